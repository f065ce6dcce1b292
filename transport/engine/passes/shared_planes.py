"""Flat surfaces that share part of a plane with a face of a Box: each acts on its sides (scene/sheets.py).

A sheet's rows come in the order of their precedence, and the first that a ray meets there acts.
"""

from transport.compile import layout
from transport.engine.bodies import lane_pass
from transport.engine.passes.flats import on_holed, on_triangle
from transport.engine.passes.intersections import crossing, meet_flat, on_disk, on_rectangle
from transport.physics.device import device


@device
def meet_on_side(lane, table, t, is_inside, is_edge):
    """Keep a flat surface crossed at t if it is the nearest ahead, acts there, and is the first to."""
    cosine = lane.ux * table.nx + lane.uy * table.ny + lane.uz * table.nz
    acts = (table.side * cosine <= 0.0) & (lane.hit_sheet != table.sheet)
    meet_flat(lane, table, t, is_inside & acts, is_edge)


@lane_pass(layout.RECTANGLE)
def meet_rectangle_on_side(lane, table):
    """Intersect rays with an acting rectangle on its side."""
    t, px, py, pz = crossing(lane, table, table.cx, table.cy, table.cz)
    is_inside, is_edge = on_rectangle(table, px, py, pz, t, True)
    meet_on_side(lane, table, t, is_inside, is_edge)


@lane_pass(layout.DISK)
def meet_disk_on_side(lane, table):
    """Intersect rays with an acting disk or annulus on its side."""
    t, px, py, pz = crossing(lane, table, table.cx, table.cy, table.cz)
    is_inside, is_edge = on_disk(table, px, py, pz, t, True)
    meet_on_side(lane, table, t, is_inside, is_edge)


@lane_pass(layout.TRIANGLE)
def meet_triangle_on_side(lane, table):
    """Intersect rays with an acting triangle on its side."""
    t, px, py, pz = crossing(lane, table, table.cx, table.cy, table.cz)
    is_inside, is_edge = on_triangle(table, px, py, pz, t)
    meet_on_side(lane, table, t, is_inside, is_edge)


@lane_pass(layout.HOLED)
def meet_holed_on_side(lane, table):
    """Intersect rays with an acting rectangle with a hole on its side."""
    t, px, py, pz = crossing(lane, table, table.cx, table.cy, table.cz)
    is_inside, is_edge = on_holed(table, px, py, pz, t, True)
    meet_on_side(lane, table, t, is_inside, is_edge)


@lane_pass(layout.PLANE)
def meet_plane_on_side(lane, table):
    """Intersect rays with an acting infinite plane on its side."""
    t, _, _, _ = crossing(lane, table, table.cx, table.cy, table.cz)
    meet_on_side(lane, table, t, True, False)
