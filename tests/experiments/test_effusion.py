"""Effusion: the closed forms agree with references and mpmath, the engine with them, and planted faults are rejected.

The statistical tests fail right code in one of 10^5 seeds each; the seed is 1.  A comment such as `J.effusion` names the
entry of the project's reference collection that a number comes from.
"""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_rejected
from tests.sim_runs import judge
from transport.sims import effusion
from transport.theory import effusion as theory
from transport.verification.experiment import run_experiment

slow = pytest.mark.slow  # runs of millions of particles

FALSE_ALARM = 1e-5
GAS = tp.Maxwellian(sigma=1.0, mass=2.0)
SPEEDS = np.linspace(0, 8, 801)
UNWEIGHTED = tp.SpeedTable(SPEEDS, SPEEDS * np.exp(-(SPEEDS**2) / 2))  # weighted: those of GAS


def run(particles=1_000_000, **parameters):
    """The first case of the sim with these parameters."""
    return run_experiment(effusion, parameters, particles=particles, seed=1)[0]


def close(value, exact, relative=1e-14):
    return np.allclose(value, np.array(exact, dtype=float), rtol=relative, atol=0)


# ---- closed forms ----


def test_maxwellian_flux_and_moments_agree_with_references():
    assert close(theory.effusive_flux_density(2.5, 1.0), 0.9973557010035817)  # A.maxwellian_effusion_moments
    assert close(theory.mean_speed_of_crossers(1.0), 1.8799712059732503)
    drifts = math.sqrt(2) * np.array([-0.5, 0.0, 0.5, 2.0])
    exact = [0.35291916596960327, 0.9973557010035817, 2.1206861189359723, 7.072796728100218]
    assert close(theory.drifting_flux_density(2.5, 1.0, drifts), exact)  # A.drifting_maxwellian_flux
    assert close(theory.hole_rate(0.01, 1.0, 1.0), 0.0025)  # J.effusion
    assert close(theory.hole_survivors(277.25887222397813, 0.01, 1.0, 1.0), 0.5)


def test_times_of_flight_agree_with_references():
    d, t = np.array([1, 1, 3]), np.array([0.5, 1, 2])  # J.time_of_flight
    assert close(
        theory.fraction_past(d, t, 1.2), [0.0477903522728147, 0.20232838096364303, 0.10564977366685528]
    )
    assert close(
        theory.arrival_rate(d, t, 1.2), [0.3315904626424957, 0.23492656284191882, 0.1141556783681387], 1e-13
    )
    assert close(theory.burst_fraction_past(1.0, np.array([1.5, 2, 10]), 1.0), [1 / 6, 0.25, 0.45])
    assert theory.fraction_past(1.0, 0.0, 1.2) == theory.arrival_rate(1.0, 0.0, 1.2) == 0
    assert theory.burst_fraction_past(1.0, 0.5, 1.0) == 0


def flux_weighted(power, low, high):
    """Integral of v^power exp(-v^2/2), in mpmath numbers."""
    with mp.workdps(30):
        return mp.quad(lambda v: v**power * mp.exp(-v * v / 2), np.linspace(low, high, 9).tolist())


def test_moments_are_integrals_of_the_flux_weighted_speeds():
    whole = flux_weighted(3, 0, 20)
    assert close(theory.mean_speed_of_crossers(1.0), flux_weighted(4, 0, 20) / whole)
    assert close(theory.mean_energy_of_crossers(1 / theory.BOLTZMANN), flux_weighted(5, 0, 20) / whole / 2)
    assert not close(theory.mean_speed(1.0), flux_weighted(4, 0, 20) / whole, 0.1)  # of the gas, unweighted


@pytest.mark.parametrize(("share", "power"), [(theory.share_of_crossers, 3), (theory.share_of_gas, 2)])
def test_shares_of_speeds_are_accurate_in_both_tails(share, power):
    for low, high in ((0, 0.001), (0.01, 0.02), (1, 3), (3, 10), (10, 11)):
        exact = flux_weighted(power, low, high) / flux_weighted(power, 0, 20)
        assert close(share(low, high, 1.0), exact, 1e-12)


@pytest.mark.parametrize("s", [-20, -8, -3, -1, -0.3, -1e-8, 0.0, 1e-8, 1, 5, 30])
def test_a_drifting_flux_is_accurate_with_and_against_the_drift(s):
    drift = math.sqrt(2) * s
    with mp.workdps(250):
        x = mp.mpf(drift) / mp.sqrt(2)
        exact = mp.exp(-x * x) / mp.sqrt(2 * mp.pi) + x / mp.sqrt(2) * mp.erfc(-x)
    assert close(theory.drifting_flux_density(1.0, 1.0, drift), exact, 1e-15 * (2 + s * s))


