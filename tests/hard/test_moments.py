"""Moments where numbers of very different size meet: slow beside fast, a narrow spread about a fast drift; and walls that
keep a gas at their temperature.

Squares of speeds are summed as whole numbers of one unit for all bins, and a variance is a difference: both lose
digits, and neither may show a small error then.  Seeds are fixed; judgements fail right code in one of 10^6 of them.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_z_spread
from transport.units import BOLTZMANN

FALSE_ALARM = 1e-6
MASS, SIGMA = 4.65e-26, 300.0  # nitrogen at room temperature
TEMPERATURE = MASS * SIGMA**2 / BOLTZMANN


def look(sources, phase_space, particles, seed=1, duration=1e-9):
    scene = tp.Scene(sources, [], phase_space, duration=duration)
    return tp.simulate(scene, particles=particles, seed=seed, progress=False, threads=1)["phase_space"]


def gas(speed, **options):
    return tp.Source(tp.Point(), tp.Gas(number=1.0, speed=speed, **options))


def sixteen_decades(u):
    """Density 1/v^2: the slowest are the most, and the fastest that can be drawn flies at 9e15."""
    return 1 / (1 - u)


def test_variances_of_slow_particles_among_very_fast_ones_are_theirs():
    """(1 / 9e15)^2 is less than the last bit of a sum that has room for the fastest: cut off, its squares were 0."""
    edges = (1, 2, 4, 8, 16)
    bins = tp.PhaseSpace(speed=edges, time=0.0, moments=True)
    found = look(gas(tp.InverseCDF(sixteen_decades), direction=(0, 0, 1)), bins, 200_000)
    low = np.array(edges[:-1])
    exact = low**2 * (2 - (2 * math.log(2)) ** 2)
    assert_agrees(found.number, 1 / (2 * low), FALSE_ALARM)
    assert_agrees(found.mean_vz, low * 2 * math.log(2), FALSE_ALARM)
    assert_agrees(found.variance_vz, exact, FALSE_ALARM)
    with pytest.raises(AssertionError):
        assert_agrees(found.variance_vz, 1.1 * exact, FALSE_ALARM)


@pytest.mark.parametrize("drift", [1e2, 1e5, 1e8])
def test_the_variance_of_a_stream_is_right_however_fast_it_drifts(drift):
    """<v^2> - <v>^2 of 1e16 each would leave a difference of 1 to rounding, of which no spread over batches knows."""
    way = drift * np.array([2.0, -1.0, 2.0]) / 3
    stream = gas(tp.Maxwellian(sigma=1.0, drift=way))
    z = []
    for seed in range(12):
        found = look(stream, tp.PhaseSpace(x=(-9e9, 9e9), time=0.0, moments=True), 4000, seed)
        z += [found.variance_vx.z(1.0)[0], found.variance_vy.z(1.0)[0], found.variance_vz.z(1.0)[0]]
        np.testing.assert_allclose(found.mean_vx.value, way[0], rtol=1e-15, atol=0.1)
    assert_z_spread(z, math.inf, FALSE_ALARM)


@pytest.mark.parametrize("drift", [1e4, 1e7, 1e9])
def test_a_variance_that_rounding_has_taken_is_not_said_to_be_known(drift):
    """A slow gas beside a fast stream: no velocity is near to both.  Right within its error, or the error is unknown."""
    sources = [gas(tp.Maxwellian(sigma=1.0)), gas(drift, direction=(0, 0, 1))]
    slow = tp.PhaseSpace(speed=(0, 100, 2 * drift), time=0.0, moments=True)
    z = np.array([look(sources, slow, 4000, seed).variance_vz.z(1.0)[0] for seed in range(12)])
    if drift < 1e6:
        assert_z_spread(z, math.inf, FALSE_ALARM)
    assert (np.isnan(z) | (np.abs(z) < 5.0)).all()


# ---- walls of a temperature ----

BOX = tp.Box(size=(0.5, 0.8, 1.0))
FLIGHT = 4 * 0.4 / 3.4 / (math.sqrt(8 / math.pi) * SIGMA)  # the mean chord 4 V/S, at the mean speed
DENSITY = 1e12


def after_twenty_flights(wall):
    """A gas between walls that take three of five particles to their own temperature, and mirror the others."""
    walls = tp.Surface(BOX, tp.Mixture({tp.Diffuse(1.0, speed=wall): 0.6, tp.Mirror(): 0.4}), "walls")
    inside = tp.Gas(density=DENSITY, speed=tp.Maxwellian(sigma=SIGMA, mass=MASS))
    looks = [
        tp.PhaseSpace(z=(-0.5, -0.2, 0.5), time=(0.0, 20 * FLIGHT), within=BOX, moments=True, name="gas"),
        tp.Detector("walls", "pressure", side="back", moments=True),
    ]
    scene = tp.Scene(tp.Source(BOX, inside), walls, looks, duration=20 * FLIGHT)
    return tp.simulate(scene, particles=40_000, seed=1, progress=False)


def assert_is_in_equilibrium(result):
    found, pressure = result["gas"], DENSITY * BOLTZMANN * TEMPERATURE
    assert result.ledger["in_flight"].value == pytest.approx(DENSITY * 0.4, rel=1e-12)
    assert str(found.density.unit) == "m^-3"
    assert_agrees(found.density, DENSITY, FALSE_ALARM)
    assert_agrees(found.temperature, TEMPERATURE, FALSE_ALARM)
    assert_agrees(found.pressure, pressure, FALSE_ALARM)
    assert_agrees(result["pressure"].pressure, pressure, FALSE_ALARM)
    for mean in (found.mean_vx, found.mean_vy, found.mean_vz):
        assert_agrees(mean, 0.0, FALSE_ALARM)


def test_walls_of_the_temperature_of_a_gas_keep_it_there_through_twenty_flights():
    """What leaves a wall is weighted by its speed, 2 kT each in the mean; what is in the gas has 3/2 kT."""
    assert_is_in_equilibrium(after_twenty_flights(tp.Maxwellian(sigma=SIGMA, mass=MASS)))


def as_in_the_gas(u):
    """Rayleigh's law: weighted by speed it is that of the gas itself, which a wall must not give off."""
    return SIGMA * np.sqrt(-2 * np.log1p(-u))


@pytest.mark.parametrize(
    "wall",
    [
        tp.Maxwellian(sigma=math.sqrt(1.02) * SIGMA, mass=MASS),
        tp.InverseCDF(as_in_the_gas),
    ],
    ids=["2 % warmer", "speeds of the gas"],
)
def test_walls_that_are_not_in_equilibrium_with_the_gas_are_seen(wall):
    with pytest.raises(AssertionError):
        assert_is_in_equilibrium(after_twenty_flights(wall))
