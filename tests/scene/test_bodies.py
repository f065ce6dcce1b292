"""Bodies of media: which there are and which of them hold a place; which go together; what closes a body of open surfaces."""

from __future__ import annotations

import math
import re
import time
from functools import partial
from typing import NamedTuple

import numpy as np
import pytest

import transport as tp
from tests.refusals import assert_refused
from tests.slow import quick
from transport.geometry.shape import Shape
from transport.scene.bodies import (
    bodies_on_sides,
    body_bits_at,
    has_media,
    media_at,
    points_below_surface,
    points_in_body,
    scene_bodies,
    scene_media,
)

T, M, V = tp.Transparent(), tp.Medium, tp.Vacuum()
LAMP = tp.Source(tp.Point(position=(1, 1.1, 1.2)), tp.Isotropic(power=1))
AFAR = tp.Source(tp.Point(position=(1, 1.1, 500)), tp.Isotropic(power=1))
PARTICLES = tp.Source(tp.Point(), tp.Gas(number=1, speed=1))
near, afar = partial(tp.Scene, LAMP), partial(tp.Scene, AFAR)
GRID = tp.Grid(box=tp.Box(size=2), scattering=np.arange(24.0).reshape(2, 3, 4))


def filled(shape: Shape, medium, material=T, **named):
    return tp.Surface(shape, material, inside=medium, **named)


def corner(size):
    """A cube with a corner in the origin."""
    return tp.Box(center=(size / 2,) * 3, size=size)


def can(medium, material=T, center=(0, 0, 0), radius=1.0, outside=None):
    """A cylinder with two lids, of which the lower one looks down."""
    x, y, z = center
    rim = tp.Cylinder(center=center, radius=radius, height=2 * radius)
    lids = [tp.Disk(center=(x, y, z + s * radius), normal=(0, 0, s), radius=radius) for s in (1, -1)]
    return [tp.Surface(shape, material, inside=medium, outside=outside) for shape in (rim, *lids)]


def cap_and_disk(medium, material):
    """Half a ball and its flat side, on z = 0.9 of the unit sphere."""
    flat = tp.Disk(center=(0, 0, 0.9), normal=(0, 0, -1), radius=math.sqrt(1 - 0.81))
    return [tp.Surface(s, material, inside=medium) for s in (tp.Sphere(radius=1, mu_min=0.9), flat)]


def stack(thicknesses, unit=1.0, shift=0.0):
    """Slabs on one another, each of its own medium, from z = shift downwards."""
    z, surfaces = shift, []
    for k, thickness in enumerate(np.array(thicknesses) * unit):
        shape = tp.Slab(center=(0, 0, z - thickness / 2), thickness=thickness)
        surfaces.append(filled(shape, M((k + 1) / unit)))
        z -= thickness
    return surfaces


# ---- which bodies there are ----


def test_nested_boxes_that_share_faces():
    """The cubes of (0, 10), (0, 50) and (0, 100) m: the innermost counts, in whatever order they are written."""
    sizes = {10.0: M(1), 50.0: V, 100.0: M(3)}
    for order in ((10, 50, 100), (100, 50, 10), (50, 100, 10)):
        scene = near([filled(corner(size), sizes[size]) for size in order])
        assert [body.medium for body in scene_bodies(scene)] == [M(1), V, M(3)]
        sizes_of = [scene.surfaces[body.surfaces[0]].shape.size[0] for body in scene_bodies(scene)]
        assert sizes_of == [10, 50, 100]
        for x, medium, bits in ((5, M(1), 7), (20, V, 6), (70, M(3), 4), (101, V, 0), (-1, V, 0)):
            assert scene.medium_at((x, 5, 5)) == medium
            assert body_bits_at(scene, [(x, 5, 5)]).tolist() == [bits]
        assert set(scene_media(scene)) == {V, M(1), M(3)} and scene_media(scene)[0] == V
        shared = [(0.0, 5, 5)] * 2
        assert body_bits_at(scene, shared, [(1, 0, 0), (-1, 0, 0)]).tolist() == [7, 0]


def test_a_body_of_open_surfaces_with_a_bubble_and_a_twin():
    """Two cans of one medium are two bodies; one holds a bubble, a third can, whose walls name vacuum."""
    glass = M(index=1.5)
    wall = tp.Dielectric(1.5)
    bubble = can(V, tp.Dielectric(1, 1.5), radius=0.4)
    scene = afar([*can(glass, wall), *bubble, *can(glass, wall, center=(5, 0, 0))])
    bodies = scene_bodies(scene)
    assert [body.medium for body in bodies] == [V, glass, glass]
    assert [body.surfaces for body in bodies] == [(3, 4, 5), (0, 1, 2), (6, 7, 8)]
    places = [(0, 0, 0), (0.3, 0, -0.3), (0.5, 0, 0), (0, 0, -0.99), (0, 0, 1.01), (5, 0.9, 0.9), (5, 0, 1.1)]
    assert media_at(scene, places) == [V, V, glass, glass, V, glass, V]
    assert bodies_on_sides(scene)[0] == ((), (1,)) and bodies_on_sides(scene)[3] == ((), (0,))


