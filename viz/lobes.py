"""Lobes: a quantity by direction in the plane of incidence, as the distance from a point on a surface.

The surface lies level through the middle, its normal points up; angles are counted from the normal to the right.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from transport.viz.style import INK, MUTED, PALETTE, figure

FINE = 1441  # points of an exact line
GLASS = "#e3eef6"  # of the half below a boundary
CELL, ROUND, MARGIN = 7.8, 5.9, 2.3  # inches: width of a panel, its circle, what a row has above and below it
COLUMNS = 3  # panels a row at most
QUARTER = math.pi / 2
EXACT, MEANS, ITSELF = "line: exact", "line: exact mean of a bin", "exact in one direction"


class Lobe(NamedTuple):
    """A quantity in bins of angle.  edges: (n + 1,) increasing [rad]; value, error: (n,) with standard errors, empty if only the
    exact line is drawn.

    exact: the quantity as a function of an array of angles [rad].  means: (n,) its exact means over the bins, drawn as
    well where bins are wide for it.
    """

    label: str
    edges: np.ndarray
    value: np.ndarray
    error: np.ndarray
    exact: Callable[[np.ndarray], np.ndarray]
    means: np.ndarray | None = None


class Panel(NamedTuple):
    """Lobes round one point.

    rays: angle [rad] -> words, dotted lines to the rim;  light: angle [rad] that a beam comes from;  media: words for
    what is above and below the surface;  arc: (words, radius, from, to), dashed, such as the radiance that arrives;
    guide: (words, function of an array of angles [rad]), dashed, such as a law that is wrong;  label: of the radius, where
    it is not that of all panels;  first: place in the palette of the first lobe.
    """

    lobes: Sequence[Lobe]
    rays: Mapping[float, str] = {}
    light: float | None = None
    media: tuple[str, str] | None = None
    arc: tuple[str, float, float, float] | None = None
    guide: tuple[str, Callable[[np.ndarray], np.ndarray]] | None = None
    label: str | None = None
    first: int = 0

    @property
    def is_whole(self) -> bool:
        """Whether anything is below the surface."""
        return any(lobe.edges[-1] > QUARTER * (1 + 1e-9) for lobe in self.lobes)


def lobes(
    panels: Mapping[str, Panel],
    path: str | os.PathLike | None,
    label: str,
    title: str | None = None,
    note: str | None = None,
) -> Figure:
    """Draw lobes, a panel per point: wedges are bins, bars two standard errors, lines exact.

    label: of the radius, with its unit.  Raises ValueError for no panels.
    """
    if not panels:
        raise ValueError("lobes: panels must hold one at least, got none")
    columns = 2 if len(panels) in (2, 4) else min(COLUMNS, len(panels))
    rows = [list(panels.items())[k : k + columns] for k in range(0, len(panels), columns)]
    heights = [ROUND * max(_share(panel) for _, panel in row) + MARGIN for row in rows]
    width, height = CELL * columns, sum(heights) + 1.6
    with figure((width, height), title, note, path, "none") as page:
        top = height - 0.7
        for row, tall in zip(rows, heights, strict=True):
            for x, (name, panel) in enumerate(row):
                low = top - MARGIN / 2 - ROUND * (0.5 + _share(panel) / 2)
                box = (CELL * (x + 0.5) - ROUND / 2) / width, low / height, ROUND / width, ROUND / height
                axes = page.add_axes(box, projection="polar")
                _draw_panel(axes, panel, name, label)
            top -= tall
        _explain(page)
    return page


def _share(panel: Panel) -> float:
    """Of the circle's height that is shown; a half one lies in the middle of its box."""
    return 1.0 if panel.is_whole else 0.5


def _draw_panel(axes: Axes, panel: Panel, name: str, label: str) -> None:
    _prepare(axes, panel)
    _draw_surroundings(axes, panel)
    for lobe, colour in zip(panel.lobes, PALETTE[panel.first :], strict=False):
        _draw_lobe(axes, lobe, colour)
    edge = _share(panel) / 2
    for words, height, size in ((name, 0.5 + edge + 0.13, 21), (panel.label or label, 0.5 - edge - 0.12, 19)):
        axes.text(0.5, height, words, transform=axes.transAxes, ha="center", va="center", fontsize=size)


