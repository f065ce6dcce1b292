"""Axes of bins: what a detector sorts its scores by, one line per coordinate."""

from __future__ import annotations

from collections.abc import Mapping
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
    symbol: in labels, its name if it is "".
    """

    group: str
    unit: str
    column: str
    is_falling: bool = False
    symbol: str = ""


# Every coordinate that can be binned. A new kind of axis is a new line.
COORDINATES = {
    "medium": Coordinate(MEDIUM, "1", ""),
    "time": Coordinate(TIME, "s", "time"),
    "speed": Coordinate(SPEED, "m s^-1", "speed"),
    "u": Coordinate(POSITION, "", "u"),
    "v": Coordinate(POSITION, "", "v"),
    "mu": Coordinate(DIRECTION, "1", "mu", symbol="μ"),
    "theta": Coordinate(DIRECTION, "rad", "mu", is_falling=True, symbol="θ"),
    "phi": Coordinate(DIRECTION, "rad", "turn", symbol="φ"),
    "x": Coordinate(CELL, "m", "x"),
    "y": Coordinate(CELL, "m", "y"),
    "z": Coordinate(CELL, "m", "z"),
    "r": Coordinate(CELL, "m", "r"),
    "vx": Coordinate(PHASE, "m s^-1", "vx"),
    "vy": Coordinate(PHASE, "m s^-1", "vy"),
    "vz": Coordinate(PHASE, "m s^-1", "vz"),
}


AXES_OF_PLACES = (
    "time",
    "medium",
)  # axes that may be lists, such as instants, and not bins


def axis_unit(name: str, units: Mapping[str, str]) -> str:
    """Return the unit of an axis: of these units, or that of its coordinate; "" if neither is known."""
    return units.get(name) or (COORDINATES[name].unit if name in COORDINATES else "")


def axis_symbol(name: str) -> str:
    """Return what a label calls an axis."""
    return (COORDINATES[name].symbol if name in COORDINATES else "") or name


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
