"""What an error costs in time, going by what a finished run cost: time goes as the error to the power 1 / slope."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from transport.pricing.price_table import duration, percent
from transport.results.quantities import Quantity

if TYPE_CHECKING:
    from transport.results.result import Cost, Result

BY_CHANCE = -0.5  # slope of the error of independent histories against time
DECADES = 2  # that a report tells, below the present error


def price_of(quantity: Quantity, cost: Cost, error: float, slope: float = BY_CHANCE) -> float:
    """Seconds that a run takes to a relative error of the quantity, in its worst bin; nan where its error is not known.

    Of the whole run, not of what is left of it; on the same machine with as many threads.
    """
    relative = np.atleast_1d(quantity.relative_error)
    relative = relative[np.isfinite(relative)]
    if not relative.size:
        return math.nan
    return float(cost.seconds * (relative.max() / error) ** (-1 / slope))


def price_lines(result: Result, name: str) -> list[str]:
    """What the next digits of a detector's first known quantity cost, in a line; none where that is not known."""
    slopes = result.cost.slopes if result.cost is not None else {}
    found = result[name].quantities if result.cost is not None else {}
    asked = [quantity for quantity in found if f"{name}.{quantity}" in slopes]
    for quantity in (*asked, *found):
        present = (
            price_of(found[quantity], result.cost, 1.0, BY_CHANCE)
            if isinstance(found[quantity], Quantity)
            else 0
        )
        if 0 < present < math.inf:
            relative = math.sqrt(present / result.cost.seconds)
            first = math.ceil(-math.log10(relative) + 1e-9)
            errors = [10.0**-k for k in range(max(1, first), max(1, first) + DECADES)]
            told = [f"{percent(e)} in {duration(result.price(f'{name}.{quantity}', e))}" for e in errors]
            worst = " in its worst bin" if np.size(found[quantity].value) > 1 else ""
            return [f"price of {quantity}{worst}: {', '.join(told)}"]
    return []
