"""Methods: which events score at a detector (estimator), and how random numbers are drawn (sampling).

Estimators
  "analog"    score crossings.
  "aimed"     every source emits only towards the detector, with the exact weight: direct light only.
  "expected"  next-event estimation: each emission, diffuse or glossy reflection and collision scores its
              expected contribution to each detector, by flat mirrors too (images.py); light from others,
              glass and lenses scores on crossing.
  "backward"  histories start at the detectors and score the radiance of sources they reach; "random" only.
  "auto"      short pilot runs of each, then the cheapest: default with `error` or `seconds`
              ("analog" with `particles` alone).
Samplings
  "random"      independent histories (Philox).
  "stratified"  the numbers of each draw are stratified over the histories of a batch, each draw separately.
  "sobol"       as "stratified", and the numbers of a birth are one Owen-scrambled Sobol point, one dimension
                per number; each batch has its own scrambling.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from transport.compile.images import chains_of_mirrors
from transport.geometry.flat import Disk, Rectangle
from transport.geometry.relations import is_on
from transport.geometry.shape import Point, Shape
from transport.geometry.solid import Sphere
from transport.scene.bins import DirectionCone
from transport.scene.cameras import Instrument
from transport.scene.detectors import Detector
from transport.scene.parts import has_emission, named_media, surface_name
from transport.scene.points import PointDetector
from transport.validation import SceneError, name_hint, short_repr

if TYPE_CHECKING:
    from transport.scene.scene import Scene
    from transport.scene.sources import Source


ESTIMATORS = "analog", "aimed", "expected", "backward"  # the simplest first
# These estimate only light that arrives at detectors: no energy balance of all emitted light.
ARRIVALS_ONLY = "aimed", "backward"
SAMPLINGS = ("random", "stratified", "sobol")
AUTO = "auto"  # choose the cheapest of them
DEFAULT_BATCHES = 32  # default number of batches
# Default number of batches of "stratified" and "sobol" runs: few and large, because the error falls faster
# than 1/sqrt(N) with the size of a batch.
DEFAULT_QMC_BATCHES = 8
# default number of histories to learn a guide from: as many as the run has, within these limits; none in runs
# of fewer than LEAST_GUIDED
MIN_GUIDE, MAX_GUIDE, LEAST_GUIDED = 1 << 18, 1 << 20, 1 << 13
GUIDE = "guide=1_000_000"  # as cures write it


@dataclass(frozen=True)
class Method:
    """One method to estimate: the arguments estimator and sampling of `simulate`."""

    estimator: str = "analog"
    sampling: str = "random"
    guide: int = 0  # histories from which a density of births is learnt (compile/guides.py); 0: none

    @property
    def default_batches(self) -> int:
        """Default number of batches."""
        return DEFAULT_BATCHES if self.sampling == "random" else DEFAULT_QMC_BATCHES

    @property
    def title(self) -> str:
        """Name in reports."""
        sampling = "" if self.sampling == "random" else f", {self.sampling}"
        return f"{self.estimator}{sampling}{f', guide of {self.guide:.2g} histories' if self.guide else ''}"


ANALOG = Method()


def coerce_method(scene: Scene, estimator: str | None, sampling: str) -> Method:
    """Return the method of a run; SceneError if it is unknown or the scene does not allow it."""
    estimator = default_estimator(scene) if estimator is None else estimator
    choices = (*ESTIMATORS, AUTO)
    for what, value, known in (("estimator", estimator, choices), ("sampling", sampling, SAMPLINGS)):
        if value not in known:
            names = ", ".join(map(repr, known))
            raise SceneError(
                f"simulate: {what} must be one of {names}, got {value!r}; {name_hint(str(value), known)}"
            )
    if reason := refusal(scene, estimator):
        raise SceneError(f"simulate: estimator {estimator!r} does not go with this scene: {reason}")
    if not _are_compatible(estimator, sampling):
        cure = "leave sampling out"
        raise SceneError(f"simulate: sampling {sampling!r} does not go with estimator {estimator!r}; {cure}")
    return Method(estimator, sampling)


def guided(scene: Scene, method: Method, particles: float | None, guide: int | None) -> Method:
    """Return a run's method with the number of histories to learn a guide from.

    guide: as given. None for the default: backward runs have one where light comes by specular or glossy
    surfaces and births send no rays. Raise SceneError where it does not go with the scene or the method.
    """
    if guide is None:
        guide = method.guide or _default_guide(scene, method, particles)
    elif guide and (reason := next(_against_guide(scene, method), None)):
        raise SceneError(f"simulate: guide={guide} does not go with this run: {reason}")
    return replace(method, guide=guide)


def _default_guide(scene: Scene, method: Method, particles: float | None) -> int:
    """Return the number of histories to learn a guide from, where none is given."""
    is_useful = method.estimator == "backward" and next(_against_guide(scene, method), None) is None
    return _guide_for(scene, particles) if is_useful and not _connects_births(scene) else 0


def guided_methods(scene: Scene, particles: float | None) -> list[Method]:
    """Return the methods with a guide that may find light by specular or glossy surfaces."""
    guide = _guide_for(scene, particles)
    found = [replace(each, guide=guide) for each in methods_for(scene) if each.sampling == "random"]
    return [each for each in found if guide and next(_against_guide(scene, each), None) is None]


def _guide_for(scene: Scene, particles: float | None) -> int:
    """Return from how many histories a run learns a guide: none without specular and glossy surfaces."""
    if particles is not None and particles < LEAST_GUIDED:
        return 0
    parts = [(surface, part) for surface in scene.surfaces for part in surface.material.elements]
    if not any(surface.material.is_specular or part.shares.glossy > 0 for surface, part in parts):
        return 0
    return MAX_GUIDE if particles is None else min(max(int(particles), MIN_GUIDE), MAX_GUIDE)


def _connects_births(scene: Scene) -> bool:
    """Return whether births of a backward run send rays to all lamps and to all their images in mirrors."""
    shapes = [scene.shape_of(source) for source in scene.sources]
    if any(getattr(detector, "directions", None) is not None for detector in scene.detectors):
        return False
    if has_emission(scene) or any(source.emission.fills_volume for source in scene.sources):
        return False
    return all(map(can_sample_points_on, shapes)) and chains_of_mirrors(scene, tuple(shapes)) is not None


def _against_guide(scene: Scene, method: Method) -> Iterator[str]:
    """Yield the reasons why a run does not allow a guide, with the cure."""
    if method.sampling != "random":
        yield f"it needs sampling 'random', got {method.sampling!r}; leave one of them out"
    if method.estimator == "aimed":
        yield "estimator 'aimed' aims all births; write estimator='analog' or 'expected'"
    if method.estimator == "backward":
        for number, source in enumerate(scene.sources):
            if found_by_rays_alone(scene, source):
                yield f"no history arrives at sources[{number}], a Point or a Beam; leave guide out"
        for detector in scene.detectors:
            if not _has_one_cell(detector):
                title = f"{type(detector).__name__} {detector.name!r}"
                yield f"{title} has bins, in each of which histories start anyhow; leave guide out"
    else:
        if not scene.meters:
            yield "it learns from Detectors on surfaces, and there is none; leave guide out"
        for number, source in enumerate(scene.sources):
            if source.aim is not None:
                yield f"sources[{number}] has aim={short_repr(source.aim)}; leave one of them out"


def _has_one_cell(detector: object) -> bool:
    """Return whether all histories that start at a detector start from one cell."""
    if isinstance(detector, PointDetector):
        return True
    is_one = isinstance(detector, Detector) and detector.positions is None
    return is_one and (detector.directions is None or isinstance(detector.directions, DirectionCone))


def default_estimator(scene: Scene) -> str:
    """Return the estimator of a run that names none."""
    return "backward" if scene.instruments else "analog"


def _are_compatible(estimator: str, sampling: str) -> bool:
    """Return whether they combine: backward histories are spread over bins, which breaks up point nets."""
    return estimator != "backward" or sampling == "random"


def refusal(scene: Scene, estimator: str) -> str | None:
    """Reason why a scene does not allow an estimator, as the end of a message; None if it does."""
    if scene.instruments and estimator != "backward":
        seen = scene.instruments[0]
        title = f"{type(seen).__name__} {seen.name!r}"
        against = refusal(scene, "backward")
        also = f", but {against}" if against else "; write estimator='backward'"
        return f"only backward histories reach {title}{also}"
    return next(REASONS_AGAINST[estimator](scene), None)


def methods_for(scene: Scene) -> list[Method]:
    """All methods that a scene allows, the simplest first."""
    allowed = [estimator for estimator in ESTIMATORS if refusal(scene, estimator) is None]
    return [
        Method(one, sampling) for one in allowed for sampling in SAMPLINGS if _are_compatible(one, sampling)
    ]


# ---- Estimator "aimed": every source emits only towards the one detector: direct light only.
#
# Weights correct for the restricted directions exactly. Light in other directions is not traced, so that
# nothing in the scene may redirect it to the detector.


def aimed_scene(scene: Scene) -> Scene:
    """The scene with every source aimed at its one detector; SceneError if a source cannot be aimed."""
    (detector,) = scene.detectors
    aim = scene.shape_of(detector)
    return replace(scene, sources=tuple(replace(source, aim=aim) for source in scene.sources))


def unaimed_scene(scene: Scene) -> Scene:
    """The original scene of an aimed one; its sources had no aim."""
    return replace(scene, sources=tuple(replace(source, aim=None) for source in scene.sources))


def _against_aimed(scene: Scene) -> Iterator[str]:
    """Yield the reasons why a scene does not allow "aimed", with the cure."""
    if len(scene.detectors) != 1 or not isinstance(scene.detectors[0], Detector):
        names = _names_of_detectors(scene) or "none"
        yield f"it needs exactly one Detector, got {names}; leave the others out, or aim sources yourself"
        return
    if has_emission(scene):
        yield "a medium emits and cannot be aimed; leave its emission out"
    (detector,) = scene.detectors
    for number, source in enumerate(scene.sources):
        if source.aim is not None:
            yield f"sources[{number}] already has aim={short_repr(source.aim)}; leave it out"
        if scene.shape_of(source) == scene.shape_of(detector):
            yield f"sources[{number}] lies on the shape of detector {detector.name!r}; put it elsewhere"
    # Surfaces and media may redirect light to the detector.
    cure = "write estimator='expected' or 'backward'"
    for number, surface in enumerate(scene.surfaces):
        for part in surface.material.elements:
            if part.redirects:
                yield f"{surface_name(scene, number)} redirects light, got {short_repr(part)}; {cure}"
    for medium in named_media(scene):
        if np.max(medium.scattering) > 0:
            yield f"a medium scatters, got {short_repr(medium)}; {cure}"
    try:
        aimed_scene(scene)
    except SceneError as error:
        yield str(error)


def _names_of_detectors(scene: Scene) -> str:
    return ", ".join(f"{type(part).__name__} {part.name!r}" for part in scene.detectors)


# ---- Estimator "expected": next-event estimation serves some detectors; others score crossings.


def _against_expected(scene: Scene) -> Iterator[str]:
    """Yield the reasons why a scene does not allow "expected", with the cure."""
    if scene.duration is not None:
        yield f"it is time-dependent, got duration={scene.duration!r}; leave duration out"
    if not scene.detectors:
        yield "it has no detector to which rays could be sent; write detectors=[...]"
    if scene.points:
        yield f"PointDetector {scene.points[0].name!r} casts its own rays; run it in a separate scene"
    if not any(uses_next_event(scene, detector) for detector in scene.meters):
        for detector in scene.meters:
            for name, value in detector.options_of_crossings.items():
                of = f"Detector {detector.name!r} has {name}={short_repr(value)}"
                yield f"{of}, which only a particle's own crossing can score; leave it out"
        got = _names_of_detectors(scene)
        shapes = "a Rectangle, Disk, Triangle, Polygon or whole Sphere"
        yield f"it cannot sample points on {got}; use a Detector on {shapes}"


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


# ---- Estimator "backward": histories start at the detectors and score the radiance of sources they reach.
#
# Light can be traced in either direction: along a ray L/eta^2 is constant, and reflection and scattering are
# reciprocal. The radiance that arrives at a detector is therefore the mean, over histories sent out from it,
# of their weight times L_s (eta_d/eta_s)^2 of each source that they reach (Veach 1997, chapters 4 and 5).
# Histories are distributed equally over the detector's bins, so that a bin of a ten-thousandth of all
# directions costs no more than all directions. At diffuse and glossy surfaces and collisions they also cast
# shadow rays to the sources (as "expected" does to detectors), so that small bright sources are not left to
# chance. Light of the first flight, and from curved mirrors and dielectrics, is scored on arrival; what these
# send on to walls that a camera sees is brought by histories from the sources (compile/caustics.py). The
# energy balance is that of all these histories, with unit 1.
#
# What each part becomes (all others are unchanged):
#
#     Lambertian source         detector on its side: arriving weight times radiance
#     Point source              target of shadow rays: their pdf / r^2 times intensity (compile/lamps.py)
#     Beam from a flat shape    target of shadow rays against it: their pdf times irradiance
#     Isotropic volume source   volume detector: weight times path length times emission per m^3 and sr
#     emitting medium           the same, over its body
#     Detector                  source with cosine law into its bins, from its receiving side
#     PointDetector             point that emits into all directions
#     Camera, EnvironmentMap    point that emits into each pixel or bin
#
# What cannot be run backward is refused: light of Points and Beams by way of specular surfaces (other than
# that of Points by flat mirrors whose chains end: compile/images.py), or in bins of direction; particles and
# time; options of detectors that need a history's past (Detector.options_of_the_past); volumes; surfaces that
# are not reciprocal (ThinLens, which does not conserve L/eta^2 equally from both sides; a TwoSided whose
# sides transmit differently). Light that leaves a detector has no backward estimate: put a detector on the
# other side. The `aim` of a source is ignored: the whole source counts.

SHAPES_WITH_POSITIONS = Disk | Rectangle | Sphere  # shapes with bins of position in which histories can start
TRANSMITTANCE_TOLERANCE = 1e-12  # tolerance of equal transmittances


def cure_of_chance(scene: Scene, method: Method) -> str:
    """Cure for a run that meets light of mirrors, glass or gloss by chance: what it does not use yet."""
    others = []
    if method.estimator != "backward" and refusal(scene, "backward") is None:
        others.append("estimator='backward'")
    if not method.guide and next(_against_guide(scene, replace(method, sampling="random")), None) is None:
        others.append(GUIDE)
    if not method.guide and method.estimator != "backward" and others:
        return f"use {'' if method.sampling == 'random' else 'random sampling and '}{' or '.join(others)}"
    return f"use {' or '.join(['more particles', *others])}"


def more_particles_or_backward(scene: Scene) -> str:
    """Cure for a forward run that hardly sampled some light; names "backward" only if the scene allows it."""
    return "use more particles" + ("" if refusal(scene, "backward") else ", or estimator='backward'")


def _against_backward(scene: Scene) -> Iterator[str]:
    """Yield the reasons why a scene does not allow "backward", with the cure.

    No other estimator is a cure where a Camera or an EnvironmentMap needs this one.
    """
    removal = next((f"take out {type(each).__name__} {each.name!r}" for each in scene.instruments), None)
    analog = removal or "write estimator='analog'"
    if scene.duration is not None:
        yield f"it is time-dependent, got duration={scene.duration!r}; leave duration out"
    if scene.measured_in == "particles":
        yield f"it emits particles, not watts; {analog}"
    if not scene.detectors:
        yield "it has no detector from which histories could start; write detectors=[...]"
    for detector in scene.detectors:
        yield from _against_sensor(scene, detector)
    for number, source in enumerate(scene.sources):
        if found_by_rays_alone(scene, source):
            yield from _against_rays(scene, source, f"sources[{number}]", removal)
    for number, surface in enumerate(scene.surfaces):
        title = surface_name(scene, number)
        for part in surface.material.elements:
            if not part.is_reciprocal:
                yield (
                    f"{title} is a {type(part).__name__}, which is not reciprocal;"
                    " build it from Dielectric surfaces"
                )
        front, back = (side.shares for side in surface.material.sides)
        differences = front.diffuse_through - back.diffuse_through, front.straight - back.straight
        if max(map(abs, differences)) > TRANSMITTANCE_TOLERANCE:
            yield f"{title} transmits different shares from its two sides (not reciprocal); make them equal"


def _forward_method(scene: Scene, source: Source) -> str:
    """Return the arguments of a forward run that finds a source's light by mirrors, glass and gloss."""
    if refusal(scene, "expected") is not None:
        return f"estimator='analog' with {GUIDE}"
    is_specular = any(surface.material.is_specular for surface in scene.surfaces)
    shapes = [scene.shape_of(detector) for detector in scene.meters]
    is_connected = source.emission.law != "beam" and chains_of_mirrors(scene, tuple(shapes)) is not None
    is_sure = not is_specular or (is_connected and not detectors_without_next_event(scene))
    return f"estimator='expected'{'' if is_sure else f' with {GUIDE}'}"


