"""What detectors read where histories run backwards: of each of their cells the mean of what its histories brought.

A cell is a bin of position and direction.  What arrives in it is the mean over its histories of weight times the radiance of
the sources that they came to, times area and projected solid angle of the bin: so it is divided by the number of its own
histories, and a bin costs the same, however small it is.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property

import numpy as np

from transport.bins import DirectionCone
from transport.cameras import Camera, Instrument
from transport.compile.adjoint import Part
from transport.compile.sizes import LARGE
from transport.detectors import Detector
from transport.points import PointDetector
from transport.results.cell_sums import CellSums, sum_of
from transport.results.empty_detector import cannot_arrive, why_dark
from transport.results.estimates import Estimate, EstimateArray, EstimateOrArray
from transport.results.findings import Finding
from transport.results.meter_sums import ARRIVALS, MeterSums
from transport.results.path_classes import Met, chances_of_sensor
from transport.results.proofs import events_of
from transport.results.quantified import Note, Quantified, note_of
from transport.results.readings import Reading
from transport.results.scores import Scores
from transport.results.sizes import scores_alike, scores_of_cell
from transport.results.solid_angles import solid_angles_of
from transport.results.stacked import Stacked, counts_told, totals_of
from transport.units import Unit
from transport.validation import SceneError, shown

BACKWARD_QUANTITIES = ("flux_in", "irradiance", "flux_density", "radiance", "intensity", "counts")
IMAGE_QUANTITIES = ("radiance", "fluence_rate", "counts")
ALIKE = 1e-9  # weights of cells that differ by less are the same
PLANE = {"u": "1", "v": "1"}  # units on a camera's plane at distance 1


def backward_reading(result, sensor: Detector | PointDetector | Instrument) -> Quantified:
    """The reading of a detector at which histories began."""
    kind = BackwardReading if isinstance(sensor, Detector) else ViewReading
    return kind(result, sensor)


class BackwardReading(Reading):
    """A Detector's quantities of what arrives; see BACKWARD_QUANTITIES.  Raises SceneError for all others."""

    known = BACKWARD_QUANTITIES

    def __init__(self, result, detector: Detector, lamps: tuple[int, ...] | None = None) -> None:
        super().__init__(result, detector)
        self._result, self._cell_sums = result, CellSums(result, detector, lamps)
        self.sums = ArrivedSums(result, detector, self._cell_sums)

    @cached_property
    def by_source(self) -> dict[str, BackwardReading]:
        """The same of each source alone, by its surface's name, or "sources[k]" or "glow[k]"."""
        return {
            lamp.name: BackwardReading(self._result, self.detector, (k,))
            for k, lamp in enumerate(self._plan.turned.lamps)
        }

    @cached_property
    def scores(self) -> Scores:
        """How many scores of each size came; as if they were alike where that is not known."""
        number = int(sum(counts.sum() for counts in self._cell_sums.counts))
        is_whole = len(self._cell_sums.lamps) == len(self._plan.turned.lamps)
        found = scores_of_cell(self._plan, self._cell_sums.batches, number) if is_whole else None
        return scores_alike(number) if found is None else found

    @property
    def is_blind(self) -> bool:
        return not any(counts.any() for counts in self._cell_sums.counts)

    @cached_property
    def cannot_arrive(self) -> bool:
        """Whether geometry proves that no light arrives at this side."""
        scene, shape = self._result.scene, self.sums.shape
        return (
            self.is_blind and not self._why_dark and cannot_arrive(scene, shape, self.detector, is_blind=True)
        )

    @cached_property
    def note(self) -> Note | None:
        """What to know of its histories, or why none met a source."""
        if not self.is_blind:
            return thin_note(self._cell_sums, self.name)
        return note_of(self._why_dark)

    def _classes(self, side: int) -> Iterator[Finding]:
        """Of lamps that are met by chance alone."""
        if side != ARRIVALS or self.is_dark(side):
            return
        unit = self._extent / self._plan.unit
        for finding in missing_of_cells(self._cell_sums, self.detector, self._title, self._extents):
            yield replace(finding, bound=finding.bound * unit)

    @cached_property
    def _extent(self) -> float:
        """Area times projected solid angle that its cells cover [m^2 sr]."""
        return sum(float(extents.sum()) for extents in self._extents)

    @cached_property
    def _extents(self) -> list[np.ndarray]:
        """The same of each cell of each part."""
        return [self.sums._extents(part) for part in self._cell_sums.parts]

    def scores_on(self, side: int) -> Scores | None:
        return self.scores

    @cached_property
    def _why_dark(self) -> str | None:
        return why_dark(self._result.scene, f"detector {self.name!r}", self.sums.shape, self.detector)

    def _whole(self, side: int, per_second: bool = True) -> EstimateOrArray:
        self._check(side, "weights")
        self._need_all(whole=True)
        return super()._whole(side, per_second)

    def _per_area(self, kind: str, side: int, per_second: bool = True) -> EstimateOrArray:
        self._check(side, kind)
        self._need_all(whole=not self.sums.place_axes)
        return super()._per_area(kind, side, per_second)

    def _by_direction(self, side: int, projected: bool, *more, **named) -> EstimateOrArray:
        self._check(side, "weights")
        return super()._by_direction(side, projected, *more, **named)

    def _check(self, side: int, kind: str) -> None:
        if side != ARRIVALS or kind != "weights":
            self._refuse(
                "this",
                "histories that run forwards",
                f"read one of {', '.join(self.known)}, or write estimator='analog'",
            )

    def _need_all(self, whole: bool) -> None:
        """Refuse sums over a hemisphere, or a shape, of which the bins are only a part."""
        detector = self.detector
        if not _covers_directions(detector):
            got = shown(detector.directions)
            self._refuse(
                "a sum over all directions",
                f"bins of all of them, got {got}",
                "read radiance, or leave directions out",
            )
        if whole and detector.positions is not None:
            areas = float(np.sum(detector.positions.areas(self.sums.shape)))
            if not math.isclose(areas, self.sums.shape.area, rel_tol=1e-9):
                got = shown(detector.positions)
                self._refuse("a sum over the shape", f"bins of all of it, got {got}", "leave positions out")


