"""Bodies that contain a particle: tracked by the surfaces crossed.

The medium is that of the innermost body.

A surface holds the set of bodies on each of its sides. A particle that leaves to a side is in that set from
then on, whatever was known before: so an error does not persist.
"""

from numba import float64, uint64

from transport.compile import layout
from transport.compile.layout import EDGE
from transport.engine.bodies import lane_pass
from transport.engine.bundle import view
from transport.engine.tally import add_lost, limbs, to_ledger, to_spare_word
from transport.engine.words import is_covered
from transport.physics.bits import bits_of
from transport.physics.device import choose, device

# [scene lengths] from a face: the tolerance of intersections.bound_rectangle, and clear of it.
AT_EDGE, OFF_EDGE = 2.0**-42, 2.0**-41


@lane_pass(layout.BIRTH_BODIES)
def set_birth_bodies(lane, table):
    """Set the bodies that contain the source."""
    inside = table.inside
    lane.inside = inside


@lane_pass(layout.BIRTH_BOUNDARY)
def leave_birth_body(lane, table):
    """Remove a body if the particle leaves it, at birth on its boundary."""
    nx, ny, nz, bit = table.nx, table.ny, table.nz, table.bit
    leaves = lane.ux * nx + lane.uy * ny + lane.uz * nz > 0.0
    lane.inside = choose(leaves, lane.inside & ~bit, lane.inside)


@lane_pass(layout.LAYERS, sums=to_spare_word(layout.ESCAPED))
def cross_boundary(lane, table):
    """Set the bodies of the side that a lane leaves to, one layer of boundaries at a time.

    Bodies that share a face each have a boundary of their own there. A lane that arrives from bodies other
    than those recorded for its side (through a gap) is counted in the ledger.
    """
    row = view(lane.arena + table.rows, table.count, layout.LAYER)[uint64(lane.hit_sheet)]
    front, back = row.front, row.back
    covered = is_covered(lane.covered, table.layer)
    side, other = (front, back) if lane.mu > 0.0 else (back, front)
    before = lane.inside & (front | back)
    passes = covered & ((lane.covered & EDGE) == 0) & (lane.surface == 0) & (lane.weight != 0.0)
    lane.inside = choose(covered, (lane.inside & ~(front | back)) | side, lane.inside)
    return 1 if passes & (before != other) else 0


@device
def box_side_along(p, half, u, positive):
    """Return for one axis of a box and a ray at p: is it outside, is it at a face, which face (+1 or -1).

    p: position relative to the middle of the box. A ray along a face is inside the one of two boxes that lies
    in direction `positive` of the axis.
    """
    side = 1.0 if p > 0.0 else -1.0
    far = abs(p) - half
    at = abs(far) <= AT_EDGE
    outwards = side * u
    leaves = (outwards > 0.0) | ((outwards == 0.0) & (side * positive > 0.0))
    return (far > AT_EDGE) | (at & leaves), at, side


@device
def is_at_boundary_edge(lane, table):
    """Return whether a lane is within rounding of the edge of a boundary."""
    return ((lane.covered & EDGE) != 0) & (lane.surface == 0)


@lane_pass(layout.BODY_BOX, when=is_at_boundary_edge)
def resolve_box_edges(lane, table):
    """Decide by its direction whether a ray within rounding of a box's edges is inside, and move it clear.

    The ray moves off the faces to the side that it goes to. So no ray through an edge or corner is mistaken
    for one that passes by, and a ray along a face shared by two boxes is inside one of them.
    """
    cx, cy, cz, hx, hy, hz, bit = table.cx, table.cy, table.cz, table.hx, table.hy, table.hz, table.bit
    t = lane.distance
    px, py = lane.rx + t * lane.ux - cx, lane.ry + t * lane.uy - cy
    pz = lane.rz + t * lane.uz - cz
    out_x, at_x, side_x = box_side_along(px, hx, lane.ux, 1.0)
    out_y, at_y, side_y = box_side_along(py, hy, lane.uy, 1.0)
    out_z, at_z, side_z = box_side_along(pz, hz, lane.uz, 1.0)
    touches = (abs(px) <= hx + AT_EDGE) & (abs(py) <= hy + AT_EDGE) & (abs(pz) <= hz + AT_EDGE)
    touches &= (lane.weight != 0.0) & (at_x | at_y | at_z)
    outside = out_x | out_y | out_z
    lane.inside = choose(touches, lane.inside & ~bit if outside else lane.inside | bit, lane.inside)
    # Move off each face that it touches: outwards where it is outside, else inwards.
    ox = cx + side_x * (hx + (OFF_EDGE if out_x else -OFF_EDGE))
    oy = cy + side_y * (hy + (OFF_EDGE if out_y else -OFF_EDGE))
    oz = cz + side_z * (hz + (OFF_EDGE if out_z else -OFF_EDGE))
    here = lane.start != 0.0  # not moved off yet: still at its ray's origin
    lane.x = choose(touches, ox if at_x else cx + px if here else lane.x, lane.x)
    lane.y = choose(touches, oy if at_y else cy + py if here else lane.y, lane.y)
    lane.z = choose(touches, oz if at_z else cz + pz if here else lane.z, lane.z)
    lane.start = choose(touches, 0.0, lane.start)
    lane.sheet = choose(touches, 0, lane.sheet)


