"""Rows of expected crossings: shapes of detectors, densities of events that send shadow rays, shares.

Sums of expected crossings follow those of the particles' own crossings. They are scaled so that the largest
score is about 1: a detector that fills 1e-20 of all directions keeps all digits.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from transport.compile import layout
from transport.compile.gloss import glossy_parts, lobe_peak, single_peak
from transport.compile.images import Chain, chains_of_mirrors, image_of, mark_of, mirrors_of, turned
from transport.compile.methods import uses_next_event
from transport.compile.points import Rays, scatters_anywhere
from transport.compile.shapes import pass_name, shape_columns
from transport.compile.sources import MAX_NEAR_WEIGHT, MIN_SOLID_ANGLE, one_minus_cosine
from transport.geometry.flat import Triangle
from transport.geometry.relations import are_on_one_support, is_behind, least_height
from transport.geometry.shape import Point, Shape
from transport.scene.bodies import body_bits_at
from transport.scene.detectors import Detector
from transport.scene.emissions import DIRECTION_DENSITIES
from transport.scene.sides import IS_BACK
from transport.validation import SceneError, refuse, short_repr

if TYPE_CHECKING:
    from transport.compile.plan import Emitter, Plan
    from transport.scene.materials import Surface
    from transport.scene.sheets import Sheet

LAMBERTIAN_DENSITY = DIRECTION_DENSITIES["lambertian"]  # [sr^-1] greatest density of directions
MAX_SPHERE_SCORE = 4.0  # upper bound of peak angle r^2 / (r^2 + pi radius^2 peak)
GLOSSY_TERMS = 2  # scores of a ray from a glossy wall: of single reflection, and of multiple scattering
ALL_SCORED, FLAT_SHARE, SPHERE_SHARE = 1, 2, 3  # values of `how` in layout.MIS_SHARE
GRID_SAFETY = 1.1  # safety factor over the maximum on a grid of points
MAX_FACES = 256  # of a mesh whose faces are bounded one by one
MIN_RELATIVE_SIZE = 1e-12  # of a coordinate: 1000 roundings across a detector


@dataclass(frozen=True)
class Expectation:
    """A detector whose crossings are expected: the rays that events of each kind send to it."""

    detector: Detector
    births: list[list[Rays]]  # by emitter
    walls: list[Rays]
    collisions: list[Rays]
    held: dict[str, float]  # columns of layout.MIS_SHARE
    layer: int  # of its sheet, among the detectors there
    scale: float  # factor by which its rows are scaled up
    # by side: largest score of a shadow ray from a birth or wall, for a particle of weight 1
    largest_score: dict[str, float]
    # by side: largest share that a particle's own crossing still counts, and that of one from a glossy wall
    largest_flight_share: dict[str, float]
    largest_glossy_share: dict[str, float]
    # The same share for a flight from a collision at least that far away [m]; None without collisions.
    scattered: Callable[[float], float] | None


@dataclass(frozen=True)
class Guard:
    """A sphere around a detector in which specular arrivals are counted, by the sheet that they come from.

    These are flights from mirrors, glass, lenses and gloss that sends no rays. The counts are never added to
    an estimate, and never prove that no such light exists: a focus is narrower than any sphere.
    """

    detector: str
    radius: float  # [m]
    row: np.ndarray  # of layout.GUARD
    surfaces: dict[int, int]  # by sheet, the number of a specular surface on it


def lower_next_event(plan: Plan, sheets: list[Sheet]) -> None:
    """Fill what shadow rays need: an Expectation and a Guard for each detector that they sample points on."""
    if not plan.sends_shadow_rays:
        return
    detectors = [each for each in plan.scene.meters if uses_next_event(plan.scene, each)]
    # Rays do not count reflections, which `events` of a detector asks for.
    has_events = any(detector.events is not None for detector in plan.scene.meters)
    shapes = [plan.scene.shape_of(each) for each in detectors]
    chains = None if has_events else chains_of_mirrors(plan.scene, tuple(shapes))
    if chains is not None:
        plan.links = _links(plan)
    for number, detector in enumerate(detectors):
        images = [] if chains is None else chains[number]
        plan.expectations.append(_expectation(plan, detector, number, images))
    plan.expected_layers = [_expected_layer(plan, layer) for layer in plan.layers]
    _add_guards(plan, sheets)


# ---- Shadow rays through surfaces and by way of mirrors (compile/images.py).


def _links(plan: Plan) -> np.ndarray:
    """Return what shadow rays keep at each surface, by its first row (layout.LINK)."""
    surfaces, table = plan.surfaces, np.zeros(len(plan.surfaces), layout.LINK)
    table["side"] = plan.optics["side"]
    for first in range(1, len(surfaces)):
        for side, start in ("front", first), ("back", first + int(surfaces["back"][first])):
            part = slice(start, start + int(surfaces["parts"][start]))
            share = np.diff(surfaces["share"][part], prepend=0.0) * surfaces["albedo"][part]
            material, through = surfaces["material"][part], plan.optics["through"][part]
            is_mirror = material == layout.MIRROR
            table[f"{side}_reflects"][first] = (share * (1 - through))[is_mirror].sum()
            passes = np.where(is_mirror, through, material == layout.TRANSPARENT)
            table[f"{side}_passes"][first] = (share * passes).sum()
    for number, mirror in enumerate(mirrors_of(plan.scene), start=1):
        index = next(k for k, surface in enumerate(plan.scene.surfaces) if surface is mirror)
        for row in plan.rows_of_surfaces.get(index, ()):
            table["mirror"][1 + row] = number
    return table


def _image(plan: Plan, row: np.ndarray, chain: Chain) -> np.ndarray:
    """Return the image by a chain of mirrors of a detector's row of layout.EXPECTATION."""
    found = row.copy()
    for _, mirror in chain[::-1]:
        normal, point = np.array(mirror.normal), np.array(plan.space.place(mirror.center))
        moves = {"eu": 0.0, "ev": 0.0, "n": 0.0, "c": point}
        for name, moved in moves.items():
            places = [f"{name}{axis}" for axis in "xyz"]
            vector = turned(np.array([float(found[place]) for place in places]) - moved, normal) + moved
            for place, value in zip(places, vector.tolist(), strict=True):
                found[place] = value
        if row["part_count"]:
            start, count = int(found["parts"]), int(found["part_count"])
            parts = plan.arena.memory[start : start + 80 * count].view(np.float64).reshape(count, 10)
            corners = turned(parts[:, 1:4] - point, normal) + point
            edges = turned(parts[:, 4:7], normal), turned(parts[:, 7:10], normal)
            found["parts"] = plan.arena.place(np.column_stack([parts[:, 0], corners, *edges]))
    found["sheet"] = -1
    return found


