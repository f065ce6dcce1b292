"""`transport cost`: what accuracy costs by each estimator, discretisation against noise, cost of effects."""

import importlib
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from types import ModuleType
from typing import Annotated

import numpy as np
import typer
from rich.table import Table

from transport.analysis.binning import BinsAgainstNoise, bins_against_noise
from transport.analysis.cost import (
    DEFAULT_SECONDS,
    CostOfAccuracy,
    cost_of_accuracy,
    price_heads,
    price_notes,
    price_rows,
)
from transport.analysis.effects import EffectCost, effect_costs
from transport.cli.effects import effect_table
from transport.cli.options import Json, Seed, Set, Sim, named_values, number
from transport.cli.output import print_json, print_labelled, print_pictures, print_rich, table_of
from transport.cli.run import checked_experiment, draw_to
from transport.results.result import Result
from transport.simulate import simulate
from transport.statistics.estimates import EstimateArray
from transport.validation import SceneError, name_hint
from transport.verification.experiment import (
    attribute_errors,
    cases_of,
    experiment,
    experiment_name,
    run_settings_of,
    scene_of,
)

LISTING_HISTORIES = 1 << 14  # histories of the run that lists the quantities
BINS_HISTORIES = 1 << 20  # histories of the run that compares discretisation with noise


def cost(
    sim: Sim,
    set_: Set = None,
    quantity: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Quantity [default: the first one with an exact value]"),
    ] = None,
    seconds: Annotated[
        str, typer.Option(metavar="S", help="CPU time of all estimators together, without compilation")
    ] = f"{DEFAULT_SECONDS:g}",
    seed: Seed = 0,
    threads: Annotated[int, typer.Option(help="Number of threads per run")] = 1,
    out: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Folder of the diagram [default: out]")
    ] = None,
    no_picture: Annotated[bool, typer.Option("--no-picture", help="Draw no diagram")] = False,
    json: Json = False,
) -> None:
    """Measure the error of every estimator against CPU time.

    \b
    Examples:
      transport cost cost_disks
      transport cost lambert_disk --set distance=20 --quantity irradiance
      transport cost mine.py --seconds 5 --no-picture --json
    """
    module, settings = checked_experiment(experiment(sim)), named_values(set_ or ())
    costs = costs_of_case(module, settings, quantity, number("--seconds", seconds), seed, threads)
    if json:
        print_json(costs.record)
    else:
        print_costs(costs)
    if not no_picture and (not json or out is not None):
        print_pictures(*draw_costs(costs, Path("out") if out is None else out), quiet=json)


# ---- The measurement.


@dataclass(frozen=True)
class Costs:
    """Costs of one case of an experiment; `bins` is None if no detector has bins."""

    sim: str
    parameters: Mapping[str, object]
    cost: CostOfAccuracy
    bins: BinsAgainstNoise | None
    effects: tuple[EffectCost, ...]

    @property
    def record(self) -> dict[str, object]:
        """All values as one dictionary for JSON."""
        bins = None if self.bins is None else asdict(self.bins) | {"total": self.bins.total()}
        if bins is not None:
            bins |= {"best": self.bins.best(), "best_of_100_times_the_particles": self.bins.best(100)}
        named = {"sim": self.sim, "parameters": dict(self.parameters)}
        return named | self.cost.to_dict() | {"bins": bins, "effects": [asdict(e) for e in self.effects]}


def costs_of_case(
    module: ModuleType,
    settings: dict[str, object],
    quantity: str | None,
    seconds: float,
    seed: int,
    threads: int,
) -> Costs:
    """Measure the first case that the settings leave.

    `quantity` None selects the first quantity with an exact value; `seconds` is the CPU time of all
    estimators.
    """
    parameters = cases_of(module, settings)[0]
    scene = scene_of(module, parameters, settings)
    with attribute_errors(module, settings):
        exact = dict(module.exact(**parameters)) if hasattr(module, "exact") else {}
    common = {"seed": seed, "threads": threads, "progress": False} | run_settings_of(module)
    few = simulate(scene, LISTING_HISTORIES, **common)
    name = _quantity_name(module, few, exact, quantity)

    def measured(result: Result):
        with attribute_errors(module):
            return module.measure(result)[name]

    measured.__name__ = name
    cost = cost_of_accuracy(
        scene, measured, exact=exact.get(name), seconds=seconds, seed=seed, threads=threads
    )
    bins = _compare_bins(few, lambda: simulate(scene, BINS_HISTORIES, **common))
    return Costs(experiment_name(module), parameters, cost, bins, tuple(effect_costs(scene)))


