"""Ways to estimate the same numbers: which events score at a detector, and from which samples histories are made.

Estimators
  "analog"    crossings are counted as they come.
  "aimed"     every source emits only towards the detector, with the exact weight: direct light alone.
  "expected"  each emission, diffuse reflection and collision scores what it would send to each detector (next-event
              estimation); what mirrors and lenses send is counted as it comes.
  "backward"  histories start at the detectors and score the radiance of the sources that they come to.
Samplings
  "random"      independent histories (Philox).
  "stratified"  the two numbers of every draw are stratified among the histories of a batch.
  "sobol"       Owen-scrambled Sobol points, one uniform a dimension, scrambled anew in each batch.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from transport.validation import SceneError, suggestion

if TYPE_CHECKING:
    from transport.scene import Scene

ESTIMATORS = ("analog",)
SAMPLINGS = ("random",)
BATCHES = 32  # of a run, where nothing is said


@dataclass(frozen=True)
class Method:
    """One way to estimate, as simulate(estimator=..., sampling=...) takes it."""

    estimator: str = "analog"
    sampling: str = "random"

    @property
    def usual_batches(self) -> int:
        """Independent replicates of a run, where their number is not said."""
        return BATCHES

    @property
    def title(self) -> str:
        """What a report calls it."""
        return self.estimator if self.sampling == "random" else f"{self.estimator}, {self.sampling}"


ANALOG = Method()


def checked_method(scene: Scene, estimator: str | None, sampling: str) -> Method:
    """The method of a run.  Raises SceneError for what there is not, or what the scene does not allow."""
    estimator = "analog" if estimator is None else estimator
    for what, value, known in (("estimator", estimator, ESTIMATORS), ("sampling", sampling, SAMPLINGS)):
        if value not in known:
            names = ", ".join(map(repr, known))
            raise SceneError(
                f"simulate: {what} must be one of {names}, got {value!r}; {suggestion(str(value), known)}"
            )
    return Method(estimator, sampling)
