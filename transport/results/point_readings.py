"""What a PointDetector reads: the fluence rate in one place, and whether a few scores carry it."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from transport.compile.layout import DIFFUSE, POINT_ROWS
from transport.compile.points import SCALES, scatters_anywhere
from transport.points import PointDetector
from transport.results.estimates import Estimate
from transport.results.quantified import Quantified
from transport.shapes import Point
from transport.units import Unit

POINT_QUANTITIES = ("fluence_rate", "counts")
FEW, MUCH = 10, 0.1  # scores, which should not carry more than this share


class PointReading(Quantified):
    """One PointDetector's quantities, each an Estimate."""

    known, title = POINT_QUANTITIES, "point detector "

    def __init__(self, result, detector: PointDetector) -> None:
        self.detector, self.name = detector, detector.name
        self._plan, self._run = result.plan, result.run
        first = self._plan.bases[detector.name]
        rows = slice(first, first + POINT_ROWS)
        self._weights = np.array([batch.weights[rows] for batch in result.batches]) * SCALES
        self._counts = np.array([batch.counts[rows] for batch in result.batches])

    @cached_property
    def fluence_rate(self) -> Estimate:
        """Fluence rate at the point, phi = ∫ L dω over all directions [W m^-2].

        Without what a Beam brings straight from its source; see PointDetector for how its error falls.
        """
        unit, counts = Unit.parse("W m^-2"), int(self._counts.sum())
        return Estimate(self.batch_values, self._run, unit, exact=self._is_sure, counts=counts)

    @property
    def batch_values(self) -> np.ndarray:
        """The fluence rate of each batch [W m^-2], (B,)."""
        return self._weights.sum(axis=1) * self._plan.unit / self._plan.space.size**2 / self._run.sizes

    @cached_property
    def counts(self) -> Estimate:
        """Number of scores in the whole run: of births, flights and reflections that the point was seen from."""
        counts = self._counts.sum(axis=1)
        values = counts * self._run.sizes.sum() / self._run.sizes
        return Estimate(values, self._run, Unit.parse("1"), counts=int(counts.sum()))

    @property
    def is_blind(self) -> bool:
        """Whether nothing was counted at all."""
        return not self._counts.any()

    @cached_property
    def few(self) -> tuple[int, float]:
        """How many scores are the largest ones, about FEW at most, and what share of all they are: (0, 0) where none stand out.

        Told from the rows of scores within four octaves of one another.
        """
        counts, weights = self._counts.sum(axis=0)[::-1], self._weights.sum(axis=0)[::-1]
        among = np.flatnonzero(np.cumsum(counts) <= FEW)
        number, total = int(counts[among].sum()), float(weights.sum())
        return (number, float(weights[among].sum()) / total) if number and total else (0, 0.0)

    @property
    def warning(self) -> str | None:
        """What to know before trusting it, where a few scores carry it."""
        number, share = self.few
        if share <= MUCH:
            return None
        return (
            f"{number} of the scores of point detector {self.name!r} make up {share:.0%} of it: its error is not to be"
            " trusted; use more particles, or a small VolumeDetector"
        )

    @property
    def _is_sure(self) -> bool:
        """Whether every history brings the same: all begin in one place, and none is sent on its way again."""
        plan = self._plan
        is_one = len(plan.emitters) == 1 and isinstance(plan.emitters[0].shape, Point)
        return is_one and not scatters_anywhere(plan) and DIFFUSE not in plan.materials

    def __repr__(self) -> str:
        return f"<{self.name}: fluence_rate {self.fluence_rate!r}>"
