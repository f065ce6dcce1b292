"""From values to positions in a small picture: linear from zero, or logarithmic if they differ by decades."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

WIDE = 1e3  # ratio of the largest to the smallest value, above which the scale is logarithmic
DECADES = 15  # shown at most


@dataclass(frozen=True)
class Scale:
    """A scale from `low` to `high` [unit]; if `is_log` it is logarithmic, and values up to 0 are at `low`."""

    low: float
    high: float
    is_log: bool

    def place(self, value: float) -> float:
        """Position of the value, 0 to 1."""
        if not self.is_log:
            return min(max((value - self.low) / (self.high - self.low), 0.0), 1.0)
        return min(max(math.log(max(value, self.low) / self.low) / math.log(self.high / self.low), 0.0), 1.0)


def scale_of(reached: np.ndarray, values: np.ndarray) -> Scale:
    """A scale that covers `reached` and zero, or the decades of the values if none is negative."""
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
