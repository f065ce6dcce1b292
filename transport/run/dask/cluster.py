"""The argument `simulate(cluster=...)`: a Client, a cluster, the address of a scheduler, or "local"."""

from __future__ import annotations

import json
import logging
import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from transport.validation import SceneError, pip_install, short_repr

LOCAL = "local"
ADVICE = "pass an address such as 'tcp://10.0.0.1:8786', a dask.distributed Client or cluster, or 'local'"
CONNECT_SECONDS = 10.0  # [s] within which a scheduler must answer
ORPHAN_SECONDS = 60.0  # [s] after which a local worker without a scheduler ends
SHUTDOWN_SECONDS = 5.0  # [s] that a local worker gets to end by itself


def checked_cluster(cluster: object) -> None:
    """Raise SceneError where `cluster` is none of these, or Dask is not installed."""
    try:
        import distributed  # noqa: F401
    except ImportError:
        raise SceneError(
            f"simulate: cluster needs Dask's distributed, which is not installed; {pip_install('cluster')}"
        ) from None
    if not isinstance(cluster, str):
        if _address_of(cluster) is None:
            state = " that is not closed" if hasattr(cluster, "scheduler") else ""
            must, got = f"cluster must be a Client or an address{state}", short_repr(cluster)
            raise SceneError(f"simulate: {must}, got {got}; {ADVICE}")
    elif cluster != LOCAL and ":" not in cluster:
        raise SceneError(
            f"simulate: cluster must be an address or 'local', got {short_repr(cluster)}; {ADVICE}"
        )


def _address_of(cluster: object) -> str | None:
    """Return the address of the scheduler of a Client or cluster; None for a closed one or anything else."""
    found = getattr(cluster, "scheduler_address", None)
    if not isinstance(found, str):
        found = getattr(getattr(cluster, "scheduler", None), "address", None)
    return found if isinstance(found, str) and found else None


@contextmanager
def open_client(cluster: object, threads: int) -> Iterator[tuple]:
    """Yield a client of the cluster, and the worker processes started by this process.

    The client is not the user's own, which may be asynchronous. threads: number of local worker processes.
    """
    from distributed import Client

    if isinstance(cluster, str) and cluster == LOCAL:
        with _local_workers(threads) as (address, processes), open_client(address, 0) as (client, _):
            yield client, processes
        return
    options = {"address": cluster if isinstance(cluster, str) else _address_of(cluster)}
    for name in ("security", "direct_to_workers"):
        if (value := getattr(cluster, name, None)) is not None:
            options[name] = value
    try:
        client = Client(**options, asynchronous=False, set_as_default=False, timeout=CONNECT_SECONDS)
    except OSError as error:
        cure = "start one with `dask scheduler`, and workers with `dask worker ADDRESS`"
        raise SceneError(
            f"simulate: cluster: no scheduler answers at {options['address']} ({error}); {cure}"
        ) from None
    with client:
        yield client, []


@contextmanager
def _local_workers(count: int) -> Iterator[tuple[str, list[subprocess.Popen]]]:
    """Start a scheduler in this process and worker processes of one thread; yield its address, and them.

    Workers end when the scheduler does, however it ends. They are fresh interpreters, neither forked nor
    spawned from this one, so that a script needs no main guard.
    """
    from distributed import LocalCluster

    quiet = {"dashboard": False, "dashboard_address": "127.0.0.1:0"}
    options = {"nthreads": 1, "death_timeout": ORPHAN_SECONDS, **quiet}
    what = json.dumps({"cls": "distributed.Worker", "opts": options})
    calm = os.environ | {"DASK_LOGGING__DISTRIBUTED": "error"}
    # start_new_session: Ctrl-C reaches the run, not its workers.
    apart = {"env": calm, "stdin": subprocess.DEVNULL, "start_new_session": True}
    with LocalCluster(n_workers=0, scheduler_kwargs=quiet, silence_logs=logging.CRITICAL) as scheduler:
        address = scheduler.scheduler_address
        command = [sys.executable, "-m", "distributed.cli.dask_spec", address, "--spec", what]
        processes: list[subprocess.Popen] = []
        try:
            processes += (subprocess.Popen(command, **apart) for _ in range(count))
            yield address, processes
        finally:
            scheduler.close()
            for process in processes:
                try:
                    process.wait(SHUTDOWN_SECONDS)
                except subprocess.TimeoutExpired:
                    process.kill()
                    process.wait()


def end_of(processes: Sequence[subprocess.Popen]) -> str | None:
    """Return how the local workers ended, and the advice; None while one runs, or where there are none."""
    codes = [process.poll() for process in processes]
    if None in codes or not codes:
        return None
    many = f"all {len(codes)} local workers have" if len(codes) > 1 else "the local worker has"
    endings = ", ".join(_ending(code) for code in sorted(set(codes)))
    if "SIGKILL" in endings:
        cure = "memory probably ran out: pass a smaller threads=, or"
    else:
        cure = "standard error may show why;"
    return f"{many} ended ({endings}); {cure} omit cluster='local' to compute in this process"


def _ending(code: int) -> str:
    return f"killed by {signal.Signals(-code).name}" if code < 0 else f"exit status {code}"


@contextmanager
def slot_released() -> Iterator[None]:
    """Release this thread's slot, where it runs a task of a Dask worker.

    The worker may then run other tasks, such as those of the run itself.
    """
    from distributed import rejoin, secede
    from distributed.worker import thread_state

    try:
        is_task = hasattr(thread_state, "key")
        if is_task:
            secede()
    except KeyError:  # the slot was released before
        is_task = False
    try:
        yield
    finally:
        if is_task:
            rejoin()
