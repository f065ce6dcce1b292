"""Landing on a surface: its sheet and normal, the point projected onto it, the cosine of incidence."""

import math

from numba import uint64

from transport.compile import layout
from transport.compile.layout import EDGE
from transport.engine.bodies import lane_pass
from transport.engine.bundle import view
from transport.engine.words import standing_sheet
from transport.physics.device import device
from transport.physics.quadrics import quadric_form

GRAZING_COSINE = 2.0**-12  # cosine below which a ray grazes a surface
MIN_RETREAT = 2.0**-22  # [scene lengths] back from where two surfaces touch: there they are 2^-45 apart
# largest share of a flight: its origin may stand on a surface, within rounding of either side
MAX_RETREAT_SHARE = 31.0 / 32.0
CONTACT_ZONE = 64.0  # in units of `reach`: distance from a surface within which a point is kept clear of it


@lane_pass(layout.ROWS)
def set_sheet(lane, table):
    """Set the sheet and its normal.

    The gather is a pass of its own because it would slow down a longer loop.
    """
    sheets = view(lane.arena + table.rows, table.count, layout.SHEET)
    s = lane.hit_sheet
    lane.sheet = s
    row = sheets[uint64(s)]
    lane.nx, lane.ny, lane.nz = row.nx, row.ny, row.nz


@lane_pass(layout.ROWS)
def project_onto_sphere(lane, table):
    """On a sphere: set the normal from the point, and project the point to the radius."""
    sheets = view(lane.arena + table.rows, table.count, layout.SHEET)
    row = sheets[lane.sheet]
    curved = row.curvature != 0.0
    ox, oy, oz = lane.x - row.cx, lane.y - row.cy, lane.z - row.cz
    o = math.sqrt(ox * ox + oy * oy + oz * oz)
    s = 1.0 / o if curved & (o > 0.0) else 0.0  # idle lanes may stand at the centre
    lane.nx, lane.ny, lane.nz = lane.nx + s * ox, lane.ny + s * oy, lane.nz + s * oz
    d = s * row.radius
    lane.x = row.cx + d * ox if curved else lane.x
    lane.y = row.cy + d * oy if curved else lane.y
    lane.z = row.cz + d * oz if curved else lane.z


@lane_pass(layout.NO_TABLE)
def set_cosine(lane, table):
    """Set mu = u·n: negative where the particle moves against the normal."""
    lane.mu = lane.ux * lane.nx + lane.uy * lane.ny + lane.uz * lane.nz


@lane_pass(layout.ROWS)
def mark_box_exit(lane, table):
    """Mark in `ray_sheet` that a ray leaves a box through this face, where boxes are detectors.

    At an edge a ray may enter by one face and leave by another.
    """
    sheets = view(lane.arena + table.rows, table.count, layout.SHEET)
    lane.ray_sheet |= layout.LEFT_BOX if sheets[lane.sheet].outward * lane.mu > 0.0 else 0


@lane_pass(layout.NO_TABLE)
def save_origin(lane, table):
    """Keep the origin of the flight and its sheet.

    They give the side of every surface that the flight did not cross.
    """
    start = lane.start if lane.start < 0.0 else 0.0  # the origin of a ray that has passed detectors
    lane.ox = lane.x + start * lane.ux
    lane.oy = lane.y + start * lane.uy
    lane.oz = lane.z + start * lane.uz
    lane.flight_sheet = standing_sheet(lane.sheet)


@device
def height_and_normal(px, py, pz, ax, ay, az, alpha, beta, gamma, is_plane):
    """Return the height of p over a plane or a surface of revolution, and the unit normal there.

    The plane passes through the origin; the surface of revolution is centred on it.
    """
    value, gx, gy, gz, w = quadric_form(px, py, pz, ax, ay, az, alpha, beta, gamma)
    g = math.sqrt(gx * gx + gy * gy + gz * gz)
    inverse = 1.0 / g if g > 0.0 else 0.0
    height = w if is_plane else 0.5 * value * inverse
    return (
        height,
        ax if is_plane else gx * inverse,
        ay if is_plane else gy * inverse,
        az if is_plane else gz * inverse,
    )


@lane_pass(layout.CONTACT)
def keep_to_side(lane, table):
    """Keep a point on one surface, close to another that cuts or touches it, on the side that it came from.

    The point moves back along its own ray, not quite to the ray's origin. So it stays on the right side of
    every surface that the flight did not cross, however many meet there and at whatever angle, and clear of
    both by more than rounding; a shorter flight within such a corner keeps little of its length. Only if the
    ray grazes the other surface, the point moves along that surface's normal.
    """
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    alpha, beta, gamma = table.alpha, table.beta, table.gamma
    reach, surface, sheet, is_plane = table.reach, table.surface, table.sheet, table.is_plane != 0
    ux, uy, uz = lane.ux, lane.uy, lane.uz
    rx, ry, rz = lane.x - cx, lane.y - cy, lane.z - cz
    ox, oy, oz = lane.ox - cx, lane.oy - cy, lane.oz - cz
    # Heights over the other surface at the point and at the origin, and the side of the origin.
    height, gx, gy, gz = height_and_normal(rx, ry, rz, nx, ny, nz, alpha, beta, gamma, is_plane)
    before, ex, ey, ez = height_and_normal(ox, oy, oz, nx, ny, nz, alpha, beta, gamma, is_plane)
    away = ux * ex + uy * ey + uz * ez
    from_front = away > 0.0 if lane.flight_sheet == sheet else before > 0.0
    # Length to move back along the ray.
    slope = abs(ux * gx + uy * gy + uz * gz)
    dx, dy, dz = rx - ox, ry - oy, rz - oz
    flight = math.sqrt(dx * dx + dy * dy + dz * dz)
    steepest = min(slope, abs(lane.mu))
    back = 2.0 * reach / (steepest if steepest > GRAZING_COSINE else GRAZING_COSINE)
    back = MAX_RETREAT_SHARE * flight if back > MAX_RETREAT_SHARE * flight else back
    # Which lanes move, and how.
    near = (lane.surface == surface) & (abs(height) <= CONTACT_ZONE * reach)
    grazes = (slope <= GRAZING_COSINE) & (abs(height) <= reach)
    # Between two surfaces that touch, both grazed:
    narrow = MIN_RETREAT if flight > MIN_RETREAT else flight
    along = back if near & (slope > GRAZING_COSINE) else 0.0
    along = narrow if near & grazes & (abs(lane.mu) <= GRAZING_COSINE) else along
    across = (2.0 * reach if from_front else -2.0 * reach) - height
    across = across if near & grazes & (abs(lane.mu) > GRAZING_COSINE) else 0.0
    lane.x += across * gx - along * ux
    lane.y += across * gy - along * uy
    lane.z += across * gz - along * uz


