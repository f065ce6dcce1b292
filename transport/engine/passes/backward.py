"""Backward (adjoint) runs: histories start in the cells of a detector and score at sources, by cell.

A cell is a bin of position and direction, numbered by u, v, turn and mu, the last fastest. The bins of a
camera's pixels are its rows (turn) and columns (mu). Each cell gets equally many histories.
"""

import math

import numpy as np
from numba import int64, uint64

from transport.compile import layout
from transport.compile.layout import COLLISION_CLEARANCE
from transport.engine.bundle import add_to_row, view
from transport.engine.passes.detector_bins import PARALLEL, tangential_part
from transport.engine.passes.volumes import SCORE_BOUND, mean_transmittance
from transport.engine.registry import lane_pass
from transport.engine.tally import hash_salt, hashed_uniform, unbiased_limbs
from transport.physics.bits import bits_of
from transport.physics.device import device
from transport.physics.directions import from_frame, select, turned_by
from transport.physics.elementary import cos_sin_turn, exp_negative
from transport.physics.streams import DIRECTION, POSITION, SHARES, random_words, uniform

SLANT_UNITS = 1 << 22  # units of a slant of 1


@lane_pass(layout.SENSOR)
def assign_cells(b, table, first, live):
    """Assign cells in turn, from a random one on: per batch each has equally many histories, or one more.

    Fields: reads `history`; writes `cell`.
    """
    w0, w1, _, _ = random_words(table.part, b.batch, 1, SHARES, b.seed_low, b.seed_high)
    cells = uint64(table.cells)
    offset = ((w0 << uint64(32)) | w1) % cells
    for k in range(first, live):
        cell = table.first + int64((uint64(b.history[k]) + offset) % cells)
        b.cell[k] = cell
        add_to_row(b.tallies + 32 * (table.births + cell), 0, 0, 1, 0)
    return live


@lane_pass(layout.NO_TABLE)
def draw_place(b, table, first, live):
    """Draw the uniforms u0, u1 for a position in a cell.

    Fields: reads `history`; writes `u0`, `u1`.
    """
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, POSITION, seed_low, seed_high)
        b.u0[k], b.u1[k] = uniform(w0, w1), uniform(w2, w3)
    return live


@lane_pass(layout.NO_TABLE)
def draw_direction(b, table, first, live):
    """Draw the uniforms u2, u3 for a direction in a cell.

    Fields: reads `history`; writes `u2`, `u3`.
    """
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, DIRECTION, seed_low, seed_high)
        b.u2[k], b.u3[k] = uniform(w0, w1), uniform(w2, w3)
    return live


@device
def coordinate_in_bin(edges, cells, number, u):
    """Return the coordinate at share u of a bin."""
    bounds = view(edges, cells + 1, np.float64)
    return bounds[number] + u * (bounds[number + 1] - bounds[number])


