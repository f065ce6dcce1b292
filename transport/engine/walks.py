"""Delta tracking through voxels (Woodcock 1965): walks of one grid, compacted in rows of their own.

A walk spends an optical depth. In each macro cell it spends it at the rate of the majorant, the largest
extinction there; where it is spent, a tentative collision is real with probability extinction of the voxel
over majorant, else the walk continues with a new depth. Macro cells are left by incrementing indices, never
by comparing positions, so every turn makes progress. These are loops over walks for `grids.collide_in_grid`.
"""

from numba import int64, uint64

from transport.compile.layout import LEVELS, SLACK
from transport.engine.bundle import CARRIED, CARRIED_WORDS, PITCH, SCRATCH
from transport.engine.voxels import voxel_along
from transport.physics.device import device
from transport.physics.elementary import log_positive
from transport.physics.streams import VOXELS, event_words, uniform

FLIES, TRIES, UNSURE, REJECTED, ENDED, COLLIDED, PAUSED = range(7)  # states of a walk
WALK = [name for name, _ in SCRATCH if name.startswith("walk_")]
WALK_FIELDS = len(WALK)
WALK_WORDS = CARRIED_WORDS + PITCH * [name for name, _ in CARRIED + SCRATCH].index(WALK[0])
DRAW = uint64(8)  # bits of a purpose below the number of the draw
MOST_TURNS = 8  # turns before a walk pauses, so that the others do not wait for long
BELOW_ONE = 1.0 - 2.0**-53


@device
def place_of(i, j, m, my, mz):
    """Return the index of a macro cell in the table of majorants.

    The table has two numbers per cell, and one more cell on every side.
    """
    return int64(2.0 * (((i + 1.0) * (my + 2.0) + (j + 1.0)) * (mz + 2.0) + (m + 1.0)))


@device
def cross(b, table, first, last):
    """Move each walk to the end of its macro cell, to its tentative collision or to its end.

    Returns the numbers of walks that try a collision, that go on (or try), and that pause.

    Fields: reads `walk_end`, `walk_top`, `walk_px, walk_py, walk_pz`, `walk_vx, walk_vy, walk_vz`,
    `walk_ix, walk_iy, walk_iz`; updates `walk_state`, `walk_turns`, `walk_t`, `walk_depth`,
    `walk_i, walk_j, walk_m`; writes `walk_cell`.
    """
    trying, walking, pausing = 0, 0, 0
    my, mz = table.my, table.mz
    for k in range(first, last):
        i, j, m, t, end = b.walk_i[k], b.walk_j[k], b.walk_m[k], b.walk_t[k], b.walk_end[k]
        state, top, depth, turns = b.walk_state[k], b.walk_top[k], b.walk_depth[k], b.walk_turns[k]
        up_x, up_y, up_z = b.walk_vx[k] >= 0.0, b.walk_vy[k] >= 0.0, b.walk_vz[k] >= 0.0
        # Distance at which the walk leaves its macro cell.
        t_x = (i + (1.0 if up_x else 0.0) - b.walk_px[k]) * b.walk_ix[k]
        t_y = (j + (1.0 if up_y else 0.0) - b.walk_py[k]) * b.walk_iy[k]
        t_z = (m + (1.0 if up_z else 0.0) - b.walk_pz[k]) * b.walk_iz[k]
        leaves = t_y if t_y < t_x else t_x
        leaves = t_z if t_z < leaves else leaves
        stop = leaves if leaves < end else end
        stop = stop if stop > t else t
        spent = top * (stop - t)
        # Tentative collision, end, pause, or on to the next macro cell.
        pauses = (state == FLIES) & (turns >= MOST_TURNS)
        flies, tries = (state == FLIES) & (not pauses), depth < spent
        ends = (not tries) & ((leaves >= end) | (top < 0.0))  # top < 0: beyond the grid
        crosses = flies & (not tries) & (not ends)
        is_x = leaves == t_x
        is_y = (leaves == t_y) & (not is_x)
        is_z = (not is_x) & (not is_y)
        i += (1.0 if up_x else -1.0) if crosses & is_x else 0.0
        j += (1.0 if up_y else -1.0) if crosses & is_y else 0.0
        m += (1.0 if up_z else -1.0) if crosses & is_z else 0.0
        new = TRIES if tries else (ENDED if ends else FLIES)
        new = new if flies else (PAUSED if pauses else state)
        b.walk_i[k], b.walk_j[k], b.walk_m[k] = i, j, m
        b.walk_cell[k] = place_of(i, j, m, my, mz)
        b.walk_t[k] = (t + depth / top if tries else stop) if flies else t
        b.walk_depth[k] = depth - spent if crosses else depth
        b.walk_turns[k] = turns + 1 if flies else turns
        b.walk_state[k] = new
        trying += 1 if new == TRIES else 0
        walking += 1 if new < ENDED else 0
        pausing += 1 if new == PAUSED else 0
    return trying, walking, pausing


