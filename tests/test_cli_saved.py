"""The command line on saved runs: saved, in parts, gone on with, merged and shown, as in Python."""

import json

import pytest

import transport as tp
from tests.test_saved import SMALL, assert_same
from transport import experiment
from transport.saved.whole import FileError


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
    assert f"done by: transport {tp.__version__}" in shown and "flux_in" in shown
    record = json.loads(call("show", "whole.npz", "--json").output)
    flux = next(row for row in record["quantities"] if row["name"] == "meter.flux_in")
    assert flux["value"] == whole["meter"].flux_in.value and record["seeds"] == [4]


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
        (("--save", "run.txt"), "ends in .nc or .npz"),
        (("--checkpoint", "none/run.nc"), "make none first"),
        (("--every", "5"), "say --checkpoint FILE as well"),
    ):
        answer = run(*options)
        assert answer.exit_code == 2 and said in answer.output, answer.output
    assert "no file none.nc" in call("show", "none.nc").output


def test_a_file_that_cannot_be_saved_is_refused_before_the_run(run, monkeypatch):
    monkeypatch.setattr(experiment, "simulate", None)
    for file, said in (("run.txt", "ends in .nc or .npz"), ("none/run.npz", "make none first")):
        answer = run("--save", file)
        assert answer.exit_code == 2 and said in answer.output, answer.output


def test_where_the_disk_is_full_in_the_end_the_run_is_told_all_the_same(run, monkeypatch):
    def full(*_):
        raise FileError("cannot write run.npz: No space left")

    monkeypatch.setattr(tp.Result, "save", full)
    answer = run("--save", "run.npz", "--json")
    record = json.loads(answer.output)
    assert answer.exit_code == 2 and record["quantities"], answer.output
    assert any("not saved: cannot write run.npz" in warning for warning in record["warnings"])
