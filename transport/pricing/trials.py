"""Runs of growing size by one way of estimating: what each gave, what error it claimed, and how long it took.

Sizes grow by fours, so that runs are spread evenly over the logarithm of time; the smaller ones are repeated more
often, so that their root mean square errors are known as well for less than what the largest cost.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from transport.results.estimates import Estimate, EstimateArray

SMALLEST, FACTOR, LARGEST = 1 << 12, 4, 1 << 34  # histories of the first runs, and how they grow
FEWEST, MOST = 8, 32  # runs of the largest size and of the small ones
OF_LARGEST = 16.0  # times its time that all runs together take
KEYS = 1 << 20  # random numbers' keys that one way may use


@dataclass(frozen=True)
class Trial:
    """One run.  value, error: of all bins, (n,) [unit];  seconds: of CPU, all threads together;  wall: by the clock [s]."""

    particles: int
    value: np.ndarray
    error: np.ndarray
    seconds: float
    wall: float


@dataclass(frozen=True)
class Trials:
    """All runs of one way, by rising size.  preparation: [s] to compile or load its passes."""

    rungs: tuple[tuple[Trial, ...], ...]
    preparation: float

    @property
    def all(self) -> list[Trial]:
        return [trial for rung in self.rungs for trial in rung]


Run = Callable[[int, int], tuple[int, "Estimate | EstimateArray", float]]


def trials_of(
    run: Run,
    seconds: float,
    seed: int = 0,
    cpu: Callable = time.process_time,
    clock: Callable = time.perf_counter,
) -> Trials:
    """Runs that take about so many seconds of CPU together, besides preparation and a first look.

    run: (particles, seed) -> (particles done, estimate, seconds of preparation).
    """
    keys = iter(range(seed, seed + KEYS))

    def trial(particles: int) -> Trial:
        begun, shown = cpu(), clock()
        done, estimate, _ = run(particles, next(keys))
        spent, passed = cpu() - begun, clock() - shown
        value, error = (np.ravel(np.asarray(part, float)) for part in (estimate.value, estimate.error))
        return Trial(done, value, error, spent, passed)

    preparation = run(SMALLEST, next(keys))[2]
    rungs = [[trial(SMALLEST)]]
    while _has_time_for_more(rungs[-1][0], seconds):
        rungs.append([trial(FACTOR * rungs[-1][0].particles)])
    for place, rung in enumerate(reversed(rungs)):
        rung += [trial(rung[0].particles) for _ in range(min(MOST, FEWEST << place) - 1)]
    return Trials(tuple(map(tuple, rungs)), preparation)


def _has_time_for_more(last: Trial, seconds: float) -> bool:
    """Whether runs of the next size fit into the time; these take no more than `FACTOR` times as long."""
    return FACTOR * max(last.seconds, 1e-9) * OF_LARGEST <= seconds and last.particles < LARGEST
