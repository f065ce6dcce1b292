"""Closed enclosures with diffuse walls: relations that do not require the radiosity equation.

Irradiance E falls on a wall; exitance M, emitted plus reflected, is its radiosity; rho is the albedo.
All reflected light falls on a wall again, so that sums over all walls are exact for any shape.
Pointwise relations are exact only for a uniform enclosure and for a sphere.
"""

from __future__ import annotations

import math

import numpy as np


def absorbed_power(albedos, fluxes_in) -> float:
    """Power absorbed by the walls of an enclosure.

    Parameters
    ----------
    albedos : array_like
        Albedo of each wall, shape (walls,) [1].
    fluxes_in : array_like
        Flux onto each wall, shape (walls,) [W].

    Returns
    -------
    float
        Sum of ``(1 - rho_i) Phi_i`` [W]; in a closed enclosure it equals the emitted power.

    Examples
    --------
    >>> from transport.theory.enclosures import absorbed_power
    >>> print(f"{absorbed_power([0.5, 0.8], [1.0, 2.0]):.4g}")
    0.9
    """
    return float(np.sum((1 - np.asarray(albedos, dtype=float)) * np.asarray(fluxes_in, dtype=float)))


def total_flux_in(power: float, albedo: float) -> float:
    """Flux onto all walls together, for walls of one albedo.

    Parameters
    ----------
    power : float
        Emitted power P [W].
    albedo : float
        Albedo rho of all walls, below 1 [1].

    Returns
    -------
    float
        ``P / (1 - rho)`` [W], for any shape and any emission.

    Notes
    -----
    The geometric series of reflections. Over P it is the mean number of wall hits per particle.

    Examples
    --------
    >>> from transport.theory.enclosures import total_flux_in
    >>> print(f"{total_flux_in(1.0, 0.9):.4g}")
    10
    """
    return power / (1 - albedo)


def mean_irradiance(power: float, albedo: float, area: float) -> float:
    """Irradiance averaged over all walls, for walls of one albedo.

    Parameters
    ----------
    power : float
        Emitted power P [W].
    albedo : float
        Albedo rho of all walls, below 1 [1].
    area : float
        Area A of all walls [m^2].

    Returns
    -------
    float
        ``P / ((1 - rho) A)`` [W m^-2].

    Examples
    --------
    >>> from transport.theory.enclosures import mean_irradiance
    >>> print(f"{mean_irradiance(1.0, 0.9, 6.0):.4g}")
    1.667
    """
    return total_flux_in(power, albedo) / area


def emitted_exitance(exitance: float, irradiance: float, albedo: float) -> float:
    """Exitance that a diffuse wall emits by itself.

    Parameters
    ----------
    exitance : float
        Exitance M, emitted plus reflected [W m^-2].
    irradiance : float
        Irradiance E [W m^-2].
    albedo : float
        Albedo rho of the wall [1].

    Returns
    -------
    float
        ``M - rho E`` [W m^-2].

    Notes
    -----
    Source: the radiosity equation (Goral et al. 1984).

    Examples
    --------
    >>> from transport.theory.enclosures import emitted_exitance
    >>> print(f"{emitted_exitance(2.0, 3.0, 0.5):.4g}")
    0.5
    """
    return exitance - albedo * irradiance


def furnace_irradiance(emitted: float, albedo: float) -> float:
    """Irradiance in a furnace: all walls emit the same exitance and have the same albedo.

    Parameters
    ----------
    emitted : float
        Exitance M0 that every wall emits by itself [W m^-2].
    albedo : float
        Albedo rho of all walls, below 1 [1].

    Returns
    -------
    float
        ``M0 / (1 - rho)`` [W m^-2], uniform.

    Notes
    -----
    The exitance is the same, so that the shape is invisible from inside (Kirchhoff 1860).

    Examples
    --------
    >>> from transport.theory.enclosures import furnace_irradiance
    >>> print(f"{furnace_irradiance(1.0, 0.5):.4g}")
    2
    """
    return emitted / (1 - albedo)


def furnace_radiance(emitted: float, albedo: float) -> float:
    """Radiance at every point and in every direction of a furnace.

    Parameters
    ----------
    emitted : float
        Exitance M0 that every wall emits by itself [W m^-2].
    albedo : float
        Albedo rho of all walls, below 1 [1].

    Returns
    -------
    float
        ``M0 / (pi (1 - rho))`` [W m^-2 sr^-1].

    Examples
    --------
    >>> from transport.theory.enclosures import furnace_radiance
    >>> print(f"{furnace_radiance(1.0, 0.5):.4g}")
    0.6366
    """
    return furnace_irradiance(emitted, albedo) / math.pi


def sphere_wall_exitance(power: float, albedo: float, area: float, port_share: float = 0.0) -> float:
    """Exitance by reflection of an integrating sphere's wall.

    Parameters
    ----------
    power : float
        Power P that first strikes the wall [W].
    albedo : float
        Albedo rho of the wall [1].
    area : float
        Area A of the whole sphere [m^2].
    port_share : float, default 0.0
        Share f of the sphere's area that only absorbs [1].

    Returns
    -------
    float
        ``rho / (1 - rho (1 - f)) * P / A`` [W m^-2].

    Notes
    -----
    Uniform, because a patch of a sphere irradiates all others equally (Ulbricht 1900; Goebel 1967).

    Examples
    --------
    >>> from transport.theory.enclosures import sphere_wall_exitance
    >>> print(f"{sphere_wall_exitance(1.0, 0.9, 1.0, 0.05):.4g}")
    6.207
    """
    return albedo / (1 - albedo * (1 - port_share)) * power / area


def sphere_irradiance_of_wall_patch(power: float, albedo: float, area: float) -> float:
    """Irradiance in a closed diffuse sphere lit by a Lambertian patch of its wall.

    Parameters
    ----------
    power : float
        Emitted power P [W].
    albedo : float
        Albedo rho of all walls, below 1 [1].
    area : float
        Area A of the sphere [m^2].

    Returns
    -------
    float
        ``P / ((1 - rho) A)`` [W m^-2], at every point.

    Notes
    -----
    The mean is the value at each point because the direct light is uniform too (Ulbricht 1900).

    Examples
    --------
    >>> from transport.theory.enclosures import sphere_irradiance_of_wall_patch
    >>> print(f"{sphere_irradiance_of_wall_patch(1.0, 0.9, 1.0):.4g}")
    10
    """
    return mean_irradiance(power, albedo, area)
