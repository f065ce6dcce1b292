"""Expected crossings as rows: of each detector its shape, what births, walls and collisions send it, what flights still count.

Their sums lie behind those of the flights' crossings, scaled so that the largest is about 1: a detector that fills
1e-20 of the directions keeps all digits.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from transport.bodies.listing import body_bits_around
from transport.compile import layout
from transport.compile.emitters import CLOSE, FAINTEST, aim_columns, one_minus_cosine
from transport.compile.points import scatters_anywhere
from transport.detectors import Detector
from transport.emissions import Isotropic, Lambertian
from transport.estimators.expected import expects
from transport.materials import Diffuse, Mixture, is_specular, simple_parts
from transport.shapes import Disk, FlatShape, Mesh, Point, Shape, Sphere, Triangle
from transport.shapes.distances import is_behind, least_distance, least_height
from transport.shapes.supports import are_on_one_support
from transport.sheets import pieces
from transport.sides import IS_BACK
from transport.validation import SceneError, refuse, shown

if TYPE_CHECKING:
    from transport.compile.plan import Emitter, Plan
    from transport.sheets import Sheet

LAMBERTIAN, NEUTRAL = 1 / math.pi, 0.25 / math.pi  # greatest densities of directions [sr^-1]
BALL = 4.0  # bounds angle * r^2 / (r^2 + pi radius^2 peak) times peak
ALL, FLAT_SHARE, BALL_SHARE = 1, 2, 3  # of layout.HELD
GRID = 1.1  # times the most that is found on a grid of points
MOST_FACES = 256  # of a mesh that are told apart
SMALLEST = 1e-12  # of a coordinate: a thousand roundings across a detector

Row = np.ndarray


@dataclass(frozen=True)
class Expectation:
    """A detector that is told what to expect: rows of layout.EXPECTATION by what tells it."""

    detector: Detector
    births: list[Row | None]  # by emitter; None of those that no ray tells of
    walls: Row | None
    collisions: Row | None
    held: dict[str, float]  # columns of layout.HELD
    layer: int  # of its sheet, among the meters there
    scale: float  # by which its rows are too large
    strongest: dict[
        str, float
    ]  # by side, the most that a ray brings from a birth or wall there of a history of weight 1
    nearest: dict[str, float]  # by side, the largest share that a flight counts of what a ray tells as well
    # that of a flight from a collision at least so far away [m]; None without any
    scattered: Callable[[float], float] | None


def fill_expected(plan: Plan) -> None:
    """An Expectation for each detector that points are drawn on."""
    if not plan.expects:
        return
    scene = plan.scene
    for detector in scene.meters:
        if expects(scene, detector):
            plan.expectations.append(_expectation(plan, detector, len(plan.expectations)))
    by_name = {each.detector.name: each for each in plan.expectations}
    plan.expected_layers = [_expected_layer(plan, layer, by_name) for layer in plan.layers]


@dataclass(frozen=True)
class Guard:
    """A ball about a detector in which flights from mirrors, glass, gloss and lenses are counted, by the sheet that they come from.

    They are never added to an estimate, and never prove that there is no such light: a focus is narrower than any ball.
    """

    detector: str
    radius: float  # [m]
    row: np.ndarray  # of layout.GUARD
    surfaces: dict[int, int]  # by sheet the number of a specular surface on it


def fill_guards(plan: Plan, sheets: list[Sheet]) -> None:
    """A Guard for each detector that is told what to expect, where surfaces send light that no ray tells of."""
    if plan.turned is not None or not plan.expectations:
        return
    scene = plan.scene
    specular = {number for number, surface in enumerate(scene.surfaces) if is_specular(surface.material)}
    numbers = {id(surface): number for number, surface in enumerate(scene.surfaces)}
    found = {
        number: numbers[id(member.surface)]
        for number, sheet in enumerate(sheets, start=1)
        for member in sheet.members
        if member.surface is not None and numbers[id(member.surface)] in specular
    }
    for each in plan.expectations if found else ():
        shape = scene.shape_of(each.detector)
        apart = min(least_distance(scene.surfaces[number].shape, shape.middle) for number in specular)
        radius = math.sqrt(shape.extent * max(apart, shape.extent))
        place = layout.center_columns(plan.space.place(shape.middle))
        row = layout.row(
            layout.GUARD, **place, radius2=(radius / plan.space.size) ** 2, first=plan.size_cells
        )
        plan.guards.append(Guard(each.detector.name, radius, row, found))
        plan.size_cells += len(sheets) + 1
    for guard in plan.guards:
        guard.row["cells"] = plan.size_cells


def _expected_layer(plan: Plan, layer: np.ndarray, by_name: dict[str, Expectation]) -> np.ndarray:
    """How rays find their detector on a sheet: as flights do, with sums of its own; the other meters are not there."""
    copy = layer.copy()
    for row in copy:
        if row["look"] != 0:
            is_told = plan.meter_names[row["meter"]] in by_name
            row["look"] = row["look"] + 2 * plan.half if is_told else 0
    return copy


def _expectation(plan: Plan, detector: Detector, number: int) -> Expectation:
    shape = plan.scene.shape_of(detector)
    births = {k: kind for k, emitter in enumerate(plan.emitters) if (kind := _birth(emitter, shape))}
    walls, collisions = _walls(plan, shape), _collisions(plan, shape)
    kinds = [kind for kind in (*births.values(), walls, collisions) if kind is not None]
    is_pure = all(peak * _angle(shape, gap) <= CLOSE for peak, gap in kinds)
    bound = max((_bound(shape, is_pure, *kind) for kind in kinds), default=1.0)
    _check_size(plan, detector, shape, bound)
    scale = math.ldexp(1.0, -math.frexp(bound)[1])
    layer, sheet = _place(plan, detector)
    values = _columns(plan, detector, shape, sheet) | {"number": number, "scale": scale}

    def row(kind: tuple[float, float] | None, **more: float) -> Row | None:
        if kind is None:
            return None
        shares = {"peak": kind[0], "sharing": 0.0 if is_pure else kind[0]}
        return layout.row(layout.EXPECTATION, **values, **shares, **more)

    by_emitter = [
        row(births[k], **_law(emitter)) if k in births else None for k, emitter in enumerate(plan.emitters)
    ]
    held = _held(shape, values, is_pure, sheet)
    places = {side: _places_of_events(plan, shape, side) for side in ("front", "back")}
    strongest = {side: _strongest(shape, side, is_pure, kinds) for side, kinds in places.items()}
    nearest = {
        side: 0.0 if is_pure else max((_flights_share(shape, *kind) for *_, kind in kinds), default=0.0)
        for side, kinds in places.items()
    }
    scattered = None if is_pure or collisions is None else partial(_scattered_share, shape, *collisions)
    return Expectation(
        detector, by_emitter, row(walls), row(collisions), held, layer, scale, strongest, nearest, scattered
    )


def face_of(detector: Detector) -> str:
    """Which of the two sides of its shape a detector looks from."""
    return "back" if IS_BACK[detector.side] else "front"


def _places_of_events(plan: Plan, shape: Shape, side: str) -> list[tuple[Shape, float, tuple[float, float]]]:
    """Each emitter and diffuse wall that is not behind a side of a detector, the greatest weight that it sends, its greatest
    density and how near it comes [m]; of a run backwards the walls alone, for no ray tells of births there.
    """
    emitters = [] if plan.method.estimator == "backward" else plan.emitters
    places = [
        (emitter.shape, 1.0, max(law.values()), isinstance(emitter.source.emission, Isotropic))
        for emitter in emitters
        if (law := _law(emitter))
    ]
    for surface in plan.scene.surfaces:
        parts = [part for part in simple_parts(surface.material) if isinstance(part, Diffuse)]
        sent = max((part.albedo + part.transmission for part in parts), default=0.0)
        walls = _triangles(surface.shape) if parts and isinstance(shape, FlatShape) else pieces(surface.shape)
        places += [(piece, sent, LAMBERTIAN, False) for piece in walls if sent > 0]
    if isinstance(shape, FlatShape):
        places = [place for place in places if not is_behind(place[0], shape, side)]
    return [(where, sent, (peak, _gap(where, shape, filled))) for where, sent, peak, filled in places]


def _triangles(shape: Shape) -> tuple[Shape, ...]:
    """The pieces of a shape, of a mesh of few faces each of them: those behind a lamp do not count."""
    if not isinstance(shape, Mesh) or len(shape.faces) > MOST_FACES:
        return pieces(shape)
    try:
        return tuple(Triangle(vertices=corners) for corners in shape.vertices[shape.faces].tolist())
    except SceneError:  # a face so thin that it has no plane
        return (shape,)


def _strongest(
    shape: Shape, side: str, is_pure: bool, places: list[tuple[Shape, float, tuple[float, float]]]
) -> float:
    """The most that a ray brings from one of these places, of a history of weight 1 there."""
    most = 0.0
    bounds = [(sent * _bound(shape, is_pure, *kind), sent, place) for place, sent, kind in places]
    for bound, sent, place in sorted(bounds, key=lambda each: -each[0]):
        if bound > most:  # else its angles need not be known
            most = max(most, min(bound, sent * _slanted(place, shape, side)))
    return most


def _slanted(place: Shape, shape: Shape, side: str) -> float:
    """The most that a ray of weight 1 from the plane of a flat wall or lamp brings, for the angles at both ends; infinite of others.

    A cos(there) cos(here) / (pi r^2), with r, and the height over the wall, as of any point of the detector: r is less by its extent, the height is
    more by what of that is across the wall.
    """
    if not isinstance(place, FlatShape):
        return math.inf
    normal, reach = np.array(place.normal), shape.extent
    height = float(np.dot(normal, np.subtract(shape.middle, place.middle)))
    if abs(height) <= reach:
        return math.inf
    facing = np.zeros(3)
    if isinstance(shape, FlatShape):
        facing = np.array(shape.normal) * (-1.0 if IS_BACK[side] else 1.0)
    along = facing - np.dot(facing, normal) * normal  # the plane comes up before the detector this way
    slope = float(np.linalg.norm(along))
    lift = reach * slope if facing.any() else reach  # of a point of the detector, over its middle
    u = along / slope if slope > 0 else np.array(place.frame[0])
    across = np.cross(normal, u)
    ways, turns = np.meshgrid(abs(height) * np.geomspace(0.01, 100, 200), np.linspace(0, math.pi, 61))
    points = (
        -height * normal + (ways * np.cos(turns))[..., None] * u + (ways * np.sin(turns))[..., None] * across
    )
    apart = np.linalg.norm(points, axis=-1)
    least = np.maximum(apart - reach, 0.0)
    with np.errstate(divide="ignore"):
        there = np.minimum((abs(height) + lift) / least, 1.0)
        # as high above all of a flat one
        here = np.clip(points @ facing / least, 0.0, 1.0) if facing.any() else 1.0
        area = math.pi * shape.radius**2 if isinstance(shape, Sphere) else shape.area
        return float(np.max(there * here / least**2)) * area * LAMBERTIAN * GRID


def _scattered_share(shape: Shape, peak: float, gap: float, distance: float) -> float:
    return _flights_share(shape, peak, max(gap, distance))


def _flights_share(shape: Shape, peak: float, gap: float) -> float:
    """The most that a flight counts of what a ray tells as well, from so far away (physics/connections.py)."""
    if isinstance(shape, Sphere):
        area, distance = math.pi * shape.radius**2, gap + shape.radius
    else:
        area, distance = shape.area, gap
    return peak * area / (distance**2 + peak * area)


def _check_size(plan: Plan, detector: Detector, shape: Shape, bound: float) -> None:
    """Refuse detectors whose points numbers cannot tell apart where they lie, or whose scores they cannot hold."""
    if not bound > FAINTEST:
        refuse(detector, f"must be seen under more than {FAINTEST:g} sr, got {shown(shape)}; come closer")
    if shape.extent / plan.space.size < SMALLEST * sum(map(abs, plan.space.place(shape.middle))):
        must = f"must be larger than {SMALLEST:g} of its distance from the smallest shape of the scene"
        refuse(detector, f"{must}, got {shown(shape)}; run it in a scene of its own")


def _birth(emitter: Emitter, shape: Shape) -> tuple[float, float] | None:
    """Greatest density of a direction, and how near births come to the detector [m]."""
    law = _law(emitter)
    if not law:
        return None
    is_filled = isinstance(emitter.source.emission, Isotropic)
    return max(law.values()), _gap(emitter.shape, shape, is_filled)


def _law(emitter: Emitter) -> dict[str, float]:
    """The density of directions at birth, where a ray can tell of it; none of births that are aimed."""
    if emitter.target is not None:
        return {}
    match emitter.source.emission:
        case Lambertian():
            return {"lambertian": LAMBERTIAN}
        case Isotropic():
            return {"isotropic": NEUTRAL}
    return {}


def _walls(plan: Plan, shape: Shape) -> tuple[float, float] | None:
    """The same of what diffuse walls send; none sends anything to a flat detector on itself."""
    scene = plan.scene
    walls = [s.shape for s in scene.surfaces if any(isinstance(p, Diffuse) for p in simple_parts(s.material))]
    if not walls:
        return None
    facing = [s for s in walls if not (isinstance(shape, FlatShape) and are_on_one_support(s, shape))]
    return LAMBERTIAN, min((_gap(wall, shape) for wall in facing), default=math.inf)


def _collisions(plan: Plan, shape: Shape) -> tuple[float, float] | None:
    """The same of collisions in media that scatter."""
    if not scatters_anywhere(plan):
        return None
    return max(map(peak_of, plan.phase_numbers)), nearest_collision(plan, shape)


def peak_of(phase) -> float:
    """The greatest density of a phase function [sr^-1]; of a mixture at most the sum of its parts'."""
    if isinstance(phase, Mixture):
        return sum(share * peak_of(part) for part, share in phase.parts)
    values = getattr(phase, "values", None)
    return float(np.max(phase.density(np.array([-1.0, 1.0])) if values is None else values))


