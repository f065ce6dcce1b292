"""Free flight of a Gaussian cloud of independent positions and velocities.

Positions and velocities start normal and independent, N(0, sigma_x) and N(0, sigma_v). Without forces
and collisions x = x0 + v t, a shear of phase space. Normal distributions remain normal: with
s^2 = sigma_x^2 + sigma_v^2 t^2 the density is N(0, s), and the velocities at x are normal with the mean
u = x sigma_v^2 t / s^2 and the variance sigma_v^2 sigma_x^2 / s^2: the cloud cools locally while it
spreads. The shear has the determinant 1: areas of phase space, and the density along each trajectory,
are constant (Liouville 1838; Goldstein 1980, 9-8). Each dimension is independent; three dimensions are
a product.

Bins hold averages, integrated by Gauss-Legendre from positive terms, so that nothing cancels in a tail.
"""

from __future__ import annotations

import math

import numpy as np

from transport.statistics.quadrature import legendre_nodes

_NODES, _WEIGHTS = legendre_nodes(64)
_REACH = 10.0  # standard deviations; beyond them exp(-x^2/2) adds less than 1e-22 to a bin


def width(time: float, sigma_x: float, sigma_v: float) -> float:
    """Standard deviation of the positions after a time.

    Parameters
    ----------
    time : float
        Time of flight t [s].
    sigma_x : float
        Standard deviation of the initial positions [m].
    sigma_v : float
        Standard deviation of the velocities [m/s].

    Returns
    -------
    float
        ``s = sqrt(sigma_x^2 + sigma_v^2 t^2)`` [m].

    Examples
    --------
    >>> from transport.theory.free_flight import width
    >>> print(f"{width(2.0, 1.0, 1.0):.4g}")
    2.236
    """
    return math.hypot(sigma_x, sigma_v * time)


def density(x: np.ndarray, time: float, sigma_x: float, sigma_v: float) -> np.ndarray:
    """Share of the cloud per length.

    Parameters
    ----------
    x : ndarray
        Positions [m].
    time : float
        Time of flight t [s].
    sigma_x : float
        Standard deviation of the initial positions [m].
    sigma_v : float
        Standard deviation of the velocities [m/s].

    Returns
    -------
    ndarray
        Density N(0, s), shape of `x` [m^-1].

    Examples
    --------
    >>> from transport.theory.free_flight import density
    >>> print(f"{density(0.0, 2.0, 1.0, 1.0):.4g}")
    0.1784
    """
    s = width(time, sigma_x, sigma_v)
    return np.exp(-((np.asarray(x) / s) ** 2) / 2) / (s * math.sqrt(2 * math.pi))


def mean_velocity(x: np.ndarray, time: float, sigma_x: float, sigma_v: float) -> np.ndarray:
    """Mean velocity of the particles at a position.

    Parameters
    ----------
    x : ndarray
        Positions [m].
    time : float
        Time of flight t [s].
    sigma_x : float
        Standard deviation of the initial positions [m].
    sigma_v : float
        Standard deviation of the velocities [m/s].

    Returns
    -------
    ndarray
        ``u = x sigma_v^2 t / s^2``, shape of `x` [m/s]; it tends to x/t.

    Examples
    --------
    >>> from transport.theory.free_flight import mean_velocity
    >>> print(f"{mean_velocity(1.0, 2.0, 1.0, 1.0):.4g}")
    0.4
    """
    return np.asarray(x) * _slope(time, sigma_x, sigma_v)


def velocity_variance(time: float, sigma_x: float, sigma_v: float) -> float:
    """Variance of the velocities at any one position.

    Parameters
    ----------
    time : float
        Time of flight t [s].
    sigma_x : float
        Standard deviation of the initial positions [m].
    sigma_v : float
        Standard deviation of the velocities [m/s].

    Returns
    -------
    float
        ``(sigma_v sigma_x / s)^2`` [m^2 s^-2], k T / m of this direction.

    Examples
    --------
    >>> from transport.theory.free_flight import velocity_variance
    >>> print(f"{velocity_variance(2.0, 1.0, 1.0):.4g}")
    0.2
    """
    return (sigma_v * (sigma_x / width(time, sigma_x, sigma_v))) ** 2


