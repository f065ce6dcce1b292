"""Next-event estimation: rays from births, walls and collisions to surface and point detectors.

A ray is sampled in steps. Sample a point on the detector; connect the event to it; contribute: the pdf with
which the event emits in that direction over the pdf of sampling it (Kalos 1963; physics/connections.py). Rays
are listed and traced next (shadow_rays.py). Each way to connect serves all kinds of events, and each kind of
event all ways. Rays from glossy walls are completed in gloss.py, MIS weights of flights are in mis.py.
"""

import math

import numpy as np
from numba import uint64

from transport.compile import layout
from transport.compile.layout import COLLISION_CLEARANCE
from transport.engine.bodies import lane_pass
from transport.engine.bundle import view
from transport.engine.passes.shadow_rays import direction_to
from transport.engine.passes.volumes import clip_to_slab, half_chord, nearest_to_centre
from transport.engine.words import standing_sheet
from transport.physics.connections import ball_connection, flat_connection
from transport.physics.device import device
from transport.physics.directions import sample_isotropic, turned_by
from transport.physics.elementary import cos_sin_turn, exp_negative
from transport.physics.emission import cone_about
from transport.physics.positions import place_in_frame, sample_disk, sample_rectangle, sample_triangle
from transport.physics.rays import plane_crossing
from transport.physics.sight import sample_equiangular
from transport.physics.streams import EXPECT, SHADOW, event_words, random_words, short_uniform, uniform

DETECTOR_SHIFT = uint64(24)  # bits of an event below the number of the detector
INVERSE_PI = 0.3183098861837907


@device
def words_of_event(lane, number, purpose):
    """Return the random words of a lane's event for one detector."""
    event = uint64(lane.event) | (uint64(number) << DETECTOR_SHIFT)
    return event_words(lane.history, lane.batch, event, purpose, lane.seed_low, lane.seed_high)


@device
def set_ray(lane, x, y, z, vx, vy, vz, start, end):
    """Set the ray through a point: its direction, and the ray parameters of its origin and of its end."""
    lane.sx, lane.sy, lane.sz, lane.vx, lane.vy, lane.vz = x, y, z, vx, vy, vz
    lane.ray_start, lane.point_distance = start, end


# ---- Sample a point on a detector; a point detector needs none.


@lane_pass(layout.EXPECTATION)
def draw_joint_point_at_birth(lane, table):
    """Draw the uniforms p0, p1 for a point on the first detector.

    Quasi-random points pair these with the birthplace.
    """
    seed_low, seed_high, batch = lane.seed_low, lane.seed_high, lane.batch
    w0, w1, w2, w3 = random_words(lane.history, batch, 0, EXPECT, seed_low, seed_high)
    lane.p0, lane.p1 = uniform(w0, w1), uniform(w2, w3)


@lane_pass(layout.EXPECTATION)
def draw_point(lane, table):
    """Draw the uniforms p0, p1 for a point on a further detector at a birth, or on any at a later event."""
    w0, w1, w2, w3 = words_of_event(lane, table.number, EXPECT)
    lane.p0, lane.p1 = uniform(w0, w1), uniform(w2, w3)


@lane_pass(layout.EXPECTATION)
def point_on_rectangle(lane, table):
    """Set a point uniform on a rectangle from p0, p1."""
    lane.sx, lane.sy, lane.sz = place_in_frame(
        table, *sample_rectangle(table.half_u, table.half_v, lane.p0, lane.p1)
    )


@lane_pass(layout.EXPECTATION)
def point_on_disk(lane, table):
    """Set a point uniform on a disk or annulus from p0, p1."""
    lane.sx, lane.sy, lane.sz = place_in_frame(
        table, *sample_disk(table.inner2, table.outer2, lane.p0, lane.p1)
    )


@lane_pass(layout.EXPECTATION)
def point_on_triangle(lane, table):
    """Set a point uniform on a triangle (corner c, edges e_u, e_v) from p0, p1."""
    lane.sx, lane.sy, lane.sz = place_in_frame(table, *sample_triangle(lane.p0, lane.p1))


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


# ---- Connect: set the ray from a lane's event, and as `score` its connection factor.
#
# The factor is one over the pdf of sampling the direction: a solid angle [sr], or one over the squared
# distance of a point. Where a point on a flight or in a source is sampled as well, it includes that.


