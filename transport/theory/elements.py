"""Two elements of area that see one another: how many rays join them, and what their size does to a radiance.

A ray that joins dA1 and dA2 at the distance r counts as much at either end: dω1 = dA2 cosθ2 / r² and
dω2 = dA1 cosθ1 / r², so that dω1 dA1 cosθ1 = dω2 dA2 cosθ2 = d²T (Hanrahan 2001, Stanford CS 348B, lecture 4,
"1st law" and "Throughput").  Elements of finite size hold T = ∬ cosθ1 cosθ2 / r² dA1 dA2 rays, and a radiance
Φ / (dω1 dA1 cosθ1), with the middles' r and cosines, is off by the factor T / d²T.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from transport.theory.nodes import legendre_nodes
from transport.theory.view_factors import coaxial_disks

Vector = Sequence[float]

# Gauss-Legendre along each side: 1e-12 where sides are as long as the distance, 1e-6 where four times
NODES = 16


def disks_throughput(radius_1: float, radius_2: float, distance: float) -> float:
    """Throughput between coaxial parallel disks [m^2 sr]: pi A1 F12 (Howell, C-41).  Vectorised."""
    return (math.pi * np.asarray(radius_1)) ** 2 * coaxial_disks(radius_1, radius_2, distance)


def element_throughput(area_1: float, mu_1: float, area_2: float, mu_2: float, distance: float) -> float:
    """Throughput between two elements by their middles [m^2 sr]: dA1 cosθ1 dA2 cosθ2 / r²."""
    return area_1 * mu_1 * (area_2 * mu_2 / distance**2)


def disks_bias(ratio_1: float, ratio_2: float) -> float:
    """Relative error of coaxial disks taken for elements [1]: T r² / (A1 A2) − 1, about −(ratio_1² + ratio_2²).

    ratio_1, ratio_2: radius over distance.  With s = (p + m) / 2r, p and m the longest and the shortest line between
    the rims, it is −(s − 1)(s + 1) / s², and nothing cancels.  Vectorised.
    """
    total, difference = np.add(ratio_1, ratio_2), np.subtract(ratio_1, ratio_2)
    longest, shortest = np.hypot(1, total), np.hypot(1, difference)
    excess = (total**2 / (1 + longest) + difference**2 / (1 + shortest)) / 2
    return -excess * (2 + excess) / (1 + excess) ** 2


def tilted_throughput(center_1: Vector, sides_1: Sequence[Vector], center_2: Vector, sides_2) -> float:
    """Throughput between two parallelograms [m^2 sr]: ∬ |cosθ1 cosθ2| / r² dA1 dA2 by Gauss-Legendre.

    center: the middle;  sides: its two side vectors, (2, 3).  Each must lie on one side of the other's plane.
    Raises ValueError where one reaches behind the other.
    """
    x, weight = legendre_nodes(NODES)
    ends = np.array([[s, t] for s in (-0.5, 0.5) for t in (-0.5, 0.5)])
    inner = np.array([[s, t] for s in x / 2 for t in x / 2])
    weights = np.outer(weight, weight).ravel() / 4
    one, two = (np.asarray(sides, dtype=float) for sides in (sides_1, sides_2))
    normal_1, normal_2 = np.cross(*one), np.cross(*two)  # as long as the areas are large
    gap = np.subtract(center_2, center_1)

    def between(of_1: np.ndarray, of_2: np.ndarray) -> np.ndarray:
        return gap + (of_2 @ two)[None, :, :] - (of_1 @ one)[:, None, :]

    corners = between(ends, ends)
    for normal in (normal_1, normal_2):
        if np.ptp(np.sign(corners @ normal)) != 0:
            raise ValueError(
                "tilted_throughput: an element reaches behind the other one's plane; tilt it less"
            )
    ray = between(inner, inner)
    rays = np.abs(ray @ normal_1) * np.abs(ray @ normal_2) / (ray**2).sum(axis=-1) ** 2
    return float(weights @ rays @ weights)
