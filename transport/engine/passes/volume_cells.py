"""Volume detectors with cells: flights are walked cell by cell; collisions are scored in their cell.

The parts of a path add up to the whole: each begins where the last one ended, and a boundary that rounding
has put behind that place is passed at once. Every step leaves a cell for the next one on the way, so the walk
ends.
"""

import math

import numpy as np
from numba import float64, int64, njit

from transport.compile import layout
from transport.compile.layout import COLLISION_CLEARANCE
from transport.engine.bundle import add_to_row, view
from transport.engine.passes.detector_bins import azimuth_cell, find_cell
from transport.engine.passes.volumes import (
    SCORE_BOUND,
    half_chord,
    lengths_of_part,
    mean_transmittance,
    slab_crossings,
)
from transport.engine.passes.voxels import axis_start
from transport.engine.registry import lane_pass
from transport.engine.tally import hash_salt, hashed_uniform, unbiased_limbs
from transport.physics.bits import bits_of
from transport.physics.device import ARITHMETIC, device
from transport.physics.elementary import azimuth_turn, exp_negative

# compiled as a separate function: inlining would only make passes slow to compile
separate_device = njit(**ARITHMETIC)


@lane_pass(layout.VOLUME)
def find_equal_bins(b, table, first, live):
    """Set the direction bin of each lane, where bins of equal width cover all directions.

    Fields: reads `ux, uy, uz`; writes `bin`.
    """
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    nx, ny, nz = table.nx, table.ny, table.nz
    cosines, turns = float64(table.mu_cells), float64(table.turn_cells)
    for k in range(first, live):
        ux, uy, uz = b.ux[k], b.uy[k], b.uz[k]
        i = math.floor((ux * nx + uy * ny + uz * nz + 1.0) * (0.5 * cosines))
        j = math.floor(azimuth_turn(ux * eux + uy * euy + uz * euz, ux * evx + uy * evy + uz * evz) * turns)
        i = i if i > 0.0 else 0.0
        i = i if i < cosines else cosines - 1.0
        j = j if j < turns else turns - 1.0
        b.bin[k] = int64(1.0 + i * turns + j)
    return live


@separate_device
def direction_bin(b, table, k):
    """Return the direction bin of lane k for any edges: 0 without bins of direction, and outside of them.

    Fields: reads `ux, uy, uz`, `bin`.
    """
    if table.is_even != 0:
        return b.bin[k]
    ux, uy, uz = b.ux[k], b.uy[k], b.uz[k]
    bin = 0
    if table.rows > 1:
        cosine, turn = ux * table.nx + uy * table.ny + uz * table.nz, 0
        found = find_cell(cosine, table.mu_cells, table.mu_edges)
        if table.turn_cells > 0:
            e_u = ux * table.eux + uy * table.euy + uz * table.euz
            e_v = ux * table.evx + uy * table.evy + uz * table.evz
            turn = azimuth_cell(e_u, e_v, table.turn_low, table.turn_cells, table.turn_edges)
        if (found >= 0) & (turn >= 0):
            bin = 1 + found * table.mu_stride + turn * table.turn_stride
    return bin


@device
def score_in_cell(b, table, k, number, bin, track, keep, count):
    """Add weight times path [scene lengths] to a cell's row, and the absorbed weight to another.

    count: 1, or 0 for a path left by rounding alone.

    Fields: reads `history`; updates `scored`.
    """
    chance = hashed_uniform(bits_of(track) ^ number, hash_salt(b.seed_low, b.batch) + b.history[k])
    high, low = unbiased_limbs(track * table.scale, chance)
    add_to_row(b.tallies + 32 * (table.first + number * table.rows + bin), high, low, count, 0)
    b.scored += high + SCORE_BOUND
    if table.kept != 0:
        high, low = unbiased_limbs(track * keep, chance)
        add_to_row(b.tallies + 32 * (table.kept + number), high, low, count, 0)
        b.scored += high


