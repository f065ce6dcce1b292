"""Refuse scenes in which light can neither be absorbed nor escape, as far as geometry proves it.

Enclosures are closed shapes, cells between infinite planes, and open surfaces whose rims join without a gap
(the faces of a box, a cylinder with its lids). Endless histories that are not proven here are stopped during
the run (`PATIENCE` of `engine/driver.py`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from transport.geometry.line_crossings import crossings
from transport.geometry.neighbours import touching_boxes
from transport.geometry.relations import are_on_one_support, boxes_meet, encloses, is_behind, point_beside
from transport.geometry.shape import ROUNDING, Shape
from transport.scene.bodies import TEST_DIRECTIONS
from transport.scene.checks.overlapping_bodies import absorbs, emitting_bodies_as_sources
from transport.scene.materials import Material, Surface, Transparent
from transport.scene.parts import join_surface_names
from transport.scene.sides import OTHER_SIDE
from transport.validation import SceneError
from transport.vectors import Vector, dot

if TYPE_CHECKING:
    from transport.scene.parts import SceneParts
    from transport.scene.sources import Source

ShapeOrPoint = Shape | Vector


class ClosedShape(NamedTuple):
    """Interior of a closed shape."""

    numbers: tuple[int, ...]
    shapes: tuple[Shape, ...]
    word = "inside"

    @property
    def is_infinite(self) -> bool:
        """Whether the region is infinite in some direction."""
        return self.shapes[0].is_infinite

    def holds(self, place: ShapeOrPoint) -> bool:
        """Return whether a shape or a point surely lies wholly in the region."""
        return encloses(self.shapes[0], place)

    def excludes(self, place: Shape) -> bool:
        """Return whether a shape surely lies wholly outside the region."""
        distance = self.shapes[0].distance(place.middle, filled=True)
        return not place.is_infinite and distance > place.extent

    def may_reach(self, shape: Shape) -> bool:
        """Return whether part of a shape may lie in the region."""
        return boxes_meet(shape, *self.shapes)


class ClosedPatches(NamedTuple):
    """Region that open surfaces enclose together."""

    numbers: tuple[int, ...]
    shapes: tuple[Shape, ...]
    word, is_infinite = "in the room of", False

    def holds(self, place: ShapeOrPoint) -> bool:
        """Return whether a shape or a point surely lies wholly in the region."""
        if not isinstance(place, Shape):
            return _is_between(self.shapes, place)
        if self._is_apart(place):
            return _is_between(self.shapes, place.middle)
        return self._are_behind((*self.shapes, place))  # touching the walls of a convex room

    def excludes(self, place: Shape) -> bool:
        """Return whether a shape surely lies wholly outside the region."""
        return self._is_apart(place) and not _is_between(self.shapes, place.middle)

    def _are_behind(self, shapes: tuple[Shape, ...]) -> bool:
        """Return whether the walls are flat, and no shape extends beyond one of them."""
        if not all(wall.is_flat for wall in self.shapes):
            return False
        outer = [
            "back" if self.holds(point_beside(wall, False, self.shapes)) else "front" for wall in self.shapes
        ]
        sided = list(zip(self.shapes, outer, strict=True))
        return all(is_behind(shape, wall, side) for wall, side in sided for shape in shapes)

    def _is_apart(self, place: Shape) -> bool:
        """Return whether the bounding sphere of a shape touches no patch."""
        if place.is_infinite:
            return False
        return all(shape.distance(place.middle) > place.extent for shape in self.shapes)

    def may_reach(self, shape: Shape) -> bool:
        """Return whether part of a shape may lie in the region."""
        return boxes_meet(shape, *self.shapes)


class PlaneCell(NamedTuple):
    """Region between planes; sides: those that face the region, which is built around a point in it."""

    numbers: tuple[int, ...]
    shapes: tuple[Shape, ...]
    sides: tuple[str, ...]
    word, is_infinite = "between", True

    def holds(self, place: ShapeOrPoint) -> bool:
        """Return whether a shape surely lies wholly in the region; always true for a point."""
        faces = zip(self.shapes, self.sides, strict=True)
        return not isinstance(place, Shape) or all(
            is_behind(place, plane, OTHER_SIDE[side]) for plane, side in faces
        )

    def may_reach(self, shape: Shape) -> bool:
        """Return whether part of a shape may lie in the region."""
        return not any(
            is_behind(shape, plane, side) for plane, side in zip(self.shapes, self.sides, strict=True)
        )


Enclosure = ClosedShape | ClosedPatches | PlaneCell


def check_lossless_enclosures(scene: SceneParts) -> None:
    """Raise SceneError if some histories of a source can never end."""
    if scene.duration is not None or absorbs(scene.medium):
        return
    # Keep the surfaces that neither absorb nor transmit on at least one side.
    walls = {
        number: surface
        for number, surface in enumerate(scene.surfaces)
        if not all(_is_lossy(surface.material, is_back) for is_back in (False, True))
    }
    if not walls:
        return
    # Look for a lossless enclosure around each source, without an absorber in it.
    fixed = [room for room in finite_enclosures(walls) if _is_lossless_inside(room, walls)]
    for source in (*scene.sources, *(glow for _, glow in emitting_bodies_as_sources(scene))):
        origin = scene.shape_of(source)
        for enclosure in (*fixed, *_cell_of_planes(walls, _start_point(source, origin, walls.values()))):
            is_sure = not enclosure.is_infinite or _hits_planes_repeatedly(scene, source)
            if is_sure and _starts_in(enclosure, source, origin) and not _has_absorber(scene, enclosure):
                raise SceneError(
                    f"Scene: nothing absorbs {_region_name(scene, enclosure)} and nothing escapes from there;"
                    " give a surface there an albedo or reflectance below 1, or the scene a duration"
                )


def _region_name(scene: SceneParts, enclosure: Enclosure) -> str:
    """Description of the region in messages."""
    return f"{enclosure.word} {join_surface_names(scene, enclosure.numbers)}"


# ---- absorption ----


def _has_absorber(scene: SceneParts, enclosure: Enclosure) -> bool:
    """Return whether anything may absorb in the region; a medium beside an open surface may be anywhere."""
    for number, surface in enumerate(scene.surfaces):
        may_reach = enclosure.may_reach(surface.shape)
        if absorbs(surface.front) or (absorbs(surface.back) and (may_reach or not surface.shape.is_closed)):
            return True
        if may_reach and number not in enclosure.numbers and surface.material.absorbs:
            return True
    return False


def _is_lossy(material: Material, is_back: bool) -> bool:
    """Return whether a side absorbs or transmits some of the incident light."""
    side = material.sides[is_back]
    return side.is_transmissive or side.absorbs


# ---- starting points ----


def _start_point(source: Source, origin: Shape, walls: Iterable[Surface]) -> Vector:
    """Middle of a source; for a flat one, which may lie on a wall, a point just in front of it."""
    is_sided = source.emission.has_side and origin.is_flat
    return point_beside(origin, source.is_back, (w.shape for w in walls)) if is_sided else origin.middle


def _hits_planes_repeatedly(scene: SceneParts, source: Source) -> bool:
    """Return whether almost all of a source's particles reach the planes again and again.

    A beam may run along the planes forever, at once or after a mirror: only between two planes alone it
    surely meets them.
    """
    direction = getattr(source.emission, "direction", None)
    if direction is None:
        return True
    acting = [s for s in scene.surfaces if s.material != Transparent()]
    is_alone = len(acting) <= 2 and all(s.shape.is_infinite for s in acting)
    return is_alone and all(abs(dot(s.shape.normal, direction)) > ROUNDING for s in acting)


def _starts_in(enclosure: Enclosure, source: Source, origin: Shape) -> bool:
    """Return whether some of a source's particles surely start in the region: at its middle, or all."""
    is_sided = source.emission.has_side
    if is_sided and isinstance(enclosure, ClosedShape) and are_on_one_support(origin, enclosure.shapes[0]):
        return source.is_back
    is_there = origin.distance(origin.middle, filled=not is_sided) == 0
    if is_sided and origin.is_flat:
        start = point_beside(origin, source.is_back, enclosure.shapes)
        return enclosure.holds(start) and (is_there or enclosure.holds(origin))
    return enclosure.holds(origin.middle if is_there else origin)


