"""The adjoint scene of the estimator "backward": detectors emit bin by bin, and sources are detected.

The scene that is run is an ordinary scene with an ordinary plan. Two things differ: each particle is born in
a cell, which is one bin of a detector (engine/passes/backward.py), and what it brings to a source is summed
by its cell of birth.
See transport.compile.methods.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from transport.compile import layout
from transport.compile.caustics import SHARE, Caustics, add_caustics, emitters_at_lamps
from transport.compile.detectors import LARGE_SHARE, edge_columns
from transport.compile.lamps import LampRays, add_lamp, strength_of
from transport.compile.media import emitting_media
from transport.compile.methods import found_by_rays_alone
from transport.compile.next_event import side_of
from transport.compile.plan import Emitter, Step
from transport.compile.rows import Rows
from transport.compile.sources import medium_row
from transport.geometry.flat import Disk, Rectangle
from transport.geometry.shape import Point, Shape
from transport.scene.bins import DirectionCone
from transport.scene.cameras import (
    BALL,
    CUBE,
    CYLINDER,
    FACES,
    IMAGE_FRAMES,
    LATITUDE_LONGITUDE,
    ORTHOGRAPHIC,
    THIN_LENS,
    Camera,
    EnvironmentMap,
    Instrument,
    LightField,
)
from transport.scene.detectors import Detector
from transport.scene.emissions import Isotropic, Lambertian
from transport.scene.points import PointDetector
from transport.scene.projections import EQUAL_AREA, FISHEYE, PINHOLE, RADIUS_OF_ALL
from transport.scene.scene import Scene
from transport.scene.sources import Source
from transport.scene.volumes import VolumeDetector
from transport.validation import SceneError, short_repr

if TYPE_CHECKING:
    from transport.compile.plan import Plan

Sensor = Detector | PointDetector | Instrument
# passes that sample a place, sample a direction and set a weight; None where not needed
Passes = tuple[str | None, str | None, str | None]
PLACE_PASSES = {Disk: "start_on_disk", Rectangle: "start_on_rectangle"}
DIRECTION_PASSES = {
    "cosine_law_from_plane": "hemisphere_direction_in_cell",
    "cosine_law_from_surface": "hemisphere_direction_in_cell",
    "uniform_direction": "direction_in_cell",
    "direction_through_pixel": "direction_in_cell",
    "direction_through_fisheye": "direction_in_round_image",
    "direction_through_equal_area": "direction_in_round_image",
    "direction_through_cube": "direction_in_cell",
    "direction_to_plane": "direction_in_cell",
}
FISHEYE_PASSES = None, "direction_through_fisheye", "weigh_round_image"
EQUAL_AREA_PASSES = None, "direction_through_equal_area", "weigh_round_image"
LENS_PASSES: dict[str, Passes] = {
    PINHOLE: (None, "direction_through_pixel", "weigh_pixel"),
    FISHEYE: FISHEYE_PASSES,
    EQUAL_AREA: EQUAL_AREA_PASSES,
    ORTHOGRAPHIC: ("start_on_rectangle", "direction_of_view", None),
    THIN_LENS: ("start_on_disk", "direction_to_plane", "weigh_lens"),
}
MAP_PASSES: dict[str, Passes] = {
    LATITUDE_LONGITUDE: (None, "uniform_direction", None),
    CYLINDER: (None, "uniform_direction", None),
    CUBE: (None, "direction_through_cube", "weigh_cube"),
    FISHEYE: FISHEYE_PASSES,
    EQUAL_AREA: EQUAL_AREA_PASSES,
    BALL: EQUAL_AREA_PASSES,
}


@dataclass(frozen=True)
class DetectedSource:
    """A source of the user's scene, and the detector that replaces it in the adjoint scene, if any does."""

    name: str
    source: Source
    detector: Detector | VolumeDetector | None  # None where only shadow rays find it (compile/lamps.py)
    # Radiance [W m^-2 sr^-1]; for a volume, emission coefficient [W m^-3 sr^-1]; for a Point, intensity
    # [W/sr]; for a Beam, irradiance across it [W m^-2].
    strength: float


@dataclass(frozen=True)
class SensorPart:
    """One piece of a detector's shape: its cells start at `first`, each with the same number of particles."""

    sensor: Sensor
    shape: Shape
    first: int
    cells: int
    share: float  # share of all particles of the run
    # By source: value of a sum of 1 over one particle [W m^-2 sr^-1], refractive indices included.
    gains: np.ndarray


