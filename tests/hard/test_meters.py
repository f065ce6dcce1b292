"""A meter only looks: rays that meet it just where they meet a wall, or another meter, go on as if it were not there.

There two distances differ by a rounding only, and what is told from its sign is wrong in half of the cases.  Random rays
come so close with 1e-16; pencil beams and symmetric scenes surely.  All is asked of integers, with seed 1.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp

BEAMS = 150


def run(scene, particles, **options):
    return tp.simulate(scene, particles=particles, seed=1, progress=False, **options)


def both_sides(shapes):
    """A detector on each side of each shape, named by its number and the side."""
    return [
        tp.Detector(s, f"{k} {side}", side=side) for k, s in enumerate(shapes) for side in ("front", "back")
    ]


def crossings(result, k):
    """Histories that cross shape k from the front and from the back; what arrives at one side leaves the other."""
    arrive = np.array([result[f"{k} {side}"].number_of("weight in") for side in ("front", "back")])
    leave = np.array([result[f"{k} {side}"].number_of("weight out") for side in ("front", "back")])
    assert (arrive == leave[::-1]).all()
    return arrive


def unit(random):
    way = random.normal(size=3)
    return way / np.linalg.norm(way)


def turned(random):
    return np.linalg.qr(random.normal(size=(3, 3)))[0]


def pencil(start, target):
    """One particle, at 1 m/s."""
    gas = tp.Gas(number=1.0, speed=1.0, direction=tuple(np.subtract(target, start)))
    return tp.Source(tp.Point(position=tuple(start)), gas)


# ---- walls ----


def box_of(kind, turn, offset, width):
    """Six walls, 2 m apart; those that are wider overhang one another."""
    for axis in range(3):
        for sign in (-1, 1):
            center, up = offset + sign * turn[:, axis], turn[:, (axis + 1) % 3]
            wall = tp.Rectangle(center=center, normal=sign * turn[:, axis], up=up, width=width, height=width)
            yield tp.Surface(wall, kind)


def through_a_wall(turn, offset, random):
    """A disk that cuts a wall, and points of their common line."""
    line, angle = turn @ (math.cos(0.3), math.sin(0.3), 0), random.uniform(0.2, 1.4)
    normal = math.cos(angle) * turn[:, 2] + math.sin(angle) * np.cross(line, turn[:, 2])
    middle = offset + turn[:, 2]
    reach = random.uniform(-0.7, 0.7, (BEAMS, 1))
    return tp.Disk(center=tuple(middle), normal=tuple(normal), radius=0.8), middle + reach * line


def through_an_edge(turn, offset, random):
    """A disk through the common line of two walls, and points of that."""
    angle = random.uniform(-1.4, 1.4)
    normal = math.cos(angle) * turn[:, 0] + math.sin(angle) * turn[:, 1]
    middle = offset + turn[:, 0] + turn[:, 1]
    reach = random.uniform(-0.8, 0.8, (BEAMS, 1))
    return tp.Disk(center=tuple(middle), normal=tuple(normal), radius=0.9), middle + reach * turn[:, 2]


def ball_at_an_edge(turn, offset, random):
    """A sphere that bulges out of a wall, and points of the circle in which they meet."""
    angle, middle = random.uniform(0, 2 * math.pi, (BEAMS, 1)), offset + turn[:, 2]
    circle = 0.6 * (np.cos(angle) * turn[:, 0] + np.sin(angle) * turn[:, 1])
    return tp.Sphere(center=tuple(middle + 0.25 * turn[:, 2]), radius=0.65), middle + circle


@pytest.mark.parametrize("cut", [through_a_wall, through_an_edge, ball_at_an_edge])
@pytest.mark.parametrize("width", [2.0, 2.4], ids=["edge to edge", "overhanging"])
@pytest.mark.parametrize("kind", [tp.Mirror(), tp.Diffuse(1.0)], ids=["mirrors", "diffuse"])
def test_a_closed_box_with_a_meter_through_its_wall_keeps_everything_inside(cut, width, kind):
    """Standing on the meter, the wall would be at 0 but for a rounding, and half of the beams would be past it.

    Where walls overhang, the side of each is told from where a ray began: its origin, not the meter that it passed last.
    """
    random = np.random.default_rng(3)
    for _ in range(4):
        turn, offset = turned(random), random.normal(size=3)
        meter, targets = cut(turn, offset, random)
        beams = [pencil(offset + turn @ random.uniform(-0.5, 0.5, 3), target) for target in targets]
        looks = [tp.Detector(meter, "meter"), tp.Snapshot(5.0, particles=BEAMS)]
        result = run(tp.Scene(beams, list(box_of(kind, turn, offset, width)), looks, duration=5.0), BEAMS)
        places = (result["snapshot"].positions - offset) @ turn
        assert len(places) == BEAMS and np.abs(places).max() <= 1 + 1e-9


# ---- other meters ----


def test_coplanar_meters_that_another_one_cuts_are_each_counted_once():
    """Each has a center of its own, and with it, but for care, its own distance from the ray's origin: another one
    came in between, and was counted with only some of those that share a plane, and those twice."""
    random = np.random.default_rng(6)
    for _ in range(4):
        offset, turn = random.normal(size=3), turned(random)
        along, across, normal = turn.T
        angle = random.uniform(0.3, 1.5)
        leaning = math.cos(angle) * normal + math.sin(angle) * across
        shifts = random.uniform(-0.3, 0.3, (4, 2))
        shapes = [
            tp.Disk(center=offset + a * along + c * across, normal=normal, radius=1.5) for a, c in shifts
        ]
        shapes += [tp.Rectangle(center=offset + 0.1 * across, normal=normal, up=along, width=2.2, height=2.5)]
        shapes += [tp.Disk(center=offset + a * along, normal=leaning, radius=1.5) for a in (-0.2, 0.13)]
        shapes = [shapes[k] for k in random.permutation(len(shapes))]
        beams = [
            pencil(offset + 3 * unit(random), offset + reach * along)
            for reach in random.uniform(-0.8, 0.8, BEAMS)
        ]
        result = run(tp.Scene(beams, [], both_sides(shapes), duration=50.0), BEAMS)
        assert [crossings(result, k).sum() for k in range(len(shapes))] == [BEAMS] * len(shapes)


@pytest.mark.parametrize("disk_first", [True, False])
def test_a_ray_through_the_circle_in_which_a_disk_cuts_a_sphere_crosses_both(disk_first):
    """From outside it enters the sphere, leaves it, and passes the disk once: the sphere's near root is at the disk."""
    disk, ball = tp.Disk(center=(0.6, 0, 0), normal=(1, 0, 0), radius=1.2), tp.Sphere(radius=1.0)
    turns = np.arange(BEAMS) / BEAMS * 2 * math.pi
    targets = np.transpose([np.full(BEAMS, 0.6), 0.8 * np.cos(turns), 0.8 * np.sin(turns)])
    beams = [pencil((3.0, 0.5, 0.25), target) for target in targets]
    shapes = [disk, ball] if disk_first else [ball, disk]
    result = run(tp.Scene(beams, [], both_sides(shapes), duration=20.0), BEAMS)
    np.testing.assert_array_equal(crossings(result, shapes.index(ball)), [BEAMS, BEAMS])
    np.testing.assert_array_equal(crossings(result, shapes.index(disk)), [BEAMS, 0])


