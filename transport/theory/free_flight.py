"""Free flight of a Gaussian cloud: positions and velocities start independent, N(0, sigma_x) and N(0, sigma_v).

Without forces and collisions x = x0 + v t, a shear of phase space.  What is normal stays normal: with
s^2 = sigma_x^2 + sigma_v^2 t^2 the density is N(0, s), and at x the velocities are normal round u = x sigma_v^2 t / s^2
with the variance sigma_v^2 sigma_x^2 / s^2: the cloud cools at every place while it spreads.  The shear has the
determinant 1: areas of phase space, and the density along each trajectory, never change (Liouville 1838; Goldstein
1980, 9-8).  Each dimension by itself; three are a product.

Bins hold averages.  They are integrated by Gauss-Legendre from positive terms, so that nothing cancels in a tail.
"""

from __future__ import annotations

import math

import numpy as np

from transport.theory.nodes import legendre_nodes

_NODES, _WEIGHTS = legendre_nodes(64)
_REACH = 10.0  # standard deviations within a bin beyond which exp(-x^2/2) adds less than 1e-22 of it


def width(time: float, sigma_x: float, sigma_v: float) -> float:
    """Standard deviation of the positions after that time [m]: s = sqrt(sigma_x^2 + sigma_v^2 t^2)."""
    return math.hypot(sigma_x, sigma_v * time)


def density(x: np.ndarray, time: float, sigma_x: float, sigma_v: float) -> np.ndarray:
    """Share of the cloud per length at x [m^-1]: N(0, s).  Vectorised over x."""
    s = width(time, sigma_x, sigma_v)
    return np.exp(-((np.asarray(x) / s) ** 2) / 2) / (s * math.sqrt(2 * math.pi))


def mean_velocity(x: np.ndarray, time: float, sigma_x: float, sigma_v: float) -> np.ndarray:
    """Mean velocity of the particles at x [m/s]: u = x sigma_v^2 t / s^2, x/t in the end.  Vectorised over x."""
    return np.asarray(x) * _slope(time, sigma_x, sigma_v)


def velocity_variance(time: float, sigma_x: float, sigma_v: float) -> float:
    """Variance of the velocities at any one place [m^2 s^-2]: (sigma_v sigma_x / s)^2, k T / m of that direction."""
    return (sigma_v * (sigma_x / width(time, sigma_x, sigma_v))) ** 2


def phase_density(x: np.ndarray, v: np.ndarray, time: float, sigma_x: float, sigma_v: float) -> np.ndarray:
    """Share of the cloud per length and velocity [m^-1 (m/s)^-1]: that at (x - v t, v) of the start (Liouville)."""
    start = (np.asarray(x) - np.asarray(v) * time) / sigma_x
    return np.exp(-(start**2 + (v / sigma_v) ** 2) / 2) / (2 * math.pi * sigma_x * sigma_v)


def sheared_covariance(time: float, xx: float, xv: float, vv: float) -> tuple[float, float, float]:
    """Covariance (xx [m^2], xv [m^2/s], vv [m^2/s^2]) after a free flight of that time, S -> M S M^T.

    M = (1 t; 0 1).  xx vv - xv^2, the square of the emittance, does not change.
    """
    return xx + 2 * time * xv + time**2 * vv, xv + time * vv, vv


def bin_shares(edges: np.ndarray, time: float, sigma_x: float, sigma_v: float) -> np.ndarray:
    """Share of the cloud in each of n bins of x, (n,).  edges: (n + 1,) increasing [m], the outer ones may be infinite."""
    return _bin_moments(edges, width(time, sigma_x, sigma_v))[0]


def bin_mean_velocities(edges: np.ndarray, time: float, sigma_x: float, sigma_v: float) -> np.ndarray:
    """Mean velocity of the particles in each bin of x [m/s], (n,): u at their mean position."""
    return _bin_moments(edges, width(time, sigma_x, sigma_v))[1] * _slope(time, sigma_x, sigma_v)


def bin_velocity_variances(edges: np.ndarray, time: float, sigma_x: float, sigma_v: float) -> np.ndarray:
    """Variance of the velocities in each bin of x [m^2 s^-2], (n,): that at a place, and the spread of u over the bin."""
    spread = _bin_moments(edges, width(time, sigma_x, sigma_v))[2]
    return velocity_variance(time, sigma_x, sigma_v) + spread * _slope(time, sigma_x, sigma_v) ** 2


def cell_shares(
    x_edges: np.ndarray, v_edges: np.ndarray, time: float, sigma_x: float, sigma_v: float
) -> np.ndarray:
    """Share of the cloud in each cell of position and velocity, (X, V).

    Edges increase [m] and [m/s], the outer ones of v may be infinite.  At x the velocities are normal, so that one
    integral over x is left: 64 points a bin, good to 1e-12 for bins of x up to ten sigma_x wide.
    """
    x_edges, v_edges = np.asarray(x_edges, dtype=float), np.asarray(v_edges, dtype=float)
    places, weights = _points_in(x_edges)
    spread = math.sqrt(velocity_variance(time, sigma_x, sigma_v))
    scaled = (v_edges - mean_velocity(places, time, sigma_x, sigma_v)[..., None]) / spread
    weights = weights * density(places, time, sigma_x, sigma_v)
    return (weights[..., None] * normal_shares(scaled[..., :-1], scaled[..., 1:])).sum(axis=1)


def normal_shares(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Probability of a standard normal number between low and high; its own size is kept in either tail."""
    from scipy.special import ndtr

    low, high = np.asarray(low), np.asarray(high)
    is_above = low > 0
    return ndtr(np.where(is_above, -low, high)) - ndtr(np.where(is_above, -high, low))


def _slope(time: float, sigma_x: float, sigma_v: float) -> float:
    """du/dx [s^-1]."""
    s = width(time, sigma_x, sigma_v)
    return sigma_v / s * (sigma_v * time / s)


def _points_in(edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places and weights of Gauss-Legendre in each of n bins, (n, 64)."""
    half = np.diff(edges)[:, None] / 2
    return edges[:-1, None] + half * (1 + _NODES), half * _WEIGHTS


def _bin_moments(edges: np.ndarray, sigma: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Share, mean and variance of normal numbers N(0, sigma) in each bin; a bin's far end, where nothing is, is cut."""
    edges = np.asarray(edges, dtype=float) / sigma
    low, high = edges[:-1], edges[1:]
    nearest = np.clip(0.0, low, high)
    reach = np.hypot(nearest, _REACH)
    low, high = np.maximum(low, -reach), np.minimum(high, reach)
    half = (high - low)[:, None] / 2
    places = low[:, None] + half * (1 + _NODES)
    # Relative to the nearest place, so that no tail underflows before it is divided by.
    weights = half * _WEIGHTS * np.exp((nearest[:, None] - places) * (nearest[:, None] + places) / 2)
    total = weights.sum(axis=1)
    mean = (weights * places).sum(axis=1) / total
    variance = (weights * (places - mean[:, None]) ** 2).sum(axis=1) / total
    mean = np.where(low == -high, 0.0, mean)
    share = total * np.exp(-(nearest**2) / 2) / math.sqrt(2 * math.pi)
    return share, mean * sigma, variance * sigma**2
