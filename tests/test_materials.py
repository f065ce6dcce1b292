"""Materials: what is refused when one is made, when it is put on a shape, and when a scene is made of it."""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.refusals import assert_refused

LAMP = tp.Source(tp.Point(position=(0, 0, 5)), tp.Isotropic(power=1))
BALL, DISK = tp.Sphere(radius=1), tp.Disk(radius=1)
GLASS, LENS = tp.Dielectric(1.5), tp.ThinLens(0.1)
NAN = math.nan


def scene(*surfaces, source=LAMP, **how):
    return tp.Scene([source], [tp.Surface(shape, material) for shape, material in surfaces], **how)


def inside(shape=BALL, **where):
    return tp.Source(tp.Point(**where), tp.Isotropic(power=1))


REFUSALS = {
    # shares
    "diffuse sum": (lambda: tp.Diffuse(0.7, 0.5), ["Diffuse: albedo + transmission", "0.7 + 0.5 = 1.2"]),
    "mirror sum": (lambda: tp.Mirror(0.75, 0.5), ["Mirror: reflectance + transmission", "0.75 + 0.5 = 1.25"]),
    "a rounding": (lambda: tp.Diffuse(0.7, 0.3 + 2e-16), ["albedo + transmission", "above 1"]),
    "transmission": (lambda: tp.Diffuse(0.1, -0.1), ["Diffuse: transmission", "[0, 1]", "-0.1"]),
    "mirror transmission": (lambda: tp.Mirror(0.1, NAN), ["Mirror: transmission", "[0, 1]", "nan"]),
    # indices
    "index 0": (lambda: tp.Dielectric(0), ["Dielectric: index_inside", "positive", "got 0"]),
    "index below 0": (lambda: tp.Dielectric(1.5, -1), ["Dielectric: index_outside", "positive", "-1"]),
    "index nan": (lambda: tp.Dielectric(NAN), ["Dielectric: index_inside", "nan"]),
    "index infinite": (lambda: tp.Dielectric(math.inf), ["Dielectric: index_inside", "inf"]),
    "index of text": (lambda: tp.Dielectric("glass"), ["Dielectric: index_inside", "number", "'glass'"]),
    "no index": (lambda: tp.Dielectric(), ["Dielectric: index_inside missing"]),
    # roughness
    "smooth": (lambda: tp.Glossy(0), ["Glossy: roughness", "above 0", "got 0", "Mirror"]),
    "too rough": (lambda: tp.Glossy(1.01), ["Glossy: roughness", "at most 1", "1.01"]),
    "rough nan": (lambda: tp.Glossy(NAN), ["Glossy: roughness", "nan"]),
    "glossy albedo": (lambda: tp.Glossy(0.1, 1.5), ["Glossy: albedo", "[0, 1]", "1.5"]),
    # lenses
    "flat lens": (lambda: tp.ThinLens(0), ["ThinLens: focal_length", "not zero", "Transparent()"]),
    "endless lens": (lambda: tp.ThinLens(math.inf), ["ThinLens: focal_length", "finite", "inf"]),
    "lens of text": (lambda: tp.ThinLens("long"), ["ThinLens: focal_length", "'long'"]),
    "lens on a ball": (
        lambda: tp.Surface(BALL, LENS, "eye"),
        ["Surface 'eye'", "ThinLens", "Disk", "Sphere"],
    ),
    "part of a lens on a ball": (
        lambda: tp.Surface(BALL, tp.Mixture({LENS: 0.5, tp.Black(): 0.5})),
        ["Surface: a ThinLens", "Sphere"],
    ),
    # two sides
    "side of glass": (
        lambda: tp.TwoSided(GLASS, tp.Black()),
        ["TwoSided: front", "Dielectric", "both sides"],
    ),
    "side of a lens": (lambda: tp.TwoSided(tp.Black(), LENS), ["TwoSided: back", "ThinLens", "both sides"]),
    "side of a mixture": (
        lambda: tp.TwoSided(tp.Black(), tp.Mixture({GLASS: 0.5, tp.Black(): 0.5})),
        ["TwoSided: back", "contain a Dielectric"],
    ),
    "sides of sides": (
        lambda: tp.TwoSided(tp.TwoSided(tp.Black(), tp.Black()), tp.Black()),
        ["TwoSided: front", "another TwoSided"],
    ),
    "side of a class": (lambda: tp.TwoSided(tp.Black, tp.Black()), ["TwoSided: front", "an instance"]),
    "one side": (lambda: tp.TwoSided(tp.Black()), ["TwoSided: back missing"]),
    # mixtures
    "mixture of sides": (
        lambda: tp.Mixture({tp.TwoSided(tp.Black(), tp.Mirror()): 1}),
        ["Mixture: parts", "TwoSided", "front=Mixture(...)"],
    ),
    "mixture of media": (
        lambda: tp.Mixture({GLASS: 0.5, tp.Dielectric(1.3): 0.5}),
        ["Mixture: parts", "the same media", "1.5", "1.3"],
    ),
    "mixture of glass and air": (
        lambda: tp.Mixture({GLASS: 0.5, tp.Transparent(): 0.5}),
        ["Mixture: parts", "the same media", "Transparent"],
    ),
    "mixture of glass and milk": (
        lambda: tp.Mixture({GLASS: 0.5, tp.Diffuse(0.2, 0.2): 0.5}),
        ["Mixture: parts", "the same media", "Diffuse"],
    ),
    # scenes
    "glass with a clock": (
        lambda: scene((BALL, GLASS), duration=1e-9),
        ["Surface: material", "Dielectric", "1e-09 s", "leave out duration"],
    ),
    "glass for particles": (
        lambda: scene((BALL, GLASS), source=tp.Source(DISK, tp.Effusive(density=1, speed=1))),
        ["Surface: material", "Dielectric", "particles", "watts"],
    ),
    "part of a lens for particles": (
        lambda: scene(
            (tp.Disk(center=(0, 0, 1), radius=1), tp.Mixture({LENS: 0.5, tp.Black(): 0.5})),
            source=tp.Source(DISK, tp.Effusive(density=1, speed=1)),
        ),
        ["Surface: material", "ThinLens", "particles"],
    ),
    "speed on a side for watts": (
        lambda: scene((BALL, tp.TwoSided(tp.Diffuse(0.5, speed=3), tp.Black()))),
        ["Surface: a wall with a speed", "watts"],
    ),
    # light that never ends
    "shut in": (
        lambda: scene((BALL, tp.Glossy(0.3)), source=inside()),
        ["nothing absorbs inside surfaces[0]"],
    ),
    "shut in by a side": (
        lambda: scene((BALL, tp.TwoSided(tp.Black(), tp.Diffuse(1.0))), source=inside()),
        ["nothing absorbs inside surfaces[0]"],
    ),
    "glass in a box of mirrors": (
        lambda: scene((tp.Box(size=4), tp.Mirror()), (BALL, GLASS), source=inside(position=(1.5, 0, 0))),
        ["nothing absorbs inside surfaces[0]"],
    ),
    "trapped in a ball": (
        lambda: scene((BALL, GLASS), source=inside(position=(0.7, 0, 0))),
        ["total internal reflection", "sources[0]", "surfaces[0]", "41.81 degrees", "Mixture"],
    ),
    "trapped under the skin": (
        lambda: tp.Scene(
            [tp.Source("ball", tp.Lambertian(power=1), side="inside")], [tp.Surface(BALL, GLASS, "ball")]
        ),
        ["total internal reflection", "Surface 'ball'"],
    ),
    "trapped in a cube": (
        lambda: scene((tp.Box(size=2), GLASS), source=inside()),
        ["total internal reflection"],
    ),
    "trapped in a slab": (
        lambda: scene((tp.Slab(thickness=2), tp.Dielectric(1.01)), source=inside()),
        ["total internal reflection"],
    ),
}


