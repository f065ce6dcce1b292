"""Flights through voxels: tentative collisions by local majorants, of which some are real (Woodcock 1965), or exact depths.

A flight has an optical depth to spend.  In each macro cell it spends it at the rate of the largest extinction there; where
it is spent, a tentative collision is real with the chance of the voxel's extinction over that majorant, else the flight goes
on with a new depth.  No draw is made on the way from macro cell to macro cell: the exponential law has no memory.  Macro
cells are left by counting their indices up or down, never by comparing places, so every step makes progress.
"""

import math

import numpy as np
from numba import float64, int64, uint64

from transport.compile.layout import GRID, LEVELS, NO_TABLE, SLACK
from transport.engine.addresses import view
from transport.engine.bundle import CARRIED, CARRIED_WORDS, PITCH, SCRATCH
from transport.engine.passes import lane_pass
from transport.engine.sums import limbs
from transport.physics.device import device
from transport.physics.elementary import exp_negative, log_positive
from transport.physics.streams import LOW32, PATH, VOXELS, event_words, short_uniform, uniform

FLIES, TRIES, UNSURE, ENDED, COLLIDED, PAUSED = range(6)  # what a walk is doing
SLOWEST, NEVER = 1e-280, 1e300  # direction along an axis that never leads out of a cell, and one over it
WALK = [name for name, _ in SCRATCH if name.startswith("walk_")]
WALK_FIELDS = len(WALK)
WALK_WORDS = CARRIED_WORDS + PITCH * [name for name, _ in CARRIED + SCRATCH].index(WALK[0])
DRAW = uint64(8)  # bits of a purpose below the number of the draw
MOST_TURNS = 8  # of a walk, before it pauses: the others shall not wait for long


@lane_pass(NO_TABLE)
def fly_in_grids(b, table, first, live):
    """Draw a free path, as collisions.fly, and keep the optical depth that it is made of: in grids it is spent voxel by voxel."""
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = event_words(b.history[k], batch, b.event[k], PATH, seed_low, seed_high)
        flies = (b.hit[k] == 0) & (b.distance[k] < math.inf) & (b.weight[k] != 0.0)
        depth = -log_positive((1.0 - 2.0**-53) - uniform(w0, w1))
        b.depth[k] = depth
        b.distance[k] = b.start[k] + (depth * b.mfp[k] + 2.0 * SLACK) if flies else b.distance[k]
        b.event[k] += 1 if flies else 0
        b.flies[k] = 1 if flies else 0
        b.u0[k], b.u1[k] = uniform(w2, (w1 << 20) & LOW32), short_uniform(w3)
    return live


@lane_pass(NO_TABLE)
def cut_nothing(b, table, first, live):
    """No flight has been cut."""
    for k in range(first, live):
        b.cut[k] = 0
    return live


@lane_pass(NO_TABLE)
def pause(b, table, first, live):
    """What was cut on its way through voxels has not collided."""
    paused = 0
    for k in range(first, live):
        pauses = (b.cut[k] != 0) & (b.collides[k] != 0)
        b.collides[k] = 0 if pauses else b.collides[k]
        paused += 1 if pauses else 0
    b.collisions -= paused
    return live


