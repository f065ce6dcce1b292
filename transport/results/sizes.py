"""A reading's scores by size, from what a run counted: of meters where sizes differ, of point detectors by their rows."""

from __future__ import annotations

import numpy as np

from transport.compile.layout import POINT_OCTAVES, SIZE_CELLS
from transport.compile.plan import Plan
from transport.compile.points import SCALES
from transport.compile.sizes import EDGES
from transport.results.batches import Batch
from transport.results.meter_sums import ARRIVALS, MeterSums
from transport.results.scores import Scores


def scores_alike(number: int) -> Scores:
    """So many scores of one size, which is 1."""
    return Scores(*np.ones((3, 1)), np.array([number]), most=1.0)


def scores_of_meter(sums: MeterSums, side: int) -> Scores | None:
    """Of all that arrived at a detector, or left from it, in units of the largest weight at birth.

    None where they were not counted by size: where few batches of many count them, a run may have none of these.
    """
    plan, number = sums.plan, int(sums.whole("counts", side).sum())
    if (sums.detector.name, side) not in plan.size_blocks:
        return scores_alike(number)
    *cells, most = _counted(plan, sums.batches, sums.detector.name, side)
    return _sorted(cells, most, number)


def scores_of_cell(plan: Plan, batches: list[Batch], number: int) -> Scores | None:
    """Of what a run backwards brought to its only cell, by the radiance that each brought; None where there are more.

    number: how often sources were met.  Sources in volumes are not counted by size: with one of them it is None as well.
    """
    turned = plan.turned
    names = [lamp.seen_by.name for lamp in turned.lamps]
    if (
        len(turned.parts) > 1
        or turned.cells > 1
        or any((name, ARRIVALS) not in plan.size_blocks for name in names)
    ):
        return None
    low, high, counts, most = [], [], [], 0.0
    for name, gain in zip(names, turned.parts[0].gains, strict=True):
        *cells, largest = _counted(plan, batches, name, ARRIVALS)
        low, high, counts = [*low, gain * cells[0]], [*high, gain * cells[1]], [*counts, cells[2]]
        most = max(most, gain * largest)
    return _sorted([np.concatenate(each) for each in (low, high, counts)], most, number)


def scores_of_point(weights: np.ndarray, counts: np.ndarray) -> Scores:
    """Of a point detector, from the sums and counts of its rows in all batches, (POINT_ROWS,)."""
    low = np.ldexp(SCALES, -POINT_OCTAVES)
    return Scores(low, SCALES, np.where(counts > 0, weights / np.maximum(counts, 1), low), counts)


def _counted(
    plan: Plan, batches: list[Batch], name: str, side: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Edges and counts of the cells of a detector, and the largest size that there can be [largest birth weight]."""
    expected = [each.scale for each in plan.expectations if each.detector.name == name]
    scales = np.array([1.0, *expected])  # by which sizes are too large
    firsts = plan.size_blocks[name, side][: len(scales)]
    low, high = ((edges / scales[:, None]).ravel() for edges in (EDGES[:-1], EDGES[1:]))
    counts = np.concatenate([sum(batch.sizes[k : k + SIZE_CELLS] for batch in batches) for k in firsts])
    return low, high, counts, max(1 / scales)


def _sorted(cells: list[np.ndarray], most: float, number: int) -> Scores | None:
    """Scores, of which there are so many, from some that were counted by size; None where none of them was."""
    order = np.argsort(cells[0], kind="stable")
    low, high, counts = (each[order] for each in cells)
    if number > 0 and not counts.any():
        return None
    share = counts.sum() / number if number > 0 else 1.0
    return Scores(low, high, 0.5 * (low + high), counts, most, share)
