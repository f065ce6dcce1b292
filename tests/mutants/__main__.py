"""Plant each fault, run the tests that are to see it, and print which did.

python -m tests.mutants [NAME ...] [--workers 1] [--out FILE] [--trust]: NAME is part of a fault's file or of its words; without one
all are planted.  Before that, the tests of all of them must pass without any fault (left out by --trust).  Status 1 where a
fault survives.
"""

from __future__ import annotations

import argparse
import queue
import sys
import tempfile
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from rich.console import Console
from rich.table import Table

from tests.mutants.fault import Fault
from tests.mutants.faults import FAULTS
from tests.mutants.planting import Copy, Outcome


def main() -> int:
    """Status 0 where each fault is caught."""
    asked, console = _asked(), Console()
    faults = chosen(FAULTS, asked.names)
    if not faults:
        console.print(f"no fault is called {' or '.join(asked.names)}")
        return 2
    outcomes = []
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        copies = [Copy(Path(folder) / str(number)) for number in range(min(asked.workers, len(faults)))]
        if not asked.trust and (failed := _failing_soundly(copies[0], faults)):
            console.print(f"without any fault {failed} fails already: nothing can be told")
            return 2
        for outcome in outcomes_of(copies, faults):
            outcomes.append(outcome)
            told = f"{outcome.fault.what}: {_verdict(outcome)}, {outcome.seconds:.0f} s"
            console.print(f"{len(outcomes)}/{len(faults)} {told}", highlight=False, soft_wrap=True)
    console.print(table(outcomes))
    if asked.out is not None:
        asked.out.write_text(markdown(outcomes), encoding="utf-8")
    survivors = [outcome for outcome in outcomes if outcome.caught_by is None]
    console.print(f"{len(outcomes) - len(survivors)} of {len(outcomes)} faults are caught")
    return 1 if survivors else 0


def chosen(faults: Iterable[Fault], names: Iterable[str]) -> list[Fault]:
    """The faults of which the file or the words hold one of these names; all of them without a name."""
    names = [name.lower() for name in names]
    return [
        fault
        for fault in faults
        if not names or any(n in f"{fault.path} {fault.what}".lower() for n in names)
    ]


def outcomes_of(copies: list[Copy], faults: list[Fault]) -> Iterator[Outcome]:
    """The outcome of each fault, in their order, each in the next copy that is free."""
    free: queue.Queue[Copy] = queue.Queue()
    for copy in copies:
        free.put(copy)

    def outcome_of(fault: Fault) -> Outcome:
        copy = free.get()
        try:
            return copy.with_fault(fault)
        finally:
            free.put(copy)

    with ThreadPoolExecutor(len(copies)) as pool:
        yield from pool.map(outcome_of, faults)


def table(outcomes: Iterable[Outcome]) -> Table:
    """One row a fault."""
    rows = Table("fault", "file", "caught by", "s", title="Faults planted")
    for outcome in outcomes:
        rows.add_row(outcome.fault.what, outcome.fault.file, _verdict(outcome), f"{outcome.seconds:.1f}")
    return rows


def markdown(outcomes: Iterable[Outcome]) -> str:
    """The same as a table in Markdown."""
    rows = [("fault", "file", "caught by", "s"), ("---",) * 3 + ("--:",)]
    for outcome in outcomes:
        caught = _verdict(outcome).replace("|", "\\|")
        rows.append((outcome.fault.what, f"`{outcome.fault.file}`", caught, f"{outcome.seconds:.0f}"))
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def _failing_soundly(copy: Copy, faults: Iterable[Fault]) -> str | None:
    """The first of all these faults' tests that fails without any fault."""
    return copy.failed(sorted({node for fault in faults for node in fault.nodes}))


def _verdict(outcome: Outcome) -> str:
    return outcome.caught_by or "SURVIVED"


def _asked() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--out", type=Path, metavar="FILE", help="write the table there, in Markdown")
    parser.add_argument("--trust", action="store_true", help="do not run the tests without a fault first")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
