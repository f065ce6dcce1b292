"""The command line: what it prints, its JSON, its refusals and exit statuses, and what it does not import."""

import json
import math
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

from transport import __version__
from transport.command import bench, cli, effects, printout

ROOT = Path(__file__).resolve().parents[1]

EXPERIMENT = '''
"""A diffuse disk and a small meter on its axis."""
import math
import transport as tp

law = "E = π L sin²θ on the axis of a diffuse disk (Foote 1915)"
question = "How much does a diffuse disk send to a meter on its axis?"
particles = 20_000

def scene(distance=2, radius=0.5):
    meter = tp.Disk(center=(0, 0, distance), normal=(0, 0, -1), radius=1e-4)
    source = tp.Source(tp.Disk(radius=radius), tp.Lambertian(radiance=100.0), aim=meter)
    return tp.Scene(sources=[source], detectors=[tp.Detector(meter, name="meter")])

def measure(result):
    return {"irradiance": result["meter"].irradiance}

def exact(distance=2, radius=0.5):
    return {"irradiance": PI * 100 * radius**2 / (radius**2 + distance**2)}

def verdict(outcomes):
    return "As much as its solid angle, projected, times its radiance."

PI = math.pi
'''
CASES = "\ndef cases():\n    return [{'distance': 2.0}, {'distance': 4.0}]\n"
PICTURE = """
def draw(outcomes, path):
    from matplotlib.figure import Figure
    Figure(figsize=(1, 1)).savefig(path)
"""
UNLIKE_UNITS = (
    "\ndef measure(result):\n    return {'x': result['meter'].irradiance + result['meter'].flux_in}\n"
)
PI_FORGOTTEN = "\nPI = 1.0\n"


@pytest.fixture
def call(tmp_path, monkeypatch):
    """Call the command line in a folder of its own, with experiment files written there: call("run", "disk.py")."""
    monkeypatch.chdir(tmp_path)
    for name, more in {
        "disk": PICTURE,
        "disks": CASES + PICTURE,
        "unlike": UNLIKE_UNITS,
        "wrong": PI_FORGOTTEN,
        "endless": "\nparticles = 10**11\n",
    }.items():
        Path(f"{name}.py").write_text(EXPERIMENT + more, encoding="utf-8")
    return lambda *arguments: CliRunner().invoke(cli.app, list(map(str, arguments)))


def test_run_prints_law_table_verdict_ledger_cost_next_digit_and_picture(call):
    answer = call("run", "disk.py", "--out", "figures")
    assert answer.exit_code == 0, answer.output
    lines = answer.output.splitlines()
    begins = [
        "disk",
        "law ",
        "question ",
        "quantity ",
        "irradiance ",
        "ledger ",
        "verdict ",
        "cost ",
        "next digit ",
        "picture ",
    ]
    places = [next(i for i, line in enumerate(lines) if line.startswith(start)) for start in begins]
    assert places == sorted(places)
    assert "Foote 1915" in answer.output
    assert "W m^-2" in lines[places[4]]
    assert "18.4799" in lines[places[4]]  # the exact value
    assert "escaped" in lines[places[5]]
    assert "lost" not in lines[places[5]]  # zero and exact
    assert Path("figures/disk.png").read_bytes().startswith(b"\x89PNG")


def test_output_in_a_pipe_is_plain_and_whole_whatever_the_width(call):
    environment = os.environ | {"COLUMNS": "30", "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "transport", "run", "disks.py", "--no-picture"]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", env=environment, check=True)
    assert "\x1b" not in done.stdout
    assert "…" not in done.stdout
    assert done.stderr == ""
    assert (
        sum(line.startswith("irradiance ") and " W m^-2 " in line for line in done.stdout.splitlines()) == 2
    )


