"""Random scenes: every ledger closes, nothing is nan, units and threads do not matter, furnaces are uniform, ways agree.

`python -m tests.fuzz` does the same for a thousand scenes.  What is checked fails right code in less than one of 10^6 scenes.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings

import transport as tp
from tests.fuzz import agreements, gases, lefts, properties, rooms
from tests.fuzz.numbered import world_of
from tests.fuzz.snippets import written
from tests.fuzz.views import seen_worlds
from tests.fuzz.worlds import bright_worlds, clocked_worlds, worlds

few = settings(
    derandomize=True,
    deadline=None,
    database=None,
    phases=[Phase.generate],  # a scene that fails is printed as it is: to shrink it would compile many others
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)


@pytest.mark.timeout(
    1200
)  # to catch what hangs; most of the time is compilation, on a busy machine several minutes
@settings(few, max_examples=24)
@given(worlds())
def test_any_world_keeps_its_promises_or_says_why_not(world):
    properties.check_or_refused(world)


@pytest.mark.timeout(
    1200
)  # to catch what hangs; most of the time is compilation, on a busy machine several minutes
@settings(few, max_examples=8)
@given(rooms.furnaces())
def test_any_furnace_is_uniform(world):
    properties.check_or_refused(world, agreements.check_furnace)


@pytest.mark.timeout(
    1200
)  # to catch what hangs; most of the time is compilation, on a busy machine several minutes
@settings(few, max_examples=6)
@given(seen_worlds())
def test_any_world_that_is_seen_by_cameras_keeps_its_promises(world):
    properties.check_or_refused(world)


@pytest.mark.timeout(
    1200
)  # to catch what hangs; most of the time is compilation, on a busy machine several minutes
@settings(few, max_examples=3)
@given(gases.gases())
def test_a_gas_that_nothing_changes_stays_uniform(world):
    properties.check_or_refused(world, gases.check_gas)


@pytest.mark.timeout(
    1200
)  # to catch what hangs; most of the time is compilation, on a busy machine several minutes
@settings(few, max_examples=3)
@given(clocked_worlds())
def test_what_is_alive_is_what_was_emitted_and_has_not_gone(world):
    properties.check_or_refused(world, lefts.check_left)


@pytest.mark.timeout(
    1200
)  # to catch what hangs; most of the time is compilation, on a busy machine several minutes
@settings(few, max_examples=6)
@given(bright_worlds())
def test_all_ways_agree(world):
    properties.check_or_refused(world, agreements.check_ways)


@settings(few, max_examples=30)
@given(worlds())
def test_a_world_is_written_as_the_python_that_makes_it(world):
    try:
        scene = world.scene()
    except tp.SceneError:
        return
    assert eval(written(scene), {"tp": tp, "np": np, "math": math}) == scene


def test_few_scenes_are_refused():
    """Else hardly anything would be tested: at most a fifth, and each refusal helps."""
    refusals = [refusal for refusal in map(refusal_of, range(40)) if refusal]
    for refusal in refusals:
        properties.refusal_helps(refusal)
    assert len(refusals) <= 8


def refusal_of(number: int) -> str:
    """Why the scene of that number is refused, if it is."""
    try:
        world_of(number, 1, "worlds").scene()
    except tp.SceneError as refusal:
        return str(refusal)
    return ""
