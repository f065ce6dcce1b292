"""What the command line refuses: a line with what is wrong, where, and status 2."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.own_experiments import EXPERIMENT, ROOT


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "dsik"], "no experiment 'dsik'"),
        (["run", "nowhere.py"], "no file nowhere.py"),
        (["run", "disk.py", "--set", "distnace=3"], "did you mean 'distance'?"),
        (["run", "disk.py", "--set", "radius=-1"], "radius must be positive"),
        (["run", "disk.py", "--set", "radius=wide"], "radius must be a number"),
        (["run", "disk.py", "--set", "radius=nan"], "radius must be positive and finite, got nan"),
        (["run", "disk.py", "--set", "radius=-inf"], "radius must be positive and finite, got -inf"),
        (["run", "disk.py", "--set", "distance=(1, inf, 0)"], "got (0, 0, (1, inf, 0))"),
        (["run", "disk.py", "--set", "distance=(1, 2)"], "center must be three finite numbers"),
        (["run", "disk.py", "--set", "radius"], "--set must be name=value"),
        (["run", "disk.py", "--set", "radius=1", "--set", "radius=2"], "given twice"),
        (["run", "disk.py", "--particles", "1.5"], "--particles must be a whole number"),
        (["run", "disk.py", "--particles", "many"], "--particles must be a whole number such as 1e7"),
        (["run", "disk.py", "--error", "meter.fluxin=1e-3"], "did you mean 'flux_in'?"),
        (["run", "disk.py", "--error", "meter.flux_in=small"], "--error must be a finite number"),
        (["run", "disk.py", "--seconds", "0"], "seconds must be positive"),
        (["run", "disk.py", "--seed", "-1"], "seed"),
        (["run", "disk.py", "--threads", "0"], "threads"),
        (["run", "unlike.py"], "unlike units"),
        (["rnu", "disk.py"], "no command 'rnu'; did you mean 'run'?"),
        (["disk.py"], "did you mean 'transport run disk.py'?"),
        (
            ["run", "disk.py", "--set", "distance=-1", "--set", "radius=0"],
            "disk with distance=-1, radius=0: ",
        ),
        (["verify", "dsik"], "error: no experiment 'dsik'"),
        (["verify", "disk.py", "dsik"], "no experiment 'dsik'"),
        (
            ["verify", "geometry"],
            "a family of hard cases, not an experiment; write transport verify --hard geometry",
        ),
        (["cost", "disk.py", "--seconds", "-1"], "seconds must be positive"),
        (["effects", "disk.py", "--set", "distnace=3"], "did you mean 'distance'?"),
    ],
)
def test_refused_input_is_one_line_and_status_2(call, arguments, words):
    answer = call(*arguments)
    assert answer.exit_code == 2
    (line,) = answer.output.splitlines()
    assert line.startswith("error: ")
    assert words in line


def test_a_file_that_is_no_experiment_is_refused(call):
    Path("empty.py").write_text("question = 'What?'\n")
    answer = call("run", "empty.py")
    assert answer.exit_code == 2
    assert "no function scene and measure" in answer.output


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("def f(:\n", ", line {first}: SyntaxError: "),
        ("import no_such_module\n", ", line {first}: ModuleNotFoundError: No module named 'no_such_module'"),
        ("def scene(): return 1 / 0\n", ", line {first}: ZeroDivisionError: division by zero"),
        (
            "def measure(result):\n    return {'x': result['metre'].flux_in}\n",
            ", line {second}: result has no detector",
        ),
        ("def measure(result): return 1\n", "measure must return {{name: Estimate}}, got 1"),
        ("def measure(result): return {'x': 1.0}\n", "measure must return an Estimate for 'x', got 1.0"),
        ("def exact(): return {}['y']\n", ", line {first}: KeyError: 'y'"),
        ("def cases(): return []\n", "cases() returns no case"),
        ("def verdict(outcomes): return outcomes[7]\n", ", line {first}: IndexError"),
        ("def draw(outcomes, path): raise RuntimeError('no ink')\n", ", line {first}: RuntimeError: no ink"),
    ],
)
def test_a_mistake_in_ones_own_experiment_is_one_line_with_its_place(call, more, words):
    Path("mine.py").write_text(EXPERIMENT + more, encoding="utf-8")
    answer = call("run", "mine.py", "--particles", "1000")
    assert answer.exit_code == 2
    (line,) = (line for line in answer.output.splitlines() if line.startswith("error: mine"))
    first = EXPERIMENT.count("\n") + 1
    assert words.format(first=first, second=first + 1) in line
    assert "Traceback" not in answer.output
    assert call("--debug", "run", "mine.py", "--particles", "1000").exception.__traceback__ is not None


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals")
def test_refusal_is_red_on_a_terminal(call):
    import pty

    own, its = pty.openpty()
    environment = {name: value for name, value in os.environ.items() if name not in ("NO_COLOR", "TERM")}
    environment |= {"TERM": "xterm", "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "transport", "run", "nowhere.py"]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=its, env=environment, check=False)
    os.close(its)
    assert done.returncode == 2
    assert b"\x1b[1;31merror: no file nowhere.py" in os.read(own, 4096)
    os.close(own)


def test_without_matplotlib_one_line_says_what_to_install(call, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    answer = call("run", "disk.py")
    assert answer.exit_code == 0
    assert "pip install '.[plot]'" in answer.output
    assert "Traceback" not in answer.output
    assert "verdict" in answer.output