def _add_guards(plan: Plan, sheets: list[Sheet]) -> None:
    """Add a Guard per expected detector, where specular light exists that no shadow ray covers."""
    scene = plan.scene
    if plan.links is not None:
        return
    specular = {number for number, surface in enumerate(scene.surfaces) if surface.material.is_specular}
    numbers = {id(surface): number for number, surface in enumerate(scene.surfaces)}
    # Find the specular surfaces by sheet.
    found = {
        number: numbers[id(member.surface)]
        for number, sheet in enumerate(sheets, start=1)
        for member in sheet.members
        if member.surface is not None and numbers[id(member.surface)] in specular
    }
    # Place a sphere around each expected detector, and reserve its cells.
    for each in plan.expectations if found else ():
        shape = scene.shape_of(each.detector)
        apart = min(scene.surfaces[number].shape.distance(shape.middle) for number in specular)
        radius = math.sqrt(shape.extent * max(apart, shape.extent))
        place = layout.center_columns(plan.space.place(shape.middle))
        row = layout.row(
            layout.GUARD, **place, radius2=(radius / plan.space.size) ** 2, first=plan.size_cells
        )
        plan.guards.append(Guard(each.detector.name, radius, row, found))
        plan.size_cells += len(sheets) + 1
    for guard in plan.guards:
        guard.row["cells"] = plan.size_cells


def _expected_layer(plan: Plan, layer: np.ndarray) -> np.ndarray:
    """Return a layer as shadow rays see it: expected detectors only, with their expected rows."""
    copy, expected = layer.copy(), {each.detector.name for each in plan.expectations}
    for row in copy:
        if row["detector_word"] != 0:
            is_next_event = plan.detector_names[row["detector"]] in expected
            row["detector_word"] = row["detector_word"] + 2 * plan.half if is_next_event else 0
    return copy


