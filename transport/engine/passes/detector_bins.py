"""Further bin axes of surface detectors: time, speed, azimuth, cosine edges, world frame, cone, position.

Each pass works on lanes that already have a bin, and exists only where a detector has that axis. A coordinate
outside its edges goes to the detector's outside row.
"""

import math

import numpy as np

from transport.compile import layout
from transport.engine.bodies import lane_pass
from transport.engine.bundle import view
from transport.physics.device import device
from transport.physics.elementary import TWO_PI, azimuth_turn

# squared sine of the angle within which a normal counts as parallel to an axis (vectors.PARALLEL_SINE)
PARALLEL = 1e-12


@device
def find_cell(value, cells, edges):
    """Return the number of the cell that holds the value, by binary search in the edges at an address.

    -1: none.
    """
    found = -1
    bounds = view(edges, cells + 1, np.float64)
    if (value >= bounds[0]) & (value <= bounds[cells]):
        found, width = 0, cells
        while width > 1:  # halves by selection: a branch would be mispredicted half of the time
            half = width >> 1
            found += half if value >= bounds[found + half] else 0
            width -= half
    return found


@device
def azimuth_cell(e_u, e_v, low, cells, edges):
    """Return the bin of the azimuth of a direction by its components, counted from the first edge on.

    -1: none.
    """
    angle = azimuth_turn(e_u, e_v) * TWO_PI
    if angle < low:
        angle += TWO_PI
    elif angle >= low + TWO_PI:
        angle -= TWO_PI
    return find_cell(angle, cells, edges)


@device
def row_after(bin, base, found, stride):
    """Return the row `found` cells further along an axis, or the outside row."""
    return bin + found * stride if found >= 0 else base


@device
def sine_squared(ux, uy, uz, ax, ay, az):
    """Return the squared sine of the angle between two unit vectors, without cancellation.

    2 beyond a right angle.
    """
    x, y, z = uy * az - uz * ay, uz * ax - ux * az, ux * ay - uy * ax
    return x * x + y * y + z * z if ux * ax + uy * ay + uz * az > 0.0 else 2.0


@device
def tangential_part(ax, ay, az, nx, ny, nz):
    """Return the part of a vector perpendicular to a unit normal."""
    a = ax * nx + ay * ny + az * nz
    return ax - a * nx, ay - a * ny, az - a * nz


@lane_pass(layout.LAYERS)
def find_detector_row(lane, table):
    """Set the index of the detector's row, for the bin axes that follow."""
    rows = view(lane.arena + table.rows, table.count, layout.LAYER)
    lane.detector_index = rows[lane.hit_sheet].detector


@lane_pass(layout.LAYERS)
def refine_by_time(lane, table):
    """Bin by the time of crossing.

    Each bin of time has outside rows of its own for direction and position.
    """
    detectors = view(lane.arena + table.detectors, table.detector_count, layout.DETECTOR)
    if lane.bin != 0:
        m = detectors[lane.detector_index]
        if m.time_cells != 0:
            found = find_cell(lane.time, m.time_cells, lane.arena + m.time_edges)
            outside = m.outside + (table.half if lane.detector_row >= table.half else 0)
            lane.bin = row_after(lane.bin, outside, found, m.time_stride)
            lane.detector_row = row_after(lane.detector_row, outside, found, m.time_stride)


@lane_pass(layout.LAYERS)
def refine_by_speed(lane, table):
    """Bin by speed, with outside rows like those of time."""
    detectors = view(lane.arena + table.detectors, table.detector_count, layout.DETECTOR)
    if lane.bin > lane.detector_row:
        m = detectors[lane.detector_index]
        if m.speed_cells != 0:
            found = find_cell(lane.speed, m.speed_cells, lane.arena + m.speed_edges)
            outside = m.outside + (table.half if lane.detector_row >= table.half else 0)
            lane.bin = row_after(lane.bin, outside, found, m.speed_stride)
            lane.detector_row = row_after(lane.detector_row, outside, found, m.speed_stride)


