"""Batches of a cluster's workers are those of one process, bit for bit: killed, late, of a scheduler that died, or stopped."""

from __future__ import annotations

import os
import pickle
import shutil
import signal
import subprocess
import sys
from types import SimpleNamespace

import pytest

import transport as tp
from tests.same_batches import assert_same
from tests.test_reproducible import scene
from transport.compile.methods import ANALOG
from transport.run.progress import Progress, WaitingWarning
from transport.run.provenance import this_origin
from transport.run.settings import Settings, checked_limits

pytest.importorskip("distributed")
from tests.dask_cluster import ROOT, SOON, DaskCluster, runs_kept
from transport.run.dask import cluster as clusters
from transport.run.dask import executor as executors
from transport.run.dask import worker as workers
from transport.run.dask.executor import DaskExecutor

LIMITS = {
    "particles": {"particles": 40_001, "batches": 64},
    "error": {"error": {"ball.flux_in": 0.02}, "estimator": "analog"},
    "nets": {"particles": 30_000, "sampling": "sobol"},
}
KILLING = """
import os, signal
from transport.run.dask.worker import RunPlugin

work = RunPlugin.work

def dask_setup(worker):
    def killing(plugin, group, *arguments):
        if any(number == 37 for number, _ in group):
            os.kill(os.getpid(), signal.SIGKILL)
        return work(plugin, group, *arguments)
    RunPlugin.work = killing
"""
MANY = {"particles": 60_000, "batches": 300, "seed": 3}

pytestmark = pytest.mark.usefixtures("small_groups")


@pytest.fixture(scope="module")
def cluster():
    with DaskCluster(2) as cluster:
        yield cluster


@pytest.fixture(scope="module")
def whole():
    """What one process comes to."""
    return tp.simulate(scene(), **MANY, threads=2)


def happening(monkeypatch, act, parcel=5):
    """Something happens when so many parcels have come."""
    keep, came = DaskExecutor._store, []

    def kept(self, batches):
        came.append(batches)
        if len(came) == parcel:
            act()
        keep(self, batches)

    monkeypatch.setattr(DaskExecutor, "_store", kept)
    return came


def without_transport(folder):
    """A folder in which transport cannot be imported, though it be installed."""
    folder.mkdir()
    (folder / "transport.py").write_text("raise ImportError('there is no transport here')")
    return folder


def come_late(monkeypatch, cluster, path):
    """A worker of these sources comes between the first question to all and the first batch; it ends by itself without transport."""
    prepare = DaskExecutor.prepare

    def late(executor, *arguments):
        prepare(executor, *arguments)
        worker = cluster.start_worker(path)
        if (path / "transport.py").exists():
            worker.wait(SOON)
        else:
            cluster.wait_for(2)

    monkeypatch.setattr(DaskExecutor, "prepare", late)


@pytest.mark.parametrize("name", LIMITS)
def test_it_ends_as_in_one_process(cluster, name):
    here = tp.simulate(scene(), seed=3, threads=2, **LIMITS[name])
    there = tp.simulate(scene(), seed=3, cluster=cluster.address, **LIMITS[name])
    assert_same(there.batches, here.batches)
    assert there.cost.workers == there.cost.threads == 2
    assert there.warnings == here.warnings


def test_nobody_is_missed_when_a_worker_is_killed_and_another_comes_late(cluster, whole, monkeypatch):
    def act():
        cluster.workers.pop(0).kill()
        cluster.start_worker()

    happening(monkeypatch, act)
    assert_same(tp.simulate(scene(), **MANY, cluster=cluster.address).batches, whole.batches)
    cluster.wait_for(2)


def test_all_workers_killed_and_another_come(cluster, whole, monkeypatch):
    def act():
        for worker in cluster.workers:
            worker.kill()
        cluster.start_worker()

    happening(monkeypatch, act)
    assert_same(tp.simulate(scene(), **MANY, cluster=cluster.address).batches, whole.batches)
    cluster.start_worker()
    cluster.wait_for(2)


