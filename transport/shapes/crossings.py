"""Intersections of straight lines with shapes, in plain NumPy: slow, independent of the engine.

Scenes with media are checked with it, and tests compare the engine with it.
"""

import math
from functools import singledispatch
from typing import NamedTuple

import numpy as np

from transport.shapes.base import Shape
from transport.shapes.flat import Disk, FlatShape, Rectangle, Triangle
from transport.shapes.infinite import Plane, Slab
from transport.shapes.mesh import Mesh
from transport.shapes.revolved import Revolved
from transport.shapes.solid import Box


class Crossings(NamedTuple):
    """Crossings of each line, sorted by distance; rows with fewer crossings than others are padded with nan.

    distances: (lines, most) [m], negative behind the origin;  sides: (lines, most), +1 where the line runs
    along the normal (leaves a closed shape), -1 where it runs against the normal.
    """

    distances: np.ndarray
    sides: np.ndarray


def crossings(shape: Shape, origins: np.ndarray, directions: np.ndarray) -> Crossings:
    """Return all crossings of a shape with infinite lines.

    origins: (lines, 3) [m];  directions: (lines, 3) unit vectors. A line within a surface does not cross it.
    Whether a line that touches a surface, a rim or an edge crosses it is decided by rounding.
    """
    origins, directions = (
        np.atleast_2d(np.asarray(origins, float)),
        np.atleast_2d(np.asarray(directions, float)),
    )
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        distances, sides = _crossed(shape, origins, directions)
    # Sort each line's crossings by distance and cut the columns that hold none.
    distances = np.where(np.isfinite(distances), distances, math.nan)
    order = np.argsort(distances, axis=1, kind="stable")  # nan comes last
    distances, sides = (np.take_along_axis(array, order, axis=1) for array in (distances, sides))
    most = int(np.isfinite(distances).sum(axis=1).max(initial=0))
    distances = distances[:, :most]
    return Crossings(distances, np.where(np.isnan(distances), math.nan, sides[:, :most]))


@singledispatch
def _crossed(shape: Shape, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distances [m] and sides of all candidate crossings; nan where there is none."""
    raise TypeError(f"{type(shape).__name__} has no surface")


@_crossed.register
def _(shape: FlatShape, origins, directions):
    """The intersection with the plane, if it lies on the shape."""
    along = directions @ np.array(shape.normal)
    distances = ((np.array(shape.center) - origins) @ np.array(shape.normal)) / along
    points = origins + distances[:, None] * directions
    distances = np.where(_covers(shape, points), distances, math.nan)
    return distances[:, None], np.sign(along)[:, None]


@_crossed.register
def _(shape: Slab, origins, directions):
    """The intersections with both planes."""
    both = [_crossed(plane, origins, directions) for plane in shape.planes()]
    return tuple(np.concatenate(parts, axis=1) for parts in zip(*both, strict=True))


@_crossed.register
def _(shape: Box, origins, directions):
    """Entry at the last of the three planes towards the origin, exit at the first of the others."""
    low, high = (np.array(corner) for corner in shape.bounds)
    ahead = directions > 0
    way = np.where(directions == 0, 1.0, directions)
    into = np.where(ahead, low - origins, high - origins) / way
    out = np.where(ahead, high - origins, low - origins) / way
    beside = (directions == 0) & ((origins < low) | (origins > high))
    into = np.where(directions == 0, -math.inf, into).max(axis=1)
    out = np.where(directions == 0, math.inf, out).min(axis=1)
    is_met = (into < out) & ~beside.any(axis=1)
    distances = np.where(is_met[:, None], np.stack([into, out], axis=1), math.nan)
    return distances, np.broadcast_to([-1.0, 1.0], distances.shape)


@_crossed.register
def _(shape: Revolved, origins, directions):
    """Roots of |x|^2 + |y|^2 - (alpha + beta w + gamma w^2) along the line.

    The origin is moved to the point of the line nearest to the shape (or the apex) first, against
    cancellation.
    """
    profile, frame = shape.profile, np.array(shape.frame)
    center = np.array(profile.origin if profile.narrowing() else shape.middle)
    nearest = ((center - origins) * directions).sum(axis=1)
    x, y, w = frame @ (origins + nearest[:, None] * directions - np.array(profile.origin)).T
    p, q, r = frame @ directions.T
    # Solve a t^2 + 2 b t + c = 0 with the stable formula: no difference of close numbers.
    a = p * p + q * q - profile.gamma * r * r
    b = x * p + y * q - (profile.beta / 2 + profile.gamma * w) * r
    c = x * x + y * y - (profile.alpha + w * (profile.beta + profile.gamma * w))
    far = -(b + np.copysign(np.sqrt(b * b - a * c), b))
    steps = np.stack([far / a, c / far], axis=1)
    # Keep the roots between the two rims.
    heights = w[:, None] + r[:, None] * steps
    within = (heights >= profile.low) & (heights <= profile.high)
    return np.where(within, steps + nearest[:, None], math.nan), np.sign(a[:, None] * steps + b[:, None])


@_crossed.register
def _(shape: Mesh, origins, directions):
    """The crossings of each line with the mesh, one line after the other."""
    found = [_through_mesh(shape, o, u) for o, u in zip(origins, directions, strict=True)]
    most = max((len(distances) for distances, _ in found), default=0)
    distances, sides = np.full((len(found), most), math.nan), np.full((len(found), most), math.nan)
    for row, (hits, ways) in enumerate(found):
        distances[row, : len(hits)], sides[row, : len(hits)] = hits, ways
    return distances, sides


def _through_mesh(mesh: Mesh, origin: np.ndarray, direction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Crossings of one line with a mesh.

    A triangle is hit if its edges, projected along the line, all turn the same way around the line. Both
    triangles at an edge compute the same sign for that edge, so no line slips between them.
    """
    # Project all vertices onto a plane across the line.
    across = np.eye(3)[np.argmin(np.abs(direction))]
    e_u = np.cross(direction, across)
    e_u /= np.linalg.norm(e_u)
    x, y = (mesh.vertices - origin) @ e_u, (mesh.vertices - origin) @ np.cross(direction, e_u)
    i, j, k = mesh.faces.T
    # Keep the triangles that surround the line.
    turns = np.stack([x[p] * y[q] - y[p] * x[q] for p, q in ((i, j), (j, k), (k, i))])
    hit = np.flatnonzero((turns >= 0).all(axis=0) | (turns <= 0).all(axis=0))
    along = mesh.normals[hit] @ direction
    distances = ((mesh.vertices[i[hit]] - origin) * mesh.normals[hit]).sum(axis=1) / along
    kept = np.isfinite(distances)
    return distances[kept], np.sign(along[kept])


def _covers(shape: FlatShape, points: np.ndarray) -> np.ndarray:
    """Whether points (n, 3) of its plane lie on a flat shape."""
    u, v, _ = np.array(shape.frame) @ (points - np.array(shape.center)).T
    match shape:
        case Plane():
            return np.ones(len(points), bool)
        case Rectangle():
            inside = (np.abs(u) <= shape.width / 2) & (np.abs(v) <= shape.height / 2)
            return inside if shape.hole is None else inside & ~_covers(shape.hole, points)
        case Disk():
            rho = np.hypot(u, v)
            return (rho <= shape.radius) & (rho >= shape.inner_radius)
        case Triangle():
            places = [(p - u, q - v) for p, q in shape.corners]
            turned = [p * t - q * s for (p, q), (s, t) in zip(places, places[1:] + places[:1], strict=True)]
            return np.all([turn >= 0 for turn in turned], axis=0)
    raise TypeError(f"{type(shape).__name__} is not a flat shape")
