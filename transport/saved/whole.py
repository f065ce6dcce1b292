"""A file that is whole or not there: written aside, brought to the disk, then put in place of the old one in one step."""

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
    """A file of a run that cannot be written, or read; the message names it, and says what to do."""


@contextmanager
def written_whole(path: Path) -> Iterator[BinaryIO]:
    """A file to write to, which takes the place of `path` once all is on the disk; else what was there stays as it was.

    Raises FileError where the disk is full and the like.
    """
    path = Path(os.path.realpath(path))  # a link stays one
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
    """Raises OSError where a file could not be written in place of this one: its folder is locked, its name too long."""
    aside = _beside(Path(os.path.realpath(path)))
    try:
        aside.open("w+b").close()
    finally:
        with suppress(OSError):
            aside.unlink(missing_ok=True)


def _beside(path: Path) -> Path:
    """Where it is written before it is put in place."""
    return path.with_name(f".{path.name}.{_mine()}-{next(_numbers)}.part")


def _cure(path: Path) -> str:
    if not path.parent.is_dir():
        return f"make the folder {path.parent} first"
    return (
        "what was there is as it was; make room, or write elsewhere" if path.exists() else "write elsewhere"
    )


def _mine() -> str:
    """The name of this process among all that may write into one folder."""
    return f"{socket.gethostname()}-{os.getpid()}"


def _remove_left_over(path: Path) -> None:
    """Remove what processes of this machine that have been killed were writing aside."""
    host = socket.gethostname()
    for left in path.parent.glob(f".{_literal(path.name)}.{_literal(host)}-*-*.part"):
        process = left.name.rsplit("-", 2)[1]
        if process.isdigit() and not _is_alive(int(process)):
            left.unlink(missing_ok=True)


def _literal(name: str) -> str:
    """A name in which a pattern's letters mean themselves."""
    return "".join(f"[{letter}]" if letter in "[]*?" else letter for letter in name)


def _is_alive(process: int) -> bool:
    if os.name == "nt":  # where asking would end it
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


def _bring_names_to_disk(folder: Path) -> None:
    """Make a new name survive a loss of power, where the system can."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