@device
def look(b, table, first, last):
    """Find the voxels of tentative collisions, and those whose extinction byte must be read.

    Few need it where extinction hardly varies within a macro cell: below `sure` a collision is real in any
    case.

    Fields: reads `walk_state`, `walk_chance`, `walk_t`, `walk_i, walk_j, walk_m`,
    `walk_px, walk_py, walk_pz`, `walk_vx, walk_vy, walk_vz`, `sure`; writes `voxel`, `open`.
    """
    block = table.block * 1.0
    nx, ny, nz = table.nx * 1.0, table.ny * 1.0, table.nz * 1.0
    for k in range(first, last):
        t = b.walk_t[k]
        x = voxel_along(b.walk_px[k] + t * b.walk_vx[k], b.walk_i[k], block, nx)
        y = voxel_along(b.walk_py[k] + t * b.walk_vy[k], b.walk_j[k], block, ny)
        z = voxel_along(b.walk_pz[k] + t * b.walk_vz[k], b.walk_m[k], block, nz)
        voxel = (x * ny + y) * nz + z
        is_open = 1.0 if (b.walk_state[k] == TRIES) & (b.walk_chance[k] >= b.sure[k]) else 0.0
        b.voxel[k] = int64(voxel)
        b.open[k] = int64(voxel * is_open)


@device
def decide(b, first, last):
    """Accept or reject tentative collisions as far as the quantised extinction of voxels decides.

    Returns the numbers of real, rejected and undecided collisions. The uniform is rescaled within its
    subinterval and reused.

    Fields: reads `sure`, `level`; updates `walk_state`, `walk_chance`.
    """
    real, rejected, unsure = 0, 0, 0
    for k in range(first, last):
        state, chance, sure, level = b.walk_state[k], b.walk_chance[k], b.sure[k], b.level[k] * 1.0
        at, is_sure = chance * LEVELS, chance < sure
        new = COLLIDED if is_sure | (at < level) else (UNSURE if at < level + 1.0 else REJECTED)
        new = new if state == TRIES else state
        low, high = 0.0 if is_sure else sure, sure if is_sure else level * (1.0 / LEVELS)
        fresh = (chance - low) / (high - low)
        fresh = fresh if fresh < BELOW_ONE else BELOW_ONE
        b.walk_chance[k] = fresh if new == COLLIDED else chance
        b.walk_state[k] = new
        real += 1 if new == COLLIDED else 0
        rejected += 1 if new == REJECTED else 0
        unsure += 1 if new == UNSURE else 0
    return real, rejected, unsure


