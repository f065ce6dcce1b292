"""Batches of a cluster's workers are those of one process, bit for bit: killed, late, of a scheduler that died, or stopped.

The default suite runs one cluster; what happens to workers under way takes processes and time, and is slow.
"""

from __future__ import annotations

import json
import pickle
import re
import shutil
import signal
import time
from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import transport as tp
from tests.plain_scenes import SMALL
from tests.plain_scenes import room as scene
from tests.processes import ROOT, python
from tests.same_batches import assert_same
from transport.cli.docs import GUIDES
from transport.compile.limits_exceeded import OverrunError
from transport.compile.methods import ANALOG
from transport.engine.driver import Stopped
from transport.run import run
from transport.run.executor import WorkersLost
from transport.run.progress import Progress, WaitingWarning
from transport.run.provenance import this_origin
from transport.run.settings import Settings, checked_limits

pytest.importorskip("distributed")
import dask
import psutil
from distributed import Client, KilledWorker

from tests.dask_cluster import SOON, DaskCluster, executing, runs_kept
from transport.run.dask import cluster as clusters
from transport.run.dask import executor as executors
from transport.run.dask import worker as workers
from transport.run.dask.executor import DaskExecutor, Groups

MANY = {"particles": 30_000, "batches": 150, "seed": 3}
FEW = {"particles": 5_000, "seed": 4}
LOCAL = {"cluster": "local", "threads": 2}
ONE_MAY_DIE = {"distributed.scheduler.allowed-failures": 0}  # workers over a task

pytestmark = pytest.mark.usefixtures("small_groups", "frequent_counts")


@pytest.fixture
def frequent_counts(monkeypatch):
    """Workers are counted ten times per second, so that no test waits a second for their loss."""
    monkeypatch.setattr(executors, "WATCH_SECONDS", 0.1)


@pytest.fixture(scope="module")
def cluster():
    with DaskCluster(2) as cluster:
        yield cluster


@pytest.fixture(scope="module")
def whole():
    """What one process comes to."""
    return tp.simulate(scene(), **MANY, threads=2).batches


@pytest.fixture
def preload(tmp_path, monkeypatch):
    """A function that lets each new worker run this code before it begins."""

    def preload(code):
        (tmp_path / "preload.py").write_text(code)
        monkeypatch.setenv("DASK_DISTRIBUTED__WORKER__PRELOAD", str([str(tmp_path / "preload.py")]))

    return preload


def before(monkeypatch, method, act):
    """Do something before each call of a method of the executor."""
    called = getattr(DaskExecutor, method)

    def acting(executor, *arguments):
        act(*arguments)
        return called(executor, *arguments)

    monkeypatch.setattr(DaskExecutor, method, acting)


def happening(monkeypatch, act, parcel=5):
    """Something happens when so many parcels have come."""
    came = []

    def count(batches):
        came.append(batches)
        if len(came) == parcel:
            act()

    before(monkeypatch, "_store", count)


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


# ---- which batches go out together, when, and what is done with those over which workers died ----


def test_groups_take_half_a_second_and_less_towards_the_end():
    groups = Groups(seconds=0.5)
    groups.put_back((number, 1000) for number in range(1000))
    assert len(groups.take(2)) == 1  # nothing is known yet
    groups.add([(1000, 0.01)] * 100, 1000)
    taken = []
    while groups.waiting:
        taken.append(groups.take(2))
    assert [number for group in taken for number, _ in group] == list(range(1, 1000))
    sizes = np.array([len(group) for group in taken])
    assert 49 <= sizes[0] <= 50 and sizes[-1] == 1 and (np.diff(sizes) <= 0).all()
    assert groups.left == 0
    groups.put_back(taken[3])
    assert groups.left == 1000 * len(taken[3]) and groups.waiting[0] == taken[3][0]
    groups.put_back((number, 1000) for number in range(10_000))
    groups.add([(1000, 0.01)] * 100, 100 << 25)
    assert len(groups.take(2)) == 1  # large sums travel alone


