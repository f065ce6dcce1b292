"""Closed meshes hold what is inside and keep out what is outside; every edge and vertex is crossed exactly once.

Bodies are narrow, sharp, thin, with crowded vertices; turned and shifted, so that no coordinate is round, but where rays are to meet
edges and vertices exactly.  Naive ways leak: facets that do not quite share their vertices, edge functions without the decision at 0
(planted below).
"""

from __future__ import annotations

import functools
import json
import math
import os
import subprocess
import sys
from fractions import Fraction
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import transport as tp
from tests.agreement import assert_agrees
from tests.slow import quick
from transport.physics import facets
from transport.theory.view_factors import parallel_rectangles

ROOT = Path(__file__).resolve().parents[2]


# ---- bodies, and beams into their edges and vertices ----


def _ring(angles, radii, height):
    return np.stack([radii * np.cos(angles), radii * np.sin(angles), 0 * angles + height], axis=1)


def turned(mesh, seed=1, shift=0.3):
    """The mesh turned and shifted at random, so that no coordinate is round."""
    random = np.random.default_rng(seed)
    return placed(mesh, random_turn(random), shift * random.normal(size=3))


def placed(mesh, turn, shift):
    return tp.Mesh(vertices=mesh.vertices @ turn.T + shift, faces=mesh.faces)


def random_turn(random):
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    return turn * np.sign(np.linalg.det(turn))


def bipyramid(sides, height):
    """Two vertices that each join as many triangles as there are sides."""
    i, j = np.arange(sides), np.roll(np.arange(sides), -1)
    top, bottom = np.full(sides, sides), np.full(sides, sides + 1)
    ring = _ring(2 * np.pi * i / sides, 1.0, 0.0)
    faces = np.concatenate([np.stack([i, j, top], axis=1), np.stack([j, i, bottom], axis=1)])
    return tp.Mesh(vertices=np.concatenate([ring, [(0, 0, height), (0, 0, -height)]]), faces=faces)


def prism(angles, radii=1.0, height=1.0):
    """An upright prism over corners at these azimuths and radii, its floor and ceiling fans about their middles."""
    n = len(angles)
    i, j = np.arange(n), np.roll(np.arange(n), -1)
    bottom, top = np.full(n, 2 * n), np.full(n, 2 * n + 1)
    sides = ((i, j, i + n), (j, j + n, i + n), (j, i, bottom), (i + n, j + n, top))
    floor = _ring(angles, radii, -height / 2)
    middles = [(0, 0, -height / 2), (0, 0, height / 2)]
    vertices = np.concatenate([floor, floor + (0, 0, height), middles])
    return tp.Mesh(vertices=vertices, faces=np.concatenate([np.stack(face, axis=1) for face in sides]))


def needles(aspect):
    """A prism of a hundred sides, half of which are crowded and as narrow as that."""
    return prism(np.concatenate([0.3 + np.arange(50) / aspect, np.linspace(0.5, 6.3, 50)]))


def star(points, inner):
    """A prism over a star: every other corner lies at the inner radius."""
    corners = np.arange(2 * points)
    return prism(np.pi * corners / points, np.where(corners % 2, inner, 1.0), 0.6)


def wedge(angle):
    """A prism over a triangle with a sharp corner, without middles."""
    corners = np.array([(0, 0), (1, 0), (np.cos(angle), np.sin(angle))])
    vertices = np.concatenate([np.insert(corners, 2, z, axis=1) for z in (0.0, 1.0)])
    faces = [(0, 2, 1), (3, 4, 5), (0, 1, 4), (0, 4, 3), (1, 2, 5), (1, 5, 4), (2, 0, 3), (2, 3, 5)]
    return tp.Mesh(vertices=vertices, faces=faces)


def lattice(n):
    """A cube [0, n]^3 each face of which is n x n squares, cut along alternating diagonals: whole coordinates."""
    i, j = (index.ravel() for index in np.meshgrid(range(n), range(n), indexing="ij"))
    squares = np.stack(
        [np.stack([i + a, j + b], axis=1) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))], axis=1
    )
    odd = (i + j) % 2 == 1
    squares[odd] = np.roll(squares[odd], 1, axis=1)
    flat = np.concatenate([squares[:, (0, 1, 2)], squares[:, (0, 2, 3)]])
    sides = []
    for axis in range(3):
        for place in (0, n):
            side = np.full((*flat.shape[:2], 3), float(place))
            side[..., (axis + 1) % 3], side[..., (axis + 2) % 3] = flat[..., 0], flat[..., 1]
            sides.append(side if place else side[:, ::-1])
    corners = np.concatenate(sides).reshape(-1, 3)
    return tp.Mesh(vertices=corners, faces=np.arange(len(corners)).reshape(-1, 3)).merged()