@pytest.mark.parametrize(("make", "words"), REFUSALS.values(), ids=REFUSALS)
def test_wrong_materials_are_refused_with_object_parameter_value_and_cure(make, words):
    assert_refused(make, words)


ACCEPTED = {
    "all that arrives": lambda: (tp.Diffuse(0.7, 0.3), tp.Mirror(0.1, 0.9), tp.Mirror(0.0, 1.0)),
    "no boundary": lambda: tp.Mixture({tp.Dielectric(1.5, 1.5): 0.5, tp.Transparent(): 0.5}),
    "glass, dust and a mirror": lambda: tp.Mixture({GLASS: 0.8, tp.Black(): 0.1, tp.Mirror(): 0.1}),
    "a half mirror on a side": lambda: tp.TwoSided(
        tp.Mixture({tp.Mirror(): 0.5, tp.Black(): 0.5}), tp.Black()
    ),
    "a lens on either shape": lambda: (
        tp.Surface(tp.Rectangle(width=1, height=1), LENS),
        tp.Surface(tp.Disk(radius=1, inner_radius=0.5), tp.ThinLens(-3)),
    ),
    "a lens with a clock": lambda: scene((DISK, LENS), duration=1),
    "a lossless bulb of milk": lambda: scene((BALL, tp.Diffuse(0.9, 0.1)), source=inside()),
    "a half mirror round a lamp": lambda: scene((BALL, tp.Mirror(0.9, 0.1)), source=inside()),
    "dark inside, mirror outside": lambda: scene(
        (BALL, tp.TwoSided(tp.Mirror(), tp.Diffuse(0.9))), source=inside()
    ),
    "a lamp in the middle of a ball": lambda: scene((BALL, GLASS), source=inside(position=(0.66, 0, 0))),
    "a lamp on a ball": lambda: tp.Scene(
        [tp.Source("ball", tp.Lambertian(power=1))], [tp.Surface(BALL, GLASS, "ball")]
    ),
    "a bubble": lambda: scene((BALL, tp.Dielectric(1.0, 1.5)), source=inside(position=(0.9, 0, 0))),
    "a cube of ice": lambda: scene((tp.Box(size=2), tp.Dielectric(1.22)), source=inside()),
    "a beam in glass": lambda: scene(
        (BALL, GLASS), source=tp.Source(tp.Point(position=(0.9, 0, 0)), tp.Beam(direction=(1, 0, 0), power=1))
    ),
    "a dusty ball": lambda: scene(
        (BALL, tp.Mixture({GLASS: 0.99, tp.Black(): 0.01})), source=inside(position=(0.9, 0, 0))
    ),
}


