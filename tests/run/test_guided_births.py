"""Births by a learnt density: unbiased whatever was learnt, and precise where light comes by mirrors, glass or a small opening."""

from __future__ import annotations

import math
import sys
from dataclasses import replace

import numpy as np
import pytest

import transport as tp
from tests.focusing_scenes import SCENES, VALUES
from tests.specular_scenes import (
    BALL,
    IMAGE_PLACE,
    LAMP_PLACE,
    UNLIT_METAL,
    ball_scene,
    by_point,
    direct,
    lamp,
    mirrored,
    panel_scene,
    point_lamp,
)
from transport.compile.guides import LEAST, MAX_BOXES, UNIFORM, learn_guide
from transport.compile.methods import MAX_GUIDE, MIN_GUIDE, Method
from transport.engine.driver import compile_program, run_batch
from transport.engine.program import build_program
from transport.run.guiding import _sums_per_history
from transport.run.programs import plan_for
from transport.sims import cost_mirror

RADIUS = 1e-3


def unconnected(scene: tp.Scene) -> tp.Scene:
    return replace(scene, surfaces=(*scene.surfaces, UNLIT_METAL))


CONNECTED = panel_scene(RADIUS, lamp(), tp.Mirror(1.0), is_behind=False)
MIRROR = unconnected(CONNECTED)
HALF = unconnected(panel_scene(RADIUS, lamp(), tp.Mirror(0.5, 0.5), is_behind=False))


def run(scene: tp.Scene, particles: float = 2e5, **options) -> tp.Result:
    return tp.simulate(scene, particles=particles, progress=False, **{"seed": 1} | options)


# ---- what is learnt ----


def two_spots(count: int = 4000) -> tuple[np.ndarray, np.ndarray]:
    """Histories that scored: a bright spot, and a fainter one on both sides of the end of a turn."""
    rng = np.random.default_rng(7)
    numbers = rng.random((count, 4))
    bright = rng.random(count) < 0.8
    numbers[:, 0] = np.where(bright, 0.25 * numbers[:, 0], numbers[:, 0])
    numbers[:, 2] = np.where(bright, 0.31, 0.72) + 0.01 * rng.random(count)
    numbers[:, 3] = np.where(bright, 0.4 + 0.02 * rng.random(count), (0.99 + 0.02 * rng.random(count)) % 1.0)
    return numbers, np.where(bright, 4.0, 1.0)


def density_at(guide, numbers: np.ndarray) -> np.ndarray:
    """The density of births at points of the unit cube."""
    inside = (numbers[:, None] >= guide.lows) & (numbers[:, None] < guide.lows + guide.widths)
    found = np.argmax(inside.all(axis=2), axis=1)
    return (guide.shares / np.prod(guide.widths, axis=1))[found]


def test_a_guide_is_a_density_with_weights_of_its_inverse():
    guide = learn_guide(*two_spots())
    volumes = np.prod(guide.widths, axis=1)
    assert volumes.sum() == pytest.approx(1.0, rel=1e-12)
    assert guide.shares.sum() == pytest.approx(1.0, rel=1e-12)
    assert (
        guide.weights * guide.shares / volumes == pytest.approx(LEAST, rel=1e-12)
    ) and guide.weights.max() <= 1.0
    assert 10 < len(guide.shares) <= MAX_BOXES


def test_a_guide_sends_most_births_where_histories_scored():
    numbers, squares = two_spots()
    guide, others = learn_guide(numbers, squares), two_spots(3000)[0]
    assert np.median(density_at(guide, others)) > 500.0  # the spots fill 3e-4 of the cube
    spread = np.random.default_rng(8).random((2000, 4))
    assert np.median(density_at(guide, spread)) >= LEAST


def test_a_guide_does_not_follow_a_single_heavy_score():
    numbers, squares = two_spots()
    heavy = squares.copy()
    heavy[17] = 1e9
    there, elsewhere = (
        density_at(learn_guide(numbers, heavy), numbers),
        density_at(learn_guide(numbers, squares), numbers),
    )
    assert np.median(there / elsewhere) > 0.5


def test_from_few_scores_nothing_is_learnt():
    numbers, squares = two_spots(5)
    assert learn_guide(numbers, squares) is UNIFORM


# ---- the estimates ----


def test_where_nothing_is_learnt_all_numbers_are_those_without_a_guide():
    """One history teaches nothing; its guide passes all numbers on, and the weights are scaled by a power of two."""
    plain, same = (run(MIRROR, 3e5, estimator="backward", guide=guide)["m"].irradiance for guide in (0, 1))
    np.testing.assert_array_equal(plain.values, same.values)


