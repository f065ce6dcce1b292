"""Estimator "auto": pilot runs of each method that a scene allows, to find the cheapest trustworthy one.

A run with `error` or `seconds` and no `estimator` uses it. Without `error` any quantity may be read from the
result; then the methods that estimate only light arriving at detectors (ARRIVALS_ONLY) are chosen only where
no other can be trusted. Where no method for all quantities is trusted, or the run would be long, and light
comes by specular or glossy surfaces, forward methods are tried with a guide too.

Two kinds of methods are excluded: those whose results would still be doubtful after the run
(statistics/findings.py), and those whose mean lies below that of another by more than chance, however small
both errors are, because light that a method misses is missing from its error estimate too. Chance is
Student's t at FALSE_ALARM for all pairs together. If no method can be trusted, the least doubtful is used,
and the report states it.

The cost of a method is its squared relative error times the time of its pilot: the time to a relative error
of 1 if errors fall with the square root of time. Times are measured, so that two runs may choose differently.
The report names the choice, and `simulate` with these names for `estimator` and `sampling` repeats the run
bitwise.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import permutations, product
from typing import TYPE_CHECKING

import numpy as np

from transport.compile.methods import (
    ARRIVALS_ONLY,
    SAMPLINGS,
    Method,
    default_estimator,
    guided_methods,
    methods_for,
    refusal,
)
from transport.results.choice import MISSES_LIGHT, PARTIAL_REASON, Choice, Mean, Pilot
from transport.statistics.batches import normal_score
from transport.statistics.estimates import EstimateOrArray
from transport.statistics.findings import (
    DEFAULT_ALLOWED_BOUND,
    particle_factors_needed,
)
from transport.statistics.notation import ratio_text
from transport.validation import SceneError, join_names, name_hint

if TYPE_CHECKING:
    from transport.results.result import Result
    from transport.scene.scene import Scene

PILOT_SECONDS = 0.4  # time of all pilots together [s], without compilation
# histories of the first pilot, growth factor, most histories
MIN_HISTORIES, GROWTH_FACTOR, MAX_HISTORIES = 1 << 8, 4, 1 << 26
# least histories of a pilot, unless they take longer than this [s]
MIN_PILOT_HISTORIES, LONG_PILOT_SECONDS = 1 << 12, 0.25
FALSE_ALARM = 1e-4  # probability that any pilot lies below another by chance
# runs that take less time [s], or that reach this relative error in their time, need no guide
GUIDE_SECONDS, PRECISE = 2.0, 1e-3
TIE_FACTOR = 1.2  # the simplest method within this factor of the lowest price is chosen
# Cost factor of stratified and Sobol runs for an error or a time: they run in rounds of doubled size, and
# only the last complete round is the result.
ROUNDS_COST_FACTOR = 3.0
NOTHING_TO_COMPARE = "the simplest, as no detector gives a quantity to compare methods by"
PILOT_SEED_MASK = 0x5DEECE66D  # seed offset of pilots: their choice must not depend on the run's own numbers


def choose_method(
    scene: Scene,
    error: Mapping[str, float] | None,
    sampling: str | None,
    run: Callable[[Method, int], Result],
    clock: Callable[[], float] = time.process_time,
    particles: float | None = None,
    seconds: float | None = None,
    reads_all: bool = False,
    may_guide: bool = False,
) -> Choice:
    """Choose the cheapest method for the quantities of `error`, or for the main quantity of each detector.

    sampling: None for any;  run: (method, particles) -> Result;  clock: [s];  particles, seconds: limits of
    the coming run;  reads_all: whether any quantity and the energy balance may be read, for which methods
    that estimate only a part are second choice;  may_guide: whether to try guides where no method is trusted.
    Raises SceneError for an unknown sampling, or if no method can be run.
    """
    if sampling is not None and sampling not in SAMPLINGS:
        names = ", ".join(map(repr, SAMPLINGS))
        cure = name_hint(str(sampling), SAMPLINGS)
        raise SceneError(f"simulate: sampling must be one of {names}, got {sampling!r}; {cure}")
    methods = [method for method in methods_for(scene) if sampling in (None, method.sampling)]
    if not methods and (reason := refusal(scene, default_estimator(scene))):
        raise SceneError(f"simulate: no estimator goes with this scene: {reason}")
    if not methods:
        names = join_names(sorted({method.estimator for method in methods_for(scene)}))
        raise SceneError(
            f"simulate: sampling {sampling!r} does not go with {names}, which this scene needs; leave it out"
        )
    if len(methods) == 1:
        return Choice(methods[0], (Pilot(methods[0]),))
    groups = [(name,) for name in error] if error else main_quantities(scene)
    if not groups:
        return Choice(methods[0], (Pilot(methods[0]),), why=NOTHING_TO_COMPARE)
    # Run the pilots, and price them by the requested quantities or by those that score.
    patience = PILOT_SECONDS / len(methods)

    def tried(methods: Sequence[Method]) -> list[_Trial]:
        return [_trial(method, groups, error or {}, run, clock, patience) for method in methods]

    def chosen(trials: Sequence[_Trial]) -> Choice:
        targets = dict(error) if error else dict.fromkeys(_scored_quantities(groups, trials), 1.0)
        in_rounds = ROUNDS_COST_FACTOR if error or seconds is not None else 1.0
        costs = [1.0 if trial.method.sampling == "random" else in_rounds for trial in trials]
        pilots = [_pilot(trial, targets, cost) for trial, cost in zip(trials, costs, strict=True)]
        return select_method(pilots, bool(error), particles, seconds, reads_all)

    trials = tried(methods)
    choice = chosen(trials)
    is_whole = choice.is_trusted and not (reads_all and choice.method.estimator in ARRIVALS_ONLY)
    is_whole = is_whole and not any(_is_unknown(group[0], trials) for group in groups)
    if may_guide and not (is_whole and _is_cheap(choice, error, seconds)) and sampling in (None, "random"):
        guided = [each for each in guided_methods(scene, particles) if each.estimator not in ARRIVALS_ONLY]
        more = tried(guided)
        trials, choice = [*trials, *more], chosen([*trials, *more])
    _check_any_scored(choice.pilots, trials)
    return choice


def select_method(
    pilots: Sequence[Pilot],
    has_error: bool,
    particles: float | None = None,
    seconds: float | None = None,
    reads_all: bool = False,
) -> Choice:
    """The cheapest of the pilots' methods that can be trusted, or the least doubtful one."""
    # Collect the reasons against each method: misses light, estimates a part only, or is doubtful.
    below = _significantly_below(pilots)
    excesses = [_missing_growth(pilot, has_error, particles, seconds) for pilot in pilots]
    partial = [k for k, pilot in enumerate(pilots) if reads_all and pilot.method.estimator in ARRIVALS_ONLY]

    def reason_against(k: int) -> str:
        if k in below:
            return below[k]
        if excesses[k] > 1:
            return f"is doubtful: {pilots[k].doubt}"
        return PARTIAL_REASON if k in partial and not pilots[k].note else ""

    reasons = [reason_against(k) for k in range(len(pilots))]
    # Take the cheapest trusted method, if possible one for all quantities, or else the least doubtful one.
    for allowed in ("",), ("", PARTIAL_REASON):
        pairs = zip(pilots, reasons, strict=True)
        trusted = [pilot for pilot, reason in pairs if reason in allowed and not pilot.note]
        is_trusted = any(pilot.rate > 0 for pilot in trusted)
        if is_trusted:
            taken = cheapest(trusted)
            break
    else:
        rest = [k for k, pilot in enumerate(pilots) if not pilot.note and k not in below]
        rest = [k for k in rest if pilots[k].rate > 0] or rest or range(len(pilots))
        taken = pilots[min(rest, key=lambda k: excesses[k])]
    return Choice(taken.method, tuple(pilots), tuple(reasons), is_trusted)