@separate_device
def score_part(b, table, k, number, bin, length, weight, fade, keep):
    """Score the path through one cell; returns the weight behind it.

    Fields: reads `history`; updates `scored`.
    """
    mean, left = 1.0, weight
    if table.kept != 0:
        mean, less = mean_transmittance(fade * length)
        left = weight + weight * less
    count = 1 if length > COLLISION_CLEARANCE else 0
    score_in_cell(b, table, k, number, bin, weight * length * mean, keep, count)
    return left


@device
def number_along(place, per_length, count):
    """Return the cell along one axis that holds a coordinate measured from the lower face, clamped."""
    number = int64(math.floor(place * per_length))
    return 0 if number < 0 else (count - 1 if number >= count else number)


@device
def next_face(place, number, u, inverse, width, count):
    """Return the distance at which the ray leaves cells of this number along one axis.

    Infinity beyond the last ones.
    """
    if u > 0.0:
        return (width * (number + 1) - place) * inverse if number + 1 < count else math.inf
    return (width * number - place) * inverse if (u < 0.0) & (number > 0) else math.inf


@separate_device
def walk_voxels(b, table, k, bin, t, end, weight, fade, keep):
    """Walk a flight through the voxels from distance t to `end` (Amanatides and Woo 1987).

    Returns the weight left. The distance of each face is computed from its number, so rounding does not
    accumulate.

    Fields: reads `x, y, z`, `ux, uy, uz`, `history`; updates `scored`.
    """
    ux, uy, uz = b.ux[k], b.uy[k], b.uz[k]
    ix, iy, iz = 1.0 / ux, 1.0 / uy, 1.0 / uz
    px, py, pz = b.x[k] - table.cx + table.hx, b.y[k] - table.cy + table.hy, b.z[k] - table.cz + table.hz
    # First voxel, and the distances of the next face along each axis.
    i = number_along(px + t * ux, table.per_x, table.cells_x)
    j = number_along(py + t * uy, table.per_y, table.cells_y)
    m = number_along(pz + t * uz, table.per_z, table.cells_z)
    t_x = next_face(px, i, ux, ix, table.width_x, table.cells_x)
    t_y = next_face(py, j, uy, iy, table.width_y, table.cells_y)
    t_z = next_face(pz, m, uz, iz, table.width_z, table.cells_z)
    going = True
    while going:
        face = min(t_x, min(t_y, t_z))
        going = face < end
        length = (face if going else end) - t
        if length > 0.0:  # none to a face that rounding has put behind
            number = (i * table.cells_y + j) * table.cells_z + m
            weight = score_part(b, table, k, number, bin, length, weight, fade, keep)
            t = face
        # Step across the nearest face.
        if going:
            if face == t_x:
                i += 1 if ux > 0.0 else -1
                t_x = next_face(px, i, ux, ix, table.width_x, table.cells_x)
            elif face == t_y:
                j += 1 if uy > 0.0 else -1
                t_y = next_face(py, j, uy, iy, table.width_y, table.cells_y)
            else:
                m += 1 if uz > 0.0 else -1
                t_z = next_face(pz, m, uz, iz, table.width_z, table.cells_z)
    return weight


@device
def shell_at(radius, count, radii):
    """Return the shell at this distance from the centre.

    -1 within the first radius, the last shell beyond all.
    """
    bounds = view(radii, count + 1, np.float64)
    found = find_cell(radius, count, radii)
    return (-1 if radius < bounds[0] else count - 1) if found < 0 else found


