"""Next-event rays from glossy surfaces: the mean is that of flights alone, the furnace stays white, and narrow lobes are no secret."""

from __future__ import annotations

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_rejected
from tests.slow import quick

DOWN = (0.0, 0.0, -1.0)
ALBEDO = 0.9


def run(scene, particles, seed, estimator, **how):
    how = how | ({"guide": 0} if estimator == "backward" else {})
    return tp.simulate(scene, particles, seed=seed, estimator=estimator, progress=False, **how)


# ---- the mean ----


def panel_scene(lamp, height, material, screen=()):
    """A panel, a lamp, and a detector that looks down and sees nothing but the panel."""
    panel = tp.Surface(tp.Rectangle(width=3, height=3), material, "panel")
    eye = tp.Detector(tp.Disk(center=(0.3, 0.05, height), normal=DOWN, radius=0.08), "m")
    surfaces = [panel, tp.Surface(lamp, tp.Black(), "lamp"), *screen]
    return tp.Scene(tp.Source("lamp", tp.Lambertian(radiance=1.0)), surfaces, eye)


def steep(lamp, material):
    return panel_scene(lamp((-0.3, 0, 0.92)), 0.75, material)


def grazing(lamp, material):
    return panel_scene(lamp((-1.2, 0, 0.24)), 0.07, material)


def touching(lamp, material):
    """A lamp that stands on the panel, seen by way of it under a screen."""
    stands = tp.Rectangle(center=(-0.5, 0, 0.3), normal=(1, 0, 0), up=(0, 0, 1), width=0.6, height=0.6)
    hides = tp.Rectangle(center=(0, 0, 0.45), normal=(1, 0, 0), up=(0, 0, 1), width=3, height=0.52)
    return panel_scene(stands, 0.2, material, [tp.Surface(hides, tp.Black(), "screen")])


def flat(center):
    return tp.Disk(center=center, normal=(0.3, 0, -1), radius=0.1)


def ball(center):
    return tp.Sphere(center=center, radius=0.1)


def plain(roughness):
    return tp.Glossy(roughness, ALBEDO)


def mixed(roughness):
    parts = {tp.Glossy(roughness, ALBEDO): 0.6, tp.Diffuse(0.8): 0.3, tp.Mirror(1.0): 0.1}
    return tp.TwoSided(front=tp.Mixture(parts), back=tp.Black())


PLACES = {
    "steep, flat": (steep, flat, plain),
    "steep, ball": (steep, ball, plain),
    "grazing, flat": (grazing, flat, plain),
    "grazing, ball": (grazing, ball, plain),
    "touching": (touching, flat, plain),
    "steep, mixed": (steep, flat, mixed),
    "grazing, mixed": (grazing, ball, mixed),
}
ROUGHNESSES = 0.05, 0.2, 0.5, 1.0
CASES = [(place, roughness) for place in PLACES for roughness in ROUGHNESSES]
QUICK = ("steep, flat", 0.2), ("steep, ball", 1.0), ("grazing, flat", 0.5), ("touching", 0.05)


@pytest.mark.parametrize("case", quick(CASES, *QUICK), ids=str)
def test_rays_and_flights_together_have_the_mean_of_flights_alone(case):
    place, roughness = case
    where, lamp, material = PLACES[place]
    scene, seed = where(lamp, material(roughness)), 10 * CASES.index(case)
    analog = run(scene, 2e6, seed, "analog")["m"].irradiance
    expected = run(scene, 2e5, seed + 1, "expected")["m"].irradiance
    backward = run(scene, 2e5, seed + 2, "backward")["m"].irradiance
    for one, other in ((analog, expected), (analog, backward), (expected, backward)):
        assert_agrees(other - one, 0.0, 1e-5)


