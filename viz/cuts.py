"""Radiance along polar angle: estimated points on what each bin should hold; several distances in one figure."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping

import numpy as np
from matplotlib.axes import Axes

from transport import EstimateArray
from viz.directions import DirectionBins, Radiance, direction_bins
from viz.style import INK, MARKERS, MUTED, PALETTE, figure_at, with_unit

BARS = "± 2 standard errors"
FINE = 4001  # points of an analytic line: a jump looks upright


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

    curves: label -> radiance with the one axis mu or theta (and a phi of one bin).
    exact: label -> the analytic radiance, a function of an array theta [rad]; it may jump.
    steps: whether the means of `exact` over the bins are drawn as well.
    Raises ValueError for no curves, for unlike units, and for more than one bin of azimuth.
    """
    bins = {label: direction_bins(curve) for label, curve in curves.items()}
    units = {str(each.unit) for each in bins.values()}
    if len(units) != 1:
        raise ValueError(f"radiance_cuts: curves of one unit are needed, got {sorted(units) or 'no curves'}")
    if any(len(each.phi) > 2 for each in bins.values()):
        raise ValueError("radiance_cuts: each curve must have one bin of phi; take one by radiance[:, i]")
    with figure_at(path, (13, 8), title, note) as figure:
        axes = figure.subplots()
        for place, (label, each) in enumerate(bins.items()):
            colour, marker = PALETTE[place % len(PALETTE)], MARKERS[place % len(MARKERS)]
            if exact is not None and label in exact:
                law = exact[label]
                draw_exact(axes, each, 0, lambda theta, phi, law=law: law(theta), colour=colour, steps=steps, labelled=False)
            draw_points(axes, each, 0, colour, marker, label)
        if log_x:
            axes.set_xscale("log")
        else:
            axes.set_xlim(0, max(math.degrees(each.theta.max()) for each in bins.values()))
        finish_radiance_axis(axes, units.pop())
        axes.set_xlabel("polar angle θ  [deg]")
    return path


def draw_points(
    axes: Axes, bins: DirectionBins, column: int, colour: str, marker: str, label: str, sign: int = 1
) -> None:
    """The bins of one azimuth as points with bars of two standard errors; hollow where none is known."""
    x, value, error = sign * np.degrees(bins.angles), bins.value[:, column], bins.error[:, column]
    known = np.isfinite(error)
    bars = axes.errorbar(
        x[known], value[known], 2 * error[known], fmt=marker, color=colour, capsize=4, lw=2, mec="white", mew=0.8, label=label, zorder=4
    )
    axes.plot(x[~known], value[~known], marker, mfc="white", mec=colour, mew=1.8, zorder=3)
    bars.lines[0].set_clip_on(False)


def draw_exact(
    axes: Axes,
    bins: DirectionBins,
    column: int,
    exact: Radiance,
    sign: int = 1,
    colour: str = INK,
    steps: bool = True,
    labelled: bool = True,
) -> None:
    """The analytic line in the middle of one azimuth's bins and, as a pale band, its mean over each bin."""
    if steps:
        edges, expected = sign * np.degrees(bins.theta), bins.expected(exact, column)
        axes.stairs(
            expected[::sign], edges[::sign], baseline=None, color=MUTED if colour == INK else colour, alpha=0.3, lw=7, label="exact, mean over a bin" if labelled else None
        )
    theta = np.linspace(bins.theta[0], bins.theta[-1], FINE)
    line = np.broadcast_to(exact(theta, np.full(FINE, bins.phi[column : column + 2].mean())), FINE)
    axes.plot(sign * np.degrees(theta), line, color=colour, lw=1.8, label="exact" if labelled else None, zorder=2)


def finish_radiance_axis(axes: Axes, unit: object) -> None:
    """Start at zero, leave head room for the legend, and name the unit."""
    heights = [np.nanmax(line.get_ydata(), initial=0.0) for line in axes.lines]
    top = max(heights, default=1.0)
    axes.set_ylim(-0.02 * top, 1.4 * top if top > 0 else 1)
    axes.set_ylabel(with_unit("radiance L", unit))
    axes.legend(loc="upper center", ncol=2)
