"""Shapes: where sources emit, surfaces act and detectors look. Lengths in metres, keywords only.

Every shape answers `area` [m^2] (a Point has none), `bounds` (lower and upper corner), `extent` (radius of
the ball round its `middle` that just holds it) and `is_closed`; those with an axis have a `frame`.
"""

import math
from collections.abc import Iterable

from transport.normals import REACH
from transport.triangles import centroid, corners_of, frame_of, is_on_a_line, normal_and_area
from transport.validation import (
    as_float,
    as_floats,
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


class Shape:
    """What all shapes share; not made itself."""

    is_closed = False

    @property
    def middle(self) -> Vector:
        """Centre [m]."""
        return self.center

    @property
    def bounds(self) -> tuple[Vector, Vector]:
        """Lower and upper corner [m] of the smallest box along the axes that holds the shape."""
        reach = list(zip(self.middle, self._reach(), strict=True))
        return tuple(c - r for c, r in reach), tuple(c + r for c, r in reach)

    @property
    def extent(self) -> float:
        """Half diagonal of its bounds [m]."""
        return math.hypot(*self._reach())

    def _check_size(self, *names: str) -> None:
        """Refuse lengths whose area, volume or bounds leave the range of doubles."""
        sizes = {"area": self.area} | ({"volume": self.volume} if self.is_closed else {})
        for quantity, size in sizes.items():
            if not 0 < size < math.inf:
                values = ", ".join(f"{name}={shown(getattr(self, name))}" for name in names)
                refuse(
                    self, f"{quantity} must be positive and finite, got {size} from {values}; change the unit"
                )
        if not all(map(math.isfinite, (*self.bounds[0], *self.bounds[1]))):
            refuse(self, f"bounds must be finite, got {self.bounds}; move center towards the origin")


class FlatShape(Shape):
    """What flat shapes share: a unit normal, and `up`, which turns the frame of all but triangles about it."""

    def _settle_plane(self) -> None:
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
        """Unit vectors (e_u, e_v, n): e_v is `up` projected into the plane, e_u = e_v x n.

        The default `up` is +y, or +z where the normal is along y to within 1e-6 rad.
        """
        return local_frame(self.normal, self.up)

    def projected_area(self, direction: Vector) -> float:
        """Area [m^2] seen along a unit direction."""
        return self.area * abs(dot(self.normal, direction))


@scene_object(kw_only=True)
class Rectangle(FlatShape):
    """A flat rectangle, `width` [m] along e_u and `height` [m] along e_v of its frame."""

    center: Vector = (0.0, 0.0, 0.0)
    normal: Vector = (0.0, 0.0, 1.0)
    width: float
    height: float
    up: Vector | None = None

    def __post_init__(self) -> None:
        self._settle_plane()
        settle_positive(self, "width", "height")
        self._check_size("width", "height")

    @property
    def area(self) -> float:
        """Area of one side [m^2]."""
        return self.width * self.height

    @property
    def extent(self) -> float:
        """Half diagonal [m]."""
        return math.hypot(self.width / 2, self.height / 2)

    def _reach(self) -> Vector:
        e_u, e_v, _ = self.frame
        return tuple(
            abs(u) * self.width / 2 + abs(v) * self.height / 2 for u, v in zip(e_u, e_v, strict=True)
        )


@scene_object(kw_only=True)
class Disk(FlatShape):
    """A flat disk of `radius` [m]; an annulus where `inner_radius` [m] is not zero."""

    center: Vector = (0.0, 0.0, 0.0)
    normal: Vector = (0.0, 0.0, 1.0)
    radius: float
    inner_radius: float = 0.0
    up: Vector | None = None

    def __post_init__(self) -> None:
        self._settle_plane()
        settle_positive(self, "radius")
        settle_nonnegative(self, "inner_radius")
        if self.inner_radius >= self.radius:
            refuse(self, f"inner_radius must be below radius {self.radius}, got {self.inner_radius}")
        self._check_size("radius", "inner_radius")

    @property
    def area(self) -> float:
        """Area of one side [m^2]; the product of difference and sum keeps thin rings exact."""
        return math.pi * (self.radius - self.inner_radius) * (self.radius + self.inner_radius)

    @property
    def extent(self) -> float:
        """Outer radius [m]."""
        return self.radius

    def _reach(self) -> Vector:
        x, y, z = self.normal
        return tuple(self.radius * min(1.0, math.hypot(*others)) for others in ((y, z), (x, z), (x, y)))


@scene_object(kw_only=True)
class Triangle(FlatShape):
    """A flat triangle of three `vertices` [m], whose normal is that of a right hand whose fingers follow them."""

    vertices: tuple[Vector, Vector, Vector]

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
        """Unit normal; exact to rounding for slivers too."""
        return normal_and_area(self.vertices)[0]

    @property
    def frame(self) -> Frame:
        """Unit vectors (e_u, e_v, n): e_u from the first vertex to the second, e_v = n x e_u."""
        return frame_of(self.vertices)

    @property
    def corners(self) -> tuple[tuple[float, float], ...]:
        """The vertices in the frame, (u, v) from the centroid [m]; they turn to the left."""
        return corners_of(self.vertices)

    @property
    def area(self) -> float:
        """Area of one side [m^2]; exact to rounding for slivers too."""
        return normal_and_area(self.vertices)[1]

    @property
    def extent(self) -> float:
        """Distance of the vertex that is farthest from the centroid [m]."""
        return max(math.dist(self.center, vertex) for vertex in self.vertices)

    @property
    def bounds(self) -> tuple[Vector, Vector]:
        """Lower and upper corner [m] of the smallest box along the axes that holds the shape."""
        axes = list(zip(*self.vertices, strict=True))
        return tuple(map(min, axes)), tuple(map(max, axes))


@scene_object(kw_only=True)
class Sphere(Shape):
    """A sphere of `radius` [m], its normal outwards; `axis` is the pole of its coordinates."""

    center: Vector = (0.0, 0.0, 0.0)
    radius: float
    axis: Vector = (0.0, 0.0, 1.0)
    is_closed = True

    def __post_init__(self) -> None:
        settle_vector(self, "center")
        settle_positive(self, "radius")
        settle_direction(self, "axis")
        self._check_size("radius")

    @property
    def frame(self) -> Frame:
        """Unit vectors (e_u, e_v, axis) of its coordinates; azimuth runs from e_u towards e_v."""
        return local_frame(self.axis, None)

    @property
    def area(self) -> float:
        """Area [m^2]."""
        return 4 * math.pi * self.radius * self.radius

    @property
    def volume(self) -> float:
        """Volume [m^3]."""
        return self.area * self.radius / 3

    @property
    def extent(self) -> float:
        """Radius [m]."""
        return self.radius

    def projected_area(self, direction: Vector) -> float:
        """Area [m^2] seen along any direction: a quarter of the surface."""
        return math.pi * self.radius * self.radius

    def _reach(self) -> Vector:
        return (self.radius,) * 3


@scene_object(kw_only=True)
class Box(Shape):
    """A box along the axes, `size` its three lengths [m] or one for a cube; normals outwards."""

    center: Vector = (0.0, 0.0, 0.0)
    size: Vector | float
    is_closed = True

    def __post_init__(self) -> None:
        settle_vector(self, "center")
        edge = as_float(self.size)
        size = as_floats(self.size if edge is None else (edge,) * 3)
        if size is None or len(size) != 3 or min(size) <= 0:
            refuse(self, f"size must be one or three lengths, positive and finite, got {shown(self.size)}")
        store(self, size=size)
        self._check_size("size")

    @property
    def area(self) -> float:
        """Area of the six faces [m^2]."""
        return 2 * math.fsum(self._face_areas())

    @property
    def volume(self) -> float:
        """Volume [m^3]."""
        return math.prod(self.size)

    def faces(self) -> dict[str, Rectangle]:
        """The faces "-x", "+x", "-y", "+y", "-z", "+z" as rectangles with outward normals."""
        x, y, z = self.size
        lengths = {"x": (z, y), "y": (x, z), "z": (x, y)}  # width and height in the default frame
        faces = {}
        for axis, (name, (width, height)) in enumerate(lengths.items()):
            for sign, corner in zip((-1.0, 1.0), self.bounds, strict=True):
                center, normal = list(self.center), [0.0, 0.0, 0.0]
                center[axis], normal[axis] = corner[axis], sign
                face = Rectangle(center=center, normal=normal, width=width, height=height)
                faces[f"{'-' if sign < 0 else '+'}{name}"] = face
        return faces

    def projected_area(self, direction: Vector) -> float:
        """Area [m^2] seen along a unit direction: the sum over the faces that look that way."""
        return dot(self._face_areas(), tuple(map(abs, direction)))

    def _face_areas(self) -> Vector:
        x, y, z = self.size
        return y * z, x * z, x * y

    def _reach(self) -> Vector:
        return tuple(length / 2 for length in self.size)


@scene_object(kw_only=True)
class Point(Shape):
    """A point, for sources only."""

    position: Vector = (0.0, 0.0, 0.0)
    extent = 0.0

    def __post_init__(self) -> None:
        settle_vector(self, "position")

    @property
    def middle(self) -> Vector:
        """Its position [m]."""
        return self.position

    def _reach(self) -> Vector:
        return 0.0, 0.0, 0.0


@scene_object(kw_only=True)
class Cloud(Shape):
    """A Gaussian cloud, for a Gas only; `sigma` [m], one or along each axis, bounds 8.5 sigma away."""

    center: Vector = (0.0, 0.0, 0.0)
    sigma: Vector | float

    def __post_init__(self) -> None:
        settle_vector(self, "center")
        every = as_float(self.sigma)
        sigma = as_floats(self.sigma if every is None else (every,) * 3)
        if sigma is None or len(sigma) != 3 or min(sigma) < 0 or not 0 < max(sigma) < 1e300:
            must = f"one or three lengths, 0 or more and not all 0, got {shown(self.sigma)}"
            refuse(self, f"sigma must be {must}; a Point has no extent")
        store(self, sigma=sigma)

    @property
    def volume(self) -> float:
        """Volume [m^3] that holds as many particles at the density of the centre."""
        return (2 * math.pi) ** 1.5 * math.prod(self.sigma)

    def _reach(self) -> Vector:
        return tuple(REACH * length for length in self.sigma)