@lane_pass(layout.SENSOR)
def place_in_cell(b, table, first, live):
    """Set the two coordinates, uniform in area, within the cell's bin of position.

    Fields: reads `cell`; updates `u0`, `u1`.
    """
    for k in range(first, live):
        number = (b.cell[k] - table.first) // (table.mu_cells * table.turn_cells)
        b.u0[k] = coordinate_in_bin(table.u_edges, table.u_cells, number // table.v_cells, b.u0[k])
        b.u1[k] = coordinate_in_bin(table.v_edges, table.v_cells, number % table.v_cells, b.u1[k])
    return live


@lane_pass(layout.SENSOR)
def direction_in_cell(b, table, first, live):
    """Set the two coordinates, uniform in their measure, within the cell's bin of direction.

    Fields: reads `cell`; updates `u2`, `u3`.
    """
    for k in range(first, live):
        number = (b.cell[k] - table.first) % (table.mu_cells * table.turn_cells)
        b.u2[k] = coordinate_in_bin(table.mu_edges, table.mu_cells, number % table.mu_cells, b.u2[k])
        b.u3[k] = coordinate_in_bin(table.turn_edges, table.turn_cells, number // table.mu_cells, b.u3[k])
    return live


@lane_pass(layout.SENSOR)
def hemisphere_direction_in_cell(b, table, first, live):
    """Set squared cosine, squared sine and turn within the cell's bin.

    The sine is computed apart because it keeps its digits near the normal.

    Fields: reads `cell`; updates `u2`, `u3`; writes `u4`.
    """
    for k in range(first, live):
        number = (b.cell[k] - table.first) % (table.mu_cells * table.turn_cells)
        column, u = number % table.mu_cells, b.u2[k]
        b.u2[k] = coordinate_in_bin(table.mu_edges, table.mu_cells, column, u)
        b.u4[k] = coordinate_in_bin(table.sine_edges, table.mu_cells, column, u)
        b.u3[k] = coordinate_in_bin(table.turn_edges, table.turn_cells, number // table.mu_cells, b.u3[k])
    return live


@device
def positive_turn(turn):
    """Return a turn in [-1, 1) as one in [0, 1)."""
    return turn + 1.0 if turn < 0.0 else turn


@lane_pass(layout.SENSOR)
def start_on_rectangle(b, table, first, live):
    """Set the position on a rectangle from its lengths u0, u1.

    Fields: reads `u0`, `u1`; writes `x, y, z`.
    """
    cx, cy, cz, eux, euy, euz = table.cx, table.cy, table.cz, table.eux, table.euy, table.euz
    evx, evy, evz = table.evx, table.evy, table.evz
    for k in range(first, live):
        u, v = b.u0[k], b.u1[k]
        b.x[k], b.y[k], b.z[k] = cx + u * eux + v * evx, cy + u * euy + v * evy, cz + u * euz + v * evz
    return live


@lane_pass(layout.SENSOR)
def start_on_disk(b, table, first, live):
    """Set the position on a disk from squared radius u0 and azimuth u1.

    Fields: reads `u0`, `u1`; writes `x, y, z`.
    """
    cx, cy, cz, eux, euy, euz = table.cx, table.cy, table.cz, table.eux, table.euy, table.euz
    evx, evy, evz = table.evx, table.evy, table.evz
    for k in range(first, live):
        c, s = cos_sin_turn(positive_turn(b.u1[k]))
        radius = math.sqrt(b.u0[k])
        u, v = radius * c, radius * s
        b.x[k], b.y[k], b.z[k] = cx + u * eux + v * evx, cy + u * euy + v * evy, cz + u * euz + v * evz
    return live


@lane_pass(layout.SENSOR)
def start_on_sphere(b, table, first, live):
    """Set position and normal on a sphere from the cosine to its axis u0 and the azimuth u1 (Archimedes).

    Fields: reads `u0`, `u1`; writes `x, y, z`, `nx, ny, nz`.
    """
    cx, cy, cz, eux, euy, euz = table.cx, table.cy, table.cz, table.eux, table.euy, table.euz
    evx, evy, evz, ax, ay, az = table.evx, table.evy, table.evz, table.nx, table.ny, table.nz
    radius, side = table.radius, table.side
    for k in range(first, live):
        w = b.u0[k]
        c, s = cos_sin_turn(positive_turn(b.u1[k]))
        sine = math.sqrt((1.0 - w) * (1.0 + w))
        u, v = sine * c, sine * s
        nx, ny, nz = from_frame(u, v, w, eux, euy, euz, evx, evy, evz, ax, ay, az)
        b.x[k], b.y[k], b.z[k] = cx + radius * nx, cy + radius * ny, cz + radius * nz
        b.nx[k], b.ny[k], b.nz[k] = side * nx, side * ny, side * nz
    return live


@lane_pass(layout.SENSOR)
def cosine_law_from_plane(b, table, first, live):
    """Set a direction by the cosine law within the cell's bin, for one common normal.

    Fields: reads `u2`, `u3`, `u4`; writes `ux, uy, uz`.
    """
    side, handed = table.side, table.handed
    nx, ny, nz = side * table.nx, side * table.ny, side * table.nz
    eux, euy, euz = handed * table.eux, handed * table.euy, handed * table.euz
    evx, evy, evz = table.evx, table.evy, table.evz
    for k in range(first, live):
        mu, sine = math.sqrt(b.u2[k]), math.sqrt(b.u4[k])
        c, s = cos_sin_turn(positive_turn(b.u3[k]))
        c, s = c * sine, s * sine
        b.ux[k], b.uy[k], b.uz[k] = from_frame(c, s, mu, eux, euy, euz, evx, evy, evz, nx, ny, nz)
    return live


@lane_pass(layout.SENSOR)
def cosine_law_from_surface(b, table, first, live):
    """Set a direction by the cosine law about the local normal; e_v is the projected axis of the shape.

    Fields: reads `nx, ny, nz`, `u2`, `u3`, `u4`; writes `ux, uy, uz`.
    """
    ax, ay, az, ox, oy, oz = table.nx, table.ny, table.nz, table.evx, table.evy, table.evz
    for k in range(first, live):
        mu, sine = math.sqrt(b.u2[k]), math.sqrt(b.u4[k])
        c, s = cos_sin_turn(positive_turn(b.u3[k]))
        c, s = c * sine, s * sine
        nx, ny, nz = b.nx[k], b.ny[k], b.nz[k]
        evx, evy, evz = tangential_part(ax, ay, az, nx, ny, nz)
        qx, qy, qz = tangential_part(ox, oy, oz, nx, ny, nz)  # at the pole of a sphere
        upright = evx * evx + evy * evy + evz * evz >= PARALLEL
        evx, evy, evz = select(upright, evx, evy, evz, qx, qy, qz)
        scale = 1.0 / math.sqrt(evx * evx + evy * evy + evz * evz)
        evx, evy, evz = evx * scale, evy * scale, evz * scale
        eux, euy, euz = evy * nz - evz * ny, evz * nx - evx * nz, evx * ny - evy * nx
        b.ux[k], b.uy[k], b.uz[k] = from_frame(c, s, mu, eux, euy, euz, evx, evy, evz, nx, ny, nz)
    return live


@lane_pass(layout.SENSOR)
def uniform_direction(b, table, first, live):
    """Set a direction from its cosine to +z and azimuth: uniform in solid angle.

    Fields: reads `u2`, `u3`; writes `ux, uy, uz`.
    """
    for k in range(first, live):
        mu = b.u2[k]
        c, s = cos_sin_turn(positive_turn(b.u3[k]))
        sine = math.sqrt((1.0 - mu) * (1.0 + mu))
        b.ux[k], b.uy[k], b.uz[k] = sine * c, sine * s, mu
    return live


@lane_pass(layout.SENSOR)
def direction_in_cone(b, table, first, live):
    """Set a direction uniform in the solid angle of a cone: 1 - cos uniform up to `spread`.

    Fields: reads `u2`, `u3`; writes `ux, uy, uz`.
    """
    ax, ay, az, spread = table.axis_x, table.axis_y, table.axis_z, table.spread
    for k in range(first, live):
        less = spread * b.u2[k]
        sine = math.sqrt(less * (2.0 - less))
        c, s = cos_sin_turn(b.u3[k])
        b.ux[k], b.uy[k], b.uz[k] = turned_by(ax, ay, az, 1.0 - less, sine * c, sine * s)
    return live


@lane_pass(layout.SENSOR)
def direction_through_pixel(b, table, first, live):
    """Set the direction through a point of the image plane at distance 1.

    Fields: reads `u2`, `u3`; writes `ux, uy, uz`.
    """
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    nx, ny, nz = table.nx, table.ny, table.nz
    for k in range(first, live):
        u, v = b.u2[k], b.u3[k]
        mu = 1.0 / math.sqrt(1.0 + u * u + v * v)
        u, v = mu * u, mu * v
        b.ux[k], b.uy[k], b.uz[k] = from_frame(u, v, mu, eux, euy, euz, evx, evy, evz, nx, ny, nz)
    return live


@lane_pass(layout.SENSOR)
def weigh_pixel(b, table, first, live):
    """Weight by solid angle per area of the image plane, cos^3: the mean is per solid angle.

    Fields: reads `ux, uy, uz`; updates `weight`.
    """
    nx, ny, nz = table.nx, table.ny, table.nz
    for k in range(first, live):
        mu = b.ux[k] * nx + b.uy[k] * ny + b.uz[k] * nz
        b.weight[k] *= mu * mu * mu
    return live


@lane_pass(layout.SENSOR)
def weigh_by_plane(b, table, first, live):
    """Weight uniform directions by their cosine to the side; 0 below its horizon.

    Fields: reads `ux, uy, uz`; updates `weight`.
    """
    nx, ny, nz = table.side * table.nx, table.side * table.ny, table.side * table.nz
    for k in range(first, live):
        mu = b.ux[k] * nx + b.uy[k] * ny + b.uz[k] * nz
        b.weight[k] *= mu if mu > 0.0 else 0.0
    return live


@lane_pass(layout.SENSOR)
def weigh_by_surface(b, table, first, live):
    """Weight directions by their cosine to the local normal; 0 below the surface.

    Fields: reads `ux, uy, uz`, `nx, ny, nz`; updates `weight`.
    """
    for k in range(first, live):
        mu = b.ux[k] * b.nx[k] + b.uy[k] * b.ny[k] + b.uz[k] * b.nz[k]
        b.weight[k] *= mu if mu > 0.0 else 0.0
    return live


@lane_pass(layout.LAYERS)
def refine_by_cell(b, table, first, live):
    """Score arrivals at a source, by flights or next-event rays, in the row of the cell of birth.

    No departures.

    No reading needs weight/|mu| of these rows: their slant counts the rays that are among the strongest.

    Fields: reads `weight`, `cell`, `detector_row`, `detector_index`; updates `bin`; writes `slant`.
    """
    detectors, half = view(table.detectors, table.detector_count, layout.DETECTOR), table.half
    for k in range(first, live):
        m, is_flight = detectors[b.detector_index[k]], b.detector_row[k] < half
        arrives = is_flight | ((b.detector_row[k] >= 2 * half) & (b.detector_row[k] < 3 * half))
        row = (m.by_cell if is_flight else m.of_rays) + b.cell[k]
        b.bin[k] = row if (b.bin[k] != 0) & arrives else 0
        b.slant[k] = 0 if is_flight | (b.weight[k] < m.strong) else SLANT_UNITS
    return live


@lane_pass(layout.VOLUME)
def score_path_by_cell(b, table, first, live):
    """Score weight times path length in a source that fills a volume, by cell of birth.

    Fields: reads `weight`, `history`, `cell`, `length_inside`; updates `scored`.
    """
    total, scale, salt = 0, table.scale, hash_salt(b.seed_low, b.batch)
    for k in range(first, live):
        length = b.length_inside[k]
        if length > 0.0:
            chance = hashed_uniform(bits_of(length), salt + b.history[k])
            high, low = unbiased_limbs(b.weight[k] * length * scale, chance)
            seen = 1 if length > COLLISION_CLEARANCE else 0  # paths left by rounding alone do not count
            add_to_row(b.tallies + 32 * (table.first + b.cell[k]), high, low, seen, 0)
            total += high
    b.scored += total + SCORE_BOUND * int64(live - first)
    return live


@lane_pass(layout.VOLUME)
def score_path_by_cell_in_media(b, table, first, live):
    """Score the mean weight along a path times its length by cell of birth, where media absorb.

    Fields: reads `weight`, `history`, `cell`, `length_before`, `length_inside`, `path_absorption`; updates
    `scored`.
    """
    total, scale, salt = 0, table.scale, hash_salt(b.seed_low, b.batch)
    for k in range(first, live):
        length, fade = b.length_inside[k], b.path_absorption[k]
        if length > 0.0:
            mean, _ = mean_transmittance(fade * length)
            track = b.weight[k] * exp_negative(-fade * b.length_before[k]) * mean * length
            high, low = unbiased_limbs(track * scale, hashed_uniform(bits_of(length), salt + b.history[k]))
            seen = 1 if length > COLLISION_CLEARANCE else 0
            add_to_row(b.tallies + 32 * (table.first + b.cell[k]), high, low, seen, 0)
            total += high
    b.scored += total + SCORE_BOUND * int64(live - first)
    return live
