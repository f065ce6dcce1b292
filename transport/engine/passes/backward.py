"""Backward (adjoint) runs: histories start in the cells of a detector and score at sources, by cell.

A cell is a bin of position and direction, numbered by u, v, turn and mu, the last fastest. The bins of a
camera's pixels are its rows (turn) and columns (mu). Each cell gets equally many histories.
"""

import math

import numpy as np
from numba import int64, uint64

from transport.compile import layout
from transport.compile.layout import COLLISION_CLEARANCE
from transport.engine.bodies import lane_pass
from transport.engine.bundle import add_to_row, view
from transport.engine.passes.detector_bins import PARALLEL, tangential_part
from transport.engine.passes.shadow_rays import SCORE_BOUND as RAY_BOUND
from transport.engine.passes.shadow_rays import reaches_point
from transport.engine.passes.volumes import SCORE_BOUND, mean_transmittance
from transport.engine.tally import hash_salt, hashed_uniform_of_one, to_scored, unbiased_limbs_of_one
from transport.engine.words import birth_block, words_of_block
from transport.physics.bits import bits_of
from transport.physics.device import device
from transport.physics.directions import from_frame, select, turned_by
from transport.physics.elementary import cos_sin_turn, exp_negative
from transport.physics.streams import DIRECTION, POSITION, SHARES, random_words, uniform

INVERSE_TURN = 1.0 / (2.0 * math.pi)
SLANT_UNITS = 1 << 22  # units of a slant of 1
# Bound of the score of a ray to a Point. Those from the nearest walls are about 1, and only light scattered
# within a millionth of their distance exceeds it: a share of 1e-12.
MAX_LAMP_SCORE = 2.0**20


@lane_pass(layout.SENSOR)
def assign_cells(lane, table):
    """Assign cells in turn, from a random one on: per batch each has equally many histories, or one more."""
    w0, w1, _, _ = random_words(table.part, lane.batch, 1, SHARES, lane.seed_low, lane.seed_high)
    cells = uint64(table.cells)
    offset = ((w0 << uint64(32)) | w1) % cells
    cell = table.first + int64((uint64(lane.history) + offset) % cells)
    lane.cell = cell
    add_to_row(lane.tallies + 32 * (table.births + cell), 0, 0, 1, 0)


@lane_pass(layout.NO_TABLE, before=birth_block(POSITION))
def draw_place(lane, table):
    """Draw the uniforms u0, u1 for a position in a cell."""
    w0, w1, w2, w3 = words_of_block(lane)
    lane.u0, lane.u1 = uniform(w0, w1), uniform(w2, w3)


@lane_pass(layout.NO_TABLE, before=birth_block(DIRECTION))
def draw_direction(lane, table):
    """Draw the uniforms u2, u3 for a direction in a cell."""
    w0, w1, w2, w3 = words_of_block(lane)
    lane.u2, lane.u3 = uniform(w0, w1), uniform(w2, w3)


@device
def coordinate_in_bin(edges, cells, number, u):
    """Return the coordinate at share u of a bin."""
    bounds = view(edges, cells + 1, np.float64)
    return bounds[number] + u * (bounds[number + 1] - bounds[number])


