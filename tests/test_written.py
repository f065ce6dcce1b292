"""A scene written as text and read again is equal bit for bit: object, program and results."""

from __future__ import annotations

import json
import math
import random
from dataclasses import replace

import numpy as np
import pytest

import transport as tp
from tests.fuzz.numbered import TURNS, world_of
from tests.mesh_scenes import mesh
from tests.round_trips import assert_compiled_alike, assert_runs_alike, read_again, scenes_of_tests
from transport.io.json.codec import (
    MAX_LISTED_NUMBERS,
    Reader,
    array_from_json,
    array_to_json,
    number_from_json,
    number_to_json,
    to_json,
)
from transport.io.json.differences import are_identical, differences
from transport.io.json.text import WIDTH, pretty_print
from transport.verification.experiment import cases_of, experiment, experiment_names

SCENES = dict(scenes_of_tests())
LAMP = tp.Source(tp.Disk(radius=1.0), tp.Lambertian(power=1.0))
FLOOR = tp.Surface(tp.Rectangle(width=4, height=4, center=(0, 0, -1)), tp.Diffuse(0.5), "floor")
METER = tp.Detector(tp.Disk(radius=0.5, center=(0, 0, 1)), "meter")
SCENE = tp.Scene([LAMP], [FLOOR], [METER])


def table(seed, points=40):
    """A phase function of a random table."""
    rng = np.random.default_rng(seed)
    inner = np.sort(rng.uniform(-1, 1, points - 2))
    return tp.Tabulated(mu=[-1, *inner, 1], density=rng.uniform(0, 1, points) ** 8)


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_of_the_tests_is_read_back_bit_by_bit(name):
    read_again(SCENES[name])


@pytest.mark.parametrize("name", experiment_names())
def test_the_first_scene_of_an_experiment_is_read_back_bit_by_bit(name):
    read_again(experiment(name).scene(**cases_of(experiment(name), {})[0]))


@pytest.mark.parametrize("number", [0, 1, 2, 3, 5, 13])  # a world of each family of the fuzz
def test_a_random_world_is_read_back_bit_by_bit(number):
    read_again(world_of(number, 1, TURNS[number]).scene())


@pytest.mark.parametrize("name", ["plain_scenes.vessel", "plain_scenes.meshed", "media_scenes.cloud"])
def test_what_was_read_compiles_to_the_same_program(name):
    scene = SCENES[f"tests.{name}"]
    assert_compiled_alike(scene, read_again(scene))


@pytest.mark.parametrize(
    "name", ["plain_scenes.meshed", "media_scenes.cloud"]
)  # more: python -m tests.bench.written
def test_what_was_read_runs_the_same(name):
    scene = SCENES[f"tests.{name}"]
    assert_runs_alike(scene, read_again(scene), particles=500, batches=4)


def test_another_scene_compiles_and_runs_otherwise():
    """The last bit of a radius is seen by all that says that scenes are the same."""
    other = replace(
        SCENE, detectors=[tp.Detector(tp.Disk(radius=math.nextafter(0.5, 1), center=(0, 0, 1)), "meter")]
    )
    assert other.to_json() != SCENE.to_json()
    with pytest.raises(AssertionError, match="tables"):
        assert_compiled_alike(SCENE, other)
    with pytest.raises(AssertionError, match="of meter"):
        assert_runs_alike(SCENE, other, particles=500, batches=4)


@pytest.mark.parametrize(
    "number", [0.1, 5e-324, 1.7976931348623157e308, -0.0, math.pi, math.inf, -math.inf, math.nan, 1e22]
)
def test_a_number_keeps_every_bit(number):
    data = json.loads(pretty_print(number_to_json(number)))
    again = number_from_json(data) if isinstance(data, dict) else data
    assert again.hex() == number.hex()


