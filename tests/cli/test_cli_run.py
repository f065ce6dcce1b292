"""`transport run`: what it prints and draws, its JSON, its cases, where it stops, and the input that is refused."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.own_experiments import CASES, EXPERIMENT
from tests.processes import ROOT, python
from transport.verification.experiment import parameter_unit
from transport.viz import curves


def record_of(call, *arguments):
    """The JSON of `transport run` with these arguments."""
    return json.loads(call("run", *arguments, "--json").stdout)


def test_run_prints_law_table_verdict_ledger_cost_next_digit_and_picture(call):
    answer = call("run", "disk.py", "--out", "figures")
    assert answer.exit_code == 0, answer.output
    lines, words = (
        answer.output.splitlines(),
        ["disk", "law", "question", "quantity", "irradiance", "ledger", "verdict", "cost"],
    )
    begins = [words[0], *(f"{word} " for word in (*words[1:], "next digit", "picture"))]
    places = [next(i for i, line in enumerate(lines) if line.startswith(start)) for start in begins]
    assert places == sorted(places)
    assert "Foote 1915" in answer.output
    assert "W m^-2" in lines[places[4]] and "18.4799" in lines[places[4]]  # the exact value
    assert "escaped" in lines[places[5]] and "lost" not in lines[places[5]]  # zero and exact
    assert Path("figures/disk.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_output_in_a_pipe_is_plain_and_whole_whatever_the_width(call):
    command = "-m", "transport", "run", "disks.py", "--no-picture"
    done = python(*command, folder=Path.cwd(), COLUMNS="30")
    assert "\x1b" not in done.stdout
    assert "…" not in done.stdout
    assert done.stderr == ""
    assert sum(" irradiance " in line and " W m^-2 " in line for line in done.stdout.splitlines()) == 2


def test_run_json_has_the_settled_keys(call):
    record = record_of(call, "disk.py", "--set", "distance=3", "--particles", "1e4", "--seed", "5")
    assert list(record) == [
        "sim",
        "parameters",
        "quantities",
        "ledger",
        "cost",
        "verdict",
        "warnings",
        "notes",
        "method",
    ]
    assert record["sim"] == "disk" and record["parameters"] == {"distance": 3}
    (quantity,) = record["quantities"]
    assert list(quantity) == ["name", "value", "error", "unit", "verdict", "findings", "exact", "z"]
    assert quantity["verdict"] == "sound" and quantity["findings"] == [] and quantity["unit"] == "W m^-2"
    assert abs(quantity["z"]) < 5 and math.isclose(quantity["exact"], math.pi * 100 / 37)
    assert record["cost"]["particles"] == 10_000
    ledger = {name: entry["value"] for name, entry in record["ledger"].items()}
    assert math.isclose(ledger.pop("emitted"), sum(ledger.values()), rel_tol=1e-12)
    assert not Path("out").exists()


def test_run_json_of_several_cases_lists_them_in_order_unless_a_setting_leaves_one(call):
    record = record_of(call, "disks.py")
    assert record["parameters"] == {"distance": [2.0, 4.0]}
    names = ["distance=2: irradiance", "distance=4: irradiance"]
    assert [quantity["name"] for quantity in record["quantities"]] == names
    assert record["ledger"]["lost"] == {"value": [0.0, 0.0], "error": [0.0, 0.0], "unit": "W"}
    assert record["cost"]["particles"] == 40_000
    assert record_of(call, "disks.py", "--set", "distance=8.0")["parameters"] == {"distance": 8.0}


def test_same_seed_and_any_threads_print_the_same_digits(call):
    runs = ((3, 1), (3, 2), (4, 1))
    values = [record_of(call, "disk.py", "--seed", s, "--threads", n)["quantities"] for s, n in runs]
    assert values[0] == values[1] != values[2]


@pytest.mark.slow
@pytest.mark.parametrize("limit", [("--error", "meter.irradiance=1e-3"), ("--seconds", "0.1")])
def test_run_for_an_error_or_a_time_reports_the_estimator_that_pilots_chose(call, limit):
    def method(*options):
        found = record_of(call, "disk.py", *options)["method"]
        return found["estimator"], found["sampling"]

    plain = "analog", "random"
    assert method(*limit) != plain  # which is a thousand times as dear here
    assert method(*limit, "--sampling", "random")[1] == "random"
    assert method(*limit, "--estimator", "analog") == method("--particles", "1e4") == plain


@pytest.mark.slow
def test_a_guide_is_typed_and_recorded(call):
    """The record's settings, typed again, give the same number."""

    def value(*options):
        record = record_of(call, "cost_mirror", "--set", "by=ball", "--particles", "2e4", *options)
        return record["quantities"][0]["value"], record["method"]["guide"]

    plain, led = value("--guide", "0"), value()
    assert (plain[1], led[1]) == (0, 1 << 18) and plain[0] != led[0]
    assert value("--guide", str(led[1])) == led


