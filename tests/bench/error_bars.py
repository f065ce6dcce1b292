"""Claimed against true errors of every way to estimate on every cost scene, over 2000 seeds: z against Student's t.

    python -m tests.bench.error_bars [SIM ...] [--seeds 2000] [--spread 0.02]

A run has so many histories that its mean is about normal: relative errors of a run below SPREAD, as a first run finds;
of few scores a mean is lopsided, and z with it, by half its skewness: then a smaller spread tells.  A way that would
take more than MOST histories a batch is left out, and said to be.  `off` is the mean of all runs less the exact value,
in its own standard errors: no skewness touches that, so that it tells a bias.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from importlib import import_module
from multiprocessing import get_context

import numpy as np
import typer

import transport as tp
from tests.agreement import assert_z_spread
from transport.compile.methods import Method, methods_for
from transport.statistics.batches import normal_score
from transport.verification.experiment import cases_of

SIMS = ("cost_disks", "cost_speck", "cost_enclosure", "cost_fog", "cost_glint", "cost_caustic", "cost_mirror")
SEEDS, SPREAD, LEAST, MOST = 2000, 0.05, 64, 1 << 15
FIRST = 1 << 16  # histories of the run that chooses how many a batch has


@dataclass(frozen=True)
class Way:
    """A sim's case, one of its quantities, and how it is estimated."""

    sim: str
    case: int
    quantity: str
    method: Method

    def __str__(self) -> str:
        return f"{self.sim}[{self.case}] {self.quantity}: {self.method.title}"

    def run(self, particles: int, seed: int, batches: int | None = None) -> tuple[tp.Estimate, float]:
        """What a run of one thread gives, and the exact value."""
        module = import_module(f"transport.sims.{self.sim}")
        parameters = cases_of(module, {})[self.case]
        method = {"estimator": self.method.estimator, "sampling": self.method.sampling}
        options = {"threads": 1, "progress": False} | method
        result = tp.simulate(module.scene(**parameters), particles, seed=seed, batches=batches, **options)
        return module.measure(result)[self.quantity], module.exact(**parameters)[self.quantity]


def ways(sims: tuple[str, ...] = SIMS) -> Iterator[Way]:
    """All that the cost scenes allow."""
    for sim in sims:
        module = import_module(f"transport.sims.{sim}")
        for case, parameters in enumerate(cases_of(module, {})):
            quantities = module.exact(**parameters)
            for method in methods_for(module.scene(**parameters)):
                for quantity in quantities:
                    yield Way(sim, case, quantity, method)


def histories_a_batch(way: Way, spread: float = SPREAD) -> int | str:
    """How many histories make a batch about normal; or why there are no z to judge."""
    estimate, exact = way.run(FIRST, seed=1)
    if estimate.value == 0:
        return "nothing scores"
    if not estimate.error > 0:
        off = abs(estimate.value / exact - 1)
        return f"no noise, {off:.1e} off the exact value"
    size = max(LEAST, math.ceil((estimate.relative_error / spread) ** 2 * FIRST / _batches(way)))
    size = 1 << (size - 1).bit_length()
    return size if size <= MOST else f"{size} histories a batch"


def scores(way: Way, seeds: int = SEEDS) -> tuple[np.ndarray, float] | str:
    """(value - exact) / error of each seed, and its degrees of freedom; or why there are none."""
    found = runs_of(way, seeds)
    if isinstance(found, str):
        return found
    return _z_of(found), _batches(way) - 1


def _z_of(found: list[tuple[tp.Estimate, float]]) -> np.ndarray:
    return np.array([(estimate.value - exact) / estimate.error for estimate, exact in found])


def runs_of(way: Way, seeds: int = SEEDS, spread: float = SPREAD) -> list[tuple[tp.Estimate, float]] | str:
    """The estimate and the exact value of each seed; or why there are none."""
    size, batches = histories_a_batch(way, spread), _batches(way)
    return (
        size if isinstance(size, str) else [way.run(batches * size, seed, batches) for seed in range(seeds)]
    )


def _batches(way: Way) -> int:
    return min(16, way.method.default_batches)


def _told(way: Way, seeds: int, spread: float) -> tuple[str, str]:
    found = runs_of(way, seeds, spread)
    if isinstance(found, str):
        return str(way), found
    values, exact = np.array([estimate.value for estimate, _ in found]), found[0][1]
    off = (values.mean() - exact) / values.std(ddof=1) * math.sqrt(seeds)
    z, dof = _z_of(found), _batches(way) - 1
    normal = normal_score(z, dof)
    told = f"off {off:+.2f} mean {normal.mean():+.3f} spread {normal.std():.3f} within 95 % {np.mean(np.abs(normal) < 1.96):.4f}"
    try:
        assert_z_spread(z, dof, 1e-4)
    except AssertionError as error:
        return str(way), f"{told}  REJECTED: {error}"
    return str(way), told


def main(
    sims: list[str] = typer.Argument(None),  # noqa: B008
    seeds: int = SEEDS,
    spread: float = SPREAD,
    workers: int = 2,
) -> None:
    """Print a line a way."""
    chosen = list(ways(tuple(sims) if sims else SIMS))
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        for name, told in pool.map(_told, chosen, [seeds] * len(chosen), [spread] * len(chosen)):
            print(f"{name:60s} {told}", flush=True)


if __name__ == "__main__":
    typer.run(main)
