"""`transport verify --hard`: the hard cases, a table a family, with what the naive formula gives instead."""

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

NOTE = """off: in standard errors where it has a sign, else relative, with what is allowed where that is more than rounding;
–: the naive way has no number, as it is lost or never ends; cases in other units or places share their random numbers
with the plain one; --json tells why each is hard"""


@dataclass(frozen=True)
class Judged:
    """A case, what it came to, and whether that is right; rate: of false alarms that it was judged at."""

    case: Case
    seen: Seen
    rate: float

    @property
    def holds(self) -> bool:
        return self.seen.holds(self.rate)

    @property
    def record(self) -> dict[str, object]:
        """For machines."""
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
    """Run and print the cases of these families, or of all; the status: 1 if one fails, 130 if it was interrupted."""
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
    """Each case as it is done, until Ctrl-C.  others: rows that share the rate of false alarms with them."""
    with suppress(KeyboardInterrupt):
        for case in cases:
            yield Judged(case, _seen(case), FALSE_ALARM / (len(cases) + others))


def _seen(case: Case) -> Seen:
    """What the case comes to.  Raises KeyboardInterrupt after Ctrl-C, also where it has only cut short a run within."""
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
    """What was found, what is exact, and what the naive way gives."""
    table = plain_table("case", "found>", "exact>", "off>", "naive way", "gives>", "")
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
    """How far off a number is that has no error, and what is allowed where rounding alone would not do it."""
    allowed = f" < {seen.within:.2g}" if seen.within > 1e-6 else ""
    return f"{seen.off:.1e}{allowed}" if seen.off else "0"


def _naive(seen: Seen) -> str:
    if seen.naive is None:
        return "–"
    if math.isnan(seen.naive):
        return "NaN"
    short = f"{seen.naive:.4g}"
    return short if float(short) != float(f"{seen.exact:.4g}") else f"{seen.naive:.9g}"
