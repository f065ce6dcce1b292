"""Saved runs: atomic files, loading, resuming bit for bit, and merging."""

from __future__ import annotations

from os import PathLike
from typing import TYPE_CHECKING

from transport.validation import checked_keywords

if TYPE_CHECKING:
    from transport.results.result import Result


@checked_keywords
def load(path: str | PathLike) -> Result:
    """Load a saved run, bit for bit as `simulate` returned it.

    Parameters
    ----------
    path : str or path-like
        File written by `Result.save`, by a checkpoint, or by ``transport run --save``.  The suffix gives the
        format: ``.nc`` (NetCDF-4, needs the extra ``files``) or ``.npz``.

    Returns
    -------
    Result
        The run with its scene, batches, seed, cost and warnings.  Pass it to ``simulate(scene, resume=...)``
        to continue it.

    Raises
    ------
    FileError
        If there is no such file, or it is damaged or incomplete, or a newer version wrote it.  FileError is a
        SceneError and an OSError.
    SceneError
        If the path does not end in ``.nc`` or ``.npz``.

    See Also
    --------
    merge : Merge several runs of one scene.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import transport as tp
    >>> lamp = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    >>> floor = tp.Surface(tp.Disk(center=(0, 0, -1), radius=1.0), tp.Black(), name="floor")
    >>> scene = tp.Scene(sources=[lamp], surfaces=[floor], detectors=[tp.Detector("floor")])
    >>> result = tp.simulate(scene, particles=1e4, seed=1, progress=False)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "run.npz")
    ...     result.save(path)
    ...     loaded = tp.load(path)
    >>> loaded["floor"].flux_in.value == result["floor"].flux_in.value
    True
    """
    from transport.io.runs import load

    return load(path)


@checked_keywords
def merge(*runs: Result | str | PathLike) -> Result:
    """Merge runs of the same scene into one result with the batches of all of them.

    Runs with different seeds add their particles.  Merged parts of one run (``part=(k, n)``) equal the whole
    run bit for bit.

    Parameters
    ----------
    *runs : Result, str or path-like
        At least two runs: results, or files of saved runs (``.nc`` or ``.npz``).  All must have the same
        scene, estimator, sampling and tracking.

    Returns
    -------
    Result
        The merged run.  It has a warning if batches of a part are missing, or if runs come from different
        versions of the program or different machines.

    Raises
    ------
    SceneError
        For fewer than two runs, for different scenes or settings, and for batches that two runs have in
        common.
    FileError
        If a file cannot be read, as in `load`.

    See Also
    --------
    load : Load one saved run.

    Examples
    --------
    >>> import transport as tp
    >>> lamp = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    >>> floor = tp.Surface(tp.Disk(center=(0, 0, -1), radius=1.0), tp.Black(), name="floor")
    >>> scene = tp.Scene(sources=[lamp], surfaces=[floor], detectors=[tp.Detector("floor")])
    >>> runs = [tp.simulate(scene, particles=1e4, seed=seed, progress=False) for seed in (1, 2)]
    >>> tp.merge(*runs).particles
    20000
    """
    from transport.io.merging import merge

    return merge(*runs)