def test_run_json_has_the_settled_keys(call):
    answer = call("run", "disk.py", "--json", "--set", "distance=3", "--particles", "1e4", "--seed", "5")
    record = json.loads(answer.output)
    assert list(record) == ["sim", "parameters", "quantities", "ledger", "cost", "verdict", "warnings"]
    assert record["sim"] == "disk"
    assert record["parameters"] == {"distance": 3}
    (quantity,) = record["quantities"]
    assert list(quantity) == ["name", "value", "error", "unit", "exact", "z"]
    assert quantity["unit"] == "W m^-2"
    assert abs(quantity["z"]) < 5
    assert math.isclose(quantity["exact"], math.pi * 100 / 37)
    assert record["cost"]["particles"] == 10_000
    ledger = {name: entry["value"] for name, entry in record["ledger"].items()}
    assert math.isclose(ledger.pop("emitted"), sum(ledger.values()), rel_tol=1e-12)
    assert not Path("out").exists()


def test_run_json_of_several_cases_lists_them_in_order(call):
    record = json.loads(call("run", "disks.py", "--json").output)
    assert record["parameters"] == {"distance": [2.0, 4.0]}
    assert [q["name"] for q in record["quantities"]] == [
        "distance=2: irradiance",
        "distance=4: irradiance",
    ]
    assert record["ledger"]["lost"] == {"value": [0.0, 0.0], "error": [0.0, 0.0], "unit": "W"}
    assert record["cost"]["particles"] == 40_000


def test_a_setting_given_for_all_cases_leaves_one(call):
    record = json.loads(call("run", "disks.py", "--json", "--set", "distance=8.0").output)
    assert record["parameters"] == {"distance": 8.0}


def test_same_seed_and_any_threads_print_the_same_digits(call):
    values = [
        json.loads(call("run", "disk.py", "--json", "--seed", seed, "--threads", threads).output)[
            "quantities"
        ]
        for seed, threads in ((3, 1), (3, 2), (4, 1))
    ]
    assert values[0] == values[1]
    assert values[0] != values[2]


def test_run_stops_at_the_error_asked_for(call):
    record = json.loads(call("run", "disk.py", "--json", "--error", "meter.irradiance=1e-4").output)
    (quantity,) = record["quantities"]
    assert 0 < quantity["error"] / quantity["value"] <= 1e-4


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
        (["run", "disk.py", "--particles", "many"], "--particles must be a finite number"),
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
        (["verify", "dsik"], "no experiment 'dsik'"),
        (["effects", "disk.py", "--set", "distnace=3"], "did you mean 'distance'?"),
        (["bench", "--repeats", "2"], "repeats must be at least 5"),
    ],
)
def test_refused_input_is_one_line_and_status_2(call, arguments, words):
    answer = call(*arguments)
    assert answer.exit_code == 2
    (line,) = answer.output.splitlines()
    assert line.startswith("refused: ")
    assert words in line


def test_a_file_that_is_no_experiment_is_refused(call):
    Path("empty.py").write_text("question = 'What?'\n")
    answer = call("run", "empty.py")
    assert answer.exit_code == 2
    assert "no function scene and measure" in answer.output


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
    known, unknown = json.loads(call("run", "more.py", "--json").output)["quantities"]
    assert known["exact"] > 0
    assert unknown["exact"] is unknown["z"] is None
    assert [row["quantity"] for row in json.loads(call("verify", "more.py", "--json").output)] == [
        "irradiance"
    ]


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
        ("def measure(result): return {'x': 1.0}\n", "measure must give an Estimate for 'x', got 1.0"),
        ("def exact(): return {}['y']\n", ", line {first}: KeyError: 'y'"),
        ("def cases(): return []\n", "cases() gives none"),
        ("def verdict(outcomes): return outcomes[7]\n", ", line {first}: IndexError"),
        ("def draw(outcomes, path): raise RuntimeError('no ink')\n", ", line {first}: RuntimeError: no ink"),
    ],
)
def test_a_mistake_in_ones_own_experiment_is_one_line_with_its_place(call, more, words):
    Path("mine.py").write_text(EXPERIMENT + more, encoding="utf-8")
    answer = call("run", "mine.py", "--particles", "1000")
    assert answer.exit_code == 2
    (line,) = (line for line in answer.output.splitlines() if line.startswith("refused: mine"))
    first = EXPERIMENT.count("\n") + 1
    assert words.format(first=first, second=first + 1) in line
    assert "Traceback" not in answer.output
    assert call("--debug", "run", "mine.py", "--particles", "1000").exception.__traceback__ is not None


