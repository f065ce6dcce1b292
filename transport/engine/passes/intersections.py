"""Ray tracing to the next crossing: find the nearest sheet ahead, move there, or leave the scene.

An acting surface accepts a ray that rounding carried past its edge, so that no ray slips between two walls
with a common edge; layout.ROUNDING and the slack of compile/compiler.py bound that rounding. A detector uses
its exact bounds.
"""

import math

from transport.compile import layout
from transport.compile.layout import EDGE, ROUNDING
from transport.engine.registry import lane_pass
from transport.engine.tally import add_lost, add_to_ledger, limbs
from transport.engine.words import passed_sheet, sheet_of, standing_sheet, surface_of
from transport.physics.device import device
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
def keep_nearest(covers, same, t, code, distance, hit):
    """Return distance and hit after a transparent detector at t.

    A nearer one replaces them; on the sheet of the nearest hit (`same`) its bit is added.
    """
    nearer = covers & ((t < distance) | same)
    return t if nearer & (not same) else distance, (hit | code if same else code) if nearer else hit


@lane_pass(layout.NO_TABLE)
def reset_hit(b, table, first, live):
    """Reset the nearest hit: infinite distance, no sheet.

    Fields: writes `distance`, `hit`.
    """
    for k in range(first, live):
        b.distance[k] = math.inf
        b.hit[k] = 0
    return live


@lane_pass(layout.RECTANGLE)
def meet_rectangle(b, table, first, live):
    """Intersect rays with an acting rectangle; keep it if it is the nearest surface ahead.

    Sets bit EDGE of the hit within rounding of the rectangle's edge.

    Fields: reads `x, y, z`, `ux, uy, uz`, `sheet`, `start`; updates `distance`, `hit`.
    """
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    half_u, half_v, inner_u, inner_v = table.half_u, table.half_v, table.inner_u, table.inner_v
    code, sheet = table.code, table.sheet
    for k in range(first, live):
        ux, uy, uz = b.ux[k], b.uy[k], b.uz[k]
        t, px, py, pz = plane_crossing(cx - b.x[k], cy - b.y[k], cz - b.z[k], ux, uy, uz, nx, ny, nz)
        u, v, slack = abs(px * eux + py * euy + pz * euz), abs(px * evx + py * evy + pz * evz), ROUNDING * t
        nearer = (u - slack <= half_u) & (v - slack <= half_v) & (t < b.distance[k])
        nearer &= (t > b.start[k]) & (standing_sheet(b.sheet[k]) != sheet)
        edge = (u > inner_u) | (v > inner_v)
        b.distance[k] = t if nearer else b.distance[k]
        b.hit[k] = (code | EDGE if edge else code) if nearer else b.hit[k]
    return live


@lane_pass(layout.RECTANGLE)
def cover_rectangle(b, table, first, live):
    """Intersect rays with a rectangular transparent detector; keep it if its sheet is the nearest ahead.

    On the sheet of the nearest hit, adds its bit to the hit.

    Fields: reads `x, y, z`, `ux, uy, uz`, `sheet`, `start`; updates `distance`, `hit`.
    """
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    sx, sy, sz, tie, outward = table.sx, table.sy, table.sz, table.tie, table.outward
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    half_u, half_v, code, sheet = table.half_u, table.half_v, table.code, table.sheet
    for k in range(first, live):
        ux, uy, uz = b.ux[k], b.uy[k], b.uz[k]
        rx, ry, rz = cx - b.x[k], cy - b.y[k], cz - b.z[k]
        t, _, _, _ = plane_crossing(sx - b.x[k], sy - b.y[k], sz - b.z[k], ux, uy, uz, nx, ny, nz)
        px, py, pz = t * ux - rx, t * uy - ry, t * uz - rz
        u, v = abs(px * eux + py * euy + pz * euz), abs(px * evx + py * evy + pz * evz)
        leaves = outward * (ux * nx + uy * ny + uz * nz) > 0.0
        same = sheet_of(b.hit[k]) == sheet
        covers = (u <= half_u) & (v <= half_v) & is_ahead(t, b.start[k], sheet, b.sheet[k])
        covers &= not is_box_face_passed(t, b.start[k], tie, leaves, b.sheet[k])
        b.distance[k], b.hit[k] = keep_nearest(covers, same, t, code, b.distance[k], b.hit[k])
    return live


