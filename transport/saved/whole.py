"""Atomic writes: a file is written under a temporary name, synced to disk, then renamed over the old file."""

from __future__ import annotations

import itertools
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from transport.validation import SceneError

_numbers = itertools.count()


class FileError(SceneError, OSError):
    """A file cannot be written or read; the message names the file and the cure."""


@contextmanager
def written_whole(path: Path) -> Iterator[BinaryIO]:
    """Yield a file to write to, which replaces `path` once it is on disk; on an error the old file stays.

    Raises FileError if the disk is full or the file cannot be written.
    """
    path = Path(os.path.realpath(path))  # keep a symbolic link
    aside = _beside(path)
    try:
        _remove_left_over(path)
        try:
            with aside.open("w+b") as file:
                yield file
                file.flush()
                os.fsync(file.fileno())
            os.replace(aside, path)
        except BaseException:
            aside.unlink(missing_ok=True)
            raise
        _bring_names_to_disk(path.parent)
    except FileError:
        raise
    except OSError as error:
        said = error.strerror or error
        raise FileError(f"cannot write {path}: {said}; {_cure(path)}") from error


def check_writable(path: Path) -> None:
    """Raise OSError if the file could not be replaced, e.g. in a read-only folder or with too long a name."""
    aside = _beside(Path(os.path.realpath(path)))
    try:
        aside.open("w+b").close()
    finally:
        with suppress(OSError):
            aside.unlink(missing_ok=True)


def _beside(path: Path) -> Path:
    """Return the temporary path beside the file."""
    return path.with_name(f".{path.name}.{_mine()}-{next(_numbers)}.part")


def _cure(path: Path) -> str:
    if not path.parent.is_dir():
        return f"make the folder {path.parent} first"
    return (
        "the old file is unchanged; free disk space, or write elsewhere"
        if path.exists()
        else "write elsewhere"
    )


def _mine() -> str:
    """Return a name of this process, unique among all that may write into one folder."""
    return f"{socket.gethostname()}-{os.getpid()}"


def _remove_left_over(path: Path) -> None:
    """Remove temporary files that killed processes of this machine left."""
    host = socket.gethostname()
    for left in path.parent.glob(f".{_literal(path.name)}.{_literal(host)}-*-*.part"):
        process = left.name.rsplit("-", 2)[1]
        if process.isdigit() and not _is_alive(int(process)):
            left.unlink(missing_ok=True)


def _literal(name: str) -> str:
    """Escape the special characters of a glob pattern."""
    return "".join(f"[{letter}]" if letter in "[]*?" else letter for letter in name)


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


def _bring_names_to_disk(folder: Path) -> None:
    """Sync a folder, so that a new name survives a power loss, if the system can."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
