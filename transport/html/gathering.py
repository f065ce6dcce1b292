"""Reduce many bins to the few that fit into a small picture: each block of whole bins is their mean."""

from __future__ import annotations

import math

import numpy as np


def gathered(numbers: np.ndarray, most: tuple[int, ...]) -> tuple[np.ndarray, tuple[int, ...]]:
    """Means over blocks of bins, at most `most` blocks along each axis, and the bins per block along each.

    Values that are not finite are left out; a block of only such values is nan.  The last block may be
    smaller.
    """
    sizes = tuple(math.ceil(n / m) for n, m in zip(numbers.shape, most, strict=True))
    if all(size == 1 for size in sizes):
        return numbers, sizes
    known = np.isfinite(numbers)
    total, count = np.where(known, numbers, 0.0), known.astype(float)
    for axis, size in enumerate(sizes):
        starts = np.arange(0, numbers.shape[axis], size)
        total, count = np.add.reduceat(total, starts, axis), np.add.reduceat(count, starts, axis)
    with np.errstate(invalid="ignore", divide="ignore"):
        return total / count, sizes


def gathered_edges(edges: np.ndarray, bins: int, size: int) -> np.ndarray:
    """Edges of the blocks; for instants, of which there are as many as bins, the first one of each block."""
    return np.append(edges[:bins:size], edges[bins:])
