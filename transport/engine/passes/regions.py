"""Bodies that contain a particle: tracked by the surfaces crossed.

The medium is that of the innermost body.

A surface holds the set of bodies on each of its sides. A particle that leaves to a side is in that set from
then on, whatever was known before: so an error does not persist.
"""

import numpy as np
from numba import float64, uint64

from transport.compile import layout
from transport.compile.layout import EDGE
from transport.engine.bundle import view
from transport.engine.passes.surfaces import ACTING_BITS
from transport.engine.registry import lane_pass
from transport.engine.tally import add_lost, add_to_ledger, limbs
from transport.engine.words import sheet_of
from transport.physics.bits import bits_of
from transport.physics.device import device

# [scene lengths] from a face: the tolerance of intersections.bound_rectangle, and clear of it.
AT_EDGE, OFF_EDGE = 2.0**-42, 2.0**-41
MARKED_LOST = 2  # value of `flies` that marks a lost lane


@lane_pass(layout.BIRTH_BODIES)
def set_birth_bodies(b, table, first, live):
    """Set the bodies that contain the source.

    Fields: writes `inside`.
    """
    inside = table.inside
    for k in range(first, live):
        b.inside[k] = inside
    return live


@lane_pass(layout.BIRTH_BOUNDARY)
def leave_birth_body(b, table, first, live):
    """Remove a body if the particle leaves it, at birth on its boundary.

    Fields: reads `ux, uy, uz`; updates `inside`.
    """
    nx, ny, nz, bit = table.nx, table.ny, table.nz, table.bit
    for k in range(first, live):
        leaves = b.ux[k] * nx + b.uy[k] * ny + b.uz[k] * nz > 0.0
        b.inside[k] = b.inside[k] & ~bit if leaves else b.inside[k]
    return live


@lane_pass(layout.LAYERS)
def cross_boundary(b, table, first, live):
    """Set the bodies of the side that a lane leaves to, one layer of boundaries at a time.

    Bodies that share a face each have a boundary of their own there. A lane that arrives from bodies other
    than those recorded for its side (through a gap) is counted in the ledger.

    Fields: reads `weight`, `hit`, `mu`; updates `inside`.
    """
    rows, layer, unseen = view(table.rows, table.count, layout.LAYER), table.layer, 0
    for k in range(first, live):
        row = rows[uint64(sheet_of(b.hit[k]))]
        front, back = row.front, row.back
        covered = ((b.hit[k] >> layer) & 1) != 0
        side, other = (front, back) if b.mu[k] > 0.0 else (back, front)
        before = b.inside[k] & (front | back)
        passes = covered & ((b.hit[k] & (EDGE | ACTING_BITS)) == 0) & (b.weight[k] != 0.0)
        unseen += 1 if passes & (before != other) else 0
        b.inside[k] = (b.inside[k] & ~(front | back)) | side if covered else b.inside[k]
    view(b.ledger, b.ledger_words, np.int64)[4 * layout.ESCAPED + 3] += unseen
    return live


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


