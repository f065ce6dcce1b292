"""An experiment is a module with a scene, measured quantities, exact values, a question and a verdict.

    law: str                                  the law in one line, with its source
    question: str                             the question in one sentence
    particles: int                            default number of particles per case
    run: dict                                 default settings of `simulate` (RUN_SETTINGS), for
                                              example {"estimator": "aimed"}; without an estimator
                                              pilot runs choose one for `error` or `seconds`, among
                                              those that estimate all quantities
    cases() -> list of dict                   the parameter sets of its table; if missing: one, the defaults
    scene(**parameters) -> Scene
    measure(result) -> {name: Estimate}
    intended: dict                            diagnostics that find what the experiment means, with
                                              the reason, which is a note instead of a warning:
                                              {"aim": "only rays between the disks are wanted"}
    in_bins(result) -> {name: EstimateArray}  further results, for JSON only; optional
    exact(**parameters) -> {name: float}      closed forms; without a name, or if missing: unknown
    verdict(outcomes) -> str                  the answer in one sentence
    draw(outcomes, path)                      draw the figure, a PNG; returns the paths if there are several

Only `scene` and `measure` are required. The modules of the package `sims` are experiments, and so is any
Python file of a user. A scene's JSON file is an experiment that measures all quantities of its detectors
(transport.verification.scene_file).
"""

import importlib
import importlib.util
import inspect
import math
import pkgutil
import re
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from types import ModuleType

from transport.io.atomic import FileError
from transport.io.resuming import NOT_SAVED
from transport.io.runs import check_not_existing, checked_destination, scene_text
from transport.results.diagnostics.run_findings import warnings_of
from transport.results.diagnostics.table import DIAGNOSTICS
from transport.results.result import Result
from transport.run.settings import checked_limits
from transport.scene.scene import Scene
from transport.simulate import simulate_all_quantities
from transport.statistics.estimates import Estimate, EstimateArray
from transport.statistics.findings import DOUBTFUL, NOTE, Finding
from transport.units import UnitError
from transport.validation import SceneError, name_hint, short_repr

SIMS = "transport.sims"  # the package whose modules are experiments, each loaded when it is named
SEEDS_APART = 1_000_000  # seeds of one case and the next
DEFAULT_PARTICLES = 1_000_000  # default number of particles per case
# parameters of `simulate` that an experiment may set
RUN_SETTINGS = "estimator", "sampling", "guide", "batches", "tracking"
FILE_SETTINGS = ("save", "resume", "checkpoint")  # parameters that are files


@dataclass(frozen=True)
class Row:
    """One row of an experiment's table. exact: nan if no closed form is known."""

    name: str
    estimate: Estimate
    exact: float

    @property
    def z(self) -> float:
        """Deviation from the exact value in standard errors, as a standard normal score; nan if unknown."""
        return math.nan if math.isnan(self.exact) else self.estimate.z(self.exact)


@dataclass(frozen=True)
class Outcome:
    """One case of an experiment: its parameters, the run, and its table.

    notes: warnings besides those of the run;  bins: measured arrays, by name;  given: the parameters, and
    the defaults of the scene's others;  read: the scores of which rows and bins were made, by detector;
    intended: names of diagnostics that find what the experiment means, each with the reason;  number: of the
    case.
    """

    parameters: dict[str, object]
    result: Result
    rows: tuple[Row, ...]
    notes: tuple[str, ...] = ()
    bins: Mapping[str, EstimateArray] = field(default_factory=dict)
    given: Mapping[str, object] = field(default_factory=dict)
    read: Mapping[str, frozenset[str]] = field(default_factory=dict)
    intended: Mapping[str, str] = field(default_factory=dict)
    number: int = 0

    @property
    def seed(self) -> int:
        """Seed of the experiment, from which that of the case was made."""
        return self.result.seed - SEEDS_APART * self.number

    def __getitem__(self, name: str) -> Row:
        """Row of that name."""
        return next(row for row in self.rows if row.name == name)

    def __contains__(self, name: str) -> bool:
        """Whether there is a row of that name."""
        return any(row.name == name for row in self.rows)

    @property
    def warnings(self) -> list[str]:
        """Warnings about the numbers that the experiment reads, and about detectors that only pictures read.

        Without those of diagnostics that find what is intended; the run itself has all of them.
        """
        return [*self.notes, *warnings_of(f for f in self._findings if f.name not in self.intended)]

    @property
    def intentions(self) -> list[str]:
        """The reason of each intended diagnostic that found something in this run."""
        names = {finding.name for finding in self._findings if finding.severity in (NOTE, DOUBTFUL)}
        return [f"{why} ({name}, as intended)" for name, why in self.intended.items() if name in names]

    @cached_property
    def _findings(self) -> tuple[Finding, ...]:
        return self.result._findings_about(self.read)

    @property
    def not_saved(self) -> list[str]:
        """Warnings about files that could not be written at the end."""
        return [warning for warning in (*self.notes, *self.result._warnings) if warning.startswith(NOT_SAVED)]

    @property
    def title(self) -> str:
        """Parameters in one line."""
        return ", ".join(
            f"{name}={value:.6g}" if isinstance(value, float) else f"{name}={value}"
            for name, value in self.parameters.items()
        )


