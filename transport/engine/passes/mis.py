"""Multiple importance sampling: weights of flights where next-event rays score too (Veach 1997).

A lane keeps the point and the largest pdf of its last sampled direction (at a glossy wall the pdf of that
direction: gloss.py). A crossing that a next-event ray could also have produced is scored with the
complementary weight.
"""

import numpy as np
from numba import uint64

from transport.compile import layout
from transport.engine.bodies import lane_pass
from transport.engine.bundle import view
from transport.engine.words import standing_sheet
from transport.physics.connections import flights_share
from transport.physics.device import device
from transport.physics.directions import select


@lane_pass(layout.MIS_PEAK)
def record_pdf_at_births(lane, table):
    """Record the point and the largest pdf of the direction sampled at birth.

    0 if no next-event ray was cast.
    """
    peak = table.peak
    lane.mis_pdf, lane.ex, lane.ey, lane.ez = peak, lane.x, lane.y, lane.z


@lane_pass(layout.MIS_PEAK)
def record_pdf_at_walls(lane, table):
    """Record the same at acting surfaces.

    0 at mirrors, glass and lenses, whose directions no ray can sample. That of glossy walls comes next.
    """
    peak = table.peak
    acts = lane.surface != 0
    is_diffuse = lane.material == layout.DIFFUSE
    now, before = peak if is_diffuse else 0.0, lane.mis_pdf
    lane.mis_pdf = now if acts else before
    lane.ex, lane.ey, lane.ez = select(acts, lane.x, lane.y, lane.z, lane.ex, lane.ey, lane.ez)


@lane_pass(layout.MIS_LINK)
def record_pdf_across_mirrors(lane, table):
    """Record the same where shadow rays pass straight through surfaces and are reflected by a mirror.

    The point becomes its image: from there the path is straight.
    """
    acts = lane.surface != 0
    is_diffuse, is_mirror = lane.material == layout.DIFFUSE, lane.material == layout.MIRROR
    reflects = is_mirror & ((table.transmits == 0) | (lane.transmitted != 1.0))
    links = is_mirror | (lane.material == layout.TRANSPARENT)
    now = table.peak if is_diffuse else (lane.mis_pdf if links else 0.0)
    x, y, z = lane.x, lane.y, lane.z
    height = (lane.ex - x) * lane.nx + (lane.ey - y) * lane.ny + (lane.ez - z) * lane.nz
    height = 2.0 * height if reflects else 0.0
    ex, ey, ez = lane.ex - height * lane.nx, lane.ey - height * lane.ny, lane.ez - height * lane.nz
    ex, ey, ez = select(is_diffuse, x, y, z, ex, ey, ez)
    lane.mis_pdf = now if acts else lane.mis_pdf
    lane.ex, lane.ey, lane.ez = select(acts, ex, ey, ez, lane.ex, lane.ey, lane.ez)


@lane_pass(layout.MIS_PEAK)
def record_pdf_at_collisions(lane, table):
    """Record the same at collisions."""
    peak = table.peak
    here, before = lane.collides != 0, lane.mis_pdf
    lane.mis_pdf = peak if here else before
    lane.ex, lane.ey, lane.ez = select(here, lane.x, lane.y, lane.z, lane.ex, lane.ey, lane.ez)


@lane_pass(layout.NO_TABLE)
def save_weight(lane, table):
    """Save the full weight."""
    lane.full_weight = lane.weight


@lane_pass(layout.MIS_SHARE)
def apply_mis_weight(lane, table):
    """Multiply the weight by the MIS share of flights, at one detector that next-event rays score too."""
    cx, cy, cz, area, sheet = table.cx, table.cy, table.cz, table.area, table.sheet
    is_pure, is_ball, passing = table.how == 1, table.how == 3, table.passing != 0
    acts, peak, weight = lane.surface != 0, lane.mis_pdf, lane.weight
    px, py, pz = select(is_ball, cx, cy, cz, lane.x, lane.y, lane.z)
    rx, ry, rz = px - lane.ex, py - lane.ey, pz - lane.ez
    share = 0.0 if is_pure else flights_share(rx * rx + ry * ry + rz * rz, area, peak)
    here = (lane.hit_sheet == sheet) & (peak > 0.0) & (not (passing & acts))
    lane.weight = weight * share if here else weight


@lane_pass(layout.NO_TABLE)
def restore_weight(lane, table):
    """Restore the full weight."""
    lane.weight = lane.full_weight


@device
def is_in_guard(lane, table):
    """Return whether a flight without a next-event ray passes through the ball."""
    rx, ry, rz = table.cx - lane.x, table.cy - lane.y, table.cz - lane.z
    # Closest point of the flight to the centre.
    along = rx * lane.ux + ry * lane.uy + rz * lane.uz
    along = lane.start if along < lane.start else along
    along = lane.distance if along > lane.distance else along
    dx, dy, dz = rx - along * lane.ux, ry - along * lane.uy, rz - along * lane.uz
    has_pdf = (lane.mis_pdf != 0.0) | (lane.weight == 0.0)
    return (not has_pdf) & (dx * dx + dy * dy + dz * dz <= table.radius2)


@lane_pass(layout.GUARD, when=is_in_guard)
def count_in_guard(lane, table):
    """Count flights through a ball around a detector that have no next-event ray, by sheet of origin."""
    counts = view(lane.sizes, table.cells, np.int64)
    counts[uint64(table.first + standing_sheet(lane.sheet))] += 1
