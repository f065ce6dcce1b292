"""Readings of detectors in backward runs: for each cell the mean score of the histories that start in it.

A cell is a bin of position and direction.  What arrives in it is the mean over its histories of weight times
the radiance of the sources that they reach, times area and projected solid angle of the bin.  The sum is
divided by the cell's own number of histories, so the cost of a bin does not depend on its size.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property, partial

import numpy as np

from transport.compile.adjoint import Adjoint, SensorPart
from transport.compile.detectors import side_rows
from transport.compile.methods import found_by_rays_alone
from transport.compile.rows import Rows
from transport.geometry.shape import Point, Shape
from transport.results.batches import Batch
from transport.results.detectors import BINS, Reading
from transport.results.solid_angles import solid_angles_of
from transport.results.tally import (
    Column,
    Formula,
    Lacks,
    Measure,
    Quantity,
    Score,
    Tally,
    energy_unit,
)
from transport.scene.bins import DirectionCone
from transport.scene.cameras import (
    THIN_LENS,
    Camera,
    EnvironmentMap,
    Instrument,
    LightField,
)
from transport.scene.detectors import Detector
from transport.scene.parts import SceneParts
from transport.scene.points import PointDetector
from transport.statistics.axes import DIRECTION, Axis
from transport.statistics.chunked import ChunkedArray, batch_totals, is_large
from transport.statistics.estimates import Estimate, EstimateOrArray
from transport.units import Unit
from transport.validation import SceneError, short_repr

BACKWARD_QUANTITIES = ("flux_in", "irradiance", "flux_density", "radiance", "intensity", "counts")
SENSORS = {
    Camera: "camera",
    EnvironmentMap: "environment map",
    LightField: "light field",
    PointDetector: "point detector",
}


def backward_reading(result, sensor: Detector | PointDetector | Instrument) -> Tally:
    """The reading of a detector at which histories start."""
    kind = BackwardReading if isinstance(sensor, Detector) else ViewReading
    return kind(result, sensor)


class BackwardReading(Reading):
    """The quantities of a Detector in a backward run: arrivals only (BACKWARD_QUANTITIES).

    Parameters
    ----------
    result : Result
        The run.
    detector : Detector
        The detector of the scene.
    lamps : tuple of int, optional
        Indices of the sources that count; None for all.

    Raises
    ------
    SceneError
        When another quantity is read, or a sum over directions or positions that the bins do not cover.
    """

    known = BACKWARD_QUANTITIES
    main = ("weight in",)

    def __init__(self, result, detector: Detector, lamps: tuple[int, ...] | None = None) -> None:
        super().__init__(result, detector)
        self._result, self.cell_sums = result, CellSums(result, detector, lamps)

    def _arrival_rows(self) -> Rows:
        """Return the rows of arrivals, a row per cell."""
        return side_rows(self.detector, self.shape, self.scene.duration, 0)

    @cached_property
    def scores(self) -> Mapping[str, Score]:
        """Flux in the cells; nothing lies outside of them."""
        values = sum(
            means * extents for means, extents in zip(self.cell_sums.means, self.extents, strict=True)
        )
        weights = made_column(self.batches, values * self.run.sizes[:, None] / self.plan.unit)
        counts = made_column(self.batches, sum(self.cell_sums.counts))
        rows, number = self.rows, float(self.particles)
        dark, missing = (
            partial(each, "weight in") for each in (self.diagnosis.is_dark, self.diagnosis.missing)
        )
        unit = energy_unit(self.plan)
        weight = Score(
            rows, weights, counts, unit, self.plan.unit, is_dark=dark, is_sure=dark, findings=missing
        )
        return {"weight in": weight, "count in": Score(rows, counts, counts, "1", number)}

    @cached_property
    def lacks(self) -> Lacks:
        """What the detector was not set up for, also sums over directions or places that no bin covers."""
        lacks, detector = dict(super().lacks), self.detector
        if not _covers_directions(detector):
            got = short_repr(detector.directions)
            lacks["all directions"] = (
                f"bins that cover all directions, got {got}",
                "read radiance, or leave directions out",
            )
        areas = None if detector.positions is None else float(np.sum(detector.positions.areas(self.shape)))
        if areas is not None and not math.isclose(areas, self.shape.area, rel_tol=1e-9):
            got = short_repr(detector.positions)
            lacks["whole shape"] = (f"bins that cover all of the shape, got {got}", "leave positions out")
        return lacks

    def require(self, name: str, needs: Iterable[str]) -> None:
        """Raise SceneError for quantities of departures and of other scores, too."""
        if name not in self.known:
            cure = f"read one of {', '.join(self.known)}, or pass estimator='analog'"
            raise SceneError(f"Detector {self.name!r}: {name} needs forward histories; {cure}")
        super().require(name, needs)

    @cached_property
    def by_source(self) -> dict[str, BackwardReading]:
        """The quantities from each source alone.

        Returns
        -------
        dict of str to BackwardReading
            By the name of the source's surface, or "sources[k]" or "glow[k]"; by "sources[k]" where a surface
            has several.
        """
        return {
            lamp.name: BackwardReading(self._result, self.detector, (k,))
            for k, lamp in enumerate(self.plan.adjoint.sources)
        }

    def __repr__(self) -> str:
        is_whole = not {"all directions", "whole shape"} & set(self.lacks)
        name = "flux_in" if is_whole else "radiance"
        return f"<{self.name}: {name} {getattr(self, name)!r}>"

    @cached_property
    def extents(self) -> list[np.ndarray]:
        """Area times projected solid angle of each cell of each part [m^2 sr]."""
        parts = self.cell_sums.parts
        return [_cell_extents(self.detector, self.shape, part, self.axes) for part in parts]


def _covers_directions(detector: Detector) -> bool:
    """Return whether the bins cover all directions of the hemisphere."""
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


def _cell_extents(detector: Detector, shape: Shape, part: SensorPart, axes: tuple[Axis, ...]) -> np.ndarray:
    """Area times solid angle of each cell [m^2 sr], (cells,) as stored, in the measure of its sampling."""
    positions, directions = detector.positions, detector.directions
    areas = part.shape.area if positions is None else positions.areas(part.shape)
    if directions is None:
        return np.outer(np.ravel(areas), [math.pi]).ravel()
    plain, projected = solid_angles_of(detector, shape)
    angles = projected if getattr(directions, "frame", "world") == "local" else plain
    bins = {axis.coordinate.column: axis for axis in axes if axis.group == DIRECTION}
    angles = np.reshape(angles, [len(bins[name]) if name in bins else 1 for name in ("mu", "turn")])
    is_falling = "mu" in bins and bins["mu"].coordinate.is_falling
    return np.outer(np.ravel(areas), (angles[::-1] if is_falling else angles).T.ravel()).ravel()


def made_column(batches: list[Batch], values: np.ndarray) -> Column:
    """Return a column of values (B, cells) that are computed and not stored; row 0, for the outside, is 0."""
    rows = dict(zip(map(id, batches), np.pad(values, ((0, 0), (1, 0))), strict=True))
    return lambda batch, first, past: rows[id(batch)][first:past]


class ViewReading(Tally):
    """The quantities of a Camera, an EnvironmentMap or a PointDetector in a backward run.

    A Camera or an EnvironmentMap has `radiance`, without the direct light of Points and Beams; a sensor of
    all directions has `fluence_rate`, except an EnvironmentMap where there are such sources.

    Parameters
    ----------
    result : Result
        The run.
    sensor : Camera, EnvironmentMap or PointDetector
        The detector of the scene.
    lamps : tuple of int, optional
        Indices of the sources that count; None for all.
    """

    radiance = Quantity(
        """Mean arriving radiance over each pixel's or bin's solid angle [W m^-2 sr^-1].

        Axes (v, u) of a Camera and of images of an EnvironmentMap, (face, v, u) of a cube, else
        (theta, phi), and (u, v, s, t) of a LightField.
        """,
        "radiance",
        BINS,
        needs=("bins",),
    )
    irradiance = Quantity(
        "Mean irradiance E of each pixel of the film of a thin lens [W m^-2], axes (v, u).",
        "irradiance",
        BINS,
        needs=("film",),
    )
    fluence_rate = Formula(
        "Fluence rate at the point, φ = ∫ L dω over all directions, direct light of Beams included [W m^-2].",
        lambda tally: tally._fluence_rate(),
        needs=("all directions",),
    )
    flux_in = Formula(
        "Power that arrives through both planes of a LightField [W].",
        lambda tally: tally._flux_in(),
        needs=("planes",),
    )
    counts = Quantity(
        "Number of scores in the whole run, by pixel or bin: arrivals, and rays [1].", "count", BINS
    )

    def __init__(
        self, result, sensor: Instrument | PointDetector, lamps: tuple[int, ...] | None = None
    ) -> None:
        super().__init__(result, sensor)
        self.shape = Point(position=sensor.position)
        self._result, self.cell_sums = result, CellSums(result, sensor, lamps)
        edges = {} if isinstance(sensor, PointDetector) else sensor.edges()
        units = {} if not isinstance(sensor, Instrument) else sensor.axis_units
        self.axes = tuple(Axis(name, each, units.get(name, "")) for name, each in edges.items())

    @cached_property
    def scores(self) -> Mapping[str, Score]:
        """Mean radiance of the histories of each pixel or bin."""
        inner, gain = self._stored_axes, 1.0
        rows, sizes = Rows(0, (), inner, 1 + math.prod(map(len, inner))), self.run.sizes
        rows = rows if inner else Rows(1, (), (), 1)
        gains = self.detector.gains() if inner else None
        if gains is not None:  # histories are even over a pixel's area, and the mean is over its measure
            stored = np.moveaxis(gains, [self.axes.index(axis) for axis in inner], range(len(inner)))
            gain = np.pad(stored.ravel(), (1, 0))  # row 0, for the outside, is no pixel
        number, part = sizes.sum(), self.cell_sums.parts[0]
        sizes_of = dict(zip(map(id, self.batches), sizes.tolist(), strict=True))

        def radiance(batch: Batch, first: int, past: int) -> np.ndarray:
            means = self.cell_sums.means_in(batch, part, first - 1, past - 1)
            return means * (gain[first:past] if np.ndim(gain) else gain)

        def scored(batch: Batch, first: int, past: int) -> np.ndarray:
            return self.cell_sums.counts_in(batch, part, first - 1, past - 1)

        def in_run(batch: Batch, first: int, past: int) -> np.ndarray:
            return scored(batch, first, past) * (number / sizes_of[id(batch)])

        def irradiance(batch: Batch, first: int, past: int) -> np.ndarray:
            return radiance(batch, first, past) * measure[first:past]

        missing = partial(self.diagnosis.missing, "radiance")
        kept = {"is_mean": True, "findings": missing}
        scores = {"radiance": Score(rows, radiance, scored, "W m^-2 sr^-1", **kept)}
        if "film" not in self.lacks:
            measure = np.pad(self.detector.cell_measures().values.ravel(), (1, 0))
            scores["irradiance"] = Score(rows, irradiance, scored, "W m^-2", largest=measure.max(), **kept)
        return scores | {
            "count": Score(rows, in_run, scored, "1", is_mean=True),
        }

    @property
    def _stored_axes(self) -> tuple[Axis, ...]:
        """The axes in the order in which cells are stored, the fastest last."""
        if not self.axes:
            return ()
        named = {axis.name: axis for axis in self.axes}
        return tuple(named[name] for name in self.detector.stored_axes)

    def in_bins(self, cells: np.ndarray) -> np.ndarray:
        """Return numbers of cells, as they are stored, in the shape of `radiance`."""
        inner = self._stored_axes
        cells = cells.reshape([len(axis) for axis in inner])
        cells = np.moveaxis(cells, range(len(inner)), [self.axes.index(axis) for axis in inner])
        falling = [k for k, axis in enumerate(self.axes) if axis.coordinate.is_falling]
        return np.flip(cells, falling)

    @cached_property
    def measures(self) -> Mapping[str, Callable[[], Measure]]:
        """What radiance is a mean over: solid angle, area or throughput of each pixel or bin."""
        extent = self.detector.cell_measures()
        return {extent.name: lambda: Measure(extent.values, extent.unit, extent.axes)}

    def _measures_of(self, quantity: str) -> tuple[str, ...]:
        return tuple(self.measures) if quantity == "radiance" else ()

    @cached_property
    def lacks(self) -> Lacks:
        """What the user's scene, not the adjoint one, or the sensor was not set up for."""
        return self.lacks_of(self._result.scene, self.detector)

    @staticmethod
    def lacks_of(scene: SceneParts, detector: Instrument | PointDetector) -> Lacks:
        """Return what the sensor was not set up for; known before a run."""
        is_lens = isinstance(detector, Camera) and detector.lens == THIN_LENS
        options = {
            "bins": (isinstance(detector, Instrument), "bins", "use an EnvironmentMap there"),
            "film": (is_lens, "the film of a lens", "use a Camera(lens='thin lens')"),
            "map": (isinstance(detector, EnvironmentMap), "a map", "use an EnvironmentMap there"),
            "planes": (isinstance(detector, LightField), "two planes", "use a LightField"),
        }
        lacks = {need: (what, cure) for need, (has, what, cure) in options.items() if not has}
        if isinstance(detector, PointDetector):
            return lacks
        if any(found_by_rays_alone(scene, source) for source in scene.sources):
            needs = "the direct light of each Point and Beam, which has no radiance"
            lost = dict.fromkeys(("film", "planes"), (needs, "use a Detector there"))
            return lost | lacks | {"all directions": (needs, "use a PointDetector there")}
        if detector.sees_from_point and math.isclose(
            float(detector.solid_angles().sum()), 4 * math.pi, rel_tol=1e-9
        ):
            return lacks
        return lacks | {"all directions": ("all directions", "use an EnvironmentMap that covers all of them")}

    def _fluence_rate(self) -> Estimate:
        """The sum of radiance times solid angle over all cells."""
        if isinstance(self.detector, PointDetector):
            means = self.cell_sums.means[0]
            return self._summed(4 * math.pi * means[:, 0], "W m^-2", 4 * math.pi)
        return self._sum_over_cells(self.detector.solid_angles(), "W m^-2", 4 * math.pi)

    def _flux_in(self) -> Estimate:
        throughput = self.detector.cell_measures().values
        return self._sum_over_cells(throughput, "W", float(throughput.sum()))

    def _sum_over_cells(self, weights: np.ndarray, unit: str, largest: float) -> Estimate:
        """The sum of radiance times weights over all cells; largest: by which findings are multiplied."""
        values = self.sums("radiance", BINS) * weights
        axes = tuple(range(1, values.ndim))
        values = batch_totals(values) if isinstance(values, ChunkedArray) else values.sum(axis=axes)
        return self._summed(values, unit, largest)

    def _summed(self, values: np.ndarray, unit: str, largest: float) -> Estimate:
        counts = int(batch_totals(self.cell_sums.counts[0]).sum())
        made = Estimate(values, self.run, Unit.parse(unit), counts=counts)
        return self._with_findings(made, self.scores["radiance"], largest)

    def irradiance_on(self, normal: Sequence[float]) -> Estimate:
        """Irradiance on a plane at the point of an EnvironmentMap [W m^-2].

        Parameters
        ----------
        normal : vector
            Normal of the side of the plane that receives the light, of any length except 0.

        Returns
        -------
        Estimate
            The sum of radiance times `projected_solid_angles(normal)` of the map.

        Raises
        ------
        SceneError
            For other detectors, maps that do not cover all directions, and scenes with a Point or a Beam.

        Notes
        -----
        Light that varies within a bin of the map adds an error that falls with the square of the bin's size
        and is not in the error bar.
        """
        self.require("irradiance_on", ("map", "all directions"))
        return self._sum_over_cells(self.detector.projected_solid_angles(normal), "W m^-2", math.pi)

    def image(self) -> np.ndarray:
        """Return the radiance [W m^-2 sr^-1] as rows of an image, the top row first.

        Returns
        -------
        numpy.ndarray
            Shape (height, width) for a Camera and for images of an EnvironmentMap, (6, height, width) for its
            cube, else (theta, phi); (u, v, height, width), a picture for each view, for a LightField.

        Notes
        -----
        Columns of an EnvironmentMap are in the order of `radiance`, by increasing azimuth.  Seen from inside,
        azimuth increases to the left: draw the columns in reverse order, as `transport.viz.plot_map` does.
        """
        return self._top_row_first(self.radiance.value)

    def errors(self) -> np.ndarray:
        """One standard error of each pixel [W m^-2 sr^-1], in the layout of `image`.

        Returns
        -------
        numpy.ndarray
            nan where there is no score.
        """
        return self._top_row_first(self.radiance.error)

    @cached_property
    def by_source(self) -> dict[str, ViewReading]:
        """The quantities from each source alone.

        Returns
        -------
        dict of str to ViewReading
            By the name of the source's surface, or "sources[k]" or "glow[k]"; by "sources[k]" where a surface
            has several.
        """
        lamps = self.cell_sums.adjoint.sources
        return {lamp.name: ViewReading(self._result, self.detector, (k,)) for k, lamp in enumerate(lamps)}

    @property
    def heading(self) -> str:
        """Title in a report."""
        return f"{SENSORS[type(self.detector)]} {self.name!r}"

    @property
    def is_blind(self) -> bool:
        """Whether no history reached a source.

        Returns
        -------
        bool
        """
        return not self.cell_sums.counts[0].any()

    def binned(self) -> Iterator[tuple[str, EstimateOrArray]]:
        """Yield the radiance by pixel or bin."""
        if self.cell_sums.is_view:
            yield "radiance", self.radiance

    def __repr__(self) -> str:
        what = "fluence_rate" if isinstance(self.detector, PointDetector) else "radiance"
        return f"<{self.name}: {what} {getattr(self, what)!r}>"

    def _top_row_first(self, rows: np.ndarray) -> np.ndarray:
        names = [axis.name for axis in self.axes]
        if names == list("uvst"):
            return rows.swapaxes(2, 3)[:, :, ::-1]
        return np.flip(rows, names.index("v")) if "v" in names else rows


