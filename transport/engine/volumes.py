"""Volume detectors: how far each flight goes within a box or a ball, cell by cell, and the collisions there.

A flight lasts from `start` to `reach`: to what it meets or collides with next, or to the end of the clock.  `clip_...` finds
the part of it in the volume, `score_...` counts a volume of one cell; what has cells or directions is walked through
flight by flight, from boundary to boundary, so that the parts add up to the whole and every step makes progress.

Lengths are counted in lengths of the volume, so that a score is 1 at most; what absorption keeps on the way, in weights.
"""

import math

import numpy as np
from numba import float64, int64

from transport.compile.layout import CLOCK, GRID, MEDIA, MEDIA_CLOCK, NO_TABLE, VOLUME, VOLUME_IN_GRID
from transport.engine.addresses import add_to_row, view
from transport.engine.grids import axis_of
from transport.engine.passes import lane_pass
from transport.engine.refinements import cell
from transport.engine.sums import limbs
from transport.physics.device import device
from transport.physics.elementary import TWO_PI, azimuth_turn, exp_negative, expm1_negative

A_SCORE = 1 << 28  # towards driver.MOST_SCORED, so that the low limbs stay in range as well


@lane_pass(NO_TABLE)
def reach_next(b, table, first, live):
    """As far as what is met next; what has ended goes nowhere."""
    for k in range(first, live):
        b.reach[k] = b.distance[k] if b.weight[k] != 0.0 else -math.inf
    return live


@lane_pass(NO_TABLE)
def reach_next_in_media(b, table, first, live):
    """The same in media, where some wait for the others; and what lessens weights there, and what is absorbed in all."""
    for k in range(first, live):
        flies = (b.flies[k] != 0) & (b.weight[k] != 0.0)
        b.reach[k] = b.distance[k] if flies else -math.inf
        b.fade[k] = b.sigma_a[k]
        b.keep[k] = b.sigma_a[k] + (1.0 - b.survival[k]) / b.mfp[k]
    return live


@lane_pass(CLOCK)
def reach_until_end(b, table, first, live):
    """No farther than until the clock stops, where all fly alike."""
    slowness = table.slowness
    for k in range(first, live):
        last = b.start[k] + (1.0 - b.time[k]) / slowness
        b.reach[k] = last if last < b.reach[k] else b.reach[k]
    return live


@lane_pass(NO_TABLE)
def reach_until_end_by_speed(b, table, first, live):
    """The same at its own speed."""
    for k in range(first, live):
        last = b.start[k] + (1.0 - b.time[k]) * b.speed[k]
        b.reach[k] = last if last < b.reach[k] else b.reach[k]
    return live


@lane_pass(MEDIA_CLOCK)
def reach_until_end_in_media(b, table, first, live):
    """The same in media, where light is slower by their index."""
    rows, slowness, has_speeds = view(table.rows, table.count, MEDIA), table.slowness, table.has_speeds != 0
    for k in range(first, live):
        pace = rows[b.medium[k]].index * slowness
        pace = 1.0 / b.speed[k] if has_speeds else pace
        last = b.start[k] + (1.0 - b.time[k]) / pace
        b.reach[k] = last if last < b.reach[k] else b.reach[k]
    return live


@device
def slab(o, u, half):
    """Where a ray enters and leaves the slab |x| <= half; along a face, or between them, it is always inside."""
    side, inverse = math.copysign(half, u), 1.0 / u
    near, far = (-side - o) * inverse, (side - o) * inverse
    return near if near == near else -math.inf, far if far == far else math.inf


@lane_pass(VOLUME)
def clip_to_box(b, table, first, live):
    """How far it flies before it is in the box, and how far within.  Slabs: Kay and Kajiya (1986)."""
    cx, cy, cz, hx, hy, hz = table.cx, table.cy, table.cz, table.hx, table.hy, table.hz
    for k in range(first, live):
        near_x, far_x = slab(b.x[k] - cx, b.ux[k], hx)
        near_y, far_y = slab(b.y[k] - cy, b.uy[k], hy)
        near_z, far_z = slab(b.z[k] - cz, b.uz[k], hz)
        start, near, far = b.start[k], b.start[k], b.reach[k]
        near = near_x if near_x > near else near
        near = near_y if near_y > near else near
        near = near_z if near_z > near else near
        far = far_x if far_x < far else far
        far = far_y if far_y < far else far
        far = far_z if far_z < far else far
        inside = near < far
        b.lead[k] = near - start if inside else 0.0
        b.within[k] = far - near if inside else 0.0
    return live


