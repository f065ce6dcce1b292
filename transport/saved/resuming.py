"""Going on with a saved run: what is not said is as it was, and what is said must not be unlike it, but for the limits.

Limits count from the beginning of the run, so that a call that is repeated does nothing twice.
"""

from __future__ import annotations

import os
from dataclasses import replace
from os import PathLike

from transport.estimators.methods import AUTO
from transport.results import Result
from transport.runs.limits import Limits, checked_limits
from transport.runs.ways import Asked, Way
from transport.saved.merging import MISSING
from transport.saved.record import checked_path, given_scene, load
from transport.scene import Scene
from transport.validation import SceneError, shown
from transport.written.differences import differences


def run_to_go_on_with(resume: object, checkpoint: object) -> Result | None:
    """The saved run, or None for one that begins: where none is named, or the file is yet to be written by this very run.

    Raises SceneError where it would write over another run.
    """
    if not (resume is None or isinstance(resume, Result | str | PathLike)):
        raise SceneError(f"simulate: resume must be a file or a Result, got {shown(resume)}; write 'run.nc'")
    path = None if checkpoint is None else checked_path("checkpoint", checkpoint)
    is_file = not (resume is None or isinstance(resume, Result))
    is_same = path is not None and is_file and os.path.realpath(path) == os.path.realpath(resume)
    if path is not None and path.exists() and not is_same:
        cure = f"say resume={str(path)!r} to go on with it, or remove it"
        raise SceneError(f"simulate: checkpoint must be a new file, but {path} is there; {cure}")
    if not is_file:
        return resume
    return None if is_same and not path.exists() else load(resume)


def lasting_warnings(saved: Result) -> list[str]:
    """What is said of a saved run however far it goes on: the batches of a merged one that are missing."""
    return [warning for warning in saved._warnings if MISSING in warning]


def way_of(saved: Result, scene: Scene, asked: Asked) -> Way:
    """How a saved run goes on.  Raises SceneError that names what is asked for and unlike it."""
    _check_alike(saved, scene, asked)
    return Way(saved.plan.method, _limits(saved, asked), saved.seed, saved.asked, saved.choice)


def _check_alike(saved: Result, scene: Scene, asked: Asked) -> None:
    if saved.state is None:
        raise SceneError(
            "simulate: resume must be a run that can go on; take one that simulate, load or merge returned"
        )
    if unlike := differences(scene, given_scene(saved)):
        raise SceneError(f"simulate: the scene is not that of the saved run: {'; '.join(unlike)}")
    method, limits = saved.plan.method, saved.state.limits
    _check("seed", asked.seed, saved.seed)
    _check("estimator", None if asked.estimator == AUTO else asked.estimator, method.estimator)
    _check("sampling", asked.sampling, method.sampling)
    _check("tracking", asked.tracking, saved.plan.tracking)
    _check("batches", asked.batches, limits.batches)
    _check("part", tuple(asked.part) if isinstance(asked.part, list) else asked.part, limits.part)


def _limits(saved: Result, asked: Asked) -> Limits:
    """When the run that goes on ends: as was said at first, where nothing is said now."""
    was = saved.state.limits
    if asked.particles is None and not asked.error and asked.seconds is None:
        return was
    if was.part != (1, 1):
        _check("particles", asked.particles, was.particles)
        for name in ("error", "seconds"):
            _check(name, getattr(asked, name) or None, None)
    batches = None if was.is_free else was.batches
    limits = checked_limits(given_scene(saved), *asked.limits, batches, saved.plan.method)
    return replace(limits, is_free=was.is_free, part=was.part)


def _check(name: str, said: object, was: object) -> None:
    if said is not None and said != was:
        raise SceneError(
            f"simulate: {name} must be that of the saved run, {shown(was)}, got {shown(said)}; leave it out"
        )
