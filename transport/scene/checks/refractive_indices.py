"""Checks that the dielectric boundaries of a scene agree on the refractive index between them.

A Dielectric states the index inside and outside. Overlapping bodies, a bubble whose outside is not the
surrounding glass, reversed normals or a forgotten gap of air contradict one another: light would leave one
boundary into index 1.5 and reach the next one from 1.0.

Intersections of spheres and boxes are decided exactly. The rest is probed along some hundred fixed straight
lines through the surfaces and from one to another: anything smaller than their spacing may be missed. Lines
that pass within 1e-9 of the scene's size of an edge, a rim or a tangent are not judged, nothing is known
behind an opaque surface, and the region between a boundary and the end of the scene is not checked.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from transport.geometry.line_crossings import (
    DEFAULT_LINES,
    EDGE_TOLERANCE,
    MAX_LINE_FACETS,
    crossings,
    lines_through,
    scene_size,
    with_neighbour_lines,
)
from transport.geometry.neighbours import touching_boxes
from transport.geometry.relations import is_within, solids_overlap
from transport.geometry.shape import Shape
from transport.scene.materials import Dielectric
from transport.scene.parts import surface_name
from transport.validation import SceneError
from transport.vectors import Vector

if TYPE_CHECKING:
    from transport.scene.parts import SceneParts

LINES_PER_POSITION = 32  # lines from a position
MAX_LINE_BOUNDARIES = 200_000  # most lines times boundaries: a quarter of a second


class Boundary(NamedTuple):
    """Surface between two media; opaque (the medium behind it is unknown) if `glass` is None."""

    title: str
    shape: Shape
    glass: Dielectric | None

    def indices(self, direction: float) -> tuple[float, float]:
        """Indices before and behind it for a line along its normal (+1) or against it (-1); nan if opaque."""
        if self.glass is None:
            return math.nan, math.nan
        pair = self.glass.index_inside, self.glass.index_outside
        return pair if direction > 0 else pair[::-1]


def check_media(scene: SceneParts) -> None:
    """Raise SceneError for boundaries that contradict one another, within the limits stated above."""
    boundaries = _boundaries(scene)
    glass = [b for b in boundaries if b.glass is not None]
    if len(glass) < 2 and not any(b.shape.triangles for b in glass):
        return
    for one, other in _pairs(glass):
        if one.indices(1) + other.indices(1) != (one.glass.index_inside,) * 4 and _intersect(
            one.shape, other.shape
        ):
            cure = "move them apart, put one wholly into the other, or make one Mesh of both"
            raise SceneError(f"Scene: {one.title} and {other.title} are overlapping media; {cure}")
    _check_lines(boundaries, glass)


def index_around(scene: SceneParts, position: Vector) -> float:
    """Refractive index at a position, by the majority of lines from there; nan if they do not agree."""
    boundaries = _boundaries(scene)
    glass = [b for b in boundaries if b.glass is not None]
    size = _boundaries_size(boundaries)
    # Send lines towards points in the boxes of boundaries, and in all directions.
    places, directions = lines_through([b.shape for b in glass], LINES_PER_POSITION, size)
    directions = np.concatenate([places - np.array(position), directions])
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    met, places = _boundary_crossings(
        boundaries, np.tile(position, (len(directions), 1)), directions, EDGE_TOLERANCE * size
    )
    # Take the index before the first boundary ahead, and let the lines vote.
    ahead = np.argmax((met >= 0) & (places > 0), axis=1)
    first = np.where(
        np.take_along_axis(places, ahead[:, None], axis=1)[:, 0] > 0, met[range(len(met)), ahead], -1
    )
    before = np.array(
        [b.indices(direction)[0] for b in boundaries for direction in (-1.0, 1.0)] + [math.nan]
    )[first]
    found, counts = np.unique(before[~np.isnan(before)], return_counts=True)
    return float(found[counts.argmax()]) if 4 * counts.max(initial=0) > 3 * counts.sum() else math.nan


def _boundaries(scene: SceneParts) -> list[Boundary]:
    """The surfaces of a scene that change the index, or transmit no light."""
    return [
        Boundary(surface_name(scene, number), surface.shape, surface.material.boundary)
        for number, surface in enumerate(scene.surfaces)
        if surface.material.boundary is not None or not surface.material.is_transmissive
    ]


# ---- spheres and boxes ----


def _pairs(glass: list[Boundary]) -> Iterator[tuple[Boundary, Boundary]]:
    """Pairs whose bounding boxes touch."""
    low, high = np.array([b.shape.bounds for b in glass]).transpose(1, 0, 2)
    for k, near in enumerate(touching_boxes(low, high)):
        yield from ((glass[k], glass[other]) for other in near[near > k].tolist())


def _intersect(a: Shape, b: Shape) -> bool:
    """Return whether the surfaces of two spheres, two boxes or one of each intersect, beyond rounding."""
    if not all(shape.is_convex and not shape.is_infinite for shape in (a, b)):
        return False
    return solids_overlap(a, b) and not is_within(a, b) and not is_within(b, a)


# ---- lines through all other shapes ----


def _check_lines(boundaries: list[Boundary], glass: list[Boundary]) -> None:
    """Refuse boundaries between which a line finds two different indices."""
    size, facets = _boundaries_size(boundaries), sum(b.shape.triangles for b in boundaries)
    count = max(
        4,
        min(
            max(DEFAULT_LINES, len(glass)),
            MAX_LINE_BOUNDARIES // len(boundaries),
            MAX_LINE_FACETS // max(facets, 1),
        ),
    )
    origins, directions = lines_through([b.shape for b in glass], count, size)
    met, places = _boundary_crossings(boundaries, origins, directions, EDGE_TOLERANCE * size)
    before, behind = np.array(
        [b.indices(direction) for b in boundaries for direction in (-1.0, 1.0)] + [(math.nan,) * 2]
    ).T
    # Compare the index behind each boundary with that before the next one.
    wrong = behind[met[:, :-1]] != before[met[:, 1:]]
    wrong &= ~np.isnan(behind[met[:, :-1]]) & ~np.isnan(before[met[:, 1:]])
    if wrong.any():
        line, k = np.argwhere(wrong)[0]
        one, other = (boundaries[number // 2] for number in met[line, k : k + 2])
        leaves, comes = float(behind[met[line, k]]), float(before[met[line, k + 1]])
        _raise_contradiction(
            one, other, leaves, comes, origins[line] + places[line, k + 1] * directions[line]
        )


def _raise_contradiction(
    one: Boundary, other: Boundary, leaves: float, comes: float, place: np.ndarray
) -> None:
    """Raise the SceneError for contradicting indices."""
    where = ", ".join(f"{x:.6g}" for x in place)
    found = f"light leaves {one.title} into index {leaves} and reaches {other.title} from index {comes}"
    cure = "give both the same index there, reverse normals that point the wrong way, or close the gap"
    raise SceneError(f"Scene: contradicting media: {found}, at ({where}); {cure}")


def _boundaries_size(boundaries: list[Boundary]) -> float:
    """Length scale [m] of the boundaries."""
    return scene_size([b.shape for b in boundaries])


def _boundary_crossings(boundaries, origins, directions, close: float) -> tuple[np.ndarray, np.ndarray]:
    """Boundaries that each line crosses in order, and places [m].

    A boundary is 2 * index + (1: along its normal), -1 for none.

    A line has no crossings if its three neighbours at a distance `close` cross others, or if two crossings
    are within `close`.
    """
    starts, tiled = with_neighbour_lines(origins, directions, close)
    found = [crossings(b.shape, starts, tiled) for b in boundaries]
    places = np.concatenate([f.distances for f in found], axis=1)
    met = np.concatenate([np.where(f.sides > 0, 2 * n + 1, 2 * n) for n, f in enumerate(found)], axis=1)
    met = np.where(np.isnan(places), -1, met)
    order = np.argsort(places, axis=1, kind="stable")
    places, met = (np.take_along_axis(a, order, axis=1).reshape(4, len(origins), -1) for a in (places, met))
    is_clear = (met == met[0]).all(axis=(0, 2)) & ~(np.diff(places[0], axis=1) <= close).any(axis=1)
    return np.where(is_clear[:, None], met[0], -1), places[0]
