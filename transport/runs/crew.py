"""Threads that do batches, and hand them over in the order of their numbers."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Iterator

from transport.results.batches import Batch, batch_of
from transport.runs.origins import Origin

GLANCE = 0.1  # [s] between looks at the progress
# [s] of batches that are handed over together: between threads that takes as long as a small one
PARCEL = 5e-3


class CrewLost(RuntimeError):
    """Nobody is there any more to do batches; those that were handed over are good."""


class InOrder:
    """Batches come as they are done, and are handed over in the order of their numbers, each once.

    done: the histories and seconds of each batch of the present leg, as they are done;  origins: who does them, where that is
    not this process;  threads: of this process that do.
    """

    threads = 0
    origins: tuple[Origin, ...] = ()

    def __init__(self) -> None:
        self.next = 0  # number of the next batch to be handed over
        self.ahead: dict[int, Batch] = {}  # batches that are done, though others before them are not
        self.done: list[tuple[int, float]] = []

    def _missing(self, sizes: Iterator[int]) -> Iterator[tuple[int, int]]:
        """Numbers and sizes of the batches that are not done yet."""
        known = frozenset(self.ahead)
        return ((number, size) for number, size in enumerate(sizes, self.next) if number not in known)

    def _keep(self, parcel: dict[int, Batch]) -> None:
        """Batches that are done; of one that was done twice, because its first doer seemed lost, only one is kept."""
        self.ahead |= {number: batch for number, batch in parcel.items() if number >= self.next}

    def _whose_turn_it_is(self) -> Iterator[Batch]:
        while self.next in self.ahead:
            self.next += 1
            yield self.ahead.pop(self.next - 1)


class Crew(InOrder):
    """As many threads as asked for, each with a bundle of its own."""

    def __init__(self, machine: object, seed: int, threads: int, count: int) -> None:
        """count: batches, among which the sample of a Snapshot is divided."""
        from transport.engine.bundle import empty_bundle

        super().__init__()
        self.machine, self.seed, self.count, self.threads = machine, seed, count, threads
        self.bundles = [empty_bundle() for _ in range(threads)]

    @property
    def started(self) -> int:
        """Histories begun in the batches that are being done, about."""
        return sum(int(bundle["started"][0]) for bundle in self.bundles)

    def work(self, sizes: Iterator[int]) -> Iterator[Batch | None]:
        """The batches of these sizes in order; None now and then, while there is nothing to hand over.

        Close it to stop early: what is done then, out of order, is in `ahead`, and not done again.  Raises what a batch raised.
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
                self._keep(self.finished.get()[0])

    def _in_order(self) -> Iterator[Batch | None]:
        working = len(self.bundles)
        yield from self._whose_turn_it_is()
        while working:
            try:
                parcel, error = self.finished.get(timeout=GLANCE)
            except queue.Empty:
                yield None
                continue
            if error is not None:
                raise error
            working -= not parcel
            self._keep(parcel)
            yield from self._whose_turn_it_is()

    def _work(self, bundle) -> None:
        """What a thread does: batch after batch, in its own bundle."""
        from transport.engine.driver import Stopped, run_batch

        bundle["stop"], bundle["started"] = 0, 0
        parcel, handed = {}, time.perf_counter()
        try:
            while not self.is_over:
                with self.lock:
                    number, size = next(self.tasks, (None, 0))
                if number is None:
                    break
                begun = time.perf_counter()
                # Its sums are not held on to: they would be there beside those of the next batch.
                parcel[number] = batch_of(
                    self.machine.program.plan,
                    run_batch(self.machine, self.seed, number, size, bundle, self.count),
                    number,
                )
                bundle["started"], now = 0, time.perf_counter()
                self.done.append((size, now - begun))
                if now - handed > PARCEL:
                    self.finished.put((parcel, None))
                    parcel, handed = {}, now
        except Stopped:
            pass
        except Exception as error:  # handed to the caller's thread
            self.finished.put(({}, error))
        if parcel:
            self.finished.put((parcel, None))
        self.finished.put(({}, None))  # the last

    def _stop(self) -> None:
        self.is_over = True
        for bundle in self.bundles:
            bundle["stop"] = 1
