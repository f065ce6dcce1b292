"""Diagnostics of light from near a detector, which few histories carry, and of light at grazing angles."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from transport.compile.detectors import weights_vary
from transport.compile.gloss import glossy_parts, single_peak
from transport.compile.layout import GRAZING_CUT
from transport.compile.methods import more_particles_or_backward, uses_next_event
from transport.compile.next_event import min_collision_distance
from transport.geometry.relations import is_behind
from transport.geometry.shape import Shape
from transport.results.diagnostics.proofs import source_title
from transport.results.tally import SIDES
from transport.scene.bodies import body_bits_at, nested_bodies, surrounding_medium
from transport.scene.parts import surface_name
from transport.statistics.batches import MIN_SCORES_FOR_ERROR, student_quantile
from transport.statistics.chunked import batch_totals
from transport.statistics.findings import Finding, doubtful, unseen_scores
from transport.vectors import Vector

if TYPE_CHECKING:
    from transport.compile.plan import Emitter, Plan
    from transport.results.tally import Tally
    from transport.scene.materials import Material, Surface
    from transport.scene.media import Grid, Medium
    from transport.statistics.estimates import Estimate


# ---- Diagnostic "near emitter": whether a run misses light of a wall, emitter or thick medium near a point.
#
# Half of the light that reaches a point at the small distance d from a diffuse wall leaves the wall within
# about d of the nearest spot (the foot).  If hardly any history leaves there, all of its light is missing,
# and so is its variance: neither scores nor errors show it.  Geometry shows it: a single history at the foot
# would add w cos / (pi d^2), which must not matter.  With n histories per area pi d^2 it is sqrt(2 / n)
# errors of the wall's light, whose scores s then have (sum of s^2)^2 / (sum of s^4) = 5 n / 4.  A scattering
# medium counts as such a wall, as rough as its mean free path is long.

# Of a wall's extent: from farther away the wall cannot matter unless the run has no light at all.
MAX_RELATIVE_DISTANCE = 0.25


@dataclass(frozen=True)
class NearEmitter:
    """A wall or an emitter near a point, and the scores of a run from about the foot."""

    title: str
    distance: float  # [m]
    added: float  # by one history of the largest weight that leaves nearest to the point [W m^-2]
    expected: float  # about how many full histories leave within d of the foot
    extent: float  # [m]
    is_surrounding: bool = False  # a medium around the point; then d is its mean free path
    # A lamp farther away than it is large: births count wherever they are on it.
    is_small: bool = False


def near_emitter_findings(tally: Tally, fluence: Estimate) -> Iterator[Finding]:
    """The wall that may add most to a point detector, if any; the bound is a fluence rate [W m^-2]."""
    if not fluence.value > 0:
        return
    found = [(unseen_scores(wall.expected) * wall.added, wall) for wall in _near_emitters(tally, fluence)]
    bound, wall = max(found, key=lambda one: one[0], default=(0.0, None))
    if not bound > 0:
        return
    expected = f"only about {wall.expected:.2g} histories are expected"
    if wall.is_surrounding:
        what = f"light scattered nearby in {wall.title} not sampled: {expected} within a mean free path"
        what, cure = f"{what}, {wall.distance:.3g} m", ""
    elif wall.is_small:
        what = f"light of {wall.title}, {wall.distance:.3g} m away, hardly sampled"
        what += f": {expected} to be born there"
        cure = "simulate it in a separate scene and add the results, "
    else:
        what = f"light of {wall.title}, {wall.distance:.3g} m away, not sampled"
        what += f": {expected} to leave so close to it"
        clear = min(
            wall.distance * math.sqrt(2 * MIN_SCORES_FOR_ERROR / max(wall.expected, 1e-99)),
            MAX_RELATIVE_DISTANCE * wall.extent,
        )
        cure = f"move the point to at least {clear:.2g} m from it, "
    cure += "use more particles, or use a small VolumeDetector"
    yield doubtful("near emitter", what, bound, cure)


def _near_emitters(tally: Tally, fluence: Estimate) -> Iterator[NearEmitter]:
    """Diffuse walls, media, emitters with fewer than MIN_SCORES_FOR_ERROR expected histories at the foot."""
    plan, point = tally.plan, tally.detector.position
    born = plan.unit / (math.pi * tally.particles)  # added by one history straight above a spot 1 m away
    one = born / _splitting_factor(plan, point)
    reach = math.sqrt(4 * MIN_SCORES_FOR_ERROR * one / fluence.value)  # from farther away enough are expected
    # Diffuse walls.
    for title, piece, material in _diffuse_walls(plan, point, reach):
        share = _diffuse_share(material, _side(piece, point))
        distance = _distance(piece, point, reach)
        if distance is not None and not _is_negligible(plan, share, fluence):
            arrivals = distance**2 * fluence.value / 4 / one  # as in isotropic light
            added = one * share * _inverse_square_cosine(piece, point, distance)
            yield NearEmitter(title, distance, added, arrivals, piece.extent)
    # Scattering media.
    for title, shape, medium in _scattering_media(plan, point):
        path, share = _free_path(medium)
        distance = path if shape is None else _distance(shape, point, reach, path)
        if distance is not None and not _is_negligible(plan, share, fluence):
            arrivals = distance**2 * fluence.value / 4 / one
            extent = math.inf if shape is None else shape.extent
            yield NearEmitter(title, distance, one * share / distance**2, arrivals, extent, shape is None)
    # Emitters, small ones as a whole and large ones by the foot.
    for title, emitter in _diffuse_emitters(plan):
        shape, has_side = emitter.shape, emitter.source.emission.has_side
        if has_side and _side(shape, point) == (1.0 if emitter.source.is_back else -1.0):  # it faces away
            continue
        distance = 0.0 if shape.is_infinite else shape.distance(point)
        if distance > MAX_RELATIVE_DISTANCE * shape.extent:  # births on it score alike
            births = tally.particles * emitter.bound / math.fsum(each.bound for each in plan.emitters)
            added = born / distance**2 if has_side else born / 4 / distance**2
            yield NearEmitter(title, distance, added, births, shape.extent, is_small=True)
        elif emitter.source.emission.law == "lambertian":
            exitance = emitter.amount / shape.area
            distance = _distance(shape, point, math.sqrt(MIN_SCORES_FOR_ERROR * born / exitance))
            if distance is not None and 2 * exitance > fluence.error / 2:
                added, births = born * _inverse_square_cosine(shape, point, distance), distance**2 * exitance
                yield NearEmitter(title, distance, added, births / born, shape.extent)


def _splitting_factor(plan: Plan, point: Vector) -> float:
    """Factor by which histories at the point are split; their weight is smaller by it."""
    return math.exp(plan.tracking.splitting.rise_at(point)) if plan.splits else 1.0


def _diffuse_walls(plan: Plan, point: Vector, reach: float) -> Iterator[tuple[str, Shape, Material]]:
    """Walls within reach that reflect or transmit diffusely, piece by piece."""
    for number, surface in enumerate(plan.scene.surfaces):
        if not _is_out_of_reach(surface.shape, point, reach) and surface.material.max_diffuse_share > 0:
            title = surface_name(plan.scene, number)
            yield from ((title, piece, surface.material) for piece in surface.shape.pieces())


def _scattering_media(plan: Plan, point: Vector) -> Iterator[tuple[str, Shape | None, Medium | Grid]]:
    """The scattering media: boundaries of media elsewhere, piece by piece.

    None for the medium around the point.
    """
    if not plan.scatters:
        return
    bodies, holders = nested_bodies(plan.scene)
    bits = int(body_bits_at(plan.scene, np.array([point]))[0])
    about = (bits & -bits).bit_length() - 1
    if about < 0 and np.any(surrounding_medium(plan.scene).scattering):
        yield "a scattering medium", None, surrounding_medium(plan.scene)
    for number, body in enumerate(bodies):
        faces = [(plan.scene.surfaces[k].shape, surface_name(plan.scene, k)) for k in body.surfaces]
        extent = max(shape.extent for shape, _ in faces)
        if number == about and _free_path(body.medium)[0] < MAX_RELATIVE_DISTANCE * extent:
            yield f"the scattering medium inside {faces[0][1]}", None, body.medium
        beyond = min(holders[number], default=-1)  # each body comes before those that contain it
        for side, where in ((number, "inside"), (beyond, "beyond")):
            medium = bodies[side].medium if side >= 0 else surrounding_medium(plan.scene)
            if side != about and np.any(medium.scattering):
                for shape, title in faces:
                    yield from (
                        (f"the scattering medium {where} {title}", piece, medium) for piece in shape.pieces()
                    )


def _free_path(medium: Medium | Grid) -> tuple[float, float]:
    """Mean free path [m] in a medium and its albedo; a grid of voxels counts as its mean."""
    scattering = float(np.mean(medium.scattering))
    extinction = scattering + float(np.mean(medium.absorption))
    return (1 / extinction, scattering / extinction) if scattering else (math.inf, 0.0)


def _diffuse_emitters(plan: Plan) -> Iterator[tuple[str, Emitter]]:
    for emitter in plan.emitters:
        if emitter.source.emission.ray_densities:
            yield source_title(plan.scene, emitter.source), emitter


def _distance(shape: Shape, point: Vector, reach: float, least: float = 0.0) -> float | None:
    """The distance [m], at least `least`; None unless it is within reach and small against the shape."""
    reach = min(reach, MAX_RELATIVE_DISTANCE * shape.extent)
    if _is_out_of_reach(shape, point, reach):
        return None
    distance = max(shape.distance(point), least)
    return distance if 0 < distance < reach else None


def _is_out_of_reach(shape: Shape, point: Vector, reach: float) -> bool:
    """Return whether a shape is certainly farther away than `reach` [m]."""
    return not shape.is_infinite and math.dist(point, shape.middle) - shape.extent > reach


def _inverse_square_cosine(shape: Shape, point: Vector, distance: float) -> float:
    """cos / d^2 [m^-2] from the nearest spot; it is small beside a flat shape."""
    cosine = abs(shape.height_of(point)) / distance if shape.is_flat else 1.0
    return min(cosine, 1.0) / distance**2


def _side(shape: Shape, point: Vector) -> float:
    """+1 in front of a shape, -1 behind or inside it, 0 if neither is known."""
    if shape.is_flat:
        return math.copysign(1.0, shape.height_of(point))
    return (-1.0 if shape.contains(np.array([point]))[0] else 1.0) if shape.is_closed else 0.0


def _diffuse_share(material: Material, side: float) -> float:
    """Largest share of a history's weight that leaves a wall diffusely on a side; side 0.0: on any."""
    here, beyond = (material, material) if side == 0 else material.sides[:: 1 if side > 0 else -1]
    sent = [part.shares for part in here.elements if part.shares.diffuse]
    sent += [part.shares for part in beyond.elements if part.shares.diffuse_through]
    return max((shares.diffuse + shares.diffuse_through for shares in sent), default=0.0)


