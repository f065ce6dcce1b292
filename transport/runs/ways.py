"""How a scene is run: what is asked of `simulate`, and what that comes to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from transport.estimators.methods import Method
from transport.results.choice import Choice
from transport.runs.limits import Limits
from transport.tracking import Tracking


@dataclass(frozen=True)
class Asked:
    """What was said to `simulate`; None for what was not.

    reads_all: whether any quantity may be read of the result, where an `error` names only some.
    """

    particles: float | None = None
    error: Mapping[str, float] | None = None
    seconds: float | None = None
    batches: int | None = None
    part: tuple[int, int] | None = None
    seed: int | None = None
    estimator: str | None = None
    sampling: str | None = None
    tracking: Tracking | str | None = None
    reads_all: bool = False

    @property
    def limits(self) -> tuple:
        """When the run ends."""
        return self.particles, self.error, self.seconds


@dataclass(frozen=True)
class Way:
    """What decides every batch of a run; choice: how the method was chosen, where it was."""

    method: Method
    limits: Limits
    seed: int
    tracking: Tracking | None
    choice: Choice | None
