"""Refuses a run whose sums would not fit into the memory that is left, before it runs, with the figure and the cure."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from transport.compile.plan import Plan
from transport.free_memory import ALWAYS, memory_left, size_text
from transport.results.aside import bytes_free
from transport.results.footprint import (
    bytes_in_all,
    bytes_in_memory,
    bytes_of_counting,
    bytes_of_records,
    rows_of,
)
from transport.runs.schedules import LARGEST_BATCH, Schedule
from transport.validation import SceneError, listed


@dataclass(frozen=True)
class Need:
    """Memory that a run takes [bytes], at most.

    counting: of each of so many threads;  kept: of each of so many batches;  on_the_way: of those that come from elsewhere, in all.
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
        parts += (
            [f"{size_text(self.on_the_way)} in those that come from the workers"] if self.on_the_way else []
        )
        return listed(parts)


def check_memory(plan: Plan, schedule: Schedule, threads: int, saved: int = 0) -> None:
    """Raises SceneError where the sums of all threads and the batches that are kept may take more than is left.

    threads: of this process, 0 where workers count elsewhere;  saved: batches of the run to go on with, which are here already.
    Nothing is refused where the system does not say how much is left.
    """
    need = need_of(plan, schedule, threads, saved)
    cures = ["threads=1"] if need.threads > 1 else []
    cures += [f"fewer batches than {need.batches + saved}"] if need.batches != 1 else []
    _refuse_beyond(plan, need, "simulate: the sums of this scene", cures)


def check_worker_memory(plan: Plan, threads: int) -> None:
    """The same for the worker of a cluster, whose process counts in so many threads and keeps what they do until it is sent."""
    batch = bytes_in_all(plan, _records(plan, 1))
    need = Need(_counting(plan, 1) + 2 * batch, threads, 0.0, 0)
    cures = [*(["workers with fewer threads"] if threads > 1 else []), "workers with more memory"]
    _refuse_beyond(plan, need, "a worker of the cluster: the sums of this scene", cures)


def need_of(plan: Plan, schedule: Schedule, threads: int, saved: int = 0) -> Need:
    """What a run takes at most, but for what a file of its batches holds."""
    batches = max(0, _most_kept(schedule, saved) - saved)
    records = _records(plan, schedule.count)
    whole, kept = (of(plan, records) for of in (bytes_in_all, bytes_in_memory))
    if bytes_free() < batches * (whole - kept):
        kept = whole
    counting = _counting(plan, schedule.count) + kept  # of the batch that it packs
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
    """Of a thread, while a batch runs."""
    return bytes_of_counting(plan) + bytes_of_records(_records(plan, batches))


def _records(plan: Plan, batches: int) -> float:
    """Of the sample of snapshots, in a batch."""
    return sum(snapshot.particles for snapshot in plan.scene.snapshots) / batches


def _most_kept(schedule: Schedule, saved: int) -> int:
    """How many batches may be there at a time; of a run for a number of particles that begins, no more than it has."""
    limits = schedule.limits
    if saved or limits.error or limits.seconds is not None or limits.particles is None:
        return schedule.most_kept
    return min(schedule.most_kept, max(schedule.count, math.ceil(limits.particles / LARGEST_BATCH)))


def _fewer_bins(plan: Plan) -> str:
    """Where most of them are."""
    meters = {f"detector {meter.name!r}": rows_of(plan.scene, meter) for meter in plan.scene.meters}
    for volume in plan.volumes:
        cells = np.size(volume.detector.volumes(volume.shape))
        meters[f"volume detector {volume.detector.name!r}"] = cells * int(volume.row["rows"])
    name = max(meters, key=meters.get, default=None)
    return f"take fewer bins ({name} has {meters[name]:_})" if name else "take fewer bins"
