"""Bodies of passes: wrong ones are refused by errors that name the cure; fields are found wherever a lane is given."""

from __future__ import annotations

import re

import pytest
from numba import config
from numba.core.errors import TypingError

from tests.driven import Lanes
from transport.compile import layout
from transport.engine.bodies import Pass, lane_pass
from transport.engine.registry import PASSES
from transport.engine.stages.quasi_random import quasi_random_twin
from transport.engine.tally import to_ledger
from transport.engine.words import birth_block
from transport.physics.device import device
from transport.physics.streams import POSITION

compiled_only = pytest.mark.skipif(config.DISABLE_JIT, reason="needs machine code")


def nothing_to_do(lane, table):
    pass


@device
def is_light(lane, table):
    return lane.weight < 0.5


def undecorated(lane, table):
    return lane.weight < 0.5


# ---- wrong passes ----


@pytest.mark.parametrize(
    "options",
    [
        {"before": is_light, "when": is_light},
        {"before": is_light, "is_loop": True},
        {"unless": (is_light, PASSES["move"]), "sums": is_light},
        {"unless": (is_light, PASSES["move"]), "when": is_light},
        {"unless": (is_light, PASSES["play_roulette"])},
        {"unless": (is_light, PASSES["draw_uniforms"])},
        {"unless": (is_light, is_light)},
    ],
    ids=[
        "before and when",
        "before of a loop",
        "sums",
        "when",
        "sums of the other",
        "before of the other",
        "a function",
    ],
)
def test_options_that_a_loop_would_pass_over_are_refused(options):
    with pytest.raises(TypeError, match=r"^pass nothing_to_do: .*(before|unless)"):
        Pass(nothing_to_do, layout.NO_TABLE, **options)
    Pass(nothing_to_do, layout.NO_TABLE, unless=(is_light, PASSES["move"]))  # nothing is passed over


@compiled_only
@pytest.mark.parametrize("option", ["sums", "before", "when", "unless"])
def test_a_function_that_numba_does_not_know_is_refused(option):
    given = (undecorated, PASSES["move"]) if option == "unless" else undecorated
    with pytest.raises(
        TypeError, match=f"pass nothing_to_do: decorate the function in `{option}` with @device"
    ):
        lane_pass(layout.NO_TABLE, **{option: given})(nothing_to_do)


def test_a_pass_without_a_table_is_refused():
    with pytest.raises(TypeError, match=r"write @lane_pass\(layout.NO_TABLE\)"):
        lane_pass(nothing_to_do)


def two_amounts(lane, table):
    return 1, 2


def real_amounts(lane, table):
    return 0.7 * lane.weight, 0


def sets_the_seed(lane, table):
    lane.seed_low = 1


WRONG = {  # pass, and what the error says
    "amounts without sums": (lane_pass(layout.NO_TABLE)(two_amounts), "returns 2 amounts, its sums take 0"),
    "real numbers": (
        lane_pass(layout.NO_TABLE, sums=to_ledger(layout.ROULETTE))(real_amounts),
        "`limbs` of a weight",
    ),
    "a constant": (lane_pass(layout.NO_TABLE)(sets_the_seed), "seed_low is constant in a batch"),
    "amounts of a pass with another": (
        lane_pass(layout.NO_TABLE, unless=(is_light, PASSES["move"]))(two_amounts),
        "returns 2 amounts, its sums take 0",
    ),
}


@compiled_only
@pytest.mark.parametrize(("wrong", "says"), WRONG.values(), ids=WRONG)
def test_a_wrong_body_is_refused_when_it_is_compiled(wrong, says):
    with pytest.raises(TypeError, match=says) as caught:
        _ = wrong.compiled
    assert f"the pass {wrong.name}" in caught.value.__notes__[0]


@pytest.mark.parametrize(("wrong", "says"), WRONG.values(), ids=WRONG)
def test_a_wrong_body_is_refused_in_plain_python(wrong, says):
    with pytest.raises(TypeError, match=says):
        Lanes().run_plainly(wrong)


@compiled_only
def test_a_wrong_field_is_shown_in_its_line_of_the_body():
    @lane_pass(layout.NO_TABLE)
    def misspelt(lane, table):
        double = 2.0 * lane.weight
        lane.wieght = double

    with pytest.raises(TypingError) as caught:
        _ = misspelt.compiled
    here = misspelt.function.__code__.co_firstlineno
    shown = {int(line) for line in re.findall(r'test_lane_bodies\.py", line (\d+):', str(caught.value))}
    assert {line for line in shown if line > here} == {here + 3}


# ---- fields ----


def halved(factor):
    @device
    def halve(lane):
        return lane.distance * factor

    return halve


half = halved(0.5)


def test_fields_are_found_in_what_a_function_closes_over():
    def closed(lane, table):
        return inner(lane)

    inner = half

    def by_a_global(lane, table):
        lane.x = half(lane)

    for function in (closed, by_a_global):
        assert lane_pass(layout.NO_TABLE)(function).reads == ("distance",)


def test_draws_in_a_closure_are_quasi_random_in_twins():
    begin = birth_block(POSITION)

    def draws(lane, table):
        begin(lane, table)

    drawing = lane_pass(layout.NO_TABLE)(draws)
    assert quasi_random_twin(drawing, "sobol") is not drawing
    assert quasi_random_twin(PASSES["move"], "sobol") is PASSES["move"]


def test_the_form_for_one_lane_is_a_twin_too():
    walk = PASSES["delta_track_in_grid"]
    assert quasi_random_twin(walk, "sobol").alone is not walk.alone
