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
from transport.engine.bundle import view
from transport.engine.passes.shadow_rays import DETECTOR_SHIFT, INVERSE_PI, direction_to
from transport.engine.registry import lane_pass
from transport.engine.words import material_of, standing_sheet
from transport.physics.device import device
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
def first_leg_from_births(b, table, first, live):
    """Cast the first leg from a birth: light that is scattered once.

    Fields: reads `x, y, z`, `weight`, `history`, `sheet`, `nx, ny, nz`; writes `sx, sy, sz`, `vx, vy, vz`,
    `point_distance`, `score`, `pdf`, `shadow_sheet`, `tally`.
    """
    px, py, pz, tally = table.x, table.y, table.z, table.first
    isotropic, lambertian = table.isotropic, table.lambertian
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    event = uint64(table.number) << DETECTOR_SHIFT
    for k in range(first, live):
        w0, w1, w2, w3 = event_words(b.history[k], batch, event, AGAIN, seed_low, seed_high)
        vx, vy, vz, leg, inverse = sample_first_leg(b.x[k], b.y[k], b.z[k], px, py, pz, w0, w1, w2, w3)
        cosine = vx * b.nx[k] + vy * b.ny[k] + vz * b.nz[k] if lambertian > 0.0 else 0.0
        b.sx[k], b.sy[k], b.sz[k] = b.x[k], b.y[k], b.z[k]
        b.vx[k], b.vy[k], b.vz[k], b.point_distance[k] = vx, vy, vz, leg
        b.score[k] = b.weight[k] * inverse
        b.pdf[k] = isotropic + lambertian * (cosine if cosine > 0.0 else 0.0)
        b.shadow_sheet[k], b.tally[k] = b.sheet[k], tally
    return live


@lane_pass(layout.POINT_EMISSION)
def first_leg_along_beams(b, table, first, live):
    """Cast the first leg along a beam: a place on its line, sampled equiangularly.

    Fields: reads `x, y, z`, `ux, uy, uz`, `weight`, `history`, `sheet`; writes `sx, sy, sz`, `vx, vy, vz`,
    `point_distance`, `score`, `pdf`, `shadow_sheet`, `tally`.
    """
    px, py, pz, tally = table.x, table.y, table.z, table.first
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    event = uint64(table.number) << DETECTOR_SHIFT
    for k in range(first, live):
        w0, w1, _, _ = event_words(b.history[k], batch, event, AGAIN, seed_low, seed_high)
        ux, uy, uz = b.ux[k], b.uy[k], b.uz[k]
        rx, ry, rz = px - b.x[k], py - b.y[k], pz - b.z[k]
        foot = rx * ux + ry * uy + rz * uz
        qx, qy, qz = rx - foot * ux, ry - foot * uy, rz - foot * uz
        least = math.sqrt(qx * qx + qy * qy + qz * qz)
        leg, inverse = sample_equiangular_beyond(least, -foot, uniform(w0, w1))
        b.sx[k], b.sy[k], b.sz[k] = b.x[k], b.y[k], b.z[k]
        b.vx[k], b.vy[k], b.vz[k], b.point_distance[k] = ux, uy, uz, leg
        b.score[k], b.pdf[k] = b.weight[k] * inverse, 1.0
        b.shadow_sheet[k], b.tally[k] = b.sheet[k], tally
    return live


@lane_pass(layout.ROWS)
def find_phase_at_collisions(b, table, first, live):
    """Set the number of the phase function of the medium that a lane collides in; 0 without a collision.

    Fields: reads `medium`, `collides`; writes `phase_number`.
    """
    rows = view(table.rows, table.count, layout.MEDIA)
    for k in range(first, live):
        b.phase_number[k] = rows[b.medium[k]].phase if b.collides[k] != 0 else 0
    return live


@lane_pass(layout.POINT)
def first_leg_from_collisions(b, table, first, live):
    """Cast the first leg from a collision: light that is scattered once more.

    Fields: reads `x, y, z`, `ux, uy, uz`, `weight`, `history`, `event`, `phase_number`; writes `sx, sy, sz`,
    `vx, vy, vz`, `point_distance`, `score`, `scatter_cosine`, `pdf`, `shadow_sheet`, `tally`.
    """
    px, py, pz, tally = table.x, table.y, table.z, table.first
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    number = uint64(table.number) << DETECTOR_SHIFT
    for k in range(first, live):
        event = uint64(b.event[k]) | number
        w0, w1, w2, w3 = event_words(b.history[k], batch, event, AGAIN, seed_low, seed_high)
        vx, vy, vz, leg, inverse = sample_first_leg(b.x[k], b.y[k], b.z[k], px, py, pz, w0, w1, w2, w3)
        b.sx[k], b.sy[k], b.sz[k] = b.x[k], b.y[k], b.z[k]
        b.vx[k], b.vy[k], b.vz[k], b.point_distance[k] = vx, vy, vz, leg
        b.scatter_cosine[k] = b.ux[k] * vx + b.uy[k] * vy + b.uz[k] * vz
        b.score[k] = b.weight[k] * inverse if b.phase_number[k] != 0 else 0.0
        b.pdf[k], b.shadow_sheet[k], b.tally[k] = 0.0, 0, tally
    return live


