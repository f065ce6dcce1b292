"""Paths divided between histories from cameras and histories from lamps (compile/caustics.py).

`began` is the first interaction of a history. One from a lamp has a negative `cell`, the number of the lamp.
"""

import numpy as np
from numba import int64, uint64

from transport.compile import layout
from transport.engine.bodies import lane_pass
from transport.engine.bundle import view
from transport.engine.passes.backward import score_ray
from transport.engine.passes.detector_bins import find_cell
from transport.engine.passes.shadow_rays import reaches_point
from transport.engine.tally import limbs, to_ledger, to_scored
from transport.physics.device import choose, device
from transport.physics.elementary import azimuth_turn


@lane_pass(layout.BEGINNING)
def begin_at_lamp(lane, table):
    """Set the state of a history from a lamp: the lamp, and where its first interaction must be."""
    cell, began = table.cell, table.began
    lane.cell, lane.began = cell, began


@lane_pass(layout.BEGINNING)
def begin_at_sensor(lane, table):
    """Set the state of a history from a detector: of other detectors than cameras no path is left out."""
    began = table.began
    lane.began = began


@lane_pass(layout.NO_TABLE)
def keep_rays_to_lamps(lane, table):
    """Keep rays to lamps from histories of detectors alone."""
    lane.score = lane.score if lane.cell >= 0 else 0.0


@lane_pass(layout.NO_TABLE)
def keep_rays_to_views(lane, table):
    """Keep rays to cameras from histories of lamps alone, after their first interaction."""
    lane.score = lane.score if (lane.cell < 0) & (lane.began == layout.OTHER_FIRST) else 0.0


@lane_pass(layout.ROWS, sums=to_ledger(layout.BORN))
def note_first_interaction(lane, table):
    """Note the first interaction of a history, and end histories from lamps whose first is not specular.

    Those of another surface than the one aimed at end, too; their births do not count.
    """
    numbers = view(lane.arena + table.rows, table.count, np.int64)
    begins = (lane.surface != 0) & (lane.began <= 0)
    is_met = (lane.began == layout.UNBEGUN) | (lane.began == -numbers[uint64(lane.surface)])
    ends = begins & (lane.cell < 0) & ((not is_met) | (lane.mis_pdf != 0.0))
    first = choose(lane.material == layout.DIFFUSE, layout.DIFFUSE_FIRST, layout.OTHER_FIRST)
    before = choose(ends, lane.weight, 0.0)
    high, low = limbs(before)
    lane.weight = choose(ends, 0.0, lane.weight)
    lane.began = choose(begins, first, lane.began)
    return -high, -low


@lane_pass(layout.LAYERS)
def refine_by_path(lane, table):
    """Drop flights whose light histories from lamps bring, and those histories themselves."""
    is_flight, is_foreign = lane.detector_row < table.half, lane.cell < 0
    is_brought = (lane.began == layout.DIFFUSE_FIRST) & (lane.mis_pdf == 0.0)
    lane.bin = 0 if is_flight & (is_foreign | is_brought) else lane.bin


@device
def reaches_view(lane, table):
    """Return whether a shadow ray has reached its camera."""
    return reaches_point(lane, table) & (lane.tally == table.first)


@lane_pass(layout.VIEW, sums=to_scored, when=reaches_view)
def score_in_view(lane, table):
    """Score rays that reached a camera or a map unoccluded, in the pixel or bin that they come from."""
    m, x, y, z = table.sensor, -lane.ux, -lane.uy, -lane.uz
    across, up, is_seen = z, 0.0, True
    if table.is_flat != 0:
        depth = x * m.nx + y * m.ny + z * m.nz
        is_seen = depth > 0.0
        depth = depth if is_seen else 1.0
        across = (x * m.eux + y * m.euy + z * m.euz) / depth
        up = (x * m.evx + y * m.evy + z * m.evz) / depth
    else:
        up = azimuth_turn(x, y)
        low = view(lane.arena + m.turn_edges, 1, np.float64)[0]
        up += 1.0 if up < low else (-1.0 if up >= low + 1.0 else 0.0)
    column = find_cell(across, m.mu_cells, lane.arena + m.mu_edges)
    row = find_cell(up, m.turn_cells, lane.arena + m.turn_edges)
    cell = row * m.mu_cells + column
    if is_seen & (row >= 0) & (column >= 0):
        return score_ray(lane, int64(table.first + (-1 - lane.cell) * table.cells + cell), table.strong)
    return 0
