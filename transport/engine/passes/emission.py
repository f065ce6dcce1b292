"""Births: position and direction; their time and speed are in velocities.py.

Loops run over the new lanes [first, live) only.
"""

import math

from numba import int64

from transport.compile import layout
from transport.compile.layout import TAKEN
from transport.engine.bodies import lane_pass
from transport.engine.passes.flats import distance_from_hole, on_holed, on_triangle
from transport.engine.passes.intersections import on_disk, on_rectangle
from transport.engine.tally import limbs, to_row_of_table
from transport.engine.words import birth_block, words_of_block
from transport.physics.bits import float_of
from transport.physics.device import choose, device
from transport.physics.directions import from_frame, sample_cosine_law, sample_isotropic
from transport.physics.elementary import cos_sin_turn
from transport.physics.positions import place_in_frame, sample_disk, sample_rectangle, sample_triangle
from transport.physics.streams import DEPTH, DIRECTION, POSITION, random_words, uniform
from transport.physics.velocities import sample_normal_pair


@lane_pass(layout.BIRTH)
def start_history(lane, table):
    """Start a new history: number, birth weight, ray parameter and sheet.

    The birth weight is that of the table times the factor dealt to the emitter (driver._deal_histories).
    """
    lane.history = lane.next_history + int64(lane.number)
    lane.weight = table.weight * float_of(lane.birth_factor)
    lane.sheet, lane.start = table.sheet, table.start


@lane_pass(layout.NO_TABLE)
def reset_events(lane, table):
    """Set the event counter, which numbers the random blocks, to 0."""
    lane.event = 0


@lane_pass(layout.MEDIUM)
def set_birth_index(lane, table):
    """Set the refractive index to that of the source's medium."""
    index = table.index
    lane.index = index


@lane_pass(layout.NO_TABLE)
def reset_visits(lane, table):
    """Clear the bit set of visited objects."""
    lane.visited = 0


@lane_pass(layout.NO_TABLE)
def reset_reflections(lane, table):
    """Set the count of reflections to 0."""
    lane.reflections = 0


@lane_pass(layout.NO_TABLE)
def save_birth_weight(lane, table):
    """Keep the birth weight as the reference of Russian roulette."""
    lane.birth = lane.weight


@device
def words_at_birth(lane, purpose):
    """Return the random words of a birth for one purpose."""
    return random_words(lane.history, lane.batch, 0, purpose, lane.seed_low, lane.seed_high)


@lane_pass(layout.PATCH, before=birth_block(POSITION))
def born_on_rectangle(lane, table):
    """Sample a point uniformly on a rectangle."""
    w0, w1, w2, w3 = words_of_block(lane)
    u, v = sample_rectangle(table.half_u, table.half_v, uniform(w0, w1), uniform(w2, w3))
    lane.x, lane.y, lane.z = place_in_frame(table, u, v)


@lane_pass(layout.PATCH, before=birth_block(POSITION))
def born_on_disk(lane, table):
    """Sample a point uniformly on a disk or annulus."""
    w0, w1, w2, w3 = words_of_block(lane)
    u, v = sample_disk(table.inner2, table.outer2, uniform(w0, w1), uniform(w2, w3))
    lane.x, lane.y, lane.z = place_in_frame(table, u, v)


@lane_pass(layout.PATCH, before=birth_block(POSITION))
def born_on_triangle(lane, table):
    """Sample a point uniformly on a triangle with corner c and edges e_u, e_v."""
    w0, w1, w2, w3 = words_of_block(lane)
    u, v = sample_triangle(uniform(w0, w1), uniform(w2, w3))
    lane.x, lane.y, lane.z = place_in_frame(table, u, v)


@lane_pass(layout.HOLED)
def born_beside_hole(lane, table):
    """Sample a point uniformly on a rectangle with a hole, by rejection of points in the hole."""
    seed_low, seed_high, batch = lane.seed_low, lane.seed_high, lane.batch
    u, v, draws, beyond = 0.0, 0.0, 0, -1.0
    # Reject points in the hole.
    while beyond < 0.0:
        w0, w1, w2, w3 = random_words(lane.history, batch, draws, POSITION, seed_low, seed_high)
        u, v = sample_rectangle(table.half_u, table.half_v, uniform(w0, w1), uniform(w2, w3))
        beyond = distance_from_hole(table, u, v)
        draws += 1
    lane.x = table.cx + u * table.eux + v * table.evx
    lane.y = table.cy + u * table.euy + v * table.evy
    lane.z = table.cz + u * table.euz + v * table.evz


