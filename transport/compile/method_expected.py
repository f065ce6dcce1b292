"""Estimator "expected": the detectors it serves, and the scenes that allow it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from transport.geometry.shape import Shape
from transport.geometry.solid import Sphere
from transport.scene.detectors import Detector

if TYPE_CHECKING:
    from transport.scene.scene import Scene


def refusal(scene: Scene) -> str | None:
    """Reason why a scene cannot be run with estimator "expected", with the cure; None if it can."""
    if scene.duration is not None:
        return f"it is time-dependent, got duration={scene.duration!r}; leave duration out"
    if scene.points:
        name = scene.points[0].name
        return f"PointDetector {name!r} casts its own rays; run it in a separate scene"
    if not any(uses_next_event(scene, detector) for detector in scene.meters):
        got = ", ".join(f"{type(part).__name__} {part.name!r}" for part in scene.detectors) or "no detector"
        cure = "use a Detector on a Rectangle, Disk, Triangle, Polygon or whole Sphere"
        return f"it cannot sample points on {got}; {cure}, without speeds, moments or path_lengths"
    return None


def detectors_without_next_event(scene: Scene) -> list[str]:
    """Names of the detectors that score crossings only, without next-event estimation."""
    return [detector.name for detector in scene.meters if not uses_next_event(scene, detector)]


def uses_next_event(scene: Scene, detector: Detector) -> bool:
    """Return whether next-event estimation serves this detector; others score crossings."""
    return not detector.options_of_crossings and can_sample_points_on(scene.shape_of(detector))


def can_sample_points_on(shape: Shape) -> bool:
    """Return whether points are sampled on a shape: flat shapes without holes, and whole spheres."""
    if shape.is_flat:
        return shape.hole is None and not shape.is_infinite
    return isinstance(shape, Sphere) and shape.is_closed
