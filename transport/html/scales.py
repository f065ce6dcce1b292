"""From values to places in a small picture: in proportion from zero, or by decades where they differ by many."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

WIDE = 1e3  # times the smallest value that the largest may be in proportion
DECADES = 15  # shown at most


@dataclass(frozen=True)
class Scale:
    """low, high: the ends [unit].  is_log: whether decades are as long as one another; what is not positive is then at low."""

    low: float
    high: float
    is_log: bool

    def place(self, value: float) -> float:
        """Where the value is, 0 to 1."""
        if not self.is_log:
            return min(max((value - self.low) / (self.high - self.low), 0.0), 1.0)
        return min(max(math.log(max(value, self.low) / self.low) / math.log(self.high / self.low), 0.0), 1.0)


def scale_of(reached: np.ndarray, values: np.ndarray) -> Scale:
    """A scale that holds all that is reached and zero, or the decades of the values where none is negative."""
    known, values = reached[np.isfinite(reached)], values[np.isfinite(values)]
    low, high = (min(known.min(), 0.0), max(known.max(), 0.0)) if known.size else (0.0, 0.0)
    positive = values[values > 0]
    if positive.size and not (values < 0).any() and positive.min() * WIDE < positive.max():
        top = 10.0 ** math.ceil(math.log10(high) - 1e-9)
        bottom = 10.0 ** math.floor(math.log10(positive.min()) + 1e-9)
        return Scale(max(bottom, top * 10.0**-DECADES), top, True)
    if values.size and not (values < 0).any():
        low = 0.0
    return Scale(float(low), float(high), False) if high > low else Scale(0.0, 1.0, False)
