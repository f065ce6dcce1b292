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
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from transport.compile.layout import SIZE_CELLS
from transport.compile.sizes import EDGES
from transport.detectors import Detector
from transport.emissions import Beam
from transport.estimators import backward
from transport.materials import Material, TwoSided, is_specular, lets_through
from transport.materials.surface import titled
from transport.points import PointDetector
from transport.results.empty_detector import are_parted
from transport.results.findings import DOUBTFUL, MIN_SCORES, Finding, unseen_scores
from transport.results.quality import MORE
from transport.shapes import Disk, FlatShape, Point, Rectangle, Shape, Sphere
from transport.shapes.crossings import crossings
from transport.shapes.distances import is_behind
from transport.sides import IS_BACK, OTHER_SIDE
from transport.validation import listed
from transport.vectors import dot

if TYPE_CHECKING:
    from transport.compile.adjoint import Part
    from transport.compile.plan import Plan
    from transport.results.batches import Batch
    from transport.scene import Scene
    from transport.sources import Source

PAIRS = 1 << 13  # lines between a sensor and a lamp
CLEAR = 1e-9  # of a line, at its ends: the surfaces on which it begins and ends do not block it
LARGE = 0.25  # of the largest score: scores above it tell whether such large ones come


@dataclass(frozen=True)
class PathClass:
    """Paths that are found by chance: what they are, how often they scored, and the most that one score adds to the sum."""

    what: str
    scores: int
    largest: float
    cure: str
    seen: str = ""  # by a guard about the detector

    def finding(self, title: str, histories: float) -> Finding | None:
        """What of it a run of so many histories may have missed; None where nothing that its error does not tell."""
        if self.scores >= MIN_SCORES or self.largest == 0:
            return None
        few = (
            f"only {self.scores} score{'s' * (self.scores > 1)} of {self.what}"
            if self.scores
            else f"{self.what} not sampled"
        )
        bound = unseen_scores(self.scores) * self.largest / histories
        times = MIN_SCORES / self.scores if self.scores else math.nan
        return Finding(
            DOUBTFUL, title, "", few, bound, self.cure, name="path class", times=times, seen=self.seen
        )


def chances_of_detector(
    plan: Plan, batches: list[Batch], title: str, name: str, side: int, scores: int, mean: float
) -> Iterator[Finding]:
    """What a detector that histories come to may have missed, with bounds as mean weights of a history.

    side: 0 for arrivals;  scores: how many there are in all;  mean: the mean weight of a history that came.
    """
    histories = sum(batch.histories for batch in batches)
    found = (
        each.finding(title, histories)
        for each in _classes_of_detector(plan, batches, name, side, scores, mean)
    )
    yield from filter(None, found)
    expectation = next((each for each in plan.expectations if each.detector.name == name), None)
    if expectation is not None and expectation.scattered is not None:
        yield _near_collisions(plan, batches, title, name, side, mean, expectation.scattered)


def _near_collisions(
    plan: Plan,
    batches: list[Batch],
    title: str,
    name: str,
    side: int,
    mean: float,
    share: Callable[[float], float],
) -> Finding:
    """Collisions near a detector in a medium, whose flights count up to all of their weight.

    Those nearer than a distance e bring at most about sigma_s e of the mean: that is how much of the light there is scattered on
    such a length.  From farther away a score has a limit.  The distance taken is that of the least bound.
    """
    scattering = max(float(np.max(getattr(medium, "scattering", 0.0))) for medium in plan.distinct_media)
    extent, histories = (
        plan.scene.shape_of(_detector(plan, name)).extent,
        sum(batch.histories for batch in batches),
    )
    bounds = []
    for distance in np.geomspace(1e-2, 1e4, 61) * extent:
        largest = share(distance)
        unseen = unseen_scores(large_scores(plan, batches, name, side, largest, 0))
        bounds.append(scattering * distance * mean + unseen * largest / histories)
    what = "light scattered very near not sampled"
    return Finding(
        DOUBTFUL,
        title,
        "",
        what,
        min(bounds),
        "use more particles, or estimator='backward'",
        name="path class",
    )


def _detector(plan: Plan, name: str) -> Detector:
    return next(detector for detector in plan.scene.meters if detector.name == name)


