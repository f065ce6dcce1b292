"""Whether the bodies of a scene fit together: one lies in another or beside it, and what fills it has a place there.

Balls, boxes, slabs and half spaces that cut one another are told exactly.  Meshes and bodies of open surfaces are
judged by some dozens of places just under their surfaces: what cuts less of them than lies between these may be
missed.  What surfaces have on their two sides is asked in frontiers.py.
"""

from __future__ import annotations

import math
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from transport.bodies import bodies_of, surrounding_of
from transport.emissions import Isotropic
from transport.frontiers import check_sides, title_of
from transport.materials import Dielectric, Transparent, simple_parts
from transport.materials.surface import AnyMedium
from transport.media import Grid
from transport.nesting import CLOSE
from transport.regions import Body, have_common_part, is_in, solid_of
from transport.shapes import Box, Sphere
from transport.solids import HalfSpace
from transport.sources import Source
from transport.validation import SceneError, shown

if TYPE_CHECKING:
    from transport.scene import Scene


def check_filling(scene: Scene) -> None:
    """Refuse media that do not go together.  Raises SceneError; what is looked at is said above."""
    if not names_media(scene):
        return
    bodies = bodies_of(scene)
    _check_grids(scene, bodies)
    _check_units(scene, bodies)
    for one, other in combinations(range(len(bodies)), 2):
        _check_pair(scene, bodies[one], bodies[other])
    _check_glow(scene, bodies)
    _check_end(scene, bodies)
    check_sides(scene, bodies)


def names_media(scene: Scene) -> bool:
    """Whether any medium is named in a scene."""
    return scene.medium is not None or any(
        medium is not None for surface in scene.surfaces for medium in (surface.front, surface.back)
    )


def glows(scene: Scene) -> bool:
    """Whether a medium in a scene emits."""
    media = [scene.medium, *(m for surface in scene.surfaces for m in (surface.front, surface.back))]
    return any(medium is not None and medium.emission > 0 for medium in media)


def glowing_sources(scene: Scene) -> list[tuple[int, Source]]:
    """Surfaces, by their numbers, whose inside emits, as sources of 1 W that fill them."""
    return [
        (number, Source(surface.shape, Isotropic(power=1.0)))
        for number, surface in enumerate(scene.surfaces)
        if surface.back is not None
        and surface.back.emission > 0
        and isinstance(surface.shape, Box | Sphere)
        and surface.shape.is_closed
    ]


def _bounds_of(scene: Scene, body: Body) -> str:
    """The surfaces of a body, in words."""
    titles = [title_of(scene, number) for number in body.surfaces]
    return " and ".join([", ".join(titles[:-1]), titles[-1]]) if len(titles) > 1 else titles[0]


# ---- bodies ----


def _check_grids(scene: Scene, bodies: tuple[Body, ...]) -> None:
    """Refuse a body that reaches beyond the voxels which fill it."""
    for body in bodies:
        if not isinstance(body.medium, Grid):
            continue
        box = body.medium.box
        low, high = np.array(box.bounds)
        gap = CLOSE * box.extent
        for number in body.surfaces:
            bounds = np.array(scene.surfaces[number].shape.bounds)
            if (bounds[0] < low - gap).any() or (bounds[1] > high + gap).any():
                must = f"{title_of(scene, number)} must lie within the box of the Grid that fills it"
                got = f"{shown(scene.surfaces[number].shape)} beyond {box}"
                cure = "write Surface(grid.box, Transparent(), inside=grid)"
                raise SceneError(f"Scene: {must}, got {got}; {cure}")


def _check_units(scene: Scene, bodies: tuple[Body, ...]) -> None:
    """Refuse what is of light in a scene of particles."""
    if scene.measured_in == "watts":
        return
    named = [("medium", surrounding_of(scene)), *((_bounds_of(scene, body), body.medium) for body in bodies)]
    for what, medium in named:
        if medium.index != 1 or medium.emission:
            got = f"index={medium.index}" if medium.index != 1 else f"emission={medium.emission}"
            cure = "leave it out, or emit watts"
            raise SceneError(
                f"Scene: {what}: a medium of particles bends and emits nothing, got {got}; {cure}"
            )


def _check_pair(scene: Scene, one: Body, other: Body) -> None:
    """Refuse two bodies of unlike media of which neither lies in the other, or each does."""
    if one.medium == other.medium or not _boxes_meet(scene, one, other):
        return
    a, b = is_in(scene, one, other), is_in(scene, other, one)
    if a != b or not (a or have_common_part(scene, one, other)):
        return
    words = "are one region of two media" if a else "overlap in part, and their media differ"
    cure = "leave one out" if a else "move them apart, put one wholly into the other, or give both one medium"
    got = f"{shown(one.medium)} and {shown(other.medium)}"
    raise SceneError(
        f"Scene: {_bounds_of(scene, one)} and {_bounds_of(scene, other)} {words}, got {got}; {cure}"
    )


def _boxes_meet(scene: Scene, one: Body, other: Body) -> bool:
    (low_a, high_a), (low_b, high_b) = box_of(scene, one), box_of(scene, other)
    return bool((low_a <= high_b).all() and (low_b <= high_a).all())


def box_of(scene: Scene, body: Body) -> np.ndarray:
    """Lower and upper corner (2, 3) [m] of a box that holds a body."""
    if isinstance(solid_of(scene, body), HalfSpace):
        return np.array([[-math.inf] * 3, [math.inf] * 3])
    bounds = np.array([scene.surfaces[number].shape.bounds for number in body.surfaces])
    return np.array([bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)])


def _check_glow(scene: Scene, bodies: tuple[Body, ...]) -> None:
    """Refuse emission of what is not a whole Box or ball of its own."""
    if surrounding_of(scene).emission:
        got = f"emission={surrounding_of(scene).emission}"
        cure = "give it to a body, as Surface(Box(...), Transparent(), inside=Medium(emission=...))"
        raise SceneError(f"Scene: medium must not emit without end, got {got}; {cure}")
    for body in bodies:
        if not body.medium.emission:
            continue
        if not isinstance(solid_of(scene, body), Box | Sphere):
            got = shown(scene.surfaces[body.surfaces[0]].shape)
            cure = "fill a Box or a Sphere with what emits"
            raise SceneError(
                f"Scene: {_bounds_of(scene, body)}: emission needs a Box or Sphere, got {got}; {cure}"
            )
        for other in bodies:
            is_beside = other is body or not _boxes_meet(scene, body, other) or is_in(scene, body, other)
            if not is_beside and have_common_part(scene, body, other):
                raise SceneError(
                    f"Scene: {_bounds_of(scene, body)}: a body that emits must hold no other one, got {_bounds_of(scene, other)}"
                    " in it; make boxes side by side of it"
                )


def _check_end(scene: Scene, bodies: tuple[Body, ...]) -> None:
    """Refuse endless scattering where nothing in the scene absorbs and no clock runs."""
    around = surrounding_of(scene)
    if scene.duration is not None or not around.scattering or absorbs(around):
        return
    walls = any(
        not isinstance(part, Dielectric | Transparent)
        for surface in scene.surfaces
        for part in simple_parts(surface.material)
    )
    if not walls and not any(absorbs(body.medium) for body in bodies):
        must = "medium must absorb, or have an end"
        cure = "add absorption=..., put it into a Box, or give the scene a duration"
        raise SceneError(f"Scene: {must}, got {shown(scene.medium)}, in which no history ends; {cure}")


def absorbs(medium: AnyMedium | None) -> bool:
    """Whether some of what flies through a medium ends there."""
    return medium is not None and bool(np.max(medium.absorption) > 0)
