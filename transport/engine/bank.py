"""Copies of particles wait in a bank until lanes are free: for splitting, and for collisions that are forced.

A copy draws its own random numbers: its number is a hash of its parent's number, event and place among the copies, 55 bits
and a mark, so that two of a batch of 10^6 copies share one with a chance of 1e-5.  What a run counts does not depend on
when a copy is taken up.
"""

import numpy as np
from numba import int64, uint64

from transport.compile.layout import MOVED
from transport.engine.addresses import view
from transport.engine.bundle import CARRIED, CARRIED_WORDS, PITCH
from transport.engine.lanes import FIELDS
from transport.engine.passes import lane_pass
from transport.physics.bits import bits_of
from transport.physics.device import device

ROOM = 1 << 16  # copies that a bank holds
HISTORY, WEIGHT, BIRTH, AHEAD = (
    [name for name, _ in CARRIED].index(name) for name in ("history", "weight", "birth", "ahead")
)
FORCED = 1 << 20  # the place of a copy whose collision is forced, beyond those of splitting
MARK, LOWER = 1 << 55, (1 << 55) - 1


@device
def number_of_copy(history, event, place):
    """A number that no history born has: bit 55 marks a copy; SplitMix64's mixing (Steele, Lea, Flood 2014)."""
    z = uint64(history) + uint64(0x9E3779B97F4A7C15) * uint64(event + 1)
    z = (z ^ (z >> uint64(30))) * uint64(0xBF58476D1CE4E5B9) + uint64(place)
    z = (z ^ (z >> uint64(27))) * uint64(0x94D049BB133111EB)
    z = (z ^ (z >> uint64(30))) * uint64(0xBF58476D1CE4E5B9)
    return int64((z ^ (z >> uint64(31))) & uint64(LOWER)) | int64(MARK)


@device
def listed_with_copies(b, first, live):
    """Lists the lanes that go into the bank, and returns their number."""
    n = 0
    for k in range(first, live):
        b.listed[n] = k
        n += 1 if b.copies[k] > 0 else 0
    return n


@device
def laid_down(b, fields, words, count, k, place):
    """A copy of lane k in the bank, as a row by the numbers of its fields; the first row again where there is no room."""
    b.overfull |= 1 if b.banked >= b.bank_room else 0
    row = view(b.bank + (0 if b.overfull != 0 else 8 * FIELDS * b.banked), FIELDS, np.int64)
    for f in range(count):
        row[fields[f]] = words[CARRIED_WORDS + fields[f] * PITCH + k]
    row[HISTORY] = number_of_copy(b.history[k], b.event[k], place)
    b.banked += 1 if b.overfull == 0 else 0
    return row


@lane_pass(MOVED)
def deposit(b, table, first, live):
    """`copies` of each lane go into the bank."""
    fields = view(table.fields, table.count, np.int64)
    words = view(b.address, CARRIED_WORDS + FIELDS * PITCH, np.int64)
    for j in range(listed_with_copies(b, first, live)):
        k = b.listed[j]
        for place in range(b.copies[k]):
            laid_down(b, fields, words, table.count, k, place)
        b.copies[k] = 0
    return live


@lane_pass(MOVED)
def deposit_forced(b, table, first, live):
    """The copies that force_collision made: each sets out where its lane does, with a weight and a path of its own."""
    fields = view(table.fields, table.count, np.int64)
    words = view(b.address, CARRIED_WORDS + FIELDS * PITCH, np.int64)
    for j in range(listed_with_copies(b, first, live)):
        k = b.listed[j]
        row = laid_down(b, fields, words, table.count, k, FORCED)
        caught = b.caught[k]
        birth = caught * (
            b.birth[k] / (b.weight[k] + caught)
        )  # so that roulette treats it as it would have the whole
        row[WEIGHT], row[BIRTH], row[AHEAD] = bits_of(caught), bits_of(birth), bits_of(b.path[k])
        b.copies[k] = 0
    return live


@lane_pass(MOVED)
def withdraw(b, table, first, live):
    """Free lanes take copies from the bank."""
    fields = view(table.fields, table.count, np.int64)
    words = view(b.address, CARRIED_WORDS + FIELDS * PITCH, np.int64)
    for k in range(first, live):
        b.banked -= 1
        row = view(b.bank + 8 * FIELDS * b.banked, FIELDS, np.int64)
        for f in range(table.count):
            words[CARRIED_WORDS + fields[f] * PITCH + k] = row[fields[f]]
    return live