def test_a_parcel_that_comes_twice_counts_once(cluster, whole, monkeypatch):
    keep, first = DaskExecutor._store, []

    def kept(self, batches):
        first.append(batches)
        keep(self, batches)
        keep(self, first[0])

    monkeypatch.setattr(DaskExecutor, "_store", kept)
    result = tp.simulate(scene(), **MANY, cluster=cluster.address)
    assert_same(result.batches, whole.batches)
    assert result.state.ahead == {}  # where an interrupted run would have counted them again


def test_what_is_out_is_taken_back_when_time_is_up(cluster):
    result = tp.simulate(scene(), seconds=0.5, estimator="analog", cluster=cluster.address)
    assert result.is_complete and 0.5 < result.cost.seconds < 2
    cluster.wait_until_empty()


def test_ctrl_c_gives_what_is_done_and_it_goes_on_elsewhere(
    cluster, whole, monkeypatch, caplog, press_ctrl_c
):
    happening(monkeypatch, press_ctrl_c)
    stopped = tp.simulate(scene(), **MANY, cluster=cluster.address)
    assert not stopped.is_complete and 0 < stopped.particles < MANY["particles"]
    cluster.wait_until_empty()
    assert_same(tp.simulate(scene(), **MANY, resume=stopped).batches, whole.batches)
    assert [record.getMessage() for record in caplog.records if record.name == "asyncio"] == []


def test_a_client_of_ones_own_does(cluster, whole):
    from distributed import Client

    with Client(cluster.address) as client:
        assert_same(tp.simulate(scene(), **MANY, cluster=client).batches, whole.batches)
        assert client.status == "running"


def test_without_scheduler_a_run_ends_with_what_it_has(whole, monkeypatch):
    monkeypatch.setattr(clusters, "CONNECT_SECONDS", 1.0)
    with DaskCluster(1) as cluster:
        happening(monkeypatch, cluster.scheduler.kill)
        result = tp.simulate(scene(), **MANY, cluster=cluster.address)
    assert not result.is_complete and 0 < len(result.batches)
    assert any(f"the scheduler at {cluster.address} was lost" in warning for warning in result.warnings)
    with pytest.raises(tp.SceneError, match=r"no scheduler answers at tcp.*dask scheduler"):
        tp.simulate(scene(), **MANY, cluster=cluster.address)


def test_what_is_waited_for_in_vain_is_told_without_a_terminal_and_by_ctrl_c(monkeypatch):
    calls = iter([False, False])

    def is_met():
        try:
            return next(calls)
        except StopIteration:
            raise KeyboardInterrupt from None

    monkeypatch.setattr(executors, "SILENT_SECONDS", -1.0)
    told = pytest.warns(WaitingWarning, match=r"no workers at tcp://10\.0\.0\.1:8786; the run starts")
    with told, pytest.raises(KeyboardInterrupt, match="before the run began: no workers at"):
        executors._Waiting(Progress()).until(is_met, "no workers at tcp://10.0.0.1:8786")


def test_a_batch_that_kills_its_workers_is_named_and_no_other(whole, tmp_path, monkeypatch):
    """Though others wait beside it at each of them: whoever is suspected is tried by itself."""
    killing = tmp_path / "killing.py"
    killing.write_text(KILLING)
    monkeypatch.setenv("DASK_DISTRIBUTED__WORKER__PRELOAD", str([str(killing)]))
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES", "0")
    with DaskCluster(3) as deadly:
        result = tp.simulate(scene(), **MANY, cluster=deadly.address)
    assert not result.is_complete and len(result.batches) > 20
    assert "batch 37 (200 particles) killed 1 workers" in result.warnings[0]
    assert_same(tp.simulate(scene(), resume=result).batches, whole.batches)


def test_a_worker_that_does_not_answer_keeps_nobody_waiting(whole, monkeypatch):
    """Dask gives it up after its worker-ttl."""
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL", "1s")
    with DaskCluster(2) as cluster:
        os.kill(cluster.workers[0].pid, signal.SIGSTOP)
        result = tp.simulate(scene(), **MANY, cluster=cluster.address)
    assert_same(result.batches, whole.batches)
    assert result.cost.workers == 1


