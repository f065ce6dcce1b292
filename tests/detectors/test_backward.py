"""Histories that start at detectors tell the same as those that start at sources, and cost the same however small a bin is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ndtri

import transport as tp
from tests import backward_scenes
from tests.agreement import assert_agrees

FALSE_ALARM = 1e-6  # of a scene; of all nine 1e-5
PARTICLES = 300_000
RADIANCE, INDEX = 7.0, 1.5


def run(scene, particles=PARTICLES, seed=5, **more):
    return tp.simulate(scene, particles, seed=seed, estimator="backward", progress=False, **more)


@pytest.mark.parametrize("name", backward_scenes.SCENES)
def test_either_way_tells_the_same(name):
    """Bin by bin, through Student's t; errors of both together are 1 to 3 % of irradiances, so that 5 to 15 % would show."""
    scene = backward_scenes.SCENES[name]()
    particles = 1_000_000 if name == "glowing_glass" else PARTICLES  # a tenth of its volume is to be seen
    forward, backward = tp.simulate(scene, particles, seed=4, progress=False), run(scene, particles)
    assert backward.ledger["lost"].value == 0
    for detector in scene.detectors:
        for quantity in {"irradiance", "radiance"} & backward[detector.name].quantities.keys():
            there, back = (getattr(result[detector.name], quantity) for result in (forward, backward))
            z = np.atleast_1d((there - back).z(0)).ravel()
            is_known = np.isfinite(z)
            assert is_known.sum() >= 0.8 * len(z)  # but for bins at the horizon, which are nearly never met
            assert np.abs(z[is_known]).max() < -ndtri(FALSE_ALARM / 2 / len(z)), (detector.name, quantity, z)


@pytest.fixture(scope="module")
def furnace():
    """Black walls of one radiance about a ball of glass with a mirror: every detector sees it whole."""
    walls = tp.Surface(tp.Box(size=(1.0, 1.2, 0.8)), tp.Black(), name="walls")
    ball = tp.Surface(tp.Sphere(center=(0.1, 0, 0), radius=0.2), tp.Dielectric(INDEX), name="ball")
    mirror = tp.Surface(tp.Disk(center=(-0.3, 0, 0), normal=(1, 1, 0.3), radius=0.15), tp.Mirror())
    places = tp.Positions(u=2, v=3)
    within = tp.Disk(center=(0.1, 0, 0.05), normal=(0, 1, 1), radius=0.05)
    disk = tp.Disk(center=(0.1, 0, 0.25), radius=0.05)
    around = tp.Cylinder(center=(0.35, 0, 0), radius=0.05, height=0.2)
    cone = tp.Directions.cone((0, 0.5, 1), 1e-3)
    here = (-0.4, -0.3, 0.2)
    detectors = [
        tp.Detector(within, name="within", directions=tp.Directions(theta=4, phi=5), positions=places),
        tp.Detector("ball", directions=tp.Directions(mu=(0, 0.1, 1), phi=3), positions=places),
        tp.Detector("walls", side="back", directions=tp.Directions(mu=3)),
        tp.Detector(around, name="round", directions=tp.Directions(theta=3, phi=4)),
        tp.Detector(disk, name="cone", directions=cone),
        tp.Camera(name="camera", position=here, look_at=(0.1, 0, 0), pixels=(8, 6), field_of_view=1.2),
        tp.EnvironmentMap(name="map", position=here, theta=4, phi=5),
        tp.EnvironmentMap(name="inner map", position=(0.1, 0.0, 0.0), theta=4, phi=5),
    ]
    lamp = tp.Source("walls", tp.Lambertian(radiance=RADIANCE), side="back")
    return run(tp.Scene([lamp], [walls, ball, mirror], detectors), 100_000)


def test_furnace_is_seen_whole_by_every_history(furnace):
    """L is the same everywhere, eta^2 L in the glass: exactly, for each history brings the same."""
    for name in ("ball", "walls", "round", "map"):
        np.testing.assert_allclose(furnace[name].radiance.value, RADIANCE, rtol=1e-12)
    for name in ("within", "inner map"):
        np.testing.assert_allclose(furnace[name].radiance.value, INDEX**2 * RADIANCE, rtol=1e-12)
    np.testing.assert_allclose(furnace["map"].fluence_rate.value, 4 * math.pi * RADIANCE, rtol=1e-12)
    np.testing.assert_allclose(furnace["walls"].irradiance.value, math.pi * RADIANCE, rtol=1e-12)


