"""Bins of place as they lie: a rectangle and a cell in metres, a disk round, a ball and a tube by angle."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from transport import EstimateArray
from transport.geometry.flat import Disk, Rectangle
from transport.geometry.solid import Sphere
from transport.results.volumes import VolumeReading
from transport.viz.wording import unit_of_length

PLACES = ("u", "v", "x", "y", "z", "r")  # axes that are places


class Coordinate(NamedTuple):
    """One axis of a map: its words, its unit ("deg" where `scale` turns radians), and the factor to it."""

    words: str
    unit: str
    scale: float = 1.0

    @property
    def is_length(self) -> bool:
        return self.unit != "deg"

    @property
    def is_downwards(self) -> bool:
        """Whether its zero is on top: the pole of a ball, which is seen from outside."""
        return self.words == "polar angle"


METRES = {name: Coordinate(name, "m") for name in PLACES}
TURN = Coordinate("azimuth", "deg", 180 / math.pi)
COORDINATES = {  # of shapes whose (u, v) are not both metres along the sides
    Disk: {"u": Coordinate("radius", "m"), "v": TURN},
    Sphere: {"u": Coordinate("polar angle", "deg", 180 / math.pi), "v": TURN},
}
OF_REVOLVED = {"u": Coordinate("height along the axis", "m"), "v": TURN}


@dataclass(frozen=True, eq=False)
class Places:
    """Bins over one or two coordinates; the first one is across the picture.

    edges: of each, in the unit of its axis;  value, error, unscored, doubtful: (across, up), or (across,);  is_round: a radius and an azimuth;
    taken, order: which bins of the detector's these are, and in which order of its axes.
    """

    axes: tuple[Coordinate, ...]
    edges: tuple[np.ndarray, ...]
    value: np.ndarray
    error: np.ndarray
    unscored: np.ndarray
    doubtful: np.ndarray
    unit: object
    is_round: bool
    taken: tuple[int | slice, ...]
    order: tuple[int, ...]

    @property
    def is_metric(self) -> bool:
        """Whether both coordinates are lengths, to be drawn on one scale."""
        return all(axis.is_length for axis in self.axes)

    def middles(self, axis: int) -> np.ndarray:
        """The middles of the bins along an axis."""
        return 0.5 * (self.edges[axis][1:] + self.edges[axis][:-1])

    def arranged(self, field: np.ndarray) -> np.ndarray:
        """Of numbers for all bins of the detector's those that are here, (across, up) or (across,)."""
        return np.transpose(field[self.taken], self.order)


def places_of(reading: object, quantity: str, at: Mapping[str, int] | None = None) -> Places:
    """The bins of a detector's quantity by place, such as `result["meter"]` and "irradiance".

    at: which bin to take along other axes, such as {"time": 3}; of three axes of cells one is taken in the middle, across z
    first.  Raises ValueError for a quantity without bins of place, and for other axes of which no bin is told.
    """
    array = getattr(reading, quantity)
    if not isinstance(array, EstimateArray) or not set(array.dims) & set(PLACES):
        cure = "give it positions=Positions(...), or cells=..."
        raise ValueError(f"{reading.name!r}: {quantity} has no bins of place; {cure}")
    taken = _taken(array, at or {}, f"{reading.name!r}: {quantity}")
    shown, field = array[taken], (array.value, array.error, array.reason == "no score", array.is_doubtful)
    names = _in_order(shown.dims, shape_of(reading))
    order = tuple(shown.dims.index(name) for name in names)
    axes = tuple(names.values())
    edges = tuple(shown.coords[name] * axis.scale for name, axis in names.items())
    axes, edges = _in_suitable_units(axes, edges)
    fields = (np.transpose(each[taken], order) for each in field)
    is_round = isinstance(shape_of(reading), Disk) and len(names) == 2
    return Places(axes, edges, *fields, array.unit, is_round, taken, order)


def _in_suitable_units(
    axes: tuple[Coordinate, ...], edges: tuple[np.ndarray, ...]
) -> tuple[tuple[Coordinate, ...], tuple[np.ndarray, ...]]:
    """Lengths in one unit, such as µm, in which they are neither tiny nor huge numbers."""
    largest = max(
        (np.abs(e).max() for axis, e in zip(axes, edges, strict=True) if axis.is_length), default=1.0
    )
    size, unit = unit_of_length(float(largest))
    told = tuple(axis._replace(unit=unit) if axis.is_length else axis for axis in axes)
    return told, tuple(e / size if axis.is_length else e for axis, e in zip(axes, edges, strict=True))


def words_of(shape: object) -> dict[str, str]:
    """What the coordinates u and v of a curved shape or a disk are, such as "azimuth v"; nothing where they are lengths along sides."""
    found = _in_order(("u", "v"), shape) if shape is not None and shape.coordinates() else {}
    return {name: f"{axis.words} {name}" for name, axis in found.items() if axis.words != name}


def _in_order(dims: tuple[str, ...], shape: object) -> dict[str, Coordinate]:
    """The coordinates of these axes, the one across the picture first: of a curved surface it is the azimuth."""
    if not set(dims) <= {"u", "v"} or isinstance(shape, Rectangle):
        return {name: METRES[name] for name in dims}
    kind = next((kind for kind in COORDINATES if isinstance(shape, kind)), None)
    across_first = ("u", "v") if kind is Disk else ("v", "u")
    return {name: COORDINATES.get(kind, OF_REVOLVED)[name] for name in across_first if name in dims}


def _taken(array: EstimateArray, at: Mapping[str, int], whose: str) -> tuple[int | slice, ...]:
    """Which bins are drawn: of the axes of place two at most, and of all others one."""
    if strangers := set(at) - set(array.dims):
        raise ValueError(f"{whose} has no axes {sorted(strangers)}; there are {array.dims}")
    at, length = dict(at), dict(zip(array.dims, array.shape, strict=True))
    for name in sorted(set(array.dims) & set("xyz"), key=lambda name: (length[name] > 1, -ord(name))):
        free = [dim for dim in array.dims if dim in PLACES and dim not in at]
        if name in free and len(free) > (1 if length[name] == 1 else 2):
            at[name] = length[name] // 2
    left = [name for name in array.dims if name not in at]
    others = [name for name in left if name not in PLACES]
    if others or not left:
        example = f"write at={{{others[0]!r}: 0}} for the first" if others else "leave one out of at="
        raise ValueError(f"{whose}: a map by place has no axes but places, got {left}; {example}")
    return tuple(at.get(name, slice(None)) for name in array.dims)


def shape_of(reading: object) -> object:
    """The shape that a detector looks at; None of a volume."""
    return None if isinstance(reading, VolumeReading) else getattr(reading, "shape", None)