@dataclass(frozen=True)
class Adjoint:
    """The user's scene behind an adjoint plan, and where its sums by cell of birth lie.

    Rows from `first` on hold, per cell: the particles born in it; then for each source what they brought;
    then what shadow rays brought (slants: the number of strong ones); then what rays from histories of lamps
    brought.
    """

    scene: Scene
    sources: tuple[DetectedSource, ...]
    parts: tuple[SensorPart, ...]
    first: int
    cells: int
    rays: dict[int, LampRays]  # by source that shadow rays are sent to
    ray_lamps: tuple[np.ndarray, ...]  # rows of layout.RAY_LAMP of those without a detector
    caustics: Caustics | None = None  # histories that start at lamps

    def parts_of(self, sensor: Sensor) -> list[SensorPart]:
        """Return the pieces of a detector."""
        return [part for part in self.parts if part.sensor is sensor]


def adjoint_scene(scene: Scene) -> tuple[Scene, tuple[DetectedSource, ...]]:
    """Return the adjoint scene and the sources that its detectors stand for, in the same order."""
    lamps = [_detected_source(scene, source, f"sources[{k}]") for k, source in enumerate(scene.sources)]
    lamps += [_detected_source(scene, glow, f"glow[{k}]") for k, glow in enumerate(emitting_media(scene))]
    sources = [_source(detector) for detector in scene.detectors]
    detectors = [lamp.detector for lamp in lamps if lamp.detector is not None]
    turned = Scene(sources=sources, surfaces=scene.surfaces, detectors=detectors, medium=scene.medium)
    return turned, tuple(lamps)


def _source(sensor: Sensor) -> Source:
    """Return the source that emits the particles of a detector."""
    if isinstance(sensor, Detector):
        return Source(sensor.shape, Lambertian(power=1.0), side=sensor.side)
    if isinstance(sensor, Instrument) and not isinstance(sensor.shape, Point):
        return Source(sensor.shape, Lambertian(power=1.0))
    return Source(Point(position=sensor.position), Isotropic(power=1.0))


def _detected_source(scene: Scene, source: Source, place: str) -> DetectedSource:
    """Return a source with the detector that replaces it, and its strength."""
    shape, label = scene.shape_of(source), f"lamp {place}"
    is_only = [other.shape for other in scene.sources].count(source.shape) == 1
    name = source.shape if isinstance(source.shape, str) and is_only else place
    if found_by_rays_alone(scene, source):
        return DetectedSource(name, source, None, strength_of(source, shape))
    power = source.amount(shape, None)
    if source.emission.fills_volume:
        return DetectedSource(
            place, source, VolumeDetector(shape, name=label), power / (4 * math.pi * shape.volume)
        )
    seen_by = Detector(source.shape, name=label, side=source.side)
    return DetectedSource(name, source, seen_by, power / (math.pi * shape.area))


def fill_adjoint(plan: Plan, scene: Scene, lamps: tuple[DetectedSource, ...]) -> None:
    """Set the cells of birth in the plan of an adjoint scene, and the rows of its sums by cell."""
    parts, emitters, first, at_lamps = [], [], 0, emitters_at_lamps(plan, scene)
    # Divide each detector's particles among the pieces of its shape, and number the cells.
    for sensor, source in zip(scene.detectors, plan.scene.sources, strict=True):
        mine = [emitter for emitter in plan.emitters if emitter.source is source]
        whole = math.fsum(emitter.amount for emitter in mine)
        for emitter in mine:
            share = emitter.amount / whole / len(scene.detectors) * (1.0 - SHARE if at_lamps else 1.0)
            columns, (place, direction, weigh) = _cells_of(plan, sensor, emitter)
            cells = math.prod(int(columns[f"{axis}_cells"]) for axis in ("mu", "turn", "u", "v"))
            gains = gains_of(plan, scene, lamps, emitter)
            parts.append(SensorPart(sensor, emitter.shape, first, cells, share, gains))
            row = layout.row(layout.SENSOR, **columns, first=first, cells=cells, part=len(parts))
            emitters.append(_emitter(emitter, share, row, place, direction, weigh))
            first += cells
    plan.emitters = emitters
    rays, rows = _fill_rows(plan, scene, lamps, first, bool(at_lamps))
    base, caustics = plan.rows_of["cells"].first, None
    if at_lamps:
        sensors, start = [part.sensor for part in parts], base + (1 + 2 * len(lamps)) * first
        strengths = [lamp.strength for lamp in lamps]
        caustics = add_caustics(plan, scene, strengths, sensors, at_lamps, start, first)
        for number, density in caustics.densities.items():
            of_lamp = [name == lamps[number].detector.name for name in plan.detector_names]
            plan.detectors["lamp_density"][of_lamp] = density
    plan.adjoint = Adjoint(scene, lamps, tuple(parts), base, first, rays, rows, caustics)


