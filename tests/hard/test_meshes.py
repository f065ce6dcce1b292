"""Closed meshes hold what is inside and keep out what is outside; every edge and vertex is crossed exactly once.

Bodies are turned and shifted, so that no coordinate is round, but where rays are to meet edges and vertices exactly.  Naive
ways leak: facets that do not quite share their vertices, edge functions without the decision at 0 (planted below).
"""

import functools
import itertools
import json
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import transport as tp
from tests.agreement import assert_agrees
from tests.hard.meshes import (
    beam,
    beams_from_inside,
    beams_from_outside,
    bipyramid,
    cracked,
    joined,
    lattice,
    needles,
    random_turn,
    star,
    turned,
    wedge,
)
from transport.theory.view_factors import parallel_rectangles

ROOT = Path(__file__).resolve().parents[2]
BODIES = {
    "80 triangles": lambda: tp.Mesh.sphere(radius=1.0, triangles=80),
    "box": lambda: tp.Mesh.box(size=(1, 2, 3)),
    "long box": lambda: tp.Mesh.box(size=(1, 1e-3, 1e-3)),
    "plate": lambda: tp.Mesh.box(size=(1, 1, 1e-5)),
    "thin plate": lambda: tp.Mesh.box(size=(1, 1, 1e-8)),
    "thinnest plate": lambda: tp.Mesh.box(size=(1, 1, 1e-12)),
    "wedge": lambda: wedge(0.5),
    "sharp wedge": lambda: wedge(1e-3),
    "vertex of 1000": lambda: bipyramid(1000, 1.0),
    "flat vertex of 100": lambda: bipyramid(100, 1e-3),
    "needles": lambda: needles(1e8),
    "star": lambda: star(5, 0.4),
    "flat star": lambda: star(7, 0.97),
    "sharp star": lambda: star(5, 0.01),
}
bodies = pytest.mark.parametrize("make", BODIES.values(), ids=BODIES)


def run(sources, surfaces=(), detectors=(), particles=2000, batches=32):
    scene = tp.Scene(sources, surfaces, detectors)
    result = tp.simulate(scene, particles=particles, seed=1, batches=batches, progress=False)
    assert result.ledger["lost"].value == 0
    return result


def escaped(*scene, **how):
    return float(run(*scene, **how).ledger["escaped"].value)


# ---- nothing leaks ----


@bodies
@pytest.mark.parametrize(
    "material", [tp.Diffuse(0.9), tp.Mirror(0.9), tp.Black()], ids=["diffuse", "mirror", "black"]
)
def test_a_closed_mesh_holds_what_it_emits_inwards(make, material):
    wall = tp.Surface(turned(make()), material, name="wall")
    assert escaped(tp.Source("wall", tp.Lambertian(power=1.0), side="back"), wall) == 0


@bodies
def test_a_mesh_inside_out_holds_what_it_emits_from_its_front(make):
    wall = tp.Surface(turned(make()).flipped(), tp.Diffuse(0.9), name="wall")
    assert escaped(tp.Source("wall", tp.Lambertian(power=1.0)), wall) == 0


@bodies
def test_beams_from_inside_into_edges_and_vertices_stay_inside(make):
    for shift in (0.3, 10):
        mesh = turned(make(), shift=shift)
        assert escaped(beams_from_inside(mesh), tp.Surface(mesh, tp.Diffuse(0.7)), particles=6000) == 0


@bodies
def test_beams_from_outside_into_edges_and_vertices_stay_outside(make):
    mesh = turned(make())
    room = tp.Sphere(center=mesh.middle, radius=2 * mesh.extent)
    walls = [tp.Surface(mesh, tp.Diffuse(0.7), name="body"), tp.Surface(room, tp.Diffuse(0.5))]
    result = run(
        beams_from_outside(mesh), walls, tp.Detector("body", name="in", side="inside"), particles=6000
    )
    assert result["in"].counts.value == 0 and result.ledger["escaped"].value == 0


def test_facets_that_do_not_share_their_vertices_leak():
    """Planted: cracks of an ulp."""
    for make in (BODIES["box"], BODIES["80 triangles"]):
        mesh = cracked(turned(make()))
        assert escaped(beams_from_inside(mesh), tp.Surface(mesh, tp.Black()), particles=6000) > 0.5


@pytest.mark.parametrize("triangles", [1280, 20_000, 100_000])
def test_fine_spheres_hold_many_particles(triangles):
    wall = tp.Surface(turned(tp.Mesh.sphere(radius=1.0, triangles=triangles)), tp.Diffuse(0.9), name="wall")
    assert escaped(tp.Source("wall", tp.Lambertian(power=1.0), side="back"), wall, particles=20_000) == 0