def joined(*meshes):
    """Several meshes as one."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    return tp.Mesh(vertices=np.concatenate([m.vertices for m in meshes]), faces=np.concatenate(faces))


def cracked(mesh):
    """The fault: every triangle with vertices of its own, an ulp or two beside those of its neighbours."""
    corners = mesh.vertices[mesh.faces].reshape(-1, 3)
    noise = np.random.default_rng(1).integers(-2, 3, corners.shape) * 2.0**-52 * np.abs(corners).max()
    return tp.Mesh(vertices=corners + noise, faces=np.arange(len(corners)).reshape(-1, 3))


def targets(mesh, random, number):
    """Points of edges, a third of them vertices."""
    a, b, c = mesh.faces.T
    edges = np.concatenate([np.stack(ends, axis=1) for ends in ((a, b), (b, c), (c, a))])
    ends = mesh.vertices[edges[random.integers(len(edges), size=number)]]
    share = random.uniform(size=(number, 1))
    share[::3] = 0
    return (1 - share) * ends[:, 0] + share * ends[:, 1]


def beams_from_inside(mesh, number=60, seed=2):
    """Beams of 1 W from a point near the middle of a body that is seen whole from there."""
    random = np.random.default_rng(seed)
    middle = mesh.vertices.mean(axis=0)
    start = middle + 0.002 * (random.dirichlet(np.ones(len(mesh.vertices))) @ mesh.vertices - middle)
    return [beam(start, place) for place in targets(mesh, random, number)]


def beams_from_outside(mesh, number=60, seed=3):
    """Beams of 1 W from all round, most of them to edges that they see from aside or not at all."""
    random = np.random.default_rng(seed)
    ways = random.normal(size=(number, 3))
    starts = mesh.middle + 1.8 * mesh.extent * ways / np.linalg.norm(ways, axis=1)[:, None]
    return [beam(start, place) for start, place in zip(starts, targets(mesh, random, number), strict=True)]


def beam(start, target):
    return tp.Source(tp.Point(position=start), tp.Beam(np.subtract(target, start), power=1.0))


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
QUICK = "80 triangles", "thin plate", "sharp wedge", "star"
bodies = pytest.mark.parametrize("make", quick(BODIES.values(), *map(BODIES.get, QUICK)), ids=BODIES)


def run(sources, surfaces=(), detectors=(), particles=2000, batches=32):
    scene = tp.Scene(sources, surfaces, detectors)
    result = tp.simulate(scene, particles=particles, seed=1, batches=batches, progress=False)
    assert result.ledger["lost"].value == 0
    return result


def escaped(*scene, **how):
    return float(run(*scene, **how).ledger["escaped"].value)


def leaked(mesh, material=tp.Diffuse(0.7), **how):  # noqa: B008 (frozen)
    """What beams into edges from inside lose [W]."""
    return escaped(beams_from_inside(mesh), tp.Surface(mesh, material), **({"particles": 6000} | how))


# ---- nothing leaks ----


@bodies
@pytest.mark.parametrize(
    "material",
    quick([tp.Diffuse(0.9), tp.Mirror(0.9), tp.Black()], tp.Mirror(0.9)),
    ids=["diffuse", "mirror", "black"],
)
def test_a_closed_mesh_holds_what_it_emits_inwards(make, material):
    wall = tp.Surface(turned(make()), material, name="wall")
    assert escaped(tp.Source("wall", tp.Lambertian(power=1.0), side="back"), wall) == 0


@bodies
def test_a_mesh_inside_out_holds_what_it_emits_from_its_front(make):
    wall = tp.Surface(turned(make()).flipped(), tp.Diffuse(0.9), name="wall")
    assert escaped(tp.Source("wall", tp.Lambertian(power=1.0)), wall) == 0


@bodies
def test_beams_into_edges_and_vertices_stay_on_their_side(make):
    for shift in (0.3, 10):
        assert leaked(turned(make(), shift=shift)) == 0
    mesh = turned(make())
    walls = [
        tp.Surface(mesh, tp.Diffuse(0.7), name="body"),
        tp.Surface(tp.Sphere(center=mesh.middle, radius=2 * mesh.extent), tp.Diffuse(0.5)),
    ]
    inside = tp.Detector("body", name="in", side="inside")
    result = run(beams_from_outside(mesh), walls, inside, particles=6000)
    assert result["in"].counts.value == 0 and result.ledger["escaped"].value == 0


def test_facets_that_do_not_share_their_vertices_leak():
    """Planted: cracks of an ulp."""
    for name in ("box", "80 triangles"):
        assert leaked(cracked(turned(BODIES[name]())), tp.Black()) > 0.5


CLOSED = {
    f"{n} triangles": lambda n=n: tp.Mesh.sphere(radius=1.0, triangles=n) for n in (1280, 20_000, 100_000)
}
CLOSED["two that overlap"] = lambda: joined(  # light within both meets the back of either
    tp.Mesh.box(size=2.0), tp.Mesh.box(center=(1, 0.9, 0.8), size=(2.1, 2.2, 2.3))
)


@pytest.mark.quick_cases("1280 triangles", "two that overlap")
@pytest.mark.parametrize("make", CLOSED.values(), ids=CLOSED)
def test_fine_spheres_and_overlapping_bodies_hold_many_particles(make):
    wall = tp.Surface(turned(make()), tp.Diffuse(0.9), name="wall")
    assert escaped(tp.Source("wall", tp.Lambertian(power=1.0), side="back"), wall, particles=20_000) == 0


def test_light_in_a_cavity_stays_there():
    spheres = [tp.Mesh.sphere(radius=radius, triangles=320) for radius in (1.0, 0.9)]
    wall = tp.Surface(turned(joined(spheres[0], spheres[1].flipped())), tp.Diffuse(0.9), name="wall")
    lamp = tp.Source(tp.Point(position=wall.shape.middle), tp.Isotropic(power=1.0))
    result = run(lamp, wall, tp.Detector("wall", name="in", side="inside"))
    assert result["in"].counts.value == 0 and result.ledger["escaped"].value == 0


# ---- edges and vertices are crossed once ----

# vertices, points of edges, of diagonals, of facets
PLACES = [(x / 2, y / 2) for x in range(1, 8) for y in range(1, 8)]


def crossed(mesh, lamps):
    """Beams that enter and that leave a mesh which they can pass."""
    meter = run(lamps, (), tp.Detector(mesh, name="meter"), particles=32 * len(lamps))["meter"]
    return meter.flux_in.value, meter.flux_out.value


@pytest.mark.slow
@pytest.mark.parametrize(
    ("offset", "start", "way", "entries"),
    [
        ((0, 0, 0), 9, -1, 49),
        ((0.1, 0.7, -0.3), -5, 1, 49),
        ((0, 0, 0), 2.5, 1, 0),
        ((0.1, 0.7, -0.3), 1.5, -1, 0),
    ],
)
def test_rays_through_vertices_and_edges_cross_exactly_once(offset, start, way, entries):
    mesh = lattice(4).moved(offset)
    lamps = [beam(np.add((x, y, start), offset), np.add((x, y, start + way), offset)) for x, y in PLACES]
    assert crossed(mesh, lamps) == (entries, 49)
    sides = [tp.Detector("wall", name=side, side=side) for side in ("outside", "inside")]
    result = run(lamps, tp.Surface(mesh, tp.Black(), name="wall"), sides, particles=32 * 49)
    assert (result["outside"].flux_in.value, result["inside"].flux_in.value) == (entries, 49 - entries)


@pytest.mark.parametrize(
    "place", [(0, 0), (0, 4), (4, 4), (0, 2), (0, 1.5), (4, 3), (2, 0), (2, 4), (3.5, 4)]
)
def test_rays_along_a_side_go_in_as_often_as_out(place):
    """They lie in the planes of facets, along edges."""
    into, out_of = crossed(lattice(4), [beam((*place, 9), (*place, 8))])
    assert into == out_of in (0, 1)


@bodies
def test_beams_into_edges_cross_a_detector_in_pairs_from_outside_and_once_more_from_inside(make):
    mesh = turned(make())
    for lamps, are_within in ((beams_from_outside(mesh), False), (beams_from_inside(mesh), True)):
        for some in (lamps, lamps[::7]):
            into, out_of = crossed(mesh, some)
            assert out_of - into == (len(some) if are_within else 0)


@pytest.mark.parametrize("shape", ["star", "sharp star"])
def test_beams_into_vertices_where_edges_are_convex_and_concave_stay_outside(shape):
    """Several facets are crossed at one place there, and no two of them need share an edge."""
    mesh, random = turned(BODIES[shape]()), np.random.default_rng(5)
    ways = random.normal(size=(40, len(mesh.vertices), 3))
    starts = mesh.middle + 1.8 * mesh.extent * ways / np.linalg.norm(ways, axis=2)[..., None]
    lamps = [beam(*each) for some in starts for each in zip(some, mesh.vertices, strict=True)]
    inside = tp.Detector("body", name="in", side="inside")
    result = run(lamps, tp.Surface(mesh, tp.Black(), name="body"), inside, particles=32 * len(lamps))
    assert result["in"].counts.value == 0


numbers = st.floats(-2, 2, allow_subnormal=False).map(lambda x: x if abs(x) > 1e-70 else 0.0)
corners = st.tuples(numbers, numbers)


@settings(deadline=None)
@given(corners, corners)
def test_the_side_of_an_edge_is_exact_and_opposite_from_its_other_facet(p, q):
    edge_function = getattr(facets.edge_function, "py_func", facets.edge_function)
    for a, b in ((p, q), (p, (1.1 * p[0], 1.1 * p[1])), (p, (p[0] / 3, p[1] / 3)), (p, p[::-1])):
        value, other = edge_function(*a, *b), edge_function(*b, *a)
        exact = Fraction(a[0]) * Fraction(b[1]) - Fraction(a[1]) * Fraction(b[0])
        assert value == -other and (value != 0 or a == b)
        assert exact == 0 or (exact > 0) == (value > 0)


# ---- emission, irradiance and refraction at facets ----


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


@pytest.mark.parametrize(
    "mesh", [tp.Mesh.sphere(radius=1.0, triangles=20), tp.Mesh.box(size=(1, 0.1, 0.5)), bipyramid(9, 0.3)]
)
def test_a_convex_body_in_a_furnace_receives_the_same_everywhere(mesh):
    """E = pi L, however few its facets are: no error of the tessellation.  The sphere's area instead is rejected."""
    body = tp.Surface(turned(mesh), tp.Black(), name="body")
    room = tp.Surface(tp.Sphere(center=body.shape.middle, radius=1.5), tp.Black(), name="room")
    aim = tp.Sphere(center=body.shape.middle, radius=body.shape.extent)
    lamp = tp.Source("room", tp.Lambertian(radiance=1.0), side="inside", aim=aim)
    irradiance = run(lamp, [body, room], tp.Detector("body"), particles=200_000)["body"].irradiance
    assert_agrees(irradiance, math.pi)
    with pytest.raises(AssertionError):
        assert_agrees(irradiance * (mesh.area / (4 * math.pi)), math.pi)


