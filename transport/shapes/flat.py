"""Flat shapes with a unit normal and a frame: rectangle, disk, triangle."""

import math
from collections.abc import Iterable

from transport.fields import Converted, OptionalVector, VectorField
from transport.shapes.base import ROUNDING, Shape
from transport.shapes.triangles import centroid, corners_of, frame_of, is_on_a_line, normal_and_area
from transport.validation import (
    as_floats,
    check_type,
    refuse,
    scene_object,
    settle_direction,
    settle_nonnegative,
    settle_positive,
    settle_vector,
    shown,
    store,
)
from transport.vectors import Frame, Vector, are_parallel, dot, local_frame


class FlatShape(Shape):
    """Base class of flat shapes: unit normal, and `up`, which fixes the frame's rotation."""

    def _settle_plane(self) -> None:
        """Check and store centre, normal and `up`."""
        settle_vector(self, "center")
        settle_direction(self, "normal")
        if self.up is not None:
            up = self.up
            settle_direction(self, "up")
            if are_parallel(self.up, self.normal):
                refuse(
                    self, f"up must not be parallel to normal {self.normal}, got {shown(up)}; leave it out"
                )

    @property
    def frame(self) -> Frame:
        """Unit vectors (e_u, e_v, n): e_v is `up` projected onto the plane, e_u = e_v x n.

        The default `up` is +y, or +z if the normal is parallel to y within 1e-6 rad.
        """
        return local_frame(self.normal, self.up)

    def projected_area(self, direction: Vector) -> float:
        """Area [m^2] seen along a direction, area times ``|cosθ|``.

        Parameters
        ----------
        direction : three floats
            Unit vector.

        Returns
        -------
        float
            Projected area of one side [m^2].
        """
        return self.area * abs(dot(self.normal, direction))


@scene_object(kw_only=True)
class Rectangle(FlatShape):
    """Flat rectangle, optionally with a hole.

    Parameters
    ----------
    center : three floats, default (0, 0, 0)
        Centre [m].
    normal : three floats, default (0, 0, 1)
        Normal of the front side, of any length; stored as a unit vector.
    width : float
        Length along e_u of the frame [m], positive.
    height : float
        Length along e_v of the frame [m], positive.
    up : three floats, optional
        Direction whose projection onto the plane is e_v; not parallel to `normal`. Default +y, or +z if the
        normal is along y.
    hole : Disk or Rectangle, optional
        Hole, in the plane of the rectangle and within it.

    Raises
    ------
    SceneError
        If a length is not positive, `up` is parallel to `normal`, or the hole does not fit.

    Examples
    --------
    >>> import transport as tp
    >>> tp.Rectangle(width=2.0, height=0.5).area
    1.0
    >>> tp.Rectangle(width=2.0, height=0.5, hole=tp.Rectangle(width=1.0, height=0.25)).area
    0.75
    """

    center: VectorField = (0.0, 0.0, 0.0)
    normal: VectorField = (0.0, 0.0, 1.0)
    width: float
    height: float
    up: OptionalVector = None
    hole: "Disk | Rectangle | None" = None

    def __post_init__(self) -> None:
        self._settle_plane()
        settle_positive(self, "width", "height")
        if self.hole is not None:
            self._check_hole()
        self._check_size("width", "height", *(() if self.hole is None else ("hole",)))

    @property
    def area(self) -> float:
        """Area of one side without the hole [m^2]; computed without cancellation for narrow frames."""
        if not isinstance(self.hole, Rectangle):
            return self.width * self.height - (0.0 if self.hole is None else self.hole.area)
        (longer, shorter), (long, short) = (
            sorted((shape.width, shape.height), reverse=True) for shape in (self, self.hole)
        )
        return (longer - long) * shorter + long * (shorter - short)

    @property
    def extent(self) -> float:
        """Half diagonal [m]."""
        return math.hypot(self.width / 2, self.height / 2)

    def _reach(self) -> Vector:
        """Half extents [m] along the axes."""
        e_u, e_v, _ = self.frame
        return tuple(
            abs(u) * self.width / 2 + abs(v) * self.height / 2 for u, v in zip(e_u, e_v, strict=True)
        )

    def _check_hole(self) -> None:
        """Raise if the hole is not flat, is not within the rectangle, or has a hole itself."""
        hole = self.hole
        must = "a Disk or Rectangle in its plane and within it, and without a hole of its own"
        check_type(self, "hole", (Disk, Rectangle), must)
        island = hole.hole if isinstance(hole, Rectangle) else hole.inner_radius
        if island:
            refuse(self, f"hole must be {must}, got {shown(hole)}; add the island as a separate shape")
        # Check that the hole lies in the plane.
        tolerance = ROUNDING * sum((*map(abs, (*self.center, *hole.center)), self.extent, hole.extent))
        place = tuple(p - q for p, q in zip(hole.center, self.center, strict=True))
        u, v, height = (dot(place, axis) for axis in self.frame)
        tilt = math.hypot(dot(hole.normal, self.frame[0]), dot(hole.normal, self.frame[1])) * hole.extent
        if abs(height) + tilt > tolerance:
            cure = f"give it center={shown(self.center)} and normal={shown(self.normal)}"
            refuse(
                self, f"hole must lie in its plane, got {shown(hole)}, {abs(height) + tilt:.3g} m off; {cure}"
            )
        # Check that the hole lies within the edges.
        beyond = max(
            abs(x) + hole.reach_along(axis) - length / 2
            for x, axis, length in zip((u, v), self.frame[:2], (self.width, self.height), strict=True)
        )
        if beyond > tolerance:
            refuse(
                self, f"hole must lie within it, got {shown(hole)}, {beyond:.3g} m beyond; make it smaller"
            )
        if self.area <= 0:
            refuse(self, f"hole must be smaller than the rectangle, got {shown(hole)}; make it smaller")

    def reach_along(self, direction: Vector) -> float:
        """Half width [m] of the rectangle along a unit direction, from its centre."""
        e_u, e_v, _ = self.frame
        return abs(dot(direction, e_u)) * self.width / 2 + abs(dot(direction, e_v)) * self.height / 2