def test_a_warning_names_its_case(call):
    named = "\ndef scene(distance=2, radius=0.5):\n    meter = tp.Disk(center=(0, 0, distance), radius=0.1)\n"
    named += "    source = tp.Source(tp.Disk(radius=radius), tp.Lambertian(radiance=100.0))\n"
    named += "    name = 'meter' if distance < 3 else 'far'\n"
    named += "    return tp.Scene([source], detectors=[tp.Detector(meter, name=name, side='back')])\n"
    named += "\ndef measure(result):\n    return {'flux': result[next(iter(result))].flux_in}\n"
    Path("named.py").write_text(EXPERIMENT + CASES + named, encoding="utf-8")
    answer = call("run", "named.py", "--error", "meter.flux_in=0.1")
    assert answer.exit_code == 0, answer.output
    assert "warning     distance=4: run without the error asked for: " in answer.output
    never = call("run", "named.py", "--error", "meter.flux_out=0.1", "--particles", "1e4")
    assert "warning     distance=2: meter.flux_out: " in never.output
    nowhere = call("run", "named.py", "--error", "near.flux_in=0.1")
    assert nowhere.exit_code == 2


def test_long_texts_fold_and_rows_do_not(call):
    Path("long.py").write_text(EXPERIMENT + f"\nquestion = '{'why ' * 60}?'\n", encoding="utf-8")
    lines = call("run", "long.py").output.splitlines()
    assert max(map(len, lines)) <= 110
    assert sum("why" in line for line in lines) == 3


def test_version(call):
    assert call("--version").output.split() == ["transport", __version__]


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
    assert b"\x1b[1;31mrefused: run: no file nowhere.py" in os.read(own, 4096)
    os.close(own)


def test_without_matplotlib_one_line_says_what_to_install(call, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    answer = call("run", "disk.py")
    assert answer.exit_code == 0
    assert "pip install 'transport[plot]'" in answer.output
    assert "Traceback" not in answer.output
    assert "verdict" in answer.output


def test_interruption_prints_the_batches_done_as_incomplete_with_status_130(call):
    call("run", "disk.py", "--no-picture")  # so that nothing is left to compile
    threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT)).start()
    answer = call("run", "endless.py", "--seconds", "60")
    assert answer.exit_code == 130
    assert "verdict     incomplete: interrupted" in answer.output
    assert "irradiance" in answer.output


