"""Volume detectors with cells: flights are walked cell by cell; collisions are scored in their cell.

The parts of a path add up to the whole: each begins where the last one ended, and a boundary that rounding
has put behind that place is passed at once. Every step leaves a cell for the next one on the way, so the walk
ends. Boxes and voxel grids are walked by physics/cells.py, shells and rings by the same rule here.
"""

import math

import numpy as np
from numba import float64, int64, njit

from transport.compile import layout
from transport.compile.layout import COLLISION_CLEARANCE
from transport.engine.bodies import lane_pass
from transport.engine.bundle import add_to_row, view
from transport.engine.passes.detector_bins import azimuth_cell, find_cell
from transport.engine.passes.volumes import (
    SCORE_BOUND,
    clip_to_slab,
    half_chord,
    lengths_of_part,
    mean_transmittance,
    nearest_to_centre,
)
from transport.engine.passes.voxels import absorption_at, enter_grid, scattering_at, voxel_at
from transport.engine.tally import hash_salt, hashed_uniform_of_one, unbiased_limbs_of_one
from transport.physics.bits import bits_of
from transport.physics.cells import (
    distance_of_face,
    enter_axis,
    enter_cells,
    nearest_face,
    next_cell,
    number_along,
)
from transport.physics.device import ARITHMETIC, device
from transport.physics.elementary import azimuth_turn, exp_negative

# compiled as a separate function: inlining would only make passes slow to compile
separate_device = njit(**ARITHMETIC)


@lane_pass(layout.VOLUME)
def find_equal_bins(lane, table):
    """Set the direction bin of each lane, where bins of equal width cover all directions."""
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    nx, ny, nz = table.nx, table.ny, table.nz
    cosines, turns = float64(table.mu_cells), float64(table.turn_cells)
    ux, uy, uz = lane.ux, lane.uy, lane.uz
    i = math.floor((ux * nx + uy * ny + uz * nz + 1.0) * (0.5 * cosines))
    j = math.floor(azimuth_turn(ux * eux + uy * euy + uz * euz, ux * evx + uy * evy + uz * evz) * turns)
    i = i if i > 0.0 else 0.0
    i = i if i < cosines else cosines - 1.0
    j = j if j < turns else turns - 1.0
    lane.bin = int64(1.0 + i * turns + j)


@separate_device
def direction_bin(lane, table):
    """Return the direction bin of lane k for any edges: 0 without bins of direction, and outside of them."""
    if table.is_even != 0:
        return lane.bin
    ux, uy, uz = lane.ux, lane.uy, lane.uz
    bin = 0
    if table.rows > 1:
        cosine, turn = ux * table.nx + uy * table.ny + uz * table.nz, 0
        found = find_cell(cosine, table.mu_cells, lane.arena + table.mu_edges)
        if table.turn_cells > 0:
            e_u = ux * table.eux + uy * table.euy + uz * table.euz
            e_v = ux * table.evx + uy * table.evy + uz * table.evz
            turn = azimuth_cell(e_u, e_v, table.turn_low, table.turn_cells, lane.arena + table.turn_edges)
        if (found >= 0) & (turn >= 0):
            bin = 1 + found * table.mu_stride + turn * table.turn_stride
    return bin


@device
def score_in_cell(lane, table, number, bin, track, keep, count):
    """Add weight times path [scene lengths] to a cell's row, and the absorbed weight to another.

    count: 1, or 0 for a path left by rounding alone.
    """
    salt = hash_salt(lane.seed_low, lane.batch) + lane.history
    chance = hashed_uniform_of_one(bits_of(track) ^ number, salt)
    high, low = unbiased_limbs_of_one(track * table.scale, chance)
    add_to_row(lane.tallies + 32 * (table.first + number * table.rows + bin), high, low, count, 0)
    lane.scored += high + SCORE_BOUND
    if table.kept != 0:
        high, low = unbiased_limbs_of_one(track * keep, chance)
        add_to_row(lane.tallies + 32 * (table.kept + number), high, low, count, 0)
        lane.scored += high


@separate_device
def score_part(lane, table, number, bin, length, weight, fade, keep):
    """Score the path through one cell; returns the weight behind it."""
    mean, left = 1.0, weight
    if table.kept != 0:
        mean, less = mean_transmittance(fade * length)
        left = weight + weight * less
    count = 1 if length > COLLISION_CLEARANCE else 0
    score_in_cell(lane, table, number, bin, weight * length * mean, keep, count)
    return left


