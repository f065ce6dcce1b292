"""An experiment from the command line: its cases one after the other, its picture, and all of it as data."""

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from types import ModuleType

from transport.estimates import Estimate
from transport.experiment import Outcome, Row, cases_of
from transport.results import Cost
from transport.scene import Scene
from transport.simulate import simulate
from transport.units import UnitError
from transport.validation import SceneError
from transport.verify import row_name

PARTICLES = 1_000_000  # histories of a case where neither the experiment nor the user says how many
INCOMPLETE = "incomplete: interrupted, so no verdict"


def checked(module: ModuleType) -> ModuleType:
    """The experiment, if it has what a run needs.  Raises SceneError otherwise."""
    missing = [name for name in ("scene", "measure", "exact") if not callable(getattr(module, name, None))]
    if missing:
        raise SceneError(
            f"{module.__name__}: no function {' and '.join(missing)}; an experiment is a module that defines it"
        )
    return module


def outcomes_of(
    module: ModuleType, settings: dict[str, object], limits: dict[str, object]
) -> Iterator[Outcome]:
    """Each case of the experiment as soon as it is done; the last one is incomplete after Ctrl-C.

    limits: as for `simulate`; where none is given, as many particles as the module says.
    """
    if all(limits.get(name) is None for name in ("particles", "error", "seconds")):
        limits = limits | {"particles": getattr(module, "particles", PARTICLES)}
    for parameters in cases_of(module, settings):
        scene, exact = asked(module, parameters, settings)
        result = simulate(scene, **limits)
        rows = tuple(Row(name, estimate, exact[name]) for name, estimate in module.measure(result).items())
        yield Outcome(parameters, result, rows)
        if not result.is_complete:
            return


def asked(
    module: ModuleType, parameters: dict[str, object], settings: dict[str, object]
) -> tuple[Scene, dict[str, float]]:
    """The scene and the exact values of these parameters.  Raises SceneError for settings that they cannot work with."""
    try:
        return module.scene(**parameters), module.exact(**parameters)
    except (TypeError, ValueError, ArithmeticError) as error:
        if isinstance(error, (SceneError, UnitError)) or not settings:
            raise
        said = ", ".join(f"{name}={value!r}" for name, value in settings.items())
        raise SceneError(f"{name_of(module)}: cannot work with {said}: {error}") from error


def is_complete(outcomes: list[Outcome]) -> bool:
    """Whether no case was interrupted."""
    return all(outcome.result.is_complete for outcome in outcomes)


def verdict_on(module: ModuleType, outcomes: list[Outcome]) -> str:
    """The answer to the experiment's question, in a sentence."""
    if not is_complete(outcomes):
        return INCOMPLETE
    return module.verdict(outcomes) if hasattr(module, "verdict") else ""


def total_cost(outcomes: list[Outcome]) -> Cost:
    """The cost of all cases together."""
    costs = [outcome.result.cost for outcome in outcomes]
    counted = ("seconds", "preparation", "particles", "crossings", "collisions")
    return Cost(
        threads=costs[0].threads, **{name: sum(getattr(cost, name) for cost in costs) for name in counted}
    )


def picture_of(module: ModuleType, outcomes: list[Outcome], folder: Path) -> tuple[list[Path], str]:
    """Draw the experiment's figures into the folder: their paths, or none and the reason why."""
    if not hasattr(module, "draw"):
        return [], "the experiment draws none"
    path = folder / f"{name_of(module)}.png"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        paths = module.draw(outcomes, path) or [path]
    except ImportError as error:
        wanted = (error.name or "").partition(".")[0]
        if wanted not in ("matplotlib", "pyvista"):
            raise
        extra = {"matplotlib": "plot", "pyvista": "viz"}[wanted]
        return [], f"{wanted} is not installed; pip install 'transport[{extra}]'"
    except OSError as error:
        return [], f"cannot write {path}: {error.strerror or error}; say --out FOLDER"
    return paths, ""


def name_of(module: ModuleType) -> str:
    """The experiment's name, as `run` takes it."""
    return module.__name__.removeprefix("sims.")


def record_of(module: ModuleType, outcomes: list[Outcome]) -> dict[str, object]:
    """{sim, parameters, quantities, ledger, cost, verdict} for machines.

    Where the experiment has several cases, parameters and the ledger's values and errors are lists with one entry a
    case, quantities have the case in front of their names, and the cost is that of all.
    """
    one = len(outcomes) == 1
    quantities = [
        {
            "name": row_name(outcome, row.name, len(outcomes)),
            **_numbers(row.estimate),
            "exact": row.exact,
            "z": row.z,
        }
        for outcome in outcomes
        for row in outcome.rows
    ]
    names = dict.fromkeys(name for outcome in outcomes for name in outcome.parameters)
    parameters = {name: _one_or_all(one, [o.parameters.get(name) for o in outcomes]) for name in names}
    ledgers = [outcome.result.ledger for outcome in outcomes]
    ledger = {
        name: {
            "value": _one_or_all(one, [ledger[name].value for ledger in ledgers]),
            "error": _one_or_all(one, [ledger[name].error for ledger in ledgers]),
            "unit": str(ledgers[0][name].unit),
        }
        for name in ledgers[0]
    }
    cost = total_cost(outcomes)
    rates = {"particles_per_second": cost.particles_per_second, "next_digit": cost.next_digit}
    return {
        "sim": name_of(module),
        "parameters": parameters,
        "quantities": quantities,
        "ledger": ledger,
        "cost": asdict(cost) | rates,
        "verdict": verdict_on(module, outcomes),
    }


def _numbers(estimate: Estimate) -> dict[str, object]:
    return {"value": estimate.value, "error": estimate.error, "unit": str(estimate.unit)}


def _one_or_all(one: bool, values: list[object]) -> object:
    return values[0] if one else values
