"""Error bars of single bins, from variances pooled over neighbouring bins.

The variance among a bin's own batches is a poor measure of rare large scores.  A bin without one reads low
with a small error, a bin with one reads high with a large error, so that the error depends on the luck of the
value.  Neighbouring bins have other luck but nearly the same variance, so they estimate it better.

The difficulty is to distinguish an edge in the picture from luck.  The *inner spread* does it: the spread of
the inner three quarters of a bin's batches, which rare scores do not change.  Bins are pooled with neighbours
of similar inner spread, as in a bilateral filter (Tomasi & Manduchi 1998; on a grid of levels: Chen, Paris &
Durand 2007), over windows of doubling reach.  The fourth cumulant of all its batches gives the precision of a
window's variance, and each window is moderated by the next wider one (Smyth 2004).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from transport.statistics.batches import MIN_SCORES_FOR_ERROR

REACHES = (1, 2, 4, 8, 16)  # of windows, in bins to each side
SPARSE_REACH = 2  # reach within which bins with few scores are counted
MOST_IN_WINDOW = 33**2  # bins in a window; with more than two axes windows therefore have a smaller reach
INNER_SHARE = 0.75  # share of the batches, those nearest to their median, that define the inner spread
MIN_BATCHES = 8  # fewer define neither an inner spread nor a tail
# Weight of a bin's own variance; a full weight would tie the error to the luck of the value.
OWN_SHARE = 0.1
PRIOR_DOF = MIN_SCORES_FOR_ERROR  # degrees of freedom with which the next wider window moderates one
MIN_SIMILAR_BINS = MIN_SCORES_FOR_ERROR  # similar bins from which on their variances replace its own
# An error of d degrees of freedom has a relative precision of 1 / sqrt(2 d), here
# 1 / sqrt(MIN_SCORES_FOR_ERROR).
MIN_DOF = MIN_SCORES_FOR_ERROR / 2
OWN_DOF = 0.8  # of the degrees of freedom of the batches: enough if there are few batches
# Degrees of freedom, relative to those of the batches and at least, below which normal batches hardly ever
# fall; one batch that has all leaves 2.
EVEN_SHARE, LEAST_EVEN_DOF = 0.2, 2.2
OUTLIER_CHANCE = 1e-3  # chance of such a large own variance, below which the bin differs from its neighbours
ROUNDING = 1e-10  # inner spread over the largest deviation, below which it is rounding


class Pooled(NamedTuple):
    """Error bars of bins; each array has the shape of the bins, (*dims)."""

    error: np.ndarray  # one standard error [unit of the deviations]; nan if unknown
    dof: np.ndarray  # its degrees of freedom
    is_doubtful: np.ndarray  # whether it is known, but too few or too unequal scores carry it


class Moments(NamedTuple):
    """Estimates of the variance of each bin's mean, from its batches.

    Of the last four, `noise` and `square` have the unit 16**level, the others 4**level.
    """

    level: np.ndarray  # the power of 4 below the square of the inner spread
    share: np.ndarray  # part of the bin that belongs to the level above, 0 to 1
    is_sparse: np.ndarray  # whether so many batches gave the same that the bin has no inner spread
    is_thin: np.ndarray  # whether half of the batches gave the same
    variance: np.ndarray  # of the mean
    noise: np.ndarray  # variance of `variance`, unbiased
    square: np.ndarray  # of the true variance, unbiased
    largest: np.ndarray  # square of the largest contribution of one batch to the mean


def pooled_errors(
    deviations: np.ndarray,
    sizes: np.ndarray,
    known: np.ndarray,
    axes: Sequence[int],
    periodic: Sequence[int] = (),
) -> Pooled | None:
    """Return error bars of the mean of each bin, from the variances of similar neighbouring bins.

    Parameters
    ----------
    deviations : ndarray (B, *dims)
        Deviation of each batch from the mean.
    sizes : ndarray (B,)
        Histories in each batch.
    known : ndarray (*dims) of bool
        Which bins have an error of their own; the others are left out.
    axes : sequence of int
        Axes of the bins along which bins are neighbours, 0 for the first of `dims`.
    periodic : sequence of int
        Those of `axes` on which the last bin is beside the first.

    Returns
    -------
    Pooled or None
        None with fewer than MIN_BATCHES batches: then nothing is pooled.

    Notes
    -----
    Let s² be the variance of a bin's mean from its own B batches, and k its fourth cumulant (k-statistic of
    Fisher).  Then var(s²) = k / B + 2 σ⁴ / (B - 1).  A window of n bins has the mean variance v, known to D =
    2 n v² / <var(s²)> degrees of freedom; the larger <var(s²)> / v² of this window and the next wider one
    counts, because a window without the rare score does not show that it is rare.  From the widest window
    inwards, E = (D v + d E_wider) / (D + d) with d = PRIOR_DOF.  The bin itself is not in its windows; its
    own variance is added with OWN_SHARE of its degrees of freedom, or with more if fewer than
    MIN_SIMILAR_BINS other bins are similar.

    A sparse bin, most batches of which gave the same, has at least its own error.  Thin bins are doubtful
    where most bins around them are sparse; a decision for each bin by itself would keep the lucky ones.  A
    bin is also doubtful if one of its batches alone moves the mean by more than 7 errors,
    sqrt(2 MIN_SCORES_FOR_ERROR): fewer than one in 50 bins has a score of that size; and if, without enough
    similar bins, its own batches are too unequal to know its variance.
    """
    batches = len(deviations)
    known = np.asarray(known, dtype=bool)
    if batches < MIN_BATCHES:
        return None
    # Estimate the variance of each bin's mean, and its precision, for bins with a known error.
    bins = np.flatnonzero(known)
    flat = np.asarray(deviations).reshape(batches, -1)[:, bins]
    moments = _moments(flat, sizes)
    # Limit the windows of many axes to MOST_IN_WINDOW bins.
    long = sum(known.shape[axis] > 1 for axis in axes)
    reaches = [reach for reach in REACHES if reach == 1 or (2 * reach + 1) ** long <= MOST_IN_WINDOW]
    sums = [
        np.zeros((len(reaches), 4, bins.size)),  # over the windows, of 1, variance, noise, square
        np.zeros(bins.size),  # the bin's own weight in these sums
    ]
    # Add the sums over the windows, one level of inner spread at a time.
    for members, weights, rise in _levels(moments):
        _add_windows(sums, moments, (members, weights, rise), reaches, bins, known.shape, axes, periodic)
    # Combine the windows; bins that differ from their neighbours keep their own variance.
    variance, dof, of_bin, trust = _pooled_variances(*sums, moments, batches)
    is_unlike = _chance_of(moments.variance / variance, of_bin) < OUTLIER_CHANCE
    claims_own = is_unlike | moments.is_sparse
    variance = np.where(claims_own, np.maximum(variance, moments.variance), variance)
    # Write the results to all bins, and mark the doubtful ones.
    error = np.full(known.size, np.nan)
    error[bins] = np.ldexp(np.sqrt(variance), moments.level)
    of_bins = np.full(known.size, batches - 1.0)
    of_bins[bins] = dof
    doubtful = np.zeros(known.size, dtype=bool)
    is_lone = moments.largest > 2 * MIN_SCORES_FOR_ERROR * variance
    has_few = _has_few_scores(moments, bins, known.shape, axes, periodic)
    least = min(MIN_DOF, OWN_DOF * (batches - 1))
    # One history of very many scores, which no other bin tells of.
    is_uneven = (trust < 0.5) & (of_bin < max(LEAST_EVEN_DOF, EVEN_SHARE * (batches - 1)))
    doubtful[bins] = (dof < least) | is_unlike | is_lone | has_few | is_uneven
    return Pooled(*(each.reshape(known.shape) for each in (error, of_bins, doubtful)))


def _moments(deviations: np.ndarray, sizes: np.ndarray) -> Moments:
    """Moments of bins (B, n), each scaled by a power of 2, so that no square overflows."""
    count = len(deviations)
    _, exponent = np.frexp(np.abs(deviations).max(axis=0))
    roots = np.sqrt(np.asarray(sizes) / np.sum(sizes))[:, None]
    scaled = np.ldexp(deviations, -exponent)
    apart = np.sort(np.abs(scaled - np.median(scaled, axis=0)) * roots, axis=0)
    inner = (apart[: int(INNER_SHARE * count)] ** 2).mean(axis=0)
    squares = (scaled * roots) ** 2
    second, fourth = squares.sum(axis=0), (squares**2).sum(axis=0)
    is_sparse = inner * count <= ROUNDING**2
    # The typical size of its scores replaces the inner spread of a sparse bin.
    scores = np.maximum(np.count_nonzero(apart > ROUNDING, axis=0), 1)
    size = np.take_along_axis(apart, (count - (scores + 1) // 2)[None], axis=0)[0]
    size = np.where(size > 0, size, 1.0)
    power = np.log2(np.where(is_sparse, size, np.sqrt(inner)))
    # Levels lie about the median spread, so that neither the unit of the values nor one bright bin matters.
    if power.size:
        power -= power[np.argsort(exponent + power, kind="stable")[power.size // 2]] % 1.0
    level = exponent + np.floor(power).astype(int)
    # Fisher's k-statistic k4, and from it the square of the variance without its noise.
    variance = second / (count - 1)
    k4 = count * (count + 1) * fourth - 3 * (count - 1) * second**2
    k4 = k4 / ((count - 1) * (count - 2) * (count - 3))
    square = (count - 1) / (count + 1) * (variance**2 - k4 / count)
    noise = k4 / count + 2 * square / (count - 1)
    rise = 2 * (exponent - level)
    return Moments(
        level,
        power - np.floor(power),
        is_sparse,
        apart[count // 2] <= ROUNDING,
        np.ldexp(variance, rise),
        np.ldexp(noise, 2 * rise),
        np.ldexp(square, 2 * rise),
        np.ldexp((squares * roots**2).max(axis=0), rise),
    )


def _levels(moments: Moments) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """The bins of each level of inner spread: indices, weights, and the difference between the two levels."""
    found = []
    for kind in (moments.is_sparse, ~moments.is_sparse):
        group = np.flatnonzero(kind)
        level, share = moments.level[group], moments.share[group]
        for here in np.unique(np.concatenate([level, level + 1])):
            own, below = level == here, (level == here - 1) & (share > 0)
            members = np.concatenate([group[own], group[below]])
            weights = np.concatenate([1 - share[own], share[below]])
            rise = np.repeat([0, 1], [np.count_nonzero(own), np.count_nonzero(below)])
            if members.size:
                found.append((members, weights, rise))
    return found


def _add_windows(
    sums: list[np.ndarray],
    moments: Moments,
    level: tuple[np.ndarray, np.ndarray, np.ndarray],
    reaches: Sequence[int],
    bins: np.ndarray,
    shape: tuple[int, ...],
    axes: Sequence[int],
    periodic: Sequence[int],
) -> None:
    """Add the sums over all windows of one level of inner spread, for the bins of that level."""
    members, weights, rise = level
    of_windows, of_own = sums
    places = np.array(np.unravel_index(bins[members], shape))
    # No bin outside the bounding box of the members matters; a periodic axis stays whole.
    low = np.array([0 if axis in periodic else least for axis, least in enumerate(places.min(axis=1))])
    high = np.array(
        [shape[axis] if axis in periodic else most + 1 for axis, most in enumerate(places.max(axis=1))]
    )
    places = tuple(places - low[:, None])
    terms = np.zeros((4, *(high - low)))
    each = [np.ones(members.size), moments.variance[members], moments.noise[members], moments.square[members]]
    steps = [0 * rise, 2 * rise, 4 * rise, 4 * rise]  # from units of a bin's own level to this level
    for row, numbers, step in zip(terms, each, steps, strict=True):
        row[places] = weights * np.ldexp(numbers, -step)
    for k, reach in enumerate(reaches):
        found = window_sums(terms, reach, [1 + axis for axis in axes], [1 + axis for axis in periodic])
        for row, step in enumerate(steps):
            of_windows[k, row, members] += weights * np.ldexp(found[(row, *places)], step)
    of_own[members] += weights**2


def _pooled_variances(
    sums: np.ndarray, own: np.ndarray, moments: Moments, batches: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Variance of each bin's mean [units of its level], its degrees of freedom, those of its own variance.

    And the share in which other bins judge it.
    """
    bare = 2 / (batches - 1)  # relative variance of a variance of so many normal batches
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        each = np.stack([np.ones_like(own), moments.variance, moments.noise, moments.square])
        others = sums - own * each
        # A bin without similar bins, or beside which they vanish in rounding, uses its own variance.
        is_alone = (others[:, 0] <= ROUNDING * own) | (others[:, 1] <= ROUNDING * own * moments.variance)
        count, total, noise, square = np.where(is_alone[:, None], own * each, others).swapaxes(0, 1)
        mean, noise = total / count, noise / count
        # Assume that all bins are like the mean of the window, or like themselves.
        of_window = _larger_of_next(np.maximum(noise / mean**2, bare))
        of_bin = _larger_of_next(np.maximum(noise / np.maximum(square / count, mean**2), bare))
        dof = np.where(is_alone, 0.0, 2 * count / of_window)
        # Start with the widest window, and moderate each narrower one with the result so far.
        variance = np.where(is_alone[-1], moments.variance, mean[-1])
        relative = np.where(is_alone[-1], bare, 2 / dof[-1])
        for k in reversed(range(len(count) - 1)):
            variance, relative = _moderate(mean[k], dof[k], variance, relative, PRIOR_DOF)
        # A few other bins do not show how much bins differ: then a bin judges itself, as if it were alone.
        trust = np.where(is_alone[-1], 0.0, np.minimum(1.0, count[-1] / MIN_SIMILAR_BINS))
        share = 1 + (OWN_SHARE - 1) * trust
        of_own = share * 2 / (trust * of_bin[0] + (1 - trust) * bare)
        variance, relative = _moderate(moments.variance, of_own, variance, relative, trust * 2 / relative)
    return variance, 2 / relative, 2 / of_bin.max(axis=0), trust


