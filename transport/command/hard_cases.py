"""`transport verify --hard`: one table per family of hard cases, compared with the naive formula."""

import math
import signal
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import groupby

from rich.table import Table
from rich.text import Text

from transport.command.console import say, say_json, status_of
from transport.command.tables import estimate_cell, plain_table, z_cell
from transport.hard.cases import FALSE_ALARM, Case, Seen, cases_of, family_title
from transport.results.estimates import Estimate

NOTE = """off: in standard errors if signed, else a relative difference, with its tolerance beyond rounding;
–: the naive formula gives no number, because its particle is lost or its loop never ends; a case in other
units or at another place uses the random numbers of the plain case; --json explains why each case is hard"""


@dataclass(frozen=True)
class Judged:
    """A case with its outcome, judged at the false-alarm rate `rate`."""

    case: Case
    seen: Seen
    rate: float

    @property
    def holds(self) -> bool:
        return self.seen.holds(self.rate)

    @property
    def record(self) -> dict[str, object]:
        """All values as one dictionary for JSON."""
        case, seen = self.case, self.seen
        error = seen.found.error if isinstance(seen.found, Estimate) else 0.0
        return {
            "family": case.family,
            "case": case.title,
            "reason": case.reason,
            "value": seen.value,
            "error": error,
            "exact": seen.exact,
            "off": seen.off,
            "naive": case.naive,
            "naive_value": seen.naive,
            "holds": self.holds,
        }


def verify_hard(families: list[str] | None, json: bool) -> int:
    """Run and print the cases of these families, or of all.

    Returns status 1 if one fails, 130 if interrupted.
    """
    cases, found = list(cases_of(families)), []
    for family, rows in groupby(judged(cases), key=lambda row: row.case.family):
        found += (of_family := list(rows))
        if not json:
            say(Text(family_title(family), "bold"), hard_table(of_family), "")
    if not found:
        raise KeyboardInterrupt
    failed = sum(not row.holds for row in found)
    if json:
        say_json([row.record for row in found])
    else:
        style = "bold red" if failed else "bold green"
        say(f"{len(found) - failed} of {len(found)} hard cases hold", style=style)
        say(NOTE)
    return status_of(failed, complete=len(found) == len(cases))


def judged(cases: list[Case], others: int = 0) -> Iterator[Judged]:
    """Run the cases until Ctrl-C and yield each outcome; `others` more rows share the false-alarm rate."""
    with suppress(KeyboardInterrupt):
        for case in cases:
            yield Judged(case, _seen(case), FALSE_ALARM / (len(cases) + others))


def _seen(case: Case) -> Seen:
    """Run a case.  Raises KeyboardInterrupt after Ctrl-C, even if a run inside the case handled it."""
    came, usual = [], signal.getsignal(signal.SIGINT)
    if usual is signal.SIG_IGN:  # as under nohup
        return case.see()

    def note(*_: object) -> None:
        came.append(True)
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, note)
    try:
        seen = case.see()
    finally:
        signal.signal(signal.SIGINT, usual)
    if came:
        raise KeyboardInterrupt
    return seen


def hard_table(rows: list[Judged]) -> Table:
    """Return a table of found, exact and naive values."""
    table = plain_table("case", "found>", "exact>", "off>", "naive formula", "gives>", "")
    for row in rows:
        table.add_row(*_cells(row))
    return table


def _cells(row: Judged) -> tuple[str | Text, ...]:
    seen = row.seen
    state = Text("holds", "green") if row.holds else Text("FAILS", "bold red")
    found = estimate_cell(seen.found) if seen.is_noisy else f"{seen.value:.7g}"
    off = z_cell(seen.off) if seen.is_noisy else Text(_rounding(seen))
    return (row.case.title, found, f"{seen.exact:.7g}", off, row.case.naive, _naive(seen), state)


def _rounding(seen: Seen) -> str:
    """Return the relative difference of a number without error, and its tolerance beyond rounding."""
    allowed = f" < {seen.within:.2g}" if seen.within > 1e-6 else ""
    return f"{seen.off:.1e}{allowed}" if seen.off else "0"


def _naive(seen: Seen) -> str:
    if seen.naive is None:
        return "–"
    if math.isnan(seen.naive):
        return "NaN"
    short = f"{seen.naive:.4g}"
    return short if float(short) != float(f"{seen.exact:.4g}") else f"{seen.naive:.9g}"
