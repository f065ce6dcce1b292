"""Compilation with an empty cache: CPU time, machine code and bytes per lane of each kind of scene.

    python -m tests.bench cold [SIM] [--json]

Each start is a new process with a copy of the library; a row has the first start and the next one, which loads.
"""

import os
import pickle
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path

import typer
from rich.table import Table

import transport
from tests.bench.prices import base_room, first_case, with_addition
from tests.bench.speed import disks_scene, glass_ball_scene, mesh_box_scene, slab_scene, thermal_box_scene
from transport.analysis.effects import CompileTime, Footprint, Treatment, footprint_of, treatment_of
from transport.cli.output import print_json, print_rich, table_of
from transport.statistics.notation import duration

LIBRARY = Path(transport.__file__).parent
CHILD = """
import pickle, sys
from transport.analysis.effects import compile_time_of
pickle.dump(compile_time_of(pickle.load(sys.stdin.buffer)), sys.stdout.buffer)
"""
HEADS = "kind of scene~", "passes>", "cold>", "from disk>", "machine code>", "bytes per lane>", "carried>"


def _room_with(name: str) -> Callable[[], Treatment]:
    return lambda: with_addition(name, base_room())


SCENES: dict[str, Callable[[], Treatment]] = {
    "coaxial disks, one flight": disks_scene,
    "closed box of diffuse walls": base_room,
    "... with clock, speeds, thermal walls": thermal_box_scene,
    "glass ball": glass_ball_scene,
    "mesh": mesh_box_scene,
    "slab of fog": slab_scene,
    "box of voxels in a room": _room_with("... of 8 x 8 x 8 voxels"),
    "point detector in fog": _room_with("... a point detector"),
    "camera, backward histories": _room_with("... a camera of 16 x 16 pixels"),
}


@contextmanager
def library_copy() -> Iterator[Path]:
    """Yield a temporary folder with a copy of the library's sources, without machine code."""
    with tempfile.TemporaryDirectory(prefix="transport-cold-") as folder:
        leave = shutil.ignore_patterns("__kernels__", "__pycache__")
        shutil.copytree(LIBRARY, Path(folder, LIBRARY.name), ignore=leave)
        yield Path(folder)


def compile_times_in(folder: Path, treatments: Iterable[Treatment]) -> Iterator[CompileTime]:
    """Yield the compile time of each treatment, in a new process each, with the library of `folder`."""
    environment = {**os.environ, "PYTHONPATH": str(folder), "PYTHONSAFEPATH": "1"}
    for treatment in treatments:
        sent = pickle.dumps(treatment)
        done = subprocess.run(
            [sys.executable, "-c", CHILD], input=sent, env=environment, capture_output=True, check=False
        )
        if done.returncode:
            raise RuntimeError(f"cold start: {done.stderr.decode(errors='replace')[-2000:]}")
        yield pickle.loads(done.stdout)


Start = tuple[CompileTime, CompileTime, Footprint]  # with an empty cache, the next one, and the memory


def start_of(treatment: Treatment) -> Start:
    """Return the first start of a treatment, the next start, and its footprint."""
    with library_copy() as folder:
        first, second = compile_times_in(folder, [treatment, treatment])
    return first, second, footprint_of(treatment.program)


def start_table(starts: Mapping[str, Start]) -> Table:
    """Return a table of the first start (empty cache) and the second start of each kind of scene."""
    rows = []
    for name, (first, second, footprint) in starts.items():
        times = duration(first.seconds), duration(second.seconds)
        sizes = f"{first.bytes / 2**20:.1f} MiB", str(footprint.touched), str(footprint.carried)
        rows.append([name, str(first.passes), *times, *sizes])
    return table_of(HEADS, rows)


def main(
    sim: str = typer.Argument("", help="Experiment [default: all kinds of scenes]"), json: bool = False
) -> None:
    """Start each kind of scene, or the first case of an experiment, with an empty cache."""
    treatments = {name: treatment_of(make()) for name, make in SCENES.items()}
    if sim:
        treatments = {sim: first_case(sim)}
    starts = {name: start_of(treatment) for name, treatment in treatments.items()}
    if json:
        keys = "first", "second", "memory"
        print_json({name: dict(zip(keys, map(asdict, start), strict=True)) for name, start in starts.items()})
    else:
        print_rich(start_table(starts))


if __name__ == "__main__":
    typer.run(main)