@lane_pass(layout.SENSOR)
def place_in_cell(lane, table):
    """Set the two coordinates, uniform in area, within the cell's bin of position."""
    number = (lane.cell - table.first) // (table.mu_cells * table.turn_cells)
    lane.u0 = coordinate_in_bin(lane.arena + table.u_edges, table.u_cells, number // table.v_cells, lane.u0)
    lane.u1 = coordinate_in_bin(lane.arena + table.v_edges, table.v_cells, number % table.v_cells, lane.u1)


@lane_pass(layout.SENSOR)
def direction_in_cell(lane, table):
    """Set the two coordinates, uniform in their measure, within the cell's bin of direction."""
    number = (lane.cell - table.first) % (table.mu_cells * table.turn_cells)
    lane.u2 = coordinate_in_bin(lane.arena + table.mu_edges, table.mu_cells, number % table.mu_cells, lane.u2)
    lane.u3 = coordinate_in_bin(
        lane.arena + table.turn_edges, table.turn_cells, number // table.mu_cells, lane.u3
    )


@lane_pass(layout.SENSOR)
def hemisphere_direction_in_cell(lane, table):
    """Set squared cosine, squared sine and turn within the cell's bin.

    The sine is computed apart because it keeps its digits near the normal.
    """
    number = (lane.cell - table.first) % (table.mu_cells * table.turn_cells)
    column, u = number % table.mu_cells, lane.u2
    lane.u2 = coordinate_in_bin(lane.arena + table.mu_edges, table.mu_cells, column, u)
    lane.u4 = coordinate_in_bin(lane.arena + table.sine_edges, table.mu_cells, column, u)
    lane.u3 = coordinate_in_bin(
        lane.arena + table.turn_edges, table.turn_cells, number // table.mu_cells, lane.u3
    )


@device
def positive_turn(turn):
    """Return a turn in [-1, 1) as one in [0, 1)."""
    return turn + 1.0 if turn < 0.0 else turn


@lane_pass(layout.SENSOR)
def start_on_rectangle(lane, table):
    """Set the position on a rectangle from its lengths u0, u1."""
    cx, cy, cz, eux, euy, euz = table.cx, table.cy, table.cz, table.eux, table.euy, table.euz
    evx, evy, evz = table.evx, table.evy, table.evz
    u, v = lane.u0, lane.u1
    lane.x, lane.y, lane.z = cx + u * eux + v * evx, cy + u * euy + v * evy, cz + u * euz + v * evz


@lane_pass(layout.SENSOR)
def start_on_disk(lane, table):
    """Set the position on a disk from squared radius u0 and azimuth u1."""
    cx, cy, cz, eux, euy, euz = table.cx, table.cy, table.cz, table.eux, table.euy, table.euz
    evx, evy, evz = table.evx, table.evy, table.evz
    c, s = cos_sin_turn(positive_turn(lane.u1))
    radius = math.sqrt(lane.u0)
    u, v = radius * c, radius * s
    lane.x, lane.y, lane.z = cx + u * eux + v * evx, cy + u * euy + v * evy, cz + u * euz + v * evz


@lane_pass(layout.SENSOR)
def start_on_sphere(lane, table):
    """Set position and normal on a sphere from the cosine to its axis u0 and the azimuth u1 (Archimedes)."""
    cx, cy, cz, eux, euy, euz = table.cx, table.cy, table.cz, table.eux, table.euy, table.euz
    evx, evy, evz, ax, ay, az = table.evx, table.evy, table.evz, table.nx, table.ny, table.nz
    radius, side = table.radius, table.side
    w = lane.u0
    c, s = cos_sin_turn(positive_turn(lane.u1))
    sine = math.sqrt((1.0 - w) * (1.0 + w))
    u, v = sine * c, sine * s
    nx, ny, nz = from_frame(u, v, w, eux, euy, euz, evx, evy, evz, ax, ay, az)
    lane.x, lane.y, lane.z = cx + radius * nx, cy + radius * ny, cz + radius * nz
    lane.nx, lane.ny, lane.nz = side * nx, side * ny, side * nz


@lane_pass(layout.SENSOR)
def cosine_law_from_plane(lane, table):
    """Set a direction by the cosine law within the cell's bin, for one common normal."""
    side, handed = table.side, table.handed
    nx, ny, nz = side * table.nx, side * table.ny, side * table.nz
    eux, euy, euz = handed * table.eux, handed * table.euy, handed * table.euz
    evx, evy, evz = table.evx, table.evy, table.evz
    mu, sine = math.sqrt(lane.u2), math.sqrt(lane.u4)
    c, s = cos_sin_turn(positive_turn(lane.u3))
    c, s = c * sine, s * sine
    lane.ux, lane.uy, lane.uz = from_frame(c, s, mu, eux, euy, euz, evx, evy, evz, nx, ny, nz)


@lane_pass(layout.SENSOR)
def cosine_law_from_surface(lane, table):
    """Set a direction by the cosine law about the local normal; e_v is the projected axis of the shape."""
    ax, ay, az, ox, oy, oz = table.nx, table.ny, table.nz, table.evx, table.evy, table.evz
    mu, sine = math.sqrt(lane.u2), math.sqrt(lane.u4)
    c, s = cos_sin_turn(positive_turn(lane.u3))
    c, s = c * sine, s * sine
    nx, ny, nz = lane.nx, lane.ny, lane.nz
    evx, evy, evz = tangential_part(ax, ay, az, nx, ny, nz)
    qx, qy, qz = tangential_part(ox, oy, oz, nx, ny, nz)  # at the pole of a sphere
    upright = evx * evx + evy * evy + evz * evz >= PARALLEL
    evx, evy, evz = select(upright, evx, evy, evz, qx, qy, qz)
    scale = 1.0 / math.sqrt(evx * evx + evy * evy + evz * evz)
    evx, evy, evz = evx * scale, evy * scale, evz * scale
    eux, euy, euz = evy * nz - evz * ny, evz * nx - evx * nz, evx * ny - evy * nx
    lane.ux, lane.uy, lane.uz = from_frame(c, s, mu, eux, euy, euz, evx, evy, evz, nx, ny, nz)


@lane_pass(layout.SENSOR)
def uniform_direction(lane, table):
    """Set a direction from its cosine to +z and azimuth: uniform in solid angle."""
    mu = lane.u2
    c, s = cos_sin_turn(positive_turn(lane.u3))
    sine = math.sqrt((1.0 - mu) * (1.0 + mu))
    lane.ux, lane.uy, lane.uz = sine * c, sine * s, mu


@lane_pass(layout.SENSOR)
def direction_in_cone(lane, table):
    """Set a direction uniform in the solid angle of a cone: 1 - cos uniform up to `spread`."""
    ax, ay, az, spread = table.axis_x, table.axis_y, table.axis_z, table.spread
    less = spread * lane.u2
    sine = math.sqrt(less * (2.0 - less))
    c, s = cos_sin_turn(lane.u3)
    lane.ux, lane.uy, lane.uz = turned_by(ax, ay, az, 1.0 - less, sine * c, sine * s)


@lane_pass(layout.SENSOR)
def direction_through_pixel(lane, table):
    """Set the direction through a point of the image plane at distance 1."""
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    nx, ny, nz = table.nx, table.ny, table.nz
    u, v = lane.u2, lane.u3
    mu = 1.0 / math.sqrt(1.0 + u * u + v * v)
    u, v = mu * u, mu * v
    lane.ux, lane.uy, lane.uz = from_frame(u, v, mu, eux, euy, euz, evx, evy, evz, nx, ny, nz)


@lane_pass(layout.SENSOR)
def weigh_pixel(lane, table):
    """Weight by solid angle per area of the image plane, cos^3: the mean is per solid angle."""
    nx, ny, nz = table.nx, table.ny, table.nz
    mu = lane.ux * nx + lane.uy * ny + lane.uz * nz
    lane.weight *= mu * mu * mu


@lane_pass(layout.SENSOR)
def direction_in_round_image(lane, table):
    """Set a place in the cell's pixel within the rim of the image, and what share of the pixel it stands for.

    The row is uniform where the pixel lies within the rim, and the column on the chord there. A pixel beyond
    the rim has the share 0.
    """
    number, rim = (lane.cell - table.first) % (table.mu_cells * table.turn_cells), table.rim
    columns = view(lane.arena + table.mu_edges, table.mu_cells + 1, np.float64)
    rows = view(lane.arena + table.turn_edges, table.turn_cells + 1, np.float64)
    column, row = number % table.mu_cells, number // table.mu_cells
    left, right, low, high = columns[column], columns[column + 1], rows[row], rows[row + 1]
    nearest = max(max(left, -right), 0.0)
    reach = math.sqrt(max(rim * rim - nearest * nearest, 0.0))
    first, last = max(low, -reach), min(high, reach)
    v = first + lane.u3 * (last - first)
    chord = math.sqrt(max(rim * rim - v * v, 0.0))
    start, stop = max(left, -chord), min(right, chord)
    share = max(last - first, 0.0) * max(stop - start, 0.0) / ((high - low) * (right - left))
    lane.u4 = share if nearest < rim else 0.0
    lane.u2, lane.u3 = start + lane.u2 * (stop - start), v


@lane_pass(layout.SENSOR)
def direction_through_fisheye(lane, table):
    """Set the direction at the polar angle that is the distance from the middle of the image."""
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    nx, ny, nz = table.nx, table.ny, table.nz
    u, v = lane.u2, lane.u3
    radius = math.sqrt(u * u + v * v)
    mu, sine = cos_sin_turn(min(radius * INVERSE_TURN, 0.5))
    aside = sine / radius if radius > 0.0 else 1.0
    lane.u4 *= aside
    u, v = aside * u, aside * v
    lane.ux, lane.uy, lane.uz = from_frame(u, v, mu, eux, euy, euz, evx, evy, evz, nx, ny, nz)


@lane_pass(layout.SENSOR)
def direction_through_equal_area(lane, table):
    """Set the direction at the distance 2 sin(theta/2) from the middle of the image."""
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    nx, ny, nz = table.nx, table.ny, table.nz
    u, v = lane.u2, lane.u3
    square = min(0.25 * (u * u + v * v), 1.0)  # sin^2(theta/2)
    aside = math.sqrt(1.0 - square)
    u, v, mu = aside * u, aside * v, 1.0 - 2.0 * square
    lane.ux, lane.uy, lane.uz = from_frame(u, v, mu, eux, euy, euz, evx, evy, evz, nx, ny, nz)


@lane_pass(layout.SENSOR)
def weigh_round_image(lane, table):
    """Weight by the share of the pixel, and by solid angle per area, sin(theta)/theta of a fisheye.

    Histories beyond the rim end.
    """
    lane.weight *= lane.u4


@lane_pass(layout.SENSOR)
def direction_through_cube(lane, table):
    """Set the direction through a face of a cube about the point: +x, -x, +y, -y, +z, -z.

    Images are upright along +z, those of the last two along +y.
    """
    per_face = float(table.mu_cells * table.turn_cells)
    face = math.floor((float(lane.cell - table.first) + 0.5) / per_face)  # in floats, which are vectorised
    odd = face - 2.0 * math.floor(0.5 * face)
    ahead = 1.0 - 2.0 * odd
    u, v = lane.u2, lane.u3
    mu = 1.0 / math.sqrt(1.0 + u * u + v * v)
    right, up, along = mu * u, mu * v, mu * ahead
    is_x, is_z = face < 2.0, face >= 4.0
    turned = ahead * right
    lane.ux = along if is_x else (-turned if is_z else turned)
    lane.uy = -turned if is_x else (up if is_z else along)
    lane.uz = along if is_z else up


@lane_pass(layout.SENSOR)
def weigh_cube(lane, table):
    """Weight by solid angle per area of a face of the cube, cos^3."""
    u, v = lane.u2, lane.u3
    square = 1.0 / (1.0 + u * u + v * v)
    lane.weight *= square * math.sqrt(square)


@lane_pass(layout.SENSOR)
def direction_of_view(lane, table):
    """Set the line of sight as the direction."""
    lane.ux, lane.uy, lane.uz = table.nx, table.ny, table.nz


@device
def offset_in_plane(lane, table):
    """Return the place on a lens or a near plane, along e_u and e_v from its middle."""
    x, y, z = lane.x - table.cx, lane.y - table.cy, lane.z - table.cz
    u = x * table.eux + y * table.euy + z * table.euz
    v = x * table.evx + y * table.evy + z * table.evz
    return u, v


@lane_pass(layout.SENSOR)
def direction_to_plane(lane, table):
    """Set the direction from a place on a lens to a point of the plane in focus, seen from its middle.

    table.nearness: one over the distance of that plane.
    """
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    nx, ny, nz, nearness = table.nx, table.ny, table.nz, table.nearness
    a, b = offset_in_plane(lane, table)
    u, v = lane.u2 - nearness * a, lane.u3 - nearness * b
    mu = 1.0 / math.sqrt(1.0 + u * u + v * v)
    u, v = mu * u, mu * v
    lane.ux, lane.uy, lane.uz = from_frame(u, v, mu, eux, euy, euz, evx, evy, evz, nx, ny, nz)


@lane_pass(layout.SENSOR)
def weigh_lens(lane, table):
    """Weight by cos^4 of the line from the film to the place on the lens; of the ray itself without power.

    table.power: one over the focal length.
    """
    power, nearness = table.power, table.nearness
    a, b = offset_in_plane(lane, table)
    u, v = lane.u2 + (power - nearness) * a, lane.u3 + (power - nearness) * b
    square = 1.0 / (1.0 + u * u + v * v)
    lane.weight *= square * square


@lane_pass(layout.SENSOR)
def weigh_by_plane(lane, table):
    """Weight uniform directions by their cosine to the side; 0 below its horizon."""
    nx, ny, nz = table.side * table.nx, table.side * table.ny, table.side * table.nz
    mu = lane.ux * nx + lane.uy * ny + lane.uz * nz
    lane.weight *= mu if mu > 0.0 else 0.0


@lane_pass(layout.SENSOR)
def weigh_by_surface(lane, table):
    """Weight directions by their cosine to the local normal; 0 below the surface."""
    mu = lane.ux * lane.nx + lane.uy * lane.ny + lane.uz * lane.nz
    lane.weight *= mu if mu > 0.0 else 0.0


@lane_pass(layout.LAYERS)
def refine_by_cell(lane, table):
    """Score arrivals at a source, by flights or next-event rays, in the row of the cell of birth.

    No departures.

    No reading needs weight/|mu| of these rows: their slant counts the rays that are among the strongest.
    """
    detectors, half = view(lane.arena + table.detectors, table.detector_count, layout.DETECTOR), table.half
    m, is_flight = detectors[lane.detector_index], lane.detector_row < half
    arrives = is_flight | ((lane.detector_row >= 2 * half) & (lane.detector_row < 3 * half))
    row = (m.by_cell if is_flight else m.of_rays) + lane.cell
    lane.bin = row if (lane.bin != 0) & arrives else 0
    lane.slant = 0 if is_flight | (lane.weight < m.strong) else SLANT_UNITS


@device
def score_ray(lane, row, least):
    """Score a shadow ray in a row; its slant counts strong ones. Return what it adds to a sum at most."""
    score = min(lane.weight, MAX_LAMP_SCORE)
    chance = hashed_uniform_of_one(bits_of(score), hash_salt(lane.seed_low, lane.batch) + lane.history)
    high, low = unbiased_limbs_of_one(score, chance)
    add_to_row(lane.tallies + 32 * row, high, low, 1, SLANT_UNITS if score >= least else 0)
    return RAY_BOUND + high


@device
def reaches_lamp(lane, table):
    """Return whether a shadow ray has reached its Point, or the shape of its Beam."""
    return reaches_point(lane, table) & (lane.tally == table.first)


@lane_pass(layout.RAY_LAMP, sums=to_scored, when=reaches_lamp)
def score_at_lamp_by_cell(lane, table):
    """Score rays that reached a Point or a Beam unoccluded, by cell of birth.

    The slant counts the strong ones.
    """
    return score_ray(lane, table.first + lane.cell, table.strong)


@lane_pass(layout.VOLUME, sums=to_scored)
def score_path_by_cell(lane, table):
    """Score weight times path length in a source that fills a volume, by cell of birth."""
    length, scored = lane.length_inside, SCORE_BOUND
    if length > 0.0:
        chance = hashed_uniform_of_one(bits_of(length), hash_salt(lane.seed_low, lane.batch) + lane.history)
        high, low = unbiased_limbs_of_one(lane.weight * length * table.scale, chance)
        seen = 1 if length > COLLISION_CLEARANCE else 0  # paths left by rounding alone do not count
        add_to_row(lane.tallies + 32 * (table.first + lane.cell), high, low, seen, 0)
        scored += high
    return scored


@lane_pass(layout.VOLUME, sums=to_scored)
def score_path_by_cell_in_media(lane, table):
    """Score the mean weight along a path times its length by cell of birth, where media absorb."""
    length, fade, scored = lane.length_inside, lane.path_absorption, SCORE_BOUND
    if length > 0.0:
        mean, _ = mean_transmittance(fade * length)
        track = lane.weight * exp_negative(-fade * lane.length_before) * mean * length
        chance = hashed_uniform_of_one(bits_of(length), hash_salt(lane.seed_low, lane.batch) + lane.history)
        high, low = unbiased_limbs_of_one(track * table.scale, chance)
        seen = 1 if length > COLLISION_CLEARANCE else 0
        add_to_row(lane.tallies + 32 * (table.first + lane.cell), high, low, seen, 0)
        scored += high
    return scored
