"""Tallies of very many bins: packed and read part by part they are bit for bit what plain ones are, and what does not fit is refused.

Here pages and parts are made so small that ordinary scenes have many of them.
"""

import subprocess
import sys
import tracemalloc

import numpy as np
import pytest

import transport as tp
from transport.compile.compiler import compile_scene
from transport.results import batches, footprint
from transport.run import executor, memory
from transport.run.schedules import batches_in, schedule_for
from transport.run.settings import checked_limits
from transport.statistics import chunked, packed
from transport.statistics.chunked import ChunkedReplicates
from transport.statistics.packed import Packed


def room(**bins):
    """A grey room with a detector with bins of all kinds, and a wall with moments; particles fly at two speeds."""
    wall = tp.Rectangle(center=(0, 0, 1), normal=(0, 0, -1), width=2, height=2)
    gas = tp.Gas(density=1.0, speed=tp.SpeedTable((1.0, 2.0), (0.5, 0.5)), mass=1e-26)
    all_kinds = {"directions": tp.Directions(**bins), "times": 3, "speeds": (0.5, 1.5, 2.5), "moments": True}
    return tp.Scene(
        tp.Source(tp.Box(size=(2, 2, 2)), gas),
        surfaces=tp.Surface(tp.Box(size=(2, 2, 2)), tp.Diffuse(albedo=0.5), name="room"),
        detectors=[
            tp.Detector(
                tp.Rectangle(width=1, height=1), name="bins", positions=tp.Positions(u=5, v=6), **all_kinds
            ),
            tp.Detector(wall, name="places", positions=tp.Positions(u=9, v=11)),
        ],
        duration=1.0,
    )


def fog() -> tp.Scene:
    """A lamp in fog with a void; cells with bins of direction, and without."""
    void = tp.Surface(tp.Box(center=(1, 0, 0), size=(1, 2, 2)), tp.Transparent(), inside=tp.Vacuum())
    cells = {"cells": (5, 6, 7), "directions": tp.Directions.sphere(mu=3, phi=4)}
    return tp.Scene(
        tp.Source(tp.Point(), tp.Isotropic(power=1.0)),
        surfaces=void,
        medium=tp.Medium(scattering=1.0, absorption=0.5),
        detectors=[
            tp.VolumeDetector(tp.Box(size=(3, 3, 3)), name="by direction", **cells),
            tp.VolumeDetector(tp.Box(size=(2, 2, 2)), name="cells", cells=(9, 8, 7)),
        ],
    )


def view(instrument: tp.Camera | tp.EnvironmentMap) -> tp.Scene:
    """A camera that looks at a lit wall."""
    wall = tp.Surface(tp.Rectangle(center=(0, 0, 1), normal=(0, 0, -1), width=4, height=4), tp.Diffuse(0.5))
    lamp = tp.Surface(tp.Rectangle(center=(0, 0, -1), width=4, height=4), tp.Black(), name="lamp")
    return tp.Scene(tp.Source("lamp", tp.Lambertian(radiance=1.0)), [lamp, wall], instrument)


def camera(*pixels: int) -> tp.Camera:
    return tp.Camera(
        name="view", position=(0, 0, 0), look_at=(0, 0, 1), up=(0, 1, 0), field_of_view=0.9, pixels=pixels
    )


def gas(time: object, *bins: int, moments: bool = False) -> tp.Scene:
    """A free gas in phase space."""
    axes = {
        name: tuple(np.linspace(-half, half, many + 1))
        for name, half, many in zip(("x", "vx"), (0.4, 2.0), bins, strict=False)
    }
    cloud = tp.Source(tp.Box(size=1.0), tp.Gas(number=1.0, speed=tp.Maxwellian(sigma=1.0, mass=3.0)))
    look = tp.PhaseSpace(**axes, time=time, name="phase space", moments=moments)
    return tp.Scene(cloud, detectors=look, duration=0.2)


SCENES = {
    "bins of theta": room(theta=3, phi=4),
    "bins of mu": room(mu=4),
    "cells": fog(),
    "camera": view(camera(17, 13)),
    "map": view(tp.EnvironmentMap(name="map", position=(0.1, 0, 0), theta=17, phi=19)),
    "phase space": gas((0.05, 0.1), 17, 19, moments=True),
}
TOTALS = ("map.fluence_rate",)  # of all bins, added in another order


def simulate(scene, particles=4000, batches=8):
    return tp.simulate(scene, particles, seed=1, batches=batches, progress=False)


def _from_batches(quantity: tp.Estimate | tp.EstimateArray) -> tuple:
    """Value, error, reason and degrees of freedom from the batches alone: neighbours are pooled part by part."""
    found = quantity._replicates
    return quantity.value, found.error, quantity.reason, found.dof


