"""What a run leaves behind: its plan, the sums of its batches, its cost; diagnostics and reports read it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from transport.compile.plan import Plan
from transport.results.batches import Batch
from transport.results.choice import Choice
from transport.results.estimates import Batches
from transport.results.findings import ALLOWED
from transport.tracking import Tracking

BY_CHANCE = -0.5  # slope of the error of independent histories against time


@dataclass(frozen=True)
class Forecast:
    """Forecast of a pilot, made `after` seconds: seconds and particles of the whole run."""

    after: float
    seconds: float
    particles: int | float  # infinite where unknown


@dataclass(frozen=True)
class Cost:
    """What a run cost.

    seconds: wall clock, without `preparation` (compiling or loading passes);  particles, crossings, collisions: all that were
    followed, with those of rounds that a later one has replaced;  threads: at a time, of so many workers where it was a cluster that
    did them;  slopes: of the errors asked for against time, where that has
    been measured;  forecast: what a pilot of the run foretold, where it came to that.
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
        return self.particles / self.seconds

    @property
    def next_digit(self) -> float:
        """Seconds for a tenth of the error: a hundred times the particles, or fewer where the slope is steeper."""
        return self.seconds * 10 ** (-1 / max(self.slopes.values(), default=BY_CHANCE))


class Record:
    """What a run leaves behind; `Result` adds how it is read."""

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
        """asked: the tracking that was said, choice: how the estimator was chosen; None where nobody did.

        state: by which the run can go on (a `State` of the room `run`, which nothing here reads but its limits);  wanted: relative errors that were asked for, None for those of the state.
        """
        self.wanted = wanted
        self.scene, self.plan, self.seed, self.cost, self.is_complete = (
            plan.scene if plan.turned is None else plan.turned.scene,
            plan,
            seed,
            cost,
            is_complete,
        )
        self.batches, self.asked, self.choice, self.state = batches, asked, choice, state
        is_even = plan.method.sampling != "random"
        self.run = Batches(np.array([batch.histories for batch in batches]), is_even)
        self._warnings = list(warnings)
        self._readings: dict[str, Any] = {}

    @property
    def particles(self) -> int:
        return int(self.run.sizes.sum())

    def allowed_of(self, name: str) -> float:
        """The relative error that was asked for of a detector, up to which a bound is no doubt; 1 % where none was."""
        asked = (
            self.wanted if self.wanted is not None else {} if self.state is None else self.state.limits.error
        )
        errors = [error for quantity, error in asked.items() if quantity.partition(".")[0] == name]
        return min(errors, default=ALLOWED)
