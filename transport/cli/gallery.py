"""`transport gallery`: all figures in a folder, with a page that describes each and gives its command."""

import importlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter

from transport.analysis.tracks import tracks
from transport.cli.cost import costs_of_case, draw_costs
from transport.cli.output import NO_BREAK_SPACE, print_json, print_labelled, print_to_stderr
from transport.cli.run import (
    case_warnings,
    checked_experiment,
    draw_experiment,
    draw_to,
    is_complete,
    verdict_on,
)
from transport.results.result import Result
from transport.simulate import simulate
from transport.statistics.notation import with_thousands_spaces
from transport.validation import SceneError, name_hint, optional_packages
from transport.verification.experiment import (
    DEFAULT_PARTICLES,
    experiment,
    experiment_names,
    iterate_outcomes,
    run_settings_of,
    scene_of,
)

MAX_PARTICLES = 1_000_000  # largest number of particles per case of an experiment
COST_SECONDS = 6.0  # CPU time of a cost diagram
COST_PREFIX = "cost_"  # prefix of experiments whose cost diagram is drawn too
PAGE = "README.md"
HEADINGS = {
    "general": "Figures of any result", "costs": "Cost of accuracy", "experiments": "The experiments"
}  # fmt: skip


@dataclass(frozen=True)
class Piece:
    """One entry of the gallery; `draw(folder)` draws its pictures and returns them as a DrawnPiece."""

    name: str
    heading: str
    command: str
    draw: Callable[[Path], "DrawnPiece"]


@dataclass(frozen=True)
class DrawnPiece:
    """Outcome of a piece: its pictures with description and notes, or the reason for no picture."""

    paths: list[Path]
    says: str = ""
    notes: list[str] = field(default_factory=list)
    why: str = ""
    is_unsupported: bool = False  # True if this machine cannot draw it


Timed = tuple[Piece, DrawnPiece, float]  # a piece, its outcome, and the seconds that it took


@dataclass(frozen=True)
class GallerySettings:
    """Settings of the gallery's runs; `particles` limits the number per scene, None: no limit."""

    particles: int | None = None
    seed: int = 0
    threads: int | None = None

    @property
    def limits(self) -> dict[str, object]:
        """Arguments of `simulate`, without the number of particles."""
        return {"seed": self.seed, "threads": self.threads, "progress": False}

    def limited(self, wanted: int) -> int:
        """Return the smaller of `wanted` and the allowed number of particles."""
        return wanted if self.particles is None else min(wanted, self.particles)


def build_gallery(settings: GallerySettings, only: Sequence[str], folder: Path, json: bool = False) -> int:
    """Draw the selected pieces, print each, and write the page; return status 1 if a picture is missing."""
    wanted, found = select_pieces(pieces(settings), only), []
    for piece, made, seconds in draw_pieces(wanted, folder):
        found.append((piece, made, seconds))
        if made.why:
            print_to_stderr(f"{piece.name}: no picture: {made.why}")
        elif not json:
            paths = ", ".join(str(path).replace(" ", NO_BREAK_SPACE) for path in made.paths)
            print_labelled(f"{piece.name:24s}", f"{paths}  ({seconds:.1f} s)")
    page = write_page(found, folder, settings)
    if json:
        print_json({"page": str(page), "figures": record_of_gallery(found)})
    else:
        print_labelled(f"{'page':24s}", str(page).replace(" ", NO_BREAK_SPACE))
    return int(any(not made.paths and not made.is_unsupported for _, made, _ in found))


def pieces(settings: GallerySettings) -> list[Piece]:
    """Return all pieces: general figures, costs and experiments.  Raises SceneError without matplotlib."""
    with optional_packages("gallery"):
        exhibits = importlib.import_module("transport.viz.exhibits").EXHIBITS
    runs = ResultCache(settings)
    found = [_general(exhibit, runs, settings) for exhibit in exhibits]
    names = experiment_names()
    found += [_cost(name, settings) for name in names if name.startswith(COST_PREFIX)]
    return found + [_experiment(name, settings) for name in names if hasattr(experiment(name), "draw")]


def select_pieces(found: Sequence[Piece], only: Sequence[str]) -> list[Piece]:
    """Return the pieces of these names, or all if `only` is empty.  Raises SceneError for an unknown name."""
    names = {piece.name: piece for piece in found}
    for name in only:
        if name not in names:
            raise SceneError(f"gallery: no figure {name!r}; {name_hint(name, names)}")
    return [names[name] for name in dict.fromkeys(only)] if only else list(found)


def draw_pieces(wanted: Sequence[Piece], folder: Path) -> Iterator[Timed]:
    """Draw each piece into the folder; yield (piece, outcome, seconds)."""
    folder.mkdir(parents=True, exist_ok=True)
    for piece in wanted:
        start = perf_counter()
        try:
            made = piece.draw(folder)
        except SceneError as error:
            made = DrawnPiece([], why=str(error))
        yield piece, made, perf_counter() - start


