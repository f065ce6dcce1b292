"""Free paths: their law, their random numbers, what they leave alone, and collisions at their ends.

Passes are driven by themselves.  Each judgement fails right code in one of 10^6 seeds; beside each is a fault that it rejects.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.agreement import assert_follows
from tests.driven import Lanes
from tests.free_flights import (
    COLLISION_BITS,
    FALSE_ALARM,
    PATH_BITS,
    ROUNDS,
    WORDS,
    coins,
    draw_only,
    flights,
    worst,
)
from transport.compile import layout
from transport.engine.bundle import LANES
from transport.engine.passes import collisions, variance_reduction


@pytest.fixture(scope="module")
def drawn():
    return flights(start=np.linspace(0, 1, LANES), mfp=np.where(np.arange(LANES) % 2, 1.0, 1e-3))


def test_every_bit_of_a_collision_s_numbers_is_a_fair_coin_of_its_own(drawn):
    """Of those that choose what happens (u0) and the azimuth (u1); whatever the path was."""
    alone, pairs = coins(*drawn)
    assert worst(alone) < 1
    assert worst(pairs) < 1


def test_a_word_that_spills_over_into_another_is_seen(drawn):
    """Planted: the lower word of the path OR-ed onto bits of u0, as `w1 << 20` without a mask does."""
    path, u0, u1 = drawn
    low = np.floor(-np.expm1(-path) * 2.0**PATH_BITS).astype(np.int64) & 0xFFF
    spilt = (np.floor(u0 * 2.0**COLLISION_BITS).astype(np.int64) | low << 8) * 2.0**-COLLISION_BITS
    alone, pairs = coins(path, spilt, u1)
    assert worst(alone) > 10
    assert worst(pairs) > 10


def exponential_cells(cells=64):
    """Edges of equal probability, the last of them cut into ten octaves of survival."""
    survival = np.r_[1 - np.arange(cells) / cells, 0.5 ** np.arange(1, 8) / cells, 0.0]
    return -np.log(np.maximum(survival, 1e-300)), -np.diff(survival)


@pytest.mark.parametrize(
    "fly", [collisions.sample_free_path, variance_reduction.sample_free_or_forced_path], ids=lambda p: p.name
)
def test_free_paths_follow_the_exponential_law(fly):
    path = flights(ROUNDS, fly, start=np.linspace(-1, 1, LANES), mfp=np.geomspace(1e-3, 1e3, LANES))[0]
    edges, probabilities = exponential_cells()
    assert_follows(np.histogram(path, edges)[0], probabilities, FALSE_ALARM)
    with pytest.raises(AssertionError):  # an extinction 3 % too large
        assert_follows(np.histogram(path * 0.97, edges)[0], probabilities, FALSE_ALARM)
    assert path.min() > 0


def test_what_waits_is_dead_or_meets_nothing_is_left_alone():
    """A lane that met a surface, one that left, one of weight 0: neither flies nor uses up a number."""
    lanes = Lanes(distance=0.5)
    lanes["hit"] = np.where(np.arange(LANES) % 4 == 0, 1, 0)
    lanes["distance"] = np.where(np.arange(LANES) % 4 == 1, np.inf, 0.5)
    lanes["weight"] = np.where(np.arange(LANES) % 4 == 2, 0.0, 1.0)
    for step in (collisions.sample_free_path, variance_reduction.sample_free_or_forced_path):
        before = {name: lanes[name] for name in ("distance", "event", "start", "x")}
        lanes.run(step)
        still = np.arange(LANES) % 4 != 3
        assert (lanes["flies"] == ~still).all()
        assert (lanes["event"] - before["event"] == ~still).all()
        assert (lanes["distance"] == before["distance"])[still].all()
        lanes["distance"] = before["distance"]


def test_in_vacuum_a_flight_has_no_end():
    lanes = Lanes(mfp=np.inf).run(collisions.sample_free_path)
    assert np.isinf(lanes["distance"]).all()
    assert (lanes.run(collisions.collide)["collides"] == 0).all()
    assert (lanes["z"] == 0).all() and int(lanes.bundle["collisions"][0]) == 0


def test_a_collision_is_at_the_end_of_its_path_and_only_there():
    lanes = Lanes(start=0.25, x=1.0, ux=0.6, uz=0.8, sheet=5)
    lanes.run(collisions.sample_free_path)
    path = lanes["distance"]
    lanes["hit"] = np.where(np.arange(LANES) % 3 == 0, 9, 0)
    lanes.run(collisions.collide)
    collided = lanes["hit"] == 0
    way = np.where(collided, path - layout.COLLISION_CLEARANCE, 0.0)
    np.testing.assert_allclose(lanes["x"], 1 + 0.6 * way, rtol=1e-15)
    np.testing.assert_allclose(lanes["z"], 0.8 * way, rtol=1e-15)
    assert (lanes["collides"] == collided).all()
    assert (lanes["start"] == np.where(collided, 0.0, 0.25)).all()
    assert (lanes["sheet"] == np.where(collided, 0, 5)).all()
    assert int(lanes.bundle["collisions"][0]) == collided.sum() == int(lanes.bundle["colliding"][0])


@pytest.mark.parametrize("word", WORDS.values(), ids=WORDS)
@pytest.mark.parametrize("mfp", [1e-300, 1.0, 1e300, math.inf])
def test_extreme_draws_make_finite_paths(word, mfp, monkeypatch):
    """Plain Python with a stream of zeros, and of ones: no path is 0 or longer than 37 mean ones; none in vacuum ends."""
    draw_only(word, monkeypatch)
    for step in (collisions.sample_free_path, variance_reduction.sample_free_or_forced_path):
        lanes = Lanes(mfp=mfp).run_plainly(step)
        depth = lanes["distance"] / mfp if 1e-200 < mfp < math.inf else lanes["distance"]
        assert (np.isinf(depth) if mfp == math.inf else (depth > 0) & (depth < 37.5)).all()
        for name in ("u0", "u1"):
            assert ((lanes[name] >= 0) & (lanes[name] < 1)).all()
        lanes.run_plainly(collisions.collide)
        assert np.isfinite(lanes["z"]).all()
