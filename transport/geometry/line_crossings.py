"""Intersections of straight lines with shapes, in plain NumPy: slow, independent of the engine.

Scenes with media are checked with it, and tests compare the engine with it.
"""

from __future__ import annotations

import math
from functools import singledispatch
from typing import NamedTuple

import numpy as np

from transport.geometry.flat import FlatShape, Slab
from transport.geometry.mesh import Mesh
from transport.geometry.revolved import Revolved
from transport.geometry.shape import ROUNDING, Shape
from transport.geometry.solid import Box


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
        distances, sides = _candidates(shape, origins, directions)
    # Sort each line's crossings by distance and cut the columns that hold none.
    distances = np.where(np.isfinite(distances), distances, math.nan)
    order = np.argsort(distances, axis=1, kind="stable")  # nan comes last
    distances, sides = (np.take_along_axis(array, order, axis=1) for array in (distances, sides))
    most = int(np.isfinite(distances).sum(axis=1).max(initial=0))
    distances = distances[:, :most]
    return Crossings(distances, np.where(np.isnan(distances), math.nan, sides[:, :most]))


@singledispatch
def _candidates(shape: Shape, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distances [m] and sides of all candidate crossings; nan where there is none."""
    raise TypeError(f"{type(shape).__name__} has no surface")


@_candidates.register
def _(shape: FlatShape, origins, directions):
    """The intersection with the plane, if it lies on the shape."""
    along = directions @ np.array(shape.normal)
    distances = ((np.array(shape.center) - origins) @ np.array(shape.normal)) / along
    points = origins + distances[:, None] * directions
    distances = np.where(shape.covers(points), distances, math.nan)
    return distances[:, None], np.sign(along)[:, None]


@_candidates.register
def _(shape: Slab, origins, directions):
    """The intersections with both planes."""
    both = [_candidates(plane, origins, directions) for plane in shape.planes()]
    return tuple(np.concatenate(parts, axis=1) for parts in zip(*both, strict=True))


@_candidates.register
def _(shape: Box, origins, directions):
    """Entry at the last of the three planes towards the origin, exit at the first of the others."""
    low, high = (np.array(corner) for corner in shape.bounds)
    ahead = directions > 0
    divisors = np.where(directions == 0, 1.0, directions)
    into = np.where(ahead, low - origins, high - origins) / divisors
    out = np.where(ahead, high - origins, low - origins) / divisors
    beside = (directions == 0) & ((origins < low) | (origins > high))
    into = np.where(directions == 0, -math.inf, into).max(axis=1)
    out = np.where(directions == 0, math.inf, out).min(axis=1)
    is_met = (into < out) & ~beside.any(axis=1)
    distances = np.where(is_met[:, None], np.stack([into, out], axis=1), math.nan)
    return distances, np.broadcast_to([-1.0, 1.0], distances.shape)


@_candidates.register
def _(shape: Revolved, origins, directions):
    """Roots of |x|^2 + |y|^2 - (alpha + beta w + gamma w^2) along the line.

    The origin is moved to the point of the line nearest to the shape (or the apex) first, against
    cancellation.
    """
    profile, frame = shape.profile, np.array(shape.frame)
    center = np.array(profile.origin if profile.taper_sign() else shape.middle)
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


@_candidates.register
def _(shape: Mesh, origins, directions):
    """The crossings of each line with the mesh, one line after the other."""
    found = [_cross_mesh(shape, o, u) for o, u in zip(origins, directions, strict=True)]
    most = max((len(distances) for distances, _ in found), default=0)
    distances, sides = np.full((len(found), most), math.nan), np.full((len(found), most), math.nan)
    for row, (hits, hit_sides) in enumerate(found):
        distances[row, : len(hits)], sides[row, : len(hits)] = hits, hit_sides
    return distances, sides


def _cross_mesh(mesh: Mesh, origin: np.ndarray, direction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
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


# ---- Fixed set of straight lines through shapes, along which the media of a scene are checked.

DEFAULT_LINES = 256  # default number of lines
MAX_LINE_FACETS = 1_000_000  # most lines times triangles of meshes
EDGE_TOLERANCE = 1e-9  # relative to the scene's size: lines this close to an edge or a tangent are ignored
COINCIDENCE_TOLERANCE = 1e-11  # relative to the scene's size: surfaces this close count as coincident
# increments of an evenly distributed sequence in five dimensions
KRONECKER_STRIDES = 2.0 ** -(np.arange(1, 6) / 6)


def scene_size(shapes: list[Shape]) -> float:
    """Length scale [m] of a scene: diagonal of the box around finite shapes and middles of infinite ones."""
    corners = np.array([c for shape in shapes for c in (*shape.bounds, *(p.middle for p in shape.pieces()))])
    corners = corners[np.isfinite(corners).all(axis=1)]
    return float(np.linalg.norm(np.ptp(corners, axis=0))) or 1.0


def lines_through(shapes: list[Shape], count: int, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Lines through points in each shape's bounding box; every second one aims at a point in another box."""
    # Draw points in the boxes and isotropic directions from an evenly distributed sequence.
    boxes = np.array([_box(shape, size) for shape in shapes])
    number = np.arange(count)
    owner = number * len(shapes) // count
    u = np.modf((number[:, None] + 1) * KRONECKER_STRIDES)[0]
    origins = _points_in_boxes(boxes[owner], u[:, :3])
    rise, turn = 2 * u[:, 3] - 1, 2 * math.pi * u[:, 4]
    across = np.sqrt((1 - rise) * (1 + rise))
    directions = np.stack([across * np.cos(turn), across * np.sin(turn), rise], axis=1)
    # Aim every second line at a point in another shape's box.
    target = (owner + 1 + number // 2 % max(len(shapes) - 1, 1)) % len(shapes)
    to_points = _points_in_boxes(boxes[target], u[:, 2:]) - origins
    lengths = np.linalg.norm(to_points, axis=1)
    is_aimed = (number % 2 == 1) & (lengths > 0)
    directions[is_aimed] = to_points[is_aimed] / lengths[is_aimed, None]
    return origins, directions


def _points_in_boxes(boxes: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Points at fractions u of boxes."""
    return boxes[:, 0] + u * (boxes[:, 1] - boxes[:, 0])


def _box(shape: Shape, size: float) -> np.ndarray:
    """Corners of a shape's bounding box; an infinite shape's box has the size of the scene."""
    middle = np.array(shape.middle)
    return (
        np.clip(np.array(shape.bounds), middle - size, middle + size)
        if shape.is_infinite
        else np.array(shape.bounds)
    )


def with_neighbour_lines(
    origins: np.ndarray, directions: np.ndarray, close: float
) -> tuple[np.ndarray, np.ndarray]:
    """Origins and directions (4 n, 3) of n lines, then of three neighbours of each, `close` [m] away."""
    e_u = np.cross(directions, np.eye(3)[np.argmin(np.abs(directions), axis=1)])
    e_u /= np.linalg.norm(e_u, axis=1)[:, None]
    e_v = np.cross(directions, e_u)
    turns = [2 * math.pi * k / 3 for k in range(3)]
    shifts = [0 * e_u, *(close * (math.cos(turn) * e_u + math.sin(turn) * e_v) for turn in turns)]
    return np.concatenate([origins + shift for shift in shifts]), np.tile(directions, (4, 1))


def sorted_crossings(shapes: list[Shape], origins, directions, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Crossings of each line in order: places [m] and keys; -1 for lines that pass close to an edge.

    A key is 2 shapes group + 2 shape + (1: along its normal); coincident crossings have the same group.
    """
    # Cross all shapes with each line and its three neighbours, and sort the crossings.
    neighbours = with_neighbour_lines(origins, directions, EDGE_TOLERANCE * size)
    found = [crossings(shape, *neighbours) for shape in shapes]
    places = np.concatenate([f.distances for f in found], axis=1)
    codes = np.concatenate([np.where(f.sides > 0, 2 * n + 1, 2 * n) for n, f in enumerate(found)], axis=1)
    order = np.argsort(places, axis=1, kind="stable")  # nan comes last
    places, codes = (np.take_along_axis(array, order, axis=1) for array in (places, codes))
    # Number groups of coincident crossings.
    flush = COINCIDENCE_TOLERANCE * size + 256 * ROUNDING * max(shape.coordinate_scale for shape in shapes)
    group = np.cumsum(np.diff(places, axis=1, prepend=places[:, :1]) > flush, axis=1)
    keys = np.where(np.isnan(places), -1, 2 * len(shapes) * group + codes).astype(np.int64)
    places, keys = (array.reshape(4, len(origins), -1) for array in (places, keys))
    # Keep only lines whose neighbours cross the same surfaces.
    by_key = np.sort(keys, axis=2)  # the order of coincident crossings may differ on a neighbour
    is_clear = (by_key == by_key[0]).all(axis=(0, 2))
    return places[0], np.where(is_clear[:, None], keys[0], -1)
