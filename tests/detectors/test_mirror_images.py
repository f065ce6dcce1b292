"""Shadow rays by way of flat mirrors: they go to the image of a detector, are reflected in turn, and share light with flights."""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.focusing_scenes import by_periscope, periscope
from tests.specular_scenes import (
    IMAGE_PLACE,
    LAMP_PLACE,
    by_point,
    direct,
    lamp,
    mirrored,
    panel_scene,
    point_lamp,
)
from transport.compile.compiler import compile_scene
from transport.compile.images import may_be_seen, outlines_of_images
from transport.compile.methods import Method
from transport.engine.program import build_program

RADIUS = 1e-3


def run(scene: tp.Scene, particles: float, estimator: str, seed: int = 1) -> tp.Estimate:
    guide = {"guide": 0} if estimator == "backward" else {}
    result = tp.simulate(scene, particles=particles, seed=seed, estimator=estimator, progress=False, **guide)
    return result["m"].irradiance


@pytest.mark.parametrize(("reflectance", "transmission"), [(1.0, 0.0), (0.5, 0.5), (0.3, 0.0)])
def test_a_lamp_in_a_mirror(reflectance, transmission):
    scene = panel_scene(RADIUS, lamp(), tp.Mirror(reflectance, transmission), is_behind=False)
    found = run(scene, 2e5, "expected")
    assert abs(found.z(direct(RADIUS) + reflectance * mirrored(RADIUS))) < 4
    assert found.error < 1e-5 * found.value  # by flights alone 20 %
    assert found.verdict == "sound"


def test_a_point_lamp_in_a_mirror_which_no_flight_could_hit():
    found = run(panel_scene(RADIUS, point_lamp(), tp.Mirror(1.0), is_behind=False), 2e5, "expected")
    value = sum(abs(by_point(RADIUS, place)) for place in (LAMP_PLACE, IMAGE_PLACE))
    assert abs(found.z(value)) < 4
    assert found.error < 1e-6 * value


def test_a_periscope():
    found = run(periscope(), 1e5, "expected")
    assert abs(found.z(by_periscope())) < 4
    assert found.error < 1e-6 * found.value
    assert found.verdict == "sound"


@pytest.mark.parametrize("scene", ["mirror", "periscope"])
def test_births_of_backward_runs_send_rays_to_images_too(scene):
    """So no guide is needed, and no doubt left."""
    value = direct(RADIUS) + mirrored(RADIUS) if scene == "mirror" else by_periscope()
    mirror = panel_scene(RADIUS, lamp(), tp.Mirror(1.0), is_behind=False)
    found = run(mirror if scene == "mirror" else periscope(), 1e5, "backward")
    assert abs(found.z(value)) < 4
    assert found.error < 2e-5 * value
    assert found.verdict == "sound"


def upright(x: float, y: float, turn: float, reflectance: float, name: str) -> tp.Surface:
    """An upright mirror that begins on the z axis."""
    normal = (-math.sin(turn), math.cos(turn), 0)
    shape = tp.Rectangle(center=(x, y, 0), normal=normal, up=(0, 0, 1), width=4, height=4)
    return tp.Surface(shape, tp.Mirror(reflectance), name)


@pytest.mark.parametrize(("images", "angle"), [(3, 90.0), (5, 60.0)])
def test_a_point_lamp_in_a_kaleidoscope(images, angle):
    """Two mirrors at 360°/(n + 1) show n images; the last is seen by way of either first."""
    turn = math.radians(angle)
    mirrors = [
        upright(2 * math.cos(at), 2 * math.sin(at), at, rho, name)
        for at, rho, name in ((0.0, 0.8, "one"), (turn, 0.9, "other"))
    ]
    lamp, place = np.array([0.9, 0.3, 0.1]), np.array([1.6, 0.8, 0.2])
    normal = np.array([-1.0, -0.3, 0.0]) / math.hypot(1.0, 0.3)
    source = tp.Source(tp.Point(position=lamp), tp.Isotropic(power=4 * math.pi))
    scene = tp.Scene([source], mirrors, [tp.Detector(tp.Disk(center=place, normal=normal, radius=1e-4), "m")])
    # The images lie on a circle about the z axis, turned by twice the angle at every second reflection.
    radius, first = math.hypot(lamp[0], lamp[1]), math.atan2(lamp[1], lamp[0])
    seen = []
    for number in range(images + 1):
        half = (number + 1) // 2
        at, sign = 2 * half * turn, 1 if number % 2 == 0 else -1
        seen.append((at + sign * first) % (2 * math.pi))
    value = 0.0
    for at in seen:
        apart = np.array([radius * math.cos(at), radius * math.sin(at), lamp[2]]) - place
        shown = max(float(normal @ apart), 0.0) / float(apart @ apart) ** 1.5
        value += shown * math.prod(_reflectances(at, turn, place))
    found = run(scene, 1e5, "expected")
    assert abs(found.value - value) < 4 * found.error + 1e-7 * value