@pytest.mark.parametrize(
    ("scene", "value"),
    [(MIRROR, direct(RADIUS) + mirrored(RADIUS)), (HALF, direct(RADIUS) + 0.5 * mirrored(RADIUS))],
)
def test_light_by_a_mirror_is_found_by_a_point_like_detector(scene, value):
    found = run(scene, estimator="backward", guide=1 << 20)["m"].irradiance
    assert abs(found.z(value)) < 4
    assert found.error < 0.005 * found.value  # without a guide 20 %


def test_a_caustic_of_a_glass_ball():
    value, error, *_ = BALL[1e-3]
    found = run(ball_scene(1e-3, is_behind=False), estimator="backward")["m"].irradiance
    assert abs(found.value - value) < 4 * np.hypot(found.error, error)
    assert found.error < 0.003 * found.value  # without a guide 0.9 %


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_light_by_a_periscope_a_lens_a_prism_and_a_glass_of_water(name):
    """Three seeds agree; the median error counts, as a guide of the prism has now and then missed an edge of its light."""
    value, error = VALUES[name]()
    found = [run(SCENES[name](), 2e6, estimator="backward", seed=seed)["m"].irradiance for seed in (1, 2, 3)]
    for each in found:
        assert abs(each.value - value) < 4 * np.hypot(each.error, error)
    assert np.median([each.relative_error for each in found]) < 0.005


SOURCES = {
    "point": tp.Source(tp.Point(position=(0, 0, 1)), tp.Isotropic(power=1.0)),
    "disk": tp.Source(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.2), tp.Lambertian(power=1.0)),
    "rectangle": tp.Source(
        tp.Rectangle(center=(0, 0, 1), normal=(0, 0, -1), up=(1, 0, 0), width=0.3, height=0.2),
        tp.Lambertian(power=1.0),
    ),
    "triangle": tp.Source(
        tp.Triangle(vertices=[(0, 0, 1), (0.3, 0, 1), (0, 0.3, 1)]), tp.Lambertian(power=1.0), side="back"
    ),
    "sphere": tp.Source(tp.Sphere(center=(0, 0, 1), radius=0.1), tp.Lambertian(power=1.0)),
    "ball": tp.Source(tp.Sphere(center=(0, 0, 1), radius=0.1), tp.Isotropic(power=1.0)),
    "box": tp.Source(tp.Box(center=(0, 0, 1), size=0.2), tp.Isotropic(power=1.0)),
    "beam": tp.Source(
        tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.2), tp.Beam((0, 0, -1), power=1.0)
    ),
}


@pytest.mark.parametrize("estimator", ["analog", "expected"])
@pytest.mark.parametrize("name", SOURCES)
def test_every_source_gives_the_same_with_a_guide(name, estimator):
    """A small detector in a grey room, and a mirror: with a guide and without one the estimates agree."""
    room = tp.Surface(tp.Box(size=3.0), tp.Diffuse(0.5), "room")
    mirror = tp.Surface(tp.Disk(center=(0.9, 0, 0), normal=(-1, 0, 0), radius=0.5), tp.Mirror(0.9), "mirror")
    meter = tp.Detector(tp.Disk(center=(0, 0.05, 0), radius=0.1), "m")
    scene = tp.Scene([SOURCES[name]], [room, mirror], [meter])
    plain, led = (run(scene, 2e5, estimator=estimator, guide=guide) for guide in (0, 1 << 17))
    other = led["m"].irradiance - run(scene, 2e5, estimator=estimator, guide=0, seed=2)["m"].irradiance
    assert abs(other.value) < 4 * np.hypot(led["m"].irradiance.error, plain["m"].irradiance.error)
    assert led["m"].irradiance.error < 1.2 * plain["m"].irradiance.error
    assert sum(entry.value for key, entry in led.ledger.items() if key != "emitted") == pytest.approx(
        1.0, rel=1e-12
    )
    assert abs(led.ledger["unsampled"].z(0.0)) < 4 or led.ledger["unsampled"].value == 0


