"""Supports: the infinite plane or surface of revolution on which a shape lies; a mesh is its own support.

Two shapes have one support if they differ only by the rounding of their coordinates.
"""

import math

from transport.geometry.flat import FlatShape, Plane, Slab, Triangle
from transport.geometry.revolved import Revolved
from transport.geometry.shape import ROUNDING, Shape
from transport.geometry.solid import Sphere
from transport.vectors import Vector, dot

# Cosine and sine of five azimuths, none along a symmetry axis.
AZIMUTHS = [(math.cos(turn), math.sin(turn)) for turn in (2 * math.pi * (k + 0.3) / 5 for k in range(5))]


def are_on_one_support(a: Shape, b: Shape) -> bool:
    """Return whether two shapes lie on the same plane or the same surface of revolution, within rounding."""
    if isinstance(a, FlatShape) and isinstance(b, FlatShape):
        if isinstance(a, Triangle) or isinstance(b, Triangle):
            return _has_vertices_on(a, b) or _has_vertices_on(b, a)
        return _are_on_one_plane(a, b)
    if isinstance(a, Sphere) and isinstance(b, Sphere):
        tolerance = rounding_tolerance(a, b)
        return math.dist(a.center, b.center) <= tolerance and abs(a.radius - b.radius) <= tolerance
    if isinstance(a, Revolved) and isinstance(b, Revolved):
        return _has_rings_on(a, b) or _has_rings_on(b, a)
    return a == b


def is_on_support(position: Vector, shape: Shape) -> bool:
    """Return whether a point lies on the plane or surface of revolution of a shape, within rounding."""
    return _is_near_support(position, shape, ROUNDING * (_magnitude(shape) + sum(map(abs, position))))


def relative_orientation(support: Shape, shape: Shape) -> float:
    """-1 if the normals of two shapes on one support are opposite, else +1."""
    if isinstance(support, FlatShape) and isinstance(shape, FlatShape):
        return math.copysign(1.0, dot(support.normal, shape.normal))
    return 1.0


def rounding_tolerance(a: Shape, b: Shape) -> float:
    """Distance [m] that rounding of coordinates can leave between two shapes that are meant to touch."""
    return ROUNDING * (_magnitude(a) + _magnitude(b))


def cylindrical_coordinates(shape: Revolved, position: Vector) -> tuple[float, float]:
    """Distance [m] of a point from the axis, and its height [m] along the axis from the profile's origin."""
    offset = tuple(p - o for p, o in zip(position, shape.profile.origin, strict=True))
    e_u, e_v, axis = shape.frame
    return math.hypot(dot(offset, e_u), dot(offset, e_v)), dot(offset, axis)


def _are_on_one_plane(a: FlatShape, b: FlatShape) -> bool:
    # Compare the offset between the planes and the effect of their tilt over both shapes.
    """Return whether two flat shapes lie on one plane, within rounding."""
    tolerance = rounding_tolerance(a, b)
    apart = math.dist(a.center, b.center)
    sign = relative_orientation(a, b)
    tilt = math.hypot(*(p - q * sign for p, q in zip(a.normal, b.normal, strict=True)))
    offset = abs(dot(tuple(p - q for p, q in zip(a.center, b.center, strict=True)), a.normal))
    if isinstance(a, Plane) and isinstance(b, Plane):
        return offset <= tolerance and tilt <= ROUNDING
    reach = sum(shape.extent for shape in (a, b) if not isinstance(shape, Plane))
    return offset <= tolerance and tilt * (apart + reach) <= tolerance


def _has_vertices_on(support: Shape, shape: Shape) -> bool:
    """Return whether a triangle's vertices lie on a support: they are more accurate than its normal."""
    return isinstance(shape, Triangle) and all(is_on_support(vertex, support) for vertex in shape.vertices)


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
    if isinstance(shape, FlatShape):
        offset = tuple(p - q for p, q in zip(position, shape.center, strict=True))
        return abs(dot(offset, shape.normal)) <= tolerance
    if isinstance(shape, Sphere):
        return abs(math.dist(position, shape.center) - shape.radius) <= tolerance
    if isinstance(shape, Revolved):
        rho, w = cylindrical_coordinates(shape, position)
        return (
            shape.profile.is_on_branch(w, tolerance)
            and abs(shape.profile.signed_distance(rho, w)) <= tolerance
        )
    return False


def _magnitude(shape: Shape) -> float:
    """Sum of the absolute coordinates and lengths [m] that define a shape: the scale of its rounding."""
    if isinstance(shape, Plane | Slab):
        return sum(map(abs, shape.center)) + getattr(shape, "thickness", 0.0)
    if isinstance(shape, Sphere):
        return sum(map(abs, shape.center)) + shape.radius
    if isinstance(shape, Revolved):
        profile = shape.profile
        reach = max(math.hypot(w, profile.radius_at(w)) for w in (profile.low, profile.high))
        return sum(map(abs, profile.origin)) + reach
    return sum(map(abs, shape.middle)) + shape.extent