def flight_distribution(x):
    """Antiderivative of 1 - F in closed form, x in units of sqrt(2) R/sigma."""
    rest = (2 * x**3 - x) / 3 * math.exp(-1 / x**2) + math.sqrt(math.pi) / 3 * math.erfc(1 / x)
    return x - 2 * x**3 / 3 + rest


@pytest.mark.parametrize("flights", [0.1, 1.0, 3.0, 7.77])
def test_a_black_ball_loses_at_the_first_hit(flights):
    exact = 1 - flight_distribution(flights * theory.MEAN_FLIGHT_TIME) / theory.MEAN_FLIGHT_TIME
    assert theory.ball_survivors(flights, 1.0) == pytest.approx(exact, abs=1e-12)
    assert theory.ball_flight_time(math.sqrt(0.5), 1.0) == pytest.approx(theory.MEAN_FLIGHT_TIME, rel=1e-14)


def test_hits_on_a_closed_ball_come_at_a_steady_rate():
    """To first order each flight costs the loss, from the first moment on: the renewal process is stationary."""
    flights = np.linspace(0, 30, 61)
    assert np.allclose((1 - theory.ball_survivors(flights, 1e-7)) / 1e-7, flights, atol=1e-4)


def test_a_leaky_ball_is_near_a_small_hole_and_outlives_it():
    for loss in (0.1, 0.03, 0.01):
        rate = -math.log(theory.ball_survivors(30.0, loss)) / (loss * 30)
        assert 0.2 * loss < rate - 1 < 0.4 * loss
    assert theory.ball_survivors(40.0, 0.5) > 1e3 * math.exp(-0.5 * 40)  # slow ones, like t^-3


@pytest.mark.slow
def test_the_renewal_equation_agrees_with_flights_drawn_one_by_one():
    rng, draws, loss, times = np.random.default_rng(1), 400_000, 0.3, np.array([1.0, 4.0, 8.0])

    def weighted_speeds():
        return np.sqrt(2 * rng.gamma(2.0, size=draws))

    place = rng.normal(size=(draws, 3))
    place *= (rng.random(draws) ** (1 / 3) / np.linalg.norm(place, axis=1))[:, None]
    velocity = rng.normal(size=(draws, 3))
    v2, along = (velocity**2).sum(1), (place * velocity).sum(1)
    clock = (np.sqrt(along**2 + v2 * (1 - (place**2).sum(1))) - along) / v2
    end = np.full(draws, np.inf)
    while not np.isfinite(end).all():
        lost = ~np.isfinite(end) & (rng.random(draws) < loss)
        end[lost] = clock[lost]
        clock = clock + 2 * np.sqrt(rng.random(draws)) / weighted_speeds()
    counted = (end[:, None] > times * theory.ball_flight_time(1.0, 1.0)).mean(axis=0)
    exact = theory.ball_survivors(times, loss)
    assert np.all(np.abs(counted - exact) < 4.5 * np.sqrt(exact * (1 - exact) / draws))


# ---- counted ----


@slow
def test_what_effuses_carries_two_kt_and_unweighted_speeds_are_rejected():
    """kT = m sigma^2 = 2 J."""
    hole = tp.Disk(radius=1.0)
    meter = tp.Detector(hole, "beam", moments=True)

    def energy(speed):
        scene = tp.Scene(tp.Source(hole, tp.Effusive(exitance=1.0, speed=speed, mass=2.0)), detectors=meter)
        return tp.simulate(scene, particles=1_000_000, seed=1)["beam"].mean_energy_out

    assert_agrees(energy(GAS), 4.0, FALSE_ALARM)
    assert_rejected(energy(UNWEIGHTED), 4.0)
    assert energy(UNWEIGHTED).value == pytest.approx(3.0, rel=0.01)  # that of the gas


@slow
def test_speeds_of_the_beam_are_flux_weighted_bin_by_bin():
    shares = effusion.beam_shares(run(setting="beam").result)
    edges = effusion.SPEEDS
    assert_agrees(shares, theory.share_of_crossers(edges[:-1], edges[1:], 1.0), FALSE_ALARM)
    assert_rejected(shares, theory.share_of_gas(edges[:-1], edges[1:], 1.0))


