"""Why a meter reads nothing, where that is sure: the slip that everybody makes once is a normal the wrong way round."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from transport.bodies.filling import glows
from transport.materials import Black, Transparent, lets_through, simple_parts
from transport.materials.surface import titled
from transport.results.deep_ways import why_so_deep
from transport.results.meter_sums import ARRIVALS, DEPARTURES
from transport.results.shut_in import holds_all, is_outside, shut_in
from transport.shapes import FlatShape, Point, Shape, Sphere
from transport.vectors import dot

if TYPE_CHECKING:
    from transport.compile.plan import Plan
    from transport.detectors import Detector
    from transport.results.readings import Reading
    from transport.scene import Scene
    from transport.sources import Source


def why_empty(plan: Plan, detector: Detector, particles: int) -> str | None:
    """What to know of a meter that counted nothing at all, in a run forwards; None where the reason is not sure."""
    shape, title = plan.scene.shape_of(detector), f"detector {detector.name!r}"
    deep = why_so_deep(plan, title, shape, particles)
    if deep or shape.is_infinite or glows(plan.scene):
        return deep
    ball = Sphere(center=shape.middle, radius=shape.extent)
    return (
        shut_in(plan, title, ball)
        or _shut_out(plan, title, shape)
        or _room(plan.scene, title, detector, shape)
        or _behind(plan.scene, title, shape)
    )


def wrong_way(reading: Reading) -> str | None:
    """A note on a transparent meter that light crosses from behind alone: what arrives there counts on its other side."""
    arrived, left = (reading.sums.whole("counts", side).any() for side in (ARRIVALS, DEPARTURES))
    if isinstance(reading.detector.shape, str) or arrived or not left:
        return None
    other = "front" if reading.detector.is_back else "back"
    return f"nothing arrives at this side, what crosses comes from behind: turn the normal, or say side={other!r}"


def _shut_out(plan: Plan, title: str, shape: Shape) -> str | None:
    """All sources in an opaque shell, the meter outside of it."""
    for number, surface in enumerate(plan.scene.surfaces):
        shell = surface.shape
        is_shell = shell.is_closed and not shell.is_infinite and not lets_through(surface.material)
        if is_shell and is_outside(shell, shape) and all(_is_inside(shell, e.shape) for e in plan.emitters):
            return (
                f"{title} counted nothing: every source lies inside {titled(surface, number)}, which lets nothing"
                " through; move the source out, or the detector in"
            )
    return None


def _room(scene: Scene, title: str, detector: Detector, shape: Shape) -> str | None:
    """A room whose walls emit outwards, as a source on a closed surface does, while the meter looks inwards."""
    for number, surface in enumerate(scene.surfaces):
        shell = surface.shape
        if not shell.is_closed or shell.is_infinite or lets_through(surface.material):
            continue
        is_within = detector.is_back if shape == shell else _is_inside(shell, shape)
        if is_within and scene.sources and all(_emits_outwards(scene, s, shell) for s in scene.sources):
            name = titled(surface, number)
            return f"{title} counted nothing: every source emits from the outside of {name}; say side='inside' of the source"
    return None


def _is_inside(shell: Shape, shape: Shape) -> bool:
    """Whether all of a shape surely lies in a closed one."""
    if isinstance(shape, Point):
        return holds_all(shell, shape.position)
    return not shape.is_infinite and holds_all(shell, Sphere(center=shape.middle, radius=shape.extent))


def _emits_outwards(scene: Scene, source: Source, shell: Shape) -> bool:
    return scene.shape_of(source) == shell and source.emission.has_side and not source.is_back


def _behind(scene: Scene, title: str, shape: Shape) -> str | None:
    """The meter behind the flat sources, in a scene that turns no light round."""
    if not scene.sources or _turns_light(scene):
        return None
    if not all(_is_behind(scene, source, shape) for source in scene.sources):
        return None
    return (
        f"{title} counted nothing: it lies behind the sources, which emit to where their normals point; turn a"
        " normal, or say side='back' of the source"
    )


def _is_behind(scene: Scene, source: Source, shape: Shape) -> bool:
    origin = scene.shape_of(source)
    if not (source.emission.has_side and isinstance(origin, FlatShape)):
        return False
    ahead = dot(origin.normal, tuple(m - o for m, o in zip(shape.middle, origin.middle, strict=True)))
    return (-ahead if source.is_back else ahead) < -shape.extent


def _turns_light(scene: Scene) -> bool:
    """Whether a surface or a medium may send light on in another direction."""
    media = [scene.medium, *(m for surface in scene.surfaces for m in (surface.front, surface.back))]
    if any(medium is not None and np.max(medium.scattering) > 0 for medium in media):
        return True
    parts = (part for surface in scene.surfaces for part in simple_parts(surface.material))
    return any(not isinstance(part, Black | Transparent) for part in parts)
