"""An experiment from the command line: what it needs, its verdict, its picture, and all of it as data."""

from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from pathlib import Path
from types import ModuleType

from transport.command.verify import row_name, score_of
from transport.experiment import Outcome, blamed, name_of
from transport.results import Cost
from transport.results.estimates import Estimate, EstimateArray
from transport.validation import SceneError

FEW_CASES = 3  # that a warning names

EXTRAS = {"matplotlib": "plot", "pyvista": "viz"}  # what a picture needs -> the extra that brings it
INCOMPLETE = "incomplete: interrupted, so no verdict"


def checked(module: ModuleType) -> ModuleType:
    """The experiment, if it has what a run needs.  Raises SceneError otherwise."""
    missing = [name for name in ("scene", "measure") if not callable(getattr(module, name, None))]
    if missing:
        raise SceneError(
            f"{module.__name__}: no function {' and '.join(missing)}; an experiment is a module that defines it"
        )
    return module


def is_complete(outcomes: list[Outcome]) -> bool:
    """Whether no case was interrupted."""
    return all(outcome.result.is_complete for outcome in outcomes)


def verdict_on(module: ModuleType, outcomes: list[Outcome]) -> str:
    """The answer to the experiment's question, in a sentence."""
    if not is_complete(outcomes):
        return INCOMPLETE
    with blamed(module):
        return module.verdict(outcomes) if hasattr(module, "verdict") else ""


def total_cost(outcomes: list[Outcome]) -> Cost:
    """The cost of all cases together."""
    costs = [outcome.result.cost for outcome in outcomes]
    counted = ("seconds", "preparation", "particles", "crossings", "collisions")
    return Cost(
        threads=costs[0].threads,
        workers=costs[0].workers,
        **{name: sum(getattr(cost, name) for cost in costs) for name in counted},
    )


def picture_of(module: ModuleType, outcomes: list[Outcome], folder: Path) -> tuple[list[Path], str]:
    """Draw the experiment's figures into the folder: their paths, or none and the reason why."""
    if not hasattr(module, "draw"):
        return [], "the experiment draws none"
    with blamed(module):
        return drawn(partial(module.draw, outcomes), folder / f"{name_of(module)}.png")


def drawn(draw: Callable[[Path], object], path: Path) -> tuple[list[Path], str]:
    """Call draw(path), which returns the paths where there are several: the figures' paths, or none and the reason why."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        made = draw(path)
        return list(made) if isinstance(made, list | tuple) and made else [path], ""
    except OSError as error:
        return [], f"cannot write {path}: {error.strerror or error}; say --out FOLDER"
    except Exception as error:
        wanted = (error.name or "").partition(".")[0] if isinstance(error, ImportError) else ""
        if wanted in EXTRAS:
            return [], f"{wanted} is not installed; {pip_install(EXTRAS[wanted])}"
        raise


def pip_install(extra: str) -> str:
    """The command that brings an extra; the package is in no index, so it is run in the clone."""
    return f"pip install '.[{extra}]' in the clone"


def record_of(module: ModuleType, outcomes: list[Outcome]) -> dict[str, object]:
    """{sim, parameters, quantities, ledger, cost, verdict, warnings} for machines; with `bins` where there are such.

    Where the experiment has several cases, parameters and the ledger's values and errors are lists with one entry a
    case, quantities have the case in front of their names, and the cost is that of all.
    """
    one = len(outcomes) == 1
    quantities = [
        {
            "name": row_name(outcome, row.name, len(outcomes)),
            **numbers_of(row.estimate),
            "exact": row.exact,
            "z": score_of(row.estimate, row.exact),
        }
        for outcome in outcomes
        for row in outcome.rows
    ]
    names = dict.fromkeys(name for outcome in outcomes for name in outcome.parameters)
    parameters = {name: _one_or_all(one, [o.parameters.get(name) for o in outcomes]) for name in names}
    ledgers = [outcome.result._own_ledger for outcome in outcomes]
    ledger = {
        name: {
            "value": _one_or_all(one, [ledger[name].value for ledger in ledgers]),
            "error": _one_or_all(one, [ledger[name].error for ledger in ledgers]),
            "unit": str(ledgers[0][name].unit),
        }
        for name in ledgers[0]
    }
    bins = [
        bins_record(row_name(outcome, name, len(outcomes)), array)
        for outcome in outcomes
        for name, array in outcome.bins.items()
    ]
    cost = total_cost(outcomes)
    rates = {"particles_per_second": cost.particles_per_second, "next_digit": cost.next_digit}
    return {
        "sim": name_of(module),
        "parameters": parameters,
        "quantities": quantities,
        **({"bins": bins} if bins else {}),
        "ledger": ledger,
        "cost": asdict(cost) | rates,
        "verdict": verdict_on(module, outcomes),
        "warnings": warnings_of(outcomes),
        "method": _one_or_all(one, [_method(outcome.result) for outcome in outcomes]),
    }


def bins_record(name: str, array: EstimateArray) -> dict[str, object]:
    """What was measured over bins: nested lists with an axis for each of dims, whose edges coords hold."""
    coords = {dim: edges.tolist() for dim, edges in array.coords.items()}
    numbers = {"value": array.value.tolist(), "error": array.error.tolist(), "unit": str(array.unit)}
    doubtful = {"doubtful": array.is_doubtful.tolist()}
    return {"name": name, "dims": array.dims, "coords": coords, **numbers, **doubtful}


def _method(result) -> dict[str, object]:
    """What repeats a run, beside its parameters and particles."""
    method = result.plan.method
    return {"estimator": method.estimator, "sampling": method.sampling, "seed": result.seed}


def numbers_of(estimate: Estimate) -> dict[str, object]:
    """An estimate for machines, with its verdict and findings."""
    told = [finding.record() for finding in estimate.findings]
    numbers = {"value": estimate.value, "error": estimate.error, "unit": str(estimate.unit)}
    return numbers | {"verdict": estimate.verdict, "findings": told}


def _one_or_all(one: bool, values: list[object]) -> object:
    return values[0] if one else values


def warnings_of(outcomes: list[Outcome]) -> list[str]:
    """Each warning once, with the cases that it is about in front where there are several cases."""
    cases: dict[str, list[str]] = {}
    for outcome in outcomes:
        for warning in outcome.warnings:
            cases.setdefault(warning, []).append(outcome.title)
    if len(outcomes) == 1:
        return list(cases)
    return [f"{_whose(titles, len(outcomes))}: {warning}" for warning, titles in cases.items()]


def _whose(titles: list[str], cases: int) -> str:
    """The cases that a warning is about: by name, or where they are many by number."""
    if len(titles) == cases:
        return "all cases"
    return "; ".join(titles) if len(titles) <= FEW_CASES else f"{len(titles)} of {cases} cases"
