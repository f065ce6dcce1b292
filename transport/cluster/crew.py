"""A crew whose members are the workers of a cluster, wherever they are."""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterator
from contextlib import suppress

from transport.cluster.groups import SECONDS, Groups, Pace
from transport.cluster.line import Line
from transport.free_memory import memory_left
from transport.results.batches import Batch
from transport.runs.crew import GLANCE, InOrder
from transport.runs.progress import WaitingWarning
from transport.runs.state import Origin

AHEAD = 1 << 28  # bytes of sums that may wait for their turn; or a quarter of the memory that is left
FEWEST = 50  # groups of a thread in the seconds of a run: what is not done when they are over is lost


class ClusterCrew(InOrder):
    """Batches done at the other end of a line."""

    started = 0  # histories of batches that are being done are not known here

    def __init__(self, line: Line, seed: int, seconds: float | None, count: int) -> None:
        """seconds: that the run may take, of which a group is to be a small part;  count: batches, among which the sample of
        a Snapshot is divided."""
        super().__init__()
        self.line, self.seed, self.count = line, seed, count
        self.group_seconds = SECONDS if seconds is None else min(SECONDS, seconds / FEWEST)
        self.most_ahead = max(AHEAD, (memory_left() or 0) // 4)
        self.pace, self.trouble = Pace(), None

    @property
    def origins(self) -> tuple[Origin, ...]:
        """Of all workers."""
        return tuple(self.line.origins)

    def work(self, sizes: Iterator[int]) -> Iterator[Batch | None]:
        """As `Crew.work`; raises CrewLost too."""
        sizes, self.done = list(sizes), []
        past = self.next + len(sizes)
        missing = self._missing(iter(sizes))
        groups = Groups(missing, self.pace, self.group_seconds, self.most_ahead, self.next)
        self.line.begin(groups, self.seed, self.count)
        try:
            yield from self._whose_turn_it_is()
            while self.next < past:
                if not self._take_in(GLANCE):
                    yield None
                self._tell_trouble()
                yield from self._whose_turn_it_is()
                self.line.turn(self.next)
        finally:
            self.line.end()
            with suppress(Exception):  # of what is wanted no more
                while self._take_in(0):
                    pass

    def _tell_trouble(self) -> None:
        """Warn where nobody is there any more, and where they are there again: the log of a job is to tell."""
        if self.line.trouble == self.trouble:
            return
        self.trouble = self.line.trouble
        what = (
            f"{self.trouble}; the run waits"
            if self.trouble
            else "the cluster is there again; the run goes on"
        )
        warnings.warn(f"{time.strftime('%Y-%m-%d %H:%M:%S')}: {what}", WaitingWarning, stacklevel=2)

    def _take_in(self, seconds: float) -> bool:
        """Keep what comes within so long; whether anything came."""
        came = self.line.receive(seconds)
        if came is None:
            return False
        batches, times = came
        self._keep(batches)
        self.done += times
        return True