@lane_pass(VOLUME)
def clip_to_ball(b, table, first, live):
    """The same for a ball, told from the place nearest its centre, where a chord's halves are alike."""
    cx, cy, cz, radius = table.cx, table.cy, table.cz, table.hx
    for k in range(first, live):
        ox, oy, oz, ux, uy, uz = b.x[k] - cx, b.y[k] - cy, b.z[k] - cz, b.ux[k], b.uy[k], b.uz[k]
        h = ox * ux + oy * uy + oz * uz
        qx, qy, qz = ox - h * ux, oy - h * uy, oz - h * uz
        q = math.sqrt(qx * qx + qy * qy + qz * qz)
        d = (radius - q) * (radius + q)
        half = math.sqrt(d if d > 0.0 else 0.0)
        start, reach = b.start[k] + h, b.reach[k] + h
        near = start if start > -half else -half
        far = reach if reach < half else half
        inside = near < far
        b.lead[k] = near - start if inside else 0.0
        b.within[k] = far - near if inside else 0.0
    return live


@lane_pass(VOLUME)
def score_way(b, table, first, live):
    """Weight times way in a volume of one cell."""
    total_high, total_low, count, scale = 0, 0, 0, table.scale
    for k in range(first, live):
        way = b.within[k]
        inside = way > 0.0
        high, low = limbs(b.weight[k] * way * scale if inside else 0.0)
        total_high += high
        total_low += low
        count += 1 if inside else 0
    add_to_row(b.tallies + 32 * table.first, total_high, total_low, count, 0)
    b.scored += total_high + A_SCORE * count
    return live


@device
def mean_of_fading(depth):
    """The mean of exp(-s) over s from 0 to an optical depth, and exp(-depth) - 1, with all their digits near 0."""
    less = expm1_negative(-depth)
    return -less / depth if depth > 0.0 else 1.0, less


@lane_pass(VOLUME)
def score_way_in_media(b, table, first, live):
    """The same where media absorb: the mean weight on the way counts, and apart what is absorbed on it."""
    total_high, total_low, kept_high, kept_low, count, scale = 0, 0, 0, 0, 0, table.scale
    for k in range(first, live):
        way, fade = b.within[k], b.fade[k]
        inside = way > 0.0
        mean, _ = mean_of_fading(fade * way)
        track = b.weight[k] * exp_negative(-fade * b.lead[k]) * mean * way if inside else 0.0
        high, low = limbs(track * scale)
        total_high += high
        total_low += low
        high, low = limbs(track * b.keep[k] if inside else 0.0)
        kept_high += high
        kept_low += low
        count += 1 if inside else 0
    add_to_row(b.tallies + 32 * table.first, total_high, total_low, count, 0)
    add_to_row(b.tallies + 32 * table.kept, kept_high, kept_low, count, 0)
    b.scored += total_high + kept_high + A_SCORE * count
    return live


@device
def direction_bin(table, ux, uy, uz):
    """Which of a cell's rows a direction counts in: 0 without directions, and outside of their bins."""
    bin = 0
    if table.rows > 1:
        found, turn = cell(ux * table.nx + uy * table.ny + uz * table.nz, table.mu_cells, table.mu_edges), 0
        if table.turn_cells > 0:
            e_u = ux * table.eux + uy * table.euy + uz * table.euz
            e_v = ux * table.evx + uy * table.evy + uz * table.evz
            angle = azimuth_turn(e_u, e_v) * TWO_PI  # within a turn from the first edge
            if angle < table.turn_low:
                angle += TWO_PI
            elif angle >= table.turn_low + TWO_PI:
                angle -= TWO_PI
            turn = cell(angle, table.turn_cells, table.turn_edges)
        if (found >= 0) & (turn >= 0):
            bin = 1 + found * table.mu_stride + turn * table.turn_stride
    return bin


@device
def score_in_cell(b, table, number, bin, track, keep):
    """Add weight times way, in scene lengths, to a cell's rows."""
    high, low = limbs(track * table.scale)
    add_to_row(b.tallies + 32 * (table.first + number * table.rows + bin), high, low, 1, 0)
    b.scored += high + A_SCORE
    if table.kept != 0:
        high, low = limbs(track * keep)
        add_to_row(b.tallies + 32 * (table.kept + number), high, low, 1, 0)
        b.scored += high


