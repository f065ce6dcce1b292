"""Media along a flight: free path, absorption at collisions or along the path, scattering.

A flight ends at a surface or, before that, at a collision: the free path bounds `distance` before surfaces
are searched. Lanes at a surface wait while the others collide and fly on (driver._fly_until_few); `flies`
distinguishes them.

Collisions keep a distance of layout.COLLISION_CLEARANCE from surfaces ahead and behind, so that no rounding
carries one through a surface.
"""

import math

from transport.compile import layout
from transport.compile.layout import COLLISION_CLEARANCE
from transport.compile.media import SEGMENT
from transport.engine.bundle import add_to_row, view
from transport.engine.registry import lane_pass
from transport.engine.tally import add_to_ledger, hash_salt, hashed_uniform, limbs, limbs_of_loss
from transport.physics.bits import bits_of, float_of
from transport.physics.device import device
from transport.physics.directions import sample_isotropic, select
from transport.physics.elementary import exp_negative
from transport.physics.paths import free_flight
from transport.physics.scattering import (
    choose_segment,
    sample_henyey_greenstein,
    sample_rayleigh,
    sample_segment,
    turned_by_angle,
)

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
def start_flight(b, table, first, live):
    """Mark all lanes as flying: distance 0, no hit.

    Fields: writes `distance`, `hit`.
    """
    for k in range(first, live):
        b.distance[k] = 0.0
        b.hit[k] = 0
    return live


@lane_pass(layout.NO_TABLE)
def fly_uncollided(b, table, first, live):
    """Set an infinite free path (no collisions): fly to the next surface.

    Fields: writes `distance`, `hit`, `flies`.
    """
    for k in range(first, live):
        b.distance[k] = math.inf
        b.hit[k] = 0
        b.flies[k] = 1
    return live


@device
def is_flying(hit, distance, weight):
    """Return whether a lane flies: no surface hit yet, not leaving, alive."""
    return (hit == 0) & (distance < math.inf) & (weight != 0.0)


@lane_pass(layout.NO_TABLE)
def sample_free_path(b, table, first, live):
    """Sample a free path by the exponential law, and the uniforms u0, u1 of the collision at its end.

    Fields: reads `weight`, `history`, `start`, `hit`, `mfp`; updates `event`, `distance`; writes `u0`, `u1`,
    `flies`.
    """
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        depth, b.u0[k], b.u1[k] = free_flight(b.history[k], batch, b.event[k], seed_low, seed_high)
        flies = is_flying(b.hit[k], b.distance[k], b.weight[k])
        path = depth * b.mfp[k] + 2.0 * COLLISION_CLEARANCE
        b.distance[k] = b.start[k] + path if flies else b.distance[k]
        b.event[k] += 1 if flies else 0
        b.flies[k] = 1 if flies else 0
    return live


@lane_pass(layout.NO_TABLE)
def collide(b, table, first, live):
    """Move lanes to the end of the free path where no surface came before it; mark them as colliding.

    Fields: reads `ux, uy, uz`, `weight`, `distance`, `hit`, `flies`; updates `x, y, z`, `sheet`, `start`,
    `collisions`; writes `collides`, `colliding`.
    """
    colliding = 0
    for k in range(first, live):
        collides = (b.flies[k] != 0) & (b.hit[k] == 0) & (b.distance[k] < math.inf) & (b.weight[k] != 0.0)
        d = b.distance[k] - COLLISION_CLEARANCE if collides else 0.0
        b.x[k] += d * b.ux[k]
        b.y[k] += d * b.uy[k]
        b.z[k] += d * b.uz[k]
        b.start[k] = 0.0 if collides else b.start[k]
        b.sheet[k] = 0 if collides else b.sheet[k]
        b.collides[k] = 1 if collides else 0
        colliding += 1 if collides else 0
    b.colliding = colliding
    b.collisions += colliding
    return live


