"""The command line on saved runs: saved, in parts, gone on with, merged and shown, as in Python."""

import json
import re
from dataclasses import replace

import pytest

import transport as tp
from tests.plain_scenes import SMALL
from tests.same_batches import assert_same
from transport.io import resuming
from transport.io.atomic import FileError
from transport.results.record import total_cost
from transport.run import progress
from transport.run import run as running
from transport.verification import experiment


@pytest.fixture
def run(call, tmp_path):
    """Run a scene of one case with these options."""
    SMALL.to_json(tmp_path / "small.json")
    return lambda *options: call("run", "small.json", "--particles", "5000", *options)


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
    record = json.loads(call("show", "whole.npz", "--json").output)
    flux = next(row for row in record["quantities"] if row["name"] == "meter.flux_in")
    assert flux["value"] == whole["meter"].flux_in.value and record["seeds"] == [4]


def test_a_part_says_what_it_is_of(run, call):
    """In its file, as a line of several, and for machines."""
    run("--save", "1.npz", "--part", "1/2")
    run("--save", "2.npz", "--part", "2/2")
    lines = call("show", "1.npz", "2.npz").output.splitlines()
    assert [line.split()[0] for line in lines] == ["1.npz", "2.npz"]
    assert lines[1].endswith("2_496 particles in 16 batches, seed 0; part 2 of 2 of a run of 5_000")
    one, other = json.loads(call("show", "1.npz", "2.npz", "--json").output)
    assert (one["file"], one["part"], one["asked"]) == ("1.npz", [1, 2], 5000) and other["part"] == [2, 2]
    assert one["cost"]["particles"] == 2504 and one["left out"] == []


def test_bins_are_told_for_machines(call, tmp_path):
    meter = tp.Detector(tp.Sphere(radius=1.0), name="meter", directions=tp.Directions(mu=4))
    tp.Scene(tp.Source(tp.Disk(radius=0.5), tp.Lambertian(radiance=1.0)), (), meter).to_json(
        tmp_path / "bins.json"
    )
    assert call("run", "bins.json", "--particles", "1e4", "--save", "bins.npz").exit_code == 0
    record = json.loads(call("show", "bins.npz", "--json").output)
    radiance = next(row for row in record["bins"] if row["name"] == "meter.radiance_out")
    result = tp.load(tmp_path / "bins.npz")["meter"].radiance_out
    assert radiance["value"] == result.value.tolist() and radiance["dims"] == list(result.dims)


def test_no_other_run_is_written_over_unless_that_is_said(run, call, tmp_path):
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


def test_files_of_several_cases_are_named(call, tmp_path):
    (tmp_path / "sun.npz").touch()
    answer = call("run", "sun", "--particles", "1e4", "--resume", "sun.npz")
    assert answer.exit_code == 2 and "whose files are sun_1.npz to sun_" in answer.output


def test_the_same_command_begins_goes_on_and_has_nothing_to_do(run, tmp_path):
    again = ("--checkpoint", "run.npz", "--resume", "run.npz", "--every", "1", "--json")
    first, second = (json.loads(run(*again).output) for _ in range(2))
    assert first["quantities"] == second["quantities"]
    assert tp.load(tmp_path / "run.npz").particles == 5_000


def test_each_case_has_a_file_of_its_own(call, tmp_path):
    said = call("run", "sun", "--particles", "1e4", "--save", "sun.npz", "--no-picture")
    assert said.exit_code == 0, said.output
    names = sorted(path.name for path in tmp_path.glob("*.npz"))
    assert names == [f"sun_{number}.npz" for number in range(1, len(names) + 1)] and len(names) > 1


def test_wrong_files_and_parts_are_refused_in_a_line(run, call):
    for options, said in (
        (("--part", "3"), "--part must be like 2/8"),
        (("--part", "0/8"), "parts count from 1: part=(1, 8)"),
        (("--part", "1/64"), "pass batches=64 or more, the same in every part"),
        (("--save", "run.txt"), "ends in .nc or .npz"),
        (("--checkpoint", "none/run.nc"), "make none first"),
        (("--every", "5"), "--every needs --checkpoint FILE"),
    ):
        answer = run(*options)
        assert answer.exit_code == 2 and said in answer.output, answer.output
    assert "no file none.nc" in call("show", "none.nc").output


def test_a_file_that_cannot_be_saved_is_refused_before_the_run(run, monkeypatch):
    monkeypatch.setattr(experiment, "simulate_all_quantities", None)
    for file, said in (("run.txt", "ends in .nc or .npz"), ("none/run.npz", "make none first")):
        answer = run("--save", file)
        assert answer.exit_code == 2 and said in answer.output, answer.output


def test_where_the_disk_is_full_in_the_end_the_run_is_told_all_the_same(run, monkeypatch):
    def full(*_):
        raise FileError("cannot write run.npz: No space left")

    monkeypatch.setattr(tp.Result, "save", full)
    answer = run("--save", "run.npz", "--json")
    record = json.loads(answer.stdout)
    assert answer.exit_code == 2 and record["quantities"], answer.output
    assert "not saved: cannot write run.npz" in answer.stderr
    assert any("not saved: cannot write run.npz" in warning for warning in record["warnings"])


def test_where_the_last_checkpoint_fails_the_run_is_told_all_the_same(run, monkeypatch):
    def full(*_):
        raise FileError("cannot write run.npz: No space left")

    monkeypatch.setattr(resuming, "save", full)
    with pytest.warns(resuming.CheckpointWarning, match="the run is not saved"):
        answer = run("--checkpoint", "run.npz", "--json")
    assert answer.exit_code == 2 and json.loads(answer.stdout)["quantities"], answer.output
    assert "not saved at its end: cannot write run.npz" in answer.stderr


def test_what_is_saved_nowhere_is_told(run):
    assert run("--save", "run.npz").stderr == ""
    said = run("--resume", "run.npz", "--particles", "6000")
    assert said.exit_code == 0 and "pass --checkpoint run.npz or --save FILE" in said.stderr
    assert run("--resume", "run.npz", "--particles", "6000", "--save", "more.npz").stderr == ""


def test_batches_are_said_as_in_python(run, tmp_path):
    assert run("--batches", "5e1", "--save", "run.npz").exit_code == 0
    assert len(tp.load(tmp_path / "run.npz").batches) == 50
    assert "--batches must be a whole number" in run("--batches", "3.5").stderr


def test_where_merged_runs_cannot_be_saved_nothing_is_read(call):
    answer = call("merge", "1.nc", "2.nc", "--out", "none/whole.nc")
    assert (
        answer.exit_code == 2
        and "--out none/whole.nc: the folder does not exist; make none first" in answer.output
    )


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


def test_a_missing_file_of_an_experiment_names_those_of_its_cases(run, call, tmp_path):
    assert run("--save", "run_1.npz").exit_code == 0
    assert "run_1.npz" in call("show", "run.npz").output