@lane_pass(layout.NO_TABLE, sums=to_ledger(layout.ESCAPED))
def escape_to_empty_space(lane, table):
    """End lanes as escaped that leave all bodies to a side without further surfaces."""
    beyond = layout.EMPTY_FRONT if lane.mu > 0.0 else layout.EMPTY_BACK
    escapes = ((lane.covered & beyond) != 0) & (lane.inside == 0)
    high, low = limbs(lane.weight if escapes else 0.0)
    lane.weight = choose(escapes, 0.0, lane.weight)
    return high, low


@device
def innermost(inside):
    """Return 1 + number of the lowest set bit; 0 if there is none."""
    lowest = inside & -inside
    return (bits_of(float64(lowest)) >> 52) - 1022 if lowest != 0 else 0


@device
def ends_beyond(x, y, z, ux, uy, uz, length, low_x, low_y, low_z, high_x, high_y, high_z):
    """Return whether a flight of this length ends outside a box (true for an infinite flight)."""
    x, y, z = x + length * ux, y + length * uy, z + length * uz
    return not ((x >= low_x) & (x <= high_x) & (y >= low_y) & (y <= high_y) & (z >= low_z) & (z <= high_z))


@device
def end_as_lost(lane):
    """End a particle as lost."""
    add_lost(lane, lane.weight)
    lane.weight, lane.distance = 0.0, 0.0


@device
def is_stray(lane, table):
    """Return whether a lane in a finite body has no surface ahead, or a collision beyond the body."""
    strays = ends_beyond(
        lane.x, lane.y, lane.z, lane.ux, lane.uy, lane.uz, lane.distance,
        table.low_x, table.low_y, table.low_z, table.high_x, table.high_y, table.high_z,
    )  # fmt: skip
    strays &= (lane.inside & table.bit) != 0
    return strays & (lane.hit == 0) & (lane.weight != 0.0)


@lane_pass(layout.BODY_BOUNDS, when=is_stray)
def end_lost_particles(lane, table):
    """End lanes in a finite body without a surface ahead, or with a collision beyond the body, as lost.

    So no ray that rounding carried past a rim flies on as if the body were infinite.
    """
    end_as_lost(lane)


@device
def is_stray_of_many(lane, table):
    """Return the same for many finite bodies; gathers a row."""
    row = view(lane.arena + table.rows, table.count, layout.BODY_BOUNDS)[uint64(innermost(lane.inside))]
    strays = ends_beyond(
        lane.x, lane.y, lane.z, lane.ux, lane.uy, lane.uz, lane.distance,
        row.low_x, row.low_y, row.low_z, row.high_x, row.high_y, row.high_z,
    )  # fmt: skip
    return strays & (row.bit != 0) & (lane.hit == 0) & (lane.weight != 0.0)


@lane_pass(layout.ROWS, when=is_stray_of_many)
def end_lost_particles_of_many(lane, table):
    """End lost particles as `end_lost_particles` does, for many finite bodies."""
    end_as_lost(lane)


@lane_pass(layout.BODY)
def set_outer_medium(lane, table):
    """Set the medium outside all bodies, and its coefficients."""
    medium, mfp, sigma_a, survival = table.medium, table.mfp, table.sigma_a, table.survival
    lane.medium, lane.mfp, lane.sigma_a, lane.survival = medium, mfp, sigma_a, survival


@lane_pass(layout.BODY)
def find_medium(lane, table):
    """Set the medium of one body for the lanes in it; passes run from the outermost to the innermost body."""
    bit, medium, mfp, sigma_a, survival = table.bit, table.medium, table.mfp, table.sigma_a, table.survival
    here = (lane.inside & bit) != 0
    lane.medium = choose(here, medium, lane.medium)
    lane.mfp = choose(here, mfp, lane.mfp)
    lane.sigma_a = choose(here, sigma_a, lane.sigma_a)
    lane.survival = choose(here, survival, lane.survival)


@lane_pass(layout.ROWS)
def find_medium_of_many(lane, table):
    """Find the medium as `find_medium` does, for many bodies: gathers the row of the innermost one."""
    rows = view(lane.arena + table.rows, table.count, layout.MEDIA)
    medium = innermost(lane.inside)
    row = rows[uint64(medium)]
    lane.medium, lane.mfp, lane.sigma_a, lane.survival = medium, row.mfp, row.sigma_a, row.survival