def test_what_is_named_outside_and_surrounds_a_body_is_no_body():
    haze, plane = M(0.1, 2), tp.Surface(tp.Plane(), T, back=M(1), front=V)
    scenes = [near(can(M(1), outside=V)), near(plane)]
    scenes.append(near(can(M(1), outside=haze), medium=haze))
    for scene in scenes:
        assert [body.medium for body in scene_bodies(scene)] == [M(1)]
    assert scenes[2].medium_at((0, 0, 9)) == haze and bodies_on_sides(scenes[1]) == [((), (0,))]


@pytest.mark.parametrize("kind", ["mesh", "can", "lens", "shell"])
def test_places_under_the_skin_of_a_body_are_within_it(kind):
    """By how far each is looked at: those beside the skin, 1e-6 further out, are not."""
    surfaces = {
        "mesh": [filled(tp.Mesh.sphere(radius=1), M(1))],
        "can": can(M(1)),
        "lens": cap_and_disk(M(1), T),
        "shell": can(M(1)) + [tp.Surface(surface.shape, T, outside=M(1)) for surface in can(V, radius=0.5)],
    }[kind]
    scene = afar(surfaces)
    [body] = scene_bodies(scene)
    places = points_below_surface(scene, body)
    assert len(places) >= 60 and points_in_body(scene, body, places).all()
    middle = np.array([0, 0, 0.95 if kind == "lens" else 0])
    assert not points_in_body(scene, body, middle + (places - middle) * (1 + 1e-6))[: len(places) // 2].any()


def test_sides_of_surfaces_know_the_bodies_that_they_bound():
    scene = near([tp.Surface(tp.Plane(), T, back=M(1), front=M(2)), filled(corner(1), V)])
    assert scene_bodies(scene)[0].medium == V  # it lies in front of the plane
    media = [body.medium for body in scene_bodies(scene)]
    front, back = bodies_on_sides(scene)[0]
    assert [media[k] for k in front] == [M(2)] and [media[k] for k in back] == [M(1)]
    assert bodies_on_sides(scene)[1] == ((), (0,))
    assert scene.medium_at((0, 0, 2)) == M(2) and scene.medium_at((0, 0, -2)) == M(1)


def test_whether_a_scene_has_media():
    assert not has_media(tp.Scene(LAMP))
    assert not has_media(near(filled(corner(1), V), medium=V))
    assert not has_media(near(filled(corner(1), M(phase=tp.Rayleigh()))))
    assert not has_media(afar(tp.Surface(corner(1), tp.Dielectric(1.5))))
    for medium in (M(1), M(0, 1), M(index=1.0000001), M(emission=1)):
        material = tp.Dielectric(medium.index) if medium.index != 1 else T
        assert has_media(afar(filled(corner(1), medium, material)))
    assert has_media(near(medium=M(1)))


def test_a_position_is_three_numbers():
    assert_refused(lambda: tp.Scene(LAMP).medium_at((1, 2)), "position must be three finite numbers")


# ---- which bodies go together ----


def pair(one, other):
    return lambda: afar([filled(one, M(1), name="one"), filled(other, M(2))])


BUILT = {
    "slab": lambda: near(filled(tp.Slab(thickness=2.0), M(1, 2))),
    "half space of glass": lambda: near(filled(tp.Plane(), M(1, index=1.5), tp.Dielectric(1.5))),
    "two boxes side by side": lambda: near([filled(tp.Box(size=1), M(1)), filled(tp.Box(center=(1, 0, 0), size=1), M(2))]),
    "box on a half space": lambda: near([filled(tp.Plane(), M(1)), filled(tp.Box(center=(0, 0, 0.5), size=1), M(2))]),
    "ball on a slab": lambda: near([filled(tp.Slab(thickness=1), M(1)), filled(tp.Sphere(center=(0, 0, 1), radius=0.5), M(2))]),
    "ball touching its box": lambda: near([filled(tp.Box(size=1), M(1)), filled(tp.Sphere(radius=0.5), M(2))]),
    "panes of two glasses": lambda: afar(
        [
            filled(tp.Slab(thickness=1), M(1, index=1.3)), filled(tp.Slab(center=(0, 0, 1), thickness=1), M(1, index=1.5)),
            *(tp.Surface(tp.Plane(center=(0, 0, z)), tp.Dielectric(*pair)) for z, pair in ((-0.5, (1, 1.3)), (0.5, (1.3, 1.5)), (1.5, (1.5, 1)))),
        ],
    ),
    "balls side by side": pair(tp.Sphere(radius=1), tp.Sphere(center=(2, 0, 0), radius=1)),
    "panes that all but touch": lambda: afar([filled(tp.Slab(center=(0, 0, z), thickness=1), M(index=1.5), tp.Dielectric(1.5)) for z in (0, 1 + 1e-12)]),
    "mesh of water and a ball of glass": lambda: afar(
        [
            filled(tp.Mesh.sphere(radius=1), M(index=1.3), tp.Dielectric(1.3)),
            filled(tp.Sphere(center=(3, 0, 0), radius=1), M(index=1.5), tp.Dielectric(1.5)),
        ],
    ),
    "water in black walls": lambda: near(filled(corner(3), M(index=1.33), tp.Black())),
    "haze all round": lambda: near(medium=M(0.1, 1)),
    "haze in white walls": lambda: near(tp.Surface(tp.Sphere(radius=3), tp.Diffuse(1)), medium=M(1)),
    "rod that names the water of its tank": lambda: afar([filled(tp.Box(size=6), M(1)), *(tp.Surface(part.shape, T, inside=M(2), outside=M(1)) for part in can(M(2)))]),
    "layer of planes": lambda: afar([tp.Surface(tp.Plane(center=(0, 0, 1)), T, back=M(1)), tp.Surface(tp.Plane(), T, front=M(1), back=V)]),
    "gap between half spaces": lambda: afar([tp.Surface(tp.Plane(center=(0, 0, -1)), T, back=M(1)), tp.Surface(tp.Plane(center=(0, 0, 1), normal=(0, 0, -1)), T, back=M(1))]),
    "grid": lambda: near(filled(GRID.box, GRID)),
    "grid in a ball": lambda: near(filled(tp.Sphere(radius=1), GRID)),
    "grid in walls": lambda: near(filled(GRID.box, GRID, tp.Diffuse(0.5))),
    "mesh of fog with a drop": lambda: afar([filled(tp.Mesh.sphere(radius=1), M(2)), filled(tp.Sphere(radius=0.3), M(index=1.3), tp.Dielectric(1.3))]),
    "can": lambda: near(can(M(1, 2))),
    "can of glass": lambda: afar(can(M(index=1.5), tp.Dielectric(1.5))),
    "lens": lambda: afar(cap_and_disk(M(index=1.5), tp.Dielectric(1.5))),
    "dusty lens": lambda: afar(cap_and_disk(M(index=1.5), tp.Mixture({tp.Dielectric(1.5): 0.9, tp.Black(): 0.1}))),
    "bubble of open surfaces": lambda: afar([filled(tp.Box(size=5), M(index=1.5), tp.Dielectric(1.5)), *can(V, tp.Dielectric(1, 1.5))]),
    "fog in black walls": lambda: near(filled(tp.Sphere(radius=3), M(0, 1), tp.Black())),
    "fog all round in black walls": lambda: near(tp.Surface(tp.Sphere(radius=3), tp.Black()), medium=M(0, 1)),
    "white walls full of fog": lambda: near(filled(tp.Sphere(radius=3), M(1), tp.Diffuse(1))),
    "gap of vacuum": lambda: near([filled(tp.Slab(thickness=2), M(1)), filled(tp.Slab(thickness=1e-9), V)]),
    "one fog in two balls": lambda: near([filled(tp.Sphere(center=(x, 0, 0), radius=1), M(1)) for x in (0, 1)]),
    "sheet inside fog": lambda: near(tp.Surface(tp.Rectangle(width=1, height=1), tp.Mirror(0.5, 0.5)), medium=M(1)),
    "glow": lambda: tp.Scene([], filled(tp.Box(size=5), M(1, emission=2), tp.Black())),
    "glow in dull glass": lambda: tp.Scene([], filled(tp.Sphere(radius=1), M(1, index=1.5, emission=1), tp.Dielectric(1.5))),
    "glow in fog": lambda: tp.Scene([], [filled(tp.Box(size=5), M(1)), filled(tp.Sphere(radius=1), M(1, emission=2))]),
    "glass with a clock": lambda: near(filled(tp.Plane(), M(1, 9, index=1.4), tp.Dielectric(1.4)), duration=1e-9),
    "particles": lambda: tp.Scene(PARTICLES, filled(corner(1), M(1)), duration=1),
    "lamp in dull glass": lambda: near(filled(corner(9), M(1e-3, index=1.5), tp.Dielectric(1.5))),
    "62 slabs": lambda: afar(stack([1.0] * 62)),
}  # fmt: skip


@pytest.mark.quick_cases("slab", "half space of glass")
@pytest.mark.parametrize("make", BUILT.values(), ids=BUILT)
def test_media_that_fit_together_are_accepted(make):
    scene = make()
    hash(scene)
    assert has_media(scene)


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e11])
@pytest.mark.parametrize("shift", [0.0, 0.1, -1e6])
def test_stacks_touch_whatever_their_unit_and_place(unit, shift):
    """Layers of 0.1, 0.2, ... whose faces differ by roundings touch; each middle is in its own medium."""
    thicknesses = np.random.default_rng(2).uniform(0.05, 3, 12).round(2)
    surfaces = stack(thicknesses, unit, shift * unit)
    source = tp.Source(tp.Point(position=(0, 0, (shift + 1) * unit)), tp.Isotropic(power=1))
    scene = tp.Scene(source, surfaces)
    middles = [surface.shape.center for surface in surfaces]
    assert media_at(scene, np.array(middles)) == [surface.inside for surface in surfaces]


