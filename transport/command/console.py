"""Where the command line writes: colours on a terminal, plain text in a pipe, JSON for machines, refusals in red."""

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

from transport.runs.crew import CrewLost
from transport.units import UnitError
from transport.validation import SceneError

TEXT_WIDTH = 110  # characters, at which a labelled text is folded
UNBROKEN = "\u00a0"  # a space at which it is not
# characters: so wide that no table is folded where neither a terminal nor COLUMNS sets a width
PIPED_WIDTH = 4096
FAILED, REFUSED, INTERRUPTED = 1, 2, 130  # exit statuses


def console(stderr: bool = False, least: int = 0) -> Console:
    """A console on standard output (or error) that folds to a terminal's width or to COLUMNS, and not in a pipe without.

    least: characters that it has at the least.
    """
    stream, told = sys.stderr if stderr else sys.stdout, os.environ.get("COLUMNS", "")
    made = Console(file=stream, markup=False, highlight=False, emoji=False)
    width = int(told) if told.isdigit() else made.width if stream.isatty() else PIPED_WIDTH
    made.size = max(width, least), made.height  # both: where one is left out, a dumb terminal has 80 columns
    return made


def say(*parts: object, style: str | None = None) -> None:
    """Print a line, or tables and texts of rich, to standard output; tables as wide as their words and numbers need."""
    for part in parts:
        if isinstance(part, str):
            part = Text(part, style=style or "")
        console(least=_least_width(part) if isinstance(part, Table) else 0).print(part)


def _least_width(table: Table) -> int:
    """Characters that a table takes where it folds between words alone: what it holds is worth more than a margin."""
    wide = console(least=PIPED_WIDTH)
    for column in table.columns:
        if column.no_wrap:
            cells = (column.header, *column.cells)
            column.min_width = max(Measurement.get(wide, wide.options, cell).maximum for cell in cells)
    return Measurement.get(wide, wide.options, table).minimum


def say_labelled(label: str, text: str, style: str = "bold") -> None:
    """Print "label     text" with the label in colour, and the text folded beside it."""
    out, label = console(), f"{label:12s}"
    width = max(24, min(out.width, TEXT_WIDTH) - len(label))
    lines = textwrap.wrap(text, width, break_long_words=False, break_on_hyphens=False) or [""]
    folded = ("\n" + " " * len(label)).join(lines)
    out.print(Text.assemble((label, style), folded.replace(UNBROKEN, " ")))


def say_json(data: object) -> None:
    """Print the data as JSON in which what is no finite number is null."""
    typer.echo(json.dumps(as_json(data), indent=2, ensure_ascii=False))


def as_json(data: object) -> object:
    """The data in JSON's own types; numbers that are not finite become None."""
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


def status_of(failed: int, complete: bool) -> int:
    """The exit status of a verification: 1 where some rows fail; says on standard error where rows are missing."""
    if not complete:
        console(stderr=True).print("interrupted: the rows are incomplete", style="bold red")
        return INTERRUPTED
    return int(failed > 0)


@contextmanager
def refusals(debug: bool = False) -> Iterator[None]:
    """Turn refused input into one red line on standard error and status 2, lost workers into status 1, an interruption into 130.

    debug: let it through, with its traceback.
    """
    try:
        yield
    except (SceneError, UnitError) as refusal:
        if debug:
            raise
        line = " ".join(str(refusal).split())
        console(stderr=True).print(Text(f"refused: {line}", style="bold red"), soft_wrap=True)
        raise typer.Exit(REFUSED) from None
    except CrewLost as lost:
        if debug:
            raise
        console(stderr=True).print(Text(str(lost), style="bold red"), soft_wrap=True)
        raise typer.Exit(FAILED) from None
    except KeyboardInterrupt as interruption:
        line = str(interruption) or "interrupted before anything was known"
        console(stderr=True).print(Text(line, style="bold red"), soft_wrap=True)
        raise typer.Exit(INTERRUPTED) from None
