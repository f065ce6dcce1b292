"""Next-event estimation for surface detectors: rays from emissions, diffuse reflections and collisions.

A ray goes from the event to a point sampled on the detector; its contribution is the pdf with which the event
emits in that direction over the pdf of sampling it (Kalos 1963; physics/connections.py). MIS weights of
flights are in mis.py, tracing of rays in stages/next_event.py.
"""

import math

import numpy as np
from numba import uint64

from transport.compile import layout
from transport.engine.bundle import view
from transport.engine.passes.shadow_rays import DETECTOR_SHIFT, INVERSE_PI, SCORE_BOUND, direction_to
from transport.engine.registry import lane_pass
from transport.engine.words import is_covered, material_of, standing_sheet, surface_of
from transport.physics.connections import ball_connection, flat_connection
from transport.physics.directions import turned_by
from transport.physics.elementary import cos_sin_turn
from transport.physics.emission import cone_about
from transport.physics.positions import sample_disk, sample_rectangle, sample_triangle
from transport.physics.streams import EXPECT, event_words, random_words, uniform

# ---- Points on detectors ----


@lane_pass(layout.NO_TABLE)
def draw_joint_point_at_birth(b, table, first, live):
    """Draw the uniforms p0, p1 for a point on the first detector.

    Quasi-random points pair these with the birthplace.

    Fields: reads `history`; writes `p0`, `p1`.
    """
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, EXPECT, seed_low, seed_high)
        b.p0[k], b.p1[k] = uniform(w0, w1), uniform(w2, w3)
    return live


@lane_pass(layout.EXPECTATION)
def draw_point_at_birth(b, table, first, live):
    """Draw the uniforms p0, p1 for a point on a further detector.

    Fields: reads `history`; writes `p0`, `p1`.
    """
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    number = uint64(table.number) << DETECTOR_SHIFT
    for k in range(first, live):
        w0, w1, w2, w3 = event_words(b.history[k], batch, number, EXPECT, seed_low, seed_high)
        b.p0[k], b.p1[k] = uniform(w0, w1), uniform(w2, w3)
    return live


@lane_pass(layout.EXPECTATION)
def draw_point_at_event(b, table, first, live):
    """Draw the uniforms p0, p1 for a point on a detector at a later event.

    Fields: reads `history`, `event`; writes `p0`, `p1`.
    """
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    number = uint64(table.number) << DETECTOR_SHIFT
    for k in range(first, live):
        event = uint64(b.event[k]) | number
        w0, w1, w2, w3 = event_words(b.history[k], batch, event, EXPECT, seed_low, seed_high)
        b.p0[k], b.p1[k] = uniform(w0, w1), uniform(w2, w3)
    return live


@lane_pass(layout.EXPECTATION)
def point_on_rectangle(b, table, first, live):
    """Set a point uniform on a rectangle from p0, p1.

    Fields: reads `p0`, `p1`; writes `sx, sy, sz`.
    """
    cx, cy, cz, half_u, half_v = table.cx, table.cy, table.cz, table.half_u, table.half_v
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    for k in range(first, live):
        u, v = sample_rectangle(half_u, half_v, b.p0[k], b.p1[k])
        b.sx[k], b.sy[k], b.sz[k] = cx + u * eux + v * evx, cy + u * euy + v * evy, cz + u * euz + v * evz
    return live


@lane_pass(layout.EXPECTATION)
def point_on_disk(b, table, first, live):
    """Set a point uniform on a disk or annulus from p0, p1.

    Fields: reads `p0`, `p1`; writes `sx, sy, sz`.
    """
    cx, cy, cz, inner2, outer2 = table.cx, table.cy, table.cz, table.inner2, table.outer2
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    for k in range(first, live):
        u, v = sample_disk(inner2, outer2, b.p0[k], b.p1[k])
        b.sx[k], b.sy[k], b.sz[k] = cx + u * eux + v * evx, cy + u * euy + v * evy, cz + u * euz + v * evz
    return live


@lane_pass(layout.EXPECTATION)
def point_on_triangle(b, table, first, live):
    """Set a point uniform on a triangle (corner c, edges e_u, e_v) from p0, p1.

    Fields: reads `p0`, `p1`; writes `sx, sy, sz`.
    """
    cx, cy, cz = table.cx, table.cy, table.cz
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    for k in range(first, live):
        u, v = sample_triangle(b.p0[k], b.p1[k])
        b.sx[k], b.sy[k], b.sz[k] = cx + u * eux + v * evx, cy + u * euy + v * evy, cz + u * euz + v * evz
    return live


