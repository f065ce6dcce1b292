"""A result says where histories that survive roulette may be missing from a figure, and is silent where none can be.

Through 20 mean free paths of albedo 0.2 come 2.94e-9 of the light; one survivor of roulette weighs as much as all of a
run.  At 8 mean free paths (4.2e-4) enough of them come.
"""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_rejected
from tests.tracking_scenes import FALSE_ALARM, run, slab, splitting
from transport.results.diagnostics.depth import _roulette_weight
from transport.statistics.findings import DOUBTFUL, NOTE
from transport.theory import ordinates

DEEP = (20.0, 0.2)


def doubt(result, name: str) -> str | None:
    """The doubts about a detector and why it counted nothing, as one text; None where there are none."""
    about = [each for each in result.findings if repr(name) in each.object]
    texts = {DOUBTFUL: str, NOTE: lambda finding: finding.what}
    return "; ".join(texts[each.severity](each) for each in about if each.severity in texts) or None


def with_core(tau, albedo):
    """The slab, and a ball at its bottom in which fluence is counted."""
    scene = slab(tau, albedo)
    core = tp.VolumeDetector(tp.Sphere(center=(0, 0, -0.9), radius=0.05), "core")
    return tp.Scene(scene.sources, scene.surfaces, [*scene.detectors, core])


DOUBTED = [pytest.param(r, n, marks=() if (r, n) in ((0.25, 300_000), (1e-2, 10_000)) else pytest.mark.slow)
    for r in (0.25, 1e-2, 1e-3) for n in (10_000, 300_000)
]  # fmt: skip


@pytest.mark.parametrize(("roulette", "particles"), DOUBTED)
def test_what_survivors_of_roulette_would_outweigh_is_warned_of(roulette, particles):
    result = run(with_core(*DEEP), tp.Tracking(roulette=roulette), particles)
    words = [
        "times it",
        "flux_out of detector 'bottom'",
        f"at {roulette:g} of",
        "Tracking(roulette=1e-1",
    ]
    assert [word for word in words if word not in doubt(result, "bottom")] == []
    assert "fluence_rate of volume detector 'core'" in doubt(result, "core")
    assert doubt(result, "top") is None


def test_forced_collisions_are_warned_of_as_well():
    assert doubt(run(slab(*DEEP), tp.Tracking(forced=True, roulette=0.25)), "bottom") is not None


def test_the_error_that_is_warned_of_is_wrong_and_the_roulette_proposed_mends_it():
    exact = ordinates.slab(*DEEP).transmitted
    before = run(slab(*DEEP), tp.Tracking(roulette=0.25))
    assert_rejected(before["bottom"].flux_out, exact)
    share = float(doubt(before, "bottom").partition("Tracking(roulette=")[2].partition(")")[0])
    after = run(slab(*DEEP), tp.Tracking(roulette=share))
    assert doubt(after, "bottom") is None
    assert_agrees(after["bottom"].flux_out, exact, FALSE_ALARM)
    assert after["bottom"].flux_out.relative_error < 0.03


@pytest.mark.parametrize(("tau", "albedo"), [(8.0, 0.2), (8.0, 0.8), (2.0, 0.9)])
@pytest.mark.slow
def test_at_moderate_depth_the_default_is_right_and_silent(tau, albedo):
    result, exact = run(with_core(tau, albedo), None, 1_000_000), ordinates.slab(tau, albedo)
    assert [doubt(result, name) for name in ("top", "bottom", "core")] == [None] * 3
    assert_agrees(result["bottom"].flux_out, exact.transmitted, FALSE_ALARM)
    assert result["bottom"].flux_out.relative_error < 0.008


@pytest.mark.parametrize(
    ("gain", "is_small"), [(2.0, True), (1e8, False), pytest.param(1e10, False, marks=pytest.mark.slow)]
)
def test_a_gain_too_small_is_warned_of_and_one_that_suits_is_not(gain, is_small):
    result = run(slab(*DEEP), tp.Tracking(splitting=splitting(gain)))
    warning = doubt(result, "bottom")
    assert doubt(result, "top") is None and (warning is not None) == is_small
    assert not is_small or f"raise its gain, got {gain:g}," in warning