# ---- what is refused ----

OVERLAPPING = {
    "balls": (tp.Sphere(radius=1), tp.Sphere(center=(1, 0, 0), radius=1)),
    "boxes": (tp.Box(size=1), tp.Box(center=(0.5, 0, 0), size=1)),
    "crossed boxes": (tp.Box(size=(1, 1, 9)), tp.Box(size=(9, 1, 1))),
    "ball and box": (tp.Box(size=2), tp.Sphere(center=(1.5, 1.5, 1.5), radius=1)),
    "slab and box": (tp.Slab(thickness=1), tp.Box(center=(0, 0, 0.5), size=1)),
    "slab and ball": (tp.Slab(normal=(1, 1, 0), thickness=1), tp.Sphere(radius=0.6)),
    "slabs": (tp.Slab(thickness=1), tp.Slab(normal=(0, 1, 1), thickness=1)),
    "half spaces": (tp.Plane(), tp.Plane(normal=(1, 0, 0))),
    "half spaces face to face": (tp.Plane(), tp.Plane(center=(0, 0, -1), normal=(0, 0, -1))),
    "half space and box": (tp.Plane(), tp.Box(size=1)),
    "mesh and ball": (tp.Mesh.sphere(radius=1), tp.Sphere(center=(1, 0, 0), radius=1)),
    "meshes": (tp.Mesh.sphere(radius=1), tp.Mesh.box(center=(1, 0, 0), size=1)),
    "mesh and half space": (tp.Mesh.sphere(radius=1), tp.Plane(center=(0, 0, 0.7))),
}


