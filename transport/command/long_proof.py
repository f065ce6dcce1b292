"""`transport verify --long`: every law with many particles, and every hard case, in one table.

Two pilot runs of each experiment estimate the time before it starts.
"""

import math
import time
from dataclasses import dataclass
from itertools import groupby
from types import ModuleType

import numpy as np
from rich.text import Text

from transport.command.console import console, say, say_json, status_of
from transport.command.hard_cases import Judged, hard_table, judged
from transport.command.running import total_cost
from transport.command.tables import bias_text, law_tables, plain_table, z_cell
from transport.command.verify import FALSE_ALARM, POWER, Law, laws_of
from transport.command.verifying import check_any, known_outcomes, law_record, modules_of
from transport.experiment import name_of
from transport.hard.cases import cases_of
from transport.results import Cost
from transport.results.notation import duration
from transport.runs.limits import MOST_PARTICLES, checked_whole

LONG = 100_000_000  # histories per case by default
SHARES = 1000, 250  # the two pilots run 1/SHARES of the histories ...
LEAST = 50_000, 200_000  # ... but at least LEAST, because start-up takes time too

NOTE = f"""false alarms: {FALSE_ALARM:g} over all rows and cases; farthest: largest deviation
in standard errors; bias caught: median over the rows of the smallest relative bias detected with
{POWER:.0%} power; --json lists every row"""


@dataclass(frozen=True)
class Part:
    """Laws of one experiment, and its time [s]."""

    name: str
    cases: int
    laws: tuple[Law, ...]
    seconds: float


def verify_long(sims: list[str] | None, limits: dict[str, object], json: bool) -> int:
    """Run these experiments, or all experiments and hard cases.

    Returns status 1 if one fails, 130 if interrupted.
    """
    particles = LONG if limits["particles"] is None else limits["particles"]
    checked_whole("particles", particles, 1, MOST_PARTICLES * 100)
    modules, cases = modules_of(sims), [] if sims else list(cases_of())
    _tell("running pilots to estimate the time")
    foreseen = [_foreseen(module, limits, particles) for module in modules]
    _tell(
        f"experiments: {len(modules)}, with {particles:.3g} particles per case; hard cases: {len(cases)};"
        f" about {duration(sum(foreseen))} according to the pilots; Ctrl-C stops and prints the finished rows"
    )
    begun = time.perf_counter()
    parts, complete = _run(modules, limits | {"particles": particles}, foreseen)
    laws = [law for part in parts for law in part.laws]
    found = list(judged(cases, others=len(laws))) if complete else []
    complete = complete and len(found) == len(cases)
    check_any([*laws, *found], complete)
    took, rate = time.perf_counter() - begun, FALSE_ALARM / (len(laws) + len(found))
    failed = sum(not law.holds(rate) for law in laws) + sum(not row.holds for row in found)
    if json:
        rows = [law_record(law, rate) for law in laws]
        times = {"particles": particles, "foreseen_seconds": sum(foreseen), "seconds": took}
        say_json(times | {"laws": rows, "hard": [row.record for row in found]})
    else:
        _print(parts, found, rate)
        style, number = "bold red" if failed else "bold green", len(laws) + len(found)
        say(f"{number - failed} of {number} rows and hard cases hold", style=style)
        say(
            NOTE, f"{duration(took)}, estimated {duration(sum(foreseen))}; {particles:.3g} particles per case"
        )
    return status_of(failed, complete)


def _foreseen(module: ModuleType, limits: dict[str, object], particles: int) -> float:
    """Estimate the seconds of an experiment from a line through two pilots; compilation is not counted."""
    sizes = [
        min(particles, max(particles // share, least)) for share, least in zip(SHARES, LEAST, strict=True)
    ]
    few, more = (_pilot(module, limits, size) for size in sizes)
    slope = (more.seconds - few.seconds) / max(1, more.particles - few.particles)
    if slope <= 0:  # noise; a proportional time is an upper estimate
        slope = more.seconds / more.particles
    return more.seconds + slope * more.particles * (particles / sizes[1] - 1)


def _pilot(module: ModuleType, limits: dict[str, object], particles: int) -> Cost:
    """Run all cases with this many particles each and return their total cost."""
    outcomes, complete = known_outcomes(module, limits | {"particles": particles})
    if not complete:
        raise KeyboardInterrupt
    return total_cost(outcomes)


def _run(
    modules: list[ModuleType], limits: dict[str, object], foreseen: list[float]
) -> tuple[list[Part], bool]:
    """Run the experiments, with progress on standard error; return their parts, and whether all ran."""
    parts, begun = [], time.perf_counter()
    for number, module in enumerate(modules, 1):
        started = time.perf_counter()
        outcomes, complete = known_outcomes(module, limits)
        now = time.perf_counter()
        parts.append(Part(name_of(module), len(outcomes), tuple(laws_of(module, outcomes)), now - started))
        if not complete:
            return parts, False
        rest = (now - begun) * sum(foreseen[number:]) / sum(foreseen[:number])
        to_go = f"; about {duration(rest)} left" if number < len(modules) else ""
        _tell(f"{number} of {len(modules)}: {parts[-1].name}, {duration(now - started)}{to_go}")
    return parts, True


def _tell(line: str) -> None:
    """Print a line to standard error, apart from the results."""
    console(stderr=True).print(line, style="cyan")


def _print(parts: list[Part], found: list[Judged], rate: float) -> None:
    """Print the table, then every failing row in full."""
    table = plain_table("shown by", "cases>", "rows>", "hold>", "farthest>", "bias caught>", "time>")
    for part in parts:
        table.add_row(*_cells_of_laws(part, rate))
    for family, of_family in groupby(found, key=lambda row: row.case.family):
        rows = list(of_family)
        holding = str(sum(row.holds for row in rows))
        far = _farthest([row.seen.off for row in rows if row.seen.is_noisy])
        table.add_row(f"hard: {family}", str(len(rows)), str(len(rows)), holding, far, "", "")
    say(table, "")
    if failing := [law for part in parts for law in part.laws if not law.holds(rate)]:
        say(*law_tables(failing, rate))
    if failing := [row for row in found if not row.holds]:
        say(hard_table(failing), "")


def _cells_of_laws(part: Part, rate: float) -> tuple[str | Text, ...]:
    holding = sum(law.holds(rate) for law in part.laws)
    biases = [law.smallest_bias(rate) for law in part.laws if law.exact != 0]
    caught = bias_text(float(np.median(biases)), 1.0, "") if biases else ""
    numbers = str(part.cases), str(len(part.laws)), str(holding)
    return (part.name, *numbers, _farthest([law.z for law in part.laws]), caught, duration(part.seconds))


def _farthest(scores: list[float]) -> str | Text:
    """Return the cell of the largest score by magnitude; empty if none is known."""
    known = [score for score in scores if not math.isnan(score)]
    return z_cell(max(known, key=abs)) if known else ""
