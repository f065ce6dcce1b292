"""Refuse light that can neither be absorbed nor escape, where geometry proves it.

Enclosures are closed shapes, cells between infinite planes, and open surfaces whose rims join without a gap (the faces of a
box, a cylinder with its lids).  What is not proven here is stopped while it runs (`engine/driver.py`, TRAPPED).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from transport.bodies.filling import absorbs, glowing_sources
from transport.bodies.regions import WAYS
from transport.materials import (
    Black,
    Diffuse,
    Glossy,
    Material,
    Mirror,
    Surface,
    Transparent,
    TwoSided,
    lets_through,
    simple_parts,
)
from transport.materials.surface import titled
from transport.shapes import Disk, FlatShape, Mesh, Plane, Rectangle, Revolved, Shape, Slab, Sphere, Triangle
from transport.shapes.base import ROUNDING
from transport.shapes.crossings import crossings
from transport.shapes.distances import is_behind, least_distance
from transport.shapes.supports import rounding_of
from transport.validation import SceneError
from transport.vectors import Vector, dot

if TYPE_CHECKING:
    from transport.scene import Scene
    from transport.sources import Source

STEP = 1e-6  # of a flat source's extent: how far in front of it its light is looked for
MOST_RIMS = 512  # that are compared with one another
NAMED = 6  # surfaces that a message names


class Enclosure(NamedTuple):
    """Surfaces, by their numbers, that let nothing out of a region; planes: the sides that face the region."""

    kind: str  # "shape", "planes" or "patches"
    numbers: tuple[int, ...]
    shapes: tuple[Shape, ...]
    sides: tuple[str, ...] = ()

    def may_reach(self, shape: Shape) -> bool:
        """Whether a shape may have a part in the region."""
        if self.kind == "planes":
            beyond = zip(self.shapes, self.sides, strict=True)
            return not any(is_behind(shape, plane, side) for plane, side in beyond)
        low, high = (np.array(corner) for corner in shape.bounds)
        bounds = np.array([each.bounds for each in self.shapes])
        return bool((low <= bounds[:, 1].max(axis=0)).all() and (bounds[:, 0].min(axis=0) <= high).all())


def check_endless(scene: Scene) -> None:
    """Refuse a scene in which some histories of a source can never end.  Raises SceneError."""
    if scene.duration is not None or absorbs(scene.medium):
        return
    walls = {
        number: surface
        for number, surface in enumerate(scene.surfaces)
        if not all(_is_lossy(surface.material, is_back) for is_back in (False, True))
    }
    if not walls:
        return
    fixed = [*_closed_shapes(walls), *_joined_patches(walls)]
    for source in (*scene.sources, *(glow for _, glow in glowing_sources(scene))):
        origin = scene.shape_of(source)
        start = _start(source, origin)
        cells = _cell_of_planes(walls, start) if _spreads(scene, source) else ()
        for enclosure in (*fixed, *cells):
            if _starts_in(enclosure, source, origin, start) and not _has_absorber(scene, enclosure):
                raise SceneError(
                    f"Scene: nothing absorbs {_place(scene, enclosure)} and nothing escapes from there; give a surface there"
                    " an albedo or reflectance below 1, or the scene a duration"
                )


def _place(scene: Scene, enclosure: Enclosure) -> str:
    """Where the light is kept, in words."""
    names = [titled(scene.surfaces[number], number) for number in enclosure.numbers[:NAMED]]
    names += ["others"] * (len(enclosure.numbers) > NAMED)
    word = "between" if enclosure.kind == "planes" else "inside"
    return f"{word} {' and '.join(filter(None, [', '.join(names[:-1]), names[-1]]))}"


# ---- what ends light ----


def _has_absorber(scene: Scene, enclosure: Enclosure) -> bool:
    """Whether a surface or a medium may absorb in the region; a medium beside an open surface may be anywhere."""
    for number, surface in enumerate(scene.surfaces):
        may_reach = enclosure.may_reach(surface.shape)
        if absorbs(surface.front) or (absorbs(surface.back) and (may_reach or not surface.shape.is_closed)):
            return True
        if may_reach and number not in enclosure.numbers and _absorbs(surface.material):
            return True
    return False


def _is_lossy(material: Material, is_back: bool) -> bool:
    """Whether some of what arrives at a side is absorbed or goes through."""
    if isinstance(material, TwoSided):
        material = material.back if is_back else material.front
    return lets_through(material) or _absorbs(material)


def _absorbs(material: Material) -> bool:
    """Whether some of what arrives ends there."""
    return any(_kept(part) > 0 for part in simple_parts(material))


def _kept(material: Material) -> float:
    """The share of what arrives that a simple material absorbs."""
    match material:
        case Black():
            return 1.0
        case Diffuse(albedo=share, transmission=passed) | Mirror(reflectance=share, transmission=passed):
            return 1 - (share + passed)
        case Glossy(albedo=share):
            return 1 - share
    return 0.0


# ---- where light starts ----


def _start(source: Source, origin: Shape) -> Vector:
    """A place of a source, or just in front of it: its middle."""
    if not (source.emission.has_side and isinstance(origin, FlatShape)):
        return origin.middle
    step = STEP * origin.extent * (-1 if source.is_back else 1)
    return tuple(p + step * n for p, n in zip(origin.middle, origin.normal, strict=True))


def _spreads(scene: Scene, source: Source) -> bool:
    """Whether almost all of a source's particles come to planes again and again.

    A beam may run along them for ever, at once or after a mirror: only between two planes alone is it known to meet them.
    """
    direction = getattr(source.emission, "direction", None)
    if direction is None:
        return True
    acting = [s for s in scene.surfaces if s.material != Transparent()]
    is_alone = len(acting) == 2 and all(isinstance(s.shape, Plane) for s in acting)
    return is_alone and all(abs(dot(s.shape.normal, direction)) > ROUNDING for s in acting)


def _starts_in(enclosure: Enclosure, source: Source, origin: Shape, start: Vector) -> bool:
    """Whether some of a source's particles surely start in the region: in its middle, or all of them."""
    if enclosure.kind == "shape" and origin == enclosure.shapes[0] and source.emission.has_side:
        return source.is_back
    if not _holds(enclosure, start):
        return False
    is_volume = not source.emission.has_side
    if least_distance(origin, origin.middle, filled=is_volume) == 0:
        return True
    return all(least_distance(shape, origin.middle) >= origin.extent for shape in enclosure.shapes)