@pytest.mark.parametrize(("one", "other"), OVERLAPPING.values(), ids=OVERLAPPING)
def test_bodies_that_overlap_in_part_are_refused(one, other):
    words = (
        "Surface 'one' and surfaces[1] overlap in part ... Medium(absorption=1.0) ... Medium(absorption=2.0)"
    )
    assert_refused(pair(one, other), f"{words} ... put one wholly into the other")


UNFIT = {  # words that the message must hold: the scene that is refused
    "surfaces[3] ... surfaces[0], surfaces[1] and surfaces[2] ... overlap in part ... Medium(absorption=2.0) ... Medium(absorption=1.0) ... put one wholly into the other": lambda: afar([*can(M(1)), filled(tp.Sphere(center=(1, 0, 0), radius=0.5), M(2))]),
    "one region of two media ... leave one out": pair(tp.Sphere(radius=1), tp.Sphere(radius=1)),
    "Surface 'sea' ... Dielectric ... Medium(absorption=1.0, index=1.5) behind ... Vacuum() in front ... write Dielectric(1.5, 1)": lambda: near(filled(tp.Plane(), M(1, index=1.5), name="sea")),
    "material ... Mirror ... write Dielectric(1.5, 1)": lambda: near(filled(tp.Plane(), M(1, index=1.5), tp.Mirror(0.5, 0.5))),
    "surfaces[ ... must be a Dielectric ... Vacuum() in front": lambda: afar([filled(tp.Box(size=1), M(index=1.5), T), filled(tp.Box(center=(1, 0, 0), size=1), M(index=1.4), T)]),
    "surfaces[0] ... index_inside=1.5 ... contradicts ... index=1.33 ... write Dielectric(1.33, 1)": lambda: near(filled(tp.Plane(), M(1, index=1.33), tp.Dielectric(1.5))),
    "contradicts the medium outside ... outside=Medium(index=1.1) ... write Dielectric(1.5, 1)": lambda: afar([filled(tp.Sphere(radius=1), M(index=1.5), tp.Dielectric(1.5, 1.1))]),
    "contradicts the medium inside ... Medium(absorption=1.0) of index 1 ... inside=Medium(index=1.5)": lambda: afar(tp.Surface(tp.Sphere(radius=1), tp.Dielectric(1.5)), medium=M(1)),
    "Surface 'last' ... contradicts the medium back ... name the medium there, back=Vacuum()": lambda: near([filled(tp.Plane(), M(1, index=1.4), tp.Dielectric(1.4)), tp.Surface(tp.Plane(center=(0, 0, -1)), tp.Dielectric(1, 1.4), "last")]),
    "contradicts ... write Dielectric(1.5, 1)": lambda: near(filled(tp.Plane(), M(1, index=1.5), tp.Dielectric(1, 1.5))),
    "surfaces[0]: outside must be the medium there, Vacuum() ... Medium(absorption=2.0) ... leave outside out": lambda: near(tp.Surface(tp.Sphere(radius=1), T, inside=M(1), outside=M(2))),
    "outside must be the medium there, Medium(absorption=1.0) ... got Vacuum()": lambda: near(tp.Surface(tp.Sphere(radius=1), tp.Black(), outside=V), medium=M(1)),
    "surfaces[0] ... box of the Grid ... Surface(grid.box": lambda: near(filled(tp.Box(size=2.1), GRID)),
    "surfaces[0] ... box of the Grid": lambda: near(filled(tp.Plane(), GRID)),
    "Scene: medium must fill all space ... Surface(grid.box": lambda: near(medium=GRID),
    "Scene: medium ... Medium( ... got 3": lambda: near(medium=3),
    "Scene: medium must absorb ... duration": lambda: near(medium=M(0, 1)),
    "emission needs a Box or Sphere ... Slab(": lambda: near(filled(tp.Slab(thickness=1), M(1, emission=1))),
    "must hold no other body ... Surface 'hole'": lambda: near([filled(tp.Box(size=4), M(1, emission=1)), filled(tp.Sphere(radius=0.1), V, name="hole")]),
    "must hold no other body": lambda: near([filled(tp.Sphere(center=(x, 0, 0), radius=1), M(1, emission=1)) for x in (0, 1)]),
    "medium must not emit, because it is infinite ... give it to a body": lambda: near(medium=M(1, emission=1)),
    "at least one Source ... let a medium emit": lambda: tp.Scene([], filled(corner(1), M(1))),
    "Dielectric ... 1e-09 s ... inside=Medium(index=1.5)": lambda: near(tp.Surface(tp.Plane(), tp.Dielectric(1.5)), duration=1e-9),
    "Surface 'ice' ... particles ... index=1.1": lambda: tp.Scene(PARTICLES, filled(corner(1), M(1, index=1.1), name="ice"), duration=1),
    "particles ... emission=3": lambda: tp.Scene(PARTICLES, filled(corner(1), M(1, emission=3)), duration=1),
    "at most 62 bodies ... got 63 ... Grid( ... of (1, 1, 63) in a wide Box": lambda: afar(stack([1.0] * 63)),
    "Surface 'end' ... back must be named ... write back=Vacuum()": lambda: afar([tp.Surface(tp.Plane(center=(0, 0, 1)), T, "top", back=M(1)), tp.Surface(tp.Plane(), T, "end", front=M(1))]),
    "half spaces that overlap ... Box(...).faces()": lambda: afar([tp.Surface(tp.Plane(center=c, normal=c), T, back=M(1)) for c in np.concatenate([np.eye(3), -np.eye(3)]).tolist()]),
    "half spaces that overlap ... write Slab(...)": lambda: afar([tp.Surface(tp.Plane(center=c, normal=c), T, back=M(1)) for c in ((0, 0, 1), (0, 0, -1))]),
    "total internal reflection": lambda: near(filled(corner(9), M(index=1.5), tp.Dielectric(1.5))),
    "total internal reflection ... the medium of surfaces[0]": lambda: tp.Scene([], filled(tp.Sphere(radius=1), M(index=1.5, emission=1), tp.Dielectric(1.5))),
    "nothing absorbs inside surfaces[0]": lambda: tp.Scene([], filled(tp.Box(size=1), M(emission=1), tp.Diffuse(1))),
    "Scene: nothing absorbs inside surfaces[0]": lambda: tp.Scene(tp.Source(tp.Box(size=1), tp.Isotropic(power=1)), tp.Surface(tp.Box(size=1), tp.Diffuse(1))),
    "nothing absorbs inside": lambda: near(filled(tp.Sphere(radius=3), M(0, 1), tp.Diffuse(1))),
}  # fmt: skip


