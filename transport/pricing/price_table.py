"""The cost of accuracy as rows of text: what each way costs, its slope, and how far off the truth it is."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from transport.results.notation import duration, percent

if TYPE_CHECKING:
    from transport.pricing.cost import CostOfAccuracy
    from transport.pricing.ways import Price, Way

EXTRAPOLATED = "*"


def price_heads(cost: CostOfAccuracy) -> tuple[str, ...]:
    """The heads of the columns; those of numbers end in >."""
    return ("way", *(f"{percent(target)}>" for target in cost.targets), "slope>", "z>", "compiled in>")


def price_rows(cost: CostOfAccuracy) -> list[tuple[str, ...]]:
    """One row a way."""
    return [(way.name, *(price_text(way.price(t)) for t in cost.targets), *_told(way)) for way in cost.ways]


def price_notes(cost: CostOfAccuracy) -> list[str]:
    """What the table means, and what is not in it."""
    threads = f"{cost.threads} thread{'s' if cost.threads > 1 else ''}"
    notes = [f"seconds of CPU on {cost.machine}, {threads}; errors from the truth, {cost.truth_is}"]
    if any(way.price(target).is_extrapolated and way.line for way in cost.ways for target in cost.targets):
        notes.append(f"{EXTRAPOLATED} extrapolated: below every error that was measured")
    notes += [f"{way.name}: {_why_no_price(way)}" for way in cost.ways if way.line is None]
    return notes + [f"{name}: not taken: {why}" for name, why in cost.refused.items()]


def price_lines(cost: CostOfAccuracy) -> list[str]:
    """The whole as plain text."""
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
    """What the prices are of, with its value."""
    value = f"{cost.truth:.7g} {cost.unit}" if isinstance(cost.truth, float) else f"{len(cost.truth)} bins"
    return f"cost of {cost.quantity} ({value})"


def price_text(price: Price) -> str:
    """A price with a mark where it was not measured; a dash where nothing is known."""
    if price.seconds == math.inf:
        return "–"
    return duration(price.seconds) + EXTRAPOLATED * price.is_extrapolated


def _why_no_price(way: Way) -> str:
    if way.known_points:
        return "its error is known for one size of run only; a price needs two: give it more seconds"
    return f"{way.points[-1].particles:.2g} particles of the largest run left its error unknown"


def _told(way: Way) -> tuple[str, str, str]:
    slope = "–" if way.line is None else f"{way.line.slope:.2f} ± {way.line.slope_error:.2f}"
    return slope, "–" if math.isnan(way.z) else f"{way.z:+.1f}", duration(way.preparation)
