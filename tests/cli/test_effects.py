"""`transport effects`: passes, fields, what is absent, and the cost of each pass and effect beside a whole run."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

import transport as tp
from tests.bench.speed import box_scene
from tests.own_experiments import EXPERIMENT
from transport.analysis.effects import (
    EFFECTS,
    Effects,
    PassCost,
    costs_by_effect,
    effect_costs,
    effects_of,
    pass_costs,
    run_ns,
)
from transport.cli.effects import effects_record


@pytest.fixture(scope="module")
def costs():
    return pass_costs(box_scene())


@pytest.mark.slow
def test_effects_prints_passes_fields_costs_and_a_check_and_json_has_the_same(call):
    text = call("effects", "disk.py").output
    headings = (
        "carried",
        "scratch",
        "absent",
        "memory",
        "compiled",
        "births at emitter 0",
        "ns per lane",
        "every step",
        "can be left out",
    )
    places = [text.index(words) for words in headings]
    assert places == sorted(places)
    assert "media, " in text and "ns in a whole run" in text and "rays to detectors" not in text
    record = json.loads(call("effects", "disk.py", "--json").stdout)
    assert list(record) == ["passes", "fields", "absent", "ns", "scenes"]
    passes = record["passes"]
    assert passes[0] == "start_history" and 0 < passes.index("born_on_disk") < passes.index("move")
    assert record["absent"]["reflect_diffusely"] == "pass" and record["absent"]["time"] == "field"
    assert record["fields"]["x"] == "carried"
    assert not {*passes, *record["fields"]} & set(record["absent"])
    assert set(record["ns"]) == set(passes) and all(0 <= cost < 1e4 for cost in record["ns"].values())
    (scene,) = record["scenes"]
    assert list(scene) == ["cases", "memory", "compiled", "effects", "ns_per_history"]
    assert scene["compiled"]["passes"] >= scene["compiled"]["on_disk"] >= 0
    assert 0 < scene["memory"]["carried"] <= scene["memory"]["touched"] < scene["memory"]["known"]
    assert math.isclose(sum(effect["share"] for effect in scene["effects"]), 1)
    total = sum(effect["ns"] for effect in scene["effects"])
    assert math.isclose(scene["ns_per_history"]["passes"], total) and scene["ns_per_history"]["run"] > 0


def test_what_is_absent_is_printed_before_anything_is_compiled(call, monkeypatch):
    class Forbidden(Exception):
        pass

    def forbidden(*_, **__):
        raise Forbidden

    monkeypatch.setattr("transport.engine.driver.compile_program", forbidden)
    answer = call("effects", "disk.py")
    assert isinstance(answer.exception, Forbidden)
    assert all(word in answer.output for word in ("carried", "scratch", "absent", "memory"))
    assert "compiled  " not in answer.output


@pytest.mark.slow
def test_a_pass_that_no_lane_reaches_is_printed_as_not_reached(call):
    Path("away.py").write_text(EXPERIMENT.replace("aim=meter", "side='back'"), encoding="utf-8")
    assert None in json.loads(call("effects", "away.py", "--json").stdout)["ns"].values()
    output = call("effects", "away.py").output
    assert "not reached" in output and "nan" not in output


@pytest.mark.slow
def test_a_scene_with_rays_to_detectors_is_priced_without_them_with_a_note(call):
    lamp = tp.Source(tp.Disk(radius=1.0), tp.Lambertian(power=1.0))
    tp.Scene(lamp, (), tp.PointDetector((0, 0, 2), "p")).to_json("point.json")
    output = call("effects", "point.json").output
    assert "rays to detectors and split copies (?) are in the run only" in " ".join(output.split())


@pytest.mark.slow
def test_the_former_options_are_accepted_or_name_the_benchmark(call):
    assert call("effects", "disk.py", "--quick").exit_code == 0
    answer = call("effects", "disk.py", "--cold")
    assert answer.exit_code == 2 and "python -m tests.bench cold disk.py" in answer.output


# Measurements


@pytest.mark.slow
def test_every_pass_of_a_program_has_a_cost(costs):
    assert set(costs) == set(effects_of(box_scene()).passes)
    assert all(0.0 <= cost.ns_per_lane < 1000.0 and cost.lanes > 0 for cost in costs.values())
    assert sum(cost.ns_per_lane for cost in costs.values()) > 0.1  # ns: less than one random block takes


@pytest.mark.slow
def test_lanes_per_history_follow_from_the_albedo(costs):
    """At an albedo of a half every second landing is followed by a roulette, which a quarter survives: 2 / (1 - 1/4)."""
    assert costs["start_history"].lanes == 1.0
    assert costs["absorb"].lanes == pytest.approx(8 / 3, rel=0.05)


@pytest.mark.slow
def test_the_sum_over_the_passes_is_about_the_time_of_a_whole_run(costs):
    """The driver's own work is not in the sum, and other load may be in the run: within a factor of three."""
    total = sum(cost.ns for cost in costs.values())
    assert 1 / 3 < total / run_ns(box_scene(), seconds=0.02) < 3


def test_a_pass_that_no_particle_reaches_costs_nothing():
    behind = tp.Detector(tp.Disk(center=(0, 0, -1), radius=0.1), name="behind")
    scene = tp.Scene([tp.Source(tp.Disk(radius=0.5), tp.Lambertian(radiance=1.0))], detectors=[behind])
    costs = pass_costs(scene)
    assert set(costs) == set(effects_of(scene).passes)
    assert costs["cover_disk"].ns > 0.0
    assert np.isnan(costs["bin_crossings"].ns_per_lane) and costs["bin_crossings"].ns == 0.0


@pytest.mark.slow
def test_effects_of_a_measured_scene_add_up_to_one():
    found = {effect.name: effect for effect in effect_costs(box_scene(cells=4))}
    assert found["births"].ns > 0 and math.isclose(sum(effect.share for effect in found.values()), 1)
    assert found["surfaces"].can_go and not found["births"].can_go


def test_an_effect_costs_its_passes_for_each_history():
    costs = {"begin": (2.0, 1.0), "fly": (1.0, 4.0), "new": (0.5, 4.0), "never": (math.nan, 0.0)}
    found = costs_by_effect(
        {name: PassCost(*cost) for name, cost in costs.items()},
        {"begin": "emission", "fly": "collisions", "never": "optics"},
    )
    assert {effect.name: effect.ns for effect in found} == {
        "births": 2.0, "media": 4.0, "other": 2.0, "surfaces": 0.0,
    }  # fmt: skip
    assert found[0].name == "media" and found[0].share == 0.5
    assert [effect.can_go for effect in found if effect.name in ("births", "media")] == [True, False]


def test_every_file_of_passes_belongs_to_one_effect():
    from transport.engine.registry import MODULE_OF_PASS, MODULES

    members = [member for members in EFFECTS.values() for member in members]
    assert len(set(members)) == len(members)
    assert set(members) >= set(MODULES)
    assert set(members) - set(MODULES) <= set(MODULE_OF_PASS)


def test_the_cost_of_a_pass_is_that_of_the_first_scene_that_reaches_it():
    found = Effects((), ("move", "meet"), {})
    costs = [{"move": math.nan, "meet": 1.0}, {"move": 2.0, "meet": 3.0}]
    pairs = [(found, {name: PassCost(ns, 1.0) for name, ns in each.items()}) for each in costs]
    assert effects_record(pairs)["ns"] == {"move": 2.0, "meet": 1.0}