def _is_between(shapes: tuple[Shape, ...], point: Vector) -> bool:
    """Return whether all of a few lines from a point cross closed patches an odd number of times."""
    directions = TEST_DIRECTIONS / np.linalg.norm(TEST_DIRECTIONS, axis=1)[:, None]
    origins = np.tile(np.array(point, float), (len(directions), 1))
    crossed = sum((crossings(shape, origins, directions).distances > 0).sum(axis=1) for shape in shapes)
    return bool((crossed % 2 == 1).all())


# ---- enclosures ----


def finite_enclosures(surfaces: dict[int, Surface]) -> list[ClosedShape | ClosedPatches]:
    """Finite regions that surfaces, by index, enclose: one surface alone, or several without a gap."""
    closed = [
        ClosedShape((number,), (surface.shape,))
        for number, surface in surfaces.items()
        if surface.shape.is_closed
    ]
    return closed + list(_closed_patches(surfaces))


def _is_lossless_inside(room: ClosedShape | ClosedPatches, walls: dict[int, Surface]) -> bool:
    """Return whether the walls of a room return all light that arrives from inside."""
    for number, shape in zip(room.numbers, room.shapes, strict=True):
        sides = (True,) if isinstance(room, ClosedShape) else (False, True)
        if shape.is_flat:
            sides = (not room.holds(point_beside(shape, False, room.shapes)),)
        if any(_is_lossy(walls[number].material, is_back) for is_back in sides):
            return False
    return True


