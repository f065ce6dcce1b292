"""Commands view, gallery, schema and docs."""

from pathlib import Path
from typing import Annotated

import typer

from transport.command.console import say, say_json
from transport.command.gallery import Settings, build_gallery
from transport.command.options import Json, Seed, Set, Sim, Threads
from transport.command.printout import tell_picture
from transport.command.running import checked
from transport.command.settings import named_values, whole_number
from transport.command.view import TRACKS, WINDOW, kinds_of, show, view_of, written
from transport.experiment import experiment


def view(
    sim: Sim,
    set_: Set = None,
    case: Annotated[int, typer.Option(metavar="K", help="Number of the case, from 1")] = 1,
    particles: Annotated[
        str | None, typer.Option(metavar="N", help="Particles of the run that colours surfaces; 0: no run")
    ] = None,
    tracks: Annotated[
        int | None,
        typer.Option(metavar="N", min=0, help=f"Number of paths drawn [default: {TRACKS}, movie: more]"),
    ] = None,
    html: Annotated[
        bool, typer.Option("--html", help="Write an interactive HTML page that works offline")
    ] = False,
    vtk: Annotated[bool, typer.Option("--vtk", help="Write ParaView files: a .vtm and its blocks")] = False,
    movie: Annotated[
        bool, typer.Option("--movie", help="Write a GIF of moving particles, in time if the scene has it")
    ] = False,
    colour: Annotated[
        str, typer.Option(metavar="direction", help="Movie: colour particles by direction or weight")
    ] = "direction",
    seed: Seed = 0,
    threads: Threads = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Write files here, no window [default: out]")
    ] = None,
    json: Json = False,
) -> None:
    """Show an experiment in 3-D: a window, a PNG, a page or a movie.

    Opens a window if there is a display. Otherwise, or with --out, writes a PNG.

    \b
    Examples:
      transport view integrating_sphere
      transport view cloud --html
      transport view effusion --movie --tracks 2000
      transport view mine.py --case 2 --set albedo=0.9 --vtk --out figures
    """
    folder = Path("out") if out is None and json else out
    kinds = kinds_of(html, vtk, movie, folder)
    number_of = whole_number("--particles", particles)
    seen = view_of(
        checked(experiment(sim)),
        named_values(set_ or ()),
        kinds,
        case,
        number_of,
        tracks,
        colour,
        seed,
        threads,
    )
    if WINDOW in kinds:
        show(seen)
        return
    paths = list(written(seen, kinds, Path("out") if folder is None else folder))
    if json:
        say_json({"sim": seen.sim, "parameters": seen.parameters, "pictures": paths})
    else:
        say(seen.title, style="bold")
        if seen.note:
            say(f"{'tracks':<12}{seen.note}")
        tell_picture(paths, "", quiet=False)


def gallery(
    only: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="Draw only this figure or experiment; repeatable"),
    ] = None,
    particles: Annotated[
        str | None, typer.Option(metavar="N", help="Largest number of particles per scene")
    ] = None,
    seed: Seed = 0,
    threads: Threads = None,
    out: Annotated[Path, typer.Option(metavar="FOLDER", help="Folder of the figures and the page")] = Path(
        "out/gallery"
    ),
    json: Json = False,
) -> None:
    """Draw all figures into a folder, with a page that describes them.

    \b
    Examples:
      transport gallery
      transport gallery --only power_flow --only convergence
      transport gallery --only lambert_disk --particles 1e5 --out pictures
    """
    settings = Settings(whole_number("--particles", particles), seed, threads)
    raise typer.Exit(build_gallery(settings, only or (), out, json))


def schema(
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Output file [default: standard output]")
    ] = None,
) -> None:
    """Print the JSON Schema of scene files.

    \b
    Examples:
      transport schema
      transport schema --out scene.schema.json
    """
    from transport.written.schema import schema_text

    if out is None:
        typer.echo(schema_text(), nl=False)
    else:
        out.write_text(schema_text(), encoding="utf-8")


def docs(
    context: typer.Context,
    out: Annotated[Path, typer.Option(metavar="FOLDER", help="Folder of the pages")] = Path("out/docs"),
) -> None:
    """Build README, guides and reference as HTML pages.

    \b
    Examples:
      transport docs
      transport docs --out site
    """
    from transport.command.site import build_site

    say(f"pages: {build_site(out, context.find_root().command)}")