@device
def settle(b, k, extinction):
    """Decide an undecided collision by the extinction itself [1/scene lengths]; returns 1 if it is real.

    Fields: reads `walk_top`, `sure`, `level`; updates `walk_chance`; writes `walk_state`.
    """
    chance, share = b.walk_chance[k], extinction / b.walk_top[k]
    low = b.level[k] * (1.0 / LEVELS)
    low = low if low > b.sure[k] else b.sure[k]
    is_real = chance < share
    fresh = (chance - low) / (share - low)
    fresh = fresh if fresh > 0.0 else 0.0
    b.walk_chance[k] = (fresh if fresh < BELOW_ONE else BELOW_ONE) if is_real else chance
    b.walk_state[k] = COLLIDED if is_real else REJECTED
    return 1 if is_real else 0


@device
def draw_again(b, first, last):
    """Sample a new optical depth and a new uniform for walks whose collision was rejected.

    Fields: reads `walk_history`, `walk_event`; updates `walk_state`, `walk_chance`, `walk_draw`,
    `walk_depth`.
    """
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, last):
        again, drawn = b.walk_state[k] == REJECTED, b.walk_draw[k]
        purpose = uint64(VOXELS) | uint64(drawn) << DRAW
        w0, w1, w2, w3 = event_words(b.walk_history[k], batch, b.walk_event[k], purpose, seed_low, seed_high)
        depth = -log_positive(BELOW_ONE - uniform(w0, w1))
        b.walk_depth[k] = depth if again else b.walk_depth[k]
        b.walk_chance[k] = uniform(w2, w3) if again else b.walk_chance[k]
        b.walk_draw[k] = drawn + (1 if again else 0)
        b.walk_state[k] = FLIES if again else b.walk_state[k]


@device
def end_in_place(b, first, last):
    """End the flights of walks that collided, while each walk is still in the row of its lane.

    Fields: reads `walk_chance`, `walk_t`; updates `distance`, `hit`, `u0`, `walk_state`.
    """
    for k in range(first, last):
        collided = b.walk_state[k] == COLLIDED
        b.distance[k] = b.walk_t[k] + 2.0 * SLACK if collided else b.distance[k]
        b.hit[k] = 0 if collided else b.hit[k]
        b.u0[k] = b.walk_chance[k] if collided else b.u0[k]
        b.walk_state[k] = ENDED if collided else b.walk_state[k]


@device
def list_of(b, state, first, last):
    """List the walks in a state; returns their number.

    Fields: reads `walk_state`.
    """
    count = 0
    for k in range(first, last):  # no branch, so no misprediction
        b.listed[count] = k
        count += 1 if b.walk_state[k] == state else 0
    return count


@device
def end_listed(b, count, cuts):
    """End the flights of listed walks at their current distance: by a collision (cuts 0) or cut (cuts 1).

    Fields: reads `walk_lane`, `walk_chance`, `walk_t`; writes `distance`, `hit`, `u0`, `cut`, `walk_state`.
    """
    for g in range(count):
        k = b.listed[g]
        lane = b.walk_lane[k]
        b.distance[lane], b.hit[lane] = b.walk_t[k] + 2.0 * SLACK, 0
        b.u0[lane], b.cut[lane] = b.walk_chance[k], cuts
        b.walk_state[k] = ENDED


@device
def close_ranks(b, words, first, last, walking):
    """Compact walks: move the last ones into the gaps of ended ones; returns the new end, in full vectors.

    Fields: updates `walk_state`.
    """
    reach = int64(first) + walking
    gaps, movers = 0, 0
    for k in range(first, uint64(reach)):
        b.listed[gaps] = k
        gaps += 1 if b.walk_state[k] == ENDED else 0
    for k in range(uint64(reach), last):
        b.movers[movers] = k
        movers += 1 if b.walk_state[k] != ENDED else 0
    for g in range(gaps):
        here, there = uint64(WALK_WORDS + b.listed[g]), uint64(WALK_WORDS + b.movers[g])
        for f in range(WALK_FIELDS):
            words[here + uint64(f * PITCH)] = words[there + uint64(f * PITCH)]
    full = (reach + 7) // 8 * 8
    full = full if full < int64(last) else int64(last)
    for k in range(uint64(reach), uint64(full)):
        b.walk_state[k] = ENDED
    return uint64(full)
