"""tp.view_factor and tp.etendue count what closed forms say: near, far, past obstacles, for any sides and
shapes.

A comment such as `C.coaxial_discs` names the entry of the project's reference collection that a number comes
from.  The closed forms themselves are tested in experiments/test_view_factors.py.  Each statistical test fails right code
in one of 10^5 seeds; the seed is 1.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_z_spread, smallest_bias
from transport.analysis.view_factors import view_factor_from_run, view_factor_scene
from transport.theory import occlusion, round_view_factors, view_factors

FALSE_ALARM = 1e-5
DOWN = (0, 0, -1)


def counted(a, b, *blockers, particles=200_000, seed=1, **sides):
    return tp.view_factor(a, b, blockers, particles=particles, seed=seed, **sides)


def disks(radius_1, radius_2, distance):
    return tp.Disk(radius=radius_1), tp.Disk(center=(0, 0, distance), normal=DOWN, radius=radius_2)


def rectangles(width, height, distance):
    sides = {"width": width, "height": height}
    return tp.Rectangle(**sides), tp.Rectangle(center=(0, 0, distance), normal=DOWN, **sides)


def corner(width_1, width_2):
    """With a common edge of 1 m along y."""
    floor = tp.Rectangle(center=(width_1 / 2, 0, 0), width=width_1, height=1)
    wall = tp.Rectangle(center=(0, 0, width_2 / 2), normal=(1, 0, 0), up=(0, 1, 0), width=width_2, height=1)
    return floor, wall


def ball_and_disk(ball, disk, distance):
    return tp.Sphere(center=(0, 0, distance), radius=ball), tp.Disk(radius=disk)


def tube(height):
    return tp.Cylinder(center=(0, 0, height / 2), radius=1, height=height)


def assert_rejected(estimate, wrong):
    with pytest.raises(AssertionError):
        assert_agrees(estimate, wrong, FALSE_ALARM)


# ---- the reference collection ----

REFERENCES = [
    # C.coaxial_discs
    (disks(1, 1, 1), 0.38196601125010515),
    (disks(1, 2, 1), 0.7639320225002103),
    (disks(1, 0.001, 1), 4.999998750000001e-07),
    # C.parallel_rectangles
    (rectangles(1, 1, 10), 0.0031620568387576015),
    (rectangles(1, 1, 0.001), 0.9980056319075797),
    (rectangles(100, 0.01, 1), 0.004968045609095783),
    (rectangles(1, 1, 100_000), 3.1830988616257004e-11),
    # C.perpendicular_rectangles
    (corner(1, 1), 0.20004377607540316),
    (corner(1, 0.01), 0.004895849268506683),
    (corner(1, 100), 0.2499920427833168),
    # C.sphere_to_disc
    (ball_and_disk(1, 0.01, 2), 6.249882814941353e-06),
    (ball_and_disk(1, 10_000, 1.5), 0.4999250000008437),
]


@pytest.mark.slow
@pytest.mark.parametrize(("pair", "exact"), REFERENCES)
def test_a_reference_is_counted(pair, exact):
    """To 5 % and mostly to 0.5 %, whatever its size: from the smaller area, aimed at what is far."""
    found = counted(*pair)
    assert found.unit == tp.Unit()
    assert_agrees(found, exact, FALSE_ALARM)
    limit = 0.05 if 0.001 < exact < 0.005 else 0.006
    if exact < 1e-10:  # all rays weigh the same: eight digits where one unaimed ray in 3e10 would arrive
        limit = 1e-9
    assert found.relative_error < limit


@pytest.mark.slow
@pytest.mark.parametrize(
    ("height", "to_end", "to_wall", "from_wall", "itself"),
    [  # C.inside_cylinder
        (0.01, 0.9900498750007812, 0.00995012499921876, 0.497506249960938, 0.0049875000781240235),
        (0.1, 0.9048750780274961, 0.09512492197250394, 0.47562460986251964, 0.048750780274960714),
        (2, 0.1715728752538099, 0.8284271247461901, 0.20710678118654752, 0.585786437626905),
        (10, 0.0098048640721517, 0.9901951359278482, 0.04950975679639241, 0.9009804864072152),
    ],
)
def test_the_inside_of_a_tube_is_counted(height, to_end, to_wall, from_wall, itself):
    wall, (bottom, top) = tube(height), disks(1, 1, height)
    assert_agrees(counted(bottom, top), to_end, FALSE_ALARM)
    assert_agrees(counted(bottom, wall, side_b="back"), to_wall, FALSE_ALARM)
    assert_agrees(counted(wall, bottom, side_a="back"), from_wall, FALSE_ALARM)
    assert_agrees(counted(wall, wall, side_a="back", side_b="back"), itself, FALSE_ALARM)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pair", "exact"),
    [  # B.etendue_discs, B.etendue_rectangles
        (disks(1, 1, 1), 3.7698534257005853),
        (disks(0.01, 0.02, 1), 3.945868983699782e-07),
        (disks(1, 1, 100), 0.0009867630973551228),
        (rectangles(1, 2, 0.5), 3.198070126842054),
        (rectangles(1, 1, 0.01), 3.080069597209699),
        (rectangles(10, 0.1, 1), 0.1467386196838192),
    ],
)
def test_an_etendue_is_counted_and_the_same_from_either_end(pair, exact):
    found, back = (tp.etendue(*ends, particles=200_000, seed=1) for ends in (pair, pair[::-1]))
    assert found.unit == tp.Unit.parse("m^2 sr")
    assert_agrees(found, exact, FALSE_ALARM)
    assert_agrees(back, exact, FALSE_ALARM)


# ---- reciprocity, sides, obstacles ----


def test_both_ways_are_one_and_the_factors_swapped_are_rejected():
    a, b = disks(1, 0.5, 0.8)
    there, back = counted(a, b), counted(b, a)
    assert there.value * a.area == pytest.approx(back.value * b.area, rel=1e-12)
    assert_agrees(there, view_factors.coaxial_disks(1, 0.5, 0.8), FALSE_ALARM)
    assert_rejected(there, view_factors.coaxial_disks(0.5, 1, 0.8))
    assert smallest_bias(there, FALSE_ALARM) < 0.02
    assert_rejected(there, 1.02 * view_factors.coaxial_disks(1, 0.5, 0.8))


@pytest.mark.quick_cases("False-a", "False-b")
@pytest.mark.parametrize("start", ["a", "b"])
@pytest.mark.parametrize("is_aimed", [False, True])
def test_every_way_of_counting_gives_the_same(start, is_aimed, monkeypatch):
    """Which one is taken is a matter of cost only."""
    ends, module = (start, "b" if start == "a" else "a"), "transport.analysis.view_factors"
    monkeypatch.setattr(f"{module}._start_and_target", lambda a, b: ends)
    monkeypatch.setattr(f"{module}._is_far", lambda start, target: is_aimed)
    assert_agrees(counted(*disks(1, 0.7, 0.5)), view_factors.coaxial_disks(1, 0.7, 0.5), FALSE_ALARM)
    assert_agrees(counted(*corner(1, 0.3)), view_factors.perpendicular_rectangles(1, 0.3), FALSE_ALARM)
    balls = tp.Sphere(radius=1), tp.Sphere(center=(0, 0, 3), radius=0.5)
    assert_agrees(counted(*balls), round_view_factors.spheres(1, 0.5, 3), FALSE_ALARM)


def test_shapes_that_face_away_exchange_nothing():
    a, b = disks(1, 1, 1)
    for name in ("a", "b"):
        cure = (
            f'the back of {name} faces away from all of .*; reverse its normal, or write side_{name}="front"'
        )
        with pytest.warns(UserWarning, match=cure) as warned:
            assert counted(a, b, particles=1000, **{f"side_{name}": "back"}).value == 0
        assert len(warned) == 1
    both = counted(*disks(1, 1, -1), side_a="back", side_b="back")
    assert_agrees(both, view_factors.coaxial_disks(1, 1, 1), FALSE_ALARM)


def test_in_one_plane_nothing_is_exchanged_exactly():
    for b in (tp.Disk(center=(3, 0, 0), radius=1), tp.Rectangle(center=(0, -4, 0), width=1, height=5)):
        found = counted(tp.Disk(radius=1), b, particles=1000)
        assert (found.value, found.error, found.exact) == (0, 0, True)
    itself = counted(tp.Disk(radius=1), tp.Disk(radius=1), particles=1000)
    assert itself.exact and itself.value == 0


def test_a_sphere_round_a_ball_receives_all_of_it_and_returns_its_share():
    ball, around = tp.Sphere(center=(0.2, 0, 0.1), radius=0.5), tp.Sphere(radius=1)
    assert counted(ball, around, side_b="back", particles=1000).value == 1
    assert counted(around, ball, side_a="back", particles=1000).value == pytest.approx(0.25, rel=1e-12)
    itself = counted(around, around, ball, side_a="back", side_b="back")
    assert_agrees(itself, 0.75, FALSE_ALARM)


def test_an_obstacle_takes_its_share_and_leaving_it_out_is_rejected():
    pair, obstacle = disks(1, 1, 1), tp.Disk(center=(0, 0, 0.5), radius=0.5)
    found = counted(*pair, obstacle)
    assert_agrees(found, occlusion.disks_past_disk(1, 1, 1, 0.5, 0.5), FALSE_ALARM)
    assert_rejected(found, view_factors.coaxial_disks(1, 1, 1))
    alone = tp.view_factor(*pair, obstacle, particles=200_000, seed=1)  # one without a list
    assert alone.value == found.value
    screen = tp.Disk(center=(0, 0, 0.5), radius=3)
    assert counted(*pair, screen, particles=1000).value == 0


def test_several_obstacles_of_several_kinds_stand_in_the_way():
    """Two opposite quarters of a screen hide half, by symmetry; with a ball behind nothing is left."""
    pair = disks(0.1, 0.1, 1)
    quarters = [tp.Rectangle(center=(x, y, 0.5), width=1, height=1) for x, y in ((0.5, 0.5), (-0.5, -0.5))]
    ball = tp.Sphere(center=(0, 0, 0.75), radius=0.2)
    assert_agrees(counted(*pair, *quarters), view_factors.coaxial_disks(0.1, 0.1, 1) / 2, FALSE_ALARM)
    assert counted(*pair, *quarters, ball, particles=10_000).value == 0


def test_boxes_triangles_and_endless_planes_take_part():
    box = tp.Box(center=(0, 0, 1.5), size=1)  # a small disk sees its lower face only
    from_below = 0.7522746884541075 / math.pi  # B.projected_solid_angle_polygon
    assert_agrees(counted(tp.Disk(radius=1e-5), box), from_below, FALSE_ALARM)
    assert_agrees(counted(box, tp.Plane(normal=(0, 0, 1))), (1 / 2 * 4 + 1) / 6, FALSE_ALARM)
    half = tp.Triangle(vertices=((-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0)))
    _, lid = rectangles(1, 1, 1)
    assert_agrees(counted(half, lid), view_factors.parallel_rectangles(1, 1, 1), FALSE_ALARM)


@pytest.mark.slow
def test_a_mesh_gives_what_its_shape_gives():
    _, disk = ball_and_disk(0.5, 0.8, 1)
    cube = {"center": (0, 0, 1), "size": 0.8}
    mesh = tp.Mesh.box(size=0.8).moved((0, 0, 1))
    by_mesh, by_box = (counted(shape, disk, seed=seed) for seed, shape in enumerate((mesh, tp.Box(**cube))))
    assert_agrees(by_mesh - by_box, 0.0, FALSE_ALARM)
    assert by_mesh.relative_error < 0.02


# ---- the numbers ----


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e12])
def test_the_unit_of_length_does_not_matter(size):
    found, usual = counted(*disks(size, 0.7 * size, 2 * size)), counted(*disks(1, 0.7, 2))
    assert found.value == pytest.approx(usual.value, rel=1e-12)
    here, there = (tp.etendue(*disks(x, x, x), particles=1000).value for x in (1, size))
    assert there == pytest.approx(here * size**2, rel=1e-12)


def test_a_seed_gives_the_same_digits_and_another_one_others():
    pair = disks(1, 1, 1)
    assert counted(*pair, seed=5).value == counted(*pair, seed=5).value != counted(*pair, seed=6).value


@pytest.mark.slow
def test_errors_are_right():
    """Over seeds z follows Student's t: aimed from the smaller area, past an obstacle."""
    pair, obstacle = disks(1, 0.7, 1.2), tp.Disk(center=(0, 0, 0.6), radius=0.3)
    exact = occlusion.disks_past_disk(1, 0.7, 1.2, 0.3, 0.6)
    z = [counted(*pair, obstacle, particles=4_000, seed=seed).z(exact) for seed in range(120)]
    assert_z_spread(np.array(z), math.inf, FALSE_ALARM)


def test_the_scene_can_be_had_by_itself():
    scene = view_factor_scene(*disks(1, 0.5, 1), blockers=tp.Disk(center=(0, 0, 0.5), radius=0.1))
    assert [surface.name for surface in scene.surfaces] == ["a", "b", "blockers[0]"]
    result = tp.simulate(scene, particles=10_000, seed=1)
    assert result.ledger["lost"].value == 0
    assert view_factor_from_run(result).value > 0
