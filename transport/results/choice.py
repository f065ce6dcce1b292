"""Which estimator a run was made with, and why: the pilots that were compared, as a result keeps and reports them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from transport.estimators.methods import Method
from transport.results.findings import MORE
from transport.results.notation import times_text

MUCH_CHEAPER = 0.5  # times the cost of the way that is taken
ONLY_WAY = "the only way that this scene allows"
MISSES = ", so it misses light"
KNOWS_PART = "knows only what arrives at detectors"
LARGER = "use more particles or a larger detector"


@dataclass(frozen=True)
class Mean:
    """What a pilot estimated of one quantity: the value, of bins their sum; its standard error, nan where it is not known."""

    name: str
    value: float
    error: float
    dof: float


@dataclass(frozen=True)
class Pilot:
    """What a short run told of one way.

    price: [s] of CPU to the errors asked for, or to a relative error of 1 where none are; infinite where nothing is known.
    rate: batches with a score, bin by bin, a second [s^-1].  note: why it could not be run.  seconds: that it took.
    foretold, unseen: how many times as many histories until nothing is doubtful any more, by what has scored, and by what has not
    (findings.times_needed);  doubt: what is doubtful.
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
        """Seconds until the error is reached and nothing foretold is doubtful [s]."""
        return max(self.price, self.seconds * self.foretold) if self.foretold > 1 else self.price


@dataclass(frozen=True)
class Choice:
    """The way taken, and the pilots of all that were tried, the simplest first.

    reasons: of each pilot why its way is out, "" where it is not;  is_trusted: whether any way is not out;  why: of a way that no
    pilot chose.
    """

    method: Method
    pilots: tuple[Pilot, ...]
    reasons: tuple[str, ...] = ()
    is_trusted: bool = True
    why: str = ONLY_WAY

    @property
    def lines(self) -> list[str]:
        """What a report says of it."""
        taken = next(pilot for pilot in self.pilots if pilot.method == self.method)
        reasons = self.reasons or ("",) * len(self.pilots)
        others = [
            _against(pilot, taken, reason)
            for pilot, reason in zip(self.pilots, reasons, strict=True)
            if pilot is not taken
        ]
        why = f"by pilots: {'; '.join(others)}" if others else self.why
        which = "no way that knows all can" if KNOWS_PART in reasons else "no way can"
        what = f": {taken.doubt}" if taken.doubt else ""
        doubt = f"; {which} be trusted here, and this one is the least doubtful{what}"
        return [
            f"chosen: {self.method.title}{'' if self.is_trusted else doubt}, {why}",
            f"repeat: simulate(..., {_named(self.method)}) gives the same digits",
        ]

    @property
    def others(self) -> list[str]:
        """The estimators that could be taken instead: those of which no pilot found that light is missing, or that it was refused."""
        reasons = self.reasons or ("",) * len(self.pilots)
        found = [
            pilot.method.estimator
            for pilot, reason in zip(self.pilots, reasons, strict=True)
            if not pilot.note and MISSES not in reason
        ]
        return [name for name in dict.fromkeys(found) if name != self.method.estimator]


def more_of(choice: Choice | None) -> str:
    """What to do where a run knows too little: as MORE, but of a run whose estimator pilots chose what they have not done yet."""
    if choice is None:
        return MORE
    others = " or ".join(map(repr, choice.others))
    return f"{LARGER.replace(' or', ',')}, or estimator={others}" if others else LARGER


def _named(method: Method) -> str:
    """A way, as `simulate` takes it."""
    return f"estimator={method.estimator!r}, sampling={method.sampling!r}"


def _against(pilot: Pilot, taken: Pilot, reason: str) -> str:
    """Why a way was not taken: what speaks against it, or how its cost compares."""
    if reason not in ("", KNOWS_PART):
        return f"{pilot.method.title} {reason}"
    is_less = reason == KNOWS_PART and pilot.cost < taken.cost
    return _compared(pilot, taken) + f", but {reason}" * is_less


def _compared(pilot: Pilot, taken: Pilot) -> str:
    """How the cost of a way that was not taken compares."""
    title = pilot.method.title
    if pilot.note:
        return f"{title} refused ({pilot.note})"
    if pilot.price == math.inf:
        return f"{title} scored nothing that tells its price"
    if taken.cost == 0:
        return f"{title} no cheaper"
    ratio = pilot.cost / taken.cost
    if ratio < MUCH_CHEAPER:
        return (
            f"{title} is {times_text(1 / ratio) if ratio else 'many'} times cheaper ({_named(pilot.method)})"
        )
    return f"{title} costs {times_text(ratio)} times as much"
