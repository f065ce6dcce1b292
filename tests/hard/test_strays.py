"""Beams aimed at what has no width: tangents, rims, apexes, edges, corners of bodies that absorb.

Each is absorbed as on one side of the edge or on the other, or lost and counted with a warning; never absorbed for ever in
what it has left.  A code that tells what a ray is in by the surfaces crossed, and misses one of two that meet, reports 1.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.driven import Lanes
from transport.compile import layout
from transport.engine.passes import regions
from transport.geometry.flat import Disk, Plane, Rectangle
from transport.geometry.mesh import Mesh
from transport.geometry.revolved import Cone, Cylinder, Paraboloid
from transport.geometry.shape import Point
from transport.geometry.solid import Box, Sphere
from transport.scene.detectors import Detector
from transport.scene.emissions import Beam
from transport.scene.materials import Surface, Transparent
from transport.scene.media import Medium
from transport.scene.scene import Scene
from transport.scene.sources import Source
from transport.simulate import simulate

FOG = Medium(absorption=1.0)


def filled(shape, medium=FOG):
    return Surface(shape, Transparent(), inside=medium)


def can(medium=FOG):
    ends = [Disk(center=(0, 0, 1), radius=1.0), Disk(center=(0, 0, -1), normal=(0, 0, -1), radius=1.0)]
    return [filled(Cylinder(radius=1.0, height=2.0), medium), *(filled(end, medium) for end in ends)]


def hut(medium=FOG, height=2.0):
    base = Disk(center=(0, 0, -height / 2), normal=(0, 0, -1), radius=1.0)
    return [filled(Cone(radius=1.0, height=height), medium), filled(base, medium)]


def dome(medium=FOG):
    return [
        filled(Sphere(radius=1.0, mu_min=0.0), medium),
        filled(Disk(normal=(0, 0, -1), radius=1.0), medium),
    ]


def bowl(medium=FOG):
    """A paraboloid with its vertex at the origin, and its lid."""
    lid = Disk(center=(0, 0, 1), radius=1.0)
    return [filled(Paraboloid(focal_length=0.25, radius=1.0), medium), filled(lid, medium)]


def followed(surfaces, origin, target, medium=FOG, particles=320):
    """Absorbed and lost shares of a beam from one point towards another, and the run's warnings."""
    way = tuple(float(b - a) for a, b in zip(origin, target, strict=True))
    lamp = Source(Point(position=tuple(map(float, origin))), Beam(way, power=1.0))
    result = simulate(Scene(lamp, surfaces), particles=particles, seed=1, threads=1)
    return result.ledger["absorbed"].value, result.ledger["lost"].value, result.warnings


def absorbed(way):
    return -math.expm1(-way)


TANGENTS = {
    "wall of a can": (can, (1, 3, 0), (1, 0, 0), 0.0),
    "pole of a dome": (dome, (3, 0, 1), (0, 0, 1), 0.0),
    "side of a dome": (dome, (1, 3, 0.5), (1, 0, 0.5), None),
    "vertex of a bowl": (bowl, (3, 0, 0), (0, 0, 0), 0.0),
    "apex, from the side": (hut, (2, 0, 1), (0, 0, 1), 0.0),
    "apex, obliquely past it": (hut, (2, 0, 2), (0, 0, 1), 0.0),
}


@pytest.mark.parametrize(("solid", "origin", "target", "way"), TANGENTS.values(), ids=TANGENTS)
def test_what_only_touches_stays_outside(solid, origin, target, way):
    share, lost, _ = followed(solid(), origin, target)
    assert lost == 0
    assert share == pytest.approx(0.0 if way == 0.0 else share, abs=1e-12)
    assert share < 1e-6


@pytest.mark.parametrize("aside", [0.0, 1e-300, 1e-15, 1e-12, 1e-9, 1e-6])
@pytest.mark.parametrize("upwards", [False, True])
def test_through_the_apex_of_a_cone(aside, upwards):
    """On the axis, and so near to it that squares vanish: both ways the path is the height of the cone."""
    origin, target = ((aside, 0, 3), (aside, 0, 0))
    if upwards:
        origin = (aside, 0, -3)
    share, lost, _ = followed(hut(), origin, target)
    assert lost == 0
    assert share == pytest.approx(absorbed(2 * (1 - aside)), rel=1e-12)


