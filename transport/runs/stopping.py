"""Whether a run for an error knows enough, and how many histories it will want: few looks, at planned times.

A run that looks often and stops as soon as its error seems small stops where the error is underestimated, and its
intervals are too short.  So a run looks at its errors only where an earlier look has planned it: after a pilot, at most
16 times as many histories later, and so on to where the error should be reached, with a margin of one standard error of
that error, so that one look in six has to be followed by another.  What is looked at last is nearly independent of what
planned it (Stein 1945 has two such stages; Chow and Robbins 1965 the limit).

A small error is not enough: of few or unlike scores the mean is lopsided about the truth.  Student's intervals of
95 % then cover less by 0.25 g^2, where g is the skewness of the mean (Hall 1988, equation 2.5, normal quantile 1.96):
g is 0.1 for 100 scores of equal weight.  A look asks for g <= 0.2, a loss below 1 %.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from transport.results.findings import CONSTANT, MIN_SCORES, times_needed
from transport.results.quantities import Quantity
from transport.results.statistics import skewness_of_mean

LOPSIDED = 1 / math.sqrt(MIN_SCORES)  # skewness of a mean, above which intervals cover too little
LEAP = 16.0  # most times as many histories from a look to the next
BLIND_LEAP = 4.0  # where nothing is known yet


@dataclass(frozen=True)
class Standing:
    """Where a quantity stands: its relative error (of the worst bin; inf while unknown) and its mean's skewness.

    foretold, unseen: how many times as many histories until nothing about it is doubtful any more, by what has scored and by what
    may never score (results.findings.times_needed), of bins about their sum;  doubt: what that is.
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
        """By how much it is off what is asked for: its square is how many times the histories it takes."""
        return max(self.relative / self.target, self.skewness / self.allowed, self._doubted)

    @property
    def _doubted(self) -> float:
        """The same of what has scored too seldom; a run for an error goes on until it knows that."""
        return math.sqrt(self.foretold) if self.foretold > 1 else 0.0


@dataclass(frozen=True)
class Look:
    """What a run knew when it looked."""

    particles: int
    batches: int
    standings: tuple[Standing, ...]

    @property
    def worst(self) -> Standing:
        """The quantity that will take longest."""
        return max(self.standings, key=lambda standing: standing.shortfall)

    @property
    def doubted(self) -> Standing:
        """The quantity of which most is unseen."""
        return max(self.standings, key=lambda standing: standing.unseen)

    @property
    def unseen_of_numbers(self) -> float:
        """The most that is unseen of a number, which in doubt is worth nothing however small its error; of bins most may stand."""
        return max((standing.unseen for standing in self.standings if not standing.has_bins), default=1.0)

    def of(self, name: str) -> Standing:
        """Where that quantity stood."""
        return next(standing for standing in self.standings if standing.name == name)

    @property
    def is_enough(self) -> bool:
        return self.worst.shortfall <= 1

    @property
    def is_blind(self) -> bool:
        """Whether of some quantity nothing is known yet."""
        return math.isinf(self.worst.shortfall)

    @property
    def needed(self) -> float:
        """Histories in all that will do, at five to one; infinite while that is not known."""
        margin = 1 + 1 / math.sqrt(2 * self.batches)
        return self.particles * (self.worst.shortfall * margin) ** 2

    @property
    def legs(self) -> int:
        """How many further looks that will take."""
        return max(1, math.ceil(math.log(self.needed / self.particles, LEAP)))

    @property
    def next_at(self) -> int:
        """Histories in all at which to look again: on equal steps to where they will do."""
        if self.is_blind:
            return math.ceil(self.particles * BLIND_LEAP)
        return math.ceil(self.particles * (self.needed / self.particles) ** (1 / self.legs))


def standing_of(name: str, quantity: Quantity, target: float) -> Standing:
    """Where a quantity stands; of an array its bin that is furthest off, among those with known errors, and what its sum leaves in doubt."""
    replicates = quantity._replicates
    relative = np.atleast_1d(quantity.relative_error)
    known = np.isfinite(relative)
    allowed = LOPSIDED + math.sqrt(6) / quantity.batches  # what of it is noise: one standard error of it
    if not known.any():
        is_constant = np.all(np.atleast_1d(quantity.reason) == CONSTANT)
        return Standing(
            name, target, 0.0 if is_constant and np.any(quantity.value) else math.inf, 0.0, allowed
        )
    skewness = np.zeros(relative.shape)
    for run, deviations in replicates.deviations.items():
        skewness = np.fmax(skewness, np.abs(np.atleast_1d(skewness_of_mean(deviations, run.sizes))))
    worst = np.argmax(np.where(known, np.fmax(relative / target, skewness / allowed), -1.0))
    whole = quantity._whole
    doubts = times_needed(whole._raw_findings, whole.value, whole.error, target)
    furthest = float(relative.flat[worst]), float(skewness.flat[worst])
    return Standing(name, target, *furthest, allowed, *doubts, has_bins=bool(quantity.coords))
