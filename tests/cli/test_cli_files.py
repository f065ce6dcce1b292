"""Files on the command line: runs that are saved, in parts, resumed, merged and shown; scenes as JSON."""

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

import transport as tp
from tests.plain_scenes import SMALL
from tests.round_trips import faults_of
from tests.same_batches import assert_same
from transport.cli.docs import GUIDES
from transport.io import resuming
from transport.io.atomic import FileError
from transport.io.json.schema import schema_text
from transport.results.record import total_cost
from transport.run import progress
from transport.run import run as running
from transport.verification import experiment


@pytest.fixture
def run(call, tmp_path):
    """Run a scene of one case with these options."""
    SMALL.to_json(tmp_path / "small.json")
    return lambda *options: call("run", "small.json", "--particles", "5000", *options)


# Saved runs


@pytest.mark.slow
def test_parts_are_saved_merged_and_shown(run, call, tmp_path):
    assert run("--save", "whole.npz", "--seed", "4").exit_code == 0
    for k in (1, 2):
        assert run("--save", f"{k}.nc", "--part", f"{k}/2", "--seed", "4").exit_code == 0
    merged = call("merge", "2.nc", "1.nc", "--out", "merged.nc")
    assert merged.exit_code == 0 and "5_000 particles in 32 batches, seed 4" in merged.output
    whole = tp.load(tmp_path / "whole.npz")
    assert_same(tp.load(tmp_path / "merged.nc").batches, whole.batches)
    shown = call("show", "merged.nc").output
    assert f"run by: transport {tp.__version__}" in shown and "flux_in" in shown
    record = json.loads(call("show", "whole.npz", "--json").stdout)
    flux = next(row for row in record["quantities"] if row["name"] == "meter.flux_in")
    assert flux["value"] == whole["meter"].flux_in.value and record["seeds"] == [4]


def test_a_part_names_its_run(run, call):
    """In its file, as a line of several, and for machines."""
    run("--save", "1.npz", "--part", "1/2")
    run("--save", "2.npz", "--part", "2/2")
    lines = call("show", "1.npz", "2.npz").output.splitlines()
    assert [line.split()[0] for line in lines] == ["1.npz", "2.npz"]
    assert lines[1].endswith("2_496 particles in 16 batches, seed 0; part 2 of 2 of a run of 5_000")
    one, other = json.loads(call("show", "1.npz", "2.npz", "--json").stdout)
    assert (one["file"], one["part"], one["asked"]) == ("1.npz", [1, 2], 5000) and other["part"] == [2, 2]
    assert one["cost"]["particles"] == 2504 and one["left out"] == []


def test_json_has_the_bins_of_a_saved_run(call, tmp_path):
    meter = tp.Detector(tp.Sphere(radius=1.0), name="meter", directions=tp.Directions(mu=4))
    tp.Scene(tp.Source(tp.Disk(radius=0.5), tp.Lambertian(radiance=1.0)), (), meter).to_json(
        tmp_path / "bins.json"
    )
    assert call("run", "bins.json", "--particles", "1e4", "--save", "bins.npz").exit_code == 0
    record = json.loads(call("show", "bins.npz", "--json").stdout)
    radiance = next(row for row in record["bins"] if row["name"] == "meter.radiance_out")
    result = tp.load(tmp_path / "bins.npz")["meter"].radiance_out
    assert radiance["value"] == result.value.tolist() and radiance["dims"] == list(result.dims)


