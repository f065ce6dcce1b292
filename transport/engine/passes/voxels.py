"""Rays through voxels: cells along each axis, coefficients of a voxel, exact optical depth."""

import math

import numpy as np
from numba import int64, uint64

from transport.compile import layout
from transport.compile.layout import COLLISION_CLEARANCE, LEVELS
from transport.engine.bodies import bundle_pass, lane_at, lane_pass
from transport.engine.bundle import CARRIED, CARRIED_WORDS, PITCH, SCRATCH, view
from transport.engine.passes.collisions import attenuated, revoke_collisions
from transport.engine.tally import hash_salt, limbs_of_loss, to_row_of_table
from transport.physics.cells import (
    component_and_reciprocal,
    enter_cells,
    nearest_face,
    next_cell,
    number_along,
)
from transport.physics.device import choose, device
from transport.physics.elementary import log_positive
from transport.physics.paths import free_depth
from transport.physics.streams import VOXELS, event_words, uniform


@device
def cell_at(place, count):
    """Return the cell that holds a coordinate, clamped to the grid."""
    cell = math.floor(place)
    highest = count - 1.0
    cell = cell if cell > 0.0 else 0.0
    return cell if cell < highest else highest


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
def scattering_at(lane, table, voxel):
    """Return the scattering coefficient [m^-1] of a voxel by its number."""
    values = view(lane.arena + table.scattering, table.scattering_count, np.float64)
    return values[voxel * table.scattering_stride]


@device
def absorption_at(lane, table, voxel):
    """Return the absorption coefficient [m^-1] of a voxel by its number."""
    values = view(lane.arena + table.absorption, table.absorption_count, np.float64)
    return values[voxel * table.absorption_stride]


@device
def voxel_at(table, x, y, z):
    """Return the number of the voxel that holds a point, clamped to the grid."""
    i = number_along(x - table.cx, table.per_x, table.nx)
    j = number_along(y - table.cy, table.per_y, table.ny)
    return (i * table.ny + j) * table.nz + number_along(z - table.cz, table.per_z, table.nz)


@device
def enter_grid(lane, table):
    """Start a walk through the voxels along a lane's ray, in units of voxels (physics/cells.py)."""
    per_x, per_y, per_z = table.per_x, table.per_y, table.per_z
    place = ((lane.x - table.cx) * per_x, (lane.y - table.cy) * per_y, (lane.z - table.cz) * per_z)
    direction, one = (lane.ux * per_x, lane.uy * per_y, lane.uz * per_z), (1.0, 1.0, 1.0)
    return enter_cells(place, direction, lane.start, one, one, (table.nx, table.ny, table.nz))


@device
def grid_depth(lane, table):
    """Return the optical depth along a lane's flight, voxel by voxel.

    A shadow ray needs exp(-depth). The exact depth has no variance, unlike ratio tracking (Novak et al.
    2014), and is cheaper in voxels.
    """
    axes, cell, faces = enter_grid(lane, table)
    t, end, depth, going = lane.start, lane.distance, 0.0, True
    while going:
        face = nearest_face(faces)
        going = face < end
        stop = face if going else end
        here = scattering_at(lane, table, cell[0]) + absorption_at(lane, table, cell[0])
        depth += here * (stop - t) if stop > t else 0.0
        t = stop if stop > t else t
        if going:
            cell, faces = next_cell(axes, cell, faces)
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
def start_walk(lane, table):
    """Start a walk, in units of macro cells, if the lane flies in this grid; returns 1 if it does."""
    shrink = 1.0 / (table.block * 1.0)
    per_x, per_y, per_z = table.per_x * shrink, table.per_y * shrink, table.per_z * shrink
    mx, my, mz = table.mx, table.my, table.mz
    walks, start = (lane.weight != 0.0) & (lane.medium == table.medium), lane.start
    px, py, pz = (lane.x - table.cx) * per_x, (lane.y - table.cy) * per_y, (lane.z - table.cz) * per_z
    vx, ix = component_and_reciprocal(lane.ux * per_x)
    vy, iy = component_and_reciprocal(lane.uy * per_y)
    vz, iz = component_and_reciprocal(lane.uz * per_z)
    i, j, m = cell_at(px + start * vx, mx), cell_at(py + start * vy, my), cell_at(pz + start * vz, mz)
    lane.walk_i, lane.walk_j, lane.walk_m, lane.walk_cell = i, j, m, majorant_index(i, j, m, my, mz)
    lane.walk_px, lane.walk_py, lane.walk_pz = px, py, pz
    lane.walk_vx, lane.walk_vy, lane.walk_vz = vx, vy, vz
    lane.walk_ix, lane.walk_iy, lane.walk_iz = ix, iy, iz
    lane.walk_t, lane.walk_end = start, lane.distance - 2.0 * COLLISION_CLEARANCE
    lane.walk_depth, lane.walk_uniform = lane.depth, lane.u0
    lane.walk_history, lane.walk_event, lane.walk_lane = lane.history, lane.event, lane.number
    lane.walk_draw, lane.walk_turns, lane.walk_state = 0, 0, FLYING if walks else ENDED
    return 1 if walks else 0