def test_weighted_directions_tell_the_furnace_within_their_errors(furnace):
    assert_agrees(furnace["cone"].radiance, RADIANCE)
    assert_agrees(furnace["camera"].radiance, RADIANCE)
    assert furnace["camera"].radiance.relative_error.max() < 0.01


def test_ledger_is_of_the_histories_and_closes(furnace):
    ledger = furnace.ledger
    parts = sum(ledger[name].value for name in ledger if name != "emitted")
    assert (
        ledger["emitted"].value == pytest.approx(1, rel=1e-15, abs=0) and str(ledger["emitted"].unit) == "1"
    )
    assert parts == pytest.approx(1, rel=1e-12, abs=0)
    assert "estimator: backward" in furnace.report()


def test_bin_of_a_ten_thousandth_costs_as_much_as_the_whole_hemisphere():
    """Where a million forward histories bring some ten scores, 20 000 that start in the bin know it to 1 %."""
    scene = narrow_bin()
    forward = tp.simulate(scene, 1_000_000, seed=1, progress=False)["meter"]
    backward = run(scene, 20_000)["meter"]
    assert forward.counts.value.sum() < 100
    assert backward.radiance.relative_error.max() < 0.01
    assert_agrees(forward.radiance - backward.radiance, 0)


def narrow_bin():
    lamp = tp.Rectangle(center=(0, 0, 0.5), normal=(0, 0, -1), width=0.9, height=0.9)
    walls = tp.Surface(tp.Box(size=(1, 1, 1)), tp.Diffuse(0.5))
    cone = tp.Directions.cone((0.0, 0.5, math.sqrt(0.75)), 2 * math.asin(math.sqrt(0.5e-4)))
    meter = tp.Detector(tp.Disk(radius=0.1), name="meter", directions=cone)
    return tp.Scene([tp.Source(lamp, tp.Lambertian(radiance=10.0))], [walls], [meter])


def test_threads_do_not_change_a_bit():
    scene = backward_scenes.fog()
    one, two = (run(scene, 50_000, threads=n)["meter"].radiance.values for n in (1, 2))
    np.testing.assert_array_equal(one, two)


def test_sources_add_up():
    reading = run(backward_scenes.fog(), 50_000)["side"]
    lamp, cloud = (reading.by_source[name].flux_in for name in ("sources[0]", "sources[1]"))
    assert reading.flux_in.value == pytest.approx((lamp + cloud).value, rel=1e-12, abs=0)
    assert 0 < lamp.value < cloud.value


def test_every_cell_gets_its_share_of_histories():
    """As many, or one more, in each batch, whatever the number of cells."""
    result = run(backward_scenes.occluded(), 50_021)
    turned = result.plan.adjoint
    born = np.array([batch.counts[turned.first : turned.first + turned.cells] for batch in result.batches])
    np.testing.assert_array_equal(born.sum(axis=1), result.run.sizes)
    assert (born.max(axis=1) - born.min(axis=1) <= 1).all()


def test_batches_smaller_than_the_cells_stay_unbiased():
    """15 histories a batch for 24 cells: those without one count as 0, and all are divided by what was expected.

    Divided by its own number, where there is one, the flux would be 38 % too low; its error is 2 %.
    """
    whole, thin = (
        run(backward_scenes.occluded(), 300_000),
        run(backward_scenes.occluded(), 30_000, batches=2000),
    )
    assert_agrees(whole["meter"].flux_in - thin["meter"].flux_in, 0)
    assert any("batches are smaller" in warning for warning in thin.warnings)


def test_small_bright_lamp_that_is_never_met_is_told_of():
    lamps = [
        tp.Source(tp.Disk(radius=0.5), tp.Lambertian(power=1.0)),
        tp.Source(tp.Disk(center=(0, 0, 0.01), radius=1e-5), tp.Lambertian(power=1.0)),
    ]
    meter = tp.Detector(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.1), name="meter")
    result = run(tp.Scene(lamps, (), [meter]), 10_000)
    assert any("light from 'sources[1]' not sampled" in warning for warning in result.warnings)
    assert not run(tp.Scene(lamps[:1], (), [meter]), 10_000).warnings


def test_what_only_forward_histories_know_is_refused_where_it_is_read():
    reading = run(narrow_bin(), 1000)["meter"]
    for name in ("flux_out", "fluence_rate", "flux_in", "irradiance"):
        with pytest.raises(tp.SceneError, match="needs"):
            getattr(reading, name)
    assert set(reading.quantities) == {"flux_density", "radiance", "intensity", "counts"}
