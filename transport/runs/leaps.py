"""Size of the next round of a quasi-random run, from a line through the errors of earlier rounds.

Errors of n quasi-random points fall as n^-0.5 to n^-1.5, with a slope that is unknown beforehand. A few pilot
rounds, each four times as large as the one before, measure the slope. The run then grows, by at most a factor
of 8 per round, to the size at which nine of ten rounds reach the target error. It ends with a round that was
planned to be the last and reaches the target. To end with a round that merely happens to look good would make
confidence intervals too short.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from transport.runs.stopping import Look, Standing

STEEPEST, FLATTEST = -1.5, -0.5  # bounds of the slope of log error against log n
FEWEST_ROUNDS = 4  # per run; the last round is the result
MEMORY = 4  # number of rounds that determine the slope
PILOT = 2  # doublings between pilot rounds
FARTHEST = 3  # largest number of doublings between rounds
MOST_DOUBLINGS = 60
SURE = 1.28  # one-sided normal quantile of 90 %


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

    def at_most(self, particles: float) -> float:
        """Return a 90 % upper bound of the error with so many particles."""
        away = math.log(particles) - self.middle
        of_slope = away**2 / self.spread if self.spread > 0 else 0.0
        above = SURE * self.noise * math.sqrt(1 + 1 / self.rounds + of_slope)
        return math.exp(min(700.0, self.height + self.slope * away + above))


def trend_of(looks: list[Look], name: str) -> Trend | None:
    """Return the line through a quantity's errors in the last MEMORY rounds, with bounded slope.

    None where no error is known.
    """
    errors = [(look.particles, look.of(name).relative) for look in looks[-MEMORY:]]
    points = [(math.log(particles), math.log(error)) for particles, error in errors if 0 < error < math.inf]
    if not points:
        return None
    x, y = np.transpose(points)
    spread = float(((x - x.mean()) ** 2).sum())
    # Fit the slope within its bounds; two points are too few for one.
    slope = float(((x - x.mean()) * y).sum() / spread) if len(points) > 2 else FLATTEST
    slope = min(max(slope, STEEPEST), FLATTEST)
    # Take the scatter about the line as noise, but no less than that of an error estimate.
    off = y - y.mean() - slope * (x - x.mean())
    unlike = math.sqrt(float((off**2).sum()) / max(1, len(points) - 2))
    noise = max(unlike, 1 / math.sqrt(2 * (looks[-1].batches - 1)))
    return Trend(float(y.mean()), slope, float(x.mean()), noise, len(points), spread)


def slope_of(looks: list[Look], name: str) -> float:
    """Return the slope of a quantity's error against the number of particles in the last rounds."""
    trend = trend_of(looks, name)
    return FLATTEST if trend is None else trend.slope


def leaps_to_come(looks: list[Look], farthest: int = FARTHEST) -> tuple[int, ...]:
    """Return the doublings from each round to the next, up to the round planned to be the last."""
    pilot = (min(PILOT, farthest),) * max(0, FEWEST_ROUNDS - 1 - len(looks))
    if looks[-1].is_blind:
        return (*pilot, min(PILOT, farthest), 1)
    doublings = max(1, *(_doublings_to(looks, standing) for standing in looks[-1].standings))
    doublings = max(1, doublings - sum(pilot))
    legs = math.ceil(doublings / farthest)
    ends = [round(k * doublings / legs) for k in range(legs + 1)]
    return (*pilot, *(int(step) for step in np.diff(ends)))


def is_last_leap(looks: list[Look], farthest: int = FARTHEST) -> bool:
    """Return whether the next round is planned to be the last."""
    return len(leaps_to_come(looks, farthest)) == 1


def leaps_suffice(looks: list[Look], farthest: int = FARTHEST) -> bool:
    """Return whether the last round reaches the target and was planned to be the last."""
    is_planned = len(looks) >= FEWEST_ROUNDS and is_last_leap(looks[:-1], farthest)
    return is_planned and looks[-1].is_enough


def _doublings_to(looks: list[Look], standing: Standing) -> int:
    """Return the doublings after which a quantity reaches its target error and skewness.

    The error reaches its target in nine of ten cases.
    """
    trend, particles = trend_of(looks, standing.name), looks[-1].particles
    lopsided = math.ceil(2 * math.log2(max(1.0, standing.skewness / standing.allowed)))
    if trend is None:
        return lopsided
    wide = next(
        (k for k in range(MOST_DOUBLINGS) if trend.at_most(particles * 2.0**k) <= standing.target),
        MOST_DOUBLINGS,
    )
    return max(wide, lopsided)
