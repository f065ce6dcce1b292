"""Pulses: when a source emits within the scene's duration; without one it emits evenly over all of it."""

import numpy as np

from transport.normals import REACH, line
from transport.validation import refuse, scene_object, settle_nonnegative, settle_positive

ROUNDING = 1e-12  # of the reach of a Gaussian, which goes farther than any draw


class Pulse:
    """What all pulses share; not made itself."""

    holds_rates = False  # whether a power [W] can hold while it is on

    @property
    def first(self) -> float:
        """Earliest time of emission [s]."""
        return self.time

    @property
    def last(self) -> float:
        """Latest time of emission [s]."""
        return self.time

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """Time of emission [s] for u uniform in [0, 1), an array."""
        raise NotImplementedError


@scene_object
class Instant(Pulse):
    """All at one `time` [s]."""

    time: float = 0.0

    def __post_init__(self) -> None:
        settle_nonnegative(self, "time")

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """The one time [s]."""
        return np.full(np.shape(u), self.time)


@scene_object
class BoxPulse(Pulse):
    """Evenly from `start` to `stop` [s]; rates such as a power hold while it is on."""

    start: float
    stop: float

    holds_rates = True

    def __post_init__(self) -> None:
        settle_nonnegative(self, "start")
        settle_positive(self, "stop")
        if self.stop <= self.start:
            refuse(
                self,
                f"stop must be after start={self.start} s, got {self.stop}; for all at once write Instant()",
            )

    @property
    def first(self) -> float:
        """Its start [s]."""
        return self.start

    @property
    def last(self) -> float:
        """Its stop [s]."""
        return self.stop

    @property
    def length(self) -> float:
        """For how long it is on [s]."""
        return self.stop - self.start

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """Time of emission [s], uniform."""
        return np.minimum(self.start + np.asarray(u, float) * self.length, self.stop)


@scene_object
class GaussianPulse(Pulse):
    """Normal about `time` [s] with the standard deviation `sigma` [s]; it reaches 8.5 sigma to both sides."""

    time: float
    sigma: float

    def __post_init__(self) -> None:
        settle_positive(self, "time", "sigma")
        if self.first < 0:
            cure = f"write time={REACH * self.sigma:g} or more, or a smaller sigma"
            refuse(
                self,
                f"time must be {REACH} sigma or more, got {self.time} with sigma={self.sigma}; {cure}",
            )

    @property
    def first(self) -> float:
        """8.5 sigma before its middle [s]."""
        return self.time - self._reach

    @property
    def last(self) -> float:
        """8.5 sigma after its middle [s]."""
        return self.time + self._reach

    @property
    def _reach(self) -> float:
        return REACH * (1 - ROUNDING) * self.sigma

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """Time of emission [s], normal; u below 2^-54 stands for 2^-54."""
        return self.time + self.sigma * line(u)
