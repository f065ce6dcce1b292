"""Points very near to what sends diffusely: a run that misses it says so; where it is silent the figure is right.

False alarms 1e-6 each, fixed seeds.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.point_scenes import LAMP, M, filled, seen
from tests.slow import quick

ROOM = tp.Surface(tp.Box(size=4.0), tp.Diffuse(0.8), "room")


def near_findings(result, name="p0"):
    """What a result reports of one point and what is near it."""
    doubts = (each for each in result[name].fluence_rate.findings if each.severity == "doubtful")
    return [str(each) for each in doubts if "histories are expected" in each.what]


def test_near_a_diffuse_wall_half_is_missing_and_a_finding_reports_it():
    """At a two-millionth of a room's width no history reflects so near: 0.1 instead of 0.2, and a claimed error of 0.2 %."""
    heights = (1.999999, 1.9999, 1.9, 1.0, 0.2)
    *found, result = seen(LAMP, [(0.3, 0, z) for z in heights], [ROOM], particles=200_000)
    assert found[0].value < 0.6 * found[2].value and found[0].relative_error < 0.01  # wrong, and sure of it
    for name, height in (("p0", "1e-06"), ("p1", "0.0001")):
        (warning,) = near_findings(result, name)
        for words in (
            f"light of Surface 'room', {height} m away, not sampled",
            "Move the point to at least 0.0",
            "VolumeDetector",
        ):
            assert words in warning
    assert not any(near_findings(result, f"p{k}") for k in (2, 3, 4))
    assert "light of Surface 'room', 1e-06 m away" in result.report()


@pytest.mark.parametrize("unit", [1e-9, 1e9])
def test_the_unit_of_length_does_not_matter(unit):
    room = tp.Surface(tp.Box(size=4.0 * unit), tp.Diffuse(0.8), "room")
    places = [(0.3 * unit, 0, z * unit) for z in (1.9999, 1.0)]
    *_, result = seen(LAMP, places, [room], particles=10_000)
    assert near_findings(result, "p0") and not near_findings(result, "p1")


WALLS = {
    "plane": (tp.Plane(center=(0, 0, -1)), (0.5, 0, -1 + 1e-4)),
    "ball": (tp.Sphere(radius=1.0), (0.6 - 6e-5, 0, 0.8 - 8e-5)),
    "facets": (tp.Mesh.sphere(radius=1.0, triangles=1280), None),
    "tube": (tp.Cylinder(radius=1.0, height=8.0), (0, 1 - 1e-4, 0.5)),
}


@pytest.mark.parametrize("name", quick(WALLS, *(name for name in WALLS if name != "facets")))
def test_walls_of_any_shape_are_reported(name):
    shape, near = WALLS[name]
    if near is None:
        near = tuple(shape.vertices[shape.faces[100]].mean(axis=0) * (1 - 1e-4))
    veil = tp.Surface(shape, tp.Diffuse(0.5, transmission=0.4), "veil")
    *_, result = seen(LAMP, [near, (0.3, 0.1, 0)], [veil], particles=20_000)
    (warning,) = near_findings(result)
    assert "light of Surface 'veil'" in warning and not near_findings(result, "p1")


def test_near_a_diffuse_emitter_the_number_of_births_is_known():
    """1e-5 above a disk 1e-10 of all births lie so near; behind it, and beside it in its plane, nothing is missing."""
    lamp = tp.Source(tp.Disk(radius=1.0), tp.Lambertian(radiance=1.0))
    places = [(0.1, 0, 1e-5), (0.1, 0, -1e-5), (1 + 1e-5, 0, 0), (0.1, 0, 0.1)]
    above, *_, far, result = seen(lamp, places, particles=50_000)
    weak = tp.Source(tp.Point(position=(0.5, 0, -1)), tp.Isotropic(power=1.0))
    *_, lit = seen([lamp, weak], places, particles=50_000)
    assert near_findings(lit) and not any(near_findings(lit, f"p{k}") for k in (1, 2, 3))
    (warning,) = near_findings(result)
    assert "sources[0], 1e-05 m away, not sampled: only about 5e-06 histories" in warning
    assert above.value < 0.5 * 2 * math.pi
    assert_agrees(far, tp.solid_angle(tp.Disk(radius=1.0), places[3]).value, 1e-6)
    assert not any(near_findings(result, f"p{k}") for k in (1, 2, 3))
    wall = tp.Surface(tp.Disk(radius=1.0), tp.Black(), "wall")
    lamp = tp.Source("wall", tp.Lambertian(radiance=1.0), side="back")
    *_, result = seen(lamp, [(0.1, 0, -1e-5), (0.1, 0, 1e-5)], [wall], particles=50_000)
    assert "the source on 'wall'" in near_findings(result)[0] and not near_findings(result, "p1")


@pytest.mark.slow
def test_a_thick_medium_is_as_a_diffuse_wall_as_rough_as_its_mean_free_path():
    """0.1 mm above milk of mean free paths of a third of a millimetre 2/3 are missing; and in it, deep down."""
    milk = filled(tp.Slab(center=(0, 0, -1.005), thickness=0.01), M(absorption=5.0, scattering=3e3))
    near, far, _, result = seen(
        LAMP, [(0.5, 0, -0.9999), (0.5, 0, -0.8), (0.5, 0, -1.001)], [milk], particles=40_000
    )
    assert near.value < 0.6 * far.value
    assert "the scattering medium inside surfaces[0], 0.000333 m away" in near_findings(result)[0]
    assert "scattered nearby in the scattering medium inside surfaces[0]" in near_findings(result, "p2")[0]
    assert not near_findings(result, "p1")
    void = [filled(tp.Sphere(radius=1.0), tp.Vacuum())]
    *_, result = seen(LAMP, [(0, 0, 0.9999), (0, 0.2, 0)], void, particles=4000, medium=M(5.0, 300.0))
    assert "the scattering medium beyond surfaces[0]" in near_findings(result)[0] and not near_findings(
        result, "p1"
    )


