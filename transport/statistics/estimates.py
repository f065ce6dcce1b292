"""Estimates with standard error and unit: one number (Estimate) or an array over bins (EstimateArray)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from types import EllipsisType
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar, overload

import numpy as np

from transport.renderers import function_for
from transport.statistics.any_estimate import AnyEstimate, Operand
from transport.statistics.axes import AXES_OF_PLACES, axis_places, axis_unit
from transport.statistics.chunked import release_pages, replicates_of
from transport.statistics.findings import BOUNDED, CONSTANT, DOUBTFUL, NO_SCORE, UNKNOWN, Finding
from transport.statistics.notation import estimate_text, split_format
from transport.statistics.pooling import Pooled
from transport.statistics.replicates import Batches, Replicates
from transport.units import Unit
from transport.validation import name_hint, optional_packages

if TYPE_CHECKING:
    from os import PathLike

    import pandas
    import xarray
    from matplotlib.axes import Axes

__all__ = ["Batches", "Estimate", "EstimateArray", "EstimateOrArray"]

_METHODS_WITH_ERRORS = dict.fromkeys((np.sum, np.nansum), "sum")
_METHODS_WITH_ERRORS |= dict.fromkeys((np.mean, np.nanmean, np.average), "mean")
_EXTREMES = dict.fromkeys((np.min, np.nanmin), "argmin") | dict.fromkeys((np.max, np.nanmax), "argmax")
_BIN_MEMBERS = (
    "plot",
    "sum",
    "mean",
    "min",
    "max",
    "argmin",
    "argmax",
    "shape",
    "dims",
    "to_xarray",
    "to_dataframe",
)


Other = TypeVar("Other", bound=AnyEstimate[Any, Any])
Index = int | np.integer | slice | EllipsisType


class Estimate(AnyEstimate[float, str | None]):
    """One estimated number with its standard error and unit.

    Parameters
    ----------
    values : numpy.ndarray
        Means of the batches [unit], shape (B,).
    run : Batches
        The batches of the run.  Two estimates belong to one run if their `run` is the same object; arithmetic
        then keeps their correlations, batch by batch.
    unit : Unit or str
        Unit of the values, such as "W m^-2".
    exact : bool, default False
        Whether the value is the same for every history by construction; its error is then 0.
    counts : int, optional
        Number of scores; None if it is not known.

    Raises
    ------
    ValueError
        If `values` has another shape than (B,).

    Notes
    -----
    The value is the mean over all histories, and the error is one standard error of that mean from the spread
    of the batches.  Arithmetic (``+ - * / **``, also with numbers) propagates errors with the
    correlations of the run; nonlinear operations use the jackknife (Quenouille 1956; Tukey 1958).
    `float(estimate)` is the bare value.  Estimates have no order: `<` and `>` raise TypeError.

    Examples
    --------
    >>> import numpy as np
    >>> import transport as tp
    >>> from transport.statistics.replicates import Batches
    >>> run = Batches(np.full(8, 100))
    >>> flux = tp.Estimate(np.array([1.0, 1.1, 0.9, 1.05, 0.95, 1.0, 1.02, 0.98]), run, "W")
    >>> print(flux)
    (1.000 ± 0.021) W
    >>> print(2 * flux)
    (2.00 ± 0.04) W
    >>> print(flux / flux)
    1 (exact)
    >>> print(f"{flux:.2f}")
    (1.00 ± 0.02) W
    """

    def __init__(
        self,
        values: np.ndarray,
        run: Batches,
        unit: Unit | str,
        exact: bool = False,
        counts: int | None = None,
    ) -> None:
        if np.ndim(values) != 1:
            got = f"got shape {np.shape(values)}"
            raise ValueError(f"Estimate: values must have one axis, the batches, {got}")
        self._replicates = Replicates.of_batches(values, run, exact, counts)
        self._is_measured = self._is_sum_of_scores = True
        self.unit = coerce_unit(unit)
        self.coords = {}

    if TYPE_CHECKING:  # the result with an EstimateArray is an EstimateArray

        @overload
        def __add__(self, other: Other) -> Other: ...
        @overload
        def __add__(self, other: float | np.number) -> Estimate: ...
        @overload
        def __add__(self, other: np.ndarray) -> Any: ...

        __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = __add__

    def __float__(self) -> float:
        return self.value

    def __str__(self) -> str:
        return self._text()

    def __format__(self, spec: str) -> str:
        """Format the numbers by a specification such as ".3f", the text by one such as ">40", or both."""
        text, number, sign = split_format(spec)
        return format(self._text(number, sign), text)

    def __repr__(self) -> str:
        return f"<Estimate {self}>" if self.exact else f"<Estimate {self}, {self.batches} batches>"

    if not TYPE_CHECKING:  # type checkers would accept any name

        def __getattr__(self, name: str):
            """Raise AttributeError with the closest name, or say that a single number has no bins."""
            if name.startswith("_"):
                raise AttributeError(f"Estimate has no attribute {name!r}")
            names = [each for each in dir(type(self)) if not each.startswith("_")]
            cure = name_hint(name, [*names, "unit"])
            if name in _BIN_MEMBERS:
                bins = "Detector(..., positions=...) or directions=..."
                cure = f"one number has no bins: print it, or give its detector bins, {bins}"
            raise AttributeError(f"Estimate has no attribute {name!r}; {cure}")

    @property
    def _whole(self) -> Estimate:
        return self

    def _text(self, number: str = "", sign: str = "") -> str:
        limit = None
        if self.reason == CONSTANT and np.isfinite(self._unknown_error_limits):
            limit = CONSTANT
        elif self.reason == NO_SCORE and np.isfinite(self._unknown_error_limits) and self._bounds[0] == 0:
            limit = f"{NO_SCORE}: at most {float(self._bounds[1]):.2g} {self.unit}".removesuffix(" 1")
        words = estimate_text(
            self.value, self.error, str(self.unit), self.exact, self.reason, number, sign, limit
        )
        return words + self._finding_text()

    def _finding_text(self) -> str:
        """Text after a known error: the worst finding; "" if none matters."""
        if self.reason not in (None, CONSTANT):  # the reason says more
            return ""
        skipped = UNKNOWN if self.reason == CONSTANT else None  # the text already names this finding
        worst = next((finding for finding in self.findings if finding.name != skipped), None)
        if worst is None:
            return ""
        if worst.severity == DOUBTFUL:
            return f", doubtful: {worst.what}"
        if worst.severity != BOUNDED:
            return ""
        below, above = (float(bound) for bound in self._bounds)
        parts = [f"{bound:.1g} {way}" for bound, way in ((above, "more"), (below, "less")) if bound > 0]
        return f", or up to {' or '.join(parts)}: {worst.what}"

    def _like(
        self, replicates: Replicates, unit: Unit, coords: dict[str, np.ndarray] | None = None
    ) -> Estimate:
        return _from_replicates(replicates, unit, {})


class EstimateArray(AnyEstimate[np.ndarray, np.ndarray]):
    """Estimates over bins, with named axes, bin edges and a unit.

    Parameters
    ----------
    values : numpy.ndarray
        Means of the batches [unit], shape ``(B, *dims)``.
    run : Batches
        The batches of the run, as for Estimate.
    unit : Unit or str
        Unit of the values.
    dims : sequence of str
        Names of the axes, such as ("mu", "phi").
    coords : dict of str to numpy.ndarray
        For each name in `dims` the n + 1 edges of its n bins; "time" may have n instants instead.
    counts : numpy.ndarray, optional
        Number of scores in each bin, shape ``(*dims)``; None if it is not known.
    exact : bool, default False
        As for Estimate.
    axis_units : mapping of str to str, optional
        Units of the axes "u" and "v", which depend on the shape of the detector.

    Raises
    ------
    ValueError
        If `dims`, `coords` and the shape of `values` do not match.

    Notes
    -----
    An element is an Estimate, a slice an EstimateArray.  Arithmetic matches axes by name, and matches plain
    arrays by NumPy's broadcasting.  NumPy functions receive the bare values, except those that would lose
    errors and for which there is a method (`numpy.sum`, `numpy.mean`, ...): they raise TypeError.  The error
    of a bin also uses neighbouring bins; the error of a sum comes from the batches alone.

    Examples
    --------
    >>> import numpy as np
    >>> import transport as tp
    >>> from transport.statistics.replicates import Batches
    >>> run = Batches(np.full(4, 10))
    >>> values = np.array([[1.0, 2.0], [1.1, 2.1], [0.9, 1.9], [1.05, 1.95]])
    >>> flux = tp.EstimateArray(values, run, "W", ("x",), {"x": np.array([0.0, 1.0, 2.0])})
    >>> flux
    <EstimateArray (x: 2) 1.012 to 1.988 W, median relative error 3.2e-02>
    >>> print(flux[0])
    (1.01 ± 0.04) W
    >>> print(flux.sum("x"))
    (3.00 ± 0.08) W
    """

    def __init__(
        self,
        values: np.ndarray,
        run: Batches,
        unit: Unit | str,
        dims: Sequence[str],
        coords: dict[str, np.ndarray],
        counts: np.ndarray | None = None,
        exact: bool = False,
        axis_units: Mapping[str, str] | None = None,
    ) -> None:
        _check_axes(np.shape(values)[1:], dims, coords)
        self._replicates = replicates_of(values, run, exact, counts)
        self._is_measured = self._is_sum_of_scores = True
        self.unit = coerce_unit(unit)
        self.coords = {name: np.array(coords[name], dtype=float) for name in dims}
        self.axis_units = dict(axis_units or {})

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the axes, in order.

        Returns
        -------
        tuple of str
        """
        return tuple(self.coords)

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of bins along the axes.

        Returns
        -------
        tuple of int
        """
        return self._replicates.shape

    def __len__(self) -> int:
        return self.shape[0]

    def __iter__(self) -> Iterator[EstimateOrArray]:
        return (self[i] for i in range(len(self)))

    def __getitem__(self, index: Index | tuple[Index, ...]) -> EstimateOrArray:
        index = _complete_index(index, self.shape)
        replicates = self._replicates.indexed(index)
        coords = {}
        for (name, edges), along, bins in zip(self.coords.items(), index, self.shape, strict=True):
            if isinstance(along, slice):
                start, stop, _ = along.indices(bins)
                coords[name] = edges[start : max(start, stop) + len(edges) - bins]
        made = self._like(replicates, self.unit, coords)
        made = self._pass_findings(made, lambda bound, _: bound[index])
        made._is_sum_of_scores = self._is_sum_of_scores
        made._bars_from = lambda: Pooled(*(np.asarray(each[index]) for each in self._error_bars))
        return made

    def __array__(
        self, dtype: object = None, copy: bool | None = None
    ) -> np.ndarray[Any, np.dtype[np.object_]]:  # so that type checkers take array * estimates for Any
        return np.array(self.value, dtype=dtype)

    def __array_function__(self, function: Callable, types: object, args: tuple, kwargs: dict) -> object:
        if function in _METHODS_WITH_ERRORS:
            method = _METHODS_WITH_ERRORS[function]
            raise TypeError(
                f"numpy.{function.__name__} would lose the errors; use .{method}() or .{method}(dim),"
                f" or numpy.{function.__name__}(estimates.value)"
            )
        if function in _EXTREMES:
            raise TypeError(_refused_extreme(f"numpy.{function.__name__}", _EXTREMES[function]))
        return function(*_values_of(args), **_values_of(kwargs))

    def __float__(self) -> float:
        if self._replicates.value.size != 1:
            raise TypeError(
                f"Only an array of one bin converts to float; this one has bins {self.shape}:"
                " index it or use .value"
            )
        return self._replicates.value.item()

    def sum(self, dim: str | tuple[str, ...] | None = None) -> EstimateOrArray:
        """Sum over bins.

        Parameters
        ----------
        dim : str or tuple of str, optional
            Axis or axes to sum over; None for all.

        Returns
        -------
        Estimate or EstimateArray
            The sum [unit]; an Estimate if no axis is left.  Bins without a score add 0.  Its error comes from
            the batches, with the correlations between bins.

        Raises
        ------
        ValueError
            If the array has no axis of that name.

        Examples
        --------
        >>> import numpy as np
        >>> import transport as tp
        >>> from transport.statistics.replicates import Batches
        >>> counts = np.array([[1.0, 2.0], [3.0, 4.0]])
        >>> edges = {"x": np.array([0.0, 1.0, 3.0])}
        >>> array = tp.EstimateArray(counts, Batches(np.full(2, 5)), "1", ("x",), edges)
        >>> print(array.sum())
        (5.0 ± 2.0)
        """
        replicates, left = self._replicates, list(self.dims)
        axes = tuple(left.index(name) for name in self._axes(dim, "sum"))
        for name in self._axes(dim, "sum"):
            replicates = replicates.summed(axis=left.index(name) - len(left))
            left.remove(name)
        made = self._like(replicates, self.unit, {name: self.coords[name] for name in left})
        made._is_sum_of_scores = self._is_sum_of_scores
        return self._pass_findings(made, lambda bound, adds: _bound_of_sum(bound, axes, adds))

    def _pass_findings(
        self, made: EstimateOrArray, change: Callable[[np.ndarray, bool], np.ndarray]
    ) -> EstimateOrArray:
        """Attach the findings to bins or sums of this array; change: of a bound, (*dims), and `adds`."""

        def findings() -> Iterator[Finding]:
            for finding in self._raw_findings:
                bound = change(np.broadcast_to(finding.bound, self.shape), finding.adds)
                yield replace(finding, bound=float(bound) if np.ndim(bound) == 0 else bound)

        return made._with_findings(findings, self.allowed)

    @property
    def _whole(self) -> Estimate:
        return self.sum()

    def weighted(
        self, matrix: Any, coords: dict[str, np.ndarray], axis_units: Mapping[str, str] | None = None
    ) -> EstimateArray:
        """Weighted sums over all bins, as bins of other axes.

        Parameters
        ----------
        matrix : numpy.ndarray or scipy.sparse array
            Weights, shape (new bins, bins), both in the order of a flattened array.
        coords : dict of str to numpy.ndarray
            Edges of the bins along the new axes.
        axis_units : mapping of str to str, optional
            Units of the new axes "u" and "v".

        Returns
        -------
        EstimateArray
            The sums [unit]. Their errors come from the batches, with the correlations between bins.

        Examples
        --------
        >>> import numpy as np
        >>> import transport as tp
        >>> from transport.statistics.replicates import Batches
        >>> counts = np.array([[1.0, 2.0], [3.0, 4.0]])
        >>> array = tp.EstimateArray(counts, Batches(np.full(2, 5)), "1", ("x",), {"x": np.arange(3)})
        >>> array.weighted(np.array([[0.5, 0.5]]), {"x": np.array([0.0, 2.0])}).value
        array([2.5])
        """
        values = self.values.reshape(len(self.values), -1)
        new = [len(edges) - 1 for edges in coords.values()]
        sums = (matrix @ values.T).T.reshape(len(values), *new)
        made = EstimateArray(sums, self.run, self.unit, tuple(coords), coords, axis_units=axis_units)
        return self._pass_findings(
            made, lambda bound, _: (abs(matrix) @ np.nan_to_num(bound, nan=np.inf).ravel()).reshape(new)
        )

    def mean(self, dim: str | tuple[str, ...] | None = None) -> EstimateOrArray:
        """Mean over bins, unweighted: a wide bin has the same weight as a narrow one.

        Parameters
        ----------
        dim : str or tuple of str, optional
            Axis or axes to average over; None for all.

        Returns
        -------
        Estimate or EstimateArray
            The mean [unit]; an Estimate if no axis is left.

        Raises
        ------
        ValueError
            If the array has no axis of that name.
        """
        bins = [self.shape[self.dims.index(name)] for name in self._axes(dim, "mean")]
        return self.sum(dim) / math.prod(bins)

    def argmin(self) -> tuple[int, ...]:
        """Index of the bin that reads lowest.

        Returns
        -------
        tuple of int
            ``array[array.argmin()]`` is that bin, with its error.  Bins of value nan are left out.

        Raises
        ------
        ValueError
            If all values are nan.

        Notes
        -----
        The lowest of many noisy bins is biased low, by about one standard error or more where many bins are
        alike: chance has picked a bin that reads too low.

        Examples
        --------
        >>> import numpy as np
        >>> import transport as tp
        >>> from transport.statistics.replicates import Batches
        >>> counts = np.array([[3.0, 1.0, 2.0], [3.1, 1.1, 2.1]])
        >>> edges = {"x": np.array([0.0, 1.0, 2.0, 3.0])}
        >>> array = tp.EstimateArray(counts, Batches(np.full(2, 5)), "W", ("x",), edges)
        >>> array.argmin()
        (1,)
        >>> print(array[array.argmin()])
        (1.05 ± 0.05) W
        """
        return self._index_of(np.nanargmin)

    def argmax(self) -> tuple[int, ...]:
        """Index of the bin that reads highest.

        Returns
        -------
        tuple of int
            ``array[array.argmax()]`` is that bin, with its error.  Bins of value nan are left out.

        Raises
        ------
        ValueError
            If all values are nan.

        Notes
        -----
        The highest of many noisy bins is biased high, as the lowest is low (see `argmin`).

        Examples
        --------
        >>> import numpy as np
        >>> import transport as tp
        >>> from transport.statistics.replicates import Batches
        >>> counts = np.array([[3.0, 1.0, 2.0], [3.1, 1.1, 2.1]])
        >>> edges = {"x": np.array([0.0, 1.0, 2.0, 3.0])}
        >>> array = tp.EstimateArray(counts, Batches(np.full(2, 5)), "W", ("x",), edges)
        >>> array.argmax()
        (0,)
        """
        return self._index_of(np.nanargmax)

    def _index_of(self, find: Callable[[np.ndarray], np.intp]) -> tuple[int, ...]:
        return tuple(map(int, np.unravel_index(find(np.asarray(self.value)), self.shape)))

    if not TYPE_CHECKING:

        def min(self, *_: object, **__: object) -> NoReturn:
            raise TypeError(_refused_extreme(".min()", "argmin"))

        def max(self, *_: object, **__: object) -> NoReturn:
            raise TypeError(_refused_extreme(".max()", "argmax"))

    def to_xarray(self) -> xarray.Dataset:
        """Convert to an xarray Dataset (needs xarray).

        Returns
        -------
        xarray.Dataset
            Variables `value` and `error` [unit] and `doubtful` (bool) with the axes as dimensions.
            Coordinates are the centres of the bins, with <name>_low and <name>_high for their edges; instants
            of time have no edges.
        """
        with optional_packages("to_xarray"):
            import xarray

        attributes = {"units": str(self.unit) or "1"}
        data = {key: (self.dims, getattr(self, key), attributes) for key in ("value", "error")}
        data["doubtful"] = (self.dims, self.is_doubtful)
        coords = {}
        for (name, edges), bins in zip(self.coords.items(), self.shape, strict=True):
            unit = axis_unit(name, self.axis_units)
            about = {"units": unit} if unit else {}
            places = axis_places(edges, bins)
            coords |= {name + end: (name, place, about) for end, place in places.items()}
        return xarray.Dataset(data, coords, attributes | {"batches": self.batches})

    def to_dataframe(self) -> pandas.DataFrame:
        """Convert to a pandas DataFrame with a row per bin (needs xarray and pandas).

        Returns
        -------
        pandas.DataFrame
            Columns of `to_xarray`: the centres and edges of the bins, `value`, `error` and `doubtful`.
        """
        return self.to_xarray().to_dataframe().reset_index()

    def plot(
        self,
        ax: Axes | None = None,
        decades: float | None = None,
        label: str = "estimate",
        *,
        cut: bool | float = False,
        unit: str | None = None,
        path: str | PathLike | None = None,
    ) -> Axes:
        """Draw the array over its one or two axes (needs matplotlib).

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw [default: a new figure of pyplot, in which a map stands beside that of its relative
            standard error].
        decades : float, optional
            Range of a logarithmic scale, below the greatest value [default: a linear scale].
        label : str, default "estimate"
            Name of the quantity; the unit is added.
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
            If more than two axes have several bins: index or average the array.
        """
        with optional_packages("plot"):
            draw = function_for(type(self), "plot")
            return draw(self, ax, decades, label, cut=cut, unit=unit, path=path)

    def __repr__(self) -> str:
        axes = ", ".join(f"{name}: {length}" for name, length in zip(self.dims, self.shape, strict=True))
        unknown = np.count_nonzero(~self._is_known)
        known = self.value[~np.isnan(self.value)]
        unit = "" if self.unit.is_dimensionless else f" {self.unit}"
        parts = [f"{known.min():.4g} to {known.max():.4g}{unit}"] if known.size else []
        if self.exact:
            parts.append("exact")
        elif unknown < self.value.size:
            parts.append(f"median relative error {np.nanmedian(self.relative_error):.1e}")
        if unknown:
            parts.append(f"error unknown in {unknown} of {self.value.size} bins")
        if doubtful := np.count_nonzero(self._is_known_but_doubtful):
            of = f"the other {self.value.size - unknown}" if unknown else f"{self.value.size} bins"
            parts.append(f"doubtful in {doubtful} of {of}")
        self._replicates.release_pages()
        for each in self._error_bars:
            release_pages(each)
        return f"<EstimateArray ({axes}) {', '.join(parts)}>"

    def _like(
        self, replicates: Replicates, unit: Unit, coords: dict[str, np.ndarray] | None = None
    ) -> EstimateOrArray:
        made = _from_replicates(replicates, unit, self.coords if coords is None else coords)
        made.axis_units = dict(self.axis_units)
        return made

    def _axes(self, dim: str | tuple[str, ...] | None, method: str) -> tuple[str, ...]:
        """Names of the selected axes, each once.  Raises ValueError for an unknown name."""
        names = self.dims if dim is None else (dim,) if isinstance(dim, str) else tuple(dim)
        for name in names:
            if name not in self.dims:
                raise ValueError(f"{method}: no axis {name!r}; there are {', '.join(self.dims)}")
        return tuple(dict.fromkeys(names))


if TYPE_CHECKING:

    class EstimateAndArray(EstimateArray, Estimate):
        """The members of both classes, for type checkers: the bins decide which class a quantity is."""

        value: Any
        error: Any
        reason: Any
        relative_error: Any
        dof: Any
        is_doubtful: Any

        def interval(self, confidence: float = 0.95) -> tuple[Any, Any]: ...
        def z(self, exact_value: float | np.ndarray) -> Any: ...
        def __add__(self, other: Operand) -> EstimateOrArray: ...

        __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = __add__

    EstimateOrArray = EstimateAndArray | Any  # accepted where either class is; an unknown name is an error
else:
    EstimateOrArray = Estimate | EstimateArray


def _refused_extreme(call: str, method: str) -> str:
    """Message that refuses an extreme over bins, with the method that finds its bin."""
    least = "lowest" if method == "argmin" else "highest"
    return (
        f"{call} would lose the error; E[E.{method}()] is the bin that reads {least}, biased by about one"
        f" error where many bins are alike, and numpy.{method[3:]}(E.value) its bare value"
    )


def coerce_unit(unit: Unit | str) -> Unit:
    """Parse a unit from text; return a Unit unchanged."""
    return Unit.parse(unit) if isinstance(unit, str) else unit


def _from_replicates(replicates: Replicates, unit: Unit, coords: dict[str, np.ndarray]) -> EstimateOrArray:
    """Make an Estimate, or with axes an EstimateArray, from replicates instead of batch values."""
    made = object.__new__(EstimateArray if coords else Estimate)
    made._replicates, made.unit, made.coords = replicates, unit, coords
    return made


def _bound_of_sum(bound: np.ndarray, axes: tuple[int, ...], adds: bool) -> np.ndarray:
    """Bound of a sum over bins ``(*dims)``.

    With `adds` the bounds of the bins add; otherwise the missing score falls into any one bin, and the
    largest counts.
    """
    if adds or not bound.size:
        return bound.sum(axis=axes)
    low, high = np.nanmin(bound, axis=axes, initial=0.0), np.nanmax(bound, axis=axes, initial=0.0)
    return np.where(np.isnan(bound).any(axis=axes), np.nan, np.where(-low > high, low, high))


def _check_axes(shape: tuple[int, ...], dims: Sequence[str], coords: dict[str, np.ndarray]) -> None:
    if isinstance(dims, str) or set(dims) != set(coords) or len(dims) != len(shape) or not shape:
        raise ValueError(f"EstimateArray: dims {dims!r}, coords {list(coords)} and bins {shape} must match")
    for name, length in zip(dims, shape, strict=True):
        places = (length,) if name in AXES_OF_PLACES else None
        if np.shape(coords[name]) not in ((length + 1,), places):
            raise ValueError(
                f"EstimateArray: {name!r} has {length} bins, so its coords must be {length + 1} edges"
            )


def _values_of(argument: object) -> object:
    """Replace each EstimateArray in a function's argument by its values."""
    if isinstance(argument, EstimateArray):
        return argument.value
    if isinstance(argument, dict):
        return {name: _values_of(value) for name, value in argument.items()}
    return type(argument)(map(_values_of, argument)) if type(argument) in (tuple, list) else argument


def _complete_index(index: object, shape: tuple[int, ...]) -> tuple[int | slice, ...]:
    """Complete an index to one whole number or slice per axis.  Raises IndexError for any other kind."""
    index = index if isinstance(index, tuple) else (index,)
    if Ellipsis not in index:
        index += (Ellipsis,)
    place = index.index(Ellipsis)
    missing = len(shape) - (len(index) - 1)
    index = index[:place] + (slice(None),) * missing + index[place + 1 :]
    if missing < 0 or not all(_is_index(along) for along in index):
        raise IndexError(
            "Index with whole numbers, slices of step 1 and one ellipsis; for other indices use .value"
        )
    for axis, (along, length) in enumerate(zip(index, shape, strict=True)):
        if not isinstance(along, slice) and not -length <= along < length:
            raise IndexError(f"index {along} is out of bounds for axis {axis} with {length} bins")
    return index


def _is_index(along: object) -> bool:
    if isinstance(along, slice):
        return along.step in (None, 1)
    return isinstance(along, int | np.integer) and not isinstance(along, bool)
