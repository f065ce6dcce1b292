"""Quantiles by inverting cumulative laws, accurate relatively in both tails.

A tail is always measured from its own end: what lies above is never taken as one minus what lies below.
"""

from collections.abc import Callable

import numpy as np

LAST = 1 - 2.0**-53  # the largest u below 1
MOST_STEPS = 100
CLOSE = 2.0**-30  # a step of Newton's, relative, after which the error is its square
MOST_PANELS = 1 << 16
NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)
NODES, WEIGHTS = (NODES + 1) / 2, WEIGHTS / 2  # on [0, 1]


def increasing_root(
    misfit: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]], low: np.ndarray, high: np.ndarray
) -> np.ndarray:
    """x >= 0 at which a misfit, increasing between `low` and `high`, is 0; arrays, each lane by itself.

    misfit: x -> (logarithm of value over target, its slope times x).  Newton in log x, halving where it would leave
    the bracket.
    """
    low, high = np.array(low, float), np.array(high, float)
    x = 0.5 * (low + high)
    with np.errstate(all="ignore"):
        for _ in range(MOST_STEPS):
            value, slope = misfit(x)
            above = value > 0
            high, low = np.where(above, x, high), np.where(above, low, x)
            trial = x * np.exp(-value / slope)
            trial = np.where((trial >= low) & (trial <= high), trial, 0.5 * (low + high))
            is_done = np.abs(trial - x) <= CLOSE * x
            x = trial
            if is_done.all():
                break
    return x


def log_ratio(value: np.ndarray, target: np.ndarray) -> np.ndarray:
    """log(value / target), without the rounding of the quotient where they are nearly equal."""
    return np.log1p((value - target) / target)


class PiecewiseLaw:
    """A density on pieces between knots, on each of them a quadratic in Bernstein form.

    coefficients: (pieces, 3), none below 0, so that every sum below is one of positive terms.  `mass` is the integral.
    """

    def __init__(self, knots: np.ndarray, coefficients: np.ndarray) -> None:
        pieces = np.diff(knots) * coefficients.sum(axis=1) / 3
        self.mass = float(pieces.sum())
        self._up = _ladder(knots, coefficients / self.mass)
        self._down = _ladder(-knots[::-1], coefficients[::-1, ::-1] / self.mass)

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """Where the integral reaches the share u of the whole."""
        u = np.asarray(u, float)
        x = np.empty(u.shape)
        upper = u > 0.5
        x[~upper] = _climb(*self._up, u[~upper])
        x[upper] = -_climb(*self._down, 1 - u[upper])
        return x


def _ladder(knots: np.ndarray, coefficients: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Knots, coefficients, and the integral below each knot."""
    pieces = (np.diff(knots) * coefficients.sum(axis=1) / 3).astype(np.longdouble)
    return knots, coefficients, np.concatenate([[0.0], np.cumsum(pieces)]).astype(float)


def _climb(knots: np.ndarray, coefficients: np.ndarray, below: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Where the integral from the lowest knot reaches t; within a piece measured from the end that is nearer."""
    piece = np.clip(np.searchsorted(below, t, side="right") - 1, 0, len(knots) - 2)
    from_left, from_right = t - below[piece], below[piece + 1] - t
    flip = from_right < from_left
    b0, b1, b2 = np.where(flip[:, None], coefficients[piece, ::-1], coefficients[piece]).T
    width = knots[piece + 1] - knots[piece]
    target = np.where(flip, from_right, from_left) / width

    def misfit(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        rest = 1 - y
        integral = y * (b0 * rest * rest + y * ((b0 + b1) * rest + y * ((b0 + b1 + b2) / 3)))
        density = b0 * rest * rest + y * (2 * b1 * rest + y * b2)
        return log_ratio(integral, target), y * density / integral

    y = increasing_root(misfit, np.zeros(t.shape), np.ones(t.shape))
    x = width * np.where(target > 0, y, 0.0)
    return np.where(flip, knots[piece + 1] - x, knots[piece] + x)


class WeightedByItself:
    """The law of a quantile function q(u), weighted by |q|: `mean` is the mean of |q|.

    Gauss-Legendre on panels that shrink geometrically towards both ends of [0, 1) and are halved where q is not smooth:
    exact to rounding, jumps included, but that near 1 a u is known to 2^-53 only, so that a tail that is not bounded
    has a relative error of about 2^-53 / (1 - u).
    """

    def __init__(self, q: Callable[[np.ndarray], np.ndarray]) -> None:
        self._q = q
        self._ups = _Panels(lambda u: np.abs(q(u)), first=-120, granularity=0.0)
        self._downs = _Panels(lambda rest: np.abs(q(np.minimum(1 - rest, LAST))), first=-53, granularity=1.0)
        self.mean = self._ups.whole + self._downs.whole

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """q where the integral of |q| reaches the share u of the whole."""
        u = np.asarray(u, float)
        place = np.empty(u.shape)
        upper = u * self.mean > self._ups.whole
        place[~upper] = self._ups.reached(u[~upper] * self.mean)
        place[upper] = 1 - self._downs.reached((1 - u[upper]) * self.mean)
        return self._q(np.minimum(place, LAST))


class _Panels:
    """Panels over [0, 1/2] on which the integral of f(t) >= 0 is known.

    first: the power of 2 that ends the lowest panel.  granularity: 1 where f rounds t as a part of 1, else 0.
    """

    def __init__(self, f: Callable[[np.ndarray], np.ndarray], first: int, granularity: float) -> None:
        self._f, self._granularity = f, granularity
        edges = np.concatenate([[0.0], 2.0 ** np.arange(float(first), 0.0)])
        self._low, self._high = self._refined(edges[:-1], edges[1:])
        pieces = self._integral(self._low, self._high).astype(np.longdouble)
        self._below = np.concatenate([[0.0], np.cumsum(pieces)]).astype(float)
        self.whole = float(self._below[-1])

    def reached(self, target: np.ndarray) -> np.ndarray:
        """t at which the integral from 0 reaches the target."""
        panel = np.clip(np.searchsorted(self._below, target, side="right") - 1, 0, len(self._low) - 1)
        low, width = self._low[panel], self._high[panel] - self._low[panel]
        rest = target - self._below[panel]

        def misfit(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            integral = self._integral(low, low + y * width)
            return log_ratio(integral, rest), y * width * self._f(low + y * width) / integral

        y = increasing_root(misfit, np.zeros(rest.shape), np.ones(rest.shape))
        return low + width * np.where(rest > 0, y, 0.0)

    def _integral(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        width = high - low
        return width * (self._f(low[:, None] + width[:, None] * NODES) @ WEIGHTS)

    def _refined(self, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The panels, halved until halving changes no integral by more than rounding does."""
        least = 2.0**-58 * self._integral(low, high).sum()
        kept = []
        while len(low):
            middle = 0.5 * (low + high)
            halves = self._integral(low, middle) + self._integral(middle, high)
            noise = 2.0**-52 * (low + high + self._granularity) * np.abs(self._f(high) - self._f(low))
            wrong = np.abs(halves - self._integral(low, high)) > 2.0**-50 * halves + noise + least
            wrong &= (middle > low) & (middle < high)
            if len(kept) + 2 * len(low) > MOST_PANELS:
                wrong[:] = False
            kept += zip(low[~wrong], high[~wrong], strict=True)
            low, high = (
                np.concatenate([low[wrong], middle[wrong]]),
                np.concatenate([middle[wrong], high[wrong]]),
            )
        return tuple(np.array(sorted(kept)).T)
