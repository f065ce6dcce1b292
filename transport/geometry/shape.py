"""Base class of all shapes; a point and a Gaussian cloud, which are shapes for sources only."""

import math
from itertools import product
from typing import NamedTuple

import numpy as np

from transport.statistics.normal import MAX_DEVIATION
from transport.validation import (
    LengthsField,
    VectorField,
    as_float,
    as_floats,
    coerce_vector,
    refuse,
    scene_object,
    set_fields,
    short_repr,
)
from transport.vectors import Vector

# ---- Base class of all shapes: bounds, middle, extent, closed or open, finite or infinite.

ROUNDING = 8 * 2.0**-52  # relative tolerance: supports that differ only by rounding of coordinates are equal


class Rim(NamedTuple):
    """Edge of an open surface: a segment with half its vector, or a circle with radius times axis [m]."""

    is_circle: bool
    center: Vector
    span: Vector


class Shape:
    """Base class of all shapes; not instantiated itself.

    A subclass overrides what it can answer. Questions about two shapes are in `relations` and `contacts`.
    """

    is_closed = False
    is_infinite = False
    has_area = True
    is_flat = False  # has a normal and lies in one plane
    is_plane = False  # infinite and flat
    is_convex = False  # closed, and described by inequalities: a whole sphere, a box, a slab
    hole = None
    triangles = 0  # number of triangles of a mesh
    support_breadth = math.inf  # [m] how accurately its coordinates define its support; the largest does best

    @property
    def middle(self) -> Vector:
        """Centre [m].

        Returns
        -------
        tuple of three floats
        """
        return self.center

    @property
    def coordinate_scale(self) -> float:
        """Sum of absolute coordinates and lengths [m] that define the shape, the scale of its rounding."""
        return sum(map(abs, self.middle)) + self.extent

    @property
    def least_width(self) -> float:
        """Least width of a flat shape [m]; infinite for other shapes."""
        return math.inf

    # What to write where there are no coordinates for bins of position.
    coordinates_cure = "use a Rectangle, Disk, Sphere, Cylinder, Cone or Paraboloid"

    coordinate_names = ("u", "v")  # of u and v

    def coordinates(self) -> dict[str, tuple[float, float, str]]:
        """Return the range and the unit of the coordinates u and v of its points; empty if it has none."""
        return {}

    def strip_areas(self, u: np.ndarray) -> np.ndarray:
        """Return the areas between edges u, per unit of v, without cancellation for narrow strips."""
        return u[1:] - u[:-1]

    def pieces(self) -> "tuple[Shape, ...]":
        """Return its pieces with one support each: the faces of a box or slab, else the shape itself."""
        return (self,)

    def primitives(self) -> "tuple[Shape, ...]":
        """Return what the engine intersects and samples: the triangles of a polygon, else the shape."""
        return (self,)

    def inner_sides(self, part: "Shape") -> tuple[bool, bool, bool]:
        """Return which sides of one of several primitives, a triangle, are shared with another one.

        They are the sides opposite to its second, third and first vertex.
        """
        return False, False, False

    def rims(self) -> list[Rim]:
        """Return the edges of a finite open surface; none if they are not known."""
        return []

    def contains(self, points: np.ndarray) -> np.ndarray:
        """Return which points (n, 3) [m] lie in a closed shape, as (n,) of bool; none lie in an open one."""
        return np.zeros(len(points), bool)

    def distance(self, point: Vector, filled: bool = False) -> float:
        """Return the distance [m] of a point; filled: from the volume of a closed shape."""
        return math.hypot(*(p - q for p, q in zip(point, self.middle, strict=True)))

    def sample_area(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return points even over the area, and the normals there, (n, 3) each.

        numbers: (n, 2), even in [0, 1). Points that would lie in a hole are left out.
        """
        raise TypeError(f"{type(self).__name__} has no area")

    @property
    def bounds(self) -> tuple[Vector, Vector]:
        """Lower and upper corner [m] of the smallest axis-aligned box that holds the shape.

        Returns
        -------
        tuple of two tuples of three floats
        """
        return self._bounds_around(self._reach())

    def __str__(self) -> str:
        """The parameters, and where the shape is [m]; `repr` alone is valid Python."""
        if self.is_infinite:
            return repr(self)
        return f"{self!r} with {self._place()} [m]"

    def _place(self) -> str:
        """The bounds of the shape, in words."""
        low, high = self.bounds
        return f"bounds {point_text(low)} and {point_text(high)}"

    def bounds_corners(self) -> list[Vector]:
        """Return the eight corners [m] of the bounds."""
        return list(product(*zip(*self.bounds, strict=True)))

    def _bounds_around(self, reach: Vector) -> tuple[Vector, Vector]:
        """Lower and upper corner [m] at distances `reach` from the middle."""
        reach = list(zip(self.middle, reach, strict=True))
        return tuple(c - r for c, r in reach), tuple(c + r for c, r in reach)

    @property
    def extent(self) -> float:
        """Half diagonal of the bounds [m].

        Returns
        -------
        float
        """
        return math.hypot(*self._reach())

    @property
    def mean_chord(self) -> float:
        """Mean chord of the volume within in isotropic light [m], 4 volumes per area (Cauchy)."""
        return 4 * self.volume / self.area

    def _check_size(self, *names: str) -> None:
        """Raise if area, volume or bounds overflow or underflow a double."""
        sizes = {"area": self.area} | ({"volume": self.volume} if self.is_closed else {})
        for quantity, size in sizes.items():
            if not 0 < size < math.inf:
                values = ", ".join(f"{name}={short_repr(getattr(self, name))}" for name in names)
                refuse(
                    self, f"{quantity} must be positive and finite, got {size} from {values}; change the unit"
                )
        if not all(map(math.isfinite, (*self.bounds[0], *self.bounds[1]))):
            refuse(self, f"bounds must be finite, got {self.bounds}; move center towards the origin")


# ---- Point and Gaussian cloud: shapes for sources only.


@scene_object(kw_only=True)
class Point(Shape):
    """Point, for sources only.

    Parameters
    ----------
    position : three floats, default (0, 0, 0)
        Position [m].

    Examples
    --------
    >>> import transport as tp
    >>> tp.Point(position=(0, 0, 1)).middle
    (0.0, 0.0, 1.0)
    """

    position: VectorField = (0.0, 0.0, 0.0)
    extent = 0.0
    has_area = False

    def __post_init__(self) -> None:
        coerce_vector(self, "position")

    @property
    def middle(self) -> Vector:
        """Position [m]."""
        return self.position

    def sample_area(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the position, and normals of length 0."""
        return np.tile(np.array(self.position), (len(numbers), 1)), np.zeros((len(numbers), 3))

    def _reach(self) -> Vector:
        """Half extents [m] along the axes: 0."""
        return 0.0, 0.0, 0.0


@scene_object(kw_only=True)
class Cloud(Shape):
    """Gaussian cloud of positions, for the emission Gas only.

    Parameters
    ----------
    center : three floats, default (0, 0, 0)
        Mean position [m].
    sigma : float or three floats
        Standard deviation [m], one for all axes or one per axis; 0 or more, not all 0.

    Notes
    -----
    `bounds` lie 8.5 sigma from the centre, beyond which no position is sampled.

    Examples
    --------
    >>> import transport as tp
    >>> tp.Cloud(sigma=1e-3).sigma
    (0.001, 0.001, 0.001)
    """

    center: VectorField = (0.0, 0.0, 0.0)
    sigma: LengthsField
    has_area = False

    def __post_init__(self) -> None:
        coerce_vector(self, "center")
        every = as_float(self.sigma)
        sigma = as_floats(self.sigma if every is None else (every,) * 3)
        if sigma is None or len(sigma) != 3 or min(sigma) < 0 or not 0 < max(sigma) < 1e300:
            must = f"one or three lengths, 0 or more and not all 0, got {short_repr(self.sigma)}"
            refuse(self, f"sigma must be {must}; for a source without extent write Point(position=...)")
        set_fields(self, sigma=sigma)

    @property
    def volume(self) -> float:
        """Effective volume [m^3], the number over the density at the centre."""
        return (2 * math.pi) ** 1.5 * math.prod(self.sigma)

    def _reach(self) -> Vector:
        """Half extents [m] along the axes."""
        return tuple(MAX_DEVIATION * length for length in self.sigma)


def point_text(point: Vector) -> str:
    """Write a point with six digits: (0.5, -1, 2)."""
    return f"({', '.join(f'{x + 0.0:.6g}' for x in point)})"
