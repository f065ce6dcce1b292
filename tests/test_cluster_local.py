"""Worker processes of `cluster="local"` that end or stop: nobody replaces them, so the run ends soon and says why."""

from __future__ import annotations

import signal
import time

import pytest

import transport as tp
from tests.same_batches import assert_same
from tests.test_reproducible import scene

pytest.importorskip("distributed")
import dask
import psutil

from tests.test_cluster import happening
from transport.run.dask import executor as executors

MANY = {"particles": 60_000, "batches": 300, "seed": 3}
LOCAL = {"cluster": "local", "threads": 2}
SOON = 30.0  # [s] in which a run must end once its last worker has
DYING = """
import os, signal
from transport.run.dask.worker import RunPlugin

def die(*_):
    os.kill(os.getpid(), signal.SIGKILL)

RunPlugin.{method} = die
"""

pytestmark = pytest.mark.usefixtures("small_groups")


def workers():
    """The worker processes of this one."""
    children = psutil.Process().children()
    return [child for child in children if "distributed.cli.dask_spec" in child.cmdline()]


def signal_workers(which, times):
    """Send it to all of them, and note the time."""
    found = workers()
    assert len(found) == 2
    for worker in found:
        worker.send_signal(which)
    times.append(time.monotonic())


@pytest.fixture
def preload(tmp_path, monkeypatch):
    """Let each worker run this code before it begins."""

    def preload(code):
        (tmp_path / "preload.py").write_text(code)
        monkeypatch.setenv("DASK_DISTRIBUTED__WORKER__PRELOAD", str([str(tmp_path / "preload.py")]))

    return preload


def test_a_run_ends_with_what_it_has_when_its_workers_are_killed(monkeypatch):
    killed = []
    happening(monkeypatch, lambda: signal_workers(signal.SIGKILL, killed))
    result = tp.simulate(scene(), **MANY, **LOCAL)
    assert time.monotonic() - killed[0] < SOON
    assert not result.is_complete and 0 < result.particles < MANY["particles"]
    (warning,) = (warning for warning in result.warnings if "local workers" in warning)
    assert "all 2 local workers have ended (killed by SIGKILL)" in warning
    assert "pass a smaller threads=, or omit cluster='local'" in warning
    assert_same(tp.simulate(scene(), resume=result, threads=2).batches, tp.simulate(scene(), **MANY).batches)


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
    one_at_most = dask.config.set({"distributed.scheduler.allowed-failures": 0})  # may die over a task
    with one_at_most, pytest.raises(tp.SceneError) as refused:
        tp.simulate(scene(), **MANY, **LOCAL)
    assert time.monotonic() - begun < SOON
    assert f"all 2 local workers have ended ({ending})" in str(refused.value)
    assert "omit cluster='local'" in str(refused.value)


def test_a_run_whose_workers_end_over_their_first_batches_says_so_in_a_line(preload, call):
    preload(DYING.format(method="work"))
    scene().to_json("scene.json")
    answer = call("run", "scene.json", "--particles", "1000", "--cluster", "local", "--threads", "2")
    waiting = ("workers compile or load passes", " 0 particles")  # lines of progress, on a slow machine
    lines = [line for line in answer.output.splitlines() if not any(words in line for words in waiting)]
    assert answer.exit_code == 1 and len(lines) == 1, answer.output
    assert lines[0].startswith("all 2 local workers have ended (killed by SIGKILL)")


def test_workers_that_are_frozen_are_waited_for_half_a_minute_at_most(monkeypatch):
    """Dask gives them up after its worker-ttl; since then no worker is there, though their processes are."""
    frozen = []
    happening(monkeypatch, lambda: signal_workers(signal.SIGSTOP, frozen))
    assert executors.LOCAL_WAIT_SECONDS <= SOON
    monkeypatch.setattr(executors, "LOCAL_WAIT_SECONDS", 1.0)
    with dask.config.set({"distributed.scheduler.worker-ttl": "1s"}):
        result = tp.simulate(scene(), **MANY, **LOCAL)
    assert time.monotonic() - frozen[0] < SOON
    assert not result.is_complete
    assert any("no workers at tcp://127.0.0.1:" in warning for warning in result.warnings)
