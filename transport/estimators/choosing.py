"""The estimator "auto": a short pilot of each way that a scene allows, and the run goes on by the cheapest that can be trusted.

Out is a way that the judge would still doubt after the run (results/findings.py), and one whose mean lies below that of
another by more than chance, however small both errors are: light that a way misses is missing from its error as well.  Chance
is Student's t at FALSE_ALARM for all pairs together.  Where no way can be trusted, the one with the least doubt is taken, and
the report says so.

What a way costs is its relative error squared, times the seconds that it took: the time to a relative error of 1 if
errors fall with the square root of time.  Seconds are measured, so that two runs may choose differently: the report
names the choice, and `simulate` with its name for `estimator` and `sampling` repeats the run bitwise.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations, product
from typing import TYPE_CHECKING

import numpy as np

from transport.estimators.methods import SAMPLINGS, Method, methods_for
from transport.results.error_bars import CONSTANT
from transport.results.estimates import Estimate, EstimateOrArray
from transport.results.findings import ALLOWED, times_needed
from transport.results.statistics import normal_score
from transport.validation import SceneError, listed, suggestion

if TYPE_CHECKING:
    from transport.results import Result
    from transport.scene import Scene

PATIENCE = 0.4  # [s] that all pilots together may take, compilation aside
FIRST, FACTOR, MOST = 1 << 12, 4, 1 << 26  # histories of a pilot, and how they grow
FALSE_ALARM = 1e-4  # of all pairs of pilots that one lies below another by chance
TIE = 1.2  # times the least price: the simplest way within it is taken
OTHER_NUMBERS = 0x5DEECE66D  # keys of pilots, so that nothing is chosen for the luck of the run itself


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

    reasons: of each pilot why its way is out, "" where it is not;  is_trusted: whether any way is not out.
    """

    method: Method
    pilots: tuple[Pilot, ...]
    reasons: tuple[str, ...] = ()
    is_trusted: bool = True

    @property
    def lines(self) -> list[str]:
        """What a report says of it."""
        named = f"estimator={self.method.estimator!r}, sampling={self.method.sampling!r}"
        taken = next(pilot for pilot in self.pilots if pilot.method == self.method)
        reasons = self.reasons or ("",) * len(self.pilots)
        others = [
            f"{pilot.method.title} {reason}" if reason else _compared(pilot, taken)
            for pilot, reason in zip(self.pilots, reasons, strict=True)
            if pilot is not taken
        ]
        why = f"by pilots: {'; '.join(others)}" if others else "the only way that this scene allows"
        doubt = f"; no way can be trusted here, and this one is the least doubtful: {taken.doubt}"
        return [
            f"chosen: {self.method.title}{'' if self.is_trusted else doubt}, {why}",
            f"repeat: simulate(..., {named}) gives the same digits",
        ]


def choose(
    scene: Scene,
    error: Mapping[str, float] | None,
    sampling: str | None,
    run: Callable[[Method, int], Result],
    clock: Callable[[], float] = time.process_time,
    particles: float | None = None,
    seconds: float | None = None,
) -> Choice:
    """The cheapest way to the quantities of `error`, or to what every detector counts where none are named.

    sampling: None for any.  run: (method, particles) -> Result;  clock: [s];  particles, seconds: limits of the run to come.
    Raises SceneError for no such sampling, or what the ways say where none of them can be run.
    """
    if sampling is not None and sampling not in SAMPLINGS:
        names = ", ".join(map(repr, SAMPLINGS))
        cure = suggestion(str(sampling), SAMPLINGS)
        raise SceneError(f"simulate: sampling must be one of {names}, got {sampling!r}; {cure}")
    methods = [method for method in methods_for(scene) if sampling in (None, method.sampling)]
    if not methods:
        names = listed(sorted({method.estimator for method in methods_for(scene)}))
        raise SceneError(
            f"simulate: sampling {sampling!r} does not go with {names}, which this scene needs; leave it out"
        )
    if len(methods) == 1:
        return Choice(methods[0], (Pilot(methods[0]),))
    targets = dict(error) if error else dict.fromkeys(usual_quantities(scene), 1.0)
    allowed = error or dict.fromkeys(targets, ALLOWED)
    patience = PATIENCE / len(methods)
    pilots = _settled([_pilot(method, targets, allowed, run, clock, patience) for method in methods])
    return chosen(pilots, bool(error), particles, seconds)


def chosen(
    pilots: Sequence[Pilot], has_error: bool, particles: float | None = None, seconds: float | None = None
) -> Choice:
    """The cheapest of the pilots' ways that can be trusted, or the least doubtful one."""
    below = _below(pilots)
    excesses = [_excess(pilot, has_error, particles, seconds) for pilot in pilots]
    reasons = [
        below.get(k, "") or (f"is doubtful: {pilot.doubt}" if excess > 1 else "")
        for k, (pilot, excess) in enumerate(zip(pilots, excesses, strict=True))
    ]
    trusted = [pilot for pilot, reason in zip(pilots, reasons, strict=True) if not reason and not pilot.note]
    is_trusted = any(pilot.rate > 0 for pilot in trusted)
    if is_trusted:
        taken = cheapest(trusted)
    else:
        rest = [k for k, pilot in enumerate(pilots) if not pilot.note and k not in below]
        rest = [k for k in rest if pilots[k].rate > 0] or rest or range(len(pilots))
        taken = pilots[min(rest, key=lambda k: excesses[k])]
    return Choice(taken.method, tuple(pilots), tuple(reasons), is_trusted)


