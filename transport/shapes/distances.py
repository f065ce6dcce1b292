"""The least distance between a point and a shape, with no more than rounding lost: it bounds the weights of an aim."""

import math

from transport.shapes import Box, Disk, FlatShape, Rectangle, Shape, Sphere, Triangle
from transport.shapes.triangles import distance_beside
from transport.vectors import Vector, dot


def least_distance(shape: Shape, point: Vector, filled: bool = False) -> float:
    """Distance [m] from a point to the nearest point of a shape; filled: of a closed one's volume, not its surface."""
    offset = tuple(p - q for p, q in zip(point, shape.middle, strict=True))
    match shape:
        case Sphere(radius=radius):
            beyond = math.hypot(*offset) - radius
            return max(beyond, 0.0) if filled else abs(beyond)
        case Box():
            beyond = [abs(x) - size / 2 for x, size in zip(offset, shape.size, strict=True)]
            if filled or max(beyond) > 0:
                return math.hypot(*(max(x, 0.0) for x in beyond))
            return -max(beyond)
        case FlatShape():
            u, v, height = (dot(offset, axis) for axis in shape.frame)
            return math.hypot(height, *_beside(shape, u, v))
    return math.hypot(*offset)


def in_plane_distances(shape: Rectangle | Disk, point: Vector) -> tuple[float, float]:
    """The least and the greatest distance [m] from a point of the plane to the points of a shape in it."""
    offset = tuple(p - q for p, q in zip(point, shape.center, strict=True))
    u, v = (dot(offset, axis) for axis in shape.frame[:2])
    if isinstance(shape, Disk):
        return math.hypot(*_beside(shape, u, v)), math.hypot(u, v) + shape.radius
    return math.hypot(*_beside(shape, u, v)), math.hypot(abs(u) + shape.width / 2, abs(v) + shape.height / 2)


def _beside(shape: FlatShape, u: float, v: float) -> tuple[float, ...]:
    """How far a point of the plane lies beside a flat shape: components of the way to it."""
    if isinstance(shape, Triangle):
        return (distance_beside(shape.corners, u, v),)
    if isinstance(shape, Disk):
        apart = math.hypot(u, v)
        return (max(0.0, apart - shape.radius, shape.inner_radius - apart),)
    return max(0.0, abs(u) - shape.width / 2), max(0.0, abs(v) - shape.height / 2)
