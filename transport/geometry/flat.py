"""Flat shapes: rectangle, disk, triangle, infinite plane; and the slab between two planes."""

import math
from collections.abc import Iterable, Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np

from transport.geometry.shape import ROUNDING, Rim, Shape, point_text
from transport.validation import (
    Converted,
    OptionalVectorField,
    VectorField,
    as_floats,
    check_type,
    coerce_direction,
    coerce_nonnegative,
    coerce_positive,
    coerce_vector,
    refuse,
    scene_object,
    set_fields,
    short_repr,
)
from transport.vectors import Frame, Vector, are_parallel, dot, local_frame, unit_vector

# ---- Geometry of one triangle, in whole numbers where thin triangles would cancel; rounded once.

Vertices = tuple[Vector, Vector, Vector]
Corner = tuple[float, float]
TRIANGLE_ROUNDING = 51  # bits of a coordinate: triangles of smaller height count as lines


@lru_cache(maxsize=4096)
def normal_and_area(vertices: Vertices) -> tuple[Vector, float]:
    """Unit normal (right-hand rule over the vertex order) and area [m^2], infinite on overflow."""
    twice, unit = twice_area(vertices)
    largest = max(map(abs, twice))
    scaled = tuple(component / largest for component in twice)
    try:
        return unit_vector(scaled), largest / unit * math.hypot(*scaled) / 2
    except OverflowError:
        return unit_vector(scaled), math.inf


@lru_cache(maxsize=4096)
def is_collinear(vertices: Vertices) -> bool:
    """Return whether the vertices are collinear within the rounding of their coordinates."""
    (*edges, third), size, _ = _whole_edges(vertices)
    longest2 = max(_square(edge) for edge in (*edges, third))
    return _square(_cross(*edges)) << 2 * TRIANGLE_ROUNDING <= size * size * longest2


def centroid(vertices: Vertices) -> Vector:
    """Mean of the vertices [m]; exact quarters avoid overflow."""
    return tuple(math.fsum(0.25 * x for x in axis) / 0.75 for axis in zip(*vertices, strict=True))


def distance_to_triangle(corners: tuple[Corner, ...], u: float, v: float) -> float:
    """Distance [m] of a point of the plane from a triangle with counterclockwise corners (u, v); 0 inside."""
    sides = list(pairwise((*corners, corners[0])))
    if all((q - p) * (v - s) >= (t - s) * (u - p) for (p, s), (q, t) in sides):
        return 0.0
    return min(distance_to_side(one, other, (u, v)) for one, other in sides)


def distance_to_side(one: Corner, other: Corner, point: Corner) -> float:
    """Distance [m] of a point from a side."""
    length, offset = math.dist(one, other), tuple(q - p for p, q in zip(one, other, strict=True))
    along = dot([x / length for x in offset], [x - p for p, x in zip(one, point, strict=True)]) / length
    within = min(max(along, 0.0), 1.0)
    return math.dist([p + within * x for p, x in zip(one, offset, strict=True)], point)


def twice_area(vertices: Vertices) -> tuple[tuple[int, ...], int]:
    """Return the cross product of two edges, exactly as whole numbers over one power of two."""
    (one, other, _), _, unit = _whole_edges(vertices)
    return _cross(one, other), unit * unit


