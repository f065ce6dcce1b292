"""Relations of shapes: one support, overlap, one within another, distance, side of a plane.

A support is the infinite plane or surface of revolution on which a shape lies; a mesh is its own support. Two
shapes have one support if they differ only by the rounding of their coordinates. Solids that share only part
of a plane do not overlap.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np

from transport.geometry.flat import Disk, FlatPolygon, FlatShape, Plane, Slab
from transport.geometry.mesh import Mesh
from transport.geometry.revolved import Cylinder, Revolved
from transport.geometry.shape import ROUNDING, Shape
from transport.geometry.solid import Box, Sphere
from transport.vectors import Vector, are_parallel, dot

# Cosine and sine of five azimuths, none along a symmetry axis.
AZIMUTHS = [(math.cos(turn), math.sin(turn)) for turn in (2 * math.pi * (k + 0.3) / 5 for k in range(5))]
OFFSET_IN_ROUNDINGS = 256  # offset from a flat shape, in units of the rounding of coordinates


# ---- Supports.

ROUNDINGS_APART = 8  # a point that is no farther off a shape may end up on either side of it


def are_on_one_support(a: Shape, b: Shape) -> bool:
    """Return whether two shapes lie on the same plane or the same surface of revolution, within rounding."""
    if a.is_flat and b.is_flat:
        if isinstance(a, FlatPolygon) or isinstance(b, FlatPolygon):
            return _has_vertices_on(a, b) or _has_vertices_on(b, a)
        return _are_on_one_plane(a, b)
    if isinstance(a, Sphere) and isinstance(b, Sphere):
        tolerance = rounding_tolerance(a, b)
        return math.dist(a.center, b.center) <= tolerance and abs(a.radius - b.radius) <= tolerance
    if all(isinstance(shape, Revolved) and not isinstance(shape, Sphere) for shape in (a, b)):
        return _has_rings_on(a, b) or _has_rings_on(b, a)
    return a == b


def is_on_support(position: Vector, shape: Shape) -> bool:
    """Return whether a point lies on the plane or surface of revolution of a shape, within rounding."""
    return _is_near_support(position, shape, ROUNDING * (shape.coordinate_scale + sum(map(abs, position))))


def is_on(position: Vector, shape: Shape) -> bool:
    """Return whether a point lies on a shape itself, within some roundings of its coordinates."""
    tolerance = ROUNDINGS_APART * ROUNDING * (shape.coordinate_scale + sum(map(abs, position)))
    return shape.distance(position) <= tolerance


def relative_orientation(support: Shape, shape: Shape) -> float:
    """-1 if the normals of two shapes on one support are opposite, else +1."""
    if support.is_flat and shape.is_flat:
        return math.copysign(1.0, dot(support.normal, shape.normal))
    return 1.0


def rounding_tolerance(a: Shape | HalfSpace, b: Shape | HalfSpace) -> float:
    """Distance [m] that rounding of coordinates can leave between two shapes that are meant to touch."""
    return ROUNDING * (a.coordinate_scale + b.coordinate_scale)


def _are_on_one_plane(a: FlatShape, b: FlatShape) -> bool:
    """Return whether two flat shapes lie on one plane, within rounding."""
    # Compare the offset between the planes and the effect of their tilt over both shapes.
    tolerance = rounding_tolerance(a, b)
    apart = math.dist(a.center, b.center)
    sign = relative_orientation(a, b)
    tilt = math.hypot(*(p - q * sign for p, q in zip(a.normal, b.normal, strict=True)))
    offset = abs(dot(tuple(p - q for p, q in zip(a.center, b.center, strict=True)), a.normal))
    if a.is_infinite and b.is_infinite:
        return offset <= tolerance and tilt <= ROUNDING
    reach = sum(shape.extent for shape in (a, b) if not shape.is_infinite)
    return offset <= tolerance and tilt * (apart + reach) <= tolerance


def _has_vertices_on(support: Shape, shape: Shape) -> bool:
    """Return whether a polygon's vertices lie on a support: they are more accurate than its normal."""
    return isinstance(shape, FlatPolygon) and all(is_on_support(vertex, support) for vertex in shape.vertices)


