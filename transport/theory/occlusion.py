"""View factors between coaxial disks or parallel rectangles past an obstacle.

A ray from 1 to 2 meets a plane between them either inside the third shape or outside. An opaque shape
there passes the rays outside, a screen with a hole of this shape those inside, and the two factors add
up to the unobstructed factor. Only the rays through a hole are computed; sizes in m.

A ray that leaves 1 at x1 for x2, parallel planes h apart, crosses the plane z = t h at p = (1 - t)
x1 + t x2; with s = x2 - x1, dx1 dx2 = dp ds, and A1 F12 = ∬ h^2 / (pi (h^2 + s^2)^2) dp ds over the
points that lie in all three shapes:

    x1 = p - t s in shape 1,   x2 = p + (1 - t) s in shape 2,   p in shape 3.
"""

from __future__ import annotations

import math

import numpy as np

from transport.statistics.quadrature import legendre_nodes
from transport.theory.view_factors import coaxial_disks, opposed_rectangles, parallel_rectangles

NODES = 24  # nodes per panel of the integral over the hole


def disks_through_hole(
    radius_1: float, radius_2: float, distance: float, hole: float, position: float
) -> float:
    """View factor F12 of coaxial disks through a coaxial round hole in a screen between them.

    Parameters
    ----------
    radius_1 : float
        Radius of disk 1 [m].
    radius_2 : float
        Radius of disk 2 [m].
    distance : float
        Distance between the planes of 1 and 2 [m].
    hole : float
        Radius of the hole [m].
    position : float
        Distance of the third plane from 1, between 0 and `distance` [m].

    Returns
    -------
    float
        F12 [1], good to 1e-12.

    Raises
    ------
    ValueError
        If the position is not between 0 and the distance.

    Notes
    -----
    For a point p of the hole the offsets s lie in two circles: that of disk 1, of radius r1/t about
    p/t, and that of disk 2, of radius r2/(1 - t) about -p/(1 - t). Over their intersection the integral
    is a contour integral (Lambert 1760), in closed form on each arc. The integral over p is
    Gauss-Legendre on panels that shrink towards the rims' shadows and the points where the circles
    begin to cross.

    Examples
    --------
    >>> from transport.theory.occlusion import disks_through_hole
    >>> print(f"{disks_through_hole(1.0, 1.0, 2.0, 0.5, 1.0):.4g}")
    0.09016
    """
    t = _check_position(position / distance)
    ratios = np.array([radius_1 / t, radius_2 / (1 - t)]) / distance
    reach = t * (1 - t) * distance
    total, x, w = 0.0, *legendre_nodes(NODES)
    angle, w = math.pi / 4 * (1 + x), math.pi / 4 * w
    steep = np.array([0.0, reach * abs(ratios[0] - ratios[1]), radius_1, radius_2, reach * ratios.sum()])
    cuts = _graded_cuts(np.unique(np.minimum([*steep, hole], min(hole, steep[-1]))), reach)
    for low, high in zip(cuts[:-1], cuts[1:], strict=True):
        p = low + (high - low) * np.sin(angle) ** 2
        seen = [
            _view_factor_of_intersection(*ratios, place / distance / t, place / distance / (1 - t))
            for place in p
        ]
        total += (w * (high - low) * np.sin(2 * angle) * 2 * p) @ seen
    return float(total / radius_1**2)


def disks_past_disk(
    radius_1: float, radius_2: float, distance: float, blocker: float, position: float
) -> float:
    """View factor F12 of coaxial disks past an opaque coaxial disk between them.

    Parameters
    ----------
    radius_1 : float
        Radius of disk 1 [m].
    radius_2 : float
        Radius of disk 2 [m].
    distance : float
        Distance between the planes of 1 and 2 [m].
    blocker : float
        Radius of the opaque disk [m].
    position : float
        Distance of the third plane from 1, between 0 and `distance` [m].

    Returns
    -------
    float
        F12 [1].

    Raises
    ------
    ValueError
        If the position is not between 0 and the distance.

    Notes
    -----
    The unobstructed factor minus `disks_through_hole`.

    Examples
    --------
    >>> from transport.theory.occlusion import disks_past_disk
    >>> print(f"{disks_past_disk(1.0, 1.0, 2.0, 0.5, 1.0):.4g}")
    0.08141
    """
    free = coaxial_disks(radius_1, radius_2, distance)
    return float(free) - disks_through_hole(radius_1, radius_2, distance, blocker, position)


def rectangles_through_hole(
    sides_1: tuple, sides_2: tuple, distance: float, hole: tuple, position: float
) -> float:
    """View factor F12 of coaxial parallel rectangles through a rectangular hole in a screen between them.

    Parameters
    ----------
    sides_1 : tuple of 2 float
        Width and height of rectangle 1 [m].
    sides_2 : tuple of 2 float
        Width and height of rectangle 2 [m].
    distance : float
        Distance between the planes of 1 and 2 [m].
    hole : tuple of 2 float
        Width and height of the hole [m].
    position : float
        Distance of the third plane from 1, between 0 and `distance` [m].

    Returns
    -------
    float
        F12 [1].

    Raises
    ------
    ValueError
        If the position is not between 0 and the distance.

    Notes
    -----
    All sides are parallel to the same two axes. Along each axis the points p that a step s permits form
    an interval, whose length falls piecewise linearly with ``|s|``: a sum of tents ``(w - |s|)+``. Each
    pair of tents gives the known ``w h F`` of equal opposed rectangles w x h (Howell, C-11). The sum
    cancels if the shapes are small compared with the distance.

    Examples
    --------
    >>> from transport.theory.occlusion import rectangles_through_hole
    >>> print(f"{rectangles_through_hole((1.0, 1.0), (1.0, 1.0), 2.0, (0.5, 0.5), 1.0):.4g}")
    0.03719
    """
    t, total = _check_position(position / distance), 0.0
    tents = [_tents(a, b, c, t) for a, b, c in zip(sides_1, sides_2, hole, strict=True)]
    for width, weight in tents[0]:
        for height, other in tents[1]:
            total += weight * other * width * height * float(parallel_rectangles(width, height, distance))
    return total / (sides_1[0] * sides_1[1])