def _expectation(plan: Plan, detector: Detector, number: int, chains: list[Chain]) -> Expectation:
    """Return the Expectation of a detector, which also has an image by each of these chains of mirrors.

    A kind of event is (largest density of directions [sr^-1], least distance from the detector [m]).

    Where glossy walls send rays, all flights score a share, as the density of gloss has no small bound.
    """
    shape = plan.scene.shape_of(detector)
    # Bound what each kind of event can send.
    births = {k: kind for k, emitter in enumerate(plan.emitters) if (kind := _birth(emitter, shape))}
    walls, collisions = _walls(plan, shape), _collisions(plan, shape)
    kinds = [kind for kind in (*births.values(), walls, collisions) if kind is not None]
    glossy = [
        place
        for surface in plan.scene.surfaces
        if not (shape.is_flat and are_on_one_support(surface.shape, shape))
        for place in _glossy_places(surface, (surface.shape,), shape)
    ]
    is_pure = not glossy and all(
        peak * _max_solid_angle(shape, gap) <= MAX_NEAR_WEIGHT for peak, gap in kinds
    )
    bounds = [_max_score(shape, is_pure, *kind) for kind in kinds]
    bounds += [
        place.sent * GLOSSY_TERMS * _max_score(shape, is_pure, place.peak, place.gap) for place in glossy
    ]
    bound = max(bounds, default=1.0)
    _check_size(plan, detector, shape, bound)
    # Scale sums by a power of two, so that the largest score is about 1.
    scale = math.ldexp(1.0, -math.frexp(bound)[1])
    layer, sheet = _layer_and_sheet(plan, detector)
    values = _columns(plan, shape, sheet) | {"number": number}
    first, legs = plan.rows_of[detector.name].first + 2 * plan.half, 1 if shape.is_flat else 2

    def rays(kind: tuple[float, float] | None, draw: str = "draw_point", **density: float) -> list[Rays]:
        if kind is None:
            return []
        row = layout.row(layout.EXPECTATION, values, sharing=0.0 if is_pure else kind[0])
        rows = [(row, first), *((_image(plan, row, chain), first + mark_of(chain)) for chain in chains)]
        ways = []
        for each, first_row in rows:
            names = _connections(shape) if ways else (draw, *_connections(shape))  # all from one draw
            contribution = layout.row(layout.CONTRIBUTION, first=first_row, scale=scale, **density)
            ways.append(Rays(tuple((name, each) for name in names), contribution, legs, kind[0]))
        return ways

    draw = "draw_point" if number else "draw_joint_point_at_birth"
    by_emitter = [rays(births.get(k), draw, **_law(emitter)) for k, emitter in enumerate(plan.emitters)]
    from_walls = rays(walls)
    if glossy:
        row = layout.row(layout.EXPECTATION, values, sharing=walls[0])
        densities = ("set_glossy_pdf", layout.row(layout.NO_TABLE)), ("share_glossy_pdf", row)
        from_walls = [replace(each, densities=densities) for each in from_walls]
    held = _mis_columns(shape, values, is_pure, sheet)
    # Bound the strongest ray and the largest MIS share per side, which diagnostics compare with the scores.
    places = {side: _places(plan, shape, side, chains) for side in ("front", "back")}
    strongest = {side: _largest_score(shape, side, is_pure, each) for side, each in places.items()}
    nearest = {side: 0.0 if is_pure else _largest_share(shape, each) for side, each in places.items()}
    glossiest = {
        side: _largest_share(shape, [place for place in each if place.is_glossy])
        for side, each in places.items()
    }
    scattered = None if is_pure or collisions is None else partial(_scattered_share, shape, *collisions)
    return Expectation(
        detector, by_emitter, from_walls, rays(collisions), held, layer, scale,
        strongest, nearest, glossiest, scattered,
    )  # fmt: skip


def side_of(detector: Detector) -> str:
    """Return the side of its shape, "front" or "back", that a detector measures on."""
    return "back" if IS_BACK[detector.side] else "front"


class Place(NamedTuple):
    """A place that sends shadow rays to a detector."""

    shape: Shape
    sent: float  # greatest weight sent
    peak: float  # greatest density of directions [sr^-1]
    gap: float  # least distance [m]
    roughness: float = 0.0  # of gloss; 0 for other places
    is_reflected: bool = False  # whether its rays come by way of mirrors

    @property
    def is_glossy(self) -> bool:
        """Whether the directions are those of gloss."""
        return self.roughness > 0


