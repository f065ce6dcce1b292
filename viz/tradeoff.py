"""What an element's size costs: its bias falls and its noise rises as it shrinks, and one size is the best."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from transport.viz.style import INK, MARKERS, MUTED, PALETTE, POINTS, figure_at


class Curve(NamedTuple):
    """Deviations that a number of particles leaves.  expected: (n,) along the panel's widths, root mean square.

    sizes, measured, error: (m,) widths, deviations found and their standard errors; None where none were.
    """

    label: str
    expected: np.ndarray
    sizes: np.ndarray | None = None
    measured: np.ndarray | None = None
    error: np.ndarray | None = None


class Tradeoff(NamedTuple):
    """One panel: widths (n,) of the element in the unit of `xlabel`, its bias (n,) in size, and the curves."""

    xlabel: str
    widths: np.ndarray
    bias: np.ndarray
    curves: Sequence[Curve]


def tradeoff(
    panels: Mapping[str, Tradeoff],
    path: str | os.PathLike,
    ylabel: str,
    title: str | None = None,
    note: str | None = None,
) -> str | os.PathLike:
    """Draw deviation against an element's width, a panel a kind of element, both axes logarithmic; returns the path.

    The bias is dashed; each budget has its expected curve, points with bars of two standard errors, and a star where
    its deviation is least.  A line joins the stars.  Raises ValueError for no panels.
    """
    if not panels:
        raise ValueError("tradeoff: at least one panel is needed, got none")
    with figure_at(path, (2 + 7.2 * len(panels), 10.2), title, note) as figure:
        row = figure.subplots(1, len(panels), squeeze=False)[0]
        for axes, (name, panel) in zip(row, panels.items(), strict=True):
            _draw_panel(axes, panel)
            axes.set_title(name)
            axes.set_xlabel(panel.xlabel)
        row[0].set_ylabel(ylabel)
    return path


def _draw_panel(axes: Axes, panel: Tradeoff) -> None:
    bests = []
    for place, curve in enumerate(panel.curves):
        colour, marker = PALETTE[place % len(PALETTE)], MARKERS[place % len(MARKERS)]
        axes.plot(panel.widths, curve.expected, color=colour, lw=2.4, label=curve.label)
        if curve.measured is not None:
            bars = 2 * np.minimum(curve.error, 0.49 * curve.measured)  # a bar stays above 0
            axes.errorbar(curve.sizes, curve.measured, bars, fmt=marker, color=colour, zorder=4, **POINTS)
        least = int(np.argmin(curve.expected))
        bests.append((panel.widths[least], curve.expected[least]))
    low = 0.5 * min(curve.expected.min() for curve in panel.curves)
    high = 1.5 * max(curve.expected.max() for curve in panel.curves)
    axes.plot(panel.widths, np.abs(panel.bias), "--", color=INK, lw=2.4, label="bias, exact", zorder=1.5)
    if any(curve.measured is not None for curve in panel.curves):
        axes.plot([], [], "o", color=MUTED, label="measured, ± 2 standard errors")
    axes.plot(*zip(*bests, strict=True), color=MUTED, lw=1.6, zorder=3)
    axes.plot(*zip(*bests, strict=True), "*", color=INK, mec="white", ms=26, zorder=5, label="best element")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylim(low, high)
    axes.set_xlim(0.9 * panel.widths[0], 1.1 * panel.widths[-1])
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(10, subs=(1, 2, 5)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.15), ncol=1)
