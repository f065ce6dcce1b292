"""Cylinders, cones, paraboloids and spherical zones: intersection, landing, births."""

import math

from transport.compile import layout
from transport.compile.layout import COLLISION_CLEARANCE, ROUNDING
from transport.engine.bodies import lane_pass
from transport.engine.bundle import view
from transport.engine.passes.intersections import cover_curved, keep_acting
from transport.engine.words import birth_block, passed_sheet, standing_sheet, words_of_block
from transport.physics.device import device
from transport.physics.elementary import cos_sin_turn
from transport.physics.quadrics import next_crossing, on_one_nappe, quadric_crossings, quadric_form
from transport.physics.streams import POSITION, uniform


@device
def next_on_quadric(lane, table, acts):
    """Return the distance to the next crossing of a surface of revolution, to its other one, and the height.

    acts: an acting surface meets tangent rays, and reaches over its edges by rounding. A detector is that
    nappe of a cone on which it lies; of detectors that meet in a line, the next number is next.
    """
    low, high, sheet = table.low, table.high, table.sheet
    ox, oy, oz = lane.x - table.cx, lane.y - table.cy, lane.z - table.cz
    start, last = lane.start, passed_sheet(lane.sheet)
    standing = standing_sheet(lane.sheet) == sheet
    own = start if start < 0.0 else 0.0  # ray parameter of the origin
    near, far, w, pace, steep = quadric_crossings(
        ox, oy, oz, lane.ux, lane.uy, lane.uz, table.ax, table.ay, table.az,
        table.alpha, table.beta, table.gamma, standing, own, acts,
    )  # fmt: skip
    at_near, at_far = w + near * pace, w + far * pace
    slack_near, slack_far = (ROUNDING * abs(near), ROUNDING * abs(far)) if acts else (0.0, 0.0)
    if not acts:
        is_below = table.beta + table.gamma * (low + high) < 0.0  # on the side of its apex
        one_near, one_far = on_one_nappe(at_near, at_far, ROUNDING * abs(w), pace, is_below, standing)
        at_near, at_far = one_near if steep else at_near, one_far if steep else at_far
    is_near_in = (at_near + slack_near >= low) & (at_near - slack_near <= high)
    is_far_in = (at_far + slack_far >= low) & (at_far - slack_far <= high)
    closed, passed = (not acts) & (last != 0) & (sheet > last), (not acts) & (last == sheet)
    t = next_crossing(near, far, is_near_in, is_far_in, start, closed, passed)
    return t, near + far - t, w + t * pace


@lane_pass(layout.QUADRIC)
def meet_quadric(lane, table):
    """Intersect rays with an acting surface of revolution; keep it if it is the nearest surface ahead."""
    t, _, height = next_on_quadric(lane, table, True)
    is_edge = (height < table.inner_low) | (height > table.inner_high)
    keep_acting(lane, table, t, t < lane.distance, is_edge)


@lane_pass(layout.QUADRIC)
def cover_quadric(lane, table):
    """Intersect rays with a transparent detector on a surface of revolution; keep it if nearest.

    On the sheet of the nearest hit, adds its bit to the hit.
    """
    t, other, _ = next_on_quadric(lane, table, False)
    cover_curved(lane, table, t, other)