@device
def look_up_majorant(lane, tops):
    """Look up the majorant of the macro cell, and the least share of collisions that are real there."""
    cell = uint64(lane.walk_cell)
    lane.walk_majorant, lane.sure_probability = tops[cell], tops[cell + uint64(1)]


@device
def cross_macro_cell(lane, table):
    """Move a walk to the end of its macro cell, to its tentative collision or to its end.

    Returns three numbers, 0 or 1: does it try a collision, does it go on (or try), does it pause.
    """
    my, mz = table.my, table.mz
    i, j, m, t, end = lane.walk_i, lane.walk_j, lane.walk_m, lane.walk_t, lane.walk_end
    state, top, depth, turns = lane.walk_state, lane.walk_majorant, lane.walk_depth, lane.walk_turns
    up_x, up_y, up_z = lane.walk_vx >= 0.0, lane.walk_vy >= 0.0, lane.walk_vz >= 0.0
    # Distance at which the walk leaves its macro cell.
    t_x = (i + (1.0 if up_x else 0.0) - lane.walk_px) * lane.walk_ix
    t_y = (j + (1.0 if up_y else 0.0) - lane.walk_py) * lane.walk_iy
    t_z = (m + (1.0 if up_z else 0.0) - lane.walk_pz) * lane.walk_iz
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
    lane.walk_i, lane.walk_j, lane.walk_m = i, j, m
    lane.walk_cell = majorant_index(i, j, m, my, mz)
    lane.walk_t = (t + depth / top if tries else stop) if flies else t
    lane.walk_depth = depth - spent if crosses else depth
    lane.walk_turns = turns + 1 if flies else turns
    lane.walk_state = new
    return 1 if new == TENTATIVE else 0, 1 if new < ENDED else 0, 1 if new == PAUSED else 0


@device
def find_voxel(lane, table):
    """Find the voxel of a tentative collision, and whether its extinction byte must be read.

    Few need it where extinction hardly varies within a macro cell: below `sure` a collision is real in any
    case.
    """
    block = table.block * 1.0
    nx, ny, nz, t = table.nx * 1.0, table.ny * 1.0, table.nz * 1.0, lane.walk_t
    x = voxel_along(lane.walk_px + t * lane.walk_vx, lane.walk_i, block, nx)
    y = voxel_along(lane.walk_py + t * lane.walk_vy, lane.walk_j, block, ny)
    z = voxel_along(lane.walk_pz + t * lane.walk_vz, lane.walk_m, block, nz)
    voxel = (x * ny + y) * nz + z
    is_open = (lane.walk_state == TENTATIVE) & (lane.walk_uniform >= lane.sure_probability)
    lane.voxel = int64(voxel)
    lane.lookup_voxel = int64(voxel * (1.0 if is_open else 0.0))


@device
def accept_by_level(lane):
    """Accept or reject a tentative collision as far as the quantised extinction of its voxel decides.

    Returns three numbers, 0 or 1: is it real, is it rejected, is it undecided. The uniform is rescaled within
    its subinterval and reused.
    """
    state, chance, sure = lane.walk_state, lane.walk_uniform, lane.sure_probability
    level = lane.level * 1.0
    at, is_sure = chance * LEVELS, chance < sure
    new = COLLIDED if is_sure | (at < level) else (UNDECIDED if at < level + 1.0 else REJECTED)
    new = new if state == TENTATIVE else state
    low, high = 0.0 if is_sure else sure, sure if is_sure else level * (1.0 / LEVELS)
    fresh = (chance - low) / (high - low)
    fresh = fresh if fresh < BELOW_ONE else BELOW_ONE
    lane.walk_uniform = fresh if new == COLLIDED else chance
    lane.walk_state = new
    return 1 if new == COLLIDED else 0, 1 if new == REJECTED else 0, 1 if new == UNDECIDED else 0


@device
def accept_exactly(lane, extinction):
    """Decide an undecided collision by the extinction itself [1/scene lengths]; returns 1 if it is real."""
    chance, share = lane.walk_uniform, extinction / lane.walk_majorant
    low = lane.level * (1.0 / LEVELS)
    low = low if low > lane.sure_probability else lane.sure_probability
    is_real = chance < share
    fresh = (chance - low) / (share - low)
    fresh = fresh if fresh > 0.0 else 0.0
    lane.walk_uniform = (fresh if fresh < BELOW_ONE else BELOW_ONE) if is_real else chance
    lane.walk_state = COLLIDED if is_real else REJECTED
    return 1 if is_real else 0


