"""Refuses a run whose sums would not fit into the memory that is left, before it runs, with the figure and the cure."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from transport.compile.plan import Plan
from transport.results.footprint import bytes_of_a_batch, bytes_of_counting, rows_of
from transport.runs.schedules import Schedule
from transport.validation import SceneError

ALWAYS = 1 << 28  # bytes that are there
PROC, GROUPS = Path("/proc"), Path("/sys/fs/cgroup")


def check_memory(plan: Plan, schedule: Schedule, threads: int) -> None:
    """Raises SceneError where the sums of all threads and the batches that are kept may take more than is left.

    Nothing is refused where the system does not say how much that is.
    """
    counting, batch = bytes_of_counting(plan), bytes_of_a_batch(plan)
    kept = schedule.most_kept
    need = threads * (counting + batch) + kept * batch
    if need < ALWAYS:
        return
    left = memory_left()
    if left is not None and need > left:
        raise SceneError(
            f"simulate: the sums of this scene take up to {_size(need)}, {_size(counting)} on each of {threads} threads and"
            f" {_size(batch)} in each of {kept} batches, and {_size(left)} of memory are left; {_cure(plan, threads, kept)}"
        )


def memory_left() -> int | None:
    """Bytes that this process may still take, as the system and its control groups tell; None where they do not."""
    return min(_told(), default=None)


def _told() -> Iterator[int]:
    with contextlib.suppress(OSError, ValueError, KeyError):
        yield _fields(PROC / "meminfo")["MemAvailable"] * 1024
    groups = []
    with contextlib.suppress(OSError):
        groups = [line.split(":", 2) for line in (PROC / "self/cgroup").read_text().splitlines()]
    for _, controllers, path in groups:
        if controllers == "":  # version 2
            yield from _of_group(GROUPS, path, "memory.max", "memory.current", "inactive_file")
        elif "memory" in controllers.split(","):
            names = ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file")
            yield from _of_group(GROUPS / "memory", path, *names)


def _of_group(root: Path, path: str, most: str, used: str, cache: str) -> Iterator[int]:
    """What a control group and those above it leave; files that are only remembered make room."""
    here = Path(path.lstrip("/"))
    for group in (here, *here.parents):
        with contextlib.suppress(OSError, ValueError):
            limit = int((root / group / most).read_text())  # "max" where there is none
            remembered = _fields(root / group / "memory.stat").get(cache, 0)
            yield max(0, limit - int((root / group / used).read_text()) + remembered)


def _fields(path: Path) -> dict[str, int]:
    """The numbers of a file of names and numbers."""
    lines = (line.replace(":", " ").split() for line in path.read_text().splitlines())
    return {line[0]: int(line[1]) for line in lines if len(line) > 1}


def _cure(plan: Plan, threads: int, kept: int) -> str:
    """What makes them smaller."""
    meters = {f"detector {meter.name!r}": rows_of(plan.scene, meter) for meter in plan.scene.meters}
    for volume in plan.volumes:
        cells = np.size(volume.detector.volumes(volume.shape))
        meters[f"volume detector {volume.detector.name!r}"] = cells * int(volume.row["rows"])
    name = max(meters, key=meters.get, default=None)
    cures = [f"take fewer bins ({name} has {meters[name]:_})" if name else "take fewer bins"]
    cures += ["threads=1"] * (threads > 1) + [f"fewer batches than {kept}"] * (kept > 2)
    return ", or ".join(cures)


def _size(number: float) -> str:
    return f"{number / 1e9:.3g} GB" if number >= 1e9 else f"{number / 1e6:.3g} MB"
