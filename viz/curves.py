"""Series along an abscissa: points with bars of two standard errors before exact curves, and residuals below.

One series, or several by their labels, as a figure with title and note:

>>> near = Series(distances, estimates, exact=lambda d: 100 / d**2)  # doctest: +SKIP
>>> plot_curves(near, "near.png", xlabel="distance  [m]", ylabel="irradiance", log_x=True)  # doctest: +SKIP
>>> plot_curves({"near": near, "far": far}, xlabel="distance  [m]")  # doctest: +SKIP

Panels of one figure, each with its residuals:

>>> with figure((16, 9.6), "Two windows", path="both.png") as page:  # doctest: +SKIP
...     grid = page.subplots(2, 2, sharex="col", height_ratios=(2.6, 1))
...     for column, window in zip(grid.T, windows):
...         plot_curves(window, ax=tuple(column), xlabel="depth  [mm]")
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from textwrap import fill
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.container import ErrorbarContainer
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike

from transport import Estimate, EstimateArray
from transport.validation import short_repr
from transport.viz.style import (
    HOLLOW,
    INK,
    MUTED,
    ORANGE,
    POINTS,
    PURPLE,
    SKY,
    VERMILLION,
    WITHIN_TWO,
    figure,
    look,
    tick_log,
    with_unit,
)
from transport.viz.wording import as_it_stands

Curve = Callable[[np.ndarray], ArrayLike] | tuple[ArrayLike, ArrayLike]  # a function of an array x, or (x, y)

FINE = 4001  # points of a function's curve: a jump looks upright
FURTHEST = 6.0  # standard errors; a residual beyond is an arrow at the edge
TRUSTED = 0.25  # relative error; less certain points do not stretch a scale
LOWEST = 1e-9  # share of a value, to which a bar reaches on a logarithmic axis at the most
MANY = 60  # points above which they are drawn small
SMALL_POINTS = POINTS | {"capsize": 0, "lw": 1.4, "mew": 0.0, "ms": 6}
LINE, BAND = {"lw": 2.2}, {"lw": 7.0, "alpha": 0.3}  # of an exact curve, of its means over bins
GUIDES = (ORANGE, PURPLE, SKY, VERMILLION)
ERRORS_SHOWN = "points ± 2 standard errors"
UNSURE = "error unknown or doubtful"
UNNAMED = "simulated"  # label of a series without one
LONG_LABEL = (
    20  # characters; with longer labels the entries of a legend above its panel stand one below another
)
NOTE_WIDTH = 55  # characters of a note below each panel of a sweep
MOST_INSIDE = 4  # entries of a legend in the panel; more stand beside it


class Series(NamedTuple):
    """Estimates along x, and what they should be.

    Parameters
    ----------
    x : ArrayLike (n,) or (n + 1,)
        Places, or edges of bins, in the unit that the axis names.
    estimates : EstimateArray, sequence of Estimate, or tuple (values, standard errors)
        The n estimates; an array has one axis.
    exact : callable or tuple of ArrayLike, optional
        The exact curve: a function of an array x, or (x, y).
    expected : ArrayLike (n,), optional
        Exact values of the points, such as means over bins [default: `exact` at the places].
    places : ArrayLike (n,), optional
        Where the points stand [default: x, or the middles of the bins].
    guides : mapping of str to curve
        Curves to compare this series with, dashed in its colour.
    """

    x: ArrayLike
    estimates: EstimateArray | Sequence[Estimate] | tuple[ArrayLike, ArrayLike]
    exact: Curve | None = None
    expected: ArrayLike | None = None
    places: ArrayLike | None = None
    guides: Mapping[str, Curve] = {}


def plot_curves(
    series: Series | EstimateArray | Mapping[str, Series | EstimateArray],
    path: str | os.PathLike | None = None,
    *,
    ax: Axes | tuple[Axes, Axes] | None = None,
    xlabel: str = "x",
    ylabel: str = "estimate",
    title: str | None = None,
    note: str | None = None,
    guides: Mapping[str, Curve] | None = None,
    levels: Mapping[str, float] | None = None,
    marks: Mapping[str, float] | None = None,
    log_x: bool = False,
    log_y: bool = False,
    span: tuple[float, float] | None = None,
    steps: bool = False,
    means: bool = False,
    residuals: bool = True,
    legend: str | None = None,
    size: tuple[float, float] | None = None,
) -> Figure | Axes:
    """Draw series of estimates with bars of two standard errors, and their residuals below.

    Parameters
    ----------
    series : Series or EstimateArray, or mapping of str to them
        What is drawn, by its label; of an array with one axis the coordinates are taken in SI units.
    path : str or os.PathLike, optional
        File to write [default: none].
    ax : Axes or (Axes, Axes), optional
        Where to draw: the curves, or curves and residuals [default: a new figure].
    xlabel : str
        With the unit.
    ylabel : str
        Without the unit of the estimates, which is added.
    title, note : str, optional
        Of a new figure.
    guides : mapping of str to curve, optional
        Dashed curves to compare with; they do not stretch the scales.
    levels, marks : mapping of str to float, optional
        Heights and places that a dotted line shows, with their words.
    log_x, log_y : bool
        Logarithmic axes.
    span : tuple of float, optional
        Range of the axis, the exact functions and the guides; it grows to hold all points [default: that of all x].
    steps : bool
        Whether estimates over bins are also drawn as steps.
    means : bool
        Whether `expected` over bins is drawn beside `exact`, as pale steps; without `exact` it always is drawn.
    residuals : bool
        Whether a new figure has a panel of residuals where exact values are known.
    legend : str, optional
        Where it stands: "right", "above" or "below" outside, or a place in the panel, such as "upper left" [default: "best",
        or "right" with many entries].
    size : tuple of float, optional
        Of a new figure [inches].

    Returns
    -------
    Figure or Axes
        The new figure, or the axes of the curves if `ax` is given.

    Raises
    ------
    ValueError
        For no series, lengths that do not fit, unlike units, and an array with several axes.

    Notes
    -----
    Points whose error is unknown or doubtful are hollow; without an error there is no residual.  A residual beyond six standard errors is an arrow
    at the edge.  Points with a relative error above 25 % do not stretch a linear scale.
    """
    if ax is not None and (path is not None or title or note or size):
        raise ValueError(
            "plot_curves: path, title, note and size are of a new figure; leave them out with ax="
        )
    named = dict(series) if isinstance(series, Mapping) else {UNNAMED: series}
    points = _resolved(named, span, log_x)
    has_residuals = residuals and any(each.expected is not None for each in points.values())
    panel = Panel(points, guides or {}, levels or {}, marks or {}, span, log_x, log_y, steps, means)
    many = sum((len(points), len(panel.guides), *(len(each.guides) for each in points.values())))
    legend = legend or ("best" if many <= MOST_INSIDE else "right")
    if ax is not None:
        panels = [ax] if isinstance(ax, Axes) else list(np.ravel(ax))
        if not 1 <= len(panels) <= 2 or not all(isinstance(each, Axes) for each in panels):
            raise ValueError(f"plot_curves: ax must be one or two Axes of matplotlib, got {short_repr(ax)}")
        main, below = (*panels, None)[:2]
        _draw(main, below, panel, xlabel, ylabel, legend)
        return main
    with figure(size or (16.5 if legend == "right" else 14, 10), title, note, path) as page:
        if has_residuals:
            main, below = page.subplots(2, 1, sharex=True, height_ratios=(2.7, 1))
        else:
            main, below = page.subplots(), None
        _draw(main, below, panel, xlabel, ylabel, legend)
        page.align_ylabels()
    return page


def in_standard_errors(value: np.ndarray, error: np.ndarray, expected: np.ndarray) -> np.ndarray:
    """(value - expected) / error; where the error is 0, 0 if the two agree to 1e-12 and infinite if not."""
    with np.errstate(divide="ignore", invalid="ignore"):
        residual = (value - expected) / error
    agree = np.abs(value - expected) <= 1e-12 * np.maximum(np.abs(value), np.abs(expected))
    return np.where((error == 0) & agree, 0.0, residual)


def draw_points(
    axes: Axes,
    x: np.ndarray,
    value: np.ndarray,
    error: np.ndarray,
    rank: int = 0,
    label: str | None = None,
    doubtful: np.ndarray | None = None,
) -> None:
    """Points with bars of two standard errors in the look of a series' rank; hollow where that is unknown or doubtful."""
    colour, marker = look(rank)
    known = np.isfinite(error)
    bars = np.tile(2 * error[known], (2, 1))
    if axes.get_yscale() == "log":  # a bar that reaches 0 ends below the panel
        bars[0] = np.minimum(bars[0], (1 - LOWEST) * np.abs(value[known]))
    style = POINTS if len(x) <= MANY else SMALL_POINTS
    axes.errorbar(x[known], value[known], bars, fmt=marker, color=colour, label=label, zorder=4, **style)
    unsure = ~known if doubtful is None else ~known | doubtful
    if unsure.any():
        axes.plot(x[unsure], value[unsure], marker, mec=colour, label=UNSURE, zorder=5, **HOLLOW)