def _places(plan: Plan, shape: Shape, side: str, chains: list[Chain]) -> list[Place]:
    """Return the emitters and walls that send shadow rays to one side of a detector.

    Those behind the detector send rays by way of chains of mirrors alone. For the estimator "backward" these
    are walls alone, unless births send rays to images in mirrors, too.
    """
    has_births = plan.method.estimator != "backward" or plan.links is not None
    emitters = plan.emitters if has_births else []
    places = [Place(emitter.shape, 1.0, *_birth(emitter, shape)) for emitter in emitters if _law(emitter)]
    for surface in plan.scene.surfaces:
        sent, pieces = surface.material.max_diffuse_share, ()
        if sent > 0 or glossy_parts(surface.material):
            pieces = pieces_or_faces(surface.shape) if shape.is_flat else surface.shape.pieces()
        if sent > 0:
            places += [
                Place(piece, sent, LAMBERTIAN_DENSITY, _min_distance(piece, shape)) for piece in pieces
            ]
        places += _glossy_places(surface, pieces, shape)
    straight = [place for place in places if not is_behind(place.shape, shape, side)]
    return straight + [_reflected(place, shape, chains) for place in places if chains]


def _reflected(place: Place, shape: Shape, chains: list[Chain]) -> Place:
    """Return a place whose rays come by way of mirrors, at the distance of the detector's nearest image."""
    images = (image_of(shape.middle, chain) for chain in chains)
    gap = min(map(place.shape.distance, images)) - shape.extent
    return place._replace(gap=max(place.gap, gap), is_reflected=True)


def _glossy_places(surface: Surface, pieces: Iterable[Shape], shape: Shape) -> Iterator[Place]:
    """Yield the pieces of a surface by the gloss on them.

    The directions to the detector from a flat piece have a least cosine, which bounds the density.
    """
    for part in glossy_parts(surface.material):
        for piece in pieces:
            least = 0.0
            if piece.is_flat and not piece.is_infinite:
                farthest = math.dist(piece.middle, shape.middle) + piece.extent + shape.extent
                least = min(least_height(shape, piece) / farthest, 1.0)
            peak = max(float(single_peak(part.roughness, least)), lobe_peak(part.roughness))
            yield Place(piece, part.shares.glossy, peak, _min_distance(piece, shape), part.roughness)


def pieces_or_faces(shape: Shape) -> tuple[Shape, ...]:
    """Return the pieces of a shape; a small mesh by its faces, as those behind a detector do not count."""
    if not 0 < shape.triangles <= MAX_FACES:
        return shape.pieces()
    try:
        return tuple(Triangle(vertices=corners) for corners in shape.vertices[shape.faces].tolist())
    except SceneError:  # a face too thin to define a plane
        return (shape,)


def _largest_score(shape: Shape, side: str, is_pure: bool, places: list[Place]) -> float:
    """Return the largest score of a shadow ray from one of these places, for a particle of weight 1."""
    most, bounds = 0.0, []
    for place in places:
        terms = GLOSSY_TERMS if place.is_glossy else 1
        bounds.append((terms * place.sent * _max_score(shape, is_pure, place.peak, place.gap), place))
    for bound, place in sorted(bounds, key=lambda each: -each[0]):
        if bound > most:  # Skip the costlier bound by angles where it cannot raise the result.
            by_angles = math.inf if place.is_reflected else place.sent * _bound_by_angles(place, shape, side)
            most = max(most, min(bound, by_angles))
    return most


def _largest_share(shape: Shape, places: list[Place]) -> float:
    """Return the largest share that a flight from one of these places keeps."""
    return max((_flight_share(shape, place.peak, place.gap) for place in places), default=0.0)