class Sent(DaskExecutor):
    """Without a cluster: what would be sent to two workers of one thread."""

    def __init__(self, batches, **state):
        self.groups, self.suspects, self.suspect = Groups(), [], None
        self.next, self.ahead, self.done, self.in_flight = 0, {}, [], {}
        self.max_ahead_bytes, self.worker_threads = float("inf"), {"a": 1, "b": 1}
        self.groups.put_back(batches)
        for name, value in state.items():
            setattr(self, name, value)

    def send(self):
        """Send all that may be sent now; return their groups."""
        sent = []
        while group := self._next_group():
            self.in_flight[len(sent), self.next] = group
            sent.append(group)
        return sent


def test_batches_ahead_of_their_turn_are_bounded():
    """Where one worker is slow the others wait for it, but for what fits: so many bytes ahead."""
    sums = Sent([(number, 1000) for number in range(5, 105)], next=5, max_ahead_bytes=1000)
    sums.worker_threads = {"a": 100}
    sums.groups.batch_bytes = 100.0
    assert [group[0][0] for group in sums.send()] == list(range(5, 15))
    sums.next = 6
    assert sums.send() == [[(15, 1000)]]


def test_suspects_are_tried_one_at_a_time():
    """When nothing else is in flight: Dask blames all tasks of a dead worker."""
    killed = KilledWorker("task", SimpleNamespace(address="tcp://a"), 0)
    died = "future", (KilledWorker, killed, None)
    sums = Sent([(number, 1000) for number in range(4)])
    sums.groups.most = 2
    sums.in_flight = {died[0]: [(8, 10), (9, 10)], "another": [(7, 10)]}
    sums._take_in(*died)
    assert sums.send() == []  # another is in flight
    sums.in_flight.clear()
    assert sums.send() == [[(8, 10)]]
    sums.in_flight, sums.suspect = {}, None  # it was no cause
    assert sums.send() == [[(9, 10)]]
    sums.in_flight = {died[0]: sums.suspect}
    with pytest.raises(WorkersLost, match=r"batch 9 \(10 particles\) killed 1 workers; the last was tcp://a"):
        sums._take_in(*died)


# ---- the worker's side, and waiting ----


def plugin_of(name="run", there=None, particles=100):
    """A run as a worker of one thread has it."""
    there = there or SimpleNamespace(state=SimpleNamespace(nthreads=1), plugins={})
    settings = pickle.dumps(Settings(SMALL, ANALOG, checked_limits(SMALL, particles, None, None, None)))
    there.plugins[name] = plugin = workers.RunPlugin(name, settings, this_origin().sources)
    plugin.setup(there)
    return plugin


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


def test_a_worker_without_enough_memory_is_reported(monkeypatch):
    monkeypatch.setattr("transport.run.memory.MIN_FREE", 0)
    monkeypatch.setattr("transport.run.memory.available_memory", lambda: 1000)
    plugin = plugin_of(there=SimpleNamespace(state=SimpleNamespace(nthreads=3), plugins={}))
    words = r"a worker of the cluster: .* on each of 3 threads, and 0\.001 MB.*fewer threads"
    for _ in range(2):  # whoever asks
        with pytest.raises(tp.SceneError, match=words):
            plugin.compiled_program()


def test_a_worker_forgets_the_program_of_a_run_whose_client_was_killed():
    """When another run begins: Dask keeps the plugin, but not what takes memory."""
    there = SimpleNamespace(state=SimpleNamespace(nthreads=1), plugins={})

    def begin(name):
        plugin = plugin_of(name, there)
        plugin.compiled_program()
        plugin.work([(0, 100)], 1, "task")
        return plugin

    killed, other = begin("killed"), begin("other")
    assert killed.compiled and killed.free and not killed.busy
    killed.used -= 2 * workers.IDLE_SECONDS
    begin("next")
    assert killed.compiled is None and not killed.free and other.compiled
    again, _ = killed.work([(0, 100)], 1, "task")  # its client was not
    assert_same(list(again.values()), list(other.work([(0, 100)], 1, "task")[0].values()))


def test_a_cancelled_task_stops_and_no_other():
    plugin = plugin_of()
    one, other = plugin._take_bundle("one"), plugin._take_bundle("other")
    plugin.transition("one", "executing", "memory")
    assert one["stop"] == other["stop"] == 0
    plugin.transition("one", "executing", "released")
    assert one["stop"] == 1 and other["stop"] == 0
    plugin.teardown(SimpleNamespace(plugins={}))
    assert other["stop"] == 1
    with pytest.raises(Stopped):
        plugin._take_bundle("next")