@pytest.fixture
def small_parts(monkeypatch):
    """A function after whose call columns are packed, in small pages and mapped to files, and readings made of small parts."""

    def begin():
        for module, name, value in (
            (chunked, "MIN_MAPPED_BYTES", 1),
            *((module, "MAX_UNPACKED_ROWS", 0) for module in (packed, batches, executor)),
            (packed, "PAGE", 64),
            (packed, "CHUNK_ROWS", 256),
            (chunked, "MAX_ARRAY_SIZE", 300),
            (chunked, "MAX_CHUNK_SIZE", 500),
        ):
            monkeypatch.setattr(module, name, value)

    return begin


def warnings_of(result) -> list[str]:
    """All but those of bins that have too few neighbours: each part knows those of its own bins alone."""
    return [warning for warning in result.warnings if "neighbouring bins" not in warning]


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_readings_of_packed_rows_made_part_by_part_are_bit_for_bit_those_of_plain_ones(name, small_parts):
    plain = simulate(SCENES[name])
    read = {f"{look}.{q}": each for look in plain for q, each in plain[look].quantities.items()}
    whole = {title: _from_batches(each) for title, each in read.items()}
    warnings = warnings_of(plain)
    small_parts()
    large = simulate(SCENES[name])
    assert isinstance(large.batches[0].weights, Packed)
    in_parts = 0
    for title, numbers in whole.items():
        found = large.quantity(title)
        in_parts += isinstance(found._replicates, ChunkedReplicates) and len(found._replicates.boxes) > 4
        if title in TOTALS:
            np.testing.assert_allclose((found.value, found.error), numbers[:2], rtol=1e-9)
            continue
        for number, like in zip(_from_batches(found), numbers, strict=True):
            np.testing.assert_array_equal(number, like, err_msg=title)
    assert in_parts >= (2 if "view" in plain or "map" in plain else 4) and warnings_of(large) == warnings


ARITHMETIC = {
    "twice": lambda r: 2.0 * r["bins"].radiance,
    "an array": lambda r: r["bins"].radiance * np.arange(1.0, 5.0),
    "a total": lambda r: r["bins"].radiance / r["places"].flux_in,
    "a ratio": lambda r: r["bins"].radiance / r["bins"].radiance_out,
    "a power": lambda r: r["bins"].radiance ** 0.5,
    "an element": lambda r: r["bins"].radiance[1, 0, 2, 3, -1],
    "a slice": lambda r: r["bins"].radiance[1:, :, 2, 1:4],
    "doubt": lambda r: r["bins"].radiance.unless(r["bins"].counts.value < 3),
    "a sum": lambda r: r["bins"].radiance.sum("u"),
    "all": lambda r: r["places"].irradiance.sum(),
    "a mean": lambda r: r["bins"].radiance.mean(("time", "mu")),
}


@pytest.mark.slow
def test_arithmetic_and_merging_of_parts_are_those_of_the_whole(small_parts):
    plain = simulate(room(mu=4))
    whole = {name: _from_batches(make(plain))[:2] for name, make in ARITHMETIC.items()}
    merged = plain.batches[0].merged(plain.batches[1], 0)
    small_parts()
    large = simulate(room(mu=4))
    for name, make in ARITHMETIC.items():
        rounding = 1e-12 * (name in ("a sum", "all", "a mean"))
        np.testing.assert_allclose(_from_batches(make(large))[:2], whole[name], rtol=rounding, err_msg=name)
    np.testing.assert_array_equal(large["bins"].radiance.values, plain["bins"].radiance.values)
    other = large.batches[0].merged(large.batches[1], 0)
    for name in ("weights", "counts", "slants", "moments"):
        np.testing.assert_array_equal(getattr(other, name)[:], getattr(merged, name))


def wall_of(bins: int, material=None) -> tp.Scene:
    wall = tp.Rectangle(center=(0, 0, 1), normal=(0, 0, -1), width=1, height=1)
    return tp.Scene(
        tp.Source(tp.Rectangle(width=1, height=1), tp.Lambertian(radiance=1.0)),
        surfaces=tp.Surface(wall, tp.Black() if material is None else material, name="wall"),
        detectors=tp.Detector("wall", name="image", positions=tp.Positions(u=bins, v=bins)),
    )


GREY = tp.Diffuse(albedo=0.5)


def test_batches_are_fewer_where_bins_are_very_many(monkeypatch):
    def schedule(bins, batches=None, material=None):
        scene = wall_of(bins, material)
        return schedule_for(checked_limits(scene, 1_100_000_000, None, None, batches), compile_scene(scene))

    assert schedule(900).count == 32 and schedule(900).max_stored == 128
    black, grey = schedule(3162), schedule(3162, material=GREY)
    assert (black.count, grey.count, schedule(3162, batches=40).count) == (12, 8, 40)
    leg = black.next_leg([])
    assert (batches_in(leg), black.together, black.max_stored) == (72, 6, 12)
    monkeypatch.setattr(footprint, "MAX_KEPT_BYTES", 6e6)
    result = tp.simulate(wall_of(100), 1000, seed=1, progress=False)
    assert "batches: fewer than the usual 32, because the sums of one take up to 0.48 MB" in result.report()
    assert len(result.run) == 12


