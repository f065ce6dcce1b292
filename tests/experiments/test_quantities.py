"""Each quantity follows from radiance; what adds up does, and what does not stays; each law beside a planted fault.

Each statistical test fails right code in one of 10^5 seeds; the seed is 1.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_rejected
from tests.sim_runs import judge
from transport.sims import quantities as sim
from transport.theory import solid_angles
from transport.verification.experiment import run_experiment

pytestmark = pytest.mark.slow  # runs of a million particles

FALSE_ALARM = 1e-5


@pytest.fixture(scope="module")
def outcomes():
    return run_experiment(sim, particles=1_000_000, seed=1, threads=2)


@pytest.fixture(scope="module")
def first(outcomes):
    """The first outcome of each show."""
    return {o.given["show"]: o for o in reversed(outcomes)}


def test_all_rows_agree(outcomes):
    assert len(judge(outcomes)) > 50


# ---- integrals of radiance ----


def test_the_sums_of_binned_radiance_are_the_counts(first):
    outcome = first["integrals"]
    assert outcome[sim.DIFFERENCE].estimate.exact
    assert outcome[sim.DIFFERENCE].estimate.value == 0
    for key, name in sim.SUMMED.items():
        if key != "φ":
            assert outcome[name].exact == outcome[sim.COUNTED[key]].exact


def test_bins_of_radiance_give_the_fluence_rate_as_they_get_narrow(monkeypatch):
    """Planted: the means of bins by cosθ taken for means by dω, which 20 bins tell and 2000 do not."""
    fine = sim.mean_fluence_rate(sim.RADIUS, sim.APART)
    off = []
    for bins in (20, 200, 2000):
        monkeypatch.setitem(sim.BINS, "mu", bins)
        off.append(sim.binned_fluence_rate(sim.RADIUS, sim.APART) / fine - 1)
    assert off[0] > off[1] > off[2] > 0
    assert off[0] == pytest.approx(0.0012, rel=0.01)
    assert off[2] < 1e-6
    monkeypatch.undo()
    result = tp.simulate(sim.scene("integrals"), particles=4_000_000, seed=1, sampling="sobol")
    rows, exact = sim.measure(result), sim.exact(show="integrals")
    for name in (sim.SUMMED["φ"], sim.COUNTED["φ"], sim.COUNTED["E"]):
        assert_agrees(rows[name], exact[name], FALSE_ALARM)
    assert_rejected(rows[sim.SUMMED["φ"]], exact[sim.COUNTED["φ"]])


def test_a_sum_without_its_cosine_is_rejected(first):
    """Planted: E = ∫L dω, and M = 2π L."""
    outcome = first["integrals"]
    assert_rejected(outcome[sim.SUMMED["φ"]].estimate, outcome[sim.COUNTED["E"]].exact)
    assert_rejected(outcome[sim.SUMMED["E"]].estimate, outcome[sim.COUNTED["φ"]].exact)
    assert_rejected(outcome[sim.SUMMED["M"]].estimate, 2 * math.pi * outcome.given["radiance"])


def test_intensity_without_the_projected_area_is_rejected(first):
    row = first["integrals"][sim.COUNTED["I"]]
    assert_agrees(row.estimate, row.exact, FALSE_ALARM)
    assert_rejected(row.estimate, first["integrals"].given["radiance"] * math.pi * sim.RADIUS**2)


@pytest.mark.parametrize("distance", [0.3, 0.5, 2.0, 30.0])
def test_the_mean_fluence_rate_is_a_sum_over_pairs_of_points(distance):
    """Beside plain sums over both disks, and L Ω far away."""
    rng = np.random.default_rng(1)
    places = [
        np.sqrt(rng.random(400_000)) * sim.RADIUS * np.exp(2j * math.pi * rng.random(400_000))
        for _ in range(2)
    ]
    values = distance / (np.abs(places[0] - places[1]) ** 2 + distance**2) ** 1.5 * math.pi * sim.RADIUS**2
    error = values.std() / math.sqrt(len(values))
    assert abs(values.mean() - sim.mean_fluence_rate(sim.RADIUS, distance)) < 4.5 * error
    far = solid_angles.disk_solid_angle(sim.RADIUS, 3000.0)
    assert sim.mean_fluence_rate(sim.RADIUS, 3000.0) == pytest.approx(far, rel=1e-6)


# ---- what adds up ----


def test_power_is_extensive_and_irradiance_is_not(first):
    doubled, kept = first["area"][sim.DOUBLED], first["area"][sim.KEPT]
    assert_agrees(doubled.estimate, 2.0, FALSE_ALARM)
    assert_rejected(doubled.estimate, 1.0)
    assert_agrees(kept.estimate, 1.0, FALSE_ALARM)
    assert_rejected(kept.estimate, 2.0)


def test_two_lamps_give_the_sum_arrival_by_arrival(first):
    outcome = first["superposition"]
    for name in (sim.UNEXPLAINED, sim.EXCESS):
        assert outcome[name].estimate.exact
        assert outcome[name].estimate.value == 0
    in_the_middle = f"E {sim.BOTH}, in the middle"
    e_a, e_b = (outcome[f"E {name}, in the middle"].exact for name in sim.PLACES)
    assert_agrees(outcome[in_the_middle].estimate, e_a + e_b, FALSE_ALARM)
    assert_rejected(outcome[in_the_middle].estimate, (math.sqrt(e_a) + math.sqrt(e_b)) ** 2)
    assert_rejected(outcome[in_the_middle].estimate, max(e_a, e_b))


def test_a_third_lamp_is_noticed():
    """Planted: light that neither lamp has sent."""
    scene = sim.scene("superposition")
    stray = tp.Source(tp.Point(position=(0, 0, 0.3)), tp.Isotropic(power=1.0))
    scene = replace(scene, sources=(*scene.sources, stray))
    rows = sim.measure(tp.simulate(scene, particles=100_000, seed=1))
    assert rows[sim.UNEXPLAINED].value > 0
    assert rows[sim.EXCESS].value > 0


# ---- directions, exposure, photons, time ----


def test_the_incident_direction_points_to_the_lamp(first):
    """Planted: the directions of flight, seen from above, which are mirrored."""
    outcome = first["facing"]
    assert_agrees(outcome[sim.ARRIVING].estimate, outcome[sim.LEAVING].exact, FALSE_ALARM)
    assert_rejected(outcome[sim.ARRIVING].estimate, 0.0)
    assert outcome[sim.MIRRORED].estimate.value == 0


def test_film_counts_irradiance_times_time(first):
    outcome, level = first["exposure"], first["exposure"].given["radiance"]
    for film, share in sim.FILMS.items():
        row = outcome[f"H, {film}, 1/4 s"]
        assert_agrees(row.estimate, level * share / 4, FALSE_ALARM)
        assert_rejected(row.estimate, level * share)  # that of a second
    assert_rejected(outcome[sim.SAME].estimate, 1.05)
    assert_rejected(outcome[sim.TURNED].estimate, level)  # without the cosine
    assert_rejected(outcome[sim.FLUENCE].estimate, level * math.cos(sim.TURN))  # with it


def test_a_photon_has_the_energy_h_nu(first):
    outcome = first["photons"]
    assert sim.PHOTON == pytest.approx(3.6117e-19, rel=1e-4)
    assert_agrees(outcome[sim.CARRIED].estimate, outcome[sim.CARRIED].exact, FALSE_ALARM)
    slip = outcome.given["power"] / (sim.PLANCK / sim.WAVELENGTH) * sim.pupil_share(outcome.given["distance"])
    assert_rejected(outcome[sim.THROUGH].estimate, slip)  # E = h/λ


@pytest.mark.parametrize("place", sim.WATCHERS)
def test_the_lamp_is_seen_when_its_light_arrives(place):
    """Planted: light that takes no time, or half of it; the steps lie within the bins that are left out."""
    result = tp.simulate(sim.scene("plenoptic", place=place), particles=400_000, seed=1)
    rows, exact = sim.measure(result), sim.exact(show="plenoptic", place=place)
    before, after, beside = sim._moments(place)
    assert rows[before].value == 0 == rows[beside].value
    assert_agrees(rows[after], exact[after], FALSE_ALARM)
    first, last = sim.arrival(sim.WATCHERS[place])
    far = math.dist(sim.WATCHERS[place], (0, 0, 0)) / tp.speed_of_light
    assert first < far < last < sim.CLOCK
    seen = result["in time"].radiance[:, 0]
    ticks = np.linspace(0, sim.CLOCK, sim.TICKS + 1)
    early = np.flatnonzero((ticks[:-1] > 0.5 * far) & (ticks[1:] < first))
    assert len(early)
    for tick in early:
        assert seen[int(tick)].value == 0  # light twice as fast would be there