def _reflectances(at: float, turn: float, place: np.ndarray) -> list[float]:
    """Reflectances of the unfolded mirrors between a place within the angle and an image at azimuth `at`."""
    mine, rhos = math.atan2(place[1], place[0]), {0: 0.8, 1: 0.9}
    apart = (at - mine + math.pi) % (2 * math.pi) - math.pi  # the shorter way about the axis
    edges = [k for k in range(-4, 5) if min(mine, mine + apart) < k * turn < max(mine, mine + apart)]
    return [rhos[k % 2] for k in edges]


def room(
    floor: tp.Material, source: tp.Source, meter: tp.Shape, medium: tp.Medium | None, others: str = ""
) -> tp.Scene:
    """A room with diffuse walls, and a floor of another material, as are the `others` by name."""
    faces = tp.Box(center=(0, 0, 1.25), size=(4, 5, 2.5)).faces().items()
    walls = [
        tp.Surface(face, floor if name in ("-z", others) else tp.Diffuse(0.5), name) for name, face in faces
    ]
    return tp.Scene([source], walls, [tp.Detector(meter, "m")], medium=medium or tp.Medium())


LAMPS = {
    "disk": tp.Source(tp.Disk(center=(0.5, 0.4, 2.0), normal=(0.3, 0, -1), radius=0.4), tp.Lambertian(power=10.0)),
    "ball": tp.Source(tp.Sphere(center=(0.5, 0.4, 1.6), radius=0.4), tp.Lambertian(power=10.0)),
}  # fmt: skip
CORNERS = [(-1, -1, 1), (-0.5, -1, 1), (-0.2, -0.3, 1), (-0.7, -0.4, 1), (-1.2, -0.2, 1)]
METERS = {
    "disk": tp.Disk(center=(-1, -1, 1), normal=(0, 0, -1), radius=0.5),
    "ball": tp.Sphere(center=(-1, -1, 1), radius=0.4),
    "polygon": tp.Polygon(vertices=CORNERS),
}
MIXED = tp.Mixture([(tp.Mirror(0.9), 0.4), (tp.Transparent(), 0.3), (tp.Diffuse(0.5), 0.3)])
FLOORS = {
    "mirror": tp.Mirror(0.9),
    "half mirror": tp.Mirror(0.5, 0.4),
    "mixture": MIXED,
    "sides": tp.TwoSided(tp.Black(), tp.Mirror(0.8)),
}
FOG = tp.Medium(scattering=0.4, absorption=0.05)


@pytest.mark.parametrize("floor", FLOORS)
@pytest.mark.parametrize("source", LAMPS)
@pytest.mark.parametrize("meter", METERS)
@pytest.mark.parametrize("medium", [None, pytest.param(FOG, marks=pytest.mark.slow)], ids=["clear", "fog"])
def test_a_room_with_a_mirror_is_the_same_to_all_estimators(floor, source, meter, medium):
    """Planted: the image of the point in mis.record_pdf_across_mirrors left out."""
    scene = room(FLOORS[floor], LAMPS[source], METERS[meter], medium)
    particles = {"analog": 3e5, "expected": 1e5, "backward": 3e5}
    found = {name: run(scene, number, name) for name, number in particles.items()}
    for one, other in (("expected", "analog"), ("backward", "analog"), ("expected", "backward")):
        apart = abs(found[one].value - found[other].value)
        assert apart < 4 * np.hypot(found[one].error, found[other].error), (one, other)