@lane_pass(layout.EXPECTATION)
def connect_to_flat(lane, table):
    """Set the ray to that point, with its parameter 0 there, and its connection factor [sr].

    No contribution to a detector in the sheet that the lane stands on.
    """
    nx, ny, nz, sheet = table.nx, table.ny, table.nz, table.sheet
    area, sharing = table.area, table.sharing
    vx, vy, vz, r = direction_to(lane.x, lane.y, lane.z, lane.sx, lane.sy, lane.sz)
    brings = flat_connection(r * r, area, abs(vx * nx + vy * ny + vz * nz), sharing)
    set_ray(lane, lane.sx, lane.sy, lane.sz, vx, vy, vz, lane.start - r, math.inf)
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
    vx, vy, vz = cosine * axis_x + sine * ex, cosine * axis_y + sine * ey, cosine * axis_z + sine * ez
    # Closest point to the centre.
    depth, ahead = d * sine, (cosine > 0.0) & (d2 > radius * radius)
    x = cx + depth * (cosine * ex - sine * axis_x) if ahead else lane.x
    y = cy + depth * (cosine * ey - sine * axis_y) if ahead else lane.y
    z = cz + depth * (cosine * ez - sine * axis_z) if ahead else lane.z
    set_ray(lane, x, y, z, vx, vy, vz, lane.start - (d * cosine if ahead else 0.0), math.inf)
    lane.score = ball_connection(d2, radius, area, sharing)


@lane_pass(layout.POINT)
def connect_to_point(lane, table):
    """Set the ray to a point detector; its connection factor is one over the squared distance."""
    x, y, z = lane.x, lane.y, lane.z
    vx, vy, vz, r = direction_to(x, y, z, table.x, table.y, table.z)
    set_ray(lane, x, y, z, vx, vy, vz, 0.0, r)
    lane.score = 1.0 / (r * r) if r > 0.0 else 0.0


@device
def crossing_against_beam(lane, table):
    """Return the way from an event against a beam to a plane, and the crossing relative to a point there."""
    rx, ry, rz = table.cx - lane.x, table.cy - lane.y, table.cz - lane.z
    return plane_crossing(rx, ry, rz, -table.ux, -table.uy, -table.uz, table.nx, table.ny, table.nz)


@device
def set_ray_against_beam(lane, table, way, is_met):
    """Set the ray to the place of a beam's shape that shines on the event; its factor is 1, or 0 for none."""
    x, y, z, end = lane.x, lane.y, lane.z, way - table.slack
    set_ray(lane, x, y, z, -table.ux, -table.uy, -table.uz, lane.start, end)
    lane.score = 1.0 if is_met & (end > lane.start) else 0.0


@lane_pass(layout.BEAM_PART)
def connect_to_beam_of_rectangle(lane, table):
    """Set the ray against the beam of a rectangle."""
    way, qx, qy, qz = crossing_against_beam(lane, table)
    u = qx * table.eux + qy * table.euy + qz * table.euz
    v = qx * table.evx + qy * table.evy + qz * table.evz
    set_ray_against_beam(lane, table, way, (abs(u) <= table.half_u) & (abs(v) <= table.half_v))


@lane_pass(layout.BEAM_PART)
def connect_to_beam_of_disk(lane, table):
    """Set the ray against the beam of a disk or annulus."""
    way, qx, qy, qz = crossing_against_beam(lane, table)
    rho2 = qx * qx + qy * qy + qz * qz
    set_ray_against_beam(lane, table, way, (rho2 >= table.inner2) & (rho2 <= table.outer2))


@lane_pass(layout.BEAM_PART)
def connect_to_beam_of_triangle(lane, table):
    """Set the ray against the beam of a triangle, or of a part of a polygon."""
    way, qx, qy, qz = crossing_against_beam(lane, table)
    a = qx * table.ax + qy * table.ay + qz * table.az
    b = qx * table.bx + qy * table.by + qz * table.bz
    set_ray_against_beam(lane, table, way, (a >= 0.0) & (b >= 0.0) & (a + b <= 1.0))


@device
def line_through_point(lane, table):
    """Return a point relative to a source's middle, an isotropic direction and a uniform number."""
    event = uint64(table.number) << DETECTOR_SHIFT
    w0, w1, w2, w3 = random_words(lane.history, lane.batch, event, SHADOW, lane.seed_low, lane.seed_high)
    ox, oy, oz = table.x - table.cx, table.y - table.cy, table.z - table.cz
    return ox, oy, oz, *sample_isotropic(uniform(w0, w1), short_uniform(w2)), short_uniform(w3)


@device
def set_ray_from_chord(lane, table, ux, uy, uz, near, far, chance):
    """Set the ray to a point from a place uniform on its line's chord of a source, and the factor."""
    length = far - near if near < far else 0.0
    s = near + chance * length if near < far else 1.0
    x, y, z = table.x + s * ux, table.y + s * uy, table.z + s * uz
    set_ray(lane, x, y, z, -ux, -uy, -uz, 0.0, s)
    lane.score = length * table.scale


@lane_pass(layout.POINT_GLOW)
def connect_through_box(lane, table):
    """Set a ray from a uniformly emitting box to a point.

    Samples an isotropic line through the point and a uniform place in the box on it: the factor 1/r^2 is
    sampled rather than weighted.
    """
    ox, oy, oz, ux, uy, uz, chance = line_through_point(lane, table)
    near, far = clip_to_slab(0.0, math.inf, ox, ux, table.hx)
    near, far = clip_to_slab(near, far, oy, uy, table.hy)
    near, far = clip_to_slab(near, far, oz, uz, table.hz)
    set_ray_from_chord(lane, table, ux, uy, uz, near, far, chance)