def test_waiting_in_vain_is_reported_without_a_terminal_and_by_ctrl_c(monkeypatch):
    calls = iter([False, False])

    def is_met():
        try:
            return next(calls)
        except StopIteration:
            raise KeyboardInterrupt from None

    monkeypatch.setattr(executors, "SILENT_SECONDS", -1.0)
    warned = pytest.warns(WaitingWarning, match=r"no workers at tcp://10\.0\.0\.1:8786; the run starts")
    with warned, pytest.raises(KeyboardInterrupt, match="before the run began: no workers at"):
        executors._Waiting(Progress()).until(is_met, "no workers at tcp://10.0.0.1:8786")


@pytest.mark.quick_cases("somewhere-2-must be an address or 'local'", "3-2-must be a Client or an address")
@pytest.mark.parametrize(
    ("cluster", "threads", "said"),
    [
        ("somewhere", 2, "must be an address or 'local'"),
        (3, 2, "must be a Client or an address"),
        ("tcp://127.0.0.1:1", 2, "threads must not be given with a cluster"),
        ("tcp://127.0.0.1:1", None, "no scheduler answers at tcp://127.0.0.1:1"),
    ],
)
def test_a_wrong_cluster_is_refused_by_simulate_and_in_one_line_by_the_command(
    call, monkeypatch, cluster, threads, said
):
    monkeypatch.setattr(clusters, "CONNECT_SECONDS", 1.0)
    with pytest.raises(tp.SceneError, match=said):
        tp.simulate(SMALL, particles=10, cluster=cluster, threads=threads)
    if isinstance(cluster, str):
        SMALL.to_json("small.json")
        options = () if threads is None else ("--threads", threads)
        answer = call("run", "small.json", "--cluster", cluster, *options)
        assert answer.exit_code == 2 and said in answer.output, answer.output
        assert len(answer.output.splitlines()) == 1, answer.output


# ---- one cluster ----

LIMITS = {
    "particles": {"particles": 40_001, "batches": 64},
    "error": {"error": {"ball.flux_in": 0.02}, "estimator": "analog"},
    "nets": {"particles": 30_000, "sampling": "sobol"},
}


@pytest.mark.slow
@pytest.mark.parametrize("name", LIMITS)
def test_a_run_on_a_cluster_ends_as_in_one_process(cluster, name):
    here = tp.simulate(scene(), seed=3, threads=2, **LIMITS[name])
    there = tp.simulate(scene(), seed=3, cluster=cluster.address, **LIMITS[name])
    assert_same(there.batches, here.batches)
    assert there.cost.workers == there.cost.threads == 2
    assert there.warnings == here.warnings


@pytest.mark.slow
def test_a_parcel_that_comes_twice_counts_once(cluster, whole, monkeypatch):
    keep, first = DaskExecutor._store, []

    def kept(self, batches):
        first.append(batches)
        keep(self, batches)
        keep(self, first[0])

    monkeypatch.setattr(DaskExecutor, "_store", kept)
    with Client(cluster.address) as client:  # one's own does as well as an address
        result = tp.simulate(scene(), **MANY, cluster=client)
        assert client.status == "running"
    assert_same(result.batches, whole)
    assert result.state.ahead == {}  # where an interrupted run would have counted them again


@pytest.mark.slow
def test_ctrl_c_gives_what_is_done_and_it_goes_on_elsewhere(
    cluster, whole, monkeypatch, caplog, press_ctrl_c
):
    happening(monkeypatch, press_ctrl_c)
    stopped = tp.simulate(scene(), **MANY, cluster=cluster.address)
    assert not stopped.is_complete and 0 < stopped.particles < MANY["particles"]
    cluster.wait_until_empty()
    assert_same(tp.simulate(scene(), **MANY, resume=stopped).batches, whole)
    assert [record.getMessage() for record in caplog.records if record.name == "asyncio"] == []


@pytest.mark.slow
def test_batches_that_are_out_are_taken_back_when_time_is_up(cluster):
    result = tp.simulate(scene(), seconds=0.5, estimator="analog", cluster=cluster.address)
    assert result.is_complete and 0.5 < result.cost.seconds < 2
    cluster.wait_until_empty()


@pytest.mark.slow
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


