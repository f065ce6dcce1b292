"""Speeds: sampled at birth, shifted by a drift, resampled at thermal walls.

Only where speeds differ or are scored.
"""

import numpy as np

from transport.compile import layout
from transport.engine.bundle import view
from transport.engine.registry import lane_pass
from transport.engine.tally import add_to_ledger, limbs
from transport.engine.words import surface_of
from transport.physics.device import device
from transport.physics.quantiles import cell_place, cell_value, octave_of, polynomial
from transport.physics.streams import CLOCK, SPEED, random_words, uniform
from transport.physics.velocities import sample_normal_pair, speed_and_direction


@device
def quantile_table(row):
    """Return octaves and coefficients of an inverse CDF, from a row with the columns of layout.QUANTILES."""
    octaves = view(row.octaves, row.octave_count, layout.OCTAVE)
    return octaves, view(row.cells, row.cell_count * layout.CELL_TERMS, np.float64)


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
def set_speed(b, table, first, live):
    """Set one speed for all particles of this emitter.

    Fields: writes `speed`.
    """
    speed = table.vx
    for k in range(first, live):
        b.speed[k] = speed
    return live


@lane_pass(layout.NO_TABLE)
def draw_speed_uniform(b, table, first, live):
    """Draw the uniform (u0) from which a speed is computed.

    Fields: reads `history`; writes `u0`.
    """
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, _, _ = random_words(b.history[k], batch, 0, SPEED, seed_low, seed_high)
        b.u0[k] = uniform(w0, w1)
    return live


@lane_pass(layout.QUANTILES)
def set_speed_by_quantile(b, table, first, live):
    """Set the speed at cumulative probability u0, for a smooth distribution.

    Fields: reads `u0`; writes `speed`.
    """
    octaves, cells = quantile_table(table)
    for k in range(first, live):
        c, t = cell_of(octaves, b.u0[k])
        c0, c1, c2, c3, c4, c5 = coefficients_at(cells, c)
        b.speed[k] = polynomial(c0, c1, c2, c3, c4, c5, t)
    return live


@lane_pass(layout.QUANTILES)
def set_speed_by_stepped_quantile(b, table, first, live):
    """Set the speed at cumulative probability u0, for any distribution.

    Fields: reads `u0`; writes `speed`.
    """
    octaves, cells = quantile_table(table)
    for k in range(first, live):
        b.speed[k] = quantile(octaves, cells, b.u0[k])
    return live


@lane_pass(layout.VELOCITY)
def add_drift(b, table, first, live):
    """Add a drift to the velocity; a negative speed reverses the direction, a particle at rest keeps it.

    Fields: updates `ux, uy, uz`, `speed`.
    """
    dx, dy, dz = table.vx, table.vy, table.vz
    for k in range(first, live):
        v, ux, uy, uz = b.speed[k], b.ux[k], b.uy[k], b.uz[k]
        vx, vy, vz = v * ux + dx, v * uy + dy, v * uz + dz
        b.speed[k], b.ux[k], b.uy[k], b.uz[k] = speed_and_direction(vx, vy, vz, ux, uy, uz)
    return live


@lane_pass(layout.DRIFTING_GAS)
def emit_from_drifting_gas(b, table, first, live):
    """Sample the velocity of effusion from a drifting Maxwellian.

    The normal component is sampled by its inverse CDF, the tangential ones are Gaussian about the drift.

    Fields: reads `history`; writes `ux, uy, uz`, `speed`.
    """
    octaves, cells = quantile_table(table)
    side, sigma, drift_u, drift_v = table.side, table.sigma, table.drift_u, table.drift_v
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, _, _ = random_words(b.history[k], batch, 0, SPEED, seed_low, seed_high)
        d0, d1, d2, d3 = random_words(b.history[k], batch, 1, SPEED, seed_low, seed_high)
        p, q = sample_normal_pair(uniform(d0, d1), uniform(d2, d3))
        vn = side * quantile(octaves, cells, uniform(w0, w1))
        vu, vv = sigma * p + drift_u, sigma * q + drift_v
        vx = vu * table.eux + vv * table.evx + vn * table.nx
        vy = vu * table.euy + vv * table.evy + vn * table.ny
        vz = vu * table.euz + vv * table.evz + vn * table.nz
        b.speed[k], b.ux[k], b.uy[k], b.uz[k] = speed_and_direction(vx, vy, vz, 0.0, 0.0, 0.0)
    return live