# ---- Clamp a point within rounding of its surface's edge to the inner side of that rounding.
#
# Where two walls share an edge, the point is then surely on the inner side of the other wall, and whether it
# hits that wall next depends on its direction, not on the sign of a rounding error.


@device
def clamp_outside_hole(rim, u, v):
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
def clamp_to_rectangle(rim, u, v):
    """Return a point (u, v) of the plane, clamped to a rectangle and out of its hole."""
    u = min(max(u, -rim.inner_u), rim.inner_u)
    v = min(max(v, -rim.inner_v), rim.inner_v)
    return clamp_outside_hole(rim, u, v) if rim.half_p > 0.0 else (u, v)


@device
def clamp_to_disk(rim, u, v):
    """Return a point (u, v) of the plane, clamped between a disk's radii inner_v and inner_u."""
    r = math.sqrt(u * u + v * v)
    s = min(max(r, rim.inner_v), rim.inner_u) / r if r > 0.0 else 1.0
    return s * u, s * v


@device
def clamp_to_triangle(rim, u, v):
    """Return the barycentric weights of the second and third vertex, clamped away from all three edges."""
    p, q = max(u, rim.least_a), max(v, rim.least_b)
    excess = 0.5 * max(p + q - (1.0 - rim.least_c), 0.0)
    return p - excess, q - excess


@device
def is_at_edge(lane, table):
    """Return whether a lane landed within rounding of an edge."""
    return (lane.covered & EDGE) != 0


@lane_pass(layout.ROWS, when=is_at_edge)
def clamp_inside_edge(lane, table):
    """Clamp a lane that landed within rounding of an edge (bit EDGE) to the inner side of it."""
    rims = view(lane.arena + table.rows, table.count, layout.RIM)  # one row per surface
    rim = rims[lane.surface]
    px, py, pz = lane.x - rim.cx, lane.y - rim.cy, lane.z - rim.cz
    if rim.form == layout.QUADRIC_RIM:
        # Surface of revolution: clamp the height, then project onto the surface and renew its normal.
        w = px * rim.nx + py * rim.ny + pz * rim.nz
        qx, qy, qz = px - w * rim.nx, py - w * rim.ny, pz - w * rim.nz
        w = min(max(w, rim.low), rim.high)
        alpha, beta, gamma = rim.alpha, rim.beta, rim.gamma
        rho2, q2 = alpha + w * (beta + gamma * w), qx * qx + qy * qy + qz * qz
        if q2 == 0.0:  # on the axis, at the apex of a cone
            qx, qy, qz, q2 = rim.eux, rim.euy, rim.euz, 1.0
        s = math.sqrt(rho2 / q2) if rho2 > 0.0 else 0.0
        px, py, pz = w * rim.nx + s * qx, w * rim.ny + s * qy, w * rim.nz + s * qz
        lane.x, lane.y, lane.z = rim.cx + px, rim.cy + py, rim.cz + pz
        _, gx, gy, gz, _ = quadric_form(px, py, pz, rim.nx, rim.ny, rim.nz, alpha, beta, gamma)
        inverse = 1.0 / math.sqrt(gx * gx + gy * gy + gz * gz)
        lane.nx, lane.ny, lane.nz = gx * inverse, gy * inverse, gz * inverse
        lane.mu = lane.ux * lane.nx + lane.uy * lane.ny + lane.uz * lane.nz
    else:
        # Flat shapes: clamp (u, v); for a triangle, the weights of two vertices, with edges e_u, e_v.
        is_triangle = rim.form == layout.TRIANGLE_RIM
        u = px * rim.eux + py * rim.euy + pz * rim.euz
        v = px * rim.evx + py * rim.evy + pz * rim.evz
        if is_triangle:
            u = px * rim.ax + py * rim.ay + pz * rim.az
            v = px * rim.bx + py * rim.by + pz * rim.bz
        new_u, new_v = u, v
        if rim.form == layout.RECTANGLE_RIM:
            new_u, new_v = clamp_to_rectangle(rim, u, v)
        elif rim.form == layout.DISK_RIM:
            new_u, new_v = clamp_to_disk(rim, u, v)
        elif is_triangle:
            new_u, new_v = clamp_to_triangle(rim, u, v)
        du, dv = new_u - u, new_v - v
        lane.x += du * rim.eux + dv * rim.evx
        lane.y += du * rim.euy + dv * rim.evy
        lane.z += du * rim.euz + dv * rim.evz
