"""Distances between points and shapes, accurate to rounding; they bound the weights of aimed sources."""

import math
from collections.abc import Iterable
from itertools import product

import numpy as np

from transport.geometry.flat import Disk, FlatShape, Plane, Rectangle, Slab, Triangle, distance_to_triangle
from transport.geometry.mesh import Mesh
from transport.geometry.revolved import Paraboloid, Profile, Revolved
from transport.geometry.shape import ROUNDING, Shape
from transport.geometry.solid import Box, Sphere
from transport.geometry.supports import are_on_one_support, cylindrical_coordinates, rounding_tolerance
from transport.vectors import Vector, dot

OFFSET_IN_ROUNDINGS = 256  # offset from a flat shape, in units of the rounding of coordinates


def distance_to_shape(shape: Shape, point: Vector, filled: bool = False) -> float:
    """Distance [m] from a point to the nearest point of a shape; filled: to the volume of a closed shape."""
    offset = tuple(p - q for p, q in zip(point, shape.middle, strict=True))
    match shape:
        case Sphere(radius=radius, is_zone=False):
            beyond = math.hypot(*offset) - radius
            return max(beyond, 0.0) if filled else abs(beyond)
        case Revolved():
            return _distance_to_profile(shape, *cylindrical_coordinates(shape, point))
        case Box():
            beyond = [abs(x) - size / 2 for x, size in zip(offset, shape.size, strict=True)]
            if filled or max(beyond) > 0:
                return math.hypot(*(max(x, 0.0) for x in beyond))
            return -max(beyond)
        case Slab():
            beyond = abs(dot(offset, shape.normal)) - shape.thickness / 2
            return max(beyond, 0.0) if filled else abs(beyond)
        case FlatShape():
            u, v, height = (dot(offset, axis) for axis in shape.frame)
            return math.hypot(height, *_offset_from_flat(shape, u, v))
        case Mesh():
            return (
                0.0 if filled and shape.is_closed and shape.holds(point) else _distance_to_mesh(shape, point)
            )
    return math.hypot(*offset)


def least_height(shape: Shape, plane: FlatShape) -> float:
    """Least height [m] of a shape's bounds over the plane of a flat shape; 0 if they lie on both sides."""
    if shape.is_infinite:
        return 0.0
    corners = product(*zip(*shape.bounds, strict=True))
    offsets = ([p - q for p, q in zip(corner, plane.middle, strict=True)] for corner in corners)
    heights = [dot(edge, plane.normal) for edge in offsets]
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
    heights = [least_height(shape, flat) for shape, flat in pairs if isinstance(flat, FlatShape)]
    return max(balls, boxes, *heights, 0.0)


def point_beside(flat: FlatShape, is_back: bool, others: Iterable[Shape]) -> Vector:
    """Point in front of (or behind) the middle of a flat shape, off all other shapes in spite of rounding."""
    step = OFFSET_IN_ROUNDINGS * max(
        (rounding_tolerance(flat, other) for other in others), default=rounding_tolerance(flat, flat)
    )
    step = -step if is_back else step
    return tuple(p + step * n for p, n in zip(flat.middle, flat.normal, strict=True))


def is_behind(shape: Shape, flat: FlatShape, side: str) -> bool:
    """Return whether no point of a shape lies in front of a side ("front" or "back") of a flat shape."""
    if are_on_one_support(shape, flat):
        return True
    sign = 1.0 if side == "front" else -1.0

    def height(point: Vector) -> float:
        return sign * dot(tuple(p - q for p, q in zip(point, flat.middle, strict=True)), flat.normal)

    if isinstance(shape, Plane | Slab):
        turned = tuple(-x for x in flat.normal)
        is_parallel = min(math.dist(shape.normal, n) for n in (flat.normal, turned)) <= ROUNDING
        return is_parallel and height(shape.middle) + getattr(shape, "thickness", 0.0) / 2 <= 0
    if shape.is_infinite:
        return False
    reach = shape.radius if isinstance(shape, Sphere) and shape.is_closed else shape.extent
    highest = max(map(height, product(*zip(*shape.bounds, strict=True))))
    return min(highest, height(shape.middle) + reach) <= rounding_tolerance(shape, flat)


def in_plane_distances(shape: Rectangle | Disk | Triangle, point: Vector) -> tuple[float, float]:
    """Least and greatest distance [m] from a point of the plane to the points of a shape in that plane."""
    offset = tuple(p - q for p, q in zip(point, shape.center, strict=True))
    u, v = (dot(offset, axis) for axis in shape.frame[:2])
    nearest = math.hypot(*_offset_from_flat(shape, u, v))
    if isinstance(shape, Disk):
        return nearest, math.hypot(u, v) + shape.radius
    if isinstance(shape, Triangle):
        return nearest, max(math.dist(point, vertex) for vertex in shape.vertices)
    return nearest, math.hypot(abs(u) + shape.width / 2, abs(v) + shape.height / 2)


