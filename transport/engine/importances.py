"""Splitting and Russian roulette by importance, for deep penetration.

The wanted weight is birth weight over importance; within a factor of two of it nothing is done. Flights in
media are cut at stations so close that importance at most doubles between them: particles that penetrate
deeply without a collision are split on the way.
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
MOST_COPIES = 64.0  # per splitting; the rest follows at the next


@device
def rise_at(x, y, z, cx, cy, cz, kx, ky, kz, most):
    """Return the logarithm of importance at a point.

    It is linear along the axis from its start to its end, and constant beyond.
    """
    return min(max((x - cx) * kx + (y - cy) * ky + (z - cz) * kz, 0.0), most)


@device
def wanted_at(x, y, z, birth, cx, cy, cz, kx, ky, kz, most):
    """Return the wanted weight at a point: birth * exp(-rise), at most 1 (the largest birth weight)."""
    return min(birth * exp_negative(-rise_at(x, y, z, cx, cy, cz, kx, ky, kz, most)), 1.0)


@lane_pass(IMPORTANCE)
def begin_where_important(b, table, first, live):
    """Set the reference weight `birth` so that a newborn history has the wanted weight at its birthplace.

    Fields: reads `x, y, z`, `ux, uy, uz`, `weight`, `start`; writes `birth`.
    """
    cx, cy, cz, kx, ky, kz, most = table.cx, table.cy, table.cz, table.kx, table.ky, table.kz, table.most
    for k in range(first, live):
        start = b.start[k] if b.start[k] < 0.0 else 0.0  # an aimed particle, whose x is its target
        x, y, z = b.x[k] + start * b.ux[k], b.y[k] + start * b.uy[k], b.z[k] + start * b.uz[k]
        rise = rise_at(x, y, z, cx, cy, cz, kx, ky, kz, most)
        b.birth[k] = b.weight[k] / exp_negative(-rise)
    return live


@lane_pass(IMPORTANCE)
def cut_flight(b, table, first, live):
    """Cut a flight in a medium at the station where importance has doubled, unless it ends before.

    Fields: reads `x, y, z`, `ux, uy, uz`, `start`, `mfp`, `sigma_a`, `flies`; updates `distance`; writes
    `cut`.
    """
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
    """Revoke the collision of lanes that were cut at a station.

    Mark collisions and stations for weighting.

    Fields: updates `cut`, `collides`, `collisions`.
    """
    paused = 0
    for k in range(first, live):
        pauses = (b.cut[k] != 0) & (b.collides[k] != 0)
        b.cut[k] = 1 if pauses | (b.collides[k] != 0) else 0  # ended within a medium: to be weighted
        b.collides[k] = 0 if pauses else b.collides[k]
        paused += 1 if pauses else 0
    b.collisions -= paused
    return live


@lane_pass(IMPORTANCE)
def weigh_by_importance(b, table, first, live):
    """Split lanes that are too heavy for their place; play Russian roulette with those that are too light.

    The ledger takes the weight killed less the weight gained.

    Fields: reads `x, y, z`, `birth`, `history`, `event`, `cut`; updates `weight`; writes `copies`.
    """
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
