"""Sheets: shapes on one support (plane, sphere, cylinder ...) form one sheet; a mesh is its own sheet.

A particle remembers the sheet on which it stands, so that rounding never decides between a detector and the
wall it lies on, a source and its floor, or two adjacent patches. On each side of each point of a sheet at
most one surface acts. Opaque surfaces may share part of a plane if one of them is a face of a Box: furniture
on a floor (`members_by_side`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from transport.geometry.neighbours import Supports, touching_boxes
from transport.geometry.relations import are_on_one_support, is_on_support, overlap, relative_orientation
from transport.geometry.shape import ROUNDING, Point, Shape
from transport.geometry.solid import Box
from transport.scene.bodies import bodies_on_sides, has_media
from transport.scene.detectors import Detector
from transport.scene.materials import Surface
from transport.vectors import Vector

if TYPE_CHECKING:
    from transport.scene.parts import SceneParts


@dataclass
class SheetMember:
    """Piece of a sheet: its acting surface (None: transparent) and the detectors on it."""

    shape: Shape
    surface: Surface | None
    detectors: list[Detector] = field(default_factory=list)
    orientation: float = 1.0  # sign of its normal relative to the sheet's
    mark: str | None = None  # name of the surface if a detector's `via` refers to it
    whole: Shape | None = None  # shape of which it is a piece
    bodies: tuple[int, int] = (0, 0)  # bits of the bodies just in front and just behind


@dataclass
class Sheet:
    """Members on one support; the first one defines the sheet's normal."""

    members: list[SheetMember]

    @property
    def support(self) -> Shape:
        """Shape that defines the support."""
        return self.members[0].shape


def scene_sheets(scene: SceneParts) -> list[Sheet]:
    """Sheets of the scene, acting members before detectors, without surfaces that have no effect.

    A member that is on two sheets within rounding makes them one.
    """
    known: list[tuple[Shape, Sheet]] = []  # supports by number, and the sheet of each
    members = sorted(_members(scene), key=_precedence)
    origin = _origin_of_rays(scene)
    far = max((sum(map(abs, _seen_from(origin, member.shape))) for member in members), default=0.0)
    supports = Supports([member.shape for member in members], far)
    for member in members:
        near = (known[number] for number in supports.near(member.shape))
        homes = {id(sheet): sheet for on, sheet in near if _are_on_one_sheet(on, member.shape, origin)}
        if not homes:
            sheet = Sheet([])
            supports.add(len(known), member.shape)
            known.append((member.shape, sheet))
            homes = {id(sheet): sheet}
        home, *others = homes.values()
        home.members += [*chain.from_iterable(other.members for other in others), member]
        if others:
            known = [(on, home if id(sheet) in homes else sheet) for on, sheet in known]
        for each in home.members if others else [member]:
            each.orientation = relative_orientation(home.support, each.shape)
    return list({id(sheet): sheet for _, sheet in known}.values())


def located_shapes(scene: SceneParts) -> list[Shape]:
    """Shapes of all objects of a scene; of infinite ones their planes."""
    shapes = [surface.shape for surface in scene.surfaces]
    shapes = [piece for shape in shapes for piece in (shape.pieces() if shape.is_infinite else (shape,))]
    shapes += [scene.shape_of(user) for user in (*scene.sources, *scene.meters, *scene.volumes)]
    shapes += [source.aim for source in scene.sources if source.aim is not None]
    return shapes + [Point(position=detector.position) for detector in scene.points]


def scene_origin(shapes: list[Shape]) -> Vector:
    """Origin [m] of the coordinates in which a scene is simulated: the middle of the smallest shape."""
    return min(shapes, key=lambda shape: (isinstance(shape, Point), shape.extent)).middle


def _origin_of_rays(scene: SceneParts) -> Vector:
    """Return the place [m] from which planes are compared: rays from there cannot tell them closer apart.

    That is the origin of the scene's coordinates; beside planes alone, the farthest point.
    """
    shapes = located_shapes(scene)
    origin = scene_origin(shapes)
    finite = [shape for shape in shapes if not shape.is_infinite]
    if not all(isinstance(shape, Point) for shape in finite):
        return origin
    return max((shape.middle for shape in finite), key=lambda place: math.dist(place, origin), default=origin)


