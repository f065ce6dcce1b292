"""Materials: what is refused when one is made, put on a shape or in a scene; metals, by themselves and in scenes.

Each statistical judgement fails right code in one of 10^5 seeds; the seed is 1.
"""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import quad

import transport as tp
from tests.agreement import assert_agrees
from tests.refusals import assert_refused
from transport.compile.compiler import compile_scene
from transport.engine.program import build_program
from transport.physics import interfaces

LAMP = tp.Source(tp.Point(position=(0, 0, 5)), tp.Isotropic(power=1))
BALL, DISK = tp.Sphere(radius=1), tp.Disk(radius=1)
GLASS, LENS = tp.Dielectric(1.5), tp.ThinLens(0.1)
NAN = math.nan
METAL = tp.Conductor(n=0.2, k=3.4)  # about gold in red light


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
    # indices
    "index 0": (lambda: tp.Dielectric(0), ["Dielectric: index_inside", "positive", "got 0"]),
    "index of text": (lambda: tp.Dielectric("glass"), ["Dielectric: index_inside", "number", "'glass'"]),
    "one index": (lambda: tp.Dielectric(index_outside=1.3), ["Dielectric: index_inside missing"]),
    # roughness
    "smooth": (lambda: tp.Glossy(0), ["Glossy: roughness", "above 0", "got 0", "Mirror"]),
    "too rough": (lambda: tp.Glossy(1.01), ["Glossy: roughness", "at most 1", "1.01"]),
    "glossy albedo": (lambda: tp.Glossy(0.1, 1.5), ["Glossy: albedo", "[0, 1]", "1.5"]),
    # lenses
    "flat lens": (lambda: tp.ThinLens(0), ["ThinLens: focal_length", "not zero", "Transparent()"]),
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
REFUSALS |= {
    "a metal without loss": (lambda: tp.Conductor(0.2, 0), ["use Dielectric"]),
    "a metal that gains": (lambda: tp.Conductor(0.2, -1), ["k must be positive"]),
    "a metal without index": (lambda: tp.Conductor(0, 2), ["n must be positive"]),
    "a metal too dense": (lambda: tp.Conductor(1e6, 1e6), ["from 0.001 to 1e+06"]),
    "a metal too thin": (lambda: tp.Conductor(1e-4, 1e-4), ["from 0.001 to 1e+06"]),
    "a metal for particles": (
        lambda: scene((BALL, METAL), source=tp.Source(DISK, tp.Effusive(exitance=1.0, speed=300.0))),
        ["must not be a Conductor in a scene of particles"],
    ),
} | {
    f"reflectance at {mu}": (lambda mu=mu: METAL.reflectance(mu), ["mu must be a cosine in [0, 1]"])
    for mu in (-0.1, 1.1, NAN, [0.5, 2.0])
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


# ---- metals: Fresnel's reflectance with a complex index ----

INDICES = [
    (0.055, 3.6), (1.2, 7.3), (2.9, 3.1), (1 + 1e-12, 1e-12), (1 - 1e-9, 1e-6), (0.03, 1e-3), (1e-3, 1e-6), (1e-6, 1e6 / 2),
    (1e6 / 2, 1e-6), (1.5, 1e-12), (0.5, 0.5), (1e3, 1e3),
]  # fmt: skip
plain_reflectance = getattr(interfaces.metallic_reflectance, "py_func", interfaces.metallic_reflectance)


def textbook(cosine, n=METAL.n, k=METAL.k):
    """Born and Wolf (1999), 1.5.2 with a complex index, in 50 digits."""
    with mp.workdps(50):
        c, index = mp.mpf(float(cosine)), mp.mpc(float(n), float(k))
        root = mp.sqrt(index**2 - (1 - c) * (1 + c))
        s, p = (c - root) / (c + root), (index**2 * c - root) / (index**2 * c + root)
        return (abs(s) ** 2 + abs(p) ** 2) / 2


@pytest.mark.parametrize("n, k", INDICES)
def test_the_reflectance_is_exact_to_rounding_from_grazing_to_the_normal(n, k):
    """Relative; where |index|^2 is far below 1, its difference from the squared sine costs so many digits."""
    row = tp.Conductor(n, k).row()
    tolerance = 4e-15 + 1e-15 / min(1.0, n * n + k * k)
    for cosine in (*np.geomspace(1e-300, 1, 40), *np.linspace(0.01, 1, 40), 1 - 1e-9, 1 - 2**-53):
        exact, found = textbook(cosine, n, k), plain_reflectance(cosine, row.excess, row.loss)
        assert abs(found - exact) <= tolerance * exact
        assert found <= 1


def test_the_reflectance_of_a_conductor_is_that_of_the_engine():
    row, mu = METAL.row(), np.linspace(0, 1, 101)
    assert METAL.reflectance(mu) == pytest.approx(
        [plain_reflectance(c, row.excess, row.loss) for c in mu], rel=1e-13
    )
    assert METAL.reflectance(1.0) == pytest.approx((0.8**2 + 3.4**2) / (1.2**2 + 3.4**2), rel=1e-14)


def beam_on(material, angle, is_behind=False, particles=1000):
    """Power of a pencil beam that a disk absorbs and sends on to a black ball."""
    side = -1 if is_behind else 1
    direction = (math.sin(angle), 0, -side * math.cos(angle))
    lamp = tp.Source(tp.Point(position=tuple(-x for x in direction)), tp.Beam(power=1.0, direction=direction))
    surfaces = [
        tp.Surface(tp.Disk(radius=0.5), material, "disk"),
        tp.Surface(tp.Sphere(radius=3), tp.Black(), "ball"),
    ]
    ledger = tp.simulate(tp.Scene([lamp], surfaces), particles, seed=1, progress=False).ledger
    return ledger.absorbed_by["disk"], ledger.absorbed_by["ball"]


@pytest.mark.parametrize("is_behind", [False, True])
@pytest.mark.parametrize("degrees", [0, 30, 80, 89.9])
def test_a_beam_is_reflected_by_the_law_and_the_rest_is_absorbed(degrees, is_behind):
    """An extinction that is off by 1 % is seen."""
    kept, sent = (power.value for power in beam_on(METAL, math.radians(degrees), is_behind))
    cosine = math.cos(math.radians(degrees))
    exact = float(textbook(cosine))
    assert (kept, sent) == (pytest.approx(1 - exact, rel=1e-12), pytest.approx(exact, rel=1e-12))
    assert kept != pytest.approx(1 - float(textbook(cosine, METAL.n, 1.01 * METAL.k)), rel=1e-3)


def test_a_metal_is_one_side_or_a_part_of_a_mixture():
    exact = float(textbook(math.cos(0.7)))
    for front, back, share in ((METAL, tp.Black(), 1.0), (tp.Black(), METAL, 0.0)):
        assert beam_on(tp.TwoSided(front=front, back=back), 0.7)[1].value == pytest.approx(
            share * exact, rel=1e-12
        )
    found = beam_on(tp.Mixture({METAL: 0.25, tp.Black(): 0.75}), 0.7, particles=40_000)[1]
    assert_agrees(found, 0.25 * exact)
    with pytest.raises(AssertionError):  # a share 10 % too large
        assert_agrees(found, 0.275 * exact)


def room(metal, **of_detector):
    """A lamp and a detector side by side under a ceiling of metal; a black floor around."""
    lamp = tp.Source(tp.Disk(center=(-0.5, 0, 0), radius=0.3), tp.Lambertian(power=1.0))
    ceiling = tp.Surface(
        tp.Rectangle(center=(0, 0, 1), width=4, height=4, normal=(0, 0, -1)), metal, "ceiling"
    )
    return tp.Scene([lamp], [ceiling], [tp.Detector(tp.Disk(center=(0.5, 0, 0), radius=0.3), "meter")])


def test_diffuse_light_is_absorbed_by_the_mean_over_the_cosine_law():
    lamp = tp.Source(tp.Disk(radius=1.0), tp.Lambertian(power=1.0))
    wall = tp.Surface(tp.Plane(center=(0, 0, 1), normal=(0, 0, -1)), METAL, "wall")
    result = tp.simulate(tp.Scene([lamp], [wall], [tp.Detector("wall", side="front")]), 200_000, seed=1)
    exact, _ = quad(lambda mu: 2 * mu * float(METAL.reflectance(mu)), 0, 1, epsabs=1e-12)
    assert_agrees(result["wall"].flux_out / result["wall"].flux_in, exact)


def test_metal_is_the_same_forwards_and_backwards():
    """Without the absorption it would be seen."""
    back = tp.simulate(room(tp.Conductor(2.9, 3.1)), 100_000, seed=1, estimator="backward", progress=False)[
        "meter"
    ].flux_in
    metal, mirror = (
        tp.simulate(room(material), 500_000, seed=1, estimator="analog", progress=False)["meter"].flux_in
        for material in (tp.Conductor(2.9, 3.1), tp.Mirror())
    )
    assert_agrees(metal - back, 0.0)
    with pytest.raises(AssertionError):
        assert_agrees(back - mirror, 0.0)


def test_scenes_of_metal_alone_have_its_passes_and_files_keep_it():
    scene = room(METAL)
    names = {each.name for each in build_program(compile_scene(scene)).passes}
    plain = {each.name for each in build_program(compile_scene(room(tp.Mirror(0.5)))).passes}
    assert names - plain == {"look_up_metal", "reflect_by_metal"} and not plain - names
    assert tp.Scene.from_json(scene.to_json()) == scene


def test_lanes_without_a_particle_have_no_reflectance():
    """Batches of 63 leave lanes empty, whose normal on a ball is 0/0."""
    ball = tp.Surface(tp.Sphere(radius=1.0), METAL, "ball")
    room = tp.Surface(tp.Box(size=6.0), tp.Black(), "room")
    lamp = tp.Source(tp.Point(position=(0, 0, 2)), tp.Isotropic(power=1.0))
    result = tp.simulate(tp.Scene([lamp], [room, ball]), 2000, seed=1, threads=1, progress=False)
    total = sum(each.value for each in result.ledger.absorbed_by.values())
    assert total == pytest.approx(1.0, rel=1e-12)