@device
def resample_rejected(lane):
    """Sample a new optical depth and a new uniform for a walk whose collision was rejected."""
    again, drawn = lane.walk_state == REJECTED, lane.walk_draw
    purpose = uint64(VOXELS) | uint64(drawn) << DRAW_SHIFT
    w0, w1, w2, w3 = event_words(
        lane.walk_history, lane.batch, lane.walk_event, purpose, lane.seed_low, lane.seed_high
    )
    depth = -log_positive(BELOW_ONE - uniform(w0, w1))
    lane.walk_depth = choose(again, depth, lane.walk_depth)
    lane.walk_uniform = choose(again, uniform(w2, w3), lane.walk_uniform)
    lane.walk_draw = drawn + (1 if again else 0)
    lane.walk_state = choose(again, FLYING, lane.walk_state)


@device
def end_collided_flight(lane):
    """End the flight of a walk that collided and is still in the row of its lane."""
    collided = lane.walk_state == COLLIDED
    lane.distance = choose(collided, lane.walk_t + 2.0 * COLLISION_CLEARANCE, lane.distance)
    lane.hit = choose(collided, 0, lane.hit)
    lane.covered = choose(collided, 0, lane.covered)
    lane.u0 = choose(collided, lane.walk_uniform, lane.u0)
    lane.walk_state = choose(collided, ENDED, lane.walk_state)


@device
def end_flight(lane, walk, cuts):
    """End a lane's flight at its walk's current distance: by a collision (cuts 0) or cut (cuts 1)."""
    lane.distance, lane.hit, lane.covered = walk.walk_t + 2.0 * COLLISION_CLEARANCE, 0, 0
    lane.u0, lane.cut = walk.walk_uniform, cuts
    walk.walk_state = ENDED


@device
def list_walks(lanes, state, first, last):
    """List the walks in a state; returns their number."""
    count = 0
    for k in range(first, last):  # no branch, so no misprediction
        lane_at(lanes, uint64(count)).listed = k
        count += 1 if lane_at(lanes, k).walk_state == state else 0
    return count


@device
def end_listed_flights(lanes, count, cuts):
    """End the flights of listed walks, by collisions (cuts 0) or cut (cuts 1)."""
    for g in range(uint64(count)):
        walk = lane_at(lanes, uint64(lane_at(lanes, g).listed))
        end_flight(lane_at(lanes, uint64(walk.walk_lane)), walk, cuts)


@device
def compact_walks(lanes, first, last, walking):
    """Compact walks: move the last ones into the gaps of ended ones; returns the new end, in full vectors."""
    words = view(lanes.address, WALK_WORDS + WALK_FIELDS * PITCH, np.int64)
    reach = int64(first) + walking
    gaps, movers = 0, 0
    for k in range(first, uint64(reach)):
        lane_at(lanes, uint64(gaps)).listed = k
        gaps += 1 if lane_at(lanes, k).walk_state == ENDED else 0
    for k in range(uint64(reach), last):
        lane_at(lanes, uint64(movers)).movers = k
        movers += 1 if lane_at(lanes, k).walk_state != ENDED else 0
    for g in range(uint64(gaps)):
        there = uint64(WALK_WORDS + lane_at(lanes, g).movers)
        here = uint64(WALK_WORDS + lane_at(lanes, g).listed)
        for f in range(WALK_FIELDS):
            words[here + uint64(f * PITCH)] = words[there + uint64(f * PITCH)]
    full = (reach + 7) // 8 * 8
    full = full if full < int64(last) else int64(last)
    for k in range(uint64(reach), uint64(full)):
        lane_at(lanes, k).walk_state = ENDED
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
    lane.depth = free_depth(lane.depth)
    lane.distance = lane.start + (lane.depth * lane.mfp + 2.0 * COLLISION_CLEARANCE)


@lane_pass(layout.NO_TABLE)
def reset_cuts(lane, table):
    """Clear the mark of cut flights."""
    lane.cut = 0


@lane_pass(layout.NO_TABLE, sums=revoke_collisions)
def revoke_cut_collisions(lane, table):
    """Revoke the collision of lanes whose flight was cut within voxels."""
    pauses = (lane.cut != 0) & (lane.collides != 0)
    lane.collides = choose(pauses, 0, lane.collides)
    return 1 if pauses else 0


@device
def extinction_of(lane, table):
    """Return extinction [1/scene lengths] and albedo of the voxel of a tentative collision."""
    scatters, absorbs = scattering_at(lane, table, lane.voxel), absorption_at(lane, table, lane.voxel)
    return (scatters + absorbs) * table.length, scatters / (scatters + absorbs)


