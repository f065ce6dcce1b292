"""The cloud: its direct light by place, layers against the slab, a plain walk through the same voxels, and
its picture.

Each statistical judgement fails right code in one of 10^5 seeds; the seed is 1.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_rejected, smallest_bias
from transport.sims import cloud as sim
from transport.sims.cloud import Voxels, along_sight
from transport.theory import ordinates
from transport.verification.experiment import run_experiment

pytestmark = pytest.mark.slow  # runs of millions of particles

FALSE_ALARM = 1e-5
HALF_SHADOW = "direct light in half-shadow"
RUNS = 300_000
DOWN = (math.sin(40 * tp.deg), 0.0, -math.cos(40 * tp.deg))


@pytest.fixture(scope="module")
def outcomes():
    return run_experiment(sim, particles=RUNS, seed=1, threads=1)


def run(scene, particles=RUNS, seed=1):
    return tp.simulate(scene, particles=particles, seed=seed, threads=1)


def only(scene, *names):
    """The scene with these detectors alone: faster."""
    return dataclasses.replace(scene, detectors=[d for d in scene.detectors if d.name in names])


def with_field(scene, change):
    """The scene with another field of coefficients in its cloud."""
    *others, cloud = scene.surfaces
    grid = cloud.inside
    other = dataclasses.replace(grid, absorption=change(grid.absorption), scattering=change(grid.scattering))
    body = tp.Surface(cloud.shape, tp.Transparent(), "cloud", inside=other)
    return dataclasses.replace(scene, surfaces=[*others, body])


def test_the_cloud_is_always_the_same_and_of_a_clouds_depth():
    field = sim.cumulus(0.05)
    depths = field.sum(axis=2) * sim.VOXEL
    assert field.max() == 0.05
    assert (field[[0, -1]] == 0).all() and (field[:, [0, -1]] == 0).all() and (field[:, :, -1] == 0).all()
    assert depths.max() == pytest.approx(26.998, abs=0.01)
    assert (depths > 0.1).mean() == pytest.approx(0.495, abs=0.002)
    assert (sim.cumulus(0.1) == 2 * field).all()


CHANGES = {"mirrored": lambda f: f[:, ::-1], "a voxel aside": lambda f: np.roll(f, 1, axis=0)}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_another_cloud_throws_another_shadow(outcomes, change):
    """Seen by χ² of all bins."""
    expected = sim.SUN * -DOWN[2] * sim.direct_means(DOWN, 0.05)
    other = run(with_field(only(sim.scene(), "light", "direct"), change))
    assert_agrees(sim.chi_square(outcomes[0].result["direct"].irradiance, expected), 1.0, FALSE_ALARM)
    assert_rejected(sim.chi_square(other["direct"].irradiance, expected), 1.0)


def test_the_mean_depth_of_a_bin_is_not_what_comes_through(outcomes):
    """Gaps let through more than their mean does: exp of minus the mean depth of each bin is rejected."""
    row, means = outcomes[0][HALF_SHADOW], sim.direct_means(DOWN, 0.05)
    fine = (np.arange(180) - 89.5) * sim.BIN / 3
    places = np.meshgrid(sim.shadow_middle(DOWN) + fine, fine, [0.0], indexing="ij")
    starts = np.stack([each.ravel() for each in places], axis=1)
    depths = sim.optical_depths(sim.cumulus(0.05), sim.LOW, sim.HIGH, starts, [-d for d in DOWN])
    low, high = sim.ZONES["half-shadow"]
    held = (means >= low) & (means < high)
    through = np.exp(-depths).reshape(60, 3, 60, 3).mean(axis=(1, 3))[held].mean()
    assert through == pytest.approx(row.exact, rel=0.02)  # nine lines a bin
    assert_rejected(row.estimate, np.exp(-depths.reshape(60, 3, 60, 3).mean(axis=(1, 3)))[held].mean())


@pytest.mark.parametrize("zenith", [0.0, 60 * tp.deg])
def test_at_other_hours_the_shadow_is_known_as_well(zenith):
    [outcome] = run_experiment(
        sim, {"sky": "cumulus", "zenith": zenith}, particles=300_000, seed=1, threads=1
    )
    for row in outcome.rows:
        assert_agrees(row.estimate, row.exact, FALSE_ALARM / len(outcome.rows))
    assert smallest_bias(outcome[HALF_SHADOW].estimate, FALSE_ALARM) < 0.3


def test_without_scattered_light_the_direct_is_all():
    scene = only(sim.scene(albedo=0.0, ground=0.0), "light", "direct")
    result = run(scene, 20_000)
    assert np.array_equal(result["light"].irradiance.values, result["direct"].irradiance.values)


@pytest.mark.parametrize("g", [0.0, 0.85])
def test_equal_layers_are_a_homogeneous_medium(g):
    """One voxel, eight alike, and a Slab filled with the Medium: R and T of all are those of theory."""
    medium = tp.Medium(absorption=2e-4, scattering=3.8e-3, phase=tp.HenyeyGreenstein(g))
    layers = sim.scene(sky="layers", g=g)
    box = layers.surfaces[0].shape
    slab = ordinates.slab(640 * 4e-3, 0.95, ordinates.henyey_greenstein(g), -DOWN[2])
    bodies = [
        tp.Surface(tp.Slab(center=box.center, thickness=640.0), tp.Transparent(), "cloud", inside=medium)
    ]
    for n in (1, 8):
        even = np.full((1, 1, n), 1.0)
        grid = tp.Grid(box=box, absorption=2e-4 * even, scattering=3.8e-3 * even, phase=medium.phase)
        bodies.append(tp.Surface(box, tp.Transparent(), "cloud", inside=grid))
    for body in bodies:
        result = run(dataclasses.replace(layers, surfaces=[body]), 60_000)
        rows = sim.measure(result)
        assert_agrees(rows[sim.REFLECTED], slab.reflected, FALSE_ALARM)
        assert_agrees(rows[sim.THROUGH], slab.transmitted, FALSE_ALARM)


@pytest.mark.filterwarnings("error")
def test_a_thin_cloud_has_no_deep_shadow_and_no_row_of_it():
    [outcome] = run_experiment(
        sim, {"sky": "cumulus", "extinction": 1e-4}, particles=20_000, seed=1, threads=1
    )
    names = [row.name for row in outcome.rows]
    assert names == ["direct light in thin rims", "direct light in the sun", sim.ALL]
    assert names == list(sim.exact(extinction=1e-4))
    assert "shadow" not in sim.verdict([outcome])


def test_layers_that_absorb_nothing_keep_nothing():
    [outcome] = run_experiment(sim, {"sky": "layers", "albedo": 1.0}, particles=20_000, seed=1, threads=1)
    assert outcome[sim.KEPT].estimate.value == outcome[sim.KEPT].exact == 0
    assert sim.verdict([outcome]).endswith("standard errors off.") and "inf" not in sim.verdict([outcome])


def test_layers_of_another_order_are_the_same_and_of_another_depth_are_not(outcomes):
    rows, phase = outcomes[1], ordinates.henyey_greenstein(0.85)
    shallow = ordinates.slab(3.8, 0.999, phase, -DOWN[2])
    assert_rejected(rows[sim.REFLECTED].estimate, shallow.reflected)
    assert_rejected(rows[sim.THROUGH].estimate, shallow.transmitted)
    scene = sim.scene(sky="layers")
    result = run(with_field(scene, lambda f: f[:, :, ::-1]), 60_000)
    assert_agrees(sim.measure(result)[sim.REFLECTED], rows[sim.REFLECTED].exact, FALSE_ALARM)


def test_a_plain_walk_through_the_voxels_reflects_as_much():
    """Woodcock's method in a few lines of NumPy, with one majorant: shares that go up, down, and stay."""
    result = run(only(sim.scene(ground=0.0, albedo=0.99), "sky", "all ground"), 100_000)
    emitted = result.ledger["emitted"]
    shares = [result["sky"].flux_in / emitted, result["all ground"].flux_in / emitted]
    up, down, number = _walked(sim.cumulus(0.05), 0.99, 0.85, 60_000)
    for estimate, count in zip(shares, (up, down), strict=True):
        share = count / number
        assert abs(estimate.value - share) < 5 * math.hypot(estimate.error, math.sqrt(share / number))
    assert shares[0].value == pytest.approx(up / number, rel=0.1)


