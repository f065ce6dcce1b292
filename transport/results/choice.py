"""Choice of a run's estimator: the pilots that were compared, as a result stores and reports them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from transport.compile.methods import Method
from transport.statistics.findings import MORE_PARTICLES
from transport.statistics.notation import ratio_text

RECOMMENDATION_RATIO = 0.5  # cost relative to the chosen method, below which the report recommends another
ONLY_METHOD = "the only method that this scene allows"
MISSES_LIGHT = ", so it misses light"
PARTIAL_REASON = "estimates only arrivals at detectors"
FORMER_PARTIAL_REASON = "knows only what arrives at detectors"  # in the files of version 0.1
LARGER_DETECTOR = "use more particles or a larger detector"


@dataclass(frozen=True)
class Mean:
    """Pilot estimate of one quantity: value (sum over bins), standard error (nan if unknown), dof."""

    name: str
    value: float
    error: float
    dof: float


@dataclass(frozen=True)
class Pilot:
    """Result of a short run of one method.

    price: CPU time [s] to the requested errors, or to a relative error of 1; infinite if unknown. rate:
    batches with a score, summed over bins, per second [s^-1]. note: why it could not be run. seconds: time it
    took. foretold, unseen: factor by which the run must grow until nothing is doubtful any more, from scores
    seen and from possible scores not seen (findings.particle_factors_needed);  doubt: the doubtful finding.
    """

    method: Method
    price: float = math.inf
    rate: float = 0.0
    particles: int = 0
    note: str = ""
    seconds: float = 0.0
    means: tuple[Mean, ...] = ()
    foretold: float = 1.0
    unseen: float = 1.0
    doubt: str = ""

    @property
    def cost(self) -> float:
        """Time [s] until the error is reached and no forecast finding is doubtful."""
        return max(self.price, self.seconds * self.foretold) if self.foretold > 1 else self.price


@dataclass(frozen=True)
class Choice:
    """The chosen method and the pilots of all that were tried, the simplest first.

    reasons: why each pilot's method is excluded, "" if it is not;  is_trusted: whether any method is trusted;
    why: reason for a choice without pilots.
    """

    method: Method
    pilots: tuple[Pilot, ...]
    reasons: tuple[str, ...] = ()
    is_trusted: bool = True
    why: str = ONLY_METHOD

    def __post_init__(self) -> None:
        renamed = {FORMER_PARTIAL_REASON: PARTIAL_REASON}
        object.__setattr__(self, "reasons", tuple(renamed.get(reason, reason) for reason in self.reasons))

    def with_method(self, method: Method) -> Choice:
        """Return the choice with the guide that the run has for the one that its pilot had."""
        pilots = [
            replace(each, method=method) if each.method == self.method else each for each in self.pilots
        ]
        return replace(self, method=method, pilots=tuple(pilots))

    @property
    def _reasoned(self) -> list[tuple[Pilot, str]]:
        """The pilots, each with the reason against its method."""
        return list(zip(self.pilots, self.reasons or ("",) * len(self.pilots), strict=True))

    @property
    def lines(self) -> list[str]:
        """Lines for the report."""
        taken = next(pilot for pilot in self.pilots if pilot.method == self.method)
        others = [_why_not_chosen(pilot, taken, why) for pilot, why in self._reasoned if pilot is not taken]
        why = f"by pilots: {'; '.join(others)}" if others else self.why
        which = "no method for all quantities can" if PARTIAL_REASON in self.reasons else "no method can"
        what = f": {taken.doubt}" if taken.doubt else ""
        no_guide = ", guide=0" if self.method.estimator == "backward" and not self.method.guide else ""
        doubt = f"; {which} be trusted here, and this is the least doubtful{what}"
        return [
            f"chosen: {self.method.title}{'' if self.is_trusted else doubt}, {why}",
            f"repeat: simulate(..., {_as_arguments(self.method)}{no_guide}) gives the same digits",
        ]

    @property
    def others(self) -> list[str]:
        """Estimators that could be used instead: those not refused and not found to miss light."""
        seen = [pilot for pilot, why in self._reasoned if not pilot.note and MISSES_LIGHT not in why]
        found = [pilot.method.estimator for pilot in seen]
        return [name for name in dict.fromkeys(found) if name != self.method.estimator]


def more_particles_cure(choice: Choice | None) -> str:
    """The cure of a run with too few scores, without estimators that its pilots already compared."""
    if choice is None:
        return MORE_PARTICLES
    others = " or ".join(map(repr, choice.others))
    return f"{LARGER_DETECTOR.replace(' or', ',')}, or estimator={others}" if others else LARGER_DETECTOR


def _as_arguments(method: Method) -> str:
    """The method as arguments of `simulate`."""
    guide = f", guide={method.guide}" if method.guide else ""
    return f"estimator={method.estimator!r}, sampling={method.sampling!r}{guide}"


def _why_not_chosen(pilot: Pilot, taken: Pilot, reason: str) -> str:
    """Why a method was not chosen: the reason against it, or its cost."""
    if reason not in ("", PARTIAL_REASON):
        return f"{pilot.method.title} {reason}"
    is_less = reason == PARTIAL_REASON and pilot.cost < taken.cost
    return _relative_cost(pilot, taken) + f", but {reason}" * is_less


def _relative_cost(pilot: Pilot, taken: Pilot) -> str:
    """Cost of a method relative to the chosen one, in words."""
    title = pilot.method.title
    if pilot.note:
        return f"{title} refused ({pilot.note})"
    if pilot.price == math.inf:
        return f"{title} had too few scores to estimate its price"
    if taken.cost == 0:
        return f"{title} no cheaper"
    ratio = pilot.cost / taken.cost
    if ratio < RECOMMENDATION_RATIO:
        return (
            f"{title} is {ratio_text(1 / ratio) if ratio else 'many'} times cheaper"
            f" ({_as_arguments(pilot.method)})"
        )
    return f"{title} costs {ratio_text(ratio)} times as much"