@lane_pass(layout.RECTANGLE)
def bound_rectangle(b, table, first, live):
    """Intersect rays with a rectangular boundary of a medium; keep it if its sheet is the nearest ahead.

    Like an acting surface, it accepts rays that rounding carried past its edge.

    Fields: reads `x, y, z`, `ux, uy, uz`, `sheet`, `start`; updates `distance`, `hit`.
    """
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    sx, sy, sz = table.sx, table.sy, table.sz
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    half_u, half_v, inner_u, inner_v = table.half_u, table.half_v, table.inner_u, table.inner_v
    code, sheet = table.code, table.sheet
    for k in range(first, live):
        ux, uy, uz = b.ux[k], b.uy[k], b.uz[k]
        rx, ry, rz = cx - b.x[k], cy - b.y[k], cz - b.z[k]
        t, _, _, _ = plane_crossing(sx - b.x[k], sy - b.y[k], sz - b.z[k], ux, uy, uz, nx, ny, nz)
        px, py, pz, slack = t * ux - rx, t * uy - ry, t * uz - rz, ROUNDING * t
        u, v = abs(px * eux + py * euy + pz * euz), abs(px * evx + py * evy + pz * evz)
        found = code | EDGE if (u > inner_u) | (v > inner_v) else code
        same = sheet_of(b.hit[k]) == sheet
        covers = (u - slack <= half_u) & (v - slack <= half_v) & is_ahead(t, b.start[k], sheet, b.sheet[k])
        b.distance[k], b.hit[k] = keep_nearest(covers, same, t, found, b.distance[k], b.hit[k])
    return live


@lane_pass(layout.DISK)
def meet_disk(b, table, first, live):
    """Intersect rays with an acting disk or annulus; keep it if it is the nearest surface ahead.

    Fields: reads `x, y, z`, `ux, uy, uz`, `sheet`, `start`; updates `distance`, `hit`.
    """
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    inner2, outer2, breadth, code, sheet = table.inner2, table.outer2, table.breadth, table.code, table.sheet
    least2, most2 = table.least2, table.most2
    for k in range(first, live):
        ux, uy, uz = b.ux[k], b.uy[k], b.uz[k]
        t, px, py, pz = plane_crossing(cx - b.x[k], cy - b.y[k], cz - b.z[k], ux, uy, uz, nx, ny, nz)
        r2, slack = px * px + py * py + pz * pz, ROUNDING * breadth * t
        nearer = (r2 - slack <= outer2) & (r2 + slack >= inner2) & (t < b.distance[k])
        nearer &= (t > b.start[k]) & (standing_sheet(b.sheet[k]) != sheet)
        edge = (r2 > most2) | (r2 < least2)
        b.distance[k] = t if nearer else b.distance[k]
        b.hit[k] = (code | EDGE if edge else code) if nearer else b.hit[k]
    return live


@lane_pass(layout.DISK)
def cover_disk(b, table, first, live):
    """Intersect rays with a transparent detector on a disk; keep it if its sheet is the nearest ahead.

    On the sheet of the nearest hit, adds its bit to the hit.

    Fields: reads `x, y, z`, `ux, uy, uz`, `sheet`, `start`; updates `distance`, `hit`.
    """
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    sx, sy, sz = table.sx, table.sy, table.sz
    inner2, outer2, code, sheet = table.inner2, table.outer2, table.code, table.sheet
    for k in range(first, live):
        ux, uy, uz = b.ux[k], b.uy[k], b.uz[k]
        rx, ry, rz = cx - b.x[k], cy - b.y[k], cz - b.z[k]
        t, _, _, _ = plane_crossing(sx - b.x[k], sy - b.y[k], sz - b.z[k], ux, uy, uz, nx, ny, nz)
        px, py, pz = t * ux - rx, t * uy - ry, t * uz - rz
        r2 = px * px + py * py + pz * pz
        same = sheet_of(b.hit[k]) == sheet
        covers = (r2 <= outer2) & (r2 >= inner2) & is_ahead(t, b.start[k], sheet, b.sheet[k])
        b.distance[k], b.hit[k] = keep_nearest(covers, same, t, code, b.distance[k], b.hit[k])
    return live


@lane_pass(layout.SPHERE)
def meet_sphere(b, table, first, live):
    """Intersect rays with an acting sphere; keep it if it is the nearest surface ahead.

    Fields: reads `x, y, z`, `ux, uy, uz`, `sheet`, `start`; updates `distance`, `hit`.
    """
    cx, cy, cz, radius, code, sheet = table.cx, table.cy, table.cz, table.radius, table.code, table.sheet
    for k in range(first, live):
        ox, oy, oz = b.x[k] - cx, b.y[k] - cy, b.z[k] - cz
        standing, start = standing_sheet(b.sheet[k]) == sheet, b.start[k]
        own = start if start < 0.0 else 0.0  # ray parameter of the origin
        t = sphere_crossing(ox, oy, oz, b.ux[k], b.uy[k], b.uz[k], radius, start, standing, own, False, False)
        nearer = t < b.distance[k]
        b.distance[k] = t if nearer else b.distance[k]
        b.hit[k] = code if nearer else b.hit[k]
    return live


