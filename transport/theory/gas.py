"""The isotropic gas: what crosses a plane in a gas of equal speeds.

n is the density [m^-3], v the speed [m/s].  The prism v dt cos(theta) dA holds the particles that cross dA
within dt (Cornell CS 6620, lecture 2), so that a stream carries n v cos(theta) and everything else is an
integral of it.
"""

from __future__ import annotations

import math

import numpy as np


def stream_flux_density(density: float, speed: float, mu: float) -> float:
    """Particle flux density of a parallel stream on a patch [m^-2 s^-1]: n v max(mu, 0).

    mu: cosine between the patch's normal and the velocity; at mu < 0 the stream meets the other side.
    Vectorised.  Source: Cornell CS 6620, lecture 2; clamp of Akenine-Moeller et al. 2008, eq. 7.5.
    """
    return density * speed * np.maximum(mu, 0.0)


def one_way_flux_density(density: float, speed: float) -> float:
    """One-way particle flux density through a plane in an isotropic gas [m^-2 s^-1]: n v / 4 (Reif 1965,
    7.11)."""
    return density * speed / 4


def net_flux_density(density: float, speed: float, mean_mu: float = 0.0) -> float:
    """Particles through a plane in both directions, the second counted negative [m^-2 s^-1]: n v <mu>.

    mean_mu: mean cosine between velocity and normal, 0 for an isotropic gas.  Source: Reif 1965, 7.11.
    """
    return density * speed * mean_mu


def radiance(density: float, speed: float) -> float:
    """Radiance of an isotropic gas, in particles [s^-1 m^-2 sr^-1]: n v / (4 pi), as M = n v / 4 = pi L."""
    return density * speed / (4 * math.pi)


def fluence_rate(density: float, speed: float) -> float:
    """Fluence rate (integral of radiance over all directions) of any gas of one speed [m^-2 s^-1]: n v."""
    return density * speed


def flux_in_bin(density: float, speed: float, projected_solid_angle: float) -> float:
    """Flux density that an isotropic gas brings from a bin of directions [m^-2 s^-1]: n v / (4 pi) * P.

    projected_solid_angle: P, the bin's integral of cos(theta) d omega [sr], of any shape (see
    solid_angles.py); the whole hemisphere, P = pi, gives n v / 4.
    """
    return radiance(density, speed) * projected_solid_angle


def mean_mu_of_crossers() -> float:
    """Mean cosine of the particles that cross a plane one way in an isotropic gas [1]: 2/3.

    Not 1/2, the mean over the gas's own hemisphere: crossings are weighted by the cosine (Reif 1965, 7.11).
    """
    return 2 / 3
