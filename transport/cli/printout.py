"""Printed output of the commands: menu, checks, runs of experiments, costs."""

from collections import Counter
from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path
from types import ModuleType, SimpleNamespace

from transport.analysis.cost import price_notes
from transport.cli.console import NO_BREAK_SPACE, print_labelled, print_rich, print_to_stderr
from transport.cli.costs import Costs
from transport.cli.run import case_warnings, draw_experiment, is_complete, verdict_on
from transport.cli.tables import bins_table, case_table, cost_table, effect_table, ledger_line
from transport.results.diagnostics.table import CHECKS
from transport.results.record import total_cost
from transport.results.report import cost_lines, method_lines, tracking_lines
from transport.verification.experiment import Outcome, experiment, experiment_name, experiment_names


def print_menu(with_commands: bool = True) -> None:
    """Print the experiments grouped by question."""
    groups: dict[str, list[tuple[str, str]]] = {}
    for name in experiment_names():
        module = experiment(name)
        groups.setdefault(text_of(module, "question"), []).append((name, text_of(module, "law")))
    if with_commands:
        print_rich("transport: Monte Carlo transport and radiometry with standard errors", style="bold")
        print_rich("")
    width = max((len(name) for group in groups.values() for name, _ in group), default=0)
    for question, sims in groups.items():
        print_rich(question, style="bold")
        for name, law in sims:
            print_labelled(f"  {name:{width}}  ", law, style="cyan")
    if with_commands:
        example = next(iter(sims for group in groups.values() for sims, _ in group), "my_experiment.py")
        print_rich("")
        print_rich(
            f"Start with: transport run {example}. Other commands: view, gallery, list, verify, cost,"
            " effects, bench; see transport --help"
        )


def print_checks() -> None:
    """Print the table of checks and diagnostics."""
    for check in CHECKS:
        print_rich(check.name, style="bold")
        print_labelled("  detects  ", check.detects, style="cyan")
        if check.cannot_detect:
            print_labelled("  misses   ", check.cannot_detect, style="cyan")


def print_run(module: ModuleType, pending: Iterable[Outcome]) -> list[Outcome]:
    """Print law and question, table and ledger of each case when it ends, then verdict, cost and warnings."""
    outcomes = []
    for outcome in pending:
        if not outcomes:
            print_rich(experiment_name(module), style="bold")
            for label in filter(partial(text_of, module), ("about", "law", "question")):
                print_labelled(label, text_of(module, label))
        outcomes.append(outcome)
        print_rich("")
        if outcome.title:
            print_rich(outcome.title, style="bold cyan")
        print_rich(case_table(outcome))
        if outcome.bins:
            print_labelled("in bins", f"{bins_line(outcome)}; --json lists them")
        print_labelled("ledger", ledger_line(outcome.result))
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
    for warning in case_warnings(outcomes):
        print_labelled("warning", warning, style="bold yellow")
    return outcomes


def _estimator_lines(outcomes: list[Outcome]) -> Iterator[str]:
    """Yield the estimator of each case, or, if pilots chose for several cases, the cases per estimator."""
    if len(outcomes) == 1 or all(outcome.result.choice is None for outcome in outcomes):
        yield from (line for outcome in outcomes for line in method_lines(outcome.result))
        return
    counts = Counter(outcome.result.plan.method.title for outcome in outcomes)
    choices = "; ".join(f"{title} in {count} of {len(outcomes)} cases" for title, count in counts.items())
    yield f"estimator: chosen by pilots: {choices} (--json gives each)"


def report_unsaved(outcomes: Iterable[Outcome]) -> bool:
    """Return whether all runs were saved; print failures to standard error."""
    lines = dict.fromkeys(line for outcome in outcomes for line in outcome.not_saved)
    for line in lines:
        print_to_stderr(line, style="bold red")
    return not lines


def bins_line(outcome: Outcome) -> str:
    """Return the names of the binned quantities with their axes and numbers of bins."""
    parts = []
    for name, array in outcome.bins.items():
        axes = ", ".join(f"{dim} {bins}" for dim, bins in zip(array.dims, array.shape, strict=True))
        parts.append(f"{name} ({axes})".replace(" ", NO_BREAK_SPACE))
    return ", ".join(parts)


def draw_picture(module: ModuleType, outcomes: list[Outcome], folder: Path, quiet: bool) -> None:
    """Draw the experiment's figures and print their paths unless quiet; print a failure to standard error."""
    print_pictures(*draw_experiment(module, outcomes, folder), quiet)


def print_pictures(paths: list[Path], why: str, quiet: bool) -> None:
    """Print the paths of figures unless quiet, or the reason why there are none to standard error."""
    if not paths:
        print_to_stderr(f"no picture: {why}")
    elif not quiet:
        print_labelled("picture", ", ".join(str(path).replace(" ", NO_BREAK_SPACE) for path in paths))


def print_costs(costs: Costs) -> None:
    """Print prices, noise and blur of bins, and the cost of each effect."""
    title = ", ".join(f"{name}={value}" for name, value in costs.parameters.items())
    print_rich(f"{costs.sim}{': ' if title else ''}{title}", style="bold")
    cost = costs.cost
    value = f"{cost.truth:.7g} {cost.unit}" if isinstance(cost.truth, float) else f"{len(cost.truth)} bins"
    print_labelled("quantity", f"{cost.quantity}, {value}, {cost.truth_is}")
    print_rich("", cost_table(cost))
    for line in price_notes(cost):
        print_labelled("note", line)
    if costs.bins is not None:
        print_rich("", bins_table(costs.bins))
    print_rich("", effect_table(costs.effects))


def text_of(module: ModuleType, name: str) -> str:
    """Return a text of the experiment on one line; empty if it has none."""
    return " ".join(str(getattr(module, name, "")).split())
