"""Owen-scrambled Sobol points: the published digits, a scrambling that keeps nets, words that are uniform and independent.

All draws are fixed by their keys: a test that passes once passes always.  Rates of false alarms are those over all seeds;
together they stay below 1e-3.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from numba import njit
from scipy.special import ndtri
from scipy.stats import qmc

from tests.agreement import assert_follows
from transport.physics.device import ARITHMETIC
from transport.physics.sobol import (
    NOT_JOINT,
    PAIRS,
    direction_numbers,
    later_digits,
    net_event_words,
    pair_digits,
    pair_of,
    scrambled,
    second_digits,
    sobol_words,
    stratified_words,
)
from transport.physics.streams import (
    AIM,
    CLOCK,
    DEPTH,
    DIRECTION,
    EVENT,
    EXPECT,
    PATH,
    POSITION,
    SHADOW,
    SPEED,
    uniform,
)

FALSE_ALARM = 1e-5
SEED = 20240607, 11
POINTS = 1 << 12
DIMENSIONS = 2 * len(PAIRS)
COPY = (1 << 55) | 0x1234567890ABCD  # a number as engine/passes/variance_reduction.py gives it


@njit(**ARITHMETIC)
def fill_digits(pair, out):
    for i in range(out.shape[0]):
        out[i, 0], out[i, 1] = pair_digits(np.uint64(i), pair), second_digits(np.uint64(i))


@njit(**ARITHMETIC)
def fill_scrambled(digits, key, out):
    for i in range(out.shape[0]):
        out[i] = scrambled(digits[i], key)


def filling(draw):
    """Compile a loop over histories."""

    @njit(**ARITHMETIC)
    def fill(first, batch, event, purpose, low, high, out):
        for i in range(out.shape[0]):
            w = draw(first + i, batch, event, purpose, low, high)
            out[i, 0], out[i, 1], out[i, 2], out[i, 3] = w

    return fill


fill_births, fill_strata, fill_events = map(filling, (sobol_words, stratified_words, net_event_words))
FILLS = (fill_births, fill_strata, fill_events)


def words(fill, batch=0, event=0, purpose=POSITION, points=POINTS, first=0, seed=SEED):
    """Words (points, 4) of the histories from `first` on."""
    out = np.zeros((points, 4), np.uint64)
    fill(first, batch, event, purpose, *seed, out)
    return out


def columns(*parts):
    """Numbers of [0, 1) of 32 bits, (points, dimensions), from columns of words."""
    return np.column_stack(parts).astype(np.float64) * 2.0**-32


def occupancy(u, cells):
    """How many points are in each box of so many cells along each dimension."""
    places = (u * np.array(cells)).astype(np.int64)
    return np.bincount(np.ravel_multi_index(tuple(places.T), cells), minlength=math.prod(cells))


def boxes(dimensions, log2_points):
    """All shapes of elementary intervals that hold one point of a net in the mean."""
    ranges = itertools.product(range(log2_points + 1), repeat=dimensions)
    return [tuple(1 << k for k in shape) for shape in ranges if sum(shape) == log2_points]


def plain_points(dimensions, points=POINTS):
    """Points of SciPy's unscrambled sequence: of the same directions, the points in the order of a Gray code."""
    sequence = qmc.Sobol(DIMENSIONS, scramble=False, bits=32).random(points)
    return np.ascontiguousarray(sequence[:, dimensions])


def assert_pairs_are_even(found, shift):
    """Each pair of a block's four words fills 8 by 8 cells evenly, by its digits from this one on."""
    digits = ((found >> np.uint64(shift)) & np.uint64(7)).astype(np.int64)
    for one, other in itertools.combinations(range(4), 2):
        counts = np.bincount(8 * digits[:, one] + digits[:, other], minlength=64)
        assert_follows(counts, np.full(64, 1 / 64), FALSE_ALARM)


@pytest.mark.parametrize("pair", range(len(PAIRS)))
def test_digits_are_those_of_joe_and_kuo(pair):
    """Bit for bit, against SciPy's table of the same directions."""
    digits, numbers = np.zeros((POINTS, 2), np.uint64), np.arange(POINTS)
    fill_digits(pair, digits)
    gray = numbers ^ (numbers >> 1)
    expected = (plain_points([2 * pair, 2 * pair + 1]) * 2.0**32).astype(np.uint64)
    for half, shift in enumerate((0, 32)):
        forwards = [int(f"{int(word) >> shift & 0xFFFFFFFF:032b}"[::-1], 2) for word in digits[gray, 0]]
        np.testing.assert_array_equal(np.array(forwards, np.uint64), expected[:, half])
    if pair == 0:
        np.testing.assert_array_equal(digits[:, 0], np.arange(POINTS, dtype=np.uint64) | digits[:, 1] << 32)


