"""Whether a scene makes sense as a whole: one surface acts at a point, aims can be met, light can end somewhere."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from transport.materials import Diffuse, Material, Mirror, Surface, Transparent
from transport.scene_speeds import parts_of
from transport.shapes import Box, FlatShape, Shape, Sphere, Triangle
from transport.sheets import are_on_one_support, overlap, sheets_of
from transport.validation import SceneError, refuse, shown

if TYPE_CHECKING:
    from transport.scene import Scene


def check_scene(scene: Scene) -> None:
    """Refuse a scene whose parts do not go together.  Raises SceneError."""
    check_surfaces(scene)
    check_supports(scene)
    check_aims(scene)
    check_endless(scene)


def check_surfaces(scene: Scene) -> None:
    """Refuse a triangle that acts; a transparent one may be metered."""
    for surface in scene.surfaces:
        if isinstance(surface.shape, Triangle) and not isinstance(surface.material, Transparent):
            cure = "make it of Rectangles and Disks; surfaces of triangles come with meshes"
            refuse(surface, f"shape must not be a Triangle that acts, got {surface.shape}; {cure}")


def check_supports(scene: Scene) -> None:
    """Refuse two acting surfaces over one point of a sheet."""
    for sheet in sheets_of(scene):
        acting = [m for m in sheet.members if m.surface is not None]
        for i, one in enumerate(acting):
            for other in acting[:i]:
                if overlap(one.shape, other.shape):
                    raise SceneError(
                        f"Scene: {_title(scene, other.surface)} and {_title(scene, one.surface)} overlap on one"
                        f" {'sphere' if isinstance(one.shape, Sphere) else 'plane'}; make them share an edge at most,"
                        " or leave one out"
                    )


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
        if not shape.is_closed or _lets_through(surface.material):
            continue
        if any(_absorbs(other.material) and _meet(other.shape, shape) for other in scene.surfaces):
            continue
        for source in scene.sources:
            origin = scene.shape_of(source)
            is_inside = source.is_back if origin == shape else _holds(shape, origin.middle)
            if is_inside:
                raise SceneError(
                    f"Scene: nothing absorbs inside {_title(scene, surface)} and nothing escapes from it; give it an"
                    " albedo below 1, or the scene a duration"
                )


def _absorbs(material: Material) -> bool:
    """Whether some of what arrives ends there."""
    return any(_reflected(part) < 1 for part in parts_of(material) if not isinstance(part, Transparent))


def _reflected(material: Material) -> float:
    """The share that a simple material reflects."""
    match material:
        case Diffuse(albedo=share) | Mirror(reflectance=share):
            return share
    return 0.0


def _lets_through(material: Material) -> bool:
    return any(isinstance(part, Transparent) for part in parts_of(material))


def _meet(a: Shape, b: Shape) -> bool:
    """Whether the boxes about two shapes overlap."""
    (low_a, high_a), (low_b, high_b) = a.bounds, b.bounds
    return all(p <= s and r <= q for p, q, r, s in zip(low_a, high_a, low_b, high_b, strict=True))


def _holds(shape: Sphere | Box, point: tuple[float, ...]) -> bool:
    """Whether a point lies inside a closed shape."""
    if isinstance(shape, Sphere):
        return math.dist(point, shape.center) < shape.radius
    return all(low < x < high for low, x, high in zip(shape.bounds[0], point, shape.bounds[1], strict=True))


def _title(scene: Scene, surface: Surface) -> str:
    return f"Surface {surface.name!r}" if surface.name else f"surfaces[{scene.surfaces.index(surface)}]"