@separate_device
def walk_shells(b, table, k, bin, start, last, weight, fade, keep):
    """Walk a flight through spherical shells: inwards as far as the ray hits them, then outwards.

    Returns the weight left.

    Fields: reads `x, y, z`, `ux, uy, uz`, `history`; updates `scored`.
    """
    count = table.cells_x
    radii = view(table.radii, count + 1, np.float64)
    ux, uy, uz = b.ux[k], b.uy[k], b.uz[k]
    ox, oy, oz = b.x[k] - table.cx, b.y[k] - table.cy, b.z[k] - table.cz
    h = ox * ux + oy * uy + oz * uz
    qx, qy, qz = ox - h * ux, oy - h * uy, oz - h * uz
    q = math.sqrt(qx * qx + qy * qy + qz * qz)
    t, end = start + h, last + h  # measured from the point nearest to the centre
    shell = shell_at(math.sqrt(q * q + t * t), count, table.radii)
    going = True
    while going:
        # Next sphere: inwards until the ray's closest point, then outwards.
        inwards = (t < 0.0) & (shell >= 0)
        if inwards:
            inwards = radii[shell] > q
        if inwards:
            face = -half_chord(radii[shell], q)
        else:
            face = half_chord(radii[shell + 1], q) if shell + 1 < count else math.inf
        going = face < end
        length = (face if going else end) - t
        if length > 0.0:
            if shell >= 0:
                weight = score_part(b, table, k, shell, bin, length, weight, fade, keep)
            elif table.kept != 0:
                weight *= exp_negative(-fade * length)
            t = face
        if going:
            shell += -1 if inwards else 1
    return weight


@device
def seen_along_axis(px, py, pz, ux, uy, uz, ax, ay, az):
    """Return how a ray from p runs about and along an axis through the origin.

    Distance from the axis where it is nearest; the way from there to p across the axis; sine and cosine of
    the ray to the axis; height of p. A ray along the axis stays at its distance.
    """
    cosine, height = ux * ax + uy * ay + uz * az, px * ax + py * ay + pz * az
    px, py, pz = px - height * ax, py - height * ay, pz - height * az
    ux, uy, uz = ux - cosine * ax, uy - cosine * ay, uz - cosine * az
    sine = math.sqrt(ux * ux + uy * uy + uz * uz)
    inverse = 1.0 / sine if sine > 0.0 else 0.0
    ux, uy, uz = ux * inverse, uy * inverse, uz * inverse
    across = px * ux + py * uy + pz * uz
    qx, qy, qz = px - across * ux, py - across * uy, pz - across * uz
    return math.sqrt(qx * qx + qy * qy + qz * qz), across, sine, cosine, height


@lane_pass(layout.VOLUME)
def clip_to_cylinder(b, table, first, live):
    """Find the flight's path length before a cylinder and inside it, between its side and its ends.

    Fields: reads `x, y, z`, `ux, uy, uz`, `start`, `flight_end`; writes `length_before`, `length_inside`.
    """
    cx, cy, cz, ax, ay, az = table.cx, table.cy, table.cz, table.ax, table.ay, table.az
    radius, half_height = table.hx, table.hz
    for k in range(first, live):
        px, py, pz = b.x[k] - cx, b.y[k] - cy, b.z[k] - cz
        q, across, sine, cosine, height = seen_along_axis(px, py, pz, b.ux[k], b.uy[k], b.uz[k], ax, ay, az)
        bottom, top = slab_crossings(height, cosine, half_height)
        half, inverse = half_chord(radius, q), 1.0 / sine if sine > 0.0 else math.inf
        enters, leaves = (-half - across) * inverse, (half - across) * inverse
        leaves = leaves if q <= radius else -math.inf
        start, near, far = b.start[k], b.start[k], b.flight_end[k]
        near = bottom if bottom > near else near
        near = enters if enters > near else near
        far = top if top < far else far
        far = leaves if leaves < far else far
        b.length_before[k], b.length_inside[k] = lengths_of_part(start, near, far)
    return live


