"""A detector's scores by size, from what a run counted: of meters where sizes differ, of point detectors by their rows."""

from __future__ import annotations

import math

import numpy as np

from transport.compile.layout import POINT_OCTAVES, SIZE_CELLS
from transport.compile.points import SCALES
from transport.compile.sizes import EDGES
from transport.results.meter_sums import MeterSums
from transport.results.scores import Scores


def scores_of_meter(sums: MeterSums, side: int) -> Scores:
    """Of all that arrived at a detector, or left from it, in units of the largest weight at birth."""
    plan = sums.plan
    if (sums.detector.name, side) not in plan.size_blocks:
        return Scores(*np.ones((3, 1)), sums.whole("counts", side).sum(keepdims=True).ravel(), most=1.0)
    expected = [each.scale for each in plan.expectations if each.detector.name == sums.detector.name]
    scales = np.array([1.0, *expected])  # by which sizes are too large
    firsts = plan.size_blocks[sums.detector.name, side][: len(scales)]
    low, high = ((edges / scales[:, None]).ravel() for edges in (EDGES[:-1], EDGES[1:]))
    counts = np.concatenate([sum(batch.sizes[k : k + SIZE_CELLS] for batch in sums.batches) for k in firsts])
    order = np.argsort(low, kind="stable")
    low, high, counts = low[order], high[order], counts[order]
    return Scores(low, high, 0.5 * (low + high), counts, most=math.inf if expected else 1.0)


def scores_of_point(weights: np.ndarray, counts: np.ndarray) -> Scores:
    """Of a point detector, from the sums and counts of its rows in all batches, (POINT_ROWS,)."""
    low = np.ldexp(SCALES, -POINT_OCTAVES)
    return Scores(low, SCALES, np.where(counts > 0, weights / np.maximum(counts, 1), low), counts)
