"""Ray tracing to the next crossing: find the nearest sheet ahead, move there, or leave the scene.

An acting surface accepts a ray that rounding carried past its edge, so that no ray slips between two walls
with a common edge; layout.ROUNDING and the slack of compile/compiler.py bound that rounding. A detector uses
its exact bounds.
"""

import math

from transport.compile import layout
from transport.compile.layout import EDGE, ROUNDING
from transport.engine.bodies import lane_pass
from transport.engine.tally import add_lost, add_to_ledger, limbs
from transport.engine.words import passed_sheet, standing_sheet
from transport.physics.device import choose, device
from transport.physics.directions import select
from transport.physics.rays import plane_crossing, sphere_crossing


@device
def is_ahead(t, start, sheet, places):
    """Return whether a detector lies further along the ray.

    Of detectors that meet in a line, the next number is next. places: the lane's `sheet` word; the sheets
    that the ray began on or passed last do not count.
    """
    passed = passed_sheet(places)
    further = (t > start) & (passed != sheet)
    is_next = (t == start) & (passed != 0) & (passed < sheet)
    return (further | is_next) & (standing_sheet(places) != sheet)


@device
def is_box_face_passed(t, start, tie, leaves, places):
    """Return whether another face of this face's box was entered, or left, at this very point (on an edge).

    tie: number of the box's first sheet.
    """
    return (t == start) & (passed_sheet(places) >= tie) & (((places & layout.LEFT_BOX) != 0) == leaves)


@device
def keep_acting(lane, table, t, nearer, is_edge):
    """Keep an acting surface at t as the next hit if it is nearer; is_edge: within rounding of its edge."""
    covers = table.covers | EDGE if is_edge else table.covers
    lane.distance = choose(nearer, t, lane.distance)
    lane.hit = choose(nearer, table.hit, lane.hit)
    lane.covered = choose(nearer, covers, lane.covered)


@device
def keep_transparent(lane, table, t, covers, same, bits):
    """Keep a transparent detector or boundary at t as the next hit, if it covers the point and is nearer.

    On the sheet of the nearest hit (`same`) its bits are added.
    """
    nearer = covers & ((t < lane.distance) | same)
    replaces = nearer & (not same)
    lane.distance = choose(replaces, t, lane.distance)
    lane.hit = choose(replaces, table.hit, lane.hit)
    lane.covered = choose(nearer, lane.covered | bits if same else bits, lane.covered)


@lane_pass(layout.NO_TABLE)
def reset_hit(lane, table):
    """Reset the nearest hit: infinite distance, no sheet."""
    lane.distance = math.inf
    lane.hit, lane.covered = 0, 0


@lane_pass(layout.RECTANGLE)
def meet_rectangle(lane, table):
    """Intersect rays with an acting rectangle; keep it if it is the nearest surface ahead.

    Sets bit EDGE of the hit within rounding of the rectangle's edge.
    """
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    half_u, half_v, inner_u, inner_v = table.half_u, table.half_v, table.inner_u, table.inner_v
    sheet = table.sheet
    ux, uy, uz = lane.ux, lane.uy, lane.uz
    t, px, py, pz = plane_crossing(cx - lane.x, cy - lane.y, cz - lane.z, ux, uy, uz, nx, ny, nz)
    u, v, slack = abs(px * eux + py * euy + pz * euz), abs(px * evx + py * evy + pz * evz), ROUNDING * t
    nearer = (u - slack <= half_u) & (v - slack <= half_v) & (t < lane.distance)
    nearer &= (t > lane.start) & (standing_sheet(lane.sheet) != sheet)
    edge = (u > inner_u) | (v > inner_v)
    keep_acting(lane, table, t, nearer, edge)


