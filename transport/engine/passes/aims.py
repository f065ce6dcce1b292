"""Emission aimed at a target only, with the exact weight (physics/emission.py).

x becomes the point on the target and `start` the ray parameter of the birthplace behind it: so the crossing
of the target is known to the target's own precision, however far away the particle was born.
"""

import math

import numpy as np

from transport.compile import layout
from transport.engine.bodies import lane_pass
from transport.engine.bundle import view
from transport.engine.tally import add_to_ledger, limbs
from transport.engine.words import birth_block, words_of_block
from transport.physics.bits import bits_of
from transport.physics.device import choose, device
from transport.physics.directions import select, turned_by, unit_and_length
from transport.physics.elementary import TWO_PI, cos_sin_turn
from transport.physics.emission import aimed_weight, cone_about
from transport.physics.positions import sample_disk, sample_rectangle, sample_triangle
from transport.physics.rays import box_crossings, plane_crossing
from transport.physics.streams import AIM, random_words, short_uniform, uniform


@lane_pass(layout.TARGET, before=birth_block(AIM))
def sample_target_rectangle(lane, table):
    """Sample a point uniformly on a rectangle, and find whether the ray as it is hits the rectangle."""
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    half_u, half_v = table.half_u, table.half_v
    w0, w1, w2, w3 = words_of_block(lane)
    u, v = sample_rectangle(half_u, half_v, uniform(w0, w1), uniform(w2, w3))
    lane.ox, lane.oy, lane.oz = u * eux + v * evx, u * euy + v * evy, u * euz + v * evz
    rx, ry, rz = cx - lane.x, cy - lane.y, cz - lane.z
    t, qx, qy, qz = plane_crossing(rx, ry, rz, lane.ux, lane.uy, lane.uz, nx, ny, nz)
    u, v = abs(qx * eux + qy * euy + qz * euz), abs(qx * evx + qy * evy + qz * evz)
    lane.distance = t if (u <= half_u) & (v <= half_v) else 0.0


@lane_pass(layout.TARGET, before=birth_block(AIM))
def sample_target_disk(lane, table):
    """Sample a point uniformly on a disk or annulus, and find whether the ray as it is hits it."""
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    inner2, outer2 = table.inner2, table.outer2
    w0, w1, w2, w3 = words_of_block(lane)
    u, v = sample_disk(inner2, outer2, uniform(w0, w1), uniform(w2, w3))
    lane.ox, lane.oy, lane.oz = u * eux + v * evx, u * euy + v * evy, u * euz + v * evz
    rx, ry, rz = cx - lane.x, cy - lane.y, cz - lane.z
    t, qx, qy, qz = plane_crossing(rx, ry, rz, lane.ux, lane.uy, lane.uz, nx, ny, nz)
    q2 = qx * qx + qy * qy + qz * qz
    lane.distance = t if (q2 <= outer2) & (q2 >= inner2) else 0.0


@lane_pass(layout.TARGET, before=birth_block(AIM))
def sample_target_triangle(lane, table):
    """Sample a point uniformly on a triangle, and find whether the ray as it is hits it.

    The edges e_u, e_v start at the corner c.
    """
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    ax, ay, az, bx, by, bz = table.ax, table.ay, table.az, table.bx, table.by, table.bz
    w0, w1, w2, w3 = words_of_block(lane)
    u, v = sample_triangle(uniform(w0, w1), uniform(w2, w3))
    lane.ox, lane.oy, lane.oz = u * eux + v * evx, u * euy + v * evy, u * euz + v * evz
    rx, ry, rz = cx - lane.x, cy - lane.y, cz - lane.z
    t, qx, qy, qz = plane_crossing(rx, ry, rz, lane.ux, lane.uy, lane.uz, nx, ny, nz)
    u, v = qx * ax + qy * ay + qz * az, qx * bx + qy * by + qz * bz
    lane.distance = t if (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) else 0.0


@lane_pass(layout.TARGET)
def aim_at_sampled_point(lane, table):
    """Aim at the point sampled on a flat target.

    A share `natural` of particles keeps its direction (mixture pdf).
    """
    cx, cy, cz, nx, ny, nz = table.cx, table.cy, table.cz, table.nx, table.ny, table.nz
    area, isotropic, lambertian = table.area, table.isotropic, table.lambertian
    natural, scale = table.natural, table.unit
    seed_low, seed_high, batch = lane.seed_low, lane.seed_high, lane.batch
    d0, d1, _, _ = random_words(lane.history, batch, 1, AIM, seed_low, seed_high)
    px, py, pz = lane.ox, lane.oy, lane.oz
    vx, vy, vz = cx - lane.x + px, cy - lane.y + py, cz - lane.z + pz
    distance = math.sqrt(vx * vx + vy * vy + vz * vz)
    inverse = 1.0 / distance if distance > 0.0 else 0.0
    # Keep the direction with probability `natural`, else aim.
    keeps = uniform(d0, d1) < natural
    reach = lane.distance if keeps else distance
    ux = lane.ux if keeps else vx * inverse
    uy = lane.uy if keeps else vy * inverse
    uz = lane.uz if keeps else vz * inverse
    # Weight: pdf of the emitter over the mixture's.
    cosine = ux * lane.nx + uy * lane.ny + uz * lane.nz
    f = isotropic + lambertian * (cosine if cosine > 0.0 else 0.0)
    w = aimed_weight(f, area, abs(ux * nx + uy * ny + uz * nz), reach * reach, natural)
    lane.ux, lane.uy, lane.uz = ux, uy, uz
    lane.x, lane.y, lane.z = select(keeps, lane.x, lane.y, lane.z, cx + px, cy + py, cz + pz)
    lane.start = 0.0 if keeps else -distance
    lane.weight *= w * scale if (not keeps) | (reach > 0.0) else 0.0