@pytest.mark.parametrize("far", [0.3, 10.0])
def test_all_meters_through_one_point_count_each_ray_through_that_point(far):
    """Disks, rectangles and spheres, in any order: planes once, spheres on the way in and on the way out."""
    random = np.random.default_rng(7)
    for _ in range(6):
        point, count = far * random.normal(size=3), random.integers(2, 6)
        normals, shapes = [unit(random) for _ in range(count)], []
        for normal in normals:
            shift, kind = random.uniform(0, 0.5) * np.cross(normal, unit(random)), random.integers(3)
            radius = random.uniform(0.2, 2)
            shapes.append(
                (
                    tp.Disk(center=point + shift, normal=normal, radius=1.0),
                    tp.Rectangle(center=point + shift, normal=normal, width=2.0, height=2.0),
                    tp.Sphere(center=point + radius * normal, radius=radius),
                )[kind]
            )
        ways = [unit(random) for _ in range(4 * BEAMS)]
        ways = [way for way in ways if np.abs(np.array(normals) @ way).min() > 0.05][:BEAMS]  # none grazes
        beams = [pencil(point - 5 * way, point) for way in ways]
        result = run(tp.Scene(beams, [], both_sides(shapes), duration=20.0), len(beams))
        for k, shape in enumerate(shapes):
            if isinstance(shape, tp.Sphere):
                np.testing.assert_array_equal(crossings(result, k), [len(beams)] * 2)
            else:
                assert crossings(result, k).sum() == len(beams)