@pytest.mark.parametrize("size", [1, MAX_LISTED_NUMBERS, MAX_LISTED_NUMBERS + 1, 5000])
@pytest.mark.parametrize("dtype", ["float64", "float32", "int64", "int32", "uint8"])
def test_an_array_keeps_every_bit(size, dtype):
    bits = random.Random(size).randbytes(8 * size)
    array = (
        np.frombuffer(bits, "u8").astype(dtype)
        if dtype[0] != "f"
        else np.frombuffer(bits, "i4")[:size] * 1e-3
    )
    array = array.astype(dtype).reshape(size, 1)
    data = json.loads(pretty_print(array_to_json(array)))
    again = array_from_json(data) if isinstance(data, dict) else np.array(data, dtype)
    assert again.dtype == array.dtype and again.shape == array.shape and again.tobytes() == array.tobytes()
    assert isinstance(data, dict) == (size > MAX_LISTED_NUMBERS)


def test_voxels_that_are_all_alike_are_one_number():
    same = np.full((100, 100, 100), 0.25)
    same[0, 0, 0] = 0.5
    for absorption, most in ((np.full((100, 100, 100), 0.25), 1000), (same, 12_000_000)):
        grid = tp.Grid(box=tp.Box(size=1), absorption=absorption)
        scene = tp.Scene([LAMP], [tp.Surface(grid.box, tp.Transparent(), inside=grid)], [METER])
        again = tp.Scene.from_json(scene.to_json())
        assert again == scene and len(scene.to_json()) < most
        assert again.surfaces[0].inside.absorption.tobytes() == absorption.tobytes()


@pytest.mark.parametrize("seed", range(50))
def test_a_table_that_is_normalised_stays_as_it_is(seed):
    """Else it would drift by a bit each time that it is written."""
    one = table(seed, points=2 + 7 * seed)
    for again in (tp.Tabulated(mu=one.mu, density=one.values), replace(one)):
        assert again == one and again.g == one.g
    twice = tp.Tabulated(mu=one.mu, density=2 * one.values)
    assert math.isclose(twice.g, one.g, rel_tol=1e-12)
    assert not np.array_equal(
        tp.Tabulated(mu=one.mu, density=one.values * (1 + 1e-14)).values, one.values * (1 + 1e-14)
    )


def test_a_heavy_part_is_written_once_and_found_wherever_it_is_used():
    triangle = mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    law = table(1, points=200)
    scene = tp.Scene(
        [tp.Source(triangle, tp.Lambertian(power=1.0), aim=triangle)],
        [tp.Surface(tp.Sphere(radius=3, center=(0, 0, 9)), tp.Transparent(), inside=tp.Medium(1, 1, law))],
        medium=tp.Medium(2, 1, tp.Mixture({law: 0.5, tp.Rayleigh(): 0.5})),
    )
    data = json.loads(scene.to_json())
    assert {name: part["type"] for name, part in data["shared"].items()} == {
        "mesh_1": "Mesh",
        "tabulated_1": "Tabulated",
    }
    assert data["scene"]["sources"][0]["aim"] == {"shared": "mesh_1"}
    assert read_again(scene).sources[0].shape is not None


def test_what_follows_from_other_fields_is_not_written():
    gas = tp.Gas(1.0, tp.Maxwellian(temperature=300, mass=5e-26))
    water = tp.Surface(tp.Sphere(radius=1), tp.Transparent(), inside=tp.Medium(1))
    assert to_json(gas) == {
        "type": "Gas",
        "density": 1.0,
        "speed": {"type": "Maxwellian", "temperature": 300.0, "mass": 5e-26},
    }
    assert to_json(LAMP.emission) == {"type": "Lambertian", "power": 1.0}
    assert list(to_json(water)) == ["type", "shape", "material", "inside"]
    assert list(to_json(replace(FLOOR, back=tp.Medium(1), inside=None))) == [
        "type",
        "name",
        "shape",
        "material",
        "back",
    ]
    assert "name" not in to_json(tp.Detector("floor"))
    assert to_json(tp.Detector("floor", "other"))["name"] == "other"


PARTS = (
    tp.Tracking(roulette=1e-3, forced=True),
    tp.Lambertian(power=1, speed=2.0),
    tp.Gas(1.0, tp.Maxwellian(sigma=1.0), mass=2.0),
    tp.Medium(),
)


