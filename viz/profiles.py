"""A quantity along a coordinate against its analytic curve, with the residuals in standard errors below."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, MaxNLocator

from transport import Estimate, EstimateArray
from transport.viz.style import (
    BLUE,
    HOLLOW,
    INK,
    ORANGE,
    POINTS,
    PURPLE,
    SKY,
    VERMILLION,
    WITHIN_TWO,
    figure_at,
    with_unit,
)

Curve = Callable[[np.ndarray], np.ndarray]

FINE = 4001  # points of an analytic curve
FURTHEST = 6.0  # standard errors; a residual beyond is an arrow at the edge


class Series(NamedTuple):
    """Estimates along x: places (n,), edges (n + 1,) if they are bins, values and standard errors (n,)."""

    places: np.ndarray
    edges: np.ndarray | None
    value: np.ndarray
    error: np.ndarray
    unit: object


def profile(
    x: Sequence[float] | np.ndarray,
    estimates: EstimateArray | Sequence[Estimate],
    path: str | os.PathLike,
    exact: Curve | None = None,
    expected: Sequence[float] | np.ndarray | None = None,
    guides: Mapping[str, Curve] | None = None,
    xlabel: str = "x",
    ylabel: str = "estimate",
    label: str = "simulated",
    title: str | None = None,
    log_x: bool = False,
    log_y: bool = False,
    note: str | None = None,
) -> str | os.PathLike:
    """Draw n estimates along x with bars of two standard errors, and residuals below; returns the path.

    x: n places, or n + 1 edges of bins, in the unit that `xlabel` names.  ylabel: without unit, it is added.
    exact: the analytic value, a function of an array x; residuals are from it at each place, or at the
    middle of each bin.  expected: (n,) exact values to take for the residuals instead, such as means over
    bins; drawn as steps where x are edges.  Without both there are no residuals.
    guides: label -> function of x, drawn dashed to compare with, such as the inverse square.
    Raises ValueError where lengths do not fit, for unlike units, and for estimates of several axes.
    """
    series = _series(x, estimates)
    if expected is None and exact is not None:
        expected = np.broadcast_to(exact(series.places), series.places.shape)
    if expected is not None and np.shape(expected) != series.places.shape:
        raise ValueError(f"profile: expected must have shape {series.places.shape}, got {np.shape(expected)}")
    with figure_at(path, (13.5, 9.6), title, note) as figure:
        if expected is None:
            main = lowest = figure.subplots()
        else:
            main, lowest = figure.subplots(2, 1, sharex=True, height_ratios=(2.5, 1))
            expected = np.asarray(expected, dtype=float)
            _draw_exact(main, series, exact, expected, log_x)
            _draw_residuals(lowest, series, expected)
        _draw_estimates(main, series, label)
        _scale(main, log_x, log_y)
        _draw_guides(main, series, guides or {}, log_x)
        main.legend(loc="best")
        main.set_ylabel(with_unit(ylabel, series.unit))
        lowest.set_xlabel(xlabel)
        figure.align_ylabels()
    return path


def in_standard_errors(value: np.ndarray, error: np.ndarray, expected: np.ndarray) -> np.ndarray:
    """(value - expected) / error; where the error is 0, 0 if the two agree to 1e-12 and infinite if not."""
    with np.errstate(divide="ignore", invalid="ignore"):
        residual = (value - expected) / error
    agree = np.abs(value - expected) <= 1e-12 * np.maximum(np.abs(value), np.abs(expected))
    return np.where((error == 0) & agree, 0.0, residual)


def _series(x: Sequence[float] | np.ndarray, estimates: EstimateArray | Sequence[Estimate]) -> Series:
    if isinstance(estimates, EstimateArray):
        if len(estimates.dims) != 1:
            raise ValueError(f"profile: estimates must have one axis, got {estimates.dims}")
        value, error, units = estimates.value, estimates.error, {str(estimates.unit)}
    else:
        value, error = (np.array([getattr(each, name) for each in estimates]) for name in ("value", "error"))
        units = {str(each.unit) for each in estimates}
    if len(units) != 1:
        raise ValueError(f"profile: estimates of one unit are needed, got {sorted(units) or 'none'}")
    x = np.asarray(x, dtype=float)
    if x.ndim != 1 or len(x) not in (len(value), len(value) + 1):
        raise ValueError(f"profile: x must be {len(value)} places or {len(value) + 1} edges, got {x.shape}")
    are_edges = len(x) > len(value)
    places = 0.5 * (x[1:] + x[:-1]) if are_edges else x
    return Series(places, x if are_edges else None, value, error, units.pop())


def _fine(series: Series, log_x: bool) -> np.ndarray:
    x = series.places if series.edges is None else series.edges
    return (np.geomspace if log_x and x.min() > 0 else np.linspace)(x.min(), x.max(), FINE)


def _draw_exact(axes: Axes, series: Series, exact: Curve | None, expected: np.ndarray, log_x: bool) -> None:
    if exact is not None:
        fine = _fine(series, log_x)
        axes.plot(fine, np.broadcast_to(exact(fine), fine.shape), color=INK, lw=2.2, label="exact")
    elif series.edges is not None:
        axes.stairs(expected, series.edges, baseline=None, color=INK, lw=2.2, label="exact, bin mean")
    else:
        axes.plot(series.places, expected, "_", color=INK, ms=26, mew=2.2, label="exact")


def _draw_estimates(axes: Axes, series: Series, label: str) -> None:
    x, value, error = series.places, series.value, series.error
    known = np.isfinite(error)
    bars = 2 * error[known]
    words = f"{label}, ± 2 standard errors"
    axes.errorbar(x[known], value[known], bars, fmt="o", color=BLUE, label=words, zorder=4, **POINTS)
    if not known.all():
        axes.plot(x[~known], value[~known], "o", mec=BLUE, zorder=4, label="no error known", **HOLLOW)


def _draw_guides(axes: Axes, series: Series, guides: Mapping[str, Curve], log_x: bool) -> None:
    """Dashed lines to compare with, under limits that the estimates have set."""
    axes.autoscale(False)
    fine = _fine(series, log_x)
    colours = (ORANGE, PURPLE, SKY, VERMILLION)
    for place, (label, guide) in enumerate(guides.items()):
        line = np.broadcast_to(guide(fine), fine.shape)
        axes.plot(fine, line, "--", color=colours[place % len(colours)], lw=2.6, label=label, zorder=1.5)


def _draw_residuals(axes: Axes, series: Series, expected: np.ndarray) -> None:
    x, residual = series.places, in_standard_errors(series.value, series.error, expected)
    axes.axhspan(-2, 2, color=WITHIN_TWO, lw=0)
    axes.axhline(0, color=INK, lw=1.6)
    inside = np.abs(residual) <= FURTHEST
    reach = max(3.4, 1.25 * np.abs(residual[inside]).max(initial=0.0))
    axes.plot(x[inside], residual[inside], "o", color=BLUE, mec="white", mew=0.8)
    for sign, marker in ((1, "^"), (-1, "v")):
        beyond = sign * residual > FURTHEST
        axes.plot(x[beyond], np.full(beyond.sum(), 0.86 * sign * reach), marker, color=VERMILLION, ms=14)
    axes.set_ylim(-reach, reach)
    axes.yaxis.set_major_locator(MaxNLocator(5, integer=True, steps=[1, 2, 4, 5, 10]))
    axes.set_ylabel("residual\n[std. errors]")


def _scale(axes: Axes, log_x: bool, log_y: bool) -> None:
    """Set the scales; a linear one shows its zero unless the values lie far from it."""
    if log_x:
        axes.set_xscale("log")
    if log_y:
        axes.set_yscale("log", nonpositive="mask")
        axes.yaxis.set_major_locator(LogLocator(numticks=12))
        return
    low, high = axes.get_ylim()
    if 0 < low < 0.7 * high:
        axes.set_ylim(bottom=0)
