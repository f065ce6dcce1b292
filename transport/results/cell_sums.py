"""Sums over the cells of a sensor in a backward run, per batch; very many cells are computed in chunks."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from transport.cameras import Instrument
from transport.compile.adjoint import Part, Turned
from transport.compile.sizes import LARGE
from transport.results.findings import Finding
from transport.results.path_classes import Met, chances_of_sensor
from transport.results.proofs import events_of
from transport.results.stacked import Stacked, is_large, totals_of

ALIKE = 1e-9  # relative difference below which weights of cells are equal


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
        return not all(self._rows(part, "counts", 0).all() for part in self.parts)

    def _brought(self, part: Part, lamp: int) -> np.ndarray:
        return self._weights(part, lamp) * part.gains[lamp]

    def _weights(self, part: Part, lamp: int) -> np.ndarray:
        """Weights that flights and rays brought to a lamp, per cell."""
        weights, scale = self._rows(part, "weights", 1 + lamp), self.turned.scales.get(lamp)
        return weights if scale is None else weights + self._rows(part, "weights", self._block(lamp)) / scale

    def _met(self, part: Part, lamp: int) -> np.ndarray:
        """How often flights and rays reached a lamp, per cell."""
        counts = self._rows(part, "counts", 1 + lamp)
        return (
            counts + self._rows(part, "counts", self._block(lamp)) if lamp in self.turned.scales else counts
        )

    def _block(self, lamp: int) -> int:
        return 1 + len(self.turned.lamps) + lamp

    def _born(self, part: Part) -> np.ndarray:
        """Histories of each cell.

        Their expectation if a batch has too few for all cells, which is unbiased too.
        """
        born = self._rows(part, "counts", 0)
        if born.all():
            return born
        return (self.run.sizes * part.share / part.cells)[:, None]

    def _rows(self, part: Part, kind: str, block: int) -> np.ndarray | Stacked:
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

    def _met_by(self, lamp: int, chosen: list[np.ndarray | None]) -> Met:
        """How often flights and rays of the chosen cells (None: all) reached a lamp.

        Rays only if it has any.
        """

        def number(kind: str, block: int) -> int:
            rows = (self._rows(part, kind, block) for part in self.parts)
            return round(
                sum(
                    sum_of(each if which is None else each[:, which])
                    for each, which in zip(rows, chosen, strict=True)
                )
            )

        flights, block = number("counts", 1 + lamp), self._block(lamp)
        if lamp not in self.turned.scales:
            return Met(flights, 0, 0)
        return Met(flights, number("counts", block), number("slants", block))

    def _weights_of_cells(self, extents: list[np.ndarray]) -> list[np.ndarray]:
        """For each part's cells, the effect of a score on the mean over all, relative to equal cells."""
        shares, whole = sum(part.share for part in self.parts), sum(float(each.sum()) for each in extents)
        return [
            each / whole * part.cells * shares / part.share
            for part, each in zip(self.parts, extents, strict=True)
        ]

    def missing(self, sensor: object, title: str, extents: list[np.ndarray] | None = None) -> list[Finding]:
        """Findings for a sensor, with bounds as mean radiances over its cells [W m^-2 sr^-1].

        extents: of each part's cells, as weights of the mean; None for equal weights.
        """
        histories = sum(part.share for part in self.parts) * self.run.sizes.sum()
        heaviest, chosen = 1.0, [None] * len(self.parts)
        if extents is not None:
            weights = self._weights_of_cells(extents)
            most = max(float(each.max()) for each in weights)
            if most > 1 + ALIKE:  # scores in small cells do not represent those in large ones
                heaviest, chosen = most, [each >= LARGE * most for each in weights]
        met = {lamp: self._met_by(lamp, chosen) for lamp in self.lamps}
        error = 0.0
        if not self.is_view:
            each = sum(
                part.share * mean.mean(axis=1) for part, mean in zip(self.parts, self.means, strict=True)
            )
            error = float(np.std(each) / np.sqrt(len(each))) / sum(part.share for part in self.parts)
        events = events_of(self.batches)
        return list(
            chances_of_sensor(
                self.plan, title, sensor, self.parts, met, histories, error, heaviest, events=events
            )
        )


def sum_of(values: np.ndarray | Stacked) -> float | int:
    """Sum over all batches and cells."""
    return totals_of(values).sum() if isinstance(values, Stacked) else values.sum()