def test_light_in_a_cavity_stays_there():
    shell = joined(
        tp.Mesh.sphere(radius=1.0, triangles=320), tp.Mesh.sphere(radius=0.9, triangles=320).flipped()
    )
    wall = tp.Surface(turned(shell), tp.Diffuse(0.9), name="wall")
    lamp = tp.Source(tp.Point(position=wall.shape.middle), tp.Isotropic(power=1.0))
    result = run(lamp, wall, tp.Detector("wall", name="in", side="inside"))
    assert result["in"].counts.value == 0 and result.ledger["escaped"].value == 0


def test_two_bodies_that_overlap_in_one_mesh_hold_what_is_in_either():
    """Light within both meets the back of either."""
    both = turned(joined(tp.Mesh.box(size=2.0), tp.Mesh.box(center=(1, 0.9, 0.8), size=(2.1, 2.2, 2.3))))
    wall = tp.Surface(both, tp.Diffuse(0.9), name="wall")
    lamp = tp.Source("wall", tp.Lambertian(power=1.0), side="back")
    assert escaped(lamp, wall, particles=20_000) == 0


# ---- edges and vertices are crossed once ----

PLACES = [
    (x / 2, y / 2) for x in range(1, 8) for y in range(1, 8)
]  # vertices, points of edges, of diagonals, of facets


@pytest.mark.parametrize("offset", [(0, 0, 0), (0.1, 0.7, -0.3)])
@pytest.mark.parametrize(("start", "way", "entries"), [(9, -1, 49), (-5, 1, 49), (2.5, 1, 0), (1.5, -1, 0)])
def test_rays_through_vertices_and_edges_cross_exactly_once(offset, start, way, entries):
    mesh = lattice(4).moved(offset)
    lamps = [beam(np.add((x, y, start), offset), np.add((x, y, start + way), offset)) for x, y in PLACES]
    meter = run(lamps, (), tp.Detector(mesh, name="meter"), particles=32 * 49)["meter"]
    assert (meter.flux_in.value, meter.flux_out.value) == (entries, 49)
    sides = [tp.Detector("wall", name=side, side=side) for side in ("outside", "inside")]
    result = run(lamps, tp.Surface(mesh, tp.Black(), name="wall"), sides, particles=32 * 49)
    assert (result["outside"].flux_in.value, result["inside"].flux_in.value) == (entries, 49 - entries)


@pytest.mark.parametrize(
    "place", [(0, 0), (0, 4), (4, 4), (0, 2), (0, 1.5), (4, 3), (2, 0), (2, 4), (3.5, 4)]
)
def test_rays_along_a_side_go_in_as_often_as_out(place):
    """They lie in the planes of facets, along edges."""
    meter = run(beam((*place, 9), (*place, 8)), (), tp.Detector(lattice(4), name="meter"), particles=32)[
        "meter"
    ]
    assert meter.flux_in.value == meter.flux_out.value in (0, 1)


@bodies
def test_beams_into_edges_cross_a_transparent_meter_in_pairs_from_outside_and_once_more_from_inside(make):
    mesh = turned(make())
    for lamps, within in ((beams_from_outside(mesh), 0), (beams_from_inside(mesh), 60)):
        for lamp in (lamps, lamps[::7]):
            meter = run(lamp, (), tp.Detector(mesh, name="meter"), particles=32 * len(lamp))["meter"]
            assert meter.flux_out.value - meter.flux_in.value == (len(lamp) if within else 0)


numbers = st.floats(-2, 2, allow_subnormal=False).map(lambda x: x if abs(x) > 1e-70 else 0.0)
corners = st.tuples(numbers, numbers)


@settings(deadline=None)
@given(corners, corners)
def test_the_side_of_an_edge_is_exact_and_opposite_from_its_other_facet(p, q):
    from fractions import Fraction

    from transport.physics import facets

    for a, b in ((p, q), (p, (1.1 * p[0], 1.1 * p[1])), (p, (p[0] / 3, p[1] / 3)), (p, p[::-1])):
        value, other = _plain(facets.edge_function)(*a, *b), _plain(facets.edge_function)(*b, *a)
        exact = Fraction(a[0]) * Fraction(b[1]) - Fraction(a[1]) * Fraction(b[0])
        assert value == -other and (value != 0 or a == b)
        assert exact == 0 or (exact > 0) == (value > 0)


def _plain(function):
    return getattr(function, "py_func", function)


# ---- what acts at a facet ----


