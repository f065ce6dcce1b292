"""Tally: the sums of one detector over its axes, and how each of its quantities is made of them.

    quantity = sum of a score, along some of the axes, over the measures that it is a density in

A kind of detector is a subclass: axes, scores, measures, and one line per quantity.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property, partial, reduce
from operator import add
from typing import TYPE_CHECKING, Any, ClassVar, Self, overload

import numpy as np

from transport.compile.rows import Rows
from transport.renderers import function_for
from transport.results.batches import Batch
from transport.statistics.axes import Axis
from transport.statistics.batches import MIN_SCORES_FOR_ERROR
from transport.statistics.chunked import ChunkedArray, batch_totals, is_large, over_batches, summed_counts
from transport.statistics.estimates import Batches, Estimate, EstimateArray, EstimateOrArray
from transport.statistics.findings import FEW_CARRIERS, Finding, doubtful
from transport.units import Unit
from transport.validation import SceneError, name_hint, optional_packages, short_repr

if TYPE_CHECKING:
    from os import PathLike

    import pandas
    import xarray
    from matplotlib.axes import Axes

Column = Callable[[Batch, int, int], np.ndarray]  # the rows of a batch from one number up to another
Lacks = Mapping[str, tuple[str, str]]  # need: (what is needed, what to type)
ARRIVALS, DEPARTURES = 0, 1  # sides of a surface ...
SIDES = ("in", "out")  # ... and how their scores and quantities end
# A batch with more than this share of the variance of all is an outlier of a long tail: of normal scores one
# mean in 10^4 has one in so many batches.
LONE_SHARE, MIN_BATCHES_FOR_TAILS = 0.5, 32
NO_CLOCK = ("a clock", "write Scene(..., duration=...)")


@dataclass(frozen=True, eq=False)
class Score:
    """A number that is added up, and what a sum of 1 means.

    Parameters
    ----------
    rows : Rows
        Where the sums lie.
    column : callable
        column(batch, first, past) returns the sums in these rows.
    counts : callable
        The numbers of scores in the same way.
    unit : str
        Unit of the score: "J" of a weight (power per second of the clock), "J m" of a path.
    scale : float
        The value of a sum of 1, in this unit, for the whole run.
    is_dark : callable
        Whether geometry proves that nothing scores.
    is_sure : callable
        Whether every history scores the same in all bins together, so that the sum has no error.
    is_mean : bool
        Whether the column holds means over the histories of a cell (backward runs), not sums over the run.
    findings : callable or None
        findings(is_whole) returns the findings, with bounds for a mean score of 1 per history, of all bins
        together or of single ones.
    largest : float or callable
        The score of a missing particle relative to those bounds; of parts a function that returns them all.
    notes : callable
        Findings of this score alone, whose bounds are not scaled.
    parts : Axis or None
        The axis of a score of several parts, such as one per medium; columns then return (parts, rows).
    """

    rows: Rows
    column: Column
    counts: Column
    unit: str
    scale: float = 1.0
    _: KW_ONLY
    is_dark: Callable[[], bool] = lambda: False
    is_sure: Callable[[], bool] = lambda: False
    is_mean: bool = False
    findings: Callable[[bool], Iterable[Finding]] | None = None
    largest: float | Callable[[], np.ndarray] = 1.0
    notes: Callable[[], Iterable[Finding]] = tuple
    parts: Axis | None = None


@dataclass(frozen=True, eq=False)
class Measure:
    """The size of each bin: seconds, area, solid angle, volume.

    values: of the shape of `axes`, nan for a bin of size 0;  unit: such as "m^2";  axes: names.
    """

    values: np.ndarray | float
    unit: str
    axes: tuple[str, ...] = ()

    def along(self, axes: Sequence[Axis]) -> np.ndarray | float:
        """Return the values in the shape of an array with these axes; a number where they are one."""
        if not self.axes:
            return self.values
        return np.reshape(self.values, [len(axis) if axis.name in self.axes else 1 for axis in axes])


# ---- Quantities: each is a line in the class of its detector.


class _Named:
    """Base class: a quantity as an attribute of a tally, computed when it is read and then kept.

    doc: its meaning, with symbol and unit;  needs: what the scene or the detector must have (Tally.lacks).
    """

    name: str

    def __init__(self, doc: str, needs: tuple[str, ...] = ()) -> None:
        self.__doc__, self.needs = doc, needs

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @property
    def summary(self) -> str:
        """The first paragraph of its meaning, in one line."""
        return " ".join(inspect.cleandoc(self.__doc__ or "").partition("\n\n")[0].split())

    if TYPE_CHECKING:

        @overload
        def __get__(self, tally: None, kind: type) -> Self: ...
        @overload
        def __get__(self, tally: object, kind: type) -> EstimateOrArray: ...

    def __get__(self, tally: Any, kind: type) -> Any:
        if tally is None:
            return self
        tally.require(self.name, self.needs)
        value = vars(tally)[self.name] = self.of(tally)
        return value

    def of(self, tally: Any) -> EstimateOrArray:
        """Return the quantity of a tally."""
        raise NotImplementedError


class Quantity(_Named):
    """A density of scores.

    score: name of a score, or several, which are added;  by: groups of inner axes to keep where the detector
    has them, while all others are summed over;  per: names of measures to divide by, in this order.
    """

    def __init__(
        self,
        doc: str,
        score: str | tuple[str, ...],
        by: tuple[str, ...] = (),
        per: tuple[str, ...] = (),
        needs: tuple[str, ...] = (),
    ) -> None:
        super().__init__(doc, needs)
        self.scores = (score,) if isinstance(score, str) else score
        self.by, self.per = by, per

    def of(self, tally: Tally) -> EstimateOrArray:
        """Return the density."""
        return reduce(add, [tally.estimate(score, self.by, self.per) for score in self.scores])


class MeanPerWeight(_Named):
    """A mean per weight: the sum of a score over the sum of weights; of too few scores without an error."""

    def __init__(
        self, doc: str, score: str, weight: str, by: tuple[str, ...] = (), needs: tuple[str, ...] = ()
    ) -> None:
        super().__init__(doc, needs)
        self.score, self.weight, self.by = score, weight, by

    def of(self, tally: Tally) -> EstimateOrArray:
        """Return the mean."""
        mean = tally.estimate(self.score, self.by) / tally.estimate(self.weight, self.by)
        counts = over_batches(tally.counts_of(self.score, self.by)).reshape(np.shape(mean.value))
        sums, has_parts = tally.sums(self.score, self.by), tally.scores[self.score].parts is not None
        if tally.has_equal_means and not has_parts:  # of one speed, so that missing particles do not matter
            mean = mean._with_findings((), mean.allowed)
        if has_parts and isinstance(sums, np.ndarray):
            # How many of the scores were above 0 is not counted.
            counts = np.minimum(counts, _scores_by_batches(sums))
            mean = mean._with_findings(partial(_with_lone_batches, mean, mean._unjudged), mean.allowed)
        return mean.unless(counts < MIN_SCORES_FOR_ERROR)


def _scores_by_batches(sums: np.ndarray) -> np.ndarray:
    """Return about how many scores above 0 there were, from the share of batches with one (Poisson)."""
    share = over_batches(sums != 0) / len(sums)
    with np.errstate(divide="ignore"):
        return np.round(-len(sums) * np.log1p(-share))


def _with_lone_batches(mean: EstimateOrArray, findings: Any) -> Iterator[Finding]:
    """Yield the findings of a mean, and one where a single batch has most of the variance (a long tail)."""
    yield from findings() if callable(findings) else findings
    squares = np.square(np.nan_to_num(mean.values - mean.value))
    is_lone = squares.max(axis=0) > LONE_SHARE * squares.sum(axis=0)
    if len(squares) >= MIN_BATCHES_FOR_TAILS and is_lone.any():
        what = "a few very long paths, which one batch has and the others have not"
        yield doubtful(FEW_CARRIERS, what, np.where(is_lone, np.inf, 0.0))


class Formula(_Named):
    """A quantity made of other quantities of the same tally, with their correlations."""

    def __init__(
        self, doc: str, formula: Callable[[Any], EstimateOrArray], needs: tuple[str, ...] = ()
    ) -> None:
        super().__init__(doc, needs)
        self.of = formula


def scores_behind(kind: type, quantity: str) -> tuple[str, ...]:
    """Return the names of the scores of which a quantity of this kind of tally is made; () if unknown."""
    match getattr(kind, quantity, None):
        case Quantity(scores=scores):
            return scores
        case MeanPerWeight(score=score, weight=weight):
            return score, weight
    return ()


class Tally:
    """Base class of all tallies: the quantities of a detector by name.

    Attributes
    ----------
    name : str
        Name of the detector.
    known : tuple of str
        Names of its quantities.
    main : tuple of str
        Names of the scores whose totals are diagnosed.
    diagnosis : Diagnosis
        What the run may have missed of it.
    kind : str
        Kind of detector, as messages and reports call it.
    axes : tuple of Axis
        Axes of its bins, in the order of the dimensions of its quantities.
    scores, measures : dict
        By name; measures are functions, called when they are needed.
    lacks : dict
        What the scene or the detector was not set up for, by need.
    has_equal_means : bool
        Whether all particles have one speed, so that means do not depend on missing ones.
    """

    name: str
    known: ClassVar[tuple[str, ...]] = ()
    main: ClassVar[tuple[str, ...]] = ()
    kind = "detector"
    axes: tuple[Axis, ...] = ()
    scores: Mapping[str, Score]
    measures: Mapping[str, Callable[[], Measure]]
    batches: Sequence[Batch]
    run: Batches
    plan: Any
    scene: Any
    shape: Any
    detector: Any
    diagnosis: Any
    has_equal_means = False

    def __init__(self, result: Any, detector: Any) -> None:
        self.plan, self.scene = result.plan, result.plan.scene
        self.detector, self.name = detector, detector.name
        self.batches, self.run = result.batches, result.run
        self.diagnosis = result.diagnosis_of(self)

    def __getstate__(self) -> dict[str, Any]:
        # What is computed when it is read is computed anew; scores hold functions, which cannot be pickled.
        kept = (
            name for name in vars(self) if not isinstance(getattr(type(self), name, None), cached_property)
        )
        return {name: vars(self)[name] for name in kept}

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if "known" not in vars(cls):
            own = tuple(name for name, each in vars(cls).items() if isinstance(each, _Named))
            cls.known = (*own, *(name for name in cls.known if name not in own)) if own else cls.known

    @cached_property
    def lacks(self) -> Lacks:
        """What the scene or the detector was not set up for, by need."""
        return self.lacks_of(self.scene, self.detector)

    @staticmethod
    def lacks_of(scene: Any, detector: Any) -> Lacks:
        """Return what a scene or a detector was not set up for, by need; known before a run."""
        return {}

    def require(self, name: str, needs: Iterable[str]) -> None:
        """Raise SceneError where the scene or the detector lacks what a quantity needs."""
        for what, cure in (self.lacks[need] for need in needs if need in self.lacks):
            kind = type(self.detector).__name__
            raise SceneError(f"{kind} {self.name!r}: {name} needs {what}; {cure}")

    def named(self, name: str) -> EstimateOrArray:
        """Return the quantity of this name; raise SceneError if there is none."""
        if not isinstance(name, str) or name not in self.known:
            kind = type(self.detector).__name__
            raise SceneError(f"{kind} {self.name!r}: no quantity {short_repr(name)}; {self._cure(str(name))}")
        return getattr(self, name)

    @property
    def quantities(self) -> dict[str, EstimateOrArray]:
        """All quantities for which the detector has the options.

        Returns
        -------
        dict of str to Estimate or EstimateArray
        """
        return {name: getattr(self, name) for name in self.available}

    @property
    def available(self) -> tuple[str, ...]:
        """Names of the quantities for which scene and detector have the options.

        Returns
        -------
        tuple of str
        """
        return tuple(name for name in self.known if not self.lacks.keys() & getattr(type(self), name).needs)

    @property
    def bin_sizes(self) -> dict[str, tuple[tuple[str, ...], np.ndarray, str]]:
        """Sizes of the bins that divide its available quantities (axes, values and unit, by name)."""
        found = {}
        for name in {each: None for quantity in self.available for each in self._measures_of(quantity)}:
            measure = self.measures[name]()
            if axes := [axis for axis in self.axes if axis.name in measure.axes]:
                values = np.reshape(measure.values, [len(axis) for axis in axes])
                found[name] = tuple(axis.name for axis in axes), values, measure.unit
        return found

    def _measures_of(self, quantity: str) -> tuple[str, ...]:
        return getattr(getattr(type(self), quantity), "per", ())

    def to_dataset(self, *names: str) -> xarray.Dataset:
        """Convert to an xarray Dataset (needs xarray).

        Parameters
        ----------
        *names : str
            Names of quantities; without names all that are available.

        Returns
        -------
        xarray.Dataset
            Variables <name> and <name>_error with units, and <name>_doubtful (0 or 1), as in a saved
            run; where bins are too many for memory, none is judged.  Coordinates are the centres of the
            bins, <axis>_low and <axis>_high for their edges, and the sizes of bins by which quantities are
            divided, such as bin_area or bin_projected_solid_angle: a sum of a density times these sizes is
            its integral.

        Examples
        --------
        >>> import transport as tp
        >>> lamp = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
        >>> floor = tp.Surface(tp.Rectangle(center=(0, 0, -1), width=2, height=2), tp.Black(), "floor")
        >>> meter = tp.Detector("floor", positions=tp.Positions(u=4, v=4))
        >>> scene = tp.Scene(lamp, floor, meter)
        >>> data = tp.simulate(scene, particles=1e5, seed=1, progress=False)["floor"].to_dataset()
        >>> flux = (data.irradiance * data.bin_area).sum()
        >>> f"{flux.item():.4f} of {data.flux_in.item():.4f} W"
        '0.1661 of 0.1661 W'
        """
        return function_for(type(self), "to_dataset")(self, *names)

    @property
    def particles(self) -> int:
        """Number of histories of the run.

        Returns
        -------
        int
        """
        return self.run.histories

    @property
    def read_scores(self) -> frozenset[str]:
        """The names of the scores of which quantities were read so far: each is kept when it is read."""
        return frozenset(score for name in vars(self) for score in scores_behind(type(self), name))

    @property
    def title(self) -> str:
        """Kind and name of the detector, as messages call it."""
        return f"{self.kind} {self.name!r}"

    @property
    def heading(self) -> str:
        """Title of the detector in a report."""
        return self.title

    @property
    def is_blind(self) -> bool:
        """Whether the detector has no score.

        Returns
        -------
        bool
        """
        return bool(self.main) and not any(map(self.has_scores, self.main))

    def has_scores(self, score: str) -> bool:
        """Return whether anything scored."""
        return score in self.scores and bool(self.counts_of(score).any())

    def has_weight(self, score: str) -> bool:
        """Return whether a score has a sum."""
        return score in self.scores and bool(self.sums(score).any())

    def binned(self) -> Iterable[tuple[str, EstimateOrArray]]:
        """The quantities by bin, of which a report counts the doubtful bins."""
        return ()

    # ---- sums ----

    def axes_of(self, score: str, by: tuple[str, ...] = ()) -> list[Axis]:
        """Return the axes of a score that are kept: parts, outer ones, and the inner ones of these groups."""
        rows, parts = self.scores[score].rows, self.scores[score].parts
        kept = [axis for axis in self.axes if axis in rows.outer or (axis in rows.inner and axis.group in by)]
        return kept if parts is None else [parts, *kept]

    def sums(self, score: str, by: tuple[str, ...] = ()) -> np.ndarray | ChunkedArray:
        """Return the sums of each batch as the engine counts them, ``(B, *axes kept)``."""
        return self._sums(score, self.scores[score].column, by)

    def counts_of(self, score: str, by: tuple[str, ...] = ()) -> np.ndarray | ChunkedArray:
        """Return the numbers of scores of each batch, ``(B, *axes kept)``."""
        return self._sums(score, self.scores[score].counts, by)

    def number_of(self, score: str) -> int:
        """Return the number of scores in the whole run."""
        return int(batch_totals(self.counts_of(score)).sum())

    def _sums(self, score: str, column: Column, by: tuple[str, ...]) -> np.ndarray | ChunkedArray:
        """Sums of each batch: an array, of many bins made batch by batch, of very many in chunks."""
        axes, rows, batches = self.axes_of(score, by), self.scores[score].rows, self.batches
        shape = (len(batches), *map(len, axes))
        parts = int(self.scores[score].parts is not None)  # axes of parts, in front of those of bins

        def part(box: Sequence[slice] | None, some: Sequence[Batch] = batches) -> np.ndarray:
            box = [slice(0, len(axis)) for axis in axes] if box is None else box
            of_parts = (slice(None), *box[:parts])

            def read(a: int, b: int) -> np.ndarray:
                return np.array([column(batch, a, b) for batch in some])[of_parts]

            return rows.sums(read, axes[parts:], box[parts:])

        if not is_large((len(batches), *map(len, axes[:parts]), *rows.bins)):
            return part(None)
        if not is_large(shape):
            return np.concatenate([part(None, [batch]) for batch in batches])
        farthest = sorted(range(len(axes)), key=lambda k: -rows.strides.get(axes[k].name, 0))
        return ChunkedArray(shape, tuple(farthest), part)

    # ---- from sums to estimates ----

    def estimate(self, score: str, by: tuple[str, ...] = (), per: tuple[str, ...] = ()) -> EstimateOrArray:
        """Return a score as a mean over histories, by the groups of axes `by`, per the measures `per`."""
        what, measures = self.scores[score], [self.measures[name]() for name in per]
        axes, unit, one = self.axes_of(score, by), Unit.parse(what.unit), what.scale
        values, counts = self.sums(score, by) * one, summed_counts(self.counts_of(score, by))
        for measure in measures:
            size, unit = measure.along(axes), unit / Unit.parse(measure.unit)
            values, one = values / size, one / size
        if not what.is_mean:
            values = values / self.run.sizes.reshape(-1, *(1,) * len(axes))
        is_whole = not any(axis in what.rows.inner for axis in axes)
        exact = what.is_dark() or (is_whole and what.is_sure())
        made = self._made(values, unit, axes, counts, exact)
        has_findings = not exact and (what.findings is not None or what.notes is not tuple)
        return self._with_findings(made, what, one) if has_findings else made

    def _made(
        self, values: Any, unit: Unit, axes: Sequence[Axis], counts: Any, exact: bool = False
    ) -> EstimateOrArray:
        """Return batch means ``(B, *axes)`` as an estimate."""
        if not axes:
            return Estimate(values, self.run, unit, exact, int(counts))
        edges = {axis.name: axis.edges for axis in axes}
        units = {axis.name: axis.unit for axis in axes if axis.unit != axis.coordinate.unit}
        return EstimateArray(values, self.run, unit, tuple(edges), edges, counts, exact, units)

    def _with_findings(self, made: EstimateOrArray, score: Score, one: np.ndarray | float) -> EstimateOrArray:
        """Attach the findings of a score; one: the quantity for a mean score of 1."""
        bins = made._replicates.shape

        def findings() -> Iterator[Finding]:
            largest = score.largest
            if callable(largest):
                largest = largest().reshape(-1, *(1,) * (len(bins) - 1))
            each = (np.broadcast_to(one, bins) if bins else float(np.ravel(one)[0])) * largest
            for finding in score.findings(not bins) if score.findings is not None else ():
                yield replace(finding, bound=np.abs(finding.bound * each))
            yield from score.notes()

        return self.diagnosis.judged(made, findings)

    def constant(self, name: str) -> Estimate:
        """Return a measure that is one number, as an exact estimate of this run."""
        measure = self.measures[name]()
        return Estimate(np.full(len(self.run), measure.values), self.run, measure.unit, exact=True)

    def to_dataframe(self, *names: str) -> pandas.DataFrame:
        """Convert quantities to a pandas DataFrame with a row per bin (needs xarray and pandas).

        Parameters
        ----------
        *names : str
            Names of quantities [default: all], as of `to_dataset`.

        Returns
        -------
        pandas.DataFrame
            Columns of `to_dataset`, whose coordinates come first.
        """
        data = self.to_dataset(*names)
        if not data.dims:
            return data.expand_dims("row").to_dataframe().reset_index(drop=True)
        return data.to_dataframe().reset_index()

    def plot(
        self,
        quantity: str | None = None,
        ax: Axes | None = None,
        decades: float | None = None,
        *,
        label: str | None = None,
        cut: bool | float = False,
        unit: str | None = None,
        path: str | PathLike | None = None,
    ) -> Axes:
        """Draw a quantity over one or two axes of bins (needs matplotlib).

        Parameters
        ----------
        quantity : str, optional
            Name of a quantity with bins [default: such as radiance with bins of direction, irradiance with
            bins of position, fluence_rate of cells].
        ax : matplotlib.axes.Axes, optional
            Where to draw [default: a new figure of pyplot, in which a map stands beside that of its relative
            standard error].
        decades : float, optional
            Range of a logarithmic scale, below the greatest value [default: a linear scale].
        label : str, optional
            Name to write in place of that of the quantity; the unit is added.
        cut : bool or float, default False
            A third panel, of a cut through the map: True through the brightest row of bins, a number through
            the row at that coordinate [SI unit].
        unit : str, optional
            Unit to write in place of that of the quantity, such as "lx"; values stay as they are.
        path : path, optional
            File to write the picture to, such as "floor.png" [default: none].

        Returns
        -------
        matplotlib.axes.Axes
            The axes with the values.

        Raises
        ------
        ValueError
            For a quantity without bins, or with more than two axes of them: index or average that array and
            plot the result, as in ``result["floor"].radiance.mean("phi").plot()``.

        Notes
        -----
        Bars are two standard errors; bins without a known error are hollow points, or hatched on grey, and
        bins with a doubtful one are hatched above their colour.  `transport.viz.plot_map` draws cuts
        and exact values too, and panels of a figure.
        """
        with optional_packages("plot"):
            draw = function_for(type(self), "plot")
            return draw(self, quantity, ax, decades, label=label, cut=cut, unit=unit, path=path)

    def _repr_html_(self) -> str:
        return function_for(type(self), "html")(self)

    if not TYPE_CHECKING:  # type checkers would accept any name

        def __getattr__(self, name: str):
            if name.startswith("_"):
                raise AttributeError(name)
            raise AttributeError(f"{self.title} has no quantity {name!r}; {self._cure(name)}")

    def _cure(self, name: str) -> str:
        if name == "to_xarray":
            return "write to_dataset()"
        return name_hint(name, self.available)


def plain_column(name: str) -> Column:
    """Return the column of a batch: "weights", "counts" or "slants"."""
    return lambda batch, first, past: getattr(batch, name)[first:past]


def moment_column(place: int, each: int, base: int = 0, shift: int = 0) -> Column:
    """Return a velocity sum, one of `each` per row; those of rows from `base` on begin at `shift`."""

    def column(batch: Batch, first: int, past: int) -> np.ndarray:
        rows = slice(shift + each * (first - base), shift + each * (past - base))
        return batch.moments[rows].reshape(-1, each)[:, place]

    return column


def energy_unit(plan: Any) -> str:
    """Return the unit of a weight per second of the clock: "J" of light, "1" of particles."""
    return "J" if plan.scene.measured_in == "watts" else "1"


def seconds_of(plan: Any, axes: Sequence[Axis]) -> Measure:
    """Return the length of each bin of time; the duration where time is not binned, 1 s without a clock."""
    times = [axis for axis in axes if axis.name == "time"]
    return Measure(np.diff(times[0].edges), "s", ("time",)) if times else Measure(plan.time_unit, "s")
