"""Volume detectors (track-length estimator): path length of each flight in a box or ball.

A flight lasts from `start` to `flight_end`: to the next hit or collision, or to the end of the clock. The
passes `clip_...` find its part in the volume; a volume of one cell is scored here, volumes with cells or
directions are walked through (volume_cells.py). Path lengths are in lengths of the volume, so that a score is
at most 1; absorption along the path is in weights.
"""

import math

from transport.compile import layout
from transport.compile.layout import COLLISION_CLEARANCE
from transport.engine.bodies import lane_pass
from transport.engine.bundle import add_to_row, view
from transport.engine.tally import hash_salt, hashed_uniform, unbiased_limbs
from transport.physics.bits import bits_of
from transport.physics.device import choose, device
from transport.physics.elementary import exp_negative, expm1_negative

SCORE_BOUND = 1 << 28  # contribution to driver.MAX_SCORED, so that the low limbs stay in range as well


@lane_pass(layout.NO_TABLE)
def set_flight_end(lane, table):
    """Set the end of the flight to the next hit; ended lanes have none (-inf)."""
    lane.flight_end = lane.distance if lane.weight != 0.0 else -math.inf


@lane_pass(layout.NO_TABLE)
def set_flight_end_in_media(lane, table):
    """Set the end of the flight, and the absorption coefficients: along the path, and the total one."""
    lane.flight_end = lane.distance if lane.weight != 0.0 else -math.inf
    lane.path_absorption = lane.sigma_a
    lane.total_absorption = lane.sigma_a + (1.0 - lane.survival) / lane.mfp


@lane_pass(layout.CLOCK)
def limit_by_clock(lane, table):
    """Limit the flight to the end of the clock, for one common speed."""
    slowness = table.slowness
    last = lane.start + (1.0 - lane.time) / slowness
    lane.flight_end = choose(last < lane.flight_end, last, lane.flight_end)


@lane_pass(layout.NO_TABLE)
def limit_by_clock_and_speed(lane, table):
    """Limit the flight to the end of the clock, for particles with speeds of their own."""
    last = lane.start + (1.0 - lane.time) * lane.speed
    lane.flight_end = choose(last < lane.flight_end, last, lane.flight_end)


@lane_pass(layout.MEDIA_CLOCK)
def limit_by_clock_in_media(lane, table):
    """Limit the flight to the end of the clock in media, where the refractive index slows light."""
    rows = view(lane.arena + table.rows, table.count, layout.MEDIA)
    slowness, has_speeds = table.slowness, table.has_speeds != 0
    pace = rows[lane.medium].index * slowness
    pace = 1.0 / lane.speed if has_speeds else pace
    last = lane.start + (1.0 - lane.time) / pace
    lane.flight_end = choose(last < lane.flight_end, last, lane.flight_end)


@device
def clip_to_slab(near, far, o, u, half):
    """Return the part of a ray, from near to far, that lies in the slab |x| <= half.

    A ray along a face counts as inside: there 0 times infinity is NaN, which no comparison takes.
    """
    side, inverse = math.copysign(half, u), 1.0 / u
    enters, leaves = (-side - o) * inverse, (side - o) * inverse
    return enters if enters > near else near, leaves if leaves < far else far


@device
def nearest_to_centre(ox, oy, oz, ux, uy, uz):
    """Return how far a point lies past its line's point nearest to the origin, and that one's distance."""
    h = ox * ux + oy * uy + oz * uz
    qx, qy, qz = ox - h * ux, oy - h * uy, oz - h * uz
    return h, math.sqrt(qx * qx + qy * qy + qz * qz)


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
def clip_to_box(lane, table):
    """Find the flight's path length before a box and inside it, by slabs (Kay and Kajiya 1986)."""
    cx, cy, cz, hx, hy, hz = table.cx, table.cy, table.cz, table.hx, table.hy, table.hz
    near, far = clip_to_slab(lane.start, lane.flight_end, lane.x - cx, lane.ux, hx)
    near, far = clip_to_slab(near, far, lane.y - cy, lane.uy, hy)
    near, far = clip_to_slab(near, far, lane.z - cz, lane.uz, hz)
    lane.length_before, lane.length_inside = lengths_of_part(lane.start, near, far)


@lane_pass(layout.VOLUME)
def clip_to_ball(lane, table):
    """Find the flight's path length before a ball and inside it.

    Both follow from the ray's point nearest to the centre.
    """
    cx, cy, cz, radius = table.cx, table.cy, table.cz, table.hx
    ox, oy, oz, ux, uy, uz = lane.x - cx, lane.y - cy, lane.z - cz, lane.ux, lane.uy, lane.uz
    h, q = nearest_to_centre(ox, oy, oz, ux, uy, uz)
    half = half_chord(radius, q)
    start, reach = lane.start + h, lane.flight_end + h
    near = start if start > -half else -half
    far = reach if reach < half else half
    lane.length_before, lane.length_inside = lengths_of_part(start, near, far)


@device
def add_paths(lane, table, high, low, count, bound):
    """Add to the row of the volume detector, and to the bound of the sums of scores."""
    add_to_row(lane.tallies + 32 * table.first, high, low, count, 0)
    lane.scored += high + bound


@lane_pass(layout.VOLUME, sums=add_paths)
def score_path(lane, table):
    """Score weight times path length in a volume of one cell (track-length estimator)."""
    length = lane.length_inside
    chance = hashed_uniform(bits_of(length), hash_salt(lane.seed_low, lane.batch) + lane.history)
    high, low = unbiased_limbs(lane.weight * length * table.scale if length > 0.0 else 0.0, chance)
    # Paths left by rounding alone do not count.
    return high, low, 1 if length > COLLISION_CLEARANCE else 0, SCORE_BOUND


@device
def mean_transmittance(depth):
    """Return the mean of exp(-s) for s from 0 to an optical depth, and exp(-depth) - 1.

    Both keep their digits near 0.
    """
    less = expm1_negative(-depth)
    return -less / depth if depth > 0.0 else 1.0, less


@device
def add_paths_in_media(lane, table, high, low, kept_high, kept_low, count, bound):
    """Add to the rows of the volume detector and of its absorption, and to the bound of the sums."""
    add_to_row(lane.tallies + 32 * table.first, high, low, count, 0)
    add_to_row(lane.tallies + 32 * table.kept, kept_high, kept_low, count, 0)
    lane.scored += high + kept_high + bound


@lane_pass(layout.VOLUME, sums=add_paths_in_media)
def score_path_in_media(lane, table):
    """Score the mean weight along a path times its length where media absorb.

    Score the absorbed weight too.
    """
    length, fade = lane.length_inside, lane.path_absorption
    inside = length > 0.0
    mean, _ = mean_transmittance(fade * length)
    track = lane.weight * exp_negative(-fade * lane.length_before) * mean * length if inside else 0.0
    chance = hashed_uniform(bits_of(length), hash_salt(lane.seed_low, lane.batch) + lane.history)
    high, low = unbiased_limbs(track * table.scale, chance)
    kept_high, kept_low = unbiased_limbs(track * lane.total_absorption if inside else 0.0, chance)
    # Paths left by rounding alone do not count.
    return high, low, kept_high, kept_low, 1 if length > COLLISION_CLEARANCE else 0, SCORE_BOUND
