"""Files of runs: damaged ones are errors, other programs read them with units, and all data come back."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import subprocess
import sys
import zipfile

import numpy as np
import pytest

import transport as tp
from tests.own_experiments import ROOT
from tests.same_batches import assert_same
from tests.test_saved import SMALL, killed_at, refusal, run
from transport.io.atomic import FileError, atomic_write
from transport.io.columns import describe_columns, read_values
from transport.statistics.packed import Packed, pack


@pytest.mark.filterwarnings("error::pytest.PytestUnraisableExceptionWarning")
def test_what_is_no_whole_file_is_refused(tmp_path):
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
    told = refusal(tp.simulate(SMALL, particles=100).save, tmp_path / "run.nc")
    assert "pip install '.[files]'" in told and "run.npz" in told


def test_other_programs_read_what_it_found_out(tmp_path):
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


def test_files_tell_other_programs_units_and_whether_they_are_complete(tmp_path, monkeypatch):
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
        meter = tp.Detector(tp.Disk(center=(0, 0, 1), radius=1), name)
        scene = dataclasses.replace(SMALL, detectors=meter)
        result = tp.simulate(scene, particles=100)
        for suffix in (".nc", ".npz"):
            assert repr(name) in refusal(result.save, tmp_path / f"run{suffix}")
        assert repr(name) in refusal(tp.simulate, scene, particles=10**12, checkpoint=tmp_path / "run.nc")
    assert not os.listdir(tmp_path)


def test_a_full_disk_leaves_the_old_file_and_stops_no_run(tmp_path):
    """In a process with a file-size limit; HDF5 would crash it if it saw the error."""
    for suffix in (".nc", ".npz"):
        path = tmp_path / f"run{suffix}"
        tp.simulate(SMALL, particles=4_000).save(path)
        old = path.read_bytes()
        code = f"""
import resource, warnings
import transport as tp
from tests.test_saved import SMALL
from transport.io.atomic import FileError
tp.simulate(SMALL, particles=1000)
resource.setrlimit(resource.RLIMIT_FSIZE, ({len(old) // 3}, resource.RLIM_INFINITY))
result = tp.simulate(SMALL, particles=5000)
for _ in range(3):
    try:
        result.save({str(path)!r})
    except FileError as error:
        print(error)
with warnings.catch_warnings(record=True) as told:
    result = tp.simulate(SMALL, particles=9000, resume={str(path)!r}, checkpoint={str(path)!r}, every=1e-9)
print(len(told), result.particles, result.warnings[-1])
"""
        done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        first, *_, second = done.stdout.splitlines()
        assert "File too large" in first and "old file is unchanged" in first
        assert " 9000 " in second and "not saved at its end" in second and not second.startswith("0")
        assert path.read_bytes() == old and os.listdir(tmp_path) == [path.name]
        path.unlink()


def test_what_a_killed_process_left_aside_is_removed(tmp_path):
    path = tmp_path / "run.npz"
    child = "import os, sys, pathlib\nfrom transport.io.atomic import atomic_write as written_whole\n"
    child += "with written_whole(pathlib.Path(sys.argv[1])): os._exit(0)"
    subprocess.run([sys.executable, "-c", child, path], cwd=ROOT, check=True)
    assert len(os.listdir(tmp_path)) == 1
    with atomic_write(path) as file:
        file.write(b"whole")
    assert os.listdir(tmp_path) == ["run.npz"]


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


def test_names_that_a_file_cannot_have_are_kept_apart(tmp_path):
    meters = [
        tp.Detector(tp.Disk(center=(0, 0, z), radius=1), name)
        for z, name in ((1, "a/b"), (2, "a|b"), (3, "run"), (4, "absorbed"))
    ]
    result = tp.simulate(dataclasses.replace(SMALL, detectors=meters), particles=1_000)
    result.save(tmp_path / "run.nc")
    xarray = pytest.importorskip("xarray")
    for group, name in (("a|b", "a/b"), ("a|b_", "a|b"), ("run_", "run"), ("absorbed_", "absorbed")):
        with xarray.open_dataset(tmp_path / "run.nc", engine="h5netcdf", group=group) as found:
            assert found.attrs["name"] == name and float(found.flux_out) == result[name].flux_out.value
    assert_same(tp.load(tmp_path / "run.nc").batches, result.batches)
