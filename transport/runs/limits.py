"""When a run ends, and how it is told: input checked before anything runs."""

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from transport.cameras import Instrument
from transport.detectors import Detector
from transport.estimators.methods import ANALOG, Method
from transport.phase_space import PhaseSpace, Snapshot
from transport.points import PointDetector
from transport.results.backward_readings import IMAGE_QUANTITIES
from transport.results.phase_readings import OF_PHASE_MOMENTS, PHASE_QUANTITIES
from transport.results.point_readings import POINT_QUANTITIES
from transport.results.readings import BY_DIRECTION, CLOCKED, OF_MOMENTS, QUANTITIES
from transport.results.volume_readings import VOLUME_QUANTITIES, VOLUMES_CLOCKED
from transport.scene import Scene
from transport.validation import SceneError, suggestion
from transport.volumes import VolumeDetector

FEWEST_FOR_ERROR = 16  # batches
# batches, and up to twice as many: they know an error to 1 / sqrt(2 × 128) = 6 % or better
MANY_FOR_ERROR = 128
MOST_BATCHES = 4096
HOPELESS = 10**7  # particles without a score, after which a run for an error ends
MOST_PARTICLES = 10**10  # at which a run for an `error` alone ends, with a warning


@dataclass(frozen=True)
class Limits:
    """When a run ends: at the first of these that is reached."""

    particles: int | None
    error: Mapping[str, float]
    seconds: float | None
    batches: int
    is_free: bool = False  # whether the number of batches was left open
    part: tuple[int, int] = (1, 1)  # which of how many parts of the batches

    @property
    def is_open(self) -> bool:
        """Whether it depends on errors or on time how many particles it takes."""
        return bool(self.error) or self.seconds is not None


def checked_limits(scene, particles, error, seconds, batches, method=ANALOG) -> Limits:
    """The limits of a run, as `simulate` takes them.  Raises SceneError where none is given or one cannot be kept."""
    error = {} if error is None else error
    if not isinstance(error, Mapping):
        raise SceneError(f"simulate: error must be like {{'meter.flux_in': 1e-3}}, got {error!r}")
    if particles is None and not error and seconds is None:
        raise SceneError(
            "simulate: no limit given; say particles=1_000_000, error={'meter.flux_in': 1e-3} or seconds=10"
        )
    if particles is not None:
        particles = checked_whole("particles", particles, 1, MOST_PARTICLES * 100)
    if seconds is not None and not (_is_number(seconds) and 0 < seconds < math.inf):
        raise SceneError(f"simulate: seconds must be positive and finite, got {seconds!r}")
    is_free = batches is None
    if is_free:
        batches = _usual_batches(method, error)
    batches = checked_whole("batches", batches, 2, MOST_BATCHES)
    if error and batches < FEWEST_FOR_ERROR:
        raise SceneError(
            f"simulate: batches must be at least {FEWEST_FOR_ERROR} with error=..., got {batches}; of fewer the run"
            " would end when their error happens to look small"
        )
    for name, target in error.items():
        _check_quantity(scene, name)
        if not (_is_number(target) and 0 < target < 1):
            raise SceneError(f"simulate: error of {name!r} must be relative, within (0, 1), got {target!r}")
    return Limits(particles, dict(error), seconds, batches, is_free)


def _usual_batches(method: Method, error: Mapping[str, float]) -> int:
    """How many batches, where nothing is said: for an error so many that it is well known."""
    if not error:
        return method.usual_batches
    return MANY_FOR_ERROR if method.sampling == "random" else FEWEST_FOR_ERROR


def _check_quantity(scene: Scene, name: str) -> None:
    detector, _, quantity = str(name).partition(".")
    names = [d.name for d in scene.detectors]
    if detector in names and not quantity:
        raise SceneError(f"simulate: error must name a quantity of {detector!r}; write '{detector}.flux_in'")
    if detector not in names:
        raise SceneError(f"simulate: error names no detector {detector!r}; {suggestion(detector, names)}")
    asked = scene.detectors[names.index(detector)]
    if isinstance(asked, Snapshot):
        raise SceneError(
            f"simulate: error names the Snapshot {detector!r}, which is a sample; name a PhaseSpace"
        )
    known = PHASE_QUANTITIES if isinstance(asked, PhaseSpace) else QUANTITIES
    known = VOLUME_QUANTITIES if isinstance(asked, VolumeDetector) else known
    known = POINT_QUANTITIES if isinstance(asked, PointDetector) else known
    known = IMAGE_QUANTITIES if isinstance(asked, Instrument) else known
    if quantity not in known:
        raise SceneError(f"simulate: error names no quantity {quantity!r}; {suggestion(quantity, known)}")
    of_moments = {Detector: OF_MOMENTS, PhaseSpace: OF_PHASE_MOMENTS}.get(type(asked), ())
    if quantity in of_moments and not asked.moments:
        raise SceneError(f"simulate: error of {name!r} needs moments; write moments=True")
    if isinstance(asked, PhaseSpace | Instrument):
        return
    if quantity in BY_DIRECTION and asked.directions is None:
        raise SceneError(f"simulate: error of {name!r} needs a detector with directions=...; add them")
    if quantity in (*CLOCKED, *VOLUMES_CLOCKED) and scene.duration is None:
        raise SceneError(f"simulate: error of {name!r} needs a clock; write Scene(..., duration=...)")


def checked_whole(name: str, value: object, least: int, most: int) -> int:
    """The value as a whole number within its range; floats such as 1e6 are taken.  Raises SceneError."""
    is_whole = _is_number(value) and math.isfinite(value) and value == int(value)
    if not is_whole or not least <= value <= most:
        raise SceneError(f"simulate: {name} must be a whole number from {least} to {most}, got {value!r}")
    return int(value)


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(
        value, (bool, np.bool_)
    )


def checked_part(part: object, limits: Limits) -> tuple[int, int]:
    """(k, n): the k-th of n parts of a run for `particles`, (1, 1) where all is done.  Raises SceneError."""
    if part is None:
        return 1, 1
    is_pair = isinstance(part, tuple | list) and len(part) == 2
    if not is_pair or not all(_is_number(number) and number == number // 1 for number in part):
        raise SceneError(
            f"simulate: part must be (k, n), the k-th of n parts, got {part!r}; write part=(1, 4)"
        )
    one, of = map(int, part)
    if not 1 <= one <= of:
        cure = f"; an array counted from 0 says k + 1: part=({one + 1}, {of})" if one == 0 < of else ""
        raise SceneError(f"simulate: part must be (k, n) with k from 1 to n, got {part!r}{cure}")
    if of > 1 and limits.is_open:
        raise SceneError(
            f"simulate: part must be of a run for particles alone, got {part!r}; leave out error and seconds"
        )
    return one, of


def checked_threads(threads: object) -> int:
    """The number of threads; None means one for each core that this process may use.  Raises SceneError."""
    if threads is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return checked_whole("threads", threads, 1, 1024)
