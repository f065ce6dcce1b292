"""Mean chords of convex bodies along uniform, isotropic straight lines.

Such lines leave a diffuse inner wall: the same number per area, with the cosine law. Their mean chord
is 4 V/S for every convex body (Cauchy 1850; Dirac 1943; Coleman 1969, J. Appl. Prob. 6, 430).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np


def mean_chord(volume: float, surface: float) -> float:
    """Mean chord of a convex body.

    Parameters
    ----------
    volume : float or ndarray
        Volume V [m^3].
    surface : float or ndarray
        Surface area S [m^2].

    Returns
    -------
    float or ndarray
        ``4 V/S`` [m].

    Notes
    -----
    Source: Cauchy 1850.

    Examples
    --------
    >>> from transport.theory.chords import mean_chord
    >>> print(f"{mean_chord(1.0, 6.0):.4g}")
    0.6667
    """
    return 4 * np.divide(volume, surface)


def sphere_mean_chord(radius: float) -> float:
    """Mean chord of a sphere.

    Parameters
    ----------
    radius : float
        Radius R [m].

    Returns
    -------
    float
        ``4 R/3`` [m].

    Examples
    --------
    >>> from transport.theory.chords import sphere_mean_chord
    >>> print(f"{sphere_mean_chord(1.0):.4g}")
    1.333
    """
    return 4 / 3 * radius


def box_mean_chord(size: Sequence[float]) -> float:
    """Mean chord of a box.

    Parameters
    ----------
    size : sequence of float
        The three side lengths a, b, c [m].

    Returns
    -------
    float
        ``2 / (1/a + 1/b + 1/c)`` [m].

    Examples
    --------
    >>> from transport.theory.chords import box_mean_chord
    >>> print(f"{box_mean_chord((1.0, 2.0, 3.0)):.4g}")
    1.091
    """
    return 2 / math.fsum(1 / length for length in size)