def _missing_growth(pilot: Pilot, has_error: bool, particles: float | None, seconds: float | None) -> float:
    """Factor by which the run is too short to remove all doubts; at most 1 for a trustworthy method.

    A run for an error continues until observed scores are sufficient, but not for scores never seen.
    """
    longer = [max(pilot.price / pilot.seconds, pilot.foretold)] if has_error and pilot.seconds > 0 else []
    longer += [particles / pilot.particles] if particles and pilot.particles else []
    longer += [seconds / pilot.seconds] if seconds and pilot.seconds > 0 else []
    needed = max(pilot.foretold, pilot.unseen)
    return needed / max(min(longer, default=1.0), 1.0)


def _significantly_below(pilots: Sequence[Pilot]) -> dict[int, str]:
    """Pilots whose mean lies below another's by more than chance, with the reason in words."""
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
                errors = ratio_text(-score)
                words = f"lies {errors} standard errors below {pilots[high].method.title}{MISSES_LIGHT}"
                found[low] = score, words
    return {low: words for low, (_, words) in found.items()}


def main_quantities(scene: Scene) -> list[tuple[str, ...]]:
    """Quantities to compare when none is named, in groups of which the first one with scores counts.

    For a detector the arriving quantity, else the leaving one; for volume and point detectors the fluence
    rate; for phase spaces the number.
    """
    found: list[tuple[str, ...]] = []
    for detector in scene.meters:
        kind = "flux" if detector.directions is None else "radiance"
        if kind == "radiance" and scene.shape_of(detector).is_infinite:
            kind = "intensity"
        arriving, leaving = ("flux_in", "flux_out") if kind == "flux" else (kind, f"{kind}_out")
        found.append((f"{detector.name}.{arriving}", f"{detector.name}.{leaving}"))
    found += [(f"{detector.name}.fluence_rate",) for detector in (*scene.volumes, *scene.points)]
    return found + [(f"{detector.name}.number",) for detector in scene.phase_spaces]


