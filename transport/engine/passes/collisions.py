"""Media along a flight: free path, absorption at collisions or along the path, scattering.

A flight ends at a surface or, before that, at a collision: the free path bounds `distance` before surfaces
are searched. Lanes at a surface wait in a queue while the others collide and fly on (passes/lanes.py).

Collisions keep a distance of layout.COLLISION_CLEARANCE from surfaces ahead and behind, so that no rounding
carries one through a surface.
"""

import math

from transport.compile import layout
from transport.compile.layout import COLLISION_CLEARANCE
from transport.compile.media import SEGMENT
from transport.engine.bodies import lane_pass
from transport.engine.bundle import add_to_row, view
from transport.engine.tally import (
    hash_salt,
    hashed_uniform,
    limbs_of_loss,
    to_row_of_table,
)
from transport.engine.words import event_block, words_of_block
from transport.physics.bits import bits_of, float_of
from transport.physics.device import choose, device
from transport.physics.directions import sample_isotropic, select
from transport.physics.elementary import exp_negative
from transport.physics.paths import free_depth
from transport.physics.scattering import (
    choose_segment,
    sample_henyey_greenstein,
    sample_rayleigh,
    sample_segment,
    turned_by_angle,
)
from transport.physics.streams import LOW32, PATH, short_uniform, uniform

# ---- Absorption too weak for the digits of a weight: unbiased to the last unit of the ledger.
#
# before * exp(-depth), rounded, is off by half a unit in its last place: 1e-16 / depth of the absorbed
# weight, with the same sign where all paths are equal; below 1e-16 nothing is absorbed at all. The absorbed
# weight before * (1 - exp(-depth)) is known to all digits, so the remaining weight is rounded up or down at
# random with the right mean.

# optical depth below which this is done: above it rounding errs by at most 1e-10 of the absorbed weight
WEAK_DEPTH = 2.0**-20


@device
def is_weak(depth):
    """Return whether a path absorbs so little."""
    return (depth > 0.0) & (depth < WEAK_DEPTH)


@device
def attenuated(before, depth, salt):
    """Return before * exp(-depth); for a weak depth rounded at random, exact in the mean over salts."""
    if not (is_weak(depth) and before != 0.0):
        return before * exp_negative(-depth)
    kept = before * (depth - depth * depth * (0.5 - depth / 6.0))
    after = before - kept
    excess = (before - after) - kept  # by which rounding has absorbed too much
    other = float_of(bits_of(after) + (1 if excess > 0.0 else -1))
    return other if hashed_uniform(bits_of(depth), salt) * abs(other - after) < abs(excess) else after


# ---- The passes.


@lane_pass(layout.NO_TABLE)
def fly_uncollided(lane, table):
    """Set an infinite free path (no collisions): fly to the next surface."""
    lane.distance = math.inf
    lane.hit, lane.covered = 0, 0


@lane_pass(layout.NO_TABLE, before=event_block(PATH))
def draw_flight(lane, table):
    """Draw the uniforms of a flight: one of its path, in `depth`, and u0, u1 of the collision at its end.

    They have 52, 52 and 32 bits. The flight has no surface ahead yet.
    """
    w0, w1, w2, w3 = words_of_block(lane)
    lane.depth, lane.u0, lane.u1 = uniform(w0, w1), uniform(w2, (w1 << 20) & LOW32), short_uniform(w3)
    lane.hit, lane.covered = 0, 0
    lane.event += 1


@lane_pass(layout.NO_TABLE)
def sample_free_path(lane, table):
    """Sample a free path by the exponential law."""
    lane.distance = lane.start + (free_depth(lane.depth) * lane.mfp + 2.0 * COLLISION_CLEARANCE)


@device
def count_collisions(lane, table, colliding):
    """Count the collisions."""
    lane.collisions += colliding


@device
def revoke_collisions(lane, table, paused):
    """Take collisions off their count."""
    lane.collisions -= paused


@lane_pass(layout.NO_TABLE, sums=count_collisions)
def collide(lane, table):
    """Move lanes to the end of the free path where no surface came before it; mark them as colliding."""
    collides = (lane.hit == 0) & (lane.distance < math.inf) & (lane.weight != 0.0)
    d = lane.distance - COLLISION_CLEARANCE if collides else 0.0
    lane.x += d * lane.ux
    lane.y += d * lane.uy
    lane.z += d * lane.uz
    lane.start = choose(collides, 0.0, lane.start)
    lane.sheet = choose(collides, 0, lane.sheet)
    lane.collides = 1 if collides else 0
    return 1 if collides else 0


@device
def path_depth(lane):
    """Return the optical depth by which absorption along the path lessens a weight."""
    is_absorbed = (lane.weight != 0.0) & (lane.sigma_a > 0.0)
    return lane.sigma_a * (lane.distance - lane.start) if is_absorbed else 0.0


@device
def is_path_weak(lane, table):
    """Return whether the path absorbs too little for the digits of a weight."""
    return is_weak(lane.sigma_a * (lane.distance - lane.start))


@lane_pass(layout.NO_TABLE)
def attenuate_unbiased(lane, table):
    """Absorb along the path where the change of a weight may be below its last digits; unbiased."""
    salt = hash_salt(lane.seed_low, lane.batch) + lane.history
    lane.left = attenuated(lane.weight, path_depth(lane), salt)


@lane_pass(layout.NO_TABLE, unless=(is_path_weak, attenuate_unbiased))
def attenuate(lane, table):
    """Absorb along the path: weight times exp(-sigma_a path)."""
    lane.left = lane.weight * exp_negative(-path_depth(lane))


