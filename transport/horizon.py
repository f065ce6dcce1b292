"""The horizon of a flat shape: whether its side can see any direction of bins that are given in the world's frame."""

import math

from transport.bins import DirectionCone, Directions
from transport.vectors import Vector, dot

ROUNDING = 1e-15  # of a cosine: no nearer to the horizon are edges such as pi/2 known


def is_in_sight(directions: Directions | DirectionCone, normal: Vector) -> bool:
    """Whether any direction of the bins, in the world's frame, is above the horizon of a side with this unit normal."""
    if isinstance(directions, DirectionCone):
        return -dot(directions.axis, normal) < math.sin(directions.half_angle)
    return _highest(directions, normal) > ROUNDING


def _highest(directions: Directions, normal: Vector) -> float:
    """The largest cosine to the normal of all directions from the first edges to the last."""
    edges = directions.edges()
    first, last = (edges["theta"][i] for i in (0, -1)) if "theta" in edges else _polar(edges.get("mu"))
    across = math.hypot(normal[0], normal[1])
    if "phi" in edges:
        begin, end = (edge - math.atan2(normal[1], normal[0]) for edge in edges["phi"][[0, -1]])
        holds_normal = math.floor(end / (2 * math.pi)) > math.floor(begin / (2 * math.pi))
        across *= 1.0 if holds_normal else max(math.cos(begin), math.cos(end))
    # On the best meridian the cosine is normal_z cos(theta) + across sin(theta), with one peak.
    peak = min(max(math.atan2(across, normal[2]), first), last)
    return max(normal[2] * math.cos(theta) + across * math.sin(theta) for theta in (first, peak, last))


def _polar(mu) -> tuple[float, float]:
    """Polar angles of the first and last edge, of all directions without."""
    return (0.0, math.pi) if mu is None else (math.acos(mu[-1]), math.acos(mu[0]))
