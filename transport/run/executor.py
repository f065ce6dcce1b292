"""Executors: compute batches of a run, in threads of this process or elsewhere, and yield them in order."""

from __future__ import annotations

import queue
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence

from transport.compile.plan import Plan
from transport.results.batches import Batch, batches_of
from transport.run.provenance import Origin
from transport.statistics.packed import MAX_UNPACKED_ROWS

POLL_SECONDS = 0.1  # [s] between updates of the progress
# [s] of work that a thread returns together: handing over costs as long as a small batch
PARCEL_SECONDS = 5e-3

Numbered = Iterator[tuple[int, int]]  # numbers and particles of batches


class WorkersLost(RuntimeError):
    """Raised when no worker is left to compute batches; batches returned before stay valid."""


class Executor(ABC):
    """Map batches of given sizes to their sums, by number, each once; cancel; describe itself.

    A subclass starts to compute batches, receives those finished in any order, and cancels the rest. A batch
    may come twice, where its first worker seemed lost; one copy is kept.

    Attributes
    ----------
    plan : Plan
        Plan of the scene.
    threads, workers : int
        Number of threads in all, and of workers of a cluster to which they belong (0 for this process).
    next : int
        Number of the next batch to yield.
    ahead : dict of int to Batch
        Finished batches that wait for earlier ones.
    done : list of (int, float)
        Particles and seconds of each finished batch of the last `map`.
    """

    workers = 0

    def __init__(self, plan: Plan, threads: int) -> None:
        self.plan, self.threads = plan, threads
        self.next = 0
        self.ahead: dict[int, Batch] = {}
        self.done: list[tuple[int, float]] = []

    def map(self, sizes: Sequence[int], count: int) -> Iterator[Batch | None]:
        """Yield the batches of these sizes in order; yield None every POLL_SECONDS when there is none.

        count: batches of the run, among which the sample of a Snapshot is divided. Close the generator to
        cancel: batches finished out of order then stay in `ahead`, and are not repeated. Raise the exception
        of a batch, or WorkersLost.
        """
        past, self.done = self.next + len(sizes), []
        try:
            self._start(self._missing(sizes), count)
            yield from self._next_in_order()
            while self.next < past:
                if not self._receive(POLL_SECONDS):
                    yield None
                yield from self._next_in_order()
        finally:
            self._cancel()

    @property
    def origins(self) -> tuple[Origin, ...]:
        """Return the provenance of the batches, where it is not that of this process."""
        return ()

    @property
    def warnings(self) -> list[str]:
        """Return findings about the executor, as sentences."""
        return []

    @property
    def started(self) -> int:
        """Return the approximate number of particles started in unfinished batches, as far as is known."""
        return 0

    @abstractmethod
    def _start(self, batches: Numbered, count: int) -> None:
        """Start to compute these batches."""

    @abstractmethod
    def _receive(self, seconds: float) -> bool:
        """Store batches that arrive within so many seconds; return whether any did."""

    @abstractmethod
    def _cancel(self) -> None:
        """Cancel unfinished batches, and store the finished ones."""

    def _missing(self, sizes: Sequence[int]) -> Numbered:
        """Return numbers and sizes of the unfinished batches."""
        known = frozenset(self.ahead)
        return ((number, size) for number, size in enumerate(sizes, self.next) if number not in known)

    def _store(self, parcel: dict[int, Batch]) -> None:
        """Store finished batches."""
        self.ahead |= {number: batch for number, batch in parcel.items() if number >= self.next}

    def _next_in_order(self) -> Iterator[Batch]:
        """Yield the finished batches whose predecessors have all been yielded."""
        while self.next in self.ahead:
            self.next += 1
            yield self.ahead.pop(self.next - 1)


class ThreadExecutor(Executor):
    """Compute batches in threads of this process, each with its own bundle."""

    def __init__(self, compiled, seed: int, threads: int) -> None:
        from transport.engine.bundle import empty_bundle

        super().__init__(compiled.program.plan, threads)
        self.compiled, self.seed = compiled, seed
        self.bundles = [empty_bundle() for _ in range(threads)]
        # Parcels of batches, or exceptions. Not a SimpleQueue: where the handler of Ctrl-C outlasts the
        # timeout, its `get` waits without end (CPython 3.11).
        self.finished: queue.Queue = queue.Queue()
        self.running: list[threading.Thread] = []

    @property
    def started(self) -> int:
        """Return the approximate number of particles started in unfinished batches."""
        return sum(int(bundle["started"][0]) for bundle in self.bundles)

    def _start(self, batches: Numbered, count: int) -> None:
        self.tasks, self.lock, self.is_over, self.count = batches, threading.Lock(), False, count
        self.running = [
            threading.Thread(target=self._work, args=(bundle,), daemon=True) for bundle in self.bundles
        ]
        for thread in self.running:
            thread.start()

    def _receive(self, seconds: float) -> bool:
        try:
            arrived = self.finished.get(timeout=seconds)
        except queue.Empty:
            return False
        if isinstance(arrived, Exception):
            raise arrived
        self._store(arrived)
        return True

    def _cancel(self) -> None:
        # Ask all threads to stop, within a batch.
        self.is_over = True
        for bundle in self.bundles:
            bundle["stop"] = 1
        for thread in self.running:
            if thread.ident is not None:  # it was started
                thread.join()
        while not self.finished.empty():
            arrived = self.finished.get()
            if not isinstance(arrived, Exception):
                self._store(arrived)

    def _work(self, bundle) -> None:
        """Run one thread: compute batches in its bundle, and return them in parcels of PARCEL_SECONDS."""
        from transport.engine.driver import Stopped, run_batch

        bundle["stop"], bundle["started"] = 0, 0
        # Long sums are converted at once: their memory would add up.
        patience = PARCEL_SECONDS if self.plan.rows <= MAX_UNPACKED_ROWS else 0.0
        parcel: dict[int, object] = {}
        handed = begun = time.perf_counter()
        try:
            # Compute batches until none is left, and hand them over in parcels.
            while not self.is_over:
                with self.lock:
                    number, size = next(self.tasks, (None, 0))
                if number is None:
                    break
                parcel[number] = run_batch(self.compiled, self.seed, number, size, bundle, self.count)
                bundle["started"], now = 0, time.perf_counter()
                self.done.append((size, now - begun))
                begun = now
                if now - handed > patience:
                    self._hand_over(parcel)
                    parcel, handed = {}, now
        except Stopped:
            pass
        except Exception as error:  # raised again in the caller's thread
            self.finished.put(error)
        self._hand_over(parcel)

    def _hand_over(self, parcel: dict[int, object]) -> None:
        """Convert the sums of batches, and hand them over to the caller's thread."""
        if not parcel:
            return
        try:
            self.finished.put(batches_of(self.plan, parcel))
        except Exception as error:  # raised again there
            self.finished.put(error)