def test_all_32_direction_numbers_are_those_of_scipy():
    """The points 2^k alone: also digits that no short sequence shows."""
    for dimension in range(DIMENSIONS):
        numbers = direction_numbers(dimension)
        sequence = qmc.Sobol(DIMENSIONS, scramble=False, bits=32)
        at, before = 0, 0
        for bit in range(20):
            sequence.fast_forward((1 << bit) - at)  # the point 2^bit has the Gray code 2^bit + 2^(bit - 1)
            at = (1 << bit) + 1
            here = int(sequence.random(1)[0, dimension] * 2.0**32)
            assert here == numbers[bit] ^ before
            before = numbers[bit]


def test_scrambling_keeps_how_many_digits_two_points_share():
    """Nested: a digit is flipped by those before it alone, so cells become cells; and no two points become one."""
    digits = np.random.default_rng(1).integers(1 << 32, size=POINTS, dtype=np.uint64)
    near = digits ^ (np.uint64(1) << np.random.default_rng(2).integers(32, size=POINTS).astype(np.uint64))
    for key in (0, 1, 0xFFFFFFFF, 0x9E3779B9, 0x12345678):
        one, other = np.zeros_like(digits), np.zeros_like(digits)
        fill_scrambled(digits, np.uint64(key), one)
        fill_scrambled(near, np.uint64(key), other)
        shared, left = digits ^ near, one ^ other
        np.testing.assert_array_equal(shared & (~shared + np.uint64(1)), left & (~left + np.uint64(1)))


@pytest.mark.parametrize("batch", [0, 77])
def test_births_are_nets_in_four_dimensions(batch):
    """Every elementary interval of the first four uniforms holds as many points as before scrambling, in another order."""
    place, aim = (words(fill_births, batch, 0, purpose, 256) for purpose in (POSITION, AIM))
    u = columns(place[:, 0], place[:, 2], aim[:, 0], aim[:, 2])
    plain = plain_points([0, 1, 2, 3], 256)
    for cells in boxes(4, 8):
        np.testing.assert_array_equal(np.sort(occupancy(u, cells)), np.sort(occupancy(plain, cells)))


@pytest.mark.parametrize(("fill", "purpose"), [(FILLS[0], POSITION), (FILLS[1], POSITION), (FILLS[2], EVENT)])
def test_pairs_of_numbers_fill_every_strip_and_square_once(fill, purpose):
    """The first two dimensions are a (0, 12, 2)-net: a point in each of 4096 boxes, of any shape."""
    block = words(fill, 5, 0, purpose)
    u = columns(block[:, 0], block[:, 2])
    for cells in boxes(2, 12):
        assert (occupancy(u, cells) == 1).all()


def test_the_third_number_of_an_event_is_stratified_as_well():
    block = words(fill_events, 5, 3, EVENT)
    u = columns(block[:, 0], block[:, 2], block[:, 3])
    for cells in ((1, 1, 4096), (4096, 1, 1), (1, 4096, 1)):
        assert (occupancy(u, cells) == 1).all()
    assert occupancy(u, (16, 16, 16)).max() <= 4


BLOCKS = [
    (fill_births, 0, POSITION), (fill_births, 0, AIM), (fill_births, 0, DIRECTION), (fill_births, 1, SPEED),
    (fill_births, 2, POSITION), (fill_strata, 0, POSITION), (fill_events, 0, PATH), (fill_events, 7, EVENT),
]  # fmt: skip


@pytest.mark.parametrize("fill, event, purpose", BLOCKS)
def test_the_words_of_a_history_are_uniform_over_scramblings(fill, event, purpose):
    """One history in 2^14 batches, by its words' first and by later digits."""
    found = np.concatenate([words(fill, batch, event, purpose, 1, 1234) for batch in range(1 << 14)])
    for shift in (29, 14):
        assert_pairs_are_even(found, shift)


def test_copies_of_a_history_have_numbers_of_their_own():
    """Told apart by all 56 bits of their number: copies that share the lower 32 still differ."""
    copies = [COPY ^ (k << 33) for k in range(1 << 13)]
    assert_pairs_are_even(
        np.concatenate([words(fill_events, 0, 4, EVENT, 1, number) for number in copies]), 29
    )