# ---- Sums over the cells of a sensor in a backward run, per batch; very many cells are computed in chunks.


class CellSums:
    """Scores of the histories of a sensor's cells, per batch.

    lamps: indices of the sources that count, None for all.
    """

    def __init__(self, result, sensor, lamps: tuple[int, ...] | None = None) -> None:
        adjoint: Adjoint = result.plan.adjoint
        self.adjoint, self.batches, self.run, self.plan = adjoint, result.batches, result.run, result.plan
        self.parts = adjoint.parts_of(sensor)
        self.is_view = isinstance(sensor, Instrument)
        # how histories from lamps score, where they do (compile/caustics.py)
        self.view = adjoint.caustics.views.get(sensor.name) if adjoint.caustics else None
        self.lamps = tuple(range(len(adjoint.sources))) if lamps is None else lamps

    @cached_property
    def means(self) -> list[np.ndarray | ChunkedArray]:
        """For each part, the mean radiance of each cell [W m^-2 sr^-1], weights included, (B, cells)."""
        return [self._by_batch(part, self.means_in) for part in self.parts]

    @cached_property
    def counts(self) -> list[np.ndarray | ChunkedArray]:
        """For each part, the number of scores of its cells: arrivals at sources, and rays, (B, cells)."""
        return [self._by_batch(part, self.counts_in) for part in self.parts]

    def means_in(self, batch: Batch, part: SensorPart, first: int, past: int) -> np.ndarray:
        """Return the mean radiance of some cells of a part in a batch."""
        rows = partial(self._rows_in, batch, part, first, past)
        weights = (self._with_rays(rows, "weights", lamp) * part.gains[lamp] for lamp in self.lamps)
        means = sum(weights) / self._histories_in(batch, part, first, past)
        if self.view is None:
            return means
        return means + sum(self.brought_in(batch, part, lamp, first, past) for lamp in self.lamps)

    def brought_in(
        self, batch: Batch, part: SensorPart, lamp: int, first: int = 0, past: int | None = None
    ) -> np.ndarray:
        """Return the mean radiance that histories from a lamp brought to some cells in a batch."""
        caustics, view, past = self.adjoint.caustics, self.view, part.cells if past is None else past
        gain = caustics.power / (self._size_of(batch) * caustics.share * view.scale)
        brought = self._rows_in(batch, part, first, past, "weights", self.block_of(lamp, from_lamp=True))
        return brought * (gain / view.measures[first:past])

    def counts_in(self, batch: Batch, part: SensorPart, first: int, past: int) -> np.ndarray:
        """Return the number of scores of some cells in a batch: arrivals at sources, and rays."""
        rows = partial(self._rows_in, batch, part, first, past)
        counts = sum(self._with_rays(rows, "counts", lamp) for lamp in self.lamps)
        if self.view is None:
            return counts
        return counts + sum(rows("counts", self.block_of(lamp, from_lamp=True)) for lamp in self.lamps)

    def _with_rays(self, rows: Callable, kind: str, lamp: int) -> np.ndarray:
        """What flights brought to a source, and shadow rays over their scale."""
        of_flights, rays = rows(kind, 1 + lamp), self.adjoint.rays.get(lamp)
        if rays is None:
            return of_flights
        of_rays = rows(kind, self.block_of(lamp))
        return of_flights + (of_rays if kind == "counts" else of_rays / rays.scale)

    def _rows_in(
        self, batch: Batch, part: SensorPart, first: int, past: int, kind: str, block: int
    ) -> np.ndarray:
        begin = self.adjoint.first + block * self.adjoint.cells + part.first
        return getattr(batch, kind)[begin + first : begin + past]

    def _histories_in(self, batch: Batch, part: SensorPart, first: int, past: int) -> np.ndarray | float:
        """Histories of some cells; if a batch has too few for all, their expectation (unbiased too)."""
        if not self._is_thin[self.parts.index(part)]:
            return self._rows_in(batch, part, first, past, "counts", 0)
        return self._size_of(batch) * part.share / part.cells

    def _size_of(self, batch: Batch) -> float:
        """Number of histories of a batch."""
        return self.run.sizes[next(k for k, other in enumerate(self.batches) if other is batch)]

    def _by_batch(self, part: SensorPart, read: Callable) -> np.ndarray | ChunkedArray:
        """(B, cells); for a view with very many cells, computed in chunks."""
        shape = (len(self.batches), part.cells)

        def rows(first: int, past: int) -> np.ndarray:
            return np.array([read(batch, part, first, past) for batch in self.batches])

        if self.is_view and is_large(shape):
            return ChunkedArray(shape, (0,), lambda box: rows(box[0].start, box[0].stop))
        return rows(0, part.cells)

    @cached_property
    def _is_thin(self) -> list[bool]:
        """For each part, whether any batch has cells without a history."""
        return [not self.rows_of(part, "counts", 0).all() for part in self.parts]

    @property
    def is_thin(self) -> bool:
        """Whether any batch has cells without a history."""
        return any(self._is_thin)

    def block_of(self, lamp: int, from_lamp: bool = False) -> int:
        """Number of the block of sums that shadow rays to a source have of their own.

        from_lamp: that of rays from histories that started there.
        """
        return 1 + len(self.adjoint.sources) * (2 if from_lamp else 1) + lamp

    def rows_of(self, part: SensorPart, kind: str, block: int) -> np.ndarray | ChunkedArray:
        """(B, cells); for a view with very many cells, computed in chunks."""
        return self._by_batch(part, lambda batch, of, a, b: self._rows_in(batch, of, a, b, kind, block))
