"""Ways to estimate the same numbers: which events score at a detector, and from which samples histories are made.

Estimators
  "analog"    crossings are counted as they come.
  "aimed"     every source emits only towards the detector, with the exact weight: direct light alone.
  "expected"  each emission, diffuse reflection and collision scores what it would send to each detector (next-event
              estimation); what mirrors and lenses send is counted as it comes.
  "backward"  histories start at the detectors and score the radiance of the sources that they come to; "random" alone.
  "auto"      a short run of each, then the cheapest: the default with `error` or `seconds` ("analog" is that of `particles` alone).
Samplings
  "random"      independent histories (Philox).
  "stratified"  the numbers of every draw are stratified among the histories of a batch, each draw by itself.
  "sobol"       the same, and the numbers of a birth are one Owen-scrambled Sobol point, one number a dimension; scrambled
                anew in each batch.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING

from transport.validation import SceneError, suggestion

if TYPE_CHECKING:
    from transport.scene import Scene

ESTIMATORS = (
    "analog",
    "aimed",
    "expected",
    "backward",
)  # the simplest first; each file transport/<name>.py says why_not(scene)
PARTIAL = (
    "aimed",
    "backward",
)  # know only what arrives at detectors: the ledger is not that of all that is emitted
SAMPLINGS = ("random", "stratified", "sobol")
AUTO = "auto"  # takes the cheapest of them (choosing.py)
BATCHES = 32  # of a run, where nothing is said
NETS = 8  # of a run whose points know of one another: few and large ones, as their accuracy grows faster than their number


@dataclass(frozen=True)
class Method:
    """One way to estimate, as simulate(estimator=..., sampling=...) takes it."""

    estimator: str = "analog"
    sampling: str = "random"

    @property
    def usual_batches(self) -> int:
        """Independent replicates of a run, where their number is not said."""
        return BATCHES if self.sampling == "random" else NETS

    @property
    def title(self) -> str:
        """What a report calls it."""
        return self.estimator if self.sampling == "random" else f"{self.estimator}, {self.sampling}"


ANALOG = Method()


def checked_method(scene: Scene, estimator: str | None, sampling: str) -> Method:
    """The method of a run.  Raises SceneError for what there is not, or what the scene does not allow."""
    if estimator is None:
        estimator = "backward" if scene.instruments else "analog"
    choices = (*ESTIMATORS, AUTO)
    for what, value, known in (("estimator", estimator, choices), ("sampling", sampling, SAMPLINGS)):
        if value not in known:
            names = ", ".join(map(repr, known))
            raise SceneError(
                f"simulate: {what} must be one of {names}, got {value!r}; {suggestion(str(value), known)}"
            )
    if reason := why_not(scene, estimator):
        raise SceneError(f"simulate: estimator {estimator!r} does not go with this scene: {reason}")
    if not _goes(estimator, sampling):
        cure = "leave sampling out"
        raise SceneError(f"simulate: sampling {sampling!r} does not go with estimator {estimator!r}; {cure}")
    return Method(estimator, sampling)


def _goes(estimator: str, sampling: str) -> bool:
    """Histories that start backwards are dealt out among the bins of detectors, which would tear nets of points apart."""
    return estimator != "backward" or sampling == "random"


def why_not(scene: Scene, estimator: str) -> str | None:
    """Why a scene cannot be estimated so, as the end of a message; None where it can."""
    if scene.instruments and estimator != "backward":
        seen = scene.instruments[0]
        title = f"{type(seen).__name__} {seen.name!r}"
        return f"only backward histories come to {title}; write estimator='backward'"
    return (
        None if estimator == "analog" else import_module(f"transport.estimators.{estimator}").why_not(scene)
    )


def methods_for(scene: Scene) -> list[Method]:
    """All the ways that a scene allows, the simplest first."""
    allowed = [estimator for estimator in ESTIMATORS if why_not(scene, estimator) is None]
    return [Method(one, sampling) for one in allowed for sampling in SAMPLINGS if _goes(one, sampling)]
