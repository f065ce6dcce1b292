"""Cost of accuracy in time: one quantity by every method that a scene allows, in runs of growing size.

For each method the true error (root mean square over independent runs) is listed beside the error that the
runs claimed, against seconds rather than particle numbers: a method that needs fewer particles may take more
time per particle.
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
SECONDS = 20.0  # CPU time, shared by the methods
DEEP = 1e-4  # roulette threshold for deep penetration, relative to the birth weight

Quantity = str | Callable[[Result], Estimate | EstimateArray]


@dataclass(frozen=True)
class CostOfAccuracy:
    """Cost of one quantity on one machine, by method.

    Parameters
    ----------
    quantity : str
        Name of the quantity.
    unit : str
        Unit of the quantity.
    truth : float or tuple of floats
        Value from which deviations are measured [unit]: the exact value or the best estimate.
    truth_is : str
        "exact", or the relative standard error of the best estimate.
    ways : tuple of Way
        Methods, each with `points` (measured errors and seconds), `line` (fit, with its slope), `z`
        (deviation from the truth in standard errors) and `price(error)` in seconds.
    targets : tuple of floats
        Relative errors of the price table, in falling order.
    refused : mapping of str to str
        Methods that could not be run, with the reason.
    machine : str
        Processor, cores and system.
    threads : int
        Number of threads per run.

    Notes
    -----
    Seconds are CPU seconds of all threads together; `wall` of a point is elapsed time.

    Examples
    --------
    `cost_of_accuracy` makes it; it needs some seconds of runs:

    >>> cost = tp.cost_of_accuracy(scene, "meter.flux_in")  # doctest: +SKIP
    >>> cost["analog"].price(1e-3)  # doctest: +SKIP
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
        """Return the method of that name."""
        names = [way.name for way in self.ways]
        if name not in names:
            raise SceneError(f"cost_of_accuracy: no method {name!r}; {suggestion(name, names)}")
        return self.ways[names.index(name)]

    @property
    def cheapest(self) -> Way | None:
        """Method with the lowest price at the smallest target; None if no price is known."""
        known = [way for way in self.ways if way.line is not None]
        return min(known, key=lambda way: way.price(min(self.targets)).seconds, default=None)

    def to_dict(self) -> dict[str, object]:
        """Return everything as dicts, lists, strings and numbers, with the prices of each method.

        Returns
        -------
        dict
            Fields by name; each method has a list "prices".
        """
        record = asdict(self) | {"refused": dict(self.refused)}
        for way, told in zip(self.ways, record["ways"], strict=True):
            told["prices"] = [{"error": target} | asdict(way.price(target)) for target in self.targets]
        return record

    def to_json(self) -> str:
        """Return `to_dict` as JSON, with null for unknown numbers.

        Returns
        -------
        str
            JSON text.
        """
        return json.dumps(_without_nan(self.to_dict()), indent=2)

    def __str__(self) -> str:
        from transport.pricing.price_table import price_lines

        return "\n".join(price_lines(self))

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Table for notebooks."""
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
    """Measure what a relative error costs in time, by every method that a scene allows.

    Parameters
    ----------
    scene : Scene
        Scene to run.
    quantity : str or callable
        "meter.flux_in", or a function of a Result that returns an Estimate or an EstimateArray (whose error
        is the root mean square over all bins).
    targets : sequence of floats, default (1e-2, 1e-3, 1e-4)
        Relative errors of the price table, within (0, 1).
    exact : float, optional
        Exact value, in the unit of the quantity. Default: the best estimate, the mean of all runs of all
        methods.
    methods : sequence of str, or mapping of str to dict, optional
        Names of methods, such as "aimed" or "analog, sobol", or {name: keywords of simulate}. Default all
        that the scene allows.
    seconds : float, default 20
        CPU time [s] for all methods together, without compilation.
    seed : int, default 0
        Seed, 0 to 2^32 - 1.
    threads : int, default 1
        Number of threads per run; None for all cores.

    Returns
    -------
    CostOfAccuracy
        Errors, seconds and prices of each method; prints as a table.

    Raises
    ------
    SceneError
        If a parameter is invalid or no method can be run.

    Notes
    -----
    Splitting is not among the default methods, because start, end and gain are needed: pass {"deep":
    {"tracking": Tracking(splitting=...)}}.

    Examples
    --------
    >>> import transport as tp
    >>> shape = tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=1.0)
    >>> disk = tp.Surface(shape, tp.Black(), name="disk")
    >>> source = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    >>> scene = tp.Scene(sources=[source], surfaces=[disk], detectors=[tp.Detector("disk", "meter")])
    >>> cost = tp.cost_of_accuracy(scene, "meter.flux_in", exact=0.14644660940672624)  # doctest: +SKIP
    >>> print(cost)  # doctest: +SKIP
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
    # Run every method for its share of the time, each with seeds of its own.
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
        raise SceneError(f"cost_of_accuracy: no method could be run: {next(iter(refused.values()))}")
    # Measure deviations from the exact value, or from the mean of all runs.
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
    """All methods that a scene allows, {name: keywords of simulate}, the simplest first.

    These are the estimators with each sampling and, in scenes with media, the kinds of tracking with the
    analog estimator. Splitting is left out, because start, end and gain are needed: {"deep": {"tracking":
    Tracking(splitting=...)}}.
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
    """The requested methods, {name: keywords of simulate}. Raises SceneError for unknown names."""
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
                f"cost_of_accuracy: no method {name!r} for this scene; {suggestion(str(name), ways)}"
            )
    return {name: ways[name] for name in names}


def _reader(scene: Scene, quantity: Quantity) -> Callable[[Result], Estimate | EstimateArray]:
    """Function that reads the quantity from a result. Raises SceneError for an unknown quantity."""
    if isinstance(quantity, str):
        checked_limits(scene, None, {quantity: 0.5}, None, 32)
        return lambda result: result.quantity(quantity)
    if not callable(quantity):
        must = "quantity must be a name such as 'meter.flux_in' or a function of a result"
        raise SceneError(f"cost_of_accuracy: {must}, got {shown(quantity)}")
    return quantity


def _estimator(scene: Scene, keywords: Mapping[str, object]) -> str:
    """Estimator that simulate(**keywords) uses; "auto" if it would choose one."""
    return checked_method(scene, keywords.get("estimator"), keywords.get("sampling", "random")).estimator


def _run(scene, read, keywords, threads: int, units: list[str], particles: int, seed: int) -> tuple:
    """Run once: particles done, estimate, preparation time [s]; appends the unit to `units`."""
    result = simulate(scene, particles, seed=seed, threads=threads, progress=False, **keywords)
    estimate = read(result)
    units.append(str(estimate.unit))
    return result.particles, estimate, result.cost.preparation


def _without_nan(data: object) -> object:
    """Replace numbers that are not finite by None."""
    if isinstance(data, Mapping):
        return {str(key): _without_nan(value) for key, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [_without_nan(value) for value in data]
    return None if isinstance(data, float) and not math.isfinite(data) else data
