"""Once-more-collided estimator for point detectors: finite variance (Kalos 1963, Steinberg and Kalos 1971).

From a birth, a collision or a diffuse wall, a ray goes to a scattering point sampled with a pdf proportional
to 1/(a^2 b^2), with a and b its distances from both ends. This cancels both inverse squares, so scores go as
1/r only, with r from end to end, and their variance is finite. The ray is scattered at that point, in the
medium around the detector's point; all other scattering is scored from flights (shadow_rays.py), which do not
come close to the point.
"""

import math

from numba import uint64

from transport.compile import layout
from transport.engine.bodies import lane_pass
from transport.engine.bundle import view
from transport.engine.passes.shadow_rays import DETECTOR_SHIFT, INVERSE_PI, direction_to
from transport.engine.words import standing_sheet
from transport.physics.device import choose, device
from transport.physics.scattering import turned_by_angle
from transport.physics.sight import PI_CUBED, sample_detour, sample_equiangular_beyond
from transport.physics.streams import AGAIN, event_words, short_uniform, uniform


@device
def sample_first_leg(x, y, z, px, py, pz, w0, w1, w2, w3):
    """Return direction and length of the first leg, and one over (its pdf times a^2 b^2)."""
    ex, ey, ez, r = direction_to(x, y, z, px, py, pz)
    mu, sine, leg = sample_detour(r, uniform(w0, w1), short_uniform(w3))
    vx, vy, vz = turned_by_angle(ex, ey, ez, mu, sine, short_uniform(w2))
    return vx, vy, vz, leg, PI_CUBED / r if r > 0.0 else 0.0


@lane_pass(layout.POINT_EMISSION)
def first_leg_from_births(lane, table):
    """Cast the first leg from a birth: light that is scattered once."""
    px, py, pz, tally = table.x, table.y, table.z, table.first
    isotropic, lambertian = table.isotropic, table.lambertian
    seed_low, seed_high, batch = lane.seed_low, lane.seed_high, lane.batch
    event = uint64(table.number) << DETECTOR_SHIFT
    w0, w1, w2, w3 = event_words(lane.history, batch, event, AGAIN, seed_low, seed_high)
    vx, vy, vz, leg, inverse = sample_first_leg(lane.x, lane.y, lane.z, px, py, pz, w0, w1, w2, w3)
    cosine = vx * lane.nx + vy * lane.ny + vz * lane.nz if lambertian > 0.0 else 0.0
    lane.sx, lane.sy, lane.sz = lane.x, lane.y, lane.z
    lane.vx, lane.vy, lane.vz, lane.point_distance = vx, vy, vz, leg
    lane.score = lane.weight * inverse
    lane.pdf = isotropic + lambertian * (cosine if cosine > 0.0 else 0.0)
    lane.shadow_sheet, lane.tally = lane.sheet, tally


@lane_pass(layout.POINT_EMISSION)
def first_leg_along_beams(lane, table):
    """Cast the first leg along a beam: a place on its line, sampled equiangularly."""
    px, py, pz, tally = table.x, table.y, table.z, table.first
    seed_low, seed_high, batch = lane.seed_low, lane.seed_high, lane.batch
    event = uint64(table.number) << DETECTOR_SHIFT
    w0, w1, _, _ = event_words(lane.history, batch, event, AGAIN, seed_low, seed_high)
    ux, uy, uz = lane.ux, lane.uy, lane.uz
    rx, ry, rz = px - lane.x, py - lane.y, pz - lane.z
    foot = rx * ux + ry * uy + rz * uz
    qx, qy, qz = rx - foot * ux, ry - foot * uy, rz - foot * uz
    least = math.sqrt(qx * qx + qy * qy + qz * qz)
    leg, inverse = sample_equiangular_beyond(least, -foot, uniform(w0, w1))
    lane.sx, lane.sy, lane.sz = lane.x, lane.y, lane.z
    lane.vx, lane.vy, lane.vz, lane.point_distance = ux, uy, uz, leg
    lane.score, lane.pdf = lane.weight * inverse, 1.0
    lane.shadow_sheet, lane.tally = lane.sheet, tally


@lane_pass(layout.ROWS)
def find_phase_at_collisions(lane, table):
    """Set the number of the phase function of the medium that a lane collides in; 0 without a collision."""
    rows = view(lane.arena + table.rows, table.count, layout.MEDIA)
    lane.phase_number = rows[lane.medium].phase if lane.collides != 0 else 0


