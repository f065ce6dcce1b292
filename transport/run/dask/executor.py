"""Executor whose batches are computed by the workers of a Dask cluster.

Dask sends tasks to workers, and those of a dead worker to others. What is added here: how many batches form a
task, the order of their sums, and which batch is the cause where workers die.
"""

from __future__ import annotations

import math
import pickle
import subprocess
import time
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from uuid import uuid4

from cloudpickle import dumps  # comes with Dask, and pickles functions defined in a script
from distributed import Client, Future, KilledWorker, as_completed
from distributed.utils import silence_logging_cmgr

from transport.run.dask.cluster import CONNECT_SECONDS, end_of, open_client, slot_released
from transport.run.dask.worker import Group, Refusal, RunPlugin, compile_run, run_group, unlike_sources
from transport.run.executor import POLL_SECONDS, Executor, Numbered, WorkersLost
from transport.run.programs import plan_for
from transport.run.progress import Progress, WaitingWarning
from transport.run.provenance import Origin, this_origin
from transport.run.settings import Settings
from transport.statistics.chunked import available_memory
from transport.validation import SceneError

# ---- Sizes of tasks: groups of about half a second of batches, and less at the end of a leg.
#
# A group costs the scheduler and the client about a millisecond each, so that many threads get larger groups.
# Towards the end of a leg each group takes a share of what is left, so that all threads end together: guided
# self-scheduling (Polychronopoulos and Kuck 1987, IEEE Trans. Comput. C-36, 1425).

GROUP_SECONDS = 0.5  # [s] per group: long against the latency of a task, short against a person's patience
MAX_GROUPS_PER_SECOND = 500  # groups per second that a scheduler and a client can handle
GROUPS_PER_THREAD = 2  # groups per thread into which the rest of a leg is divided
MIN_GROUPS = 50  # groups per thread in a run limited by seconds: an unfinished group is lost when time is up
MAX_GROWTH = 4  # largest factor of batches over those timed before, as the first say little about the others
MAX_GROUP_BYTES = 1 << 25  # bytes of the sums of a group, which travel together


class Groups:
    """The batches of a leg that are not sent yet, grouped by what the last finished group cost."""

    def __init__(self, seconds: float = GROUP_SECONDS) -> None:
        """seconds: target time per group, where threads are few."""
        self.seconds, self.left = seconds, 0  # left: particles
        self.waiting: deque[tuple[int, int]] = deque()
        self.particle_seconds, self.batch_bytes, self.most = 0.0, 0.0, 1  # most: batches in the next group

    def put_back(self, group: Iterable[tuple[int, int]]) -> None:
        """Add batches before those that wait."""
        group = list(group)
        self.waiting.extendleft(reversed(group))
        self.left += sum(size for _, size in group)

    def add(self, times: list[tuple[int, float]], size: int) -> None:
        """Add a finished group: particles and seconds of its batches, and the bytes of their sums."""
        particles = sum(histories for histories, _ in times)
        self.particle_seconds = sum(seconds for _, seconds in times) / max(1, particles)
        self.batch_bytes = size / len(times)
        by_bytes = int(MAX_GROUP_BYTES / max(1.0, self.batch_bytes))
        self.most = max(1, min(max(self.most, MAX_GROWTH * len(times)), by_bytes))

    def take(self, threads: int) -> Group:
        """Return the next group for one of so many threads."""
        longest = max(self.seconds, threads / MAX_GROUPS_PER_SECOND)
        seconds = min(longest, self.left * self.particle_seconds / (GROUPS_PER_THREAD * threads))
        group = [self.waiting.popleft()]
        expected = group[0][1] * self.particle_seconds
        while self.waiting and len(group) < self.most:
            expected += self.waiting[0][1] * self.particle_seconds
            if expected > seconds:
                break
            group.append(self.waiting.popleft())
        self.left -= sum(size for _, size in group)
        return group

    def clear(self) -> None:
        """Forget the batches that wait."""
        self.waiting.clear()
        self.left = 0


