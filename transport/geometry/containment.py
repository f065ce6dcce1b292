"""Solids described by inequalities: half spaces, slabs, boxes and spheres; containment and overlap.

Exact up to the rounding of coordinates: solids that share only part of a plane do not overlap.
"""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np

from transport.geometry.distances import distance_to_shape
from transport.geometry.flat import Plane, Slab
from transport.geometry.mesh import Mesh
from transport.geometry.revolved import Cylinder
from transport.geometry.shape import ROUNDING, Shape
from transport.geometry.solid import Box, Sphere
from transport.vectors import Vector, dot


class HalfSpace(NamedTuple):
    """All points with normal · x <= level [m]."""

    normal: Vector
    level: float


Solid = HalfSpace | Slab | Box | Sphere | Cylinder  # a cylinder only as what may lie in another


def half_space(plane: Plane, is_front: bool) -> HalfSpace:
    """The half space behind a plane, or in front of it."""
    normal = tuple(-x for x in plane.normal) if is_front else plane.normal
    return HalfSpace(normal, dot(normal, plane.center))


def coordinate_scale(solid: Solid | Shape) -> float:
    """Sum of the absolute coordinates and lengths [m] that define a solid: the scale of its rounding."""
    match solid:
        case HalfSpace():
            return abs(solid.level)
        case Slab():
            return sum(map(abs, solid.center)) + solid.thickness
        case Sphere():
            return sum(map(abs, solid.center)) + solid.radius
        case Plane():
            return sum(map(abs, solid.center))
    return sum(map(abs, solid.middle)) + solid.extent


def contains_points(solid: Solid, points: np.ndarray) -> np.ndarray:
    """Return which points (n, 3) [m] lie in a solid, its surface included, as (n,) of bool."""
    match solid:
        case HalfSpace():
            return points @ np.array(solid.normal) <= solid.level
        case Slab():
            return np.abs((points - solid.center) @ np.array(solid.normal)) <= solid.thickness / 2
        case Sphere():
            direction = points - solid.center
            return (direction * direction).sum(axis=1) <= solid.radius * solid.radius
    low, high = solid.bounds
    return ((points >= low) & (points <= high)).all(axis=1)


def is_within(a: Solid, b: Solid) -> bool:
    """Return whether one solid lies wholly in another; their surfaces may touch."""
    tolerance = _tolerance(a, b)
    if isinstance(b, Sphere):
        return _max_distance(a, b.center) <= b.radius + tolerance
    return all(
        _support_function(a, normal) <= level + tolerance for normal, level in _bounding_half_spaces(b)
    )


def contains(shell: Shape, place: Shape | Vector) -> bool:
    """Return whether a shape or a point [m] surely lies in a closed solid, surface included."""
    if not isinstance(place, Shape):
        return (
            shell.holds(place)
            if isinstance(shell, Mesh)
            else bool(contains_points(shell, np.array([place]))[0])
        )
    if place.is_infinite:
        return False
    if isinstance(shell, Mesh):
        return shell.holds(place.middle) and distance_to_shape(shell, place.middle) >= place.extent
    if isinstance(place, Box | Sphere) and place.is_closed:
        return is_within(place, shell)
    corners, middle = np.array(list(product(*zip(*place.bounds, strict=True)))), np.array(place.middle)
    margin = ROUNDING * (
        coordinate_scale(shell) + coordinate_scale(place)
    )  # a shape in the wall counts as inside
    return bool(contains_points(shell, corners + np.clip(middle - corners, -margin, margin)).all())


def solids_overlap(a: Solid, b: Solid) -> bool:
    """Return whether two solids have a common volume."""
    tolerance = _tolerance(a, b)
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
        sides = zip(a.center, *b.bounds, strict=True)
        return math.hypot(*(max(low - x, x - high, 0.0) for x, low, high in sides)) < a.radius - tolerance
    return True


def _tolerance(a: Solid, b: Solid) -> float:
    """Rounding [m] of two solids."""
    return ROUNDING * (coordinate_scale(a) + coordinate_scale(b))


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