@lane_pass(layout.POINT)
def first_leg_from_collisions(lane, table):
    """Cast the first leg from a collision: light that is scattered once more."""
    px, py, pz, tally = table.x, table.y, table.z, table.first
    seed_low, seed_high, batch = lane.seed_low, lane.seed_high, lane.batch
    number = uint64(table.number) << DETECTOR_SHIFT
    event = uint64(lane.event) | number
    w0, w1, w2, w3 = event_words(lane.history, batch, event, AGAIN, seed_low, seed_high)
    vx, vy, vz, leg, inverse = sample_first_leg(lane.x, lane.y, lane.z, px, py, pz, w0, w1, w2, w3)
    lane.sx, lane.sy, lane.sz = lane.x, lane.y, lane.z
    lane.vx, lane.vy, lane.vz, lane.point_distance = vx, vy, vz, leg
    lane.scatter_cosine = lane.ux * vx + lane.uy * vy + lane.uz * vz
    lane.score = lane.weight * inverse if lane.phase_number != 0 else 0.0
    lane.pdf, lane.shadow_sheet, lane.tally = 0.0, 0, tally


@lane_pass(layout.POINT)
def first_leg_from_walls(lane, table):
    """Cast the first leg from a diffuse wall: light that is scattered once."""
    px, py, pz, tally = table.x, table.y, table.z, table.first
    seed_low, seed_high, batch = lane.seed_low, lane.seed_high, lane.batch
    number = uint64(table.number) << DETECTOR_SHIFT
    event = uint64(lane.event) | number
    w0, w1, w2, w3 = event_words(lane.history, batch, event, AGAIN, seed_low, seed_high)
    vx, vy, vz, leg, inverse = sample_first_leg(lane.x, lane.y, lane.z, px, py, pz, w0, w1, w2, w3)
    side = 1.0 if lane.mu > 0.0 else -1.0
    cosine = side * (vx * lane.nx + vy * lane.ny + vz * lane.nz)
    here = lane.material == layout.DIFFUSE
    lane.sx, lane.sy, lane.sz = lane.x, lane.y, lane.z
    lane.vx, lane.vy, lane.vz, lane.point_distance = vx, vy, vz, leg
    lane.score = lane.weight * inverse if here & (cosine > 0.0) else 0.0
    lane.pdf, lane.shadow_sheet, lane.tally = INVERSE_PI * cosine, standing_sheet(lane.sheet), tally


@device
def ends_first_leg(lane, table):
    """Return whether a ray has reached the end of its first leg."""
    return (lane.leg != 0) & (lane.hit == 0) & (lane.weight != 0.0)


@lane_pass(layout.NO_TABLE)
def reset_phase_number(lane, table):
    """Set no phase function."""
    lane.phase_number = 0


@lane_pass(layout.TWO_ROWS, when=ends_first_leg)
def turn_into_second_leg(lane, table):
    """Turn a ray towards the point at the end of its first leg, in the medium around the point."""
    points = view(lane.arena + table.rows, table.count, layout.POINT)
    media = view(lane.arena + table.others, table.other_count, layout.MEDIA)
    # Direction to the point, scattering angle and coefficient; pdfs of phase functions follow.
    point, medium, length, mfp = points[lane.leg - 1], lane.medium, lane.distance, lane.mfp
    here = medium == point.medium
    x, y, z = lane.x + length * lane.ux, lane.y + length * lane.uy, lane.z + length * lane.uz
    vx, vy, vz, r = direction_to(x, y, z, point.x, point.y, point.z)
    sigma_s = lane.survival / mfp if mfp < math.inf else -1.0
    lane.scatter_cosine = lane.ux * vx + lane.uy * vy + lane.uz * vz
    lane.phase_number = media[medium].phase if here else 0
    lane.score = sigma_s if here else 0.0
    lane.pdf = 0.0
    lane.x, lane.y, lane.z, lane.ux, lane.uy, lane.uz = x, y, z, vx, vy, vz
    lane.sx, lane.sy, lane.sz = x, y, z
    lane.point_distance, lane.start, lane.sheet = r, 0.0, 0


@lane_pass(layout.NO_TABLE)
def start_second_leg(lane, table):
    """Start the second leg with the weight that is scattered into it."""
    turns = (lane.leg != 0) & (lane.hit == 0)
    score = lane.score * lane.pdf
    after = lane.weight * score if score > 0.0 else 0.0
    lane.weight = choose(turns, after, lane.weight)
    lane.leg = choose(turns, 0, lane.leg)
