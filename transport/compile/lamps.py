"""Sources that shadow rays of a backward run end at: a Point, and a Beam from a flat shape.

No history can hit a Point, and none flies exactly along a Beam. Rays are cast to them instead, as to a point
detector (compile/points.py): from collisions, diffuse walls, and births of detectors without bins of
direction. A ray to a Point scores the pdf of its direction over the squared distance; one against a Beam,
which ends at the place of its shape that shines on the event, the pdf alone. Rays go to the images of a Point
in flat mirrors, too (compile/images.py), and score by the whole length of their path.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from transport.compile import layout
from transport.compile.images import Chain, chains_of_mirrors, image_of, mark_of
from transport.compile.next_event import LAMBERTIAN_DENSITY, min_collision_distance, pieces_or_faces
from transport.compile.points import (
    MAX_POINTS,
    PointPlan,
    Rays,
    point_plan,
    refuse_births_on_boundaries,
    scatters_anywhere,
)
from transport.compile.shapes import pass_name, rounding_of_crossings, shape_columns
from transport.geometry.relations import is_on_support
from transport.geometry.shape import Point, Shape
from transport.scene.sources import Source
from transport.validation import SceneError
from transport.vectors import Vector, dot

if TYPE_CHECKING:
    from transport.compile.plan import Plan
    from transport.scene.scene import Scene

# of the distances in the scene: nearer to a Point scores are not scaled down further ...
MIN_RELATIVE_GAP = 2.0**-26
# ... and this where a medium scatters around it, whose scores grow as one over the distance only
RELATIVE_GAP_IN_MEDIUM = 2.0**-10
SLACK_IN_ROUNDINGS = 64  # of a ray's end on a Beam's shape, in units of the rounding of coordinates


@dataclass(frozen=True)
class LampRays:
    """The shadow rays to a source of a backward run."""

    scale: float  # factor by which their sums are scaled up
    strongest: float  # largest sum of a ray from a wall, for a history of weight 1
    from_walls: bool
    from_collisions: bool
    places: tuple[Vector, ...] = ()  # of a Point, and of its images in mirrors [m]


def strength_of(source: Source, shape: Shape) -> float:
    """Return the intensity of a Point [W/sr], or the irradiance across a Beam [W m^-2]."""
    power = source.amount(shape, None)
    if source.emission.law == "beam":
        return power / shape.projected_area(source.emission.direction)
    return power / (4 * math.pi)


def diffuse_pieces(scene: Scene) -> list[tuple[Shape, float]]:
    """Return the pieces of surfaces that reflect or transmit diffusely, each with its largest share."""
    return [
        (piece, sent)
        for surface in scene.surfaces
        if (sent := surface.material.max_diffuse_share) > 0
        for piece in pieces_or_faces(surface.shape)
    ]


def add_lamp(plan: Plan, source: Source, shape: Shape, first: int) -> LampRays:
    """Add a source to the points that rays end at, with sums by cell from row `first` on."""
    chains = [()] if source.emission.law == "beam" else _chains_to(plan, shape)
    if len(plan.points) + len(chains) > MAX_POINTS:
        most = f"{MAX_POINTS} Points and Beams, images in mirrors included"
        raise SceneError(f"simulate: estimator 'backward' takes at most {most}")
    walls = diffuse_pieces(plan.scene)
    phases = plan.phase_numbers if scatters_anywhere(plan) else ()
    peak = max([LAMBERTIAN_DENSITY, *(phase.max_density for phase in phases)])
    number, size, places = len(plan.points), plan.space.size, ()
    if source.emission.law == "beam":
        largest, unit = peak, 1.0
        strongest = max((sent * LAMBERTIAN_DENSITY for _, sent in walls), default=0.0)
        scale = power_of_two(largest)
        plan.points.append(_beam(plan, source, shape, number, first, scale))
    else:
        unit, places = size * size, tuple(image_of(shape.position, chain) for chain in chains)
        largest = peak * unit / _least_distance(plan, places, walls) ** 2
        rays = (sent * strongest_ray(piece, place, places[0]) for piece, sent in walls for place in places)
        strongest = max(rays, default=0.0)
        scale = power_of_two(largest)
        for place, chain in zip(places, chains, strict=True):
            plan.points.append(point_plan(plan, source, place, number, first + mark_of(chain), scale))
    return LampRays(scale * unit, strongest, strongest > 0, bool(phases), places)


def _chains_to(plan: Plan, point: Point) -> list[Chain]:
    """Return the chains of mirrors by which rays come to a Point: none first, for straight rays."""
    return [(), *(chains_of_mirrors(plan.scene, (point,))[0] if plan.links is not None else ())]


def least_path(shape: Shape, place: Vector, position: Vector) -> float:
    """Bound the lengths [m] of rays from a shape to an image, or to the position itself, of a Point.

    No path by way of mirrors is shorter than the straight one.
    """
    return max(shape.distance(place), shape.distance(position))


def strongest_ray(shape: Shape, place: Vector, position: Vector) -> float:
    """Bound cosine / (pi r^2) [m^-2] of the same rays; 0 on a plane through the place."""
    distance, cosine = least_path(shape, place, position), 1.0
    if shape.is_flat:
        if is_on_support(place, shape):
            return 0.0
        cosine = min(abs(shape.height_of(place)) / distance, 1.0)
    return LAMBERTIAN_DENSITY * cosine / distance**2 if distance > 0 else math.inf


def _least_distance(plan: Plan, places: Sequence[Vector], walls: list[tuple[Shape, float]]) -> float:
    """Return the distance [m] whose scores are scaled to about 1: of the nearest event to a Point.

    places: of the Point, and of its images.
    """
    position = places[0]
    births = [emitter.shape for emitter in plan.emitters if emitter.ray_densities]
    pieces = [piece for piece, _ in walls]
    seen_from = [*pieces, *(emitter.shape for emitter in plan.emitters)]
    apart = [math.dist(shape.middle, position) for shape in seen_from if not shape.is_infinite]
    reach = max(apart, default=0.0) or plan.space.size
    gaps = [
        least_path(shape, place, position)
        for shape in (*pieces, *births)
        for place in places
        if strongest_ray(shape, place, position) > 0
    ]
    if scatters_anywhere(plan):
        collided = min_collision_distance(plan, Point(position=position))
        gaps.append(max(collided, RELATIVE_GAP_IN_MEDIUM * reach))
    gap = min(gaps, default=reach)
    return max(gap if gap < math.inf else reach, MIN_RELATIVE_GAP * reach)


def _beam(plan: Plan, source: Source, shape: Shape, number: int, first: int, scale: float) -> PointPlan:
    """Return a Beam ready to run: a ray per part of its shape from each event."""
    refuse_births_on_boundaries(plan, source)
    space, direction = plan.space, source.emission.direction
    slack = SLACK_IN_ROUNDINGS * (rounding_of_crossings(shape, space) + layout.ROUNDING)
    values = layout.vector_columns("u", direction) | {"slack": slack / abs(dot(direction, shape.normal))}
    parts = [
        (f"connect_to_beam_of_{pass_name(part)}", layout.row(layout.BEAM_PART, columns | values))
        for part in shape.primitives()
        if (columns := shape_columns(part, space))
    ]

    def rays(**density: float) -> list[Rays]:
        contribution = layout.row(layout.CONTRIBUTION, first=first, scale=scale, **density)
        return [Rays((part,), contribution, layout.STRAIGHT_LEG) for part in parts]

    births = [rays(**law) if (law := emitter.ray_densities) else [] for emitter in plan.emitters]
    walls = rays() if layout.DIFFUSE in plan.materials else []
    collisions = rays() if scatters_anywhere(plan) else []
    row = layout.row(layout.POINT, number=number, medium=-1)
    return PointPlan(row, first, births, walls, collisions, [])


def power_of_two(largest: float) -> float:
    """Return the power of two that scales a largest score to between 1/2 and 1."""
    return math.ldexp(1.0, -math.frexp(largest)[1])
