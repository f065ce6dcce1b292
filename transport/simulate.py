"""The one entry point: run batches of a scene until enough is known, then reduce them to a result."""

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from os import PathLike
from typing import TYPE_CHECKING

from transport.estimators.choosing import OTHER_NUMBERS, choose
from transport.estimators.methods import AUTO, Method, checked_method
from transport.results import Cost, Result
from transport.results.choice import Choice
from transport.runs.hiring import Hands, Staff, checked_staff, hands_for
from transport.runs.interruption import put_off
from transport.runs.limits import Limits, checked_limits, checked_part, checked_whole
from transport.runs.origins import doubts_of
from transport.runs.progress import PilotProgress, Progress, progress_on
from transport.runs.running import Run
from transport.runs.ways import Asked, Way
from transport.scene import Scene
from transport.tracking import Tracking
from transport.validation import SceneError, shown, suggestion

if TYPE_CHECKING:
    from transport.saved.checkpoints import Checkpoints


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
) -> Result:
    """Run a scene and return what its detectors counted, every number with its standard error.

    particles: histories to emit, a whole number such as 1e6, exactly as many, or with "sobol" and "stratified" as many as fill equal batches whose sizes
    are powers of two: up to twice as many, result.particles says how many;  error: {"meter.flux_in": 1e-3}, relative standard errors to reach;
    seconds: wall-clock time, besides that of compiling and of pilots.  The run ends at the first limit reached, in whole batches; Ctrl-C returns the batches
    done so far, labelled incomplete, and before the first one raises KeyboardInterrupt, which says how long a batch takes.  The same seed gives bitwise the same result for any number of threads.
    tracking: how histories go through media, "analog", "weighted" or a Tracking; None for what suits the scene (its report
    says which, and what of it had nothing to do).
    estimator: see transport.estimators.methods.  None for "auto" with `error` or `seconds`, for "analog" with `particles` alone, and
    for "backward" where a Camera or an EnvironmentMap needs it.  "auto" takes the cheapest that can be trusted, found by short pilots,
    which take about half a second together; one where the scene allows but one is taken without.  Pilots measure times, so two runs may choose
    differently: the report names the choice, and a run repeats bitwise under that name.  A run by default with `seconds` alone may be
    read for everything: then "aimed" and "backward", which know only what arrives at detectors, are taken only where no other one
    tells anything, and the report says what they would save.
    sampling: None for "random", or for any with "auto"; a name restricts "auto" to it.
    batches: independent replicates, from whose spread errors are told; None for 32, for 128 to 256 with `error` (fewer where
    sums are large), and for fewer with "sobol" and "stratified".  These take `error` and `seconds` in rounds, each twice as
    large as the one before, of which the last complete one is the result.
    A run for an `error` looks at its errors a few times only, where an earlier look has planned it, so that its intervals
    cover what they claim; it also goes on while its means are lopsided, of few or unlike scores (transport.runs.stopping).
    seed: None for 0;  threads: None for one a core;  progress: a bar on the terminal, None where there is one;
    "lines" for a line now and then where there is none, as in the log of a job.
    resume: a saved run to go on with, limits counting from its beginning; what is not said is as it was, its estimator too.
    checkpoint: a file, .nc or .npz, to save the run to every so many seconds and at its end, new or that of `resume`; with the
    same file for both the call begins, goes on or has nothing to do.  part: (k, n), only the k-th of n parts of the batches, for `tp.merge`; "auto" is
    refused with it, as parts that choose apart could not be merged.
    cluster: where the batches are done, bit for bit as here: a dask.distributed Client or cluster, the address of a scheduler, or
    "local" for a process a thread.
    Raises SceneError for input that cannot be run.
    """
    return _begin(
        scene,
        Asked(particles, error, seconds, batches, part, seed, estimator, sampling, tracking),
        threads,
        cluster,
        progress,
        resume,
        checkpoint,
        every,
    )


