"""Rows of detectors on sheets: how the engine finds the bin of a crossing."""

import math

import numpy as np

from transport.compile import layout
from transport.compile.plan import Plan
from transport.geometry.flat import Disk, Rectangle
from transport.geometry.shape import Shape
from transport.geometry.solid import Sphere
from transport.scene.bins import DirectionCone
from transport.scene.detectors import Detector
from transport.scene.emissions import Emission
from transport.scene.phase_space import PhaseSpace
from transport.scene.sheets import SheetMember
from transport.vectors import Vector

# Kind of coordinates, and which of them are lengths; the others are heights on surfaces of revolution.
POSITION_KINDS = {
    Rectangle: (layout.RECTANGLE_PLACE, ("u", "v")),
    Disk: (layout.DISK_PLACE, ("u",)),
    Sphere: (layout.SPHERE_PLACE, ()),
}


def bin_counts(detector: Detector, shape: Shape, duration: float | None) -> dict[str, int]:
    """Return the number of bins per axis, in memory order: time, speed, u, v, azimuth, cosine (fastest).

    Each time and speed has a block of rows: one row outside all other bins, then those bins.
    """
    outer = {"time": detector.time_edges(duration), "speed": detector.speed_edges()}
    edges = {} if detector.positions is None else detector.positions.edges(shape)
    directions = {} if detector.directions is None else detector.directions.edges()
    cosine = directions.get("mu", directions.get("theta"))
    axes = outer | {"u": edges.get("u"), "v": edges.get("v"), "turn": directions.get("phi"), "mu": cosine}
    return {name: 1 if e is None else len(e) - 1 for name, e in axes.items()}


def block_rows(counts: dict[str, int]) -> int:
    """Return the rows of one time and speed: one outside all other bins, then those bins."""
    return 1 + math.prod(counts[name] for name in ("u", "v", "turn", "mu"))


def has_blocks(detector: Detector) -> bool:
    """Return whether there are blocks of times or speeds, and so one more row outside all of them."""
    return detector.times is not None or detector.speeds is not None


def layer_row(plan: Plan, member: SheetMember, detector: Detector, number: int) -> np.ndarray:
    """Return the row by which a lane finds the detector on a sheet, at the first block of its rows."""
    base = plan.bases[detector.name] + has_blocks(detector)
    word = (
        layout.DETECTOR_PRESENT | base | (uniform_cosine_bins(detector) or 1) << layout.DETECTOR_CELLS_SHIFT
    )
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
    shape, scene_shape = member.shape, plan.scene.shape_of(detector)
    back = -1.0 if detector.is_back else 1.0
    e_u, e_v, normal = shape.frame
    values = layout.center_columns(
        plan.space.place(shape.middle if shape.triangles else shape.center)
    ) | layout.frame_columns((e_u, e_v, normal))
    values |= {"side": member.orientation * back, "handed": 1.0}
    if not shape.is_flat:
        values |= dict(zip(("axis_x", "axis_y", "axis_z"), normal, strict=True))
    elif detector.is_back:  # Seen from behind, e_u changes sign, which keeps the frame right-handed.
        values |= {"eux": -e_u[0], "euy": -e_u[1], "euz": -e_u[2], "handed": -1.0}
    # Lay out the axes in memory, the cosine fastest.
    counts = bin_counts(detector, scene_shape, plan.scene.duration)
    values |= _block_axes(plan, detector, counts) | _filters(plan, detector)
    strides = dict(
        zip(("mu", "turn", "v", "u"), np.cumprod([1, counts["mu"], counts["turn"], counts["v"]]), strict=True)
    )
    values |= _direction_axes(plan, detector, shape, strides)
    if detector.positions is not None:
        values |= _position_axes(plan, detector, shape, strides)
    return layout.row(layout.DETECTOR, **values)


def _block_axes(plan: Plan, detector: Detector, counts: dict[str, int]) -> dict[str, float]:
    """Return the columns of times and speeds, each bin of which is a block of rows."""
    block, values = block_rows(counts), {"outside": plan.bases[detector.name]}
    times, speeds = detector.time_edges(plan.scene.duration), detector.speed_edges()
    if times is not None:
        plan.axes.add("time")
        values |= axis_columns(plan, "time", times / plan.time_unit, counts["speed"] * block)
    if speeds is not None:
        plan.axes.add("speed")
        values |= axis_columns(plan, "speed", speeds / plan.speed_unit, block)
    return values


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


