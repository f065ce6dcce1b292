"""Pulses: when a source emits within the duration of the scene."""

import numpy as np

from transport.statistics.normal import MAX_DEVIATION, normal_quantile
from transport.validation import coerce_nonnegative, coerce_positive, refuse, scene_object

EXTENT_ROUNDING = 1e-12  # relative, of the extent of a Gaussian pulse, which exceeds every number drawn


class Pulse:
    """Base class of pulses; not instantiated directly."""

    holds_rates = False  # whether the amount may be a rate [W] that holds while the pulse is on

    @property
    def first(self) -> float:
        """Earliest time of emission.

        Returns
        -------
        float
            Time [s].
        """
        return self.time

    @property
    def last(self) -> float:
        """Latest time of emission.

        Returns
        -------
        float
            Time [s].
        """
        return self.time

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """Return times of emission for uniform numbers.

        Parameters
        ----------
        u : array
            Uniform numbers in [0, 1).

        Returns
        -------
        array
            Times [s], of the shape of u.
        """
        raise NotImplementedError


@scene_object
class Instant(Pulse):
    """A pulse in which everything is emitted at one time.

    Parameters
    ----------
    time : float, default 0
        Time of emission [s], zero or positive. The source needs a total amount (`energy` or `number`).

    Examples
    --------
    >>> import transport as tp
    >>> tp.Instant(2 * tp.ns).first
    2e-09
    """

    time: float = 0.0

    def __post_init__(self) -> None:
        coerce_nonnegative(self, "time")

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """Return the one time of emission [s], in an array of the shape of u."""
        return np.full(np.shape(u), self.time)


@scene_object
class BoxPulse(Pulse):
    """A rectangular pulse: uniform emission from `start` to `stop`.

    Parameters
    ----------
    start : float
        Start of the pulse [s], zero or positive.
    stop : float
        End of the pulse [s], after start.

    Notes
    -----
    The amount of the source may be a rate such as a power [W]: it holds while the pulse is on.

    Examples
    --------
    >>> import transport as tp
    >>> pulse = tp.BoxPulse(0.0, 1e-9)
    >>> pulse.length
    1e-09
    >>> tp.Isotropic(power=5.0).amount(tp.Point(), duration=1.0, pulse=pulse)  # [J]
    5e-09
    """

    start: float
    stop: float

    holds_rates = True

    def __post_init__(self) -> None:
        coerce_nonnegative(self, "start")
        coerce_positive(self, "stop")
        if self.stop <= self.start:
            refuse(
                self,
                f"stop must be after start={self.start} s, got {self.stop}; for one time write Instant()",
            )

    @property
    def first(self) -> float:
        """Start of the pulse.

        Returns
        -------
        float
            Time [s].
        """
        return self.start

    @property
    def last(self) -> float:
        """End of the pulse.

        Returns
        -------
        float
            Time [s].
        """
        return self.stop

    @property
    def length(self) -> float:
        """Length of the pulse, stop - start.

        Returns
        -------
        float
            Time [s].
        """
        return self.stop - self.start

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """Return times of emission [s], uniform from start to stop."""
        return np.minimum(self.start + np.asarray(u, float) * self.length, self.stop)


@scene_object
class GaussianPulse(Pulse):
    """A Gaussian pulse: times of emission are normally distributed.

    Parameters
    ----------
    time : float
        Mean time of emission [s], at least 8.5 `sigma`.
    sigma : float
        Standard deviation [s].

    Notes
    -----
    The pulse extends 8.5 sigma to either side, farther than any number that is drawn. The source needs a
    total amount (`energy` or `number`).

    Examples
    --------
    >>> import transport as tp
    >>> pulse = tp.GaussianPulse(time=10 * tp.ns, sigma=1 * tp.ns)
    >>> round(pulse.last / tp.ns, 6)
    18.5
    """

    time: float
    sigma: float

    def __post_init__(self) -> None:
        coerce_positive(self, "time", "sigma")
        if self.first < 0:
            cure = f"write time={MAX_DEVIATION * self.sigma:g} or more, or a smaller sigma"
            refuse(
                self,
                f"time must be {MAX_DEVIATION} sigma or more, got {self.time} with sigma={self.sigma};"
                f" {cure}",
            )

    @property
    def first(self) -> float:
        """Earliest time of emission, 8.5 sigma before the mean.

        Returns
        -------
        float
            Time [s].
        """
        return self.time - self._reach

    @property
    def last(self) -> float:
        """Latest time of emission, 8.5 sigma after the mean.

        Returns
        -------
        float
            Time [s].
        """
        return self.time + self._reach

    @property
    def _reach(self) -> float:
        return MAX_DEVIATION * (1 - EXTENT_ROUNDING) * self.sigma

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """Return times of emission [s], normally distributed; u below 2^-54 counts as 2^-54."""
        return self.time + self.sigma * normal_quantile(u)
