"""An experiment on the command line: requirements, verdict, picture, and a run as text and JSON."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict
from functools import partial
from pathlib import Path
from types import ModuleType, SimpleNamespace

from rich.table import Table
from rich.text import Text

from transport.analysis.effects import Treatment, treatment_of
from transport.cli.laws import row_name, z_score
from transport.cli.output import (
    NO_BREAK_SPACE,
    estimate_cell,
    exact_cell,
    print_labelled,
    print_rich,
    print_to_stderr,
    table_of,
    unit_cell,
    z_cell,
)
from transport.results.record import total_cost
from transport.results.report import cost_lines, method_lines, tracking_lines
from transport.results.result import Result
from transport.scene.scene import Scene
from transport.statistics.estimates import Estimate, EstimateArray
from transport.validation import SceneError, join_names, missing_package
from transport.verification.experiment import (
    Outcome,
    Row,
    attribute_errors,
    experiment_name,
    parameter_unit,
    run_settings_of,
)

MAX_NAMED_CASES = 3  # largest number of cases that a warning names

INCOMPLETE = "incomplete: interrupted, so no verdict"


def checked_experiment(module: ModuleType) -> ModuleType:
    """Return the experiment.  Raises SceneError if it lacks scene() or measure()."""
    missing = [name for name in ("scene", "measure") if not callable(getattr(module, name, None))]
    if missing:
        raise SceneError(
            f"{module.__name__}: no function {' and '.join(missing)}; an experiment module must define it"
        )
    return module


def experiment_treatment(module: ModuleType, scene: Scene) -> Treatment:
    """Return the treatment of a scene with the default settings of its experiment."""
    return treatment_of(scene, **run_settings_of(module))


def text_of(module: ModuleType, name: str) -> str:
    """Return a text of the experiment on one line; empty if it has none."""
    return " ".join(str(getattr(module, name, "")).split())


def is_complete(outcomes: list[Outcome]) -> bool:
    """Return whether no case was interrupted."""
    return all(outcome.result.is_complete for outcome in outcomes)


def verdict_on(module: ModuleType, outcomes: list[Outcome]) -> str:
    """Return the experiment's verdict, or a note that the run is incomplete."""
    if not is_complete(outcomes):
        return INCOMPLETE
    with attribute_errors(module):
        return module.verdict(outcomes) if hasattr(module, "verdict") else ""


def draw_experiment(module: ModuleType, outcomes: list[Outcome], folder: Path) -> tuple[list[Path], str]:
    """Draw the experiment's figures into the folder; return their paths, or an empty list and the reason."""
    if not hasattr(module, "draw"):
        return [], "the experiment has no draw()"
    with attribute_errors(module):
        return draw_to(partial(module.draw, outcomes), folder / f"{experiment_name(module)}.png")


def draw_sweep(
    module: ModuleType, outcomes: list[Outcome], name: str, values: list[object], path: Path
) -> tuple[list[Path], str]:
    """Draw each quantity against a parameter.

    Returns the path and which quantities are left out, or an empty list and the reason.
    """
    if not all(isinstance(value, int | float) for value in values):
        return [], f"{name} has no numbers to draw against"
    names = dict.fromkeys(row.name for outcome in outcomes for row in outcome.rows)
    common = [each for each in names if all(each in outcome for outcome in outcomes)]
    others = join_names([repr(each) for each in names if each not in common], most=2)
    if not common:
        return [], f"no quantity has the same name at all values of {name}"
    left_out = f"Only some values of {name} have {others}, which the picture leaves out." if others else ""

    def draw(path: Path) -> None:
        from transport.viz.curves import plot_sweep
        from transport.viz.style import with_unit

        rows = {each: [outcome[each] for outcome in outcomes] for each in common}
        series = {
            each: ([row.estimate for row in found], [row.exact for row in found])
            for each, found in rows.items()
        }
        xlabel = with_unit(name, parameter_unit(module, name))
        plot_sweep(values, series, path, xlabel, experiment_name(module), left_out)

    paths, why = draw_to(draw, path)
    return paths, why or left_out