@lane_pass(layout.NO_TABLE)
def absorb_at_collisions(lane, table):
    """Absorb all or nothing at a collision: survive with probability `survival`; rescales and reuses u0."""
    u, survival, collides = lane.u0, lane.survival, lane.collides != 0
    dies = collides & (u >= survival)
    fresh = u / survival
    lane.u0 = fresh if fresh < 1.0 else 0.0
    lane.left = choose(dies, 0.0, lane.weight)
    lane.collides = choose(dies, 0, lane.collides)


@lane_pass(layout.ABSORBING_MEDIUM, sums=to_row_of_table)
def account_absorbed_in(lane, table):
    """Take what one medium absorbed from the weights, and add it to its row of the ledger.

    It is added as a difference of exact sums. A loop of its own is faster than one with the exponential: the
    chain of operations of each lane is shorter, so the processor works at more lanes at once.
    """
    here = lane.medium == table.medium
    high, low = limbs_of_loss(lane.weight, lane.left)
    lane.weight = choose(here, lane.left, lane.weight)
    return high if here else 0, low if here else 0


@device
def take_absorbed(lane, table):
    """Take what a medium absorbed from the weight; `high`, `low` receive it as a difference of exact sums."""
    lane.high, lane.low = limbs_of_loss(lane.weight, lane.left)
    lane.weight = lane.left


@lane_pass(layout.ABSORBING_MEDIUM, before=take_absorbed)
def account_absorbed_in_all(lane, table):
    """Do the same for all media: one addition per lane."""
    add_to_row(lane.ledger + 32 * table.ledger + 32 * lane.medium, lane.high, lane.low, 0, 0)


@lane_pass(layout.TWO_ROWS)
def choose_phase(lane, table):
    """Choose the phase function of the medium; of a mixture, one part with the probability of its share.

    The uniform u0 is rescaled within the part's share and reused.
    """
    media = view(lane.arena + table.rows, table.count, layout.MEDIA)
    laws = view(lane.arena + table.others, table.other_count, layout.PHASE_LAW)
    if lane.collides != 0:
        chosen = media[lane.medium].phase
        low, last, u = 0.0, chosen + laws[chosen - 1].parts - 1, lane.u0
        while chosen < last and u >= laws[chosen - 1].share:
            low = laws[chosen - 1].share
            chosen += 1
        if laws[chosen - 1].parts > 1:
            lane.u0 = min((u - low) / (laws[chosen - 1].share - low), 1.0 - 2.0**-53)
        lane.collides = chosen


@lane_pass(layout.PHASE_LAW)
def scatter_isotropic(lane, table):
    """Sample an isotropic direction."""
    number = table.number
    ux, uy, uz = sample_isotropic(lane.u0, lane.u1)
    here = lane.collides == number
    lane.ux, lane.uy, lane.uz = select(here, ux, uy, uz, lane.ux, lane.uy, lane.uz)


@lane_pass(layout.PHASE_LAW)
def scatter_henyey_greenstein(lane, table):
    """Sample the scattering angle by the phase function of Henyey and Greenstein (1941)."""
    number, g = table.number, table.g
    mu, sine = sample_henyey_greenstein(g, lane.u0)
    ux, uy, uz = turned_by_angle(lane.ux, lane.uy, lane.uz, mu, sine, lane.u1)
    here = lane.collides == number
    lane.ux, lane.uy, lane.uz = select(here, ux, uy, uz, lane.ux, lane.uy, lane.uz)


@lane_pass(layout.PHASE_LAW)
def scatter_rayleigh(lane, table):
    """Sample the scattering angle by the phase function of Rayleigh (1871), 3/(16 pi) (1 + mu^2)."""
    number = table.number
    mu, sine = sample_rayleigh(lane.u0)
    ux, uy, uz = turned_by_angle(lane.ux, lane.uy, lane.uz, mu, sine, lane.u1)
    here = lane.collides == number
    lane.ux, lane.uy, lane.uz = select(here, ux, uy, uz, lane.ux, lane.uy, lane.uz)


@lane_pass(layout.PHASE_LAW)
def choose_segment_of_table(lane, table):
    """Choose a segment of a tabulated phase function (alias method).

    Puts start, width and share of the segment into nx, ny, nz. The gather is a pass of its own because it
    would slow down the loop that turns directions.
    """
    number, count, rows = table.number, table.count, view(lane.arena + table.rows, table.count, SEGMENT)
    if lane.collides == number:
        lane.nx, lane.ny, lane.nz, lane.u0 = choose_segment(rows, count, lane.u0)


@lane_pass(layout.PHASE_LAW)
def scatter_tabulated(lane, table):
    """Sample the scattering angle by a tabulated phase function, within the chosen segment."""
    number = table.number
    here = lane.collides == number
    start, width, share = lane.nx if here else 0.0, lane.ny if here else 1.0, lane.nz if here else 0.5
    mu, sine = sample_segment(start, width, share, lane.u0)
    ux, uy, uz = turned_by_angle(lane.ux, lane.uy, lane.uz, mu, sine, lane.u1)
    lane.ux, lane.uy, lane.uz = select(here, ux, uy, uz, lane.ux, lane.uy, lane.uz)


@lane_pass(layout.NO_TABLE)
def count_scatterings(lane, table):
    """Count the scattering of lanes that collided and survived."""
    lane.reflections += 1 if lane.collides != 0 else 0
