"""Output of all commands: text, tables, JSON and errors; coloured on a terminal, plain in a pipe."""

import json
import math
import os
import sys
import textwrap
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import typer
from rich import box
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from transport.run.executor import WorkersLost
from transport.statistics.estimates import Estimate
from transport.statistics.findings import CONSTANT, DOUBTFUL, SOUND
from transport.statistics.notation import estimate_text
from transport.units import UnitError
from transport.validation import SceneError

TEXT_WIDTH = 110  # characters at which labelled text wraps
NO_BREAK_SPACE = "\u00a0"  # a space at which text does not wrap
# characters; no table wraps if neither a terminal nor COLUMNS sets a width
PIPED_WIDTH = 4096
FAILED, INVALID, INTERRUPTED = 1, 2, 130  # exit statuses


def console(stderr: bool = False, least: int = 0) -> Console:
    """Return a console on standard output or error.

    It wraps at COLUMNS or at the terminal's width, and not in a pipe without COLUMNS.  `least` is its
    smallest width in characters.
    """
    stream, columns = sys.stderr if stderr else sys.stdout, os.environ.get("COLUMNS", "")
    made = Console(file=stream, markup=False, highlight=False, emoji=False)
    width = int(columns) if columns.isdigit() else made.width if stream.isatty() else PIPED_WIDTH
    made.size = max(width, least), made.height  # set both; otherwise rich uses 80 columns on a dumb terminal
    return made


def print_rich(*parts: object, style: str | None = None) -> None:
    """Print strings, or rich tables and texts, to standard output; no word or number of a table is cut."""
    for part in parts:
        if isinstance(part, str):
            part = Text(part, style=style or "")
        console(least=_min_width(part) if isinstance(part, Table) else 0).print(part)


def _min_width(table: Table) -> int:
    """Return the width of a table [characters] at which it wraps between words only."""
    wide = console(least=PIPED_WIDTH)
    for column in table.columns:
        if column.no_wrap:
            cells = (column.header, *column.cells)
            column.min_width = max(Measurement.get(wide, wide.options, cell).maximum for cell in cells)
    return Measurement.get(wide, wide.options, table).minimum


def print_labelled(label: str, text: str, style: str = "bold") -> None:
    """Print "label     text" with a styled label and the text wrapped beside it."""
    out, label = console(), f"{label:12s}"
    width = max(24, min(out.width, TEXT_WIDTH) - len(label))
    lines = textwrap.wrap(text, width, break_long_words=False, break_on_hyphens=False) or [""]
    folded = ("\n" + " " * len(label)).join(lines)
    out.print(Text.assemble((label, style), folded.replace(NO_BREAK_SPACE, " ")))


def print_json(data: object) -> None:
    """Print the data as JSON; numbers that are not finite become null."""
    typer.echo(json.dumps(as_json(data), indent=2, ensure_ascii=False))


def as_json(data: object) -> object:
    """Return the data in JSON types; numbers that are not finite become None."""
    if isinstance(data, dict):
        return {str(key): as_json(value) for key, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [as_json(value) for value in data]
    if data is None or isinstance(data, (bool, int, str)):
        return data
    try:
        number = float(data)
    except (TypeError, ValueError):
        return str(data)
    return number if math.isfinite(number) else None


def exit_status(failed: int, complete: bool) -> int:
    """Return the exit status of a verification: 1 if rows fail, 130 (with a message) if incomplete."""
    if not complete:
        print_to_stderr("interrupted: the rows are incomplete", style="bold red")
        return INTERRUPTED
    return int(failed > 0)


@contextmanager
def report_errors(debug: bool = False) -> Iterator[None]:
    """Turn exceptions into one red line on standard error and an exit status.

    Invalid input gives status 2, lost workers 1, Ctrl-C 130.  With `debug` errors pass through with their
    traceback.
    """
    try:
        yield
        return
    except (SceneError, UnitError, WorkersLost) as error:
        if debug:
            raise
        is_lost = isinstance(error, WorkersLost)
        line = str(error) if is_lost else f"error: {' '.join(str(error).split())}"
        status = FAILED if is_lost else INVALID
    except KeyboardInterrupt as interruption:
        line, status = str(interruption) or "interrupted before the first result", INTERRUPTED
    print_to_stderr(line, style="bold red")
    raise typer.Exit(status)


def print_to_stderr(line: str, style: str = "yellow") -> None:
    """Print a line to standard error."""
    console(stderr=True).print(Text(line, style=style), soft_wrap=True)


def print_pictures(paths: list[Path], note: str, quiet: bool = False) -> None:
    """Print the paths of figures unless quiet, and to standard error a note, or why there are no figures."""
    if not paths:
        print_to_stderr(f"no picture: {note}")
        return
    if not quiet:
        print_labelled("picture", ", ".join(str(path).replace(" ", NO_BREAK_SPACE) for path in paths))
    if note:
        print_to_stderr(note)


# ---- Tables and their cells.


def table_of(heads: Iterable[str], rows: Iterable[Iterable[str | Text]]) -> Table:
    """Return a table with these column heads and rows.

    A column whose head ends in > is right-aligned; one whose head ends in ~ may wrap, the others never do.
    """
    table = Table(box=box.SIMPLE_HEAD, header_style="bold", pad_edge=False, show_edge=False)
    for head in heads:
        align, is_whole = "right" if head.endswith(">") else "left", not head.endswith("~")
        table.add_column(head.rstrip(">~"), justify=align, overflow="fold", no_wrap=is_whole)
    for row in rows:
        table.add_row(*row)
    return table


def estimate_cell(estimate: Estimate) -> str:
    """Return value ± error without the unit, and the verdict if it is not sound."""
    number = "" if estimate.reason is None else ".7g"  # without an error the number of digits is unknown
    words = estimate_text(estimate.value, estimate.error, "1", estimate.exact, estimate.reason, number)
    if estimate.reason is None and estimate.verdict != SOUND:
        return f"{words}, {estimate.verdict}"
    return f"{words}, {DOUBTFUL}" if estimate.reason == CONSTANT and estimate.is_doubtful else words


def unit_cell(estimate: Estimate) -> str:
    """Return the unit; empty for a dimensionless estimate."""
    return "" if estimate.unit.is_dimensionless else str(estimate.unit)


def exact_cell(exact: float, estimate: Estimate) -> str:
    """Return the exact value with two more digits than the estimate has; a dash if unknown."""
    if math.isnan(exact):
        return "–"
    relative = estimate.error / abs(exact) if exact else math.nan
    digits = 6 if not 0 < relative < 1 else min(15, max(6, 3 - math.floor(math.log10(relative))))
    return f"{exact:.{digits}g}"


def z_cell(z: float) -> Text:
    """Return z with a sign, coloured by its magnitude."""
    if math.isnan(z):
        return Text("unknown", "yellow")
    style = "green" if abs(z) < 2.5 else "yellow" if abs(z) < 4 else "bold red"
    return Text(f"{z:+.2f}", style)


def state_cell(holds: bool) -> Text:
    """Return whether a law or case holds, as a coloured word."""
    return Text("holds", "green") if holds else Text("FAILS", "bold red")
