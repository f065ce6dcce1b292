"""Shapes without end: a plane, and the slab between two of them.  No sources, no aims, nothing per area."""

import math

from transport.fields import VectorField
from transport.shapes.base import Shape
from transport.shapes.flat import FlatShape
from transport.validation import (
    refuse,
    scene_object,
    settle_direction,
    settle_positive,
    settle_vector,
    shown,
)
from transport.vectors import Frame, Vector, local_frame


@scene_object(kw_only=True)
class Plane(FlatShape):
    """An infinite plane through `center`."""

    center: VectorField = (0.0, 0.0, 0.0)
    normal: VectorField = (0.0, 0.0, 1.0)
    up = None
    area = extent = math.inf
    is_infinite = True

    def __post_init__(self) -> None:
        self._settle_plane()

    @property
    def bounds(self) -> tuple[Vector, Vector]:
        """Lower and upper corner [m] of the smallest box that holds it: infinite but along a normal that is an axis."""
        return _bounds(self.center, self.normal, 0.0)


@scene_object(kw_only=True)
class Slab(Shape):
    """What lies between two infinite planes `thickness` [m] apart, `center` midway; normals outwards."""

    center: VectorField = (0.0, 0.0, 0.0)
    normal: VectorField = (0.0, 0.0, 1.0)
    thickness: float
    area = volume = extent = math.inf
    is_closed = is_infinite = True

    def __post_init__(self) -> None:
        settle_vector(self, "center")
        settle_direction(self, "normal")
        settle_positive(self, "thickness")
        faces = [face.center for face in self.planes()]
        apart = math.dist(*faces)
        if not 0.5 < apart / self.thickness < 2:
            must = f"thickness must not vanish in the rounding of center {self.center}"
            refuse(self, f"{must}, got {shown(self.thickness)}; move center towards the origin")

    @property
    def frame(self) -> Frame:
        """Unit vectors (e_u, e_v, n), as of a flat shape."""
        return local_frame(self.normal, None)

    @property
    def bounds(self) -> tuple[Vector, Vector]:
        """Lower and upper corner [m] of the smallest box that holds it: infinite but along a normal that is an axis."""
        return _bounds(self.center, self.normal, self.thickness / 2)

    def planes(self) -> tuple[Plane, Plane]:
        """Its two faces, with outward normals: the one that `normal` leaves, then the other."""
        ways = (self.normal, tuple(-x + 0.0 for x in self.normal))
        half = self.thickness / 2
        centers = [tuple(c + half * x for c, x in zip(self.center, way, strict=True)) for way in ways]
        return tuple(Plane(center=c, normal=way) for c, way in zip(centers, ways, strict=True))


def _bounds(center: Vector, normal: Vector, half: float) -> tuple[Vector, Vector]:
    reach = [half if abs(x) == 1 else math.inf for x in normal]
    lower, upper = (tuple(c + s * r for c, r in zip(center, reach, strict=True)) for s in (-1, 1))
    return lower, upper
