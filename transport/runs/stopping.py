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

from transport.results.findings import CONSTANT, MIN_SCORES, times_needed
from transport.results.quantities import Quantity
from transport.results.statistics import skewness_of_mean

LOPSIDED = 1 / math.sqrt(MIN_SCORES)  # skewness of a mean above which intervals cover too little
LEAP = 16.0  # largest factor of particles from one check to the next
BLIND_LEAP = 4.0  # the same where nothing is known yet


@dataclass(frozen=True)
class Standing:
    """Status of a quantity: relative error (of the worst bin; inf while unknown), skewness of its mean.

    foretold, unseen: factor of particles until no finding about it remains, by what has scored and by what
    may never score (results.findings.times_needed; for bins, about their sum); doubt: the text of that
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
        return max(self.relative / self.target, self.skewness / self.allowed, self._doubted)

    @property
    def _doubted(self) -> float:
        """Return the same for scores that are too rare; a run goes on until it has enough of them."""
        return math.sqrt(self.foretold) if self.foretold > 1 else 0.0


@dataclass(frozen=True)
class Look:
    """An error check: what a run knows at a planned number of particles."""

    particles: int
    batches: int
    standings: tuple[Standing, ...]

    @property
    def worst(self) -> Standing:
        """Return the status of the quantity that takes longest."""
        return max(self.standings, key=lambda standing: standing.shortfall)

    @property
    def doubted(self) -> Standing:
        """Return the status of the quantity with the largest `unseen`."""
        return max(self.standings, key=lambda standing: standing.unseen)

    @property
    def unseen_of_numbers(self) -> float:
        """Return the largest `unseen` of single numbers; of bins, most may be sound although some are not.

        A number with such a finding is worthless however small its error.
        """
        return max((standing.unseen for standing in self.standings if not standing.has_bins), default=1.0)

    def of(self, name: str) -> Standing:
        """Return the status of a quantity by name."""
        return next(standing for standing in self.standings if standing.name == name)

    @property
    def is_enough(self) -> bool:
        return self.worst.shortfall <= 1

    @property
    def is_blind(self) -> bool:
        """Return whether nothing is known yet about some quantity."""
        return math.isinf(self.worst.shortfall)

    @property
    def needed(self) -> float:
        """Return the total of particles that will suffice (odds 5 to 1); infinite while unknown."""
        margin = 1 + 1 / math.sqrt(2 * self.batches)
        return self.particles * (self.worst.shortfall * margin) ** 2

    @property
    def legs(self) -> int:
        """Return how many further checks that will take."""
        return max(1, math.ceil(math.log(self.needed / self.particles, LEAP)))

    @property
    def next_at(self) -> int:
        """Return the total of particles at the next check, by equal factors up to the number needed."""
        if self.is_blind:
            return math.ceil(self.particles * BLIND_LEAP)
        return math.ceil(self.particles * (self.needed / self.particles) ** (1 / self.legs))


def standing_of(name: str, quantity: Quantity, target: float) -> Standing:
    """Return the status of a quantity.

    For an array it is that of the bin furthest from the target, with the findings of the sum. Only bins with
    known errors count.
    """
    replicates = quantity._replicates
    relative = np.atleast_1d(quantity.relative_error)
    known = np.isfinite(relative)
    # The second term is noise: one standard error of the skewness.
    allowed = LOPSIDED + math.sqrt(6) / quantity.batches
    if not known.any():
        is_constant = np.all(np.atleast_1d(quantity.reason) == CONSTANT)
        return Standing(
            name, target, 0.0 if is_constant and np.any(quantity.value) else math.inf, 0.0, allowed
        )
    # Find the bin furthest from its target, by error or by skewness.
    skewness = np.zeros(relative.shape)
    for run, deviations in replicates.deviations.items():
        skewness = np.fmax(skewness, np.abs(np.atleast_1d(skewness_of_mean(deviations, run.sizes))))
    worst = np.argmax(np.where(known, np.fmax(relative / target, skewness / allowed), -1.0))
    # Add how many particles the findings about the sum require.
    whole = quantity._whole
    doubts = times_needed(whole._raw_findings, whole.value, whole.error, target)
    furthest = float(relative.flat[worst]), float(skewness.flat[worst])
    return Standing(name, target, *furthest, allowed, *doubts, has_bins=bool(quantity.coords))
