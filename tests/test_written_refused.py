"""A wrong scene file is an error that names the place, the value and the cure."""

from __future__ import annotations

import copy
import json
import random
import re
import time
from dataclasses import replace
from pathlib import Path

import pytest

import transport as tp
from tests.refusals import assert_refused
from tests.round_trips import faults_of, read_again, scenes_of_tests
from transport.io.json import codec
from transport.io.json.codec import SCENE_TYPES, UNSUPPORTED, array_from_json

ROOT = Path(__file__).resolve().parents[1]
TEXT = """
{"format": "transport scene", "version": 1, "shared": {"wood": {"type": "Diffuse", "albedo": 0.5}}, "scene": {"type": "Scene",
 "sources": [{"type": "Source", "shape": {"type": "Disk", "radius": 0.5}, "emission": {"type": "Lambertian", "power": 1}}],
 "surfaces": [{"type": "Surface", "name": "floor", "material": {"shared": "wood"},
               "shape": {"type": "Rectangle", "width": 4, "height": 4, "center": [0, 0, -1]}}],
 "detectors": [{"type": "Detector", "name": "meter", "shape": {"type": "Disk", "center": [0, 0, 2], "radius": 0.1}}]}}
"""
SHARED = '"wood": {"type": "Diffuse", "albedo": 0.5}'
WRONG = {  # what is written instead of what, what the refusal says, and whether the schema sees it too
    "value": (
        '"albedo": 0.5',
        '"albedo": 1.5',
        ["shared.wood.albedo: Diffuse: albedo must be in [0, 1], got 1.5"],
        False,
    ),
    "kind of value": ('"albedo": 0.5', '"albedo": "much"', ["shared.wood.albedo", "number", "'much'"], True),
    "list": ('"radius": 0.1', '"radius": [0.1]', ["detectors[0].shape.radius: Disk", "(0.1,)"], True),
    "short vector": ("[0, 0, 2]", "[0, 0]", ["detectors[0].shape.center", "three finite numbers"], True),
    "infinite": (
        '"radius": 0.1',
        '"radius": {"float": "inf"}',
        ["detectors[0].shape.radius", "got inf"],
        True,
    ),
    "unknown field": (
        '"albedo"',
        '"reflectance"',
        ["shared.wood.reflectance", "did you mean 'albedo'"],
        True,
    ),
    "missing field": ('"width": 4, ', "", ["surfaces[0].shape.width: Rectangle: width missing"], True),
    "unknown type": (
        '"Disk", "radius": 0.5',
        '"Disc", "radius": 0.5',
        ["sources[0].shape.type", "'Disc'", "'Disk'"],
        True,
    ),
    "no type": ('"type": "Lambertian", ', "", ["sources[0].emission", 'no "type"'], True),
    "other object": (
        '"Diffuse", "albedo": 0.5',
        '"Disk", "radius": 1',
        ["surfaces[0].material", "Disk("],
        False,
    ),
    "no emission": (
        '{"type": "Lambertian", "power": 1}',
        '{"type": "Black"}',
        ["sources[0].emission: Source"],
        True,
    ),
    "function": (
        '"Lambertian", "power": 1',
        '"InverseCDF"',
        ["sources[0].emission.type", "SpeedTable"],
        True,
    ),
    "side": (
        '"name": "meter"',
        '"name": "meter", "side": "bakc"',
        ["detectors[0].side", "'bakc'", "'back'"],
        True,
    ),
    "unknown name": (
        '"name": "meter"',
        '"name": "meter", "via": ["flor"]',
        ["detectors[0].via", "did you mean 'floor'"],
        False,
    ),
    "not in one scene": ('"name": "meter"', '"name": "floor"', ["detectors[0].name", "rename it"], False),
    "unknown share": (
        '{"shared": "wood"}',
        '{"shared": "wod"}',
        ["surfaces[0].material", "'wod'", "'wood'"],
        False,
    ),
    "more than a share": (
        '{"shared": "wood"}',
        '{"shared": "wood", "albedo": 1}',
        ["surfaces[0].material.albedo"],
        True,
    ),
    "share of itself": (SHARED, '"wood": {"shared": "wood"}', ["shared.wood", "contains itself"], False),
    "share of nothing": (SHARED, '"wood": 0.5', ["shared.wood", "must be an object, got 0.5"], True),
    "newer version": (
        '"version": 1',
        '"version": 2',
        ["version: 2 is newer than 1", "update transport"],
        True,
    ),
    "no version": ('"version": 1, ', "", ["version", "got None"], True),
    "other format": ("transport scene", "transport", ["format", '"transport scene"', "'transport'"], True),
    "field of the head": (
        '"version": 1',
        '"version": 1, "sceen": 1',
        ["sceen", "did you mean 'scene'"],
        True,
    ),
    "no scene": (
        '"scene": {"type": "Scene"',
        '"scene": {"type": "Disk"',
        ["scene.type", '"Scene"', "'Disk'"],
        True,
    ),
    "number of a word": ('"radius": 0.1', '"radius": NaN', ["NaN is not JSON", '{"float": "nan"}'], None),
    "said twice": (
        '"radius": 0.1',
        '"radius": 0.1, "radius": 0.2',
        ["scene.json: detectors[0].shape.radius: is given twice"],
        None,
    ),
    "Python's own name": ('"radius": 0.1', '"radius": 0.1, "self": 1', ["detectors[0].shape.self"], True),
    "truth for a number": ("[0, 0, 2]", "[0, 0, true]", ["detectors[0].shape.center[2]", "True"], True),
    "array for a vector": (
        "[0, 0, 2]",
        '{"constant": 1, "shape": [3]}',
        ["detectors[0].shape.center: takes no array", "write numbers"],
        True,
    ),
    "half of a character": (
        '"name": "meter"',
        r'"name": "a\ud800"',
        ["scene.json: detectors[0].name", r"'a\ud800'"],
        None,
    ),
    "half of one in a name": ('"radius": 0.1', r'"\udc00": 0.1', [r"detectors[0].shape.'\udc00'"], None),
    "no JSON": ('"radius": 0.1', '"radius": 0.1,', ["line 6", "not JSON"], None),
    "wrong and unused": (
        SHARED,
        SHARED + ', "steel": {"type": "Mirror", "albedo": 1}',
        ["shared.steel.albedo"],
        True,
    ),
    "deep": ("[0, 0, 2]", "[" * 500 + "]" * 500, ["too deeply nested"], None),
    "too deep": ("[0, 0, 2]", "[" * 100_000 + "]" * 100_000, ["too deeply nested"], None),
    "too long": ('"radius": 0.1', f'"radius": {"1" * 5000}', ["unreadable JSON"], None),
}
ARRAYS = {
    "array of no shape": ({"constant": 1}, ["absorption: shape must be", "got None"]),
    "array too large": ({"constant": 1, "shape": [10**6, 10**6, 10**6]}, ["absorption: shape", "1e+18"]),
    "array of a number too large": (
        {"constant": 10**400, "shape": [1, 1, 1]},
        ["absorption", "finite, got inf"],
    ),
    "array of a text": ({"constant": "a", "shape": [1]}, ["absorption: constant", "'a'"]),
    "array too short": (
        {"base64": "AAAA", "dtype": "float64", "shape": [1]},
        ["absorption: base64", "8 bytes", "got 3"],
    ),
    "no base64": ({"base64": "A A!", "dtype": "float64", "shape": [1]}, ["absorption: base64 must be"]),
    "unknown dtype": (
        {"base64": "", "dtype": "object", "shape": [1]},
        ["absorption: dtype", "float64", "'object'"],
    ),
    "unknown number": ({"float": "Infinity"}, ["absorption: float", '"inf"', "'Infinity'"]),
}