def _bound_by_angles(sender: Place, shape: Shape, side: str) -> float:
    """Bound the score of a ray of weight 1 from a flat place by the angles at both ends.

    The score is A cos(there) cos(here) / (pi r^2); of shapes that are not flat the bound is infinite. It is
    bounded over all points of the detector: r is reduced by the detector's extent, and the height over the
    wall is increased by the part of the extent that lies across the wall.

    From gloss, the densities of its two kinds of reflection take the place of cos(there) / pi, each with its
    MIS weight.
    """
    place = sender.shape
    if not place.is_flat:
        return math.inf
    normal, reach = np.array(place.normal), shape.extent
    height = float(np.dot(normal, np.subtract(shape.middle, place.middle)))
    if abs(height) <= reach:
        return math.inf
    facing = np.zeros(3)
    if shape.is_flat:
        facing = np.array(shape.normal) * (-1.0 if IS_BACK[side] else 1.0)
    # The plane of a flat detector comes up in this direction.
    along = facing - np.dot(facing, normal) * normal
    slope = float(np.linalg.norm(along))
    # largest height of a point of the detector over its middle
    lift = reach * slope if facing.any() else reach
    u = along / slope if slope > 0 else np.array(place.frame[0])
    across = np.cross(normal, u)
    lines, turns = np.meshgrid(abs(height) * np.geomspace(0.01, 100, 200), np.linspace(0, math.pi, 61))
    points = (
        -height * normal
        + (lines * np.cos(turns))[..., None] * u
        + (lines * np.sin(turns))[..., None] * across
    )
    apart = np.linalg.norm(points, axis=-1)
    least = np.maximum(apart - reach, 0.0)
    with np.errstate(divide="ignore"):
        there = np.minimum((abs(height) + lift) / least, 1.0)
        # A flat detector is equally high above all of these points.
        here = np.clip(points @ facing / least, 0.0, 1.0) if facing.any() else 1.0
        area = shape.cross_section
        if not sender.is_glossy:
            return float(np.max(there * here / least**2)) * area * LAMBERTIAN_DENSITY * GRID_SAFETY
        lowest = np.maximum(abs(height) - lift, 0.0) / (apart + reach)
        densities = single_peak(sender.roughness, lowest), lobe_peak(sender.roughness) * there
        scores = sum(each / (1.0 + each * area / (apart + reach) ** 2) for each in densities)
        return float(np.max(scores * here / least**2)) * area * GRID_SAFETY


def _scattered_share(shape: Shape, peak: float, gap: float, distance: float) -> float:
    return _flight_share(shape, peak, max(gap, distance))


def _flight_share(shape: Shape, peak: float, gap: float) -> float:
    """Return the largest share that a particle's own crossing keeps from that distance [m].

    See physics/connections.py.
    """
    area, distance = shape.cross_section, gap + _depth(shape)
    return peak * area / (distance**2 + peak * area)


def _depth(shape: Shape) -> float:
    """Return how far the surface of a detector lies before its middle [m]: the radius of a sphere."""
    return 0.0 if shape.is_flat else shape.radius


def _check_size(plan: Plan, detector: Detector, shape: Shape, bound: float) -> None:
    """Refuse detectors too small for rounding to resolve their points, or for their scores to be held."""
    if not bound > MIN_SOLID_ANGLE:
        refuse(
            detector, f"must subtend more than {MIN_SOLID_ANGLE:g} sr, got {short_repr(shape)}; come closer"
        )
    if shape.extent / plan.space.size < MIN_RELATIVE_SIZE * sum(map(abs, plan.space.place(shape.middle))):
        must = (
            f"must be larger than {MIN_RELATIVE_SIZE:g} times its distance from the smallest shape of the"
            " scene"
        )
        refuse(detector, f"{must}, got {short_repr(shape)}; run it in a scene of its own")


def _birth(emitter: Emitter, shape: Shape) -> tuple[float, float] | None:
    """Return the greatest density of directions [sr^-1] and the least distance [m] of births.

    None where they send no shadow rays.
    """
    law = _law(emitter)
    if not law:
        return None
    is_filled = emitter.source.emission.fills_volume
    return max(law.values()), _min_distance(emitter.shape, shape, is_filled)


def _law(emitter: Emitter) -> dict[str, float]:
    """Return the density of directions at birth that shadow rays use; empty for births with a target, too."""
    return {} if emitter.target is not None else emitter.ray_densities


def _walls(plan: Plan, shape: Shape) -> tuple[float, float] | None:
    """Return the same for walls, of diffuse ones; a flat detector on a wall receives nothing from it."""
    walls = [
        surface.shape
        for surface in plan.scene.surfaces
        if surface.material.max_diffuse_share > 0 or glossy_parts(surface.material)
    ]
    if not walls:
        return None
    is_own = shape.is_flat and plan.links is None
    facing = [s for s in walls if not (is_own and are_on_one_support(s, shape))]
    return LAMBERTIAN_DENSITY, min((_min_distance(wall, shape) for wall in facing), default=math.inf)