@separate_device
def walk_rings(b, table, k, bin, t, end, weight, fade, keep):
    """Walk a flight through the rings of a cylinder: inwards as far as the ray hits them, then outwards.

    Returns the weight left. Rings and layers are crossed at distances computed from their numbers.

    Fields: reads `x, y, z`, `ux, uy, uz`, `history`; updates `scored`.
    """
    count, layers = table.cells_x, table.cells_z
    radii = view(table.radii, count + 1, np.float64)
    px, py, pz = b.x[k] - table.cx, b.y[k] - table.cy, b.z[k] - table.cz
    ax, ay, az = table.ax, table.ay, table.az
    q, across, sine, cosine, height = seen_along_axis(px, py, pz, b.ux[k], b.uy[k], b.uz[k], ax, ay, az)
    inverse, per_height = 1.0 / sine if sine > 0.0 else 0.0, 1.0 / cosine
    place, now = height + table.hz, across + t * sine
    ring = shell_at(math.sqrt(q * q + now * now), count, table.radii)
    layer = number_along(place + t * cosine, table.per_z, layers)
    t_z = next_face(place, layer, cosine, per_height, table.width_z, layers)
    inwards = now < 0.0
    going = True
    while going:
        # Next ring: inwards until the ray's closest point, then outwards.
        inwards = inwards & (ring > 0)
        if inwards:
            inwards = radii[ring] > q
        t_r = math.inf
        if inwards:
            t_r = (-half_chord(radii[ring], q) - across) * inverse
        elif (ring + 1 < count) & (sine > 0.0):
            t_r = (half_chord(radii[ring + 1], q) - across) * inverse
        face = min(t_r, t_z)
        going = face < end
        length = (face if going else end) - t
        if length > 0.0:
            weight = score_part(b, table, k, ring * layers + layer, bin, length, weight, fade, keep)
            t = face
        if going:
            if face == t_r:
                ring += -1 if inwards else 1
            else:
                layer += 1 if cosine > 0.0 else -1
                t_z = next_face(place, layer, cosine, per_height, table.width_z, layers)
    return weight


@device
def walk(b, table, k, bin, t, end, weight, fade, keep):
    """Walk through the cells of a volume from distance t on a flight to `end`; returns the weight left.

    Fields: reads `x, y, z`, `ux, uy, uz`, `history`; updates `scored`.
    """
    if table.is_one != 0:
        return score_part(b, table, k, 0, bin, end - t, weight, fade, keep)
    if table.cells_z == 0:
        return walk_shells(b, table, k, bin, t, end, weight, fade, keep)
    if table.radii != 0:
        return walk_rings(b, table, k, bin, t, end, weight, fade, keep)
    return walk_voxels(b, table, k, bin, t, end, weight, fade, keep)


@lane_pass(layout.VOLUME)
def walk_through_cells(b, table, first, live):
    """Score the path through each cell of a volume detector.

    Fields: reads `x, y, z`, `ux, uy, uz`, `weight`, `history`, `start`, `bin`, `length_before`,
    `length_inside`, `path_absorption`, `total_absorption`; updates `scored`.
    """
    n = 0
    for k in range(first, live):  # no branch, so no misprediction
        b.listed[n] = k
        n += 1 if b.length_inside[k] > 0.0 else 0
    for item in range(n):
        k = b.listed[item]
        weight, fade, keep = b.weight[k], 0.0, 0.0
        if table.kept != 0:
            fade, keep = b.path_absorption[k], b.total_absorption[k]
            weight *= exp_negative(-fade * b.length_before[k])
        bin = direction_bin(b, table, k)
        t = b.start[k] + b.length_before[k]
        walk(b, table, k, bin, t, t + b.length_inside[k], weight, fade, keep)
    return live


