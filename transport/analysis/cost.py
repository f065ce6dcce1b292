"""Cost of accuracy in time: one quantity by every method that a scene allows, in runs of growing size.

For each method the true error (root mean square over independent runs) is listed beside the error that the
runs claimed, against seconds rather than particle numbers: a method that needs fewer particles may take more
time per particle.
"""

from __future__ import annotations

import json
import math
import os
import platform
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from transport.analysis.work_precision import (
    SEEDS_PER_METHOD,
    MethodCost,
    Trials,
    best_estimate,
    cost_of_method,
    run_trials,
)
from transport.compile.compiler import compile_scene
from transport.compile.methods import (
    MIN_GUIDE,
    Method,
    coerce_method,
    guided,
    guided_methods,
    methods_for,
)
from transport.io.html.elements import escaped, framed, heading, muted, table, typeset
from transport.results.result import Result
from transport.run.settings import checked_integer, checked_limits, checked_threads
from transport.scene.scene import Scene
from transport.scene.tracking import Tracking
from transport.simulate import simulate
from transport.statistics.estimates import Estimate, EstimateArray
from transport.statistics.notation import duration, percent
from transport.validation import SceneError, checked_keywords, name_hint, short_repr

if TYPE_CHECKING:
    from transport.analysis.work_precision import Price


# ---- Name of the machine on which times were measured.


def machine_name() -> str:
    """Processor, number of cores and system, such as "AMD EPYC, 2 cores, Linux x86_64"."""
    cores = os.cpu_count() or 1
    return f"{_processor()}, {cores} core{'s' if cores > 1 else ''}, {platform.system()} {platform.machine()}"


def _processor() -> str:
    """Name of the processor."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    except OSError:
        names = []
    return next(iter(names), "") or platform.processor() or "unknown processor"


# ---- The measurement.

DEFAULT_TARGETS = (1e-2, 1e-3, 1e-4)
DEFAULT_SECONDS = 20.0  # CPU time, shared by the methods
DEEP_ROULETTE = 1e-4  # roulette threshold for deep penetration, relative to the birth weight

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
    ways : tuple of MethodCost
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
    ways: tuple[MethodCost, ...]
    targets: tuple[float, ...]
    refused: Mapping[str, str]
    machine: str
    threads: int

    def __getitem__(self, name: str) -> MethodCost:
        """Return the method of that name."""
        names = [way.name for way in self.ways]
        if name not in names:
            raise SceneError(f"cost_of_accuracy: no method {name!r}; {name_hint(name, names)}")
        return self.ways[names.index(name)]

    @property
    def cheapest(self) -> MethodCost | None:
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
        for way, entry in zip(self.ways, record["ways"], strict=True):
            entry["prices"] = [{"error": target} | asdict(way.price(target)) for target in self.targets]
        return record

    def to_json(self) -> str:
        """Return `to_dict` as JSON, with null for unknown numbers.

        Returns
        -------
        str
            JSON text.
        """
        return json.dumps(_nan_to_none(self.to_dict()), indent=2)

    def __str__(self) -> str:
        return "\n".join(price_lines(self))

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Table for notebooks."""
        return prices_html(self)


@checked_keywords
def cost_of_accuracy(
    scene: Scene,
    quantity: Quantity,
    targets: Sequence[float] = DEFAULT_TARGETS,
    exact: float | None = None,
    methods: Sequence[str] | Mapping[str, Mapping[str, object]] | None = None,
    seconds: float = DEFAULT_SECONDS,
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
    ways = _requested_methods(scene, methods)
    read = _quantity_reader(scene, quantity)
    threads, seed = checked_threads(threads), checked_integer("seed", seed, 0, 2**32 - 1)
    if not 0 < seconds < math.inf:
        raise SceneError(f"cost_of_accuracy: seconds must be positive and finite, got {short_repr(seconds)}")
    for target in targets:
        if not 0 < target < 1:
            raise SceneError(
                f"cost_of_accuracy: targets must be relative, within (0, 1), got {short_repr(target)}"
            )
    # Run every method for its share of the time, each with seeds of its own.
    found: dict[str, Trials] = {}
    refused: dict[str, str] = {}
    units: list[str] = []
    for place, (name, keywords) in enumerate(ways.items()):
        run = partial(_run, scene, read, keywords, threads, units)
        try:
            found[name] = run_trials(run, seconds / len(ways), (seed << 32) + place * SEEDS_PER_METHOD)
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
        tuple(
            cost_of_method(name, trials, truth, _estimator(scene, ways[name]))
            for name, trials in found.items()
        ),
        tuple(sorted(map(float, targets), reverse=True)),
        refused,
        machine_name(),
        threads,
    )


