"""Equilibrium of radiation: the escape cone, and a chi-square test of many correlated bins at once."""

from __future__ import annotations

import math

import numpy as np


def escape_cosine(index: float) -> float:
    """Cosine of the critical angle within a body.

    Parameters
    ----------
    index : float
        Index n of the body over that of its surroundings, at least 1 [1].

    Returns
    -------
    float
        ``sqrt(1 - 1/n^2)`` [1]. Light that entered by refraction is within this cone about the normal.

    Raises
    ------
    ValueError
        If the index is below 1.

    Examples
    --------
    >>> from transport.theory.equilibrium import escape_cosine
    >>> print(f"{escape_cosine(1.5):.4g}")
    0.7454
    """
    if not index >= 1:
        raise ValueError(f"escape_cosine: index must be 1 or more, got {index!r}")
    return math.sqrt((index - 1) * (index + 1)) / index


def chi_square_values(deviations: np.ndarray, weights: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Batch values whose mean is X^2 over its expectation and whose standard error is that of X^2.

    Parameters
    ----------
    deviations : ndarray
        Deviation of each batch from the expectation in K bins, shape (B, K).
    weights : ndarray
        Weights of the bins, best proportional to the inverse variances, shape (K,).
    sizes : ndarray
        Histories per batch, shape (B,).

    Returns
    -------
    ndarray
        Batch values, shape (B,) [1]; nan for fewer than three batches.

    Notes
    -----
    ``X^2 = sum w (mean of d)^2``. Let ``G_ab = sum w d_a d_b``. For two different batches G has the
    expectation ``sum w bias^2``, for any distributions and correlations of the bins (Chen, Qin 2010,
    Ann. Stat. 38, 808). So X^2 exceeds its expectation by U/V, with U the mean of G over such pairs and
    V = ``sum w variance of the means``, from the spread of the batches.

    Without bias all G_ab are uncorrelated with one variance T. The variance of U is
    ``2 T/(B (B - 1))``, and the means S_b of G_ab over a have the variance ``T (B - 2)/(B - 1)^2``. The
    batch values are 1 + U/V, with the spread ``sqrt(2 (B - 1)/(B - 2)) S_b/V``. If many bins
    contribute, X^2 is normally distributed, and its excess divided by its error follows Student's t
    with B - 1 degrees of freedom.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.equilibrium import chi_square_values
    >>> d = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, -1.0]])
    >>> print(chi_square_values(d, np.ones(2), np.ones(3)).round(4))
    [ 0.5  0.5 -1. ]
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
    with np.errstate(divide="ignore", invalid="ignore"):  # if nothing was counted, the noise is 0
        return 1 + (excess + spread * (rows - excess)) / noise