@lane_pass(layout.BODY_BOX)
def resolve_box_edges(b, table, first, live):
    """Decide by its direction whether a ray within rounding of a box's edges is inside, and move it clear.

    The ray moves off the faces to the side that it goes to. So no ray through an edge or corner is mistaken
    for one that passes by, and a ray along a face shared by two boxes is inside one of them. Does nothing if
    no lane is at an edge, the usual case.

    Fields: reads `ux, uy, uz`, `weight`, `distance`, `hit`, `rx, ry, rz`; updates `x, y, z`, `sheet`,
    `start`, `inside`.
    """
    any_edge = 0
    for k in range(first, live):
        any_edge |= 1 if (b.hit[k] & (EDGE | ACTING_BITS)) == EDGE else 0
    if any_edge == 0:
        return live
    cx, cy, cz, hx, hy, hz, bit = table.cx, table.cy, table.cz, table.hx, table.hy, table.hz, table.bit
    for k in range(first, live):
        t = b.distance[k]
        px, py = b.rx[k] + t * b.ux[k] - cx, b.ry[k] + t * b.uy[k] - cy
        pz = b.rz[k] + t * b.uz[k] - cz
        out_x, at_x, side_x = box_side_along(px, hx, b.ux[k], 1.0)
        out_y, at_y, side_y = box_side_along(py, hy, b.uy[k], 1.0)
        out_z, at_z, side_z = box_side_along(pz, hz, b.uz[k], 1.0)
        edge = ((b.hit[k] & (EDGE | ACTING_BITS)) == EDGE) & (b.weight[k] != 0.0)
        touches = (abs(px) <= hx + AT_EDGE) & (abs(py) <= hy + AT_EDGE) & (abs(pz) <= hz + AT_EDGE)
        touches &= edge & (at_x | at_y | at_z)
        outside = out_x | out_y | out_z
        b.inside[k] = (b.inside[k] & ~bit if outside else b.inside[k] | bit) if touches else b.inside[k]
        # Move off each face that it touches: outwards where it is outside, else inwards.
        ox = cx + side_x * (hx + (OFF_EDGE if out_x else -OFF_EDGE))
        oy = cy + side_y * (hy + (OFF_EDGE if out_y else -OFF_EDGE))
        oz = cz + side_z * (hz + (OFF_EDGE if out_z else -OFF_EDGE))
        here = b.start[k] != 0.0  # not moved off yet: still at its ray's origin
        b.x[k] = (ox if at_x else cx + px if here else b.x[k]) if touches else b.x[k]
        b.y[k] = (oy if at_y else cy + py if here else b.y[k]) if touches else b.y[k]
        b.z[k] = (oz if at_z else cz + pz if here else b.z[k]) if touches else b.z[k]
        b.start[k] = 0.0 if touches else b.start[k]
        b.sheet[k] = 0 if touches else b.sheet[k]
    return live


@lane_pass(layout.NO_TABLE)
def escape_to_empty_space(b, table, first, live):
    """End lanes as escaped that leave all bodies to a side without further surfaces.

    Fields: reads `hit`, `inside`, `mu`; updates `weight`.
    """
    high, low = 0, 0
    for k in range(first, live):
        beyond = layout.EMPTY_FRONT if b.mu[k] > 0.0 else layout.EMPTY_BACK
        escapes = ((b.hit[k] & beyond) != 0) & (b.inside[k] == 0)
        w_high, w_low = limbs(b.weight[k] if escapes else 0.0)
        high += w_high
        low += w_low
        b.weight[k] = 0.0 if escapes else b.weight[k]
    add_to_ledger(b, layout.ESCAPED, high, low)
    return live


@device
def innermost(inside):
    """Return 1 + number of the lowest set bit; 0 if there is none."""
    lowest = inside & -inside
    return (bits_of(float64(lowest)) >> 52) - 1022 if lowest != 0 else 0


@device
def ends_beyond(x, y, z, ux, uy, uz, length, low_x, low_y, low_z, high_x, high_y, high_z):
    """Return whether a flight of length `way` ends outside a box (true for an infinite flight)."""
    x, y, z = x + length * ux, y + length * uy, z + length * uz
    return not ((x >= low_x) & (x <= high_x) & (y >= low_y) & (y <= high_y) & (z >= low_z) & (z <= high_z))


@device
def end_marked(b, first, live):
    """End lanes marked as strays, as lost.

    Fields: updates `weight`, `flies`; writes `distance`.
    """
    for k in range(first, live):
        if b.flies[k] == MARKED_LOST:
            add_lost(b, b.weight[k])
            b.weight[k], b.distance[k], b.flies[k] = 0.0, 0.0, 0