def test_no_other_run_is_overwritten_without_the_option(run, call, tmp_path):
    for k in (1, 2):
        run("--save", f"{k}.npz", "--part", f"{k}/2")
    before = (tmp_path / "1.npz").read_bytes()
    for answer, said in (
        (run("--save", "1.npz"), "--save: 1.npz exists; pass --overwrite"),
        (call("merge", "1.npz", "2.npz", "--out", "1.npz"), "--out: 1.npz is one of the files to merge"),
    ):
        assert answer.exit_code == 2 and said in answer.output, answer.output
        assert (tmp_path / "1.npz").read_bytes() == before
    assert run("--resume", "1.npz", "--part", "1/2", "--save", "1.npz").exit_code == 0  # its own
    assert call("merge", "1.npz", "2.npz", "--out", "whole.npz").exit_code == 0
    assert "--out: whole.npz exists" in call("merge", "1.npz", "2.npz", "--out", "whole.npz").output
    assert call("merge", "1.npz", "2.npz", "--out", "whole.npz", "--overwrite").exit_code == 0
    assert run("--save", "1.npz", "--overwrite").exit_code == 0
    assert tp.load(tmp_path / "1.npz").particles == 5000


def test_each_case_has_a_file_of_its_own(call, tmp_path):
    (tmp_path / "sun.npz").touch()
    answer = call("run", "sun", "--particles", "1e4", "--resume", "sun.npz")
    assert answer.exit_code == 2 and "whose files are sun_1.npz to sun_" in answer.output
    (tmp_path / "sun.npz").unlink()
    answer = call("run", "sun", "--particles", "1e4", "--save", "sun.npz", "--no-picture")
    assert answer.exit_code == 0, answer.output
    names = sorted(path.name for path in tmp_path.glob("*.npz"))
    assert names == [f"sun_{number}.npz" for number in range(1, len(names) + 1)] and len(names) > 1
    assert "sun_1.npz" in call("show", "sun.npz").output


def test_the_same_command_begins_goes_on_and_has_nothing_to_do(run, tmp_path):
    again = ("--checkpoint", "run.npz", "--resume", "run.npz", "--every", "1", "--json")
    first, second = (json.loads(run(*again).stdout) for _ in range(2))
    assert first["quantities"] == second["quantities"]
    assert tp.load(tmp_path / "run.npz").particles == 5_000


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--part", "3"), "--part must be like 2/8"),
        (("--part", "0/8"), "parts count from 1: part=(1, 8)"),
        (("--part", "1/64"), "pass batches=64 or more, the same in every part"),
        (("--batches", "3.5"), "--batches must be a whole number"),
        (("--save", "run.txt"), "ends in .nc or .npz"),
        (("--save", "none/run.npz"), "make none first"),
        (("--checkpoint", "none/run.nc"), "make none first"),
        (("--every", "5"), "--every needs --checkpoint FILE"),
    ],
)
def test_wrong_files_and_parts_are_refused_before_the_run(run, monkeypatch, options, words):
    if "--save" in options:
        monkeypatch.setattr(experiment, "simulate_all_quantities", None)
    answer = run(*options)
    assert answer.exit_code == 2 and words in answer.output, answer.output


def test_missing_files_and_folders_are_refused(call):
    assert "no file none.nc" in call("show", "none.nc").output
    answer = call("merge", "1.nc", "2.nc", "--out", "none/whole.nc")
    cure = "--out none/whole.nc: the folder does not exist; make none first"
    assert answer.exit_code == 2 and cure in answer.output


@pytest.mark.parametrize(
    ("option", "place", "words"),
    [
        ("--save", (tp.Result, "save"), "not saved: cannot write run.npz"),
        ("--checkpoint", (resuming, "save"), "not saved at its end: cannot write run.npz"),
    ],
    ids=["save", "checkpoint"],
)
def test_a_run_is_printed_although_the_disk_is_full_at_its_end(
    run, monkeypatch, recwarn, option, place, words
):
    def full(*_):
        raise FileError("cannot write run.npz: No space left")

    monkeypatch.setattr(*place, full)
    answer = run(option, "run.npz", "--json")
    record = json.loads(answer.stdout)
    assert answer.exit_code == 2 and record["quantities"] and words in answer.stderr, answer.output
    if option == "--save":
        assert any(words in warning for warning in record["warnings"])
    else:
        assert any(each.category is resuming.CheckpointWarning for each in recwarn)


