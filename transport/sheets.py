"""Sheets: shapes on one support (the same plane, the same sphere) form one sheet.

A particle remembers the sheet that it stands on, so a meter on a wall, a source on a floor and two patches side by side
are never a tie of roundings.  Over one point of a sheet at most one surface may act.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from transport.detectors import Detector
from transport.materials import Surface, Transparent
from transport.shapes import Box, Disk, Point, Rectangle, Shape, Sphere, Triangle
from transport.shapes.distances import in_plane_distances
from transport.vectors import dot

if TYPE_CHECKING:
    from transport.scene import Scene

ROUNDING = 8 * 2.0**-52  # two supports are one where they differ by the rounding of their coordinates only


@dataclass
class Member:
    """A flat or spherical piece of a sheet: what acts on it (None: a transparent meter), and who looks at it."""

    shape: Rectangle | Disk | Triangle | Sphere
    surface: Surface | None
    detectors: list[Detector] = field(default_factory=list)
    orientation: float = 1.0  # of its normal against the sheet's
    mark: str | None = None  # the surface's name, where a detector's `via` asks for it
    whole: Shape | None = None  # the shape of which it is a piece


@dataclass
class Sheet:
    """Members on one support; the first one gives the sheet its normal."""

    members: list[Member]

    @property
    def support(self) -> Rectangle | Disk | Triangle | Sphere:
        return self.members[0].shape


def pieces(shape: Shape) -> tuple[Shape, ...]:
    """The flat or spherical pieces of a shape: the faces of a box, else the shape itself."""
    return tuple(shape.faces().values()) if isinstance(shape, Box) else (shape,)


def sheets_of(scene: Scene) -> list[Sheet]:
    """The scene's sheets, acting members before meters; surfaces that do nothing and are not looked at are left out."""
    sheets: list[Sheet] = []
    for member in sorted(_members(scene), key=_precedence):
        home = next((s for s in sheets if are_on_one_support(s.support, member.shape)), None)
        if home is None:
            home = Sheet([])
            sheets.append(home)
        home.members.append(member)
        member.orientation = _orientation(home.support, member.shape)
    return sheets


def _precedence(member: Member) -> tuple[bool, float]:
    """What acts comes first; then what knows its plane best, for the first one gives the sheet its normal."""
    shape = member.shape
    breadth = shape.area / shape.extent if isinstance(shape, Triangle) else math.inf
    return member.surface is None, -breadth


def are_on_one_support(a: Shape, b: Shape) -> bool:
    """Whether two shapes lie on the same plane or sphere, up to the rounding of their coordinates."""
    if isinstance(a, Sphere) != isinstance(b, Sphere):
        return False
    if isinstance(a, Triangle) or isinstance(b, Triangle):
        return _has_vertices_on(a, b) or _has_vertices_on(b, a)
    tolerance = ROUNDING * (_magnitude(a) + _magnitude(b))
    apart = math.dist(a.center, b.center)
    if isinstance(a, Sphere):
        return apart <= tolerance and abs(a.radius - b.radius) <= tolerance
    tilt = math.hypot(*(p - q * _sign(a, b) for p, q in zip(a.normal, b.normal, strict=True)))
    offset = abs(dot(tuple(p - q for p, q in zip(a.center, b.center, strict=True)), a.normal))
    return offset <= tolerance and tilt * (apart + a.extent + b.extent) <= tolerance


def _has_vertices_on(support: Shape, shape: Shape) -> bool:
    """Whether a triangle lies on a support by its vertices: a sliver's normal says less than they do."""
    return isinstance(shape, Triangle) and all(is_on_support(vertex, support) for vertex in shape.vertices)


def is_on_support(position: tuple[float, ...], shape: Shape) -> bool:
    """Whether a point lies on the plane or sphere of the shape, up to rounding."""
    tolerance = ROUNDING * (_magnitude(shape) + sum(map(abs, position)))
    if isinstance(shape, Sphere):
        return abs(math.dist(position, shape.center) - shape.radius) <= tolerance
    return (
        abs(dot(tuple(p - q for p, q in zip(position, shape.center, strict=True)), shape.normal)) <= tolerance
    )


def overlap(a: Shape, b: Shape) -> bool:
    """Whether two shapes on one support have more than an edge in common."""
    tolerance = ROUNDING * (_magnitude(a) + _magnitude(b))
    if isinstance(a, Sphere):
        return True
    if isinstance(a, Rectangle) and isinstance(b, Rectangle):
        return all(_gap_along(axis, a, b) < -tolerance for shape in (a, b) for axis in shape.frame[:2])
    disk, other = (a, b) if isinstance(a, Disk) else (b, a)
    nearest, farthest = in_plane_distances(other, disk.center)
    return nearest < disk.radius - tolerance and farthest > disk.inner_radius + tolerance


def _members(scene: Scene) -> Iterator[Member]:
    for surface in scene.surfaces:
        looking = [d for d in scene.meters if d.shape == surface.name and surface.name is not None]
        acts = not isinstance(surface.material, Transparent)
        mark = surface.name if surface.name in scene.visited else None
        if acts or looking or mark is not None:
            for piece in pieces(surface.shape):
                yield Member(piece, surface if acts else None, list(looking), mark=mark, whole=surface.shape)
    for detector in scene.meters:
        if isinstance(detector.shape, Shape):
            for piece in pieces(detector.shape):
                yield Member(piece, None, [detector], whole=detector.shape)


def _orientation(support: Shape, shape: Shape) -> float:
    return 1.0 if isinstance(shape, Sphere) else _sign(support, shape)


def _sign(a: Shape, b: Shape) -> float:
    return 1.0 if dot(a.normal, b.normal) > 0 else -1.0


def _magnitude(shape: Shape) -> float:
    return sum(map(abs, shape.middle)) + shape.extent


def _gap_along(axis: tuple[float, ...], a: Rectangle, b: Rectangle) -> float:
    """Distance between the shadows of two rectangles on an axis; negative where they overlap (separating axes)."""
    reach = sum(_reach_along(axis, shape) for shape in (a, b))
    return abs(dot(axis, tuple(p - q for p, q in zip(a.center, b.center, strict=True)))) - reach


def _reach_along(axis: tuple[float, ...], shape: Rectangle) -> float:
    e_u, e_v, _ = shape.frame
    return abs(dot(axis, e_u)) * shape.width / 2 + abs(dot(axis, e_v)) * shape.height / 2


def sheets_of_source(shape: Shape, sheets: list[Sheet]) -> list[int]:
    """Numbers, from 1, of the sheets on which a source's piece or point lies."""
    return [
        number
        for number, sheet in enumerate(sheets, start=1)
        if (
            is_on_support(shape.position, sheet.support)
            if isinstance(shape, Point)
            else are_on_one_support(shape, sheet.support)
        )
    ]
