"""A number, or an array of them, from batches: the value, and the deviations of the batches from it.

It has no units and names.  Linear operations act on the deviations, all others use the jackknife.  Deviations
of one run keep its correlations; those of different runs add in quadrature.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, reduce

import numpy as np

from transport.statistics.batches import (
    pseudo_shifts,
    rounding_error,
    standard_error,
    weighted_mean,
    welch_dof,
)
from transport.statistics.findings import CONSTANT, MIN_EQUAL_BATCHES, NO_SCORE


@dataclass(frozen=True, eq=False)
class Batches:
    """The batches of one run, by their numbers of histories; the object, not its sizes, identifies a run.

    Parameters
    ----------
    sizes : numpy.ndarray
        Numbers of histories, shape (B,), positive integers.
    is_even : bool, default False
        Whether the histories of a batch are points of one low-discrepancy net, so that batches are more equal
        than random ones.

    Raises
    ------
    ValueError
        For a batch without a history.

    Examples
    --------
    >>> import numpy as np
    >>> len(Batches(np.array([100, 100, 50])))
    3
    """

    sizes: np.ndarray
    is_even: bool = False

    def __post_init__(self) -> None:
        sizes = np.array(self.sizes, dtype=np.int64)
        if sizes.ndim != 1 or len(sizes) == 0 or (sizes < 1).any():
            raise ValueError(f"Batches: sizes must be a row of positive whole numbers, got {self.sizes!r}")
        sizes.flags.writeable = False
        object.__setattr__(self, "sizes", sizes)

    def __len__(self) -> int:
        return len(self.sizes)

    @property
    def histories(self) -> int:
        """Number of histories in all batches.

        Returns
        -------
        int
        """
        return int(self.sizes.sum())


@dataclass(frozen=True, eq=False)
class Replicates:
    """Values with the deviations of the batches from them; without deviations they are exact.

    value, scores, scale: (*dims);  deviations: {run: (B, *dims)};  runs: those that contribute, exact or not.
    """

    value: np.ndarray
    deviations: dict[Batches, np.ndarray]
    scores: np.ndarray  # number of scores; infinite if not counted, or if the value is exact
    runs: tuple[Batches, ...]
    scale: np.ndarray  # size of the largest added term: a spread within its rounding is none

    is_chunked = False  # whether it is computed in chunks, as for very many bins (chunked.py)

    @classmethod
    def of_batches(
        cls, values: np.ndarray, run: Batches, exact: bool, counts: np.ndarray | None
    ) -> Replicates:
        """Make replicates from batch means, (B, *dims), and counts of scores, (*dims), if known."""
        values = np.asarray(values, dtype=float)
        if len(values) != len(run):
            raise ValueError(f"{len(values)} batch values for a run of {len(run)} batches")
        with np.errstate(invalid="ignore", over="ignore"):
            value = weighted_mean(values, run.sizes)
            deviations = values - value
        is_scored = (values != 0).any(axis=0)  # a score too small for the digits of a sum counts as none
        scores = np.where(is_scored, np.inf if counts is None else counts, 0.0)
        return _without_rounding(value, {} if exact else {run: deviations}, scores, (run,))

    @classmethod
    def constant(cls, value: np.ndarray | float, runs: tuple[Batches, ...] = ()) -> Replicates:
        """Make replicates of an exact value."""
        return _without_rounding(np.asarray(value, dtype=float), {}, np.inf, runs)

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of bins along the axes."""
        return self.value.shape

    @property
    def is_exact(self) -> bool:
        """Whether the value is the same for every history by construction."""
        return not self.deviations

    @cached_property
    def error(self) -> np.ndarray:
        """One standard error, (*dims); nan where it cannot be known, see `reason`."""
        with np.errstate(invalid="ignore", over="ignore"):
            errors = [standard_error(deviations, run.sizes) for run, deviations in self.deviations.items()]
            error = reduce(np.hypot, errors, np.zeros(self.value.shape))
        return _read_only(np.where(np.equal(self.reason, None), error, np.nan))

    @cached_property
    def reason(self) -> np.ndarray:
        """Why the error is unknown, (*dims) of str, or None where it is known; the most important reason."""
        reason = np.full(self.value.shape, None, dtype=object)
        spreads = {run: np.abs(deviations).max(axis=0) for run, deviations in self.deviations.items()}
        if spreads:
            reason[reduce(np.fmax, spreads.values()) == 0] = CONSTANT
        for run, spread in spreads.items():
            if len(run) < MIN_EQUAL_BATCHES:  # chance may have made the batches equal
                reason[spread == 0] = CONSTANT
            reason[np.isnan(spread)] = "too few scores or digits"
            if len(run) < 2:
                reason[...] = "fewer than 2 batches"
        if not self.is_exact:
            reason[self.scores == 0] = NO_SCORE
        reason[~np.isfinite(self.value)] = "undefined: not finite"
        return _read_only(reason)

    @cached_property
    def dof(self) -> np.ndarray:
        """Degrees of freedom of the error, (*dims): batches - 1, effective ones for several runs."""
        if self.is_exact:
            return np.full(self.value.shape, np.inf)
        with np.errstate(invalid="ignore", over="ignore"):
            errors = [standard_error(deviations, run.sizes) for run, deviations in self.deviations.items()]
            return welch_dof(errors, [len(run) - 1 for run in self.deviations])

    def release_pages(self) -> None:
        """Release memory-mapped pages until the next access."""

    def unless(self, too_few: np.ndarray) -> Replicates:
        """Return these replicates with unknown error where `too_few`, (*dims) of bool, is true."""
        deviations = {run: np.where(too_few, np.nan, of_run) for run, of_run in self.deviations.items()}
        return _broadcast(self.value, deviations, self.scores, self.runs, self.scale)

    def rearranged(self, change: Callable[[np.ndarray], np.ndarray]) -> Replicates:
        """Replicates after a change of the last axes that keeps those in front, such as x[..., i]."""
        deviations = {run: change(of_run) for run, of_run in self.deviations.items()}
        value, scores, scale = (change(part) for part in (self.value, self.scores, self.scale))
        return _broadcast(value, deviations, scores, self.runs, scale)

    def indexed(self, index: tuple[int | slice, ...]) -> Replicates:
        """Replicates of the bins of an index with one whole number or slice per axis."""
        return self.rearranged(lambda array: array[(..., *index)])

    def along(self, own: tuple[str, ...], dims: tuple[str, ...]) -> Replicates:
        """Rearrange axes `own` into the order of `dims`; missing axes get length 1."""
        return self.rearranged(lambda array: with_axes(array, own, dims))

    def summed(self, axis: int) -> Replicates:
        """Replicates of the sum over a bin axis, counted from the end."""
        with np.errstate(invalid="ignore", over="ignore"):
            deviations = {run: of_run.sum(axis=axis) for run, of_run in self.deviations.items()}
            value, scale = self.value.sum(axis=axis), self.scale.sum(axis=axis)
        return _without_rounding(value, deviations, self.scores.sum(axis=axis), self.runs, scale)


