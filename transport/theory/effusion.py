"""Effusion of a Maxwellian gas: flux through a plane, emptying of a vessel, time of flight.

sigma = sqrt(kT/m) [m/s] is the standard deviation of each component of velocity, v = sqrt(8/pi) sigma
the mean speed. Crossings are weighted by the normal velocity: fast particles are more frequent among
those that pass a hole, and their mean energy is 2 kT, against 3/2 kT in the gas (Reif 1965, 7.11-7.12;
Knudsen 1909).
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from transport.units import BOLTZMANN

MEAN_FLIGHT_TIME = (
    math.sqrt(math.pi) / 3
)  # mean time between wall hits in a ball, in units of sqrt(2) R / sigma
STEPS_PER_FLIGHT = 96  # per flight, coarsest grid of the renewal equation; two finer grids extrapolate it


def thermal_sigma(temperature: float, mass: float) -> float:
    """Standard deviation of each component of velocity in a gas.

    Parameters
    ----------
    temperature : float
        Temperature T [K].
    mass : float
        Mass of a particle [kg].

    Returns
    -------
    float
        ``sqrt(kT/m)`` [m/s].

    Notes
    -----
    Source: Maxwell 1860.

    Examples
    --------
    >>> from transport.theory.effusion import thermal_sigma
    >>> print(f"{thermal_sigma(300.0, 4.65e-26):.4g}")
    298.5
    """
    return math.sqrt(BOLTZMANN * temperature / mass)


def mean_speed(sigma: float) -> float:
    """Mean speed in a Maxwellian gas.

    Parameters
    ----------
    sigma : float
        Standard deviation of each component of velocity, sqrt(kT/m) [m/s].

    Returns
    -------
    float
        ``sqrt(8/pi) sigma`` [m/s]; the root mean square speed is sqrt(3) sigma.

    Notes
    -----
    Source: Reif 1965, 7.10.

    Examples
    --------
    >>> from transport.theory.effusion import mean_speed
    >>> print(f"{mean_speed(300.0):.4g}")
    478.7
    """
    return math.sqrt(8 / math.pi) * sigma


def effusive_flux_density(density: float, sigma: float) -> float:
    """One-way particle flux density in a gas at rest.

    Parameters
    ----------
    density : float
        Particle density n [m^-3].
    sigma : float
        Standard deviation of each component of velocity, sqrt(kT/m) [m/s].

    Returns
    -------
    float
        ``n v/4 = n sigma / sqrt(2 pi)`` [m^-2 s^-1].

    Notes
    -----
    Source: Reif 1965, 7.11.

    Examples
    --------
    >>> from transport.theory.effusion import effusive_flux_density
    >>> print(f"{effusive_flux_density(2.5e25, 300.0):.4g}")
    2.992e+27
    """
    return density * mean_speed(sigma) / 4


def mean_speed_of_crossers(sigma: float) -> float:
    """Mean speed of the particles that cross a plane.

    Parameters
    ----------
    sigma : float
        Standard deviation of each component of velocity, sqrt(kT/m) [m/s].

    Returns
    -------
    float
        ``(3/4) sqrt(2 pi) sigma`` [m/s], 3 pi/8 times the mean speed of the gas.

    Examples
    --------
    >>> from transport.theory.effusion import mean_speed_of_crossers
    >>> print(f"{mean_speed_of_crossers(300.0):.4g}")
    564
    """
    return 0.75 * math.sqrt(2 * math.pi) * sigma


def mean_energy_of_crossers(temperature: float) -> float:
    """Mean kinetic energy of the particles that cross a plane.

    Parameters
    ----------
    temperature : float
        Temperature T [K].

    Returns
    -------
    float
        ``2 kT`` [J]: kT along the normal and kT/2 in each tangential direction.

    Notes
    -----
    Source: Reif 1965, 7.12.

    Examples
    --------
    >>> from transport.theory.effusion import mean_energy_of_crossers
    >>> print(f"{mean_energy_of_crossers(300.0):.4g}")
    8.284e-21
    """
    return 2 * BOLTZMANN * temperature


def share_of_crossers(low: float, high: float, sigma: float) -> float:
    """Share of the particles crossing a plane whose speed is in a range.

    Parameters
    ----------
    low : float or ndarray
        Lower speed, at least 0 [m/s].
    high : float or ndarray
        Upper speed [m/s].
    sigma : float or ndarray
        Standard deviation of each component of velocity, sqrt(kT/m) [m/s].

    Returns
    -------
    float or ndarray
        Integral of the normalised density ``v^3 exp(-v^2/2 sigma^2)`` [1].

    Examples
    --------
    >>> from transport.theory.effusion import share_of_crossers
    >>> print(f"{share_of_crossers(0.0, 300.0, 300.0):.4g}")
    0.0902
    """
    return _speed_share(2.0, low, high, sigma)


def share_of_gas(low: float, high: float, sigma: float) -> float:
    """Share of a Maxwellian gas whose speed is in a range.

    Parameters
    ----------
    low : float or ndarray
        Lower speed, at least 0 [m/s].
    high : float or ndarray
        Upper speed [m/s].
    sigma : float or ndarray
        Standard deviation of each component of velocity, sqrt(kT/m) [m/s].

    Returns
    -------
    float or ndarray
        Integral of the normalised density ``v^2 exp(-v^2/2 sigma^2)`` [1].

    Notes
    -----
    Source: Maxwell 1860.

    Examples
    --------
    >>> from transport.theory.effusion import share_of_gas
    >>> print(f"{share_of_gas(0.0, 300.0, 300.0):.4g}")
    0.1987
    """
    return _speed_share(1.5, low, high, sigma)


def drifting_flux_density(density: float, sigma: float, drift: float) -> float:
    """One-way particle flux density of a gas that drifts along the plane's normal.

    Parameters
    ----------
    density : float or ndarray
        Particle density n [m^-3].
    sigma : float or ndarray
        Standard deviation of each component of velocity, sqrt(kT/m) [m/s].
    drift : float or ndarray
        Drift velocity u, positive along the counted crossings [m/s].

    Returns
    -------
    float or ndarray
        One-way flux density [m^-2 s^-1].

    Notes
    -----
    ``n [sigma/sqrt(2 pi) exp(-s^2) + u/2 erfc(-s)]`` with ``s = u/(sqrt(2) sigma)`` (Bird 1994, 4.22).
    Against the drift the terms cancel to a relative error of 2 s^2 roundings, the same as the error due
    to the rounding of s.

    Examples
    --------
    >>> from transport.theory.effusion import drifting_flux_density
    >>> print(f"{drifting_flux_density(1.0, 300.0, 300.0):.4g}")
    325
    """
    from scipy.special import erfc

    s = np.asarray(drift, dtype=float) / (math.sqrt(2) * sigma)
    return (density * sigma / math.sqrt(2) * (np.exp(-s * s) / math.sqrt(math.pi) + s * erfc(-s)))[()]


def hole_rate(area: float, volume: float, speed: float) -> float:
    """Share of a gas that leaves through a small hole per second.

    Parameters
    ----------
    area : float
        Area A of the hole [m^2].
    volume : float
        Volume V of the vessel [m^3].
    speed : float
        Mean speed v of the gas [m/s].

    Returns
    -------
    float
        ``A v / 4V`` [s^-1].

    Notes
    -----
    Source: Knudsen 1909; Reif 1965, 7.12. Exact at first, while the gas is in equilibrium. Later its
    relative error is of the order of the hole's share of the wall area (too low by 0.28 of that share
    for a ball, by about 1.3 of it for a cube).

    Examples
    --------
    >>> from transport.theory.effusion import hole_rate
    >>> print(f"{hole_rate(1e-4, 1.0, 480.0):.4g}")
    0.012
    """
    return area * speed / (4 * volume)


def hole_survivors(time: float, area: float, volume: float, speed: float) -> float:
    """Share of a gas that is still in a vessel with a small hole.

    Parameters
    ----------
    time : float or ndarray
        Time [s].
    area : float or ndarray
        Area A of the hole [m^2].
    volume : float or ndarray
        Volume V of the vessel [m^3].
    speed : float or ndarray
        Mean speed v of the gas [m/s].

    Returns
    -------
    float or ndarray
        ``exp(-A v t / 4V)`` [1].

    Examples
    --------
    >>> from transport.theory.effusion import hole_survivors
    >>> print(f"{hole_survivors(60.0, 1e-4, 1.0, 480.0):.4g}")
    0.4868
    """
    return np.exp(-hole_rate(area, volume, speed) * np.asarray(time, dtype=float))


def ball_flight_time(radius: float, sigma: float) -> float:
    """Mean time between two wall hits in a ball of gas.

    Parameters
    ----------
    radius : float
        Radius R of the ball [m].
    sigma : float
        Standard deviation of each component of velocity, sqrt(kT/m) [m/s].

    Returns
    -------
    float
        ``4V/(S v) = 4R/3v = sqrt(pi)/3 sqrt(2) R/sigma`` [s].

    Examples
    --------
    >>> from transport.theory.effusion import ball_flight_time
    >>> print(f"{ball_flight_time(1.0, 300.0):.4g}")
    0.002785
    """
    return 4 * radius / (3 * mean_speed(sigma))


def ball_survivors(flights: float, loss: float) -> float:
    """Share of a gas left in a ball whose thermal wall absorbs each hitting particle with a probability.

    Parameters
    ----------
    flights : float or ndarray
        Time over the mean time between wall hits [1].
    loss : float
        Probability of absorption per hit, 0 to 1 [1].

    Returns
    -------
    float or ndarray
        Share left [1]; error below 1e-9.

    Notes
    -----
    Particles re-emitted by a sphere's wall with the cosine law hit the whole wall uniformly, so that
    successive flights are independent: chord over speed, with the chord c of density c/2R^2 and the
    flux-weighted speed. The time x of a flight, in units of ``sqrt(2) R / sigma``, has the density
    ``f = 4x P(3, 1/x^2)``, P the regularised lower incomplete gamma function. The first flight began
    before time 0; its end has the density ``(1 - F)/m``. The hit rate a(t) of the remaining particles
    obeys the renewal equation ``a = (1 - F)/m + (1 - loss) a*f`` (``*`` is convolution), and
    ``N = 1 - loss ∫ a`` (Feller 1971, XI).

    N is close to ``exp(-loss t/m)``, the law of the small hole, but its tail falls as t^-3 because slow
    particles survive longer. Solved by the trapezoidal rule with Romberg extrapolation.

    Examples
    --------
    >>> from transport.theory.effusion import ball_survivors
    >>> print(f"{ball_survivors(1.0, 0.1):.4g}")
    0.9024
    """
    flights = np.asarray(flights, dtype=float)
    nodes, left, hits = _renewal(float(loss), float(max(flights.max(), 1e-3)))
    # Interpolate by cubic Hermite polynomials: values and slopes are known.
    i = np.minimum((flights / nodes[1]).astype(int), len(nodes) - 2)
    h, s = nodes[1], flights / nodes[1] - i
    a, b = (1 + 2 * s) * (1 - s) ** 2, s * s * (3 - 2 * s)
    slopes = s * (1 - s) * ((1 - s) * hits[i] - s * hits[i + 1])
    return (a * left[i] + b * left[i + 1] - loss * h * slopes)[()]


@lru_cache(maxsize=8)
def _renewal(loss: float, longest: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times [flights], share left and hits per flight on the coarsest grid."""
    steps = math.ceil(STEPS_PER_FLIGHT * max(longest, 4.0))
    grids = [_renewal_on_grid(loss, longest, steps << level) for level in range(3)]
    left, hits = ([values[part][:: 1 << k] for k, values in enumerate(grids)] for part in (0, 1))
    return np.linspace(0, longest, steps + 1), _romberg(*left), _romberg(*hits)


