"""Quantiles by inverting cumulative distributions, accurate relatively in both tails.

A tail is always measured from its own end, never as one minus the rest.
"""

from collections.abc import Callable

import numpy as np

LARGEST_U = 1 - 2.0**-53  # the largest u below 1
MAX_STEPS = 100
STEP_TOLERANCE = 2.0**-30  # relative Newton step at which to stop: the error is its square
MAX_PANELS = 1 << 16
NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)
NODES, WEIGHTS = (NODES + 1) / 2, WEIGHTS / 2  # on [0, 1]


def increasing_root(
    misfit: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]], low: np.ndarray, high: np.ndarray
) -> np.ndarray:
    """Return x >= 0, elementwise, at which an increasing function between `low` and `high` is 0.

    misfit: x -> (logarithm of value over target, its slope times x). Newton's method in log x, with bisection
    if a step would leave the bracket.
    """
    low, high = np.array(low, float), np.array(high, float)
    x = 0.5 * (low + high)
    with np.errstate(all="ignore"):
        for _ in range(MAX_STEPS):
            value, slope = misfit(x)
            above = value > 0
            high, low = np.where(above, x, high), np.where(above, low, x)
            trial = x * np.exp(-value / slope)
            trial = np.where((trial >= low) & (trial <= high), trial, 0.5 * (low + high))
            is_done = np.abs(trial - x) <= STEP_TOLERANCE * x
            x = trial
            if is_done.all():
                break
    return x


