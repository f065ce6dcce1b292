"""Classes of paths that an estimator finds only by chance, and what a run may have missed of them.

The estimators "expected" and "backward" connect diffuse and glossy walls, collisions and births to a
detector, or a source, by rays.  Paths that no ray can connect score only if a flight happens to arrive: light
whose last vertex is specular, beams, light from very near or in the middle of a narrow glossy lobe, of which
rays have a small share, and, in a backward run, the direct view of a source.  These
flights have sums of their own, apart from those of rays, so a run knows how often each class scored.  A class
with fewer than MIN_SCORES_FOR_ERROR scores may contribute (U(n) - n) S / N more, with S the largest possible
score (findings.unseen_scores); a class that geometry proves to be empty is left out.

Every other estimator finds all light by chance, which is one class.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from transport.compile.detectors import LARGE_SHARE
from transport.compile.guides import LEAST
from transport.compile.lamps import diffuse_pieces, least_path, strongest_ray
from transport.compile.methods import cure_of_chance, more_particles_or_backward
from transport.compile.next_event import side_of
from transport.results.diagnostics.empty_detector import proven
from transport.results.diagnostics.proofs import (
    DirectView,
    Probe,
    cones_of,
    events_of,
    glossy_surfaces_of,
    max_transmitted_weight,
    mirrors_and_gloss,
    miss_distance,
    nearest_rays,
    pixels_of,
    sees_mirrors,
    specular_surfaces_of,
    surface_names,
    unconnected_sources,
)
from transport.results.diagnostics.score_sizes import count_large_scores
from transport.results.tally import ARRIVALS, DEPARTURES
from transport.scene.detectors import Detector
from transport.scene.sides import IS_BACK, OTHER_SIDE
from transport.statistics.batches import MIN_SCORES_FOR_ERROR
from transport.statistics.chunked import batch_totals, independent_scores, over_batches
from transport.statistics.findings import MORE_PARTICLES, USE_MORE, Finding, doubtful, unseen_scores
from transport.validation import join_names

if TYPE_CHECKING:
    from transport.compile.next_event import Expectation
    from transport.compile.plan import Plan
    from transport.results.backward import BackwardReading, CellSums, ViewReading
    from transport.results.detectors import Reading
    from transport.scene.cameras import Instrument
    from transport.scene.scene import Scene
    from transport.scene.sources import Source
    from transport.statistics.estimates import Estimate

ALL_LIGHT = "all light"  # the class of all light of a detector, if it arrives only by chance
EQUAL_WEIGHTS_TOLERANCE = 1e-9  # relative difference below which weights of cells are equal


@dataclass(frozen=True)
class PathClass:
    """Paths found by chance.

    Their description, their number of scores, and the largest contribution of one score.  Of guided births
    the number is that of plain births of the same sum.
    """

    what: str
    scores: float
    largest: float
    cure: str = USE_MORE
    seen: str = ""  # evidence from a guard around the detector
    surfaces: tuple[int, ...] = ()  # where all of it comes from, besides direct light of a lamp
    straight: float = 0.0  # bound of the direct light in the sum, from lines of sight; infinite if unknown
    gain: float = 1.0  # of `largest` and `straight`, in the unit of the bound
    is_guided: bool = False
    name: str = "path class"  # of its entry in the table of diagnostics

    def findings(self, histories: float) -> tuple[Finding, ...]:
        """The finding for a run of so many histories; none if its error already includes the class."""
        if self.largest == 0 or (self.scores >= MIN_SCORES_FOR_ERROR and not self.is_guided):
            return ()
        worth = self.largest / histories * self.gain
        if self.is_guided:
            # However much the births that it sends bring, only the others would meet what it has missed.
            what, bound = f"{self.what} beyond the guide not sampled", unseen_scores(0) * worth
            return (doubtful(self.name, what, bound, self.cure, is_foretold=self.scores > 0),)
        number = int(self.scores)
        few = (
            f"only {number} score{'s' * (number > 1)} of {self.what}"
            if number
            else f"{self.what} not sampled"
        )
        bound = unseen_scores(self.scores) * worth
        times = MIN_SCORES_FOR_ERROR / self.scores if self.scores else math.nan
        return (doubtful(self.name, few, bound, self.cure, times=times, seen=self.seen),)


@dataclass(frozen=True)
class ProbedRun:
    """A run whose findings about path classes probes may bound.

    detector: with the side concerned;  histories, events: of the run;  error: of the mean that the bounds
    concern;  unit: of that mean [W].
    """

    scene: Scene
    detector: Detector
    histories: float
    events: int
    error: float
    unit: float

    def bounded(self, finding: Finding, light: PathClass, lamp: Source | None = None) -> Finding:
        """The finding with the bound from lines of sight and a probe, if that is smaller and matters."""
        straight = light.straight * light.gain
        if not (light.surfaces or straight) or finding.bound <= self.error or straight >= finding.bound:
            return finding
        if finding.is_foretold:  # a probe would find the light that has scored, too
            return finding
        if not light.surfaces:
            return replace(finding, bound=straight)
        if lamp is not None and lamp.emission.law != "lambertian":
            return finding
        probe = Probe(self.scene, self.detector, light.surfaces, lamp)
        bound, found = probe.bound(self.histories, self.error * self.unit, self.events)
        if math.isinf(bound) and (why := probe.refusal):
            why = f"no probe bounds it: {why}"
            return replace(finding, seen=f"{finding.seen}; {why}" if finding.seen else why)
        bound += straight * self.unit
        if not bound < finding.bound * self.unit:
            return finding
        scores = found / self.unit / (light.largest * light.gain) * self.histories
        if light.scores or not scores > 0:
            return replace(finding, bound=bound / self.unit)
        times = max(MIN_SCORES_FOR_ERROR / scores, 1.0)
        return replace(finding, bound=bound / self.unit, times=times, about=found / bound)


# ---- Forward runs: classes of a detector that histories arrive at.


def detector_path_findings(tally: Reading, side: int, total: Estimate) -> Iterator[Finding]:
    """Findings for arrivals at a detector, or departures, with bounds as mean weights of a history.

    total: the mean weight of that side per history.
    """
    plan, detector = tally.plan, tally.detector
    sided = Detector(detector.shape, tally.name, side=OTHER_SIDE[detector.side] if side else detector.side)
    run = ProbedRun(plan.scene, sided, tally.particles, events_of(tally.batches), total.error, plan.unit)
    is_aimed = any(emitter.target is not None for emitter in plan.emitters)  # probes cannot use aims
    for light in _classes_of_detector(tally, side, total.value):
        for finding in light.findings(tally.particles):
            yield finding if is_aimed else run.bounded(finding, light)
    if tally.expectation is not None and tally.expectation.scattered is not None:
        yield _near_collision_finding(tally, side, total.value, tally.expectation.scattered)


def _near_collision_finding(
    tally: Reading, side: int, mean: float, share: Callable[[float], float]
) -> Finding:
    """The finding about collisions near a detector in a medium, whose flights score up to their full weight.

    Collisions nearer than a distance e contribute at most about sigma_s e of the mean, the light scattered on
    such a length.  A beam that passes nearer than e contributes at most its scattered part on the path 2 e,
    times the score from so near.  From farther away a score has a limit.  The chosen distance gives the
    smallest bound.
    """
    plan, shape = tally.plan, tally.shape
    scattering = max(float(np.max(getattr(medium, "scattering", 0.0))) for medium in plan.distinct_media)
    beams = [
        (emitter.bound / plan.unit, miss_distance(emitter.shape, emitter.source.emission.direction, shape))
        for emitter in plan.emitters
        if emitter.source.emission.law == "beam"
    ]
    bounds = []
    for distance in np.geomspace(1e-2, 1e4, 61) * shape.extent:
        largest = share(distance)
        unseen = unseen_scores(count_large_scores(tally, side, largest, 0))
        passing = math.fsum(2 * amount * share(apart) for amount, apart in beams if apart < distance)
        near = scattering * distance * (mean + passing)
        bounds.append(near + unseen * largest / tally.particles)
    cure = more_particles_or_backward(plan.scene)
    return doubtful("path class", "light scattered very near not sampled", min(bounds), cure)


def _classes_of_detector(tally: Reading, side: int, mean: float) -> Iterator[PathClass]:
    """The classes of a detector; `largest` in units of the largest birth weight."""
    plan, scores = tally.plan, tally.number_of(tally.main[side])
    is_aimed = all(emitter.weighs_births for emitter in plan.emitters)
    heaviest = max(batch.heaviest for batch in tally.batches) if is_aimed else 1.0
    # Without next-event estimation, all light arrives by chance.
    expectation = tally.expectation
    if expectation is None:
        if plan.scatters and (plan.reduces_weights or plan.splits or plan.forces_collisions):
            # Scattering reduces weights along the path, down to the limits of roulette and splitting
            # (depth.py).
            yield PathClass("light", scores, heaviest, MORE_PARTICLES, name=ALL_LIGHT)
            if not is_aimed:
                return
            born = sum(batch.born for batch in tally.batches)
            heaviest *= min(mean * tally.particles / born, 1.0) if born > 0 else 0.0
        else:
            heaviest *= max_transmitted_weight(plan, tally.shape)
        number = count_large_scores(tally, side, heaviest, scores)
        what = "the heaviest births" if is_aimed and not plan.is_guided else "light"
        if number < min(scores, MIN_SCORES_FOR_ERROR) and plan.attenuates and not is_aimed:
            what = "light that media hardly attenuate"
        yield PathClass(what, number, heaviest, MORE_PARTICLES, is_guided=plan.is_guided, name=ALL_LIGHT)
        return
    scene, detector, shape = plan.scene, expectation.detector, tally.shape
    side_seen = detector.side if side == ARRIVALS else OTHER_SIDE[detector.side]
    face = "back" if IS_BACK[side_seen] else "front"
    if side == DEPARTURES and isinstance(detector.shape, str):  # counted by flights
        number = count_large_scores(tally, side, 1.0, scores)
        yield PathClass("light", number, 1.0, MORE_PARTICLES, is_guided=plan.is_guided, name=ALL_LIGHT)
        return
    # Flights: light that no ray connects.
    is_linked = plan.links is not None and all(expectation.births)
    mirrors = [] if is_linked else specular_surfaces_of(scene, shape, side_seen)
    beams = list(unconnected_sources(plan, shape, side_seen))
    unconnected = [*surface_names(scene, mirrors), *beams]
    largest = heaviest if unconnected else heaviest * expectation.largest_flight_share[face]
    number = count_large_scores(tally, side, largest, scores)
    what = f"light via {join_names(unconnected)}" if unconnected else "light from very near"
    if not unconnected and 0 < largest == heaviest * expectation.largest_glossy_share[face]:
        glossy = glossy_surfaces_of(scene, shape, side_seen)
        what = f"light in the middle of the lobes of {join_names(surface_names(scene, glossy))}"
    seen, radius = _guard_counts(tally) if unconnected and not number else ({}, 0.0)
    if seen:
        what = f"light via {join_names(list(seen))}"
    flights = " and ".join(
        f"{passed} flight{'s' * (passed > 1)} from {title}" for title, passed in seen.items()
    )
    evidence = f"{flights} passed within {radius:.2g} m" if seen else ""
    yield PathClass(
        what,
        number,
        largest,
        cure_of_chance(scene, plan.method),
        "" if plan.is_guided else evidence,
        () if beams else tuple(mirrors),
        is_guided=plan.is_guided,
    )
    # Rays from walls and sources so near that a few of them matter.
    strongest = expectation.largest_score[face]
    rays = count_large_scores(tally, side, strongest * expectation.scale, scores, block=1)
    yield PathClass("light from near walls or sources", rays, strongest, name="strong rays")


def _guard_counts(tally: Reading) -> tuple[dict[str, int], float]:
    """Number of flights from each surface that passed a guard around a detector, and its radius [m]."""
    guard = next((each for each in tally.plan.guards if each.detector == tally.name), None)
    if guard is None:
        return {}, 0.0
    first, seen = int(guard.row["first"]), {}
    for sheet, number in guard.surfaces.items():
        passed = int(sum(batch.sizes[first + sheet] for batch in tally.batches))
        (title,) = surface_names(tally.plan.scene, [number])
        if passed:
            seen[title] = seen.get(title, 0) + passed
    return seen, guard.radius


# ---- Backward runs: classes of each source, which histories from a detector reach.


def cell_path_findings(
    tally: BackwardReading | ViewReading, extents: list[np.ndarray] | None = None
) -> Iterator[Finding]:
    """Findings for a detector at which histories start; bounds are mean radiances of cells [W m^-2 sr^-1].

    extents: of each part's cells, as weights of the mean; None for equal weights.
    """
    sums, plan, sensor = tally.cell_sums, tally.plan, tally.detector
    scene, share = plan.adjoint.scene, sum(part.share for part in sums.parts)
    histories = share * sums.run.histories
    # Choose the cells with a large weight in the mean.
    heaviest, chosen = 1.0, [None] * len(sums.parts)
    if extents is not None:
        weights = _relative_cell_weights(sums, extents)
        most = max(float(each.max()) for each in weights)
        if most > 1 + EQUAL_WEIGHTS_TOLERANCE:  # scores in small cells do not represent those in large ones
            heaviest, chosen = most, [each >= LARGE_SHARE * most for each in weights]
    error = 0.0
    if not sums.is_view:
        each = sum(part.share * mean.mean(axis=1) for part, mean in zip(sums.parts, sums.means, strict=True))
        error = float(np.std(each) / np.sqrt(len(each))) / share
    # Compare the bound of each source's classes with those of lines of sight and probes.
    is_probed = isinstance(sensor, Detector)
    unit = math.pi * scene.shape_of(sensor).area if is_probed else math.nan
    run = ProbedRun(scene, sensor, histories, events_of(sums.batches), error, unit)
    for number in sums.lamps:
        lamp, met = plan.adjoint.sources[number].source, _lamp_scores(sums, number, chosen)
        for light in _classes_of_source(plan, sums, sensor, number, met, error, heaviest):
            if isinstance(light, Finding):
                yield light
                continue
            for finding in light.findings(histories):
                yield run.bounded(finding, light, lamp) if is_probed else finding


def pixel_path_findings(tally: ViewReading) -> Iterator[Finding]:
    """Findings for each pixel or bin; bounds are radiances [W m^-2 sr^-1], in the shape of `radiance`.

    A glint or a caustic may fill a pixel alone, so that no other one tells what it may have missed. Where it
    may show a lamp, or a mirror, glass or gloss on the way from one, its own flights alone find such light.
    On diffuse walls they share it with histories from the lamp.
    """
    sums, sensor = tally.cell_sums, tally.detector
    (part,), scene = sums.parts, sums.plan.adjoint.scene
    births = np.maximum(over_batches(sums.rows_of(part, "counts", 0)), 1)
    cones = cones_of(sensor) if sensor.sees_from_point else None
    shows_mirrors = pixels_of(sensor, mirrors_and_gloss(scene), cones)
    for number in sums.lamps:
        lamp = sums.adjoint.sources[number]
        if not isinstance(lamp.detector, Detector):
            continue
        ways = _ways_to(sums, sensor, number)
        flights = scores = independent_scores(sums.rows_of(part, "weights", 1 + number))
        share = ways.rays.largest_glossy_share[side_of(lamp.detector)] if ways.glossy else 0.0
        shares = np.where(shows_mirrors, share, 0.0)
        if ways.mirrors and sums.view is not None:
            shares = np.maximum(shares, _shares_of_flights(sums, sensor, number))
            brought = sum(sums.brought_in(batch, part, number) for batch in sums.batches) / len(sums.batches)
            scores = scores + brought * births / part.gains[number]
        lamps = [] if ways.view.is_hidden else [scene.shape_of(lamp.source)]
        is_alone = pixels_of(sensor, lamps, cones) | (shows_mirrors & bool(ways.mirrors))
        scores, shares = np.where(is_alone, flights, scores), np.where(is_alone, 1.0, shares)
        scores = np.divide(scores, shares, out=np.zeros(len(scores)), where=shares > 0)
        bound = unseen_scores(scores) * shares * part.gains[number] / births
        if bound.any():
            names = surface_names(scene, sorted({*ways.mirrors, *ways.glossy}))
            origins = ["directly"] * (not ways.view.is_hidden) + [f"via {join_names(names)}"] * bool(names)
            what = f"light from {lamp.name!r} {' or '.join(origins)} not sampled in single pixels"
            yield doubtful("bins", what, tally.in_bins(bound))


def _shares_of_flights(sums: CellSums, sensor: Instrument, number: int) -> np.ndarray:
    """Return the largest weight of a flight to a lamp in each cell, if histories from it share its light."""
    scene, density = sums.adjoint.scene, sums.adjoint.caustics.densities.get(number, 0.0)
    walls = [piece for piece, _ in diffuse_pieces(scene)]
    rays = proven(scene, ("nearest rays", sensor.name), lambda: nearest_rays(sensor, walls))
    with np.errstate(invalid="ignore"):  # a wall at the camera's own place has no bound
        most = sums.view.births * rays
        return np.where(rays == 0, 0.0, np.where(np.isfinite(most), most / (most + density), 1.0))


@dataclass(frozen=True)
class Ways:
    """Ways between a lamp and a sensor that flights find.

    view: the straight one;  rays: to the lamp, None if none are sent;  is_linked: whether these connect
    mirrors, too;  mirrors, glossy: numbers of surfaces that flights alone connect.
    """

    view: DirectView
    rays: Expectation | None
    is_linked: bool
    mirrors: list[int]
    glossy: list[int]


def _ways_to(sums: CellSums, sensor: object, number: int) -> Ways:
    """Return the ways to a lamp with a shape that flights can meet."""
    scene, lamp = sums.adjoint.scene, sums.adjoint.sources[number]
    shape, side = scene.shape_of(lamp.source), lamp.source.side if lamp.source.emission.has_side else None
    rays = next((each for each in sums.plan.expectations if each.detector.name == lamp.detector.name), None)
    view = DirectView(scene, sensor, sums.parts, number, shape, side)
    is_linked = rays is not None and sums.plan.links is not None and not view.is_mirrored
    mirrors = [] if is_linked else specular_surfaces_of(scene, shape, side)
    glossy = [] if rays is None else glossy_surfaces_of(scene, shape, side)
    return Ways(view, rays, is_linked, mirrors, glossy)


@dataclass(frozen=True)
class LampScores:
    """Numbers of flights and rays that reached a source, and of rays near the largest score (LARGE_SHARE).

    brought: of flights of the same sum as the scores of histories from the lamp.
    """

    flights: float
    rays: int = 0
    strong_rays: int = 0
    brought: float = 0.0


def _lamp_scores(sums: CellSums, lamp: int, chosen: list[np.ndarray | None]) -> LampScores:
    """Number of flights and rays of the chosen cells (None: all) that reached a source.

    Rays only if it has any.
    """

    def by_batch(kind: str, block: int) -> np.ndarray:
        rows = [sums.rows_of(part, kind, block) for part in sums.parts]
        pairs = zip(rows, chosen, strict=True)
        cells = (each if which is None else each[:, which] for each, which in pairs)
        return sum(batch_totals(each) for each in cells)

    # The number of full scores that add up to those of flights, which media, surfaces and MIS have weakened.
    # Of guided histories these are about those that no guide has sent: each was one with the probability of
    # its weight.
    weights, block, brought = by_batch("weights", 1 + lamp), sums.block_of(lamp), 0.0
    flights = float(weights.sum() if sums.plan.is_guided else independent_scores(weights))
    if sums.view is not None:
        (part,) = sums.parts
        mean = np.mean([sums.brought_in(batch, part, lamp).mean() for batch in sums.batches])
        brought = float(mean) * sums.run.histories * part.share / part.gains[lamp]
    if lamp not in sums.adjoint.rays:
        return LampScores(flights, brought=brought)
    rays, strong = (round(float(by_batch(kind, block).sum())) for kind in ("counts", "slants"))
    return LampScores(flights, rays, strong, brought)


def _relative_cell_weights(sums: CellSums, extents: list[np.ndarray]) -> list[np.ndarray]:
    """For each part's cells, the effect of a score on the mean over all, relative to equal cells."""
    shares, whole = sum(part.share for part in sums.parts), sum(float(each.sum()) for each in extents)
    return [
        each / whole * part.cells * shares / part.share
        for part, each in zip(sums.parts, extents, strict=True)
    ]


