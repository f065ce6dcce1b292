"""Rays through voxels: cells along each axis, coefficients of a voxel, exact optical depth."""

import math

import numpy as np
from numba import float64, int64, uint64

from transport.compile import layout
from transport.compile.layout import COLLISION_CLEARANCE, LEVELS
from transport.engine.bodies import bundle_pass, lane_pass
from transport.engine.bundle import CARRIED, CARRIED_WORDS, PITCH, SCRATCH, view
from transport.engine.passes.collisions import attenuated, is_flying
from transport.engine.tally import add_to_ledger, hash_salt, limbs_of_loss
from transport.physics.device import device
from transport.physics.elementary import log_positive
from transport.physics.paths import free_flight
from transport.physics.streams import VOXELS, event_words, uniform

# a ray with a direction component below MIN_COMPONENT never leaves a cell; NO_CROSSING is its reciprocal
MIN_COMPONENT, NO_CROSSING = 1e-280, 1e300


@device
def component_and_reciprocal(v):
    """Return a direction component in cells per scene length and its reciprocal.

    The component is 0, and the reciprocal NO_CROSSING, if the ray never leaves a cell along this axis.
    """
    moves = abs(v) > MIN_COMPONENT
    return v if moves else 0.0, 1.0 / v if moves else NO_CROSSING


@device
def cell_at(place, count):
    """Return the cell that holds a coordinate, clamped to the grid."""
    cell = math.floor(place)
    highest = count - 1.0
    cell = cell if cell > 0.0 else 0.0
    return cell if cell < highest else highest


@device
def axis_start(p, v, start, block, cells, count):
    """Return for one axis of a ray p + v t in voxels: cell at `start`, its step, the face ahead, 1/v."""
    v, inverse = component_and_reciprocal(v)
    step = 1 if v >= 0.0 else -1
    cell = int64(cell_at((p + start * v) / block, cells))
    face = (float64(cell) + (1.0 if v >= 0.0 else 0.0)) * block
    return cell, step, face if face < count else count, inverse


@device
def voxel_along(place, cell, block, count):
    """Return the voxel at a coordinate, clamped to its macro cell.

    So its extinction never exceeds the majorant.
    """
    low, high = cell * block, cell * block + (block - 1.0)
    high = high if high < count else count - 1.0
    voxel = math.floor(place * block)
    voxel = voxel if voxel > low else low
    return voxel if voxel < high else high


@device
def coefficients(table, scattering, absorption, voxel):
    """Return scattering and absorption coefficient [m^-1] of a voxel by its number."""
    column, z = voxel // table.nz, voxel % table.nz
    x, y = column // table.ny, column % table.ny
    scatters = scattering[x * table.scattering_x + y * table.scattering_y + z * table.scattering_z]
    return scatters, absorption[x * table.absorption_x + y * table.absorption_y + z * table.absorption_z]


@device
def grid_depth(table, absorption, scattering, x, y, z, ux, uy, uz, start, end):
    """Return the optical depth along a ray from `start` to `end`, voxel by voxel (Amanatides, Woo 1987).

    A shadow ray needs exp(-depth). The exact depth has no variance, unlike ratio tracking (Novak et al.
    2014), and is cheaper in voxels.
    """
    per_x, per_y, per_z = table.per_x, table.per_y, table.per_z
    px, py, pz = (x - table.cx) * per_x, (y - table.cy) * per_y, (z - table.cz) * per_z
    vx, ix = component_and_reciprocal(ux * per_x)
    vy, iy = component_and_reciprocal(uy * per_y)
    vz, iz = component_and_reciprocal(uz * per_z)
    i, j = cell_at(px + start * vx, table.nx), cell_at(py + start * vy, table.ny)
    m = cell_at(pz + start * vz, table.nz)
    up_x, up_y, up_z = 1.0 if vx >= 0.0 else 0.0, 1.0 if vy >= 0.0 else 0.0, 1.0 if vz >= 0.0 else 0.0
    # Add extinction times length in each voxel, then step across the nearest face.
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


# ---- Delta tracking through voxels (Woodcock 1965): walks of one grid, compacted in rows of their own.
#
# A walk spends an optical depth. In each macro cell it spends it at the rate of the majorant, the largest
# extinction there; where it is spent, a tentative collision is real with probability extinction of the voxel
# over majorant, else the walk continues with a new depth. Macro cells are left by incrementing indices, never
# by comparing positions, so every turn makes progress. These are loops over walks for
# `voxels.delta_track_in_grid`.

