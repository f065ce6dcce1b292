"""Whether the boundaries of media in a scene agree on which medium is where.

A Dielectric says which index of refraction is inside and which outside.  Two that overlap, a bubble whose
outside is not the glass that it is in, normals that point the wrong way or a forgotten gap of air contradict
one another: light would leave one boundary into 1.5 and come to the next one from 1.0.

Balls and boxes that cut one another are told exactly.  The rest is looked for along some hundred straight
lines, always the same ones, through the surfaces and from one to another: what is smaller than their spacing
may be missed; rays that pass within 1e-9 of the scene's size of an edge, a rim or a tangent are not judged;
an opaque surface ends what is known; what lies between a boundary and the end of the scene is not asked
after.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from transport.materials import Dielectric, Surface, lets_through, simple_parts
from transport.shapes import Box, Mesh, Shape, Slab, Sphere
from transport.shapes.crossings import crossings
from transport.shapes.supports import rounding_of
from transport.validation import SceneError
from transport.vectors import Vector

if TYPE_CHECKING:
    from transport.scene import Scene

LINES = 256
ROUND = 32  # lines about a position
WORK = 200_000  # lines times boundaries, a quarter of a second
FACETS = 1_000_000  # lines times triangles of meshes
CLOSE = 1e-9  # of the size of the scene
STEPS = 2.0 ** -(np.arange(1, 6) / 6)  # of places that fill a cube of five dimensions evenly


class Boundary(NamedTuple):
    """A surface between two media, or one that ends what is known of the medium, where `glass` is None."""

    title: str
    shape: Shape
    glass: Dielectric | None

    def indices(self, way: float) -> tuple[float, float]:
        """The indices before and behind it on a way along its normal (+1) or against it; nan where it is opaque."""
        if self.glass is None:
            return math.nan, math.nan
        pair = self.glass.index_inside, self.glass.index_outside
        return pair if way > 0 else pair[::-1]


def check_media(scene: Scene) -> None:
    """Refuse boundaries of media that contradict one another.  Raises SceneError; its limits are said above."""
    boundaries = [b for k, surface in enumerate(scene.surfaces) if (b := _boundary(surface, k)) is not None]
    glass = [b for b in boundaries if b.glass is not None]
    if len(glass) < 2 and not any(isinstance(b.shape, Mesh) for b in glass):
        return
    for one, other in _pairs(glass):
        if one.indices(1) + other.indices(1) != (one.glass.index_inside,) * 4 and _cut(
            one.shape, other.shape
        ):
            cure = "move them apart, put one wholly into the other, or make one Mesh of both"
            raise SceneError(f"Scene: {one.title} and {other.title} are overlapping media; {cure}")
    _check_lines(boundaries, glass)


def index_around(scene: Scene, position: Vector) -> float:
    """The refractive index at a position, by what most straight lines from there come to; nan where they do not tell."""
    boundaries = [b for k, surface in enumerate(scene.surfaces) if (b := _boundary(surface, k)) is not None]
    glass = [b for b in boundaries if b.glass is not None]
    size = _size(boundaries)
    places, ways = lines_through(
        [b.shape for b in glass], ROUND, size
    )  # towards places in the boxes about boundaries, and any way
    ways = np.concatenate([places - np.array(position), ways])
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    met, places = _met(boundaries, np.tile(position, (len(ways), 1)), ways, CLOSE * size)
    ahead = np.argmax((met >= 0) & (places > 0), axis=1)
    first = np.where(
        np.take_along_axis(places, ahead[:, None], axis=1)[:, 0] > 0, met[range(len(met)), ahead], -1
    )
    before = np.array([b.indices(way)[0] for b in boundaries for way in (-1.0, 1.0)] + [math.nan])[first]
    found, counts = np.unique(before[~np.isnan(before)], return_counts=True)
    return float(found[counts.argmax()]) if 4 * counts.max(initial=0) > 3 * counts.sum() else math.nan


def _boundary(surface: Surface, number: int) -> Boundary | None:
    """What a surface is to the medium of light; None where it lets light through and changes nothing."""
    glass = next((part for part in simple_parts(surface.material) if isinstance(part, Dielectric)), None)
    if glass is None and lets_through(surface.material):
        return None
    title = f"Surface {surface.name!r}" if surface.name else f"surfaces[{number}]"
    return Boundary(title, surface.shape, glass)


# ---- balls and boxes ----


def _pairs(glass: list[Boundary]) -> Iterator[tuple[Boundary, Boundary]]:
    """Pairs whose boxes meet."""
    low, high = np.array([b.shape.bounds for b in glass]).transpose(1, 0, 2)
    for k, one in enumerate(glass):
        for n in np.flatnonzero((low[k + 1 :] < high[k]).all(axis=1) & (high[k + 1 :] > low[k]).all(axis=1)):
            yield one, glass[k + 1 + n]


def _cut(a: Shape, b: Shape) -> bool:
    """Whether the surfaces of two balls, two boxes or one of each go through one another, beyond rounding."""
    if isinstance(a, Box) and isinstance(b, Sphere):
        return _cut(b, a)
    if not all(isinstance(shape, (Box, Sphere)) and shape.is_closed for shape in (a, b)):
        return False
    tolerance = rounding_of(a, b)
    if isinstance(b, Sphere):
        apart = math.dist(a.center, b.center)
        return abs(a.radius - b.radius) + tolerance < apart < a.radius + b.radius - tolerance
    if isinstance(a, Sphere):
        offsets = [(abs(p - q), size / 2) for p, q, size in zip(a.center, b.center, b.size, strict=True)]
        nearest = math.hypot(*(max(offset - half, 0.0) for offset, half in offsets))
        farthest = math.hypot(*(offset + half for offset, half in offsets))
        is_within = all(offset + a.radius <= half + tolerance for offset, half in offsets)
        return nearest < a.radius - tolerance and farthest > a.radius + tolerance and not is_within
    sides = list(zip(*a.bounds, *b.bounds, strict=True))
    meet = all(p < s - tolerance and r < q - tolerance for p, q, r, s in sides)
    holds = all(p <= r + tolerance and s <= q + tolerance for p, q, r, s in sides)
    is_held = all(r <= p + tolerance and q <= s + tolerance for p, q, r, s in sides)
    return meet and not holds and not is_held


# ---- lines through the rest ----


def _check_lines(boundaries: list[Boundary], glass: list[Boundary]) -> None:
    """Refuse what a line finds between one boundary and the next."""
    size, facets = _size(boundaries), sum(b.shape.triangles for b in boundaries if isinstance(b.shape, Mesh))
    count = max(4, min(max(LINES, len(glass)), WORK // len(boundaries), FACETS // max(facets, 1)))
    origins, directions = lines_through([b.shape for b in glass], count, size)
    met, places = _met(boundaries, origins, directions, CLOSE * size)
    before, behind = np.array(
        [b.indices(way) for b in boundaries for way in (-1.0, 1.0)] + [(math.nan,) * 2]
    ).T
    wrong = behind[met[:, :-1]] != before[met[:, 1:]]
    wrong &= ~np.isnan(behind[met[:, :-1]]) & ~np.isnan(before[met[:, 1:]])
    if wrong.any():
        line, k = np.argwhere(wrong)[0]
        one, other = (boundaries[number // 2] for number in met[line, k : k + 2])
        leaves, comes = float(behind[met[line, k]]), float(before[met[line, k + 1]])
        _refuse(one, other, leaves, comes, origins[line] + places[line, k + 1] * directions[line])


def _refuse(one: Boundary, other: Boundary, leaves: float, comes: float, place: np.ndarray) -> None:
    where = ", ".join(f"{x:.6g}" for x in place)
    found = f"light leaves {one.title} into index {leaves} and comes to {other.title} from index {comes}"
    cure = "give both the same index there, turn round normals that point the wrong way, or close the gap"
    raise SceneError(f"Scene: contradicting media: {found}, at ({where}); {cure}")


def _size(boundaries: list[Boundary]) -> float:
    return size_of([b.shape for b in boundaries])


def size_of(shapes: list[Shape]) -> float:
    """A length [m] of a scene: the diagonal about all that is finite, and about the middles of what is not."""
    corners = np.array([c for shape in shapes for c in (*shape.bounds, *_middles(shape))])
    corners = corners[np.isfinite(corners).all(axis=1)]
    return float(np.linalg.norm(np.ptp(corners, axis=0))) or 1.0


def _middles(shape: Shape) -> list[Vector]:
    return [plane.center for plane in shape.planes()] if isinstance(shape, Slab) else [shape.middle]


def lines_through(shapes: list[Shape], count: int, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Lines through places in the box about each shape: each other one towards a place in another's box."""
    boxes = np.array([_box(shape, size) for shape in shapes])
    number = np.arange(count)
    owner = number * len(shapes) // count
    u = np.modf((number[:, None] + 1) * STEPS)[0]
    origins = _within(boxes[owner], u[:, :3])
    rise, turn = 2 * u[:, 3] - 1, 2 * math.pi * u[:, 4]
    across = np.sqrt((1 - rise) * (1 + rise))
    directions = np.stack([across * np.cos(turn), across * np.sin(turn), rise], axis=1)
    target = (owner + 1 + number // 2 % max(len(shapes) - 1, 1)) % len(shapes)
    ways = _within(boxes[target], u[:, 2:]) - origins
    lengths = np.linalg.norm(ways, axis=1)
    is_aimed = (number % 2 == 1) & (lengths > 0)
    directions[is_aimed] = ways[is_aimed] / lengths[is_aimed, None]
    return origins, directions


def _within(boxes: np.ndarray, u: np.ndarray) -> np.ndarray:
    return boxes[:, 0] + u * (boxes[:, 1] - boxes[:, 0])


def _box(shape: Shape, size: float) -> np.ndarray:
    """Corners of the box about a shape; of an endless one as far as the scene reaches from its middle."""
    middle = np.array(shape.middle)
    return (
        np.clip(np.array(shape.bounds), middle - size, middle + size)
        if shape.is_infinite
        else np.array(shape.bounds)
    )


def _met(boundaries, origins, directions, close: float) -> tuple[np.ndarray, np.ndarray]:
    """What each line meets in turn, 2 * boundary + (1: along its normal), -1 where nothing, and where [m].

    A line whose three neighbours, `close` about it, do not meet the same, or that meets two within `close`,
    meets nothing.
    """
    starts, ways = along_lines(origins, directions, close)
    found = [crossings(b.shape, starts, ways) for b in boundaries]
    places = np.concatenate([f.distances for f in found], axis=1)
    met = np.concatenate([np.where(f.sides > 0, 2 * n + 1, 2 * n) for n, f in enumerate(found)], axis=1)
    met = np.where(np.isnan(places), -1, met)
    order = np.argsort(places, axis=1, kind="stable")
    places, met = (np.take_along_axis(a, order, axis=1).reshape(4, len(origins), -1) for a in (places, met))
    is_clear = (met == met[0]).all(axis=(0, 2)) & ~(np.diff(places[0], axis=1) <= close).any(axis=1)
    return np.where(is_clear[:, None], met[0], -1), places[0]


def along_lines(origins: np.ndarray, directions: np.ndarray, close: float) -> tuple[np.ndarray, np.ndarray]:
    """Origins and directions (4 n, 3) of n lines, and then of three neighbours of each, `close` [m] about it."""
    e_u = np.cross(directions, np.eye(3)[np.argmin(np.abs(directions), axis=1)])
    e_u /= np.linalg.norm(e_u, axis=1)[:, None]
    e_v = np.cross(directions, e_u)
    turns = [2 * math.pi * k / 3 for k in range(3)]
    shifts = [0 * e_u, *(close * (math.cos(turn) * e_u + math.sin(turn) * e_v) for turn in turns)]
    return np.concatenate([origins + shift for shift in shifts]), np.tile(directions, (4, 1))