def nearest_collision(plan: Plan, shape: Shape) -> float:
    """How near a detector, or a point, collisions can be [m]: 0 where it lies in what scatters."""
    rows = np.flatnonzero(plan.media["phase"] != 0).tolist()
    bits = int(body_bits_around(plan.scene, np.array([shape.middle]))[0])
    if 0 in rows or any(bits >> (row - 1) & 1 for row in rows):
        return 0.0
    bounds = {number for row in rows for number in plan.bodies[row - 1].surfaces}
    shapes = [plan.scene.surfaces[number].shape for number in sorted(bounds)]
    if isinstance(shape, Point):
        return min((least_distance(bound, shape.position) for bound in shapes), default=math.inf)
    return min((_gap(bound, shape) for bound in shapes), default=math.inf)


def _gap(place: Shape, shape: Shape, is_filled: bool = False) -> float:
    """A bound of the distance between where events are and a detector [m]; 0 where it may be less than that."""
    if isinstance(shape, Sphere):
        return max(0.0, least_distance(place, shape.center, filled=is_filled) - shape.radius)
    reach = shape.radius if isinstance(shape, Disk) else shape.extent
    apart = least_distance(place, shape.middle, filled=is_filled) - reach
    return max(apart, least_height(place, shape))


def _angle(shape: Shape, gap: float) -> float:
    """A bound of the solid angle of a detector from so far away [sr]; of a flat one area/r^2."""
    if isinstance(shape, Sphere):
        return 2 * math.pi * one_minus_cosine(shape.radius, shape.radius + gap) if gap > 0 else 4 * math.pi
    return shape.area / gap**2 if gap > 0 else math.inf


