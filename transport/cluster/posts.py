"""What a worker does: it keeps a run's scene, makes a machine of it once, and does the batches that it is told to.

Nothing of Dask is needed here: a post is a process that was given a scene under a name.
"""

from __future__ import annotations

import pickle
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import wraps

POSTS: dict[str, Post] = {}  # of the runs that this process works for
OVER: deque[str] = deque(maxlen=1000)  # the last runs that it works for no more
IDLE = 600.0  # [s] without a batch, after which a run is forgotten: its client may have been killed; else it tells of it anew
NEWS = threading.Condition()  # told of either
PATIENCE = 10.0  # [s] that a batch waits for its run's scene: those that come late are told soon


@dataclass(frozen=True)
class Untold:
    """What a worker says that was not told of the run, or that it is over."""

    worker: str  # its address


def enlist(name: str, task: bytes, sources: str, dask_worker=None):
    """Let this process work for a run, unless its sources are others than these.  Returns its Origin.

    dask_worker: the worker that it is, which Dask fills in.
    """
    from transport.runs.origins import this_origin

    origin = this_origin()
    with NEWS:
        if origin.sources != sources:
            OVER.append(name)  # for this one before it began
        elif name not in POSTS and name not in OVER:  # of which this may be late news
            _forget_idle()
            POSTS[name] = Post(task, 1 if dask_worker is None else dask_worker.state.nthreads)
        NEWS.notify_all()
    return origin


def dismiss(name: str) -> None:
    """The run is over: what is still being done for it stops, and is forgotten."""
    with NEWS:
        OVER.append(name)
        post = POSTS.pop(name, None)
        NEWS.notify_all()
    if post is not None:
        post.stop()


def _forget_idle() -> None:
    for name, post in list(POSTS.items()):
        if post.is_idle:
            POSTS.pop(name).stop()


def _frameless(work: Callable) -> Callable:
    """An error leaves its frames here: a client of Dask never returns from a thousand of them."""

    @wraps(work)
    def working(*arguments):
        try:
            return work(*arguments)
        except Exception as error:
            raise error.with_traceback(None) from None

    return working


@_frameless
def make_ready(name: str) -> Untold | None:
    """Compile or load the passes of the run."""
    post = _post_of(name)
    if post is None:
        return _untold()
    post.machine()
    return None


@_frameless
def work_on(name: str, batches: list[tuple[int, int]], seed: int, count: int) -> bytes | Untold:
    """Do these batches, numbers and sizes.  Returns what `Post.work` does, pickled."""
    from transport.engine.driver import Stopped

    post = _post_of(name)
    with suppress(Stopped):
        if post is not None:
            # One string of bytes: thousands of small arrays would each travel by themselves.
            return pickle.dumps(post.work(batches, seed, count), protocol=5)
    return _untold()


def _post_of(name: str) -> Post | None:
    """This process's post of a run; one that is not told of it yet waits, so that the batch keeps its place.

    Were it given back, the scheduler would forget how many workers have died over it.
    """
    with NEWS:
        NEWS.wait_for(lambda: name in POSTS or name in OVER, PATIENCE)
        return POSTS.get(name)


def _untold() -> Untold:
    from distributed import get_worker

    return Untold(get_worker().address)


class Post:
    """A run in a worker's process: its threads share the machine, and each of them has a bundle.

    The machine is made at once, in a thread that does not keep the worker from answering.
    """

    def __init__(self, task: bytes, threads: int) -> None:
        """task: scene, tracking and method, pickled."""
        self.task, self.threads, self.made, self.is_over = task, threads, None, False
        self.making, self.lock = threading.Lock(), threading.Lock()
        self.free: list = []  # bundles
        self.busy: list = []
        self.used = time.monotonic()
        threading.Thread(target=self._prepare, daemon=True).start()

    def machine(self):
        """Made by the first thread that asks for it; the others wait.  Raises SceneError where there is no memory for it."""
        from transport.runs.machines import machine_for
        from transport.runs.memory import check_worker_memory
        from transport.runs.progress import Progress

        with self.making:
            if self.made is None:
                made = machine_for(*pickle.loads(self.task), Progress())
                check_worker_memory(made.program.plan, self.threads)
                self.made = made
            return self.made

    def work(
        self, batches: list[tuple[int, int]], seed: int, count: int
    ) -> tuple[dict, list[tuple[int, float]]]:
        """The batches of these numbers and sizes, and how long each took: histories and seconds.

        count: batches, among which the sample of a Snapshot is divided.  Raises Stopped where the run is over.
        """
        from transport.engine.driver import run_batch
        from transport.results.batches import batch_of

        machine, done, times = self.machine(), {}, []
        bundle = self._take_bundle()
        try:
            for number, size in batches:
                begun = time.perf_counter()
                # Its sums are not held on to: they would be there beside those of the next batch.
                done[number] = batch_of(
                    machine.program.plan, run_batch(machine, seed, number, size, bundle, count), number
                )
                times.append((size, time.perf_counter() - begun))
        finally:
            with self.lock:
                self.busy = [other for other in self.busy if other is not bundle]
                self.free.append(bundle)
                self.used = time.monotonic()
        return done, times

    @property
    def is_idle(self) -> bool:
        """Whether nobody has wanted anything of it for long."""
        with self.lock:
            return not self.busy and time.monotonic() - self.used > IDLE

    def _prepare(self) -> None:
        with suppress(Exception):  # which those who ask for the machine will see
            self.machine()

    def stop(self) -> None:
        """End the batches that are being done, and do no others."""
        with self.lock:
            self.is_over = True
            for bundle in self.busy:
                bundle["stop"] = 1

    def _take_bundle(self):
        from transport.engine.bundle import empty_bundle
        from transport.engine.driver import Stopped

        with self.lock:
            if self.is_over:
                raise Stopped
            bundle = self.free.pop() if self.free else empty_bundle()
            bundle["stop"] = 0
            self.busy.append(bundle)
        return bundle
