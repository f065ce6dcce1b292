"""Isotropic gas of particles of one speed: flux through a plane, radiance, fluence rate.

n is the density [m^-3], v the speed [m/s]. The particles that cross dA within dt fill the prism v dt
cos(theta) dA (Cornell CS 6620, lecture 2), so that a stream has the flux density n v cos(theta), and
all other quantities are integrals of it.
"""

from __future__ import annotations

import math

import numpy as np


def stream_flux_density(density: float, speed: float, mu: float) -> float:
    """Particle flux density of a parallel stream on a patch.

    Parameters
    ----------
    density : float or ndarray
        Particle density n [m^-3].
    speed : float or ndarray
        Speed v [m/s].
    mu : float or ndarray
        Cosine between the patch's normal and the velocity; for mu < 0 the stream meets the other side
        [1].

    Returns
    -------
    float or ndarray
        ``n v max(mu, 0)`` [m^-2 s^-1].

    Notes
    -----
    Source: Cornell CS 6620, lecture 2; clamp of Akenine-Moeller et al. 2008, eq. 7.5.

    Examples
    --------
    >>> from transport.theory.gas import stream_flux_density
    >>> print(f"{stream_flux_density(2.0, 3.0, 0.5):.4g}")
    3
    """
    return density * speed * np.maximum(mu, 0.0)


def one_way_flux_density(density: float, speed: float) -> float:
    """One-way particle flux density through a plane in an isotropic gas.

    Parameters
    ----------
    density : float
        Particle density n [m^-3].
    speed : float
        Speed v [m/s].

    Returns
    -------
    float
        ``n v / 4`` [m^-2 s^-1].

    Notes
    -----
    Source: Reif 1965, 7.11.

    Examples
    --------
    >>> from transport.theory.gas import one_way_flux_density
    >>> print(f"{one_way_flux_density(2.0, 3.0):.4g}")
    1.5
    """
    return density * speed / 4


def net_flux_density(density: float, speed: float, mean_mu: float = 0.0) -> float:
    """Net particle flux density through a plane: crossings in one direction minus those in the other.

    Parameters
    ----------
    density : float
        Particle density n [m^-3].
    speed : float
        Speed v [m/s].
    mean_mu : float, default 0.0
        Mean cosine between velocity and normal, 0 for an isotropic gas [1].

    Returns
    -------
    float
        ``n v <mu>`` [m^-2 s^-1].

    Notes
    -----
    Source: Reif 1965, 7.11.

    Examples
    --------
    >>> from transport.theory.gas import net_flux_density
    >>> print(f"{net_flux_density(2.0, 3.0, 0.1):.4g}")
    0.6
    """
    return density * speed * mean_mu


def radiance(density: float, speed: float) -> float:
    """Particle radiance of an isotropic gas.

    Parameters
    ----------
    density : float
        Particle density n [m^-3].
    speed : float
        Speed v [m/s].

    Returns
    -------
    float
        ``n v / (4 pi)`` [s^-1 m^-2 sr^-1], because ``M = n v / 4 = pi L``.

    Examples
    --------
    >>> from transport.theory.gas import radiance
    >>> print(f"{radiance(2.0, 3.0):.4g}")
    0.4775
    """
    return density * speed / (4 * math.pi)


def fluence_rate(density: float, speed: float) -> float:
    """Fluence rate (integral of radiance over all directions) of any gas of one speed.

    Parameters
    ----------
    density : float
        Particle density n [m^-3].
    speed : float
        Speed v [m/s].

    Returns
    -------
    float
        ``n v`` [m^-2 s^-1].

    Examples
    --------
    >>> from transport.theory.gas import fluence_rate
    >>> print(f"{fluence_rate(2.0, 3.0):.4g}")
    6
    """
    return density * speed


def flux_in_bin(density: float, speed: float, projected_solid_angle: float) -> float:
    """Flux density of an isotropic gas from a bin of directions.

    Parameters
    ----------
    density : float
        Particle density n [m^-3].
    speed : float
        Speed v [m/s].
    projected_solid_angle : float
        Projected solid angle P of the bin, the integral of cos(theta) d omega, of any shape (see
        solid_angles.py) [sr].

    Returns
    -------
    float
        ``n v / (4 pi) * P`` [m^-2 s^-1]; n v / 4 for the hemisphere, P = pi.

    Examples
    --------
    >>> from transport.theory.gas import flux_in_bin
    >>> print(f"{flux_in_bin(2.0, 3.0, 1.0):.4g}")
    0.4775
    """
    return radiance(density, speed) * projected_solid_angle


def mean_mu_of_crossers() -> float:
    """Mean cosine of the particles that cross a plane one way in an isotropic gas.

    Returns
    -------
    float
        2/3 [1].

    Notes
    -----
    Not 1/2, the mean over the gas's hemisphere of velocities: crossings are weighted by the cosine
    (Reif 1965, 7.11).

    Examples
    --------
    >>> from transport.theory.gas import mean_mu_of_crossers
    >>> print(f"{mean_mu_of_crossers():.4g}")
    0.6667
    """
    return 2 / 3
