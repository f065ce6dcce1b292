"""Emission aimed at a target only, with the exact weight (physics/emission.py).

x becomes the point on the target and `start` the ray parameter of the birthplace behind it: so the crossing
of the target is known to the target's own precision, however far away the particle was born.
"""

import math

import numpy as np
from numba import int64

from transport.compile import layout
from transport.engine.bundle import view
from transport.engine.registry import lane_pass
from transport.engine.tally import limbs
from transport.physics.bits import bits_of
from transport.physics.directions import select, turned_by, unit_and_length
from transport.physics.elementary import TWO_PI, cos_sin_turn
from transport.physics.emission import aimed_weight, cone_about
from transport.physics.positions import sample_disk, sample_rectangle, sample_triangle
from transport.physics.rays import box_crossings, plane_crossing
from transport.physics.streams import AIM, random_words, short_uniform, uniform


@lane_pass(layout.TARGET)
def sample_target_rectangle(b, table, first, live):
    """Sample a point uniformly on a rectangle, and find whether the ray as it is hits the rectangle.

    Fields: reads `x, y, z`, `ux, uy, uz`, `history`; writes `distance`, `ox, oy, oz`.
    """
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    half_u, half_v = table.half_u, table.half_v
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, AIM, seed_low, seed_high)
        u, v = sample_rectangle(half_u, half_v, uniform(w0, w1), uniform(w2, w3))
        b.ox[k], b.oy[k], b.oz[k] = u * eux + v * evx, u * euy + v * evy, u * euz + v * evz
        rx, ry, rz = cx - b.x[k], cy - b.y[k], cz - b.z[k]
        t, qx, qy, qz = plane_crossing(rx, ry, rz, b.ux[k], b.uy[k], b.uz[k], nx, ny, nz)
        u, v = abs(qx * eux + qy * euy + qz * euz), abs(qx * evx + qy * evy + qz * evz)
        b.distance[k] = t if (u <= half_u) & (v <= half_v) else 0.0
    return live


@lane_pass(layout.TARGET)
def sample_target_disk(b, table, first, live):
    """Sample a point uniformly on a disk or annulus, and find whether the ray as it is hits it.

    Fields: reads `x, y, z`, `ux, uy, uz`, `history`; writes `distance`, `ox, oy, oz`.
    """
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    inner2, outer2 = table.inner2, table.outer2
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, AIM, seed_low, seed_high)
        u, v = sample_disk(inner2, outer2, uniform(w0, w1), uniform(w2, w3))
        b.ox[k], b.oy[k], b.oz[k] = u * eux + v * evx, u * euy + v * evy, u * euz + v * evz
        rx, ry, rz = cx - b.x[k], cy - b.y[k], cz - b.z[k]
        t, qx, qy, qz = plane_crossing(rx, ry, rz, b.ux[k], b.uy[k], b.uz[k], nx, ny, nz)
        q2 = qx * qx + qy * qy + qz * qz
        b.distance[k] = t if (q2 <= outer2) & (q2 >= inner2) else 0.0
    return live


@lane_pass(layout.TARGET)
def sample_target_triangle(b, table, first, live):
    """Sample a point uniformly on a triangle, and find whether the ray as it is hits it.

    The edges e_u, e_v start at the corner c.

    Fields: reads `x, y, z`, `ux, uy, uz`, `history`; writes `distance`, `ox, oy, oz`.
    """
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    ax, ay, az, bx, by, bz = table.ax, table.ay, table.az, table.bx, table.by, table.bz
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, AIM, seed_low, seed_high)
        u, v = sample_triangle(uniform(w0, w1), uniform(w2, w3))
        b.ox[k], b.oy[k], b.oz[k] = u * eux + v * evx, u * euy + v * evy, u * euz + v * evz
        rx, ry, rz = cx - b.x[k], cy - b.y[k], cz - b.z[k]
        t, qx, qy, qz = plane_crossing(rx, ry, rz, b.ux[k], b.uy[k], b.uz[k], nx, ny, nz)
        u, v = qx * ax + qy * ay + qz * az, qx * bx + qy * by + qz * bz
        b.distance[k] = t if (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) else 0.0
    return live


