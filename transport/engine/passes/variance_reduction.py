"""Splitting and Russian roulette by importance; forced first collisions; Russian roulette of light histories.

The wanted weight is birth weight over importance; within a factor of two of it nothing is done. Flights in
media are cut at stations so close that importance at most doubles between them: particles that penetrate
deeply without a collision are split on the way.
"""

import math

from numba import int64

from transport.compile import layout
from transport.compile.layout import COLLISION_CLEARANCE
from transport.engine.passes.collisions import is_flying
from transport.engine.registry import lane_pass
from transport.engine.tally import add_to_ledger, limbs, limbs_of_loss
from transport.physics.device import device
from transport.physics.elementary import exp_negative
from transport.physics.paths import depth_before, free_flight, survived
from transport.physics.streams import WEIGH, event_words, uniform

LN_2 = 0.6931471805599453
MAX_COPIES_PER_SPLIT = 64.0  # per splitting; the rest follows at the next


@device
def log_importance(x, y, z, cx, cy, cz, kx, ky, kz, most):
    """Return the logarithm of importance at a point.

    It is linear along the axis from its start to its end, and constant beyond.
    """
    return min(max((x - cx) * kx + (y - cy) * ky + (z - cz) * kz, 0.0), most)


@device
def wanted_weight(x, y, z, birth, cx, cy, cz, kx, ky, kz, most):
    """Return the wanted weight at a point: birth * exp(-rise), at most 1 (the largest birth weight)."""
    return min(birth * exp_negative(-log_importance(x, y, z, cx, cy, cz, kx, ky, kz, most)), 1.0)


@lane_pass(layout.IMPORTANCE)
def set_reference_weight(b, table, first, live):
    """Set the reference weight `birth` so that a newborn history has the wanted weight at its birthplace.

    Fields: reads `x, y, z`, `ux, uy, uz`, `weight`, `start`; writes `birth`.
    """
    cx, cy, cz, kx, ky, kz, most = table.cx, table.cy, table.cz, table.kx, table.ky, table.kz, table.most
    for k in range(first, live):
        start = b.start[k] if b.start[k] < 0.0 else 0.0  # an aimed particle, whose x is its target
        x, y, z = b.x[k] + start * b.ux[k], b.y[k] + start * b.uy[k], b.z[k] + start * b.uz[k]
        rise = log_importance(x, y, z, cx, cy, cz, kx, ky, kz, most)
        b.birth[k] = b.weight[k] / exp_negative(-rise)
    return live


@lane_pass(layout.IMPORTANCE)
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
        doubled = max(rise, 0.0) + LN_2
        end = b.start[k] + ((doubled - rise) / slope + 2.0 * COLLISION_CLEARANCE)
        cuts = (b.flies[k] != 0) & (slope > 0.0) & (doubled < most) & (end < b.distance[k])
        cuts &= (b.mfp[k] < math.inf) | (b.sigma_a[k] > 0.0) | has_grids
        b.distance[k] = end if cuts else b.distance[k]
        b.cut[k] = 1 if cuts else 0
    return live


@lane_pass(layout.NO_TABLE)
def revoke_station_collisions(b, table, first, live):
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


@lane_pass(layout.IMPORTANCE)
def split_or_roulette(b, table, first, live):
    """Split lanes that are too heavy for their place; play Russian roulette with those that are too light.

    The ledger takes the weight killed less the weight gained.

    Fields: reads `x, y, z`, `birth`, `history`, `event`, `cut`; updates `weight`; writes `copies`.
    """
    cx, cy, cz, kx, ky, kz, most = table.cx, table.cy, table.cz, table.kx, table.ky, table.kz, table.most
    total_high, total_low = 0, 0
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, _, _ = event_words(b.history[k], batch, b.event[k], WEIGH, seed_low, seed_high)
        wanted = wanted_weight(b.x[k], b.y[k], b.z[k], b.birth[k], cx, cy, cz, kx, ky, kz, most)
        w, weighed = b.weight[k], (b.cut[k] != 0) & (b.weight[k] != 0.0)
        ratio = w / wanted
        count = math.floor(ratio) if ratio < MAX_COPIES_PER_SPLIT else MAX_COPIES_PER_SPLIT
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
    add_to_ledger(b, layout.ROULETTE, total_high, total_low)
    return live


# ---- Forced first collisions, for thin media: until its first, each flight makes a copy that collides.
#
# On a flight of optical depth tau, weight w exp(-tau) continues uncollided to the surface ahead, and w (1 -
# exp(-tau)) flies as a copy, with its own birth weight, to a collision before it, at depth -ln(1 - u (1 -
# exp(-tau))).

UNCOLLIDED, FREE = -1.0, 0.0  # to be forced, not to be forced; a positive number: path of a forced copy


@lane_pass(layout.NO_TABLE)
def mark_uncollided(b, table, first, live):
    """Mark newborn lanes as not yet collided.

    Fields: writes `forced_path`.
    """
    for k in range(first, live):
        b.forced_path[k] = UNCOLLIDED
    return live