@pytest.mark.parametrize(("words", "make"), UNFIT.items())
def test_media_that_do_not_fit_together_are_refused(words, make):
    assert_refused(make, words)


@pytest.mark.parametrize("unit", [1e-9, 1e11])
def test_refusals_of_media_do_not_depend_on_the_unit(unit):
    balls = [filled(tp.Sphere(center=(x * unit, 0, 0), radius=unit), M(x + 1)) for x in (0, 1)]
    assert_refused(lambda: afar(balls), "overlap in part")
    sea = filled(tp.Slab(thickness=unit), M(1 / unit, index=1.5))
    assert_refused(lambda: afar(sea), "write Dielectric")


@pytest.mark.slow
def test_checks_take_no_longer_than_a_second():
    start = time.process_time()
    ball, drop = (tp.Mesh.sphere(radius=r, triangles=20_000) for r in (1.0, 0.5))
    afar([filled(ball, M(1)), filled(drop, M(2)), *stack([1.0] * 40, shift=-2)])
    assert time.process_time() - start < 3


# ---- what closes a body of open surfaces ----

HAZE = M(1.0, 2.0)


class Part(NamedTuple):
    """A shape, and whether the body is in front of it."""

    shape: Shape
    is_front: bool = False


def frame(rng) -> np.ndarray:
    """Three unit vectors (rows) turned by chance."""
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return q