def draw_residuals(axes: Axes, x: np.ndarray, residual: np.ndarray, rank: int = 0) -> None:
    """Residuals in standard errors, in the look of a series' rank, over the band of two; arrows at the edge for those far away."""
    colour, marker = look(rank)
    inside, reach = np.abs(residual) <= FURTHEST, 3.4
    if axes.lines:
        reach = axes.get_ylim()[1]
    else:
        axes.axhspan(-2, 2, color=WITHIN_TWO, lw=0)
        axes.axhline(0, color=INK, lw=1.6)
    reach = max(reach, 1.25 * np.abs(residual[inside]).max(initial=0.0))
    small = {"mew": 0.8} if len(x) <= MANY else {"mew": 0.0, "ms": 6}
    axes.plot(x[inside], residual[inside], marker, color=colour, mec="white", **small)
    for sign, arrow in ((1, "^"), (-1, "v")):
        beyond = sign * residual > FURTHEST
        if beyond.any():
            at_edge = {"transform": axes.get_xaxis_transform(), "ls": "none", "ms": 14, "mec": INK}
            axes.plot(
                x[beyond], np.full(beyond.sum(), 0.5 + 0.43 * sign), marker=arrow, color=colour, **at_edge
            )
    axes.set_ylim(-reach, reach)
    axes.yaxis.set_major_locator(MaxNLocator(5, integer=True, steps=[1, 2, 4, 5, 10]))
    axes.set_ylabel("residual\n[std. errors]")