def methods_of_scene(scene: Scene) -> dict[str, dict[str, object]]:
    """All methods that a scene allows, {name: keywords of simulate}, the simplest first.

    These are the estimators with each sampling, in scenes with specular or glossy surfaces with and without a
    guide, and, in scenes with media, the kinds of tracking with the analog estimator. Splitting is left out,
    because start, end and gain are needed: {"deep": {"tracking": Tracking(splitting=...)}}.
    """
    ways: dict[str, dict[str, object]] = {}
    for m in methods_for(scene):
        has_guide = guided(scene, m, None, None).guide > 0
        way = {"estimator": m.estimator, "sampling": m.sampling}
        ways |= {f"{m.title}, no guide": way | {"guide": 0}} if has_guide else {m.title: way}
    # The number of histories to learn from is the same in runs of all sizes, and learning counts as time.
    for m in guided_methods(scene, None):
        ways[f"{m.estimator}, guide"] = {"estimator": m.estimator, "guide": MIN_GUIDE}
    plan = compile_scene(scene)
    if plan.scatters and plan.reduces_weights:
        ways["analog absorption"] = {"tracking": "analog"}
        ways[f"roulette {DEEP_ROULETTE:g}"] = {"tracking": Tracking(roulette=DEEP_ROULETTE)}
    if plan.scatters:
        ways["forced collisions"] = {"tracking": Tracking(absorption=plan.tracking.absorption, forced=True)}
    return ways


def _requested_methods(scene: Scene, methods: object) -> dict[str, dict[str, object]]:
    """The requested methods, {name: keywords of simulate}. Raises SceneError for unknown names."""
    if isinstance(methods, Mapping):
        return {str(name): dict(keywords) for name, keywords in methods.items()}
    ways = methods_of_scene(scene)
    if methods is None:
        return ways
    names = [
        m.title if isinstance(m, Method) else m for m in ([methods] if isinstance(methods, str) else methods)
    ]
    for name in names:
        if name not in ways:
            raise SceneError(
                f"cost_of_accuracy: no method {name!r} for this scene; {name_hint(str(name), ways)}"
            )
    return {name: ways[name] for name in names}


def _quantity_reader(scene: Scene, quantity: Quantity) -> Callable[[Result], Estimate | EstimateArray]:
    """Function that reads the quantity from a result. Raises SceneError for an unknown quantity."""
    if isinstance(quantity, str):
        checked_limits(scene, None, {quantity: 0.5}, None, 32)
        return lambda result: result.quantity(quantity)
    if not callable(quantity):
        must = "quantity must be a name such as 'meter.flux_in' or a function of a result"
        raise SceneError(f"cost_of_accuracy: {must}, got {short_repr(quantity)}")
    return quantity


def _estimator(scene: Scene, keywords: Mapping[str, object]) -> str:
    """Estimator that simulate(**keywords) uses; "auto" if it would choose one."""
    return coerce_method(scene, keywords.get("estimator"), keywords.get("sampling", "random")).estimator


def _run(scene, read, keywords, threads: int, units: list[str], particles: int, seed: int) -> tuple:
    """Run once: particles done, estimate, preparation time [s]; appends the unit to `units`."""
    result = simulate(scene, particles, seed=seed, threads=threads, progress=False, **keywords)
    estimate = read(result)
    units.append(str(estimate.unit))
    return result.particles, estimate, result.cost.preparation


