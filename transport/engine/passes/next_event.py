"""Next-event estimation for surface detectors: rays from emissions, diffuse reflections and collisions.

A ray goes from the event to a point sampled on the detector; its contribution is the pdf with which the event
emits in that direction over the pdf of sampling it (Kalos 1963; physics/connections.py). MIS weights of
flights are in mis.py, tracing of rays in stages/next_event.py.
"""

import math

import numpy as np
from numba import uint64

from transport.compile import layout
from transport.engine.bodies import lane_pass
from transport.engine.bundle import view
from transport.engine.passes.shadow_rays import DETECTOR_SHIFT, INVERSE_PI, SCORE_BOUND, direction_to
from transport.engine.tally import to_scored
from transport.engine.words import is_covered, standing_sheet
from transport.physics.connections import ball_connection, flat_connection
from transport.physics.device import choose
from transport.physics.directions import turned_by
from transport.physics.elementary import cos_sin_turn
from transport.physics.emission import cone_about
from transport.physics.positions import sample_disk, sample_rectangle, sample_triangle
from transport.physics.streams import EXPECT, event_words, random_words, uniform

# ---- Points on detectors ----


@lane_pass(layout.NO_TABLE)
def draw_joint_point_at_birth(lane, table):
    """Draw the uniforms p0, p1 for a point on the first detector.

    Quasi-random points pair these with the birthplace.
    """
    seed_low, seed_high, batch = lane.seed_low, lane.seed_high, lane.batch
    w0, w1, w2, w3 = random_words(lane.history, batch, 0, EXPECT, seed_low, seed_high)
    lane.p0, lane.p1 = uniform(w0, w1), uniform(w2, w3)


@lane_pass(layout.EXPECTATION)
def draw_point_at_birth(lane, table):
    """Draw the uniforms p0, p1 for a point on a further detector."""
    seed_low, seed_high, batch = lane.seed_low, lane.seed_high, lane.batch
    number = uint64(table.number) << DETECTOR_SHIFT
    w0, w1, w2, w3 = event_words(lane.history, batch, number, EXPECT, seed_low, seed_high)
    lane.p0, lane.p1 = uniform(w0, w1), uniform(w2, w3)


@lane_pass(layout.EXPECTATION)
def draw_point_at_event(lane, table):
    """Draw the uniforms p0, p1 for a point on a detector at a later event."""
    seed_low, seed_high, batch = lane.seed_low, lane.seed_high, lane.batch
    number = uint64(table.number) << DETECTOR_SHIFT
    event = uint64(lane.event) | number
    w0, w1, w2, w3 = event_words(lane.history, batch, event, EXPECT, seed_low, seed_high)
    lane.p0, lane.p1 = uniform(w0, w1), uniform(w2, w3)


@lane_pass(layout.EXPECTATION)
def point_on_rectangle(lane, table):
    """Set a point uniform on a rectangle from p0, p1."""
    cx, cy, cz, half_u, half_v = table.cx, table.cy, table.cz, table.half_u, table.half_v
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    u, v = sample_rectangle(half_u, half_v, lane.p0, lane.p1)
    lane.sx, lane.sy, lane.sz = cx + u * eux + v * evx, cy + u * euy + v * evy, cz + u * euz + v * evz


@lane_pass(layout.EXPECTATION)
def point_on_disk(lane, table):
    """Set a point uniform on a disk or annulus from p0, p1."""
    cx, cy, cz, inner2, outer2 = table.cx, table.cy, table.cz, table.inner2, table.outer2
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    u, v = sample_disk(inner2, outer2, lane.p0, lane.p1)
    lane.sx, lane.sy, lane.sz = cx + u * eux + v * evx, cy + u * euy + v * evy, cz + u * euz + v * evz


@lane_pass(layout.EXPECTATION)
def point_on_triangle(lane, table):
    """Set a point uniform on a triangle (corner c, edges e_u, e_v) from p0, p1."""
    cx, cy, cz = table.cx, table.cy, table.cz
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    u, v = sample_triangle(lane.p0, lane.p1)
    lane.sx, lane.sy, lane.sz = cx + u * eux + v * evx, cy + u * euy + v * evy, cz + u * euz + v * evz


@lane_pass(layout.EXPECTATION)
def point_on_polygon(lane, table):
    """Set a point uniform on a polygon from p0, p1: a triangle by its area, then a point uniform on it."""
    count = table.part_count
    parts = view(lane.arena + table.parts, 10 * count, np.float64)
    # Binary search in the cumulative shares of the area.
    chance, found, width = lane.p0, 0, count
    while width > 1:
        half = width >> 1
        found += half if chance >= parts[10 * (found + half - 1)] else 0
        width -= half
    i = 10 * found
    before = parts[i - 10] if found > 0 else 0.0
    u, v = sample_triangle((chance - before) / (parts[i] - before), lane.p1)
    lane.sx = parts[i + 1] + u * parts[i + 4] + v * parts[i + 7]
    lane.sy = parts[i + 2] + u * parts[i + 5] + v * parts[i + 8]
    lane.sz = parts[i + 3] + u * parts[i + 6] + v * parts[i + 9]


@lane_pass(layout.EXPECTATION)
def connect_to_flat(lane, table):
    """Set the ray to that point, with its parameter 0 there, and its connection factor [sr].

    No contribution to a detector in the sheet that the lane stands on.
    """
    nx, ny, nz, sheet = table.nx, table.ny, table.nz, table.sheet
    area, sharing = table.area, table.sharing
    vx, vy, vz, r = direction_to(lane.x, lane.y, lane.z, lane.sx, lane.sy, lane.sz)
    brings = flat_connection(r * r, area, abs(vx * nx + vy * ny + vz * nz), sharing)
    lane.vx, lane.vy, lane.vz, lane.ray_start = vx, vy, vz, lane.start - r
    lane.score = brings if standing_sheet(lane.sheet) != sheet else 0.0