def simulate_for_any_reader(
    scene: Scene,
    threads: int | None = None,
    cluster: object = None,
    progress: bool | str | None = None,
    resume: Result | str | PathLike | None = None,
    checkpoint: str | PathLike | None = None,
    every: float = 60.0,
    **asked: object,
) -> Result:
    """As `simulate`, of which any quantity may be read, and the ledger, whatever `error` names.

    asked: fields of Asked.
    """
    return _begin(
        scene, Asked(**asked, reads_all=True), threads, cluster, progress, resume, checkpoint, every
    )


def _begin(
    scene: Scene,
    asked: Asked,
    threads: int | None,
    cluster: object,
    progress: bool | str | None,
    resume: Result | str | PathLike | None,
    checkpoint: str | PathLike | None,
    every: float,
) -> Result:
    """Check what is asked for, and run it."""
    if not isinstance(scene, Scene):
        raise SceneError(
            f"simulate: scene must be a Scene, got {shown(scene)}; write Scene(sources=[...], ...)"
        )
    seed = None if asked.seed is None else checked_whole("seed", asked.seed, 0, 2**64 - 1)
    asked = replace(asked, seed=seed, tracking=checked_tracking(scene, asked.tracking))
    staff = checked_staff(threads, cluster)
    with _checkpoints(checkpoint, every, scene) as keep:  # before a run is read that another might be writing
        return _run(scene, asked, _saved(resume, checkpoint), staff, keep, progress)


def _run(
    scene: Scene,
    asked: Asked,
    saved: Result | None,
    staff: Staff,
    keep: "Checkpoints | None",
    progress: bool | str | Progress | None,
) -> Result:
    """Begin, or go on with the saved run, until enough is known."""
    begun = time.perf_counter()
    with progress_on(progress) as bar:
        way = _way(scene, asked, saved, bar)
        with put_off() as interruption, hands_for(scene, way, staff, bar, interruption) as hands:
            ready = time.perf_counter()
            plan, seed, limits, threads = hands.plan, way.seed, way.limits, hands.threads
            run = Run(
                scene, plan, seed, limits, threads, bar, hands.hire, way.choice, interruption=interruption
            )
            result_of = partial(_result, way=way, hands=hands, begun=begun, ready=ready)
            if saved is not None:
                run.go_on_with(saved.state, saved.cost, _lasting_warnings(saved))
            if keep is not None:
                run.between = lambda run: keep.if_due(run, result_of)
            run.go()
            if not run.batches:
                raise KeyboardInterrupt(run.why_nothing())
            result = result_of(run, run.is_complete)
            if keep is not None:
                keep.end(result)
    return result


def _saved(resume: Result | str | PathLike | None, checkpoint: str | PathLike | None) -> Result | None:
    """The run to go on with, None for one that begins."""
    if resume is None and checkpoint is None:
        return None
    from transport.saved.resuming import run_to_go_on_with

    return run_to_go_on_with(resume, checkpoint)


def _lasting_warnings(saved: Result) -> list[str]:
    from transport.saved.resuming import lasting_warnings

    return lasting_warnings(saved)


def _way(scene: Scene, asked: Asked, saved: Result | None, bar: Progress) -> Way:
    """How the scene is run: as it is asked for, and as it was begun."""
    if saved is not None:
        from transport.saved.resuming import way_of

        return way_of(saved, scene, asked)
    limits = checked_limits(scene, *asked.limits, asked.batches)  # before any pilot runs
    part = checked_part(asked.part, limits)
    seed = 0 if asked.seed is None else asked.seed
    choice, estimator, sampling = None, asked.estimator, asked.sampling
    if estimator is None and limits.is_open:
        estimator = AUTO
    if estimator == AUTO:
        _check_no_part(part)
        choice = _choice(scene, asked, limits, seed, bar)
        estimator, sampling = choice.method.estimator, choice.method.sampling
    method = checked_method(scene, estimator, "random" if sampling is None else sampling)
    limits = checked_limits(scene, *asked.limits, asked.batches, method)
    return Way(method, replace(limits, part=part), seed, asked.tracking, choice)


