"""Copies of histories have numbers of their own; splitting divides weights among them, and thins out what is light.

Passes are driven by themselves.  Each judgement fails right code in one of 10^6 seeds; beside each is a fault that it rejects.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from numba import njit
from scipy.special import ndtri

from tests.driven import Lanes
from tests.free_flights import FALSE_ALARM, worst
from transport.compile import layout
from transport.engine.bundle import LANES
from transport.engine.passes import collisions, variance_reduction
from transport.engine.passes.bank import number_of_copy as bank_number


@njit
def numbers_of_copies(parents, events, places):
    return np.array([bank_number(h, e, p) for h in parents for e in events for p in places])


def test_copies_have_numbers_of_their_own():
    """10^6 copies of histories, and of copies: none twice, none that of a birth, 55 bits that are fair coins."""
    events, places = np.array([0, 1, 2, 63, 1 << 20]), np.array([0, 1, 2, 61, 62])
    first = numbers_of_copies(np.arange(20_000), events, places)
    numbers = np.concatenate([first, numbers_of_copies(first[::25], events, places)])
    assert len(np.unique(numbers)) == len(numbers) == 1_000_000
    assert numbers.min() >= 1 << 55 and numbers.max() < 1 << 56
    bits = (2 * ((numbers[::4, None] >> np.arange(55)) & 1) - 1).astype(np.float32)
    pairs = (bits.T @ bits)[np.triu_indices(55, 1)]
    assert worst(np.r_[bits.sum(axis=0), pairs] / math.sqrt(len(bits))) < 1
    beside = (bits[1:].T @ bits[:-1]).ravel() / math.sqrt(len(bits))
    assert worst(beside) < 1
    with pytest.raises(AssertionError):  # numbers that are not mixed
        plain = (2 * ((np.arange(len(bits))[:, None] >> np.arange(55)) & 1) - 1).astype(np.float32)
        assert worst(plain.sum(axis=0) / math.sqrt(len(bits))) < 1


def weighed(ratio, seed=1, gain=1e6, z=0.0, **fields):
    """Lanes of that weight over the one to have at z, after the pass, and the importance there."""
    table = {"kz": math.log(gain), "most": math.log(gain)}
    importance = math.exp(min(max(z, 0.0), 1.0) * math.log(gain))
    lanes = Lanes(seed=seed, z=z, cut=1, weight=ratio * 0.5 / importance, birth=0.5, **fields)
    lanes.run(variance_reduction.split_or_roulette, **table)
    return lanes, 0.5 / importance


@pytest.mark.parametrize(("gain", "z"), [(2.0, 1.0), (1e3, 0.5), (1e12, 1.0), (1e12, -3.0), (1e6, 7.0)])
def test_splitting_divides_a_weight_among_its_copies(gain, z):
    for ratio in (2.0 + 1e-9, 3.7, 63.9, 1e4):
        lanes, wanted = weighed(ratio, gain=gain, z=z)
        many = lanes["copies"][0] + 1
        assert many == min(math.floor(ratio), 64)
        np.testing.assert_allclose(lanes["weight"] * many, ratio * wanted, rtol=1e-12)
        assert 1 <= lanes["weight"][0] / wanted < 2 or many == 64
        assert abs(lanes.gained(layout.ROULETTE)) <= LANES * (ratio * wanted * 2.0**-52 + many * 2.0**-62)
    for ratio in (0.5 + 1e-9, 1.0, 2.0 - 1e-9):
        lanes, wanted = weighed(ratio, gain=gain, z=z)
        assert (lanes["copies"] == 0).all() and lanes.gained(layout.ROULETTE) == 0
        np.testing.assert_allclose(lanes["weight"], ratio * wanted, rtol=1e-12)


@pytest.mark.parametrize("ratio", [0.49, 0.1, 1e-3])
def test_thinning_out_keeps_the_expectation_and_tells_the_ledger(ratio):
    alive, rounds = 0, 300
    for seed in range(rounds):
        lanes, wanted = weighed(ratio, seed=seed, gain=100.0, z=0.25)
        lives = lanes["weight"] > 0
        np.testing.assert_allclose(lanes["weight"][lives], wanted, rtol=1e-12)
        taken = LANES * ratio * wanted - lanes["weight"].sum()
        assert lanes.gained(layout.ROULETTE) == pytest.approx(taken, rel=1e-9, abs=1e-12)
        alive += lives.sum()
    draws = rounds * LANES
    limit = -ndtri(FALSE_ALARM / 2) * math.sqrt(draws * ratio * (1 - ratio))
    assert abs(alive - draws * ratio) < limit < draws * ratio


def test_what_has_met_a_surface_or_waits_is_not_weighed():
    lanes = Lanes(cut=0, weight=1e3, birth=1.0)
    lanes.run(variance_reduction.split_or_roulette, kz=1.0, most=1.0)
    assert (lanes["weight"] == 1e3).all() and (lanes["copies"] == 0).all()


def test_a_station_is_no_collision():
    lanes = Lanes(flies=1, distance=np.where(np.arange(LANES) % 2, 5.0, 0.01), uz=1.0)
    lanes.run(variance_reduction.cut_flight, kz=variance_reduction.LN_2 / 0.1, most=1e3)
    np.testing.assert_allclose(lanes["distance"], np.where(np.arange(LANES) % 2, 0.1, 0.01), rtol=1e-12)
    lanes.run(collisions.collide).run(variance_reduction.revoke_station_collisions)
    assert (lanes["collides"] == (np.arange(LANES) % 2 == 0)).all()
    assert (lanes["cut"] == 1).all() and int(lanes.bundle["collisions"][0]) == LANES // 2
