"""What a scene calls for, told before any run: its passes in order, the fields of its bundles, and what is absent."""

import importlib
import math
import pkgutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from transport.command.treatment import Treatment, treatment_of
from transport.runs.progress import progress_on
from transport.scene import Scene


@dataclass(frozen=True)
class Effects:
    """Passes of the newborn of each emitter (a source, or a face of a Box), and of every step, by name and in order."""

    births: tuple[tuple[str, ...], ...]
    steps: tuple[str, ...]
    fields: Mapping[str, str]  # name -> "carried" along with the particle, or "scratch" of one step

    @property
    def passes(self) -> tuple[str, ...]:
        """Each pass once, in order of first use."""
        return tuple(dict.fromkeys(name for part in (*self.births, self.steps) for name in part))

    @cached_property
    def absent(self) -> dict[str, str]:
        """name -> "pass" or "field", of all that the engine has and this scene does not use."""
        from transport.engine.passes import LANE_FIELDS

        passes = {name: "pass" for name in known_passes() if name not in self.passes}
        return passes | {name: "field" for name in LANE_FIELDS if name not in self.fields}


def effects_of(scene: Scene | Treatment) -> Effects:
    """The effects of a scene.  Nothing is compiled and nothing is run."""
    from transport.engine.passes import LANE_FIELDS
    from transport.engine.program import program_of

    program = program_of(treatment_of(scene).plan)
    carried = program.carried
    touched = {name for lane_pass in program.passes for name in lane_pass.fields}
    fields = {
        name: "carried" if name in carried else "scratch"
        for name in LANE_FIELDS
        if name in touched | set(carried)
    }
    births = tuple(tuple(lane_pass.name for lane_pass, _ in part) for part in program.births)
    steps = (*program.steps, *program.withdrawal, *program.sight)
    return Effects(births, tuple(lane_pass.name for lane_pass, _ in steps), fields)


def known_passes() -> list[str]:
    """Every pass that the engine has, by name."""
    from transport import engine
    from transport.engine.passes import Pass

    names = {}
    for module in pkgutil.iter_modules(engine.__path__):
        family = importlib.import_module(f"transport.engine.{module.name}")
        names |= {value.name: None for value in vars(family).values() if isinstance(value, Pass)}
    return list(names)


def costs_of(scene: Scene | Treatment) -> dict[str, float]:
    """Nanoseconds a lane of each pass, measured now, nan for one that no lane reached; a bar names what is compiled."""
    from transport.command.pass_costs import pass_costs
    from transport.engine.driver import machine_of
    from transport.engine.program import program_of

    with progress_on(None) as bar:
        machine_of(program_of(treatment_of(scene).plan), bar.compiling)
    return pass_costs(scene)


def record_of_effects(found: Sequence[tuple[Effects, Mapping[str, float]]]) -> dict[str, object]:
    """{passes, fields, absent, ns} for machines: all that the scenes use between them, and what none of them does.

    found: the effects of each scene with the costs of its passes; the first scene in which one is reached tells its ns.
    """
    passes, fields, ns = {}, {}, {}
    for told, costs in found:
        passes |= dict.fromkeys(told.passes)
        fields |= {name: role for name, role in told.fields.items() if fields.get(name) != "carried"}
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