@lane_pass(GRID)
def collide_in_grid(b, table, first, live):
    """The first real collision in one grid, where it comes before the surface that was found.

    Leaves what `collide` needs, and in `survival` the albedo of the voxel.  All flights walk together, in turns of two kinds: each
    goes on to the next macro cell; and, once half of them have come to a tentative collision, these are decided.
    """
    tops = view(table.tops, table.top_count, np.float64)
    levels = view(table.levels, table.level_count, np.uint8)
    absorption = view(table.absorption, table.absorption_count, np.float64)
    scattering = view(table.scattering, table.scattering_count, np.float64)
    words = view(b.address, WALK_WORDS + WALK_FIELDS * PITCH, np.int64)
    shrink = 1.0 / float64(table.block)
    per_x, per_y, per_z = table.per_x * shrink, table.per_y * shrink, table.per_z * shrink
    medium, cx, cy, cz = table.medium, table.cx, table.cy, table.cz
    walking = 0
    for k in range(first, live):
        walks = (b.flies[k] != 0) & (b.medium[k] == medium)
        start = b.start[k]
        px, py, pz = (b.x[k] - cx) * per_x, (b.y[k] - cy) * per_y, (b.z[k] - cz) * per_z
        vx, ix = pace(b.ux[k] * per_x)
        vy, iy = pace(b.uy[k] * per_y)
        vz, iz = pace(b.uz[k] * per_z)
        i, j, m = (
            cell_at(px + start * vx, table.mx),
            cell_at(py + start * vy, table.my),
            cell_at(pz + start * vz, table.mz),
        )
        b.walk_i[k], b.walk_j[k], b.walk_m[k] = i, j, m
        b.walk_cell[k] = place_of(i, j, m, table.my, table.mz)
        b.walk_px[k], b.walk_py[k], b.walk_pz[k] = px, py, pz
        b.walk_vx[k], b.walk_vy[k], b.walk_vz[k] = vx, vy, vz
        b.walk_ix[k], b.walk_iy[k], b.walk_iz[k] = ix, iy, iz
        b.walk_t[k], b.walk_end[k], b.walk_depth[k] = start, b.distance[k] - 2.0 * SLACK, b.depth[k]
        b.walk_history[k], b.walk_event[k], b.walk_draw[k], b.walk_lane[k] = b.history[k], b.event[k], 0, k
        b.walk_state[k], b.walk_turns[k] = FLIES if walks else ENDED, 0
        walking += 1 if walks else 0
    last = live
    while walking > 0:
        if walking * 4 < (int64(last) - int64(first)) * 3:
            last = close_ranks(b, words, first, last, walking)
        for k in range(first, last):
            b.walk_top[k] = tops[uint64(b.walk_cell[k])]
        trying, walking, pausing = cross(b, table, first, last)
        if pausing > 0:
            pause_walks(b, first, last)
        if trying * 2 >= walking:
            find_voxels(b, table, first, last)
            for k in range(first, last):
                b.level[k] = levels[uint64(b.voxel[k])]
            walking -= decide(b, table, first, last)
            for k in range(first, last):  # seldom
                if b.walk_state[k] == UNSURE:
                    scatters, absorbs = coefficients(table, scattering, absorption, b.voxel[k])
                    is_real = b.chance[k] * b.walk_top[k] < (scatters + absorbs) * table.length
                    b.walk_state[k] = COLLIDED if is_real else FLIES
                    walking -= 1 if is_real else 0
            collided = 0
            for k in range(first, last):
                b.listed[collided] = k
                collided += 1 if b.walk_state[k] == COLLIDED else 0
            for g in range(collided):
                end_flight(b, b.listed[g])
            if table.absorbs != 0:
                for g in range(collided):
                    k = b.listed[g]
                    scatters, absorbs = coefficients(table, scattering, absorption, b.voxel[k])
                    b.survival[b.walk_lane[k]] = scatters / (scatters + absorbs)
    return live


