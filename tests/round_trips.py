"""Scenes written as text and read again: what must be the same of both, and the scenes that this is asked of."""

from __future__ import annotations

import inspect
import json
from collections.abc import Iterator
from functools import cache

import jsonschema

import transport as tp
from tests import backward_scenes, expected_scenes, media_scenes, plain_scenes
from tests.fuzz.properties import are_the_same
from tests.grid_scenes import forget_programs
from transport.compile.methods import ANALOG, Method
from transport.io.json.differences import differences
from transport.io.json.schema import schema
from transport.run.programs import program_for
from transport.verification.experiment import cases_of, experiment, experiment_names

MODULES = (plain_scenes, media_scenes, backward_scenes, expected_scenes)


def scenes_of_tests() -> Iterator[tuple[str, tp.Scene]]:
    """All scenes that functions without parameters make in the tests' files of scenes."""
    for module in MODULES:
        for name, make in vars(module).items():
            own = inspect.isfunction(make) and make.__module__ == module.__name__
            if own and not inspect.signature(make).parameters and isinstance(scene := make(), tp.Scene):
                yield f"{module.__name__}.{name}", scene


def scenes_of_sims() -> Iterator[tuple[str, tp.Scene]]:
    """The scenes of all cases of all experiments."""
    for name in experiment_names():
        for place, parameters in enumerate(cases_of(experiment(name), {})):
            yield f"{name}[{place}]", experiment(name).scene(**parameters)


def read_again(scene: tp.Scene) -> tp.Scene:
    """The scene after it was written and read; it is the same bit by bit, and so is its text, which the schema allows."""
    text = scene.to_json()
    assert faults_of(json.loads(text)) == []
    again = tp.Scene.from_json(text)
    assert differences(scene, again) == []
    assert again == scene and hash(again) == hash(scene), "not equal"
    assert again.to_json() == text, "another text"
    return again


def assert_compiled_alike(scene: tp.Scene, again: tp.Scene, method: Method = ANALOG) -> None:
    """Both call for the same passes with the same numbers in their tables."""
    one, other = (_compiled(each, method) for each in (scene, again))
    assert one[0] == other[0], "other passes"
    assert one[1] == other[1], "other numbers in the tables"


def assert_runs_alike(scene: tp.Scene, again: tp.Scene, **how: object) -> None:
    """Both give the same result bit by bit, each by a program of its own."""
    results = []
    for each in (scene, again):
        forget_programs()
        results.append(tp.simulate(each, seed=5, progress=False, **how))
    are_the_same(*results)


def faults_of(data: object) -> list[str]:
    """What the schema finds wrong with the data of a file."""
    return [f"{fault.json_path}: {fault.message}" for fault in _validator().iter_errors(data)]


@cache
def _validator() -> jsonschema.Draft202012Validator:
    return jsonschema.Draft202012Validator(schema())


def _compiled(scene: tp.Scene, method: Method) -> tuple[list[str], bytes]:
    """Names of the passes, and the bytes of all tables."""
    forget_programs()
    program = program_for(scene, None, method)
    return [each.name for each in program.passes], program.plan.arena.memory.tobytes()