@pytest.mark.slow
def test_a_task_may_run_on_the_cluster_that_it_is_done_by(cluster):
    """Its own worker does the batches, though it has but one thread."""

    def task(scene, limits, address):
        import transport

        return transport.simulate(scene, **limits, cluster=address, progress=False).batches

    with Client(cluster.address, set_as_default=False) as client:
        batches = client.submit(task, SMALL, FEW, cluster.address, pure=False).result(timeout=60)
    assert_same(batches, tp.simulate(SMALL, **FEW, threads=1).batches)


@pytest.mark.slow
def test_an_overrun_at_a_worker_is_that_of_one_process(cluster):
    fog = tp.Medium(absorption=0.3, scattering=2.7)
    beam = tp.Source(tp.Point(position=(0, 0, 3)), tp.Beam((0, 0, -1), power=1.0))
    foggy = tp.Scene(beam, tp.Surface(tp.Sphere(radius=1.0), tp.Transparent(), inside=fog))
    split = tp.Splitting(start=(0, 0, 1), end=(0, 0, -1), gain=1e30)
    how = {"particles": 20_000, "tracking": tp.Tracking(splitting=split)}
    said = []
    for where in ({"threads": 1}, {"cluster": cluster.address}):
        with pytest.raises(OverrunError, match="Splitting: gain") as overrun:
            tp.simulate(foggy, **how, **where)
        said.append(
            re.sub(r"made \d+ copies", "made copies", str(overrun.value))
        )  # of whichever batch is first
    assert said[0] == said[1]
    cluster.wait_until_empty()
    assert tp.simulate(SMALL, **FEW, cluster=cluster.address).is_complete  # the worker is none the worse


@pytest.mark.slow
def test_pilots_run_here_and_the_estimator_that_they_choose_there(cluster, monkeypatch):
    opened = []
    before(monkeypatch, "prepare", lambda *arguments: opened.append(arguments))
    there = tp.simulate(SMALL, **FEW, estimator="auto", cluster=cluster.address)
    assert len(opened) == 1 and len(there.choice.pilots) > 1
    method = there.plan.method
    here = tp.simulate(SMALL, **FEW, estimator=method.estimator, sampling=method.sampling, threads=1)
    assert_same(there.batches, here.batches)


@pytest.mark.slow
def test_a_machine_that_did_no_batch_is_not_among_those_that_did(
    cluster, tmp_path, monkeypatch, press_ctrl_c
):
    """A run is begun by workers, and gone on with by them, from a machine of another kind."""
    other = replace(this_origin(), machine="a machine of another kind")
    monkeypatch.setattr(run, "this_origin", lambda: other)
    with monkeypatch.context() as patch:
        happening(patch, press_ctrl_c)
        tp.simulate(scene(), **MANY, cluster=cluster.address).save(tmp_path / "begun.npz")
    ended = tp.simulate(scene(), resume=tmp_path / "begun.npz", cluster=cluster.address)
    assert ended.is_complete and ended.state.origins == (this_origin(),)
    assert not any("different machines" in warning for warning in ended.warnings)
    here = tp.simulate(scene(), resume=tmp_path / "begun.npz", threads=1)
    assert here.state.origins == (this_origin(), other)  # which did do some


@pytest.mark.slow
def test_the_command_line_sends_a_run_to_a_cluster(cluster, call):
    SMALL.to_json("small.json")

    def record(*options):
        answer = call("run", "small.json", "--particles", "5000", "--seed", "4", "--json", *options)
        assert answer.exit_code == 0, answer.output
        return json.loads(answer.stdout)

    there = record("--cluster", cluster.address, "--save", "there.npz")
    assert there["quantities"] == record("--threads", "1")["quantities"]
    assert there["cost"]["workers"] == there["cost"]["threads"] == tp.load("there.npz").cost.workers == 2


@pytest.mark.slow
def test_the_example_of_the_guide_runs(cluster):
    """But for its address and its size."""
    text = (GUIDES / "clusters.md").read_text(encoding="utf-8")
    example = text.split("```py", 1)[1].split("\n", 1)[1].split("```")[0]
    assert "tcp://10.0.0.1:8786" in example and "100_000_000" in example
    known = {}
    exec(example.replace("tcp://10.0.0.1:8786", cluster.address).replace("100_000_000", "10_000"), known)
    assert known["result"].particles == 10_000 and known["result"].cost.workers == 2


