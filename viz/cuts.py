"""Radiance along polar angle: estimated points on what each bin should hold; several places in one figure."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.container import ErrorbarContainer
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from transport import EstimateArray
from transport.viz.directions import DirectionBins, Radiance, direction_bins
from transport.viz.style import HOLLOW, MARKERS, MUTED, PALETTE, POINTS, figure_at, with_unit
from transport.viz.uncertainty import TRUSTED

FINE = 4001  # points of an analytic line: a jump looks upright
SPREAD = 0.6  # of a bin, over which the points of several curves stand side by side
LINE, BAND = {"lw": 2.0}, {"lw": 7.0, "alpha": 0.3}


def radiance_cuts(
    curves: Mapping[str, EstimateArray],
    path: str | os.PathLike,
    exact: Mapping[str, Callable[[np.ndarray], np.ndarray]] | None = None,
    title: str | None = None,
    steps: bool = True,
    log_x: bool = False,
    note: str | None = None,
) -> str | os.PathLike:
    """Draw radiance against polar angle for several places, one curve a label; returns the path.

    curves: label -> radiance with the axis mu or theta (and phi of one bin).
    exact: label -> the analytic radiance, a function of an array theta [rad]; it may jump.
    steps: whether the means of `exact` over the bins are drawn as well, which is what a bin estimates.
    Raises ValueError for no curves, for unlike units, for more than one bin of azimuth, and for an `exact`
    without a curve.
    """
    bins = {label: direction_bins(curve) for label, curve in curves.items()}
    exact = exact or {}
    unit = _check_curves(bins, exact)
    with figure_at(path, (14, 8.6), title, note) as figure:
        axes, tops = figure.subplots(), []
        for place, (label, each) in enumerate(bins.items()):
            colour, marker = PALETTE[place % len(PALETTE)], MARKERS[place % len(MARKERS)]
            if label in exact:
                law = _along_theta(exact[label])
                tops.append(draw_exact(axes, each, 0, law, colour, steps=steps))
            aside = SPREAD * ((place + 0.5) / len(bins) - 0.5)
            tops.append(draw_points(axes, each, 0, colour, marker, label, aside=aside))
        if exact:
            explain_exact(axes, MUTED, steps)
        reach = max(math.degrees(each.theta.max()) for each in bins.values())
        if log_x:
            axes.set_xscale("log")
            first = min(each.angles[0] - SPREAD / 2 * np.diff(each.theta)[0] for each in bins.values())
            axes.set_xlim(0.8 * math.degrees(first), 1.1 * reach)
            axes.xaxis.set_major_locator(LogLocator(10, subs=(1, 2, 5)))
            axes.xaxis.set_major_formatter(FuncFormatter(lambda angle, _: f"{angle:g}"))
            axes.xaxis.set_minor_locator(NullLocator())
        else:
            axes.set_xlim(0, reach)
        unknown = any(np.isnan(each.error).any() for each in bins.values())
        finish_radiance_axis(axes, unit, max(tops), unknown, columns=4)
    return path


def draw_points(
    axes: Axes,
    bins: DirectionBins,
    column: int,
    colour: str,
    marker: str,
    label: str,
    sign: int = 1,
    aside: float = 0.0,
) -> float:
    """The bins of one azimuth as points with bars of two standard errors; hollow where none is known.

    aside: shift along theta as a share of the bin, so that curves do not hide each other.
    Returns the height that these points need.
    """
    x = sign * np.degrees(bins.angles + aside * np.diff(bins.theta))
    value, error = bins.value[:, column], bins.error[:, column]
    known = np.isfinite(error)
    bars = 2 * error[known]
    axes.errorbar(x[known], value[known], bars, fmt=marker, color=colour, label=label, zorder=4, **POINTS)
    if not known.all():
        axes.plot(x[~known], value[~known], marker, mec=colour, zorder=3, clip_on=False, **HOLLOW)
    trusted = known & (error <= TRUSTED * np.abs(value))
    return max((value + 2 * error)[trusted].max(initial=0.0), value[known].max(initial=0.0))


def draw_exact(
    axes: Axes,
    bins: DirectionBins,
    column: int,
    exact: Radiance,
    colour: str,
    sign: int = 1,
    steps: bool = True,
) -> float:
    """The analytic line in the middle of one azimuth's bins and, as a pale band, its mean over each bin.

    Returns the largest exact value.
    """
    if steps:
        edges, expected = sign * np.degrees(bins.theta), bins.expected(exact, column)
        axes.stairs(expected[::sign], edges[::sign], baseline=None, color=colour, **BAND)
    low, high = bins.theta[[0, -1]]
    theta = np.union1d(np.linspace(low, high, FINE), np.geomspace(max(low, 1e-4 * high), high, FINE))
    phi = np.full(theta.shape, bins.phi[column : column + 2].mean())
    line = np.broadcast_to(exact(theta, phi), theta.shape)
    axes.plot(sign * np.degrees(theta), line, color=colour, zorder=2, **LINE)
    return float(np.nanmax(line))


def explain_exact(axes: Axes, colour: str, steps: bool) -> None:
    """Entries of the legend for the analytic line and its means."""
    axes.plot([], [], color=colour, label="exact", **LINE)
    if steps:
        axes.plot([], [], color=colour, label="exact, bin mean", **BAND)


def finish_radiance_axis(axes: Axes, unit: object, top: float, unknown: bool, columns: int) -> None:
    """Start at zero, name both axes, and put the legend below, where it can cover nothing.

    unknown: whether the legend explains hollow points.
    """
    axes.set_ylim(-0.03 * top, 1.08 * top if top > 0 else 1)
    axes.set_ylabel(with_unit("radiance L", unit))
    axes.set_xlabel("polar angle θ  [deg]")
    if unknown:
        axes.plot([], [], "o", mec=MUTED, label="no error known", **HOLLOW)
    handles, labels = axes.get_legend_handles_labels()
    order = sorted(range(len(labels)), key=lambda place: not isinstance(handles[place], ErrorbarContainer))
    axes.legend(
        [handles[place] for place in order],
        [labels[place] for place in order],
        loc="upper center",
        bbox_to_anchor=(0.5, -0.15),
        ncol=columns,
        columnspacing=1.4,
        handletextpad=0.6,
        handlelength=1.6,
    )


def _along_theta(law: Callable[[np.ndarray], np.ndarray]) -> Radiance:
    return lambda theta, phi: law(theta)


def _check_curves(bins: Mapping[str, DirectionBins], exact: Mapping[str, object]) -> object:
    """The one unit of all curves."""
    units = {str(each.unit) for each in bins.values()}
    if len(units) != 1:
        raise ValueError(f"radiance_cuts: curves of one unit are needed, got {sorted(units) or 'no curves'}")
    if any(len(each.phi) > 2 for each in bins.values()):
        raise ValueError("radiance_cuts: each curve must have one bin of phi; take one by radiance[:, i]")
    if strangers := exact.keys() - bins.keys():
        raise ValueError(f"radiance_cuts: exact names {sorted(strangers)}; the curves are {list(bins)}")
    return units.pop()