def test_sums_that_do_not_fit_into_memory_are_refused_before_the_run(monkeypatch):
    monkeypatch.setattr(memory, "available_memory", lambda: 3e9)
    with pytest.raises(tp.SceneError) as refused:
        tp.simulate(wall_of(3162, tp.Diffuse(albedo=0.5)), 1000, threads=4, batches=40, progress=False)
    assert str(refused.value) == (
        "simulate: the sums of this scene take up to 5.25 GB, 701 MB on each of 4 threads and 61 MB in each of 40 batches,"
        " and 3 GB of memory are left; use fewer bins (detector 'image' has 9_998_245), or threads=1, or fewer batches"
        " than 40"
    )
    monkeypatch.setattr(memory, "free_disk_bytes", lambda: 0)  # for what would lie aside
    with pytest.raises(tp.SceneError, match=r"17.8 GB, 987 MB on each of 4 threads and 347 MB in each of 40"):
        tp.simulate(wall_of(3162, tp.Diffuse(albedo=0.5)), 1000, threads=4, batches=40, progress=False)
    monkeypatch.setattr(memory, "available_memory", lambda: pytest.fail("asked for a run that needs nothing"))
    tp.simulate(wall_of(100), 1000, progress=False)


def test_a_client_and_its_workers_need_what_each_of_them_takes(monkeypatch):
    plan = compile_scene(wall_of(3162, GREY))
    schedule = schedule_for(checked_limits(plan.scene, 1000, None, None, 40), plan)
    both, client = memory.memory_need(plan, schedule, 2), memory.memory_need(plan, schedule, 0)
    assert (client.threads, client.batches, client.kept) == (0, 40, both.kept)
    assert client.total < both.total and client.in_transit > 2 * client.kept
    assert memory.memory_need(plan, schedule, 2, saved=30).batches == 10  # the others are here already
    monkeypatch.setattr(memory, "available_memory", lambda: 2e9)
    memory.check_worker_memory(plan, 1)
    words = r"a worker of the cluster: .* 2.67 GB, 1.33 GB on each of 2 threads, and 2 GB"
    with pytest.raises(tp.SceneError, match=words):
        memory.check_worker_memory(plan, 2)
    words = r"3.14 GB, 61 MB in each of 40 batches and 695 MB in transit from"
    with pytest.raises(tp.SceneError, match=words):
        memory.check_memory(plan, schedule, 0)
    memory.check_memory(plan, schedule, 0, saved=30)


@pytest.mark.slow
def test_values_and_errors_of_a_million_bins_take_few_bytes_a_bin():
    result = simulate(view(camera(1000, 1000)), 20_000, 32)
    for quantity in ("radiance", "counts"):
        tracemalloc.start()
        read = getattr(result._read(result.scene.detectors[0]), quantity)
        assert read.value.size == read.error.size == 1e6
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert most < 80e6  # of 32 batches alone there would be 256


def test_available_memory_is_the_least_that_the_system_and_the_control_groups_leave(tmp_path, monkeypatch):
    proc, groups = tmp_path / "proc", tmp_path / "groups"
    (proc / "self").mkdir(parents=True)
    (groups / "a/b").mkdir(parents=True)
    (proc / "meminfo").write_text("MemTotal: 9000 kB\nMemAvailable:    8000 kB\n")
    (proc / "self/cgroup").write_text("0::/a/b\n")
    monkeypatch.setattr(chunked, "PROC_FOLDER", proc)
    monkeypatch.setattr(chunked, "CGROUP_FOLDER", groups)
    assert chunked.available_memory() == 8000 * 1024
    for where, most in (("a/b", "max"), ("a", "5000000")):
        (groups / where / "memory.max").write_text(f"{most}\n")
        (groups / where / "memory.current").write_text("3000000\n")
        (groups / where / "memory.stat").write_text("anon 5\ninactive_file 1000000\n")
    assert chunked.available_memory() == 3_000_000
    (proc / "meminfo").unlink()
    (groups / "a/memory.max").unlink()
    assert chunked.available_memory() is None


CHILD = """
import transport as tp
from tests.results.test_large_tallies import wall_of
result = tp.simulate(wall_of(3162), 1_000_000, seed=1, threads=2, batches=4, progress=False)
read, total = result["image"].irradiance, result["image"].flux_in.value
assert abs(read.value.mean() - total) < 1e-9 * total and (read.error > 0).any()
print(next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM")))
"""


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_ten_million_bins_are_run_and_read_within_two_gigabytes():
    told = subprocess.run([sys.executable, "-c", CHILD], capture_output=True, text=True, check=True).stdout
    assert 1024 * int(told) < 1.2e9
