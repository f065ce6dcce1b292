"""What a run found out: an estimate, or an array of them over bins, with standard errors and unit."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from types import EllipsisType
from typing import TYPE_CHECKING, Any, TypeVar, overload

import numpy as np

from transport.renderers import function_for
from transport.results.aside import let_go
from transport.results.findings import BOUNDED, CONSTANT, DOUBTFUL, NO_SCORE, UNKNOWN, Finding
from transport.results.in_parts import replicates_of
from transport.results.notation import measured, split_format
from transport.results.pooling import Pooled
from transport.results.quantities import AXIS_UNITS, Operand, Quantity
from transport.results.replicates import Batches, Replicates
from transport.units import Unit

if TYPE_CHECKING:
    import xarray

__all__ = ["Batches", "Estimate", "EstimateArray", "EstimateOrArray"]

_KEEPS_ERRORS = {np.sum: "sum", np.nansum: "sum", np.mean: "mean", np.nanmean: "mean", np.average: "mean"}


Other = TypeVar("Other", bound=Quantity[Any, Any])
Index = int | np.integer | slice | EllipsisType


class Estimate(Quantity[float, str | None]):
    """One estimated number: `.value` ± `.error` (one standard error) in `.unit`, from `.batches` batches.

    values: means of the batches, (B,);  exact: whether it is the same for every history by construction;
    counts: number of scores, where it is known.  Estimates are of one run if their `run` is the same object;
    arithmetic then keeps their correlations, batch by batch.  float(estimate) is the bare value.
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
            raise ValueError(
                f"Estimate: values must have one axis, the batches, got shape {np.shape(values)}"
            )
        self._replicates = Replicates.of_batches(values, run, exact, counts)
        self._is_measured = self._adds_scores = True
        self.unit = as_unit(unit)
        self.coords = {}

    if TYPE_CHECKING:  # with an EstimateArray it gives one

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
        return self._in_words()

    def __format__(self, spec: str) -> str:
        """Numbers as ".3f" says, the whole text as ">40" says; both may be given."""
        text, number, sign = split_format(spec)
        return format(self._in_words(number, sign), text)

    def __repr__(self) -> str:
        return f"<Estimate {self}>" if self.exact else f"<Estimate {self}, {self.batches} batches>"

    def _repr_html_(self) -> str:
        return function_for(type(self), "html")(self)

    @property
    def _whole(self) -> Estimate:
        return self

    def _in_words(self, number: str = "", sign: str = "") -> str:
        limit = None
        if self.reason == CONSTANT and np.isfinite(self._limits_of_unknown):
            limit = CONSTANT
        elif self.reason == NO_SCORE and np.isfinite(self._limits_of_unknown) and self._bounds[0] == 0:
            limit = f"{NO_SCORE}: at most {float(self._bounds[1]):.2g} {self.unit}".removesuffix(" 1")
        words = measured(self.value, self.error, str(self.unit), self.exact, self.reason, number, sign, limit)
        return words + self._doubt_in_words()

    def _doubt_in_words(self) -> str:
        """What the error leaves out, after a number whose error is known; "" where nothing matters."""
        if self.reason not in (None, CONSTANT):  # which says more
            return ""
        told = UNKNOWN if self.reason == CONSTANT else None  # that they are all the same is said
        worst = next((finding for finding in self.findings if finding.name != told), None)
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
        return _made(replicates, unit, {})


