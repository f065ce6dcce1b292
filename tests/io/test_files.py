"""Files of runs: each is one run's own, damaged ones are errors, other programs read them with units, and all data come back."""

from __future__ import annotations

import dataclasses
import errno
import json
import math
import os
import pickle
import signal
import subprocess
import sys
import zipfile
from types import SimpleNamespace

import numpy as np
import pytest

import transport as tp
from tests.fuzz.properties import quantities_of
from tests.io.test_saved import killed_at, refusal, run, small
from tests.plain_scenes import METHODS, SCENES, SMALL
from tests.processes import ROOT, python
from tests.same_batches import assert_same
from transport.io import atomic, resuming
from transport.io.atomic import FileError, atomic_write
from transport.io.columns import describe_columns, read_values
from transport.statistics.packed import Packed, pack

LOCKS = pytest.mark.skipif(atomic.fcntl is None, reason="the system has no such locks")
HOLDER = """
import os, pathlib, sys, time
from transport.io.atomic import locked as held
with held(pathlib.Path(sys.argv[1])):
    print("held", flush=True)
    {then}
"""


def disks(*names, **bins):
    """The small scene with horizontal disks for detectors."""
    looks = [
        tp.Detector(tp.Disk(center=(0, 0, z), radius=1), name, **bins) for z, name in enumerate(names, 1)
    ]
    return dataclasses.replace(SMALL, detectors=looks)


# ---- what a file holds ----


@pytest.mark.parametrize("name", ["pile", pytest.param("vessel", marks=pytest.mark.slow), "backward view"])
def test_a_result_can_be_pickled_after_its_numbers_were_read(name):
    """By detectors, volume detectors, phase space, snapshots, cameras and points: another process reads the same."""
    estimator = METHODS[name].estimator if name in METHODS else "analog"
    result = tp.simulate(
        SCENES[name](), particles=400, estimator=estimator, seed=1, threads=1, progress=False
    )
    read = quantities_of(result)
    again = quantities_of(pickle.loads(pickle.dumps(result)))
    assert read.keys() == again.keys()
    for each, number in read.items():
        np.testing.assert_array_equal(again[each].value, number.value)
        np.testing.assert_array_equal(again[each].error, number.error)
    for detector in result:
        assert pickle.loads(pickle.dumps(result[detector])).name == detector


@pytest.mark.filterwarnings("error::pytest.PytestUnraisableExceptionWarning")
def test_a_file_that_is_damaged_or_of_another_version_is_refused(tmp_path):
    """And no half-opened one is left that cannot close."""
    result = tp.simulate(SMALL, particles=4_000)
    assert "ends in .nc or .npz" in refusal(result.save, tmp_path / "run.json")
    assert "no file" in refusal(tp.load, tmp_path / "none.nc")
    assert "make the folder" in refusal(result.save, tmp_path / "none" / "run.nc")
    for suffix in (".nc", ".npz"):
        path = tmp_path / f"run{suffix}"
        result.save(path)
        content = path.read_bytes()
        rng = np.random.default_rng(3)
        for length in rng.integers(0, len(content) - 1, 10):
            path.write_bytes(content[:length])
            assert "not a complete file" in refusal(tp.load, path)
        for place, bit in zip(rng.integers(0, len(content), 40), rng.integers(0, 8, 40), strict=True):
            path.write_bytes(content[:place] + bytes([content[place] ^ 1 << bit]) + content[place + 1 :])
            try:
                again = tp.load(path)
            except FileError:
                continue
            assert suffix == ".npz"  # of which a bit may be of no account: of a sealed file none is
            assert_same(again.batches, result.batches)
            assert (again.scene, again.cost, again.seed) == (result.scene, result.cost, result.seed)
        path.write_bytes(content + b"more")
        if suffix == ".nc":
            assert "checksum is missing: it was cut off, or rewritten" in refusal(tp.load, path)
    assert issubclass(FileError, OSError)
    path = tmp_path / "newer.npz"
    result.save(path)
    for change, told in (
        ({"version": 99}, "is newer than"),
        ({"format": "x"}, "not the file of a run"),
        ({"rows": {}}, "lays out"),
    ):
        with zipfile.ZipFile(path) as archive:
            entries = {name: archive.read(name) for name in archive.namelist()}
        entries["run.json"] = json.dumps(json.loads(entries["run.json"]) | change)
        with zipfile.ZipFile(tmp_path / "changed.npz", "w") as archive:
            for name, entry in entries.items():
                archive.writestr(name, entry)
        assert told in refusal(tp.load, tmp_path / "changed.npz")