def _nan_to_none(data: object) -> object:
    """Replace numbers that are not finite by None."""
    if isinstance(data, Mapping):
        return {str(key): _nan_to_none(value) for key, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [_nan_to_none(value) for value in data]
    return None if isinstance(data, float) and not math.isfinite(data) else data


# ---- Cost of accuracy as a table of text: price, slope and deviation from the truth of each method.

EXTRAPOLATION_MARK = "*"


def price_heads(cost: CostOfAccuracy) -> tuple[str, ...]:
    """Column heads; those of numbers end in >."""
    return ("method", *(f"{percent(target)}>" for target in cost.targets), "slope>", "z>", "compiled in>")


def price_rows(cost: CostOfAccuracy) -> list[tuple[str, ...]]:
    """One row per method."""
    return [
        (way.name, *(price_text(way.price(t)) for t in cost.targets), *_slope_cells(way)) for way in cost.ways
    ]


def price_notes(cost: CostOfAccuracy) -> list[str]:
    """Notes below the table: units, machine, and methods without a price."""
    threads = f"{cost.threads} thread{'s' if cost.threads > 1 else ''}"
    notes = [f"seconds of CPU on {cost.machine}, {threads}; errors from the truth, {cost.truth_is}"]
    if any(way.price(target).is_extrapolated and way.line for way in cost.ways for target in cost.targets):
        notes.append(f"{EXTRAPOLATION_MARK} extrapolated: below all measured errors")
    notes += [f"{way.name}: {_why_no_price(way)}" for way in cost.ways if way.line is None]
    return notes + [f"{name}: not run: {why}" for name, why in cost.refused.items()]


def price_lines(cost: CostOfAccuracy) -> list[str]:
    """Title, table and notes as lines of text."""
    heads, rows = price_heads(cost), price_rows(cost)
    widths = [max(len(row[i]) for row in (*rows, [h.rstrip(">") for h in heads])) for i in range(len(heads))]
    lines = []
    for row in ([head.rstrip(">") for head in heads], *rows):
        cells = [
            f"{cell:>{width}}" if head.endswith(">") else f"{cell:{width}}"
            for cell, width, head in zip(row, widths, heads, strict=True)
        ]
        lines.append("  ".join(cells).rstrip())
    return [price_title(cost), *lines, *price_notes(cost)]


def price_title(cost: CostOfAccuracy) -> str:
    """Title with the quantity and its value."""
    value = f"{cost.truth:.7g} {cost.unit}" if isinstance(cost.truth, float) else f"{len(cost.truth)} bins"
    return f"cost of {cost.quantity} ({value})"


def price_text(price: Price) -> str:
    """Price with a mark if it is extrapolated; a dash if it is unknown."""
    if price.seconds == math.inf:
        return "–"
    return duration(price.seconds) + EXTRAPOLATION_MARK * price.is_extrapolated


def _why_no_price(way: MethodCost) -> str:
    """Reason why a method has no price."""
    if way.known_points:
        return "its error is known for one size of run only, a price needs two; pass more seconds"
    return f"its error is still unknown after {way.points[-1].particles:.2g} particles in the largest run"


def _slope_cells(way: MethodCost) -> tuple[str, str, str]:
    """Text of slope, z and preparation time."""
    slope = "–" if way.line is None else f"{way.line.slope:.2f} ± {way.line.slope_error:.2f}"
    return slope, "–" if math.isnan(way.z) else f"{way.z:+.1f}", duration(way.preparation)


# ---- The cost of accuracy in a notebook: a row per estimator, the cheapest in bold.


def prices_html(cost: CostOfAccuracy) -> str:
    """Return the table of a cost of accuracy as HTML, with the rows and notes of its text."""
    heads = [f">{typeset(h.rstrip('>'))}" if h.endswith(">") else escaped(h) for h in price_heads(cost)]
    rows = [[escaped(row[0]), *(f">{typeset(cell)}" for cell in row[1:])] for row in price_rows(cost)]
    names = [way.name for way in cost.ways]
    best = names.index(cost.cheapest.name) if cost.cheapest is not None else None
    notes = (f"<div>{muted(typeset(note))}</div>" for note in price_notes(cost))
    return framed(heading(typeset(price_title(cost))), table(rows, heads, best), *notes)
