"""One radiance by direction: its map, the map of its standard error, and a cut against the analytic line."""

from __future__ import annotations

import math
import os

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from transport import EstimateArray
from viz.cuts import BARS, draw_exact, draw_points, finish_radiance_axis
from viz.directions import DirectionBins, Radiance, direction_bins
from viz.hemisphere import draw_map, explain_hatching, mark_azimuth
from viz.style import BLUE, VERMILLION, figure_at, with_unit

VALUES, ERRORS = "inferno", "cividis"
TRUSTED = 0.25  # bins of a larger relative error do not stretch the scale of values


def radiance_map(
    radiance: EstimateArray,
    path: str | os.PathLike,
    exact: Radiance | None = None,
    title: str | None = None,
    azimuth: float = 0.0,
    steps: bool = True,
    note: str | None = None,
) -> str | os.PathLike:
    """Draw a radiance by direction with its relative standard error [%] and a cut; returns the path.

    radiance: axes mu or theta, and phi where there is one; over one hemisphere.
    exact: the analytic radiance, a function of arrays theta and phi [rad]; it may jump.
    azimuth: of the cut [rad], which goes on at the opposite azimuth; for the bins that hold it.
    steps: whether the mean of `exact` over each bin is drawn as well, which is what a bin estimates.
    note: provenance in small type, such as particles and seed.
    Raises ValueError for other axes, and for an azimuth that is in no bin.
    """
    bins = direction_bins(radiance)
    sides = _sides(bins, azimuth)
    with figure_at(path, (20, 7.2 if title else 6.7), title, note) as figure:
        values, errors, cut = figure.subplots(1, 3, width_ratios=(1, 1, 1.12))
        _map_values(figure, values, bins)
        _map_errors(figure, errors, bins)
        for column, _, colour, _ in sides:
            if not bins.is_round:
                mark_azimuth(values, bins, column, colour)
        _cut(cut, bins, sides, exact, steps)
    return path


def _sides(bins: DirectionBins, azimuth: float) -> list[tuple[int, int, str, str]]:
    """(bin of azimuth, sign of theta, colour, marker) of the cut's two halves; of one where phi is not told."""
    if bins.is_round:
        return [(0, 1, VERMILLION, "o")]
    here, opposite = bins.column(azimuth), bins.column(azimuth + math.pi)
    if here is None:
        raise ValueError(f"radiance_map: no bin of phi holds the azimuth {azimuth!r} rad; take one within {bins.phi}")
    sides = [(here, 1, VERMILLION, "o"), (opposite, -1, BLUE, "s")]
    return [side for side in sides if side[0] is not None]


def _map_values(figure: Figure, axes: Axes, bins: DirectionBins) -> None:
    finite = np.isfinite(bins.value)
    trusted = finite & (bins.error <= TRUSTED * np.abs(bins.value))
    shown = bins.value[trusted] if trusted.any() else bins.value[finite]
    low, high = min(0.0, shown.min(initial=0.0)), shown.max(initial=0.0)
    beyond = bins.value[finite].max(initial=0.0) > high
    mesh = draw_map(axes, bins, bins.value, Normalize(low, high if high > low else low + 1), VALUES)
    axes.set_title(with_unit("radiance", bins.unit))
    figure.colorbar(mesh, ax=axes, shrink=0.78, pad=0.03, extend="max" if beyond else "neither")


def _map_errors(figure: Figure, axes: Axes, bins: DirectionBins) -> None:
    with np.errstate(divide="ignore", invalid="ignore"):
        percent = np.where(bins.error == 0, 0.0, 100 * bins.error / np.abs(bins.value))
    percent[np.isinf(percent)] = np.nan
    positive = percent[percent > 0]
    low, high = (positive.min(), positive.max()) if positive.size else (0.0, 1.0)
    logarithmic = low > 0 and high > 5 * low
    norm = LogNorm(low, high) if logarithmic else Normalize(0, high)
    mesh = draw_map(axes, bins, percent, norm, ERRORS)
    axes.set_title("relative standard error  [%]")
    bar = figure.colorbar(mesh, ax=axes, shrink=0.78, pad=0.03)
    if logarithmic:
        bar.ax.yaxis.set_major_locator(LogLocator(10, subs=(1, 2, 5)))
        bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        bar.ax.yaxis.set_minor_locator(NullLocator())
    if np.isnan(percent).any():
        explain_hatching(axes, "no score" if bins.unscored[np.isnan(percent)].all() else "error unknown")


def _cut(axes: Axes, bins: DirectionBins, sides: list, exact: Radiance | None, steps: bool) -> None:
    for column, sign, colour, marker in sides:
        if exact is not None:
            draw_exact(axes, bins, column, exact, sign=sign, steps=steps, labelled=sign > 0)
        low, high = np.degrees(bins.phi[column : column + 2])
        label = "all φ" if bins.is_round else f"φ = {low:.4g}° to {high:.4g}°"
        draw_points(axes, bins, column, colour, marker, label, sign=sign)
    reach = math.degrees(bins.theta.max())
    axes.set_xlim(-1.03 * reach if len(sides) > 1 else 0, 1.03 * reach)
    finish_radiance_axis(axes, bins.unit)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda angle, _: f"{abs(angle):g}"))
    axes.set_xlabel("polar angle θ  [deg]")
    axes.set_title(f"cut, points {BARS}")
