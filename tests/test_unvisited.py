"""The classic trap: an answer four times too low with a claimed error of 2 % is flagged before the mean is right.

A speck of a detector sees a dim lamp from afar, which every birth tells it, and a small lit patch close by, which brings three quarters
of its light by one history in some hundred thousand.  The truth comes from histories that start at the detector.
"""

import numpy as np
import pytest

import transport as tp
from tests.expected_scenes import SCENES

MET = tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=1e-3)
PATCH = tp.Surface(
    tp.Disk(center=(2.5e-3, 0, 1.998), normal=(-1, 0, 1), radius=2e-3), tp.Diffuse(0.9), "patch"
)
ROOF = tp.Surface(tp.Disk(center=(0, 0, 2.001), radius=1e-3), tp.Black(), "roof")
BRIGHT = tp.Source(tp.Disk(center=(0, 0, 4), normal=(0, 0, -1), radius=0.5), tp.Lambertian(radiance=1.0))
DIM = 0.0470  # W m^-2 sr^-1: a quarter of the light then comes from the dim lamp
SAID = "light of Surface 'patch'"


def trap(look):
    dim = tp.Source(tp.Disk(radius=0.5), tp.Lambertian(radiance=DIM))
    return tp.Scene([dim, BRIGHT], [PATCH, ROOF], look)


METER = tp.Detector(MET, "meter")
POINT = tp.PointDetector(position=(5e-4, 0, 1.9995), name="meter")


@pytest.fixture(scope="module")
def truth():
    result = tp.simulate(trap(METER), 300_000, seed=1, estimator="backward")
    assert not result.warnings
    return result["meter"].flux_in


@pytest.mark.parametrize("sampling", ["random", "sobol"])
def test_the_trap_is_flagged_in_every_short_run(truth, sampling):
    shares, claimed = [], []
    for seed in range(20):
        result = tp.simulate(trap(METER), 4096, seed=seed, estimator="expected", sampling=sampling)
        told = [each.what for each in result["meter"].flux_in.findings if each.severity == "doubtful"]
        assert any(SAID in what for what in told) and result.warnings
        shares.append(result["meter"].flux_in.value / truth.value)
        claimed.append(result["meter"].flux_in.relative_error)
    assert 0.2 < np.median(shares) < 0.3
    assert np.median(claimed) < 0.03


def test_a_point_detector_falls_into_it_as_well_and_says_so():
    for seed in range(10):
        result = tp.simulate(trap(POINT), 4096, seed=seed)
        assert any(SAID in warning for warning in result.warnings)


def test_it_is_silent_once_histories_have_come(truth):
    result = tp.simulate(trap(METER), 80_000_000, seed=1, estimator="expected")
    assert not any(SAID in warning for warning in result.warnings)
    assert abs((result["meter"].flux_in - truth).value) < 5 * (result["meter"].flux_in - truth).error


@pytest.mark.parametrize("name", ["room", "balls", "glass", "shadow", "facing"])
def test_sound_scenes_do_not_raise_it(name):
    for seed in range(5):
        result = tp.simulate(SCENES[name](), 4096, seed=seed, estimator="expected")
        assert not any("hardly any history has reached" in warning for warning in result.warnings)
