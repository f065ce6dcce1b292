"""Speeds: sampled at birth, shifted by a drift, resampled at thermal walls.

Only where speeds differ or are scored.
"""

import numpy as np

from transport.compile import layout
from transport.engine.bodies import lane_pass
from transport.engine.bundle import view
from transport.engine.tally import limbs, to_ledger
from transport.engine.words import birth_block, words_of_block
from transport.physics.device import choose, device
from transport.physics.quantiles import cell_place, cell_value, octave_of, polynomial
from transport.physics.streams import CLOCK, SPEED, random_words, uniform
from transport.physics.velocities import sample_normal_pair, speed_and_direction


@device
def quantile_table(lane, row):
    """Return octaves and coefficients of an inverse CDF, from a row with the columns of layout.QUANTILES."""
    octaves = view(lane.arena + row.octaves, row.octave_count, layout.OCTAVE)
    return octaves, view(lane.arena + row.cells, row.cell_count * layout.CELL_TERMS, np.float64)


@device
def cell_of(octaves, u):
    """Return the offset of the coefficients of a probability's cell, and the coordinate in the cell."""
    octave, mantissa = octave_of(u)
    cells = octaves[octave].cells
    cell, t = cell_place(mantissa, cells >> 32)
    return layout.CELL_TERMS * ((cells & 0xFFFFFFFF) + cell), t


@device
def coefficients_at(cells, c):
    """Return the six coefficients of a cell by their offset."""
    return cells[c], cells[c + 1], cells[c + 2], cells[c + 3], cells[c + 4], cells[c + 5]


@device
def quantile(octaves, cells, u):
    """Return the speed at cumulative probability u (inverse CDF)."""
    k, t = cell_of(octaves, u)
    c0, c1, c2, c3, c4, c5 = coefficients_at(cells, k)
    return cell_value(c0, c1, c2, c3, c4, c5, cells[k + 6], t)


@lane_pass(layout.VELOCITY)
def set_speed(lane, table):
    """Set one speed for all particles of this emitter."""
    speed = table.vx
    lane.speed = speed


@lane_pass(layout.NO_TABLE, before=birth_block(SPEED))
def draw_speed_uniform(lane, table):
    """Draw the uniform (u0) from which a speed is computed."""
    w0, w1, _, _ = words_of_block(lane)
    lane.u0 = uniform(w0, w1)


@lane_pass(layout.QUANTILES)
def set_speed_by_quantile(lane, table):
    """Set the speed at cumulative probability u0, for a smooth distribution."""
    octaves, cells = quantile_table(lane, table)
    c, t = cell_of(octaves, lane.u0)
    c0, c1, c2, c3, c4, c5 = coefficients_at(cells, c)
    lane.speed = polynomial(c0, c1, c2, c3, c4, c5, t)


@lane_pass(layout.QUANTILES)
def set_speed_by_stepped_quantile(lane, table):
    """Set the speed at cumulative probability u0, for any distribution."""
    octaves, cells = quantile_table(lane, table)
    lane.speed = quantile(octaves, cells, lane.u0)


@lane_pass(layout.VELOCITY)
def add_drift(lane, table):
    """Add a drift to the velocity; a negative speed reverses the direction, a particle at rest keeps it."""
    dx, dy, dz = table.vx, table.vy, table.vz
    v, ux, uy, uz = lane.speed, lane.ux, lane.uy, lane.uz
    vx, vy, vz = v * ux + dx, v * uy + dy, v * uz + dz
    lane.speed, lane.ux, lane.uy, lane.uz = speed_and_direction(vx, vy, vz, ux, uy, uz)


@lane_pass(layout.DRIFTING_GAS)
def emit_from_drifting_gas(lane, table):
    """Sample the velocity of effusion from a drifting Maxwellian.

    The normal component is sampled by its inverse CDF, the tangential ones are Gaussian about the drift.
    """
    octaves, cells = quantile_table(lane, table)
    side, sigma, drift_u, drift_v = table.side, table.sigma, table.drift_u, table.drift_v
    seed_low, seed_high, batch = lane.seed_low, lane.seed_high, lane.batch
    w0, w1, _, _ = random_words(lane.history, batch, 0, SPEED, seed_low, seed_high)
    d0, d1, d2, d3 = random_words(lane.history, batch, 1, SPEED, seed_low, seed_high)
    p, q = sample_normal_pair(uniform(d0, d1), uniform(d2, d3))
    vn = side * quantile(octaves, cells, uniform(w0, w1))
    vu, vv = sigma * p + drift_u, sigma * q + drift_v
    vx = vu * table.eux + vv * table.evx + vn * table.nx
    vy = vu * table.euy + vv * table.evy + vn * table.ny
    vz = vu * table.euz + vv * table.evz + vn * table.nz
    lane.speed, lane.ux, lane.uy, lane.uz = speed_and_direction(vx, vy, vz, 0.0, 0.0, 0.0)


