"""How large the next round of nets has to be: by the line through the errors of the rounds so far.

Errors of nets fall with their number n as n^-0.5 to n^-1.5, nobody knows beforehand how.  A first few rounds, each four
times as large as the one before, tell the slope; then a run leaps to where nine of ten rounds are below the error asked
for, 8 times as far at most.  It ends with a round that was planned to be the last and is good enough: not with one that
happens to look so, whose intervals would be too short.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from transport.runs.stopping import Look, Standing

STEEPEST, FLATTEST = -1.5, -0.5  # slopes of the errors of nets of points against their number
FEWEST_ROUNDS = 4  # that a run takes, the last of which is the result
MEMORY = 4  # rounds that tell the slope
PILOT = 2  # doublings between the first rounds
FARTHEST = 3  # doublings from a round to the next
MOST_DOUBLINGS = 60
SURE = 1.28  # standard errors above what is expected: nine of ten are below


@dataclass(frozen=True)
class Trend:
    """Logarithms of errors: height + slope (log n - middle); noise: of each round's, spread: sum of squares."""

    height: float
    slope: float
    middle: float
    noise: float
    rounds: int
    spread: float

    def at_most(self, particles: float) -> float:
        """What the error of so many will be, all but surely: in nine of ten rounds."""
        away = math.log(particles) - self.middle
        of_slope = away**2 / self.spread if self.spread > 0 else 0.0
        above = SURE * self.noise * math.sqrt(1 + 1 / self.rounds + of_slope)
        return math.exp(min(700.0, self.height + self.slope * away + above))


def trend_of(looks: list[Look], name: str) -> Trend | None:
    """The line through a quantity's errors of the last rounds, its slope within -1.5 and -0.5; None where no error is known."""
    errors = [(look.particles, look.of(name).relative) for look in looks[-MEMORY:]]
    points = [(math.log(particles), math.log(error)) for particles, error in errors if 0 < error < math.inf]
    if not points:
        return None
    x, y = np.transpose(points)
    spread = float(((x - x.mean()) ** 2).sum())
    slope = float(((x - x.mean()) * y).sum() / spread) if len(points) > 2 else FLATTEST
    slope = min(max(slope, STEEPEST), FLATTEST)
    off = y - y.mean() - slope * (x - x.mean())
    unlike = math.sqrt(float((off**2).sum()) / max(1, len(points) - 2))
    noise = max(unlike, 1 / math.sqrt(2 * (looks[-1].batches - 1)))
    return Trend(float(y.mean()), slope, float(x.mean()), noise, len(points), spread)


def slope_of(looks: list[Look], name: str) -> float:
    """The slope of a quantity's error against the histories of its last rounds."""
    trend = trend_of(looks, name)
    return FLATTEST if trend is None else trend.slope


def leaps_to_come(looks: list[Look], farthest: int = FARTHEST) -> tuple[int, ...]:
    """Doublings from each round to the next, to the one that is planned to be the last."""
    pilot = (min(PILOT, farthest),) * max(0, FEWEST_ROUNDS - 1 - len(looks))
    if looks[-1].is_blind:
        return (*pilot, min(PILOT, farthest), 1)
    doublings = max(1, *(_doublings_to(looks, standing) for standing in looks[-1].standings))
    doublings = max(1, doublings - sum(pilot))
    legs = math.ceil(doublings / farthest)
    ends = [round(k * doublings / legs) for k in range(legs + 1)]
    return (*pilot, *(int(step) for step in np.diff(ends)))


def is_last_leap(looks: list[Look], farthest: int = FARTHEST) -> bool:
    """Whether the next round is planned to be the last."""
    return len(leaps_to_come(looks, farthest)) == 1


def leaps_suffice(looks: list[Look], farthest: int = FARTHEST) -> bool:
    """Whether the last of a run's rounds is enough and was planned to be."""
    is_planned = len(looks) >= FEWEST_ROUNDS and is_last_leap(looks[:-1], farthest)
    return is_planned and looks[-1].is_enough


def _doublings_to(looks: list[Look], standing: Standing) -> int:
    """By how many doublings a quantity is below its error, all but surely, and no more lopsided than allowed."""
    trend, particles = trend_of(looks, standing.name), looks[-1].particles
    lopsided = math.ceil(2 * math.log2(max(1.0, standing.skewness / standing.allowed)))
    if trend is None:
        return lopsided
    wide = next(
        (k for k in range(MOST_DOUBLINGS) if trend.at_most(particles * 2.0**k) <= standing.target),
        MOST_DOUBLINGS,
    )
    return max(wide, lopsided)
