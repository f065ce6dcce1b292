"""Once-more-collided estimator for point detectors: finite variance (Kalos 1963, Steinberg and Kalos 1971).

From a birth, a collision or a diffuse wall, a ray goes to a scattering point sampled with a pdf proportional
to 1/(a^2 b^2), with a and b its distances from both ends. This cancels both inverse squares, so scores go as
1/r only, with r from end to end, and their variance is finite. The ray is scattered at that point, in the
medium around the detector's point; all other scattering is scored from flights (next_event.py), which do not
come close to the point.
"""

import math

from transport.compile import layout
from transport.engine.bodies import lane_pass
from transport.engine.bundle import view
from transport.engine.passes.next_event import set_ray, words_of_event
from transport.engine.passes.shadow_rays import direction_to
from transport.physics.device import choose, device
from transport.physics.scattering import turned_by_angle
from transport.physics.sight import PI_CUBED, sample_detour, sample_equiangular_beyond
from transport.physics.streams import AGAIN, short_uniform, uniform


@lane_pass(layout.POINT)
def connect_by_detour(lane, table):
    """Set the first leg to a scattering point; its factor is one over (the point's pdf times a^2 b^2)."""
    x, y, z = lane.x, lane.y, lane.z
    w0, w1, w2, w3 = words_of_event(lane, table.number, AGAIN)
    ex, ey, ez, r = direction_to(x, y, z, table.x, table.y, table.z)
    mu, sine, leg = sample_detour(r, uniform(w0, w1), short_uniform(w3))
    vx, vy, vz = turned_by_angle(ex, ey, ez, mu, sine, short_uniform(w2))
    set_ray(lane, x, y, z, vx, vy, vz, 0.0, leg)
    lane.score = PI_CUBED / r if r > 0.0 else 0.0


@lane_pass(layout.POINT)
def connect_along_beam(lane, table):
    """Set the first leg along a beam: to a place on its line, sampled equiangularly."""
    x, y, z, ux, uy, uz = lane.x, lane.y, lane.z, lane.ux, lane.uy, lane.uz
    w0, w1, _, _ = words_of_event(lane, table.number, AGAIN)
    rx, ry, rz = table.x - x, table.y - y, table.z - z
    foot = rx * ux + ry * uy + rz * uz
    qx, qy, qz = rx - foot * ux, ry - foot * uy, rz - foot * uz
    least = math.sqrt(qx * qx + qy * qy + qz * qz)
    leg, lane.score = sample_equiangular_beyond(least, -foot, uniform(w0, w1))
    set_ray(lane, x, y, z, ux, uy, uz, 0.0, leg)


@device
def ends_first_leg(lane, table):
    """Return whether a ray has reached the end of its first leg."""
    return (lane.leg <= layout.FIRST_LEG) & (lane.hit == 0) & (lane.weight != 0.0)


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
    point, medium, length, mfp = points[layout.FIRST_LEG - lane.leg], lane.medium, lane.distance, lane.mfp
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
    turns = (lane.leg <= layout.FIRST_LEG) & (lane.hit == 0)
    score = lane.score * lane.pdf
    after = lane.weight * score if score > 0.0 else 0.0
    lane.weight = choose(turns, after, lane.weight)
    lane.leg = choose(turns, layout.STRAIGHT_LEG, lane.leg)