def _covers_directions(detector: Detector) -> bool:
    """Whether the bins hold all directions of the hemisphere."""
    directions = detector.directions
    if directions is None:
        return True
    if isinstance(directions, DirectionCone):
        return False
    edges, is_world = directions.edges(), directions.frame == "world"
    spans = {
        "mu": 2.0 if is_world else 1.0,
        "theta": math.pi if is_world else math.pi / 2,
        "phi": 2 * math.pi,
    }
    return all(math.isclose(e[-1] - e[0], spans[name], rel_tol=1e-9) for name, e in edges.items())


class ArrivedSums(MeterSums):
    """The cells' means as if they were a detector's sums over the run: fluxes in bins [W]."""

    is_large = False  # they are made at once

    def __init__(self, result, detector: Detector, cells: CellSums) -> None:
        super().__init__(result.plan, result.batches, result.run, detector)
        self._cell_sums = cells

    def blocks(self, kind: str, side: int) -> np.ndarray:
        """(B, 1, 1, 1 + cells): nothing is outside of all bins."""
        if kind == "counts":
            values = sum(self._cell_sums.counts)
        else:
            parts = zip(self._cell_sums.parts, self._cell_sums.means, strict=True)
            flux = sum(means * self._extents(part) for part, means in parts)
            values = flux * self.run.sizes[:, None] / self.plan.unit
        return np.concatenate([np.zeros_like(values[:, :1]), values], axis=1)[:, None, None, :]

    def _extents(self, part: Part) -> np.ndarray:
        """Area times solid angle of each cell [m^2 sr], (cells,), of the measure that its directions are drawn by."""
        positions = self.detector.positions
        areas = part.shape.area if positions is None else positions.areas(part.shape)
        return np.outer(np.ravel(areas), self._angles()).ravel()

    def _angles(self) -> np.ndarray:
        """Projected solid angles of bins in the local frame, plain ones of others, in the order of the cells."""
        directions = self.detector.directions
        if directions is None:
            return np.array([math.pi])
        plain, projected = solid_angles_of(self.detector, self.shape)
        angles = projected if getattr(directions, "frame", "world") == "local" else plain
        angles = np.reshape(angles, (self.cells["mu"], self.cells["turn"]))
        return (angles[::-1] if "theta" in self.direction_axes else angles).T.ravel()