def _chance_of(ratio: np.ndarray, dof: np.ndarray) -> np.ndarray:
    """Probability that a bin's own variance exceeds the true one by this ratio."""
    from scipy.special import gammaincc

    return gammaincc(dof / 2, dof / 2 * ratio)


def _moderate(
    inner: np.ndarray, dof: np.ndarray, wider: np.ndarray, relative: np.ndarray, prior: np.ndarray | float
) -> tuple[np.ndarray, np.ndarray]:
    """A variance with `dof` degrees of freedom, moderated by a wider one, and its relative variance."""
    weight = dof / (dof + prior)
    return weight * inner + (1 - weight) * wider, weight * 2 / (dof + prior) + (1 - weight) ** 2 * relative


def _has_few_scores(
    moments: Moments,
    bins: np.ndarray,
    shape: tuple[int, ...],
    axes: Sequence[int],
    periodic: Sequence[int],
) -> np.ndarray:
    """Return whether the values have too few scores: thin bins among which most are sparse."""
    if not moments.is_sparse.any():
        return moments.is_sparse
    marks = np.zeros((2, math.prod(shape)))
    marks[:, bins] = moments.is_sparse, np.ones(bins.size)
    sums = window_sums(
        marks.reshape(2, *shape), SPARSE_REACH, [1 + axis for axis in axes], [1 + axis for axis in periodic]
    )
    sparse, all_ = sums.reshape(2, -1)[:, bins]
    return moments.is_thin & (2 * sparse >= all_)


