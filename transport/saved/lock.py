"""One run at a time in a file: by a lock that the system lets go of, however its holder ends."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from transport.saved.whole import FileError

try:
    import fcntl
except ImportError:  # where the system has no such locks
    fcntl = None

MOST_SAID = 200  # bytes of who has it
_open: set[int] = set()  # descriptors of this process's own locks


@contextmanager
def held(path: Path) -> Iterator[None]:
    """The file to oneself until the context ends.  Raises FileError where another run has it.

    The lock is on a file beside it, as the file itself is replaced by each checkpoint; what a killed process leaves of it is
    not locked.  Where a file system knows no locks, nobody is refused.
    """
    real = Path(os.path.realpath(path))
    beside = real.with_name(f".{real.name}.lock")
    descriptor = None if fcntl is None else _taken(path, beside)
    try:
        yield
    finally:
        if descriptor in _open:
            with suppress(OSError):
                beside.unlink(missing_ok=True)  # before it is let go: else it might be another's
            _open.remove(descriptor)
            os.close(descriptor)


def _taken(path: Path, beside: Path) -> int | None:
    """What the lock is held by; None where there are no locks."""
    while True:
        try:
            descriptor = os.open(beside, os.O_RDWR | os.O_CREAT, 0o666)
        except OSError:  # what a checkpoint would be told too
            return None
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except (BlockingIOError, PermissionError):
            holder = _who(descriptor)
            os.close(descriptor)
            cure = "wait until it has ended, end it, or name another file"
            raise FileError(
                f"simulate: checkpoint {path} is that of a run that goes on{holder}; {cure}"
            ) from None
        except OSError:
            os.close(descriptor)
            with suppress(OSError):
                beside.unlink()
            return None
        if _is_there(descriptor, beside):
            _sign(descriptor)
            _open.add(descriptor)
            return descriptor
        os.close(descriptor)  # which its last holder removed meanwhile


def _is_there(descriptor: int, beside: Path) -> bool:
    with suppress(OSError):
        return os.path.samestat(os.fstat(descriptor), os.stat(beside))
    return False


def _sign(descriptor: int) -> None:
    """Say who has it, for those who are refused."""
    with suppress(OSError):
        os.ftruncate(descriptor, 0)
        os.write(descriptor, f", process {os.getpid()} on {socket.gethostname()}".encode()[:MOST_SAID])


def _who(descriptor: int) -> str:
    with suppress(OSError):
        return os.pread(descriptor, MOST_SAID, 0).decode(errors="replace")
    return ""


def _let_go() -> None:
    """In a child of this process: the locks are its parent's, and would outlive it there."""
    while _open:
        os.close(_open.pop())


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_let_go)