def experiment_names() -> list[str]:
    """Names of the installed experiments."""
    folders = importlib.util.find_spec(SIMS).submodule_search_locations
    return sorted(module.name for module in pkgutil.iter_modules(folders))


def experiment(name: str) -> ModuleType:
    """The experiment of that name in `sims`, or in the .py or .json file at that path; else SceneError."""
    if name.endswith(".json"):
        from transport.verification.scene_file import experiment_of_file

        return experiment_of_file(name)
    if name.endswith(".py"):
        path = Path(name)
        if not path.is_file():
            folder, cure = (
                path.parent.resolve(),
                "give its path, or an experiment's name, which `transport` lists",
            )
            raise SceneError(f"no file {path.name} in {folder}; {cure}")
        spec = importlib.util.spec_from_file_location(path.stem, path)
        module = importlib.util.module_from_spec(spec)
        with attribute_errors(module):
            spec.loader.exec_module(module)
        return module
    names = experiment_names()
    if name not in names:
        raise SceneError(f"no experiment {name!r}; {name_hint(name, names)}")
    return importlib.import_module(f"{SIMS}.{name}")


def experiment_name(module: ModuleType) -> str:
    """Name of the experiment, as `run` accepts it."""
    return module.__name__.removeprefix(f"{SIMS}.")


@contextmanager
def attribute_errors(module: ModuleType, settings: Mapping[str, object] | None = None) -> Iterator[None]:
    """Convert an exception in an experiment's own code into a SceneError that names settings or place."""
    try:
        yield
    except Exception as error:
        refused = isinstance(error, (SceneError, UnitError))
        message = str(error) if refused else f"{type(error).__name__}: {getattr(error, 'msg', None) or error}"
        if settings:
            values = ", ".join(f"{name}={value!r}" for name, value in settings.items())
            raise SceneError(f"{experiment_name(module)} with {values}: {message}") from error
        raise SceneError(f"{_place(module, error)}: {message}") from error


def _place(module: ModuleType, error: Exception) -> str:
    """File and line where the experiment's code failed."""
    if isinstance(error, SyntaxError):
        return f"{Path(error.filename or '').name}, line {error.lineno}"
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if frame.filename == module.__file__]
    frame = own[-1] if own else frames[-1]
    return f"{Path(frame.filename).name}, line {frame.lineno}"


def cases_of(module: ModuleType, settings: dict[str, object]) -> list[dict[str, object]]:
    """Parameter sets of an experiment's table, with the user's settings in each.

    Raises SceneError for a setting that is not a parameter of the experiment's `scene`.
    """
    known = inspect.signature(module.scene).parameters
    for name in settings:
        if name not in known:
            raise SceneError(f"{module.__name__}: no parameter {name!r}; {name_hint(name, known)}")
        default, value = known[name].default, settings[name]
        if isinstance(default, int | float) and isinstance(value, str):
            raise SceneError(f"{module.__name__}: {name} must be a number, got {value!r}")
    with attribute_errors(module):
        cases = module.cases() if hasattr(module, "cases") else [{}]
        merged = [case | settings for case in cases]
    if not merged:
        raise SceneError(f"{module.__name__}: cases() returns no case; leave it out, or return [{{}}]")
    return [case for i, case in enumerate(merged) if case not in merged[:i]]


