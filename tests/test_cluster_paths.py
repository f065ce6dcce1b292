"""What seldom happens to a run over a cluster: strangers, nobody left, overruns, the command line, pilots, and who did what."""

from __future__ import annotations

import json
import pickle
import time
from dataclasses import replace
from types import SimpleNamespace

import pytest

import transport as tp
from tests.same_batches import assert_same
from tests.test_overruns import CLEAR, DOWN
from tests.test_readme import fences
from tests.test_reproducible import scene
from tests.test_saved import SMALL
from transport.cli.docs import GUIDES
from transport.compile.limits_exceeded import OverrunError
from transport.compile.methods import ANALOG
from transport.engine.driver import Stopped
from transport.run import run
from transport.run.provenance import this_origin
from transport.run.settings import Settings, checked_limits

pytest.importorskip("distributed")
from distributed import Client

from tests.dask_cluster import DaskCluster, executing
from tests.test_any_way import stopped
from tests.test_cluster import come_late, happening, without_transport
from transport.run.dask import cluster as clusters
from transport.run.dask import executor as executors
from transport.run.dask import worker
from transport.run.dask.executor import DaskExecutor

MANY = {"particles": 60_000, "batches": 300, "seed": 3}
FEW = {"particles": 5_000, "seed": 4}

pytestmark = pytest.mark.usefixtures("small_groups")


@pytest.fixture(scope="module")
def cluster():
    with DaskCluster(1) as cluster:
        yield cluster


@pytest.fixture(scope="module")
def whole():
    return tp.simulate(scene(), **MANY, threads=2).batches


# ---- a worker that comes late and has no transport ----


def test_a_stranger_that_ends_over_its_batches_takes_none_along(whole, tmp_path, monkeypatch):
    """Dask ends a worker that cannot read what the run gives to all."""
    monkeypatch.setattr(executors, "GROUPS_IN_FLIGHT", 40)  # of which it would get some
    with DaskCluster(1) as mixed:
        come_late(monkeypatch, mixed, without_transport(tmp_path / "stranger"))
        result = tp.simulate(scene(), **MANY, cluster=mixed.address)
    assert_same(result.batches, whole)
    assert result.cost.workers == 1


# ---- nobody is left ----


def test_without_workers_a_run_ends_with_what_it_has_and_goes_on_elsewhere(whole, monkeypatch):
    monkeypatch.setattr(executors, "WAIT_SECONDS", 0.5)
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
        (("--cluster", "tcp://127.0.0.1:1", "--threads", "2"), "threads must not be given with a cluster"),
    ],
)
def test_the_command_line_refuses_in_a_line(call, tmp_path, monkeypatch, options, said):
    monkeypatch.setattr(clusters, "CONNECT_SECONDS", 1.0)
    SMALL.to_json(tmp_path / "small.json")
    answer = call("run", "small.json", *options)
    assert answer.exit_code == 2 and said in answer.output, answer.output
    assert len(answer.output.splitlines()) == 1, answer.output


def test_the_guide_s_own_example_runs(cluster):
    """But for its address and its size."""
    example = next(code for language, code in fences(GUIDES / "clusters.md") if language == "py")
    assert "tcp://10.0.0.1:8786" in example and "100_000_000" in example
    known = {}
    exec(example.replace("tcp://10.0.0.1:8786", cluster.address).replace("100_000_000", "10_000"), known)
    assert known["result"].particles == 10_000 and known["result"].cost.workers == 1


# ---- a task that runs a simulation itself ----


def test_a_task_may_run_on_the_cluster_that_it_is_done_by(cluster):
    """Its own worker does the batches, though it has but one thread."""

    def task(scene, limits, address):
        import transport

        return transport.simulate(scene, **limits, cluster=address, progress=False).batches

    with Client(cluster.address, set_as_default=False) as client:
        batches = client.submit(task, SMALL, FEW, cluster.address, pure=False).result(timeout=60)
    assert_same(batches, tp.simulate(SMALL, **FEW, threads=1).batches)


# ---- what a worker is told, and keeps ----