@lane_pass(layout.VOLUME_IN_GRID)
def walk_through_grid(b, table, first, live):
    """Score flights in an absorbing grid, voxel by voxel of the grid.

    Later passes skip these lanes (`length_inside` = 0).

    Fields: reads `x, y, z`, `ux, uy, uz`, `weight`, `history`, `start`, `medium`, `bin`, `length_before`;
    updates `length_inside`, `scored`.
    """
    n, grid, volume = 0, table.grid, table.volume
    for k in range(first, live):
        b.listed[n] = k
        n += 1 if (b.length_inside[k] > 0.0) & (b.medium[k] == grid.medium) else 0
    absorption = view(grid.absorption, grid.absorption_count, np.float64)
    for item in range(n):
        k = b.listed[item]
        weight, t, entry = b.weight[k], b.start[k], b.start[k] + b.length_before[k]
        end = entry + b.length_inside[k]
        b.length_inside[k] = 0.0
        bin = direction_bin(b, volume, k)
        vx, vy, vz = b.ux[k] * grid.per_x, b.uy[k] * grid.per_y, b.uz[k] * grid.per_z
        px, py = (b.x[k] - grid.cx) * grid.per_x, (b.y[k] - grid.cy) * grid.per_y
        pz = (b.z[k] - grid.cz) * grid.per_z
        # Start in the voxel at `start`.
        i, step_x, face_x, ix = axis_start(px, vx, t, 1.0, grid.nx, float64(grid.nx))
        j, step_y, face_y, iy = axis_start(py, vy, t, 1.0, grid.ny, float64(grid.ny))
        m, step_z, face_z, iz = axis_start(pz, vz, t, 1.0, grid.nz, float64(grid.nz))
        t_x, t_y, t_z = (face_x - px) * ix, (face_y - py) * iy, (face_z - pz) * iz
        going = True
        while going:
            leaves = min(t_x, min(t_y, t_z))
            last = leaves if leaves < end else end
            here = i * grid.absorption_x + j * grid.absorption_y + m * grid.absorption_z
            keep = absorption[here] * grid.length
            fade = keep if table.fades != 0 else 0.0
            # Attenuate up to the volume; then score the part of this voxel in the volume.
            before = (entry if entry < last else last) - t
            if before > 0.0:
                weight *= exp_negative(-fade * before)
                t += before
            if last > t:
                weight = walk(b, volume, k, bin, t, last, weight, fade, keep)
                t = last
            going = leaves < end
            # Step to the next voxel.
            if leaves == t_x:
                i, face_x = i + step_x, face_x + step_x
                t_x = (face_x - px) * ix
            elif leaves == t_y:
                j, face_y = j + step_y, face_y + step_y
                t_y = (face_y - py) * iy
            else:
                m, face_z = m + step_z, face_z + step_z
                t_z = (face_z - pz) * iz
            going &= (i >= 0) & (j >= 0) & (m >= 0) & (i < grid.nx) & (j < grid.ny) & (m < grid.nz)
    return live


@lane_pass(layout.NO_TABLE)
def set_collision_paths(b, table, first, live):
    """Set the mean free path, as `length_inside`, and the total absorption coefficient at collisions.

    Fields: reads `mfp`, `sigma_a`, `survival`; writes `length_inside`, `total_absorption`.
    """
    for k in range(first, live):
        b.length_inside[k] = b.mfp[k]
        b.total_absorption[k] = b.sigma_a[k] + (1.0 - b.survival[k]) / b.mfp[k]
    return live


@lane_pass(layout.GRID)
def set_collision_paths_in_grid(b, table, first, live):
    """Set mean free path and total absorption coefficient at collisions in a grid, from their voxel.

    Fields: reads `x, y, z`, `medium`, `collides`; writes `length_inside`, `total_absorption`.
    """
    absorption = view(table.absorption, table.absorption_count, np.float64)
    scattering = view(table.scattering, table.scattering_count, np.float64)
    for k in range(first, live):
        if (b.collides[k] != 0) & (b.medium[k] == table.medium):
            i = number_along(b.x[k] - table.cx, table.per_x, table.nx)
            j = number_along(b.y[k] - table.cy, table.per_y, table.ny)
            m = number_along(b.z[k] - table.cz, table.per_z, table.nz)
            keep = absorption[i * table.absorption_x + j * table.absorption_y + m * table.absorption_z]
            sigma = scattering[i * table.scattering_x + j * table.scattering_y + m * table.scattering_z]
            sigma += keep
            b.length_inside[k] = 1.0 / (sigma * table.length) if sigma > 0.0 else 0.0
            b.total_absorption[k] = keep * table.length
    return live


