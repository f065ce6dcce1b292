"""View factors F12: the share of what a diffuse surface 1 gives off that falls on surface 2 [1].

pi A1 F12 is the throughput between the two; A1 F12 = A2 F21.  Every form is written so that nothing
cancels, near or far.
"""

from __future__ import annotations

import math

import numpy as np

from transport.theory.nodes import legendre_nodes

NODES = 24  # of the unequal rectangles' integrals: their nearest pole leaves 3.7^-48


def coaxial_disks(radius_1: float, radius_2: float, distance: float) -> float:
    """F12 between coaxial parallel disks [1]: (2 r2 / (p + m))^2.

    p and m are the longest and the shortest straight line between the rims, p^2 = h^2 + (r1 + r2)^2,
    m^2 = h^2 + (r1 - r2)^2; equal to Howell's C-41, without its difference.  Vectorised.
    """
    longest = np.hypot(distance, np.add(radius_1, radius_2))
    shortest = np.hypot(distance, np.subtract(radius_1, radius_2))
    return (2 * np.divide(radius_2, longest + shortest)) ** 2


def parallel_rectangles(width: float, height: float, distance: float) -> float:
    """F12 between equal aligned parallel rectangles [1] (Howell, C-11).  Vectorised."""
    x, y = np.divide(width, distance), np.divide(height, distance)
    return 2 / math.pi * _opposed(x, y) / x / y


def opposed_rectangles(sides_1: tuple, sides_2: tuple, distance: float) -> float:
    """F12 between parallel rectangles of any sizes with one axis and parallel sides [1].

    sides_1, sides_2: (width, height).  With E(w, h) = w h F of equal rectangles w x h,
    A1 F12 = E(q, s) - E(p, s) - E(q, r) + E(p, r); q, p: half the sum and difference of the widths, s, r: of
    the heights, as the overlap of two intervals is a difference of two tents.  Where one side is below half
    the other the difference is an integral of E's derivative (Gauss-Legendre).  Equal to Howell's C-13.
    """
    (short_x, long_x), (short_y, long_y) = (
        sorted((a / 2 / distance, b / 2 / distance)) for a, b in zip(sides_1, sides_2, strict=True)
    )
    if long_x > 2 * short_x and long_y > 2 * short_y:
        total = _integral(
            lambda x: _integral(lambda y: _both_slopes(x, y[:, None]), long_y, short_y), long_x, short_x
        )
    elif long_x > 2 * short_x:
        total = _integral(
            lambda x: _slope(x, long_y + short_y) - _slope(x, long_y - short_y), long_x, short_x
        )
    elif long_y > 2 * short_y:
        total = _integral(
            lambda y: _slope(y, long_x + short_x) - _slope(y, long_x - short_x), long_y, short_y
        )
    else:
        q, p, s, r = long_x + short_x, long_x - short_x, long_y + short_y, long_y - short_y
        total = _opposed(q, s) - _opposed(p, s) - _opposed(q, r) + _opposed(p, r)
    return 2 / math.pi * total / (sides_1[0] / distance) / (sides_1[1] / distance)


def perpendicular_rectangles(width_1: float, width_2: float, edge: float = 1.0) -> float:
    """F12 between rectangles at a right angle with a common edge [1] (Howell, C-14).

    width_1, width_2: measured away from the edge.  With W = width_1/edge, H = width_2/edge, R^2 = W^2 + H^2
    and T(x) = x atan(1/x) it is [T(W) + T(H) - T(R) + logs/4] / (pi W).
    """
    w, h = width_1 / edge, width_2 / edge
    short, long = min(w, h), max(w, h)
    slant = math.hypot(w, h)
    # slant - long, and T(slant) - T(long) from it
    excess = short * (short / (long + slant))
    angles = (
        short * math.atan2(1, short)
        - excess * math.atan2(1, slant)
        + long * math.atan(excess / (1 + slant * long))
    )
    square, x, y = slant**2, short**2, long**2
    logs = math.log1p(x * (y / (1 + square))) + y * math.log1p(-x / square / (1 + y))
    share = y / square / (1 + x)
    logs += x * (math.log1p(-share) if share < 0.5 else math.log(x / square * ((1 + square) / (1 + x))))
    return (angles + logs / 4) / (math.pi * w)


def infinite_strips(width: float, distance: float) -> float:
    """F12 between equal opposed strips without ends [1]: sqrt(1 + (h/w)^2) - h/w, by crossed strings (Hottel
    1954).

    Written as w / (sqrt(h^2 + w^2) + h).  Vectorised.
    """
    return np.divide(width, np.hypot(width, distance) + distance)


def infinite_wedge(angle: float) -> float:
    """F12 between equal strips without ends that share an edge [1]: 1 - sin(angle/2) (Hottel 1954).

    angle: between them [rad].  Written as 2 sin^2((pi - angle) / 4).  Vectorised.
    """
    return 2 * np.sin((math.pi - np.asarray(angle, dtype=float)) / 4) ** 2


def infinite_cylinders(radius: float, gap: float) -> float:
    """F12 between equal parallel cylinders without ends [1] (Hottel 1954, by crossed strings).

    (sqrt(X^2 - 1) + asin(1/X) - X) / pi, X = 1 + gap/2r, from its square root and without the difference.
    Vectorised.
    """
    over = np.divide(gap, 2 * np.asarray(radius, dtype=float))
    root = np.sqrt(over * (2 + over))
    return (np.arctan2(1.0, root) - 1 / (1 + over + root)) / math.pi


def box_view_factors(size: tuple) -> np.ndarray:
    """View factors between the six inner walls of a box, shape (6, 6) [1].

    size: (x, y, z); walls -x, +x, -y, +y, -z, +z; each row sums to 1.  Source: Howell, C-11 and C-14.
    """
    factors = np.zeros((6, 6))
    for i in range(6):
        for j in range(6):
            one, two = i // 2, j // 2
            if one != two:
                factors[i, j] = perpendicular_rectangles(size[two], size[one], size[3 - one - two])
            elif i != j:
                factors[i, j] = parallel_rectangles(*(size[k] for k in range(3) if k != one), size[one])
    return factors


def _opposed(x, y):
    """(pi/2) x y F of equal rectangles at unit distance; every term is positive."""
    logarithm = np.log1p(np.square(x) * (np.square(y) / (1 + np.square(x) + np.square(y)))) / 2
    return logarithm + x * _atan_excess(x, y) + y * _atan_excess(y, x)


def _slope(x, y):
    """Derivative of _opposed by x."""
    k = np.hypot(1, x)
    return _atan_excess(x, y) + x / k * y * np.arctan(y / k)


def _both_slopes(x, y):
    """Derivative of _opposed by x and y: half a rectangle's projected solid angle, half sides x and y."""
    k, m = np.hypot(1, x), np.hypot(1, y)
    return x / k * np.arctan(y / k) + y / m * np.arctan(x / m)


def _atan_excess(x, y):
    """k atan(x/k) - atan(x), k = sqrt(1 + y^2), from k - 1 = y^2 / (1 + k)."""
    k = np.hypot(1, y)
    more = y * (y / (1 + k))
    return more * np.arctan(x / k) - np.arctan(more * x / (k + np.square(x)))


def _integral(function, middle, half):
    """Gauss-Legendre integral from middle - half to middle + half, over the value's last axis."""
    nodes, weights = legendre_nodes(NODES)
    return half * (function(middle + half * nodes) @ weights)
