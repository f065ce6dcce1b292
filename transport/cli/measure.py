"""Commands that measure: cost of accuracy, passes and effects of a scene, speed of the engine."""

from pathlib import Path
from typing import Annotated

import typer

from transport.analysis.cost import DEFAULT_SECONDS
from transport.cli.console import print_json, print_rich
from transport.cli.costs import costs_of_case, draw_costs
from transport.cli.effects.passes import effects_of, effects_record, measure_passes
from transport.cli.effects.report import print_base_prices, print_cold_starts, print_effects, record_of_scene
from transport.cli.effects.treatment import experiment_treatment
from transport.cli.options import Json, Seed, Set, Sim, named_values, number
from transport.cli.printout import print_costs, print_pictures
from transport.cli.run import checked_experiment
from transport.validation import SceneError
from transport.verification.experiment import cases_of, experiment, scene_of


def cost(
    sim: Sim,
    set_: Set = None,
    quantity: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Quantity [default: the first one with an exact value]"),
    ] = None,
    seconds: Annotated[
        str, typer.Option(metavar="S", help="CPU time of all estimators together, without compilation")
    ] = f"{DEFAULT_SECONDS:g}",
    seed: Seed = 0,
    threads: Annotated[int, typer.Option(help="Number of threads per run")] = 1,
    out: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Folder of the diagram [default: out]")
    ] = None,
    no_picture: Annotated[bool, typer.Option("--no-picture", help="Draw no diagram")] = False,
    json: Json = False,
) -> None:
    """Measure the error of every estimator against CPU time.

    \b
    Examples:
      transport cost cost_disks
      transport cost lambert_disk --set distance=20 --quantity irradiance
      transport cost mine.py --seconds 5 --no-picture --json
    """
    module, settings = checked_experiment(experiment(sim)), named_values(set_ or ())
    costs = costs_of_case(module, settings, quantity, number("--seconds", seconds), seed, threads)
    if json:
        print_json(costs.record)
    else:
        print_costs(costs)
    if not no_picture and (not json or out is not None):
        print_pictures(*draw_costs(costs, Path("out") if out is None else out), quiet=json)


def effects(
    sim: Sim,
    set_: Set = None,
    cold: Annotated[
        bool,
        typer.Option("--cold", help="Also time compilation in a new process with an empty cache"),
    ] = False,
    quick: Annotated[bool, typer.Option("--quick", help="Do not price effects that the scene lacks")] = False,
    json: Json = False,
) -> None:
    """List the passes of an experiment and the cost of each effect.

    \b
    Examples:
      transport effects diffuse_box
      transport effects slab --set tau=20 --quick
      transport effects mine.py --cold --json
    """
    module, settings = checked_experiment(experiment(sim)), named_values(set_ or ())
    found = {}
    for parameters in cases_of(module, settings):
        scene = experiment_treatment(module, scene_of(module, parameters, settings))
        scene_effects = effects_of(scene)
        found.setdefault((scene_effects.births, scene_effects.steps), (scene_effects, scene, []))[2].append(
            parameters
        )
    if json:
        costs = [measure_passes(scene) for _, scene, _ in found.values()]
        scenes = [
            {"cases": cases} | record_of_scene(scene, ns, cold, more=kind == 0 and not quick)
            for kind, ((_, scene, cases), ns) in enumerate(zip(found.values(), costs, strict=True))
        ]
        scene_effects = [scene_effects for scene_effects, *_ in found.values()]
        print_json(effects_record(list(zip(scene_effects, costs, strict=True))) | {"scenes": scenes})
        return
    for kind, (scene_effects, scene, cases) in enumerate(found.values()):
        if len(found) > 1:
            print_rich(
                "; ".join(", ".join(f"{name}={value}" for name, value in case.items()) for case in cases),
                style="bold cyan",
            )
        print_effects(scene_effects, scene, cold, more=kind == 0 and not quick)


def bench(
    repeats: Annotated[int, typer.Option(help="Number of timings per median, at least 5")] = 5,
    quick: Annotated[bool, typer.Option("--quick", help="Use fewer particles per timing")] = False,
    long: Annotated[
        bool, typer.Option("--long", help="Measure peak memory with 1e9 particles instead of 1e7")
    ] = False,
    effects: Annotated[
        bool, typer.Option("--effects", help="Only price each effect, added to a base room")
    ] = False,
    cold: Annotated[
        bool, typer.Option("--cold", help="Only time compilation of each kind of scene with an empty cache")
    ] = False,
    json: Json = False,
) -> None:
    """Measure the engine against a plain kernel, and price effects.

    \b
    Examples:
      transport bench
      transport bench --quick --json
      transport bench --effects --repeats 7
      transport bench --cold
    """
    from transport.cli.bench.benchmarks import bench as measure
    from transport.cli.bench.benchmarks import render

    if (effects or cold) and (quick or long):
        raise SceneError("bench: --effects and --cold have one form; leave out --quick and --long")
    if effects and cold and json:
        raise SceneError("bench: --json prints one table only; leave out --effects or --cold")
    if repeats < 5:
        raise SceneError(f"bench: repeats must be at least 5 for a median, got {repeats}")
    if effects or cold:
        if effects:
            print_base_prices(repeats, json)
        if cold:
            print_cold_starts(json)
        return
    rows = measure(repeats=repeats, quick=quick, long=long)
    print_json(rows) if json else print_rich(render(rows), "medians of one run, on one thread unless stated")
