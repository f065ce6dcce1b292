"""Volume detectors (track-length estimator): path length of each flight in a box or ball.

A flight lasts from `start` to `reach`: to the next hit or collision, or to the end of the clock. `clip_...`
finds its part in the volume; a volume of one cell is scored here, volumes with cells or directions are walked
through (volume_cells.py). Path lengths are in lengths of the volume, so that a score is at most 1; absorption
along the path is in weights.
"""

import math

from numba import int64

from transport.compile import layout
from transport.compile.layout import COLLISION_CLEARANCE
from transport.engine.bundle import add_to_row, view
from transport.engine.registry import lane_pass
from transport.engine.tally import hash_salt, hashed_uniform, unbiased_limbs
from transport.physics.bits import bits_of
from transport.physics.device import device
from transport.physics.elementary import exp_negative, expm1_negative

SCORE_BOUND = 1 << 28  # contribution to driver.MAX_SCORED, so that the low limbs stay in range as well


@lane_pass(layout.NO_TABLE)
def set_flight_end(b, table, first, live):
    """Set the end of the flight to the next hit; ended lanes have none (-inf).

    Fields: reads `weight`, `distance`; writes `flight_end`.
    """
    for k in range(first, live):
        b.flight_end[k] = b.distance[k] if b.weight[k] != 0.0 else -math.inf
    return live


@lane_pass(layout.NO_TABLE)
def set_flight_end_in_media(b, table, first, live):
    """Set the end of the flight in media, for lanes that fly.

    Set the absorption coefficient along the path too, and the total one.

    Fields: reads `weight`, `distance`, `mfp`, `sigma_a`, `survival`, `flies`; writes `flight_end`,
    `path_absorption`, `total_absorption`.
    """
    for k in range(first, live):
        flies = (b.flies[k] != 0) & (b.weight[k] != 0.0)
        b.flight_end[k] = b.distance[k] if flies else -math.inf
        b.path_absorption[k] = b.sigma_a[k]
        b.total_absorption[k] = b.sigma_a[k] + (1.0 - b.survival[k]) / b.mfp[k]
    return live


@lane_pass(layout.CLOCK)
def limit_by_clock(b, table, first, live):
    """Limit the flight to the end of the clock, for one common speed.

    Fields: reads `start`, `time`; updates `flight_end`.
    """
    slowness = table.slowness
    for k in range(first, live):
        last = b.start[k] + (1.0 - b.time[k]) / slowness
        b.flight_end[k] = last if last < b.flight_end[k] else b.flight_end[k]
    return live


@lane_pass(layout.NO_TABLE)
def limit_by_clock_and_speed(b, table, first, live):
    """Limit the flight to the end of the clock, for particles with speeds of their own.

    Fields: reads `start`, `time`, `speed`; updates `flight_end`.
    """
    for k in range(first, live):
        last = b.start[k] + (1.0 - b.time[k]) * b.speed[k]
        b.flight_end[k] = last if last < b.flight_end[k] else b.flight_end[k]
    return live


@lane_pass(layout.MEDIA_CLOCK)
def limit_by_clock_in_media(b, table, first, live):
    """Limit the flight to the end of the clock in media, where the refractive index slows light.

    Fields: reads `start`, `time`, `speed`, `medium`; updates `flight_end`.
    """
    rows = view(table.rows, table.count, layout.MEDIA)
    slowness, has_speeds = table.slowness, table.has_speeds != 0
    for k in range(first, live):
        pace = rows[b.medium[k]].index * slowness
        pace = 1.0 / b.speed[k] if has_speeds else pace
        last = b.start[k] + (1.0 - b.time[k]) / pace
        b.flight_end[k] = last if last < b.flight_end[k] else b.flight_end[k]
    return live


@device
def slab_crossings(o, u, half):
    """Return where a ray enters and leaves the slab |x| <= half.

    A ray along a face or parallel to it counts as inside.
    """
    side, inverse = math.copysign(half, u), 1.0 / u
    near, far = (-side - o) * inverse, (side - o) * inverse
    return near if near == near else -math.inf, far if far == far else math.inf


@device
def half_chord(radius, q):
    """Return half the chord of a sphere at distance q from its centre."""
    d = (radius - q) * (radius + q)
    return math.sqrt(d if d > 0.0 else 0.0)


@device
def lengths_of_part(start, near, far):
    """Return the path length before and in the part of a flight from near to far; 0 if it is empty."""
    inside = near < far
    return near - start if inside else 0.0, far - near if inside else 0.0


