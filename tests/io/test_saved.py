"""Saved runs: loaded, resumed and merged runs equal the uninterrupted run bit for bit; what is kept of them stays bounded."""

from __future__ import annotations

import dataclasses
import json
import math
import sys
from pathlib import Path

import numpy as np
import pytest

import transport as tp
from tests.media_scenes import TRACKINGS
from tests.plain_scenes import SCENES, SMALL
from tests.same_batches import assert_same
from transport.io import resuming
from transport.run import schedules
from transport.run.provenance import this_origin
from transport.run.run import Run
from transport.run.state import FORMER_KINDS, restore_schedule

ERROR = {"error": {"-z.flux_in": 0.04}, "estimator": "analog"}
LIMITS = {
    "random": ("room", {"particles": 20_001}),
    "few batches": ("room", {"particles": 20_001, "batches": 5}),
    "sobol": ("room", {"particles": 20_000, "sampling": "sobol"}),
    "error": ("room", ERROR),
    "error, few batches": ("room", ERROR | {"batches": 16}),
    "error by sobol": ("room", ERROR | {"sampling": "sobol"}),
    "snapshots": ("vessel", {"particles": 4_001}),
    "volumes": ("pile", {"particles": 4_001}),
    "clock": ("flash", {"particles": 4_001}),
    "backward": ("backward view", {"particles": 8_001, "estimator": "backward"}),
    "expected": ("expected fog", {"particles": 4_001, "estimator": "expected"}),
    "splitting": ("deep", {"particles": 4_001, "tracking": TRACKINGS["deep"]}),
}
FILES = {name: ".nc" if place % 2 else ".npz" for place, name in enumerate(LIMITS)}
SMALL_STEPS, LARGE_STEPS = range(1000, 1120), range(20_000, 200_000, 20_000)
EARLIER = Path(__file__).parents[1] / "earlier"


class Killed(BaseException):
    """What ends a run at once."""


def run(name, **more):
    scene, how = LIMITS[name]
    return tp.simulate(SCENES[scene](), **{"seed": 2**64 - 3, "threads": 2} | how | more)


def killed_at(save_number, path, monkeypatch, name, **more):
    """A run that is saved between all batches, and killed after the file has been written so many times."""
    times, save = [], resuming.save

    def save_and_count(*what):
        save(*what)
        times.append(1)
        if len(times) == save_number:
            raise Killed

    with monkeypatch.context() as patch:
        patch.setattr(resuming, "MAX_WRITE_FRACTION", math.inf)
        patch.setattr(resuming, "save", save_and_count)
        with pytest.raises(Killed):
            run(name, checkpoint=path, every=1e-9, **more)


def refusal(call, *arguments, **named):
    with pytest.raises(tp.SceneError) as refused:
        call(*arguments, **named)
    return str(refused.value)


def small(particles=1_000, **how):
    return tp.simulate(SMALL, **{"particles": particles, "threads": 1} | how)


# ---- a run that was killed, in parts, or extended ----


@pytest.mark.slow
@pytest.mark.parametrize("name", LIMITS)
def test_a_run_is_loaded_and_resumed_as_if_it_had_not_been_killed(name, tmp_path, monkeypatch):
    whole, path = run(name), tmp_path / f"run{FILES[name]}"
    whole.save(path)
    loaded = tp.load(path)
    assert_same(whole.batches, loaded.batches)
    assert loaded.report() == whole.report() and loaded.scene == whole.scene
    assert loaded.cost == whole.cost and loaded.state.looks == whole.state.looks
    path.unlink()
    place = 1 + list(LIMITS).index(name) % 7
    killed_at(place, path, monkeypatch, name)
    again = run(name, threads=1 + place % 3, resume=path, checkpoint=path)
    assert_same(again.batches, whole.batches)
    assert (again.is_complete, again.warnings) == (whole.is_complete, whole.warnings)
    assert again.cost.crossings == whole.cost.crossings and again.particles == whole.particles
    assert again.state.looks == whole.state.looks
    assert_same(tp.simulate(SCENES[LIMITS[name][0]](), resume=path).batches, whole.batches)


@pytest.mark.slow
@pytest.mark.parametrize("name", ("random", "few batches", "sobol", "snapshots", "backward"))
def test_parts_are_together_the_whole(name, tmp_path):
    whole = run(name)
    parts = [run(name, part=(k, 3)) for k in (3, 1, 2)]
    parts[0].save(tmp_path / "part.npz")
    merged = tp.merge(tmp_path / "part.npz", *parts[1:])
    assert_same(merged.batches, whole.batches)
    assert merged.particles == sum(part.particles for part in parts)
    scene, more = SCENES[LIMITS[name][0]](), 4 * whole.particles
    gone_on = [tp.simulate(scene, particles=more, resume=run) for run in (merged, whole)]
    assert_same(*(result.batches for result in gone_on))