@pytest.mark.slow
def test_where_nothing_is_reported_the_value_is_right():
    """In a diffuse ball phi is known: z over 40 runs at distances down to where all of them warn, and are wrong."""
    wall = tp.Surface(tp.Sphere(radius=1.0), tp.Diffuse(0.6))
    distances = (0.3, 0.1, 0.07, 0.06, 1e-3, 1e-5)
    places = [(0.6 * (1 - d), 0, 0.8 * (1 - d)) for d in distances]
    exact = [2 / (4 * math.pi * (1 - d) ** 2) + 4 * 1.5 * 2 / (4 * math.pi) for d in distances]
    z = np.full((40, len(distances)), np.nan)
    all_z = z.copy()
    for seed in range(len(z)):
        *found, result = seen(LAMP, places, [wall], particles=20_000, seed=seed)
        for k, (estimate, value) in enumerate(zip(found, exact, strict=True)):
            all_z[seed, k] = estimate.z(value)
            if not near_findings(result, f"p{k}"):
                z[seed, k] = all_z[seed, k]
    silent = np.isfinite(z).sum(axis=0)
    assert (silent[:2] == len(z)).all() and silent[3] > 0 and (silent[4:] == 0).all(), silent
    for k in range(4):
        judged = z[np.isfinite(z[:, k]), k]
        assert abs(judged.mean()) < 5 / math.sqrt(len(judged)) and np.abs(judged).max() < 5.6, (
            distances[k],
            judged,
        )
    assert (np.median(all_z[:, 4:], axis=0) < -2).all()  # as it would be without a word


def test_as_far_off_as_the_finding_asks_or_with_more_particles_nothing_is_reported():
    *_, result = seen(LAMP, [(0.3, 0, 1.999)], [ROOM], particles=20_000)
    clear = float(near_findings(result)[0].split("at least ")[1].split(" m")[0])
    *_, moved = seen(LAMP, [(0.3, 0, 2 - clear)], [ROOM], particles=20_000)
    assert 0.01 < clear < 0.3 and not near_findings(moved)
    for particles, is_reported in ((2000, True), (200_000, False)):
        *_, result = seen(LAMP, [(0.3, 0, 1.95)], [ROOM], particles=particles)
        assert bool(near_findings(result)) == is_reported


def test_where_histories_are_split_each_weighs_less():
    """Behind a shield, half a metre off a diffuse wall: one of a hundredth of the weight adds little."""
    shield = filled(tp.Slab(center=(0, 0, 3), thickness=4.0), M(0.8, 0.4))
    wall = tp.Surface(tp.Plane(center=(0, 0, 8)), tp.Diffuse(0.9), "wall")
    splitting = tp.Splitting(start=(0, 0, 1), end=(0, 0, 5), gain=100)
    for tracking, is_reported in ((None, True), (tp.Tracking(splitting=splitting), False)):
        *_, result = seen(LAMP, [(0, 0, 7.0)], [shield, wall], particles=20_000, tracking=tracking)
        assert bool(near_findings(result)) == is_reported


NEAR, PLANE = (0.3, 0, -1 + 1e-5), tp.Plane(center=(0, 0, -1))
PENCIL = tp.Source(tp.Point(position=(0, 0, 2)), tp.Beam((0, 0, -1), power=3.0))
WHITE = tp.Diffuse(0.9)
SILENT = {
    "black wall": (NEAR, tp.Surface(PLANE, tp.Black()), {}),
    "black side of a wall": (NEAR, tp.Surface(PLANE, tp.TwoSided(tp.Black(), WHITE)), {}),
    "wall of albedo 0": (NEAR, tp.Surface(PLANE, tp.Diffuse(0.0)), {}),
    "mixture of both": (NEAR, tp.Surface(PLANE, tp.Mixture({tp.Black(): 0.5, tp.Diffuse(0.0): 0.5})), {}),
    "thin fog": (NEAR, filled(tp.Box(center=(0, 0, -2), size=2.0), M(0.1, 0.2)), {}),
    "a room from its middle": ((0.5, 0.5, 0), ROOM, {"particles": 100}),
    "a spot from afar": ((0, 1.2, 1.6), tp.Surface(tp.Disk(radius=1.0), tp.Diffuse(0.6)), {"sources": PENCIL, "particles": 100}),
    "soot in haze": ((0.3, 0, 1.9999), tp.Surface(ROOM.shape, tp.Diffuse(1e-4)), {"medium": M(0.1, 0.1), "particles": 1000}),
}  # fmt: skip


@pytest.mark.parametrize("case", SILENT)
def test_a_wall_or_medium_that_sends_nothing_there_is_not_reported(case):
    place, surface, how = SILENT[case]
    *_, result = seen(
        **{"sources": LAMP, "places": [place], "surfaces": [surface], "particles": 10_000} | how
    )
    assert not near_findings(result)


def test_the_diffuse_side_of_a_wall_is_reported():
    *_, result = seen(LAMP, [NEAR], [tp.Surface(PLANE, tp.TwoSided(WHITE, tp.Black()))])
    assert near_findings(result)
