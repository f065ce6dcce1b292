"""A progress bar with the time left, where there is a terminal; elsewhere silence, or a line now and then for a log."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from transport.results.notation import duration, percent
from transport.validation import SceneError, shown

if TYPE_CHECKING:
    from transport.runs.stopping import Standing

LINES = "lines"
BAR = 16  # characters
FIRST_LINE = 15.0  # [s] until the first line of a log; twice as long to each next
LONGEST = 600.0  # [s] between two of them at most
PATIENCE = 0.5  # [s] before the first bar is shown: short work needs none


class WaitingWarning(UserWarning):
    """A run waits for the workers of its cluster."""


class Progress:
    """Says nothing; what a run tells its progress to."""

    def compiling(self, done: int, of: int, name: str) -> None:
        """Before the pass `name` is compiled or loaded."""

    def waiting(self, what: str) -> None:
        """While a cluster is not ready yet: what for."""

    def trying(self, way: str) -> None:
        """Before a pilot of a way to estimate."""

    def running(self, particles: int, elapsed: float, end: float, worst: Standing | None) -> None:
        """While batches run: particles so far, seconds since the run began and in all (inf: not known), and the quantity
        that is furthest from the error asked for."""


class PilotProgress(Progress):
    """Of a pilot: what it compiles is shown where the run shows it, its batches are not."""

    def __init__(self, run: Progress) -> None:
        self.compiling = run.compiling


class Bar(Progress):
    """One line of rich that shows what is going on."""

    def __init__(self, is_forced: bool = False) -> None:
        self.is_forced = is_forced
        self.begun, self.bar, self.task, self.stage = time.perf_counter(), None, None, ""

    def compiling(self, done: int, of: int, name: str) -> None:
        self._show("compile", f"compiling {name} (the first time only)", done / of)

    def waiting(self, what: str) -> None:
        self._show("wait", what, 0.0)

    def trying(self, way: str) -> None:
        self._show("try", f"trying {way}", 0.0)

    def running(self, particles: int, elapsed: float, end: float, worst: Standing | None) -> None:
        self._show("run", running_text(particles, elapsed, end, worst), elapsed / end if end > 0 else 1.0)

    def _show(self, stage: str, text: str, share: float) -> None:
        if self.bar is None:
            if time.perf_counter() - self.begun < PATIENCE:
                return
            self._start()
        if stage != self.stage:
            self.bar.reset(self.task)
            self.stage = stage
        known = share > 0
        self.bar.update(
            self.task,
            description=text,
            total=1.0 if known else None,
            completed=min(share, 1.0) if known else 0,
        )

    def _start(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, TaskProgressColumn, TextColumn
        from rich.progress import Progress as Rich

        columns = TextColumn("{task.description}"), BarColumn(BAR), TaskProgressColumn()
        console = Console(stderr=True, force_terminal=self.is_forced or None)
        self.bar = Rich(*columns, console=console, transient=True)
        self.bar.start()
        self.task = self.bar.add_task("", total=1.0)

    def close(self) -> None:
        if self.bar is not None:
            self.bar.stop()


class Lines(Progress):
    """A plain line on standard error now and then, ever more rarely: what the log of a job is to tell."""

    def __init__(self) -> None:
        self.begun = time.perf_counter()
        self.pause, self.due = FIRST_LINE, self.begun + FIRST_LINE

    def compiling(self, done: int, of: int, name: str) -> None:
        self._tell(f"compiling {name} (the first time only), {done} of {of} passes")

    def waiting(self, what: str) -> None:
        self._tell(what)

    def trying(self, way: str) -> None:
        self._tell(f"trying {way}")

    def running(self, particles: int, elapsed: float, end: float, worst: Standing | None) -> None:
        self._tell(f"{running_text(particles, elapsed, end, worst)}{_ends_at(end - elapsed)}")

    def _tell(self, text: str) -> None:
        now = time.perf_counter()
        if now < self.due:
            return
        self.pause = min(2 * self.pause, LONGEST)
        self.due = now + self.pause
        print(f"{_clock()}: after {duration(now - self.begun)} {text}", file=sys.stderr, flush=True)


def _clock(later: float = 0.0) -> str:
    return time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(time.time() + later))


def _ends_at(left: float) -> str:
    """When the run will be over; nothing where that is not known, or beyond what a calendar has."""
    try:
        return f", until {_clock(max(0.0, left))}" if left < math.inf else ""
    except (OverflowError, ValueError, OSError):
        return ""


def running_text(particles: int, elapsed: float, end: float, worst: Standing | None) -> str:
    """What is going on: "12 000 000 particles, about 12 s to go, meter.flux_in 0.31 % of 0.1 % asked".

    What a narrow terminal cuts off comes last.
    """
    parts = [f"{particles:,} particles".replace(",", " ")]
    if end < math.inf:
        parts.append(f"about {duration(max(0.0, end - elapsed))} to go")
    if worst is not None:
        reached = f"{100 * worst.relative:.2g} %" if worst.relative < math.inf else "unknown"
        parts.append(f"{worst.name} {reached} of {percent(worst.target)} asked")
    return ", ".join(parts)


@contextmanager
def progress_on(wanted: bool | str | Progress | None) -> Iterator[Progress]:
    """The bar, lines, or silence.  wanted: None for a bar where standard error is a terminal, "lines" for lines where it is none;
    a Progress for that one.

    Raises SceneError for what is none of these.
    """
    if isinstance(wanted, Progress):
        yield wanted
        return
    if wanted not in (None, True, False, LINES):
        raise SceneError(
            f"simulate: progress must be True, False or {LINES!r}, got {shown(wanted)}; leave it out"
        )
    is_terminal = sys.stderr.isatty()
    if wanted is False or not (wanted or is_terminal):
        yield Progress()
        return
    if wanted == LINES and not is_terminal:
        yield Lines()
        return
    bar = Bar(is_forced=wanted is True)
    try:
        yield bar
    finally:
        bar.close()