def test_a_missing_part_is_named():
    """A failed job of an array: the merged rest is a valid result with fewer particles."""
    one, two, three = (small(4_000, batches=8, part=(k, 3)) for k in (1, 2, 3))
    for parts, said in (
        ((three, one), "batches 2 to 4 of seed 0 are in none"),
        ((two, three), "batches 0 to 1 of seed 0 are in none"),
        ((one, two), "the batches of seed 0 after part 2 of 3 are in none"),
    ):
        assert any(said in warning for warning in tp.merge(*parts).warnings)
    for whole in (tp.merge(three, one, two), tp.merge(tp.merge(one, two), three)):
        assert not any("in none" in warning for warning in whole.warnings)


@pytest.mark.parametrize("missing", [1, 2, 3])
def test_a_missing_part_is_merged_after_the_others_went_on(missing):
    """Its numbers stay its own, also where neighbours on either side of it become one."""
    parts = {k: small(4_000, batches=8, part=(k, 3)) for k in (1, 2, 3)}
    late = parts.pop(missing)
    for particles in (5_000, 60_000):
        longer = small(particles, resume=tp.merge(*parts.values()))
        assert any("in none of these runs" in warning for warning in longer.warnings)
        whole = tp.merge(longer, late)
        assert whole.particles == particles + late.particles
        assert not any("in none" in warning for warning in whole.warnings)
        assert_contiguous(sorted(whole.batches, key=lambda batch: batch.first))


def assert_contiguous(batches):
    assert [batch.first for batch in batches] == [0, *(batch.past for batch in batches[:-1])]


def test_parts_end_where_batches_that_are_put_together_do(monkeypatch):
    monkeypatch.setattr(schedules, "MAX_BATCH_SIZE", 64)
    whole = tp.simulate(SMALL, particles=20_001)
    parts = [tp.simulate(SMALL, particles=20_001, part=(k, 5)) for k in range(1, 6)]
    assert whole.batches[0].past == 3
    assert_same(tp.merge(*parts).batches, whole.batches)


def test_parts_of_unlike_runs_are_named():
    """A job of an array that had another number of particles."""
    one, other = (small(n, part=(k, 2)) for k, n in ((1, 4_000), (2, 3_000)))
    (said,) = (warning for warning in tp.merge(one, other).warnings if "neither" in warning)
    assert "run 2 is of a run of 3_000 particles in 32 batches and 2 parts, run 1 of one of 4_000" in said


def test_a_killed_part_is_resumed_as_that_part(tmp_path, monkeypatch):
    path = tmp_path / "part.nc"
    killed_at(3, path, monkeypatch, "random", part=(2, 3))
    assert_same(run("random", resume=path).batches, run("random", part=(2, 3)).batches)


@pytest.mark.slow
def test_a_run_is_extended_and_never_beyond_what_is_asked(tmp_path, monkeypatch):
    path = tmp_path / "run.npz"
    few = tp.simulate(SMALL, particles=10_000)
    more = tp.simulate(SMALL, particles=30_000, resume=few)
    assert (few.particles, more.particles) == (10_000, 30_000)
    one, other, *_ = few.batches
    np.testing.assert_array_equal(more.batches[0].weights, one.weights + other.weights)
    assert tp.simulate(SMALL, particles=5_000, resume=more).particles == 30_000
    exact = tp.simulate(SMALL, error={"meter.flux_in": 0.01}, resume=few)["meter"].flux_in
    assert exact.relative_error <= 0.01
    for sampling in ("random", "sobol"):
        known = tp.simulate(SMALL, error={"meter.flux_in": 0.1}, estimator="analog", sampling=sampling)
        late = known.state.seconds + 0.3
        assert tp.simulate(SMALL, seconds=late, resume=known, sampling=sampling).particles > known.particles
    killed_at(4, path, monkeypatch, "random")
    done = tp.load(path).particles
    assert run("random", particles=done + 1000, resume=path).particles == done + 1000