def defaults_of(function: Callable[..., object]) -> dict[str, object]:
    """Default values of a function's parameters."""
    known = inspect.signature(function).parameters.values()
    return {each.name: each.default for each in known if each.default is not inspect.Parameter.empty}


def parameter_unit(module: ModuleType, name: str) -> str:
    """Unit of a parameter of an experiment's `scene`, as its docstring gives it; "1" if it gives none.

    Docstrings give it as "radius [m]" or "radius: of the ball [m]".
    """
    text = " ".join((inspect.getdoc(module.scene) or "").split())
    found = re.search(rf"(?:^|[;.] ){re.escape(name)}(?:: [^;.\[]*)? \[([^\]]+)\]", text)
    return found[1] if found else "1"


def scene_of(module: ModuleType, parameters: dict[str, object], settings: dict[str, object]) -> Scene:
    """Scene with these parameters. Raises SceneError if the experiment's code fails."""
    with attribute_errors(module, settings):
        return module.scene(**parameters)


def run_experiment(module: ModuleType, settings: dict[str, object] | None = None, **limits) -> list[Outcome]:
    """Run each case of an experiment.

    limits: as for `simulate`; particles and the method default to the module's own.
    """
    return list(iterate_outcomes(module, settings or {}, limits))


def iterate_outcomes(
    module: ModuleType,
    settings: dict[str, object],
    limits: dict[str, object],
    save: Path | None = None,
    overwrite: bool = False,
) -> Iterator[Outcome]:
    """Yield each case of the experiment when it is done; after Ctrl-C the last one is incomplete.

    limits: as for `simulate`; without any, the module's number of particles and method. A case without a
    quantity named in `error` runs without that error, with a warning. save: file of each run; with several
    cases the number of the case is added to the names of all files: run_1.nc, run_2.nc. If it cannot be
    written at the end, the case is still yielded. overwrite: whether it may replace files other than those
    that the run continues.
    """
    if save is not None:
        checked_destination("save", save)
    # Build and check all scenes before any of them runs.
    ready, intended = [], intended_of(module)
    for parameters in cases_of(module, settings):
        scene = scene_of(module, parameters, settings)
        if scene in [known for _, known, *_ in ready]:  # the settings override the parameters that differ
            continue
        if save is not None:
            scene_text(scene)  # raise before the run if no file can hold the scene
        with attribute_errors(module, settings):
            exact = dict(module.exact(**parameters)) if hasattr(module, "exact") else {}
        ready.append((parameters, scene, exact, *_feasible_errors(scene, limits.get("error"))))
    # Raise for quantities that no case has.
    for name, refusal in ready[0][-1].items():
        if all(name in refusals for *_, refusals in ready):
            raise refusal
    files = [
        _with_case_number({"save": save} | limits, number if len(ready) > 1 else None)
        for number in range(1, len(ready) + 1)
    ]
    _check_files(module, files, limits, overwrite)
    # Run one case after the other.
    for number, (own, (parameters, scene, exact, errors, refusals)) in enumerate(
        zip(files, ready, strict=True)
    ):
        file = own.pop("save")
        chosen = _with_defaults(module, own | {"error": errors, "seed": case_seed(own, number)})
        result = simulate_all_quantities(scene, **chosen)
        failure = None if file is None else _try_to_save(result, file)
        notes = tuple(f"run without the requested error: {refusal}" for refusal in refusals.values())
        notes += () if failure is None else (f"{NOT_SAVED}: {failure}",)
        rows = _rows(module, result, exact)
        with attribute_errors(module):
            bins = module.in_bins(result) if hasattr(module, "in_bins") else {}
        read = result._read_scores()
        given = defaults_of(module.scene) | parameters
        yield Outcome(parameters, result, rows, notes, bins, given, read, intended, number)
        if not result.is_complete:
            return


def case_seed(limits: Mapping[str, object], number: int) -> int | None:
    """Return the seed of a case: each has random numbers of its own; None for one that is continued."""
    seed = limits.get("seed")
    if seed is None and limits.get("resume") is not None and Path(limits["resume"]).exists():
        return None
    return (seed or 0) + SEEDS_APART * number