@pytest.mark.parametrize("fill", FILLS)
def test_two_histories_are_independent_beyond_what_their_net_asks_for(fill):
    """Points 8 and 12 of 16 share a cell of the first number: whether they share its next digits is a coin's toss."""
    pairs = []
    for batch in range(1 << 13):
        block = words(fill, batch, 0, POSITION, 2, 8)
        pairs.append(block[:, 0])
    one, other = np.array(pairs).T
    together = (one >> np.uint64(27) ^ other >> np.uint64(27)).astype(np.int64)
    digits = ((one >> np.uint64(20)) & np.uint64(15)).astype(np.int64)
    others = ((other >> np.uint64(20)) & np.uint64(15)).astype(np.int64)
    assert_follows(np.bincount(16 * digits + others, minlength=256), np.full(256, 1 / 256), FALSE_ALARM)
    if fill is fill_births:
        assert (together >> 4 != 0).all()  # neighbours lie in opposite halves


STREAMS = {
    "another purpose, by itself": (fill_strata, 0, 0, DIRECTION),
    "an event": (fill_events, 0, 0, EVENT),
    "the next event": (fill_events, 0, 1, EVENT),
    "a flight": (fill_events, 0, 0, PATH),
    "another detector": (fill_events, 0, 1 << 24, EXPECT),
    "a shadow ray": (fill_events, 0, 0, SHADOW),
    "a second try": (fill_events, 0, 0, EVENT | 1 << 8),
}


def score(found):
    """Means over runs, in their standard errors."""
    return found.mean(axis=0) / (found.std(axis=0, ddof=1) / math.sqrt(len(found)))


@pytest.mark.parametrize("name", STREAMS)
def test_blocks_know_nothing_of_one_another(name):
    """Numbers of the same histories in two blocks: products of their deviations vanish in the mean over scramblings."""
    fill, batch, event, purpose = STREAMS[name]
    runs, points = 1024, 256
    found = []
    for run in range(runs):
        seed = (run, 5)  # of both
        first = words(fill_births, 0, 0, POSITION, points, 0, seed)
        second = words(fill, batch, event, purpose, points, 0, seed)
        u, v = (columns(block[:, 0], block[:, 2], block[:, 3]) - 0.5 for block in (first, second))
        found.append(12 * u.T @ v / points)
    found = np.array(found)
    limit = -ndtri(FALSE_ALARM / 2 / 9)
    assert np.abs(score(found)).max() <= limit
    assert score(found**2 * points - 1).max() <= limit  # a nested shuffle alone would leave 1.6 times as much


def test_joint_dimensions_are_those_of_one_point():
    """No two blocks of a birth share dimensions, but for an aim and an expectation, which never meet."""
    blocks = [(0, p) for p in (POSITION, AIM, DIRECTION, DEPTH, CLOCK, SPEED)]
    blocks += [(1, p) for p in (AIM, SPEED, DEPTH)]
    assert sorted(pair_of.py_func(*block) for block in blocks) == list(range(len(PAIRS)))
    assert pair_of.py_func(0, EXPECT) == pair_of.py_func(0, AIM)
    assert pair_of.py_func(2, POSITION) == pair_of.py_func(0, SHADOW) == NOT_JOINT


def test_numbers_have_52_even_bits():
    block = words(fill_births)
    u = np.array([uniform(*word) for word in block[:, :2]])
    assert ((u >= 0) & (u < 1)).all()
    assert len(set((u * 2.0**52 % 2.0**20).tolist())) > POINTS - 30  # of 2^20 values
    later = np.array([later_digits.py_func(np.uint64(k), np.uint64(7)) for k in range(POINTS)], np.uint64)
    assert_follows(
        np.bincount((later >> np.uint64(26)).astype(np.int64), minlength=64), np.full(64, 1 / 64), FALSE_ALARM
    )
    assert len(set(later.tolist())) >= POINTS - 2


def test_words_are_a_pure_function_of_what_they_are_numbered_by():
    """Each of seed, batch, event, purpose and history changes them; the place in a loop does not."""
    base = words(fill_events, 3, 2, EVENT)
    np.testing.assert_array_equal(words(fill_events, 3, 2, EVENT, points=10, first=90), base[90:100])
    for other in (
        words(fill_events, 4, 2, EVENT),
        words(fill_events, 3, 3, EVENT),
        words(fill_events, 3, 2, PATH),
        words(fill_events, 3, 2, EVENT, seed=(SEED[0] + 1, SEED[1])),
        words(fill_events, 3, 2, EVENT, seed=(SEED[0], SEED[1] + 1)),
        words(fill_events, 3, 2, EVENT, first=POINTS),
    ):
        assert (other != base).mean() > 0.99
