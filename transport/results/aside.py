"""Room for many numbers in a file without a name: they take memory only while they are looked at.

The file is gone with the array.  Where temporary files lie in memory, the disk is full or no file can be mapped, numbers stay in memory.
"""

from __future__ import annotations

import contextlib
import mmap
import os
from pathlib import Path

import numpy as np

LARGE = 1 << 24  # bytes, from which on numbers are put aside
MOUNTS = Path("/proc/mounts")
IN_MEMORY = ("tmpfs", "ramfs")  # file systems


def room_for(shape: int | tuple[int, ...], kind: np.dtype | type) -> np.ndarray:
    """An array whose numbers are not set, aside where they are many."""
    kind = np.dtype(kind)
    size = int(np.prod(shape)) * kind.itemsize
    if size >= LARGE and has_files():
        import tempfile  # which imports `random`: a script's own file of that name would be taken for it

        with contextlib.suppress(OSError), tempfile.TemporaryFile() as file:
            # A disk that is full says so here: at a write to the memory the process would die.
            os.posix_fallocate(file.fileno(), 0, size)
            return np.memmap(file, kind, "r+", shape=shape)
    return np.empty(shape, kind)


def put_aside(numbers: np.ndarray) -> np.ndarray:
    """The same numbers, aside where they are many."""
    if numbers.nbytes < LARGE or isinstance(numbers, np.memmap):
        return numbers
    room = room_for(numbers.shape, numbers.dtype)
    if not isinstance(room, np.memmap):
        return numbers
    room[...] = numbers
    let_go(room)
    return room


def let_go(numbers: np.ndarray) -> None:
    """Give back the memory that it took to look at them; they are in their file."""
    if isinstance(numbers, np.memmap) and numbers._mmap is not None:
        numbers._mmap.madvise(mmap.MADV_DONTNEED)


def has_files() -> bool:
    """Whether temporary files can be mapped, and do not lie in memory themselves."""
    if not (hasattr(os, "posix_fallocate") and hasattr(mmap, "MADV_DONTNEED")):
        return False
    import tempfile

    folder, kinds = Path(tempfile.gettempdir()).resolve(), {}
    with contextlib.suppress(OSError):
        lines = (line.split() for line in MOUNTS.read_text().splitlines())
        kinds = {Path(line[1]): line[2] for line in lines}  # of the last that is mounted there
    on = next((place for place in (folder, *folder.parents) if place in kinds), None)
    return on is not None and kinds[on] not in IN_MEMORY


def bytes_free() -> int:
    """How much there is room for."""
    import shutil
    import tempfile

    return shutil.disk_usage(tempfile.gettempdir()).free if has_files() else 0