@lane_pass(layout.ROWS)
def sample_wall_speed(lane, table):
    """Set a speed sampled from the thermal wall that reflected the particle."""
    surfaces = view(lane.arena + table.rows, table.count, layout.SURFACE)
    at = surfaces[lane.surface].quantiles
    if at != 0 and lane.weight != 0.0:
        octaves, cells = quantile_table(lane, view(lane.arena + at, 1, layout.QUANTILES)[0])
        lane.speed = quantile(octaves, cells, lane.u4)


# ---- The clock: time of birth, time of arrival, end of the clock. Only in scenes with a duration.
#
# Times are in durations. A flight lasts from `time` to `arrival`, and the next begins at that very number, so
# an instant belongs to exactly one flight of each history and each particle is scored once per instant.


@lane_pass(layout.BIRTH_TIME)
def set_birth_time(lane, table):
    """Set one time of birth for all."""
    start = table.start
    lane.time = start


@lane_pass(layout.BIRTH_TIME, before=birth_block(CLOCK))
def sample_birth_time(lane, table):
    """Sample a time of birth uniformly in an interval: a steady source, or a pulse of constant power."""
    start, width = table.start, table.width
    w0, w1, _, _ = words_of_block(lane)
    lane.time = start + uniform(w0, w1) * width


@lane_pass(layout.BIRTH_TIME, before=birth_block(CLOCK))
def sample_birth_time_and_speed(lane, table):
    """Sample a time of birth, and keep in u0 the uniform for a speed from the same random block."""
    start, width = table.start, table.width
    w0, w1, w2, w3 = words_of_block(lane)
    lane.time, lane.u0 = start + uniform(w0, w1) * width, uniform(w2, w3)


@lane_pass(layout.BIRTH_TIME, before=birth_block(CLOCK))
def sample_pulse_time(lane, table):
    """Sample a time of birth from a Gaussian pulse; width: its standard deviation."""
    start, width = table.start, table.width
    w0, w1, w2, w3 = words_of_block(lane)
    deviation, _ = sample_normal_pair(uniform(w0, w1), uniform(w2, w3))
    lane.time = start + width * deviation


@lane_pass(layout.CLOCK)
def time_arrival(lane, table):
    """Set the time at the end of the flight, for one common speed; infinite without a surface ahead."""
    slowness = table.slowness
    lane.arrival = lane.time + (lane.distance - lane.start) * slowness


@lane_pass(layout.NO_TABLE)
def time_arrival_by_speed(lane, table):
    """Set the time of arrival at the particle's own speed; infinite at rest."""
    lane.arrival = lane.time + (lane.distance - lane.start) / lane.speed


@lane_pass(layout.MEDIA_CLOCK)
def time_arrival_in_media(lane, table):
    """Set the time of arrival in media, where light is slower by the index."""
    rows = view(lane.arena + table.rows, table.count, layout.MEDIA)
    slowness, has_speeds = table.slowness, table.has_speeds != 0
    pace = rows[lane.medium].index * slowness
    pace = 1.0 / lane.speed if has_speeds else pace
    lane.arrival = lane.time + (lane.distance - lane.start) * pace


@lane_pass(layout.CLOCK, sums=to_ledger(layout.IN_FLIGHT))
def stop_clock(lane, table):
    """End particles whose flight outlasts the clock, as in flight; advance the time of the others."""
    arrival = lane.arrival
    late = arrival > table.duration
    high, low = limbs(lane.weight if late else 0.0)
    lane.time = arrival
    lane.hit = choose(late, 0, lane.hit)
    lane.covered = choose(late, 0, lane.covered)
    lane.weight = choose(late, 0.0, lane.weight)
    return high, low
