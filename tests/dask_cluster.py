"""A scheduler and workers of one's own on loopback, each a process, all of which end with the test whatever happens.

What may happen to them while a run is under way is here as well: `with disturbed(cluster, "killed"):`.
"""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch

from distributed import Client

from tests.processes import ROOT
from transport.run.dask.executor import DaskExecutor
from transport.run.dask.worker import RunPlugin

SOON = 30.0  # [s] in which each of them must be there


class DaskCluster:
    """`with DaskCluster(2) as cluster:` so many workers of one thread at `cluster.address`."""

    def __init__(self, workers: int = 2) -> None:
        self.wanted, self.workers, self.started = workers, [], []
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.address = f"tcp://127.0.0.1:{free.getsockname()[1]}"

    def __enter__(self) -> DaskCluster:
        try:
            self.start_scheduler()
            for _ in range(self.wanted):
                self.start_worker()
            self.wait_for(self.wanted)
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        for process in self.started:
            process.kill()
        for process in self.started:
            process.wait()

    def start_scheduler(self) -> None:
        port = self.address.rpartition(":")[2]
        self.scheduler = self._start(
            *("dask_scheduler", "--host", "127.0.0.1", "--port", port, "--no-dashboard"),
            *("--idle-timeout", "600s"),  # where the tests are killed themselves, and workers end with it
        )

    def start_worker(self, path: Path = ROOT) -> subprocess.Popen:
        """A worker more, of the sources in that folder."""
        options = "--nthreads", "1", "--no-nanny", "--no-dashboard"
        self.workers.append(self._start("dask_worker", self.address, *options, path=path))
        return self.workers[-1]

    def freeze_worker(self) -> None:
        """The first of them keeps what it is given, and does nothing."""
        os.kill(self.workers[0].pid, signal.SIGSTOP)

    def kill_worker(self) -> None:
        """The first of them is gone, as where power fails."""
        worker = self.workers.pop(0)
        worker.kill()
        worker.wait()

    def wait_for(self, workers: int) -> None:
        """Until so many are there."""
        with Client(self.address, set_as_default=False, timeout=SOON) as client:
            client.wait_for_workers(workers, timeout=SOON)

    def wait_until_empty(self) -> None:
        """Until no task of anybody is there, nor any worker that does one."""
        deadline = time.monotonic() + SOON
        with Client(self.address, set_as_default=False) as client:
            while client.run_on_scheduler(_tasks) and time.monotonic() < deadline:
                time.sleep(0.05)
            assert client.run_on_scheduler(_tasks) == 0

    def _start(self, program: str, *options: str, path: Path = ROOT) -> subprocess.Popen:
        environment = os.environ | {"PYTHONPATH": str(path), "DASK_LOGGING__DISTRIBUTED": "critical"}
        command = [sys.executable, "-m", f"distributed.cli.{program}", *options]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self.started.append(
            subprocess.Popen(command, cwd=path, env=environment, start_new_session=True, **quiet)
        )
        return self.started[-1]


def _tasks(dask_scheduler) -> int:
    return len(dask_scheduler.tasks)


def runs_kept(dask_worker) -> int:
    """How many runs a worker keeps."""
    return sum(isinstance(plugin, RunPlugin) for plugin in dask_worker.plugins.values())


def executing(dask_worker) -> int:
    """How many tasks a worker does at present."""
    return len(dask_worker.state.executing)


# ---- what happens while a run is under way ----


@contextmanager
def disturbed(cluster: DaskCluster, how: str | None) -> Iterator[list[str]]:
    """In the next run something happens to the cluster: "killed", a worker that holds batches, or where it is the only one
    it, and another comes;  "late", one more comes once the run has begun;  or nothing.  Yields what has happened, once batches have come since."""
    happened: list[str] = []
    begins, comes = _acts(cluster, how)

    def come() -> None:
        comes()
        happened.extend([how] * (how is not None))

    try:
        with _first(DaskExecutor, "_start", begins), _first(DaskExecutor, "_store", come):
            yield happened
    finally:
        if how == "killed" and not happened:  # nothing was to be done
            os.kill(cluster.workers[0].pid, signal.SIGCONT)


def _acts(cluster: DaskCluster, how: str | None) -> tuple[Callable[[], None], Callable[[], None]]:
    """What to do before the run hands out its batches, and before it takes in the first that come."""
    many = len(cluster.workers)

    def one_more() -> None:
        cluster.start_worker()
        cluster.wait_for(many + 1)

    def another() -> None:
        cluster.kill_worker()
        cluster.start_worker()

    if how == "killed":
        return (cluster.freeze_worker, cluster.kill_worker) if many > 1 else (_nothing, another)
    return {
        "late": (one_more, _nothing),
        None: (_nothing, _nothing),
    }[how]


@contextmanager
def _first(kind: type, name: str, act: Callable[[], None]) -> Iterator[None]:
    """Act before the first call of a method."""
    called, is_due = getattr(kind, name), [True]

    def acting(self, *arguments):
        if is_due:
            is_due.clear()
            act()
        return called(self, *arguments)

    with patch.object(kind, name, acting):
        yield


def _nothing() -> None:
    pass
