"""Commands that show: a scene in 3-D, every figure, the format of scenes, these pages."""

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
    case: Annotated[int, typer.Option(metavar="K", help="Which of its cases; 1 is the first.")] = 1,
    particles: Annotated[
        str | None, typer.Option(metavar="N", help="Histories that colour the surfaces; 0 for none.")
    ] = None,
    tracks: Annotated[
        int | None,
        typer.Option(metavar="N", min=0, help=f"Tracks drawn; {TRACKS} if not said, more in a movie."),
    ] = None,
    html: Annotated[
        bool, typer.Option("--html", help="A page that turns under the mouse in any browser, offline.")
    ] = False,
    vtk: Annotated[bool, typer.Option("--vtk", help="Files for ParaView: a .vtm and what it names.")] = False,
    movie: Annotated[
        bool, typer.Option("--movie", help="A GIF of flying particles, by the clock where there is one.")
    ] = False,
    colour: Annotated[
        str, typer.Option(metavar="direction", help="Of the movie's particles: direction or weight.")
    ] = "direction",
    seed: Seed = 0,
    threads: Threads = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Where files go, and no window; out/ if not said.")
    ] = None,
    json: Json = False,
) -> None:
    """See an experiment in 3-D: a window, a PNG, a page, a movie.

    Where there is a display it opens a window; else, or with --out, it draws a PNG.

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
        typer.Option(metavar="NAME", help="A figure or an experiment; repeatable; all if not said."),
    ] = None,
    particles: Annotated[
        str | None, typer.Option(metavar="N", help="At most so many histories of each scene.")
    ] = None,
    seed: Seed = 0,
    threads: Threads = None,
    out: Annotated[
        Path, typer.Option(metavar="FOLDER", help="Where figures and page go; out/gallery/ if not said.")
    ] = Path("out/gallery"),
    json: Json = False,
) -> None:
    """Draw every figure into a folder, with a page about them.

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
        Path | None, typer.Option(metavar="FILE", help="Where it goes; printed if not said.")
    ] = None,
) -> None:
    """Print what a scene's .json file may hold, as a JSON Schema.

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
    out: Annotated[Path, typer.Option(metavar="FOLDER", help="Where the pages go.")] = Path("out/docs"),
) -> None:
    """Build README, guides and the reference of all names as HTML.

    \b
    Examples:
      transport docs
      transport docs --out site
    """
    from transport.command.site import build_site

    say(f"pages: {build_site(out)}")
