"""A detector's integer sums as arrays over its bins and as estimates, the basis of all its quantities."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from functools import cached_property

import numpy as np

from transport.compile.adjoint import Adjoint, SensorPart
from transport.compile.detectors import bin_counts, block_rows, has_blocks
from transport.results.batches import Batch
from transport.scene.cameras import PointInstrument
from transport.scene.detectors import Detector
from transport.statistics.chunked import (
    Box,
    ChunkedArray,
    batch_totals,
    is_large,
    rows_in_chunk,
    summed_counts,
)
from transport.statistics.estimates import Estimate, EstimateArray, EstimateOrArray
from transport.units import Unit

ARRIVALS, DEPARTURES = 0, 1
STORAGE_ORDER = (  # axes of the rows, ordered by the distance of their bins in memory, largest first
    "time",
    "speed",
    "u",
    "v",
    "turn",
    "mu",
)
MOMENTS = ("momentum", "speeds", "squares")  # the three rows of velocity sums behind each row of scores


class DetectorSums:
    """Sums of one detector in the batches of a run.

    kind: "weights" (in the unit of the run), "counts", "slants", or one of MOMENTS;  side: ARRIVALS or
    DEPARTURES.  Arrays have the axes (batches, time, speed, ...), the latter two of length 1 if they are not
    binned; with very many bins they are Stacked (computed in chunks).
    """

    def __init__(self, plan, batches, run, detector: Detector) -> None:
        self.plan, self.batches, self.run, self.detector = plan, batches, run, detector
        self.scene, self.shape = plan.scene, plan.scene.shape_of(detector)
        self.cells = bin_counts(detector, self.shape, self.scene.duration)

    @cached_property
    def outer_axes(self) -> dict[str, np.ndarray]:
        """Edges of the bins of time [s] and speed [m/s], if any."""
        axes = {"time": self.detector.time_edges(self.scene.duration), "speed": self.detector.speed_edges()}
        return {name: edges for name, edges in axes.items() if edges is not None}

    @cached_property
    def position_axes(self) -> dict[str, np.ndarray]:
        """Edges of the bins of position."""
        positions = self.detector.positions
        return {} if positions is None else positions.edges(self.shape)

    @cached_property
    def direction_axes(self) -> dict[str, np.ndarray]:
        """Edges of the bins of direction, in the order of quantities by direction."""
        edges = {} if self.detector.directions is None else self.detector.directions.edges()
        return {name: edges[name] for name in ("mu", "theta", "phi") if name in edges}

    @cached_property
    def seconds(self) -> np.ndarray:
        """Length of each time bin [s], (time, speed).

        The duration if time is not binned, 1 without a clock.
        """
        edges = self.outer_axes.get("time", np.array([0.0, self.plan.time_unit]))
        return np.repeat(np.diff(edges)[:, None], self.cells["speed"], axis=1)

    def whole(self, kind: str, side: int) -> np.ndarray:
        """Sums over the whole shape and all directions, (B, time, speed)."""
        if self.is_large:
            return np.concatenate([one.whole(kind, side) for one in self._batchwise])
        return self.blocks(kind, side).sum(axis=-1)

    def by_position(self, kind: str, side: int) -> np.ndarray | ChunkedArray:
        """Sums over all directions, (B, time, speed, u, v), without axes that are not binned."""
        if not self.position_axes:
            return self.whole(kind, side)
        inner = 3 + len(self.position_axes)
        shape = self._lengths[: inner - 1]
        if self.is_large and not is_large((len(self.batches), *shape)):
            return np.concatenate([one.by_position(kind, side) for one in self._batchwise])
        bins = self.by_direction(kind, side)
        return bins.sum(axis=tuple(range(inner, bins.ndim)))

    def by_direction(self, kind: str, side: int) -> np.ndarray | ChunkedArray:
        """Sums in all bins, (B, time, speed, u, v, mu or theta, phi), without axes that are not binned."""
        if self.is_large:
            # In memory azimuths lie farther apart than cosines.
            order = sorted(
                range(len(self._lengths)), key=lambda axis: STORAGE_ORDER.index(self._storage_axes[axis])
            )
            shape = (len(self.batches), *self._lengths)
            return ChunkedArray(shape, tuple(order), lambda box: self._in_box(kind, side, box))
        blocks = self.blocks(kind, side)[..., 1:]
        inner = [self.cells[name] for name in ("u", "v", "turn", "mu")]
        return self._arranged(blocks.reshape(*blocks.shape[:3], *inner))

    def _arranged(self, values: np.ndarray) -> np.ndarray:
        """Put stored sums (B, time, speed, u, v, azimuth, cosine) into the order of the quantities."""
        values = values.swapaxes(5, 6)
        if "theta" in self.direction_axes:
            values = values[..., ::-1, :]  # stored by rising cosine
        lengths = dict(zip(("time", "speed", "u", "v", "mu", "turn"), values.shape[1:], strict=True))
        return values.reshape(len(values), *(lengths[name] for name in self._storage_axes))

    def estimate(
        self,
        values: np.ndarray,
        unit: Unit,
        axes: dict[str, np.ndarray],
        counts: np.ndarray,
        exact: bool = False,
    ) -> EstimateOrArray:
        """Turn sums (B, time, speed, *axes), in units of a whole run, into means over histories.

        Counts alike.
        """
        axes = self.outer_axes | axes
        shape = [len(edges) - 1 for edges in axes.values()]
        sizes = self.run.sizes.reshape(-1, *(1,) * len(shape))
        values = values.reshape(len(values), *shape) / sizes
        counts = counts.reshape(len(counts), *shape)
        counts = summed_counts(counts)
        if not axes:
            return Estimate(values, self.run, unit, exact=exact, counts=int(counts))
        units = {} if self.detector.positions is None else self.detector.positions.units(self.shape)
        return EstimateArray(values, self.run, unit, tuple(axes), axes, counts, exact, units)

    def blocks(self, kind: str, side: int) -> np.ndarray:
        """The detector's rows, (B, time, speed, block).

        The first row of a block is outside its other bins.
        """
        outer, block = (self.cells["time"], self.cells["speed"]), block_rows(self.cells)
        return self._rows(kind, side, 0, math.prod(outer) * block).reshape(-1, *outer, block)

    @property
    def is_large(self) -> bool:
        """Whether the rows of all batches are too many for one array; those of one batch are not."""
        return is_large((len(self.batches), *self._lengths))

    @property
    def _batchwise(self) -> Iterator[DetectorSums]:
        """The sums of each batch alone."""
        return (DetectorSums(self.plan, [batch], self.run, self.detector) for batch in self.batches)

    @cached_property
    def _storage_axes(self) -> list[str]:
        """Names of the axes of `by_direction` in the order of storage."""
        named = {"theta": "mu", "phi": "turn"}
        return [
            "time",
            "speed",
            *(named.get(name, name) for name in self.position_axes | self.direction_axes),
        ]

    @cached_property
    def _lengths(self) -> tuple[int, ...]:
        """Bins along the axes of `by_direction`."""
        return tuple(self.cells[name] for name in self._storage_axes)

    def _in_box(self, kind: str, side: int, box: Box) -> np.ndarray:
        """Sums by direction in a box of bins, cut out of one stretch of rows per time and speed."""
        spans = {name: slice(0, count) for name, count in self.cells.items()}
        spans |= dict(zip(self._storage_axes, box, strict=True))
        if "theta" in self.direction_axes:
            last, requested = self.cells["mu"], spans["mu"]
            spans["mu"] = slice(last - requested.stop, last - requested.start)
        times, speeds = (range(self.cells[name])[spans[name]] for name in STORAGE_ORDER[:2])
        inner, bins = (
            [spans[name] for name in STORAGE_ORDER[2:]],
            [self.cells[name] for name in STORAGE_ORDER[2:]],
        )

        def block(time: int, speed: int) -> np.ndarray:
            first = 1 + (time * self.cells["speed"] + speed) * block_rows(self.cells)
            return rows_in_chunk(
                lambda a, many: self._rows(kind, side, first + a, many), tuple(inner), tuple(bins)
            )

        values = np.stack([block(*pair) for pair in itertools.product(times, speeds)], axis=1)
        return self._arranged(values.reshape(len(values), len(times), len(speeds), *values.shape[2:]))

    def _rows(self, kind: str, side: int, start: int, many: int) -> np.ndarray:
        """`many` of the detector's rows, (B, many), with the scores of next-event estimation."""
        first = (
            self.plan.bases[self.detector.name] + has_blocks(self.detector) + side * self.plan.half + start
        )
        sums = self._columns(kind, first, many)
        if self._scale is not None:
            expected = self._columns(kind, first + 2 * self.plan.half, many)
            sums = sums + (expected if kind == "counts" else expected / self._scale)
        return sums

    def _columns(self, kind: str, first: int, many: int) -> np.ndarray:
        return np.array([_column(batch, kind, slice(first, first + many)) for batch in self.batches])

    @cached_property
    def _scale(self) -> float | None:
        """Factor by which next-event sums are too large; None without next-event estimation."""
        name = self.detector.name
        return next((each.scale for each in self.plan.expectations if each.detector.name == name), None)