def _holds(enclosure: Enclosure, point: Vector) -> bool:
    """Whether a point lies in the region."""
    if enclosure.kind == "planes":
        return True  # of which it is made
    if enclosure.kind == "patches":
        return _is_between(enclosure.shapes, point)
    shape = enclosure.shapes[0]
    match shape:
        case Sphere():
            return math.dist(point, shape.center) < shape.radius
        case Slab():
            offset = tuple(p - c for p, c in zip(point, shape.center, strict=True))
            return abs(dot(offset, shape.normal)) < shape.thickness / 2
        case Mesh():
            return shape.holds(point)
    return all(low < x < high for low, x, high in zip(shape.bounds[0], point, shape.bounds[1], strict=True))


def _is_between(shapes: tuple[Shape, ...], point: Vector) -> bool:
    """Whether all of a few lines from a point cross closed patches an odd number of times."""
    ways = WAYS / np.linalg.norm(WAYS, axis=1)[:, None]
    origins = np.tile(np.array(point, float), (len(ways), 1))
    crossed = sum((crossings(shape, origins, ways).distances > 0).sum(axis=1) for shape in shapes)
    return bool((crossed % 2 == 1).all())


# ---- enclosures ----


def _closed_shapes(walls: dict[int, Surface]) -> Iterator[Enclosure]:
    for number, surface in walls.items():
        if surface.shape.is_closed and not _is_lossy(surface.material, is_back=True):
            yield Enclosure("shape", (number,), (surface.shape,))


def _cell_of_planes(walls: dict[int, Surface], point: Vector) -> Iterator[Enclosure]:
    """The cell between planes that holds a point, if light has no way out of it but exactly along the planes."""
    numbers, sides = [], []
    for number, surface in walls.items():
        if isinstance(surface.shape, Plane):
            height = dot(
                tuple(p - c for p, c in zip(point, surface.shape.center, strict=True)), surface.shape.normal
            )
            if height != 0 and not _is_lossy(surface.material, is_back=height < 0):
                numbers.append(number)
                sides.append("front" if height > 0 else "back")
    planes = tuple(walls[number].shape for number in numbers)
    signs = [1.0 if side == "front" else -1.0 for side in sides]
    normals = np.array([plane.normal for plane in planes]).reshape(-1, 3) * np.array(signs)[:, None]
    if _leave_no_way(normals):
        yield Enclosure("planes", tuple(numbers), planes, tuple(sides))