@lane_pass(layout.TARGET, before=birth_block(AIM))
def aim_at_sphere(lane, table):
    """Sample a direction uniform in the solid angle of a sphere, or uniform over all directions inside it."""
    cx, cy, cz, radius, scale = table.cx, table.cy, table.cz, table.half_u, table.unit
    isotropic, lambertian = table.isotropic, table.lambertian
    w0, w1, w2, w3 = words_of_block(lane)
    rx, ry, rz = cx - lane.x, cy - lane.y, cz - lane.z
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
    mu = ux * lane.nx + uy * lane.ny + uz * lane.nz
    f = isotropic + lambertian * (mu if mu > 0.0 else 0.0)
    # The ray's closest point to the centre; for births inside, it may lie behind them.
    depth = d * sine
    ahead = (cosine > 0.0) & (d2 > radius * radius)
    lane.x = choose(ahead, cx + depth * (cosine * ex - sine * axis_x), lane.x)
    lane.y = choose(ahead, cy + depth * (cosine * ey - sine * axis_y), lane.y)
    lane.z = choose(ahead, cz + depth * (cosine * ez - sine * axis_z), lane.z)
    lane.start = -d * cosine if ahead else 0.0
    lane.ux, lane.uy, lane.uz = ux, uy, uz
    lane.weight *= f * TWO_PI * cone * scale


@lane_pass(layout.TARGET)
def aim_at_box(lane, table):
    """Aim at a point uniform on a box's faces; the pdf counts both faces that the ray crosses."""
    cx, cy, cz, hx, hy, hz = table.cx, table.cy, table.cz, table.half_u, table.half_v, table.half_w
    area, isotropic, lambertian = table.area, table.isotropic, table.lambertian
    natural, scale = table.natural, table.unit
    share_x, share_y = 8.0 * hy * hz / area, 8.0 * hx * hz / area
    seed_low, seed_high, batch = lane.seed_low, lane.seed_high, lane.batch
    w0, w1, w2, w3 = random_words(lane.history, batch, 0, AIM, seed_low, seed_high)
    d0, d1, d2, d3 = random_words(lane.history, batch, 1, AIM, seed_low, seed_high)
    # Sample a face by area, and a point on it.
    u, v, face = 2.0 * uniform(w0, w1) - 1.0, 2.0 * uniform(w2, w3) - 1.0, uniform(d0, d1)
    end = 1.0 if d2 & 1 else -1.0
    on_x, on_y = face < share_x, (face >= share_x) & (face < share_x + share_y)
    px = hx * (end if on_x else u)
    py = hy * (end if on_y else (u if on_x else v))
    pz = hz * (v if on_x | on_y else end)
    ox, oy, oz = lane.x - cx, lane.y - cy, lane.z - cz
    vx, vy, vz, distance = unit_and_length(px - ox, py - oy, pz - oz)
    keeps = short_uniform(d3) < natural
    ux = lane.ux if keeps else vx
    uy = lane.uy if keeps else vy
    uz = lane.uz if keeps else vz
    # Weight: pdf of the emitter over the mixture's.
    near, near_cosine, far, far_cosine = box_crossings(ox, oy, oz, ux, uy, uz, hx, hy, hz)
    # A face seen edge-on is sampled but never hit: such directions have measure zero.
    slope = abs(ux) if on_x else (abs(uy) if on_y else abs(uz))
    meets = ((near <= far) & (far > 0.0)) if keeps else slope > 0.0
    cosine = ux * lane.nx + uy * lane.ny + uz * lane.nz
    f = isotropic + lambertian * (cosine if cosine > 0.0 else 0.0)
    density = (far * far / far_cosine + (near * near / near_cosine if near > 0.0 else 0.0)) / area
    w = f / (natural * f + (1.0 - natural) * density)
    lane.ux, lane.uy, lane.uz = ux, uy, uz
    lane.x, lane.y, lane.z = select(keeps, lane.x, lane.y, lane.z, cx + px, cy + py, cz + pz)
    lane.start = 0.0 if keeps else -distance
    lane.weight *= w * scale if meets & (f > 0.0) & (w > 0.0) else 0.0


@device
def add_births(lane, table, high, low, count):
    """Add births to the ledger."""
    add_to_ledger(lane, layout.BORN, high, low)
    view(lane.ledger, lane.ledger_words, np.int64)[4 * layout.BORN + 2] += count


@lane_pass(layout.NO_TABLE, sums=add_births)
def account_births(lane, table):
    """Add the births towards a target to the ledger.

    The rest of the power is `unsampled`.
    """
    high, low = limbs(lane.weight)
    return high, low, 1


@device
def is_heaviest(lane, table):
    """Return whether a birth is heavier than all before; as bits, whose order is that of the weights."""
    return bits_of(lane.weight) > view(lane.ledger, lane.ledger_words, np.int64)[4 * layout.BORN + 3]


@lane_pass(layout.NO_TABLE, when=is_heaviest)
def note_heaviest_birth(lane, table):
    """Keep the largest birth weight towards a target in the ledger."""
    ledger = view(lane.ledger, lane.ledger_words, np.int64)
    ledger[4 * layout.BORN + 3] = max(ledger[4 * layout.BORN + 3], bits_of(lane.weight))