def log_ratio(value: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Return log(value / target) without the rounding of the quotient if they are nearly equal."""
    return np.log1p((value - target) / target)


class PiecewiseQuadraticDensity:
    """A piecewise density between knots, on each piece a quadratic in Bernstein form.

    coefficients: (pieces, 3), none negative, so that all terms of each sum below are positive. `mass` is the
    integral.
    """

    def __init__(self, knots: np.ndarray, coefficients: np.ndarray) -> None:
        pieces = np.diff(knots) * coefficients.sum(axis=1) / 3
        self.mass = float(pieces.sum())
        self._from_low = _cumulative_table(knots, coefficients / self.mass)
        self._from_high = _cumulative_table(-knots[::-1], coefficients[::-1, ::-1] / self.mass)

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """Return the positions at which the integral reaches the fraction u of the total."""
        u = np.asarray(u, float)
        x = np.empty(u.shape)
        upper = u > 0.5
        x[~upper] = _invert_table(*self._from_low, u[~upper])
        x[upper] = -_invert_table(*self._from_high, 1 - u[upper])
        return x


def _cumulative_table(
    knots: np.ndarray, coefficients: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return knots, coefficients, and the integral below each knot."""
    return knots, coefficients, _cumulative_sums(np.diff(knots) * coefficients.sum(axis=1) / 3)


def _invert_table(
    knots: np.ndarray, coefficients: np.ndarray, below: np.ndarray, t: np.ndarray
) -> np.ndarray:
    """Return where the integral from the lowest knot reaches t; measured from the nearer end of its piece."""
    # Find the piece, and measure from its nearer end.
    piece = np.clip(np.searchsorted(below, t, side="right") - 1, 0, len(knots) - 2)
    from_left, from_right = t - below[piece], below[piece + 1] - t
    flip = from_right < from_left
    b0, b1, b2 = np.where(flip[:, None], coefficients[piece, ::-1], coefficients[piece]).T
    width = knots[piece + 1] - knots[piece]
    target = np.where(flip, from_right, from_left) / width

    # Solve for the position y within the piece, in units of its width.
    def misfit(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        rest = 1 - y
        integral = y * (b0 * rest * rest + y * ((b0 + b1) * rest + y * ((b0 + b1 + b2) / 3)))
        density = b0 * rest * rest + y * (2 * b1 * rest + y * b2)
        return log_ratio(integral, target), y * density / integral

    y = increasing_root(misfit, np.zeros(t.shape), np.ones(t.shape))
    x = width * np.where(target > 0, y, 0.0)
    return np.where(flip, knots[piece + 1] - x, knots[piece] + x)


class SelfWeightedQuantile:
    """The distribution of a quantile function q(u), weighted by |q|; `mean` is the mean of |q|.

    Gauss-Legendre quadrature on panels that shrink geometrically towards both ends of [0, 1) and are halved
    where q is not smooth: exact to rounding, jumps included. Near 1, however, u is known to 2^-53 only: an
    unbounded tail has a relative error of about 2^-53 / (1 - u).
    """

    def __init__(self, q: Callable[[np.ndarray], np.ndarray]) -> None:
        self._quantile = q
        lower = _refine_panels(self._weight, *_octave_panels(120), False)
        upper = _refine_panels(self._weight, *_octave_panels(53), True)
        # Concatenate the panels in order of u; above 1/2 a position is 1 - u, which decreases.
        self._start = np.concatenate([lower[0], upper[1][::-1]])
        self._end = np.concatenate([lower[1], upper[0][::-1]])
        self._is_upper = np.arange(len(self._start)) >= len(lower[0])
        pieces = _integral(self._weight, self._start, self._end, self._is_upper)
        self._below, self._sums_from_high = _cumulative_sums(pieces), _cumulative_sums(pieces[::-1])
        self.mean = float(self._below[-1])

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """Return q at which the integral of |q| reaches the fraction u of the total."""
        u = np.asarray(u, float)
        place, upper = np.empty(u.shape), u > 0.5
        place[~upper] = self._inverse(u[~upper], self._below, self._start, self._end, self._is_upper)
        down = self._sums_from_high, self._end[::-1], self._start[::-1], self._is_upper[::-1]
        place[upper] = self._inverse(1 - u[upper], *down)
        return self._quantile(np.minimum(place, LARGEST_U))

    def _weight(self, place: np.ndarray, is_upper: np.ndarray | bool) -> np.ndarray:
        return np.abs(self._quantile(np.where(is_upper, np.minimum(1 - place, LARGEST_U), place)))

    def _inverse(self, share, sums, start, end, is_upper) -> np.ndarray:
        """Return the u at which the integral, from the first panel on, reaches the share of the total."""
        target = share * sums[-1]
        panel = np.clip(np.searchsorted(sums, target, side="right") - 1, 0, len(start) - 1)
        start, width, is_upper = start[panel], end[panel] - start[panel], is_upper[panel]
        rest = target - sums[panel]

        def misfit(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            place = start + y * width
            integral = _integral(self._weight, start, place, is_upper)
            return log_ratio(integral, rest), y * np.abs(width) * self._weight(place, is_upper) / integral

        y = increasing_root(misfit, np.zeros(rest.shape), np.ones(rest.shape))
        place = start + width * np.where(rest > 0, y, 0.0)
        return np.where(is_upper, 1 - place, place)


def _octave_panels(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return lower and upper ends of panels over [0, 1/2]."""
    edges = np.concatenate([[0.0], 2.0 ** np.arange(-float(count), 0.0)])
    return edges[:-1], edges[1:]


def _cumulative_sums(pieces: np.ndarray) -> np.ndarray:
    return np.concatenate([[0.0], np.cumsum(pieces.astype(np.longdouble))]).astype(float)


def _integral(
    weight: Callable, start: np.ndarray, end: np.ndarray, is_upper: np.ndarray | bool
) -> np.ndarray:
    width = end - start
    places = start[:, None] + width[:, None] * NODES
    return np.abs(width) * (weight(places, np.reshape(is_upper, (-1, 1))) @ WEIGHTS)


def _refine_panels(
    weight: Callable, low: np.ndarray, high: np.ndarray, is_upper: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return the panels, halved until halving changes no integral by more than the rounding of u."""
    least = 2.0**-58 * _integral(weight, low, high, is_upper).sum()
    kept = []
    # Halve all panels whose two halves do not add up to the whole; keep the others.
    while len(low):
        middle = 0.5 * (low + high)
        halves = _integral(weight, low, middle, is_upper) + _integral(weight, middle, high, is_upper)
        size = low + high + is_upper  # magnitude that determines the rounding of u
        noise = 2.0**-52 * size * np.abs(weight(high, is_upper) - weight(low, is_upper))
        wrong = np.abs(halves - _integral(weight, low, high, is_upper)) > 2.0**-50 * halves + noise + least
        wrong &= (middle > low) & (middle < high) & (len(kept) + 2 * len(low) <= MAX_PANELS)
        kept += zip(low[~wrong], high[~wrong], strict=True)
        low, high = (
            np.concatenate([low[wrong], middle[wrong]]),
            np.concatenate([middle[wrong], high[wrong]]),
        )
    return tuple(np.array(sorted(kept)).T)