def test_both_sides_of_an_open_mesh_count():
    """Two squares in one mesh, whose fronts face the same way: the lower front sees the upper back."""
    square = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    leaves = tp.Mesh(
        vertices=np.concatenate([square, square + (0, 0, 0.5)]),
        faces=[(0, 1, 2), (0, 2, 3), (4, 5, 6), (4, 6, 7)],
    )
    wall = tp.Surface(leaves, tp.Black(), name="wall")
    result = run(
        tp.Source("wall", tp.Lambertian(power=2.0)), wall, tp.Detector("wall", side="back"), particles=200_000
    )
    assert_agrees(result["wall"].flux_in, parallel_rectangles(1.0, 1.0, 0.5))


def test_a_convex_body_in_a_furnace_receives_the_same_everywhere():
    """E = pi L, however few its facets are: no error of the tessellation.  The sphere's area instead is rejected."""
    for mesh in (
        tp.Mesh.sphere(radius=1.0, triangles=20),
        tp.Mesh.box(size=(1, 0.1, 0.5)),
        bipyramid(9, 0.3),
    ):
        body = tp.Surface(turned(mesh), tp.Black(), name="body")
        room = tp.Surface(tp.Sphere(center=body.shape.middle, radius=1.5), tp.Black(), name="room")
        aim = tp.Sphere(center=body.shape.middle, radius=body.shape.extent)
        lamp = tp.Source("room", tp.Lambertian(radiance=1.0), side="inside", aim=aim)
        irradiance = run(lamp, [body, room], tp.Detector("body"), particles=200_000)["body"].irradiance
        assert_agrees(irradiance, math.pi)
        with pytest.raises(AssertionError):
            assert_agrees(irradiance * (mesh.area / (4 * math.pi)), math.pi)


def test_a_convex_mesh_emits_by_area_and_sees_nothing_of_itself():
    box, mesh = tp.Box(size=(1, 2, 3)), tp.Mesh.box(size=(1, 2, 3))
    room, seen = tp.Surface(tp.Sphere(radius=4.0), tp.Black(), name="room"), {}
    for shape in (box, mesh):
        body = tp.Surface(shape, tp.Black(), name="body")
        looks = [tp.Detector("body"), tp.Detector("room", side="inside", positions=tp.Positions(u=5, v=4))]
        seen[shape] = run(tp.Source("body", tp.Lambertian(power=1.0)), [body, room], looks, particles=200_000)
        assert seen[shape]["body"].counts.value == 0
    assert_agrees(seen[mesh]["room"].irradiance - seen[box]["room"].irradiance, 0.0)


def test_a_mesh_of_a_sphere_is_the_sphere():
    """Light of a lamp aside, reflected by a ball in a dark room, in bins of the room: mesh against analytic sphere."""
    lamp = tp.Source(tp.Point(position=(2, 1, 0.5)), tp.Isotropic(power=1.0))
    room, seen = tp.Surface(tp.Sphere(radius=4.0), tp.Black(), name="room"), {}
    for ball in (tp.Sphere(radius=1.0), tp.Mesh.sphere(radius=1.0, triangles=100_000)):
        body = tp.Surface(ball, tp.Diffuse(0.8), name="ball")
        looks = [tp.Detector("ball"), tp.Detector("room", side="inside", positions=tp.Positions(u=5, v=4))]
        seen[ball] = run(lamp, [body, room], looks, particles=200_000)
    exact, mesh = seen.values()
    assert_agrees(mesh["room"].irradiance - exact["room"].irradiance, 0.0)
    assert_agrees(mesh["ball"].flux_in - exact["ball"].flux_in, 0.0)


# ---- an edge does not flip the medium ----


@pytest.mark.parametrize("glass", [tp.Mesh.box(size=2.0), tp.Box(size=2.0)], ids=["mesh", "box"])
def test_a_plate_of_glass_transmits_alike_through_the_edges_of_its_facets(glass):
    """Beams through diagonals: T = 2 n / (n^2 + 1)."""
    lamps = [beam((x, x, 3), (x, x, 0)) for x in (-0.5, 0, 0.25, 0.75)]
    below = tp.Detector(tp.Disk(center=(0, 0, -2), radius=2), name="below")
    result = run(lamps, tp.Surface(glass, tp.Dielectric(1.5)), below, particles=200_000)
    assert_agrees(result["below"].flux_in / 4, 2 * 1.5 / (1 + 1.5**2))


WAYS = list(itertools.product((1, -1), repeat=3))


