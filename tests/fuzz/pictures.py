"""Random looks at an instant: densities over phase space, and samples of what flies."""

from __future__ import annotations

from hypothesis import strategies as st

import transport as tp
from transport.vectors import Vector

ALL = 10_000  # more than the histories of any world
FAST = 1e9  # m/s, beyond all speeds
THERMAL = 500.0  # m/s


@st.composite
def pictures(draw, middle: Vector, duration: float, name: str, light: bool) -> tp.PhaseSpace | tp.Snapshot:
    """A density or a sample, at both ends of the clock or between."""
    instants = [0.0, duration / 3, 0.8 * duration, duration]
    if draw(st.booleans()):
        return tp.Snapshot(draw(st.sampled_from(instants)), draw(st.sampled_from([1, 100, ALL])), name)
    bins = draw(st.sampled_from(axes_about(middle, light)))
    within = draw(st.sampled_from([None, tp.Box(center=middle, size=(1.5, 0.9, 1.2))]))
    time = draw(st.sampled_from([*instants, tuple(instants), (duration / 3,)]))
    return tp.PhaseSpace(**bins, time=time, name=name, within=within, moments=draw(st.booleans()))


def axes_about(middle: Vector, light: bool) -> list[dict]:
    """Bins of place about the middle, of velocity, of speed and of direction, one or two of them."""
    fast = tp.speed_of_light if light else THERMAL
    x, y, z = (tuple(m + edge for edge in (-1.0, -0.3, 0.1, 1.0)) for m in middle)
    speeds = (-fast, -0.5 * fast, 0.0, fast)
    return [
        {"x": x},
        {"y": y, "mu": 4},
        {"z": z, "vx": speeds},
        {"vy": speeds, "vz": speeds},
        {"speed": (0.0, 0.9 * fast, FAST)},
        {"mu": (-1.0, -0.5, 0.9), "speed": (0.0, FAST)},
    ]
