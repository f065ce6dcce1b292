"""Sums over the cells of a sensor in a backward run, per batch; very many cells are computed in chunks."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from transport.cameras import Instrument
from transport.compile.adjoint import Part, Turned
from transport.results.stacked import Stacked, is_large, totals_of


class CellSums:
    """Scores of the histories of a sensor's cells, per batch.

    lamps: indices of the sources that count, None for all.
    """

    def __init__(self, result, sensor, lamps: tuple[int, ...] | None = None) -> None:
        turned: Turned = result.plan.turned
        self.turned, self.batches, self.run, self.plan = turned, result.batches, result.run, result.plan
        self.parts = turned.parts_of(sensor)
        self.is_view = isinstance(sensor, Instrument)
        self.lamps = tuple(range(len(turned.lamps))) if lamps is None else lamps

    @cached_property
    def means(self) -> list[np.ndarray | Stacked]:
        """For each part, the mean radiance of each cell [W m^-2 sr^-1], weights included, (B, cells)."""
        return [
            sum(self._brought(part, lamp) for lamp in self.lamps) / self._born(part) for part in self.parts
        ]

    @cached_property
    def counts(self) -> list[np.ndarray | Stacked]:
        """For each part, how often its cells' histories reached sources, (B, cells)."""
        return [sum(self._met(part, lamp) for lamp in self.lamps) for part in self.parts]

    @property
    def is_thin(self) -> bool:
        """Whether any batch has cells without a history."""
        return not all(self.rows_of(part, "counts", 0).all() for part in self.parts)

    def _brought(self, part: Part, lamp: int) -> np.ndarray:
        return self._weights(part, lamp) * part.gains[lamp]

    def _weights(self, part: Part, lamp: int) -> np.ndarray:
        """Weights that flights and rays brought to a lamp, per cell."""
        weights, scale = self.rows_of(part, "weights", 1 + lamp), self.turned.scales.get(lamp)
        return (
            weights if scale is None else weights + self.rows_of(part, "weights", self.block_of(lamp)) / scale
        )

    def _met(self, part: Part, lamp: int) -> np.ndarray:
        """How often flights and rays reached a lamp, per cell."""
        counts = self.rows_of(part, "counts", 1 + lamp)
        return (
            counts + self.rows_of(part, "counts", self.block_of(lamp))
            if lamp in self.turned.scales
            else counts
        )

    def block_of(self, lamp: int) -> int:
        return 1 + len(self.turned.lamps) + lamp

    def _born(self, part: Part) -> np.ndarray:
        """Histories of each cell.

        Their expectation if a batch has too few for all cells, which is unbiased too.
        """
        born = self.rows_of(part, "counts", 0)
        if born.all():
            return born
        return (self.run.sizes * part.share / part.cells)[:, None]

    def rows_of(self, part: Part, kind: str, block: int) -> np.ndarray | Stacked:
        """(B, cells); for a view with very many cells, computed in chunks."""
        begin, shape = (
            self.turned.first + block * self.turned.cells + part.first,
            (len(self.batches), part.cells),
        )

        def rows(first: int, past: int) -> np.ndarray:
            return np.array([getattr(batch, kind)[begin + first : begin + past] for batch in self.batches])

        if self.is_view and is_large(shape):
            return Stacked(shape, (0,), lambda box: rows(box[0].start, box[0].stop))
        return rows(0, part.cells)


def sum_of(values: np.ndarray | Stacked) -> float | int:
    """Sum over all batches and cells."""
    return totals_of(values).sum() if isinstance(values, Stacked) else values.sum()