@lane_pass(layout.PATCH, before=birth_block(POSITION))
def born_on_sphere(lane, table):
    """Sample a point uniformly on a sphere, with its normal on the emitting side."""
    cx, cy, cz, radius, side = table.cx, table.cy, table.cz, table.half_u, table.side
    w0, w1, w2, w3 = words_of_block(lane)
    nx, ny, nz = sample_isotropic(uniform(w0, w1), uniform(w2, w3))
    lane.x, lane.y, lane.z = cx + radius * nx, cy + radius * ny, cz + radius * nz
    lane.nx, lane.ny, lane.nz = side * nx, side * ny, side * nz


@lane_pass(layout.PATCH, before=birth_block(POSITION))
def born_on_sphere_cross_section(lane, table):
    """Sample a point on a sphere, uniformly over its cross section, for a parallel beam.

    The beam goes along (nx, ny, nz) of the table.
    """
    cx, cy, cz, radius, side = table.cx, table.cy, table.cz, table.half_u, table.side
    ux, uy, uz = table.nx, table.ny, table.nz
    w0, w1, w2, w3 = words_of_block(lane)
    nx, ny, nz, _ = sample_cosine_law(ux, uy, uz, uniform(w0, w1), uniform(w2, w3))
    r = side * radius
    lane.x, lane.y, lane.z = cx + r * nx, cy + r * ny, cz + r * nz


@lane_pass(layout.PATCH)
def set_emission_normal(lane, table):
    """Set the normal of the emitting side, by which an aim weights directions; 0 for isotropic emission."""
    nx, ny, nz = table.side * table.nx, table.side * table.ny, table.side * table.nz
    lane.nx, lane.ny, lane.nz = nx, ny, nz


@lane_pass(layout.PATCH)
def born_at_point(lane, table):
    """Set the position to one point."""
    cx, cy, cz = table.cx, table.cy, table.cz
    lane.x, lane.y, lane.z = cx, cy, cz


@lane_pass(layout.PATCH)
def born_in_box(lane, table):
    """Sample a point uniformly in a box."""
    cx, cy, cz = table.cx, table.cy, table.cz
    half_u, half_v, half_w = table.half_u, table.half_v, table.half_w
    w0, w1, w2, w3 = words_at_birth(lane, POSITION)
    d0, d1, _, _ = words_at_birth(lane, DEPTH)
    lane.x = cx + (2.0 * uniform(w0, w1) - 1.0) * half_u
    lane.y = cy + (2.0 * uniform(w2, w3) - 1.0) * half_v
    lane.z = cz + (2.0 * uniform(d0, d1) - 1.0) * half_w


@lane_pass(layout.PATCH)
def born_in_sphere(lane, table):
    """Sample a point uniformly in a ball.

    The radius is the largest of three uniforms, which has the law of the cube root of one.
    """
    cx, cy, cz, radius = table.cx, table.cy, table.cz, table.half_u
    w0, w1, w2, w3 = words_at_birth(lane, POSITION)
    d0, d1, d2, d3 = words_at_birth(lane, DEPTH)
    e0, e1, _, _ = random_words(lane.history, lane.batch, 1, DEPTH, lane.seed_low, lane.seed_high)
    ux, uy, uz = sample_isotropic(uniform(w0, w1), uniform(w2, w3))
    r = radius * max(max(uniform(d0, d1), uniform(d2, d3)), uniform(e0, e1))
    lane.x, lane.y, lane.z = cx + r * ux, cy + r * uy, cz + r * uz


@lane_pass(layout.PATCH)
def born_in_cloud(lane, table):
    """Sample a point of a normal distribution with a standard deviation per coordinate."""
    cx, cy, cz = table.cx, table.cy, table.cz
    half_u, half_v, half_w = table.half_u, table.half_v, table.half_w
    w0, w1, w2, w3 = words_at_birth(lane, POSITION)
    d0, d1, d2, d3 = words_at_birth(lane, DEPTH)
    p, q = sample_normal_pair(uniform(w0, w1), uniform(w2, w3))
    r, _ = sample_normal_pair(uniform(d0, d1), uniform(d2, d3))
    lane.x, lane.y, lane.z = cx + half_u * p, cy + half_v * q, cz + half_w * r


@lane_pass(layout.NO_TABLE, before=birth_block(DIRECTION))
def emit_lambertian(lane, table):
    """Sample a direction by the cosine law about the normal of the emitting side."""
    w0, w1, w2, w3 = words_of_block(lane)
    ux, uy, uz, _ = sample_cosine_law(lane.nx, lane.ny, lane.nz, uniform(w0, w1), uniform(w2, w3))
    lane.ux, lane.uy, lane.uz = ux, uy, uz


