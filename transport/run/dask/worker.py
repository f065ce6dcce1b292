"""Worker side of a run: a process keeps the run's scene, compiles its program once, and computes batches.

Dask is not needed here: a post is the process's share of a run, found by the run's name.
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

POSTS: dict[str, Post] = {}  # by name, the runs that this process works for
OVER: deque[str] = deque(maxlen=1000)  # names of finished runs
# [s] without a batch after which a run is forgotten, as its client may have been killed; a live client sends
# it again
IDLE = 600.0
NEWS = threading.Condition()  # notified of changes of either
PATIENCE = 10.0  # [s] that a batch waits for its run's scene, which late workers soon receive


@dataclass(frozen=True)
class Untold:
    """Answer of a worker that does not know the run, or knows that it is over."""

    worker: str  # its address


def enlist(name: str, task: bytes, sources: str, dask_worker=None):
    """Make this process work for a run, unless its sources differ. Return its Origin.

    dask_worker: the worker itself, which Dask passes in.
    """
    from transport.run.provenance import this_origin

    origin = this_origin()
    with NEWS:
        if origin.sources != sources:
            OVER.append(name)  # over for this process before it began
        elif name not in POSTS and name not in OVER:  # unless a late message of a finished run
            _forget_idle()
            POSTS[name] = Post(task, 1 if dask_worker is None else dask_worker.state.nthreads)
        NEWS.notify_all()
    return origin


def dismiss(name: str) -> None:
    """End a run: stop its batches in progress, and forget it."""
    with NEWS:
        OVER.append(name)
        post = POSTS.pop(name, None)
        NEWS.notify_all()
    if post is not None:
        post.stop()


def _forget_idle() -> None:
    """Forget runs that have been idle for long."""
    for name, post in list(POSTS.items()):
        if post.is_idle:
            POSTS.pop(name).stop()


def _frameless(work: Callable) -> Callable:
    """Decorate a function to drop the tracebacks of its exceptions.

    A Dask client hangs on a traceback of a thousand frames.
    """

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
    """Compute these batches (number, particles). Return the result of `Post.work`, pickled."""
    from transport.engine.driver import Stopped

    post = _post_of(name)
    with suppress(Stopped):
        if post is not None:
            # One byte string, because thousands of small arrays would each travel by themselves.
            return pickle.dumps(post.work(batches, seed, count), protocol=5)
    return _untold()


def _post_of(name: str) -> Post | None:
    """Return this process's post of a run; wait where the run has not arrived yet.

    The batch thus keeps its place. If the task were given back, the scheduler would forget how many workers
    have died over it.
    """
    with NEWS:
        NEWS.wait_for(lambda: name in POSTS or name in OVER, PATIENCE)
        return POSTS.get(name)


def _untold() -> Untold:
    from distributed import get_worker

    return Untold(get_worker().address)


class Post:
    """A run in a worker's process: its threads share the compiled program, and each has a bundle.

    The program is compiled at once, in a thread that does not keep the worker from answering.
    """

    def __init__(self, task: bytes, threads: int) -> None:
        """task: scene, tracking and method, pickled."""
        self.task, self.threads, self.made, self.is_over = task, threads, None, False
        self.making, self.lock = threading.Lock(), threading.Lock()
        self.free: list = []  # unused bundles
        self.busy: list = []
        self.used = time.monotonic()
        threading.Thread(target=self._prepare, daemon=True).start()

    def machine(self):
        """Return the compiled program; the first caller makes it, and the others wait.

        Raise SceneError where memory does not suffice.
        """
        from transport.run.memory import check_worker_memory
        from transport.run.programs import machine_for
        from transport.run.progress import Progress

        with self.making:
            if self.made is None:
                made = machine_for(*pickle.loads(self.task), Progress())
                check_worker_memory(made.program.plan, self.threads)
                self.made = made
            return self.made

    def work(
        self, batches: list[tuple[int, int]], seed: int, count: int
    ) -> tuple[dict, list[tuple[int, float]]]:
        """Return the batches of these numbers and sizes by number, with particles and seconds of each.

        count: batches of the run, among which the sample of a Snapshot is divided. Raise Stopped where the
        run is over.
        """
        from transport.engine.driver import run_batch
        from transport.results.batches import batch_of

        machine, done, times = self.machine(), {}, []
        bundle = self._take_bundle()
        try:
            for number, size in batches:
                begun = time.perf_counter()
                # Keep no reference to the raw sums: they would double the memory of the next batch.
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
        """Return whether the run has had no batch for IDLE seconds."""
        with self.lock:
            return not self.busy and time.monotonic() - self.used > IDLE

    def _prepare(self) -> None:
        """Compile the program in advance."""
        with suppress(Exception):  # raised again to the callers of `machine`
            self.machine()

    def stop(self) -> None:
        """Stop the batches in progress, and accept no others."""
        with self.lock:
            self.is_over = True
            for bundle in self.busy:
                bundle["stop"] = 1

    def _take_bundle(self):
        """Return an unused bundle, and mark it as busy. Raise Stopped where the run is over."""
        from transport.engine.bundle import empty_bundle
        from transport.engine.driver import Stopped

        with self.lock:
            if self.is_over:
                raise Stopped
            bundle = self.free.pop() if self.free else empty_bundle()
            bundle["stop"] = 0
            self.busy.append(bundle)
        return bundle