@lane_pass(layout.SPHERE)
def cover_sphere(b, table, first, live):
    """Intersect rays with a transparent detector on a sphere; keep it if its sheet is the nearest ahead.

    On the sheet of the nearest hit, adds its bit to the hit.

    Fields: reads `x, y, z`, `ux, uy, uz`, `sheet`, `start`; updates `distance`, `hit`.
    """
    cx, cy, cz, radius, code, sheet = table.cx, table.cy, table.cz, table.radius, table.code, table.sheet
    for k in range(first, live):
        ox, oy, oz = b.x[k] - cx, b.y[k] - cy, b.z[k] - cz
        start, last = b.start[k], passed_sheet(b.sheet[k])
        standing = standing_sheet(b.sheet[k]) == sheet
        own = start if start < 0.0 else 0.0
        # Of detectors that meet in a line, the next number is next.
        closed = (last != 0) & (sheet > last)
        t = sphere_crossing(
            ox, oy, oz, b.ux[k], b.uy[k], b.uz[k], radius, start, standing, own, closed, last == sheet
        )
        other = -2.0 * (ox * b.ux[k] + oy * b.uy[k] + oz * b.uz[k]) - t
        # the hit is the other crossing, found by a zone of the same sphere
        is_other = abs(t - b.distance[k]) > abs(other - b.distance[k])
        same = (sheet_of(b.hit[k]) == sheet) & (not is_other)
        b.distance[k], b.hit[k] = keep_nearest(t < math.inf, same, t, code, b.distance[k], b.hit[k])
    return live


@lane_pass(layout.NO_TABLE)
def end_escaped(b, table, first, live):
    """End lanes without a surface ahead as escaped, and lanes with a non-finite state as lost.

    Both weights go into the ledger. Counts the crossings of the other lanes.

    Fields: reads `x, y, z`, `ux, uy, uz`, `distance`; updates `weight`, `crossings`.
    """
    # Sum up escaped weight and count crossings.
    high, low, hits, any_lost = 0, 0, 0, 0
    for k in range(first, live):
        w = b.weight[k]
        is_sane = abs(b.x[k] + b.y[k] + b.z[k] + b.ux[k] + b.uy[k] + b.uz[k] + w) < math.inf
        gone = b.distance[k] == math.inf
        w_high, w_low = limbs(w if gone & is_sane else 0.0)
        high += w_high
        low += w_low
        hits += 0 if gone | (w == 0.0) else 1
        any_lost |= 0 if is_sane | (w == 0.0) else 1
        b.weight[k] = 0.0 if gone & is_sane else w
    add_to_ledger(b, layout.ESCAPED, high, low)
    b.crossings += hits
    # Rarely: end lanes whose state is not finite, as lost.
    if any_lost != 0:
        for k in range(first, live):
            w = b.weight[k]
            is_sane = abs(b.x[k] + b.y[k] + b.z[k] + b.ux[k] + b.uy[k] + b.uz[k] + w) < math.inf
            if w != 0.0 and not is_sane:
                add_lost(b, w)
                b.weight[k] = 0.0
    return live


@lane_pass(layout.NO_TABLE)
def move(b, table, first, live):
    """Move each lane along its ray to the hit.

    Fields: reads `ux, uy, uz`, `distance`, `hit`; updates `x, y, z`; writes `start`.
    """
    for k in range(first, live):
        d = b.distance[k] if b.hit[k] != 0 else 0.0  # idle lanes stay in place
        b.x[k] += d * b.ux[k]
        b.y[k] += d * b.uy[k]
        b.z[k] += d * b.uz[k]
        b.start[k] = 0.0
    return live


@lane_pass(layout.NO_TABLE)
def save_ray(b, table, first, live):
    """Keep the origin of the ray, in scenes with detectors that other surfaces may touch.

    Fields: reads `x, y, z`, `sheet`, `start`; writes `rx, ry, rz`, `ray_sheet`.
    """
    for k in range(first, live):
        b.rx[k], b.ry[k], b.rz[k] = b.x[k], b.y[k], b.z[k]
        # The x of an aimed ray is its target: such a ray began on no sheet.
        b.ray_sheet[k] = standing_sheet(b.sheet[k]) if b.start[k] >= 0.0 else 0
    return live


@lane_pass(layout.NO_TABLE)
def restore_ray(b, table, first, live):
    """Restore the origin of the ray after a transparent detector; `start` becomes the crossing's distance.

    All crossings of a ray are thus computed from one origin: a wall that touches a detector lies behind or
    before it, never at a distance of 0 that rounding takes for passed.

    Fields: reads `distance`, `hit`, `rx, ry, rz`, `ray_sheet`; updates `x, y, z`, `sheet`, `start`.
    """
    for k in range(first, live):
        passes = (b.hit[k] != 0) & (surface_of(b.hit[k]) == 0)
        b.x[k], b.y[k], b.z[k] = select(passes, b.rx[k], b.ry[k], b.rz[k], b.x[k], b.y[k], b.z[k])
        b.start[k] = b.distance[k] if passes else b.start[k]
        b.sheet[k] = ((b.sheet[k] << layout.PASSED_SHIFT) | b.ray_sheet[k]) if passes else b.sheet[k]
    return live
