"""Whether a scene makes sense as a whole: one surface acts at a point, aims can be met, light can end somewhere."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from transport.materials import Black, Diffuse, Mirror, Surface, Transparent
from transport.shapes import Box, Disk, Rectangle, Shape, Sphere
from transport.sheets import are_on_one_support, overlap, sheets_of
from transport.validation import SceneError, refuse, shown

if TYPE_CHECKING:
    from transport.scene import Scene


def check_scene(scene: Scene) -> None:
    """Refuse a scene whose parts do not go together.  Raises SceneError."""
    check_supports(scene)
    check_aims(scene)
    check_endless(scene)


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
        if (
            isinstance(aim, Rectangle | Disk)
            and isinstance(shape, Rectangle | Disk)
            and are_on_one_support(shape, aim)
        ):
            refuse(source, f"aim must not lie in the source's own plane, got {shown(aim)}; aim above it")


def check_endless(scene: Scene) -> None:
    """Refuse light that is shut in where nothing absorbs it and no clock stops it, as far as one shape tells."""
    if scene.duration is not None:
        return
    for surface in scene.surfaces:
        shape = surface.shape
        if isinstance(surface.material, Transparent) or not shape.is_closed:
            continue
        if any(_absorbs(other) and _meet(other.shape, shape) for other in scene.surfaces):
            continue
        for source in scene.sources:
            origin = scene.shape_of(source)
            is_inside = source.is_back if origin == shape else _holds(shape, origin.middle)
            if is_inside:
                raise SceneError(
                    f"Scene: nothing absorbs inside {_title(scene, surface)} and nothing escapes from it; give it an"
                    " albedo below 1, or the scene a duration"
                )


def _absorbs(surface: Surface) -> bool:
    match surface.material:
        case Diffuse(albedo=albedo):
            return albedo < 1
        case Mirror(reflectance=reflectance):
            return reflectance < 1
    return isinstance(surface.material, Black)


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