@pytest.mark.parametrize(
    ("tau", "albedo", "tracking"),
    [
        (8.0, 0.2, "analog"),
        (20.0, 0.0, None),
        (2.0, 1 - 1e-12, None),
        (1e-6, 0.5, None),
        (1e-6, 0.5, tp.Tracking(forced=True)),
    ],
    ids=["analog", "no scattering", "hardly any absorption", "thin", "thin, forced"],
)
def test_there_is_no_warning_where_no_roulette_is_played(tau, albedo, tracking):
    result = run(slab(tau, albedo), tracking)
    assert [doubt(result, name) for name in result] == [None, None]


def test_a_detector_of_unscattered_light_is_not_doubted():
    scene = slab(*DEEP)
    straight = tp.Detector(tp.Plane(center=(0, 0, -1), normal=(0, 0, -1)), "straight", events=0)
    result = run(tp.Scene(scene.sources, scene.surfaces, [*scene.detectors, straight]))
    assert doubt(result, "bottom") is not None
    assert doubt(result, "straight") is None
    assert_agrees(result["straight"].flux_out, math.exp(-20), FALSE_ALARM)


def test_weights_of_an_aimed_lamp_are_those_of_its_histories():
    """Aimed at a small disk, histories carry what flies there, and survivors no more."""
    scene = slab(8.0, 0.8)
    lamp = tp.Source(
        tp.Point(position=(0, 0, 1)),
        tp.Isotropic(power=1.0),
        aim=tp.Disk(center=(0, 0, 0), normal=(0, 0, 1), radius=1e-3),
    )
    result = run(tp.Scene(lamp, scene.surfaces, scene.detectors), None, 300_000)
    assert result["bottom"].flux_out.value < 1e-5
    assert doubt(result, "bottom") is None


def test_what_arrives_before_any_collision_has_no_survivors():
    """A lamp aimed at a disk on the slab: its flux has an error of 1e-12 only, from the aim."""
    lid = tp.Disk(center=(0, 0, 0), radius=0.02)
    disk = tp.Disk(center=(0, 0, 1000), normal=(0, 0, -1), radius=0.01)
    lamp = tp.Source(disk, tp.Lambertian(power=1.0), aim=lid)
    meter = tp.Detector(tp.Disk(center=(0, 0, 1e-3), radius=0.03), "lid")
    result = run(tp.Scene(lamp, slab(8.0, 0.8).surfaces, meter))
    assert 0 < result["lid"].flux_in.relative_error < 1e-6
    assert doubt(result, "lid") is None


def test_a_splitting_is_advised_along_the_path_to_a_detector_about_the_lamp():
    """The middles of both are one place, which no Splitting could begin and end at."""
    fog = tp.Surface(tp.Sphere(radius=2.0), tp.Transparent(), inside=tp.Medium(0.5, 300.0))
    lamp = tp.Source(tp.Point(position=(0, 0, 0)), tp.Isotropic(power=1.0))
    shell = tp.Detector(tp.Sphere(radius=1.0), "shell")
    told = doubt(run(tp.Scene(lamp, fog, shell), None, 256), "shell")
    assert "Splitting(start=(0, 0, 0), end=(0, 0, 1), gain=2e+09)" in told


def test_a_detector_that_no_particle_reaches_is_doubted():
    """Through 60 mean free paths of albedo 0.9 (6e-15) nothing comes in a short run: its inverse is the gain that would do."""
    result = run(slab(60.0, 0.9), None, 20_000)
    assert result["bottom"].flux_out.reason == "no score"
    assert "no particle has reached detector 'bottom': the straight path" in doubt(result, "bottom")
    path = "Splitting(start=(0, 0, 1), end=(0, 0, -1), gain=2e+14)"
    assert f"use tracking=Tracking(splitting={path})" in doubt(result, "bottom")
    white = doubt(run(slab(600.0, 1.0), None, 16), "bottom")
    assert "gain=5e+02" in white  # 1 + 450, by diffusion
    forward = doubt(run(slab(600.0, 1.0, g=0.9), None, 4), "bottom")
    assert "gain=5e+01" in forward  # 1 + 45: one scattering in ten turns the light
    assert doubt(result, "top") is None
    assert "raise its gain, got 10" in doubt(
        run(slab(60.0, 0.9), tp.Tracking(splitting=splitting(10.0)), 2000), "bottom"
    )