def test_a_small_opening_is_found_forward():
    """A lamp in a black box with a hole of 7e-5 of all directions lights a detector behind it."""
    wall = tp.Surface(
        tp.Rectangle(
            center=(0, 0, 1), normal=(0, 0, 1), up=(0, 1, 0), width=4, height=4,
            hole=tp.Rectangle(center=(0, 0, 1), normal=(0, 0, 1), up=(0, 1, 0), width=0.03, height=0.03),
        ),
        tp.Black(),
    )  # fmt: skip
    source = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    scene = tp.Scene(
        [source],
        [wall],
        [
            tp.Detector(
                tp.Rectangle(center=(0, 0, 1.5), normal=(0, 0, -1), up=(0, 1, 0), width=2, height=2), "m"
            )
        ],
    )
    found = run(scene, 1e5, guide=1 << 20)["m"].flux_in
    exact = tp.solid_angle(wall.shape.hole, (0, 0, 0)).value / (4 * np.pi)
    assert found.value == pytest.approx(exact, rel=1e-3 + 4 * found.error / found.value)
    assert found.error < 0.02 * found.value


# ---- runs ----


def test_threads_parts_and_seeds():
    """The guide follows from the seed alone: the same result on one thread and two, and from two parts merged."""
    options = {"estimator": "backward", "guide": 1 << 16, "particles": 1e5}
    whole = run(MIRROR, threads=1, **options)
    two = run(MIRROR, threads=2, **options)
    merged = tp.merge(*(run(MIRROR, part=(k, 2), **options) for k in (1, 2)))
    for other in (two, merged):
        np.testing.assert_array_equal(whole["m"].irradiance.values, other["m"].irradiance.values)
    assert run(MIRROR, seed=2, **options)["m"].irradiance.value != whole["m"].irradiance.value


def test_runs_with_different_guides_are_merged_and_those_with_and_without_one_are_not():
    options = {"estimator": "backward", "particles": 2e4}
    one, other, plain = (run(HALF, seed=k, guide=n, **options) for k, n in enumerate((1 << 16, 1 << 15, 0)))
    both = tp.merge(one, other)["m"].irradiance
    assert both.value == pytest.approx(np.mean([each["m"].irradiance.value for each in (one, other)]))
    with pytest.raises(tp.SceneError, match="a guide for both or none"):
        tp.merge(one, plain)


def test_auto_finds_a_point_lamp_behind_a_mirror_with_a_guide():
    scene = unconnected(panel_scene(RADIUS, point_lamp(), tp.Mirror(1.0), is_behind=False))
    found = run(scene, 5e5, estimator="auto", guide=1 << 20)
    value = by_point(RADIUS, LAMP_PLACE) + by_point(RADIUS, IMAGE_PLACE)
    assert found.plan.method.guide == 1 << 20
    assert abs(found["m"].irradiance.z(value)) < 4


def test_a_lamp_in_a_mirror_ball_is_found_by_a_short_guide():
    """Of histories from the meter one in forty thousand meets the lamp, of a guide's first ones one in a hundred."""
    result = run(cost_mirror.scene("ball"), 1e5, estimator="backward", guide=1 << 18)["meter"].irradiance
    assert abs(result.z(cost_mirror.exact(by="ball")["irradiance"])) < 4
    assert result.error < 0.01 * result.value


@pytest.mark.parametrize("limits", [{"particles": 5e5}, {"error": {"m.irradiance": 0.02}}])
def test_auto_tries_guides_where_no_estimator_is_trusted(limits):
    """A point lamp in a mirror ball: backward histories do not find it, no ray connects it, one birth in 1e8 is seen."""
    away, radius = 2.0, 0.3
    source = tp.Source(tp.Point(position=(0, 0, away)), tp.Isotropic(power=100.0))
    ball = tp.Surface(tp.Sphere(radius=radius), tp.Mirror(0.9), "ball")
    detector = tp.Detector(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=1e-3), "m")
    result = run(tp.Scene(source, ball, detector), estimator="auto", **limits)
    behind = 1 / (2 / radius + 1 / (away - radius))  # of the ball's surface: the image of the lamp
    spread = (away - radius) * (behind + 1 - radius) / behind
    assert abs(result["m"].irradiance.z(0.9 * 100 / (4 * math.pi * spread**2))) < 4
    method = result.plan.method
    assert method.guide > 0 and f"guide={method.guide}" in result.choice.lines[1]
    if "particles" in limits:
        again = run(result.scene, result.particles, estimator=method.estimator, guide=method.guide)
        np.testing.assert_array_equal(again["m"].irradiance.values, result["m"].irradiance.values)