def test_without_its_package_netcdf_is_refused_with_the_other_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "h5netcdf", None)
    told = refusal(small(100).save, tmp_path / "run.nc")
    assert "pip install '.[files]'" in told and "run.npz" in told


@pytest.mark.slow
def test_other_programs_read_the_numbers_of_a_file(tmp_path):
    xarray = pytest.importorskip("xarray")
    result, path = run("random"), tmp_path / "run.nc"
    result.save(path)
    radiance = result["-z"].radiance
    with xarray.open_dataset(path, engine="h5netcdf", group="-z") as found:
        assert found.radiance.dims == radiance.dims and found.radiance.units == str(radiance.unit)
        np.testing.assert_array_equal(found.radiance, radiance.value)
        np.testing.assert_array_equal(found.radiance_error, radiance.error)
        np.testing.assert_array_equal(found.mu_high, radiance.coords["mu"][1:])
        assert {"mu_low", "mu_high", "phi_low"} <= set(found.coords)
    with xarray.open_dataset(path, engine="h5netcdf") as ledger:
        assert float(ledger.absorbed) == result.ledger["absorbed"].value
    with xarray.open_dataset(path, engine="h5netcdf", group="run") as saved:
        assert tp.Scene.from_json(saved.scene.item()) == result.scene
    result.save(tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as found:
        np.testing.assert_array_equal(found["-z/radiance_error"], radiance.error)


@pytest.mark.slow
def test_other_programs_read_units_and_whether_a_file_is_complete(tmp_path, monkeypatch):
    xarray, path = pytest.importorskip("xarray"), tmp_path / "run.nc"
    ball, binned = tp.Sphere(center=(0, 0, 2), radius=0.5), tp.Positions(u=2, v=3)
    meters = [
        tp.Detector(tp.Disk(center=(0, 0, 1), radius=1), "disk", positions=binned),
        tp.Detector(ball, "ball", positions=binned),
        tp.Detector(tp.Rectangle(center=(0, 0, 3), width=1, height=1), "plate", positions=binned),
    ]
    result = tp.simulate(dataclasses.replace(SMALL, detectors=meters), particles=1_000)
    result._warnings.append("it rained")
    result.save(path)
    for name, units in (("disk", ("m", "rad")), ("ball", ("rad", "rad")), ("plate", ("m", "m"))):
        with xarray.open_dataset(path, engine="h5netcdf", group=name) as found:
            assert (found.u.units, found.v_low.units) == units
        array = (2.0 * result[name].irradiance[:, :2]).to_xarray()
        assert (array.u.units, array.v_high.units) == units
    with xarray.open_dataset(path, engine="h5netcdf") as found:
        assert found.completeness == "complete" and "it rained" in found.warnings
    result.is_complete = False
    result.save(path)
    with xarray.open_dataset(path, engine="h5netcdf") as found:
        assert found.completeness == "incomplete: interrupted"
    path.unlink()
    killed_at(2, path, monkeypatch, "random")
    with xarray.open_dataset(path, engine="h5netcdf") as found:
        assert "a checkpoint" in found.completeness and not found.variables


def test_names_that_no_file_can_have_are_refused_before_the_run(tmp_path):
    for name in ("a\0b", "a\ud800b"):
        scene = disks(name)
        result = tp.simulate(scene, particles=100)
        for suffix in (".nc", ".npz"):
            assert repr(name) in refusal(result.save, tmp_path / f"run{suffix}")
        assert repr(name) in refusal(tp.simulate, scene, particles=10**12, checkpoint=tmp_path / "run.nc")
    assert not os.listdir(tmp_path)


@pytest.mark.slow
def test_names_that_a_file_cannot_have_are_kept_apart(tmp_path):
    result, xarray = tp.simulate(disks("a/b", "a|b", "run", "absorbed"), 1_000), pytest.importorskip("xarray")
    result.save(tmp_path / "run.nc")
    for group, name in (("a|b", "a/b"), ("a|b_", "a|b"), ("run_", "run"), ("absorbed_", "absorbed")):
        with xarray.open_dataset(tmp_path / "run.nc", engine="h5netcdf", group=group) as found:
            assert found.attrs["name"] == name and float(found.flux_out) == result[name].flux_out.value
    assert_same(tp.load(tmp_path / "run.nc").batches, result.batches)


def test_any_kind_of_field_comes_back_as_it_was():
    """What a Batch may come to hold: see saved.columns."""
    rng, columns = np.random.default_rng(2), {}
    rows = [
        {
            "ragged": rng.random((n, 3)), "alike": rng.random(4).astype(np.float32), "bool": rng.random(n) > 0.5,
            "mixed": rng.integers(0, 9, n).astype(np.uint8 if n % 2 else np.int64), "kinds": 2 if n % 2 else -0.0,
            "whole": 2**64 - 1 - n, "empty": np.zeros((0, 2)), "nested": {"a": n, "b": math.inf}, "keys": {f"k{n % 2}": 1.5},
            "packed": pack(lambda first, past, n=n: np.arange(first, past) % (3 * n + 2) * 0.5, 5000, 0.5),
        }
        for n in (3, 1, 0)
    ]  # fmt: skip
    described = json.loads(json.dumps(describe_columns("", rows, columns)))
    whole = {name: np.concatenate([p for p in column.pieces]) for name, column in columns.items()}

    def pieces(name, lengths):
        return iter(np.split(whole[name], np.cumsum(lengths)[:-1]))

    again = read_values(described, "", len(rows), pieces, {"Packed": Packed})
    for row, like in zip(rows, again, strict=True):
        for name, value in row.items():
            assert type(value) is type(like[name]), name
            if isinstance(value, np.ndarray | Packed):
                array, other = np.asarray(value), np.asarray(like[name])
                assert (array.dtype, array.shape) == (other.dtype, other.shape), name
                assert array.tobytes() == other.tobytes(), name
            else:
                assert repr(value) == repr(like[name])


# ---- how it is written ----

FULL_DISK = """
import resource, sys, warnings
import transport as tp
from tests.plain_scenes import SMALL
from transport.io.atomic import FileError
path, limit = sys.argv[1:]
tp.simulate(SMALL, particles=1000)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(limit), resource.RLIM_INFINITY))
result = tp.simulate(SMALL, particles=5000)
for _ in range(3):
    try:
        result.save(path)
    except FileError as error:
        print(error)
with warnings.catch_warnings(record=True) as told:
    result = tp.simulate(SMALL, particles=9000, resume=path, checkpoint=path, every=1e-9)
print(len(told), result.particles, result.warnings[-1])
"""


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".nc", pytest.param(".npz", marks=pytest.mark.slow)])
def test_a_full_disk_leaves_the_old_file_and_stops_no_run(tmp_path, suffix):
    """In a process with a file-size limit; HDF5 would crash it if it saw the error."""
    path = tmp_path / f"run{suffix}"
    small(4_000).save(path)
    old = path.read_bytes()
    first, *_, second = python("-c", FULL_DISK, path, len(old) // 3).stdout.splitlines()
    assert "File too large" in first and "old file is unchanged" in first
    assert " 9000 " in second and "not saved at its end" in second and not second.startswith("0")
    assert path.read_bytes() == old and os.listdir(tmp_path) == [path.name]


@pytest.mark.slow
def test_files_that_a_killed_process_left_are_removed(tmp_path):
    path = tmp_path / "run.npz"
    child = "import os, sys, pathlib\nfrom transport.io.atomic import atomic_write as written_whole\n"
    child += "with written_whole(pathlib.Path(sys.argv[1])): os._exit(0)"
    python("-c", child, path)
    assert len(os.listdir(tmp_path)) == 1
    with atomic_write(path) as file:
        file.write(b"whole")
    assert os.listdir(tmp_path) == ["run.npz"]


def test_a_file_is_on_the_disk_before_it_has_its_name_and_then_its_name_is(tmp_path, monkeypatch):
    done = []
    for name in ("fsync", "replace"):
        act = getattr(os, name)
        monkeypatch.setattr(atomic.os, name, lambda *a, act=act, name=name: (done.append(name), act(*a))[1])
    with atomic.atomic_write(tmp_path / "run.npz") as file:
        file.write(b"all")
    assert done == ["fsync", "replace", "fsync"]


def test_at_most_a_tenth_of_the_time_goes_into_writing(tmp_path, monkeypatch):
    clock = [0.0]
    monkeypatch.setattr(resuming, "time", SimpleNamespace(perf_counter=lambda: clock[0]))
    monkeypatch.setattr(resuming, "save", lambda *_: clock.__setitem__(0, clock[0] + 30.0))
    keep = resuming.Checkpoints(tmp_path / "run.npz", 60.0, SMALL)
    clock[0] = 61.0
    keep.save_if_due(SimpleNamespace(batches=[1], now=lambda: None, result=lambda is_complete: None))
    assert keep.due - clock[0] >= 9 * 30.0


def test_a_name_that_cannot_be_written_is_refused_before_the_run(tmp_path):
    told = refusal(small, checkpoint=tmp_path / ("x" * 247 + ".npz"))
    assert "cannot be written: File name too long; name another file or folder" in told
    assert os.listdir(tmp_path) == []


def test_the_file_is_where_it_was_named_wherever_the_script_goes(tmp_path, monkeypatch):
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path)
    keep = resuming.Checkpoints("run.npz", 60.0, SMALL)
    monkeypatch.chdir("elsewhere")
    keep.end(small())
    assert (tmp_path / "run.npz").exists() and os.listdir() == []


