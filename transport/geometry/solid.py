"""Closed shapes with a volume and outward normals: sphere (also its zones and caps) and box."""

import math

import numpy as np

from transport.geometry.flat import Rectangle
from transport.geometry.revolved import Profile, Revolved
from transport.geometry.shape import Shape
from transport.validation import (
    LengthsField,
    VectorField,
    as_float,
    as_floats,
    coerce_positive,
    coerce_vector,
    refuse,
    scene_object,
    set_fields,
    short_repr,
)
from transport.vectors import Vector, dot


@scene_object(kw_only=True)
class Sphere(Revolved):
    """Sphere, or a zone or cap of one; normals outwards.

    With bounds on mu = (x - center) · axis / radius it is a zone or cap, which is not closed.

    Parameters
    ----------
    center : three floats, default (0, 0, 0)
        Centre [m].
    radius : float
        Radius [m], positive.
    axis : three floats, default (0, 0, 1)
        Pole of the sphere's coordinates, of any length; stored as a unit vector.
    mu_min : float, default -1
        Lower bound of mu, in [-1, 1].
    mu_max : float, default 1
        Upper bound of mu, in [-1, 1], above `mu_min`.

    Raises
    ------
    SceneError
        If the radius is not positive or the bounds are out of range.

    Examples
    --------
    >>> import transport as tp
    >>> f"{tp.Sphere(radius=1.0).area:.4f}"
    '12.5664'
    >>> tp.Sphere(radius=1.0, mu_min=0.0).is_closed
    False
    """

    center: VectorField = (0.0, 0.0, 0.0)
    radius: float
    axis: VectorField = (0.0, 0.0, 1.0)
    mu_min: float = -1.0
    mu_max: float = 1.0

    def __post_init__(self) -> None:
        self._coerce_axis()
        coerce_positive(self, "radius")
        for name in ("mu_min", "mu_max"):
            cosine = as_float(getattr(self, name))
            if cosine is None or not -1 <= cosine <= 1:
                refuse(self, f"{name} must be a number in [-1, 1], got {short_repr(getattr(self, name))}")
            set_fields(self, **{name: cosine})
        if self.mu_min >= self.mu_max:
            refuse(self, f"mu_min must be below mu_max {self.mu_max}, got {self.mu_min}; exchange them")
        self._check_size("radius", "mu_min", "mu_max")

    @property
    def is_zone(self) -> bool:
        """Whether it is a zone or cap rather than the whole sphere."""
        return self.mu_min > -1 or self.mu_max < 1

    @property
    def is_closed(self) -> bool:
        """Whether it is the whole sphere."""
        return not self.is_zone

    support_breadth = math.inf

    @property
    def is_convex(self) -> bool:
        """Whether it is the whole sphere."""
        return not self.is_zone

    @property
    def coordinate_scale(self) -> float:
        """Sum of the absolute coordinates of the centre, and the radius [m]."""
        return sum(map(abs, self.center)) + self.radius

    @property
    def profile(self) -> Profile:
        """Conic section rho^2 = radius^2 - w^2."""
        low, high = self.radius * self.mu_min, self.radius * self.mu_max
        return Profile(self.radius * self.radius, 0.0, -1.0, low, high, self.center)

    @property
    def area(self) -> float:
        """Area of one side [m^2]."""
        return 2 * math.pi * self.radius * self.radius * (self.mu_max - self.mu_min)

    @property
    def volume(self) -> float:
        """Volume of the whole sphere [m^3]."""
        return 4 * math.pi * self.radius * self.radius * self.radius / 3

    @property
    def middle(self) -> Vector:
        """Centre [m]; for a zone or cap the centre of the smallest sphere that holds it."""
        return super().middle if self.is_zone else self.center

    @property
    def extent(self) -> float:
        """Radius of the smallest sphere that holds it [m]."""
        if not self.is_zone or self.mu_min <= 0 <= self.mu_max:
            return self.radius
        rim = min(abs(self.mu_min), abs(self.mu_max))
        return self.radius * math.sqrt((1 - rim) * (1 + rim))

    @property
    def bounds(self) -> tuple[Vector, Vector]:
        """Lower and upper corner [m] of the smallest axis-aligned box that holds the shape."""
        return super().bounds if self.is_zone else self._bounds_around((self.radius,) * 3)

    coordinate_names = ("polar_angle", "azimuth")  # of u and v

    def coordinates(self) -> dict[str, tuple[float, float, str]]:
        """Return the ranges of the polar angle and the azimuth [rad]."""
        return {"u": (math.acos(self.mu_max), math.acos(self.mu_min), "rad"), "v": (0.0, 2 * math.pi, "rad")}

    def strip_areas(self, u: np.ndarray) -> np.ndarray:
        """Return the areas of zones per azimuth [m^2/rad]."""
        lower, upper = u[:-1], u[1:]
        return 2 * self.radius**2 * np.sin(upper / 2 + lower / 2) * np.sin((upper - lower) / 2)

    @property
    def cross_section(self) -> float:
        """Projected area [m^2] of the whole sphere, the same from everywhere."""
        return math.pi * self.radius * self.radius

    def projected_area(self, direction: Vector) -> float:
        """Area [m^2] of the whole sphere seen along any direction: a quarter of its surface.

        Parameters
        ----------
        direction : three floats
            Unit vector.

        Returns
        -------
        float
            Projected area [m^2].
        """
        return self.cross_section

    def contains(self, points: np.ndarray) -> np.ndarray:
        """Return which points (n, 3) [m] lie in the whole sphere, its surface included."""
        if self.is_zone:
            return super().contains(points)
        direction = points - self.center
        return (direction * direction).sum(axis=1) <= self.radius * self.radius

    def distance(self, point: Vector, filled: bool = False) -> float:
        """Return the distance [m] of a point; filled: from the ball."""
        if self.is_zone:
            return super().distance(point)
        beyond = math.hypot(*(p - q for p, q in zip(point, self.center, strict=True))) - self.radius
        return max(beyond, 0.0) if filled else abs(beyond)

    def _distance_in_plane(self, rho: float, w: float) -> float:
        profile, apart = self.profile, math.hypot(rho, w)
        if profile.low * apart <= w * self.radius <= profile.high * apart:
            return abs(apart - self.radius)
        return min(math.hypot(rho - profile.radius_at(rim), w - rim) for rim in (profile.low, profile.high))


