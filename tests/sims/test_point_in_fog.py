"""A point of light in fog measured: shells by both estimators, net flux, spread in time, and planted faults.

All runs have seed 1.  Each judgement fails right code in one of 10^5 seeds, or shares that among its rows.
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.agreement import assert_agrees, assert_follows, assert_rejected, smallest_bias
from transport.sims import point_in_fog
from transport.theory import point_source, random_flights
from transport.verification.experiment import run_experiment

pytestmark = pytest.mark.slow  # runs of millions of particles

FALSE_ALARM = 1e-5
PARTICLES = 500_000
SHELLS = point_in_fog.SHELLS


@pytest.fixture(scope="module")
def outcomes():
    return run_experiment(point_in_fog, particles=PARTICLES, seed=1, threads=2)


@pytest.fixture(scope="module")
def steady(outcomes):
    """By albedo."""
    return {o.parameters["albedo"]: o for o in outcomes if o.parameters["subject"] == "steady"}


@pytest.fixture(scope="module")
def clocks(outcomes):
    """By g."""
    return {o.parameters["g"]: o for o in outcomes if o.parameters["subject"] == "clock"}


def judge(outcomes):
    rows = [(o, row) for o in outcomes for row in o.rows]
    for outcome, row in rows:
        try:
            assert_agrees(row.estimate, row.exact, FALSE_ALARM / len(rows))
        except AssertionError as error:
            raise AssertionError(f"{outcome.title}: {row.name}: {error}") from None
    return rows


def test_every_row_is_met_and_would_show_a_bias(outcomes):
    for outcome, row in judge(outcomes):
        bias = smallest_bias(row.estimate, FALSE_ALARM)
        assert bias < 0.4, f"{outcome.title}: {row.name}: {bias:.1%}"


@pytest.mark.parametrize("albedo", [0.5, 0.8])
@pytest.mark.parametrize("name", point_in_fog.ESTIMATORS)
def test_what_has_not_collided_is_not_all(steady, albedo, name):
    means = point_source.shell_means(SHELLS)
    for estimate, direct in zip(steady[albedo].result[name].fluence_rate, means, strict=True):
        if name == "track" or direct < 1:  # collisions in the first shells are few
            assert_rejected(estimate, direct)


def test_the_fluence_rate_at_the_middle_of_a_shell_is_not_its_mean(steady):
    track = steady[0.8].result["track"].fluence_rate
    for i in (0, 1, 2):
        middle = (SHELLS[i] + SHELLS[i + 1]) / 2
        assert_rejected(track[i], point_source.fluence_rate(middle, 1.0, 0.8))


def test_diffusion_is_rejected_near_the_source_and_where_much_is_absorbed(steady):
    x, w = np.polynomial.legendre.leggauss(20)
    for albedo, shells in ((0.8, range(5)), (0.5, range(len(SHELLS) - 1))):
        track = steady[albedo].result["track"].fluence_rate
        for i in shells:
            r = SHELLS[i] + (SHELLS[i + 1] - SHELLS[i]) * (1 + x) / 2
            mean = (w * r**2 * point_source.diffusion(r, albedo)).sum() / (w * r**2).sum()
            assert_rejected(track[i], mean)


def test_what_flows_out_is_what_is_not_absorbed_within(steady):
    for albedo, outcome in steady.items():
        for radius in point_in_fog.SPHERES:
            row = outcome[point_in_fog._through(radius)]
            assert_agrees(row.estimate, 1 - point_source.absorbed_within(radius, 1.0, albedo), FALSE_ALARM)
            assert_rejected(row.estimate, 1.0)  # as if nothing were absorbed
            assert_rejected(row.estimate, np.exp(-radius))  # only what has not collided


def test_what_is_absorbed_within_the_ball_and_what_leaves_it_are_all(steady):
    for albedo, outcome in steady.items():
        row = outcome[point_in_fog._within()]
        assert_agrees(row.estimate, 1 - point_source.net_flux(SHELLS[-1], 1.0, albedo), FALSE_ALARM)


def test_light_spreads_neither_as_in_straight_flight_nor_as_in_diffusion(clocks):
    for g, outcome in clocks.items():
        for t in point_in_fog.TIMES:
            row = outcome[point_in_fog._spread(t)]
            assert_agrees(row.estimate, random_flights.mean_square_displacement(t, g), FALSE_ALARM)
            assert_rejected(row.estimate, t**2)
            assert_rejected(row.estimate, 2 * t / (1 - g))


def test_a_mean_cosine_that_is_forgotten_or_a_hundredth_off_is_rejected(clocks):
    late = clocks[0.9][point_in_fog._spread(point_in_fog.TIMES[-1])]
    assert_rejected(late.estimate, random_flights.mean_square_displacement(point_in_fog.TIMES[-1], 0.0))
    assert_rejected(late.estimate, random_flights.mean_square_displacement(point_in_fog.TIMES[-1], 0.89))
    early = clocks[0.0][point_in_fog._spread(point_in_fog.TIMES[-1])]
    assert_rejected(early.estimate, random_flights.mean_square_displacement(point_in_fog.TIMES[-1], 0.03))


@pytest.mark.parametrize("time", point_in_fog.PULSES)
def test_a_burst_follows_the_plane_pulse(clocks, time):
    """Chi-square over 50 bins; the pulse of a time 3 % later is rejected."""
    number = clocks[0.0].result[point_in_fog._counter(time)].number.value
    counts = np.rint(number * PARTICLES).reshape(50, -1).sum(axis=1)
    edges = np.linspace(-time, time, 51)
    shares = random_flights.plane_pulse_shares(edges, time)
    assert counts.sum() == PARTICLES
    assert_follows(counts, shares / shares.sum(), FALSE_ALARM / 3)
    late = random_flights.plane_pulse_shares(edges, 1.03 * time)
    with pytest.raises(AssertionError, match="chi-square"):
        assert_follows(counts, late / late.sum(), FALSE_ALARM)


def test_no_particle_ends_while_the_clock_runs(clocks):
    for outcome in clocks.values():
        assert outcome.result.ledger["in_flight"].value == pytest.approx(1.0, rel=1e-12)


def test_fog_in_millimetres_is_a_million_times_as_bright():
    settings = {"subject": "steady", "mean_free_path": 1e-3}
    small = run_experiment(point_in_fog, settings, particles=50_000, seed=1)
    assert len(judge(small)) > 30
    large = point_in_fog.exact(albedo=0.5)
    for name, value in small[0].result["track"].fluence_rate.coords.items():
        np.testing.assert_allclose(value, SHELLS * 1e-3, err_msg=name)
    first = small[0].rows[0]
    assert first.exact == pytest.approx(1e6 * large[first.name], rel=1e-12)
