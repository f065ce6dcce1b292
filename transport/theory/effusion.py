"""Effusion: what a Maxwellian gas sends through a plane, how a vessel with a hole empties, and time of flight.

sigma = sqrt(kT/m) [m/s] is the standard deviation of each component of velocity, v = sqrt(8/pi) sigma the mean speed.
Crossings are weighted by the normal velocity: through a hole come more of the fast ones, 2 kT each in the mean,
although those in the gas have 3/2 kT (Reif 1965, 7.11-7.12; Knudsen 1909).
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from transport.units import BOLTZMANN

FLIGHT = math.sqrt(math.pi) / 3  # mean time between hits in a ball, in its natural time sqrt(2) R / sigma
STEPS = 96  # a flight, of the coarsest grid of the renewal equation; two finer ones extrapolate it


def thermal_sigma(temperature: float, mass: float) -> float:
    """Standard deviation of each component of velocity in a gas [m/s]: sqrt(kT/m) (Maxwell 1860)."""
    return math.sqrt(BOLTZMANN * temperature / mass)


def mean_speed(sigma: float) -> float:
    """Mean speed in the gas [m/s]: sqrt(8/pi) sigma (Reif 1965, 7.10); the root mean square is sqrt(3) sigma."""
    return math.sqrt(8 / math.pi) * sigma


def effusive_flux_density(density: float, sigma: float) -> float:
    """One-way particle flux density of a gas at rest [m^-2 s^-1]: n v/4 = n sigma / sqrt(2 pi) (Reif 1965, 7.11)."""
    return density * mean_speed(sigma) / 4


def mean_speed_of_crossers(sigma: float) -> float:
    """Mean speed of what crosses a plane [m/s]: (3/4) sqrt(2 pi) sigma, 3 pi/8 times that of the gas."""
    return 0.75 * math.sqrt(2 * math.pi) * sigma


def mean_energy_of_crossers(temperature: float) -> float:
    """Mean kinetic energy of what crosses a plane [J]: 2 kT; kT along the normal and kT/2 each across (Reif, 7.12)."""
    return 2 * BOLTZMANN * temperature


def share_of_crossers(low: float, high: float, sigma: float) -> float:
    """Share of what crosses a plane with speeds low to high [1]: of the density v^3 exp(-v^2/2 sigma^2).  Vectorised."""
    return _speed_share(2.0, low, high, sigma)


def share_of_gas(low: float, high: float, sigma: float) -> float:
    """Share of a gas with speeds low to high [1]: of the density v^2 exp(-v^2/2 sigma^2) (Maxwell 1860).  Vectorised."""
    return _speed_share(1.5, low, high, sigma)


def drifting_flux_density(density: float, sigma: float, drift: float) -> float:
    """One-way particle flux density of a gas that drifts along the plane's normal [m^-2 s^-1].

    drift: u, positive along the crossings counted.  n [sigma/sqrt(2 pi) exp(-s^2) + u/2 erfc(-s)], s = u/(sqrt(2) sigma)
    (Bird 1994, 4.22).  Against the drift its terms cancel to a relative error of 2 s^2 roundings, which is what the
    rounding of s costs as well.  Vectorised.
    """
    from scipy.special import erfc

    s = np.asarray(drift, dtype=float) / (math.sqrt(2) * sigma)
    return (density * sigma / math.sqrt(2) * (np.exp(-s * s) / math.sqrt(math.pi) + s * erfc(-s)))[()]


def hole_rate(area: float, volume: float, speed: float) -> float:
    """Share of a gas that leaves by a small hole a second [s^-1]: A v / 4V (Knudsen 1909; Reif 1965, 7.12).

    speed: mean speed v.  Exact at first, while the gas is in equilibrium; then off by a part of itself of the order of
    the hole's share of the walls (too low by 0.28 of that share for a ball, by about 1.3 of it for a cube).
    """
    return area * speed / (4 * volume)


def hole_survivors(time: float, area: float, volume: float, speed: float) -> float:
    """Share of a gas that is still in a vessel with a small hole [1]: exp(-A v t / 4V).  Vectorised."""
    return np.exp(-hole_rate(area, volume, speed) * np.asarray(time, dtype=float))


def ball_flight_time(radius: float, sigma: float) -> float:
    """Mean time between two hits of the wall of a ball of gas [s]: 4V/(S v) = 4R/3v; sqrt(pi)/3 sqrt(2) R/sigma."""
    return 4 * radius / (3 * mean_speed(sigma))


def ball_survivors(flights: float, loss: float) -> float:
    """Share of a gas left in a ball whose thermal wall keeps each hit with the chance `loss` [1].  Vectorised.

    flights: time over the mean time between hits.  What a sphere re-emits by the cosine law falls evenly on all of it,
    so that the flights are independent: chord over speed, the chord c of density c/2R^2, the speed flux-weighted.
    The time x of a flight, in units of sqrt(2) R / sigma, has the density f = 4x P(3, 1/x^2), P the regularised lower
    incomplete gamma function; the first one ends like one begun before the clock, of density (1 - F)/m.  So the hits a(t)
    of those left solve the renewal equation a = (1 - F)/m + (1 - loss) a*f and N = 1 - loss ∫a (Feller 1971, XI).  It is
    near exp(-loss t/m), the small hole's law, and does not end as an exponential: the slow ones outlive, like t^-3.
    Solved by trapezia with Romberg's extrapolation; the error is below 1e-9.
    """
    flights = np.asarray(flights, dtype=float)
    nodes, left, hits = _renewal(float(loss), float(max(flights.max(), 1e-3)))
    # Cubic Hermite: values and slopes are known.
    i = np.minimum((flights / nodes[1]).astype(int), len(nodes) - 2)
    h, s = nodes[1], flights / nodes[1] - i
    a, b = (1 + 2 * s) * (1 - s) ** 2, s * s * (3 - 2 * s)
    slopes = s * (1 - s) * ((1 - s) * hits[i] - s * hits[i + 1])
    return (a * left[i] + b * left[i + 1] - loss * h * slopes)[()]


@lru_cache(maxsize=8)
def _renewal(loss: float, longest: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times [flights], share left and hits a flight on the coarsest grid."""
    steps = math.ceil(STEPS * max(longest, 4.0))
    grids = [_renewal_on_grid(loss, longest, steps << level) for level in range(3)]
    left, hits = ([values[part][:: 1 << k] for k, values in enumerate(grids)] for part in (0, 1))
    return np.linspace(0, longest, steps + 1), _romberg(*left), _romberg(*hits)


