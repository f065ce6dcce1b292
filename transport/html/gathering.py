"""Many bins as the few that a small picture has room for: blocks of whole bins, each the mean of its own."""

from __future__ import annotations

import math

import numpy as np


def gathered(numbers: np.ndarray, most: tuple[int, ...]) -> tuple[np.ndarray, tuple[int, ...]]:
    """Means over blocks of bins, at most so many along each axis, and the bins that a block has along each.

    What is not a number counts for nothing; a block of such alone is none either.  The last block may be smaller.
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
    """The edges of the blocks; instants, of which there are as many as bins, stay the first of each block."""
    return np.append(edges[:bins:size], edges[bins:])