@lane_pass(layout.ROWS)
def sample_wall_speed(b, table, first, live):
    """Set a speed sampled from the thermal wall that reflected the particle.

    Fields: reads `weight`, `hit`, `u4`; writes `speed`.
    """
    surfaces = view(table.rows, table.count, layout.SURFACE)
    for k in range(first, live):
        at = surfaces[surface_of(b.hit[k])].quantiles
        if at != 0 and b.weight[k] != 0.0:
            octaves, cells = quantile_table(view(at, 1, layout.QUANTILES)[0])
            b.speed[k] = quantile(octaves, cells, b.u4[k])
    return live


# ---- The clock: time of birth, time of arrival, end of the clock. Only in scenes with a duration.
#
# Times are in durations. A flight lasts from `time` to `arrival`, and the next begins at that very number, so
# an instant belongs to exactly one flight of each history and each particle is scored once per instant.


@lane_pass(layout.BIRTH_TIME)
def set_birth_time(b, table, first, live):
    """Set one time of birth for all.

    Fields: writes `time`.
    """
    start = table.start
    for k in range(first, live):
        b.time[k] = start
    return live


@lane_pass(layout.BIRTH_TIME)
def sample_birth_time(b, table, first, live):
    """Sample a time of birth uniformly in an interval: a steady source, or a pulse of constant power.

    Fields: reads `history`; writes `time`.
    """
    start, width = table.start, table.width
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, _, _ = random_words(b.history[k], batch, 0, CLOCK, seed_low, seed_high)
        b.time[k] = start + uniform(w0, w1) * width
    return live


@lane_pass(layout.BIRTH_TIME)
def sample_birth_time_and_speed(b, table, first, live):
    """Sample a time of birth, and keep in u0 the uniform for a speed from the same random block.

    Fields: reads `history`; writes `time`, `u0`.
    """
    start, width = table.start, table.width
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, CLOCK, seed_low, seed_high)
        b.time[k], b.u0[k] = start + uniform(w0, w1) * width, uniform(w2, w3)
    return live


@lane_pass(layout.BIRTH_TIME)
def sample_pulse_time(b, table, first, live):
    """Sample a time of birth from a Gaussian pulse; width: its standard deviation.

    Fields: reads `history`; writes `time`.
    """
    start, width = table.start, table.width
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, CLOCK, seed_low, seed_high)
        deviation, _ = sample_normal_pair(uniform(w0, w1), uniform(w2, w3))
        b.time[k] = start + width * deviation
    return live


@lane_pass(layout.CLOCK)
def time_arrival(b, table, first, live):
    """Set the time at the end of the flight, for one common speed; infinite without a surface ahead.

    Fields: reads `start`, `distance`, `time`; writes `arrival`.
    """
    slowness = table.slowness
    for k in range(first, live):
        b.arrival[k] = b.time[k] + (b.distance[k] - b.start[k]) * slowness
    return live


@lane_pass(layout.NO_TABLE)
def time_arrival_by_speed(b, table, first, live):
    """Set the time of arrival at the particle's own speed; infinite at rest.

    Fields: reads `start`, `distance`, `time`, `speed`; writes `arrival`.
    """
    for k in range(first, live):
        b.arrival[k] = b.time[k] + (b.distance[k] - b.start[k]) / b.speed[k]
    return live


@lane_pass(layout.MEDIA_CLOCK)
def time_arrival_in_media(b, table, first, live):
    """Set the time of arrival in media, where light is slower by the index; waiting lanes keep theirs.

    Fields: reads `start`, `distance`, `time`, `speed`, `medium`, `flies`; writes `arrival`.
    """
    rows = view(table.rows, table.count, layout.MEDIA)
    slowness, has_speeds = table.slowness, table.has_speeds != 0
    for k in range(first, live):
        pace = rows[b.medium[k]].index * slowness
        pace = 1.0 / b.speed[k] if has_speeds else pace
        length = b.distance[k] - b.start[k]
        b.arrival[k] = b.time[k] + (length * pace if b.flies[k] != 0 else 0.0)
    return live


@lane_pass(layout.CLOCK)
def stop_clock(b, table, first, live):
    """End particles whose flight outlasts the clock, as in flight; advance the time of the others.

    Fields: reads `arrival`; updates `weight`, `hit`; writes `time`.
    """
    high, low, duration = 0, 0, table.duration
    for k in range(first, live):
        arrival = b.arrival[k]
        late = arrival > duration
        w_high, w_low = limbs(b.weight[k] if late else 0.0)
        high += w_high
        low += w_low
        b.time[k] = arrival
        b.hit[k] = 0 if late else b.hit[k]
        b.weight[k] = 0.0 if late else b.weight[k]
    add_to_ledger(b, layout.IN_FLIGHT, high, low)
    return live