def phase_density(x: np.ndarray, v: np.ndarray, time: float, sigma_x: float, sigma_v: float) -> np.ndarray:
    """Share of the cloud per length and velocity.

    Parameters
    ----------
    x : ndarray
        Positions [m].
    v : ndarray
        Velocities [m/s].
    time : float
        Time of flight t [s].
    sigma_x : float
        Standard deviation of the initial positions [m].
    sigma_v : float
        Standard deviation of the velocities [m/s].

    Returns
    -------
    ndarray
        Initial density at (x - v t, v) (Liouville's theorem) [m^-1 (m/s)^-1].

    Examples
    --------
    >>> from transport.theory.free_flight import phase_density
    >>> print(f"{phase_density(1.0, 0.5, 2.0, 1.0, 1.0):.4g}")
    0.1405
    """
    start = (np.asarray(x) - np.asarray(v) * time) / sigma_x
    return np.exp(-(start**2 + (v / sigma_v) ** 2) / 2) / (2 * math.pi * sigma_x * sigma_v)


def sheared_covariance(time: float, xx: float, xv: float, vv: float) -> tuple[float, float, float]:
    """Covariance of position and velocity after a free flight.

    Parameters
    ----------
    time : float
        Time of flight t [s].
    xx : float
        Initial variance of the positions [m^2].
    xv : float
        Initial covariance of position and velocity [m^2/s].
    vv : float
        Variance of the velocities [m^2/s^2].

    Returns
    -------
    tuple of 3 float
        xx [m^2], xv [m^2/s] and vv [m^2/s^2] at the time t.

    Notes
    -----
    ``S -> M S M^T`` with ``M = (1 t; 0 1)``. ``xx vv - xv^2``, the squared emittance, is constant.

    Examples
    --------
    >>> from transport.theory.free_flight import sheared_covariance
    >>> sheared_covariance(2.0, 1.0, 0.0, 1.0)
    (5.0, 2.0, 1.0)
    """
    return xx + 2 * time * xv + time**2 * vv, xv + time * vv, vv


def bin_shares(edges: np.ndarray, time: float, sigma_x: float, sigma_v: float) -> np.ndarray:
    """Share of the cloud in each bin of position.

    Parameters
    ----------
    edges : ndarray
        Bin edges, increasing, shape (n + 1,) [m]; the outer ones may be infinite.
    time : float
        Time of flight t [s].
    sigma_x : float
        Standard deviation of the initial positions [m].
    sigma_v : float
        Standard deviation of the velocities [m/s].

    Returns
    -------
    ndarray
        Shares, shape (n,) [1].

    Examples
    --------
    >>> from transport.theory.free_flight import bin_shares
    >>> print(bin_shares([-1.0, 0.0, 1.0], 2.0, 1.0, 1.0).round(4))
    [0.1726 0.1726]
    """
    return _bin_moments(edges, width(time, sigma_x, sigma_v))[0]


def bin_mean_velocities(edges: np.ndarray, time: float, sigma_x: float, sigma_v: float) -> np.ndarray:
    """Mean velocity of the particles in each bin of position.

    Parameters
    ----------
    edges : ndarray
        Bin edges, increasing, shape (n + 1,) [m]; the outer ones may be infinite.
    time : float
        Time of flight t [s].
    sigma_x : float
        Standard deviation of the initial positions [m].
    sigma_v : float
        Standard deviation of the velocities [m/s].

    Returns
    -------
    ndarray
        u at the mean position of each bin's particles, shape (n,) [m/s].

    Examples
    --------
    >>> from transport.theory.free_flight import bin_mean_velocities
    >>> print(bin_mean_velocities([-1.0, 0.0, 1.0], 2.0, 1.0, 1.0).round(4))
    [-0.1967  0.1967]
    """
    return _bin_moments(edges, width(time, sigma_x, sigma_v))[1] * _slope(time, sigma_x, sigma_v)


def bin_velocity_variances(edges: np.ndarray, time: float, sigma_x: float, sigma_v: float) -> np.ndarray:
    """Variance of the velocities in each bin of position.

    Parameters
    ----------
    edges : ndarray
        Bin edges, increasing, shape (n + 1,) [m]; the outer ones may be infinite.
    time : float
        Time of flight t [s].
    sigma_x : float
        Standard deviation of the initial positions [m].
    sigma_v : float
        Standard deviation of the velocities [m/s].

    Returns
    -------
    ndarray
        Local variance plus the variance of u over the bin, shape (n,) [m^2 s^-2].

    Examples
    --------
    >>> from transport.theory.free_flight import bin_velocity_variances
    >>> print(bin_velocity_variances([-1.0, 0.0, 1.0], 2.0, 1.0, 1.0).round(4))
    [0.2132 0.2132]
    """
    spread = _bin_moments(edges, width(time, sigma_x, sigma_v))[2]
    return velocity_variance(time, sigma_x, sigma_v) + spread * _slope(time, sigma_x, sigma_v) ** 2


