"""Arguments of `simulate`, and the settings that follow from them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from transport.estimators.methods import Method
from transport.results.choice import Choice
from transport.runs.limits import Limits
from transport.tracking import Tracking


@dataclass(frozen=True)
class Asked:
    """Arguments of `simulate` as given by the user; None for those omitted.

    reads_all: whether any quantity of the result may be read, although `error` names some only.
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
        """Return the limits as given: particles, error, seconds."""
        return self.particles, self.error, self.seconds


@dataclass(frozen=True)
class Way:
    """Settings that determine every batch of a run.

    choice: how the method was chosen, None where it was given.
    """

    method: Method
    limits: Limits
    seed: int
    tracking: Tracking | None
    choice: Choice | None
