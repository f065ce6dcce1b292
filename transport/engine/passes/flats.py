"""Flat shapes other than whole rectangles and disks: infinite planes, triangles, rectangles with a hole."""

import math

from transport.compile import layout
from transport.compile.layout import ROUNDING
from transport.engine.bodies import lane_pass
from transport.engine.passes.intersections import is_ahead, keep_acting, keep_transparent
from transport.engine.words import standing_sheet
from transport.physics.device import device
from transport.physics.rays import plane_crossing


@device
def distance_from_hole(u, v, hole_u, hole_v, hole_cos, hole_sin, half_p, half_q):
    """Return the distance of a point (u, v) of the plane from the hole; negative inside the hole."""
    du, dv = u - hole_u, v - hole_v
    p, q = abs(hole_cos * du + hole_sin * dv), abs(hole_cos * dv - hole_sin * du)
    round_ = math.sqrt(p * p + q * q) - half_p
    beyond_p, beyond_q = p - half_p, q - half_q
    square = beyond_p if beyond_p > beyond_q else beyond_q
    return round_ if half_q == 0.0 else square


@lane_pass(layout.PLANE)
def meet_plane(lane, table):
    """Intersect rays with an acting infinite plane; keep it if it is the nearest surface ahead."""
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    sheet = table.sheet
    ux, uy, uz = lane.ux, lane.uy, lane.uz
    t, _, _, _ = plane_crossing(cx - lane.x, cy - lane.y, cz - lane.z, ux, uy, uz, nx, ny, nz)
    nearer = (t < lane.distance) & (t > lane.start) & (standing_sheet(lane.sheet) != sheet)
    keep_acting(lane, table, t, nearer, False)


@device
def keep_plane(lane, table, t):
    """Keep a detector's plane at t as the next hit if it is the nearest ahead."""
    covers = (t < math.inf) & is_ahead(t, lane.start, table.sheet, lane.sheet)
    keep_transparent(lane, table, t, covers, lane.hit_sheet == table.sheet, table.covers)


@lane_pass(layout.PLANE)
def cover_plane(lane, table):
    """Intersect rays with a transparent detector on a plane; keep it if its sheet is the nearest ahead.

    On the sheet of the nearest hit, adds its bit to the hit.
    """
    nx, ny, nz, sx, sy, sz = table.nx, table.ny, table.nz, table.sx, table.sy, table.sz
    ux, uy, uz = lane.ux, lane.uy, lane.uz
    t, _, _, _ = plane_crossing(sx - lane.x, sy - lane.y, sz - lane.z, ux, uy, uz, nx, ny, nz)
    keep_plane(lane, table, t)


@lane_pass(layout.PLANES)
def cover_planes(lane, table):
    """Intersect rays with two parallel planes (as of a Slab), with one division by the cosine."""
    one, other = table.one, table.other
    nx, ny, nz, sx, sy, sz = one.nx, one.ny, one.nz, one.sx, one.sy, one.sz
    ox, oy, oz = other.sx, other.sy, other.sz
    x, y, z = lane.x, lane.y, lane.z
    inverse = 1.0 / (lane.ux * nx + lane.uy * ny + lane.uz * nz)
    t = ((sx - x) * nx + (sy - y) * ny + (sz - z) * nz) * inverse
    keep_plane(lane, one, t)
    t = ((ox - x) * nx + (oy - y) * ny + (oz - z) * nz) * inverse
    keep_plane(lane, other, t)


@lane_pass(layout.TRIANGLE)
def meet_triangle(lane, table):
    """Intersect rays with an acting triangle; keep it if it is the nearest surface ahead."""
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    ax, ay, az, bx, by, bz = table.ax, table.ay, table.az, table.bx, table.by, table.bz
    reach_a, reach_b, reach_c, slack = table.reach_a, table.reach_b, table.reach_c, table.slack
    least_a, least_b, least_c = table.least_a, table.least_b, table.least_c
    sheet = table.sheet
    ux, uy, uz = lane.ux, lane.uy, lane.uz
    t, px, py, pz = plane_crossing(cx - lane.x, cy - lane.y, cz - lane.z, ux, uy, uz, nx, ny, nz)
    p, q = px * ax + py * ay + pz * az, px * bx + py * by + pz * bz
    r, beyond = 1.0 - p - q, slack + ROUNDING * t
    nearer = (p >= -beyond * reach_a) & (q >= -beyond * reach_b) & (r >= -beyond * reach_c)
    nearer &= (t < lane.distance) & (t > lane.start) & (standing_sheet(lane.sheet) != sheet)
    edge = (p < least_a) | (q < least_b) | (r < least_c)
    keep_acting(lane, table, t, nearer, edge)


