"""Score, and count scores by size where they differ: a few heavy scores may dominate a mean.

Sizes are binned by quarters of an octave, from the bits of the weight, so counts are exact and independent of
order.
"""

import numpy as np
from numba import uint64

from transport.compile import layout
from transport.engine.bundle import add_to_row, view
from transport.engine.registry import lane_pass
from transport.engine.tally import count_grazing
from transport.physics.bits import bits_of
from transport.physics.device import device

SHIFT = 50  # bits of a float64 below those of its octave and quarter
# octave and quarter of the least size that has a cell of its own
LOWEST = (1023 + layout.SIZE_OCTAVE) * layout.SIZE_PARTS


@device
def size_cell(weight):
    """Return the size cell of a score; the first and last cells take all beyond them."""
    return min(max((bits_of(weight) >> SHIFT) - LOWEST, 0), layout.SIZE_CELLS - 1)


@lane_pass(layout.SIZES)
def score_and_size(b, table, first, live):
    """Score like detectors.score, and count the score's size on this side of the detector.

    A batch whose number has a bit of `resting` counts none.

    Fields: reads `weight`, `mu`, `detector_row`, `bin`, `high`, `low`, `slant`, `is_grazing`.
    """
    numbers, sizes = view(table.numbers, table.count, np.int64), view(b.sizes, table.cells, np.int64)
    n, one = 0, 1 if b.batch & table.resting == 0 else 0
    for k in range(first, live):  # no branch, so no misprediction
        b.listed[n] = k
        n += 1 if b.bin[k] != 0 else 0
    for j in range(n):
        k = uint64(b.listed[j])
        add_to_row(b.tallies + 32 * b.bin[k], b.high[k], b.low[k], 1, b.slant[k])
        sizes[uint64(numbers[uint64(b.detector_row[k])] + size_cell(b.weight[k]))] += one
    count_grazing(b, first, live)
    return live


@lane_pass(layout.SIZES)
def score_all_and_size(b, table, first, live):
    """Score as `score_and_size` does, where nearly every lane has a bin.

    Row 0 and the first cells take the others and are never read.

    Fields: reads `weight`, `mu`, `detector_row`, `bin`, `high`, `low`, `slant`, `is_grazing`.
    """
    numbers, sizes = view(table.numbers, table.count, np.int64), view(b.sizes, table.cells, np.int64)
    if b.batch & table.resting != 0:
        for k in range(first, live):
            add_to_row(b.tallies + 32 * b.bin[k], b.high[k], b.low[k], 1, b.slant[k])
        count_grazing(b, first, live)
        return live
    for k in range(first, live):
        cell = numbers[uint64(b.detector_row[k])] + size_cell(b.weight[k])
        b.listed[k] = cell if b.bin[k] != 0 else 0
    for k in range(first, live):  # one loop for both, whose memory accesses overlap
        add_to_row(b.tallies + 32 * b.bin[k], b.high[k], b.low[k], 1, b.slant[k])
        sizes[uint64(b.listed[k])] += 1
    count_grazing(b, first, live)
    return live
