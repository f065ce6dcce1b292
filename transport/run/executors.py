"""Choose the executor of a run: threads of this process, or the workers of a cluster."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

from transport.compile.plan import Plan
from transport.run.interruption import Interruption
from transport.run.programs import compiled_program_for, plan_for
from transport.run.progress import Progress, WaitingWarning
from transport.run.settings import RunSettings, checked_threads
from transport.run.threads import OrderedResults, ThreadExecutor
from transport.scene.scene import Scene
from transport.validation import SceneError

if TYPE_CHECKING:
    from transport.run.dask.client import DaskExecutor

SILENT_SECONDS = 30.0  # [s] of waiting for a cluster before a warning


@dataclass(frozen=True)
class ExecutorSpec:
    """The requested executor: a number of threads, or a cluster; for cluster="local" as many processes."""

    threads: int
    cluster: object = None


@dataclass(frozen=True)
class Executor:
    """A plan and a ready executor of its batches.

    make_executor: make the executor of a run of so many batches, which share the sample of a Snapshot.
    threads: total number of threads; workers: of a cluster, else 0.
    warnings: return findings about the executor after the run, as sentences.
    """

    plan: Plan
    make_executor: Callable[[int], OrderedResults]
    threads: int
    workers: int = 0
    warnings: Callable[[], list[str]] = field(default=list)


def checked_executor(threads: object, cluster: object) -> ExecutorSpec:
    """Return the requested executor; threads: None for one per core. Raise SceneError for invalid input."""
    if cluster is not None:
        from transport.run.dask.connect import LOCAL, checked_cluster

        checked_cluster(cluster)
        if threads is not None and not (isinstance(cluster, str) and cluster == LOCAL):
            cure = "leave it out: the workers of a cluster have their own"
            raise SceneError(f"simulate: threads must not be given with a cluster, got {threads!r}; {cure}")
    return ExecutorSpec(checked_threads(threads), cluster)


@contextmanager
def open_executor(
    scene: Scene, settings: RunSettings, spec: ExecutorSpec, bar: Progress, interruption: Interruption
) -> Iterator[Executor]:
    """Yield an executor that is ready to start. Raise SceneError where the cluster cannot run the scene."""
    if spec.cluster is None:
        compiled = compiled_program_for(scene, settings.tracking, settings.method, bar)
        yield Executor(
            compiled.program.plan,
            partial(ThreadExecutor, compiled, settings.seed, spec.threads),
            spec.threads,
        )
        return
    from transport.run.dask.client import DaskExecutor
    from transport.run.dask.connect import slot_released
    from transport.run.dask.executor import ClusterExecutor

    plan = plan_for(scene, settings.tracking, settings.method)
    dask_executor = DaskExecutor(spec.cluster, spec.threads, (scene, settings.tracking, settings.method))
    with slot_released():
        try:
            _wait_for_workers(dask_executor, bar, interruption)
            make_executor = partial(ClusterExecutor, dask_executor, settings.seed, settings.limits.seconds)
            yield Executor(
                plan,
                make_executor,
                dask_executor.threads,
                dask_executor.workers,
                lambda: dask_executor.warnings,
            )
        finally:
            dask_executor.close()


def _wait_for_workers(dask_executor: DaskExecutor, bar: Progress, interruption: Interruption) -> None:
    """Wait until a worker is ready; warn once after SILENT_SECONDS.

    A job without a terminal would otherwise wait forever in silence.
    """
    due = time.perf_counter() + SILENT_SECONDS

    def wait(what: str) -> None:
        nonlocal due
        bar.waiting(what)
        interruption.check()
        if time.perf_counter() > due:
            warnings.warn(f"{what}; the run starts when a worker is ready", WaitingWarning, stacklevel=2)
            due = math.inf

    try:
        dask_executor.open(wait)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"interrupted before the run began: {dask_executor.doing}") from None
