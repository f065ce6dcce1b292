"""A scene turned round for the estimator "backward": detectors emit, bin by bin, and sources are met (transport.estimators.backward).

What is run is an ordinary scene with an ordinary plan, but that each history is born in a cell, one of a sensor's bins
(engine/sensors.py), and that what it brings to a source is summed up by the cell that it was born in.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from transport.bins import DirectionCone
from transport.cameras import Camera, EnvironmentMap, Instrument
from transport.compile import layout
from transport.compile.emitters import medium_row
from transport.compile.expected import face_of
from transport.compile.looks import axis_columns
from transport.compile.media import glowing_sources
from transport.compile.plan import Emitter, Step
from transport.compile.sizes import LARGE
from transport.detectors import Detector
from transport.emissions import Isotropic, Lambertian
from transport.points import PointDetector
from transport.scene import Scene
from transport.shapes import Disk, FlatShape, Point, Rectangle, Shape
from transport.sheets import pieces
from transport.sources import Source
from transport.validation import SceneError, shown
from transport.volumes import VolumeDetector

if TYPE_CHECKING:
    from transport.compile.plan import Plan

Sensor = Detector | PointDetector | Instrument
Passes = tuple[str | None, str | None, str | None]  # that take a place, a direction and a weight
STARTS = {Disk: "start_on_disk", Rectangle: "start_on_rectangle"}
FINDS = {
    "look_from_plane": "find_hemisphere_direction",
    "look_from_surface": "find_hemisphere_direction",
    "look_evenly": "find_direction",
    "look_through_pixel": "find_direction",
}


@dataclass(frozen=True)
class Lamp:
    """A source, and the detector that takes its place in the scene that is run."""

    name: str
    source: Source
    seen_by: Detector | VolumeDetector
    strength: float  # its radiance [W m^-2 sr^-1], or of a volume its emission [W m^-3 sr^-1]


@dataclass(frozen=True)
class Part:
    """A piece of a sensor: its cells from `first` on, each of the same number of histories."""

    sensor: Sensor
    shape: Shape
    first: int
    cells: int
    share: float  # of all histories of a run
    # by lamp: what a sum of 1 over one history is [W m^-2 sr^-1], indices of refraction and all
    gains: np.ndarray


@dataclass(frozen=True)
class Turned:
    """What a plan knows of the scene that it stands for, and where its sums by cell lie.

    Rows from `first` on: of each cell the histories born in it, then for each lamp what they brought, then what rays did (slants: the number of strong ones).
    """

    scene: Scene
    lamps: tuple[Lamp, ...]
    parts: tuple[Part, ...]
    first: int
    cells: int
    scales: dict[int, float]  # of the lamps that rays are sent to: what their sums are too large by

    def parts_of(self, sensor: Sensor) -> list[Part]:
        """The pieces of a sensor."""
        return [part for part in self.parts if part.sensor is sensor]


def turned_scene(scene: Scene) -> tuple[Scene, tuple[Lamp, ...]]:
    """The scene to run, and the lamps that its detectors stand for, in their order."""
    lamps = [_lamp(scene, source, f"sources[{k}]") for k, source in enumerate(scene.sources)]
    lamps += [_lamp(scene, glow, f"glow[{k}]") for k, glow in enumerate(glowing_sources(scene))]
    sources = [_source(detector) for detector in scene.detectors]
    looks = [lamp.seen_by for lamp in lamps]
    turned = Scene(sources=sources, surfaces=scene.surfaces, detectors=looks, medium=scene.medium)
    return turned, tuple(lamps)


def _source(sensor: Sensor) -> Source:
    """What sends out the histories of a detector."""
    if isinstance(sensor, Detector):
        return Source(sensor.shape, Lambertian(power=1.0), side=sensor.side)
    return Source(Point(position=sensor.position), Isotropic(power=1.0))


def _lamp(scene: Scene, source: Source, place: str) -> Lamp:
    shape, label = scene.shape_of(source), f"lamp {place}"
    power = source.amount(shape, None)
    if isinstance(source.emission, Isotropic):
        return Lamp(place, source, VolumeDetector(shape, name=label), power / (4 * math.pi * shape.volume))
    name = source.shape if isinstance(source.shape, str) else place
    seen_by = Detector(source.shape, name=label, side=source.side)
    return Lamp(name, source, seen_by, power / (math.pi * shape.area))


def turn_back(plan: Plan, scene: Scene, lamps: tuple[Lamp, ...]) -> None:
    """Give the plan of a turned scene its cells, and the rows of its sums by cell."""
    parts, emitters, first = [], [], 0
    for sensor, source in zip(scene.detectors, plan.scene.sources, strict=True):
        mine = [emitter for emitter in plan.emitters if emitter.source is source]
        whole = math.fsum(emitter.amount for emitter in mine)
        for emitter in mine:
            share = emitter.amount / whole / len(scene.detectors)
            columns, (place, look, weigh) = _cells_of(plan, sensor, emitter)
            cells = math.prod(int(columns[f"{axis}_cells"]) for axis in ("mu", "turn", "u", "v"))
            gains = gains_of(plan, scene, lamps, emitter)
            parts.append(Part(sensor, emitter.shape, first, cells, share, gains))
            row = layout.row(layout.SENSOR, **columns, first=first, cells=cells, part=len(parts))
            emitters.append(_emitter(emitter, share, row, place, look, weigh))
            first += cells
    plan.emitters = emitters
    _fill_rows(plan, lamps, first)
    told = {each.detector.name: each.scale for each in plan.expectations}
    scales = {k: told[lamp.seen_by.name] for k, lamp in enumerate(lamps) if lamp.seen_by.name in told}
    plan.turned = Turned(scene, lamps, tuple(parts), plan.bases["cells"], first, scales)


def _emitter(
    emitter: Emitter, share: float, row: np.ndarray, place: str | None, look: str | None, weigh: str | None
) -> Emitter:
    """An emitter of a sensor: names of the passes that take a place, a direction or a weight in its cells, if any do."""
    steps: list[Step] = [("draw_cell", row)]
    if place is not None:
        steps += [("draw_place", layout.row(layout.NO_TABLE)), ("find_place", row)]
    if look is not None:
        steps += [("draw_direction", layout.row(layout.NO_TABLE))]
        steps += [(FINDS[look], row)] if look in FINDS else []
    return replace(
        emitter,
        amount=share,
        cells=tuple(steps),
        place=emitter.place if place is None else (place, row),
        law=emitter.law if look is None else (look, row),
        facing=None,
        target=None if weigh is None else ((weigh, row),),
    )


def _fill_rows(plan: Plan, lamps: tuple[Lamp, ...], cells: int) -> None:
    """Where sums by cell lie: behind all others."""
    plan.bases["cells"] = first = plan.rows
    plan.cell_rows = (1 + len(lamps) * (2 if plan.expectations else 1)) * cells
    plan.axes.add("cell")
    volumes = iter(plan.volumes)
    for number, lamp in enumerate(lamps, start=1):
        if isinstance(lamp.seen_by, VolumeDetector):
            next(volumes).row["first"] = first + number * cells
        else:
            of_lamp = [name == lamp.seen_by.name for name in plan.meter_names]
            plan.meters["by_cell"][of_lamp] = first + number * cells
            plan.meters["of_rays"][of_lamp] = first + (number + len(lamps)) * cells
            for each in plan.expectations:
                if each.detector.name == lamp.seen_by.name:
                    strongest = each.strongest[face_of(lamp.seen_by)]
                    plan.meters["strong"][of_lamp] = LARGE * strongest * each.scale
    for (
        each
    ) in plan.expectations:  # a birth looks into its own bin, of which rays to all sides could not tell
        each.births[:] = [None] * len(plan.emitters)
    for emitter in plan.emitters:
        emitter.cells[0][1]["births"] = first


def gains_of(plan: Plan, scene: Scene, lamps: tuple[Lamp, ...], emitter: Emitter) -> np.ndarray:
    """By lamp, its strength times (eta_d/eta_s)^2, and of a volume the length that its sums count in [m]."""
    here, volumes, gains = _index(emitter.medium, emitter.source), iter(plan.volumes), []
    for lamp in lamps:
        sides = [medium_row(scene, lamp.source, piece) for piece in _pieces_of(scene, lamp.source)]
        there = {_index(side, lamp.source) for side in sides}
        if len(there) > 1:
            raise SceneError(
                f"Source: it emits into several media, got {shown(lamp.source.shape)}; divide it to run backwards"
            )
        is_volume = isinstance(lamp.seen_by, VolumeDetector)
        length = next(volumes).unit if is_volume else 1.0
        gains.append(lamp.strength * length * (here / there.pop()) ** 2)
    return np.array(gains)


def _pieces_of(scene: Scene, source: Source) -> tuple[Shape, ...]:
    shape = scene.shape_of(source)
    return (shape,) if isinstance(source.emission, Isotropic) else pieces(shape)


def _index(medium: np.ndarray | None, source: Source) -> float:
    """The refractive index that a source emits into; 1 where all are alike."""
    if medium is None:
        return 1.0
    if medium["index"] == 0:
        raise SceneError(
            f"Source: the index of refraction about it is not known, got {shown(source.shape)}; name the media of"
            " surfaces, or move it, to run backwards"
        )
    return float(medium["index"])


def _cells_of(plan: Plan, sensor: Sensor, emitter: Emitter) -> tuple[dict, Passes]:
    """Columns of a sensor's row, and the passes that draw a place and a direction in a cell and weigh it, if any do."""
    shape = emitter.shape
    columns = layout.center_columns(plan.space.place(shape.middle)) | {"side": 1.0, "handed": 1.0}
    columns |= {f"{axis}_cells": 1 for axis in ("mu", "turn", "u", "v")}
    match sensor:
        case Camera():
            return columns | _camera(plan, sensor), (None, "look_through_pixel", "weigh_pixel")
        case EnvironmentMap():
            return columns | _even(plan, sensor.edges()), (None, "look_evenly", None)
        case PointDetector():
            return columns, (None, None, None)
    place, look, weigh = None, None, None
    columns |= layout.frame_columns(shape.frame)
    if emitter.source.is_back:
        columns |= {"side": -1.0, "handed": -1.0 if isinstance(shape, FlatShape) else 1.0}
    if sensor.positions is not None:
        columns |= _places(plan, sensor, shape)
        place = STARTS.get(type(shape), "start_on_sphere")
    over = "plane" if isinstance(shape, FlatShape) else "surface"
    directions = sensor.directions
    if isinstance(directions, DirectionCone):
        columns |= dict(zip(("axis_x", "axis_y", "axis_z"), directions.axis, strict=True))
        columns |= {"spread": 2 * math.sin(directions.half_angle / 2) ** 2}
        look, weigh = "look_into_cone", f"weigh_by_{over}"
    elif directions is not None and directions.frame == "world":
        columns |= _even(plan, directions.edges())
        look, weigh = "look_evenly", f"weigh_by_{over}"
    elif directions is not None:
        columns |= _local(plan, directions.edges())
        look = f"look_from_{over}"
    return columns, (place, look, weigh)


