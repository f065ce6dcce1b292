"""Flights through voxels: delta tracking to the first collision; exact optical depths in absorbing grids.

No random number is drawn between macro cells, and none in empty ones: the exponential law has no memory, so
an optical depth is spent wherever it is spent. For the same reason a long flight may be cut and resumed as a
new one.
"""

import numpy as np
from numba import int64, uint64

from transport.compile.layout import GRID, NO_TABLE, SLACK
from transport.engine.addresses import view
from transport.engine.bundle import PITCH
from transport.engine.collisions import takes_off
from transport.engine.ledger import enter
from transport.engine.passes import lane_pass
from transport.engine.sums import limbs, salt_of
from transport.engine.thinning import is_thin, thinned
from transport.engine.voxels import cell_at, coefficients, grid_depth, pace
from transport.engine.walks import (
    COLLIDED,
    ENDED,
    FLIES,
    PAUSED,
    UNSURE,
    WALK_FIELDS,
    WALK_WORDS,
    close_ranks,
    cross,
    decide,
    draw_again,
    end_in_place,
    end_listed,
    list_of,
    look,
    place_of,
    settle,
)
from transport.physics.elementary import exp_negative
from transport.physics.paths import free_flight


@lane_pass(NO_TABLE)
def fly_in_grids(b, table, first, live):
    """Sample a free path like collisions.fly and keep its optical depth, which grids spend voxel by voxel.

    Fields: reads `weight`, `history`, `start`, `hit`, `mfp`; updates `event`, `distance`; writes `u0`, `u1`,
    `depth`, `flies`.
    """
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        depth, b.u0[k], b.u1[k] = free_flight(b.history[k], batch, b.event[k], seed_low, seed_high)
        flies = takes_off(b.hit[k], b.distance[k], b.weight[k])
        b.depth[k] = depth
        b.distance[k] = b.start[k] + (depth * b.mfp[k] + 2.0 * SLACK) if flies else b.distance[k]
        b.event[k] += 1 if flies else 0
        b.flies[k] = 1 if flies else 0
    return live


@lane_pass(NO_TABLE)
def cut_nothing(b, table, first, live):
    """Clear the mark of cut flights.

    Fields: writes `cut`.
    """
    for k in range(first, live):
        b.cut[k] = 0
    return live


@lane_pass(NO_TABLE)
def pause(b, table, first, live):
    """Revoke the collision of lanes whose flight was cut within voxels.

    Fields: reads `cut`; updates `collides`, `collisions`.
    """
    paused = 0
    for k in range(first, live):
        pauses = (b.cut[k] != 0) & (b.collides[k] != 0)
        b.collides[k] = 0 if pauses else b.collides[k]
        paused += 1 if pauses else 0
    b.collisions -= paused
    return live


