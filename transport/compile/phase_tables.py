"""Rows of a tabulated phase function: segments of the table, sampled by the alias method.

Each row keeps its segment for part of its probability 1/rows and yields the rest to another segment (Walker
1977, built as in Vose 1991). A sample thus costs one row whatever the table's length, and follows the table's
piecewise linear density exactly.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from transport.media.phases import Tabulated

# kept: share of the row's samples that its own segment keeps; the others go to the other segment.
# start: 1 - |mu| at the end of a segment nearer to the peak (mu = 1, or mu = -1 where width < 0); |width|:
# its width in mu.
# share: the density at that end over the sum of the densities at both ends.
COLUMNS = ("kept", "start", "width", "share", "other_start", "other_width", "other_share", "unused")
SEGMENT = np.dtype([(name, "f8") for name in COLUMNS])
ENDS = ("start", "width", "share")


def tabulated_rows(phase: Tabulated) -> np.ndarray:
    """Return rows of SEGMENT: segments of nonzero weight, padded to a power of two."""
    segments, weights = _segments(phase.mu, phase.values)
    count = 1 << max(len(weights) - 1, 0).bit_length()
    kept, other = _aliases(np.concatenate([weights, np.zeros(count - len(weights))]))
    rows = np.zeros(count, SEGMENT)
    rows["kept"] = kept
    for column, values in zip(ENDS, segments, strict=True):
        rows[column][: len(weights)] = values
        rows[f"other_{column}"] = values[other]
    return rows


def _segments(mu: np.ndarray, density: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (start, width, share) of the segments of nonzero weight, and their relative weights.

    A segment across mu = 0 is measured from its nearer end: 1 - |mu| continues beyond 1.
    """
    low, high, at_low, at_high = mu[:-1], mu[1:], density[:-1], density[1:]
    widths, sums = high - low, at_low + at_high
    is_forward = low + high >= 0
    start = np.where(is_forward, 1 - high, 1 + low)
    share = np.where(is_forward, at_high, at_low) / np.where(sums > 0, sums, 1.0)
    met = widths * sums > 0
    return np.stack([start, np.where(is_forward, widths, -widths), share])[:, met], (widths * sums)[met]


def _aliases(weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (kept, other) per row: rows lighter than average stay whole, and heavier ones fill them up."""
    left = weights * (len(weights) / weights.sum())
    kept, other = np.ones(len(weights)), np.arange(len(weights))
    light = [int(k) for k in np.flatnonzero(left < 1)]
    heavy = [int(k) for k in np.flatnonzero(left >= 1)]
    while light and heavy:
        k, donor = light.pop(), heavy[-1]
        kept[k], other[k] = left[k], donor
        left[donor] -= 1 - left[k]
        if left[donor] < 1:
            light.append(heavy.pop())
    return kept, other
