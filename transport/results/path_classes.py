"""Classes of paths that an estimator finds by chance alone, and what a run may have missed of them.

"expected" and "backward" connect diffuse walls, collisions and births to a detector, or a lamp, by rays.  What no ray can
connect is counted only where a flight happens to come: light whose last vertex is specular, beams, what is very near, and,
of a run backwards, the direct view of a lamp.  These flights have sums of their own, apart from those of rays, so a run knows how
often each class has scored.  A class that scored fewer than MIN_SCORES times may be worth (U(n) - n) S / N more, where S
is the most that one score can bring (findings.unseen_scores); a class that geometry proves to be empty is left out.

Every other estimator counts all light by chance, which is one class.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from transport.compile.layout import SIZE_CELLS
from transport.compile.sizes import EDGES
from transport.emissions import Beam
from transport.estimators import backward
from transport.materials import Black, Diffuse, Material, Mirror, Transparent, TwoSided, simple_parts
from transport.materials.surface import titled
from transport.results.empty_detector import are_parted
from transport.results.findings import DOUBTFUL, MIN_SCORES, Finding, unseen_scores
from transport.results.quality import MORE
from transport.shapes import FlatShape, Shape
from transport.shapes.distances import is_behind
from transport.sides import OTHER_SIDE
from transport.validation import listed

if TYPE_CHECKING:
    from transport.compile.adjoint import Part
    from transport.compile.plan import Plan
    from transport.detectors import Detector
    from transport.results.batches import Batch
    from transport.scene import Scene
    from transport.sources import Source

LARGE = 0.25  # of the largest score: scores above it tell whether such large ones come

@dataclass(frozen=True)
class PathClass:
    """Paths that are found by chance: what they are, how often they scored, and the most that one score adds to the sum."""

    what: str
    scores: int
    largest: float
    cure: str

    def finding(self, title: str, histories: float) -> Finding | None:
        """What of it a run of so many histories may have missed; None where nothing that its error does not tell."""
        if self.scores >= MIN_SCORES or self.largest == 0:
            return None
        few = f"only {self.scores} score{'s' * (self.scores > 1)} of {self.what}" if self.scores else f"{self.what} not sampled"
        bound = unseen_scores(self.scores) * self.largest / histories
        times = MIN_SCORES / self.scores if self.scores else math.nan
        return Finding(DOUBTFUL, title, "", few, bound, self.cure, name="path class", times=times)


def chances_of_detector(
    plan: Plan, batches: list[Batch], title: str, name: str, side: int, scores: int, mean: float
) -> Iterator[Finding]:
    """What a detector that histories come to may have missed, with bounds as mean weights of a history.

    side: 0 for arrivals;  scores: how many there are in all;  mean: the mean weight of a history that came.
    """
    histories = sum(batch.histories for batch in batches)
    found = (each.finding(title, histories) for each in _classes_of_detector(plan, batches, name, side, scores))
    yield from filter(None, found)
    expectation = next((each for each in plan.expectations if each.detector.name == name), None)
    if expectation is not None and expectation.scattered is not None:
        yield _near_collisions(plan, batches, title, name, side, mean, expectation.scattered)


def _near_collisions(
    plan: Plan, batches: list[Batch], title: str, name: str, side: int, mean: float, share: Callable[[float], float]
) -> Finding:
    """Collisions near a detector in a medium, whose flights count up to all of their weight.

    Those nearer than a distance e bring at most about sigma_s e of the mean: that is how much of the light there is scattered on
    such a length.  From farther away a score has a limit.  The distance taken is that of the least bound.
    """
    scattering = max(float(np.max(getattr(medium, "scattering", 0.0))) for medium in plan.distinct_media)
    extent, histories = plan.scene.shape_of(_detector(plan, name)).extent, sum(batch.histories for batch in batches)
    bounds = []
    for distance in np.geomspace(1e-2, 1e4, 61) * extent:
        largest = share(distance)
        unseen = unseen_scores(large_scores(plan, batches, name, side, largest, 0))
        bounds.append(scattering * distance * mean + unseen * largest / histories)
    what = "light scattered very near not sampled"
    return Finding(DOUBTFUL, title, "", what, min(bounds), "use more particles, or estimator='backward'", name="path class")


def _detector(plan: Plan, name: str) -> Detector:
    return next(detector for detector in plan.scene.meters if detector.name == name)


def _classes_of_detector(
    plan: Plan, batches: list[Batch], name: str, side: int, scores: int
) -> Iterator[PathClass]:
    """Those of a detector; largest: in units of the largest weight at birth."""
    expectation = next((each for each in plan.expectations if each.detector.name == name), None)
    heaviest = max((batch.heaviest for batch in batches), default=0.0) or 1.0
    if expectation is None:
        number = scores if plan.lessens else large_scores(plan, batches, name, side, heaviest, scores)
        yield PathClass("light", number, heaviest, MORE)
        return
    scene, detector = plan.scene, expectation.detector
    looks = detector.side if side == 0 else OTHER_SIDE[detector.side]
    shape = scene.shape_of(detector)
    unconnected = [*mirrors_of(scene, shape, looks), *beams_of(plan, shape)]
    largest = 1.0 if unconnected else expectation.nearest
    flights, rays = (int(sum(batch.sizes[k : k + SIZE_CELLS].sum() for batch in batches)) for k in plan.size_blocks[name, side][:2])
    number = large_scores(plan, batches, name, side, largest, flights)
    what = f"light by {listed(unconnected)}" if unconnected else "light from very near"
    yield PathClass(what, number, largest, _cure(scene))
    yield PathClass("light that rays connect", rays, 1 / expectation.scale, "use more particles")


def classes_of_lamps(plan: Plan, sensor: object, parts: list[Part], met: dict[int, tuple[int, int]]) -> Iterator[tuple[int, PathClass]]:
    """Those of a detector that histories start from, of each lamp; met: by lamp how often flights and rays came to it.

    largest: in units of what a sum of 1 over one history is.
    """
    scene = plan.turned.scene
    expected = {each.detector.name: each for each in plan.expectations}
    told = {k: expected[lamp.seen_by.name] for k, lamp in enumerate(plan.turned.lamps) if lamp.seen_by.name in expected}
    scales = {k: 1 / each.scale for k, each in told.items() if each.walls is not None or each.collisions is not None}
    for number, lamp in enumerate(plan.turned.lamps):
        if number not in met:
            continue
        shape, side = scene.shape_of(lamp.source), lamp.source.side if lamp.source.emission.has_side else None
        mirrors = list(mirrors_of(scene, shape, side))
        seen = not _is_hidden(scene, sensor, parts, shape, side)
        if mirrors or seen:
            ways = [f"from {lamp.name!r}"] * seen + [f"by {listed(mirrors)}"] * bool(mirrors)
            yield number, PathClass(f"light {' or '.join(ways)}", met[number][0], 1.0, "use more particles")
        if number in scales:
            what = f"light from {lamp.name!r} by diffuse walls or scattering"
            yield number, PathClass(what, met[number][1], scales[number], "use more particles")


def large_scores(plan: Plan, batches: list[Batch], name: str, side: int, largest: float, scores: int) -> int:
    """How many scores of flights are at least a quarter of the largest that there can be; all where they are alike."""
    blocks = plan.size_blocks.get((name, side))
    if blocks is None:
        return scores
    counts = sum(batch.sizes[blocks[0] : blocks[0] + SIZE_CELLS] for batch in batches)
    return int(counts[EDGES[:-1] >= LARGE * largest].sum())


# ---- which of them are empty by proof ----


def mirrors_of(scene: Scene, shape: Shape, side: str | None) -> list[str]:
    """The surfaces whose mirrored or refracted light may come straight to a side of a shape; side: None for all."""
    found = []
    for number, surface in enumerate(scene.surfaces):
        if not is_specular(surface.material):
            continue
        if side is not None and isinstance(shape, FlatShape) and is_behind(surface.shape, shape, side):
            continue
        if _faces_away(surface.shape, surface.material, shape) or are_parted(scene, (shape, side), (surface.shape, None)):
            continue
        found.append(repr(surface.name) if surface.name else titled(surface, number))
    return found


def is_specular(material: Material) -> bool:
    """Whether light leaves a material into directions that no ray can connect: mirrors, glass, gloss and lenses."""
    return any(_is_specular(part) for part in simple_parts(material))


def _is_specular(part: Material) -> bool:
    if isinstance(part, Mirror):
        return part.reflectance > 0 or part.transmission > 0
    return not isinstance(part, Black | Diffuse | Transparent)


def _faces_away(mirror: Shape, material: Material, shape: Shape) -> bool:
    """Whether a flat surface of which only one side is specular has that side turned away from all of a shape."""
    if not (isinstance(mirror, FlatShape) and isinstance(material, TwoSided)):
        return False
    sides = {"front": material.front, "back": material.back}
    specular = [side for side, each in sides.items() if is_specular(each)]
    return len(specular) == 1 and is_behind(shape, mirror, specular[0])


def beams_of(plan: Plan, shape: Shape) -> Iterator[str]:
    """The sources whose births no ray connects and which may come straight to a shape."""
    for emitter in plan.emitters:
        emission = emitter.source.emission
        if isinstance(emission, Beam) and not _misses(emitter.shape, emission.direction, shape):
            yield _source_name(plan.scene, emitter.source)


def _misses(origin: Shape, direction: tuple[float, float, float], shape: Shape) -> bool:
    """Whether balls about both lie so that no parallel ray from the one comes to the other."""
    if origin.is_infinite or shape.is_infinite:
        return False
    way = np.subtract(shape.middle, origin.middle)
    along = float(np.dot(way, direction))
    aside = math.sqrt(max(float(np.dot(way, way)) - along * along, 0.0))
    return aside > origin.extent + shape.extent or along < -(origin.extent + shape.extent)


def _source_name(scene: Scene, source: Source) -> str:
    numbers = [number for number, each in enumerate(scene.sources) if each is source]
    return f"sources[{numbers[0]}]" if numbers else "an emitting medium"


def _is_hidden(scene: Scene, sensor: object, parts: list[Part], lamp: Shape, side: str | None) -> bool:
    """Whether geometry proves that no light of a lamp comes straight to a sensor."""
    looks = getattr(sensor, "side", None)
    for part in parts:
        if looks is not None and isinstance(part.shape, FlatShape) and is_behind(lamp, part.shape, looks):
            continue
        if side is not None and isinstance(lamp, FlatShape) and is_behind(part.shape, lamp, side):
            continue
        if not are_parted(scene, (part.shape, looks), (lamp, side)):
            return False
    return True


def _cure(scene: Scene) -> str:
    """What finds such light."""
    if backward.why_not(scene) is None:
        return "use estimator='backward'"
    return "use estimator='analog' with more particles or a larger detector"