LAMP = tp.Source(tp.Point(position=(2, 1, 0.5)), tp.Isotropic(power=1.0))
BY_AREA = tp.Source("body", tp.Lambertian(power=1.0))
SPHERES = tp.Sphere(radius=1.0), tp.Mesh.sphere(radius=1.0, triangles=100_000)


@pytest.mark.parametrize(
    ("shapes", "material", "lamp"),
    [
        ((tp.Box(size=(1, 2, 3)), tp.Mesh.box(size=(1, 2, 3))), tp.Black(), BY_AREA),
        (SPHERES, tp.Diffuse(0.8), LAMP),
    ],
    ids=["a box emits by area and sees nothing of itself", "a sphere reflects a lamp aside"],
)
def test_a_mesh_lights_a_dark_room_as_the_shape_that_it_is_made_of(shapes, material, lamp):
    """In bins of the room."""
    room = tp.Surface(tp.Sphere(radius=4.0), tp.Black(), name="room")
    looks = [tp.Detector("body"), tp.Detector("room", side="inside", positions=tp.Positions(u=5, v=4))]
    exact, mesh = (
        run(lamp, [tp.Surface(s, material, "body"), room], looks, particles=200_000) for s in shapes
    )
    assert_agrees(mesh["room"].irradiance - exact["room"].irradiance, 0.0)
    if lamp is LAMP:
        assert_agrees(mesh["body"].flux_in - exact["body"].flux_in, 0.0)
    else:
        assert mesh["body"].counts.value == exact["body"].counts.value == 0