@lane_pass(layout.ROWS)
def project_onto_quadric(lane, table):
    """Set the normal from the gradient and project the point onto the surface by one Newton step along it."""
    sheets = view(lane.arena + table.rows, table.count, layout.CURVED_SHEET)
    row = sheets[lane.sheet]
    if row.is_curved != 0:
        ax, ay, az = row.ax, row.ay, row.az
        px, py, pz = lane.x - row.cx, lane.y - row.cy, lane.z - row.cz
        value, gx, gy, gz, w = quadric_form(px, py, pz, ax, ay, az, row.alpha, row.beta, row.gamma)
        g2 = gx * gx + gy * gy + gz * gz
        step = 0.5 * value / g2 if g2 > 0.0 else 0.0
        lane.x, lane.y, lane.z = lane.x - step * gx, lane.y - step * gy, lane.z - step * gz
        # Within rounding of its apex, a ray steeper than the cone passes through the apex: take the axis.
        pace, narrows = lane.ux * ax + lane.uy * ay + lane.uz * az, row.narrows
        p2 = px * px + py * py + pz * pz
        is_near = (p2 < COLLISION_CLEARANCE * COLLISION_CLEARANCE) | (w * narrows > 0.0)
        at_apex = (narrows != 0.0) & is_near & ((1.0 + row.gamma) * pace * pace > 1.0)
        has_normal = (g2 > 0.0) & (not at_apex)
        inverse, top = 1.0 / math.sqrt(g2) if has_normal else 0.0, narrows if narrows != 0.0 else 1.0
        lane.nx = gx * inverse if has_normal else top * ax
        lane.ny = gy * inverse if has_normal else top * ay
        lane.nz = gz * inverse if has_normal else top * az


@lane_pass(layout.BAND, before=birth_block(POSITION))
def born_on_band(lane, table):
    """Sample a point uniformly on a cylinder, cone or zone, whose area per height is linear in the height.

    The height is the root of the linear cumulative law in a form without cancellation; for equal ends that is
    the share u of the height.
    """
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    alpha, beta, gamma, low, high = table.alpha, table.beta, table.gamma, table.low, table.high
    one, other, side = table.first, table.last, table.side
    w0, w1, w2, w3 = words_of_block(lane)
    # Invert the cumulative area for the height w; then sample the azimuth.
    u = uniform(w0, w1)
    here = math.sqrt(one * one + u * (other - one) * (other + one))
    w = low + (high - low) * (u * (one + other) / (one + here) if u > 0.0 else 0.0)
    c, s = cos_sin_turn(uniform(w2, w3))
    rho2 = alpha + w * (beta + gamma * w)
    rho = math.sqrt(rho2 if rho2 > 0.0 else 0.0)
    px, py, pz = c * eux + s * evx, c * euy + s * evy, c * euz + s * evz
    slope = 0.5 * beta + gamma * w
    gx, gy, gz = rho * px - slope * nx, rho * py - slope * ny, rho * pz - slope * nz
    g2 = gx * gx + gy * gy + gz * gz
    turn = side / math.sqrt(g2) if g2 > 0.0 else 0.0
    lane.x, lane.y, lane.z = cx + rho * px + w * nx, cy + rho * py + w * ny, cz + rho * pz + w * nz
    lane.nx, lane.ny, lane.nz = turn * gx, turn * gy, turn * gz


@lane_pass(layout.BAND, before=birth_block(POSITION))
def born_on_paraboloid(lane, table):
    """Sample a point uniformly on a paraboloid of focal length f: (1 + w/f)^(3/2) - 1 is uniform.

    first, last of the table: this quantity at both ends.
    """
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    beta, one, other, low, high, side = table.beta, table.first, table.last, table.low, table.high, table.side
    w0, w1, w2, w3 = words_of_block(lane)
    w = 0.25 * beta * math.expm1(math.log1p(one + uniform(w0, w1) * (other - one)) / 1.5)
    w = min(max(w, low), high)
    c, s = cos_sin_turn(uniform(w2, w3))
    rho = math.sqrt(beta * w)
    px, py, pz = c * eux + s * evx, c * euy + s * evy, c * euz + s * evz
    gx, gy, gz = rho * px - 0.5 * beta * nx, rho * py - 0.5 * beta * ny, rho * pz - 0.5 * beta * nz
    turn = side / math.sqrt(gx * gx + gy * gy + gz * gz)
    lane.x, lane.y, lane.z = cx + rho * px + w * nx, cy + rho * py + w * ny, cz + rho * pz + w * nz
    lane.nx, lane.ny, lane.nz = turn * gx, turn * gy, turn * gz