@device
def score_collision(b, table, k, number):
    """Score weight times mean free path at a collision in this cell (collision estimator).

    Fields: reads `ux, uy, uz`, `weight`, `history`, `bin`, `length_inside`, `total_absorption`; updates
    `scored`.
    """
    track, bin = b.weight[k] * b.length_inside[k], direction_bin(b, table, k)
    score_in_cell(b, table, k, number, bin, track, b.total_absorption[k], 1)


@lane_pass(layout.VOLUME)
def score_collisions_in_box(b, table, first, live):
    """Score weight times mean free path at each collision in a box (collision estimator).

    Fields: reads `x, y, z`, `ux, uy, uz`, `weight`, `history`, `collides`, `bin`, `length_inside`,
    `total_absorption`; updates `scored`.
    """
    n, hx, hy, hz = 0, table.hx, table.hy, table.hz
    for k in range(first, live):
        dx, dy, dz = abs(b.x[k] - table.cx), abs(b.y[k] - table.cy), abs(b.z[k] - table.cz)
        b.listed[n] = k
        n += 1 if (b.collides[k] != 0) & (dx <= hx) & (dy <= hy) & (dz <= hz) else 0
    for item in range(n):
        k = b.listed[item]
        i = number_along(b.x[k] - table.cx + hx, table.per_x, table.cells_x)
        j = number_along(b.y[k] - table.cy + hy, table.per_y, table.cells_y)
        m = number_along(b.z[k] - table.cz + hz, table.per_z, table.cells_z)
        score_collision(b, table, k, (i * table.cells_y + j) * table.cells_z + m)
    return live


@lane_pass(layout.VOLUME)
def score_collisions_in_ball(b, table, first, live):
    """Score weight times mean free path at each collision in the shells of a ball.

    Fields: reads `x, y, z`, `ux, uy, uz`, `weight`, `history`, `collides`, `bin`, `length_inside`,
    `total_absorption`; updates `scored`.
    """
    n, radius = 0, table.hx
    for k in range(first, live):
        dx, dy, dz = b.x[k] - table.cx, b.y[k] - table.cy, b.z[k] - table.cz
        b.listed[n] = k
        n += 1 if (b.collides[k] != 0) & (dx * dx + dy * dy + dz * dz <= radius * radius) else 0
    for item in range(n):
        k = b.listed[item]
        dx, dy, dz = b.x[k] - table.cx, b.y[k] - table.cy, b.z[k] - table.cz
        shell = shell_at(math.sqrt(dx * dx + dy * dy + dz * dz), table.cells_x, table.radii)
        if shell >= 0:
            score_collision(b, table, k, shell)
    return live


@lane_pass(layout.VOLUME)
def score_collisions_in_cylinder(b, table, first, live):
    """Score weight times mean free path at each collision in the rings of a cylinder.

    Fields: reads `x, y, z`, `ux, uy, uz`, `weight`, `history`, `collides`, `bin`, `length_inside`,
    `total_absorption`; updates `scored`.
    """
    ax, ay, az, radius, half_height = table.ax, table.ay, table.az, table.hx, table.hz
    for k in range(first, live):
        px, py, pz = b.x[k] - table.cx, b.y[k] - table.cy, b.z[k] - table.cz
        height = px * ax + py * ay + pz * az
        px, py, pz = px - height * ax, py - height * ay, pz - height * az
        rho = math.sqrt(px * px + py * py + pz * pz)
        if (b.collides[k] != 0) & (rho <= radius) & (abs(height) <= half_height):
            ring = shell_at(rho, table.cells_x, table.radii)
            layer = number_along(height + half_height, table.per_z, table.cells_z)
            score_collision(b, table, k, ring * table.cells_z + layer)
    return live
