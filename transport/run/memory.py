"""Memory check: refuse a run whose sums exceed the available memory, before it starts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from transport.compile.plan import Plan
from transport.results.footprint import (
    bytes_in_all,
    bytes_in_memory,
    bytes_of_counting,
    bytes_of_records,
    rows_of,
)
from transport.run.schedules import LARGEST_BATCH, Schedule
from transport.statistics.chunked import ALWAYS, bytes_free, memory_left, size_text
from transport.validation import SceneError, listed


@dataclass(frozen=True)
class Need:
    """Upper bound of the memory of a run [bytes].

    counting: per thread; kept: per stored batch; on_the_way: total of batches in transit from workers.
    """

    counting: float
    threads: int
    kept: float
    batches: int
    on_the_way: float = 0.0

    @property
    def total(self) -> float:
        return self.counting * self.threads + self.kept * self.batches + self.on_the_way

    def __str__(self) -> str:
        parts = [f"{size_text(self.counting)} on each of {self.threads} threads"] if self.threads else []
        parts += [f"{size_text(self.kept)} in each of {self.batches} batches"] if self.batches else []
        parts += [f"{size_text(self.on_the_way)} in transit from the workers"] if self.on_the_way else []
        return listed(parts)


def check_memory(plan: Plan, schedule: Schedule, threads: int, saved: int = 0) -> None:
    """Raise SceneError where the sums of all threads and stored batches may exceed the available memory.

    threads: of this process, 0 where workers compute; saved: batches of the resumed run, which are in memory
    already. Nothing is refused where the system does not report its available memory.
    """
    need = need_of(plan, schedule, threads, saved)
    cures = ["threads=1"] if need.threads > 1 else []
    cures += [f"fewer batches than {need.batches + saved}"] if need.batches != 1 else []
    _refuse_beyond(plan, need, "simulate: the sums of this scene", cures)


def check_worker_memory(plan: Plan, threads: int) -> None:
    """Raise SceneError where a cluster worker's sums may exceed its available memory.

    These are the sums of its threads, and those that wait to be sent.
    """
    batch = bytes_in_all(plan, _records(plan, 1))
    need = Need(_counting(plan, 1) + 2 * batch, threads, 0.0, 0)
    cures = [*(["workers with fewer threads"] if threads > 1 else []), "workers with more memory"]
    _refuse_beyond(plan, need, "a worker of the cluster: the sums of this scene", cures)


def need_of(plan: Plan, schedule: Schedule, threads: int, saved: int = 0) -> Need:
    """Return the upper bound of a run's memory, without sums that are stored in a file."""
    batches = max(0, _most_kept(schedule, saved) - saved)
    records = _records(plan, schedule.count)
    whole, kept = (of(plan, records) for of in (bytes_in_all, bytes_in_memory))
    # Count all sums as memory where their file would not fit on the disk.
    if bytes_free() < batches * (whole - kept):
        kept = whole
    counting = _counting(plan, schedule.count) + kept  # kept: the thread's batch while it is packed
    return Need(counting, threads, kept, batches, 0 if threads else 2 * whole)


def _refuse_beyond(plan: Plan, need: Need, what: str, cures: list[str]) -> None:
    if need.total < ALWAYS:
        return
    left = memory_left()
    if left is not None and need.total > left:
        raise SceneError(
            f"{what} take up to {size_text(need.total)}, {need}, and {size_text(left)} of memory are left;"
            f" {', or '.join([_fewer_bins(plan), *cures])}"
        )


def _counting(plan: Plan, batches: int) -> float:
    """Return the bytes per thread while a batch runs."""
    return bytes_of_counting(plan) + bytes_of_records(_records(plan, batches))


def _records(plan: Plan, batches: int) -> float:
    """Return the records of snapshots per batch."""
    return sum(snapshot.particles for snapshot in plan.scene.snapshots) / batches


def _most_kept(schedule: Schedule, saved: int) -> int:
    """Return the largest number of stored batches.

    A new run limited by particles stores no more than it has.
    """
    limits = schedule.limits
    if saved or limits.error or limits.seconds is not None or limits.particles is None:
        return schedule.most_kept
    return min(schedule.most_kept, max(schedule.count, math.ceil(limits.particles / LARGEST_BATCH)))


def _fewer_bins(plan: Plan) -> str:
    """Return the advice to use fewer bins, with the detector that has most of them."""
    meters = {f"detector {meter.name!r}": rows_of(plan.scene, meter) for meter in plan.scene.meters}
    for volume in plan.volumes:
        cells = np.size(volume.detector.volumes(volume.shape))
        meters[f"volume detector {volume.detector.name!r}"] = cells * int(volume.row["rows"])
    name = max(meters, key=meters.get, default=None)
    return f"use fewer bins ({name} has {meters[name]:_})" if name else "use fewer bins"
