"""One radiance by direction: its map, the map of its standard error, and a cut against the analytic line."""

from __future__ import annotations

import math
import os
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, MaxNLocator, MultipleLocator

from transport import EstimateArray
from transport.viz.cuts import draw_exact, draw_points, explain_exact, finish_radiance_axis
from transport.viz.directions import DirectionBins, Radiance, direction_bins
from transport.viz.hemisphere import draw_map, explain_hatching, mark_azimuth, on_plan
from transport.viz.style import BLUE, INK, VERMILLION, axes_at, figure_at, with_unit
from transport.viz.uncertainty import (
    ERRORS,
    TITLE,
    VALUES,
    error_bar,
    error_norm,
    gap_words,
    hatch,
    on_scale,
    percent_of,
    value_bar,
    value_norm,
)

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
    decades: float | None = None,
) -> str | os.PathLike:
    """Draw a radiance by direction with its relative standard error [%] and a cut; returns the path.

    radiance: axes mu or theta, and phi where there is one; over one hemisphere, or a cone of it.
    exact: the analytic radiance, a function of arrays theta and phi [rad]; it may jump.
    azimuth: of the cut [rad], which goes on at the opposite azimuth; the bins that hold them are taken.
    steps: whether the mean of `exact` over each bin is drawn as well, which is what a bin estimates.
    note: provenance in small type, such as particles and seed.  decades: logarithmic scales so far down from the brightest.
    Raises ValueError for other axes, and for an azimuth that is in no bin.
    """
    bins = direction_bins(radiance)
    sides = _sides(bins, azimuth)
    with figure_at(path, (WIDTH, HEIGHT + (0.7 if title else 0)), title, note, "none") as figure:
        values, errors = (axes_at(figure, *corner, *MAP) for corner in MAPS)
        bars = [axes_at(figure, *corner, *BAR) for corner in BARS]
        _map_values(values, bars[0], bins, decades)
        _map_errors(errors, bars[1], bins)
        for side in sides:
            if not bins.is_round:
                mark_azimuth(values, bins, side.column, side.colour)
        cut = axes_at(figure, *CUT)
        top = _draw_cut(cut, bins, sides, exact, steps)
        if decades is not None and top > 0:
            cut.set_yscale("log", nonpositive="clip")
            cut.set_ylim(top * 10.0**-decades, 1.5 * top)
    return path


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


def _map_values(axes: Axes, below: Axes, bins: DirectionBins, decades: float | None) -> None:
    norm = value_norm(bins.value, bins.error, decades)
    mesh = draw_map(axes, bins, on_scale(bins.value, norm), norm, VALUES)
    axes.set_title(with_unit("radiance L", bins.unit))
    value_bar(mesh, norm, bins.value, cax=below)


def _map_errors(axes: Axes, below: Axes, bins: DirectionBins) -> None:
    percent = percent_of(bins.value, bins.error)
    norm = error_norm(percent)
    mesh = draw_map(axes, bins, percent, norm, ERRORS)
    axes.set_title(TITLE)
    error_bar(mesh, norm, cax=below)
    hatch(axes, *on_plan(bins, bins.doubtful & ~np.isnan(percent)))
    if words := gap_words(percent, bins.unscored, bins.doubtful):
        explain_hatching(axes, words.replace(", ", ",\n"))


def _draw_cut(
    axes: Axes, bins: DirectionBins, sides: list[Side], exact: Radiance | None, steps: bool
) -> float:
    """Both halves as points on the exact line; returns the height that they need."""
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
    return max(tops)
