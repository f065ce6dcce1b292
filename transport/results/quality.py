"""How far an error bar is to be trusted: how many scores carry it, how heavy their tail is, whether batches agree.

An error tells the spread of what came.  Where rare large scores have not come yet, mean and error are both too low, and the
error does not know.  What did come betrays it: a few scores carry the error, or the largest thin out so slowly that one more of
them would be larger than the error.  These are MCNP's ten checks (X-5 Monte Carlo Team 2003, 2.VI), in as far as they are not
each other's consequence.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from transport.results.estimates import Estimate
from transport.results.scores import Scores
from transport.results.trends import outlier_of, trend_of

FEW = 5.0  # scores that may carry an error: its variance's variance is then 0.2; MCNP wants 0.1, at more false alarms
UNSEEN, INFINITE = 1.0, 0.5  # standard errors that larger scores may bring; where their variance is infinite
LONE = 3.0  # that one score of a size that is possible may bring, as in survivors.py
ODD, ALONE = 1e-6, 1e-8  # probabilities below which batches have a trend, or one of them stands alone


@dataclass(frozen=True)
class Quality:
    """The quality of one number's error bar; nan for what is not known.

    relative_error: one standard error over the value;  figure_of_merit: 1/(relative error^2 seconds) [s^-1], constant while a run
    goes on;  scores: how many there are, None where they are not counted;  carriers: about how many independent ones carry the error, 1/VOV;  vov: variance of
    the variance, 1/N for normal sums, below 0.1 wanted;  tail_slope: of the density of the largest scores, size^-slope, above 3
    wanted, at most 10, nan where all are alike or too few;  unseen: standard errors that larger scores than all that came would bring if
    the law of the largest goes on;  trend: probability that batches without a trend would look so;  doubts: what speaks against
    the error bar, in words.
    """

    relative_error: float
    figure_of_merit: float
    scores: int | None
    carriers: float
    vov: float
    tail_slope: float
    unseen: float
    trend: float
    doubts: tuple[str, ...] = ()

    @property
    def is_sound(self) -> bool:
        """Whether nothing speaks against the error bar."""
        return not self.doubts

    def __str__(self) -> str:
        scores = "unknown" if self.scores is None else self.scores
        numbers = (
            f"relative error {self.relative_error:.2g}, figure of merit {self.figure_of_merit:.3g} s^-1, scores {scores},"
            f" VOV {self.vov:.2g}, slope {self.tail_slope:.2g}, unseen {self.unseen:.2g} errors, trend p = {self.trend:.2g}"
        )
        return f"{numbers}: {'; '.join(self.doubts) or 'sound'}"


def quality_of(
    estimate: Estimate, scores: Scores | None = None, particles: int = 0, seconds: float = math.nan
) -> Quality:
    """The quality of an estimate of one run.

    scores: how many there are of each size, None where that is not known;  particles: histories of the run, by which
    it is told how many did not score.  What is exact is not doubted; a value without a score, or of unknown error, is.
    """
    relative = estimate.relative_error
    merit = 1 / (relative**2 * seconds) if relative > 0 else math.inf if relative == 0 else math.nan
    if not 0 < relative < math.inf or estimate.run is None:
        number = None if scores is None else scores.number
        return Quality(relative, merit, number, *(math.nan,) * 5, _of_unknown(estimate))
    values = _alike(estimate)
    trend, alone = trend_of(values), outlier_of(values)
    number = None if scores is None else scores.number
    vov, slope, unseen = math.nan, math.nan, math.nan
    if scores is not None and scores.number:
        slope = scores.slope
        vov = _vov(scores, relative, particles)
        unseen = scores.unseen / relative
    carriers = 1 / vov if vov > 0 else math.nan
    lone = scores.lone / relative if scores is not None else 0.0
    doubts = _doubts(scores, carriers, slope, unseen, lone, trend, alone)
    numbers = map(float, (carriers, vov, slope, unseen, trend))
    return Quality(relative, merit, number, *numbers, tuple(doubts))


def _of_unknown(estimate: Estimate) -> tuple[str, ...]:
    """What speaks against an error that is not a finite number."""
    if math.isfinite(estimate.error):
        return ()
    if estimate.reason == "no score":
        return ("no score, so the value is unknown, not 0",)
    return (f"the error is unknown: {estimate.reason or 'not finite'}",)


def _alike(estimate: Estimate) -> np.ndarray:
    """What the batches gave, without those that are much smaller than the others."""
    sizes = estimate.run.sizes
    return estimate.values[2 * sizes > np.median(sizes)]


def _vov(scores: Scores, relative: float, particles: int) -> float:
    """Variance of the variance of what histories score: that of single scores, times how many of them come together.

    How many come together is told by the variance among batches over that of single scores.  Where nearly every history
    scores alike it is the others that carry the error.
    """
    among = (relative * scores.power(1)) ** 2
    if among > 0.5 * scores.power(2):
        return max(among / scores.power(2), 1.0) / scores.carriers
    single = scores.variance(particles)
    return max(among / single, 1.0) * scores.vov(particles) if single > 0 else math.nan


def _doubts(
    scores: Scores | None,
    carriers: float,
    slope: float,
    unseen: float,
    lone: float,
    trend: float,
    alone: float,
) -> list[str]:
    """What speaks against an error bar, the worst first."""
    doubts = []
    if carriers < FEW:
        doubts.append(_of_few(scores, carriers))
    index = slope - 1
    is_infinite = index * (1 + 1 / math.sqrt(scores.tail_scores)) < 2 if scores and index > 0 else False
    if unseen > UNSEEN or (is_infinite and unseen > INFINITE):
        law = f"the largest scores thin out as size^-{slope:.2g}"
        law += ", whose variance is infinite" if is_infinite else ""
        doubts.append(
            f"{law}: larger ones that have not come yet may bring {unseen:.2g} standard errors more"
        )
    if lone > LONE:
        doubts.append(
            "the heaviest that an aim gave birth to have not scored, and one of them would bring"
            f" {lone:.2g} standard errors"
        )
    if trend < ODD and not doubts:
        doubts.append(
            f"the batches have a trend, which chance makes once in {1 / max(trend, 1e-99):.1g} runs"
        )
    if alone < ALONE and not doubts:
        doubts.append("one batch is far above all others: rare histories that score much carry the error")
    return doubts


def _of_few(scores: Scores, carriers: float) -> str:
    """How few scores there are, or how few of them carry the error."""
    if scores.number < FEW:
        return f"only {scores.number} score{'s' if scores.number > 1 else ''} came"
    return f"about {max(carriers, 1):.2g} of {scores.number} scores carry the error"
