"""How many scores of each size came: whether a few of them carry an error, and what larger ones might still bring.

Every score by itself: what one history scores several times, or its copies do, is told apart only by the batches.
Sizes are known by cells, a quarter of an octave wide or sixteen times, whose edges serve the tail and whose means the moments.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

TAIL, LEAST_TAIL, SHARE = 200, 40, 10  # scores that tell the tail: one in SHARE of all, between these limits
STEEPEST = 10.0  # slopes above it are not told apart (as in MCNP)
LEAST_INDEX, STEEPEST_INDEX = 0.05, 1000.0
NARROW = 1e-9  # the least width of a cell, as a logarithm
SURE = 700.0  # an exponent that is as good as infinite


@dataclass(frozen=True, eq=False)
class Scores:
    """Counts of scores by size.

    low, high: edges of the cells, of rising size; sizes: mean size of the scores in each; counts: how many were counted, all of
    shape (cells,);  most: the largest size that a score can have, infinite where that is not known;  share: of all scores,
    that were counted by size.
    """

    low: np.ndarray
    high: np.ndarray
    sizes: np.ndarray
    counts: np.ndarray
    most: float = math.inf
    share: float = 1.0

    @property
    def number(self) -> int:
        """How many scores there are."""
        return round(self.counts.sum() / self.share)

    def power(self, exponent: int) -> float:
        """The sum of s^exponent over all scores, in units of the largest that came."""
        return float((self.counts * self._relative**exponent).sum()) / self.share

    @cached_property
    def carriers(self) -> float:
        """About how many scores s carry the error, (sum of s^2)^2 / sum of s^4; 0 without any.

        One over the squared relative error of the error itself, for many scores.
        """
        return self.power(2) ** 2 / self.power(4) if self.number else 0.0

    def vov(self, histories: int) -> float:
        """Variance of the variance, sum (x - m)^4 / (sum (x - m)^2)^2 - 1/N, as if each history scored once at most."""
        many = max(histories, self.number)
        mean = self.power(1) / many
        idle = many - self.number
        second, fourth = (
            float((self.counts * (self._relative - mean) ** k).sum()) / self.share + idle * mean**k
            for k in (2, 4)
        )
        return fourth / second**2 - 1 / many if second > 0 else 0.0

    def variance(self, histories: int) -> float:
        """Variance of the sum, were each score a history's only one; in squared units of the largest that came."""
        return max(self.power(2) - self.power(1) ** 2 / max(histories, self.number), 0.0)

    @property
    def slope(self) -> float:
        """Slope of the density of the largest scores, size^-slope: up to 3 the variance of such a law is infinite.

        Pickands 1975; Booth and others in MCNP's manual want it above 3.  Nan where there are too few to tell.
        """
        return min(1.0 + self.tail_index, STEEPEST)

    @cached_property
    def tail_index(self) -> float:
        """The index of Pareto's law that suits the largest scores best: above a size s are s^-index of them.

        Maximum likelihood for counts in cells (Hill 1975 for sizes); nan for less than LEAST_TAIL scores.
        """
        first, number = self._tail
        if number < LEAST_TAIL:
            return math.nan
        among = np.flatnonzero(self.counts[first:]) + first
        low, high = (np.log(edges[among] / self.low[first]) for edges in (self.low, self.high))
        counts, width = self.counts[among], np.maximum(high - low, NARROW)
        lowest, highest = math.log(LEAST_INDEX), math.log(STEEPEST_INDEX)
        for _ in range(40):  # the derivative of the likelihood falls through 0 once
            index = math.exp(0.5 * (lowest + highest))
            slope = (counts * (width / np.expm1(np.minimum(index * width, SURE)) - low)).sum()
            lowest, highest = (math.log(index), highest) if slope > 0 else (lowest, math.log(index))
        return index

    @property
    def tail_scores(self) -> int:
        """How many scores told that index."""
        return self._tail[1]

    @property
    def unseen(self) -> float:
        """About what scores larger than all that came would bring, did the law of the largest go on: a share of the sum."""
        first, number = self._tail
        index = self.tail_index
        if not index > 0 or self.most <= self._largest:
            return 0.0
        # What has come and was not counted is larger by as much as the law has it.
        top = min(self._largest * self.share ** (-1 / index), self.most)
        reach = math.log(self.most / top)
        gain = 1.0 - index  # the integral of s^-index from the largest that came to the largest that can
        if math.isinf(reach):
            grown = math.inf if gain >= 0 else -1.0 / gain
        else:
            grown = math.expm1(gain * reach) / gain if abs(gain * reach) > 1e-9 else reach
        # Of more than one of them some would have come: then the law ends before.
        beyond = min(number / self.share * (self.low[first] / top) ** index, 1.0)
        return beyond * index * grown * top / self.sizes[self._top] / self.power(1)

    @cached_property
    def _top(self) -> int:
        """The cell of the largest score."""
        return int(np.flatnonzero(self.counts)[-1])

    @property
    def _largest(self) -> float:
        """The largest score, as far as that is known."""
        top = self._top
        return float(min(self.high[top], self.counts[top] * self.sizes[top]))

    @cached_property
    def _relative(self) -> np.ndarray:
        """Sizes over the largest that came; 0 where none came."""
        if not self.number:
            return np.zeros(len(self.sizes))
        return np.where(self.counts > 0, self.sizes, 0.0) / self.sizes[self._top]

    @cached_property
    def _tail(self) -> tuple[int, int]:
        """The first cell of the tail, and how many scores are in it."""
        above = np.cumsum(self.counts[::-1])[::-1]
        wanted = min(max(above[0] // SHARE, LEAST_TAIL), TAIL)
        first = int(np.flatnonzero(above >= wanted)[-1]) if above[0] >= wanted else 0
        return first, int(above[first])
