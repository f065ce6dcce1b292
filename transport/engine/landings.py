"""Arrived at a surface: its sheet and normal, the point put back onto it, the cosine of incidence."""

import math

from transport.engine.addresses import view
from transport.engine.passes import lane_pass
from transport.layout import EDGE, NO_TABLE, RECTANGLE, ROWS, SHEET, SHEET_SHIFT, SURFACE_MASK, SURFACE_SHIFT


@lane_pass(ROWS)
def stand_on_sheet(b, table, first, live):
    """Remember the sheet and take its normal.  The gather is a pass of its own: it would hold up a longer loop."""
    sheets = view(table.rows, table.count, SHEET)
    for k in range(first, live):
        s = b.hit[k] >> SHEET_SHIFT
        b.sheet[k] = s
        b.nx[k], b.ny[k], b.nz[k] = sheets[s].nx, sheets[s].ny, sheets[s].nz
    return live


@lane_pass(ROWS)
def put_back_on_sphere(b, table, first, live):
    """On a curved sheet the normal follows from the point, and the point is put back to the radius."""
    sheets = view(table.rows, table.count, SHEET)
    for k in range(first, live):
        row = sheets[b.sheet[k]]
        curved = row.curvature != 0.0
        ox, oy, oz = b.x[k] - row.cx, b.y[k] - row.cy, b.z[k] - row.cz
        o = math.sqrt(ox * ox + oy * oy + oz * oz)
        s = 1.0 / o if curved else 0.0
        b.nx[k], b.ny[k], b.nz[k] = b.nx[k] + s * ox, b.ny[k] + s * oy, b.nz[k] + s * oz
        d = s * row.radius
        b.x[k] = row.cx + d * ox if curved else b.x[k]
        b.y[k] = row.cy + d * oy if curved else b.y[k]
        b.z[k] = row.cz + d * oz if curved else b.z[k]
    return live


@lane_pass(NO_TABLE)
def take_cosine(b, table, first, live):
    """mu = u·n: negative where the particle comes towards the side that the normal points to."""
    for k in range(first, live):
        b.mu[k] = b.ux[k] * b.nx[k] + b.uy[k] * b.ny[k] + b.uz[k] * b.nz[k]
    return live


@lane_pass(ROWS)
def draw_back_from_edge(b, table, first, live):
    """A point within rounding of its wall's edge goes to the inner side of that rounding.

    Where two walls meet, it is then surely on the inner side of the other wall's plane, which it meets next or not
    by its direction, never by the sign of a rounding error.
    """
    any_edge = 0
    for k in range(first, live):
        any_edge |= b.hit[k] & EDGE
    if any_edge == 0:
        return live
    walls = view(table.rows, table.count, RECTANGLE)  # by surface
    for k in range(first, live):
        if b.hit[k] & EDGE:
            w = walls[(b.hit[k] >> SURFACE_SHIFT) & SURFACE_MASK]
            px, py, pz = b.x[k] - w.cx, b.y[k] - w.cy, b.z[k] - w.cz
            u = px * w.eux + py * w.euy + pz * w.euz
            v = px * w.evx + py * w.evy + pz * w.evz
            du = min(max(u, -w.inner_u), w.inner_u) - u
            dv = min(max(v, -w.inner_v), w.inner_v) - v
            b.x[k] += du * w.eux + dv * w.evx
            b.y[k] += du * w.euy + dv * w.evy
            b.z[k] += du * w.euz + dv * w.evz
    return live
