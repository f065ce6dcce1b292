"""Births: position and direction; their time and speed are in velocities.py.

Loops run over the new lanes [first, live) only.
"""

import math

from numba import int64

from transport.compile import layout
from transport.engine.passes.flats import distance_from_hole
from transport.engine.registry import lane_pass
from transport.physics.bits import float_of
from transport.physics.directions import from_frame, sample_cosine_law, sample_isotropic
from transport.physics.elementary import cos_sin_turn
from transport.physics.positions import sample_disk, sample_rectangle, sample_triangle
from transport.physics.streams import DEPTH, DIRECTION, POSITION, random_words, uniform
from transport.physics.velocities import sample_normal_pair


@lane_pass(layout.BIRTH)
def start_history(b, table, first, live):
    """Start a new history: number, birth weight, ray parameter and sheet.

    The birth weight is that of the table times the factor dealt to the emitter (driver._deal_histories).

    Fields: writes `weight`, `history`, `sheet`, `start`.
    """
    weight, start, sheet = table.weight * float_of(b.birth_factor), table.start, table.sheet
    history = int64(b.next_history) - int64(first)
    for k in range(first, live):
        b.history[k] = history + int64(k)
        b.weight[k], b.sheet[k], b.start[k] = weight, sheet, start
    return live


@lane_pass(layout.NO_TABLE)
def reset_events(b, table, first, live):
    """Set the event counter, which numbers the random blocks, to 0.

    Fields: writes `event`.
    """
    for k in range(first, live):
        b.event[k] = 0
    return live


@lane_pass(layout.MEDIUM)
def set_birth_index(b, table, first, live):
    """Set the refractive index to that of the source's medium.

    Fields: writes `index`.
    """
    index = table.index
    for k in range(first, live):
        b.index[k] = index
    return live


@lane_pass(layout.NO_TABLE)
def reset_visits(b, table, first, live):
    """Clear the bit set of visited objects.

    Fields: writes `visited`.
    """
    for k in range(first, live):
        b.visited[k] = 0
    return live


@lane_pass(layout.NO_TABLE)
def reset_reflections(b, table, first, live):
    """Set the count of reflections to 0.

    Fields: writes `reflections`.
    """
    for k in range(first, live):
        b.reflections[k] = 0
    return live


@lane_pass(layout.NO_TABLE)
def save_birth_weight(b, table, first, live):
    """Keep the birth weight as the reference of Russian roulette.

    Fields: reads `weight`; writes `birth`.
    """
    for k in range(first, live):
        b.birth[k] = b.weight[k]
    return live


@lane_pass(layout.PATCH)
def born_on_rectangle(b, table, first, live):
    """Sample a point uniformly on a rectangle.

    Fields: reads `history`; writes `x, y, z`.
    """
    cx, cy, cz, eux, euy, euz = table.cx, table.cy, table.cz, table.eux, table.euy, table.euz
    evx, evy, evz, half_u, half_v = table.evx, table.evy, table.evz, table.half_u, table.half_v
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, POSITION, seed_low, seed_high)
        u, v = sample_rectangle(half_u, half_v, uniform(w0, w1), uniform(w2, w3))
        b.x[k], b.y[k], b.z[k] = cx + u * eux + v * evx, cy + u * euy + v * evy, cz + u * euz + v * evz
    return live


@lane_pass(layout.PATCH)
def born_on_disk(b, table, first, live):
    """Sample a point uniformly on a disk or annulus.

    Fields: reads `history`; writes `x, y, z`.
    """
    cx, cy, cz, eux, euy, euz = table.cx, table.cy, table.cz, table.eux, table.euy, table.euz
    evx, evy, evz, inner2, outer2 = table.evx, table.evy, table.evz, table.inner2, table.outer2
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, POSITION, seed_low, seed_high)
        u, v = sample_disk(inner2, outer2, uniform(w0, w1), uniform(w2, w3))
        b.x[k], b.y[k], b.z[k] = cx + u * eux + v * evx, cy + u * euy + v * evy, cz + u * euz + v * evz
    return live


