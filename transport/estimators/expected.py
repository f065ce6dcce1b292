"""Which detectors the estimator "expected" serves, and which scenes allow it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from transport.detectors import Detector
from transport.shapes import Disk, Rectangle, Shape, Sphere, Triangle

if TYPE_CHECKING:
    from transport.scene import Scene


def why_not(scene: Scene) -> str | None:
    """Why a scene cannot be run with estimator "expected", with the cure; None where it can."""
    if scene.duration is not None:
        return f"it has a clock, got duration={scene.duration!r}; leave duration out"
    if scene.points:
        name = scene.points[0].name
        return f"PointDetector {name!r} casts rays of its own; run it in another scene"
    if not any(expects(scene, meter) for meter in scene.meters):
        got = ", ".join(f"{type(part).__name__} {part.name!r}" for part in scene.detectors) or "no detector"
        cure = "meter a Rectangle, Disk, Triangle or whole Sphere, without speeds or moments"
        return f"on {got} it can draw no points; {cure}"
    return None


def counted_as_they_come(scene: Scene) -> list[str]:
    """The names of the detectors that no event tells anything."""
    return [meter.name for meter in scene.meters if not expects(scene, meter)]


def expects(scene: Scene, detector: Detector) -> bool:
    """Whether events tell this detector what they send there; others count what crosses them."""
    plain = detector.speeds is None and not detector.moments
    return plain and can_draw_on(scene.shape_of(detector))


def can_draw_on(shape: Shape) -> bool:
    """Whether points are drawn on a shape: flat ones without holes, and balls."""
    if isinstance(shape, Rectangle):
        return shape.hole is None
    return isinstance(shape, Disk | Triangle) or (isinstance(shape, Sphere) and shape.is_closed)
