"""Chords of convex bodies, along straight lines that are uniform and isotropic.

Such lines are what a diffuse inner wall sends out: as many from each area, with the cosine law.  Their mean chord is
4 V/S for every convex body (Cauchy 1850; Dirac 1943; Coleman 1969, J. Appl. Prob. 6, 430).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np


def mean_chord(volume: float, surface: float) -> float:
    """Mean chord of a convex body [m]: 4 V/S (Cauchy 1850).  Vectorised."""
    return 4 * np.divide(volume, surface)


def sphere_mean_chord(radius: float) -> float:
    """Mean chord of a sphere [m]: 4 R/3."""
    return 4 / 3 * radius


def box_mean_chord(size: Sequence[float]) -> float:
    """Mean chord of a box of three lengths [m]: 2 / (1/a + 1/b + 1/c)."""
    return 2 / math.fsum(1 / length for length in size)
