"""Closed meshes hold what is inside and keep out what is outside; edges and vertices are crossed exactly once.

Coordinates are turned and shifted at random, so that none is round, but where rays are to meet edges and vertices exactly:
there coordinates are small whole numbers, of which all sums are exact.
"""

import sys

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from transport.compile import compiler as compiling
from transport.compile import meshes as tables

simulating = sys.modules[tp.simulate.__module__]


@pytest.fixture(autouse=True)
def compiled_anew():
    """Scenes are compiled once; a planted fault must not meet or leave a plan of before."""
    for step in ("before", "after"):
        compiling.compile_scene.cache_clear()
        simulating._program.cache_clear()
        if step == "before":
            yield


def run(scene, particles=20_000, seed=1):
    result = tp.simulate(scene, particles=particles, seed=seed, progress=False)
    assert result.ledger["lost"].value == 0
    return result


# ---- meshes that are hard to close ----


def turned(mesh, seed=1, shift=0.3):
    random = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    return tp.Mesh(vertices=mesh.vertices @ turn + shift * random.normal(size=3), faces=mesh.faces)


def bipyramid(sides, height):
    """Two vertices that each join as many triangles as there are sides."""
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    i, j = np.arange(sides), np.roll(np.arange(sides), -1)
    top, bottom = np.full(sides, sides), np.full(sides, sides + 1)
    faces = np.concatenate([np.stack([i, j, top], axis=1), np.stack([j, i, bottom], axis=1)])
    return tp.Mesh(vertices=np.concatenate([ring, [(0, 0, height), (0, 0, -height)]]), faces=faces)


def needles(aspect):
    """A prism of unit height whose side is triangles as narrow as that, between fans over a ring of 100 vertices, of which 50 crowd together."""
    crowd = 0.3 + np.arange(50) / aspect
    angle = np.concatenate([crowd, np.linspace(0.5, 6.3, 50)])
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle - 0.5], axis=1)
    n = len(ring)
    i, j = np.arange(n), np.roll(np.arange(n), -1)
    up, bottom, top = n, np.full(n, 2 * n), np.full(n, 2 * n + 1)
    sides = [np.stack(face, axis=1) for face in ((i, j, i + up), (j, j + up, i + up), (j, i, bottom), (i + up, j + up, top))]
    vertices = np.concatenate([ring, ring + (0, 0, 1), [(0, 0, -0.5), (0, 0, 0.5)]])
    return tp.Mesh(vertices=vertices, faces=np.concatenate(sides))


MESHES = {
    "80 triangles": lambda: tp.Mesh.sphere(radius=1.0, triangles=80),
    "1280 triangles": lambda: tp.Mesh.sphere(radius=1.0, triangles=1280),
    "100 000 triangles": lambda: tp.Mesh.sphere(radius=1.0, triangles=100_000),
    "box": lambda: tp.Mesh.box(size=(1, 2, 3)),
    "long box": lambda: tp.Mesh.box(size=(1, 1e-3, 1e-3)),
    "plate": lambda: tp.Mesh.box(size=(1, 1, 1e-5)),
    "thin plate": lambda: tp.Mesh.box(size=(1, 1, 1e-8)),
    "thinner plate": lambda: tp.Mesh.box(size=(1, 1, 1e-12)),
    "vertex of 1000": lambda: bipyramid(1000, 1.0),
    "flat vertex of 1000": lambda: bipyramid(1000, 1e-4),
    "needles": lambda: needles(1e8),
}


@pytest.fixture(params=MESHES.values(), ids=MESHES)
def closed(request):
    mesh = turned(request.param())
    assert mesh.is_closed
    return mesh


def test_what_leaves_the_inside_of_a_closed_mesh_stays_there(closed):
    wall = tp.Surface(closed, tp.Diffuse(0.9), name="wall")
    result = run(tp.Scene([tp.Source("wall", tp.Lambertian(power=1.0), side="back")], wall))
    assert result.ledger["escaped"].value == 0


def test_a_point_inside_a_closed_mesh_sees_no_gap(closed):
    wall = tp.Surface(closed, tp.Black(), name="wall")
    inside = tp.Source(tp.Point(position=closed.vertices.mean(axis=0)), tp.Isotropic(power=1.0))
    result = run(tp.Scene([inside], wall, tp.Detector("wall", name="inside", side="inside")))
    assert result.ledger["escaped"].value == 0
    assert_agrees(result["inside"].flux_in, 1.0)


def test_inside_out_it_holds_as_well(closed):
    wall = tp.Surface(closed.flipped(), tp.Diffuse(0.9), name="wall")
    result = run(tp.Scene([tp.Source("wall", tp.Lambertian(power=1.0), side="front")], wall))
    assert result.ledger["escaped"].value == 0


def test_mirrors_hold_what_they_reflect(closed):
    wall = tp.Surface(closed, tp.Mirror(0.95), name="wall")
    result = run(tp.Scene([tp.Source("wall", tp.Lambertian(power=1.0), side="back")], wall))
    assert result.ledger["escaped"].value == 0


def test_nothing_gets_into_a_closed_mesh(closed):
    """In a furnace: isotropic light from all round, and what arrives at the inside is counted."""
    room = tp.Sphere(center=closed.middle, radius=1.5 * closed.extent)
    walls = [tp.Surface(closed, tp.Diffuse(0.5), name="body"), tp.Surface(room, tp.Diffuse(0.5), name="room")]
    lamp = tp.Source("room", tp.Lambertian(power=1.0), side="inside", aim=tp.Sphere(center=closed.middle, radius=closed.extent))
    result = run(tp.Scene([lamp], walls, tp.Detector("body", name="inside", side="inside")))
    assert result["inside"].counts.value == 0 and result.ledger["escaped"].value == 0


def test_a_convex_body_in_a_furnace_receives_the_same_everywhere():
    """E = pi L on each facet, however few they are: no error of the tessellation."""