def test_other_seeds_add_up_in_whatever_order(tmp_path):
    runs = [tp.simulate(SMALL, particles=8_000, seed=seed) for seed in (5, 3)]
    merged = tp.merge(*runs)
    assert_same(merged.batches, tp.merge(*runs[::-1]).batches)
    mean = np.mean([run["meter"].flux_in.value for run in runs])
    assert merged["meter"].flux_in.value == pytest.approx(mean, rel=1e-12)
    assert "seeds 3, 5" in merged.report()
    merged.save(tmp_path / "both.nc")
    more = tp.simulate(SMALL, particles=20_000, resume=tmp_path / "both.nc")
    assert more.particles == 20_000 and {batch.seed for batch in more.batches} == {3, 5}
    places = [(batch.seed, number) for batch in more.batches for number in range(batch.first, batch.past)]
    assert len(set(places)) == len(places)
    odd = [tp.simulate(SMALL, particles=1000 * n, batches=n, seed=seed) for n, seed in ((3, 3), (2, 5))]
    more = tp.merge(*odd)
    for particles in (30_000, 100_000):  # for which what there is becomes larger batches, twice
        more = tp.simulate(SMALL, particles=particles, resume=more)
    assert "batches 0 to 1 of seed 5" in refusal(tp.merge, more, odd[1])


def test_overlapping_or_unlike_runs_are_refused_by_name(tmp_path):
    one, path = tp.simulate(SMALL, particles=4_000, seed=1), tmp_path / "a.npz"
    one.save(path)
    parts = [tp.simulate(SMALL, particles=4_000, seed=1, part=(k, 2)) for k in (1, 2)]
    assert "batches 16 to 31 of seed 1" in refusal(
        tp.merge, tp.merge(path, tp.simulate(SMALL, particles=9, seed=2)), parts[1]
    )
    assert "batches 0 to 15 of seed 1" in refusal(tp.merge, parts[0], one)
    brighter = dataclasses.replace(SMALL, sources=tp.Source(tp.Disk(radius=0.5), tp.Lambertian(power=2.0)))
    other = tp.simulate(brighter, particles=4_000, seed=2)
    told = "sources[0].emission.power: 2.0 instead of 1.0"
    assert told in refusal(tp.merge, one, other)
    assert told in refusal(tp.simulate, brighter, resume=path)
    aimed = tp.simulate(SMALL, particles=4_000, seed=2, estimator="aimed")
    told = refusal(tp.merge, one, aimed)
    assert "method of run 2" in told and "name the same estimator and sampling for both" in told
    assert "two runs or more" in refusal(tp.merge, one)
    weighted = (
        {"tracking": "weighted"} if one.plan.tracking.absorption != "weighted" else {"tracking": "analog"}
    )
    for unlike in (
        {"seed": 2},
        {"estimator": "aimed"},
        {"sampling": "sobol"},
        {"batches": 33},
        {"part": (1, 2)},
        weighted,
    ):
        assert f"{next(iter(unlike))} must be that of the saved run" in refusal(
            tp.simulate, SMALL, resume=path, **unlike
        )
    assert "particles must be that" in refusal(tp.simulate, SMALL, resume=parts[0], particles=9_000)
    assert "checkpoint must be a new file" in refusal(tp.simulate, SMALL, particles=9, checkpoint=path)
    assert "every must be" in refusal(tp.simulate, SMALL, particles=9, checkpoint=tmp_path / "b.nc", every=0)
    for part in (3, (0, 2), (3, 2), (1.5, 2)):
        assert "part must be (k, n)" in refusal(tp.simulate, SMALL, particles=9, part=part)
    assert "by particles alone" in refusal(tp.simulate, SMALL, seconds=1, part=(1, 2))
    assert "at most 9 parts" in refusal(tp.simulate, SMALL, particles=9, part=(1, 40))


def test_runs_of_a_scene_with_other_names_of_the_same_bins_are_merged_and_resumed(tmp_path):
    plain, own = (
        dataclasses.replace(SMALL, detectors=tp.Detector(tp.Disk(radius=1), "meter", positions=positions))
        for positions in (tp.Positions(u=2, v=3), tp.Positions(radius=2, azimuth=3))
    )
    one, other = (tp.simulate(scene, particles=1_000, seed=k) for k, scene in enumerate((plain, own)))
    assert tp.merge(one, other)["meter"].irradiance.dims == ("u", "v")
    other.save(tmp_path / "run.nc")
    for scene, saved in ((own, one), (plain, other), (plain, tmp_path / "run.nc")):
        assert tp.simulate(scene, particles=2_000, resume=saved).particles == 2_000


