"""What `transport cost` measures of an experiment: prices of a quantity, bins against noise, and what effects cost."""

import importlib
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from types import ModuleType

import numpy as np

from transport.command.effect_costs import EffectCost, effect_costs
from transport.command.running import drawn
from transport.experiment import blamed, cases_of, name_of, scene_of, ways_of
from transport.pricing.cost import CostOfAccuracy, cost_of_accuracy
from transport.pricing.discretisation import BinsAgainstNoise, bins_against_noise
from transport.results import Result
from transport.results.estimates import EstimateArray
from transport.simulate import simulate
from transport.validation import SceneError, suggestion

FEW = 1 << 14  # histories that tell which quantities there are
MANY = 1 << 20  # histories of which bins are judged


@dataclass(frozen=True)
class Costs:
    """What one case of an experiment costs.  bins: None where nothing in it is binned."""

    sim: str
    parameters: Mapping[str, object]
    cost: CostOfAccuracy
    bins: BinsAgainstNoise | None
    effects: tuple[EffectCost, ...]

    @property
    def record(self) -> dict[str, object]:
        """All of it for machines."""
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
    """Measure the first case that the settings leave.  quantity: the first one that has an exact value where it is None."""
    parameters = cases_of(module, settings)[0]
    scene = scene_of(module, parameters, settings)
    with blamed(module, settings):
        exact = dict(module.exact(**parameters)) if hasattr(module, "exact") else {}
    common = {"seed": seed, "threads": threads, "progress": False} | ways_of(module)
    few = simulate(scene, FEW, **common)
    name = _quantity(module, few, exact, quantity)

    def measured(result: Result):
        with blamed(module):
            return module.measure(result)[name]

    measured.__name__ = name
    cost = cost_of_accuracy(
        scene, measured, exact=exact.get(name), seconds=seconds, seed=seed, threads=threads
    )
    bins = _bins(few, lambda: simulate(scene, MANY, **common))
    return Costs(name_of(module), parameters, cost, bins, tuple(effect_costs(scene)))


def draw_costs(costs: Costs, folder: Path) -> tuple[list[Path], str]:
    """Draw the diagram as cost_SIM.png into the folder: its path, or none and the reason why."""
    if not any(way.known_points for way in costs.cost.ways):
        return [], "no way has a known error; give it more --seconds"

    def draw(path: Path) -> object:
        title = f"{costs.sim}: what accuracy costs"
        return importlib.import_module("viz.costs").cost_diagram(costs.cost, path, costs.bins, title)

    return drawn(draw, folder / f"cost_{costs.sim.removeprefix('cost_')}.png")


def _quantity(module: ModuleType, few: Result, exact: Mapping[str, float], asked: str | None) -> str:
    """The name of what is to be priced."""
    with blamed(module):
        found = module.measure(few)
    names = list(found)
    if asked is None:
        chancy = [name for name in names if not found[name].exact] or names
        return next((name for name in chancy if name in exact), chancy[0])
    if asked not in names:
        raise SceneError(f"cost: {name_of(module)} has no quantity {asked!r}; {suggestion(asked, names)}")
    return asked


def _bins(few: Result, run) -> BinsAgainstNoise | None:
    """Of the first detector with bins, along the axis that has the most; run: gives a result of more histories."""
    for meter in few.scene.meters:
        array = _binned(few, meter)
        if isinstance(array, EstimateArray):
            axes = [(bins, dim) for bins, dim in zip(array.shape, array.dims, strict=True) if bins > 3]
            for _, dim in sorted(axes, reverse=True) if np.any(array.value) else ():
                with suppress(SceneError):  # a number of bins that cannot be divided
                    return bins_against_noise(_binned(run(), meter), dim)
    return None


def _binned(result: Result, meter) -> object:
    try:
        return result.quantity(f"{meter.name}.{'irradiance' if meter.directions is None else 'radiance'}")
    except SceneError:  # such as what a way of estimating does not know
        return None
