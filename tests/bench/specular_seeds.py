"""Claimed against true errors where light comes by mirrors, glass and lenses: each scene, "backward" and "expected", over 200 seeds.

    python -m tests.bench.specular_seeds [SCENE ...] [--seeds 200] [--particles 65536] [--workers 2]

`off` is the mean of all runs less the reference, over the error of both together; `spread` the standard deviation over
the claimed error, whose own error is 1/sqrt(2 seeds); `within` how many runs lie within 95 % of Student's t of the
reference. What is doubtful in each of the first three runs of "expected" is left out.
"""

from __future__ import annotations

import math
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import typer

import transport as tp
from tests.focusing_scenes import SCENES, VALUES
from tests.specular_scenes import CASES
from transport.statistics.batches import student_quantile

FIRST = 1000  # seed


def scene_of(name: str) -> tuple[tp.Scene, float, float]:
    """The scene, its irradiance at "m", and the error of that."""
    if name in SCENES:
        return SCENES[name](), *VALUES[name]()
    case = CASES[name]
    return case.scene(case.radii[0]), *case.value(case.radii[0])


def line_of(name: str, estimator: str, seeds: int, particles: int) -> str:
    """What all seeds say of one way to estimate."""
    scene, exact, error = scene_of(name)
    found: list[tp.Estimate] = []
    verdicts: Counter[str] = Counter()
    options = {"estimator": estimator, "threads": 1, "progress": False}
    for seed in range(FIRST, FIRST + seeds):
        try:
            found.append(tp.simulate(scene, particles, seed=seed, **options)["m"].irradiance)
        except tp.SceneError as refusal:
            return "refused: " + str(refusal)[:100]
        verdicts[found[-1].verdict] += 1
        if estimator == "expected" and verdicts["doubtful"] == 3 == len(found):
            return "doubtful"
    values, errors = (np.array([getattr(each, what) for each in found]) for what in ("value", "error"))
    limit = student_quantile(0.975, found[0].dof)
    off = (values.mean() - exact) / math.hypot(values.std(ddof=1) / math.sqrt(seeds), error)
    spread = values.std(ddof=1) / math.sqrt(np.mean(errors**2))
    within = np.mean(np.abs(values - exact) < limit * np.hypot(errors, error))
    counts = ", ".join(f"{many} {verdict}" for verdict, many in sorted(verdicts.items()))
    return f"off {off:+.2f}  spread {spread:.3f}  within {within:.3f}  error {values.std() / exact:.1e}  {counts}"


def main(
    scenes: list[str] = typer.Argument(None),  # noqa: B008
    seeds: int = 200,
    particles: int = 65536,
    workers: int = 2,
) -> None:
    """Print a line for each scene and estimator."""
    pairs = [(name, how) for name in scenes or [*SCENES, *CASES] for how in ("backward", "expected")]
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        lines = pool.map(line_of, *zip(*pairs, strict=True), [seeds] * len(pairs), [particles] * len(pairs))
        for (name, how), line in zip(pairs, lines, strict=True):
            print(f"{name:22s} {how:9s} {line}", flush=True)


if __name__ == "__main__":
    typer.run(main)
