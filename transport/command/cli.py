"""The command `transport`: run an experiment, list and verify them all, tell what a scene calls for, benchmark."""

import sys
from pathlib import Path
from typing import Annotated

import typer
from typer.core import TyperGroup

from transport import __version__
from transport.command.console import INTERRUPTED, TEXT_WIDTH, refusals, say, say_json
from transport.command.costs import costs_of_case, draw_costs
from transport.command.effect_report import (
    print_base_prices,
    print_cold_starts,
    print_effects,
    record_of_scene,
)
from transport.command.effects import costs_of, effects_of, record_of_effects
from transport.command.hard_cases import verify_hard
from transport.command.long_proof import verify_long
from transport.command.printout import (
    draw_picture,
    print_costs,
    print_menu,
    print_run,
    tell_picture,
    text_of,
)
from transport.command.running import checked, is_complete, record_of
from transport.command.settings import named_errors, named_values, number, tracking_of, whole_number
from transport.command.treatment import treatment_by
from transport.command.verifying import verify_laws
from transport.estimators.methods import ESTIMATORS, SAMPLINGS
from transport.experiment import cases_of, experiment, experiment_names, outcomes_of, scene_of
from transport.pricing.cost import SECONDS
from transport.validation import SceneError, suggestion


class Commands(TyperGroup):
    """Commands whose refused input ends in one line and status 2."""

    def invoke(self, ctx: typer.Context) -> object:
        with refusals(debug=ctx.params["debug"]):
            return super().invoke(ctx)

    def resolve_command(self, ctx: typer.Context, args: list[str]) -> tuple:
        name = args[0]
        if name not in self.commands and not name.startswith("-"):
            if name.endswith(".py") or name in experiment_names():
                raise SceneError(f"transport: no command {name!r}; did you mean 'transport run {name}'?")
            raise SceneError(f"transport: no command {name!r}; {suggestion(name, self.commands)}")
        return super().resolve_command(ctx, args)


app = typer.Typer(
    cls=Commands,
    help="Monte Carlo transport: photons fly, crossings are counted, radiance comes out with error bars.",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": TEXT_WIDTH},
)

Sim = Annotated[
    str, typer.Argument(metavar="SIM", help="An experiment's name, or the path of a .py file that is one.")
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON for machines.")]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="A parameter of the scene; repeatable."),
]
Particles = Annotated[str | None, typer.Option(metavar="N", help="Histories of each case, such as 1e7.")]
Seed = Annotated[int, typer.Option(help="The same seed gives the same digits.")]
Threads = Annotated[int | None, typer.Option(help="One a core where it is not said.")]


