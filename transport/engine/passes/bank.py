"""Particle bank: copies from splitting and forced collisions wait until lanes are free.

A copy draws random numbers of its own: its history number is a hash of its parent's number, event and index
among the copies, 55 bits and a mark, so that two of 10^6 copies in a batch coincide with probability 1e-5.
Results do not depend on when a copy is taken up.
"""

import numpy as np
from numba import int64, uint64

from transport.compile import layout
from transport.engine.bundle import CARRIED, CARRIED_WORDS, PITCH, view
from transport.engine.passes.lanes import FIELDS
from transport.engine.registry import lane_pass
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
def list_copied_lanes(b, first, live):
    """List the lanes with copies to bank; returns their number.

    Fields: reads `copies`.
    """
    n = 0
    for k in range(first, live):
        b.listed[n] = k
        n += 1 if b.copies[k] > 0 else 0
    return n


@device
def write_copy(b, fields, words, count, k, place):
    """Write a copy of lane k into the bank and return its row.

    A full bank sets `bank_overflow` and reuses the first row.

    Fields: reads `history`, `event`; updates `banked`, `bank_overflow`.
    """
    b.bank_overflow |= 1 if b.banked >= b.bank_capacity else 0
    row = view(b.bank + (0 if b.bank_overflow != 0 else 8 * FIELDS * b.banked), FIELDS, np.int64)
    for f in range(count):
        row[fields[f]] = words[CARRIED_WORDS + fields[f] * PITCH + k]
    row[HISTORY] = number_of_copy(b.history[k], b.event[k], place)
    b.banked += 1 if b.bank_overflow == 0 else 0
    return row


@lane_pass(layout.FIELD_MOVES)
def bank_copies(b, table, first, live):
    """Put `copies` copies of each lane into the bank.

    Fields: reads `history`, `event`; updates `copies`, `banked`, `bank_overflow`.
    """
    fields = view(table.fields, table.count, np.int64)
    words = view(b.address, CARRIED_WORDS + FIELDS * PITCH, np.int64)
    for j in range(list_copied_lanes(b, first, live)):
        k = b.listed[j]
        for place in range(b.copies[k]):
            write_copy(b, fields, words, table.count, k, place)
        b.copies[k] = 0
    return live


@lane_pass(layout.FIELD_MOVES)
def bank_forced_copies(b, table, first, live):
    """Put the copies of force_collision into the bank, with a weight and a path of their own.

    Fields: reads `weight`, `birth`, `history`, `event`, `copy_weight`, `copy_path`; updates `copies`,
    `banked`, `bank_overflow`.
    """
    fields = view(table.fields, table.count, np.int64)
    words = view(b.address, CARRIED_WORDS + FIELDS * PITCH, np.int64)
    for j in range(list_copied_lanes(b, first, live)):
        k = b.listed[j]
        row = write_copy(b, fields, words, table.count, k, FORCED)
        caught = b.copy_weight[k]
        # Roulette treats the copy like the undivided particle.
        birth = caught * (b.birth[k] / (b.weight[k] + caught))
        row[WEIGHT], row[BIRTH], row[AHEAD] = bits_of(caught), bits_of(birth), bits_of(b.copy_path[k])
        b.copies[k] = 0
    return live


@lane_pass(layout.FIELD_MOVES)
def take_copies(b, table, first, live):
    """Fill free lanes with copies from the bank.

    Fields: updates `banked`.
    """
    fields = view(table.fields, table.count, np.int64)
    words = view(b.address, CARRIED_WORDS + FIELDS * PITCH, np.int64)
    for k in range(first, live):
        b.banked -= 1
        row = view(b.bank + 8 * FIELDS * b.banked, FIELDS, np.int64)
        for f in range(table.count):
            words[CARRIED_WORDS + fields[f] * PITCH + k] = row[fields[f]]
    return live
