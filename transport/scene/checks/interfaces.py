"""Checks of the media on both sides of each surface: named media, and matching refractive indices.

Surfaces are probed along some hundred fixed straight lines; anything smaller than their spacing may be
missed. Which bodies hold a point of a line is decided by inequalities; for closed meshes and bodies of open
surfaces (closed_bodies.py checks that they are closed) by the surfaces crossed before, as in the engine.
Sides are not judged where surfaces are closer than 1e-11 of the scene's size (and the rounding of their
coordinates), nor by lines that pass within 1e-9 of it of an edge or a tangent.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from transport.geometry.line_crossings import (
    DEFAULT_LINES,
    MAX_LINE_FACETS,
    lines_through,
    scene_size,
    sorted_crossings,
)
from transport.scene.bodies import Body, bits_of_bodies_at, bodies_on_sides, body_solid, surrounding_medium
from transport.scene.materials import AnyMedium, Surface
from transport.scene.media import Vacuum, canonical_medium
from transport.scene.parts import surface_name
from transport.validation import SceneError, short_repr

if TYPE_CHECKING:
    from transport.scene.parts import SceneParts


class InterfaceCrossing(NamedTuple):
    """Surfaces that a line crosses at one place, each with +1 if the line runs along the normal, else -1."""

    surfaces: tuple[tuple[int, int], ...]
    place: np.ndarray
    before: int  # bits of the bodies before and behind the crossing
    behind: int


def check_sides(scene: SceneParts, bodies: tuple[Body, ...]) -> None:
    """Refuse named media that differ from what is there, and refractive indices that do not match."""
    seen = set()
    for crossed in _interface_crossings(scene, bodies):
        kind = crossed.surfaces, crossed.before, crossed.behind
        if kind in seen:
            continue
        seen.add(kind)
        media = [_medium_of(scene, bodies, bits) for bits in (crossed.before, crossed.behind)]
        if len(crossed.surfaces) == 1:
            ((number, direction),) = crossed.surfaces
            _check_named(scene, bodies, number, direction, crossed, media)
        _check_index(scene, crossed, media)


def _medium_of(scene: SceneParts, bodies: tuple[Body, ...], bits: int) -> AnyMedium:
    """Medium of the innermost body in a bit set; the surrounding medium if it is empty."""
    return bodies[(bits & -bits).bit_length() - 1].medium if bits else surrounding_medium(scene)


def _check_named(
    scene, bodies, number: int, direction: int, crossed: InterfaceCrossing, media: list[AnyMedium]
) -> None:
    """Refuse a surface whose named media are not there: neither its own body nor the same medium."""
    surface = scene.surfaces[number]
    sides = [(True, crossed.behind, media[1]), (False, crossed.before, media[0])]
    if direction < 0:
        sides = [(True, crossed.before, media[0]), (False, crossed.behind, media[1])]
    for is_front, bits, found in sides:
        named = surface.front if is_front else surface.back
        if named is None:
            continue
        own = [k for k, body in enumerate(bodies) if (number, is_front) in body.faces]
        if not any(bits >> k & 1 for k in own) and found != canonical_medium(named):
            _refuse_named(scene, number, is_front, found, crossed.place)


def _refuse_named(
    scene: SceneParts, number: int, is_front: bool, found: AnyMedium, place: np.ndarray
) -> None:
    """Raise the SceneError for a named medium that is not there."""
    surface = scene.surfaces[number]
    side = _side_name(scene, number, is_front)
    where = ", ".join(f"{x:.6g}" for x in place)
    cure = f"leave {side} out: the medium outside comes from the body around, or from Scene(medium=...)"
    if not surface.shape.is_closed:
        cure = f"close the gaps between its surfaces, reverse its normal, or leave {side} out"
    named = short_repr(surface.front if is_front else surface.back)
    raise SceneError(
        f"Scene: {surface_name(scene, number)}: {side} must be the medium there, {short_repr(found)} at"
        f" ({where}), got {named}; {cure}"
    )


def _side_name(scene: SceneParts, number: int, is_front: bool) -> str:
    """Name of a side of a surface in messages."""
    if scene.surfaces[number].shape.is_closed:
        return "outside" if is_front else "inside"
    return "front" if is_front else "back"


def _check_index(scene: SceneParts, crossed: InterfaceCrossing, media: list[AnyMedium]) -> None:
    """Refuse a change of index without a Dielectric, and a Dielectric with other indices."""
    acting = [(k, direction) for k, direction in crossed.surfaces if scene.surfaces[k].material.acts]
    if len(acting) > 1:
        return
    number, direction = acting[0] if acting else crossed.surfaces[0]
    material = scene.surfaces[number].material
    glass = material.boundary
    inside, outside = media if direction > 0 else media[::-1]
    there = inside.index, outside.index
    words = f"Dielectric({there[0]:g}, {there[1]:g})"
    where = ", ".join(f"{x:.6g}" for x in crossed.place)
    if glass is None and material.is_transmissive and there[0] != there[1]:
        must = (
            f"material must be a Dielectric between {short_repr(inside)} behind it and {short_repr(outside)}"
            " in front"
        )
        raise SceneError(
            f"Scene: {surface_name(scene, number)}: {must}, at ({where}), got {short_repr(material)};"
            f" write {words}"
        )
    if glass is not None and there != (glass.index_inside, glass.index_outside):
        is_inside = there[0] != glass.index_inside
        medium, index = (inside, glass.index_inside) if is_inside else (outside, glass.index_outside)
        side = _side_name(scene, number, not is_inside)
        surface = scene.surfaces[number]
        own = surface.back if is_inside else surface.front
        written = "Vacuum()" if index == 1 else f"Medium(index={index:g})"
        cure = f"name the medium there, {side}={written}"
        cure = f"give that medium index={index:g}" if own not in (None, Vacuum()) and index != 1 else cure
        cure += "" if there == (1, 1) else f", or write {words}"
        raise SceneError(
            f"Scene: {surface_name(scene, number)}: {short_repr(glass)} contradicts the medium {side},"
            f" {short_repr(medium)} of index {medium.index:g}, at ({where}); {cure}"
        )


def _interface_crossings(scene: SceneParts, bodies: tuple[Body, ...]) -> Iterator[InterfaceCrossing]:
    """Crossings of straight lines through the bounding surfaces, with the bodies before and behind each."""
    shapes = [surface.shape for surface in scene.surfaces]
    aimed = [surface.shape for surface in scene.surfaces if _bounds_media(surface)]
    if not aimed:
        return
    # Choose the lines and find all their crossings.
    size = scene_size(shapes)
    facets = sum(shape.triangles for shape in shapes)
    count = max(4, min(max(DEFAULT_LINES, 4 * len(aimed)), MAX_LINE_FACETS // max(4 * facets, 1)))
    origins, directions = lines_through(aimed, count, size)
    places, keys = sorted_crossings(shapes, origins, directions, size)
    base = 2 * len(shapes)
    # Group coincident crossings, and take a point between each pair of groups.
    lines = [_group_coincident(row, key, base) for row, key in zip(places, keys, strict=True)]
    kept = [k for k, groups in enumerate(lines) if groups]
    between = [_midpoints([step for step, _ in lines[k]], size) for k in kept]
    points = [origins[k] + steps[:, None] * directions[k] for k, steps in zip(kept, between, strict=True)]
    # Find the bodies at these points: solids by inequalities, others by the surfaces crossed.
    solids = [number for number, body in enumerate(bodies) if body_solid(scene, body) is not None]
    crossed = sum(1 << number for number in range(len(bodies)) if number not in solids)
    sides = [
        [sum(1 << number for number in side) & crossed for side in pair] for pair in bodies_on_sides(scene)
    ]
    bits = iter(bits_of_bodies_at(scene, np.concatenate(points), solids).tolist() if points else [])
    for k in kept:
        before, held = next(bits), 0  # bits of bodies of surfaces: none before the first crossing
        for step, surfaces in lines[k]:
            behind = next(bits)
            was_held = held
            for number, direction in surfaces:
                front, back = sides[number]
                held = held & ~(front | back) | (front if direction > 0 else back)
            yield InterfaceCrossing(
                surfaces, origins[k] + step * directions[k], before | was_held, behind | held
            )
            before = behind


def _group_coincident(
    row: np.ndarray, keys: np.ndarray, base: int
) -> list[tuple[float, tuple[tuple[int, int], ...]]]:
    """Crossings of one line in order: distance [m], and the surfaces that coincide there."""
    groups: dict[int, tuple[float, list[tuple[int, int]]]] = {}
    for step, key in zip(row[keys >= 0].tolist(), keys[keys >= 0].tolist(), strict=True):
        _, members = groups.setdefault(key // base, (step, []))
        members.append((key % base // 2, 1 if key % 2 else -1))
    return [(step, tuple(members)) for step, members in groups.values()]


def _bounds_media(surface: Surface) -> bool:
    """Return whether a surface is a dielectric or names a medium."""
    return surface.material.boundary is not None or surface.front is not None or surface.back is not None


def _midpoints(steps: list[float], size: float) -> np.ndarray:
    """Distances before, between and behind the crossings."""
    ends = np.array([steps[0] - 2 * size, *steps, steps[-1] + 2 * size])
    return (ends[:-1] + ends[1:]) / 2
