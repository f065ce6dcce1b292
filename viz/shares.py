"""Shares by angle: what is reflected or let through, on exact curves, with the residuals in standard errors below."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MultipleLocator

from transport import Estimate
from transport.viz.profiles import FURTHEST, in_standard_errors
from transport.viz.style import INK, MARKERS, MUTED, PALETTE, POINTS, WITHIN_TWO, figure_at

Curve = Callable[[np.ndarray], np.ndarray]

FINE = 2001  # points of an exact curve
DASHES = ("--", ":", "-.")


class Shares(NamedTuple):
    """Estimates at n angles [deg], and the exact share as a function of an array of angles [deg]."""

    label: str
    angles: Sequence[float]
    estimates: Sequence[Estimate]
    exact: Curve


class Sheet(NamedTuple):
    """One panel.  guides: words -> function of angles [deg], dashed, such as another law."""

    ylabel: str
    series: Sequence[Shares]
    guides: Mapping[str, Curve] = {}


def shares(
    panels: Mapping[str, Sheet],
    path: str | os.PathLike,
    title: str | None = None,
    note: str | None = None,
) -> str | os.PathLike:
    """Draw shares against the angle of incidence, a column a panel, residuals below; returns the path.

    Bars are two standard errors.  Raises ValueError for no panels.
    """
    if not panels:
        raise ValueError("shares: panels must hold one at least, got none")
    with figure_at(path, (9.6 * len(panels) + 0.6, 10.4), title, note) as figure:
        grid = figure.subplots(2, len(panels), sharex="col", height_ratios=(2.6, 1), squeeze=False)
        for (upper, lower), (name, sheet) in zip(grid.T, panels.items(), strict=True):
            upper.set_title(name)
            upper.set_ylabel(sheet.ylabel)
            _draw_shares(upper, sheet)
            _draw_residuals(lower, sheet)
            lower.set_xlabel("angle of incidence  [deg]")
        grid[1, 0].set_ylabel("residual\n[std. errors]")
        figure.align_ylabels()
    return path


def _draw_shares(axes: Axes, sheet: Sheet) -> None:
    fine = np.linspace(0, 90, FINE)
    for place, (label, angles, estimates, exact) in enumerate(sheet.series):
        value, error = _arrays(estimates)
        colour, marker = PALETTE[place], MARKERS[place]
        axes.plot(fine, exact(fine), color=colour, lw=2, alpha=0.7, zorder=2)
        axes.errorbar(angles, value, 2 * error, fmt=marker, color=colour, label=label, zorder=4, **POINTS)
    for place, (words, guide) in enumerate(sheet.guides.items()):
        style = DASHES[place % len(DASHES)]
        axes.plot(fine, guide(fine), style, color=MUTED, lw=2.2, label=words, zorder=1.5)
    axes.plot([], [], color=PALETTE[0], lw=2, alpha=0.7, label="lines: exact")
    axes.set(xlim=(-1.5, 91.5), ylim=(-0.03, 1.05))
    axes.legend(loc="best")


def _draw_residuals(axes: Axes, sheet: Sheet) -> None:
    axes.axhspan(-2, 2, color=WITHIN_TWO, lw=0)
    axes.axhline(0, color=INK, lw=1.6)
    for place, (_, angles, estimates, exact) in enumerate(sheet.series):
        angles = np.asarray(angles, dtype=float)
        residual = in_standard_errors(*_arrays(estimates), exact(angles))
        for x, y in zip(angles, residual, strict=True):
            beyond = abs(y) > FURTHEST
            marker = ("^" if y > 0 else "v") if beyond else MARKERS[place]
            height = np.clip(y, -0.9 * FURTHEST, 0.9 * FURTHEST) if beyond else y
            axes.plot(x, height, marker, color=PALETTE[place], mec="white", mew=0.8, ms=14 if beyond else 9)
    reach = max(3.4, *(1.2 * abs(y) for y in axes.dataLim.intervaly))
    axes.set_ylim(-reach, reach)
    axes.yaxis.set_major_locator(MultipleLocator(2))


def _arrays(estimates: Sequence[Estimate]) -> tuple[np.ndarray, np.ndarray]:
    return tuple(np.array([getattr(each, name) for each in estimates]) for name in ("value", "error"))