def disk(rng, center, out, radius, inner=0.0) -> Part:
    """A disk across `out`, which leads out of the body; its normal is along that or against it."""
    sign = rng.choice([-1.0, 1.0])
    return Part(tp.Disk(center=center, normal=sign * out, radius=radius, inner_radius=inner), sign < 0)


def box(rng, size) -> list[Part]:
    axes, half = frame(rng), size * rng.uniform(0.3, 1, 3) / 2
    parts = []
    for k, out in ((k, sign * axes[k]) for k in range(3) for sign in (-1, 1)):
        sign, wide, high = rng.choice([-1.0, 1.0]), (k + 1) % 3, (k + 2) % 3
        sides = {"width": 2 * half[wide], "height": 2 * half[high], "up": axes[high]}
        parts.append(Part(tp.Rectangle(center=half[k] * out, normal=sign * out, **sides), sign < 0))
    return parts


def tin(rng, size) -> list[Part]:
    axis, radius, height = frame(rng)[0], size * rng.uniform(0.1, 0.5), size * rng.uniform(0.1, 1)
    lids = [disk(rng, s * height / 2 * axis, s * axis, radius) for s in (-1, 1)]
    return [Part(tp.Cylinder(axis=axis, radius=radius, height=height)), *lids]


def pipe(rng, size) -> list[Part]:
    axis, inner = frame(rng)[0], 0.2 * size
    outer, height = size * rng.uniform(0.3, 0.5), size * rng.uniform(0.2, 1)
    walls = [Part(tp.Cylinder(axis=axis, radius=r, height=height), r == inner) for r in (inner, outer)]
    return [*walls, *(disk(rng, s * height / 2 * axis, s * axis, outer, inner) for s in (-1, 1))]


def bucket(rng, size) -> list[Part]:
    axis, height, radii = frame(rng)[0], size * rng.uniform(0.2, 1), size * rng.uniform(0.1, 0.5, 2)
    wall = tp.Cone(axis=axis, radius=radii[0], top_radius=radii[1], height=height)
    lids = [disk(rng, s * height / 2 * axis, s * axis, r) for s, r in zip((-1, 1), radii, strict=True)]
    return [Part(wall), *lids]


def dish(rng, size) -> list[Part]:
    axis, radius, focal_length = frame(rng)[0], size * rng.uniform(0.2, 0.5), size * rng.uniform(0.1, 0.5)
    depth = radius * radius / (4 * focal_length)
    wall = tp.Paraboloid(center=-depth / 2 * axis, axis=axis, radius=radius, focal_length=focal_length)
    return [Part(wall), disk(rng, depth / 2 * axis, axis, radius)]


def cap(rng, size) -> list[Part]:
    axis, radius, mu = frame(rng)[0], size / 2, rng.uniform(-0.8, 0.8)
    flat = disk(rng, mu * radius * axis, -axis, radius * math.sqrt(1 - mu * mu))
    return [Part(tp.Sphere(radius=radius, axis=axis, mu_min=mu)), flat]


