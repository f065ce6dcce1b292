"""Laws of one velocity component of a Maxwellian gas, in units of its standard deviation.

Positive terms only: nothing cancels for a drift away from the plane, where next to nothing crosses.
"""

import math

import numpy as np

from transport.speeds.inversion import increasing_root, log_ratio

REACH = 8.5  # standard deviations; `line` stays within
LEAST = 2.0**-54
TERMS = 120  # of the continued fraction
WINDOW = 10.0  # standard deviations below a speed, beyond which what crosses more slowly is nothing (e^-45)
NODES, WEIGHTS = np.polynomial.legendre.leggauss(64)
NODES, WEIGHTS = (NODES + 1) / 2, WEIGHTS / 2  # on [0, 1]


def line(u: np.ndarray) -> np.ndarray:
    """Quantile of a standard normal; u below 2^-54 stands for 2^-54, so that 0 gives a number."""
    from scipy.special import ndtri

    u = np.asarray(u, float)
    return np.where(u > 0.5, -ndtri(np.maximum(1 - u, LEAST)), ndtri(np.maximum(u, LEAST)))


def crossing_rate(drift: np.ndarray) -> np.ndarray:
    """Mean of max(w, 0) for a normal w with that mean: phi(d) + d Phi(d).

    For d < -2 by the continued fraction of the ratios of repeated integrals of erfc, r[n-1] = 1/(2 z + 2 n
    r[n]) at z = -d/sqrt 2 (Abramowitz and Stegun 1964, 7.2.5), where the closed form cancels.
    """
    from scipy.special import ndtr

    drift = np.asarray(drift, float)
    away = np.minimum(drift, -2.0) / -math.sqrt(2.0)
    ratio = 1 / (away + np.sqrt(away * away + 2 * TERMS))
    for n in range(TERMS, 1, -1):
        ratio = 1 / (2 * (away + n * ratio))
    density = np.exp(-0.5 * drift * drift) / math.sqrt(2 * math.pi)
    far = density * ratio / (away + ratio)
    return np.where(drift < -2, far, density + drift * ndtr(drift))


def crossing(u: np.ndarray, drift: float) -> np.ndarray:
    """Quantile of the density proportional to w exp(-(w - d)²/2), w > 0: of normal speeds that cross."""
    u = np.asarray(u, float)
    w, upper, whole = np.empty(u.shape), u > 0.5, float(crossing_rate(drift))
    w[~upper] = _slow(u[~upper] * whole, drift)
    w[upper] = _fast((1 - u[upper]) * whole, drift)
    return w


def _slow(target: np.ndarray, drift: float) -> np.ndarray:
    """w below which the target crosses."""

    def misfit(w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        start = np.maximum(w - WINDOW, 0.0)
        width = w - start
        below = width * (_density(start[:, None] + width[:, None] * NODES, drift) @ WEIGHTS)
        return log_ratio(below, target), w * _density(w, drift) / below

    w = increasing_root(misfit, *_bracket(target, drift))
    return np.where(target > 0, w, 0.0)


def _fast(target: np.ndarray, drift: float) -> np.ndarray:
    """w above which the target crosses."""
    from scipy.special import ndtr

    def misfit(w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        above = crossing_rate(drift - w) + w * ndtr(drift - w)
        return -log_ratio(above, target), w * _density(w, drift) / above

    return increasing_root(misfit, *_bracket(target, drift))


def _density(w: np.ndarray, drift: float) -> np.ndarray:
    return w * np.exp(-0.5 * (w - drift) ** 2) / math.sqrt(2 * math.pi)


def _bracket(target: np.ndarray, drift: float) -> tuple[np.ndarray, np.ndarray]:
    return np.zeros(target.shape), np.full(target.shape, max(drift, 0.0) + WINDOW)
