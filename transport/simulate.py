"""The entry point `simulate`: run batches of a scene until a limit is reached, and return a Result."""

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, replace
from functools import lru_cache
from os import PathLike
from typing import TYPE_CHECKING

from transport.compile.methods import AUTO, LEAST_GUIDED, MIN_GUIDE, Method, coerce_method, guided
from transport.results.result import Result
from transport.run.auto import GUIDE_SECONDS, LONG_PILOT_SECONDS, PILOT_SEED_MASK, choose_method
from transport.run.executor import Executor, ThreadExecutor
from transport.run.interruption import delay_interrupts
from transport.run.programs import compiled_program_for
from transport.run.progress import PilotProgress, Progress, open_progress
from transport.run.run import Run
from transport.run.settings import RunRequest, Settings, checked_part, checked_threads
from transport.scene.scene import Scene
from transport.scene.tracking import Tracking
from transport.validation import SceneError, checked_keywords

if TYPE_CHECKING:
    from transport.io.resuming import Checkpoints

TIMED_HISTORIES = 1 << 8, 1 << 12  # of the runs that tell how long learning a guide will take


@checked_keywords
def simulate(
    scene: Scene,
    particles: float | None = None,
    error: Mapping[str, float] | None = None,
    seconds: float | None = None,
    seed: int | None = None,
    batches: int | None = None,
    threads: int | None = None,
    estimator: str | None = None,
    sampling: str | None = None,
    tracking: Tracking | str | None = None,
    progress: bool | str | None = None,
    resume: Result | str | PathLike | None = None,
    checkpoint: str | PathLike | None = None,
    every: float = 60.0,
    part: tuple[int, int] | None = None,
    cluster: object = None,
    guide: int | None = None,
) -> Result:
    """Run a scene and return the results of its detectors, each with its standard error.

    The run ends at the first limit reached, after a whole batch: `particles`, `error` or `seconds`, of which
    at least one is required for a new run. The same seed gives bitwise the same result on any number of
    threads. Ctrl-C returns the completed batches as an incomplete result.

    Parameters
    ----------
    scene : Scene
        Scene to run.
    particles : float, optional
        Number of particles to emit, a whole number such as 1e6. With sampling "sobol" or "stratified" it is
        rounded up so that all batches have equal sizes that are powers of two, at most to twice the number;
        `result.particles` is the number emitted.
    error : mapping of str to float, optional
        Relative standard errors to reach by quantity, such as {"meter.flux_in": 1e-3}. Errors are checked
        only at a few times planned in advance, so that the reported intervals keep their coverage. The run
        also continues while a mean rests on few or very unequal scores.
    seconds : float, optional
        Wall-clock time [s], without compilation and pilot runs.
    seed : int, optional
        Seed, 0 to 2^64 - 1. Default 0; with `resume` that of the saved run.
    batches : int, optional
        Number of batches, independent replicates whose spread gives the errors. Default 32; 128 to 256 with
        `error` (fewer if the sums are large); fewer with "sobol" and "stratified". With these, `error` and
        `seconds` are run in rounds of doubled size, and the last complete round is the result.
    threads : int, optional
        Number of threads. Default all cores.
    estimator : str, optional
        "analog" (score crossings), "aimed" (sources emit only towards the detector), "expected" (next-event
        estimation), "backward" (histories start at the detectors) or "auto" (choose the cheapest trustworthy
        method by pilot runs of about half a second in total). Default "auto" with `error` or `seconds`,
        "analog" with `particles` alone, "backward" for scenes with a Camera or an EnvironmentMap. See Notes.
    sampling : str, optional
        "random", "stratified" or "sobol". Default "random"; with "auto" any, and a name restricts the choice
        to it.
    tracking : Tracking or str, optional
        Treatment of absorption in media: "analog", "weighted", or a Tracking with more options. Default
        depends on the scene; the report names it and the options without effect.
    progress : bool or str, optional
        Progress bar on the terminal; "lines" prints a line at increasing intervals, for log files. Default: a
        bar if the output is a terminal.
    resume : Result, str or Path, optional
        Saved run to continue. Limits count from its beginning; settings that you omit are taken from it, and
        settings that you pass must match it.
    checkpoint : str or Path, optional
        File (.nc or .npz) to which the run is saved at intervals and at its end: a new file or that of
        `resume`. With the same file for both, the call starts the run, continues it, or returns at once if it
        is complete.
    every : float, default 60
        Interval between checkpoints [s].
    part : tuple of two ints, optional
        (k, n) runs only the k-th of n parts of the batches, for `tp.merge`. Not with "auto", because parts
        could choose different methods.
    cluster : object, optional
        Where batches run, with bitwise the same result: a dask.distributed Client or cluster, the address of
        a scheduler, or "local" for one process per thread.
    guide : int, optional
        Number of histories of short runs before the run, from which it learns where to send its own: births
        then follow the learnt density, each with its exact weight. It finds small lamps behind mirrors, glass
        and lenses. 0 for none. Default: with "backward", in scenes with specular or glossy surfaces whose
        light rays do not connect, for detectors without bins, as many as `particles` within 262144 and
        1048576, from 8192 particles on; else none. Runs for an `error` or a time have a smaller one where it
        would take long to learn; "auto" gives one to other estimators where they need it.

    Returns
    -------
    Result
        Quantities of all detectors, energy balance (`ledger`), warnings and report.

    Raises
    ------
    SceneError
        If the scene or a parameter cannot be run.
    KeyboardInterrupt
        If interrupted before the first batch; the message gives the time per batch.

    Notes
    -----
    "auto" measures times, so that two runs may choose different methods. The report names the choice;
    repeated with that name, the run is bitwise the same. With `seconds` alone any quantity may be read from
    the result. "aimed" and "backward" estimate only light that arrives at detectors, so they are then chosen
    only if no other method can be trusted; the report states what they would save.

    Examples
    --------
    The disk subtends (1 - cos 45°) / 2 = 0.1464 of all directions.

    >>> import transport as tp
    >>> shape = tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=1.0)
    >>> disk = tp.Surface(shape, tp.Black(), name="disk")
    >>> source = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    >>> scene = tp.Scene(sources=[source], surfaces=[disk], detectors=[tp.Detector("disk", "meter")])
    >>> result = tp.simulate(scene, particles=1e4, seed=1, progress=False)
    >>> result["meter"].flux_in
    <Estimate (0.151 ± 0.003) W, 32 batches>
    """
    request = RunRequest(
        scene, particles, error, seconds, batches, part, seed, estimator, sampling, tracking, guide
    )
    return _run(request, threads, cluster, progress, resume, checkpoint, every)