@lane_pass(layout.POINT)
def first_leg_from_walls(b, table, first, live):
    """Cast the first leg from a diffuse wall: light that is scattered once.

    Fields: reads `x, y, z`, `weight`, `history`, `event`, `sheet`, `hit`, `nx, ny, nz`, `mu`; writes
    `sx, sy, sz`, `vx, vy, vz`, `point_distance`, `score`, `pdf`, `shadow_sheet`, `tally`.
    """
    px, py, pz, tally = table.x, table.y, table.z, table.first
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    number = uint64(table.number) << DETECTOR_SHIFT
    for k in range(first, live):
        event = uint64(b.event[k]) | number
        w0, w1, w2, w3 = event_words(b.history[k], batch, event, AGAIN, seed_low, seed_high)
        vx, vy, vz, leg, inverse = sample_first_leg(b.x[k], b.y[k], b.z[k], px, py, pz, w0, w1, w2, w3)
        side = 1.0 if b.mu[k] > 0.0 else -1.0
        cosine = side * (vx * b.nx[k] + vy * b.ny[k] + vz * b.nz[k])
        here = material_of(b.hit[k]) == layout.DIFFUSE
        b.sx[k], b.sy[k], b.sz[k] = b.x[k], b.y[k], b.z[k]
        b.vx[k], b.vy[k], b.vz[k], b.point_distance[k] = vx, vy, vz, leg
        b.score[k] = b.weight[k] * inverse if here & (cosine > 0.0) else 0.0
        b.pdf[k], b.shadow_sheet[k], b.tally[k] = INVERSE_PI * cosine, standing_sheet(b.sheet[k]), tally
    return live


@lane_pass(layout.TWO_ROWS)
def turn_into_second_leg(b, table, first, live):
    """Turn a ray towards the point at the end of its first leg, in the medium around the point.

    Fields: reads `weight`, `distance`, `hit`, `medium`, `mfp`, `survival`, `leg`; updates `x, y, z`,
    `ux, uy, uz`; writes `sheet`, `start`, `sx, sy, sz`, `point_distance`, `score`, `scatter_cosine`, `pdf`,
    `phase_number`.
    """
    points = view(table.rows, table.count, layout.POINT)
    media = view(table.others, table.other_count, layout.MEDIA)
    turning = 0
    for k in range(first, live):  # no branch, so no misprediction
        b.phase_number[k] = 0
        b.listed[turning] = k
        turning += 1 if (b.leg[k] != 0) & (b.hit[k] == 0) & (b.weight[k] != 0.0) else 0
    # Direction to the point, scattering angle and coefficient; pdfs of phase functions follow.
    for item in range(turning):
        k = b.listed[item]
        point, medium, length, mfp = points[b.leg[k] - 1], b.medium[k], b.distance[k], b.mfp[k]
        here = medium == point.medium
        x, y, z = b.x[k] + length * b.ux[k], b.y[k] + length * b.uy[k], b.z[k] + length * b.uz[k]
        vx, vy, vz, r = direction_to(x, y, z, point.x, point.y, point.z)
        sigma_s = b.survival[k] / mfp if mfp < math.inf else -1.0
        b.scatter_cosine[k] = b.ux[k] * vx + b.uy[k] * vy + b.uz[k] * vz
        b.phase_number[k] = media[medium].phase if here else 0
        b.score[k] = sigma_s if here else 0.0
        b.pdf[k] = 0.0
        b.x[k], b.y[k], b.z[k], b.ux[k], b.uy[k], b.uz[k] = x, y, z, vx, vy, vz
        b.sx[k], b.sy[k], b.sz[k] = x, y, z
        b.point_distance[k], b.start[k], b.sheet[k] = r, 0.0, 0
    return live


@lane_pass(layout.NO_TABLE)
def start_second_leg(b, table, first, live):
    """Start the second leg with the weight that is scattered into it.

    Fields: reads `hit`, `score`, `pdf`; updates `weight`, `leg`.
    """
    for k in range(first, live):
        turns = (b.leg[k] != 0) & (b.hit[k] == 0)
        score = b.score[k] * b.pdf[k]
        after = b.weight[k] * score if score > 0.0 else 0.0
        b.weight[k] = after if turns else b.weight[k]
        b.leg[k] = 0 if turns else b.leg[k]
    return live
