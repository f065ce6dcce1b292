"""A detector's integer sums as arrays over its bins, and as estimates: what all its quantities are made of."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from transport.compile.looks import bin_counts, block_rows, is_blocked
from transport.detectors import Detector
from transport.results.estimates import Estimate, EstimateArray
from transport.units import Unit

ARRIVALS, DEPARTURES = 0, 1
MOMENTS = ("momentum", "speeds", "squares")  # of the three rows of velocity sums behind each row of scores


class MeterSums:
    """Sums of one detector in the batches of a run.

    kind: "weights" (in the unit of the run), "counts", "slants", or one of MOMENTS;  side: ARRIVALS or DEPARTURES.
    Arrays have the axes (batches, time, speed, ...), the latter two of length 1 where they are not binned.
    """

    def __init__(self, plan, batches, run, detector: Detector) -> None:
        self.plan, self.batches, self.run, self.detector = plan, batches, run, detector
        self.scene, self.shape = plan.scene, plan.scene.shape_of(detector)
        self.cells = bin_counts(detector, self.shape, self.scene.duration)

    @cached_property
    def outer_axes(self) -> dict[str, np.ndarray]:
        """Edges of the bins of time [s] and speed [m/s], of those that there are."""
        axes = {"time": self.detector.time_edges(self.scene.duration), "speed": self.detector.speed_edges()}
        return {name: edges for name, edges in axes.items() if edges is not None}

    @cached_property
    def place_axes(self) -> dict[str, np.ndarray]:
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
        """How long each bin of time is [s], (time, speed); the duration where time is not binned, 1 without a clock."""
        edges = self.outer_axes.get("time", np.array([0.0, self.plan.tempo]))
        return np.repeat(np.diff(edges)[:, None], self.cells["speed"], axis=1)

    def whole(self, kind: str, side: int) -> np.ndarray:
        """Sums over the whole shape and all directions, (B, time, speed)."""
        return self.blocks(kind, side).sum(axis=-1)

    def by_place(self, kind: str, side: int) -> np.ndarray:
        """Sums over all directions, (B, time, speed, u, v) without axes that are not binned."""
        if not self.place_axes:
            return self.whole(kind, side)
        bins = self.by_direction(kind, side)
        return bins.sum(axis=tuple(range(3 + len(self.place_axes), bins.ndim)))

    def by_direction(self, kind: str, side: int) -> np.ndarray:
        """Sums in all bins, (B, time, speed, u, v, mu or theta, phi) without axes that are not binned."""
        blocks = self.blocks(kind, side)[..., 1:]
        inner = [self.cells[name] for name in ("u", "v", "turn", "mu")]
        values = blocks.reshape(*blocks.shape[:3], *inner).swapaxes(5, 6)  # stored (u, v, azimuth, cosine)
        if "theta" in self.direction_axes:
            values = values[..., ::-1, :]  # stored by rising cosine
        axes = self.place_axes | self.direction_axes
        return values.reshape(*blocks.shape[:3], *(len(edges) - 1 for edges in axes.values()))

    def estimate(
        self,
        values: np.ndarray,
        unit: Unit,
        axes: dict[str, np.ndarray],
        counts: np.ndarray,
        exact: bool = False,
    ) -> Estimate | EstimateArray:
        """Sums (B, time, speed, *axes), in units of a run's whole, as means over histories; counts: as the sums."""
        axes = self.outer_axes | axes
        shape = [len(edges) - 1 for edges in axes.values()]
        sizes = self.run.sizes.reshape(-1, *(1,) * len(shape))
        values = values.reshape(len(values), *shape) / sizes
        counts = counts.sum(axis=0).reshape(shape)
        if not axes:
            return Estimate(values, self.run, unit, exact=exact, counts=int(counts))
        return EstimateArray(values, self.run, unit, tuple(axes), axes, counts=counts, exact=exact)

    def blocks(self, kind: str, side: int) -> np.ndarray:
        """The detector's rows, (B, time, speed, block): the first row of a block fell outside its other bins."""
        first = self.plan.bases[self.detector.name] + is_blocked(self.detector) + side * self.plan.half
        sums = self._rows(kind, first)
        if self._scale is not None:
            expected = self._rows(kind, first + 2 * self.plan.half)
            sums = sums + (expected if kind == "counts" else expected / self._scale)
        return sums

    def _rows(self, kind: str, first: int) -> np.ndarray:
        outer, block = (self.cells["time"], self.cells["speed"]), block_rows(self.cells)
        rows = slice(first, first + math.prod(outer) * block)
        return np.array([self._column(batch, kind)[rows] for batch in self.batches]).reshape(
            -1, *outer, block
        )

    @cached_property
    def _scale(self) -> float | None:
        """By how much the sums of what events told it are too large; None where none did."""
        name = self.detector.name
        return next((each.scale for each in self.plan.expectations if each.detector.name == name), None)

    def _column(self, batch, kind: str) -> np.ndarray:
        if kind in MOMENTS:
            return batch.moments[: 6 * self.plan.half].reshape(-1, 3)[:, MOMENTS.index(kind)]
        return getattr(batch, kind)
