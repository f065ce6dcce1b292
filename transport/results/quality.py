"""How reliable an error bar is: how many scores carry it, how heavy their tail is, whether batches agree.

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

import numpy as np

from transport.results.estimates import Estimate
from transport.results.findings import (
    BOUNDED,
    DOUBTFUL,
    FEW_CARRIERS,
    MIN_SCORES,
    MORE,
    NOTE,
    SOUND,
    Finding,
    unknown_of_error,
)
from transport.results.scores import Scores
from transport.results.trends import outlier_of, trend_of

CHANCE = 4.0  # excess of a number of scores, in its square roots, that chance may cause
ODD, ALONE = 1e-6, 1e-8  # probabilities below which batches have a trend, or one of them is an outlier


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
        Probability that batches without a trend look so.
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
    more: str = MORE,
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
        found = advising(findings_of_error("", estimate, scores, particles), more)
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
        numbers = _numbers(estimate, scores, particles)
    return Quality(relative, merit, number, *numbers, verdict_of(estimate), estimate.findings)


def advising(findings: Iterable[Finding], more: str) -> Iterator[Finding]:
    """The findings, with `more` in place of the cure MORE."""
    return (replace(finding, cure=more) if finding.cure == MORE else finding for finding in findings)


def verdict_of(estimate: Estimate) -> str:
    """The verdict on a number, or the worst one on the bins of an array."""
    verdicts = np.atleast_1d(estimate.verdict)
    if (verdicts == DOUBTFUL).any():
        return DOUBTFUL
    return BOUNDED if (verdicts == BOUNDED).any() else SOUND


def findings_of_error(
    title: str, total: Estimate, scores: Scores | None, particles: int
) -> Iterator[Finding]:
    """Findings from the sizes of scores and from the batches, with bounds in the unit of the number.

    title: name of the detector;  total: its total.
    """
    carriers, _, slope, unseen, trend = _numbers(total, scores, particles)
    if scores is not None and scores.number >= MIN_SCORES:
        if carriers < MIN_SCORES:
            what = f"about {max(carriers, 1):.2g} of {scores.number} scores carry the error"
            bound = unknown_of_error(carriers) * total.error
            yield Finding(
                DOUBTFUL,
                title,
                "",
                what,
                bound,
                MORE,
                name=FEW_CARRIERS,
                times=MIN_SCORES / max(carriers, 1),
            )
        if unseen > 0:
            index = slope - 1
            is_infinite = index * (1 + 1 / math.sqrt(scores.tail_scores)) < 2 if index > 0 else False
            what = f"rare larger scores not sampled: the density of the largest falls as size^-{slope:.2g}"
            what += ", whose variance is infinite" if is_infinite else ""
            yield Finding(
                DOUBTFUL, title, "", what, (2 if is_infinite else 1) * unseen * total.error, MORE, name="tail"
            )
    elif scores is not None:  # `Quantity.findings` reports that
        return
    if trend < ODD:
        what = f"the batches have a trend, which chance produces once in {1 / max(trend, 1e-99):.1g} runs"
        yield Finding(DOUBTFUL, title, "", what, math.nan, MORE, name="batches")
    if outlier_of(_alike(total)) < ALONE and _is_above_chance(total, scores):
        what = "one batch is far above all others: rare histories with large scores carry the error"
        yield Finding(DOUBTFUL, title, "", what, math.nan, MORE, name="batches")


def _is_above_chance(total: Estimate, scores: Scores | None) -> bool:
    """Whether the largest batch exceeds what chance brings of the largest scores.

    One more of few is no rarity.
    """
    if scores is None:
        return True
    values = _alike(total)
    # Measure the excess in scores of the largest size.
    excess = (values.max() / values.mean() - 1) * scores.power(1) / len(values)
    return excess > CHANCE * math.sqrt(max(scores.carriers / len(values), 1.0))


def _numbers(
    total: Estimate, scores: Scores | None, particles: int
) -> tuple[float, float, float, float, float]:
    """Number of scores that carry the error, its VOV, slope of the largest, errors of unseen ones, trend."""
    trend = trend_of(_alike(total))
    vov, slope, unseen, relative = math.nan, math.nan, math.nan, total.relative_error
    if scores is not None and scores.number:
        vov, slope, unseen = _vov(scores, relative, particles), scores.slope, scores.unseen / relative
    carriers = 1 / vov if vov > 0 else math.nan
    return tuple(map(float, (carriers, vov, slope, unseen, trend)))


def _alike(estimate: Estimate) -> np.ndarray:
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