@lane_pass(layout.NO_TABLE)
def attenuate(b, table, first, live):
    """Absorb along the path: weight times exp(-sigma_a path).

    `high`, `low` receive the absorbed weight as a difference of exact sums.

    Fields: reads `history`, `start`, `distance`, `sigma_a`, `flies`; updates `weight`; writes `high`, `low`.
    """
    any_thin = 0
    for k in range(first, live):
        any_thin |= 1 if is_weak(b.sigma_a[k] * (b.distance[k] - b.start[k])) else 0
    if any_thin != 0:
        attenuate_unbiased(b, first, live)
        return live
    for k in range(first, live):
        length, sigma_a, before = b.distance[k] - b.start[k], b.sigma_a[k], b.weight[k]
        depth = sigma_a * length if (b.flies[k] != 0) & (sigma_a > 0.0) else 0.0
        after = before * exp_negative(-depth)
        b.high[k], b.low[k] = limbs_of_loss(before, after)
        b.weight[k] = after
    return live


@device
def attenuate_unbiased(b, first, live):
    """Absorb along the path where the change of a weight may be below its last digits; unbiased.

    Fields: reads `history`, `start`, `distance`, `sigma_a`, `flies`; updates `weight`; writes `high`, `low`.
    """
    salt = hash_salt(b.seed_low, b.batch)
    for k in range(first, live):
        length, sigma_a, before = b.distance[k] - b.start[k], b.sigma_a[k], b.weight[k]
        depth = sigma_a * length if (b.flies[k] != 0) & (sigma_a > 0.0) else 0.0
        after = attenuated(before, depth, salt + b.history[k])
        b.high[k], b.low[k] = limbs_of_loss(before, after)
        b.weight[k] = after


@lane_pass(layout.NO_TABLE)
def absorb_at_collisions(b, table, first, live):
    """Absorb all or nothing at a collision: survive with probability `survival`; rescales and reuses u0.

    Fields: reads `survival`; updates `weight`, `u0`, `collides`; writes `high`, `low`.
    """
    for k in range(first, live):
        u, survival, collides = b.u0[k], b.survival[k], b.collides[k] != 0
        dies = collides & (u >= survival)
        fresh = u / survival
        b.u0[k] = fresh if fresh < 1.0 else 0.0
        high, low = limbs(b.weight[k] if dies else 0.0)
        b.high[k], b.low[k] = high, low
        b.weight[k] = 0.0 if dies else b.weight[k]
        b.collides[k] = 0 if dies else b.collides[k]
    return live


@lane_pass(layout.ABSORBING_MEDIUM)
def account_absorbed_in(b, table, first, live):
    """Add the absorption in one medium to its row of the ledger.

    Fields: reads `medium`, `high`, `low`.
    """
    high, low, medium = 0, 0, table.medium
    for k in range(first, live):
        here = b.medium[k] == medium
        high += b.high[k] if here else 0
        low += b.low[k] if here else 0
    add_to_ledger(b, table.ledger, high, low)
    return live


@lane_pass(layout.ABSORBING_MEDIUM)
def account_absorbed_in_all(b, table, first, live):
    """Add the absorption in all media to their rows of the ledger: one addition per lane.

    Fields: reads `medium`, `high`, `low`.
    """
    rows = b.ledger + 32 * table.ledger
    for k in range(first, live):
        add_to_row(rows + 32 * b.medium[k], b.high[k], b.low[k], 0, 0)
    return live


@lane_pass(layout.TWO_ROWS)
def choose_phase(b, table, first, live):
    """Choose the phase function of the medium; of a mixture, one part with the probability of its share.

    The uniform u0 is rescaled within the part's share and reused.

    Fields: reads `medium`; updates `u0`, `collides`.
    """
    media = view(table.rows, table.count, layout.MEDIA)
    laws = view(table.others, table.other_count, layout.PHASE_LAW)
    for k in range(first, live):
        if b.collides[k] != 0:
            chosen = media[b.medium[k]].phase
            low, last, u = 0.0, chosen + laws[chosen - 1].parts - 1, b.u0[k]
            while chosen < last and u >= laws[chosen - 1].share:
                low = laws[chosen - 1].share
                chosen += 1
            if laws[chosen - 1].parts > 1:
                b.u0[k] = min((u - low) / (laws[chosen - 1].share - low), 1.0 - 2.0**-53)
            b.collides[k] = chosen
    return live