@lane_pass(layout.NO_TABLE)
def sample_free_or_forced_path(b, table, first, live):
    """Sample a free path like collisions.sample_free_path.

    Fresh lanes fly to the surface ahead, forced copies have their path.

    Fields: reads `weight`, `history`, `start`, `hit`, `mfp`; updates `event`, `distance`, `forced_path`;
    writes `u0`, `u1`, `depth`, `flies`.
    """
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        depth, b.u0[k], b.u1[k] = free_flight(b.history[k], batch, b.event[k], seed_low, seed_high)
        flies, ahead = is_flying(b.hit[k], b.distance[k], b.weight[k]), b.forced_path[k]
        path = ahead if ahead > 0.0 else depth * b.mfp[k]
        path = math.inf if ahead == UNCOLLIDED else path
        b.distance[k] = b.start[k] + (path + 2.0 * COLLISION_CLEARANCE) if flies else b.distance[k]
        b.forced_path[k] = FREE if flies & (ahead > 0.0) else ahead
        b.depth[k] = depth
        b.event[k] += 1 if flies else 0
        b.flies[k] = 1 if flies else 0
    return live


@lane_pass(layout.NO_TABLE)
def force_collision(b, table, first, live):
    """Divide fresh lanes into the uncollided part and a copy that collides before the surface ahead.

    Without a surface ahead, the lane collides as sampled.

    Fields: reads `start`, `depth`, `mfp`, `flies`; updates `weight`, `distance`, `forced_path`; writes
    `copy_weight`, `copy_path`, `copies`.
    """
    total_high, total_low = 0, 0
    for k in range(first, live):
        fresh = (b.flies[k] != 0) & (b.forced_path[k] == UNCOLLIDED) & (b.mfp[k] < math.inf)
        w, mfp = b.weight[k], b.mfp[k]
        length = b.distance[k] - b.start[k]
        ends = length < math.inf
        tau = length / mfp if fresh & ends else 1.0
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
        b.copy_weight[k] = caught if forced & (caught > 0.0) else 0.0
        b.copy_path[k] = path
        b.copies[k] = 1 if forced & (caught > 0.0) else 0
        b.weight[k] = rest if forced else w
        far = fresh & (not ends)
        b.distance[k] = b.start[k] + (b.depth[k] * mfp + 2.0 * COLLISION_CLEARANCE) if far else b.distance[k]
        b.forced_path[k] = FREE if far else b.forced_path[k]
    add_to_ledger(b, layout.ROULETTE, total_high, total_low)
    return live


# ---- Russian roulette at walls and at collisions: light histories end or regain weight, unbiased.
#
# A weight is light relative to the history's birth weight, or to the one wanted by importance, so the unit of
# power does not matter. The ledger takes the weight killed less the weight gained: expectation 0.

LIGHT_SHARE = 0.5  # share of the wanted weight, where importance gives one


@device
def roulette_outcome(is_light, weight, wanted, u):
    """Return (weight, uniform, high limb, low limb) after Russian roulette, played only if is_light.

    The uniform is a fresh one in place of u, the limbs are those of the loss.
    """
    left, fresh = survived(weight, wanted, u)
    new = left if is_light else weight
    high, low = limbs_of_loss(weight, new)
    return new, fresh if is_light else u, high, low


@lane_pass(layout.ROULETTE_LAW)
def play_roulette(b, table, first, live):
    """Play Russian roulette at walls, below a share `threshold` of the birth weight.

    Survivors have share `level`.

    Fields: reads `birth`, `hit`, `u2`; updates `weight`.
    """
    total_high, total_low, threshold, level = 0, 0, table.threshold, table.level
    for k in range(first, live):
        w, birth = b.weight[k], b.birth[k]
        is_light = (w < threshold * birth) & (w > 0.0) & (b.hit[k] != 0)
        b.weight[k], _, high, low = roulette_outcome(is_light, w, level * birth, b.u2[k])
        total_high += high
        total_low += low
    add_to_ledger(b, layout.ROULETTE, total_high, total_low)
    return live


@lane_pass(layout.IMPORTANCE)
def play_roulette_by_importance(b, table, first, live):
    """Play Russian roulette at walls, below half the weight wanted there, which survivors have.

    Fields: reads `x, y, z`, `birth`, `history`, `event`, `hit`; updates `weight`.
    """
    total_high, total_low = 0, 0
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    cx, cy, cz, kx, ky, kz, most = table.cx, table.cy, table.cz, table.kx, table.ky, table.kz, table.most
    for k in range(first, live):
        w0, w1, _, _ = event_words(b.history[k], batch, b.event[k], WEIGH, seed_low, seed_high)
        w = b.weight[k]
        wanted = wanted_weight(b.x[k], b.y[k], b.z[k], b.birth[k], cx, cy, cz, kx, ky, kz, most)
        is_light = (w < LIGHT_SHARE * wanted) & (w > 0.0) & (b.hit[k] != 0)
        b.weight[k], _, high, low = roulette_outcome(is_light, w, wanted, uniform(w0, w1))
        total_high += high
        total_low += low
    add_to_ledger(b, layout.ROULETTE, total_high, total_low)
    return live


@lane_pass(layout.ROULETTE_LAW)
def play_roulette_in_flight(b, table, first, live):
    """Play Russian roulette at collisions, below a share `threshold` of the birth weight.

    Fields: reads `birth`; updates `weight`, `u0`, `collides`.
    """
    total_high, total_low, threshold, level = 0, 0, table.threshold, table.level
    for k in range(first, live):
        w, birth = b.weight[k], b.birth[k]
        is_light = (b.collides[k] != 0) & (w < threshold * birth)
        new, b.u0[k], high, low = roulette_outcome(is_light, w, level * birth, b.u0[k])
        b.weight[k] = new
        b.collides[k] = 0 if new == 0.0 else b.collides[k]
        total_high += high
        total_low += low
    add_to_ledger(b, layout.ROULETTE, total_high, total_low)
    return live
