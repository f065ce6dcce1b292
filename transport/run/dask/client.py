"""Connection of a run to a Dask cluster: sends groups of batches and collects their sums.

It runs in a thread of its own, which alone uses Dask; the run hands over groups and receives sums. Groups
lost with a worker or the scheduler are sent again. The scene is in no task: each worker receives it once, and
a worker that lacks it, because it joined late, reports so.
"""

from __future__ import annotations

import asyncio
import heapq
import math
import pickle
import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import partial
from uuid import uuid4

from transport.run.dask import worker
from transport.run.dask.connect import LocalWorkers, open_cluster, silenced
from transport.run.provenance import this_origin
from transport.run.threads import POLL_SECONDS as GLANCE
from transport.run.threads import WorkersLost
from transport.validation import SceneError

# ---- Sizes of task groups: about half a second of batches per group, and less at the end of a leg.
#
# A group costs the scheduler and the client about a millisecond each, so that many threads get larger groups.
# Towards the end of a leg each group takes a share of what is left, so that all threads end together: guided
# self-scheduling (Polychronopoulos and Kuck 1987, IEEE Trans. Comput. C-36, 1425).

GROUP_SECONDS = 0.5  # [s] per group: long against the latency of a task, short against a person's patience
MAX_GROUPS_PER_SECOND = 500  # groups per second that a scheduler and a client can handle
GROUPS_PER_THREAD = 2  # groups per thread into which the rest of a leg is divided
MAX_GROWTH = 4  # largest factor of batches over those timed before, as the first say little about the others
MAX_GROUP_BYTES = 1 << 25  # bytes of the sums of a group, which travel together

Group = list[tuple[int, int]]  # numbers and particles of batches


class BatchPace:
    """Cost of batches, by the last finished group: seconds per particle, bytes of sums per batch."""

    def __init__(self) -> None:
        self.seconds, self.bytes, self.batches = 0.0, 0.0, 0

    def add(self, times: list[tuple[int, float]], size: int) -> None:
        """Add a finished group: particles and seconds of its batches, and the bytes of their sums."""
        self.seconds = sum(seconds for _, seconds in times) / max(1, sum(histories for histories, _ in times))
        self.bytes = size / len(times)
        self.batches = max(self.batches, len(times))  # largest number of batches in a finished group

    @property
    def most(self) -> int:
        """Return the largest number of batches in the next group."""
        return max(1, min(MAX_GROWTH * self.batches, int(MAX_GROUP_BYTES / max(1.0, self.bytes))))


