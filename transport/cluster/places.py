"""What `simulate(cluster=...)` takes: a Client, a cluster, the address of a scheduler, or "local"."""

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

from transport.validation import SceneError, shown

LOCAL = "local"
CURE = "write the address of a scheduler, such as 'tcp://10.0.0.1:8786', a dask.distributed Client or cluster, or 'local'"
LONELY = 60.0  # [s] after which a local worker ends that finds no scheduler
DYING = 5.0  # [s] that a local worker gets to end by itself


def checked_cluster(cluster: object) -> None:
    """Raises SceneError where it is none of these, or where Dask is missing."""
    try:
        import distributed  # noqa: F401
    except ImportError:
        cure = "pip install '.[cluster]' in the clone"
        raise SceneError(
            f"simulate: cluster needs Dask's distributed, which is not installed; {cure}"
        ) from None
    if not isinstance(cluster, str):
        if _address_of(cluster) is None:
            state = " that is not closed" if hasattr(cluster, "scheduler") else ""
            raise SceneError(
                f"simulate: cluster must be a Client or an address{state}, got {shown(cluster)}; {CURE}"
            )
    elif cluster != LOCAL and ":" not in cluster:
        raise SceneError(f"simulate: cluster must be an address or 'local', got {shown(cluster)}; {CURE}")


@dataclass(frozen=True)
class LocalWorkers:
    """The worker processes of `cluster="local"`, which nothing restarts."""

    processes: Sequence[asyncio.subprocess.Process]

    @property
    def end(self) -> str | None:
        """How they ended, and what to do; None while one of them runs."""
        codes = [process.returncode for process in self.processes]
        if None in codes:
            return None
        many = f"all {len(codes)} local workers have" if len(codes) > 1 else "the local worker has"
        endings = ", ".join(_ending(code) for code in sorted(set(codes)))
        if "SIGKILL" in endings:
            cure = "most likely memory ran out: pass a smaller threads=, or"
        else:
            cure = "standard error may show why;"
        return f"{many} ended ({endings}); {cure} leave out cluster='local' to compute in this process"


def _ending(code: int) -> str:
    return f"killed by {signal.Signals(-code).name}" if code < 0 else f"exit status {code}"


@asynccontextmanager
async def reached(
    cluster: object, threads: int
) -> AsyncIterator[tuple[dict[str, object], LocalWorkers | None]]:
    """What a Client of this cluster is made with, and the workers that this process has started for it.

    threads: of a local one, a process each, which end with the context.
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
    """Of the scheduler of a Client, or of a cluster; None of anything else, and where it is closed."""
    found = getattr(cluster, "scheduler_address", None)
    if not isinstance(found, str):
        found = getattr(getattr(cluster, "scheduler", None), "address", None)
    return found if isinstance(found, str) and found else None


@asynccontextmanager
async def _local(threads: int) -> AsyncIterator[tuple[str, LocalWorkers]]:
    """A scheduler in this process, and a worker process for each thread; these end when the scheduler does, however it ends.

    They are interpreters of their own and not forked or spawned from this one, so that a script needs no main guard.
    """
    from distributed import Scheduler

    quiet = {"dashboard": False, "dashboard_address": "127.0.0.1:0"}
    async with Scheduler(host="127.0.0.1", port=0, **quiet) as scheduler:
        what = json.dumps(
            {"cls": "distributed.Worker", "opts": {"nthreads": 1, "death_timeout": LONELY, **quiet}}
        )
        calm = os.environ | {"DASK_LOGGING__DISTRIBUTED": "error"}
        apart = {
            "env": calm,
            "stdin": asyncio.subprocess.DEVNULL,
            "start_new_session": True,
        }  # Ctrl-C is for the run
        command = ["-m", "distributed.cli.dask_spec", scheduler.address, "--spec", what]
        workers = [
            await asyncio.create_subprocess_exec(sys.executable, *command, **apart) for _ in range(threads)
        ]
        try:
            yield scheduler.address, LocalWorkers(workers)
        finally:
            await scheduler.close()
            await asyncio.gather(*map(_ended, workers))


@contextmanager
def place_given_up() -> Iterator[None]:
    """Where this thread does a task of a Dask worker, that worker may do others meanwhile: the run's own among them."""
    from distributed import rejoin, secede
    from distributed.worker import thread_state

    try:
        is_task = hasattr(thread_state, "key")
        if is_task:
            secede()
    except KeyError:  # it was given up before
        is_task = False
    try:
        yield
    finally:
        if is_task:
            rejoin()


@contextmanager
def unheard(thread: str) -> Iterator[None]:
    """What Dask logs in this thread is no news of a run, which tells itself what happens to it."""
    import distributed  # noqa: F401  # which makes the handlers; those of the user's own are left alone

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


async def _ended(worker: asyncio.subprocess.Process) -> None:
    """Wait until a worker has gone; one that does not is killed."""
    with suppress(TimeoutError):
        async with asyncio.timeout(DYING):
            await worker.wait()
    if worker.returncode is None:
        worker.kill()
        await worker.wait()
