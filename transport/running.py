"""Batches on threads until enough is known: what `simulate` does once a program is ready."""

import math
import queue
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from transport.limits import HOPELESS, MOST_PARTICLES, Limits
from transport.progress import Progress
from transport.results import Result
from transport.results.batches import Batch, batch_of
from transport.scene import Scene

LARGEST_BATCH = 1 << 24  # histories; sums are exact below 2^30 crossings a batch
FIRST_BATCH = (
    512  # histories of a batch where their number is not known beforehand; doubled as the run goes on
)
GLANCE = 0.1  # [s] between looks at the progress


@dataclass
class Run:
    """Batches on threads, taken in order, so that when a run stops does not depend on their timing."""

    scene: Scene
    machine: object
    seed: int
    limits: Limits
    threads: int
    bar: Progress
    batches: list[Batch] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    is_complete: bool = True

    def go(self) -> None:
        from transport.engine.bundle import empty_bundle

        self.begun = self.shown = time.perf_counter()
        self.is_over = False
        self.bundles = [empty_bundle() for _ in range(self.threads)]
        self.tasks, self.lock, self.finished = enumerate(self._sizes()), threading.Lock(), queue.SimpleQueue()
        workers: list[threading.Thread] = []
        done: dict[int, Batch] = {}
        try:
            for bundle in self.bundles:
                worker = threading.Thread(target=self._work, args=(bundle,), daemon=True)
                worker.start()
                workers.append(worker)
            self._collect(done)
            if not_reached := self._not_reached():
                self.warnings.append(not_reached)
        except KeyboardInterrupt:
            for number in sorted(done):  # complete as they are; only their order is not
                self._take(done[number])
            self.is_complete = False
            self.warnings.append(f"interrupted after {len(self.batches)} batches")
        finally:
            self.is_over = True
            for bundle in self.bundles:
                bundle["stop"] = 1
            for worker in workers:
                worker.join()

    def _work(self, bundle) -> None:
        """What a thread does: batch after batch, in its own bundle."""
        from transport.engine.driver import Stopped, run_batch

        plan = self.machine.program.plan
        try:
            while not self.is_over:
                with self.lock:
                    number, size = next(self.tasks, (None, 0))
                if number is None:
                    break
                self.finished.put(
                    (
                        number,
                        batch_of(
                            plan,
                            run_batch(self.machine, self.seed, number, size, bundle, self.limits.batches),
                        ),
                    )
                )
        except Stopped:
            pass
        except Exception as error:  # handed to the caller's thread
            self.finished.put((None, error))
        self.finished.put((None, None))

    def _collect(self, done: dict[int, Batch]) -> None:
        """Take batches in the order of their numbers until all are there or enough is known."""
        working, taken = self.threads, 0
        while working:
            found = self._next_finished()
            if found is None:
                return
            number, batch = found
            if number is not None:
                done[number] = batch
            elif batch is not None:
                raise batch
            else:
                working -= 1
            while taken in done:
                self._take(done.pop(taken))
                taken += 1
                if self._is_enough():
                    return

    def _next_finished(self) -> tuple[int | None, Batch | Exception | None] | None:
        """A batch with its number, an error or a worker's end without one; None when the time is up."""
        while True:
            if len(self.batches) > 1 and self._is_late():
                return None
            if time.perf_counter() - self.shown > GLANCE:
                self._show(sum(int(bundle["started"][0]) for bundle in self.bundles))
            try:
                return self.finished.get(timeout=GLANCE)
            except queue.Empty:
                continue

    def _sizes(self) -> Iterator[int]:
        """Histories of the next batches.  With `particles` alone all are known; else they double as the run goes on."""
        particles, batches = self.limits.particles, self.limits.batches
        if particles is not None and not self.limits.error and self.limits.seconds is None:
            count = min(particles, max(batches, math.ceil(particles / LARGEST_BATCH)))
            for k in range(count):
                yield particles // count + (k < particles % count)
            return
        size, left = FIRST_BATCH, particles or MOST_PARTICLES
        first = True
        while left > 0:
            for _ in range(2 * batches if first else batches):
                if left > 0:
                    yield min(size, left)
                    left -= min(size, left)
            first = False
            size = min(2 * size, LARGEST_BATCH)

    def _take(self, batch: Batch) -> None:
        """Keep the batch.  Between `batches` and twice as many are kept: then pairs become one."""
        open_ended = self.limits.particles is None or self.limits.error or self.limits.seconds is not None
        self.batches.append(batch)
        if open_ended and len(self.batches) == 2 * self.limits.batches:
            wanted = sum(snapshot.particles for snapshot in self.scene.snapshots)
            most = math.ceil(2 * wanted / self.limits.batches)
            pairs = zip(self.batches[::2], self.batches[1::2], strict=True)
            self.batches = [one.merged(other, most) for one, other in pairs]

    def _is_enough(self) -> bool:
        limits = self.limits
        if self._is_late():
            return True
        if limits.error and len(self.batches) >= limits.batches:
            ratios = self._error_ratios()
            is_hopeless = math.inf in ratios and self._particles() >= HOPELESS
            return is_hopeless or max(ratios) <= 1
        return False

    def _is_late(self) -> bool:
        return self.limits.seconds is not None and time.perf_counter() - self.begun >= self.limits.seconds

    def _not_reached(self) -> str | None:
        """What to say when the run ended before the error asked for was reached."""
        if not self.limits.error:
            return None
        ratios = dict(zip(self.limits.error, self._error_ratios(), strict=True))
        name = max(ratios, key=ratios.get)
        if ratios[name] <= 1:
            return None
        times = (
            "without a score for it"
            if ratios[name] == math.inf
            else f"at {ratios[name]:.3g} times the error asked for"
        )
        return f"{name}: stopped after {self._particles()} particles, {times}"

    def _particles(self) -> int:
        return sum(batch.histories for batch in self.batches)

    def _error_ratios(self) -> list[float]:
        """Each relative error asked for, as it is over as it should be; infinite while it is not known."""
        result = Result(self.machine.program.plan, self.batches, self.seed, None, True, [])
        ratios = []
        for name, target in self.limits.error.items():
            quantity = result.quantity(name)
            relative = np.atleast_1d(quantity.relative_error)
            known = relative[np.isfinite(relative)]  # bins without a score have no error to reach
            if known.size:
                ratios.append(float(known.max()) / target)
            else:
                ratios.append(math.inf if np.all(np.asarray(quantity.value) == 0) else 0.0)
        return ratios

    def _show(self, started: int) -> None:
        self.shown = time.perf_counter()
        taken = sum(batch.histories for batch in self.batches)
        elapsed = time.perf_counter() - self.begun
        if self.limits.particles is not None:
            share = (taken + started) / self.limits.particles
        elif self.limits.seconds is not None:
            share = elapsed / self.limits.seconds
        else:
            share = math.nan
        if self.limits.seconds is not None:
            share = max(0.0 if share != share else share, elapsed / self.limits.seconds)
        self.bar.running(taken + started, share)