@lane_pass(layout.EXPECTATION)
def point_on_polygon(b, table, first, live):
    """Set a point uniform on a polygon from p0, p1: a triangle by its area, then a point uniform on it.

    Fields: reads `p0`, `p1`; writes `sx, sy, sz`.
    """
    count = table.part_count
    parts = view(table.parts, 10 * count, np.float64)
    for k in range(first, live):
        # Binary search in the cumulative shares of the area.
        chance, found, width = b.p0[k], 0, count
        while width > 1:
            half = width >> 1
            found += half if chance >= parts[10 * (found + half - 1)] else 0
            width -= half
        i = 10 * found
        before = parts[i - 10] if found > 0 else 0.0
        u, v = sample_triangle((chance - before) / (parts[i] - before), b.p1[k])
        b.sx[k] = parts[i + 1] + u * parts[i + 4] + v * parts[i + 7]
        b.sy[k] = parts[i + 2] + u * parts[i + 5] + v * parts[i + 8]
        b.sz[k] = parts[i + 3] + u * parts[i + 6] + v * parts[i + 9]
    return live


@lane_pass(layout.EXPECTATION)
def connect_to_flat(b, table, first, live):
    """Set the ray to that point, with its parameter 0 there, and its connection factor [sr].

    No contribution to a detector in the sheet that the lane stands on.

    Fields: reads `x, y, z`, `sheet`, `start`, `sx, sy, sz`; writes `vx, vy, vz`, `score`, `ray_start`.
    """
    nx, ny, nz, sheet = table.nx, table.ny, table.nz, table.sheet
    area, sharing = table.area, table.sharing
    for k in range(first, live):
        vx, vy, vz, r = direction_to(b.x[k], b.y[k], b.z[k], b.sx[k], b.sy[k], b.sz[k])
        brings = flat_connection(r * r, area, abs(vx * nx + vy * ny + vz * nz), sharing)
        b.vx[k], b.vy[k], b.vz[k], b.ray_start[k] = vx, vy, vz, b.start[k] - r
        b.score[k] = brings if standing_sheet(b.sheet[k]) != sheet else 0.0
    return live


@lane_pass(layout.EXPECTATION)
def connect_to_ball(b, table, first, live):
    """Set a ray uniform in the solid angle of a ball, and its connection factor [sr].

    The ray's parameter is 0 at its closest point to the centre, if that is ahead.

    Fields: reads `x, y, z`, `start`, `p0`, `p1`; writes `sx, sy, sz`, `vx, vy, vz`, `score`, `ray_start`.
    """
    cx, cy, cz, radius = table.cx, table.cy, table.cz, table.half_w
    area, sharing = table.area, table.sharing
    for k in range(first, live):
        rx, ry, rz = cx - b.x[k], cy - b.y[k], cz - b.z[k]
        d2 = rx * rx + ry * ry + rz * rz
        d = math.sqrt(d2)
        inverse = 1.0 / d if d2 > 0.0 else 0.0
        axis_x, axis_y, axis_z = rx * inverse, ry * inverse, rz * inverse if d2 > 0.0 else 1.0
        cone = cone_about(d2, radius)
        gap = cone * b.p0[k]  # 1 - cos of the angle from the axis
        cosine, sine = 1.0 - gap, math.sqrt(gap * (2.0 - gap))
        c, s = cos_sin_turn(b.p1[k])
        ex, ey, ez = turned_by(axis_x, axis_y, axis_z, 0.0, c, s)
        # Closest point to the centre.
        depth, ahead = d * sine, (cosine > 0.0) & (d2 > radius * radius)
        b.sx[k] = cx + depth * (cosine * ex - sine * axis_x) if ahead else b.x[k]
        b.sy[k] = cy + depth * (cosine * ey - sine * axis_y) if ahead else b.y[k]
        b.sz[k] = cz + depth * (cosine * ez - sine * axis_z) if ahead else b.z[k]
        b.ray_start[k] = b.start[k] - (d * cosine if ahead else 0.0)
        b.vx[k] = cosine * axis_x + sine * ex
        b.vy[k] = cosine * axis_y + sine * ey
        b.vz[k] = cosine * axis_z + sine * ez
        b.score[k] = ball_connection(d2, radius, area, sharing)
    return live


# ---- Contributions of events ----


@lane_pass(layout.EXPECTATION)
def contribute_from_births(b, table, first, live):
    """Set the contribution of a birth: its weight times its pdf [sr^-1] in the ray's direction.

    Fields: reads `weight`, `sheet`, `nx, ny, nz`, `vx, vy, vz`; updates `score`; writes `point_distance`,
    `pdf`, `shadow_sheet`, `tally`.
    """
    isotropic, lambertian, scale, tally = table.isotropic, table.lambertian, table.scale, table.first
    for k in range(first, live):
        cosine = b.vx[k] * b.nx[k] + b.vy[k] * b.ny[k] + b.vz[k] * b.nz[k] if lambertian > 0.0 else 0.0
        b.score[k] *= scale * b.weight[k]
        b.pdf[k] = isotropic + lambertian * (cosine if cosine > 0.0 else 0.0)
        b.point_distance[k], b.shadow_sheet[k], b.tally[k] = math.inf, b.sheet[k], tally
    return live