class ViewReading(Quantified):
    """What arrives at a point: of a Camera or an EnvironmentMap its `radiance`, of those round about the `fluence_rate`."""

    known, title = IMAGE_QUANTITIES, "detector "

    def __init__(
        self, result, sensor: Instrument | PointDetector, lamps: tuple[int, ...] | None = None
    ) -> None:
        self.detector, self.name = sensor, sensor.name
        self._result, self._sums = result, CellSums(result, sensor, lamps)

    @cached_property
    def radiance(self) -> EstimateArray:
        """Radiance that arrives, a mean over each pixel's or bin's solid angle, (v, u) or (theta, phi) [W m^-2 sr^-1]."""
        if isinstance(self.detector, PointDetector):
            raise SceneError(f"PointDetector {self.name!r}: radiance needs bins; use an EnvironmentMap there")
        values, counts = self._arranged(self._sums.means[0]), self._arranged(self._sums.counts[0])
        if isinstance(self.detector, Camera):
            values = values * (self._plane_area / self.detector.solid_angles())
        edges, unit = self.detector.edges(), Unit.parse("W m^-2 sr^-1")
        counts = counts_told(counts)
        made = EstimateArray(values, self._sums.run, unit, tuple(edges), edges, counts, axis_units=PLANE)
        return self._with_findings(made, 1.0)

    @cached_property
    def fluence_rate(self) -> Estimate:
        """Fluence rate at the point, phi = ∫ L dω over all directions [W m^-2]."""
        unit, run = Unit.parse("W m^-2"), self._sums.run
        counts = int(sum_of(self._sums.counts[0]))
        if isinstance(self.detector, PointDetector):
            made = Estimate(4 * math.pi * self._sums.means[0][:, 0], run, unit, counts=counts)
            return self._with_findings(made, 4 * math.pi)
        angles = self.detector.solid_angles()
        if not math.isclose(float(angles.sum()), 4 * math.pi, rel_tol=1e-9):
            cure = "use an EnvironmentMap of all directions"
            raise SceneError(
                f"{type(self.detector).__name__} {self.name!r}: fluence_rate needs them all; {cure}"
            )
        values = self._arranged(self._sums.means[0]) * angles
        values = totals_of(values) if isinstance(values, Stacked) else values.sum(axis=(1, 2))
        return self._with_findings(Estimate(values, run, unit, counts=counts), 4 * math.pi)

    @cached_property
    def counts(self) -> EstimateOrArray:
        """How often histories met sources in the whole run, by pixel or bin."""
        run, counts = self._sums.run, self._sums.counts[0]
        values = counts * (run.sizes.sum() / run.sizes)[:, None]
        if isinstance(self.detector, PointDetector):
            return Estimate(values[:, 0], run, Unit.parse("1"), counts=int(counts.sum()))
        edges = self.detector.edges()
        totals = counts_told(self._arranged(counts))
        values, unit = self._arranged(values), Unit.parse("1")
        return EstimateArray(values, run, unit, tuple(edges), edges, totals, axis_units=PLANE)

    def image(self) -> np.ndarray:
        """Return the radiance [W m^-2 sr^-1] as rows of an image, the upper one first.

        Returns
        -------
        numpy.ndarray
            (height, width) of a Camera; (theta, phi) of an EnvironmentMap.

        Notes
        -----
        Columns of an EnvironmentMap are in the order of `radiance`, by growing azimuth.  Seen from inside
        azimuth grows to the left: draw the columns in reverse order, as `viz.seen` does.
        """
        return self._upright(self.radiance.value)

    def errors(self) -> np.ndarray:
        """One standard error of each pixel [W m^-2 sr^-1], as `image`; nan where nothing came."""
        return self._upright(self.radiance.error)

    @cached_property
    def by_source(self) -> dict[str, ViewReading]:
        """The same of each source alone, by its surface's name, or "sources[k]" or "glow[k]"."""
        lamps = self._sums.turned.lamps
        return {lamp.name: ViewReading(self._result, self.detector, (k,)) for k, lamp in enumerate(lamps)}

    @property
    def is_blind(self) -> bool:
        """Whether no history met a source."""
        return not self._sums.counts[0].any()

    @cached_property
    def note(self) -> Note | None:
        """What to know of its histories, or why none met a source."""
        if not self.is_blind:
            return thin_note(self._sums, self.name)
        return note_of(why_dark(self._result.scene, self._title, self.detector.position))

    def _with_findings(self, made: EstimateOrArray, factor: float) -> EstimateOrArray:
        """A quantity with what may be missing; factor: what a mean radiance of 1 is in it."""

        def findings() -> Iterator[Finding]:
            found = (
                []
                if self.is_blind and self.note
                else missing_of_cells(self._sums, self.detector, self._title)
            )
            return (replace(finding, bound=finding.bound * factor, adds=True) for finding in found)

        return made._with_findings(findings, self._result.allowed_of(self.name))

    def binned(self) -> Iterator[tuple[str, EstimateOrArray]]:
        """The radiance by pixel or bin."""
        if self._sums.is_view:
            yield "radiance", self.radiance

    def totals(self) -> Iterator[tuple[str, Estimate]]:
        """The mean over all its cells, with what may be missing of it."""
        means = self._sums.means[0]
        mean = totals_of(means) / means.shape[1] if isinstance(means, Stacked) else means.mean(axis=1)
        name = "fluence_rate" if isinstance(self.detector, PointDetector) else "radiance"
        yield (
            name,
            self._with_findings(
                Estimate(mean, self._sums.run, Unit(), counts=int(sum_of(self._sums.counts[0]))), 1.0
            ),
        )

    @property
    def _title(self) -> str:
        return f"{self.title}{self.name!r}"

    def __repr__(self) -> str:
        what = "fluence_rate" if isinstance(self.detector, PointDetector) else "radiance"
        return f"<{self.name}: {what} {getattr(self, what)!r}>"

    @property
    def _plane_area(self) -> float:
        """Area of a pixel on the plane at distance 1."""
        v, u = self.detector.edges().values()
        return float((v[1] - v[0]) * (u[1] - u[0]))

    def _arranged(self, cells: np.ndarray | Stacked) -> np.ndarray | Stacked:
        """(B, cells), the first axis of the sensor's bins slowest: pixels as they are, cosines and turns as (theta, phi)."""
        sizes = [len(edges) - 1 for edges in self.detector.edges().values()]
        is_image = isinstance(self.detector, Camera)
        bins = tuple(sizes if is_image else sizes[::-1])
        if isinstance(cells, Stacked):
            return cells.split(bins) if is_image else cells.split(bins).swapped()
        values = cells.reshape(-1, *bins)
        return values if is_image else values.swapaxes(1, 2)[:, ::-1]

    def _upright(self, rows: np.ndarray) -> np.ndarray:
        return rows[::-1] if isinstance(self.detector, Camera) else rows


