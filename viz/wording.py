"""Estimates and names as they are written into a figure: the value with its error, the unit in mathtext, a name as it is."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from transport import Estimate
from transport.statistics.notation import plus_minus
from transport.units import au
from transport.viz.style import unit_label

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
LENGTHS = (  # from which length on [m]; the unit's size [m] and its name
    (1e10, au, "au"), (1e3, 1e3, "km"), (0.1, 1.0, "m"), (1e-3, 1e-3, "mm"), (1e-6, 1e-6, "µm"), (0.0, 1e-9, "nm"),
)  # fmt: skip


def estimate_text(estimate: Estimate) -> str:
    """ "(18.44 ± 0.01) W m⁻²", or the value with "(exact)" or why no error is known."""
    if estimate.reason is None and not estimate.exact:
        number = plus_minus(estimate.value, estimate.error).replace("-", "−")
    else:
        number = f"{estimate.value:.6g}".replace("-", "−")
    tail = " (exact)" if estimate.exact else "" if estimate.reason is None else f" ({estimate.reason})"
    unit = unit_label(estimate.unit)
    return f"{number}{' ' if unit else ''}{unit}{tail}"


def number_text(estimate: Estimate, scale: float = 1.0) -> str:
    """ "18.44 ± 0.01" without the unit, the value times `scale`; the value alone where it has no error."""
    value, error = scale * estimate.value, scale * estimate.error
    if estimate.exact or not error > 0 or not math.isfinite(error):
        return f"{value:.4g}".replace("-", "−")
    number = plus_minus(value, error)
    return (number.strip("()") if number.endswith(")") else number).replace("-", "−")


def lengths_text(lengths: Sequence[float]) -> str:
    """ "4 × 4 × 2.3 µm": lengths [m] in the unit that suits the largest, from nm to km."""
    size, unit = unit_of_length(max(lengths))
    return " × ".join(f"{length / size:.3g}" for length in lengths) + f" {unit}"


def unit_of_length(largest: float) -> tuple[float, str]:
    """(its size [m], its name) of the unit that suits lengths up to the largest [m]."""
    if largest == 0:
        return 1.0, "m"
    return next((size, unit) for least, size, unit in LENGTHS if largest >= 0.999 * least)


def raised(words: str) -> str:
    """Exponents written as such: "on 1 m^2" as "on 1 m²"."""
    return re.sub(r"\^\(?(-?\d+)\)?", lambda found: found[1].translate(SUPERSCRIPTS), words)


def as_it_stands(name: str) -> str:
    """A name, in which no dollar sign begins a formula."""
    return name.replace("$", r"\$")
