"""Rays to detectors on their way: they pass other meters unseen, count at their own, and end there or where something acts."""

from transport.compile.layout import LAYERS, LOOK_BASE, NO_TABLE, SURFACE_MASK, SURFACE_SHIFT
from transport.engine.passes import lane_pass
from transport.engine.shadows import A_SCORE


@lane_pass(NO_TABLE)
def end_unmet(b, table, first, live):
    """Rays that meet nothing more have ended; idle lanes stay where they are."""
    for k in range(first, live):
        met = (b.hit[k] != 0) & (b.weight[k] != 0.0)
        b.weight[k] = b.weight[k] if met else 0.0
        b.distance[k] = b.distance[k] if met else 0.0
        b.start[k] = b.start[k] if met else 0.0
        b.hit[k] = b.hit[k] if met else 0
    return live


@lane_pass(NO_TABLE)
def look_at_target_alone(b, table, first, live):
    """Of the meters that a ray crosses only the one counts that it was cast to."""
    for k in range(first, live):
        b.look[k] = b.look[k] if (b.look[k] & LOOK_BASE) == b.tally[k] else 0
    return live


@lane_pass(NO_TABLE)
def look_through(b, table, first, live):
    """What crosses departs as well; what arrives at a wall does not."""
    for k in range(first, live):
        passes = ((b.hit[k] >> SURFACE_SHIFT) & SURFACE_MASK) == 0
        b.look[k] = b.look[k] if passes else 0
    return live


@lane_pass(LAYERS)
def pass_target(b, table, first, live):
    """A ray has one crossing of its target less to come."""
    layer, passed = table.layer, 0
    for k in range(first, live):
        there = (b.look[k] != 0) & (((b.hit[k] >> layer) & 1) != 0) & (b.weight[k] != 0.0)
        passed += 1 if there else 0
        b.leg[k] -= 1 if there else 0
    b.scored += passed * A_SCORE
    return live


@lane_pass(NO_TABLE)
def end_expected(b, table, first, live):
    """Rays end where something acts, and behind their target."""
    for k in range(first, live):
        acts = ((b.hit[k] >> SURFACE_SHIFT) & SURFACE_MASK) != 0
        b.weight[k] = 0.0 if acts | (b.leg[k] <= 0) else b.weight[k]
    return live
