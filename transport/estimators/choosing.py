"""The estimator "auto": a short pilot of each way that a scene allows, and the run goes on by the cheapest.

What a way costs is its relative error squared, times the seconds that it took: the time to a relative error of 1 if
errors fall with the square root of time.  Seconds are measured, so that two runs may choose differently: the report
names the choice, and `simulate` with its name for `estimator` and `sampling` repeats the run bitwise.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from transport.estimators.methods import SAMPLINGS, Method, methods_for
from transport.validation import SceneError, listed, suggestion

if TYPE_CHECKING:
    from transport.results import Result
    from transport.scene import Scene

PATIENCE = 0.4  # [s] that all pilots together may take, compilation aside
FIRST, FACTOR, MOST = 1 << 12, 4, 1 << 26  # histories of a pilot, and how they grow
TIE = 1.2  # times the least price: the simplest way within it is taken
OTHER_NUMBERS = 0x5DEECE66D  # keys of pilots, so that nothing is chosen for the luck of the run itself


@dataclass(frozen=True)
class Pilot:
    """What a short run told of one way.

    price: [s] of CPU to the errors asked for, or to a relative error of 1 where none are; infinite where nothing is known.
    rate: batches with a score, bin by bin, a second [s^-1].  note: why it could not be run.
    """

    method: Method
    price: float = math.inf
    rate: float = 0.0
    particles: int = 0
    note: str = ""


@dataclass(frozen=True)
class Choice:
    """The way taken, and the pilots of all that were tried, the simplest first."""

    method: Method
    pilots: tuple[Pilot, ...]

    @property
    def lines(self) -> list[str]:
        """What a report says of it."""
        named = f"estimator={self.method.estimator!r}, sampling={self.method.sampling!r}"
        taken = next(pilot for pilot in self.pilots if pilot.method == self.method)
        others = [_compared(pilot, taken) for pilot in self.pilots if pilot is not taken]
        why = f"by pilots: {'; '.join(others)}" if others else "the only way that this scene allows"
        return [
            f"chosen: {self.method.title}, {why}",
            f"repeat: simulate(..., {named}) gives the same digits",
        ]


def choose(
    scene: Scene,
    error: Mapping[str, float] | None,
    sampling: str | None,
    run: Callable[[Method, int], Result],
    clock: Callable[[], float] = time.process_time,
) -> Choice:
    """The cheapest way to the quantities of `error`, or to what every detector counts where none are named.

    sampling: None for any.  run: (method, particles) -> Result;  clock: [s].  Raises SceneError for no such sampling,
    or what the ways say where none of them can be run.
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
    patience = PATIENCE / len(methods)
    pilots = _settled([_pilot(method, targets, run, clock, patience) for method in methods])
    return Choice(cheapest(pilots).method, tuple(pilots))


def usual_quantities(scene: Scene) -> list[str]:
    """What is sought where nobody says: the flux into each detector, its radiance by direction, or a fluence rate."""
    names = [f"{m.name}.{'flux_in' if m.directions is None else 'radiance'}" for m in scene.meters]
    return names + [f"{look.name}.fluence_rate" for look in (*scene.volumes, *scene.points)]


def cheapest(pilots: Sequence[Pilot]) -> Pilot:
    """The first, that is the simplest, of those within a tie of the least price; without prices, of the most scores."""
    least = min(pilot.price for pilot in pilots)
    if least < math.inf:
        return next(pilot for pilot in pilots if pilot.price <= TIE * least)
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
        is_known = np.isfinite(relative)
        if is_known.any():
            unknown = np.where(is_known, np.minimum(relative, 1.0), 1.0)
            squares.append(float(np.mean(unknown**2)) / target**2)
        scores += np.count_nonzero(quantity.values)
    is_whole = len(squares) == len(targets)
    return seconds * max(squares) if squares and is_whole else math.inf, scores / seconds


def _pilot(method: Method, targets: Mapping[str, float], run: Callable, clock: Callable, patience: float):
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
        return Pilot(method, *price_of(result, targets, seconds), result.particles)
    except SceneError as refusal:
        return Pilot(method, note=str(refusal))


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
    if taken.price == 0:
        return f"{title} no cheaper"
    return f"{title} costs {pilot.price / taken.price:.2g} times as much"
