"""What a scene is run by: its plan, the program of passes that it calls for, and these compiled, wired and kept."""

from __future__ import annotations

from functools import lru_cache

from transport.compile import compile_scene
from transport.compile.plan import Plan
from transport.estimators.aimed import aimed_scene
from transport.estimators.methods import Method
from transport.runs.progress import Progress
from transport.scene import Scene
from transport.tracking import Tracking


def plan_for(scene: Scene, tracking: Tracking | None, method: Method) -> Plan:
    """What is read off the scene; nothing of the engine is needed for it."""
    scene = aimed_scene(scene) if method.estimator == "aimed" else scene
    return compile_scene(scene, tracking, method)


@lru_cache(maxsize=32)
def program_for(scene: Scene, tracking: Tracking | None, method: Method):
    """The passes that the plan calls for, each with its table."""
    from transport.engine.program import program_of

    return program_of(plan_for(scene, tracking, method))


def machine_for(scene: Scene, tracking: Tracking | None, method: Method, bar: Progress):
    """Passes compiled or loaded, and wired; kept for scenes that are run again."""
    from transport.engine.driver import machine_of

    program = program_for(scene, tracking, method)
    if program.machine is None:
        program.machine = machine_of(program, bar.compiling)
    return program.machine