@device
def score_part(b, table, number, bin, way, weight, fade, keep):
    """Score the way through one cell; returns the weight that is left behind it."""
    if table.kept == 0:
        score_in_cell(b, table, number, bin, weight * way, 0.0)
        return weight
    mean, less = mean_of_fading(fade * way)
    score_in_cell(b, table, number, bin, weight * way * mean, keep)
    return weight + weight * less


@device
def number_along(place, per_length, count):
    """The cell along one axis that holds a place, from the lower face."""
    number = int64(math.floor(place * per_length))
    return 0 if number < 0 else (count - 1 if number >= count else number)


@device
def next_face(place, number, u, inverse, width, count):
    """Where the ray leaves the cells of this number along one axis; never, beyond the last ones."""
    if u > 0.0:
        return (width * (number + 1) - place) * inverse if number + 1 < count else math.inf
    return (width * number - place) * inverse if (u < 0.0) & (number > 0) else math.inf


@device
def walk_voxels(b, table, k, bin, t, end, weight, fade, keep):
    """From face to face of the voxels that a flight comes through from t to end (Amanatides and Woo 1987).

    Each face's distance comes anew from its number: no rounding adds up.  Returns the weight that is left.
    """
    ux, uy, uz = b.ux[k], b.uy[k], b.uz[k]
    ix, iy, iz = 1.0 / ux, 1.0 / uy, 1.0 / uz
    px, py, pz = b.x[k] - table.cx + table.hx, b.y[k] - table.cy + table.hy, b.z[k] - table.cz + table.hz
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
        way = (face if going else end) - t
        if way > 0.0:  # there is none to a face that rounding has put behind
            number = (i * table.cells_y + j) * table.cells_z + m
            weight = score_part(b, table, number, bin, way, weight, fade, keep)
            t = face
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
    """The shell that holds a place at this distance of the centre; -1 within the first radius, the last one beyond all."""
    bounds = view(radii, count + 1, np.float64)
    found = cell(radius, count, radii)
    return (-1 if radius < bounds[0] else count - 1) if found < 0 else found


@device
def half_chord(radius, q):
    """Half the chord of a sphere at the distance q of its centre."""
    d = (radius - q) * (radius + q)
    return math.sqrt(d if d > 0.0 else 0.0)


@device
def walk_shells(b, table, k, bin, start, last, weight, fade, keep):
    """Inwards from sphere to sphere as far as the ray meets them, then outwards.  Returns the weight that is left."""
    count = table.cells_x
    radii = view(table.radii, count + 1, np.float64)
    ux, uy, uz = b.ux[k], b.uy[k], b.uz[k]
    ox, oy, oz = b.x[k] - table.cx, b.y[k] - table.cy, b.z[k] - table.cz
    h = ox * ux + oy * uy + oz * uz
    qx, qy, qz = ox - h * ux, oy - h * uy, oz - h * uz
    q = math.sqrt(qx * qx + qy * qy + qz * qz)
    t, end = start + h, last + h  # from the place nearest the centre
    shell = shell_at(math.sqrt(q * q + t * t), count, table.radii)
    going = True
    while going:
        inwards = (t < 0.0) & (shell >= 0)
        if inwards:
            inwards = radii[shell] > q
        if inwards:
            face = -half_chord(radii[shell], q)
        else:
            face = half_chord(radii[shell + 1], q) if shell + 1 < count else math.inf
        going = face < end
        way = (face if going else end) - t
        if way > 0.0:
            if shell >= 0:
                weight = score_part(b, table, shell, bin, way, weight, fade, keep)
            elif table.kept != 0:
                weight *= exp_negative(-fade * way)
            t = face
        if going:
            shell += -1 if inwards else 1
    return weight


@device
def walk(b, table, k, bin, t, end, weight, fade, keep):
    """Through the cells of a volume, from the distance t on a flight to `end`; returns the weight that is left."""
    if table.radii != 0:
        return walk_shells(b, table, k, bin, t, end, weight, fade, keep)
    return walk_voxels(b, table, k, bin, t, end, weight, fade, keep)


@lane_pass(VOLUME)
def walk_through_cells(b, table, first, live):
    """Count in each cell the way through it."""
    n = 0
    for k in range(first, live):  # no branch, so nothing to mispredict
        b.listed[n] = k
        n += 1 if b.within[k] > 0.0 else 0
    for item in range(n):
        k = b.listed[item]
        weight, fade, keep = b.weight[k], 0.0, 0.0
        if table.kept != 0:
            fade, keep = b.fade[k], b.keep[k]
            weight *= exp_negative(-fade * b.lead[k])
        bin = direction_bin(table, b.ux[k], b.uy[k], b.uz[k])
        t = b.start[k] + b.lead[k]
        walk(b, table, k, bin, t, t + b.within[k], weight, fade, keep)
    return live


