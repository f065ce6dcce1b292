"""Scenes of all experiments, of the tests and of the fuzz, written and read: the same bit by bit, and so are their results.

    python -m tests.bench.written [--worlds 300] [--runs 30]

Worlds are those of the fuzz, by number, as they are made for its seed 1; the first of `runs` of each kind also run.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count, islice

import typer

import transport as tp
from tests.fuzz.numbered import TURNS, world_of
from tests.round_trips import (
    assert_compiled_alike,
    assert_runs_alike,
    read_again,
    scenes_of_sims,
    scenes_of_tests,
)
from transport.compile.methods import Method, methods_for
from transport.run.programs import plan_for

PARTICLES = 2000


def scenes_of_fuzz(seed: int = 1) -> Iterator[tuple[str, tp.Scene]]:
    """Worlds that are no refusals, endlessly."""
    for number in count():
        try:
            yield f"world {number}", world_of(number, seed, TURNS[number % len(TURNS)]).scene()
        except tp.SceneError:
            continue


@dataclass
class Census:
    """What came of the scenes of one kind.  seconds: of writing and reading them;  length: of their texts."""

    read: int = 0
    compiled: int = 0
    ran: int = 0
    length: int = 0
    seconds: float = 0.0

    def __str__(self) -> str:
        each = f"{self.length / self.read / 1e3:.1f} kB and {self.seconds / self.read * 1e3:.1f} ms each"
        alike = f"{self.compiled} compiled alike, {self.ran} run, the same bit by bit"
        return f"{self.read} scenes read back bit by bit, {each} to write and read; {alike}"

    def take(self, scene: tp.Scene, runs: int) -> None:
        """Write and read it, compile both, and run both if there are runs left."""
        begun = time.perf_counter()
        text = scene.to_json()
        tp.Scene.from_json(text)
        self.seconds += time.perf_counter() - begun
        again = read_again(scene)
        self.read, self.length = self.read + 1, self.length + len(text)
        method = way_of(scene)
        if method is None:
            return
        assert_compiled_alike(scene, again, method)
        self.compiled += 1
        if self.ran < runs:
            how = {"estimator": method.estimator, "sampling": method.sampling}
            assert_runs_alike(scene, again, particles=PARTICLES, batches=4, **how)
            self.ran += 1


def way_of(scene: tp.Scene) -> Method | None:
    """The simplest way to estimate it; None for a scene that no way is for."""
    for method in methods_for(scene):
        try:
            plan_for(scene, None, method)
        except tp.SceneError:
            continue
        return method
    return None


def main(worlds: int = 300, runs: int = 30) -> None:
    """One line for each kind of scene; an error where one is not the same."""
    warnings.simplefilter("ignore", tp.MeshWarning)
    kinds = {"sims": scenes_of_sims(), "tests": scenes_of_tests(), "fuzz": islice(scenes_of_fuzz(), worlds)}
    for kind, scenes in kinds.items():
        census = Census()
        for name, scene in scenes:
            try:
                census.take(scene, runs)
            except Exception as error:
                raise SystemExit(f"{name}: {type(error).__name__}: {error}") from error
        print(f"{kind}: {census}", flush=True)


if __name__ == "__main__":
    typer.run(main)
