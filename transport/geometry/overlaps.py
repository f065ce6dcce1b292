"""Overlap of two shapes on one support: they may not both act as surfaces there."""

import math
from itertools import pairwise

from transport.geometry.distances import in_plane_distances
from transport.geometry.flat import Disk, FlatShape, Plane, Rectangle, Triangle
from transport.geometry.revolved import Revolved
from transport.geometry.shape import ROUNDING, Shape
from transport.geometry.solid import Sphere
from transport.geometry.supports import rounding_tolerance
from transport.vectors import Vector, are_parallel, dot


def overlap(a: Shape, b: Shape) -> bool:
    """Return whether two shapes on one support have more than an edge in common.

    Exact, except for a shape that reaches into a hole which is open at the edge of its rectangle: this counts
    as an overlap.
    """
    if isinstance(a, FlatShape) and isinstance(b, FlatShape):
        return _overlap_on_plane(a, b, rounding_tolerance(a, b))
    if isinstance(a, Sphere) and isinstance(b, Sphere) and not are_parallel(a.axis, b.axis):
        return _overlap_on_sphere(a, b)
    if isinstance(a, Revolved) and isinstance(b, Revolved):
        return _overlap_along_axis(a, b, rounding_tolerance(a, b))
    return True


def _overlap_on_plane(a: FlatShape, b: FlatShape, tolerance: float) -> bool:
    """Return whether two flat shapes on one plane overlap."""
    if isinstance(a, Plane) or isinstance(b, Plane):
        return True
    if _hole_contains(a, b, tolerance) or _hole_contains(b, a, tolerance):
        return False
    if not isinstance(a, Disk) and not isinstance(b, Disk):
        return all(
            _projected_gap(across, a, b) < -tolerance for shape in (a, b) for across in _edge_normals(shape)
        )
    disk, other = (a, b) if isinstance(a, Disk) else (b, a)
    nearest, farthest = in_plane_distances(other, disk.center)
    return nearest < disk.radius - tolerance and farthest > disk.inner_radius + tolerance


def _hole_contains(shape: FlatShape, other: FlatShape, tolerance: float) -> bool:
    """Return whether the other shape lies within the hole of a rectangle."""
    hole = shape.hole if isinstance(shape, Rectangle) else None
    if hole is None:
        return False
    if isinstance(hole, Disk):
        return in_plane_distances(other, hole.center)[1] <= hole.radius + tolerance
    for axis, length in zip(hole.frame[:2], (hole.width, hole.height), strict=True):
        low, high = _projection(axis, other)
        middle = dot(axis, hole.center)
        if low < middle - length / 2 - tolerance or high > middle + length / 2 + tolerance:
            return False
    return True


def _edge_normals(shape: Rectangle | Triangle) -> list[Vector]:
    """Unit vectors in the plane, perpendicular to the edges."""
    e_u, e_v, _ = shape.frame
    if isinstance(shape, Rectangle):
        return [e_u, e_v]
    edges = [(q - p, t - s) for (p, s), (q, t) in pairwise((*shape.corners, shape.corners[0]))]
    return [
        tuple((v * p - u * q) / math.hypot(u, v) for p, q in zip(e_u, e_v, strict=True)) for u, v in edges
    ]


def _projected_gap(axis: Vector, a: FlatShape, b: FlatShape) -> float:
    """Distance [m] between projections of two shapes on an axis; negative if they overlap."""
    (low_a, high_a), (low_b, high_b) = _projection(axis, a), _projection(axis, b)
    return max(low_a, low_b) - min(high_a, high_b)


def _projection(axis: Vector, shape: FlatShape) -> tuple[float, float]:
    """Interval [m] that a shape's projection covers on an axis."""
    if isinstance(shape, Triangle):
        heights = [dot(axis, vertex) for vertex in shape.vertices]
        return min(heights), max(heights)
    middle, reach = dot(axis, shape.center), shape.half_width_along(axis)
    return middle - reach, middle + reach


def _overlap_along_axis(a: Revolved, b: Revolved, tolerance: float) -> bool:
    """Return whether two shapes with one axis overlap in height."""
    offset = tuple(q - p for p, q in zip(a.profile.origin, b.profile.origin, strict=True))
    sign = math.copysign(1.0, dot(a.axis, b.axis))
    low, high = sorted(dot(offset, a.axis) + sign * w for w in (b.profile.low, b.profile.high))
    return min(high, a.profile.high) - max(low, a.profile.low) > tolerance


def _overlap_on_sphere(a: Sphere, b: Sphere) -> bool:
    """Return whether two zones of one sphere with different axes overlap.

    A point at polar angle t about one axis is seen from the other axis at polar angles from |t - tilt| to
    min(t + tilt, 2 pi - t - tilt); the zones overlap if a range of t satisfies both.
    """
    (first, last), (nearest, farthest) = _polar_angles(a), _polar_angles(b)
    tilt = math.atan2(math.dist(a.axis, b.axis), math.dist(a.axis, [-x for x in b.axis])) * 2
    low = max(first, tilt - farthest, nearest - tilt)
    high = min(last, tilt + farthest, 2 * math.pi - nearest - tilt)
    return high - low > math.sqrt(ROUNDING)  # error of an angle from a rounded cosine


def _polar_angles(zone: Sphere) -> tuple[float, float]:
    """Polar angles [rad] between which a zone lies."""
    return math.acos(zone.mu_max), math.acos(zone.mu_min)
