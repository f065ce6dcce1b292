"""What a run for an error will take: how fast its batches were so far, and how many are still to come."""

from __future__ import annotations

import math

import numpy as np

from transport.pricing.slopes import Pace, pace_of
from transport.results.record import Forecast
from transport.runs.stopping import Look

# relative error below which it is known well enough to tell by it how many histories another takes
KNOWN = 0.1
# [s], a batch that tells the time of its histories: in smaller ones lanes idle, and latencies count
LONG = 1e-3
FAR = 0.1  # of the way to the end, from where on the way itself tells the speed


class Outlook:
    """How long batches take: a latency and a time for each history, told from legs of unlike batches.

    Latencies of threads follow one another (they are Python's), histories do not; how much longer the last leg took than
    so explained goes to handing its batches over, and is taken to stay the same for each.
    """

    def __init__(self, threads: int) -> None:
        self.threads = threads
        self.typical: list[np.ndarray] = []  # histories and seconds of the median batch of each leg
        self.handing = 0.0  # [s] of the last leg beyond those explained, a batch
        self.forecast: Forecast | None = None  # the latest
        self.particles = 0  # when it was made

    def add_leg(self, batches: list[tuple[int, float]], seconds: float) -> None:
        """A leg is done: the histories and seconds of each of its batches, and the seconds that it took in all."""
        if not batches:  # all of them were saved before
            return
        self.typical.append(np.median(batches, axis=0))
        histories = sum(size for size, _ in batches)
        self.handing = max(0.0, seconds - self._explained(histories, len(batches))) / len(batches)

    def plan(self, elapsed: float, particles: int, histories: float, batches: int) -> None:
        """So many histories in so many batches are still to come, after so many seconds and particles."""
        if not self.typical:
            return
        seconds = elapsed + self._explained(histories, batches) + self.handing * batches
        self.forecast, self.particles = (
            Forecast(elapsed, float(seconds), _whole(particles + histories)),
            particles,
        )

    def end(self, elapsed: float, particles: int) -> float:
        """When the run will be over [s], now that it is so far; infinite where nothing is planned."""
        plan = self.forecast
        if plan is None or plan.particles == math.inf:
            return math.inf
        done = (particles - self.particles) / (plan.particles - self.particles)
        if done > FAR:
            return plan.after + (elapsed - plan.after) / min(done, 1.0)
        return max(plan.seconds, elapsed)

    def is_clear(self, look: Look) -> bool:
        """Whether the error and the time of a history are known well enough for a forecast."""
        is_timed = bool(self.typical) and self.typical[-1][1] > LONG
        return bool(is_timed and look.worst.relative <= KNOWN)

    def _explained(self, histories: float, batches: int) -> float:
        pace: Pace = pace_of(*np.transpose(self.typical))
        return pace.latency * batches + pace.per_particle * histories / self.threads


def _whole(number: float) -> int | float:
    return round(number) if number < math.inf else number