def test_an_error_travels_without_its_frames(monkeypatch):
    def fail(depth):
        if depth == 0:
            raise ValueError("deep")
        fail(depth - 1)

    plugin = SimpleNamespace(work=lambda *_: fail(500), compiled_program=lambda: fail(500), unlike=None)
    worker = SimpleNamespace(plugins={"run": plugin}, get_current_task=lambda: "task")
    monkeypatch.setattr(workers, "get_worker", lambda: worker)
    for act in (lambda: workers.compile_run("run"), lambda: workers.run_group("run", [(0, 1)], 1)):
        with pytest.raises(ValueError, match="deep") as error:
            act()
        assert len(error.traceback) < 10


def test_a_worker_without_the_memory_for_it_says_so(monkeypatch):
    monkeypatch.setattr("transport.run.memory.MIN_FREE", 0)
    monkeypatch.setattr("transport.run.memory.available_memory", lambda: 1000)
    settings = Settings(scene(), ANALOG, checked_limits(scene(), 10, None, None, None))
    plugin = workers.RunPlugin("run", pickle.dumps(settings), this_origin().sources)
    plugin.setup(SimpleNamespace(state=SimpleNamespace(nthreads=3), plugins={}))
    for _ in range(2):  # whoever asks
        with pytest.raises(
            tp.SceneError,
            match=r"a worker of the cluster: .* on each of 3 threads, and 0\.001 MB.*fewer threads",
        ):
            plugin.compiled_program()


def test_a_worker_of_other_sources_is_refused_by_name(cluster, whole, tmp_path, monkeypatch):
    """One that comes late is not used; the run goes on, and says so."""
    stranger = without_transport(tmp_path / "stranger")
    ignored = shutil.ignore_patterns("__kernels__", "__pycache__")
    shutil.copytree(ROOT / "transport", tmp_path / "transport", ignore=ignored)
    with (tmp_path / "transport/units.py").open("a") as units:
        units.write("# other\n")
    with DaskCluster(1) as mixed:
        come_late(monkeypatch, mixed, tmp_path)
        result = tp.simulate(scene(), **MANY, cluster=mixed.address)
        assert_same(result.batches, whole.batches)
        assert any("was not used: it has transport" in warning for warning in result.warnings)
        monkeypatch.undo()
        mixed.start_worker(stranger)
        mixed.wait_for(3)
        with pytest.raises(tp.SceneError) as refused:
            tp.simulate(scene(), **MANY, cluster=mixed.address)
    said = str(refused.value)
    assert "worker tcp://127.0.0.1:" in said and "of sources" in said and "cannot import transport" in said


@pytest.mark.parametrize(
    ("cluster", "said"),
    [
        ("somewhere", "must be an address or 'local'"),
        (3, "must be a Client or an address"),
        ("tcp://127.0.0.1:1", "threads"),
    ],
)
def test_wrong_input_is_refused(cluster, said):
    with pytest.raises(tp.SceneError, match=said):
        tp.simulate(scene(), particles=10, cluster=cluster, threads=2)


def test_a_script_needs_no_main_guard_and_loads_no_engine(tmp_path):
    """`cluster="local"`: processes of its own, gone when it ends."""
    script = tmp_path / "script.py"
    script.write_text(
        "import sys, transport as tp\nfrom tests.test_reproducible import digest, scene\n"
        "print(digest(scene(), cluster='local', threads=2), 'numba' in sys.modules)\n"
    )
    done = subprocess.run(
        [sys.executable, script],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    from tests.test_reproducible import digest

    assert done.stdout.split() == [digest(scene()), "False"] and done.stderr == ""


def test_nothing_is_left_behind(cluster):
    """No scene at a worker, no task at the scheduler."""
    from distributed import Client

    cluster.wait_until_empty()
    with Client(cluster.address, set_as_default=False) as client:
        assert set(client.run(runs_kept).values()) == {0}
