"""Passes of a scene in order, fields of its bundles, and absent passes and fields, without a run."""

import importlib
import math
import pkgutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from transport.cli.effects.treatment import Treatment, treatment_of
from transport.run.progress import open_progress
from transport.scene.scene import Scene


@dataclass(frozen=True)
class Effects:
    """Passes and fields of a scene's program.

    `births` holds the pass names of a birth at each emitter (a source, or a face of a Box), `steps` those of
    a step, both in order.
    """

    births: tuple[tuple[str, ...], ...]
    steps: tuple[str, ...]
    fields: Mapping[str, str]  # name -> "carried" with the particle, or "scratch" within one step

    @property
    def passes(self) -> tuple[str, ...]:
        """Names of the passes, each once, in order of first use."""
        return tuple(dict.fromkeys(name for part in (*self.births, self.steps) for name in part))

    @cached_property
    def absent(self) -> dict[str, str]:
        """Passes and fields of the engine that the scene does not use: name -> "pass" or "field"."""
        from transport.engine.registry import LANE_FIELDS

        passes = {name: "pass" for name in known_passes() if name not in self.passes}
        return passes | {name: "field" for name in LANE_FIELDS if name not in self.fields}


def effects_of(scene: Scene | Treatment) -> Effects:
    """Return the effects of a scene without compiling or running anything."""
    from transport.engine.registry import LANE_FIELDS

    program = treatment_of(scene).program
    carried = program.carried
    touched = {name for lane_pass in program.passes for name in lane_pass.fields}
    fields = {
        name: "carried" if name in carried else "scratch"
        for name in LANE_FIELDS
        if name in touched | set(carried)
    }
    births = tuple(tuple(lane_pass.name for lane_pass, _ in part) for part in program.births)
    steps = (*program.steps, *program.bank_steps, *program.shadow_steps)
    return Effects(births, tuple(lane_pass.name for lane_pass, _ in steps), fields)


def known_passes() -> list[str]:
    """Return the names of all passes of the engine."""
    from transport.engine import passes
    from transport.engine.registry import Pass

    names = {}
    for module in pkgutil.iter_modules(passes.__path__):
        family = importlib.import_module(f"transport.engine.passes.{module.name}")
        names |= {value.name: None for value in vars(family).values() if isinstance(value, Pass)}
    return list(names)


def measure_passes(scene: Scene | Treatment) -> dict[str, float]:
    """Measure the ns per lane of each pass, nan where no lane reached it; shows a progress bar."""
    from transport.cli.effects.costs import pass_costs
    from transport.engine.driver import compile_program

    with open_progress(None) as bar:
        compile_program(treatment_of(scene).program, bar.compiling)
    return pass_costs(scene)


def effects_record(found: Sequence[tuple[Effects, Mapping[str, float]]]) -> dict[str, object]:
    """Return {passes, fields, absent, ns} for JSON: the union over the scenes, and what none of them uses.

    `found` holds the effects of each scene with the costs of its passes.  The ns of a pass come from the
    first scene in which a lane reached it.
    """
    passes, fields, ns = {}, {}, {}
    for effects, costs in found:
        passes |= dict.fromkeys(effects.passes)
        fields |= {name: role for name, role in effects.fields.items() if fields.get(name) != "carried"}
        ns |= {name: cost for name, cost in costs.items() if math.isnan(ns.get(name, math.nan))}
    absent = {
        name: kind for name, kind in found[0][0].absent.items() if name not in passes and name not in fields
    }
    return {
        "passes": list(passes),
        "fields": fields,
        "absent": absent,
        "ns": {name: ns.get(name) for name in passes},
    }