FLYING, TENTATIVE, UNDECIDED, REJECTED, ENDED, COLLIDED, PAUSED = range(7)  # states of a walk
WALK = [name for name, _ in SCRATCH if name.startswith("walk_")]
WALK_FIELDS = len(WALK)
WALK_WORDS = CARRIED_WORDS + PITCH * [name for name, _ in CARRIED + SCRATCH].index(WALK[0])
DRAW_SHIFT = uint64(8)  # bits of a purpose below the number of the draw
MAX_TURNS = 8  # turns before a walk pauses, so that the others do not wait for long
BELOW_ONE = 1.0 - 2.0**-53


@device
def majorant_index(i, j, m, my, mz):
    """Return the index of a macro cell in the table of majorants.

    The table has two numbers per cell, and one more cell on every side.
    """
    return int64(2.0 * (((i + 1.0) * (my + 2.0) + (j + 1.0)) * (mz + 2.0) + (m + 1.0)))


@device
def cross_macro_cells(b, table, first, last):
    """Move each walk to the end of its macro cell, to its tentative collision or to its end.

    Returns the numbers of walks that try a collision, that go on (or try), and that pause.

    Fields: reads `walk_end`, `walk_majorant`, `walk_px, walk_py, walk_pz`, `walk_vx, walk_vy, walk_vz`,
    `walk_ix, walk_iy, walk_iz`; updates `walk_state`, `walk_turns`, `walk_t`, `walk_depth`,
    `walk_i, walk_j, walk_m`; writes `walk_cell`.
    """
    trying, walking, pausing = 0, 0, 0
    my, mz = table.my, table.mz
    for k in range(first, last):
        i, j, m, t, end = b.walk_i[k], b.walk_j[k], b.walk_m[k], b.walk_t[k], b.walk_end[k]
        state, top, depth, turns = b.walk_state[k], b.walk_majorant[k], b.walk_depth[k], b.walk_turns[k]
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
        pauses = (state == FLYING) & (turns >= MAX_TURNS)
        flies, tries = (state == FLYING) & (not pauses), depth < spent
        ends = (not tries) & ((leaves >= end) | (top < 0.0))  # top < 0: beyond the grid
        crosses = flies & (not tries) & (not ends)
        is_x = leaves == t_x
        is_y = (leaves == t_y) & (not is_x)
        is_z = (not is_x) & (not is_y)
        i += (1.0 if up_x else -1.0) if crosses & is_x else 0.0
        j += (1.0 if up_y else -1.0) if crosses & is_y else 0.0
        m += (1.0 if up_z else -1.0) if crosses & is_z else 0.0
        new = TENTATIVE if tries else (ENDED if ends else FLYING)
        new = new if flies else (PAUSED if pauses else state)
        b.walk_i[k], b.walk_j[k], b.walk_m[k] = i, j, m
        b.walk_cell[k] = majorant_index(i, j, m, my, mz)
        b.walk_t[k] = (t + depth / top if tries else stop) if flies else t
        b.walk_depth[k] = depth - spent if crosses else depth
        b.walk_turns[k] = turns + 1 if flies else turns
        b.walk_state[k] = new
        trying += 1 if new == TENTATIVE else 0
        walking += 1 if new < ENDED else 0
        pausing += 1 if new == PAUSED else 0
    return trying, walking, pausing


@device
def find_voxels(b, table, first, last):
    """Find the voxels of tentative collisions, and those whose extinction byte must be read.

    Few need it where extinction hardly varies within a macro cell: below `sure` a collision is real in any
    case.

    Fields: reads `walk_state`, `walk_uniform`, `walk_t`, `walk_i, walk_j, walk_m`,
    `walk_px, walk_py, walk_pz`, `walk_vx, walk_vy, walk_vz`, `sure_probability`; writes `voxel`,
    `lookup_voxel`.
    """
    block = table.block * 1.0
    nx, ny, nz = table.nx * 1.0, table.ny * 1.0, table.nz * 1.0
    for k in range(first, last):
        t = b.walk_t[k]
        x = voxel_along(b.walk_px[k] + t * b.walk_vx[k], b.walk_i[k], block, nx)
        y = voxel_along(b.walk_py[k] + t * b.walk_vy[k], b.walk_j[k], block, ny)
        z = voxel_along(b.walk_pz[k] + t * b.walk_vz[k], b.walk_m[k], block, nz)
        voxel = (x * ny + y) * nz + z
        is_open = (b.walk_state[k] == TENTATIVE) & (b.walk_uniform[k] >= b.sure_probability[k])
        b.voxel[k] = int64(voxel)
        b.lookup_voxel[k] = int64(voxel * (1.0 if is_open else 0.0))


