"""Bodies: the regions of a scene that a medium fills, and which of them hold a place.

A closed shape with a medium inside is a body, and so is the half space on a side of a Plane that names one; open surfaces
that name the same medium on a side bound a body together, as the two caps and the rim of a lens, where the boxes
about them meet.  Bodies may be nested, and the innermost counts; what no body claims, the scene's medium fills.

Balls, boxes, slabs and half spaces are told by inequalities, closed meshes by their winding number, bodies of open surfaces by
what most of a few straight lines come to.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from transport.media import Grid, Medium, Vacuum
from transport.media.medium import plain
from transport.shapes import Box, Mesh, Plane, Shape, Slab, Sphere
from transport.shapes.base import ROUNDING
from transport.shapes.crossings import crossings
from transport.shapes.mesh_geometry import winding_number
from transport.solids import Solid, do_meet, half_space, holds, is_within, magnitude
from transport.validation import SceneError
from transport.vectors import Vector

if TYPE_CHECKING:
    from transport.scene import Scene

MOST_BODIES = 62  # bits of an integer
AnyMedium = Medium | Grid | Vacuum
WAYS = np.array(  # of lines that tell what is inside; none along an axis or a diagonal
    [(0.36, 0.48, 0.8), (-0.64, 0.6, 0.48), (0.28, -0.576, 0.768), (-0.352, -0.36, 0.864), (0.768, 0.28, -0.576),
     (-0.48, 0.8, -0.36), (0.6, -0.48, -0.64)]
)  # fmt: skip
ASIDE = 16 * ROUNDING  # of the size of numbers: how far from a surface a place is surely on one side of it
SKIN = 1e-9  # of a body's extent: how deep under its surface it is looked at


@dataclass(frozen=True)
class Body:
    """A region and what fills it: the numbers of the surfaces that bound it, and on which side of each it is."""

    medium: AnyMedium
    surfaces: tuple[int, ...]
    faces: tuple[tuple[int, bool], ...] = ()  # surface, and whether the body is in front of it


def surrounding_of(scene: Scene) -> AnyMedium:
    """What fills all that no body claims."""
    return Vacuum() if scene.medium is None else plain(scene.medium)


def media_of(scene: Scene) -> tuple[AnyMedium, ...]:
    """All media of a scene, each once, the surrounding one first."""
    return tuple(dict.fromkeys([surrounding_of(scene), *(body.medium for body in bodies_of(scene))]))


def has_media(scene: Scene) -> bool:
    """Whether anything in a scene fills space that absorbs, scatters, glows or has an index of its own."""
    return any(medium != Vacuum() for medium in media_of(scene))


@lru_cache(maxsize=32)
def bodies_of(scene: Scene) -> tuple[Body, ...]:
    """The bodies of a scene, each before those that hold it.  Raises SceneError for more than 62."""
    bodies = [*_solid_bodies(scene), *_compound_bodies(scene)]
    if len(bodies) > MOST_BODIES:
        must = f"surfaces must bound at most {MOST_BODIES} bodies of media, got {len(bodies)}"
        raise SceneError(f"Scene: {must}; write many small ones as one Grid(box=..., scattering=...)")
    depth = [sum(is_in(scene, body, other) for other in bodies if other is not body) for body in bodies]
    order = sorted(range(len(bodies)), key=lambda k: -depth[k])
    return tuple(bodies[k] for k in order)


def sides_of(scene: Scene) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    """Of each surface the bodies, by their numbers, that lie in front of it, and behind it, because of it."""
    sides = [((), ()) for _ in scene.surfaces]
    for number, body in enumerate(bodies_of(scene)):
        for surface, is_front in body.faces:
            front, back = sides[surface]
            sides[surface] = ((*front, number), back) if is_front else (front, (*back, number))
    return sides


def body_bits_around(scene: Scene, positions: np.ndarray, directions: np.ndarray | None = None) -> np.ndarray:
    """Which bodies hold positions (n, 3) [m]: bit k is set for body k, in integers of 64 bits.

    With `directions` (n, 3) what holds the place just ahead: a position on a surface is on the side that it leads to.
    """
    points = np.atleast_2d(np.asarray(positions, float))
    if directions is not None:
        size = np.abs(points).sum(axis=1) + max(
            (magnitude(surface.shape) for surface in scene.surfaces), default=0.0
        )
        points = points + ASIDE * size[:, None] * np.atleast_2d(directions)
    bits = np.zeros(len(points), np.int64)
    for number, body in enumerate(bodies_of(scene)):
        bits |= held_by(scene, body, points).astype(np.int64) << number
    return bits


def medium_at(scene: Scene, position: Vector) -> AnyMedium:
    """What fills the place [m]: the innermost body that holds it, else the surrounding medium."""
    return media_at(scene, np.array([position], float))[0]


def media_at(scene: Scene, positions: np.ndarray) -> list[AnyMedium]:
    """What fills each of the positions (n, 3) [m]."""
    bodies, around = bodies_of(scene), surrounding_of(scene)
    return [
        bodies[(int(bits) & -int(bits)).bit_length() - 1].medium if bits else around
        for bits in body_bits_around(scene, positions)
    ]


# ---- which bodies there are ----


def _solid_bodies(scene: Scene) -> Iterator[Body]:
    """One for each closed shape with a medium inside, and for each side of a Plane with one."""
    for number, surface in enumerate(scene.surfaces):
        if is_whole(surface.shape) and surface.back is not None:
            yield Body(plain(surface.back), (number,), ((number, False),))
        is_plane = isinstance(surface.shape, Plane)
        if is_plane and surface.front is not None and plain(surface.front) != surrounding_of(scene):
            yield Body(plain(surface.front), (number,), ((number, True),))


def is_whole(shape: Shape) -> bool:
    """Whether a surface bounds a body by itself."""
    return shape.is_closed or isinstance(shape, Plane)


def _compound_bodies(scene: Scene) -> list[Body]:
    """Those that open surfaces bound together; none of the surrounding medium but where another body holds it."""
    faces: dict[AnyMedium, list[tuple[int, bool]]] = {}
    for number, surface in enumerate(scene.surfaces):
        if not is_whole(surface.shape):
            for medium, is_front in ((surface.front, True), (surface.back, False)):
                if medium is not None:
                    faces.setdefault(plain(medium), []).append((number, is_front))
    around = faces.pop(surrounding_of(scene), [])
    bodies = [_body(medium, part) for medium, every in faces.items() for part in _parts(scene, every)]
    if not around:
        return bodies
    others = [*_solid_bodies(scene), *bodies]
    inner = [face for face in around if _is_inside(scene, face, others)]
    return bodies + [_body(surrounding_of(scene), part) for part in _parts(scene, inner)]


def _body(medium: AnyMedium, faces: list[tuple[int, bool]]) -> Body:
    return Body(medium, tuple(dict.fromkeys(number for number, _ in faces)), tuple(faces))


def _parts(scene: Scene, faces: list[tuple[int, bool]]) -> list[list[tuple[int, bool]]]:
    """Faces that belong together: those whose boxes meet, or that are joined by others."""
    parts: list[list[tuple[int, bool]]] = []
    for face in faces:
        joined = [part for part in parts if any(_do_touch(scene, face, other) for other in part)]
        parts = [part for part in parts if part not in joined] + [[*sum(joined, []), face]]
    return [sorted(part) for part in parts]


def _do_touch(scene: Scene, one: tuple[int, bool], other: tuple[int, bool]) -> bool:
    a, b = scene.surfaces[one[0]].shape, scene.surfaces[other[0]].shape
    gap = SKIN * (a.extent + b.extent)
    return all(p <= s + gap and r <= q + gap for p, q, r, s in zip(*a.bounds, *b.bounds, strict=True))


def _is_inside(scene: Scene, face: tuple[int, bool], bodies: list[Body]) -> bool:
    """Whether all places just beside a face are held by bodies."""
    points = skin_of(scene, _body(Vacuum(), [face]))
    held = np.zeros(len(points), bool)
    for body in bodies:
        held |= held_by(scene, body, points)
    return bool(held.all()) and len(points) > 0


# ---- where they are ----


def solid_of(scene: Scene, body: Body) -> Solid | None:
    """The solid that a body is, where it is told by inequalities; else None."""
    shape = scene.surfaces[body.surfaces[0]].shape
    if isinstance(shape, Plane):
        return half_space(shape, body.faces[0][1])
    is_solid = isinstance(shape, (Box, Slab)) or (isinstance(shape, Sphere) and shape.is_closed)
    return shape if is_solid else None


def held_by(scene: Scene, body: Body, points: np.ndarray) -> np.ndarray:
    """Which points (n, 3) [m] a body holds."""
    solid = solid_of(scene, body)
    if solid is not None:
        return holds(solid, points)
    shapes = [scene.surfaces[number].shape for number in body.surfaces]
    bounds = np.array([shape.bounds for shape in shapes])
    near = ((points >= bounds[:, 0].min(axis=0)) & (points <= bounds[:, 1].max(axis=0))).all(axis=1)
    held = np.zeros(len(points), bool)
    if isinstance(shapes[0], Mesh) and shapes[0].is_closed:
        mesh = shapes[0]
        held[near] = [abs(winding_number(mesh.vertices, mesh.faces, point)) > 0.5 for point in points[near]]
    elif near.any():
        held[near] = _by_lines(scene, body, points[near])
    return held


def _by_lines(scene: Scene, body: Body, points: np.ndarray) -> np.ndarray:
    """Whether most of the lines from each point come to the body's surface from within."""
    votes = np.zeros(len(points), int)
    for way in WAYS / np.linalg.norm(WAYS, axis=1)[:, None]:
        nearest, is_in = np.full(len(points), np.inf), np.zeros(len(points), bool)
        for number in body.surfaces:
            found = crossings(scene.surfaces[number].shape, points, np.tile(way, (len(points), 1)))
            if not found.distances.shape[1]:
                continue
            ahead = np.where(found.distances > 0, found.distances, np.inf)
            first = np.argmin(ahead, axis=1)[:, None]
            distance = np.take_along_axis(ahead, first, axis=1)[:, 0]
            is_before = (
                np.take_along_axis(found.sides, first, axis=1)[:, 0] < 0
            )  # the side where it comes from: front
            faces = set(body.faces)
            inside = np.where(is_before, (number, True) in faces, (number, False) in faces)
            is_in = np.where(distance < nearest, inside, is_in)
            nearest = np.minimum(nearest, distance)
        votes += np.where(is_in, 1, -1)
    return votes > 0