@lane_pass(layout.PATCH)
def born_on_triangle(b, table, first, live):
    """Sample a point uniformly on a triangle with corner c and edges e_u, e_v.

    Fields: reads `history`; writes `x, y, z`.
    """
    cx, cy, cz, eux, euy, euz = table.cx, table.cy, table.cz, table.eux, table.euy, table.euz
    evx, evy, evz = table.evx, table.evy, table.evz
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, POSITION, seed_low, seed_high)
        u, v = sample_triangle(uniform(w0, w1), uniform(w2, w3))
        b.x[k], b.y[k], b.z[k] = cx + u * eux + v * evx, cy + u * euy + v * evy, cz + u * euz + v * evz
    return live


@lane_pass(layout.HOLED)
def born_beside_hole(b, table, first, live):
    """Sample a point uniformly on a rectangle with a hole, by rejection of points in the hole.

    Fields: reads `history`; writes `x, y, z`.
    """
    hole_u, hole_v, hole_cos, hole_sin = table.hole_u, table.hole_v, table.hole_cos, table.hole_sin
    half_p, half_q = table.half_p, table.half_q
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        u, v, draws, beyond = 0.0, 0.0, 0, -1.0
        # Reject points in the hole.
        while beyond < 0.0:
            w0, w1, w2, w3 = random_words(b.history[k], batch, draws, POSITION, seed_low, seed_high)
            u, v = sample_rectangle(table.half_u, table.half_v, uniform(w0, w1), uniform(w2, w3))
            beyond = distance_from_hole(u, v, hole_u, hole_v, hole_cos, hole_sin, half_p, half_q)
            draws += 1
        b.x[k] = table.cx + u * table.eux + v * table.evx
        b.y[k] = table.cy + u * table.euy + v * table.evy
        b.z[k] = table.cz + u * table.euz + v * table.evz
    return live


@lane_pass(layout.PATCH)
def born_on_sphere(b, table, first, live):
    """Sample a point uniformly on a sphere, with its normal on the emitting side.

    Fields: reads `history`; writes `x, y, z`, `nx, ny, nz`.
    """
    cx, cy, cz, radius, side = table.cx, table.cy, table.cz, table.half_u, table.side
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, POSITION, seed_low, seed_high)
        nx, ny, nz = sample_isotropic(uniform(w0, w1), uniform(w2, w3))
        b.x[k], b.y[k], b.z[k] = cx + radius * nx, cy + radius * ny, cz + radius * nz
        b.nx[k], b.ny[k], b.nz[k] = side * nx, side * ny, side * nz
    return live


@lane_pass(layout.PATCH)
def born_on_sphere_cross_section(b, table, first, live):
    """Sample a point on a sphere, uniformly over its cross section, for a parallel beam.

    The beam goes along (nx, ny, nz) of the table.

    Fields: reads `history`; writes `x, y, z`.
    """
    cx, cy, cz, radius, side = table.cx, table.cy, table.cz, table.half_u, table.side
    ux, uy, uz = table.nx, table.ny, table.nz
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, POSITION, seed_low, seed_high)
        nx, ny, nz, _ = sample_cosine_law(ux, uy, uz, uniform(w0, w1), uniform(w2, w3))
        r = side * radius
        b.x[k], b.y[k], b.z[k] = cx + r * nx, cy + r * ny, cz + r * nz
    return live


@lane_pass(layout.PATCH)
def set_emission_normal(b, table, first, live):
    """Set the normal of the emitting side, by which an aim weights directions; 0 for isotropic emission.

    Fields: writes `nx, ny, nz`.
    """
    nx, ny, nz = table.side * table.nx, table.side * table.ny, table.side * table.nz
    for k in range(first, live):
        b.nx[k], b.ny[k], b.nz[k] = nx, ny, nz
    return live


@lane_pass(layout.PATCH)
def born_at_point(b, table, first, live):
    """Set the position to one point.

    Fields: writes `x, y, z`.
    """
    cx, cy, cz = table.cx, table.cy, table.cz
    for k in range(first, live):
        b.x[k], b.y[k], b.z[k] = cx, cy, cz
    return live


