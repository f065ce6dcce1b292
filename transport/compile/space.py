"""Scene coordinates: origin in the middle of the smallest shape, every coordinate within [-1, 1].

Floating-point numbers are thus finest at the finest detail, and the unit and offset of the user's coordinates
do not matter. The size is a power of two, so that scaling does not round. Other shapes as small as 1e-10 of
the scene, away from the origin, resolve their edges to about 1e-6 of their own size only.
"""

import math
from dataclasses import dataclass

import numpy as np

from transport.geometry.shape import Shape
from transport.scene.bodies import scene_media
from transport.scene.scene import Scene
from transport.scene.sheets import located_shapes, scene_origin
from transport.validation import SceneError
from transport.vectors import Vector

MIN_SIZE, MAX_SIZE = 1e-140, 1e140  # [m] sizes whose squares are still normal numbers


@dataclass(frozen=True)
class Space:
    """The transformation x -> (x - origin) / size."""

    origin: Vector
    size: float  # [m]

    def place(self, point: Vector) -> Vector:
        """Return a point's scene coordinates [scene lengths]."""
        return tuple((p - o) / self.size for p, o in zip(point, self.origin, strict=True))


def make_space(scene: Scene) -> Space:
    """Return the coordinates in which a scene is simulated."""
    shapes = located_shapes(scene)
    origin = scene_origin(shapes)
    largest = float(np.abs(np.array([_corners(shape) for shape in shapes]) - np.array(origin)).max())
    if not MIN_SIZE < largest < MAX_SIZE and largest != 0:
        raise SceneError(
            f"Scene: size must be between {MIN_SIZE:g} and {MAX_SIZE:g} m, got {largest:.3g};"
            " use another unit"
        )
    if largest == 0:  # All is in one place: the mean free path is the only length.
        thickest = max((float(np.max(medium.extinction)) for medium in scene_media(scene)), default=0.0)
        largest = 1.0 / thickest if MIN_SIZE < thickest < MAX_SIZE else 1.0
    return Space(origin, math.ldexp(1.0, math.frexp(largest)[1]))


def _corners(shape: Shape) -> tuple[Vector, Vector]:
    """Return the corners of a shape's bounding box; for an infinite shape twice its center."""
    return (shape.middle, shape.middle) if shape.is_infinite else shape.bounds
