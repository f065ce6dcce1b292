"""Mean, variance and best size of a count within an element of finite size.

An element of width h about a point estimates the value f at the point. Its mean is biased by about f''
h²/24, and its variance falls with the number of particles that it catches: large elements blur, small
ones are noisy.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np


class Moments(NamedTuple):
    """Exact means of elements and the terms of their variances, one entry per element.

    Parameters
    ----------
    mean : ndarray
        Exact mean over the element.
    second : ndarray
        Number of histories times the mean square of one history's contribution to the mean.
    square : ndarray
        Term that is subtracted from `second` for the square of the mean.
    """

    mean: np.ndarray
    second: np.ndarray
    square: np.ndarray

    def variance(self, histories: float, parts: int = 1) -> np.ndarray:
        """Return the variance of a mean estimated from a number of histories.

        Parameters
        ----------
        histories : float
            Number of histories N [1].
        parts : int, default 1
            Number of equal parts of the detector; the mean is taken over one part [1].

        Returns
        -------
        ndarray
            ``(parts second - square)/N``, square of the mean's unit.
        """
        return (parts * self.second - self.square) / histories

    def deviation(self, value: float, histories: float, parts: int = 1) -> np.ndarray:
        """Return the root mean square deviation from the value at the point.

        Parameters
        ----------
        value : float
            Value at the point, in the mean's unit.
        histories : float
            Number of histories [1].
        parts : int, default 1
            Number of equal parts of the detector [1].

        Returns
        -------
        ndarray
            ``sqrt(bias² + variance)``, in the mean's unit.
        """
        return np.sqrt((self.mean - value) ** 2 + self.variance(histories, parts))


def root_mean(squares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Root of a mean over measurements and its standard error.

    Parameters
    ----------
    squares : ndarray
        Measured squares, shape (measurements, ...).

    Returns
    -------
    tuple of ndarray
        Root of the mean over the first axis, and its standard error (nan for a single measurement),
        both in the root's unit.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.counting import root_mean
    >>> print(root_mean(np.array([[1.0], [4.0]]))[0].round(4))
    [1.5811]
    """
    root = np.sqrt(squares.mean(axis=0))
    if len(squares) < 2:
        return root, np.full_like(root, math.nan)
    return root, squares.std(axis=0, ddof=1) / math.sqrt(len(squares)) / (2 * root)


def best_width(value: float, curvature: float, rate: float, histories: float) -> float:
    """Width of the element whose mean has the least mean square deviation from the value at a point.

    Parameters
    ----------
    value : float or ndarray
        Value f at the point.
    curvature : float or ndarray
        Second derivative f'' at the point.
    rate : float or ndarray
        An element of width h receives rate f h scores per history, all of one weight.
    histories : float or ndarray
        Number of histories N [1].

    Returns
    -------
    float or ndarray
        Best width h, in the unit of the width.

    Notes
    -----
    The bias is f'' h²/24 and the variance f / (rate N h). Their sum bias² + variance is least at
    ``h = (144 f / (rate N f''²))^(1/5)``, where the variance is four times the squared bias (Rosenblatt
    1956, Ann. Math. Stat. 27, 832, for the same estimate of a density).

    Examples
    --------
    >>> from transport.theory.counting import best_width
    >>> print(f"{best_width(1.0, 2.0, 1.0, 1e4):.4g}")
    0.3245
    """
    return (144 * value / (rate * np.asarray(histories) * np.square(curvature))) ** 0.2


def burst_moments(low: np.ndarray, high: np.ndarray, fluence: float, sigma: float, share: float) -> Moments:
    """Moments of the mean irradiance of a Gaussian burst over time spans.

    Parameters
    ----------
    low : ndarray
        Start of each span after the peak, shape (n,) [s].
    high : ndarray
        End of each span after the peak, shape (n,) [s].
    fluence : float
        Fluence of the whole burst [J m^-2].
    sigma : float
        Standard deviation of the burst in time [s].
    share : float
        Share of the histories that reach the detector [1].

    Returns
    -------
    Moments
        Means [W m^-2] and the terms of their variances, shape (n,).

    Notes
    -----
    A span holds the share ``Φ(high/σ) - Φ(low/σ)`` of the burst, with Φ the normal distribution.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.counting import burst_moments
    >>> print(burst_moments(np.array([-1.0]), np.array([1.0]), 1.0, 1.0, 1.0).mean.round(4))
    [0.3413]
    """
    from scipy.special import ndtr

    part = ndtr(np.divide(high, sigma)) - ndtr(np.divide(low, sigma))
    mean = fluence * part / np.subtract(high, low)
    return Moments(mean, mean**2 / (share * part), mean**2)


def burst_peak(fluence: float, sigma: float) -> float:
    """Irradiance at the peak of a Gaussian burst.

    Parameters
    ----------
    fluence : float
        Fluence of the whole burst [J m^-2].
    sigma : float
        Standard deviation in time [s].

    Returns
    -------
    float
        ``fluence / (sqrt(2 pi) σ)`` [W m^-2].

    Examples
    --------
    >>> from transport.theory.counting import burst_peak
    >>> print(f"{burst_peak(1.0, 1.0):.4g}")
    0.3989
    """
    return fluence / (math.sqrt(2 * math.pi) * sigma)
