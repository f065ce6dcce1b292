"""Estimator "backward": histories start at the detectors and score the radiance of sources that they reach.

Light can be traced in either direction: along a ray L/eta^2 is constant, and reflection and scattering are
reciprocal. The radiance that arrives at a detector is therefore the mean, over histories sent out from it, of
their weight times L_s (eta_d/eta_s)^2 of each source that they reach (Veach 1997, chapters 4 and 5).
Histories are distributed equally over the detector's bins, so that a bin of a ten-thousandth of all
directions costs no more than all directions. At diffuse surfaces and collisions they also cast shadow rays to
the sources (as "expected" does to detectors), so that small bright sources are not left to chance. Light from
mirrors, dielectrics and glossy surfaces, and of the first flight, is scored on arrival. The energy balance is
that of these backward histories, with unit 1.

What each part becomes (all others are unchanged):

    Lambertian source         detector on its side: arriving weight times radiance
    Isotropic volume source   volume detector: weight times path length times emission per m^3 and sr
    emitting medium           the same, over its body
    Detector                  source with cosine law into its bins, from its receiving side
    PointDetector             point that emits into all directions
    Camera, EnvironmentMap    point that emits into each pixel or bin

`refusal` refuses what cannot be run backward: sources that no history reaches (a Point, any Beam); particles
and time; detector options that need a history's past (via, events, times, speeds, moments); volumes; surfaces
that are not reciprocal (ThinLens, which does not conserve L/eta^2 equally from both sides; a TwoSided whose
sides transmit differently). Light that leaves a detector has no backward estimate: put a detector on the
other side. The `aim` of a source is ignored: the whole source counts.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from transport.geometry.flat import Disk, Rectangle
from transport.geometry.shape import Point
from transport.geometry.solid import Sphere
from transport.scene.cameras import PointInstrument
from transport.scene.detectors import Detector
from transport.scene.materials import (
    Surface,
    display_name,
)
from transport.scene.points import PointDetector
from transport.scene.sources import Source
from transport.validation import short_repr

if TYPE_CHECKING:
    from transport.scene.scene import Scene

SHAPES_WITH_POSITIONS = Disk | Rectangle | Sphere  # shapes with bins of position in which histories can start
TRANSMITTANCE_TOLERANCE = 1e-12  # tolerance of equal transmittances


def refusal(scene: Scene) -> str | None:
    """Reason why a scene cannot be run backward, as the end of a message; None if it can."""
    if scene.duration is not None:
        return f"it is time-dependent, got duration={scene.duration!r}; leave duration out"
    if scene.measured_in == "particles":
        return "it emits particles, not watts; write estimator='analog'"
    if not scene.detectors:
        return "it has no detector from which histories could start; write detectors=[...]"
    reasons = (
        *(_detector_refusal(scene, detector) for detector in scene.detectors),
        *(_source_refusal(scene, source, k) for k, source in enumerate(scene.sources)),
        *(_surface_refusal(scene, surface) for surface in scene.surfaces),
    )
    return next(filter(None, reasons), None)


def more_particles_or_backward(scene: Scene) -> str:
    """Cure for a forward run that hardly sampled some light; names "backward" only if the scene allows it."""
    return "use more particles" + ("" if refusal(scene) else ", or estimator='backward'")


def _detector_refusal(scene: Scene, detector: object) -> str | None:
    """Reason why a detector cannot be run backward; None if it can."""
    if isinstance(detector, PointInstrument | PointDetector):
        return None
    title = f"{type(detector).__name__} {detector.name!r}"
    if not isinstance(detector, Detector):
        return f"no history starts from {title}; use a Detector, an EnvironmentMap or estimator='analog'"
    shape = scene.shape_of(detector)
    if shape.is_infinite:
        return f"{title} must be finite, got {short_repr(shape)}; use a Rectangle or Disk in it"
    for name, value in detector.options_of_the_past.items():
        return f"{title} has {name}={short_repr(value)}, which only forward histories know; leave it out"
    if detector.positions is not None and not isinstance(shape, SHAPES_WITH_POSITIONS):
        return (
            f"{title} has positions on a {type(shape).__name__};"
            " leave them out, or use a Disk, Rectangle or Sphere"
        )
    if shape.triangles and getattr(detector.directions, "phi", None) is not None:
        return f"{title} bins phi on a Mesh; leave phi out of its directions"
    return None


def _source_refusal(scene: Scene, source: Source, number: int) -> str | None:
    """Reason why no history reaches a source; None if histories do."""
    title = f"sources[{number}]"
    if source.emission.law == "beam":
        return f"no history can hit the Beam of {title}; write estimator='analog'"
    if isinstance(scene.shape_of(source), Point):
        return f"no history can hit the Point of {title}; write estimator='expected', or use a small Sphere"
    return None


def _surface_refusal(scene: Scene, surface: Surface) -> str | None:
    """Reason why a surface is not reciprocal; None if it is."""
    title = display_name(surface, scene.surfaces.index(surface))
    for part in surface.material.elements:
        if not part.is_reciprocal:
            return (
                f"{title} is a {type(part).__name__}, which is not reciprocal;"
                " build it from Dielectric surfaces"
            )
    front, back = (side.shares for side in surface.material.sides)
    if (
        abs(front.diffuse_through - back.diffuse_through) > TRANSMITTANCE_TOLERANCE
        or abs(front.straight - back.straight) > TRANSMITTANCE_TOLERANCE
    ):
        return f"{title} transmits different shares from its two sides (not reciprocal); make them equal"
    return None
