"""Thread executor: computes batches in threads, and yields them in the order of their numbers."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Iterator

from transport.results.batches import Batch, batch_of
from transport.run.provenance import Origin

POLL_SECONDS = 0.1  # [s] between updates of the progress
# [s] of work that a thread returns together: handing over costs as long as a small batch
PARCEL_SECONDS = 5e-3


class WorkersLost(RuntimeError):
    """Raised when no worker is left to compute batches; batches returned before stay valid."""


class OrderedResults:
    """Reorder batches: they arrive as they finish, and are yielded by number, each once.

    done: particles and seconds per finished batch of the present leg; origins: provenance of the batches,
    where not this process; threads: number of threads of this process.
    """

    threads = 0
    origins: tuple[Origin, ...] = ()

    def __init__(self) -> None:
        self.next = 0  # number of the next batch to yield
        self.ahead: dict[int, Batch] = {}  # finished batches that wait for earlier ones
        self.done: list[tuple[int, float]] = []

    def _missing(self, sizes: Iterator[int]) -> Iterator[tuple[int, int]]:
        """Return numbers and sizes of the unfinished batches."""
        known = frozenset(self.ahead)
        return ((number, size) for number, size in enumerate(sizes, self.next) if number not in known)

    def _store(self, parcel: dict[int, Batch]) -> None:
        """Store finished batches.

        A batch may come twice, where its first worker seemed lost; one copy is kept.
        """
        self.ahead |= {number: batch for number, batch in parcel.items() if number >= self.next}

    def _next_in_order(self) -> Iterator[Batch]:
        """Yield the finished batches whose predecessors have all been yielded."""
        while self.next in self.ahead:
            self.next += 1
            yield self.ahead.pop(self.next - 1)


class ThreadExecutor(OrderedResults):
    """Compute batches in threads of this process, each with its own bundle."""

    def __init__(self, compiled: object, seed: int, threads: int, count: int) -> None:
        """count: number of batches, among which the sample of a Snapshot is divided."""
        from transport.engine.bundle import empty_bundle

        super().__init__()
        self.compiled, self.seed, self.count, self.threads = compiled, seed, count, threads
        self.bundles = [empty_bundle() for _ in range(threads)]

    @property
    def started(self) -> int:
        """Return the approximate number of particles started in unfinished batches."""
        return sum(int(bundle["started"][0]) for bundle in self.bundles)

    def work(self, sizes: Iterator[int]) -> Iterator[Batch | None]:
        """Yield the batches of these sizes in order; yield None every POLL_SECONDS when there is none.

        Close the generator to stop early: batches finished out of order then stay in `ahead`, and are not
        repeated. Raise the exception of a batch.
        """
        self.tasks, self.lock, self.is_over, self.done = self._missing(sizes), threading.Lock(), False, []
        self.finished = queue.SimpleQueue()
        workers = [
            threading.Thread(target=self._work, args=(bundle,), daemon=True) for bundle in self.bundles
        ]
        try:
            for worker in workers:
                worker.start()
            yield from self._in_order()
        finally:
            self._stop()
            for worker in workers:
                if worker.ident is not None:
                    worker.join()
            while not self.finished.empty():
                self._store(self.finished.get()[0])

    def _in_order(self) -> Iterator[Batch | None]:
        """Yield batches in order as threads return them, until the last thread ends; None at each timeout."""
        working = len(self.bundles)
        yield from self._next_in_order()
        while working:
            try:
                parcel, error = self.finished.get(timeout=POLL_SECONDS)
            except queue.Empty:
                yield None
                continue
            if error is not None:
                raise error
            working -= not parcel
            self._store(parcel)
            yield from self._next_in_order()

    def _work(self, bundle) -> None:
        """Run one thread: compute batches in its bundle, and return them in parcels of PARCEL_SECONDS."""
        from transport.engine.driver import Stopped, run_batch

        bundle["stop"], bundle["started"] = 0, 0
        parcel, handed = {}, time.perf_counter()
        try:
            # Compute batches until none is left, and hand them over in parcels.
            while not self.is_over:
                with self.lock:
                    number, size = next(self.tasks, (None, 0))
                if number is None:
                    break
                begun = time.perf_counter()
                # Keep no reference to the raw sums: they would double the memory of the next batch.
                parcel[number] = batch_of(
                    self.compiled.program.plan,
                    run_batch(self.compiled, self.seed, number, size, bundle, self.count),
                    number,
                )
                bundle["started"], now = 0, time.perf_counter()
                self.done.append((size, now - begun))
                if now - handed > PARCEL_SECONDS:
                    self.finished.put((parcel, None))
                    parcel, handed = {}, now
        except Stopped:
            pass
        except Exception as error:  # raised again in the caller's thread
            self.finished.put(({}, error))
        if parcel:
            self.finished.put((parcel, None))
        self.finished.put(({}, None))  # an empty parcel marks the end of this thread

    def _stop(self) -> None:
        """Ask all threads to stop, within a batch."""
        self.is_over = True
        for bundle in self.bundles:
            bundle["stop"] = 1
