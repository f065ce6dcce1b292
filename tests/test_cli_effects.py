"""`transport effects`: passes, fields, what is absent, and what each pass costs."""

import json
import math
from pathlib import Path

from tests.own_experiments import EXPERIMENT
from transport.command import cli, effects, printout


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