def test_interruption_before_the_first_batch_has_status_130(call, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("transport.experiment.simulate", interrupted)
    answer = call("run", "disk.py")
    assert answer.exit_code == 130
    assert len(answer.output.splitlines()) == 1


def test_verify_has_one_row_a_law_with_formula_source_and_smallest_bias(call):
    answer = call("verify", "disks.py")
    assert answer.exit_code == 0, answer.output
    assert "E = π L sin²θ on the axis of a diffuse disk (Foote 1915)" in answer.output
    assert sum(line.rstrip().endswith("holds") for line in answer.output.splitlines()) == 2
    rows = json.loads(call("verify", "disks.py", "--json").output)
    assert [row["quantity"] for row in rows] == ["distance=2: irradiance", "distance=4: irradiance"]
    keys = ["law", "source", "sim", "quantity", "value", "error", "unit", "exact", "z", "smallest_bias"]
    assert all(list(row) == keys for row in rows)
    assert all(0 < row["smallest_bias"] < 0.01 for row in rows)


def test_verify_fails_where_pi_is_forgotten(call):
    answer = call("verify", "wrong.py")
    assert answer.exit_code == 1
    assert "FAILS" in answer.output
    assert "0 of 1 rows hold" in answer.output


def test_effects_tell_passes_in_order_fields_and_what_is_absent(call, monkeypatch):
    for module in (cli, printout):
        monkeypatch.setattr(module, "costs_of", lambda scene: {"begin": 0.5})
    record = json.loads(call("effects", "disk.py", "--json").output)
    assert list(record) == ["passes", "fields", "absent", "ns"]
    passes = record["passes"]
    assert passes[0] == "begin"
    assert 0 < passes.index("born_on_disk") < passes.index("move")
    assert record["absent"]["reflect_diffusely"] == "pass"
    assert record["absent"]["time"] == "field"
    assert record["fields"]["x"] == "carried"
    assert not {*passes, *record["fields"]} & set(record["absent"])
    assert record["ns"]["begin"] == 0.5
    assert set(record["ns"]) == set(passes)
    text = call("effects", "disk.py").output
    assert all(word in text for word in ("carried", "scratch", "absent", "every step", "ns per lane"))


def test_effects_are_told_before_anything_runs(call, monkeypatch):
    def forbidden(*_, **__):
        raise AssertionError("compiled or ran something")

    monkeypatch.setattr(printout, "costs_of", lambda scene: {})
    monkeypatch.setattr("transport.engine.driver.machine_of", forbidden)
    monkeypatch.setattr("transport.experiment.simulate", forbidden)
    assert call("effects", "disk.py").exit_code == 0


def test_pass_costs_are_measured_for_every_pass(call):
    record = json.loads(call("effects", "disk.py", "--json").output)
    assert all(0 <= cost < 1e4 for cost in record["ns"].values())


def test_a_pass_that_no_lane_reaches_is_told_so(call):
    Path("away.py").write_text(EXPERIMENT.replace("aim=meter", "side='back'"), encoding="utf-8")
    assert None in json.loads(call("effects", "away.py", "--json").output)["ns"].values()
    output = call("effects", "away.py").output
    assert "not reached" in output
    assert "nan" not in output


def test_the_cost_of_a_pass_is_that_of_the_first_scene_which_reaches_it():
    told = effects.Effects((), ("move", "meet"), {})
    record = effects.record_of_effects(
        [(told, {"move": math.nan, "meet": 1.0}), (told, {"move": 2.0, "meet": 3.0})]
    )
    assert record["ns"] == {"move": 2.0, "meet": 1.0}


def test_bench_prints_its_rows_and_json(call, monkeypatch):
    rows = [
        {
            "name": "closed box, against one particle at a time",
            "value": 5e7,
            "unit": "crossings/s",
            "ratio": 4.0,
        }
    ]
    monkeypatch.setattr(bench, "bench", lambda **_: rows)
    assert json.loads(call("bench", "--json").output) == rows
    assert "4.00" in call("bench").output


def test_bare_command_is_a_menu_of_experiments_grouped_by_question(call, monkeypatch):
    asked = {"a": ("Why?", "A = 1"), "b": ("How?", "B = 2"), "c": ("Why?", "C = 3")}
    modules = {name: SimpleNamespace(question=question, law=law) for name, (question, law) in asked.items()}
    for module in (cli, printout):
        monkeypatch.setattr(module, "experiment_names", lambda: list(modules))
        monkeypatch.setattr(module, "experiment", modules.__getitem__)
    lines = [line.split() for line in call().output.splitlines()]
    order = [lines.index(words.split()) for words in ("Why?", "a A = 1", "c C = 3", "How?", "b B = 2")]
    assert order == sorted(order)
    assert json.loads(call("list", "--json").output)[1] == {"sim": "b", "question": "How?"}


def test_list_loads_no_compiler_and_no_plotting(call):
    code = (
        "import sys\nfrom transport.command.cli import app\napp(['list'], standalone_mode=False)\n"
        "heavy = {'numba', 'scipy', 'matplotlib', 'pyvista', 'xarray'} & set(sys.modules)\nassert not heavy, heavy"
    )
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, "-c", code], check=True, env=environment, stdout=subprocess.DEVNULL)