def _check_files(
    module: ModuleType, files: list[dict[str, object]], limits: dict[str, object], overwrite: bool
) -> None:
    """Refuse to overwrite other runs, and to continue one run with several cases, before any is run."""
    for own in files:
        if own["save"] is not None and own["save"] != own.get("resume"):
            check_not_existing("--save", own["save"], overwrite)
    resume = limits.get("resume")
    if len(files) > 1 and resume is not None and Path(resume).exists() and not files[0]["resume"].exists():
        own = f"{files[0]['resume'].name} to {files[-1]['resume'].name}"
        raise SceneError(
            f"--resume: {resume} is one run, and {experiment_name(module)} has {len(files)} cases, whose"
            f" files are {own}"
        )


def _try_to_save(result: Result, file: Path) -> FileError | None:
    """Save the run; return the error if the disk is full or the like."""
    try:
        result.save(file)
    except FileError as error:
        return error
    return None


def _with_case_number(limits: dict[str, object], number: int | None) -> dict[str, object]:
    """The limits, with the number of the case added to the names of files."""
    files = (
        {}
        if number is None
        else {name: limits[name] for name in FILE_SETTINGS if limits.get(name) is not None}
    )
    return limits | {name: path.with_stem(f"{path.stem}_{number}") for name, path in files.items()}


def _feasible_errors(
    scene: Scene, errors: Mapping[str, float] | None
) -> tuple[dict | None, dict[str, SceneError]]:
    """Relative errors that this scene can be run for, and the exceptions of the others."""
    found, refusals = {}, {}
    for name, target in (errors or {}).items():
        try:
            found |= checked_limits(scene, None, {name: target}, None, 32).error
        except SceneError as refusal:
            refusals[name] = refusal
    return found or None, refusals


def _with_defaults(module: ModuleType, limits: dict[str, object]) -> dict[str, object]:
    """The limits, completed by the module's method and number of particles."""
    limits = run_settings_of(module) | {name: value for name, value in limits.items() if value is not None}
    goes_on = "resume" in limits and Path(limits["resume"]).exists()  # the saved run has limits of its own
    if goes_on or any(name in limits for name in ("particles", "error", "seconds")):
        return limits
    return limits | {"particles": getattr(module, "particles", DEFAULT_PARTICLES)}


def run_settings_of(module: ModuleType) -> dict[str, object]:
    """Default settings of an experiment, its `run`. Raises SceneError for settings that it may not have."""
    settings = getattr(module, "run", {})
    if not isinstance(settings, Mapping):
        example = "{'estimator': 'backward'}"
        raise SceneError(
            f"{experiment_name(module)}: run must be settings such as {example}, got {short_repr(settings)}"
        )
    for name in settings:
        if name not in RUN_SETTINGS:
            raise SceneError(
                f"{experiment_name(module)}: run has no setting {name!r};"
                f" {name_hint(str(name), RUN_SETTINGS)}"
            )
    return dict(settings)


def intended_of(module: ModuleType) -> dict[str, str]:
    """What diagnostics find as the experiment means it, its `intended`: {name of the diagnostic: reason}.

    Raises SceneError for a name that the table of diagnostics lacks.
    """
    intended = dict(getattr(module, "intended", {}))
    known = [check.name for check in DIAGNOSTICS]
    for name in intended:
        if name not in known:
            raise SceneError(
                f"{experiment_name(module)}: intended has no diagnostic {name!r}; {name_hint(name, known)}"
            )
    return intended


def _rows(module: ModuleType, result: Result, exact: Mapping[str, float]) -> tuple[Row, ...]:
    """Table of the measured quantities. Raises SceneError if `measure` returns anything else."""
    with attribute_errors(module):
        measured = module.measure(result)
    if not isinstance(measured, Mapping):
        raise SceneError(
            f"{experiment_name(module)}: measure must return {{name: Estimate}}, got {short_repr(measured)}"
        )
    for name, estimate in measured.items():
        if not isinstance(estimate, Estimate):
            raise SceneError(
                f"{experiment_name(module)}: measure must return an Estimate for {name!r}, got"
                f" {short_repr(estimate)}; of an array take .sum() or one bin"
            )
    return tuple(Row(name, estimate, exact.get(name, math.nan)) for name, estimate in measured.items())
