"""Forced first collisions, for thin media: until its first, each flight makes a copy that collides.

On a flight of optical depth tau, weight w exp(-tau) continues uncollided to the surface ahead, and w (1 -
exp(-tau)) flies as a copy, with its own birth weight, to a collision before it, at depth -ln(1 - u (1 -
exp(-tau))).
"""

import math

from transport.compile.layout import NO_TABLE, ROULETTE, SLACK
from transport.engine.collisions import takes_off
from transport.engine.ledger import enter
from transport.engine.passes import lane_pass
from transport.engine.sums import limbs
from transport.physics.paths import depth_before, free_flight

FRESH, FREE = -1.0, 0.0  # to be forced, not to be forced; a positive number: path of a forced copy


@lane_pass(NO_TABLE)
def begin_fresh(b, table, first, live):
    """Mark newborn lanes as not yet collided.

    Fields: writes `ahead`.
    """
    for k in range(first, live):
        b.ahead[k] = FRESH
    return live


@lane_pass(NO_TABLE)
def fly_or_be_forced(b, table, first, live):
    """Sample a free path like collisions.fly.

    Fresh lanes fly to the surface ahead, forced copies have their path.

    Fields: reads `weight`, `history`, `start`, `hit`, `mfp`; updates `event`, `distance`, `ahead`; writes
    `u0`, `u1`, `depth`, `flies`.
    """
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        depth, b.u0[k], b.u1[k] = free_flight(b.history[k], batch, b.event[k], seed_low, seed_high)
        flies, ahead = takes_off(b.hit[k], b.distance[k], b.weight[k]), b.ahead[k]
        path = ahead if ahead > 0.0 else depth * b.mfp[k]
        path = math.inf if ahead == FRESH else path
        b.distance[k] = b.start[k] + (path + 2.0 * SLACK) if flies else b.distance[k]
        b.ahead[k] = FREE if flies & (ahead > 0.0) else ahead
        b.depth[k] = depth
        b.event[k] += 1 if flies else 0
        b.flies[k] = 1 if flies else 0
    return live


@lane_pass(NO_TABLE)
def force_collision(b, table, first, live):
    """Divide fresh lanes into the uncollided part and a copy that collides before the surface ahead.

    Without a surface ahead, the lane collides as sampled.

    Fields: reads `start`, `depth`, `mfp`, `flies`; updates `weight`, `distance`, `ahead`; writes `caught`,
    `path`, `copies`.
    """
    total_high, total_low = 0, 0
    for k in range(first, live):
        fresh = (b.flies[k] != 0) & (b.ahead[k] == FRESH) & (b.mfp[k] < math.inf)
        w, mfp = b.weight[k], b.mfp[k]
        way = b.distance[k] - b.start[k]
        ends = way < math.inf
        tau = way / mfp if fresh & ends else 1.0
        # Depth of the forced collision, and minus the collision probability.
        depth, share = depth_before(tau, b.depth[k])  # share < 0
        path = depth * mfp
        forced = fresh & ends
        high, low = limbs(w)
        caught, rest = -w * share, w + w * share
        caught_high, caught_low = limbs(caught)
        rest_high, rest_low = limbs(rest)
        total_high += high - caught_high - rest_high if forced else 0
        total_low += low - caught_low - rest_low if forced else 0
        b.caught[k] = caught if forced & (caught > 0.0) else 0.0
        b.path[k] = path
        b.copies[k] = 1 if forced & (caught > 0.0) else 0
        b.weight[k] = rest if forced else w
        far = fresh & (not ends)
        b.distance[k] = b.start[k] + (b.depth[k] * mfp + 2.0 * SLACK) if far else b.distance[k]
        b.ahead[k] = FREE if far else b.ahead[k]
    enter(b, ROULETTE, total_high, total_low)
    return live
