"""Flights through voxels: tentative collisions by local majorants, of which some are real (Woodcock 1965), or exact depths.

A flight has an optical depth to spend.  In each macro cell it spends it at the rate of the largest extinction there; where
it is spent, a tentative collision is real with the chance of the voxel's extinction over that majorant, else the flight goes
on with a new depth.  No draw is made on the way from macro cell to macro cell: the exponential law has no memory.  Macro
cells are left by counting their indices up or down, never by comparing places, so every step makes progress.
"""

import math

import numpy as np
from numba import int64, uint64

from transport.compile.layout import GRID, NO_TABLE, SLACK
from transport.engine.addresses import view
from transport.engine.passes import lane_pass
from transport.engine.sums import limbs
from transport.physics.device import device
from transport.physics.elementary import exp_negative, log_positive
from transport.physics.streams import PATH, VOXELS, random_words, short_uniform, uniform

FASTEST = 1e-280  # direction along an axis, in voxels per scene length, below which a flight never leaves a cell that way
NEVER = 1e300  # one over it
STEPS = uint64(6)  # bits of a purpose below the number of the draw
LOW32 = uint64(0xFFFFFFFF)


@lane_pass(NO_TABLE)
def fly_in_grids(b, table, first, live):
    """Draw a free path, as collisions.fly, and keep the optical depth that it is made of: in grids it is spent voxel by voxel."""
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, b.event[k], PATH, seed_low, seed_high)
        flies = (b.hit[k] == 0) & (b.distance[k] < math.inf) & (b.weight[k] != 0.0)
        depth = -log_positive((1.0 - 2.0**-53) - uniform(w0, w1))
        b.depth[k] = depth
        b.distance[k] = b.start[k] + (depth * b.mfp[k] + 2.0 * SLACK) if flies else b.distance[k]
        b.event[k] += 1 if flies else 0
        b.flies[k] = 1 if flies else 0
        b.u0[k], b.u1[k] = uniform(w2, (w1 << uint64(20)) & LOW32), short_uniform(w3)
    return live


@device
def axis_of(p, v, start, block, cells, count):
    """Along one axis, for a ray p + v t in voxels: the macro cell at `start`, the step to the next one, the face between them, and 1/v."""
    moves = abs(v) > FASTEST
    step = -1 if (v < 0.0) & moves else 1
    cell = int64((p + start * v) / block)
    cell = 0 if cell < 0 else (cells - 1 if cell >= cells else cell)
    face = float64_of(cell if step < 0 else cell + 1) * block
    return cell, step, face if face < count else count, 1.0 / v if moves else NEVER


@device
def float64_of(n):
    """An integer as a number."""
    return n * 1.0


@device
def voxel_of(place, cell, block, count):
    """The voxel at a place, kept within its macro cell: so its extinction is never above the majorant."""
    low, high = cell * block, cell * block + block - 1
    high = high if high < count else count - 1
    voxel = int64(place)
    return low if voxel < low else (high if voxel > high else voxel)


