"""Classes of paths that an estimator finds only by chance, and what a run may have missed of them.

The estimators "expected" and "backward" connect diffuse walls, collisions and births to a detector, or a
source, by rays.  Paths that no ray can connect score only if a flight happens to arrive: light whose last
vertex is specular, beams, light from very near, and, in a backward run, the direct view of a source.  These
flights have sums of their own, apart from those of rays, so a run knows how often each class scored.  A class
with fewer than MIN_SCORES_FOR_ERROR scores may contribute (U(n) - n) S / N more, with S the largest possible
score (findings.unseen_scores); a class that geometry proves to be empty is left out.

Every other estimator finds all light by chance, which is one class.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from transport.compile import method_backward
from transport.compile.layout import SIZE_CELLS
from transport.compile.next_event import side_of
from transport.compile.volumes import EDGES, LARGE_SHARE
from transport.results.diagnostics.proofs import (
    bound_by_lines,
    bound_by_probe,
    events_of,
    is_hidden,
    max_transmitted_weight,
    miss_distance,
    no_probe_reason,
    specular_surfaces_of,
    surface_names,
    unconnected_sources,
)
from transport.scene.detectors import Detector
from transport.scene.emissions import Beam, Lambertian
from transport.scene.sides import IS_BACK, OTHER_SIDE
from transport.statistics.batches import MIN_SCORES_FOR_ERROR
from transport.statistics.findings import DOUBTFUL, MORE_PARTICLES, Finding, unseen_scores
from transport.validation import join_names

if TYPE_CHECKING:
    from transport.compile.adjoint import SensorPart
    from transport.compile.plan import Plan
    from transport.results.batches import Batch
    from transport.scene.scene import Scene
    from transport.scene.sources import Source

ALL_LIGHT = "all light"  # the class of all light of a detector, if it arrives only by chance


@dataclass(frozen=True)
class PathClass:
    """Paths found by chance.

    Their description, their number of scores, and the largest contribution of one score.
    """

    what: str
    scores: int
    largest: float
    cure: str
    seen: str = ""  # evidence from a guard around the detector
    surfaces: tuple[int, ...] = ()  # where all of it comes from, besides direct light of a lamp
    straight: float = 0.0  # bound of the direct light in the sum, from lines of sight; infinite if unknown
    name: str = "path class"  # of its entry in the table of diagnostics

    def finding(self, title: str, histories: float) -> Finding | None:
        """The finding for a run of so many histories; None if its error already includes the class."""
        if self.scores >= MIN_SCORES_FOR_ERROR or self.largest == 0:
            return None
        few = (
            f"only {self.scores} score{'s' * (self.scores > 1)} of {self.what}"
            if self.scores
            else f"{self.what} not sampled"
        )
        bound = unseen_scores(self.scores) * self.largest / histories
        times = MIN_SCORES_FOR_ERROR / self.scores if self.scores else math.nan
        return Finding(
            DOUBTFUL, title, "", few, bound, self.cure, name=self.name, times=times, seen=self.seen
        )


@dataclass(frozen=True)
class LampScores:
    """Numbers of flights and rays that reached a source, and of rays near the largest score (LARGE_SHARE)."""

    flights: int
    rays: int
    strong_rays: int


def detector_path_findings(
    plan: Plan, batches: list[Batch], title: str, name: str, side: int, scores: int, mean: float, error: float
) -> Iterator[Finding]:
    """Findings for a detector that histories arrive at, with bounds as mean weights of a history.

    side: 0 for arrivals;  scores: total number;  mean, error: of the mean weight of arrivals per history.
    """
    histories = sum(batch.histories for batch in batches)
    is_probed = all(emitter.target is None for emitter in plan.emitters)  # probes cannot use aims
    detector = _detector(plan, name)
    sided = Detector(detector.shape, name, side=OTHER_SIDE[detector.side] if side else detector.side)
    for each in _classes_of_detector(plan, batches, name, side, scores, mean):
        finding = each.finding(title, histories)
        if finding is not None and is_probed:
            finding = _with_probe_bound(
                plan.scene, sided, each, finding, histories, error, plan.unit, events=events_of(batches)
            )
        if finding is not None:
            yield finding
    expectation = next((each for each in plan.expectations if each.detector.name == name), None)
    if expectation is not None and expectation.scattered is not None:
        yield _near_collision_finding(plan, batches, title, name, side, mean, expectation.scattered)


def _with_probe_bound(
    scene: Scene,
    detector: Detector,
    light: PathClass,
    finding: Finding,
    histories: float,
    error: float,
    unit: float,
    gain: float = 1.0,
    lamp: Source | None = None,
    events: float = 0.0,
) -> Finding:
    """The finding with the bound from lines of sight and a probe, if that is smaller and matters.

    unit: of the bound [W];  gain: of a score.
    """
    straight = light.straight * gain
    if not (light.surfaces or straight) or finding.bound <= error or straight >= finding.bound:
        return finding
    if not light.surfaces:
        return replace(finding, bound=straight)
    if lamp is not None and not isinstance(lamp.emission, Lambertian):
        return finding
    bound, found = bound_by_probe(scene, detector, light.surfaces, histories, error * unit, lamp, events)
    if math.isinf(bound) and (why := no_probe_reason(scene, light.surfaces, lamp)):
        why = f"no probe bounds it: {why}"
        return replace(finding, seen=f"{finding.seen}; {why}" if finding.seen else why)
    bound += straight * unit
    if not bound < finding.bound * unit:
        return finding
    scores = found / unit / (light.largest * gain) * histories
    if light.scores or not scores > 0:
        return replace(finding, bound=bound / unit)
    return replace(
        finding, bound=bound / unit, times=max(MIN_SCORES_FOR_ERROR / scores, 1.0), about=found / bound
    )


def _near_collision_finding(
    plan: Plan,
    batches: list[Batch],
    title: str,
    name: str,
    side: int,
    mean: float,
    share: Callable[[float], float],
) -> Finding:
    """The finding about collisions near a detector in a medium, whose flights score up to their full weight.

    Collisions nearer than a distance e contribute at most about sigma_s e of the mean, the light scattered on
    such a length.  A beam that passes nearer than e contributes at most its scattered part on the path 2 e,
    times the score from so near.  From farther away a score has a limit.  The chosen distance gives the
    smallest bound.
    """
    scattering = max(float(np.max(getattr(medium, "scattering", 0.0))) for medium in plan.distinct_media)
    shape, histories = plan.scene.shape_of(_detector(plan, name)), sum(batch.histories for batch in batches)
    beams = [
        (emitter.bound / plan.unit, miss_distance(emitter.shape, emitter.source.emission.direction, shape))
        for emitter in plan.emitters
        if isinstance(emitter.source.emission, Beam)
    ]
    bounds = []
    for distance in np.geomspace(1e-2, 1e4, 61) * shape.extent:
        largest = share(distance)
        unseen = unseen_scores(count_large_scores(plan, batches, name, side, largest, 0))
        passing = math.fsum(2 * amount * share(apart) for amount, apart in beams if apart < distance)
        near = scattering * distance * (mean + passing)
        bounds.append(near + unseen * largest / histories)
    what = "light scattered very near not sampled"
    return Finding(
        DOUBTFUL,
        title,
        "",
        what,
        min(bounds),
        method_backward.more_particles_or_backward(plan.scene),
        name="path class",
    )


def _detector(plan: Plan, name: str) -> Detector:
    return next(detector for detector in plan.scene.meters if detector.name == name)


def _classes_of_detector(
    plan: Plan, batches: list[Batch], name: str, side: int, scores: int, mean: float
) -> Iterator[PathClass]:
    """The classes of a detector; `largest` in units of the largest birth weight."""
    expectation = next((each for each in plan.expectations if each.detector.name == name), None)
    is_aimed = all(emitter.target is not None for emitter in plan.emitters)
    heaviest = max(batch.heaviest for batch in batches) if is_aimed else 1.0
    # Without next-event estimation, all light arrives by chance.
    if expectation is None:
        if plan.scatters and (plan.reduces_weights or plan.splits or plan.forces_collisions):
            # Scattering reduces weights along the path, down to the limits of roulette and splitting
            # (depth.py).
            yield PathClass("light", scores, heaviest, MORE_PARTICLES, name=ALL_LIGHT)
            if not is_aimed:
                return
            born = sum(batch.born for batch in batches)
            heaviest *= min(mean * sum(batch.histories for batch in batches) / born, 1.0) if born > 0 else 0.0
        else:
            heaviest *= max_transmitted_weight(plan, plan.scene.shape_of(_detector(plan, name)))
        number = count_large_scores(plan, batches, name, side, heaviest, scores)
        what = "the heaviest births of an aimed source" if is_aimed else "light"
        if number < min(scores, MIN_SCORES_FOR_ERROR) and plan.attenuates and not is_aimed:
            what = "light that media hardly attenuate"
        yield PathClass(what, number, heaviest, MORE_PARTICLES, name=ALL_LIGHT)
        return
    scene, detector = plan.scene, expectation.detector
    side_seen = detector.side if side == 0 else OTHER_SIDE[detector.side]
    face = "back" if IS_BACK[side_seen] else "front"
    shape = scene.shape_of(detector)
    if side == 1 and isinstance(detector.shape, str):  # departures from a surface are counted by flights
        number = count_large_scores(plan, batches, name, side, 1.0, scores)
        yield PathClass("light", number, 1.0, MORE_PARTICLES, name=ALL_LIGHT)
        return
    # Flights: light that no ray connects.
    mirrors, beams = (
        specular_surfaces_of(scene, shape, side_seen),
        list(unconnected_sources(plan, shape, side_seen)),
    )
    unconnected = [*surface_names(scene, mirrors), *beams]
    largest = heaviest if unconnected else expectation.largest_flight_share[face]
    number = count_large_scores(plan, batches, name, side, largest, scores)
    what = f"light via {join_names(unconnected)}" if unconnected else "light from very near"
    seen, radius = _guard_counts(plan, batches, name) if unconnected and not number else ({}, 0.0)
    if seen:
        what = f"light via {join_names(list(seen))}"
    flights = " and ".join(
        f"{passed} flight{'s' * (passed > 1)} from {title}" for title, passed in seen.items()
    )
    yield PathClass(
        what,
        number,
        largest,
        _estimator_advice(scene),
        f"{flights} passed within {radius:.2g} m" if seen else "",
        () if beams else tuple(mirrors),
    )
    # Rays from walls and sources so near that a few of them matter.
    strongest = expectation.largest_score[face]
    rays = count_large_scores(plan, batches, name, side, strongest * expectation.scale, scores, block=1)
    yield PathClass(
        "light from near walls or sources", rays, strongest, "use more particles", name="strong rays"
    )


def sensor_path_findings(
    plan: Plan,
    title: str,
    sensor: object,
    parts: list[SensorPart],
    met: dict[int, LampScores],
    histories: float,
    error: float,
    heaviest: float = 1.0,
    events: float = 0.0,
) -> Iterator[Finding]:
    """Findings for a detector at which histories start; bounds are mean radiances of cells [W m^-2 sr^-1].

    met: scores by source, in cells with a large weight in the mean;  histories: that started there;  error:
    of the mean radiance;  heaviest: weight of a cell, relative to equal cells;  events: of the run.
    """
    scene = plan.adjoint.scene
    for number, each in _classes_of_sources(plan, sensor, parts, met, error, heaviest):
        finding = each.finding(title, histories) if isinstance(each, PathClass) else each
        if finding is None:
            continue
        gain = max(part.gains[number] for part in parts)
        finding = replace(finding, object=title, bound=finding.bound * gain)
        if isinstance(each, PathClass) and isinstance(sensor, Detector):
            lamp = plan.adjoint.sources[number].source
            unit = math.pi * scene.shape_of(sensor).area
            finding = _with_probe_bound(
                scene, sensor, each, finding, histories, error, unit, gain, lamp, events
            )
        yield finding


def _classes_of_sources(
    plan: Plan,
    sensor: object,
    parts: list[SensorPart],
    met: dict[int, LampScores],
    error: float,
    heaviest: float,
) -> Iterator[tuple[int, PathClass | Finding]]:
    """The path classes of each source by its index.

    `largest`, `straight` in units of a sum of 1 over one history.
    """
    scene = plan.adjoint.scene
    expected = {each.detector.name: each for each in plan.expectations}
    with_rays = {
        k: expected[lamp.detector.name]
        for k, lamp in enumerate(plan.adjoint.sources)
        if lamp.detector.name in expected
    }
    for number, lamp in enumerate(plan.adjoint.sources):
        if number not in met:
            continue
        # Flights: direct light of the lamp, and light via specular surfaces.
        shape, side = scene.shape_of(lamp.source), lamp.source.side if lamp.source.emission.has_side else None
        mirrors = specular_surfaces_of(scene, shape, side)
        seen = not is_hidden(scene, sensor, parts, shape, side)
        straight = 0.0
        if seen and met[number].flights < MIN_SCORES_FOR_ERROR:
            gain = max(part.gains[number] for part in parts)
            straight, is_shown = bound_by_lines(scene, sensor, number, parts, shape, side, error / gain)
            if not is_shown and not met[number].flights:
                seen = False
                what = f"direct light from {lamp.name!r}, which no sampled line of sight shows"
                yield (
                    number,
                    Finding(DOUBTFUL, "", "", what, straight, "use more particles", name="path class"),
                )
                straight = 0.0
        if mirrors or seen:
            origins = [f"from {lamp.name!r}"] * seen
            origins += [f"via {join_names(surface_names(scene, mirrors))}"] * bool(mirrors)
            yield (
                number,
                PathClass(
                    f"light {' or '.join(origins)}",
                    met[number].flights,
                    heaviest,
                    "use more particles",
                    surfaces=tuple(mirrors),
                    straight=straight,
                ),
            )
        if number not in with_rays:
            continue
        # Rays to the lamp: from collisions and from diffuse walls.
        each, rays, strong = with_rays[number], met[number].rays, met[number].strong_rays
        if each.collisions is not None:  # collisions may be so near that their rays have no other limit
            what = f"light from {lamp.name!r} via diffuse walls or scattering"
            yield number, PathClass(what, rays, heaviest / each.scale, "use more particles")
        if each.walls is not None:
            near = "walls near it" if rays else "diffuse walls"
            yield (
                number,
                PathClass(
                    f"light from {lamp.name!r} via {near}",
                    strong,
                    heaviest * each.largest_score[side_of(lamp.detector)],
                    "use more particles",
                    name="strong rays",
                ),
            )


def _guard_counts(plan: Plan, batches: list[Batch], name: str) -> tuple[dict[str, int], float]:
    """Number of flights from each surface that passed a guard around a detector, and its radius [m]."""
    guard = next((each for each in plan.guards if each.detector == name), None)
    if guard is None:
        return {}, 0.0
    first, seen = int(guard.row["first"]), {}
    for sheet, number in guard.surfaces.items():
        passed = int(sum(batch.sizes[first + sheet] for batch in batches))
        (title,) = surface_names(plan.scene, [number])
        if passed:
            seen[title] = seen.get(title, 0) + passed
    return seen, guard.radius


def count_large_scores(
    plan: Plan, batches: list[Batch], name: str, side: int, largest: float, scores: int, block: int = 0
) -> int:
    """Number of scores of at least a quarter (LARGE_SHARE) of the largest possible; all if they are alike.

    block: 0 for flights, 1 for rays, in their own unit.
    """
    blocks = plan.size_blocks.get((name, side))
    if blocks is None:
        return scores
    first = blocks[block]
    counts = sum(batch.sizes[first : first + SIZE_CELLS] for batch in batches)
    return int(counts[EDGES[:-1] >= LARGE_SHARE * largest].sum())


def _estimator_advice(scene: Scene) -> str:
    """The estimator that finds such light."""
    if method_backward.refusal(scene) is None:
        return "use estimator='backward'"
    return "use estimator='analog' with more particles or a larger detector"
