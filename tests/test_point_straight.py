"""Point detectors against exact fluence rates: straight from lamps, glowing bodies and walls, through media.

What does not depend on chance is asked to 1e-12; the rest with 1e-6 false alarms each and fixed seeds.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import dblquad

import transport as tp
from tests.agreement import assert_agrees, smallest_bias
from tests.point_scenes import LAMP, M, V, assert_is, filled, seen, straight

# ---- straight from where light is born ----


@pytest.mark.parametrize("unit", [1.0, 1e-6, 1.5e11])
def test_a_point_source_in_vacuum_falls_with_the_square_of_the_distance(unit):
    lamp = tp.Source(tp.Point(position=(unit, 0, 0)), tp.Isotropic(power=2.0))
    *found, result = seen(lamp, [(4 * unit, 4 * unit, 0), (-9 * unit, 0, 0), (unit, 0, 0.01 * unit)])
    for estimate, distance in zip(found, (5.0, 10.0, 0.01), strict=True):
        assert_is(estimate, straight(distance * unit))
        assert str(estimate.unit) == "W m^-2"
    assert result["p0"].counts.value == 1000
    assert not result.warnings


def test_an_absorber_dims_by_its_optical_depth():
    for tracking in ("weighted", "analog"):
        near, far, _ = seen(LAMP, [(0, 0.5, 0), (3, 0, 4)], medium=M(absorption=0.7), tracking=tracking)
        assert_is(near, straight(0.5, 0.35))
        assert_is(far, straight(5.0, 3.5))


def test_nested_boxes_a_ball_and_a_void_dim_each_by_its_own_way():
    surfaces = [
        filled(tp.Box(size=2.0), M(0.7)),
        filled(tp.Box(size=1.0), M(0.2)),
        filled(tp.Box(center=(3, 0, 0), size=2.0), V),
        filled(tp.Sphere(center=(3, 0, 0), radius=0.5), M(1.3)),
    ]
    places = [(5, 0, 0), (0.8, 0.1, 0), (0, 0, 0.3), (2.5, 0.25, 0), (3, 0, 0.2)]
    *found, _ = seen(LAMP, places, surfaces, medium=M(0.1))
    ways = [
        [(0.2, 0.5), (0.7, 0.5), (0.1, 1.0), (1.3, 1.0), (0.1, 1.0)],
        [(0.2, 0.5), (0.7, 0.3)],
        [(0.2, 0.0)],
        [(0.2, 0.5), (0.7, 0.5), (0.1, 1.0)],
        [(0.2, 0.5), (0.7, 0.5), (0.1, 1.0)],
    ]
    for k, (estimate, place, way) in enumerate(zip(found, places, ways, strict=True)):
        distance = math.hypot(*place)
        slope = place[0] / distance or 1.0
        depth = sum(sigma * length / slope for sigma, length in way)
        if k == 2:
            depth = 0.2 * 0.3
        if k in (3, 4):
            depth += 1.3 * way_in_ball(place)
        assert_is(estimate, straight(distance, depth))


def way_in_ball(place, center=3.0, radius=0.5):
    """Length in the ball of the straight way from the origin to a place in it."""
    distance = math.hypot(*place)
    foot = center * place[0] / distance
    entry = foot - math.sqrt(radius**2 - (center**2 - foot**2))
    return max(0.0, distance - entry)


def test_a_mesh_that_is_filled_dims_what_passes_through_it():
    ball = tp.Mesh.sphere(radius=1.0, triangles=320)
    (found, _) = seen(LAMP, [(2.0, 0.3, 0.1)], [filled(ball, M(0.8))])
    box, _ = seen(LAMP, [(2.0, 0.3, 0.1)], [filled(tp.Sphere(radius=1.0), M(0.8))])
    assert found.value == pytest.approx(box.value, rel=0.03)
    assert box.value < found.value < straight(math.hypot(2.0, 0.3, 0.1))


def test_a_grid_dims_voxel_by_voxel():
    absorption = np.array([0.1, 0.9, 0.3, 1.7]).reshape(4, 1, 1)
    grid = tp.Grid(box=tp.Box(center=(2, 0, 0), size=2.0), absorption=absorption)
    beyond, within, _ = seen(LAMP, [(4, 0, 0), (2.25, 0, 0)], [filled(grid.box, grid)])
    assert_is(beyond, straight(4.0, 0.5 * 3.0))
    assert_is(within, straight(2.25, 0.5 * 1.0 + 0.25 * 0.3))


def test_a_diffuse_disk_is_seen_by_its_solid_angle():
    """phi = L Omega, from its front only."""
    disk = tp.Disk(radius=1.0)
    lamp = tp.Source(disk, tp.Lambertian(radiance=3.0))
    above, beside, behind, _ = seen(lamp, [(0, 0, 1.5), (0.7, 0, 0.6), (0, 0, -1)], particles=400_000)
    assert_agrees(above, 6 * math.pi * (1 - 1.5 / math.hypot(1.5, 1)), 1e-6)
    assert_agrees(beside, 3 * tp.solid_angle(disk, (0.7, 0, 0.6)).value, 1e-6)
    assert behind.value == 0
    assert smallest_bias(above) < 0.003


@pytest.mark.parametrize("kind", ["ball", "mesh", "triangle", "back"])
def test_other_diffuse_emitters_are_seen_by_their_solid_angles(kind):
    place, side = (0.3, 0.2, 2.5), "front"
    shape = {
        "ball": tp.Sphere(radius=1.0),
        "mesh": tp.Mesh.sphere(radius=1.0, triangles=80),
        "triangle": tp.Triangle(vertices=[(0, 0, 0), (2, 0, 0), (0, 1, 0)]),
        "back": tp.Rectangle(width=2, height=1, normal=(0, 0, -1)),
    }[kind]
    exact = 2 * math.pi * (1 - math.sqrt(1 - 1 / math.hypot(*place) ** 2))
    if kind != "ball":
        exact = tp.solid_angle(shape, place).value
    if kind == "back":
        side = "back"
    lamp = tp.Source(shape, tp.Lambertian(radiance=1.0), side=side)
    found, _ = seen(lamp, [place], particles=200_000)
    assert_agrees(found, exact, 1e-6)


def glow_of_ball(distance):
    """Of a ball of radius 1 that emits 1 W m^-3 sr^-1: the integral of 1/r^2 over it."""
    if distance == 0:
        return 4 * math.pi
    ratio = abs((1 + distance) / (1 - distance))
    return 2 * math.pi * (1 + (1 - distance**2) / (2 * distance) * math.log(ratio))


def test_a_glowing_ball_is_seen_from_inside_from_close_by_and_from_afar():
    lamp = tp.Source(tp.Sphere(radius=1.0), tp.Isotropic(power=16 * math.pi**2 / 3))
    distances = [0.0, 0.7, 1.0, 1.2, 1.6, 3.0]
    *found, _ = seen(lamp, [(0, 0.6 * d, 0.8 * d) for d in distances], particles=300_000)
    assert found[0].value == pytest.approx(glow_of_ball(0.0), rel=1e-12)  # all chords are alike
    for estimate, distance in zip(found[1:], distances[1:], strict=True):
        exact = glow_of_ball(distance) if distance != 1.0 else 2 * math.pi
        assert_agrees(estimate, exact, 1e-6)


def glow_of_box(size, place):
    """The integral of 1/r^2 over a box about the origin that emits 1 W m^-3 sr^-1, as cones on its faces.

    A face at the height h adds the integral of h/r^2 over it, with h < 0 where the place is beyond its plane.
    """
    total = 0.0
    for axis in range(3):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        for sign in (-1, 1):
            h = size[axis] / 2 - sign * place[axis]
            ends = [(-size[k] / 2 - place[k], size[k] / 2 - place[k]) for k in (i, j)]
            total += h * dblquad(lambda u, v, h=h: 1 / (h * h + u * u + v * v), *ends[0], *ends[1])[0]
    return total


def test_a_glowing_box_is_seen_from_inside_from_close_by_and_from_afar():
    """From within, from both sides of each axis, and from so far that it is treated as any other lamp."""
    size = (1.0, 2.0, 0.5)
    lamp = tp.Source(tp.Box(size=size), tp.Isotropic(power=4 * math.pi * math.prod(size)))
    places = [
        (0, 0, 0),
        (0.3, -0.8, 0.1),
        (0.7, 0, 0),
        (-0.7, 0, 0),
        (0.2, 1.2, 0),
        (0.2, -1.2, 0),
        (0, 0, 0.4),
    ]
    places += [(0, 0, -0.4), (2.0, 3.0, 1.0)]
    *found, _ = seen(lamp, places, particles=400_000)
    for estimate, place in zip(found, places, strict=True):
        assert_agrees(estimate, glow_of_box(size, place), 1e-6)
        assert smallest_bias(estimate) < 0.05


def test_a_glowing_box_that_absorbs_is_seen_as_thick_as_it_is():
    """Within a thick glowing medium phi is 4 pi emission / absorption, half of that on its face."""
    box = tp.Box(size=2.0)
    medium = M(absorption=40.0, emission=5.0)
    within, face, beside, _ = seen(
        (), [(0, 0.1, 0.2), (0, 0, 1.0), (0.3, 0, 0)], [filled(box, medium)], particles=200_000
    )
    assert_agrees(within, 4 * math.pi * 5 / 40, 1e-6)
    assert_agrees(beside, 4 * math.pi * 5 / 40, 1e-6)
    assert_agrees(face, 2 * math.pi * 5 / 40, 1e-6)


# ---- walls ----


def test_a_black_disk_stands_in_the_way():
    disk = tp.Source(tp.Disk(radius=1.0), tp.Lambertian(radiance=1.0))
    moon = tp.Surface(tp.Disk(center=(0, 0, 0.75), radius=0.25), tp.Black())
    found, _ = seen(disk, [(0, 0, 1.5)], [moon], particles=400_000)
    assert_agrees(found, 2 * math.pi * (1.5 / math.hypot(1.5, 0.5) - 1.5 / math.hypot(1.5, 1)), 1e-6)
    hidden, beside, _ = seen(LAMP, [(0, 0, 1), (0.5, 0, 1)], [moon])
    assert hidden.value == 0
    assert_is(beside, straight(math.hypot(0.5, 1)))


def test_a_lit_spot_on_a_diffuse_wall_sends_by_the_cosine_law():
    """A pencil of light: phi = share P cos / (pi r^2), of what is reflected or let through."""
    pencil = tp.Source(tp.Point(position=(0, 0, 2)), tp.Beam((0, 0, -1), power=3.0))
    places = [(0, 1.2, 1.6), (0, -0.6, -0.8), (0.4, 0, 0.1)]
    wall = tp.Surface(tp.Disk(radius=1.0), tp.Diffuse(0.6))
    above, behind, low, _ = seen(pencil, places, [wall])
    assert above.value == pytest.approx(0.6 * 3 * 0.8 / (math.pi * 4), rel=1e-12)
    assert low.value == pytest.approx(0.6 * 3 * 0.1 / math.hypot(0.4, 0.1) / (math.pi * 0.17), rel=1e-12)
    assert behind.value == 0
    veil = tp.Surface(tp.Disk(radius=1.0), tp.Diffuse(0.5, transmission=0.3))
    above, behind, _, _ = seen(pencil, places, [veil], particles=100_000)
    assert_agrees(above, 0.5 * 3 * 0.8 / (math.pi * 4), 1e-6)
    assert_agrees(behind, 0.3 * 3 * 0.8 / math.pi, 1e-6)


def test_in_a_diffuse_ball_the_walls_radiosity_adds_up():
    """The wall has B = albedo E / (1 - albedo) of the direct E: phi = direct + 4 B inside."""
    wall = tp.Surface(tp.Sphere(radius=1.0), tp.Diffuse(0.6))
    places = [(0.3, 0.2, 0.1), (0.8, 0, 0)]
    *found, _ = seen(LAMP, places, [wall], particles=200_000)
    for estimate, place in zip(found, places, strict=True):
        assert_agrees(estimate, straight(math.hypot(*place)) + 4 * 1.5 * 2 / (4 * math.pi), 1e-6)
