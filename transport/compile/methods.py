"""Methods: which events score at a detector (estimator), and how random numbers are drawn (sampling).

Estimators
  "analog"    score crossings.
  "aimed"     every source emits only towards the detector, with the exact weight: direct light only.
  "expected"  next-event estimation: each emission, diffuse reflection and collision scores its expected
              contribution to each detector; light from mirrors and lenses scores on crossing.
  "backward"  histories start at the detectors and score the radiance of sources they reach; "random" only.
  "auto"      short pilot runs of each, then the cheapest: default with `error` or `seconds`
              ("analog" with `particles` alone).
Samplings
  "random"      independent histories (Philox).
  "stratified"  the numbers of each draw are stratified over the histories of a batch, each draw separately.
  "sobol"       as "stratified", and the numbers of a birth are one Owen-scrambled Sobol point, one dimension
                per number; each batch has its own scrambling.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING

from transport.validation import SceneError, name_hint

if TYPE_CHECKING:
    from transport.scene.scene import Scene


ESTIMATORS = (
    "analog",
    "aimed",
    "expected",
    "backward",
)  # the simplest first; the module of each defines refusal(scene)
ARRIVALS_ONLY = (
    "aimed",
    "backward",
)  # estimate only light that arrives at detectors: no energy balance of all emitted light
SAMPLINGS = ("random", "stratified", "sobol")
AUTO = "auto"  # choose the cheapest of them
DEFAULT_BATCHES = 32  # default number of batches
# Default number of batches of "stratified" and "sobol" runs: few and large, because the error falls faster
# than 1/sqrt(N) with the size of a batch.
DEFAULT_QMC_BATCHES = 8


@dataclass(frozen=True)
class Method:
    """One method to estimate: the arguments estimator and sampling of `simulate`."""

    estimator: str = "analog"
    sampling: str = "random"

    @property
    def default_batches(self) -> int:
        """Default number of batches."""
        return DEFAULT_BATCHES if self.sampling == "random" else DEFAULT_QMC_BATCHES

    @property
    def title(self) -> str:
        """Name in reports."""
        return self.estimator if self.sampling == "random" else f"{self.estimator}, {self.sampling}"


ANALOG = Method()


def coerce_method(scene: Scene, estimator: str | None, sampling: str) -> Method:
    """Return the method of a run; SceneError if it is unknown or the scene does not allow it."""
    if estimator is None:
        estimator = "backward" if scene.instruments else "analog"
    choices = (*ESTIMATORS, AUTO)
    for what, value, known in (("estimator", estimator, choices), ("sampling", sampling, SAMPLINGS)):
        if value not in known:
            names = ", ".join(map(repr, known))
            raise SceneError(
                f"simulate: {what} must be one of {names}, got {value!r}; {name_hint(str(value), known)}"
            )
    if reason := refusal(scene, estimator):
        raise SceneError(f"simulate: estimator {estimator!r} does not go with this scene: {reason}")
    if not _are_compatible(estimator, sampling):
        cure = "leave sampling out"
        raise SceneError(f"simulate: sampling {sampling!r} does not go with estimator {estimator!r}; {cure}")
    return Method(estimator, sampling)


def _are_compatible(estimator: str, sampling: str) -> bool:
    """Return whether they combine: backward histories are spread over bins, which breaks up point nets."""
    return estimator != "backward" or sampling == "random"


def refusal(scene: Scene, estimator: str) -> str | None:
    """Reason why a scene does not allow an estimator, as the end of a message; None if it does."""
    if scene.instruments and estimator != "backward":
        seen = scene.instruments[0]
        title = f"{type(seen).__name__} {seen.name!r}"
        return f"only backward histories reach {title}; write estimator='backward'"
    if estimator == "analog":
        return None
    return import_module(f"transport.compile.method_{estimator}").refusal(scene)


def methods_for(scene: Scene) -> list[Method]:
    """All methods that a scene allows, the simplest first."""
    allowed = [estimator for estimator in ESTIMATORS if refusal(scene, estimator) is None]
    return [
        Method(one, sampling) for one in allowed for sampling in SAMPLINGS if _are_compatible(one, sampling)
    ]