@lane_pass(layout.PATCH, before=birth_block(DIRECTION))
def emit_lambertian_from_plane(lane, table):
    """Sample a direction by the cosine law about one normal for all lanes, in a frame computed once."""
    side = table.side
    eux, euy, euz, evx, evy, evz = table.eux, table.euy, table.euz, table.evx, table.evy, table.evz
    nx, ny, nz = side * table.nx, side * table.ny, side * table.nz
    w0, w1, w2, w3 = words_of_block(lane)
    u = uniform(w0, w1)
    c, s = cos_sin_turn(uniform(w2, w3))
    mu, sine = math.sqrt(1.0 - u), math.sqrt(u)
    c, s = c * sine, s * sine
    lane.ux, lane.uy, lane.uz = from_frame(c, s, mu, eux, euy, euz, evx, evy, evz, nx, ny, nz)


@lane_pass(layout.NO_TABLE, before=birth_block(DIRECTION))
def emit_isotropic(lane, table):
    """Sample a direction uniformly over the sphere."""
    w0, w1, w2, w3 = words_of_block(lane)
    lane.ux, lane.uy, lane.uz = sample_isotropic(uniform(w0, w1), uniform(w2, w3))


@lane_pass(layout.BEAM)
def emit_beam(lane, table):
    """Set one direction for all."""
    ux, uy, uz = table.ux, table.uy, table.uz
    lane.ux, lane.uy, lane.uz = ux, uy, uz


# ---- Score births on a sheet with detectors: a newborn particle counts there as a departure.
#
# Only for emitters whose sheet carries a detector. The x of an aimed particle is its target, so it moves to
# its birthplace for these steps.


@lane_pass(layout.BIRTH)
def hit_birth_sheet(lane, table):
    """Set the hit to the sheet of birth, without detectors yet."""
    lane.hit, lane.covered = table.sheet, 0


@lane_pass(layout.NO_TABLE)
def move_to_birthplace(lane, table):
    """Move an aimed particle from its target back along the ray to its birthplace.

    The target is kept in u0 to u2.
    """
    lane.u0, lane.u1, lane.u2 = lane.x, lane.y, lane.z
    lane.x += lane.start * lane.ux
    lane.y += lane.start * lane.uy
    lane.z += lane.start * lane.uz


@lane_pass(layout.NO_TABLE)
def move_to_target(lane, table):
    """Restore the target as the position, to its full precision."""
    lane.x, lane.y, lane.z = lane.u0, lane.u1, lane.u2


@device
def add_covers(lane, covers, is_inside):
    """Add bits to the hit of a birth within a shape; of shapes that act (bit TAKEN), of the first one."""
    is_free = (lane.covered & covers & TAKEN) == 0
    lane.covered |= covers if is_inside & is_free else 0


@device
def from_center(lane, table):
    """Return the place of a lane relative to a shape's center."""
    return lane.x - table.cx, lane.y - table.cy, lane.z - table.cz


@lane_pass(layout.RECTANGLE)
def born_over_rectangle(lane, table):
    """Add the detectors of this rectangle to the hit of births within it."""
    px, py, pz = from_center(lane, table)
    is_inside, _ = on_rectangle(table, px, py, pz, 0.0, False)
    add_covers(lane, table.covers, is_inside)


@lane_pass(layout.DISK)
def born_over_disk(lane, table):
    """Add the detectors of this disk to the hit of births within it."""
    px, py, pz = from_center(lane, table)
    is_inside, _ = on_disk(table, px, py, pz, 0.0, False)
    add_covers(lane, table.covers, is_inside)


@lane_pass(layout.TRIANGLE)
def born_over_triangle(lane, table):
    """Add the detectors of this triangle to the hit of births within it."""
    px, py, pz = from_center(lane, table)
    is_inside, _ = on_triangle(table, px, py, pz, 0.0)
    add_covers(lane, table.covers, is_inside)


@lane_pass(layout.HOLED)
def born_over_holed(lane, table):
    """Add the detectors of this rectangle with a hole to the hit of births within it."""
    px, py, pz = from_center(lane, table)
    is_inside, _ = on_holed(table, px, py, pz, 0.0, False)
    add_covers(lane, table.covers, is_inside)


@lane_pass(layout.QUADRIC)
def born_over_quadric(lane, table):
    """Add the detectors of this surface of revolution to the hit of births between its heights."""
    w = (lane.x - table.cx) * table.ax + (lane.y - table.cy) * table.ay + (lane.z - table.cz) * table.az
    add_covers(lane, table.covers, (w >= table.low) & (w <= table.high))


@lane_pass(layout.BITS)
def born_all_over(lane, table):
    """Add the detectors of the emitter's own shape to the hit of all births, despite rounding at its rim."""
    add_covers(lane, table.bits, True)


@lane_pass(layout.LEDGER_ROW, sums=to_row_of_table)
def absorb_covered_births(lane, table):
    """End births beneath another surface, which absorbs them: those with a bit of `covered`."""
    high, low = limbs(choose(lane.covered != 0, lane.weight, 0.0))
    lane.weight = choose(lane.covered != 0, 0.0, lane.weight)
    return high, low
