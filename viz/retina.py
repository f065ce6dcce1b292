"""Pictures on a screen side by side in one scale of grey: what shrinks, and what fades."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.patches import Circle

from transport.viz.style import ORANGE, figure_at, with_unit


def retinas(
    rows: Mapping[str, Mapping[str, np.ndarray]],
    path: str | os.PathLike,
    half_width: float,
    cell: float,
    top: float,
    quantity: str,
    unit: object,
    title: str | None = None,
    note: str | None = None,
) -> str | os.PathLike:
    """Draw square pictures (pixels, pixels), a row a kind, a column a label, all from black at 0 to white at `top`.

    half_width: of the pictures, cell: radius of a circle drawn in their middle [mm].  A picture that a row does not have
    is left out.  Returns the path; raises ValueError for no pictures.
    """
    columns = list(dict.fromkeys(label for row in rows.values() for label in row))
    if not columns:
        raise ValueError("retinas: at least one picture is needed, got none")
    with figure_at(path, (2.4 + 3.5 * len(columns), 1.9 + 3.6 * len(rows)), title, note) as figure:
        grid = figure.subplots(len(rows), len(columns), squeeze=False, sharex=True, sharey=True)
        for axes, label in zip(grid[0], columns, strict=True):
            axes.set_title(label)
        for (kind, row), line in zip(rows.items(), grid, strict=True):
            for label, axes in zip(columns, line, strict=True):
                if label in row:
                    shown = _draw(axes, row[label], half_width, cell, top)
                else:
                    axes.set_axis_off()
            line[0].set_ylabel(f"{kind}\n[mm]")
        for axes in grid[-1]:
            axes.set_xlabel("[mm]")
        bar = figure.colorbar(shown, ax=grid, shrink=0.85, pad=0.015)
        bar.set_label(with_unit(quantity, unit))
    return path


def _draw(axes, picture: Sequence[Sequence[float]], half_width: float, cell: float, top: float):
    extent = (-half_width, half_width, -half_width, half_width)
    shown = axes.imshow(np.transpose(picture), cmap="gray", vmin=0, vmax=top, origin="lower", extent=extent)
    axes.add_patch(Circle((0, 0), cell, fill=False, color=ORANGE, lw=2))
    axes.grid(False)
    return shown