def _excess(pilot: Pilot, has_error: bool, particles: float | None, seconds: float | None) -> float:
    """By how many times the run would have to be longer until nothing is doubtful; 1 or less where it can be trusted.

    A run for an error goes on until it knows what has scored, but not for what has not.
    """
    longer = [pilot.cost / pilot.seconds] if has_error and pilot.seconds > 0 else []
    longer += [particles / pilot.particles] if particles and pilot.particles else []
    longer += [seconds / pilot.seconds] if seconds and pilot.seconds > 0 else []
    needed = max(pilot.foretold, pilot.unseen)
    return needed / max(min(longer, default=1.0), 1.0)


def _below(pilots: Sequence[Pilot]) -> dict[int, str]:
    """The pilots that lie below another one by more than chance, with the words for it."""
    from scipy.special import ndtri

    pairs = list(permutations(range(len(pilots)), 2))
    least = float(ndtri(FALSE_ALARM / max(len(pairs), 1)))
    found: dict[int, tuple[float, str]] = {}
    for low, high in pairs:
        for mine, other in product(pilots[low].means, pilots[high].means):
            error = math.hypot(mine.error, other.error)
            if mine.name != other.name or not error > 0:
                continue
            dof = error**4 / (mine.error**4 / mine.dof + other.error**4 / other.dof)
            score = float(normal_score((mine.value - other.value) / error, dof))
            if score < least and score < found.get(low, (0.0, ""))[0]:
                words = (
                    f"lies {-score:.2g} standard errors below {pilots[high].method.title}, so it misses light"
                )
                found[low] = score, words
    return {low: words for low, (_, words) in found.items()}


def usual_quantities(scene: Scene) -> list[str]:
    """What is sought where nobody says: the flux into each detector, its radiance by direction, or a fluence rate."""
    names = [f"{m.name}.{'flux_in' if m.directions is None else 'radiance'}" for m in scene.meters]
    return names + [f"{look.name}.fluence_rate" for look in (*scene.volumes, *scene.points)]


def cheapest(pilots: Sequence[Pilot]) -> Pilot:
    """The first, that is the simplest, of those within a tie of the least cost; without costs, of the most scores."""
    least = min(pilot.cost for pilot in pilots)
    if least < math.inf:
        return next(pilot for pilot in pilots if pilot.cost <= TIE * least)
    most = max(pilot.rate for pilot in pilots)
    return next(pilot for pilot in pilots if not pilot.note and TIE * pilot.rate >= most)


def price_of(result: Result, targets: Mapping[str, float], seconds: float) -> tuple[float, float]:
    """(seconds to all these relative errors, batches with a score a second) of a run that took so many seconds.

    A bin without a score is unknown by all of its value.
    """
    squares, scores = [], 0.0
    for name, target in targets.items():
        quantity = result.quantity(name)
        relative = np.atleast_1d(quantity.relative_error)
        relative = np.where(np.atleast_1d(quantity.reason) == CONSTANT, 0.0, relative)  # cheapest of all
        is_known = np.isfinite(relative)
        if is_known.any():
            unknown = np.where(is_known, np.minimum(relative, 1.0), 1.0)
            squares.append(float(np.mean(unknown**2)) / target**2)
        scores += np.count_nonzero(quantity.values)
    is_whole = len(squares) == len(targets)
    return seconds * max(squares) if squares and is_whole else math.inf, scores / seconds


def _pilot(
    method: Method,
    targets: Mapping[str, float],
    allowed: Mapping[str, float],
    run: Callable,
    clock: Callable,
    patience: float,
) -> Pilot:
    """Runs of one way, each four times as large as the last, until a fair share of the patience is spent."""
    particles = FIRST
    try:
        run(method, particles)  # compiles or loads its passes
        while True:
            begun = clock()
            result = run(method, particles)
            seconds = max(clock() - begun, 1e-9)
            if seconds >= patience / (FACTOR + 1) or particles >= MOST:
                break
            particles *= FACTOR
        price, rate = price_of(result, targets, seconds)
        means, doubts = zip(
            *(_mean_of(name, result.quantity(name), allowed[name]) for name in targets), strict=True
        )
        foretold, unseen, doubt = max(doubts, key=lambda each: max(each[:2]))
        return Pilot(
            method, price, rate, result.particles, "", seconds, tuple(means), foretold, unseen, doubt
        )
    except SceneError as refusal:
        return Pilot(method, note=str(refusal))


def _mean_of(name: str, quantity: EstimateOrArray, allowed: float) -> tuple[Mean, tuple[float, float, str]]:
    """A quantity as one number, and what is doubtful of it."""
    whole = quantity if isinstance(quantity, Estimate) else quantity.sum()
    mean = Mean(name, whole.value, whole.error, whole.dof)
    return mean, times_needed(whole._raw_findings, whole.value, whole.error, allowed)


def _settled(pilots: list[Pilot]) -> list[Pilot]:
    """The pilots, if any of them tells something: where all that could be run scored nothing, the refusals of the others do."""
    if not any(pilot.rate > 0 for pilot in pilots):
        for refused in filter(lambda pilot: pilot.note, pilots):
            raise SceneError(refused.note)
    return pilots


def _compared(pilot: Pilot, taken: Pilot) -> str:
    """How a way that was not taken compares."""
    title = pilot.method.title
    if pilot.note:
        return f"{title} refused ({pilot.note})"
    if pilot.price == math.inf:
        return f"{title} scored nothing that tells its price"
    if taken.cost == 0:
        return f"{title} no cheaper"
    return f"{title} costs {pilot.cost / taken.cost:.2g} times as much"
