"""Output of the command line: colour on a terminal, plain text in a pipe, JSON, and errors in red."""

import json
import math
import os
import sys
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager

import typer
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from transport.run.executor import WorkersLost
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
