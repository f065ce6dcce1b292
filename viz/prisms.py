"""Who crosses a patch within a time: the places at the start, seen from the side, with the oblique prism round them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes

from viz.style import BLUE, INK, MUTED, VERMILLION, figure_at

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
    with figure_at(path, (7.2 * columns + 1, 6.6 * rows + 2), title, note) as figure:
        grid = figure.subplots(rows, columns, squeeze=False)
        for axes, (label, starts) in zip(grid.flat, panels.items(), strict=False):
            _draw_panel(axes, starts)
            axes.set_title(label, fontsize=18)
        for axes in grid.flat[len(panels) :]:
            axes.set_axis_off()
        for axes in grid[:, 0]:
            axes.set_ylabel(labels[1])
        for axes in grid[-1]:
            axes.set_xlabel(labels[0])
        handles, words = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, words, loc="outside lower center", ncols=len(words), markerscale=4)
    return path


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
    middle, reach = ends.mean(axis=0), np.hypot(*path)
    _draw_arrow(axes, middle, 0.35 * reach * np.asarray(starts.normal), INK, "n")
    _draw_arrow(axes, ends[0] - path, 0.35 * path, VERMILLION, "v")
    axes.set_aspect("equal", adjustable="datalim")
    axes.tick_params(colors=MUTED)


def _draw_arrow(axes: Axes, start: np.ndarray, way: np.ndarray, colour: str, word: str) -> None:
    arrow = {"arrowstyle": "-|>,head_width=0.45,head_length=0.9", "color": colour, "lw": 3}
    axes.annotate("", start + way, start, arrowprops=arrow, annotation_clip=False)
    axes.annotate(
        word, start + 1.18 * way, color=colour, ha="center", va="center", fontsize=20, fontweight="bold"
    )