def _classes_of_detector(
    plan: Plan, batches: list[Batch], name: str, side: int, scores: int, mean: float
) -> Iterator[PathClass]:
    """Those of a detector; largest: in units of the largest weight at birth."""
    expectation = next((each for each in plan.expectations if each.detector.name == name), None)
    if expectation is None:
        is_aimed = all(emitter.target is not None for emitter in plan.emitters)
        heaviest = max(batch.heaviest for batch in batches) if is_aimed else 1.0
        if plan.lessens or plan.splits or plan.forces:
            yield PathClass("light", scores, heaviest, MORE)
            if not is_aimed:
                return
            born = sum(batch.born for batch in batches)
            heaviest *= (
                min(mean * sum(batch.histories for batch in batches) / born, 1.0) if born > 0 else 0.0
            )  # on its way
        number = large_scores(plan, batches, name, side, heaviest, scores)
        yield PathClass("the heaviest births of an aim" if is_aimed else "light", number, heaviest, MORE)
        return
    scene, detector = plan.scene, expectation.detector
    looks = detector.side if side == 0 else OTHER_SIDE[detector.side]
    shape = scene.shape_of(detector)
    if side == 1 and isinstance(detector.shape, str):  # what leaves a surface is counted as it comes
        yield PathClass("light", large_scores(plan, batches, name, side, 1.0, scores), 1.0, MORE)
        return
    unconnected = [*mirrors_of(scene, shape, looks), *beams_of(plan, shape, looks)]
    largest = 1.0 if unconnected else expectation.nearest[looks]
    number = large_scores(plan, batches, name, side, largest, scores)
    what = f"light by {listed(unconnected)}" if unconnected else "light from very near"
    seen, radius = _guarded(plan, batches, name) if unconnected and not number else ({}, 0.0)
    if seen:
        what = f"light by {listed(list(seen))}"
    flights = " and ".join(f"{passed} flights from {title}" for title, passed in seen.items())
    yield PathClass(
        what, number, largest, _cure(scene), f"{flights} passed within {radius:.2g} m" if seen else ""
    )
    strongest = expectation.strongest[looks]
    rays = large_scores(plan, batches, name, side, strongest * expectation.scale, scores, block=1)
    yield PathClass("light from near walls or sources", rays, strongest, "use more particles")


def chances_of_sensor(
    plan: Plan,
    title: str,
    sensor: object,
    parts: list[Part],
    met: dict[int, tuple[int, int]],
    histories: float,
) -> Iterator[Finding]:
    """What a detector that histories start from may have missed, with bounds as mean radiances over its cells [W m^-2 sr^-1].

    met: by lamp how often flights and rays came to it;  histories: those that started there.
    """
    for number, each in _classes_of_lamps(plan, sensor, parts, met):
        finding = each.finding(title, histories) if isinstance(each, PathClass) else each
        if finding is not None:
            yield replace(
                finding, object=title, bound=finding.bound * max(part.gains[number] for part in parts)
            )


def _classes_of_lamps(
    plan: Plan, sensor: object, parts: list[Part], met: dict[int, tuple[int, int]]
) -> Iterator[tuple[int, PathClass | Finding]]:
    """Those of each lamp by its number; largest: in units of what a sum of 1 over one history is."""
    scene = plan.turned.scene
    expected = {each.detector.name: each for each in plan.expectations}
    with_rays = {
        k: expected[lamp.seen_by.name]
        for k, lamp in enumerate(plan.turned.lamps)
        if lamp.seen_by.name in expected
    }
    scales = {
        k: 1 / each.scale
        for k, each in with_rays.items()
        if each.walls is not None or each.collisions is not None
    }
    for number, lamp in enumerate(plan.turned.lamps):
        if number not in met:
            continue
        shape, side = scene.shape_of(lamp.source), lamp.source.side if lamp.source.emission.has_side else None
        mirrors = list(mirrors_of(scene, shape, side))
        seen = not _is_hidden(scene, sensor, parts, shape, side)
        bound = None
        if seen and not met[number][0]:
            key = sensor.name, number  # once per plan: a run for an error looks often
            if key not in plan.proofs:
                plan.proofs[key] = _unseen_by_pairs(scene, sensor, parts, shape, side)
            bound = plan.proofs[key]
        if bound is not None:
            seen = False
            what = f"light straight from {lamp.name!r}, which no line between them shows"
            yield number, Finding(DOUBTFUL, "", "", what, bound, "use more particles", name="path class")
        if mirrors or seen:
            ways = [f"from {lamp.name!r}"] * seen + [f"by {listed(mirrors)}"] * bool(mirrors)
            yield number, PathClass(f"light {' or '.join(ways)}", met[number][0], 1.0, "use more particles")
        if number in scales:
            what = f"light from {lamp.name!r} by diffuse walls or scattering"
            yield number, PathClass(what, met[number][1], scales[number], "use more particles")


def _guarded(plan: Plan, batches: list[Batch], name: str) -> tuple[dict[str, int], float]:
    """How many flights a guard saw pass a detector, by the surface that they came from, and within what distance [m]."""
    guard = next((each for each in plan.guards if each.detector == name), None)
    if guard is None:
        return {}, 0.0
    first, seen = int(guard.row["first"]), {}
    for sheet, number in guard.surfaces.items():
        passed = int(sum(batch.sizes[first + sheet] for batch in batches))
        surface = plan.scene.surfaces[number]
        title = repr(surface.name) if surface.name else titled(surface, number)
        if passed:
            seen[title] = seen.get(title, 0) + passed
    return seen, guard.radius


