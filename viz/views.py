"""The same thing seen several times: round maps of radiance in one scale, and all of them along polar angle
below."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize

from transport import EstimateArray
from transport.viz.cuts import BAND, FINE, LINE
from transport.viz.directions import DirectionBins, direction_bins
from transport.viz.hemisphere import draw_map, explain_hatching
from transport.viz.style import INK, MARKERS, MUTED, PALETTE, POINTS, figure_at, with_unit
from transport.viz.uncertainty import TRUSTED

Law = Callable[[np.ndarray], np.ndarray]

COLOURS = "inferno"
DARKEST = 1e-4  # of the brightest: the lower end of a logarithmic scale
PANEL = 5.2  # inches


def views(
    seen: Mapping[str, EstimateArray],
    path: str | os.PathLike,
    exact: Mapping[str, Law] | None = None,
    title: str | None = None,
    log: bool = False,
    note: str | None = None,
) -> str | os.PathLike:
    """Draw each radiance as a map of the hemisphere, then all as points with exact lines; returns the path.

    seen: label -> radiance with the axis mu or theta and one bin of azimuth.  exact: label -> the analytic
    radiance, a function of an array theta [rad]; its means over the bins are drawn as well.  log: colours and cut
    over decades; bins in which nothing was counted are hatched, but where the law has nothing. Raises ValueError
    for no views, for unlike units, and for more than one bin of azimuth.
    """
    views_ = {label: direction_bins(radiance) for label, radiance in seen.items()}
    units = {str(each.unit) for each in views_.values()}
    if len(units) != 1 or not all(each.is_round for each in views_.values()):
        raise ValueError(
            f"views: radiances of one unit, each round, are needed, got {sorted(units) or 'none'}"
        )
    norm, exact = _norm(views_, log), exact or {}
    with figure_at(path, (max(PANEL * len(views_), 13) + 1.6, 14), title, note) as figure:
        above, below = figure.subfigures(2, 1, height_ratios=(1, 1.15))
        panels = above.subplots(1, len(views_), squeeze=False)[0]
        for axes, (label, bins) in zip(panels, views_.items(), strict=True):
            field = _shown_on_map(bins, exact.get(label), norm) if log else bins.value
            mesh = draw_map(axes, bins, field, norm, COLOURS)
            if np.isnan(field).any():
                explain_hatching(axes, "nothing counted")
            axes.set_title(label)
        bar = above.colorbar(mesh, ax=panels, shrink=0.8, pad=0.01, extend="min" if log else "neither")
        bar.set_label(with_unit("radiance L", units.copy().pop()))
        _draw_cut(below.subplots(), views_, exact, log, norm, units.pop())
    return path


def _shown_on_map(bins: DirectionBins, law: Law | None, norm: Normalize) -> np.ndarray:
    """Radiance, darkest where the law has none, and nan where none was counted that might be there."""
    dark = _means(bins, law)[:, None] == 0 if law else np.zeros(bins.value.shape, bool)
    return np.where(bins.value > 0, np.maximum(bins.value, norm.vmin), np.where(dark, norm.vmin, np.nan))


def _means(bins: DirectionBins, law: Law) -> np.ndarray:
    """Means of the law over the bins, (n,)."""
    return bins.expected(lambda theta, phi: np.broadcast_to(law(theta), theta.shape), 0)


def _norm(views_: Mapping[str, DirectionBins], log: bool) -> Normalize:
    """One scale for all, up to the brightest bin that is well known."""
    top = (
        max(each.value[each.error <= TRUSTED * each.value].max(initial=0.0) for each in views_.values())
        or 1.0
    )
    return LogNorm(DARKEST * top, top, clip=True) if log else Normalize(0, top, clip=True)


def _draw_cut(
    axes: Axes, views_: Mapping[str, DirectionBins], exact: Mapping, log: bool, norm: Normalize, unit
) -> None:
    reach = max(math.degrees(each.theta.max()) for each in views_.values())
    theta = np.linspace(0, math.radians(reach), FINE)
    for place, (label, bins) in enumerate(views_.items()):
        colour, marker = PALETTE[place % len(PALETTE)], MARKERS[place % len(MARKERS)]
        if label in exact:
            line, means = np.asarray(exact[label](theta), dtype=float), _means(bins, exact[label])
            hidden = np.nan if log else 0.0
            axes.plot(np.degrees(theta), np.where(line > 0, line, hidden), color=colour, **LINE)
            steps = np.where(means > 0, means, hidden)
            axes.stairs(steps, np.degrees(bins.theta), baseline=None, color=colour, **BAND)
        value, error = bins.value[:, 0], bins.error[:, 0]
        shown = np.isfinite(error) & (value > 0) if log else np.isfinite(error)
        bars = 2 * error[shown]
        if log:
            bars = np.minimum(bars, 0.9 * value[shown])
        axes.errorbar(
            np.degrees(bins.angles)[shown],
            value[shown],
            bars,
            fmt=marker,
            color=colour,
            label=label,
            **POINTS,
        )
    if exact:
        axes.plot([], [], color=INK, label="exact", **LINE)
        axes.plot([], [], color=MUTED, label="exact, bin mean", **BAND)
    if log:
        axes.set_yscale("log")
        axes.set_ylim(norm.vmin, 2 * norm.vmax)
    else:
        axes.set_ylim(-0.03 * norm.vmax, 1.1 * norm.vmax)
    axes.set_xlim(0, reach)
    axes.set_xlabel("polar angle θ  [deg]")
    axes.set_ylabel(with_unit("radiance L", unit))
    axes.legend(loc="best", title="points ± 2 standard errors", title_fontsize=15)