@scene_object(kw_only=True)
class Box(Shape):
    """Axis-aligned box with outward normals.

    Parameters
    ----------
    center : three floats, default (0, 0, 0)
        Centre [m].
    size : float or three floats
        Edge lengths [m] along x, y and z, positive; one number for a cube.

    Raises
    ------
    SceneError
        If a length is not positive and finite.

    Examples
    --------
    >>> import transport as tp
    >>> box = tp.Box(size=(1, 2, 3))
    >>> box.volume, box.area
    (6.0, 22.0)
    >>> box.faces()["+z"].center
    (0.0, 0.0, 1.5)
    """

    center: VectorField = (0.0, 0.0, 0.0)
    size: LengthsField
    is_closed = is_convex = True
    coordinates_cure = "put a Detector on each of its faces() instead"

    def __post_init__(self) -> None:
        coerce_vector(self, "center")
        edge = as_float(self.size)
        size = as_floats(self.size if edge is None else (edge,) * 3)
        if size is None or len(size) != 3 or min(size) <= 0:
            refuse(
                self, f"size must be one or three lengths, positive and finite, got {short_repr(self.size)}"
            )
        set_fields(self, size=size)
        self._check_size("size")

    @property
    def area(self) -> float:
        """Area of the six faces [m^2]."""
        faces = self._face_areas()
        return 2 * (math.fsum(faces) if sum(faces) < math.inf else math.inf)

    @property
    def volume(self) -> float:
        """Volume [m^3]."""
        return math.prod(self.size)

    def faces(self) -> dict[str, Rectangle]:
        """Return the six faces as rectangles with outward normals.

        Returns
        -------
        dict of str to Rectangle
            Keys "-x", "+x", "-y", "+y", "-z", "+z".
        """
        x, y, z = self.size
        lengths = {"x": (z, y), "y": (x, z), "z": (x, y)}  # width and height in each face's default frame
        faces = {}
        for axis, (name, (width, height)) in enumerate(lengths.items()):
            for sign, corner in zip((-1.0, 1.0), self.bounds, strict=True):
                center, normal = list(self.center), [0.0, 0.0, 0.0]
                center[axis], normal[axis] = corner[axis], sign
                face = Rectangle(center=center, normal=normal, width=width, height=height)
                faces[f"{'-' if sign < 0 else '+'}{name}"] = face
        return faces

    def projected_area(self, direction: Vector) -> float:
        """Area [m^2] of the box seen along a direction.

        Parameters
        ----------
        direction : three floats
            Unit vector.

        Returns
        -------
        float
            Sum of the projected areas of the visible faces [m^2].

        Examples
        --------
        >>> import transport as tp
        >>> tp.Box(size=(1, 2, 3)).projected_area((0, 0, 1))
        2.0
        """
        return dot(self._face_areas(), tuple(map(abs, direction)))

    def pieces(self) -> tuple[Rectangle, ...]:
        """Return the six faces."""
        return tuple(self.faces().values())

    def contains(self, points: np.ndarray) -> np.ndarray:
        """Return which points (n, 3) [m] lie in the box, its faces included."""
        low, high = self.bounds
        return ((points >= low) & (points <= high)).all(axis=1)

    def distance(self, point: Vector, filled: bool = False) -> float:
        """Return the distance [m] of a point from the nearest face; filled: from the box."""
        offset = (p - q for p, q in zip(point, self.middle, strict=True))
        beyond = [abs(x) - size / 2 for x, size in zip(offset, self.size, strict=True)]
        if filled or max(beyond) > 0:
            return math.hypot(*(max(x, 0.0) for x in beyond))
        return -max(beyond)

    def _face_areas(self) -> Vector:
        """Areas [m^2] of the faces across x, y and z."""
        x, y, z = self.size
        return y * z, x * z, x * y

    def _reach(self) -> Vector:
        """Half extents [m] along the axes."""
        return tuple(length / 2 for length in self.size)