def cheapest(pilots: Sequence[Pilot]) -> Pilot:
    """The simplest pilot within a factor TIE_FACTOR of the lowest cost, or if unknown of the highest rate."""
    least = min(pilot.cost for pilot in pilots)
    if least < math.inf:
        return next(pilot for pilot in pilots if pilot.cost <= TIE_FACTOR * least)
    most = max(pilot.rate for pilot in pilots)
    return next(pilot for pilot in pilots if not pilot.note and TIE_FACTOR * pilot.rate >= most)


@dataclass(frozen=True)
class PilotQuantity:
    """Pilot result of one quantity.

    square: mean square of relative errors over bins, nan if unknown;  scores: batches with a score, summed
    over bins;  mean: sum over bins;  doubt: doubtful findings of it (findings.particle_factors_needed).
    """

    square: float
    scores: int
    mean: Mean
    doubt: tuple[float, float, str] = (1.0, 1.0, "")


def evaluate_quantity(
    name: str, quantity: EstimateOrArray, allowed: float = DEFAULT_ALLOWED_BOUND
) -> PilotQuantity:
    """Evaluate a pilot's quantity. A bin without a score counts as a relative error of 1."""
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.atleast_1d(quantity._error_with_unknown / np.abs(quantity.value))
    is_known = np.isfinite(relative)
    unknown = np.where(is_known, np.minimum(relative, 1.0), 1.0)
    square = float(np.mean(unknown**2)) if is_known.any() else math.nan
    whole = quantity._whole
    error = float(whole._error_with_unknown)
    mean = Mean(name, whole.value, error if error < math.inf else math.nan, whole.dof)
    findings = whole._all_findings if error < math.inf else whole._raw_findings
    doubt = particle_factors_needed(findings, whole.value, error, allowed)
    return PilotQuantity(square, int(np.count_nonzero(quantity.values)), mean, doubt)


def price_of(
    seen: Mapping[str, PilotQuantity], targets: Mapping[str, float], seconds: float
) -> tuple[float, float]:
    """(seconds to reach all target errors, batches with a score per second) from a run of `seconds`."""
    squares = [seen[name].square / target**2 for name, target in targets.items()]
    scores = sum(seen[name].scores for name in targets)
    return math.inf if any(map(math.isnan, squares)) else seconds * max(squares), scores / seconds


@dataclass(frozen=True)
class _Trial:
    """Last and largest pilot run of a method: quantities seen, and reasons for those it could not give."""

    method: Method
    particles: int = 0
    seconds: float = 0.0
    seen: Mapping[str, PilotQuantity] = field(default_factory=dict)
    refused: Mapping[str, str] = field(default_factory=dict)
    note: str = ""