@device
def accept_by_levels(b, first, last):
    """Accept or reject tentative collisions as far as the quantised extinction of voxels decides.

    Returns the numbers of real, rejected and undecided collisions. The uniform is rescaled within its
    subinterval and reused.

    Fields: reads `sure_probability`, `level`; updates `walk_state`, `walk_uniform`.
    """
    real, rejected, unsure = 0, 0, 0
    for k in range(first, last):
        state, chance, sure = b.walk_state[k], b.walk_uniform[k], b.sure_probability[k]
        level = b.level[k] * 1.0
        at, is_sure = chance * LEVELS, chance < sure
        new = COLLIDED if is_sure | (at < level) else (UNDECIDED if at < level + 1.0 else REJECTED)
        new = new if state == TENTATIVE else state
        low, high = 0.0 if is_sure else sure, sure if is_sure else level * (1.0 / LEVELS)
        fresh = (chance - low) / (high - low)
        fresh = fresh if fresh < BELOW_ONE else BELOW_ONE
        b.walk_uniform[k] = fresh if new == COLLIDED else chance
        b.walk_state[k] = new
        real += 1 if new == COLLIDED else 0
        rejected += 1 if new == REJECTED else 0
        unsure += 1 if new == UNDECIDED else 0
    return real, rejected, unsure


@device
def accept_exactly(b, k, extinction):
    """Decide an undecided collision by the extinction itself [1/scene lengths]; returns 1 if it is real.

    Fields: reads `walk_majorant`, `sure_probability`, `level`; updates `walk_uniform`; writes `walk_state`.
    """
    chance, share = b.walk_uniform[k], extinction / b.walk_majorant[k]
    low = b.level[k] * (1.0 / LEVELS)
    low = low if low > b.sure_probability[k] else b.sure_probability[k]
    is_real = chance < share
    fresh = (chance - low) / (share - low)
    fresh = fresh if fresh > 0.0 else 0.0
    b.walk_uniform[k] = (fresh if fresh < BELOW_ONE else BELOW_ONE) if is_real else chance
    b.walk_state[k] = COLLIDED if is_real else REJECTED
    return 1 if is_real else 0


@device
def resample_rejected(b, first, last):
    """Sample a new optical depth and a new uniform for walks whose collision was rejected.

    Fields: reads `walk_history`, `walk_event`; updates `walk_state`, `walk_uniform`, `walk_draw`,
    `walk_depth`.
    """
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, last):
        again, drawn = b.walk_state[k] == REJECTED, b.walk_draw[k]
        purpose = uint64(VOXELS) | uint64(drawn) << DRAW_SHIFT
        w0, w1, w2, w3 = event_words(b.walk_history[k], batch, b.walk_event[k], purpose, seed_low, seed_high)
        depth = -log_positive(BELOW_ONE - uniform(w0, w1))
        b.walk_depth[k] = depth if again else b.walk_depth[k]
        b.walk_uniform[k] = uniform(w2, w3) if again else b.walk_uniform[k]
        b.walk_draw[k] = drawn + (1 if again else 0)
        b.walk_state[k] = FLYING if again else b.walk_state[k]


@device
def end_collided_flights(b, first, last):
    """End the flights of walks that collided, while each walk is still in the row of its lane.

    Fields: reads `walk_uniform`, `walk_t`; updates `distance`, `hit`, `u0`, `walk_state`.
    """
    for k in range(first, last):
        collided = b.walk_state[k] == COLLIDED
        b.distance[k] = b.walk_t[k] + 2.0 * COLLISION_CLEARANCE if collided else b.distance[k]
        b.hit[k] = 0 if collided else b.hit[k]
        b.u0[k] = b.walk_uniform[k] if collided else b.u0[k]
        b.walk_state[k] = ENDED if collided else b.walk_state[k]


@device
def list_walks(b, state, first, last):
    """List the walks in a state; returns their number.

    Fields: reads `walk_state`.
    """
    count = 0
    for k in range(first, last):  # no branch, so no misprediction
        b.listed[count] = k
        count += 1 if b.walk_state[k] == state else 0
    return count


