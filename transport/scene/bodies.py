"""Bodies: the regions of a scene that media fill, and which of them hold a point.

A closed shape with a medium inside is a body, and so is the half space on a side of a Plane that names a
medium. Open surfaces that name the same medium on a side, such as the two caps and the rim of a lens, bound
one body together if their boxes touch. Bodies may be nested, and the innermost counts; the scene's medium
fills the rest.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from transport.geometry.line_crossings import MAX_LINE_FACETS, crossings, lines_through
from transport.geometry.relations import HalfSpace, Solid, half_space, is_within, solids_overlap
from transport.geometry.shape import ROUNDING, Shape
from transport.geometry.solid import Box, Sphere
from transport.scene.materials import AnyMedium, Surface
from transport.scene.media import Grid, Vacuum, canonical_medium
from transport.validation import SceneError
from transport.vectors import Vector

if TYPE_CHECKING:
    from transport.scene.parts import SceneParts


# ---- Regions of bodies: which points a body holds, and whether it lies in another or overlaps it.
#
# Spheres, boxes, slabs and half spaces are decided by inequalities, closed meshes by their winding number,
# bodies of open surfaces by the majority of a few straight lines.

# directions of the lines that decide what is inside; none along an axis or a diagonal
TEST_DIRECTIONS = np.array(
    [(0.36, 0.48, 0.8), (-0.64, 0.6, 0.48), (0.28, -0.576, 0.768), (-0.352, -0.36, 0.864),
     (0.768, 0.28, -0.576), (-0.48, 0.8, -0.36), (0.6, -0.48, -0.64)]
)  # fmt: skip
TEST_POINTS = 64  # test points below each face
TEST_DEPTH = 1e-9  # depth of test points, relative to a body's extent


@dataclass(frozen=True)
class Body:
    """Region filled by a medium: indices of the surfaces that bound it, and on which side of each it lies."""

    medium: AnyMedium
    surfaces: tuple[int, ...]
    faces: tuple[tuple[int, bool], ...] = ()  # index of the surface, and whether the body is in front of it


def body_solid(scene: SceneParts, body: Body) -> Solid | None:
    """The body as a solid that inequalities describe; None if it is not one."""
    shape = scene.surfaces[body.surfaces[0]].shape
    if shape.is_plane:
        return half_space(shape, body.faces[0][1])
    return shape if shape.is_convex else None


def points_in_body(scene: SceneParts, body: Body, points: np.ndarray) -> np.ndarray:
    """Mask of the points (n, 3) [m] that lie in a body."""
    shape = scene.surfaces[body.surfaces[0]].shape
    if bounds_alone(shape):
        return (body_solid(scene, body) or shape).contains(points)
    low, high = body_bounds(scene, body)
    near = ((points >= low) & (points <= high)).all(axis=1)
    held = np.zeros(len(points), bool)
    if near.any():
        held[near] = _majority_inside(scene, body, points[near])
    return held


def _majority_inside(scene: SceneParts, body: Body, points: np.ndarray) -> np.ndarray:
    """Return whether most lines from each point reach the body's surface from inside."""
    votes = np.zeros(len(points), int)
    for direction in TEST_DIRECTIONS / np.linalg.norm(TEST_DIRECTIONS, axis=1)[:, None]:
        nearest, is_in = np.full(len(points), np.inf), np.zeros(len(points), bool)
        for number in body.surfaces:
            found = crossings(scene.surfaces[number].shape, points, np.tile(direction, (len(points), 1)))
            if not found.distances.shape[1]:
                continue
            ahead = np.where(found.distances > 0, found.distances, np.inf)
            first = np.argmin(ahead, axis=1)[:, None]
            distance, side = (np.take_along_axis(a, first, axis=1)[:, 0] for a in (ahead, found.sides))
            faces = set(body.faces)
            inside = np.where(side < 0, (number, True) in faces, (number, False) in faces)
            is_in = np.where(distance < nearest, inside, is_in)
            nearest = np.minimum(nearest, distance)
        votes += np.where(is_in, 1, -1)
    return votes > 0


