"""The argument `simulate(cluster=...)`: a Client, a cluster, the address of a scheduler, or "local"."""

from __future__ import annotations

import asyncio
import json
import logging
import os
import signal
import sys
from collections.abc import AsyncIterator, Iterator, Sequence
from contextlib import asynccontextmanager, contextmanager, suppress
from dataclasses import dataclass

from transport.validation import SceneError, pip_install, short_repr

LOCAL = "local"
ADVICE = "pass an address such as 'tcp://10.0.0.1:8786', a dask.distributed Client or cluster, or 'local'"
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
            raise SceneError(
                f"simulate: cluster must be a Client or an address{state}, got {short_repr(cluster)};"
                f" {ADVICE}"
            )
    elif cluster != LOCAL and ":" not in cluster:
        raise SceneError(
            f"simulate: cluster must be an address or 'local', got {short_repr(cluster)}; {ADVICE}"
        )


@dataclass(frozen=True)
class LocalWorkers:
    """The worker processes of cluster="local", which nothing restarts."""

    processes: Sequence[asyncio.subprocess.Process]

    @property
    def end(self) -> str | None:
        """Return how the workers ended, and the advice; None while one of them runs."""
        codes = [process.returncode for process in self.processes]
        if None in codes:
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


@asynccontextmanager
async def open_cluster(
    cluster: object, threads: int
) -> AsyncIterator[tuple[dict[str, object], LocalWorkers | None]]:
    """Yield the arguments of a Client of this cluster, and the workers started by this process.

    threads: number of local worker processes, which end with the context.
    """
    if isinstance(cluster, str) and cluster == LOCAL:
        async with _local(threads) as (address, workers):
            yield {"address": address}, workers
    elif isinstance(cluster, str):
        yield {"address": cluster}, None
    else:
        options = {"address": _address_of(cluster), "security": getattr(cluster, "security", None)}
        direct = getattr(cluster, "direct_to_workers", None)
        yield options | ({} if direct is None else {"direct_to_workers": direct}), None


def _address_of(cluster: object) -> str | None:
    """Return the address of the scheduler of a Client or cluster; None for a closed one or anything else."""
    found = getattr(cluster, "scheduler_address", None)
    if not isinstance(found, str):
        found = getattr(getattr(cluster, "scheduler", None), "address", None)
    return found if isinstance(found, str) and found else None


@asynccontextmanager
async def _local(threads: int) -> AsyncIterator[tuple[str, LocalWorkers]]:
    """Start a scheduler in this process and one worker process per thread.

    Workers end when the scheduler does, however it ends. They are fresh interpreters, neither forked nor
    spawned from this one, so that a script needs no main guard.
    """
    from distributed import Scheduler

    quiet = {"dashboard": False, "dashboard_address": "127.0.0.1:0"}
    async with Scheduler(host="127.0.0.1", port=0, **quiet) as scheduler:
        what = json.dumps(
            {"cls": "distributed.Worker", "opts": {"nthreads": 1, "death_timeout": ORPHAN_SECONDS, **quiet}}
        )
        calm = os.environ | {"DASK_LOGGING__DISTRIBUTED": "error"}
        # start_new_session: Ctrl-C reaches the run, not its workers.
        apart = {
            "env": calm,
            "stdin": asyncio.subprocess.DEVNULL,
            "start_new_session": True,
        }
        command = ["-m", "distributed.cli.dask_spec", scheduler.address, "--spec", what]
        workers = [
            await asyncio.create_subprocess_exec(sys.executable, *command, **apart) for _ in range(threads)
        ]
        try:
            yield scheduler.address, LocalWorkers(workers)
        finally:
            await scheduler.close()
            await asyncio.gather(*map(_wait_or_kill, workers))


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


@contextmanager
def silenced(thread: str) -> Iterator[None]:
    """Silence Dask's log messages of this thread, below critical: the run reports itself what happens."""
    import distributed  # noqa: F401  # creates the log handlers; the user's own handlers stay as they are

    handlers = list(logging.getLogger("distributed").handlers)

    def is_news(record: logging.LogRecord) -> bool:
        return record.threadName != thread or record.levelno >= logging.CRITICAL

    for handler in handlers:
        handler.addFilter(is_news)
    try:
        yield
    finally:
        for handler in handlers:
            handler.removeFilter(is_news)


async def _wait_or_kill(worker: asyncio.subprocess.Process) -> None:
    """Wait until a worker process has ended; kill it after SHUTDOWN_SECONDS."""
    with suppress(TimeoutError):
        async with asyncio.timeout(SHUTDOWN_SECONDS):
            await worker.wait()
    if worker.returncode is None:
        worker.kill()
        await worker.wait()
