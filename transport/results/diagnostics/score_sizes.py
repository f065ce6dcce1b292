"""A tally's scores by size, from the counts of a run.

Detectors with varying sizes, point detectors by their rows.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from transport.compile.detectors import EDGES, LARGE_SHARE
from transport.compile.layout import POINT_OCTAVES, POINT_ROWS, SIZE_CELLS
from transport.compile.points import SCALES
from transport.statistics.quality import Scores

if TYPE_CHECKING:
    from transport.results.tally import Tally


def equal_scores(number: int) -> Scores:
    """`number` scores of size 1."""
    return Scores(*np.ones((3, 1)), np.array([number]), most=1.0)


def detector_scores(tally: Tally, side: int) -> Scores | None:
    """Scores of all arrivals at a detector, or departures, in units of the largest birth weight.

    None if none was counted by size, as can happen where only some of many batches count sizes.
    """
    number = tally.number_of(tally.main[side])
    if (tally.name, side) not in tally.plan.size_blocks:
        return equal_scores(number)
    *cells, most = _size_cells(tally, tally.name, side)
    return _scores_by_size(cells, most, number)


def single_cell_scores(tally: Tally, number: int) -> Scores | None:
    """Scores of a backward run with a single cell, by radiance; None with more cells.

    number: how often histories reached sources.  Sources in volumes, Points and Beams are not counted by
    size; with one of them it is None.
    """
    adjoint = tally.plan.adjoint
    names = [lamp.detector and lamp.detector.name for lamp in adjoint.sources]
    if (
        len(adjoint.parts) > 1
        or adjoint.cells > 1
        or any((name, 0) not in tally.plan.size_blocks for name in names)
    ):
        return None
    low, high, counts, most = [], [], [], 0.0
    for name, gain in zip(names, adjoint.parts[0].gains, strict=True):
        *cells, largest = _size_cells(tally, name, 0)
        low, high, counts = [*low, gain * cells[0]], [*high, gain * cells[1]], [*counts, cells[2]]
        most = max(most, gain * largest)
    return _scores_by_size([np.concatenate(each) for each in (low, high, counts)], most, number)


def point_detector_scores(tally: Tally) -> Scores:
    """Scores of a point detector, from its rows' sums and counts in all batches."""
    score = tally.scores["weight"]
    first = score.rows.first
    weights, counts = (
        sum(column(batch, first, first + POINT_ROWS) for batch in tally.batches)
        for column in (score.column, score.counts)
    )
    low = np.ldexp(SCALES, -POINT_OCTAVES)
    return Scores(low, SCALES, np.where(counts > 0, weights / np.maximum(counts, 1), low), counts)


def count_large_scores(tally: Tally, side: int, largest: float, scores: int, block: int = 0) -> float:
    """Number of scores of at least a quarter (LARGE_SHARE) of the largest possible; all if they are alike.

    block: 0 for flights, 1 for rays, in their own unit. With guided births it is the expected number of
    scores of those that no guide has sent: each score was one with the probability of its weight.
    """
    blocks = tally.plan.size_blocks.get((tally.name, side))
    if blocks is None:
        return scores
    counts = _size_counts(tally, blocks[block])
    if block == 0 and tally.plan.is_guided:
        return float((counts * EDGES[:-1]).sum() / largest) if largest > 0 else 0.0
    return int(counts[EDGES[:-1] >= LARGE_SHARE * largest].sum())


def _size_counts(tally: Tally, first: int) -> np.ndarray:
    """Numbers of scores in the size cells of a block."""
    return sum(batch.sizes[first : first + SIZE_CELLS] for batch in tally.batches)


def _size_cells(tally: Tally, name: str, side: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Edges and counts of a detector's size cells, and the largest possible size [largest birth weight]."""
    expected = [each.scale for each in tally.plan.expectations if each.detector.name == name]
    scales = np.array([1.0, *expected])  # factors by which stored sizes are too large
    firsts = tally.plan.size_blocks[name, side][: len(scales)]
    low, high = ((edges / scales[:, None]).ravel() for edges in (EDGES[:-1], EDGES[1:]))
    counts = np.concatenate([_size_counts(tally, first) for first in firsts])
    return low, high, counts, max(1 / scales)


def _scores_by_size(cells: list[np.ndarray], most: float, number: int) -> Scores | None:
    """Scores with total `number`, from the part counted by size; None if no score was counted by size."""
    order = np.argsort(cells[0], kind="stable")
    low, high, counts = (each[order] for each in cells)
    if number > 0 and not counts.any():
        return None
    share = counts.sum() / number if number > 0 else 1.0
    return Scores(low, high, 0.5 * (low + high), counts, most, share)
