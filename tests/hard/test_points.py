"""Point detectors where it is hard: far and tiny, deep behind shields, in many bodies, in meshes, close to what sends.

False alarms 1e-6 each, fixed seeds; what does not depend on chance to rounding.
"""

from __future__ import annotations

import hashlib
import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from transport.physics.sight import sample_detour, sample_equiangular, sample_equiangular_beyond
from transport.theory import point_source

T, M = tp.Transparent(), tp.Medium


def lamp(position=(0, 0, 0), power=2.0):
    return tp.Source(tp.Point(position=position), tp.Isotropic(power=power))


def filled(shape, medium):
    return tp.Surface(shape, T, inside=medium)


def seen(sources, places, surfaces=(), particles=1000, seed=1, **options):
    points = [tp.PointDetector(place, f"p{k}") for k, place in enumerate(places)]
    scene = tp.Scene(sources, surfaces, points, **options)
    result = tp.simulate(scene, particles=particles, seed=seed, threads=1, progress=False)
    return [result[point.name].fluence_rate for point in points]


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e12])
def test_the_unit_of_length_does_not_matter(unit):
    """A fog, a box in it and a wall in nanometres and in thousands of kilometres give the same digits."""

    def run(unit):
        surfaces = [
            filled(
                tp.Box(center=(0, 0, 1.5 * unit), size=unit),
                M(0.3 / unit, 2 / unit, tp.HenyeyGreenstein(0.5)),
            ),
            tp.Surface(tp.Plane(center=(0, 0, -unit)), tp.Diffuse(0.7)),
        ]
        fog = M(0.2 / unit, 0.8 / unit)
        found = seen(lamp(), [(0.3 * unit, 0, 0.2 * unit), (0, 0.2 * unit, 1.4 * unit)], surfaces, medium=fog)
        return [estimate.value * unit**2 for estimate in found]

    assert run(unit) == pytest.approx(run(1.0), rel=1e-9)


def test_a_scene_far_from_the_origin_is_as_good_as_near_it():
    """A thousand kilometres away coordinates have steps of 1e-10 m."""
    far = np.array([1e6, -2e6, 3e6])
    box = filled(tp.Box(center=tuple(far), size=2.0), M(0.5))
    place = far + (3.0, 4.0, 0.0)
    (found,) = seen(lamp(tuple(far)), [tuple(place)], [box])
    assert found.value == pytest.approx(2 * math.exp(-0.5 * 1.25) / (100 * math.pi), rel=1e-9)


@pytest.mark.parametrize("depth", [1.0, 30.0, 300.0, 690.0])
def test_behind_a_shield_of_any_depth_no_digit_is_lost(depth):
    shield = filled(tp.Slab(center=(0, 0, 2), thickness=1.0), M(depth))
    straight, slanting = seen(lamp(), [(0, 0, 4), (3, 0, 4)], [shield])
    assert straight.value == pytest.approx(2 * math.exp(-depth) / (64 * math.pi), rel=1e-10)
    if depth < 500:
        assert slanting.value == pytest.approx(2 * math.exp(-1.25 * depth) / (100 * math.pi), rel=1e-10)


def test_through_sixty_shells_of_media_in_one_another():
    sigmas = np.linspace(0.1, 2.0, 60)
    radii = np.linspace(1.0, 60.0, 60)
    surfaces = [filled(tp.Sphere(radius=float(r)), M(float(s))) for r, s in zip(radii, sigmas, strict=True)]
    place = np.array([0.6, 0.0, 0.8]) * 61
    (found,) = seen(lamp(), [tuple(place)], surfaces, particles=100)
    exact = 2 * math.exp(-sigmas.sum()) / (4 * math.pi * 61**2)
    assert found.value == pytest.approx(exact, rel=1e-12)