def _trial(
    method: Method,
    groups: Sequence[tuple[str, ...]],
    allowed: Mapping[str, float],
    run: Callable,
    clock: Callable,
    patience: float,
) -> _Trial:
    """Run one method, each run four times as large as the last, until its share of the time is spent.

    groups: of quantities; of each group the first one that scores is wanted.
    """
    particles = MIN_HISTORIES
    try:
        run(method, particles)  # compile or load the kernels
        while True:
            begun = clock()
            result = run(method, particles)
            seconds = max(clock() - begun, 1e-9)
            is_large = particles >= MIN_PILOT_HISTORIES or seconds >= LONG_PILOT_SECONDS
            is_long = seconds >= patience / (GROWTH_FACTOR + 1)
            if (is_long and is_large) or particles >= MAX_HISTORIES:
                break
            particles *= GROWTH_FACTOR
    except SceneError as error:
        return _Trial(method, note=str(error))
    seen: dict[str, PilotQuantity] = {}
    refused: dict[str, str] = {}
    for name in (name for group in groups for name in _until_scored(group, seen)):
        try:
            bound = allowed.get(name, DEFAULT_ALLOWED_BOUND)
            seen[name] = evaluate_quantity(name, result.quantity(name), bound)
        except SceneError as error:
            refused[name] = str(error)
    return _Trial(method, result.particles, seconds, seen, refused)


def _until_scored(group: tuple[str, ...], seen: Mapping[str, PilotQuantity]) -> Iterator[str]:
    """Quantities of a group up to the first that scores."""
    for name in group:
        yield name
        if name in seen and seen[name].scores:
            return


def _scored_quantities(groups: Sequence[tuple[str, ...]], trials: Sequence[_Trial]) -> list[str]:
    """First quantity of each group that any method scores; all first quantities if none scores."""
    seen = [trial.seen for trial in trials]
    lit = [
        [name for name in group if any(name in one and one[name].scores for one in seen)] for group in groups
    ]
    return [names[0] for names in lit if names] or [group[0] for group in groups]


def _is_unknown(name: str, trials: Sequence[_Trial]) -> bool:
    """Return whether no method scored a quantity, nor knows that it is zero."""
    seen = [trial.seen[name] for trial in trials if name in trial.seen]
    return not any(each.scores or each.mean.error == 0 for each in seen)


def _is_cheap(choice: Choice, error: Mapping[str, float] | None, seconds: float | None) -> bool:
    """Return whether a run by the chosen method is short, or precise, without a guide."""
    cost = next(pilot.cost for pilot in choice.pilots if pilot.method == choice.method)
    if not error and seconds is not None:
        return seconds < GUIDE_SECONDS or cost < PRECISE**2 * seconds
    return not error or cost < GUIDE_SECONDS


def _pilot(trial: _Trial, targets: Mapping[str, float], rounds: float) -> Pilot:
    """Pilot for these target quantities. rounds: total cost of a run relative to its last round."""
    note = trial.note or next((trial.refused[name] for name in targets if name in trial.refused), "")
    if note:
        return Pilot(trial.method, note=note)
    seen = [trial.seen[name] for name in targets]
    price, rate = price_of(trial.seen, targets, trial.seconds)
    price *= rounds
    worst = max(seen, key=lambda each: max(each.doubt[:2]))
    foretold, unseen, doubt = worst.doubt
    means = tuple(each.mean for each in seen)
    spent = trial.particles, "", trial.seconds
    return Pilot(trial.method, price, rate, *spent, means, foretold, unseen, doubt)


def _check_any_scored(pilots: Sequence[Pilot], trials: Sequence[_Trial]) -> None:
    """Raise the first refusal, if there is one and none of the pilots scored."""
    if not any(pilot.rate > 0 for pilot in pilots):
        refusals = [trial.note for trial in trials if trial.note]
        refusals += [pilot.note for pilot in pilots] if all(pilot.note for pilot in pilots) else []
        for refusal in refusals:
            raise SceneError(refusal)