def _direction_axes(
    plan: Plan, detector: Detector, shape: Shape, strides: dict[str, int]
) -> dict[str, float]:
    """Return the columns of the cosine and azimuth axes."""
    directions, values = detector.directions, {}
    if directions is None:
        return values
    if isinstance(directions, DirectionCone):
        plan.axes.add("cosine")
        values |= dict(zip(("axis_x", "axis_y", "axis_z"), directions.axis, strict=True))
        edges = np.array([-(math.sin(directions.half_angle) ** 2), 1.0])
        return values | {"mu_kind": layout.CONE} | axis_columns(plan, "mu", edges, strides["mu"])
    edges = directions.edges()
    is_world = directions.frame == "world"
    if uniform_cosine_bins(detector) is None and ("mu" in edges or "theta" in edges):
        plan.axes.add("cosine")
        bounds = edges["mu"] if "mu" in edges else np.cos(edges["theta"])[::-1]
        if "theta" in edges:
            bounds = np.where(np.abs(bounds) < 1e-16, 0.0, bounds)
        values |= {"mu_kind": layout.WORLD_COSINE if is_world else layout.LOCAL_COSINE}
        values |= axis_columns(plan, "mu", bounds, strides["mu"])
    if "phi" in edges:
        plan.axes.add("azimuth")
        local = layout.FLAT_AZIMUTH if shape.is_flat else layout.SPHERE_AZIMUTH
        kind = layout.WORLD_AZIMUTH if is_world else local
        values |= {"turn_kind": kind, "turn_low": edges["phi"][0]}
        values |= axis_columns(plan, "turn", edges["phi"], strides["turn"])
    return values


def _position_axes(plan: Plan, detector: Detector, shape: Shape, strides: dict[str, int]) -> dict[str, float]:
    """Return the columns of the axes u and v."""
    plan.axes.add("place")
    place, lengths = POSITION_KINDS.get(type(shape), (layout.REVOLVED_PLACE, ("u",)))
    values, size = {"place": place}, plan.space.size
    for name in ("u", "v"):
        bounds = detector.positions.edges(shape).get(name)
        if bounds is None:
            bounds = np.array([-math.inf, math.inf])
        values |= axis_columns(plan, name, bounds / size if name in lengths else bounds, strides[name])
    return values


def axis_columns(plan: Plan, name: str, edges: np.ndarray, stride: int) -> dict[str, float]:
    """Return the columns of one axis; the plan keeps its edges alive."""
    edges = np.ascontiguousarray(edges, np.float64)
    plan.kept.append(edges)
    return {f"{name}_cells": len(edges) - 1, f"{name}_edges": edges.ctypes.data, f"{name}_stride": stride}


# ---- Rows of phase spaces and snapshots: their times, coordinates and bins.


def fill_phase_spaces(plan: Plan) -> None:
    """Fill a row per time of each PhaseSpace; its sums and moments follow the detectors'."""
    for phase_space in plan.scene.phase_spaces:
        plan.bases[phase_space.name] = plan.rows
        if phase_space.moments:
            plan.first_long_rows[phase_space.name] = plan.long_rows
        for time in phase_space.times:
            row = _phase_space_row(plan, phase_space, time)
            if phase_space.moments:
                plan.long_rows += len(layout.VELOCITY_SUMS) * (1 + count_bins(phase_space))
            plan.phase_spaces.append(row)


def fill_snapshots(plan: Plan) -> None:
    """Fill a row per Snapshot, in order."""
    for number, snapshot in enumerate(plan.scene.snapshots):
        plan.snapshots.append(
            layout.row(layout.SNAPSHOT, time=min(snapshot.time / plan.time_unit, 1.0), number=number)
        )


def count_bins(phase_space: PhaseSpace) -> int:
    """Return the number of bins at one time."""
    return math.prod(len(edges) - 1 for edges in phase_space.axes.values())


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


def _phase_space_row(plan: Plan, phase_space: PhaseSpace, time: float) -> np.ndarray:
    """Return the row (layout.PHASE) of a PhaseSpace at one time: box, reference velocity, bins."""
    size, speed = plan.space.size, plan.speed_unit
    values = {
        "time": min(time / plan.time_unit, 1.0),
        "first": plan.rows,
        "fastest": max_relative_speed(plan) / speed or 1.0,
        **dict(zip(("vx", "vy", "vz"), (v / speed for v in reference_velocity(plan)), strict=True)),
        "moments": -1,
    }
    if phase_space.moments:
        values["moments"] = plan.long_rows
    low, high = (
        ((-math.inf,) * 3, (math.inf,) * 3) if phase_space.within is None else phase_space.within.bounds
    )
    for k, axis in enumerate("xyz"):
        origin = plan.space.origin[k]
        values |= {f"low_{axis}": (low[k] - origin) / size, f"high_{axis}": (high[k] - origin) / size}
    strides = (len(list(phase_space.axes.values())[-1]) - 1, 1) if len(phase_space.axes) == 2 else (1, 1)
    for name, stride, (coordinate, edges) in zip("ab", strides, phase_space.axes.items(), strict=False):
        values[f"{name}_kind"] = layout.COORDINATES.index(coordinate) + 1
        if coordinate in ("x", "y", "z"):
            edges = (edges - plan.space.origin["xyz".index(coordinate)]) / size
        elif coordinate != "mu":
            edges = edges / speed
        values |= axis_columns(plan, name, edges, stride)
    return layout.row(layout.PHASE, **values)
