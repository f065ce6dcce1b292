"""Irradiance from the simplest emitters: a Lambert disk, a Lambert sphere, an isotropic point.

Radiance L in W m^-2 sr^-1 (or particles), lengths in m, mu is the cosine of the receiver's tilt.  All
vectorised.
"""

from __future__ import annotations

import math

import numpy as np

from transport.theory.cones import projected_cone
from transport.theory.view_factors import coaxial_disks


def lambert_power(radiance: float, area: float) -> float:
    """Power that one side of a diffuse emitter gives off [W]: P = pi L A (Cornell CS 6620, lecture 2)."""
    return math.pi * radiance * area


def disk_irradiance(radiance: float, radius: float, distance: float, offset: float = 0.0) -> float:
    """Irradiance by a Lambert disk on a patch parallel to it [W m^-2]; on the axis pi L R^2 / (R^2 + d^2).

    distance: d > 0 from the disk's plane; offset: x >= 0 from its axis.
    E = (pi/2) L [1 - T/S], T = x^2 + d^2 - R^2, S^2 = (x^2 + d^2 + R^2)^2 - 4 x^2 R^2 (Foote 1915, Bull.
    Bur. Stand. 12, 583; Walsh 1958).  S is the product of the distances to the rim's nearest and farthest
    point, and S^2 - T^2 = 4 R^2 d^2: so nothing cancels, neither far away nor next to the rim.
    """
    near = np.hypot(distance, offset - radius)
    far = np.hypot(distance, offset + radius)
    t = (offset - radius) / near * ((offset + radius) / far) + distance / near * (distance / far)
    outside = 2 * math.pi * (radius / far * (distance / near)) ** 2 / (1 + np.maximum(t, 0.0))
    return radiance * np.where(t > 0, outside, math.pi / 2 * (1 - t))[()]


def mean_disk_irradiance(
    radiance: float, source_radius: float, receiver_radius: float, distance: float
) -> float:
    """Mean irradiance over a disk that faces a coaxial Lambert disk [W m^-2]: pi L F(receiver -> source).

    Source: reciprocity and coaxial_disks (Howell, C-41).
    """
    return math.pi * radiance * coaxial_disks(receiver_radius, source_radius, distance)


def sphere_irradiance(radiance: float, radius: float, distance: float, mu: float = 1.0) -> float:
    """Irradiance by a Lambert sphere at distance d > R from its centre [W m^-2]: pi L (R/d)^2 mu.

    mu: cosine between the receiver's normal and the direction of the centre.  The plain law holds while the
    whole sphere is above the receiver's horizon (mu >= R/d); else the part above it counts (cones.py).
    Raises ValueError for d < R.  Source: Lambert 1760; Howell's catalogue, element to sphere.
    """
    if np.any(np.less(distance, radius)):
        raise ValueError(f"distance must be at least the sphere's radius {radius}, got {distance}")
    cosine = np.sqrt(np.subtract(distance, radius) / distance * (np.add(distance, radius) / distance))
    return radiance * projected_cone(np.divide(radius, distance), cosine, mu)


def point_irradiance(power: float, distance: float, mu: float = 1.0) -> float:
    """Irradiance by an isotropic point source [W m^-2]: P max(mu, 0) / (4 pi d^2) (Lambert 1760).

    Exact for a uniform Lambert sphere too, distances from its centre, while all of it is above the horizon.
    """
    return power * np.maximum(mu, 0.0) / (4 * math.pi) / distance / distance


def point_flux_through_disk(power: float, radius: float, distance: float) -> float:
    """Power of an isotropic point source through a coaxial disk [W]: (P/2) (1 - d / sqrt(d^2 + a^2)).

    Computed as (P/2) a^2 / (h (h + d)), h = sqrt(d^2 + a^2).  Also the power of a Lambert sphere around the
    point that stays in front of the disk's plane (Howell, C-136).
    """
    slant = np.hypot(distance, radius)
    return power / 2 * (radius / slant) * (radius / (slant + distance))


def mean_point_irradiance(power: float, radius: float, distance: float) -> float:
    """Mean irradiance over a coaxial disk that faces an isotropic point source [W m^-2]: flux / (pi a^2)."""
    slant = np.hypot(distance, radius)
    return power / (2 * math.pi) / slant / (slant + distance)


def disk_over_inverse_square(widths: float) -> float:
    """Irradiance on a Lambert disk's axis over pi L R^2/d^2, its inverse-square law [1]: 1 / (1 + (R/d)^2).

    widths: d over the diameter.  At 5 it is 1/1.01: the five-times rule (Lambert 1760, cited by
    Akenine-Moeller et al. 2008, 7.1).  For a sphere the ratio is exactly 1, distances from its centre.
    """
    return 1 / (1 + np.square(0.5 / widths))


def disk_inverse_square_error(widths: float) -> float:
    """Relative error of the inverse-square law on a Lambert disk's axis [1]: (R/d)^2 = 1 / (2 widths)^2.

    It is too large by exactly 1 % at 5 widths.
    """
    return np.square(0.5 / widths)


def strip_over_inverse_square(widths: float) -> float:
    """The same ratio for a thin Lambert strip, distance over its length [1].

    (1/(1 + t^2) + atan(t)/t) / 2, t = 0.5/widths.
    Source: the integral of cos^4 / d^2 along the strip, cosines at source and receiver.
    """
    t = 0.5 / widths
    return (1 / (1 + t * t) + np.arctan(t) / t) / 2
