"""Metals: Fresnel's reflectance with a complex index, by itself and in scenes.

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
from transport.compile.compiler import compile_scene
from transport.engine.program import build_program
from transport.physics import interfaces

mp.mp.dps = 50
METAL = tp.Conductor(n=0.2, k=3.4)  # about gold in red light
INDICES = [
    (0.055, 3.6),
    (1.2, 7.3),
    (2.9, 3.1),
    (1 + 1e-12, 1e-12),
    (1 - 1e-9, 1e-6),
    (0.03, 1e-3),
    (1e-3, 1e-6),
]
INDICES += [(1e-6, 1e6 / 2), (1e6 / 2, 1e-6), (1.5, 1e-12), (0.5, 0.5), (1e3, 1e3)]
reflectance = getattr(interfaces.metallic_reflectance, "py_func", interfaces.metallic_reflectance)


def textbook(cosine, n, k):
    """Born and Wolf (1999), 1.5.2 with a complex index."""
    c, index = mp.mpf(float(cosine)), mp.mpc(float(n), float(k))
    root = mp.sqrt(index**2 - (1 - c) * (1 + c))
    return (abs((c - root) / (c + root)) ** 2 + abs((index**2 * c - root) / (index**2 * c + root)) ** 2) / 2


@pytest.mark.parametrize("n, k", INDICES)
def test_the_reflectance_is_exact_to_rounding_from_grazing_to_the_normal(n, k):
    """Relative; where |index|^2 is far below 1, its difference from the squared sine costs so many digits."""
    row = tp.Conductor(n, k).row()
    tolerance = 4e-15 + 1e-15 / min(1.0, n * n + k * k)
    for cosine in (*np.geomspace(1e-300, 1, 40), *np.linspace(0.01, 1, 40), 1 - 1e-9, 1 - 2**-53):
        exact, found = textbook(cosine, n, k), reflectance(cosine, row.excess, row.loss)
        assert abs(found - exact) <= tolerance * exact
        assert found <= 1


def test_the_user_s_reflectance_is_the_engine_s():
    row, mu = METAL.row(), np.linspace(0, 1, 101)
    assert METAL.reflectance(mu) == pytest.approx(
        [reflectance(c, row.excess, row.loss) for c in mu], rel=1e-13
    )
    assert METAL.reflectance(1.0) == pytest.approx((0.8**2 + 3.4**2) / (1.2**2 + 3.4**2), rel=1e-14)


def beam(material, angle, is_behind=False):
    """A pencil beam on a disk at an angle to its normal, and a black ball around both."""
    side = -1 if is_behind else 1
    direction = (math.sin(angle), 0, -side * math.cos(angle))
    lamp = tp.Source(tp.Point(position=tuple(-x for x in direction)), tp.Beam(power=1.0, direction=direction))
    disk = tp.Surface(tp.Disk(radius=0.5), material, "disk")
    ball = tp.Surface(tp.Sphere(radius=3), tp.Black(), "ball")
    return tp.Scene([lamp], [disk, ball], [tp.Detector("disk")])


def absorbed(result, name):
    return result.ledger.absorbed_by[name].value


@pytest.mark.parametrize("is_behind", [False, True])
@pytest.mark.parametrize("degrees", [0, 30, 80, 89.9])
def test_a_beam_is_reflected_by_the_law_and_the_rest_is_absorbed(degrees, is_behind):
    angle = math.radians(degrees)
    result = tp.simulate(beam(METAL, angle, is_behind), particles=1000, seed=1, progress=False)
    exact = float(textbook(math.cos(angle), METAL.n, METAL.k))
    assert absorbed(result, "disk") == pytest.approx(1 - exact, rel=1e-12)
    assert absorbed(result, "ball") == pytest.approx(exact, rel=1e-12)


def test_a_wrong_index_is_rejected():
    """Planted: the extinction off by 1 %."""
    result = tp.simulate(beam(METAL, 0.5), particles=1000, seed=1, progress=False)
    assert absorbed(result, "disk") != pytest.approx(
        1 - float(textbook(math.cos(0.5), METAL.n, 1.01 * METAL.k)), rel=1e-3
    )


@pytest.mark.parametrize(
    "material, share",
    [
        (tp.TwoSided(front=METAL, back=tp.Black()), 1.0),
        (tp.TwoSided(front=tp.Black(), back=METAL), 0.0),
    ],
)
def test_a_metal_is_one_side(material, share):
    result = tp.simulate(beam(material, 0.7), particles=1000, seed=1, progress=False)
    exact = share * float(textbook(math.cos(0.7), METAL.n, METAL.k))
    assert absorbed(result, "ball") == pytest.approx(exact, rel=1e-12)


def test_a_metal_is_a_part_of_a_mixture():
    material = tp.Mixture({METAL: 0.25, tp.Black(): 0.75})
    result = tp.simulate(beam(material, 0.7), particles=40_000, seed=1, progress=False)
    found = result.ledger.absorbed_by["ball"]
    assert_agrees(found, 0.25 * float(textbook(math.cos(0.7), METAL.n, METAL.k)))
    with pytest.raises(AssertionError):  # planted: a share 10 % too large
        assert_agrees(found, 0.275 * float(textbook(math.cos(0.7), METAL.n, METAL.k)))


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


def test_forwards_and_backwards_agree():
    scene = room(tp.Conductor(2.9, 3.1))
    forward = tp.simulate(scene, 2_000_000, seed=1, estimator="analog", progress=False)["meter"].flux_in
    back = tp.simulate(scene, 100_000, seed=1, estimator="backward", progress=False)["meter"].flux_in
    assert_agrees(forward - back, 0.0)
    perfect = tp.simulate(room(tp.Mirror()), 2_000_000, seed=1, estimator="analog", progress=False)
    with pytest.raises(AssertionError):  # planted: without the absorption
        assert_agrees(back - perfect["meter"].flux_in, 0.0)


def test_its_scene_alone_has_its_pass_and_files_keep_it():
    scene = room(METAL)
    names = {each.name for each in build_program(compile_scene(scene)).passes}
    plain = {each.name for each in build_program(compile_scene(room(tp.Mirror(0.5)))).passes}
    assert names - plain == {"look_up_metal", "reflect_by_metal"} and not plain - names
    assert tp.Scene.from_json(scene.to_json()) == scene


@pytest.mark.parametrize(
    "n, k, message",
    [
        (0.2, 0, "use Dielectric"),
        (0.2, -1, "k must be positive"),
        (0, 2, "n must be positive"),
        (math.nan, 2, "n must be positive"),
        (1e6, 1e6, "from 0.001 to 1e\\+06"),
        (1e-4, 1e-4, "from 0.001 to 1e\\+06"),
    ],
)
def test_wrong_indices_are_refused(n, k, message):
    with pytest.raises(tp.SceneError, match=message):
        tp.Conductor(n, k)


def test_it_is_for_light_alone():
    gas = tp.Source(tp.Disk(radius=1.0), tp.Effusive(exitance=1.0, speed=300.0))
    wall = tp.Surface(tp.Plane(center=(0, 0, 1)), METAL, "wall")
    with pytest.raises(tp.SceneError, match="must not be a Conductor in a scene of particles"):
        tp.Scene([gas], [wall], [tp.Detector("wall")])


def test_lanes_without_a_particle_have_no_reflectance():
    """Batches of 63 leave lanes empty, whose normal on a ball is 0/0."""
    ball = tp.Surface(tp.Sphere(radius=1.0), METAL, "ball")
    room = tp.Surface(tp.Box(size=6.0), tp.Black(), "room")
    lamp = tp.Source(tp.Point(position=(0, 0, 2)), tp.Isotropic(power=1.0))
    result = tp.simulate(tp.Scene([lamp], [room, ball]), 2000, seed=1, threads=1, progress=False)
    total = sum(each.value for each in result.ledger.absorbed_by.values())
    assert total == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("mu", [-0.1, 1.1, math.nan, [0.5, 2.0]])
def test_the_reflectance_is_of_cosines(mu):
    with pytest.raises(tp.SceneError, match=r"mu must be a cosine in \[0, 1\]"):
        METAL.reflectance(mu)
