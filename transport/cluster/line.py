"""A run's line to a cluster: groups of batches go out, their sums come back, whatever happens to workers and scheduler.

It lives in a thread of its own, which alone knows Dask; the run puts in groups and takes out what was counted.  What is
out when a worker or the scheduler dies goes out again.  The scene is in no task: each worker is told it once, and a worker
that does not know it, because it came late, says so.
"""

from __future__ import annotations

import asyncio
import math
import pickle
import queue
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from uuid import uuid4

from transport.cluster import posts
from transport.cluster.groups import Group, Groups
from transport.cluster.places import LocalWorkers, reached, unheard
from transport.runs.crew import GLANCE, CrewLost
from transport.runs.origins import this_origin
from transport.validation import SceneError

DEPTH = 3  # groups that are out for each thread: one is being done, one waits beside it, one is on its way
WATCH = 1.0  # [s] between looks at who is there
CONNECT = 10.0  # [s] in which a scheduler must answer
PATIENCE = 300.0  # [s] without scheduler or workers, after which a run ends with what it has
LOCAL_PATIENCE = 30.0  # [s] the same for local workers, which nothing restarts
READY = object()  # what comes first: someone can begin


class Line:
    """Open it, then hand in the groups of one leg after the other; close it whatever happens."""

    def __init__(self, cluster: object, threads: int, task: tuple) -> None:
        """cluster: as `simulate` takes it;  threads: of a local one;  task: scene, tracking and method."""
        from cloudpickle import dumps  # which comes with Dask, and takes functions of a script along

        self.cluster, self.processes, self.task = cluster, threads, dumps(task)
        self.name, self.sources = f"transport-{uuid4().hex}", this_origin().sources
        # by which workers know it; another with each connection, as news of the last may be late
        self.run = self.name
        self.came: queue.SimpleQueue = queue.SimpleQueue()  # parcels, or what went wrong
        self.groups: Groups | None = None
        self.out: dict[asyncio.Task, tuple] = {}  # the future, its group, and who may do it
        self.local: LocalWorkers | None = None
        self.there: dict[str, int] = {}  # threads of each worker
        self.told: set[str] = set()  # workers that know of the run, and are to be used
        self.telling: asyncio.Task | None = None  # those that came late
        self.refused: dict[str, str] = {}  # workers that are not to be used, and why
        self.origins: dict = {}  # of those that are, in the order in which they came
        self.trouble: str | None = None  # what keeps a run that has begun waiting
        self.sent, self.is_begun, self.is_over = 0, False, False

    # ---- called by the run ----

    def open(self, tell: Callable[[str], None]) -> None:
        """Return once a worker is ready; until then tell what is waited for.  Raises SceneError where none can be had."""
        self.doing = "looking for the cluster"
        self.thread = threading.Thread(target=self._live, name=self.name, daemon=True)
        self.thread.start()
        while self.receive(GLANCE) is not READY:
            tell(self.doing)

    def begin(self, groups: Groups, seed: int, count: int) -> None:
        """Have these batches done.  count: of the run, among which the sample of a Snapshot is divided."""
        self._soon(self._begin, groups, (seed, count))

    def end(self) -> None:
        """What is not done yet is wanted no more."""
        self._soon(self._begin, None, ())

    def turn(self, number: int) -> None:
        """The batch of this number is the next that the run waits for."""
        self._soon(self._turn, number)

    def receive(self, seconds: float) -> tuple | object | None:
        """What has come, or None after so long: batches by their numbers, histories and seconds of each.  Raises what a batch
        raised, and CrewLost."""
        try:
            came = self.came.get(timeout=seconds)
        except queue.Empty:
            return None
        if isinstance(came, BaseException):
            raise came
        return came

    def close(self) -> None:
        """Tell the workers that the run is over, and return when all that was begun here has ended."""
        self.is_over = True  # Dask may swallow a cancellation
        self._soon(lambda: self.serving.cancel())
        self.thread.join()

    @property
    def workers(self) -> int:
        """That are to be used."""
        return len(self.told)

    @property
    def threads(self) -> int:
        """Of all workers that are to be used."""
        return max(1, sum(many for address, many in self.there.items() if address in self.told))

    @property
    def doubts(self) -> list[str]:
        """What a reader should know of those who did the batches."""
        return [f"worker {address} was not used: {why}" for address, why in self.refused.items()]

    def _soon(self, act: Callable, *arguments: object) -> None:
        with suppress(RuntimeError, AttributeError):  # its thread has ended, or not begun
            self.loop.call_soon_threadsafe(act, *arguments)

    # ---- in the line's own thread ----

    def _live(self) -> None:
        try:
            with unheard(self.name):
                asyncio.run(self._serve())
        except BaseException as error:
            self.came.put(error)

    async def _serve(self) -> None:
        """Keep a client connected to the scheduler, and begin anew with another where that fails."""
        from distributed import Client

        self.serving, self.changed, self.heard = asyncio.current_task(), asyncio.Event(), time.monotonic()
        self.loop = asyncio.get_running_loop()
        self.loop.set_exception_handler(_tell_news)
        async with reached(self.cluster, self.processes) as (options, self.local):
            while not self.is_over:
                try:
                    async with Client(
                        **options, asynchronous=True, set_as_default=False, timeout=CONNECT
                    ) as client:
                        await self._converse(client)
                except OSError as error:
                    self._bear(f"no scheduler answers at {options['address']}", error)
                    await asyncio.sleep(WATCH)

    async def _converse(self, client) -> None:
        """Hand out groups until the line is closed.  Raises OSError where the scheduler is gone."""
        self.run, self.told = f"{self.name}-{uuid4().hex}", set()
        try:
            looked = -math.inf
            while not self.is_over:
                if time.monotonic() - looked >= WATCH:
                    await self._look_round(client)
                    looked = time.monotonic()
                self._hand_out(client)
                with suppress(TimeoutError):
                    async with asyncio.timeout(
                        WATCH
                    ):  # wait_for may swallow the cancellation by which the line is closed
                        await self.changed.wait()
                self.changed.clear()
                if client.status != "running":
                    raise ConnectionError("the connection was lost")
        finally:
            self._take_back()
            if self.telling is not None:
                self.telling.cancel()
            if client.status == "running":
                with suppress(OSError):
                    async with asyncio.timeout(CONNECT):
                        await client.run(posts.dismiss, self.run, on_error="ignore")

    async def _look_round(self, client) -> None:
        """Who is there?  Whoever is new is told of the run."""
        self.there = await client.nthreads()
        self.told &= self.there.keys()
        for task, (future, _, allowed) in list(self.out.items()):
            if allowed is not None and not allowed & self.there.keys():
                await client.cancel([future])  # none of those who may do it is there any more
                task.cancel()
        if not self.there.keys() - self.refused.keys():
            self._wait_for_workers(client.scheduler.address)
            return
        self.heard, self.trouble = time.monotonic(), None
        if not self.is_begun:
            await self._muster(client)
            return
        newcomers = self.there.keys() - self.refused.keys() - self.told
        if newcomers and (self.telling is None or self.telling.done()):
            self.telling = asyncio.create_task(self._tell(client, list(newcomers)))

    async def _muster(self, client) -> None:
        """Tell everybody of the run, and wait until one has compiled or loaded its passes.  Raises SceneError naming those
        that cannot work for it."""
        self.doing = "workers compile or load passes"
        await self._tell(client, None)
        if self.refused:
            told = "; ".join(f"worker {address}: {why}" for address, why in self.refused.items())
            raise SceneError(
                f"simulate: cluster: {told}; start its workers from the same sources as this process"
            )
        if not self.told:  # they have just died, or do not answer: look round again
            return
        if await self._one_is_ready(client):
            self.is_begun = True
            self.came.put(READY)

    async def _one_is_ready(self, client) -> bool:
        """Wait until one of the workers that were told has compiled or loaded the passes; False where they end before."""
        from distributed import KilledWorker

        self.sent += 1
        told = {"workers": list(self.told), "key": (self.name, self.sent), "pure": False}
        future = client.submit(posts.make_ready, self.run, **told)
        answer = asyncio.ensure_future(client.gather(future))
        try:
            while not (await asyncio.wait([answer], timeout=WATCH))[0]:
                if not self.told & (await client.nthreads()).keys():
                    answer.cancel()
                    await client.cancel([future])
                    return False
            return await answer is None
        except KilledWorker:
            if self.local is None:
                raise
            return False  # the others are tried, until none is left
        finally:
            answer.cancel()

    async def _tell(self, client, workers: list[str] | None) -> None:
        """Tell workers of the run, all of them or these; whoever has other sources is not to be used."""
        for address, answer in (await self._answers(client, workers)).items():
            if isinstance(answer, OSError):
                continue  # it has just died
            if isinstance(answer, Exception):  # whose kind is lost on the way
                self.refused[address] = f"it cannot import transport: {answer}"
            elif answer.sources != self.sources:
                self.refused[address] = (
                    f"it has transport {answer.version} of sources {answer.sources}, not {self.sources}"
                )
            else:
                self.told.add(address)
                self.origins[answer] = None

    async def _answers(self, client, workers: list[str] | None) -> dict[str, object]:
        """What each says who is told of the run.  One that is silent keeps nobody waiting for long: it is asked again later."""
        tell = partial(client.run, posts.enlist, self.run, self.task, self.sources, on_error="return")
        answers: dict[str, object] = {}

        async def ask(some: list[str] | None) -> None:
            async with asyncio.timeout(CONNECT):
                answers.update(await tell(workers=some))

        try:
            await ask(workers)
        except TimeoutError:
            each = self.there.keys() if workers is None else workers
            await asyncio.gather(*(ask([address]) for address in each), return_exceptions=True)
        return answers

    def _begin(self, groups: Groups | None, arguments: tuple) -> None:
        self._take_back()
        self.groups, self.arguments = groups, arguments
        self._wake()

    def _turn(self, number: int) -> None:
        if self.groups is not None:
            self.groups.turn = number
            self._wake()

    def _take_back(self) -> None:
        """Nobody is to do what is out; it waits again."""
        for task in list(self.out):
            task.cancel()

    def _wake(self) -> None:
        self.changed.set()

    def _hand_out(self, client) -> None:
        """Give everybody something to do."""
        allowed = None if self.there.keys() <= self.told else frozenset(self.there.keys() & self.told)
        while self.groups and len(self.out) < DEPTH * self.threads and allowed != frozenset():
            group = self.groups.take(self.threads)
            self.sent += 1
            future = client.submit(
                posts.work_on,
                self.run,
                group,
                *self.arguments,
                key=(self.name, self.sent),  # of its own: what was lost is never asked for again by its key
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
        """Wait for what a group counted; where its worker or the scheduler died, the group waits again."""
        from distributed import KilledWorker

        try:
            parcel = await client.gather(future)
            if isinstance(parcel, posts.Untold):
                await self._tell(client, [parcel.worker])
                groups.put_back(group)
                return
        except asyncio.CancelledError:
            groups.put_back(group)
            raise
        except KilledWorker as error:
            if groups.accuse(group):
                number, size = group[0]
                why = f"batch {number}, of {size} particles, killed its workers, {error.allowed_failures + 1} of them"
                last = f"the last was {error.last_worker.address}, whose log may tell why"
                cure = "most likely it needs more memory than they have: take fewer bins, or other workers"
                self.came.put(CrewLost(f"{why}; {last}; {cure}"))
        except Exception as error:
            if future.status == "error":
                self.came.put(error)
            groups.put_back(group)
        else:
            batches, times = pickle.loads(parcel)
            groups.clear(group)
            groups.pace.add(times, len(parcel))
            self.came.put((batches, times))

    def _wait_for_workers(self, address: str) -> None:
        """No worker is there: wait, unless none can come because the local ones have ended."""
        if self.local is not None and (end := self.local.end):
            raise CrewLost(end) if self.is_begun else SceneError(f"simulate: cluster: {end}")
        self._bear(f"no workers at {address}")

    def _bear(self, what: str, error: Exception | None = None) -> None:
        """Wait for what is not there; but not for ever, once the run has begun, nor for a scheduler that was never there."""
        self.doing = what
        self.trouble = what if self.is_begun else None
        if error is not None and not self.is_begun:
            cure = "start one with `dask scheduler`, and workers with `dask worker ADDRESS`"
            raise SceneError(f"simulate: cluster: {what} ({error}); {cure}")
        patience = PATIENCE if self.local is None else LOCAL_PATIENCE
        if self.is_begun and time.monotonic() - self.heard > patience:
            raise CrewLost(f"{what} for {patience:g} s")


def _tell_news(loop: asyncio.AbstractEventLoop, context: dict[str, object]) -> None:
    """What went wrong where nobody waits for it; but not what Dask leaves behind of groups that were taken back."""
    from distributed.client import AllExit

    if not isinstance(context.get("exception"), AllExit):
        loop.default_exception_handler(context)
