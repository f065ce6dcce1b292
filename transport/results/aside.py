"""Memory-mapped arrays: an anonymous temporary file holds the numbers, and only pages in use take memory.

The file disappears with the array.  Arrays stay in memory if temporary files lie in memory, the disk is full
or no file can be mapped.
"""

from __future__ import annotations

import contextlib
import mmap
import os
from pathlib import Path

import numpy as np

LARGE = 1 << 24  # bytes, from which on arrays are memory-mapped
MOUNTS = Path("/proc/mounts")
IN_MEMORY = ("tmpfs", "ramfs")  # file systems in memory


def room_for(shape: int | tuple[int, ...], kind: np.dtype | type) -> np.ndarray:
    """Allocate an uninitialised array, memory-mapped if it is large."""
    kind = np.dtype(kind)
    size = int(np.prod(shape)) * kind.itemsize
    if size >= LARGE and has_files():
        import tempfile  # not at the top: it imports `random`, which a user's file may shadow

        with contextlib.suppress(OSError), tempfile.TemporaryFile() as file:
            # Allocate the disk space here, where a full disk raises an error; a later write would kill the
            # process.
            os.posix_fallocate(file.fileno(), 0, size)
            return np.memmap(file, kind, "r+", shape=shape)
    return np.empty(shape, kind)


def put_aside(numbers: np.ndarray) -> np.ndarray:
    """Move an array to a memory-mapped file if it is large; otherwise return it unchanged."""
    if numbers.nbytes < LARGE or isinstance(numbers, np.memmap):
        return numbers
    room = room_for(numbers.shape, numbers.dtype)
    if not isinstance(room, np.memmap):
        return numbers
    room[...] = numbers
    let_go(room)
    return room


def let_go(numbers: np.ndarray) -> None:
    """Release the resident pages of a memory-mapped array (madvise DONTNEED); its file keeps the numbers."""
    if isinstance(numbers, np.memmap) and numbers._mmap is not None:
        numbers._mmap.madvise(mmap.MADV_DONTNEED)


def has_files() -> bool:
    """Whether temporary files can be mapped and do not lie in memory themselves."""
    if not (hasattr(os, "posix_fallocate") and hasattr(mmap, "MADV_DONTNEED")):
        return False
    import tempfile

    folder, kinds = Path(tempfile.gettempdir()).resolve(), {}
    with contextlib.suppress(OSError):
        lines = (line.split() for line in MOUNTS.read_text().splitlines())
        kinds = {Path(line[1]): line[2] for line in lines}  # the last file system mounted at each place
    on = next((place for place in (folder, *folder.parents) if place in kinds), None)
    return on is not None and kinds[on] not in IN_MEMORY


def bytes_free() -> int:
    """Free disk space for temporary files [bytes]; 0 if they cannot be used."""
    import shutil
    import tempfile

    return shutil.disk_usage(tempfile.gettempdir()).free if has_files() else 0
