"""Phase space counts every particle that is alive once, at every instant; snapshots are unbiased samples of the same histories.

What is a law of every history is asked of integers: numbers of histories, or the limbs of exact sums.  All runs
have fixed seeds; statistical judgements fail right code in one of 10^6 seeds.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ndtri

import transport as tp
from tests import phase_scenes
from tests.phase_scenes import FALSE_ALARM, HOT, PICTURES, TIMES, faces_with, histories, streaming
from tests.plain_scenes import SCENES
from tests.same_batches import digest
from transport.compile.compiler import compile_scene
from transport.compile.layout import IN_FLIGHT
from transport.engine.driver import compile_program, run_batch
from transport.engine.program import build_program
from transport.results.batches import SAMPLED, merged_records, thinned

# ---- phase space ----


@pytest.mark.parametrize("picture", [p.name for p in PICTURES])
def test_bins_and_outside_are_all_that_were_emitted_and_not_yet_absorbed(picture):
    """History by history: born at the start, plus all that left walls, less all that arrived at them."""
    result = phase_scenes.kept()
    found, counted = result[picture], phase_scenes.rows(result, picture)
    sides = phase_scenes.ARRIVALS, phase_scenes.DEPARTURES
    arrived, left = (phase_scenes.wall_histories(result, side) for side in sides)
    gas = result.particles - born_at_walls(result)
    alive = gas - (arrived - left).sum(axis=0)
    np.testing.assert_array_equal(counted.sum(axis=1), alive)
    np.testing.assert_array_equal(histories(result, found.alive.value), alive)
    number = histories(result, found.number.value).reshape(len(TIMES), -1)
    np.testing.assert_array_equal(number, counted[:, 1:])
    np.testing.assert_array_equal(histories(result, found.outside.value), counted[:, 0])
    assert (counted[:, 0] > 0).all() and len(set(alive)) == len(TIMES)


def born_at_walls(result):
    """Histories of the last two sources: shares 4 and 2 of 12 to the last, as batches are dealt out systematically."""
    # Black walls: what leaves them was born there.
    left = phase_scenes.wall_histories(result, phase_scenes.DEPARTURES)[4:, -1]
    share = left / result.particles
    np.testing.assert_allclose(share, [4 / 12, 2 / 12], atol=2e-3)
    return left.sum()


def test_particles_alive_at_the_end_are_those_in_flight_in_the_ledger():
    result = phase_scenes.kept()
    in_flight = histories(result, result.ledger["in_flight"].value)
    for picture in PICTURES:
        assert phase_scenes.rows(result, picture.name)[-1].sum() == in_flight
        assert result[picture.name].alive[-1].value == result.ledger["in_flight"].value
    assert 0 < in_flight < result.particles


def test_weights_that_walls_and_roulette_have_changed_are_conserved_to_the_last_limb():
    """Numbers in the unit 2^-63 of the largest weight: phase space at the end against the ledger."""
    kinds = [tp.Diffuse(0.9), tp.Mirror(0.3), tp.Diffuse(0.2, speed=HOT), tp.Mirror(), tp.Diffuse(0.7)]
    plan = compile_scene(phase_scenes.vessel(faces_with(*kinds, tp.Black()), PICTURES))
    raw = run_batch(compile_program(build_program(plan)), 1, 0, 20_000)
    flying = whole(raw.ledger[IN_FLIGHT])
    for picture in PICTURES:
        bins = math.prod(len(edges) - 1 for edges in picture.axes.values())
        last = plan.rows_of[picture.name].first + (len(TIMES) - 1) * (1 + bins)
        assert sum(map(whole, raw.detectors[last : last + 1 + bins])) == flying
    assert 0 < flying < 20_000 << 63 and flying % (1 << 31) != 0


def whole(row):
    return (int(row[0]) << 31) + int(row[1])


def test_particles_that_meet_a_wall_at_the_instant_itself_are_counted_once():
    """All of them do, at 1 s and 3 s: flights that held both of their ends would count twice, open ones never."""
    gas = tp.Source(tp.Point(), tp.Gas(number=1.0, speed=1.0, direction=(0, 0, 1)))
    look = tp.PhaseSpace(z=(-2, 2), vz=(-2, 0, 2), time=(0.0, 1.0, 2.0, 3.0))
    scene = tp.Scene(gas, faces_with(*[tp.Mirror()] * 6), look, duration=4.0)
    result = tp.simulate(scene, particles=1000, seed=1)
    found = result["phase_space"]
    assert (histories(result, found.alive.value) == 1000).all()
    upwards = histories(result, found.number.value)[:, 0, 1]
    np.testing.assert_array_equal(upwards, [1000, 0, 0, 1000])


# ---- snapshots ----

PAIR = [tp.Snapshot(0.5, particles=20_000, name="before"), tp.Snapshot(2.75, particles=20_000, name="after")]


def matched(result):
    """Both snapshots in the order of their histories."""
    found = [result[shot.name] for shot in PAIR]
    orders = [np.lexsort((shot.histories, shot.batches)) for shot in found]
    first, second = (np.stack([s.batches, s.histories], 1)[o] for s, o in zip(found, orders, strict=True))
    np.testing.assert_array_equal(first, second)
    return [(s.positions[o], s.velocities[o]) for s, o in zip(found, orders, strict=True)]


@pytest.mark.parametrize("particles", [20_000, 4000], ids=["all", "one in five"])
def test_without_walls_every_particle_moves_by_v_t(particles):
    """Both snapshots are of the same histories, chosen before anything was known of them."""
    pair = [tp.Snapshot(each.time, particles=particles, name=each.name) for each in PAIR]
    (x, v), (later, w) = matched(tp.simulate(streaming(pair), particles=20_000, seed=1))
    assert 0.975 * particles <= len(x) <= particles and (particles == 4000 or len(x) == particles)
    np.testing.assert_array_equal(v, w)
    np.testing.assert_allclose(later, x + 2.25 * v, rtol=0, atol=1e-13)
    assert np.abs(later - (x + 2.2 * v)).max() > 0.1


def test_between_mirrors_every_particle_moves_as_its_unfolded_image_does():
    walls = faces_with(*[tp.Mirror()] * 6)
    (x, v), (later, w) = matched(tp.simulate(streaming(PAIR, walls), particles=20_000, seed=1))
    unfolded = x + 2.25 * v
    turns = np.floor((unfolded + 1) / 2)
    sign = 1 - 2 * (turns % 2)
    np.testing.assert_allclose(later, sign * (unfolded - 2 * turns), rtol=0, atol=1e-12)
    np.testing.assert_allclose(w, sign * v, rtol=1e-12, atol=1e-12)
    assert (sign < 0).mean() > 0.2 and (np.abs(turns) > 1).any()


@pytest.mark.parametrize("particles", [20_011, 10_000_000])
def test_a_snapshot_of_more_particles_than_histories_has_all_of_them(particles):
    """Also where batches differ by one history."""
    shot = tp.Snapshot(1.0, particles=particles)
    result = tp.simulate(streaming(shot), particles=20_011, seed=1)
    found = result["snapshot"]
    assert len(found) == 20_011 == len(set(zip(found.batches, found.histories, strict=True)))
    np.testing.assert_allclose(found.weights, 6.0 / 20_011, rtol=1e-14)
    assert found.time == 1.0 and found.positions.shape == found.velocities.shape == (20_011, 3)


@pytest.mark.parametrize(
    "aim", [None, tp.Disk(center=(0.5, 0, 3.0), radius=0.2), tp.Sphere(center=(0, 0, 2), radius=0.5)]
)
def test_light_from_a_flash_is_on_a_sphere_whether_it_was_aimed_or_not(aim):
    """An aimed particle is kept at its target while it flies there from its source."""
    source = tp.Source(tp.Point(), tp.Isotropic(energy=1.0, speed=2.0), aim=aim, pulse=tp.Instant(0.25))
    looks = [tp.Snapshot(t, particles=2000, name=f"{k}") for k, t in enumerate((0.25, 0.5, 1.0, 3.0))]
    looks.append(tp.PhaseSpace(x=(-9, 9), time=(0.1, 0.5, 3.0), name="all"))
    around = tp.Sphere(radius=4.0)
    looks.append(tp.Detector(around, "around", side="inside", times=(0.0, 2.2499, 2.2501, 3.0)))
    result = tp.simulate(tp.Scene(source, [], looks, duration=3.0), particles=2000, seed=1)
    for k, t in enumerate((0.25, 0.5, 1.0, 3.0)):
        shot = result[f"{k}"]
        far = np.linalg.norm(shot.positions, axis=1)
        np.testing.assert_allclose(far, 2 * (t - 0.25), rtol=1e-13, atol=1e-15)
        np.testing.assert_allclose(np.linalg.norm(shot.velocities, axis=1), 2.0, rtol=1e-14)
    met = result["around"].counts_of("weight in").sum(axis=0)
    np.testing.assert_array_equal(met, [0, 2000, 0])
    emitted = 1.0 - result.ledger["unsampled"].value
    np.testing.assert_allclose(result["all"].alive.value, [0, emitted, emitted], rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("thinned", [False, True])
def test_samples_of_a_few_are_unbiased_over_seeds(thinned):
    """Weights, and weights times speed, of a sample against phase space of all; few are alive, of two kinds.

    Where another snapshot asks for more, this one is thinned out afterwards.
    """
    few = tp.Snapshot(2.0, particles=25, name="few")
    more = [tp.Snapshot(1.0, particles=400, name="more")] if thinned else []
    looks = [few, *more, tp.PhaseSpace(speed=(0, 9), time=2.0, moments=True, name="all")]
    fast, slow = (tp.Source(tp.Box(size=1.0), tp.Gas(number=n, speed=v)) for n, v in ((4.0, 2.0), (1.0, 0.3)))
    ball = tp.Surface(tp.Sphere(radius=1.5), tp.Diffuse(0.5))
    scene = tp.Scene([fast, slow], ball, looks, duration=phase_scenes.DURATION)
    off = []
    for seed in range(200):
        result = tp.simulate(scene, particles=1000, seed=seed, batches=8, threads=1, progress=False)
        sample, all_ = result["few"], result["all"]
        assert len(sample) <= 25 + 8
        speeds = np.linalg.norm(sample.velocities, axis=1)
        exact = all_.alive.value, (all_.fluence_rate * 9.0).value[0]
        off.append([sample.weights.sum() - exact[0], sample.weights @ speeds - exact[1]])
    off = np.array(off)
    z = off.mean(axis=0) / (off.std(axis=0, ddof=1) / math.sqrt(len(off)))
    assert (np.abs(z) < -ndtri(FALSE_ALARM / 4)).all(), z
    biased = off.mean(axis=0) + 0.1 * np.array(exact)
    assert (np.abs(biased / (off.std(axis=0, ddof=1) / math.sqrt(len(off)))) > 5.1).any()


def test_snapshots_of_a_run_without_an_end_are_unbiased_too():
    """Batches are put together as the run goes on; each snapshot's sample still stands for all that are alive."""
    times = {"start": 0.0, "soon": 0.01, "end": 3.0}
    looks = [tp.Snapshot(time, particles=500, name=name) for name, time in times.items()]
    looks += [tp.PhaseSpace(x=(-9, 9), time=tuple(times.values()), name="all")]
    ball = tp.Surface(tp.Sphere(radius=1.5), tp.Black())
    scene = streaming(looks, ball)
    limits = {"particles": 300_000, "error": {"all.alive": 1e-9}, "batches": 32, "estimator": "analog"}
    result = tp.simulate(scene, **limits, seed=1, progress=False)
    assert result.particles == 300_000 and len(result.run) < 64
    for name, alive in zip(times, result["all"].alive.value, strict=True):
        sample = result[name]
        assert 0 < len(sample) <= 500
        assert sample.weights.sum() == pytest.approx(alive, rel=max(0.06, 5 / math.sqrt(len(sample)))), name


