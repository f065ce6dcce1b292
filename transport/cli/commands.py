"""The command `transport`: run, list, verify, checks and bench; the other commands are in files by topic."""

import sys
from itertools import chain, islice
from pathlib import Path
from typing import Annotated

import typer
from typer.core import TyperGroup

from transport import __version__
from transport.cli.cost import cost
from transport.cli.effects import effects
from transport.cli.files import merge, show
from transport.cli.options import (
    Batches,
    Checkpoint,
    Cluster,
    Every,
    Json,
    Overwrite,
    Part,
    Particles,
    Resume,
    Save,
    Seed,
    Set,
    Sim,
    Threads,
    named_errors,
    named_values,
    number,
    parse_part,
    parse_tracking,
    swept,
    whole_number,
)
from transport.cli.output import (
    INTERRUPTED,
    INVALID,
    TEXT_WIDTH,
    print_json,
    print_labelled,
    print_pictures,
    print_rich,
    print_to_stderr,
    report_errors,
)
from transport.cli.run import (
    checked_experiment,
    draw_experiment,
    draw_sweep,
    is_complete,
    outcomes_record,
    print_run,
    report_unsaved,
    text_of,
)
from transport.cli.show import docs, gallery, plot, schema, view
from transport.cli.verify import verify_hard, verify_laws, verify_long
from transport.compile.methods import ESTIMATORS, SAMPLINGS
from transport.results.diagnostics.table import CHECKS
from transport.validation import SceneError, name_hint
from transport.verification.experiment import (
    case_seed,
    experiment,
    experiment_name,
    experiment_names,
    iterate_outcomes,
)


class CommandGroup(TyperGroup):
    """Command group that reports invalid input in one line with exit status 2."""

    def invoke(self, ctx: typer.Context) -> object:
        """Run the chosen command; report invalid input in one line unless --debug is given."""
        with report_errors(debug=ctx.params["debug"]):
            return super().invoke(ctx)

    def resolve_command(self, ctx: typer.Context, args: list[str]) -> tuple:
        """Return the command of `args`; raise SceneError with a suggestion for an unknown one."""
        name = args[0]
        if name not in self.commands and not name.startswith("-"):
            if name.endswith(".py") or name in experiment_names():
                raise SceneError(f"transport: no command {name!r}; did you mean 'transport run {name}'?")
            raise SceneError(f"transport: no command {name!r}; {name_hint(name, self.commands)}")
        return super().resolve_command(ctx, args)


app = typer.Typer(
    cls=CommandGroup,
    help="Monte Carlo transport of photons and particles: radiometry with standard errors.",
    epilog="Each command's help has examples: transport run --help",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": TEXT_WIDTH},
)