def thin_note(sums: CellSums, name: str) -> Note | None:
    """What to know of a sensor that has too few histories for its cells."""
    if not sums.is_thin:
        return None
    return "thin batches", (
        f"batches are smaller than the {sum(part.cells for part in sums.parts)} bins of {name!r}, which adds"
        " noise; use more particles or fewer batches"
    )


def missing_of_cells(
    sums: CellSums, sensor: object, title: str, extents: list[np.ndarray] | None = None
) -> list[Finding]:
    """What may be missing of a sensor, with bounds as mean radiances over its cells [W m^-2 sr^-1].

    extents: of each part's cells, by which the mean weighs them; None where it weighs all alike.
    """
    histories = sum(part.share for part in sums.parts) * sums.run.sizes.sum()
    heaviest, chosen = 1.0, [None] * len(sums.parts)
    if extents is not None:
        weights = _weights_of_cells(sums, extents)
        most = max(float(each.max()) for each in weights)
        if most > 1 + ALIKE:  # a score in a small cell does not tell of what comes in a large one
            heaviest, chosen = most, [each >= LARGE * most for each in weights]
    met = {lamp: _met_by(sums, lamp, chosen) for lamp in sums.lamps}
    error = 0.0
    if not sums.is_view:
        each = sum(part.share * mean.mean(axis=1) for part, mean in zip(sums.parts, sums.means, strict=True))
        error = float(np.std(each) / np.sqrt(len(each))) / sum(part.share for part in sums.parts)
    events = events_of(sums.batches)
    return list(
        chances_of_sensor(
            sums.plan, title, sensor, sums.parts, met, histories, error, heaviest, events=events
        )
    )


def _met_by(sums: CellSums, lamp: int, chosen: list[np.ndarray | None]) -> Met:
    """How often flights and rays of chosen cells, None for all, came to a lamp; no ray where none is sent to it."""

    def number(kind: str, block: int) -> int:
        rows = (sums.rows_of(part, kind, block) for part in sums.parts)
        return round(
            sum(
                sum_of(each if which is None else each[:, which])
                for each, which in zip(rows, chosen, strict=True)
            )
        )

    flights, block = number("counts", 1 + lamp), sums.block_of(lamp)
    if lamp not in sums.turned.scales:
        return Met(flights, 0, 0)
    return Met(flights, number("counts", block), number("slants", block))


def _weights_of_cells(sums: CellSums, extents: list[np.ndarray]) -> list[np.ndarray]:
    """Of each part's cells, what a score there adds to the mean over all, where it would add 1 if all cells were alike."""
    shares, whole = sum(part.share for part in sums.parts), sum(float(each.sum()) for each in extents)
    return [
        each / whole * part.cells * shares / part.share
        for part, each in zip(sums.parts, extents, strict=True)
    ]
