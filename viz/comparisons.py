"""A table of estimates and exact values as a picture: relative differences and scores on one line a quantity."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes

from transport import Estimate
from transport.notation import plus_minus
from viz.style import BLUE, INK, MUTED, VERMILLION, figure_at, unit_label

BAND = "#dcebf5"
SCALES = ((1e-1, 1e2, "%"), (0.0, 1e6, "ppm"))


def comparison(
    table: Mapping[str, tuple[Estimate, float]],
    path: str | os.PathLike,
    title: str | None = None,
    note: str | None = None,
) -> str | os.PathLike:
    """Draw estimate / exact - 1 with bars of two standard errors, a row for each quantity; returns the path.

    table: name -> (estimate, exact value).  The second panel shows z, the score through Student's t, with
    the band of two; it also serves quantities whose exact value is 0, which have no relative difference.
    Raises ValueError for an empty table.
    """
    if not table:
        raise ValueError("comparison: the table must have a row, got none")
    rows = [(estimate, float(exact)) for estimate, exact in table.values()]
    with figure_at(path, (17, 2.6 + 0.78 * len(rows)), title, note) as figure:
        left, right = figure.subplots(1, 2, sharey=True, width_ratios=(2.1, 1))
        _draw_differences(left, rows)
        _draw_scores(right, rows)
        left.set_yticks(range(len(rows)), list(table))
        left.set_ylim(len(rows) - 0.4, -0.6)
    return path


def _draw_differences(axes: Axes, rows: list[tuple[Estimate, float]]) -> None:
    differences = np.array([e.value / exact - 1 if exact else math.nan for e, exact in rows])
    bars = np.array([2 * e.error / abs(exact) if exact else math.nan for e, exact in rows])
    ends = np.abs(differences) + np.nan_to_num(bars)
    largest = np.max(ends[np.isfinite(ends)], initial=0.0)
    factor, unit = (1e2, "%") if largest >= 1e-4 or largest == 0 else (1e6, "ppm")
    axes.axvline(0, color=INK, lw=1.8)
    for row, (difference, bar) in enumerate(zip(factor * differences, factor * bars, strict=True)):
        if math.isfinite(bar):
            axes.errorbar(difference, row, xerr=bar, fmt="o", color=BLUE, capsize=7, lw=3, capthick=2.4, ms=11)
        else:
            axes.plot(difference, row, "o", mfc="white", mec=BLUE, mew=2, ms=11)
    reach = 1.15 * factor * largest if largest > 0 else 1.0
    axes.set_xlim(-reach, reach)
    axes.grid(False, axis="y")
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel(f"estimate / exact − 1  [{unit}],  ± 2 standard errors")


def _draw_scores(axes: Axes, rows: list[tuple[Estimate, float]]) -> None:
    z = np.array([estimate.z(exact) for estimate, exact in rows])
    reach = float(np.clip(1.3 * np.max(np.abs(z[np.isfinite(z)]), initial=0.0), 3.5, 8.0))
    axes.axvspan(-2, 2, color=BAND, lw=0)
    axes.axvline(0, color=INK, lw=1.8)
    for row, score in enumerate(z):
        if abs(score) < reach:
            axes.plot(score, row, "o", color=BLUE, ms=11)
        elif not math.isnan(score):
            axes.plot(math.copysign(0.93 * reach, score), row, ">" if score > 0 else "<", color=VERMILLION, ms=13)
    axes.set_xlim(-reach, reach)
    axes.grid(False, axis="y")
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel("z  [standard errors]")
    for row, (estimate, exact) in enumerate(rows):
        axes.text(1.05, row, _in_words(estimate, exact), transform=axes.get_yaxis_transform(), va="center", fontsize=16)


def _in_words(estimate: Estimate, exact: float) -> str:
    unit = unit_label(estimate.unit)
    if estimate.reason is not None:
        number = f"{estimate.value:.4g} (error unknown)"
    elif estimate.exact:
        number = f"{estimate.value:.6g} (exact)"
    else:
        number = plus_minus(estimate.value, estimate.error)
    return f"{number} {unit}\nexact {exact:.6g}"
