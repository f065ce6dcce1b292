"""Files of an earlier version load, with the same bits: runs and a scene that commit e50b82d wrote."""

import json
from pathlib import Path

import numpy as np
import pytest

import transport as tp
from transport.run import schedules
from transport.run.state import FORMER_KINDS, restore_schedule

FOLDER = Path(__file__).parent / "earlier"
NUMBERS = json.loads((FOLDER / "numbers.json").read_text())


@pytest.mark.parametrize("file", ["run.nc", "run.npz", "chosen.npz", "gas.npz"])
def test_a_run_of_an_earlier_version_has_the_same_numbers(file):
    result, title = tp.load(FOLDER / file), file.partition(".")[0]
    expected = {name.partition(".")[2]: number for name, number in NUMBERS.items() if name.startswith(title)}
    assert expected
    for name, (value, error) in expected.items():
        found = result.quantity(name)
        assert np.array_equal(np.ravel(found.value), value, equal_nan=True), name
        assert np.array_equal(np.ravel(found.error), error, equal_nan=True), name


def test_a_scene_of_an_earlier_version_is_the_scene_of_its_run():
    assert tp.Scene.from_json(FOLDER / "scene.json") == tp.load(FOLDER / "run.npz").scene


@pytest.mark.parametrize("file", ["run.npz", "chosen.npz", "gas.npz"])
def test_the_schedule_of_an_earlier_version_is_known_by_its_present_name(file):
    """Else a run would resume from its batches, not exactly where it stood."""
    saved = tp.load(FOLDER / file).state
    schedule = object.__new__(getattr(schedules, FORMER_KINDS.get(saved.kind, saved.kind)))
    schedule.limits = saved.limits
    assert restore_schedule(saved, schedule)
    assert {name: getattr(schedule, name) for name in schedule.remembered} == saved.remembered
