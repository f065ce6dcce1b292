"""The price of accuracy, predicted from the cost of a finished run: time ~ error^(1 / slope)."""

from __future__ import annotations

import math

import numpy as np

from transport.results.notation import duration, percent
from transport.results.quantities import Quantity
from transport.results.record import BY_CHANCE, Cost, Record

DECADES = 2  # below the present error, in a report


def price_of(quantity: Quantity, cost: Cost, error: float, slope: float = BY_CHANCE) -> float:
    """Seconds of a run for a relative error of the quantity, in its worst known bin that is not doubtful.

    nan if there is no such bin.  For the whole run, not its rest, on the same machine with as many threads.
    """
    relative = np.atleast_1d(quantity.relative_error)
    relative = relative[np.isfinite(relative) & ~np.atleast_1d(quantity._is_known_but_doubtful)]
    if not relative.size:
        return math.nan
    return float(cost.seconds * (relative.max() / error) ** (-1 / slope))


def price_lines(result: Record, name: str) -> list[str]:
    """A line with the price of the next digits of a detector's first known quantity.

    None if there is no such quantity.
    """
    slopes = result.cost.slopes if result.cost is not None else {}
    found = result[name].quantities if result.cost is not None else {}
    asked = [quantity for quantity in found if f"{name}.{quantity}" in slopes]
    known = (each for each in (*asked, *found) if _has_error(found[each]))
    if (quantity := next(known, None)) is None:
        return []
    present = price_of(found[quantity], result.cost, 1.0, BY_CHANCE)
    if not 0 < present < math.inf:
        return []
    relative = math.sqrt(present / result.cost.seconds)
    first = math.ceil(-math.log10(relative) + 1e-9)
    errors = [10.0**-k for k in range(max(1, first), max(1, first) + DECADES)]
    told = [f"{percent(e)} in {duration(result.price(f'{name}.{quantity}', e))}" for e in errors]
    sound = " that is not doubtful" if np.any(found[quantity]._is_known_but_doubtful) else ""
    worst = f" in its worst bin{sound}" if np.size(found[quantity].value) > 1 else ""
    return [f"price of {quantity}{worst}: {', '.join(told)}"]


def _has_error(quantity: object) -> bool:
    """Whether there is an error that a longer run would reduce."""
    if not isinstance(quantity, Quantity):
        return False
    relative = np.asarray(quantity.relative_error)
    return bool(np.any((relative > 0) & np.isfinite(relative)))