def main() -> None:
    """What the console script `transport` and `python -m transport` call."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")  # an ASCII pipe is no reason to fail
    app()


@app.callback(invoke_without_command=True)
def menu(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show where refused input was refused.")] = False,
) -> None:
    """Print the menu where no command is given."""
    if version:
        say(f"transport {__version__}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        print_menu()


@app.command()
def run(
    sim: Sim,
    set_: Set = None,
    particles: Particles = None,
    error: Annotated[
        list[str] | None,
        typer.Option(
            metavar="meter.flux_in=1e-3", help="Run until this relative standard error; repeatable."
        ),
    ] = None,
    seconds: Annotated[
        str | None, typer.Option(metavar="S", help="Run each case for at most so long.")
    ] = None,
    tracking: Annotated[
        str | None,
        typer.Option(metavar="analog", help="Through media: analog, weighted, forced, or roulette=1e-8."),
    ] = None,
    estimator: Annotated[
        str | None, typer.Option(metavar="auto", help=f"{', '.join(ESTIMATORS)}, or auto: the cheapest.")
    ] = None,
    sampling: Annotated[str | None, typer.Option(metavar="sobol", help=f"{', '.join(SAMPLINGS)}.")] = None,
    seed: Seed = 0,
    threads: Threads = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Where the picture goes; out/ if not said.")
    ] = None,
    no_picture: Annotated[bool, typer.Option("--no-picture", help="Draw none.")] = False,
    json: Json = False,
) -> None:
    """Run an experiment: estimates, exact values, verdict, picture."""
    limits = {
        "particles": whole_number("--particles", particles),
        "error": named_errors(error or ()),
        "seconds": None if seconds is None else number("--seconds", seconds),
        "tracking": tracking_of(tracking),
        "estimator": estimator,
        "sampling": sampling,
        "seed": seed,
        "threads": threads,
    }
    module = checked(experiment(sim))
    pending = outcomes_of(module, named_values(set_ or ()), limits)
    if json:
        outcomes = list(pending)
        say_json(record_of(module, outcomes))
        wants_picture = out is not None
    else:
        outcomes = print_run(module, pending)
        wants_picture = True
    if wants_picture and not no_picture and is_complete(outcomes):
        draw_picture(module, outcomes, Path("out") if out is None else out, quiet=json)
    if not is_complete(outcomes):
        raise typer.Exit(INTERRUPTED)


@app.command("list")
def list_(json: Json = False) -> None:
    """List the experiments with their questions."""
    if json:
        say_json(
            [{"sim": name, "question": text_of(experiment(name), "question")} for name in experiment_names()]
        )
    else:
        print_menu(with_commands=False)


@app.command()
def verify(
    sims: Annotated[
        list[str] | None,
        typer.Argument(metavar="SIM", help="All if not said; with --hard families of hard cases."),
    ] = None,
    particles: Particles = None,
    seed: Seed = 0,
    threads: Threads = None,
    hard: Annotated[
        bool, typer.Option("--hard", help="Instead, hard cases beside what the naive formula gives.")
    ] = False,
    long: Annotated[
        bool,
        typer.Option(
            "--long", help="The proof: 1e8 particles a case, and all hard cases; tells first how long."
        ),
    ] = False,
    json: Json = False,
) -> None:
    """Judge every law against its exact value; status 1 if one fails."""
    if hard and long:
        raise SceneError("verify: --long has the hard cases in it; leave out --hard")
    if hard:
        if particles is not None or seed != 0 or threads is not None:
            raise SceneError(
                "verify --hard: its cases have numbers of their own; leave out --particles, --seed, --threads"
            )
        raise typer.Exit(verify_hard(sims, json))
    limits = {"particles": whole_number("--particles", particles), "seed": seed, "threads": threads}
    raise typer.Exit((verify_long if long else verify_laws)(sims, limits, json))


@app.command()
def cost(
    sim: Sim,
    set_: Set = None,
    quantity: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="What is priced; the first with an exact value if not said."),
    ] = None,
    seconds: Annotated[
        str, typer.Option(metavar="S", help="For all ways together, besides compilation.")
    ] = f"{SECONDS:g}",
    seed: Seed = 0,
    threads: Annotated[int, typer.Option(help="Of each run.")] = 1,
    out: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Where the diagram goes; out/ if not said.")
    ] = None,
    no_picture: Annotated[bool, typer.Option("--no-picture", help="Draw none.")] = False,
    json: Json = False,
) -> None:
    """Measure what accuracy costs: error against seconds, in every way."""
    module, settings = checked(experiment(sim)), named_values(set_ or ())
    costs = costs_of_case(module, settings, quantity, number("--seconds", seconds), seed, threads)
    if json:
        say_json(costs.record)
    else:
        print_costs(costs)
    if not no_picture and (not json or out is not None):
        tell_picture(*draw_costs(costs, Path("out") if out is None else out), quiet=json)


@app.command()
def effects(
    sim: Sim,
    set_: Set = None,
    cold: Annotated[
        bool,
        typer.Option("--cold", help="Time compilation with nothing on disk, too; in a process of its own."),
    ] = False,
    quick: Annotated[bool, typer.Option("--quick", help="Leave out what effects more would cost.")] = False,
    json: Json = False,
) -> None:
    """Tell what an experiment calls for, and what each effect costs."""
    module, settings = checked(experiment(sim)), named_values(set_ or ())
    found = {}
    for parameters in cases_of(module, settings):
        scene = treatment_by(module, scene_of(module, parameters, settings))
        told = effects_of(scene)
        found.setdefault((told.births, told.steps), (told, scene, []))[2].append(parameters)
    if json:
        costs = [costs_of(scene) for _, scene, _ in found.values()]
        scenes = [
            {"cases": cases} | record_of_scene(scene, ns, cold, more=kind == 0 and not quick)
            for kind, ((_, scene, cases), ns) in enumerate(zip(found.values(), costs, strict=True))
        ]
        told = [told for told, *_ in found.values()]
        say_json(record_of_effects(list(zip(told, costs, strict=True))) | {"scenes": scenes})
        return
    for kind, (told, scene, cases) in enumerate(found.values()):
        if len(found) > 1:
            say(
                "; ".join(", ".join(f"{name}={value}" for name, value in case.items()) for case in cases),
                style="bold cyan",
            )
        print_effects(told, scene, cold, more=kind == 0 and not quick)


@app.command()
def bench(
    repeats: Annotated[int, typer.Option(help="Timings of which the median is taken, at least 5.")] = 5,
    quick: Annotated[bool, typer.Option("--quick", help="Fewer particles a timing.")] = False,
    long: Annotated[
        bool, typer.Option("--long", help="Peak memory at 1e9 particles instead of 1e7.")
    ] = False,
    effects: Annotated[
        bool, typer.Option("--effects", help="Only the price list: what each effect adds to a base room.")
    ] = False,
    cold: Annotated[
        bool, typer.Option("--cold", help="Only how long each kind of scene compiles with nothing on disk.")
    ] = False,
    json: Json = False,
) -> None:
    """Measure the engine against a plain kernel, and price effects."""
    from transport.command.bench import bench as measure
    from transport.command.bench import render

    if (effects or cold) and (quick or long):
        raise SceneError("bench: --effects and --cold are measured in one way; leave out --quick and --long")
    if effects and cold and json:
        raise SceneError("bench: --json tells one table; leave out --effects or --cold")
    if repeats < 5:
        raise SceneError(f"bench: repeats must be at least 5 for a median, got {repeats}")
    if effects or cold:
        if effects:
            print_base_prices(repeats, json)
        if cold:
            print_cold_starts(json)
        return
    rows = measure(repeats=repeats, quick=quick, long=long)
    say_json(rows) if json else say(render(rows), "medians of one run, one thread unless said")
