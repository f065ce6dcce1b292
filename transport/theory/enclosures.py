"""Closed enclosures with diffuse walls: what is exact without solving for the radiosity.

Irradiance E (what falls on a wall), exitance M (what it emits and reflects: its radiosity), albedo rho.
Everything that a wall reflects falls on a wall again, so that sums over all walls are exact for any shape;
point by point only a uniform enclosure and a sphere are.
"""

from __future__ import annotations

import math

import numpy as np


def absorbed_power(albedos, fluxes_in) -> float:
    """Power that the walls take up [W]: sum of (1 - rho_i) Phi_i, in a closed enclosure all that is
    emitted."""
    return float(np.sum((1 - np.asarray(albedos, dtype=float)) * np.asarray(fluxes_in, dtype=float)))


def total_flux_in(power: float, albedo: float) -> float:
    """Flux on all walls together, all of one albedo [W]: P / (1 - rho), wherever and however P is emitted.

    The geometric series of reflections; over P it is the mean number of wall hits of a particle.
    """
    return power / (1 - albedo)


def mean_irradiance(power: float, albedo: float, area: float) -> float:
    """Irradiance averaged over all walls of one albedo [W m^-2]: P / ((1 - rho) A)."""
    return total_flux_in(power, albedo) / area


def emitted_exitance(exitance: float, irradiance: float, albedo: float) -> float:
    """What a diffuse wall emits by itself [W m^-2]: M - rho E (Goral et al. 1984, the radiosity equation)."""
    return exitance - albedo * irradiance


def furnace_irradiance(emitted: float, albedo: float) -> float:
    """Irradiance everywhere in an enclosure of walls that all emit M0 and reflect rho [W m^-2]: M0 / (1 -
    rho).

    The exitance is the same, so that no shape can be told by looking inside (Kirchhoff 1860).
    """
    return emitted / (1 - albedo)


def furnace_radiance(emitted: float, albedo: float) -> float:
    """Radiance at every point and in every direction of that furnace [W m^-2 sr^-1]: M0 / (pi (1 - rho))."""
    return furnace_irradiance(emitted, albedo) / math.pi


def sphere_wall_exitance(power: float, albedo: float, area: float, port_share: float = 0.0) -> float:
    """Exitance of an integrating sphere's wall by reflection [W m^-2]: rho / (1 - rho (1 - f)) * P / A.

    power: what first strikes the wall; area: the whole sphere's; port_share: f, the share of it that only
    absorbs. Uniform, as a patch of a sphere lights all others alike (Ulbricht 1900; Goebel 1967).
    """
    return albedo / (1 - albedo * (1 - port_share)) * power / area


def sphere_irradiance_of_wall_patch(power: float, albedo: float, area: float) -> float:
    """Irradiance anywhere in a closed diffuse sphere lit by a Lambertian patch of its wall [W m^-2].

    P / ((1 - rho) A): the mean is the value at each point, as the direct light is uniform too (Ulbricht
    1900).
    """
    return mean_irradiance(power, albedo, area)