def test_a_worker_forgets_the_program_of_a_run_whose_client_was_killed():
    """When another run begins: Dask keeps the plugin, but not what takes memory."""
    there = SimpleNamespace(state=SimpleNamespace(nthreads=1), plugins={})
    settings = pickle.dumps(Settings(SMALL, ANALOG, checked_limits(SMALL, 100, None, None, None)))

    def begin(name):
        there.plugins[name] = plugin = worker.RunPlugin(name, settings, this_origin().sources)
        plugin.setup(there)
        plugin.compiled_program()
        plugin.work([(0, 100)], 1, "task")
        return plugin

    killed, other = begin("killed"), begin("other")
    assert killed.compiled and killed.free and not killed.busy
    killed.used -= 2 * worker.IDLE_SECONDS
    begin("next")
    assert killed.compiled is None and not killed.free and other.compiled
    again, _ = killed.work([(0, 100)], 1, "task")  # its client was not
    assert_same(list(again.values()), list(other.work([(0, 100)], 1, "task")[0].values()))


def test_a_task_that_is_cancelled_stops_and_no_other():
    there = SimpleNamespace(state=SimpleNamespace(nthreads=1), plugins={})
    settings = pickle.dumps(Settings(SMALL, ANALOG, checked_limits(SMALL, 100, None, None, None)))
    plugin = worker.RunPlugin("run", settings, this_origin().sources)
    plugin.setup(there)
    one, other = plugin._take_bundle("one"), plugin._take_bundle("other")
    plugin.transition("one", "executing", "memory")
    assert one["stop"] == other["stop"] == 0
    plugin.transition("one", "executing", "released")
    assert one["stop"] == 1 and other["stop"] == 0
    plugin.teardown(there)
    assert other["stop"] == 1
    with pytest.raises(Stopped):
        plugin._take_bundle("next")


def test_a_batch_under_way_stops_when_its_run_ends(cluster, press_ctrl_c, monkeypatch):
    """Dask itself would let it finish, which takes many seconds here."""
    start = DaskExecutor._start

    def started(executor, *arguments):
        start(executor, *arguments)
        press_ctrl_c(after=0.5)

    monkeypatch.setattr(DaskExecutor, "_start", started)
    with pytest.raises(KeyboardInterrupt, match="before the first batch"):
        tp.simulate(scene(), particles=10**9, batches=64, cluster=cluster.address)
    ended = time.monotonic()
    with Client(cluster.address, set_as_default=False) as client:
        while set(client.run(executing).values()) != {0}:
            assert time.monotonic() - ended < 3.0
            time.sleep(0.05)


# ---- pilots ----


def test_pilots_run_here_and_the_way_that_they_choose_there(cluster, monkeypatch):
    opened, prepare = [], DaskExecutor.prepare

    def counted(executor, *arguments):
        opened.append(executor)
        prepare(executor, *arguments)

    monkeypatch.setattr(DaskExecutor, "prepare", counted)
    there = tp.simulate(SMALL, **FEW, estimator="auto", cluster=cluster.address)
    assert len(opened) == 1 and len(there.choice.pilots) > 1
    method = there.plan.method
    here = tp.simulate(SMALL, **FEW, estimator=method.estimator, sampling=method.sampling, threads=1)
    assert_same(there.batches, here.batches)


# ---- who did the batches ----


def test_who_did_no_batch_is_not_among_those_who_did(cluster, tmp_path, monkeypatch):
    """A run is begun by workers, and gone on with by them, from a machine of another kind."""
    other = replace(this_origin(), machine="a machine of another kind")
    monkeypatch.setattr(run, "this_origin", lambda: other)
    there = {"cluster": cluster.address}
    stopped(monkeypatch, scene(), 5, **MANY, **there).save(tmp_path / "begun.npz")
    ended = tp.simulate(scene(), resume=tmp_path / "begun.npz", **there)
    assert ended.is_complete and ended.state.origins == (this_origin(),)
    assert not any("different machines" in warning for warning in ended.warnings)
    here = tp.simulate(scene(), resume=tmp_path / "begun.npz", threads=1)
    assert here.state.origins == (this_origin(), other)  # which did do some
