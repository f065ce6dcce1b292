"""Speeds: sampled at birth, shifted by a drift, resampled at thermal walls.

Only where speeds differ or are scored.
"""

import numpy as np

from transport.compile.layout import (
    CELL_TERMS,
    DRIFTING,
    NO_TABLE,
    OCTAVE,
    QUANTILES,
    ROWS,
    SURFACE,
    SURFACE_MASK,
    SURFACE_SHIFT,
    VELOCITY,
)
from transport.engine.addresses import view
from transport.engine.passes import lane_pass
from transport.physics.device import device
from transport.physics.quantiles import cell_place, cell_value, octave_of, polynomial
from transport.physics.streams import SPEED, random_words, uniform
from transport.physics.velocities import sample_normal_pair, speed_and_direction


@device
def cell_of(octaves, u):
    """Return the offset of the coefficients of a probability's cell, and the coordinate in the cell."""
    octave, mantissa = octave_of(u)
    cells = octaves[octave].cells
    cell, t = cell_place(mantissa, cells >> 32)
    return CELL_TERMS * ((cells & 0xFFFFFFFF) + cell), t


@device
def quantile(octaves, cells, u):
    """Return the speed at cumulative probability u (inverse CDF)."""
    k, t = cell_of(octaves, u)
    c0, c1, c2, c3, c4, c5 = cells[k], cells[k + 1], cells[k + 2], cells[k + 3], cells[k + 4], cells[k + 5]
    return cell_value(c0, c1, c2, c3, c4, c5, cells[k + 6], t)


@lane_pass(VELOCITY)
def take_speed(b, table, first, live):
    """Set one speed for all particles of this emitter.

    Fields: writes `speed`.
    """
    speed = table.vx
    for k in range(first, live):
        b.speed[k] = speed
    return live


@lane_pass(NO_TABLE)
def draw_speed(b, table, first, live):
    """Draw the uniform (u0) from which a speed is computed.

    Fields: reads `history`; writes `u0`.
    """
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, _, _ = random_words(b.history[k], batch, 0, SPEED, seed_low, seed_high)
        b.u0[k] = uniform(w0, w1)
    return live


@lane_pass(QUANTILES)
def take_quantile(b, table, first, live):
    """Set the speed at cumulative probability u0, for a smooth distribution.

    Fields: reads `u0`; writes `speed`.
    """
    octaves = view(table.octaves, table.octave_count, OCTAVE)
    cells = view(table.cells, table.cell_count * CELL_TERMS, np.float64)
    for k in range(first, live):
        c, t = cell_of(octaves, b.u0[k])
        c0, c1, c2, c3, c4, c5 = (
            cells[c],
            cells[c + 1],
            cells[c + 2],
            cells[c + 3],
            cells[c + 4],
            cells[c + 5],
        )
        b.speed[k] = polynomial(c0, c1, c2, c3, c4, c5, t)
    return live


@lane_pass(QUANTILES)
def take_stepped_quantile(b, table, first, live):
    """Set the speed at cumulative probability u0, for any distribution.

    Fields: reads `u0`; writes `speed`.
    """
    octaves = view(table.octaves, table.octave_count, OCTAVE)
    cells = view(table.cells, table.cell_count * CELL_TERMS, np.float64)
    for k in range(first, live):
        b.speed[k] = quantile(octaves, cells, b.u0[k])
    return live


@lane_pass(VELOCITY)
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


@lane_pass(DRIFTING)
def emit_from_drifting_gas(b, table, first, live):
    """Sample the velocity of effusion from a drifting Maxwellian.

    The normal component is sampled by its inverse CDF, the tangential ones are Gaussian about the drift.

    Fields: reads `history`; writes `ux, uy, uz`, `speed`.
    """
    octaves = view(table.octaves, table.octave_count, OCTAVE)
    cells = view(table.cells, table.cell_count * CELL_TERMS, np.float64)
    side, sigma, drift_u, drift_v = table.side, table.sigma, table.drift_u, table.drift_v
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, _, _ = random_words(b.history[k], batch, 0, SPEED, seed_low, seed_high)
        d0, d1, d2, d3 = random_words(b.history[k], batch, 1, SPEED, seed_low, seed_high)
        p, q = sample_normal_pair(uniform(d0, d1), uniform(d2, d3))
        vn, vu, vv = (
            side * quantile(octaves, cells, uniform(w0, w1)),
            sigma * p + drift_u,
            sigma * q + drift_v,
        )
        vx = vu * table.eux + vv * table.evx + vn * table.nx
        vy = vu * table.euy + vv * table.evy + vn * table.ny
        vz = vu * table.euz + vv * table.evz + vn * table.nz
        b.speed[k], b.ux[k], b.uy[k], b.uz[k] = speed_and_direction(vx, vy, vz, 0.0, 0.0, 0.0)
    return live


@lane_pass(ROWS)
def take_wall_speed(b, table, first, live):
    """Set a speed sampled from the thermal wall that reflected the particle.

    Fields: reads `weight`, `hit`, `u4`; writes `speed`.
    """
    surfaces = view(table.rows, table.count, SURFACE)
    for k in range(first, live):
        at = surfaces[(b.hit[k] >> SURFACE_SHIFT) & SURFACE_MASK].quantiles
        if at != 0 and b.weight[k] != 0.0:
            row = view(at, 1, QUANTILES)[0]
            octaves = view(row.octaves, row.octave_count, OCTAVE)
            cells = view(row.cells, row.cell_count * CELL_TERMS, np.float64)
            b.speed[k] = quantile(octaves, cells, b.u4[k])
    return live
