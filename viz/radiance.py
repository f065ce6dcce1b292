"""One radiance by direction: its map, the map of its standard error, and a cut against the analytic line."""

from __future__ import annotations

import math
import os
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, MultipleLocator, NullLocator

from transport import EstimateArray
from viz.cuts import TRUSTED, draw_exact, draw_points, explain_exact, finish_radiance_axis
from viz.directions import DirectionBins, Radiance, direction_bins
from viz.hemisphere import draw_map, explain_hatching, mark_azimuth
from viz.style import BLUE, INK, VERMILLION, figure_at, with_unit

VALUES, ERRORS = "inferno", "cividis"  # both perceptually uniform, and unlike each other
WIDTH, HEIGHT = 19.2, 7.7  # inches, without a title
MAPS, BARS = ((0.55, 1.45), (6.75, 1.45)), ((1.1, 1.0), (7.3, 1.0))  # lower left corners [inches]
MAP, BAR, CUT = (5.5, 5.5), (4.4, 0.2), (13.7, 2.6, 5.2, 4.35)


class Side(NamedTuple):
    """One half of a cut: which bin of azimuth, to the right (+1) or left (-1), and how it is drawn."""

    column: int
    sign: int
    colour: str
    marker: str


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

    radiance: axes mu or theta, and phi where there is one; over one hemisphere, or a cone of it.
    exact: the analytic radiance, a function of arrays theta and phi [rad]; it may jump.
    azimuth: of the cut [rad], which goes on at the opposite azimuth; the bins that hold them are taken.
    steps: whether the mean of `exact` over each bin is drawn as well, which is what a bin estimates.
    note: provenance in small type, such as particles and seed.
    Raises ValueError for other axes, and for an azimuth that is in no bin.
    """
    bins = direction_bins(radiance)
    sides = _sides(bins, azimuth)
    with figure_at(path, (WIDTH, HEIGHT + (0.7 if title else 0)), title, note, "none") as figure:
        values, errors = (_axes_at(figure, *corner, *MAP) for corner in MAPS)
        bars = [_axes_at(figure, *corner, *BAR) for corner in BARS]
        _map_values(values, bars[0], bins)
        _map_errors(errors, bars[1], bins)
        for side in sides:
            if not bins.is_round:
                mark_azimuth(values, bins, side.column, side.colour)
        _draw_cut(_axes_at(figure, *CUT), bins, sides, exact, steps)
    return path


def _axes_at(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Axes at a place in inches: the panels keep their sizes, whatever their labels are."""
    across, up = figure.get_size_inches()
    return figure.add_axes((left / across, bottom / up, width / across, height / up))


def _sides(bins: DirectionBins, azimuth: float) -> list[Side]:
    """The halves of the cut that there are; one where azimuth is not told."""
    if bins.is_round:
        return [Side(0, 1, VERMILLION, "o")]
    here, opposite = bins.column(azimuth), bins.column(azimuth + math.pi)
    if here is None:
        low, high = bins.phi[[0, -1]]
        raise ValueError(f"radiance_map: azimuth must be {low:.4g} to {high:.4g} rad, got {azimuth!r}")
    sides = [Side(here, 1, VERMILLION, "o")]
    return sides if opposite is None else [*sides, Side(opposite, -1, BLUE, "s")]


def _map_values(axes: Axes, below: Axes, bins: DirectionBins) -> None:
    finite = bins.value[np.isfinite(bins.value)]
    trusted = bins.value[bins.error <= TRUSTED * np.abs(bins.value)]
    shown = trusted if trusted.size else finite
    low, high = min(0.0, shown.min(initial=0.0)), shown.max(initial=0.0)
    norm = Normalize(low, high if high > low else low + 1)
    mesh = draw_map(axes, bins, bins.value, norm, VALUES)
    axes.set_title(with_unit("radiance L", bins.unit))
    beyond = finite.max(initial=0.0) > high
    bar = axes.figure.colorbar(
        mesh, cax=below, orientation="horizontal", extend="max" if beyond else "neither"
    )
    bar.ax.xaxis.set_major_locator(MaxNLocator(5))


def _map_errors(axes: Axes, below: Axes, bins: DirectionBins) -> None:
    percent = _percent(bins)
    positive = percent[percent > 0]
    low, high = (positive.min(), positive.max()) if positive.size else (0.0, 1.0)
    is_wide = high > 5 * low > 0
    mesh = draw_map(axes, bins, percent, LogNorm(low, high) if is_wide else Normalize(0, high), ERRORS)
    axes.set_title("relative standard error  [%]")
    bar = axes.figure.colorbar(mesh, cax=below, orientation="horizontal")
    if is_wide:
        many = high > 1e3 * low
        bar.ax.xaxis.set_major_locator(LogLocator(10, subs=(1,) if many else (1, 2, 5)))
        bar.ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        bar.ax.xaxis.set_minor_locator(NullLocator())
    else:
        bar.ax.xaxis.set_major_locator(MaxNLocator(5))
    if np.isnan(percent).any():
        explain_hatching(axes, "no score" if bins.unscored[np.isnan(percent)].all() else "not known")


def _percent(bins: DirectionBins) -> np.ndarray:
    """Relative standard errors [%], nan where there is none: no score, no error, or a value of 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        percent = np.where(bins.error == 0, 0.0, 100 * bins.error / np.abs(bins.value))
    return np.where(np.isfinite(percent), percent, np.nan)


def _draw_cut(
    axes: Axes, bins: DirectionBins, sides: list[Side], exact: Radiance | None, steps: bool
) -> None:
    tops = []
    for side in sides:
        if exact is not None:
            tops.append(draw_exact(axes, bins, side.column, exact, INK, sign=side.sign, steps=steps))
        low, high = np.degrees(bins.phi[side.column : side.column + 2])
        label = "all φ" if bins.is_round else f"φ = {low:.4g}° to {high:.4g}°"
        tops.append(draw_points(axes, bins, side.column, side.colour, side.marker, label, sign=side.sign))
    if exact is not None:
        explain_exact(axes, INK, steps)
    reach = math.degrees(bins.theta.max())
    axes.set_xlim(-1.03 * reach if len(sides) > 1 else 0, 1.03 * reach)
    unknown = np.isnan(bins.error[:, [side.column for side in sides]]).any()
    finish_radiance_axis(axes, bins.unit, max(tops), bool(unknown), columns=2)
    axes.xaxis.set_major_locator(MultipleLocator(30) if math.isclose(reach, 90) else MaxNLocator(6))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda angle, _: f"{abs(angle):g}"))
    axes.set_title("cut, points ± 2 standard errors")
