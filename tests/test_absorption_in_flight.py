"""What a medium takes from a flight, by chance and by weight, and roulette with what is left.

Passes are driven by themselves.  Each judgement fails right code in one of 10^6 seeds; beside each is a fault that it rejects.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ndtri

from tests.agreement import assert_follows
from tests.driven import Lanes
from tests.free_flights import FALSE_ALARM, LAST
from transport.compile import layout
from transport.engine.bundle import LANES
from transport.engine.passes import collisions, variance_reduction


@pytest.mark.parametrize("survival", [0.0, 1e-3, 0.2, 0.9, 1 - 1e-9, 1.0])
def test_absorption_by_chance_leaves_the_albedo_and_a_number_as_good_as_new(survival):
    died, left = 0, []
    for seed in range(200):
        lanes = Lanes(seed=seed, collides=1, survival=survival, weight=0.75)
        lanes["u0"] = np.random.default_rng(seed).random(LANES)
        lanes.run(collisions.absorb_at_collisions)
        dies = lanes["weight"] == 0
        assert (lanes["collides"] == ~dies).all()
        np.testing.assert_allclose(lanes.scored, np.where(dies, 0.75, 0.0), rtol=1e-15)
        died += dies.sum()
        left.append(lanes["u0"][~dies])
    left, draws = np.concatenate(left), 200 * LANES
    spread = math.sqrt(draws * survival * (1 - survival))
    assert abs(died - draws * (1 - survival)) <= -ndtri(FALSE_ALARM / 2) * spread
    if survival >= 0.2:
        assert_follows(np.histogram(left, 50, (0, 1))[0], np.full(50, 0.02), FALSE_ALARM)
        if survival == 0.2:
            with pytest.raises(AssertionError):  # the number that decided, used again
                assert_follows(np.histogram(left * survival, 50, (0, 1))[0], np.full(50, 0.02), FALSE_ALARM)


@pytest.mark.parametrize("least", [1e-12, 1e-5], ids=["beside thin ways", "no thin way"])
def test_weights_fall_exponentially_along_the_way_and_nothing_is_lost(least):
    depths = np.geomspace(least, 1e3, LANES)
    lanes = Lanes(start=0.5, distance=0.5 + depths, sigma_a=1.0, flies=1, weight=0.8, mfp=1.0)
    way = lanes["distance"] - 0.5
    lanes.run(collisions.attenuate)
    np.testing.assert_allclose(lanes["weight"], 0.8 * np.exp(-way), rtol=1e-14, atol=1e-300)
    np.testing.assert_allclose(lanes["weight"] + lanes.scored, 0.8, rtol=1e-15)
    for change in ({"flies": 0}, {"sigma_a": 0.0}, {"sigma_a": 0.0, "distance": np.inf}):
        lanes = Lanes(**{"distance": 2.0, "sigma_a": 1.0, "flies": 1, "weight": 0.8} | change)
        assert (lanes.run(collisions.attenuate)["weight"] == 0.8).all() and (lanes.scored == 0).all()
    assert (Lanes(distance=np.inf, sigma_a=1.0, flies=1).run(collisions.attenuate)["weight"] == 0).all()


GAMES = {  # where it is played, what says so, and the number that decides
    "in flight": (variance_reduction.play_roulette_in_flight, {"collides": 1}, "u0"),
    "at walls": (variance_reduction.play_roulette, {"hit": 1}, "u2"),
}


@pytest.mark.parametrize("game", GAMES.values(), ids=GAMES)
@pytest.mark.parametrize(("threshold", "level"), [(1e-3, 1e-2), (0.05, 0.5), (0.5, 1.0), (1.0, 1.0)])
def test_roulette_keeps_the_expectation_and_tells_the_ledger(threshold, level, game):
    """Of 10^5 weights; those above the threshold are let alone, survivors have their level."""
    play, where, number = game
    before, after, numbers = [], [], []
    for seed in range(400):
        random = np.random.default_rng(seed)
        birth = random.choice([1.0, 1e-3, 0.37], LANES)
        weight = birth * random.random(LANES) * (1 if threshold > 0.01 else 2 * threshold)
        lanes = Lanes(weight=weight, birth=birth, **where, **{number: random.random(LANES)})
        lanes.run(play, threshold=threshold, level=level)
        played = weight < threshold * birth
        assert (lanes["weight"] == weight)[~played].all()
        left = (lanes["weight"] / birth)[played] / level
        assert ((left == 0) | (abs(left - 1) < 1e-15)).all()
        assert (lanes["collides"] == (lanes["weight"] > 0) * where.get("collides", 0)).all()
        assert lanes.gained(layout.ROULETTE) == pytest.approx(
            (weight - lanes["weight"]).sum(), rel=1e-9, abs=1e-12
        )
        before.append((weight / birth)[played])
        after.append((lanes["weight"] / birth)[played])
        numbers.append(lanes["u0"][played & (lanes["weight"] > 0)])
    before, after, numbers = (np.concatenate(part) for part in (before, after, numbers))
    spread = math.sqrt((before * (level - before)).sum())
    assert abs((after - before).sum()) < -ndtri(FALSE_ALARM / 2) * spread
    assert abs((after - np.sqrt(before)).sum()) > -ndtri(FALSE_ALARM / 2) * spread  # another chance is seen
    if play is variance_reduction.play_roulette_in_flight:  # where it serves again
        assert_follows(np.histogram(numbers, 20, (0, 1))[0], np.full(20, 0.05), FALSE_ALARM)


@pytest.mark.parametrize("play", [play for play, _, _ in GAMES.values()], ids=GAMES)
def test_what_meets_nothing_is_not_played_for(play):
    lanes = Lanes(collides=0, hit=0, weight=1e-6, u0=0.5, u2=0.5).run(play, threshold=0.5, level=1.0)
    assert (lanes["weight"] == 1e-6).all() and lanes.gained(layout.ROULETTE) == 0


@pytest.mark.parametrize("survival", [0.0, 1e-300, 0.5, 1.0])
@pytest.mark.parametrize("u", [0.0, 2.0**-52, 0.5, LAST])
def test_extreme_draws_absorb_or_leave_a_number_below_one(survival, u):
    with np.errstate(divide="ignore", invalid="ignore"):
        lanes = Lanes(collides=1, survival=survival, u0=u).run_plainly(collisions.absorb_at_collisions)
    assert ((lanes["u0"] >= 0) & (lanes["u0"] < 1)).all()
    assert ((lanes["weight"] > 0) == (u < survival)).all()


@pytest.mark.parametrize("u", [0.0, LAST])
def test_extreme_draws_in_roulette(u):
    for weight in (5e-324, 1e-300, 0.25, 0.5 - 2.0**-54):
        lanes = Lanes(collides=1, weight=weight, u0=u)
        lanes.run_plainly(variance_reduction.play_roulette_in_flight, threshold=0.5, level=1.0)
        assert np.isin(lanes["weight"], (0.0, 1.0)).all()
        assert ((lanes["u0"] >= 0) & (lanes["u0"] < 1)).all()
