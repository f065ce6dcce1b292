"""Throughput between two facing elements of area, and the bias of radiance due to their size.

A ray that joins dA1 and dA2 at the distance r has the same measure at both ends: dω1 = dA2 cosθ2 / r²
and dω2 = dA1 cosθ1 / r², so that dω1 dA1 cosθ1 = dω2 dA2 cosθ2 = d²T (Hanrahan 2001, Stanford CS 348B,
lecture 4, "1st law" and "Throughput"). Elements of finite size have the throughput T = ∬ cosθ1
cosθ2 / r² dA1 dA2, and a radiance Φ / (dω1 dA1 cosθ1), computed with r and the cosines of their
centers, is biased by the factor T / d²T.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from transport.theory.nodes import legendre_nodes
from transport.theory.view_factors import coaxial_disks

Vector = Sequence[float]

# Gauss-Legendre along each side: error 1e-12 for sides as long as the distance, 1e-6 for four times that
NODES = 16


def disks_throughput(radius_1: float, radius_2: float, distance: float) -> float:
    """Throughput between coaxial parallel disks.

    Parameters
    ----------
    radius_1 : float or ndarray
        Radius of the first disk [m].
    radius_2 : float or ndarray
        Radius of the second disk [m].
    distance : float or ndarray
        Distance between the disks [m].

    Returns
    -------
    float or ndarray
        ``pi A1 F12`` [m^2 sr].

    Notes
    -----
    Source: Howell, C-41.

    Examples
    --------
    >>> from transport.theory.elements import disks_throughput
    >>> print(f"{disks_throughput(1.0, 1.0, 2.0):.4g}")
    1.693
    """
    return (math.pi * np.asarray(radius_1)) ** 2 * coaxial_disks(radius_1, radius_2, distance)


def element_throughput(area_1: float, mu_1: float, area_2: float, mu_2: float, distance: float) -> float:
    """Throughput between two small elements, computed from their centers.

    Parameters
    ----------
    area_1 : float
        Area dA1 [m^2].
    mu_1 : float
        Cosine at the first element, between its normal and the ray [1].
    area_2 : float
        Area dA2 [m^2].
    mu_2 : float
        Cosine at the second element [1].
    distance : float
        Distance r between the centers [m].

    Returns
    -------
    float
        ``dA1 cosθ1 dA2 cosθ2 / r²`` [m^2 sr].

    Examples
    --------
    >>> from transport.theory.elements import element_throughput
    >>> print(f"{element_throughput(0.01, 1.0, 0.02, 0.5, 2.0):.4g}")
    2.5e-05
    """
    return area_1 * mu_1 * (area_2 * mu_2 / distance**2)


def disks_bias(ratio_1: float, ratio_2: float) -> float:
    """Relative error of treating coaxial disks as small elements.

    Parameters
    ----------
    ratio_1 : float or ndarray
        Radius of the first disk over the distance [1].
    ratio_2 : float or ndarray
        Radius of the second disk over the distance [1].

    Returns
    -------
    float or ndarray
        ``T r² / (A1 A2) - 1`` [1], about -(ratio_1² + ratio_2²).

    Notes
    -----
    With ``s = (p + m) / 2r``, p and m the longest and the shortest line between the rims, it is
    ``-(s - 1)(s + 1) / s²``, which does not cancel.

    Examples
    --------
    >>> from transport.theory.elements import disks_bias
    >>> print(f"{disks_bias(0.1, 0.1):.4g}")
    -0.01951
    """
    total, difference = np.add(ratio_1, ratio_2), np.subtract(ratio_1, ratio_2)
    longest, shortest = np.hypot(1, total), np.hypot(1, difference)
    excess = (total**2 / (1 + longest) + difference**2 / (1 + shortest)) / 2
    return -excess * (2 + excess) / (1 + excess) ** 2


def tilted_throughput(center_1: Vector, sides_1: Sequence[Vector], center_2: Vector, sides_2) -> float:
    """Throughput between two parallelograms.

    Parameters
    ----------
    center_1 : array_like
        Center of the first parallelogram, shape (3,) [m].
    sides_1 : array_like
        Its two side vectors, shape (2, 3) [m].
    center_2 : array_like
        Center of the second parallelogram, shape (3,) [m].
    sides_2 : array_like
        Its two side vectors, shape (2, 3) [m].

    Returns
    -------
    float
        ``∬ |cosθ1 cosθ2| / r² dA1 dA2`` [m^2 sr].

    Raises
    ------
    ValueError
        If one parallelogram crosses the plane of the other.

    Notes
    -----
    Gauss-Legendre quadrature along all four sides.

    Examples
    --------
    >>> from transport.theory.elements import tilted_throughput
    >>> sides = [(0.1, 0.0, 0.0), (0.0, 0.1, 0.0)]
    >>> print(f"{tilted_throughput((0.0, 0.0, 0.0), sides, (0.0, 0.0, 1.0), sides):.4g}")
    9.934e-05
    """
    x, weight = legendre_nodes(NODES)
    ends = np.array([[s, t] for s in (-0.5, 0.5) for t in (-0.5, 0.5)])
    inner = np.array([[s, t] for s in x / 2 for t in x / 2])
    weights = np.outer(weight, weight).ravel() / 4
    one, two = (np.asarray(sides, dtype=float) for sides in (sides_1, sides_2))
    normal_1, normal_2 = np.cross(*one), np.cross(*two)  # lengths equal the areas
    gap = np.subtract(center_2, center_1)

    def between(of_1: np.ndarray, of_2: np.ndarray) -> np.ndarray:
        """Vectors from points of the first parallelogram to points of the second [m]."""
        return gap + (of_2 @ two)[None, :, :] - (of_1 @ one)[:, None, :]

    corners = between(ends, ends)
    for normal in (normal_1, normal_2):
        if np.ptp(np.sign(corners @ normal)) != 0:
            raise ValueError(
                "tilted_throughput: an element reaches behind the plane of the other; tilt it less"
            )
    ray = between(inner, inner)
    rays = np.abs(ray @ normal_1) * np.abs(ray @ normal_2) / (ray**2).sum(axis=-1) ** 2
    return float(weights @ rays @ weights)