def cell_shares(
    x_edges: np.ndarray, v_edges: np.ndarray, time: float, sigma_x: float, sigma_v: float
) -> np.ndarray:
    """Share of the cloud in each cell of position and velocity.

    Parameters
    ----------
    x_edges : ndarray
        Edges of the position bins, increasing, shape (X + 1,) [m].
    v_edges : ndarray
        Edges of the velocity bins, increasing, shape (V + 1,) [m/s]; the outer ones may be infinite.
    time : float
        Time of flight t [s].
    sigma_x : float
        Standard deviation of the initial positions [m].
    sigma_v : float
        Standard deviation of the velocities [m/s].

    Returns
    -------
    ndarray
        Shares, shape (X, V) [1].

    Notes
    -----
    The velocities at x are normal, which leaves one integral over x: 64 nodes per bin, accurate to
    1e-12 for bins up to ten sigma_x wide.

    Examples
    --------
    >>> from transport.theory.free_flight import cell_shares
    >>> print(cell_shares([0.0, 1.0], [0.0, 1.0], 2.0, 1.0, 1.0).round(4))
    [[0.1077]]
    """
    x_edges, v_edges = np.asarray(x_edges, dtype=float), np.asarray(v_edges, dtype=float)
    places, weights = _points_in(x_edges)
    spread = math.sqrt(velocity_variance(time, sigma_x, sigma_v))
    scaled = (v_edges - mean_velocity(places, time, sigma_x, sigma_v)[..., None]) / spread
    weights = weights * density(places, time, sigma_x, sigma_v)
    return (weights[..., None] * normal_shares(scaled[..., :-1], scaled[..., 1:])).sum(axis=1)


def normal_shares(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Probability of a standard normal number between two limits, with full relative accuracy in either tail.

    Parameters
    ----------
    low : ndarray
        Lower limits [1].
    high : ndarray
        Upper limits [1].

    Returns
    -------
    ndarray
        Probabilities [1].

    Examples
    --------
    >>> from transport.theory.free_flight import normal_shares
    >>> print(f"{normal_shares(-1.0, 1.0):.4g}")
    0.6827
    """
    from scipy.special import ndtr

    low, high = np.asarray(low), np.asarray(high)
    is_above = low > 0
    return ndtr(np.where(is_above, -low, high)) - ndtr(np.where(is_above, -high, low))


def _slope(time: float, sigma_x: float, sigma_v: float) -> float:
    """Slope du/dx of the mean velocity [s^-1]."""
    s = width(time, sigma_x, sigma_v)
    return sigma_v / s * (sigma_v * time / s)


def _points_in(edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of Gauss-Legendre quadrature in each of n bins, (n, 64)."""
    half = np.diff(edges)[:, None] / 2
    return edges[:-1, None] + half * (1 + _NODES), half * _WEIGHTS


def _bin_moments(edges: np.ndarray, sigma: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Share, mean and variance of N(0, sigma) in each bin; the negligible far end of a bin is cut off."""
    edges = np.asarray(edges, dtype=float) / sigma
    low, high = edges[:-1], edges[1:]
    nearest = np.clip(0.0, low, high)
    reach = np.hypot(nearest, _REACH)
    low, high = np.maximum(low, -reach), np.minimum(high, reach)
    half = (high - low)[:, None] / 2
    places = low[:, None] + half * (1 + _NODES)
    # Take the density relative to the nearest node, so that a tail does not underflow before the division.
    weights = half * _WEIGHTS * np.exp((nearest[:, None] - places) * (nearest[:, None] + places) / 2)
    total = weights.sum(axis=1)
    mean = (weights * places).sum(axis=1) / total
    variance = (weights * (places - mean[:, None]) ** 2).sum(axis=1) / total
    mean = np.where(low == -high, 0.0, mean)
    share = total * np.exp(-(nearest**2) / 2) / math.sqrt(2 * math.pi)
    return share, mean * sigma, variance * sigma**2