def test_a_resumed_run_that_is_saved_nowhere_has_a_warning(run):
    assert run("--save", "run.npz").stderr == ""
    answer = run("--resume", "run.npz", "--particles", "6000")
    assert answer.exit_code == 0 and "pass --checkpoint run.npz or --save FILE" in answer.stderr
    assert run("--resume", "run.npz", "--particles", "6000", "--save", "more.npz").stderr == ""


def test_batches_are_as_in_python(run, tmp_path):
    assert run("--batches", "5e1", "--save", "run.npz").exit_code == 0
    assert len(tp.load(tmp_path / "run.npz").batches) == 50


def test_a_log_has_lines_now_and_then(run, monkeypatch, capfd):
    monkeypatch.setattr(running, "POLL_SECONDS", 0.0)
    monkeypatch.setattr(progress, "FIRST_INTERVAL", 0.0)
    said = run("--batches", "64", "--json")
    line = said.stderr.splitlines()[-1]
    assert json.loads(said.stdout) and len(said.stderr.splitlines()) > 1
    assert re.fullmatch(
        r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d: after .* \d* ?\d+ particles, about .* to go, until .*", line
    )
    tp.simulate(SMALL, particles=5_000, threads=1)
    assert capfd.readouterr().err == ""


@pytest.mark.slow
def test_the_price_of_the_next_digit_is_that_of_the_saved_run(call, tmp_path):
    """In quasi-random sampling the slope is measured; a table of one case has it, and so has its file."""
    SMALL.to_json(tmp_path / "small.json")
    options = ("--error", "meter.flux_in=2e-2", "--sampling", "sobol", "--estimator", "analog")
    assert call("run", "small.json", *options, "--save", "small.npz").exit_code == 0
    cost = tp.load(tmp_path / "small.npz").cost
    assert cost.slopes and cost.next_digit != pytest.approx(100 * cost.seconds, rel=1e-6)
    assert total_cost([cost]).next_digit == cost.next_digit
    assert total_cost([cost, cost]).next_digit == pytest.approx(2 * cost.next_digit)
    assert total_cost([cost, replace(cost, slopes={})]).next_digit == pytest.approx(200 * cost.seconds)


# Scenes as JSON: the guide's scene

GUIDE = (GUIDES / "scenes.md").read_text(encoding="utf-8")
LAMP = next(iter(re.findall(r"^```json\n(.*?)^```$", GUIDE, re.M | re.S)))
SAID = next(iter(re.findall(r"^```text\n(.*?)^```$", GUIDE, re.M | re.S)))

REFUSALS = re.findall(r"^\| `(\"[^|]*)` \| `(lamp\.json: [^|]*)` \|$", GUIDE, re.M)


def scene_run(call, *options, text=LAMP):
    """Run the guide's scene, or another text, with these options."""
    Path("lamp.json").write_text(text, encoding="utf-8")
    return call("run", "lamp.json", *options)


def lines_of(text):
    """All lines but those on times, and on the progress of a first compilation, which begin with the hour.

    The rule below a table's heads counts, but not its length: rich before 14.3 draws it one column longer.
    """
    timed = re.compile(r"cost |next digit |\d{4}-\d\d-\d\d ")
    lines = [line.rstrip() for line in text.splitlines() if line.strip() and not timed.match(line)]
    return [re.sub("^─+$", "─", line) for line in lines]


def test_the_scene_of_the_guide_runs_as_the_guide_says(call):
    answer = scene_run(call)
    assert answer.exit_code == 0, answer.output
    assert lines_of(answer.output) == lines_of(SAID)
    assert faults_of(json.loads(LAMP)) == []


def test_its_numbers_are_those_of_python(call):
    record = json.loads(scene_run(call, "--json", "--particles", "1e4", "--seed", "3").stdout)
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


def test_a_wrong_file_is_refused_with_the_place(call):
    answer = scene_run(call, text=LAMP.replace("0.4", "1.4"))
    assert answer.exit_code == 2
    assert "lamp.json: shared.wood.albedo: Diffuse: albedo must be in [0, 1], got 1.4" in answer.output
    assert "no parameter 'x'" in scene_run(call, "--set", "x=1").output


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
