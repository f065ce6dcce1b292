"""The readings of a PointDetector: the fluence rate at a point, and whether a few scores carry it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from transport.compile.layout import DIFFUSE, POINT_ROWS
from transport.compile.points import SCALES, scatters_anywhere
from transport.geometry.shape import Point
from transport.results.choice import more_particles_cure
from transport.results.diagnostics.depth import optical_depth_message
from transport.results.diagnostics.empty_detector import no_light_message
from transport.results.diagnostics.rays import point_forward_peaks, unvisited_surface_findings
from transport.results.diagnostics.sources import near_emitter_findings
from transport.results.reading import Note, ReadingBase, empty_note
from transport.results.score_sizes import point_detector_scores
from transport.scene.points import PointDetector
from transport.statistics.estimates import Estimate
from transport.statistics.findings import Finding
from transport.statistics.quality import Scores, findings_of_error, with_cure
from transport.units import Unit

POINT_QUANTITIES = ("fluence_rate", "counts")


class PointReading(ReadingBase):
    """The quantities of one PointDetector, each an Estimate, from `result["name"]`.

    Parameters
    ----------
    result : Result
        The run.
    detector : PointDetector
        The detector of the scene.
    """

    known, title = POINT_QUANTITIES, "point detector "

    def __init__(self, result, detector: PointDetector) -> None:
        self.detector, self.name = detector, detector.name
        self._plan, self._run, self._allowed = result.plan, result.run, result.allowed_of(detector.name)
        self._more = more_particles_cure(result.choice)
        first = self._plan.bases[detector.name]
        rows = slice(first, first + POINT_ROWS)
        self._batches = result.batches
        self._weights = np.array([batch.weights[rows] for batch in result.batches]) * SCALES
        self._counts = np.array([batch.counts[rows] for batch in result.batches])

    @cached_property
    def fluence_rate(self) -> Estimate:
        """Fluence rate at the point, φ = ∫ L dω over all directions [W m^-2].

        Returns
        -------
        Estimate
            [W m^-2]

        Notes
        -----
        It excludes the direct light of a Beam.  `PointDetector` explains how its error falls.
        """
        unit, counts = Unit.parse("W m^-2"), int(self._counts.sum())
        made = Estimate(self.batch_values, self._run, unit, exact=self._is_exact, counts=counts)
        return made._with_findings(self._missing, self._allowed)

    @property
    def batch_values(self) -> np.ndarray:
        """Fluence rate of each batch [W m^-2].

        Returns
        -------
        numpy.ndarray
            Shape (B,).
        """
        return self._weights.sum(axis=1) * self._plan.unit / self._plan.space.size**2 / self._run.sizes

    @cached_property
    def counts(self) -> Estimate:
        """Number of scores in the whole run: events that are visible from the point.

        Returns
        -------
        Estimate
            [1]
        """
        counts = self._counts.sum(axis=1)
        values = counts * float(self._run.sizes.sum()) / self._run.sizes
        return Estimate(values, self._run, Unit.parse("1"), counts=int(counts.sum()))

    @property
    def is_blind(self) -> bool:
        """Whether the detector has no score.

        Returns
        -------
        bool
        """
        return not self._counts.any()

    @cached_property
    def scores(self) -> Scores:
        """The scores by size."""
        return point_detector_scores(self._weights.sum(axis=0), self._counts.sum(axis=0))

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
            int(self._run.sizes.sum()),
        )
        dark = no_light_message(self._plan.scene, title, position)
        return empty_note(dark, optical_depth_message(self._plan, title, position, particles))

    def _missing(self) -> Iterator[Finding]:
        """Findings about the fluence rate, with bounds in W m^-2."""
        plan, name, place, particles = (
            self._plan,
            self.name,
            self.detector.position,
            int(self._run.sizes.sum()),
        )
        fluence = self.fluence_rate
        if self.is_blind or fluence.exact:
            return
        yield from near_emitter_findings(plan, name, place, fluence, particles)
        yield from unvisited_surface_findings(
            plan, self._batches, f"point detector {name!r}", place, 0.0, fluence.value / 4
        )
        yield from point_forward_peaks(plan, name, place, particles)
        if fluence.error > 0:
            found = findings_of_error(f"point detector {name!r}", fluence, self.scores, particles)
            yield from with_cure(found, self._more)

    @property
    def _is_exact(self) -> bool:
        """Whether all histories score the same.

        They start at one point, and nothing scatters or reflects them.
        """
        plan = self._plan
        is_one = len(plan.emitters) == 1 and isinstance(plan.emitters[0].shape, Point)
        return is_one and not scatters_anywhere(plan) and DIFFUSE not in plan.materials

    def __repr__(self) -> str:
        return f"<{self.name}: fluence_rate {self.fluence_rate!r}>"