# ---- The executor.

GROUPS_IN_FLIGHT = 3  # groups in flight per thread: one is computed, one waits beside it, one travels
MAX_AHEAD_BYTES = 1 << 28  # bytes of sums that may wait for their turn; or a quarter of the available memory
WATCH_SECONDS = 1.0  # [s] between counts of the workers
SILENT_SECONDS = 30.0  # [s] of waiting for a cluster before a warning
WAIT_SECONDS = 300.0  # [s] without workers, after which a run ends with what it has
LOCAL_WAIT_SECONDS = 30.0  # [s] the same for local workers, which nothing restarts


class DaskExecutor(Executor):
    """Compute batches on the workers of a cluster; those that die are Dask's business, unless all do."""

    def __init__(self, settings: Settings, client: Client, local: Sequence[subprocess.Popen] = ()) -> None:
        """local: the worker processes of cluster="local"."""
        super().__init__(plan_for(settings.scene, settings.tracking, settings.method), 1)
        self.client, self.local, self.name = client, local, f"transport-{uuid4().hex}"
        self.address = client.scheduler.address
        self.plugin = RunPlugin(self.name, dumps(settings), this_origin().sources)
        limit = settings.limits.seconds
        self.groups = Groups(GROUP_SECONDS if limit is None else min(GROUP_SECONDS, limit / MIN_GROUPS))
        self.max_ahead_bytes = max(MAX_AHEAD_BYTES, (available_memory() or 0) // 4)
        self.arrivals = as_completed(loop=client.loop, with_results=True, raise_errors=False)
        self.in_flight: dict[Future, Group] = {}  # groups by future
        # Batches of groups over which workers died: each is tried alone, to find the cause.
        self.suspects: list[tuple[int, int]] = []
        self.suspect: Group | None = None  # the one in flight
        self.sent, self.seen, self.watched = 0, time.monotonic(), -math.inf
        self.worker_threads: dict[str, int] = {}  # number of threads of each usable worker
        self.refused: dict[str, str] = {}  # excluded workers, with the reason
        self.known_origins: dict[Origin, None] = {}  # of the batches (a dict as an ordered set)
        self.problem: str | None = None  # why the run is waiting

    @property
    def origins(self) -> tuple[Origin, ...]:
        """Return the provenance of the batches."""
        return tuple(self.known_origins)

    @property
    def warnings(self) -> list[str]:
        """Return which workers were not used, as sentences."""
        return [f"worker {address} was not used: {why}" for address, why in self.refused.items()]

    def prepare(self, bar: Progress) -> None:
        """Give the run to the workers, and return when one has compiled its passes.

        Raise SceneError with the workers that cannot run it.
        """
        wait = _Waiting(bar)
        wait.until(self._is_any_there, f"no workers at {self.address}")
        self._check_sources()
        wait.until(self._register, "workers receive the scene")
        while not self._is_any_ready(wait):
            pass
        self._count_workers()
        self.threads, self.workers = max(1, self._usable_threads), len(self.worker_threads)

    def _is_any_ready(self, wait: _Waiting) -> bool:
        """Wait until a worker has compiled or loaded the passes; return False where those that tried died."""
        ready = self.client.submit(compile_run, self.name, key=self._new_key(), pure=False)
        wait.until(lambda: self._check_local() or ready.done(), "workers compile or load passes")
        try:
            ready.result()
        except KilledWorker:
            if not self.local:
                raise
            return False  # try the other workers until none is left
        return True

    def close(self) -> None:
        """End the run at the workers."""
        with suppress(Exception):  # the scheduler may have gone, or a worker not answer
            if self.client.status == "running":
                remove = self.client.scheduler.unregister_worker_plugin
                self.client.sync(remove, name=self.name, callback_timeout=CONNECT_SECONDS)

    # ---- a leg ----

    def _start(self, batches: Numbered, count: int) -> None:
        self.count, self.seen = count, time.monotonic()
        self.groups.put_back(batches)
        self._send()

    def _receive(self, seconds: float) -> bool:
        with self.arrivals.thread_condition:
            self.arrivals.thread_condition.wait_for(self.arrivals.has_ready, seconds)
        arrived = self.arrivals.next_batch(block=False)
        # Store sums before an error ends the run.
        for future, result in sorted(arrived, key=lambda pair: not isinstance(pair[1], bytes)):
            self._take_in(future, result)
        self._watch_workers()
        self._send()
        return bool(arrived)

    def _cancel(self) -> None:
        self.groups.clear()
        for future, result in self.arrivals.next_batch(block=False):
            with suppress(Exception):  # of a batch that is no longer needed
                self._take_in(future, result)
        with suppress(Exception):  # the scheduler may have gone
            self.client.cancel(list(self.in_flight))
        self.arrivals.clear()
        self.in_flight, self.suspects, self.suspect = {}, [], None

    def _send(self) -> None:
        """Send groups until each thread has GROUPS_IN_FLIGHT of them."""
        while group := self._next_group():
            # Restrict groups to usable workers only where there are others.
            where = list(self.worker_threads) if self.refused else None
            how = {"key": self._new_key(), "pure": False, "workers": where}
            how["allow_other_workers"] = where is not None
            future = self.client.submit(run_group, self.name, group, self.count, **how)
            self.in_flight[future] = group
            self.arrivals.add(future)

    def _next_group(self) -> Group | None:
        """Return the next group to send; None while enough are in flight."""
        if self.suspect or (self.suspects and self.in_flight):
            return None
        if self.suspects:
            self.suspect = [self.suspects.pop(0)]
            return self.suspect
        waiting, threads = self.groups.waiting, self._usable_threads
        if not waiting or len(self.in_flight) >= GROUPS_IN_FLIGHT * threads:
            return None
        # Wait where one slow worker could fill this process's memory.
        if (waiting[0][0] - self.next) * self.groups.batch_bytes >= self.max_ahead_bytes:
            return None
        return self.groups.take(threads)

    def _take_in(self, future: Future, result) -> None:
        """Store the sums of a group, or find out why it has none."""
        group = self.in_flight.pop(future, None)
        if group is None:  # it arrived twice
            return
        suspect, self.suspect = self.suspect, None  # it was alone in flight
        # The result tells, not the future's status: that may be lost again with its worker meanwhile.
        if isinstance(result, bytes):
            origin, batches, times = pickle.loads(result)
            self.known_origins[origin] = None
            self.groups.add(times, len(result))
            self._store(batches)
            self.done += times
        elif isinstance(result, Refusal):
            self.refused[result.worker] = result.why
            self.worker_threads.pop(result.worker, None)
            self.groups.put_back(group)
        elif not isinstance(result, tuple):  # it was cancelled, but not by this run
            raise WorkersLost(f"the scheduler at {self.address} was lost")
        else:
            _, error, _ = result  # as of sys.exc_info
            if not isinstance(error, KilledWorker):
                raise error
            if group is suspect:
                raise WorkersLost(_cause(*group[0], error))
            # Dask blames all tasks of a dead worker: try each of their batches alone.
            self.suspects = sorted(self.suspects + group)

    # ---- the workers ----

    def _new_key(self) -> tuple[str, int]:
        """Return a new key of a task, so that a lost one is never requested again."""
        self.sent += 1
        return self.name, self.sent

    @property
    def _usable_threads(self) -> int:
        return sum(self.worker_threads.values())

    def _is_any_there(self) -> bool:
        """Return whether a worker has come; of local ones, whether all have that have not ended."""
        self._check_local()
        running = sum(process.poll() is None for process in self.local)
        return self._count_workers() >= max(1, running)

    def _register(self) -> bool:
        """Give the run to all workers, also to those that come late; return whether that succeeded."""
        try:
            self.client.register_plugin(self.plugin, name=self.name)
        except OSError:  # a worker has died: try again
            return False
        return True

    def _count_workers(self) -> int:
        """Count the usable workers and their threads."""
        lost = WorkersLost(f"the scheduler at {self.address} was lost")
        if self.client.status != "running":
            raise lost
        try:
            found = self.client.nthreads()
        except OSError:
            raise lost from None
        self.worker_threads = {where: many for where, many in found.items() if where not in self.refused}
        return len(self.worker_threads)

    def _check_local(self) -> None:
        """Raise SceneError where all local workers have ended before the run began."""
        if end := end_of(self.local):
            raise SceneError(f"simulate: cluster: {end}")

    def _check_sources(self) -> None:
        """Refuse workers of other sources, and those without transport."""
        refused = []
        for address, answer in self.client.run(this_origin, on_error="return").items():
            if isinstance(answer, OSError):
                continue  # the worker has died
            if isinstance(answer, Exception):
                refused.append(f"worker {address}: it cannot import transport: {answer}")
            elif why := unlike_sources(answer, self.plugin.sources):
                refused.append(f"worker {address}: {why}")
        if refused:
            cure = "start its workers from the same sources as this process"
            raise SceneError(f"simulate: cluster: {'; '.join(refused)}; {cure}")

    def _watch_workers(self) -> None:
        """Count the workers now and then; warn where there are none, and raise WorkersLost in the end."""
        now = time.monotonic()
        if now - self.watched < WATCH_SECONDS:
            return
        self.watched = now
        if self._count_workers():
            self.seen = now
        # Sums that were lost with their worker before they arrived may end as errors.
        for future in self.in_flight:
            if future.status == "error":
                self.arrivals.add(future)
        problem = None if self.worker_threads else f"no workers at {self.address}"
        if problem and (end := end_of(self.local)):
            raise WorkersLost(end)
        patience = LOCAL_WAIT_SECONDS if self.local else WAIT_SECONDS
        if now - self.seen > patience:
            raise WorkersLost(f"{problem} for {patience:g} s")
        if problem != self.problem:
            self.problem = problem
            what = f"{problem}; the run waits" if problem else "the cluster is back; the run continues"
            warnings.warn(f"{time.strftime('%Y-%m-%d %H:%M:%S')}: {what}", WaitingWarning, stacklevel=2)


def _cause(number: int, size: int, error) -> str:
    """Return the message about a batch that kills its workers."""
    why = f"batch {number} ({size} particles) killed {error.allowed_failures + 1} workers"
    last = f"the last was {error.last_worker.address}, whose log may show why"
    cure = "it probably needs more memory: use fewer bins, or workers with more memory"
    return f"{why}; {last}; {cure}"


class _Waiting:
    """Wait for a cluster before a run begins, and warn once after SILENT_SECONDS.

    A job without a terminal would otherwise wait forever in silence.
    """

    def __init__(self, bar: Progress) -> None:
        self.bar, self.due = bar, time.perf_counter() + SILENT_SECONDS

    def until(self, is_met: Callable[[], object], what: str) -> None:
        """Wait until a condition is met, and report what is waited for."""
        try:
            while not is_met():
                self.bar.waiting(what)
                if time.perf_counter() > self.due:
                    message = f"{what}; the run starts when a worker is ready"
                    warnings.warn(message, WaitingWarning, stacklevel=2)
                    self.due = math.inf
                time.sleep(POLL_SECONDS)
        except KeyboardInterrupt:
            raise KeyboardInterrupt(f"interrupted before the run began: {what}") from None


@contextmanager
def open_dask(settings: Settings, cluster: object, threads: int, bar: Progress) -> Iterator[DaskExecutor]:
    """Yield an executor that is ready to start. Raise SceneError where the cluster cannot run the scene.

    threads: number of local workers.
    """
    with (
        slot_released(),
        silence_logging_cmgr("CRITICAL"),  # the run reports itself what happens
        open_client(cluster, threads) as (client, local),
    ):
        executor = DaskExecutor(settings, client, local)
        try:
            executor.prepare(bar)
            yield executor
        finally:
            executor.close()
