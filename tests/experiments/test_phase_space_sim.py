"""Phase space and pressure measured: every bin of every picture, conservation of counts, and planted faults.

All runs have seed 1.  Each judgement fails right code in one of 10^5 seeds, or shares that among its rows.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from matplotlib.figure import Figure

import transport as tp
from tests.agreement import assert_agrees, assert_follows, assert_rejected
from tests.synthetic import EVEN_RUN
from transport.sims import phase_space, pressure
from transport.statistics.estimates import EstimateArray
from transport.theory import free_flight, phase_mixing
from transport.verification.experiment import run_experiment
from transport.viz import phase_space as viz

pytestmark = pytest.mark.slow  # runs of millions of particles

FALSE_ALARM = 1e-5
MANY = 3_000_000
STARTS = tuple(phase_space.TIMES)


@pytest.fixture(scope="module")
def clouds():
    """Each start of phase space."""
    outcomes = run_experiment(phase_space, particles=MANY, seed=1, threads=2)
    return {outcome.parameters["start"]: outcome for outcome in outcomes}


@pytest.fixture(scope="module")
def presses():
    """Each case of pressure."""
    outcomes = run_experiment(pressure, particles=300_000, seed=1, threads=2)
    return {tuple(outcome.parameters.values()): outcome for outcome in outcomes}


def counts_of(share, particles=MANY):
    """Numbers of histories from shares of the one particle that they stand for."""
    counts = np.asarray(share) * particles
    np.testing.assert_allclose(counts, np.rint(counts), rtol=0, atol=1e-3)
    return np.rint(counts)


# Phase space


def test_nothing_is_between_the_filaments_of_a_water_bag(clouds):
    empty = [row for row in clouds["waterbag"].rows if "outside" in row.name]
    assert [row.estimate.value for row in empty] == [0.0] * 3
    assert all(row.estimate.exact for row in empty)


@pytest.mark.parametrize("start", STARTS)
def test_every_cell_of_phase_space_follows_its_law(clouds, start):
    """Chi-square over all cells of each picture and what is outside of it."""
    found = clouds[start].result[start]
    x, v = phase_space.CELLS[start]
    for k in range(len(phase_space.TIMES[start])):
        counts = counts_of(np.append(found.number[k].value.ravel(), found.outside[k].value))
        shares = phase_space.expected(start, k)["picture"] * np.outer(np.diff(x), np.diff(v))
        beyond = max(0.0, 1 - shares.sum())
        assert counts.sum() == MANY
        assert_follows(counts, np.append(shares.ravel(), beyond), FALSE_ALARM / 20)


@pytest.mark.parametrize("start", STARTS)
def test_particles_in_bins_and_outside_are_all_that_are_alive(clouds, start):
    result = clouds[start].result
    for picture in result.scene.detectors:
        found = result[picture.name]
        total = found.number.value.reshape(np.size(picture.time), -1).sum(axis=1) + found.outside.value
        np.testing.assert_array_equal(counts_of(total), counts_of(found.alive.value))
        np.testing.assert_array_equal(counts_of(found.alive.value), MANY)


@pytest.mark.parametrize("start", ["point", "half"])
def test_mirrors_that_turn_positions_but_not_velocities_are_rejected(clouds, start):
    """Densities alone would not show it: the row of those that fly to the right does."""
    begin, law = phase_space.BOXES[start]
    k, t = len(phase_space.TIMES[start]) - 1, phase_space.TIMES[start][-1]
    unturned = sum(
        phase_mixing._free_flight_shares(2 * m + low, 2 * m + high, 0.0, 9.0, t, begin, law)
        for m in range(-6, 7)
        for low, high in ((0.0, 0.5), (-0.5, 0.0))
    )
    row = clouds[start][f"share in the left half flying right, t = {t:g} s"]
    assert_agrees(row.estimate, row.exact, FALSE_ALARM)
    assert_rejected(row.estimate, float(np.squeeze(unturned)))
    density = clouds[start].result["all"].number[k].sum("vx")
    assert_agrees(density, phase_space.expected(start, k)["number"].sum(axis=1), FALSE_ALARM)


def test_a_temperature_without_the_mean_velocity_taken_off_is_rejected(clouds):
    for k, t in enumerate(phase_space.TIMES["cloud"][1:], start=1):
        slabs = clouds["cloud"].result[f"slabs {k}"]
        row = clouds["cloud"][f"kT/m at x = 2σ, t = {t:g} s"]
        assert_agrees(row.estimate, row.exact, FALSE_ALARM)
        i = phase_space.TOLD["2σ"]
        assert_rejected(slabs.variance_vx[i] + slabs.mean_vx[i] ** 2, row.exact)


def test_a_variance_that_forgets_the_spread_over_its_slab_is_rejected(clouds):
    row = clouds["cloud"]["kT/m at x = σ, t = 5 s"]
    assert_rejected(row.estimate, free_flight.velocity_variance(5.0, *phase_space.CLOUDS["cloud"]))


def test_every_slab_of_the_cloud_has_its_density_velocity_and_temperature(clouds):
    for k in range(len(phase_space.TIMES["cloud"])):
        slabs, exact = clouds["cloud"].result[f"slabs {k}"], phase_space.expected("cloud", k)
        middle = slice(3, -3)  # further out are too few for a variance to be nearly normal
        for found, name in ((slabs.density, "n"), (slabs.mean_vx, "u"), (slabs.variance_vx, "kT/m")):
            assert_agrees(found[middle], exact[name][middle], FALSE_ALARM)


def test_a_clock_a_twentieth_of_a_second_off_is_rejected(clouds):
    for start in ("cloud", "point", "half"):
        k, late = phase_space.TIMES[start].index(0.3), 0.35
        result, expected = clouds[start].result, phase_space.expected(start, k)
        if start == "cloud":
            counted, exact = result[f"slabs {k}"].density[3:-3], expected["n"][3:-3]
            edges = counted.coords["x"]
            wrong = free_flight.bin_shares(edges, late, *phase_space.CLOUDS[start]) / np.diff(edges)
        else:
            counted, exact = result["all"].number[k].sum("vx"), expected["number"].sum(axis=1)
            wrong = phase_mixing.bin_shares(phase_space.QUARTERS[0], late, *phase_space.BOXES[start])
        assert_agrees(counted, exact, FALSE_ALARM)
        assert_rejected(counted, wrong)


def test_moments_from_bins_without_sheppard_are_rejected(clouds):
    for t, xx in {0.25: 0.3, 0.75: 0.4, 2.25: 1.3}.items():  # J.free_shear, and its start
        row = clouds["shear"][f"⟨x²⟩, t = {t} s"]
        assert row.exact == pytest.approx(xx, rel=1e-12)
        assert_agrees(row.estimate, xx, FALSE_ALARM)
        assert_rejected(row.estimate, xx + 0.25**2 / 12)
        assert clouds["shear"][f"{phase_space.EMITTANCE}, t = {t} s"].exact == pytest.approx(
            0.0575, rel=1e-12
        )


def test_a_density_that_thins_out_along_a_path_is_rejected(clouds):
    """As it would were phase space stretched like the cloud is in space."""
    cloud = phase_space.CLOUDS["shear"]
    stretched = free_flight.width(2.25, *cloud) / free_flight.width(0.25, *cloud)
    for path in phase_space.PATHS:
        first, last = (clouds["shear"][f"n along path {path}, t = {t} s"] for t in (0.25, 2.25))
        assert last.exact == pytest.approx(first.exact, rel=0.01)  # the bins' size
        ratio = last.estimate / first.estimate
        assert_agrees(ratio, last.exact / first.exact, FALSE_ALARM)
        assert_rejected(ratio, 1 / stretched)


def test_phase_space_is_the_same_in_micrometres():
    """Every batch and z of all rows, of the same histories, with the errors of single bins."""
    outcomes, plain = (
        run_experiment(phase_space, units, particles=200_000, seed=1)
        for units in ({"length": 1e-6, "speed": 300.0}, {})
    )
    for small, usual in zip(outcomes, plain, strict=True):
        for one, other in zip(small.rows, usual.rows, strict=True):
            if one.exact != 0 and not (math.isnan(one.z) and math.isnan(other.z)):
                of_small, of_usual = one.estimate.values / one.exact, other.estimate.values / other.exact
                assert of_small == pytest.approx(of_usual, rel=1e-9, abs=1e-9), f"{small.title}: {one.name}"
                assert one.z == pytest.approx(other.z, abs=1e-4), f"{small.title}: {one.name}"


# Pressure


def test_light_presses_with_a_third_on_a_mirror_and_a_sixth_on_black(presses):
    third, sixth = (presses["light", wall]["p / u, of u = 4E/c"] for wall in ("mirror", "black"))
    assert_agrees(third.estimate, 1 / 3, FALSE_ALARM)  # A.photon_pressure
    assert_agrees(sixth.estimate, 1 / 6, FALSE_ALARM)
    assert_rejected(third.estimate, 1 / 2)  # the momentum without its cosine
    assert_rejected(third.estimate, 1 / 6)  # what the mirror sends back forgotten
    assert_rejected(sixth.estimate, 1 / 3)


def test_a_diffuse_wall_is_pressed_like_a_mirror_by_a_gas_but_not_by_a_beam(presses):
    assert_agrees(presses["light", "diffuse"]["p / u, of u = 4E/c"].estimate, 1 / 3, FALSE_ALARM)
    beam = presses["light", "stream", "diffuse", 60 * tp.deg]["pressure"]
    assert_agrees(beam.estimate, beam.exact, FALSE_ALARM)
    assert_rejected(beam.estimate, presses["light", "stream", "mirror", 60 * tp.deg]["pressure"].exact)


def test_a_beam_without_one_of_its_cosines_is_rejected(presses):
    for wall in ("mirror", "black"):
        row = presses["light", "stream", wall, 60 * tp.deg]["pressure"]
        assert_agrees(row.estimate, row.exact, FALSE_ALARM)
        assert_rejected(row.estimate, 2 * row.exact)


def test_n_k_t_with_the_mean_speed_for_the_root_mean_square_is_rejected(presses):
    row = presses["gas", "mirror"]["pressure"]
    assert_agrees(row.estimate, 2.5e25 * 1.380649e-23 * 300, FALSE_ALARM)
    assert_rejected(row.estimate, row.exact * 8 / (3 * math.pi))


def test_the_shadow_of_a_black_wall_comes_back_after_two_depths():
    """The sim stops its clock just before: a longer one would measure less."""
    scene = pressure.scene(wall="black")
    longer = tp.Scene(scene.sources, scene.surfaces, scene.detectors, duration=3 * scene.duration)
    shaded = tp.simulate(longer, particles=400_000, seed=1)["wall"].pressure
    assert_rejected(shaded, pressure.exact(wall="black")["pressure"])


# Pictures


def portrait(shape=(4, 3), unit="m^-2 s", **coords):
    values = np.random.default_rng(1).poisson(50.0, size=(len(EVEN_RUN), *shape)).astype(float)
    names = ("x", "vx")[: len(shape)]
    edges = {name: np.linspace(0, 1, n + 1) for name, n in zip(names, shape, strict=True)}
    return EstimateArray(values, EVEN_RUN, unit, names, edges | coords)


def test_phase_portraits_refuse_what_does_not_fit(tmp_path):
    path = tmp_path / "new" / "portraits.png"
    for panels, exact, words in (
        ({}, None, "at least one"),
        ({"a": portrait((4,))}, None, "two axes"),
        ({"a": portrait(), "b": portrait(unit="m^-1")}, None, "one unit"),
        ({"a": portrait()}, {"b": np.ones((4, 3))}, "must be one of"),
        ({"a": portrait()}, {"a": np.ones((3, 4))}, "with its bins"),
    ):
        with pytest.raises(ValueError, match=words):
            viz.phase_portraits(panels, path, exact=exact)
    assert not path.exists()
    over = {"contours": {"b": lambda x, v: np.exp(-(x**2) - v**2)}, "marks": {"a": {"c": (0.5, 0.5)}}}
    exact = {"a": np.outer(np.arange(40.0, 60.0, 5.0), np.ones(3))}
    assert isinstance(viz.phase_portraits({"a": portrait()}), Figure) and not path.exists()
    viz.phase_portraits({"a": portrait(), "b": portrait()}, path, exact=exact, **over)
    assert path.read_bytes().startswith(b"\x89PNG")
