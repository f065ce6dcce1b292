"""Tracing of next-event rays: they score at their own detector only.

They pass other transparent detectors without a score, and end behind their own or at an acting surface.
"""

from transport.compile.layout import LAYERS, LOOK_BASE, NO_TABLE, SURFACE_MASK, SURFACE_SHIFT
from transport.engine.passes import lane_pass
from transport.engine.shadows import A_SCORE


@lane_pass(NO_TABLE)
def end_unmet(b, table, first, live):
    """End rays that hit nothing more; idle lanes stay in place.

    Fields: updates `weight`, `start`, `distance`, `hit`.
    """
    for k in range(first, live):
        met = (b.hit[k] != 0) & (b.weight[k] != 0.0)
        b.weight[k] = b.weight[k] if met else 0.0
        b.distance[k] = b.distance[k] if met else 0.0
        b.start[k] = b.start[k] if met else 0.0
        b.hit[k] = b.hit[k] if met else 0
    return live


@lane_pass(NO_TABLE)
def look_at_target_alone(b, table, first, live):
    """Ignore detectors other than the one that the ray was cast to.

    Fields: reads `tally`; updates `look`.
    """
    for k in range(first, live):
        b.look[k] = b.look[k] if (b.look[k] & LOOK_BASE) == b.tally[k] else 0
    return live


@lane_pass(NO_TABLE)
def look_through(b, table, first, live):
    """Score departures only for rays that pass through; a ray at a wall does not depart.

    Fields: reads `hit`; updates `look`.
    """
    for k in range(first, live):
        passes = ((b.hit[k] >> SURFACE_SHIFT) & SURFACE_MASK) == 0
        b.look[k] = b.look[k] if passes else 0
    return live


@lane_pass(LAYERS)
def pass_target(b, table, first, live):
    """Count one crossing of its target off the `leg` of each ray.

    Fields: reads `weight`, `hit`, `look`; updates `leg`, `scored`.
    """
    layer, passed = table.layer, 0
    for k in range(first, live):
        there = (b.look[k] != 0) & (((b.hit[k] >> layer) & 1) != 0) & (b.weight[k] != 0.0)
        passed += 1 if there else 0
        b.leg[k] -= 1 if there else 0
    b.scored += passed * A_SCORE
    return live


@lane_pass(NO_TABLE)
def end_expected(b, table, first, live):
    """End rays at acting surfaces, and behind their target.

    Fields: reads `hit`, `leg`; updates `weight`.
    """
    for k in range(first, live):
        acts = ((b.hit[k] >> SURFACE_SHIFT) & SURFACE_MASK) != 0
        b.weight[k] = 0.0 if acts | (b.leg[k] <= 0) else b.weight[k]
    return live
