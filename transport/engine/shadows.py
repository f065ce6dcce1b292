"""Tracing of shadow rays, in a bundle of their own: attenuated by media, stopped by acting surfaces, scored.

They use the passes of flights for all shapes and media. Rays wait until the bundle is full, so its passes
work on full vectors; their order does not matter, because sums are of integers.
"""

import numpy as np

from transport.compile.layout import (
    GRID,
    NO_TABLE,
    POINT_MIDDLE,
    POINT_OCTAVES,
    ROWS,
    SURFACE_MASK,
    SURFACE_SHIFT,
    WORD,
)
from transport.engine.addresses import add_to_row, view
from transport.engine.bundle import LANES, Bundle
from transport.engine.passes import lane_pass
from transport.engine.sums import limbs
from transport.engine.voxels import grid_depth
from transport.physics.bits import bits_of, float_of
from transport.physics.elementary import exp_negative

WORDS = Bundle.itemsize // 8
WEIGHT = Bundle.fields["weight"][1] // 8
LARGEST = 2.0**250  # bound of a score; only a beam through the very point exceeds it
# Contribution to driver.MOST_SCORED: bounds what one score adds to a row, like 2^28 for a volume score.
A_SCORE = 1 << 30


@lane_pass(ROWS)
def take_shadows(b, table, first, live):
    """Move listed rays into idle lanes of the shadow bundle; returns the number of rays under way there.

    Called with the bundle that casts; `table` maps words of its lanes to words of the shadow bundle.

    Fields: updates `cast`, `taken`.
    """
    moves = view(table.rows, table.count, WORD)
    here, there = view(b.address, WORDS, np.int64), view(b.shadow, WORDS, np.int64)
    taken, cast, flying = b.taken, b.cast, 0
    for lane in range(LANES):
        if there[WEIGHT + lane] != 0:
            flying += 1
        elif taken < cast:
            k = b.listed[taken]
            for m in range(table.count):
                source = moves[m].source
                there[moves[m].target + lane] = here[source + k] if source >= 0 else 0
            taken += 1
            flying += 1
    b.taken = taken
    b.cast = cast if taken < cast else 0
    return flying


@lane_pass(NO_TABLE)
def look_for_point(b, table, first, live):
    """Set the distance of each ray to that of its point, with no hit; 0 in idle lanes.

    Fields: reads `weight`, `gap`; writes `distance`, `hit`.
    """
    for k in range(first, live):
        b.distance[k] = b.gap[k] if b.weight[k] != 0.0 else 0.0
        b.hit[k] = 0
    return live


@lane_pass(NO_TABLE)
def dim(b, table, first, live):
    """Multiply by the transmittance of the medium, exp(-(absorption + scattering) path).

    Fields: reads `start`, `distance`, `mfp`, `sigma_a`; updates `weight`.
    """
    for k in range(first, live):
        depth = (b.sigma_a[k] + 1.0 / b.mfp[k]) * (b.distance[k] - b.start[k])
        b.weight[k] *= exp_negative(-depth)
    return live


@lane_pass(GRID)
def dim_in_grid(b, table, first, live):
    """The same in voxels, with the exact optical depth.

    Fields: reads `x, y, z`, `ux, uy, uz`, `start`, `distance`, `medium`; updates `weight`.
    """
    absorption = view(table.absorption, table.absorption_count, np.float64)
    scattering = view(table.scattering, table.scattering_count, np.float64)
    for k in range(first, live):
        if (b.weight[k] != 0.0) & (b.medium[k] == table.medium):
            x, y, z, ux, uy, uz = b.x[k], b.y[k], b.z[k], b.ux[k], b.uy[k], b.uz[k]
            start, end = b.start[k], b.distance[k]
            depth = grid_depth(table, absorption, scattering, x, y, z, ux, uy, uz, start, end)
            b.weight[k] *= exp_negative(-depth)
    return live


@lane_pass(NO_TABLE)
def arrive(b, table, first, live):
    """Score rays that reached their point unoccluded, and end them; acting surfaces end rays too.

    Rows hold scores by octaves (POINT_OCTAVES), each scaled to its row.

    Fields: reads `hit`, `tally`, `leg`; updates `weight`, `scored`.
    """
    arrived = 0
    for k in range(first, live):  # no branch, so no misprediction
        b.listed[arrived] = k
        arrived += 1 if (b.hit[k] == 0) & (b.weight[k] != 0.0) & (b.leg[k] == 0) else 0
    for item in range(arrived):
        k = b.listed[item]
        score = min(b.weight[k], LARGEST)
        row = ((bits_of(score) >> 52) - 1023) // POINT_OCTAVES
        scale = float_of((1023 - POINT_OCTAVES * (row + 1)) << 52)
        high, low = limbs(score * scale)
        add_to_row(b.tallies + 32 * (b.tally[k] + POINT_MIDDLE + row), high, low, 1, 0)
    b.scored += arrived * A_SCORE
    for k in range(first, live):
        stopped = (b.hit[k] == 0) & (b.leg[k] == 0)
        stopped |= ((b.hit[k] >> SURFACE_SHIFT) & SURFACE_MASK) != 0
        b.weight[k] = 0.0 if stopped else b.weight[k]
    return live
