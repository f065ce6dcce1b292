"""View factors F12 of round surfaces: spheres, the insides of tubes and cones, coaxial cylinders [1].

Numbers such as C-136 are those of Howell's catalogue (Howell, A Catalog of Radiation Heat Transfer
Configuration Factors).  A1 F12 = A2 F21; the factors from a side into a closed enclosure add up to 1.
"""

from __future__ import annotations

import math

import numpy as np

from transport.theory.nodes import legendre_nodes
from transport.theory.view_factors import coaxial_disks

NODES = 40  # of the spheres' integral


def sphere_to_disk(radius: float, distance: float) -> float:
    """F12 from a sphere to a coaxial disk of `radius` at `distance` from its centre [1] (Howell, C-136).

    (1/2) [1 - 1/sqrt(1 + (R/h)^2)], whatever the sphere's radius: a diffuse sphere sends the same to all
    sides. Written as (R/h)^2 / (2 k (1 + k)), k = sqrt(1 + (R/h)^2).  Vectorised.
    """
    ratio = np.divide(radius, distance)
    k = np.hypot(1.0, ratio)
    return ratio / k * (ratio / (1 + k)) / 2


def spheres(radius_1: float, radius_2: float, distance: float) -> float:
    """F12 between two spheres whose centres are `distance` apart [1]; there is no closed form.

    The mean over the smaller sphere of an element's view factor to the other, (r/D)^2 cos where it sees all
    of it, less where its horizon cuts it (Juul 1976), by Gauss-Legendre on both sides of where that begins.
    Good to 1e-11 from touching on.
    """
    small, large = sorted((radius_1, radius_2))
    low, high = (small - large) / distance, (small + large) / distance
    ends = (max(low, -1.0), high, 1.0)
    factor = sum(
        _over_sphere(small, large, distance, *part) for part in zip(ends[:-1], ends[1:], strict=True)
    )
    return factor * (small / radius_1) ** 2


def base_to_base(radius: float, height: float) -> float:
    """F12 from one end of a tube to the other [1], (2 R / (p + h))^2, p^2 = h^2 + 4 R^2 (Howell, C-41).
    Vectorised.
    """
    return coaxial_disks(radius, radius, height)


def base_to_side(radius: float, height: float) -> float:
    """F12 from one end of a tube to its wall [1], 2 h / (p + h): 1 - base_to_base without its difference.
    Vectorised.
    """
    return 2 * np.divide(height, np.hypot(height, 2 * np.asarray(radius, dtype=float)) + height)


def side_to_base(radius: float, height: float) -> float:
    """F12 from the inside of a tube's wall to one end [1], R / (p + h).  Vectorised."""
    return np.divide(radius, np.hypot(height, 2 * np.asarray(radius, dtype=float)) + height)


def side_to_side(radius: float, height: float) -> float:
    """F11 from the inside of a tube's wall to itself [1].

    1 - 2 side_to_base = (h/R) (1 + h/(p + 2 R)) / ((p + h)/R), which does not cancel in short tubes.
    Vectorised.
    """
    p = np.hypot(height, 2 * np.asarray(radius, dtype=float))
    return height * (1 + height / (p + 2 * radius)) / (p + height)


def cone_to_base(radius: float, height: float) -> float:
    """F12 from the inside of a cone to its base [1]: R over the slant height, the sine of half its angle.
    Vectorised.
    """
    return np.divide(radius, np.hypot(radius, height))


def cone_to_itself(radius: float, height: float) -> float:
    """F11 from the inside of a cone to itself [1], 1 - cone_to_base: h^2 / (l (l + R)), l the slant height.
    Vectorised.
    """
    slant = np.hypot(radius, height)
    return height / slant * (height / (slant + radius))


def sphere_to_patch(area_share: float) -> float:
    """F12 from the inside of a sphere, or any part of it, to any part of it [1]: that part's share of the
    sphere's area.

    A hemisphere sees half of what it sends out itself, its base the other half.
    """
    return area_share


def outer_sphere_to_inner(inner: float, outer: float) -> float:
    """F21 from the inside of a sphere to a sphere within, concentric or not [1]: (r1/r2)^2; the rest falls on
    itself.
    """
    return np.divide(inner, outer) ** 2


def outer_cylinder_to_inner(inner: float, outer: float, height: float) -> float:
    """F21 from the inside of a cylinder to a coaxial one of the same height within [1].

    With X = r2/r1, Y = h/r1, A = Y^2 + X^2 - 1, B = Y^2 - X^2 + 1 (Hamilton and Morgan 1952; Howell's
    catalogue). Its terms cancel where h or r2 - r1 is small or large beside r1: good to 1e-10 from 0.1 to 10
    of it.
    """
    x, y = outer / inner, height / inner
    a, b = y * y + x * x - 1, y * y - x * x + 1
    bracket = (
        math.sqrt((a + 2) ** 2 - 4 * x * x) * math.acos(b / (x * a)) + b * math.asin(1 / x) - math.pi * a / 2
    )
    return 1 / x - (math.acos(b / a) - bracket / (2 * y)) / (math.pi * x)


def outer_cylinder_to_itself(inner: float, outer: float, height: float) -> float:
    """F22 from the inside of a cylinder to itself past a coaxial one of the same height within [1] (same
    source).
    """
    x, y = outer / inner, height / inner
    x2, y2 = x * x, y * y
    gap = 4 * (x2 - 1)
    slant = math.sqrt(4 * x2 + y2) / y
    around = slant * math.asin((gap + y2 / x2 * (x2 - 2)) / (y2 + gap)) - math.asin((x2 - 2) / x2)
    past = 2 / math.pi * math.atan(2 * math.sqrt(x2 - 1) / y)
    return 1 - 1 / x + past / x - y / (2 * math.pi * x) * (around + math.pi / 2 * (slant - 1))


def _over_sphere(radius_1: float, radius_2: float, distance: float, low: float, high: float) -> float:
    """Half the integral over mu from low to high; mu = low + (high - low) sin^2, for half-odd powers at the
    ends.
    """
    from transport.theory.emitters import sphere_irradiance

    if not low < high:
        return 0.0
    x, w = legendre_nodes(NODES)
    t, w = math.pi / 4 * (1 + x), math.pi / 4 * w
    mu, w = low + (high - low) * np.sin(t) ** 2, w * (high - low) * np.sin(2 * t)
    away = np.sqrt((distance - radius_1) ** 2 + 2 * distance * radius_1 * (1 - mu))
    cosine = (distance * mu - radius_1) / away
    return float(w @ sphere_irradiance(1.0, radius_2, away, cosine) / math.pi / 2)