@pytest.mark.parametrize("estimator", ["expected", "backward"])
def test_a_white_furnace_of_gloss_stays_white(estimator):
    """Walls that emit what they do not reflect: the radiance is 1 everywhere, at their edges too."""
    walls = zip(tp.Box(size=1.0).faces().items(), (0.05, 0.2, 0.5, 1.0, 0.1, 0.3), strict=True)
    surfaces = [tp.Surface(face, tp.Glossy(alpha, 0.5), name) for (name, face), alpha in walls]
    lamps = [tp.Source(surface.name, tp.Lambertian(radiance=0.5), side="back") for surface in surfaces]
    eye = tp.Detector(tp.Disk(center=(0.2, -0.1, -0.3), normal=(0.6, 0, 0.8), radius=0.15), "m")
    found = run(tp.Scene(lamps, surfaces, eye), 4e5, 5, estimator)["m"].irradiance
    assert_agrees(found, np.pi)
    assert_rejected(found, 1.02 * np.pi)


def unit_scene(reach):
    panel = tp.Surface(tp.Rectangle(width=3 * reach, height=3 * reach), tp.Glossy(0.1), "panel")
    ball = tp.Sphere(center=(-0.3 * reach, 0, reach), radius=0.1 * reach)
    disk = tp.Disk(center=(0.3 * reach, 0, 0.7 * reach), normal=DOWN, radius=0.1 * reach)
    return tp.Scene(tp.Source(ball, tp.Lambertian(radiance=1.0)), panel, tp.Detector(disk, "m"))


@pytest.mark.parametrize("estimator", ["expected", "backward"])
def test_the_unit_of_length_does_not_matter(estimator):
    metre, *others = (
        run(unit_scene(reach), 2e4, 1, estimator)["m"].irradiance.value for reach in (1.0, 2.0**-40, 2.0**40)
    )
    assert metre > 0 and others == pytest.approx([metre, metre], rel=1e-9)


# ---- what may be missed ----


def small_detector(roughness, radius=1e-3):
    panel = tp.Rectangle(center=(-1, 0, 0), normal=(1, 0, 0), up=(0, 0, 1), width=3, height=3)
    lamp = tp.Source(tp.Disk(center=(0, 0, 1.9), normal=DOWN, radius=0.05), tp.Lambertian(power=100.0))
    eye = tp.Detector(tp.Disk(center=(1.5, 0, -0.5), normal=(-1, 0, 0), radius=radius), "m")
    return tp.Scene(lamp, tp.Surface(panel, tp.Glossy(roughness, ALBEDO), "panel"), eye)


def test_a_small_detector_that_gloss_lights_is_known_and_sure():
    """Of ten thousand million births one would meet the detector by way of the panel."""
    found = run(small_detector(0.2), 4e5, 1, "expected")["m"].irradiance
    backward = tp.simulate(small_detector(0.2), 4e5, seed=2, estimator="backward", progress=False)[
        "m"
    ].irradiance
    assert not found.is_doubtful and found.error < 0.003 * found.value
    assert_agrees(backward - found, 0.0, 1e-5)


@pytest.mark.parametrize("estimator", ["expected", "backward"])
def test_a_lobe_that_neither_rays_nor_flights_find_is_reported(estimator):
    """A tiny lamp in a narrow lobe: what brings most of the light has hardly been sampled."""
    panel = tp.Surface(tp.Rectangle(width=3, height=3), tp.Glossy(0.002, ALBEDO), "panel")
    lamp = tp.Source(tp.Disk(center=(-1, 0, 1), normal=DOWN, radius=1e-3), tp.Lambertian(radiance=1.0))
    eye = tp.Detector(tp.Disk(center=(1, 0, 1), normal=DOWN, radius=1e-3), "m")
    found = run(tp.Scene(lamp, panel, eye), 2e4, 1, estimator)["m"].irradiance
    assert found.is_doubtful
    assert any(name in str(found) for name in ("panel", "walls", "larger scores"))


def test_gloss_too_smooth_for_rays_counts_as_a_mirror():
    rough, smooth = tp.Glossy(2e-3), tp.Glossy(5e-4)
    assert smooth.is_specular and not rough.is_specular
    assert tp.Mixture({rough: 0.5, smooth: 0.5}).is_specular