@pytest.mark.quick_cases("box")
@pytest.mark.parametrize("glass", [tp.Mesh.box(size=2.0), tp.Box(size=2.0)], ids=["mesh", "box"])
def test_a_plate_of_glass_transmits_alike_through_the_edges_of_its_facets(glass):
    """Beams through diagonals: T = 2 n / (n^2 + 1)."""
    lamps = [beam((x, x, 3), (x, x, 0)) for x in (-0.5, 0, 0.25, 0.75)]
    below = tp.Detector(tp.Disk(center=(0, 0, -2), radius=2), name="below")
    result = run(lamps, tp.Surface(glass, tp.Dielectric(1.5)), below, particles=200_000)
    assert_agrees(result["below"].flux_in / 4, 2 * 1.5 / (1 + 1.5**2))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["mesh", "faces"])
@pytest.mark.parametrize("seed", [0, 1])
def test_light_leaves_a_box_of_glass_as_it_entered_but_for_signs(seed, kind):
    """A box of index above sqrt 2 sends light out only through the faces opposite to those by which it came in, or these, so
    the direction keeps its cosines but for signs.  A medium that is flipped at an edge would bend it elsewhere."""
    random = np.random.default_rng(seed)
    turn, shift = (np.eye(3), np.zeros(3)) if seed == 0 else (random_turn(random), random.normal(size=3))
    parts = [placed(tp.Mesh.box(size=2.0), turn, shift)]
    if kind == "faces":  # six rectangles, with their own way of telling media apart at edges
        normals = [np.roll([sign, 0.0, 0.0], axis) for axis, sign in product(range(3), (-1.0, 1.0))]
        flat = [{"center": shift + turn @ n, "normal": turn @ n, "up": turn @ np.roll(n, 1)} for n in normals]
        parts = [tp.Rectangle(**each, width=2.0, height=2.0) for each in flat]
    way = np.array([0.3, -0.4, math.sqrt(0.75)])
    places = [shift + turn @ place for place in edge_points(random)]
    lamps = [beam(place - 3 * turn @ way, place) for place in places]
    far = tp.Sphere(center=shift, radius=20.0)
    cones = [tp.Directions.cone(-turn @ (way * signs), 1e-6) for signs in product((1, -1), repeat=3)]
    looks = [tp.Detector(far, name=f"{k}", side="inside", directions=cone) for k, cone in enumerate(cones)]
    glass = [tp.Surface(part, tp.Dielectric(1.5)) for part in parts]
    result = run(lamps, glass, looks, particles=64 * len(lamps))
    solid_angle = 4 * math.pi * math.sin(0.5e-6) ** 2
    kept = sum(float(np.sum(result[look.name].flux_density.value)) for look in looks) * far.area * solid_angle
    assert kept == pytest.approx(len(lamps), rel=1e-9)