@pytest.mark.slow
def test_run_stops_at_the_requested_error(call):
    (quantity,) = record_of(call, "disk.py", "--error", "meter.irradiance=1e-4")["quantities"]
    assert 0 < quantity["error"] / quantity["value"] <= 1e-4


def test_an_experiment_needs_no_more_than_scene_and_measure(call):
    lines = EXPERIMENT.split("\ndef exact")[0].splitlines()
    text = "\n".join(line for line in lines if not line.startswith(("law", "question", "particles")))
    Path("least.py").write_text(text, encoding="utf-8")
    answer = call("run", "least.py", "--particles", "1e4")
    assert answer.exit_code == 0, answer.output
    assert not any(word in answer.output for word in ("law", "question", "verdict"))
    judged = call("verify", "least.py")
    assert judged.exit_code == 2
    assert "nothing to judge" in judged.output


def test_a_quantity_without_an_exact_value_is_shown_and_not_judged(call):
    more = "\ndef measure(result):\n    return {n: getattr(result['meter'], n) for n in ('irradiance', 'flux_in')}\n"
    Path("more.py").write_text(EXPERIMENT + more, encoding="utf-8")
    (line,) = (line for line in call("run", "more.py").output.splitlines() if line.startswith("flux_in "))
    assert line.split()[-2:] == ["–", "unknown"]
    known, unknown = record_of(call, "more.py")["quantities"]
    assert known["exact"] > 0
    assert unknown["exact"] is unknown["z"] is None
    assert [row["quantity"] for row in json.loads(call("verify", "more.py", "--json").stdout)] == [
        "irradiance"
    ]


@pytest.mark.slow
def test_a_warning_names_its_case(call):
    named = "\ndef scene(distance=2, radius=0.5):\n    meter = tp.Disk(center=(0, 0, distance), radius=0.1)\n"
    named += "    source = tp.Source(tp.Disk(radius=radius), tp.Lambertian(radiance=100.0))\n"
    named += "    name = 'meter' if distance < 3 else 'far'\n"
    named += "    return tp.Scene([source], detectors=[tp.Detector(meter, name=name, side='back')])\n"
    named += "\ndef measure(result):\n    return {'flux': result[next(iter(result))].flux_in}\n"
    Path("named.py").write_text(EXPERIMENT + CASES + named, encoding="utf-8")
    answer = call("run", "named.py", "--error", "meter.flux_in=0.1")
    assert answer.exit_code == 0, answer.output
    assert "warning     distance=4: run without the requested error: " in answer.output
    never = call("run", "named.py", "--error", "meter.flux_in=1e-9", "--particles", "1e4")
    assert "warning     distance=2: meter.flux_in: " in never.output
    nowhere = call("run", "named.py", "--error", "near.flux_in=0.1")
    assert nowhere.exit_code == 2


def test_long_texts_fold_and_rows_do_not(call):
    Path("long.py").write_text(EXPERIMENT + f"\nquestion = '{'why ' * 60}?'\n", encoding="utf-8")
    lines = call("run", "long.py").output.splitlines()
    assert max(map(len, lines)) <= 110
    assert sum("why" in line for line in lines) == 3


@pytest.mark.slow
def test_of_several_cases_those_of_each_chosen_estimator_are_counted(call):
    Path("cases.py").write_text(EXPERIMENT + CASES, encoding="utf-8")
    answer = call("run", "cases.py", "--seconds", "0.05", "--no-picture")
    (line,) = (line for line in answer.output.splitlines() if line.startswith("estimator "))
    assert "chosen by pilots: " in line and " of 2 cases" in line and "repeat" not in answer.output


# Refused input: one line with what is wrong, where, and status 2


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


@pytest.mark.slow
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


@pytest.mark.slow
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


