"""Forecast of a run for an error: the speed of its batches so far, and how many are still to come."""

from __future__ import annotations

import math

import numpy as np

from transport.results.record import Forecast
from transport.run.stopping import Look
from transport.statistics.convergence import TimeModel, fit_time

# relative error below which it predicts how many particles a smaller error takes
MAX_FORECAST_ERROR = 0.1
# [s] least time of a batch that measures the time per particle: in smaller ones lanes idle and latency
# dominates
MIN_BATCH_SECONDS = 1e-3
MIN_PROGRESS = 0.1  # share of the planned particles from which on progress itself measures the speed


class Forecaster:
    """Forecaster of the remaining time, by a latency per batch and a time per particle.

    Both are fitted to legs of different batch sizes. Latencies of threads add up (they are Python's), times
    of particles run in parallel. What the last leg took beyond that is attributed to handing over batches, at
    a constant cost per batch.
    """

    def __init__(self, threads: int) -> None:
        self.threads = threads
        self.median_batches: list[np.ndarray] = []  # particles and seconds of the median batch of each leg
        self.handover_seconds = 0.0  # [s] per batch of the last leg, beyond the fitted time
        self.forecast: Forecast | None = None  # the latest
        self.particles = 0  # at the time of the forecast

    def add_leg(self, batches: list[tuple[int, float]], seconds: float) -> None:
        """Add a finished leg: particles and seconds per batch, and its total wall time [s]."""
        if not batches:  # all of its batches were in the saved run
            return
        self.median_batches.append(np.median(batches, axis=0))
        histories = sum(size for size, _ in batches)
        rest = seconds - self._fitted_seconds(histories, len(batches))
        self.handover_seconds = max(0.0, rest) / len(batches)

    def plan(self, elapsed: float, particles: int, histories: float, batches: int) -> None:
        """Forecast the end of the run, where so many particles in so many batches are still to come.

        elapsed: seconds so far; particles: so far; histories, batches: still to come.
        """
        if not self.median_batches:
            return
        seconds = elapsed + self._fitted_seconds(histories, batches) + self.handover_seconds * batches
        total = particles + histories
        total = round(total) if total < math.inf else total
        self.forecast, self.particles = Forecast(elapsed, float(seconds), total), particles

    def end(self, elapsed: float, particles: int) -> float:
        """Return the total time of the run [s], as expected at this point; infinite without a forecast."""
        plan = self.forecast
        if plan is None or plan.particles == math.inf:
            return math.inf
        done = (particles - self.particles) / (plan.particles - self.particles)
        if done > MIN_PROGRESS:
            return plan.after + (elapsed - plan.after) / min(done, 1.0)
        return max(plan.seconds, elapsed)

    def is_clear(self, look: Look) -> bool:
        """Return whether the error and the time per particle are known well enough for a forecast."""
        is_timed = bool(self.median_batches) and self.median_batches[-1][1] > MIN_BATCH_SECONDS
        return bool(is_timed and look.worst.relative <= MAX_FORECAST_ERROR)

    def _fitted_seconds(self, histories: float, batches: int) -> float:
        """Return the fitted time of so many particles in so many batches [s]."""
        pace: TimeModel = fit_time(*np.transpose(self.median_batches))
        return pace.latency * batches + pace.per_particle * histories / self.threads
