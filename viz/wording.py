"""Estimates and names as they are written into a figure: the value with its error, the unit in mathtext, a name as it is."""

from __future__ import annotations

from transport import Estimate
from transport.results.notation import plus_minus
from viz.style import unit_label


def estimate_text(estimate: Estimate) -> str:
    """ "(18.44 ± 0.01) W m⁻²", or the value with "(exact)" or why no error is known."""
    if estimate.reason is None and not estimate.exact:
        number = plus_minus(estimate.value, estimate.error).replace("-", "−")
    else:
        number = f"{estimate.value:.6g}".replace("-", "−")
    tail = " (exact)" if estimate.exact else "" if estimate.reason is None else f" ({estimate.reason})"
    unit = unit_label(estimate.unit)
    return f"{number}{' ' if unit else ''}{unit}{tail}"


def as_it_stands(name: str) -> str:
    """A name, in which no dollar sign begins a formula."""
    return name.replace("$", r"\$")
