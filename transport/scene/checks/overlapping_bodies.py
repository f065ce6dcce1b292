"""Checks that the bodies of a scene fit together: nested or disjoint, and filled by media that fit there.

Intersections of spheres, boxes, slabs and half spaces are decided exactly. Meshes and bodies of open surfaces
are tested at dozens of points just below their surfaces; an overlap smaller than their spacing may be missed.
The media on both sides of each surface are checked in interfaces.py.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from transport.geometry.line_crossings import EDGE_TOLERANCE
from transport.geometry.relations import HalfSpace
from transport.geometry.shape import ROUNDING
from transport.scene.bodies import (
    Body,
    bodies_overlap,
    body_bounds,
    body_solid,
    is_layer,
    nested_bodies,
    scene_bodies,
    surrounding_medium,
)
from transport.scene.checks.closed_bodies import check_closed
from transport.scene.checks.interfaces import check_sides
from transport.scene.emissions import Isotropic
from transport.scene.materials import AnyMedium
from transport.scene.media import Grid
from transport.scene.parts import join_surface_names, named_media, surface_name
from transport.scene.sources import Source
from transport.validation import SceneError, short_repr

if TYPE_CHECKING:
    from transport.scene.parts import SceneParts


def check_filling(scene: SceneParts) -> None:
    """Raise SceneError for media that do not fit together, within the limits stated above."""
    if not named_media(scene):
        return
    bodies = scene_bodies(scene)
    _check_grids(scene, bodies)
    _check_units(scene, bodies)
    check_closed(scene, bodies)
    _check_layers(scene)
    _check_pairs(scene, bodies)
    _check_emission(scene, bodies)
    _check_infinite_scattering(scene, bodies)
    check_sides(scene, bodies)


def emitting_bodies_as_sources(scene: SceneParts) -> list[tuple[int, Source]]:
    """Surfaces whose inside emits, by index, as sources of 1 W that fill them."""
    return [
        (number, Source(surface.shape, Isotropic(power=1.0)))
        for number, surface in enumerate(scene.surfaces)
        if surface.back is not None
        and surface.back.emission > 0
        and surface.shape.is_convex
        and not surface.shape.is_infinite
    ]


def _body_name(scene: SceneParts, body: Body) -> str:
    """Names of the surfaces of a body."""
    return join_surface_names(scene, body.surfaces, most=len(body.surfaces))


# ---- bodies ----


def _check_grids(scene: SceneParts, bodies: tuple[Body, ...]) -> None:
    """Refuse a body that extends beyond the voxels that fill it."""
    for body in bodies:
        if not isinstance(body.medium, Grid):
            continue
        box = body.medium.box
        low, high = np.array(box.bounds)
        gap = EDGE_TOLERANCE * box.extent
        for number in body.surfaces:
            bounds = np.array(scene.surfaces[number].shape.bounds)
            if (bounds[0] < low - gap).any() or (bounds[1] > high + gap).any():
                must = f"{surface_name(scene, number)} must lie within the box of the Grid that fills it"
                got = f"{short_repr(scene.surfaces[number].shape)} beyond {box}"
                cure = "write Surface(grid.box, Transparent(), inside=grid)"
                raise SceneError(f"Scene: {must}, got {got}; {cure}")


def _check_units(scene: SceneParts, bodies: tuple[Body, ...]) -> None:
    """Refuse optical properties in a scene of particles."""
    if scene.measured_in == "watts":
        return
    named = [
        ("medium", surrounding_medium(scene)),
        *((_body_name(scene, body), body.medium) for body in bodies),
    ]
    for what, medium in named:
        if medium.index != 1 or medium.emission:
            got = f"index={medium.index}" if medium.index != 1 else f"emission={medium.emission}"
            cure = "leave it out, or emit watts"
            raise SceneError(
                f"Scene: {what}: a medium of particles must not refract or emit, got {got}; {cure}"
            )


def _check_pairs(scene: SceneParts, bodies: tuple[Body, ...]) -> None:
    """Refuse two bodies of different media unless one lies in the other or they are disjoint."""
    _, holders = nested_bodies(scene)
    for k, n in np.argwhere(np.triu(_boxes_meet(scene, bodies), 1)).tolist():
        one, other = bodies[k], bodies[n]
        is_held, holds = n in holders[k], k in holders[n]
        if one.medium != other.medium and is_held == holds:
            _check_pair(scene, one, other, is_held)
        elif is_held == holds and all(
            isinstance(body_solid(scene, body), HalfSpace) for body in (one, other)
        ):
            _check_half_spaces(scene, one, other, is_held)


def _check_half_spaces(scene: SceneParts, one: Body, other: Body, is_same: bool) -> None:
    """Refuse overlapping half spaces of one medium: they fill their union, not a layer between planes."""
    if is_same or not bodies_overlap(scene, one, other):
        return
    raise SceneError(
        f"Scene: {_body_name(scene, one)} and {_body_name(scene, other)} must not fill half spaces"
        f" that overlap, got {short_repr(one.medium)} in both; for the region between planes write Slab(...),"
        " Box(...) or Box(...).faces()"
    )


def _check_layers(scene: SceneParts) -> None:
    """Refuse a plane that does not end a layer: the medium named in front of it continues behind it."""
    for number, surface in enumerate(scene.surfaces):
        is_plane = surface.shape.is_plane
        is_one_sided = is_plane and surface.front is not None and surface.back is None
        if is_one_sided and is_layer(scene, surface):
            raise SceneError(
                f"Scene: {surface_name(scene, number)}: back must be named below a layer of"
                f" {short_repr(surface.front)}, which would continue behind it, got None;"
                " write back=Vacuum(), or the medium there"
            )


def _check_pair(scene: SceneParts, one: Body, other: Body, is_same: bool) -> None:
    """Refuse two bodies that are the same region or overlap."""
    if not is_same and not bodies_overlap(scene, one, other):
        return
    words = "are one region of two media" if is_same else "overlap in part, and their media differ"
    cure = (
        "leave one out"
        if is_same
        else "move them apart, put one wholly into the other, or give both the same medium"
    )
    got = f"{short_repr(one.medium)} and {short_repr(other.medium)}"
    raise SceneError(
        f"Scene: {_body_name(scene, one)} and {_body_name(scene, other)} {words}, got {got}; {cure}"
    )


def _boxes_meet(scene: SceneParts, bodies: tuple[Body, ...]) -> np.ndarray:
    """Mask of the pairs of bodies, (bodies, bodies), whose bounding boxes have a common volume."""
    low, high = np.array([body_bounds(scene, body) for body in bodies]).reshape(-1, 2, 3).transpose(1, 0, 2)
    sizes = np.where(np.isfinite(low), abs(low), 0) + np.where(np.isfinite(high), abs(high), 0)
    across = np.minimum(high[:, None], high) - np.maximum(low[:, None], low)
    return (across > ROUNDING * (sizes[:, None] + sizes)).all(axis=2)


def _check_emission(scene: SceneParts, bodies: tuple[Body, ...]) -> None:
    """Refuse emission of anything but a whole Box or Sphere that holds no other body."""
    if surrounding_medium(scene).emission:
        got = f"emission={surrounding_medium(scene).emission}"
        cure = "give it to a body, as Surface(Box(...), Transparent(), inside=Medium(emission=...))"
        raise SceneError(f"Scene: medium must not emit, because it is infinite, got {got}; {cure}")
    _, holders = nested_bodies(scene)
    meet = _boxes_meet(scene, bodies)
    for k, body in enumerate(bodies):
        if not body.medium.emission:
            continue
        solid = body_solid(scene, body)
        if solid is None or solid.is_infinite:
            got = short_repr(scene.surfaces[body.surfaces[0]].shape)
            cure = "fill a Box or a Sphere with the emitting medium"
            raise SceneError(
                f"Scene: {_body_name(scene, body)}: emission needs a Box or Sphere, got {got}; {cure}"
            )
        for number, other in enumerate(bodies):
            is_beside = other is body or number in holders[k] or not meet[k, number]
            if not is_beside and bodies_overlap(scene, body, other):
                raise SceneError(
                    f"Scene: {_body_name(scene, body)}: a body that emits must hold no other body,"
                    f" got {_body_name(scene, other)} in it; divide it into boxes side by side"
                )


def _check_infinite_scattering(scene: SceneParts, bodies: tuple[Body, ...]) -> None:
    """Refuse an infinite scattering medium if nothing in the scene absorbs and no duration is set."""
    around = surrounding_medium(scene)
    if scene.duration is not None or not around.scattering or absorbs(around):
        return
    is_open = all(surface.material.is_clear for surface in scene.surfaces)
    if is_open and not any(absorbs(body.medium) for body in bodies):
        must = "medium must absorb or be finite"
        cure = "add absorption=..., put it into a Box, or give the scene a duration"
        raise SceneError(f"Scene: {must}, got {short_repr(scene.medium)}, in which no history ends; {cure}")


def absorbs(medium: AnyMedium | None) -> bool:
    """Return whether a medium absorbs."""
    return medium is not None and bool(np.max(medium.absorption) > 0)