@lane_pass(layout.RECTANGLE)
def cover_rectangle(lane, table):
    """Intersect rays with a rectangular transparent detector; keep it if its sheet is the nearest ahead.

    On the sheet of the nearest hit, adds its bit to the hit.
    """
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    sx, sy, sz, tie, outward = table.sx, table.sy, table.sz, table.tie, table.outward
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    half_u, half_v, sheet = table.half_u, table.half_v, table.sheet
    ux, uy, uz = lane.ux, lane.uy, lane.uz
    rx, ry, rz = cx - lane.x, cy - lane.y, cz - lane.z
    t, _, _, _ = plane_crossing(sx - lane.x, sy - lane.y, sz - lane.z, ux, uy, uz, nx, ny, nz)
    px, py, pz = t * ux - rx, t * uy - ry, t * uz - rz
    u, v = abs(px * eux + py * euy + pz * euz), abs(px * evx + py * evy + pz * evz)
    leaves = outward * (ux * nx + uy * ny + uz * nz) > 0.0
    same = lane.hit_sheet == sheet
    covers = (u <= half_u) & (v <= half_v) & is_ahead(t, lane.start, sheet, lane.sheet)
    covers &= not is_box_face_passed(t, lane.start, tie, leaves, lane.sheet)
    keep_transparent(lane, table, t, covers, same, table.covers)


# ---- Rectangles aligned with the axes: the same digits without the products by 0 and 1.


@device
def meet_aligned(lane, table, x, y, z, ux, uy, uz, cx, cy, cz):
    """Intersect rays with an acting rectangle as `meet_rectangle` does; x: along its normal."""
    t = (cx - x) / ux
    v, w, slack = abs(t * uy - (cy - y)), abs(t * uz - (cz - z)), ROUNDING * t
    nearer = (v - slack <= table.half_next) & (w - slack <= table.half_last) & (t < lane.distance)
    nearer &= (t > lane.start) & (standing_sheet(lane.sheet) != table.sheet)
    edge = (v > table.inner_next) | (w > table.inner_last)
    keep_acting(lane, table, t, nearer, edge)


@device
def cover_aligned(lane, table, x, y, z, ux, uy, uz, sx, cy, cz, nx):
    """Intersect rays with a transparent rectangle as `cover_rectangle` does; x: along its normal."""
    t = (sx - x) / ux
    v, w = abs(t * uy - (cy - y)), abs(t * uz - (cz - z))
    leaves = table.outward * (ux * nx) > 0.0
    covers = (v <= table.half_next) & (w <= table.half_last)
    covers &= is_ahead(t, lane.start, table.sheet, lane.sheet)
    covers &= not is_box_face_passed(t, lane.start, table.tie, leaves, lane.sheet)
    keep_transparent(lane, table, t, covers, lane.hit_sheet == table.sheet, table.covers)


@lane_pass(layout.RECTANGLE)
def meet_rectangle_x(lane, table):
    """Intersect rays with an acting rectangle across the x axis."""
    x, y, z, ux, uy, uz = lane.x, lane.y, lane.z, lane.ux, lane.uy, lane.uz
    meet_aligned(lane, table, x, y, z, ux, uy, uz, table.cx, table.cy, table.cz)


@lane_pass(layout.RECTANGLE)
def meet_rectangle_y(lane, table):
    """Intersect rays with an acting rectangle across the y axis."""
    x, y, z, ux, uy, uz = lane.x, lane.y, lane.z, lane.ux, lane.uy, lane.uz
    meet_aligned(lane, table, y, z, x, uy, uz, ux, table.cy, table.cz, table.cx)


@lane_pass(layout.RECTANGLE)
def meet_rectangle_z(lane, table):
    """Intersect rays with an acting rectangle across the z axis."""
    x, y, z, ux, uy, uz = lane.x, lane.y, lane.z, lane.ux, lane.uy, lane.uz
    meet_aligned(lane, table, z, x, y, uz, ux, uy, table.cz, table.cx, table.cy)


@lane_pass(layout.RECTANGLE)
def cover_rectangle_x(lane, table):
    """Intersect rays with a transparent rectangle across the x axis."""
    x, y, z, ux, uy, uz = lane.x, lane.y, lane.z, lane.ux, lane.uy, lane.uz
    cover_aligned(lane, table, x, y, z, ux, uy, uz, table.sx, table.cy, table.cz, table.nx)


@lane_pass(layout.RECTANGLE)
def cover_rectangle_y(lane, table):
    """Intersect rays with a transparent rectangle across the y axis."""
    x, y, z, ux, uy, uz = lane.x, lane.y, lane.z, lane.ux, lane.uy, lane.uz
    cover_aligned(lane, table, y, z, x, uy, uz, ux, table.sy, table.cz, table.cx, table.ny)