def _cell_of_planes(walls: dict[int, Surface], point: Vector) -> Iterator[Enclosure]:
    """Cell between planes around a point, if light can leave it only exactly along the planes."""
    numbers, sides = [], []
    for number, surface in walls.items():
        if surface.shape.is_plane:
            height = surface.shape.height_of(point)
            if height != 0 and not _is_lossy(surface.material, is_back=height < 0):
                numbers.append(number)
                sides.append("front" if height > 0 else "back")
    planes = tuple(walls[number].shape for number in numbers)
    signs = [1.0 if side == "front" else -1.0 for side in sides]
    normals = np.array([plane.normal for plane in planes]).reshape(-1, 3) * np.array(signs)[:, None]
    if _close_all_directions(normals):
        yield PlaneCell(tuple(numbers), planes, tuple(sides))


def _close_all_directions(normals: np.ndarray) -> bool:
    """Return whether no direction leads away from all planes with these normals (n, 3) towards the cell.

    By Gordan's theorem this holds if some of the normals, with weights not all 0, sum to zero.
    """
    if any(math.dist(one, -other) <= ROUNDING for one, other in combinations(normals, 2)):
        return True
    if len(normals) < 3:
        return False
    from scipy.optimize import nnls

    must = np.append(np.zeros(3), 1.0)
    _, distance = nnls(np.vstack([normals.T, np.ones(len(normals))]), must)
    return bool(distance <= 8 * ROUNDING)


def _closed_patches(surfaces: dict[int, Surface]) -> Iterator[ClosedPatches]:
    """Sets of open surfaces without gaps: every rim is shared by exactly one other surface."""
    found = {number: surface.shape.rims() for number, surface in surfaces.items()}
    shapes = {number: surfaces[number].shape for number, its in found.items() if its}
    if not shapes:
        return
    # List all rims with their surfaces.
    owners = np.array([number for number, its in found.items() for _ in its], int)
    rims = [rim for its in found.values() for rim in its]
    centers, spans = (
        np.array([getattr(rim, name) for rim in rims]).reshape(-1, 3) for name in ("center", "span")
    )
    is_circle = np.array([rim.is_circle for rim in rims], bool)
    slack = 4 * ROUNDING * np.array([shapes[number].coordinate_scale for number in owners.tolist()])
    # Find equal rims of other surfaces.
    reach = 2 * slack[:, None]
    partners: list[list[int]] = []
    for k, near in enumerate(touching_boxes(centers - reach, centers + reach)):
        tolerance = slack[near] + slack[k]
        directions = np.minimum(*(np.abs(spans[near] - sign * spans[k]).max(axis=1) for sign in (1, -1)))
        is_same = (np.abs(centers[near] - centers[k]).max(axis=1) <= tolerance) & (directions <= tolerance)
        is_same &= (is_circle[near] == is_circle[k]) & (owners[near] != owners[k])
        partners.append(near[is_same].tolist())
    # Grow connected sets; keep those in which every rim has exactly one partner.
    rows: dict[int, list[int]] = {number: [] for number in shapes}
    for k, number in enumerate(owners.tolist()):
        rows[number].append(k)
    left = set(shapes)
    for number in shapes:
        joined, new = set(), {number} & left
        while new:
            joined |= new
            new = {int(owners[n]) for number in new for k in rows[number] for n in partners[k]} - joined
        left -= joined
        if joined and all(len(partners[k]) == 1 for number in joined for k in rows[number]):
            numbers = tuple(sorted(joined))
            yield ClosedPatches(numbers, tuple(shapes[number] for number in numbers))
