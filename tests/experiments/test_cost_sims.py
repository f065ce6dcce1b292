"""The scenes on which the price of accuracy is shown: their exact values by other ways, and wrong laws that they reject.

Each statistical judgement fails right code in one of 10^5 seeds; the seed is 1.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

import transport as tp
from tests.agreement import agrees, assert_agrees, smallest_bias
from transport.sims import (
    cost_caustic,
    cost_disks,
    cost_enclosure,
    cost_fog,
    cost_glint,
    cost_mirror,
    cost_speck,
)
from transport.theory import emitters, fresnel
from transport.verification.experiment import run_experiment

slow = pytest.mark.slow  # runs of millions of particles

FALSE_ALARM = 1e-5
RNG = np.random.default_rng(1)


def the_value(sim, **parameters):
    (value,) = sim.exact(**parameters).values()
    return value


# ---- exact values by other ways ----


@pytest.mark.parametrize(("radius", "meter", "distance"), [(1.0, 1.0, 1.0), (0.5, 2.0, 0.3), (2.0, 0.1, 3.0)])
def test_the_flux_from_disk_to_disk_is_the_integral_of_its_irradiance(radius, meter, distance):
    rings = quad(lambda r: 2 * math.pi * r * emitters.disk_irradiance(7.0, radius, distance, r), 0, meter)
    assert the_value(
        cost_disks, radius=radius, meter=meter, distance=distance, radiance=7.0
    ) == pytest.approx(rings[0], rel=1e-10, abs=0)


@pytest.mark.parametrize("share", [1e-10, 1e-3, 0.1])
def test_the_speck_fills_its_share_and_a_glowing_ball_lights_it_as_a_point(share):
    radius = cost_speck.speck_radius(share, 2.0)
    assert emitters.point_flux_through_disk(1.0, radius, 2.0) == pytest.approx(share, rel=1e-13, abs=0)
    seen = 0.3 / 2.0  # sine of the ball's angle, seen from the speck's middle

    def arriving(s):  # radiance times cosine, of a chord 2 √(R² - d² s²) of stuff that emits 3/(4π R³) in all
        return (
            2
            * math.pi
            * s
            * 2
            * math.sqrt(max(0.3**2 - 4 * s * s, 0))
            * 3
            / (4 * math.pi * 0.3**3)
            / (4 * math.pi)
        )

    irradiance = quad(arriving, 0, seen)[0]
    assert irradiance == pytest.approx(emitters.point_irradiance(1.0, 2.0), rel=1e-8, abs=0)
    if share < 1e-9:
        flux = irradiance * math.pi * radius**2
        assert the_value(cost_speck, lamp="ball", share=share, distance=2.0) == pytest.approx(
            flux, rel=1e-8, abs=0
        )
        disk = emitters.disk_irradiance(1 / (math.pi * math.pi * 0.3**2), 0.3, 2.0) * math.pi * radius**2
        exact = the_value(cost_speck, lamp="disk", share=share, distance=2.0, size=0.3)
        assert exact == pytest.approx(disk, rel=1e-8, abs=0)


def on_disk(radius, count=20_000):
    """Places on the rim of a disk and within it."""
    r, phi = radius * np.sqrt(RNG.random(count)), 2 * math.pi * RNG.random(count)
    r[::2] = radius
    return np.stack([r * np.cos(phi), r * np.sin(phi), 0 * r], axis=1)


def in_cone(axis, half_angle, count=20_000):
    """Directions in a cone and on its surface."""
    mu = 1 - (1 - math.cos(half_angle)) * RNG.random(count)
    mu[::3] = math.cos(half_angle)
    axis = np.asarray(axis)
    u = np.cross(axis, (0, 1, 0)) / np.linalg.norm(np.cross(axis, (0, 1, 0)))
    v, phi = np.cross(axis, u), 2 * math.pi * RNG.random(count)
    side = np.sqrt(1 - mu**2)[:, None]
    return mu[:, None] * axis + side * (np.cos(phi)[:, None] * u + np.sin(phi)[:, None] * v)


def on_sphere(places, directions):
    """Where rays from within the unit sphere meet it."""
    along = (places * directions).sum(axis=1)
    return places + (np.sqrt(along**2 + 1 - (places**2).sum(axis=1)) - along)[:, None] * directions


@pytest.mark.parametrize("parameters", [{}, {"share": 0.02, "meter": 0.2}, {"share": 0.04, "meter": 0.2}])
def test_the_cone_of_the_glint_is_filled_by_lamp_or_wall_from_all_of_the_meter(parameters):
    for seen, lowest, highest in (
        ("lamp", 1 - 2 * cost_glint.LAMP, 1),
        ("wall", -1, 2 * cost_glint.WALL - 1),
    ):
        detector = cost_glint.scene(seen, **parameters).detectors[0]
        cone = detector.directions
        ends = on_sphere(on_disk(detector.shape.radius), in_cone(cone.axis, cone.half_angle))
        assert (ends[:, 2] >= lowest).all() and (ends[:, 2] <= highest).all()
    with pytest.raises(tp.SceneError, match="so small that the lamp fills the cone"):
        cost_glint.scene("lamp", share=0.12, meter=0.2)
    assert 1 - math.cos(cost_glint.half_angle(1e-4)) == pytest.approx(1e-4, rel=1e-11, abs=0)


def test_behind_the_glass_every_ray_of_the_cone_meets_it_and_in_it_every_ray_gets_out():
    behind = cost_caustic.scene("behind", meter=0.999 * cost_caustic.largest_meter("behind", 1.5)).detectors[
        0
    ]
    places = on_disk(behind.shape.radius) + (0, 0, cost_caustic.PLACE)
    directions = in_cone((0, 0, 1), behind.directions.half_angle)
    miss = np.linalg.norm(np.cross(places, directions), axis=1)
    assert 0.99 < miss.max() <= 1
    inside = on_disk(cost_caustic.largest_meter("inside", 1.5))
    sines = np.linalg.norm(np.cross(inside, in_cone((0, 0, 1), math.pi / 2)), axis=1)  # at the boundary
    assert 0.99 < 1.5 * sines.max() <= 1 + 1e-12


@pytest.mark.parametrize("cosine", [1.0, 0.7, 0.1])
def test_glass_in_a_lamp_holds_n_squared_times_its_radiance_at_any_angle(cosine):
    """Entering light, reflected within 0, 1, 2, ... times; outside, what is reflected and what comes out."""
    passed = float(fresnel.transmittance(cosine, 1.5))
    inside = sum(passed * 1.5**2 * (1 - passed) ** k for k in range(2000))
    assert inside == pytest.approx(1.5**2, rel=1e-12, abs=0)
    assert 1 - passed + passed * inside / 1.5**2 == pytest.approx(1, rel=1e-12, abs=0)


# ---- runs, and wrong answers ----

CASES = {
    "disks": (cost_disks, {}, 1_000_000),
    "speck, disk": (cost_speck, {"lamp": "disk"}, 100_000),
    "speck, sphere": (cost_speck, {"lamp": "sphere"}, 1_000_000),
    "enclosure": (cost_enclosure, {"meter": 0.2}, 1_000_000),
    "fog": (cost_fog, {"albedo": 0.9, "meter": 0.4}, 1_000_000),
    "glint, wall": (cost_glint, {"seen": "wall"}, 300_000),
    "glint, lamp": (cost_glint, {"seen": "lamp"}, 300_000),
    "mirror": (cost_mirror, {"by": "mirror"}, 300_000),
    "periscope": (cost_mirror, {"by": "periscope"}, 300_000),
    "ball": (cost_mirror, {"by": "ball"}, 300_000),
    "caustic, inside": (cost_caustic, {"place": "inside", "meter": 0.6}, 1_000_000),
    "caustic, behind": (cost_caustic, {"place": "behind"}, 100_000, "backward"),
}
WRONG = {
    "disks": {"the inverse square": math.pi**2, "isotropic": math.pi**2 * 2 * (1 - 1 / math.sqrt(2))},
    "speck, disk": {"no cosine where it leaves": 1e-10, "half": 2e-10 / (1 + 0.1**2)},
    "speck, sphere": {"as a disk": 4e-10 / (1 + 0.1**2), "by its nearest point": 1e-10 / 0.9**2},
    "enclosure": {"with direct light": 1 / (4 * math.pi * 0.1), "one reflection": 0.9 / (4 * math.pi)},
    "fog": {
        "straight light": math.exp(-10) * emitters.point_flux_through_disk(1.0, 0.4, 1.25),
        "diffusion": 10.71 * math.sqrt(0.3) / math.sinh(10.71 * math.sqrt(0.3))
        * emitters.point_flux_through_disk(1.0, 0.4, 1.25),
        "a tenth more": 1.1 * cost_fog.exact(albedo=0.9, meter=0.4)[cost_fog.FLUX],
    },
    "glint, wall": {"one reflection": 0.8 / (4 * math.pi**2), "a closed sphere": 0.8 / 0.2 / (4 * math.pi**2)},
    "glint, lamp": {"2π for π": 1 / (8 * math.pi**2 * cost_glint.LAMP), "its cosine": math.cos(0.3) / (4 * math.pi**2 * 0.2)},
    "mirror": {"no reflectance": 3.182215 / 0.9, "as far as the mirror": 9 * 3.182215},
    "periscope": {"one reflectance": 1.611192 / 0.9, "one arm less": 1.611192 * 16 / 9},
    "ball": {"no reflectance": 0.268137 / 0.9, "a flat mirror": 0.9 * 100 / (math.pi * 0.05**2) * (0.05 / 2.4) ** 2},
    "caustic, inside": {"no n²": math.pi, "n for n²": 1.5 * math.pi, "Fresnel once": 0.96 * 2.25 * math.pi},
    "caustic, behind": {"n²": 2.25, "Fresnel twice": 0.92},
}  # fmt: skip


@pytest.fixture(scope="module")
def runs():
    return {
        name: run_experiment(sim, parameters, particles=particles, seed=1, estimator=(*way, None)[0])[0]
        for name, (sim, parameters, particles, *way) in CASES.items()
    }


@slow
@pytest.mark.parametrize("name", CASES)
def test_a_run_meets_the_law_and_none_of_the_wrong_ones(name, runs):
    (row,) = runs[name].rows
    assert_agrees(row.estimate, row.exact, FALSE_ALARM)
    for words, wrong in WRONG[name].items():
        assert not agrees(row.estimate, wrong), words
    assert smallest_bias(row.estimate, FALSE_ALARM) < 0.1


@slow
@pytest.mark.parametrize(
    ("sim", "right", "wrong"),
    [
        (cost_disks, {}, {"distance": 1.02}),
        (cost_speck, {"lamp": "disk"}, {"distance": 1.01, "share": 1e-10 / 1.01**2}),
        (cost_enclosure, {"meter": 0.2}, {"albedo": 0.89}),
        (cost_fog, {"albedo": 0.9, "meter": 0.4}, {"albedo": 0.88}),
        (cost_glint, {"seen": "wall"}, {"albedo": 0.79}),
        (cost_caustic, {"place": "inside", "meter": 0.6}, {"index": 1.45}),
        (cost_mirror, {"by": "periscope"}, {"reflectance": 0.89}),
    ],
)
def test_a_slightly_different_scene_is_rejected(sim, right, wrong):
    [outcome] = run_experiment(sim, right | wrong, particles=300_000, seed=1, threads=2)
    assert not agrees(outcome.rows[0].estimate, the_value(sim, **right))


@slow
def test_a_detector_without_scores_has_no_error_bar():
    """The speck's analog run and the glint's: 0 without an error bar, and a verdict that claims none."""
    for sim in (cost_speck, cost_glint):
        outcomes = run_experiment(sim, particles=10_000, seed=1, estimator="analog", threads=1)
        for outcome in outcomes:
            (row,) = outcome.rows
            assert row.estimate.value == 0
            assert row.estimate.reason == "no score"
        assert sim.verdict(outcomes).endswith("no reading has an error bar.")
