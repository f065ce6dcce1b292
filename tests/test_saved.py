"""Saved runs: loaded, resumed and merged runs equal the uninterrupted run bit for bit."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import transport as tp
from tests.media_scenes import TRACKINGS
from tests.plain_scenes import SCENES
from tests.same_batches import assert_same
from transport.io import resuming
from transport.run import schedules
from transport.run.provenance import this_origin

LIMITS = {
    "random": ("room", {"particles": 20_001}),
    "few batches": ("room", {"particles": 20_001, "batches": 5}),
    "sobol": ("room", {"particles": 20_000, "sampling": "sobol"}),
    "error": ("room", {"error": {"-z.flux_in": 0.02}, "estimator": "analog"}),
    "error by sobol": (
        "room",
        {"error": {"-z.flux_in": 0.02}, "estimator": "analog", "sampling": "sobol"},
    ),
    "snapshots": ("vessel", {"particles": 4_001}),
    "volumes": ("pile", {"particles": 4_001}),
    "clock": ("flash", {"particles": 4_001}),
    "backward": ("backward view", {"particles": 8_001, "estimator": "backward"}),
    "expected": ("expected fog", {"particles": 4_001, "estimator": "expected"}),
    "splitting": ("deep", {"particles": 4_001, "tracking": TRACKINGS["deep"]}),
}
FILES = {name: ".nc" if place % 2 else ".npz" for place, name in enumerate(LIMITS)}
SMALL = tp.Scene(
    tp.Source(tp.Disk(radius=0.5), tp.Lambertian(power=1.0)),
    (),
    tp.Detector(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.5), "meter"),
)


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


@pytest.mark.parametrize("name", LIMITS)
def test_it_is_loaded_and_goes_on_as_if_it_had_not_been_killed(name, tmp_path, monkeypatch):
    whole, path = run(name), tmp_path / f"run{FILES[name]}"
    whole.save(path)
    loaded = tp.load(path)
    assert_same(whole.batches, loaded.batches)
    assert loaded.report() == whole.report() and loaded.scene == whole.scene
    assert loaded.cost == whole.cost and loaded.state.looks == whole.state.looks
    for place in np.random.default_rng(1).integers(1, 8, 2):
        path.unlink()
        killed_at(place, path, monkeypatch, name)
        again = run(name, threads=1 + place % 3, resume=path, checkpoint=path)
        assert_same(again.batches, whole.batches)
        assert (again.is_complete, again.warnings) == (whole.is_complete, whole.warnings)
        assert again.cost.crossings == whole.cost.crossings
    assert_same(tp.simulate(SCENES[LIMITS[name][0]](), resume=path).batches, whole.batches)


@pytest.mark.parametrize("name", ["random", "few batches", "sobol", "snapshots", "backward"])
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


def test_a_part_that_is_missing_is_told():
    """A failed job of an array: the merged rest is a valid result with fewer particles."""
    one, two, three = (tp.simulate(SMALL, particles=4_000, batches=8, part=(k, 3)) for k in (1, 2, 3))
    for parts, said in (
        ((three, one), "batches 2 to 4 of seed 0 are in none"),
        ((two, three), "batches 0 to 1 of seed 0 are in none"),
        ((one, two), "the batches of seed 0 after part 2 of 3 are in none"),
    ):
        assert any(said in warning for warning in tp.merge(*parts).warnings)
    for whole in (tp.merge(three, one, two), tp.merge(tp.merge(one, two), three)):
        assert not any("in none" in warning for warning in whole.warnings)


def test_parts_end_where_batches_that_are_put_together_do(monkeypatch):
    monkeypatch.setattr(schedules, "MAX_BATCH_SIZE", 64)
    whole = tp.simulate(SMALL, particles=20_001)
    parts = [tp.simulate(SMALL, particles=20_001, part=(k, 5)) for k in range(1, 6)]
    assert whole.batches[0].past == 3
    assert_same(tp.merge(*parts).batches, whole.batches)


def test_a_killed_part_goes_on_as_that_part(tmp_path, monkeypatch):
    path = tmp_path / "part.nc"
    killed_at(3, path, monkeypatch, "random", part=(2, 3))
    assert_same(run("random", resume=path).batches, run("random", part=(2, 3)).batches)


def test_a_run_goes_on_to_more_and_never_beyond_what_is_asked(tmp_path, monkeypatch):
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


def refusal(call, *arguments, **named):
    with pytest.raises(tp.SceneError) as refused:
        call(*arguments, **named)
    return str(refused.value)


def test_what_overlaps_or_is_unlike_is_refused_by_name(tmp_path):
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
    assert "method of run 2" in refusal(tp.merge, one, aimed)
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


def test_aimed_runs_go_on_with_the_scene_that_was_given(tmp_path):
    how = {"estimator": "aimed", "particles": 4_000}
    whole = tp.simulate(SMALL, **how)
    whole.save(tmp_path / "run.nc")
    assert tp.simulate(SMALL, resume=tmp_path / "run.nc").report().splitlines()[1] == "estimator: aimed"
    assert_same(tp.load(tmp_path / "run.nc").batches, whole.batches)


def test_ctrl_c_saves_too(tmp_path, press_ctrl_c):
    """Between two batches, with what was done out of turn: nothing is missing afterwards."""
    path, whole = tmp_path / "run.npz", tp.simulate(SMALL, particles=30_000_000, batches=300)
    press_ctrl_c(after=0.3 * whole.cost.seconds)
    stopped = tp.simulate(SMALL, particles=30_000_000, batches=300, checkpoint=path)
    assert not stopped.is_complete and 0 < len(stopped.batches) < 300
    again = tp.simulate(SMALL, resume=path)
    assert again.is_complete
    assert_same(again.batches, whole.batches)


def test_kills_at_random_instants_tear_no_file():
    """Three of them; tests/bench/kills.py has fifty."""
    from tests.bench.kills import survives

    kills, _ = survives("short", "run.nc", np.random.default_rng(7), 3)
    assert kills


def test_histories_of_other_seeds_have_other_numbers():
    """Of a sample: the first seed's keep theirs, and one history has one number in all snapshots."""
    runs = [run("snapshots", seed=seed) for seed in (3, 5)]
    merged = tp.merge(*runs)
    snapshot = merged.scene.snapshots[0].name
    numbers = [set(run[snapshot].histories.tolist()) for run in runs]
    found = set(merged[snapshot].histories.tolist())
    assert found & numbers[0] and not found & (numbers[1] - numbers[0])


def test_runs_of_unlike_estimators_are_not_merged_and_the_cure_is_told():
    runs = [
        tp.simulate(SMALL, particles=1000, seed=k, estimator=name)
        for k, name in enumerate(("analog", "expected"))
    ]
    assert "name the same estimator and sampling for both" in refusal(tp.merge, *runs)


def test_unlike_sources_and_machines_are_told():
    one, other = (tp.simulate(SMALL, particles=1_000, seed=seed) for seed in (1, 2))
    origin = dataclasses.replace(this_origin(), sources="0", machine="another")
    other.state = dataclasses.replace(other.state, origins=(origin,))
    told = " ".join(tp.merge(one, other).warnings)
    assert "different sources" in told and "another" in told
    assert tp.merge(one, tp.simulate(SMALL, particles=1_000, seed=2)).warnings == []
    assert any("different sources" in w for w in tp.simulate(SMALL, particles=3_000, resume=other).warnings)
    assert not any("different" in w for w in tp.simulate(SMALL, particles=1_000, resume=other).warnings)
