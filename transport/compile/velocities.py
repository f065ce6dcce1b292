"""Time and speed of births: the passes, with the rows of their tables."""

from __future__ import annotations

import math
from functools import lru_cache

from transport.compile import layout
from transport.compile.plan import Plan, Step
from transport.compile.quantile_tables import has_steps, quantile_columns, quantile_row
from transport.pulses import BoxPulse, GaussianPulse, Instant
from transport.shapes import Shape
from transport.sources import Effusive, Gas, Source
from transport.speeds import Maxwellian
from transport.validation import refuse
from transport.vectors import dot

AT_REST = (0.0, 0.0, 0.0)


def moment_of(source: Source, duration: float | None) -> Step | None:
    """Return the pass and row of the time of birth [durations]; None without a clock."""
    if duration is None:
        return None
    match source.pulse:
        case Instant(time=time):
            return "start_at", layout.row(layout.MOMENT, start=time / duration)
        case BoxPulse(start=start, stop=stop):
            return "start_within", layout.row(
                layout.MOMENT, start=start / duration, width=(stop - start) / duration
            )
        case GaussianPulse(time=time, sigma=sigma):
            return "start_about", layout.row(layout.MOMENT, start=time / duration, width=sigma / duration)
    if isinstance(source.emission, Gas):
        return "start_at", layout.row(layout.MOMENT, start=0.0)
    return "start_within", layout.row(layout.MOMENT, start=0.0, width=1.0)


def speed_of(plan: Plan, source: Source) -> tuple[Step, ...]:
    """Return the passes that sample the speed and add the drift, after the direction is sampled."""
    emission, nothing = source.emission, layout.row(layout.NO_TABLE)
    unit = plan.speed_unit
    if isinstance(emission.speed, float):
        speed = emission.speed / unit
        if not math.isfinite(speed):
            refuse(source, f"speed must cross the scene in a finite part of its duration, got {speed}")
        return (("take_speed", layout.row(layout.VELOCITY, vx=speed)),)
    drift = getattr(emission.speed, "drift", AT_REST)
    if isinstance(emission, Effusive):
        if drift != AT_REST:
            return ()  # the pass of drifting_law samples speed and direction together
        quantile = emission.speed.flux_quantile
    else:
        quantile = emission.speed.quantile if emission.direction is None else emission.speed.line_quantile
    take = "take_stepped_quantile" if has_steps(quantile) else "take_quantile"
    steps = [("draw_speed", nothing), (take, quantile_row(plan, quantile))]
    if drift != AT_REST or getattr(emission, "direction", None) is not None:
        steps.append(("add_drift", layout.row(layout.VELOCITY, **_velocity(drift, unit))))
    return tuple(steps)


def drifting_law(plan: Plan, source: Source, shape: Shape) -> Step | None:
    """Return the pass that samples velocities of a drifting gas effusing through a plane.

    None for all sources but an Effusive one with a drifting Maxwellian.
    """
    emission = source.emission
    if not isinstance(emission, Effusive) or getattr(emission.speed, "drift", AT_REST) == AT_REST:
        return None
    e_u, e_v, normal = shape.frame
    side, unit = -1.0 if source.is_back else 1.0, plan.speed_unit
    drift = emission.speed.drift
    values = layout.frame_columns((e_u, e_v, normal)) | {"side": side, "sigma": emission.speed.sigma / unit}
    values |= {"drift_u": dot(drift, e_u) / unit, "drift_v": dot(drift, e_v) / unit}
    values |= quantile_columns(plan, _normal_quantile(emission.speed, side * dot(drift, normal)))
    return "emit_from_drifting_gas", layout.row(layout.DRIFTING, **values)


@lru_cache(maxsize=64)
def _normal_quantile(speed: Maxwellian, drift: float):
    return lambda u: speed.normal_quantile(u, drift)


def _velocity(drift: tuple[float, float, float], unit: float) -> dict[str, float]:
    return {name: component / unit for name, component in zip(("vx", "vy", "vz"), drift, strict=True)}