def _walked(extinction, albedo, g, number):
    """Photons from the sun's rectangle through the cumulus over a black ground: how many end above, below, of
    all.
    """
    draws, most = np.random.default_rng(1), extinction.max()
    low, high = np.array(sim.LOW), np.array(sim.HIGH)
    middle = sim.shadow_middle(DOWN) + sim.SUNRISE * DOWN[0] / DOWN[2]
    x = np.stack(
        [
            middle + draws.uniform(-1200, 1200, number),
            draws.uniform(-1200, 1200, number),
            np.full(number, 1000.0),
        ],
        1,
    )
    u, ends = np.tile(DOWN, (number, 1)), np.zeros(2, int)
    while len(x):
        near, far = np.sort(
            [(low - x) / np.where(u == 0, 1e-300, u), (high - x) / np.where(u == 0, 1e-300, u)], axis=0
        )
        enter, leave = np.maximum(near.max(axis=1), 0), far.min(axis=1)
        path = enter - np.log(draws.random(len(x))) / most
        out = (enter >= leave) | (path >= leave)
        ends += [(out & (u[:, 2] > 0)).sum(), (out & (u[:, 2] <= 0)).sum()]
        x, u = (x + path[:, None] * u)[~out], u[~out]
        index = np.clip(((x - low) / sim.VOXEL).astype(int), 0, np.array(sim.SHAPE) - 1)
        real = draws.random(len(x)) * most < extinction[tuple(index.T)]
        stays = real & (draws.random(len(x)) > albedo)
        u[real] = _scattered(u[real], g, draws)
        x, u = x[~stays], u[~stays]
    return *ends, number


