"""Splitting and Russian roulette by importance; forced first collisions; Russian roulette of light histories.

The wanted weight is birth weight over importance; within a factor of two of it nothing is done. Flights in
media are cut at stations so close that importance at most doubles between them: particles that penetrate
deeply without a collision are split on the way.
"""

import math

from numba import int64

from transport.compile import layout
from transport.compile.layout import COLLISION_CLEARANCE
from transport.engine.bodies import lane_pass
from transport.engine.passes.collisions import is_flying, revoke_collisions
from transport.engine.tally import limbs, limbs_of_loss, to_ledger
from transport.physics.device import choose, device
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
def set_reference_weight(lane, table):
    """Set the reference weight `birth` so that a newborn history has the wanted weight at its birthplace."""
    cx, cy, cz, kx, ky, kz, most = table.cx, table.cy, table.cz, table.kx, table.ky, table.kz, table.most
    start = lane.start if lane.start < 0.0 else 0.0  # an aimed particle, whose x is its target
    x, y, z = lane.x + start * lane.ux, lane.y + start * lane.uy, lane.z + start * lane.uz
    rise = log_importance(x, y, z, cx, cy, cz, kx, ky, kz, most)
    lane.birth = lane.weight / exp_negative(-rise)


@lane_pass(layout.IMPORTANCE)
def cut_flight(lane, table):
    """Cut a flight in a medium at the station where importance has doubled, unless it ends before."""
    has_grids = table.has_grids != 0
    cx, cy, cz, kx, ky, kz, most = table.cx, table.cy, table.cz, table.kx, table.ky, table.kz, table.most
    slope = lane.ux * kx + lane.uy * ky + lane.uz * kz
    rise = (lane.x - cx) * kx + (lane.y - cy) * ky + (lane.z - cz) * kz + lane.start * slope
    doubled = max(rise, 0.0) + LN_2
    end = lane.start + ((doubled - rise) / slope + 2.0 * COLLISION_CLEARANCE)
    cuts = (lane.flies != 0) & (slope > 0.0) & (doubled < most) & (end < lane.distance)
    cuts &= (lane.mfp < math.inf) | (lane.sigma_a > 0.0) | has_grids
    lane.distance = choose(cuts, end, lane.distance)
    lane.cut = 1 if cuts else 0


@lane_pass(layout.NO_TABLE, sums=revoke_collisions)
def revoke_station_collisions(lane, table):
    """Revoke the collision of lanes that were cut at a station.

    Mark collisions and stations for weighting.
    """
    pauses = (lane.cut != 0) & (lane.collides != 0)
    lane.cut = 1 if pauses | (lane.collides != 0) else 0  # ended within a medium: to be weighted
    lane.collides = choose(pauses, 0, lane.collides)
    return 1 if pauses else 0


@lane_pass(layout.IMPORTANCE, sums=to_ledger(layout.ROULETTE))
def split_or_roulette(lane, table):
    """Split lanes that are too heavy for their place; play Russian roulette with those that are too light.

    The ledger takes the weight killed less the weight gained.
    """
    cx, cy, cz, kx, ky, kz, most = table.cx, table.cy, table.cz, table.kx, table.ky, table.kz, table.most
    w0, w1, _, _ = event_words(lane.history, lane.batch, lane.event, WEIGH, lane.seed_low, lane.seed_high)
    wanted = wanted_weight(lane.x, lane.y, lane.z, lane.birth, cx, cy, cz, kx, ky, kz, most)
    w, weighed = lane.weight, (lane.cut != 0) & (lane.weight != 0.0)
    ratio = w / wanted
    count = math.floor(ratio) if ratio < MAX_COPIES_PER_SPLIT else MAX_COPIES_PER_SPLIT
    count = count if count > 1.0 else 1.0
    dies_or_rises, splits = weighed & (ratio < 0.5), weighed & (ratio >= 2.0)
    new = w / count if splits else w
    left, _ = survived(w, wanted, uniform(w0, w1))
    new = left if dies_or_rises else new
    lane.copies = int64(count) - 1 if splits else 0
    high, low = limbs(w)
    new_high, new_low = limbs(new)
    many = int64(count) if splits else 1
    lane.weight = new
    return high - many * new_high, low - many * new_low


# ---- Forced first collisions, for thin media: until its first, each flight makes a copy that collides.
#
# On a flight of optical depth tau, weight w exp(-tau) continues uncollided to the surface ahead, and w (1 -
# exp(-tau)) flies as a copy, with its own birth weight, to a collision before it, at depth -ln(1 - u (1 -
# exp(-tau))).

