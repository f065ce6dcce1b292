"""`transport effects`: which passes a scene calls for, what each effect costs, and what is absent."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from itertools import groupby
from typing import Annotated

import typer
from rich.table import Table

from transport.analysis.effects import (
    EFFECTS,
    CompileTime,
    EffectCost,
    Effects,
    Footprint,
    PassCost,
    Treatment,
    compile_time_of,
    costs_by_effect,
    effect_of,
    effects_of,
    files_of_passes,
    footprint_of,
    pass_costs,
    run_ns,
)
from transport.cli.options import Json, Set, Sim, named_values
from transport.cli.output import print_json, print_labelled, print_rich, table_of
from transport.cli.run import checked_experiment, experiment_treatment
from transport.run.progress import open_progress
from transport.statistics.notation import duration
from transport.validation import SceneError
from transport.verification.experiment import cases_of, experiment, scene_of


def effects(
    sim: Sim,
    set_: Set = None,
    json: Json = False,
    quick: Annotated[bool, typer.Option("--quick", hidden=True)] = False,
    cold: Annotated[bool, typer.Option("--cold", hidden=True)] = False,
) -> None:
    """List the passes of an experiment and the cost of each effect.

    \b
    Examples:
      transport effects diffuse_box
      transport effects slab --set tau=20
      transport effects mine.py --json
    """
    if cold:
        raise SceneError(
            f"effects: --cold is a benchmark now: python -m tests.bench cold {sim} in a clone; leave it out"
        )
    module, settings = checked_experiment(experiment(sim)), named_values(set_ or ())
    # Cases with the same program are one scene here.
    scenes: dict[tuple, tuple[Effects, Treatment, list]] = {}
    for parameters in cases_of(module, settings):
        scene = experiment_treatment(module, scene_of(module, parameters, settings))
        found = effects_of(scene)
        scenes.setdefault((found.births, found.steps), (found, scene, []))[2].append(parameters)
    if json:
        measured = [measure(scene) | {"cases": cases} for _, scene, cases in scenes.values()]
        costs = (record["costs"] for record in measured)
        kinds = zip((found for found, *_ in scenes.values()), costs, strict=True)
        print_json(effects_record(list(kinds)) | {"scenes": [scene_record(record) for record in measured]})
        return
    for found, scene, cases in scenes.values():
        if len(scenes) > 1:
            titles = (", ".join(f"{name}={value}" for name, value in case.items()) for case in cases)
            print_rich("; ".join(titles), style="bold cyan")
        print_effects(found, scene)


def measure(scene: Treatment) -> dict[str, object]:
    """Compile the scene's program and measure its passes, its effects and a whole run."""
    with open_progress(None) as bar:
        compiled = compile_time_of(scene, bar.compiling)
    costs = pass_costs(scene)
    return {
        "memory": footprint_of(scene.program),
        "compiled": compiled,
        "costs": costs,
        "effects": costs_by_effect(costs, files_of_passes()),
        "run": run_ns(scene),
    }


# ---- The effects as JSON.


def effects_record(found: Sequence[tuple[Effects, Mapping[str, PassCost]]]) -> dict[str, object]:
    """Return {passes, fields, absent, ns} for JSON: the union over the scenes, and what none of them uses.

    `found` holds the effects of each scene with the costs of its passes.  The ns of a pass come from the
    first scene in which a lane reached it.
    """
    passes, fields, ns = {}, {}, {}
    for effects, costs in found:
        passes |= dict.fromkeys(effects.passes)
        fields |= {name: role for name, role in effects.fields.items() if fields.get(name) != "carried"}
        ns |= {n: cost.ns_per_lane for n, cost in costs.items() if math.isnan(ns.get(n, math.nan))}
    absent = {
        name: kind for name, kind in found[0][0].absent.items() if name not in passes and name not in fields
    }
    return {
        "passes": list(passes),
        "fields": fields,
        "absent": absent,
        "ns": {name: ns.get(name) for name in passes},
    }