def _scattered(u, g, draws):
    ratio = (1 - g * g) / (1 - g + 2 * g * draws.random(len(u)))
    mu, phi = (1 + g * g - ratio**2) / (2 * g), draws.uniform(0, 2 * np.pi, len(u))
    other = np.where(np.abs(u[:, [2]]) < 0.9, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    across = np.cross(u, other)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    side = np.cross(u, across)
    turned = np.cos(phi)[:, None] * across + np.sin(phi)[:, None] * side
    found = mu[:, None] * u + np.sqrt(1 - mu**2)[:, None] * turned
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def test_along_a_line_of_sight_light_is_added_and_weakened():
    """Through an even block of even light: S (1 - exp(-τ)), and exp(-τ) of what is behind."""
    even, dark = np.full((4, 4, 4), 0.3), np.zeros((4, 4, 4))
    places = (0, 0, -1), (0, 0, 0), (2, 2, 2)
    block = Voxels(even, dark, dark + 4 * math.pi, 0.9, lambda mu: 0 * mu, *places)
    sent, passed = along_sight(block, np.array([-5.0, 1.0, 1.0]), np.array([[1.0, 0, 0], [0, 1.0, 0]]))
    assert passed == pytest.approx([math.exp(-0.6), 1.0], rel=1e-12)
    assert sent == pytest.approx([0.9 * (1 - math.exp(-0.6)), 0.0], rel=1e-12)
    beam = block._replace(direct=dark + 1.0, scattered=dark, density=lambda mu: 1 + mu)
    sent, _ = along_sight(beam, np.array([1.0, 1.0, 9.0]), np.array([[0, 0, -1.0]]))
    assert sent == pytest.approx(0.0)  # the eye has the sun behind it, and this phase nothing backwards
    sent, _ = along_sight(beam, np.array([1.0, 1.0, -9.0]), np.array([[0, 0, 1.0]]))
    assert sent == pytest.approx(1.8 * (1 - math.exp(-0.6)), rel=1e-12)
