"""Pressure: the momentum that particles bring to a wall and take away from it, per area and time.

A stream has a momentum flux: n m v^2 of particles of mass m and speed v, and of light its energy density u, as the
momentum is w/c.  A wall that it meets at the cosine mu receives mu^2 of it: one cosine for how many come, one for the
component that pushes.  Over an isotropic gas <mu^2> = 1/3, half of it on the way in.  What leaves adds its own: from a
mirror as much as came, from a black wall nothing, from a diffuse wall of albedo 1 the cosine law's 2/3 of the momentum
(Reif 1965, 7.13; for light Maxwell 1873, art. 792; Boltzmann 1884).
"""

from __future__ import annotations

from transport.units import BOLTZMANN

_ISOTROPIC = {"mirror": 1.0, "diffuse": 1.0, "black": 0.5}  # of the pressure inside


def light_pressure(energy_density: float, wall: str = "mirror") -> float:
    """Pressure of isotropic light of this energy density [J m^-3] on a wall [Pa]: u/3, on a black one u/6."""
    return isotropic_pressure(energy_density / 3, wall)


def gas_pressure(density: float, temperature: float, wall: str = "mirror") -> float:
    """Pressure of a gas of this density [m^-3] and temperature [K] on a wall [Pa]: n k T, on a black one half of it."""
    return isotropic_pressure(density * BOLTZMANN * temperature, wall)


def kinetic_pressure(density: float, mass: float, mean_square_speed: float) -> float:
    """Pressure of an isotropic gas by its speeds [Pa]: n m <v^2>/3; the mean of the squares, not the mean's square."""
    return density * mass * mean_square_speed / 3


def isotropic_pressure(inside: float, wall: str = "mirror") -> float:
    """Pressure on a wall of what is isotropic and has the pressure `inside` in its interior [Pa].

    wall: a "black" one feels the half that comes in.  A "mirror" returns its mirror image, and a "diffuse" one of
    albedo 1 the cosine law, which is just what an isotropic gas brings: the whole.
    """
    return _ISOTROPIC[wall] * inside


def stream_pressure(momentum_flux: float, mu: float = 1.0, wall: str = "black") -> float:
    """Pressure of a parallel stream on a wall [Pa].  momentum_flux: along the stream, n m v^2, or u for light [Pa].

    mu: cosine between the stream and the wall's normal.  On a "black" wall mu^2 of it, on a "mirror" twice that, on a
    "diffuse" one of albedo 1, which sends all back by the cosine law, mu (mu + 2/3).
    """
    leaving = {"mirror": mu, "diffuse": 2 / 3, "black": 0.0}[wall]
    return momentum_flux * mu * (mu + leaving)