# ---- What is drawn


@dataclass(frozen=True, eq=False)
class Points:
    """A series with all that was left out filled in: arrays (n,), edges (n + 1,) or None, and curves (x, y)."""

    places: np.ndarray
    edges: np.ndarray | None
    value: np.ndarray
    error: np.ndarray
    doubtful: np.ndarray | None
    unit: str | None
    curve: tuple[np.ndarray, np.ndarray] | None
    expected: np.ndarray | None
    guides: Mapping[str, tuple[np.ndarray, np.ndarray]]


class Panel(NamedTuple):
    """The points by label, and what is drawn with them."""

    points: Mapping[str, Points]
    guides: Mapping[str, Curve]
    levels: Mapping[str, float]
    marks: Mapping[str, float]
    span: tuple[float, float] | None
    log_x: bool
    log_y: bool
    steps: bool
    means: bool

    @property
    def reach(self) -> tuple[float, float]:
        """Ends of all that has an x."""
        ends = [_ends(each) for each in self.points.values()]
        return min(low for low, _ in ends), max(high for _, high in ends)


def _resolved(
    series: Mapping[str, Series], span: tuple[float, float] | None, log_x: bool
) -> dict[str, Points]:
    if not series:
        raise ValueError("plot_curves: at least one series is needed, got none")
    series = {label: _as_series(label, each) for label, each in series.items()}
    read = {label: _read(label, each) for label, each in series.items()}
    if len(units := {unit for *_, unit in read.values() if unit is not None}) > 1:
        raise ValueError(f"plot_curves: estimates of one unit are needed, got {sorted(units)}")
    ends = np.concatenate([x for x, *_ in read.values()])
    ends = ends[np.isfinite(ends)]
    low, high = span or (ends.min(), ends.max())
    fine = (np.geomspace if log_x and low > 0 else np.linspace)(low, high, FINE)
    unit = next(iter(units), None)
    return {label: _points(label, series[label], fine, *read[label][:-1], unit) for label in series}


def _as_series(label: str, each: object) -> Series:
    if isinstance(each, EstimateArray) and len(each.dims) == 1:
        return Series(each.coords[each.dims[0]], each)
    if not isinstance(each, Series):
        must = f"{label!r} must be a Series or an EstimateArray with one axis"
        raise ValueError(f"plot_curves: {must}, got {short_repr(each)}")
    return each


