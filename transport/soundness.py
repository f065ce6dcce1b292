"""Whether a scene makes sense as a whole: one surface acts at a point, aims can be met, light can end somewhere."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from transport.bodies.filling import absorbs, check_filling, glowing_sources
from transport.bodies.nesting import check_media
from transport.flush import check_flush
from transport.materials import (
    Black,
    Dielectric,
    Diffuse,
    Glossy,
    Material,
    Mirror,
    Surface,
    TwoSided,
    lets_through,
    simple_parts,
)
from transport.materials.surface import titled
from transport.shapes import FlatShape, Mesh, Shape, Slab, Sphere
from transport.shapes.distances import least_distance
from transport.shapes.overlaps import overlap
from transport.shapes.supports import are_on_one_support
from transport.sheets import sheets_of
from transport.trapping import check_trapped
from transport.validation import SceneError, refuse, shown
from transport.vectors import Vector, dot

if TYPE_CHECKING:
    from transport.scene import Scene
    from transport.sources import Source


def check_scene(scene: Scene) -> None:
    """Refuse a scene whose parts do not go together.  Raises SceneError."""
    check_supports(scene)
    check_flush(scene)
    check_aims(scene)
    check_endless(scene)
    check_trapped(scene)
    check_media(scene)
    check_filling(scene)


def check_supports(scene: Scene) -> None:
    """Refuse two acting surfaces over one point of a sheet."""
    for sheet in sheets_of(scene):
        acting = [m for m in sheet.members if m.surface is not None]
        for i, one in enumerate(acting):
            for other in acting[:i]:
                if overlap(one.shape, other.shape):
                    cure = "make them share an edge at most, leave a gap of a billionth between them, or leave one out"
                    if all(_refracts(member.surface) for member in (one, other)):
                        cure = (
                            "give the common face once, as a Plane, Disk or Rectangle with Dielectric(index behind,"
                            " index in front), and make the bodies there Transparent(); a gap would be a film of air"
                        )
                    raise SceneError(
                        f"Scene: {_title(scene, other.surface)} and {_title(scene, one.surface)} overlap on one"
                        f" {_support_of(one.shape)}; {cure}"
                    )


def _refracts(surface: Surface) -> bool:
    return any(isinstance(part, Dielectric) for part in simple_parts(surface.material))


def check_aims(scene: Scene) -> None:
    """Refuse a flat source that aims into its own plane, where none of its directions lead."""
    for source in scene.sources:
        shape, aim = scene.shape_of(source), source.aim
        if isinstance(aim, FlatShape) and isinstance(shape, FlatShape) and are_on_one_support(shape, aim):
            refuse(source, f"aim must not lie in the source's own plane, got {shown(aim)}; aim above it")


def check_endless(scene: Scene) -> None:
    """Refuse light that is shut in where nothing absorbs it and no clock stops it, as far as one shape tells."""
    if scene.duration is not None:
        return
    for surface in scene.surfaces:
        shape = surface.shape
        inside = _back_of(surface.material)
        if not shape.is_closed or lets_through(inside) or _absorbs(inside):
            continue
        others = (other for other in scene.surfaces if other is not surface)
        if any(_absorbs(other.material) and _meet(other.shape, shape) for other in others):
            continue
        if absorbs(scene.medium) or any(
            _fills_with_absorber(s) and _meet(s.shape, shape) for s in scene.surfaces
        ):
            continue
        for source in (*scene.sources, *(glow for _, glow in glowing_sources(scene))):
            origin = scene.shape_of(source)
            is_own = origin == shape and source.emission.has_side
            is_inside = source.is_back if is_own else _starts_inside(shape, source, origin)
            if is_inside:
                raise SceneError(
                    f"Scene: nothing absorbs inside {_title(scene, surface)} and nothing escapes from it; give it an"
                    " albedo below 1, or the scene a duration"
                )


def _back_of(material: Material) -> Material:
    """What acts on the inside of a closed shape."""
    return material.back if isinstance(material, TwoSided) else material


def _fills_with_absorber(surface: Surface) -> bool:
    return absorbs(surface.front) or absorbs(surface.back)


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


def _meet(a: Shape, b: Shape) -> bool:
    """Whether the boxes about two shapes overlap."""
    (low_a, high_a), (low_b, high_b) = a.bounds, b.bounds
    return all(p <= s and r <= q for p, q, r, s in zip(low_a, high_a, low_b, high_b, strict=True))


def _starts_inside(shape: Shape, source: Source, origin: Shape) -> bool:
    """Whether some of a source's particles surely start inside a closed shape: in its middle, or all of them."""
    middle, is_volume = origin.middle, not source.emission.has_side
    if not _holds(shape, middle):
        return False
    is_there = (
        least_distance(origin, middle, filled=is_volume) == 0
    )  # it may lie about the closed shape instead
    return is_there or least_distance(shape, middle) >= origin.extent


def _holds(shape: Shape, point: Vector) -> bool:
    """Whether a point lies inside a closed shape."""
    match shape:
        case Sphere():
            return math.dist(point, shape.center) < shape.radius
        case Slab():
            offset = tuple(p - c for p, c in zip(point, shape.center, strict=True))
            return abs(dot(offset, shape.normal)) < shape.thickness / 2
        case Mesh():
            return shape.holds(point)
    return all(low < x < high for low, x, high in zip(shape.bounds[0], point, shape.bounds[1], strict=True))


def _support_of(shape: Shape) -> str:
    return "plane" if isinstance(shape, FlatShape) else type(shape).__name__.lower()


def _title(scene: Scene, surface: Surface) -> str:
    return titled(surface, scene.surfaces.index(surface))
