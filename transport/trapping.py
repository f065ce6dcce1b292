"""Light that total reflection keeps in clear glass for ever, told for balls, boxes and slabs with a lamp inside.

It comes to the walls at the same angles again and again (in a ball by symmetry, between planes by
reflection), so that a history of it ends only when it is given up.  A medium that absorbs or scatters keeps none.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from transport.emissions import Beam
from transport.filling import glowing_sources
from transport.materials import Dielectric, Material, Mirror, Transparent, simple_parts
from transport.materials.surface import AnyMedium
from transport.shapes import Box, Shape, Slab, Sphere
from transport.validation import SceneError
from transport.vectors import dot

if TYPE_CHECKING:
    from transport.scene import Scene
    from transport.sources import Source


def check_trapped(scene: Scene) -> None:
    """Refuse a lamp in a clear body with nothing else in it, where some of its light can never leave.

    Beams and lamps that aim are not asked.  Raises SceneError.
    """
    for number, surface in enumerate(scene.surfaces):
        sine = _escape_sine(surface.material)
        if sine == 1 or not surface.shape.is_closed or _has_company(scene, number):
            continue
        if _acts(scene.medium if surface.back is None else surface.back):
            continue
        lamps = {f"sources[{place}]": source for place, source in enumerate(scene.sources)}
        lamps |= {f"the medium of surfaces[{k}]": source for k, source in glowing_sources(scene)}
        for lamp, source in lamps.items():
            if _is_wide(source) and _traps(surface.shape, sine, source, scene.shape_of(source)):
                title = f"Surface {surface.name!r}" if surface.name else f"surfaces[{number}]"
                raise SceneError(
                    f"Scene: total reflection keeps light of {lamp} in {title} for ever, got a critical angle"
                    f" of {math.degrees(math.asin(sine)):.4g} degrees and nothing that absorbs; let the material absorb"
                    " a little, as Mixture({Dielectric(...): 0.999, Black(): 0.001}), or use aim=... or a Beam"
                )


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


def _has_company(scene: Scene, number: int) -> bool:
    """Whether another surface that acts may be within, as far as their boxes tell."""
    low, high = scene.surfaces[number].shape.bounds
    for k, other in enumerate(scene.surfaces):
        sides = zip(low, high, *other.shape.bounds, strict=True)
        is_inert = other.material == Transparent() and not (_acts(other.front) or _acts(other.back))
        if k != number and not is_inert and all(p <= s and r <= q for p, q, r, s in sides):
            return True
    return False


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
