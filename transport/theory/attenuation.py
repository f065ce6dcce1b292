"""Attenuation: what is left of light that neither was absorbed nor scattered on its way through a medium.

Along a ray radiance falls by exp(-tau), tau the integral of the extinction along it (Bouguer 1729; Beer 1852):
what is left never collided.  Everything here is an integral of that over directions.  tau is the optical depth
straight through, mu the cosine to the straight way, so that a slanted ray has tau/mu before it.  Integrals over
directions are exponential integrals, E_n(tau) = ∫ mu^(n-2) exp(-tau/mu) dmu over mu from 0 to 1 (Chandrasekhar
1960, appendix I).

Radiance L in W m^-2 sr^-1, lengths in m, extinction in m^-1.  In a purely absorbing medium the values are those
of all light; where light is scattered, those of the direct part.
"""

from __future__ import annotations

import math

import numpy as np

from transport.theory.nodes import legendre_nodes

_NODES, _WEIGHTS = legendre_nodes(64)
_SERIES = 40  # terms: in units of the first, the last is below 1e-40


def transmittance(tau: float) -> float:
    """Share of a beam that gets through the optical depth tau uncollided [1]: exp(-tau).  Vectorised."""
    return np.exp(-np.asarray(tau, dtype=float))[()]


def exponential_integral(order: int, tau: float) -> float:
    """E_n(tau) [1], n from 0 on: ∫ exp(-tau t) / t^n dt over t from 1 on (DLMF 8.19.3).  Vectorised over tau >=
    0."""
    from scipy.special import expn

    return expn(order, tau)


def lambertian_transmission(tau: float) -> float:
    """Share of diffuse light that gets through a slab uncollided [1]: 2 E3(tau).  Vectorised."""
    return 2 * exponential_integral(3, tau)


def slab_escape(tau: float) -> float:
    """Share of what a slab emits, evenly and isotropically, that leaves it uncollided on either side [1].

    tau: above 0.  (1 - 2 E3(tau)) / (2 tau), as (E2(tau) + (1 - exp(-tau))/tau) / 2, in which nothing cancels.
    Vectorised.  Source: integral of E2 over the depth (Case, de Hoffmann, Placzek 1953, 10).
    """
    tau = np.asarray(tau, dtype=float)
    return ((exponential_integral(2, tau) - np.expm1(-tau) / tau) / 2)[()]


def sphere_escape(radii: float) -> float:
    """Share of what a ball emits, evenly and isotropically, that leaves it uncollided [1].

    radii: x above 0, the ball's radius times its extinction.  3/(8 x^3) [2 x^2 - 1 + (1 + 2 x) exp(-2 x)]
    (Case, de Hoffmann, Placzek 1953, 10), below x = 1 by its series.  Vectorised.
    """
    x = np.asarray(radii, dtype=float)
    y = 2 * np.maximum(x, 1.0)
    closed = 3 / y**3 * (y * y / 2 - 1 + (1 + y) * np.exp(-y))
    y, terms = 2 * np.minimum(x, 1.0), np.zeros_like(x)
    for k in range(_SERIES, 2, -1):
        terms = (-1) ** (k + 1) * (k - 1) / math.factorial(k) + y * terms
    return np.where(x < 1, 3 * terms, closed)[()]


def mean_slant_transmittance(tau: float, low: float, high: float) -> float:
    """Mean of exp(-tau/mu) over the cosines low to high, weighted with mu [1]: what a bin of radiance holds.

    0 <= low < high <= 1.  Vectorised.  Source: 2 ∫ mu exp(-tau/mu) dmu / (high^2 - low^2).
    """
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    return (2 * slant_integral(tau, low, high) / ((high - low) * (high + low)))[()]


def slant_integral(tau: float, low: float, high: float) -> float:
    """∫ mu exp(-tau/mu) dmu from low to high [1], 0 <= low <= high <= 1; E3(tau) over all of them.  Vectorised.

    high^2 E3(tau/high) - low^2 E3(tau/low), and by quadrature where these would cancel.
    """
    tau, low, high = (np.asarray(x, dtype=float) for x in (tau, low, high))
    wide = low < high / 2
    bottom = np.where(low > 0, low, 1.0)
    far = np.where(low > 0, low**2 * exponential_integral(3, tau / bottom), 0.0)
    closed = high**2 * exponential_integral(3, tau / high) - far
    start = np.where(wide, high / 2, low)
    mu = start[..., None] + (high - start)[..., None] * (1 + _NODES) / 2
    summed = (mu * np.exp(-tau[..., None] / mu)) @ _WEIGHTS * (high - start) / 2
    return np.where(wide, closed, summed)[()]