@lane_pass(layout.POINT_GLOW)
def connect_through_sphere(lane, table):
    """Set a ray from a uniformly emitting ball to a point.

    The chord follows from its point nearest the centre.
    """
    ox, oy, oz, ux, uy, uz, chance = line_through_point(lane, table)
    h, q = nearest_to_centre(ox, oy, oz, ux, uy, uz)
    half = half_chord(table.hx, q)
    set_ray_from_chord(lane, table, ux, uy, uz, max(0.0, -h - half), half - h, chance)


@lane_pass(layout.POINT)
def connect_to_flight(lane, table):
    """Set a ray from a scattering point sampled equiangularly on each flight (Kulla and Fajardo 2012).

    No factor for survival to that point: the flight's length is itself sampled; only absorption along it is
    weighted. In voxels the coefficient is not known yet: the score stays negative until
    `scale_by_grid_scattering`.
    """
    px, py, pz, medium = table.x, table.y, table.z, table.medium
    w0, w1, _, _ = words_of_event(lane, table.number, SHADOW)
    x, y, z, ux, uy, uz = lane.x, lane.y, lane.z, lane.ux, lane.uy, lane.uz
    rx, ry, rz = px - x, py - y, pz - z
    # Foot of the perpendicular from the point on the ray, and its length.
    foot = rx * ux + ry * uy + rz * uz
    qx, qy, qz = rx - foot * ux, ry - foot * uy, rz - foot * uz
    least = math.sqrt(qx * qx + qy * qy + qz * qz)
    start, end, mfp = lane.start + COLLISION_CLEARANCE, lane.distance - COLLISION_CLEARANCE, lane.mfp
    flies = (lane.weight != 0.0) & (lane.phase_number != 0) & (lane.medium != medium)
    flies &= (start < end) & (end < math.inf)
    # Sample the place; `inverse` is one over (pdf times r^2).
    end = end if flies else start
    place, inverse = sample_equiangular(least, start - foot, end - foot, uniform(w0, w1))
    t = foot + place
    sx, sy, sz = x + t * ux, y + t * uy, z + t * uz
    vx, vy, vz, r = direction_to(sx, sy, sz, px, py, pz)
    sigma_s = lane.survival / mfp if mfp < math.inf else -1.0
    score = exp_negative(-lane.sigma_a * (t - lane.start)) * sigma_s * inverse
    set_ray(lane, sx, sy, sz, vx, vy, vz, 0.0, r)
    lane.score = score if flies else 0.0


# ---- Contribute: multiply by the event's weight, and set its pdf in the direction of the ray.


@lane_pass(layout.CONTRIBUTION)
def contribute_from_births(lane, table):
    """Set the contribution of a birth: its weight times its pdf [sr^-1] in the ray's direction."""
    isotropic, lambertian = table.isotropic, table.lambertian
    cosine = lane.vx * lane.nx + lane.vy * lane.ny + lane.vz * lane.nz if lambertian > 0.0 else 0.0
    lane.score *= table.scale * lane.weight
    lane.pdf = isotropic + lambertian * (cosine if cosine > 0.0 else 0.0)
    lane.shadow_sheet, lane.tally = lane.sheet, table.first


@lane_pass(layout.CONTRIBUTION)
def contribute_from_walls(lane, table):
    """Set the contribution of a diffuse wall, of weight reflected or transmitted: pdf cosine/pi [sr^-1].

    The pdf of a glossy wall is added next; that of other walls is 0.
    """
    side = 1.0 if lane.mu > 0.0 else -1.0
    cosine = side * (lane.vx * lane.nx + lane.vy * lane.ny + lane.vz * lane.nz)
    here = lane.material == layout.DIFFUSE
    lane.score *= table.scale * lane.weight if cosine > 0.0 else 0.0
    lane.pdf = INVERSE_PI * cosine if here else 0.0
    lane.shadow_sheet, lane.tally = standing_sheet(lane.sheet), table.first


@lane_pass(layout.CONTRIBUTION)
def contribute_from_scattering(lane, table):
    """Set the contribution of a collision, or of a scattering point on a flight.

    Pdfs of phase functions are added next, none for lanes without either.
    """
    lane.scatter_cosine = lane.ux * lane.vx + lane.uy * lane.vy + lane.uz * lane.vz
    lane.score *= table.scale * lane.weight
    lane.shadow_sheet, lane.pdf, lane.tally = 0, 0.0, table.first


@lane_pass(layout.ROWS)
def find_phase_of_flights(lane, table):
    """Set the number of the phase function of the medium that a lane flies in."""
    rows = view(lane.arena + table.rows, table.count, layout.MEDIA)
    lane.phase_number = rows[lane.medium].phase


@lane_pass(layout.ROWS)
def find_phase_at_collisions(lane, table):
    """Set the number of the phase function of the medium that a lane collides in; 0 without a collision."""
    rows = view(lane.arena + table.rows, table.count, layout.MEDIA)
    lane.phase_number = rows[lane.medium].phase if lane.collides != 0 else 0