def _offset_from_flat(shape: FlatShape, u: float, v: float) -> tuple[float, ...]:
    """Components [m] of the vector from a point of the plane to the nearest point of a flat shape."""
    if isinstance(shape, Plane):
        return (0.0,)
    if isinstance(shape, Triangle):
        return (distance_to_triangle(shape.corners, u, v),)
    if isinstance(shape, Disk):
        apart = math.hypot(u, v)
        return (max(0.0, apart - shape.radius, shape.inner_radius - apart),)
    if shape.hole is not None:
        depth = _depth_in_hole(shape, u, v)
        if depth > 0:
            return (depth,)
    return max(0.0, abs(u) - shape.width / 2), max(0.0, abs(v) - shape.height / 2)


def _depth_in_hole(shape: Rectangle, u: float, v: float) -> float:
    """Distance [m] of a point of the plane from the edge of a rectangle's hole; negative outside the hole."""
    hole, (e_u, e_v, _) = shape.hole, shape.frame
    steps = zip(shape.center, e_u, e_v, hole.center, strict=True)
    offset = tuple(c + u * p + v * q - h for c, p, q, h in steps)
    along, up = (abs(dot(offset, axis)) for axis in hole.frame[:2])
    if isinstance(hole, Disk):
        return hole.radius - math.hypot(along, up)
    return min(hole.width / 2 - along, hole.height / 2 - up)


def _distance_to_profile(shape: Revolved, rho: float, w: float) -> float:
    """Distance [m] from a point at axial distance rho and height w to a surface of revolution."""
    profile = shape.profile
    if isinstance(shape, Sphere):
        apart = math.hypot(rho, w)
        if profile.low * apart <= w * shape.radius <= profile.high * apart:
            return abs(apart - shape.radius)
        return min(_distance_to_rim(profile, rim, rho, w) for rim in (profile.low, profile.high))
    if isinstance(shape, Paraboloid):
        return _distance_to_parabola(shape, rho, w)
    rims = [(profile.radius_at(rim), rim) for rim in (profile.low, profile.high)]
    length = math.dist(*rims)
    # Project the point onto the straight profile between the two rims (cylinder, cone).
    edge, offset = (
        tuple((q - p) / length for p, q in zip(*rims, strict=True)),
        (rho - rims[0][0], w - rims[0][1]),
    )
    onward, across = edge[0] * offset[0] + edge[1] * offset[1], edge[1] * offset[0] - edge[0] * offset[1]
    return math.hypot(across, onward - min(max(onward, 0.0), length))


def _distance_to_rim(profile: Profile, height: float, rho: float, w: float) -> float:
    """Distance [m] from a point at axial distance rho and height w to the rim at `height`."""
    return math.hypot(rho - profile.radius_at(height), w - height)


def _distance_to_parabola(shape: Paraboloid, rho: float, w: float) -> float:
    """Minimum over r of the distance to (r, r^2/4f): the roots of r^3 + (8 f^2 - 4 f w) r = 8 f^2 rho."""
    size, f = shape.radius, shape.focal_length / shape.radius
    rho, w = rho / size, w / size
    roots = np.roots([1.0, 0.0, 8 * f * f - 4 * f * w, -8 * f * f * rho]).real
    radii = [*np.clip(roots, shape.inner_radius / size, 1.0).tolist(), shape.inner_radius / size, 1.0]
    return size * min(math.hypot(rho - r, w - r * r / (4 * f)) for r in radii)


def _distance_to_mesh(mesh: Mesh, point: Vector) -> float:
    """For each triangle the height over it if the foot lies inside, else the distance to the nearest side."""
    corners = mesh.vertices[mesh.faces] - np.array(point)
    height = np.abs(np.einsum("ij,ij->i", corners[:, 0], mesh.normals))
    is_over, nearest = True, math.inf
    for k in range(3):
        start, side = corners[:, k], corners[:, (k + 1) % 3] - corners[:, k]
        is_over &= np.einsum("ij,ij->i", np.cross(start, side), mesh.normals) >= 0  # to the left of each side
        step = -np.einsum("ij,ij->i", start, side) / np.einsum("ij,ij->i", side, side)
        apart = np.linalg.norm(start + np.clip(step, 0.0, 1.0)[:, None] * side, axis=1)
        nearest = np.minimum(nearest, apart)
    return float(np.where(is_over, height, nearest).min())
