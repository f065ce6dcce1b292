"""Random numbers as a pure function of (seed, batch, history, event, purpose): Philox4x32-10.

The seed is the 64-bit key; history, batch, event and purpose are the four words of the 128-bit counter. No
two draws of any run share a counter, so streams cannot overlap, by construction. Salmon, Moraes, Dror, Shaw
(2011), "Parallel random numbers: as easy as 1, 2, 3"; known answers of their Random123 distribution are a
test.
"""

from numba import int64, uint64

from transport.physics.bits import float_of, real
from transport.physics.device import device

# Purposes: the fourth word of the counter, one per kind of draw.
EVENT, POSITION, DIRECTION, DEPTH, CLOCK, AIM, SHARES, SPEED = range(8)
WALL, PATH, VOXELS, SHADOW, WEIGH, AGAIN = range(8, 14)
EXPECT = 14  # points on detectors; the upper bits of the event hold the detector's number
GUIDE = 15  # boxes of a learnt density of births (compile/guides.py)

LOW32 = uint64(0xFFFFFFFF)
HALF = uint64(32)
UPPER24 = uint64(0xFFFFFF00)
EXPONENT_OF_ONE = uint64(0x3FF0000000000000)
MULTIPLIER_0, MULTIPLIER_1 = uint64(0xD2511F53), uint64(0xCD9E8D57)
WEYL_0, WEYL_1 = uint64(0x9E3779B9), uint64(0xBB67AE85)


ROUNDS, FIRST_ROUNDS = 10, 6


@device
def philox_rounds(c0, c1, c2, c3, key0, key1, rounds):
    """Return four 32-bit words (in uint64) for a counter and a key of 32-bit words (in uint64)."""
    for _ in range(rounds):
        p0 = MULTIPLIER_0 * c0
        p1 = MULTIPLIER_1 * c2
        c0, c1, c2, c3 = (p1 >> HALF) ^ c1 ^ key0, p1 & LOW32, (p0 >> HALF) ^ c3 ^ key1, p0 & LOW32
        key0 = (key0 + WEYL_0) & LOW32
        key1 = (key1 + WEYL_1) & LOW32
    return c0, c1, c2, c3


# A block is begun by FIRST_ROUNDS rounds and ended by the others, so that a pass may do each in a loop of its
# own. Every round waits for the one before; with all rounds in one loop a processor has too few lanes at
# work at once (3.4 ns a lane, 4.0 in one loop; AMD Zen 3).


@device
def packed(w0, w1, w2, w3):
    """Return four 32-bit words as two of 64 bits."""
    return int64((w0 << HALF) | w1), int64((w2 << HALF) | w3)


@device
def unpacked(first, second):
    """Return the four 32-bit words in two of 64 bits."""
    first, second = uint64(first), uint64(second)
    return first >> HALF, first & LOW32, second >> HALF, second & LOW32


@device
def begin_block(history, batch, event, purpose, seed_low, seed_high):
    """Return the begun block for all draws of one event of one history, packed, for `end_block`."""
    # The compiler knows of a masked word that a product of 32 bits is enough.
    c0, c1 = uint64(history) & LOW32, uint64(batch) & LOW32
    c2, c3 = uint64(event) & LOW32, uint64(purpose) & LOW32
    key0, key1 = uint64(seed_low) & LOW32, uint64(seed_high) & LOW32
    c0, c1, c2, c3 = philox_rounds(c0, c1, c2, c3, key0, key1, FIRST_ROUNDS)
    return packed(c0, c1, c2, c3)


@device
def begin_event_block(history, batch, event, purpose, seed_low, seed_high):
    """Return the same for a history that may be a copy.

    The upper 24 of its number's 56 bits (engine/passes/variance_reduction.py) are combined with the purpose.
    """
    own = uint64(purpose) ^ ((uint64(history) >> uint64(24)) & UPPER24)
    return begin_block(history, batch, event, own, seed_low, seed_high)


@device
def end_block(first, second, seed_low, seed_high):
    """Return the block of four random 32-bit words that was begun."""
    c0, c1, c2, c3 = unpacked(first, second)
    key0 = (uint64(seed_low) + uint64(FIRST_ROUNDS) * WEYL_0) & LOW32
    key1 = (uint64(seed_high) + uint64(FIRST_ROUNDS) * WEYL_1) & LOW32
    return philox_rounds(c0, c1, c2, c3, key0, key1, ROUNDS - FIRST_ROUNDS)


@device
def random_words(history, batch, event, purpose, seed_low, seed_high):
    """Return the block of four random 32-bit words for all draws of one event of one history."""
    first, second = begin_block(history, batch, event, purpose, seed_low, seed_high)
    return end_block(first, second, seed_low, seed_high)


@device
def event_words(history, batch, event, purpose, seed_low, seed_high):
    """Return the same for a history that may be a copy."""
    first, second = begin_event_block(history, batch, event, purpose, seed_low, seed_high)
    return end_block(first, second, seed_low, seed_high)


@device
def uniform(high, low):
    """Return a uniform in [0, 1) with 52 random bits, from two 32-bit words."""
    bits = (high << HALF) | low
    return float_of(int64((bits >> uint64(12)) | EXPONENT_OF_ONE)) - 1.0


@device
def short_uniform(word):
    """Return a uniform in (0, 1) from one 32-bit word: a middle of 2^32 equal cells, so never 0 or 1."""
    return (real(int64(word)) + 0.5) * 2.3283064365386963e-10
