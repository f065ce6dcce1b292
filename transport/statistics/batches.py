"""Mean, standard error and normal score from batch values; batches are independent replicates.

Arrays have the batch as their first axis and any number of bins after it, (B, *dims).  The sizes of batches,
n_b of shape (B,), may differ; N is their sum and w_b = n_b / N.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

Partial = tuple[np.ndarray, np.ndarray, np.ndarray]  # count, mean, sum of squared deviations from the mean

_SMALLEST_SAFE_TAIL = 1e-280  # smaller probabilities are computed as logarithms


def weighted_mean(values: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Mean over all histories, sum_b n_b x_b / N [unit of the values], shape (*dims).

    It averages the differences from the first batch, then the rounding errors: equal values give exactly that
    value.
    """
    weights = _batch_weights(values, sizes)
    mean = values[0] + (weights * (values - values[0])).sum(axis=0)
    return mean + (weights * (values - mean)).sum(axis=0)


def standard_error(values: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """One standard error of `weighted_mean` [unit of the values], shape (*dims); nan for one batch.

    Its square is sum_b n_b (x_b - mean)^2 / (N (B - 1)), unbiased because x_b has variance sigma^2 / n_b.
    """
    deviations = values - weighted_mean(values, sizes)
    if len(values) < 2:
        return np.full(deviations.shape[1:], np.nan)
    # Scale the deviations, since squares of very small or very large ones leave the range of a float.
    scale = np.abs(deviations).max(axis=0)
    scale = np.where((scale > 0) & np.isfinite(scale), scale, 1.0)
    squares = (_batch_weights(values, sizes) * (deviations / scale) ** 2).sum(axis=0)
    return scale * np.sqrt(squares / (len(values) - 1))


def skewness_of_mean(deviations: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Skewness of the distribution of `weighted_mean`, from the deviations of the batches, shape (*dims).

    sum_b w_b^3 d_b^3 / (sum_b w_b^2 d_b^2)^(3/2), 0 without deviations: the skewness of one history over the
    root of their number.
    """
    parts = _batch_weights(deviations, sizes) * deviations
    scale = np.abs(parts).max(axis=0)
    parts = parts / np.where(scale > 0, scale, 1.0)
    squares = (parts**2).sum(axis=0)
    return (parts**3).sum(axis=0) / np.where(squares > 0, squares, 1.0) ** 1.5


def merge(first: Partial, second: Partial) -> Partial:
    """Merge count, mean and sum of squared deviations of two samples (Chan, Golub & LeVeque 1983)."""
    (count_a, mean_a, squares_a), (count_b, mean_b, squares_b) = first, second
    count = np.add(count_a, count_b)
    share = np.divide(count_b, np.maximum(count, 1))
    difference = np.subtract(mean_b, mean_a)
    return count, mean_a + difference * share, squares_a + squares_b + difference**2 * count_a * share


def pseudo_shifts(
    function: Callable[..., np.ndarray],
    means: Sequence[np.ndarray],
    deviations: Sequence[np.ndarray],
    sizes: np.ndarray,
) -> np.ndarray:
    """Jackknife pseudo-values minus function(*means), shape (B, *dims); needs two batches or more.

    The weighted mean of the pseudo-values is the function's value without its O(1/B) bias, their standard
    error its error (Quenouille 1956; Tukey 1958). For batches of different sizes a pseudo-value is
    (f(x) - (1 - w_b) f(x without b)) / w_b.

    means: shapes that broadcast to (*dims);  deviations: of the batches from them, (B, *dims), or 0.0.
    Shifts within rounding are set to 0, because the factor B would amplify them.
    """
    full = np.asarray(function(*means))
    weights = (sizes / np.sum(sizes)).reshape(-1, *(1,) * full.ndim)
    odds = weights / (1 - weights)
    without = [mean - odds * deviation for mean, deviation in zip(means, deviations, strict=True)]
    # If a single batch contributed everything, the rest is 0: set differences within rounding to 0.
    without = [
        np.where(np.abs(rest) <= rounding_error(mean), 0.0, rest)
        for rest, mean in zip(without, means, strict=True)
    ]
    difference = full - function(*without)
    return np.where(np.abs(difference) <= rounding_error(full), 0.0, difference / odds)


def rounding_error(values: np.ndarray) -> np.ndarray:
    """Rounding error of numbers of this size: four units in the last place."""
    return 4 * np.finfo(float).eps * np.abs(values)


def student_quantile(probability: float, dof: np.ndarray | float) -> np.ndarray:
    """The t below which Student's distribution with `dof` degrees of freedom has the given probability."""
    from scipy.special import stdtrit

    return stdtrit(dof, probability)


def normal_score(t: np.ndarray | float, dof: np.ndarray | float) -> np.ndarray:
    """The standard normal score with the same tail probability as t in Student's distribution.

    Odd in t; accurate to about 1e-12, also where the tail probability is below the range of a float.  An
    infinite dof gives t itself.
    """
    from scipy.special import ndtri_exp

    t, dof = np.broadcast_arrays(np.asarray(t, dtype=float), np.asarray(dof, dtype=float))
    score = -ndtri_exp(_log_tail(np.abs(t), np.where(np.isinf(dof), 1.0, dof)))
    return np.where(np.isinf(dof), t, np.copysign(np.where(t == 0, 0.0, score), t))


def welch_dof(errors: Sequence[np.ndarray], dofs: Sequence[int]) -> np.ndarray:
    """Effective degrees of freedom of a sum of independent estimates (Welch 1947; Satterthwaite 1946)."""
    if len(errors) == 1:
        return np.full(np.shape(errors[0]), float(dofs[0]))
    shares = np.square(errors / np.linalg.norm(errors, axis=0))
    return 1 / sum(share**2 / dof for share, dof in zip(shares, dofs, strict=True))


def _log_tail(t: np.ndarray, dof: np.ndarray) -> np.ndarray:
    """Logarithm of the probability above t >= 0 in Student's distribution."""
    from scipy.special import betaln, stdtr

    tail = stdtr(dof, -t)
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        # I_x(a, 1/2) / 2, where a = dof / 2, x = dof / (dof + t^2), odds = x / (1 - x) (DLMF 8.17.8, 15.8.1).
        log_odds = np.log(dof) - 2 * np.log(t)
        log_1_minus_x = -np.logaddexp(0.0, log_odds)
        log_prefactor = (
            dof / 2 * (log_odds + log_1_minus_x) - log_1_minus_x / 2 - np.log(dof) - betaln(dof / 2, 0.5)
        )
        far_out = log_prefactor + np.log(_far_series(dof / 2, np.exp(log_odds)))
        return np.where(tail > _SMALLEST_SAFE_TAIL, np.log(tail), far_out)


def _far_series(a: np.ndarray, odds: np.ndarray) -> np.ndarray:
    """2F1(1, 1/2; a + 1; -odds); far out odds / a is below 2 / 35^2, so a few terms suffice."""
    term = total = np.ones_like(odds)
    for n in range(12):
        term = -term * odds * (n + 0.5) / (a + 1 + n)
        total = total + term
    return total


def _batch_weights(values: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    return (np.asarray(sizes) / np.sum(sizes)).reshape(-1, *(1,) * (np.ndim(values) - 1))


# ---- Whether batches are good replicates: no trend in their mean or spread, and no outlier.
#
# Each number is the probability that independent, equal, roughly normal batches look so odd; nan for fewer
# than MIN_BATCHES.

MAX_OUTLIERS = 5  # batches that may together be outliers above all others
MIN_BATCHES = 16  # batches: with fewer a perfect order is not rare


def trend_probability(values: np.ndarray) -> float:
    """Probability of a drift from batch to batch, (B,), as odd as this: of three tests the oddest.

    The tests are Student's t between the halves, Spearman's rank correlation with the order, and Brown and
    Forsythe (1974) on the halves' deviations from their medians: a constant mean, and an error that falls as
    N^-1/2.
    """
    values = np.asarray(values, dtype=float)
    if len(values) < MIN_BATCHES or not np.ptp(values) > 0:
        return math.nan
    first, last = values[: len(values) // 2], values[len(values) // 2 :]
    spreads = [np.abs(half - np.median(half)) for half in (first, last)]
    tests = (_two_sample_test(first, last), _rank_test(values), _two_sample_test(*spreads))
    return min(1.0, len(tests) * min(tests))


def outlier_probability(values: np.ndarray) -> float:
    """Probability that the largest batch, (B,), or one of the MAX_OUTLIERS largest is so far above others.

    Grubbs 1950; Rosner 1983 for several outliers, of which one would hide another.
    """
    values = np.sort(np.asarray(values, dtype=float))
    if len(values) < MIN_BATCHES or not np.ptp(values) > 0:
        return math.nan
    return min(
        1.0,
        MAX_OUTLIERS
        * min(_grubbs_test(values[: len(values) - left_out]) for left_out in range(MAX_OUTLIERS)),
    )


def _grubbs_test(values: np.ndarray) -> float:
    """Probability for the largest value alone."""
    many = len(values)
    if not np.ptp(values) > 0:
        return 1.0
    far = (values.max() - values.mean()) / values.std(ddof=1)
    left = (many - 1) ** 2 - many * far**2
    t = math.sqrt(many * (many - 2) * far**2 / left) if left > 0 else math.inf
    return min(1.0, many * _upper_tail(t, many - 2))


def _two_sample_test(first: np.ndarray, last: np.ndarray) -> float:
    """Two-sided probability for the difference of the means."""
    dof = len(first) + len(last) - 2
    pooled = (((first - first.mean()) ** 2).sum() + ((last - last.mean()) ** 2).sum()) / dof
    error = math.sqrt(pooled * (1 / len(first) + 1 / len(last)))
    difference = abs(first.mean() - last.mean())
    return 1.0 if difference == 0 else 2 * _upper_tail(difference / error if error > 0 else math.inf, dof)


def _rank_test(values: np.ndarray) -> float:
    """Two-sided probability for the correlation of ranks with the order; ties share their mean rank."""
    _, places, counts = np.unique(values, return_inverse=True, return_counts=True)
    ranks = (np.cumsum(counts) - 0.5 * counts)[places]
    r, dof = float(np.corrcoef(ranks, np.arange(len(values)))[0, 1]), len(values) - 2
    return 2 * _upper_tail(abs(r) * math.sqrt(dof / (1 - r * r)) if abs(r) < 1 else math.inf, dof)


def _upper_tail(t: float, dof: int) -> float:
    """Probability of a value above t."""
    from scipy.special import stdtr

    return float(stdtr(dof, -t))


# ---- The number of scores that is enough to know an error bar, defined once.

# Fewer scores are too few everywhere: the mean of 25 scores of one size has a skewness of 25^-1/2 = 0.2, with
# which a
# 95 % interval covers 1 % less than it claims (Hall 1988, equation 2.5).
MIN_SCORES_FOR_ERROR = 25
