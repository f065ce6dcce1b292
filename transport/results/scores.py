"""Counts of scores by size: whether a few of them carry an error, and what larger ones might add.

Every score counts by itself; several scores of one history, or of its copies, show only in the batches.
Sizes are known by cells, a quarter of an octave or sixteen times as wide; their edges give the tail and their
means the moments.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

TAIL, LEAST_TAIL, SHARE = 200, 40, 10  # scores in the tail: one in SHARE of all, between these limits
STEEPEST = 10.0  # slopes above it are not distinguished (as in MCNP)
LEAST_INDEX, STEEPEST_INDEX = 0.05, 1000.0
NARROW = 1e-9  # least width of a cell, as a logarithm
SURE = 700.0  # an exponent that is practically infinite


@dataclass(frozen=True, eq=False)
class Scores:
    """Counts of scores by size.

    low, high: edges of the cells, by ascending size;  sizes: mean size of the scores in each;  counts: their
    numbers, all of shape (cells,);  most: largest possible size, infinite if unknown;  share: of all scores,
    the part that was counted by size.
    """

    low: np.ndarray
    high: np.ndarray
    sizes: np.ndarray
    counts: np.ndarray
    most: float = math.inf
    share: float = 1.0

    @property
    def number(self) -> int:
        """Number of scores."""
        return round(self.counts.sum() / self.share)

    def power(self, exponent: int) -> float:
        """Sum of s^exponent over all scores, in units of the largest present score."""
        return float((self.counts * self._relative**exponent).sum()) / self.share

    @cached_property
    def carriers(self) -> float:
        """Approximate number of scores s that carry the error, (sum of s^2)^2 / sum of s^4; 0 without scores.

        It is one over the squared relative error of the error itself, for many scores.
        """
        return self.power(2) ** 2 / self.power(4) if self.number else 0.0

    def vov(self, histories: int) -> float:
        """Variance of the variance, sum (x - m)^4 / (sum (x - m)^2)^2 - 1/N, with one score per history."""
        many = max(histories, self.number)
        mean = self.power(1) / many
        idle = many - self.number
        second, fourth = (
            float((self.counts * (self._relative - mean) ** k).sum()) / self.share + idle * mean**k
            for k in (2, 4)
        )
        return fourth / second**2 - 1 / many if second > 0 else 0.0

    def variance(self, histories: int) -> float:
        """Variance of the sum for at most one score per history, in squared units of the largest score."""
        return max(self.power(2) - self.power(1) ** 2 / max(histories, self.number), 0.0)

    @property
    def slope(self) -> float:
        """Slope of the density of the largest scores, size^-slope; up to 3 its variance is infinite.

        Pickands 1975; MCNP's manual (Booth and others) requires a slope above 3.  nan with too few scores.
        """
        return min(1.0 + self.tail_index, STEEPEST)

    @cached_property
    def tail_index(self) -> float:
        """Index of Pareto's law that fits the largest scores best: s^-index of them are above a size s.

        Maximum likelihood for counts in cells (Hill 1975 for sizes); nan for fewer than LEAST_TAIL scores.
        """
        first, number = self._tail
        if number < LEAST_TAIL:
            return math.nan
        among = np.flatnonzero(self.counts[first:]) + first
        low, high = (np.log(edges[among] / self.low[first]) for edges in (self.low, self.high))
        counts, width = self.counts[among], np.maximum(high - low, NARROW)
        lowest, highest = math.log(LEAST_INDEX), math.log(STEEPEST_INDEX)
        for _ in range(40):  # bisect: the derivative of the likelihood crosses 0 once
            index = math.exp(0.5 * (lowest + highest))
            slope = (counts * (width / np.expm1(np.minimum(index * width, SURE)) - low)).sum()
            lowest, highest = (math.log(index), highest) if slope > 0 else (lowest, math.log(index))
        return index

    @property
    def tail_scores(self) -> int:
        """Number of scores that determine the index."""
        return self._tail[1]

    @property
    def unseen(self) -> float:
        """Share of the sum that scores above all present ones would add by the law of the largest."""
        first, number = self._tail
        index = self.tail_index
        if not index > 0 or self.most <= self._largest:
            return 0.0
        # A present but uncounted score may be larger, by as much as the law gives.
        top = min(self._largest * self.share ** (-1 / index), self.most)
        reach = math.log(self.most / top)
        gain = 1.0 - index  # of s^-index, integrated from the largest present to the largest possible size
        if math.isinf(reach):
            grown = math.inf if gain >= 0 else -1.0 / gain
        else:
            grown = math.expm1(gain * reach) / gain if abs(gain * reach) > 1e-9 else reach
        # Of more than one such score some would be present: limit their number to one.
        beyond = min(number / self.share * (self.low[first] / top) ** index, 1.0)
        return beyond * index * grown * top / self.sizes[self._top] / self.power(1)

    @cached_property
    def _top(self) -> int:
        """Index of the cell with the largest score."""
        return int(np.flatnonzero(self.counts)[-1])

    @property
    def _largest(self) -> float:
        """The largest score, as far as known."""
        top = self._top
        return float(min(self.high[top], self.counts[top] * self.sizes[top]))

    @cached_property
    def _relative(self) -> np.ndarray:
        """Sizes relative to the largest present score; 0 in empty cells."""
        if not self.number:
            return np.zeros(len(self.sizes))
        return np.where(self.counts > 0, self.sizes, 0.0) / self.sizes[self._top]

    @cached_property
    def _tail(self) -> tuple[int, int]:
        """Index of the first cell of the tail, and its number of scores."""
        above = np.cumsum(self.counts[::-1])[::-1]
        wanted = min(max(above[0] // SHARE, LEAST_TAIL), TAIL)
        first = int(np.flatnonzero(above >= wanted)[-1]) if above[0] >= wanted else 0
        return first, int(above[first])
