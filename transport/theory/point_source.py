"""An isotropic point source in an infinite medium: exact fluence rate, net flux and shell means.

The medium scatters isotropically; c is its albedo. In mean free paths, per emitted power, the transform
of the fluence rate is A/(1 - c A) with A(k) = atan(k)/k. Its pole at k = i kappa and its cut from i
upwards give

    phi(r) = [B exp(-kappa r) + ∫ g(s) exp(-s r) ds, s from 1 on] / (4 pi r),

with c atanh(kappa)/kappa = 1, B = 2 kappa^2 (1 - kappa^2) / (c (kappa^2 - 1 + c)), and 1/g = (1 - (c/s)
atanh(1/s))^2 + (pi c/(2 s))^2 (Case, de Hoffmann, Placzek 1953, 21; Case, Zweifel 1967, 4). g = 1 gives
the uncollided exp(-r)/(4 pi r^2); the collided part is computed with g - 1, so that nothing cancels
near the source. With s = coth t the integrand is smooth, including its resonance at t = 1/c; panels
uniform in log t make it good to 1e-12 at all r and c.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from transport.statistics.quadrature import legendre_nodes

_NODES, _WEIGHTS = legendre_nodes(24)
_MAX_T = 20.0  # largest t: beyond it s = 1 to 1e-17
_UNDERFLOW = 745.0  # s r beyond which exp(-s r) is 0


@lru_cache(maxsize=64)
def relaxation(albedo: float) -> tuple[float, float]:
    """Relaxation constant kappa and amplitude B of the asymptotic part.

    Parameters
    ----------
    albedo : float
        Single-scattering albedo c, in (0, 1] [1].

    Returns
    -------
    tuple of 2 float
        kappa, the reciprocal of the diffusion length [per mean free path], and B [1]; 0 and 3 for the
        albedo 1.

    Raises
    ------
    ValueError
        If the albedo is not in (0, 1].

    Notes
    -----
    Solves ``z coth z - 1 = (1 - c)/c`` with z = atanh kappa, which is convex, by Newton's method from
    the right.

    Examples
    --------
    >>> from transport.theory.point_source import relaxation
    >>> print(f"{relaxation(0.9)[0]:.4g}")
    0.5254
    """
    if not 0 < albedo <= 1:
        raise ValueError(f"relaxation: albedo must be above 0 and at most 1, got {albedo}")
    lost = 1 - albedo
    if lost == 0:
        return 0.0, 3.0
    z = lost / albedo + 1
    for _ in range(200):
        value, slope = _coth_curve(z)
        step = (value - lost / albedo) / slope
        z -= step
        if abs(step) <= 4e-16 * z:
            break
    kappa = math.tanh(z)
    if z > 20:  # sech^2 z is below 1e-17 of the other terms
        return kappa, 8 * math.exp(-2 * z) / albedo**2
    return kappa, 2 * (kappa / math.cosh(z)) ** 2 / (albedo * (kappa**2 - lost))


def _coth_curve(z: float) -> tuple[float, float]:
    """z coth z - 1 and its slope, by the continued fraction z^2/(3 + z^2/(5 + ...)) for small z."""
    if z > 1:
        coth = 1 / math.tanh(z)
        return z * coth - 1, coth - z * (coth - 1) * (coth + 1)
    square, value = z * z, 0.0
    for odd in range(31, 1, -2):
        value = square / (odd + value)
    # (z coth z)' from w = z coth z - 1: z w' = w + 1 - z^2/sinh^2 z and z^2/sinh^2 z = (1 + w)^2 - z^2
    return value, (square - value - value * value) / z


def uncollided(distance: float) -> float:
    """Fluence rate of uncollided light, per power.

    Parameters
    ----------
    distance : float or ndarray
        Distance from the source [mean free paths].

    Returns
    -------
    float or ndarray
        ``exp(-r)/(4 pi r^2)`` [mean free paths^-2].

    Examples
    --------
    >>> from transport.theory.point_source import uncollided
    >>> print(f"{uncollided(1.0):.4g}")
    0.02927
    """
    r = np.asarray(distance, dtype=float)
    return (np.exp(-r) / (4 * math.pi * r * r))[()]


def asymptotic(distance: float, albedo: float) -> float:
    """Asymptotic part of the fluence rate far from the source, per power.

    Parameters
    ----------
    distance : float or ndarray
        Distance from the source [mean free paths].
    albedo : float
        Single-scattering albedo c, in (0, 1] [1].

    Returns
    -------
    float or ndarray
        ``B exp(-kappa r)/(4 pi r)`` [mean free paths^-2].

    Raises
    ------
    ValueError
        If the albedo is not in (0, 1].

    Examples
    --------
    >>> from transport.theory.point_source import asymptotic
    >>> print(f"{asymptotic(1.0, 0.9):.4g}")
    0.1187
    """
    kappa, factor = relaxation(float(albedo))
    r = np.asarray(distance, dtype=float)
    return (factor * np.exp(-kappa * r) / (4 * math.pi * r))[()]


def diffusion(distance: float, albedo: float, g: float = 0.0) -> float:
    """Fluence rate by diffusion theory, per power.

    Parameters
    ----------
    distance : float or ndarray
        Distance from the source [mean free paths].
    albedo : float
        Single-scattering albedo c, from 0 to 1 [1].
    g : float, default 0.0
        Mean scattering cosine [1].

    Returns
    -------
    float or ndarray
        ``exp(-r/l)/(4 pi D r)`` with ``D = 1/(3 (1 - g c))`` and ``1/l^2 = (1 - c)/D`` [mean free
        paths^-2].

    Notes
    -----
    The limit of transport theory for albedos near 1, far from the source (Ishimaru 1978, 9-3).

    Examples
    --------
    >>> from transport.theory.point_source import diffusion
    >>> print(f"{diffusion(1.0, 0.9):.4g}")
    0.1381
    """
    r, coefficient = np.asarray(distance, dtype=float), 1 / (3 * (1 - g * albedo))
    falls = math.sqrt((1 - albedo) / coefficient)
    return (np.exp(-falls * r) / (4 * math.pi * coefficient * r))[()]


def fluence_rate(distance: float, extinction: float = 1.0, albedo: float = 0.0) -> float:
    """Fluence rate at a distance from an isotropic point source, per power.

    Parameters
    ----------
    distance : float or ndarray
        Distance from the source [m].
    extinction : float, default 1.0
        Extinction coefficient [m^-1].
    albedo : float, default 0.0
        Single-scattering albedo c, from 0 to 1 [1].

    Returns
    -------
    float or ndarray
        Fluence rate per power [m^-2], good to 1e-12.

    Examples
    --------
    >>> from transport.theory.point_source import fluence_rate
    >>> print(f"{fluence_rate(1.0, 1.0, 0.9):.4g}")
    0.1433
    """
    r = extinction * np.asarray(distance, dtype=float)
    return (extinction**2 * (uncollided(r) + collided(r, albedo)))[()]


def collided(distance: float, albedo: float) -> float:
    """Fluence rate of light that has collided, per power.

    Parameters
    ----------
    distance : float or ndarray
        Distance from the source [mean free paths].
    albedo : float
        Single-scattering albedo c, from 0 to 1 [1].

    Returns
    -------
    float or ndarray
        Fluence rate [mean free paths^-2].

    Examples
    --------
    >>> from transport.theory.point_source import collided
    >>> print(f"{collided(1.0, 0.9):.4g}")
    0.114
    """
    r = np.asarray(distance, dtype=float)
    if albedo == 0:
        return np.zeros_like(r)[()]
    parts = [
        _integral_over_cut(each, albedo, lambda s, each=each: np.exp(-s * each)) / each for each in r.ravel()
    ]
    return asymptotic(r, albedo) + (np.reshape(parts, r.shape) / (4 * math.pi))[()]


def shell_means(edges: np.ndarray, extinction: float = 1.0, albedo: float = 0.0) -> np.ndarray:
    """Mean fluence rate in spherical shells about an isotropic point source, per power.

    Parameters
    ----------
    edges : ndarray
        Radii between the shells, increasing from 0 on, shape (n + 1,) [m].
    extinction : float, default 1.0
        Extinction coefficient [m^-1].
    albedo : float, default 0.0
        Single-scattering albedo c, from 0 to 1 [1].

    Returns
    -------
    ndarray
        Mean fluence rates per power, shape (n,) [m^-2].

    Notes
    -----
    Each term of the fluence rate is integrated in closed form, ``r exp(-s r)``, so that the pole at the
    source causes no error.

    Examples
    --------
    >>> from transport.theory.point_source import shell_means
    >>> print(shell_means([0.0, 1.0, 2.0], 1.0, 0.9).round(4))
    [0.3527 0.064 ]
    """
    edges = np.asarray(edges, dtype=float) * extinction
    volumes = 4 * math.pi / 3 * np.diff(edges) * (edges[1:] ** 2 + edges[1:] * edges[:-1] + edges[:-1] ** 2)
    return extinction**2 * _shell_integrals(edges, albedo) / volumes


def absorbed_within(radius: float, extinction: float = 1.0, albedo: float = 0.0) -> float:
    """Share of the power that is absorbed within a distance of the source.

    Parameters
    ----------
    radius : float
        Distance [m].
    extinction : float, default 1.0
        Extinction coefficient [m^-1].
    albedo : float, default 0.0
        Single-scattering albedo c, from 0 to 1 [1].

    Returns
    -------
    float
        (1 - c) times the number of collisions per particle there [1].

    Examples
    --------
    >>> from transport.theory.point_source import absorbed_within
    >>> print(f"{absorbed_within(1.0, 1.0, 0.9):.4g}")
    0.1477
    """
    return float((1 - albedo) * _shell_integrals(np.array([0.0, extinction * radius]), albedo)[0])


def net_flux(radius: float, extinction: float = 1.0, albedo: float = 0.0) -> float:
    """Net share of the power that crosses a sphere about the source, outward minus inward.

    Parameters
    ----------
    radius : float
        Radius of the sphere [m].
    extinction : float, default 1.0
        Extinction coefficient [m^-1].
    albedo : float, default 0.0
        Single-scattering albedo c, from 0 to 1 [1].

    Returns
    -------
    float
        Share that is not absorbed inside [1]; 1 for the albedo 1.

    Notes
    -----
    Computed as the sum of the absorption outside, so that it keeps its relative accuracy far away.

    Examples
    --------
    >>> from transport.theory.point_source import net_flux
    >>> print(f"{net_flux(1.0, 1.0, 0.9):.4g}")
    0.8523
    """
    if albedo == 1:
        return 1.0
    return float((1 - albedo) * _shell_integrals(np.array([extinction * radius, np.inf]), albedo)[0])


def _shell_integrals(edges: np.ndarray, albedo: float) -> np.ndarray:
    """Collisions per particle in each shell [1]: ∫ 4 pi r^2 phi dr; the last edge may be infinite."""
    low, high = edges[:-1], edges[1:]
    direct = -np.exp(-low) * np.expm1(-(high - low))
    if albedo == 0:
        return direct
    kappa, factor = relaxation(float(albedo))
    found = []
    for one, other in zip(low, high, strict=True):
        cut = _integral_over_cut(
            one, albedo, lambda s, one=one, other=other: _shell_integral_of_term(s, one, other)
        )
        found.append(cut + factor * _shell_integral_of_term(np.array(kappa), one, other))
    return direct + np.array(found)


def _shell_integral_of_term(s: np.ndarray, low: float, high: float) -> np.ndarray:
    """∫ r exp(-s r) dr from low to high, without cancellation."""
    from scipy.special import gammainc

    if high == np.inf:
        return np.exp(-s * low) * (1 + s * low) / s**2
    width = high - low
    x = s * width
    safe = np.where(x > 1e-150, x, 1.0)
    flat = np.where(x > 1e-150, -np.expm1(-x) / safe, 1.0)
    rising = np.where(x > 1e-150, gammainc(2, safe) / safe**2, 0.5)
    return np.exp(-s * low) * width * (low * flat + width * rising)


def _integral_over_cut(nearest: float, albedo: float, term) -> float:
    """∫ (g(s) - 1) term(s) ds from 1 on, where term(s) falls at least as fast as exp(-s nearest)."""
    least = max(nearest / _UNDERFLOW, 1e-9)
    if least >= _MAX_T:
        return 0.0
    panels = max(8, math.ceil(4 * math.log(_MAX_T / least)))
    edges = np.geomspace(least, _MAX_T, panels + 1)
    t = edges[:-1, None] + np.diff(edges)[:, None] * (1 + _NODES) / 2
    weights = np.diff(edges)[:, None] / 2 * _WEIGHTS / np.sinh(t) ** 2
    return float((weights * _g_minus_one(t, albedo) * term(1 / np.tanh(t))).sum())


def _g_minus_one(t: np.ndarray, albedo: float) -> np.ndarray:
    """g - 1 at s = coth t: (1 - 1/g) g."""
    angle, tilt = albedo * t * np.tanh(t), (math.pi / 2 * albedo * np.tanh(t)) ** 2
    return (angle * (2 - angle) - tilt) / ((1 - angle) ** 2 + tilt)