@pytest.mark.parametrize("kind", ["mesh", "faces"])
@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_light_leaves_a_box_of_glass_as_it_entered_but_for_signs(seed, kind):
    """A box of index above sqrt 2 sends light out only through the faces opposite to those by which it came in, or these, so
    the direction keeps its cosines but for signs.  A medium that is flipped at an edge would bend it elsewhere."""
    random = np.random.default_rng(seed)
    turn, shift = (np.eye(3), np.zeros(3)) if seed == 0 else (random_turn(random), random.normal(size=3))
    mesh = tp.Mesh.box(size=2.0)
    parts = [tp.Mesh(vertices=mesh.vertices @ turn.T + shift, faces=mesh.faces)]
    if kind == "faces":  # six rectangles, with their own way of telling media apart at edges
        parts = [
            tp.Rectangle(
                center=shift + turn @ n, normal=turn @ n, up=turn @ np.roll(n, 1), width=2.0, height=2.0
            )
            for axis, sign in itertools.product(range(3), (-1.0, 1.0))
            for n in [np.roll([sign, 0.0, 0.0], axis)]
        ]
    far = tp.Sphere(center=shift, radius=20.0)
    way = np.array([0.3, -0.4, math.sqrt(0.75)])
    places = [shift + turn @ place for place in edge_points(random)]
    lamps = [beam(place - 3 * turn @ way, place) for place in places]
    looks = [
        tp.Detector(
            far, name=str(signs), side="inside", directions=tp.Directions.cone(-turn @ (way * signs), 1e-6)
        )
        for signs in WAYS
    ]
    glass = [tp.Surface(part, tp.Dielectric(1.5)) for part in parts]
    result = run(lamps, glass, looks, particles=64 * len(lamps))
    cone = 4 * math.pi * math.sin(0.5e-6) ** 2
    kept = sum(float(np.sum(result[str(signs)].flux_density.value)) for signs in WAYS) * far.area * cone
    assert kept == pytest.approx(len(lamps), rel=1e-9)


def edge_points(random):
    """Points of the edges of a box of size 2, of its facets' diagonals, and its vertices."""
    for axis, sign, other, along in itertools.product(
        range(3), (-1, 1), (-1, 1), (0.3, random.uniform(-1, 1), 1)
    ):
        place = np.roll([sign, other, along], axis)
        yield place
        yield np.roll([sign, along, along], axis)


# ---- planted in the engine, as plain Python ----

PLAIN = """
import json
from transport.engine.passes import meshes
from transport.physics import facets
{plant}
import transport as tp
from tests.hard import test_meshes as hard
print(json.dumps(hard.{case}))
"""
PLANTS = {  # what is left out, and the case that shows it
    "the decision at 0": (
        "facets.edge_function = lambda px, py, qx, qy: px * qy - py * qx",
        "missed_by_rays()",
    ),
    "facets that join ahead": ("meshes.joins_ahead = lambda *them: False", "leaks('box')"),
    "distances by the plane": ("meshes.plane_distance = lambda t, *them: t", "leaks('plate')"),
    "places put back onto their facet": (
        "meshes.within_facet = lambda x, y, z, *them: (x, y, z)",
        "leaks('plate')",
    ),
    "the order by the fold": ("meshes.folds_back = lambda *them: False", "leaks_in('box')"),
}


@pytest.mark.parametrize("left_out", PLANTS)
def test_what_keeps_meshes_shut_is_needed(left_out):
    plant, case = PLANTS[left_out]
    assert plainly("", case) == 0
    assert plainly(plant, case) > 0


@functools.cache
def plainly(plant, case):
    """What a case gives in plain Python, with a fault planted before."""
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", PLAIN.format(plant=plant, case=case)],
        capture_output=True,
        text=True,
        cwd=ROOT,
        env=os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(ROOT)},
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def missed_by_rays():
    """Crossings that rays from above through vertices and edges of a lattice lack."""
    lamps = [beam((x, y, 9), (x, y, 8)) for x, y in PLACES]
    meter = run(lamps, (), tp.Detector(lattice(4), name="meter"), particles=98, batches=2)["meter"]
    return 98 - float(meter.flux_in.value) - float(meter.flux_out.value)


def leaks(name):
    """What beams into edges from inside lose [W]."""
    mesh = turned(BODIES[name]())
    return escaped(beams_from_inside(mesh), tp.Surface(mesh, tp.Diffuse(0.7)), particles=240, batches=2)


def leaks_in(name):
    """How many crossings of the inside beams into edges from outside make."""
    mesh = turned(BODIES[name]())
    wall = tp.Surface(mesh, tp.Black(), name="body")
    looks = tp.Detector("body", name="in", side="inside")
    return float(run(beams_from_outside(mesh), wall, looks, particles=120, batches=2)["in"].counts.value)
