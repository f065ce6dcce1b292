"""Tables of the command line: estimates with exact values, laws, passes and effects of a scene."""

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby

from rich import box
from rich.table import Table
from rich.text import Text

from transport.analysis.binning import BinsAgainstNoise
from transport.analysis.cost import CostOfAccuracy, price_heads, price_rows
from transport.cli.console import NO_BREAK_SPACE
from transport.cli.effects.costs import EffectCost
from transport.cli.effects.passes import Effects
from transport.cli.laws import Law, z_score
from transport.results.result import Result
from transport.statistics.estimates import Estimate
from transport.statistics.findings import CONSTANT, DOUBTFUL, SOUND
from transport.statistics.notation import estimate_text
from transport.verification.experiment import Outcome, Row

# columns that wrap if the console is too narrow
WRAPPED_COLUMNS = "quantity", "case", "naive formula", "effect", "over", "measured", "kind of scene"


def case_table(outcome: Outcome) -> Table:
    """Return a table of estimates ± one standard error, with exact values and z if any is known."""
    is_judged = not all(math.isnan(row.exact) for row in outcome.rows)

    def cells(row: Row) -> Iterator[str | Text]:
        yield from (row.name, estimate_cell(row.estimate), unit_cell(row.estimate))
        if is_judged:
            yield from (exact_number(row.exact, row.estimate), z_cell(z_score(row.estimate, row.exact)))

    heads = ("quantity", "estimate ± error>", "unit", *(("exact>", "z>") if is_judged else ()))
    return table_of(heads, map(cells, outcome.rows))


def law_tables(laws: list[Law], false_alarm: float) -> Iterator[Text | Table]:
    """Yield for each law a title (formula, source, experiment) and a table of its rows."""
    for (sim, law, source), group in groupby(laws, key=lambda law: (law.sim, law.law, law.source)):
        yield Text.assemble((law, "bold"), f" ({source}) " if source else " ", (sim, "cyan"))
        heads = "quantity", "estimate ± error>", "unit", "exact>", "z>", "smallest bias>", ""
        yield table_of(heads, (_law_cells(row, false_alarm) for row in group))
        yield Text()


def pass_table(names: Iterable[str], costs: dict[str, float]) -> Table:
    """Return a table of passes in order, with ns per lane if measured."""
    rows, number = [], 1
    for name, run in groupby(names):
        times = len(list(run))
        title = name if times == 1 else f"{name} × {times}"
        rows.append([str(number), title, *([_cost_cell(costs.get(name))] if costs else [])])
        number += times
    return table_of([">", "pass", *(["ns per lane>"] if costs else [])], rows)


def cost_table(cost: CostOfAccuracy) -> Table:
    """Return a table of the cost of each estimator, with the slope of its error."""
    return table_of(price_heads(cost), price_rows(cost))


def bins_table(bins: BinsAgainstNoise) -> Table:
    """Return a table of noise, blur and their sum by number of bins, with the best sums marked."""
    sums = f"both, {bins.particles:.2g} particles>", f"{100 * bins.particles:.2g}>"
    rows, best = [], (bins.best(), bins.best(100))
    columns = zip(bins.bins, bins.noise, bins.blur, bins.total(), bins.total(100), strict=True)
    for number, noise, blur, *totals in columns:
        cells = [f"{100 * t:.2g} %{' ★' if number == b else '  '}" for t, b in zip(totals, best, strict=True)]
        rows.append([str(number), f"{100 * noise:.2g} %", f"{100 * blur:.2g} %", *cells])
    return table_of([f"bins along {bins.dim}>", "noise>", "blur>", *sums], rows)


def effect_table(effects: Sequence[EffectCost]) -> Table:
    """Return a table of ns per history, share and possible saving of each effect."""
    rows = []
    for effect in effects:
        share = f"{100 * effect.share:.0f} %"
        rows.append([effect.name, f"{effect.ns:.3g}", share, share if effect.can_go else "–"])
    return table_of(["effect", "ns per history>", "share>", "left out, saves>"], rows)


