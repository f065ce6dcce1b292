"""`transport view`, `gallery`, `schema` and `docs`: scenes in 3-D, figures, the JSON schema and the pages."""

import importlib
import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Annotated

import typer

from transport.analysis.tracks import Tracks, tracks
from transport.cli.gallery import GallerySettings, build_gallery
from transport.cli.options import Json, Seed, Set, Sim, Threads, named_values, whole_number
from transport.cli.output import print_json, print_pictures, print_rich
from transport.cli.run import checked_experiment, draw_to, experiment_treatment
from transport.results.result import Result
from transport.scene.scene import Scene
from transport.simulate import simulate
from transport.validation import SceneError, optional_packages
from transport.verification.experiment import (
    DEFAULT_PARTICLES,
    cases_of,
    experiment,
    experiment_name,
    run_settings_of,
    scene_of,
)

WINDOW, PICTURE, PAGE, FILES, MOVIE = "window", ".png", ".html", ".vtm", ".gif"
TRACKS, MOVIE_TRACKS = 300, 1500  # number of tracks of a picture, and of a movie
MAX_FLIGHTS = 200_000  # largest number of flights if the user gave no number of tracks
TRACK_REDUCTION = 64  # factor by which tracks are reduced if they do not fit into memory
SHORT_NUMBER = 10  # characters of a short number
MAX_TITLE = 76  # largest number of characters of a title
BY_DIRECTION, BY_WEIGHT = "direction", "weight"


@dataclass(frozen=True)
class View:
    """The pictures to draw of one case of an experiment.

    `result` and `tracks` are None if not drawn.  `flying` holds the tracks of a movie, None for a movie in
    time.  `case` counts from 1; `note` is a remark on the tracks.
    """

    sim: str
    parameters: Mapping[str, object]
    scene: Scene
    result: Result | None
    tracks: Tracks | None
    movie_tracks: Tracks | None
    colour: str
    case: int = 1
    note: str = ""

    @property
    def title(self) -> str:
        """The experiment and the parameters of its case in one line."""
        text = ", ".join(f"{name} = {_short(value)}" for name, value in self.parameters.items())
        return textwrap.shorten(f"{self.sim}: {text}" if text else self.sim, MAX_TITLE, placeholder=" …")


def _short(value: object) -> str:
    """Return a number with all digits if they are few, else four: 0.99999 must not read as 1."""
    is_long = isinstance(value, float) and len(repr(value)) > SHORT_NUMBER
    return f"{value:.4g}" if is_long else str(value)


def _viz(name: str) -> ModuleType:
    """Import a module of the pictures."""
    return importlib.import_module(f"transport.viz.{name}")


def output_kinds(page: bool, files: bool, movie: bool, folder: Path | None) -> tuple[str, ...]:
    """Return the requested kinds; by default a window if there is a display and no folder, else a picture.

    Raises SceneError, with the packages to install, if this machine cannot draw them.
    """
    requested = {PAGE: page, FILES: files, MOVIE: movie}
    kinds = tuple(kind for kind, is_requested in requested.items() if is_requested)
    with optional_packages("view"):
        screen = _viz("screen")
        if not kinds:
            kinds = (WINDOW if folder is None and screen.has_display() else PICTURE,)
        if not set(kinds) <= {FILES, PAGE}:  # these are written without drawing
            try:
                screen.require_screen()
            except screen.NoScreen as lack:
                raise SceneError(f"view: {lack}") from None
    return kinds


def make_view(
    module: ModuleType,
    settings: dict[str, object],
    kinds: tuple[str, ...],
    case: int = 1,
    particles: int | None = None,
    ways: int | None = None,
    colour: str = BY_DIRECTION,
    seed: int = 0,
    threads: int | None = None,
) -> View:
    """Run one case of an experiment, and trace the paths of a few particles.

    `case` counts from 1.  `particles` None: the experiment's number, at most a million; 0: no run.  `ways` is
    the number of tracks, None: a suitable number.
    """
    if colour not in (BY_DIRECTION, BY_WEIGHT):
        raise SceneError(f"view: --colour must be {BY_DIRECTION} or {BY_WEIGHT}, got {colour!r}")
    parameters = _case_parameters(module, settings, case)
    scene = scene_of(module, parameters, settings)
    if particles is None:
        particles = min(getattr(module, "particles", DEFAULT_PARTICLES), DEFAULT_PARTICLES)
    film = _with_snapshots(module, scene) if MOVIE in kinds and particles > 0 else None
    is_still = set(kinds) != {MOVIE}
    result = None
    if particles > 0 and (is_still or film is not None):
        result = simulate(film or scene, particles, seed=seed, threads=threads, **run_settings_of(module))
    still = 0 if not is_still else TRACKS if ways is None else ways
    flying = MOVIE_TRACKS if ways is None else ways
    shown, note = _find_tracks(scene, still, seed, ways is None)
    flown, note = (
        _find_tracks(scene, flying, seed, ways is None) if MOVIE in kinds and film is None else (None, note)
    )
    return View(experiment_name(module), parameters, scene, result, shown, flown, colour, case, note)