@lane_pass(layout.TARGET)
def aim_at_sampled_point(b, table, first, live):
    """Aim at the point sampled on a flat target.

    A share `natural` of particles keeps its direction (mixture pdf).

    Fields: reads `history`, `distance`, `nx, ny, nz`, `ox, oy, oz`; updates `x, y, z`, `ux, uy, uz`,
    `weight`; writes `start`.
    """
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    area, isotropic, lambertian = table.area, table.isotropic, table.lambertian
    natural, scale = table.natural, table.unit
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        d0, d1, _, _ = random_words(b.history[k], batch, 1, AIM, seed_low, seed_high)
        px, py, pz = b.ox[k], b.oy[k], b.oz[k]
        vx, vy, vz = cx - b.x[k] + px, cy - b.y[k] + py, cz - b.z[k] + pz
        distance = math.sqrt(vx * vx + vy * vy + vz * vz)
        inverse = 1.0 / distance if distance > 0.0 else 0.0
        # Keep the direction with probability `natural`, else aim.
        keeps = uniform(d0, d1) < natural
        reach = b.distance[k] if keeps else distance
        ux = b.ux[k] if keeps else vx * inverse
        uy = b.uy[k] if keeps else vy * inverse
        uz = b.uz[k] if keeps else vz * inverse
        # Weight: pdf of the emitter over the mixture's.
        cosine = ux * b.nx[k] + uy * b.ny[k] + uz * b.nz[k]
        f = isotropic + lambertian * (cosine if cosine > 0.0 else 0.0)
        w = aimed_weight(f, area, abs(ux * nx + uy * ny + uz * nz), reach * reach, natural)
        b.ux[k], b.uy[k], b.uz[k] = ux, uy, uz
        b.x[k], b.y[k], b.z[k] = select(keeps, b.x[k], b.y[k], b.z[k], cx + px, cy + py, cz + pz)
        b.start[k] = 0.0 if keeps else -distance
        b.weight[k] *= w * scale if (not keeps) | (reach > 0.0) else 0.0
    return live


@lane_pass(layout.TARGET)
def aim_at_sphere(b, table, first, live):
    """Sample a direction uniform in the solid angle of a sphere, or uniform over all directions inside it.

    Fields: reads `history`, `nx, ny, nz`; updates `x, y, z`, `weight`; writes `ux, uy, uz`, `start`.
    """
    cx, cy, cz, radius, scale = table.cx, table.cy, table.cz, table.half_u, table.unit
    isotropic, lambertian = table.isotropic, table.lambertian
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, AIM, seed_low, seed_high)
        rx, ry, rz = cx - b.x[k], cy - b.y[k], cz - b.z[k]
        d2 = rx * rx + ry * ry + rz * rz
        d = math.sqrt(d2)
        inverse = 1.0 / d if d2 > 0.0 else 0.0
        axis_x, axis_y, axis_z = rx * inverse, ry * inverse, rz * inverse if d2 > 0.0 else 1.0
        cone = cone_about(d2, radius)
        gap = cone * uniform(w0, w1)  # 1 - cos of the angle from the axis
        cosine, sine = 1.0 - gap, math.sqrt(gap * (2.0 - gap))
        c, s = cos_sin_turn(uniform(w2, w3))
        ex, ey, ez = turned_by(axis_x, axis_y, axis_z, 0.0, c, s)
        ux, uy, uz = cosine * axis_x + sine * ex, cosine * axis_y + sine * ey, cosine * axis_z + sine * ez
        # Weight: pdf of the emitter over that of the aim.
        mu = ux * b.nx[k] + uy * b.ny[k] + uz * b.nz[k]
        f = isotropic + lambertian * (mu if mu > 0.0 else 0.0)
        # The ray's closest point to the centre; for births inside, it may lie behind them.
        depth = d * sine
        ahead = (cosine > 0.0) & (d2 > radius * radius)
        b.x[k] = cx + depth * (cosine * ex - sine * axis_x) if ahead else b.x[k]
        b.y[k] = cy + depth * (cosine * ey - sine * axis_y) if ahead else b.y[k]
        b.z[k] = cz + depth * (cosine * ez - sine * axis_z) if ahead else b.z[k]
        b.start[k] = -d * cosine if ahead else 0.0
        b.ux[k], b.uy[k], b.uz[k] = ux, uy, uz
        b.weight[k] *= f * TWO_PI * cone * scale
    return live


