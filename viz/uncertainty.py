"""A map of values beside a map of relative standard errors: what is drawn in each bin, on which scale, with which bar."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar
from matplotlib.colors import LogNorm, Normalize
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullLocator

from transport.viz.style import HATCHING, HOLLOW, MUTED, PALE, POINTS

VALUES, ERRORS = "inferno", "cividis"  # both perceptually uniform, and unlike each other
TITLE = "relative standard error  [%]"
TRUSTED = 0.25  # relative error; less certain bins do not stretch a scale
MANY = 60  # points along an axis, above which they are drawn small
WIDE = 5.0  # times the least error, from which on the scale is logarithmic


def value_norm(value: np.ndarray, error: np.ndarray, decades: float | None = None) -> Normalize:
    """From 0 (or the least, below it) to the greatest value that is well known, or so many decades down from there.

    Raises ValueError for decades of negative values.
    """
    trusted = value[error <= TRUSTED * np.abs(value)]
    shown = trusted if trusted.size else value[np.isfinite(value)]
    low, high = min(0.0, shown.min(initial=0.0)), shown.max(initial=0.0)
    if decades is None:
        return Normalize(low, high if high > low else low + 1)
    if low < 0:
        raise ValueError(f"decades: a logarithmic scale has no place for {low:.4g}; leave decades out")
    high = high or value[value > 0].max(initial=0.0) or 1.0
    return LogNorm(high * 10.0**-decades, high)


def on_scale(value: np.ndarray, norm: Normalize) -> np.ndarray:
    """The values; on a logarithmic scale what is fainter at its darkest end, and nan for what has no logarithm."""
    if not isinstance(norm, LogNorm):
        return value
    return np.where(value > 0, np.maximum(value, norm.vmin), np.nan)


def value_bar(drawn: ScalarMappable, norm: Normalize, value: np.ndarray, cax: Axes) -> Colorbar:
    """The colour bar of a map of values, with an arrow at each end that some of them lie beyond."""
    bar = cax.figure.colorbar(drawn, cax=cax, orientation="horizontal", extend=beyond(value, norm))
    if not isinstance(norm, LogNorm):
        bar.ax.xaxis.set_major_locator(MaxNLocator(5))
    return bar


def beyond(value: np.ndarray, norm: Normalize) -> str:
    """The ends of a scale that some values lie beyond, as `extend` of a colour bar."""
    finite = value[np.isfinite(value)]
    ends = finite.min(initial=norm.vmax) < norm.vmin, finite.max(initial=norm.vmin) > norm.vmax
    return {(True, True): "both", (True, False): "min", (False, True): "max"}.get(ends, "neither")


def draw_points(
    axes: Axes, x: np.ndarray, value: np.ndarray, error: np.ndarray, colour: str, mark: str, label: str
) -> None:
    """Points with bars of two standard errors; hollow where none is known."""
    known = np.isfinite(error)
    style = POINTS if len(x) <= MANY else POINTS | {"capsize": 0, "lw": 1.4, "mew": 0.0, "ms": 4}
    axes.errorbar(x[known], value[known], 2 * error[known], fmt=mark, color=colour, label=label, **style)
    if not known.all():
        axes.plot(x[~known], value[~known], mark, mec=colour, label="no error known", clip_on=False, **HOLLOW)


def percent_of(value: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Relative standard errors [%], nan where there is none: no score, no error, or a value of 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        percent = np.where(error == 0, 0.0, 100 * error / np.abs(value))
    return np.where(np.isfinite(percent), percent, np.nan)


def error_norm(percent: np.ndarray) -> Normalize:
    """From the least to the greatest over decades where they differ much, from 0 where they do not."""
    positive = percent[percent > 0]
    low, high = (positive.min(), positive.max()) if positive.size else (0.0, 1.0)
    return LogNorm(low, high) if high > WIDE * low > 0 else Normalize(0, high)


def error_bar(drawn: ScalarMappable, norm: Normalize, cax: Axes) -> Colorbar:
    """The colour bar of a map of errors, with plain numbers."""
    bar = cax.figure.colorbar(drawn, cax=cax, orientation="horizontal")
    tick_errors(bar.ax.xaxis, norm)
    return bar


def tick_errors(axis: Axis, norm: Normalize) -> None:
    """Plain numbers along a bar of errors: 1, 2, 5, or where they span much one a decade."""
    if not isinstance(norm, LogNorm):
        axis.set_major_locator(MaxNLocator(5))
        return
    many = norm.vmax > 1e3 * norm.vmin
    axis.set_major_locator(LogLocator(10, subs=(1,) if many else (1, 2, 5)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_locator(NullLocator())


def hatch(
    axes: Axes,
    doubtful: np.ndarray | None = None,
    across: np.ndarray | None = None,
    up: np.ndarray | None = None,
) -> None:
    """Hatch bins of a map.

    Parameters
    ----------
    axes : Axes
        The map.
    doubtful : ndarray (up, across) of bool, optional
        Bins to hatch above their colours: those with a doubtful error.  Without it the whole ground is hatched, in grey,
        which shows where a map that is drawn upon it has a gap.
    across, up : ndarray, optional
        Edges of the bins (across + 1,) and (up + 1,), or their corners (up + 1, across + 1).
    """
    if doubtful is None:
        axes.fill(
            (0, 1, 1, 0), (0, 0, 1, 1), transform=axes.transAxes, facecolor=PALE, hatch=HATCHING, ec=MUTED,
            lw=0, zorder=-5,
        )  # fmt: skip
    elif doubtful.any():
        if np.ndim(across) == 1:
            across, up = np.meshgrid(across, up)
        corners = np.stack([across, up], axis=-1)
        ways = corners[:-1, :-1], corners[:-1, 1:], corners[1:, 1:], corners[1:, :-1], corners[:-1, :-1]
        outlines = np.stack([way[doubtful] for way in ways], axis=1)
        codes = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY]
        # One path for all bins: hatching each of them takes seconds.
        path = Path(outlines.reshape(-1, 2), np.tile(codes, len(outlines)))
        axes.add_patch(
            PathPatch(path, facecolor="none", edgecolor=MUTED, linewidth=0, hatch=HATCHING, zorder=3)
        )


def gap_words(percent: np.ndarray, unscored: np.ndarray, doubtful: np.ndarray | None = None) -> str | None:
    """Why bins of a map of errors are hatched; None where none is."""
    gaps = np.isnan(percent)
    why = []
    if gaps.any():
        why.append("no score" if unscored[gaps].all() else "not known")
    if doubtful is not None and (doubtful & ~gaps).any():
        why.append("doubtful")
    return ", ".join(why) or None


def hatch_key(words: str) -> Patch:
    """The mark of hatched bins for a legend."""
    return Patch(facecolor=PALE, hatch=HATCHING, edgecolor=MUTED, linewidth=0, label=words)
