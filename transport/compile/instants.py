"""Rows of phase spaces and snapshots: their times, coordinates and bins."""

import math

import numpy as np

from transport.compile import layout
from transport.compile.looks import axis_columns
from transport.compile.plan import Plan
from transport.emissions import Emission
from transport.phase_space import PhaseSpace
from transport.vectors import Vector


def fill_phase_spaces(plan: Plan) -> None:
    """Fill a row per time of each PhaseSpace; its sums and moments follow the detectors'."""
    for phase_space in plan.scene.phase_spaces:
        plan.bases[phase_space.name] = plan.rows
        if phase_space.moments:
            plan.long_bases[phase_space.name] = plan.long_rows
        for time in phase_space.times:
            row = _row(plan, phase_space, time)
            if phase_space.moments:
                plan.long_rows += len(layout.VELOCITY_SUMS) * (1 + bins_of(phase_space))
            plan.phase_spaces.append(row)


def fill_snapshots(plan: Plan) -> None:
    """Fill a row per Snapshot, in order."""
    for number, snapshot in enumerate(plan.scene.snapshots):
        plan.snapshots.append(
            layout.row(layout.SNAPSHOT, time=min(snapshot.time / plan.tempo, 1.0), number=number)
        )


def bins_of(phase_space: PhaseSpace) -> int:
    """Return the number of bins at one time."""
    return math.prod(len(edges) - 1 for edges in phase_space.axes.values())


def reference_velocity(plan: Plan) -> Vector:
    """Return the mean velocity of the sources [m/s]: moments about it do not cancel."""
    total = math.fsum(emitter.amount for emitter in plan.emitters)
    means = [(emitter.amount / total, _common_velocity(emitter.source.emission)) for emitter in plan.emitters]
    return tuple(math.fsum(share * velocity[k] for share, velocity in means) for k in range(3))


def fastest_about(plan: Plan) -> float:
    """Return an upper bound of all speeds relative to the reference velocity [m/s]."""
    return plan.fastest + math.hypot(*reference_velocity(plan))


def _common_velocity(emission: Emission) -> Vector:
    """Return the drift of an emission, or the velocity of a stream of one speed [m/s]."""
    direction, speed = getattr(emission, "direction", None), emission.speed
    if direction is not None and isinstance(speed, float):
        return tuple(speed * u for u in direction)
    return getattr(speed, "drift", (0.0, 0.0, 0.0))


def _row(plan: Plan, phase_space: PhaseSpace, time: float) -> np.ndarray:
    """Return the row (layout.PHASE) of a PhaseSpace at one time: box, reference velocity, bins."""
    size, speed = plan.space.size, plan.speed_unit
    values = {
        "time": min(time / plan.tempo, 1.0),
        "first": plan.rows,
        "fastest": fastest_about(plan) / speed or 1.0,
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