def _collisions(plan: Plan, shape: Shape) -> tuple[float, float] | None:
    """Return the same for collisions in media that scatter."""
    if not scatters_anywhere(plan):
        return None
    return max(phase.max_density for phase in plan.phase_numbers), min_collision_distance(plan, shape)


def min_collision_distance(plan: Plan, shape: Shape) -> float:
    """Return the least distance of collisions from a detector [m]; 0 in a medium that scatters."""
    rows = np.flatnonzero(plan.media["phase"] != 0).tolist()
    bits = int(body_bits_at(plan.scene, np.array([shape.middle]))[0])
    if 0 in rows or any(bits >> (row - 1) & 1 for row in rows):
        return 0.0
    bounds = {number for row in rows for number in plan.bodies[row - 1].surfaces}
    shapes = [plan.scene.surfaces[number].shape for number in sorted(bounds)]
    if isinstance(shape, Point):
        return min((bound.distance(shape.position) for bound in shapes), default=math.inf)
    return min((_min_distance(bound, shape) for bound in shapes), default=math.inf)


def _min_distance(place: Shape, shape: Shape, is_filled: bool = False) -> float:
    """Return a lower bound of the distance between the place of events and a detector [m]."""
    apart = place.distance(shape.middle, filled=is_filled) - shape.extent
    return max(apart, least_height(place, shape) if shape.is_flat else 0.0)


def _max_solid_angle(shape: Shape, gap: float) -> float:
    """Return an upper bound of a detector's solid angle from that distance [sr]; for a flat one area/r^2."""
    if not shape.is_flat:
        return 2 * math.pi * one_minus_cosine(shape.radius, shape.radius + gap) if gap > 0 else 4 * math.pi
    return shape.area / gap**2 if gap > 0 else math.inf


def _max_score(shape: Shape, is_pure: bool, peak: float, gap: float) -> float:
    """Return the largest score of a ray of weight 1."""
    bound = peak * _max_solid_angle(shape, gap)
    return bound if is_pure else min(bound, 1.0 if shape.is_flat else MAX_SPHERE_SCORE)


def _connections(shape: Shape) -> tuple[str, ...]:
    """Return the passes that sample a point on a detector's shape and connect an event to it."""
    if not shape.is_flat:
        return ("connect_to_ball",)
    parts = shape.primitives()
    return f"point_on_{'polygon' if len(parts) > 1 else pass_name(parts[0])}", "connect_to_flat"


def _columns(plan: Plan, shape: Shape, sheet: int) -> dict[str, float]:
    """Return the columns of layout.EXPECTATION that do not depend on the kind of event."""
    size = plan.space.size
    values = layout.center_columns(plan.space.place(shape.middle))
    values |= {"sheet": -1, "area": shape.cross_section / size / size}
    if not shape.is_flat:
        return values | {"half_w": shape.radius / size}
    parts = shape.primitives()
    columns = _part_columns(plan, shape) if len(parts) > 1 else shape_columns(parts[0], plan.space)
    return values | columns | {"sheet": sheet}


def _part_columns(plan: Plan, shape: Shape) -> dict[str, float]:
    """Return the columns of the triangles on which points of a polygon are sampled."""
    parts, names = shape.primitives(), ("cx", "cy", "cz", "eux", "euy", "euz", "evx", "evy", "evz")
    shares = np.cumsum([part.area for part in parts])
    columns = [shape_columns(part, plan.space) for part in parts]
    table = np.column_stack([shares / shares[-1], [[each[name] for name in names] for each in columns]])
    return layout.frame_columns(shape.frame) | {"parts": plan.arena.place(table), "part_count": len(parts)}


def _layer_and_sheet(plan: Plan, detector: Detector) -> tuple[int, int]:
    """Return the layer and the sheet of a detector in one piece."""
    return next(
        (layer, int(number))
        for layer, rows in enumerate(plan.layers)
        for number in np.flatnonzero(rows["detector_word"])
        if plan.detector_names[rows[number]["detector"]] == detector.name
    )


def _mis_columns(shape: Shape, values: dict[str, float], is_pure: bool, sheet: int) -> dict[str, float]:
    """Return the columns of layout.MIS_SHARE."""
    how = FLAT_SHARE if shape.is_flat else SPHERE_SHARE
    columns = {name: values[name] for name in ("cx", "cy", "cz", "area")}
    return columns | {"how": ALL_SCORED if is_pure else how, "sheet": sheet}