class Groups:
    """The batches of a leg that no worker computes at present."""

    def __init__(
        self,
        batches: Iterable[tuple[int, int]],
        pace: BatchPace,
        seconds: float = GROUP_SECONDS,
        ahead: float = math.inf,
        turn: int = 0,
    ) -> None:
        """Take batches as (number, particles).

        seconds: target time per group, where threads are few; ahead: bytes of sums that may be finished or in
        progress before their turn; turn: number of the batch that the run waits for.
        """
        self.waiting = deque(batches)
        # heap of groups to send again, lowest numbers first, as the run waits for these
        self.lost: list[Group] = []
        self.suspects: list[Group] = []  # heap of groups of one batch each that may kill their workers
        # the suspect in progress; one at a time, so that the cause of a death is known
        self.suspect: Group | None = None
        self.left = sum(size for _, size in self.waiting)  # particles
        self.pace, self.seconds, self.ahead, self.turn = pace, seconds, ahead, turn

    def __bool__(self) -> bool:
        """Return whether a group is available now."""
        return bool(self.lost) or self._may_try_suspect() or (bool(self.waiting) and self._is_near_turn())

    def take(self, threads: int) -> Group:
        """Return the next group for one of so many threads."""
        # Try suspects first, then lost groups, as the run waits for these.
        if self._may_try_suspect():
            self.suspect = heapq.heappop(self.suspects)
            return self.suspect
        if self.lost:
            return heapq.heappop(self.lost)
        # Fill a new group up to its time.
        group, seconds = [self.waiting.popleft()], self._group_seconds(threads)
        expected = group[0][1] * self.pace.seconds
        while self.waiting and len(group) < self.pace.most:
            expected += self.waiting[0][1] * self.pace.seconds
            if expected > seconds:
                break
            group.append(self.waiting.popleft())
        self.left -= sum(size for _, size in group)
        return group

    def put_back(self, group: Group) -> None:
        """Put back a group whose worker died or could not be reached."""
        heapq.heappush(self.suspects if group is self.suspect else self.lost, group)
        self.clear(group)

    def clear(self, group: Group) -> None:
        """Note that a group is finished, or waits again."""
        if group is self.suspect:
            self.suspect = None

    def suspect_group(self, group: Group) -> bool:
        """Suspect a group over which several workers died: try each of its batches alone, one at a time.

        Return whether the group is already known to be the cause.
        """
        if group is self.suspect:
            return True
        for batch in group:
            heapq.heappush(self.suspects, [batch])
        return False

    def _may_try_suspect(self) -> bool:
        return bool(self.suspects) and self.suspect is None

    def _is_near_turn(self) -> bool:
        """Return whether the next batch is near its turn.

        Otherwise one slow worker could fill this process's memory.
        """
        number, _ = self.waiting[0]
        return (number - self.turn) * self.pace.bytes < self.ahead

    def _group_seconds(self, threads: int) -> float:
        """Return the time that a group may take [s]."""
        usual = max(self.seconds, threads / MAX_GROUPS_PER_SECOND)
        return min(usual, self.left * self.pace.seconds / (GROUPS_PER_THREAD * threads))


# ---- The connection.

GROUPS_IN_FLIGHT = 3  # groups in flight per thread: one is computed, one waits beside it, one travels
POLL_SECONDS = 1.0  # [s] between polls of the workers
CONNECT_SECONDS = 10.0  # [s] within which a scheduler must answer
WAIT_SECONDS = 300.0  # [s] without scheduler or workers, after which a run ends with what it has
LOCAL_WAIT_SECONDS = 30.0  # [s] the same for local workers, which nothing restarts
READY = object()  # first message: a worker can start


