"""The tally of a PointDetector: the fluence rate at a point, and whether a few scores carry it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property, partial

import numpy as np

from transport.compile.points import SCALES
from transport.geometry.shape import Point
from transport.results.tally import (
    Measure,
    Quantity,
    Score,
    Tally,
    energy_unit,
    plain_column,
    seconds_of,
)
from transport.scene.points import PointDetector


class PointReading(Tally):
    """The quantities of one PointDetector, each an Estimate, from `result["name"]`.

    Parameters
    ----------
    result : Result
        The run.
    detector : PointDetector
        The detector of the scene.
    """

    kind = "point detector"
    main = ("weight",)

    fluence_rate = Quantity(
        """Fluence rate at the point, φ = ∫ L dω over all directions [W m^-2].

        It excludes the direct light of a Beam.  `PointDetector` explains how its error falls.
        """,
        "weight",
        per=("time", "square"),
    )
    counts = Quantity("Number of scores in the whole run: events visible from the point [1].", "count")

    def __init__(self, result, detector: PointDetector) -> None:
        super().__init__(result, detector)
        self.shape = Point(position=detector.position)

    @cached_property
    def scores(self) -> Mapping[str, Score]:
        """The weights, in a row for each octave of size."""
        rows, plan = self.plan.rows_of[self.name], self.plan
        weights, counts, first = plain_column("weights"), plain_column("counts"), rows.first
        return {
            "weight": Score(
                rows,
                lambda batch, a, b: weights(batch, a, b) * SCALES[a - first : b - first],
                counts,
                energy_unit(plan),
                plan.unit,
                is_dark=partial(self.diagnosis.is_sure, "weight"),
                notes=partial(self.diagnosis.missing, "weight"),
            ),
            "count": Score(rows, counts, counts, "1", float(self.particles)),
        }

    @cached_property
    def measures(self) -> Mapping[str, Callable[[], Measure]]:
        """Sizes by name: the square of the scene length, in which scores are counted."""
        return {
            "time": lambda: seconds_of(self.plan, ()),
            "square": lambda: Measure(self.plan.space.size**2, "m^2"),
        }

    @property
    def batch_values(self) -> np.ndarray:
        """Fluence rate of each batch [W m^-2].

        Returns
        -------
        numpy.ndarray
            Shape (B,).
        """
        return self.fluence_rate.values

    def __repr__(self) -> str:
        return f"<{self.name}: fluence_rate {self.fluence_rate!r}>"