@pytest.mark.parametrize("make", ACCEPTED.values(), ids=ACCEPTED)
def test_right_materials_are_accepted(make):
    make()


def test_materials_are_plain_values():
    """Equal and of one hash from lists, NumPy's numbers and integers; frozen."""
    assert tp.Dielectric(np.float32(1.5)) == GLASS and hash(tp.Dielectric(np.float64(1.5))) == hash(GLASS)
    assert tp.ThinLens(np.int64(2)) == tp.ThinLens(2.0) and tp.Glossy(1) == tp.Glossy(1.0, 1)
    assert tp.Diffuse(0.5) == tp.Diffuse(0.5, 0.0) != tp.Diffuse(0.5, 0.1)
    one, other = {GLASS: 0.5, tp.Black(): 0.5}, {tp.Black(): 0.5, GLASS: 0.5}
    assert (
        tp.Mixture(one) == tp.Mixture(other)
        and tp.TwoSided(GLASS and tp.Black(), tp.Mirror()).back == tp.Mirror()
    )
    with pytest.raises(AttributeError):
        GLASS.index_inside = 2.0


def test_parts_and_what_passes():
    half = tp.Mixture({tp.Mirror(): 0.5, tp.Diffuse(0.5, 0.1): 0.5})
    assert tp.TwoSided(tp.Black(), half).elements == (
        tp.Black(),
        *(part for part, _ in half.parts),
    )
    assert GLASS.elements == (GLASS,)
    passing = [GLASS, LENS, tp.Transparent(), tp.Mirror(0, 0.1), half, tp.TwoSided(tp.Black(), half)]
    assert all(each.is_transmissive for each in passing)
    opaque = [tp.Black(), tp.Mirror(), tp.Diffuse(1.0), tp.Glossy(0.5), tp.TwoSided(tp.Black(), tp.Mirror())]
    assert not any(each.is_transmissive for each in opaque)


def test_trapped_light_is_that_beyond_the_critical_angle():
    """A ray across the radius at r meets a ball's wall at sin = r/R; one along a cube's diagonal at cos = 1/sqrt 3."""
    edge = 1 / 1.5
    scene((BALL, GLASS), source=inside(position=(edge * (1 - 1e-9), 0, 0)))
    with pytest.raises(tp.SceneError, match="total internal reflection"):
        scene((BALL, GLASS), source=inside(position=(edge * (1 + 1e-9), 0, 0)))
    index = math.sqrt(1.5)
    scene((tp.Box(size=1), tp.Dielectric(index * (1 - 1e-9))), source=inside())
    with pytest.raises(tp.SceneError, match="total internal reflection"):
        scene((tp.Box(size=1), tp.Dielectric(index * (1 + 1e-9))), source=inside())