@pytest.mark.parametrize("tilt", [0.1, 0.2, 0.4])
def test_through_the_apex_obliquely(tilt):
    share, lost, _ = followed(hut(), (tilt, 0, 2), (0, 0, 1))
    assert lost == 0
    assert share == pytest.approx(absorbed(2 * math.hypot(1, tilt)), rel=1e-12)


@pytest.mark.parametrize("height", [1e-3, 1e-2, 0.1, 0.5, 10.0, 1e3])
def test_through_the_apex_of_flat_cones_and_sharp_ones(height):
    """From near and far, from both sides, and from the apex itself; the slope at a flat cone's apex is steep in its height."""
    top, middle = (0, 0, height / 2), (0, 0, 0)
    for origin in (*((0, 0, height / 2 + way) for way in (1, 3, 10, 1e4)), (0, 0, -100 - height), top):
        share, lost, _ = followed(hut(height=height), origin, middle, particles=64)
        assert lost == 0
        assert share == pytest.approx(absorbed(height), rel=1e-9)


def test_meters_on_a_cone_and_its_base_count_a_ray_through_the_apex_once():
    for height in (0.01, 0.1, 2.0):
        for origin, way in (((0, 0, 10.0), (0, 0, -1)), ((0, 0, -100.0), (0, 0, 1))):
            lamp = Source(Point(position=origin), Beam(way, power=1.0))
            base = Disk(center=(0, 0, -height / 2), normal=(0, 0, -1), radius=1.0)
            meters = [Detector(Cone(radius=1.0, height=height), "cone"), Detector(base, "base")]
            result = simulate(Scene(lamp, [], meters), particles=64, seed=1, threads=1)
            into, out = ("cone", "base") if way[2] < 0 else ("base", "cone")
            assert result[into].flux_in.value == 1 and result[into].flux_out.value == 0
            assert result[out].flux_in.value == 0 and result[out].flux_out.value == 1


def aimed_at_rims(number):
    """Beams from all around at points of the rims and corners of solids."""
    rng = np.random.default_rng(number)
    turn, height = rng.uniform(0, 2 * math.pi), rng.choice([-1.0, 1.0])
    rim = (math.cos(turn), math.sin(turn), height)
    corner = tuple(rng.choice([-1.0, 1.0], 3))
    edge = (rng.uniform(-1, 1), *rng.choice([-1.0, 1.0], 2))
    solids = [(can(), rim), ([filled(Mesh.box(size=2.0))], corner), ([filled(Mesh.box(size=2.0))], edge)]
    solids += [([filled(Box(size=2.0))], corner), ([filled(Box(size=2.0))], edge)]
    for surfaces, target in solids:
        for _ in range(6):
            way = rng.normal(size=3)
            yield surfaces, tuple(np.array(target) - 3 * way / np.linalg.norm(way)), target


def chord(origin, target, is_can):
    """Way of a line within the can or the box of half sides 1."""
    o, u = np.array(origin, float), np.array(target, float) - origin
    u /= np.linalg.norm(u)
    ends = []
    for axis in (2,) if is_can else (0, 1, 2):
        ends.append(sorted(((-1 - o[axis]) / u[axis], (1 - o[axis]) / u[axis])))
    if is_can:
        a, b, c = u[:2] @ u[:2], o[:2] @ u[:2], o[:2] @ o[:2] - 1
        root = math.sqrt(max(b * b - a * c, 0.0))
        ends.append([(-b - root) / a, (-b + root) / a])
    return max(min(far for _, far in ends) - max(near for near, _ in ends), 0.0)


@pytest.mark.parametrize("number", range(3))
def test_at_rims_and_corners_it_is_right_or_lost(number):
    """Through the solid, or past it by nothing; what rounding led astray is counted as lost and told."""
    for surfaces, origin, target in aimed_at_rims(number):
        share, lost, warnings = followed(surfaces, origin, target, particles=64)
        way = chord(origin, target, is_can=len(surfaces) == 3)
        assert lost in (0.0, 1.0)
        assert lost > 0 or share == pytest.approx(absorbed(way), abs=1e-6)
        assert lost == 0 or any("lost" in warning for warning in warnings)


