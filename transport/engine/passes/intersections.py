"""Ray tracing to the next crossing: find the nearest sheet ahead, move there, or leave the scene.

An acting surface accepts a ray that rounding carried past its edge, so that no ray slips between two walls
with a common edge; layout.ROUNDING and compile.surfaces.edge_slack bound that rounding. A detector uses
its exact bounds.
"""

import math

from transport.compile import layout
from transport.compile.layout import EDGE, ROUNDING
from transport.engine.bodies import lane_pass
from transport.engine.passes.lanes import is_finite
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
def is_box_face_passed(lane, table, t, cosine):
    """Return whether another face of this face's box was entered, or left, at this very point (on an edge).

    table.tie: number of the box's first sheet.
    """
    leaves = table.outward * cosine > 0.0
    left = (lane.sheet & layout.LEFT_BOX) != 0
    return (t == lane.start) & (passed_sheet(lane.sheet) >= table.tie) & (left == leaves)


@device
def keep_acting(lane, table, t, nearer, is_edge):
    """Keep an acting surface at t as the next hit if it is nearer; is_edge: within rounding of its edge."""
    covers = table.covers | EDGE if is_edge else table.covers
    lane.distance = choose(nearer, t, lane.distance)
    lane.hit = choose(nearer, table.hit, lane.hit)
    lane.covered = choose(nearer, covers, lane.covered)


@device
def meet_flat(lane, table, t, is_inside, is_edge):
    """Keep a flat acting surface crossed inside its edge at t, if it is the nearest ahead."""
    nearer = (t < lane.distance) & (t > lane.start) & (standing_sheet(lane.sheet) != table.sheet) & is_inside
    keep_acting(lane, table, t, nearer, is_edge)


@device
def keep_transparent(lane, hit, t, covers, same, bits):
    """Keep a transparent detector or boundary at t as the next hit, if it covers the point and is nearer.

    On the sheet of the nearest hit (`same`) its bits are added.
    """
    t = choose(covers, t, math.inf)
    bits = choose(same, lane.covered | bits, bits)
    lane.covered = choose(t < choose(same, math.inf, lane.distance), bits, lane.covered)
    replaces = choose(same, math.inf, t) < lane.distance
    lane.distance = choose(replaces, t, lane.distance)
    lane.hit = choose(replaces, hit, lane.hit)


@device
def cover_curved(lane, table, t, other):
    """Keep a curved transparent detector at t as the next hit, if it is the nearest ahead.

    other: its other crossing, which may be the hit of a part of the same sheet.
    """
    is_other = abs(t - lane.distance) > abs(other - lane.distance)
    same = (lane.hit_sheet == table.sheet) & (not is_other)
    keep_transparent(lane, table.hit, t, t < math.inf, same, table.covers)


@device
def cover_flat(lane, table, t, is_inside, bits):
    """Keep a flat transparent shape crossed inside its edge at t, if its sheet is the nearest ahead."""
    covers = is_ahead(t, lane.start, table.sheet, lane.sheet) & is_inside
    keep_transparent(lane, table.hit, t, covers, lane.hit_sheet == table.sheet, bits)


@lane_pass(layout.NO_TABLE)
def reset_hit(lane, table):
    """Reset the nearest hit: infinite distance, no sheet."""
    lane.distance = math.inf
    lane.hit, lane.covered = 0, 0


# ---- Flat shapes. An acting surface lies in its own plane through c, a transparent one in that of its sheet
# through s.
#
# on_...(table, px, py, pz, t, reaches) returns whether a point p relative to c lies inside the edge, and
# whether it lies within rounding of it. reaches: whether the shape accepts rays that rounding carried past
# its edge; t: distance of their origin.


@device
def crossing(lane, table, sx, sy, sz):
    """Return the distance to the plane of a flat shape through s, and the crossing relative to its c."""
    nx, ny, nz, ux, uy, uz = table.nx, table.ny, table.nz, lane.ux, lane.uy, lane.uz
    t, _, _, _ = plane_crossing(sx - lane.x, sy - lane.y, sz - lane.z, ux, uy, uz, nx, ny, nz)
    rx, ry, rz = table.cx - lane.x, table.cy - lane.y, table.cz - lane.z
    return t, t * ux - rx, t * uy - ry, t * uz - rz


@device
def within_sides(u, v, half_u, half_v, inner_u, inner_v, slack):
    """Return whether |u| and |v| lie within the half sides of a rectangle, and whether near its edge."""
    u, v = abs(u), abs(v)
    return (u - slack <= half_u) & (v - slack <= half_v), (u > inner_u) | (v > inner_v)


