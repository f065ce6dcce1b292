"""Diagnostic "unvisited surface": whether any history reached a small wall close to a detector.

A detector with next-event estimation knows the light from afar after a few histories.  The light of a small
wall close to it comes from the few histories that reach that wall, each with a score larger by the inverse
square of the distance.  Before the first of them the mean is too low, and nothing in the scores shows it.
The energy balance does: it has the absorbed weight of each surface, and so the number of histories that
reached it; geometry gives the score of one of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from transport.compile import method_backward
from transport.compile.layout import GRAZING_CUT
from transport.compile.method_expected import uses_next_event
from transport.compile.next_event import max_phase_density, min_collision_distance
from transport.compile.volumes import weights_vary
from transport.geometry.distances import distance_to_shape, is_behind
from transport.geometry.flat import FlatShape
from transport.results.tally import Tally
from transport.scene.materials import Diffuse, display_name, elementary_materials
from transport.statistics.batches import MIN_SCORES_FOR_ERROR, student_quantile
from transport.statistics.chunked import batch_totals
from transport.statistics.findings import Finding, doubtful, unseen_scores

if TYPE_CHECKING:
    from transport.scene.materials import Surface
    from transport.statistics.estimates import Estimate


def detector_unvisited_findings(tally: Tally, total: Estimate) -> Iterator[Finding]:
    """Findings for a detector with next-event estimation; total: mean weight of arrivals per history."""
    plan, shape = tally.plan, tally.shape
    if _has_rays(tally) and total.error > 0:
        light = total.value * plan.unit / shape.area
        for finding in unvisited_surface_findings(tally, shape.extent, light):
            yield replace(finding, bound=finding.bound * shape.area / plan.unit)


def _has_rays(tally: Tally) -> bool:
    """Return whether next-event estimation finds light for a detector in a forward run."""
    plan = tally.plan
    return plan.sends_shadow_rays and plan.adjoint is None and uses_next_event(plan.scene, tally.detector)


def unvisited_surface_findings(tally: Tally, size: float, light: float) -> Iterator[Finding]:
    """The wall that may add most, if any; the bound is an irradiance or fluence rate [W m^-2].

    size: extent of the detector [m], the least distance of a wall;  light: its irradiance, or a quarter of
    its fluence rate [W m^-2].
    """
    plan, found = tally.plan, []
    for number, surface in enumerate(plan.scene.surfaces):
        share = 0.0 if _cannot_light(tally, surface) else _max_diffuse_share(surface)
        unseen = unseen_scores(_estimated_visits(tally, number, share, light)) if share > 0 else 0.0
        if unseen > 0:
            distance = max(distance_to_shape(surface.shape, tally.shape.middle), size)
            if distance > 0:
                added = plan.unit / tally.particles * share / (math.pi * distance**2)
                found.append((unseen * added, distance, display_name(surface, number)))
    most, distance, wall = max(found, default=(0.0, 0.0, ""))
    if most > 0:
        what = f"light of {wall}, {distance:.3g} m away, not sampled: hardly any history has reached it"
        cure = method_backward.more_particles_or_backward(plan.scene)
        yield doubtful("unvisited surface", what, most, cure)


def _cannot_light(tally: Tally, surface: Surface) -> bool:
    """Return whether a surface lies behind the active side of a flat detector."""
    shape = tally.shape
    return isinstance(shape, FlatShape) and is_behind(surface.shape, shape, tally.detector.side)


def _max_diffuse_share(surface: Surface) -> float:
    """Largest share of the incident weight that leaves a surface diffusely."""
    parts = [part for part in elementary_materials(surface.material) if isinstance(part, Diffuse)]
    return max((part.albedo + part.transmission for part in parts), default=0.0)


def _estimated_visits(tally: Tally, number: int, share: float, light: float) -> float:
    """Approximate number of histories of full weight that reached a surface, from its absorbed weight.

    A surface that absorbs nothing is assumed to receive the irradiance of the detector.
    """
    plan, shape = tally.plan, tally.plan.scene.surfaces[number].shape
    if share >= 1:
        return math.inf if shape.is_infinite else shape.area * light * tally.particles / plan.unit
    rows = [row for row, owner in enumerate(plan.surface_numbers) if owner == number]
    return sum(float(batch.absorbed[rows].sum()) for batch in tally.batches) / (1 - share)


# ---- Diagnostic "grazing": whether a fluence rate depends on grazing light unlike constant radiance.
#
# Below the grazing cut a crossing scores its mean under constant radiance, 2/cut, instead of 1/|mu|.  Diffuse
# light agrees with that, and brings a thousandth of its fluence there; a beam at that angle does not.  Under
# constant radiance as many crossings are nearer to grazing than cut/sqrt(2) as are farther, and batches count
# the difference (engine/tally.py).

MAX_CHANCE_AGREEMENT = 1e-6  # probability that so many batches agree by chance under constant radiance


def grazing_findings(tally: Tally) -> Iterator[Finding]:
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
        yield doubtful("grazing", what, cure=cure)


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
    if _has_rays(tally) and total.error > 0:
        cure = method_backward.more_particles_or_backward(tally.plan.scene)
        area = tally.shape.area
        yield from _forward_peaks(tally, lambda density: min(1.0, density * area), 1 / tally.particles, cure)


def point_forward_peaks(tally: Tally) -> Iterator[Finding]:
    """Findings for a point, with bounds as fluence rates [W m^-2]."""
    cure = "use more particles, or a small VolumeDetector"
    yield from _forward_peaks(tally, float, tally.plan.unit / tally.particles, cure)


def _forward_peaks(
    tally: Tally, score: Callable[[float], float], each: float, cure: str
) -> Iterator[Finding]:
    """The finding about the medium whose collision may score most.

    score: of a collision, from the density of directions per area;  each: weight of a history.  The bound
    assumes no such score, since the error would show one.
    """
    plan = tally.plan
    if not plan.scatters:
        return
    gap, found = min_collision_distance(plan, tally.shape), []  # least distance of collisions [m]
    for medium in plan.distinct_media:
        if float(np.max(getattr(medium, "scattering", 0.0))) > 0:
            path = max(1.0 / float(np.max(medium.extinction)), gap)
            found.append((score(max_phase_density(medium.phase) / path**2), medium))
    largest, medium = max(found, key=lambda one: one[0], default=(0.0, None))
    if largest > 0:
        angle = math.sqrt(1 / (math.pi * max_phase_density(medium.phase)))
        what = (
            f"light scattered by the {type(medium).__name__} within {angle:.2g} rad of the forward direction"
            " hardly sampled"
        )
        yield doubtful("forward peak", what, unseen_scores(0) * largest * each, cure)
