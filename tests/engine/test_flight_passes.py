"""What passes do to lanes: free and forced flights, absorption, roulette, splitting, scattering, numbers at walls.

Passes are run alone, on lanes filled here. Each judgement fails right code in one of 10^6 seeds; beside each is a fault that it rejects.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from numba import njit
from scipy.special import ndtri

import transport as tp
from tests.agreement import assert_follows
from tests.driven import PASS, Lanes
from transport.compile import layout
from transport.engine.bundle import CARRIED, LANES
from transport.engine.passes import collisions, landing, surfaces, variance_reduction
from transport.engine.passes.bank import number_of_copy as bank_number
from transport.engine.passes.lanes import pad_group, queue_arrivals, resume_flights

FALSE_ALARM = 1e-6
ROUNDS = 800  # of LANES draws
PATH_BITS, COLLISION_BITS, TURN_BITS = 44, 44, 32  # of the uniforms that are told apart here
WORDS = {"all zeros": 0, "all ones": 0xFFFFFFFF}
LAST = 1 - 2.0**-52
NUMBERS = np.arange(LANES)
FLIGHTS = (collisions.sample_free_path, variance_reduction.sample_free_or_forced_path)


def is_even(numbers, cells=20):
    """Fail unless numbers fill [0, 1) evenly."""
    assert_follows(np.histogram(numbers, cells, (0, 1))[0], np.full(cells, 1 / cells), FALSE_ALARM)


def largest_deviation(draws, spread):
    """Deviation of a sum of that standard deviation which right code exceeds in one of 10^6 seeds."""
    return -ndtri(FALSE_ALARM / 2) * spread


# ---- free paths ----


def flights(rounds=ROUNDS, fly=collisions.sample_free_path, **fields):
    """Paths [mean free paths], u0 and u1 of many flights, one after the other of each lane."""
    lanes = Lanes(**fields)
    found = []
    for _ in range(rounds):
        lanes["distance"], lanes["hit"] = 0.0, 0
        lanes.run(collisions.draw_flight).run(fly)
        path = lanes["distance"] - lanes["start"] - 2 * layout.COLLISION_CLEARANCE
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


def draw_only(word, monkeypatch):
    """Let free paths be made of this word alone, in plain Python."""
    monkeypatch.setattr(collisions, "words_of_block", lambda _: (np.uint64(word),) * 4)


@pytest.fixture(scope="module")
def drawn():
    return flights(start=np.linspace(0, 1, LANES), mfp=np.where(np.arange(LANES) % 2, 1.0, 1e-3))


def test_every_bit_of_the_numbers_of_a_collision_is_an_independent_fair_coin(drawn):
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


@pytest.mark.parametrize("fly", FLIGHTS, ids=lambda p: p.name)
def test_free_paths_follow_the_exponential_law(fly):
    """In cells of equal probability, the last of them cut into octaves of survival."""
    path = flights(ROUNDS, fly, start=np.linspace(-1, 1, LANES), mfp=np.geomspace(1e-3, 1e3, LANES))[0]
    survival = np.r_[1 - np.arange(64) / 64, 0.5 ** np.arange(1, 8) / 64, 0.0]
    edges = -np.log(np.maximum(survival, 1e-300))
    assert_follows(np.histogram(path, edges)[0], -np.diff(survival), FALSE_ALARM)
    with pytest.raises(AssertionError):  # an extinction 3 % too large
        assert_follows(np.histogram(path * 0.97, edges)[0], -np.diff(survival), FALSE_ALARM)
    assert path.min() > 0


# ---- the queue at surfaces ----

FIELDS = ("x", "weight", "history", "hit", "distance")
PLACES = [[name for name, _ in CARRIED].index(name) for name in FIELDS]
MOVED = np.array(pad_group(PLACES), np.int64)


def particles(lanes, first, last):
    """Fields of the lanes [first, last) that hold a particle, sorted by its number."""
    rows = np.stack([lanes.bundle[name][0][first:last].astype(float) for name in FIELDS], axis=1)
    rows = rows[rows[:, 1] != 0.0]
    return rows[np.argsort(rows[:, 2])]


def test_lanes_at_a_surface_wait_in_the_queue_with_their_fields_and_come_back():
    """Of five kinds of lanes: at a surface, escaping, dead, without a finite place, flying on; twice, then back."""
    kind = NUMBERS % 5
    moves = layout.row(layout.FIELD_MOVES, fields=MOVED.ctypes.data, count=len(MOVED))
    lanes = Lanes(hit=np.where(kind == 0, 7, 0), weight=np.where(kind == 2, 0.0, 1.0))
    lanes["distance"], lanes["x"] = np.where(kind == 1, np.inf, 0.5), np.where(kind == 3, np.nan, NUMBERS)
    bundle = lanes.bundle  # its arena begins at address 0
    before = particles(lanes, 0, LANES)
    table = layout.row(layout.QUEUE, arriving=moves, flying=moves)
    call = PASS(queue_arrivals.entry)
    flying = call(bundle.ctypes.data, table.ctypes.data, 0, LANES)
    waiting = int(bundle["waiting"][0])
    is_flying = kind[before[:, 2].astype(int)] == 4
    assert flying == is_flying.sum() and waiting == (~is_flying).sum()
    np.testing.assert_array_equal(particles(lanes, 0, flying), before[is_flying])
    np.testing.assert_array_equal(particles(lanes, LANES, LANES + waiting), before[~is_flying])
    # More of them meet a surface; of the queue every second particle ends there, the others fly on.
    bundle["hit"][0][:flying:3] = 9
    met = particles(lanes, 0, flying)[particles(lanes, 0, flying)[:, 3] == 9]
    left = call(bundle.ctypes.data, table.ctypes.data, 0, flying)
    total = int(bundle["waiting"][0])
    np.testing.assert_array_equal(particles(lanes, LANES + waiting, LANES + total), met)
    bundle["weight"][0][LANES : LANES + total : 2] = 0.0
    kept, stayed = particles(lanes, LANES, LANES + total), particles(lanes, 0, left)
    bundle["flying"] = left
    PASS(resume_flights.entry)(bundle.ctypes.data, moves.ctypes.data, LANES, LANES + total)
    assert int(bundle["waiting"][0]) == 0 and int(bundle["flying"][0]) == left + len(kept)
    np.testing.assert_array_equal(particles(lanes, left, left + len(kept)), kept)
    np.testing.assert_array_equal(particles(lanes, 0, left), stayed)


# ---- collisions ----


def test_flights_in_vacuum_have_no_collision():
    lanes = Lanes(mfp=np.inf).run(collisions.draw_flight).run(collisions.sample_free_path)
    assert np.isinf(lanes["distance"]).all()
    assert (lanes.run(collisions.collide)["collides"] == 0).all()
    assert (lanes["z"] == 0).all() and int(lanes.bundle["collisions"][0]) == 0


def test_a_collision_is_at_the_end_of_its_path_and_only_there():
    lanes = Lanes(start=0.25, x=1.0, ux=0.6, uz=0.8, sheet=5)
    lanes.run(collisions.draw_flight).run(collisions.sample_free_path)
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
    assert int(lanes.bundle["collisions"][0]) == collided.sum()


@pytest.mark.parametrize("word", WORDS.values(), ids=WORDS)
def test_extreme_draws_make_finite_paths(word, monkeypatch):
    """Plain Python with a stream of zeros, and of ones: no path is 0 or longer than 37 mean ones; none in vacuum ends."""
    draw_only(word, monkeypatch)
    mfp = np.resize([1e-300, 1.0, 1e300, math.inf], LANES)
    for step in FLIGHTS:
        lanes = Lanes(mfp=mfp).run_plainly(collisions.draw_flight).run_plainly(step)
        depth = lanes["distance"] / np.where((mfp > 1e-200) & (mfp < math.inf), mfp, 1.0)
        assert np.where(mfp == math.inf, np.isinf(depth), (depth > 0) & (depth < 37.5)).all()
        assert all(((lanes[name] >= 0) & (lanes[name] < 1)).all() for name in ("u0", "u1"))
        assert np.isfinite(lanes.run_plainly(collisions.collide)["z"]).all()


# ---- forced flights ----


@pytest.mark.parametrize("tau", [1e-12, 1e-6, 0.1, 2.0, 40.0])
def test_a_forced_collision_carries_its_probability_and_follows_the_truncated_exponential_law(tau):
    """Of w the share 1 - exp(-tau) flies to a collision before the surface, by the exponential law cut off there."""
    depths, mfp = [], 0.5
    for seed in range(200):
        lanes = Lanes(seed=seed, mfp=mfp, start=-0.5, weight=0.75, forced_path=variance_reduction.UNCOLLIDED)
        lanes.run(collisions.draw_flight).run(variance_reduction.sample_free_or_forced_path)
        assert np.isinf(lanes["distance"]).all()
        lanes["distance"] = -0.5 + tau * mfp
        way = lanes["distance"] + 0.5
        lanes.run(variance_reduction.force_collision)
        assert (lanes["copies"] == 1).all() and (lanes["forced_path"] == variance_reduction.UNCOLLIDED).all()
        np.testing.assert_allclose(lanes["copy_weight"], -0.75 * np.expm1(-way / mfp), rtol=1e-15)
        np.testing.assert_allclose(lanes["weight"] + lanes["copy_weight"], 0.75, rtol=1e-15)
        assert abs(lanes.gained(layout.ROULETTE)) <= LANES * 2.0**-52
        assert (lanes["copy_path"] > 0).all() and (lanes["copy_path"] <= way).all()
        depths.append(lanes["copy_path"] / way)
    depths, cells = np.concatenate(depths), np.linspace(0, 1, 41)
    through = np.expm1(-tau * cells) / np.expm1(-tau)
    assert_follows(np.histogram(depths, cells)[0], np.diff(through), FALSE_ALARM)
    if tau >= 0.1:
        with pytest.raises(AssertionError):  # evenly along the way
            assert_follows(np.histogram(depths, cells)[0], np.diff(cells), FALSE_ALARM)


def test_no_collision_is_forced_in_vacuum_without_a_surface_ahead_or_twice():
    kinds = np.arange(LANES) % 4
    ahead = np.where(kinds == 2, variance_reduction.FREE, variance_reduction.UNCOLLIDED)
    lanes = Lanes(mfp=np.where(kinds == 0, np.inf, 1.0), forced_path=ahead).run(collisions.draw_flight)
    lanes.run(variance_reduction.sample_free_or_forced_path)
    distance = lanes["distance"]
    lanes["distance"] = np.where(kinds == 3, 1.0, distance)
    lanes.run(variance_reduction.force_collision)
    assert (lanes["copies"] == (kinds == 3)).all()
    assert (lanes["weight"] == 1.0)[kinds != 3].all()
    assert (
        lanes["forced_path"]
        == np.where(np.isin(kinds, (1, 2)), variance_reduction.FREE, variance_reduction.UNCOLLIDED)
    ).all()
    assert np.isinf(lanes["distance"])[kinds == 0].all() and np.isfinite(lanes["distance"])[kinds != 0].all()


def test_a_copy_flies_its_own_path_once():
    lanes = (
        Lanes(forced_path=0.125)
        .run(collisions.draw_flight)
        .run(variance_reduction.sample_free_or_forced_path)
    )
    np.testing.assert_allclose(lanes["distance"], 0.125, rtol=1e-12)
    assert (lanes["forced_path"] == variance_reduction.FREE).all()
    lanes["distance"], lanes["hit"] = 0.0, 0
    assert (
        len(
            np.unique(
                lanes.run(collisions.draw_flight).run(variance_reduction.sample_free_or_forced_path)[
                    "distance"
                ]
            )
        )
        == LANES
    )


@pytest.mark.parametrize("word", WORDS.values(), ids=WORDS)
def test_extreme_draws_force_collisions_within_the_way(word, monkeypatch):
    draw_only(word, monkeypatch)
    tau = np.resize([1e-300, 1e-12, 1.0, 1e4], LANES)
    lanes = Lanes(forced_path=variance_reduction.UNCOLLIDED).run_plainly(FLIGHTS[1])
    lanes["distance"] = tau
    lanes.run_plainly(variance_reduction.force_collision)
    assert ((lanes["copy_path"] > 0) & (lanes["copy_path"] <= tau)).all()
    assert ((lanes["weight"] >= 0) & (lanes["copy_weight"] > 0)).all()


@pytest.mark.parametrize("tau", [1e-2, 1e-4, 1e-6])
def test_forced_copies_are_not_killed_by_roulette_for_their_small_weight(tau):
    """Every history of a pencil beam scatters the same: its albedo times 1 - exp(-tau).

    Roulette that compared a forced copy with the whole birth weight would kill 99 of 100 copies, or more.
    """
    albedo, radius = 0.9, 1.0
    fog = tp.Medium(absorption=(1 - albedo) * tau / (2 * radius), scattering=albedo * tau / (2 * radius))
    scene = tp.Scene(
        tp.Source(tp.Point(position=(0, 0, -2)), tp.Beam((0, 0, 1), power=1.0)),
        tp.Surface(tp.Sphere(radius=radius), tp.Transparent(), "ball", inside=fog),
        tp.Detector(tp.Sphere(radius=10.0), "sky", side="inside", events=(1, 1)),
    )
    result = tp.simulate(scene, 2000, seed=1, tracking=tp.Tracking(forced=True), progress=False)
    scattered = result["sky"].flux_in
    assert scattered.value == pytest.approx(albedo * tau, rel=2 * tau)
    assert scattered.relative_error <= tau


# ---- absorption and roulette ----


def absorbed(lanes, absorb):
    """Lanes after a pass that absorbs, and that which accounts for it."""
    return lanes.run(absorb).run(collisions.account_absorbed_in, ledger=layout.ABSORBED)


@pytest.mark.parametrize("survival", [0.0, 1e-3, 0.2, 0.9, 1 - 1e-9, 1.0])
def test_analog_absorption_leaves_the_albedo_and_a_fresh_uniform_number(survival):
    died, left = 0, []
    for seed in range(200):
        lanes = Lanes(seed=seed, collides=1, survival=survival, weight=0.75)
        lanes["u0"] = np.random.default_rng(seed).random(LANES)
        absorbed(lanes, collisions.absorb_at_collisions)
        dies = lanes["weight"] == 0
        assert (lanes["collides"] == ~dies).all() and (lanes["weight"][~dies] == 0.75).all()
        assert lanes.gained(layout.ABSORBED) == 0.75 * dies.sum()
        died += dies.sum()
        left.append(lanes["u0"][~dies])
    left, draws = np.concatenate(left), 200 * LANES
    spread = math.sqrt(draws * survival * (1 - survival))
    assert abs(died - draws * (1 - survival)) <= largest_deviation(draws, spread)
    if survival >= 0.2:
        is_even(left, 50)
    if survival == 0.2:
        with pytest.raises(AssertionError):  # the number that decided, used again
            is_even(left * survival, 50)


@pytest.mark.parametrize("least", [1e-12, 1e-5], ids=["beside thin ways", "no thin way"])
def test_weights_fall_exponentially_along_a_flight_and_the_ledger_gets_the_rest(least):
    depths = np.geomspace(least, 1e3, LANES)
    lanes = Lanes(start=0.5, distance=0.5 + depths, sigma_a=1.0, weight=0.8, mfp=1.0)
    way = lanes["distance"] - 0.5
    absorbed(lanes, collisions.attenuate)
    np.testing.assert_allclose(lanes["weight"], 0.8 * np.exp(-way), rtol=1e-14, atol=1e-300)
    assert lanes.gained(layout.ABSORBED) == pytest.approx(math.fsum(0.8 - lanes["weight"]), rel=1e-15)
    for change in ({"sigma_a": 0.0}, {"sigma_a": 0.0, "distance": np.inf}):
        lanes = absorbed(Lanes(**{"distance": 2.0, "weight": 0.8} | change), collisions.attenuate)
        assert (lanes["weight"] == 0.8).all() and lanes.gained(layout.ABSORBED) == 0
    assert (absorbed(Lanes(distance=np.inf, sigma_a=1.0), collisions.attenuate)["weight"] == 0).all()


@pytest.mark.parametrize("number", [0, 1, 2])
def test_a_medium_accounts_for_its_own_lanes_alone(number):
    """All at once give the same rows of the ledger, and weights."""
    lanes, together = (
        Lanes(weight=0.8, left=np.linspace(0, 0.8, LANES), medium=np.arange(LANES) % 3) for _ in range(2)
    )
    here = lanes["medium"] == number
    lanes.run(collisions.account_absorbed_in, medium=number, ledger=layout.ABSORBED + number)
    together.run(collisions.account_absorbed_in_all, ledger=layout.ABSORBED)
    assert (lanes["weight"] == np.where(here, lanes["left"], 0.8)).all()
    assert (together["weight"] == lanes["left"]).all()
    row = layout.ABSORBED + number
    assert (lanes.ledger[row, :2] == together.ledger[row, :2]).all() and lanes.gained(row) > 0


GAMES = {  # where it is played, what says so, and the number that decides
    "in flight": (variance_reduction.play_roulette_in_flight, {"collides": 1}, "u0"),
    "at walls": (variance_reduction.play_roulette, {"hit": 1}, "u2"),
}


@pytest.mark.parametrize("game", GAMES.values(), ids=GAMES)
@pytest.mark.parametrize(("threshold", "level"), [(1e-3, 1e-2), (0.05, 0.5), (0.5, 1.0), (1.0, 1.0)])
def test_roulette_keeps_the_expectation_and_balances_the_ledger(threshold, level, game):
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
        lost = (weight - lanes["weight"]).sum()
        assert lanes.gained(layout.ROULETTE) == pytest.approx(lost, rel=1e-9, abs=1e-12)
        before.append((weight / birth)[played])
        after.append((lanes["weight"] / birth)[played])
        numbers.append(lanes["u0"][played & (lanes["weight"] > 0)])
    before, after, numbers = (np.concatenate(part) for part in (before, after, numbers))
    most = largest_deviation(before.size, math.sqrt((before * (level - before)).sum()))
    assert abs((after - before).sum()) < most
    assert abs((after - np.sqrt(before)).sum()) > most  # another chance is seen
    if play is variance_reduction.play_roulette_in_flight:  # where it serves again
        is_even(numbers)


@pytest.mark.parametrize("play", [play for play, _, _ in GAMES.values()], ids=GAMES)
def test_lanes_that_meet_nothing_play_no_roulette(play):
    lanes = Lanes(collides=0, hit=0, weight=1e-6, u0=0.5, u2=0.5).run(play, threshold=0.5, level=1.0)
    assert (lanes["weight"] == 1e-6).all() and lanes.gained(layout.ROULETTE) == 0


def test_extreme_draws_absorb_or_leave_a_number_below_one():
    cases = itertools.product([0.0, 1e-300, 0.5, 1.0], [0.0, 2.0**-52, 0.5, LAST])
    survival, u = np.resize(list(cases), (LANES, 2)).T
    with np.errstate(divide="ignore", invalid="ignore"):
        lanes = Lanes(collides=1, survival=survival, u0=u).run_plainly(collisions.absorb_at_collisions)
    assert ((lanes["u0"] >= 0) & (lanes["u0"] < 1)).all()
    assert ((lanes["left"] > 0) == (u < survival)).all()


def test_extreme_draws_kill_or_raise_a_weight_to_its_level():
    weight, u = np.resize(
        list(itertools.product([5e-324, 1e-300, 0.25, 0.5 - 2.0**-54], [0.0, LAST])), (LANES, 2)
    ).T
    lanes = Lanes(collides=1, weight=weight, u0=u)
    lanes.run_plainly(variance_reduction.play_roulette_in_flight, threshold=0.5, level=1.0)
    assert np.isin(lanes["weight"], (0.0, 1.0)).all()
    assert ((lanes["u0"] >= 0) & (lanes["u0"] < 1)).all()


# ---- copies ----


@njit
def numbers_of_copies(parents, events, places):
    return np.array([bank_number(h, e, p) for h in parents for e in events for p in places])


def test_copies_have_independent_random_numbers():
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
def test_thinning_out_keeps_the_expectation_and_balances_the_ledger(ratio):
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


def test_lanes_that_meet_a_surface_or_wait_are_not_split():
    lanes = Lanes(cut=0, weight=1e3, birth=1.0)
    lanes.run(variance_reduction.split_or_roulette, kz=1.0, most=1.0)
    assert (lanes["weight"] == 1e3).all() and (lanes["copies"] == 0).all()


def test_a_station_is_no_collision():
    lanes = Lanes(distance=np.where(np.arange(LANES) % 2, 5.0, 0.01), uz=1.0)
    lanes.run(variance_reduction.cut_flight, kz=variance_reduction.LN_2 / 0.1, most=1e3)
    np.testing.assert_allclose(lanes["distance"], np.where(np.arange(LANES) % 2, 0.1, 0.01), rtol=1e-12)
    lanes.run(collisions.collide).run(variance_reduction.revoke_station_collisions)
    assert (lanes["collides"] == (np.arange(LANES) % 2 == 0)).all()
    assert (lanes["cut"] == 1).all() and int(lanes.bundle["collisions"][0]) == LANES // 2


# ---- scattering ----


def test_extreme_draws_scatter_into_directions_of_length_one():
    """Compiled and plain alike: every pair of extreme numbers about four directions, in one bundle."""
    olds = [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0.6, 0, -0.8)]
    turns = [0.5 * 2.0**-32, 0.25, 0.5, 1 - 0.5 * 2.0**-32]
    cases = [(*old, u0, u1) for old in olds for u0 in (0.0, 2.0**-52, 0.5, LAST) for u1 in turns]
    draws = dict(zip(("ux", "uy", "uz", "u0", "u1"), np.resize(cases, (LANES, 5)).T, strict=True))
    steps = [(collisions.scatter_isotropic, {}), (collisions.scatter_rayleigh, {})]
    steps += [
        (collisions.scatter_henyey_greenstein, {"g": g}) for g in (0.8, -0.3, 0.999, -0.999, 1e-15, -1e-15)
    ]
    for scatter, law in steps:
        other = Lanes(collides=2, **draws).run(scatter, number=1, **law)
        assert (other.directions == np.resize(cases, (LANES, 5))[:, :3]).all()  # by another phase function
        lanes = Lanes(collides=1, **draws).run(scatter, number=1, **law)
        assert np.abs((lanes.directions**2).sum(axis=1) - 1).max() < 1e-14
        plainly = Lanes(collides=1, **draws).run_plainly(scatter, number=1, **law)
        np.testing.assert_allclose(plainly.directions, lanes.directions, rtol=0, atol=1e-14)


# ---- at walls ----


def test_the_random_numbers_of_an_event_at_a_wall_are_independent():
    """Those that make a direction, play roulette, choose a part and a speed: ten pairs in 8 x 8 squares each."""
    events = []
    for seed in range(60):
        lanes = Lanes(seed=seed, hit=1, event=seed)
        lanes.run(surfaces.draw_second_block).run(surfaces.draw_uniforms)
        assert (lanes["event"] == seed + 1).all()
        events.append([lanes[name] for name in ("u0", "u1", "u2", "u3", "u4")])
    numbers = np.concatenate(events, axis=1)

    def are_independent(one, other):
        squares = np.histogram2d(one, other, bins=8, range=[[0, 1]] * 2)[0]
        assert_follows(squares, np.full(64, 1 / 64), FALSE_ALARM / 10)

    for pair in itertools.combinations(numbers, 2):
        are_independent(*pair)
    with pytest.raises(AssertionError):
        are_independent(numbers[0], numbers[0])


def test_points_beside_a_sphere_are_projected_onto_it():
    """However far rounding has carried it: its normal points outwards, its distance from the centre is the radius."""
    sheets = np.zeros(2, layout.SHEET)
    sheets[1] = layout.row(layout.SHEET, cx=0.3, cy=-0.2, cz=0.1, radius=0.25, curvature=4.0)
    away = np.random.default_rng(1).normal(size=(3, len(Lanes()["x"])))
    away /= np.linalg.norm(away, axis=0)
    center, off = np.array([[0.3], [-0.2], [0.1]]), 0.25 * (1 + 1e-9)
    x, y, z = center + off * away
    lanes = Lanes(x=x, y=y, z=z, sheet=1, nx=0.0, ny=0.0, nz=0.0)
    lanes.run(landing.project_onto_sphere, rows=sheets.ctypes.data, count=len(sheets))
    place = np.stack([lanes["x"], lanes["y"], lanes["z"]]) - center
    np.testing.assert_allclose(np.linalg.norm(place, axis=0), 0.25, rtol=4e-15)
    np.testing.assert_allclose([lanes["nx"], lanes["ny"], lanes["nz"]], away, atol=1e-15)
