"""Several quantities along one coordinate, each before its exact curve, and all their residuals in standard errors below."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from transport import Estimate
from transport.viz.profiles import FURTHEST, in_standard_errors
from transport.viz.style import INK, MARKERS, MUTED, PALETTE, POINTS, WITHIN_TWO, figure_at, with_unit


class Family(NamedTuple):
    """One quantity: places x (n,), n estimates with their exact values (n,), and the exact curve (x, y), nan where unknown."""

    x: Sequence[float]
    estimates: Sequence[Estimate]
    exact: Sequence[float]
    curve: tuple[np.ndarray, np.ndarray]


def families(
    members: Mapping[str, Family],
    path: str | os.PathLike,
    xlabel: str,
    ylabel: str,
    title: str | None = None,
    log_y: bool = False,
    levels: Mapping[str, float] | None = None,
    marks: Mapping[str, float] | None = None,
    guides: Mapping[str, tuple[np.ndarray, np.ndarray]] | None = None,
    note: str | None = None,
) -> str | os.PathLike:
    """Draw each quantity with bars of two standard errors over a logarithmic x, and residuals below; returns the path.

    levels, marks: words -> a height, a place that a dotted line shows.  guides: label -> (x, y) of a dashed curve, in the
    colour of the quantity of the same rank.  Raises ValueError without a quantity, and for
    unlike units.
    """
    units = {str(each.unit) for member in members.values() for each in member.estimates}
    if len(units) != 1:
        raise ValueError(f"families: quantities of one unit are needed, got {sorted(units) or 'none'}")
    with figure_at(path, (14, 10.5), title, note) as figure:
        main, lowest = figure.subplots(2, 1, sharex=True, height_ratios=(2.6, 1))
        lowest.axhspan(-2, 2, color=WITHIN_TWO, lw=0)
        lowest.axhline(0, color=INK, lw=1.6)
        for place, (label, member) in enumerate(members.items()):
            _draw(main, lowest, member, label, PALETTE[place % len(PALETTE)], MARKERS[place % len(MARKERS)])
        _scale(main, log_y)
        main.plot([], [], color=MUTED, lw=2.2, label="exact")
        for (label, guide), colour in zip((guides or {}).items(), PALETTE, strict=False):
            main.plot(*guide, "--", color=colour, lw=2.2, label=label, zorder=1.5)
        _draw_lines(main, levels or {}, marks or {})
        main.legend(loc="best", title="points ± 2 standard errors", title_fontsize=15)
        main.set_ylabel(with_unit(ylabel, units.pop()))
        lowest.set_ylabel("residual\n[std. errors]")
        lowest.set_ylim(-max(3.4, *np.abs(lowest.get_ylim())), max(3.4, *np.abs(lowest.get_ylim())))
        lowest.set_xlabel(xlabel)
        figure.align_ylabels()
    return path


def _draw(main: Axes, lowest: Axes, member: Family, label: str, colour: str, marker: str) -> None:
    x, exact = np.asarray(member.x, dtype=float), np.asarray(member.exact, dtype=float)
    value, error = (
        np.array([getattr(each, name) for each in member.estimates]) for name in ("value", "error")
    )
    main.plot(*member.curve, color=colour, lw=2.2)
    main.errorbar(x, value, 2 * error, fmt=marker, color=colour, label=label, zorder=4, **POINTS)
    residual = np.clip(in_standard_errors(value, error, exact), -FURTHEST, FURTHEST)
    lowest.plot(x, residual, marker, color=colour, mec="white", mew=0.8)


def _scale(axes: Axes, log_y: bool) -> None:
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(10, subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda place, _: f"{place:g}"))
    axes.xaxis.set_minor_locator(NullLocator())
    if log_y:
        axes.set_yscale("log")
    else:
        axes.set_ylim(0, 1.12 * axes.get_ylim()[1])


def _draw_lines(axes: Axes, levels: Mapping[str, float], marks: Mapping[str, float]) -> None:
    """Dotted lines, with their words at the right end or beside them."""
    for words, height in levels.items():
        axes.axhline(height, color=MUTED, lw=1.6, ls=":", zorder=1)
        axes.text(
            0.995, height, words, transform=axes.get_yaxis_transform(), ha="right", va="bottom", fontsize=15
        )
    for rank, (words, place) in enumerate(marks.items()):
        axes.axvline(place, color=MUTED, lw=1.6, ls=":", zorder=1)
        height = 0.82 - 0.055 * rank
        axes.annotate(
            words, (place, height), (7, 0), axes.get_xaxis_transform(), "offset points", va="top", fontsize=15,
            bbox={"fc": "white", "ec": "none", "pad": 2},
        )  # fmt: skip
