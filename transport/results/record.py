"""The record of a run: its plan, the sums of its batches, its cost; diagnostics and reports read it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from transport.compile.plan import Plan
from transport.results.batches import Batch
from transport.results.choice import Choice
from transport.scene.tracking import Tracking
from transport.statistics.findings import DEFAULT_ALLOWED_BOUND
from transport.statistics.replicates import Batches

RANDOM_SLOPE = -0.5  # logarithmic slope of the error of independent histories against time


@dataclass(frozen=True)
class Forecast:
    """Forecast of a pilot, made `after` seconds: seconds and particles of the whole run."""

    after: float
    seconds: float
    particles: int | float  # infinite where unknown


@dataclass(frozen=True)
class Cost:
    """The cost of a run.

    Parameters
    ----------
    seconds : float
        Wall-clock time [s], without `preparation`.
    preparation : float
        Time to compile or load the compiled passes [s].
    particles, crossings, collisions : int
        Numbers of followed particles and their events, including rounds that a later round replaced.
    threads : int
        Number of threads at a time.
    workers : int, default 0
        Number of workers to which the threads belong, on a cluster; 0 for a run in this process.
    slopes : mapping of str to float
        Slopes of the requested errors against time on a logarithmic scale, where they were measured.
    forecast : Forecast or None
        Forecast from a pilot of the run, if there was one.

    Examples
    --------
    >>> from transport.results.record import Cost
    >>> cost = Cost(seconds=2.0, preparation=0.0, particles=1_000_000, crossings=3_000_000, threads=2)
    >>> cost.particles_per_second, cost.next_digit
    (500000.0, 200.0)
    """

    seconds: float
    preparation: float
    particles: int
    crossings: int
    threads: int
    collisions: int = 0
    workers: int = 0
    slopes: Mapping[str, float] = field(default_factory=dict)
    forecast: Forecast | None = None

    @property
    def particles_per_second(self) -> float:
        """Particles per second of wall-clock time [s^-1].

        Returns
        -------
        float
        """
        return self.particles / self.seconds

    @property
    def next_digit(self) -> float:
        """Seconds for a tenth of the error, by 100 times the particles, or fewer if the slope is steeper.

        Returns
        -------
        float
            [s]
        """
        return self.seconds * 10 ** (-1 / max(self.slopes.values(), default=RANDOM_SLOPE))


def total_cost(costs: Sequence[Cost]) -> Cost:
    """Return the cost of several runs; errors fall with the least steep of their slopes, if all are known."""
    if len(costs) == 1:
        return costs[0]
    names = ("seconds", "preparation", "particles", "crossings", "collisions")
    sums = {name: sum(getattr(cost, name) for cost in costs) for name in names}
    slopes = [pair for cost in costs for pair in sorted(cost.slopes.items())]
    known = {name: max(each for other, each in slopes if other == name) for name, _ in slopes}
    return Cost(
        threads=max(cost.threads for cost in costs),
        workers=max(cost.workers for cost in costs),
        slopes=known if all(cost.slopes for cost in costs) else {},
        **sums,
    )


class Record:
    """The plan, sums and cost of a run; `Result` adds quantities with units and errors."""

    cost: Cost | Any  # None of a Record that no run has made

    def __init__(
        self,
        plan: Plan,
        batches: list[Batch],
        seed: int,
        cost: Cost | None,
        is_complete: bool,
        warnings: list[str],
        asked: Tracking | None = None,
        choice: Choice | None = None,
        state: Any = None,
        wanted: Mapping[str, float] | None = None,
    ):
        """Collect the batches of a run.

        asked: tracking that the user passed, or None;  choice: how pilots chose the estimator, or None;
        state: from which the run can continue;  wanted: requested relative errors, None for those of the
        state.
        """
        self.wanted, self.plan, self.seed, self.cost, self.is_complete = wanted, plan, seed, cost, is_complete
        self.scene = plan.scene if plan.adjoint is None else plan.adjoint.scene
        self.batches, self.asked, self.choice, self.state = batches, asked, choice, state
        is_even = plan.method.sampling != "random"
        self.run = Batches(np.array([batch.histories for batch in batches]), is_even)
        self._warnings = list(warnings)
        self._readings: dict[str, Any] = {}

    @property
    def particles(self) -> int:
        """Number of histories of the run.

        Returns
        -------
        int
        """
        return self.run.histories

    def allowed_of(self, name: str) -> float:
        """Requested relative error of a detector, up to which a bound is accepted; 1 % by default."""
        of_state = {} if self.state is None else self.state.limits.error
        asked = of_state if self.wanted is None else self.wanted
        errors = [error for quantity, error in asked.items() if quantity.partition(".")[0] == name]
        return min(errors, default=DEFAULT_ALLOWED_BOUND)
