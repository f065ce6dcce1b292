"""Where one acting surface cuts or touches the inside of another: walls that overhang, a ball on a floor.

A particle that lands there is within rounding of both, and the sign of a rounding error must not decide on which side of
the other it is.  The engine keeps it to the side that it came from, in scenes that have such places only.
"""

import math
from collections.abc import Iterator

import numpy as np

from transport.shapes import Disk, Shape, Sphere
from transport.sheets import ROUNDING, Member
from transport.vectors import Vector, dot


def contacts_of(members: list[Member]) -> Iterator[tuple[int, int]]:
    """Pairs (hit, other) of acting members that come within rounding of one another.

    There are none where surfaces share edges only: a point near its own edge is cared for by itself.
    """
    pairs = list(_pairs(members))
    if any(is_inside for *_, is_inside in pairs):
        yield from (pair[:2] for pair in pairs)


def _pairs(members: list[Member]) -> Iterator[tuple[int, int, bool]]:
    """Pairs (hit, other) that touch, and whether the other comes inside the hit."""
    if not members:
        return
    low, high = (np.array([member.shape.bounds[side] for member in members]) for side in (0, 1))
    tolerance = 64 * ROUNDING * (np.abs(low).max() + np.abs(high).max())
    for hit, member in enumerate(members):
        near = ((low <= high[hit] + tolerance) & (high >= low[hit] - tolerance)).all(axis=1)
        for other in np.flatnonzero(near):
            if other != hit and touches(member.shape, members[other].shape, tolerance, tolerance):
                is_inside = touches(member.shape, members[other].shape, -tolerance, tolerance)
                yield hit, int(other), is_inside


def touches(hit: Shape, other: Shape, widened: float, tolerance: float) -> bool:
    """Whether a shape comes within the tolerance of another, of which `widened` (negative: shrunk) counts."""
    if isinstance(hit, Sphere) and isinstance(other, Sphere):
        apart = math.dist(hit.center, other.center)
        return abs(hit.radius - other.radius) - tolerance <= apart <= hit.radius + other.radius + tolerance
    if isinstance(hit, Sphere) or isinstance(other, Sphere):
        ball, flat = (hit, other) if isinstance(hit, Sphere) else (other, hit)
        return abs(dot(_minus(ball.center, flat.center), flat.normal)) <= ball.radius + tolerance
    inside, beside = _common_line(hit, other, widened, tolerance)
    return inside[0] < inside[1] and max(inside[0], beside[0]) <= min(inside[1], beside[1])


def _common_line(
    hit: Shape, other: Shape, widened: float, tolerance: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """The stretches of two planes' common line that lie within one shape, widened, and within the other."""
    nothing = (math.inf, -math.inf)
    slope = dot(hit.normal, other.normal)
    across = tuple(m - slope * n for m, n in zip(other.normal, hit.normal, strict=True))
    steep = dot(across, across)
    if steep <= tolerance**2 / (hit.extent + other.extent) ** 2:
        return nothing, nothing
    step = dot(_minus(other.center, hit.center), other.normal) / steep
    point = tuple(c + step * a for c, a in zip(hit.center, across, strict=True))
    x, y = hit.normal, other.normal
    line = (x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0])
    line = tuple(value / math.sqrt(steep) for value in line)
    return _stretch(hit, point, line, widened), _stretch(other, point, line, tolerance)


def _stretch(shape: Shape, point: Vector, line: Vector, slack: float) -> tuple[float, float]:
    """Where a line in its plane enters and leaves a shape that is widened by the slack; a hole does not count."""
    offset = _minus(point, shape.center)
    if isinstance(shape, Disk):
        middle = -dot(offset, line)
        apart2 = dot(offset, offset) - middle * middle
        half2 = max(shape.radius + slack, 0.0) ** 2 - apart2
        half = math.sqrt(half2) if half2 > 0 else -math.inf
        return middle - half, middle + half
    enter, leave = -math.inf, math.inf
    for axis, length in zip(shape.frame[:2], (shape.width, shape.height), strict=True):
        place, pace, half = dot(offset, axis), dot(line, axis), length / 2 + slack
        if abs(pace) * length <= abs(slack):
            if abs(place) > half:
                return math.inf, -math.inf
            continue
        ends = sorted(((-half - place) / pace, (half - place) / pace))
        enter, leave = max(enter, ends[0]), min(leave, ends[1])
    return enter, leave


def _minus(a: Vector, b: Vector) -> Vector:
    return tuple(p - q for p, q in zip(a, b, strict=True))