@scene_object(kw_only=True)
class Disk(FlatShape):
    """Flat disk, or annulus.

    Parameters
    ----------
    center : three floats, default (0, 0, 0)
        Centre [m].
    normal : three floats, default (0, 0, 1)
        Normal of the front side, of any length; stored as a unit vector.
    radius : float
        Outer radius [m], positive.
    inner_radius : float, default 0
        Inner radius [m] of an annulus, below `radius`.
    up : three floats, optional
        Direction whose projection onto the plane is e_v of the frame; not parallel to `normal`. Default +y,
        or +z if the normal is along y.

    Raises
    ------
    SceneError
        If a radius is out of range or `up` is parallel to `normal`.

    Examples
    --------
    >>> import transport as tp
    >>> f"{tp.Disk(radius=1.0).area:.4f}"
    '3.1416'
    >>> tp.Disk(center=(0, 0, 2), radius=1.0).bounds
    ((-1.0, -1.0, 2.0), (1.0, 1.0, 2.0))
    """

    center: VectorField = (0.0, 0.0, 0.0)
    normal: VectorField = (0.0, 0.0, 1.0)
    radius: float
    inner_radius: float = 0.0
    up: OptionalVector = None

    def __post_init__(self) -> None:
        self._settle_plane()
        settle_positive(self, "radius")
        settle_nonnegative(self, "inner_radius")
        if self.inner_radius >= self.radius:
            refuse(self, f"inner_radius must be below radius {self.radius}, got {self.inner_radius}")
        self._check_size("radius", "inner_radius")

    @property
    def area(self) -> float:
        """Area of one side [m^2]; computed without cancellation for thin rings."""
        return math.pi * (self.radius - self.inner_radius) * (self.radius + self.inner_radius)

    @property
    def extent(self) -> float:
        """Outer radius [m]."""
        return self.radius

    def _reach(self) -> Vector:
        """Half extents [m] along the axes."""
        x, y, z = self.normal
        return tuple(self.radius * min(1.0, math.hypot(*others)) for others in ((y, z), (x, z), (x, y)))

    def reach_along(self, direction: Vector) -> float:
        """Radius [m]: the half width along any unit direction of the plane."""
        return self.radius


@scene_object(kw_only=True)
class Triangle(FlatShape):
    """Flat triangle.

    Parameters
    ----------
    vertices : three points of three floats
        Vertices [m], not on one line. The normal follows the right-hand rule over their order.

    Raises
    ------
    SceneError
        If there are not three finite points, or if they lie on one line within rounding.

    Examples
    --------
    >>> import transport as tp
    >>> triangle = tp.Triangle(vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0)])
    >>> triangle.area, triangle.normal
    (0.5, (0.0, 0.0, 1.0))
    """

    vertices: Converted[Iterable[Iterable[float]], tuple[Vector, Vector, Vector]]

    def __post_init__(self) -> None:
        given = self.vertices if isinstance(self.vertices, Iterable) else ()
        vertices = tuple(as_floats(vertex) for vertex in given)
        if len(vertices) != 3 or any(vertex is None or len(vertex) != 3 for vertex in vertices):
            refuse(self, f"vertices must be three points of three finite numbers, got {shown(self.vertices)}")
        if is_on_a_line(vertices):
            refuse(self, f"vertices must not lie on one line, got {shown(vertices)}; move one of them")
        store(self, vertices=vertices)
        self._check_size("vertices")

    @property
    def center(self) -> Vector:
        """Centroid [m]."""
        return centroid(self.vertices)

    @property
    def normal(self) -> Vector:
        """Unit normal; accurate to rounding for thin triangles too."""
        return normal_and_area(self.vertices)[0]

    @property
    def frame(self) -> Frame:
        """Unit vectors (e_u, e_v, n): e_u from the first vertex to the second, e_v = n x e_u."""
        return frame_of(self.vertices)

    @property
    def corners(self) -> tuple[tuple[float, float], ...]:
        """Vertices in the frame, (u, v) from the centroid [m], counterclockwise."""
        return corners_of(self.vertices)

    @property
    def area(self) -> float:
        """Area of one side [m^2]; accurate to rounding for thin triangles too."""
        return normal_and_area(self.vertices)[1]

    @property
    def extent(self) -> float:
        """Distance from the centroid to the farthest vertex [m]."""
        return max(math.dist(self.center, vertex) for vertex in self.vertices)

    @property
    def bounds(self) -> tuple[Vector, Vector]:
        """Lower and upper corner [m] of the smallest axis-aligned box that holds the shape."""
        axes = list(zip(*self.vertices, strict=True))
        return tuple(map(min, axes)), tuple(map(max, axes))