def write_page(found: Sequence[Timed], folder: Path, settings: GallerySettings) -> Path:
    """Write the Markdown page with each picture, its description, notes and command; return its path."""
    lines = ["# Gallery", ""]
    limits = "as many particles as each needs"
    if settings.particles is not None:
        limits = f"at most {with_thousands_spaces(settings.particles)} particles"
    bars = "Bars and bands are two standard errors."
    lines += [f"Figures of `transport gallery`: {limits}, seed {settings.seed}. {bars}", ""]
    for heading, words in HEADINGS.items():
        shown = [(piece, made) for piece, made, _ in found if piece.heading == heading]
        if shown:
            lines += [f"## {words}", ""]
        for piece, made in shown:
            lines += _entry(piece, made, folder)
    path = folder / PAGE
    path.write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")
    return path


def record_of_gallery(found: Sequence[Timed]) -> list[dict[str, object]]:
    """Return the entries as JSON-ready types."""
    return [
        {
            "name": piece.name,
            "pictures": [str(path) for path in made.paths],
            "says": made.says,
            "notes": made.notes,
            "why_none": made.why or None,
            "command": piece.command,
            "seconds": seconds,
        }
        for piece, made, seconds in found
    ]


def _entry(piece: Piece, made: DrawnPiece, folder: Path) -> list[str]:
    lines = [f"### {piece.name}", ""]
    lines += [f"![{piece.name}]({path.relative_to(folder).as_posix()})\n" for path in made.paths]
    if made.why:
        lines += [f"No picture: {made.why}", ""]
    if made.says:
        lines += [made.says, ""]
    lines += [f"Note: {note}\n" for note in made.notes]
    return [*lines, f"`{piece.command}`", ""]


class ResultCache:
    """Results of exhibits; exhibits with the same scene share one run."""

    def __init__(self, settings: GallerySettings) -> None:
        self._settings, self._results = settings, {}

    def result_for(self, exhibit: object) -> Result:
        """Return the result of the exhibit's scene; runs it at the first call."""
        key = (exhibit.sim, exhibit.looks, *sorted(exhibit.parameters.items()), exhibit.particles)
        if key not in self._results:
            self._results[key] = self._run(exhibit)
        return self._results[key]

    def _run(self, exhibit: object) -> Result:
        if exhibit.sim is None:
            scene, settings = exhibit.scene, exhibit.ways
        else:
            module = experiment(exhibit.sim)
            scene, settings = scene_of(module, dict(exhibit.parameters), {}), run_settings_of(module)
        result = simulate(
            scene, self._settings.limited(exhibit.particles), **self._settings.limits, **settings
        )
        if not result.is_complete:
            raise KeyboardInterrupt
        return result


def _general(exhibit: object, runs: ResultCache, settings: GallerySettings) -> Piece:
    def draw(folder: Path) -> DrawnPiece:
        if exhibit.is_solid and (lack := _missing_screen()):
            return DrawnPiece([], exhibit.says, why=lack, is_unsupported=True)
        result = runs.result_for(exhibit)
        few = tracks(result.scene, exhibit.tracks, settings.seed) if exhibit.tracks else None
        note = f"{with_thousands_spaces(result.particles)} particles, seed {result.seed}"
        paths, why = draw_to(
            lambda path: exhibit.draw(result, few, path, note), folder / f"{exhibit.name}.png"
        )
        return DrawnPiece(paths, exhibit.says, result.warnings, why)

    return Piece(exhibit.name, "general", f"transport gallery --only {exhibit.name}", draw)


def _missing_screen() -> str:
    """Return why 3-D pictures cannot be drawn here, or an empty string."""
    screen = importlib.import_module("transport.viz.screen")
    try:
        screen.require_screen()
    except screen.NoScreen as lack:
        return str(lack)
    return ""


def _experiment(name: str, settings: GallerySettings) -> Piece:
    module = experiment(name)
    particles = settings.limited(min(getattr(module, "particles", DEFAULT_PARTICLES), MAX_PARTICLES))

    def draw(folder: Path) -> DrawnPiece:
        limits = settings.limits | {"particles": particles}
        outcomes = list(iterate_outcomes(checked_experiment(module), {}, limits))
        if not is_complete(outcomes):
            raise KeyboardInterrupt
        paths, why = draw_experiment(module, outcomes, folder / "experiments")
        says = " ".join(f"{getattr(module, 'question', '')} {verdict_on(module, outcomes)}".split())
        return DrawnPiece(paths, says, case_warnings(outcomes), why)

    return Piece(name, "experiments", f"transport run {name} --particles {particles}", draw)


def _cost(name: str, settings: GallerySettings) -> Piece:
    def draw(folder: Path) -> DrawnPiece:
        costs = costs_of_case(experiment(name), {}, None, COST_SECONDS, settings.seed, 1)
        paths, why = draw_costs(costs, folder / "costs")
        says = (
            f"True and claimed error of {costs.cost.quantity} against CPU seconds, for each estimator."
            " Bars are two standard errors of the true error; each slope is given with its standard error."
        )
        return DrawnPiece(paths, says, why=why)

    command = f"transport cost {name} --seconds {COST_SECONDS:g}"
    return Piece(f"price_{name.removeprefix(COST_PREFIX)}", "costs", command, draw)
