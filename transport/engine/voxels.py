"""Rays through voxels: cells along each axis, coefficients of a voxel, exact optical depth."""

import math

from numba import float64, int64

from transport.physics.device import device

# a direction component below SLOWEST never leaves a cell; NEVER is its reciprocal
SLOWEST, NEVER = 1e-280, 1e300


@device
def pace(v):
    """Return a direction component in cells per scene length and its reciprocal.

    The component is 0, and the reciprocal NEVER, if the ray never leaves a cell along this axis.
    """
    moves = abs(v) > SLOWEST
    return v if moves else 0.0, 1.0 / v if moves else NEVER


@device
def cell_at(place, count):
    """Return the cell that holds a coordinate, clamped to the grid."""
    cell = math.floor(place)
    highest = count - 1.0
    cell = cell if cell > 0.0 else 0.0
    return cell if cell < highest else highest


@device
def axis_of(p, v, start, block, cells, count):
    """Return for one axis of a ray p + v t in voxels: cell at `start`, its step, the face ahead, 1/v."""
    v, inverse = pace(v)
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
    vx, ix = pace(ux * per_x)
    vy, iy = pace(uy * per_y)
    vz, iz = pace(uz * per_z)
    i, j, m = (
        cell_at(px + start * vx, table.nx),
        cell_at(py + start * vy, table.ny),
        cell_at(pz + start * vz, table.nz),
    )
    up_x, up_y, up_z = (
        1.0 if vx >= 0.0 else 0.0,
        1.0 if vy >= 0.0 else 0.0,
        1.0 if vz >= 0.0 else 0.0,
    )
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