def _read(
    label: str, each: Series
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray | None, str | None]:
    """x, values, errors, which are doubtful, and the unit; None where that is not known."""
    estimates, doubtful, unit = each.estimates, None, None
    if isinstance(estimates, EstimateArray):
        if len(estimates.dims) != 1:
            raise ValueError(f"plot_curves: {label!r} must have one axis, got {estimates.dims}")
        value, error, unit = estimates.value, estimates.error, str(estimates.unit)
        doubtful = estimates.is_doubtful
    elif len(estimates) and isinstance(estimates[0], Estimate):
        value, error = ([getattr(one, name) for one in estimates] for name in ("value", "error"))
        if len(units := {str(one.unit) for one in estimates}) != 1:
            raise ValueError(f"plot_curves: estimates of one unit are needed, got {sorted(units)}")
        unit = units.pop()
    elif isinstance(estimates, tuple) and len(estimates) == 2:
        value, error = estimates
    else:
        must = f"the estimates of {label!r} must be an EstimateArray, a list of Estimate or (values, errors)"
        raise ValueError(f"plot_curves: {must}, got {short_repr(estimates)}")
    value, error, x = (np.asarray(numbers, dtype=float) for numbers in (value, error, each.x))
    if x.ndim != 1 or len(x) not in (len(value), len(value) + 1):
        must = f"{len(value)} places or {len(value) + 1} edges"
        raise ValueError(f"plot_curves: x of {label!r} must be {must}, got {x.shape}")
    return x, value, np.broadcast_to(error, value.shape), doubtful, unit


def _points(
    label: str,
    each: Series,
    fine: np.ndarray,
    x: np.ndarray,
    value: np.ndarray,
    error: np.ndarray,
    doubtful: np.ndarray | None,
    unit: str | None,
) -> Points:
    are_edges = len(x) > len(value)
    places = 0.5 * (x[1:] + x[:-1]) if are_edges else x
    if each.places is not None:
        places = np.asarray(each.places, dtype=float)
    expected = each.expected
    if expected is None and each.exact is not None:
        if callable(each.exact):
            expected = np.broadcast_to(each.exact(places), places.shape)
        else:
            x_exact, exact = (np.asarray(numbers, dtype=float) for numbers in each.exact)
            order = np.argsort(x_exact, kind="stable")
            expected = np.interp(places, x_exact[order], exact[order], left=np.nan, right=np.nan)
    if expected is not None:
        expected = np.asarray(expected, dtype=float)
        if expected.shape != value.shape:
            must = f"must have shape {value.shape}"
            raise ValueError(f"plot_curves: expected of {label!r} {must}, got {expected.shape}")
    curve = None if each.exact is None else drawn_curve(each.exact, fine)
    guides = {words: drawn_curve(guide, fine) for words, guide in each.guides.items()}
    return Points(places, x if are_edges else None, value, error, doubtful, unit, curve, expected, guides)


