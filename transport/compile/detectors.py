"""Rows of detectors on sheets: how the engine finds the bin of a crossing."""

import math
from dataclasses import dataclass, replace

import numpy as np

from transport.compile import layout
from transport.compile.plan import Plan
from transport.compile.rows import Rows
from transport.geometry.flat import Disk, Rectangle
from transport.geometry.shape import Shape
from transport.geometry.solid import Sphere
from transport.scene.bins import DirectionCone
from transport.scene.bodies import scene_bodies, scene_media
from transport.scene.detectors import Detector
from transport.scene.emissions import Emission
from transport.scene.materials import AnyMedium
from transport.scene.phase_space import COORDINATES, PhaseSpace
from transport.scene.scene import Scene
from transport.scene.scene_speeds import scene_speeds
from transport.scene.sheets import SheetMember
from transport.statistics.axes import DIRECTION, POSITION, Axis
from transport.validation import SceneError, refuse, short_repr
from transport.vectors import Vector

# Kind of coordinates of a place; on any other shape they are those of a surface of revolution.
PLACE_KINDS = {
    Rectangle: layout.RECTANGLE_PLACE,
    Disk: layout.DISK_PLACE,
    Sphere: layout.SPHERE_PLACE,
}


def layer_row(plan: Plan, member: SheetMember, detector: Detector, number: int) -> np.ndarray:
    """Return the row by which a lane finds the detector on a sheet, at the first block of its rows."""
    first, cosines = plan.rows_of[detector.name].first, uniform_cosine_bins(detector) or 1
    word = layout.DETECTOR_PRESENT | first | cosines << layout.DETECTOR_CELLS_SHIFT
    if (member.orientation < 0) != detector.is_back:
        word |= layout.DETECTOR_BACK
    return layout.row(
        layout.LAYER, detector_word=word, detector=number, mark=plan.marks.get(detector.name, 0)
    )


def uniform_cosine_bins(detector: Detector) -> int | None:
    """Return the number of equal cosine bins over the hemisphere; None for other bins or none."""
    directions = detector.directions
    if directions is None or isinstance(directions, DirectionCone) or directions.frame != "local":
        return None
    return directions.mu if isinstance(directions.mu, int) else None


def detector_row(plan: Plan, member: SheetMember, detector: Detector) -> np.ndarray:
    """Return the row of a detector's finer axes, and record their kinds in `plan.axes`."""
    shape, rows = member.shape, plan.rows_of[detector.name]
    back = -1.0 if detector.is_back else 1.0
    e_u, e_v, normal = shape.frame
    values = layout.center_columns(
        plan.space.place(shape.middle if shape.triangles else shape.center)
    ) | layout.frame_columns((e_u, e_v, normal))
    values |= {"side": member.orientation * back, "handed": 1.0}
    if not shape.is_flat:
        values |= layout.vector_columns("axis_", normal)
    elif detector.is_back:  # Seen from behind, e_u changes sign, which keeps the frame right-handed.
        values |= {"eux": -e_u[0], "euy": -e_u[1], "euz": -e_u[2], "handed": -1.0}
    values |= {"outside": rows.base} | _filters(plan, detector)
    for axis in rows.outer:
        plan.axes.add(axis.name)
        values |= axis_columns(plan, axis, rows)
    for axis in rows.inner:
        values |= _direction_columns(plan, detector, shape, axis, rows) if axis.group == DIRECTION else {}
    if detector.positions is not None:
        values |= _position_columns(plan, shape, rows)
    return layout.row(layout.DETECTOR, **values)


def _filters(plan: Plan, detector: Detector) -> dict[str, float]:
    """Return the columns of conditions on visits and reflections, recorded in `plan.filters`."""
    values = {"most": np.iinfo(np.int64).max}
    if detector.via is not None:
        plan.filters.add("visits")
        values["via"] = sum({plan.marks[name] for name in detector.via})
    if detector.events is not None:
        plan.filters.add("reflections")
        least, most = detector.events
        values |= {"least": int(least), "most": int(min(most, np.iinfo(np.int32).max))}
    return values