def test_aimed_runs_go_on_with_the_scene_that_was_given(tmp_path):
    whole, path = small(4_000, estimator="aimed"), tmp_path / "run.nc"
    whole.save(path)
    assert tp.simulate(SMALL, resume=path).report().splitlines()[1] == "estimator: aimed"
    assert_same(tp.load(path).batches, whole.batches)


@pytest.mark.slow
def test_ctrl_c_saves_the_run(tmp_path, press_ctrl_c):
    """Between two batches, with what was done out of turn: nothing is missing afterwards."""
    path, whole = tmp_path / "run.npz", tp.simulate(SMALL, particles=30_000_000, batches=300)
    press_ctrl_c(after=0.3 * whole.cost.seconds)
    stopped = tp.simulate(SMALL, particles=30_000_000, batches=300, checkpoint=path)
    assert not stopped.is_complete and 0 < len(stopped.batches) < 300
    again = tp.simulate(SMALL, resume=path)
    assert again.is_complete
    assert_same(again.batches, whole.batches)


@pytest.mark.slow
def test_kills_at_random_instants_tear_no_file():
    """Three of them; tests/bench/kills.py has fifty."""
    from tests.bench.kills import survives

    kills, _ = survives("short", "run.nc", np.random.default_rng(7), 3)
    assert kills


@pytest.mark.slow
def test_histories_of_other_seeds_have_other_numbers():
    """Of a sample: the first seed's keep theirs, and one history has one number in all snapshots."""
    runs = [run("snapshots", seed=seed) for seed in (3, 5)]
    merged = tp.merge(*runs)
    snapshot = merged.scene.snapshots[0].name
    numbers = [set(run[snapshot].histories.tolist()) for run in runs]
    found = set(merged[snapshot].histories.tolist())
    assert found & numbers[0] and not found & (numbers[1] - numbers[0])


def test_unlike_sources_and_machines_are_named():
    one, other = (small(seed=seed) for seed in (1, 2))
    origin = dataclasses.replace(this_origin(), sources="0", machine="another")
    other.state = dataclasses.replace(other.state, origins=(origin,))
    told = " ".join(tp.merge(one, other).warnings)
    assert "different sources" in told and "another" in told
    assert tp.merge(one, small(seed=2)).warnings == []
    assert any("different sources" in warning for warning in small(3_000, resume=other).warnings)
    assert not any("different" in warning for warning in small(1_000, resume=other).warnings)


# ---- runs that are resumed again and again ----


def extended(particles, **how):
    """A run for each number of particles, resumed from the one before."""
    result = None
    for number in particles:
        result = small(number, resume=result, **how)
    return result


@pytest.mark.slow
@pytest.mark.parametrize("sampling", ["random", "sobol"])
@pytest.mark.parametrize("steps", (SMALL_STEPS, LARGE_STEPS), ids=["small", "large"])
def test_batches_stay_bounded_however_often_a_run_is_resumed(steps, sampling, monkeypatch):
    """And errors are known as of more batches than were asked for, all alike."""
    monkeypatch.setattr(schedules, "MAX_BATCH_SIZE", 64)
    result = extended(steps, sampling=sampling)
    asked, sizes = result.state.limits.batches, np.array([batch.histories for batch in result.batches], float)
    assert asked < sizes.sum() ** 2 / (sizes**2).sum() and len(result.batches) <= 4 * asked
    assert result.particles == steps[-1] if sampling == "random" else result.particles >= steps[-1]
    assert_contiguous(result.batches)


def test_nets_of_resumed_runs_are_whole_and_as_large_as_in_one_go():
    """Small ones for ever would be slow, and hardly better than random points."""
    result = extended([1_000, 5_000, 60_000, 200_000], sampling="sobol")
    last = [(batch.histories, batch.past - batch.first) for batch in result.batches[-8:]]
    assert last == [(16384, 1)] * 8
    assert all(batch.histories % 128 == 0 for batch in result.batches)
    assert result["meter"].flux_in.error < 3 * extended([200_000], sampling="sobol")["meter"].flux_in.error


def test_merged_runs_keep_no_more_batches_than_resumed_ones():
    runs = [small(3_200, seed=seed) for seed in range(6)]
    merged = tp.merge(*runs)
    assert 64 <= len(merged.batches) <= 4 * 32 and {batch.seed for batch in merged.batches} == set(range(6))
    assert merged.particles == 6 * 3_200
    mean = np.mean([run["meter"].flux_in.value for run in runs])
    assert merged["meter"].flux_in.value == pytest.approx(mean, rel=1e-12)
    longer = small(30_000, resume=merged)
    assert longer.particles == 30_000 and len(longer.batches) <= 4 * 32


