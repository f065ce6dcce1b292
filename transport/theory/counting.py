"""What a count within an element of finite size is worth: its mean, its variance, and the size that is best.

An element of width h about a point stands for the value f there.  Its mean is off by about f'' h²/24, and its variance
falls with the particles that it catches: one too large is blurred, one too small is noisy.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np


class Moments(NamedTuple):
    """What elements hold, each an array: exact means, and what their variances are made of.

    second: histories × the mean square of what one of them adds to the mean over the element;  square: what to take
    off for the mean itself.
    """

    mean: np.ndarray
    second: np.ndarray
    square: np.ndarray

    def variance(self, histories: float, parts: int = 1) -> np.ndarray:
        """Variance of the mean that histories count, in one of several equal parts of the meter: (parts s − q)/N."""
        return (parts * self.second - self.square) / histories

    def deviation(self, value: float, histories: float, parts: int = 1) -> np.ndarray:
        """Root mean square deviation from the value at the point: √(bias² + variance)."""
        return np.sqrt((self.mean - value) ** 2 + self.variance(histories, parts))


def root_mean(squares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Root of the mean over measurements, the first axis, and its standard error [unit of the root]; nan of one."""
    root = np.sqrt(squares.mean(axis=0))
    if len(squares) < 2:
        return root, np.full_like(root, math.nan)
    return root, squares.std(axis=0, ddof=1) / math.sqrt(len(squares)) / (2 * root)


def best_width(value: float, curvature: float, rate: float, histories: float) -> float:
    """Width h of the element about a point whose mean comes closest to the point's value [unit of the width].

    value, curvature: f and f'' at the point;  rate: an element of width h receives rate f h scores a history, all of
    one weight.  Its mean is off by f'' h²/24 and has the variance f / (rate N h).  The sum of the square and of the
    variance is least at h = (144 f / (rate N f''²))^(1/5), where the variance is four times the square (Rosenblatt
    1956, Ann. Math. Stat. 27, 832, for the same estimate of a density).  Vectorised.
    """
    return (144 * value / (rate * np.asarray(histories) * np.square(curvature))) ** 0.2


def burst_moments(low: np.ndarray, high: np.ndarray, fluence: float, sigma: float, share: float) -> Moments:
    """Means of a Gaussian burst over spans of time [W m^-2], from low to high after its peak [s].

    fluence: of the whole burst [J m^-2];  sigma: its standard deviation [s];  share: of the histories that reach the
    meter at all.  A span holds Φ(high/σ) − Φ(low/σ) of the burst, Φ the normal distribution.
    """
    from scipy.special import ndtr

    part = ndtr(np.divide(high, sigma)) - ndtr(np.divide(low, sigma))
    mean = fluence * part / np.subtract(high, low)
    return Moments(mean, mean**2 / (share * part), mean**2)


def burst_peak(fluence: float, sigma: float) -> float:
    """Irradiance at the peak of a Gaussian burst [W m^-2]: fluence / (√(2π) σ)."""
    return fluence / (math.sqrt(2 * math.pi) * sigma)
