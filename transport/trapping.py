"""Light that never ends: kept in clear glass by total reflection, or in a medium that hardly absorbs.

Total reflection is told for balls, boxes and slabs with a lamp inside, or a scatterer in a slab.
It comes to the walls at the same angles again and again (in a ball by symmetry, between planes by
reflection), so that a history of it ends only when it is given up.  A medium that absorbs or scatters keeps none.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from transport.bodies.filling import absorbs, glowing_sources
from transport.bodies.listing import surrounding_of
from transport.bodies.nesting import CLOSE
from transport.emissions import Beam
from transport.materials import Dielectric, Diffuse, Material, Mirror, Surface, Transparent, simple_parts
from transport.materials.surface import AnyMedium, titled
from transport.shapes import Box, Shape, Slab, Sphere
from transport.validation import SceneError, shown
from transport.vectors import dot

if TYPE_CHECKING:
    from transport.parts import SceneParts
    from transport.sources import Source

MOST_EVENTS = 1 << 24  # after which the engine gives a history up (engine/surfaces.py)
LIFETIMES = 16  # mean numbers of scatterings before absorption, in which all but one history in 10^7 ends


def check_trapped(scene: SceneParts) -> None:
    """Refuse a lamp in a clear body with nothing else in it, where some of its light can never leave.

    In a clear slab there may be bodies of finite size: light that is guided passes them, and what scatters within
    it is a lamp as well.  Beams and lamps that aim are not asked.  Raises SceneError.
    """
    if scene.duration is not None:
        return
    check_sluggish(scene)
    for number, surface in enumerate(scene.surfaces):
        sine = _escape_sine(surface.material)
        if sine == 1 or not surface.shape.is_closed:
            continue
        if _acts(scene.medium if surface.back is None else surface.back):
            continue
        company = _company(scene, number)
        if company and not (isinstance(surface.shape, Slab) and all(map(_is_bounded, company))):
            continue
        for lamp, cure in _trapped_lamps(scene, surface.shape, sine, company):
            title = titled(surface, number)
            raise SceneError(
                f"Scene: total reflection keeps light of {lamp} in {title} for ever, got a critical angle"
                f" of {math.degrees(math.asin(sine)):.4g} degrees and nothing that absorbs; let the material absorb"
                f" a little, as Mixture({{Dielectric(...): 0.999, Black(): 0.001}}), give the scene a duration, or {cure}"
            )


def _trapped_lamps(
    scene: SceneParts, shape: Shape, sine: float, company: list[Surface]
) -> Iterator[tuple[str, str]]:
    """What sends light into a clear body that can never leave it, and another cure, in words."""
    lamps = {f"sources[{place}]": source for place, source in enumerate(scene.sources)}
    lamps |= {f"the medium of surfaces[{k}]": source for k, source in glowing_sources(scene)}
    for lamp, source in lamps.items():
        origin = scene.shape_of(source)
        if _is_wide(source) and _traps(shape, sine, source, origin) and not _is_hidden(origin, company):
            yield lamp, "use aim=... or a Beam"
    for surface in company:
        others = [other for other in company if other is not surface]
        if _scatters(surface) and _lies_deep(surface.shape, shape) and not _is_hidden(surface.shape, others):
            number = scene.surfaces.index(surface)
            title = titled(surface, number)
            yield f"what scatters at {title}", "let the slab end, as a Box"


def check_sluggish(scene: SceneParts) -> None:
    """Refuse an endless medium that absorbs so little that histories are given up before it ends them."""
    around = surrounding_of(scene)
    sigma_a, sigma_s = float(np.max(around.absorption)), float(np.max(around.scattering))
    if not 0 < sigma_a < sigma_s * LIFETIMES / MOST_EVENTS:
        return
    is_open = all(_is_bounded(s) and not _acts_otherwise(s) for s in scene.surfaces)
    if is_open and not any(absorbs(m) for s in scene.surfaces for m in (s.front, s.back)):
        raise SceneError(
            f"Scene: medium without end must absorb more, got {shown(scene.medium)}, in which a history scatters"
            f" {sigma_s / sigma_a:.2g} times before it is absorbed, and is given up after {MOST_EVENTS:.2g}; raise its"
            " absorption, put it into a Box, or give the scene a duration"
        )


def _acts_otherwise(surface: Surface) -> bool:
    """Whether a surface may absorb, scatter or mirror what arrives."""
    return any(not isinstance(part, Dielectric | Transparent) for part in simple_parts(surface.material))


def _escape_sine(material: Material) -> float:
    """Sine of the critical angle from inside, where nothing but clear smooth glass acts; else 1."""
    parts = simple_parts(material)
    glass = [part for part in parts if isinstance(part, Dielectric)]
    if not glass or any(part not in glass and part != Mirror(1.0) for part in parts):
        return 1.0
    return min(1.0, glass[0].index_outside / glass[0].index_inside)


def _acts(medium: AnyMedium | None) -> bool:
    """Whether a medium turns light round or ends it."""
    return medium is not None and bool(np.max(medium.extinction) > 0)


def _company(scene: SceneParts, number: int) -> list[Surface]:
    """Other surfaces that act and may be within, as far as their boxes tell."""
    shape, others = scene.surfaces[number].shape, enumerate(scene.surfaces)
    return [
        other for k, other in others if k != number and not _is_inert(other) and _meet(other.shape, shape)
    ]


def _is_inert(surface: Surface) -> bool:
    return surface.material == Transparent() and not (_acts(surface.front) or _acts(surface.back))


def _meet(shape: Shape, other: Shape) -> bool:
    """Whether the boxes about two shapes overlap."""
    return all(p <= s and r <= q for p, q, r, s in zip(*other.bounds, *shape.bounds, strict=True))


def _lies_deep(shape: Shape, slab: Slab) -> bool:
    """Whether the middle of a shape lies between the faces of a slab, not on one."""
    offset = tuple(p - q for p, q in zip(shape.middle, slab.middle, strict=True))
    return abs(dot(offset, slab.normal)) < (1 - CLOSE) * slab.thickness / 2


def _is_hidden(shape: Shape, walls: list[Surface]) -> bool:
    """Whether something may stand about it that keeps its light."""
    return any(_acts_otherwise(wall) and _meet(shape, wall.shape) for wall in walls)


def _is_bounded(surface: Surface) -> bool:
    return bool(np.isfinite(surface.shape.bounds).all())


def _scatters(surface: Surface) -> bool:
    """Whether it sends what arrives into directions of all kinds."""
    media = [medium for medium in (surface.front, surface.back) if medium is not None]
    is_rough = any(isinstance(part, Diffuse) and part.albedo > 0 for part in simple_parts(surface.material))
    return is_rough or any(np.max(medium.scattering) > 0 for medium in media)


def _is_wide(source: Source) -> bool:
    """Whether it sends light into half of all directions at least."""
    return source.aim is None and not isinstance(source.emission, Beam)


def _traps(shape: Shape, sine: float, source: Source, origin: Shape) -> bool:
    """Whether a wide lamp inside the body has rays beyond the critical angle wherever they meet its walls.

    In a ball those from places beyond `sine` of its radius across it; in a box those as oblique to all faces.
    """
    offset = tuple(p - q for p, q in zip(origin.middle, shape.middle, strict=True))
    is_own = origin == shape
    if is_own and source.emission.has_side and not source.is_back:
        return False
    match shape:
        case Sphere(radius=radius):
            return is_own or sine * radius < math.hypot(*offset, origin.extent) < radius
        case Slab(normal=normal, thickness=thickness):
            return abs(dot(offset, normal)) < thickness / 2
        case Box(size=size):
            is_inside = is_own or all(2 * abs(x) < length for x, length in zip(offset, size, strict=True))
            return is_inside and 3 * (1 - sine) * (1 + sine) > 1
    return False