@device
def delta_track(lane, table):
    """Find the first real collision of one lane as `delta_track_in_grid` does."""
    tops = view(lane.arena + table.tops, table.top_count, np.float64)
    levels = view(lane.arena + table.levels, table.level_count, np.uint8)
    start_walk(lane, table)
    while lane.walk_state < ENDED:
        resample_rejected(lane)
        look_up_majorant(lane, tops)
        cross_macro_cell(lane, table)
        if lane.walk_state == PAUSED:
            end_flight(lane, lane, 1)
        if lane.walk_state == TENTATIVE:
            find_voxel(lane, table)
            lane.level = levels[uint64(lane.lookup_voxel)]
            accept_by_level(lane)
            extinction, albedo = extinction_of(lane, table)
            if lane.walk_state == UNDECIDED:
                accept_exactly(lane, extinction)
            if lane.walk_state == COLLIDED:
                lane.survival = choose(table.absorbs != 0, albedo, lane.survival)
                end_collided_flight(lane)


@bundle_pass(layout.GRID, alone=delta_track)
def delta_track_in_grid(lanes, table, first, live):
    """Find the first real collision in one grid, if it lies before the nearest surface (delta tracking).

    Sets what `collide` needs and, in `survival`, the albedo of the voxel. All flights walk together, in turns
    of two kinds: each moves to the next macro cell; once half of them have reached a tentative collision,
    these are decided.
    """
    tops = view(lanes.arena + table.tops, table.top_count, np.float64)
    levels = view(lanes.arena + table.levels, table.level_count, np.uint8)
    walking = 0
    for k in range(first, live):
        walking += start_walk(lane_at(lanes, k), table)
    last, rejected, is_in_place = live, 0, table.absorbs == 0
    while walking > 0:
        # Compact the walks when a quarter has ended.
        if walking * 4 < (int64(last) - int64(first)) * 3:
            last, is_in_place = compact_walks(lanes, first, last, walking), False
        # New depths after rejected collisions; then cross one macro cell.
        if rejected > 0:
            for k in range(first, last):
                resample_rejected(lane_at(lanes, k))
        for k in range(first, last):
            look_up_majorant(lane_at(lanes, k), tops)
        trying, walking, pausing, rejected = 0, 0, 0, 0
        for k in range(first, last):
            tries, walks, pauses = cross_macro_cell(lane_at(lanes, k), table)
            trying, walking, pausing = trying + tries, walking + walks, pausing + pauses
        if pausing > 0:
            end_listed_flights(lanes, list_walks(lanes, PAUSED, first, last), 1)
        # Decide tentative collisions: by quantised extinctions, then exactly.
        if trying * 2 >= walking:
            for k in range(first, last):
                find_voxel(lane_at(lanes, k), table)
            for k in range(first, last):
                lane_at(lanes, k).level = levels[uint64(lane_at(lanes, k).lookup_voxel)]
            real, unsure = 0, 0
            for k in range(first, last):
                is_real, is_rejected, is_unsure = accept_by_level(lane_at(lanes, k))
                real, rejected, unsure = real + is_real, rejected + is_rejected, unsure + is_unsure
            for g in range(uint64(list_walks(lanes, UNDECIDED, first, last) if unsure > 0 else 0)):
                walk = lane_at(lanes, uint64(lane_at(lanes, g).listed))
                extinction, _ = extinction_of(walk, table)
                real += accept_exactly(walk, extinction)
            rejected, walking = rejected + unsure, walking - real
            # End the flights of real collisions.
            if is_in_place:
                for k in range(first, last):
                    end_collided_flight(lane_at(lanes, k))
            else:
                collided = uint64(list_walks(lanes, COLLIDED, first, last))
                for g in range(collided if table.absorbs != 0 else uint64(0)):
                    walk = lane_at(lanes, uint64(lane_at(lanes, g).listed))
                    _, albedo = extinction_of(walk, table)
                    lane_at(lanes, uint64(walk.walk_lane)).survival = albedo
                end_listed_flights(lanes, collided, 0)
    return live


@lane_pass(layout.GRID, sums=to_row_of_table)
def attenuate_in_grid(lane, table):
    """Absorb along flights through a grid that only absorbs: weight times the exact exp(-optical depth).

    The ledger takes the difference of the exact sums before and after.
    """
    if lane.medium != table.medium or lane.weight == 0.0:
        return 0, 0
    before, depth = lane.weight, grid_depth(lane, table)
    lane.weight = attenuated(before, depth, hash_salt(lane.seed_low, lane.batch) + lane.history)
    return limbs_of_loss(before, lane.weight)


@lane_pass(layout.NO_TABLE)
def absorb_by_albedo(lane, table):
    """Absorb at collisions in grids by weight: multiply by the voxel's albedo (`survival`)."""
    lane.left = lane.weight * lane.survival if lane.collides != 0 else lane.weight
    lane.collides = choose(lane.left == 0.0, 0, lane.collides)
