"""Compile a scene: each kind of object has one function that lowers it to tables. No Numba here."""

from functools import lru_cache

from transport.compile.adjoint import adjoint_scene, fill_adjoint
from transport.compile.detectors import lower_detectors
from transport.compile.guides import guide_births
from transport.compile.media import default_tracking, lower_media
from transport.compile.methods import ANALOG, Method
from transport.compile.next_event import lower_next_event
from transport.compile.phase_space import lower_phase_spaces, lower_snapshots
from transport.compile.plan import Plan
from transport.compile.points import lower_points
from transport.compile.sources import lower_sources
from transport.compile.space import make_space
from transport.compile.surfaces import check_thin_shapes, lower_surfaces
from transport.compile.volumes import lower_volumes
from transport.scene.scene import Scene
from transport.scene.sheets import scene_sheets
from transport.scene.tracking import Tracking
from transport.validation import SceneError


@lru_cache(maxsize=32)
def compile_scene(scene: Scene, tracking: Tracking | None = None, method: Method = ANALOG) -> Plan:
    """Return the plan of a scene.

    tracking: how absorption is treated, None for the default of the scene; method: the estimator and the
    sampling.
    Raise SceneError where the scene, or for estimator "backward" the adjoint scene, cannot be simulated.
    """
    if method.estimator != "backward":
        plan = _make_plan(scene, tracking, method)
    else:
        turned, lamps = adjoint_scene(scene)
        try:
            plan = _make_plan(turned, tracking, method)
        except SceneError as refusal:
            turning = "simulate: estimator 'backward' exchanges detectors and sources"
            raise SceneError(f"{turning}, and the exchanged scene is invalid: {refusal}") from refusal
        fill_adjoint(plan, scene, lamps)
    guide_births(plan)
    plan.freeze()
    return plan


def _make_plan(scene: Scene, tracking: Tracking | None, method: Method) -> Plan:
    """Return the plan of a scene as it stands, without exchanging sources and detectors."""
    sheets, space = scene_sheets(scene), make_space(scene)
    check_thin_shapes(sheets, space)
    plan = Plan(scene, space, tracking or default_tracking(scene), method)
    # What follows depends on the media and the sources, and surfaces on the layers of detectors.
    lower_media(plan)
    lower_sources(plan, sheets)
    layer_bits = lower_detectors(plan, sheets)
    lower_surfaces(plan, sheets, layer_bits)
    lower_next_event(plan, sheets)
    # The rows of sums of other detectors follow those of detectors on surfaces.
    lower_phase_spaces(plan)
    lower_snapshots(plan)
    lower_volumes(plan)
    lower_points(plan)
    return plan