@separate_device
def walk_voxels(lane, table, bin, t, end, weight, fade, keep):
    """Walk a flight through the voxels from distance t to `end`; returns the weight left."""
    place = (lane.x - table.cx + table.hx, lane.y - table.cy + table.hy, lane.z - table.cz + table.hz)
    per_length, width = (table.per_x, table.per_y, table.per_z), (table.width_x, table.width_y, table.width_z)
    count = (table.cells_x, table.cells_y, table.cells_z)
    axes, cell, faces = enter_cells(place, (lane.ux, lane.uy, lane.uz), t, per_length, width, count)
    going = True
    while going:
        face = nearest_face(faces)
        going = face < end
        length = (face if going else end) - t
        if length > 0.0:  # none to a face that rounding has put behind
            weight = score_part(lane, table, cell[0], bin, length, weight, fade, keep)
            t = face
        if going:
            cell, faces = next_cell(axes, cell, faces)
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
def walk_shells(lane, table, bin, start, last, weight, fade, keep):
    """Walk a flight through spherical shells: inwards as far as the ray hits them, then outwards.

    Returns the weight left.
    """
    count = table.cells_x
    radii = view(lane.arena + table.radii, count + 1, np.float64)
    ux, uy, uz = lane.ux, lane.uy, lane.uz
    ox, oy, oz = lane.x - table.cx, lane.y - table.cy, lane.z - table.cz
    h, q = nearest_to_centre(ox, oy, oz, ux, uy, uz)
    t, end = start + h, last + h  # measured from the point nearest to the centre
    shell = shell_at(math.sqrt(q * q + t * t), count, lane.arena + table.radii)
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
                weight = score_part(lane, table, shell, bin, length, weight, fade, keep)
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
def clip_to_cylinder(lane, table):
    """Find the flight's path length before a cylinder and inside it, between its side and its ends."""
    cx, cy, cz, ax, ay, az = table.cx, table.cy, table.cz, table.ax, table.ay, table.az
    radius, half_height = table.hx, table.hz
    px, py, pz = lane.x - cx, lane.y - cy, lane.z - cz
    q, across, sine, cosine, height = seen_along_axis(px, py, pz, lane.ux, lane.uy, lane.uz, ax, ay, az)
    half, inverse = half_chord(radius, q), 1.0 / sine if sine > 0.0 else math.inf
    enters, leaves = (-half - across) * inverse, (half - across) * inverse
    leaves = leaves if q <= radius else -math.inf
    near, far = clip_to_slab(lane.start, lane.flight_end, height, cosine, half_height)
    near = enters if enters > near else near
    far = leaves if leaves < far else far
    lane.length_before, lane.length_inside = lengths_of_part(lane.start, near, far)


@separate_device
def walk_rings(lane, table, bin, t, end, weight, fade, keep):
    """Walk a flight through the rings of a cylinder: inwards as far as the ray hits them, then outwards.

    Returns the weight left. Rings and layers are crossed at distances computed from their numbers.
    """
    count, layers = table.cells_x, table.cells_z
    radii = view(lane.arena + table.radii, count + 1, np.float64)
    px, py, pz = lane.x - table.cx, lane.y - table.cy, lane.z - table.cz
    ax, ay, az = table.ax, table.ay, table.az
    q, across, sine, cosine, height = seen_along_axis(px, py, pz, lane.ux, lane.uy, lane.uz, ax, ay, az)
    inverse, now = 1.0 / sine if sine > 0.0 else 0.0, across + t * sine
    ring = shell_at(math.sqrt(q * q + now * now), count, lane.arena + table.radii)
    axis, layer, end_of_layer = enter_axis(
        height + table.hz, cosine, t, table.per_z, table.width_z, layers, 1
    )
    t_z = distance_of_face(axis, end_of_layer)
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
            weight = score_part(lane, table, ring * layers + layer, bin, length, weight, fade, keep)
            t = face
        if going:
            if face == t_r:
                ring += -1 if inwards else 1
            else:
                layer, end_of_layer = layer + axis[5], end_of_layer + axis[4]
                t_z = distance_of_face(axis, end_of_layer)
    return weight


@device
def walk(lane, table, bin, t, end, weight, fade, keep):
    """Walk through the cells of a volume from distance t on a flight to `end`; returns the weight left."""
    if table.is_one != 0:
        return score_part(lane, table, 0, bin, end - t, weight, fade, keep)
    if table.cells_z == 0:
        return walk_shells(lane, table, bin, t, end, weight, fade, keep)
    if table.radii != 0:
        return walk_rings(lane, table, bin, t, end, weight, fade, keep)
    return walk_voxels(lane, table, bin, t, end, weight, fade, keep)


@device
def is_inside(lane, table):
    """Return whether the flight has a part in the volume."""
    return lane.length_inside > 0.0


@lane_pass(layout.VOLUME, when=is_inside)
def walk_through_cells(lane, table):
    """Score the path through each cell of a volume detector."""
    weight, fade, keep = lane.weight, 0.0, 0.0
    if table.kept != 0:
        fade, keep = lane.path_absorption, lane.total_absorption
        weight *= exp_negative(-fade * lane.length_before)
    t = lane.start + lane.length_before
    walk(lane, table, direction_bin(lane, table), t, t + lane.length_inside, weight, fade, keep)