def _classes_of_source(
    plan: Plan, sums: CellSums, sensor: object, number: int, met: LampScores, error: float, heaviest: float
) -> Iterator[PathClass | Finding]:
    """The path classes of a source, `largest` and `straight` in units of a sum of 1 over one history.

    error: of the mean radiance;  heaviest: weight of a cell, relative to equal cells.
    """
    scene, lamp = plan.adjoint.scene, plan.adjoint.sources[number]
    gain = max(part.gains[number] for part in sums.parts)
    if lamp.detector is None:
        yield from _direct_rays(sums, number, heaviest * gain)
    else:
        yield from _flights_to_source(scene, sums, sensor, number, met, error / gain, heaviest, gain)
    # Rays to the lamp: from collisions and from walls.
    rays = plan.adjoint.rays.get(number)
    if rays is None:
        return
    if rays.from_collisions:  # collisions may be so near that their rays have no other limit
        what = f"light from {lamp.name!r} via walls or scattering"
        yield PathClass(what, met.rays, heaviest / rays.scale, gain=gain)
    if rays.from_walls:
        is_near = met.rays and lamp.source.emission.law != "beam"
        what = f"light from {lamp.name!r} via {'walls near it' if is_near else 'walls'}"
        yield PathClass(what, met.strong_rays, heaviest * rays.strongest, gain=gain, name="strong rays")