@lane_pass(layout.PHASE_LAW)
def scatter_isotropic(b, table, first, live):
    """Sample an isotropic direction.

    Fields: reads `u0`, `u1`, `collides`; updates `ux, uy, uz`.
    """
    number = table.number
    for k in range(first, live):
        ux, uy, uz = sample_isotropic(b.u0[k], b.u1[k])
        here = b.collides[k] == number
        b.ux[k], b.uy[k], b.uz[k] = select(here, ux, uy, uz, b.ux[k], b.uy[k], b.uz[k])
    return live


@lane_pass(layout.PHASE_LAW)
def scatter_henyey_greenstein(b, table, first, live):
    """Sample the scattering angle by the phase function of Henyey and Greenstein (1941).

    Fields: reads `u0`, `u1`, `collides`; updates `ux, uy, uz`.
    """
    number, g = table.number, table.g
    for k in range(first, live):
        mu, sine = sample_henyey_greenstein(g, b.u0[k])
        ux, uy, uz = turned_by_angle(b.ux[k], b.uy[k], b.uz[k], mu, sine, b.u1[k])
        here = b.collides[k] == number
        b.ux[k], b.uy[k], b.uz[k] = select(here, ux, uy, uz, b.ux[k], b.uy[k], b.uz[k])
    return live


@lane_pass(layout.PHASE_LAW)
def scatter_rayleigh(b, table, first, live):
    """Sample the scattering angle by the phase function of Rayleigh (1871), 3/(16 pi) (1 + mu^2).

    Fields: reads `u0`, `u1`, `collides`; updates `ux, uy, uz`.
    """
    number = table.number
    for k in range(first, live):
        mu, sine = sample_rayleigh(b.u0[k])
        ux, uy, uz = turned_by_angle(b.ux[k], b.uy[k], b.uz[k], mu, sine, b.u1[k])
        here = b.collides[k] == number
        b.ux[k], b.uy[k], b.uz[k] = select(here, ux, uy, uz, b.ux[k], b.uy[k], b.uz[k])
    return live


@lane_pass(layout.PHASE_LAW)
def choose_segment_of_table(b, table, first, live):
    """Choose a segment of a tabulated phase function (alias method).

    Puts start, width and share of the segment into nx, ny, nz. The gather is a pass of its own because it
    would slow down the loop that turns directions.

    Fields: reads `collides`; updates `u0`; writes `nx, ny, nz`.
    """
    number, count, rows = table.number, table.count, view(table.rows, table.count, SEGMENT)
    for k in range(first, live):
        if b.collides[k] == number:
            b.nx[k], b.ny[k], b.nz[k], b.u0[k] = choose_segment(rows, count, b.u0[k])
    return live


@lane_pass(layout.PHASE_LAW)
def scatter_tabulated(b, table, first, live):
    """Sample the scattering angle by a tabulated phase function, within the chosen segment.

    Fields: reads `nx, ny, nz`, `u0`, `u1`, `collides`; updates `ux, uy, uz`.
    """
    number = table.number
    for k in range(first, live):
        here = b.collides[k] == number
        start, width, share = b.nx[k] if here else 0.0, b.ny[k] if here else 1.0, b.nz[k] if here else 0.5
        mu, sine = sample_segment(start, width, share, b.u0[k])
        ux, uy, uz = turned_by_angle(b.ux[k], b.uy[k], b.uz[k], mu, sine, b.u1[k])
        b.ux[k], b.uy[k], b.uz[k] = select(here, ux, uy, uz, b.ux[k], b.uy[k], b.uz[k])
    return live


@lane_pass(layout.NO_TABLE)
def count_scatterings(b, table, first, live):
    """Count the scattering of lanes that collided and survived.

    Fields: reads `collides`; updates `reflections`.
    """
    for k in range(first, live):
        b.reflections[k] += 1 if b.collides[k] != 0 else 0
    return live