def rectangles_past_rectangle(
    sides_1: tuple, sides_2: tuple, distance: float, blocker: tuple, position: float
) -> float:
    """View factor F12 of coaxial parallel rectangles past an opaque rectangle between them.

    Parameters
    ----------
    sides_1 : tuple of 2 float
        Width and height of rectangle 1 [m].
    sides_2 : tuple of 2 float
        Width and height of rectangle 2 [m].
    distance : float
        Distance between the planes of 1 and 2 [m].
    blocker : tuple of 2 float
        Width and height of the opaque rectangle [m].
    position : float
        Distance of the third plane from 1, between 0 and `distance` [m].

    Returns
    -------
    float
        F12 [1].

    Raises
    ------
    ValueError
        If the position is not between 0 and the distance.

    Notes
    -----
    The unobstructed factor minus `rectangles_through_hole`.

    Examples
    --------
    >>> from transport.theory.occlusion import rectangles_past_rectangle
    >>> print(f"{rectangles_past_rectangle((1.0, 1.0), (1.0, 1.0), 2.0, (0.5, 0.5), 1.0):.4g}")
    0.0314
    """
    free = opposed_rectangles(sides_1, sides_2, distance)
    return free - rectangles_through_hole(sides_1, sides_2, distance, blocker, position)


def _check_position(share: float) -> float:
    if not 0 < share < 1:
        raise ValueError(f"occlusion: position must be between 0 and distance, got {share:g} of it")
    return share


def _graded_cuts(cuts: np.ndarray, finest: float) -> np.ndarray:
    """The cuts, with more cuts between each two that halve the distance to both ends down to `finest`."""
    parts = [cuts]
    for low, high in zip(cuts[:-1], cuts[1:], strict=True):
        steps = math.ceil(math.log2(max((high - low) / finest, 1.0)))
        shrinking = (high - low) * 0.5 ** np.arange(1, steps + 1)
        parts += [low + shrinking, high - shrinking]
    return np.unique(np.concatenate(parts))


def _view_factor_of_intersection(radius_1: float, radius_2: float, shift_1: float, shift_2: float) -> float:
    """View factor of the intersection of two circles in the plane at unit distance.

    The circles are centered at (shift_1, 0) and (-shift_2, 0).
    """
    apart = shift_1 + shift_2
    if apart >= radius_1 + radius_2:
        return 0.0
    if apart <= abs(radius_1 - radius_2):
        return _arc(*((radius_1, shift_1) if radius_1 < radius_2 else (radius_2, shift_2)), math.pi)
    turn_1, turn_2 = _half_arc(radius_1, radius_2, apart), _half_arc(radius_2, radius_1, apart)
    return _arc(radius_1, -shift_1, turn_1) + _arc(radius_2, -shift_2, turn_2)


def _half_arc(own: float, other: float, apart: float) -> float:
    """Half the angle of a circle's arc within another circle, by Heron's formula."""
    perimeter = (own + other + apart) * (own + other - apart) * (apart + own - other) * (apart - own + other)
    return math.atan2(math.sqrt(max(perimeter, 0.0)), own * own - other * other + apart * apart)


def _arc(radius: float, ahead: float, half: float) -> float:
    """Contribution of an arc to the view factor, as a contour integral.

    (1/4pi) ∮ [1 + (r^2 - c^2 - 1) / (1 + c^2 + r^2 + 2 c r cos a)] da over |a| < half, c = `ahead` the
    distance of the circle's center along the arc's middle; c > 0 if the arc bulges away from the axis.
    """
    near, far = math.hypot(1, radius - ahead), math.hypot(1, radius + ahead)
    angle = math.pi / 2 if half >= math.pi else math.atan(near / far * math.tan(half / 2))
    return (half + ((radius - ahead) * (radius + ahead) - 1) * 2 * angle / (near * far)) / (2 * math.pi)


def _tents(side_1: float, side_2: float, hole: float, t: float) -> list[tuple[float, float]]:
    """Permitted length for a step s as a sum of tents (w - |s|)+ with weights: list of (w, weight).

    The length is the minimum of a few linear functions, and 0 where that is negative.
    """
    a, b, c = side_1 / 2, side_2 / 2, hole / 2
    lines = [(2 * min(a, b, c), 0.0), (c + a, -t), (c + b, t - 1), (a + b, -1.0)]
    end = min(value / -slope for value, slope in lines if slope)
    crossings = [(v - w) / (n - m) for v, m in lines for w, n in lines if m != n]
    corners = [0.0, *sorted({s for s in crossings if 0 < s < end}), end]
    middles = [(low + high) / 2 for low, high in zip(corners[:-1], corners[1:], strict=True)]
    slopes = [min((value + slope * s, slope) for value, slope in lines)[1] for s in middles] + [0.0]
    return [
        (corner, after - before)
        for corner, before, after in zip(corners[1:], slopes[:-1], slopes[1:], strict=True)
        if after != before
    ]