class EstimateArray(Quantity[np.ndarray, np.ndarray]):
    """Estimates over bins: `.value` and `.error` are arrays with the axes `.dims` and bin edges `.coords`.

    values: means of the batches, (B, *dims);  coords: for each name in dims the edges of its n bins; "time" may be n instants;
    counts: number of scores in each bin, (*dims), where it is known;  exact: as for Estimate;  axis_units: those of u and v.
    An element is an Estimate; arithmetic matches axes by name, and plain arrays by NumPy's broadcasting.
    NumPy's functions take the bare values, but those that would lose errors for which there is a method.
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
        self._is_measured = self._adds_scores = True
        self.unit = as_unit(unit)
        self.coords = {name: np.array(coords[name], dtype=float) for name in dims}
        self.axis_units = dict(axis_units or {})

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the axes."""
        return tuple(self.coords)

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of bins along the axes."""
        return self._replicates.shape

    def __len__(self) -> int:
        return self.shape[0]

    def __iter__(self) -> Iterator[EstimateOrArray]:
        return (self[i] for i in range(len(self)))

    def __getitem__(self, index: Index | tuple[Index, ...]) -> EstimateOrArray:
        index = _one_index_an_axis(index, self.shape)
        replicates, shape = self._replicates.indexed(index), self.shape
        coords = {}
        for (name, edges), along, bins in zip(self.coords.items(), index, self.shape, strict=True):
            if isinstance(along, slice):
                start, stop, _ = along.indices(bins)
                coords[name] = edges[start : max(start, stop) + len(edges) - bins]
        made = self._like(replicates, self.unit, coords)._with_findings(
            lambda: self._changed(lambda bound: np.broadcast_to(bound, shape)[index]), self.allowed
        )
        made._adds_scores = self._adds_scores
        made._bars_from = lambda: Pooled(*(np.asarray(each[index]) for each in self._error_bars))
        return made

    def __array__(
        self, dtype: object = None, copy: bool | None = None
    ) -> np.ndarray[Any, np.dtype[np.object_]]:  # so that type checkers take array * estimates for Any
        return np.array(self.value, dtype=dtype)

    def __array_function__(self, function: Callable, types: object, args: tuple, kwargs: dict) -> object:
        if function in _KEEPS_ERRORS:
            method = _KEEPS_ERRORS[function]
            raise TypeError(
                f"numpy.{function.__name__} would lose the errors; write .{method}() or .{method}(dim),"
                f" or numpy.{function.__name__}(estimates.value)"
            )
        return function(*_bare(args), **_bare(kwargs))

    def __float__(self) -> float:
        if self._replicates.value.size != 1:
            raise TypeError(
                f"Only an array of one bin is a number, this has the bins {self.shape}; index it or take .value"
            )
        return self._replicates.value.item()

    def sum(self, dim: str | tuple[str, ...] | None = None) -> EstimateOrArray:
        """Sum over the axis or axes of this name, or over all; bins without a score add nothing."""
        replicates, left, shape = self._replicates, list(self.dims), self.shape
        axes = tuple(left.index(name) for name in self._axes(dim, "sum"))
        for name in self._axes(dim, "sum"):
            replicates = replicates.summed(axis=left.index(name) - len(left))
            left.remove(name)
        made = self._like(replicates, self.unit, {name: self.coords[name] for name in left})
        made._adds_scores = self._adds_scores
        return made._with_findings(
            lambda: [
                replace(each, bound=_number(_together(np.broadcast_to(each.bound, shape), axes, each.adds)))
                for each in self._raw_findings
            ],
            self.allowed,
        )

    def _changed(self, change: Callable[[np.ndarray], np.ndarray]) -> Iterator[Finding]:
        """Its findings, with bounds changed so."""
        return (replace(finding, bound=_number(change(finding.bound))) for finding in self._raw_findings)

    @property
    def _whole(self) -> Estimate:
        return self.sum()

    def mean(self, dim: str | tuple[str, ...] | None = None) -> EstimateOrArray:
        """Mean of the bins along the axis or axes of this name, or of all; wide bins weigh no more than others."""
        bins = [self.shape[self.dims.index(name)] for name in self._axes(dim, "mean")]
        return self.sum(dim) / math.prod(bins)

    def to_xarray(self) -> xarray.Dataset:
        """Dataset with `value`, `error` and `doubtful`; coordinates are the bins' centres, and <name>_low and <name>_high.

        Instants of time have neither.
        """
        import xarray

        attributes = {"units": str(self.unit) or "1"}
        data = {key: (self.dims, getattr(self, key), attributes) for key in ("value", "error")}
        data["doubtful"] = (self.dims, self.is_doubtful)
        coords = {}
        for (name, edges), bins in zip(self.coords.items(), self.shape, strict=True):
            known = AXIS_UNITS | dict(self.axis_units)
            of_axis = {"units": known[name]} if name in known else {}
            places = {"": 0.5 * (edges[1:] + edges[:-1]), "_low": edges[:-1], "_high": edges[1:]}
            places = {"": edges} if len(edges) == bins else places
            coords |= {name + end: (name, place, of_axis) for end, place in places.items()}
        return xarray.Dataset(data, coords, attributes | {"batches": self.batches})

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
        self._replicates.let_go()
        for each in self._error_bars:
            let_go(each)
        return f"<EstimateArray ({axes}) {', '.join(parts)}>"

    def _repr_html_(self) -> str:
        return function_for(type(self), "html")(self)

    def _like(
        self, replicates: Replicates, unit: Unit, coords: dict[str, np.ndarray] | None = None
    ) -> EstimateOrArray:
        made = _made(replicates, unit, self.coords if coords is None else coords)
        made.axis_units = dict(self.axis_units)
        return made

    def _axes(self, dim: str | tuple[str, ...] | None, method: str) -> tuple[str, ...]:
        """Names of the axes meant, each once.  Raises ValueError for one that there is not."""
        names = self.dims if dim is None else (dim,) if isinstance(dim, str) else tuple(dim)
        for name in names:
            if name not in self.dims:
                raise ValueError(f"{method}: no axis {name!r}; there are {', '.join(self.dims)}")
        return tuple(dict.fromkeys(names))


if TYPE_CHECKING:

    class EstimateAndArray(EstimateArray, Estimate):
        """What both can: the bins decide which of them a quantity is, and no type checker knows the bins."""

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

    EstimateOrArray = EstimateAndArray | Any  # goes where either goes; a name that neither has is an error
else:
    EstimateOrArray = Estimate | EstimateArray


def as_unit(unit: Unit | str) -> Unit:
    """The unit, read from its text where it is one."""
    return Unit.parse(unit) if isinstance(unit, str) else unit


def _made(replicates: Replicates, unit: Unit, coords: dict[str, np.ndarray]) -> EstimateOrArray:
    """An Estimate, or with axes an EstimateArray, from replicates instead of batch values."""
    made = object.__new__(EstimateArray if coords else Estimate)
    made._replicates, made.unit, made.coords = replicates, unit, coords
    return made


def _together(bound: np.ndarray, axes: tuple[int, ...], adds: bool) -> np.ndarray:
    """The bound of a sum over bins: of all their parts, or where what has not scored may fall into one of them only, the largest."""
    if adds or not bound.size:
        return bound.sum(axis=axes)
    low, high = np.nanmin(bound, axis=axes, initial=0.0), np.nanmax(bound, axis=axes, initial=0.0)
    return np.where(np.isnan(bound).any(axis=axes), np.nan, np.where(-low > high, low, high))


def _number(array: np.ndarray) -> float | np.ndarray:
    return float(array) if np.ndim(array) == 0 else array


def _check_axes(shape: tuple[int, ...], dims: Sequence[str], coords: dict[str, np.ndarray]) -> None:
    if isinstance(dims, str) or set(dims) != set(coords) or len(dims) != len(shape) or not shape:
        raise ValueError(f"EstimateArray: dims {dims!r}, coords {list(coords)} and bins {shape} must match")
    for name, length in zip(dims, shape, strict=True):
        instants = (length,) if name == "time" else None
        if np.shape(coords[name]) not in ((length + 1,), instants):
            raise ValueError(
                f"EstimateArray: {name!r} has {length} bins, so its coords must be {length + 1} edges"
            )


def _bare(argument: object) -> object:
    """The argument of a function with the values of each EstimateArray in its place."""
    if isinstance(argument, EstimateArray):
        return argument.value
    if isinstance(argument, dict):
        return {name: _bare(value) for name, value in argument.items()}
    return type(argument)(map(_bare, argument)) if type(argument) in (tuple, list) else argument


def _one_index_an_axis(index: object, shape: tuple[int, ...]) -> tuple[int | slice, ...]:
    """The index as one whole number or slice for every axis.  Raises IndexError for any other kind."""
    index = index if isinstance(index, tuple) else (index,)
    if Ellipsis not in index:
        index += (Ellipsis,)
    place = index.index(Ellipsis)
    missing = len(shape) - (len(index) - 1)
    index = index[:place] + (slice(None),) * missing + index[place + 1 :]
    if missing < 0 or not all(_is_index(along) for along in index):
        raise IndexError(
            "Index with whole numbers, slices of step 1 and one ellipsis; for others take .value"
        )
    for axis, (along, length) in enumerate(zip(index, shape, strict=True)):
        if not isinstance(along, slice) and not -length <= along < length:
            raise IndexError(f"index {along} is out of bounds for axis {axis} with {length} bins")
    return index


def _is_index(along: object) -> bool:
    if isinstance(along, slice):
        return along.step in (None, 1)
    return isinstance(along, int | np.integer) and not isinstance(along, bool)
