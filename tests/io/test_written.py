"""A scene written as text and read again is equal bit for bit: object, program and results.  A wrong file names place, value and cure."""

from __future__ import annotations

import copy
import json
import math
import random
import re
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import transport as tp
from tests.fuzz.numbered import TURNS, world_of
from tests.refusals import assert_refused
from tests.round_trips import (
    assert_compiled_alike,
    assert_runs_alike,
    faults_of,
    read_again,
    scenes_of_tests,
)
from transport.io.json import codec
from transport.io.json.codec import (
    MAX_LISTED_NUMBERS,
    SCENE_TYPES,
    UNSUPPORTED,
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
WRITTEN = {f"scene {name}": lambda name=name: SCENES[name] for name in SCENES}
WRITTEN |= {
    f"sim {name}": lambda name=name: experiment(name).scene(**cases_of(experiment(name), {})[0])
    for name in experiment_names()
}
WRITTEN |= {  # a world of each family of the fuzz
    f"world {number}": lambda number=number: world_of(number, 1, TURNS[number]).scene()
    for number in (0, 1, 2, 3, 5, 13)
}

# ---- what is written is read back ----


def table(seed, points=40):
    """A phase function of a random table."""
    rng = np.random.default_rng(seed)
    inner = np.sort(rng.uniform(-1, 1, points - 2))
    return tp.Tabulated(mu=[-1, *inner, 1], density=rng.uniform(0, 1, points) ** 8)


@pytest.mark.quick_cases("scene tests.plain_scenes.room", "scene tests.plain_scenes.furnace")
@pytest.mark.parametrize("name", WRITTEN)
def test_a_scene_is_read_back_bit_by_bit(name):
    read_again(WRITTEN[name]())


COMPILED = "plain_scenes.vessel", "plain_scenes.meshed", "media_scenes.cloud"


@pytest.mark.slow
@pytest.mark.parametrize("name", COMPILED)
def test_a_scene_that_was_read_compiles_and_runs_the_same(name):
    """More: python -m tests.bench.written."""
    scene = SCENES[f"tests.{name}"]
    again = read_again(scene)
    assert_compiled_alike(scene, again)
    if name != "plain_scenes.vessel":
        assert_runs_alike(scene, again, particles=500, batches=4)


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
    array = np.frombuffer(bits, "i4")[:size] * 1e-3 if dtype[0] == "f" else np.frombuffer(bits, "u8")
    array = array.astype(dtype).reshape(size, 1)
    data = json.loads(pretty_print(array_to_json(array)))
    again = array_from_json(data) if isinstance(data, dict) else np.array(data, dtype)
    assert again.dtype == array.dtype and again.shape == array.shape and again.tobytes() == array.tobytes()
    assert isinstance(data, dict) == (size > MAX_LISTED_NUMBERS)


@pytest.mark.slow
def test_equal_voxels_are_written_as_one_number():
    equal = np.full((100, 100, 100), 0.25)
    other = equal.copy()
    other[0, 0, 0] = 0.5
    for absorption, most in ((equal, 1000), (other, 12_000_000)):
        grid = tp.Grid(box=tp.Box(size=1), absorption=absorption)
        scene = tp.Scene([LAMP], [tp.Surface(grid.box, tp.Transparent(), inside=grid)], [METER])
        again = tp.Scene.from_json(scene.to_json())
        assert again == scene and len(scene.to_json()) < most
        assert again.surfaces[0].inside.absorption.tobytes() == absorption.tobytes()


def test_a_normalised_table_stays_as_it_is():
    """Else it would drift by a bit each time that it is written."""
    for seed in range(50):
        one = table(seed, points=2 + 7 * seed)
        for again in (tp.Tabulated(mu=one.mu, density=one.values), replace(one)):
            assert again == one and again.g == one.g
        twice = tp.Tabulated(mu=one.mu, density=2 * one.values)
        assert math.isclose(twice.g, one.g, rel_tol=1e-12)
        more = one.values * (1 + 1e-14)
        assert not np.array_equal(tp.Tabulated(mu=one.mu, density=more).values, more)


def test_a_heavy_part_is_written_once_and_found_wherever_it_is_used():
    triangle = tp.Mesh(vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0)], faces=[(0, 1, 2)])
    law = table(1, points=200)
    ball = tp.Sphere(radius=3, center=(0, 0, 9))
    scene = tp.Scene(
        tp.Source(triangle, tp.Lambertian(power=1.0), aim=triangle),
        tp.Surface(ball, tp.Transparent(), inside=tp.Medium(1, 1, law)),
        medium=tp.Medium(2, 1, tp.Mixture({law: 0.5, tp.Rayleigh(): 0.5})),
    )
    data = json.loads(scene.to_json())
    types = {name: part["type"] for name, part in data["shared"].items()}
    assert types == {"mesh_1": "Mesh", "tabulated_1": "Tabulated"}
    assert data["scene"]["sources"][0]["aim"] == {"shared": "mesh_1"}
    assert read_again(scene).sources[0].shape is not None