@lane_pass(layout.PATCH)
def born_in_box(b, table, first, live):
    """Sample a point uniformly in a box.

    Fields: reads `history`; writes `x, y, z`.
    """
    cx, cy, cz = table.cx, table.cy, table.cz
    half_u, half_v, half_w = table.half_u, table.half_v, table.half_w
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, POSITION, seed_low, seed_high)
        d0, d1, _, _ = random_words(b.history[k], batch, 0, DEPTH, seed_low, seed_high)
        b.x[k] = cx + (2.0 * uniform(w0, w1) - 1.0) * half_u
        b.y[k] = cy + (2.0 * uniform(w2, w3) - 1.0) * half_v
        b.z[k] = cz + (2.0 * uniform(d0, d1) - 1.0) * half_w
    return live


@lane_pass(layout.PATCH)
def born_in_sphere(b, table, first, live):
    """Sample a point uniformly in a ball.

    The radius is the largest of three uniforms, which has the law of the cube root of one.

    Fields: reads `history`; writes `x, y, z`.
    """
    cx, cy, cz, radius = table.cx, table.cy, table.cz, table.half_u
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, POSITION, seed_low, seed_high)
        d0, d1, d2, d3 = random_words(b.history[k], batch, 0, DEPTH, seed_low, seed_high)
        e0, e1, _, _ = random_words(b.history[k], batch, 1, DEPTH, seed_low, seed_high)
        ux, uy, uz = sample_isotropic(uniform(w0, w1), uniform(w2, w3))
        r = radius * max(max(uniform(d0, d1), uniform(d2, d3)), uniform(e0, e1))
        b.x[k], b.y[k], b.z[k] = cx + r * ux, cy + r * uy, cz + r * uz
    return live


@lane_pass(layout.PATCH)
def born_in_cloud(b, table, first, live):
    """Sample a point of a normal distribution with a standard deviation per coordinate.

    Fields: reads `history`; writes `x, y, z`.
    """
    cx, cy, cz = table.cx, table.cy, table.cz
    half_u, half_v, half_w = table.half_u, table.half_v, table.half_w
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, POSITION, seed_low, seed_high)
        d0, d1, d2, d3 = random_words(b.history[k], batch, 0, DEPTH, seed_low, seed_high)
        p, q = sample_normal_pair(uniform(w0, w1), uniform(w2, w3))
        r, _ = sample_normal_pair(uniform(d0, d1), uniform(d2, d3))
        b.x[k], b.y[k], b.z[k] = cx + half_u * p, cy + half_v * q, cz + half_w * r
    return live


@lane_pass(layout.NO_TABLE)
def emit_lambertian(b, table, first, live):
    """Sample a direction by the cosine law about the normal of the emitting side.

    Fields: reads `history`, `nx, ny, nz`; writes `ux, uy, uz`.
    """
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, DIRECTION, seed_low, seed_high)
        ux, uy, uz, _ = sample_cosine_law(b.nx[k], b.ny[k], b.nz[k], uniform(w0, w1), uniform(w2, w3))
        b.ux[k], b.uy[k], b.uz[k] = ux, uy, uz
    return live


@lane_pass(layout.PATCH)
def emit_lambertian_from_plane(b, table, first, live):
    """Sample a direction by the cosine law about one normal for all lanes, in a frame computed once.

    Fields: reads `history`; writes `ux, uy, uz`.
    """
    side = table.side
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    nx, ny, nz = side * table.nx, side * table.ny, side * table.nz
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, DIRECTION, seed_low, seed_high)
        u = uniform(w0, w1)
        c, s = cos_sin_turn(uniform(w2, w3))
        mu, sine = math.sqrt(1.0 - u), math.sqrt(u)
        c, s = c * sine, s * sine
        b.ux[k], b.uy[k], b.uz[k] = from_frame(c, s, mu, eux, euy, euz, evx, evy, evz, nx, ny, nz)
    return live