def _check_no_part(part: tuple[int, int]) -> None:
    """Refuse pilots for a part of a run: each part would choose by seconds of its own, and the parts could not be merged."""
    if part != (1, 1):
        cure = "name one, such as that which the report of a short run without part= names"
        raise SceneError(
            f"simulate: estimator {AUTO!r} does not go with part={part}, as parts may choose apart; {cure}"
        )


@contextmanager
def _checkpoints(
    checkpoint: str | PathLike | None, every: float, scene: Scene
) -> Iterator["Checkpoints | None"]:
    """What saves the run while it goes on, its file to itself; None where nobody asked for it."""
    if checkpoint is None:
        yield None
        return
    from transport.saved.checkpoints import Checkpoints
    from transport.saved.lock import held

    keep = Checkpoints(checkpoint, every, scene)
    with held(keep.path):
        yield keep


def _result(run: Run, is_complete: bool, way: Way, hands: Hands, begun: float, ready: float) -> Result:
    """What the batches of a run come to, now."""
    cost = Cost(
        seconds=time.perf_counter() - ready + run.seconds_before,
        preparation=ready - begun,
        particles=run.particles,
        crossings=run.crossings,
        collisions=run.collisions,
        threads=run.threads,
        workers=hands.workers,
        slopes=run.slopes,
        forecast=run.forecast,
    )
    warnings = [*run.warnings, *hands.doubts(), *doubts_of(run.state.origins)]
    return Result(
        run.plan, run.batches, way.seed, cost, is_complete, warnings, way.tracking, way.choice, run.state
    )


def _choice(scene: Scene, asked: Asked, limits: Limits, seed: int, bar: Progress) -> Choice:
    """The cheapest way, by pilots that have random numbers of their own."""
    quiet, staff = PilotProgress(bar), Staff(1)

    def pilot(method: Method, particles: int) -> Result:
        bar.trying(method.title)
        of_method = Asked(
            particles,
            seed=seed ^ OTHER_NUMBERS,
            estimator=method.estimator,
            sampling=method.sampling,
            tracking=asked.tracking,
        )
        result = _run(scene, of_method, None, staff, None, quiet)
        if not result.is_complete:
            raise KeyboardInterrupt("interrupted while pilots tried the estimators, so nothing is known")
        return result

    return choose(
        scene,
        limits.error,
        asked.sampling,
        pilot,
        particles=limits.particles,
        seconds=limits.seconds,
        reads_all=asked.reads_all or (asked.estimator is None and not limits.error),
    )


def checked_tracking(scene: Scene, tracking: Tracking | str | None) -> Tracking | None:
    """How to follow histories through media; None where that is left to the scene."""
    given = tracking
    if isinstance(tracking, str) and tracking in ("analog", "weighted"):
        tracking = Tracking(absorption=tracking)
    if tracking is None or isinstance(tracking, Tracking):
        if tracking is not None and tracking.absorption == "weighted" and scene.duration is not None:
            cure = "leave it out" if isinstance(given, str) else "write Tracking(absorption='analog', ...)"
            raise SceneError(
                f"simulate: tracking must be analog in a scene with a duration, got {shown(given)}; {cure}"
            )
        return tracking
    must = "tracking must be 'analog', 'weighted' or a Tracking"
    raise SceneError(f"simulate: {must}, got {shown(tracking)}; {_tracking_cure(tracking)}")


def _tracking_cure(tracking: object) -> str:
    """What to write instead of a tracking that is none."""
    if isinstance(tracking, str):
        if tracking in ("roulette", "forced", "splitting"):
            return f"write tracking=Tracking({tracking}=...)"
        meant = suggestion(tracking, ("analog", "weighted"))
        if meant.startswith("did you mean"):
            return meant
    return "leave it out for what suits the scene"
