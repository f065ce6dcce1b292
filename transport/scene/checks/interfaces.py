"""Checks of the media on both sides of each surface: named media, and matching refractive indices.

Surfaces are probed along some hundred fixed straight lines; anything smaller than their spacing may be
missed. Which bodies hold a point of a line is decided by inequalities; for closed meshes and bodies of open
surfaces (closed_bodies.py checks that they are closed) by the surfaces crossed before, as in the engine. Sides are not
judged where surfaces are closer than 1e-11 of the scene's size (and the rounding of their coordinates), nor
by lines that pass within 1e-9 of it of an edge or a tangent.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from transport.geometry.line_crossings import FACETS, LINES, crossed_in_turn, lines_through, size_of
from transport.geometry.mesh import Mesh
from transport.scene.bodies import Body, bits_at, sides_of, solid_of, surrounding_of
from transport.scene.materials import (
    AnyMedium,
    Dielectric,
    Surface,
    Transparent,
    lets_through,
    simple_parts,
    titled,
)
from transport.scene.media import plain
from transport.validation import SceneError, shown

if TYPE_CHECKING:
    from transport.scene.parts import SceneParts


class Crossed(NamedTuple):
    """Surfaces that a line crosses at one place, each with +1 if the line runs along the normal, else -1."""

    surfaces: tuple[tuple[int, int], ...]
    place: np.ndarray
    before: int  # bits of the bodies before and behind the crossing
    behind: int


def title_of(scene: SceneParts, number: int) -> str:
    """Name of a surface in messages."""
    return titled(scene.surfaces[number], number)


def check_sides(scene: SceneParts, bodies: tuple[Body, ...]) -> None:
    """Refuse named media that differ from what is there, and refractive indices that do not match."""
    seen = set()
    for crossed in _crossed_by_lines(scene, bodies):
        kind = crossed.surfaces, crossed.before, crossed.behind
        if kind in seen:
            continue
        seen.add(kind)
        media = [_medium_of(scene, bodies, bits) for bits in (crossed.before, crossed.behind)]
        if len(crossed.surfaces) == 1:
            ((number, way),) = crossed.surfaces
            _check_named(scene, bodies, number, way, crossed, media)
        _check_index(scene, crossed, media)


def _medium_of(scene: SceneParts, bodies: tuple[Body, ...], bits: int) -> AnyMedium:
    """Medium of the innermost body in a bit set; the surrounding medium if it is empty."""
    return bodies[(bits & -bits).bit_length() - 1].medium if bits else surrounding_of(scene)


def _check_named(scene, bodies, number: int, way: int, crossed: Crossed, media: list[AnyMedium]) -> None:
    """Refuse a surface whose named media are not there: neither its own body nor the same medium."""
    surface = scene.surfaces[number]
    sides = [(True, crossed.behind, media[1]), (False, crossed.before, media[0])]
    if way < 0:
        sides = [(True, crossed.before, media[0]), (False, crossed.behind, media[1])]
    for is_front, bits, found in sides:
        named = surface.front if is_front else surface.back
        if named is None:
            continue
        own = [k for k, body in enumerate(bodies) if (number, is_front) in body.faces]
        if not any(bits >> k & 1 for k in own) and found != plain(named):
            _refuse_named(scene, number, is_front, found, crossed.place)


def _refuse_named(
    scene: SceneParts, number: int, is_front: bool, found: AnyMedium, place: np.ndarray
) -> None:
    """Raise the SceneError for a named medium that is not there."""
    surface = scene.surfaces[number]
    side = _side(scene, number, is_front)
    where = ", ".join(f"{x:.6g}" for x in place)
    cure = f"leave {side} out: the medium outside comes from the body around, or from Scene(medium=...)"
    if not surface.shape.is_closed:
        cure = f"close the gaps between its surfaces, reverse its normal, or leave {side} out"
    named = shown(surface.front if is_front else surface.back)
    raise SceneError(
        f"Scene: {title_of(scene, number)}: {side} must be the medium there, {shown(found)} at ({where}),"
        f" got {named}; {cure}"
    )


def _side(scene: SceneParts, number: int, is_front: bool) -> str:
    """Name of a side of a surface in messages."""
    if scene.surfaces[number].shape.is_closed:
        return "outside" if is_front else "inside"
    return "front" if is_front else "back"


def _check_index(scene: SceneParts, crossed: Crossed, media: list[AnyMedium]) -> None:
    """Refuse a change of index without a Dielectric, and a Dielectric with other indices."""
    acting = [(k, way) for k, way in crossed.surfaces if scene.surfaces[k].material != Transparent()]
    if len(acting) > 1:
        return
    number, way = acting[0] if acting else crossed.surfaces[0]
    material = scene.surfaces[number].material
    glass = next((part for part in simple_parts(material) if isinstance(part, Dielectric)), None)
    inside, outside = media if way > 0 else media[::-1]
    there = inside.index, outside.index
    words = f"Dielectric({there[0]:g}, {there[1]:g})"
    where = ", ".join(f"{x:.6g}" for x in crossed.place)
    if glass is None and lets_through(material) and there[0] != there[1]:
        must = (
            f"material must be a Dielectric between {shown(inside)} behind it and {shown(outside)} in front"
        )
        raise SceneError(
            f"Scene: {title_of(scene, number)}: {must}, at ({where}), got {shown(material)}; write {words}"
        )
    if glass is not None and there != (glass.index_inside, glass.index_outside):
        is_inside = there[0] != glass.index_inside
        medium, index = (inside, glass.index_inside) if is_inside else (outside, glass.index_outside)
        side = _side(scene, number, not is_inside)
        named = "Vacuum()" if index == 1 else f"Medium(index={index:g})"
        cure = f"name the medium there, {side}={named}, or write {words}"
        raise SceneError(
            f"Scene: {title_of(scene, number)}: {shown(glass)} contradicts the medium {side}, {shown(medium)}"
            f" of index {medium.index:g}, at ({where}); {cure}"
        )


def _crossed_by_lines(scene: SceneParts, bodies: tuple[Body, ...]) -> Iterator[Crossed]:
    """Crossings of straight lines through the bounding surfaces, with the bodies before and behind each."""
    shapes = [surface.shape for surface in scene.surfaces]
    aimed = [surface.shape for surface in scene.surfaces if _bounds_media(surface)]
    if not aimed:
        return
    # Choose the lines and find all their crossings.
    size = size_of(shapes)
    facets = sum(shape.triangles for shape in shapes if isinstance(shape, Mesh))
    count = max(4, min(max(LINES, 4 * len(aimed)), FACETS // max(4 * facets, 1)))
    origins, ways = lines_through(aimed, count, size)
    places, keys = crossed_in_turn(shapes, origins, ways, size)
    base = 2 * len(shapes)
    # Group coincident crossings, and take a point between each pair of groups.
    lines = [_groups(row, key, base) for row, key in zip(places, keys, strict=True)]
    kept = [k for k, groups in enumerate(lines) if groups]
    between = [_between([step for step, _ in lines[k]], size) for k in kept]
    points = [origins[k] + steps[:, None] * ways[k] for k, steps in zip(kept, between, strict=True)]
    # Find the bodies at these points: solids by inequalities, others by the surfaces crossed.
    solids = [number for number, body in enumerate(bodies) if solid_of(scene, body) is not None]
    crossed = sum(1 << number for number in range(len(bodies)) if number not in solids)
    sides = [[sum(1 << number for number in side) & crossed for side in pair] for pair in sides_of(scene)]
    bits = iter(bits_at(scene, np.concatenate(points), solids).tolist() if points else [])
    for k in kept:
        before, held = next(bits), 0  # bits of bodies of surfaces: none before the first crossing
        for step, surfaces in lines[k]:
            behind = next(bits)
            was_held = held
            for number, way in surfaces:
                front, back = sides[number]
                held = held & ~(front | back) | (front if way > 0 else back)
            yield Crossed(surfaces, origins[k] + step * ways[k], before | was_held, behind | held)
            before = behind


def _groups(row: np.ndarray, keys: np.ndarray, base: int) -> list[tuple[float, tuple[tuple[int, int], ...]]]:
    """Crossings of one line in order: distance [m], and the surfaces that coincide there."""
    groups: dict[int, tuple[float, list[tuple[int, int]]]] = {}
    for step, key in zip(row[keys >= 0].tolist(), keys[keys >= 0].tolist(), strict=True):
        _, members = groups.setdefault(key // base, (step, []))
        members.append((key % base // 2, 1 if key % 2 else -1))
    return [(step, tuple(members)) for step, members in groups.values()]


def _bounds_media(surface: Surface) -> bool:
    """Whether a surface is a dielectric or names a medium."""
    is_glass = any(isinstance(part, Dielectric) for part in simple_parts(surface.material))
    return is_glass or surface.front is not None or surface.back is not None


def _between(steps: list[float], size: float) -> np.ndarray:
    """Distances before, between and behind the crossings."""
    ends = np.array([steps[0] - 2 * size, *steps, steps[-1] + 2 * size])
    return (ends[:-1] + ends[1:]) / 2