@pytest.mark.parametrize("source", LAMPS)
@pytest.mark.parametrize("meter", METERS)
def test_a_room_with_two_mirrors_is_the_same_to_all_estimators(source, meter):
    """Floor and a wall: chains of one and of two."""
    scene = room(FLOORS["half mirror"], LAMPS[source], METERS[meter], None, "+x")
    assert compile_scene(scene, None, Method("expected")).links is not None
    particles = {"analog": 3e5, "expected": 1e5, "backward": 3e5}
    found = {name: run(scene, number, name) for name, number in particles.items()}
    for one, other in (("expected", "analog"), ("backward", "analog"), ("expected", "backward")):
        apart = abs(found[one].value - found[other].value)
        assert apart < 4 * np.hypot(found[one].error, found[other].error), (one, other)


@pytest.mark.slow
def test_claimed_errors_hold():
    """Forty seeds of each; the spread over the claimed error is known to 11 %."""
    scene = room(FLOORS["mirror"], LAMPS["disk"], METERS["disk"], None)
    for estimator in ("expected", "backward"):
        runs = [run(scene, 4e4, estimator, seed) for seed in range(40)]
        values, claimed = (np.array([getattr(each, name) for each in runs]) for name in ("value", "error"))
        assert 0.6 < values.std(ddof=1) / np.sqrt(np.mean(claimed**2)) < 1.5


# ---- which scenes are connected ----


def links_of(*surfaces: tp.Surface, estimator: str = "expected") -> bool:
    scene = tp.Scene([LAMPS["disk"]], list(surfaces), [tp.Detector(METERS["disk"], "m")])
    plan = compile_scene(scene, None, Method(estimator))
    names = {each.name for each in build_program(plan).passes}
    assert ("redirect_next_event_rays" in names) == (plan.links is not None)
    return plan.links is not None


def flat(material: tp.Material, x: float = 2.0, size: float = 1.0) -> tp.Surface:
    shape = tp.Rectangle(center=(x, 0, 0), normal=(1, 0, 0), width=size, height=size)
    return tp.Surface(shape, material, f"panel {round(x)}")


BALL = tp.Sphere(center=(0, 3, 0), radius=0.5)
SCREEN = tp.Mixture([(tp.Transparent(), 0.5), (tp.Black(), 0.5)])


@pytest.mark.parametrize(
    "surfaces",
    [
        (flat(tp.Mirror(0.5)),),
        (flat(tp.Mirror(0.5)), tp.Surface(BALL, tp.Diffuse(0.5), "ball")),
        (flat(tp.Mirror(0.5)), tp.Surface(BALL, SCREEN, "ball")),
        (tp.Surface(BALL, tp.Mirror(0.0, 0.5), "filter"),),
    ],
    ids=["a mirror", "a mirror and a wall", "a mirror and a screen", "a filter"],
)
def test_flat_mirrors_are_connected(surfaces):
    assert links_of(*surfaces)
    assert not links_of(*surfaces, estimator="analog")


@pytest.mark.parametrize(
    "surfaces",
    [
        (),
        (flat(tp.Diffuse(0.5)),),
        (flat(tp.Mirror(0.5)), flat(tp.Mirror(0.5), 3.0)),
        (flat(tp.Mirror(0.5), size=9), flat(tp.Mirror(0.5), -3.0, size=9)),
        (flat(tp.Mirror(0.5)), tp.Surface(BALL, tp.Dielectric(1.5), "glass")),
        (tp.Surface(BALL, tp.Mirror(0.5), "ball"),),
        (flat(tp.Glossy(0.2, 0.9)),),
        (flat(tp.Conductor(0.2, 3.4)),),
    ],
    ids=[
        "nothing",
        "a wall",
        "two mirrors",
        "facing mirrors",
        "glass too",
        "a curved mirror",
        "gloss",
        "a metal",
    ],
)
def test_others_are_not(surfaces):
    """Their specular light comes by flights; scenes without any have the passes that they had."""
    assert not links_of(*surfaces)


