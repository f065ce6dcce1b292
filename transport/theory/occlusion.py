"""View factors past an obstacle: coaxial disks and parallel rectangles with a third one between them [1].

What leaves 1 and meets a plane between 1 and 2 does so either within the third shape or beside it: with an
opaque shape there the rays beside it arrive, with a screen that has such a hole the others, and both together
are the factor without either.  So it is the rays through a hole that are worked out; sizes in metres.

A ray that leaves 1 at x1 for x2, parallel planes h apart, crosses the plane z = t h at p = (1 - t) x1 + t x2;
with s = x2 - x1, dx1 dx2 = dp ds, and A1 F12 = ∬ h^2 / (pi (h^2 + s^2)^2) dp ds over what lies in all three
shapes:

    x1 = p - t s in shape 1,   x2 = p + (1 - t) s in shape 2,   p in shape 3.
"""

from __future__ import annotations

import math

import numpy as np

from transport.theory.nodes import legendre_nodes
from transport.theory.view_factors import coaxial_disks, opposed_rectangles, parallel_rectangles

NODES = 24  # of each panel of the integral over the hole


def disks_through_hole(
    radius_1: float, radius_2: float, distance: float, hole: float, position: float
) -> float:
    """F12 of coaxial disks through a round hole in a screen between them [1].

    hole: its radius; position: its distance from disk 1.  For a place p of the hole the s lie in two circles,
    the one of disk 1 of radius r1/t about p/t and that of disk 2 of radius r2/(1 - t) about -p/(1 - t); over
    what they share the integral is one along the rim (Lambert 1760), in closed form on each arc.  That over p
    is Gauss-Legendre on panels that shrink towards the rims' shadows and the places where the circles begin
    to cross.  Good to 1e-12.
    """
    t = _checked(position / distance)
    ratios = np.array([radius_1 / t, radius_2 / (1 - t)]) / distance
    reach = t * (1 - t) * distance
    total, x, w = 0.0, *legendre_nodes(NODES)
    angle, w = math.pi / 4 * (1 + x), math.pi / 4 * w
    steep = np.array([0.0, reach * abs(ratios[0] - ratios[1]), radius_1, radius_2, reach * ratios.sum()])
    cuts = _graded(np.unique(np.minimum([*steep, hole], min(hole, steep[-1]))), reach)
    for low, high in zip(cuts[:-1], cuts[1:], strict=True):
        p = low + (high - low) * np.sin(angle) ** 2
        seen = [_seen(*ratios, place / distance / t, place / distance / (1 - t)) for place in p]
        total += (w * (high - low) * np.sin(2 * angle) * 2 * p) @ seen
    return float(total / radius_1**2)


def disks_past_disk(
    radius_1: float, radius_2: float, distance: float, blocker: float, position: float
) -> float:
    """F12 of coaxial disks past an opaque coaxial disk between them [1]; as `disks_through_hole`."""
    free = coaxial_disks(radius_1, radius_2, distance)
    return float(free) - disks_through_hole(radius_1, radius_2, distance, blocker, position)


def rectangles_through_hole(
    sides_1: tuple, sides_2: tuple, distance: float, hole: tuple, position: float
) -> float:
    """F12 of parallel rectangles with one axis and parallel sides through such a hole in a screen between
    them [1].

    Sides (width, height).  Along each axis the places p that a step s leaves free are an interval, whose
    length falls with |s| in straight pieces: a sum of tents (w - |s|)+.  Each pair of tents gives the known w
    h F of equal opposed rectangles w x h (Howell, C-11).  The sum cancels where the shapes are small beside
    the distance.
    """
    t, total = _checked(position / distance), 0.0
    tents = [_tents(a, b, c, t) for a, b, c in zip(sides_1, sides_2, hole, strict=True)]
    for width, weight in tents[0]:
        for height, other in tents[1]:
            total += weight * other * width * height * float(parallel_rectangles(width, height, distance))
    return total / (sides_1[0] * sides_1[1])


def rectangles_past_rectangle(
    sides_1: tuple, sides_2: tuple, distance: float, blocker: tuple, position: float
) -> float:
    """F12 of such rectangles past an opaque one between them [1]; as `rectangles_through_hole`."""
    free = opposed_rectangles(sides_1, sides_2, distance)
    return free - rectangles_through_hole(sides_1, sides_2, distance, blocker, position)


def _checked(share: float) -> float:
    if not 0 < share < 1:
        raise ValueError(f"occlusion: position must be between 0 and distance, got {share:g} of it")
    return share


def _graded(cuts: np.ndarray, finest: float) -> np.ndarray:
    """The cuts, and between each two more of them, that halve the way to both ends until they are `finest`
    apart.
    """
    parts = [cuts]
    for low, high in zip(cuts[:-1], cuts[1:], strict=True):
        steps = math.ceil(math.log2(max((high - low) / finest, 1.0)))
        shrinking = (high - low) * 0.5 ** np.arange(1, steps + 1)
        parts += [low + shrinking, high - shrinking]
    return np.unique(np.concatenate(parts))


def _seen(radius_1: float, radius_2: float, shift_1: float, shift_2: float) -> float:
    """View factor of what two circles share, in the plane at unit distance: about (shift_1, 0) and (-shift_2,
    0).
    """
    apart = shift_1 + shift_2
    if apart >= radius_1 + radius_2:
        return 0.0
    if apart <= abs(radius_1 - radius_2):
        return _arc(*((radius_1, shift_1) if radius_1 < radius_2 else (radius_2, shift_2)), math.pi)
    turn_1, turn_2 = _half_arc(radius_1, radius_2, apart), _half_arc(radius_2, radius_1, apart)
    return _arc(radius_1, -shift_1, turn_1) + _arc(radius_2, -shift_2, turn_2)


def _half_arc(own: float, other: float, apart: float) -> float:
    """Half the angle of a circle's arc within another circle, from the heights over the triangle's sides."""
    perimeter = (own + other + apart) * (own + other - apart) * (apart + own - other) * (apart - own + other)
    return math.atan2(math.sqrt(max(perimeter, 0.0)), own * own - other * other + apart * apart)


def _arc(radius: float, ahead: float, half: float) -> float:
    """(1/4pi) ∮ [1 + (r^2 - c^2 - 1) / (1 + c^2 + r^2 + 2 c r cos a)] da over |a| < half, c = `ahead` of the
    arc's middle.

    c > 0: the arc bulges away from the axis.
    """
    near, far = math.hypot(1, radius - ahead), math.hypot(1, radius + ahead)
    angle = math.pi / 2 if half >= math.pi else math.atan(near / far * math.tan(half / 2))
    return (half + ((radius - ahead) * (radius + ahead) - 1) * 2 * angle / (near * far)) / (2 * math.pi)


def _tents(side_1: float, side_2: float, hole: float, t: float) -> list[tuple[float, float]]:
    """The length that is free for a step s, as tents (w - |s|)+ with weights: (w, weight).

    It is the least of a few straight lines, and nothing where that is below 0.
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
