"""Base class of Estimate and EstimateArray: replicates with a unit and named axes, arithmetic, findings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import cached_property, reduce
from numbers import Real
from types import MappingProxyType
from typing import Any, Generic, Never, NoReturn, Self, TypeAlias, TypeVar

import numpy as np

from transport.renderers import function_for
from transport.statistics.axes import axis_unit
from transport.statistics.batches import normal_score, student_quantile
from transport.statistics.error_bars import error_bars_of
from transport.statistics.findings import (
    CONSTANT,
    DEFAULT_ALLOWED_BOUND,
    DOUBTFUL,
    FEW_CARRIERS,
    MIN_EQUAL_BATCHES,
    NO_SCORE,
    SOUND,
    UNKNOWN,
    Finding,
    bin_findings,
    doubtful,
    even_scores_findings,
    few_scores_findings,
    propagated_findings,
    severities,
    unknown_error_findings,
    unknown_error_limits,
    weak_denominator_findings,
    with_severities,
    worst_verdicts,
)
from transport.statistics.pooling import Pooled
from transport.statistics.replicates import Batches, Replicates, added, power, product, ratio, with_axes
from transport.units import Unit, UnitError

Number = TypeVar("Number", covariant=True)  # a float of an Estimate, an array of an EstimateArray
Reason = TypeVar("Reason", covariant=True)
Operand: TypeAlias = "AnyEstimate[Any, Any] | float | np.number | np.ndarray"


class AnyEstimate(Generic[Number, Reason]):
    """Replicates with a unit: the common behaviour of Estimate and EstimateArray.

    Attributes
    ----------
    unit : Unit
        Unit of values and errors.
    coords : dict of str to numpy.ndarray
        Edges of the bins along each axis; empty for a single estimate.
    axis_units : mapping of str to str
        Units of axes whose unit is not fixed, such as "u" and "v".
    allowed : float, default 0.01
        Relative error up to which a finding's bound is accepted; a larger bound makes the number doubtful.
    """

    __array_ufunc__ = None  # NumPy defers to the operators of this class: 2.0 * estimate, array * estimates

    _replicates: Replicates
    unit: Unit
    coords: dict[str, np.ndarray]  # edges of the bins along each axis; empty for a single estimate
    axis_units: Mapping[str, str] = MappingProxyType({})  # of axes without a fixed unit
    # Error bars from elsewhere, such as those of one bin of an array.
    _bars_from: Callable[[], Pooled] | None = None
    allowed: float = DEFAULT_ALLOWED_BOUND  # relative to the value; a larger bound makes the number doubtful
    _is_measured = False  # measured by a run itself, not computed from other quantities
    _is_sum_of_scores = False  # a sum of scores of one run, or a part or multiple of it
    _unjudged: tuple[Finding, ...] | Callable[[], Iterable[Finding]] = tuple  # made at the first access

    @property
    def value(self) -> Number:
        """Estimated value [unit].

        Returns
        -------
        float or numpy.ndarray
            A float for an Estimate, an array ``(*dims)`` for an EstimateArray.
        """
        return _unwrapped(self._replicates.value)

    @property
    def error(self) -> Number:
        """One standard error [unit], 0 if exact and nan if it cannot be known (see `reason`).

        Returns
        -------
        float or numpy.ndarray
            The error of a bin also uses neighbouring bins (see `is_doubtful`); that of a sum uses its batches
            alone.
        """
        return _unwrapped(np.asarray(self._error_bars.error))

    @property
    def reason(self) -> Reason:
        """Reason why the error is unknown.

        Returns
        -------
        str, None or numpy.ndarray
            None where the error is known; an object array ``(*dims)`` for an EstimateArray.
        """
        return _unwrapped(self._replicates.reason)

    @property
    def exact(self) -> bool:
        """Whether the value is the same for every history by construction.

        Returns
        -------
        bool
        """
        return self._replicates.is_exact

    @property
    def relative_error(self) -> Number:
        """One standard error divided by the size of the value.

        Returns
        -------
        float or numpy.ndarray
            A fraction [1]; 0 if exact, infinite for a value of 0, nan if the error is unknown.
        """
        error = np.asarray(self._error_bars.error)
        with np.errstate(divide="ignore", invalid="ignore"):
            return _unwrapped(np.where(error == 0, 0.0, error / np.abs(self._replicates.value)))

    @property
    def run(self) -> Batches | None:
        """The run of this estimate.

        Returns
        -------
        Batches or None
            None for a combination of several runs.
        """
        runs = self._replicates.runs
        return runs[0] if len(runs) == 1 else None

    @property
    def batches(self) -> int:
        """Number of batches.

        Returns
        -------
        int
            For several runs the effective number, of the least certain bin.
        """
        if self.run is not None:
            return len(self.run)
        dof = self._replicates.dof[np.isfinite(self._replicates.dof)]
        return int(dof.min()) + 1 if dof.size else 0

    @property
    def dof(self) -> Number:
        """Degrees of freedom of the error.

        Returns
        -------
        float or numpy.ndarray
            batches - 1; effective ones (Welch-Satterthwaite, pooling) for several runs or bins; infinite if
            exact.
        """
        return _unwrapped(np.asarray(self._error_bars.dof))

    @property
    def values(self) -> np.ndarray:
        """Value of each batch alone [unit]; pseudo-values of the jackknife after a ratio or a product.

        Returns
        -------
        numpy.ndarray
            Shape ``(B, *dims)``.

        Raises
        ------
        ValueError
            For a combination of several runs.
        """
        if self.run is None:
            raise ValueError(
                "Only an estimate of one run has values by batch; this one combines several or none"
            )
        value = self._replicates.value
        none = np.zeros((len(self.run), *value.shape))
        with np.errstate(invalid="ignore", over="ignore"):
            return value + self._replicates.deviations.get(self.run, none)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Findings of contributions to this number that the run may have missed, the worst first.

        Returns
        -------
        tuple of Finding
            Empty if there is no finding against the error.  Arithmetic, slices, merged and resumed runs, and
            files keep the findings.
        """
        return with_severities(
            self._all_findings, self._replicates.value, np.asarray(self._error_bars.error), self.allowed
        )

    @property
    def verdict(self) -> Any:
        """Verdict on the error, "sound", "bounded" or "doubtful".

        Returns
        -------
        str or numpy.ndarray
            An array ``(*dims)`` of str for an EstimateArray.

        Notes
        -----
        sound: the missing part is smaller than the standard error.  bounded: it is smaller than the requested
        error (1 % of the value by default), and `interval()` includes it.  doubtful: it is larger, or not
        bounded.
        """
        value, error = self._replicates.value, np.asarray(self._error_bars.error)
        verdicts = [severities(finding, value, error, self.allowed) for finding in self._all_findings]
        return _unwrapped(worst_verdicts(verdicts, np.shape(value)))

    @property
    def is_doubtful(self) -> Any:
        """Whether the verdict is "doubtful".

        Returns
        -------
        bool or numpy.ndarray
            An array ``(*dims)`` of bool for an EstimateArray.
        """
        return _unwrapped(np.equal(self.verdict, DOUBTFUL))

    @property
    def _is_known(self) -> np.ndarray:
        """Mask of the bins whose error is known, ``(*dims)`` of bool."""
        return ~np.isnan(self._error_bars.error)

    @property
    def _is_known_but_doubtful(self) -> np.ndarray:
        """Mask of the bins whose error is known but doubtful, ``(*dims)`` of bool."""
        value, error = self._replicates.value, np.asarray(self._error_bars.error)
        doubts = [np.asarray(self._error_bars.is_doubtful)]
        doubts += [severities(each, value, error, self.allowed) == DOUBTFUL for each in self._raw_findings]
        return np.logical_or.reduce(doubts) & self._is_known

    @property
    def _raw_findings(self) -> tuple[Finding, ...]:
        """All findings before comparison with the error; for a single number also that it has few scores."""
        if callable(self._unjudged):
            found = tuple(self._unjudged())
            has_few = any(each.name == FEW_CARRIERS for each in found)
            if not (self.coords or self.exact or self._bars_from or has_few):
                number, error = self._replicates, np.asarray(self._error_bars.error).item()
                is_sum = self._is_sum_of_scores and bool(np.all(self.values >= 0))
                found += few_scores_findings(number.scores.item(), number.value.item(), error, is_sum)
            self._unjudged = found + self._even_scores_findings
        return self._unjudged

    @property
    def _error_with_unknown(self) -> np.ndarray:
        """One standard error including the uncertainty of equal batches, ``(*dims)``; infinite if unknown."""
        from scipy.special import ndtri

        reason, error = self._replicates.reason, np.asarray(self._error_bars.error)
        unknown = [each.bound for each in self._raw_findings if each.name == UNKNOWN]
        bounds = [bound for bound in unknown if np.all(bound >= 0)]
        is_constant = np.equal(reason, CONSTANT)
        limit = reduce(np.hypot, bounds, np.where(is_constant, self._unknown_error_limits, 0.0))
        known = np.where(np.equal(reason, None), error, np.where(is_constant, 0.0, np.inf))
        return np.hypot(known, limit / ndtri(0.975))

    @property
    def _even_scores_findings(self) -> tuple[Finding, ...]:
        """The finding that the batches are more equal than they should be, if so."""
        number, run = self._replicates, self.run
        if not self._is_measured or self.exact or run is None or not run.is_even or number.is_chunked:
            return ()
        error = np.asarray(self._error_bars.error)
        return even_scores_findings(number.value, error, number.scores, run.histories)

    @property
    def _propagated_findings(self) -> tuple[Finding, ...]:
        """The findings that arithmetic propagates.

        They are the same findings, and one more for a single unbounded number without a score.
        """
        if self.coords or self.reason != NO_SCORE or not np.isinf(self._unknown_error_limits):
            return self._raw_findings
        return *self._raw_findings, doubtful(UNKNOWN, "a part of it has no score", np.inf)

    @property
    def _all_findings(self) -> tuple[Finding, ...]:
        """All findings, and a finding for each error that is not known."""
        unknown = unknown_error_findings(self._replicates.reason, self._unknown_error_limits)
        return *unknown, *bin_findings(np.asarray(self._error_bars.is_doubtful)), *self._raw_findings

    @cached_property
    def _unknown_error_limits(self) -> np.ndarray:
        """Limits of numbers with unknown error besides the findings, ``(*dims)``; 0 if the error is known."""
        number, runs = self._replicates, self._replicates.runs
        histories = min((run.histories for run in runs), default=0)
        is_sure = all(run.is_even or len(run) >= MIN_EQUAL_BATCHES for run in runs)
        return unknown_error_limits(
            number.reason, number.scale, number.scores, histories, is_sure, self._raw_findings
        )

    def _with_findings(
        self,
        findings: tuple[Finding, ...] | Callable[[], Iterable[Finding]],
        allowed: float = DEFAULT_ALLOWED_BOUND,
    ) -> Self:
        """Attach findings, with bounds in the unit of this quantity: a tuple, or a function that makes it."""
        self._unjudged, self.allowed = findings, allowed
        return self

    def _repr_html_(self) -> str:
        return function_for(type(self), "html")(self)

    def __getstate__(self) -> dict[str, Any]:
        made = {"_unjudged": self._raw_findings, "_error_bars": self._error_bars}
        return {name: each for name, each in (vars(self) | made).items() if name != "_bars_from"}

    def to_numpy(self) -> np.ndarray:
        """Return the bare values.

        matplotlib calls this method; without it, it would plot all batches.

        Returns
        -------
        numpy.ndarray
            Values [unit], shape ``(*dims)``.
        """
        return np.array(self.value)

    def unless(self, too_few: np.ndarray) -> Self:
        """Return the same estimate with an unknown error where `too_few` is true.

        Parameters
        ----------
        too_few : numpy.ndarray
            Array ``(*dims)`` of bool: where there are too few scores to know the error.

        Returns
        -------
        Estimate or EstimateArray
        """
        made = self._like(self._replicates.unless(too_few), self.unit)
        return made._with_findings(lambda: self._raw_findings, self.allowed)

    def interval(self, confidence: float = 0.95) -> tuple[Number, Number]:
        """Confidence interval by Student's t.

        Parameters
        ----------
        confidence : float, default 0.95
            Probability that the interval covers the true value, between 0 and 1.

        Returns
        -------
        (low, high) : tuple of float or of numpy.ndarray
            Limits [unit].  They include the bounds of findings that matter (see `findings`).  A number
            without a score has the interval from 0 to its bound; nan if nothing bounds it.

        Raises
        ------
        ValueError
            If `confidence` is not between 0 and 1.

        Examples
        --------
        >>> import numpy as np
        >>> import transport as tp
        >>> from transport.statistics.replicates import Batches
        >>> flux = tp.Estimate(np.array([1.0, 1.2, 0.8, 1.0]), Batches(np.full(4, 1000)), "W")
        >>> print("{:.2f} to {:.2f} W".format(*flux.interval(0.95)))
        0.74 to 1.26 W
        """
        if not 0 < confidence < 1:
            raise ValueError(f"interval: confidence must lie between 0 and 1, got {confidence!r}")
        reach = 0.0
        if not self.exact:
            bars = self._error_bars
            known = student_quantile(0.5 + confidence / 2, bars.dof) * bars.error
            limits = self._unknown_error_limits
            unknown = np.where(np.isfinite(limits), limits, np.nan)
            reach = np.where(np.equal(self._replicates.reason, None), known, unknown)
        value, (below, above) = self._replicates.value, self._bounds
        return _unwrapped(value - reach - below), _unwrapped(value + reach + above)

    @property
    def _bounds(self) -> tuple[np.ndarray | float, np.ndarray | float]:
        """Largest errors below and above the estimate besides its standard error, each ``(*dims)``."""
        below, above, value = 0.0, 0.0, self._replicates.value
        for finding in self._raw_findings:
            matters = severities(finding, value, np.asarray(self._error_bars.error), self.allowed) != SOUND
            bound = np.where(matters, np.nan_to_num(finding.bound, posinf=np.inf, neginf=-np.inf), 0.0)
            below, above = below - np.minimum(bound, 0.0), above + np.maximum(bound, 0.0)
        return np.broadcast_to(below, np.shape(value)), np.broadcast_to(above, np.shape(value))

    def z(self, exact_value: float | np.ndarray) -> Number:
        """Standard normal score of the difference from a known value.

        Parameters
        ----------
        exact_value : float or numpy.ndarray
            The value to compare with [unit].

        Returns
        -------
        float or numpy.ndarray
            The normal score with the same tail probability as the difference has in Student's t distribution;
            nan without an error.  For an exact estimate 0 if both agree to 1e-12 of their size, or of the
            terms of which the estimate is a difference, and infinite otherwise.
        """
        value, expected = self._replicates.value, np.asarray(exact_value, dtype=float)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            if self.exact:
                size = np.maximum(self._replicates.scale, np.abs(expected))
                agree = np.abs(value - expected) <= 1e-12 * size
                surely_not = np.where(np.isnan(value), np.nan, np.copysign(np.inf, value - expected))
                return _unwrapped(np.where(agree, 0.0, surely_not))
            t = (value - expected) / self._error_bars.error
        return _unwrapped(normal_score(t, self._error_bars.dof))

    def __add__(self, other: Operand) -> Self:
        return self._add_signed(other, +1)

    __radd__ = __add__

    def __sub__(self, other: Operand) -> Self:
        if other is self:
            with np.errstate(invalid="ignore"):
                return self._known(self._replicates.value * 0 + 0.0, self.unit)
        return self._add_signed(other, -1)

    def __rsub__(self, other: Operand) -> Self:
        return (-self)._add_signed(other, +1)

    def __neg__(self) -> Self:
        return self * -1.0

    def __pos__(self) -> Self:
        return self

    def __abs__(self) -> Self:
        return self * np.where(self._replicates.value < 0, -1.0, 1.0)

    def __lt__(self, other: Never) -> NoReturn:
        distance = f"E.z({other!r})" if isinstance(other, Real) else "(E - other).z(0)"
        raise TypeError(
            f"Estimates have no order: compare E.value, or use {distance}, the difference in standard errors"
        )

    __le__ = __gt__ = __ge__ = __lt__

    def __mul__(self, other: Operand) -> Self:
        if (other := self._operand(other)) is None:
            return NotImplemented
        return _combined(product, np.multiply, self, other, self.unit * other.unit)

    __rmul__ = __mul__

    def __truediv__(self, other: Operand) -> Self:
        if other is self:
            with np.errstate(divide="ignore", invalid="ignore"):
                ones = self._replicates.value / self._replicates.value
            return self._known(ones, Unit())
        if (other := self._operand(other)) is None:
            return NotImplemented
        return _combined(ratio, np.divide, self, other, self.unit / other.unit)

    def __rtruediv__(self, other: Operand) -> Self:
        if (other := self._operand(other)) is None:
            return NotImplemented
        return _combined(ratio, np.divide, other, self, other.unit / self.unit)

    def __pow__(self, exponent: float) -> Self:
        if not isinstance(exponent, Real):
            return NotImplemented
        made = self._like(power(self._replicates, exponent), self.unit**exponent)

        def findings() -> tuple[Finding, ...]:
            operand = self._replicates.value, self._raw_findings
            return propagated_findings(lambda x: np.power(x, float(exponent)), operand)

        _keep_error_bars(made, self)
        return made._with_findings(findings, self.allowed)

    def _add_signed(self, other: object, sign: int) -> Self:
        if isinstance(other, Real) and other == 0:  # sum() starts with 0
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
        return _combined(lambda first, second: added(first, second, sign), plain, self, other, self.unit)

    @cached_property
    def _error_bars(self) -> Pooled:
        """Error, degrees of freedom and doubt of each bin, each ``(*dims)``."""
        if self._bars_from is not None:
            return self._bars_from()
        units = {name: axis_unit(name, self.axis_units) for name in self.coords}
        return error_bars_of(self._replicates, self.coords, units)

    def _operand(self, other: object) -> AnyEstimate | None:
        """The other operand; a number or array becomes an exact quantity with the same axes."""
        if isinstance(other, AnyEstimate):
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
        """Make an exact quantity of the same runs and axes."""
        return self._like(Replicates.constant(value, self._replicates.runs), unit)

    @property
    def _whole(self) -> AnyEstimate[float, str | None]:
        """The sum over all bins; a single estimate itself."""
        raise NotImplementedError

    def _like(self, replicates: Replicates, unit: Unit, coords: dict[str, np.ndarray] | None = None) -> Self:
        """Make a quantity of this kind; it has the same axes if `coords` is None."""
        raise NotImplementedError