@device
def on_rectangle(table, px, py, pz, t, reaches):
    """Return whether a point lies in a rectangle, and whether within rounding of its edge."""
    u = px * table.eux + py * table.euy + pz * table.euz
    v = px * table.evx + py * table.evy + pz * table.evz
    slack = ROUNDING * t if reaches else 0.0
    return within_sides(u, v, table.half_u, table.half_v, table.inner_u, table.inner_v, slack)


@device
def on_disk(table, px, py, pz, t, reaches):
    """Return whether a point lies in a disk or annulus, and whether within rounding of its edge."""
    r2, slack = px * px + py * py + pz * pz, ROUNDING * table.breadth * t if reaches else 0.0
    is_edge = (r2 > table.most2) | (r2 < table.least2)
    return (r2 - slack <= table.outer2) & (r2 + slack >= table.inner2), is_edge


@lane_pass(layout.RECTANGLE)
def meet_rectangle(lane, table):
    """Intersect rays with an acting rectangle; keep it if it is the nearest surface ahead.

    Sets bit EDGE of the hit within rounding of the rectangle's edge.
    """
    t, px, py, pz = crossing(lane, table, table.cx, table.cy, table.cz)
    is_inside, is_edge = on_rectangle(table, px, py, pz, t, True)
    meet_flat(lane, table, t, is_inside, is_edge)


@lane_pass(layout.RECTANGLE)
def cover_rectangle(lane, table):
    """Intersect rays with a rectangular transparent detector; keep it if its sheet is the nearest ahead.

    On the sheet of the nearest hit, adds its bit to the hit.
    """
    t, px, py, pz = crossing(lane, table, table.sx, table.sy, table.sz)
    is_inside, _ = on_rectangle(table, px, py, pz, t, False)
    cosine = lane.ux * table.nx + lane.uy * table.ny + lane.uz * table.nz
    is_inside &= not is_box_face_passed(lane, table, t, cosine)
    cover_flat(lane, table, t, is_inside, table.covers)


@lane_pass(layout.RECTANGLE)
def bound_rectangle(lane, table):
    """Intersect rays with a rectangular boundary of a medium; keep it if its sheet is the nearest ahead.

    Like an acting surface, it accepts rays that rounding carried past its edge.
    """
    t, px, py, pz = crossing(lane, table, table.sx, table.sy, table.sz)
    is_inside, is_edge = on_rectangle(table, px, py, pz, t, True)
    cover_flat(lane, table, t, is_inside, table.covers | EDGE if is_edge else table.covers)


@lane_pass(layout.DISK)
def meet_disk(lane, table):
    """Intersect rays with an acting disk or annulus; keep it if it is the nearest surface ahead."""
    t, px, py, pz = crossing(lane, table, table.cx, table.cy, table.cz)
    is_inside, is_edge = on_disk(table, px, py, pz, t, True)
    meet_flat(lane, table, t, is_inside, is_edge)


@lane_pass(layout.DISK)
def cover_disk(lane, table):
    """Intersect rays with a transparent detector on a disk; keep it if its sheet is the nearest ahead.

    On the sheet of the nearest hit, adds its bit to the hit.
    """
    t, px, py, pz = crossing(lane, table, table.sx, table.sy, table.sz)
    is_inside, _ = on_disk(table, px, py, pz, t, False)
    cover_flat(lane, table, t, is_inside, table.covers)


# ---- Rectangles aligned with the axes: the same digits without the products by 0 and 1. x: along the normal.


@device
def aligned_crossing(table, x, y, z, ux, uy, uz, sx, cy, cz, reaches):
    """Return the distance to an aligned rectangle's plane, and the same two answers as `on_rectangle`."""
    t = (sx - x) / ux
    v, w, slack = t * uy - (cy - y), t * uz - (cz - z), ROUNDING * t if reaches else 0.0
    is_inside, is_edge = within_sides(
        v, w, table.half_next, table.half_last, table.inner_next, table.inner_last, slack
    )
    return t, is_inside, is_edge


@device
def meet_aligned(lane, table, x, y, z, ux, uy, uz, cx, cy, cz):
    """Intersect rays with an acting rectangle as `meet_rectangle` does."""
    t, is_inside, is_edge = aligned_crossing(table, x, y, z, ux, uy, uz, cx, cy, cz, True)
    meet_flat(lane, table, t, is_inside, is_edge)


