"""Additions: functions that add one effect to a scene or to the settings of its run, for the price list."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from transport.command.treatment import Treatment
from transport.compile import compile_scene
from transport.detectors import Detector
from transport.materials import Surface
from transport.media import Medium
from transport.scene import Scene
from transport.shapes import Box

Change = Callable[[Treatment], Treatment]


@dataclass(frozen=True)
class Addition:
    """An effect that can be added to a treatment.

    `to(treatment)` returns the treatment with the effect, or an equal treatment if the effect is present
    already or does not apply.  `over` names the addition that this one needs and that its price is relative
    to; None: the unchanged scene.
    """

    name: str
    to: Change
    over: str | None = None


def in_scene(change: Callable[[Scene], Scene]) -> Change:
    """Return a change of the treatment that applies `change` to its scene."""
    return lambda treatment: replace(treatment, scene=change(treatment.scene))


def meters_ask(**asked: object) -> Change:
    """Set these fields on every Detector, unless a detector has one of them already."""

    def change(scene: Scene) -> Scene:
        if any(getattr(meter, name) not in (None, False) for meter in scene.meters for name in asked):
            return scene
        return replace(scene, detectors=[_asking(one, asked) for one in scene.detectors])

    return in_scene(change)


def looks(make: Callable[[Scene], object]) -> Change:
    """Add the detector `make(scene)`, unless the scene has one of its type."""

    def change(scene: Scene) -> Scene:
        more = make(scene)
        if any(isinstance(one, type(more)) for one in scene.detectors):
            return scene
        return replace(scene, detectors=(*scene.detectors, more))

    return in_scene(change)


def stands(*surfaces: Surface) -> Change:
    """Add surfaces to the scene."""
    return in_scene(lambda scene: replace(scene, surfaces=(*scene.surfaces, *surfaces)))


def filled(**coefficients: float) -> Change:
    """Fill a vacuum scene with a medium; coefficients are in units of 1 / (half the scene's size).

    A scene that has media stays unchanged.
    """

    def change(scene: Scene) -> Scene:
        plan = compile_scene(scene)
        if plan.has_media:
            return scene
        reach = 0.5 * plan.space.size
        return replace(scene, medium=Medium(**{name: value / reach for name, value in coefficients.items()}))

    return in_scene(change)


def medium_has(**changes: object) -> Change:
    """Change fields of the ambient medium, if there is one."""

    def change(scene: Scene) -> Scene:
        if not isinstance(scene.medium, Medium):
            return scene
        return replace(scene, medium=replace(scene.medium, **changes))

    return in_scene(change)


def estimated(**changes: str) -> Change:
    """Change the estimator or the sampling."""
    return lambda treatment: replace(treatment, method=replace(treatment.method, **changes))


def tracked(**choices: object) -> Change:
    """Change the tracking through media, if there are any."""

    def change(treatment: Treatment) -> Treatment:
        plan = compile_scene(treatment.scene, treatment.tracking)
        if not plan.has_media:
            return treatment
        return replace(treatment, tracking=replace(plan.tracking, **choices))

    return change


def box_within(scene: Scene) -> Box:
    """Return a cube of a quarter of the scene's size, at the mean centre of its shapes."""
    shapes = [scene.shape_of(one) for one in (*scene.sources, *scene.meters)]
    shapes += [surface.shape for surface in scene.surfaces]
    middle = np.mean([shape.middle for shape in shapes], axis=0)
    return Box(center=tuple(map(float, middle)), size=0.25 * compile_scene(scene).space.size)


def _asking(one: object, asked: dict[str, object]) -> object:
    return replace(one, **asked) if isinstance(one, Detector) else one
