"""Executor whose batches are computed by the workers of a Dask cluster."""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterator
from contextlib import suppress

from transport.results.batches import Batch
from transport.run.dask.client import GROUP_SECONDS, BatchPace, DaskExecutor, Groups
from transport.run.progress import WaitingWarning
from transport.run.provenance import Origin
from transport.run.threads import POLL_SECONDS, OrderedResults
from transport.statistics.chunked import available_memory

MAX_AHEAD_BYTES = 1 << 28  # bytes of sums that may wait for their turn; or a quarter of the available memory
MIN_GROUPS = 50  # groups per thread in a run limited by seconds: an unfinished group is lost when time is up


class ClusterExecutor(OrderedResults):
    """Compute batches on the workers of a cluster, and yield them in order."""

    started = 0  # the particles of unfinished batches are not known here

    def __init__(self, line: DaskExecutor, seed: int, seconds: float | None, count: int) -> None:
        """Arguments of the executor.

        seconds: limit of the run, of which a group takes a small part; count: number of batches of the run. A
        Snapshot's sample is divided among that many batches.
        """
        super().__init__()
        self.line, self.seed, self.count = line, seed, count
        self.group_seconds = GROUP_SECONDS if seconds is None else min(GROUP_SECONDS, seconds / MIN_GROUPS)
        self.max_ahead_bytes = max(MAX_AHEAD_BYTES, (available_memory() or 0) // 4)
        self.pace, self.problem = BatchPace(), None

    @property
    def origins(self) -> tuple[Origin, ...]:
        """Return the provenance of all workers."""
        return tuple(self.line.origins)

    def work(self, sizes: Iterator[int]) -> Iterator[Batch | None]:
        """Yield batches as `Crew.work` does; raise WorkersLost too."""
        sizes, self.done = list(sizes), []
        past = self.next + len(sizes)
        missing = self._missing(iter(sizes))
        groups = Groups(missing, self.pace, self.group_seconds, self.max_ahead_bytes, self.next)
        self.line.begin(groups, self.seed, self.count)
        try:
            yield from self._next_in_order()
            while self.next < past:
                if not self._receive(POLL_SECONDS):
                    yield None
                self._warn_problem()
                yield from self._next_in_order()
                self.line.turn(self.next)
        finally:
            self.line.end()
            with suppress(Exception):  # drain results that are no longer needed
                while self._receive(0):
                    pass

    def _warn_problem(self) -> None:
        """Warn where the workers are lost, and where they are back, for the log of a job."""
        if self.line.problem == self.problem:
            return
        self.problem = self.line.problem
        what = f"{self.problem}; the run waits" if self.problem else "the cluster is back; the run continues"
        warnings.warn(f"{time.strftime('%Y-%m-%d %H:%M:%S')}: {what}", WaitingWarning, stacklevel=2)

    def _receive(self, seconds: float) -> bool:
        """Store results that arrive within so many seconds; return whether any did."""
        came = self.line.receive(seconds)
        if came is None:
            return False
        batches, times = came
        self._store(batches)
        self.done += times
        return True