@pytest.mark.slow
def test_no_scene_stays_at_a_worker_and_no_task_at_the_scheduler(cluster):
    cluster.wait_until_empty()
    with Client(cluster.address, set_as_default=False) as client:
        assert set(client.run(runs_kept).values()) == {0}


# ---- workers and schedulers that are killed, late or strangers ----


@pytest.mark.slow
@pytest.mark.parametrize("lost", ["workers", "scheduler"])
def test_a_run_without_workers_or_scheduler_ends_with_what_it_has_and_goes_on_elsewhere(
    whole, monkeypatch, lost
):
    monkeypatch.setattr(executors, "WAIT_SECONDS", 0.5)
    monkeypatch.setattr(clusters, "CONNECT_SECONDS", 1.0)
    with DaskCluster(1) as cluster:
        happening(monkeypatch, cluster.kill_worker if lost == "workers" else cluster.scheduler.kill)
        result = tp.simulate(scene(), **MANY, cluster=cluster.address)
    assert not result.is_complete and 0 < result.particles < MANY["particles"]
    no_workers, no_scheduler = (
        f"no workers at {cluster.address} for 0.5 s",
        f"the scheduler at {cluster.address} was lost",
    )
    words = no_workers if lost == "workers" else no_scheduler
    assert any(words in warning for warning in result.warnings)
    assert_same(tp.simulate(scene(), resume=result, threads=2).batches, whole)
    with pytest.raises(tp.SceneError, match=r"no scheduler answers at tcp.*dask scheduler"):
        tp.simulate(scene(), **MANY, cluster=cluster.address)


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


@pytest.mark.slow
def test_a_batch_that_kills_its_workers_is_named_and_no_other(whole, preload, monkeypatch):
    """Though others wait beside it at each of them: whoever is suspected is tried by itself."""
    preload(KILLING)
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES", "0")
    with DaskCluster(2) as deadly:
        result = tp.simulate(scene(), **MANY, cluster=deadly.address)
    assert not result.is_complete and len(result.batches) > 20
    assert "batch 37 (200 particles) killed 1 workers" in result.warnings[0]
    assert_same(tp.simulate(scene(), resume=result).batches, whole)


@pytest.mark.slow
def test_a_worker_that_does_not_answer_keeps_nobody_waiting(whole, monkeypatch):
    """Dask gives it up after its worker-ttl."""
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL", "1s")
    with DaskCluster(2) as cluster:
        cluster.freeze_worker()
        result = tp.simulate(scene(), **MANY, cluster=cluster.address)
    assert_same(result.batches, whole)
    assert result.cost.workers == 1


@pytest.mark.slow
def test_a_stranger_that_ends_over_its_batches_takes_none_along(cluster, whole, tmp_path, monkeypatch):
    """Dask ends a worker that cannot read what the run gives to all."""
    monkeypatch.setattr(executors, "GROUPS_IN_FLIGHT", 40)  # of which it would get some
    come_late(monkeypatch, cluster, without_transport(tmp_path / "stranger"))
    result = tp.simulate(scene(), **MANY, cluster=cluster.address)
    assert_same(result.batches, whole)
    assert result.cost.workers == 2


@pytest.mark.slow
def test_a_worker_of_other_sources_is_refused_by_name(whole, tmp_path, monkeypatch):
    """One that comes late is not used; the run goes on, and says so."""
    stranger = without_transport(tmp_path / "stranger")
    ignored = shutil.ignore_patterns("__kernels__", "__pycache__")
    shutil.copytree(ROOT / "transport", tmp_path / "transport", ignore=ignored)
    with (tmp_path / "transport/units.py").open("a") as units:
        units.write("# other\n")
    with DaskCluster(1) as mixed:
        come_late(monkeypatch, mixed, tmp_path)
        result = tp.simulate(scene(), **MANY, cluster=mixed.address)
        assert_same(result.batches, whole)
        assert any("was not used: it has transport" in warning for warning in result.warnings)
        monkeypatch.undo()
        mixed.start_worker(stranger)
        mixed.wait_for(3)
        with pytest.raises(tp.SceneError) as refused:
            tp.simulate(scene(), **MANY, cluster=mixed.address)
    said = str(refused.value)
    assert "worker tcp://127.0.0.1:" in said and "of sources" in said and "cannot import transport" in said


# ---- processes of one's own, which nobody replaces ----