def test_fields_that_follow_from_others_are_not_written():
    speed = {"type": "Maxwellian", "temperature": 300.0, "mass": 5e-26}
    gas = tp.Gas(1.0, tp.Maxwellian(temperature=300, mass=5e-26))
    assert to_json(gas) == {"type": "Gas", "density": 1.0, "speed": speed}
    assert to_json(LAMP.emission) == {"type": "Lambertian", "power": 1.0}
    water = tp.Surface(tp.Sphere(radius=1), tp.Transparent(), inside=tp.Medium(1))
    behind = replace(FLOOR, back=tp.Medium(1), inside=None)
    assert list(to_json(water)) == ["type", "shape", "material", "inside"]
    assert list(to_json(behind)) == ["type", "name", "shape", "material", "back"]
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


# ---- differences of scenes ----

WALL = replace(FLOOR, material=tp.Diffuse(0.4))
DARK = "surfaces[0].material: Black() instead of Diffuse(albedo=0.5, transmission=0.0, speed=None)"
DIFFERENCES = {
    "a number": ({"surfaces": [WALL]}, ["surfaces[0].material.albedo: 0.4 instead of 0.5"]),
    "nothing": ({"duration": 2}, ["duration: 2.0 instead of nothing"]),
    "a vector": (
        {"detectors": [replace(METER, shape=tp.Disk(radius=0.5, center=(0, 0, 2)))]},
        ["detectors[0].shape.center[2]: 2.0 instead of 1.0"],
    ),
    "a kind": ({"surfaces": [replace(FLOOR, material=tp.Black())]}, [DARK]),
    "more": ({"detectors": [METER, replace(METER, name="m")]}, ["detectors: also has 'm'"]),
    "fewer": ({"surfaces": []}, ["surfaces: lacks 'floor'"]),
    "a name": (
        {"surfaces": [replace(WALL, name="wall")]},
        ["surfaces: also has 'wall'", "surfaces: lacks 'floor'"],
    ),
    "sources": ({"sources": [LAMP, LAMP]}, ["sources: 2 instead of 1"]),
}


@pytest.mark.parametrize(("changed", "said"), DIFFERENCES.values(), ids=DIFFERENCES)
def test_differences_are_described_in_words(changed, said):
    other = replace(SCENE, **changed)
    assert differences(other, SCENE) == said
    assert differences(other, other) == differences(SCENE, tp.Scene.from_json(SCENE.to_json())) == []


@pytest.mark.parametrize(
    ("one", "other", "is_identical"),
    [
        (-0.0, -0.0, True), (0.0, -0.0, False), (math.nan, math.nan, True), (np.zeros(2), -np.zeros(2), False), (1, 1.0, False),
        (True, 1, False),
    ],
)  # fmt: skip
def test_zeros_of_both_signs_and_numbers_of_two_types_differ(one, other, is_identical):
    assert are_identical(one, other) == is_identical


def test_differences_of_arrays_and_of_order_are_described():
    one = tp.Grid(box=tp.Box(size=1), absorption=np.arange(8.0).reshape(2, 2, 2))
    other = tp.Grid(box=tp.Box(size=1), absorption=np.array([0, 1, 2, 9, 4, 5, 6, 8.0]).reshape(2, 2, 2))
    assert differences(one, other) == ["absorption[0, 1, 1]: 3.0 instead of 9.0, and 1 more of its numbers"]
    meters = [METER, replace(METER, name="m")]
    turned = replace(SCENE, detectors=meters[::-1])
    assert differences(replace(SCENE, detectors=meters), turned) == ["detectors: in another order"]
    many = replace(SCENE, sources=[replace(LAMP, shape=tp.Disk(radius=k)) for k in range(1, 21)])
    more = replace(SCENE, sources=[replace(LAMP, shape=tp.Disk(radius=k)) for k in range(101, 121)])
    assert len(differences(many, more)) == 11 and differences(many, more)[-1] == "and 10 more"


# ---- wrong files ----