@pytest.mark.parametrize(("per_history", "guide"), [(1e-7, MAX_GUIDE), (1e-4, 1 << 14), (1e-2, 0)])
def test_a_run_for_a_time_learns_a_guide_no_longer_than_that(monkeypatch, per_history, guide):
    """Within GUIDE_SECONDS, by halves; what was asked for stays, and so does that of a run of so many particles."""
    monkeypatch.setattr(sys.modules["transport.simulate"], "_seconds_per_history", lambda *_: per_history)
    timed = {"particles": None, "seconds": 0.05, "estimator": "backward"}
    assert run(MIRROR, **timed).plan.method.guide == guide
    assert run(MIRROR, **timed | {"guide": 1 << 15}).plan.method.guide == 1 << 15
    assert run(MIRROR, 2e4, estimator="backward").plan.method.guide == MIN_GUIDE


def test_a_guided_run_is_saved_and_continued(tmp_path):
    path = tmp_path / "run.npz"
    options = {"estimator": "backward", "guide": 1 << 16}
    first = run(HALF, 1e5, checkpoint=path, **options)
    assert tp.load(path).plan.method.guide == 1 << 16
    more, other = (tp.simulate(HALF, particles=2e5, resume=saved, progress=False) for saved in (path, first))
    np.testing.assert_array_equal(more["m"].irradiance.values, other["m"].irradiance.values)
    assert more.plan.method == first.plan.method
    with pytest.raises(tp.SceneError, match="guide"):
        tp.simulate(HALF, particles=2e5, resume=path, guide=5, progress=False)


def test_by_default_runs_with_specular_surfaces_have_a_guide():
    diffuse = panel_scene(RADIUS, lamp(), tp.Diffuse(0.5), is_behind=False)
    for scene, particles, options, expected in [
        (MIRROR, 2e4, {"estimator": "backward"}, MIN_GUIDE),
        (MIRROR, 5e5, {"estimator": "backward"}, 500_000),
        (MIRROR, 2e4, {"estimator": "expected"}, 0),
        (MIRROR, 1e3, {"estimator": "backward"}, 0),
        (CONNECTED, 2e4, {"estimator": "backward"}, 0),
        (MIRROR, 2e4, {"estimator": "analog"}, 0),
        (diffuse, 2e4, {"estimator": "backward"}, 0),
    ]:
        assert run(scene, particles, **options).plan.method.guide == expected


def test_a_point_lamp_behind_a_mirror_lights_a_detector_of_a_millimetre():
    """Of a hundred million births one would meet the detector by way of the mirror."""
    scene = unconnected(panel_scene(RADIUS, point_lamp(), tp.Mirror(1.0), is_behind=False))
    value = by_point(RADIUS, LAMP_PLACE) + by_point(RADIUS, IMAGE_PLACE)
    for estimator in ("analog", "expected"):
        found = run(scene, 1e6, estimator=estimator, guide=1 << 20)["m"].irradiance
        assert abs(found.z(value)) < 4
        assert found.error < 0.01 * value


@pytest.mark.parametrize("place", [-1.0, 3.0])
def test_rays_do_not_hide_rare_flights_from_a_guide(place):
    """By a small ball of glass, with a lamp that all births see or none: as good as where no rays are sent."""
    spot = tp.Source(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=5e-4), tp.Lambertian(power=1.0))
    ball = tp.Surface(tp.Sphere(radius=0.02), tp.Dielectric(1.5), "ball")
    meter = tp.Detector(tp.Disk(center=(0, 0, -0.035), radius=2e-4), "m")
    other = tp.Source(
        tp.Disk(center=(0, 0, place), normal=(0, 0, -place), radius=0.1), tp.Lambertian(power=1e-5)
    )
    scene = tp.Scene([spot, other], [ball], [meter])
    errors = [
        run(scene, estimator=estimator, guide=200_000)["m"].irradiance.relative_error
        for estimator in ("analog", "expected")
    ]
    assert errors[1] < 1.2 * errors[0] < 0.03


def test_a_few_flights_of_a_round_are_no_outliers_among_its_rays():
    """Of the smallest round's 6250 births all send a ray to the detector, and one meets it by way of the mirror."""
    scene = unconnected(panel_scene(0.1, point_lamp(), tp.Mirror(1.0), is_behind=False))
    for seed in (1, 2):
        found = run(scene, estimator="expected", guide=100_000, seed=seed)["m"].irradiance
        assert found.relative_error < 0.02  # it was 0.08 with those of rays