@slow
def test_a_wind_crosses_by_the_drifting_law_and_rms_speed_or_a_turned_drift_are_rejected():
    n_sigma = 2.5  # so that A.drifting_maxwellian_flux is met
    exact = {
        -0.5: 0.35291916596960327,
        0.0: 0.9973557010035817,
        0.5: 2.1206861189359723,
        2.0: 7.072796728100218,
    }
    for ratio, flux in exact.items():
        rows = run(2_000_000, setting="wind", speed_ratio=ratio)
        one_way = rows[effusion.ONE_WAY].estimate * n_sigma
        assert_agrees(one_way, flux, FALSE_ALARM)
        assert_agrees(rows[effusion.NET].estimate, math.sqrt(2) * ratio, FALSE_ALARM)
        if ratio:
            turned = theory.drifting_flux_density(n_sigma, 1.0, -math.sqrt(2) * ratio)
            assert_rejected(one_way, turned)
        else:
            assert_rejected(one_way, n_sigma * math.sqrt(3) / 4)  # n v/4 with the root mean square


@slow
def test_a_burst_arrives_bin_by_bin_and_a_clock_half_a_bin_off_is_rejected():
    for setting, past in effusion.PAST.items():
        arrived, edges = effusion.arrivals(run(setting=setting).result), effusion.CLOCKS[setting]
        shifted = edges + np.diff(edges, append=2 * edges[-1] - edges[-2]) / 2
        keep = slice(1, None)  # nothing arrives in the first bin of the isotropic burst
        assert_agrees(arrived[keep], np.diff(past(1.0, edges, 1.0))[keep], FALSE_ALARM)
        assert_rejected(arrived[keep], np.diff(past(1.0, shifted, 1.0))[keep])


def closed_ball(speed, accommodation=1.0):
    """A ball of gas within walls of `speed`, its hits counted by time over 20 flights; sigma and radius are 1."""
    ball, flight = tp.Sphere(radius=1.0), theory.ball_flight_time(1.0, 1.0)
    wall = tp.Mixture({tp.Mirror(): 1 - accommodation, tp.Diffuse(1.0, speed=speed): accommodation})
    scene = tp.Scene(
        tp.Source(ball, tp.Gas(number=1.0, speed=GAS)),
        tp.Surface(ball, wall, name="wall"),
        tp.Detector("wall", side="inside", times=10, moments=True),
        duration=20 * flight,
    )
    return tp.simulate(scene, particles=100_000, seed=1)["wall"]


@slow
@pytest.mark.parametrize("accommodation", [1.0, 0.3])
def test_walls_of_the_gas_own_temperature_leave_it_as_it_is(accommodation):
    """n v/4 and 2 kT arrive at all times, to 20 flights."""
    wall = closed_ball(GAS, accommodation)
    density = 3 / (4 * math.pi)
    assert_agrees(wall.irradiance, theory.effusive_flux_density(density, 1.0), FALSE_ALARM)
    assert_agrees(wall.mean_energy_in, 4.0, FALSE_ALARM)


@slow
def test_walls_that_forget_the_flux_weighting_are_rejected():
    wall = closed_ball(UNWEIGHTED)
    assert_rejected(wall.irradiance, theory.effusive_flux_density(3 / (4 * math.pi), 1.0))
    assert_rejected(wall.mean_energy_in, 4.0)


@slow
@pytest.mark.parametrize("loss", [0.1, 0.5, 1.0])
def test_a_leaky_ball_empties_by_the_renewal_law_not_by_the_exponential(loss):
    left = effusion.share_left(run(300_000, setting="ball", loss=loss).result)[:10]
    flights = np.arange(1, 11)
    assert_agrees(left, theory.ball_survivors(flights, loss), FALSE_ALARM)
    assert_rejected(left, np.exp(-loss * flights))


@slow
def test_a_leaky_ball_keeps_its_books():
    result = run(20_000, setting="ball").result
    alive = result["ball"].alive
    assert np.all(np.diff(alive.value) < 0)
    assert alive[-1].value == pytest.approx(result.ledger["in_flight"].value, rel=1e-14)


@slow
def test_a_box_with_a_small_hole_empties_by_the_exponential():
    outcome = run(300_000, setting="box")
    assert len(outcome.rows) == 5
    judge([outcome])
    assert_rejected(outcome[effusion.ENERGY].estimate, 1.5)


@slow
def test_a_large_hole_empties_a_box_faster_by_about_its_share_of_the_walls():
    """And no closed form is claimed for it."""
    outcome = run(300_000, setting="box", hole=0.1)
    assert all(math.isnan(row.exact) for row in outcome.rows)
    left = effusion.share_left(outcome.result)[9]
    assert_rejected(left, math.exp(-0.1 * 10))
    excess = -math.log(left.value) / (0.1 * 10) - 1
    assert excess / 0.1 == pytest.approx(1.28, abs=0.05)


@slow
def test_rows_hold_for_any_gas_and_wall():
    changed = {"temperature": 4.0, "mass": 1e-20, "accommodation": 1.0, "loss": 0.9}
    assert len(judge(run_experiment(effusion, changed, particles=200_000, seed=1))) > 20
