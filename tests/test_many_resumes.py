"""Runs that are gone on with again and again: what is kept of them stays bounded, about as large, and nobody else's."""

import dataclasses

import numpy as np
import pytest

import transport as tp
from tests.same_batches import assert_same
from tests.test_saved import SMALL, killed_at, run
from transport.run import schedules


def gone_on(particles, **how):
    """A run for each number of particles, on from the one before."""
    result = None
    for number in particles:
        result = tp.simulate(SMALL, particles=number, resume=result, threads=1, **how)
    return result


def effective(result):
    """Of how many batches, all alike, errors are known as well."""
    sizes = np.array([batch.histories for batch in result.batches], float)
    return sizes.sum() ** 2 / (sizes**2).sum()


@pytest.mark.parametrize("sampling", ["random", "sobol"])
@pytest.mark.parametrize("steps", [range(1000, 1300), range(20_000, 400_000, 20_000)], ids=["small", "large"])
def test_batches_stay_bounded_however_often_a_run_goes_on(steps, sampling, monkeypatch):
    monkeypatch.setattr(schedules, "MAX_BATCH_SIZE", 64)
    result = gone_on(steps, sampling=sampling)
    asked = result.state.limits.batches
    assert asked < effective(result) and len(result.batches) <= 4 * asked
    assert result.particles == steps[-1] if sampling == "random" else result.particles >= steps[-1]
    ends = [batch.past for batch in result.batches]
    assert [batch.first for batch in result.batches] == [0, *ends[:-1]]


def test_nets_of_runs_that_went_on_are_whole_and_as_large_as_in_one_go():
    """Small ones for ever would be slow, and hardly better than random points."""
    result = gone_on([1_000, 5_000, 60_000, 200_000], sampling="sobol")
    last = [(batch.histories, batch.past - batch.first) for batch in result.batches[-8:]]
    assert last == [(16384, 1)] * 8
    assert all(batch.histories % 128 == 0 for batch in result.batches)
    error = gone_on([200_000], sampling="sobol")["meter"].flux_in.error
    assert result["meter"].flux_in.error < 3 * error


def test_merged_runs_keep_no_more_than_one_that_went_on():
    runs = [tp.simulate(SMALL, particles=3_200, seed=seed, threads=1) for seed in range(6)]
    merged = tp.merge(*runs)
    assert 64 <= len(merged.batches) <= 4 * 32 and {batch.seed for batch in merged.batches} == set(range(6))
    assert merged.particles == 6 * 3_200
    mean = np.mean([run["meter"].flux_in.value for run in runs])
    assert merged["meter"].flux_in.value == pytest.approx(mean, rel=1e-12)
    gone = tp.simulate(SMALL, particles=30_000, resume=merged, threads=1)
    assert gone.particles == 30_000 and len(gone.batches) <= 4 * 32


def test_it_is_killed_after_neighbours_have_become_one_and_goes_on(tmp_path, monkeypatch):
    monkeypatch.setattr(schedules, "MAX_BATCH_SIZE", 64)
    path = tmp_path / "run.npz"
    run("random", particles=9_000).save(path)
    whole = run("random", particles=30_000, resume=path)
    killed_at(4, path, monkeypatch, "random", particles=30_000, resume=path)
    assert 0 < tp.load(path).state.done
    assert_same(run("random", particles=30_000, resume=path).batches, whole.batches)


def test_a_run_that_stopped_with_batches_out_of_turn_alone_goes_on_otherwise():
    """Interrupted while the first batch was being done, and others were."""
    done = tp.simulate(SMALL, particles=1_000, sampling="sobol", threads=1)
    state = dataclasses.replace(
        done.state, batches=[], done=0, next=0, ahead={1: done.batches[1]}, particles=0, crossings=0
    )
    stopped = tp.simulate(SMALL, particles=1_000, sampling="sobol", threads=1)
    stopped.state = state
    result = tp.simulate(SMALL, seconds=0.05, resume=stopped, threads=1)
    assert result.particles > 0


@pytest.mark.parametrize("missing", [1, 2, 3])
def test_a_part_that_was_missing_is_merged_after_the_others_went_on(missing, monkeypatch):
    """Its numbers stay its own, also where neighbours on either side of it become one."""
    parts = {k: tp.simulate(SMALL, particles=4_000, batches=8, part=(k, 3), threads=1) for k in (1, 2, 3)}
    late = parts.pop(missing)
    for particles in (5_000, 60_000):
        gone = tp.simulate(SMALL, particles=particles, resume=tp.merge(*parts.values()), threads=1)
        assert any("in none of these runs" in warning for warning in gone.warnings)
        whole = tp.merge(gone, late)
        assert whole.particles == particles + late.particles
        assert not any("in none" in warning for warning in whole.warnings)
        first, *others = sorted(whole.batches, key=lambda batch: batch.first)
        assert first.first == 0
        for batch in others:
            assert batch.first == first.past
            first = batch


def test_parts_of_unlike_runs_are_told():
    """A job of an array that had another number of particles."""
    one, other = (
        tp.simulate(SMALL, particles=n, part=(k, 2), threads=1) for k, n in ((1, 4_000), (2, 3_000))
    )
    (said,) = (warning for warning in tp.merge(one, other).warnings if "neither" in warning)
    assert "run 2 is of a run of 3_000 particles in 32 batches and 2 parts, run 1 of one of 4_000" in said


def test_of_large_sums_fewer_are_kept_though_no_fewer_than_asked_for(monkeypatch):
    """As many as a run in one go keeps; to more, up to twice as many, for of half as many errors would be known less well."""
    monkeypatch.setattr(schedules, "MAX_KEPT_BYTES", 0)
    assert len(gone_on([4_000], batches=16).batches) == 16
    for last in range(5_000, 12_000, 1_000):
        assert 16 <= len(gone_on([4_000, *range(5_000, last + 1, 1_000)], batches=16).batches) <= 32