@lane_pass(layout.EXPECTATION)
def connect_to_ball(lane, table):
    """Set a ray uniform in the solid angle of a ball, and its connection factor [sr].

    The ray's parameter is 0 at its closest point to the centre, if that is ahead.
    """
    cx, cy, cz, radius = table.cx, table.cy, table.cz, table.half_w
    area, sharing = table.area, table.sharing
    rx, ry, rz = cx - lane.x, cy - lane.y, cz - lane.z
    d2 = rx * rx + ry * ry + rz * rz
    d = math.sqrt(d2)
    inverse = 1.0 / d if d2 > 0.0 else 0.0
    axis_x, axis_y, axis_z = rx * inverse, ry * inverse, rz * inverse if d2 > 0.0 else 1.0
    cone = cone_about(d2, radius)
    gap = cone * lane.p0  # 1 - cos of the angle from the axis
    cosine, sine = 1.0 - gap, math.sqrt(gap * (2.0 - gap))
    c, s = cos_sin_turn(lane.p1)
    ex, ey, ez = turned_by(axis_x, axis_y, axis_z, 0.0, c, s)
    # Closest point to the centre.
    depth, ahead = d * sine, (cosine > 0.0) & (d2 > radius * radius)
    lane.sx = cx + depth * (cosine * ex - sine * axis_x) if ahead else lane.x
    lane.sy = cy + depth * (cosine * ey - sine * axis_y) if ahead else lane.y
    lane.sz = cz + depth * (cosine * ez - sine * axis_z) if ahead else lane.z
    lane.ray_start = lane.start - (d * cosine if ahead else 0.0)
    lane.vx = cosine * axis_x + sine * ex
    lane.vy = cosine * axis_y + sine * ey
    lane.vz = cosine * axis_z + sine * ez
    lane.score = ball_connection(d2, radius, area, sharing)


# ---- Contributions of events ----


@lane_pass(layout.EXPECTATION)
def contribute_from_births(lane, table):
    """Set the contribution of a birth: its weight times its pdf [sr^-1] in the ray's direction."""
    isotropic, lambertian, scale, tally = table.isotropic, table.lambertian, table.scale, table.first
    cosine = lane.vx * lane.nx + lane.vy * lane.ny + lane.vz * lane.nz if lambertian > 0.0 else 0.0
    lane.score *= scale * lane.weight
    lane.pdf = isotropic + lambertian * (cosine if cosine > 0.0 else 0.0)
    lane.point_distance, lane.shadow_sheet, lane.tally = math.inf, lane.sheet, tally


@lane_pass(layout.EXPECTATION)
def contribute_from_walls(lane, table):
    """Set the contribution of a diffuse wall, of weight reflected or transmitted: pdf cosine/pi [sr^-1]."""
    scale, tally = table.scale, table.first
    side = 1.0 if lane.mu > 0.0 else -1.0
    cosine = side * (lane.vx * lane.nx + lane.vy * lane.ny + lane.vz * lane.nz)
    here = lane.material == layout.DIFFUSE
    lane.score *= scale * lane.weight if here & (cosine > 0.0) else 0.0
    lane.pdf = INVERSE_PI * cosine
    lane.point_distance, lane.shadow_sheet, lane.tally = math.inf, standing_sheet(lane.sheet), tally


@lane_pass(layout.EXPECTATION)
def contribute_from_collisions(lane, table):
    """Set the contribution of a collision.

    Pdfs of phase functions are added next, none for lanes without collision.
    """
    scale, tally = table.scale, table.first
    lane.scatter_cosine = lane.ux * lane.vx + lane.uy * lane.vy + lane.uz * lane.vz
    lane.score *= scale * lane.weight
    lane.pdf = 0.0
    lane.point_distance, lane.shadow_sheet, lane.tally = math.inf, 0, tally


# ---- Tracing of next-event rays: they score at their own detector only.
#
# They pass other transparent detectors without a score, and end behind their own or at an acting surface.


@lane_pass(layout.NO_TABLE)
def end_missed_rays(lane, table):
    """End rays that hit nothing more; idle lanes stay in place."""
    met = (lane.hit != 0) & (lane.weight != 0.0)
    lane.weight = choose(met, lane.weight, 0.0)
    lane.distance = choose(met, lane.distance, 0.0)
    lane.start = choose(met, lane.start, 0.0)
    lane.hit = choose(met, lane.hit, 0)
    lane.covered = choose(met, lane.covered, 0)


@lane_pass(layout.NO_TABLE)
def ignore_other_detectors(lane, table):
    """Ignore detectors other than the one that the ray was cast to."""
    is_target = (lane.detector_word & layout.DETECTOR_BASE_MASK) == lane.tally
    lane.detector_word = choose(is_target, lane.detector_word, 0)


@lane_pass(layout.NO_TABLE)
def keep_transmitted(lane, table):
    """Score departures only for rays that pass through; a ray at a wall does not depart."""
    passes = lane.surface == 0
    lane.detector_word = choose(passes, lane.detector_word, 0)


@lane_pass(layout.LAYERS, sums=to_scored)
def count_target_crossings(lane, table):
    """Count one crossing of its target off the `leg` of each ray."""
    there = (lane.detector_word != 0) & is_covered(lane.covered, table.layer) & (lane.weight != 0.0)
    lane.leg -= 1 if there else 0
    return SCORE_BOUND if there else 0


@lane_pass(layout.NO_TABLE)
def end_next_event_rays(lane, table):
    """End rays at acting surfaces, and behind their target."""
    acts = lane.surface != 0
    lane.weight = choose(acts | (lane.leg <= 0), 0.0, lane.weight)