def with_axes(array: np.ndarray, own: tuple[str, ...], dims: tuple[str, ...]) -> np.ndarray:
    """Rearrange the last axes `own` of an array into the order of `dims`; missing axes get length 1."""
    order = [own.index(name) - len(own) for name in dims if name in own]
    index = (..., *(slice(None) if name in own else None for name in dims))
    return np.moveaxis(array, order, range(-len(own), 0))[index]


def added(first: Replicates, second: Replicates, sign: int) -> Replicates:
    """first + second, or first - second for sign -1."""
    if large := _first_chunked(first, second):
        return large.mapped(lambda *parts: added(*parts, sign), (first, second))
    runs = dict.fromkeys((*first.deviations, *second.deviations))
    with np.errstate(invalid="ignore", over="ignore"):
        deviations = {
            run: first.deviations.get(run, 0.0) + sign * second.deviations.get(run, 0.0) for run in runs
        }
        value, scale = first.value + sign * second.value, np.fmax(first.scale, second.scale)
    return _without_rounding(value, deviations, first.scores + second.scores, first.runs + second.runs, scale)


def product(first: Replicates, second: Replicates) -> Replicates:
    """first * second."""
    return combined(np.multiply, first, second, linear_in=(0, 1))


def ratio(first: Replicates, second: Replicates) -> Replicates:
    """first / second."""
    return combined(np.divide, first, second, linear_in=(0,))


