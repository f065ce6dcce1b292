"""Shadow rays by way of a flat mirror: they go to the image of a detector, are reflected once, and share light with flights."""

from __future__ import annotations

import numpy as np
import pytest

import transport as tp
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


def room(floor: tp.Material, source: tp.Source, meter: tp.Shape, medium: tp.Medium | None) -> tp.Scene:
    """A room with diffuse walls, and a floor of another material."""
    faces = tp.Box(center=(0, 0, 1.25), size=(4, 5, 2.5)).faces().items()
    walls = [tp.Surface(face, floor if name == "-z" else tp.Diffuse(0.5), name) for name, face in faces]
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


def flat(material: tp.Material, x: float = 2.0) -> tp.Surface:
    return tp.Surface(
        tp.Rectangle(center=(x, 0, 0), normal=(1, 0, 0), width=1, height=1), material, f"panel {round(x)}"
    )


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
def test_one_flat_mirror_is_connected(surfaces):
    assert links_of(*surfaces)
    assert not links_of(*surfaces, estimator="analog")


@pytest.mark.parametrize(
    "surfaces",
    [
        (),
        (flat(tp.Diffuse(0.5)),),
        (flat(tp.Mirror(0.5)), flat(tp.Mirror(0.5), 3.0)),
        (flat(tp.Mirror(0.5)), tp.Surface(BALL, tp.Dielectric(1.5), "glass")),
        (tp.Surface(BALL, tp.Mirror(0.5), "ball"),),
        (flat(tp.Glossy(0.2, 0.9)),),
        (flat(tp.Conductor(0.2, 3.4)),),
    ],
    ids=["nothing", "a wall", "two mirrors", "glass too", "a curved mirror", "gloss", "a metal"],
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
