"""The experiments: each module a short paper with derivation, scene, exact values and figure.

What they have in common is described in transport/verification/experiment.py.  `python -m transport.sims.sun` runs one and prints its table, and
`transport run sun` does so with its picture.
"""

from __future__ import annotations

if __name__ == "sims":
    raise ImportError("'sims' is a part of transport now: import transport.sims")

import inspect
from collections.abc import Callable, Collection, Sequence
from functools import wraps
from pathlib import Path
from typing import NamedTuple

import numpy as np

from transport import Estimate, Result, SceneError
from transport.statistics.notation import with_thousands_spaces
from transport.theory.enclosures import chi_square_values
from transport.verification.experiment import Outcome, Row, defaults_of, experiment, run_experiment

ROUNDING = 1e-12  # of the terms of a difference: what is smaller is left over from their cancellation

Selection = Callable[[Sequence[Outcome]], Sequence[Outcome]]  # outcomes -> those that a figure shows
Drawing = Callable[..., object]  # (outcomes, path=, note=): draws them


# ---- parameters ----


def of_scene(scene: Callable[..., object]) -> Callable[[Callable], Callable]:
    """Decorate a function of some of the scene's parameters: it takes all of them, with the scene's defaults."""

    def decorate(function: Callable) -> Callable:
        names = inspect.signature(function).parameters

        @wraps(function)
        def completed(**parameters: object) -> object:
            given = defaults_of(scene) | parameters
            unknown = [name for name in given if name not in inspect.signature(scene).parameters]
            if unknown:
                raise TypeError(f"{function.__name__}() got unknown parameters: {', '.join(unknown)}")
            return function(**{name: given[name] for name in names})

        return completed

    return decorate


def one_of(sim: str, **choices: tuple[object, Collection]) -> None:
    """Raise SceneError for a parameter that is not one of its known values.  choices: name=(value, known values)."""
    for name, (value, known) in choices.items():
        if value not in known:
            words = ", ".join(map(str, known))
            raise SceneError(f"{sim}: {name} must be one of {words}, got {value!r}")


def require(sim: str, **checks: tuple[object, bool, str]) -> None:
    """Raise SceneError for a parameter out of its range.  checks: name=(value, whether it is allowed, what it must be)."""
    for name, (value, is_allowed, must) in checks.items():
        if not is_allowed:
            raise SceneError(f"{sim}: {name} must be {must}, got {value}")


# ---- estimates ----


def constant(result: Result, value: float, unit: str) -> Estimate:
    """A known number with its unit, to calculate with the estimates of a run."""
    return Estimate(np.full(len(result.run), value), result.run, unit, exact=True)


def sharp(estimate: Estimate, of: Estimate) -> Estimate:
    """The estimate, labelled exact where its batches differ by no more than the rounding of `of`.

    For what is the same in every history although it is calculated from random sums; what the cancellation of sums of
    the size of `of` leaves is 0 then.
    """
    rounding = ROUNDING * abs(of.value)
    if not np.ptp(estimate.values) <= rounding:
        return estimate
    value = 0.0 if abs(estimate.value) <= rounding else estimate.value
    return Estimate(np.full(len(estimate.run), value), estimate.run, estimate.unit, exact=True)


# ---- radiance in equilibrium ----


class Deviations(NamedTuple):
    """What the bins of radiance are off in each batch, over what is expected, (B, K) [1], and their throughputs, (K,)."""

    result: Result
    values: np.ndarray
    weights: np.ndarray

    def chi_square(self) -> Estimate:
        """X² over its expectation: 1 where all bins hold what is expected."""
        run = self.result.run
        return Estimate(chi_square_values(self.values, self.weights, run.sizes), run, "1")

    def mean(self) -> Estimate:
        """Radiance over the expected one, the mean over all bins by throughput."""
        return Estimate(1 + self.values @ self.weights / self.weights.sum(), self.result.run, "1")


# ---- answers ----


def provenance(outcomes: list[Outcome]) -> str:
    """Particles and seed of the runs, for the small print of a figure."""
    particles, seed = max(o.result.particles for o in outcomes), outcomes[0].seed
    return f"{with_thousands_spaces(particles)} particles per case, seed {seed}"


def main(path: str) -> None:
    """Run the experiment of this file and print its tables and its verdict."""
    module = experiment(path)
    outcomes = run_experiment(module)
    print(module.law)
    for outcome in outcomes:
        print(f"\n{outcome.title}")
        for row in outcome.rows:
            print(f"  {row.name:42s} {row.estimate!s:46s} exact {row.exact:<12.6g} z {row.z:+.2f}")
    print(f"\n{module.verdict(outcomes)}")


def where(**given: object) -> Selection:
    """Select the outcomes with these parameters; of a tuple any value will do."""
    wanted = {name: value if isinstance(value, tuple) else (value,) for name, value in given.items()}
    return lambda outcomes: [o for o in outcomes if all(o.given[n] in known for n, known in wanted.items())]