def simulate_all_quantities(scene: Scene, particles: float | None = None, **arguments) -> Result:
    """Run like `simulate`, but any quantity and the energy balance may be read, whatever `error` names."""
    names = [field.name for field in fields(RunRequest) if field.name in arguments]
    request = RunRequest(scene, particles, **{name: arguments.pop(name) for name in names}, reads_all=True)
    return _run(request, **arguments)


def _run(
    request: RunRequest,
    threads: int | None = None,
    cluster: object = None,
    progress: bool | str | None = None,
    resume: Result | str | PathLike | None = None,
    checkpoint: str | PathLike | None = None,
    every: float = 60.0,
) -> Result:
    """Resolve the settings of a run, and run it or continue the saved one."""
    threads = _checked_threads(threads, cluster)
    # Lock the file before it is read: another run might be writing it.
    with _checkpoints(checkpoint, every, request.scene) as keep:
        saved = None
        if resume is not None or checkpoint is not None:
            from transport.io.resuming import run_to_resume

            saved = run_to_resume(resume, checkpoint)
        begun = time.perf_counter()
        with open_progress(progress) as bar:
            if saved is None:
                settings = _new_settings(request, bar)
            else:
                from transport.io.resuming import resumed_settings

                settings = resumed_settings(saved, request)
            return _execute(settings, threads, cluster, bar, begun, saved, keep)


def _execute(
    settings: Settings,
    threads: int,
    cluster: object,
    bar: Progress,
    begun: float,
    saved: Result | None = None,
    keep: "Checkpoints | None" = None,
) -> Result:
    """Start a run with these settings, or continue the saved one, until a limit is reached."""
    with (
        delay_interrupts() as interruption,
        _open_executor(settings, threads, cluster, bar) as executor,
    ):
        preparation = time.perf_counter() - begun
        between = None if keep is None else keep.save_if_due
        run = Run(settings, executor, bar, interruption, preparation, saved, between)
        run.go()
        if not run.batches:
            raise KeyboardInterrupt(run.no_result_message())
        result = run.result(run.is_complete)
        if keep is not None:
            keep.end(result)
    return result


def _checked_threads(threads: object, cluster: object) -> int:
    """Return the number of threads; None means one per core. Raise SceneError, also for a wrong cluster."""
    if cluster is not None:
        from transport.run.dask.cluster import LOCAL, checked_cluster

        checked_cluster(cluster)
        if threads is not None and not (isinstance(cluster, str) and cluster == LOCAL):
            cure = "leave it out: the workers of a cluster have their own"
            raise SceneError(f"simulate: threads must not be given with a cluster, got {threads!r}; {cure}")
    return checked_threads(threads)


@contextmanager
def _open_executor(settings: Settings, threads: int, cluster: object, bar: Progress) -> Iterator[Executor]:
    """Yield an executor that is ready to start: threads of this process, or the workers of a cluster."""
    if cluster is None:
        yield ThreadExecutor(compiled_program_for(settings, bar), settings.seed, threads)
        return
    from transport.run.dask.executor import open_dask

    with open_dask(settings, cluster, threads, bar) as executor:
        yield executor