def test_the_cells_of_a_volume_are_doubted_one_by_one():
    """Fluence with depth: the lit cells are right, the deepest are not."""
    scene = slab(20.0, 0.5)
    box = tp.Box(center=(0, 0, -0.5), size=(1e3, 1e3, 1))
    scene = tp.Scene(scene.sources, scene.surfaces, tp.VolumeDetector(box, "depth", cells=(1, 1, 20)))
    assert "which matters in 9 of 20 bins" in doubt(run(scene, tp.Tracking(roulette=1e-2), 100_000), "depth")
    assert doubt(run(scene, tp.Tracking(roulette=1e-14), 100_000), "depth") is None


def test_the_weight_that_roulette_was_played_for_follows_from_its_balance():
    """With few survivors from the weight of killed particles, with many from the variance."""
    random = np.random.default_rng(1)
    for heaviest in (1.0, 1e-4):
        for played in (1e-3, 30.0, 1e4):  # expected survivors a batch
            balance = heaviest * (played - random.poisson(played, 32))
            batches = [SimpleNamespace(ledger={"roulette": one}) for one in balance]
            found = _roulette_weight(batches, 32_000, heaviest) * 1000 / heaviest
            assert played / 3 < found < 3 * played


def test_bins_are_doubted_where_their_total_is_not():
    """Light that comes back far from where a pencil beam went in: the inner rings are right, the outer ones are not."""
    fog = tp.Medium(absorption=1.0, scattering=1.0)
    beam = tp.Source(tp.Point(position=(0, 0, 1)), tp.Beam((0, 0, -1), power=1.0))
    ground = tp.Surface(tp.Plane(), tp.Transparent(), inside=fog)
    rings = tp.Detector(tp.Disk(radius=12.0), "rings", positions=tp.Positions(u=12))
    scene = tp.Scene(beam, ground, rings)
    warning = doubt(run(scene, tp.Tracking(roulette=1e-2), 100_000), "rings")
    assert "exitance of detector 'rings'" in warning and "which matters in 6 of 10 bins" in warning
    near = tp.Scene(beam, ground, tp.Detector(tp.Disk(radius=3.0), "rings", positions=tp.Positions(u=3)))
    assert doubt(run(near, None, 100_000), "rings") is None


def test_a_bound_of_what_may_be_missing_widens_the_interval():
    """Nearly all of what comes through never collides: a bound of 0.2 % is no doubt, and in the interval."""
    flux = run(slab(8.0, 1e-4), tp.Tracking(roulette=1e-2))["bottom"].flux_out
    assert flux.verdict == "bounded" and flux.findings[0].share == pytest.approx(0.002, rel=0.2)
    assert flux.interval()[1] - flux.value > flux.findings[0].bound > 0.5 * (flux.interval()[1] - flux.value)


def voxels(tau, albedo):
    """The same slab as voxels in a wide box."""
    layers = np.ones((1, 1, 40)) * tau
    grid = tp.Grid(
        box=tp.Box(center=(0, 0, -0.5), size=(1e3, 1e3, 1)),
        absorption=(1 - albedo) * layers,
        scattering=albedo * layers,
    )
    beam = tp.Source(tp.Point(position=(0.1, 0.1, 1)), tp.Beam((0, 0, -1), power=1.0))
    below = tp.Detector(tp.Plane(center=(0, 0, -1), normal=(0, 0, -1)), "bottom")
    return tp.Scene(beam, tp.Surface(grid.box, tp.Transparent(), inside=grid), below)


def test_rare_flights_through_voxels_are_reported():
    assert "unknown, not 0; uncollided particles through voxels" in doubt(run(voxels(*DEEP)), "bottom")
    assert "only 6 scores" in doubt(run(voxels(10.0, 0.2), None, 20_000), "bottom")
    assert doubt(run(voxels(3.0, 0.8)), "bottom") is None


@pytest.mark.slow
def test_splitting_goes_on_along_flights_through_voxels():
    """A flight through 20 mean free paths without a collision is split on its way, as it is in a Medium."""
    result = run(voxels(*DEEP), tp.Tracking(splitting=splitting(1e8)), 200_000)
    flux = result["bottom"].flux_out
    assert_agrees(flux, ordinates.slab(*DEEP).transmitted, FALSE_ALARM)
    assert doubt(result, "bottom") is None and flux.relative_error < 0.03


def test_a_splitting_the_wrong_way_round_is_warned_of():
    back = tp.Splitting(start=(0, 0, -1), end=(0, 0, 0), gain=1e8)
    warning = doubt(run(slab(*DEEP), tp.Tracking(splitting=back), 20_000), "bottom")
    assert "Let the Splitting rise towards it" in warning