def test_endless_bodies_have_no_strays():
    """A half space, a slab, and all that lies outside of a ball: flights without a surface ahead are their due."""
    lamp = Source(Point(position=(0, 0, 2.0)), Beam((0, 0, 1), power=1.0))
    outside = Surface(Sphere(radius=1.0), Transparent(), outside=FOG)
    result = simulate(Scene(lamp, [outside], medium=FOG), particles=64, seed=1, threads=1)
    assert result.ledger["absorbed"].value == pytest.approx(1.0) and result.ledger["lost"].value == 0


def test_only_what_flies_in_a_finite_body_goes_astray():
    """Each reason by itself: not in the body, a surface ahead, waiting, dead, ending within the box."""
    lanes = Lanes(inside=1, flies=1, distance=math.inf, weight=0.5)
    for lane, name, value in ((1, "inside", 2), (2, "hit", 1), (3, "flies", 0), (4, "weight", 0.0)):
        changed = lanes[name]
        changed[lane] = value
        lanes[name] = changed
    changed = lanes["distance"]
    changed[5], changed[6] = 0.5, 1.5
    lanes["distance"] = changed
    lanes.run(regions.end_lost_particles, low_x=-1, low_y=-1, low_z=-1, high_x=1, high_y=1, high_z=1, bit=1)
    kept = np.flatnonzero(lanes["weight"] == 0.5)
    assert kept.tolist() == [1, 2, 3, 5]
    strays = int(lanes.ledger[layout.LOST, 2])
    assert strays == len(lanes["weight"]) - 5
    assert lanes.gained(layout.LOST) == pytest.approx(0.5 * strays)
    assert (lanes["flies"][6:] == 0).all() and (lanes["distance"][6:] == 0.0).all()


def test_a_meter_does_not_make_a_body_finite():
    """A disk beside a half space bounds nothing."""
    lamp = Source(Point(position=(0, 0, 1.0)), Beam((0, 0, -1), power=1.0))
    ground = Surface(Rectangle(width=1, height=1, center=(0, 0, 0.5)), Transparent())
    soil = Surface(Plane(), Transparent(), inside=FOG)
    result = simulate(Scene(lamp, [ground, soil], Detector(Plane(), "top")), particles=64, seed=1, threads=1)
    assert result.ledger["absorbed"].value == pytest.approx(1.0) and result.ledger["lost"].value == 0


def test_what_enters_by_a_gap_is_told_of_when_it_leaves():
    """A hole too small for the lines that look for gaps: what comes in by it is in no fog, and the result says so."""
    lid = Disk(center=(0, 0, 1), radius=1.0, inner_radius=0.01)
    surfaces = [filled(lid) if surface.shape.center == (0, 0, 1) else surface for surface in can()]
    share, lost, warnings = followed(surfaces, (0, 0, 3), (0, 0, 0))
    assert (share, lost) == (0.0, 0.0)
    assert any("without having entered it: its surfaces leave a gap" in warning for warning in warnings)
    share, lost, warnings = followed(surfaces, (0, 0, -3), (0, 0, 0))
    assert lost == pytest.approx(1.0) and any("histories were lost" in warning for warning in warnings)
    assert followed(can(), (0, 0, 3), (0, 0, 0))[2] == []


@pytest.mark.parametrize("balls", [0, 2, 9])
def test_strays_of_a_body_are_told_by_its_own_box(balls):
    """A ray that grazes the rim of a can, with other bodies far off: it does not collide in the empty space between them."""
    haze = Medium(absorption=0.01, scattering=0.09)
    far = [filled(Sphere(center=(50.0 + 9 * k, 60, 70), radius=1.0), haze) for k in range(balls)]
    origin = np.array([3.1510952907115253, -0.41387957380853624, 0.10639802125006559])
    way = np.array([-0.938251256781713, -0.17595350266540644, 0.29786732624997814])
    share, lost, warnings = followed([*can(haze), *far], origin, origin + way, particles=2000)
    assert share < 0.1  # 0.8 where one box is laid about all bodies
    assert lost in (0.0, pytest.approx(1.0, abs=0.1))
    assert lost == 0 or any("histories were lost" in warning for warning in warnings)