def draw_to(draw: Callable[[Path], object], path: Path) -> tuple[list[Path], str]:
    """Call draw(path), which may return several paths; return the paths, or [] and the reason."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        made = draw(path)
        return list(made) if isinstance(made, list | tuple) and made else [path], ""
    except OSError as error:
        return [], f"cannot write {path}: {error.strerror or error}; pass another --out FOLDER"
    except Exception as error:
        lack = missing_package(error) if isinstance(error, ImportError) else None
        if lack is None:
            raise
        return [], lack


# ---- A run as text.


def print_run(module: ModuleType, pending: Iterable[Outcome], is_verbose: bool = False) -> list[Outcome]:
    """Print law and question, a table of all cases, then verdict, cost and warnings.

    is_verbose: a table and the ledger of each case when it ends, as of a single case.
    """
    outcomes = []
    for outcome in pending:
        if not outcomes:
            print_rich(experiment_name(module), style="bold")
            for label in filter(partial(text_of, module), ("about", "law", "question")):
                print_labelled(label, text_of(module, label))
        outcomes.append(outcome)
        if is_verbose:
            _print_case(outcome)
    if len(outcomes) == 1 and not is_verbose:
        _print_case(outcomes[0])
    elif not is_verbose:
        print_rich("")
        print_rich(summary_table(outcomes))
        for line in dict.fromkeys(bins_line(outcome) for outcome in outcomes if outcome.bins):
            print_labelled("in bins", f"{line}; --json lists them")
    print_rich("")
    is_whole = is_complete(outcomes)
    if verdict := verdict_on(module, outcomes):
        print_labelled("verdict", verdict, style="bold" if is_whole else "bold red")
    lines = dict.fromkeys(
        (*_estimator_lines(outcomes), *(line for o in outcomes for line in tracking_lines(o.result)))
    )
    kept = sum(outcome.result.particles for outcome in outcomes)
    whole = SimpleNamespace(cost=total_cost([outcome.result.cost for outcome in outcomes]), particles=kept)
    for line in (*lines, *cost_lines(whole)):
        label, _, text = line.partition(": ")
        print_labelled(label, text)
    for reason in intentions(outcomes):
        print_labelled("note", reason)
    for warning in case_warnings(outcomes):
        print_labelled("warning", warning, style="bold yellow")
    return outcomes


def _print_case(outcome: Outcome) -> None:
    """Print the table and the ledger of a case."""
    print_rich("")
    if outcome.title:
        print_rich(outcome.title, style="bold cyan")
    print_rich(case_table(outcome))
    if outcome.bins:
        print_labelled("in bins", f"{bins_line(outcome)}; --json lists them")
    print_labelled("ledger", ledger_line(outcome.result))


def _estimator_lines(outcomes: list[Outcome]) -> Iterator[str]:
    """Yield the estimator of each case, or, if pilots chose for several cases, the cases per estimator."""
    if len(outcomes) == 1 or all(outcome.result.choice is None for outcome in outcomes):
        yield from (line for outcome in outcomes for line in method_lines(outcome.result))
        return
    counts = Counter(outcome.result.plan.method.title for outcome in outcomes)
    choices = "; ".join(f"{title} in {count} of {len(outcomes)} cases" for title, count in counts.items())
    yield f"estimator: chosen by pilots: {choices} (--json gives each)"


def case_table(outcome: Outcome) -> Table:
    """Return a table of estimates ± one standard error, with exact values and z if any is known."""
    return _table([outcome], has_cases=False)


def summary_table(outcomes: list[Outcome]) -> Table:
    """Return one table of the estimates of several cases."""
    return _table(outcomes, has_cases=True)


def _table(outcomes: list[Outcome], has_cases: bool) -> Table:
    is_judged = not all(math.isnan(row.exact) for outcome in outcomes for row in outcome.rows)

    def cells(case: str, row: Row) -> Iterator[str | Text]:
        yield from (case,) if has_cases else ()
        yield from (row.name, estimate_cell(row.estimate), unit_cell(row.estimate))
        if is_judged:
            yield from (exact_cell(row.exact, row.estimate), z_cell(z_score(row.estimate, row.exact)))

    judged = ("exact>", "z>") if is_judged else ()
    heads = (*(("case~",) if has_cases else ()), "quantity~", "estimate ± error>", "unit", *judged)
    rows = [
        cells(outcome.title if place == 0 else "", row)
        for outcome in outcomes
        for place, row in enumerate(outcome.rows)
    ]
    return table_of(heads, rows)


def ledger_line(result: Result) -> str:
    """Return "emitted 100 W (exact) = absorbed ... + escaped ..." without entries that are exactly zero.

    Spaces within an entry do not break, so that lines wrap between entries.
    """
    emitted, *parts = (
        f"{name} {estimate}".replace(" ", NO_BREAK_SPACE)
        for name, estimate in result._own_ledger.items()
        if name == "emitted" or not (estimate.exact and estimate.value == 0)
    )
    return f"{emitted} = {f' +{NO_BREAK_SPACE}'.join(parts) or 0}"


def bins_line(outcome: Outcome) -> str:
    """Return the names of the binned quantities with their axes and numbers of bins."""
    parts = []
    for name, array in outcome.bins.items():
        axes = ", ".join(f"{dim} {bins}" for dim, bins in zip(array.dims, array.shape, strict=True))
        parts.append(f"{name} ({axes})".replace(" ", NO_BREAK_SPACE))
    return ", ".join(parts)


def report_unsaved(outcomes: Iterable[Outcome]) -> bool:
    """Return whether all runs were saved; print failures to standard error."""
    lines = dict.fromkeys(line for outcome in outcomes for line in outcome.not_saved)
    for line in lines:
        print_to_stderr(line, style="bold red")
    return not lines


# ---- A run as JSON.


def outcomes_record(module: ModuleType, outcomes: list[Outcome]) -> dict[str, object]:
    """Return the outcomes for JSON: {sim, parameters, quantities, [bins,] ledger, cost, ..., method}.

    With several cases, parameters and the ledger's values and errors are lists with one entry per case, names
    of quantities start with the case, and the cost is the sum.
    """
    one = len(outcomes) == 1
    quantities = [
        {
            "name": row_name(outcome, row.name, len(outcomes)),
            **estimate_record(row.estimate),
            "exact": row.exact,
            "z": z_score(row.estimate, row.exact),
        }
        for outcome in outcomes
        for row in outcome.rows
    ]
    names = dict.fromkeys(name for outcome in outcomes for name in outcome.parameters)
    parameters = {name: _one_or_all(one, [o.parameters.get(name) for o in outcomes]) for name in names}
    ledgers = [outcome.result._own_ledger for outcome in outcomes]
    ledger = {}
    for name, entry in ledgers[0].items():
        ledger[name] = {"unit": str(entry.unit)}
        for key in ("value", "error"):
            ledger[name][key] = _one_or_all(one, [getattr(each[name], key) for each in ledgers])
    bins = [
        bins_record(row_name(outcome, name, len(outcomes)), array)
        for outcome in outcomes
        for name, array in outcome.bins.items()
    ]
    cost = total_cost([outcome.result.cost for outcome in outcomes])
    rates = {"particles_per_second": cost.particles_per_second, "next_digit": cost.next_digit}
    return {
        "sim": experiment_name(module),
        "parameters": parameters,
        "quantities": quantities,
        **({"bins": bins} if bins else {}),
        "ledger": ledger,
        "cost": asdict(cost) | rates,
        "verdict": verdict_on(module, outcomes),
        "warnings": case_warnings(outcomes),
        "notes": intentions(outcomes),
        "method": _one_or_all(one, [_method(outcome.result) for outcome in outcomes]),
    }


def bins_record(name: str, array: EstimateArray) -> dict[str, object]:
    """Return a binned quantity for JSON: nested lists with one axis per dim, and bin edges in coords."""
    coords = {dim: edges.tolist() for dim, edges in array.coords.items()}
    numbers = {"value": array.value.tolist(), "error": array.error.tolist(), "unit": str(array.unit)}
    doubtful = {"doubtful": array.is_doubtful.tolist()}
    return {"name": name, "dims": array.dims, "coords": coords, **numbers, **doubtful}


def _method(result) -> dict[str, object]:
    """Return the settings that, with parameters and particles, repeat a run."""
    return asdict(result.plan.method) | {"seed": result.seed}


def estimate_record(estimate: Estimate) -> dict[str, object]:
    """Return an estimate for JSON, with its verdict and findings."""
    findings = [finding.record() for finding in estimate.findings]
    return number_record(estimate) | {"verdict": estimate.verdict, "findings": findings}


def number_record(estimate: Estimate) -> dict[str, object]:
    """Return value, error and unit of an estimate for JSON."""
    return {"value": estimate.value, "error": estimate.error, "unit": str(estimate.unit)}


def _one_or_all(one: bool, values: list[object]) -> object:
    return values[0] if one else values


def intentions(outcomes: list[Outcome]) -> list[str]:
    """Return each reason why a diagnostic finds what the experiment intends once."""
    return list(dict.fromkeys(reason for outcome in outcomes for reason in outcome.intentions))


def case_warnings(outcomes: list[Outcome]) -> list[str]:
    """Return each warning once, preceded by its cases if there are several cases."""
    cases: dict[str, list[str]] = {}
    for outcome in outcomes:
        for warning in outcome.warnings:
            cases.setdefault(warning, []).append(outcome.title)
    if len(outcomes) == 1:
        return list(cases)
    return [f"{_case_names(titles, len(outcomes))}: {warning}" for warning, titles in cases.items()]


def _case_names(titles: list[str], cases: int) -> str:
    """Return the cases of a warning: their names, or their number if there are many."""
    if len(titles) == cases:
        return "all cases"
    return "; ".join(titles) if len(titles) <= MAX_NAMED_CASES else f"{len(titles)} of {cases} cases"