@lane_pass(layout.EXPECTATION)
def contribute_from_walls(b, table, first, live):
    """Set the contribution of a diffuse wall, of weight reflected or transmitted: pdf cosine/pi [sr^-1].

    Fields: reads `weight`, `sheet`, `hit`, `nx, ny, nz`, `mu`, `vx, vy, vz`; updates `score`; writes
    `point_distance`, `pdf`, `shadow_sheet`, `tally`.
    """
    scale, tally = table.scale, table.first
    for k in range(first, live):
        side = 1.0 if b.mu[k] > 0.0 else -1.0
        cosine = side * (b.vx[k] * b.nx[k] + b.vy[k] * b.ny[k] + b.vz[k] * b.nz[k])
        here = material_of(b.hit[k]) == layout.DIFFUSE
        b.score[k] *= scale * b.weight[k] if here & (cosine > 0.0) else 0.0
        b.pdf[k] = INVERSE_PI * cosine
        b.point_distance[k], b.shadow_sheet[k], b.tally[k] = math.inf, standing_sheet(b.sheet[k]), tally
    return live


@lane_pass(layout.EXPECTATION)
def contribute_from_collisions(b, table, first, live):
    """Set the contribution of a collision.

    Pdfs of phase functions are added next, none for lanes without collision.

    Fields: reads `ux, uy, uz`, `weight`, `vx, vy, vz`; updates `score`; writes `point_distance`,
    `scatter_cosine`, `pdf`, `shadow_sheet`, `tally`.
    """
    scale, tally = table.scale, table.first
    for k in range(first, live):
        b.scatter_cosine[k] = b.ux[k] * b.vx[k] + b.uy[k] * b.vy[k] + b.uz[k] * b.vz[k]
        b.score[k] *= scale * b.weight[k]
        b.pdf[k] = 0.0
        b.point_distance[k], b.shadow_sheet[k], b.tally[k] = math.inf, 0, tally
    return live


# ---- Tracing of next-event rays: they score at their own detector only.
#
# They pass other transparent detectors without a score, and end behind their own or at an acting surface.


@lane_pass(layout.NO_TABLE)
def end_missed_rays(b, table, first, live):
    """End rays that hit nothing more; idle lanes stay in place.

    Fields: updates `weight`, `start`, `distance`, `hit`.
    """
    for k in range(first, live):
        met = (b.hit[k] != 0) & (b.weight[k] != 0.0)
        b.weight[k] = b.weight[k] if met else 0.0
        b.distance[k] = b.distance[k] if met else 0.0
        b.start[k] = b.start[k] if met else 0.0
        b.hit[k] = b.hit[k] if met else 0
    return live


@lane_pass(layout.NO_TABLE)
def ignore_other_detectors(b, table, first, live):
    """Ignore detectors other than the one that the ray was cast to.

    Fields: reads `tally`; updates `detector_word`.
    """
    for k in range(first, live):
        is_target = (b.detector_word[k] & layout.DETECTOR_BASE_MASK) == b.tally[k]
        b.detector_word[k] = b.detector_word[k] if is_target else 0
    return live


@lane_pass(layout.NO_TABLE)
def keep_transmitted(b, table, first, live):
    """Score departures only for rays that pass through; a ray at a wall does not depart.

    Fields: reads `hit`; updates `detector_word`.
    """
    for k in range(first, live):
        passes = surface_of(b.hit[k]) == 0
        b.detector_word[k] = b.detector_word[k] if passes else 0
    return live


@lane_pass(layout.LAYERS)
def count_target_crossings(b, table, first, live):
    """Count one crossing of its target off the `leg` of each ray.

    Fields: reads `weight`, `hit`, `detector_word`; updates `leg`, `scored`.
    """
    layer, passed = table.layer, 0
    for k in range(first, live):
        there = (b.detector_word[k] != 0) & is_covered(b.hit[k], layer) & (b.weight[k] != 0.0)
        passed += 1 if there else 0
        b.leg[k] -= 1 if there else 0
    b.scored += passed * SCORE_BOUND
    return live


@lane_pass(layout.NO_TABLE)
def end_next_event_rays(b, table, first, live):
    """End rays at acting surfaces, and behind their target.

    Fields: reads `hit`, `leg`; updates `weight`.
    """
    for k in range(first, live):
        acts = surface_of(b.hit[k]) != 0
        b.weight[k] = 0.0 if acts | (b.leg[k] <= 0) else b.weight[k]
    return live