def points_below_surface(scene: SceneParts, body: Body) -> np.ndarray:
    """Points (n, 3) [m] just below the surface of a finite body."""
    faces = [(scene.surfaces[number].shape, is_front) for number, is_front in body.faces]
    return np.concatenate([points_beside(shape, is_front) for shape, is_front in faces])


@lru_cache(maxsize=512)
def points_beside(shape: Shape, is_front: bool) -> np.ndarray:
    """Points (n, 3) [m] close to one side of a surface.

    For a mesh they lie beside facets, else where lines through the shape's bounding box cross it.
    """
    depth = TEST_DEPTH * shape.extent
    if shape.triangles:
        most = max(8, min(TEST_POINTS, MAX_LINE_FACETS // shape.triangles))
        facets = np.unique(np.linspace(0, shape.triangles - 1, most).astype(int))
        direction = shape.normals[facets] if is_front else -shape.normals[facets]
        return shape.vertices[shape.faces[facets]].mean(axis=1) + depth * direction
    origins, directions = lines_through([shape], TEST_POINTS, shape.extent)
    found = crossings(shape, origins, directions)
    is_met = ~np.isnan(found.distances)
    line, _ = np.nonzero(is_met)
    into = found.sides[is_met] if is_front else -found.sides[is_met]
    return origins[line] + (found.distances[is_met] + depth * into)[:, None] * directions[line]


def body_bounds(scene: SceneParts, body: Body) -> np.ndarray:
    """Lower and upper corner (2, 3) [m] of a body's bounding box."""
    if isinstance(body_solid(scene, body), HalfSpace):
        return np.array([[-math.inf] * 3, [math.inf] * 3])
    bounds = np.array([scene.surfaces[number].shape.bounds for number in body.surfaces])
    return np.array([bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)])


def enclosing_bodies(scene: SceneParts, bodies: list[Body]) -> list[set[int]]:
    """For each body the indices of all bodies in which it lies.

    Larger bodies come first, so that the holders of a holder need no test.
    """
    if not bodies:
        return []
    low, high = np.array([body_bounds(scene, body) for body in bodies]).transpose(1, 0, 2)
    # Select candidates by their boxes, with slack for rounding.
    span = high - low
    slack = 4 * TEST_DEPTH * np.where(np.isfinite(span), span, 0).max(axis=1)
    slack = (slack[:, None] + slack + 4 * ROUNDING * (_max_finite(low) + _max_finite(high)))[:, :, None]
    may_hold = ((low[:, None] >= low - slack) & (high[:, None] <= high + slack)).all(axis=2)  # (body, holder)
    # Test them from the smallest to the largest, and inherit the holders of each holder.
    breadth = span.sum(axis=1)
    holders: list[set[int]] = [set() for _ in bodies]
    for k in np.argsort(-breadth, kind="stable").tolist():
        for j in sorted(np.flatnonzero(may_hold[k]).tolist(), key=breadth.__getitem__):
            if j != k and j not in holders[k] and is_body_within(scene, bodies[k], bodies[j]):
                holders[k] |= {j} | holders[j] - {k}
    return holders


def _max_finite(corners: np.ndarray) -> float:
    """Largest finite coordinate."""
    return float(np.abs(corners[np.isfinite(corners)]).max(initial=0.0))


def is_body_within(scene: SceneParts, one: Body, other: Body) -> bool:
    """Return whether one body lies wholly in another: exact for solids, else by points below its surface."""
    a, b = body_solid(scene, one), body_solid(scene, other)
    if a is not None and b is not None:
        return is_within(a, b)
    if _is_infinite_body(scene, one):
        return False
    points = points_below_surface(scene, one)
    return bool(points_in_body(scene, other, points).all()) and len(points) > 0


def bodies_overlap(scene: SceneParts, one: Body, other: Body) -> bool:
    """Return whether two bodies overlap: exact for solids, else by points below their surfaces."""
    a, b = body_solid(scene, one), body_solid(scene, other)
    if a is not None and b is not None:
        return solids_overlap(a, b)
    pairs = [(p, q) for p, q in ((one, other), (other, one)) if not _is_infinite_body(scene, p)]
    return any(points_in_body(scene, q, points_below_surface(scene, p)).any() for p, q in pairs)


def _is_infinite_body(scene: SceneParts, body: Body) -> bool:
    """Return whether a body is infinite."""
    return scene.surfaces[body.surfaces[0]].shape.is_infinite


# ---- All bodies of a scene.

MAX_BODIES = 62  # bits of a 64-bit integer
SIDE_OFFSET = 16 * ROUNDING  # relative to coordinates: a point this far from a surface is surely on one side


def surrounding_medium(scene: SceneParts) -> AnyMedium:
    """Medium outside all bodies."""
    return Vacuum() if scene.medium is None else canonical_medium(scene.medium)


def scene_media(scene: SceneParts) -> tuple[AnyMedium, ...]:
    """All media of a scene, each once, the surrounding one first."""
    return tuple(dict.fromkeys([surrounding_medium(scene), *(body.medium for body in scene_bodies(scene))]))


def has_media(scene: SceneParts) -> bool:
    """Return whether any medium of the scene is not vacuum."""
    return any(medium != Vacuum() for medium in scene_media(scene))


def scene_bodies(scene: SceneParts) -> tuple[Body, ...]:
    """Bodies of a scene, inner ones before those that hold them. Raises SceneError for more than 62."""
    return nested_bodies(scene)[0]


@lru_cache(maxsize=8)
def nested_bodies(scene: SceneParts) -> tuple[tuple[Body, ...], tuple[frozenset[int], ...]]:
    """Bodies of a scene, and for each the indices of the bodies in which it lies."""
    bodies = [*_solid_bodies(scene), *_compound_bodies(scene)]
    if len(bodies) > MAX_BODIES:
        must = f"surfaces must bound at most {MAX_BODIES} bodies of media, got {len(bodies)}"
        layers = f"write layers as a Grid(box=..., absorption=...) of (1, 1, {len(bodies)}) in a wide Box"
        raise SceneError(f"Scene: {must}; {layers}, and many small bodies as a Grid with more voxels")
    holders = enclosing_bodies(scene, bodies)
    order = sorted(range(len(bodies)), key=lambda k: -len(holders[k]))
    number = {k: n for n, k in enumerate(order)}
    return tuple(bodies[k] for k in order), tuple(frozenset(number[j] for j in holders[k]) for k in order)


def bodies_on_sides(scene: SceneParts) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    """For each surface the indices of the bodies that it bounds on its front and on its back."""
    sides = [((), ()) for _ in scene.surfaces]
    for number, body in enumerate(scene_bodies(scene)):
        for surface, is_front in body.faces:
            front, back = sides[surface]
            sides[surface] = ((*front, number), back) if is_front else (front, (*back, number))
    return sides


def body_bits_at(
    scene: SceneParts, positions: np.ndarray, directions: np.ndarray | None = None
) -> np.ndarray:
    """Bodies that hold positions (n, 3) [m]: bit k of a 64-bit integer for body k.

    With `directions` (n, 3) the point just ahead counts: a position on a surface belongs to the side that the
    direction leads to.
    """
    points = np.atleast_2d(np.asarray(positions, float))
    if directions is not None:
        size = np.abs(points).sum(axis=1) + max(
            (surface.shape.coordinate_scale for surface in scene.surfaces), default=0.0
        )
        points = points + SIDE_OFFSET * size[:, None] * np.atleast_2d(directions)
    return bits_of_bodies_at(scene, points, range(len(scene_bodies(scene))))


def bits_of_bodies_at(scene: SceneParts, points: np.ndarray, numbers: Iterable[int]) -> np.ndarray:
    """Bodies with these indices that hold points (n, 3) [m], as bits."""
    bits, bodies = np.zeros(len(points), np.int64), scene_bodies(scene)
    for number in numbers:
        bits |= points_in_body(scene, bodies[number], points).astype(np.int64) << number
    return bits


def medium_at(scene: SceneParts, position: Vector) -> AnyMedium:
    """Medium at a position [m]: of the innermost body that holds it, else the surrounding medium."""
    return media_at(scene, np.array([position], float))[0]


def media_at(scene: SceneParts, positions: np.ndarray) -> list[AnyMedium]:
    """Medium at each of the positions (n, 3) [m]."""
    media = scene_media(scene)
    return [media[number] for number in media_numbers(scene, positions)]


def media_numbers(scene: SceneParts, positions: np.ndarray) -> np.ndarray:
    """Number in `scene_media` of the medium at each of the positions (n, 3) [m]."""
    bodies, media, bits = scene_bodies(scene), scene_media(scene), body_bits_at(scene, positions)
    numbers = np.zeros(len(bits), np.int64)
    for number in reversed(range(len(bodies))):  # inner bodies come first
        numbers[bits >> number & 1 != 0] = media.index(bodies[number].medium)
    return numbers


# ---- construction of bodies ----


def _solid_bodies(scene: SceneParts) -> Iterator[Body]:
    """One body for each closed shape with a medium inside, and for each side of a Plane with one."""
    for number, surface in enumerate(scene.surfaces):
        if bounds_alone(surface.shape) and surface.back is not None:
            yield Body(canonical_medium(surface.back), (number,), ((number, False),))
        is_plane = surface.shape.is_plane and surface.front is not None
        if (
            is_plane
            and canonical_medium(surface.front) != surrounding_medium(scene)
            and not is_layer(scene, surface)
        ):
            yield Body(canonical_medium(surface.front), (number,), ((number, True),))


def is_layer(scene: SceneParts, lower: Surface) -> bool:
    """Return whether a Plane and the next parallel plane before it name the same medium between them."""
    normal, heights = np.array(lower.shape.normal), []
    level = float(normal @ lower.shape.center)
    for upper in scene.surfaces:
        if upper.shape.is_plane and normal @ upper.shape.normal >= 1 - 4 * ROUNDING:
            height = float(normal @ upper.shape.center) - level
            if height > 0:
                heights.append((height, upper.back))
    _, medium = min(heights, key=lambda found: found[0], default=(0.0, None))
    return medium is not None and canonical_medium(medium) == canonical_medium(lower.front)


def bounds_alone(shape: Shape) -> bool:
    """Return whether a surface bounds a body by itself."""
    return shape.is_closed or shape.is_infinite


def _compound_bodies(scene: SceneParts) -> list[Body]:
    """Bodies that open surfaces bound together; of the surrounding medium only those inside another body.

    A side that names the medium of a closed body around it, such as that of a rod in a tank, bounds no body
    of its own.
    """
    # Collect the faces of each medium, without those inside a body of the same medium.
    solids = list(_solid_bodies(scene))
    faces: dict[AnyMedium, list[tuple[int, bool]]] = {}
    for number, surface in enumerate(scene.surfaces):
        if not bounds_alone(surface.shape):
            for medium, is_front in ((surface.front, True), (surface.back, False)):
                about = [
                    body for body in solids if medium is not None and body.medium == canonical_medium(medium)
                ]
                if medium is not None and not (about and _is_inside_bodies(scene, (number, is_front), about)):
                    faces.setdefault(canonical_medium(medium), []).append((number, is_front))
    # Split them into connected bodies; keep the surrounding medium only inside other bodies.
    around = faces.pop(surrounding_medium(scene), [])
    bodies = [
        _make_body(medium, part) for medium, every in faces.items() for part in _connected_faces(scene, every)
    ]
    if not around:
        return bodies
    others = [*solids, *bodies]
    inner = [face for face in around if _is_inside_bodies(scene, face, others)]
    return bodies + [_make_body(surrounding_medium(scene), part) for part in _connected_faces(scene, inner)]


def _make_body(medium: AnyMedium, faces: list[tuple[int, bool]]) -> Body:
    """Body of a medium with these faces."""
    return Body(medium, tuple(dict.fromkeys(number for number, _ in faces)), tuple(faces))


def _connected_faces(scene: SceneParts, faces: list[tuple[int, bool]]) -> list[list[tuple[int, bool]]]:
    """Groups of faces whose boxes touch, directly or through others."""
    parts: list[list[tuple[int, bool]]] = []
    for face in faces:
        joined = [part for part in parts if any(_boxes_touch(scene, face, other) for other in part)]
        parts = [part for part in parts if part not in joined]
        parts.append([*chain.from_iterable(joined), face])
    return [sorted(part) for part in parts]


def _boxes_touch(scene: SceneParts, one: tuple[int, bool], other: tuple[int, bool]) -> bool:
    """Return whether the bounding boxes of two faces touch."""
    a, b = scene.surfaces[one[0]].shape, scene.surfaces[other[0]].shape
    gap = TEST_DEPTH * (a.extent + b.extent)
    return all(p <= s + gap and r <= q + gap for p, q, r, s in zip(*a.bounds, *b.bounds, strict=True))


def _is_inside_bodies(scene: SceneParts, face: tuple[int, bool], bodies: list[Body]) -> bool:
    """Return whether all points just beside a face are in one of the bodies."""
    points = points_below_surface(scene, _make_body(Vacuum(), [face]))
    held = np.zeros(len(points), bool)
    for body in bodies:
        held |= points_in_body(scene, body, points)
    return bool(held.all()) and len(points) > 0


# ---- Absorption in a volume: whether the media that it may hold absorb there.


def may_absorb(scene: SceneParts, volume: Box | Sphere, hollow: Sphere | None = None) -> bool:
    """Return whether any medium that a volume may hold absorbs; media that only touch it do not count.

    hollow: sphere in the volume that is not part of it.
    """
    return any(_absorbs_within(medium, volume) for medium in _media_within(scene, volume, hollow))


def max_absorption(scene: SceneParts, volume: Box | Sphere) -> float:
    """Largest absorption coefficient [1/m] that a volume may hold."""
    return max(float(np.max(medium.absorption)) for medium in _media_within(scene, volume))


def _media_within(scene: SceneParts, volume: Box | Sphere, hollow: Sphere | None = None) -> list[AnyMedium]:
    """Media that may fill part of a volume, the innermost first.

    The search ends at the first body that holds the whole volume.
    """
    found = []
    for body in scene_bodies(scene):
        solid = body_solid(scene, body)
        if solid is None:
            if _boxes_meet(volume, body_bounds(scene, body)):
                found.append(body.medium)
        elif is_within(volume, solid):
            return [*found, body.medium]
        elif solids_overlap(volume, solid) and not (hollow is not None and is_within(solid, hollow)):
            found.append(body.medium)
    return [*found, surrounding_medium(scene)]


def _boxes_meet(volume: Box | Sphere, corners: np.ndarray) -> bool:
    """Return whether the volume's bounding box and a box (2, 3) overlap."""
    (low, high), (least, most) = volume.bounds, corners
    return bool(((np.array(low) < most) & (least < np.array(high))).all())


def _absorbs_within(medium: AnyMedium, volume: Box | Sphere) -> bool:
    """Return whether a medium absorbs in a volume; of a Grid the voxels that reach into it count."""
    if not isinstance(medium, Grid):
        return medium.absorption > 0
    return bool(medium.absorption[_voxels_in(medium, volume)].any())


def _voxels_in(grid: Grid, volume: Box | Sphere) -> tuple[slice, ...]:
    """Slices of the voxels of a grid that may reach into a volume."""
    found = []
    sides = zip(*grid.box.bounds, *volume.bounds, grid.absorption.shape, strict=True)
    for start, end, low, high, count in sides:
        width = (end - start) / count
        slack = ROUNDING * (abs(start) + abs(end) + abs(low) + abs(high))
        first, last = np.clip([(low + slack - start) / width, (high - slack - start) / width], 0, count)
        found.append(slice(int(np.floor(first)), int(np.ceil(last))))
    return tuple(found)