def _romberg(coarse: np.ndarray, middle: np.ndarray, fine: np.ndarray) -> np.ndarray:
    """Limit of values with errors in h^2 and h^4."""
    first, second = middle + (middle - coarse) / 3, fine + (fine - middle) / 3
    return second + (second - first) / 15


def _renewal_on_grid(loss: float, longest: float, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Share left and hits per flight, by the trapezoidal rule; f(0) = 0 makes each step explicit."""
    from scipy.special import gammainc

    h = longest / steps
    x = MEAN_FLIGHT_TIME * h * np.arange(steps + 1)
    beta = np.concatenate(([np.inf], x[1:] ** -2))
    density = 4 * x * gammainc(3, beta) * MEAN_FLIGHT_TIME  # per flight
    first = gammainc(2, beta) - 2 * x * x * gammainc(3, beta)  # 1 - F
    hits, backwards = np.empty(steps + 1), density[::-1].copy()
    hits[0] = 1.0
    for i in range(1, steps + 1):
        past = hits[:i] @ backwards[steps - i : steps] - 0.5 * density[i]
        hits[i] = first[i] + (1 - loss) * h * past
    gone = loss * h * (np.cumsum(hits) - 0.5 * (hits + hits[0]))
    return 1 - gone, hits


def fraction_past(distance: float, time: float, sigma: float) -> float:
    """Share of a point burst of a one-dimensional Maxwellian that is past a plane.

    Parameters
    ----------
    distance : float or ndarray
        Distance d of the plane from the point of the burst [m].
    time : float or ndarray
        Time [s].
    sigma : float or ndarray
        Standard deviation of each component of velocity, sqrt(kT/m) [m/s].

    Returns
    -------
    float or ndarray
        ``erfc(d/(sqrt(2) sigma t))/2`` [1]; 0 at time 0. Half of the burst flies away from the plane.

    Examples
    --------
    >>> from transport.theory.effusion import fraction_past
    >>> print(f"{fraction_past(1.0, 1e-2, 300.0):.4g}")
    0.3694
    """
    from scipy.special import erfc

    with np.errstate(divide="ignore"):
        return erfc(np.divide(distance, math.sqrt(2) * sigma * np.asarray(time, dtype=float))) / 2


def arrival_rate(distance: float, time: float, sigma: float) -> float:
    """Share of a point burst of a one-dimensional Maxwellian that arrives at a plane per second.

    Parameters
    ----------
    distance : float or ndarray
        Distance d of the plane from the point of the burst [m].
    time : float or ndarray
        Time [s].
    sigma : float or ndarray
        Standard deviation of each component of velocity, sqrt(kT/m) [m/s].

    Returns
    -------
    float or ndarray
        ``(d/t^2) f(d/t)`` [s^-1], f the density of velocities; 0 at time 0.

    Notes
    -----
    Its mean over a bin of time is the difference of `fraction_past` over the bin's length.

    Examples
    --------
    >>> from transport.theory.effusion import arrival_rate
    >>> print(f"{arrival_rate(1.0, 1e-2, 300.0):.4g}")
    12.58
    """
    time = np.asarray(time, dtype=float)
    t = np.where(time > 0, time, 1.0)
    bell = np.exp(-0.5 * (distance / (sigma * t)) ** 2) / (math.sqrt(2 * math.pi) * sigma)
    return np.where(time > 0, distance / t**2 * bell, 0.0)[()]


def burst_fraction_past(distance: float, time: float, speed: float) -> float:
    """Share of an isotropic point burst of one speed that is past a plane.

    Parameters
    ----------
    distance : float or ndarray
        Distance d of the plane from the point of the burst [m].
    time : float or ndarray
        Time [s].
    speed : float or ndarray
        Speed v of all particles [m/s].

    Returns
    -------
    float or ndarray
        ``(1 - d/vt)/2`` [1]; 0 before the first arrival.

    Examples
    --------
    >>> from transport.theory.effusion import burst_fraction_past
    >>> print(f"{burst_fraction_past(1.0, 2.0, 1.0):.4g}")
    0.25
    """
    reach = np.maximum(speed * np.asarray(time, dtype=float), distance)
    return (1 - distance / reach) / 2


def _speed_share(order: float, low: float, high: float, sigma: float) -> float:
    """Difference of the regularised incomplete gamma function, from its small tail."""
    from scipy.special import gammainc, gammaincc

    x, y = (0.5 * np.square(np.divide(v, sigma)) for v in (low, high))
    return np.where(
        x < order, gammainc(order, y) - gammainc(order, x), gammaincc(order, x) - gammaincc(order, y)
    )[()]


# ---- Isotropic gas of particles of one speed: flux through a plane, radiance, fluence rate.
#
# n is the density [m^-3], v the speed [m/s]. The particles that cross dA within dt fill the prism v dt
# cos(theta) dA (Cornell CS 6620, lecture 2), so that a stream has the flux density n v cos(theta), and
# all other quantities are integrals of it.


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
    >>> from transport.theory.effusion import stream_flux_density
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
    >>> from transport.theory.effusion import one_way_flux_density
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
    >>> from transport.theory.effusion import net_flux_density
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
    >>> from transport.theory.effusion import radiance
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
    >>> from transport.theory.effusion import fluence_rate
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
    >>> from transport.theory.effusion import flux_in_bin
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
    >>> from transport.theory.effusion import mean_mu_of_crossers
    >>> print(f"{mean_mu_of_crossers():.4g}")
    0.6667
    """
    return 2 / 3


# ---- Pressure: momentum that particles transfer to a wall per area and time.
#
# A stream has a momentum flux: n m v^2 for particles of mass m and speed v, and for light its energy
# density u, because the momentum is w/c. A wall at the cosine mu receives mu^2 of it: one factor for the
# arrival rate, one for the normal component. In an isotropic gas <mu^2> = 1/3, half of it from arriving
# particles. Leaving particles add their own momentum: a mirror doubles it, a black wall adds nothing, a
# diffuse wall of albedo 1 adds the cosine law's 2/3 of the momentum (Reif 1965, 7.13; for light Maxwell
# 1873, art. 792; Boltzmann 1884).

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
    >>> from transport.theory.effusion import light_pressure
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
    >>> from transport.theory.effusion import gas_pressure
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
    >>> from transport.theory.effusion import kinetic_pressure
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
    >>> from transport.theory.effusion import isotropic_pressure
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
    >>> from transport.theory.effusion import stream_pressure
    >>> print(f"{stream_pressure(1.0, 0.5, 'diffuse'):.4g}")
    0.5833
    """
    leaving = {"mirror": mu, "diffuse": 2 / 3, "black": 0.0}[wall]
    return momentum_flux * mu * (mu + leaving)
