"""What a PointDetector reads: the fluence rate in one place, and whether a few scores carry it."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from transport.compile.layout import DIFFUSE, POINT_ROWS
from transport.compile.points import SCALES, scatters_anywhere
from transport.points import PointDetector
from transport.results import near_walls
from transport.results.deep_ways import why_so_deep
from transport.results.empty_detector import why_dark
from transport.results.estimates import Estimate
from transport.results.peaked import doubt_of_forward_point
from transport.results.quantified import Quantified
from transport.results.scores import Scores
from transport.results.sizes import scores_of_point
from transport.results.unvisited import unvisited_wall
from transport.shapes import Point
from transport.units import Unit

POINT_QUANTITIES = ("fluence_rate", "counts")
FEW, SMALL = 20, 0.02  # scores that may carry an error above this share


class PointReading(Quantified):
    """One PointDetector's quantities, each an Estimate."""

    known, title = POINT_QUANTITIES, "point detector "

    def __init__(self, result, detector: PointDetector) -> None:
        self.detector, self.name = detector, detector.name
        self._plan, self._run = result.plan, result.run
        first = self._plan.bases[detector.name]
        rows = slice(first, first + POINT_ROWS)
        self._batches = result.batches
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
        """Number of scores in the whole run: of events that the point was seen from."""
        counts = self._counts.sum(axis=1)
        values = counts * float(self._run.sizes.sum()) / self._run.sizes
        return Estimate(values, self._run, Unit.parse("1"), counts=int(counts.sum()))

    @property
    def is_blind(self) -> bool:
        """Whether nothing was counted at all."""
        return not self._counts.any()

    @cached_property
    def scores(self) -> Scores:
        """How many scores of each size came."""
        return scores_of_point(self._weights.sum(axis=0), self._counts.sum(axis=0))

    @property
    def carriers(self) -> float:
        """About how many scores carry the error; infinite without any."""
        return math.inf if self.is_blind else self.scores.carriers

    @cached_property
    def warning(self) -> str | None:
        """What to know before trusting it: it is shut in, it lies too near a wall, or a few scores carry its error."""
        position, fluence = self.detector.position, self.fluence_rate
        if self.is_blind:
            title, particles = f"point detector {self.name!r}", int(self._run.sizes.sum())
            return why_dark(self._plan.scene, title, position) or why_so_deep(
                self._plan, title, position, particles
            )
        near = near_walls.warning_of(self._plan, self.name, position, fluence, int(self._run.sizes.sum()))
        near = near or self._unvisited or self._peaked
        if near or self.carriers >= FEW or not fluence.relative_error > SMALL:
            return near
        return (
            f"the scores of point detector {self.name!r} differ so much that about {self.carriers:.2g} of them carry"
            " its error, which is not to be trusted; use more particles, or a small VolumeDetector"
        )

    @property
    def _unvisited(self) -> str | None:
        """A wall close by to which hardly any history has come."""
        title, error = f"point detector {self.name!r}", float(np.nan_to_num(self.fluence_rate.error))
        place, light = self.detector.position, self.fluence_rate.value / 4
        return unvisited_wall(self._plan, self._batches, title, place, 0.0, light, error)

    @property
    def _peaked(self) -> str | None:
        """Light scattered sharply forward, of which hardly any has come."""
        error, particles = float(np.nan_to_num(self.fluence_rate.error)), int(self._run.sizes.sum())
        return doubt_of_forward_point(self._plan, self.name, self.detector.position, error, particles)

    @property
    def _is_sure(self) -> bool:
        """Whether all histories bring the same: they begin in one place, and nothing sends them on again."""
        plan = self._plan
        is_one = len(plan.emitters) == 1 and isinstance(plan.emitters[0].shape, Point)
        return is_one and not scatters_anywhere(plan) and DIFFUSE not in plan.materials

    def __repr__(self) -> str:
        return f"<{self.name}: fluence_rate {self.fluence_rate!r}>"
