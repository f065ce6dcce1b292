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

RUNS: dict[str, WorkerRun] = {}  # by name, the runs that this process works for
FINISHED: deque[str] = deque(maxlen=1000)  # names of finished runs
# [s] without a batch after which a run is forgotten, as its client may have been killed; a live client sends
# it again
IDLE_SECONDS = 600.0
CHANGED = threading.Condition()  # notified of changes of either
SCENE_SECONDS = 10.0  # [s] that a batch waits for its run's scene, which late workers soon receive


@dataclass(frozen=True)
class UnknownRun:
    """Answer of a worker that does not know the run, or knows that it is over."""

    worker: str  # its address


def register_run(name: str, task: bytes, sources: str, dask_worker=None):
    """Make this process work for a run, unless its sources differ. Return its Origin.

    dask_worker: the worker itself, which Dask passes in.
    """
    from transport.run.provenance import this_origin

    origin = this_origin()
    with CHANGED:
        if origin.sources != sources:
            FINISHED.append(name)  # over for this process before it began
        elif name not in RUNS and name not in FINISHED:  # unless a late message of a finished run
            _forget_idle()
            RUNS[name] = WorkerRun(task, 1 if dask_worker is None else dask_worker.state.nthreads)
        CHANGED.notify_all()
    return origin


def end_run(name: str) -> None:
    """End a run: stop its batches in progress, and forget it."""
    with CHANGED:
        FINISHED.append(name)
        post = RUNS.pop(name, None)
        CHANGED.notify_all()
    if post is not None:
        post.stop()


def _forget_idle() -> None:
    """Forget runs that have been idle for long."""
    for name, post in list(RUNS.items()):
        if post.is_idle:
            RUNS.pop(name).stop()


def _without_traceback(work: Callable) -> Callable:
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


@_without_traceback
def compile_run(name: str) -> UnknownRun | None:
    """Compile or load the passes of the run."""
    post = _run_of(name)
    if post is None:
        return _unknown_run()
    post.compiled_program()
    return None


@_without_traceback
def run_group(name: str, batches: list[tuple[int, int]], seed: int, count: int) -> bytes | UnknownRun:
    """Compute these batches (number, particles). Return the result of `WorkerRun.work`, pickled."""
    from transport.engine.driver import Stopped

    post = _run_of(name)
    with suppress(Stopped):
        if post is not None:
            # One byte string, because thousands of small arrays would each travel by themselves.
            return pickle.dumps(post.work(batches, seed, count), protocol=5)
    return _unknown_run()


def _run_of(name: str) -> WorkerRun | None:
    """Return this process's post of a run; wait where the run has not arrived yet.

    The batch thus keeps its place. If the task were given back, the scheduler would forget how many workers
    have died over it.
    """
    with CHANGED:
        CHANGED.wait_for(lambda: name in RUNS or name in FINISHED, SCENE_SECONDS)
        return RUNS.get(name)


def _unknown_run() -> UnknownRun:
    from distributed import get_worker

    return UnknownRun(get_worker().address)


class WorkerRun:
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

    def compiled_program(self):
        """Return the compiled program; the first caller makes it, and the others wait.

        Raise SceneError where memory does not suffice.
        """
        from transport.run.memory import check_worker_memory
        from transport.run.programs import compiled_program_for
        from transport.run.progress import Progress

        with self.making:
            if self.made is None:
                made = compiled_program_for(*pickle.loads(self.task), Progress())
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

        compiled, done, times = self.compiled_program(), {}, []
        bundle = self._take_bundle()
        try:
            for number, size in batches:
                begun = time.perf_counter()
                # Keep no reference to the raw sums: they would double the memory of the next batch.
                done[number] = batch_of(
                    compiled.program.plan, run_batch(compiled, seed, number, size, bundle, count), number
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
        """Whether the run has had no batch for IDLE_SECONDS."""
        with self.lock:
            return not self.busy and time.monotonic() - self.used > IDLE_SECONDS

    def _prepare(self) -> None:
        """Compile the program in advance."""
        with suppress(Exception):  # raised again to the callers of `compiled_program`
            self.compiled_program()

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
