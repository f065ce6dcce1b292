"""Checkpoints: a run is saved while it runs, and continues from the last complete file after a crash."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable

from transport.results import Result
from transport.runs.running import Run
from transport.saved.record import checked_place, save, scene_text
from transport.saved.whole import FileError
from transport.scene import Scene
from transport.validation import SceneError, as_float, shown

NOT_SAVED = "not saved"  # begins the warning of a run whose end was not saved
SHARE = 0.1  # largest fraction of the time spent on writing: large runs are saved less often than requested


class CheckpointWarning(UserWarning):
    """A checkpoint could not be written; the run continues."""


class Checkpoints:
    """Saves a run at intervals of `every` seconds, and at its end with all results."""

    def __init__(self, path: object, every: object, scene: Scene) -> None:
        """Raise SceneError for an invalid path or interval, and for a scene that no file can hold."""
        self.path = checked_place("checkpoint", path).absolute()  # in case the script changes its folder
        self.every = _checked(every)
        self.scene, self.due, self.failures = scene_text(scene), time.perf_counter() + self.every, []

    def if_due(self, run: Run, result_of: Callable[[Run, bool], Result]) -> None:
        """Save the run between two batches if it is due; `result_of(run, is_complete)` returns its result."""
        if time.perf_counter() < self.due or not run.batches:
            return
        begun = time.perf_counter()
        run.state = run.now()
        self._save(result_of(run, False), is_over=False)
        ended = time.perf_counter()
        self.due = ended + max(self.every, (ended - begun) / SHARE)

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
            told = f"the run is {NOT_SAVED}" if is_over else "checkpoint not written, the run continues"
            warnings.warn(f"{told}: {error}", CheckpointWarning, stacklevel=2)
            return False
        return True


def _checked(every: object) -> float:
    seconds = as_float(every)
    if seconds is None or not 0 < seconds < math.inf:
        raise SceneError(
            f"simulate: every must be a positive, finite time in seconds, got {shown(every)}; write every=60"
        )
    return seconds
