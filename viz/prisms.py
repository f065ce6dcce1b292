"""Who crosses a patch within a time: the places at the start, seen from the side, with the oblique prism round them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke

from transport.viz.style import BLUE, INK, MUTED, VERMILLION, figure_at

MOST = 6000  # points of a panel: more hide each other
COLUMNS = 3  # panels a row


class Starts(NamedTuple):
    """Places at the start in the plane of the picture (n, 2), and what happens to them.

    crossed: (n,) of bool;  ends: of the patch, (2, 2);  normal: of the patch, (2,);  path: v dt, (2,).
    """

    places: np.ndarray
    crossed: np.ndarray
    ends: np.ndarray
    normal: np.ndarray
    path: np.ndarray


def prisms(
    panels: Mapping[str, Starts],
    path: str | os.PathLike,
    title: str | None = None,
    labels: tuple[str, str] = ("x  [m]", "y  [m]"),
    note: str | None = None,
) -> str | os.PathLike:
    """Draw places at the start, coloured by whether they cross a patch, round its prism; returns the path.

    panels: label -> Starts.  labels: of the two axes.  Raises ValueError for no panels.
    """
    if not panels:
        raise ValueError("prisms: panels must hold one at least, got none")
    columns = min(COLUMNS, len(panels))
    rows = -(-len(panels) // columns)
    low, high = _limits(list(panels.values()))
    width, height = high - low
    across = 7.2 if columns > 1 else 13.0
    with figure_at(
        path, (across * columns + 1, (across * height / width + 1.2) * rows + 1.7), title, note
    ) as figure:
        grid = figure.subplots(rows, columns, squeeze=False)
        for axes, (label, starts) in zip(grid.flat, panels.items(), strict=False):
            _draw_panel(axes, starts)
            axes.set_title(label, fontsize=18)
            axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
            axes.set_xlabel(labels[0])
        for axes in grid.flat[len(panels) :]:
            axes.set_axis_off()
        for axes in grid[:, 0]:
            axes.set_ylabel(labels[1])
        handles, words = grid[0, 0].get_legend_handles_labels()
        place, ncols = ("center", 4) if columns > 1 else ("left", 2)
        figure.legend(handles, words, loc=f"outside lower {place}", ncols=ncols, markerscale=4)
    return path


def _limits(panels: list[Starts]) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corner of all that is drawn, the same for all panels."""
    tips = [starts.ends.mean(axis=0) + 1.3 * _normal_arrow(starts) for starts in panels]
    points = np.concatenate([tips, *(starts.places for starts in panels)])
    margin = 0.06 * np.ptp(points, axis=0).max()
    return points.min(axis=0) - margin, points.max(axis=0) + margin


def _normal_arrow(starts: Starts) -> np.ndarray:
    return 0.35 * np.hypot(*starts.path) * np.asarray(starts.normal)


def _draw_panel(axes: Axes, starts: Starts) -> None:
    places, crossed = starts.places[:MOST], starts.crossed[:MOST]
    for chosen, colour, label in (
        (~crossed, "#b8b8b8", "does not cross"),
        (crossed, BLUE, "crosses within dt"),
    ):
        axes.plot(*places[chosen].T, "o", color=colour, ms=2.6, mew=0, label=label)
    ends, path = np.asarray(starts.ends), np.asarray(starts.path)
    prism = np.array([*ends, *(ends[::-1] - path), ends[0]])
    axes.plot(*prism.T, "--", color=VERMILLION, lw=2.6, label="prism, edge v dt")
    axes.plot(*ends.T, color=INK, lw=6, solid_capstyle="butt", label="patch dA")
    middle = ends.mean(axis=0)
    _draw_arrow(axes, middle, _normal_arrow(starts), INK, "n")
    _draw_arrow(axes, middle - path, 0.4 * path, VERMILLION, "v")
    axes.tick_params(colors=MUTED)


def _draw_arrow(axes: Axes, start: np.ndarray, way: np.ndarray, colour: str, word: str) -> None:
    """An arrow with its name beyond its head, both on a pale rim so that points do not hide them."""
    rim = [withStroke(linewidth=6, foreground="white")]
    arrow = {"arrowstyle": "-|>,head_width=0.45,head_length=0.9", "color": colour, "lw": 3}
    axes.annotate("", start + way, start, arrowprops=arrow | {"path_effects": rim, "shrinkA": 0})
    place = start + 1.22 * way
    words = {"ha": "center", "va": "center", "fontsize": 21, "fontweight": "bold"}
    axes.annotate(word, place, color=colour, path_effects=rim, **words)
