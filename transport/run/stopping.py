"""Stopping rule of a run for an error: few checks, at planned numbers of particles.

A run that checks often and stops as soon as its error seems small stops where the error is underestimated,
and its intervals are too short. So a run checks its errors only where an earlier check has planned it: after
a pilot, then at most 16 times as many particles later, and so on to where the error should be reached, with a
margin of one standard error of that error, so that one check in six is followed by another. The last check is
nearly independent of what planned it (Stein 1945 has two such stages; Chow and Robbins 1965 the limit).

A small error is not enough: the mean of few or unequal scores is skewed about the truth. Student's intervals
of 95 % then cover less by 0.25 g^2, where g is the skewness of the mean (Hall 1988, equation 2.5, normal
quantile 1.96).
g is 0.1 for 100 scores of equal weight. A check requires g <= 0.2, a loss below 1 %.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from transport.statistics.any_estimate import AnyEstimate
from transport.statistics.batches import MIN_SCORES_FOR_ERROR, skewness_of_mean
from transport.statistics.findings import CONSTANT, particle_factors_needed

# skewness of a mean above which intervals cover too little
MAX_SKEWNESS = 1 / math.sqrt(MIN_SCORES_FOR_ERROR)
MAX_GROWTH = 16.0  # largest factor of particles from one check to the next
BLIND_GROWTH = 4.0  # the same where nothing is known yet


@dataclass(frozen=True)
class Standing:
    """Status of a quantity: relative error (of the worst bin; inf while unknown), skewness of its mean.

    foretold, unseen: factor of particles until no finding about it remains, by what has scored and by what
    may never score (findings.particle_factors_needed; for bins, about their sum); doubt: the text of that
    finding.
    """

    name: str
    target: float
    relative: float
    skewness: float
    allowed: float
    foretold: float = 1.0
    unseen: float = 1.0
    doubt: str = ""
    has_bins: bool = False

    @property
    def shortfall(self) -> float:
        """Return the distance from the target: its square is the factor of particles still needed."""
        return max(self.relative / self.target, self.skewness / self.allowed, self._rare_shortfall)

    @property
    def _rare_shortfall(self) -> float:
        """Return the same for scores that are too rare; a run continues until it has enough of them."""
        return math.sqrt(self.foretold) if self.foretold > 1 else 0.0


@dataclass(frozen=True)
class Look:
    """An error check: the status of all quantities at a planned number of particles."""

    particles: int
    batches: int
    standings: tuple[Standing, ...]

    @property
    def worst(self) -> Standing:
        """Return the status of the quantity that takes longest."""
        return max(self.standings, key=lambda standing: standing.shortfall)

    @property
    def least_seen(self) -> Standing:
        """Return the status of the quantity with the largest `unseen`."""
        return max(self.standings, key=lambda standing: standing.unseen)

    @property
    def max_unseen_number(self) -> float:
        """Return the largest `unseen` of single numbers; of bins, most may be sound although some are not.

        A number with such a finding is worthless however small its error.
        """
        return max((standing.unseen for standing in self.standings if not standing.has_bins), default=1.0)

    def of(self, name: str) -> Standing:
        """Return the status of a quantity by name."""
        return next(standing for standing in self.standings if standing.name == name)

    @property
    def is_enough(self) -> bool:
        """Whether all quantities have reached their target errors."""
        return self.worst.shortfall <= 1

    @property
    def is_blind(self) -> bool:
        """Whether nothing is known yet about some quantity."""
        return math.isinf(self.worst.shortfall)

    @property
    def particles_needed(self) -> float:
        """Return the total of particles that will suffice (odds 5 to 1); infinite while unknown."""
        margin = 1 + 1 / math.sqrt(2 * self.batches)
        return self.particles * (self.worst.shortfall * margin) ** 2

    @property
    def legs(self) -> int:
        """Return how many further checks that will take."""
        return max(1, math.ceil(math.log(self.particles_needed / self.particles, MAX_GROWTH)))

    @property
    def next_check(self) -> int:
        """Return the total of particles at the next check, by equal factors up to the number needed."""
        if self.is_blind:
            return math.ceil(self.particles * BLIND_GROWTH)
        return math.ceil(self.particles * (self.particles_needed / self.particles) ** (1 / self.legs))


def status_of(name: str, quantity: AnyEstimate, target: float) -> Standing:
    """Return the status of a quantity.

    For an array it is that of the bin furthest from the target, with the findings of the sum. Only bins with
    known errors count.
    """
    replicates = quantity._replicates
    relative = np.atleast_1d(quantity.relative_error)
    known = np.isfinite(relative)
    # The second term is noise: one standard error of the skewness.
    allowed = MAX_SKEWNESS + math.sqrt(6) / quantity.batches
    if not known.any():
        is_constant = np.all(np.atleast_1d(quantity.reason) == CONSTANT) and np.any(quantity.value)
        return Standing(name, target, 0.0 if is_constant else math.inf, 0.0, allowed)
    # Find the bin furthest from its target, by error or by skewness.
    skewness = np.zeros(relative.shape)
    for run, deviations in replicates.deviations.items():
        skewness = np.fmax(skewness, np.abs(np.atleast_1d(skewness_of_mean(deviations, run.sizes))))
    worst = np.argmax(np.where(known, np.fmax(relative / target, skewness / allowed), -1.0))
    # Add how many particles the findings about the sum require.
    whole = quantity._whole
    doubts = particle_factors_needed(whole._raw_findings, whole.value, whole.error, target)
    furthest = float(relative.flat[worst]), float(skewness.flat[worst])
    return Standing(name, target, *furthest, allowed, *doubts, has_bins=bool(quantity.coords))


# ---- Size of the next round of a quasi-random run, from a line through the errors of earlier rounds.
#
# Errors of n quasi-random points fall as n^-0.5 to n^-1.5, with a slope that is unknown beforehand. A few
# pilot rounds, each four times as large as the one before, measure the slope. The run then grows, by at most
# a factor of 8 per round, to the size at which nine of ten rounds reach the target error. It ends with a
# round that was planned to be the last and reaches the target. To end with a round that merely happens to
# look good would make confidence intervals too short.

MIN_SLOPE, MAX_SLOPE = -1.5, -0.5  # bounds of the slope of log error against log n
MIN_ROUNDS = 4  # per run; the last round is the result
ROUNDS_FITTED = 4  # number of rounds that determine the slope
PILOT_DOUBLINGS = 2  # doublings between pilot rounds
MAX_STEP_DOUBLINGS = 3  # largest number of doublings between rounds
MAX_DOUBLINGS = 60
NORMAL_QUANTILE_90 = 1.28  # one-sided normal quantile of 90 %


@dataclass(frozen=True)
class Trend:
    """Line through logarithms of errors: height + slope (log n - middle).

    noise: standard deviation per round; spread: sum of squares of log n - middle.
    """

    height: float
    slope: float
    middle: float
    noise: float
    rounds: int
    spread: float

    def upper_bound(self, particles: float) -> float:
        """Return a 90 % upper bound of the error with so many particles."""
        away = math.log(particles) - self.middle
        of_slope = away**2 / self.spread if self.spread > 0 else 0.0
        above = NORMAL_QUANTILE_90 * self.noise * math.sqrt(1 + 1 / self.rounds + of_slope)
        return math.exp(min(700.0, self.height + self.slope * away + above))


def fit_trend(looks: list[Look], name: str) -> Trend | None:
    """Return the line through a quantity's errors in the last ROUNDS_FITTED rounds, with bounded slope.

    None where no error is known.
    """
    errors = [(look.particles, look.of(name).relative) for look in looks[-ROUNDS_FITTED:]]
    points = [(math.log(particles), math.log(error)) for particles, error in errors if 0 < error < math.inf]
    if not points:
        return None
    x, y = np.transpose(points)
    spread = float(((x - x.mean()) ** 2).sum())
    # Fit the slope within its bounds; two points are too few for one.
    slope = float(((x - x.mean()) * y).sum() / spread) if len(points) > 2 else MAX_SLOPE
    slope = min(max(slope, MIN_SLOPE), MAX_SLOPE)
    # Take the scatter about the line as noise, but no less than that of an error estimate.
    off = y - y.mean() - slope * (x - x.mean())
    unlike = math.sqrt(float((off**2).sum()) / max(1, len(points) - 2))
    noise = max(unlike, 1 / math.sqrt(2 * (looks[-1].batches - 1)))
    return Trend(float(y.mean()), slope, float(x.mean()), noise, len(points), spread)


def error_slope(looks: list[Look], name: str) -> float:
    """Return the slope of a quantity's error against the number of particles in the last rounds."""
    trend = fit_trend(looks, name)
    return MAX_SLOPE if trend is None else trend.slope


