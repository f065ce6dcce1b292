"""The generator is Philox4x32-10, its uniforms are uniform, and no two streams know of each other.

All draws are fixed by their counters: a test that passes once passes always.  Rates of false alarms are those over all
seeds; together they stay below 1e-4.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numba import njit
from scipy.special import ndtri

from tests.agreement import assert_follows
from transport.physics.device import ARITHMETIC
from transport.physics.streams import event_words, random_words, short_uniform, uniform

FALSE_ALARM = 1e-5
DRAWS = 1 << 18
COORDINATES = "history", "batch", "event", "purpose", "seed_low", "seed_high"
ORIGIN = (0, 3, 5, 2, 20240607, 11)  # of the streams that are compared
WORD = (1 << 32) - 1
# Random123 (Salmon et al. 2011), kat_vectors: counter, key -> words of philox4x32-10.
KNOWN_ANSWERS = [
    ("00000000 00000000 00000000 00000000", "00000000 00000000", "6627e8d5 e169c58d bc57ac4c 9b00dbd8"),
    ("ffffffff ffffffff ffffffff ffffffff", "ffffffff ffffffff", "408f276d 41c83b0e a20bc7c6 6d5451fd"),
    ("243f6a88 85a308d3 13198a2e 03707344", "a4093822 299f31d0", "d16cfe09 94fdcceb 5001e420 24126ea1"),
]


def reference(c0, c1, c2, c3, key0, key1, rounds=10):
    """Philox4x32 from its paper, for Python integers or arrays of uint64."""
    for n in range(rounds):
        k0, k1 = (key0 + n * 0x9E3779B9) & WORD, (key1 + n * 0xBB67AE85) & WORD
        p, q = 0xD2511F53 * c0, 0xCD9E8D57 * c2
        c0, c1, c2, c3 = (q >> 32) ^ c1 ^ k0, q & WORD, (p >> 32) ^ c3 ^ k1, p & WORD
    return c0, c1, c2, c3


@njit(**ARITHMETIC)
def blocks(counters, keys):
    words = np.empty_like(counters)
    for k in range(len(counters)):
        c, key = counters[k], keys[k]
        words[k, 0], words[k, 1], words[k, 2], words[k, 3] = random_words(
            c[0], c[1], c[2], c[3], key[0], key[1]
        )
    return words


def drawn_at(draw):
    """The four words at each of many places."""

    @njit(**ARITHMETIC)
    def at(places):
        words = np.empty((len(places), 4), np.uint64)
        for k in range(len(places)):
            p = places[k]
            words[k, 0], words[k, 1], words[k, 2], words[k, 3] = draw(p[0], p[1], p[2], p[3], p[4], p[5])
        return words

    return at


words_at, event_words_at = drawn_at(random_words), drawn_at(event_words)


@njit(**ARITHMETIC)
def uniforms_of(words):
    """Two 52-bit and four short uniforms of each block."""
    u = np.empty((len(words), 6))
    for k in range(len(words)):
        w = words[k]
        u[k, 0], u[k, 1] = uniform(w[0], w[1]), uniform(w[2], w[3])
        for i in range(4):
            u[k, 2 + i] = short_uniform(w[i])
    return u


def places(**moved) -> np.ndarray:
    """Coordinates of DRAWS histories in a row, some of the other coordinates moved away from ORIGIN's."""
    table = np.tile(np.array(ORIGIN, np.int64), (DRAWS, 1))
    table[:, 0] = np.arange(DRAWS)
    for name, step in moved.items():
        table[:, COORDINATES.index(name)] += step
    return table


def by_reference(table, rounds=10):
    """The words at these places, by the reference."""
    return np.stack(reference(*table.astype(np.uint64).T, rounds=rounds), axis=-1)


def score(a, b):
    """Standard normal score of the correlation of two samples of independent uniforms."""
    return 12 * ((a - 0.5) * (b - 0.5)).sum() / np.sqrt(len(a))


@pytest.fixture(scope="module")
def stream():
    return uniforms_of(words_at(places()))


@pytest.mark.parametrize(("counter", "key", "answer"), KNOWN_ANSWERS)
def test_known_answers_of_random123(counter, key, answer):
    counter, key, answer = ([int(word, 16) for word in text.split()] for text in (counter, key, answer))
    assert list(reference(*counter, *key)) == answer
    assert blocks(np.array([counter], np.uint64), np.array([key], np.uint64)).tolist() == [answer]
    assert list(reference(*counter, *key, rounds=9)) != answer


def test_a_thousand_blocks_are_those_of_plain_python():
    rng = np.random.default_rng(1)
    counters, keys = (rng.integers(0, 1 << 32, (1000, n), np.uint64) for n in (4, 2))
    counters[:32, 0], counters[32:64, 2], keys[:32, 1] = WORD, 0, WORD
    plain = [reference(*map(int, c), *map(int, k)) for c, k in zip(counters, keys, strict=True)]
    assert blocks(counters, keys).tolist() == [list(words) for words in plain]


def test_history_batch_event_purpose_and_seed_are_counter_and_key():
    rng = np.random.default_rng(2)
    table = rng.integers(0, 1 << 32, (1000, 6)).astype(np.int64)
    assert (words_at(table) == by_reference(table)).all()


def test_all_56_bits_of_the_number_of_a_copy_are_in_the_counter():
    """Of 56 the upper 24 go beside the purpose: copies that share the lower 32 have blocks of their own."""
    rng = np.random.default_rng(3)
    table = rng.integers(0, 1 << 32, (1000, 6)).astype(np.int64)
    table[:, 3] &= 0xFF
    assert (event_words_at(table) == words_at(table)).all()  # of a history born, which has no upper bits
    upper = rng.integers(1, 1 << 24, 1000)
    copies, folded = (
        table + upper[:, None] * [1 << 32, 0, 0, 0, 0, 0],
        table ^ upper[:, None] * [0, 0, 0, 256, 0, 0],
    )
    assert (event_words_at(copies) == by_reference(folded)).all()
    assert len(np.unique(np.concatenate([event_words_at(copies), words_at(table)]), axis=0)) == 2000


