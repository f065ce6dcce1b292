"""Digests of all public numbers of many runs: a change that should not move results is shown to move none.

    python -m tests.digests write FILE [--only TEXT]
    python -m tests.digests compare BEFORE AFTER [--only TEXT]      each a file of digests, or a checkout that is run first

Runs are the cases of all sims, each in every estimator that its scene allows and in the way that it chooses itself, all hard cases,
200 random scenes of the fuzz in every estimator, and the scenes that together call for every pass: by random and quasi-random numbers,
to a target error, and as paths.  A digest is of the bytes of value and error of one quantity, or of
one entry of the ledger; of a run that is refused, that it is.  Digests of two machines differ: machine code does.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

import transport as tp
from tests.fuzz.numbered import TURNS, world_of
from tests.fuzz.properties import quantities_of
from tests.plain_scenes import METHODS, SCENES
from transport.compile.methods import ESTIMATORS, SAMPLINGS, refusal
from transport.verification.experiment import cases_of, experiment, experiment_names
from transport.verification.hard.cases import cases_of as hard_cases

PARTICLES, WORLDS, SEED = 100_000, 200, 1
FEW_PARTICLES = 400  # of scenes that are run in many ways
WAYS = "estimator", "sampling", "batches", "tracking"  # what a sim may choose of its runs
REFUSED = {"refused": 1.0}
SHOWN = 40  # differences that are listed

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)


def digest_of(number: object) -> str:
    """Of the bytes of value and error of a quantity, or of a number."""
    parts = (number.value, number.error) if hasattr(number, "error") else (number,)
    arrays = [np.ascontiguousarray(part, dtype=float) for part in parts]
    sums = hashlib.sha256(repr([array.shape for array in arrays]).encode())
    for array in arrays:
        sums.update(array.tobytes())
    return sums.hexdigest()[:16]


def runs(worlds: int = WORLDS) -> Iterator[tuple[str, Callable[[], dict[str, object]]]]:
    """Yield the name of each run, and a function that makes it and returns its numbers; `worlds` random scenes."""
    for name in experiment_names():
        module = experiment(name)
        own = {key: value for key, value in getattr(module, "run", {}).items() if key in WAYS}
        for place, parameters in enumerate(cases_of(module, {})):
            scene, title = module.scene(**parameters), f"sim {name} {place}"
            if own.get("estimator") != "auto":
                yield f"{title}, its own way", lambda s=scene, o=own, m=module: _numbers(s, o, m.measure)
            yield from _by_estimator(title, scene, {})
    for case in hard_cases():
        yield f"hard {case.family}: {case.title}", lambda case=case: _of_hard_case(case)
    for number in range(worlds):
        world = world_of(number, SEED, TURNS[number % len(TURNS)])
        try:
            scene = world.scene()
        except tp.SceneError:
            yield f"world {number}", lambda: REFUSED
            continue
        options = {key: value for key, value in world.said(scene).items() if key in world.options}
        yield from _by_estimator(f"world {number}", scene, options)
    for name, make in SCENES.items():
        estimator = METHODS[name].estimator if name in METHODS else "analog"
        yield from _in_other_ways(f"scene {name}", make, estimator)


def _in_other_ways(
    title: str, make: Callable[[], tp.Scene], estimator: str
) -> Iterator[tuple[str, Callable]]:
    """A scene by random and quasi-random numbers, to the error of its first quantity, and as paths."""
    for sampling in SAMPLINGS:
        said = {"estimator": estimator, "sampling": sampling}
        yield f"{title}, {sampling}", lambda said=said: _numbers(make(), said, particles=FEW_PARTICLES)
        if title != "scene optics":  # its histories are long
            yield (
                f"{title}, {sampling}, to an error",
                lambda said=said: _numbers(
                    make(), said | {"error": _target(make())}, particles=FEW_PARTICLES
                ),
            )
    yield f"{title}, paths", lambda: _paths(make())


def _target(scene: tp.Scene) -> dict[str, float]:
    """A target for the first detector: 5 %."""
    for parts, quantity in (
        (scene.meters, "flux_in"),
        (scene.instruments, "radiance"),
        (scene.phase_spaces, "alive"),
    ):
        if parts:
            return {f"{parts[0].name}.{quantity}": 0.05}
    return {f"{(*scene.volumes, *scene.points)[0].name}.fluence_rate": 0.05}


def _paths(scene: tp.Scene) -> dict[str, object]:
    """The places of a hundred particles, their weights and lengths."""
    try:
        found = tp.tracks(scene, particles=100, seed=SEED)
    except tp.SceneError:
        return REFUSED
    return {name: value for name, value in vars(found).items() if isinstance(value, np.ndarray)}


def _by_estimator(title: str, scene: tp.Scene, options: dict) -> Iterator[tuple[str, Callable]]:
    for estimator in ESTIMATORS:
        if refusal(scene, estimator) is None:
            said = options | {"estimator": estimator}
            yield f"{title}, {estimator}", lambda said=said: _numbers(scene, said)


def _numbers(
    scene: tp.Scene, said: dict, measure: Callable[[object], dict] | None = None, particles: int = PARTICLES
) -> dict[str, object]:
    try:
        result = tp.simulate(scene, particles, seed=SEED, threads=2, progress=False, **said)
    except tp.SceneError:
        return REFUSED
    measured = {} if measure is None else {f"measured {k}": v for k, v in measure(result).items()}
    samples = {
        f"{shot.name}.{name}": getattr(result[shot.name], name)
        for shot in scene.snapshots
        for name in ("positions", "velocities", "weights", "histories")
    }
    return quantities_of(result) | measured | samples


def _of_hard_case(case: object) -> dict[str, object]:
    seen = case.run()
    return {"found": seen.found, "exact": seen.exact} | ({} if seen.naive is None else {"naive": seen.naive})


@app.command()
def write(path: Path, only: str = "") -> None:
    """Make all runs whose names hold a text, and write their digests as JSON."""
    found, begun = {}, time.perf_counter()
    warnings.simplefilter("ignore")
    for name, run in runs():
        if only in name:
            numbers = run()
            found[name] = {key: digest_of(number) for key, number in numbers.items()}
    path.write_text(json.dumps(found, indent=0))
    many = sum(map(len, found.values()))
    typer.echo(f"{many} digests of {len(found)} runs in {time.perf_counter() - begun:.0f} s")


@app.command()
def compare(
    before: Path,
    after: Path,
    only: Annotated[str, typer.Option(help="Of names of runs, the text that they hold.")] = "",
) -> None:
    """Compare the digests of two files or checkouts; ends with status 1 where any differs or is missing."""
    one, other = (_digests_of(path, only) for path in (before, after))
    differ = [
        f"{run}: {number}"
        for run in sorted(one.keys() | other.keys())
        for number in sorted(one.get(run, {}).keys() | other.get(run, {}).keys())
        if one.get(run, {}).get(number) != other.get(run, {}).get(number)
    ]
    for line in differ[:SHOWN]:
        typer.echo(line)
    typer.echo(f"{len(differ)} of {sum(map(len, one.values()))} digests of {len(one)} runs differ")
    raise typer.Exit(bool(differ) or not one)


def _digests_of(path: Path, only: str) -> dict[str, dict[str, str]]:
    """Those of a file, or those that a checkout writes."""
    if path.is_file():
        found = json.loads(path.read_text())
        return {name: numbers for name, numbers in found.items() if only in name}
    with tempfile.TemporaryDirectory() as folder:
        # A copy has sims and viz within the package, so that none of an editable install is found.
        copy, file = Path(folder, "copy"), Path(folder, "digests.json")
        for name in ("transport", "sims", "viz", "tests"):
            shutil.copytree(
                path / name, copy / name, ignore=shutil.ignore_patterns("__kernels__", "__pycache__")
            )
        for name in ("sims", "viz"):
            shutil.copytree(copy / name, copy / "transport" / name)
        command = [sys.executable, "-m", "tests.digests", "write", str(file), "--only", only]
        subprocess.run(command, cwd=copy, env={**os.environ, "PYTHONPATH": str(copy)}, check=True)
        return json.loads(file.read_text())


if __name__ == "__main__":
    app()