def _emitter(
    emitter: Emitter,
    share: float,
    row: np.ndarray,
    place: str | None,
    direction: str | None,
    weigh: str | None,
) -> Emitter:
    """Return a detector's emitter: its passes sample place, direction and weight within a cell."""
    steps: list[Step] = [("assign_cells", row)]
    if place is not None:
        steps += [("draw_place", layout.row(layout.NO_TABLE)), ("place_in_cell", row)]
    if direction is not None:
        steps += [("draw_direction", layout.row(layout.NO_TABLE))]
        steps += [(DIRECTION_PASSES[direction], row)] if direction in DIRECTION_PASSES else []
    return replace(
        emitter,
        amount=share,
        cells=tuple(steps),
        place=emitter.place if place is None else (place, row),
        law=emitter.law if direction is None else (direction, row),
        is_divided=direction is not None,
        facing=emitter.facing if direction is None else None,
        target=None if weigh is None else ((weigh, row),),
    )


def _fill_rows(
    plan: Plan, scene: Scene, lamps: tuple[DetectedSource, ...], cells: int, starts_at_lamps: bool
) -> tuple[dict[int, LampRays], tuple[np.ndarray, ...]]:
    """Place the sums by cell after all other rows, and point the detectors and shadow rays to them.

    Return the rays by source, and the rows of the sources without a detector.
    """
    has_rays = bool(plan.expectations) or any(lamp.detector is None for lamp in lamps)
    first, blocks = plan.rows, 1 + len(lamps) * (1 + has_rays + starts_at_lamps)
    plan.rows_of["cells"] = Rows(first, (), (), blocks * cells)
    plan.rows = plan.rows_of["cells"].past
    plan.axes.add("cell")
    volumes, rays, rows = iter(plan.volumes), {}, []
    for number, lamp in enumerate(lamps, start=1):
        of_rays = first + (number + len(lamps)) * cells
        if isinstance(lamp.detector, VolumeDetector):
            next(volumes).row["first"] = first + number * cells
        elif lamp.detector is None:
            shape = scene.shape_of(lamp.source)
            found = rays[number - 1] = add_lamp(plan, lamp.source, shape, of_rays)
            strong = LARGE_SHARE * found.strongest * found.scale
            rows.append(layout.row(layout.RAY_LAMP, strong=strong, first=of_rays))
        else:
            of_lamp = [name == lamp.detector.name for name in plan.detector_names]
            plan.detectors["by_cell"][of_lamp] = first + number * cells
            plan.detectors["of_rays"][of_lamp] = of_rays
            for each in plan.expectations:
                if each.detector.name == lamp.detector.name:
                    strongest = each.largest_score[side_of(lamp.detector)]
                    plan.detectors["strong"][of_lamp] = LARGE_SHARE * strongest * each.scale
                    events = bool(each.walls), bool(each.collisions)
                    rays[number - 1] = LampRays(each.scale, strongest, *events)
    # A birth in a bin of directions sends its flight alone, as rays in all directions could not respect the
    # bin; so do all births where nothing is specular, as most lamps are large.
    for number, emitter in enumerate(plan.emitters):
        for each in plan.expectations:
            if plan.links is None or emitter.is_divided:
                each.births[number] = []
        emitter.cells[0][1]["births"] = first
    return rays, tuple(rows)