@device
def coefficients(table, scattering, absorption, voxel):
    """Those of a voxel by its place among the levels [m^-1]."""
    brick, within = voxel >> 6, voxel & 63
    bricks_y, bricks_z = (table.ny + 3) >> 2, (table.nz + 3) >> 2
    row = brick // bricks_z
    x, y, z = (
        4 * (row // bricks_y) + (within >> 4),
        4 * (row % bricks_y) + (within >> 2 & 3),
        4 * (brick % bricks_z) + (within & 3),
    )
    scatters = scattering[x * table.scattering_x + y * table.scattering_y + z * table.scattering_z]
    return scatters, absorption[x * table.absorption_x + y * table.absorption_y + z * table.absorption_z]


@device
def axis_of(p, v, start, block, cells, count):
    """Along one axis, for a ray p + v t in voxels: the cell at `start`, the step to the next one, the face between them, and 1/v."""
    v, inverse = pace(v)
    step = 1 if v >= 0.0 else -1
    cell = int64(cell_at((p + start * v) / block, cells))
    face = (float64(cell) + (1.0 if v >= 0.0 else 0.0)) * block
    return cell, step, face if face < count else count, inverse


@device
def pace(v):
    """Direction along an axis in macro cells per scene length, 0 where it never leaves one that way, and one over it."""
    moves = abs(v) > SLOWEST
    return v if moves else 0.0, 1.0 / v if moves else NEVER


@device
def cell_at(place, count):
    """The macro cell along an axis at a place, kept within the grid."""
    cell = math.floor(place)
    highest = count - 1.0
    cell = cell if cell > 0.0 else 0.0
    return cell if cell < highest else highest


@device
def place_of(i, j, m, my, mz):
    """Where in the table of majorants a macro cell is: it has one more on every side."""
    return int64(((i + 1.0) * (my + 2.0) + (j + 1.0)) * (mz + 2.0) + (m + 1.0))


@device
def cross(b, table, first, last):
    """Each walk to the end of its macro cell, to its tentative collision or to its end; how many try, go on, and pause."""
    trying, walking, pausing = 0, 0, 0
    my, mz = table.my, table.mz
    for k in range(first, last):
        i, j, m, t, end = b.walk_i[k], b.walk_j[k], b.walk_m[k], b.walk_t[k], b.walk_end[k]
        state, top, depth = b.walk_state[k], b.walk_top[k], b.walk_depth[k]
        up_x, up_y, up_z = b.walk_vx[k] >= 0.0, b.walk_vy[k] >= 0.0, b.walk_vz[k] >= 0.0
        t_x = (i + (1.0 if up_x else 0.0) - b.walk_px[k]) * b.walk_ix[k]
        t_y = (j + (1.0 if up_y else 0.0) - b.walk_py[k]) * b.walk_iy[k]
        t_z = (m + (1.0 if up_z else 0.0) - b.walk_pz[k]) * b.walk_iz[k]
        leaves = t_y if t_y < t_x else t_x
        leaves = t_z if t_z < leaves else leaves
        stop = leaves if leaves < end else end
        stop = stop if stop > t else t
        spent = top * (stop - t)
        turns = b.walk_turns[k]
        pauses = (state == FLIES) & (turns >= MOST_TURNS)
        flies, tries = (state == FLIES) & (not pauses), depth < spent
        b.walk_turns[k] = turns + 1 if flies else turns
        ends = (not tries) & ((leaves >= end) | (top < 0.0))
        crosses = flies & (not tries) & (not ends)
        is_x = leaves == t_x
        is_y = (leaves == t_y) & (not is_x)
        is_z = (not is_x) & (not is_y)
        i += (1.0 if up_x else -1.0) if crosses & is_x else 0.0
        j += (1.0 if up_y else -1.0) if crosses & is_y else 0.0
        m += (1.0 if up_z else -1.0) if crosses & is_z else 0.0
        b.walk_i[k], b.walk_j[k], b.walk_m[k] = i, j, m
        b.walk_t[k] = (t + depth / top if tries else stop) if flies else t
        b.walk_depth[k] = depth - spent if crosses else depth
        new = TRIES if tries else (ENDED if ends else FLIES)
        new = new if flies else (PAUSED if pauses else state)
        b.walk_state[k] = new
        b.walk_cell[k] = place_of(i, j, m, my, mz)
        trying += 1 if new == TRIES else 0
        walking += 1 if new < ENDED else 0
        pausing += 1 if pauses else 0
    return trying, walking, pausing


@device
def pause_walks(b, first, last):
    """End the flights of walks that pause where they are."""
    paused = 0
    for k in range(first, last):
        b.listed[paused] = k
        paused += 1 if b.walk_state[k] == PAUSED else 0
    for g in range(paused):
        k = b.listed[g]
        end_flight(b, k)
        b.cut[b.walk_lane[k]] = 1


@device
def end_flight(b, k):
    """The flight of a walk ends where that has come to."""
    lane = b.walk_lane[k]
    b.distance[lane] = b.walk_t[k] + 2.0 * SLACK
    b.hit[lane] = 0
    b.walk_state[k] = ENDED


@device
def voxel_along(place, cell, block, count):
    """The voxel at a place along an axis, kept within its macro cell: so its extinction is never above the majorant."""
    low, high = cell * block, cell * block + (block - 1.0)
    high = high if high < count else count - 1.0
    voxel = math.floor(place * block)
    voxel = voxel if voxel > low else low
    return voxel if voxel < high else high


@device
def find_voxels(b, table, first, last):
    """The numbers of the voxels of tentative collisions."""
    block = float64(table.block)
    nx, ny, nz = float64(table.nx), float64(table.ny), float64(table.nz)
    bricks_y, bricks_z = math.floor((ny + 3.0) * 0.25), math.floor((nz + 3.0) * 0.25)
    for k in range(first, last):
        t, is_there = b.walk_t[k], 1.0 if b.walk_state[k] == TRIES else 0.0
        x = voxel_along(b.walk_px[k] + t * b.walk_vx[k], b.walk_i[k], block, nx)
        y = voxel_along(b.walk_py[k] + t * b.walk_vy[k], b.walk_j[k], block, ny)
        z = voxel_along(b.walk_pz[k] + t * b.walk_vz[k], b.walk_m[k], block, nz)
        at = math.floor(x * 0.25), math.floor(y * 0.25), math.floor(z * 0.25)
        brick = (at[0] * bricks_y + at[1]) * bricks_z + at[2]
        within = ((x - 4.0 * at[0]) * 4.0 + (y - 4.0 * at[1])) * 4.0 + (z - 4.0 * at[2])
        b.voxel[k] = int64((brick * 64.0 + within) * is_there)


@device
def decide(b, table, first, last):
    """Which tentative collisions are real, as far as the levels of their chances tell, and how many; all draw a new depth."""
    seed_low, seed_high, batch, real = b.seed_low, b.seed_high, b.batch, 0
    for k in range(first, last):
        state, draw, level = b.walk_state[k], b.walk_draw[k], float64(b.level[k])
        purpose = uint64(VOXELS) | uint64(draw) << DRAW
        w0, w1, w2, w3 = event_words(b.walk_history[k], batch, b.walk_event[k], purpose, seed_low, seed_high)
        chance = uniform(w2, w3)
        at = chance * LEVELS
        new = COLLIDED if at < level else (UNSURE if at < level + 1.0 else FLIES)
        new = new if state == TRIES else state
        depth = -log_positive((1.0 - 2.0**-53) - uniform(w0, w1))
        b.chance[k] = chance
        b.walk_depth[k] = depth if state == TRIES else b.walk_depth[k]
        b.walk_draw[k] = draw + (1 if state == TRIES else 0)
        b.walk_state[k] = new
        real += 1 if new == COLLIDED else 0
    return real


@device
def close_ranks(b, words, first, last, walking):
    """The last walks move into the gaps that ended ones left; how far they reach then, in full vectors."""
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


@device
def grid_depth(table, absorption, scattering, x, y, z, ux, uy, uz, start, end):
    """Optical depth along a ray from the distance `start` to `end`: exact, voxel by voxel."""
    per_x, per_y, per_z = table.per_x, table.per_y, table.per_z
    px, py, pz = (x - table.cx) * per_x, (y - table.cy) * per_y, (z - table.cz) * per_z
    vx, ix = pace(ux * per_x)
    vy, iy = pace(uy * per_y)
    vz, iz = pace(uz * per_z)
    i, j, m = (
        cell_at(px + start * vx, table.nx),
        cell_at(py + start * vy, table.ny),
        cell_at(pz + start * vz, table.nz),
    )
    up_x, up_y, up_z = 1.0 if vx >= 0.0 else 0.0, 1.0 if vy >= 0.0 else 0.0, 1.0 if vz >= 0.0 else 0.0
    t, depth, going = start, 0.0, True
    while going:
        t_x, t_y, t_z = (i + up_x - px) * ix, (j + up_y - py) * iy, (m + up_z - pz) * iz
        leaves = min(t_x, min(t_y, t_z))
        stop = leaves if leaves < end else end
        here = scattering[int64(i * table.scattering_x + j * table.scattering_y + m * table.scattering_z)]
        here += absorption[int64(i * table.absorption_x + j * table.absorption_y + m * table.absorption_z)]
        depth += here * (stop - t) if stop > t else 0.0
        t = stop if stop > t else t
        going = leaves < end
        if leaves == t_x:
            i += 2.0 * up_x - 1.0
            going &= (i >= 0.0) & (i < table.nx)
        elif leaves == t_y:
            j += 2.0 * up_y - 1.0
            going &= (j >= 0.0) & (j < table.ny)
        else:
            m += 2.0 * up_z - 1.0
            going &= (m >= 0.0) & (m < table.nz)
    return depth * table.length


@lane_pass(GRID)
def attenuate_in_grid(b, table, first, live):
    """A grid that only absorbs lessens weights by the exact transmittance; what is lost is entered as a difference of exact sums."""
    absorption = view(table.absorption, table.absorption_count, np.float64)
    scattering = view(table.scattering, table.scattering_count, np.float64)
    high, low = 0, 0
    for k in range(first, live):
        if b.flies[k] == 0 or b.medium[k] != table.medium or b.weight[k] == 0.0:
            continue
        depth = grid_depth(
            table,
            absorption,
            scattering,
            b.x[k],
            b.y[k],
            b.z[k],
            b.ux[k],
            b.uy[k],
            b.uz[k],
            b.start[k],
            b.distance[k],
        )
        before = b.weight[k]
        after = before * exp_negative(-depth)
        w_high, w_low = limbs(before)
        left_high, left_low = limbs(after)
        high += w_high - left_high
        low += w_low - left_low
        b.weight[k] = after
    row = 4 * table.ledger
    ledger = view(b.ledger, b.ledger_words, np.int64)
    ledger[row] += high
    ledger[row + 1] += low
    return live


@lane_pass(NO_TABLE)
def absorb_share(b, table, first, live):
    """At a collision in a grid the weight is lessened by the voxel's albedo; what is lost, as a difference of exact sums, is the medium's."""
    for k in range(first, live):
        collides, before = b.collides[k] != 0, b.weight[k]
        after = before * b.survival[k] if collides else before
        high, low = limbs(before)
        left_high, left_low = limbs(after)
        b.high[k], b.low[k] = high - left_high, low - left_low
        b.weight[k] = after
        b.collides[k] = 0 if after == 0.0 else b.collides[k]
    return live