@lane_pass(layout.LAYERS)
def refine_by_cosine(lane, table):
    """Bin by cosine with given edges, by cosine in the world's frame, or by one cone."""
    detectors = view(lane.arena + table.detectors, table.detector_count, layout.DETECTOR)
    if lane.bin > lane.detector_row:  # not yet outside of another axis
        m = detectors[lane.detector_index]
        if m.mu_kind != 0:
            toward = -1.0 if m.side * lane.mu < 0.0 else 1.0  # arrivals by the direction they come from
            value = abs(lane.mu)
            if m.mu_kind == layout.WORLD_COSINE:
                value = toward * lane.uz
            if m.mu_kind == layout.CONE:
                value = -sine_squared(
                    toward * lane.ux, toward * lane.uy, toward * lane.uz, m.axis_x, m.axis_y, m.axis_z
                )
            found = find_cell(value, m.mu_cells, lane.arena + m.mu_edges)
            lane.bin = row_after(lane.bin, lane.detector_row, found, m.mu_stride)


@lane_pass(layout.LAYERS)
def refine_by_azimuth(lane, table):
    """Bin by azimuth of the direction, from e_u towards e_v, or from the world's x towards y."""
    detectors = view(lane.arena + table.detectors, table.detector_count, layout.DETECTOR)
    if lane.bin > lane.detector_row:
        m = detectors[lane.detector_index]
        if m.turn_kind != 0:
            toward = -1.0 if m.side * lane.mu < 0.0 else 1.0
            ux, uy, uz = toward * lane.ux, toward * lane.uy, toward * lane.uz
            eux, euy, euz, evx, evy, evz = m.eux, m.euy, m.euz, m.evx, m.evy, m.evz
            # On a sphere: e_v = projected axis, e_u = e_v x n; lengths do not matter.
            if m.turn_kind == layout.SPHERE_AZIMUTH:
                nx, ny, nz = m.side * lane.nx, m.side * lane.ny, m.side * lane.nz
                evx, evy, evz = tangential_part(m.axis_x, m.axis_y, m.axis_z, nx, ny, nz)
                if evx * evx + evy * evy + evz * evz < PARALLEL:  # a facet of a mesh across the axis
                    evx, evy, evz = tangential_part(m.evx, m.evy, m.evz, nx, ny, nz)
                eux, euy, euz = evy * nz - evz * ny, evz * nx - evx * nz, evx * ny - evy * nx
            e_u, e_v = ux * eux + uy * euy + uz * euz, ux * evx + uy * evy + uz * evz
            if m.turn_kind == layout.WORLD_AZIMUTH:
                e_u, e_v = ux, uy
            found = azimuth_cell(e_u, e_v, m.turn_low, m.turn_cells, lane.arena + m.turn_edges)
            lane.bin = row_after(lane.bin, lane.detector_row, found, m.turn_stride)


@lane_pass(layout.LAYERS)
def refine_by_place(lane, table):
    """Bin by position in the shape's coordinates: width and height.

    Radius and azimuth; polar angle and azimuth.
    """
    detectors = view(lane.arena + table.detectors, table.detector_count, layout.DETECTOR)
    if lane.bin > lane.detector_row:
        m = detectors[lane.detector_index]
        if m.place != 0:
            px, py, pz = lane.x - m.cx, lane.y - m.cy, lane.z - m.cz
            u = px * m.eux + py * m.euy + pz * m.euz
            v = px * m.evx + py * m.evy + pz * m.evz
            if m.place == layout.RECTANGLE_PLACE:
                u = m.handed * u
            elif m.place == layout.DISK_PLACE:
                u = m.handed * u
                u, v = math.sqrt(u * u + v * v), azimuth_turn(u, v) * TWO_PI
            else:
                w = px * m.nx + py * m.ny + pz * m.nz
                polar = azimuth_turn(w, math.sqrt(u * u + v * v)) * TWO_PI
                u, v = w if m.place == layout.REVOLVED_PLACE else polar, azimuth_turn(u, v) * TWO_PI
            found = find_cell(u, m.u_cells, lane.arena + m.u_edges)
            lane.bin = row_after(lane.bin, lane.detector_row, found, m.u_stride)
            if lane.bin > lane.detector_row:
                found = find_cell(v, m.v_cells, lane.arena + m.v_edges)
                lane.bin = row_after(lane.bin, lane.detector_row, found, m.v_stride)