def test_without_matplotlib_one_line_names_the_extra(call, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    answer = call("run", "disk.py")
    assert answer.exit_code == 0
    assert "pip install '.[plot]'" in answer.output
    assert "Traceback" not in answer.output
    assert "verdict" in answer.output


def test_a_sweep_is_one_table_and_a_picture(call):
    answer = call("run", "disk.py", "--sweep", "distance=[1,2,4]", "--particles", "2e4", "--out", "swept")
    assert answer.exit_code == 0, answer.output
    lines = answer.output.splitlines()
    (head,) = [line for line in lines if line.startswith("case ")]
    assert [sum(f"distance={value}" in line for line in lines) for value in (1, 2, 4)] == [1, 1, 1]
    assert "ledger" not in answer.output and head.split()[:2] == ["case", "quantity"]
    assert Path("swept/disk_sweep.png").stat().st_size > 10_000 and "disk_sweep.png" in answer.output
    assert "ledger" in call("run", "disk.py", "--verbose", "--no-picture", "--particles", "2e4").output


DOCUMENTED = EXPERIMENT.replace(
    "radius=0.5):\n    meter =",
    'radius=0.5):\n    """A disk.  radius [m];  distance: to it, on its axis [m]."""\n    meter =',
)
NAMED_BY_VALUE = """
def measure(result):
    found = {"irradiance": result["meter"].irradiance}
    return found | {f"E at {result.scene.detectors[0].shape.center[2]:g} m": result["meter"].irradiance}
"""
NONE_IN_COMMON = NAMED_BY_VALUE.replace('"irradiance": result["meter"].irradiance}', "}")


@pytest.fixture
def sweep_of(call, monkeypatch):
    """What a sweep over distances of an experiment prints, and its figures."""
    drawn = []

    def sweep(text, *words):
        Path("own.py").write_text(text, encoding="utf-8")
        monkeypatch.setattr(curves, "plot_sweep", lambda *given: drawn.append(plot_sweep(*given)))
        return call("run", "own.py", "--sweep", "distance=[1,2]", "--particles", "1e3", *words), drawn

    plot_sweep = curves.plot_sweep
    return sweep


@pytest.mark.parametrize(
    ("text", "label"), [(EXPERIMENT, "distance"), (DOCUMENTED, r"distance  [$\mathrm{m}$]")]
)
def test_a_sweep_is_drawn_with_the_unit_that_the_experiment_gives(sweep_of, text, label):
    answer, (figure,) = sweep_of(text)
    assert answer.exit_code == 0, answer.output
    assert [axes.get_xlabel() for axes in figure.axes] == [label]
    assert "leaves out" not in answer.output and not figure.get_supxlabel()


@pytest.mark.parametrize("words", [(), ("--json", "--out", "swept")], ids=["text", "json"])
def test_a_sweep_names_the_quantities_that_it_leaves_out(sweep_of, words):
    answer, (figure,) = sweep_of(EXPERIMENT + NAMED_BY_VALUE, *words)
    said = "Only some values of distance have 'E at 1 m' and 'E at 2 m', which the picture leaves out."
    assert answer.exit_code == 0 and said in " ".join(answer.stderr.split())
    assert [axes.get_title() for axes in figure.axes] == ["irradiance"]
    assert " ".join(figure.get_supxlabel().split()) == said
    assert max(map(len, figure.get_supxlabel().splitlines())) < 60


def test_a_sweep_whose_quantities_have_no_name_in_common_has_no_picture(sweep_of):
    answer, drawn = sweep_of(EXPERIMENT + NONE_IN_COMMON)
    assert answer.exit_code == 0 and not drawn
    assert "no picture: no quantity has the same name at all values of distance" in " ".join(
        answer.stderr.split()
    )


@pytest.mark.parametrize(
    ("doc", "unit"),
    [
        ("radius [m];  power [W]", "m"),
        ("power [W];  radius: of the ball, a\n    round one [m];", "m"),
        ("length: over the radius [m]", "1"),
        ("radius: over the length;  length [m]", "1"),
        ("radius: of it. Lengths are in [m]", "1"),
        ("inner_radius [m]", "1"),
        ("distance: in units of `radius` [m]", "1"),
        ("", "1"),
    ],
)
def test_the_unit_of_a_parameter_is_that_behind_its_name_or_none(doc, unit):
    def scene(radius):
        pass

    scene.__doc__ = doc
    assert parameter_unit(SimpleNamespace(scene=scene), "radius") == unit


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--sweep", "distance=2"], "--sweep takes several values, such as --sweep distance=[1,2,4]"),
        (["--sweep", "distnace=[1,2]"], "did you mean 'distance'?"),
        (["--sweep", "distance=[1,2]", "--save", "run.nc"], "--sweep saves no runs"),
        (
            ["--sweep", "distance=[1,2]", "--sweep", "radius=[1,2]"],
            "takes one parameter, got distance=[1,2] and radius=[1,2]",
        ),
        (["--sweep", "distance=[1,2]", "--set", "distance=3"], "leave out --set distance=3"),
    ],
)
def test_a_sweep_that_means_nothing_or_two_things_is_refused(call, words, said):
    answer = call("run", "disk.py", *words)
    assert answer.exit_code == 2 and said in answer.output
