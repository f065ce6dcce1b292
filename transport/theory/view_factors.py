"""View factors F12: the share of the diffuse emission of surface 1 that falls on surface 2 [1].

pi A1 F12 is the throughput between the two; A1 F12 = A2 F21. All formulas are written so that nothing
cancels, near or far.
"""

from __future__ import annotations

import math

import numpy as np

from transport.statistics.quadrature import legendre_nodes

NODES = 24  # nodes of the unequal rectangles' integrals; their nearest pole gives the error 3.7^-48


def coaxial_disks(radius_1: float, radius_2: float, distance: float) -> float:
    """View factor F12 between coaxial parallel disks.

    Parameters
    ----------
    radius_1 : float or ndarray
        Radius r1 of disk 1 [m].
    radius_2 : float or ndarray
        Radius r2 of disk 2 [m].
    distance : float or ndarray
        Distance h between the planes [m].

    Returns
    -------
    float or ndarray
        ``(2 r2 / (p + m))^2`` [1].

    Notes
    -----
    p and m are the longest and the shortest straight line between the rims,
    ``p^2 = h^2 + (r1 + r2)^2``, ``m^2 = h^2 + (r1 - r2)^2``. Equal to Howell's C-41, without its
    difference.

    Examples
    --------
    >>> from transport.theory.view_factors import coaxial_disks
    >>> print(f"{coaxial_disks(1.0, 1.0, 2.0):.4g}")
    0.1716
    """
    longest = np.hypot(distance, np.add(radius_1, radius_2))
    shortest = np.hypot(distance, np.subtract(radius_1, radius_2))
    return (2 * np.divide(radius_2, longest + shortest)) ** 2


def parallel_rectangles(width: float, height: float, distance: float) -> float:
    """View factor F12 between equal aligned parallel rectangles.

    Parameters
    ----------
    width : float or ndarray
        Width of the rectangles [m].
    height : float or ndarray
        Height of the rectangles [m].
    distance : float or ndarray
        Distance h between the planes [m].

    Returns
    -------
    float or ndarray
        F12 [1].

    Notes
    -----
    Source: Howell, C-11.

    Examples
    --------
    >>> from transport.theory.view_factors import parallel_rectangles
    >>> print(f"{parallel_rectangles(1.0, 1.0, 1.0):.4g}")
    0.1998
    """
    x, y = np.divide(width, distance), np.divide(height, distance)
    return 2 / math.pi * _opposed(x, y) / x / y