def whole_numbers(numbers: Iterable[float]) -> tuple[list[int], int]:
    """Return numbers exactly as whole numbers over one power of two, and that power."""
    ratios = [number.as_integer_ratio() for number in numbers]
    unit = max(below for _, below in ratios)
    return [above * (unit // below) for above, below in ratios], unit


def _whole_edges(vertices: Vertices) -> tuple[list[tuple[int, ...]], int, int]:
    """Return the edges from a to b, from a to c and from b to c, the largest coordinate, and the unit."""
    whole, unit = whole_numbers(x for vertex in vertices for x in vertex)
    a, b, c = whole[:3], whole[3:6], whole[6:]
    edges = [tuple(q - p for p, q in zip(*ends, strict=True)) for ends in ((a, b), (a, c), (b, c))]
    return edges, max(map(abs, whole)), unit


def _cross(u: tuple[int, ...], v: tuple[int, ...]) -> tuple[int, ...]:
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


def _square(vector: tuple[int, ...]) -> int:
    return sum(component * component for component in vector)


# ---- Rectangle, disk and triangle.


class FlatShape(Shape):
    """Base class of flat shapes: unit normal, and `up`, which fixes the frame's rotation."""

    is_flat = True
    corners: tuple[Corner, ...] = ()  # (u, v) [m] of a convex polygon in its frame, counterclockwise

    def _coerce_plane(self) -> None:
        """Check and store centre, normal and `up`."""
        coerce_vector(self, "center")
        coerce_direction(self, "normal")
        if self.up is not None:
            up = self.up
            coerce_direction(self, "up")
            if are_parallel(self.up, self.normal):
                refuse(
                    self,
                    f"up must not be parallel to normal {self.normal}, got {short_repr(up)}; leave it out",
                )

    @property
    def frame(self) -> Frame:
        """Unit vectors (e_u, e_v, n), where e_v is `up` projected onto the plane and e_u = e_v x n.

        The default `up` is +y, or +z if the normal is parallel to y within 1e-6 rad.

        Returns
        -------
        tuple of three tuples of three floats
        """
        return local_frame(self.normal, self.up)

    @property
    def cross_section(self) -> float:
        """Largest projected area [m^2], which is the area."""
        return self.area

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

    def height_of(self, point: Vector) -> float:
        """Return the height [m] of a point over the plane."""
        return dot(tuple(p - q for p, q in zip(point, self.middle, strict=True)), self.normal)

    def covers(self, points: np.ndarray) -> np.ndarray:
        """Return which points (n, 3) [m] of the plane lie on the shape, as (n,) of bool."""
        u, v, _ = np.array(self.frame) @ (points - np.array(self.center)).T
        return self._covers(u, v)

    def distance(self, point: Vector, filled: bool = False) -> float:
        """Return the distance [m] of a point."""
        offset = tuple(p - q for p, q in zip(point, self.middle, strict=True))
        u, v, height = (dot(offset, axis) for axis in self.frame)
        return math.hypot(height, *self._gap(u, v))

    def in_plane_distances(self, point: Vector) -> tuple[float, float]:
        """Return the least and the greatest distance [m] of its points from a point of the plane."""
        offset = tuple(p - q for p, q in zip(point, self.center, strict=True))
        u, v = (dot(offset, axis) for axis in self.frame[:2])
        return math.hypot(*self._gap(u, v)), self._farthest(point, u, v)

    def sample_area(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return points even over the area and off a hole, and the normal for each; see `Shape`."""
        places = self._sample(numbers[:, :1], numbers[:, 1:2])
        if self.hole is not None:
            places = places[~self.hole.covers(places)]
        return places, np.broadcast_to(self.normal, places.shape)

    def interval_along(self, axis: Vector) -> tuple[float, float]:
        """Return the interval [m] that the projection on an axis covers."""
        middle, reach = dot(axis, self.center), self.half_width_along(axis)
        return middle - reach, middle + reach

    def edges(self) -> list[tuple[Vector, float]]:
        """Return unit vectors of the plane out of each edge, and the edges' distances from the centre [m]."""
        e_u, e_v, _ = self.frame
        found = []
        for (p, s), (q, t) in pairwise((*self.corners, *self.corners[:1])):
            u, v = (t - s) / math.dist((p, s), (q, t)), (p - q) / math.dist((p, s), (q, t))
            found.append((tuple(u * a + v * b for a, b in zip(e_u, e_v, strict=True)), u * p + v * s))
        return found

    def _covers(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return whether points (u, v) [m] of the frame lie on the shape."""
        raise NotImplementedError

    def _gap(self, u: float, v: float) -> tuple[float, ...]:
        """Components [m] of the vector from a point of the plane to the nearest point of the shape."""
        raise NotImplementedError

    def _farthest(self, point: Vector, u: float, v: float) -> float:
        """Greatest distance [m] of the shape's points from a point of its plane."""
        raise NotImplementedError

    def _sample(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Points (n, 3) [m] even over the area, holes included, from two columns of numbers in [0, 1)."""
        raise NotImplementedError


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
    up: OptionalVectorField = None
    hole: "Disk | Rectangle | None" = None

    def __post_init__(self) -> None:
        self._coerce_plane()
        coerce_positive(self, "width", "height")
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

    @property
    def corners(self) -> tuple[Corner, ...]:
        """Corners (u, v) in the frame [m], counterclockwise."""
        u, v = self.width / 2, self.height / 2
        return (u, v), (-u, v), (-u, -v), (u, -v)

    def _place(self) -> str:
        """The corners in space, in words, counterclockwise seen from the front."""
        e_u, e_v, _ = self.frame
        scale = self.coordinate_scale
        points = [
            tuple(c + u * p + v * q for c, p, q in zip(self.center, e_u, e_v, strict=True))
            for u, v in self.corners
        ]
        points = [tuple(0.0 if abs(x) < ROUNDING * scale else x for x in point) for point in points]
        return f"corners {', '.join(map(point_text, points))}"

    coordinates_cure = "put Detectors on Rectangles that leave out the hole"

    coordinate_names = ("x", "y")  # of u and v

    def coordinates(self) -> dict[str, tuple[float, float, str]]:
        """Return the ranges of u and v along the sides [m]; none with a hole."""
        if self.hole is not None:
            return {}
        u, v = self.width / 2, self.height / 2
        return {"u": (-u, u, "m"), "v": (-v, v, "m")}

    @property
    def least_width(self) -> float:
        """Shorter side [m]."""
        return min(self.width, self.height)

    def rims(self) -> list[Rim]:
        """Return the four sides; none with a hole."""
        if self.hole is not None:
            return []
        steps = list(zip(self.center, *self.frame[:2], strict=True))
        return segments([tuple(c + p * u + q * v for c, u, v in steps) for p, q in self.corners])

    def _covers(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        inside = (np.abs(u) <= self.width / 2) & (np.abs(v) <= self.height / 2)
        if self.hole is None:
            return inside
        e_u, e_v, _ = np.array(self.frame)
        places = np.array(self.center) + np.outer(u, e_u) + np.outer(v, e_v)
        return inside & ~self.hole.covers(places)

    def _gap(self, u: float, v: float) -> tuple[float, ...]:
        if self.hole is not None:
            depth = self._depth_in_hole(u, v)
            if depth > 0:
                return (depth,)
        return max(0.0, abs(u) - self.width / 2), max(0.0, abs(v) - self.height / 2)

    def _depth_in_hole(self, u: float, v: float) -> float:
        """Distance [m] of a point of the plane from the edge of the hole; negative outside the hole."""
        hole, (e_u, e_v, _) = self.hole, self.frame
        steps = zip(self.center, e_u, e_v, hole.center, strict=True)
        offset = tuple(c + u * p + v * q - h for c, p, q, h in steps)
        return hole.depth_inside(*(dot(offset, axis) for axis in hole.frame[:2]))

    def depth_inside(self, u: float, v: float) -> float:
        """Distance [m] of a point from the sides, negative outside, to the nearer side beyond a corner."""
        return min(self.width / 2 - abs(u), self.height / 2 - abs(v))

    def _farthest(self, point: Vector, u: float, v: float) -> float:
        return math.hypot(abs(u) + self.width / 2, abs(v) + self.height / 2)

    def _sample(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        e_u, e_v, _ = np.array(self.frame)
        return np.array(self.center) + (one - 0.5) * self.width * e_u + (other - 0.5) * self.height * e_v

    def _check_hole(self) -> None:
        """Raise if the hole is not flat, is not within the rectangle, or has a hole itself."""
        hole = self.hole
        must = "a Disk or Rectangle in its plane and within it, and without a hole of its own"
        check_type(self, "hole", (Disk, Rectangle), must)
        island = hole.hole if isinstance(hole, Rectangle) else hole.inner_radius
        if island:
            refuse(self, f"hole must be {must}, got {short_repr(hole)}; add the island as a separate shape")
        # Check that the hole lies in the plane.
        tolerance = ROUNDING * sum((*map(abs, (*self.center, *hole.center)), self.extent, hole.extent))
        place = tuple(p - q for p, q in zip(hole.center, self.center, strict=True))
        u, v, height = (dot(place, axis) for axis in self.frame)
        tilt = math.hypot(dot(hole.normal, self.frame[0]), dot(hole.normal, self.frame[1])) * hole.extent
        if abs(height) + tilt > tolerance:
            cure = f"give it center={short_repr(self.center)} and normal={short_repr(self.normal)}"
            refuse(
                self,
                f"hole must lie in its plane, got {short_repr(hole)}, {abs(height) + tilt:.3g} m off; {cure}",
            )
        # Check that the hole lies within the edges.
        beyond = max(
            abs(x) + hole.half_width_along(axis) - length / 2
            for x, axis, length in zip((u, v), self.frame[:2], (self.width, self.height), strict=True)
        )
        if beyond > tolerance:
            refuse(
                self,
                f"hole must lie within it, got {short_repr(hole)}, {beyond:.3g} m beyond; make it smaller",
            )
        if self.area <= 0:
            refuse(self, f"hole must be smaller than the rectangle, got {short_repr(hole)}; make it smaller")

    def half_width_along(self, direction: Vector) -> float:
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
    up: OptionalVectorField = None

    def __post_init__(self) -> None:
        self._coerce_plane()
        coerce_positive(self, "radius")
        coerce_nonnegative(self, "inner_radius")
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

    def half_width_along(self, direction: Vector) -> float:
        """Radius [m]: the half width along any unit direction of the plane."""
        return self.radius

    coordinate_names = ("radius", "azimuth")  # of u and v

    def coordinates(self) -> dict[str, tuple[float, float, str]]:
        """Return the ranges of the radius [m] and the azimuth [rad]."""
        return {"u": (self.inner_radius, self.radius, "m"), "v": (0.0, 2 * math.pi, "rad")}

    def strip_areas(self, u: np.ndarray) -> np.ndarray:
        """Return the areas of rings per azimuth [m^2/rad]."""
        lower, upper = u[:-1], u[1:]
        return (upper - lower) * (upper / 2 + lower / 2)

    @property
    def least_width(self) -> float:
        """Radius, or width of the ring [m]."""
        return self.radius - self.inner_radius

    def rims(self) -> list[Rim]:
        """Return the circle; none for an annulus."""
        span = tuple(self.radius * x for x in self.normal)
        return [] if self.inner_radius else [Rim(True, self.center, span)]

    def depth_inside(self, u: float, v: float) -> float:
        """Distance [m] of a point of the plane from the outer edge; negative outside."""
        return self.radius - math.hypot(u, v)

    def _covers(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        rho = np.hypot(u, v)
        return (rho <= self.radius) & (rho >= self.inner_radius)

    def _gap(self, u: float, v: float) -> tuple[float, ...]:
        apart = math.hypot(u, v)
        return (max(0.0, apart - self.radius, self.inner_radius - apart),)

    def _farthest(self, point: Vector, u: float, v: float) -> float:
        return math.hypot(u, v) + self.radius

    def _sample(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        e_u, e_v, _ = np.array(self.frame)
        inner, outer = self.inner_radius, self.radius
        rho, turn = np.sqrt(inner**2 + one * (outer - inner) * (outer + inner)), 2 * math.pi * other
        return np.array(self.center) + rho * (np.cos(turn) * e_u + np.sin(turn) * e_v)


class FlatPolygon(FlatShape):
    """Base class of flat shapes given by vertices, which define the plane more accurately than a normal.

    e_u of the frame runs from the first vertex to the second; (u, v) are measured from the centroid.
    """

    coordinates_cure = "put a Detector on a Rectangle or Disk in its plane instead"

    @property
    def frame(self) -> Frame:
        """Unit vectors (e_u, e_v, n), with e_u from the first vertex to the second and e_v = n x e_u."""
        e_u = unit_vector(tuple(q - p for p, q in zip(*self.vertices[:2], strict=True)))
        return e_u, local_frame(e_u, self.normal)[0], self.normal

    @property
    def corners(self) -> tuple[Corner, ...]:
        """Vertices in the frame, (u, v) from the centroid [m], counterclockwise."""
        (e_u, e_v, _), center = self.frame, self.center
        offsets = [tuple(p - c for p, c in zip(vertex, center, strict=True)) for vertex in self.vertices]
        return tuple((dot(offset, e_u), dot(offset, e_v)) for offset in offsets)

    @property
    def extent(self) -> float:
        """Distance from the centroid to the farthest vertex [m]."""
        center = self.center
        return max(math.dist(center, vertex) for vertex in self.vertices)

    @property
    def bounds(self) -> tuple[Vector, Vector]:
        """Lower and upper corner [m] of the smallest axis-aligned box that holds the shape."""
        axes = list(zip(*self.vertices, strict=True))
        return tuple(map(min, axes)), tuple(map(max, axes))

    @property
    def support_breadth(self) -> float:
        """Length [m] over which the vertices define the plane."""
        return self.area / self.extent

    def rims(self) -> list[Rim]:
        """Return the sides."""
        return segments(self.vertices)

    def interval_along(self, axis: Vector) -> tuple[float, float]:
        """Return the interval [m] that the projection on an axis covers."""
        heights = [dot(axis, vertex) for vertex in self.vertices]
        return min(heights), max(heights)

    def _farthest(self, point: Vector, u: float, v: float) -> float:
        return max(math.dist(point, vertex) for vertex in self.vertices)


@scene_object(kw_only=True)
class Triangle(FlatPolygon):
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
            refuse(
                self,
                f"vertices must be three points of three finite numbers, got {short_repr(self.vertices)}",
            )
        if is_collinear(vertices):
            refuse(self, f"vertices must not lie on one line, got {short_repr(vertices)}; move one of them")
        set_fields(self, vertices=vertices)
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
    def area(self) -> float:
        """Area of one side [m^2]; accurate to rounding for thin triangles too."""
        return normal_and_area(self.vertices)[1]

    @property
    def least_width(self) -> float:
        """Least height over a side [m]."""
        return 2 * self.area / max(math.dist(p, q) for p, q in pairwise((*self.vertices, self.vertices[0])))

    def _covers(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        places = [(p - u, q - v) for p, q in self.corners]
        turned = [p * t - q * s for (p, q), (s, t) in zip(places, places[1:] + places[:1], strict=True)]
        return np.all([turn >= 0 for turn in turned], axis=0)

    def _gap(self, u: float, v: float) -> tuple[float, ...]:
        return (distance_to_triangle(self.corners, u, v),)

    def _sample(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        return points_in_triangles(np.array([self.vertices]), one, other)


def points_in_triangles(corners: np.ndarray, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return points (n, 3) even over triangles (n or 1, 3, 3) from columns (n, 1) of numbers in [0, 1)."""
    first, second, third = corners.transpose(1, 0, 2)
    s = np.sqrt(one)
    return first + s * (1 - other) * (second - first) + s * other * (third - first)


def even_facets(areas: np.ndarray, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return facets drawn by area from numbers (n,) in [0, 1), and even numbers that are left (n, 1)."""
    whole = np.cumsum(areas)
    place = numbers * whole[-1]
    facets = np.minimum(np.searchsorted(whole, place, side="right"), len(areas) - 1)
    return facets, np.clip((place - (whole - areas)[facets]) / areas[facets], 0.0, 1.0)[:, None]


def segments(corners: Sequence[Vector]) -> list[Rim]:
    """Return the sides of a polygon as rims."""
    return [
        Rim(
            False,
            tuple((a + b) / 2 for a, b in zip(p, q, strict=True)),
            tuple((b - a) / 2 for a, b in zip(p, q, strict=True)),
        )
        for p, q in pairwise((*corners, corners[0]))
    ]


# ---- Infinite shapes: a plane, and the slab between two planes; not for sources, aims or results per area.


@scene_object(kw_only=True)
class Plane(FlatShape):
    """Infinite plane.

    It can be a surface or a detector, but not the shape of a source or an aim, and it has no results per
    area.

    Parameters
    ----------
    center : three floats, default (0, 0, 0)
        A point of the plane [m]; the origin of its frame.
    normal : three floats, default (0, 0, 1)
        Normal of the front side, of any length; stored as a unit vector.

    Examples
    --------
    >>> import transport as tp
    >>> tp.Plane(normal=(0, 0, 2)).normal
    (0.0, 0.0, 1.0)
    >>> tp.Plane().area
    inf
    """

    center: VectorField = (0.0, 0.0, 0.0)
    normal: VectorField = (0.0, 0.0, 1.0)
    up = None
    area = extent = math.inf
    is_infinite = is_plane = True
    coordinates_cure = "put a Detector on a Rectangle or Disk in it instead"

    def __post_init__(self) -> None:
        self._coerce_plane()

    @property
    def bounds(self) -> tuple[Vector, Vector]:
        """Corners [m] of the bounding box, finite only along a normal that is a coordinate axis."""
        return _infinite_bounds(self.center, self.normal, 0.0)

    @property
    def coordinate_scale(self) -> float:
        """Sum of the absolute coordinates of the centre [m]."""
        return sum(map(abs, self.center))

    def _covers(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.ones(len(u), bool)

    def _gap(self, u: float, v: float) -> tuple[float, ...]:
        return (0.0,)

    def _farthest(self, point: Vector, u: float, v: float) -> float:
        return math.inf


@scene_object(kw_only=True)
class Slab(Shape):
    """Region between two parallel infinite planes, with normals outwards.

    Parameters
    ----------
    center : three floats, default (0, 0, 0)
        A point midway between the planes [m].
    normal : three floats, default (0, 0, 1)
        Direction across the slab, of any length; stored as a unit vector.
    thickness : float
        Distance between the planes [m], positive.

    Raises
    ------
    SceneError
        If the thickness is not positive, or vanishes in the rounding of `center`.

    Examples
    --------
    >>> import transport as tp
    >>> top, bottom = tp.Slab(thickness=0.5).planes()
    >>> top.center, bottom.normal
    ((0.0, 0.0, 0.25), (0.0, 0.0, -1.0))
    """

    center: VectorField = (0.0, 0.0, 0.0)
    normal: VectorField = (0.0, 0.0, 1.0)
    thickness: float
    area = volume = extent = math.inf
    is_closed = is_infinite = is_convex = True
    coordinates_cure = "put Detectors on Rectangles in its planes() instead"

    def __post_init__(self) -> None:
        coerce_vector(self, "center")
        coerce_direction(self, "normal")
        coerce_positive(self, "thickness")
        faces = [face.center for face in self.planes()]
        apart = math.dist(*faces)
        if not 0.5 < apart / self.thickness < 2:
            must = f"thickness must not vanish in the rounding of center {self.center}"
            refuse(self, f"{must}, got {short_repr(self.thickness)}; move center towards the origin")

    @property
    def frame(self) -> Frame:
        """Unit vectors (e_u, e_v, n), as for a flat shape."""
        return local_frame(self.normal, None)

    @property
    def bounds(self) -> tuple[Vector, Vector]:
        """Corners [m] of the bounding box, finite only along a normal that is a coordinate axis."""
        return _infinite_bounds(self.center, self.normal, self.thickness / 2)

    @property
    def coordinate_scale(self) -> float:
        """Sum of the absolute coordinates of the centre, and the thickness [m]."""
        return sum(map(abs, self.center)) + self.thickness

    def pieces(self) -> tuple[Plane, Plane]:
        """Return both faces."""
        return self.planes()

    def contains(self, points: np.ndarray) -> np.ndarray:
        """Return which points (n, 3) [m] lie in it, its faces included."""
        return np.abs((points - self.center) @ np.array(self.normal)) <= self.thickness / 2

    def distance(self, point: Vector, filled: bool = False) -> float:
        """Return the distance [m] of a point from the nearer face; filled: from the region."""
        offset = tuple(p - q for p, q in zip(point, self.middle, strict=True))
        beyond = abs(dot(offset, self.normal)) - self.thickness / 2
        return max(beyond, 0.0) if filled else abs(beyond)

    def planes(self) -> tuple[Plane, Plane]:
        """Return the two faces as planes with outward normals.

        Returns
        -------
        tuple of two Plane
            The face on the side of `normal`, then the opposite one.
        """
        offsets = (self.normal, tuple(-x + 0.0 for x in self.normal))
        half = self.thickness / 2
        centers = [
            tuple(c + half * x for c, x in zip(self.center, offset, strict=True)) for offset in offsets
        ]
        return tuple(Plane(center=c, normal=offset) for c, offset in zip(centers, offsets, strict=True))


def _infinite_bounds(center: Vector, normal: Vector, half: float) -> tuple[Vector, Vector]:
    """Corners [m] of the bounding box of a plane or slab with half thickness `half`."""
    reach = [half if abs(x) == 1 else math.inf for x in normal]
    lower, upper = (tuple(c + s * r for c, r in zip(center, reach, strict=True)) for s in (-1, 1))
    return lower, upper
