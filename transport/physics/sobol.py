"""Owen-scrambled Sobol points as a function of (seed, batch, history, event, purpose).

They are twins of the random words of streams.py. The points of a batch are a net: each uniform of a birth is
one dimension, and all boxes of equal volume hold equally many of the 2^m points. Sobol (1967); directions by
Joe and Kuo (2008), "Constructing Sobol sequences with better two-dimensional projections", SIAM J. Sci.
Comput. 30, 2635 (new-joe-kuo-6). Each digit is flipped by a hash of the digits before it (nested uniform
scrambling, Owen 1995), after Laine and Karras (2011) and Burley (2020), "Practical hash-based Owen
scrambling", JCGT 9 (4). The keys come from Philox: every batch, purpose and event has its own scrambling, so
batches are independent replicates.

Digits are kept in reverse order, the first one lowest: a multiplication then carries only from earlier digits
to later ones.
"""

import numpy as np
from numba import uint64

from transport.physics.bits import reversed_bits
from transport.physics.device import device
from transport.physics.streams import (
    AIM,
    CLOCK,
    DEPTH,
    DIRECTION,
    EXPECT,
    HALF,
    LOW32,
    POSITION,
    SPEED,
    UPPER24,
    philox_rounds,
    random_words,
)

# Dimensions 2, 3, ...: degree of a primitive polynomial, its inner coefficients as bits, initial numbers.
JOE_KUO = (
    (1, 0, (1,)),
    (2, 1, (1, 3)),
    (3, 1, (1, 3, 1)),
    (3, 2, (1, 1, 1)),
    (4, 1, (1, 1, 3, 3)),
    (4, 4, (1, 3, 5, 13)),
    (5, 2, (1, 1, 5, 5, 17)),
    (5, 4, (1, 1, 5, 5, 5)),
    (5, 7, (1, 1, 7, 11, 19)),
    (5, 11, (1, 1, 5, 1, 1)),
    (5, 13, (1, 1, 1, 3, 11)),
    (5, 14, (1, 3, 5, 5, 31)),
    (6, 1, (1, 3, 3, 9, 7, 49)),
    (6, 13, (1, 1, 1, 15, 21, 21)),
    (6, 16, (1, 3, 1, 13, 27, 49)),
    (6, 19, (1, 1, 1, 15, 7, 5)),
    (6, 22, (1, 3, 1, 15, 13, 25)),
)
DIGITS = 32
NOT_JOINT = -1


def direction_numbers(dimension: int) -> list[int]:
    """Return the 32 direction numbers of a dimension (0, 1, ...), first digit highest.

    Method of Bratley and Fox (1988).
    """
    if dimension == 0:
        return [1 << (DIGITS - 1 - bit) for bit in range(DIGITS)]
    degree, inner, first = JOE_KUO[dimension - 1]
    numbers = [m << (DIGITS - 1 - bit) for bit, m in enumerate(first)]
    for bit in range(degree, DIGITS):
        number = numbers[bit - degree] ^ (numbers[bit - degree] >> degree)
        for k in range(1, degree):
            number ^= numbers[bit - k] if inner >> (degree - 1 - k) & 1 else 0
        numbers.append(number)
    return numbers


def _pair(first: int) -> list[int]:
    """Return the direction numbers of two dimensions in one word each, digits in reverse order."""
    one, other = (
        [int(f"{number:032b}"[::-1], 2) for number in direction_numbers(first + k)] for k in range(2)
    )
    return [a | b << DIGITS for a, b in zip(one, other, strict=True)]


PAIRS = np.array([_pair(2 * pair) for pair in range(9)], np.uint64)
ZERO, ONE, EIGHT = uint64(0), uint64(1), uint64(8)
# Bits of a purpose; higher bits number the blocks where their count is not known beforehand.
PURPOSE = uint64(0xFF)
MIX_0, MIX_1, MIX_2 = uint64(0x3D20ADEA), uint64(0x05526C56), uint64(0x53A22864)  # Vegdahl (2021)
KEY_ROUNDS = 5


@device
def pair_of(event, purpose):
    """Return the pair of dimensions of a block at birth, most important first.

    NOT_JOINT for a net of its own.
    """
    pair = NOT_JOINT
    if event == 0:
        pair = 0 if purpose == POSITION else pair
        pair = 1 if (purpose == AIM) | (purpose == EXPECT) else pair
        pair = 2 if purpose == DIRECTION else pair
        pair = 3 if purpose == DEPTH else pair
        pair = 4 if purpose == CLOCK else pair
        pair = 5 if purpose == SPEED else pair
    if event == 1:
        pair = 6 if purpose == AIM else pair
        pair = 7 if purpose == SPEED else pair
        pair = 8 if purpose == DEPTH else pair
    return pair


@device
def pair_digits(index, pair):
    """Return the reversed digits of the two dimensions of a pair, the first one in the lower half."""
    digits = ZERO
    for bit in range(DIGITS):
        digits ^= PAIRS[pair, bit] if (index >> uint64(bit)) & ONE != ZERO else ZERO
    return digits