def _new_settings(request: RunRequest, bar: Progress) -> Settings:
    """Settings of a new run; for "auto", pilot runs choose the method."""
    scene, estimator, sampling = request.scene, request.estimator, request.sampling
    limits = request.limits()  # before any pilot runs
    part = checked_part(request.part, limits)
    choice, seed = None, 0 if request.seed is None else request.seed
    if estimator == AUTO or (estimator is None and limits.is_open):
        _check_no_part(part)
        # Without `error` and `estimator` any quantity may be read.
        reads_all = request.reads_all or (estimator is None and not limits.error)
        pilot = _pilots(request, seed, bar)
        sampling = "random" if sampling is None and request.guide else sampling  # a guide goes with no other
        wanted = {"particles": limits.particles, "seconds": limits.seconds, "reads_all": reads_all}
        choice = choose_method(
            scene, limits.error, sampling, pilot, **wanted, may_guide=request.guide is None
        )
        method = choice.method
    else:
        method = coerce_method(scene, estimator, "random" if sampling is None else sampling)
    method = guided(scene, method, limits.particles, request.guide)
    method = _with_short_guide(request, method)
    choice = None if choice is None else choice.with_method(method)
    limits = replace(request.limits(method), part=part)
    return Settings(scene, method, limits, seed, request.tracking, choice)


def _pilots(request: RunRequest, seed: int, bar: Progress) -> Callable[[Method, int], Result]:
    """Return a function that makes a pilot run of a method, with random numbers of its own."""
    scene, quiet = request.scene, PilotProgress(bar)

    def pilot(method: Method, particles: int) -> Result:
        bar.trying(method.title)
        # With a guide as in the run, of few histories; learnt once, in the first pilot, which is not timed.
        method = guided(scene, method, request.particles, request.guide)
        method = _with_short_guide(request, replace(method, guide=min(method.guide, MIN_GUIDE)))
        limits = RunRequest(scene, particles).limits(method)
        settings = Settings(scene, method, limits, seed ^ PILOT_SEED_MASK, request.tracking)
        return _pilot_run(settings, quiet)

    return pilot


def _pilot_run(settings: Settings, bar: Progress) -> Result:
    """Return the result of a pilot run, on one thread."""
    result = _execute(settings, 1, None, bar, time.perf_counter())
    if not result.is_complete:
        raise KeyboardInterrupt("interrupted during pilot runs, so there is no result")
    return result


@lru_cache(maxsize=32)
def _seconds_per_history(scene: Scene, method: Method, tracking: Tracking | None) -> float:
    """Return the time [s] that a history takes, from runs of few and more histories."""
    few, many = (RunRequest(scene, particles).limits(method) for particles in TIMED_HISTORIES)
    settings = Settings(scene, method, few, PILOT_SEED_MASK, tracking)
    first = _pilot_run(settings, Progress()).cost.seconds
    if first > LONG_PILOT_SECONDS:
        return first / TIMED_HISTORIES[0]
    second = _pilot_run(replace(settings, limits=many), Progress()).cost.seconds
    return max(second - first, 0.0) / (TIMED_HISTORIES[1] - TIMED_HISTORIES[0])


def _with_short_guide(request: RunRequest, method: Method) -> Method:
    """Return a method with a guide learnt in GUIDE_SECONDS, or in the time of the run if that is more.

    One that was asked for stays, and so does that of a run of so many particles by a named estimator.
    """
    is_timed = request.error or request.seconds is not None or request.estimator == AUTO
    if not method.guide or request.guide is not None or not is_timed:
        return method
    plain = replace(method, guide=0)
    per_history = _seconds_per_history(request.scene, plain, request.tracking)
    while method.guide * per_history > max(GUIDE_SECONDS, request.seconds or 0.0):
        method = replace(method, guide=method.guide // 2)
    return method if method.guide >= LEAST_GUIDED else plain


def _check_no_part(part: tuple[int, int]) -> None:
    """Refuse pilot runs for a part of a run: parts that choose different methods cannot be merged."""
    if part != (1, 1):
        cure = "name one, such as the choice in the report of a short run without part="
        raise SceneError(
            f"simulate: estimator {AUTO!r} does not go with part={part}, as parts could choose differently;"
            f" {cure}"
        )


@contextmanager
def _checkpoints(
    checkpoint: str | PathLike | None, every: float, scene: Scene
) -> Iterator["Checkpoints | None"]:
    """Object that saves the run at intervals, with its file locked; None without a checkpoint file."""
    if checkpoint is None:
        yield None
        return
    from transport.io.atomic import locked
    from transport.io.resuming import Checkpoints

    keep = Checkpoints(checkpoint, every, scene)
    with locked(keep.path):
        yield keep
