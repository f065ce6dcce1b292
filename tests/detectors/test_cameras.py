"""Cameras and environment maps: their geometry, their pictures, and that they agree with what forward histories tell."""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.refusals import assert_refused

CAMERA = tp.Camera(name="view", position=(0, 0, 0), direction=(1, 0, 0), field_of_view=1.0, pixels=(8, 6))


def run(scene, particles=1000, **how):
    return tp.simulate(scene, particles, progress=False, **how)


def lamp_at(center, radiance=3.0, radius=0.2):
    """A luminous ball."""
    return tp.Source(tp.Sphere(center=center, radius=radius), tp.Lambertian(radiance=radiance))


def test_pixels_fill_the_solid_angle_of_the_image():
    """Of a rectangle of half sides a, b at distance 1, 4 asin(a b / sqrt((1 + a^2)(1 + b^2)))."""
    a = math.tan(0.5)
    b = 0.75 * a
    exact = 4 * math.asin(a * b / math.sqrt((1 + a * a) * (1 + b * b)))
    assert CAMERA.solid_angles().sum() == pytest.approx(exact, rel=1e-13)
    whole = tp.EnvironmentMap(name="map", position=(0, 0, 0)).solid_angles().sum()
    assert whole == pytest.approx(4 * math.pi)


def test_image_is_upright_and_not_mirrored():
    """Looking along +x with +z up, +y is on the left."""
    result = run(tp.Scene(lamp_at((4, 1.2, 0.9)), (), CAMERA), 50_000)
    row, column = np.unravel_index(np.argmax(result["view"].image()), (6, 8))
    assert row < 3 and column < 4


@pytest.mark.parametrize("kind", ["lamp in fog", "fog that glows"])
@pytest.mark.parametrize("distance", [0.0, 1.0, 2.5])
def test_a_glow_behind_fog_is_as_bright_as_what_fades_on_the_way_leaves(kind, distance):
    """Along one ray: (1 - exp(-depth)) / absorption of the glow, times exp(-tau) of the fog before it."""
    thick, before, within = 1.5, 0.6, 1.3  # m and m^-1
    box = tp.Box(center=(distance + thick / 2, 0, 0), size=(thick, 1.0, 2.0))
    eye = tp.Camera(name="eye", position=(-1e-9, 0, 0), look_at=(1, 0, 0), pixels=(2, 1), field_of_view=1e-6)
    if kind == "lamp in fog":
        lit = {"sources": tp.Source(box, tp.Isotropic(power=4 * math.pi * box.volume)), "surfaces": ()}
        within = before
    else:
        glow = tp.Medium(absorption=within, emission=1.0)
        lit = {"sources": (), "surfaces": tp.Surface(box, tp.Transparent(), "body", inside=glow)}
    scene = tp.Scene(**lit, detectors=eye, medium=tp.Medium(absorption=before))
    radiance = run(scene, seed=1)["eye"].radiance
    exact = math.exp(-before * distance) * -math.expm1(-within * thick) / within
    np.testing.assert_allclose(radiance.value, exact, rtol=1e-8)


def test_map_tells_where_light_comes_from():
    view = tp.EnvironmentMap(name="map", position=(0, 0, 0), theta=4, phi=4)
    radiance = run(tp.Scene(lamp_at((0, 2, 2)), (), view), 50_000)["map"].radiance
    assert radiance.dims == ("theta", "phi")
    lit = set(map(tuple, np.argwhere(radiance.value > 0).tolist()))
    assert lit == {(0, 0), (0, 1), (1, 0), (1, 1)}  # on the edge at 45 and at 90 degrees


def test_pixels_on_a_lamp_show_its_radiance_and_shares_of_it_at_its_edge():
    """The flux through the image is L times the solid angle of the ball, 2 pi (1 - cos)."""
    radiance = run(tp.Scene(lamp_at((4, 0, 0), radius=1.0), (), CAMERA), 200_000)["view"].radiance
    assert_agrees(radiance[2, 3], 3.0)
    whole = (radiance * CAMERA.solid_angles()).sum()
    assert_agrees(whole, 3.0 * 2 * math.pi * (1 - math.sqrt(15) / 4))


def occluded(extra):
    """A room's corner with a lamp, and something in the way."""
    floor = tp.Surface(tp.Rectangle(center=(0, 0, -1), width=6, height=6), tp.Diffuse(0.6))
    block = tp.Surface(tp.Sphere(center=(0.4, 0.3, 0.8), radius=0.4), tp.Diffuse(0.3))
    lamp = tp.Source(tp.Disk(center=(0.5, 0, 2), normal=(0, 0, -1), radius=0.8), tp.Lambertian(radiance=5.0))
    return tp.Scene([lamp], [floor, block], [extra])


def foggy(extra):
    """A lamp in a fog that fills a box."""
    fog = tp.Medium(absorption=0.3, scattering=1.2, phase=tp.HenyeyGreenstein(0.4))
    body = tp.Surface(tp.Box(size=(3, 3, 3)), tp.Transparent(), inside=fog)
    lamp = tp.Source(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.5), tp.Lambertian(radiance=5.0))
    return tp.Scene([lamp], [body], [extra])


@pytest.mark.parametrize("scene", [occluded, foggy])
def test_fluence_rate_is_the_same_seen_from_the_lamp_and_from_the_point(scene):
    """Next-event estimation forwards, and a map and a point backwards."""
    place = (0.1, -0.2, 0.1)
    point, view = tp.PointDetector(place, "here"), tp.EnvironmentMap(name="here", position=place)
    ways = [(point, {"seed": 1}), (point, {"seed": 2, "estimator": "backward"}), (view, {"seed": 3})]
    there, back, seen = (run(scene(each), 300_000, **how)["here"].fluence_rate for each, how in ways)
    assert_agrees(there - back, 0)
    assert_agrees(there - seen, 0)
    assert seen.relative_error < 0.02


def test_cameras_alone_run_backwards_by_themselves_and_forward_histories_are_refused():
    assert run(occluded(CAMERA)).plan.method.estimator == "backward"
    words = "only backward histories reach Camera 'view'; write estimator='backward'"
    assert_refused(lambda: run(occluded(CAMERA), estimator="analog"), words)


def test_cameras_and_meters_go_together_backwards():
    meter = tp.Detector(tp.Disk(center=(0, 0, -0.5), radius=0.3), name="meter")
    scene = tp.Scene(lamp_at((2, 0, 0.5)), (), [CAMERA, meter])
    assert_refused(lambda: run(scene, estimator="analog"), "estimator='backward'")
    result = run(scene, 100_000)
    assert "camera 'view'" in result.report() and result["meter"].irradiance.value > 0


def test_a_run_stops_at_the_error_of_a_map():
    scene = occluded(tp.EnvironmentMap(name="map", position=(0, 0, 0), theta=2, phi=2))
    result = tp.simulate(scene, error={"map.fluence_rate": 0.05}, progress=False)
    assert result["map"].fluence_rate.relative_error <= 0.05
