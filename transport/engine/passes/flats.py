"""Flat shapes other than whole rectangles and disks: infinite planes, triangles, rectangles with a hole."""

import math

from transport.compile import layout
from transport.compile.layout import ROUNDING
from transport.engine.bodies import lane_pass
from transport.engine.passes.intersections import (
    cover_flat,
    crossing,
    is_ahead,
    keep_transparent,
    meet_flat,
    within_sides,
)
from transport.physics.device import choose, device


@device
def distance_from_hole(table, u, v):
    """Return the distance of a point (u, v) of the plane from the hole; negative inside the hole."""
    du, dv = u - table.hole_u, v - table.hole_v
    p, q = abs(table.hole_cos * du + table.hole_sin * dv), abs(table.hole_cos * dv - table.hole_sin * du)
    round_ = math.sqrt(p * p + q * q) - table.half_p
    beyond_p, beyond_q = p - table.half_p, q - table.half_q
    square = beyond_p if beyond_p > beyond_q else beyond_q
    return round_ if table.half_q == 0.0 else square


@device
def on_holed(table, px, py, pz, t, reaches):
    """Return whether a point lies in a rectangle with a hole, and whether within rounding of its edge."""
    u = px * table.eux + py * table.euy + pz * table.euz
    v = px * table.evx + py * table.evy + pz * table.evz
    beyond, slack = distance_from_hole(table, u, v), ROUNDING * t if reaches else 0.0
    is_inside, is_edge = within_sides(u, v, table.half_u, table.half_v, table.inner_u, table.inner_v, slack)
    return is_inside & (beyond + slack >= 0.0), is_edge | (beyond < table.margin)


@device
def on_triangle(table, px, py, pz, t):
    """Return whether a point lies in a triangle, and whether within rounding of its edge.

    t: distance of the ray's origin.
    It reaches over an edge of an acting triangle, and over one between the triangles of a polygon, so that no
    ray passes between two; over another edge of a detector its reach is 0.
    """
    p = px * table.ax + py * table.ay + pz * table.az
    q = px * table.bx + py * table.by + pz * table.bz
    r, beyond = 1.0 - p - q, table.slack + ROUNDING * t
    is_inside = (p >= -beyond * table.reach_a) & (q >= -beyond * table.reach_b)
    is_inside &= r >= -beyond * table.reach_c
    return is_inside, (p < table.least_a) | (q < table.least_b) | (r < table.least_c)


@lane_pass(layout.PLANE)
def meet_plane(lane, table):
    """Intersect rays with an acting infinite plane; keep it if it is the nearest surface ahead."""
    t, _, _, _ = crossing(lane, table, table.cx, table.cy, table.cz)
    meet_flat(lane, table, t, True, False)


@lane_pass(layout.PLANE)
def cover_plane(lane, table):
    """Intersect rays with a transparent detector on a plane; keep it if its sheet is the nearest ahead.

    On the sheet of the nearest hit, adds its bit to the hit.
    """
    t, _, _, _ = crossing(lane, table, table.sx, table.sy, table.sz)
    cover_flat(lane, table, t, t < math.inf, table.covers)


@device
def cover_two(lane, table, t, other_t):
    """Keep the nearer ahead of two detectors on planes at these distances, as `cover_plane` does.

    The planes are of two sheets: planes of one sheet are one shape.
    """
    one, other, start, places = table.one, table.other, lane.start, lane.sheet
    t = choose(is_ahead(t, start, one.sheet, places), t, math.inf)
    other_t = choose(is_ahead(other_t, start, other.sheet, places), other_t, math.inf)
    takes_other = other_t < t
    hit, sheet = choose(takes_other, other.hit, one.hit), choose(takes_other, other.sheet, one.sheet)
    t, bits = choose(takes_other, other_t, t), choose(takes_other, other.covers, one.covers)
    keep_transparent(lane, hit, t, t < math.inf, lane.hit_sheet == sheet, bits)


@lane_pass(layout.PLANES)
def cover_planes(lane, table):
    """Intersect rays with two parallel planes (as of a Slab), with one division by the cosine."""
    one, other = table.one, table.other
    nx, ny, nz = one.nx, one.ny, one.nz
    x, y, z = lane.x, lane.y, lane.z
    inverse = 1.0 / (lane.ux * nx + lane.uy * ny + lane.uz * nz)
    t = ((one.sx - x) * nx + (one.sy - y) * ny + (one.sz - z) * nz) * inverse
    other_t = ((other.sx - x) * nx + (other.sy - y) * ny + (other.sz - z) * nz) * inverse
    cover_two(lane, table, t, other_t)


@lane_pass(layout.PLANES)
def cover_planes_x(lane, table):
    """Intersect rays with two planes across the x axis: the same digits without the products by 0 and 1."""
    inverse = 1.0 / lane.ux
    cover_two(lane, table, (table.one.sx - lane.x) * inverse, (table.other.sx - lane.x) * inverse)


@lane_pass(layout.PLANES)
def cover_planes_y(lane, table):
    """Intersect rays with two planes across the y axis."""
    inverse = 1.0 / lane.uy
    cover_two(lane, table, (table.one.sy - lane.y) * inverse, (table.other.sy - lane.y) * inverse)


@lane_pass(layout.PLANES)
def cover_planes_z(lane, table):
    """Intersect rays with two planes across the z axis."""
    inverse = 1.0 / lane.uz
    cover_two(lane, table, (table.one.sz - lane.z) * inverse, (table.other.sz - lane.z) * inverse)


@lane_pass(layout.TRIANGLE)
def meet_triangle(lane, table):
    """Intersect rays with an acting triangle; keep it if it is the nearest surface ahead."""
    t, px, py, pz = crossing(lane, table, table.cx, table.cy, table.cz)
    is_inside, is_edge = on_triangle(table, px, py, pz, t)
    meet_flat(lane, table, t, is_inside, is_edge)


@lane_pass(layout.TRIANGLE)
def cover_triangle(lane, table):
    """Intersect rays with a transparent detector on a triangle; keep it if its sheet is the nearest ahead.

    On the sheet of the nearest hit, adds its bit to the hit.
    """
    t, px, py, pz = crossing(lane, table, table.sx, table.sy, table.sz)
    is_inside, _ = on_triangle(table, px, py, pz, abs(t))
    cover_flat(lane, table, t, is_inside, table.covers)


@lane_pass(layout.HOLED)
def meet_holed(lane, table):
    """Intersect rays with an acting rectangle with a hole; keep it if it is the nearest surface ahead."""
    t, px, py, pz = crossing(lane, table, table.cx, table.cy, table.cz)
    is_inside, is_edge = on_holed(table, px, py, pz, t, True)
    meet_flat(lane, table, t, is_inside, is_edge)


@lane_pass(layout.HOLED)
def cover_holed(lane, table):
    """Intersect rays with a transparent detector on a rectangle with a hole; keep it if nearest.

    On the sheet of the nearest hit, adds its bit to the hit.
    """
    t, px, py, pz = crossing(lane, table, table.sx, table.sy, table.sz)
    is_inside, _ = on_holed(table, px, py, pz, t, False)
    cover_flat(lane, table, t, is_inside, table.covers)