@device
def cover_aligned(lane, table, x, y, z, ux, uy, uz, sx, cy, cz, nx):
    """Intersect rays with a transparent rectangle as `cover_rectangle` does."""
    t, is_inside, _ = aligned_crossing(table, x, y, z, ux, uy, uz, sx, cy, cz, False)
    is_inside &= not is_box_face_passed(lane, table, t, ux * nx)
    cover_flat(lane, table, t, is_inside, table.covers)


@lane_pass(layout.RECTANGLE)
def meet_rectangle_x(lane, table):
    """Intersect rays with an acting rectangle across the x axis."""
    x, y, z, ux, uy, uz = lane.x, lane.y, lane.z, lane.ux, lane.uy, lane.uz
    meet_aligned(lane, table, x, y, z, ux, uy, uz, table.cx, table.cy, table.cz)


@lane_pass(layout.RECTANGLE)
def cover_rectangle_x(lane, table):
    """Intersect rays with a transparent rectangle across the x axis."""
    x, y, z, ux, uy, uz = lane.x, lane.y, lane.z, lane.ux, lane.uy, lane.uz
    cover_aligned(lane, table, x, y, z, ux, uy, uz, table.sx, table.cy, table.cz, table.nx)


@lane_pass(layout.RECTANGLE)
def meet_rectangle_y(lane, table):
    """Intersect rays with an acting rectangle across the y axis."""
    x, y, z, ux, uy, uz = lane.y, lane.z, lane.x, lane.uy, lane.uz, lane.ux
    meet_aligned(lane, table, x, y, z, ux, uy, uz, table.cy, table.cz, table.cx)


@lane_pass(layout.RECTANGLE)
def cover_rectangle_y(lane, table):
    """Intersect rays with a transparent rectangle across the y axis."""
    x, y, z, ux, uy, uz = lane.y, lane.z, lane.x, lane.uy, lane.uz, lane.ux
    cover_aligned(lane, table, x, y, z, ux, uy, uz, table.sy, table.cz, table.cx, table.ny)


@lane_pass(layout.RECTANGLE)
def meet_rectangle_z(lane, table):
    """Intersect rays with an acting rectangle across the z axis."""
    x, y, z, ux, uy, uz = lane.z, lane.x, lane.y, lane.uz, lane.ux, lane.uy
    meet_aligned(lane, table, x, y, z, ux, uy, uz, table.cz, table.cx, table.cy)


@lane_pass(layout.RECTANGLE)
def cover_rectangle_z(lane, table):
    """Intersect rays with a transparent rectangle across the z axis."""
    x, y, z, ux, uy, uz = lane.z, lane.x, lane.y, lane.uz, lane.ux, lane.uy
    cover_aligned(lane, table, x, y, z, ux, uy, uz, table.sz, table.cx, table.cy, table.nz)


# ---- Spheres.


@device
def next_on_sphere(lane, table, acts):
    """Return the distance to the next crossing of a sphere, and that to the other one.

    acts: whether an acting surface is crossed; of detectors that meet in a line, the next number is next.
    """
    ox, oy, oz = lane.x - table.cx, lane.y - table.cy, lane.z - table.cz
    start, last = lane.start, passed_sheet(lane.sheet)
    standing = standing_sheet(lane.sheet) == table.sheet
    own = start if start < 0.0 else 0.0  # ray parameter of the origin
    closed = (not acts) & (last != 0) & (table.sheet > last)
    passed = (not acts) & (last == table.sheet)
    ux, uy, uz = lane.ux, lane.uy, lane.uz
    t = sphere_crossing(ox, oy, oz, ux, uy, uz, table.radius, start, standing, own, closed, passed)
    return t, -2.0 * (ox * ux + oy * uy + oz * uz) - t


@lane_pass(layout.SPHERE)
def meet_sphere(lane, table):
    """Intersect rays with an acting sphere; keep it if it is the nearest surface ahead."""
    t, _ = next_on_sphere(lane, table, True)
    keep_acting(lane, table, t, t < lane.distance, False)


@lane_pass(layout.SPHERE)
def cover_sphere(lane, table):
    """Intersect rays with a transparent detector on a sphere; keep it if its sheet is the nearest ahead.

    On the sheet of the nearest hit, adds its bit to the hit.
    """
    t, other = next_on_sphere(lane, table, False)
    cover_curved(lane, table, t, other)


@device
def is_not_finite(lane, table):
    """Return whether a particle's state is not finite."""
    return (lane.weight != 0.0) & (not is_finite(lane))


@lane_pass(layout.NO_TABLE, when=is_not_finite)
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
