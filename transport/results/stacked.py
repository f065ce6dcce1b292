"""Chunked arrays: batch values in very many bins, computed box by box to limit memory.

The cost of a box of bins is that of its rows if these are adjacent, so boxes are cut along the axis whose
bins are farthest apart in memory.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

MOST_AT_ONCE = 1 << 24  # numbers of batches in one array
MOST_OF_A_PART = 1 << 20  # numbers of batches in a box
Box = tuple[slice, ...]  # of bins, one slice per axis


class Stacked:
    """A virtual array (B, *dims) with the arithmetic that readings need before they make estimates.

    part: function that computes a box, (B, *its lengths);  order: axes of the bins, those farthest apart in
    memory first.
    """

    __array_ufunc__ = None  # NumPy defers to the operators of this class

    def __init__(self, shape: tuple[int, ...], order: tuple[int, ...], part: Callable[[Box], np.ndarray]):
        self.shape, self.order, self.part = shape, order, part

    @property
    def ndim(self) -> int:
        return len(self.shape)

    def __len__(self) -> int:
        return self.shape[0]

    def __mul__(self, other: object) -> Stacked:
        return self._with(other, np.multiply)

    def __truediv__(self, other: object) -> Stacked:
        return self._with(other, np.divide)

    def __add__(self, other: object) -> Stacked:
        return self._with(other, np.add)

    __radd__ = __add__  # for sum(), which starts with 0

    def boxes(self) -> list[Box]:
        """Boxes of limited size that together contain every bin once."""
        return boxes_of(self.shape[1:], self.order, MOST_OF_A_PART // len(self))

    def any(self) -> bool:
        """Whether any number is nonzero."""
        return any(self.part(box).any() for box in self.boxes())

    def all(self) -> bool:
        """Whether all numbers are nonzero."""
        return all(self.part(box).all() for box in self.boxes())

    def reshape(self, *shape: int) -> Stacked:
        """Add or drop axes of length 1.  Raises ValueError for any other change of shape."""
        kept = [axis for axis, bins in enumerate(self.shape[1:]) if bins != 1]
        wanted = [bins for bins in shape[1:] if bins != 1]
        if wanted != [self.shape[1 + axis] for axis in kept]:
            raise ValueError(f"batches of bins {self.shape[1:]} cannot become {shape[1:]}")
        into = [place for place, bins in enumerate(shape[1:]) if bins != 1]

        def part(box: Box) -> np.ndarray:
            whole = [slice(0, 1)] * (self.ndim - 1)
            for axis, place in zip(kept, into, strict=True):
                whole[axis] = box[place]
            return self.part(tuple(whole)).reshape(len(self), *lengths_of(box, shape[1:]))

        order = [into[kept.index(axis)] for axis in self.order if axis in kept]
        order += [place for place in range(len(shape) - 1) if place not in order]
        return Stacked(tuple(shape), tuple(order), part)

    def split(self, bins: tuple[int, ...]) -> Stacked:
        """Split one axis of bins, stored with the last axis fastest, into (B, *bins)."""

        def part(box: Box) -> np.ndarray:
            return in_box(lambda first, many: self.part((slice(first, first + many),)), box, bins)

        return Stacked((len(self), *bins), tuple(range(len(bins))), part)

    def swapped(self) -> Stacked:
        """Swap two axes of bins, (B, a, b) to (B, b, a), with b reversed."""
        last = self.shape[2]

        def part(box: Box) -> np.ndarray:
            turned = slice(last - box[0].stop, last - box[0].start)
            return self.part((box[1], turned)).swapaxes(1, 2)[:, ::-1]

        return Stacked((len(self), last, self.shape[1]), (1, 0), part)

    def sum(self, axis: int | tuple[int, ...]) -> Stacked:
        """Sums over axes of bins, counted with the batch axis."""
        axis = tuple(np.atleast_1d(axis) % self.ndim)
        kept = [place for place in range(self.ndim - 1) if place + 1 not in axis]

        def part(box: Box) -> np.ndarray:
            whole = [slice(0, bins) for bins in self.shape[1:]]
            for place, along in zip(kept, box, strict=True):
                whole[place] = along
            return self.part(tuple(whole)).sum(axis=axis)

        order = tuple(kept.index(place) for place in self.order if place in kept)
        return Stacked((len(self), *(self.shape[1 + place] for place in kept)), order, part)

    def _with(self, other: object, function: Callable) -> Stacked:
        return Stacked(
            self.shape, self.order, lambda box: function(self.part(box), _cut(other, box, self.ndim))
        )


def is_large(shape: tuple[int, ...]) -> bool:
    """Whether numbers of this shape, (B, *dims), are too many for one array; those of one batch are not."""
    return shape[0] > 1 and math.prod(shape) > MOST_AT_ONCE


def totals_of(values: np.ndarray | Stacked) -> np.ndarray:
    """Sums of each batch over all bins, (B,)."""
    if isinstance(values, Stacked):
        return sum(totals_of(values.part(box)) for box in values.boxes())
    return values.reshape(len(values), -1).sum(axis=1)


def counts_told(counts: np.ndarray | Stacked) -> np.ndarray | Stacked:
    """Counts (B, *dims) as an argument of EstimateArray: summed over batches, or chunked counts unchanged."""
    return counts if isinstance(counts, Stacked) else counts.sum(axis=0)


def over_batches(values: np.ndarray | Stacked) -> np.ndarray:
    """Sums over the batches, (*dims)."""
    if not isinstance(values, Stacked):
        return values.sum(axis=0)
    found = np.zeros(values.shape[1:])
    for box in values.boxes():
        found[box] = values.part(box).sum(axis=0)
    return found


def in_box(rows: Callable[[int, int], np.ndarray], box: Box, bins: tuple[int, ...]) -> np.ndarray:
    """The numbers in a box of bins, read as one stretch of rows; rows are in order, the last axis fastest.

    rows: function of (first, many) that returns (B, many).
    """
    lengths, strides = lengths_of(box, bins), [math.prod(bins[axis + 1 :]) for axis in range(len(bins))]
    wide = next((axis for axis, length in enumerate(lengths) if length > 1), len(bins) - 1)
    first = sum(along.start * stride for along, stride in zip(box[: wide + 1], strides, strict=False))
    values = rows(first, lengths[wide] * strides[wide])
    values = values.reshape(-1, *[1] * wide, lengths[wide], *bins[wide + 1 :])
    return values[(..., *box[wide + 1 :])]


def boxes_of(bins: tuple[int, ...], order: tuple[int, ...], most: int) -> list[Box]:
    """Boxes of at most `most` bins each, or of one, that together are all bins."""
    boxes, left = [[slice(0, count) for count in bins]], math.prod(bins)
    for axis in order:
        if left <= most:
            break
        left //= max(1, bins[axis])  # bins per step along this axis
        step = max(1, most // max(1, left))
        cuts = [slice(k, min(k + step, bins[axis])) for k in range(0, bins[axis], step)]
        boxes = [[*box[:axis], cut, *box[axis + 1 :]] for box in boxes for cut in cuts]
        left *= step
    return [tuple(box) for box in boxes]


def lengths_of(box: Box, bins: tuple[int, ...]) -> tuple[int, ...]:
    """Lengths of a box along the axes."""
    return tuple(len(range(*along.indices(count))) for along, count in zip(box, bins, strict=True))


def cut(array: np.ndarray, box: Box) -> np.ndarray:
    """The part in a box of an array whose last axes are those of the bins, or have length 1."""
    along = [
        slice(None) if length == 1 else one for one, length in zip(box[::-1], array.shape[::-1], strict=False)
    ]
    return array[(..., *along[::-1])]


def _cut(other: object, box: Box, ndim: int) -> object:
    """The part in a box of the other operand."""
    if isinstance(other, Stacked):
        return other.part(box)
    return cut(other, box) if isinstance(other, np.ndarray) else other