@pytest.mark.slow
def test_small_snapshots_beside_a_large_one_are_unbiased_where_few_are_left():
    """Of 3200 particles 1.1 % are left at the second instant: most of its samples of 25 histories are then empty.

    Those that are not must stand for these, too: by the chance with which a history was chosen, not by how many there were.
    """
    gas = tp.Gas(number=1.0, speed=1.0, direction=(0, 0, 1))
    source = tp.Source(tp.Box(size=(1, 1, 0.01), center=(0, 0, -0.01)), gas)
    wall = tp.Surface(tp.Disk(center=(0, 0, 0.5), radius=5.0, inner_radius=0.06), tp.Black())
    looks = [tp.Snapshot(0.0, particles=25, name="all"), tp.Snapshot(0.9, particles=25, name="few")]
    looks += [tp.Snapshot(0.0, particles=3200, name="large"), tp.PhaseSpace(x=(-9, 9), time=0.9)]
    scene = tp.Scene(source, wall, looks, duration=1.0)
    off, alive, empty = [], [], 0
    for seed in range(100):
        result = tp.simulate(scene, particles=3200, seed=seed, batches=8, threads=1, progress=False)
        assert len(result["all"]) <= 25 and len(result["large"]) == 3200
        alive.append(result["phase_space"].alive.value)
        off.append([result["all"].weights.sum() - 1.0, result["few"].weights.sum() - alive[-1]])
        empty += len(result["few"]) == 0
    error = np.std(off, axis=0, ddof=1) / math.sqrt(len(off))
    assert np.mean(alive) == pytest.approx(math.pi * 0.06**2, rel=0.03) and empty > 50
    assert (np.abs(np.mean(off, axis=0)) < 5 * error).all()


def test_any_number_of_threads_counts_and_samples_the_same():
    assert len({digest(SCENES["vessel"](), threads=threads) for threads in (1, 2, 3)}) == 1


def test_a_thinned_sample_stands_for_the_whole():
    records = np.zeros(1000, SAMPLED)
    records["weight"], records["below"], records["place"] = 3.0, 1.0, (np.arange(1000) + 0.5) / 1000
    quarter = thinned(records, 0.25)
    assert len(quarter) == 250 and (quarter["weight"] == 12.0).all()
    eighth = thinned(quarter, 0.125)
    assert len(eighth) == 125 and (eighth["weight"] == 24.0).all()
    both = merged_records(quarter, records, most=800)  # one of them thinned out before: all alike afterwards
    assert both["weight"].sum() == 2 * 125 * 24.0