def power(base: Replicates, exponent: float) -> Replicates:
    """base ** exponent."""
    return combined(lambda value: np.power(value, float(exponent)), base)


def combined(function: Callable, *operands: Replicates, linear_in: tuple[int, ...] = ()) -> Replicates:
    """A function of replicates, without its O(1/B) bias and with its first-order error, by the jackknife.

    linear_in: operands in which the function is linear while the others are fixed; if only one of these is
    uncertain, no jackknife is needed.
    """
    if large := _first_chunked(*operands):
        return large.mapped(lambda *parts: combined(function, *parts, linear_in=linear_in), operands)
    means = [operand.value for operand in operands]
    scores = reduce(np.minimum, [operand.scores for operand in operands])
    runs = sum((operand.runs for operand in operands), ())
    uncertain = [place for place, operand in enumerate(operands) if not operand.is_exact]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        value = np.asarray(function(*means))
        deviations = {}
        # Propagate the deviations: directly if the function is linear in them, else by the jackknife.
        for run in dict.fromkeys(run for operand in operands for run in operand.deviations):
            of_run = [operand.deviations.get(run, 0.0) for operand in operands]
            if len(uncertain) == 1 and uncertain[0] in linear_in:
                (place,) = uncertain
                deviations[run] = function(*means[:place], of_run[place], *means[place + 1 :])
            elif len(run) < 2:
                deviations[run] = np.zeros((1, *value.shape))
            else:
                shifts = pseudo_shifts(function, means, of_run, run.sizes)
                shifts = np.where(np.isfinite(shifts).all(axis=0), shifts, np.nan)
                correction = weighted_mean(shifts, run.sizes)
                deviations[run] = shifts - correction
                value = value + np.nan_to_num(correction)
        # Propagate the rounding of each operand's scale: the change of the function under it.
        moved = [
            np.abs(np.asarray(function(*means[:k], mean + operand.scale, *means[k + 1 :])) - value)
            for k, (mean, operand) in enumerate(zip(means, operands, strict=True))
        ]
        scale = reduce(np.fmax, [np.where(np.isfinite(each), each, 0.0) for each in moved])
    return _without_rounding(value, deviations, scores, runs, scale)


def _first_chunked(*operands: Replicates) -> Replicates | None:
    """The first chunked operand, if any; results are then chunked too."""
    return next((each for each in operands if each.is_chunked), None)


def _without_rounding(
    value: np.ndarray,
    deviations: dict,
    scores: np.ndarray | float,
    runs: tuple,
    scale: np.ndarray | float = 0.0,
) -> Replicates:
    """Make replicates without spreads that rounding alone can cause; scale: of the terms, if larger."""
    scale = np.fmax(np.abs(value), scale)
    deviations = {
        run: np.where(np.abs(of_run) <= rounding_error(scale), 0.0, of_run)
        for run, of_run in deviations.items()
    }
    return _broadcast(value, deviations, scores, runs, scale)


def _broadcast(
    value: np.ndarray, deviations: dict, scores: np.ndarray | float, runs: tuple, scale: np.ndarray
) -> Replicates:
    """Make replicates whose arrays all have the shape of the value."""
    value = np.asarray(value, dtype=float)
    deviations = {
        run: _read_only(np.broadcast_to(of_run, (len(run), *value.shape)))
        for run, of_run in deviations.items()
    }
    runs = tuple(deviations) or tuple(dict.fromkeys(runs))
    scores, scale = (np.broadcast_to(part, value.shape) for part in (scores, scale))
    return Replicates(_read_only(value), deviations, scores, runs, scale)


def _read_only(array: np.ndarray) -> np.ndarray:
    view = array.view()
    view.flags.writeable = False
    return view