@device
def end_listed_flights(b, count, cuts):
    """End the flights of listed walks at their current distance: by a collision (cuts 0) or cut (cuts 1).

    Fields: reads `walk_lane`, `walk_uniform`, `walk_t`; writes `distance`, `hit`, `u0`, `cut`, `walk_state`.
    """
    for g in range(count):
        k = b.listed[g]
        lane = b.walk_lane[k]
        b.distance[lane], b.hit[lane] = b.walk_t[k] + 2.0 * COLLISION_CLEARANCE, 0
        b.u0[lane], b.cut[lane] = b.walk_uniform[k], cuts
        b.walk_state[k] = ENDED


@device
def compact_walks(b, words, first, last, walking):
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


# ---- Flights through voxels: delta tracking to the first collision; exact optical depths in absorbing grids.
#
# No random number is drawn between macro cells, and none in empty ones: the exponential law has no memory, so
# an optical depth is spent wherever it is spent. For the same reason a long flight may be cut and resumed as
# a new one.


@lane_pass(layout.NO_TABLE)
def sample_path_in_grids(lane, table):
    """Sample a free path like collisions.sample_free_path and keep its optical depth.

    Grids spend that depth voxel by voxel.
    """
    seed_low, seed_high, batch = lane.seed_low, lane.seed_high, lane.batch
    depth, lane.u0, lane.u1 = free_flight(lane.history, batch, lane.event, seed_low, seed_high)
    flies = is_flying(lane.hit, lane.distance, lane.weight)
    lane.depth = depth
    end = lane.start + (depth * lane.mfp + 2.0 * COLLISION_CLEARANCE)
    lane.distance = end if flies else lane.distance
    lane.event += 1 if flies else 0
    lane.flies = 1 if flies else 0


@lane_pass(layout.NO_TABLE)
def reset_cuts(lane, table):
    """Clear the mark of cut flights."""
    lane.cut = 0


@device
def revoke_collisions(lane, table, paused):
    """Take collisions off their count."""
    lane.collisions -= paused


@lane_pass(layout.NO_TABLE, sums=revoke_collisions)
def revoke_cut_collisions(lane, table):
    """Revoke the collision of lanes whose flight was cut within voxels."""
    pauses = (lane.cut != 0) & (lane.collides != 0)
    lane.collides = 0 if pauses else lane.collides
    return 1 if pauses else 0


