"""Étendue, or throughput: how many rays a beam holds, T = n^2 ∬ cosθ dω dA; every lossless optic hands it on unchanged.

In the coordinates x, y and p = n times the direction cosines it is a volume, ∬ dx dy dp_x dp_y, as cosθ dω = dp_x dp_y;
straight lines, mirrors, refraction and an ideal lens keep it (Liouville; Straubel 1902; Hanrahan 2001, Stanford CS 348B,
lecture 4, "Throughput").  In the plane of the axis rays keep the area ∬ dx dp.  What lies between two apertures is in
elements.py (`disks_throughput`), what glass lets through of it in glass_lenses.py.
"""

from __future__ import annotations

import math

import numpy as np

from transport.theory.optical_paths import Rays, from_to


def cone_etendue(area: float, half_angle: float = math.pi / 2, index: float = 1.0) -> float:
    """Throughput of an area with a cone of directions about its normal [m^2 sr]: n^2 pi A sin^2 theta.  Vectorised."""
    return np.square(index * np.sin(half_angle)) * math.pi * area


def meridional_etendue(half_1: float, half_2: float, distance: float) -> float:
    """∬ dx dp of the rays in one plane between two facing slits [m], by their half widths: 2 (crossed - uncrossed).

    Crossed and uncrossed: straight lines between their ends (Hottel 1954), whose squares differ by 4 half_1 half_2, so
    that nothing cancels.  Vectorised.
    """
    crossed = np.hypot(distance, np.add(half_1, half_2))
    uncrossed = np.hypot(distance, np.subtract(half_1, half_2))
    return 8 * np.multiply(half_1, half_2) / (crossed + uncrossed)


def meridional_outline(
    half_1: float, height_1: float, half_2: float, height_2: float, points: int = 200
) -> Rays:
    """The outermost rays in the plane y = 0 from one slit about the z axis to another, once round, (4 points, 3) [m].

    half_1, half_2: their half widths at these heights.  Traced on, they bound the beam in x and p at every place.
    """
    run, still = np.linspace(-1, 1, points, endpoint=False), np.ones(points)
    one = half_1 * np.concatenate([run, still, -run, -still])
    two = half_2 * np.concatenate([-still, run, still, -run])
    start, end = (
        np.stack([x, 0 * x, np.full_like(x, z)], axis=-1) for x, z in ((one, height_1), (two, height_2))
    )
    return from_to(start, end)


def outlined_area(x: np.ndarray, p: np.ndarray) -> float:
    """Area within a closed outline in x and p (Gauss' shoelace formula); the sense of rotation does not matter."""
    return float(abs(np.sum(x * np.roll(p, -1) - p * np.roll(x, -1))) / 2)