TEXT = """
{"format": "transport scene", "version": 1, "shared": {"wood": {"type": "Diffuse", "albedo": 0.5}}, "scene": {"type": "Scene",
 "sources": [{"type": "Source", "shape": {"type": "Disk", "radius": 0.5}, "emission": {"type": "Lambertian", "power": 1}}],
 "surfaces": [{"type": "Surface", "name": "floor", "material": {"shared": "wood"},
               "shape": {"type": "Rectangle", "width": 4, "height": 4, "center": [0, 0, -1]}}],
 "detectors": [{"type": "Detector", "name": "meter", "shape": {"type": "Disk", "center": [0, 0, 2], "radius": 0.1}}]}}
"""
SHARED = '"wood": {"type": "Diffuse", "albedo": 0.5}'
WRONG = {  # what is written instead of what, what the refusal says, and whether the schema sees it too
    "value": ('"albedo": 0.5', '"albedo": 1.5', ["shared.wood.albedo: Diffuse: albedo must be in [0, 1], got 1.5"], False),
    "kind of value": ('"albedo": 0.5', '"albedo": "much"', ["shared.wood.albedo", "number", "'much'"], True),
    "list": ('"radius": 0.1', '"radius": [0.1]', ["detectors[0].shape.radius: Disk", "(0.1,)"], True),
    "short vector": ("[0, 0, 2]", "[0, 0]", ["detectors[0].shape.center", "three finite numbers"], True),
    "infinite": ('"radius": 0.1', '"radius": {"float": "inf"}', ["detectors[0].shape.radius", "got inf"], True),
    "unknown field": ('"albedo"', '"reflectance"', ["shared.wood.reflectance", "did you mean 'albedo'"], True),
    "missing field": ('"width": 4, ', "", ["surfaces[0].shape.width: Rectangle: width missing"], True),
    "unknown type": ('"Disk", "radius": 0.5', '"Disc", "radius": 0.5', ["sources[0].shape.type", "'Disc'", "'Disk'"], True),
    "no type": ('"type": "Lambertian", ', "", ["sources[0].emission", 'no "type"'], True),
    "other object": ('"Diffuse", "albedo": 0.5', '"Disk", "radius": 1', ["surfaces[0].material", "Disk("], False),
    "no emission": ('{"type": "Lambertian", "power": 1}', '{"type": "Black"}', ["sources[0].emission: Source"], True),
    "function": ('"Lambertian", "power": 1', '"InverseCDF"', ["sources[0].emission.type", "SpeedTable"], True),
    "side": ('"name": "meter"', '"name": "meter", "side": "bakc"', ["detectors[0].side", "'bakc'", "'back'"], True),
    "unknown name": ('"name": "meter"', '"name": "meter", "via": ["flor"]', ["detectors[0].via", "did you mean 'floor'"], False),
    "not in one scene": ('"name": "meter"', '"name": "floor"', ["detectors[0].name", "rename it"], False),
    "unknown share": ('{"shared": "wood"}', '{"shared": "wod"}', ["surfaces[0].material", "'wod'", "'wood'"], False),
    "more than a share": ('{"shared": "wood"}', '{"shared": "wood", "albedo": 1}', ["surfaces[0].material.albedo"], True),
    "share of itself": (SHARED, '"wood": {"shared": "wood"}', ["shared.wood", "contains itself"], False),
    "share of nothing": (SHARED, '"wood": 0.5', ["shared.wood", "must be an object, got 0.5"], True),
    "newer version": ('"version": 1', '"version": 2', ["version: 2 is newer than 1", "update transport"], True),
    "no version": ('"version": 1, ', "", ["version", "got None"], True),
    "other format": ("transport scene", "transport", ["format", '"transport scene"', "'transport'"], True),
    "field of the head": ('"version": 1', '"version": 1, "sceen": 1', ["sceen", "did you mean 'scene'"], True),
    "no scene": ('"scene": {"type": "Scene"', '"scene": {"type": "Disk"', ["scene.type", '"Scene"', "'Disk'"], True),
    "number of a word": ('"radius": 0.1', '"radius": NaN', ["NaN is not JSON", '{"float": "nan"}'], None),
    "said twice": (
        '"radius": 0.1', '"radius": 0.1, "radius": 0.2', ["scene.json: detectors[0].shape.radius: is given twice"], None),
    "Python's own name": ('"radius": 0.1', '"radius": 0.1, "self": 1', ["detectors[0].shape.self"], True),
    "truth for a number": ("[0, 0, 2]", "[0, 0, true]", ["detectors[0].shape.center[2]", "True"], True),
    "array for a vector": (
        "[0, 0, 2]", '{"constant": 1, "shape": [3]}', ["detectors[0].shape.center: takes no array", "write numbers"], True),
    "half of a character": (
        '"name": "meter"', r'"name": "a\ud800"', ["scene.json: detectors[0].name", r"'a\ud800'"], None),
    "half of one in a name": ('"radius": 0.1', r'"\udc00": 0.1', [r"detectors[0].shape.'\udc00'"], None),
    "no JSON": ('"radius": 0.1', '"radius": 0.1,', ["line 6", "not JSON"], None),
    "wrong and unused": (SHARED, SHARED + ', "steel": {"type": "Mirror", "albedo": 1}', ["shared.steel.albedo"], True),
    "deep": ("[0, 0, 2]", "[" * 500 + "]" * 500, ["too deeply nested"], None),
    "too deep": ("[0, 0, 2]", "[" * 100_000 + "]" * 100_000, ["too deeply nested"], None),
    "too long": ('"radius": 0.1', f'"radius": {"1" * 5000}', ["unreadable JSON"], None),
}  # fmt: skip
ARRAYS = {
    "of no shape": ({"constant": 1}, ["absorption: shape must be", "got None"]),
    "too large": ({"constant": 1, "shape": [10**6, 10**6, 10**6]}, ["absorption: shape", "1e+18"]),
    "of a number too large": ({"constant": 10**400, "shape": [1, 1, 1]}, ["absorption", "finite, got inf"]),
    "of a text": ({"constant": "a", "shape": [1]}, ["absorption: constant", "'a'"]),
    "too short": ({"base64": "AAAA", "dtype": "float64", "shape": [1]}, ["absorption: base64", "8 bytes", "got 3"]),
    "no base64": ({"base64": "A A!", "dtype": "float64", "shape": [1]}, ["absorption: base64 must be"]),
    "unknown dtype": ({"base64": "", "dtype": "object", "shape": [1]}, ["absorption: dtype", "float64", "'object'"]),
    "unknown number": ({"float": "Infinity"}, ["absorption: float", '"inf"', "'Infinity'"]),
}  # fmt: skip


