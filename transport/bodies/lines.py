"""Fixed set of straight lines through shapes, along which the media of a scene are checked."""

from __future__ import annotations

import math

import numpy as np

from transport.bodies.solids import magnitude
from transport.shapes import Shape, Slab
from transport.shapes.base import ROUNDING
from transport.shapes.crossings import crossings
from transport.vectors import Vector

LINES = 256  # default number of lines
FACETS = 1_000_000  # most lines times triangles of meshes
CLOSE = 1e-9  # relative to the scene's size: lines this close to an edge or a tangent are ignored
FLUSH = 1e-11  # relative to the scene's size: surfaces this close count as coincident
STEPS = 2.0 ** -(np.arange(1, 6) / 6)  # increments of an evenly distributed sequence in five dimensions


def size_of(shapes: list[Shape]) -> float:
    """Length scale [m] of a scene: diagonal of the box around finite shapes and middles of infinite ones."""
    corners = np.array([c for shape in shapes for c in (*shape.bounds, *_middles(shape))])
    corners = corners[np.isfinite(corners).all(axis=1)]
    return float(np.linalg.norm(np.ptp(corners, axis=0))) or 1.0


def _middles(shape: Shape) -> list[Vector]:
    """Points [m] for the size of the scene: the middle of a shape, both faces of a slab."""
    return [plane.center for plane in shape.planes()] if isinstance(shape, Slab) else [shape.middle]


def lines_through(shapes: list[Shape], count: int, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Lines through points in each shape's bounding box; every second one aims at a point in another box."""
    # Draw points in the boxes and isotropic directions from an evenly distributed sequence.
    boxes = np.array([_box(shape, size) for shape in shapes])
    number = np.arange(count)
    owner = number * len(shapes) // count
    u = np.modf((number[:, None] + 1) * STEPS)[0]
    origins = _within(boxes[owner], u[:, :3])
    rise, turn = 2 * u[:, 3] - 1, 2 * math.pi * u[:, 4]
    across = np.sqrt((1 - rise) * (1 + rise))
    directions = np.stack([across * np.cos(turn), across * np.sin(turn), rise], axis=1)
    # Aim every second line at a point in another shape's box.
    target = (owner + 1 + number // 2 % max(len(shapes) - 1, 1)) % len(shapes)
    ways = _within(boxes[target], u[:, 2:]) - origins
    lengths = np.linalg.norm(ways, axis=1)
    is_aimed = (number % 2 == 1) & (lengths > 0)
    directions[is_aimed] = ways[is_aimed] / lengths[is_aimed, None]
    return origins, directions


def _within(boxes: np.ndarray, u: np.ndarray) -> np.ndarray:
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


def along_lines(origins: np.ndarray, directions: np.ndarray, close: float) -> tuple[np.ndarray, np.ndarray]:
    """Origins and directions (4 n, 3) of n lines, then of three neighbours of each, `close` [m] away."""
    e_u = np.cross(directions, np.eye(3)[np.argmin(np.abs(directions), axis=1)])
    e_u /= np.linalg.norm(e_u, axis=1)[:, None]
    e_v = np.cross(directions, e_u)
    turns = [2 * math.pi * k / 3 for k in range(3)]
    shifts = [0 * e_u, *(close * (math.cos(turn) * e_u + math.sin(turn) * e_v) for turn in turns)]
    return np.concatenate([origins + shift for shift in shifts]), np.tile(directions, (4, 1))


def crossed_in_turn(shapes: list[Shape], origins, ways, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Crossings of each line in order: places [m] and keys; -1 for lines that pass close to an edge.

    A key is 2 shapes group + 2 shape + (1: along its normal); coincident crossings have the same group.
    """
    # Cross all shapes with each line and its three neighbours, and sort the crossings.
    neighbours = along_lines(origins, ways, CLOSE * size)
    found = [crossings(shape, *neighbours) for shape in shapes]
    places = np.concatenate([f.distances for f in found], axis=1)
    codes = np.concatenate([np.where(f.sides > 0, 2 * n + 1, 2 * n) for n, f in enumerate(found)], axis=1)
    order = np.argsort(places, axis=1, kind="stable")  # nan comes last
    places, codes = (np.take_along_axis(array, order, axis=1) for array in (places, codes))
    # Number groups of coincident crossings.
    flush = FLUSH * size + 256 * ROUNDING * max(map(magnitude, shapes))
    group = np.cumsum(np.diff(places, axis=1, prepend=places[:, :1]) > flush, axis=1)
    keys = np.where(np.isnan(places), -1, 2 * len(shapes) * group + codes).astype(np.int64)
    places, keys = (array.reshape(4, len(origins), -1) for array in (places, keys))
    # Keep only lines whose neighbours cross the same surfaces.
    by_key = np.sort(keys, axis=2)  # the order of coincident crossings may differ on a neighbour
    is_clear = (by_key == by_key[0]).all(axis=(0, 2))
    return places[0], np.where(is_clear[:, None], keys[0], -1)