@lane_pass(VOLUME_IN_GRID)
def walk_through_grid(b, table, first, live):
    """The same for what flies in a grid that absorbs, voxel by voxel of the grid; the passes behind pass these lanes over."""
    n, grid, volume = 0, table.grid, table.volume
    for k in range(first, live):
        b.listed[n] = k
        n += 1 if (b.within[k] > 0.0) & (b.medium[k] == grid.medium) else 0
    absorption = view(grid.absorption, grid.absorption_count, np.float64)
    for item in range(n):
        k = b.listed[item]
        weight, t, entry = b.weight[k], b.start[k], b.start[k] + b.lead[k]
        end = entry + b.within[k]
        b.within[k] = 0.0
        bin = direction_bin(volume, b.ux[k], b.uy[k], b.uz[k])
        vx, vy, vz = b.ux[k] * grid.per_x, b.uy[k] * grid.per_y, b.uz[k] * grid.per_z
        px, py = (b.x[k] - grid.cx) * grid.per_x, (b.y[k] - grid.cy) * grid.per_y
        pz = (b.z[k] - grid.cz) * grid.per_z
        i, step_x, face_x, ix = axis_of(px, vx, t, 1.0, grid.nx, float64(grid.nx))
        j, step_y, face_y, iy = axis_of(py, vy, t, 1.0, grid.ny, float64(grid.ny))
        m, step_z, face_z, iz = axis_of(pz, vz, t, 1.0, grid.nz, float64(grid.nz))
        t_x, t_y, t_z = (face_x - px) * ix, (face_y - py) * iy, (face_z - pz) * iz
        going = True
        while going:
            leaves = min(t_x, min(t_y, t_z))
            last = leaves if leaves < end else end
            here = i * grid.absorption_x + j * grid.absorption_y + m * grid.absorption_z
            keep = absorption[here] * grid.size
            fade = keep if table.fades != 0 else 0.0
            before = (entry if entry < last else last) - t
            if before > 0.0:
                weight *= exp_negative(-fade * before)
                t += before
            if last > t:
                weight = walk(b, volume, k, bin, t, last, weight, fade, keep)
                t = last
            going = leaves < end
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


@lane_pass(NO_TABLE)
def know_collisions(b, table, first, live):
    """The mean free path where it collides, and by what is absorbed there."""
    for k in range(first, live):
        b.within[k] = b.mfp[k]
        b.keep[k] = b.sigma_a[k] + (1.0 - b.survival[k]) / b.mfp[k]
    return live


@lane_pass(GRID)
def know_collisions_in_grid(b, table, first, live):
    """The same in a grid: in the voxel where it collides."""
    absorption = view(table.absorption, table.absorption_count, np.float64)
    scattering = view(table.scattering, table.scattering_count, np.float64)
    for k in range(first, live):
        if (b.collides[k] != 0) & (b.medium[k] == table.medium):
            i = number_along(b.x[k] - table.cx, table.per_x, table.nx)
            j = number_along(b.y[k] - table.cy, table.per_y, table.ny)
            m = number_along(b.z[k] - table.cz, table.per_z, table.nz)
            keep = absorption[i * table.absorption_x + j * table.absorption_y + m * table.absorption_z]
            sigma = (
                keep + scattering[i * table.scattering_x + j * table.scattering_y + m * table.scattering_z]
            )
            b.within[k] = 1.0 / (sigma * table.size) if sigma > 0.0 else 0.0
            b.keep[k] = keep * table.size
    return live


@lane_pass(VOLUME)
def score_collisions_in_box(b, table, first, live):
    """Weight times mean free path at each collision."""
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
        bin = direction_bin(table, b.ux[k], b.uy[k], b.uz[k])
        number = (i * table.cells_y + j) * table.cells_z + m
        score_in_cell(b, table, number, bin, b.weight[k] * b.within[k], b.keep[k])
    return live


@lane_pass(VOLUME)
def score_collisions_in_ball(b, table, first, live):
    """The same in the shells of a ball."""
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
            bin = direction_bin(table, b.ux[k], b.uy[k], b.uz[k])
            score_in_cell(b, table, shell, bin, b.weight[k] * b.within[k], b.keep[k])
    return live
