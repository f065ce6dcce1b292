"""`transport verify --long`: every law with many particles, and every hard case, in one table.

Two pilot runs of each experiment estimate the time before it starts.
"""

import math
import signal
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import groupby
from types import ModuleType

import numpy as np
from rich.table import Table
from rich.text import Text

from transport.cli.laws import (
    FAILS,
    HOLDS,
    IS_WEAK,
    LAWS_FALSE_ALARM,
    POWER,
    WEAK,
    WITHOUT_SCORE,
    Law,
    laws_of,
)
from transport.cli.output import (
    estimate_cell,
    exact_cell,
    exit_status,
    print_json,
    print_rich,
    print_to_stderr,
    state_cell,
    table_of,
    unit_cell,
    z_cell,
)
from transport.cli.run import checked_experiment, is_complete
from transport.results.record import Cost, total_cost
from transport.run.settings import MAX_PARTICLES, checked_integer
from transport.statistics.estimates import Estimate
from transport.statistics.notation import duration
from transport.validation import SceneError
from transport.verification.experiment import (
    Outcome,
    experiment,
    experiment_name,
    experiment_names,
    iterate_outcomes,
)
from transport.verification.hard.cases import FALSE_ALARM, Case, CaseResult, cases_of, families, family_title

# ---- `transport verify --hard`: one table per family of hard cases, compared with the naive formula.

ALIKE = 0.99  # correlation of the batches of two rows above which they are one check
HARD_NOTE = """off: in standard errors if signed, else a relative difference, with its tolerance beyond
rounding; –: the naive formula gives no number, because its particle is lost or its loop never ends;
a case in other units or at another place uses the random numbers of the plain case; --json explains why each
case is hard"""


@dataclass(frozen=True)
class JudgedCase:
    """A case with its outcome, judged at the false-alarm rate `rate`."""

    case: Case
    seen: CaseResult
    rate: float

    @property
    def holds(self) -> bool:
        """Whether the case agrees with its exact value at the rate `rate` of false alarms."""
        return self.seen.holds(self.rate)

    @property
    def record(self) -> dict[str, object]:
        """All values as one dictionary for JSON."""
        case, seen = self.case, self.seen
        error = seen.found.error if isinstance(seen.found, Estimate) else 0.0
        return {
            "family": case.family,
            "case": case.title,
            "reason": case.reason,
            "value": seen.value,
            "error": error,
            "exact": seen.exact,
            "off": seen.off,
            "naive": case.naive,
            "naive_value": seen.naive,
            "holds": self.holds,
        }


def verify_hard(families: list[str] | None, json: bool) -> int:
    """Run and print the cases of these families, or of all.

    Returns status 1 if one fails, 130 if interrupted.
    """
    cases, found = list(cases_of(families)), []
    for family, rows in groupby(judge_cases(cases), key=lambda row: row.case.family):
        found += (of_family := list(rows))
        if not json:
            print_rich(Text(family_title(family), "bold"), hard_table(of_family), "")
    if not found:
        raise KeyboardInterrupt
    failed = sum(not row.holds for row in found)
    if json:
        print_json([row.record for row in found])
    else:
        _print_number(failed, len(found), "hard cases")
        print_rich(HARD_NOTE)
    return exit_status(failed, complete=len(found) == len(cases))


def _print_number(failed: int, number: int, what: str, unscored: int = 0) -> None:
    """Print how many rows or cases hold, in green if none fails, and how many are 0 without a score."""
    line = f"{number - failed - unscored} of {number} {what} hold"
    line += f", {unscored} {'has' if unscored == 1 else 'have'} no score, as expected" if unscored else ""
    print_rich(line, style="bold red" if failed else "bold green")


def judge_cases(cases: list[Case], others: int = 0) -> Iterator[JudgedCase]:
    """Run the cases until Ctrl-C and yield each outcome; `others` more rows share the false-alarm rate."""
    with suppress(KeyboardInterrupt):
        for case in cases:
            yield JudgedCase(case, _run_case(case), FALSE_ALARM / (len(cases) + others))


def _run_case(case: Case) -> CaseResult:
    """Run a case.  Raises KeyboardInterrupt after Ctrl-C, even if a run inside the case handled it."""
    came, usual = [], signal.getsignal(signal.SIGINT)
    if usual is signal.SIG_IGN:  # as under nohup
        return case.run()

    def note(*_: object) -> None:
        came.append(True)
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, note)
    try:
        seen = case.run()
    finally:
        signal.signal(signal.SIGINT, usual)
    if came:
        raise KeyboardInterrupt
    return seen