@lane_pass(layout.BODY_BOUNDS)
def end_lost_particles(b, table, first, live):
    """End lanes in a finite body without a surface ahead, or with a collision beyond the body, as lost.

    So no ray that rounding carried past a rim flies on as if the body were infinite.

    Fields: reads `x, y, z`, `ux, uy, uz`, `hit`, `inside`; updates `weight`, `distance`, `flies`.
    """
    low_x, low_y, low_z = table.low_x, table.low_y, table.low_z
    high_x, high_y, high_z, bit = table.high_x, table.high_y, table.high_z, table.bit
    strays = 0
    for k in range(first, live):
        x, y, z, ux, uy, uz, length = b.x[k], b.y[k], b.z[k], b.ux[k], b.uy[k], b.uz[k], b.distance[k]
        is_stray = ends_beyond(x, y, z, ux, uy, uz, length, low_x, low_y, low_z, high_x, high_y, high_z)
        is_stray &= (b.inside[k] & bit) != 0
        is_stray &= (b.hit[k] == 0) & (b.flies[k] != 0) & (b.weight[k] != 0.0)
        b.flies[k] = MARKED_LOST if is_stray else b.flies[k]
        strays += 1 if is_stray else 0
    if strays != 0:
        end_marked(b, first, live)
    return live


@lane_pass(layout.ROWS)
def end_lost_particles_of_many(b, table, first, live):
    """End lost particles as `end_lost_particles` does, for many finite bodies; gathers a row.

    Fields: reads `x, y, z`, `ux, uy, uz`, `hit`, `inside`; updates `weight`, `distance`, `flies`.
    """
    rows, strays = view(table.rows, table.count, layout.BODY_BOUNDS), 0
    for k in range(first, live):
        row = rows[uint64(innermost(b.inside[k]))]
        low_x, low_y, low_z = row.low_x, row.low_y, row.low_z
        high_x, high_y, high_z = row.high_x, row.high_y, row.high_z
        x, y, z, ux, uy, uz, length = b.x[k], b.y[k], b.z[k], b.ux[k], b.uy[k], b.uz[k], b.distance[k]
        is_stray = ends_beyond(x, y, z, ux, uy, uz, length, low_x, low_y, low_z, high_x, high_y, high_z)
        is_stray &= row.bit != 0
        is_stray &= (b.hit[k] == 0) & (b.flies[k] != 0) & (b.weight[k] != 0.0)
        b.flies[k] = MARKED_LOST if is_stray else b.flies[k]
        strays += 1 if is_stray else 0
    if strays != 0:
        end_marked(b, first, live)
    return live


@lane_pass(layout.BODY)
def set_outer_medium(b, table, first, live):
    """Set the medium outside all bodies, and its coefficients.

    Fields: writes `medium`, `mfp`, `sigma_a`, `survival`.
    """
    medium, mfp, sigma_a, survival = table.medium, table.mfp, table.sigma_a, table.survival
    for k in range(first, live):
        b.medium[k], b.mfp[k], b.sigma_a[k], b.survival[k] = medium, mfp, sigma_a, survival
    return live


@lane_pass(layout.BODY)
def find_medium(b, table, first, live):
    """Set the medium of one body for the lanes in it; passes run from the outermost to the innermost body.

    Fields: reads `inside`; updates `medium`, `mfp`, `sigma_a`, `survival`.
    """
    bit, medium, mfp, sigma_a, survival = table.bit, table.medium, table.mfp, table.sigma_a, table.survival
    for k in range(first, live):
        here = (b.inside[k] & bit) != 0
        b.medium[k] = medium if here else b.medium[k]
        b.mfp[k] = mfp if here else b.mfp[k]
        b.sigma_a[k] = sigma_a if here else b.sigma_a[k]
        b.survival[k] = survival if here else b.survival[k]
    return live


@lane_pass(layout.ROWS)
def find_medium_of_many(b, table, first, live):
    """Find the medium as `find_medium` does, for many bodies: gathers the row of the innermost one.

    Fields: reads `inside`; writes `medium`, `mfp`, `sigma_a`, `survival`.
    """
    rows = view(table.rows, table.count, layout.MEDIA)
    for k in range(first, live):
        medium = innermost(b.inside[k])
        row = rows[uint64(medium)]
        b.medium[k], b.mfp[k], b.sigma_a[k], b.survival[k] = medium, row.mfp, row.sigma_a, row.survival
    return live
