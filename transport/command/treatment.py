"""A treatment: a scene and the way in which it is run, as `simulate` would settle it."""

from dataclasses import dataclass
from types import ModuleType

from transport.compile import compile_scene
from transport.compile.plan import Plan
from transport.estimators.aimed import aimed_scene
from transport.estimators.methods import ANALOG, AUTO, Method, checked_method
from transport.experiment import ways_of
from transport.scene import Scene
from transport.simulate import checked_tracking
from transport.tracking import Tracking


@dataclass(frozen=True)
class Treatment:
    """tracking: None for what suits the scene."""

    scene: Scene
    tracking: Tracking | None = None
    method: Method = ANALOG

    def checked(self) -> "Treatment":
        """The same.  Raises SceneError where the scene does not allow it."""
        checked_method(self.scene, self.method.estimator, self.method.sampling)
        checked_tracking(self.scene, self.tracking)
        return self

    @property
    def plan(self) -> Plan:
        """What it compiles to."""
        scene = aimed_scene(self.scene) if self.method.estimator == "aimed" else self.scene
        return compile_scene(scene, self.tracking, self.method)


def treatment_of(scene: Scene | Treatment, **ways: object) -> Treatment:
    """How a scene is run: ways as of `simulate`; where "auto" would choose, or nothing is said, the scene's own way."""
    if isinstance(scene, Treatment):
        return scene
    estimator = ways.get("estimator")
    method = checked_method(scene, None if estimator == AUTO else estimator, ways.get("sampling") or "random")
    return Treatment(scene, checked_tracking(scene, ways.get("tracking")), method)


def treatment_by(module: ModuleType, scene: Scene) -> Treatment:
    """How an experiment runs a scene of its own, where the user does not say."""
    return treatment_of(scene, **ways_of(module))
