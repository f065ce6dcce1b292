"""The command line: menu, list, verify, bench, interruption, and what it does not import."""

import json
import os
import subprocess
import sys
from types import SimpleNamespace

import pytest

from tests.own_experiments import ROOT
from transport import __version__
from transport.cli import commands


def test_version(call):
    assert call("--version").output.split() == ["transport", __version__]


def test_interruption_prints_the_batches_done_as_incomplete_with_status_130(call, press_ctrl_c):
    call("run", "disk.py", "--no-picture")  # so that nothing is left to compile
    press_ctrl_c(after=1.0)
    answer = call("run", "endless.py", "--seconds", "60", "--estimator", "analog")
    assert answer.exit_code == 130
    assert "verdict     incomplete: interrupted" in answer.output
    assert "irradiance" in answer.output


def test_interruption_before_the_first_batch_has_status_130(call, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("transport.verification.experiment.simulate_all_quantities", interrupted)
    answer = call("run", "disk.py")
    assert answer.exit_code == 130
    assert len(answer.output.splitlines()) == 1


@pytest.mark.parametrize("options", [(), ("--quick", "--json"), ("--effects",)])
def test_bench_prints_where_the_benchmarks_are(call, options):
    answer = call("bench", *options)
    assert answer.exit_code == 0 and "python -m tests.bench" in answer.output


def test_bare_command_is_a_menu_of_experiments_grouped_by_question(call, monkeypatch):
    asked = {"a": ("Why?", "A = 1"), "b": ("How?", "B = 2"), "c": ("Why?", "C = 3")}
    modules = {name: SimpleNamespace(question=question, law=law) for name, (question, law) in asked.items()}
    monkeypatch.setattr(commands, "experiment_names", lambda: list(modules))
    monkeypatch.setattr(commands, "experiment", modules.__getitem__)
    assert "..." not in call("--help").output.partition("Commands:")[2]  # each command in a line of 80
    lines = [line.split() for line in call().output.splitlines()]
    order = [lines.index(words.split()) for words in ("Why?", "a A = 1", "c C = 3", "How?", "b B = 2")]
    assert order == sorted(order)
    assert json.loads(call("list", "--json").output)[1] == {"sim": "b", "question": "How?"}


def test_list_loads_no_compiler_and_no_plotting(call):
    code = (
        "import sys\nfrom transport.cli.commands import app\napp(['list'], standalone_mode=False)\n"
        "heavy = {'numba', 'scipy', 'matplotlib', 'pyvista', 'xarray'} & set(sys.modules)\nassert not heavy, heavy"
    )
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, "-c", code], check=True, env=environment, stdout=subprocess.DEVNULL)


def test_verify_has_one_row_a_law_with_formula_source_and_smallest_bias(call):
    answer = call("verify", "disks.py")
    assert answer.exit_code == 0, answer.output
    assert "E = π L sin²θ on the axis of a diffuse disk (Foote 1915)" in answer.output
    assert sum(line.rstrip().endswith("holds") for line in answer.output.splitlines()) == 2
    rows = json.loads(call("verify", "disks.py", "--json").output)
    assert [row["quantity"] for row in rows] == ["distance=2: irradiance", "distance=4: irradiance"]
    keys = [
        "law",
        "source",
        "sim",
        "quantity",
        "value",
        "error",
        "unit",
        "exact",
        "z",
        "smallest_bias",
        "holds",
    ]
    assert all(list(row) == keys for row in rows)
    assert all(0 < row["smallest_bias"] < 0.01 for row in rows)


def test_verify_fails_where_pi_is_forgotten(call):
    answer = call("verify", "wrong.py")
    assert answer.exit_code == 1
    assert "FAILS" in answer.output
    assert "0 of 1 rows hold" in answer.output
