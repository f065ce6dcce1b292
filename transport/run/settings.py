"""Settings of a run: its scene, method, limits and seed, and the checks of these arguments."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from transport.compile.methods import ANALOG, Method
from transport.results.choice import Choice
from transport.results.result import TALLIES
from transport.scene.phase_space import Snapshot
from transport.scene.scene import Scene
from transport.scene.tracking import Tracking
from transport.validation import SceneError, name_hint, set_fields, short_repr

MIN_BATCHES_FOR_ERROR = 16  # batches
# batches, up to twice as many: the error is then known to 1 / sqrt(2 × 128) = 6 % or better
USUAL_BATCHES_FOR_ERROR = 128
MAX_BATCHES = 4096
MAX_PARTICLES_UNSCORED = 10**7  # particles without a score, after which a run for an error ends
MAX_GUIDE_ASKED = 10**7  # histories from which a guide is learnt: what each brought is kept in memory
MAX_PARTICLES = 10**10  # particles at which a run for an `error` alone ends, with a warning


@dataclass(frozen=True)
class Limits:
    """Limits of a run, which ends at the first one that is reached."""

    particles: int | None
    error: Mapping[str, float]
    seconds: float | None
    batches: int
    is_free: bool = False  # whether the user left the number of batches open
    part: tuple[int, int] = (1, 1)  # (k, n): the k-th of n parts of the batches

    @property
    def is_open(self) -> bool:
        """Whether the number of particles depends on errors or time."""
        return bool(self.error) or self.seconds is not None


@dataclass(frozen=True)
class RunRequest:
    """The arguments of `simulate` that determine the batches of a run; None where one is left out.

    reads_all: whether any quantity may be read, although `error` names some only.
    """

    scene: Scene
    particles: float | None = None
    error: Mapping[str, float] | None = None
    seconds: float | None = None
    batches: int | None = None
    part: tuple[int, int] | None = None
    seed: int | None = None
    estimator: str | None = None
    sampling: str | None = None
    tracking: Tracking | str | None = None
    guide: int | None = None
    reads_all: bool = False

    def __post_init__(self) -> None:
        if not isinstance(self.scene, Scene):
            got = short_repr(self.scene)
            raise SceneError(f"simulate: scene must be a Scene, got {got}; write Scene(sources=[...], ...)")
        seed = None if self.seed is None else checked_integer("seed", self.seed, 0, 2**64 - 1)
        guide = None if self.guide is None else checked_integer("guide", self.guide, 0, MAX_GUIDE_ASKED)
        set_fields(self, seed=seed, tracking=coerce_tracking(self.scene, self.tracking), guide=guide)

    def limits(self, method: Method = ANALOG) -> Limits:
        """Return the limits of a new run of this method; raise SceneError where one is invalid."""
        return checked_limits(self.scene, self.particles, self.error, self.seconds, self.batches, method)


def checked_limits(scene, particles, error, seconds, batches, method=ANALOG) -> Limits:
    """Return the limits of a run from the arguments of `simulate`.

    Raise SceneError where none is given or one is invalid.
    """
    error = {} if error is None else error
    if not isinstance(error, Mapping):
        raise SceneError(f"simulate: error must be like {{'meter.flux_in': 1e-3}}, got {error!r}")
    if particles is None and not error and seconds is None:
        raise SceneError(
            "simulate: no limit given; pass particles=1_000_000, error={'meter.flux_in': 1e-3} or seconds=10"
        )
    if particles is not None:
        particles = checked_integer("particles", particles, 1, MAX_PARTICLES * 100)
    if seconds is not None and not (_is_number(seconds) and 0 < seconds < math.inf):
        raise SceneError(f"simulate: seconds must be positive and finite, got {seconds!r}")
    is_free = batches is None
    if is_free:
        batches = _usual_batches(method, error)
    batches = checked_integer("batches", batches, 2, MAX_BATCHES)
    if error and batches < MIN_BATCHES_FOR_ERROR:
        raise SceneError(
            f"simulate: batches must be at least {MIN_BATCHES_FOR_ERROR} with error=..., got {batches};"
            " with fewer, the run would end when the error is underestimated by chance"
        )
    for name, target in error.items():
        _check_quantity(scene, name)
        if not (_is_number(target) and 0 < target < 1):
            raise SceneError(f"simulate: error of {name!r} must be relative, within (0, 1), got {target!r}")
    return Limits(particles, dict(error), seconds, batches, is_free)


def _usual_batches(method: Method, error: Mapping[str, float]) -> int:
    """Return the default number of batches; with an error target, enough to know the error well."""
    if not error:
        return method.default_batches
    return USUAL_BATCHES_FOR_ERROR if method.sampling == "random" else MIN_BATCHES_FOR_ERROR


def _check_quantity(scene: Scene, name: str) -> None:
    """Refuse a name "detector.quantity" that does not exist, or lacks moments, directions or a clock."""
    detector, _, quantity = str(name).partition(".")
    names = [d.name for d in scene.detectors]
    if detector in names and not quantity:
        raise SceneError(
            f"simulate: error must name a quantity of {detector!r}, such as '{detector}.flux_in'"
        )
    if detector not in names:
        raise SceneError(f"simulate: error names no detector {detector!r}; {name_hint(detector, names)}")
    requested = scene.detectors[names.index(detector)]
    if isinstance(requested, Snapshot):
        raise SceneError(
            f"simulate: error names the Snapshot {detector!r}, which is a sample; name a PhaseSpace"
        )
    kind = TALLIES[type(requested)]
    if quantity not in kind.known:
        raise SceneError(f"simulate: error names no quantity {quantity!r}; {name_hint(quantity, kind.known)}")
    lacks = kind.lacks_of(scene, requested)
    for need in getattr(kind, quantity).needs:
        if need in lacks:
            what, cure = lacks[need]
            raise SceneError(f"simulate: error of {name!r} needs {what}; {cure}")


def checked_integer(name: str, value: object, least: int, most: int) -> int:
    """Return the value as an int within [least, most]; floats such as 1e6 are accepted. Raise SceneError."""
    is_whole = _is_number(value) and math.isfinite(value) and value == int(value)
    if not is_whole or not least <= value <= most:
        raise SceneError(f"simulate: {name} must be a whole number from {least} to {most}, got {value!r}")
    return int(value)


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(
        value, (bool, np.bool_)
    )


def checked_part(part: object, limits: Limits) -> tuple[int, int]:
    """Return (k, n), the k-th of n parts of a run; (1, 1) for the whole run. Raise SceneError."""
    if part is None:
        return 1, 1
    is_pair = isinstance(part, tuple | list) and len(part) == 2
    if not is_pair or not all(_is_number(number) and number == number // 1 for number in part):
        raise SceneError(f"simulate: part must be (k, n), the k-th of n parts, such as (1, 4), got {part!r}")
    one, of = map(int, part)
    if not 1 <= one <= of:
        cure = f"; parts count from 1: part=({one + 1}, {of})" if one == 0 < of else ""
        raise SceneError(f"simulate: part must be (k, n) with k from 1 to n, got {part!r}{cure}")
    if of > 1 and limits.is_open:
        raise SceneError(
            f"simulate: part needs a run limited by particles alone, got {part!r}; omit error and seconds"
        )
    return one, of


def checked_threads(threads: object) -> int:
    """Return the number of threads; None means one per core available to this process. Raise SceneError."""
    if threads is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return checked_integer("threads", threads, 1, 1024)


def coerce_tracking(scene: Scene, tracking: Tracking | str | None) -> Tracking | None:
    """Return the tracking as a Tracking, or None for the default of the scene."""
    given = tracking
    if isinstance(tracking, str) and tracking in ("analog", "weighted"):
        tracking = Tracking(absorption=tracking)
    if tracking is None or isinstance(tracking, Tracking):
        if tracking is not None and tracking.absorption == "weighted" and scene.duration is not None:
            cure = "leave it out" if isinstance(given, str) else "write Tracking(absorption='analog', ...)"
            raise SceneError(
                f"simulate: tracking must be analog in a scene with a duration, got {short_repr(given)};"
                f" {cure}"
            )
        return tracking
    must = "tracking must be 'analog', 'weighted' or a Tracking"
    raise SceneError(f"simulate: {must}, got {short_repr(tracking)}; {_tracking_cure(tracking)}")


def _tracking_cure(tracking: object) -> str:
    """Suggest a valid tracking for an invalid one."""
    if isinstance(tracking, str):
        if tracking in ("roulette", "forced", "splitting"):
            return f"write tracking=Tracking({tracking}=...)"
        meant = name_hint(tracking, ("analog", "weighted"))
        if meant.startswith("did you mean"):
            return meant
    return "leave it out for the default of the scene"


@dataclass(frozen=True)
class Settings:
    """Settings that determine every batch of a run, resolved from the arguments of `simulate`.

    tracking: as passed by the user, None for the default of the scene; choice: how the method was chosen,
    None where it was given.
    """

    scene: Scene
    method: Method
    limits: Limits
    seed: int = 0
    tracking: Tracking | None = None
    choice: Choice | None = None
