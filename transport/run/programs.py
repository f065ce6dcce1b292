"""Caches of what a scene is run with: its plan, its program of passes, and the compiled program."""

from __future__ import annotations

from functools import lru_cache

from transport.compile.compiler import compile_scene
from transport.compile.methods import Method, aimed_scene
from transport.compile.plan import Plan
from transport.run.guiding import guided_program
from transport.run.progress import Progress
from transport.run.settings import Settings
from transport.scene.scene import Scene
from transport.scene.tracking import Tracking


def plan_for(scene: Scene, tracking: Tracking | None, method: Method) -> Plan:
    """Return the plan of a scene; needs nothing of the engine."""
    scene = aimed_scene(scene) if method.estimator == "aimed" else scene
    return compile_scene(scene, tracking, method)


@lru_cache(maxsize=32)
def program_for(scene: Scene, tracking: Tracking | None, method: Method, seed: int = 0):
    """Return the program of a plan: its passes, each with its table. seed: of a run that learns a guide."""
    from transport.engine.program import build_program

    plan = plan_for(scene, tracking, method)
    return guided_program(plan, seed) if method.guide else build_program(plan)


def compiled_program_for(settings: Settings, bar: Progress):
    """Return the compiled program of a run, compiled or loaded; cached for scenes that are run again."""
    from transport.engine.driver import compile_program

    seed = settings.seed if settings.method.guide else 0  # the program of other runs does not depend on it
    program = program_for(settings.scene, settings.tracking, settings.method, seed)
    if program.compiled is None:
        program.compiled = compile_program(program, bar.compiling)
    return program.compiled