def _prepare(axes: Axes, panel: Panel) -> None:
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(-1)
    if not panel.is_whole:
        axes.set_thetalim(-QUARTER, QUARTER)
    largest = max(_top(lobe) for lobe in panel.lobes)
    beyond = panel.guide[1](np.linspace(-QUARTER, QUARTER, FINE)).max() if panel.guide else 0
    axes.set_rlim(0, 1.12 * max(largest, panel.arc[1] if panel.arc else 0, beyond))
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 2.5, 5, 10]))
    highest = (0.9 if panel.is_whole else 1) * axes.get_rmax()  # beyond, it would stand among the angles
    axes.yaxis.set_major_formatter(
        FuncFormatter(lambda value, _: f"{value:g}" if 0 < value <= highest else "")
    )
    axes.set_rlabel_position(76)
    axes.tick_params(axis="x", pad=9)
    axes.tick_params(axis="y", labelsize=15, labelcolor=INK)
    rim = patheffects.withStroke(linewidth=3, foreground="white")
    for words in axes.get_yticklabels():
        words.set_path_effects([rim])
    angles = np.arange(0, 360, 30) if panel.is_whole else np.arange(-90, 91, 30)
    axes.set_xticks(np.radians(angles), [f"{_to_normal(angle):.0f}°" for angle in angles])
    axes.grid(color="#dcdcdc")


def _top(lobe: Lobe) -> float:
    """The largest exact value, so that a noisy bin stretches no scale."""
    fine = np.linspace(lobe.edges[0], lobe.edges[-1], FINE)
    return float(np.nanmax(lobe.exact(fine) if lobe.means is None else lobe.means))


def _draw_surroundings(axes: Axes, panel: Panel) -> None:
    reach = axes.get_rmax()
    if panel.media:
        below = np.linspace(QUARTER, 3 * QUARTER, FINE)
        axes.fill_between(below, 0, reach, color=GLASS, lw=0, zorder=0)
        for words, height in zip(panel.media, (0.96, 0.03), strict=True):
            axes.text(-0.12, height, words, transform=axes.transAxes, va="center", color=MUTED, fontsize=19)
    axes.plot([-QUARTER, -QUARTER, QUARTER], [reach, 0, reach], color=INK, lw=2.6, zorder=3)
    if panel.arc:
        words, radius, low, high = panel.arc
        axes.plot(
            np.linspace(low, high, FINE),
            np.full(FINE, radius),
            "--",
            color=INK,
            lw=2,
            zorder=2.5,
            label=words,
        )
    if panel.guide:
        words, law = panel.guide
        fine = np.linspace(-QUARTER, QUARTER, FINE)
        axes.plot(fine, law(fine), "--", color=MUTED, lw=2.5, zorder=2.5, label=words)
    for angle, words in panel.rays.items():
        axes.plot([angle, angle], [0, reach], ":", color=INK, lw=2, zorder=3)
        axes.text(angle, 1.09 * reach, words, ha="center", va="center", fontsize=17)
    if panel.light is not None:
        arrow = {
            "arrowstyle": "-|>,head_width=0.5,head_length=1",
            "color": INK,
            "lw": 3,
            "shrinkA": 0,
            "shrinkB": 0,
        }
        axes.annotate("", (panel.light, 0.55 * reach), (panel.light, reach), arrowprops=arrow, zorder=5)


def _to_normal(degrees: float) -> float:
    """The angle to the nearest of both normals."""
    return math.degrees(math.acos(min(1.0, abs(math.cos(math.radians(degrees))))))


def _draw_lobe(axes: Axes, lobe: Lobe, colour: str) -> None:
    middles, widths = (lobe.edges[1:] + lobe.edges[:-1]) / 2, np.diff(lobe.edges)
    if len(lobe.value):
        axes.bar(middles, lobe.value, widths, color=colour, alpha=0.3, lw=0, zorder=1, label=lobe.label)
        axes.errorbar(middles, lobe.value, 2 * lobe.error, fmt="o", ms=5, color=colour, lw=2, zorder=4)
    fine = np.linspace(lobe.edges[0], lobe.edges[-1], FINE)
    if lobe.means is None:
        axes.plot(fine, lobe.exact(fine), color=colour, lw=2.2, zorder=3)
        return
    axes.plot(fine, lobe.exact(fine), ":", color=INK, lw=1.8, zorder=2.5, label=ITSELF)
    angles = np.concatenate([np.linspace(*pair, 9) for pair in pairwise(lobe.edges)])
    axes.plot(angles, np.repeat(lobe.means, 9), color=colour, lw=2.2, zorder=3)


def _explain(figure: Figure) -> None:
    """One legend below all panels, each label once."""
    found = {}
    for axes in figure.axes:
        words = [text.get_label() for text in axes.lines]
        axes.plot([], [], color=MUTED, lw=2.2, label=MEANS if ITSELF in words else EXACT)
        handles, labels = axes.get_legend_handles_labels()
        found |= dict(zip(labels, handles, strict=True))
    figure.legend(found.values(), found.keys(), loc="lower left", ncols=4)
