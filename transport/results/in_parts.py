"""Chunked replicates of very many bins: values and errors are memory-mapped, deviations are recomputed.

Arithmetic is also done by chunk, when its values are read, with the functions for plain replicates.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np

from transport.results.aside import let_go, room_for
from transport.results.replicates import Batches, Replicates
from transport.results.stacked import MOST_OF_A_PART, Box, Stacked, boxes_of, cut, lengths_of


class InParts(Replicates):
    """Replicates of `bins`, computed in boxes.

    part: function that computes those of a box;  order: axes, in the order in which boxes are cut.  An
    operation on the deviations of all bins at once gets them, and takes their memory.
    """

    is_in_parts = True

    def __init__(
        self,
        bins: tuple[int, ...],
        order: tuple[int, ...],
        runs: tuple[Batches, ...],
        is_exact: bool,
        part: Callable[[Box], Replicates],
    ) -> None:
        batches = max(len(run) for run in runs)
        boxes = boxes_of(bins, order, max(1, MOST_OF_A_PART // batches))
        known = {"bins": bins, "order": order, "runs": runs, "part": part, "boxes": boxes, "exact": is_exact}
        vars(self).update(known)  # the dataclass is frozen, and its other fields are computed below

    @classmethod
    def of_batches(cls, values: Stacked, run: Batches, exact: bool, counts: Stacked | None) -> InParts:
        """As Replicates.of_batches; counts: numbers of scores by batch."""

        def part(box: Box) -> Replicates:
            scores = None if counts is None else counts.part(box).sum(axis=0)
            return Replicates.of_batches(values.part(box), run, exact, scores)

        return cls(values.shape[1:], values.order, (run,), exact, part)

    @property
    def is_exact(self) -> bool:
        return self.exact

    @property
    def shape(self) -> tuple[int, ...]:
        return self.bins

    @cached_property
    def value(self) -> np.ndarray:
        return np.asarray(self._known[0])

    @cached_property
    def error(self) -> np.ndarray:
        return np.asarray(self._known[1])

    @cached_property
    def _known(self) -> tuple[np.ndarray, np.ndarray]:
        """Values and errors, from one pass over the batches."""
        known = room_for(self.bins, float), room_for(self.bins, float)
        for box in self.boxes:
            part = self.part(box)
            for room, numbers in zip(known, (part.value, part.error), strict=True):
                room[box] = numbers
                let_go(room)
        for room in known:
            room.flags.writeable = False
        return known

    def let_go(self) -> None:
        for room in self._known:
            let_go(room)

    @property
    def reason(self) -> np.ndarray:
        return self._gathered(lambda part: part.reason, object)

    @property
    def dof(self) -> np.ndarray:
        return self._gathered(lambda part: part.dof, float)

    @property
    def scores(self) -> np.ndarray:
        return self._gathered(lambda part: part.scores, float)

    @property
    def scale(self) -> np.ndarray:
        return self._gathered(lambda part: part.scale, float)

    @property
    def deviations(self) -> dict[Batches, np.ndarray]:
        whole = {} if self.exact else {run: np.empty((len(run), *self.bins)) for run in self.runs}
        for box in self.boxes if whole else ():
            for run, of_run in self.part(box).deviations.items():
                whole[run][(slice(None), *box)] = of_run
        return whole

    def unless(self, too_few: np.ndarray) -> InParts:
        return self._made(lambda box: self.part(box).unless(cut(np.asarray(too_few), box)))

    def indexed(self, index: tuple[int | slice, ...]) -> Replicates:
        starts = [along if isinstance(along, slice) else slice(along, along + 1 or None) for along in index]
        box = tuple(slice(*along.indices(count)[:2]) for along, count in zip(starts, self.bins, strict=True))
        if np.prod(lengths_of(box, self.bins)) * max(map(len, self.runs)) > MOST_OF_A_PART:
            return super().indexed(index)
        inner = tuple(slice(None) if isinstance(along, slice) else 0 for along in index)
        return self.part(box).indexed(inner)

    def along(self, own: tuple[str, ...], dims: tuple[str, ...]) -> Replicates:
        return self if own == dims else super().along(own, dims)

    def summed(self, axis: int) -> Replicates:
        axis %= len(self.bins)
        left = self.bins[:axis] + self.bins[axis + 1 :]
        value, scale, scores = np.zeros(left), np.zeros(left), np.zeros(left)
        deviations = {} if self.exact else {run: np.zeros((len(run), *left)) for run in self.runs}
        for box in self.boxes:
            part, into = self.part(box).summed(axis - len(self.bins)), box[:axis] + box[axis + 1 :]
            value[into] += part.value
            scale[into] += part.scale
            scores[into] += part.scores
            for run, of_run in part.deviations.items():
                deviations[run][(slice(None), *into)] += of_run
        return Replicates(value, deviations, scores, self.runs, scale)

    def mapped(self, function: Callable[..., Replicates], operands: tuple[Replicates, ...]) -> InParts:
        """A function of replicates with these bins, or one along an axis; this object is one of them."""
        uncertain = [run for each in operands if not each.is_exact for run in each.runs]
        runs = tuple(dict.fromkeys(uncertain or [run for each in operands for run in each.runs]))

        def part(box: Box) -> Replicates:
            return function(*(_of_box(each, box) for each in operands))

        return InParts(self.bins, self.order, runs, not uncertain, part)

    def _made(self, part: Callable[[Box], Replicates]) -> InParts:
        return InParts(self.bins, self.order, self.runs, self.exact, part)

    def _gathered(self, look: Callable[[Replicates], np.ndarray], kind: type) -> np.ndarray:
        found = np.empty(self.bins, kind)
        for box in self.boxes:
            found[box] = look(self.part(box))
        return found


def replicates_of(
    values: np.ndarray | Stacked, run: Batches, exact: bool, counts: np.ndarray | Stacked | None
) -> Replicates:
    """Make replicates from the means of the batches, (B, *dims); counts: (*dims), or by batch if chunked."""
    kind = InParts if isinstance(values, Stacked) else Replicates
    return kind.of_batches(values, run, exact, counts)


def _of_box(replicates: Replicates, box: Box) -> Replicates:
    if replicates.is_in_parts:
        return replicates.part(box)
    return replicates.rearranged(lambda array: cut(array, box))