# ---- one run a file ----


def test_no_other_run_is_written_over(tmp_path):
    a, b, c = (tmp_path / f"{name}.npz" for name in "abc")
    first, other = small(checkpoint=a), small(checkpoint=b, seed=1)
    for resume in (a, first, None):
        told = refusal(small, 2_000, checkpoint=b, resume=resume)
        assert f"checkpoint must be a new file, but {b} exists; pass resume='{b}'" in told
    assert tp.load(b).seed == other.seed
    assert small(2_000, checkpoint=tmp_path / "." / "a.npz", resume=a).particles == 2_000
    assert small(3_000, checkpoint=c, resume=a).particles == 3_000
    assert (tp.load(a).particles, tp.load(c).particles) == (2_000, 3_000)
    b.unlink()
    b.symlink_to(a)
    assert small(4_000, checkpoint=b, resume=a).particles == 4_000
    assert b.is_symlink() and tp.load(a).particles == 4_000


@pytest.mark.slow
def test_a_second_run_in_the_same_file_is_refused_until_the_first_is_gone(tmp_path):
    """Also where that was killed, and what it held the file by was left."""
    path = tmp_path / "run.npz"
    command = [sys.executable, "-c", HOLDER.format(then="sys.stdin.read()"), str(path)]
    with subprocess.Popen(command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        other.stdout.readline()
        told = refusal(small, checkpoint=path, resume=path)
        other.kill()
    assert f"checkpoint {path} is in use by another run, process {other.pid} on" in told
    assert "name another file" in told and len(os.listdir(tmp_path)) == 1
    assert small(checkpoint=path, resume=path).particles == 1_000
    assert os.listdir(tmp_path) == ["run.npz"]


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system cannot fork")
def test_a_child_does_not_keep_what_its_parent_held(tmp_path):
    """Though it live on: the lock goes with the process that took it."""
    path = tmp_path / "run.npz"
    forks = "os.fork() or (print('child', flush=True), time.sleep(60)); os._exit(0)"
    command = [sys.executable, "-c", HOLDER.format(then=forks), str(path)]
    other = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, start_new_session=True)
    try:
        assert [other.stdout.readline() for _ in range(2)] == [b"held\n", b"child\n"]  # which is under way
        assert other.wait(20) == 0
        assert small(checkpoint=path, resume=path).particles == 1_000
    finally:
        os.killpg(other.pid, signal.SIGKILL)


