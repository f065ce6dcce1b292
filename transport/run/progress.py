"""Progress of a run: a bar on a terminal; elsewhere nothing, or occasional lines for a log."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from transport.statistics.notation import duration, percent
from transport.validation import SceneError, short_repr

if TYPE_CHECKING:
    from transport.run.stopping import Standing

LINES = "lines"
BAR_WIDTH = 16  # characters
FIRST_INTERVAL = 15.0  # [s] until the first line of a log; the interval doubles with each line
MAX_INTERVAL = 600.0  # [s] longest interval between lines
BAR_DELAY = 0.5  # [s] before the bar is shown: short work needs none


class WaitingWarning(UserWarning):
    """A run waits for the workers of its cluster."""


class Progress:
    """Receiver of a run's progress; this one shows nothing."""

    def compiling(self, done: int, of: int, name: str) -> None:
        """Report that pass `name`, number `done` of `of`, is about to be compiled or loaded."""
        text = f"compiling {name} (the first time only)"
        self._show("compile", text, done / of, f", {done} of {of} passes")

    def waiting(self, what: str) -> None:
        """Report what a cluster is still waiting for."""
        self._show("wait", what)

    def trying(self, method: str) -> None:
        """Report that a pilot of an estimator starts."""
        self._show("try", f"trying {method}")

    def running(self, particles: int, elapsed: float, end: float, worst: Standing | None) -> None:
        """Report a running simulation.

        particles: so far; elapsed, end: seconds so far and in total (inf: unknown); worst: the quantity
        furthest from its target error.
        """
        text = running_text(particles, elapsed, end, worst)
        self._show("run", text, elapsed / end if end > 0 else 1.0, _ends_at(end - elapsed))

    def _show(self, stage: str, text: str, share: float = 0.0, details: str = "") -> None:
        """Show the state of a stage and the share that is done (0: unknown); details: for lines alone."""


class PilotProgress(Progress):
    """Progress of a pilot: its compilation is shown in the run's progress, its batches are not."""

    def __init__(self, run: Progress) -> None:
        self.compiling = run.compiling


class Bar(Progress):
    """Progress as one line of rich."""

    def __init__(self, is_forced: bool = False) -> None:
        self.is_forced = is_forced
        self.begun, self.bar, self.task, self.stage = time.perf_counter(), None, None, ""

    def _show(self, stage: str, text: str, share: float = 0.0, details: str = "") -> None:
        if self.bar is None:
            if time.perf_counter() - self.begun < BAR_DELAY:
                return
            self._start()
        if stage != self.stage:
            self.bar.reset(self.task)
            self.stage = stage
        total, completed = (1.0, min(share, 1.0)) if share > 0 else (None, 0)
        self.bar.update(self.task, description=text, total=total, completed=completed)

    def _start(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, TaskProgressColumn, TextColumn
        from rich.progress import Progress as Rich

        columns = TextColumn("{task.description}"), BarColumn(BAR_WIDTH), TaskProgressColumn()
        console = Console(stderr=True, force_terminal=self.is_forced or None)
        self.bar = Rich(*columns, console=console, transient=True)
        self.bar.start()
        self.task = self.bar.add_task("", total=1.0)

    def close(self) -> None:
        """Stop the bar, if it was shown."""
        if self.bar is not None:
            self.bar.stop()


class Lines(Progress):
    """Progress as plain lines on standard error, at growing intervals, for the log of a job."""

    def __init__(self) -> None:
        self.begun = time.perf_counter()
        self.pause, self.due = FIRST_INTERVAL, self.begun + FIRST_INTERVAL

    def _show(self, stage: str, text: str, share: float = 0.0, details: str = "") -> None:
        now = time.perf_counter()
        if now < self.due:
            return
        self.pause = min(2 * self.pause, MAX_INTERVAL)
        self.due = now + self.pause
        print(f"{_clock()}: after {duration(now - self.begun)} {text}{details}", file=sys.stderr, flush=True)


def _clock(later: float = 0.0) -> str:
    return time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(time.time() + later))


def _ends_at(left: float) -> str:
    """Return when the run will end, as text; empty where that is unknown or beyond the calendar."""
    try:
        return f", until {_clock(max(0.0, left))}" if left < math.inf else ""
    except (OverflowError, ValueError, OSError):
        return ""


def running_text(particles: int, elapsed: float, end: float, worst: Standing | None) -> str:
    """Return the state of a run as text.

    For example "12 000 000 particles, about 12 s to go, meter.flux_in 0.31 % (target 0.1 %)". The parts that
    a narrow terminal may cut off come last.
    """
    parts = [f"{particles:,} particles".replace(",", " ")]
    if end < math.inf:
        parts.append(f"about {duration(max(0.0, end - elapsed))} to go")
    if worst is not None:
        reached = f"{100 * worst.relative:.2g} %" if worst.relative < math.inf else "unknown"
        parts.append(f"{worst.name} {reached} (target {percent(worst.target)})")
    return ", ".join(parts)


@contextmanager
def open_progress(wanted: bool | str | Progress | None) -> Iterator[Progress]:
    """Yield the receiver of a run's progress.

    wanted: None for a bar where standard error is a terminal, True for a bar, False for nothing, "lines" for
    lines where standard error is no terminal; a Progress for itself. Raise SceneError for any other value.
    """
    if isinstance(wanted, Progress):
        yield wanted
        return
    if wanted not in (None, True, False, LINES):
        raise SceneError(f"simulate: progress must be True, False or {LINES!r}, got {short_repr(wanted)}")
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