def holding(name: str) -> Selection:
    """Select the outcomes whose results have a detector of that name."""
    return lambda outcomes: [o for o in outcomes if name in o.result]


def several(select: Selection) -> Selection:
    """Select those outcomes if they are more than one."""
    return lambda outcomes: found if len(found := select(outcomes)) > 1 else []


def in_space(select: Selection) -> Selection:
    """Select those outcomes if this machine can draw in 3-D."""

    def chosen(outcomes: Sequence[Outcome]) -> Sequence[Outcome]:
        from transport.viz.screen import has_screen

        return select(outcomes) if has_screen() else []

    return chosen


def others(select: Selection) -> Selection:
    """Select all other outcomes."""
    return lambda outcomes: [o for o in outcomes if o not in select(outcomes)]


def grouped(outcomes: Sequence[Outcome], *names: str) -> dict[object, list[Outcome]]:
    """The outcomes by their value of a parameter, or by their values of several, in a tuple."""
    found: dict[object, list[Outcome]] = {}
    for outcome in outcomes:
        values = tuple(outcome.given[name] for name in names)
        found.setdefault(values if len(names) > 1 else values[0], []).append(outcome)
    return found


def furthest(outcomes: Sequence[Outcome]) -> str:
    """How far off the worst of all readings is, in words for a verdict."""
    rows = [row for outcome in outcomes for row in outcome.rows]
    scores = [abs(row.z) for row in rows if np.isfinite(row.z)]
    if not scores:
        return "no reading has an error bar"
    if len(rows) == 1:
        return f"{scores[0]:.1f} standard errors off"
    return f"the furthest of {len(scores)} readings is {max(scores):.1f} standard errors off"


def sentence(*clauses: str) -> str:
    """The clauses as one sentence."""
    words = "; ".join(clauses)
    return f"{words[:1].upper()}{words[1:]}."


# ---- figures ----


def figures(
    **parts: Drawing | tuple[Drawing, Selection],
) -> Callable[[Sequence[Outcome], str], list[Path]]:
    """The `draw` of an experiment: how each figure is drawn, and of which outcomes if not of all.

    A figure without outcomes is left out.  The first one is drawn at the path, each other with its name behind the
    path's; `note` is the provenance of its outcomes.  Where there would be none, all rows are drawn.
    """

    def draw(outcomes: Sequence[Outcome], path: str) -> list[Path]:
        path, paths = Path(path), []
        pairs = {word: part if isinstance(part, tuple) else (part, list) for word, part in parts.items()}
        shown = {word: (drawing, found) for word, (drawing, of) in pairs.items() if (found := of(outcomes))}
        for word, (drawing, found) in (shown or {"rows": (draw_rows, outcomes)}).items():
            paths.append(path.with_stem(f"{path.stem}_{word}") if paths else path)
            drawing(found, path=paths[-1], note=provenance(found))
        return paths

    return draw


def curves_figure(**labels: object) -> Callable[[Callable[[list[Outcome]], dict[str, object]]], Drawing]:
    """Decorate a function of outcomes that returns arguments of `plot_curves`: it becomes their drawing.

    labels: the arguments that are the same for all outcomes;  each series is the fields of a viz.Series, in a tuple.
    """

    def decorate(curves: Callable[[list[Outcome]], dict[str, object]]) -> Drawing:
        @wraps(curves)
        def draw(outcomes: list[Outcome], path: Path, note: str) -> None:
            from transport.viz.curves import Series, plot_curves

            found = {"note": note} | labels | curves(outcomes)
            series = found.pop("series")
            if isinstance(series, dict):
                plot_curves({label: Series(*fields) for label, fields in series.items()}, path, **found)
            else:
                plot_curves(Series(*series), path, **found)

        return draw

    return decorate


def rows_figure(
    title: str,
    label: Callable[[Row, Outcome], str] | None = None,
    keep: Callable[[Row], bool] = lambda row: True,
) -> Drawing:
    """A drawing of readings beside their exact values.  label: of a row, with its case;  keep: whether to show it."""
    return lambda outcomes, **out: draw_rows(outcomes, title=title, label=label, keep=keep, **out)


def draw_rows(
    outcomes: Sequence[Outcome],
    path: Path,
    note: str,
    title: str | None = None,
    label: Callable[[Row, Outcome], str] | None = None,
    keep: Callable[[Row], bool] = lambda row: True,
) -> None:
    """Every reading of every case beside its exact value."""
    from transport.viz.comparisons import comparison

    has_titles = len(outcomes) > 1  # that of a single case would stand at every row
    words = label or (lambda row, outcome: "\n".join(filter(None, (row.name, has_titles and outcome.title))))
    rows = [(words(row, outcome), row) for outcome in outcomes for row in outcome.rows]
    table = {
        name: (row.estimate, row.exact) for name, row in [each for each in rows if keep(each[1])] or rows
    }
    comparison(table, path, title=title, note=note)