@pytest.mark.parametrize(("old", "new", "words", "is_seen"), WRONG.values(), ids=WRONG)
def test_what_is_wrong_is_told_with_its_place(old, new, words, is_seen, tmp_path):
    assert TEXT.count(old) == 1
    path = tmp_path / "scene.json"
    path.write_text(TEXT.replace(old, new), encoding="utf-8")
    assert_refused(lambda: tp.Scene.from_json(path), [*words, "scene.json: "])
    if is_seen is not None:
        assert bool(faults_of(json.loads(TEXT.replace(old, new)))) == is_seen


@pytest.mark.parametrize(("array", "words"), ARRAYS.values(), ids=ARRAYS)
def test_a_wrong_array_is_told_with_its_place(array, words):
    grid = {"type": "Grid", "box": {"type": "Box", "size": 1}, "absorption": array}
    data = json.loads(TEXT)
    data["scene"]["surfaces"][0]["inside"] = grid
    assert_refused(lambda: tp.Scene.from_json(json.dumps(data)), ["surfaces[0].inside.absorption", *words])


def test_an_array_that_does_not_fit_into_memory_is_refused_before_it_is_made(monkeypatch):
    monkeypatch.setattr(codec, "available_memory", lambda: 1_000_000_000)
    with pytest.raises(
        ValueError, match=r"requests 8e\+09 numbers, 128 GB .* but 1 GB of memory are left; take fewer"
    ):
        array_from_json({"constant": 1, "shape": [2000, 2000, 2000]})
    assert array_from_json({"constant": 1, "shape": [100, 100, 100]}).shape == (100, 100, 100)