@device
def is_inside_in_grid(lane, table):
    """Return whether the flight has a part in the volume, and is in the grid."""
    return (lane.length_inside > 0.0) & (lane.medium == table.grid.medium)


@lane_pass(layout.VOLUME_IN_GRID, when=is_inside_in_grid)
def walk_through_grid(lane, table):
    """Score flights in an absorbing grid, voxel by voxel of the grid.

    Later passes skip these lanes (`length_inside` = 0).
    """
    grid, volume = table.grid, table.volume
    weight, t, entry = lane.weight, lane.start, lane.start + lane.length_before
    end = entry + lane.length_inside
    lane.length_inside = 0.0
    bin = direction_bin(lane, volume)
    axes, cell, faces = enter_grid(lane, grid)
    going = True
    while going:
        face = nearest_face(faces)
        going = face < end
        last = face if going else end
        keep = absorption_at(lane, grid, cell[0]) * grid.length
        fade = keep if table.fades != 0 else 0.0
        # Attenuate up to the volume; then score the part of this voxel in the volume.
        before = (entry if entry < last else last) - t
        if before > 0.0:
            weight *= exp_negative(-fade * before)
            t += before
        if last > t:
            weight = walk(lane, volume, bin, t, last, weight, fade, keep)
            t = last
        if going:
            cell, faces = next_cell(axes, cell, faces)


@lane_pass(layout.NO_TABLE)
def set_collision_paths(lane, table):
    """Set the mean free path, as `length_inside`, and the total absorption coefficient at collisions."""
    lane.length_inside = lane.mfp
    lane.total_absorption = lane.sigma_a + (1.0 - lane.survival) / lane.mfp


@lane_pass(layout.GRID)
def set_collision_paths_in_grid(lane, table):
    """Set mean free path and total absorption coefficient at collisions in a grid, from their voxel."""
    if (lane.collides != 0) & (lane.medium == table.medium):
        voxel = voxel_at(table, lane.x, lane.y, lane.z)
        keep = absorption_at(lane, table, voxel)
        sigma = scattering_at(lane, table, voxel) + keep
        lane.length_inside = 1.0 / (sigma * table.length) if sigma > 0.0 else 0.0
        lane.total_absorption = keep * table.length


@device
def score_collision(lane, table, number):
    """Score weight times mean free path at a collision in this cell (collision estimator)."""
    track, bin = lane.weight * lane.length_inside, direction_bin(lane, table)
    score_in_cell(lane, table, number, bin, track, lane.total_absorption, 1)


@device
def collides_in_box(lane, table):
    """Return whether a lane collides in the box."""
    dx, dy, dz = abs(lane.x - table.cx), abs(lane.y - table.cy), abs(lane.z - table.cz)
    return (lane.collides != 0) & (dx <= table.hx) & (dy <= table.hy) & (dz <= table.hz)


@lane_pass(layout.VOLUME, when=collides_in_box)
def score_collisions_in_box(lane, table):
    """Score weight times mean free path at each collision in a box (collision estimator)."""
    i = number_along(lane.x - table.cx + table.hx, table.per_x, table.cells_x)
    j = number_along(lane.y - table.cy + table.hy, table.per_y, table.cells_y)
    m = number_along(lane.z - table.cz + table.hz, table.per_z, table.cells_z)
    score_collision(lane, table, (i * table.cells_y + j) * table.cells_z + m)


@device
def collides_in_ball(lane, table):
    """Return whether a lane collides in the ball."""
    dx, dy, dz = lane.x - table.cx, lane.y - table.cy, lane.z - table.cz
    return (lane.collides != 0) & (dx * dx + dy * dy + dz * dz <= table.hx * table.hx)


@lane_pass(layout.VOLUME, when=collides_in_ball)
def score_collisions_in_ball(lane, table):
    """Score weight times mean free path at each collision in the shells of a ball."""
    dx, dy, dz = lane.x - table.cx, lane.y - table.cy, lane.z - table.cz
    shell = shell_at(math.sqrt(dx * dx + dy * dy + dz * dz), table.cells_x, lane.arena + table.radii)
    if shell >= 0:
        score_collision(lane, table, shell)


@lane_pass(layout.VOLUME)
def score_collisions_in_cylinder(lane, table):
    """Score weight times mean free path at each collision in the rings of a cylinder."""
    ax, ay, az, radius, half_height = table.ax, table.ay, table.az, table.hx, table.hz
    px, py, pz = lane.x - table.cx, lane.y - table.cy, lane.z - table.cz
    height = px * ax + py * ay + pz * az
    px, py, pz = px - height * ax, py - height * ay, pz - height * az
    rho = math.sqrt(px * px + py * py + pz * pz)
    if (lane.collides != 0) & (rho <= radius) & (abs(height) <= half_height):
        ring = shell_at(rho, table.cells_x, lane.arena + table.radii)
        layer = number_along(height + half_height, table.per_z, table.cells_z)
        score_collision(lane, table, ring * table.cells_z + layer)