def edge_points(random):
    """Points of the edges of a box of size 2, of its facets' diagonals, and its vertices."""
    for axis, sign, other, along in product(range(3), (-1, 1), (-1, 1), (0.3, random.uniform(-1, 1), 1)):
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
from tests.hard import test_hard_meshes as hard
print(json.dumps(hard.{case}))
"""
LEAKS = "leaked(hard.turned(hard.BODIES['{}']()), particles=240, batches=2)"
PLANTS = {  # what is left out, and the case that shows it
    "the decision at 0": (
        "facets.edge_function = lambda px, py, qx, qy: px * qy - py * qx",
        "missed_by_rays()",
    ),
    "facets that join ahead": ("meshes.joins_ahead = lambda *them: False", LEAKS.format("box")),
    "distances by the plane": (
        "meshes.plane_distance = lambda u, v, w, a, b, c, *them: (u * a + v * b + w * c) / (u + v + w)",
        LEAKS.format("plate"),
    ),
    "places put back onto their facet": (
        "meshes.within_facet = lambda x, y, z, *them: (x, y, z)",
        LEAKS.format("plate"),
    ),
    "the order by the fold": ("meshes.lies_behind = lambda *them: False", "leaks_in('box')"),
}


@pytest.mark.slow
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


def leaks_in(name):
    """How many crossings of the inside beams into edges from outside make."""
    mesh = turned(BODIES[name]())
    wall, look = tp.Surface(mesh, tp.Black(), name="body"), tp.Detector("body", name="in", side="inside")
    return float(run(beams_from_outside(mesh), wall, look, particles=120, batches=2)["in"].counts.value)
