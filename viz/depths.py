"""Something by depth in two windows, near the surface and deep down, before its exact curve, with residuals below."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from transport import EstimateArray
from transport.viz.profiles import FURTHEST, in_standard_errors
from transport.viz.style import BLUE, INK, MUTED, ORANGE, POINTS, PURPLE, WITHIN_TWO, figure_at

FINE = 1500  # points of a curve
Curve = Callable[[np.ndarray], np.ndarray]


class Window(NamedTuple):
    """A range of depths.  fluence: by layers, edges of `z` in m;  expected: exact means over them;  is_log: its scale."""

    title: str
    fluence: EstimateArray
    expected: np.ndarray
    is_log: bool


def depth_windows(
    windows: Sequence[Window],
    path: str | os.PathLike,
    exact: Curve,
    guides: Mapping[str, Curve],
    title: str | None = None,
    note: str | None = None,
) -> str | os.PathLike:
    """Draw each window with bars of two standard errors, residuals from the means over layers below; returns the path.

    exact, guides: fluence rate over irradiance as a function of depth [mm]; the latter dashed.
    """
    with figure_at(path, (16, 9.6), title, note) as figure:
        axes = figure.subplots(2, len(windows), sharex="col", height_ratios=(2.6, 1), squeeze=False)
        for column, window in enumerate(windows):
            main, lower = axes[:, column]
            _draw_window(main, window, exact, guides)
            _draw_residuals(lower, window)
            lower.set_xlabel("depth  [mm]")
        axes[0, 0].set_ylabel("fluence rate / irradiance")
        axes[1, 0].set_ylabel("residual\n[std. errors]")
        axes[0, -1].legend(loc="lower left" if windows[-1].is_log else "upper right")
        figure.align_ylabels()
    return path


def _edges(window: Window) -> np.ndarray:
    return 1e3 * np.asarray(window.fluence.coords["z"])


def _draw_window(axes: Axes, window: Window, exact: Curve, guides: Mapping[str, Curve]) -> None:
    edges = _edges(window)
    fine, middles = np.linspace(0, edges[-1], FINE), (edges[1:] + edges[:-1]) / 2
    axes.plot(fine, exact(fine), color=INK, lw=2.4, label="exact (discrete ordinates)")
    for (label, guide), colour in zip(guides.items(), (ORANGE, PURPLE), strict=False):
        axes.plot(fine, guide(fine), "--", color=colour, lw=2.6, label=label)
    value, bars = window.fluence.value, 2 * np.nan_to_num(window.fluence.error)
    words = "simulated, ± 2 standard errors"
    axes.errorbar(middles, value, bars, fmt="o", color=BLUE, label=words, zorder=4, **POINTS)
    axes.axhline(1, color=MUTED, lw=1.6, ls=":", label="the beam's irradiance")
    axes.set_title(window.title)
    axes.set_xlim(0, edges[-1])
    if window.is_log:
        axes.set_yscale("log")
    else:
        axes.set_ylim(0, 1.15 * max(exact(fine).max(), value.max()))


def _draw_residuals(axes: Axes, window: Window) -> None:
    edges = _edges(window)
    found = in_standard_errors(window.fluence.value, window.fluence.error, window.expected)
    shown = np.clip(found, -FURTHEST, FURTHEST)
    axes.axhspan(-2, 2, color=WITHIN_TWO, lw=0)
    axes.axhline(0, color=INK, lw=1.6)
    axes.plot((edges[1:] + edges[:-1]) / 2, shown, "o", color=BLUE, mec="white", mew=0.8)
    reach = max(3.4, 1.15 * np.abs(shown[np.isfinite(shown)]).max(initial=0.0))
    axes.set_ylim(-reach, reach)
    axes.yaxis.set_major_locator(MaxNLocator(5, integer=True, steps=[1, 2, 4, 5, 10]))