def effects_lines(effects: Effects) -> list[tuple[str, str]]:
    """Return (label, names) of the used fields, and of the absent passes and fields."""
    absent = effects.absent

    def listed(names: dict[str, str], kind: str) -> str:
        return " ".join(name for name, of in names.items() if of == kind) or "none"

    return [
        ("carried", listed(effects.fields, "carried")),
        ("scratch", listed(effects.fields, "scratch")),
        ("absent", f"passes: {listed(absent, 'pass')}"),
        ("", f"fields: {listed(absent, 'field')}"),
    ]


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


def estimate_cell(estimate: Estimate) -> str:
    """Return value ± error without the unit, and the verdict if it is not sound."""
    number = "" if estimate.reason is None else ".7g"  # without an error the number of digits is unknown
    words = estimate_text(estimate.value, estimate.error, "1", estimate.exact, estimate.reason, number)
    if estimate.reason is None and estimate.verdict != SOUND:
        return f"{words}, {estimate.verdict}"
    return f"{words}, {DOUBTFUL}" if estimate.reason == CONSTANT and estimate.is_doubtful else words


def unit_cell(estimate: Estimate) -> str:
    """Return the unit; empty for a dimensionless estimate."""
    return "" if estimate.unit.is_dimensionless else str(estimate.unit)


def exact_number(exact: float, estimate: Estimate) -> str:
    """Return the exact value with two more digits than the estimate has; a dash if unknown."""
    if math.isnan(exact):
        return "–"
    relative = estimate.error / abs(exact) if exact else math.nan
    digits = 6 if not 0 < relative < 1 else min(15, max(6, 3 - math.floor(math.log10(relative))))
    return f"{exact:.{digits}g}"


def z_cell(z: float) -> Text:
    """Return z with a sign, coloured by its magnitude."""
    if math.isnan(z):
        return Text("unknown", "yellow")
    style = "green" if abs(z) < 2.5 else "yellow" if abs(z) < 4 else "bold red"
    return Text(f"{z:+.2f}", style)


def bias_text(bias: float, exact: float, unit: str) -> str:
    """Return a relative bias in percent or as a number; with its unit if the exact value is 0."""
    if math.isnan(bias):
        return "unknown"
    if bias == 0:
        return "any"
    if exact == 0:
        return f"{bias:.1e} {unit}".strip()
    return f"{100 * bias:.2g} %" if 1e-5 <= bias < 10 else f"{bias:.1e}"


def _cost_cell(cost: float | None) -> str:
    if cost is None:
        return "?"
    return "not reached" if math.isnan(cost) else f"{cost:.2f}"


def _law_cells(law: Law, false_alarm: float) -> tuple[str | Text, ...]:
    """Return the cells of a law's row."""
    unit, exact = unit_cell(law.estimate), exact_number(law.exact, law.estimate)
    bias = bias_text(law.smallest_bias(false_alarm), law.exact, unit)
    numbers = estimate_cell(law.estimate), unit, exact, z_cell(law.z), bias
    return law.quantity, *numbers, state_cell(law.holds(false_alarm))


def state_cell(holds: bool) -> Text:
    """Return whether a law or case holds, as a coloured word."""
    return Text("holds", "green") if holds else Text("FAILS", "bold red")


def table_of(heads: Iterable[str], rows: Iterable[Iterable[str | Text]]) -> Table:
    """Return a table with these column heads and rows; columns whose head ends in > are right-aligned."""
    table = Table(box=box.SIMPLE_HEAD, header_style="bold", pad_edge=False, show_edge=False)
    for head in heads:
        align, is_whole = "right" if head.endswith(">") else "left", head not in WRAPPED_COLUMNS
        table.add_column(head.rstrip(">"), justify=align, overflow="fold", no_wrap=is_whole)
    for row in rows:
        table.add_row(*row)
    return table