def _is_negligible(plan: Plan, share: float, fluence: Estimate) -> bool:
    """Return whether a wall sends next to no light.

    At most its irradiance, which the point sees, unless there are beams.
    """
    has_beams = any(source.emission.law == "beam" for source in plan.scene.sources)
    return not has_beams and 2 * share * fluence.value < fluence.error / 2


# ---- Diagnostic "unvisited surface": whether any history reached a small wall close to a detector.
#
# A detector with next-event estimation knows the light from afar after a few histories.  The light of a small
# wall close to it comes from the few histories that reach that wall, each with a score larger by the inverse
# square of the distance.  Before the first of them the mean is too low, and nothing in the scores shows it.
# The energy balance does: it has the absorbed weight of each surface, and so the number of histories that
# reached it; geometry gives the score of one of them.


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
        material = surface.material
        glossy = {part.roughness: part.shares.glossy for part in glossy_parts(material)}
        share = max(material.max_diffuse_share, *glossy.values(), 0.0)
        share = 0.0 if _cannot_light(tally, surface) else share
        unseen = unseen_scores(_estimated_visits(tally, number, share, light)) if share > 0 else 0.0
        if unseen > 0:
            distance = max(surface.shape.distance(tally.shape.middle), size)
            if distance > 0:
                density = material.max_diffuse_share / math.pi
                for roughness, sent in glossy.items():
                    density = max(density, sent * float(single_peak(roughness, 1.0)))
                added = plan.unit / tally.particles * density / distance**2
                found.append((unseen * added, distance, surface_name(plan.scene, number)))
    most, distance, wall = max(found, default=(0.0, 0.0, ""))
    if most > 0:
        what = f"light of {wall}, {distance:.3g} m away, not sampled: hardly any history has reached it"
        cure = more_particles_or_backward(plan.scene)
        yield doubtful("unvisited surface", what, most, cure)


