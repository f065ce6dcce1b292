"""The readings of a VolumeDetector: means over the cells of a volume, each with its standard error."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property

import numpy as np

from transport.geometry.solid import Box, Sphere
from transport.results.choice import more_particles_cure
from transport.results.diagnostics.depth import optical_depth_message, survivor_findings
from transport.results.diagnostics.empty_detector import no_light_message
from transport.results.diagnostics.path_classes import ALL_LIGHT, PathClass
from transport.results.diagnostics.proofs import max_transmitted_weight
from transport.results.reading import Note, ReadingBase, empty_note
from transport.results.score_sizes import equal_scores
from transport.scene.bodies import max_absorption, may_absorb
from transport.scene.volumes import VolumeDetector
from transport.statistics.chunked import (
    ChunkedArray,
    batch_totals,
    is_large,
    over_batches,
    rows_in_chunk,
    summed_counts,
)
from transport.statistics.estimates import Estimate, EstimateArray, EstimateOrArray
from transport.statistics.findings import MORE_PARTICLES, Finding
from transport.statistics.quality import Scores, findings_of_error, with_cure
from transport.units import Unit
from transport.validation import SceneError

VOLUME_QUANTITIES = (
    "fluence_rate", "absorbed_power", "absorbed_density", "radiance", "counts", "fluence",
    "absorbed_energy",
)  # fmt: skip
TIME_INTEGRATED_VOLUME = ("fluence", "absorbed_energy")
# Absorbed share of what a cell of the most absorbing medium would absorb; below it, geometry decides whether
# it absorbs.
NEGLIGIBLE_ABSORPTION = 1e-6


class VolumeReading(ReadingBase):
    """The quantities of one VolumeDetector, from `result["name"]`.

    Parameters
    ----------
    result : Result
        The run.
    detector : VolumeDetector
        The detector of the scene.

    Raises
    ------
    SceneError
        When a quantity is read for which the detector or the scene has not the options.

    Notes
    -----
    With cells each quantity is an EstimateArray with the axes of the cells, (x, y, z) or (r,); without cells
    it is an Estimate.  Sources of particles give s^-1 in place of W, and 1 in place of J.
    """

    known, title = VOLUME_QUANTITIES, "volume detector "

    def __init__(self, result, detector: VolumeDetector) -> None:
        self.detector, self.name = detector, detector.name
        self._plan, self._run, self._batches = result.plan, result.run, result.batches
        self._allowed, self._more = result.allowed_of(detector.name), more_particles_cure(result.choice)
        self._volume = next(volume for volume in self._plan.volumes if volume.detector is detector)
        self._axes = detector.edges(self._volume.shape)
        self._rate = Unit.parse("W" if self._plan.scene.measured_in == "watts" else "s^-1")

    @cached_property
    def volumes(self) -> np.ndarray:
        """Volume of each cell [m^3].

        Returns
        -------
        numpy.ndarray
            Shape of the cells.
        """
        return self.detector.volumes(self._volume.shape)

    @cached_property
    def fluence_rate(self) -> EstimateOrArray:
        """Mean of ∫ L dω over each cell, φ [W m^-2 or s^-1 m^-2]; with a clock also over its duration.

        Returns
        -------
        Estimate or EstimateArray
            [W m^-2 or s^-1 m^-2]
        """
        return self._per_volume(self._plan.time_unit, self._rate)

    @cached_property
    def fluence(self) -> EstimateOrArray:
        """Fluence rate integrated over the duration, H [J m^-2 or m^-2]; mean over each cell.

        Returns
        -------
        Estimate or EstimateArray
            [J m^-2 or m^-2]

        Raises
        ------
        SceneError
            If the scene has no `duration`.
        """
        self._need_clock("fluence")
        return self._per_volume(1.0, self._rate * Unit.parse("s"))

    @cached_property
    def absorbed_power(self) -> EstimateOrArray:
        """Power absorbed by the media in each cell [W or s^-1].

        Returns
        -------
        Estimate or EstimateArray
            [W or s^-1]: absorption coefficient times fluence rate, integrated over the cell's volume.

        Raises
        ------
        SceneError
            If no medium in the volume absorbs.
        """
        return self._absorbed(self._absorbed_sums / self._plan.time_unit, self._rate, self._plan.time_unit)

    @cached_property
    def absorbed_energy(self) -> EstimateOrArray:
        """Energy [J], or particles, absorbed by the media in each cell within the duration.

        Returns
        -------
        Estimate or EstimateArray
            [J or 1]

        Raises
        ------
        SceneError
            If the scene has no `duration`, or no medium in the volume absorbs.
        """
        self._need_clock("absorbed_energy")
        return self._absorbed(self._absorbed_sums, self._rate * Unit.parse("s"), 1.0)

    @cached_property
    def absorbed_density(self) -> EstimateOrArray:
        """Absorbed power per volume [W m^-3 or s^-1 m^-3].

        Returns
        -------
        Estimate or EstimateArray
            [W m^-3 or s^-1 m^-3]
        """
        values = self._absorbed_sums / self._plan.time_unit / self.volumes
        return self._absorbed(values, self._rate / Unit.parse("m^3"), self._plan.time_unit, self.volumes)

    @cached_property
    def radiance(self) -> EstimateArray:
        """Mean over each cell and each bin of flight direction, L [W m^-2 sr^-1 or s^-1 m^-2 sr^-1].

        Returns
        -------
        EstimateArray
            [W m^-2 sr^-1 or s^-1 m^-2 sr^-1]

        Raises
        ------
        SceneError
            If the detector has no `directions`.
        """
        directions = self.detector.directions
        if directions is None:
            self._refuse(
                "radiance", "directions=..., got None", "write directions=Directions.sphere(mu=8, phi=16)"
            )
        axes, angles = directions.edges(), directions.solid_angles()
        values, counts = (_by_direction(rows, angles.shape) for rows in (self._sums, self._counts))
        volumes = np.reshape(self.volumes, (*np.shape(self.volumes), *(1,) * angles.ndim))
        values = values * (self._unit / self._plan.time_unit) / volumes / angles
        made = self._estimate(values, self._rate / Unit.parse("m^2 sr"), counts, axes)
        return self._with_findings(made, self._unit / self._plan.time_unit / volumes / angles)

    @cached_property
    def counts(self) -> EstimateOrArray:
        """Number of scores in the whole run: of paths through each cell, or of collisions there.

        Returns
        -------
        Estimate or EstimateArray
            [1]
        """
        counts = self._counts.sum(axis=-1)
        return self._estimate(counts * float(self._run.sizes.sum()), Unit.parse("1"), counts)

    @cached_property
    def note(self) -> Note | None:
        """The reason why the detector has no score: (name of the diagnostic, text).

        Returns
        -------
        tuple of str or None
            None if it has scores or no reason is known.
        """
        title, shape, particles = (
            f"volume detector {self.name!r}",
            self._volume.shape,
            int(self._run.sizes.sum()),
        )
        if self.is_blind or not self._sums.any():
            return empty_note(
                no_light_message(self._plan.scene, title, shape),
                optical_depth_message(self._plan, title, shape, particles),
            )
        return None

    @cached_property
    def _missing(self) -> list[Finding]:
        """Findings, with bounds as a mean path length times weight [scene lengths]."""
        title, particles = f"volume detector {self.name!r}", int(self._run.sizes.sum())
        if self.is_blind and self.note:
            return []
        number, largest = int(batch_totals(self._counts).sum()), self._longest_chord()
        what = "light"
        if self._plan.attenuates and not self._plan.scatters:
            passes = max_transmitted_weight(self._plan, self._volume.shape)
            largest *= passes
            # Many paths of small weight do not represent those of full weight.
            heavy = (
                int(batch_totals(self._sums).sum() / (self._mean_chord_score * passes))
                if passes > 0
                else number
            )
            if heavy < number:
                what, number = "light that media hardly attenuate", heavy
        few = PathClass(what, number, largest, MORE_PARTICLES, name=ALL_LIGHT).finding(title, particles)
        found = [] if few is None else [few]
        middle, most = self._volume.shape.middle, self._mean_cell_chord()
        cells = None if isinstance(self._sums, ChunkedArray) or not self._axes else self._sums.sum(axis=-1)
        found += survivor_findings(self._plan, self._batches, title, self.whole, middle, cells, most)
        if self.whole.error > 0:
            found += findings_of_error(title, self.whole, self.scores, particles)
        return [*with_cure(found, self._more)]

    @cached_property
    def whole(self) -> Estimate:
        """Mean path length times weight through the whole volume [scene lengths], without findings."""
        return Estimate(
            batch_totals(self._sums) / self._run.sizes, self._run, Unit(), counts=self.scores.number
        )

    def why_unscored(self) -> list[Finding]:
        """Findings that explain why the detector has no score."""
        return self._missing

    def binned(self) -> Iterator[tuple[str, EstimateOrArray]]:
        """Yield the fluence rate by cell."""
        if self._axes:
            yield "fluence_rate", self.fluence_rate

    @property
    def total(self) -> Estimate:
        """The mean path length times weight through the whole volume, with its findings."""
        return Estimate(self.whole.values, self._run, Unit())._with_findings(
            lambda: self._missing, self._allowed
        )

    @cached_property
    def scores(self) -> Scores:
        """The scores in all cells, counted as if they had one size."""
        number = int(batch_totals(self._counts).sum())
        return equal_scores(number)

    @property
    def _mean_chord_score(self) -> float:
        """Score of full weight along a mean chord, 4 V / A (Cauchy), at most absorption [scene lengths]."""
        shape, unit = self._volume.shape, self._volume.unit
        chord, absorption = 4 * shape.volume / shape.area, max_absorption(self._plan.scene, shape)
        return (-math.expm1(-absorption * chord) / absorption if absorption > 0 else chord) / unit

    def _mean_cell_chord(self) -> float:
        """Approximate mean chord of a cell [scene lengths]: four times its volume over its area (Cauchy)."""
        shape, counts, unit = self._volume.shape, self._sums.shape[1:-1], self._volume.unit
        if len(counts) == 3:
            return 2 / sum(count / side for side, count in zip(shape.size, counts, strict=True)) / unit
        return 4 * shape.volume / shape.area / unit / max(math.prod(counts), 1)

    def _longest_chord(self) -> float:
        """The longest chord of the whole volume [scene lengths]."""
        return 2 * self._volume.shape.extent / self._volume.unit

    @property
    def is_blind(self) -> bool:
        """Whether the detector has no score.

        Returns
        -------
        bool
        """
        return not self._counts.any()

    def __repr__(self) -> str:
        return f"<{self.name}: fluence_rate {self.fluence_rate!r}>"

    # ---- from sums to estimates ----

    @cached_property
    def _sums(self) -> np.ndarray | ChunkedArray:
        """(B, *cells, 1 + bins of direction): sums of weight times path length."""
        return self._rows("weights", "first", int(self._volume.row["rows"]))

    @cached_property
    def _counts(self) -> np.ndarray | ChunkedArray:
        return self._rows("counts", "first", int(self._volume.row["rows"]))

    @property
    def _unit(self) -> float:
        """The quantity for a sum of 1 [m W, m s^-1, m J or m]."""
        return self._volume.unit * self._plan.unit

    @cached_property
    def _absorbed_sums(self) -> np.ndarray | ChunkedArray:
        if not self._volume.absorbs:
            self._refuse("absorbed power", "a medium that absorbs", "write Medium(absorption=...)")
        return self._rows("weights", "kept", 1).sum(axis=-1) * self._may_absorb * self._plan.unit

    @cached_property
    def _absorbed_counts(self) -> np.ndarray | ChunkedArray:
        return self._rows("counts", "kept", 1).sum(axis=-1)

    @cached_property
    def _may_absorb(self) -> np.ndarray:
        """Whether anything absorbs in each cell.

        Where nothing absorbs, rounding may still leave the end of a flight through an absorbing neighbour.
        """
        scene, shape = self._plan.scene, self._volume.shape
        found = np.full(np.shape(self.volumes), may_absorb(scene, shape))
        if self._axes and found.all():
            for index in zip(*np.nonzero(self._has_negligible_absorption), strict=True):
                found[index] = may_absorb(scene, *self._cell(index))
        return found

    def _cell(self, index: tuple[int, ...]) -> tuple[Box | Sphere, Sphere | None]:
        """One cell by its index along each axis; a shell as its outer ball and its inner one."""
        shape = self._volume.shape
        spans = [edges[k : k + 2].tolist() for edges, k in zip(self._axes.values(), index, strict=True)]
        if isinstance(shape, Box):
            sizes = [high - low for low, high in spans]
            return Box(center=[(low + high) / 2 for low, high in spans], size=sizes), None
        inner, outer = (Sphere(center=shape.center, radius=r) if r > 0 else None for r in spans[0])
        return outer, inner

    @property
    def _has_negligible_absorption(self) -> np.ndarray:
        """The cells that absorb less than NEGLIGIBLE_ABSORPTION of the share of the most absorbing medium."""
        kept = over_batches(self._rows("weights", "kept", 1).sum(axis=-1))
        lengths = over_batches(self._sums.sum(axis=-1)) * self._volume.unit
        most = max(float(np.max(medium.absorption)) for medium in self._plan.distinct_media)
        return (kept > 0) & (kept <= NEGLIGIBLE_ABSORPTION * most * lengths)

    def _rows(self, kind: str, column: str, each: int) -> np.ndarray | ChunkedArray:
        """(B, *cells, each)."""
        begin, bins = int(self._volume.row[column]), (*np.shape(self.volumes), each)
        shape = (len(self._batches), *bins)

        def rows(first: int, many: int) -> np.ndarray:
            these = slice(begin + first, begin + first + many)
            return np.array([getattr(batch, kind)[these] for batch in self._batches])

        if is_large(shape):
            return ChunkedArray(shape, tuple(range(len(bins))), lambda box: rows_in_chunk(rows, box, bins))
        return rows(0, math.prod(bins)).reshape(shape)

    def _per_volume(self, seconds: float, unit: Unit) -> EstimateOrArray:
        values = self._sums.sum(axis=-1) * (self._unit / seconds) / self.volumes
        made = self._estimate(values, unit / Unit.parse("m^2"), self._counts.sum(axis=-1))
        return self._with_findings(made, self._unit / seconds / self.volumes)

    def _absorbed(
        self, values: np.ndarray, unit: Unit, seconds: float, volumes: np.ndarray | float = 1.0
    ) -> EstimateOrArray:
        made = self._estimate(values, unit, self._absorbed_counts, is_sure=not self._may_absorb.any())
        most = max(float(np.max(medium.absorption)) for medium in self._plan.distinct_media)
        return self._with_findings(made, most * self._unit / seconds / volumes)

    def _with_findings(self, made: EstimateOrArray, factor: float | np.ndarray) -> EstimateOrArray:
        """Attach the findings to a quantity; factor: the quantity for a mean path of 1, per cell."""
        shape = made._replicates.shape

        def findings() -> Iterator[Finding]:
            each = np.broadcast_to(factor, shape) if shape else float(np.ravel(factor)[0])
            return (replace(finding, bound=finding.bound * each) for finding in self._missing)

        return made._with_findings(findings, self._allowed)

    def _estimate(
        self,
        values: np.ndarray,
        unit: Unit,
        counts: np.ndarray,
        axes: dict[str, np.ndarray] | None = None,
        is_sure: bool = False,
    ) -> EstimateOrArray:
        """Turn sums (B, *axes) of the batches into means over histories."""
        axes = self._axes | (axes or {})
        values = values / self._run.sizes.reshape(-1, *(1,) * (values.ndim - 1))
        counts = summed_counts(counts)
        if not axes:
            return Estimate(values, self._run, unit, is_sure, int(counts))
        return EstimateArray(values, self._run, unit, tuple(axes), axes, counts, is_sure)

    def _need_clock(self, quantity: str) -> None:
        if self._plan.scene.duration is None:
            self._refuse(quantity, "a clock", "write Scene(..., duration=...)")

    def _refuse(self, quantity: str, need: str, cure: str) -> None:
        raise SceneError(f"VolumeDetector {self.name!r}: {quantity} needs {need}; {cure}")


def _by_direction(rows: np.ndarray | ChunkedArray, bins: tuple[int, ...]) -> np.ndarray | ChunkedArray:
    """Rows (B, *cells, 1 + bins of direction) by direction bin, without the scores outside all bins."""
    shape = (*rows.shape[:-1], *bins)
    if not isinstance(rows, ChunkedArray):
        return rows[..., 1:].reshape(shape)
    cells = len(shape) - len(bins) - 1

    def part(box: tuple[slice, ...]) -> np.ndarray:
        values = rows.part((*box[:cells], slice(0, rows.shape[-1])))[..., 1:]
        return values.reshape(*values.shape[:-1], *bins)[(..., *box[cells:])]

    return ChunkedArray(shape, tuple(range(len(shape) - 1)), part)