def _column(batch: Batch, kind: str, rows: slice) -> np.ndarray:
    if kind not in MOMENTS:
        return getattr(batch, kind)[rows]
    of_rows = batch.moments[len(MOMENTS) * rows.start : len(MOMENTS) * rows.stop]
    return of_rows.reshape(-1, len(MOMENTS))[:, MOMENTS.index(kind)]


# ---- Sums over the cells of a sensor in a backward run, per batch; very many cells are computed in chunks.


class CellSums:
    """Scores of the histories of a sensor's cells, per batch.

    lamps: indices of the sources that count, None for all.
    """

    def __init__(self, result, sensor, lamps: tuple[int, ...] | None = None) -> None:
        adjoint: Adjoint = result.plan.adjoint
        self.adjoint, self.batches, self.run, self.plan = adjoint, result.batches, result.run, result.plan
        self.parts = adjoint.parts_of(sensor)
        self.is_view = isinstance(sensor, PointInstrument)
        self.lamps = tuple(range(len(adjoint.sources))) if lamps is None else lamps

    @cached_property
    def means(self) -> list[np.ndarray | ChunkedArray]:
        """For each part, the mean radiance of each cell [W m^-2 sr^-1], weights included, (B, cells)."""
        return [
            sum(self._radiance_sums(part, lamp) for lamp in self.lamps) / self._histories_per_cell(part)
            for part in self.parts
        ]

    @cached_property
    def counts(self) -> list[np.ndarray | ChunkedArray]:
        """For each part, the number of arrivals of its cells' histories at sources, (B, cells)."""
        return [sum(self._lamp_counts(part, lamp) for lamp in self.lamps) for part in self.parts]

    @property
    def is_thin(self) -> bool:
        """Whether any batch has cells without a history."""
        return not all(self.rows_of(part, "counts", 0).all() for part in self.parts)

    def _radiance_sums(self, part: SensorPart, lamp: int) -> np.ndarray:
        return self._weights(part, lamp) * part.gains[lamp]

    def _weights(self, part: SensorPart, lamp: int) -> np.ndarray:
        """Weights that flights and rays brought to a source, per cell."""
        weights, scale = self.rows_of(part, "weights", 1 + lamp), self.adjoint.scales.get(lamp)
        return (
            weights if scale is None else weights + self.rows_of(part, "weights", self.block_of(lamp)) / scale
        )

    def _lamp_counts(self, part: SensorPart, lamp: int) -> np.ndarray:
        """Number of flights and rays that reached a source, per cell."""
        counts = self.rows_of(part, "counts", 1 + lamp)
        return (
            counts + self.rows_of(part, "counts", self.block_of(lamp))
            if lamp in self.adjoint.scales
            else counts
        )

    def block_of(self, lamp: int) -> int:
        """Number of the block of sums that shadow rays to a source have of their own."""
        return 1 + len(self.adjoint.sources) + lamp

    def _histories_per_cell(self, part: SensorPart) -> np.ndarray:
        """Histories of each cell.

        Their expectation if a batch has too few for all cells, which is unbiased too.
        """
        born = self.rows_of(part, "counts", 0)
        if born.all():
            return born
        return (self.run.sizes * part.share / part.cells)[:, None]

    def rows_of(self, part: SensorPart, kind: str, block: int) -> np.ndarray | ChunkedArray:
        """(B, cells); for a view with very many cells, computed in chunks."""
        begin, shape = (
            self.adjoint.first + block * self.adjoint.cells + part.first,
            (len(self.batches), part.cells),
        )

        def rows(first: int, past: int) -> np.ndarray:
            return np.array([getattr(batch, kind)[begin + first : begin + past] for batch in self.batches])

        if self.is_view and is_large(shape):
            return ChunkedArray(shape, (0,), lambda box: rows(box[0].start, box[0].stop))
        return rows(0, part.cells)


def grand_total(values: np.ndarray | ChunkedArray) -> float | int:
    """Sum over all batches and cells."""
    return batch_totals(values).sum() if isinstance(values, ChunkedArray) else values.sum()
