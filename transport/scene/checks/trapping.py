"""Refuse light that never ends: trapped by total internal reflection, or in a nearly lossless medium.

Total internal reflection is detected for spheres, boxes and slabs with a source inside, or a scatterer in a
slab. Trapped light hits the walls at the same angles again and again (in a sphere by symmetry, between
planes by reflection), so that the engine has to abandon its history. A medium that absorbs or scatters traps
none.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from transport.geometry.flat import Slab
from transport.geometry.line_crossings import EDGE_TOLERANCE
from transport.geometry.neighbours import touching_boxes
from transport.geometry.relations import boxes_meet
from transport.geometry.shape import Shape
from transport.geometry.solid import Box, Sphere
from transport.scene.bodies import surrounding_medium
from transport.scene.checks.overlapping_bodies import absorbs, emitting_bodies_as_sources
from transport.scene.materials import AnyMedium, Material, Mirror, Surface
from transport.scene.parts import surface_name
from transport.validation import SceneError, short_repr
from transport.vectors import dot

if TYPE_CHECKING:
    from transport.scene.parts import SceneParts
    from transport.scene.sources import Source

MAX_EVENTS = 1 << 24  # events after which the engine abandons a history (engine/passes/surfaces.py)
# Mean numbers of scatterings before absorption, after which all but 1e-7 of the histories have ended.
LIFETIMES = 16


def check_total_internal_reflection(scene: SceneParts) -> None:
    """Raise SceneError for a source whose light is partly trapped in a clear, otherwise empty body.

    A clear slab may hold finite bodies: guided light passes them, and anything in it that scatters is a
    source too. Beams and aimed sources are not checked.
    """
    if scene.duration is not None:
        return
    check_weak_absorption(scene)
    lamps = {f"sources[{place}]": source for place, source in enumerate(scene.sources)}
    lamps |= {f"the medium of surfaces[{k}]": source for k, source in emitting_bodies_as_sources(scene)}
    near = []
    for number, surface in enumerate(scene.surfaces):
        sine = _escape_sine(surface.material)
        if sine == 1 or not surface.shape.is_closed:
            continue
        if _interacts(scene.medium if surface.back is None else surface.back):
            continue
        near = near or touching_boxes(*np.array([s.shape.bounds for s in scene.surfaces]).transpose(1, 0, 2))
        others = (scene.surfaces[k] for k in near[number].tolist())
        company = [other for other in others if not _is_inert(other)]  # may lie within, by bounding boxes
        if company and not (surface.shape.is_infinite and all(map(_is_bounded, company))):
            continue
        for lamp, cure in _trapped_sources(scene, lamps, surface.shape, sine, company):
            title = surface_name(scene, number)
            raise SceneError(
                f"Scene: total internal reflection traps light of {lamp} in {title} forever, got a critical"
                f" angle of {math.degrees(math.asin(sine)):.4g} degrees and no absorption; let the material"
                " absorb a little, as Mixture({Dielectric(...): 0.999, Black(): 0.001}), give the scene a"
                f" duration, or {cure}"
            )


def _trapped_sources(
    scene: SceneParts, lamps: dict[str, Source], shape: Shape, sine: float, company: list[Surface]
) -> Iterator[tuple[str, str]]:
    """Titles of the sources whose light is trapped in a clear body, with an additional cure, as text."""
    for lamp, source in lamps.items():
        origin = scene.shape_of(source)
        if (
            _is_unaimed(source)
            and _traps_light(shape, sine, source, origin)
            and not _is_enclosed(origin, company)
        ):
            yield lamp, "use aim=... or a Beam"
    for surface in company:
        others = [other for other in company if other is not surface]
        if (
            _scatters(surface)
            and _is_inside_slab(surface.shape, shape)
            and not _is_enclosed(surface.shape, others)
        ):
            yield f"the scatterer {surface_name(scene, surface)}", "replace the slab by a finite Box"


def check_weak_absorption(scene: SceneParts) -> None:
    """Refuse an infinite medium that absorbs so little that histories are abandoned before they end."""
    around = surrounding_medium(scene)
    sigma_a, sigma_s = float(np.max(around.absorption)), float(np.max(around.scattering))
    if not 0 < sigma_a < sigma_s * LIFETIMES / MAX_EVENTS:
        return
    is_open = all(_is_bounded(s) and s.material.is_clear for s in scene.surfaces)
    if is_open and not any(absorbs(m) for s in scene.surfaces for m in (s.front, s.back)):
        raise SceneError(
            f"Scene: infinite medium must absorb more, got {short_repr(scene.medium)}, in which a history"
            f" scatters {sigma_s / sigma_a:.2g} times before it is absorbed, and is abandoned after"
            f" {MAX_EVENTS:.2g}; raise its absorption, put it into a Box, or give the scene a duration"
        )


def _escape_sine(material: Material) -> float:
    """Sine of the critical angle from inside for clear smooth dielectrics; 1 for all other materials."""
    glass = material.boundary
    if glass is None or any(not part.bounds_media and part != Mirror(1.0) for part in material.elements):
        return 1.0
    return min(1.0, glass.index_outside / glass.index_inside)


def _interacts(medium: AnyMedium | None) -> bool:
    """Return whether a medium absorbs or scatters."""
    return medium is not None and bool(np.max(medium.extinction) > 0)


def _is_inert(surface: Surface) -> bool:
    """Return whether a surface has no effect."""
    return not surface.material.acts and not (_interacts(surface.front) or _interacts(surface.back))


def _is_inside_slab(shape: Shape, slab: Slab) -> bool:
    """Return whether the middle of a shape lies between the faces of a slab, not on one."""
    offset = tuple(p - q for p, q in zip(shape.middle, slab.middle, strict=True))
    return abs(dot(offset, slab.normal)) < (1 - EDGE_TOLERANCE) * slab.thickness / 2


def _is_enclosed(shape: Shape, walls: list[Surface]) -> bool:
    """Return whether a surface around the shape may block its light."""
    return any(not wall.material.is_clear and boxes_meet(shape, wall.shape) for wall in walls)


def _is_bounded(surface: Surface) -> bool:
    """Return whether a surface is finite."""
    return bool(np.isfinite(surface.shape.bounds).all())


def _scatters(surface: Surface) -> bool:
    """Return whether a surface, or the medium it names, scatters light diffusely."""
    media = [medium for medium in (surface.front, surface.back) if medium is not None]
    is_rough = any(part.shares.diffuse > 0 for part in surface.material.elements)
    return is_rough or any(np.max(medium.scattering) > 0 for medium in media)


def _is_unaimed(source: Source) -> bool:
    """Return whether a source emits into at least half of all directions."""
    return source.aim is None and source.emission.law != "beam"


def _traps_light(shape: Shape, sine: float, source: Source, origin: Shape) -> bool:
    """Return whether an unaimed source inside the body has rays that are totally reflected at all walls.

    In a sphere these start beyond `sine` times its radius, across the radius; in a box they are oblique to
    all faces.
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
