"""Particle bank: copies from splitting and forced collisions wait until lanes are free.

A copy draws random numbers of its own: its history number is a hash of its parent's number, event and index
among the copies, 55 bits and a mark, so that two of 10^6 copies in a batch coincide with probability 1e-5.
Results do not depend on when a copy is taken up.
"""

import numpy as np
from numba import int64, uint64

from transport.compile import layout
from transport.engine.bodies import lane_pass, lane_word, set_lane_word
from transport.engine.bundle import CARRIED, view
from transport.engine.passes.lanes import FIELDS
from transport.physics.bits import bits_of
from transport.physics.device import device

BANK_CAPACITY = 1 << 16  # capacity of a bank in copies
HISTORY, WEIGHT, BIRTH, AHEAD = (
    [name for name, _ in CARRIED].index(name) for name in ("history", "weight", "birth", "forced_path")
)
FORCED = 1 << 20  # index of a copy whose collision is forced, beyond those of splitting
COPY_BIT, HASH_MASK = 1 << 55, (1 << 55) - 1


@device
def number_of_copy(history, event, place):
    """Return the history number of a copy: a hash with bit 55 set, which no born history has.

    The mixing is that of SplitMix64 (Steele, Lea, Flood 2014).
    """
    z = uint64(history) + uint64(0x9E3779B97F4A7C15) * uint64(event + 1)
    z = (z ^ (z >> uint64(30))) * uint64(0xBF58476D1CE4E5B9) + uint64(place)
    z = (z ^ (z >> uint64(27))) * uint64(0x94D049BB133111EB)
    z = (z ^ (z >> uint64(30))) * uint64(0xBF58476D1CE4E5B9)
    return int64((z ^ (z >> uint64(31))) & uint64(HASH_MASK)) | int64(COPY_BIT)


@device
def has_copies(lane, table):
    """Return whether a lane has copies to bank."""
    return lane.copies > 0


@device
def write_copy(lane, table, place):
    """Write a copy of a lane into the bank and return its row.

    A full bank sets `bank_overflow` and reuses the first row.
    """
    fields = view(lane.arena + table.fields, table.count, np.int64)
    lane.bank_overflow |= 1 if lane.banked >= lane.bank_capacity else 0
    row = view(lane.bank + (0 if lane.bank_overflow != 0 else 8 * FIELDS * lane.banked), FIELDS, np.int64)
    for f in range(table.count):
        row[fields[f]] = lane_word(lane, fields[f])
    row[HISTORY] = number_of_copy(lane.history, lane.event, place)
    lane.banked += 1 if lane.bank_overflow == 0 else 0
    return row


@lane_pass(layout.FIELD_MOVES, when=has_copies)
def bank_copies(lane, table):
    """Put `copies` copies of each lane into the bank."""
    for place in range(lane.copies):
        write_copy(lane, table, place)
    lane.copies = 0


@lane_pass(layout.FIELD_MOVES, when=has_copies)
def bank_forced_copies(lane, table):
    """Put the copies of force_collision into the bank, with a weight and a path of their own."""
    row = write_copy(lane, table, FORCED)
    caught = lane.copy_weight
    # Roulette treats the copy like the undivided particle.
    birth = caught * (lane.birth / (lane.weight + caught))
    row[WEIGHT], row[BIRTH], row[AHEAD] = bits_of(caught), bits_of(birth), bits_of(lane.copy_path)
    lane.copies = 0


@lane_pass(layout.FIELD_MOVES)
def take_copies(lane, table):
    """Fill free lanes with copies from the bank."""
    fields = view(lane.arena + table.fields, table.count, np.int64)
    lane.banked -= 1
    row = view(lane.bank + 8 * FIELDS * lane.banked, FIELDS, np.int64)
    for f in range(table.count):
        set_lane_word(lane, fields[f], row[fields[f]])