def drawn_curve(curve: Curve, fine: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A curve as (x, y): a function at these x."""
    if callable(curve):
        return fine, np.broadcast_to(np.asarray(curve(fine), dtype=float), fine.shape)
    return tuple(np.asarray(numbers, dtype=float) for numbers in curve)


def _ends(points: Points) -> tuple[float, float]:
    x = points.places if points.edges is None else points.edges
    if points.curve is not None:
        x = np.concatenate([x, points.curve[0]])
    return np.nanmin(x), np.nanmax(x)


# ---- Drawing


def _draw(main: Axes, below: Axes | None, panel: Panel, xlabel: str, ylabel: str, legend: str) -> None:
    main.set_xscale("log" if panel.log_x else "linear")
    main.set_yscale("log", nonpositive="mask") if panel.log_y else main.set_yscale("linear")
    if all(points.edges is not None for points in panel.points.values()):
        main.margins(x=0.02)
    is_alone = len(panel.points) == 1
    for rank, (label, points) in enumerate(panel.points.items()):
        _draw_exact(main, points, INK if is_alone else look(rank)[0], panel.means)
        if panel.steps and points.edges is not None:
            _draw_steps(main, points.value, points.edges, lw=1.2, alpha=0.6, color=look(rank)[0])
        draw_points(main, points.places, points.value, points.error, rank, label, points.doubtful)
        if below is not None and points.expected is not None:
            residual = in_standard_errors(points.value, points.error, points.expected)
            draw_residuals(below, points.places, residual, rank)
    _explain_exact(main, panel, INK if is_alone else MUTED)
    _draw_lines(main, panel)
    _set_limits(main, panel)
    _draw_guides(main, panel)
    lowest = main if below is None else below
    if panel.span:
        places = np.concatenate([points.places for points in panel.points.values()])
        main.set_xlim(min(panel.span[0], np.nanmin(places)), max(panel.span[1], np.nanmax(places)))
    if panel.log_x:
        tick_log(main.xaxis)
    if panel.log_y:
        tick_log(main.yaxis)
    main.set_ylabel(with_unit(ylabel, next(iter(panel.points.values())).unit or "1"))
    lowest.set_xlabel(xlabel)
    _draw_legend(main, legend)


def _draw_exact(axes: Axes, points: Points, colour: str, means: bool) -> None:
    if points.curve is not None:
        axes.plot(*points.curve, color=colour, zorder=2, **LINE)
        if means and points.edges is not None:
            _draw_steps(axes, points.expected, points.edges, color=colour, **BAND)
    elif points.expected is not None and points.edges is not None:
        _draw_steps(axes, points.expected, points.edges, color=colour, **LINE)
    elif points.expected is not None:
        axes.plot(points.places, points.expected, "_", color=colour, ms=26, mew=2.2)


def _draw_steps(axes: Axes, heights: np.ndarray, edges: np.ndarray, **style: object) -> None:
    """Steps over bins, whose edges may fall."""
    order = slice(None, None, 1 if edges[-1] >= edges[0] else -1)
    axes.stairs(heights[order], edges[order], baseline=None, **style)


def _explain_exact(axes: Axes, panel: Panel, colour: str) -> None:
    """Entries of the legend for the exact curves and means."""
    kinds = {
        (points.curve is not None, points.edges is not None)
        for points in panel.points.values()
        if points.expected is not None
    }
    if any(has_curve for has_curve, _ in kinds):
        axes.plot([], [], color=colour, label="exact", **LINE)
    if (True, True) in kinds and panel.means:
        axes.plot([], [], color=colour, label="exact, bin mean", **BAND)
    if (False, True) in kinds:
        axes.plot([], [], color=colour, label="exact, bin mean", **LINE)
    if kinds == {(False, False)}:
        axes.plot([], [], "_", color=colour, ms=26, mew=2.2, label="exact")


def _draw_lines(axes: Axes, panel: Panel) -> None:
    """Dotted lines, with their words at the right end or beside them."""
    for words, height in panel.levels.items():
        axes.axhline(height, color=MUTED, lw=1.6, ls=":", zorder=1)
        where = {"transform": axes.get_yaxis_transform(), "ha": "right", "va": "bottom"}
        axes.text(0.995, height, words, fontsize="small", **where)
    for rank, (words, place) in enumerate(panel.marks.items()):
        axes.axvline(place, color=MUTED, lw=1.6, ls=":", zorder=1)
        axes.annotate(
            words, (place, 0.82 - 0.055 * rank), (7, 0), axes.get_xaxis_transform(), "offset points",
            va="top", fontsize="small", bbox={"fc": "white", "ec": "none", "pad": 2},
        )  # fmt: skip


def _set_limits(axes: Axes, panel: Panel) -> None:
    """All that is exact or well known; on a linear axis zero is shown unless the values lie far from it."""
    shown = [np.array(list(panel.levels.values()))]
    for points in panel.points.values():
        shown += [points.curve[1]] if points.curve is not None else []
        shown += [points.expected] if points.expected is not None else []
        bars = 2 * np.nan_to_num(points.error)
        trusted = bars <= 2 * TRUSTED * np.abs(points.value)
        shown += [points.value[np.isfinite(points.error)] if not trusted.any() else points.value[trusted]]
        shown += [(points.value + sign * bars)[trusted] for sign in (-1, 1)]
    heights = np.concatenate(shown)
    heights = heights[np.isfinite(heights)]
    if panel.log_y:
        _set_log_limits(axes, panel, heights[heights > 0])
        return
    low, high = heights.min(initial=np.inf), heights.max(initial=-np.inf)
    if not low < high:
        return
    if 0 <= low < 0.7 * high:
        axes.set_ylim(-0.03 * high if low < 0.03 * high else 0.0, 1.08 * high)
    else:
        margin = 0.06 * (high - low)
        axes.set_ylim(low - margin, high + margin)


def _set_log_limits(axes: Axes, panel: Panel, heights: np.ndarray) -> None:
    """All points too, with their bars: down to a tenth of a value whose bar reaches 0."""
    for points in panel.points.values():
        bars = 2 * np.nan_to_num(points.error)
        ends = np.concatenate([np.maximum(points.value - bars, 0.1 * points.value), points.value + bars])
        heights = np.concatenate([heights, ends[np.isfinite(ends) & (ends > 0)]])
    low, high = np.log(heights.min(initial=np.inf)), np.log(heights.max(initial=0.0))
    if low < high:
        axes.set_ylim(np.exp(low - 0.05 * (high - low)), np.exp(high + 0.05 * (high - low)))


def _draw_guides(axes: Axes, panel: Panel) -> None:
    """Dashed curves, under the limits that all else has set."""
    axes.autoscale_view()
    axes.autoscale(False)
    style = {"ls": "--", "lw": 2.6, "zorder": 1.5}
    low, high = panel.reach
    fine = (np.geomspace if panel.log_x and low > 0 else np.linspace)(low, high, FINE)
    for rank, (words, guide) in enumerate(panel.guides.items()):
        axes.plot(*drawn_curve(guide, fine), color=GUIDES[rank % len(GUIDES)], label=words, **style)
    for rank, points in enumerate(panel.points.values()):
        for words, guide in points.guides.items():
            axes.plot(*guide, color=look(rank)[0], label=words, **style)


def _draw_legend(axes: Axes, place: str) -> None:
    """Points first; outside the panel where it could hide something."""
    found = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    order = sorted(found, key=lambda label: not isinstance(found[label], ErrorbarContainer))
    if len(order) == 1:
        corner = {"transform": axes.transAxes, "ha": "right", "va": "bottom", "color": MUTED}
        is_said = order[0] == UNNAMED or order[0] in axes.get_ylabel()
        words = ERRORS_SHOWN if is_said else f"{order[0]}, {ERRORS_SHOWN}"
        axes.text(1.0, 1.01, words, fontsize="small", **corner)
        return
    columns = min(2, len(order)) if max(map(len, order), default=0) <= LONG_LABEL else 1
    where = {
        "right": {"loc": "center left", "bbox_to_anchor": (1.01, 0.5)},
        "above": {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "ncol": columns},
        "below": {"loc": "upper center", "bbox_to_anchor": (0.5, -0.2), "ncol": min(2, len(order))},
    }.get(place, {"loc": place})
    axes.legend(
        [found[label] for label in order], order, title=ERRORS_SHOWN, title_fontsize="small", columnspacing=1.4,
        handletextpad=0.6, **where,
    )  # fmt: skip


def plot_sweep(
    values: Sequence[float],
    series: Mapping[str, tuple[Sequence[Estimate], Sequence[float]]],
    path: str | os.PathLike | None,
    xlabel: str,
    title: str | None = None,
    note: str | None = None,
) -> Figure:
    """Draw quantities against a parameter, a panel each, with two standard errors and the exact values that are known.

    series: estimates and exact values by the quantity's name;  xlabel: of the parameter, with its unit.
    """
    columns = min(len(series), 3)
    rows = -(-len(series) // columns)
    note = as_it_stands(fill(note, NOTE_WIDTH * columns)) if note else None
    with figure((6.2 * columns, 4.6 * rows + 1.0), title, note, path) as page:
        grid = page.subplots(rows, columns, squeeze=False)
        for axes, (label, (estimates, exact)) in zip(grid.flat, series.items(), strict=False):
            value = np.array([each.value for each in estimates])
            error = np.array([each.error for each in estimates])
            draw_points(axes, np.asarray(values, dtype=float), value, error)
            if np.isfinite(exact).any():  # marks, because a line between the values would not be exact
                axes.plot(values, exact, "_", color=INK, ms=26, mew=2.2, label="exact", zorder=2)
                axes.legend()
            axes.set(xlabel=xlabel, ylabel=with_unit("", estimates[0].unit).strip(), title=label)
        for axes in list(grid.flat)[len(series) :]:
            axes.remove()
    return page