def _direction_columns(
    plan: Plan, detector: Detector, shape: Shape, axis: Axis, rows: Rows
) -> dict[str, float]:
    """Return the columns of an axis of cosines or azimuths."""
    directions = detector.directions
    is_world = not isinstance(directions, DirectionCone) and directions.frame == "world"
    if axis.name == "phi":
        plan.axes.add("azimuth")
        local = layout.FLAT_AZIMUTH if shape.is_flat else layout.SPHERE_AZIMUTH
        kind = layout.WORLD_AZIMUTH if is_world else local
        return {"turn_kind": kind, "turn_low": axis.edges[0]} | axis_columns(plan, axis, rows)
    if uniform_cosine_bins(detector) is not None:
        return {}
    plan.axes.add("cosine")
    if isinstance(directions, DirectionCone):  # binned by minus the squared sine
        values = layout.vector_columns("axis_", directions.axis)
        edges = np.array([-(math.sin(directions.half_angle) ** 2), 1.0])
        return values | {"mu_kind": layout.CONE} | edge_columns(plan, "mu", edges, rows.strides[axis.name])
    kind = layout.WORLD_COSINE if is_world else layout.LOCAL_COSINE
    return {"mu_kind": kind} | axis_columns(plan, axis, rows)


def _position_columns(plan: Plan, shape: Shape, rows: Rows) -> dict[str, float]:
    """Return the columns of the axes u and v; one that is not binned is one bin."""
    plan.axes.add("place")
    values = {"place": PLACE_KINDS.get(type(shape), layout.REVOLVED_PLACE)}
    binned = {axis.name: axis for axis in rows.inner}
    places = [binned.get(name, Axis(name, np.array([-math.inf, math.inf]))) for name in ("u", "v")]
    others = [axis for axis in rows.inner if axis.group != POSITION]
    for axis in places:
        values |= axis_columns(plan, axis, replace(rows, inner=(*places, *others)))
    return values


def axis_columns(
    plan: Plan, axis: Axis, rows: Rows, prefix: str | None = None, origin: float = 0.0
) -> dict[str, float]:
    """Return the columns of an axis in the units of the plan: number of bins, edges, stride.

    prefix: of the columns, None for that of the coordinate;  origin: what a position is measured from [m].
    """
    if axis.coordinate.is_falling:  # polar angles rise as cosines fall
        edges = np.cos(axis.edges)[::-1]
        edges = np.where(np.abs(edges) < 1e-16, 0.0, edges)
    else:
        edges = (axis.edges - origin) / plan.units.get(axis.unit, 1.0)
    return edge_columns(plan, prefix or axis.coordinate.column, edges, rows.strides[axis.name])


def edge_columns(plan: Plan, prefix: str, edges: np.ndarray, stride: int = 0) -> dict[str, float]:
    """Return the columns of bins with these edges; the plan keeps the edges alive."""
    edges = np.ascontiguousarray(edges, np.float64)
    plan.kept.append(edges)
    return {
        f"{prefix}_cells": len(edges) - 1,
        f"{prefix}_edges": edges.ctypes.data,
        f"{prefix}_stride": stride,
    }


# ---- Long scores: what a detector sums beside weights, in rows of four limbs.


@dataclass(frozen=True, eq=False)
class LongScore:
    """A score of detectors besides weights and counts, and the passes that make it.

    sums: names of its sums, which lie next to each other for each row of a detector;  table: of all its
    passes, with columns `place` (its first sum among those of a row) and `each` (the number of all);
    at_birth, in_flight, at_crossing: passes that prepare a lane, follow a flight, and add to the sums;
    fields: lane fields that these passes address by number, not as attributes of the bundle.
    """

    sums: tuple[str, ...]
    table: np.ndarray
    at_crossing: str
    at_birth: str | None = None
    in_flight: str | None = None
    fields: tuple[str, ...] = ()


def fill_long_scores(plan: Plan) -> None:
    """Fill the long scores that detectors of the scene ask for, and their rows."""
    plan.long_scores = [score for make in (_moments, _paths) if (score := make(plan)) is not None]
    for score in plan.long_scores:
        score.table["place"] = plan.long_sums.index(score.sums[0])
        score.table["each"] = len(plan.long_sums)
    plan.long_rows = len(plan.long_sums) * 2 * plan.half


def _moments(plan: Plan) -> LongScore | None:
    """Return the velocity sums, relative to the extreme speeds of the scene."""
    if not any(detector.moments for detector in plan.scene.meters):
        return None
    slowest = min((v for v in scene_speeds(plan.scene) if isinstance(v, float) and v > 0), default=0.0)
    table = layout.row(
        layout.MOMENTS,
        fastest=plan.fastest / plan.speed_unit,
        slowest=slowest / plan.speed_unit,
        is_light=plan.scene.measured_in == "watts",
    )
    return LongScore(("momentum", "speed", "square"), table, "score_moments")


MAX_PATHS = 8  # media in which a scene's path lengths are kept, at most
# [scene lengths] of a path whose sum is 1: far above any path, so that no sum of paths overflows its limbs
PATH_UNIT = 2.0**24
# rows: for each row of MEDIA the number of its path, -1 for none;  media: number of paths
PATHS = np.dtype([(name, "i8") for name in ("rows", "count", "media", "place", "each")])


