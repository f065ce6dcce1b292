"""Error bars as printed: a single number's from its own batches, a bin's with the help of neighbouring bins.

Batches, their correlations and sums over bins stay unchanged; see pooling.py.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce

import numpy as np

from transport.statistics.axes import CELL, COORDINATES, DIRECTION, PHASE, POSITION
from transport.statistics.batches import MIN_SCORES_FOR_ERROR, standard_error, welch_dof
from transport.statistics.chunked import empty_memmap, release_pages
from transport.statistics.pooling import Pooled, covers_circle, pooled_errors
from transport.statistics.replicates import Replicates

POOLED_AXES = tuple(
    name for name, each in COORDINATES.items() if each.group in (POSITION, DIRECTION, CELL, PHASE)
)


def error_bars_of(
    replicates: Replicates, coords: Mapping[str, np.ndarray], units: Mapping[str, str]
) -> Pooled:
    """Return the error bar of each bin, its degrees of freedom, and whether it is doubtful.

    Parameters
    ----------
    replicates : Replicates
        Of bins (*dims).  Chunked replicates are pooled within each chunk.
    coords : mapping of str to ndarray
        Edges of the bins along each axis, in the order of `dims`.
    units : mapping of str to str
        Units of the axes; an axis in rad that covers the circle is periodic.

    Returns
    -------
    Pooled
        Read-only arrays (*dims).
    """
    axes = [axis for axis, name in enumerate(coords) if name in POOLED_AXES]
    periodic = [
        axis
        for axis, (name, edges) in enumerate(coords.items())
        if axis in axes and units.get(name) == "rad" and covers_circle(edges)
    ]
    if not replicates.is_chunked:
        return _read_only(_bin_error_bars(replicates, axes, periodic))
    # Pool each chunk by itself; an axis that a chunk cuts is not periodic in it.
    kinds = (float, float, bool)
    rooms = Pooled(*(empty_memmap(replicates.shape, kind) for kind in kinds))
    for box in replicates.boxes:
        whole = [axis for axis in periodic if _is_whole(box[axis], replicates.shape[axis])]
        for room, numbers in zip(rooms, _bin_error_bars(replicates.part(box), axes, whole), strict=True):
            room[box] = numbers
            release_pages(room)
    return _read_only(rooms)


def _bin_error_bars(replicates: Replicates, axes: list[int], periodic: list[int]) -> Pooled:
    """Error bars of bins that are computed at once."""
    is_known, scores = np.equal(replicates.reason, None), replicates.scores
    has_few = (scores > 0) & (scores < MIN_SCORES_FOR_ERROR) if replicates.shape else np.zeros((), dtype=bool)
    found = []
    for run, deviations in replicates.deviations.items() if axes else ():
        spread = np.abs(deviations).max(axis=0)
        pooled = pooled_errors(deviations, run.sizes, is_known & (spread > 0), axes, periodic)
        if pooled is None:  # too few batches: use the run's own errors beside those of other runs
            own = np.where(is_known, standard_error(deviations, run.sizes), np.nan)
            pooled = Pooled(own, np.full(own.shape, len(run) - 1.0), has_few)
        found.append(pooled)
    if not found:
        return Pooled(replicates.error, replicates.dof, is_known & has_few)
    errors = [np.where(is_known, np.nan_to_num(each.error), np.nan) for each in found]
    dof = found[0].dof
    if len(found) > 1:
        with np.errstate(invalid="ignore"):
            dof = np.where(is_known, welch_dof(errors, [each.dof for each in found]), replicates.dof)
    doubtful = is_known & reduce(np.logical_or, [each.is_doubtful for each in found])
    return Pooled(reduce(np.hypot, errors), dof, doubtful)


def _is_whole(along: slice, count: int) -> bool:
    return along.indices(count)[:2] == (0, count)


def _read_only(bars: Pooled) -> Pooled:
    bars = Pooled(*(each if isinstance(each, np.ndarray) else np.array(each) for each in bars))
    for each in bars:
        each.flags.writeable = False
    return bars
