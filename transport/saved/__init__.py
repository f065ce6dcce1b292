"""A run on disk: saved whole or not at all, loaded, gone on with bit by bit, and merged with others."""

from __future__ import annotations

from os import PathLike
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from transport.results import Result


def load(path: str | PathLike) -> Result:
    """The run that was saved in a .nc or .npz, bit for bit as `simulate` returned it.

    Raises FileError for what is no such file, or not whole, or newer than this version.
    """
    from transport.saved.record import load

    return load(path)


def merge(*runs: Result | str | PathLike) -> Result:
    """One Result of the batches of all runs: of Results, or of files of them.

    Raises SceneError for fewer than two, unlike scenes or ways to estimate, and batches that two of them have alike.
    """
    from transport.saved.merging import merge

    return merge(*runs)
