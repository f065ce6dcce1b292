"""Horizon of a flat shape: whether one side sees any of the world-frame direction bins."""

import math

from transport.bins import DirectionCone, Directions
from transport.vectors import Vector, dot

ROUNDING = 1e-15  # of a cosine: accuracy of edges such as pi/2 at the horizon


def is_in_sight(directions: Directions | DirectionCone, normal: Vector) -> bool:
    """Return whether any world-frame direction bin is above the horizon of a side with this unit normal."""
    if isinstance(directions, DirectionCone):
        return -dot(directions.axis, normal) < math.sin(directions.half_angle)
    return _highest(directions, normal) > ROUNDING


def _highest(directions: Directions, normal: Vector) -> float:
    """Return the largest cosine to the normal over all directions between the first and last edges."""
    # Range of polar angles; `across` is the largest component normal to z on the allowed azimuths.
    edges = directions.edges()
    first, last = (edges["theta"][i] for i in (0, -1)) if "theta" in edges else _polar(edges.get("mu"))
    across = math.hypot(normal[0], normal[1])
    if "phi" in edges:
        begin, end = (edge - math.atan2(normal[1], normal[0]) for edge in edges["phi"][[0, -1]])
        holds_normal = math.floor(end / (2 * math.pi)) > math.floor(begin / (2 * math.pi))
        across *= 1.0 if holds_normal else max(math.cos(begin), math.cos(end))
    # On the best meridian the cosine is normal_z cos(theta) + across sin(theta), which has one maximum.
    peak = min(max(math.atan2(across, normal[2]), first), last)
    return max(normal[2] * math.cos(theta) + across * math.sin(theta) for theta in (first, peak, last))


def _polar(mu) -> tuple[float, float]:
    """Return the polar angles [rad] of the first and last edge; (0, pi) without bins."""
    return (0.0, math.pi) if mu is None else (math.acos(mu[-1]), math.acos(mu[0]))
