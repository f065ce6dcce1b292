"""Diagnostic "unvisited surface": whether any history reached a small wall close to a detector.

A detector with next-event estimation knows the light from afar after a few histories.  The light of a small
wall close to it comes from the few histories that reach that wall, each with a score larger by the inverse
square of the distance.  Before the first of them the mean is too low, and nothing in the scores shows it.
The energy balance does: it has the absorbed weight of each surface, and so the number of histories that
reached it; geometry gives the score of one of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from transport.compile import method_backward
from transport.compile.layout import GRAZING_CUT
from transport.compile.method_expected import uses_next_event
from transport.compile.next_event import min_collision_distance
from transport.compile.volumes import weights_vary
from transport.geometry.relations import is_behind
from transport.geometry.shape import Point
from transport.results.tally import Tally
from transport.scene.materials import display_name
from transport.statistics.batches import MIN_SCORES_FOR_ERROR, student_quantile
from transport.statistics.chunked import batch_totals
from transport.statistics.findings import DOUBTFUL, Finding, unseen_scores

if TYPE_CHECKING:
    from transport.compile.plan import Plan
    from transport.results.batches import Batch
    from transport.scene.detectors import Detector
    from transport.scene.materials import Surface
    from transport.scene.media import Medium
    from transport.statistics.estimates import Estimate
    from transport.vectors import Vector


def detector_unvisited_findings(tally: Tally, total: Estimate) -> Iterator[Finding]:
    """Findings for a detector with next-event estimation; total: mean weight of arrivals per history."""
    plan, detector, shape = tally.plan, tally.detector, tally.shape
    if not (
        plan.sends_shadow_rays
        and plan.adjoint is None
        and uses_next_event(plan.scene, detector)
        and total.error > 0
    ):
        return
    light = total.value * plan.unit / shape.area
    for finding in unvisited_surface_findings(
        plan, tally.batches, f"detector {detector.name!r}", shape.middle, shape.extent, light, detector
    ):
        yield replace(finding, bound=finding.bound * shape.area / plan.unit)


def unvisited_surface_findings(
    plan: Plan,
    batches: list[Batch],
    title: str,
    place: Vector,
    size: float,
    light: float,
    detector: Detector | None = None,
) -> Iterator[Finding]:
    """The wall that may add most, if any; the bound is an irradiance or fluence rate [W m^-2].

    place: centre of the detector [m];  size: its extent [m], the least distance of a wall;  light: its
    irradiance, or a quarter of its fluence rate [W m^-2].
    """
    histories = sum(batch.histories for batch in batches)
    found = []
    for number, surface in enumerate(plan.scene.surfaces):
        share = 0.0 if _cannot_light(plan, surface, detector) else surface.material.max_diffuse_share
        unseen = unseen_scores(_estimated_visits(plan, batches, number, share, light)) if share > 0 else 0.0
        if unseen > 0:
            distance = max(surface.shape.distance(place), size)
            if distance > 0:
                added = plan.unit / histories * share / (math.pi * distance**2)
                found.append((unseen * added, distance, display_name(surface, number)))
    most, distance, wall = max(found, default=(0.0, 0.0, ""))
    if most > 0:
        what = f"light of {wall}, {distance:.3g} m away, not sampled: hardly any history has reached it"
        yield Finding(
            DOUBTFUL,
            title,
            "",
            what,
            most,
            method_backward.more_particles_or_backward(plan.scene),
            name="unvisited surface",
        )


def _cannot_light(plan: Plan, surface: Surface, detector: Detector | None) -> bool:
    """Return whether a surface lies behind the active side of a flat detector."""
    shape = None if detector is None else plan.scene.shape_of(detector)
    return is_behind(surface.shape, shape, detector.side)


def _estimated_visits(plan: Plan, batches: list[Batch], number: int, share: float, light: float) -> float:
    """Approximate number of histories of full weight that reached a surface, from its absorbed weight.

    A surface that absorbs nothing is assumed to receive the irradiance of the detector.
    """
    shape, histories = plan.scene.surfaces[number].shape, sum(batch.histories for batch in batches)
    if share >= 1:
        return math.inf if shape.is_infinite else shape.area * light * histories / plan.unit
    rows = [row for row, owner in enumerate(plan.surface_numbers) if owner == number]
    return sum(float(batch.absorbed[rows].sum()) for batch in batches) / (1 - share)


# ---- Diagnostic "grazing": whether a fluence rate depends on grazing light unlike constant radiance.
#
# Below the grazing cut a crossing scores its mean under constant radiance, 2/cut, instead of 1/|mu|.  Diffuse
# light agrees with that, and brings a thousandth of its fluence there; a beam at that angle does not.  Under
# constant radiance as many crossings are nearer to grazing than cut/sqrt(2) as are farther, and batches count
# the difference (engine/tally.py).

MAX_CHANCE_AGREEMENT = 1e-6  # probability that so many batches agree by chance under constant radiance


def grazing_findings(tally: Tally, title: str) -> Iterator[Finding]:
    """The finding about a fluence rate that depends on such light.

    No bound is known for how much it is too low.
    """
    share = grazing_share(tally)
    if share > 0:
        what = (
            f"{share:.2g} or more of it is crossings of |mu| < {GRAZING_CUT:g}, each scored as"
            f" {2 / GRAZING_CUT:g} instead of 1/|mu|, which holds only for constant radiance"
        )
        cure = "use a VolumeDetector, or turn the detector towards the light"
        yield Finding(DOUBTFUL, title, "", what, cure=cure, name="grazing")


def grazing_share(tally: Tally) -> float:
    """Approximate least share of the fluence rate from asymmetric crossings beyond the cut; 0 if uncertain.

    A certain asymmetry matters: an excess above five square roots of a number of crossings is that many of
    the standard errors that they make.
    """
    weights, slants = (
        sum(batch_totals(tally.sums(f"{kind} {side}")) for side in ("in", "out"))
        for kind in ("weight", "slant")
    )
    counts = sum(tally.number_of(f"weight {side}") for side in ("in", "out"))
    if not slants.any():
        return 0.0
    inverse = slants.sum() / weights.sum()  # mean of 1/|mu|
    if weights_vary(tally.plan):  # counts do not measure weights
        return 1.0 if inverse > 1 / GRAZING_CUT else 0.0
    number = [detector.name for detector in tally.scene.meters].index(tally.name)
    excess = np.array([batch.grazing[number] for batch in tally.batches], float)
    if abs(excess.sum()) < MIN_SCORES_FOR_ERROR or not _is_significant(excess):
        return 0.0
    return min(1.0, 2 / GRAZING_CUT / inverse * abs(excess.sum()) / counts)


def _is_significant(excess: np.ndarray) -> bool:
    """Return whether batches agree that the mean is not zero.

    A history may graze many times, but only in its batch.
    """
    if len(excess) < 2:  # an interrupted run: nothing to compare
        return False
    limit = (
        student_quantile(1 - MAX_CHANCE_AGREEMENT / 2, len(excess) - 1)
        * excess.std(ddof=1)
        / math.sqrt(len(excess))
    )
    return abs(excess.mean()) > limit


# ---- Diagnostic "forward peak": whether next-event estimation has sampled sharply forward scattering.
#
# Each collision scores at a detector by the density of its phase function, which for g near 1 is next to
# nothing outside a narrow cone.  The scattered light comes from the few collisions whose cone contains the
# detector, each with a score as large as the cone is narrow.  Until some have come the mean is too low, and
# nothing in the scores shows it.  The score of one is known: the largest density of the phase function over
# the square of a free path.


def detector_forward_peaks(tally: Tally, total: Estimate) -> Iterator[Finding]:
    """Findings for a detector with next-event estimation; total: mean weight of arrivals per history."""
    plan, detector, shape = tally.plan, tally.detector, tally.shape
    has_rays = plan.sends_shadow_rays and plan.adjoint is None and uses_next_event(plan.scene, detector)
    if not (has_rays and plan.scatters and total.error > 0):
        return
    gap, histories = min_collision_distance(plan, shape), int(tally.run.sizes.sum())
    worst = _largest_collision_score(plan, gap, lambda density: min(1.0, density * shape.area))
    yield from _forward_peak_finding(
        worst,
        1 / histories,
        f"detector {detector.name!r}",
        method_backward.more_particles_or_backward(plan.scene),
    )


def point_forward_peaks(plan: Plan, name: str, place: Vector, histories: int) -> Iterator[Finding]:
    """Findings for a point, with bounds as fluence rates [W m^-2]."""
    if plan.scatters:
        worst = _largest_collision_score(plan, min_collision_distance(plan, Point(position=place)), float)
        cure = "use more particles, or a small VolumeDetector"
        yield from _forward_peak_finding(worst, plan.unit / histories, f"point detector {name!r}", cure)


def _largest_collision_score(plan: Plan, gap: float, score) -> tuple[float, Medium | None]:
    """The largest score of one collision, and the medium of it; gap: least distance of collisions [m]."""
    found = []
    for medium in plan.distinct_media:
        scattering = float(np.max(getattr(medium, "scattering", 0.0)))
        if scattering > 0:
            path = max(1.0 / float(np.max(medium.extinction)), gap)
            found.append((score(medium.phase.max_density / path**2), medium))
    return max(found, key=lambda one: one[0], default=(0.0, None))


def _forward_peak_finding(
    worst: tuple[float, Medium | None], each: float, title: str, cure: str
) -> Iterator[Finding]:
    """The finding; each: weight of a history.

    The bound assumes no such score, since the error would show one.
    """
    score, medium = worst
    if score > 0:
        angle = math.sqrt(1 / (math.pi * medium.phase.max_density))
        what = (
            f"light scattered by the {type(medium).__name__} within {angle:.2g} rad of the forward direction"
            " hardly sampled"
        )
        yield Finding(DOUBTFUL, title, "", what, unseen_scores(0) * score * each, cure, name="forward peak")