@lane_pass(layout.VOLUME)
def clip_to_box(b, table, first, live):
    """Find the flight's path length before a box and inside it, by slabs (Kay and Kajiya 1986).

    Fields: reads `x, y, z`, `ux, uy, uz`, `start`, `flight_end`; writes `length_before`, `length_inside`.
    """
    cx, cy, cz, hx, hy, hz = table.cx, table.cy, table.cz, table.hx, table.hy, table.hz
    for k in range(first, live):
        near_x, far_x = slab_crossings(b.x[k] - cx, b.ux[k], hx)
        near_y, far_y = slab_crossings(b.y[k] - cy, b.uy[k], hy)
        near_z, far_z = slab_crossings(b.z[k] - cz, b.uz[k], hz)
        start, near, far = b.start[k], b.start[k], b.flight_end[k]
        near = near_x if near_x > near else near
        near = near_y if near_y > near else near
        near = near_z if near_z > near else near
        far = far_x if far_x < far else far
        far = far_y if far_y < far else far
        far = far_z if far_z < far else far
        b.length_before[k], b.length_inside[k] = lengths_of_part(start, near, far)
    return live


@lane_pass(layout.VOLUME)
def clip_to_ball(b, table, first, live):
    """Find the flight's path length before a ball and inside it, from the ray's point nearest to the centre.

    Fields: reads `x, y, z`, `ux, uy, uz`, `start`, `flight_end`; writes `length_before`, `length_inside`.
    """
    cx, cy, cz, radius = table.cx, table.cy, table.cz, table.hx
    for k in range(first, live):
        ox, oy, oz, ux, uy, uz = b.x[k] - cx, b.y[k] - cy, b.z[k] - cz, b.ux[k], b.uy[k], b.uz[k]
        h = ox * ux + oy * uy + oz * uz
        qx, qy, qz = ox - h * ux, oy - h * uy, oz - h * uz
        q = math.sqrt(qx * qx + qy * qy + qz * qz)
        half = half_chord(radius, q)
        start, reach = b.start[k] + h, b.flight_end[k] + h
        near = start if start > -half else -half
        far = reach if reach < half else half
        b.length_before[k], b.length_inside[k] = lengths_of_part(start, near, far)
    return live


@lane_pass(layout.VOLUME)
def score_path(b, table, first, live):
    """Score weight times path length in a volume of one cell (track-length estimator).

    Fields: reads `weight`, `history`, `length_inside`; updates `scored`.
    """
    total_high, total_low, count, scale, salt = 0, 0, 0, table.scale, hash_salt(b.seed_low, b.batch)
    for k in range(first, live):
        length = b.length_inside[k]
        inside = length > 0.0
        chance = hashed_uniform(bits_of(length), salt + b.history[k])
        high, low = unbiased_limbs(b.weight[k] * length * scale if inside else 0.0, chance)
        total_high += high
        total_low += low
        count += 1 if length > COLLISION_CLEARANCE else 0  # paths left by rounding alone do not count
    add_to_row(b.tallies + 32 * table.first, total_high, total_low, count, 0)
    b.scored += total_high + SCORE_BOUND * int64(live - first)
    return live


@device
def mean_transmittance(depth):
    """Return the mean of exp(-s) for s from 0 to an optical depth, and exp(-depth) - 1.

    Both keep their digits near 0.
    """
    less = expm1_negative(-depth)
    return -less / depth if depth > 0.0 else 1.0, less


@lane_pass(layout.VOLUME)
def score_path_in_media(b, table, first, live):
    """Score the mean weight along a path times its length where media absorb; score the absorbed weight too.

    Fields: reads `weight`, `history`, `length_before`, `length_inside`, `path_absorption`,
    `total_absorption`; updates `scored`.
    """
    total_high, total_low, kept_high, kept_low, count, scale = 0, 0, 0, 0, 0, table.scale
    salt = hash_salt(b.seed_low, b.batch)
    for k in range(first, live):
        length, fade = b.length_inside[k], b.path_absorption[k]
        inside = length > 0.0
        mean, _ = mean_transmittance(fade * length)
        track = b.weight[k] * exp_negative(-fade * b.length_before[k]) * mean * length if inside else 0.0
        chance = hashed_uniform(bits_of(length), salt + b.history[k])
        high, low = unbiased_limbs(track * scale, chance)
        total_high += high
        total_low += low
        high, low = unbiased_limbs(track * b.total_absorption[k] if inside else 0.0, chance)
        kept_high += high
        kept_low += low
        count += 1 if length > COLLISION_CLEARANCE else 0  # paths left by rounding alone do not count
    add_to_row(b.tallies + 32 * table.first, total_high, total_low, count, 0)
    add_to_row(b.tallies + 32 * table.kept, kept_high, kept_low, count, 0)
    b.scored += total_high + kept_high + SCORE_BOUND * int64(live - first)
    return live