def test_a_sieve_that_light_passes_straight_is_no_obstacle():
    """A lamp of 1 mm behind a screen of which half is open: half the irradiance."""
    source = tp.Source(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=1e-3), tp.Lambertian(power=1.0))
    screen = tp.Surface(tp.Rectangle(center=(0, 0, 0.5), width=1, height=1), SCREEN, "screen")
    meter = tp.Detector(tp.Disk(radius=1e-3), "m")
    half, whole = (run(tp.Scene([source], walls, [meter]), 1e4, "expected") for walls in ([screen], []))
    assert half.value == pytest.approx(0.5 * whole.value, rel=1e-12)


def test_events_are_counted_by_flights():
    """Rays do not count the reflections on their way; planted: chains of mirrors in spite of `events`."""
    source = tp.Source(tp.Point(position=(0, 0, 1)), tp.Isotropic(power=100.0))
    panel = tp.Rectangle(center=(-1, 0, 1), normal=(1, 0, 0), up=(0, 0, 1), width=1.5, height=1.5)
    shape = tp.Disk(center=(0.8, 0, 1), normal=(-1, 0, 0), radius=0.4)
    meters = [tp.Detector(shape, f"after {n}", events=n) for n in (0, 1)]
    scene = tp.Scene([source], [tp.Surface(panel, tp.Mirror(1.0), "panel")], meters)
    analog, expected = (
        tp.simulate(scene, particles=2e5, seed=1, estimator=name, guide=0, progress=False)
        for name in ("analog", "expected")
    )
    for meter in meters:
        one, other = (result[meter.name].flux_in for result in (analog, expected))
        assert abs(one.value - other.value) < 4 * np.hypot(one.error, other.error)


CLOUD = tp.Surface(
    tp.Sphere(center=(0, 0, 1), radius=0.5), tp.Transparent(), "cloud", inside=tp.Medium(absorption=2.0)
)


def test_births_on_the_boundary_of_a_body_send_no_rays():
    """A quarter of the rays would start in the medium on the other side."""
    shape = tp.Disk(center=(0.8, 0, 1), normal=(-1, 0, 0), radius=0.4)
    source = tp.Source(tp.Point(position=(0.5, 0, 1)), tp.Isotropic(power=100.0))
    scene = tp.Scene([source], [CLOUD], [tp.Detector(shape, "m")])
    one, other = (run(scene, 2e5, name) for name in ("analog", "expected"))
    assert abs(one.value - other.value) < 4 * np.hypot(one.error, other.error)
    point = tp.PointDetector(position=(0.5, 0, 1), name="p")
    lamp = tp.Source(tp.Point(position=(0.8, 0, 1)), tp.Isotropic(power=100.0))
    for ends, estimator in (([lamp], "backward"), ([source], "analog")):
        meter = point if estimator == "backward" else tp.PointDetector(position=(0.8, 0, 1), name="p")
        with pytest.raises(tp.SceneError, match="no ray connects it to a point on the boundary of a body"):
            tp.simulate(tp.Scene(ends, [CLOUD], [meter]), particles=100, estimator=estimator)


def test_a_point_lamp_on_a_surface_is_refused_in_backward_runs():
    floor = tp.Surface(tp.Rectangle(width=3, height=3), tp.Black(), "floor")
    lamp = tp.Source(tp.Point(position=(0.3, 0.2, 0.0)), tp.Isotropic(power=100.0))
    meter = tp.Detector(tp.Disk(center=(0.8, 0, 1), normal=(-1, 0, 0), radius=0.4), "m")
    with pytest.raises(tp.SceneError, match="lies on Surface 'floor', where rays end; write"):
        tp.simulate(tp.Scene([lamp], [floor], [meter]), particles=100, estimator="backward")


