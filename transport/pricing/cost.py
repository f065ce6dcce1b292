"""What accuracy costs in time: the same number estimated in every way that a scene allows, by runs of growing size.

For each way the true error, the root mean square over independent runs, stands beside the error that the runs
claimed, against seconds, never against particle numbers alone: what one way saves in histories it may lose in time.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial

import numpy as np

from transport.compile import compile_scene
from transport.estimators.methods import Method, checked_method, methods_for
from transport.pricing.machine import machine_name
from transport.pricing.trials import KEYS, Trials, trials_of
from transport.pricing.ways import Way, best_estimate, way_of
from transport.results import Result
from transport.results.estimates import Estimate, EstimateArray
from transport.runs.limits import checked_limits, checked_threads, checked_whole
from transport.scene import Scene
from transport.simulate import simulate
from transport.tracking import Tracking
from transport.validation import SceneError, shown, suggestion

TARGETS = (1e-2, 1e-3, 1e-4)
SECONDS = 20.0  # of CPU, shared by the ways
DEEP = 1e-4  # share of its first weight below which a deep history plays roulette

Quantity = str | Callable[[Result], Estimate | EstimateArray]


@dataclass(frozen=True)
class CostOfAccuracy:
    """Prices of one quantity on one machine: `ways`, each with its points, its slope and `price(error)` in seconds.

    truth [unit]: what deviations are measured from, the exact value, or the best estimate with its standard error
    truth_error, of the relative size that `truth_is` says.  refused: why the ways that are missing cannot be taken.
    Seconds are of CPU, all threads together; `wall` beside them is by the clock.
    """

    quantity: str
    unit: str
    truth: float | tuple[float, ...]
    truth_is: str
    ways: tuple[Way, ...]
    targets: tuple[float, ...]
    refused: Mapping[str, str]
    machine: str
    threads: int

    def __getitem__(self, name: str) -> Way:
        names = [way.name for way in self.ways]
        if name not in names:
            raise SceneError(f"cost_of_accuracy: no way {name!r}; {suggestion(name, names)}")
        return self.ways[names.index(name)]

    @property
    def cheapest(self) -> Way | None:
        """The way of the least price at the finest target; None where none is known."""
        known = [way for way in self.ways if way.line is not None]
        return min(known, key=lambda way: way.price(min(self.targets)).seconds, default=None)

    def to_dict(self) -> dict[str, object]:
        """All of it in dicts, lists, texts and numbers; the prices of each way beside its points."""
        record = asdict(self) | {"refused": dict(self.refused)}
        for way, told in zip(self.ways, record["ways"], strict=True):
            told["prices"] = [{"error": target} | asdict(way.price(target)) for target in self.targets]
        return record

    def to_json(self) -> str:
        """`to_dict` as JSON, in which what is not known is null."""
        return json.dumps(_without_nan(self.to_dict()), indent=2)

    def __str__(self) -> str:
        from transport.pricing.price_table import price_lines

        return "\n".join(price_lines(self))

    __repr__ = __str__

    def _repr_html_(self) -> str:
        from transport.html.prices import prices_html

        return prices_html(self)


def cost_of_accuracy(
    scene: Scene,
    quantity: Quantity,
    targets: Sequence[float] = TARGETS,
    exact: float | None = None,
    methods: Sequence[str] | Mapping[str, Mapping[str, object]] | None = None,
    seconds: float = SECONDS,
    seed: int = 0,
    threads: int | None = 1,
) -> CostOfAccuracy:
    """Measure what a relative error costs in each way that the scene allows; takes about so many seconds.

    quantity: "meter.flux_in", or a function of a Result that gives an Estimate or an EstimateArray (whose error is then
    that of all its bins together, as root mean squares).  exact: its exact value [its unit]; None for the best estimate,
    the mean of all runs of all ways.  methods: names of ways (see `ways_for`), or {name: keywords of simulate};
    None for all.  seconds: of CPU for all ways together, besides compilation.  Raises SceneError.
    """
    ways = _chosen_ways(scene, methods)
    read = _reader(scene, quantity)
    threads, seed = checked_threads(threads), checked_whole("seed", seed, 0, 2**32 - 1)
    if not 0 < seconds < math.inf:
        raise SceneError(f"cost_of_accuracy: seconds must be positive and finite, got {shown(seconds)}")
    for target in targets:
        if not 0 < target < 1:
            raise SceneError(
                f"cost_of_accuracy: targets must be relative, within (0, 1), got {shown(target)}"
            )
    found: dict[str, Trials] = {}
    refused: dict[str, str] = {}
    units: list[str] = []
    for place, (name, keywords) in enumerate(ways.items()):
        run = partial(_run, scene, read, keywords, threads, units)
        try:
            found[name] = trials_of(run, seconds / len(ways), (seed << 32) + place * KEYS)
        except SceneError as refusal:
            refused[name] = str(refusal)
    if not found:
        raise SceneError(f"cost_of_accuracy: no way could be taken: {next(iter(refused.values()))}")
    if exact is None:
        truth = best_estimate(found)
    else:
        truth = best_estimate({}, np.ravel(np.asarray(exact, dtype=float)))
    return CostOfAccuracy(
        quantity if isinstance(quantity, str) else getattr(quantity, "__name__", "quantity"),
        units[0],
        truth.value[0].item() if truth.value.size == 1 else tuple(truth.value.tolist()),
        truth.words,
        tuple(way_of(name, trials, truth, _estimator(scene, ways[name])) for name, trials in found.items()),
        tuple(sorted(map(float, targets), reverse=True)),
        refused,
        machine_name(),
        threads,
    )


def ways_for(scene: Scene) -> dict[str, dict[str, object]]:
    """All ways to estimate that a scene allows, {name: keywords of simulate}, the simplest first.

    Estimators and samplings; and with media the choices of tracking, under the analog estimator.  Splitting is left
    out: where it starts, ends and how much it gains must be said, {"deep": {"tracking": Tracking(splitting=...)}}.
    """
    ways = {m.title: {"estimator": m.estimator, "sampling": m.sampling} for m in methods_for(scene)}
    plan = compile_scene(scene)
    if plan.scatters and plan.lessens:
        ways["analog absorption"] = {"tracking": "analog"}
        ways[f"roulette {DEEP:g}"] = {"tracking": Tracking(roulette=DEEP)}
    if plan.scatters:
        ways["forced collisions"] = {"tracking": Tracking(absorption=plan.tracking.absorption, forced=True)}
    return ways


def _chosen_ways(scene: Scene, methods: object) -> dict[str, dict[str, object]]:
    if isinstance(methods, Mapping):
        return {str(name): dict(keywords) for name, keywords in methods.items()}
    ways = ways_for(scene)
    if methods is None:
        return ways
    names = [
        m.title if isinstance(m, Method) else m for m in ([methods] if isinstance(methods, str) else methods)
    ]
    for name in names:
        if name not in ways:
            raise SceneError(
                f"cost_of_accuracy: no way {name!r} for this scene; {suggestion(str(name), ways)}"
            )
    return {name: ways[name] for name in names}


def _reader(scene: Scene, quantity: Quantity) -> Callable[[Result], Estimate | EstimateArray]:
    if isinstance(quantity, str):
        checked_limits(scene, None, {quantity: 0.5}, None, 32)
        return lambda result: result.quantity(quantity)
    if not callable(quantity):
        must = "quantity must be a name such as 'meter.flux_in' or a function of a result"
        raise SceneError(f"cost_of_accuracy: {must}, got {shown(quantity)}")
    return quantity


def _estimator(scene: Scene, keywords: Mapping[str, object]) -> str:
    """What simulate(**keywords) takes; "auto" for one that it chooses."""
    return checked_method(scene, keywords.get("estimator"), keywords.get("sampling", "random")).estimator


def _run(scene, read, keywords, threads: int, units: list[str], particles: int, seed: int) -> tuple:
    """One run: particles, estimate, seconds of preparation; notes the unit."""
    result = simulate(scene, particles, seed=seed, threads=threads, progress=False, **keywords)
    estimate = read(result)
    units.append(str(estimate.unit))
    return result.particles, estimate, result.cost.preparation


def _without_nan(data: object) -> object:
    """The data with None for what is no finite number."""
    if isinstance(data, Mapping):
        return {str(key): _without_nan(value) for key, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [_without_nan(value) for value in data]
    return None if isinstance(data, float) and not math.isfinite(data) else data
