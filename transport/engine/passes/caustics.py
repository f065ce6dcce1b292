"""Histories from cameras and histories from lamps, combined by the balance heuristic (compile/caustics.py).

`began` is the first interaction of a history. One from a lamp has a negative `cell`, -1 - the number of the
lamp. `path_density` is how densely histories of that kind cover phase space, per area and projected solid
angle: that of a lamp's histories everywhere, that of a camera's histories at their first diffuse wall.
"""

import math

import numpy as np
from numba import int64, uint64

from transport.compile import layout
from transport.engine.bodies import lane_pass
from transport.engine.bundle import view
from transport.engine.passes.backward import score_ray
from transport.engine.passes.detector_bins import find_cell
from transport.engine.passes.next_event import INVERSE_PI
from transport.engine.passes.shadow_rays import direction_to, reaches_point
from transport.engine.tally import limbs, to_ledger, to_scored
from transport.physics.device import choose, device
from transport.physics.elementary import azimuth_turn

NO_LIMIT = np.inf  # no ray counts as strong


@lane_pass(layout.BEGINNING)
def begin_at_lamp(lane, table):
    """Set the state of a history from a lamp: the lamp, and where its first interaction must be."""
    cell, began, density = table.cell, table.began, table.density
    lane.cell, lane.began, lane.path_density = cell, began, density


@lane_pass(layout.BEGINNING)
def begin_at_sensor(lane, table):
    """Set the state of a history from a detector: all paths of other detectors than cameras are its own."""
    began = table.began
    lane.began, lane.path_density = began, 0.0


@lane_pass(layout.NO_TABLE)
def keep_rays_to_lamps(lane, table):
    """Keep rays to lamps from histories of detectors alone."""
    lane.score = lane.score if lane.cell >= 0 else 0.0


@device
def cell_seen(lane, table, x, y, z):
    """Return the pixel or bin of a direction from a view, -1 for none, and its cosine to the optical axis.

    That of a cube is to the axis of its face, that of bins of theta and phi is 1.
    """
    m, across, up, depth, face = table.sensor, z, 0.0, 1.0, int64(0)
    if table.projection == layout.BINS_SEEN:
        up = azimuth_turn(x, y)
        low = view(lane.arena + m.turn_edges, 1, np.float64)[0]
        up += 1.0 if up < low else (-1.0 if up >= low + 1.0 else 0.0)
    elif table.projection == layout.CUBE_SEEN:
        depth = max(abs(x), abs(y), abs(z))
        is_x, is_y = depth == abs(x), depth == abs(y)
        ahead = x if is_x else (y if is_y else z)
        face = int64(0 if is_x else (2 if is_y else 4)) + int64(ahead < 0.0)
        across = (-y if is_x else (x if is_y else -x)) / ahead
        up = (z if is_x | is_y else y) / depth
    else:
        depth = x * m.nx + y * m.ny + z * m.nz
        across, up = x * m.eux + y * m.euy + z * m.euz, x * m.evx + y * m.evy + z * m.evz
        if table.projection == layout.PINHOLE_SEEN:
            if not depth > 0.0:
                return int64(-1), 0.0
            across, up = across / depth, up / depth
        elif table.projection == layout.FISHEYE_SEEN:
            sine = math.sqrt(across * across + up * up)
            depth = min(max(depth, -1.0), 1.0)
            aside = 2.0 * math.pi * azimuth_turn(depth, sine) / sine if sine > 0.0 else 1.0
            across, up = aside * across, aside * up
        elif table.projection == layout.EQUAL_AREA_SEEN:
            aside = math.sqrt(2.0 / (1.0 + depth)) if depth > -1.0 else 0.0
            across, up = aside * across, aside * up
    column = find_cell(across, m.mu_cells, lane.arena + m.mu_edges)
    row = find_cell(up, m.turn_cells, lane.arena + m.turn_edges)
    cell = int64((face * m.turn_cells + row) * m.mu_cells + column)
    return cell if (row >= 0) & (column >= 0) else int64(-1), depth


@device
def in_steradians(projection, area, depth):
    """Return the solid angle of a small area of an image at a cosine to its axis."""
    if projection <= layout.CUBE_SEEN:  # 1 for bins of theta and phi
        return area * depth * depth * depth
    if projection == layout.FISHEYE_SEEN:
        sine = math.sqrt((1.0 - depth) * (1.0 + depth))
        return area * sine / (2.0 * math.pi * azimuth_turn(depth, sine)) if sine > 0.0 else area
    return area


