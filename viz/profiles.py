"""A quantity along a coordinate against its analytic curve, with the residuals in standard errors below."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, MaxNLocator

from transport import Estimate, EstimateArray
from viz.style import BLUE, INK, MUTED, ORANGE, PURPLE, SKY, figure_at, with_unit

Curve = Callable[[np.ndarray], np.ndarray]

FURTHEST = 6.0  # standard errors; what lies beyond is an arrow at the edge
BAND = "#dcebf5"


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

    x: n places, or n + 1 edges of bins, in the unit that `xlabel` names;  ylabel: the quantity, its unit is added.
    exact: the analytic value, a function of an array x; residuals are from its value at each place, the
    middle of a bin.  expected: instead of that (n,) exact values, such as means over bins, drawn as steps.
    guides: label -> function of x, drawn dashed to compare with, such as the inverse square.
    Raises ValueError where the numbers of places and estimates do not fit.
    """
    value, error, unit = _columns(estimates)
    x = np.asarray(x, dtype=float)
    if x.ndim != 1 or len(x) not in (len(value), len(value) + 1):
        raise ValueError(f"profile: x must be {len(value)} places or {len(value) + 1} edges, got shape {x.shape}")
    edges = x if len(x) > len(value) else None
    places = x if edges is None else 0.5 * (x[1:] + x[:-1])
    if expected is None and exact is not None:
        expected = np.broadcast_to(exact(places), places.shape)
    with figure_at(path, (13, 9), title, note) as figure:
        if expected is None:
            main, below = figure.subplots(), None
        else:
            main, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
            _draw_residuals(below, places, value, error, np.asarray(expected, dtype=float))
        _draw_curves(main, x, edges, exact, expected, guides or {}, log_x)
        _draw_estimates(main, places, value, error, label)
        _finish(main, below, log_x, log_y)
        main.set_ylabel(with_unit(ylabel, unit))
        (main if below is None else below).set_xlabel(xlabel)
    return path


def _columns(estimates: EstimateArray | Sequence[Estimate]) -> tuple[np.ndarray, np.ndarray, object]:
    """(values, standard errors, unit); raises ValueError for none, unlike units or more than one axis."""
    if isinstance(estimates, EstimateArray):
        if len(estimates.dims) != 1:
            raise ValueError(f"profile: estimates must have one axis, got {estimates.dims}")
        return estimates.value, estimates.error, estimates.unit
    units = {str(each.unit) for each in estimates}
    if len(units) != 1:
        raise ValueError(f"profile: estimates of one unit are needed, got {sorted(units) or 'none'}")
    return np.array([each.value for each in estimates]), np.array([each.error for each in estimates]), units.pop()


def _draw_curves(
    axes: Axes,
    x: np.ndarray,
    edges: np.ndarray | None,
    exact: Curve | None,
    expected: np.ndarray | None,
    guides: Mapping[str, Curve],
    log_x: bool,
) -> None:
    spaced = np.geomspace if log_x and x.min() > 0 else np.linspace
    fine = spaced(x.min(), x.max(), 4001)
    for (label, guide), colour in zip(guides.items(), (ORANGE, PURPLE, SKY), strict=False):
        axes.plot(fine, np.broadcast_to(guide(fine), fine.shape), "--", color=colour, lw=2.4, label=label)
    if exact is not None:
        axes.plot(fine, np.broadcast_to(exact(fine), fine.shape), color=INK, lw=2, label="exact")
    elif edges is not None:
        axes.stairs(expected, edges, baseline=None, color=INK, lw=2, label="exact, mean over a bin")
    else:
        axes.plot(x, expected, "_", color=INK, ms=22, mew=2, label="exact")


def _draw_estimates(axes: Axes, x: np.ndarray, value: np.ndarray, error: np.ndarray, label: str) -> None:
    known = np.isfinite(error)
    axes.errorbar(
        x[known], value[known], 2 * error[known], fmt="o", color=BLUE, capsize=4, lw=2, mec="white", mew=0.8, ms=9, label=f"{label}, ± 2 standard errors", zorder=4
    )
    axes.plot(x[~known], value[~known], "o", mfc="white", mec=BLUE, mew=1.8, zorder=4)


def _draw_residuals(axes: Axes, x: np.ndarray, value: np.ndarray, error: np.ndarray, expected: np.ndarray) -> None:
    z = in_standard_errors(value, error, expected)
    axes.axhspan(-2, 2, color=BAND, lw=0)
    axes.axhline(0, color=INK, lw=1.6)
    reach = float(np.clip(1.25 * np.nanmax(np.abs(z[np.isfinite(z)]), initial=0), 3.2, FURTHEST + 0.7))
    inside = np.abs(z) <= FURTHEST
    axes.plot(x[inside], z[inside], "o", color=BLUE, mec="white", mew=0.8, ms=9)
    for sign, marker in ((1, "^"), (-1, "v")):
        beyond = sign * z > FURTHEST
        axes.plot(x[beyond], np.full(beyond.sum(), sign * 0.9 * reach), marker, color="#D55E00", ms=13)
    axes.set_ylim(-reach, reach)
    axes.yaxis.set_major_locator(MaxNLocator(5, integer=True, steps=[1, 2, 4, 5, 10]))
    axes.set_ylabel("residual\n[standard errors]")


def in_standard_errors(value: np.ndarray, error: np.ndarray, expected: np.ndarray) -> np.ndarray:
    """(value - expected) / error; where the error is 0, 0 if the two agree to 1e-12 and infinite if not."""
    with np.errstate(divide="ignore", invalid="ignore"):
        z = (value - expected) / error
    agree = np.abs(value - expected) <= 1e-12 * np.maximum(np.abs(value), np.abs(expected))
    return np.where((error == 0) & agree, 0.0, z)


def _finish(main: Axes, below: Axes | None, log_x: bool, log_y: bool) -> None:
    if log_x:
        main.set_xscale("log")
    if log_y:
        main.set_yscale("log", nonpositive="mask")
        main.yaxis.set_major_locator(LogLocator(numticks=12))
    elif main.get_ylim()[0] > 0:
        main.set_ylim(bottom=0)
    main.legend(loc="best")
    for axes in (main, below):
        if axes is not None:
            axes.tick_params(which="minor", color=MUTED)