def skin_of(scene: Scene, body: Body, count: int = 64) -> np.ndarray:
    """Places (n, 3) [m] just under the surface of a body, where straight lines through the boxes about its faces cross it."""
    from transport.nesting import lines_through

    points = []
    for number, is_front in body.faces:
        shape = scene.surfaces[number].shape
        size = shape.extent if np.isfinite(shape.extent) else max(magnitude(shape), 1.0)
        origins, ways = lines_through([shape], count if not isinstance(shape, Mesh) else 8, size)
        found = crossings(shape, origins, ways)
        line, _ = np.nonzero(~np.isnan(found.distances))
        distances, sides = (
            found.distances[~np.isnan(found.distances)],
            found.sides[~np.isnan(found.distances)],
        )
        into = sides if is_front else -sides
        points.append(origins[line] + (distances + into * SKIN * size)[:, None] * ways[line])
    return np.concatenate(points)


def is_in(scene: Scene, one: Body, other: Body) -> bool:
    """Whether all of one body lies in another: exact for solids, else by places under its surface."""
    a, b = solid_of(scene, one), solid_of(scene, other)
    if a is not None and b is not None:
        return is_within(a, b)
    if a is not None and scene.surfaces[one.surfaces[0]].shape.is_infinite:
        return False
    points = skin_of(scene, one)
    return bool(held_by(scene, other, points).all()) and len(points) > 0


def have_common_part(scene: Scene, one: Body, other: Body) -> bool:
    """Whether two bodies have a volume in common: exact for solids, else by places under their surfaces."""
    a, b = solid_of(scene, one), solid_of(scene, other)
    if a is not None and b is not None:
        return do_meet(a, b)
    return bool(
        held_by(scene, other, skin_of(scene, one)).any() or held_by(scene, one, skin_of(scene, other)).any()
    )
