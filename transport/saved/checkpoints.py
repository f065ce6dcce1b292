"""A run that is saved while it goes on: killed at any instant, the file is the last whole one, and the run goes on from it."""

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

NOT_SAVED = "not saved"  # as which a warning begins of a run whose end is in no file
SHARE = 0.1  # of the time at most that goes into writing: large runs are saved less often than asked for


class CheckpointWarning(UserWarning):
    """A checkpoint could not be written; the run goes on."""


class Checkpoints:
    """What saves a run every so many seconds, and at its end with all that it found out."""

    def __init__(self, path: object, every: object, scene: Scene) -> None:
        """Raises SceneError for a file or an interval that is none, and for a scene that no file can hold."""
        self.path = checked_place("checkpoint", path).absolute()  # whatever folder the script goes to
        self.every = _checked(every)
        self.scene, self.due, self.failures = scene_text(scene), time.perf_counter() + self.every, []

    def if_due(self, run: Run, result_of: Callable[[Run, bool], Result]) -> None:
        """Save the run between two of its batches, if it is time.  result_of: (run, is_complete) -> what it found out."""
        if time.perf_counter() < self.due or not run.batches:
            return
        begun = time.perf_counter()
        run.state = run.now()
        self._save(result_of(run, False), is_over=False)
        ended = time.perf_counter()
        self.due = ended + max(self.every, (ended - begun) / SHARE)

    def end(self, result: Result) -> None:
        """Save the run as it ends, and tell in its warnings what could not be saved."""
        earlier = len(self.failures)
        is_saved = self._save(result, is_over=True)
        if earlier:
            times = f"{earlier} checkpoints" if earlier > 1 else "a checkpoint"
            result._warnings.append(f"{times} could not be written: {self.failures[-1]}")
        if not is_saved:
            result._warnings.append(f"{NOT_SAVED} as it ended: {self.failures[-1]}")

    def _save(self, result: Result, is_over: bool) -> bool:
        """Save it; whether that went well."""
        try:
            save(result, self.path, self.scene, is_over)
        except FileError as error:
            self.failures.append(str(error))
            told = f"the run is {NOT_SAVED}" if is_over else "checkpoint not written, the run goes on"
            warnings.warn(f"{told}: {error}", CheckpointWarning, stacklevel=2)
            return False
        return True


def _checked(every: object) -> float:
    seconds = as_float(every)
    if seconds is None or not 0 < seconds < math.inf:
        raise SceneError(
            f"simulate: every must be seconds, positive and finite, got {shown(every)}; write every=60"
        )
    return seconds
