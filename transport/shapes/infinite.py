"""Infinite shapes: a plane, and the slab between two planes; not for sources, aims or results per area."""

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
    is_infinite = True

    def __post_init__(self) -> None:
        self._settle_plane()

    @property
    def bounds(self) -> tuple[Vector, Vector]:
        """Corners [m] of the bounding box: finite only along a normal that is a coordinate axis."""
        return _bounds(self.center, self.normal, 0.0)


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
        """Unit vectors (e_u, e_v, n), as for a flat shape."""
        return local_frame(self.normal, None)

    @property
    def bounds(self) -> tuple[Vector, Vector]:
        """Corners [m] of the bounding box: finite only along a normal that is a coordinate axis."""
        return _bounds(self.center, self.normal, self.thickness / 2)

    def planes(self) -> tuple[Plane, Plane]:
        """Return the two faces as planes with outward normals.

        Returns
        -------
        tuple of two Plane
            The face on the side of `normal`, then the opposite one.
        """
        ways = (self.normal, tuple(-x + 0.0 for x in self.normal))
        half = self.thickness / 2
        centers = [tuple(c + half * x for c, x in zip(self.center, way, strict=True)) for way in ways]
        return tuple(Plane(center=c, normal=way) for c, way in zip(centers, ways, strict=True))


def _bounds(center: Vector, normal: Vector, half: float) -> tuple[Vector, Vector]:
    """Corners [m] of the bounding box of a plane or slab with half thickness `half`."""
    reach = [half if abs(x) == 1 else math.inf for x in normal]
    lower, upper = (tuple(c + s * r for c, r in zip(center, reach, strict=True)) for s in (-1, 1))
    return lower, upper