def _camera(plan: Plan, camera: Camera) -> dict[str, float]:
    """Rows of pixels as turns, columns as cosines; e_u of the frame is to the right."""
    left, up, forward = camera.frame
    edges = camera.edges()
    columns = layout.frame_columns((tuple(-x for x in left), up, forward))
    return columns | axis_columns(plan, "turn", edges["v"], 0) | axis_columns(plan, "mu", edges["u"], 0)


def _even(plan: Plan, edges: dict[str, np.ndarray]) -> dict[str, float]:
    """Bins of all directions, by the cosine to +z."""
    cosines = np.cos(edges["theta"])[::-1] if "theta" in edges else edges.get("mu", np.array([-1.0, 1.0]))
    return axis_columns(plan, "mu", cosines, 0) | _turns(plan, edges)


def _local(plan: Plan, edges: dict[str, np.ndarray]) -> dict[str, float]:
    """Bins over the hemisphere: edges of the squared cosine, and of the squared sine, so that neither cancels."""
    if "theta" in edges:
        theta = edges["theta"][::-1]
        squares, rest = np.cos(theta) ** 2, np.sin(theta) ** 2
        squares = np.where(squares < 1e-32, 0.0, squares)
    else:
        mu = edges.get("mu", np.array([0.0, 1.0]))
        squares, rest = mu * mu, (1 - mu) * (1 + mu)
    sines = axis_columns(plan, "sine", rest, 0)
    return axis_columns(plan, "mu", squares, 0) | {"sine_edges": sines["sine_edges"]} | _turns(plan, edges)


def _turns(plan: Plan, edges: dict[str, np.ndarray]) -> dict[str, float]:
    return axis_columns(plan, "turn", edges.get("phi", np.array([0.0, 2 * math.pi])) / (2 * math.pi), 0)


def _places(plan: Plan, detector: Detector, shape: Shape) -> dict[str, float]:
    """Bins of position by what is even over the area: lengths, squared radii, cosines, turns."""
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
    columns = axis_columns(plan, "u", u, 0) | axis_columns(plan, "v", v, 0)
    return columns | {"radius": getattr(shape, "radius", 0.0) / size}
