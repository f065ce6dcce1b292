"""Which bodies of media go together in a scene, and which are refused, with what is wrong and how to mend it."""

from __future__ import annotations

import time

import numpy as np
import pytest

import transport as tp
from tests.body_scenes import AFAR, GRID, LAMP, M, T, V, can, corner, filled, lens, stack
from tests.refusals import assert_refused
from transport.scene.bodies import has_media, media_at

# ---- what is built ----


def pair(one, other):
    return lambda: tp.Scene(AFAR, [filled(one, M(1), name="one"), filled(other, M(2))])


BUILT = {
    "slab": lambda: tp.Scene(LAMP, filled(tp.Slab(thickness=2.0), M(1, 2))),
    "half space of glass": lambda: tp.Scene(LAMP, filled(tp.Plane(), M(1, index=1.5), tp.Dielectric(1.5))),
    "two boxes side by side": lambda: tp.Scene(LAMP, [filled(tp.Box(size=1), M(1)), filled(tp.Box(center=(1, 0, 0), size=1), M(2))]),
    "box on a half space": lambda: tp.Scene(LAMP, [filled(tp.Plane(), M(1)), filled(tp.Box(center=(0, 0, 0.5), size=1), M(2))]),
    "ball on a slab": lambda: tp.Scene(LAMP, [filled(tp.Slab(thickness=1), M(1)), filled(tp.Sphere(center=(0, 0, 1), radius=0.5), M(2))]),
    "ball touching its box": lambda: tp.Scene(LAMP, [filled(tp.Box(size=1), M(1)), filled(tp.Sphere(radius=0.5), M(2))]),
    "panes of two glasses": lambda: tp.Scene(
        AFAR,
        [
            filled(tp.Slab(thickness=1), M(1, index=1.3)), filled(tp.Slab(center=(0, 0, 1), thickness=1), M(1, index=1.5)),
            *(tp.Surface(tp.Plane(center=(0, 0, z)), tp.Dielectric(*pair)) for z, pair in ((-0.5, (1, 1.3)), (0.5, (1.3, 1.5)), (1.5, (1.5, 1)))),
        ],
    ),
    "balls side by side": pair(tp.Sphere(radius=1), tp.Sphere(center=(2, 0, 0), radius=1)),
    "panes that all but touch": lambda: tp.Scene(
        AFAR, [filled(tp.Slab(center=(0, 0, z), thickness=1), M(index=1.5), tp.Dielectric(1.5)) for z in (0, 1 + 1e-12)]
    ),
    "mesh of water and a ball of glass": lambda: tp.Scene(
        AFAR,
        [
            filled(tp.Mesh.sphere(radius=1), M(index=1.3), tp.Dielectric(1.3)),
            filled(tp.Sphere(center=(3, 0, 0), radius=1), M(index=1.5), tp.Dielectric(1.5)),
        ],
    ),
    "water in black walls": lambda: tp.Scene(LAMP, filled(corner(3), M(index=1.33), tp.Black())),
    "haze all round": lambda: tp.Scene(LAMP, medium=M(0.1, 1)),
    "haze in white walls": lambda: tp.Scene(LAMP, tp.Surface(tp.Sphere(radius=3), tp.Diffuse(1)), medium=M(1)),
    "rod that names the water of its tank": lambda: tp.Scene(
        AFAR, [filled(tp.Box(size=6), M(1)), *(tp.Surface(part.shape, T, inside=M(2), outside=M(1)) for part in can(M(2)))]
    ),
    "layer of planes": lambda: tp.Scene(AFAR, [tp.Surface(tp.Plane(center=(0, 0, 1)), T, back=M(1)), tp.Surface(tp.Plane(), T, front=M(1), back=V)]),
    "gap between half spaces": lambda: tp.Scene(
        AFAR, [tp.Surface(tp.Plane(center=(0, 0, -1)), T, back=M(1)), tp.Surface(tp.Plane(center=(0, 0, 1), normal=(0, 0, -1)), T, back=M(1))]
    ),
    "grid": lambda: tp.Scene(LAMP, filled(GRID.box, GRID)),
    "grid in a ball": lambda: tp.Scene(LAMP, filled(tp.Sphere(radius=1), GRID)),
    "grid in walls": lambda: tp.Scene(LAMP, filled(GRID.box, GRID, tp.Diffuse(0.5))),
    "mesh of fog with a drop": lambda: tp.Scene(
        AFAR, [filled(tp.Mesh.sphere(radius=1), M(2)), filled(tp.Sphere(radius=0.3), M(index=1.3), tp.Dielectric(1.3))]
    ),
    "can": lambda: tp.Scene(LAMP, can(M(1, 2))),
    "can of glass": lambda: tp.Scene(AFAR, can(M(index=1.5), tp.Dielectric(1.5))),
    "lens": lambda: tp.Scene(AFAR, lens(M(index=1.5), tp.Dielectric(1.5))),
    "dusty lens": lambda: tp.Scene(AFAR, lens(M(index=1.5), tp.Mixture({tp.Dielectric(1.5): 0.9, tp.Black(): 0.1}))),
    "bubble of open surfaces": lambda: tp.Scene(
        AFAR, [filled(tp.Box(size=5), M(index=1.5), tp.Dielectric(1.5)), *can(V, tp.Dielectric(1, 1.5))]
    ),
    "fog in black walls": lambda: tp.Scene(LAMP, filled(tp.Sphere(radius=3), M(0, 1), tp.Black())),
    "fog all round in black walls": lambda: tp.Scene(LAMP, tp.Surface(tp.Sphere(radius=3), tp.Black()), medium=M(0, 1)),
    "white walls full of fog": lambda: tp.Scene(LAMP, filled(tp.Sphere(radius=3), M(1), tp.Diffuse(1))),
    "gap of vacuum": lambda: tp.Scene(LAMP, [filled(tp.Slab(thickness=2), M(1)), filled(tp.Slab(thickness=1e-9), V)]),
    "one fog in two balls": lambda: tp.Scene(LAMP, [filled(tp.Sphere(center=(x, 0, 0), radius=1), M(1)) for x in (0, 1)]),
    "sheet inside fog": lambda: tp.Scene(LAMP, tp.Surface(tp.Rectangle(width=1, height=1), tp.Mirror(0.5, 0.5)), medium=M(1)),
    "glow": lambda: tp.Scene([], filled(tp.Box(size=5), M(1, emission=2), tp.Black())),
    "glow in dull glass": lambda: tp.Scene([], filled(tp.Sphere(radius=1), M(1, index=1.5, emission=1), tp.Dielectric(1.5))),
    "glow in fog": lambda: tp.Scene([], [filled(tp.Box(size=5), M(1)), filled(tp.Sphere(radius=1), M(1, emission=2))]),
    "glass with a clock": lambda: tp.Scene(LAMP, filled(tp.Plane(), M(1, 9, index=1.4), tp.Dielectric(1.4)), duration=1e-9),
    "particles": lambda: tp.Scene(tp.Source(tp.Point(), tp.Gas(number=1, speed=1)), filled(corner(1), M(1)), duration=1),
    "lamp in dull glass": lambda: tp.Scene(LAMP, filled(corner(9), M(1e-3, index=1.5), tp.Dielectric(1.5))),
    "62 slabs": lambda: tp.Scene(AFAR, stack([1.0] * 62)),
}  # fmt: skip


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

