"""Axes of bins: what a detector sorts its scores by, one line per coordinate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

# Groups of axes. A quantity keeps the axes of a group, or sums over them.
TIME, SPEED, POSITION, DIRECTION, CELL, PHASE = "time", "speed", "position", "direction", "cell", "phase"
MEDIUM = "medium"


@dataclass(frozen=True)
class Coordinate:
    """A coordinate of phase space that scores can be sorted by.

    group: the group of its axes;  unit: SI unit, "" where it depends on the shape (lengths or angles);
    column: prefix of its columns in the engine's tables;  is_falling: whether the engine's coordinate falls
    where this one rises, so that rows lie in the opposite order (the engine bins cosines for theta);
    symbol: in short labels, its name if it is "";  words: in long labels, its symbol if they are "";
    is_from_pole: whether it is an angle from a pole, which pictures have on top.
    """

    group: str
    unit: str
    column: str
    is_falling: bool = False
    symbol: str = ""
    words: str = ""
    is_from_pole: bool = False


# Every coordinate that can be binned. A new kind of axis is a new line.
COORDINATES = {
    "medium": Coordinate(MEDIUM, "1", ""),
    "time": Coordinate(TIME, "s", "time"),
    "speed": Coordinate(SPEED, "m s^-1", "speed"),
    "u": Coordinate(POSITION, "", "u"),
    "v": Coordinate(POSITION, "", "v"),
    "s": Coordinate(POSITION, "m", "s"),
    "t": Coordinate(POSITION, "m", "t"),
    "face": Coordinate(DIRECTION, "1", "face"),
    "mu": Coordinate(DIRECTION, "1", "mu", symbol="μ", words="cosine μ"),
    "theta": Coordinate(
        DIRECTION, "rad", "mu", is_falling=True, symbol="θ", words="polar angle θ", is_from_pole=True
    ),
    "phi": Coordinate(DIRECTION, "rad", "turn", symbol="φ", words="azimuth φ"),
    "x": Coordinate(CELL, "m", "x"),
    "y": Coordinate(CELL, "m", "y"),
    "z": Coordinate(CELL, "m", "z"),
    "r": Coordinate(CELL, "m", "r"),
    "vx": Coordinate(PHASE, "m s^-1", "vx", words="velocity vₓ"),
    "vy": Coordinate(PHASE, "m s^-1", "vy", words="velocity v_y"),
    "vz": Coordinate(PHASE, "m s^-1", "vz", words="velocity v_z"),
}


# What the axes u and v (`column`) are on shapes, by the names that the shapes give their coordinates.
SHAPE_COORDINATES = {
    "x": Coordinate(POSITION, "", "u"),
    "radius": Coordinate(POSITION, "", "u", words="radius u"),
    "height": Coordinate(POSITION, "", "u", words="height u along the axis"),
    "polar_angle": Coordinate(POSITION, "", "u", words="polar angle u", is_from_pole=True),
    "y": Coordinate(POSITION, "", "v"),
    "azimuth": Coordinate(POSITION, "", "v", words="azimuth v"),
}
POLAR_AXES = ("mu", "theta")
AXES_OF_PLACES = ("time", "medium")  # axes that may be lists, such as instants, and not bins


def name_on_shape(name: str, names: Sequence[str] = ("u", "v")) -> str:
    """Return the name of an axis on a shape that calls its coordinates u and v by these names."""
    return names["uv".index(name)] if name in ("u", "v") else name


def axis_coordinate(name: str, names: Sequence[str] = ("u", "v")) -> Coordinate | None:
    """Return the coordinate of an axis, on a shape with coordinates of these names; None if unknown."""
    own = SHAPE_COORDINATES.get(name_on_shape(name, names)) if name in ("u", "v") else None
    return own or COORDINATES.get(name)


def axis_unit(name: str, units: Mapping[str, str]) -> str:
    """Return the unit of an axis: of these units, or that of its coordinate; "" if neither is known."""
    return units.get(name) or (COORDINATES[name].unit if name in COORDINATES else "")


def axis_symbol(name: str) -> str:
    """Return what a short label calls an axis."""
    return (COORDINATES[name].symbol if name in COORDINATES else "") or name


def axis_words(name: str, names: Sequence[str] = ("u", "v")) -> str:
    """Return what a long label calls an axis, on a shape with coordinates of these names.

    Examples
    --------
    >>> axis_words("phi"), axis_words("u"), axis_words("u", ("radius", "azimuth"))
    ('azimuth φ', 'u', 'radius u')
    """
    coordinate = axis_coordinate(name, names)
    return (coordinate.words if coordinate else "") or axis_symbol(name)


def axis_places(edges: np.ndarray, bins: int) -> dict[str, np.ndarray]:
    """Return where the bins of an axis lie: centres "", edges "_low" and "_high"; of instants the times."""
    if len(edges) == bins:
        return {"": edges}
    return {"": 0.5 * (edges[1:] + edges[:-1]), "_low": edges[:-1], "_high": edges[1:]}


@dataclass(frozen=True, eq=False)
class Axis:
    """One axis of bins.

    Parameters
    ----------
    name : str
        One of COORDINATES; the name of the dimension in results.
    edges : numpy.ndarray
        Rising edges of the n bins in SI units, (n + 1,); of instants the times themselves, (n,).
    unit, group : str, default ""
        Those of the coordinate, unless the shape or the detector decides.
    is_instants : bool, default False
        Whether the axis is a list of instants and not of bins.

    Examples
    --------
    >>> theta = Axis("theta", np.linspace(0.0, np.pi / 2, 4))
    >>> len(theta), theta.group, theta.unit
    (3, 'direction', 'rad')
    """

    name: str
    edges: np.ndarray
    unit: str = ""
    group: str = ""
    is_instants: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "unit", self.unit or self.coordinate.unit)
        object.__setattr__(self, "group", self.group or self.coordinate.group)

    def __len__(self) -> int:
        return len(self.edges) - (not self.is_instants)

    @property
    def coordinate(self) -> Coordinate:
        """The coordinate of that name."""
        return COORDINATES[self.name]
