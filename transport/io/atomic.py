"""Atomic writes: a file is written under a temporary name, synced to disk, then renamed over the old file."""

from __future__ import annotations

import glob
import io
import itertools
import os
import socket
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from transport.validation import SceneError

_counter = itertools.count()


class FileError(SceneError, OSError):
    """A file cannot be written or read; the message names the file and the cure."""


@contextmanager
def atomic_write(path: Path) -> Iterator[BinaryIO]:
    """Yield a file to write to, which replaces `path` once it is on disk; on an error the old file stays.

    Raises FileError if the disk is full or the file cannot be written.
    """
    path = Path(os.path.realpath(path))  # keep a symbolic link
    temporary = _temporary_path(path)
    try:
        _remove_leftovers(path)
        try:
            with temporary.open("w+b") as file:
                yield file
                file.flush()
                os.fsync(file.fileno())
            os.replace(temporary, path)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
        _sync_folder(path.parent)
    except FileError:
        raise
    except OSError as error:
        reason = error.strerror or error
        raise FileError(f"cannot write {path}: {reason}; {_cure(path)}") from error


def check_writable(path: Path) -> None:
    """Raise OSError if the file could not be replaced, e.g. in a read-only folder or with too long a name."""
    temporary = _temporary_path(Path(os.path.realpath(path)))
    try:
        temporary.open("w+b").close()
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def _temporary_path(path: Path) -> Path:
    """Return the temporary path beside the file, unique among all processes that may write there."""
    process = f"{socket.gethostname()}-{os.getpid()}"
    return path.with_name(f".{path.name}.{process}-{next(_counter)}.part")


def _cure(path: Path) -> str:
    if not path.parent.is_dir():
        return f"make the folder {path.parent} first"
    is_old = path.exists()
    return "the old file is unchanged; free disk space, or write elsewhere" if is_old else "write elsewhere"


def _remove_leftovers(path: Path) -> None:
    """Remove temporary files that killed processes of this machine left."""
    host = socket.gethostname()
    for left in path.parent.glob(f".{glob.escape(path.name)}.{glob.escape(host)}-*-*.part"):
        process = left.name.rsplit("-", 2)[1]
        if process.isdigit() and not _is_alive(int(process)):
            left.unlink(missing_ok=True)


def _is_alive(process: int) -> bool:
    if os.name == "nt":  # os.kill would end the process
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


def _sync_folder(folder: Path) -> None:
    """Sync a folder, so that a new name survives a power loss, if the system can."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


# ---- Lock of a checkpoint file against a second run; the system releases it when the process ends.

try:
    import fcntl
except ImportError:  # the system has no such locks
    fcntl = None

MAX_HOLDER_BYTES = 200  # bytes of the text that names the holder
_open_locks: set[int] = set()  # descriptors of the locks of this process


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Hold a lock on the file until the context ends.  Raises FileError if another run holds it.

    The lock is on a file beside it, because each checkpoint replaces the file itself.  A lock file left by a
    killed process is not locked.  On a file system without locks every run is admitted.
    """
    real = Path(os.path.realpath(path))
    beside = real.with_name(f".{real.name}.lock")
    descriptor = None if fcntl is None else _acquire(path, beside)
    try:
        yield
    finally:
        if descriptor in _open_locks:
            with suppress(OSError):
                # Remove before release: afterwards it might belong to another run.
                beside.unlink(missing_ok=True)
            _open_locks.remove(descriptor)
            os.close(descriptor)


def _acquire(path: Path, beside: Path) -> int | None:
    """Return the descriptor that holds the lock; None without locks.

    Raises FileError if another run holds it.
    """
    while True:
        try:
            descriptor = os.open(beside, os.O_RDWR | os.O_CREAT, 0o666)
        except OSError:  # writing the checkpoint reports the same error
            return None
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except (BlockingIOError, PermissionError):
            holder = _read_holder(descriptor)
            os.close(descriptor)
            cure = "wait for it, stop it, or name another file"
            raise FileError(f"simulate: checkpoint {path} is in use by another run{holder}; {cure}") from None
        except OSError:
            os.close(descriptor)
            with suppress(OSError):
                beside.unlink()
            return None
        if _is_same_file(descriptor, beside):
            _write_holder(descriptor)
            _open_locks.add(descriptor)
            return descriptor
        os.close(descriptor)  # its last holder has removed it meanwhile


def _is_same_file(descriptor: int, beside: Path) -> bool:
    with suppress(OSError):
        return os.path.samestat(os.fstat(descriptor), os.stat(beside))
    return False


def _write_holder(descriptor: int) -> None:
    """Write the holder into the lock file, for the error message of other runs."""
    with suppress(OSError):
        os.ftruncate(descriptor, 0)
        os.write(descriptor, f", process {os.getpid()} on {socket.gethostname()}".encode()[:MAX_HOLDER_BYTES])


def _read_holder(descriptor: int) -> str:
    with suppress(OSError):
        return os.pread(descriptor, MAX_HOLDER_BYTES, 0).decode(errors="replace")
    return ""


def _close_in_child() -> None:
    """Close the locks in a forked child: they belong to the parent, and would outlive it in the child."""
    while _open_locks:
        os.close(_open_locks.pop())


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_close_in_child)


# ---- A checksum of all bytes, appended to a file and verified before anything else is read.
#
# HDF5 has checksums of its chunks, but not of its tables: a wrong bit there changes how numbers are unpacked,
# or causes an endless loop.  HDF5, and other programs that read the file, ignore bytes after the end of its
# own data.

CHECKSUM_MARK = b"\ntransport crc32 "  # then eight digits
CHECKSUM_LENGTH = len(CHECKSUM_MARK) + 8
READ_SIZE = 1 << 22  # bytes per read


def append_checksum(file: BinaryIO) -> None:
    """Append the checksum to the file."""
    length = file.seek(0, io.SEEK_END)
    checksum = _checksum(file, length)
    file.seek(length)
    file.write(checksum)


def verify_checksum(file: BinaryIO) -> None:
    """Raise ValueError if the checksum is missing or wrong; otherwise rewind the file."""
    length = max(0, file.seek(0, io.SEEK_END) - CHECKSUM_LENGTH)
    file.seek(length)
    found = file.read()
    if not found.startswith(CHECKSUM_MARK):
        raise ValueError("its checksum is missing: it was cut off, or rewritten by another program")
    if found != _checksum(file, length):
        raise ValueError("its checksum is wrong: bytes were damaged or changed")
    file.seek(0)


def _checksum(file: BinaryIO, length: int) -> bytes:
    found, left = 0, length
    file.seek(0)
    while left and (piece := file.read(min(READ_SIZE, left))):
        found, left = zlib.crc32(piece, found), left - len(piece)
    return CHECKSUM_MARK + f"{found:08x}".encode()