CUT = ["overlap in part", "Medium(absorption=1.0)", "Medium(absorption=2.0)", "put one wholly into the other"]


REFUSED = {
    "balls": (pair(tp.Sphere(radius=1), tp.Sphere(center=(1, 0, 0), radius=1)), ["Surface 'one' and surfaces[1]", *CUT]),
    "boxes": (pair(tp.Box(size=1), tp.Box(center=(0.5, 0, 0), size=1)), CUT),
    "crossed boxes": (pair(tp.Box(size=(1, 1, 9)), tp.Box(size=(9, 1, 1))), CUT),
    "ball and box": (pair(tp.Box(size=2), tp.Sphere(center=(1.5, 1.5, 1.5), radius=1)), CUT),
    "slab and box": (pair(tp.Slab(thickness=1), tp.Box(center=(0, 0, 0.5), size=1)), CUT),
    "slab and ball": (pair(tp.Slab(normal=(1, 1, 0), thickness=1), tp.Sphere(radius=0.6)), CUT),
    "slabs": (pair(tp.Slab(thickness=1), tp.Slab(normal=(0, 1, 1), thickness=1)), CUT),
    "half spaces": (pair(tp.Plane(), tp.Plane(normal=(1, 0, 0))), CUT),
    "half spaces face to face": (pair(tp.Plane(), tp.Plane(center=(0, 0, -1), normal=(0, 0, -1))), CUT),
    "half space and box": (pair(tp.Plane(), tp.Box(size=1)), CUT),
    "mesh and ball": (pair(tp.Mesh.sphere(radius=1), tp.Sphere(center=(1, 0, 0), radius=1)), CUT),
    "meshes": (pair(tp.Mesh.sphere(radius=1), tp.Mesh.box(center=(1, 0, 0), size=1)), CUT),
    "mesh and half space": (pair(tp.Mesh.sphere(radius=1), tp.Plane(center=(0, 0, 0.7))), CUT),
    "can and ball": (
        lambda: tp.Scene(AFAR, [*can(M(1)), filled(tp.Sphere(center=(1, 0, 0), radius=0.5), M(2))]),
        ["surfaces[0], surfaces[1] and surfaces[2]", "surfaces[3]", *CUT],
    ),
    "one region twice": (pair(tp.Sphere(radius=1), tp.Sphere(radius=1)), ["one region of two media", "leave one out"]),
    "glass behind a pane that lets all pass": (
        lambda: tp.Scene(LAMP, filled(tp.Plane(), M(1, index=1.5), name="sea")),
        ["Surface 'sea'", "Dielectric", "Medium(absorption=1.0, index=1.5) behind", "Vacuum() in front", "write Dielectric(1.5, 1)"],
    ),
    "glass behind half a mirror": (
        lambda: tp.Scene(LAMP, filled(tp.Plane(), M(1, index=1.5), tp.Mirror(0.5, 0.5))), ["material", "Mirror", "write Dielectric(1.5, 1)"]
    ),
    "glasses side by side": (
        lambda: tp.Scene(AFAR, [filled(tp.Box(size=1), M(index=1.5), T), filled(tp.Box(center=(1, 0, 0), size=1), M(index=1.4), T)]),
        ["surfaces[", "must be a Dielectric", "Vacuum() in front"],
    ),
    "glass says another index": (
        lambda: tp.Scene(LAMP, filled(tp.Plane(), M(1, index=1.33), tp.Dielectric(1.5))),
        ["surfaces[0]", "index_inside=1.5", "contradicts", "index=1.33", "write Dielectric(1.33, 1)"],
    ),
    "glass says another index outside": (
        lambda: tp.Scene(AFAR, [filled(tp.Sphere(radius=1), M(index=1.5), tp.Dielectric(1.5, 1.1))]),
        ["contradicts the medium outside", "outside=Medium(index=1.1)", "write Dielectric(1.5, 1)"],
    ),
    "unnamed glass in fog": (
        lambda: tp.Scene(AFAR, tp.Surface(tp.Sphere(radius=1), tp.Dielectric(1.5)), medium=M(1)),
        ["contradicts the medium inside", "Medium(absorption=1.0) of index 1", "inside=Medium(index=1.5)"],
    ),
    "the last plane of a stack of layers, which says nothing of what is below": (
        lambda: tp.Scene(
            LAMP, [filled(tp.Plane(), M(1, index=1.4), tp.Dielectric(1.4)), tp.Surface(tp.Plane(center=(0, 0, -1)), tp.Dielectric(1, 1.4), "last")]
        ),
        ["Surface 'last'", "contradicts the medium back", "name the medium there, back=Vacuum()"],
    ),
    "turned glass": (
        lambda: tp.Scene(LAMP, filled(tp.Plane(), M(1, index=1.5), tp.Dielectric(1, 1.5))), ["contradicts", "write Dielectric(1.5, 1)"]
    ),
    "another medium outside": (
        lambda: tp.Scene(LAMP, tp.Surface(tp.Sphere(radius=1), T, inside=M(1), outside=M(2))),
        ["surfaces[0]: outside must be the medium there, Vacuum()", "Medium(absorption=2.0)", "leave outside out"],
    ),
    "no medium outside in fog": (
        lambda: tp.Scene(LAMP, tp.Surface(tp.Sphere(radius=1), tp.Black(), outside=V), medium=M(1)),
        ["outside must be the medium there, Medium(absorption=1.0)", "got Vacuum()"],
    ),
    "grid that is too small": (lambda: tp.Scene(LAMP, filled(tp.Box(size=2.1), GRID)), ["surfaces[0]", "box of the Grid", "Surface(grid.box"]),
    "grid without end": (lambda: tp.Scene(LAMP, filled(tp.Plane(), GRID)), ["surfaces[0]", "box of the Grid"]),
    "grid all round": (lambda: tp.Scene(LAMP, medium=GRID), ["Scene: medium must fill all space", "Surface(grid.box"]),
    "medium as a number": (lambda: tp.Scene(LAMP, medium=3), ["Scene: medium", "got 3", "Medium("]),
    "fog without end": (lambda: tp.Scene(LAMP, medium=M(0, 1)), ["Scene: medium must absorb", "duration"]),
    "glowing slab": (lambda: tp.Scene(LAMP, filled(tp.Slab(thickness=1), M(1, emission=1))), ["emission needs a Box or Sphere", "Slab("]),
    "glow with a hole": (
        lambda: tp.Scene(LAMP, [filled(tp.Box(size=4), M(1, emission=1)), filled(tp.Sphere(radius=0.1), V, name="hole")]),
        ["must hold no other body", "Surface 'hole'"],
    ),
    "glow cut by its like": (
        lambda: tp.Scene(LAMP, [filled(tp.Sphere(center=(x, 0, 0), radius=1), M(1, emission=1)) for x in (0, 1)]),
        ["must hold no other body"],
    ),
    "glow all round": (lambda: tp.Scene(LAMP, medium=M(1, emission=1)), ["medium must not emit, because it is infinite", "give it to a body"]),
    "nothing emits": (lambda: tp.Scene([], filled(corner(1), M(1))), ["at least one Source", "let a medium emit"]),
    "glass of no medium with a clock": (
        lambda: tp.Scene(LAMP, tp.Surface(tp.Plane(), tp.Dielectric(1.5)), duration=1e-9), ["Dielectric", "1e-09 s", "inside=Medium(index=1.5)"]
    ),
    "glass for particles": (
        lambda: tp.Scene(tp.Source(tp.Point(), tp.Gas(number=1, speed=1)), filled(corner(1), M(1, index=1.1), name="ice"), duration=1),
        ["Surface 'ice'", "particles", "index=1.1"],
    ),
    "glow for particles": (
        lambda: tp.Scene(tp.Source(tp.Point(), tp.Gas(number=1, speed=1)), filled(corner(1), M(1, emission=3)), duration=1),
        ["particles", "emission=3"],
    ),
    "63 slabs": (lambda: tp.Scene(AFAR, stack([1.0] * 63)), ["at most 62 bodies", "got 63", "Grid(", "of (1, 1, 63) in a wide Box"]),
    "layer with no end": (
        lambda: tp.Scene(AFAR, [tp.Surface(tp.Plane(center=(0, 0, 1)), T, "top", back=M(1)), tp.Surface(tp.Plane(), T, "end", front=M(1))]),
        ["Surface 'end'", "back must be named", "write back=Vacuum()"],
    ),
    "cube of half spaces": (
        lambda: tp.Scene(AFAR, [tp.Surface(tp.Plane(center=c, normal=c), T, back=M(1)) for c in np.concatenate([np.eye(3), -np.eye(3)]).tolist()]),
        ["half spaces that overlap", "Box(...).faces()"],
    ),
    "slab of half spaces": (
        lambda: tp.Scene(AFAR, [tp.Surface(tp.Plane(center=c, normal=c), T, back=M(1)) for c in ((0, 0, 1), (0, 0, -1))]),
        ["half spaces that overlap", "write Slab(...)"],
    ),
    "lamp in clear glass": (lambda: tp.Scene(LAMP, filled(corner(9), M(index=1.5), tp.Dielectric(1.5))), ["total internal reflection"]),
    "glow in clear glass": (
        lambda: tp.Scene([], filled(tp.Sphere(radius=1), M(index=1.5, emission=1), tp.Dielectric(1.5))),
        ["total internal reflection", "the medium of surfaces[0]"],
    ),
    "glow in white walls": (
        lambda: tp.Scene([], filled(tp.Box(size=1), M(emission=1), tp.Diffuse(1))), ["nothing absorbs inside surfaces[0]"]
    ),
    "lamp that fills its white walls": (
        lambda: tp.Scene(tp.Source(tp.Box(size=1), tp.Isotropic(power=1)), tp.Surface(tp.Box(size=1), tp.Diffuse(1))),
        ["nothing absorbs inside surfaces[0]"],
    ),
    "white walls full of clear fog": (
        lambda: tp.Scene(LAMP, filled(tp.Sphere(radius=3), M(0, 1), tp.Diffuse(1))), ["nothing absorbs inside"]
    ),
}  # fmt: skip


@pytest.mark.parametrize(("make", "words"), REFUSED.values(), ids=REFUSED)
def test_media_that_do_not_fit_together_are_refused(make, words):
    assert_refused(make, words)


@pytest.mark.parametrize("unit", [1e-9, 1e11])
def test_what_is_refused_does_not_depend_on_the_unit(unit):
    with pytest.raises(tp.SceneError, match="overlap in part"):
        tp.Scene(AFAR, [filled(tp.Sphere(center=(x * unit, 0, 0), radius=unit), M(x + 1)) for x in (0, 1)])
    with pytest.raises(tp.SceneError, match="write Dielectric"):
        tp.Scene(AFAR, filled(tp.Slab(thickness=unit), M(1 / unit, index=1.5)))


def test_checks_take_no_longer_than_a_second():
    start = time.perf_counter()
    ball, drop = (tp.Mesh.sphere(radius=r, triangles=20_000) for r in (1.0, 0.5))
    tp.Scene(AFAR, [filled(ball, M(1)), filled(drop, M(2)), *stack([1.0] * 40, shift=-2)])
    assert time.perf_counter() - start < 3