@pytest.mark.parametrize(("old", "new", "words", "is_seen"), WRONG.values(), ids=WRONG)
def test_a_wrong_value_is_refused_with_its_place(old, new, words, is_seen, tmp_path):
    assert TEXT.count(old) == 1
    path = tmp_path / "scene.json"
    path.write_text(TEXT.replace(old, new), encoding="utf-8")
    assert_refused(lambda: tp.Scene.from_json(path), [*words, "scene.json: "])
    if is_seen is not None:
        assert bool(faults_of(json.loads(TEXT.replace(old, new)))) == is_seen


@pytest.mark.parametrize(("array", "words"), ARRAYS.values(), ids=ARRAYS)
def test_a_wrong_array_is_refused_with_its_place(array, words):
    grid = {"type": "Grid", "box": {"type": "Box", "size": 1}, "absorption": array}
    data = json.loads(TEXT)
    data["scene"]["surfaces"][0]["inside"] = grid
    assert_refused(lambda: tp.Scene.from_json(json.dumps(data)), ["surfaces[0].inside.absorption", *words])


def test_an_array_that_does_not_fit_into_memory_is_refused_before_it_is_made(monkeypatch):
    monkeypatch.setattr(codec, "available_memory", lambda: 1_000_000_000)
    words = r"requests 8e\+09 numbers, 128 GB .* but 1 GB of memory are left; take fewer"
    with pytest.raises(ValueError, match=words):
        array_from_json({"constant": 1, "shape": [2000, 2000, 2000]})
    assert array_from_json({"constant": 1, "shape": [100, 100, 100]}).shape == (100, 100, 100)


def test_a_long_value_is_cut_in_a_refusal():
    data = json.loads(TEXT)
    data["scene"]["detectors"][0]["type"] = [[data["scene"]["surfaces"]] * 9] * 9
    with pytest.raises(tp.SceneError, match=r"detectors\[0\].type: unknown type") as refusal:
        tp.Scene.from_json(json.dumps(data))
    assert len(str(refusal.value)) < 1200


def test_a_name_that_is_given_twice_is_found_at_once_among_many():
    names = ", ".join(f'"k{number}": 1' for number in range(50_000))
    begun = time.process_time()
    assert_refused(lambda: tp.Scene.from_json(f'{{{names}, "k49999": 2}}'), ["k49999: is given twice"])
    assert time.process_time() - begun < 5  # looking for each among all took 17 s for 30 000


