"""The tally of a PointDetector: the fluence rate at a point, and whether a few scores carry it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import cached_property

import numpy as np

from transport.compile.layout import DIFFUSE
from transport.compile.points import SCALES, scatters_anywhere
from transport.geometry.shape import Point
from transport.results.diagnostics.depth import optical_depth_message
from transport.results.diagnostics.empty_detector import no_light_message
from transport.results.diagnostics.rays import point_forward_peaks, unvisited_surface_findings
from transport.results.diagnostics.sources import near_emitter_findings
from transport.results.score_sizes import point_detector_scores
from transport.results.tally import (
    Measure,
    Note,
    Quantity,
    Score,
    Tally,
    empty_note,
    energy_unit,
    plain_column,
    seconds_of,
)
from transport.statistics.findings import Finding
from transport.statistics.quality import Scores, findings_of_error, with_cure


class PointReading(Tally):
    """The quantities of one PointDetector, each an Estimate, from `result["name"]`.

    Parameters
    ----------
    result : Result
        The run.
    detector : PointDetector
        The detector of the scene.
    """

    title = "point detector "

    fluence_rate = Quantity(
        """Fluence rate at the point, φ = ∫ L dω over all directions [W m^-2].

        It excludes the direct light of a Beam.  `PointDetector` explains how its error falls.
        """,
        "weight",
        per=("time", "square"),
    )
    counts = Quantity("Number of scores in the whole run: events visible from the point [1].", "count")

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
                is_dark=lambda: self._is_exact,
                notes=self._missing,
            ),
            "count": Score(rows, counts, counts, "1", float(self.run.sizes.sum())),
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

    @property
    def is_blind(self) -> bool:
        """Whether the detector has no score.

        Returns
        -------
        bool
        """
        return not self.counts_of("count").any()

    @cached_property
    def score_sizes(self) -> Scores:
        """The scores by size."""
        score = self.scores["weight"]
        weights, counts = (
            sum(column(batch, score.rows.first, score.rows.past) for batch in self.batches)
            for column in (score.column, score.counts)
        )
        return point_detector_scores(weights, counts)

    @cached_property
    def note(self) -> Note | None:
        """The reason why the detector has no score: (name of the diagnostic, text).

        Returns
        -------
        tuple of str or None
            None if it has scores or no reason is known.
        """
        if not self.is_blind:
            return None
        title, position, particles = (
            f"point detector {self.name!r}",
            self.detector.position,
            int(self.run.sizes.sum()),
        )
        dark = no_light_message(self.plan.scene, title, position)
        return empty_note(dark, optical_depth_message(self.plan, title, position, particles))

    def _missing(self) -> Iterator[Finding]:
        """Findings about the fluence rate, with bounds in W m^-2."""
        plan, name, place, particles = (
            self.plan,
            self.name,
            self.detector.position,
            int(self.run.sizes.sum()),
        )
        fluence = self.fluence_rate
        if self.is_blind or fluence.exact:
            return
        yield from near_emitter_findings(plan, name, place, fluence, particles)
        yield from unvisited_surface_findings(
            plan, self.batches, f"point detector {name!r}", place, 0.0, fluence.value / 4
        )
        yield from point_forward_peaks(plan, name, place, particles)
        if fluence.error > 0:
            found = findings_of_error(f"point detector {name!r}", fluence, self.score_sizes, particles)
            yield from with_cure(found, self._more)

    @property
    def _is_exact(self) -> bool:
        """Whether all histories score the same.

        They start at one point, and nothing scatters or reflects them.
        """
        plan = self.plan
        is_one = len(plan.emitters) == 1 and isinstance(plan.emitters[0].shape, Point)
        return is_one and not scatters_anywhere(plan) and DIFFUSE not in plan.materials

    def __repr__(self) -> str:
        return f"<{self.name}: fluence_rate {self.fluence_rate!r}>"
