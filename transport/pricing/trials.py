"""Runs of growing size by one method: value, claimed error and duration of each.

Sizes grow by factors of four, so that runs are spread evenly over the logarithm of time. Small runs are
repeated more often than large ones, so that their root mean square errors are well known at little cost.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from transport.results.estimates import Estimate, EstimateArray

SMALLEST, FACTOR, LARGEST = 1 << 12, 4, 1 << 34  # histories of the first runs, growth factor, most histories
FEWEST, MOST = 8, 32  # number of runs of the largest size, and most of the small ones
OF_LARGEST = 16.0  # total time of all runs over the time of the largest run
KEYS = 1 << 20  # number of seeds reserved for one method


@dataclass(frozen=True)
class Trial:
    """One run.

    value, error: of all bins, (n,) [unit];  seconds: CPU time of all threads [s];  wall: elapsed time [s].
    """

    particles: int
    value: np.ndarray
    error: np.ndarray
    seconds: float
    wall: float


@dataclass(frozen=True)
class Trials:
    """All runs of one method, by rising size. preparation: time [s] to compile or load its kernels."""

    rungs: tuple[tuple[Trial, ...], ...]
    preparation: float

    @property
    def all(self) -> list[Trial]:
        """All runs."""
        return [trial for rung in self.rungs for trial in rung]


Run = Callable[[int, int], tuple[int, "Estimate | EstimateArray", float]]


def trials_of(
    run: Run,
    seconds: float,
    seed: int = 0,
    cpu: Callable = time.process_time,
    clock: Callable = time.perf_counter,
) -> Trials:
    """Run trials that take about `seconds` of CPU time in total, without preparation and a first run.

    run: (particles, seed) -> (particles done, estimate, seconds of preparation).
    """
    keys = iter(range(seed, seed + KEYS))

    def trial(particles: int) -> Trial:
        begun, shown = cpu(), clock()
        done, estimate, _ = run(particles, next(keys))
        spent, passed = cpu() - begun, clock() - shown
        value, error = (np.ravel(np.asarray(part, float)) for part in (estimate.value, estimate.error))
        return Trial(done, value, error, spent, passed)

    # Compile with a first run that is not timed.
    preparation = run(SMALLEST, next(keys))[2]
    # Grow the runs as long as the time allows, then repeat the small ones more often.
    rungs = [[trial(SMALLEST)]]
    while _has_time_for_more(rungs[-1][0], seconds):
        rungs.append([trial(FACTOR * rungs[-1][0].particles)])
    for place, rung in enumerate(reversed(rungs)):
        rung += [trial(rung[0].particles) for _ in range(min(MOST, FEWEST << place) - 1)]
    return Trials(tuple(map(tuple, rungs)), preparation)


def _has_time_for_more(last: Trial, seconds: float) -> bool:
    """Whether runs of the next size, which take at most `FACTOR` times as long, fit into the time."""
    return FACTOR * max(last.seconds, 1e-9) * OF_LARGEST <= seconds and last.particles < LARGEST
