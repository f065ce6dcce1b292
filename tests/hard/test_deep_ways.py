"""A detector behind media so thick that nothing comes to it says why and what would do, and what it advises does."""

from __future__ import annotations

import math
import re

import pytest

import transport as tp
from tests.agreement import assert_agrees

METER = tp.Detector(tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=1000.0), "meter")
LAMP = tp.Source(tp.Point(position=(0, 0, -1)), tp.Beam(direction=(0, 0, 1), power=1.0))


def behind_slab(tracking=None, particles=4096, **medium):
    """A beam, a slab from 0 to 1 m and a meter behind it."""
    inside = tp.Medium(**medium)
    slab = tp.Surface(tp.Slab(center=(0, 0, 0.5), thickness=1.0), tp.Transparent(), inside=inside)
    scene = tp.Scene(LAMP, slab, METER)
    return tp.simulate(scene, particles=particles, tracking=tracking, seed=1, progress=False)


def said_of(result):
    """The one warning."""
    (warning,) = result.warnings
    return warning


def test_light_absorbed_before_a_detector_by_chance_is_told_by_weight():
    assert "12 mean free paths of media; exp(-12) of it is transmitted: use tracking='weighted'" in said_of(
        behind_slab("analog", absorption=12.0)
    )
    result = behind_slab("weighted", absorption=12.0)
    assert result["meter"].flux_in.value == pytest.approx(math.exp(-12), rel=1e-9) and not result.warnings


@pytest.mark.parametrize("tracking", ["analog", "weighted"])
def test_what_is_fainter_than_sums_can_tell_is_said_to_be(tracking):
    assert "exp(-60) of it is transmitted, and no run resolves less than 1e-19" in said_of(
        behind_slab(tracking, absorption=60.0)
    )


@pytest.mark.parametrize("roulette", [1e-2, 1e-20, 1e-90])
def test_two_hundred_mean_free_paths_are_not_a_matter_of_roulette(roulette):
    said = said_of(behind_slab(tp.Tracking(roulette=roulette), absorption=20.0, scattering=180.0))
    assert "200 mean free paths" in said and "roulette" not in said
    assert re.search(
        r"about exp\(-110\) of the diffusing light is transmitted, and no run resolves less", said
    )


def test_the_splitting_that_is_advised_lets_diffuse_light_through():
    """To what a tenth of its gain tells as well."""
    fog = {"absorption": 0.6, "scattering": 149.4}
    said = said_of(behind_slab(particles=256, **fog))
    gain = float(re.search(r"about 1 / transmission: (\S+) if", said)[1])
    found = []
    for each in (gain, gain / 10):
        splitting = tp.Splitting(start=(0, 0, 0), end=(0, 0, 1), gain=each)
        result = behind_slab(tp.Tracking(splitting=splitting), particles=512, **fog)
        assert not any("mean free paths" in warning for warning in result.warnings)
        found.append(result["meter"].flux_in)
    assert found[0].value > 0
    assert_agrees(found[0] - found[1], 0.0)


def test_a_dense_glowing_ball_is_said_to_shine_from_its_skin():
    ball = tp.Surface(
        tp.Sphere(radius=1.0), tp.Transparent(), name="ball", inside=tp.Medium(absorption=1e7, emission=1e7)
    )
    for look in ("ball", METER.shape):
        scene = tp.Scene([], ball, tp.Detector(look, "meter"))
        said = tp.simulate(scene, particles=1000, progress=False).warnings[0]
        assert (
            "only the outer mean free path" in said and "Lambertian(radiance=emission / absorption)" in said
        )


def test_a_detector_in_the_dark_of_a_thin_fog_or_of_none_is_not_said_to_lie_deep():
    screen = tp.Surface(tp.Disk(center=(0, 0, 1), radius=0.5), tp.Black())
    for medium in (None, tp.Medium(absorption=0.5)):
        result = tp.simulate(tp.Scene(LAMP, screen, METER, medium=medium), particles=1000, progress=False)
        assert result["meter"].flux_in.value == 0
        assert not any("mean free paths" in warning for warning in result.warnings)
