"""A lamp fills a closed room with light: how much, and how soon; a wrong mean flight or a forgotten reflection is rejected.

Each statistical test fails right code in one of 10^5 seeds; the seed is 1.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

import transport as tp
from tests.agreement import assert_agrees, assert_rejected
from tests.sim_runs import judge
from transport.sims import light_fills_a_room as sim
from transport.verification.experiment import run_experiment

FALSE_ALARM = 1e-5


@pytest.fixture(scope="module")
def outcomes():
    return run_experiment(sim, particles=400_000, seed=1, threads=2)


# ---- the exact energy ----


@pytest.mark.parametrize("albedo", [0.1, 0.5, 0.9, 0.99])
def test_the_weight_of_all_ages_together_is_the_number_of_flights(albedo):
    long = sim.stay(np.array([400 / (1 - albedo)]), albedo)[0]
    assert long == pytest.approx(4 / 3 / (1 - albedo), rel=1e-11)


@pytest.mark.parametrize("age", [0.7, 2.0, 3.3, 7.9])
def test_survival_solves_the_renewal_equation(age):
    """Beside the integral itself; the derivative of the stay is the survival."""
    albedo, h = 0.7, 1e-4

    def survival(x):
        return float(np.diff(sim.stay(np.array([max(x - h, 0), x + h]), albedo))[0] / (min(x, h) + h))

    breaks = [y for y in (age - 4, age - 2) if 0 < y < min(age, 2)]
    flown, _ = quad(lambda y: y / 2 * survival(age - y), 0, min(age, 2), points=breaks or None, epsabs=1e-9)
    assert survival(age) == pytest.approx(max(1 - age**2 / 4, 0) + albedo * flown, abs=3e-4)


def test_without_an_albedo_light_stays_for_one_chord():
    ages = np.array([0.5, 1.0, 2.0, 9.0])
    assert sim.stay(ages, 0.0) == pytest.approx([*(ages[:3] - ages[:3] ** 3 / 12), 4 / 3], rel=1e-14)
    assert sim.stay(ages, 1e-7) == pytest.approx(sim.stay(ages, 0.0), rel=1e-5)


# ---- the run ----


@pytest.mark.slow
def test_all_rows_agree(outcomes):
    assert len(judge(outcomes)) == 30


@pytest.mark.slow
def test_wrong_laws_are_rejected(outcomes):
    """Planted: a mean chord of a or of 2a, a wall that reflects nothing, and a lamp without losses."""
    steady = next(o for o in outcomes if o.parameters == {"albedo": 0.9, "clock": "none"})
    row, power = steady[sim.STEADY], steady.given["power"]
    assert_agrees(row.estimate, row.exact, FALSE_ALARM)
    for flight in (sim.CROSSING, 2 * sim.CROSSING):
        assert_rejected(row.estimate, power * flight / 0.1)
    assert_rejected(row.estimate, power * sim.FLIGHT)
    rising = next(o for o in outcomes if o.parameters == {"albedo": 0.9})
    for row in rising.rows[1:]:
        time = float(row.name.split()[2]) * tp.ns
        if time > 30 * tp.ns:
            assert_rejected(row.estimate, power * time)
        exponential = power * sim.FLIGHT / 0.1 * (1 - math.exp(-0.1 * time / sim.FLIGHT))
        if time < 30 * tp.ns:  # the law of many flights does not hold for the first
            assert_rejected(row.estimate, exponential)


@pytest.mark.slow
def test_the_first_flight_of_a_bulb_is_shorter(outcomes):
    bulb = next(o for o in outcomes if o.given["lamp"] == sim.LAMPS[1])
    row, of = bulb[sim.STEADY], bulb.given
    assert_agrees(row.estimate, row.exact, FALSE_ALARM)
    assert_rejected(row.estimate, of["power"] * sim.FLIGHT / (1 - of["albedo"]))


@pytest.mark.slow
def test_a_wall_of_another_albedo_is_rejected():
    rows = sim.measure(tp.simulate(sim.scene(albedo=0.89, clock="none"), particles=400_000, seed=1))
    assert_rejected(rows[sim.STEADY], sim.exact(albedo=0.9, clock="none")[sim.STEADY])
