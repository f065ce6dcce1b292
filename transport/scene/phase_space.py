"""Detectors of all particles at given times: their density in phase space, or a sample of them."""

import math
from collections.abc import Iterable

import numpy as np

from transport.geometry.solid import Box
from transport.scene.bins import check_bin_count, coerce_bins, edges_of
from transport.scene.sides import AnyDetector
from transport.validation import (
    Converted,
    OptionalBinsField,
    OptionalNumbersField,
    as_float,
    as_floats,
    check_type,
    coerce_name,
    is_whole_number,
    refuse,
    scene_object,
    set_fields,
    short_repr,
)

# Coordinates that a PhaseSpace bins, in the order of the axes of its results.
COORDINATES = ("x", "y", "z", "vx", "vy", "vz", "speed", "mu")
MAX_AXES = 2
MAX_SNAPSHOT_PARTICLES = 10_000_000  # per snapshot, at 64 bytes each


class TimedDetector(AnyDetector):
    """Base class of PhaseSpace and Snapshot: a name and times; not instantiated directly."""

    @property
    def times(self) -> tuple[float, ...]:
        """Times of observation.

        Returns
        -------
        tuple of float
            Times [s].
        """
        return self.time if isinstance(self.time, tuple) else (self.time,)

    def check_clock(self, duration: float | None) -> None:
        """Raise SceneError if the scene has no duration, or if a time is after its end."""
        if duration is None:
            cure = "write Scene(..., duration=...) in seconds"
            refuse(self, f"time needs a clock, got {short_repr(self.time)} in a scene without one; {cure}")
        if self.times[-1] > duration * (1 + 4e-16):  # 3 * 0.1 s is not after 0.3 s
            must = f"time must be within the scene's duration of {duration!r} s"
            refuse(self, f"{must}, got {self.times[-1]!r}; use an earlier time or a longer duration")

    def _coerce_name(self) -> None:
        coerce_name(self)
        if self.name is None:
            refuse(self, "name must be a text, got None; leave it out or write name='cloud'")


@scene_object(kw_only=True)
class PhaseSpace(TimedDetector):
    """Density of particles over one or two coordinates of phase space, at one or several times.

    Counts all particles in flight or at rest at these times. Needs a scene with a duration. All parameters
    are keywords; give one or two coordinates.

    Parameters
    ----------
    x, y, z : sequence of float, default None
        Increasing edges of bins of position [m].
    vx, vy, vz : sequence of float, default None
        Increasing edges of bins of velocity [m/s].
    speed : sequence of float, default None
        Increasing edges of bins of speed [m/s], zero or positive.
    mu : int or sequence of float, default None
        Bins of the cosine of the velocity to +z: number of equal bins, or edges within [-1, 1].
    time : float or sequence of float
        One time [s], or increasing times; a sequence adds the axis "time" to the result.
    name : str, default "phase_space"
        Key in the result.
    within : Box, default None
        Count only particles in this box.
    moments : bool, default False
        Whether to add moments of velocity, such as mean velocities and temperature.

    Raises
    ------
    SceneError
        If an argument is invalid, or if there are too many bins.

    Examples
    --------
    >>> import transport as tp
    >>> cloud = tp.PhaseSpace(x=(-1.0, 0.0, 1.0), time=(0.0, 0.1))
    >>> cloud.axes["x"]  # [m]
    array([-1.,  0.,  1.])
    >>> cloud.times  # [s]
    (0.0, 0.1)
    """

    x: OptionalNumbersField = None
    y: OptionalNumbersField = None
    z: OptionalNumbersField = None
    vx: OptionalNumbersField = None
    vy: OptionalNumbersField = None
    vz: OptionalNumbersField = None
    speed: OptionalNumbersField = None
    mu: OptionalBinsField = None
    time: Converted[float | Iterable[float], float | tuple[float, ...]]
    name: str = "phase_space"
    within: Box | None = None
    moments: bool = False

    def __post_init__(self) -> None:
        self._coerce_name()
        self._coerce_axes()
        self._coerce_time()
        if self.within is not None:
            check_type(self, "within", Box, "a Box(center=..., size=...)")
        check_type(self, "moments", bool, "True or False")
        bins = {name: len(edges) - 1 for name, edges in self.axes.items()}
        times = {"time": len(self.times)} if self.is_series else {}
        check_bin_count(self, bins | times, long_sums=7 if self.moments else 0)

    @property
    def axes(self) -> dict[str, np.ndarray]:
        """Edges of the binned coordinates.

        Returns
        -------
        dict of str to array
            Edges [m, m/s or 1], in the order x, y, z, vx, vy, vz, speed, mu.
        """
        given = {name: getattr(self, name) for name in COORDINATES if getattr(self, name) is not None}
        return {
            name: edges_of(self, name, bins, -1.0, 1.0, "a cosine") if name == "mu" else np.array(bins)
            for name, bins in given.items()
        }

    @property
    def is_series(self) -> bool:
        """Whether `time` is a sequence, so that results have the axis "time".

        Returns
        -------
        bool
        """
        return isinstance(self.time, tuple)

    def _coerce_axes(self) -> None:
        given = [name for name in COORDINATES if getattr(self, name) is not None]
        if not 1 <= len(given) <= MAX_AXES:
            cure = "use one PhaseSpace per pair" if given else "write x=edges, or x=edges and vx=edges"
            must = f"one or two of {', '.join(COORDINATES)} must be given"
            refuse(self, f"{must}, got {', '.join(given) or 'none'}; {cure}")
        for name in given:
            coerce_bins(self, name, 0.0 if name == "speed" else -math.inf, may_count=name == "mu")

    def _coerce_time(self) -> None:
        """Convert `time` to a float or a tuple of increasing floats, zero or positive."""
        time = as_float(self.time)
        times = as_floats(self.time if time is None else (time,))
        if not times or times[0] < 0 or any(p >= q for p, q in zip(times, times[1:], strict=False)):
            must = "time must be a time in seconds, 0 or later, or an increasing sequence of them"
            refuse(self, f"{must}, got {short_repr(self.time)}")
        set_fields(self, time=times if time is None else time)


@scene_object
class Snapshot(TimedDetector):
    """An unbiased sample of the particles in flight or at rest at one time.

    Needs a scene with a duration.

    Parameters
    ----------
    time : float
        Time [s], zero or positive.
    particles : int, default 100_000
        Largest number of particles in the sample, from 1 to 10 million.
    name : str, default "snapshot"
        Key in the result.

    Raises
    ------
    SceneError
        If an argument is invalid.

    Examples
    --------
    >>> import transport as tp
    >>> tp.Snapshot(0.1, particles=1e3)
    Snapshot(time=0.1, particles=1000, name='snapshot')
    """

    time: float
    particles: int = 100_000
    name: str = "snapshot"

    def __post_init__(self) -> None:
        self._coerce_name()
        time = as_float(self.time)
        if time is None or not 0 <= time < math.inf:
            cure = "; use one Snapshot per time" if as_floats(self.time) else ""
            refuse(self, f"time must be one time in seconds, 0 or later, got {short_repr(self.time)}{cure}")
        particles = as_float(self.particles)
        is_whole = is_whole_number(self.particles) or (particles is not None and particles.is_integer())
        if not is_whole or not 1 <= particles <= MAX_SNAPSHOT_PARTICLES:
            must = f"particles must be a whole number from 1 to {MAX_SNAPSHOT_PARTICLES}"
            refuse(self, f"{must}, got {short_repr(self.particles)}")
        set_fields(self, time=time, particles=int(self.particles))