def test_bodies_that_touch_are_entered_where_the_others_are_left():
    """Slabs on one another, of which neighbours share a plane; a ray along an axis and a slanting one."""
    sigmas, surfaces = (0.3, 1.1, 0.0, 0.7, 2.0), []
    for k, sigma in enumerate(sigmas):
        surfaces.append(
            filled(tp.Box(center=(0, 0, k + 0.5), size=(50, 50, 1)), M(sigma) if sigma else tp.Vacuum())
        )
    found = seen(lamp((0, 0, -1)), [(0, 0, 6), (3, 0, 3), (0, 1, 4.5)], surfaces)
    depths = [4.1, 1.4 * math.hypot(3, 4) / 4, 3.1 * math.hypot(1, 5.5) / 5.5]
    for estimate, distance, depth in zip(found, (7, 5, math.hypot(1, 5.5)), depths, strict=True):
        assert estimate.value == pytest.approx(2 * math.exp(-depth) / (4 * math.pi * distance**2), rel=1e-12)


def test_a_mesh_hides_and_a_hollow_mesh_dims_twice():
    """Cubes of twelve triangles: the ways through them are those through boxes, along edges and diagonals too."""

    def cube(size, inward=False):
        box = tp.Box(size=size)
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * size / 2
        faces = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6)]
        faces += [(0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
        return tp.Mesh(vertices=corners, faces=faces), box

    outer, inner = cube(2.0), cube(1.0)
    places = [(3, 0.1, 0.2), (3, 0, 0), (2, 2, 2), (3, 0.3, -0.4)]
    meshes = seen(lamp((-3, 0, 0)), places, [filled(outer[0], M(0.6)), filled(inner[0], M(0.1))])
    boxes = seen(lamp((-3, 0, 0)), places, [filled(outer[1], M(0.6)), filled(inner[1], M(0.1))])
    for one, other in zip(meshes, boxes, strict=True):
        assert one.value == pytest.approx(other.value, rel=1e-9)
    black = tp.Surface(inner[0], tp.Black())
    hidden, clear = seen(lamp((-3, 0, 0)), [(3, 0.1, 0.2), (3, 0, 4)], [black])
    assert hidden.value == 0
    assert clear.value == pytest.approx(2 / (4 * math.pi * 52), rel=1e-12)


def test_close_to_a_point_source_in_fog():
    """Down to a millionth of a mean free path phi is that of the source, and what is scattered adds what it adds."""
    fog = M(0.1, 0.9)
    distances = [1e-6, 1e-3, 0.01]
    found = seen(lamp(), [(r, 0, 0) for r in distances], medium=fog, particles=200_000)
    for estimate, r in zip(found, distances, strict=True):
        assert_agrees(estimate, 2 * point_source.fluence_rate(r, 1.0, 0.9), 1e-6)


def test_close_to_a_black_wall_and_in_a_narrow_slit():
    walls = [tp.Surface(tp.Plane(center=(0, 0, z)), tp.Black()) for z in (-1e-7, 1e-7)]
    on_axis, behind = seen(lamp((0, 0, 0)), [(1, 0, 0), (1, 0, 1)], walls)
    assert on_axis.value == pytest.approx(2 / (4 * math.pi), rel=1e-12)
    assert behind.value == 0
    near = seen(
        lamp((0, 0, 1)), [(0.3, 0.4, 1e-13), (0.3, 0.4, -1e-13)], [tp.Surface(tp.Plane(), tp.Black())]
    )
    assert near[0].value == pytest.approx(2 / (4 * math.pi * 1.25), rel=1e-9)
    assert near[1].value == 0


def test_a_scatterer_that_is_far_and_small_is_seen():
    """A thin ball a thousand times as far as it is large, in a pencil beam: sigma p times its chord over r^2."""
    ball = filled(tp.Sphere(center=(0, 0, 1), radius=0.001), M(scattering=1e-6))
    pencil = tp.Source(tp.Point(position=(0, 0, 0)), tp.Beam((0, 0, 1), power=1.0))
    (found,) = seen(pencil, [(1, 0, 1)], [ball], particles=10_000)
    assert found.value == pytest.approx(1e-6 * 0.002 / (4 * math.pi), rel=1e-5)


def test_a_point_in_a_grid_of_one_thick_voxel_among_thin_ones():
    """A furnace: whatever scatters in it, light is the same everywhere; the point in the thick voxel, and beside it."""
    voxels = np.full((5, 5, 5), 0.01)
    voxels[2, 2, 2] = 30.0
    grid = tp.Grid(box=tp.Box(size=1.0), scattering=voxels)
    wall = tp.Surface(tp.Sphere(radius=1.0), tp.Diffuse(0.5), "wall", inside=tp.Vacuum())
    source = tp.Source("wall", tp.Lambertian(exitance=0.5 * math.pi), side="back")
    found = seen(
        source, [(0.02, 0.01, 0.03), (0.3, 0, 0)], [wall, filled(grid.box, grid)], particles=300_000, seed=3
    )
    for estimate in found:
        assert_agrees(estimate, 4 * math.pi, 1e-6)


@pytest.mark.parametrize("least", [0.0, 1e-300, 1e-30, 1e-9, 1.0, 1e9])
def test_places_on_a_line_are_numbers_for_any_line_and_any_draw(least):
    sample, beyond = (
        getattr(each, "py_func", each) for each in (sample_equiangular, sample_equiangular_beyond)
    )
    for start, end in ((-1.0, 1.0), (1e-8, 1.0), (-1.0, -1e-8), (1.0, 1.0 + 1e-12), (-1e9, 1e9)):
        for u in (0.0, 1e-16, 0.5, 1 - 1e-16):
            place, inverse = sample(least, start, end, u)
            assert start <= place <= end and 0 < inverse < math.inf
        if (
            start > 0 or end < 0
        ) and least < 1e-9:  # seen under an angle that is its length over the distances
            assert inverse == pytest.approx((end - start) / (start * end), rel=1e-9)
        for u in (0.0, 1e-16, 0.5, 1 - 1e-15):
            way, inverse = beyond(least, start, u)
            assert 0 <= way < math.inf and 0 < inverse < math.inf


def test_detours_follow_their_law():
    """1/(a^2 b^2) r/pi^3: the share of detours within a ball about the start, by quadrature in bipolar angles."""
    random = np.random.default_rng(8)
    sample = getattr(sample_detour, "py_func", sample_detour)
    draws = np.array([sample(2.0, u, v) for u, v in random.random((20_000, 2))])
    mu, sine, leg = draws.T
    assert np.abs(mu**2 + sine**2 - 1).max() < 1e-14 and (leg >= 0).all()
    other = np.sqrt(leg**2 + 4 - 4 * leg * mu)
    # The map that exchanges both ends keeps the density: so both legs are alike in law.
    for reach in (0.5, 1.0, 2.0, 5.0):
        near, far = (np.mean(way < reach) for way in (leg, other))
        assert abs(near - far) < 5 * math.sqrt(2 * 0.25 / len(leg))
    # Within a ball of radius R about the start the share is 2/pi^2 times the integral of ln|(R+r)/(R-r)|/(2 rho) d rho.
    for reach in (0.5, 1.5, 4.0):
        steps = (np.arange(200_000) + 0.5) / 200_000 * reach / 2
        share = (
            2 / math.pi**2 * np.sum(np.log(np.abs((1 + steps) / (1 - steps))) / steps) * (steps[1] - steps[0])
        )
        assert abs(np.mean(leg < reach) - share) < 5 * math.sqrt(0.25 / len(leg)), (reach, share)


def digest() -> str:
    """Of what points count in fog, beside a wall and within a glowing ball."""
    box = tp.Surface(tp.Box(size=2.0), tp.Transparent(), inside=tp.Medium(0.2, 1.0, tp.HenyeyGreenstein(0.3)))
    ball = tp.Surface(tp.Sphere(radius=0.3), tp.Transparent(), inside=tp.Medium(0.1, 3.0, tp.Rayleigh()))
    wall = tp.Surface(tp.Plane(center=(0, 0, -2)), tp.Diffuse(0.5))
    places = [(0.6, 0.1, 0.2), (0.1, 0.0, 0.1), (0, 0, 2), (3, 0, 0)]
    points = [tp.PointDetector(place, f"p{k}") for k, place in enumerate(places)]
    lamp = tp.Source(tp.Point(position=(0, 0, 1.5)), tp.Isotropic(power=1.0))
    glow = tp.Source(tp.Sphere(center=(3, 0, 0), radius=0.5), tp.Isotropic(power=1.0))
    scene = tp.Scene([lamp, glow], [box, ball, wall], points)
    result = tp.simulate(scene, particles=3000, seed=7, batches=3, threads=1, progress=False)
    counted = np.array([result[point.name].batch_values for point in points])
    return hashlib.sha256(counted.tobytes()).hexdigest()