# ---- The costs as text and as a picture.


def print_costs(costs: Costs) -> None:
    """Print prices, noise and blur of bins, and the cost of each effect."""
    title = ", ".join(f"{name}={value}" for name, value in costs.parameters.items())
    print_rich(f"{costs.sim}{': ' if title else ''}{title}", style="bold")
    cost = costs.cost
    value = f"{cost.truth:.7g} {cost.unit}" if isinstance(cost.truth, float) else f"{len(cost.truth)} bins"
    print_labelled("quantity", f"{cost.quantity}, {value}, {cost.truth_is}")
    print_rich("", table_of(price_heads(cost), price_rows(cost)))
    for line in price_notes(cost):
        print_labelled("note", line)
    if costs.bins is not None:
        print_rich("", bins_table(costs.bins))
    print_rich("", effect_table(costs.effects))


def bins_table(bins: BinsAgainstNoise) -> Table:
    """Return a table of noise, blur and their sum by number of bins, with the best sums marked."""
    sums = f"both, {bins.particles:.2g} particles>", f"{100 * bins.particles:.2g}>"
    rows, best = [], (bins.best(), bins.best(100))
    columns = zip(bins.bins, bins.noise, bins.blur, bins.total(), bins.total(100), strict=True)
    for count, noise, blur, *totals in columns:
        cells = [f"{100 * t:.2g} %{' ★' if count == b else '  '}" for t, b in zip(totals, best, strict=True)]
        rows.append([str(count), f"{100 * noise:.2g} %", f"{100 * blur:.2g} %", *cells])
    return table_of([f"bins along {bins.dim}>", "noise>", "blur>", *sums], rows)


def draw_costs(costs: Costs, folder: Path) -> tuple[list[Path], str]:
    """Draw the diagram cost_SIM.png into the folder; return its path, or an empty list and the reason."""
    if not any(way.known_points for way in costs.cost.ways):
        return [], "no estimator has a known error; pass more --seconds"

    def draw(path: Path) -> object:
        given = "".join(f", {name}={value}" for name, value in costs.parameters.items())
        title = f"{costs.sim}{given}: cost of accuracy"
        return importlib.import_module("transport.viz.costs").cost_diagram(
            costs.cost, path, costs.bins, title
        )

    return draw_to(draw, folder / f"cost_{costs.sim.removeprefix('cost_')}.png")


def _quantity_name(module: ModuleType, few: Result, exact: Mapping[str, float], requested: str | None) -> str:
    """Return the name of the quantity to measure.  Raises SceneError for an unknown one."""
    with attribute_errors(module):
        found = module.measure(few)
    names = list(found)
    if not names:
        raise SceneError(
            f"cost: {experiment_name(module)} has no quantity that is one number, as pictures are not; add a"
            " Detector or a PointDetector where it matters"
        )
    if requested is None:
        chancy = [name for name in names if not found[name].exact] or names
        return next((name for name in chancy if name in exact), chancy[0])
    if requested not in names:
        raise SceneError(
            f"cost: {experiment_name(module)} has no quantity {requested!r}; {name_hint(requested, names)}"
        )
    return requested


def _compare_bins(few: Result, run) -> BinsAgainstNoise | None:
    """Compare discretisation with noise for the first detector with bins, along its axis with the most bins.

    `run()` returns a result with more histories.  Returns None if no detector has more than 3 bins on an
    axis.
    """
    for detector in few.scene.meters:
        array = _binned_quantity(few, detector)
        if isinstance(array, EstimateArray):
            axes = [(bins, dim) for bins, dim in zip(array.shape, array.dims, strict=True) if bins > 3]
            for _, dim in sorted(axes, reverse=True) if np.any(array.value) else ():
                with suppress(SceneError):  # the number of bins cannot be divided
                    return bins_against_noise(_binned_quantity(run(), detector), dim)
    return None


def _binned_quantity(result: Result, detector) -> object:
    try:
        return result.quantity(
            f"{detector.name}.{'irradiance' if detector.directions is None else 'radiance'}"
        )
    except SceneError:  # e.g. a quantity that the estimator does not provide
        return None