@pytest.mark.parametrize("estimator", ["analog", "expected", "backward"])
def test_births_without_a_guide_decide_the_verdict_and_the_number_that_it_names_suffices(estimator):
    """By all estimators alike: of light that a guide has missed these births alone can tell."""
    light = lamp() if estimator == "backward" else point_lamp()
    scene = unconnected(panel_scene(0.1, light, tp.Mirror(1.0), is_behind=False))
    particles = 2e4
    found = run(scene, particles, estimator=estimator, guide=100_000)
    (doubt,) = (each for each in found.findings if each.severity == "doubtful")
    assert doubt.what.endswith("beyond the guide not sampled")
    assert 4 * particles < doubt.particles < 1000 * particles
    (warning,) = found.warnings
    assert f"about {doubt.advice.split()[2]} particles" in warning and "guide=" not in warning
    longer = run(scene, round(1.2 * doubt.particles), estimator=estimator, guide=100_000)
    assert longer["m"].flux_in.verdict == "bounded" and longer["m"].flux_in.error > 0


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_light_that_a_guide_missed_is_within_the_interval(seed):
    """Of 1.5 % of all light, that by way of a ball, neither the guide nor most of the other births know anything.

    Those that have scored, more than 25, are of the direct light, which the guide sends as well.
    """
    ball = tp.Surface(tp.Sphere(center=(0.5, 0, 0.6), radius=0.3), tp.Mirror(0.9), "ball")
    spot = tp.Detector(tp.Disk(center=(1.5, 0, 0), radius=5e-3), "m")
    scene = tp.Scene(tp.Source(tp.Point(position=(0, 0, 2)), tp.Isotropic(power=100.0)), ball, spot)
    found = run(scene, 4e7, estimator="analog", guide=1_000_000, seed=seed)["m"].flux_in
    direct = 100 / (4 * math.pi) * 2 / (1.5**2 + 2**2) ** 1.5 * spot.shape.area
    assert found.interval()[1] > 1.015 * direct


def test_cures_name_what_was_not_typed_yet():
    walls = [
        tp.Surface(tp.Rectangle(center=(x, 0, 0), normal=(-x, 0, 0), width=5, height=5), tp.Mirror(0.9), name)
        for x, name in ((-1, "left"), (1, "right"))
    ]
    meter = tp.Detector(tp.Disk(center=(0.5, 0, -0.5), normal=(-1, 0, 0), radius=1e-2), "m")
    facing = tp.Scene([point_lamp()], walls, [meter])
    for options, cure in [
        ({}, ". Use guide=1_000_000"),
        ({"sampling": "sobol"}, ". Use random sampling and guide=1_000_000"),
        ({"guide": 100_000}, ". Use about "),
    ]:
        (warning, *_) = run(facing, 2e4, estimator="expected", **options).warnings
        assert cure in warning and warning.count("guide=") == cure.count("guide=")
    found = run(replace(facing, sources=[lamp()]), 2e4, estimator="expected")["m"].flux_in.findings
    (cure,) = (each.cure for each in found if each.name == "path class")
    assert cure == "use estimator='backward' or guide=1_000_000"


def test_the_report_says_what_a_guide_was_learnt_from_and_how_long_it_took():
    report = run(MIRROR, 2e4, estimator="backward").report()
    assert "guide of 2.6e+05 histories" in report and "in which the guide was learnt" in report
    assert "preparation" not in run(CONNECTED, 2e4, estimator="backward").report()


@pytest.mark.parametrize(
    ("options", "cure"),
    [
        ({"sampling": "sobol"}, "leave one of them out"),
        ({"estimator": "aimed"}, "write estimator='analog'"),
        ({"guide": -1}, "guide must be a whole number"),
        ({"guide": 0.5}, "guide must be a whole number"),
    ],
)
def test_what_does_not_go_with_a_guide(options, cure):
    scene = tp.Scene([lamp()], [], [tp.Detector(tp.Disk(radius=0.1), "m")])
    with pytest.raises(tp.SceneError, match=cure):
        run(scene, 1e3, **{"guide": 1000} | options)


def test_a_guide_is_refused_where_it_could_not_send_histories_elsewhere():
    camera = tp.Camera(name="view", position=(0, -3, 0), look_at=(0, 0, 0), pixels=(4, 3))
    scene = tp.Scene([lamp()], [], [camera])
    with pytest.raises(
        tp.SceneError, match="Camera 'view' has bins, in each of which histories start anyhow"
    ):
        run(scene, 1e3, guide=1000)