def disk_irradiance(radiance: float, radius: float, distance: float, tau: float, meter: float = 0.0) -> float:
    """Irradiance by a Lambert disk on a coaxial meter that faces it through fog [W m^-2], the mean over it.

    tau: optical depth of the fog between the two, that lies evenly between parallel planes; meter: its radius
    [m]. On the axis 2 pi L ∫ mu exp(-tau/mu) dmu over the disk.  Over a meter the pairs of points that are the
    vector s apart sideways are as many as two disks overlap that are shifted by s: one integral is left (of
    autocorrelation).
    """
    small, large = sorted((radius, meter))
    if small == 0:
        return 2 * math.pi * radiance * slant_integral(tau, distance / math.hypot(distance, large), 1.0)
    whole = slant_integral(tau, distance / math.hypot(distance, large - small), 1.0)
    angle = math.pi * (1 + _NODES) / 2
    shift = large - small * np.cos(angle)
    slant = np.hypot(distance, shift)
    parts = _overlap(large, small, shift) / (math.pi * small**2) * shift * small * np.sin(angle)
    rim = parts * (distance / slant**2) ** 2 * np.exp(-tau * slant / distance) @ _WEIGHTS * math.pi / 2
    return 2 * math.pi * radiance * float(whole + rim) * (small / meter) ** 2


def disk_radiance(
    theta: float, radiance: float, radius: float, distance: float, tau: float, meter: float
) -> np.ndarray:
    """Radiance that arrives from a Lambert disk at the angles theta [rad] through fog, the mean over a coaxial
    meter.

    L exp(-tau/cosθ) as long as the disk is met from all of the meter, then falling as the two overlap, seen
    along the ray, to 0 [W m^-2 sr^-1].  meter: its radius, above 0 [m].  Vectorised over theta from 0 to below
    pi/2.
    """
    theta = np.asarray(theta, dtype=float)
    shift, (small, large) = distance * np.tan(theta), sorted((radius, meter))
    partly = (shift > large - small) & (shift < large + small)
    rim = _overlap(large, small, np.where(partly, shift, large))
    area = np.where(partly, rim, np.where(shift < large, math.pi * small**2, 0.0))
    return radiance * np.exp(-tau / np.cos(theta)) * area / (math.pi * meter**2)


def _overlap(large: float, small: float, shift: np.ndarray) -> np.ndarray:
    """Area that two disks share whose middles are that far apart: two segments over the common chord."""
    sides = (shift + large + small, small + shift - large, shift - small + large, large + small - shift)
    chord = np.sqrt(np.maximum(math.prod(sides), 0.0)) / (2 * shift)  # half of it, Heron
    area = 0.0
    for own, other in ((large, small), (small, large)):
        # Foot of the chord seen from the middle; negative where it lies beyond the middle.
        foot = (shift * shift + (own - other) * (own + other)) / (2 * shift)
        area = area + own**2 * np.arctan2(chord, foot) - chord * foot
    return area


def cone_transmittance(tau: float, zenith_angle: float, half_angle: float) -> float:
    """Mean of exp(-tau/cosθ) over a narrow cone of directions, weighted with the cosine to its axis [1].

    tau: from the ground to the zenith; zenith_angle: of the cone's axis, with half_angle below pi/2 [rad].  For
    the sun through a flat atmosphere: exp(-tau secθ) (Bouguer 1729), and the spread of secθ over its disk.
    """
    inner = np.cos(half_angle) + (1 - np.cos(half_angle)) * (1 + _NODES) / 2
    azimuth = (np.arange(32) + 0.5) * math.pi / 32
    across = np.sqrt((1 - inner) * (1 + inner))[:, None] * np.cos(azimuth)
    cosine = inner[:, None] * math.cos(zenith_angle) + across * math.sin(zenith_angle)
    weights = inner * _WEIGHTS
    return float(weights @ np.exp(-tau / cosine).mean(axis=1) / weights.sum())


def ball_transmittance(diameters: float, low: float = 0.0, high: float = 1.0) -> float:
    """Mean of exp(-x mu) over the cosines low to high, weighted with mu [1]: light across a ball, seen from its
    wall.

    diameters: x, the ball's diameter times its extinction; a chord at the cosine mu to the normal is mu
    diameters long.  Over all cosines 2 (1 - (1 + x) exp(-x)) / x^2.  Vectorised over bins of cosine.
    """
    low, high = (np.asarray(x, dtype=float)[..., None] for x in (low, high))
    mu = low + (high - low) * (1 + _NODES) / 2
    weights = mu * _WEIGHTS
    return ((weights * np.exp(-diameters * mu)).sum(axis=-1) / weights.sum(axis=-1))[()]
