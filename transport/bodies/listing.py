"""Bodies: the regions of a scene that media fill, and which of them hold a point.

A closed shape with a medium inside is a body, and so is the half space on a side of a Plane that names a
medium. Open surfaces that name the same medium on a side, such as the two caps and the rim of a lens, bound
one body together if their boxes touch. Bodies may be nested, and the innermost counts; the scene's medium
fills the rest.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import lru_cache
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from transport.bodies.regions import SKIN, Body, held_by, holders_of, skin_of
from transport.bodies.solids import magnitude
from transport.materials.surface import AnyMedium, Surface
from transport.media import Vacuum
from transport.media.medium import plain
from transport.shapes import Plane, Shape
from transport.shapes.base import ROUNDING
from transport.validation import SceneError
from transport.vectors import Vector

if TYPE_CHECKING:
    from transport.parts import SceneParts

MOST_BODIES = 62  # bits of a 64-bit integer
ASIDE = 16 * ROUNDING  # relative to coordinates: a point this far from a surface is surely on one side


def surrounding_of(scene: SceneParts) -> AnyMedium:
    """Medium outside all bodies."""
    return Vacuum() if scene.medium is None else plain(scene.medium)


def media_of(scene: SceneParts) -> tuple[AnyMedium, ...]:
    """All media of a scene, each once, the surrounding one first."""
    return tuple(dict.fromkeys([surrounding_of(scene), *(body.medium for body in bodies_of(scene))]))


def has_media(scene: SceneParts) -> bool:
    """Whether any medium of the scene is not vacuum."""
    return any(medium != Vacuum() for medium in media_of(scene))


def bodies_of(scene: SceneParts) -> tuple[Body, ...]:
    """Bodies of a scene, inner ones before those that hold them. Raises SceneError for more than 62."""
    return nested(scene)[0]


@lru_cache(maxsize=8)
def nested(scene: SceneParts) -> tuple[tuple[Body, ...], tuple[frozenset[int], ...]]:
    """Bodies of a scene, and for each the indices of the bodies in which it lies."""
    bodies = [*_solid_bodies(scene), *_compound_bodies(scene)]
    if len(bodies) > MOST_BODIES:
        must = f"surfaces must bound at most {MOST_BODIES} bodies of media, got {len(bodies)}"
        layers = f"write layers as a Grid(box=..., absorption=...) of (1, 1, {len(bodies)}) in a wide Box"
        raise SceneError(f"Scene: {must}; {layers}, and many small bodies as a Grid with more voxels")
    holders = holders_of(scene, bodies)
    order = sorted(range(len(bodies)), key=lambda k: -len(holders[k]))
    number = {k: n for n, k in enumerate(order)}
    return tuple(bodies[k] for k in order), tuple(frozenset(number[j] for j in holders[k]) for k in order)


def sides_of(scene: SceneParts) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    """For each surface the indices of the bodies that it bounds on its front and on its back."""
    sides = [((), ()) for _ in scene.surfaces]
    for number, body in enumerate(bodies_of(scene)):
        for surface, is_front in body.faces:
            front, back = sides[surface]
            sides[surface] = ((*front, number), back) if is_front else (front, (*back, number))
    return sides


def body_bits_around(
    scene: SceneParts, positions: np.ndarray, directions: np.ndarray | None = None
) -> np.ndarray:
    """Which bodies hold positions (n, 3) [m]: bit k of a 64-bit integer for body k.

    With `directions` (n, 3) the point just ahead counts: a position on a surface belongs to the side that the
    direction leads to.
    """
    points = np.atleast_2d(np.asarray(positions, float))
    if directions is not None:
        size = np.abs(points).sum(axis=1) + max(
            (magnitude(surface.shape) for surface in scene.surfaces), default=0.0
        )
        points = points + ASIDE * size[:, None] * np.atleast_2d(directions)
    return bits_at(scene, points, range(len(bodies_of(scene))))


def bits_at(scene: SceneParts, points: np.ndarray, numbers: Iterable[int]) -> np.ndarray:
    """Which of the bodies with these indices hold points (n, 3) [m], as bits."""
    bits, bodies = np.zeros(len(points), np.int64), bodies_of(scene)
    for number in numbers:
        bits |= held_by(scene, bodies[number], points).astype(np.int64) << number
    return bits


def medium_at(scene: SceneParts, position: Vector) -> AnyMedium:
    """Medium at a position [m]: of the innermost body that holds it, else the surrounding medium."""
    return media_at(scene, np.array([position], float))[0]


def media_at(scene: SceneParts, positions: np.ndarray) -> list[AnyMedium]:
    """Medium at each of the positions (n, 3) [m]."""
    bodies, around = bodies_of(scene), surrounding_of(scene)
    return [
        bodies[(int(bits) & -int(bits)).bit_length() - 1].medium if bits else around
        for bits in body_bits_around(scene, positions)
    ]


# ---- construction of bodies ----


def _solid_bodies(scene: SceneParts) -> Iterator[Body]:
    """One body for each closed shape with a medium inside, and for each side of a Plane with one."""
    for number, surface in enumerate(scene.surfaces):
        if is_whole(surface.shape) and surface.back is not None:
            yield Body(plain(surface.back), (number,), ((number, False),))
        is_plane = isinstance(surface.shape, Plane) and surface.front is not None
        if is_plane and plain(surface.front) != surrounding_of(scene) and not is_layer(scene, surface):
            yield Body(plain(surface.front), (number,), ((number, True),))


def is_layer(scene: SceneParts, lower: Surface) -> bool:
    """Whether a Plane and the next parallel plane before it name the same medium between them."""
    normal, heights = np.array(lower.shape.normal), []
    level = float(normal @ lower.shape.center)
    for upper in scene.surfaces:
        if isinstance(upper.shape, Plane) and normal @ upper.shape.normal >= 1 - 4 * ROUNDING:
            height = float(normal @ upper.shape.center) - level
            if height > 0:
                heights.append((height, upper.back))
    _, medium = min(heights, key=lambda found: found[0], default=(0.0, None))
    return medium is not None and plain(medium) == plain(lower.front)


def is_whole(shape: Shape) -> bool:
    """Whether a surface bounds a body by itself."""
    return shape.is_closed or isinstance(shape, Plane)


def _compound_bodies(scene: SceneParts) -> list[Body]:
    """Bodies that open surfaces bound together; of the surrounding medium only those inside another body.

    A side that names the medium of a closed body around it, such as that of a rod in a tank, bounds no body
    of its own.
    """
    # Collect the faces of each medium, without those inside a body of the same medium.
    solids = list(_solid_bodies(scene))
    faces: dict[AnyMedium, list[tuple[int, bool]]] = {}
    for number, surface in enumerate(scene.surfaces):
        if not is_whole(surface.shape):
            for medium, is_front in ((surface.front, True), (surface.back, False)):
                about = [body for body in solids if medium is not None and body.medium == plain(medium)]
                if medium is not None and not (about and _is_inside(scene, (number, is_front), about)):
                    faces.setdefault(plain(medium), []).append((number, is_front))
    # Split them into connected bodies; keep the surrounding medium only inside other bodies.
    around = faces.pop(surrounding_of(scene), [])
    bodies = [_body(medium, part) for medium, every in faces.items() for part in _parts(scene, every)]
    if not around:
        return bodies
    others = [*solids, *bodies]
    inner = [face for face in around if _is_inside(scene, face, others)]
    return bodies + [_body(surrounding_of(scene), part) for part in _parts(scene, inner)]


def _body(medium: AnyMedium, faces: list[tuple[int, bool]]) -> Body:
    """Body of a medium with these faces."""
    return Body(medium, tuple(dict.fromkeys(number for number, _ in faces)), tuple(faces))


def _parts(scene: SceneParts, faces: list[tuple[int, bool]]) -> list[list[tuple[int, bool]]]:
    """Groups of faces whose boxes touch, directly or through others."""
    parts: list[list[tuple[int, bool]]] = []
    for face in faces:
        joined = [part for part in parts if any(_do_touch(scene, face, other) for other in part)]
        parts = [part for part in parts if part not in joined]
        parts.append([*chain.from_iterable(joined), face])
    return [sorted(part) for part in parts]


def _do_touch(scene: SceneParts, one: tuple[int, bool], other: tuple[int, bool]) -> bool:
    """Whether the bounding boxes of two faces touch."""
    a, b = scene.surfaces[one[0]].shape, scene.surfaces[other[0]].shape
    gap = SKIN * (a.extent + b.extent)
    return all(p <= s + gap and r <= q + gap for p, q, r, s in zip(*a.bounds, *b.bounds, strict=True))


def _is_inside(scene: SceneParts, face: tuple[int, bool], bodies: list[Body]) -> bool:
    """Whether all points just beside a face are in one of the bodies."""
    points = skin_of(scene, _body(Vacuum(), [face]))
    held = np.zeros(len(points), bool)
    for body in bodies:
        held |= held_by(scene, body, points)
    return bool(held.all()) and len(points) > 0
