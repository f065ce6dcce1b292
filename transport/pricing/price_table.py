"""Cost of accuracy as a table of text: price, slope and deviation from the truth of each method."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from transport.results.notation import duration, percent

if TYPE_CHECKING:
    from transport.pricing.cost import CostOfAccuracy
    from transport.pricing.ways import Price, Way

EXTRAPOLATED = "*"


def price_heads(cost: CostOfAccuracy) -> tuple[str, ...]:
    """Column heads; those of numbers end in >."""
    return ("method", *(f"{percent(target)}>" for target in cost.targets), "slope>", "z>", "compiled in>")


def price_rows(cost: CostOfAccuracy) -> list[tuple[str, ...]]:
    """One row per method."""
    return [(way.name, *(price_text(way.price(t)) for t in cost.targets), *_told(way)) for way in cost.ways]


def price_notes(cost: CostOfAccuracy) -> list[str]:
    """Notes below the table: units, machine, and methods without a price."""
    threads = f"{cost.threads} thread{'s' if cost.threads > 1 else ''}"
    notes = [f"seconds of CPU on {cost.machine}, {threads}; errors from the truth, {cost.truth_is}"]
    if any(way.price(target).is_extrapolated and way.line for way in cost.ways for target in cost.targets):
        notes.append(f"{EXTRAPOLATED} extrapolated: below all measured errors")
    notes += [f"{way.name}: {_why_no_price(way)}" for way in cost.ways if way.line is None]
    return notes + [f"{name}: not run: {why}" for name, why in cost.refused.items()]


def price_lines(cost: CostOfAccuracy) -> list[str]:
    """Title, table and notes as lines of text."""
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
    """Title with the quantity and its value."""
    value = f"{cost.truth:.7g} {cost.unit}" if isinstance(cost.truth, float) else f"{len(cost.truth)} bins"
    return f"cost of {cost.quantity} ({value})"


def price_text(price: Price) -> str:
    """Price with a mark if it is extrapolated; a dash if it is unknown."""
    if price.seconds == math.inf:
        return "–"
    return duration(price.seconds) + EXTRAPOLATED * price.is_extrapolated


def _why_no_price(way: Way) -> str:
    """Reason why a method has no price."""
    if way.known_points:
        return "its error is known for one size of run only, a price needs two; pass more seconds"
    return f"its error is still unknown after {way.points[-1].particles:.2g} particles in the largest run"


def _told(way: Way) -> tuple[str, str, str]:
    """Text of slope, z and preparation time."""
    slope = "–" if way.line is None else f"{way.line.slope:.2f} ± {way.line.slope_error:.2f}"
    return slope, "–" if math.isnan(way.z) else f"{way.z:+.1f}", duration(way.preparation)