def planned_doublings(looks: list[Look], farthest: int = MAX_STEP_DOUBLINGS) -> tuple[int, ...]:
    """Return the doublings from each round to the next, up to the round planned to be the last."""
    pilot = (min(PILOT_DOUBLINGS, farthest),) * max(0, MIN_ROUNDS - 1 - len(looks))
    if looks[-1].is_blind:
        return (*pilot, min(PILOT_DOUBLINGS, farthest), 1)
    doublings = max(1, *(_doublings_to(looks, standing) for standing in looks[-1].standings))
    doublings = max(1, doublings - sum(pilot))
    legs = math.ceil(doublings / farthest)
    ends = [round(k * doublings / legs) for k in range(legs + 1)]
    return (*pilot, *(int(step) for step in np.diff(ends)))


def is_last_round(looks: list[Look], farthest: int = MAX_STEP_DOUBLINGS) -> bool:
    """Return whether the next round is planned to be the last."""
    return len(planned_doublings(looks, farthest)) == 1


def rounds_suffice(looks: list[Look], farthest: int = MAX_STEP_DOUBLINGS) -> bool:
    """Return whether the last round reaches the target and was planned to be the last."""
    is_planned = len(looks) >= MIN_ROUNDS and is_last_round(looks[:-1], farthest)
    return is_planned and looks[-1].is_enough


def _doublings_to(looks: list[Look], standing: Standing) -> int:
    """Return the doublings after which a quantity reaches its target error and skewness.

    The error reaches its target in nine of ten cases.
    """
    trend, particles = fit_trend(looks, standing.name), looks[-1].particles
    lopsided = math.ceil(2 * math.log2(max(1.0, standing.skewness / standing.allowed)))
    if trend is None:
        return lopsided
    enough = (k for k in range(MAX_DOUBLINGS) if trend.upper_bound(particles * 2.0**k) <= standing.target)
    return max(next(enough, MAX_DOUBLINGS), lopsided)