def open_window(view: View) -> None:
    """Open an interactive window of the scene, and wait until it is closed."""
    plotter = _viz("scene").draw_scene(view.scene, view.result, view.tracks, off_screen=False)
    plotter.show(title=view.title)


def write_files(view: View, kinds: tuple[str, ...], folder: Path) -> Iterator[Path]:
    """Write each kind of file into the folder as view_SIM (case 2: view_SIM_2), and yield the paths.

    Raises SceneError if one cannot be written.
    """
    number = f"_{view.case}" if view.case > 1 else ""
    for kind in kinds:
        with optional_packages("view"):
            paths, why = draw_to(
                lambda path, kind=kind: _WRITERS[kind](view, path), folder / f"view_{view.sim}{number}{kind}"
            )
        if not paths:
            raise SceneError(f"view: {why}")
        yield from paths


def _case_parameters(module: ModuleType, settings: dict[str, object], number: int) -> dict[str, object]:
    """Return the parameters of a case, counted from 1.  Raises SceneError for a number out of range."""
    cases = cases_of(module, settings)
    if not 1 <= number <= len(cases):
        many = f"{experiment_name(module)} has {len(cases)} cases, counted from 1"
        has = many if len(cases) > 1 else "there is only one"
        raise SceneError(f"view: no case {number}; {has}")
    return cases[number - 1]


