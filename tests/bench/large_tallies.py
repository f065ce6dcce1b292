"""How much memory a run of 1e7 bins takes, on 2 threads, and all that is done with it: each case in a process of its own.

Run, every quantity with its error, the report, a file, the file read again: the most that was resident in each step, beside
what the check before the run foretold.

python -m tests.bench.large_tallies [case ...] [--threads 2]
"""

import contextlib
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from unittest import mock

import typer

import transport as tp
from tests.bench.frame import memory
from transport.run import run
from transport.run.memory import check_memory, memory_need

SIDE, EDGE = 3162, 215  # bins along an axis: 1e7 in a plane, and in space


def wall(material: object, particles: int, **bins: object) -> tuple[tp.Scene, dict]:
    """Two faces of a slit, of which one is measured."""
    face = tp.Rectangle(center=(0, 0, 0.01), normal=(0, 0, -1), width=1, height=1)
    return tp.Scene(
        tp.Source(tp.Rectangle(width=1, height=1), tp.Lambertian(radiance=1.0)),
        surfaces=tp.Surface(face, material, name="wall"),
        detectors=tp.Detector("wall", name="image", **bins),
    ), {"particles": particles}


def places() -> dict[str, object]:
    return {"positions": tp.Positions(u=SIDE, v=SIDE)}


def fog(**limits: object) -> tuple[tp.Scene, dict]:
    """A box that shines everywhere, in fog; its cells are looked at."""
    return tp.Scene(
        tp.Source(tp.Box(size=(1, 1, 1)), tp.Isotropic(power=1.0)),
        medium=tp.Medium(scattering=1.0, absorption=1.0),
        detectors=tp.VolumeDetector(tp.Box(size=(1, 1, 1)), name="cells", cells=(EDGE, EDGE, EDGE)),
    ), limits


def view() -> tuple[tp.Scene, dict]:
    """A camera before a lit wall."""
    face = tp.Rectangle(center=(0, 0, 1), normal=(0, 0, -1), width=4, height=4)
    return tp.Scene(
        tp.Source(tp.Rectangle(center=(0, 0, -1), width=4, height=4), tp.Lambertian(radiance=1.0)),
        surfaces=tp.Surface(face, tp.Diffuse(albedo=0.5), name="wall"),
        detectors=tp.Camera(
            name="view",
            position=(0, 0, 0),
            look_at=(0, 0, 1),
            up=(0, 1, 0),
            field_of_view=0.9,
            pixels=(SIDE, SIDE),
        ),
    ), {"particles": 100_000_000}


def gas() -> tuple[tp.Scene, dict]:
    """A free gas, its phase space and a large sample of it."""
    edges = tuple((k / SIDE - 0.5) for k in range(SIDE + 1))
    speeds = tuple(8 * edge for edge in edges)
    maxwellian = tp.Maxwellian(sigma=1.0, mass=3.0)
    return tp.Scene(
        tp.Source(tp.Box(size=1.0), tp.Gas(number=1.0, speed=maxwellian)),
        detectors=tp.PhaseSpace(x=edges, vx=speeds, time=0.01, name="phase space"),
        duration=0.02,
    ), {"particles": 40_000_000}


def sample() -> tuple[tp.Scene, dict]:
    return tp.Scene(
        tp.Source(tp.Box(size=1.0), tp.Gas(number=1.0, speed=tp.Maxwellian(sigma=1.0, mass=3.0))),
        detectors=tp.Snapshot(time=0.01, particles=10_000_000, name="sample"),
        duration=0.02,
    ), {"particles": 40_000_000}


DIRECTIONS = {
    "positions": tp.Positions(u=316, v=316),
    "directions": tp.Directions(mu=10, phi=10),
}
CASES = {
    "black wall": lambda: wall(tp.Black(), 100_000_000, **places()),
    "grey wall": lambda: wall(tp.Diffuse(albedo=0.5), 100_000_000, **places()),
    "place and direction": lambda: wall(tp.Black(), 100_000_000, **DIRECTIONS),
    "cells": lambda: fog(particles=3_000_000),
    "camera": view,
    "phase space": gas,
    "sample": sample,
    "for an error": lambda: (wall(tp.Black(), 0, **places())[0], {"particles": 100_000_000, "error": {"image.flux_in": 1e-9}, "estimator": "analog"}),
}  # fmt: skip


class Steps:
    """The most that was resident in each step [bytes]."""

    most = 0

    @contextlib.contextmanager
    def step(self, name: str) -> Iterator[None]:
        Path("/proc/self/clear_refs").write_text("5")  # the peak begins anew
        begun = time.perf_counter()
        yield
        seconds, most = time.perf_counter() - begun, memory("VmHWM")
        self.most = max(self.most, most)
        print(f"  {name:20} {seconds:8.1f} s {most / 1e9:8.2f} GB", flush=True)


def foretold(*arguments: object) -> None:
    """The check before a run, and what it foretells, with what is resident by then."""
    check_memory(*arguments)
    most = memory_need(*arguments).total + memory()
    print(f"  {'foretold of the run':20} {'':10} {most / 1e9:8.2f} GB", flush=True)


def child(case: str, threads: int) -> None:
    """One case, told as a line of JSON."""
    scene, limits = CASES[case]()
    steps = Steps()
    with steps.step("run"), mock.patch.object(run, "check_memory", foretold):
        result = tp.simulate(scene, seed=1, threads=threads, progress=False, **limits)
    (name,) = [look.name for look in scene.detectors]
    reading = result[name]
    for quantity in getattr(reading, "known", ()):
        with contextlib.suppress(tp.SceneError), steps.step(quantity):
            read = getattr(reading, quantity)
            _ = read.value, read.error
            del read
    with steps.step("report"):
        result.report()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.nc"
        with steps.step("save"):
            result.save(path)
        size = path.stat().st_size
        del result, reading
        with steps.step("load"):
            result = tp.load(path)
    print(f"{len(result.run)} batches, file of {size / 1e6:.0f} MB; in all {steps.most / 1e9:.2f} GB")


def main(
    cases: list[str] = typer.Argument(None, help=", ".join(CASES)),  # noqa: B008
    threads: int = 2,
    is_child: bool = typer.Option(False, "--child", hidden=True),
) -> None:
    """Run each case in a process of its own."""
    if is_child:
        child(cases[0], threads)
        return
    if unknown := set(cases or ()) - set(CASES):
        raise typer.BadParameter(f"no case {', '.join(sorted(unknown))}; there are {', '.join(CASES)}")
    command = [sys.executable, "-m", "tests.bench.large_tallies", "--child", "--threads", str(threads)]
    for case in cases or CASES:
        print(case, flush=True)
        subprocess.run([*command, case], check=True)


if __name__ == "__main__":
    typer.run(main)
