"""What looks at all particles at a time: their density over coordinates of phase space, or a sample of them."""

import math
from collections.abc import Iterable

import numpy as np

from transport.bins import check_total, edges_of, settle_bins
from transport.fields import Converted, OptionalBins, OptionalNumbers
from transport.shapes import Box
from transport.sides import AnyDetector
from transport.validation import (
    as_float,
    as_floats,
    check_type,
    is_count,
    refuse,
    scene_object,
    settle_name,
    shown,
    store,
)

COORDINATES = {  # of phase space, in the order of the axes of what is measured: their units
    "x": "m", "y": "m", "z": "m", "vx": "m s^-1", "vy": "m s^-1", "vz": "m s^-1", "speed": "m s^-1", "mu": "1",
}  # fmt: skip
MOST_AXES = 2
MOST_PARTICLES = 10_000_000  # of a snapshot, which takes 64 bytes for each


class Timed(AnyDetector):
    """What PhaseSpace and Snapshot share: a name, and the times [s] at which they look; not made itself."""

    @property
    def times(self) -> tuple[float, ...]:
        """The times [s] at which it looks."""
        return self.time if isinstance(self.time, tuple) else (self.time,)

    def check_clock(self, duration: float | None) -> None:
        """Refuse a scene without a clock, and a look after its end."""
        if duration is None:
            cure = "write Scene(..., duration=...) in seconds"
            refuse(self, f"time needs a clock, got {shown(self.time)} in a scene without one; {cure}")
        if self.times[-1] > duration * (1 + 4e-16):  # so that 3 * 0.1 s is not after 0.3 s
            must = f"time must be within the scene's duration of {duration!r} s"
            refuse(self, f"{must}, got {self.times[-1]!r}; look earlier or prolong it")

    def _settle_name(self) -> None:
        settle_name(self)
        if self.name is None:
            refuse(self, "name must be a text, got None; leave it out or write name='cloud'")


@scene_object(kw_only=True)
class PhaseSpace(Timed):
    """Density of particles over one or two coordinates of phase space, at a `time` [s] or at several.

    Increasing edges of bins of position `x`, `y`, `z` [m], of velocity `vx`, `vy`, `vz` [m/s], of `speed` [m/s]
    or of `mu`, the cosine to +z (edges within [-1, 1], or a number of bins).  All particles that fly or rest then
    are looked at, or only those `within` a Box.  `moments` adds mean velocities, temperature and the like.
    """

    x: OptionalNumbers = None
    y: OptionalNumbers = None
    z: OptionalNumbers = None
    vx: OptionalNumbers = None
    vy: OptionalNumbers = None
    vz: OptionalNumbers = None
    speed: OptionalNumbers = None
    mu: OptionalBins = None
    time: Converted[float | Iterable[float], float | tuple[float, ...]]
    name: str = "phase_space"
    within: Box | None = None
    moments: bool = False

    def __post_init__(self) -> None:
        self._settle_name()
        self._settle_axes()
        self._settle_time()
        if self.within is not None:
            check_type(self, "within", Box, "a Box(center=..., size=...)")
        check_type(self, "moments", bool, "True or False")
        bins = {name: len(edges) - 1 for name, edges in self.axes.items()}
        times = {"time": len(self.times)} if self.is_series else {}
        check_total(self, bins | times, moments=7 if self.moments else 0)

    @property
    def axes(self) -> dict[str, np.ndarray]:
        """Edges [m, m/s or 1] of each coordinate that is binned, in the order of COORDINATES."""
        given = {name: getattr(self, name) for name in COORDINATES if getattr(self, name) is not None}
        return {
            name: edges_of(self, name, bins, -1.0, 1.0, "a cosine") if name == "mu" else np.array(bins)
            for name, bins in given.items()
        }

    @property
    def is_series(self) -> bool:
        """Whether it was given a sequence of times, be it of one, so that what it measures has a dim "time"."""
        return isinstance(self.time, tuple)

    def _settle_axes(self) -> None:
        given = [name for name in COORDINATES if getattr(self, name) is not None]
        if not 1 <= len(given) <= MOST_AXES:
            cure = "take a PhaseSpace for each pair" if given else "write x=edges, or x=edges and vx=edges"
            must = f"one or two of {', '.join(COORDINATES)} must be given"
            refuse(self, f"{must}, got {', '.join(given) or 'none'}; {cure}")
        for name in given:
            settle_bins(self, name, 0.0 if name == "speed" else -math.inf, may_count=name == "mu")

    def _settle_time(self) -> None:
        """A time, or a sequence of increasing times, none before 0."""
        time = as_float(self.time)
        times = as_floats(self.time if time is None else (time,))
        if not times or times[0] < 0 or any(p >= q for p, q in zip(times, times[1:], strict=False)):
            must = "time must be a time in seconds, 0 or later, or an increasing sequence of them"
            refuse(self, f"{must}, got {shown(self.time)}")
        store(self, time=times if time is None else time)


@scene_object
class Snapshot(Timed):
    """An unbiased sample of up to `particles` of the particles that fly or rest at a `time` [s]."""

    time: float
    particles: int = 100_000
    name: str = "snapshot"

    def __post_init__(self) -> None:
        self._settle_name()
        time = as_float(self.time)
        if time is None or not 0 <= time < math.inf:
            cure = "; make a Snapshot of each" if as_floats(self.time) else ""
            refuse(self, f"time must be one time in seconds, 0 or later, got {shown(self.time)}{cure}")
        particles = as_float(self.particles)
        is_whole = is_count(self.particles) or (particles is not None and particles.is_integer())
        if not is_whole or not 1 <= particles <= MOST_PARTICLES:
            must = f"particles must be a whole number from 1 to {MOST_PARTICLES}"
            refuse(self, f"{must}, got {shown(self.particles)}")
        store(self, time=time, particles=int(self.particles))