def path_media(scene: Scene) -> tuple[AnyMedium, ...]:
    """Return the media in which any detector of a scene asks for path lengths, each once."""
    return tuple(dict.fromkeys(medium for detector in scene.meters for medium in detector.path_lengths or ()))


def _paths(plan: Plan) -> LongScore | None:
    """Return the path lengths in each medium that a detector names."""
    media = path_media(plan.scene)
    if not media:
        return None
    known = scene_media(plan.scene)
    for detector in plan.scene.meters:
        for medium in detector.path_lengths or ():
            if medium not in known:
                must, cure = "must name media of the scene", f"it has {', '.join(map(short_repr, known))}"
                refuse(detector, f"path_lengths {must}, got {short_repr(medium)}; {cure}")
    if len(media) > MAX_PATHS:
        raise SceneError(
            f"Scene: the path_lengths of all detectors may name {MAX_PATHS} media at most, got {len(media)};"
            " use several scenes"
        )
    rows = (known[0], *(body.medium for body in scene_bodies(plan.scene)))
    numbers = np.array([media.index(medium) if medium in media else -1 for medium in rows], np.int64)
    plan.kept.append(numbers)
    table = layout.row(PATHS, rows=numbers.ctypes.data, count=len(numbers), media=len(media))
    names = tuple(f"path {number}" for number in range(len(media)))
    fields = tuple(f"path_{number}" for number in range(len(media)))
    return LongScore(names, table, "score_paths_by_medium", "reset_paths", "follow_paths", fields)


# ---- Rows of phase spaces and snapshots: their times, coordinates and bins.


def fill_phase_spaces(plan: Plan) -> None:
    """Fill a row per time of each PhaseSpace."""
    for phase_space in plan.scene.phase_spaces:
        for number in range(len(phase_space.times)):
            plan.phase_spaces.append(_phase_space_row(plan, phase_space, number))


def fill_snapshots(plan: Plan) -> None:
    """Fill a row per Snapshot, in order."""
    for number, snapshot in enumerate(plan.scene.snapshots):
        plan.snapshots.append(
            layout.row(layout.SNAPSHOT, time=min(snapshot.time / plan.time_unit, 1.0), number=number)
        )


def reference_velocity(plan: Plan) -> Vector:
    """Return the mean velocity of the sources [m/s]: moments about it do not cancel."""
    total = math.fsum(emitter.amount for emitter in plan.emitters)
    means = [(emitter.amount / total, _common_velocity(emitter.source.emission)) for emitter in plan.emitters]
    return tuple(math.fsum(share * velocity[k] for share, velocity in means) for k in range(3))


def max_relative_speed(plan: Plan) -> float:
    """Return an upper bound of all speeds relative to the reference velocity [m/s]."""
    return plan.fastest + math.hypot(*reference_velocity(plan))


def _common_velocity(emission: Emission) -> Vector:
    """Return the drift of an emission, or the velocity of a stream of one speed [m/s]."""
    direction, speed = getattr(emission, "direction", None), emission.speed
    if direction is not None and isinstance(speed, float):
        return tuple(speed * u for u in direction)
    return getattr(speed, "drift", (0.0, 0.0, 0.0))


def _phase_space_row(plan: Plan, phase_space: PhaseSpace, number: int) -> np.ndarray:
    """Return the row (layout.PHASE) of a PhaseSpace at its time of that number: box, velocity, bins."""
    size, speed, rows = plan.space.size, plan.speed_unit, plan.rows_of[phase_space.name]
    values = {
        "time": min(phase_space.times[number] / plan.time_unit, 1.0),
        "first": rows.first + number * rows.block,
        "fastest": max_relative_speed(plan) / speed or 1.0,
        **layout.vector_columns("v", (v / speed for v in reference_velocity(plan))),
        "moments": -1,
    }
    if phase_space.moments:
        earlier = len(layout.VELOCITY_SUMS) * number * rows.block
        values["moments"] = plan.first_long_rows[phase_space.name] + earlier
    low, high = (
        ((-math.inf,) * 3, (math.inf,) * 3) if phase_space.within is None else phase_space.within.bounds
    )
    for k, axis in enumerate("xyz"):
        origin = plan.space.origin[k]
        values |= {f"low_{axis}": (low[k] - origin) / size, f"high_{axis}": (high[k] - origin) / size}
    for prefix, axis in zip("ab", rows.inner, strict=False):
        values[f"{prefix}_kind"] = COORDINATES.index(axis.name) + 1
        origin = plan.space.origin["xyz".index(axis.name)] if axis.name in ("x", "y", "z") else 0.0
        values |= axis_columns(plan, axis, rows, prefix, origin)
    return layout.row(layout.PHASE, **values)
