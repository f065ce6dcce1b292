"""Random flights: displacement of a particle that scatters repeatedly without absorption.

Directions decorrelate: the mean cosine between the directions at two times t apart is exp(-(1 - g) t),
t in mean free times, so that the mean square displacement is 2 (nu t - 1 + exp(-nu t))/nu^2 mean free
paths squared, nu = 1 - g (Taylor 1921; Fürth 1920): t^2 at first, for straight flight, and 2 t/(1 - g)
at late times, six times the diffusion constant times t.

A point burst projected on one coordinate is a plane burst: its density in x, whatever y and z, is that
of the plane pulse, known in closed form up to one integral (Ganapol 1986; benchmark AZURV1, Ganapol
2001). Isotropic scattering.
"""

from __future__ import annotations

import math

import numpy as np

from transport.statistics.quadrature import legendre_nodes

_NODES, _WEIGHTS = legendre_nodes(128)
_BIN_NODES, _BIN_WEIGHTS = legendre_nodes(24)
_SERIES = 24  # terms; for arguments below 1 the last is 1e-24 of the first


def mean_square_displacement(time: float, g: float = 0.0) -> float:
    """Mean square displacement after a time.

    Parameters
    ----------
    time : float or ndarray
        Time t [mean free times].
    g : float, default 0.0
        Mean scattering cosine, below 1 [1].

    Returns
    -------
    float or ndarray
        ``2 (nu t - 1 + exp(-nu t)) / nu^2`` with nu = 1 - g [mean free paths squared].

    Notes
    -----
    Source: Taylor 1921; Fürth 1920. A series where nu t < 1.

    Examples
    --------
    >>> from transport.theory.random_flights import mean_square_displacement
    >>> print(f"{mean_square_displacement(1.0, 0.5):.4g}")
    0.8522
    """
    t, nu = np.asarray(time, dtype=float), 1 - g
    x = nu * t
    small, series = np.minimum(x, 1.0), 0.0
    for k in range(_SERIES, 1, -1):
        series = 1 / math.factorial(k) - small * series
    large = np.maximum(x, 1.0)
    shape = np.where(x < 1, series, (large + np.expm1(-large)) / large**2)
    return (2 * t * t * shape)[()]


def mean_square_after(flights: int, g: float = 0.0) -> float:
    """Mean square displacement after a number of exponential flights.

    Parameters
    ----------
    flights : int
        Number n of flights.
    g : float, default 0.0
        Mean scattering cosine, below 1 [1].

    Returns
    -------
    float
        ``2 [n/(1-g) - g (1 - g^n)/(1-g)^2]`` [mean free paths squared]; 2 n for g = 0.

    Notes
    -----
    Computed as ``2 Σ (n - k) g^k`` over k from 0 to n - 1 (Flory 1969, a chain of fixed angles, with
    <l^2> = 2).

    Examples
    --------
    >>> from transport.theory.random_flights import mean_square_after
    >>> print(f"{mean_square_after(10, 0.5):.4g}")
    36
    """
    k = np.arange(flights)
    return float(2 * ((flights - k) * np.power(float(g), k)).sum())


def mean_advance(time: float, g: float = 0.0) -> float:
    """Mean displacement along the initial direction after a time.

    Parameters
    ----------
    time : float or ndarray
        Time t [mean free times].
    g : float, default 0.0
        Mean scattering cosine, below 1 [1].

    Returns
    -------
    float or ndarray
        ``(1 - exp(-(1 - g) t))/(1 - g)`` [mean free paths].

    Examples
    --------
    >>> from transport.theory.random_flights import mean_advance
    >>> print(f"{mean_advance(1.0, 0.5):.4g}")
    0.7869
    """
    t, nu = np.asarray(time, dtype=float), 1 - g
    return (-np.expm1(-nu * t) / nu)[()]


def plane_pulse(x: float, time: float, albedo: float = 1.0) -> float:
    """Density along x of particles born isotropically at x = 0 at the time 0.

    Parameters
    ----------
    x : float or ndarray
        Positions [mean free paths].
    time : float
        Time t, above 0 [mean free times].
    albedo : float, default 1.0
        Single-scattering albedo c; scattering is isotropic [1].

    Returns
    -------
    float or ndarray
        Density [per mean free path]; 0 for abs(x) > t.

    Notes
    -----
    ``exp(-t)/(2 t) {1 + (c t/4 pi)(1 - w^2) ∫ sec^2(u/2) Re[y^2 exp((c t/2)(1 - w^2) y)]
    du}``, u from 0 to pi, with w = x/t and ``y = (log((1 + w)/(1 - w)) + i u)/(w + i tan(u/2))``
    (Ganapol 2001). The first term is the uncollided part.

    Examples
    --------
    >>> from transport.theory.random_flights import plane_pulse
    >>> print(f"{plane_pulse(0.5, 1.0):.4g}")
    0.5329
    """
    w = np.abs(np.asarray(x, dtype=float) / time)
    inside = w < 1
    w = np.where(inside, w, 0.0)[..., None]
    half = math.pi * (1 + _NODES) / 4
    above, below = 2 * (np.arctanh(w) + 1j * half), w * np.cos(half) + 1j * np.sin(half)
    left = (1 - w) * (1 + w)
    grown = np.exp(albedo * time / 2 * left * above * np.cos(half) / below - time)
    integral = ((above / below) ** 2 * grown).real @ _WEIGHTS * math.pi / 2
    density = (math.exp(-time) + albedo * time / (4 * math.pi) * left[..., 0] * integral) / (2 * time)
    return np.where(inside, density, 0.0)[()]


def plane_pulse_shares(edges: np.ndarray, time: float, albedo: float = 1.0) -> np.ndarray:
    """Share of the particles of the plane pulse in each bin of x.

    Parameters
    ----------
    edges : ndarray
        Bin edges, increasing, shape (n + 1,) [mean free paths].
    time : float
        Time t, above 0 [mean free times].
    albedo : float, default 1.0
        Single-scattering albedo c [1].

    Returns
    -------
    ndarray
        Shares, shape (n,) [1].

    Notes
    -----
    Integrated over the angle asin(x/t), in which the density is smooth up to the front.

    Examples
    --------
    >>> from transport.theory.random_flights import plane_pulse_shares
    >>> print(plane_pulse_shares([-1.0, 0.0, 1.0], 1.0).round(4))
    [0.5 0.5]
    """
    angles = np.arcsin(np.clip(np.asarray(edges, dtype=float) / time, -1, 1))
    half = np.diff(angles)[:, None] / 2
    angle = angles[:-1, None] + half * (1 + _BIN_NODES)
    return (half * _BIN_WEIGHTS * time * np.cos(angle) * plane_pulse(time * np.sin(angle), time, albedo)).sum(
        axis=1
    )