def hard_table(rows: list[JudgedCase]) -> Table:
    """Return a table of found, exact and naive values."""
    return table_of(["case~", "found>", "exact>", "off>", "naive formula~", "gives>", ""], map(_cells, rows))


def _cells(row: JudgedCase) -> tuple[str | Text, ...]:
    seen = row.seen
    found = estimate_cell(seen.found) if seen.is_noisy else f"{seen.value:.7g}"
    off = z_cell(seen.off) if seen.is_noisy else Text(_difference_text(seen))
    numbers = found, f"{seen.exact:.7g}", off
    return row.case.title, *numbers, row.case.naive, _naive_text(seen), state_cell(row.holds)


def _difference_text(seen: CaseResult) -> str:
    """Return the relative difference of a number without error, and its tolerance beyond rounding."""
    allowed = f" < {seen.within:.2g}" if seen.within > 1e-6 else ""
    return f"{seen.off:.1e}{allowed}" if seen.off else "0"


def _naive_text(seen: CaseResult) -> str:
    if seen.naive is None:
        return "–"
    if math.isnan(seen.naive):
        return "NaN"
    short = f"{seen.naive:.4g}"
    return short if float(short) != float(f"{seen.exact:.4g}") else f"{seen.naive:.9g}"


# ---- `transport verify`: runs experiments and judges their laws together.


def verify_laws(sims: list[str] | None, limits: dict[str, object], json: bool) -> int:
    """Run these experiments, or all, and print their laws.

    Returns status 1 if one fails, 130 if interrupted.
    """
    laws, complete = [], True
    for module in experiment_modules(sims):
        outcomes, complete = run_until_interrupt(module, limits)
        laws += laws_of(module, outcomes)
        if not complete:
            break
    require_laws(laws, complete)
    rate = LAWS_FALSE_ALARM / len(laws)
    failed = sum(not law.holds(rate) for law in laws)
    if json:
        print_json([law_record(law, rate) for law in laws])
    else:
        print_rich(*law_tables(laws, rate))
        _print_number(failed, len(laws), "rows", _unscored(laws, rate))
        print_rich(
            weak_line(laws, rate),
            f"independent checks: {independent_checks(laws)}, rows with noise of their own;"
            f" false alarms: {LAWS_FALSE_ALARM:g} over all rows; smallest bias: relative, detected with"
            f" {POWER:.0%} power",
        )
    return exit_status(failed, complete)


def _unscored(laws: list[Law], rate: float) -> int:
    return sum(law.state(rate) == WITHOUT_SCORE for law in laws)


def weak_line(laws: list[Law], rate: float) -> str:
    """Return how many rows are weak, and what the bias of a row of χ² is."""
    weak = sum(law.state(rate) == IS_WEAK for law in laws)
    shapes = sum(law.is_of_shape for law in laws)
    line = f"weak: {weak} of {len(laws)} rows hold even with a bias of {WEAK:.0%}, so they show little"
    rows = "1 row compares a shape: its bias" if shapes == 1 else f"{shapes} rows compare shapes: their bias"
    return f"{line}; {rows} is of χ², not of a law" if shapes else line


def independent_checks(laws: list[Law]) -> int:
    """Return how many rows have noise of their own.

    Rows of one run that divide the same count by different numbers have batches that are proportional: they
    are one check. So is none that has no error.
    """
    kept: dict[int, list[np.ndarray]] = defaultdict(list)
    for law in laws:
        if math.isfinite(law.z) and law.estimate.error > 0:
            values = law.estimate.values - law.estimate.values.mean()
            unit = values / np.linalg.norm(values)
            known = kept[id(law.estimate.run)]
            if not any(abs(unit @ other) > ALIKE for other in known):
                known.append(unit)
    return sum(map(len, kept.values()))


def experiment_modules(sims: list[str] | None) -> list[ModuleType]:
    """Return these experiments, or all.  Raises SceneError for an unknown name before anything runs.

    A name of both an experiment and a family of hard cases, such as directions, is the experiment.
    """
    known = experiment_names()
    for name in sims or ():
        if name in families() and name not in known:
            raise SceneError(
                f"verify: {name!r} is a family of hard cases, not an experiment;"
                f" write transport verify --hard {name}"
            )
    return [checked_experiment(experiment(name)) for name in sims or known]


def run_until_interrupt(module: ModuleType, limits: dict[str, object]) -> tuple[list[Outcome], bool]:
    """Run the experiment's cases until Ctrl-C; return the outcomes so far, and whether they are complete."""
    outcomes = []
    try:
        for outcome in iterate_outcomes(module, {}, limits):
            outcomes.append(outcome)
    except KeyboardInterrupt:
        return outcomes, False
    return outcomes, is_complete(outcomes)