class DaskExecutor:
    """Connection to a cluster: open it, pass the groups of one leg after the other, and always close it."""

    def __init__(self, cluster: object, threads: int, task: tuple) -> None:
        """cluster: as in `simulate`; threads: of a local cluster; task: scene, tracking and method."""
        from cloudpickle import dumps  # comes with Dask, and pickles functions defined in a script

        self.cluster, self.processes, self.task = cluster, threads, dumps(task)
        self.name, self.sources = f"transport-{uuid4().hex}", this_origin().sources
        # Name of the run at the workers. Each connection gets a new one, as messages about the last may
        # arrive late.
        self.run = self.name
        self.results: queue.SimpleQueue = queue.SimpleQueue()  # results, or exceptions
        self.groups: Groups | None = None
        # by task: its future, its group, and the workers allowed to compute it
        self.out: dict[asyncio.Task, tuple] = {}
        self.local: LocalWorkers | None = None
        self.worker_threads: dict[str, int] = {}  # number of threads by worker
        self.usable: set[str] = set()  # usable workers that have received the run
        self.sending: asyncio.Task | None = None  # the task that sends the run to late workers
        self.refused: dict[str, str] = {}  # excluded workers, with the reason
        self.origins: dict = {}  # of the usable workers, in order of arrival (a dict as an ordered set)
        self.problem: str | None = None  # why a run that has begun is waiting; None while it is not
        self.sent, self.is_begun, self.is_over = 0, False, False

    # ---- called in the run's thread ----

    def open(self, tell: Callable[[str], None]) -> None:
        """Return once a worker is ready; call `tell` with what is missing until then.

        Raise SceneError where no worker can be had.
        """
        self.doing = "looking for the cluster"
        self.thread = threading.Thread(target=self._run_thread, name=self.name, daemon=True)
        self.thread.start()
        while self.receive(GLANCE) is not READY:
            tell(self.doing)

    def begin(self, groups: Groups, seed: int, count: int) -> None:
        """Compute these batches.

        count: batches of the run, among which the sample of a Snapshot is divided.
        """
        self._call_soon(self._begin, groups, (seed, count))

    def end(self) -> None:
        """Cancel unfinished batches."""
        self._call_soon(self._begin, None, ())

    def turn(self, number: int) -> None:
        """Set the number of the batch that the run waits for."""
        self._call_soon(self._set_next, number)

    def receive(self, seconds: float) -> tuple | object | None:
        """Return (batches by number, particles and seconds per batch), or None after so many seconds.

        Raise the exception of a batch, or WorkersLost.
        """
        try:
            came = self.results.get(timeout=seconds)
        except queue.Empty:
            return None
        if isinstance(came, BaseException):
            raise came
        return came

    def close(self) -> None:
        """End the run at the workers, and return when all tasks of this connection have ended."""
        self.is_over = True  # needed as well, because Dask may swallow a cancellation
        self._call_soon(lambda: self.serving.cancel())
        self.thread.join()

    @property
    def workers(self) -> int:
        """Return the number of usable workers."""
        return len(self.usable)

    @property
    def threads(self) -> int:
        """Return the number of threads of all usable workers."""
        return max(1, sum(many for address, many in self.worker_threads.items() if address in self.usable))

    @property
    def warnings(self) -> list[str]:
        """Return findings about the workers, as sentences."""
        return [f"worker {address} was not used: {why}" for address, why in self.refused.items()]

    def _call_soon(self, act: Callable, *arguments: object) -> None:
        """Call a function in the connection's thread."""
        with suppress(RuntimeError, AttributeError):  # the thread has ended, or not begun
            self.loop.call_soon_threadsafe(act, *arguments)

    # ---- called in the connection's own thread ----

    def _run_thread(self) -> None:
        """Run the connection, and pass on what ends it."""
        try:
            with silenced(self.name):
                asyncio.run(self._serve())
        except BaseException as error:
            self.results.put(error)

    async def _serve(self) -> None:
        """Keep a client connected to the scheduler, and connect anew where that fails."""
        from distributed import Client

        self.serving, self.changed, self.last_contact = (
            asyncio.current_task(),
            asyncio.Event(),
            time.monotonic(),
        )
        self.loop = asyncio.get_running_loop()
        self.loop.set_exception_handler(_handle_exception)
        async with open_cluster(self.cluster, self.processes) as (options, self.local):
            while not self.is_over:
                try:
                    async with Client(
                        **options, asynchronous=True, set_as_default=False, timeout=CONNECT_SECONDS
                    ) as client:
                        await self._communicate(client)
                except OSError as error:
                    self._wait_or_raise(f"no scheduler answers at {options['address']}", error)
                    await asyncio.sleep(POLL_SECONDS)

    async def _communicate(self, client) -> None:
        """Send groups until the connection is closed. Raise OSError where the scheduler is lost."""
        self.run, self.usable = f"{self.name}-{uuid4().hex}", set()
        try:
            looked = -math.inf
            while not self.is_over:
                # Poll the workers, send groups, then wait for a change or the next poll.
                if time.monotonic() - looked >= POLL_SECONDS:
                    await self._poll_workers(client)
                    looked = time.monotonic()
                self._send_groups(client)
                with suppress(TimeoutError):
                    # asyncio.wait_for may swallow the cancellation that closes the connection.
                    async with asyncio.timeout(POLL_SECONDS):
                        await self.changed.wait()
                self.changed.clear()
                if client.status != "running":
                    raise ConnectionError("the connection was lost")
        finally:
            self._cancel_groups()
            if self.sending is not None:
                self.sending.cancel()
            if client.status == "running":
                with suppress(OSError):
                    async with asyncio.timeout(CONNECT_SECONDS):
                        await client.run(worker.end_run, self.run, on_error="ignore")

    async def _poll_workers(self, client) -> None:
        """Poll the workers, and send the run to new ones."""
        self.worker_threads = await client.nthreads()
        self.usable &= self.worker_threads.keys()
        # Cancel groups whose allowed workers have all gone; they are sent again.
        for task, (future, _, allowed) in list(self.out.items()):
            if allowed is not None and not allowed & self.worker_threads.keys():
                await client.cancel([future])  # no allowed worker is left
                task.cancel()
        if not self.worker_threads.keys() - self.refused.keys():
            self._wait_for_workers(client.scheduler.address)
            return
        self.last_contact, self.problem = time.monotonic(), None
        if not self.is_begun:
            await self._start_workers(client)
            return
        newcomers = self.worker_threads.keys() - self.refused.keys() - self.usable
        if newcomers and (self.sending is None or self.sending.done()):
            self.sending = asyncio.create_task(self._tell(client, list(newcomers)))

    async def _start_workers(self, client) -> None:
        """Send the run to all workers, and wait until one has compiled or loaded its passes.

        Raise SceneError with the workers that cannot run it.
        """
        self.doing = "workers compile or load passes"
        await self._tell(client, None)
        if self.refused:
            message = "; ".join(f"worker {address}: {why}" for address, why in self.refused.items())
            raise SceneError(
                f"simulate: cluster: {message}; start its workers from the same sources as this process"
            )
        if not self.usable:  # they have died or do not answer: poll again
            return
        if await self._is_any_ready(client):
            self.is_begun = True
            self.results.put(READY)

    async def _is_any_ready(self, client) -> bool:
        """Return whether a worker has compiled or loaded the passes; False where all end before."""
        from distributed import KilledWorker

        self.sent += 1
        options = {"workers": list(self.usable), "key": (self.name, self.sent), "pure": False}
        future = client.submit(worker.compile_run, self.run, **options)
        answer = asyncio.ensure_future(client.gather(future))
        try:
            while not (await asyncio.wait([answer], timeout=POLL_SECONDS))[0]:
                if not self.usable & (await client.nthreads()).keys():
                    answer.cancel()
                    await client.cancel([future])
                    return False
            return await answer is None
        except KilledWorker:
            if self.local is None:
                raise
            return False  # try the other workers until none is left
        finally:
            answer.cancel()

    async def _tell(self, client, workers: list[str] | None) -> None:
        """Send the run to these workers, or to all (None); exclude those with other sources."""
        for address, answer in (await self._ask_workers(client, workers)).items():
            if isinstance(answer, OSError):
                continue  # the worker has died
            if isinstance(answer, Exception):  # its type is lost in transit
                self.refused[address] = f"it cannot import transport: {answer}"
            elif answer.sources != self.sources:
                self.refused[address] = (
                    f"it has transport {answer.version} of sources {answer.sources}, not {self.sources}"
                )
            else:
                self.usable.add(address)
                self.origins[answer] = None

    async def _ask_workers(self, client, workers: list[str] | None) -> dict[str, object]:
        """Return each worker's answer to the run.

        A silent worker delays nobody for long, and is asked again later.
        """
        tell = partial(client.run, worker.register_run, self.run, self.task, self.sources, on_error="return")
        answers: dict[str, object] = {}

        async def ask(some: list[str] | None) -> None:
            async with asyncio.timeout(CONNECT_SECONDS):
                answers.update(await tell(workers=some))

        try:
            await ask(workers)
        except TimeoutError:
            each = self.worker_threads.keys() if workers is None else workers
            await asyncio.gather(*(ask([address]) for address in each), return_exceptions=True)
        return answers

    def _begin(self, groups: Groups | None, arguments: tuple) -> None:
        """Replace the groups to send by those of the next leg."""
        self._cancel_groups()
        self.groups, self.arguments = groups, arguments
        self._wake()

    def _set_next(self, number: int) -> None:
        if self.groups is not None:
            self.groups.turn = number
            self._wake()

    def _cancel_groups(self) -> None:
        """Cancel all groups in flight; they wait again."""
        for task in list(self.out):
            task.cancel()

    def _wake(self) -> None:
        self.changed.set()

    def _send_groups(self, client) -> None:
        """Send groups until each thread has GROUPS_IN_FLIGHT of them."""
        # Restrict groups to usable workers, where there are others.
        allowed = (
            None
            if self.worker_threads.keys() <= self.usable
            else frozenset(self.worker_threads.keys() & self.usable)
        )
        while self.groups and len(self.out) < GROUPS_IN_FLIGHT * self.threads and allowed != frozenset():
            group = self.groups.take(self.threads)
            self.sent += 1
            future = client.submit(
                worker.run_group,
                self.run,
                group,
                *self.arguments,
                # a new key each time, so that a lost key is never requested again
                key=(self.name, self.sent),
                pure=False,
                workers=None if allowed is None else list(allowed),
            )
            task = asyncio.create_task(self._collect(client, future, group, self.groups))
            self.out[task] = future, group, allowed
            task.add_done_callback(self._forget)

    def _forget(self, task: asyncio.Task) -> None:
        self.out.pop(task, None)
        self._wake()

    async def _collect(self, client, future, group: Group, groups: Groups) -> None:
        """Wait for the sums of a group; put it back where its worker or the scheduler died."""
        from distributed import KilledWorker

        try:
            parcel = await client.gather(future)
            if isinstance(parcel, worker.UnknownRun):
                await self._tell(client, [parcel.worker])
                groups.put_back(group)
                return
        except asyncio.CancelledError:
            groups.put_back(group)
            raise
        except KilledWorker as error:
            if groups.suspect_group(group):
                number, size = group[0]
                why = f"batch {number} ({size} particles) killed {error.allowed_failures + 1} workers"
                last = f"the last was {error.last_worker.address}, whose log may show why"
                cure = "it probably needs more memory: use fewer bins, or workers with more memory"
                self.results.put(WorkersLost(f"{why}; {last}; {cure}"))
        except Exception as error:
            if future.status == "error":
                self.results.put(error)
            groups.put_back(group)
        else:
            batches, times = pickle.loads(parcel)
            groups.clear(group)
            groups.pace.add(times, len(parcel))
            self.results.put((batches, times))

    def _wait_for_workers(self, address: str) -> None:
        """Wait for workers; raise where none can come because the local ones have ended."""
        if self.local is not None and (end := self.local.end):
            raise WorkersLost(end) if self.is_begun else SceneError(f"simulate: cluster: {end}")
        self._wait_or_raise(f"no workers at {address}")

    def _wait_or_raise(self, what: str, error: Exception | None = None) -> None:
        """Record why the run waits; raise where waiting is useless.

        Waiting is useless after WAIT_SECONDS (LOCAL_WAIT_SECONDS) once the run has begun, and for a scheduler
        that was never reached.
        """
        self.doing = what
        self.problem = what if self.is_begun else None
        if error is not None and not self.is_begun:
            cure = "start one with `dask scheduler`, and workers with `dask worker ADDRESS`"
            raise SceneError(f"simulate: cluster: {what} ({error}); {cure}")
        patience = WAIT_SECONDS if self.local is None else LOCAL_WAIT_SECONDS
        if self.is_begun and time.monotonic() - self.last_contact > patience:
            raise WorkersLost(f"{what} for {patience:g} s")


def _handle_exception(loop: asyncio.AbstractEventLoop, context: dict[str, object]) -> None:
    """Handle an exception that no task awaits; ignore those that Dask leaves of cancelled groups."""
    from distributed.client import AllExit

    if not isinstance(context.get("exception"), AllExit):
        loop.default_exception_handler(context)