def _direct_rays(sums: CellSums, number: int, gain: float) -> Iterator[PathClass]:
    """The light of a Point, direct or by mirrors, on a detector that it almost touches.

    Where births are as near to its foot as the Point itself, cosine/r^2 is above a third of its maximum.
    """
    lamp, places = sums.adjoint.sources[number], sums.adjoint.rays[number].places
    for part, place in product((part for part in sums.parts if isinstance(part.sensor, Detector)), places):
        if (strongest := strongest_ray(part.shape, place, places[0])) > 0:
            near = math.pi * least_path(part.shape, place, places[0]) ** 2 / part.shape.area
            births = int(sums.run.histories * part.share * min(near, 1.0))
            way = "direct light" if place == places[0] else "light by mirrors"
            what = f"{way} from {lamp.name!r} very near it"
            yield PathClass(what, births, strongest, gain=gain, name="strong rays")


def _are_births_connected(sums: CellSums, sensor: object, rays: Expectation) -> bool:
    """Return whether all births at a detector send rays to a source, and to its images in mirrors."""
    pairs = zip(sums.adjoint.parts, rays.births, strict=True)
    return all(births for part, births in pairs if part.sensor is sensor)


def _flights_to_source(
    scene: Scene,
    sums: CellSums,
    sensor: object,
    number: int,
    met: LampScores,
    error: float,
    heaviest: float,
    gain: float,
) -> Iterator[PathClass | Finding]:
    """The path classes of flights: direct light of the lamp, and light via specular and glossy surfaces."""
    lamp, is_guided = sums.adjoint.sources[number], sums.plan.is_guided
    heaviest *= 1 / LEAST if is_guided else 1.0
    ways = _ways_to(sums, sensor, number)
    rays, view, mirrors = ways.rays, ways.view, ways.mirrors
    if rays is not None and (
        _are_births_connected(sums, sensor, rays) or (ways.is_linked and view.is_hidden)
    ):
        what, share = (
            f"light from {lamp.name!r} very near it",
            rays.largest_flight_share[side_of(lamp.detector)],
        )
        yield PathClass(what, met.flights, heaviest * share, gain=gain, is_guided=is_guided)
        return
    is_seen, straight = not view.is_hidden, 0.0
    if is_seen and met.flights < MIN_SCORES_FOR_ERROR:
        straight, is_shown = view.bound(error)
        if not is_shown and not met.flights:
            what = f"direct light from {lamp.name!r}, which no sampled line of sight shows"
            yield doubtful("path class", what, straight * gain)
            is_seen, straight = False, 0.0
    surfaces = sorted({*mirrors, *ways.glossy})
    if surfaces or is_seen:
        origins = [f"from {lamp.name!r}"] * is_seen
        origins += [f"via {join_names(surface_names(scene, surfaces))}"] * bool(surfaces)
        what, cure = f"light {' or '.join(origins)}", USE_MORE
        if surfaces:
            cure = cure_of_chance(scene, sums.plan.method)
        flights, share = met.flights, 1.0
        if not (mirrors or is_seen):
            share = rays.largest_glossy_share[side_of(lamp.detector)]
        elif sums.view is not None and not (is_seen or sees_mirrors(scene, sensor)):
            # Histories from the lamp find all of it, too, and the largest score is shared with them.
            share = float(_shares_of_flights(sums, sensor, number).max())
            flights = (flights + met.brought) / share if share > 0 else 0.0
        yield PathClass(
            what,
            flights,
            heaviest * share,
            cure,
            surfaces=tuple(surfaces),
            straight=straight,
            gain=gain,
            is_guided=is_guided,
        )