def opposed_rectangles(sides_1: tuple, sides_2: tuple, distance: float) -> float:
    """View factor F12 between coaxial parallel rectangles of any sizes with parallel sides.

    Parameters
    ----------
    sides_1 : tuple of 2 float
        Width and height of rectangle 1 [m].
    sides_2 : tuple of 2 float
        Width and height of rectangle 2 [m].
    distance : float
        Distance h between the planes [m].

    Returns
    -------
    float
        F12 [1].

    Notes
    -----
    With E(w, h) = w h F of equal rectangles w x h, ``A1 F12 = E(q, s) - E(p, s) - E(q, r) + E(p, r)``;
    q, p are half the sum and difference of the widths, s, r of the heights, because the overlap of two
    intervals is a difference of two tents. Where one side is below half the other, the difference is
    computed as an integral of E's derivative (Gauss-Legendre). Equal to Howell's C-13.

    Examples
    --------
    >>> from transport.theory.view_factors import opposed_rectangles
    >>> print(f"{opposed_rectangles((1.0, 1.0), (2.0, 1.0), 1.0):.4g}")
    0.3201
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
    """View factor F12 between rectangles at a right angle with a common edge.

    Parameters
    ----------
    width_1 : float
        Width of rectangle 1, measured away from the edge [m].
    width_2 : float
        Width of rectangle 2, measured away from the edge [m].
    edge : float, default 1.0
        Length of the common edge [m].

    Returns
    -------
    float
        F12 [1].

    Notes
    -----
    Howell, C-14. With W = width_1/edge, H = width_2/edge, R^2 = W^2 + H^2 and T(x) = x atan(1/x) it is
    ``[T(W) + T(H) - T(R) + logs/4] / (pi W)``.

    Examples
    --------
    >>> from transport.theory.view_factors import perpendicular_rectangles
    >>> print(f"{perpendicular_rectangles(1.0, 1.0):.4g}")
    0.2
    """
    w, h = width_1 / edge, width_2 / edge
    short, long = min(w, h), max(w, h)
    slant = math.hypot(w, h)
    # Compute slant - long, and T(slant) - T(long) from it.
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
    """View factor F12 between equal opposed infinite strips.

    Parameters
    ----------
    width : float or ndarray
        Width w of the strips [m].
    distance : float or ndarray
        Distance h between the planes [m].

    Returns
    -------
    float or ndarray
        ``sqrt(1 + (h/w)^2) - h/w`` [1].

    Notes
    -----
    By crossed strings (Hottel 1954). Computed as ``w / (sqrt(h^2 + w^2) + h)``.

    Examples
    --------
    >>> from transport.theory.view_factors import infinite_strips
    >>> print(f"{infinite_strips(1.0, 1.0):.4g}")
    0.4142
    """
    return np.divide(width, np.hypot(width, distance) + distance)


def infinite_wedge(angle: float) -> float:
    """View factor F12 between equal infinite strips that share an edge.

    Parameters
    ----------
    angle : float or ndarray
        Angle between the strips [rad].

    Returns
    -------
    float or ndarray
        ``1 - sin(angle/2)`` [1].

    Notes
    -----
    Hottel 1954. Computed as ``2 sin^2((pi - angle) / 4)``.

    Examples
    --------
    >>> from transport.theory.view_factors import infinite_wedge
    >>> print(f"{infinite_wedge(1.0):.4g}")
    0.5206
    """
    return 2 * np.sin((math.pi - np.asarray(angle, dtype=float)) / 4) ** 2


def infinite_cylinders(radius: float, gap: float) -> float:
    """View factor F12 between equal parallel infinite cylinders.

    Parameters
    ----------
    radius : float or ndarray
        Radius r of both cylinders [m].
    gap : float or ndarray
        Distance between their surfaces [m].

    Returns
    -------
    float or ndarray
        ``(sqrt(X^2 - 1) + asin(1/X) - X) / pi`` with ``X = 1 + gap/2r`` [1].

    Notes
    -----
    By crossed strings (Hottel 1954), computed without the difference.

    Examples
    --------
    >>> from transport.theory.view_factors import infinite_cylinders
    >>> print(f"{infinite_cylinders(1.0, 1.0):.4g}")
    0.1107
    """
    over = np.divide(gap, 2 * np.asarray(radius, dtype=float))
    root = np.sqrt(over * (2 + over))
    return (np.arctan2(1.0, root) - 1 / (1 + over + root)) / math.pi


def box_view_factors(size: tuple) -> np.ndarray:
    """View factors between the six inner walls of a box.

    Parameters
    ----------
    size : tuple of 3 float
        Side lengths x, y, z [m].

    Returns
    -------
    ndarray
        View factors from row to column, walls in the order -x, +x, -y, +y, -z, +z, shape (6, 6) [1];
        each row sums to 1.

    Notes
    -----
    Source: Howell, C-11 and C-14.

    Examples
    --------
    >>> from transport.theory.view_factors import box_view_factors
    >>> print(box_view_factors((1.0, 1.0, 1.0))[0].round(4))
    [0.     0.1998 0.2    0.2    0.2    0.2   ]
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
    """Derivative of _opposed with respect to x."""
    k = np.hypot(1, x)
    return _atan_excess(x, y) + x / k * y * np.arctan(y / k)


def _both_slopes(x, y):
    """Derivative of _opposed by x and y: half the projected solid angle of a rectangle of half sides x, y."""
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
