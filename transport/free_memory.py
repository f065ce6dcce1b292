"""Memory that this process may still use, from the system and its control groups."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

ALWAYS = 1 << 28  # bytes assumed to be available
PROC, GROUPS = Path("/proc"), Path("/sys/fs/cgroup")


def memory_left() -> int | None:
    """Bytes that this process may still use, from the system and its control groups; None if unknown."""
    return min(_told(), default=None)


def _told() -> Iterator[int]:
    """Limits on further memory [bytes]."""
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
    """Memory left by a control group and its ancestors; page cache counts as free."""
    here = Path(path.lstrip("/"))
    for group in (here, *here.parents):
        with contextlib.suppress(OSError, ValueError):
            limit = int((root / group / most).read_text())  # "max" (ValueError) if there is no limit
            remembered = _fields(root / group / "memory.stat").get(cache, 0)
            yield max(0, limit - int((root / group / used).read_text()) + remembered)


def _fields(path: Path) -> dict[str, int]:
    """Numbers of a file with lines of name and number."""
    lines = (line.replace(":", " ").split() for line in path.read_text().splitlines())
    return {line[0]: int(line[1]) for line in lines if len(line) > 1}


def size_text(number: float) -> str:
    """Number of bytes in MB, GB or TB."""
    if number >= 1e12:
        return f"{number / 1e12:.3g} TB"
    return f"{number / 1e9:.3g} GB" if number >= 1e9 else f"{number / 1e6:.3g} MB"