def test_what_is_long_is_cut_in_a_refusal():
    data = json.loads(TEXT)
    data["scene"]["detectors"][0]["type"] = [[data["scene"]["surfaces"]] * 9] * 9
    with pytest.raises(tp.SceneError) as refusal:
        tp.Scene.from_json(json.dumps(data))
    assert "detectors[0].type: unknown type" in str(refusal.value) and len(str(refusal.value)) < 1200


def test_of_many_names_the_one_that_is_said_twice_is_found_at_once():
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
    for parts in ("sources", "surfaces", "detectors"):
        data["scene"][parts] = data["scene"][parts][0]
    assert tp.Scene.from_json(json.dumps(data)) == tp.Scene.from_json(TEXT) and faults_of(data) == []


def test_the_text_without_a_fault_is_a_scene():
    scene = tp.Scene.from_json(TEXT)
    assert scene.surface("floor").material == tp.Diffuse(0.5)
    assert faults_of(json.loads(TEXT)) == []


@pytest.mark.parametrize("source", ["no_such.json", "/", 3, b"{}", "{", "[]", ""])
def test_what_is_no_file_and_no_text_is_refused(source, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert_refused(lambda: tp.Scene.from_json(source), [])


def test_a_function_is_refused_with_its_place_and_the_cure():
    gas = tp.Source(tp.Box(size=1), tp.Gas(1.0, tp.InverseCDF(lambda u: 1 + u)))
    scene = tp.Scene([gas], duration=1.0)
    assert_refused(scene.to_json, ["sources[0].emission.speed", "InverseCDF", "SpeedTable"])


def test_an_object_of_a_class_of_the_user_is_refused():
    class Velvet(tp.Diffuse):
        pass

    wall = tp.Surface(tp.Sphere(radius=1), Velvet(0.5))
    scene = tp.Scene([tp.Source(tp.Point(), tp.Isotropic(power=1))], [wall])
    assert_refused(scene.to_json, ["surfaces[0].material", "Velvet"])


def test_whatever_is_wrong_is_refused_in_words():
    """Files with a random fault give a SceneError or a scene, and no other error."""
    chance = random.Random(1)
    files = [json.loads(scene.to_json()) for _, scene in scenes_of_tests()]
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
    """What `scene_object` makes can be written, or is told why not."""
    found = set()
    for path in sorted((ROOT / "transport").rglob("*.py")):
        found |= set(re.findall(r"^@scene_object.*\nclass (\w+)", path.read_text(encoding="utf-8"), re.M))
    assert (
        found - {"SceneParts"} == SCENE_TYPES.keys() | UNSUPPORTED.keys()
    )  # a Scene is the parts that passed