def test_large_sums_are_kept_in_fewer_batches_though_no_fewer_than_asked_for(monkeypatch):
    """As many as a run in one go keeps; to more, up to twice as many, for of half as many errors would be known less well."""
    monkeypatch.setattr(schedules, "MAX_KEPT_BYTES", 0)
    assert len(extended([4_000], batches=16).batches) == 16
    for last in range(5_000, 12_000, 1_000):
        assert 16 <= len(extended([4_000, *range(5_000, last + 1, 1_000)], batches=16).batches) <= 32


@pytest.mark.slow
@pytest.mark.parametrize("sampling", ["random", "sobol"])
def test_batches_are_never_larger_than_is_safe(sampling, monkeypatch):
    """Also where several of the largest have become one, and the run goes on to more, or to an error."""
    sizes = []

    class Watched(Run):
        def go(self):
            super().go()
            sizes.append(max(size for size, _ in self.executor.done))

    monkeypatch.setattr(schedules, "MAX_BATCH_SIZE", 512)
    monkeypatch.setattr(sys.modules["transport.simulate"], "Run", Watched)
    how = {"batches": 16, "sampling": sampling, "seed": 3, "threads": 2}
    first = tp.simulate(SCENES["room"](), particles=40_000, **how)
    assert max(batch.histories for batch in first.batches) > 512
    for limits in ({"particles": 80_000}, {"error": {"lump.flux_in": 0.005}}):
        tp.simulate(SCENES["room"](), **limits, **how, resume=first)
    assert len(sizes) == 3 and max(sizes) <= 512


@pytest.mark.slow
def test_a_run_is_killed_after_neighbours_have_become_one_and_resumed(tmp_path, monkeypatch):
    monkeypatch.setattr(schedules, "MAX_BATCH_SIZE", 64)
    path = tmp_path / "run.npz"
    run("random", particles=9_000).save(path)
    whole = run("random", particles=30_000, resume=path)
    killed_at(4, path, monkeypatch, "random", particles=30_000, resume=path)
    assert 0 < tp.load(path).state.done
    assert_same(run("random", particles=30_000, resume=path).batches, whole.batches)


def test_a_run_that_stopped_with_batches_out_of_turn_alone_is_resumed():
    """Interrupted while the first batch was being done, and others were."""
    stopped = small(1_000, sampling="sobol")
    ahead = {1: stopped.batches[1]}
    stopped.state = dataclasses.replace(
        stopped.state, batches=[], done=0, next=0, ahead=ahead, particles=0, crossings=0
    )
    longer = tp.simulate(SMALL, seconds=stopped.state.seconds + 1.0, resume=stopped, threads=1)
    assert longer.particles > 0
    with pytest.raises(KeyboardInterrupt, match=r"before a batch was begun, .*; pass more seconds"):
        tp.simulate(SMALL, seconds=stopped.state.seconds / 2, resume=stopped, threads=1)


# ---- files that commit e50b82d wrote ----


@pytest.mark.parametrize("file", ["run.nc", "run.npz", "chosen.npz", "gas.npz"])
def test_a_run_of_an_earlier_version_has_the_same_numbers_and_resumes_where_it_stood(file):
    """Its schedule is known by its present name; else it would resume from its batches.

    The values are those of that version, the errors of bins those of the present rule (statistics/pooling.py).
    """
    result, title = tp.load(EARLIER / file), file.partition(".")[0]
    numbers = json.loads((EARLIER / "numbers.json").read_text())
    expected = {name.partition(".")[2]: number for name, number in numbers.items() if name.startswith(title)}
    assert expected
    for name, (value, error) in expected.items():
        found = result.quantity(name)
        assert np.array_equal(np.ravel(found.value), value, equal_nan=True), name
        assert np.array_equal(np.ravel(found.error), error, equal_nan=True), name
    saved = result.state
    schedule = object.__new__(getattr(schedules, FORMER_KINDS.get(saved.kind, saved.kind)))
    schedule.limits = saved.limits
    assert restore_schedule(saved, schedule)
    assert {name: getattr(schedule, name) for name in schedule.remembered} == saved.remembered


def test_a_scene_of_an_earlier_version_is_the_scene_of_its_run():
    assert tp.Scene.from_json(EARLIER / "scene.json") == tp.load(EARLIER / "run.npz").scene