def _bound(shape: Shape, is_pure: bool, peak: float, gap: float) -> float:
    """The most that a ray of weight 1 can bring."""
    bound = peak * _angle(shape, gap)
    return bound if is_pure else min(bound, BALL if isinstance(shape, Sphere) else 1.0)


def _columns(plan: Plan, detector: Detector, shape: Shape, sheet: int) -> dict[str, float]:
    size = plan.space.size
    values = layout.center_columns(plan.space.place(shape.middle))
    values |= {"first": plan.bases[detector.name] + 2 * plan.half, "legs": 1, "sheet": -1}
    if isinstance(shape, Sphere):
        radius = shape.radius / size
        return values | {"half_w": radius, "area": math.pi * radius * radius, "legs": 2}
    return values | aim_columns(shape, plan.space) | {"area": shape.area / size / size, "sheet": sheet}


def _place(plan: Plan, detector: Detector) -> tuple[int, int]:
    """The layer and the sheet of a detector in one piece."""
    return next(
        (layer, int(number))
        for layer, rows in enumerate(plan.layers)
        for number in np.flatnonzero(rows["look"])
        if plan.meter_names[rows[number]["meter"]] == detector.name
    )


def _held(shape: Shape, values: dict[str, float], is_pure: bool, sheet: int) -> dict[str, float]:
    """Columns of layout.HELD."""
    how = BALL_SHARE if isinstance(shape, Sphere) else FLAT_SHARE
    columns = {name: values[name] for name in ("cx", "cy", "cz", "area")}
    return columns | {"how": ALL if is_pure else how, "sheet": sheet}
