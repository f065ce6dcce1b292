"""Resuming: settings you pass, except limits, must match the saved run; others are taken from it.

Limits count from the beginning of the run, so that a repeated call runs nothing twice.
"""

from __future__ import annotations

import math
import os
import time
import warnings
from dataclasses import replace
from os import PathLike

from transport.compile.methods import AUTO
from transport.io.atomic import FileError
from transport.io.json.differences import differences
from transport.io.runs import checked_destination, checked_path, load, original_scene, save, scene_text
from transport.results.result import Result
from transport.run.run import Run
from transport.run.settings import RunRequest, Settings
from transport.scene.scene import Scene
from transport.validation import SceneError, as_float, short_repr


def run_to_resume(resume: object, checkpoint: object) -> Result | None:
    """Return the saved run, or None for a new one: if no run is named, or this call will create the file.

    Raises SceneError if the call would overwrite another run.
    """
    if not (resume is None or isinstance(resume, Result | str | PathLike)):
        raise SceneError(
            f"simulate: resume must be a file or a Result, got {short_repr(resume)}; write 'run.nc'"
        )
    path = None if checkpoint is None else checked_path("checkpoint", checkpoint)
    is_file = not (resume is None or isinstance(resume, Result))
    is_same = path is not None and is_file and os.path.realpath(path) == os.path.realpath(resume)
    if path is not None and path.exists() and not is_same:
        cure = f"pass resume={str(path)!r} to continue it, or remove it"
        raise SceneError(f"simulate: checkpoint must be a new file, but {path} exists; {cure}")
    if not is_file:
        return resume
    return None if is_same and not path.exists() else load(resume)


def resumed_settings(saved: Result, request: RunRequest) -> Settings:
    """Return the settings of a resumed run; limits are those of the saved run if the call has none.

    Raises SceneError that names the first argument that differs.
    """
    if saved.state is None:
        raise SceneError(
            "simulate: resume must be a run that can continue; pass a result of simulate, load or merge"
        )
    if unlike := differences(request.scene, original_scene(saved)):
        raise SceneError(f"simulate: the scene differs from that of the saved run: {'; '.join(unlike)}")
    method, limits, part = saved.plan.method, saved.state.limits, request.part
    _check_same("seed", request.seed, saved.seed)
    _check_same("estimator", None if request.estimator == AUTO else request.estimator, method.estimator)
    _check_same("sampling", request.sampling, method.sampling)
    _check_same("guide", request.guide, method.guide)
    _check_same("tracking", request.tracking, saved.plan.tracking)
    _check_same("batches", request.batches, limits.batches)
    _check_same("part", tuple(part) if isinstance(part, list) else part, limits.part)
    if request.particles is not None or request.error or request.seconds is not None:
        if limits.part != (1, 1):
            _check_same("particles", request.particles, limits.particles)
            _check_same("error", request.error or None, None)
            _check_same("seconds", request.seconds or None, None)
        changed = replace(request, batches=None if limits.is_free else limits.batches).limits(method)
        limits = replace(changed, is_free=limits.is_free, part=limits.part)
    return Settings(request.scene, method, limits, saved.seed, saved.asked, saved.choice)


def _check_same(name: str, requested: object, was: object) -> None:
    if requested is not None and requested != was:
        raise SceneError(
            f"simulate: {name} must be that of the saved run, {short_repr(was)}, got {short_repr(requested)};"
            " leave it out"
        )


# ---- Checkpoints: a run is saved while it runs, and continues from the last complete file after a crash.

NOT_SAVED = "not saved"  # begins the warning of a run whose end was not saved
# largest fraction of the time spent on writing: large runs are saved less often than requested
MAX_WRITE_FRACTION = 0.1


class CheckpointWarning(UserWarning):
    """A checkpoint could not be written; the run continues."""


class Checkpoints:
    """Saves a run at intervals of `every` seconds, and at its end with all results."""

    def __init__(self, path: object, every: object, scene: Scene) -> None:
        """Raise SceneError for an invalid path or interval, and for a scene that no file can hold."""
        # Make the path absolute, in case the script changes its folder.
        self.path = checked_destination("checkpoint", path).absolute()
        self.every = _checked_interval(every)
        self.scene, self.due, self.failures = scene_text(scene), time.perf_counter() + self.every, []

    def save_if_due(self, run: Run) -> None:
        """Save the run between two batches if it is due."""
        if time.perf_counter() < self.due or not run.batches:
            return
        begun = time.perf_counter()
        run.state = run.now()
        self._save(run.result(is_complete=False), is_over=False)
        ended = time.perf_counter()
        self.due = ended + max(self.every, (ended - begun) / MAX_WRITE_FRACTION)

    def end(self, result: Result) -> None:
        """Save the run at its end, and add a warning for each failure to save."""
        earlier = len(self.failures)
        is_saved = self._save(result, is_over=True)
        if earlier:
            times = f"{earlier} checkpoints" if earlier > 1 else "a checkpoint"
            result._warnings.append(f"{times} could not be written: {self.failures[-1]}")
        if not is_saved:
            result._warnings.append(f"{NOT_SAVED} at its end: {self.failures[-1]}")

    def _save(self, result: Result, is_over: bool) -> bool:
        """Save the result, and return whether that succeeded."""
        try:
            save(result, self.path, self.scene, is_over)
        except FileError as error:
            self.failures.append(str(error))
            problem = f"the run is {NOT_SAVED}" if is_over else "checkpoint not written, the run continues"
            warnings.warn(f"{problem}: {error}", CheckpointWarning, stacklevel=2)
            return False
        return True


def _checked_interval(every: object) -> float:
    seconds = as_float(every)
    if seconds is None or not 0 < seconds < math.inf:
        raise SceneError(
            f"simulate: every must be a positive, finite time in seconds, got {short_repr(every)};"
            " write every=60"
        )
    return seconds