def gains_of(plan: Plan, scene: Scene, lamps: tuple[DetectedSource, ...], emitter: Emitter) -> np.ndarray:
    """Return strength times (eta_d/eta_s)^2 by source; a volume's also times its sums' unit [m]."""
    here, volumes, gains = _refractive_index(emitter.medium, emitter.source), iter(plan.volumes), []
    for lamp in lamps:
        sides = [medium_row(scene, lamp.source, piece) for piece in _pieces_of(scene, lamp.source)]
        there = {_refractive_index(side, lamp.source) for side in sides}
        if len(there) > 1:
            raise SceneError(
                f"Source: it emits into several media, got {short_repr(lamp.source.shape)}; divide it"
            )
        is_volume = isinstance(lamp.detector, VolumeDetector)
        length = next(volumes).unit if is_volume else 1.0
        gains.append(lamp.strength * length * (here / there.pop()) ** 2)
    return np.array(gains)


def _pieces_of(scene: Scene, source: Source) -> tuple[Shape, ...]:
    """Return the pieces of a source, each in one medium: a volume is one piece."""
    shape = scene.shape_of(source)
    return (shape,) if source.emission.fills_volume else shape.pieces()


def _refractive_index(medium: np.ndarray | None, source: Source) -> float:
    """Return the refractive index that a source emits into; 1 where the scene has one index only."""
    if medium is None:
        return 1.0
    if medium["index"] == 0:
        raise SceneError(
            f"Source: the refractive index around it is unknown, got {short_repr(source.shape)}; name the"
            " media of surfaces, or move the source, for estimator='backward'"
        )
    return float(medium["index"])


def _cells_of(plan: Plan, sensor: Sensor, emitter: Emitter) -> tuple[dict, Passes]:
    """Return a detector's columns, and the passes that sample and weigh within a cell."""
    shape = emitter.shape
    columns = layout.center_columns(plan.space.place(shape.middle)) | {"side": 1.0, "handed": 1.0}
    columns |= {f"{axis}_cells": 1 for axis in ("mu", "turn", "u", "v")}
    match sensor:
        case Camera():
            return columns | _camera_columns(plan, sensor), LENS_PASSES[sensor.lens]
        case EnvironmentMap():
            return columns | _map_columns(plan, sensor), MAP_PASSES[sensor.projection]
        case LightField():
            passes = "start_on_rectangle", "direction_to_plane", "weigh_lens"
            return columns | _light_field_columns(plan, sensor), passes
        case PointDetector():
            return columns, (None, None, None)
    # Sample places within position bins, and directions within direction bins, where the detector has any.
    place, direction, weigh = None, None, None
    whole = plan.scene.shape_of(emitter.source)
    columns |= layout.frame_columns((whole if whole.is_flat else shape).frame)
    if emitter.source.is_back:
        columns |= {"side": -1.0, "handed": -1.0 if shape.is_flat else 1.0}
    if sensor.positions is not None:
        columns |= _position_columns(plan, sensor, shape)
        place = PLACE_PASSES.get(type(shape), "start_on_sphere")
    over = "plane" if shape.is_flat else "surface"
    directions = sensor.directions
    if isinstance(directions, DirectionCone):
        columns |= layout.vector_columns("axis_", directions.axis)
        columns |= {"spread": 2 * math.sin(directions.half_angle / 2) ** 2}
        direction, weigh = "direction_in_cone", f"weigh_by_{over}"
    elif directions is not None and directions.frame == "world":
        columns |= _uniform_columns(plan, directions.edges())
        direction, weigh = "uniform_direction", f"weigh_by_{over}"
    elif directions is not None:
        columns |= _hemisphere_columns(plan, directions.edges())
        direction = f"cosine_law_from_{over}"
    return columns, (place, direction, weigh)


def _camera_columns(plan: Plan, camera: Camera) -> dict[str, float]:
    """Return columns of a camera's pixels: rows as turns, columns as cosines; e_u points right.

    Of an orthographic camera they are places: rows as u and columns as v.
    """
    left, up, forward = camera.frame
    right, edges, size = tuple(-x for x in left), camera.edges(), plan.space.size
    if camera.lens == ORTHOGRAPHIC:
        columns = layout.frame_columns((up, right, forward))
        return (
            columns | edge_columns(plan, "u", edges["v"] / size) | edge_columns(plan, "v", edges["u"] / size)
        )
    columns = layout.frame_columns((right, up, forward)) | _image_columns(plan, edges["v"], edges["u"])
    if camera.lens in RADIUS_OF_ALL:
        columns |= {"rim": RADIUS_OF_ALL[camera.lens]}
    if camera.lens == THIN_LENS:
        radii, turns = np.array([0.0, (camera.aperture / 2 / size) ** 2]), np.array([0.0, 1.0])
        columns |= edge_columns(plan, "u", radii) | edge_columns(plan, "v", turns)
        columns |= {"nearness": camera.nearness * size, "power": size / camera.focal_length}
    return columns


