"""A scheduler and workers of one's own on loopback, each a process, all of which end with the test whatever happens."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from pathlib import Path

from distributed import Client

ROOT = Path(__file__).resolve().parents[1]
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
