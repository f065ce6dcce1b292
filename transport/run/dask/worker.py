"""Worker side of a run: a plugin holds the run's scene, compiles its program once, and computes batches.

Dask gives the plugin to every worker, also to those that join late.
"""

from __future__ import annotations

import pickle
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import wraps

from distributed import Reschedule, WorkerPlugin, get_worker

from transport.results.batches import batch_of
from transport.run.provenance import Origin, this_origin

IDLE_SECONDS = 600.0  # [s] without a batch after which a run's program is forgotten: its client may be gone

Group = list[tuple[int, int]]  # numbers and particles of batches


@dataclass(frozen=True)
class Refusal:
    """Answer of a worker that does not compute batches of the run: its address, and the reason."""

    worker: str
    why: str


def unlike_sources(origin: Origin, sources: str) -> str | None:
    """Return why a worker of this origin must not compute batches of these sources; None where it may."""
    if origin.sources == sources:
        return None
    return f"it has transport {origin.version} of sources {origin.sources}, not {sources}"


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
def compile_run(name: str) -> None:
    """Compile or load the passes of the run."""
    get_worker().plugins[name].compiled_program()


@_without_traceback
def run_group(name: str, group: Group, count: int) -> bytes | Refusal:
    """Return the origin of this worker and the result of `RunPlugin.work`, pickled."""
    from transport.engine.driver import Stopped

    worker = get_worker()
    plugin = worker.plugins.get(name)
    if plugin is None or plugin.unlike:
        return Refusal(worker.address, plugin.unlike if plugin else "it does not know the run")
    try:
        done = plugin.work(group, count, worker.get_current_task())
    except Stopped:
        raise Reschedule from None  # has no effect where the task was cancelled
    # One byte string, because thousands of small arrays would each travel by themselves.
    return pickle.dumps((this_origin(), *done), protocol=5)


class RunPlugin(WorkerPlugin):
    """A run on a worker: its threads share the compiled program, and each has a bundle.

    The program is compiled at once, in a thread that does not keep the worker from answering.
    """

    def __init__(self, name: str, settings: bytes, sources: str) -> None:
        """settings: pickled Settings of the run; sources: digest of the client's sources."""
        self.name, self.settings, self.sources = name, settings, sources

    def setup(self, worker) -> None:
        """Prepare the run on a worker, and forget idle runs."""
        self.unlike = unlike_sources(this_origin(), self.sources)
        self.threads, self.compiled, self.is_over = worker.state.nthreads, None, False
        self.compiling, self.lock = threading.Lock(), threading.Lock()
        self.free: list = []  # unused bundles
        self.busy: dict = {}  # bundles by task
        self.used = time.monotonic()
        for plugin in worker.plugins.values():
            if isinstance(plugin, RunPlugin) and plugin is not self:
                plugin.forget_if_idle()
        if not self.unlike:
            threading.Thread(target=self._prepare, daemon=True).start()

    def teardown(self, worker) -> None:
        """Stop the batches in progress, and accept no others."""
        with self.lock:
            self.is_over = True
            for bundle in self.busy.values():
                bundle["stop"] = 1

    def transition(self, key, start: str, finish: str, **_: object) -> None:
        """Stop a task in progress that was cancelled: Dask itself lets it finish."""
        if finish == "released" and (bundle := self.busy.get(key)) is not None:
            bundle["stop"] = 1

    def forget_if_idle(self) -> None:
        """Forget the program and the bundles of a run without a batch for IDLE_SECONDS."""
        with self.lock:
            if not self.busy and time.monotonic() - self.used > IDLE_SECONDS:
                self.compiled, self.free = None, []

    def compiled_program(self):
        """Return the compiled program; the first caller makes it, and the others wait.

        Raise SceneError where memory does not suffice.
        """
        from transport.run.memory import check_worker_memory
        from transport.run.programs import compiled_program_for
        from transport.run.progress import Progress

        with self.compiling:
            if self.compiled is None:
                settings = pickle.loads(self.settings)
                compiled, self.seed = compiled_program_for(settings, Progress()), settings.seed
                check_worker_memory(compiled.program.plan, self.threads)
                self.compiled = compiled
            return self.compiled

    def work(self, group: Group, count: int, task) -> tuple[dict, list[tuple[int, float]]]:
        """Return the batches of a group by number, and particles and seconds of each.

        count: batches of the run, among which the sample of a Snapshot is divided; task: key of the task.
        Raise Stopped where the run is over or the task was cancelled.
        """
        from transport.engine.driver import run_batch

        compiled, done, times = self.compiled_program(), {}, []
        bundle = self._take_bundle(task)
        try:
            for number, size in group:
                begun = time.perf_counter()
                # Keep no reference to the raw sums: they would double the memory of the next batch.
                done[number] = batch_of(
                    compiled.program.plan, run_batch(compiled, self.seed, number, size, bundle, count), number
                )
                times.append((size, time.perf_counter() - begun))
        finally:
            with self.lock:
                self.free.append(self.busy.pop(task))
                self.used = time.monotonic()
        return done, times

    def _prepare(self) -> None:
        """Compile the program in advance."""
        with suppress(Exception):  # raised again to the callers of `compiled_program`
            self.compiled_program()

    def _take_bundle(self, task):
        """Return an unused bundle, and mark it as busy. Raise Stopped where the run is over."""
        from transport.engine.bundle import empty_bundle
        from transport.engine.driver import Stopped

        with self.lock:
            if self.is_over:
                raise Stopped
            bundle = self.free.pop() if self.free else empty_bundle()
            bundle["stop"] = 0
            self.busy[task] = bundle
        return bundle
