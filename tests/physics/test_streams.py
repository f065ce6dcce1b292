"""The generator is Philox4x32-10, of whose counter and key every coordinate of a draw is a part; its uniforms are uniform.

All draws are fixed by their counters: a test that passes once passes always.
"""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from tests.agreement import assert_follows
from transport.physics.device import ARITHMETIC
from transport.physics.streams import event_words, philox, random_words, short_uniform, uniform

FALSE_ALARM = 1e-5
ORIGIN = (0, 3, 5, 2, 20240607, 11)  # history, batch, event, purpose, seed
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
        words[k, 0], words[k, 1], words[k, 2], words[k, 3] = philox(c[0], c[1], c[2], c[3], key[0], key[1])
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


def by_reference(table):
    """The words at these places, by the reference."""
    return np.stack(reference(*table.astype(np.uint64).T), axis=-1)


@pytest.mark.parametrize(("counter", "key", "answer"), KNOWN_ANSWERS)
def test_known_answers_of_random123(counter, key, answer):
    counter, key, answer = ([int(word, 16) for word in text.split()] for text in (counter, key, answer))
    assert list(reference(*counter, *key)) == answer
    assert blocks(np.array([counter], np.uint64), np.array([key], np.uint64)).tolist() == [answer]
    assert list(reference(*counter, *key, rounds=9)) != answer


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


def test_uniforms_fill_lines_and_squares_evenly():
    """Chi-square over 1024 cells of each uniform, and 32 x 32 of pairs: of one block, and of histories in a row."""
    histories = np.tile(np.array(ORIGIN, np.int64), (1 << 18, 1))
    histories[:, 0] = np.arange(len(histories))
    stream = uniforms_of(words_at(histories))
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
