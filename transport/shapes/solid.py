"""Closed shapes, with a volume and normals outwards: sphere, box."""

import math

from transport.shapes.base import Shape
from transport.shapes.flat import Rectangle
from transport.validation import (
    as_float,
    as_floats,
    refuse,
    scene_object,
    settle_direction,
    settle_positive,
    settle_vector,
    shown,
    store,
)
from transport.vectors import Frame, Vector, dot, local_frame


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
