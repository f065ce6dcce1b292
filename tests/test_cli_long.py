"""`transport verify --long`: the proof that is run once, in one table; how long it takes is told before."""

import json
from itertools import count
from pathlib import Path

import pytest

from tests.own_experiments import EXPERIMENT
from transport.cli import verify
from transport.verification.hard.cases import Case, CaseResult


def hard(found):
    return Case(
        "spheres", "a sphere far away", "1 - cos θ", "It rounds to 0.", lambda: CaseResult(found, 1.0, 0.0)
    )


@pytest.fixture
def proof(call, monkeypatch):
    """All experiments, which are the disks, and these hard cases."""
    monkeypatch.setattr(verify, "experiment_names", lambda: ["disks.py"])

    def prove(*made, more=()):
        monkeypatch.setattr(verify, "cases_of", lambda: list(made))
        return call("verify", "--long", "--particles", "20000", *more)

    return prove


def test_experiments_and_hard_cases_are_told_in_one_table_after_the_time_that_they_will_take(proof):
    answer = proof(hard(1.0), hard(1.0))
    assert answer.exit_code == 0, answer.output
    first = answer.stderr.splitlines()[1]
    assert first.startswith("experiments: 1, with 2e+04 particles per case; hard cases: 2; about ")
    lines = [line.split() for line in answer.stdout.splitlines()]
    assert ["disks", "2", "2", "2"] in [line[:4] for line in lines]
    assert ["hard:", "spheres", "2", "2", "2"] in lines
    assert "4 of 4 rows and hard cases hold" in answer.stdout and ", estimated " in answer.stdout


def test_what_fails_is_told_in_full(proof, call):
    answer = proof(hard(1.0), hard(1.1))
    assert answer.exit_code == 1
    assert "3 of 4 rows and hard cases hold" in answer.stdout and answer.stdout.count("FAILS") == 1
    answer = call("verify", "--long", "wrong.py", "--particles", "2000")
    assert answer.exit_code == 1
    assert (
        "irradiance" in answer.stdout and "0 of 1 rows" in answer.stdout and "hard cases: 0;" in answer.stderr
    )


def test_machines_are_told_every_row(proof):
    record = json.loads(proof(hard(1.0), more=["--json"]).stdout)
    assert record["particles"] == 20000 and record["foreseen_seconds"] > 0
    assert [row["holds"] for row in (*record["laws"], *record["hard"])] == [True] * 3


@pytest.mark.parametrize(("how", "first"), [(["--long"], 6), ([], 2)], ids=["long", "plain"])
def test_what_is_known_when_it_is_interrupted_is_told(call, monkeypatch, how, first):
    """Ctrl-C before the first batch of the second case; the long proof has had two pilots of both cases."""
    from transport.simulate import simulate_all_quantities as simulate

    calls = count(1)

    def interrupted(*arguments, **limits):
        if next(calls) == first:
            raise KeyboardInterrupt
        return simulate(*arguments, **limits)

    monkeypatch.setattr("transport.verification.experiment.simulate_all_quantities", interrupted)
    answer = call("verify", "disks.py", "--particles", "2000", *how)
    assert answer.exit_code == 130
    assert "1 of 1 rows" in answer.stdout and "the rows are incomplete" in answer.stderr


def test_what_it_cannot_run_is_refused_before_the_pilots(call, monkeypatch):
    monkeypatch.setattr(verify, "run_until_interrupt", None)
    Path("good.py").write_text(EXPERIMENT, encoding="utf-8")
    for arguments in (["--particles", "0"], ["good.py", "nowhere.py"], ["--hard"], ["geometry"]):
        answer = call("verify", "--long", *arguments)
        assert answer.exit_code == 2 and answer.output.count("error: ") == 1, answer.output