def _has_rings_on(support: Revolved, shape: Revolved) -> bool:
    """Return whether three rings of a surface of revolution lie on another's support.

    Different quadrics intersect in a curve of degree 4, so they share two circles at most. A circle that is
    not on a quadric meets it in four points at most, so five points per ring decide.
    """
    profile, frame, tolerance = shape.profile, shape.frame, rounding_tolerance(support, shape)
    for w in (profile.low, profile.low / 2 + profile.high / 2, profile.high):
        rho = profile.radius_at(w)
        for cosine, sine in AZIMUTHS:
            steps = zip(profile.origin, *frame, strict=True)
            point = tuple(o + rho * (cosine * u + sine * v) + w * n for o, u, v, n in steps)
            if not _is_near_support(point, support, tolerance):
                return False
    return True


def _is_near_support(position: Vector, shape: Shape, tolerance: float) -> bool:
    """Return whether a point lies within a tolerance [m] of a shape's support."""
    if shape.is_flat:
        return abs(shape.height_of(position)) <= tolerance
    if isinstance(shape, Sphere):
        return abs(math.dist(position, shape.center) - shape.radius) <= tolerance
    if isinstance(shape, Revolved):
        rho, w = shape.cylindrical(position)
        return (
            shape.profile.is_on_branch(w, tolerance)
            and abs(shape.profile.signed_distance(rho, w)) <= tolerance
        )
    return False


# ---- Overlap of two shapes on one support: they may not both act as surfaces there.


def overlap(a: Shape, b: Shape) -> bool:
    """Return whether two shapes on one support have more than an edge in common.

    Exact, except for a shape that reaches into a hole which is open at the edge of its rectangle: this counts
    as an overlap.
    """
    if a.is_flat and b.is_flat:
        pairs = product(a.primitives(), b.primitives())
        return any(_overlap_on_plane(p, q, rounding_tolerance(a, b)) for p, q in pairs)
    if isinstance(a, Sphere) and isinstance(b, Sphere) and not are_parallel(a.axis, b.axis):
        return _overlap_on_sphere(a, b)
    if isinstance(a, Revolved) and isinstance(b, Revolved):
        return _overlap_along_axis(a, b, rounding_tolerance(a, b))
    return True


def _overlap_on_plane(a: FlatShape, b: FlatShape, tolerance: float) -> bool:
    """Return whether two flat shapes on one plane overlap."""
    if a.is_infinite or b.is_infinite:
        return True
    if _hole_contains(a, b, tolerance) or _hole_contains(b, a, tolerance):
        return False
    if not isinstance(a, Disk) and not isinstance(b, Disk):
        return all(_projected_gap(out, a, b) < -tolerance for shape in (a, b) for out, _ in shape.edges())
    disk, other = (a, b) if isinstance(a, Disk) else (b, a)
    nearest, farthest = other.in_plane_distances(disk.center)
    return nearest < disk.radius - tolerance and farthest > disk.inner_radius + tolerance


def _hole_contains(shape: FlatShape, other: FlatShape, tolerance: float) -> bool:
    """Return whether the other shape lies within the hole of a rectangle."""
    hole = shape.hole
    if hole is None:
        return False
    if isinstance(hole, Disk):
        return other.in_plane_distances(hole.center)[1] <= hole.radius + tolerance
    for axis, length in zip(hole.frame[:2], (hole.width, hole.height), strict=True):
        low, high = other.interval_along(axis)
        middle = dot(axis, hole.center)
        if low < middle - length / 2 - tolerance or high > middle + length / 2 + tolerance:
            return False
    return True


def _projected_gap(axis: Vector, a: FlatShape, b: FlatShape) -> float:
    """Distance [m] between projections of two shapes on an axis; negative if they overlap."""
    (low_a, high_a), (low_b, high_b) = a.interval_along(axis), b.interval_along(axis)
    return max(low_a, low_b) - min(high_a, high_b)


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