def large_scores(
    plan: Plan, batches: list[Batch], name: str, side: int, largest: float, scores: int, block: int = 0
) -> int:
    """How many scores are at least a quarter of the largest that there can be; all of them where they are alike.

    block: 0 for those of flights, 1 for those of rays, in their own unit.
    """
    blocks = plan.size_blocks.get((name, side))
    if blocks is None:
        return scores
    first = blocks[block]
    counts = sum(batch.sizes[first : first + SIZE_CELLS] for batch in batches)
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
        if _faces_away(surface.shape, surface.material, shape) or are_parted(
            scene, (shape, side), (surface.shape, None), number
        ):
            continue
        found.append(repr(surface.name) if surface.name else titled(surface, number))
    return found


def _faces_away(mirror: Shape, material: Material, shape: Shape) -> bool:
    """Whether a flat surface of which only one side is specular has that side turned away from all of a shape."""
    if not (isinstance(mirror, FlatShape) and isinstance(material, TwoSided)):
        return False
    sides = {"front": material.front, "back": material.back}
    specular = [side for side, each in sides.items() if is_specular(each)]
    is_opaque = not any(lets_through(each) for each in sides.values())
    return is_opaque and len(specular) == 1 and is_behind(shape, mirror, specular[0])


def beams_of(plan: Plan, shape: Shape, side: str) -> Iterator[str]:
    """The sources whose births no ray connects and which may come straight to a side of a shape."""
    for emitter in plan.emitters:
        emission = emitter.source.emission
        if not isinstance(emission, Beam) or _misses(emitter.shape, emission.direction, shape):
            continue
        along = dot(emission.direction, shape.normal) if isinstance(shape, FlatShape) else 0.0
        if not isinstance(shape, FlatShape) or ((along > 0) == IS_BACK[side] and along != 0):
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


def _unseen_by_pairs(
    scene: Scene, sensor: object, parts: list[Part], lamp: Shape, side: str | None
) -> float | None:
    """A bound of the share of a sensor's view that a lamp fills, of which no line between the two shows any.

    As of scores that none has seen, of PAIRS lines between even points on both; None where a line shows it, or where no points can be
    drawn on either.
    """
    rng, share = np.random.default_rng(0), 0.0
    is_directed = isinstance(sensor, Detector)
    if not (is_directed or isinstance(sensor, PointDetector)) or side is None:
        return None
    for part in parts:
        ends = [points_on(shape, rng.random((PAIRS, 2))) for shape in (part.shape, lamp)]
        if any(end is None for end in ends):
            return None
        (start, facing), (end, emitting) = ends
        ways = end - start
        distances = np.linalg.norm(ways, axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            ways = ways / distances[:, None]
            there = np.maximum(-(ways * emitting).sum(axis=1) * (-1.0 if IS_BACK[side] else 1.0), 0.0)
            here = np.maximum(
                (ways * facing).sum(axis=1) * (-1.0 if is_directed and IS_BACK[sensor.side] else 1.0), 0.0
            )
            kernel = there * lamp.area / distances**2 * (here / math.pi if is_directed else 0.25 / math.pi)
        lit = kernel > 0
        if (lit & ~_are_blocked(scene, start, ways, distances)).any():
            return None
        share = max(share, unseen_scores(0) * float(kernel.max(initial=0.0)) / PAIRS)
    return share


def points_on(shape: Shape, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Points even over the area of a shape, from numbers (n, 2) within [0, 1), and its normals there, (n, 3); None of other shapes."""
    u, v = numbers.T
    if isinstance(shape, Point):
        return np.broadcast_to(shape.position, (len(u), 3)), np.zeros((len(u), 3))
    if isinstance(shape, Sphere) and shape.is_closed:
        z, turn = 2 * u - 1, 2 * math.pi * v
        rho = np.sqrt(1 - z * z)
        normals = np.stack([rho * np.cos(turn), rho * np.sin(turn), z], axis=1)
        return np.array(shape.center) + shape.radius * normals, normals
    if isinstance(shape, Disk):
        r, turn = (
            np.sqrt(shape.inner_radius**2 + u * (shape.radius**2 - shape.inner_radius**2)),
            2 * math.pi * v,
        )
        x, y = r * np.cos(turn), r * np.sin(turn)
    elif isinstance(shape, Rectangle) and shape.hole is None:
        x, y = (u - 0.5) * shape.width, (v - 0.5) * shape.height
    else:
        return None
    e_u, e_v, normal = (np.array(axis) for axis in shape.frame)
    return np.array(shape.center) + np.outer(x, e_u) + np.outer(y, e_v), np.broadcast_to(normal, (len(u), 3))


def _are_blocked(scene: Scene, start: np.ndarray, ways: np.ndarray, distances: np.ndarray) -> np.ndarray:
    """Whether an opaque surface stands between the ends of each line."""
    blocked = np.zeros(len(start), bool)
    for surface in scene.surfaces:
        if not lets_through(surface.material):
            met = crossings(surface.shape, start, ways).distances / distances[:, None]
            blocked |= ((met > CLEAR) & (met < 1 - CLEAR)).any(axis=1)
    return blocked


def _cure(scene: Scene) -> str:
    """What finds such light."""
    if backward.why_not(scene) is None:
        return "use estimator='backward'"
    return "use estimator='analog' with more particles or a larger detector"
