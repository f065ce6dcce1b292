"""Find acting surfaces that cut or touch the interior of another: overhanging walls, a sphere on a floor.

A particle that lands there lies within rounding of both surfaces, and the sign of a rounding error must not
decide on which side of the other it is. The engine keeps it on the side it came from, in scenes with such
contacts only.
"""

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from transport.geometry.coaxial import ring_contact
from transport.geometry.flat import Disk, FlatShape, Plane, Rectangle, Triangle
from transport.geometry.mesh import Mesh
from transport.geometry.revolved import Revolved
from transport.geometry.shape import ROUNDING, Shape
from transport.geometry.solid import Sphere
from transport.geometry.supports import are_on_one_support
from transport.scene.sheets import SheetMember
from transport.vectors import Vector, dot


def contact_pairs(members: list[SheetMember]) -> Iterator[tuple[int, int]]:
    """Yield pairs (hit, other) of acting members that come within rounding of one another.

    Yield nothing where surfaces share edges only: points near an edge are clamped to their own surface
    anyway.
    """
    pairs = list(_pairs(members))
    if any(is_inside for *_, is_inside in pairs):
        yield from (pair[:2] for pair in pairs)


def _pairs(members: list[SheetMember]) -> Iterator[tuple[int, int, bool]]:
    """Yield pairs (hit, other) that touch, and whether the contact lies inside `hit`, away from its edge."""
    if not members:
        return
    low, high = (np.array([member.shape.bounds[side] for member in members]) for side in (0, 1))
    places = np.array([(*member.shape.middle, *member.shape.middle) for member in members])
    # Derive the tolerance from the largest finite coordinate.
    finite = np.where(np.isfinite([*low.T, *high.T]).T, np.hstack((low, high)), places)
    tolerance = 64 * ROUNDING * (np.abs(finite[:, :3]).max() + np.abs(finite[:, 3:]).max())
    # Compare members with overlapping bounding boxes only.
    for hit, member in enumerate(members):
        near = ((low <= high[hit] + tolerance) & (high >= low[hit] - tolerance)).all(axis=1)
        for other in np.flatnonzero(near):
            if other != hit and touches(member.shape, members[other].shape, tolerance, tolerance):
                is_inside = touches(member.shape, members[other].shape, -tolerance, tolerance)
                yield hit, int(other), is_inside


def touches(hit: Shape, other: Shape, widened: float, tolerance: float) -> bool:
    """Return whether `hit` comes within the tolerance [m] of `other`.

    widened [m]: enlarges `hit` (negative: shrinks it).

    Exact for flat shapes, whole spheres and surfaces of revolution about one axis. Other pairs with a surface
    of revolution count as touching unless a plane separates them. A mesh touches nothing: it has no support.
    """
    if isinstance(hit, Mesh) or isinstance(other, Mesh) or are_on_one_support(hit, other):
        return False
    if isinstance(hit, FlatShape) and isinstance(other, FlatShape):
        inside, beside = _common_line(hit, other, widened, tolerance)
        return inside[0] < inside[1] and max(inside[0], beside[0]) <= min(inside[1], beside[1])
    if _is_whole_sphere(hit) and _is_whole_sphere(other):
        apart = math.dist(hit.center, other.center)
        return abs(hit.radius - other.radius) - tolerance <= apart <= hit.radius + other.radius + tolerance
    about_one_axis = ring_contact(hit, other, widened < 0, tolerance)
    if about_one_axis is not None:
        return about_one_axis
    if isinstance(hit, FlatShape) or isinstance(other, FlatShape):
        flat, turned = (hit, other) if isinstance(hit, FlatShape) else (other, hit)
        return _reaches_plane(turned, flat, tolerance)
    return True


def _is_whole_sphere(shape: Shape) -> bool:
    return isinstance(shape, Sphere) and shape.is_closed


def _reaches_plane(shape: Revolved, flat: FlatShape, tolerance: float) -> bool:
    """Return whether a surface of revolution reaches the plane of a flat shape."""
    height = dot(_difference(shape.profile.origin, flat.center), flat.normal)
    along = dot(shape.axis, flat.normal)
    across = math.hypot(*(dot(axis, flat.normal) for axis in shape.frame[:2]))
    reach = shape.profile.reach
    return -reach(-along, across) - tolerance <= -height <= reach(along, across) + tolerance


def _common_line(
    hit: Shape, other: Shape, widened: float, tolerance: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the intervals of two planes' common line within `hit`, widened, and within `other`."""
    nothing = (math.inf, -math.inf)
    slope = dot(hit.normal, other.normal)
    across = tuple(m - slope * n for m, n in zip(other.normal, hit.normal, strict=True))
    steep = dot(across, across)
    span = sum(shape.extent for shape in (hit, other) if not isinstance(shape, Plane))
    if steep <= max(ROUNDING, tolerance / span if span > 0 else 0.0) ** 2:
        return nothing, nothing
    step = dot(_difference(other.center, hit.center), other.normal) / steep
    point = tuple(c + step * a for c, a in zip(hit.center, across, strict=True))
    x, y = hit.normal, other.normal
    line = (x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0])
    line = tuple(value / math.sqrt(steep) for value in line)
    return _interval_in_shape(hit, point, line, widened), _interval_in_shape(other, point, line, tolerance)


def _interval_in_shape(shape: Shape, point: Vector, line: Vector, slack: float) -> tuple[float, float]:
    """Return the interval of a coplanar line within a shape widened by the slack, holes ignored."""
    offset = _difference(point, shape.center)
    if isinstance(shape, Disk):
        middle = -dot(offset, line)
        apart2 = dot(offset, offset) - middle * middle
        half2 = max(shape.radius + slack, 0.0) ** 2 - apart2
        half = math.sqrt(half2) if half2 > 0 else -math.inf
        return middle - half, middle + half
    enter, leave = -math.inf, math.inf
    for across, reach in _edges(shape):
        place, pace, half = dot(offset, across), dot(line, across), reach + slack
        if abs(pace) * shape.extent <= abs(slack):
            if place > half:
                return math.inf, -math.inf
            continue
        end = (half - place) / pace
        enter, leave = (enter, min(leave, end)) if pace > 0 else (max(enter, end), leave)
    return enter, leave


def _edges(shape: FlatShape) -> Iterator[tuple[Vector, float]]:
    """Yield outward unit vectors across the edges, with the edges' distances from the center [m]."""
    if isinstance(shape, Rectangle):
        for axis, length in zip(shape.frame[:2], (shape.width, shape.height), strict=True):
            yield from ((axis, length / 2), (_difference((0.0, 0.0, 0.0), axis), length / 2))
    if isinstance(shape, Triangle):
        e_u, e_v, _ = shape.frame
        for (p, s), (q, t) in pairwise((*shape.corners, shape.corners[0])):
            u, v = (t - s) / math.dist((p, s), (q, t)), (p - q) / math.dist((p, s), (q, t))
            yield tuple(u * a + v * b for a, b in zip(e_u, e_v, strict=True)), u * p + v * s


def _difference(a: Vector, b: Vector) -> Vector:
    return tuple(p - q for p, q in zip(a, b, strict=True))
