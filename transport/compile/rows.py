"""Rows: where the sums over some axes lie among the rows of a run.

Each tally has its Rows in the plan: the engine adds the same strides that the results read by.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import as_strided

from transport.geometry.shape import Shape
from transport.scene.detectors import Detector
from transport.scene.phase_space import PhaseSpace
from transport.scene.volumes import VolumeDetector
from transport.statistics.axes import PHASE, Axis


@dataclass(frozen=True, eq=False)
class Rows:
    """The rows of a score: one block for each bin of the outer axes.

    The first row of a block takes scores outside all bins of the inner axes; a row per inner bin follows. The
    row of a bin is first + the sum of its index along each axis times the stride of the axis.

    Parameters
    ----------
    first : int
        First row of the first block.
    outer, inner : tuple of Axis
        Axes as they are stored, the last one fastest.
    block : int
        Rows in a block.
    span : int, optional
        Rows of a block that a sum over whole blocks takes; None: all, 1: only the row for the outside.
    before : int, default 0
        Rows before the first block: 1 where scores may lie outside all bins of the outer axes.
    """

    first: int
    outer: tuple[Axis, ...]
    inner: tuple[Axis, ...]
    block: int
    span: int | None = None
    before: int = 0

    @cached_property
    def strides(self) -> dict[str, int]:
        """Rows from one bin to the next along each axis, by name."""
        strides = {}
        for axes, stride in ((self.inner, 1), (self.outer, self.block)):
            for axis in reversed(axes):
                strides[axis.name] = stride
                stride *= len(axis)
        return strides

    @property
    def axes(self) -> tuple[Axis, ...]:
        """All axes as they are stored."""
        return (*self.outer, *self.inner)

    @property
    def count(self) -> int:
        """Rows of all blocks."""
        return self.block * math.prod(map(len, self.outer))

    @property
    def base(self) -> int:
        """The very first row."""
        return self.first - self.before

    @property
    def past(self) -> int:
        """The row after the last block."""
        return self.first + self.count

    @property
    def bins(self) -> tuple[int, ...]:
        """Number of bins along each axis, as stored."""
        return tuple(map(len, self.axes))

    def sums(
        self,
        rows: Callable[[int, int], np.ndarray],
        axes: Sequence[Axis],
        box: Sequence[slice] | None = None,
    ) -> np.ndarray:
        """Return the sums along some axes and over all other inner ones, within a box of bins.

        Without an inner axis they are sums over whole blocks, with the scores outside all bins.

        Parameters
        ----------
        rows : callable
            rows(first, past) returns these rows of every batch, (B, past - first); axes may stand in between.
        axes : sequence of Axis
            All outer axes, and the inner ones to keep, in the order of the result.
        box : sequence of slice, optional
            Bins along each of `axes`; None for all.

        Returns
        -------
        numpy.ndarray
            Shape (B, *lengths of the box), with any axes in between.
        """
        is_whole = not any(axis in self.inner for axis in axes)
        summed = [] if is_whole else [axis for axis in self.inner if axis not in axes]
        box = [*(box or [slice(0, len(axis)) for axis in axes]), *(slice(0, len(axis)) for axis in summed)]
        first = self.first if is_whole else self.first + self.block - math.prod(map(len, self.inner))
        lengths, strides = [along.stop - along.start for along in box], []
        for axis, along in zip([*axes, *summed], box, strict=True):
            stride, is_falling = self.strides[axis.name], axis.coordinate.is_falling
            first += stride * (len(axis) - 1 - along.start if is_falling else along.start)
            strides.append(-stride if is_falling else stride)
        if is_whole:  # the block is one more axis, with the row for the outside
            lengths, strides = [*lengths, self.span or self.block], [*strides, 1]
        values = _strided(rows, first, lengths, strides)
        others = tuple(range(len(axes) - len(lengths), 0))
        return values.sum(axis=others) if others else values


def _strided(
    rows: Callable[[int, int], np.ndarray], first: int, lengths: Sequence[int], strides: Sequence[int]
) -> np.ndarray:
    """Return (B, ..., *lengths) of rows first + index * stride, of which only the span in between is read."""
    spans = [(length - 1) * stride for length, stride in zip(lengths, strides, strict=True)]
    low, high = first + sum(min(0, span) for span in spans), first + sum(max(0, span) for span in spans)
    values = rows(low, high + 1)
    steps = (*values.strides[:-1], *(values.strides[-1] * stride for stride in strides))
    return as_strided(values[..., first - low :], (*values.shape[:-1], *lengths), steps, writeable=False)


# ---- The rows of each kind of tally.


def side_rows(detector: Detector, shape: Shape, duration: float | None, first: int) -> Rows:
    """Return the rows of one side of a detector: a block per time and speed; in it u, v, azimuth, cosine."""
    outer = _axes({"time": detector.time_edges(duration), "speed": detector.speed_edges()})
    positions, directions = detector.positions, detector.directions
    inner = () if positions is None else _axes(positions.edges(shape), positions.units(shape))
    if directions is not None:  # the cosine or polar angle lies fastest
        edges = directions.edges()
        inner += _axes({name: edges.get(name) for name in ("phi", "mu", "theta")})
    before = len(outer) > 0
    return Rows(first + before, outer, inner, 1 + math.prod(map(len, inner)), before=int(before))


def phase_space_rows(phase_space: PhaseSpace, first: int) -> Rows:
    """Return the rows of a phase space: a block per time."""
    times = (Axis("time", np.array(phase_space.times), is_instants=True),) if phase_space.is_series else ()
    bins = tuple(Axis(name, edges, group=PHASE) for name, edges in phase_space.axes.items())
    return Rows(first, times, bins, 1 + math.prod(map(len, bins)))


def volume_rows(detector: VolumeDetector, shape: Shape, first: int) -> Rows:
    """Return the rows of paths through a volume: a block per cell, of one row without directions."""
    directions = () if detector.directions is None else _axes(detector.directions.edges())
    block = 1 + math.prod(map(len, directions)) if directions else 1
    return Rows(first, _axes(detector.edges(shape)), directions, block)


def _axes(edges: dict[str, np.ndarray | None], units: dict[str, str] | None = None) -> tuple[Axis, ...]:
    """Return the axes that have edges."""
    units = units or {}
    return tuple(
        Axis(name, bounds, units.get(name, "")) for name, bounds in edges.items() if bounds is not None
    )
