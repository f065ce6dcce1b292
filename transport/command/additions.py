"""An effect that can be switched on: what makes of a scene, and the way it is run, the same with one effect more."""

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
    """One effect more.

    to: the treatment with it; the same treatment where it is there already or has nothing to do;  over: the name of the
    addition that it needs, and over which its price is told, None for the scene as it is.
    """

    name: str
    to: Change
    over: str | None = None


def in_scene(change: Callable[[Scene], Scene]) -> Change:
    """The scene is another one."""
    return lambda treatment: replace(treatment, scene=change(treatment.scene))


def meters_ask(**asked: object) -> Change:
    """Every detector at a place asks for it, if none does yet."""

    def change(scene: Scene) -> Scene:
        if any(getattr(meter, name) not in (None, False) for meter in scene.meters for name in asked):
            return scene
        return replace(scene, detectors=[_asking(one, asked) for one in scene.detectors])

    return in_scene(change)


def looks(make: Callable[[Scene], object]) -> Change:
    """One detector more, if there is none of its kind."""

    def change(scene: Scene) -> Scene:
        more = make(scene)
        if any(isinstance(one, type(more)) for one in scene.detectors):
            return scene
        return replace(scene, detectors=(*scene.detectors, more))

    return in_scene(change)


def stands(*surfaces: Surface) -> Change:
    """Things more, where the scene has room for them."""
    return in_scene(lambda scene: replace(scene, surfaces=(*scene.surfaces, *surfaces)))


def filled(**coefficients: float) -> Change:
    """Vacuum filled with a medium, its coefficients in units of one over half the scene's size; nothing where media are."""

    def change(scene: Scene) -> Scene:
        plan = compile_scene(scene)
        if plan.has_media:
            return scene
        reach = 0.5 * plan.space.size
        return replace(scene, medium=Medium(**{name: value / reach for name, value in coefficients.items()}))

    return in_scene(change)


def medium_has(**changes: object) -> Change:
    """The medium all around is another one, if there is one."""

    def change(scene: Scene) -> Scene:
        if not isinstance(scene.medium, Medium):
            return scene
        return replace(scene, medium=replace(scene.medium, **changes))

    return in_scene(change)


def estimated(**changes: str) -> Change:
    """By another estimator or sampling."""
    return lambda treatment: replace(treatment, method=replace(treatment.method, **changes))


def tracked(**choices: object) -> Change:
    """Histories go otherwise through media, if there are any."""

    def change(treatment: Treatment) -> Treatment:
        plan = compile_scene(treatment.scene, treatment.tracking)
        if not plan.has_media:
            return treatment
        return replace(treatment, tracking=replace(plan.tracking, **choices))

    return change


def box_within(scene: Scene) -> Box:
    """A box about the middle of what is in the scene."""
    shapes = [scene.shape_of(one) for one in (*scene.sources, *scene.meters)]
    shapes += [surface.shape for surface in scene.surfaces]
    middle = np.mean([shape.middle for shape in shapes], axis=0)
    return Box(center=tuple(map(float, middle)), size=0.25 * compile_scene(scene).space.size)


def _asking(one: object, asked: dict[str, object]) -> object:
    return replace(one, **asked) if isinstance(one, Detector) else one
