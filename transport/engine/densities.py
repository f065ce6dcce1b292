"""Scattering towards a point: coefficients in voxels, and pdfs of phase functions.

`law` is the number of a lane's phase function, `bent` the cosine of its scattering angle; the pdfs of a
mixture's parts add up in `density`.
"""

import numpy as np
from numba import int64

from transport.compile.layout import GRID, POINT_PHASE
from transport.engine.addresses import view
from transport.engine.grids import cell_at
from transport.engine.passes import lane_pass
from transport.engine.refinements import cell
from transport.physics.sight import henyey_greenstein_density, rayleigh_density

NEUTRAL = 0.07957747154594767  # 1 / 4 pi


@lane_pass(GRID)
def weigh_in_grid(b, table, first, live):
    """Multiply the score by the scattering coefficient of the voxel where a shadow ray begins.

    Only scores that still lack it, which are negative.

    Fields: reads `medium`, `sx, sy, sz`; updates `score`.
    """
    scattering = view(table.scattering, table.scattering_count, np.float64)
    for k in range(first, live):
        if (b.score[k] < 0.0) & (b.medium[k] == table.medium):
            i = cell_at((b.sx[k] - table.cx) * table.per_x, table.nx)
            j = cell_at((b.sy[k] - table.cy) * table.per_y, table.ny)
            m = cell_at((b.sz[k] - table.cz) * table.per_z, table.nz)
            voxel = int64(i * table.scattering_x + j * table.scattering_y + m * table.scattering_z)
            b.score[k] *= -scattering[voxel] * table.length
    return live


@lane_pass(POINT_PHASE)
def weigh_isotropically(b, table, first, live):
    """Add the pdf of isotropic scattering, share/(4 pi) [sr^-1].

    Fields: reads `law`; updates `density`.
    """
    number, density = table.number, table.share * NEUTRAL
    for k in range(first, live):
        b.density[k] += density if b.law[k] == number else 0.0
    return live


@lane_pass(POINT_PHASE)
def weigh_by_henyey_greenstein(b, table, first, live):
    """Add the pdf of the phase function of Henyey and Greenstein [sr^-1].

    Fields: reads `bent`, `law`; updates `density`.
    """
    number, share, g = table.number, table.share, table.g
    for k in range(first, live):
        density = share * henyey_greenstein_density(g, b.bent[k])
        b.density[k] += density if b.law[k] == number else 0.0
    return live


@lane_pass(POINT_PHASE)
def weigh_by_rayleigh(b, table, first, live):
    """Add the pdf of Rayleigh's phase function [sr^-1].

    Fields: reads `bent`, `law`; updates `density`.
    """
    number, share = table.number, table.share
    for k in range(first, live):
        density = share * rayleigh_density(b.bent[k])
        b.density[k] += density if b.law[k] == number else 0.0
    return live


@lane_pass(POINT_PHASE)
def weigh_by_table(b, table, first, live):
    """Add the pdf of a tabulated phase function, linear in the cosine between its points [sr^-1].

    Fields: reads `score`, `bent`, `law`; updates `density`.
    """
    count = table.cells + 1
    cosines, values = view(table.cosines, count, np.float64), view(table.values, count, np.float64)
    for k in range(first, live):
        if (b.law[k] == table.number) & (b.score[k] != 0.0):
            mu = min(1.0, max(-1.0, b.bent[k]))
            j = cell(mu, table.cells, table.cosines)
            part = (mu - cosines[j]) / (cosines[j + 1] - cosines[j])
            b.density[k] += table.share * (values[j] + part * (values[j + 1] - values[j]))
    return live
