"""`transport effects`: passes, fields, what is absent, and what each pass costs."""

import json
import math
from dataclasses import replace
from pathlib import Path

from tests.own_experiments import EXPERIMENT
from transport.cli import measure
from transport.cli.effects import passes, report
from transport.cli.effects.prices import ADDITIONS, base_room, prices_of
from transport.cli.effects.treatment import Treatment


def test_effects_tell_passes_in_order_fields_and_what_is_absent(call, monkeypatch):
    for module in (measure, report):
        monkeypatch.setattr(module, "measure_passes", lambda scene: {"start_history": 0.5})
    record = json.loads(call("effects", "disk.py", "--json", "--quick").output)
    assert list(record) == ["passes", "fields", "absent", "ns", "scenes"]
    passes = record["passes"]
    assert passes[0] == "start_history"
    assert 0 < passes.index("born_on_disk") < passes.index("move")
    assert record["absent"]["reflect_diffusely"] == "pass"
    assert record["absent"]["time"] == "field"
    assert record["fields"]["x"] == "carried"
    assert not {*passes, *record["fields"]} & set(record["absent"])
    assert record["ns"]["start_history"] == 0.5
    assert set(record["ns"]) == set(passes)
    text = call("effects", "disk.py", "--quick").output
    assert all(word in text for word in ("carried", "scratch", "absent", "every step", "ns per lane"))
    assert "media, " in text and "cost of one additional effect" not in text


def test_effects_are_told_before_anything_is_compiled(call, monkeypatch):
    class Forbidden(Exception):
        pass

    def forbidden(*_, **__):
        raise Forbidden

    monkeypatch.setattr("transport.engine.driver.compile_program", forbidden)
    monkeypatch.setattr("transport.verification.experiment.simulate_all_quantities", forbidden)
    answer = call("effects", "disk.py")
    assert isinstance(answer.exception, Forbidden)
    assert all(word in answer.output for word in ("carried", "scratch", "absent", "memory"))
    assert "compiled  " not in answer.output


def test_what_compiles_what_it_weighs_and_what_each_effect_costs_are_told(call):
    (scene,) = json.loads(call("effects", "disk.py", "--json", "--quick").output)["scenes"]
    assert scene["compiled"]["passes"] >= scene["compiled"]["on_disk"] >= 0
    assert 0 < scene["memory"]["carried"] <= scene["memory"]["touched"] < scene["memory"]["known"]
    assert abs(sum(effect["share"] for effect in scene["effects"]) - 1) < 1e-9
    assert scene["additions"] is None and scene["cold"] is None


def test_effects_more_are_priced_over_the_scene_as_it_is():
    """A few of the list, with runs so short that only their shape is looked at."""
    names = ("a clock", "... bins of time, 16", "scattering", "... Rayleigh", "estimator aimed")
    few = [ADDITIONS[name] for name in names]
    found = prices_of(base_room(), few, turns=2, seconds=1e-4)
    assert [(price.name, price.over) for price in found.prices] == [
        ("unchanged", None),
        ("a clock", "unchanged"),
        ("... bins of time, 16", "a clock"),
        ("scattering", "unchanged"),
        ("... Rayleigh", "absorption and scattering"),
    ]
    assert list(found.refused) == ["estimator aimed"]
    assert all(price.ns > 0 and price.ratio > 0 for price in found.prices)
    clocked = Treatment(replace(base_room().scene, duration=1.0))
    again = prices_of(clocked, few[:2], turns=2, seconds=1e-4)
    assert again.idle == ("a clock",)
    assert [(price.name, price.over) for price in again.prices][1:] == [("... bins of time, 16", "unchanged")]


def test_a_passes_cost_shows_in_the_price_of_its_effect():
    """Voxels of a volume detector cost at least half as much again as the base room."""
    dear = ADDITIONS["a volume detector of 8 x 8 x 8 cells"]
    (base, price) = prices_of(base_room(), [dear], turns=5, seconds=0.02).prices
    assert price.ratio > 1.5 and price.added > 0.5 * base.ns
    assert base.ratio == 1 and base.added == 0


def test_pass_costs_are_measured_for_every_pass(call):
    record = json.loads(call("effects", "disk.py", "--json", "--quick").output)
    assert all(0 <= cost < 1e4 for cost in record["ns"].values())


def test_a_pass_that_no_lane_reaches_is_told_so(call):
    Path("away.py").write_text(EXPERIMENT.replace("aim=meter", "side='back'"), encoding="utf-8")
    assert None in json.loads(call("effects", "away.py", "--json", "--quick").output)["ns"].values()
    output = call("effects", "away.py", "--quick").output
    assert "not reached" in output
    assert "nan" not in output


def test_the_cost_of_a_pass_is_that_of_the_first_scene_which_reaches_it():
    told = passes.Effects((), ("move", "meet"), {})
    record = passes.effects_record(
        [(told, {"move": math.nan, "meet": 1.0}), (told, {"move": 2.0, "meet": 3.0})]
    )
    assert record["ns"] == {"move": 2.0, "meet": 1.0}
