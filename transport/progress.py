"""A progress bar with the time left, where there is a terminal; silence where output is piped."""

import math
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

PATIENCE = 0.5  # [s] before the first bar is shown: short work needs none


class Progress:
    """Says nothing; what a run tells its progress to."""

    def compiling(self, done: int, of: int, name: str) -> None:
        """Before the pass `name` is compiled or loaded."""

    def running(self, particles: int, share: float) -> None:
        """While batches run: particles so far, and the share of the run that is done (nan: not known)."""


class Bar(Progress):
    """One line of rich that shows what is going on."""

    def __init__(self, is_forced: bool = False) -> None:
        self.is_forced = is_forced
        self.begun, self.bar, self.task, self.stage = time.perf_counter(), None, None, ""

    def compiling(self, done: int, of: int, name: str) -> None:
        self._show("compile", f"compiling {name} (the first time only)", done / of)

    def running(self, particles: int, share: float) -> None:
        self._show("run", f"{particles:,} particles".replace(",", " "), share)

    def _show(self, stage: str, text: str, share: float) -> None:
        if self.bar is None:
            if time.perf_counter() - self.begun < PATIENCE:
                return
            self._start()
        if stage != self.stage:
            self.bar.reset(self.task)
            self.stage = stage
        known = not math.isnan(share)
        self.bar.update(
            self.task,
            description=text,
            total=1.0 if known else None,
            completed=min(share, 1.0) if known else 0,
        )

    def _start(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn
        from rich.progress import Progress as Rich

        columns = TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn()
        console = Console(stderr=True, force_terminal=self.is_forced or None)
        self.bar = Rich(*columns, console=console, transient=True)
        self.bar.start()
        self.task = self.bar.add_task("", total=1.0)

    def close(self) -> None:
        if self.bar is not None:
            self.bar.stop()


@contextmanager
def progress_on(wanted: bool | None) -> Iterator[Progress]:
    """The bar, or silence.  wanted: None for a bar where standard error is a terminal."""
    if not (sys.stderr.isatty() if wanted is None else wanted):
        yield Progress()
        return
    bar = Bar(is_forced=bool(wanted))
    try:
        yield bar
    finally:
        bar.close()