@device
def second_digits(index):
    """Return the reversed digits of the second dimension, from those of the first.

    As polynomials over GF(2): t becomes 1 + t.
    """
    digits = index ^ ((index >> uint64(16)) & uint64(0x0000FFFF))
    digits ^= (digits >> uint64(8)) & uint64(0x00FF00FF)
    digits ^= (digits >> uint64(4)) & uint64(0x0F0F0F0F)
    digits ^= (digits >> uint64(2)) & uint64(0x33333333)
    return digits ^ ((digits >> ONE) & uint64(0x55555555))


@device
def scrambled(digits, key):
    """Return reversed digits, each flipped by a hash of those before it (Owen scrambling)."""
    digits ^= (digits * MIX_0) & LOW32
    digits = (digits + key) & LOW32
    digits = (digits * ((key >> uint64(16)) | ONE)) & LOW32
    digits ^= (digits * MIX_1) & LOW32
    return digits ^ ((digits * MIX_2) & LOW32)


@device
def later_digits(word, key):
    """Return 32 more digits, which scrambling makes random for points that earlier digits distinguish."""
    mixed = (word ^ key) * uint64(0x9E3779B1)
    mixed = ((mixed >> HALF) ^ (mixed & LOW32)) * uint64(0x85EBCA6B)
    return (mixed >> HALF) ^ (mixed & LOW32)


@device
def two_numbers(one, other, key_one, key_other):
    """Return four words: scrambled and later digits of one dimension, the same of another."""
    both = reversed_bits(scrambled(one, key_one) | (scrambled(other, key_other) << HALF))
    first, second = both >> HALF, both & LOW32
    return first, later_digits(first, key_other), second, later_digits(second, key_one)


@device
def parted(index, key):
    """Return the index in another order within each 256: a linear map that makes distant points neighbours.

    A nested shuffle alone leaves neighbours side by side: they lie in opposite halves of every block's
    numbers, and products of numbers of two blocks have up to twice the variance of independent draws (with
    this map, 1.0 of it).
    """
    index = (
        (index >> EIGHT << EIGHT) | ((index & uint64(15)) << uint64(4)) | ((index >> uint64(4)) & uint64(15))
    )
    index ^= (key & uint64(0xFE)) if index & ONE != ZERO else ZERO
    index ^= ((key >> EIGHT) & uint64(0xFD)) if index & uint64(2) != ZERO else ZERO
    return index ^ (((key >> uint64(16)) & uint64(0xFB)) if index & uint64(4) != ZERO else ZERO)


@device
def own_net(history, key, key_0, key_1, key_2):
    """Return four words of an independent net: three dimensions (words 0, 2, 3) of a shuffled index."""
    index = parted(uint64(history), key_2)
    index = reversed_bits(scrambled(reversed_bits(index << HALF), key)) >> HALF
    w0, w1, w2, _ = two_numbers(index, second_digits(index), key_0, key_1)
    w3 = reversed_bits(scrambled(pair_digits(index, 1) & LOW32, key_2)) >> HALF
    return w0, w1, w2, w3


@device
def sobol_words(history, batch, event, purpose, seed_low, seed_high):
    """Return the words of a block at birth: two dimensions of the history's Sobol point."""
    key_0, key_1, key_2, key_3 = random_words(0, batch, event, purpose, seed_low, seed_high)
    pair = pair_of(event, purpose)
    if pair == NOT_JOINT:
        return own_net(history, key_0, key_1, key_2, key_3)
    index = uint64(history)
    digits = index | (second_digits(index) << HALF) if pair == 0 else pair_digits(index, pair)
    return two_numbers(digits & LOW32, digits >> HALF, key_0, key_1)


@device
def stratified_words(history, batch, event, purpose, seed_low, seed_high):
    """Return the words of a block at birth: a point of a net independent of the other blocks."""
    key_0, key_1, key_2, key_3 = random_words(0, batch, event, purpose, seed_low, seed_high)
    return own_net(history, key_0, key_1, key_2, key_3)


@device
def net_event_words(history, batch, event, purpose, seed_low, seed_high):
    """Return the words of a later event: a net among the histories of a batch that reach it.

    A copy (engine/passes/variance_reduction.py) is numbered by a hash, so it is a single random point of one
    more net.
    """
    word = (uint64(purpose) >> EIGHT << EIGHT) ^ ((uint64(history) >> uint64(24)) & UPPER24)
    base_0, base_1, base_2, base_3 = random_words(0, batch, 0, uint64(purpose) & PURPOSE, seed_low, seed_high)
    key, key_0, key_1, key_2 = philox_rounds(
        uint64(event) & LOW32, word, base_0, base_1, base_2, base_3, KEY_ROUNDS
    )
    return own_net(uint64(history) & LOW32, key, key_0, key_1, key_2)