def require_laws(laws: list[Law], complete: bool) -> None:
    """Raise SceneError if there are no laws, KeyboardInterrupt if interrupted before the first."""
    if laws:
        return
    if not complete:
        raise KeyboardInterrupt
    raise SceneError("verify: nothing to judge; name an experiment or .py file with exact values")


def law_record(law: Law, rate: float) -> dict[str, object]:
    """Return a row for JSON; `rate` is the false-alarm rate of the test."""
    return {
        "law": law.law,
        "source": law.source,
        "sim": law.sim,
        "quantity": law.quantity,
        "value": law.estimate.value,
        "error": law.estimate.error,
        "unit": str(law.estimate.unit),
        "exact": law.exact,
        "z": law.z,
        "smallest_bias": law.smallest_bias(rate),
        "holds": None if law.state(rate) == WITHOUT_SCORE else law.holds(rate),
        "state": law.state(rate).lower(),
    }


def law_tables(laws: list[Law], false_alarm: float) -> Iterator[Text | Table]:
    """Yield for each law a title (formula, source, experiment) and a table of its rows."""
    for (sim, law, source), group in groupby(laws, key=lambda law: (law.sim, law.law, law.source)):
        yield Text.assemble((law, "bold"), f" ({source}) " if source else " ", (sim, "cyan"))
        heads = "quantity~", "estimate ± error>", "unit", "exact>", "z>", "smallest bias>", ""
        yield table_of(heads, (_law_cells(row, false_alarm) for row in group))
        yield Text()


def _law_cells(law: Law, false_alarm: float) -> tuple[str | Text, ...]:
    """Return the cells of a law's row."""
    unit, exact = unit_cell(law.estimate), exact_cell(law.exact, law.estimate)
    bias = bias_text(law.smallest_bias(false_alarm), law.exact, unit)
    bias += " of χ²" if law.is_of_shape else ""
    numbers = estimate_cell(law.estimate), unit, exact, z_cell(law.z), bias
    state = law.state(false_alarm)
    is_plain = state in (HOLDS, FAILS)
    return law.quantity, *numbers, state_cell(state == HOLDS) if is_plain else Text(state, "yellow")


def bias_text(bias: float, exact: float, unit: str) -> str:
    """Return a relative bias in percent or as a number; with its unit if the exact value is 0."""
    if math.isnan(bias):
        return "unknown"
    if bias == 0:
        return "any"
    if exact == 0:
        return f"{bias:.1e} {unit}".strip()
    return f"{100 * bias:.2g} %" if 1e-5 <= bias < 10 else f"{bias:.1e}"


# ---- `transport verify --long`.

PROGRESS = "cyan"  # style of lines on standard error, apart from the results
DEFAULT_PARTICLES = 100_000_000  # histories per case by default
PILOT_FRACTIONS = 1000, 250  # the two pilots run these fractions (1/1000, 1/250) of the histories ...
MIN_PILOT_PARTICLES = 50_000, 200_000  # ... but at least so many, because start-up takes time too

LONG_NOTE = f"""false alarms: {LAWS_FALSE_ALARM:g} over all rows and cases; farthest: largest deviation
in standard errors; bias caught: median over the rows of the smallest relative bias detected with
{POWER:.0%} power; --json lists every row"""


@dataclass(frozen=True)
class ExperimentLaws:
    """Laws of one experiment, and its time [s]."""

    name: str
    cases: int
    laws: tuple[Law, ...]
    seconds: float


def verify_long(sims: list[str] | None, limits: dict[str, object], json: bool) -> int:
    """Run these experiments, or all experiments and hard cases.

    Returns status 1 if one fails, 130 if interrupted.
    """
    particles = DEFAULT_PARTICLES if limits["particles"] is None else limits["particles"]
    checked_integer("particles", particles, 1, MAX_PARTICLES * 100)
    modules, cases = experiment_modules(sims), [] if sims else list(cases_of())
    print_to_stderr("running pilots to estimate the time", PROGRESS)
    foreseen = [_estimate_seconds(module, limits, particles) for module in modules]
    print_to_stderr(
        f"experiments: {len(modules)}, with {particles:.3g} particles per case; hard cases: {len(cases)};"
        f" about {duration(sum(foreseen))} by the pilots; Ctrl-C stops and prints the finished rows",
        PROGRESS,
    )
    begun = time.perf_counter()
    parts, complete = _run_experiments(modules, limits | {"particles": particles}, foreseen)
    laws = [law for part in parts for law in part.laws]
    found = list(judge_cases(cases, others=len(laws))) if complete else []
    complete = complete and len(found) == len(cases)
    require_laws([*laws, *found], complete)
    took, rate = time.perf_counter() - begun, LAWS_FALSE_ALARM / (len(laws) + len(found))
    failed = sum(not law.holds(rate) for law in laws) + sum(not row.holds for row in found)
    if json:
        rows = [law_record(law, rate) for law in laws]
        times = {"particles": particles, "foreseen_seconds": sum(foreseen), "seconds": took}
        print_json(times | {"laws": rows, "hard": [row.record for row in found]})
    else:
        _print_table(parts, found, rate)
        _print_number(failed, len(laws) + len(found), "rows and hard cases", _unscored(laws, rate))
        print_rich(
            weak_line(laws, rate),
            LONG_NOTE,
            f"{duration(took)}, estimated {duration(sum(foreseen))}; {particles:.3g} particles per case",
        )
    return exit_status(failed, complete)