@pytest.mark.parametrize(("field", "verdict"), [(0.7, "sound"), (1.2, "doubtful")])
def test_a_camera_is_doubted_for_a_mirror_only_where_it_may_see_the_lamp_in_it(field, verdict):
    """The lamp's image lies 19 degrees above the line of sight, the upper edge of the picture at 15 or 27 degrees.

    What a wall shows of the lamp by way of the mirror is connected, in the mirror as well.
    """
    floor = tp.Surface(tp.Rectangle(width=10, height=10), tp.Diffuse(0.6), "floor")
    square = tp.Rectangle(center=(0, 0.9, 1), normal=(0, -1, 0), up=(0, 0, 1), width=1.5, height=1.5)
    mirror = tp.Surface(square, tp.Mirror(0.9), "mirror")
    spot = tp.Source(tp.Disk(center=(0, 0, 1.9), normal=(0, 0, -1), radius=1e-5), tp.Lambertian(power=100.0))
    camera = tp.Camera(
        name="view", position=(0, -0.8, 1), direction=(0, 1, 0), field_of_view=field, pixels=(12, 9)
    )
    view = tp.simulate(tp.Scene([spot], [floor, mirror], [camera]), 20_000, seed=1, progress=False)["view"]
    radiance = view.radiance
    scored = radiance.value > 0
    doubts = [each.what for each in radiance.findings if each.name == "path class"]
    assert scored.sum() > 20 and (radiance.verdict[scored] == verdict).all()
    assert doubts == ["light via 'mirror' not sampled"] * (verdict == "doubtful")


def test_images_of_a_lamp_are_seen_where_a_ray_from_a_camera_comes_to_the_lamp():
    """Two mirrors at 60 degrees: rays are traced to the middle of each image."""
    turns = [(1.0, 0.0, 0.0), (0.5, math.sqrt(0.75), 0.0)]  # the mirrors, from the edge that they share
    normals = [(0.0, 1.0, 0.0), (math.sqrt(0.75), -0.5, 0.0)]
    walls = [
        tp.Rectangle(center=turn, normal=normal, up=(0, 0, 1), width=2, height=2)
        for turn, normal in zip(turns, normals, strict=True)
    ]
    spot = tp.Disk(center=(0.5 * math.sqrt(0.75), 0.25, 0), normal=(1, 0.5, 0), radius=0.01)
    surfaces = [tp.Surface(wall, tp.Mirror(1.0), name) for wall, name in zip(walls, "ab", strict=True)]
    meter = tp.Detector(tp.Disk(center=(0, 0, 9), radius=1), "m")
    scene = tp.Scene([tp.Source(spot, tp.Lambertian(power=1.0))], surfaces, [meter])
    images = outlines_of_images(scene, spot)
    assert len(images) == 6  # by a, b, ab, ba, aba, bab

    def comes_to_the_lamp(start, along):
        for _ in range(4):
            offset = np.array(spot.center) - start
            if np.linalg.norm(np.cross(offset, along)) < 1e-9 and offset @ along > 0:
                return True
            for turn, normal in zip(turns, normals, strict=True):
                if along @ normal < 0 and start @ normal > 1e-12:
                    hit = start - (start @ normal) / (along @ normal) * along
                    if 0 <= hit @ turn <= 2 and abs(hit[2]) <= 1:
                        start, along = hit, along - 2 * (along @ normal) * np.array(normal)
                        break
            else:
                return False
        return False

    found, rng = [], np.random.default_rng(3)
    for r, turn, z in rng.uniform((0.2, 0.05, -2), (4, 1.0, 2), (200, 3)):
        place = np.array([r * math.cos(turn), r * math.sin(turn), z])
        for outlines in images:
            end = outlines[-1].mean(axis=0)
            is_seen = comes_to_the_lamp(place, (end - place) / np.linalg.norm(end - place))
            alike = [each for each in images if np.allclose(each[-1].mean(axis=0), end)]  # by aba and bab
            found.append((is_seen, any(may_be_seen(each, tuple(place)) for each in alike)))
            looking, away = (
                tp.Camera(
                    name="c", position=tuple(place), direction=tuple(sign * (end - place)), pixels=(4, 4)
                )
                for sign in (1, -1)
            )
            assert looking.may_see_hull(outlines[-1]) and not away.may_see_hull(outlines[-1])
    seen, said = np.transpose(found)
    assert seen.sum() > 300 and said[seen].all() and (~said[~seen]).mean() > 0.8