def _find_tracks(scene: Scene, wanted: int, seed: int, is_free: bool) -> tuple[Tracks | None, str]:
    """Return the tracks to draw, and a note if they are fewer; `is_free`: the user gave no number."""
    count = wanted
    while count:
        try:
            found = tracks(scene, count, seed)
        except SceneError:
            if count == 1:
                raise
            count = max(1, count // TRACK_REDUCTION)
            continue
        flights = len(found)
        if flights <= MAX_FLIGHTS or not is_free:
            break
        if count == 1:
            found = _cut_tracks(found, MAX_FLIGHTS)
            return found, f"the first {MAX_FLIGHTS} flights of 1 of {wanted} tracks, which has {flights}"
        count = max(1, count * MAX_FLIGHTS // (2 * flights))
    if count == wanted:
        return (found if wanted else None), ""
    return found, f"{count} of {wanted} tracks: each has about {flights / count:.2g} flights"


def _cut_tracks(found: Tracks, flights: int) -> Tracks:
    """Return the tracks cut to their first `flights` flights."""
    columns = ("starts", "directions", "lengths", "weights", "histories", "meets")
    return replace(found, **{name: getattr(found, name)[:flights] for name in columns})


def _with_snapshots(module: ModuleType, scene: Scene) -> Scene | None:
    """Return the scene with one snapshot per frame; None without a duration, or if it allows no snapshots."""
    if scene.duration is None:
        return None
    with optional_packages("view"):
        film = _viz("movie").filmed(scene)
    try:
        compiles = experiment_treatment(module, film).plan is not None
    except SceneError:
        return None
    return film if compiles else None


def _write_picture(view: View, path: Path) -> object:
    return _viz("scene").draw_scene(view.scene, view.result, view.tracks, path, title=view.title)


def _write_page(view: View, path: Path) -> object:
    return _viz("page").scene_page(view.scene, path, view.result, view.tracks, title=view.title)


def _write_vtk(view: View, path: Path) -> object:
    blocks = _viz("scene").scene_blocks(view.scene, view.result, view.tracks)
    path.open("wb").close()  # raises OSError; the VTK writer would only print
    blocks.save(path)
    return path


def _write_movie(view: View, path: Path) -> object:
    movie, common = _viz("movie"), {"colour": view.colour, "title": view.title}
    if view.movie_tracks is None:
        return movie.clock_movie(view.scene, path, view.result, **common)
    return movie.tracks_movie(view.scene, path, view.movie_tracks, **common)


_WRITERS = {PICTURE: _write_picture, PAGE: _write_page, FILES: _write_vtk, MOVIE: _write_movie}


# ---- The commands.


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
    module, settings = checked_experiment(experiment(sim)), named_values(set_ or ())
    kinds = output_kinds(html, vtk, movie, folder)
    options = whole_number("--particles", particles), tracks, colour, seed, threads
    seen = make_view(module, settings, kinds, case, *options)
    if WINDOW in kinds:
        open_window(seen)
        return
    paths = list(write_files(seen, kinds, Path("out") if folder is None else folder))
    if json:
        print_json({"sim": seen.sim, "parameters": seen.parameters, "pictures": paths})
    else:
        print_rich(seen.title, style="bold")
        if seen.note:
            print_rich(f"{'tracks':<12}{seen.note}")
        print_pictures(paths, "")


def plot(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A saved run, .nc or .npz, or a scene, .json")],
    detector: Annotated[
        str | None, typer.Option(metavar="NAME", help="Draw the bins of this detector, with their errors")
    ] = None,
    quantity: Annotated[
        str | None, typer.Option(metavar="NAME", help="Of the detector, such as radiance")
    ] = None,
    decades: Annotated[
        float | None, typer.Option(metavar="N", help="Logarithmic scale over so many decades")
    ] = None,
    cut: Annotated[bool, typer.Option("--cut", help="A cut through the brightest row of bins, too")] = False,
    plane: Annotated[
        str | None, typer.Option(metavar="PLANE", help="Section of a scene: xy, xz or yz [default: xz]")
    ] = None,
    at: Annotated[
        float | None, typer.Option(metavar="METRES", help="Place of the section on the third axis")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Picture to write [default: out/NAME.png]")
    ] = None,
) -> None:
    """Draw a saved run, or a section of a scene.

    \b
    Examples:
      transport plot run.nc
      transport plot run.nc --detector floor --cut
      transport plot scene.json --plane yz --at 0.5 --out scene.png
    """
    is_scene = file.suffix == ".json"
    given = {"--detector": detector, "--quantity": quantity, "--decades": decades, "--cut": cut or None}
    sections = {"--plane": plane, "--at": at}
    if is_scene:
        _refuse_options(given, f"{file} is a scene; give a saved run, .nc or .npz")
    else:
        _refuse_options(sections, f"{file} is a run; give a scene, .json")
        if detector is None:
            _refuse_options(given, "it belongs to the bins of one detector; add --detector NAME")
    with optional_packages("plot"):
        import matplotlib
    matplotlib.use("Agg")  # files alone are drawn
    if is_scene:
        from transport.scene.scene import Scene

        drawn = Scene.from_json(file).plot(plane or "xz", at)
    else:
        from transport.io import load

        result = load(file)
        if detector is None:
            drawn = result.plot()[0]
        else:
            try:
                drawn = result[detector].plot(quantity, decades=decades, cut=cut)
            except ValueError as error:  # of bins that cannot be drawn so
                raise SceneError(str(error)) from error
    path = Path("out") / f"{file.stem}.png" if out is None else out
    paths, why = draw_to(lambda path: _viz("style").save_figure(drawn.figure, path), path)
    if not paths:
        raise SceneError(f"plot: {why}")
    print_pictures(list(paths), "")


def _refuse_options(options: dict[str, object], why: str) -> None:
    for name, value in options.items():
        if value is not None:
            raise SceneError(f"plot: {name} has no use here: {why}")


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
    settings = GallerySettings(whole_number("--particles", particles), seed, threads)
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
    from transport.io.json.schema import schema_text

    if out is None:
        typer.echo(schema_text(), nl=False)
    else:
        try:
            out.write_text(schema_text(), encoding="utf-8")
        except OSError as error:
            why = error.strerror or error
            raise SceneError(f"schema: cannot write {out}: {why}; pass another --out FILE") from None


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
    from transport.cli.docs import build_site

    print_rich(f"pages: {build_site(out, context.find_root().command)}")
