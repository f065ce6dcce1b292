"""Estimates against exact values, a row per quantity: relative difference, score, and both numbers.

>>> comparison({"irradiance": (result["meter"].irradiance, 18.4)}, "rows.png", title="All rows")  # doctest: +SKIP
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from transport import Estimate
from transport.viz.style import BLUE, INK, MUTED, VERMILLION, WITHIN_TWO, figure
from transport.viz.wording import estimate_text, raised

FURTHEST = 6.0  # a score beyond is an arrow at the edge
SCALES = ((1e-3, 1e2, "%"), (0.0, 1e6, "ppm"))  # from which size on, factor, name

Rows = list[tuple[Estimate, float]]


def comparison(
    table: Mapping[str, tuple[Estimate, float]],
    path: str | os.PathLike | None = None,
    title: str | None = None,
    note: str | None = None,
) -> Figure:
    """Draw estimate / exact - 1 with bars of two standard errors, a row per quantity, and beside it z.

    Parameters
    ----------
    table : mapping of str to (Estimate, float)
        Estimate and exact value by the name of the quantity.
    path : str or os.PathLike, optional
        File to write [default: none].
    title, note : str, optional
        Headline, and provenance in small type, such as particles and seed.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        For an empty table.

    Notes
    -----
    z is the score through Student's t, with the band of two; it also serves quantities whose exact value is 0, which
    have no relative difference.
    """
    if not table:
        raise ValueError("comparison: the table must have a row, got none")
    rows = [(estimate, float(exact)) for estimate, exact in table.values()]
    height = 2.4 + 0.85 * len(rows) + (0.6 if title else 0)
    with figure((18, height), title, note, path) as page:
        left, right = page.subplots(1, 2, sharey=True, width_ratios=(1.7, 1))
        _draw_differences(left, rows)
        _draw_scores(right, rows)
        for row, (estimate, exact) in enumerate(rows):
            words = _in_words(estimate, exact)
            right.text(1.05, row, words, transform=right.get_yaxis_transform(), va="center", fontsize=17)
        left.set_yticks(range(len(rows)), [raised(name) for name in table], fontsize=19)
        left.set_ylim(len(rows) - 0.5, -0.5)
    return page


def _draw_differences(axes: Axes, rows: Rows) -> None:
    relative = [
        (e.value / exact - 1, 2 * e.error / abs(exact)) if exact else (math.nan,) * 2 for e, exact in rows
    ]
    largest = max((abs(d) + bar for d, bar in relative if math.isfinite(d + bar)), default=0.0)
    factor, unit = next((factor, name) for size, factor, name in SCALES if largest >= size)
    reach = 1.12 * factor * largest if largest > 0 else 1.0
    _prepare(axes, len(rows), reach, f"estimate / exact − 1  [{unit}],  ± 2 standard errors")
    for row, (difference, bar) in enumerate(relative):
        x, half = factor * difference, factor * bar
        if math.isnan(x):
            words = "no value" if rows[row][1] else "exact value 0: see z"
            axes.text(0.02 * reach, row, words, color=MUTED, va="center", fontsize=16)
        elif math.isfinite(half):
            axes.errorbar(x, row, xerr=half, fmt="o", color=BLUE, capsize=9, lw=3.2, capthick=3, ms=13)
        elif abs(x) < reach:
            axes.plot(x, row, "o", mfc="white", mec=BLUE, mew=2.2, ms=13)
        else:
            _draw_arrow(axes, x, row, reach, BLUE, "white")


def _draw_scores(axes: Axes, rows: Rows) -> None:
    scores = [estimate.z(exact) for estimate, exact in rows]
    reach = max(3.4, 1.2 * max((abs(z) for z in scores if abs(z) <= FURTHEST), default=0.0))
    axes.axvspan(-2, 2, color=WITHIN_TWO, lw=0)
    _prepare(axes, len(rows), reach, "z  [standard errors]")
    for row, z in enumerate(scores):
        if math.isnan(z):
            axes.text(0.04 * reach, row, "no error known", color=MUTED, va="center", fontsize=16)
        elif abs(z) <= FURTHEST:
            axes.plot(z, row, "o", color=BLUE, ms=13)
        else:
            _draw_arrow(axes, z, row, reach, VERMILLION, VERMILLION)


def _prepare(axes: Axes, rows: int, reach: float, label: str) -> None:
    axes.axvline(0, color=INK, lw=2)
    for between in np.arange(rows - 1) + 0.5:
        axes.axhline(between, color="#e6e6e6", lw=1)
    axes.set_xlim(-reach, reach)
    axes.xaxis.set_major_locator(MaxNLocator(8, steps=[1, 2, 5, 10]))
    axes.grid(False, axis="y")
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel(label)


def _draw_arrow(axes: Axes, x: float, row: int, reach: float, edge: str, face: str) -> None:
    """A mark at the edge for what lies beyond it."""
    marker = ">" if x > 0 else "<"
    axes.plot(math.copysign(0.96 * reach, x), row, marker, mec=edge, mfc=face, mew=2.2, ms=14)


def _in_words(estimate: Estimate, exact: float) -> str:
    return f"{estimate_text(estimate)}\nexact {f'{exact:.7g}'.replace('-', '−')}"
