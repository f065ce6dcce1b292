"""What an estimate and an array of them share: replicates with a unit and named axes, and arithmetic."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import cached_property, reduce
from numbers import Real
from types import MappingProxyType
from typing import Any, Generic, Never, NoReturn, Self, TypeAlias, TypeVar

import numpy as np

from transport.results.error_bars import error_bars_of
from transport.results.findings import (
    ALIKE,
    ALLOWED,
    CONSTANT,
    DOUBTFUL,
    FEW_CARRIERS,
    NO_SCORE,
    SOUND,
    UNKNOWN,
    Finding,
    carried,
    judged,
    limits_of_unknown,
    of_bins,
    of_even_scores,
    of_few_scores,
    of_unknown_error,
    of_weak_denominator,
    severities,
    worst_of,
)
from transport.results.pooling import Pooled
from transport.results.replicates import Batches, Replicates, added, arranged, power, product, ratio
from transport.results.statistics import normal_score, student_quantile
from transport.units import Unit, UnitError

AXIS_UNITS = {  # of axes; those of u and v depend on the shape
    "mu": "1", "theta": "rad", "phi": "rad", "time": "s", "speed": "m s^-1", "r": "m", "x": "m", "y": "m", "z": "m",
    "vx": "m s^-1", "vy": "m s^-1", "vz": "m s^-1",
}  # fmt: skip
Number = TypeVar("Number", covariant=True)  # a float of an Estimate, an array of an EstimateArray
Reason = TypeVar("Reason", covariant=True)
Operand: TypeAlias = "Quantity[Any, Any] | float | np.number | np.ndarray"


class Quantity(Generic[Number, Reason]):
    """Replicates with a unit: all that estimates do alike, one by one or in arrays."""

    __array_ufunc__ = None  # NumPy leaves the arithmetic to us: 2.0 * estimate, array * estimates

    _replicates: Replicates
    unit: Unit
    coords: dict[str, np.ndarray]  # the edges of the bins along each axis; none for a single estimate
    axis_units: Mapping[str, str] = MappingProxyType({})  # of axes that are not always in the same one
    # error bars known from elsewhere, such as those of a bin of an array
    _bars_from: Callable[[], Pooled] | None = None
    allowed: float = ALLOWED  # of the value: what a bound may reach before the number is doubtful
    _is_measured = False  # by a run itself, not made of other quantities
    _adds_scores = False  # of one run, as what it measured, parts of that, multiples and sums over bins do
    _unjudged: tuple[Finding, ...] | Callable[[], Iterable[Finding]] = tuple  # made when they are asked for

    @property
    def value(self) -> Number:
        """The estimated value [unit]."""
        return _plain(self._replicates.value)

    @property
    def error(self) -> Number:
        """One standard error [unit]: 0 where exact, nan where it cannot be known (see `reason`).

        That of a bin is known from neighbouring bins as well, see `is_doubtful`; that of a sum from its batches alone.
        """
        return _plain(np.asarray(self._error_bars.error))

    @property
    def reason(self) -> Reason:
        """Why the error is unknown, or None where it is known."""
        return _plain(self._replicates.reason)

    @property
    def exact(self) -> bool:
        """Whether the value is the same for every history by construction."""
        return self._replicates.is_exact

    @property
    def relative_error(self) -> Number:
        """One standard error as a fraction of the value's size; 0 where exact, infinite at a value of 0."""
        error = np.asarray(self._error_bars.error)
        with np.errstate(divide="ignore", invalid="ignore"):
            return _plain(np.where(error == 0, 0.0, error / np.abs(self._replicates.value)))

    @property
    def run(self) -> Batches | None:
        """The run that this stems from; None for a combination of several."""
        runs = self._replicates.runs
        return runs[0] if len(runs) == 1 else None

    @property
    def batches(self) -> int:
        """Number of batches; for several runs the effective one, of the least certain bin."""
        if self.run is not None:
            return len(self.run)
        dof = self._replicates.dof[np.isfinite(self._replicates.dof)]
        return int(dof.min()) + 1 if dof.size else 0

    @property
    def dof(self) -> Number:
        """Degrees of freedom of the error: batches - 1, effective ones for several runs or bins, inf if exact."""
        return _plain(np.asarray(self._error_bars.dof))

    @property
    def values(self) -> np.ndarray:
        """What each batch alone gave [unit], (B, *dims); pseudo-values after a ratio or product.

        Raises ValueError for a combination of several runs.
        """
        if self.run is None:
            raise ValueError(
                "Only an estimate of one run has values by batch; this one combines several or none"
            )
        deviations = self._replicates.deviations.get(
            self.run, np.zeros((len(self.run), *self._replicates.value.shape))
        )
        with np.errstate(invalid="ignore", over="ignore"):
            return self._replicates.value + deviations

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What the run may have missed of it, the worst first; () where nothing speaks against the error.

        They are kept through arithmetic, slices, merged and resumed runs, and files.
        """
        return judged(
            self._all_findings, self._replicates.value, np.asarray(self._error_bars.error), self.allowed
        )

    @property
    def verdict(self) -> Any:
        """ "sound", "bounded" or "doubtful"; of an array (*dims) of them.

        sound: what may be missing is less than the standard error;  bounded: less than the error that was asked for, or 1 %
        of the value where none was, and `interval()` includes it;  doubtful: more than that, or not known.
        """
        value, error = self._replicates.value, np.asarray(self._error_bars.error)
        verdicts = [severities(finding, value, error, self.allowed) for finding in self._all_findings]
        return _plain(worst_of(verdicts, np.shape(value)))

    @property
    def is_doubtful(self) -> Any:
        """Whether the verdict is "doubtful"; of an array (*dims) of bool."""
        return _plain(np.equal(self.verdict, DOUBTFUL))

    @property
    def _is_known(self) -> np.ndarray:
        """Where the error is known, (*dims) of bool."""
        return ~np.isnan(self._error_bars.error)

    @property
    def _is_known_but_doubtful(self) -> np.ndarray:
        """Where the error is known, and not to be trusted all the same, (*dims) of bool."""
        value, error = self._replicates.value, np.asarray(self._error_bars.error)
        doubts = [np.asarray(self._error_bars.is_doubtful)]
        doubts += [severities(each, value, error, self.allowed) == DOUBTFUL for each in self._raw_findings]
        return np.logical_or.reduce(doubts) & self._is_known

    @property
    def _raw_findings(self) -> tuple[Finding, ...]:
        """All that may matter, before it is compared with the error; of a single number also that it has few scores."""
        if callable(self._unjudged):
            found = tuple(self._unjudged())
            if not (
                self.coords
                or self.exact
                or self._bars_from
                or any(each.name == FEW_CARRIERS for each in found)
            ):
                number, error = self._replicates, np.asarray(self._error_bars.error).item()
                is_sum = self._adds_scores and bool(np.all(self.values >= 0))
                found += of_few_scores(number.scores.item(), number.value.item(), error, is_sum)
            self._unjudged = found + self._of_even_scores
        return self._unjudged

    @property
    def _error_of_all(self) -> np.ndarray:
        """One standard error with what batches that are alike do not tell, (*dims); infinite where that is not known."""
        from scipy.special import ndtri

        reason, error = self._replicates.reason, np.asarray(self._error_bars.error)
        bounds = [
            each.bound for each in self._raw_findings if each.name == UNKNOWN and np.all(each.bound >= 0)
        ]
        unknown = reduce(
            np.hypot, bounds, np.where(np.equal(reason, CONSTANT), self._limits_of_unknown, 0.0)
        ) / ndtri(0.975)
        known = np.where(np.equal(reason, None), error, np.where(np.equal(reason, CONSTANT), 0.0, np.inf))
        return np.hypot(known, unknown)

    @property
    def _of_even_scores(self) -> tuple[Finding, ...]:
        """That its batches are more even than they should be, where that is so."""
        number, run = self._replicates, self.run
        if not self._is_measured or self.exact or run is None or not run.is_even or number.is_in_parts:
            return ()
        histories = int(run.sizes.sum())
        return of_even_scores(number.value, np.asarray(self._error_bars.error), number.scores, histories)

    @property
    def _carried_findings(self) -> tuple[Finding, ...]:
        """What arithmetic carries: the same, and of a single number that it has no score, where nothing bounds what it may be."""
        if self.coords or self.reason != NO_SCORE or not np.isinf(self._limits_of_unknown):
            return self._raw_findings
        unknown = Finding(
            DOUBTFUL, "", "", "a part of it has no score", np.inf, "use more particles", name=UNKNOWN
        )
        return *self._raw_findings, unknown

    @property
    def _all_findings(self) -> tuple[Finding, ...]:
        """The same, and that the error is not known, where it is not."""
        unknown = of_unknown_error(self._replicates.reason, self._limits_of_unknown)
        return *unknown, *of_bins(np.asarray(self._error_bars.is_doubtful)), *self._raw_findings

    @cached_property
    def _limits_of_unknown(self) -> np.ndarray:
        """By how much numbers of unknown error may be off beside what findings bound, (*dims); 0 where the error is known."""
        runs = self._replicates.runs
        histories = min((run.sizes.sum() for run in runs), default=0)
        is_sure = all(run.is_even or len(run) >= ALIKE for run in runs)
        number = self._replicates
        return limits_of_unknown(
            number.reason, number.scale, number.scores, histories, is_sure, self._raw_findings
        )

    def _with_findings(
        self, findings: tuple[Finding, ...] | Callable[[], Iterable[Finding]], allowed: float = ALLOWED
    ) -> Self:
        """This quantity, with findings whose bounds are in its unit: all that there are, or what makes some when they are asked for."""
        self._unjudged, self.allowed = findings, allowed
        return self

    def __getstate__(self) -> dict[str, Any]:
        made = {"_unjudged": self._raw_findings, "_error_bars": self._error_bars}
        return {name: each for name, each in (vars(self) | made).items() if name != "_bars_from"}

    def to_numpy(self) -> np.ndarray:
        """The bare value [unit], (*dims); matplotlib asks for it, and without it would plot all batches."""
        return np.array(self.value)

    def unless(self, too_few: np.ndarray) -> Self:
        """The same, with the error unknown where there are too few scores to tell it; too_few: (*dims) of bool."""
        made = self._like(self._replicates.unless(too_few), self.unit)
        return made._with_findings(lambda: self._raw_findings, self.allowed)

    def interval(self, confidence: float = 0.95) -> tuple[Number, Number]:
        """(low, high) that cover the true value with this probability, by Student's t [unit].

        Where light may be missing they include the bound of it: see `findings`.  Of a number without a score they are 0 and the
        most that it may be; nan where nothing bounds it.
        """
        if not 0 < confidence < 1:
            raise ValueError(f"interval: confidence must lie between 0 and 1, got {confidence!r}")
        reach = 0.0
        if not self.exact:
            bars = self._error_bars
            known = student_quantile(0.5 + confidence / 2, bars.dof) * bars.error
            limits = self._limits_of_unknown
            unknown = np.where(np.isfinite(limits), limits, np.nan)
            reach = np.where(np.equal(self._replicates.reason, None), known, unknown)
        below, above = self._bounds
        return _plain(self._replicates.value - reach - below), _plain(self._replicates.value + reach + above)

    @property
    def _bounds(self) -> tuple[np.ndarray | float, np.ndarray | float]:
        """By how much the true value may lie below and above the estimate, beside its error."""
        below, above, value = 0.0, 0.0, self._replicates.value
        for finding in self._raw_findings:
            matters = severities(finding, value, np.asarray(self._error_bars.error), self.allowed) != SOUND
            bound = np.where(matters, np.nan_to_num(finding.bound, posinf=np.inf, neginf=-np.inf), 0.0)
            below, above = below - np.minimum(bound, 0.0), above + np.maximum(bound, 0.0)
        return np.broadcast_to(below, np.shape(value)), np.broadcast_to(above, np.shape(value))

    def z(self, exact_value: float | np.ndarray) -> Number:
        """Standard normal score of the difference from a known value, by Student's t; nan without an error.

        For an exact estimate 0 where the two agree to 1e-12 of their size, or of the terms that the estimate is a
        difference of, and infinite where they do not.
        """
        value, expected = self._replicates.value, np.asarray(exact_value, dtype=float)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            if self.exact:
                agree = np.abs(value - expected) <= 1e-12 * np.maximum(
                    self._replicates.scale, np.abs(expected)
                )
                surely_not = np.where(np.isnan(value), np.nan, np.copysign(np.inf, value - expected))
                return _plain(np.where(agree, 0.0, surely_not))
            t = (value - expected) / self._error_bars.error
        return _plain(normal_score(t, self._error_bars.dof))

    def __add__(self, other: Operand) -> Self:
        return self._plus(other, +1)

    __radd__ = __add__

    def __sub__(self, other: Operand) -> Self:
        if other is self:
            with np.errstate(invalid="ignore"):
                return self._known(self._replicates.value * 0 + 0.0, self.unit)
        return self._plus(other, -1)

    def __rsub__(self, other: Operand) -> Self:
        return (-self)._plus(other, +1)

    def __neg__(self) -> Self:
        return self * -1.0

    def __pos__(self) -> Self:
        return self

    def __abs__(self) -> Self:
        return self * np.where(self._replicates.value < 0, -1.0, 1.0)

    def __lt__(self, other: Never) -> NoReturn:
        distance = f"E.z({other!r})" if isinstance(other, Real) else "(E - other).z(0)"
        raise TypeError(
            f"Uncertain numbers have no order: compare E.value, or use {distance}, in standard errors"
        )

    __le__ = __gt__ = __ge__ = __lt__

    def __mul__(self, other: Operand) -> Self:
        if (other := self._operand(other)) is None:
            return NotImplemented
        return _applied(product, np.multiply, self, other, self.unit * other.unit)

    __rmul__ = __mul__

    def __truediv__(self, other: Operand) -> Self:
        if other is self:
            with np.errstate(divide="ignore", invalid="ignore"):
                ones = self._replicates.value / self._replicates.value
            return self._known(ones, Unit())
        if (other := self._operand(other)) is None:
            return NotImplemented
        return _applied(ratio, np.divide, self, other, self.unit / other.unit)

    def __rtruediv__(self, other: Operand) -> Self:
        if (other := self._operand(other)) is None:
            return NotImplemented
        return _applied(ratio, np.divide, other, self, other.unit / self.unit)

    def __pow__(self, exponent: float) -> Self:
        if not isinstance(exponent, Real):
            return NotImplemented
        made = self._like(power(self._replicates, exponent), self.unit**exponent)
        number = self._replicates
        made = made._with_findings(
            lambda: carried(lambda x: np.power(x, float(exponent)), (number.value, self._raw_findings)),
            self.allowed,
        )
        _keep_error_bars(made, self)
        return made

    def _plus(self, other: object, sign: int) -> Self:
        if isinstance(other, Real) and other == 0:  # so that sum() works, which begins with 0
            return self
        if (other := self._operand(other)) is None:
            return NotImplemented
        if self.unit != other.unit:
            verb = "add" if sign > 0 else "subtract"
            raise UnitError(
                f"Cannot {verb} quantities of unlike units: [{self.unit}] and [{other.unit}];"
                f" the second lacks a factor of [{self.unit / other.unit}]"
            )
        plain = np.add if sign > 0 else np.subtract
        return _applied(lambda first, second: added(first, second, sign), plain, self, other, self.unit)

    @cached_property
    def _error_bars(self) -> Pooled:
        """Error, degrees of freedom and doubt of each bin."""
        if self._bars_from is not None:
            return self._bars_from()
        return error_bars_of(self._replicates, self.coords, AXIS_UNITS | dict(self.axis_units))

    def _operand(self, other: object) -> Quantity | None:
        """The other side of an operator; a number or array becomes an exact quantity with the same axes."""
        if isinstance(other, Quantity):
            return other
        if not isinstance(other, Real | np.ndarray) or np.asarray(other).dtype.kind not in "biuf":
            return None
        shape = self._replicates.shape
        try:
            constant = np.broadcast_to(np.asarray(other, dtype=float), shape)
        except ValueError:
            raise ValueError(f"An array of shape {np.shape(other)} does not fit one of {shape}") from None
        return self._known(constant, Unit())

    def _known(self, value: np.ndarray, unit: Unit) -> Self:
        """An exact quantity of the same runs and axes."""
        return self._like(Replicates.constant(value, self._replicates.runs), unit)

    @property
    def _whole(self) -> Quantity[float, str | None]:
        """The sum over all bins; of a single estimate this itself."""
        raise NotImplementedError

    def _like(self, replicates: Replicates, unit: Unit, coords: dict[str, np.ndarray] | None = None) -> Self:
        """A quantity of this kind, with the same axes unless others are said."""
        raise NotImplementedError


def _applied(function: Callable, plain: Callable, first: Quantity, second: Quantity, unit: Unit) -> Quantity:
    """function of the replicates of both, their axes matched by name; plain: the same of bare values."""
    for name in first.coords.keys() & second.coords.keys():
        if not np.array_equal(first.coords[name], second.coords[name]):
            raise ValueError(f"The bins along {name!r} are not the same on both sides")
    coords = first.coords | second.coords
    aligned = [each._replicates.along(tuple(each.coords), tuple(coords)) for each in (first, second)]
    made = (first if first.coords else second)._like(function(*aligned), unit, coords)
    made.axis_units = {**first.axis_units, **second.axis_units}

    def findings() -> tuple[Finding, ...]:
        both = (
            (one.value, _aligned_findings(each, tuple(coords)))
            for one, each in zip(aligned, (first, second), strict=True)
        )
        weak: tuple[Finding, ...] = ()
        if plain is np.divide:
            dims, below = tuple(second.coords), second._replicates.shape
            error = arranged(np.broadcast_to(second._error_bars.error, below), dims, tuple(coords))
            weak = of_weak_denominator(aligned[1].value, error)
        return *carried(plain, *both), *weak

    made = made._with_findings(findings, min(first.allowed, second.allowed))
    uncertain = [each for each in (first, second) if not each.exact]
    if len(uncertain) == 1:
        _keep_error_bars(made, *uncertain)
        if plain is np.multiply or (plain is np.divide and not first.exact):
            made._adds_scores = uncertain[0]._adds_scores
    return made


def _aligned_findings(quantity: Quantity, dims: tuple[str, ...]) -> list[Finding]:
    """Its findings, with bounds along these axes."""
    own, shape = tuple(quantity.coords), quantity._replicates.shape
    return [
        replace(finding, bound=arranged(np.broadcast_to(finding.bound, shape), own, dims))
        for finding in quantity._carried_findings
    ]


def _keep_error_bars(made: Quantity, operand: Quantity) -> None:
    """Let what is made of one uncertain quantity keep its pooled errors: they grow as those from its batches do."""
    if made._replicates.is_in_parts or tuple(operand.coords) not in ((), tuple(made.coords)):
        return

    def judged() -> Pooled:
        bars, own = operand._error_bars, made._replicates.error
        with np.errstate(divide="ignore", invalid="ignore"):
            error = own * (bars.error / operand._replicates.error)
        return Pooled(error, *(np.broadcast_to(each, np.shape(error)) for each in bars[1:]))

    made._bars_from = judged


def _plain(array: np.ndarray) -> Any:
    """A Python value for a single estimate, the array for an array of them."""
    return array.item() if np.ndim(array) == 0 else array
