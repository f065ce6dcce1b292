"""Memory check: refuse a run whose sums exceed the available memory, before it starts."""

from __future__ import annotations

import math
from dataclasses import dataclass

from transport.compile.plan import Plan
from transport.results.footprint import (
    bytes_of_counting,
    bytes_of_records,
    resident_bytes,
    total_bytes,
)
from transport.run.schedules import MAX_BATCH_SIZE, Schedule
from transport.statistics.chunked import MIN_FREE, available_memory, free_disk_bytes, size_text
from transport.validation import SceneError, join_names


@dataclass(frozen=True)
class MemoryNeed:
    """Upper bound of the memory of a run [bytes].

    counting: per thread; kept: per stored batch; on_the_way: total of batches in transit from workers.
    """

    per_thread: float
    threads: int
    kept: float
    batches: int
    in_transit: float = 0.0

    @property
    def total(self) -> float:
        """Return the memory of all threads, stored batches and results in transit [bytes]."""
        return self.per_thread * self.threads + self.kept * self.batches + self.in_transit

    def __str__(self) -> str:
        parts = [f"{size_text(self.per_thread)} on each of {self.threads} threads"] if self.threads else []
        parts += [f"{size_text(self.kept)} in each of {self.batches} batches"] if self.batches else []
        parts += [f"{size_text(self.in_transit)} in transit from the workers"] if self.in_transit else []
        return join_names(parts)


def check_memory(plan: Plan, schedule: Schedule, threads: int, saved: int = 0) -> None:
    """Raise SceneError where the sums of all threads and stored batches may exceed the available memory.

    threads: of this process, 0 where workers compute; saved: batches of the resumed run, which are in memory
    already. Nothing is refused where the system does not report its available memory.
    """
    need = memory_need(plan, schedule, threads, saved)
    cures = ["threads=1"] if need.threads > 1 else []
    cures += [f"fewer batches than {need.batches + saved}"] if need.batches != 1 else []
    _refuse_above(plan, need, "simulate: the sums of this scene", cures)


def check_worker_memory(plan: Plan, threads: int) -> None:
    """Raise SceneError where a cluster worker's sums may exceed its available memory.

    These are the sums of its threads, and those that wait to be sent.
    """
    batch = total_bytes(plan, _records_per_batch(plan, 1))
    need = MemoryNeed(_bytes_per_thread(plan, 1) + 2 * batch, threads, 0.0, 0)
    cures = [*(["workers with fewer threads"] if threads > 1 else []), "workers with more memory"]
    _refuse_above(plan, need, "a worker of the cluster: the sums of this scene", cures)


def memory_need(plan: Plan, schedule: Schedule, threads: int, saved: int = 0) -> MemoryNeed:
    """Return the upper bound of a run's memory, without sums that are stored in a file."""
    batches = max(0, _max_stored_batches(schedule, saved) - saved)
    records = _records_per_batch(plan, schedule.count)
    whole, kept = (of(plan, records) for of in (total_bytes, resident_bytes))
    # Count all sums as memory where their file would not fit on the disk.
    if whole > kept and free_disk_bytes() < batches * (whole - kept):
        kept = whole
    counting = _bytes_per_thread(plan, schedule.count) + kept  # kept: the thread's batch while it is packed
    return MemoryNeed(counting, threads, kept, batches, 0 if threads else 2 * whole)


def _refuse_above(plan: Plan, need: MemoryNeed, what: str, cures: list[str]) -> None:
    if need.total < MIN_FREE:
        return
    left = available_memory()
    if left is not None and need.total > left:
        raise SceneError(
            f"{what} take up to {size_text(need.total)}, {need}, and {size_text(left)} of memory are left;"
            f" {', or '.join([_fewer_bins_advice(plan), *cures])}"
        )


def _bytes_per_thread(plan: Plan, batches: int) -> float:
    """Return the bytes per thread while a batch runs."""
    return bytes_of_counting(plan) + bytes_of_records(_records_per_batch(plan, batches))


def _records_per_batch(plan: Plan, batches: int) -> float:
    """Return the records of snapshots per batch."""
    return sum(snapshot.particles for snapshot in plan.scene.snapshots) / batches


def _max_stored_batches(schedule: Schedule, saved: int) -> int:
    """Return the largest number of stored batches.

    A new run limited by particles stores no more than it has.
    """
    limits = schedule.limits
    if saved or limits.error or limits.seconds is not None or limits.particles is None:
        return schedule.max_stored
    return min(schedule.max_stored, max(schedule.count, math.ceil(limits.particles / MAX_BATCH_SIZE)))


def _fewer_bins_advice(plan: Plan) -> str:
    """Return the advice to use fewer bins, with the detector that has most of them."""
    kinds = {"detector": plan.scene.meters, "volume detector": plan.scene.volumes}
    named = {f"{kind} {each.name!r}": each.name for kind, found in kinds.items() for each in found}
    rows = {title: plan.rows_of[name].count for title, name in named.items()}
    name = max(rows, key=rows.get, default=None)
    return f"use fewer bins ({name} has {rows[name]:_})" if name else "use fewer bins"
