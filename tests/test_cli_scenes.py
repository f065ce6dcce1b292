"""`transport run scene.json` prints what the guide shows, with the numbers of the same scene in Python."""

import json
import re

import pytest

import transport as tp
from tests.round_trips import faults_of
from transport.cli.docs import GUIDES
from transport.io.json.schema import schema_text

GUIDE = (GUIDES / "scenes.md").read_text(encoding="utf-8")
LAMP = next(iter(re.findall(r"^```json\n(.*?)^```$", GUIDE, re.M | re.S)))
SAID = next(iter(re.findall(r"^```text\n(.*?)^```$", GUIDE, re.M | re.S)))

REFUSALS = re.findall(r"^\| `(\"[^|]*)` \| `(lamp\.json: [^|]*)` \|$", GUIDE, re.M)


@pytest.fixture
def run(call, tmp_path):
    """Run the guide's scene, or another text, with these options."""

    def run(*options, text=LAMP):
        (tmp_path / "lamp.json").write_text(text, encoding="utf-8")
        return call("run", "lamp.json", *options)

    return run


def lines_of(text):
    """All lines but those on times, and on the progress of a first compilation, which begin with the hour."""
    timed = re.compile(r"cost |next digit |\d{4}-\d\d-\d\d ")
    return [line.rstrip() for line in text.splitlines() if line.strip() and not timed.match(line)]


def test_the_scene_of_the_guide_runs_as_the_guide_says(run):
    answer = run()
    assert answer.exit_code == 0, answer.output
    assert lines_of(answer.output) == lines_of(SAID)
    assert faults_of(json.loads(LAMP)) == []


def test_its_numbers_are_those_of_python(run):
    record = json.loads(run("--json", "--particles", "1e4", "--seed", "3").output)
    result = tp.simulate(tp.Scene.from_json(LAMP), particles=10_000, seed=3, progress=False)
    numbers = {row["name"]: (row["value"], row["error"], row["unit"]) for row in record["quantities"]}
    flux = result["floor"].flux_in
    assert numbers["floor.flux_in"] == (flux.value, flux.error, "W")
    bins = {row["name"]: row for row in record["bins"]}
    assert bins["floor.irradiance"]["value"] == result["floor"].irradiance.value.tolist()
    assert (
        bins["floor.irradiance"]["dims"] == ["u", "v"] and len(bins["floor.irradiance"]["coords"]["u"]) == 9
    )
    assert record["sim"] == "lamp" and record["verdict"] == ""


def test_a_wrong_file_is_refused_with_the_place(run):
    answer = run(text=LAMP.replace("0.4", "1.4"))
    assert answer.exit_code == 2
    assert "lamp.json: shared.wood.albedo: Diffuse: albedo must be in [0, 1], got 1.4" in answer.output
    assert "no parameter 'x'" in run("--set", "x=1").output


@pytest.mark.parametrize(("wrong", "said"), REFUSALS)
def test_a_refusal_of_the_guide_is_that(wrong, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    name = wrong.split(":")[0]
    text = re.sub(rf'{name}: ("(?:Disk|floor)"|[0-9.]+)', wrong, LAMP, count=1)
    assert text != LAMP and len(REFUSALS) == 4
    (tmp_path / "lamp.json").write_text(text, encoding="utf-8")
    with pytest.raises(tp.SceneError) as refusal:
        tp.Scene.from_json("lamp.json")
    assert str(refusal.value) == said


def test_the_schema_is_printed_and_written(call, tmp_path):
    assert call("schema").output == schema_text()
    assert call("schema", "--out", "scene.schema.json").output == ""
    assert (tmp_path / "scene.schema.json").read_text(encoding="utf-8") == schema_text()
    refused = call("schema", "--out", "nowhere/scene.json")
    assert refused.exit_code == 2 and "cannot write nowhere/scene.json: No such file" in refused.output
