"""Expected crossings are right: against flights that are counted, against closed forms, down to 1e-20 of the sphere."""

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.expected_scenes import SCENES, WALLS, lamp, pane
from tests.test_reproducible import digest
from transport.theory import emitters

PARTICLES = 150_000
SIDES = ("flux_in", "flux_out", "fluence_rate")
FALSE_ALARM = 1e-5  # of each scene


def quantities(result, scene):
    """All that detectors read, each once."""
    for detector in scene.meters:
        reading = result[detector.name]
        yield from (getattr(reading, side) for side in SIDES)
        if detector.directions is not None:
            yield reading.radiance
        if detector.positions is not None:
            yield reading.irradiance


@pytest.mark.parametrize("name", SCENES)
def test_events_tell_what_flights_count(name):
    scene = SCENES[name]()
    counted = tp.simulate(scene, PARTICLES, seed=1, estimator="analog")
    told = tp.simulate(scene, PARTICLES, seed=2, estimator="expected")
    pairs = list(zip(quantities(counted, scene), quantities(told, scene), strict=True))
    compared = 0
    for one, other in pairs:
        if np.any(np.asarray(one.value)) or np.any(np.asarray(other.value)):
            assert_agrees(other - one, 0.0, FALSE_ALARM / len(pairs))
            compared += 1
    assert compared >= 2 * len(scene.meters)
    assert told.ledger["lost"].value == 0


@pytest.mark.parametrize("share", [1e-2, 1e-10, 1e-20, 1e-100])
def test_a_speck_takes_its_share_of_a_point_to_rounding(share):
    """One minus the cosine of the half angle over two, told by every birth alike: share of 4 pi."""
    half_angle = math.acos(1 - 2 * share) if share > 1e-8 else 2 * math.sqrt(share)
    speck = tp.Detector(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=math.tan(half_angle)), "speck")
    source = tp.Source(tp.Point(position=(0, 0, 0)), tp.Isotropic(power=1.0))
    flux = tp.simulate(tp.Scene(source, (), speck), 10_000, seed=1, estimator="expected")["speck"].flux_in
    if share > 1e-8:
        assert_agrees(flux, share)
        assert flux.relative_error < 1e-3
    else:
        assert flux.value == pytest.approx(share, rel=3 * share + 1e-12, abs=0)


def test_disk_to_disk_is_the_closed_form():
    meter = tp.Detector(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=1), "meter")
    scene = tp.Scene(tp.Source(tp.Disk(radius=1), tp.Lambertian(radiance=1.0)), (), meter)
    flux = tp.simulate(scene, 1_000_000, seed=1, estimator="expected")["meter"].flux_in
    assert_agrees(flux, math.pi * emitters.mean_disk_irradiance(1.0, 1.0, 1.0, 1.0))
    assert flux.relative_error < 8e-4


def test_what_is_born_on_a_meter_leaves_it_as_ever():
    """All of the power that a disk without a surface sends out departs from the meter on it: no ray has told that."""
    source = lamp(0.0)
    own = tp.Detector(source.shape, "own", directions=tp.Directions(mu=2))
    told = tp.simulate(tp.Scene(source, (), [own, pane("meter", 0.5)]), 10_000, seed=1, estimator="expected")
    power = told.ledger["emitted"].value
    assert told["own"].flux_out.value == pytest.approx(power, rel=1e-12)
    assert_agrees(told["own"].radiance_out, 1.0)


@pytest.mark.parametrize("reach", [1e-12, 1.0, 1e12])
def test_the_unit_of_length_does_not_matter(reach):
    """What is told is the same to rounding in a room of any size."""

    def room(size):
        meter = tp.Detector(tp.Disk(center=(0, 0.3 * size, 0.8 * size), radius=0.1 * size), "meter")
        source = tp.Source(tp.Disk(radius=0.2 * size), tp.Lambertian(power=1.0))
        walls = tp.Surface(tp.Box(size=2 * size), tp.Diffuse(0.5), "walls")
        result = tp.simulate(tp.Scene(source, walls, meter), 20_000, seed=3, estimator="expected")
        return result["meter"].flux_out

    assert room(reach).value == pytest.approx(room(0.25).value, rel=1e-9)


def test_a_ball_that_shines_is_as_bright_everywhere():
    """Radiance emitted / (1 - albedo), whoever looks from wherever: a small ball in it, a patch close to it."""
    walls = tp.Surface(tp.Sphere(radius=1.0), tp.Diffuse(0.8), "walls")
    small = tp.Detector(tp.Sphere(center=(0.3, 0, -0.5), radius=0.01), "small")
    close = tp.Detector(tp.Disk(center=(0, 0, 0.9), radius=0.2), "close")
    source = tp.Source("walls", tp.Lambertian(radiance=1.0), side="inside")
    scene = tp.Scene(source, walls, [tp.Detector("walls", side="inside"), small, close])
    told = tp.simulate(scene, 100_000, seed=1, estimator="expected")
    for name in ("walls", "small", "close"):
        assert_agrees(told[name].irradiance, 5 * math.pi)
    assert_agrees(told["close"].exitance, 5 * math.pi)
    assert_agrees(told["small"].fluence_rate, 20 * math.pi)


@pytest.mark.parametrize("name", ["room", "fog", "half_mirrors"])
def test_threads_do_not_change_a_bit(name):
    scene = SCENES[name]()
    assert len({digest(scene, threads=threads, estimator="expected") for threads in (1, 2, 3)}) == 1


def test_a_detector_that_no_point_is_drawn_on_counts_as_flights_come():
    rod = tp.Detector(tp.Cylinder(center=(0, 0, 0.5), radius=0.1, height=0.2), "rod")
    scene = tp.Scene(lamp(0.0), WALLS, [rod, pane("meter", 0.5)])
    counted, told = (tp.simulate(scene, 50_000, seed=4, estimator=way) for way in ("analog", "expected"))
    assert told["rod"].flux_in.value == counted["rod"].flux_in.value
    assert "rod" in told.report().split("estimator")[1].split("\n")[0]