def _are_on_one_sheet(support: Shape, shape: Shape, origin: Vector) -> bool:
    """Return whether a shape is on a support within rounding; of two planes, also as seen from the origin."""
    if are_on_one_support(support, shape):
        return True
    if not (support.is_plane and shape.is_plane):
        return False
    return are_on_one_support(*(replace(each, center=_seen_from(origin, each)) for each in (support, shape)))


def _seen_from(origin: Vector, shape: Shape) -> Vector:
    """Return the middle of a shape, measured from the origin."""
    return tuple(c - o for c, o in zip(shape.middle, origin, strict=True))


def _precedence(member: SheetMember) -> tuple[bool, float]:
    """Sort key: acting members first, then those that define the support most accurately."""
    return member.surface is None, -member.shape.support_breadth


def _members(scene: SceneParts) -> Iterator[SheetMember]:
    """All members: pieces of surfaces with detectors and bodies, and detectors with their own shapes."""
    bounds = bodies_on_sides(scene) if has_media(scene) else [((), ())] * len(scene.surfaces)
    visited = set(scene.visited)
    on_surface: dict[str | None, list[Detector]] = {}  # by the surface's name
    for detector in scene.meters:
        if isinstance(detector.shape, str):
            on_surface.setdefault(detector.shape, []).append(detector)
    for surface, sides in zip(scene.surfaces, bounds, strict=True):
        looking = on_surface.get(surface.name, [])
        acts = surface.material.acts
        mark = surface.name if surface.name in visited else None
        front, back = (sum(1 << body for body in side) for side in sides)
        if acts or looking or mark is not None or front != back:
            for piece in surface.shape.pieces():
                whole, bodies = surface.shape, (front, back)
                yield SheetMember(piece, surface if acts else None, list(looking), 1.0, mark, whole, bodies)
    for detector in scene.meters:
        if isinstance(detector.shape, Shape):
            for piece in detector.shape.pieces():
                yield SheetMember(piece, None, [detector], whole=detector.shape)


# ---- Surfaces that share part of a plane.


def _near_pairs(members: list[SheetMember]) -> Iterator[tuple[SheetMember, SheetMember]]:
    """Yield each member with those before it whose bounding boxes it touches, within rounding."""
    if len(members) < 2:
        return
    low, high = np.array([member.shape.bounds for member in members]).transpose(1, 0, 2)
    gap = 64 * ROUNDING * max(member.shape.coordinate_scale for member in members)
    for k, near in enumerate(touching_boxes(low - gap, high)):
        yield from ((members[k], members[other]) for other in near[near < k].tolist())


def shared_planes(sheet: Sheet) -> Iterator[tuple[SheetMember, SheetMember]]:
    """Yield pairs of acting members of a sheet that have more than an edge in common."""
    acting = [member for member in sheet.members if member.surface is not None]
    yield from ((one, other) for one, other in _near_pairs(acting) if overlap(one.shape, other.shape))


def is_closed_face(member: SheetMember) -> bool:
    """Return whether a member is a face of a closed surface, whose normal points outwards."""
    return member.surface is not None and isinstance(member.whole, Box)


def members_by_side(sheet: Sheet) -> list[tuple[int, float]]:
    """Return the members of a sheet, by number, in the order in which the first that a ray meets acts.

    With each comes the side of its own normal on which it acts, 0 for both. Where surfaces share part of a
    plane, on each side the face of a Box comes first whose inner side it is, of two the smaller one; then
    open surfaces; then faces whose outer side it is, of two the larger one.
    """
    if not any(map(is_closed_face, sheet.members)):
        return [(number, 0.0) for number in range(len(sheet.members))]
    sharing = {id(member) for pair in shared_planes(sheet) for member in pair}
    entries: list[tuple[tuple[int, float], int, float]] = []
    for number, member in enumerate(sheet.members):
        if id(member) in sharing and is_closed_face(member):
            size = member.whole.extent
            entries += [((0, size), number, -1.0), ((2, -size), number, 1.0)]
        else:
            entries.append(((1 if member.surface is not None else 3, 0.0), number, 0.0))
    return [(number, side) for _, number, side in sorted(entries)]


def source_sheets(shape: Shape, sheets: list[Sheet]) -> list[int]:
    """Numbers, from 1, of the sheets on which a source's shape or point lies."""
    return [
        number
        for number, sheet in enumerate(sheets, start=1)
        if (
            is_on_support(shape.position, sheet.support)
            if isinstance(shape, Point)
            else are_on_one_support(shape, sheet.support)
        )
    ]