def lens(rng, size) -> list[Part]:
    axis, radius, mu = frame(rng)[0], size / 2, rng.uniform(0.2, 0.9)
    return [
        Part(tp.Sphere(center=-s * mu * radius * axis, radius=radius, axis=s * axis, mu_min=mu))
        for s in (-1, 1)
    ]


def shards(rng, size) -> list[Part]:
    """A ball of triangles in two meshes, of which one may be turned inside out."""
    ball = tp.Mesh.sphere(radius=size / 2, triangles=20)
    is_one = (ball.vertices[ball.faces].mean(axis=1) @ frame(rng)[0]) > size * rng.uniform(-0.2, 0.2)
    turned = rng.random() < 0.5
    one, other = (tp.Mesh(vertices=ball.vertices, faces=ball.faces[chosen]) for chosen in (is_one, ~is_one))
    return [Part(one.flipped() if turned else one, turned), Part(other)]


KINDS = [box, tin, pipe, bucket, dish, cap, lens, shards]
BODIES = [(kind, seed) for kind in KINDS for seed in range(1 if kind is shards else 2)]
MATERIALS = [T, tp.Diffuse(0.5), tp.Black(), tp.Mirror(0.5, 0.25)]


def surfaces(parts: list[Part], medium, bare: int | None = None, material=T) -> list[tp.Surface]:
    """The surfaces of a body, of which one may name no medium."""
    made = []
    for k, (shape, is_front) in enumerate(parts):
        named = {} if k == bare else {"front" if is_front else "back": medium}
        made.append(tp.Surface(shape, material if k == bare else T, f"part {k}", **named))
    return made


def neighbours(rng, size) -> list[tp.Surface]:
    """A ball within every body, what lies far about it, and bodies beside it that touch one another."""
    beside = tp.Box(center=(0, 0, 2 * size), size=size)
    return [
        filled(tp.Sphere(radius=0.01 * size), M(3.0)),
        filled(tp.Box(size=9 * size), M(0.1)),
        filled(beside, M(4.0)),
        filled(tp.Box(center=(size, 0, 2 * size), size=size), M(5.0)),
        *(tp.Surface(face, T, back=M(6.0)) for face in tp.Box(center=(-size, 0, 2 * size), size=size).faces().values()),
        *can(M(6.0), center=(0, 0, -2 * size), radius=size / 4),
        tp.Surface(tp.Rectangle(center=(0, 0, 3 * size), width=size, height=size), T, "bare beside"),
    ]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "seed"), BODIES, ids=lambda value: getattr(value, "__name__", value))
def test_whole_bodies_are_accepted_and_each_part_without_its_medium_is_named(kind, seed):
    """Each of a body's parts in turn without media, its normal either way; alone, and among nested and touching bodies."""
    rng = np.random.default_rng([seed, KINDS.index(kind)])
    size = 10.0 ** rng.integers(-6, 7)
    parts = kind(rng, size)
    lamp = tp.Source(tp.Point(position=(0, 0, 6 * size)), tp.Isotropic(power=1))
    for others in ([], neighbours(rng, size)):
        order = rng.permutation(len(parts) + len(others))
        tp.Scene(lamp, [[*surfaces(parts, HAZE), *others][k] for k in order])
        for bare, (_, is_front) in enumerate(parts):
            open_body = [*surfaces(parts, HAZE, bare, MATERIALS[rng.integers(len(MATERIALS))]), *others]
            words = f"give Surface 'part {bare}' {'front' if is_front else 'back'}={HAZE!r}"
            assert_refused(lambda each=open_body, o=order: tp.Scene(lamp, [each[k] for k in o]), words)


@pytest.mark.parametrize("kind", quick(KINDS, *KINDS[:-1]), ids=lambda kind: kind.__name__)
def test_the_place_that_a_refusal_names_is_on_the_surface_that_it_names(kind):
    rng = np.random.default_rng(KINDS.index(kind))
    parts = kind(rng, 1.0)
    for bare, (shape, _) in enumerate(parts):
        with pytest.raises(tp.SceneError) as caught:
            near(surfaces(parts, HAZE, bare))
        place = [float(x) for x in re.search(r"at \((.*?)\)", str(caught.value))[1].split(", ")]
        assert shape.distance(tuple(place)) < 1e-5


def test_a_hemisphere_on_a_disk_that_names_nothing():
    dome = tp.Surface(tp.Sphere(radius=1, mu_min=0), T, "cap", inside=HAZE)
    for z, side in ((1, "front"), (-1, "back")):
        floor = tp.Disk(normal=(0, 0, z), radius=1)
        words = f"bounded by Surface 'cap' ... got None; give Surface 'd' {side}=Medium"
        assert_refused(lambda floor=floor: near([dome, tp.Surface(floor, T, "d")]), words)
        near([dome, tp.Surface(floor, T, "d", **{side: HAZE})])


