"""In which bodies a particle is: known from the surfaces that it has crossed; the innermost one's medium counts.

A surface says for each of its sides which bodies are there.  What leaves to that side is in them from then on, whatever
was known before: so a mistake does not last.
"""

import numpy as np
from numba import float64, uint64

from transport.compile.layout import (
    BODY,
    ESCAPED,
    INSIDE,
    LAYER,
    LAYERS,
    MEDIA,
    NO_TABLE,
    NOTHING_BEFORE,
    NOTHING_BEHIND,
    ROWS,
    SHEET_SHIFT,
)
from transport.engine.addresses import view
from transport.engine.passes import lane_pass
from transport.engine.sums import limbs
from transport.physics.bits import bits_of
from transport.physics.device import device


@lane_pass(INSIDE)
def begin_inside(b, table, first, live):
    """In the bodies about its source."""
    inside = table.inside
    for k in range(first, live):
        b.inside[k] = inside
    return live


@lane_pass(LAYERS)
def cross_boundary(b, table, first, live):
    """What leaves a surface to one side is in the bodies of that side.  Bodies that share a face are each told by its own."""
    rows, layer = view(table.rows, table.count, LAYER), table.layer
    for k in range(first, live):
        row = rows[uint64(b.hit[k] >> SHEET_SHIFT)]
        front, back = row.front, row.back
        covered = ((b.hit[k] >> layer) & 1) != 0
        side = front if b.mu[k] > 0.0 else back
        inside = (b.inside[k] & ~(front | back)) | side
        b.inside[k] = inside if covered else b.inside[k]
    return live


@lane_pass(NO_TABLE)
def escape_at_once(b, table, first, live):
    """What leaves all bodies to a side where no surface lies has escaped."""
    high, low = 0, 0
    for k in range(first, live):
        beyond = NOTHING_BEFORE if b.mu[k] > 0.0 else NOTHING_BEHIND
        escapes = ((b.hit[k] & beyond) != 0) & (b.inside[k] == 0)
        w_high, w_low = limbs(b.weight[k] if escapes else 0.0)
        high += w_high
        low += w_low
        b.weight[k] = 0.0 if escapes else b.weight[k]
    ledger = view(b.ledger, b.ledger_words, np.int64)
    ledger[4 * ESCAPED] += high
    ledger[4 * ESCAPED + 1] += low
    return live


@device
def innermost(inside):
    """One more than the number of the lowest bit; 0 where there is none."""
    lowest = inside & -inside
    return (bits_of(float64(lowest)) >> 52) - 1022 if lowest != 0 else 0


@lane_pass(BODY)
def know_surroundings(b, table, first, live):
    """The medium about all bodies, and what it does to a flight."""
    medium, mfp, sigma_a, survival = table.medium, table.mfp, table.sigma_a, table.survival
    for k in range(first, live):
        b.medium[k], b.mfp[k], b.sigma_a[k], b.survival[k] = medium, mfp, sigma_a, survival
    return live


@lane_pass(BODY)
def know_body(b, table, first, live):
    """The medium of one body for those that are in it; of bodies in one another the innermost comes last."""
    bit, medium, mfp, sigma_a, survival = table.bit, table.medium, table.mfp, table.sigma_a, table.survival
    for k in range(first, live):
        here = (b.inside[k] & bit) != 0
        b.medium[k] = medium if here else b.medium[k]
        b.mfp[k] = mfp if here else b.mfp[k]
        b.sigma_a[k] = sigma_a if here else b.sigma_a[k]
        b.survival[k] = survival if here else b.survival[k]
    return live


@lane_pass(ROWS)
def know_bodies(b, table, first, live):
    """The same where bodies are many: the row of the innermost one is fetched."""
    rows = view(table.rows, table.count, MEDIA)
    for k in range(first, live):
        medium = innermost(b.inside[k])
        row = rows[uint64(medium)]
        b.medium[k], b.mfp[k], b.sigma_a[k], b.survival[k] = medium, row.mfp, row.sigma_a, row.survival
    return live
