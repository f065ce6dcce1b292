"""The same run seen through elements of several sizes: too fine is noise, too coarse is blur."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes

from transport.viz.style import BLUE, INK, MUTED, figure_at


class Resolved(NamedTuple):
    """One column: n fine bins with edges (n + 1,) in the unit of `xlabel`, their means (n,), and the exact curve (x, y).

    sizes: label -> fine bins a side of the middle that an element takes; a row each.
    """

    xlabel: str
    ylabel: str
    edges: np.ndarray
    means: np.ndarray
    curve: tuple[np.ndarray, np.ndarray]
    sizes: Mapping[str, int]


def resolutions(
    columns: Mapping[str, Resolved],
    path: str | os.PathLike,
    title: str | None = None,
    note: str | None = None,
) -> str | os.PathLike:
    """Draw means over elements of several sizes before the exact curve, a column a kind, a row a size; returns the path.

    The element about the middle, whose value is sought, is filled.  Raises ValueError for no columns.
    """
    if not columns:
        raise ValueError("resolutions: at least one column is needed, got none")
    rows = max(len(column.sizes) for column in columns.values())
    with figure_at(path, (2 + 6.4 * len(columns), 1.6 + 4.2 * rows), title, note) as figure:
        grid = figure.subplots(rows, len(columns), squeeze=False, sharex="col", sharey="col")
        for place, column in enumerate(columns.values()):
            for axes, (label, bins) in zip(grid[:, place], column.sizes.items(), strict=False):
                _draw_elements(axes, column, bins)
                axes.set_title(label, fontsize=18)
            grid[-1, place].set_xlabel(column.xlabel)
            grid[rows // 2, place].set_ylabel(column.ylabel)
    return path


def _draw_elements(axes: Axes, column: Resolved, bins: int) -> None:
    edges, means = grouped(column.edges, column.means, bins)
    middle = len(means) // 2
    axes.stairs(means, edges, baseline=None, color=BLUE, lw=2.2)
    axes.stairs(means[middle : middle + 1], edges[middle : middle + 2], fill=True, color=BLUE, alpha=0.35)
    axes.plot(*column.curve, color=INK, lw=2.2)
    axes.axvline(0.5 * (column.edges[0] + column.edges[-1]), color=MUTED, lw=1.2, ls=":")
    axes.set_xlim(column.edges[0], column.edges[-1])
    axes.set_ylim(bottom=0)


def grouped(edges: np.ndarray, means: np.ndarray, bins: int) -> tuple[np.ndarray, np.ndarray]:
    """Edges and means of elements of 2 × bins fine bins, one of them about the middle; what is left at the ends is dropped."""
    middle, width = len(means) // 2, 2 * bins
    beside = (middle - bins) // width  # whole elements on either side
    first, last = middle - bins - beside * width, middle + bins + beside * width
    return edges[first : last + 1 : width], means[first:last].reshape(-1, width).mean(axis=1)