def _image_columns(plan: Plan, rows: np.ndarray, columns: np.ndarray) -> dict[str, float]:
    """Return columns of the pixels between these edges."""
    return edge_columns(plan, "turn", rows) | edge_columns(plan, "mu", columns)


def _map_columns(plan: Plan, view: EnvironmentMap) -> dict[str, float]:
    """Return columns of the bins or pixels of a map; the faces of a cube are u."""
    edges = view.edges()
    if view.projection_of_image is None:
        return _uniform_columns(plan, edges)
    columns = _image_columns(plan, edges["v"], edges["u"])
    if view.projection == CUBE:
        return columns | {"u_cells": len(FACES)}
    columns |= {"rim": RADIUS_OF_ALL[view.projection_of_image]}
    return columns | layout.frame_columns(tuple(map(tuple, IMAGE_FRAMES[view.projection])))


def _light_field_columns(plan: Plan, field: LightField) -> dict[str, float]:
    """Return columns of the cells of a light field: v and u of the near plane, t and s of the far one."""
    left, up, forward = field.frame
    edges, size = field.edges(), plan.space.size
    columns = layout.frame_columns((tuple(-x for x in left), up, forward))
    columns |= edge_columns(plan, "u", edges["u"] / size) | edge_columns(plan, "v", edges["v"] / size)
    columns |= _image_columns(plan, edges["t"] / field.distance, edges["s"] / field.distance)
    return columns | {"nearness": size / field.distance}


def _uniform_columns(plan: Plan, edges: dict[str, np.ndarray]) -> dict[str, float]:
    """Return columns of bins over all directions, by the cosine to +z."""
    cosines = np.cos(edges["theta"])[::-1] if "theta" in edges else edges.get("mu", np.array([-1.0, 1.0]))
    return edge_columns(plan, "mu", cosines) | _azimuth_columns(plan, edges)


def _hemisphere_columns(plan: Plan, edges: dict[str, np.ndarray]) -> dict[str, float]:
    """Return columns of hemisphere bins by squared cosine and squared sine, so that neither cancels."""
    if "theta" in edges:
        theta = edges["theta"][::-1]
        squares, rest = np.cos(theta) ** 2, np.sin(theta) ** 2
        squares = np.where(squares < 1e-32, 0.0, squares)
    else:
        mu = edges.get("mu", np.array([0.0, 1.0]))
        squares, rest = mu * mu, (1 - mu) * (1 + mu)
    sines = edge_columns(plan, "sine", rest)
    return (
        edge_columns(plan, "mu", squares)
        | {"sine_edges": sines["sine_edges"]}
        | _azimuth_columns(plan, edges)
    )


def _azimuth_columns(plan: Plan, edges: dict[str, np.ndarray]) -> dict[str, float]:
    """Return columns of azimuth bins, in turns."""
    return edge_columns(plan, "turn", edges.get("phi", np.array([0.0, 2 * math.pi])) / (2 * math.pi))


def _position_columns(plan: Plan, detector: Detector, shape: Shape) -> dict[str, float]:
    """Return columns of position bins in coordinates uniform over the area.

    These are lengths, squared radii, cosines and turns.
    """
    size, edges = plan.space.size, detector.positions.edges(shape)
    match shape:
        case Rectangle():
            u, v = (
                edges.get(name, np.array([-0.5, 0.5]) * side) / size
                for name, side in (("u", shape.width), ("v", shape.height))
            )
        case Disk():
            u = (edges.get("u", np.array([shape.inner_radius, shape.radius])) / size) ** 2
        case _:
            u = np.cos(edges["u"]) if "u" in edges else np.array([shape.mu_max, shape.mu_min])
    if not isinstance(shape, Rectangle):
        v = edges.get("v", np.array([0.0, 2 * math.pi])) / (2 * math.pi)
    columns = edge_columns(plan, "u", u) | edge_columns(plan, "v", v)
    return columns | {"radius": getattr(shape, "radius", 0.0) / size}
