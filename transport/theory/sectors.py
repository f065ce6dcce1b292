"""A diffuse disk seen from a point in sectors of azimuth: distribution of its light over directions.

The disk, of radius R, is parallel to the receiver at the distance d; its center is at the distance
s > R from the receiver's axis and at the azimuth 0. For ``|φ| < asin(R/s)`` the half plane of azimuth φ
cuts it from ρ₁ to ρ₂ = s cosφ ± √(R² − s² sin²φ), and ∫ L cosθ dω = (L/2) ∫ (sin²θ₂ − sin²θ₁) dφ with
sin²θ = ρ² / (ρ² + d²).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from transport.theory.counting import Moments
from transport.theory.nodes import legendre_nodes

NODES = 24


def projected_solid_angle_in(
    phi_edges: np.ndarray, radius: float, offset: float, distance: float
) -> np.ndarray:
    """Projected solid angle of the part of the disk in each bin of azimuth.

    Parameters
    ----------
    phi_edges : ndarray
        Edges of the bins of azimuth from the disk's center, within −π to π, shape (bins + 1,) [rad].
    radius : float
        Radius R of the disk [m].
    offset : float
        Distance s of the disk's center from the receiver's axis, above R [m].
    distance : float
        Distance d between the planes [m].

    Returns
    -------
    ndarray
        Projected solid angles, shape (bins,) [sr].

    Raises
    ------
    ValueError
        If the offset does not exceed the radius.

    Notes
    -----
    Gauss-Legendre over ψ with ``φ = asin(R/s sin ψ)``, in which the integrand is smooth up to the rim.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.sectors import projected_solid_angle_in
    >>> print(projected_solid_angle_in(np.array([-0.5, 0.0, 0.5]), 1.0, 2.0, 2.0).round(4))
    [0.1022 0.1022]
    """
    return _over_sectors(phi_edges, radius, offset, distance, 1)


def squared_weights_in(phi_edges: np.ndarray, radius: float, offset: float, distance: float) -> np.ndarray:
    """Integral of G² over the part of the disk in each bin of azimuth, G = cosθ cosθ' / r².

    Parameters
    ----------
    phi_edges : ndarray
        Edges of the bins of azimuth from the disk's center, within −π to π, shape (bins + 1,) [rad].
    radius : float
        Radius R of the disk [m].
    offset : float
        Distance s of the disk's center from the receiver's axis, above R [m].
    distance : float
        Distance d between the planes [m].

    Returns
    -------
    ndarray
        ``∫ G² dA``, shape (bins,) [sr^2 m^-2].

    Raises
    ------
    ValueError
        If the offset does not exceed the radius.

    Notes
    -----
    It determines the variance of the weights of particles that are born uniformly over the disk and
    aimed at the receiver.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.sectors import squared_weights_in
    >>> print(squared_weights_in(np.array([-0.5, 0.0, 0.5]), 1.0, 2.0, 2.0).round(4))
    [0.0084 0.0084]
    """
    return _over_sectors(phi_edges, radius, offset, distance, 2)


def projected_solid_angle_a_radian(phi: float, radius: float, offset: float, distance: float) -> float:
    """Projected solid angle of the disk per radian of azimuth.

    Parameters
    ----------
    phi : float or ndarray
        Azimuth φ from the disk's center [rad].
    radius : float
        Radius R of the disk [m].
    offset : float
        Distance s of the disk's center from the receiver's axis, above R [m].
    distance : float
        Distance d between the planes [m].

    Returns
    -------
    float or ndarray
        Projected solid angle per azimuth [sr/rad].

    Examples
    --------
    >>> from transport.theory.sectors import projected_solid_angle_a_radian
    >>> print(f"{projected_solid_angle_a_radian(0.1, 1.0, 2.0, 2.0):.4g}")
    0.2424
    """
    sine = np.minimum(offset / radius * np.abs(np.sin(phi)), 1.0)
    near, far = _cuts(np.cos(phi), np.sqrt(1 - sine**2), radius, offset)
    return _along_ray(near, far, distance, 1)


def sector_moments(
    low: np.ndarray,
    high: np.ndarray,
    mu_range: tuple[float, float],
    middles: Sequence[float],
    radiance: float,
    radius: float,
    offset: float,
    distance: float,
) -> Moments:
    """Moments of the mean radiance over sectors of azimuth, counted by rays aimed at the receiver.

    Parameters
    ----------
    low : ndarray
        Lower azimuth of each sector, shape (n,) [rad].
    high : ndarray
        Upper azimuth of each sector, shape (n,) [rad].
    mu_range : tuple of 2 float
        Range of cosines of the sectors, which contains all disks [1].
    middles : sequence of float
        Azimuths of the disks' centers; each disk has an equal number of histories, born uniformly over
        it [rad].
    radiance : float
        Radiance L of the disks [W m^-2 sr^-1].
    radius : float
        Radius R of the disk [m].
    offset : float
        Distance s of the disk's center from the receiver's axis, above R [m].
    distance : float
        Distance d between the planes [m].

    Returns
    -------
    Moments
        Means [W m^-2 sr^-1] and the terms of their variances, shape (n,).

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.sectors import sector_moments
    >>> disk = (1.0, 2.0, 2.0)
    >>> print(sector_moments(np.array([-0.5]), np.array([0.5]), (0.0, 1.0), [0.0], 1.0, *disk).mean.round(4))
    [0.4089]
    """
    disk, area = (radius, offset, distance), math.pi * radius**2
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    solid_angle = (high - low) * (mu_range[1] ** 2 - mu_range[0] ** 2) / 2
    parts = np.zeros((3, len(low)))
    for middle in middles:
        edges = list(zip(low - middle, high - middle, strict=True))
        first = (
            np.array([projected_solid_angle_in(pair, *disk)[0] for pair in edges]) * radiance / solid_angle
        )
        second = np.array([squared_weights_in(pair, *disk)[0] for pair in edges])
        second *= (radiance / solid_angle) ** 2 * area
        parts += np.array([first, len(middles) * second, len(middles) * first**2])
    return Moments(*parts)


def _over_sectors(phi_edges, radius, offset, distance, power):
    if not offset > radius:
        raise ValueError(f"offset must exceed the disk's radius {radius}, got {offset}")
    slope = radius / offset
    sines = np.sin(np.clip(phi_edges, -math.asin(slope), math.asin(slope))) / slope
    psi = np.arcsin(np.clip(sines, -1.0, 1.0))
    x, weight = legendre_nodes(NODES)
    half = np.diff(psi)[:, None] / 2
    nodes = (psi[1:] + psi[:-1])[:, None] / 2 + half * x
    cosine = np.sqrt(1 - (slope * np.sin(nodes)) ** 2)  # of φ
    near, far = _cuts(cosine, np.cos(nodes), radius, offset)
    return (_along_ray(near, far, distance, power) * slope * np.cos(nodes) / cosine * half) @ weight


def _cuts(cosine, half_chord, radius, offset):
    """Distances from the axis at which the half plane enters and leaves the disk [m]; half_chord in radii."""
    return offset * cosine - radius * half_chord, offset * cosine + radius * half_chord


def _along_ray(near, far, distance, power):
    """∫ G^power ρ dρ from near to far: with q = cos²θ, (q₁ − q₂)/2 or (q₁³ − q₂³) / 6d²."""
    q1, q2 = (distance**2 / (rho**2 + distance**2) for rho in (near, far))
    if power == 1:
        return (q1 - q2) / 2
    return (q1 - q2) * (q1 * q1 + q1 * q2 + q2 * q2) / (6 * distance**2)
