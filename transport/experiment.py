"""An experiment is a module: a scene, what is measured in it, the exact values, a question and a verdict.

    law: str                                  the law in a line, with its source
    question: str                             what is asked, in a sentence
    particles: int                            histories of a case by default
    cases() -> list of dict                   the parameter sets of its table; missing: one, the defaults
    scene(**parameters) -> Scene
    measure(result) -> {name: Estimate}
    exact(**parameters) -> {name: float}
    verdict(outcomes) -> str                  the answer, in a sentence
    draw(outcomes, path)                      the figure, a PNG; returns the paths where there are more than one

The modules of the package `sims` are experiments; so is any file of the user's.
"""

import importlib
import importlib.util
import inspect
import pkgutil
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

from transport.estimates import Estimate
from transport.results import Result
from transport.simulate import simulate
from transport.validation import SceneError, suggestion


@dataclass(frozen=True)
class Row:
    """One line of an experiment's table."""

    name: str
    estimate: Estimate
    exact: float

    @property
    def z(self) -> float:
        """How many standard errors the estimate is off, as a standard normal score."""
        return self.estimate.z(self.exact)


@dataclass(frozen=True)
class Outcome:
    """One case of an experiment: its parameters, the run, and its table."""

    parameters: dict[str, object]
    result: Result
    rows: tuple[Row, ...]

    def __getitem__(self, name: str) -> Row:
        return next(row for row in self.rows if row.name == name)

    @property
    def title(self) -> str:
        """Its parameters in a line."""
        return ", ".join(
            f"{name}={value:.6g}" if isinstance(value, float) else f"{name}={value}"
            for name, value in self.parameters.items()
        )


def experiment_names() -> list[str]:
    """The experiments that are installed, by name."""
    sims = importlib.import_module("sims")
    return sorted(module.name for module in pkgutil.iter_modules(sims.__path__))


def experiment(name: str) -> ModuleType:
    """The experiment of that name in `sims`, or in the file at that path.  Raises SceneError for neither."""
    if name.endswith(".py"):
        path = Path(name)
        if not path.is_file():
            raise SceneError(f"run: no file {name}")
        spec = importlib.util.spec_from_file_location(path.stem, path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module
    names = experiment_names()
    if name not in names:
        raise SceneError(f"run: no experiment {name!r}; {suggestion(name, names)}")
    return importlib.import_module(f"sims.{name}")


def cases_of(module: ModuleType, settings: dict[str, object]) -> list[dict[str, object]]:
    """The parameter sets of an experiment's table, with the user's settings in each.

    Raises SceneError for a setting that the experiment's `scene` does not have.
    """
    known = inspect.signature(module.scene).parameters
    for name in settings:
        if name not in known:
            raise SceneError(f"{module.__name__}: no parameter {name!r}; {suggestion(name, known)}")
    cases = module.cases() if hasattr(module, "cases") else [{}]
    merged = [case | settings for case in cases]
    return [case for i, case in enumerate(merged) if case not in merged[:i]]


def run_experiment(module: ModuleType, settings: dict[str, object] | None = None, **limits) -> list[Outcome]:
    """Run each case of an experiment.  limits: as for `simulate`; `particles` is the module's own where none is given."""
    if all(limits.get(name) is None for name in ("particles", "error", "seconds")):
        limits["particles"] = module.particles
    outcomes = []
    for parameters in cases_of(module, settings or {}):
        result = simulate(module.scene(**parameters), **limits)
        exact = module.exact(**parameters)
        measured = module.measure(result)
        outcomes.append(Outcome(parameters, result, tuple(Row(n, e, exact[n]) for n, e in measured.items())))
    return outcomes