@lane_pass(layout.NO_TABLE)
def emit_isotropic(b, table, first, live):
    """Sample a direction uniformly over the sphere.

    Fields: reads `history`; writes `ux, uy, uz`.
    """
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, DIRECTION, seed_low, seed_high)
        b.ux[k], b.uy[k], b.uz[k] = sample_isotropic(uniform(w0, w1), uniform(w2, w3))
    return live


@lane_pass(layout.BEAM)
def emit_beam(b, table, first, live):
    """Set one direction for all.

    Fields: writes `ux, uy, uz`.
    """
    ux, uy, uz = table.ux, table.uy, table.uz
    for k in range(first, live):
        b.ux[k], b.uy[k], b.uz[k] = ux, uy, uz
    return live


# ---- Score births on a sheet with detectors: a newborn particle counts there as a departure.
#
# Only for emitters whose sheet carries a detector. The x of an aimed particle is its target, so it moves to
# its birthplace for these steps.


@lane_pass(layout.BIRTH)
def hit_birth_sheet(b, table, first, live):
    """Set the hit to the sheet of birth, without detectors yet.

    Fields: writes `hit`.
    """
    code = table.sheet << layout.SHEET_SHIFT
    for k in range(first, live):
        b.hit[k] = code
    return live


@lane_pass(layout.NO_TABLE)
def move_to_birthplace(b, table, first, live):
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


@lane_pass(layout.NO_TABLE)
def move_to_target(b, table, first, live):
    """Restore the target as the position, to its full precision.

    Fields: reads `u0`, `u1`, `u2`; writes `x, y, z`.
    """
    for k in range(first, live):
        b.x[k], b.y[k], b.z[k] = b.u0[k], b.u1[k], b.u2[k]
    return live


@lane_pass(layout.RECTANGLE)
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


@lane_pass(layout.DISK)
def born_over_disk(b, table, first, live):
    """Add the detectors of this disk to the hit of births within it.

    Fields: reads `x, y, z`; updates `hit`.
    """
    for k in range(first, live):
        px, py, pz = b.x[k] - table.cx, b.y[k] - table.cy, b.z[k] - table.cz
        r2 = px * px + py * py + pz * pz
        b.hit[k] |= table.code if (r2 <= table.outer2) & (r2 >= table.inner2) else 0
    return live


@lane_pass(layout.TRIANGLE)
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


@lane_pass(layout.HOLED)
def born_over_holed(b, table, first, live):
    """Add the detectors of this rectangle with a hole to the hit of births within it.

    Fields: reads `x, y, z`; updates `hit`.
    """
    for k in range(first, live):
        px, py, pz = b.x[k] - table.cx, b.y[k] - table.cy, b.z[k] - table.cz
        u = px * table.eux + py * table.euy + pz * table.euz
        v = px * table.evx + py * table.evy + pz * table.evz
        beyond = distance_from_hole(
            u, v, table.hole_u, table.hole_v, table.hole_cos, table.hole_sin, table.half_p, table.half_q
        )
        covers = (abs(u) <= table.half_u) & (abs(v) <= table.half_v) & (beyond >= 0.0)
        b.hit[k] |= table.code if covers else 0
    return live


@lane_pass(layout.QUADRIC)
def born_over_quadric(b, table, first, live):
    """Add the detectors of this surface of revolution to the hit of births between its heights.

    Fields: reads `x, y, z`; updates `hit`.
    """
    for k in range(first, live):
        w = (b.x[k] - table.cx) * table.ax + (b.y[k] - table.cy) * table.ay + (b.z[k] - table.cz) * table.az
        b.hit[k] |= table.code if (w >= table.low) & (w <= table.high) else 0
    return live


@lane_pass(layout.HIT_WORD)
def born_all_over(b, table, first, live):
    """Add the detectors of the emitter's own shape to the hit of all births, despite rounding at its rim.

    Fields: updates `hit`.
    """
    code = table.code
    for k in range(first, live):
        b.hit[k] |= code
    return live
