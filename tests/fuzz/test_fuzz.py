"""Random scenes: every energy balance closes, nothing is nan, units and threads do not matter, furnaces are uniform, ways agree.

`python -m tests.fuzz` does the same for a thousand scenes.  What is checked fails right code in less than one of 10^6 scenes.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings

import transport as tp
from tests.fuzz import properties
from tests.fuzz.numbered import FAMILIES, world_of
from tests.fuzz.worlds import written

few = settings(
    derandomize=True,
    deadline=None,
    database=None,
    phases=[Phase.generate],  # a scene that fails is printed as it is: to shrink it would compile many others
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
EXAMPLES = [("worlds", 7), ("furnaces", 2), ("views", 2), ("gases", 2), ("clocks", 2), ("ways", 2)]
LONG = 1200  # s, to catch what hangs; most of the time is compilation, on a busy machine several minutes


@pytest.mark.slow
@pytest.mark.timeout(LONG)
@pytest.mark.parametrize("case", EXAMPLES)
def test_any_world_has_all_properties_or_is_refused_with_a_cure(case):
    """Each family of scenes with its own check (tests/fuzz/numbered.py)."""
    family, examples = case
    made, look = FAMILIES[family]

    @settings(few, max_examples=examples)
    @given(made)
    def holds(world):
        properties.check_or_refused(world, look)

    holds()


@pytest.mark.slow
def test_few_worlds_are_refused_and_each_is_written_as_the_python_that_makes_it():
    """At most a fifth, since hardly anything would be tested otherwise; each refusal names its cure."""
    refusals = []
    for number in range(25):
        try:
            scene = world_of(number, 1, "worlds").scene()
        except tp.SceneError as refusal:
            properties.refusal_helps(str(refusal))
            refusals.append(refusal)
        else:
            assert eval(written(scene), {"tp": tp, "np": np, "math": math}) == scene
    assert len(refusals) <= 5