@device
def births_per_area(lane, table, cell, depth, cosine, distance):
    """Return the density that histories born in a cell have on a wall (table.scale)."""
    m = table.sensor
    column, row = cell % m.mu_cells, cell // m.mu_cells % m.turn_cells
    columns = view(lane.arena + m.mu_edges, m.mu_cells + 1, np.float64)
    rows = view(lane.arena + m.turn_edges, m.turn_cells + 1, np.float64)
    measure = (columns[column + 1] - columns[column]) * (rows[row + 1] - rows[row])
    return table.scale * cosine / in_steradians(table.projection, distance * distance * measure, depth)


@lane_pass(layout.VIEW)
def weigh_rays_to_view(lane, table):
    """Keep rays to a camera that fall into its picture, with the share of histories from lamps.

    They come from histories of lamps alone, after the first interaction.
    """
    score = 0.0
    if (lane.cell < 0) & (lane.began == layout.OTHER_FIRST) & (lane.pdf > 0.0):
        cell, depth = cell_seen(lane, table, -lane.vx, -lane.vy, -lane.vz)
        if cell >= 0:
            cosine, distance = lane.pdf / INVERSE_PI, lane.point_distance
            other = births_per_area(lane, table, cell, depth, cosine, distance)
            score = lane.score * (lane.path_density / (lane.path_density + other))
    lane.score = score


@lane_pass(layout.VIEW)
def note_first_wall(lane, table):
    """Note the density of histories of a view at the diffuse wall that is their first interaction."""
    m, cell = table.sensor, lane.cell - table.sensor.first
    is_mine = (cell >= 0) & (cell < m.cells) & (lane.began == layout.UNBEGUN)
    if is_mine & (lane.surface != 0) & (lane.material == layout.DIFFUSE):
        x, y, z, distance = direction_to(m.cx, m.cy, m.cz, lane.x, lane.y, lane.z)
        cosine = abs(x * lane.nx + y * lane.ny + z * lane.nz)
        _, depth = cell_seen(lane, table, x, y, z)
        is_seen = (depth > 0.0) | ((table.projection >= layout.FISHEYE_SEEN) & (abs(depth) < 1.0))
        if (distance > 0.0) & is_seen:
            lane.path_density = births_per_area(lane, table, cell, depth, cosine, distance)


@lane_pass(layout.ROWS, sums=to_ledger(layout.BORN))
def note_first_interaction(lane, table):
    """Note the first interaction of a history, and end histories from lamps whose first is not specular.

    Those of another surface than the one aimed at end, too, and are taken out of the births of the ledger.
    Comes after the passes that need to know whether this is the first interaction.
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
def weigh_flights_to_lamps(lane, table):
    """Weight flights by the share of histories from cameras; those from lamps do not score at lamps.

    Shared are paths whose first interaction is diffuse and whose last is specular.
    """
    rows = view(lane.arena + table.rows, table.count, layout.LAYER)
    detectors = view(lane.arena + table.detectors, table.detector_count, layout.DETECTOR)
    density = detectors[rows[lane.hit_sheet].detector].lamp_density
    is_shared = (lane.began == layout.DIFFUSE_FIRST) & (lane.mis_pdf == 0.0) & (density > 0.0)
    whole = lane.path_density + (density if is_shared else 1.0)  # never 0, as both are computed
    share = lane.path_density / whole if is_shared else 1.0
    lane.weight *= share if lane.cell >= 0 else 0.0


@device
def reaches_view(lane, table):
    """Return whether a shadow ray has reached its camera."""
    return reaches_point(lane, table) & (lane.tally == table.first)


@lane_pass(layout.VIEW, sums=to_scored, when=reaches_view)
def score_in_view(lane, table):
    """Score rays that reached a camera or a map unoccluded, in the pixel or bin that they come from."""
    cell, _ = cell_seen(lane, table, -lane.ux, -lane.uy, -lane.uz)
    if cell >= 0:
        return score_ray(lane, int64(table.first + (-1 - lane.cell) * table.cells + cell), NO_LIMIT)
    return 0
