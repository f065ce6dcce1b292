"""Splitting and thinning out by importance: where it rises histories become many light ones, where it falls few heavy ones.

The weight to have is birth weight over importance; within a factor of two of it nothing is done.  Flights in media are cut
at stations so short that importance at most doubles: what passes deep without a collision is split on the way.
"""

import math

from numba import int64

from transport.compile.layout import IMPORTANCE, NO_TABLE, ROULETTE, SLACK
from transport.engine.ledger import enter
from transport.engine.passes import lane_pass
from transport.engine.sums import limbs
from transport.physics.device import device
from transport.physics.elementary import exp_negative
from transport.physics.roulette import survived
from transport.physics.streams import WEIGH, event_words, uniform

DOUBLE = 0.6931471805599453
MOST_COPIES = 64.0  # of one splitting; the rest follows at the next


@device
def rise_at(x, y, z, cx, cy, cz, kx, ky, kz, most):
    """The logarithm of importance at a place: linear along the way from its start to its end, and constant beyond."""
    return min(max((x - cx) * kx + (y - cy) * ky + (z - cz) * kz, 0.0), most)


@device
def wanted_at(x, y, z, birth, cx, cy, cz, kx, ky, kz, most):
    """The weight to have at a place: the lighter the more important, never heavier than what is born."""
    return min(birth * exp_negative(-rise_at(x, y, z, cx, cy, cz, kx, ky, kz, most)), 1.0)


@lane_pass(IMPORTANCE)
def begin_where_important(b, table, first, live):
    """A history is as heavy as it should be where it is born: what its weight is compared with elsewhere follows from there."""
    cx, cy, cz, kx, ky, kz, most = table.cx, table.cy, table.cz, table.kx, table.ky, table.kz, table.most
    for k in range(first, live):
        start = b.start[k] if b.start[k] < 0.0 else 0.0  # of an aimed one, whose ray is told from its target
        x, y, z = b.x[k] + start * b.ux[k], b.y[k] + start * b.uy[k], b.z[k] + start * b.uz[k]
        rise = rise_at(x, y, z, cx, cy, cz, kx, ky, kz, most)
        b.birth[k] = b.weight[k] / exp_negative(-rise)
    return live


@lane_pass(IMPORTANCE)
def cut_flight(b, table, first, live):
    """A flight in a medium ends at a station where importance has doubled on its way, if nothing ends it before."""
    has_grids = table.has_grids != 0
    cx, cy, cz, kx, ky, kz, most = table.cx, table.cy, table.cz, table.kx, table.ky, table.kz, table.most
    for k in range(first, live):
        slope = b.ux[k] * kx + b.uy[k] * ky + b.uz[k] * kz
        rise = (b.x[k] - cx) * kx + (b.y[k] - cy) * ky + (b.z[k] - cz) * kz + b.start[k] * slope
        doubled = max(rise, 0.0) + DOUBLE
        end = b.start[k] + ((doubled - rise) / slope + 2.0 * SLACK)
        cuts = (b.flies[k] != 0) & (slope > 0.0) & (doubled < most) & (end < b.distance[k])
        cuts &= (b.mfp[k] < math.inf) | (b.sigma_a[k] > 0.0) | has_grids
        b.distance[k] = end if cuts else b.distance[k]
        b.cut[k] = 1 if cuts else 0
    return live


@lane_pass(NO_TABLE)
def pause_at_station(b, table, first, live):
    """What came to a station has not collided."""
    paused = 0
    for k in range(first, live):
        pauses = (b.cut[k] != 0) & (b.collides[k] != 0)
        b.cut[k] = 1 if pauses | (b.collides[k] != 0) else 0  # ended within a medium: to be weighed
        b.collides[k] = 0 if pauses else b.collides[k]
        paused += 1 if pauses else 0
    b.collisions -= paused
    return live


@lane_pass(IMPORTANCE)
def weigh_by_importance(b, table, first, live):
    """Too heavy for the place: split; too light: killed or raised.  The ledger takes what was killed less what was gained."""
    cx, cy, cz, kx, ky, kz, most = table.cx, table.cy, table.cz, table.kx, table.ky, table.kz, table.most
    total_high, total_low = 0, 0
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, _, _ = event_words(b.history[k], batch, b.event[k], WEIGH, seed_low, seed_high)
        wanted = wanted_at(b.x[k], b.y[k], b.z[k], b.birth[k], cx, cy, cz, kx, ky, kz, most)
        w, weighed = b.weight[k], (b.cut[k] != 0) & (b.weight[k] != 0.0)
        ratio = w / wanted
        count = math.floor(ratio) if ratio < MOST_COPIES else MOST_COPIES
        count = count if count > 1.0 else 1.0
        dies_or_rises, splits = weighed & (ratio < 0.5), weighed & (ratio >= 2.0)
        new = w / count if splits else w
        left, _ = survived(w, wanted, uniform(w0, w1))
        new = left if dies_or_rises else new
        b.copies[k] = int64(count) - 1 if splits else 0
        high, low = limbs(w)
        new_high, new_low = limbs(new)
        many = int64(count) if splits else 1
        total_high += high - many * new_high
        total_low += low - many * new_low
        b.weight[k] = new
    enter(b, ROULETTE, total_high, total_low)
    return live
