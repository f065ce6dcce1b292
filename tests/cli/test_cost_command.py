"""`transport cost`: prices, bins and effects of an experiment, as tables, a diagram and JSON."""

import json
from pathlib import Path

import pytest

from tests.own_experiments import EXPERIMENT
from transport.analysis.effects import EffectCost

UNAIMED = (
    EXPERIMENT.replace(", aim=meter", "")
    .replace("radius=1e-4", "radius=0.2")
    .replace('name="meter")', 'name="meter", positions=tp.Positions(u=8))')
)
MEASURE = "\ndef measure(result):\n    return {'emitted': result.ledger['emitted'], 'flux': result['meter'].flux_in}\n"
EFFECTS = [EffectCost("births", 3.0, 0.75, False, ("begin",)), EffectCost("media", 1.0, 0.25, True, ("fly",))]


@pytest.fixture
def few_ways(monkeypatch):
    """Two ways, and effects that need no measuring."""
    monkeypatch.setattr("transport.cli.cost.effect_costs", lambda scene: EFFECTS)
    ways = {"analog": {}, "aimed": {"estimator": "aimed"}}
    monkeypatch.setattr("transport.analysis.cost.methods_of_scene", lambda scene: ways)
    Path("open.py").write_text(UNAIMED + MEASURE, encoding="utf-8")


@pytest.mark.slow
def test_cost_prints_prices_bins_effects_and_the_diagram(call, few_ways):
    answer = call("cost", "open.py", "--seconds", "1", "--out", "figures")
    assert answer.exit_code == 0, answer.output
    for words in (
        "flux",
        "best estimate",
        "0.01 %",
        "slope",
        "aimed",
        "bins along u",
        "blur",
        "can be left out",
    ):
        assert words in answer.output, words
    assert any(
        line.split()[:1] == ["media"] and line.split()[-3:] == ["25", "%", "yes"]
        for line in answer.output.splitlines()
    )
    assert Path("figures/cost_open.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_the_diagram_is_drawn_where_only_one_size_of_run_fits_into_the_time(call, few_ways):
    """As on a busy machine, where the first runs take too long for larger ones."""
    answer = call("cost", "open.py", "--seconds", "1e-9", "--out", "figures")
    assert answer.exit_code == 0, answer.output
    assert "aimed: its error is known for one size of run only" in " ".join(answer.output.split())
    assert Path("figures/cost_open.png").read_bytes().startswith(b"\x89PNG")


def test_cost_as_json(call, few_ways):
    answer = call("cost", "open.py", "--seconds", "0.5", "--json", "--set", "distance=1.0")
    record = json.loads(answer.stdout)
    assert record["sim"] == "open" and record["parameters"] == {"distance": 1.0}
    assert [way["name"] for way in record["ways"]] == ["analog", "aimed"]
    assert {"error", "seconds", "is_extrapolated"} == set(record["ways"][0]["prices"][0])
    assert record["bins"]["bins"] == [1, 2, 4, 8] and record["bins"]["best"] in record["bins"]["bins"]
    assert [effect["name"] for effect in record["effects"]] == ["births", "media"]
    assert not Path("out").exists()


def test_an_unknown_quantity_is_refused(call, few_ways):
    answer = call("cost", "open.py", "--quantity", "fluxx")
    assert answer.exit_code == 2 and "no quantity 'fluxx'" in answer.output
