"""Plant each fault, run the tests that are to see it, and list in Markdown which did.

python -m tests.mutants [NAME ...] [--workers 1] [--out FILE] [--trust]: NAME is part of a fault's file or of its words; without one
all are planted.  Tests run as in the default suite: those marked slow are left out.  --out writes the list to a file as it grows;
what the file lists as caught already is not planted again, so that a run that was stopped goes on.  First, the tests of all faults
must pass without any fault (left out by --trust).  Status 1 where a fault survives.
"""

from __future__ import annotations

import argparse
import queue
import re
import sys
import tempfile
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tests.mutants.fault import Fault
from tests.mutants.faults import FAULTS
from tests.mutants.planting import Copy, Outcome

SURVIVED = "SURVIVED"
ENTRY = re.compile(r"^- (?P<what>.*) \(`(?P<file>.*)`\): (?P<caught>.*), \d+ s$")


def main() -> int:
    """Status 0 where each fault is caught."""
    asked = _asked()
    faults = chosen(FAULTS, asked.names)
    if not faults:
        print(f"no fault is called {' or '.join(asked.names)}")
        return 2
    caught = caught_before(asked.out, FAULTS)
    left = [fault for fault in faults if fault.what not in caught]
    if asked.out is not None:
        asked.out.write_text("".join(f"{entry}\n" for entry in caught.values()), encoding="utf-8")
    survivors = []
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        copies = [Copy(Path(folder) / str(number)) for number in range(min(asked.workers, len(left)))]
        if left and not asked.trust and (failed := _failing_soundly(copies[0], left)):
            print(f"without any fault {failed} fails already")
            return 2
        for outcome in outcomes_of(copies, left):
            survivors += [outcome.fault] if outcome.caught_by is None else []
            print(entry_of(outcome), flush=True)
            if asked.out is not None:
                with asked.out.open("a", encoding="utf-8") as file:
                    print(entry_of(outcome), file=file)
    print(f"{len(faults) - len(survivors)} of {len(faults)} faults are caught")
    return 1 if survivors else 0


def chosen(faults: Iterable[Fault], names: Iterable[str]) -> list[Fault]:
    """The faults of which the file or the words hold one of these names; all of them without a name."""
    names = [name.lower() for name in names]
    return [
        fault
        for fault in faults
        if not names or any(n in f"{fault.path} {fault.what}".lower() for n in names)
    ]


def caught_before(out: Path | None, faults: Iterable[Fault]) -> dict[str, str]:
    """Entries of an earlier list by the words of their faults: of faults that are still there and were caught."""
    if out is None or not out.is_file():
        return {}
    entries = filter(None, map(ENTRY.match, out.read_text(encoding="utf-8").splitlines()))
    files = {fault.what: fault.file for fault in faults}
    return {
        entry["what"]: entry[0]
        for entry in entries
        if files.get(entry["what"]) == entry["file"] and entry["caught"] != SURVIVED
    }


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

    with ThreadPoolExecutor(max(1, len(copies))) as pool:
        yield from pool.map(outcome_of, faults)


def entry_of(outcome: Outcome) -> str:
    """One line of the list."""
    caught = f"`{outcome.caught_by}`" if outcome.caught_by else SURVIVED
    return f"- {outcome.fault.what} (`{outcome.fault.file}`): {caught}, {outcome.seconds:.0f} s"


def _failing_soundly(copy: Copy, faults: Iterable[Fault]) -> str | None:
    """The first of all these faults' tests that fails without any fault."""
    return copy.failed(sorted({node for fault in faults for node in fault.nodes}), patience=None)


def _asked() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--out", type=Path, metavar="FILE", help="file of the list; continue it if it exists")
    parser.add_argument("--trust", action="store_true", help="do not run the tests without a fault first")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