def test_a_mark_of_the_byte_order_is_no_part_of_a_text(tmp_path):
    path = tmp_path / "scene.json"
    path.write_text(TEXT, encoding="utf-8-sig")
    assert tp.Scene.from_json("\ufeff" + TEXT) == tp.Scene.from_json(path) == tp.Scene.from_json(TEXT)
    path.write_text(TEXT, encoding="utf-16")
    assert_refused(lambda: tp.Scene.from_json(path), ["scene.json: cannot be read", "save it as UTF-8"])


def test_names_are_written_as_they_are_or_refused():
    data = json.loads(TEXT)
    for name in ("a\x00b", "\u202eb", "line\nline", "\U0001f600", "\\ud800", "k" * 1000):
        data["scene"]["detectors"][0]["name"] = name
        assert read_again(tp.Scene.from_json(json.dumps(data))).detectors[0].name == name
    wrong = replace(tp.Scene.from_json(TEXT), detectors=[tp.Detector(tp.Disk(radius=1), name="a\ud800")])
    assert_refused(wrong.to_json, ["detectors[0].name", r"'\ud800' is half of a character", "leave it out"])


def test_a_single_object_stands_for_a_list_in_files_too():
    data = json.loads(TEXT)
    assert faults_of(data) == []
    scene = tp.Scene.from_json(TEXT)
    assert scene.surface("floor").material == tp.Diffuse(0.5)
    for parts in ("sources", "surfaces", "detectors"):
        data["scene"][parts] = data["scene"][parts][0]
    assert tp.Scene.from_json(json.dumps(data)) == scene and faults_of(data) == []


@pytest.mark.parametrize("source", ["no_such.json", "/", 3, b"{}", "{", "[]", ""])
def test_what_is_no_file_and_no_text_is_refused(source, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert_refused(lambda: tp.Scene.from_json(source), [])


class Velvet(tp.Diffuse):
    """A material of the user."""


def test_objects_that_no_file_can_hold_are_refused_with_their_place_and_the_cure():
    gas = tp.Source(tp.Box(size=1), tp.Gas(1.0, tp.InverseCDF(lambda u: 1 + u)))
    function = tp.Scene([gas], duration=1.0)
    assert_refused(function.to_json, ["sources[0].emission.speed", "InverseCDF", "SpeedTable"])
    velvet = tp.Scene(LAMP, tp.Surface(tp.Sphere(radius=1), Velvet(0.5)))
    assert_refused(velvet.to_json, ["surfaces[0].material", "Velvet"])


@pytest.mark.slow
def test_random_faults_are_refused_in_words():
    """Files with a random fault give a SceneError or a scene, and no other error."""
    chance = random.Random(1)
    files = [json.loads(scene.to_json()) for scene in SCENES.values()]
    refused = sum(_is_refused(json.dumps(_spoilt(chance.choice(files), chance))) for _ in range(300))
    assert refused > 200


JUNK = (
    None, True, "x", "", -1, 0, 10**30, 1.5, [], [1], [1, 2, 3], ["a", "b", "c"], [[1, 2], [3]], {}, {"type": "Disk", "radius": 1},
    {"type": "Black"}, {"type": ["x"]}, {"shared": [1]}, {"float": "nan"}, {"constant": 1, "shape": [2, 2, 2]},
    {"base64": "AAAA", "dtype": "int32", "shape": [1]}, {"type": "Isotropic"}, [[{"type": "Black"}, 1]],
)  # fmt: skip


def _spoilt(data, chance):
    data = copy.deepcopy(data)
    part, place = chance.choice(list(_places(data)))
    if chance.random() < 0.2:
        del part[place]
    else:
        part[place] = chance.choice(JUNK)
    return data


def _places(data):
    inner = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for place, value in inner:
        yield data, place
        yield from _places(value)


def _is_refused(text):
    try:
        tp.Scene.from_json(text)
    except tp.SceneError as refusal:
        assert len(str(refusal)) < 1500
        return True
    return False


def test_every_kind_of_object_is_known_to_files():
    """What `scene_object` makes can be written, or its refusal has a reason; a Scene is the parts that passed."""
    found = set()
    for path in sorted(Path(tp.__file__).parent.rglob("*.py")):
        found |= set(re.findall(r"^@scene_object.*\nclass (\w+)", path.read_text(encoding="utf-8"), re.M))
    assert found - {"SceneParts"} == SCENE_TYPES.keys() | UNSUPPORTED.keys()