def test_two_links_to_a_file_are_one(tmp_path):
    a, b = (tmp_path / f"{name}.npz" for name in "ab")
    for link in (a, b):
        link.symlink_to(tmp_path / "run.npz")
    with atomic.locked(a), pytest.raises(FileError, match="in use by another run"), atomic.locked(b):
        pass


def test_the_lock_is_gone_before_another_may_take_it(tmp_path, monkeypatch):
    close, there = os.close, []
    with atomic.locked(tmp_path / "run.npz"):
        monkeypatch.setattr(
            atomic.os, "close", lambda file: (there.extend(os.listdir(tmp_path)), close(file))
        )
    assert there == []


@LOCKS
def test_without_locks_nobody_is_refused(tmp_path, monkeypatch):
    def unsupported(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(atomic.fcntl, "flock", unsupported)
    small(checkpoint=tmp_path / "a.npz")
    monkeypatch.setattr(atomic, "fcntl", None)
    small(checkpoint=tmp_path / "b.npz")
    assert sorted(os.listdir(tmp_path)) == ["a.npz", "b.npz"]


@LOCKS
def test_a_lock_that_its_last_holder_removes_meanwhile_is_none(tmp_path, monkeypatch):
    """Else a third run would make another one, and both have the file to themselves."""
    path, flock, times = tmp_path / "run.npz", atomic.fcntl.flock, []

    def late(*what):
        flock(*what)
        times.append(1)
        if len(times) == 1:
            (tmp_path / ".run.npz.lock").unlink()

    monkeypatch.setattr(atomic.fcntl, "flock", late)
    with atomic.locked(path):
        assert os.listdir(tmp_path) == [".run.npz.lock"]
        assert "in use" in refusal(atomic.locked(path).__enter__)
    assert os.listdir(tmp_path) == []
