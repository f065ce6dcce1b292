"""Light that mirrors, glass and lenses send on to walls that a camera sees: histories from the lamps.

Histories from a camera find such light by chance alone: a diffuse reflection must meet the glass and then the
lamp, and no ray samples the way there. Histories from the lamp find it easily, as each diffuse reflection can
be connected to the pinhole. Paths

    lamp - specular ... diffuse - camera

are therefore sampled from both ends, and combined by the balance heuristic (bidirectional path tracing:
Veach 1997, chapters 9 and 10): a share of the histories starts at the lamps. Their first interaction must be
specular, and each later diffuse reflection sends a ray to the camera, which scores in the pixel that it falls
in. An arrival at a lamp of a history from the camera, if its first interaction was diffuse and its last
specular, is such a path, too.

The weights need the densities of both at any one point of the path, per area and projected solid angle, as
neither a specular nor a diffuse reflection changes their ratio. Histories from a lamp have a constant one,
those from a camera have it at their first wall. Other paths are sampled from the camera alone.

Histories from a lamp are aimed at one specular surface, and end where they meet another one first; where that
is not possible, or they are too many, they are not aimed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from transport.compile import layout
from transport.compile.lamps import diffuse_pieces, power_of_two, strongest_ray
from transport.compile.points import MAX_POINTS, PointPlan, Rays
from transport.compile.sources import emitters_of
from transport.geometry.relations import is_behind, is_on
from transport.geometry.shape import Shape
from transport.scene.cameras import CUBE, FACES, Camera, EnvironmentMap, Instrument
from transport.scene.projections import EQUAL_AREA, FISHEYE, PINHOLE, RADIAL
from transport.scene.sheets import Sheet, scene_sheets
from transport.validation import SceneError

if TYPE_CHECKING:
    from transport.compile.plan import Emitter, Plan
    from transport.scene.scene import Scene
    from transport.scene.sources import Source

KINDS_OF_VIEW = {
    None: layout.BINS_SEEN,
    PINHOLE: layout.PINHOLE_SEEN,
    FISHEYE: layout.FISHEYE_SEEN,
    EQUAL_AREA: layout.EQUAL_AREA_SEEN,
}
SHARE = 1 / 8  # of the histories that start at lamps
MAX_AIMS = 32  # pairs of lamps and specular surfaces; where there are more, no history is aimed


@dataclass(frozen=True)
class View:
    """A Camera or an EnvironmentMap that histories from lamps send rays to."""

    scale: float  # factor by which the sums of rays are scaled up [m^2]
    births: np.ndarray  # of each cell's histories, at most: density on a wall over cosine / (pi r^2)
    measures: np.ndarray  # of each cell, in which a mean is taken: pixel area at distance 1, or solid angle


@dataclass(frozen=True)
class Caustics:
    """The histories of a backward run that start at lamps."""

    share: float  # of all histories
    power: float  # [W] what all of them stand for at weight 1
    views: dict[str, View]  # by name
    densities: dict[int, float]  # of histories from each lamp [m^-2 sr^-1]
    rows: tuple[np.ndarray, ...]  # of layout.VIEW
    surfaces: np.ndarray  # by row of surfaces, 1 + the number of the surface in the scene


def emitters_at_lamps(plan: Plan, scene: Scene) -> list[Emitter]:
    """Return the emitters of histories from lamps; none where paths are sampled from cameras alone.

    They are where a camera or a map may see light that no ray connects.
    """
    try:
        found = list(_emitters(plan, scene)) if _may_start_at_lamps(plan, scene) else []
    except SceneError:  # histories cannot start at a lamp, such as one that lies in two media
        return []
    return [emitter for emitter in found if emitter.bound > 0]


def _may_start_at_lamps(plan: Plan, scene: Scene) -> bool:
    """Return whether histories may start at lamps."""
    views = [view for view in scene.instruments if view.sees_from_point]
    return (
        0 < len(views) <= MAX_POINTS
        and bool(plan.expectations)
        and plan.links is None
        and layout.DIFFUSE in plan.materials
        and any(surface.material.is_specular for surface in scene.surfaces)
        and not (plan.scatters or plan.volumes)
        and all(source.emission.law == "lambertian" for source in scene.sources)
        and not any(is_on(view.position, surface.shape) for view in views for surface in scene.surfaces)
    )


def may_show(view: Instrument, shape: Shape) -> bool:
    """Return whether a shape may be in a picture; False where a plane parts its bounds from what is seen."""
    if not isinstance(view, Camera) or view.lens != PINHOLE or shape.is_infinite:
        return True
    points = np.array(shape.bounds_corners())
    if not view.may_see_hull(points):
        return False
    # Planes along the faces of the bounds.
    (low, high), (first, last) = ((edges[0], edges[-1]) for edges in view.edges().values())
    rays = np.array([(-u, v, 1.0) for u in (first, last) for v in (low, high)]) @ np.array(view.frame)
    corners = points - view.position
    below = (corners < 0).all(axis=0) & (rays >= 0).all(axis=0)
    above = (corners > 0).all(axis=0) & (rays <= 0).all(axis=0)
    return not (below | above).any()


def add_caustics(
    plan: Plan,
    scene: Scene,
    strengths: list[float],
    sensors: list[object],
    found: list[Emitter],
    first: int,
    cells: int,
) -> Caustics:
    """Add histories from lamps to the plan of an adjoint scene, and return them.

    strengths: radiance by source [W m^-2 sr^-1]. sensors: detectors by emitter of the plan. found: emitters
    at lamps. first: first row of sums, of which each lamp has so many cells.
    """
    # Let rays to lamps and to cameras start from their own histories.
    keep = ("keep_rays_to_lamps", layout.row(layout.NO_TABLE))
    for number, each in enumerate(plan.expectations):
        walls = [replace(rays, densities=(*rays.densities, keep)) for rays in each.walls]
        plan.expectations[number] = replace(each, walls=walls)
    # Start histories at the lamps.
    power, lamps = math.fsum(emitter.bound for emitter in found), {}
    for emitter in found:
        row = emitter.cells[-1][1]
        lamp = -1 - int(row["cell"])
        row["density"] = lamps[lamp] = SHARE * strengths[lamp] / power
        plan.emitters.append(replace(emitter, amount=SHARE * emitter.bound / power, weight=1.0))
    # Make each camera and map a point that rays end at.
    walls = diffuse_pieces(scene)
    views, rows, unit = {}, [], plan.space.size**2
    for number, sensor in enumerate(sensors):
        emitter = plan.emitters[number]
        is_view = isinstance(sensor, Instrument) and sensor.sees_from_point
        row = emitter.cells[0][1]
        state = layout.row(layout.BEGINNING, began=layout.UNBEGUN if is_view else layout.OTHER_FIRST)
        plan.emitters[number] = replace(emitter, cells=(*emitter.cells, ("begin_at_sensor", state)))
        if is_view:
            view = views[sensor.name] = _view(sensor, walls, emitter.amount, unit)
            of_births = emitter.amount / (math.pi * len(view.measures) * unit)
            is_cube = isinstance(sensor, EnvironmentMap) and sensor.projection == CUBE
            kind = layout.CUBE_SEEN if is_cube else KINDS_OF_VIEW[sensor.projection_of_image]
            values = {"first": first + int(row["first"]), "cells": cells, "sensor": row, "projection": kind}
            unit_of_cells = 2 * math.pi if kind == layout.BINS_SEEN else 1.0  # their azimuths are turns
            rows.append(layout.row(layout.VIEW, **values, scale=of_births / unit_of_cells))
            plan.points.append(_point_plan(plan, rows[-1], view.scale / unit))
    for each in plan.targets:
        each.births.extend([] for _ in range(len(plan.emitters) - len(each.births)))
    surfaces = np.array([0, *(1 + number for number in plan.surface_numbers)], np.int64)
    return Caustics(SHARE, power, views, lamps, tuple(rows), surfaces)


def _view(view: Instrument, walls: list[tuple[Shape, float]], share: float, unit: float) -> View:
    """Return a camera or a map for rays from walls.

    share: of the histories that start there;  unit: of areas in the engine [m^2].
    """
    place = view.position
    rays = (sent * strongest_ray(piece, place, place) for piece, sent in walls if may_show(view, piece))
    strongest = max(rays, default=0.0)
    measures = _measures(view)
    births = share * _most_area_per_steradian(view) / (len(measures) * measures)
    scale = power_of_two(strongest * unit) * unit if strongest > 0 else unit
    return View(scale=scale, births=births, measures=measures)


def _point_plan(plan: Plan, view: np.ndarray, scale: float) -> PointPlan:
    """Return a camera as a point that rays end at: from diffuse walls alone."""
    sensor, first = view["sensor"], int(view["first"])
    place = layout.vector_columns("", (sensor["cx"], sensor["cy"], sensor["cz"]))
    row = layout.row(layout.POINT, **place, number=len(plan.points), medium=-1)
    contribution = layout.row(layout.CONTRIBUTION, first=first, scale=scale)
    weigh = ("weigh_rays_to_view", view)
    walls = [Rays((("connect_to_point", row),), contribution, layout.STRAIGHT_LEG, densities=(weigh,))]
    return PointPlan(row, first, [[] for _ in plan.emitters], walls, [], [])


def _measures(view: Instrument) -> np.ndarray:
    """Return the measure of each cell of a view, as stored: rows, then columns."""
    edges = view.edges()
    if view.projection_of_image is None:
        return np.outer(np.diff(edges["phi"]), np.diff(np.cos(edges["theta"])[::-1])).ravel()
    areas = np.outer(np.diff(edges["v"]), np.diff(edges["u"])).ravel()
    return np.tile(areas, len(FACES)) if "face" in edges else areas


def _most_area_per_steradian(view: Instrument) -> np.ndarray | float:
    """Return the largest area of the image per solid angle, of all cells or of each as stored."""
    projection, edges = view.projection_of_image, view.edges()
    if projection is None:
        return 1.0
    sides = (np.maximum(np.abs(edges[name][1:]), np.abs(edges[name][:-1])) for name in ("v", "u"))
    far = np.hypot(*np.meshgrid(*sides, indexing="ij")).ravel()
    if projection == PINHOLE:
        return (1 + far.max() ** 2) ** 1.5
    law = RADIAL[projection]
    return 1 / law.weight(np.minimum(far, law.rim))  # of a fisheye without bound at the rim


def _emitters(plan: Plan, scene: Scene) -> Iterator[Emitter]:
    """Yield the emitters of the lamps: for each specular surface one that is aimed at it."""
    sheets = scene_sheets(plan.scene)
    mirrors = [number for number, each in enumerate(scene.surfaces) if each.material.is_specular]
    is_aimed = len(mirrors) * len(scene.sources) <= MAX_AIMS
    for lamp, source in enumerate(scene.sources):
        state = {"cell": -1 - lamp, "began": layout.UNBEGUN}
        plain = replace(source, aim=None)
        if not is_aimed:
            yield from _started(emitters_of(plan, plain, sheets), state)
            continue
        shape, side = scene.shape_of(source), "back" if source.is_back else "front"
        for number in mirrors:
            if not is_behind(scene.surfaces[number].shape, shape, side):
                aimed = _aimed(plan, plain, scene.surfaces[number].shape, sheets)
                yield from _started(aimed, state | {"began": -1 - number})


def _aimed(plan: Plan, source: Source, shape: Shape, sheets: list[Sheet]) -> list[Emitter]:
    """Return the emitters of a lamp aimed at a shape; as it is where that is not possible, or costs more."""
    plain = list(emitters_of(plan, source, sheets))
    try:
        aimed = list(emitters_of(plan, replace(source, aim=shape), sheets))
    except SceneError:
        return plain
    return [one if one.weight < other.weight else other for one, other in zip(aimed, plain, strict=True)]


def _started(emitters: Iterable[Emitter], state: dict[str, int]) -> Iterator[Emitter]:
    """Yield emitters whose histories have this state at birth, and are unsampled where they end early."""
    begin = ("begin_at_lamp", layout.row(layout.BEGINNING, **state))
    for emitter in emitters:
        yield replace(emitter, cells=(begin,), target=emitter.target or ())