def found_by_rays_alone(scene: Scene, source: Source) -> bool:
    """Return whether only shadow rays find a source in a backward run: a Point, or any Beam."""
    return source.emission.law == "beam" or isinstance(scene.shape_of(source), Point)


def _are_points_connected(scene: Scene) -> bool:
    """Return whether rays to Points find all their light by specular surfaces.

    So they do where flat mirrors alone are specular and all lamps that rays go to have finite chains of them
    (compile/images.py), and where nothing scatters, as no ray that is scattered once more goes to an image.
    """
    lamps = [(scene.shape_of(source), source.emission.fills_volume) for source in scene.sources]
    targets = tuple(
        shape
        for shape, is_volume in lamps
        if isinstance(shape, Point) or (not is_volume and can_sample_points_on(shape))
    )
    return not _scatters(scene) and chains_of_mirrors(scene, targets) is not None


def _scatters(scene: Scene) -> bool:
    """Return whether a medium scatters."""
    return any(np.max(medium.scattering) > 0 for medium in named_media(scene))


def _against_rays(scene: Scene, source: Source, title: str, removal: str | None) -> Iterator[str]:
    """Yield the reasons why shadow rays do not find all light of a Point or a Beam.

    removal: cure where no other estimator is one.
    """
    shape, is_beam = scene.shape_of(source), source.emission.law == "beam"
    what = f"the {'Beam' if is_beam else 'Point'} of {title}"
    lamp = "use a Disk that shines by Lambertian() from far away" if is_beam else "use a small Sphere"
    analog = removal or "write estimator='analog'"

    def instead(first: str) -> str:
        return f"{first}, or {removal}" if removal else f"write {_forward_method(scene, source)}, or {first}"

    if is_beam and (not shape.is_flat or shape.hole is not None):
        got = f"a {type(shape).__name__}{' with a hole' if shape.hole is not None else ''}"
        yield f"rays find a Beam from a whole flat shape only, got {got} in {title}; use a Disk, or {analog}"
    if not (is_beam or source.emission.ray_densities):
        yield f"the density of directions of {what} is not known to rays; {lamp}, or {analog}"
    # Light in single directions: no ray samples them, and no history can hit the source.
    is_connected = not is_beam and _are_points_connected(scene)
    for number, surface in enumerate(() if is_connected else scene.surfaces):
        sides = surface.material.sides
        is_glossy = any(side.shares.glossy > 0 for side in sides)
        if surface.material.is_specular or is_glossy:
            kind = "glossy" if is_glossy else "specular"
            lost = f"no ray finds light of {what} by way of {surface_name(scene, number)}, which is {kind}"
            yield f"{lost}; {instead(lamp)}"
    if not is_beam:
        for number, surface in enumerate(scene.surfaces):
            if is_on(shape.position, surface.shape):
                place = surface_name(scene, number)
                yield f"{what} lies on {place}, where rays end; {instead('move it off')}"
    for detector in scene.detectors:
        name = f"{type(detector).__name__} {detector.name!r}"
        if getattr(detector, "directions", None) is not None:
            got = short_repr(detector.directions)
            lost = f"no bin of directions of {name} holds the direct light of {what}, got {got}"
            yield f"{lost}; {instead(f'leave directions out, or {lamp}')}"
        if not is_beam and _scatters(scene) and getattr(detector, "position", None) == shape.position:
            yield f"{name} must not be at {what} where a medium scatters; move one of them"


def _against_sensor(scene: Scene, detector: object) -> Iterator[str]:
    """Yield the reasons why no history can start from a detector."""
    if isinstance(detector, Instrument | PointDetector):
        return
    title = f"{type(detector).__name__} {detector.name!r}"
    if not isinstance(detector, Detector):
        yield f"no history starts from {title}; use a Detector, an EnvironmentMap or estimator='analog'"
        return
    shape = scene.shape_of(detector)
    if shape.is_infinite:
        yield f"{title} must be finite, got {short_repr(shape)}; use a Rectangle or Disk in it"
    for name, value in detector.options_of_the_past.items():
        yield f"{title} has {name}={short_repr(value)}, which only forward histories know; leave it out"
    if detector.positions is not None and not isinstance(shape, SHAPES_WITH_POSITIONS):
        yield (
            f"{title} has positions on a {type(shape).__name__};"
            " leave them out, or use a Disk, Rectangle or Sphere"
        )
    if shape.triangles and getattr(detector.directions, "phi", None) is not None:
        yield f"{title} bins phi on a Mesh; leave phi out of its directions"


REASONS_AGAINST = {
    "analog": lambda scene: iter(()),
    "aimed": _against_aimed,
    "expected": _against_expected,
    "backward": _against_backward,
}
