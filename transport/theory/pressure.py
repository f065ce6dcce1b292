"""Pressure: momentum that particles transfer to a wall per area and time.

A stream has a momentum flux: n m v^2 for particles of mass m and speed v, and for light its energy
density u, because the momentum is w/c. A wall at the cosine mu receives mu^2 of it: one factor for the
arrival rate, one for the normal component. In an isotropic gas <mu^2> = 1/3, half of it from arriving
particles. Leaving particles add their own momentum: a mirror doubles it, a black wall adds nothing, a
diffuse wall of albedo 1 adds the cosine law's 2/3 of the momentum (Reif 1965, 7.13; for light Maxwell
1873, art. 792; Boltzmann 1884).
"""

from __future__ import annotations

from transport.units import BOLTZMANN

_ISOTROPIC = {"mirror": 1.0, "diffuse": 1.0, "black": 0.5}  # share of the pressure inside


def light_pressure(energy_density: float, wall: str = "mirror") -> float:
    """Pressure of isotropic light on a wall.

    Parameters
    ----------
    energy_density : float
        Energy density u [J m^-3].
    wall : str, default 'mirror'
        "mirror", "diffuse" (albedo 1, cosine law) or "black".

    Returns
    -------
    float
        ``u/3`` [Pa]; u/6 on a black wall.

    Examples
    --------
    >>> from transport.theory.pressure import light_pressure
    >>> print(f"{light_pressure(3.0):.4g}")
    1
    """
    return isotropic_pressure(energy_density / 3, wall)


def gas_pressure(density: float, temperature: float, wall: str = "mirror") -> float:
    """Pressure of a gas on a wall.

    Parameters
    ----------
    density : float
        Particle density n [m^-3].
    temperature : float
        Temperature T [K].
    wall : str, default 'mirror'
        "mirror", "diffuse" (albedo 1, cosine law) or "black".

    Returns
    -------
    float
        ``n k T`` [Pa]; half of it on a black wall.

    Examples
    --------
    >>> from transport.theory.pressure import gas_pressure
    >>> print(f"{gas_pressure(2.5e25, 300.0):.4g}")
    1.035e+05
    """
    return isotropic_pressure(density * BOLTZMANN * temperature, wall)


def kinetic_pressure(density: float, mass: float, mean_square_speed: float) -> float:
    """Pressure of an isotropic gas from its speeds.

    Parameters
    ----------
    density : float
        Particle density n [m^-3].
    mass : float
        Mass m of a particle [kg].
    mean_square_speed : float
        Mean of the squared speeds (not the square of the mean) [m^2 s^-2].

    Returns
    -------
    float
        ``n m <v^2>/3`` [Pa].

    Examples
    --------
    >>> from transport.theory.pressure import kinetic_pressure
    >>> print(f"{kinetic_pressure(2.5e25, 4.65e-26, 2.7e5):.4g}")
    1.046e+05
    """
    return density * mass * mean_square_speed / 3


def isotropic_pressure(inside: float, wall: str = "mirror") -> float:
    """Pressure of isotropic particles or light on a wall.

    Parameters
    ----------
    inside : float
        Pressure in the interior of the gas [Pa].
    wall : str, default 'mirror'
        "mirror", "diffuse" (albedo 1, cosine law) or "black".

    Returns
    -------
    float
        Pressure on the wall [Pa].

    Notes
    -----
    A black wall receives the momentum of the arriving half only. A mirror and a diffuse wall of albedo
    1 return particles with the distribution of an isotropic gas: the full pressure.

    Examples
    --------
    >>> from transport.theory.pressure import isotropic_pressure
    >>> print(f"{isotropic_pressure(1.0, 'black'):.4g}")
    0.5
    """
    return _ISOTROPIC[wall] * inside


def stream_pressure(momentum_flux: float, mu: float = 1.0, wall: str = "black") -> float:
    """Pressure of a parallel stream on a wall.

    Parameters
    ----------
    momentum_flux : float
        Momentum flux along the stream: n m v^2, or u for light [Pa].
    mu : float, default 1.0
        Cosine between the stream and the wall's normal, 0 to 1 [1].
    wall : str, default 'black'
        "mirror", "diffuse" (albedo 1, cosine law) or "black".

    Returns
    -------
    float
        Pressure [Pa]: ``mu^2`` of the momentum flux on a black wall, twice that on a mirror,
        ``mu (mu + 2/3)`` of it on a diffuse wall.

    Examples
    --------
    >>> from transport.theory.pressure import stream_pressure
    >>> print(f"{stream_pressure(1.0, 0.5, 'diffuse'):.4g}")
    0.5833
    """
    leaving = {"mirror": mu, "diffuse": 2 / 3, "black": 0.0}[wall]
    return momentum_flux * mu * (mu + leaving)