# ---- Solids described by inequalities: half spaces, slabs, boxes and spheres. Exact up to rounding.


class HalfSpace(NamedTuple):
    """All points with normal · x <= level [m]."""

    normal: Vector
    level: float
    is_infinite = True

    @property
    def coordinate_scale(self) -> float:
        """Scale of its rounding [m]."""
        return abs(self.level)

    def contains(self, points: np.ndarray) -> np.ndarray:
        """Return which points (n, 3) [m] lie in it, its plane included."""
        return points @ np.array(self.normal) <= self.level


Solid = HalfSpace | Slab | Box | Sphere | Cylinder  # a cylinder only as what may lie in another


def half_space(plane: Plane, is_front: bool) -> HalfSpace:
    """The half space behind a plane, or in front of it."""
    normal = tuple(-x for x in plane.normal) if is_front else plane.normal
    return HalfSpace(normal, dot(normal, plane.center))


def is_within(a: Solid, b: Solid) -> bool:
    """Return whether one solid lies wholly in another; their surfaces may touch."""
    tolerance = rounding_tolerance(a, b)
    if isinstance(b, Sphere):
        return _max_distance(a, b.center) <= b.radius + tolerance
    return all(
        _support_function(a, normal) <= level + tolerance for normal, level in _bounding_half_spaces(b)
    )


def solids_overlap(a: Solid, b: Solid) -> bool:
    """Return whether two solids have a common volume."""
    tolerance = rounding_tolerance(a, b)
    # Look for a face of either solid that separates them.
    for one, other in ((a, b), (b, a)):
        for normal, level in _bounding_half_spaces(one):
            if -_support_function(other, tuple(-x for x in normal)) >= level - tolerance:
                return False
    if isinstance(a, Sphere) and isinstance(b, Sphere):
        return math.dist(a.center, b.center) < a.radius + b.radius - tolerance
    if isinstance(b, Sphere):
        a, b = b, a
    if isinstance(a, Sphere) and isinstance(b, Box):
        return b.distance(a.center, filled=True) < a.radius - tolerance
    return True


def boxes_meet(shape: Shape, *others: Shape) -> bool:
    """Return whether the bounding box of a shape and the common one of others overlap or touch."""
    low, high = (np.array(corner) for corner in shape.bounds)
    bounds = np.array([other.bounds for other in others])
    return bool((low <= bounds[:, 1].max(axis=0)).all() and (bounds[:, 0].min(axis=0) <= high).all())


def encloses(shell: Shape, place: Shape | Vector) -> bool:
    """Return whether a shape or a point [m] surely lies in a closed solid, surface included."""
    if not isinstance(place, Shape):
        return bool(shell.contains(np.array([place]))[0])
    if place.is_infinite:
        return False
    if isinstance(shell, Mesh):
        return shell.holds(place.middle) and shell.distance(place.middle) >= place.extent
    if place.is_convex:
        return is_within(place, shell)
    corners, middle = np.array(place.bounds_corners()), np.array(place.middle)
    margin = rounding_tolerance(shell, place)  # a shape in the wall counts as inside
    return bool(shell.contains(corners + np.clip(middle - corners, -margin, margin)).all())


@lru_cache(maxsize=256)
def _bounding_half_spaces(solid: Solid) -> tuple[HalfSpace, ...]:
    """Half spaces whose intersection is the solid; none for a sphere."""
    match solid:
        case HalfSpace():
            return (solid,)
        case Slab():
            return tuple(half_space(plane, is_front=False) for plane in solid.planes())
        case Box():
            walls = []
            for axis, low, high in zip(np.eye(3).tolist(), *solid.bounds, strict=True):
                walls += [HalfSpace(tuple(axis), high), HalfSpace(tuple(-x for x in axis), -low)]
            return tuple(walls)
    return ()