def _estimate_seconds(module: ModuleType, limits: dict[str, object], particles: int) -> float:
    """Estimate the seconds of an experiment from a line through two pilots; compilation is not counted."""
    sizes = [
        min(particles, max(particles // share, least))
        for share, least in zip(PILOT_FRACTIONS, MIN_PILOT_PARTICLES, strict=True)
    ]
    few, more = (_pilot(module, limits, size) for size in sizes)
    slope = (more.seconds - few.seconds) / max(1, more.particles - few.particles)
    if slope <= 0:  # noise; a proportional time is an upper estimate
        slope = more.seconds / more.particles
    return more.seconds + slope * more.particles * (particles / sizes[1] - 1)


def _pilot(module: ModuleType, limits: dict[str, object], particles: int) -> Cost:
    """Run all cases with this many particles each and return their total cost."""
    outcomes, complete = run_until_interrupt(module, limits | {"particles": particles})
    if not complete:
        raise KeyboardInterrupt
    return total_cost([outcome.result.cost for outcome in outcomes])


def _run_experiments(
    modules: list[ModuleType], limits: dict[str, object], foreseen: list[float]
) -> tuple[list[ExperimentLaws], bool]:
    """Run the experiments, with progress on standard error; return their parts, and whether all ran."""
    parts, begun = [], time.perf_counter()
    for number, module in enumerate(modules, 1):
        started = time.perf_counter()
        outcomes, complete = run_until_interrupt(module, limits)
        now = time.perf_counter()
        laws = tuple(laws_of(module, outcomes))
        parts.append(ExperimentLaws(experiment_name(module), len(outcomes), laws, now - started))
        if not complete:
            return parts, False
        rest = (now - begun) * sum(foreseen[number:]) / sum(foreseen[:number])
        to_go = f"; about {duration(rest)} left" if number < len(modules) else ""
        line = f"{number} of {len(modules)}: {parts[-1].name}, {duration(now - started)}{to_go}"
        print_to_stderr(line, PROGRESS)
    return parts, True


def _print_table(parts: list[ExperimentLaws], found: list[JudgedCase], rate: float) -> None:
    """Print the table, then every failing row in full."""
    rows = [_cells_of_laws(part, rate) for part in parts]
    for family, of_family in groupby(found, key=lambda row: row.case.family):
        cases = list(of_family)
        numbers = str(len(cases)), str(len(cases)), str(sum(row.holds for row in cases))
        far = _largest_score([row.seen.off for row in cases if row.seen.is_noisy])
        rows.append((f"hard: {family}", *numbers, "", far, "", ""))
    heads = "shown by", "cases>", "rows>", "hold>", "weak>", "farthest>", "bias caught>", "time>"
    print_rich(table_of(heads, rows), "")
    if failing := [law for part in parts for law in part.laws if not law.holds(rate)]:
        print_rich(*law_tables(failing, rate))
    if failing := [row for row in found if not row.holds]:
        print_rich(hard_table(failing), "")


def _cells_of_laws(part: ExperimentLaws, rate: float) -> tuple[str | Text, ...]:
    holding = sum(law.state(rate) in (HOLDS, IS_WEAK) for law in part.laws)
    biases = [law.smallest_bias(rate) for law in part.laws if law.exact != 0]
    caught = bias_text(float(np.median(biases)), 1.0, "") if biases else ""
    weak = sum(law.state(rate) == IS_WEAK for law in part.laws)
    numbers = str(part.cases), str(len(part.laws)), str(holding), str(weak)
    return (part.name, *numbers, _largest_score([law.z for law in part.laws]), caught, duration(part.seconds))


def _largest_score(scores: list[float]) -> str | Text:
    """Return the cell of the largest score by magnitude; empty if none is known."""
    known = [score for score in scores if not math.isnan(score)]
    return z_cell(max(known, key=abs)) if known else ""