def main() -> None:
    """Entry point of the console script `transport` and of `python -m transport`."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")  # an ASCII pipe must not raise UnicodeEncodeError
    app()


@app.callback(invoke_without_command=True)
def menu(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version and exit")] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error")] = False,
) -> None:
    """Print the list of experiments if no command is given."""
    if version:
        print_rich(f"transport {__version__}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        print_menu()


GROUPS = {  # of the menu
    "start here": ("sun", "lambert_disk", "diffuse_box"),
    "radiance, solid angles, shadows": (
        "inverse_square", "directions", "flows", "throughput", "view_factors", "penumbra", "wall_distance",
        "limits", "quantities",
    ),
    "rooms and cavities": (
        "camera", "panorama", "light_field", "furnace", "integrating_sphere", "light_fills_a_room",
    ),
    "lamps, glass, lenses, surfaces": (
        "goniophotometer", "far_lamp", "refraction", "magnifier", "lenses", "two_panes", "two_elements",
        "gonioreflectometer",
    ),
    "fog, tissue, clouds": (
        "fog", "slab", "half_space", "phase_functions", "point_in_fog", "milk", "cloud", "glow", "dogleg",
    ),
    "gases and phase space": ("photon_gas", "pressure", "effusion", "tube", "phase_space"),
    "what a digit costs": (
        "cost_disks", "cost_speck", "cost_glint", "cost_enclosure", "cost_fog", "cost_caustic", "cost_mirror",
    ),
}  # fmt: skip
COMMANDS = "run, cost, verify, plot, view, gallery, show, merge, effects, list, docs"


def print_menu() -> None:
    """Print the experiments by group: at first some with the questions that they answer."""
    print_rich("transport: Monte Carlo transport and radiometry with standard errors", style="bold")
    for title, names in GROUPS.items():
        print_rich("")
        print_rich(title, style="bold")
        if title == "start here":
            for name in names:
                print_labelled(
                    f"  transport run {name:13}", text_of(experiment(name), "question"), style="cyan"
                )
        else:
            print_rich(f"  {', '.join(names)}")
    print_rich("")
    print_rich("commands", style="bold")
    print_rich(f"  {COMMANDS}")
    print_rich("  transport list: what each answers; transport run --help: options and examples")


def print_list() -> None:
    """Print the experiments grouped by question."""
    groups: dict[str, list[tuple[str, str]]] = {}
    for name in experiment_names():
        module = experiment(name)
        groups.setdefault(text_of(module, "question"), []).append((name, text_of(module, "law")))
    width = max((len(name) for group in groups.values() for name, _ in group), default=0)
    for question, sims in groups.items():
        print_rich(question, style="bold")
        for name, law in sims:
            print_labelled(f"  {name:{width}}  ", law, style="cyan")


@app.command()
def run(
    sim: Sim,
    set_: Set = None,
    particles: Particles = None,
    error: Annotated[
        list[str] | None,
        typer.Option(
            metavar="meter.flux_in=1e-3",
            help="Run until the quantity has this relative standard error; repeatable",
        ),
    ] = None,
    seconds: Annotated[
        str | None, typer.Option(metavar="S", help="Run each case for at most this many seconds")
    ] = None,
    tracking: Annotated[
        str | None,
        typer.Option(metavar="analog", help="Tracking in media: analog, weighted, forced or roulette=1e-8"),
    ] = None,
    estimator: Annotated[
        str | None,
        typer.Option(
            metavar="auto",
            help=f"{', '.join(ESTIMATORS)}, or auto: the cheapest in pilot runs"
            " [default: auto with --error or --seconds, else analog]",
        ),
    ] = None,
    sampling: Annotated[
        str | None, typer.Option(metavar="sobol", help=f"Random numbers: {', '.join(SAMPLINGS)}")
    ] = None,
    guide: Annotated[
        str | None,
        typer.Option(metavar="N", help="Histories of short runs from which births are learnt; 0: none"),
    ] = None,
    seed: Annotated[
        int | None, typer.Option(help="Random seed; the same seed gives the same digits [default: 0]")
    ] = None,
    batches: Batches = None,
    threads: Threads = None,
    save: Save = None,
    overwrite: Overwrite = False,
    checkpoint: Checkpoint = None,
    every: Every = None,
    resume: Resume = None,
    part: Part = None,
    cluster: Cluster = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Folder of the picture [default: out]")
    ] = None,
    no_picture: Annotated[bool, typer.Option("--no-picture", help="Draw no picture")] = False,
    sweep: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=[...]", help="Run the first case for each of these values"),
    ] = None,
    verbose: Annotated[bool, typer.Option("--verbose", help="A table and the ledger of each case")] = False,
    json: Json = False,
) -> None:
    """Run an experiment and compare its estimates with exact values.

    \b
    Examples:
      transport run sun
      transport run lambert_disk --particles 1e7 --seed 3
      transport run inverse_square --set emitter=disk --set widths=5
      transport run cost_disks --error meter.flux_in=1e-4
      transport run cost_disks --particles 1e6 --estimator auto
      transport run tube --sweep length=[1,2,4,8]
      transport run slab --set tau=20 --tracking roulette=1e-11 --no-picture
      transport run mine.py --seconds 10 --json
      transport run scene.json --particles 1e7
      transport run scene.json --particles 1e10 --checkpoint run.nc --resume run.nc
      transport run scene.json --particles 1e9 --part 2/8 --save part2.nc
      transport run sun --particles 1e9 --cluster tcp://10.0.0.1:8786
    """
    limits = {
        "particles": whole_number("--particles", particles),
        "error": named_errors(error or ()),
        "seconds": None if seconds is None else number("--seconds", seconds),
        "tracking": parse_tracking(tracking),
        "estimator": estimator,
        "sampling": sampling,
        "guide": whole_number("--guide", guide),
        "seed": seed,
        "batches": whole_number("--batches", batches),
        "threads": threads,
        "checkpoint": checkpoint,
        "every": None if every is None else number("--every", every),
        "resume": resume,
        "part": parse_part(part),
        "cluster": cluster,
        "progress": "lines",
    }
    if every is not None and checkpoint is None:
        raise SceneError("--every needs --checkpoint FILE; add it, or leave out --every")
    module = checked_experiment(experiment(sim))
    settings = named_values(set_ or ())
    if not sweep:
        pending = iterate_outcomes(module, settings, limits, save, overwrite)
    else:
        name, values = swept(sweep, settings)
        if save or checkpoint or resume or part:
            raise SceneError("--sweep saves no runs; leave out --save, --checkpoint, --resume and --part")
        runs = (
            iterate_outcomes(module, {**settings, name: value}, limits | {"seed": case_seed(limits, number)})
            for number, value in enumerate(values)
        )
        pending = chain.from_iterable(islice(outcomes, 1) for outcomes in runs)  # the first case of each
    if json:
        outcomes = list(pending)
        print_json(outcomes_record(module, outcomes))
        wants_picture = out is not None
    else:
        outcomes = print_run(module, pending, verbose)
        wants_picture = out is not None or not sim.endswith(".json")
    if wants_picture and not no_picture and is_complete(outcomes):
        folder = Path("out") if out is None else out
        if not sweep:
            drawn = draw_experiment(module, outcomes, folder)
        else:
            path = folder / f"{experiment_name(module)}_sweep.png"
            drawn = draw_sweep(module, outcomes, name, values, path)
        print_pictures(*drawn, quiet=json)
    is_saved = report_unsaved(outcomes)
    if resume is not None and save is None and checkpoint is None:
        print_to_stderr(
            f"{resume} was not changed; pass --checkpoint {resume} or --save FILE to keep the new batches"
        )
    if not is_complete(outcomes):
        raise typer.Exit(INTERRUPTED)
    if not is_saved:
        raise typer.Exit(INVALID)


@app.command("list")
def list_(
    course: Annotated[
        bool, typer.Option("--course", help="List the statements of the course, with row and picture")
    ] = False,
    json: Json = False,
) -> None:
    """List the experiments with their questions.

    \b
    Examples:
      transport list
      transport list --course
      transport list --json
    """
    if course:
        from transport.cli.course import course_record, print_course

        if json:
            print_json(course_record())
        else:
            print_course()
    elif json:
        print_json(
            [{"sim": name, "question": text_of(experiment(name), "question")} for name in experiment_names()]
        )
    else:
        print_list()


@app.command()
def verify(
    sims: Annotated[
        list[str] | None,
        typer.Argument(metavar="SIM", help="Experiments, with --hard families of cases [default: all]"),
    ] = None,
    particles: Particles = None,
    seed: Seed = 0,
    threads: Threads = None,
    hard: Annotated[
        bool, typer.Option("--hard", help="Run the hard cases instead, compared with naive formulas")
    ] = False,
    long: Annotated[
        bool,
        typer.Option(
            "--long",
            help="Run 1e8 particles per case and all hard cases; prints a time estimate first",
        ),
    ] = False,
    json: Json = False,
) -> None:
    """Compare results with exact values; exit status 1 if one fails.

    \b
    Examples:
      transport verify
      transport verify sun lambert_disk
      transport verify mine.py --particles 1e6
      transport verify --hard
      transport verify --hard sums slivers
      transport verify --long --particles 1e7
    """
    if hard and long:
        raise SceneError("verify: --long includes the hard cases; leave out --hard")
    if hard:
        if particles is not None or seed != 0 or threads is not None:
            raise SceneError(
                "verify --hard: hard cases have fixed settings; leave out --particles, --seed, --threads"
            )
        raise typer.Exit(verify_hard(sims, json))
    limits = {"particles": whole_number("--particles", particles), "seed": seed, "threads": threads}
    limits["progress"] = "lines"
    raise typer.Exit((verify_long if long else verify_laws)(sims, limits, json))


@app.command()
def checks(json: Json = False) -> None:
    """List the checks of every run, and what they cannot detect.

    \b
    Examples:
      transport checks
      transport checks --json
    """
    if json:
        print_json([check.record() for check in CHECKS])
        return
    for check in CHECKS:
        print_rich(check.name, style="bold")
        print_labelled("  detects  ", check.detects, style="cyan")
        if check.cannot_detect:
            print_labelled("  misses   ", check.cannot_detect, style="cyan")


@app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True})
def bench() -> None:
    """Print where the benchmarks are.

    \b
    Examples:
      transport bench
    """
    print_rich(
        "The benchmarks are in a clone of the project, beside its tests: python -m tests.bench lists and runs"
        " them.  What each effect of a scene costs: transport effects SIM."
    )


for command in (cost, show, plot, merge, view, effects, gallery, schema, docs):
    app.command()(command)
