"""Fits of run time against particles and of log(error) against log(seconds)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

MONTE_CARLO_SLOPE = -0.5  # slope for independent histories
MAX_Z = 3.0  # standard errors within which a measured slope is replaced by the expected one


@dataclass(frozen=True)
class TimeModel:
    """Duration of a run: latency + per_particle × particles.

    Parameters
    ----------
    latency : float
        Constant part [s].
    per_particle : float
        Time per particle [s].

    Examples
    --------
    >>> from transport.statistics.convergence import TimeModel as Pace
    >>> float(TimeModel(latency=0.5, per_particle=1e-3).seconds_for(1000))
    1.5
    """

    latency: float
    per_particle: float

    def seconds_for(self, particles: np.ndarray | float) -> np.ndarray | float:
        """Duration [s] of a run with this number of particles."""
        return self.latency + self.per_particle * np.asarray(particles)


def fit_time(particles: np.ndarray, seconds: np.ndarray) -> TimeModel:
    """Fit the pace by least squares of relative deviations, with both parts positive."""
    particles, seconds = np.asarray(particles, dtype=float), np.asarray(seconds, dtype=float)
    if len(seconds) > 1:
        columns = np.stack([1 / seconds, particles / seconds], axis=1)
        (latency, per_particle), *_ = np.linalg.lstsq(columns, np.ones(len(seconds)), rcond=None)
        if per_particle > 0:
            return TimeModel(max(0.0, float(latency)), float(per_particle))
    return TimeModel(0.0, float(seconds[-1] / particles[-1]))


@dataclass(frozen=True)
class PowerLaw:
    """Power law error = factor × seconds^used, in seconds beyond the latency of a run.

    Parameters
    ----------
    factor : float
        Relative error after one second.
    used : float
        Exponent: the expected -1/2 if the measured slope agrees with it, else the measured one.
    slope : float
        Measured slope of log(error) against log(seconds).
    slope_error : float
        Standard error of `slope`.

    Examples
    --------
    >>> from transport.statistics.convergence import PowerLaw as Line
    >>> line = PowerLaw(factor=0.01, used=-0.5, slope=-0.52, slope_error=0.03)
    >>> f"{line.seconds_to(0.001):g} s"
    '100 s'
    """

    factor: float
    used: float
    slope: float
    slope_error: float

    def error_at(self, seconds: np.ndarray | float) -> np.ndarray | float:
        """Relative error after this many seconds."""
        return self.factor * np.power(seconds, self.used)

    def seconds_to(self, error: float) -> float:
        """Seconds to this relative error; infinite if the line does not fall."""
        return math.inf if self.used >= 0 else (error / self.factor) ** (1 / self.used)


def fit_power_law(seconds: np.ndarray, errors: np.ndarray, runs: np.ndarray) -> PowerLaw | None:
    """Fit the line by weighted least squares; None for fewer than two known positive errors.

    errors: root mean squares over `runs` runs of normal deviations, so that their logarithms have variance 1
    / (2 runs). The slope of independent histories is used if the measured one is within three standard errors
    of it.
    """
    seconds, errors, runs = (np.asarray(part, dtype=float) for part in (seconds, errors, runs))
    known = np.isfinite(errors) & (errors > 0) & (seconds > 0)
    if np.count_nonzero(known) < 2:
        return None
    x, y, weights = np.log(seconds[known]), np.log(errors[known]), 2 * runs[known]
    x0, y0 = np.average(x, weights=weights), np.average(y, weights=weights)
    spread = float(np.sum(weights * (x - x0) ** 2))
    slope, slope_error = float(np.sum(weights * (x - x0) * (y - y0))) / spread, 1 / math.sqrt(spread)
    agrees = abs(slope - MONTE_CARLO_SLOPE) <= MAX_Z * slope_error
    used = MONTE_CARLO_SLOPE if agrees else slope
    return PowerLaw(math.exp(y0 - used * x0), used, slope, slope_error)
