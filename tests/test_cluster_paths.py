"""What seldom happens to a run over a cluster: strangers, nobody left, overruns, the command line, pilots, and who did what."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

import transport as tp
from tests.same_batches import assert_same
from tests.test_overruns import CLEAR, DOWN
from tests.test_reproducible import scene
from tests.test_saved import SMALL
from transport.cluster import line as lines
from transport.overruns import OverrunError
from transport.runs import running
from transport.runs.origins import this_origin

pytest.importorskip("distributed")
from tests.dask_cluster import DaskCluster
from tests.test_any_way import stopped
from tests.test_cluster import come_late, happening, without_transport

MANY = {"particles": 60_000, "batches": 300, "seed": 3}
FEW = {"particles": 5_000, "seed": 4}


@pytest.fixture(scope="module")
def cluster():
    with DaskCluster(1) as cluster:
        yield cluster


@pytest.fixture(scope="module")
def whole():
    return tp.simulate(scene(), **MANY, threads=2).batches


@pytest.fixture(autouse=True)
def small_groups(monkeypatch):
    """So that many are out when something happens."""
    monkeypatch.setattr("transport.cluster.crew.SECONDS", 0.01)


# ---- a worker that comes late and has no transport ----


def test_a_stranger_that_ends_over_its_batches_takes_none_along(whole, tmp_path, monkeypatch):
    """Dask ends a worker that cannot read what it is to do; others get it then."""
    monkeypatch.setattr(lines, "DEPTH", 40)  # of which it would get some
    with DaskCluster(1) as mixed:
        come_late(monkeypatch, mixed, without_transport(tmp_path / "stranger"))
        result = tp.simulate(scene(), **MANY, cluster=mixed.address)
    assert_same(result.batches, whole)
    assert result.cost.workers == 1


# ---- nobody is left ----


def test_without_workers_a_run_ends_with_what_it_has_and_goes_on_elsewhere(whole, monkeypatch):
    monkeypatch.setattr(lines, "PATIENCE", 0.5)
    with DaskCluster(1) as lonely:
        happening(monkeypatch, lonely.kill_worker)
        result = tp.simulate(scene(), **MANY, cluster=lonely.address)
        assert not result.is_complete and 0 < result.particles < MANY["particles"]
        assert any(f"no workers at {lonely.address} for 0.5 s" in warning for warning in result.warnings)
    assert_same(tp.simulate(scene(), resume=result, threads=2).batches, whole)


# ---- a batch that cannot be done ----


def test_an_overrun_at_a_worker_is_that_of_one_process(cluster):
    fog = tp.Surface(tp.Sphere(radius=1.0), CLEAR, inside=tp.Medium(absorption=0.3, scattering=2.7))
    split = tp.Splitting(start=(0, 0, 1), end=(0, 0, -1), gain=1e30)
    run = {"particles": 20_000, "tracking": tp.Tracking(splitting=split)}
    with pytest.raises(OverrunError) as here:
        tp.simulate(tp.Scene(DOWN, fog, ()), **run, threads=1)
    with pytest.raises(OverrunError) as there:
        tp.simulate(tp.Scene(DOWN, fog, ()), **run, cluster=cluster.address)
    assert str(there.value) == str(here.value) and "Splitting: gain" in str(here.value)
    cluster.wait_until_empty()
    assert tp.simulate(SMALL, **FEW, cluster=cluster.address).is_complete  # the worker is none the worse


# ---- the command line ----


def record(call, *options):
    answer = call("run", "small.json", "--particles", "5000", "--seed", "4", "--json", *options)
    assert answer.exit_code == 0, answer.output
    return json.loads(answer.output)


@pytest.mark.parametrize("workers", [1, 2])
def test_the_command_line_sends_it_to_a_cluster_or_to_processes(cluster, call, tmp_path, workers):
    SMALL.to_json(tmp_path / "small.json")
    where = [cluster.address] if workers == 1 else ["local", "--threads", "2"]
    there = record(call, "--cluster", *where, "--save", "there.npz")
    assert there["quantities"] == record(call, "--threads", "1")["quantities"]
    assert tp.load(tmp_path / "there.npz").cost.workers == workers
    assert there["cost"]["workers"] == there["cost"]["threads"] == workers


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--cluster", "somewhere"), "must be an address or 'local'"),
        (("--cluster", "tcp://127.0.0.1:1"), "no scheduler answers at tcp://127.0.0.1:1"),
        (("--cluster", "tcp://127.0.0.1:1", "--threads", "2"), "threads cannot be said with a cluster"),
    ],
)
def test_the_command_line_refuses_in_a_line(call, tmp_path, monkeypatch, options, said):
    monkeypatch.setattr(lines, "CONNECT", 1.0)
    SMALL.to_json(tmp_path / "small.json")
    answer = call("run", "small.json", *options)
    assert answer.exit_code == 2 and said in answer.output, answer.output
    assert len(answer.output.splitlines()) == 1, answer.output


# ---- pilots ----


def test_pilots_run_here_and_the_way_that_they_choose_there(cluster, monkeypatch):
    opened, begin = [], lines.Line.open

    def counted(line, tell):
        opened.append(line)
        begin(line, tell)

    monkeypatch.setattr(lines.Line, "open", counted)
    there = tp.simulate(SMALL, **FEW, estimator="auto", cluster=cluster.address)
    assert len(opened) == 1 and len(there.choice.pilots) > 1
    method = there.plan.method
    here = tp.simulate(SMALL, **FEW, estimator=method.estimator, sampling=method.sampling, threads=1)
    assert_same(there.batches, here.batches)


# ---- who did the batches ----


def test_who_did_no_batch_is_not_among_those_who_did(cluster, tmp_path, monkeypatch):
    """A run is begun by workers, and gone on with by them, from a machine of another kind."""
    other = replace(this_origin(), machine="a machine of another kind")
    monkeypatch.setattr(running, "this_origin", lambda: other)
    there = {"cluster": cluster.address}
    stopped(monkeypatch, scene(), 5, **MANY, **there).save(tmp_path / "begun.npz")
    ended = tp.simulate(scene(), resume=tmp_path / "begun.npz", **there)
    assert ended.is_complete and ended.state.origins == (this_origin(),)
    assert not any("unlike machines" in warning for warning in ended.warnings)
    here = tp.simulate(scene(), resume=tmp_path / "begun.npz", threads=1)
    assert here.state.origins == (this_origin(), other)  # which did do some