def _romberg(coarse: np.ndarray, middle: np.ndarray, fine: np.ndarray) -> np.ndarray:
    """The limit of errors in h^2 and h^4."""
    first, second = middle + (middle - coarse) / 3, fine + (fine - middle) / 3
    return second + (second - first) / 15


def _renewal_on_grid(loss: float, longest: float, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Share left and hits a flight, by trapezia; f(0) = 0 makes each step explicit."""
    from scipy.special import gammainc

    h = longest / steps
    x = FLIGHT * h * np.arange(steps + 1)
    beta = np.concatenate(([np.inf], x[1:] ** -2))
    density = 4 * x * gammainc(3, beta) * FLIGHT  # a flight
    first = gammainc(2, beta) - 2 * x * x * gammainc(3, beta)  # 1 - F
    hits, backwards = np.empty(steps + 1), density[::-1].copy()
    hits[0] = 1.0
    for i in range(1, steps + 1):
        past = hits[:i] @ backwards[steps - i : steps] - 0.5 * density[i]
        hits[i] = first[i] + (1 - loss) * h * past
    gone = loss * h * (np.cumsum(hits) - 0.5 * (hits + hits[0]))
    return 1 - gone, hits


def fraction_past(distance: float, time: float, sigma: float) -> float:
    """Share of a burst of a one-dimensional Maxwellian from a point that is past a plane [1]: erfc(d/(sqrt(2) sigma t))/2.

    Half of the burst flies the other way.  Vectorised, 0 at time 0.
    """
    from scipy.special import erfc

    with np.errstate(divide="ignore"):
        return erfc(np.divide(distance, math.sqrt(2) * sigma * np.asarray(time, dtype=float))) / 2


def arrival_rate(distance: float, time: float, sigma: float) -> float:
    """Share of such a burst that arrives at the plane a second [s^-1]: (d/t^2) f(d/t), f the density of velocities.

    Vectorised, 0 at time 0.  Its mean over a bin of time is the difference of fraction_past over the bin's length.
    """
    time = np.asarray(time, dtype=float)
    t = np.where(time > 0, time, 1.0)
    bell = np.exp(-0.5 * (distance / (sigma * t)) ** 2) / (math.sqrt(2 * math.pi) * sigma)
    return np.where(time > 0, distance / t**2 * bell, 0.0)[()]


def burst_fraction_past(distance: float, time: float, speed: float) -> float:
    """Share of an isotropic burst of one speed from a point that is past a plane [1]: (1 - d/vt)/2.  Vectorised."""
    reach = np.maximum(speed * np.asarray(time, dtype=float), distance)
    return (1 - distance / reach) / 2


def _speed_share(order: float, low: float, high: float, sigma: float) -> float:
    """Difference of the regularised incomplete gamma function, from the side where it is small."""
    from scipy.special import gammainc, gammaincc

    x, y = (0.5 * np.square(np.divide(v, sigma)) for v in (low, high))
    return np.where(
        x < order, gammainc(order, y) - gammainc(order, x), gammaincc(order, x) - gammaincc(order, y)
    )[()]