def scene_record(measured: Mapping[str, object]) -> dict[str, object]:
    """Return {cases, memory, compiled, effects, ns per history} of one scene for JSON."""
    return {
        "cases": measured["cases"],
        "memory": asdict(measured["memory"]),
        "compiled": asdict(measured["compiled"]),
        "effects": [asdict(effect) for effect in measured["effects"]],
        "ns_per_history": {
            "passes": math.fsum(effect.ns for effect in measured["effects"]),
            "run": measured["run"],
        },
    }


# ---- The effects as text.


def print_effects(effects: Effects, scene: Treatment) -> None:
    """Print the used fields and the absent effects of a scene, then measure and print its costs."""
    for role in ("carried", "scratch"):
        names = (name for name, of in effects.fields.items() if of == role)
        print_labelled(role, " ".join(names) or "none")
    print_labelled("absent", absent_line(effects))
    print_labelled("memory", memory_line(footprint_of(scene.program)))
    measured = measure(scene)
    print_labelled("compiled", start_line(measured["compiled"]))
    for births, alike in groupby(enumerate(effects.births), key=lambda pair: pair[1]):
        numbers = [number for number, _ in alike]
        emitters = f"emitter {numbers[0]}" if len(numbers) == 1 else f"emitters {numbers[0]} to {numbers[-1]}"
        print_rich(f"\nbirths at {emitters}", style="bold")
        print_rich(pass_table(births, measured["costs"]))
    print_rich("\nevery step", style="bold")
    print_rich(pass_table(effects.steps, measured["costs"]))
    print_rich("\ncost of each effect", style="bold")
    print_rich(effect_table(measured["effects"]))
    print_labelled("check", check_line(effects, measured))


def absent_line(effects: Effects) -> str:
    """Return the names of the absent effects, and the numbers of absent passes and fields."""
    files, kinds = files_of_passes(), list(effects.absent.values())
    present = {effect_of(name, files) for name in effects.passes}
    absent = [name for name in EFFECTS if name not in present]
    return (
        f"{', '.join(absent)}; in all {kinds.count('pass')} passes and {kinds.count('field')} fields"
        " of the engine (--json lists them)"
    )


def memory_line(footprint: Footprint) -> str:
    """Return a line on the bytes per lane and per bundle."""
    return (
        f"a step touches {footprint.touched} bytes per lane and carries {footprint.carried} with a"
        f" particle; a bundle uses {footprint.used / 1024:.0f} of {footprint.bundle / 1024:.0f} KiB, which"
        f" reserve {footprint.known} bytes per lane for all effects"
    )


def start_line(start: CompileTime) -> str:
    """Return a line on how many passes were compiled and how many loaded."""
    new = start.passes - start.on_disk
    if new == 0:
        return f"nothing: all {start.passes} passes were on disk, loaded in {duration(start.seconds)}"
    return (
        f"{new} of {start.passes} passes in {duration(start.seconds)}; {start.on_disk} were on disk already"
    )


def check_line(effects: Effects, measured: Mapping[str, object]) -> str:
    """Return a line that compares the sum over the passes with the time of a whole run."""
    total = math.fsum(effect.ns for effect in measured["effects"])
    is_whole = set(effects.passes) <= measured["costs"].keys()
    rest = "" if is_whole else "; rays to detectors and split copies (?) are in the run only"
    return f"{total:.3g} ns per history by passes, {measured['run']:.3g} ns in a whole run (CPU time){rest}"


def pass_table(names: Iterable[str], costs: Mapping[str, PassCost]) -> Table:
    """Return a table of passes in order, with ns per lane; ? for passes that are not measured."""
    rows, number = [], 1
    for name, calls in groupby(names):
        times = len(list(calls))
        cost = costs[name].ns_per_lane if name in costs else None
        cell = "?" if cost is None else "not reached" if math.isnan(cost) else f"{cost:.2f}"
        rows.append([str(number), name if times == 1 else f"{name} × {times}", cell])
        number += times
    return table_of([">", "pass", "ns per lane>"], rows)


def effect_table(effects: Sequence[EffectCost]) -> Table:
    """Return a table of ns per history and share of each effect, and whether the scene can do without it."""
    rows = []
    for effect in effects:
        optional = "yes" if effect.can_go else "–"
        rows.append([effect.name, f"{effect.ns:.3g}", f"{100 * effect.share:.0f} %", optional])
    return table_of(["effect~", "ns per history>", "share>", "can be left out>"], rows)
