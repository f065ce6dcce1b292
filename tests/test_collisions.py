"""What one pass does to a flight in a medium: free paths, forced ones, absorption, scattering, roulette, splitting.

Passes are driven by themselves.  Each judgement fails right code in one of 10^6 seeds; beside each is a fault that it rejects.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from numba import njit
from scipy.special import ndtri

from tests.agreement import assert_follows
from tests.driven import Lanes
from transport.compile import layout
from transport.engine import collisions, forcing, importances, roulette
from transport.engine.bank import number_of_copy as bank_number
from transport.engine.bundle import LANES
from transport.physics import paths

FALSE_ALARM = 1e-6
ROUNDS = 800  # of LANES draws
PATH_BITS, COLLISION_BITS, TURN_BITS = 44, 44, 32  # of the uniforms that are told apart here


def flights(rounds=ROUNDS, fly=collisions.fly, **fields):
    """Paths [mean free paths], u0 and u1 of many flights, one after the other of each lane."""
    lanes = Lanes(**fields)
    found = []
    for _ in range(rounds):
        lanes["distance"], lanes["hit"] = 0.0, 0
        lanes.run(fly)
        path = lanes["distance"] - lanes["start"] - 2 * layout.SLACK
        found.append((path / lanes["mfp"], lanes["u0"], lanes["u1"]))
    return np.concatenate(np.transpose(found, (1, 2, 0)).reshape(3, 1, -1))


def worst(z):
    """How many times the limit of the largest of many normal scores is reached."""
    return np.abs(z).max() / -ndtri(FALSE_ALARM / z.size / 2)


def bits_of(u, count):
    """The upper bits of uniforms, (draws, count) of +1 and -1."""
    words = np.floor(u * 2.0**count).astype(np.int64)
    return (2 * ((words[:, None] >> np.arange(count)) & 1) - 1).astype(np.float32)


def coins(path, u0, u1):
    """Scores of every bit as a fair coin, and of every two bits of unlike numbers as independent ones."""
    parts = [bits_of(-np.expm1(-path), PATH_BITS), bits_of(u0, COLLISION_BITS), bits_of(u1, TURN_BITS)]
    n = math.sqrt(len(path))
    alone = np.concatenate([part.sum(axis=0, dtype=float) / n for part in parts[1:]])
    pairs = [(a.T @ b).ravel() / n for k, a in enumerate(parts) for b in parts[k + 1 :]]
    return alone, np.concatenate(pairs)


@pytest.fixture(scope="module")
def drawn():
    return flights(start=np.linspace(0, 1, LANES), mfp=np.where(np.arange(LANES) % 2, 1.0, 1e-3))


# ---- free paths ----


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


@pytest.mark.parametrize("fly", [collisions.fly, forcing.fly_or_be_forced], ids=lambda p: p.name)
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
    for step in (collisions.fly, forcing.fly_or_be_forced):
        before = {name: lanes[name] for name in ("distance", "event", "start", "x")}
        lanes.run(step)
        still = np.arange(LANES) % 4 != 3
        assert (lanes["flies"] == ~still).all()
        assert (lanes["event"] - before["event"] == ~still).all()
        assert (lanes["distance"] == before["distance"])[still].all()
        lanes["distance"] = before["distance"]


def test_in_vacuum_a_flight_has_no_end():
    lanes = Lanes(mfp=np.inf).run(collisions.fly)
    assert np.isinf(lanes["distance"]).all()
    assert (lanes.run(collisions.collide)["collides"] == 0).all()
    assert (lanes["z"] == 0).all() and int(lanes.bundle["collisions"][0]) == 0


def test_a_collision_is_at_the_end_of_its_path_and_only_there():
    lanes = Lanes(start=0.25, x=1.0, ux=0.6, uz=0.8, sheet=5)
    lanes.run(collisions.fly)
    path = lanes["distance"]
    lanes["hit"] = np.where(np.arange(LANES) % 3 == 0, 9, 0)
    lanes.run(collisions.collide)
    collided = lanes["hit"] == 0
    way = np.where(collided, path - layout.SLACK, 0.0)
    np.testing.assert_allclose(lanes["x"], 1 + 0.6 * way, rtol=1e-15)
    np.testing.assert_allclose(lanes["z"], 0.8 * way, rtol=1e-15)
    assert (lanes["collides"] == collided).all()
    assert (lanes["start"] == np.where(collided, 0.0, 0.25)).all()
    assert (lanes["sheet"] == np.where(collided, 0, 5)).all()
    assert int(lanes.bundle["collisions"][0]) == collided.sum() == int(lanes.bundle["colliding"][0])


# ---- absorption ----


@pytest.mark.parametrize("survival", [0.0, 1e-3, 0.2, 0.9, 1 - 1e-9, 1.0])
def test_absorption_by_chance_leaves_the_albedo_and_a_number_as_good_as_new(survival):
    died, left = 0, []
    for seed in range(200):
        lanes = Lanes(seed=seed, collides=1, survival=survival, weight=0.75)
        lanes["u0"] = np.random.default_rng(seed).random(LANES)
        lanes.run(collisions.absorb_by_chance)
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


def test_weights_fall_exponentially_along_the_way_and_nothing_is_lost():
    depths = np.geomspace(1e-12, 1e3, LANES)
    lanes = Lanes(start=0.5, distance=0.5 + depths, sigma_a=1.0, flies=1, weight=0.8, mfp=1.0)
    way = lanes["distance"] - 0.5
    lanes.run(collisions.attenuate)
    np.testing.assert_allclose(lanes["weight"], 0.8 * np.exp(-way), rtol=1e-14, atol=1e-300)
    np.testing.assert_allclose(lanes["weight"] + lanes.scored, 0.8, rtol=1e-15)
    for change in ({"flies": 0}, {"sigma_a": 0.0}, {"sigma_a": 0.0, "distance": np.inf}):
        lanes = Lanes(**{"distance": 2.0, "sigma_a": 1.0, "flies": 1, "weight": 0.8} | change)
        assert (lanes.run(collisions.attenuate)["weight"] == 0.8).all() and (lanes.scored == 0).all()
    assert (Lanes(distance=np.inf, sigma_a=1.0, flies=1).run(collisions.attenuate)["weight"] == 0).all()


@pytest.mark.parametrize(("threshold", "level"), [(1e-3, 1e-2), (0.05, 0.5), (0.5, 1.0), (1.0, 1.0)])
def test_roulette_keeps_the_expectation_and_tells_the_ledger(threshold, level):
    """Of 10^5 weights; those above the threshold are let alone, survivors have their level."""
    before, after, numbers = [], [], []
    for seed in range(400):
        random = np.random.default_rng(seed)
        birth = random.choice([1.0, 1e-3, 0.37], LANES)
        weight = birth * random.random(LANES) * (1 if threshold > 0.01 else 2 * threshold)
        lanes = Lanes(collides=1, weight=weight, birth=birth, u0=random.random(LANES))
        lanes.run(roulette.play_roulette_in_flight, threshold=threshold, level=level)
        played = weight < threshold * birth
        assert (lanes["weight"] == weight)[~played].all()
        left = (lanes["weight"] / birth)[played] / level
        assert ((left == 0) | (abs(left - 1) < 1e-15)).all()
        assert (lanes["collides"] == (lanes["weight"] > 0)).all()
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
    assert_follows(np.histogram(numbers, 20, (0, 1))[0], np.full(20, 0.05), FALSE_ALARM)


def test_what_does_not_collide_is_not_played_for():
    lanes = Lanes(collides=0, weight=1e-6, u0=0.5).run(
        roulette.play_roulette_in_flight, threshold=0.5, level=1.0
    )
    assert (lanes["weight"] == 1e-6).all() and lanes.gained(layout.ROULETTE) == 0


# ---- scattering ----


def test_phase_functions_are_chosen_by_medium_and_by_share():
    """Media 0 and 2 have one phase function each, medium 1 a mixture of three."""
    shares = [(1.0, 1), (0.2, 3), (0.5, 3), (1.0, 3), (1.0, 1)]
    laws = np.array([layout.row(layout.PHASE_LAW, share=s, parts=p) for s, p in shares], layout.PHASE_LAW)
    media = np.array([layout.row(layout.MEDIA, phase=n) for n in (1, 2, 5)], layout.MEDIA)
    table = {"rows": media.ctypes.data, "count": 3, "others": laws.ctypes.data, "other_count": 5}
    counts, numbers = np.zeros((3, 6), int), []
    for seed in range(300):
        lanes = Lanes(collides=np.arange(LANES) % 4 != 3, medium=np.arange(LANES) % 3)
        u0 = np.random.default_rng(seed).random(LANES)
        lanes["u0"] = u0
        lanes.run(collisions.choose_phase, **table)
        chosen, still = lanes["collides"], np.arange(LANES) % 4 == 3
        assert (chosen[still] == 0).all() and (lanes["u0"] == u0)[still | (lanes["medium"] != 1)].all()
        np.add.at(counts, (lanes["medium"][~still], chosen[~still]), 1)
        numbers.append(lanes["u0"][~still & (lanes["medium"] == 1)])
    assert counts[0, 1] == counts[0].sum() and counts[2, 5] == counts[2].sum()
    assert_follows(counts[1], [0, 0, 0.2, 0.3, 0.5, 0], FALSE_ALARM)
    assert_follows(np.histogram(np.concatenate(numbers), 20, (0, 1))[0], np.full(20, 0.05), FALSE_ALARM)
    with pytest.raises(AssertionError):  # shares that are not added up
        assert_follows(counts[1], [0, 0, 0.2, 0.5, 0.3, 0], FALSE_ALARM)


SCATTER = [
    (collisions.scatter_isotropically, {}, 0.0, 1 / 3),
    (collisions.scatter_by_henyey_greenstein, {"g": 0.8}, 0.8, 1 / 3 + 2 / 3 * 0.64),
    (collisions.scatter_by_henyey_greenstein, {"g": -0.3}, -0.3, 1 / 3 + 2 / 3 * 0.09),
    (collisions.scatter_by_rayleigh, {}, 0.0, 0.4),
]


@pytest.mark.parametrize(("scatter", "law", "g", "square"), SCATTER, ids=lambda v: getattr(v, "name", None))
def test_scattering_turns_what_collides_by_its_phase_function_and_nothing_else(scatter, law, g, square):
    """Mean cosine and mean square cosine about the old direction (a sign turned round shows), azimuths evenly."""
    old = np.array([0.36, -0.48, 0.8])
    across = np.array([0.8, 0.6, 0.0])
    cosines, turns = [], []
    for seed in range(200):
        lanes = Lanes(
            ux=old[0], uy=old[1], uz=old[2], collides=np.where(np.arange(LANES) % 2, 3, np.arange(LANES) % 5)
        )
        lanes["u0"], lanes["u1"] = np.random.default_rng(seed).random((2, LANES))
        mine = lanes["collides"] == 3
        lanes.run(scatter, number=3, **law)
        assert (lanes.directions[~mine] == old).all()
        new = lanes.directions[mine]
        np.testing.assert_allclose((new**2).sum(axis=1), 1, rtol=4e-15)
        cosines.append(new @ old)
        turns.append(np.arctan2(new @ np.cross(old, across), new @ across) / (2 * math.pi) % 1)
    cosines, turns = np.concatenate(cosines), np.concatenate(turns)
    for values, exact in ((cosines, g), (cosines**2, square)):
        limit = -ndtri(FALSE_ALARM / 2) * values.std() / math.sqrt(len(values))
        assert abs(values.mean() - exact) < limit < 0.02
    assert_follows(np.histogram(turns, 36, (0, 1))[0], np.full(36, 1 / 36), FALSE_ALARM)


# ---- forced collisions ----


@pytest.mark.parametrize("tau", [1e-12, 1e-6, 0.1, 2.0, 40.0])
def test_a_forced_collision_is_as_likely_as_it_would_be_and_where_it_would_be(tau):
    """Of w the share 1 - exp(-tau) flies to a collision before the surface, by the exponential law cut off there."""
    depths, mfp = [], 0.5
    for seed in range(200):
        lanes = Lanes(seed=seed, mfp=mfp, start=-0.5, weight=0.75, ahead=forcing.FRESH)
        lanes.run(forcing.fly_or_be_forced)
        assert np.isinf(lanes["distance"]).all()
        lanes["distance"] = -0.5 + tau * mfp
        way = lanes["distance"] + 0.5
        lanes.run(forcing.force_collision)
        assert (lanes["copies"] == 1).all() and (lanes["ahead"] == forcing.FRESH).all()
        np.testing.assert_allclose(lanes["caught"], -0.75 * np.expm1(-way / mfp), rtol=1e-15)
        np.testing.assert_allclose(lanes["weight"] + lanes["caught"], 0.75, rtol=1e-15)
        assert abs(lanes.gained(layout.ROULETTE)) <= LANES * 2.0**-52
        assert (lanes["path"] > 0).all() and (lanes["path"] <= way).all()
        depths.append(lanes["path"] / way)
    depths, cells = np.concatenate(depths), np.linspace(0, 1, 41)
    through = np.expm1(-tau * cells) / np.expm1(-tau)
    assert_follows(np.histogram(depths, cells)[0], np.diff(through), FALSE_ALARM)
    if tau >= 0.1:
        with pytest.raises(AssertionError):  # evenly along the way
            assert_follows(np.histogram(depths, cells)[0], np.diff(cells), FALSE_ALARM)


def test_nothing_is_forced_in_vacuum_without_a_surface_ahead_or_twice():
    kinds = np.arange(LANES) % 4
    ahead = np.where(kinds == 2, forcing.FREE, forcing.FRESH)
    lanes = Lanes(mfp=np.where(kinds == 0, np.inf, 1.0), ahead=ahead).run(forcing.fly_or_be_forced)
    distance = lanes["distance"]
    lanes["distance"] = np.where(kinds == 3, 1.0, distance)
    lanes.run(forcing.force_collision)
    assert (lanes["copies"] == (kinds == 3)).all()
    assert (lanes["weight"] == 1.0)[kinds != 3].all()
    assert (lanes["ahead"] == np.where(np.isin(kinds, (1, 2)), forcing.FREE, forcing.FRESH)).all()
    assert np.isinf(lanes["distance"])[kinds == 0].all() and np.isfinite(lanes["distance"])[kinds != 0].all()


def test_a_copy_flies_its_own_path_once():
    lanes = Lanes(ahead=0.125).run(forcing.fly_or_be_forced)
    np.testing.assert_allclose(lanes["distance"], 0.125, rtol=1e-12)
    assert (lanes["ahead"] == forcing.FREE).all()
    lanes["distance"], lanes["hit"] = 0.0, 0
    assert len(np.unique(lanes.run(forcing.fly_or_be_forced)["distance"])) == LANES


# ---- copies ----


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


# ---- splitting ----


def weighed(ratio, seed=1, gain=1e6, z=0.0, **fields):
    """Lanes of that weight over the one to have at z, after the pass, and the importance there."""
    table = {"kz": math.log(gain), "most": math.log(gain)}
    importance = math.exp(min(max(z, 0.0), 1.0) * math.log(gain))
    lanes = Lanes(seed=seed, z=z, cut=1, weight=ratio * 0.5 / importance, birth=0.5, **fields)
    lanes.run(importances.weigh_by_importance, **table)
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
    lanes.run(importances.weigh_by_importance, kz=1.0, most=1.0)
    assert (lanes["weight"] == 1e3).all() and (lanes["copies"] == 0).all()


def test_a_station_is_no_collision():
    lanes = Lanes(flies=1, distance=np.where(np.arange(LANES) % 2, 5.0, 0.01), uz=1.0)
    lanes.run(importances.cut_flight, kz=importances.DOUBLE / 0.1, most=1e3)
    np.testing.assert_allclose(lanes["distance"], np.where(np.arange(LANES) % 2, 0.1, 0.01), rtol=1e-12)
    lanes.run(collisions.collide).run(importances.pause_at_station)
    assert (lanes["collides"] == (np.arange(LANES) % 2 == 0)).all()
    assert (lanes["cut"] == 1).all() and int(lanes.bundle["collisions"][0]) == LANES // 2


# ---- numbers at the ends of their range ----


WORDS = {"all zeros": 0, "all ones": 0xFFFFFFFF}
LAST = 1 - 2.0**-52


def draw_only(word, monkeypatch):
    """Let free paths be made of this word alone, in plain Python."""
    monkeypatch.setattr(paths, "event_words", lambda *_: (np.uint64(word),) * 4)
    plain = getattr(paths.free_flight, "py_func", paths.free_flight)
    for module in (collisions, forcing):
        monkeypatch.setattr(module, "free_flight", plain)


@pytest.mark.parametrize("word", WORDS.values(), ids=WORDS)
@pytest.mark.parametrize("mfp", [1e-300, 1.0, 1e300, math.inf])
def test_extreme_draws_make_finite_paths(word, mfp, monkeypatch):
    """Plain Python with a stream of zeros, and of ones: no path is 0 or longer than 37 mean ones; none in vacuum ends."""
    draw_only(word, monkeypatch)
    for step in (collisions.fly, forcing.fly_or_be_forced):
        lanes = Lanes(mfp=mfp).run_plainly(step)
        depth = lanes["distance"] / mfp if 1e-200 < mfp < math.inf else lanes["distance"]
        assert (np.isinf(depth) if mfp == math.inf else (depth > 0) & (depth < 37.5)).all()
        for name in ("u0", "u1"):
            assert ((lanes[name] >= 0) & (lanes[name] < 1)).all()
        lanes.run_plainly(collisions.collide)
        assert np.isfinite(lanes["z"]).all()


@pytest.mark.parametrize("word", WORDS.values(), ids=WORDS)
@pytest.mark.parametrize("tau", [1e-300, 1e-12, 1.0, 1e4])
def test_extreme_draws_force_collisions_within_the_way(word, tau, monkeypatch):
    draw_only(word, monkeypatch)
    lanes = Lanes(ahead=forcing.FRESH).run_plainly(forcing.fly_or_be_forced)
    lanes["distance"] = tau
    lanes.run_plainly(forcing.force_collision)
    assert ((lanes["path"] > 0) & (lanes["path"] <= tau)).all()
    assert ((lanes["weight"] >= 0) & (lanes["caught"] > 0)).all()


@pytest.mark.parametrize("survival", [0.0, 1e-300, 0.5, 1.0])
@pytest.mark.parametrize("u", [0.0, 2.0**-52, 0.5, LAST])
def test_extreme_draws_absorb_or_leave_a_number_below_one(survival, u):
    with np.errstate(divide="ignore", invalid="ignore"):
        lanes = Lanes(collides=1, survival=survival, u0=u).run_plainly(collisions.absorb_by_chance)
    assert ((lanes["u0"] >= 0) & (lanes["u0"] < 1)).all()
    assert ((lanes["weight"] > 0) == (u < survival)).all()


@pytest.mark.parametrize("u1", [0.5 * 2.0**-32, 0.25, 0.5, 1 - 0.5 * 2.0**-32])
@pytest.mark.parametrize("u0", [0.0, 2.0**-52, 0.5, LAST])
@pytest.mark.parametrize("old", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0.6, 0, -0.8)], ids=str)
def test_extreme_draws_scatter_into_directions_of_length_one(old, u0, u1):
    steps = [(scatter, law) for scatter, law, _, _ in SCATTER]
    steps += [(collisions.scatter_by_henyey_greenstein, {"g": g}) for g in (0.999, -0.999, 1e-15, -1e-15)]
    for scatter, law in steps:
        lanes = Lanes(collides=1, ux=old[0], uy=old[1], uz=old[2], u0=u0, u1=u1)
        lanes.run(scatter, number=1, **law)
        assert np.abs((lanes.directions**2).sum(axis=1) - 1).max() < 1e-14
        plainly = Lanes(collides=1, ux=old[0], uy=old[1], uz=old[2], u0=u0, u1=u1)
        plainly.run_plainly(scatter, number=1, **law)
        np.testing.assert_allclose(plainly.directions, lanes.directions, rtol=0, atol=1e-14)


@pytest.mark.parametrize("u", [0.0, LAST])
def test_extreme_draws_in_roulette(u):
    for weight in (5e-324, 1e-300, 0.25, 0.5 - 2.0**-54):
        lanes = Lanes(collides=1, weight=weight, u0=u)
        lanes.run_plainly(roulette.play_roulette_in_flight, threshold=0.5, level=1.0)
        assert np.isin(lanes["weight"], (0.0, 1.0)).all()
        assert ((lanes["u0"] >= 0) & (lanes["u0"] < 1)).all()