def _combined(
    function: Callable, plain: Callable, first: AnyEstimate, second: AnyEstimate, unit: Unit
) -> AnyEstimate:
    """Apply a function to the replicates of both operands, with their axes matched by name.

    plain: the same function of bare values.
    """
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
            error = with_axes(np.broadcast_to(second._error_bars.error, below), dims, tuple(coords))
            weak = weak_denominator_findings(aligned[1].value, error)
        return *propagated_findings(plain, *both), *weak

    made = made._with_findings(findings, min(first.allowed, second.allowed))
    uncertain = [each for each in (first, second) if not each.exact]
    if len(uncertain) == 1:
        _keep_error_bars(made, *uncertain)
        if plain is np.multiply or (plain is np.divide and not first.exact):
            made._is_sum_of_scores = uncertain[0]._is_sum_of_scores
    return made


def _aligned_findings(quantity: AnyEstimate, dims: tuple[str, ...]) -> list[Finding]:
    """The findings of a quantity, with bounds along the axes `dims`."""
    own, shape = tuple(quantity.coords), quantity._replicates.shape
    return [
        replace(finding, bound=with_axes(np.broadcast_to(finding.bound, shape), own, dims))
        for finding in quantity._propagated_findings
    ]


def _keep_error_bars(made: AnyEstimate, operand: AnyEstimate) -> None:
    """Let a function of one uncertain quantity keep its pooled errors, which scale as its batches' errors."""
    if made._replicates.is_chunked or tuple(operand.coords) not in ((), tuple(made.coords)):
        return

    def judged() -> Pooled:
        bars, own = operand._error_bars, made._replicates.error
        with np.errstate(divide="ignore", invalid="ignore"):
            error = own * (bars.error / operand._replicates.error)
        return Pooled(error, *(np.broadcast_to(each, np.shape(error)) for each in bars[1:]))

    made._bars_from = judged


def _unwrapped(array: np.ndarray) -> Any:
    """Return a Python value for a single estimate, the array for an array of them."""
    return array.item() if np.ndim(array) == 0 else array
