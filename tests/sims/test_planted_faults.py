"""Tests can fail: for each law there is a wrong answer that the judge of its test rejects while the right one passes.

Each judgement fails right code in one of 10^5 seeds; the seed is 1.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.agreement import assert_agrees, assert_rejected, assert_z_spread
from transport import simulate
from transport.results.solid_angles import solid_angles_of
from transport.sims import diffuse_box, inverse_square, lambert_disk, photon_gas
from transport.statistics.estimates import Estimate
from transport.statistics.replicates import Batches
from transport.theory import effusion
from transport.verification.experiment import run_experiment

FALSE_ALARM = 1e-5


def run(module, **parameters):
    """The first case of a sim with these parameters."""
    return run_experiment(module, parameters, particles=1_000_000, seed=1)[0]


def test_a_stream_without_its_cosine_is_rejected():
    row = run(photon_gas, motion="stream", tilt=math.pi / 3)["net"]
    assert_agrees(row.estimate, row.exact, FALSE_ALARM)
    assert_rejected(row.estimate, row.exact / math.cos(math.pi / 3))


def test_bins_of_a_gas_without_their_cosine_are_rejected():
    result = simulate(photon_gas.scene(1.0, 1.0), particles=1_000_000, seed=1)
    front = result["photons on the front"].flux_density
    assert_agrees(front, photon_gas.flux_densities(1.0, 1.0), FALSE_ALARM)
    assert_rejected(front, effusion.radiance(1.0, 1.0))
    assert_rejected(front, effusion.one_way_flux_density(1.0, 1.0) / (2 * math.pi))


def test_a_fall_with_one_over_r_is_rejected():
    outcome = run(inverse_square, emitter="point")
    for name, distance in inverse_square.DISTANCES.items():
        row = outcome[f"irradiance at {name}"]
        assert_agrees(row.estimate, row.exact, FALSE_ALARM)
        if distance != 1:  # where both are one
            assert_rejected(row.estimate, row.exact * distance)
    ratio = outcome["E(1 mm) / E(1 km)"]
    assert_agrees(ratio.estimate, 1e12, FALSE_ALARM)
    assert_rejected(ratio.estimate, 1e6)


def test_a_disk_taken_for_a_point_at_five_diameters_is_rejected():
    row = run(inverse_square, emitter="disk", widths=5.0)["irradiance / inverse square"]
    assert_agrees(row.estimate, 1 / 1.01, FALSE_ALARM)
    assert_rejected(row.estimate, 1.0)


@pytest.mark.parametrize(("distance", "name"), [(0.0, "power"), (0.0, "exitance"), (2.0, "irradiance")])
def test_a_forgotten_pi_is_rejected(distance, name):
    row = run(lambert_disk, distance=distance)[name]
    assert_agrees(row.estimate, row.exact, FALSE_ALARM)
    assert_rejected(row.estimate, row.exact / math.pi)


def test_bins_divided_by_solid_angle_instead_of_projected_solid_angle_are_rejected():
    meter = run(lambert_disk, distance=0.0).result["meter"]
    solid, projected = solid_angles_of(meter.detector, meter.detector.shape)
    assert_agrees(meter.radiance_out, 100.0, FALSE_ALARM)
    assert_rejected(meter.radiance_out * (projected / solid), 100.0)
    for i in range(len(solid)):  # each bin by itself
        assert_agrees(meter.radiance_out[i], 100.0, FALSE_ALARM)
        assert_rejected(meter.radiance_out[i] * (projected[i] / solid[i]), 100.0)


def test_a_furnace_that_forgets_what_is_reflected_is_rejected():
    outcome = run(diffuse_box, albedo=0.5, emitting="all walls")
    for wall in diffuse_box.WALLS:
        row = outcome[f"E, {wall}"]
        assert_agrees(row.estimate, row.exact, FALSE_ALARM)
        assert_rejected(row.estimate, 0.5 * row.exact)


def test_a_wall_that_reflects_a_millionth_too_much_is_rejected():
    """M - ρE is sharp: the part of E that is reflected is known to 1e-12."""
    walls = simulate(diffuse_box.scene(albedo=0.5), particles=100_000, seed=1)
    floor = walls["floor"]
    for albedo, is_right in ((0.5, True), (0.500001, False)):
        own = diffuse_box.sharp(floor.exitance - albedo * floor.irradiance, of=floor.exitance)
        assert (own.value == 0 and own.exact) == is_right


# ---- streams ----

SEEDS, BATCHES, HISTORIES, SHARE = 500, 16, 64, 0.5


def share_of_hits(seed, step):
    """An estimate of the share of particles that hit; the stream of each batch begins `step` draws after the last's."""
    words = np.random.Generator(np.random.Philox(key=seed)).random(step * (BATCHES - 1) + HISTORIES)
    starts = step * np.arange(BATCHES)
    hits = words[starts[:, None] + np.arange(HISTORIES)] < SHARE
    return Estimate(hits.mean(axis=1), Batches(np.full(BATCHES, HISTORIES)), "1")


def scores_of(step):
    estimates = (share_of_hits(seed, step) for seed in range(SEEDS))
    return np.array([(estimate.value - SHARE) / estimate.error for estimate in estimates])


def test_streams_one_step_apart_are_rejected():
    """Batches that share all but one of their draws agree with each other far better than with the truth."""
    assert_z_spread(scores_of(HISTORIES), BATCHES - 1, FALSE_ALARM)
    with pytest.raises(AssertionError, match="spread"):
        assert_z_spread(scores_of(1), BATCHES - 1, FALSE_ALARM)


def test_streams_that_share_a_third_of_their_draws_are_rejected():
    with pytest.raises(AssertionError, match="spread"):
        assert_z_spread(scores_of(2 * HISTORIES // 3), BATCHES - 1, FALSE_ALARM)
