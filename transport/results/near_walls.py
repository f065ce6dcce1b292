"""Whether a point lies so near to what sends diffusely that a run misses what that sends: walls, emitters, thick media.

Half of what reaches a point at the small distance d from a diffuse wall leaves it within about d of the foot.  Where
hardly any history does so, all that it brings is missing, and so is its variance: neither scores nor errors tell.
Geometry does: what a single history at the foot would add, w cos / (pi d^2), is known, and must not matter.
With n of them a pi d^2 it is sqrt(2 / n) errors of what the wall sends, whose scores s then have
(sum of s^2)^2 / (sum of s^4) = 5 n / 4.  A medium that scatters is such a wall, as rough as its mean free path is long.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from transport.bodies.listing import body_bits_around, nested, surrounding_of
from transport.emissions import Beam, Isotropic, Lambertian
from transport.materials import Diffuse, TwoSided, simple_parts
from transport.materials.surface import titled
from transport.results.findings import DOUBTFUL, MIN_SCORES, Finding, unseen_scores
from transport.shapes import FlatShape, Mesh, Shape, Sphere
from transport.shapes.distances import least_distance
from transport.sheets import pieces
from transport.vectors import Vector, dot

if TYPE_CHECKING:
    from transport.compile.plan import Emitter, Plan
    from transport.materials import Material
    from transport.media import Grid, Medium
    from transport.results.estimates import Estimate

NEAR = 0.25  # of a wall's extent: from farther away a run without its light is one without light


@dataclass(frozen=True)
class NearWall:
    """A wall or an emitter near a point, and what a run knows of what it sends from about the foot."""

    title: str
    distance: float  # [m]
    added: float  # by one history of the largest weight that leaves it nearest to the point [W m^-2]
    expected: float  # about how many full histories leave it within d of the foot
    extent: float  # [m]
    is_about: bool = False  # a medium that the point is in; then d is its mean free path
    is_small: bool = (
        False  # a lamp farther away than it is large; then histories are counted wherever they leave it
    )


def near_walls_of_point(
    plan: Plan, name: str, point: Vector, fluence: Estimate, particles: int
) -> Iterator[Finding]:
    """The wall that may add most to a point detector, with the bound as a fluence rate [W m^-2]; nothing where none may."""
    if not fluence.value > 0:
        return
    found = [
        (unseen_scores(wall.expected) * wall.added, wall)
        for wall in _senders(plan, point, fluence, particles)
    ]
    bound, wall = max(found, key=lambda one: one[0], default=(0.0, None))
    if not bound > 0:
        return
    expected = f"only about {wall.expected:.2g} histories are expected"
    if wall.is_about:
        what = f"light scattered close by in {wall.title} not sampled: {expected} within a mean free path, {wall.distance:.3g} m"
        cure = ""
    elif wall.is_small:
        what = (
            f"light of {wall.title}, {wall.distance:.3g} m away, hardly sampled: {expected} to be born there"
        )
        cure = "run it in a scene of its own and add the results, "
    else:
        what = f"light of {wall.title}, {wall.distance:.3g} m away, not sampled: {expected} to leave so close to it"
        clear = min(wall.distance * math.sqrt(2 * MIN_SCORES / max(wall.expected, 1e-99)), NEAR * wall.extent)
        cure = f"move the point to at least {clear:.2g} m off it, "
    cure += "use more particles, or count by a small VolumeDetector"
    yield Finding(DOUBTFUL, f"point detector {name!r}", "", what, bound, cure, name="near emitter")


def _senders(plan: Plan, point: Vector, fluence: Estimate, particles: int) -> Iterator[NearWall]:
    """Diffuse walls, media and emitters of which fewer than MIN_SCORES histories are expected from about the foot."""
    born = plan.unit / (math.pi * particles)  # added by one history straight above a place 1 m away
    one = born / _importance(plan, point)
    reach = math.sqrt(4 * MIN_SCORES * one / fluence.value)  # from farther away so many are expected
    for title, piece, material in _walls(plan, point, reach):
        share = _sent(material, _side(piece, point) if isinstance(material, TwoSided) else 0.0)
        distance = _distance(piece, point, reach)
        if distance is not None and not _is_dark(plan, share, fluence):
            arrivals = distance**2 * fluence.value / 4 / one  # as in light from everywhere
            added = one * share * _steepness(piece, point, distance)
            yield NearWall(title, distance, added, arrivals, piece.extent)
    for title, shape, medium in _scatterers(plan, point):
        path, share = _free_path(medium)
        distance = path if shape is None else _distance(shape, point, reach, path)
        if distance is not None and not _is_dark(plan, share, fluence):
            arrivals = distance**2 * fluence.value / 4 / one
            extent = math.inf if shape is None else shape.extent
            yield NearWall(title, distance, one * share / distance**2, arrivals, extent, shape is None)
    for title, emitter in _even_emitters(plan):
        if (lamp := _small_lamp(plan, title, emitter, point, particles, born)) is not None:
            yield lamp
        if lamp is not None or not isinstance(emitter.source.emission, Lambertian):
            continue
        exitance = emitter.amount / emitter.shape.area
        distance = _distance(emitter.shape, point, math.sqrt(MIN_SCORES * born / exitance))
        if distance is None or _side(emitter.shape, point) == (1.0 if emitter.source.is_back else -1.0):
            continue
        births = distance**2 * exitance / born
        if 2 * exitance > fluence.error / 2:
            added = born * _steepness(emitter.shape, point, distance)
            yield NearWall(title, distance, added, births, emitter.shape.extent)


def _small_lamp(
    plan: Plan, title: str, emitter: Emitter, point: Vector, particles: int, born: float
) -> NearWall | None:
    """A lamp that is small as seen from the point, all of whose births count much alike; None where it is large or looks away.

    born: what a birth straight below a place 1 m away adds there [W m^-2].
    """
    distance = 0.0 if emitter.shape.is_infinite else least_distance(emitter.shape, point)
    looks = emitter.source.emission.has_side
    if not distance > NEAR * emitter.shape.extent or (
        looks and _side(emitter.shape, point) == (1.0 if emitter.source.is_back else -1.0)
    ):
        return None
    births = particles * emitter.bound / math.fsum(each.bound for each in plan.emitters)
    added = born / distance**2 if looks else born / 4 / distance**2
    return NearWall(title, distance, added, births, emitter.shape.extent, is_small=True)


def _importance(plan: Plan, point: Vector) -> float:
    """By how much histories there have been split: what one weighs is as much less."""
    return math.exp(plan.tracking.splitting.rise_at(point)) if plan.splits else 1.0


def _walls(plan: Plan, point: Vector, reach: float) -> Iterator[tuple[str, Shape, Material]]:
    """All within reach that reflects or lets through diffusely, piece by piece."""
    for number, surface in enumerate(plan.scene.surfaces):
        if not _is_beyond(surface.shape, point, reach) and any(
            isinstance(part, Diffuse) for part in simple_parts(surface.material)
        ):
            title = titled(surface, number)
            yield from ((title, piece, surface.material) for piece in pieces(surface.shape))


def _scatterers(plan: Plan, point: Vector) -> Iterator[tuple[str, Shape | None, Medium | Grid]]:
    """The media that scatter: of those elsewhere their boundaries, piece by piece; of the one about the point None."""
    if not plan.scatters:
        return
    bodies, holders = nested(plan.scene)
    bits = int(body_bits_around(plan.scene, np.array([point]))[0])
    about = (bits & -bits).bit_length() - 1
    if about < 0 and np.any(surrounding_of(plan.scene).scattering):
        yield "a medium that scatters", None, surrounding_of(plan.scene)
    for number, body in enumerate(bodies):
        faces = [(plan.scene.surfaces[k].shape, titled(plan.scene.surfaces[k], k)) for k in body.surfaces]
        extent = max(shape.extent for shape, _ in faces)
        if number == about and _free_path(body.medium)[0] < NEAR * extent:
            yield f"what scatters inside {faces[0][1]}", None, body.medium
        beyond = min(holders[number], default=-1)  # each comes before those that hold it
        for side, where in ((number, "inside"), (beyond, "beyond")):
            medium = bodies[side].medium if side >= 0 else surrounding_of(plan.scene)
            if side != about and np.any(medium.scattering):
                for shape, title in faces:
                    yield from ((f"what scatters {where} {title}", piece, medium) for piece in pieces(shape))


def _free_path(medium: Medium | Grid) -> tuple[float, float]:
    """The mean free path [m] in a medium, and its albedo; in one of voxels as if they were mixed."""
    scattering = float(np.mean(medium.scattering))
    extinction = scattering + float(np.mean(medium.absorption))
    return (1 / extinction, scattering / extinction) if scattering else (math.inf, 0.0)


def _even_emitters(plan: Plan) -> Iterator[tuple[str, Emitter]]:
    sources = plan.scene.sources
    for emitter in plan.emitters:
        if isinstance(emitter.source.emission, Lambertian | Isotropic):
            shape = emitter.source.shape
            number = next(k for k, source in enumerate(sources) if source is emitter.source)
            title = f"the source on {shape!r}" if isinstance(shape, str) else f"sources[{number}]"
            yield title, emitter


def _distance(shape: Shape, point: Vector, reach: float, least: float = 0.0) -> float | None:
    """The distance [m], or `least` where it is nearer; None unless that is within reach and small against the shape."""
    reach = min(reach, NEAR * shape.extent)
    if _is_beyond(shape, point, reach):
        return None
    distance = max(least_distance(shape, point), least)
    return distance if 0 < distance < reach else None


def _is_beyond(shape: Shape, point: Vector, reach: float) -> bool:
    """Whether a shape is surely farther away than that [m]."""
    return not shape.is_infinite and math.dist(point, shape.middle) - shape.extent > reach


def _steepness(shape: Shape, point: Vector, distance: float) -> float:
    """cos / d^2 [m^-2] as seen from the nearest place; beside a flat shape it is low."""
    cosine = abs(_height(shape, point)) / distance if isinstance(shape, FlatShape) else 1.0
    return min(cosine, 1.0) / distance**2


def _height(shape: FlatShape, point: Vector) -> float:
    return dot(tuple(p - q for p, q in zip(point, shape.center, strict=True)), shape.normal)


def _side(shape: Shape, point: Vector) -> float:
    """+1 in front of a shape, -1 behind or within it, 0 where neither is known."""
    match shape:
        case FlatShape():
            return math.copysign(1.0, _height(shape, point))
        case Sphere(is_zone=False):
            return 1.0 if math.dist(point, shape.center) > shape.radius else -1.0
        case Mesh(is_closed=True):
            return -1.0 if shape.holds(point) else 1.0
    return 0.0


def _sent(material: Material, side: float) -> float:
    """The largest share of a history's weight that leaves a wall diffusely on a side; 0.0: on any."""
    sides = (material, material)
    if isinstance(material, TwoSided):
        sides = (material.front, material.back) if side >= 0 else (material.back, material.front)
        sides = (material, material) if side == 0 else sides
    here, beyond = ([part for part in simple_parts(each) if isinstance(part, Diffuse)] for each in sides)
    sent = [part for part in here if part.albedo] + [part for part in beyond if part.transmission]
    return max((part.albedo + part.transmission for part in sent), default=0.0)


def _is_dark(plan: Plan, share: float, fluence: Estimate) -> bool:
    """Whether a wall could send next to nothing: no more than falls on it, and the point sees that but for beams."""
    has_beams = any(isinstance(source.emission, Beam) for source in plan.scene.sources)
    return not has_beams and 2 * share * fluence.value < fluence.error / 2
