"""The estimator "backward": histories start at the detectors and score the radiance of the sources that they come to.

Light may be followed either way: along a ray L/eta^2 stays, reflection and scattering are reciprocal.  So the radiance that
arrives at a detector is the mean, over histories sent out from it, of their weight times L_s (eta_d/eta_s)^2 of each source
that they come to (Veach 1997, chapters 4 and 5).  They are sent within the detector's own bins, as many into each: a bin of
a ten-thousandth of the directions costs no more than all of them.  On their way diffuse walls and collisions also send rays
to the sources (as "expected" does to detectors, engine/expecting.py), so that small bright ones are not left to chance;
what mirrors, glass and gloss send, and the first flight, is counted as it comes.  The ledger is that of these histories,
of unit 1.

What becomes of each part (the others stay as they are):

    Lambertian source         a meter on its side: the weight that arrives there, times its radiance
    Isotropic from a volume   a volume detector: weight times way, times its emission per volume and steradian
    a medium that emits       the same, over its body
    Detector                  a source by the cosine law into its bins, from the side that it looks at
    PointDetector             a point that sends out into all directions
    Camera, EnvironmentMap    a point that sends out into each pixel or bin

`why_not` refuses, by name, what does not go backwards: sources that no history comes to (a Point, any Beam); particles and
clocks; what a detector knows of a history's past (via, events, times, speeds, moments); volumes; surfaces that are not
reciprocal (ThinLens does not keep L/eta^2 from both sides alike; a TwoSided that lets unlike shares through).  What leaves
from a detector has no backward estimate: meter the other side.  The `aim` of a source plays no part: the whole source counts.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from transport.cameras import Camera, EnvironmentMap, Instrument
from transport.detectors import Detector
from transport.emissions import Beam
from transport.materials import (
    Diffuse,
    Material,
    Mirror,
    Mixture,
    Surface,
    ThinLens,
    Transparent,
    TwoSided,
    simple_parts,
)
from transport.materials.surface import titled
from transport.points import PointDetector
from transport.shapes import Disk, Mesh, Point, Rectangle, Sphere
from transport.sources import Source
from transport.validation import shown

if TYPE_CHECKING:
    from transport.scene import Scene

PLACED = Disk | Rectangle | Sphere  # whose bins of position histories start in
SAME = 1e-12  # of two shares that pass
UNKNOWING = ("times", "speeds", "via", "events")  # what a history that runs backwards cannot tell


def is_instrument(detector: object) -> bool:
    """Whether nothing but backward histories sees it."""
    return isinstance(detector, Camera | EnvironmentMap)


def why_not(scene: Scene) -> str | None:
    """Why a scene cannot be run backwards, as the end of a message; None where it can."""
    if scene.duration is not None:
        return f"it has a clock, got duration={scene.duration!r}; leave duration out"
    if scene.measured_in == "particles":
        return "it emits particles, not watts; write estimator='analog'"
    if not scene.detectors:
        return "it has no detector that histories could start from; write detectors=[...]"
    reasons = (
        *(_against_detector(scene, detector) for detector in scene.detectors),
        *(_against_source(scene, source, k) for k, source in enumerate(scene.sources)),
        *(_against_surface(scene, surface) for surface in scene.surfaces),
    )
    return next(filter(None, reasons), None)


def more_or_backward(scene: Scene) -> str:
    """What to do where a forward run has hardly met some light: a cure that names "backward" only if it takes the scene."""
    return "use more particles" + ("" if why_not(scene) else ", or estimator='backward'")


def _against_detector(scene: Scene, detector: object) -> str | None:
    if isinstance(detector, Instrument | PointDetector):
        return None
    title = f"{type(detector).__name__} {detector.name!r}"
    if not isinstance(detector, Detector):
        return f"no history starts from {title}; use a Detector, an EnvironmentMap or estimator='analog'"
    shape = scene.shape_of(detector)
    if shape.is_infinite:
        return f"{title} has no end, got {shown(shape)}; meter a Rectangle or Disk in it"
    for name in UNKNOWING:
        if (value := getattr(detector, name)) is not None:
            return f"{title} asks for {name}={shown(value)}, which only forward histories know; leave it out"
    if detector.moments:
        return f"{title} takes moments, which only forward histories know; leave moments out"
    if detector.positions is not None and not isinstance(shape, PLACED):
        return f"{title} has positions on a {type(shape).__name__}; leave them out, or use a Disk, Rectangle or Sphere"
    if isinstance(shape, Mesh) and getattr(detector.directions, "phi", None) is not None:
        return f"{title} bins phi on a Mesh; leave phi out of its directions"
    return None


def _against_source(scene: Scene, source: Source, number: int) -> str | None:
    title = f"sources[{number}]"
    if isinstance(source.emission, Beam):
        return f"no history comes back along the Beam of {title}; write estimator='analog'"
    if isinstance(scene.shape_of(source), Point):
        return f"no history comes to the Point of {title}; write estimator='expected', or let a small Sphere emit"
    return None


def _against_surface(scene: Scene, surface: Surface) -> str | None:
    title = titled(surface, scene.surfaces.index(surface))
    if any(isinstance(part, ThinLens) for part in simple_parts(surface.material)):
        return f"{title} is a ThinLens, which is not reciprocal; make it of Dielectric surfaces"
    if isinstance(surface.material, TwoSided):
        sides = [_passing(side) for side in (surface.material.front, surface.material.back)]
        if any(abs(a - b) > SAME for a, b in zip(*sides, strict=True)):
            return (
                f"{title} lets unlike shares through its two sides, which is not reciprocal; make them alike"
            )
    return None


def _passing(material: Material) -> tuple[float, float]:
    """The shares of what arrives at one side that pass diffusely, and straight on."""
    parts = material.parts if isinstance(material, Mixture) else ((material, 1.0),)
    diffuse = sum(share * part.transmission for part, share in parts if isinstance(part, Diffuse))
    straight = sum(share * part.transmission for part, share in parts if isinstance(part, Mirror))
    return diffuse, straight + sum(share for part, share in parts if isinstance(part, Transparent))
