"""Clamp a point within rounding of its surface's edge to the inner side of that rounding.

Where two walls share an edge, the point is then surely on the inner side of the other wall, and whether it
hits that wall next depends on its direction, not on the sign of a rounding error.
"""

import math

from transport.compile.layout import (
    DISK_RIM,
    EDGE,
    QUADRIC_RIM,
    RECTANGLE_RIM,
    RIM,
    ROWS,
    SURFACE_MASK,
    SURFACE_SHIFT,
    TRIANGLE_RIM,
)
from transport.engine.addresses import view
from transport.engine.passes import lane_pass
from transport.physics.device import device
from transport.physics.quadrics import quadric_form


@device
def out_of_hole(rim, u, v):
    """Return a point (u, v) of the plane, moved out of the hole's margin."""
    du, dv = u - rim.hole_u, v - rim.hole_v
    p, q = rim.hole_cos * du + rim.hole_sin * dv, rim.hole_cos * dv - rim.hole_sin * du
    if rim.half_q == 0.0:
        r, least = math.sqrt(p * p + q * q), rim.half_p + rim.margin
        if r < least:
            p, q = (p * (least / r), q * (least / r)) if r > 0.0 else (least, 0.0)
    else:
        deep_p, deep_q = rim.half_p + rim.margin - abs(p), rim.half_q + rim.margin - abs(q)
        if (deep_p > 0.0) & (deep_q > 0.0):
            p += math.copysign(deep_p, p) if deep_p <= deep_q else 0.0
            q += math.copysign(deep_q, q) if deep_q < deep_p else 0.0
    du, dv = rim.hole_cos * p - rim.hole_sin * q, rim.hole_sin * p + rim.hole_cos * q
    return rim.hole_u + du, rim.hole_v + dv


@device
def within_rectangle(rim, u, v):
    """Return a point (u, v) of the plane, clamped to a rectangle and out of its hole."""
    u = min(max(u, -rim.inner_u), rim.inner_u)
    v = min(max(v, -rim.inner_v), rim.inner_v)
    return out_of_hole(rim, u, v) if rim.half_p > 0.0 else (u, v)


@device
def within_disk(rim, u, v):
    """Return a point (u, v) of the plane, clamped between a disk's radii inner_v and inner_u."""
    r = math.sqrt(u * u + v * v)
    s = min(max(r, rim.inner_v), rim.inner_u) / r if r > 0.0 else 1.0
    return s * u, s * v


@device
def within_triangle(rim, u, v):
    """Return the barycentric weights of the second and third vertex, clamped away from all three edges."""
    p, q = max(u, rim.least_a), max(v, rim.least_b)
    excess = 0.5 * max(p + q - (1.0 - rim.least_c), 0.0)
    return p - excess, q - excess


@lane_pass(ROWS)
def draw_back_from_edge(b, table, first, live):
    """Clamp the lanes that landed within rounding of an edge (bit EDGE) to the inner side of it.

    Does nothing if no lane did, the usual case.

    Fields: reads `ux, uy, uz`, `hit`; updates `x, y, z`, `nx, ny, nz`; writes `mu`.
    """
    any_edge = 0
    for k in range(first, live):
        any_edge |= b.hit[k] & EDGE
    if any_edge == 0:
        return live
    rims = view(table.rows, table.count, RIM)  # one row per surface
    for k in range(first, live):
        if b.hit[k] & EDGE:
            rim = rims[(b.hit[k] >> SURFACE_SHIFT) & SURFACE_MASK]
            px, py, pz = b.x[k] - rim.cx, b.y[k] - rim.cy, b.z[k] - rim.cz
            if rim.form == QUADRIC_RIM:
                # Surface of revolution: clamp the height, then project onto the surface and renew its normal.
                w = px * rim.nx + py * rim.ny + pz * rim.nz
                qx, qy, qz = px - w * rim.nx, py - w * rim.ny, pz - w * rim.nz
                w = min(max(w, rim.low), rim.high)
                rho2, q2 = rim.alpha + w * (rim.beta + rim.gamma * w), qx * qx + qy * qy + qz * qz
                if q2 == 0.0:  # on the axis, at the apex of a cone
                    qx, qy, qz, q2 = rim.eux, rim.euy, rim.euz, 1.0
                s = math.sqrt(rho2 / q2) if rho2 > 0.0 else 0.0
                px, py, pz = w * rim.nx + s * qx, w * rim.ny + s * qy, w * rim.nz + s * qz
                b.x[k], b.y[k], b.z[k] = rim.cx + px, rim.cy + py, rim.cz + pz
                _, gx, gy, gz, _ = quadric_form(
                    px, py, pz, rim.nx, rim.ny, rim.nz, rim.alpha, rim.beta, rim.gamma
                )
                inverse = 1.0 / math.sqrt(gx * gx + gy * gy + gz * gz)
                b.nx[k], b.ny[k], b.nz[k] = gx * inverse, gy * inverse, gz * inverse
                b.mu[k] = b.ux[k] * b.nx[k] + b.uy[k] * b.ny[k] + b.uz[k] * b.nz[k]
            else:
                # Flat shapes: clamp (u, v); for a triangle, the weights of two vertices, with edges e_u, e_v.
                is_triangle = rim.form == TRIANGLE_RIM
                u = px * rim.eux + py * rim.euy + pz * rim.euz
                v = px * rim.evx + py * rim.evy + pz * rim.evz
                if is_triangle:
                    u = px * rim.ax + py * rim.ay + pz * rim.az
                    v = px * rim.bx + py * rim.by + pz * rim.bz
                new_u, new_v = u, v
                if rim.form == RECTANGLE_RIM:
                    new_u, new_v = within_rectangle(rim, u, v)
                elif rim.form == DISK_RIM:
                    new_u, new_v = within_disk(rim, u, v)
                elif is_triangle:
                    new_u, new_v = within_triangle(rim, u, v)
                du, dv = new_u - u, new_v - v
                b.x[k] += du * rim.eux + dv * rim.evx
                b.y[k] += du * rim.euy + dv * rim.evy
                b.z[k] += du * rim.euz + dv * rim.evz
    return live
