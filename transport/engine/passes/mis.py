"""Multiple importance sampling: weights of flights where next-event rays score too (Veach 1997).

A lane keeps the point and the largest pdf of its last sampled direction. A crossing that a next-event ray
could also have produced is scored with the complementary weight.
"""

import math

import numpy as np
from numba import uint64

from transport.compile import layout
from transport.engine.bundle import view
from transport.engine.registry import lane_pass
from transport.engine.words import material_of, sheet_of, standing_sheet, surface_of
from transport.physics.connections import flights_share
from transport.physics.directions import select


@lane_pass(layout.MIS_PEAK)
def record_pdf_at_births(b, table, first, live):
    """Record the point and the largest pdf of the direction sampled at birth.

    0 if no next-event ray was cast.

    Fields: reads `x, y, z`; writes `mis_pdf`, `ex, ey, ez`.
    """
    peak = table.peak
    for k in range(first, live):
        b.mis_pdf[k], b.ex[k], b.ey[k], b.ez[k] = peak, b.x[k], b.y[k], b.z[k]
    return live


@lane_pass(layout.MIS_PEAK)
def record_pdf_at_walls(b, table, first, live):
    """Record the same at acting surfaces.

    0 at mirrors, glass and lenses, whose directions no ray can sample.

    Fields: reads `x, y, z`, `hit`; updates `mis_pdf`, `ex, ey, ez`.
    """
    peak = table.peak
    for k in range(first, live):
        acts = surface_of(b.hit[k]) != 0
        is_diffuse = material_of(b.hit[k]) == layout.DIFFUSE
        now, before = peak if is_diffuse else 0.0, b.mis_pdf[k]
        b.mis_pdf[k] = now if acts else before
        b.ex[k], b.ey[k], b.ez[k] = select(acts, b.x[k], b.y[k], b.z[k], b.ex[k], b.ey[k], b.ez[k])
    return live


@lane_pass(layout.MIS_PEAK)
def record_pdf_at_collisions(b, table, first, live):
    """Record the same at collisions.

    Fields: reads `x, y, z`, `collides`; updates `mis_pdf`, `ex, ey, ez`.
    """
    peak = table.peak
    for k in range(first, live):
        here, before = b.collides[k] != 0, b.mis_pdf[k]
        b.mis_pdf[k] = peak if here else before
        b.ex[k], b.ey[k], b.ez[k] = select(here, b.x[k], b.y[k], b.z[k], b.ex[k], b.ey[k], b.ez[k])
    return live


@lane_pass(layout.NO_TABLE)
def save_weight(b, table, first, live):
    """Save the full weight.

    Fields: reads `weight`; writes `full_weight`.
    """
    for k in range(first, live):
        b.full_weight[k] = b.weight[k]
    return live


@lane_pass(layout.MIS_SHARE)
def apply_mis_weight(b, table, first, live):
    """Multiply the weight by the MIS share of flights, at one detector that next-event rays score too.

    Fields: reads `x, y, z`, `hit`, `mis_pdf`, `ex, ey, ez`; updates `weight`.
    """
    cx, cy, cz, area, sheet = table.cx, table.cy, table.cz, table.area, table.sheet
    is_pure, is_ball, passing = table.how == 1, table.how == 3, table.passing != 0
    for k in range(first, live):
        acts, peak, weight = surface_of(b.hit[k]) != 0, b.mis_pdf[k], b.weight[k]
        px, py, pz = select(is_ball, cx, cy, cz, b.x[k], b.y[k], b.z[k])
        rx, ry, rz = px - b.ex[k], py - b.ey[k], pz - b.ez[k]
        share = 0.0 if is_pure else flights_share(rx * rx + ry * ry + rz * rz, area, peak)
        here = (sheet_of(b.hit[k]) == sheet) & (peak > 0.0) & (not (passing & acts))
        b.weight[k] = weight * share if here else weight
    return live


@lane_pass(layout.NO_TABLE)
def restore_weight(b, table, first, live):
    """Restore the full weight.

    Fields: reads `full_weight`; writes `weight`.
    """
    for k in range(first, live):
        b.weight[k] = b.full_weight[k]
    return live


@lane_pass(layout.GUARD)
def count_in_guard(b, table, first, live):
    """Count flights through a ball around a detector that have no next-event ray, by sheet of origin.

    Fields: reads `x, y, z`, `ux, uy, uz`, `weight`, `sheet`, `start`, `distance`, `mis_pdf`; updates `score`.
    """
    cx, cy, cz, radius2, begin = table.cx, table.cy, table.cz, table.radius2, table.first
    counts, n = view(b.sizes, table.cells, np.int64), 0
    for k in range(first, live):
        rx, ry, rz = cx - b.x[k], cy - b.y[k], cz - b.z[k]
        # Closest point of the flight to the centre.
        along = rx * b.ux[k] + ry * b.uy[k] + rz * b.uz[k]
        along = b.start[k] if along < b.start[k] else along
        along = b.distance[k] if along > b.distance[k] else along
        dx, dy, dz = rx - along * b.ux[k], ry - along * b.uy[k], rz - along * b.uz[k]
        has_pdf = (b.mis_pdf[k] != 0.0) | (b.weight[k] == 0.0)
        b.score[k] = math.inf if has_pdf else dx * dx + dy * dy + dz * dz
    # List the flights within the ball, and count them by sheet.
    for k in range(first, live):
        b.listed[n] = k
        n += 1 if b.score[k] <= radius2 else 0
    for j in range(n):
        k = uint64(b.listed[j])
        counts[uint64(begin + standing_sheet(b.sheet[k]))] += 1
    return live