@pytest.mark.parametrize(
    ("start", "way", "enter"),
    [
        ((-3, -3, -3), (1, 1, 1), 1),  # through two vertices
        ((-3, -3, 0.1), (1, 1, 0), 1),  # through two edges
        ((-3, -2, 0.1), (1, 1, 0), 1),  # through a face and an edge
        ((0, 0, 0), (1, 1, 1), 0),
        ((0, 0, 0), (1, 1, 0), 0),
        ((0, 0, 0), (1, 0, 0), 0),
    ],
)
def test_a_ray_through_an_edge_or_a_vertex_of_a_metered_box_is_counted_once(start, way, enter):
    """It is one detector: its faces are not meters that meet in a line, which would count two or three."""
    source = tp.Source(tp.Point(position=start), tp.Beam(way, power=1.0))
    result = run(tp.Scene(source, [], both_sides([tp.Box(size=2.0)])), 100)
    np.testing.assert_array_equal(crossings(result, 0), [100 * enter, 100])
    assert (result["0 front"].flux_in.value, result["0 front"].flux_out.value) == (enter, 1)


@pytest.mark.parametrize(
    ("start", "way"), [((0, 2, 0), (1, -1, 0)), ((2, 0, 0.3), (-1, 1, 0)), ((0, 2, 2), (1, -1, -1))]
)
def test_a_ray_that_only_touches_a_metered_box_enters_as_often_as_it_leaves(start, way):
    """At an edge it passes one face inwards and another outwards, at one and the same distance."""
    source = tp.Source(tp.Point(position=start), tp.Beam(way, power=1.0))
    result = run(tp.Scene(source, [], both_sides([tp.Box(size=2.0)])), 100)
    enter, leave = crossings(result, 0)
    assert enter == leave


# ---- aimed rays ----


@pytest.mark.parametrize("duration", [None, 1000.0])
def test_a_meter_on_the_way_does_not_change_what_reaches_a_distant_target(duration):
    """A millimetre at the distance of the Sun is 7e-15 of it: rays are told from their target, not from the meter.

    Put back from the meter, every thousandth missed the target: too few for an error bar, so the counts must be equal.
    """
    target = tp.Disk(radius=1e-3)
    light = tp.Lambertian(power=1.0) if duration is None else tp.Lambertian(energy=1.0)
    sun = np.array([1e10, 2e10, 1.496e11])
    source = tp.Source(tp.Sphere(center=sun, radius=6.96e8), light, aim=target)
    near = tp.Detector(tp.Disk(center=0.99 * sun, radius=5e9), "near the Sun", side="front")
    ball = tp.Detector(tp.Sphere(center=0.5 * sun, radius=1e9), "ball", side="front")
    found = []
    for on_the_way in ([], [near], [near, ball]):
        looks = both_sides([target])
        result = run(tp.Scene(source, [], looks + on_the_way, duration=duration), 20_000)
        found.append((tuple(crossings(result, 0)), float(result["0 front"].flux_in.value)))
    assert found[0] == found[1] == found[2]
    for name in ("near the Sun", "ball"):  # they do look at all of these rays, and at what is still under way
        assert result[name].number_of("weight in") >= sum(found[0][0]) > 4000


def test_a_point_where_meters_meet_has_crossed_none_of_them():
    """At its birth each plane is within a rounding of 0 along the ray; what flies on never meets them again."""
    random = np.random.default_rng(5)
    for _ in range(10):
        place, axes = tuple(random.normal(size=3)), turned(random).T
        meters = [
            tp.Detector(tp.Disk(center=place + 0.5 * axes[2], normal=axes[k], radius=1.0), name)
            for k, name in enumerate("ab")
        ]
        source = tp.Source(tp.Point(position=place), tp.Isotropic(power=1.0))
        result = tp.simulate(tp.Scene(source, detectors=meters), particles=2_000, seed=1, progress=False)
        assert all(result[name].is_blind for name in "ab")


def test_a_point_where_walls_meet_is_refused():
    """On which side of which wall it shines would be told by a rounding."""
    walls = [
        tp.Surface(tp.Rectangle(normal=normal, width=2.0, height=2.0), tp.Mirror(), f"wall {k}")
        for k, normal in enumerate(turned(np.random.default_rng(5)).T[:2])
    ]
    source = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    with pytest.raises(tp.SceneError, match=r"position must not lie where walls meet, got Point.*; move it"):
        tp.simulate(tp.Scene(source, walls), particles=100, progress=False)
