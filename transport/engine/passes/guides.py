"""Guided births: their uniform numbers are drawn from a learnt density, with the exact weight.

The density is constant on boxes of the unit cube of the four numbers from which place and direction follow
(compile/guides.py). So every law of emission, and every detector that histories start from, is guided by the
same pass; the passes that sample place and direction take these numbers in place of their own.
"""

import numpy as np
from numba import uint64

from transport.compile import layout
from transport.engine.bodies import lane_pass
from transport.engine.bundle import view
from transport.engine.passes.detectors import has_bin
from transport.physics.bits import bits_of
from transport.physics.device import device
from transport.physics.streams import DIRECTION, GUIDE, POSITION, random_words, uniform

BELOW_ONE = 1.0 - 2.0**-52
BIRTH_BYTES = layout.BIRTH_RECORD.itemsize


@device
def number_in(low, width, chance):
    """Return a number in a side of a box, below 1."""
    number = low + width * chance
    return number if number < BELOW_ONE else BELOW_ONE


@lane_pass(layout.GUIDE)
def draw_guided_birth(lane, table):
    """Draw the four uniform numbers of a birth from the learnt density, and set its weight."""
    count, history, batch, seed_low, seed_high = (
        table.count,
        lane.history,
        lane.batch,
        lane.seed_low,
        lane.seed_high,
    )
    shares = view(lane.arena + table.shares, count, np.float64)
    boxes = view(lane.arena + table.boxes, layout.GUIDE_BOX_WORDS * count, np.float64)
    g0, g1, _, _ = random_words(history, batch, 0, GUIDE, seed_low, seed_high)
    p0, p1, p2, p3 = random_words(history, batch, 0, POSITION, seed_low, seed_high)
    d0, d1, d2, d3 = random_words(history, batch, 0, DIRECTION, seed_low, seed_high)
    # Binary search in the cumulative probabilities.
    chance, found, width = uniform(g0, g1), 0, count
    while width > 1:
        half = width >> 1
        found += half if chance >= shares[found + half - 1] else 0
        width -= half
    i = layout.GUIDE_BOX_WORDS * found
    lane.u0 = number_in(boxes[i], boxes[i + 4], uniform(p0, p1))
    lane.u1 = number_in(boxes[i + 1], boxes[i + 5], uniform(p2, p3))
    lane.u2 = number_in(boxes[i + 2], boxes[i + 6], uniform(d0, d1))
    lane.u3 = number_in(boxes[i + 3], boxes[i + 7], uniform(d2, d3))
    lane.worth = boxes[i + 8]
    lane.weight *= boxes[i + 8]


@device
def bits_of_uniform(number):
    """Return the two words from which `uniform` makes a number, packed."""
    return bits_of(1.0 + number) << 12


@device
def place_block(lane, table):
    """Set the block of a birth's place to the guided numbers."""
    lane.block_0, lane.block_1 = bits_of_uniform(lane.u0), bits_of_uniform(lane.u1)


@device
def direction_block(lane, table):
    """Set the block of a birth's direction to the guided numbers."""
    lane.block_0, lane.block_1 = bits_of_uniform(lane.u2), bits_of_uniform(lane.u3)


# ---- What each history was born from, and what it brought to the detectors: from these a guide is learnt.


@lane_pass(layout.GUIDE)
def record_birth(lane, table):
    """Record what a history is born from."""
    row = view(lane.births + BIRTH_BYTES * lane.history, 1, layout.BIRTH_RECORD)[0]
    row.u0, row.u1, row.u2, row.u3, row.worth = lane.u0, lane.u1, lane.u2, lane.u3, lane.worth
    row.origin, lane.born = table.origin, lane.history


@lane_pass(layout.HISTORY_SUMS, when=has_bin)
def add_to_history(lane, table):
    """Add a score to the sum of its history for this detector."""
    row = uint64(lane.detector_row)
    factors = view(lane.arena + table.factors, table.rows, np.float64)
    numbers = view(lane.arena + table.numbers, table.rows, np.int64)
    sums = view(lane.brought + 8 * table.count * lane.born, table.count, np.float64)
    sums[uint64(numbers[row])] += lane.weight * factors[row]
