"""A treatment: a scene with the tracking, estimator and sampling of its run."""

from dataclasses import dataclass
from types import ModuleType

from transport.compile.methods import ANALOG, AUTO, Method, coerce_method
from transport.compile.plan import Plan
from transport.run.programs import plan_for
from transport.run.settings import coerce_tracking
from transport.scene.scene import Scene
from transport.scene.tracking import Tracking
from transport.verification.experiment import run_settings_of


@dataclass(frozen=True)
class Treatment:
    """A scene and the settings of its run; `tracking` None selects the default of the scene."""

    scene: Scene
    tracking: Tracking | None = None
    method: Method = ANALOG

    def checked(self) -> "Treatment":
        """Return this treatment.  Raises SceneError if the scene does not allow its settings."""
        coerce_method(self.scene, self.method.estimator, self.method.sampling)
        coerce_tracking(self.scene, self.tracking)
        return self

    @property
    def plan(self) -> Plan:
        """The compiled plan."""
        return plan_for(self.scene, self.tracking, self.method)

    @property
    def program(self):
        """The program of its passes, not compiled."""
        from transport.engine.program import build_program

        return build_program(self.plan)


def treatment_of(scene: Scene | Treatment, **ways: object) -> Treatment:
    """Return the treatment of a scene with these arguments of `simulate`; "auto" and None: defaults."""
    if isinstance(scene, Treatment):
        return scene
    estimator = ways.get("estimator")
    method = coerce_method(scene, None if estimator == AUTO else estimator, ways.get("sampling") or "random")
    return Treatment(scene, coerce_tracking(scene, ways.get("tracking")), method)


def experiment_treatment(module: ModuleType, scene: Scene) -> Treatment:
    """Return the treatment of a scene with the default settings of its experiment."""
    return treatment_of(scene, **run_settings_of(module))