@pytest.mark.parametrize("medium", [None, tp.Medium(scattering=0.2)])
@pytest.mark.parametrize("estimator", ["analog", "expected", "backward"])
def test_a_program_that_learns_runs_like_one_that_does_not(estimator, medium):
    """Sums of each history change nothing else, and add up to the sums of the detectors."""
    room = tp.Surface(tp.Box(size=3.0), tp.Diffuse(0.5), "room", inside=medium)
    meters = [tp.Detector(tp.Disk(center=(x, 0, 0), radius=0.3), f"m{x}") for x in (-1, 0, 1)]
    scene = tp.Scene([SOURCES["disk"]], [room], meters)
    plan = plan_for(scene, None, Method(estimator, "random", 1000))
    guides, sums = [UNIFORM] * len(plan.emitters), _sums_per_history(plan)
    plain, learning = (
        run_batch(compile_program(build_program(plan, guides, each)), 1, 0, 2000) for each in (None, sums)
    )
    np.testing.assert_array_equal(plain.detectors, learning.detectors)
    np.testing.assert_array_equal(plain.ledger, learning.ledger)
    assert plain.crossings == learning.crossings and not plain.brought.size
    arrived = learning.brought.reshape(len(learning.brought), -1, 2, len(plan.scene.meters))[:, :, 0]
    assert (learning.brought >= 0).all() and arrived.any(axis=(0, 1)).all()


def test_backward_runs_with_lamps_that_are_volumes_only():
    """Such lamps teach a guide nothing; the run is as without one."""
    glow = tp.Source(tp.Sphere(center=(0, 0, 1), radius=0.2), tp.Isotropic(power=1.0))
    mirror = tp.Surface(tp.Disk(center=(0.9, 0, 0), normal=(-1, 0, 0), radius=0.5), tp.Mirror(0.9), "mirror")
    scene = tp.Scene([glow], [mirror], [tp.Detector(tp.Disk(radius=0.1), "m")])
    plain, led = (run(scene, 2e4, estimator="backward", guide=guide)["m"].irradiance for guide in (0, None))
    np.testing.assert_array_equal(plain.values, led.values)


def test_backward_runs_with_lamps_on_surfaces_and_in_volumes():
    """A guide learns from the lamps with a surface alone; it gives what a run without one does."""
    disks = [
        tp.Source(tp.Disk(center=(x, 0, 2), normal=(0, 0, -1), radius=0.1), tp.Lambertian(power=10.0))
        for x in (-1, 1)
    ]
    glow = tp.Source(tp.Sphere(center=(0, 1, 1), radius=0.1), tp.Isotropic(power=5.0))
    ball = tp.Surface(tp.Sphere(center=(0, 0, 0.5), radius=0.2), tp.Mirror(0.9), "ball")
    detector = tp.Detector(tp.Disk(center=(0, 0, 1.2), normal=(0, 0, -1), radius=0.1), "m")
    scene = tp.Scene([disks[0], glow, disks[1]], ball, detector)
    one, other = (run(scene, 2e5, estimator="backward", guide=n)["m"].irradiance for n in (0, MIN_GUIDE))
    assert one.value > 0 and abs((one - other).z(0)) < 4


def test_many_detectors_have_a_guide_without_enlarged_ones():
    meters = [tp.Detector(tp.Disk(center=(x / 40 - 1, 0, -0.8), radius=0.01), f"d{x}") for x in range(20)]
    room = tp.Surface(tp.Box(size=3.0), tp.Diffuse(0.3), "room")
    found = run(tp.Scene([SOURCES["disk"]], [room], meters), 1e4, estimator="expected", guide=1 << 13)
    assert all(found[meter.name].irradiance.value > 0 for meter in meters)


def test_a_guide_learns_from_detectors_on_surfaces():
    scene = tp.Scene([lamp()], [], [tp.VolumeDetector(tp.Sphere(radius=0.1), "v")])
    with pytest.raises(tp.SceneError, match="it learns from Detectors on surfaces"):
        run(scene, 1e3, guide=1000)


def test_a_guide_replaces_an_aim():
    aimed = tp.Source(
        tp.Disk(center=tuple(LAMP_PLACE), normal=(0, 0, -1), radius=0.1),
        tp.Lambertian(power=1.0),
        aim=tp.Disk(radius=0.1),
    )
    with pytest.raises(tp.SceneError, match=r"sources\[0\] has aim"):
        run(tp.Scene([aimed], [], [tp.Detector(tp.Disk(radius=0.1), "m")]), 1e3, guide=1000)