def _larger_of_next(values: np.ndarray) -> np.ndarray:
    """For each window the larger of its own value and that of the next wider one."""
    return np.maximum(values, np.concatenate([values[1:], values[-1:]]))


def window_sums(terms: np.ndarray, reach: int, axes: Sequence[int], periodic: Sequence[int]) -> np.ndarray:
    """Return sums over windows of `reach` bins to each side along `axes`.

    Sums of 2, 4, 8, ... neighbours are built from each other, so that nothing is subtracted and nothing
    cancels.  The window is cut off at the end of an axis, and continues at the other end of a periodic axis.
    """
    for axis in axes:
        length = terms.shape[axis]
        far = min(reach, (length - 1) // 2 if axis in periodic else length - 1)
        if far:
            moved = np.moveaxis(terms, axis, -1)
            ends = [(0, 0)] * (terms.ndim - 1) + [(far, far)]
            padded = np.pad(moved, ends, mode="wrap" if axis in periodic else "constant")
            terms = np.moveaxis(_running_sums(padded, 2 * far + 1), -1, axis)
    return terms


def _running_sums(values: np.ndarray, width: int) -> np.ndarray:
    """Sums of `width` neighbours along the last axis, at each place that has all of them."""
    found, done = None, 0  # sums of the first `done` neighbours from each place
    of_power, power = values, 1
    left = values.shape[-1] - width + 1
    while power <= width:
        if width & power:
            part = of_power[..., done : done + left]
            found = part if found is None else found + part
            done += power
        if 2 * power <= width:
            of_power = of_power[..., :-power] + of_power[..., power:]
        power *= 2
    return found


def covers_circle(edges: np.ndarray) -> bool:
    """Return whether azimuth bins with these edges [rad] cover the circle."""
    return math.isclose(edges[-1] - edges[0], 2 * math.pi, rel_tol=1e-9)
