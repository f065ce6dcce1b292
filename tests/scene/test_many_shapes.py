"""Scenes of very many shapes: each is compared with the few that may be near it, and none of these is missed."""

import math
import random

import numpy as np
import pytest

import transport as tp
from transport.compile.compiler import compile_scene
from transport.geometry import contacts, neighbours
from transport.geometry.neighbours import Supports, touching_boxes
from transport.geometry.relations import are_on_one_support
from transport.scene import sheets

LAMP = tp.Source(tp.Point(position=(0.5, 0.5, 0.5)), tp.Isotropic(power=1.0))
METER = tp.Detector(tp.Rectangle(center=(0, 0, -2), width=9, height=9), "meter")


def turned(k):
    """A direction of its own for each number."""
    return math.sin(k), math.cos(3 * k), math.sin(5 * k) + 0.1


KINDS = {
    "spheres": lambda place, k: tp.Sphere(center=place, radius=0.2),
    "disks": lambda place, k: tp.Disk(center=place, normal=turned(k), radius=0.2),
    "tubes": lambda place, k: tp.Cylinder(center=place, axis=turned(k), radius=0.1, height=0.3),
}


def lattice(kind, count):
    """A scene of so many shapes that do not touch, each on a sheet of its own, and a detector."""
    side = math.ceil(count ** (1 / 3))
    places = ((k % side, k // side % side, k // side**2) for k in range(count))
    shapes = [KINDS[kind](place, k) for k, place in enumerate(places)]
    return tp.Scene(LAMP, [tp.Surface(shape, tp.Diffuse(0.5)) for shape in shapes], METER)


def counted(monkeypatch, module, name):
    """The list of the calls of a function."""
    calls, called = [], getattr(module, name)
    monkeypatch.setattr(module, name, lambda *given: calls.append(given) or called(*given))
    return calls


@pytest.mark.parametrize("kind", KINDS)
def test_shapes_that_are_apart_are_not_compared(kind, monkeypatch):
    """The number of pairs compared grows with the number of shapes, not with its square."""
    pairs = [counted(monkeypatch, sheets, "are_on_one_support"), counted(monkeypatch, contacts, "touches")]
    pairs.append(counted(monkeypatch, sheets, "overlap"))
    assert len(compile_scene(lattice(kind, 1000)).sheets) == 1 + 1000 + 1
    assert sum(map(len, pairs)) < 100


def test_patches_of_one_wall_are_compared_with_their_neighbours(monkeypatch):
    pairs = counted(monkeypatch, sheets, "overlap")
    patches = [tp.Rectangle(center=(k % 30, k // 30, 0), width=1, height=1) for k in range(900)]
    scene = tp.Scene(LAMP, [tp.Surface(patch, tp.Black()) for patch in patches])
    assert len(compile_scene(scene).sheets) == 1 + 1
    assert len(pairs) == 2 * 30 * 29 + 2 * 29 * 29  # neighbours along a side and across a corner


def test_an_overlap_among_many_is_refused():
    disks = [tp.Disk(center=(k, 0, 0), radius=0.4) for k in range(100)]
    disks.append(tp.Disk(center=(70.7, 0, 0), radius=0.4))
    with pytest.raises(tp.SceneError, match=r"surfaces\[70\] and surfaces\[100\] overlap on one plane"):
        tp.Scene(LAMP, [tp.Surface(disk, tp.Black()) for disk in disks])


def pairs_on_one_support(draws):
    """Shapes of each kind in pairs that share a support but for rounding, at random places and scales."""
    for _ in range(300):
        scale = 10.0 ** draws.uniform(-3, 3)
        place = np.array([draws.gauss(0, 1) for _ in range(3)]) * scale
        normal = np.array([draws.gauss(0, 1) for _ in range(3)])
        normal = draws.choice([normal, np.array((0.0, 1.0, 0.0)), np.array((1.0, 1.0, 0.0))])
        disk = tp.Disk(center=place, normal=normal, radius=scale)
        e_u, e_v, unit = np.array(disk.frame)
        spread = [draws.uniform(-1, 1) * scale for _ in range(6)]
        moved = tp.Disk(
            center=place + spread[0] * e_u + spread[1] * e_v, normal=-7 * normal, radius=scale / 50
        )
        corners = [place + spread[k] * e_u + spread[k + 1] * e_v for k in (0, 2, 4)]
        yield disk, moved
        yield disk, tp.Triangle(vertices=corners)
        yield tuple(
            tp.Cylinder(center=place + w * unit, axis=s * unit, radius=scale, height=h * scale)
            for w, s, h in ((0, 1, 1.0), (spread[0], -3, 0.02))
        )
        yield tuple(tp.Sphere(center=place, axis=axis, radius=scale, mu_min=0.5) for axis in (unit, e_u))


def test_no_shared_support_is_missed(monkeypatch):
    """Neither beside one another nor among shapes of other sizes, nor where two cells of the grid meet."""
    found = [pair for pair in pairs_on_one_support(random.Random(1)) if are_on_one_support(*pair)]
    assert len(found) > 1000
    among_all = Supports([shape for pair in found for shape in pair])
    for number, (one, _) in enumerate(found):
        among_all.add(number, one)
    for number, (_, other) in enumerate(found):
        assert number in among_all.near(other)
    for one, other in found[::5]:
        for coordinate in Supports((one, other)).coordinates(one)[1]:
            alone = Supports((one, other))
            monkeypatch.setattr(neighbours, "OFFSET", -coordinate / (neighbours.CELL * alone.tolerance))
            alone.add(0, one)
            assert alone.near(other) == [0]


def test_touching_boxes_are_those_that_a_comparison_of_all_finds():
    draws = np.random.default_rng(1)
    low = draws.integers(0, 8, (200, 3)).astype(float)
    high = low + draws.integers(0, 3, (200, 3))
    low[0], high[0], low[1, 2], high[1, 2] = -np.inf, np.inf, -np.inf, np.inf
    meet = ((low[:, None] <= high) & (low <= high[:, None])).all(axis=2)
    np.fill_diagonal(meet, False)
    for row, near in zip(meet, touching_boxes(low, high), strict=True):
        assert near.tolist() == np.flatnonzero(row).tolist()
    assert touching_boxes(low[:0], high[:0]) == [] and touching_boxes(low[:1], high[:1])[0].size == 0


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["spheres", "disks"])
def test_forty_thousand_sheets_compile_and_run(kind):
    scene = lattice(kind, 40_000)
    assert len(compile_scene(scene).sheets) == 1 + 40_000 + 1
    result = tp.simulate(scene, particles=1000, seed=1, progress=False)
    assert result.particles == 1000 and result.ledger["lost"].value == 0