@bundle_pass(layout.GRID)
def delta_track_in_grid(b, table, first, live):
    """Find the first real collision in one grid, if it lies before the nearest surface (delta tracking).

    Sets what `collide` needs and, in `survival`, the albedo of the voxel. All flights walk together, in turns
    of two kinds: each moves to the next macro cell; once half of them have reached a tentative collision,
    these are decided.

    Fields: reads `x, y, z`, `ux, uy, uz`, `history`, `event`, `start`, `depth`, `medium`, `flies`; updates
    `distance`, `hit`, `u0`, `voxel`, `lookup_voxel`, `sure_probability`, `level`, all `walk_` fields; writes
    `survival`, `cut`.
    """
    tops = view(table.tops, table.top_count, np.float64)
    levels = view(table.levels, table.level_count, np.uint8)
    absorption = view(table.absorption, table.absorption_count, np.float64)
    scattering = view(table.scattering, table.scattering_count, np.float64)
    words = view(b.address, WALK_WORDS + WALK_FIELDS * PITCH, np.int64)
    shrink = 1.0 / (table.block * 1.0)
    per_x, per_y, per_z = table.per_x * shrink, table.per_y * shrink, table.per_z * shrink
    medium, cx, cy, cz = table.medium, table.cx, table.cy, table.cz
    mx, my, mz = table.mx, table.my, table.mz
    # Start a walk for each lane that flies in this grid, in units of macro cells.
    walking = 0
    for k in range(first, live):
        walks, start = (b.flies[k] != 0) & (b.medium[k] == medium), b.start[k]
        px, py, pz = (b.x[k] - cx) * per_x, (b.y[k] - cy) * per_y, (b.z[k] - cz) * per_z
        vx, ix = component_and_reciprocal(b.ux[k] * per_x)
        vy, iy = component_and_reciprocal(b.uy[k] * per_y)
        vz, iz = component_and_reciprocal(b.uz[k] * per_z)
        i, j, m = cell_at(px + start * vx, mx), cell_at(py + start * vy, my), cell_at(pz + start * vz, mz)
        b.walk_i[k], b.walk_j[k], b.walk_m[k], b.walk_cell[k] = i, j, m, majorant_index(i, j, m, my, mz)
        b.walk_px[k], b.walk_py[k], b.walk_pz[k] = px, py, pz
        b.walk_vx[k], b.walk_vy[k], b.walk_vz[k] = vx, vy, vz
        b.walk_ix[k], b.walk_iy[k], b.walk_iz[k] = ix, iy, iz
        b.walk_t[k], b.walk_end[k] = start, b.distance[k] - 2.0 * COLLISION_CLEARANCE
        b.walk_depth[k], b.walk_uniform[k] = b.depth[k], b.u0[k]
        b.walk_history[k], b.walk_event[k], b.walk_lane[k] = b.history[k], b.event[k], k
        b.walk_draw[k], b.walk_turns[k], b.walk_state[k] = 0, 0, FLYING if walks else ENDED
        walking += 1 if walks else 0
    last, rejected, is_in_place = live, 0, table.absorbs == 0
    while walking > 0:
        # Compact the walks when a quarter has ended.
        if walking * 4 < (int64(last) - int64(first)) * 3:
            last, is_in_place = compact_walks(b, words, first, last, walking), False
        # New depths after rejected collisions; then cross one macro cell.
        if rejected > 0:
            resample_rejected(b, first, last)
        rejected = 0
        for k in range(first, last):
            cell = uint64(b.walk_cell[k])
            b.walk_majorant[k], b.sure_probability[k] = tops[cell], tops[cell + uint64(1)]
        trying, walking, pausing = cross_macro_cells(b, table, first, last)
        if pausing > 0:
            end_listed_flights(b, list_walks(b, PAUSED, first, last), 1)
        # Decide tentative collisions: by quantised extinctions, then exactly.
        if trying * 2 >= walking:
            find_voxels(b, table, first, last)
            for k in range(first, last):
                b.level[k] = levels[uint64(b.lookup_voxel[k])]
            real, rejected, unsure = accept_by_levels(b, first, last)
            for g in range(list_walks(b, UNDECIDED, first, last) if unsure > 0 else 0):
                k = b.listed[g]
                scatters, absorbs = coefficients(table, scattering, absorption, b.voxel[k])
                real += accept_exactly(b, k, (scatters + absorbs) * table.length)
            rejected, walking = rejected + unsure, walking - real
            # End the flights of real collisions.
            if is_in_place:
                end_collided_flights(b, first, last)
            else:
                collided = list_walks(b, COLLIDED, first, last)
                for g in range(collided if table.absorbs != 0 else 0):
                    k = b.listed[g]
                    scatters, absorbs = coefficients(table, scattering, absorption, b.voxel[k])
                    b.survival[b.walk_lane[k]] = scatters / (scatters + absorbs)
                end_listed_flights(b, collided, 0)
    return live


@device
def add_to_grid(lane, table, high, low):
    """Add to the grid's row of the ledger."""
    add_to_ledger(lane, table.ledger, high, low)


@lane_pass(layout.GRID, sums=add_to_grid)
def attenuate_in_grid(lane, table):
    """Absorb along flights through a grid that only absorbs: weight times the exact exp(-optical depth).

    The ledger takes the difference of the exact sums before and after.
    """
    if lane.flies == 0 or lane.medium != table.medium or lane.weight == 0.0:
        return 0, 0
    absorption = view(table.absorption, table.absorption_count, np.float64)
    scattering = view(table.scattering, table.scattering_count, np.float64)
    x, y, z, ux, uy, uz = lane.x, lane.y, lane.z, lane.ux, lane.uy, lane.uz
    depth = grid_depth(table, absorption, scattering, x, y, z, ux, uy, uz, lane.start, lane.distance)
    before = lane.weight
    lane.weight = attenuated(before, depth, hash_salt(lane.seed_low, lane.batch) + lane.history)
    return limbs_of_loss(before, lane.weight)


@lane_pass(layout.NO_TABLE)
def absorb_by_albedo(lane, table):
    """Absorb at collisions in grids by weight: multiply by the voxel's albedo (`survival`).

    `high`, `low` receive the absorbed weight as a difference of exact sums.
    """
    collides, before = lane.collides != 0, lane.weight
    after = before * lane.survival if collides else before
    lane.high, lane.low = limbs_of_loss(before, after)
    lane.weight = after
    lane.collides = 0 if after == 0.0 else lane.collides
