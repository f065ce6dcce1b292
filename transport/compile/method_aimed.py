"""Estimator "aimed": every source emits only towards the one detector: direct light only.

Weights correct for the restricted directions exactly.

Light in other directions is not traced, so that nothing in the scene may redirect it to the detector.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from transport.scene.checks.overlapping_bodies import has_emission
from transport.scene.detectors import Detector
from transport.scene.materials import display_name
from transport.validation import SceneError, short_repr

if TYPE_CHECKING:
    from transport.scene.scene import Scene


def refusal(scene: Scene) -> str | None:
    """Reason why a scene does not allow this estimator, with the cure; None if it does."""
    return (
        _detector_refusal(scene)
        or _source_refusal(scene)
        or _scattering_refusal(scene)
        or _aim_refusal(scene)
    )


def aimed_scene(scene: Scene) -> Scene:
    """The scene with every source aimed at its one detector; SceneError if a source cannot be aimed."""
    (detector,) = scene.detectors
    aim = scene.shape_of(detector)
    return replace(scene, sources=tuple(replace(source, aim=aim) for source in scene.sources))


def unaimed_scene(scene: Scene) -> Scene:
    """The original scene of an aimed one; its sources had no aim."""
    return replace(scene, sources=tuple(replace(source, aim=None) for source in scene.sources))


def _detector_refusal(scene: Scene) -> str | None:
    """Reason why the detectors do not allow it."""
    if len(scene.detectors) == 1 and isinstance(scene.detectors[0], Detector):
        return None
    names = ", ".join(f"{type(part).__name__} {part.name!r}" for part in scene.detectors) or "none"
    return f"it needs exactly one Detector, got {names}; leave the others out, or aim sources yourself"


def _source_refusal(scene: Scene) -> str | None:
    """Reason why the sources do not allow it."""
    if has_emission(scene):
        return "a medium emits and cannot be aimed; leave its emission out"
    (detector,) = scene.detectors
    shape = scene.shape_of(detector)
    for number, source in enumerate(scene.sources):
        if source.aim is not None:
            return f"sources[{number}] already has aim={short_repr(source.aim)}; leave it out"
        if scene.shape_of(source) == shape:
            return f"sources[{number}] lies on the shape of detector {detector.name!r}; put it elsewhere"
    return None


def _scattering_refusal(scene: Scene) -> str | None:
    """Reason why surfaces or media do not allow it: they may redirect light to the detector."""
    for number, surface in enumerate(scene.surfaces):
        for part in surface.material.elements:
            if part.redirects:
                return (
                    f"{display_name(surface, number)} redirects light, got {short_repr(part)};"
                    " write estimator='expected' or 'backward'"
                )
    media = [scene.medium, *(m for surface in scene.surfaces for m in (surface.front, surface.back))]
    for medium in media:
        if medium is not None and np.max(medium.scattering) > 0:
            return f"a medium scatters, got {short_repr(medium)}; write estimator='expected' or 'backward'"
    return None


def _aim_refusal(scene: Scene) -> str | None:
    """Reason why a source cannot be aimed at that shape."""
    try:
        aimed_scene(scene)
    except SceneError as refusal:
        return str(refusal)
    return None
