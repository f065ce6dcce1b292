"""`transport run`: what it prints and draws, its JSON, its cases, and where it stops."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.own_experiments import CASES, EXPERIMENT, ROOT


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
    assert list(record) == [
        "sim",
        "parameters",
        "quantities",
        "ledger",
        "cost",
        "verdict",
        "warnings",
        "method",
    ]
    assert record["sim"] == "disk"
    assert record["parameters"] == {"distance": 3}
    (quantity,) = record["quantities"]
    assert list(quantity) == ["name", "value", "error", "unit", "verdict", "findings", "exact", "z"]
    assert quantity["verdict"] == "sound" and quantity["findings"] == []
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


@pytest.mark.parametrize("limit", [("--error", "meter.irradiance=1e-3"), ("--seconds", "0.1")])
def test_run_for_an_error_or_a_time_says_which_estimator_pilots_chose(call, limit):
    method = json.loads(call("run", "disk.py", "--json", *limit).output)["method"]
    assert (method["estimator"], method["sampling"]) != (
        "analog",
        "random",
    )  # which is a thousand times as dear here
    sampled = json.loads(call("run", "disk.py", "--json", *limit, "--sampling", "random").output)["method"]
    assert sampled["sampling"] == "random"
    named = json.loads(call("run", "disk.py", "--json", *limit, "--estimator", "analog").output)["method"]
    counted = json.loads(call("run", "disk.py", "--json", "--particles", "1e4").output)["method"]
    assert (named["estimator"], named["sampling"]) == ("analog", "random")
    assert (counted["estimator"], counted["sampling"]) == ("analog", "random")


def test_run_stops_at_the_error_asked_for(call):
    record = json.loads(call("run", "disk.py", "--json", "--error", "meter.irradiance=1e-4").output)
    (quantity,) = record["quantities"]
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
    known, unknown = json.loads(call("run", "more.py", "--json").output)["quantities"]
    assert known["exact"] > 0
    assert unknown["exact"] is unknown["z"] is None
    assert [row["quantity"] for row in json.loads(call("verify", "more.py", "--json").output)] == [
        "irradiance"
    ]


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


def test_of_several_cases_it_is_told_in_how_many_pilots_took_which_estimator(call):
    Path("cases.py").write_text(EXPERIMENT + CASES, encoding="utf-8")
    answer = call("run", "cases.py", "--seconds", "0.05", "--no-picture")
    (line,) = (line for line in answer.output.splitlines() if line.startswith("estimator "))
    assert "chosen by pilots: " in line and " of 2 cases" in line and "repeat" not in answer.output
