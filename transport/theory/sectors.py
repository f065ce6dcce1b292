"""A diffuse disk seen from a point by sectors of azimuth: how its light is spread over directions.

The disk, of radius R, is parallel to the receiver at the distance d, its middle at s > R from the receiver's axis and
at the azimuth 0.  Within |φ| < asin(R/s) a half plane of azimuth φ cuts it from ρ₁ to ρ₂ = s cosφ ± √(R² − s² sin²φ), and
∫ L cosθ dω = (L/2) ∫ (sin²θ₂ − sin²θ₁) dφ with sin²θ = ρ² / (ρ² + d²).
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
    """Projected solid angle of the part of the disk in each bin of azimuth, (bins,) [sr].

    phi_edges: from the middle of the disk [rad], within −π to π.  φ = asin(R/s sin ψ) is smooth up to the disk's rim;
    Gauss-Legendre over ψ.
    """
    return _over_sectors(phi_edges, radius, offset, distance, 1)


def squared_weights_in(phi_edges: np.ndarray, radius: float, offset: float, distance: float) -> np.ndarray:
    """∫ G² dA over the disk's part in each bin of azimuth, G = cosθ cosθ' / r², (bins,) [sr^2 m^-2].

    It tells the spread of the weights that an aim at the receiver gives to particles that are born all over the disk.
    """
    return _over_sectors(phi_edges, radius, offset, distance, 2)


def projected_solid_angle_a_radian(phi: float, radius: float, offset: float, distance: float) -> float:
    """Projected solid angle of the disk for a radian of azimuth, at the azimuth φ [sr/rad].  Vectorised."""
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
    """Mean radiance over sectors of azimuth from low to high [W m^-2 sr^-1], counted by rays aimed at the receiver.

    mu_range: cosines between which the sectors lie, and all disks;  middles: azimuths of the disks, to each of which
    an equal number of histories belongs, born all over it.
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
    """Where the half plane enters and leaves the disk [m from the axis]; half_chord in radii."""
    return offset * cosine - radius * half_chord, offset * cosine + radius * half_chord


def _along_ray(near, far, distance, power):
    """∫ G^power ρ dρ from near to far: with q = cos²θ, (q₁ − q₂)/2 or (q₁³ − q₂³) / 6d²."""
    q1, q2 = (distance**2 / (rho**2 + distance**2) for rho in (near, far))
    if power == 1:
        return (q1 - q2) / 2
    return (q1 - q2) * (q1 * q1 + q1 * q2 + q2 * q2) / (6 * distance**2)
