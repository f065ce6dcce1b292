"""Lock of a checkpoint file against a second run; the system releases it when the process ends."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from transport.saved.whole import FileError

try:
    import fcntl
except ImportError:  # the system has no such locks
    fcntl = None

MOST_SAID = 200  # bytes of the text that names the holder
_open: set[int] = set()  # descriptors of the locks of this process


@contextmanager
def held(path: Path) -> Iterator[None]:
    """Hold a lock on the file until the context ends.  Raises FileError if another run holds it.

    The lock is on a file beside it, because each checkpoint replaces the file itself.  A lock file left by a
    killed process is not locked.  On a file system without locks every run is admitted.
    """
    real = Path(os.path.realpath(path))
    beside = real.with_name(f".{real.name}.lock")
    descriptor = None if fcntl is None else _taken(path, beside)
    try:
        yield
    finally:
        if descriptor in _open:
            with suppress(OSError):
                # Remove before release: afterwards it might belong to another run.
                beside.unlink(missing_ok=True)
            _open.remove(descriptor)
            os.close(descriptor)


def _taken(path: Path, beside: Path) -> int | None:
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
            holder = _who(descriptor)
            os.close(descriptor)
            cure = "wait for it, stop it, or name another file"
            raise FileError(f"simulate: checkpoint {path} is in use by another run{holder}; {cure}") from None
        except OSError:
            os.close(descriptor)
            with suppress(OSError):
                beside.unlink()
            return None
        if _is_there(descriptor, beside):
            _sign(descriptor)
            _open.add(descriptor)
            return descriptor
        os.close(descriptor)  # its last holder has removed it meanwhile


def _is_there(descriptor: int, beside: Path) -> bool:
    with suppress(OSError):
        return os.path.samestat(os.fstat(descriptor), os.stat(beside))
    return False


def _sign(descriptor: int) -> None:
    """Write the holder into the lock file, for the error message of other runs."""
    with suppress(OSError):
        os.ftruncate(descriptor, 0)
        os.write(descriptor, f", process {os.getpid()} on {socket.gethostname()}".encode()[:MOST_SAID])


def _who(descriptor: int) -> str:
    with suppress(OSError):
        return os.pread(descriptor, MOST_SAID, 0).decode(errors="replace")
    return ""


def _let_go() -> None:
    """Close the locks in a forked child: they belong to the parent, and would outlive it in the child."""
    while _open:
        os.close(_open.pop())


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_let_go)
