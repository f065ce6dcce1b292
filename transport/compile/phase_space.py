"""Lower phase spaces and snapshots: their rows of sums, times, coordinates and bins."""

import math

import numpy as np

from transport.compile import layout
from transport.compile.detectors import axis_columns
from transport.compile.plan import Plan
from transport.compile.rows import Rows
from transport.scene.emissions import Emission
from transport.scene.phase_space import COORDINATES, PhaseSpace
from transport.statistics.axes import PHASE, Axis
from transport.vectors import Vector


def lower_phase_spaces(plan: Plan) -> None:
    """Give each PhaseSpace its rows of sums, and fill a row of its table per time."""
    for phase_space in plan.scene.phase_spaces:
        rows = plan.add_rows(phase_space.name, phase_space_rows(phase_space, plan.rows))
        if phase_space.moments:
            plan.first_long_rows[phase_space.name] = plan.long_rows
            plan.long_rows += len(layout.VELOCITY_SUMS) * rows.count
        plan.phase_spaces += [_row(plan, phase_space, number) for number in range(len(phase_space.times))]


def lower_snapshots(plan: Plan) -> None:
    """Fill a row per Snapshot, in order."""
    for number, snapshot in enumerate(plan.scene.snapshots):
        time = min(snapshot.time / plan.time_unit, 1.0)
        plan.snapshots.append(layout.row(layout.SNAPSHOT, time=time, number=number))


def phase_space_rows(phase_space: PhaseSpace, first: int) -> Rows:
    """Return the rows of a phase space: a block per time."""
    times = (Axis("time", np.array(phase_space.times), is_instants=True),) if phase_space.is_series else ()
    bins = tuple(Axis(name, edges, group=PHASE) for name, edges in phase_space.axes.items())
    return Rows(first, times, bins, 1 + math.prod(map(len, bins)))


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


def _row(plan: Plan, phase_space: PhaseSpace, number: int) -> np.ndarray:
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
