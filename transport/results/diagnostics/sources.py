"""Diagnostic "near emitter": whether a run misses light of a wall, emitter or thick medium near a point.

Half of the light that reaches a point at the small distance d from a diffuse wall leaves the wall within
about d of the nearest spot (the foot).  If hardly any history leaves there, all of its light is missing, and
so is its variance: neither scores nor errors show it.  Geometry shows it: a single history at the foot would
add w cos / (pi d^2), which must not matter.  With n histories per area pi d^2 it is sqrt(2 / n) errors of the
wall's light, whose scores s then have (sum of s^2)^2 / (sum of s^4) = 5 n / 4.  A scattering medium counts as
such a wall, as rough as its mean free path is long.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from transport.geometry.distances import distance_to_shape
from transport.geometry.flat import FlatShape
from transport.geometry.mesh import Mesh
from transport.geometry.shape import Shape
from transport.geometry.solid import Sphere
from transport.scene.bodies import body_bits_at, nested_bodies, surrounding_medium
from transport.scene.emissions import Beam, Isotropic, Lambertian
from transport.scene.materials import Diffuse, TwoSided, display_name, elementary_materials
from transport.scene.sheets import pieces_of
from transport.statistics.batches import MIN_SCORES_FOR_ERROR
from transport.statistics.findings import Finding, doubtful, unseen_scores
from transport.vectors import Vector, dot

if TYPE_CHECKING:
    from transport.compile.plan import Emitter, Plan
    from transport.results.tally import Tally
    from transport.scene.materials import Material
    from transport.scene.media import Grid, Medium
    from transport.scene.sources import Source
    from transport.statistics.estimates import Estimate


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
        what = (
            f"light scattered nearby in {wall.title} not sampled: {expected} within a mean free path,"
            f" {wall.distance:.3g} m"
        )
        cure = ""
    elif wall.is_small:
        what = (
            f"light of {wall.title}, {wall.distance:.3g} m away, hardly sampled: {expected} to be born there"
        )
        cure = "simulate it in a separate scene and add the results, "
    else:
        what = (
            f"light of {wall.title}, {wall.distance:.3g} m away, not sampled: {expected}"
            " to leave so close to it"
        )
        clear = min(
            wall.distance * math.sqrt(2 * MIN_SCORES_FOR_ERROR / max(wall.expected, 1e-99)),
            MAX_RELATIVE_DISTANCE * wall.extent,
        )
        cure = f"move the point to at least {clear:.2g} m from it, "
    cure += "use more particles, or use a small VolumeDetector"
    yield doubtful("near emitter", what, bound, cure)


def _near_emitters(tally: Tally, fluence: Estimate) -> Iterator[NearEmitter]:
    """Diffuse walls, media, emitters with fewer than MIN_SCORES_FOR_ERROR expected histories at the foot."""
    plan, point, particles = tally.plan, tally.detector.position, tally.particles
    born = plan.unit / (math.pi * particles)  # added by one history straight above a spot 1 m away
    one = born / _splitting_factor(plan, point)
    reach = math.sqrt(4 * MIN_SCORES_FOR_ERROR * one / fluence.value)  # from farther away enough are expected
    # Diffuse walls.
    for title, piece, material in _diffuse_walls(plan, point, reach):
        share = _diffuse_share_of_side(
            material, _side(piece, point) if isinstance(material, TwoSided) else 0.0
        )
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
        if (lamp := _small_lamp(plan, title, emitter, point, particles, born)) is not None:
            yield lamp
        if lamp is not None or not isinstance(emitter.source.emission, Lambertian):
            continue
        exitance = emitter.amount / emitter.shape.area
        distance = _distance(emitter.shape, point, math.sqrt(MIN_SCORES_FOR_ERROR * born / exitance))
        if distance is None or _side(emitter.shape, point) == (1.0 if emitter.source.is_back else -1.0):
            continue
        births = distance**2 * exitance / born
        if 2 * exitance > fluence.error / 2:
            added = born * _inverse_square_cosine(emitter.shape, point, distance)
            yield NearEmitter(title, distance, added, births, emitter.shape.extent)


def _small_lamp(
    plan: Plan, title: str, emitter: Emitter, point: Vector, particles: int, born: float
) -> NearEmitter | None:
    """A source so small as seen from the point that births score alike; None if large or facing away.

    born: score of a birth straight below a spot 1 m away [W m^-2].
    """
    distance = 0.0 if emitter.shape.is_infinite else distance_to_shape(emitter.shape, point)
    has_side = emitter.source.emission.has_side
    if not distance > MAX_RELATIVE_DISTANCE * emitter.shape.extent or (
        has_side and _side(emitter.shape, point) == (1.0 if emitter.source.is_back else -1.0)
    ):
        return None
    births = particles * emitter.bound / math.fsum(each.bound for each in plan.emitters)
    added = born / distance**2 if has_side else born / 4 / distance**2
    return NearEmitter(title, distance, added, births, emitter.shape.extent, is_small=True)


def _splitting_factor(plan: Plan, point: Vector) -> float:
    """Factor by which histories at the point are split; their weight is smaller by it."""
    return math.exp(plan.tracking.splitting.rise_at(point)) if plan.splits else 1.0


def _diffuse_walls(plan: Plan, point: Vector, reach: float) -> Iterator[tuple[str, Shape, Material]]:
    """Walls within reach that reflect or transmit diffusely, piece by piece."""
    for number, surface in enumerate(plan.scene.surfaces):
        if not _is_out_of_reach(surface.shape, point, reach) and any(
            isinstance(part, Diffuse) for part in elementary_materials(surface.material)
        ):
            title = display_name(surface, number)
            yield from ((title, piece, surface.material) for piece in pieces_of(surface.shape))


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
        faces = [
            (plan.scene.surfaces[k].shape, display_name(plan.scene.surfaces[k], k)) for k in body.surfaces
        ]
        extent = max(shape.extent for shape, _ in faces)
        if number == about and _free_path(body.medium)[0] < MAX_RELATIVE_DISTANCE * extent:
            yield f"the scattering medium inside {faces[0][1]}", None, body.medium
        beyond = min(holders[number], default=-1)  # each body comes before those that contain it
        for side, where in ((number, "inside"), (beyond, "beyond")):
            medium = bodies[side].medium if side >= 0 else surrounding_medium(plan.scene)
            if side != about and np.any(medium.scattering):
                for shape, title in faces:
                    yield from (
                        (f"the scattering medium {where} {title}", piece, medium)
                        for piece in pieces_of(shape)
                    )


def _free_path(medium: Medium | Grid) -> tuple[float, float]:
    """Mean free path [m] in a medium and its albedo; a grid of voxels counts as its mean."""
    scattering = float(np.mean(medium.scattering))
    extinction = scattering + float(np.mean(medium.absorption))
    return (1 / extinction, scattering / extinction) if scattering else (math.inf, 0.0)


def _diffuse_emitters(plan: Plan) -> Iterator[tuple[str, Emitter]]:
    sources = plan.scene.sources
    for emitter in plan.emitters:
        if isinstance(emitter.source.emission, Lambertian | Isotropic):
            number = next(k for k, source in enumerate(sources) if source is emitter.source)
            yield _source_title(sources[number], number), emitter


def _source_title(source: Source, number: int) -> str:
    return f"the source on {source.shape!r}" if isinstance(source.shape, str) else f"sources[{number}]"


def _distance(shape: Shape, point: Vector, reach: float, least: float = 0.0) -> float | None:
    """The distance [m], at least `least`; None unless it is within reach and small against the shape."""
    reach = min(reach, MAX_RELATIVE_DISTANCE * shape.extent)
    if _is_out_of_reach(shape, point, reach):
        return None
    distance = max(distance_to_shape(shape, point), least)
    return distance if 0 < distance < reach else None


def _is_out_of_reach(shape: Shape, point: Vector, reach: float) -> bool:
    """Return whether a shape is certainly farther away than `reach` [m]."""
    return not shape.is_infinite and math.dist(point, shape.middle) - shape.extent > reach


def _inverse_square_cosine(shape: Shape, point: Vector, distance: float) -> float:
    """cos / d^2 [m^-2] from the nearest spot; it is small beside a flat shape."""
    cosine = abs(_height(shape, point)) / distance if isinstance(shape, FlatShape) else 1.0
    return min(cosine, 1.0) / distance**2


def _height(shape: FlatShape, point: Vector) -> float:
    return dot(tuple(p - q for p, q in zip(point, shape.center, strict=True)), shape.normal)


def _side(shape: Shape, point: Vector) -> float:
    """+1 in front of a shape, -1 behind or inside it, 0 if neither is known."""
    match shape:
        case FlatShape():
            return math.copysign(1.0, _height(shape, point))
        case Sphere(is_zone=False):
            return 1.0 if math.dist(point, shape.center) > shape.radius else -1.0
        case Mesh(is_closed=True):
            return -1.0 if shape.holds(point) else 1.0
    return 0.0


def _diffuse_share_of_side(material: Material, side: float) -> float:
    """Largest share of a history's weight that leaves a wall diffusely on a side; side 0.0: on any."""
    sides = (material, material)
    if isinstance(material, TwoSided):
        sides = (material.front, material.back) if side >= 0 else (material.back, material.front)
        sides = (material, material) if side == 0 else sides
    here, beyond = (
        [part for part in elementary_materials(each) if isinstance(part, Diffuse)] for each in sides
    )
    sent = [part for part in here if part.albedo] + [part for part in beyond if part.transmission]
    return max((part.albedo + part.transmission for part in sent), default=0.0)


def _is_negligible(plan: Plan, share: float, fluence: Estimate) -> bool:
    """Return whether a wall sends next to no light.

    At most its irradiance, which the point sees, unless there are beams.
    """
    has_beams = any(isinstance(source.emission, Beam) for source in plan.scene.sources)
    return not has_beams and 2 * share * fluence.value < fluence.error / 2


# ---- Diagnostic "faint source".
#
# Sources with so small a share of the power that hardly any history is born on them.


def faint_sources(plan: Plan, particles: int) -> list[str]:
    """Return a warning for each source with fewer than MIN_SCORES_FOR_ERROR expected histories.

    Births are drawn in proportion to power.
    """
    if plan.adjoint is not None:
        return []
    total = math.fsum(emitter.bound for emitter in plan.emitters)
    found = []
    for number, source in enumerate(plan.scene.sources):
        share = math.fsum(emitter.bound for emitter in plan.emitters if emitter.source is source) / total
        if share < 0.5 and particles * share < MIN_SCORES_FOR_ERROR:
            found.append(
                f"{_source_title(source, number)} has {share:.2g} of the total power and so about"
                f" {particles * share:.2g} of {particles} histories: light that only it provides is not"
                " resolved; simulate it in a separate scene and add the results"
            )
    return found