@lane_pass(layout.RECTANGLE)
def cover_rectangle_z(lane, table):
    """Intersect rays with a transparent rectangle across the z axis."""
    x, y, z, ux, uy, uz = lane.x, lane.y, lane.z, lane.ux, lane.uy, lane.uz
    cover_aligned(lane, table, z, x, y, uz, ux, uy, table.sz, table.cx, table.cy, table.nz)


@lane_pass(layout.RECTANGLE)
def bound_rectangle(lane, table):
    """Intersect rays with a rectangular boundary of a medium; keep it if its sheet is the nearest ahead.

    Like an acting surface, it accepts rays that rounding carried past its edge.
    """
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    sx, sy, sz = table.sx, table.sy, table.sz
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    half_u, half_v, inner_u, inner_v = table.half_u, table.half_v, table.inner_u, table.inner_v
    sheet = table.sheet
    ux, uy, uz = lane.ux, lane.uy, lane.uz
    rx, ry, rz = cx - lane.x, cy - lane.y, cz - lane.z
    t, _, _, _ = plane_crossing(sx - lane.x, sy - lane.y, sz - lane.z, ux, uy, uz, nx, ny, nz)
    px, py, pz, slack = t * ux - rx, t * uy - ry, t * uz - rz, ROUNDING * t
    u, v = abs(px * eux + py * euy + pz * euz), abs(px * evx + py * evy + pz * evz)
    found = table.covers | EDGE if (u > inner_u) | (v > inner_v) else table.covers
    same = lane.hit_sheet == sheet
    covers = (u - slack <= half_u) & (v - slack <= half_v) & is_ahead(t, lane.start, sheet, lane.sheet)
    keep_transparent(lane, table, t, covers, same, found)


@lane_pass(layout.DISK)
def meet_disk(lane, table):
    """Intersect rays with an acting disk or annulus; keep it if it is the nearest surface ahead."""
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    inner2, outer2, breadth, sheet = table.inner2, table.outer2, table.breadth, table.sheet
    least2, most2 = table.least2, table.most2
    ux, uy, uz = lane.ux, lane.uy, lane.uz
    t, px, py, pz = plane_crossing(cx - lane.x, cy - lane.y, cz - lane.z, ux, uy, uz, nx, ny, nz)
    r2, slack = px * px + py * py + pz * pz, ROUNDING * breadth * t
    nearer = (r2 - slack <= outer2) & (r2 + slack >= inner2) & (t < lane.distance)
    nearer &= (t > lane.start) & (standing_sheet(lane.sheet) != sheet)
    edge = (r2 > most2) | (r2 < least2)
    keep_acting(lane, table, t, nearer, edge)


@lane_pass(layout.DISK)
def cover_disk(lane, table):
    """Intersect rays with a transparent detector on a disk; keep it if its sheet is the nearest ahead.

    On the sheet of the nearest hit, adds its bit to the hit.
    """
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    sx, sy, sz = table.sx, table.sy, table.sz
    inner2, outer2, sheet = table.inner2, table.outer2, table.sheet
    ux, uy, uz = lane.ux, lane.uy, lane.uz
    rx, ry, rz = cx - lane.x, cy - lane.y, cz - lane.z
    t, _, _, _ = plane_crossing(sx - lane.x, sy - lane.y, sz - lane.z, ux, uy, uz, nx, ny, nz)
    px, py, pz = t * ux - rx, t * uy - ry, t * uz - rz
    r2 = px * px + py * py + pz * pz
    same = lane.hit_sheet == sheet
    covers = (r2 <= outer2) & (r2 >= inner2) & is_ahead(t, lane.start, sheet, lane.sheet)
    keep_transparent(lane, table, t, covers, same, table.covers)


@lane_pass(layout.SPHERE)
def meet_sphere(lane, table):
    """Intersect rays with an acting sphere; keep it if it is the nearest surface ahead."""
    cx, cy, cz, radius, sheet = table.cx, table.cy, table.cz, table.radius, table.sheet
    ox, oy, oz = lane.x - cx, lane.y - cy, lane.z - cz
    standing, start = standing_sheet(lane.sheet) == sheet, lane.start
    own = start if start < 0.0 else 0.0  # ray parameter of the origin
    t = sphere_crossing(ox, oy, oz, lane.ux, lane.uy, lane.uz, radius, start, standing, own, False, False)
    nearer = t < lane.distance
    keep_acting(lane, table, t, nearer, False)