def _leave_no_way(normals: np.ndarray) -> bool:
    """Whether no direction leads away from all planes with these normals (n, 3) towards the cell.

    By Gordan's theorem: whether some of them, not all with weight 0, add up to nothing.
    """
    if any(math.dist(one, -other) <= ROUNDING for one, other in combinations(normals, 2)):
        return True
    if len(normals) < 3:
        return False
    from scipy.optimize import nnls

    must = np.append(np.zeros(3), 1.0)
    _, distance = nnls(np.vstack([normals.T, np.ones(len(normals))]), must)
    return bool(distance <= len(normals) * ROUNDING)


def _joined_patches(walls: dict[int, Surface]) -> Iterator[Enclosure]:
    """Sets of open surfaces whose every rim is the rim of one other surface of the set, so that no gap is left."""
    rims: dict[int, list[Rim]] = {}
    for number, surface in walls.items():
        is_white = not any(_is_lossy(surface.material, is_back) for is_back in (True, False))
        if is_white and (found := rims_of(surface.shape)):
            rims[number] = found
    every = [(number, rim) for number, found in rims.items() for rim in found]
    if len(every) > MOST_RIMS:
        return
    partners: dict[int, list[int]] = {number: [] for number in rims}
    for (one, rim), (other, its) in combinations(every, 2):
        if rim.is_same(its, 4 * rounding_of(walls[one].shape, walls[other].shape)):
            partners[one].append(other)
            partners[other].append(one)
    left = set(rims)
    while left:
        joined, new = set(), {min(left)}
        while new:
            joined |= new
            new = {other for number in new for other in partners[number]} - joined
        left -= joined
        if all(len(partners[number]) == len(rims[number]) for number in joined):
            numbers = tuple(sorted(joined))
            yield Enclosure("patches", numbers, tuple(walls[number].shape for number in numbers))


class Rim(NamedTuple):
    """An edge of an open surface: a segment, with half its way, or a circle, with its radius along the axis [m]."""

    kind: str
    center: Vector
    span: Vector

    def is_same(self, other: Rim, tolerance: float) -> bool:
        """Whether two rims are one, either way round, up to a distance [m]."""
        if self.kind != other.kind or math.dist(self.center, other.center) > tolerance:
            return False
        turned = tuple(-x for x in other.span)
        return min(math.dist(self.span, other.span), math.dist(self.span, turned)) <= tolerance


def rims_of(shape: Shape) -> list[Rim]:
    """The rims of an open surface of finite size; none where they are not known."""
    match shape:
        case Rectangle(hole=None, frame=(e_u, e_v, _), width=width, height=height):
            corners = [
                tuple(
                    c + a * width / 2 * u + b * height / 2 * v
                    for c, u, v in zip(shape.center, e_u, e_v, strict=True)
                )
                for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))
            ]
            return _segments(corners)
        case Triangle(vertices=corners):
            return _segments(list(corners))
        case Disk(inner_radius=0):
            return [Rim("circle", shape.center, tuple(shape.radius * x for x in shape.normal))]
        case Revolved(is_closed=False, profile=profile, frame=(_, _, axis)):
            found = []
            for height in (profile.low, profile.high):
                radius = profile.radius_at(height)
                center = tuple(p + height * n for p, n in zip(profile.origin, axis, strict=True))
                found += [Rim("circle", center, tuple(radius * x for x in axis))] if radius > 0 else []
            return found
    return []


def _segments(corners: list[Vector]) -> list[Rim]:
    """The sides of a polygon."""
    pairs = zip(corners, corners[1:] + corners[:1], strict=True)
    return [
        Rim(
            "segment",
            tuple((a + b) / 2 for a, b in zip(p, q, strict=True)),
            tuple((b - a) / 2 for a, b in zip(p, q, strict=True)),
        )
        for p, q in pairs
    ]