@pytest.mark.parametrize("part", PARTS, ids=repr)
def test_any_object_can_be_written_alone(part):
    assert are_identical(Reader({}).value(json.loads(pretty_print(to_json(part))), ""), part)


def test_text_is_laid_out_for_people():
    lines = SCENE.to_json().splitlines()
    assert max(map(len, lines)) <= WIDTH and len(lines) < 40
    assert '        "emission": {"type": "Lambertian", "power": 1.0}' in lines
    long = list(range(1000))
    assert json.loads(pretty_print({"numbers": long})) == {"numbers": long}
    assert max(map(len, pretty_print({"numbers": long}).splitlines())) <= WIDTH


def test_a_file_is_written_and_read(tmp_path):
    path = tmp_path / "scene.json"
    assert SCENE.to_json(path) == path.read_text(encoding="utf-8")
    assert tp.Scene.from_json(path) == tp.Scene.from_json(str(path)) == SCENE
    with pytest.raises(tp.SceneError, match="make the folder"):
        SCENE.to_json(tmp_path / "none" / "scene.json")


WALL = replace(FLOOR, material=tp.Diffuse(0.4))
DIFFERENCES = {
    "a number": (replace(SCENE, surfaces=[WALL]), ["surfaces[0].material.albedo: 0.4 instead of 0.5"]),
    "nothing": (replace(SCENE, duration=2), ["duration: 2.0 instead of nothing"]),
    "a vector": (
        replace(SCENE, detectors=[replace(METER, shape=tp.Disk(radius=0.5, center=(0, 0, 2)))]),
        ["detectors[0].shape.center[2]: 2.0 instead of 1.0"],
    ),
    "a kind": (
        replace(SCENE, surfaces=[replace(FLOOR, material=tp.Black())]),
        ["surfaces[0].material: Black() instead of Diffuse(albedo=0.5, transmission=0.0, speed=None)"],
    ),
    "more": (replace(SCENE, detectors=[METER, replace(METER, name="m")]), ["detectors: also has 'm'"]),
    "fewer": (replace(SCENE, surfaces=[]), ["surfaces: lacks 'floor'"]),
    "a name": (
        replace(SCENE, surfaces=[replace(WALL, name="wall")]),
        ["surfaces: also has 'wall'", "surfaces: lacks 'floor'"],
    ),
    "sources": (replace(SCENE, sources=[LAMP, LAMP]), ["sources: 2 instead of 1"]),
}


@pytest.mark.parametrize(("other", "said"), DIFFERENCES.values(), ids=DIFFERENCES)
def test_differences_are_told_in_words(other, said):
    assert differences(other, SCENE) == said
    assert differences(other, other) == differences(SCENE, tp.Scene.from_json(SCENE.to_json())) == []


def test_zeros_of_both_signs_differ():
    assert are_identical(-0.0, -0.0) and not are_identical(0.0, -0.0) and are_identical(math.nan, math.nan)
    assert (
        not are_identical(np.zeros(2), -np.zeros(2))
        and not are_identical(1, 1.0)
        and not are_identical(True, 1)
    )


def test_differences_of_arrays_and_of_order_are_told():
    one = tp.Grid(box=tp.Box(size=1), absorption=np.arange(8.0).reshape(2, 2, 2))
    other = tp.Grid(box=tp.Box(size=1), absorption=np.array([0, 1, 2, 9, 4, 5, 6, 8.0]).reshape(2, 2, 2))
    assert differences(one, other) == ["absorption[0, 1, 1]: 3.0 instead of 9.0, and 1 more of its numbers"]
    meters = [METER, replace(METER, name="m")]
    turned = replace(SCENE, detectors=meters[::-1])
    assert differences(replace(SCENE, detectors=meters), turned) == ["detectors: in another order"]
    many = replace(SCENE, sources=[replace(LAMP, shape=tp.Disk(radius=k)) for k in range(1, 21)])
    more = replace(SCENE, sources=[replace(LAMP, shape=tp.Disk(radius=k)) for k in range(101, 121)])
    assert len(differences(many, more)) == 11 and differences(many, more)[-1] == "and 10 more"