def test_uniforms_have_52_bits_and_lie_within_the_unit_interval():
    """Each of the 52 bits is set half of the time, and no finer one ever."""
    extreme = uniforms_of(np.array([[0, 0, 0, 0], [WORD] * 4, [0, WORD, WORD, 0]], np.uint64))
    assert extreme[0].tolist() == [0.0, 0.0] + [2.0**-33] * 4
    assert extreme[1].tolist() == [1 - 2.0**-52] * 2 + [1 - 2.0**-33] * 4
    assert extreme[2, :2].tolist() == [2.0**-32 - 2.0**-52, 1 - 2.0**-32]
    words = np.zeros((64, 4), np.uint64)
    words[32:, 0] = words[:32, 1] = 1 << np.arange(32)
    assert uniforms_of(words)[:, 0].tolist() == [0.0] * 12 + [2.0**k for k in range(-52, 0)]


def test_uniforms_have_the_mean_and_the_variance_of_their_law(stream):
    """Of the 6 x 3 figures none is beyond 5 sigma: one in 1e5 for right code.  A mean off by 0.01 is."""
    assert ((stream >= 0) & (stream < 1)).all()
    assert (stream[:, 2:] > 0).all()
    v, n = stream - 0.5, len(stream)
    assert np.abs(v.mean(axis=0)).max() < 5 * np.sqrt(1 / 12 / n)
    assert np.abs((v**2).mean(axis=0) - 1 / 12).max() < 5 * np.sqrt(1 / 180 / n)
    assert np.abs((v**3).mean(axis=0)).max() < 5 * np.sqrt(1 / 448 / n)
    assert np.abs((v + 0.01).mean(axis=0)).min() > 5 * np.sqrt(1 / 12 / n)


def test_uniforms_fill_lines_and_squares_evenly(stream):
    """Chi-square over 1024 cells of each uniform, and 32 x 32 of pairs: of one block, and of histories in a row."""
    rate = FALSE_ALARM / 10
    for column in stream.T:
        assert_follows(
            np.bincount((column * 1024).astype(int), minlength=1024), np.full(1024, 1 / 1024), rate
        )
    first, second = stream[:, 0], stream[:, 1]
    for a, b in ((first, second), (first[::2], first[1::2]), (second[::2], first[1::2])):
        counts = np.histogram2d(a, b, 32, [[0, 1], [0, 1]])[0]
        assert_follows(counts, np.full(1024, 1 / 1024), rate)
    with pytest.raises(AssertionError, match="chi-square"):
        assert_follows(np.histogram2d(first, first, 32, [[0, 1], [0, 1]])[0], np.full(1024, 1 / 1024), rate)


def test_neighbouring_streams_are_independent(stream):
    """Seeds, batches, events, purposes and histories 1 or a power of two apart have no correlation.

    6 coordinates x 3 steps x 4 pairs of uniforms; the largest of 72 normal scores stays below the limit in all but
    1e-5.  A correlation of 0.02 would be caught.
    """
    moves = list(itertools.product(COORDINATES, (1, 2, 1 << 20)))
    limit = -ndtri(FALSE_ALARM / (2 * 4 * len(moves)))
    for name, step in moves:
        other = uniforms_of(words_at(places(**{name: step})))
        for i, j in ((0, 0), (1, 1), (0, 1), (1, 0)):
            z = score(stream[:, i], other[:, j])
            assert abs(z) < limit, f"{name} + {step}, uniforms {i} and {j}: z = {z:.1f}"


def test_a_stream_that_ignores_its_purpose_or_does_too_few_rounds_is_caught():
    """Planted wrong answers: the same words for all purposes, and 2 rounds instead of 10."""
    deaf = uniforms_of(by_reference(places(purpose=-ORIGIN[3])))
    assert abs(score(deaf[:, 0], deaf[:, 0])) > 100
    few, other = (uniforms_of(by_reference(places(purpose=step), rounds=2)) for step in (0, 1))
    assert np.abs([score(few[:, i], other[:, i]) for i in (0, 1)]).max() > 10


def test_one_flipped_bit_of_counter_or_key_flips_half_of_the_words():
    """Each of the 6 x 32 input bits flips each of 128 output bits in half of 256 blocks, within 6.5 sigma.

    24 576 binomials of 256: one beyond 8 + 128 in 1e-6 for right code.  Two rounds fail.
    """
    rng = np.random.default_rng(3)
    table = rng.integers(0, 1 << 32, (256, 6)).astype(np.int64)
    flipped = np.repeat(table[None], 6 * 32, axis=0).reshape(6, 32, 256, 6)
    for coordinate, bit in itertools.product(range(6), range(32)):
        flipped[coordinate, bit, :, coordinate] ^= 1 << bit

    def shares(words):
        """In how many of the blocks each output bit changes, for each input bit."""
        before, after = words(table), words(flipped.reshape(-1, 6)).reshape(6 * 32, 256, 4)
        bits = np.unpackbits((before ^ after).view(np.uint8).reshape(6 * 32, 256, 4, 8)[..., :4], axis=-1)
        return bits.sum(axis=1, dtype=int)

    assert np.abs(shares(words_at) - 128).max() <= 52
    assert np.abs(shares(lambda t: by_reference(t, rounds=2)) - 128).max() > 52
