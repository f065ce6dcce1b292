"""Regions of bodies: which points a body holds, and whether it lies in another or overlaps it.

Spheres, boxes, slabs and half spaces are decided by inequalities, closed meshes by their winding number,
bodies of open surfaces by the majority of a few straight lines.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from transport.bodies.lines import FACETS, lines_through
from transport.bodies.solids import HalfSpace, Solid, do_meet, half_space, holds, is_within
from transport.materials.surface import AnyMedium
from transport.shapes import Box, Mesh, Plane, Shape, Slab, Sphere
from transport.shapes.base import ROUNDING
from transport.shapes.crossings import crossings
from transport.shapes.mesh_geometry import winding_number

if TYPE_CHECKING:
    from transport.parts import SceneParts

WAYS = np.array(  # directions of the lines that decide what is inside; none along an axis or a diagonal
    [(0.36, 0.48, 0.8), (-0.64, 0.6, 0.48), (0.28, -0.576, 0.768), (-0.352, -0.36, 0.864),
     (0.768, 0.28, -0.576), (-0.48, 0.8, -0.36), (0.6, -0.48, -0.64)]
)  # fmt: skip
PLACES = 64  # test points below each face
SKIN = 1e-9  # depth of test points, relative to a body's extent


@dataclass(frozen=True)
class Body:
    """Region filled by a medium: indices of the surfaces that bound it, and on which side of each it lies."""

    medium: AnyMedium
    surfaces: tuple[int, ...]
    faces: tuple[tuple[int, bool], ...] = ()  # index of the surface, and whether the body is in front of it


def solid_of(scene: SceneParts, body: Body) -> Solid | None:
    """The body as a solid that inequalities describe; None if it is not one."""
    shape = scene.surfaces[body.surfaces[0]].shape
    if isinstance(shape, Plane):
        return half_space(shape, body.faces[0][1])
    is_solid = isinstance(shape, (Box, Slab)) or (isinstance(shape, Sphere) and shape.is_closed)
    return shape if is_solid else None


def held_by(scene: SceneParts, body: Body, points: np.ndarray) -> np.ndarray:
    """Which points (n, 3) [m] lie in a body."""
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


def _by_lines(scene: SceneParts, body: Body, points: np.ndarray) -> np.ndarray:
    """Whether most lines from each point reach the body's surface from inside."""
    votes = np.zeros(len(points), int)
    for way in WAYS / np.linalg.norm(WAYS, axis=1)[:, None]:
        nearest, is_in = np.full(len(points), np.inf), np.zeros(len(points), bool)
        for number in body.surfaces:
            found = crossings(scene.surfaces[number].shape, points, np.tile(way, (len(points), 1)))
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


def skin_of(scene: SceneParts, body: Body) -> np.ndarray:
    """Points (n, 3) [m] just below the surface of a finite body."""
    faces = [(scene.surfaces[number].shape, is_front) for number, is_front in body.faces]
    return np.concatenate([_under(shape, is_front) for shape, is_front in faces])


@lru_cache(maxsize=512)
def _under(shape: Shape, is_front: bool) -> np.ndarray:
    """Points (n, 3) [m] close to one side of a surface.

    For a mesh they lie beside facets, else where lines through the shape's bounding box cross it.
    """
    depth = SKIN * shape.extent
    if isinstance(shape, Mesh):
        most = max(8, min(PLACES, FACETS // shape.triangles))
        facets = np.unique(np.linspace(0, shape.triangles - 1, most).astype(int))
        way = shape.normals[facets] if is_front else -shape.normals[facets]
        return shape.vertices[shape.faces[facets]].mean(axis=1) + depth * way
    origins, ways = lines_through([shape], PLACES, shape.extent)
    found = crossings(shape, origins, ways)
    is_met = ~np.isnan(found.distances)
    line, _ = np.nonzero(is_met)
    into = found.sides[is_met] if is_front else -found.sides[is_met]
    return origins[line] + (found.distances[is_met] + depth * into)[:, None] * ways[line]


def box_of(scene: SceneParts, body: Body) -> np.ndarray:
    """Lower and upper corner (2, 3) [m] of a body's bounding box."""
    if isinstance(solid_of(scene, body), HalfSpace):
        return np.array([[-math.inf] * 3, [math.inf] * 3])
    bounds = np.array([scene.surfaces[number].shape.bounds for number in body.surfaces])
    return np.array([bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)])


def holders_of(scene: SceneParts, bodies: list[Body]) -> list[set[int]]:
    """For each body the indices of all bodies in which it lies.

    Larger bodies come first, so that the holders of a holder need no test.
    """
    if not bodies:
        return []
    low, high = np.array([box_of(scene, body) for body in bodies]).transpose(1, 0, 2)
    # Select candidates by their boxes, with slack for rounding.
    span = high - low
    slack = 4 * SKIN * np.where(np.isfinite(span), span, 0).max(axis=1)
    slack = (slack[:, None] + slack + 4 * ROUNDING * (_finite(low) + _finite(high)))[:, :, None]
    may_hold = ((low[:, None] >= low - slack) & (high[:, None] <= high + slack)).all(axis=2)  # (body, holder)
    # Test them from the smallest to the largest, and inherit the holders of each holder.
    breadth = span.sum(axis=1)
    holders: list[set[int]] = [set() for _ in bodies]
    for k in np.argsort(-breadth, kind="stable").tolist():
        for j in sorted(np.flatnonzero(may_hold[k]).tolist(), key=breadth.__getitem__):
            if j != k and j not in holders[k] and is_in(scene, bodies[k], bodies[j]):
                holders[k] |= {j} | holders[j] - {k}
    return holders


def _finite(corners: np.ndarray) -> float:
    """Largest finite coordinate."""
    return float(np.abs(corners[np.isfinite(corners)]).max(initial=0.0))


def is_in(scene: SceneParts, one: Body, other: Body) -> bool:
    """Whether one body lies wholly in another: exact for solids, else by points below its surface."""
    a, b = solid_of(scene, one), solid_of(scene, other)
    if a is not None and b is not None:
        return is_within(a, b)
    if _is_endless(scene, one):
        return False
    points = skin_of(scene, one)
    return bool(held_by(scene, other, points).all()) and len(points) > 0


def have_common_part(scene: SceneParts, one: Body, other: Body) -> bool:
    """Whether two bodies overlap: exact for solids, else by points below their surfaces."""
    a, b = solid_of(scene, one), solid_of(scene, other)
    if a is not None and b is not None:
        return do_meet(a, b)
    pairs = [(p, q) for p, q in ((one, other), (other, one)) if not _is_endless(scene, p)]
    return any(held_by(scene, q, skin_of(scene, p)).any() for p, q in pairs)


def _is_endless(scene: SceneParts, body: Body) -> bool:
    """Whether a body is infinite."""
    return scene.surfaces[body.surfaces[0]].shape.is_infinite