@lane_pass(layout.TRIANGLE)
def cover_triangle(lane, table):
    """Intersect rays with a transparent detector on a triangle; keep it if its sheet is the nearest ahead.

    On the sheet of the nearest hit, adds its bit to the hit. The triangles of a polygon reach over the sides
    between them by rounding, so that no ray passes between two; elsewhere their reach is 0.
    """
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    sx, sy, sz = table.sx, table.sy, table.sz
    ax, ay, az, bx, by, bz = table.ax, table.ay, table.az, table.bx, table.by, table.bz
    reach_a, reach_b, reach_c, slack = table.reach_a, table.reach_b, table.reach_c, table.slack
    sheet = table.sheet
    ux, uy, uz = lane.ux, lane.uy, lane.uz
    rx, ry, rz = cx - lane.x, cy - lane.y, cz - lane.z
    t, _, _, _ = plane_crossing(sx - lane.x, sy - lane.y, sz - lane.z, ux, uy, uz, nx, ny, nz)
    px, py, pz = t * ux - rx, t * uy - ry, t * uz - rz
    p, q = px * ax + py * ay + pz * az, px * bx + py * by + pz * bz
    same = lane.hit_sheet == sheet
    beyond = slack + ROUNDING * abs(t)
    covers = (p >= -beyond * reach_a) & (q >= -beyond * reach_b) & (p + q <= 1.0 + beyond * reach_c)
    covers &= is_ahead(t, lane.start, sheet, lane.sheet)
    keep_transparent(lane, table, t, covers, same, table.covers)


@lane_pass(layout.HOLED)
def meet_holed(lane, table):
    """Intersect rays with an acting rectangle with a hole; keep it if it is the nearest surface ahead."""
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    half_u, half_v, inner_u, inner_v = table.half_u, table.half_v, table.inner_u, table.inner_v
    hole_u, hole_v, hole_cos, hole_sin = table.hole_u, table.hole_v, table.hole_cos, table.hole_sin
    half_p, half_q, margin, sheet = table.half_p, table.half_q, table.margin, table.sheet
    ux, uy, uz = lane.ux, lane.uy, lane.uz
    t, px, py, pz = plane_crossing(cx - lane.x, cy - lane.y, cz - lane.z, ux, uy, uz, nx, ny, nz)
    pu, pv, slack = px * eux + py * euy + pz * euz, px * evx + py * evy + pz * evz, ROUNDING * t
    u, v = abs(pu), abs(pv)
    beyond = distance_from_hole(pu, pv, hole_u, hole_v, hole_cos, hole_sin, half_p, half_q)
    nearer = (u - slack <= half_u) & (v - slack <= half_v) & (beyond + slack >= 0.0) & (t < lane.distance)
    nearer &= (t > lane.start) & (standing_sheet(lane.sheet) != sheet)
    edge = (u > inner_u) | (v > inner_v) | (beyond < margin)
    keep_acting(lane, table, t, nearer, edge)


@lane_pass(layout.HOLED)
def cover_holed(lane, table):
    """Intersect rays with a transparent detector on a rectangle with a hole; keep it if nearest.

    On the sheet of the nearest hit, adds its bit to the hit.
    """
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    sx, sy, sz = table.sx, table.sy, table.sz
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    half_u, half_v, sheet = table.half_u, table.half_v, table.sheet
    hole_u, hole_v, hole_cos, hole_sin = table.hole_u, table.hole_v, table.hole_cos, table.hole_sin
    half_p, half_q = table.half_p, table.half_q
    ux, uy, uz = lane.ux, lane.uy, lane.uz
    rx, ry, rz = cx - lane.x, cy - lane.y, cz - lane.z
    t, _, _, _ = plane_crossing(sx - lane.x, sy - lane.y, sz - lane.z, ux, uy, uz, nx, ny, nz)
    px, py, pz = t * ux - rx, t * uy - ry, t * uz - rz
    u, v = px * eux + py * euy + pz * euz, px * evx + py * evy + pz * evz
    beyond = distance_from_hole(u, v, hole_u, hole_v, hole_cos, hole_sin, half_p, half_q)
    same = lane.hit_sheet == sheet
    covers = (abs(u) <= half_u) & (abs(v) <= half_v) & (beyond >= 0.0)
    covers &= is_ahead(t, lane.start, sheet, lane.sheet)
    keep_transparent(lane, table, t, covers, same, table.covers)