def _support_function(solid: Solid, direction: Vector) -> float:
    """Largest projection [m] of a solid on a unit vector; infinite unless a face is perpendicular to it."""
    match solid:
        case Box():
            return sum(
                (high if x > 0 else low) * x for x, low, high in zip(direction, *solid.bounds, strict=True)
            )
        case Sphere():
            return dot(solid.center, direction) + solid.radius
        case Cylinder():
            along = dot(solid.axis, direction)
            across = math.sqrt(max((1 - along) * (1 + along), 0.0))
            return dot(solid.center, direction) + abs(along) * solid.height / 2 + across * solid.radius
    for normal, level in _bounding_half_spaces(solid):
        if math.dist(normal, direction) <= ROUNDING:
            return level
    return math.inf


def _max_distance(solid: Solid, point: Vector) -> float:
    """Largest distance [m] of a solid's points from a point; infinite for infinite solids."""
    match solid:
        case Sphere():
            return math.dist(solid.center, point) + solid.radius
        case Cylinder():
            away = tuple(p - c for p, c in zip(point, solid.center, strict=True))
            along = dot(away, solid.axis)
            across = math.sqrt(max(dot(away, away) - along * along, 0.0))
            return math.hypot(across + solid.radius, abs(along) + solid.height / 2)
        case Box():
            sides = zip(point, *solid.bounds, strict=True)
            return math.hypot(*(max(abs(x - low), abs(x - high)) for x, low, high in sides))
    return math.inf


# ---- Distances between shapes, accurate to rounding, and sides of planes.


def least_height(shape: Shape, plane: FlatShape) -> float:
    """Least height [m] of a shape's bounds over the plane of a flat shape; 0 if they lie on both sides."""
    if shape.is_infinite:
        return 0.0
    heights = [plane.height_of(corner) for corner in shape.bounds_corners()]
    return max(0.0, min(heights), -max(heights))


def gap_lower_bound(first: Shape, second: Shape) -> float:
    """Lower bound [m] of the distance between two shapes; 0 where nothing is known.

    It follows from bounding spheres and boxes, and from the planes of flat shapes.
    """
    if first.is_infinite or second.is_infinite:
        return 0.0
    balls = math.dist(first.middle, second.middle) - first.extent - second.extent
    sides = zip(*first.bounds, *second.bounds, strict=True)
    boxes = math.hypot(
        *(max(low - other_high, other_low - high, 0.0) for low, high, other_low, other_high in sides)
    )
    pairs = (first, second), (second, first)
    heights = [least_height(shape, flat) for shape, flat in pairs if flat.is_flat]
    return max(balls, boxes, *heights, 0.0)


def point_beside(flat: FlatShape, is_back: bool, others: Iterable[Shape]) -> Vector:
    """Point in front of (or behind) the middle of a flat shape, off all other shapes in spite of rounding."""
    step = OFFSET_IN_ROUNDINGS * max(
        (rounding_tolerance(flat, other) for other in others), default=rounding_tolerance(flat, flat)
    )
    step = -step if is_back else step
    return tuple(p + step * n for p, n in zip(flat.middle, flat.normal, strict=True))


def is_behind(shape: Shape, flat: Shape, side: str | None) -> bool:
    """Return whether no point of a shape lies in front of a side ("front" or "back") of a flat shape.

    False where nothing is known: no side, or a shape that is not flat.
    """
    if side is None or not flat.is_flat:
        return False
    if are_on_one_support(shape, flat):
        return True
    sign = 1.0 if side == "front" else -1.0

    def height(point: Vector) -> float:
        return sign * flat.height_of(point)

    if isinstance(shape, Plane | Slab):
        turned = tuple(-x for x in flat.normal)
        is_parallel = min(math.dist(shape.normal, n) for n in (flat.normal, turned)) <= ROUNDING
        return is_parallel and height(shape.middle) + getattr(shape, "thickness", 0.0) / 2 <= 0
    highest = max(map(height, shape.bounds_corners()))
    return min(highest, height(shape.middle) + shape.extent) <= rounding_tolerance(shape, flat)
