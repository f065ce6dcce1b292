"""Score, and count scores by size where they differ: a few heavy scores may dominate a mean.

Sizes are binned by quarters of an octave, from the bits of the weight, so counts are exact and independent of
order.
"""

import numpy as np
from numba import uint64

from transport.compile import layout
from transport.engine.bodies import lane_pass
from transport.engine.bundle import view
from transport.engine.passes.detectors import add_score, has_bin
from transport.physics.bits import bits_of
from transport.physics.device import device

SHIFT = 50  # bits of a float64 below those of its octave and quarter
# octave and quarter of the least size that has a cell of its own
LOWEST = (1023 + layout.SIZE_OCTAVE) * layout.SIZE_PARTS


@device
def size_cell(weight):
    """Return the size cell of a score; the first and last cells take all beyond them."""
    return min(max((bits_of(weight) >> SHIFT) - LOWEST, 0), layout.SIZE_CELLS - 1)


@lane_pass(layout.SIZES, when=has_bin)
def score_and_size(lane, table):
    """Score like detectors.score, and count the score's size on this side of the detector.

    A batch whose number has a bit of `resting` counts none.
    """
    numbers = view(lane.arena + table.numbers, table.count, np.int64)
    sizes = view(lane.sizes, table.cells, np.int64)
    add_score(lane)
    one = 1 if lane.batch & table.resting == 0 else 0
    sizes[uint64(numbers[uint64(lane.detector_row)] + size_cell(lane.weight))] += one


@device
def is_resting(lane, table):
    """Return whether the batch counts no sizes."""
    return lane.batch & table.resting != 0


@lane_pass(layout.SIZES)
def score_all_resting(lane, table):
    """Score like detectors.score_all."""
    add_score(lane)


@lane_pass(layout.SIZES, unless=(is_resting, score_all_resting))
def score_all_and_size(lane, table):
    """Score as `score_and_size` does, where nearly every lane has a bin.

    Row 0 and the first cells take the others and are never read.
    """
    numbers = view(lane.arena + table.numbers, table.count, np.int64)
    sizes = view(lane.sizes, table.cells, np.int64)
    cell = numbers[uint64(lane.detector_row)] + size_cell(lane.weight)
    add_score(lane)
    sizes[uint64(cell if lane.bin != 0 else 0)] += 1
