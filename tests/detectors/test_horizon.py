"""Bins in the world's frame that the side of a flat meter cannot see: refused where there is no other."""

import math

import numpy as np
import pytest

from tests.refusals import LAMP, WALL, assert_refused, meter
from transport.geometry.flat import Disk, Slab
from transport.geometry.solid import Box, Sphere
from transport.geometry.solid_angles import projected_solid_angles
from transport.scene.bins import Directions, is_above_horizon
from transport.scene.detectors import Detector
from transport.scene.scene import Scene
from transport.simulate import simulate
from transport.vectors import unit_vector

BELOW = {
    "a cone": Directions.cone((0, 0, -1), 0.3),
    "a cone that touches the horizon": Directions.cone((0, 0, -1), math.pi / 2),
    "mu": Directions(mu=(-1, -0.5, 0), frame="world"),
    "theta": Directions(theta=(math.pi / 2, math.pi), frame="world"),
}


@pytest.mark.parametrize("directions", BELOW.values(), ids=BELOW)
def test_bins_that_are_all_behind_a_meter_are_refused_with_a_cure(directions):
    words = ["Detector 'lid': directions", "of its front", "(0.0, 0.0, 1.0)", "write side='back'"]
    assert_refused(lambda: meter(directions=directions), words)
    assert meter(directions=directions, side="back").is_back
    assert_refused(
        lambda: Scene([LAMP], [WALL], [Detector("floor", directions=directions)]), ["Detector 'floor'"]
    )
    for shape in (Sphere(radius=1), Box(size=1), Slab(thickness=1)):
        assert Detector(shape, name="lid", directions=directions).directions == directions


@pytest.mark.slow
def test_bins_above_the_horizon_have_a_projected_solid_angle():
    """Random bins and normals; within a billionth of a radian of the horizon too."""
    rng = np.random.default_rng(1)
    seen = []
    for number in range(400):
        normal = unit_vector(tuple(rng.normal(size=3)) if number % 3 else (0.0, 0.0, rng.choice([-1.0, 1.0])))
        mu, begin = np.sort(rng.uniform(-1, 1, 2)), rng.uniform(-6, 2)
        phi = np.array([begin, begin + rng.uniform(0.1, 4)])
        exact = projected_solid_angles(mu, phi, normal)[0, 0] > 1e-13 * np.prod([np.ptp(mu), np.ptp(phi)])
        polar = {"mu": mu} if number % 2 else {"theta": np.arccos(mu[::-1])}
        seen.append(is_above_horizon(Directions(**polar, phi=phi, frame="world"), normal))
        assert seen[-1] == exact, (mu, phi, normal)
    assert 40 < sum(seen) < 360
    for sine, in_sight in ((1e-9, True), (-1e-9, False)):
        assert is_above_horizon(Directions(mu=(-1, sine), frame="world"), (0.0, 0.0, 1.0)) is in_sight
        assert is_above_horizon(Directions.cone((1, 0, -1e-3 + sine), 1e-3), (0.0, 0.0, 1.0)) is in_sight


def test_bins_behind_a_detector_have_an_undefined_radiance():
    bins = Directions(mu=(-1, 0, 1), frame="world")
    scene = Scene(
        [LAMP], [], [Detector(Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=1), "m", directions=bins)]
    )
    radiance = simulate(scene, particles=2000, seed=1)["m"].radiance
    assert radiance.value[0] > 0 and math.isnan(radiance.value[1])
    assert "undefined" in str(radiance[1])
