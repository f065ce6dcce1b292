"""Resuming: settings you pass, except limits, must match the saved run; others are taken from it.

Limits count from the beginning of the run, so that a repeated call runs nothing twice.
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
    """Return the saved run, or None for a new one: if no run is named, or this call will create the file.

    Raises SceneError if the call would overwrite another run.
    """
    if not (resume is None or isinstance(resume, Result | str | PathLike)):
        raise SceneError(f"simulate: resume must be a file or a Result, got {shown(resume)}; write 'run.nc'")
    path = None if checkpoint is None else checked_path("checkpoint", checkpoint)
    is_file = not (resume is None or isinstance(resume, Result))
    is_same = path is not None and is_file and os.path.realpath(path) == os.path.realpath(resume)
    if path is not None and path.exists() and not is_same:
        cure = f"pass resume={str(path)!r} to continue it, or remove it"
        raise SceneError(f"simulate: checkpoint must be a new file, but {path} exists; {cure}")
    if not is_file:
        return resume
    return None if is_same and not path.exists() else load(resume)


def lasting_warnings(saved: Result) -> list[str]:
    """Return the warnings that a resumed run keeps: those about missing batches of a merged run."""
    return [warning for warning in saved._warnings if MISSING in warning]


def way_of(saved: Result, scene: Scene, asked: Asked) -> Way:
    """Return the settings of a resumed run.  Raises SceneError that names the first argument that differs."""
    _check_alike(saved, scene, asked)
    return Way(saved.plan.method, _limits(saved, asked), saved.seed, saved.asked, saved.choice)


def _check_alike(saved: Result, scene: Scene, asked: Asked) -> None:
    if saved.state is None:
        raise SceneError(
            "simulate: resume must be a run that can continue; pass a result of simulate, load or merge"
        )
    if unlike := differences(scene, given_scene(saved)):
        raise SceneError(f"simulate: the scene differs from that of the saved run: {'; '.join(unlike)}")
    method, limits = saved.plan.method, saved.state.limits
    _check("seed", asked.seed, saved.seed)
    _check("estimator", None if asked.estimator == AUTO else asked.estimator, method.estimator)
    _check("sampling", asked.sampling, method.sampling)
    _check("tracking", asked.tracking, saved.plan.tracking)
    _check("batches", asked.batches, limits.batches)
    _check("part", tuple(asked.part) if isinstance(asked.part, list) else asked.part, limits.part)


def _limits(saved: Result, asked: Asked) -> Limits:
    """Return the limits of the resumed run; those of the saved run if the call has none."""
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