@lane_pass(layout.TARGET)
def aim_at_box(b, table, first, live):
    """Aim at a point uniform on a box's faces; the pdf counts both faces that the ray crosses.

    Fields: reads `history`, `nx, ny, nz`; updates `x, y, z`, `ux, uy, uz`, `weight`; writes `start`.
    """
    cx, cy, cz, hx, hy, hz = table.cx, table.cy, table.cz, table.half_u, table.half_v, table.half_w
    area, isotropic, lambertian = table.area, table.isotropic, table.lambertian
    natural, scale = table.natural, table.unit
    share_x, share_y = 8.0 * hy * hz / area, 8.0 * hx * hz / area
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, AIM, seed_low, seed_high)
        d0, d1, d2, d3 = random_words(b.history[k], batch, 1, AIM, seed_low, seed_high)
        # Sample a face by area, and a point on it.
        u, v, face = 2.0 * uniform(w0, w1) - 1.0, 2.0 * uniform(w2, w3) - 1.0, uniform(d0, d1)
        end = 1.0 if d2 & 1 else -1.0
        on_x, on_y = face < share_x, (face >= share_x) & (face < share_x + share_y)
        px = hx * (end if on_x else u)
        py = hy * (end if on_y else (u if on_x else v))
        pz = hz * (v if on_x | on_y else end)
        ox, oy, oz = b.x[k] - cx, b.y[k] - cy, b.z[k] - cz
        vx, vy, vz, distance = unit_and_length(px - ox, py - oy, pz - oz)
        keeps = short_uniform(d3) < natural
        ux = b.ux[k] if keeps else vx
        uy = b.uy[k] if keeps else vy
        uz = b.uz[k] if keeps else vz
        # Weight: pdf of the emitter over the mixture's.
        near, near_cosine, far, far_cosine = box_crossings(ox, oy, oz, ux, uy, uz, hx, hy, hz)
        # A face seen edge-on is sampled but never hit: such directions have measure zero.
        slope = abs(ux) if on_x else (abs(uy) if on_y else abs(uz))
        meets = ((near <= far) & (far > 0.0)) if keeps else slope > 0.0
        cosine = ux * b.nx[k] + uy * b.ny[k] + uz * b.nz[k]
        f = isotropic + lambertian * (cosine if cosine > 0.0 else 0.0)
        density = (far * far / far_cosine + (near * near / near_cosine if near > 0.0 else 0.0)) / area
        w = f / (natural * f + (1.0 - natural) * density)
        b.ux[k], b.uy[k], b.uz[k] = ux, uy, uz
        b.x[k], b.y[k], b.z[k] = select(keeps, b.x[k], b.y[k], b.z[k], cx + px, cy + py, cz + pz)
        b.start[k] = 0.0 if keeps else -distance
        b.weight[k] *= w * scale if meets & (f > 0.0) & (w > 0.0) else 0.0
    return live


@lane_pass(layout.NO_TABLE)
def account_births(b, table, first, live):
    """Add the births towards a target to the ledger, with the largest weight.

    The rest of the power is `unsampled`.

    Fields: reads `weight`.
    """
    ledger, total_high, total_low = view(b.ledger, b.ledger_words, np.int64), 0, 0
    heaviest = ledger[4 * layout.BORN + 3]  # as bits, whose order is that of the weights
    for k in range(first, live):
        high, low = limbs(b.weight[k])
        total_high += high
        total_low += low
        heaviest = max(heaviest, bits_of(b.weight[k]))
    ledger[4 * layout.BORN] += total_high
    ledger[4 * layout.BORN + 1] += total_low
    ledger[4 * layout.BORN + 2] += int64(live) - int64(first)
    ledger[4 * layout.BORN + 3] = heaviest
    return live
