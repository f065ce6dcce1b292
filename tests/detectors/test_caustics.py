"""Light that mirrors and glass send on to walls that a camera sees: histories from the lamps bring it, too.

Histories from cameras and from lamps share such paths (compile/caustics.py), so that the weights of each path must add up to 1, in
its pixel, whatever else a history meets.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_rejected, assert_z_spread
from tests.slow import quick
from tests.tracking_scenes import assert_closed
from transport.compile import adjoint, caustics
from transport.compile.compiler import compile_scene
from transport.compile.methods import Method
from transport.engine.program import build_program
from transport.results.diagnostics.proofs import nearest_rays, pixels_of

CAMERA = tp.Camera(
    name="view", position=(0, -1.3, 1), look_at=(0, 0.3, 0.6), field_of_view=math.pi / 3, pixels=(8, 6)
)
MAP = tp.EnvironmentMap(name="map", position=(0.1, -0.8, 0.7), theta=4, phi=6)
GLASS = tp.Surface(tp.Sphere(center=(0.4, 0.3, 0.4), radius=0.3), tp.Dielectric(1.5), "glass")
BALL = tp.Surface(tp.Sphere(center=(-0.4, 0.3, 0.4), radius=0.3), tp.Mirror(), "ball")
MIXED = tp.Surface(
    tp.Sphere(center=(0, -0.2, 1.5), radius=0.35),
    tp.Mixture({tp.Mirror(): 0.5, tp.Glossy(0.3): 0.5}),
    "mixed",
)
PANEL = tp.Rectangle(center=(0, 1.3, 1), normal=(0, -1, 0), width=0.6, height=0.6)
GLOSS = tp.Surface(tp.Sphere(center=(0, -0.2, 0.2), radius=0.15), tp.Glossy(0.2), "gloss")
ALL = GLASS, BALL, MIXED, GLOSS
BACKWARD = Method("backward")


def run(scene, particles, seed=1, **how):
    return tp.simulate(scene, particles, seed=seed, progress=False, **how)


def furnace(*objects, albedo=0.5, detectors=(CAMERA,)):
    """A closed room whose walls send on what they do not absorb: radiance is 1 everywhere, in each direction."""
    faces = tp.Box(center=(0, 0, 1), size=(2, 3, 2)).faces().items()
    walls = [tp.Surface(face, tp.Diffuse(albedo), f"wall {name}") for name, face in faces]
    lamps = [tp.Source(wall.name, tp.Lambertian(radiance=1 - albedo), side="back") for wall in walls]
    return tp.Scene(lamps, [*walls, *objects], detectors)


def passes_of(scene):
    plan = compile_scene(scene, None, BACKWARD)
    return {each.name for each in build_program(plan.apart()).passes}


# ---- exact radiance ----


@pytest.mark.parametrize("objects", quick([(GLASS,), (BALL,), ALL], ALL))
def test_a_room_of_one_radiance_looks_alike_everywhere(objects):
    """By way of glass, of a mirror, and of mixtures and gloss between them: a path lost or scored twice shows."""
    result = run(furnace(*objects, detectors=[CAMERA, MAP]), 400_000)
    for name in ("view", "map"):
        assert_agrees(result[name].radiance, 1.0)
        whole = (
            result[name]
            .radiance.sum("v" if name == "view" else "theta")
            .sum("u" if name == "view" else "phi")
        )
        bins = 48 if name == "view" else 24
        assert_agrees(whole / bins, 1.0)
        assert_rejected(whole / bins, 0.97)
    shares = [run_source.radiance.value for run_source in result["view"].by_source.values()]
    assert np.sum(shares, axis=0) == pytest.approx(result["view"].radiance.value, rel=1e-12)
    assert_closed(result)


def scene_of_a_wall_that_a_mirror_ball_lights(radius=1e-3, far=1000.0, wide=1.0, reflectance=0.8, unit=1.0):
    """A small mirror ball above a wall, before a distant disk that the wall does not see."""
    lamp = tp.Disk(center=(-far * unit, 0, 0), normal=(1, 0, 0), radius=wide * unit)
    ball = tp.Surface(tp.Sphere(radius=radius * unit), tp.Mirror(reflectance), "ball")
    wall = tp.Rectangle(center=(0, 0, -unit), width=3 * unit, height=3 * unit)
    screen = tp.Box(center=(-1.6 * unit, 0, -unit), size=(0.1 * unit, 4 * unit, unit))
    where = {"position": (0.3 * unit, 0, -0.5 * unit), "look_at": (0, 0, -unit), "field_of_view": 0.8}
    camera = tp.Camera(name="view", pixels=(1, 1), **where)
    return tp.Scene(
        tp.Source(lamp, tp.Lambertian(radiance=1.0)),
        [ball, tp.Surface(wall, tp.Diffuse(0.5), "wall"), tp.Surface(screen, tp.Black(), "screen")],
        camera,
    )


@pytest.mark.parametrize("unit", [1.0, 1e-9, 1.5e11])
def test_a_wall_that_a_mirror_ball_alone_lights(unit):
    """A small ball sends parallel light of irradiance E0 on evenly: E = R E0 radius^2/(4 d^2) (Lambert's cosine 1).

    The lamp is a distant disk that the wall does not see. No history from the camera would find the ball.
    """
    radius, far, wide, reflectance = 1e-3, 1000.0, 1.0, 0.8
    scene = scene_of_a_wall_that_a_mirror_ball_lights(radius, far, wide, reflectance, unit)
    (camera,) = scene.detectors
    intensity = reflectance * math.pi * wide**2 / far**2 * radius**2 / 4
    # the mean over the pixel's solid angle of E/pi times the albedo, E = I cos/d^2
    left, up, forward = map(np.array, camera.frame)
    u, v = np.meshgrid(*[math.tan(0.4) * (np.arange(200) + 0.5 - 100) / 100] * 2)
    rays = forward + u[..., None] * left + v[..., None] * up
    places = np.array((0.3, 0, -0.5)) + rays * (-0.5 / rays[..., 2:])
    weights = np.linalg.norm(rays, axis=-1) ** -3
    exact = 0.5 / math.pi * intensity * np.average(np.linalg.norm(places, axis=-1) ** -3, weights=weights)
    found = run(scene, 2_000_000)["view"].radiance[0, 0]
    assert float(found.relative_error) < 0.02
    assert float(found.value) == pytest.approx(exact, abs=4 * float(found.error) + 0.003 * exact)


def test_a_mirror_ball_in_the_shadow_of_another_does_not_light_the_wall_twice():
    """Histories that are aimed at the one in the shadow meet the other first, and end."""
    scene = scene_of_a_wall_that_a_mirror_ball_lights()
    hidden = tp.Surface(tp.Sphere(center=(0.1, 0, 0), radius=0.85e-3), tp.Mirror(0.8), "hidden")
    alone, both = (
        run(replace(scene, surfaces=surfaces), 500_000)["view"].radiance[0, 0]
        for surfaces in (scene.surfaces, [*scene.surfaces, hidden])
    )
    assert_agrees(both / alone, 1.0)
    assert_rejected(both / alone, 0.7)


def test_the_glossy_part_of_a_mixture_is_left_to_histories_from_the_camera():
    """Their rays connect it to the lamp, so that histories from the lamp begin at its mirror part alone."""
    scene = scene_of_a_wall_that_a_mirror_ball_lights(radius=0.2, far=100.0)
    ball, *others = scene.surfaces
    materials = tp.Mirror(), tp.Glossy(0.3), tp.Mixture({tp.Mirror(): 0.5, tp.Glossy(0.3): 0.5})
    mirror, gloss, mixed = (
        run(replace(scene, surfaces=[replace(ball, material=each), *others]), 500_000)["view"].radiance[0, 0]
        for each in materials
    )
    assert_agrees(mixed / (0.5 * mirror + 0.5 * gloss), 1.0)
    assert_rejected(mixed / (0.5 * mirror + 0.5 * gloss), 1.2)


def test_other_detectors_of_the_run_keep_all_their_paths():
    """Histories from a Detector score what they find by way of glass, as no ray from a lamp ends there."""
    patch = tp.Detector(tp.Disk(center=(0, -0.5, 0.5), radius=0.1), "patch")
    scene = furnace(GLASS, BALL, detectors=[CAMERA, patch])
    assert "begin_at_sensor" in passes_of(scene)
    assert_agrees(run(scene, 400_000)["patch"].irradiance, math.pi)


def test_many_specular_surfaces_are_not_aimed_at_one_by_one(monkeypatch):
    """Nearly all histories start at the lamps, to show what those of the camera would hide."""
    monkeypatch.setattr(caustics, "MAX_AIMS", 3)
    for module in (caustics, adjoint):
        monkeypatch.setattr(module, "SHARE", 0.99)
    scene = furnace(GLASS, replace(BALL, name="one more"))
    plan = compile_scene(scene, None, BACKWARD)
    assert len(plan.emitters) == 1 + 6
    result = run(scene, 400_000)
    assert_agrees(result["view"].radiance, 1.0)


# ---- errors ----


@pytest.mark.slow
def test_claimed_errors_are_true_errors():
    """Of the whole picture, over 200 seeds."""
    z = [
        float((run(furnace(GLASS, BALL), 20_000, seed)["view"].radiance.sum("v").sum("u") / 48).z(1.0))
        for seed in range(200)
    ]
    assert_z_spread(np.array(z), math.inf)


# ---- only where there is such light ----


@pytest.mark.parametrize(
    ("surfaces", "starts_at_lamps"),
    [((), False), ((GLOSS,), False), ((GLASS,), True), ((BALL,), True),
     ((tp.Surface(PANEL, tp.Mirror(), "panel"),), False)],
)  # fmt: skip
def test_histories_start_at_lamps_where_no_ray_connects_mirrors_or_glass(surfaces, starts_at_lamps):
    names = {
        "begin_at_lamp", "begin_at_sensor", "keep_rays_to_lamps", "weigh_rays_to_view", "note_first_interaction",
        "note_first_wall", "weigh_flights_to_lamps", "score_in_view",
    }  # fmt: skip
    assert passes_of(furnace(*surfaces)) & names == (names if starts_at_lamps else set())


def test_a_detector_alone_a_fog_or_a_camera_on_a_wall_start_no_history_at_lamps():
    patch = tp.Detector(tp.Disk(center=(0, -0.5, 0.5), radius=0.1), "patch")
    on_wall = replace(CAMERA, position=(0, -1.5, 1))
    fog = replace(furnace(BALL), medium=tp.Medium(scattering=0.1))
    for scene in (furnace(GLASS, detectors=[patch]), furnace(GLASS, detectors=[on_wall]), fog):
        assert "begin_at_lamp" not in passes_of(scene)


def test_lamps_without_a_way_to_a_mirror_start_no_history_at_lamps():
    """A ball behind a flat lamp; a lamp in two bodies that absorb, from which no history can start."""
    floor = tp.Surface(tp.Rectangle(width=3, height=3), tp.Diffuse(0.5), "floor")
    lamp = tp.Source(
        tp.Rectangle(center=(0, 0, 2), normal=(0, 0, -1), width=1, height=1), tp.Lambertian(power=1.0)
    )
    balls = [
        tp.Surface(tp.Sphere(center=(0, 0, z), radius=0.2), tp.Mirror(), f"ball {k}")
        for k, z in enumerate((1.5, 2.5))
    ]
    tank = tp.Surface(
        tp.Box(center=(1, 0, 2), size=2), tp.Transparent(), "tank", inside=tp.Medium(absorption=0.2)
    )
    for surfaces, starts_at_lamps in (([balls[0]], True), ([balls[1]], False), ([balls[0], tank], False)):
        scene = tp.Scene(lamp, [floor, *surfaces], replace(CAMERA, position=(-0.5, -1, 1), look_at=(0, 0, 0)))
        assert ("begin_at_lamp" in passes_of(scene)) == starts_at_lamps
        assert run(scene, 1000)["view"].radiance.value.sum() > 0


# ---- findings ----


def floor_below_a_ball(field_of_view=0.3):
    """A floor that a lamp lights through a ball of glass in a hole alone."""
    lamp = tp.Source(
        tp.Disk(center=(0, 0, 1.6), normal=(0, 0, -1), radius=0.02), tp.Lambertian(radiance=100.0)
    )
    ball = tp.Surface(tp.Sphere(center=(0, 0, 1.12), radius=0.1), tp.Dielectric(1.5), "ball")
    hole = tp.Disk(center=(0, 0, 1), radius=0.06)
    screen = tp.Rectangle(center=(0, 0, 1), width=0.8, height=0.8, hole=hole)
    floor = tp.Surface(tp.Rectangle(width=3, height=3), tp.Diffuse(0.7), "floor")
    where = {"position": (0, -1.2, 0.8), "look_at": (0, 0, 0), "pixels": (8, 6)}
    camera = tp.Camera(name="view", field_of_view=field_of_view, **where)
    return tp.Scene(lamp, [ball, tp.Surface(screen, tp.Black(), "screen"), floor], camera)


def total(result):
    return result["view"].radiance.sum("v").sum("u")


def test_too_few_histories_of_a_caustic_are_found():
    result = run(floor_below_a_ball(), 64)
    assert "via 'ball' not sampled" in str(total(result).findings)
    assert total(result).verdict == "doubtful"
    assert "0.125 of the histories start at lamps" in result.report()


def test_light_by_way_of_glass_is_no_doubt_where_the_picture_does_not_show_the_glass():
    """No history from the camera then has to meet it: no path by way of glass is left to chance."""
    result = run(floor_below_a_ball(), 100_000)
    assert float(total(result).relative_error) < 0.03
    assert total(result).verdict == "sound"
    ((_, mean),) = result["view"].diagnosis.totals()
    assert mean.verdict == "sound"
    assert "light via 'ball'" not in str(mean.findings)


@pytest.mark.parametrize(
    ("center", "is_shown"),
    [((0, 0, 0), True), ((0, -2, 1), False), ((0, 0, 1.12), False), ((2, 0, 0), False), ((-2, 0, 0), False),
     ((0, 0.2, 0.1), True), ((0, -1.5, -1.5), False), ((0.2, 0, 0), True)],
)  # fmt: skip
def test_shapes_outside_of_a_picture_are_known(center, is_shown):
    (camera,) = floor_below_a_ball().instruments
    assert caustics.may_show(camera, tp.Sphere(center=center, radius=0.05)) == is_shown


def test_a_wall_behind_a_camera_is_not_in_its_picture():
    """Though a corner of it lies before the plane of a camera that looks down."""
    wall = tp.Rectangle(center=(0, -1.5, 1), normal=(0, 1, 0), width=2, height=2)
    assert not caustics.may_show(CAMERA, wall)
    assert caustics.may_show(MAP, wall)


def small_lamp_in_a_mirror_ball(pixels=(8, 6)):
    """A wide lamp and a small bright one, whose glint on a mirror ball fills a small part of one pixel."""
    wide = tp.Source(
        tp.Rectangle(center=(0, 0, 1.99), normal=(0, 0, -1), width=0.4, height=0.4),
        tp.Lambertian(radiance=100.0),
    )
    small = tp.Source(tp.Sphere(center=(0.7, 0.7, 1.5), radius=0.05), tp.Lambertian(radiance=1000.0))
    room = tp.Surface(tp.Box(center=(0, 0, 1), size=(2, 3, 2)), tp.Diffuse(0.5), "room")
    return tp.Scene([wide, small], [room, BALL], replace(CAMERA, pixels=pixels))


@pytest.mark.slow
def test_sound_pixels_beside_glints_hold_what_they_claim():
    scene = small_lamp_in_a_mirror_ball((16, 12))
    true, z = run(scene, 2e7)["view"].radiance, []
    for seed in range(2, 22):
        view = run(scene, 1e5, seed)["view"].radiance
        z.append(((view.value - true.value) / np.hypot(view.error, true.error))[view.verdict == "sound"])
    everything = np.concatenate(z)
    assert everything.size > 20 * 80
    assert np.abs(everything).max() < 5 and 0.7 < everything.std() < 1.05


def test_a_pixel_that_may_hold_a_glint_is_no_more_certain_than_its_own_flights():
    scene = small_lamp_in_a_mirror_ball((16, 12))
    ball, view = pixels_of(scene.detectors[0], [BALL.shape]).reshape(12, 16), run(scene, 1e6)["view"]
    assert 15 < ball.sum() < 60
    assert not (view.radiance.verdict == "sound")[ball].any()
    assert (view.radiance.verdict == "sound")[~ball].sum() > 80
    (warning,) = [each for each in view.diagnosis.findings() if each.severity == "doubtful"]
    assert warning.what == "light from 'sources[1]' via 'ball' not sampled in single pixels"
    assert warning.advice.startswith("use about ") and "which matters in" in warning.seen


SHAPES = (
    tp.Sphere(center=(0.4, 0.3, 0.4), radius=0.1),
    tp.Box(center=(-0.5, 0.6, 0.5), size=(0.2, 0.5, 0.1)),
    tp.Disk(center=(0, 1.2, 0.7), normal=(1, 2, 1), radius=0.2),
    tp.Rectangle(center=(0.3, 0.9, 1.4), normal=(0, -1, 0.3), width=0.7, height=0.1),
    tp.Cylinder(center=(-0.2, 0.5, 0.2), axis=(0, 0, 1), radius=0.1, height=0.3),
)
VIEWS = replace(CAMERA, pixels=(40, 30)), replace(MAP, theta=24, phi=48)


def cells_of(view, rays):
    """Numbers of the pixels or bins, as stored, of rays (n, 3) of any length; -1 outside of a picture."""
    if isinstance(view, tp.Camera):
        left, up, depth = np.array(view.frame) @ rays.T
        at, edges = (up / depth, -left / depth), view.edges().values()
    else:
        at = np.arctan2(rays[:, 1], rays[:, 0]) % (2 * math.pi), rays[:, 2] / np.linalg.norm(rays, axis=1)
        edges = view.edges()["phi"], np.cos(view.edges()["theta"])[::-1]
    row, column = (np.searchsorted(edge, each) - 1 for edge, each in zip(edges, at, strict=True))
    rows, columns = (len(edge) - 1 for edge in edges)
    is_in = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
    return np.where(is_in, row * columns + column, -1)


@pytest.mark.parametrize("view", VIEWS, ids=["camera", "map"])
def test_pixels_that_may_show_a_shape(view):
    """Of shapes of all kinds: each pixel in which a random point of the shape lies, with the rays from there."""
    rng = np.random.default_rng(3)
    for shape in SHAPES:
        places, normals = map(
            np.concatenate,
            zip(*(piece.sample_area(rng.random((20_000, 2))) for piece in shape.pieces()), strict=True),
        )
        is_in = cells_of(view, places - view.position) >= 0
        rays, normals = (places - view.position)[is_in], normals[is_in]
        cells = cells_of(view, rays)
        shown, found = pixels_of(view, [shape]), np.unique(cells)
        assert shown[found].all() and shown.sum() < 3 * found.size + 40
        square = (rays**2).sum(axis=1)
        kernel = np.abs((rays * normals).sum(axis=1)) / (math.pi * square**1.5)
        bound = nearest_rays(view, [shape])
        assert (kernel <= bound[cells] * (1 + 1e-9)).all() and not bound[~shown].any()
        if shape.is_flat:
            assert (kernel > 0.5 * bound[cells]).any()
    assert pixels_of(view, [tp.Sphere(center=view.position, radius=0.2)]).all()
    assert not pixels_of(view, []).any()
    assert not pixels_of(CAMERA, [tp.Sphere(center=(0, -3, 1), radius=0.1)]).any()


def test_a_glint_by_two_mirrors_is_doubted_where_the_first_of_them_is_seen():
    """The ball does not face the lamp; the mirror on the floor shows the lamp in it."""
    scene = small_lamp_in_a_mirror_ball((16, 12))
    down = tp.Source(
        tp.Disk(center=(0.5, 0.3, 0.9), normal=(0, 0, -1), radius=0.03), tp.Lambertian(radiance=1e4)
    )
    floor = tp.Rectangle(center=(0.2, 0.2, 0.02), normal=(0, 0, 1), width=1.2, height=1.6)
    ball = tp.Surface(tp.Sphere(center=(-0.4, 0.5, 1.4), radius=0.2), tp.Mirror(), "ball")
    surfaces = [scene.surfaces[0], ball, tp.Surface(floor, tp.Mirror(), "mirror")]
    view = run(replace(scene, sources=[down], surfaces=surfaces), 3e5)["view"].radiance
    shown = pixels_of(scene.detectors[0], [ball.shape]).reshape(12, 16)
    assert shown.sum() > 5 and not (view.verdict == "sound")[shown].any()
    (finding,) = [each for each in view.findings if "via 'mirror' not sampled" in each.what]
    assert finding.bound[shown].min() > 2.9 * 1e4 / (
        3e5 / (16 * 12)
    )  # as much as three births that show the lamp


def test_a_card_near_the_camera_is_doubted_for_caustics_that_only_its_own_flights_find():
    """Histories from the lamp have little weight there, and neighbouring pixels show what they have much weight for."""
    scene = floor_below_a_ball(0.8)
    (camera,) = scene.instruments
    ahead = np.array(camera.position) + 0.1 * np.array(camera.forward)
    card = tp.Rectangle(
        center=tuple(ahead.tolist()), normal=(0, -0.5, 1), up=(0, 1, 0.5), width=0.01, height=0.01
    )
    camera = replace(camera, pixels=(16, 12))
    surfaces = [*scene.surfaces, tp.Surface(card, tp.Diffuse(0.7), "card")]
    view = run(replace(scene, surfaces=surfaces, detectors=[camera]), 4e5)["view"].radiance
    shown = pixels_of(camera, [card]).reshape(12, 16)
    assert 0 < shown.sum() < 20
    assert (view.verdict == "sound")[~shown].mean() > 0.5 and not (view.verdict == "sound")[shown].any()


def test_a_pixel_in_which_one_history_meets_a_lamp_hundreds_of_times_is_not_sound():
    """A lamp in a box of mirrors, which the camera sees through a small hole alone."""
    mirrors = [
        tp.Surface(
            replace(face, hole=tp.Disk(center=face.center, normal=face.normal, radius=0.002))
            if name == "+z"
            else face,
            tp.Mirror(0.9995),
            name,
        )
        for name, face in tp.Box(size=0.4).faces().items()
    ]
    lamps = [
        tp.Source(tp.Disk(radius=0.19), tp.Lambertian(radiance=1.0)),
        tp.Source(tp.Disk(center=(0, 0, 3.0), normal=(0, 0, -1), radius=1.0), tp.Lambertian(radiance=1.0)),
    ]
    floor = tp.Surface(tp.Rectangle(center=(0, 0, -0.3), width=6, height=6), tp.Diffuse(0.5), "floor")
    camera = tp.Camera(
        name="view", position=(0, -0.8, 0.9), look_at=(0, 0, 0.2), field_of_view=0.6, pixels=(4, 3)
    )
    scene = tp.Scene(lamps, [*mirrors, floor], camera)
    for seed in range(5):
        view = run(scene, 1e5, seed)["view"].radiance
        assert not ((view.verdict == "sound") & (view.error > 0.5 * view.value)).any()
