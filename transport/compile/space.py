"""The scene's own coordinates: the origin in the middle of its smallest shape, every coordinate within [-1, 1].

There floating-point numbers are finest where the finest detail is, and the unit and the offset of the user's
coordinates do not matter.  The size is a power of two, so that nothing is rounded.  Other shapes as small as 1e-10 of
the scene, away from the origin, know their rims to about 1e-6 of their own size only.
"""

import math
from dataclasses import dataclass

import numpy as np

from transport.bodies.listing import media_of
from transport.scene import Scene
from transport.shapes import Point, Shape, Slab
from transport.validation import SceneError
from transport.vectors import Vector

SMALLEST, LARGEST = 1e-140, 1e140  # sizes whose squares are still normal numbers


@dataclass(frozen=True)
class Space:
    """x -> (x - origin) / size."""

    origin: Vector
    size: float  # [m]

    def place(self, point: Vector) -> Vector:
        """A point's coordinates [scene lengths]."""
        return tuple((p - o) / self.size for p, o in zip(point, self.origin, strict=True))


def space_of(scene: Scene) -> Space:
    """The coordinates in which a scene is simulated."""
    shapes = [piece for surface in scene.surfaces for piece in _pieces(surface.shape)]
    shapes += [scene.shape_of(user) for user in (*scene.sources, *scene.meters, *scene.volumes)]
    shapes += [source.aim for source in scene.sources if source.aim is not None]
    shapes += [Point(position=detector.position) for detector in scene.points]
    origin = min(shapes, key=lambda shape: (isinstance(shape, Point), shape.extent)).middle
    largest = float(np.abs(np.array([_corners(shape) for shape in shapes]) - np.array(origin)).max())
    if not SMALLEST < largest < LARGEST and largest != 0:
        raise SceneError(
            f"Scene: its size must be between {SMALLEST:g} and {LARGEST:g} m, got {largest:.3g}; use another unit of length"
        )
    if largest == 0:  # all in one place: a mean free path is what there is to measure by
        thickest = max((float(np.max(medium.extinction)) for medium in media_of(scene)), default=0.0)
        largest = 1.0 / thickest if SMALLEST < thickest < LARGEST else 1.0
    return Space(origin, math.ldexp(1.0, math.frexp(largest)[1]))


def _pieces(shape: Shape) -> tuple[Shape, ...]:
    return shape.planes() if isinstance(shape, Slab) else (shape,)


def _corners(shape: Shape) -> tuple[Vector, Vector]:
    """The corners of the box about a shape; of an infinite one its center alone."""
    return (shape.middle, shape.middle) if shape.is_infinite else shape.bounds
