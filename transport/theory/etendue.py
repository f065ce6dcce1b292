"""Étendue (throughput) of a beam, T = n^2 ∬ cosθ dω dA; every lossless optic conserves it.

In the coordinates x, y and p = n times the direction cosines it is a volume, ∬ dx dy dp_x dp_y, as cosθ
dω = dp_x dp_y; straight flight, mirrors, refraction and an ideal lens conserve it (Liouville; Straubel
1902; Hanrahan 2001, Stanford CS 348B, lecture 4, "Throughput"). In the plane of the axis rays conserve
the area ∬ dx dp. The throughput between two apertures is `elements.disks_throughput`, that through
glass is in glass_lenses.py.
"""

from __future__ import annotations

import math

import numpy as np

from transport.theory.optical_paths import Rays, from_to


def cone_etendue(area: float, half_angle: float = math.pi / 2, index: float = 1.0) -> float:
    """Throughput of an area with a cone of directions about its normal.

    Parameters
    ----------
    area : float or ndarray
        Area A [m^2].
    half_angle : float or ndarray, default math.pi / 2
        Half angle theta of the cone, up to pi/2 [rad].
    index : float or ndarray, default 1.0
        Refractive index n [1].

    Returns
    -------
    float or ndarray
        ``n^2 pi A sin^2 theta`` [m^2 sr].

    Examples
    --------
    >>> from transport.theory.etendue import cone_etendue
    >>> print(f"{cone_etendue(1.0, 0.5):.4g}")
    0.7221
    """
    return np.square(index * np.sin(half_angle)) * math.pi * area


def meridional_etendue(half_1: float, half_2: float, distance: float) -> float:
    """Throughput ``∬ dx dp`` of the rays in one plane between two facing slits.

    Parameters
    ----------
    half_1 : float or ndarray
        Half width of the first slit [m].
    half_2 : float or ndarray
        Half width of the second slit [m].
    distance : float or ndarray
        Distance between the slits [m].

    Returns
    -------
    float or ndarray
        ``2 (crossed - uncrossed)`` [m].

    Notes
    -----
    Crossed and uncrossed strings are the straight lines between the slits' ends (Hottel 1954). Their
    squares differ by ``4 half_1 half_2``, so that nothing cancels.

    Examples
    --------
    >>> from transport.theory.etendue import meridional_etendue
    >>> print(f"{meridional_etendue(1.0, 1.0, 2.0):.4g}")
    1.657
    """
    crossed = np.hypot(distance, np.add(half_1, half_2))
    uncrossed = np.hypot(distance, np.subtract(half_1, half_2))
    return 8 * np.multiply(half_1, half_2) / (crossed + uncrossed)


def meridional_outline(
    half_1: float, height_1: float, half_2: float, height_2: float, points: int = 200
) -> Rays:
    """Outermost rays in the plane y = 0 from one slit about the z axis to another, as a closed outline.

    Parameters
    ----------
    half_1 : float
        Half width of the first slit [m].
    height_1 : float
        Height z of the first slit [m].
    half_2 : float
        Half width of the second slit [m].
    height_2 : float
        Height z of the second slit [m].
    points : int, default 200
        Number of rays per side of the outline.

    Returns
    -------
    Rays
        Rays, shape (4 points, 3) [m]. Traced on, they bound the beam in x and p at every height.

    Examples
    --------
    >>> from transport.theory.etendue import meridional_outline
    >>> meridional_outline(1.0, 0.0, 1.0, 2.0, points=5).points.shape
    (20, 3)
    """
    run, still = np.linspace(-1, 1, points, endpoint=False), np.ones(points)
    one = half_1 * np.concatenate([run, still, -run, -still])
    two = half_2 * np.concatenate([-still, run, still, -run])
    start, end = (
        np.stack([x, 0 * x, np.full_like(x, z)], axis=-1) for x, z in ((one, height_1), (two, height_2))
    )
    return from_to(start, end)


def outlined_area(x: np.ndarray, p: np.ndarray) -> float:
    """Area within a closed outline in x and p.

    Parameters
    ----------
    x : ndarray
        Positions, shape (n,) [m].
    p : ndarray
        Direction cosines times the index, shape (n,) [1].

    Returns
    -------
    float
        Area, for either sense of rotation [m].

    Notes
    -----
    Gauss's shoelace formula.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.etendue import outlined_area
    >>> print(f"{outlined_area(np.array([0.0, 1.0, 1.0, 0.0]), np.array([0.0, 0.0, 2.0, 2.0])):.4g}")
    2
    """
    return float(abs(np.sum(x * np.roll(p, -1) - p * np.roll(x, -1))) / 2)
