"""Reliability of an error bar: number of scores that carry it, weight of their tail, agreement of batches.

An error measures the spread of the scores in hand.  If rare large scores are still missing, mean and error
are both too low.  The present scores show it: a few of them carry the error, or the largest thin out so
slowly that one more of them would be larger than the error.  The tests follow MCNP's ten checks (X-5 Monte
Carlo Team 2003, 2.VI), as far as these are independent of each other.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from transport.statistics.batches import MIN_SCORES_FOR_ERROR, outlier_probability, trend_probability
from transport.statistics.estimates import Estimate
from transport.statistics.findings import (
    BOUNDED,
    DOUBTFUL,
    FEW_CARRIERS,
    MORE_PARTICLES,
    NOTE,
    SOUND,
    Finding,
    doubtful,
    error_uncertainty,
)

# ---- Counts of scores by size: whether a few of them carry an error, and what larger ones might add.
#
# Every score counts by itself; several scores of one history, or of its copies, show only in the batches.
# Sizes are known by cells, a quarter of an octave or sixteen times as wide; their edges give the tail and
# their means the moments.

# Scores in the tail: one in TAIL_SHARE of all, between these limits.
MAX_TAIL_SCORES, MIN_TAIL_SCORES, TAIL_SHARE = 200, 40, 10
MAX_SLOPE = 10.0  # slopes above it are not distinguished (as in MCNP)
MIN_TAIL_INDEX, MAX_TAIL_INDEX = 0.05, 1000.0
MIN_CELL_WIDTH = 1e-9  # least width of a cell, as a logarithm
MAX_EXPONENT = 700.0  # an exponent that is practically infinite


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
        return min(1.0 + self.tail_index, MAX_SLOPE)

    @cached_property
    def tail_index(self) -> float:
        """Index of Pareto's law that fits the largest scores best: s^-index of them are above a size s.

        Maximum likelihood for counts in cells (Hill 1975 for sizes); nan below MIN_TAIL_SCORES scores.
        """
        first, number = self._tail
        if number < MIN_TAIL_SCORES:
            return math.nan
        among = np.flatnonzero(self.counts[first:]) + first
        low, high = (np.log(edges[among] / self.low[first]) for edges in (self.low, self.high))
        counts, width = self.counts[among], np.maximum(high - low, MIN_CELL_WIDTH)
        lowest, highest = math.log(MIN_TAIL_INDEX), math.log(MAX_TAIL_INDEX)
        for _ in range(40):  # bisect: the derivative of the likelihood crosses 0 once
            index = math.exp(0.5 * (lowest + highest))
            slope = (counts * (width / np.expm1(np.minimum(index * width, MAX_EXPONENT)) - low)).sum()
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
        return beyond * index * grown * top / self.sizes[self._largest_cell] / self.power(1)

    @cached_property
    def _largest_cell(self) -> int:
        """Index of the cell with the largest score."""
        return int(np.flatnonzero(self.counts)[-1])

    @property
    def _largest(self) -> float:
        """The largest score, as far as known."""
        top = self._largest_cell
        return float(min(self.high[top], self.counts[top] * self.sizes[top]))

    @cached_property
    def _relative(self) -> np.ndarray:
        """Sizes relative to the largest present score; 0 in empty cells."""
        if not self.number:
            return np.zeros(len(self.sizes))
        return np.where(self.counts > 0, self.sizes, 0.0) / self.sizes[self._largest_cell]

    @cached_property
    def _tail(self) -> tuple[int, int]:
        """Index of the first cell of the tail, and its number of scores."""
        above = np.cumsum(self.counts[::-1])[::-1]
        wanted = min(max(above[0] // TAIL_SHARE, MIN_TAIL_SCORES), MAX_TAIL_SCORES)
        first = int(np.flatnonzero(above >= wanted)[-1]) if above[0] >= wanted else 0
        return first, int(above[first])


# ---- The quality of a number.

MAX_CHANCE_EXCESS = 4.0  # excess of a number of scores, in its square roots, that chance may cause
# Probabilities below which batches have a trend, or one of them is an outlier.
TREND_CHANCE, OUTLIER_CHANCE = 1e-6, 1e-8


@dataclass(frozen=True)
class Quality:
    """Quality of the error bar of a quantity.

    Fields are nan if they are not known, and have shape (*dims) for a quantity with bins if they differ by
    bin.

    Parameters
    ----------
    relative_error : float or numpy.ndarray
        One standard error divided by the value.
    figure_of_merit : float or numpy.ndarray
        1 / (relative error² × seconds) [s^-1]; constant while a run continues.
    scores : int or None
        Number of scores; None if they are not counted.
    carriers : float
        Approximate number of independent scores that carry the error, 1/VOV.
    vov : float
        Variance of the variance (VOV); 1/N for sums of N normal numbers; should be below 0.1.
    tail_slope : float
        Slope of the density of the largest scores, size^-slope; should be above 3, at most 10; nan if all
        scores are equal or too few.
    unseen : float
        Standard errors that scores larger than all present ones would add if the law of the largest
        continues.
    trend : float
        Probability that batches without a trend give such a one.
    verdict : {"sound", "bounded", "doubtful"}
        Verdict on the quantity; the worst one of its bins.
    findings : tuple of Finding
        What the run may have missed, the worst first.
    """

    relative_error: float
    figure_of_merit: float
    scores: int | None
    carriers: float
    vov: float
    tail_slope: float
    unseen: float
    trend: float
    verdict: str
    findings: tuple[Finding, ...] = ()

    @property
    def is_sound(self) -> bool:
        """Whether the verdict is "sound".

        Returns
        -------
        bool
        """
        return self.verdict == SOUND

    @property
    def doubts(self) -> tuple[str, ...]:
        """Texts of the findings against the error bar.

        Returns
        -------
        tuple of str
        """
        return tuple(finding.what for finding in self.findings if finding.severity != NOTE)

    def __str__(self) -> str:
        scores = "unknown" if self.scores is None else self.scores
        if np.ndim(self.relative_error):
            relative, merit = (_median(each) for each in (self.relative_error, self.figure_of_merit))
            return (
                f"medians: relative error {relative:.2g}, figure of merit {merit:.3g} s^-1:"
                f" {'; '.join((self.verdict, *self.doubts))}"
            )
        numbers = (
            f"relative error {self.relative_error:.2g}, figure of merit {self.figure_of_merit:.3g} s^-1,"
            f" scores {scores}, VOV {self.vov:.2g}, slope {self.tail_slope:.2g}, unseen {self.unseen:.2g}"
            f" errors, trend p = {self.trend:.2g}"
        )
        return f"{numbers}: {'; '.join((self.verdict, *self.doubts))}"


def _median(values: float | np.ndarray) -> float:
    known = np.ravel(values)[~np.isnan(np.ravel(values))]
    return float(np.median(known)) if known.size else math.nan


def quality_of(
    estimate: Estimate,
    scores: Scores | None = None,
    particles: int = 0,
    seconds: float = math.nan,
    more: str = MORE_PARTICLES,
) -> Quality:
    """Quality of an estimate of one run.

    scores: the scores by size, None if that is not known;  particles: histories of the run, which give the
    number without a score;  more: the cure of a doubtful number.
    """
    relative = estimate.relative_error
    is_known = np.ndim(relative) == 0 and 0 < relative < math.inf
    if is_known and scores is not None:
        known = estimate._raw_findings
        names = {each.name for each in known}
        found = with_cure(findings_of_error(estimate, scores, particles), more)
        more_found = (*known, *(each for each in found if each.name not in names))
        estimate = copy(estimate)._with_findings(more_found, estimate.allowed)
    if np.ndim(relative):
        with np.errstate(divide="ignore"):
            merit = 1 / (relative**2 * seconds)
        return Quality(relative, merit, None, *(math.nan,) * 5, verdict_of(estimate), estimate.findings)
    merit = 1 / (relative**2 * seconds) if relative > 0 else math.inf if relative == 0 else math.nan
    number = None if scores is None else scores.number
    numbers = (math.nan,) * 5
    if is_known and estimate.run is not None:
        numbers = _score_statistics(estimate, scores, particles)
    return Quality(relative, merit, number, *numbers, verdict_of(estimate), estimate.findings)


def with_cure(findings: Iterable[Finding], more: str) -> Iterator[Finding]:
    """The findings, with `more` in place of the cure MORE_PARTICLES."""
    return (
        replace(finding, cure=more) if finding.cure == MORE_PARTICLES else finding for finding in findings
    )


def verdict_of(estimate: Estimate) -> str:
    """The verdict on a number, or the worst one on the bins of an array."""
    verdicts = np.atleast_1d(estimate.verdict)
    if (verdicts == DOUBTFUL).any():
        return DOUBTFUL
    return BOUNDED if (verdicts == BOUNDED).any() else SOUND


def findings_of_error(total: Estimate, scores: Scores | None, particles: int) -> Iterator[Finding]:
    """Findings about a total from the sizes of its scores and from its batches, with bounds in its unit."""
    carriers, _, slope, unseen, trend = _score_statistics(total, scores, particles)
    if scores is not None and scores.number < MIN_SCORES_FOR_ERROR:
        return  # `AnyEstimate.findings` reports that
    if scores is not None and carriers < MIN_SCORES_FOR_ERROR:
        what = f"about {max(carriers, 1):.2g} of {scores.number} scores carry the error"
        bound, times = error_uncertainty(carriers) * total.error, MIN_SCORES_FOR_ERROR / max(carriers, 1)
        yield doubtful(FEW_CARRIERS, what, bound, MORE_PARTICLES, times=times)
    if scores is not None and unseen > 0:
        index = slope - 1
        is_infinite = index * (1 + 1 / math.sqrt(scores.tail_scores)) < 2 if index > 0 else False
        what = f"rare larger scores not sampled: the density of the largest falls as size^-{slope:.2g}"
        what += ", whose variance is infinite" if is_infinite else ""
        yield doubtful("tail", what, (2 if is_infinite else 1) * unseen * total.error, MORE_PARTICLES)
    if trend < TREND_CHANCE:
        what = f"the batches have a trend, which chance produces once in {1 / max(trend, 1e-99):.1g} runs"
        yield doubtful("batches", what, cure=MORE_PARTICLES)
    if outlier_probability(_comparable_batches(total)) < OUTLIER_CHANCE and _is_above_chance(total, scores):
        what = "one batch is far above all others: rare histories with large scores carry the error"
        yield doubtful("batches", what, cure=MORE_PARTICLES)


def _is_above_chance(total: Estimate, scores: Scores | None) -> bool:
    """Return whether the largest batch exceeds what chance brings of the largest scores.

    One more of few is no rarity.
    """
    if scores is None:
        return True
    values = _comparable_batches(total)
    # Measure the excess in scores of the largest size.
    excess = (values.max() / values.mean() - 1) * scores.power(1) / len(values)
    return excess > MAX_CHANCE_EXCESS * math.sqrt(max(scores.carriers / len(values), 1.0))


def _score_statistics(
    total: Estimate, scores: Scores | None, particles: int
) -> tuple[float, float, float, float, float]:
    """Number of scores that carry the error, its VOV, slope of the largest, errors of unseen ones, trend."""
    trend = trend_probability(_comparable_batches(total))
    vov, slope, unseen, relative = math.nan, math.nan, math.nan, total.relative_error
    if scores is not None and scores.number:
        vov, slope, unseen = _vov(scores, relative, particles), scores.slope, scores.unseen / relative
    carriers = 1 / vov if vov > 0 else math.nan
    return tuple(map(float, (carriers, vov, slope, unseen, trend)))


def _comparable_batches(estimate: Estimate) -> np.ndarray:
    """Values of the batches, without batches much smaller than the others."""
    sizes = estimate.run.sizes
    return estimate.values[2 * sizes > np.median(sizes)]


def _vov(scores: Scores, relative: float, particles: int) -> float:
    """Variance of the variance of the histories' scores: that of single scores, times how many come together.

    The variance among batches over that of single scores gives how many come together.  If nearly every
    history scores the same, the other histories carry the error.
    """
    among = (relative * scores.power(1)) ** 2
    if among > 0.5 * scores.power(2):
        return max(among / scores.power(2), 1.0) / scores.carriers
    single = scores.variance(particles)
    return max(among / single, 1.0) * scores.vov(particles) if single > 0 else math.nan
