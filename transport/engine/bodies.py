"""In which bodies a particle is: known from the surfaces that it has crossed; the innermost one's medium counts.

A surface says for each of its sides which bodies are there.  What leaves to that side is in them from then on, whatever
was known before: so a mistake does not last.
"""

from numba import float64

from transport.compile.layout import INSIDE, LAYER, LAYERS, MEDIA, ROWS, SHEET_SHIFT
from transport.engine.addresses import view
from transport.engine.passes import lane_pass
from transport.physics.bits import bits_of
from transport.physics.device import device


@lane_pass(INSIDE)
def begin_inside(b, table, first, live):
    """In the bodies about its source."""
    inside, medium, sigma, sigma_a, survival = (
        table.inside,
        table.medium,
        table.sigma,
        table.sigma_a,
        table.survival,
    )
    for k in range(first, live):
        b.inside[k], b.medium[k] = inside, medium
        b.sigma[k], b.sigma_a[k], b.survival[k] = sigma, sigma_a, survival
    return live


@lane_pass(LAYERS)
def cross_boundary(b, table, first, live):
    """What leaves a surface to one side is in the bodies of that side.  Bodies that share a face are each told by its own."""
    rows, layer = view(table.rows, table.count, LAYER), table.layer
    for k in range(first, live):
        row = rows[b.hit[k] >> SHEET_SHIFT]
        front, back = row.front, row.back
        covered = ((b.hit[k] >> layer) & 1) != 0
        side = front if b.mu[k] > 0.0 else back
        inside = (b.inside[k] & ~(front | back)) | side
        b.inside[k] = inside if covered else b.inside[k]
    return live


@device
def innermost(inside):
    """One more than the number of the lowest bit; 0 where there is none."""
    lowest = inside & -inside
    return (bits_of(float64(lowest)) >> 52) - 1022 if lowest != 0 else 0


@lane_pass(ROWS)
def take_medium(b, table, first, live):
    """What the medium of the innermost body does to a flight."""
    rows = view(table.rows, table.count, MEDIA)
    for k in range(first, live):
        medium = innermost(b.inside[k])
        row = rows[medium]
        b.medium[k], b.sigma[k], b.sigma_a[k], b.survival[k] = medium, row.sigma, row.sigma_a, row.survival
    return live