DYING = """
import os, signal
from transport.run.dask.worker import RunPlugin

def die(*_):
    os.kill(os.getpid(), signal.SIGKILL)

RunPlugin.{method} = die
"""


def signal_local_workers(which):
    """Send it to both worker processes of this one."""
    children = psutil.Process().children()
    found = [child for child in children if "distributed.cli.dask_spec" in child.cmdline()]
    assert len(found) == 2
    for worker in found:
        worker.send_signal(which)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("which", "said"),
    [
        (signal.SIGKILL, "all 2 local workers have ended (killed by SIGKILL)"),
        (signal.SIGSTOP, "no workers at tcp://127.0.0.1:"),
    ],
    ids=["killed", "frozen"],
)
def test_a_run_ends_soon_with_what_it_has_when_its_workers_are_killed_or_frozen(
    whole, monkeypatch, which, said
):
    """Dask gives frozen ones up after its worker-ttl; since then no worker is there, though their processes are."""
    happened = []
    happening(monkeypatch, lambda: (signal_local_workers(which), happened.append(time.monotonic())))
    assert executors.LOCAL_WAIT_SECONDS <= SOON
    monkeypatch.setattr(executors, "LOCAL_WAIT_SECONDS", 1.0)
    monkeypatch.setattr(clusters, "SHUTDOWN_SECONDS", 0.5)  # frozen workers do not end by themselves
    ttl = (
        dask.config.set({"distributed.scheduler.worker-ttl": "1s"})
        if which == signal.SIGSTOP
        else nullcontext()
    )
    with ttl:
        result = tp.simulate(scene(), **MANY, **LOCAL)
    assert time.monotonic() - happened[0] < SOON
    assert not result.is_complete and 0 < result.particles < MANY["particles"]
    (warning,) = (warning for warning in result.warnings if said in warning)
    assert which == signal.SIGSTOP or "pass a smaller threads=, or omit cluster='local'" in warning
    assert_same(tp.simulate(scene(), resume=result, threads=2).batches, whole)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("code", "ending"),
    [
        ("import os\ndef dask_setup(worker):\n    os._exit(3)\n", "exit status 3"),
        (DYING.format(method="compiled_program"), "killed by SIGKILL"),
        (
            DYING.format(method="compiled_program") + "RunPlugin._prepare = lambda _: None\n",
            "killed by SIGKILL",
        ),
    ],
    ids=["as they start", "as they compile", "one after the other"],
)
def test_a_run_whose_workers_end_before_the_first_batch_is_refused(preload, code, ending):
    preload(code)
    begun = time.monotonic()
    with dask.config.set(ONE_MAY_DIE), pytest.raises(tp.SceneError, match="omit cluster='local'") as refused:
        tp.simulate(scene(), **MANY, **LOCAL)
    assert time.monotonic() - begun < SOON
    assert f"all 2 local workers have ended ({ending})" in str(refused.value)


@pytest.mark.slow
def test_a_run_whose_workers_end_over_their_first_batches_is_refused_in_a_line(preload, call):
    preload(DYING.format(method="work"))
    scene().to_json("scene.json")
    answer = call("run", "scene.json", "--particles", "1000", "--cluster", "local", "--threads", "2")
    waiting = ("workers compile or load passes", " 0 particles")  # lines of progress, on a slow machine
    lines = [line for line in answer.output.splitlines() if not any(words in line for words in waiting)]
    assert answer.exit_code == 1 and len(lines) == 1, answer.output
    assert lines[0].startswith("all 2 local workers have ended (killed by SIGKILL)")


@pytest.mark.slow
def test_a_script_needs_no_main_guard_and_loads_no_engine(tmp_path):
    """`cluster="local"`: processes of its own, gone when it ends."""
    SMALL.to_json(tmp_path / "small.json")
    (tmp_path / "script.py").write_text(
        "import sys, transport as tp\nscene = tp.Scene.from_json('small.json')\n"
        f"result = tp.simulate(scene, **{FEW}, cluster='local', threads=2)\n"
        "result.save('run.npz')\nprint('numba' in sys.modules)\n"
    )
    done = python("script.py", folder=tmp_path)
    assert (done.stdout, done.stderr) == ("False\n", "")
    there = tp.load(tmp_path / "run.npz")
    assert_same(there.batches, tp.simulate(SMALL, **FEW, threads=1).batches)
    assert there.cost.workers == there.cost.threads == 2