UNCOLLIDED, FREE = -1.0, 0.0  # to be forced, not to be forced; a positive number: path of a forced copy


@lane_pass(layout.NO_TABLE)
def mark_uncollided(lane, table):
    """Mark newborn lanes as not yet collided."""
    lane.forced_path = UNCOLLIDED


@lane_pass(layout.NO_TABLE)
def sample_free_or_forced_path(lane, table):
    """Sample a free path like collisions.sample_free_path.

    Fresh lanes fly to the surface ahead, forced copies have their path.
    """
    seed_low, seed_high, batch = lane.seed_low, lane.seed_high, lane.batch
    depth, lane.u0, lane.u1 = free_flight(lane.history, batch, lane.event, seed_low, seed_high)
    flies, ahead = is_flying(lane.hit, lane.distance, lane.weight), lane.forced_path
    path = ahead if ahead > 0.0 else depth * lane.mfp
    path = math.inf if ahead == UNCOLLIDED else path
    lane.distance = choose(flies, lane.start + (path + 2.0 * COLLISION_CLEARANCE), lane.distance)
    lane.forced_path = FREE if flies & (ahead > 0.0) else ahead
    lane.depth = depth
    lane.event += 1 if flies else 0
    lane.flies = 1 if flies else 0


@lane_pass(layout.NO_TABLE, sums=to_ledger(layout.ROULETTE))
def force_collision(lane, table):
    """Divide fresh lanes into the uncollided part and a copy that collides before the surface ahead.

    Without a surface ahead, the lane collides as sampled.
    """
    fresh = (lane.flies != 0) & (lane.forced_path == UNCOLLIDED) & (lane.mfp < math.inf)
    w, mfp = lane.weight, lane.mfp
    length = lane.distance - lane.start
    ends = length < math.inf
    tau = length / mfp if fresh & ends else 1.0
    # Depth of the forced collision, and minus the collision probability.
    depth, share = depth_before(tau, lane.depth)  # share < 0
    path = depth * mfp
    forced = fresh & ends
    high, low = limbs(w)
    caught, rest = -w * share, w + w * share
    caught_high, caught_low = limbs(caught)
    rest_high, rest_low = limbs(rest)
    lane.copy_weight = caught if forced & (caught > 0.0) else 0.0
    lane.copy_path = path
    lane.copies = 1 if forced & (caught > 0.0) else 0
    lane.weight = rest if forced else w
    far = fresh & (not ends)
    lane.distance = choose(far, lane.start + (lane.depth * mfp + 2.0 * COLLISION_CLEARANCE), lane.distance)
    lane.forced_path = choose(far, FREE, lane.forced_path)
    return high - caught_high - rest_high if forced else 0, low - caught_low - rest_low if forced else 0


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


@lane_pass(layout.ROULETTE_LAW, sums=to_ledger(layout.ROULETTE))
def play_roulette(lane, table):
    """Play Russian roulette at walls, below a share `threshold` of the birth weight.

    Survivors have share `level`.
    """
    w, birth = lane.weight, lane.birth
    is_light = (w < table.threshold * birth) & (w > 0.0) & (lane.hit != 0)
    lane.weight, _, high, low = roulette_outcome(is_light, w, table.level * birth, lane.u2)
    return high, low


@lane_pass(layout.IMPORTANCE, sums=to_ledger(layout.ROULETTE))
def play_roulette_by_importance(lane, table):
    """Play Russian roulette at walls, below half the weight wanted there, which survivors have."""
    cx, cy, cz, kx, ky, kz, most = table.cx, table.cy, table.cz, table.kx, table.ky, table.kz, table.most
    w0, w1, _, _ = event_words(lane.history, lane.batch, lane.event, WEIGH, lane.seed_low, lane.seed_high)
    w = lane.weight
    wanted = wanted_weight(lane.x, lane.y, lane.z, lane.birth, cx, cy, cz, kx, ky, kz, most)
    is_light = (w < LIGHT_SHARE * wanted) & (w > 0.0) & (lane.hit != 0)
    lane.weight, _, high, low = roulette_outcome(is_light, w, wanted, uniform(w0, w1))
    return high, low


@lane_pass(layout.ROULETTE_LAW, sums=to_ledger(layout.ROULETTE))
def play_roulette_in_flight(lane, table):
    """Play Russian roulette at collisions, below a share `threshold` of the birth weight."""
    w, birth = lane.weight, lane.birth
    is_light = (lane.collides != 0) & (w < table.threshold * birth)
    new, lane.u0, high, low = roulette_outcome(is_light, w, table.level * birth, lane.u0)
    lane.weight = new
    lane.collides = choose(new == 0.0, 0, lane.collides)
    return high, low
