"""Equilibrium of radiation: what every bin should hold, and whether many correlated bins do, all at once."""

from __future__ import annotations

import math

import numpy as np


def escape_cosine(index: float) -> float:
    """Cosine of the critical angle within a body of this index over its surroundings' [1]: sqrt(1 - 1/n^2).

    Light that came in by refraction is within the cone about the normal that it bounds.  Raises ValueError below 1.
    """
    if not index >= 1:
        raise ValueError(f"escape_cosine: the index must be 1 or more, got {index!r}")
    return math.sqrt((index - 1) * (index + 1)) / index


def chi_square_values(deviations: np.ndarray, weights: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Batch values whose mean is X^2 over its expectation and whose standard error is that of X^2, (B,).

    deviations: of the batches from what is expected, in K bins, (B, K);  weights: of the bins, (K,), best the
    inverses of their variances but for a factor;  sizes: histories of the batches, (B,).  nan for fewer than three.

    X^2 = sum w (mean of d)^2.  Let G_ab = sum w d_a d_b.  In pairs of unlike batches G has the expectation
    sum w bias^2, whatever the bins' distributions and correlations (Chen, Qin 2010, Ann. Stat. 38, 808).  So X^2 is
    over its expectation by U/V, with U the mean of G over such pairs and V = sum w variance of the means, from the
    spread of the batches.  Without bias all G_ab are uncorrelated, of one variance T: that of U is 2 T/(B (B - 1)),
    and the means S_b of G_ab over a spread by T (B - 2)/(B - 1)^2.  The batch values are 1 + U/V, spread as
    sqrt(2 (B - 1)/(B - 2)) S_b/V.  Where many bins count, X^2 follows a normal law, and its excess over the error
    Student's t of B - 1.
    """
    scaled = np.asarray(deviations, float) * np.sqrt(weights)
    batches, shares = len(scaled), np.asarray(sizes, float)
    if batches < 3:
        return np.full(batches, math.nan)
    gram = (scaled @ scaled.T) * np.sqrt(np.outer(shares, shares)) / shares.mean()
    rows = (gram.sum(axis=1) - np.diag(gram)) / (batches - 1)
    excess = rows.mean()
    noise = (np.trace(gram) / batches - excess) / batches
    spread = math.sqrt(2 * (batches - 1) / (batches - 2))
    with np.errstate(divide="ignore", invalid="ignore"):  # no batch differs where nothing was counted
        return 1 + (excess + spread * (rows - excess)) / noise
