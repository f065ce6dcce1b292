"""Whether batches are good replicates: no trend in their mean or spread, and no outlier.

Each number is the probability that independent, equal, roughly normal batches look so odd; nan for fewer than
LEAST.
"""

from __future__ import annotations

import math

import numpy as np

MASKED = 5  # batches that may together be outliers above all others
LEAST = 16  # batches: with fewer a perfect order is not rare


def trend_of(values: np.ndarray) -> float:
    """Probability of a drift from batch to batch, (B,), as odd as this: of three tests the oddest.

    The tests are Student's t between the halves, Spearman's rank correlation with the order, and Brown and
    Forsythe (1974) on the halves' deviations from their medians: a constant mean, and an error that falls as
    N^-1/2.
    """
    values = np.asarray(values, dtype=float)
    if len(values) < LEAST or not np.ptp(values) > 0:
        return math.nan
    first, last = values[: len(values) // 2], values[len(values) // 2 :]
    spreads = [np.abs(half - np.median(half)) for half in (first, last)]
    tests = (_two_samples(first, last), _ranks(values), _two_samples(*spreads))
    return min(1.0, len(tests) * min(tests))


def outlier_of(values: np.ndarray) -> float:
    """Probability that the largest batch, (B,), or one of the MASKED largest is so far above the others.

    Grubbs 1950; Rosner 1983 for several outliers, of which one would hide another.
    """
    values = np.sort(np.asarray(values, dtype=float))
    if len(values) < LEAST or not np.ptp(values) > 0:
        return math.nan
    return min(1.0, MASKED * min(_grubbs(values[: len(values) - left_out]) for left_out in range(MASKED)))


def _grubbs(values: np.ndarray) -> float:
    """Probability for the largest value alone."""
    many = len(values)
    if not np.ptp(values) > 0:
        return 1.0
    far = (values.max() - values.mean()) / values.std(ddof=1)
    left = (many - 1) ** 2 - many * far**2
    t = math.sqrt(many * (many - 2) * far**2 / left) if left > 0 else math.inf
    return min(1.0, many * _beyond(t, many - 2))


def _two_samples(first: np.ndarray, last: np.ndarray) -> float:
    """Two-sided probability for the difference of the means."""
    dof = len(first) + len(last) - 2
    pooled = (((first - first.mean()) ** 2).sum() + ((last - last.mean()) ** 2).sum()) / dof
    error = math.sqrt(pooled * (1 / len(first) + 1 / len(last)))
    difference = abs(first.mean() - last.mean())
    return 1.0 if difference == 0 else 2 * _beyond(difference / error if error > 0 else math.inf, dof)


def _ranks(values: np.ndarray) -> float:
    """Two-sided probability for the correlation of ranks with the order; ties share their mean rank."""
    _, places, counts = np.unique(values, return_inverse=True, return_counts=True)
    ranks = (np.cumsum(counts) - 0.5 * counts)[places]
    r, dof = float(np.corrcoef(ranks, np.arange(len(values)))[0, 1]), len(values) - 2
    return 2 * _beyond(abs(r) * math.sqrt(dof / (1 - r * r)) if abs(r) < 1 else math.inf, dof)


def _beyond(t: float, dof: int) -> float:
    """Probability of a value above t."""
    from scipy.special import stdtr

    return float(stdtr(dof, -t))
