"""Find the few among many shapes that a relation may hold for, without a comparison of each with each."""

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import product

import numpy as np

from transport.geometry.revolved import Revolved
from transport.geometry.shape import ROUNDING, Shape
from transport.geometry.solid import Sphere
from transport.vectors import dot

SLACK = 64  # of the tolerance, over the rounding of coordinates
CELL = 1000  # width of a cell in tolerances: a shape rarely has to look into two
OFFSET = 0.382  # of the grid, in cells: simple numbers such as 0 lie within a cell


class Supports:
    """Numbered supports in a grid: planes, spheres, axes, by coordinates that are equal for equal supports.

    These are the squares of the components of the normal or axis, and the foot of the perpendicular from the
    origin; for a sphere the centre and the radius; relative to the largest of them, or to a `size` [m] beyond
    it. The tolerance bounds the difference that rounding leaves between shapes on one support: it tilts the
    narrowest of them most.
    """

    def __init__(self, shapes: Sequence[Shape], size: float = 0.0) -> None:
        self.size = max((shape.coordinate_scale for shape in shapes), default=0.0)
        self.size = max(self.size, size) or 1.0
        narrowest = min(map(_width, shapes), default=math.inf)
        self.tolerance = SLACK * ROUNDING * max(1.0, self.size / narrowest)
        self.numbers: dict[tuple, list[int]] = {}  # by cell

    def add(self, number: int, support: Shape) -> None:
        """Add the support of a shape; numbers rise."""
        (cell,) = self._cells(support, 0.0)
        self.numbers.setdefault(cell, []).append(number)

    def near(self, shape: Shape) -> list[int]:
        """Return the numbers of all supports, in order, on which a shape may lie."""
        cells = self._cells(shape, 1.0 / CELL)
        return sorted(number for cell in cells for number in self.numbers.get(cell, ()))

    def _cells(self, shape: Shape, reach: float) -> Iterable[tuple]:
        """Return the cells within a reach [cells] of a shape's support."""
        kind, coordinates = self.coordinates(shape)
        width = CELL * self.tolerance
        places = [x / width + OFFSET for x in coordinates]
        ends = ({math.floor(place - reach), math.floor(place + reach)} for place in places)
        return product((kind,), *ends)

    def coordinates(self, shape: Shape) -> tuple[object, Iterator[float]]:
        """Return the kind of a support, and its coordinates relative to the largest coordinate."""
        if shape.is_flat:
            normal = shape.normal
            height = dot(normal, shape.center) / self.size
            return "plane", (*(x * x for x in normal), *(height * x for x in normal))
        if isinstance(shape, Sphere):
            return "sphere", tuple(x / self.size for x in (*shape.center, shape.radius))
        if isinstance(shape, Revolved):
            axis, origin = shape.axis, shape.profile.origin
            along = dot(axis, origin)
            foot = ((o - along * a) / self.size for o, a in zip(origin, axis, strict=True))
            return "axis", (*(x * x for x in axis), *foot)
        return shape, ()


def _width(shape: Shape) -> float:
    """Return the length [m] over which rounding may tilt a shape's support."""
    if isinstance(shape, Revolved) and not isinstance(shape, Sphere):
        return shape.profile.high - shape.profile.low
    return shape.least_width


def touching_boxes(low: np.ndarray, high: np.ndarray) -> list[np.ndarray]:
    """Return for each box, given by its corners (n, 3), the sorted numbers of the others that it touches."""
    ones, others = [], []
    for k, near in _later_boxes(low, high):
        near = near[((low[near] <= high[k]) & (low[k] <= high[near])).all(axis=1)]
        ones.append(np.full(len(near), k))
        others.append(near)
    if not ones:
        return []
    one, other = np.concatenate(ones), np.concatenate(others)
    one, other = np.append(one, other), np.append(other, one)
    order = np.lexsort((other, one))
    return np.split(other[order], np.searchsorted(one[order], np.arange(1, len(low))))


def _later_boxes(low: np.ndarray, high: np.ndarray) -> Iterator[tuple[int, np.ndarray]]:
    """Yield each box with those that begin later, but before its end, along the axis with fewest of these."""
    orders = np.argsort(low, axis=0, kind="stable")
    starts = np.take_along_axis(low, orders, axis=0)
    ends = [np.searchsorted(starts[:, a], high[orders[:, a], a], side="right") for a in range(3)]
    axis = min(range(3), key=lambda a: ends[a].sum())
    order = orders[:, axis]
    for place, (k, past) in enumerate(zip(order.tolist(), ends[axis].tolist(), strict=True)):
        yield k, order[place + 1 : past]