@lane_pass(GRID)
def collide_in_grid(b, table, first, live):
    """The first real collision in one grid, where it comes before the surface that was found.

    Leaves what `collide` needs, and in `survival` the albedo of the voxel.  A tentative collision draws only where its voxel is
    below the majorant: block after block of random numbers, told apart by their purpose.
    """
    tops = view(table.tops, table.mx * table.my * table.mz, np.float64)
    absorption = view(table.absorption, table.absorption_count, np.float64)
    scattering = view(table.scattering, table.scattering_count, np.float64)
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    size, width = table.size, table.block
    nx, ny, nz, block = (
        float64_of(table.nx),
        float64_of(table.ny),
        float64_of(table.nz),
        float64_of(table.block),
    )
    for k in range(first, live):
        if b.flies[k] == 0 or b.medium[k] != table.medium:
            continue
        vx, vy, vz = b.ux[k] * table.per_x, b.uy[k] * table.per_y, b.uz[k] * table.per_z
        px, py = (b.x[k] - table.cx) * table.per_x, (b.y[k] - table.cy) * table.per_y
        pz = (b.z[k] - table.cz) * table.per_z
        t, limit, depth, draws = b.start[k], b.distance[k] - 2.0 * SLACK, b.depth[k], 0
        i, step_x, face_x, ix = axis_of(px, vx, t, block, table.mx, nx)
        j, step_y, face_y, iy = axis_of(py, vy, t, block, table.my, ny)
        m, step_z, face_z, iz = axis_of(pz, vz, t, block, table.mz, nz)
        t_x, t_y, t_z = (face_x - px) * ix, (face_y - py) * iy, (face_z - pz) * iz
        while True:
            leaves = min(t_x, min(t_y, t_z))
            end = leaves if leaves < limit else limit
            top = tops[(i * table.my + j) * table.mz + m] * size
            if depth < top * (end - t):
                t += depth / top
                vi = voxel_of(px + t * vx, i, width, table.nx)
                vj = voxel_of(py + t * vy, j, width, table.ny)
                vm = voxel_of(pz + t * vz, m, width, table.nz)
                scatters = scattering[
                    vi * table.scattering_x + vj * table.scattering_y + vm * table.scattering_z
                ]
                here = absorption[vi * table.absorption_x + vj * table.absorption_y + vm * table.absorption_z]
                here += scatters
                accepted = here * size >= top
                if not accepted:
                    purpose = uint64(VOXELS) | uint64(draws) << STEPS
                    w0, w1, w2, w3 = random_words(
                        b.history[k], batch, b.event[k], purpose, seed_low, seed_high
                    )
                    draws += 1
                    accepted = uniform(w2, w3) * top < here * size
                    depth = -log_positive((1.0 - 2.0**-53) - uniform(w0, w1))
                if accepted:
                    b.distance[k] = t + 2.0 * SLACK
                    b.hit[k] = 0
                    b.survival[k] = scatters / here
                    break
            elif leaves < limit:
                spent = top * (end - t)
                depth -= spent if spent > 0.0 else 0.0
                t = leaves if leaves > t else t
                if leaves == t_x:
                    i += step_x
                    face_x = min(face_x + step_x * block, nx) if step_x > 0 else float64_of(i) * block
                    t_x = (face_x - px) * ix
                elif leaves == t_y:
                    j += step_y
                    face_y = min(face_y + step_y * block, ny) if step_y > 0 else float64_of(j) * block
                    t_y = (face_y - py) * iy
                else:
                    m += step_z
                    face_z = min(face_z + step_z * block, nz) if step_z > 0 else float64_of(m) * block
                    t_z = (face_z - pz) * iz
                if (i < 0) | (j < 0) | (m < 0) | (i >= table.mx) | (j >= table.my) | (m >= table.mz):
                    break
            else:
                break
    return live


@device
def grid_depth(table, absorption, scattering, x, y, z, ux, uy, uz, start, end):
    """Optical depth along a ray from the distance `start` to `end`: exact, voxel by voxel."""
    vx, vy, vz = ux * table.per_x, uy * table.per_y, uz * table.per_z
    px, py, pz = (x - table.cx) * table.per_x, (y - table.cy) * table.per_y, (z - table.cz) * table.per_z
    i, step_x, face_x, ix = axis_of(px, vx, start, 1.0, table.nx, float64_of(table.nx))
    j, step_y, face_y, iy = axis_of(py, vy, start, 1.0, table.ny, float64_of(table.ny))
    m, step_z, face_z, iz = axis_of(pz, vz, start, 1.0, table.nz, float64_of(table.nz))
    t_x, t_y, t_z = (face_x - px) * ix, (face_y - py) * iy, (face_z - pz) * iz
    t, depth, going = start, 0.0, True
    while going:
        leaves = min(t_x, min(t_y, t_z))
        last = leaves if leaves < end else end
        here = scattering[i * table.scattering_x + j * table.scattering_y + m * table.scattering_z]
        here += absorption[i * table.absorption_x + j * table.absorption_y + m * table.absorption_z]
        depth += here * (last - t) if last > t else 0.0
        t = last if last > t else t
        going = leaves < end
        if leaves == t_x:
            i += step_x
            face_x += step_x
            t_x = (face_x - px) * ix
        elif leaves == t_y:
            j += step_y
            face_y += step_y
            t_y = (face_y - py) * iy
        else:
            m += step_z
            face_z += step_z
            t_z = (face_z - pz) * iz
        going &= (i >= 0) & (j >= 0) & (m >= 0) & (i < table.nx) & (j < table.ny) & (m < table.nz)
    return depth * table.size


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
