"""Distribution of one velocity component of a Maxwellian gas, in units of its standard deviation.

Only positive terms are summed: nothing cancels for a drift away from the plane, where almost nothing crosses.
"""

import math

import numpy as np

from transport.statistics.quantiles import increasing_root, log_ratio

MAX_DEVIATION = 8.5  # standard deviations; bound of `normal_quantile`
MIN_PROBABILITY = 2.0**-54  # least probability
TERMS = 120  # terms of the continued fraction
# Standard deviations below a speed, beyond which the crossing rate of slower particles is negligible (e^-45).
WINDOW = 10.0
NODES, WEIGHTS = np.polynomial.legendre.leggauss(64)
NODES, WEIGHTS = (NODES + 1) / 2, WEIGHTS / 2  # on [0, 1]


def normal_quantile(u: np.ndarray) -> np.ndarray:
    """Quantile of the standard normal distribution; u is at least 2^-54, so that u = 0 is finite."""
    from scipy.special import ndtri

    u = np.asarray(u, float)
    return np.where(
        u > 0.5, -ndtri(np.maximum(1 - u, MIN_PROBABILITY)), ndtri(np.maximum(u, MIN_PROBABILITY))
    )


def crossing_rate(drift: np.ndarray) -> np.ndarray:
    """Mean of max(w, 0) for a normal w with mean d = `drift`: phi(d) + d Phi(d).

    For d < -2, where this form cancels, by the continued fraction for ratios of repeated integrals of erfc,
    r[n-1] = 1/(2 z + 2 n r[n]) at z = -d/sqrt 2 (Abramowitz and Stegun 1964, 7.2.5).
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


def crossing_quantile(u: np.ndarray, drift: float) -> np.ndarray:
    """Quantile of the density proportional to w exp(-(w - d)²/2), w > 0: normal speed at a crossing."""
    u = np.asarray(u, float)
    w, upper, whole = np.empty(u.shape), u > 0.5, float(crossing_rate(drift))
    w[~upper] = _invert_below(u[~upper] * whole, drift)
    w[upper] = _invert_above((1 - u[upper]) * whole, drift)
    return w


def _invert_below(target: np.ndarray, drift: float) -> np.ndarray:
    """w below which the crossing rate is `target`, by Gauss-Legendre quadrature."""

    def misfit(w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        # Integrate only the last WINDOW standard deviations below w.
        start = np.maximum(w - WINDOW, 0.0)
        width = w - start
        below = width * (_crossing_density(start[:, None] + width[:, None] * NODES, drift) @ WEIGHTS)
        return log_ratio(below, target), w * _crossing_density(w, drift) / below

    w = increasing_root(misfit, *_bracket(target, drift))
    return np.where(target > 0, w, 0.0)


def _invert_above(target: np.ndarray, drift: float) -> np.ndarray:
    """w above which the crossing rate is `target`, in closed form."""
    from scipy.special import ndtr

    def misfit(w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        above = crossing_rate(drift - w) + w * ndtr(drift - w)
        return -log_ratio(above, target), w * _crossing_density(w, drift) / above

    return increasing_root(misfit, *_bracket(target, drift))


def _crossing_density(w: np.ndarray, drift: float) -> np.ndarray:
    """w times the normal density with mean `drift`."""
    return w * np.exp(-0.5 * (w - drift) ** 2) / math.sqrt(2 * math.pi)


def _bracket(target: np.ndarray, drift: float) -> tuple[np.ndarray, np.ndarray]:
    """Interval that contains w."""
    return np.zeros(target.shape), np.full(target.shape, max(drift, 0.0) + WINDOW)
