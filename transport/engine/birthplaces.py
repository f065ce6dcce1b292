"""Score births on a sheet with detectors: a newborn particle counts there as a departure.

Only for emitters whose sheet carries a detector. The x of an aimed particle is its target, so it moves to its
birthplace for these steps.
"""

from transport.compile.layout import (
    BIRTH,
    CODE,
    DISK,
    HOLED,
    NO_TABLE,
    QUADRIC,
    RECTANGLE,
    SHEET_SHIFT,
    TRIANGLE,
)
from transport.engine.flats import beyond_hole
from transport.engine.passes import lane_pass


@lane_pass(BIRTH)
def stand_at_birth(b, table, first, live):
    """Set the hit to the sheet of birth, without detectors yet.

    Fields: writes `hit`.
    """
    code = table.sheet << SHEET_SHIFT
    for k in range(first, live):
        b.hit[k] = code
    return live


@lane_pass(NO_TABLE)
def visit_birthplace(b, table, first, live):
    """Move an aimed particle from its target back along the ray to its birthplace.

    The target is kept in u0 to u2.

    Fields: reads `ux, uy, uz`, `start`; updates `x, y, z`; writes `u0`, `u1`, `u2`.
    """
    for k in range(first, live):
        b.u0[k], b.u1[k], b.u2[k] = b.x[k], b.y[k], b.z[k]
        b.x[k] += b.start[k] * b.ux[k]
        b.y[k] += b.start[k] * b.uy[k]
        b.z[k] += b.start[k] * b.uz[k]
    return live


@lane_pass(NO_TABLE)
def return_to_target(b, table, first, live):
    """Restore the target as the position, to its full precision.

    Fields: reads `u0`, `u1`, `u2`; writes `x, y, z`.
    """
    for k in range(first, live):
        b.x[k], b.y[k], b.z[k] = b.u0[k], b.u1[k], b.u2[k]
    return live


@lane_pass(RECTANGLE)
def born_over_rectangle(b, table, first, live):
    """Add the detectors of this rectangle to the hit of births within it.

    Fields: reads `x, y, z`; updates `hit`.
    """
    for k in range(first, live):
        px, py, pz = b.x[k] - table.cx, b.y[k] - table.cy, b.z[k] - table.cz
        u = abs(px * table.eux + py * table.euy + pz * table.euz)
        v = abs(px * table.evx + py * table.evy + pz * table.evz)
        b.hit[k] |= table.code if (u <= table.half_u) & (v <= table.half_v) else 0
    return live


@lane_pass(DISK)
def born_over_disk(b, table, first, live):
    """Add the detectors of this disk to the hit of births within it.

    Fields: reads `x, y, z`; updates `hit`.
    """
    for k in range(first, live):
        px, py, pz = b.x[k] - table.cx, b.y[k] - table.cy, b.z[k] - table.cz
        r2 = px * px + py * py + pz * pz
        b.hit[k] |= table.code if (r2 <= table.outer2) & (r2 >= table.inner2) else 0
    return live


@lane_pass(TRIANGLE)
def born_over_triangle(b, table, first, live):
    """Add the detectors of this triangle to the hit of births within it.

    Fields: reads `x, y, z`; updates `hit`.
    """
    for k in range(first, live):
        px, py, pz = b.x[k] - table.cx, b.y[k] - table.cy, b.z[k] - table.cz
        u = px * table.ax + py * table.ay + pz * table.az
        v = px * table.bx + py * table.by + pz * table.bz
        b.hit[k] |= table.code if (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) else 0
    return live


@lane_pass(HOLED)
def born_over_holed(b, table, first, live):
    """Add the detectors of this rectangle with a hole to the hit of births within it.

    Fields: reads `x, y, z`; updates `hit`.
    """
    for k in range(first, live):
        px, py, pz = b.x[k] - table.cx, b.y[k] - table.cy, b.z[k] - table.cz
        u = px * table.eux + py * table.euy + pz * table.euz
        v = px * table.evx + py * table.evy + pz * table.evz
        beyond = beyond_hole(
            u, v, table.hole_u, table.hole_v, table.hole_cos, table.hole_sin, table.half_p, table.half_q
        )
        covers = (abs(u) <= table.half_u) & (abs(v) <= table.half_v) & (beyond >= 0.0)
        b.hit[k] |= table.code if covers else 0
    return live


@lane_pass(QUADRIC)
def born_over_quadric(b, table, first, live):
    """Add the detectors of this surface of revolution to the hit of births between its heights.

    Fields: reads `x, y, z`; updates `hit`.
    """
    for k in range(first, live):
        w = (b.x[k] - table.cx) * table.ax + (b.y[k] - table.cy) * table.ay + (b.z[k] - table.cz) * table.az
        b.hit[k] |= table.code if (w >= table.low) & (w <= table.high) else 0
    return live


@lane_pass(CODE)
def born_all_over(b, table, first, live):
    """Add the detectors of the emitter's own shape to the hit of all births, despite rounding at its rim.

    Fields: updates `hit`.
    """
    code = table.code
    for k in range(first, live):
        b.hit[k] |= code
    return live