@lane_pass(GRID)
def collide_in_grid(b, table, first, live):
    """Find the first real collision in one grid, if it lies before the nearest surface (delta tracking).

    Sets what `collide` needs and, in `survival`, the albedo of the voxel. All flights walk together, in turns
    of two kinds: each moves to the next macro cell; once half of them have reached a tentative collision,
    these are decided.

    Fields: reads `x, y, z`, `ux, uy, uz`, `history`, `event`, `start`, `depth`, `medium`, `flies`; updates
    `distance`, `hit`, `u0`, `voxel`, `open`, `sure`, `level`, all `walk_` fields; writes `survival`, `cut`.
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
        vx, ix = pace(b.ux[k] * per_x)
        vy, iy = pace(b.uy[k] * per_y)
        vz, iz = pace(b.uz[k] * per_z)
        i, j, m = cell_at(px + start * vx, mx), cell_at(py + start * vy, my), cell_at(pz + start * vz, mz)
        b.walk_i[k], b.walk_j[k], b.walk_m[k], b.walk_cell[k] = i, j, m, place_of(i, j, m, my, mz)
        b.walk_px[k], b.walk_py[k], b.walk_pz[k] = px, py, pz
        b.walk_vx[k], b.walk_vy[k], b.walk_vz[k] = vx, vy, vz
        b.walk_ix[k], b.walk_iy[k], b.walk_iz[k] = ix, iy, iz
        b.walk_t[k], b.walk_end[k] = start, b.distance[k] - 2.0 * SLACK
        b.walk_depth[k], b.walk_chance[k] = b.depth[k], b.u0[k]
        b.walk_history[k], b.walk_event[k], b.walk_lane[k] = b.history[k], b.event[k], k
        b.walk_draw[k], b.walk_turns[k], b.walk_state[k] = 0, 0, FLIES if walks else ENDED
        walking += 1 if walks else 0
    last, rejected, is_in_place = live, 0, table.absorbs == 0
    while walking > 0:
        # Compact the walks when a quarter has ended.
        if walking * 4 < (int64(last) - int64(first)) * 3:
            last, is_in_place = close_ranks(b, words, first, last, walking), False
        # New depths after rejected collisions; then cross one macro cell.
        if rejected > 0:
            draw_again(b, first, last)
        rejected = 0
        for k in range(first, last):
            cell = uint64(b.walk_cell[k])
            b.walk_top[k], b.sure[k] = tops[cell], tops[cell + uint64(1)]
        trying, walking, pausing = cross(b, table, first, last)
        if pausing > 0:
            end_listed(b, list_of(b, PAUSED, first, last), 1)
        # Decide tentative collisions: by quantised extinctions, then exactly.
        if trying * 2 >= walking:
            look(b, table, first, last)
            for k in range(first, last):
                b.level[k] = levels[uint64(b.open[k])]
            real, rejected, unsure = decide(b, first, last)
            for g in range(list_of(b, UNSURE, first, last) if unsure > 0 else 0):
                k = b.listed[g]
                scatters, absorbs = coefficients(table, scattering, absorption, b.voxel[k])
                real += settle(b, k, (scatters + absorbs) * table.length)
            rejected, walking = rejected + unsure, walking - real
            # End the flights of real collisions.
            if is_in_place:
                end_in_place(b, first, last)
            else:
                collided = list_of(b, COLLIDED, first, last)
                for g in range(collided if table.absorbs != 0 else 0):
                    k = b.listed[g]
                    scatters, absorbs = coefficients(table, scattering, absorption, b.voxel[k])
                    b.survival[b.walk_lane[k]] = scatters / (scatters + absorbs)
                end_listed(b, collided, 0)
    return live


@lane_pass(GRID)
def attenuate_in_grid(b, table, first, live):
    """Absorb along flights through a grid that only absorbs: weight times the exact exp(-optical depth).

    The ledger takes the difference of the exact sums before and after.

    Fields: reads `x, y, z`, `ux, uy, uz`, `history`, `start`, `distance`, `medium`, `flies`; updates
    `weight`.
    """
    absorption = view(table.absorption, table.absorption_count, np.float64)
    scattering = view(table.scattering, table.scattering_count, np.float64)
    high, low, salt = 0, 0, salt_of(b.seed_low, b.batch)
    for k in range(first, live):
        if b.flies[k] == 0 or b.medium[k] != table.medium or b.weight[k] == 0.0:
            continue
        x, y, z, ux, uy, uz = b.x[k], b.y[k], b.z[k], b.ux[k], b.uy[k], b.uz[k]
        depth = grid_depth(table, absorption, scattering, x, y, z, ux, uy, uz, b.start[k], b.distance[k])
        before = b.weight[k]
        after = (
            thinned(before, depth, salt + b.history[k]) if is_thin(depth) else before * exp_negative(-depth)
        )
        w_high, w_low = limbs(before)
        left_high, left_low = limbs(after)
        high += w_high - left_high
        low += w_low - left_low
        b.weight[k] = after
    enter(b, table.ledger, high, low)
    return live


@lane_pass(NO_TABLE)
def absorb_share(b, table, first, live):
    """Absorb at collisions in grids by weight: multiply by the voxel's albedo (`survival`).

    `high`, `low` receive the absorbed weight as a difference of exact sums.

    Fields: reads `survival`; updates `weight`, `collides`; writes `high`, `low`.
    """
    for k in range(first, live):
        collides, before = b.collides[k] != 0, b.weight[k]
        after = before * b.survival[k] if collides else before
        high, low = limbs(before)
        left_high, left_low = limbs(after)
        b.high[k], b.low[k] = high - left_high, low - left_low
        b.weight[k] = after
        b.collides[k] = 0 if after == 0.0 else b.collides[k]
    return live