def _cannot_light(tally: Tally, surface: Surface) -> bool:
    """Return whether a surface lies behind the active side of a flat detector."""
    shape = tally.shape
    return shape.is_flat and is_behind(surface.shape, shape, tally.detector.side)


def _estimated_visits(tally: Tally, number: int, share: float, light: float) -> float:
    """Approximate number of histories of full weight that reached a surface, from its absorbed weight.

    A surface that absorbs nothing is assumed to receive the irradiance of the detector.
    """
    plan, shape = tally.plan, tally.plan.scene.surfaces[number].shape
    if share >= 1:
        return math.inf if shape.is_infinite else shape.area * light * tally.particles / plan.unit
    rows = plan.rows_of_surfaces.get(number, [])
    return sum(float(batch.absorbed[rows].sum()) for batch in tally.batches) / (1 - share)


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
        cure = more_particles_or_backward(tally.plan.scene)
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
            found.append((score(medium.phase.max_density / path**2), medium))
    largest, medium = max(found, key=lambda one: one[0], default=(0.0, None))
    if largest > 0:
        angle = math.sqrt(1 / (math.pi * medium.phase.max_density))
        within = f"within {angle:.2g} rad of the forward direction"
        what = f"light scattered by the {type(medium).__name__} {within} hardly sampled"
        yield doubtful("forward peak", what, unseen_scores(0) * largest * each, cure)


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
    weights = sum(batch_totals(tally.sums(f"weight {side}")) for side in SIDES)
    slants = sum(batch_totals(tally.sums(f"slant {side}")) for side in SIDES)
    counts = sum(tally.number_of(f"weight {side}") for side in SIDES)
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
    quantile = student_quantile(1 - MAX_CHANCE_AGREEMENT / 2, len(excess) - 1)
    limit = quantile * excess.std(ddof=1) / math.sqrt(len(excess))
    return abs(excess.mean()) > limit