@lane_pass(layout.SPHERE)
def cover_sphere(lane, table):
    """Intersect rays with a transparent detector on a sphere; keep it if its sheet is the nearest ahead.

    On the sheet of the nearest hit, adds its bit to the hit.
    """
    cx, cy, cz, radius, sheet = table.cx, table.cy, table.cz, table.radius, table.sheet
    ox, oy, oz = lane.x - cx, lane.y - cy, lane.z - cz
    start, last = lane.start, passed_sheet(lane.sheet)
    standing = standing_sheet(lane.sheet) == sheet
    own = start if start < 0.0 else 0.0
    # Of detectors that meet in a line, the next number is next.
    closed = (last != 0) & (sheet > last)
    t = sphere_crossing(
        ox, oy, oz, lane.ux, lane.uy, lane.uz, radius, start, standing, own, closed, last == sheet
    )
    other = -2.0 * (ox * lane.ux + oy * lane.uy + oz * lane.uz) - t
    # the hit is the other crossing, found by a zone of the same sphere
    is_other = abs(t - lane.distance) > abs(other - lane.distance)
    same = (lane.hit_sheet == sheet) & (not is_other)
    keep_transparent(lane, table, t, t < math.inf, same, table.covers)


@device
def is_finite(lane):
    """Return whether position, direction and weight are finite."""
    return abs(lane.x + lane.y + lane.z + lane.ux + lane.uy + lane.uz + lane.weight) < math.inf


@device
def is_lost(lane, table):
    """Return whether a particle's state is not finite."""
    return (lane.weight != 0.0) & (not is_finite(lane))


@lane_pass(layout.NO_TABLE, when=is_lost)
def end_not_finite(lane, table):
    """End particles whose state is not finite, as lost."""
    add_lost(lane, lane.weight)
    lane.weight = 0.0


@device
def add_escaped(lane, table, high, low, crossings):
    """Add to the escaped weight, and to the number of crossings."""
    add_to_ledger(lane, layout.ESCAPED, high, low)
    lane.crossings += crossings


@lane_pass(layout.NO_TABLE, sums=add_escaped)
def end_escaped(lane, table):
    """End particles without a surface ahead as escaped, and count the crossings of the others."""
    weight, gone = lane.weight, lane.distance == math.inf
    high, low = limbs(weight if gone else 0.0)
    lane.weight = 0.0 if gone else weight
    return high, low, 0 if gone | (weight == 0.0) else 1


@lane_pass(layout.NO_TABLE)
def move(lane, table):
    """Move each lane along its ray to the hit."""
    d = lane.distance if lane.hit != 0 else 0.0  # idle lanes stay in place
    lane.x += d * lane.ux
    lane.y += d * lane.uy
    lane.z += d * lane.uz
    lane.start = 0.0


@lane_pass(layout.NO_TABLE)
def save_ray(lane, table):
    """Keep the origin of the ray, in scenes with detectors that other surfaces may touch."""
    lane.rx, lane.ry, lane.rz = lane.x, lane.y, lane.z
    # The x of an aimed ray is its target: such a ray began on no sheet.
    lane.ray_sheet = standing_sheet(lane.sheet) if lane.start >= 0.0 else 0


@lane_pass(layout.NO_TABLE)
def restore_ray(lane, table):
    """Restore the origin of the ray after a transparent detector; `start` becomes the crossing's distance.

    All crossings of a ray are thus computed from one origin: a wall that touches a detector lies behind or
    before it, never at a distance of 0 that rounding takes for passed.
    """
    passes = (lane.hit != 0) & (lane.surface == 0)
    lane.x, lane.y, lane.z = select(passes, lane.rx, lane.ry, lane.rz, lane.x, lane.y, lane.z)
    lane.start = choose(passes, lane.distance, lane.start)
    lane.sheet = choose(passes, (lane.sheet << layout.PASSED_SHIFT) | lane.ray_sheet, lane.sheet)