@pytest.mark.parametrize(
    "across", [tp.Plane(), tp.Plane(normal=(0, 0, -1)), tp.Box(center=(0, 0, -2), size=4)]
)
@pytest.mark.parametrize("inside", [None, HAZE])
def test_a_dome_on_a_plane_or_a_box_wants_a_floor_of_its_own(across, inside):
    """Also where the plane has the same medium below it: the fog of a dome that is left through it would go along."""
    dome = tp.Surface(tp.Sphere(radius=1, mu_min=0), T, "dome", inside=HAZE)
    if inside is not None and isinstance(across, tp.Plane) and across.normal[2] < 0:
        across = tp.Plane()
    ground = tp.Surface(across, T, "ground", inside=inside)
    words = "'dome': back must ... 'ground' does not bound the body there; put a Transparent() Disk"
    assert_refused(lambda: near([dome, ground]), words)
    floor = tp.Surface(tp.Disk(normal=(0, 0, -1), radius=1), T, inside=HAZE)
    scene = near([dome, ground, floor])
    assert media_at(scene, [(0, 0, 0.5), (0, 0, -0.5), (2, 0, 0.5)]) == [HAZE, inside or V, V]


NOT_CLOSED = {  # words that the message must hold: the surfaces that are refused
    "surfaces[ ... back must bound a closed body ... to nothing ... close the gaps": can(HAZE)[:2],
    "surfaces[2]: back ... reverse its normal, or write front instead of back": [*can(HAZE)[:2], filled(tp.Disk(center=(0, 0, -1), radius=1), HAZE)],
    "back must bound ... close the gaps": [*can(HAZE)[:2], filled(tp.Disk(center=(0, 0, -1), normal=(0, 0, -1), radius=0.9), HAZE)],
    "surfaces[2]: back must bound ... close the gaps": [*can(HAZE)[:2], filled(tp.Disk(center=(0, 0, -1), normal=(0, 0, -1), radius=1.1), HAZE)],
    "Medium(absorption=7.0)": [*can(HAZE)[:2], filled(tp.Disk(center=(0, 0, -1), normal=(0, 0, -1), radius=1), M(7.0), name="lid")],
    "front must bound a closed body": can(None, outside=HAZE),
    "back must bound a closed body ... close the gaps": filled(tp.Rectangle(width=1, height=1), HAZE),
    "reverse its normal": filled(tp.Mesh.sphere(radius=1).flipped(), HAZE),
    "surfaces[1] and surfaces[5] must not lie back to back ... leave both out": [*can(HAZE), *can(HAZE, center=(0, 0, 2))],
    "back to back ... a hole": [*can(HAZE), *can(HAZE, center=(0, 0, 1.5), radius=0.5)],
    "overlap or are nested, make them one": [*can(HAZE), *can(HAZE, center=(0, 0, 1))],
    "surfaces[0]: back must bound ... overlap or are nested, make them one": [*can(HAZE), *can(HAZE, radius=0.5)],
    "surfaces[6]: front must be Vacuum() ... give surfaces[6] front=Vacuum()": [*can(HAZE, radius=4), *can(V, radius=3), *can(HAZE, radius=2), *can(V, radius=1)],
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("words", "parts"), NOT_CLOSED.items())
def test_surfaces_that_do_not_close_a_body_are_refused(words, parts):
    assert_refused(lambda: near(parts), words)


def test_cans_without_the_lids_between_them_are_one_body():
    low, high = can(HAZE), can(HAZE, center=(0, 0, 2))
    scene = near([low[0], low[2], high[0], high[1]])
    assert media_at(scene, [(0, 0, 0.99), (0, 0, 1.01), (0, 0, 3.1)]) == [HAZE, HAZE, V]


def test_a_flask_whose_walls_name_both_of_their_sides():
    """Glass, a gap, glass and what is in it: each medium's surfaces take turns along any line."""
    sides = [(4, HAZE, None), (3, V, HAZE), (2, HAZE, V), (1, V, HAZE)]
    flask = [part for radius, *media in sides for part in can(media[0], radius=radius, outside=media[1])]
    scene = tp.Scene(tp.Source(tp.Point(position=(0, 0, 9)), tp.Isotropic(power=1)), flask)
    assert media_at(scene, [(0, 0, z) for z in (0.5, 1.5, 2.5, 3.5, 4.5)]) == [V, HAZE, V, HAZE, V]
