"""`transport verify --hard`: hard cases beside what the naive formula gives; status 1 if one fails."""

import json
import math
import signal
from contextlib import suppress

import pytest

from tests.ctrl_c import pressing_ctrl_c
from transport.statistics.estimates import Estimate
from transport.statistics.replicates import Batches
from transport.verification.hard import cases
from transport.verification.hard.cases import Case, CaseResult

NOISY = Estimate([1.0, 1.1, 0.9, 1.05, 0.95], Batches([10] * 5), "1")


def wrong(found, naive=0.0, exact=1.0):
    return Case(
        "spheres",
        "a sphere far away",
        "1 - cos θ",
        "It rounds to 0.",
        lambda: CaseResult(found, exact, naive),
    )


@pytest.fixture
def hard(call, monkeypatch):
    """Call `verify --hard` with these cases alone."""

    def verify(*made, more=()):
        monkeypatch.setattr("transport.cli.verify.cases_of", lambda families: iter(made))
        monkeypatch.setattr("transport.cli.verify.family_title", lambda name: f"All about {name}.")
        return call("verify", "--hard", *more)

    return verify


def test_cases_are_printed_with_what_the_naive_way_gives(hard):
    answer = hard(wrong(1.0, naive=math.nan), wrong(1.0, naive=None), wrong(NOISY))
    assert answer.exit_code == 0, answer.output
    assert "All about spheres." in answer.output and "3 of 3 hard cases hold" in answer.output
    assert "NaN" in answer.output and "–" in answer.output and "1.00 ± 0.04" in answer.output


@pytest.mark.parametrize("found", [1 + 1e-9, math.nan, NOISY * 2])
def test_a_case_that_fails_is_told(hard, found):
    answer = hard(wrong(found), wrong(1.0))
    assert answer.exit_code == 1
    assert "1 of 2 hard cases hold" in answer.output and "FAILS" in answer.output


def test_an_interruption_that_a_case_has_taken_ends_it_too(hard, press_ctrl_c):
    """A run within the case ends early for Ctrl-C, and what the case makes of that is not told."""

    def cut_short():
        with suppress(KeyboardInterrupt):
            press_ctrl_c()
        return CaseResult(2.0, 1.0, 0.0)

    answer = hard(wrong(1.0), Case("spheres", "cut short", "", "", cut_short), wrong(1.0))
    assert answer.exit_code == 130 and "the rows are incomplete" in answer.output
    assert "1 of 1 hard cases hold" in answer.output and "cut short" not in answer.output
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_cases_go_on_where_ctrl_c_is_ignored(hard):
    """As under nohup."""
    with pressing_ctrl_c(signal.SIG_IGN) as press:
        pressed = Case("spheres", "pressed", "", "", lambda: press() or CaseResult(1.0, 1.0, 0.0))
        answer = hard(pressed)
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    assert answer.exit_code == 0 and "1 of 1 hard cases hold" in answer.output


@pytest.mark.parametrize("option", [("--seed", "1"), ("--particles", "10"), ("--threads", "2")])
def test_what_it_would_not_heed_is_refused(hard, option):
    answer = hard(wrong(1.0), more=option)
    assert answer.exit_code == 2 and "leave out --particles, --seed, --threads" in " ".join(
        answer.output.split()
    )


def test_a_naive_number_is_told_to_the_digit_that_is_wrong(hard):
    assert "1.0001" in hard(wrong(1.0, naive=1.00010001)).output


def test_machines_are_told_the_reason(hard):
    (record,) = json.loads(hard(wrong(1.0), more=["--json"]).output)
    assert record["reason"] == "It rounds to 0." and record["naive_value"] == 0 and record["holds"] is True


def test_unknown_families_are_refused(call):
    answer = call("verify", "--hard", "direction")
    assert answer.exit_code == 2 and "did you mean 'directions'?" in answer.output
    assert "directions" in cases.families() and "cases" not in cases.families()
