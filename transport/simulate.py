"""The one entry point: run batches of a scene until enough is known, then reduce them to a result."""

import time
from collections.abc import Mapping
from functools import lru_cache, partial

from transport.compile import compile_scene
from transport.estimators.aimed import aimed_scene
from transport.estimators.choosing import OTHER_NUMBERS, Choice, choose
from transport.estimators.methods import ANALOG, AUTO, Method, checked_method
from transport.results import Cost, Result
from transport.runs.crew import Crew
from transport.runs.limits import checked_limits, checked_threads, checked_whole
from transport.runs.progress import Progress, progress_on
from transport.runs.running import Run
from transport.scene import Scene
from transport.tracking import Tracking
from transport.validation import SceneError, shown, suggestion


def simulate(
    scene: Scene,
    particles: int | None = None,
    error: Mapping[str, float] | None = None,
    seconds: float | None = None,
    seed: int = 0,
    batches: int | None = None,
    threads: int | None = None,
    estimator: str | None = None,
    sampling: str | None = None,
    tracking: Tracking | str | None = None,
    progress: bool | None = None,
) -> Result:
    """Run a scene and return what its detectors counted, every number with its standard error.

    particles: histories to emit, exactly as many, or with "sobol" and "stratified" as many as fill equal batches whose sizes
    are powers of two: up to twice as many, result.particles says how many;  error: {"meter.flux_in": 1e-3}, relative standard errors to reach;
    seconds: wall-clock time.  The run ends at the first limit reached, in whole batches; Ctrl-C returns the batches
    done so far, labelled incomplete, and before the first one raises KeyboardInterrupt, which says how long a batch takes.  The same seed gives bitwise the same result for any number of threads.
    tracking: how histories go through media, "analog", "weighted" or a Tracking; None for what suits the scene (its report
    says which, and what of it had nothing to do).
    estimator, sampling: see transport.estimators.methods; None for "analog" and "random".  "auto" takes the cheapest, found by short
    pilots; this depends on measured times, so the report names it, and the run repeats bitwise under that name.
    batches: independent replicates, from whose spread errors are told; None for 32, for 128 to 256 with `error` (fewer where
    sums are large), and for fewer with "sobol" and "stratified".  These take `error` and `seconds` in rounds, each twice as
    large as the one before, of which the last complete one is the result.
    A run for an `error` looks at its errors a few times only, where an earlier look has planned it, so that its intervals
    cover what they claim; it also goes on while its means are lopsided, of few or unlike scores (transport.runs.stopping).
    threads: None for one a core;  progress: a bar on the terminal, None where there is one.
    Raises SceneError for input that cannot be run.
    """
    if not isinstance(scene, Scene):
        raise SceneError(
            f"simulate: scene must be a Scene, got {shown(scene)}; write Scene(sources=[...], ...)"
        )
    choice = None
    if estimator == AUTO:
        choice = _choice(scene, (particles, error, seconds), sampling, tracking, seed)
        estimator, sampling = choice.method.estimator, choice.method.sampling
    method = checked_method(scene, estimator, "random" if sampling is None else sampling)
    limits = checked_limits(scene, particles, error, seconds, batches, method)
    seed, threads = checked_whole("seed", seed, 0, 2**64 - 1), checked_threads(threads)
    tracking = checked_tracking(scene, tracking)
    with progress_on(progress) as bar:
        begun = time.perf_counter()
        machine = _machine(scene, tracking, method, bar)
        ready = time.perf_counter()
        plan, hire = machine.program.plan, partial(Crew, machine, seed, threads)
        run = Run(scene, plan, seed, limits, threads, bar, hire)
        run.go()
    if not run.batches:
        raise KeyboardInterrupt(run.why_nothing())
    done = time.perf_counter()
    cost = Cost(
        seconds=done - ready,
        preparation=ready - begun,
        particles=run.particles,
        crossings=run.crossings,
        collisions=run.collisions,
        threads=threads,
        slopes=run.slopes,
        forecast=run.forecast,
    )
    return Result(plan, run.batches, seed, cost, run.is_complete, run.warnings, tracking, choice, run.state)


def _choice(scene: Scene, limits: tuple, sampling: str | None, tracking, seed: int) -> Choice:
    """The cheapest way, by pilots that have random numbers of their own; limits: checked before anything runs."""
    error = checked_limits(scene, *limits, ANALOG.usual_batches).error
    pilots = {"seed": checked_whole("seed", seed, 0, 2**64 - 1) ^ OTHER_NUMBERS, "threads": 1}
    pilot = partial(simulate, scene, tracking=checked_tracking(scene, tracking), progress=False, **pilots)
    return choose(
        scene,
        error,
        sampling,
        lambda method, particles: pilot(particles, estimator=method.estimator, sampling=method.sampling),
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


@lru_cache(maxsize=32)
def _program(scene: Scene, tracking: Tracking | None, method: Method):
    from transport.engine.program import program_of

    scene = aimed_scene(scene) if method.estimator == "aimed" else scene
    return program_of(compile_scene(scene, tracking, method))


def _machine(scene: Scene, tracking: Tracking | None, method: Method, bar: Progress):
    """Passes compiled or loaded, and wired; kept for scenes that are run again."""
    from transport.engine.driver import machine_of

    program = _program(scene, tracking, method)
    if program.machine is None:
        program.machine = machine_of(program, bar.compiling)
    return program.machine
