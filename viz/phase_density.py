"""Position against velocity, or any two coordinates of phase space: the density and its relative error, a column a time."""

from __future__ import annotations

import os
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure

from transport import EstimateArray
from transport.statistics.axes import COORDINATES
from transport.viz.style import figure_at, unit_label, with_unit
from transport.viz.uncertainty import (
    ERRORS,
    TITLE,
    VALUES,
    error_norm,
    gap_words,
    hatch,
    hatch_key,
    percent_of,
    tick_errors,
)

WORDS = {
    "x": "position x", "y": "position y", "z": "position z", "vx": "velocity vₓ", "vy": "velocity v_y",
    "vz": "velocity v_z", "speed": "speed", "mu": "cosine to +z",
}  # fmt: skip
MOST = 6  # columns
PANEL, BAR = (4.6, 4.2), 2.2  # inches


def phase_density(
    reading: object,
    path: str | os.PathLike,
    times: Sequence[int] | None = None,
    decades: float | None = None,
    title: str | None = None,
    note: str | None = None,
) -> str | os.PathLike:
    """Draw a PhaseSpace's density over two coordinates, below it its relative standard error [%]; returns the path.

    reading: `result["phase_space"]`.  times: which of its times, by number; up to six evenly among all if not told.
    decades: a logarithmic scale so far down from the greatest value; linear from 0 if not told.
    All columns share one scale.  Raises ValueError for one coordinate alone, and for a scene with nothing in the bins.
    """
    density = reading.density
    panels = _panels(density, times, reading)
    norm = _norm([each.value for each in panels.values()], decades, reading.name)
    percents = [percent_of(each.value, each.error) for each in panels.values()]
    worst = error_norm(np.concatenate([percent.ravel() for percent in percents]))
    size = PANEL[0] * len(panels) + BAR, 2 * PANEL[1] + 0.9 + (0.7 if title else 0)
    with figure_at(path, size, title, note) as figure:
        grid = figure.subplots(2, len(panels), sharex=True, sharey=True, squeeze=False)
        for (upper, lower), (label, each), percent in zip(grid.T, panels.items(), percents, strict=True):
            faint = np.where(each.value > 0, np.maximum(each.value, norm.vmin), np.nan if decades else 0.0)
            above = _map(upper, each, faint, norm, VALUES)
            below = _map(lower, each, percent, worst, ERRORS)
            upper.set_title(label)
            if words := gap_words(percent, each.reason == "no score"):
                lower.legend(handles=[hatch_key(words)], loc="lower left", fontsize=13)
        _bars(figure, grid, above, below, with_unit("density", density.unit), decades)
        across, up = next(iter(panels.values())).dims
        for axes in grid[-1]:
            axes.set_xlabel(_named(across))
        for axes in grid[:, 0]:
            axes.set_ylabel(_named(up))
    return path


def _panels(density: EstimateArray, times: Sequence[int] | None, reading: object) -> dict[str, EstimateArray]:
    """Label -> density over two coordinates at one time."""
    dims = [name for name in density.dims if name != "time"]
    if len(dims) != 2:
        raise ValueError(
            f"phase_density: {reading.name!r} has the coordinates {dims}, two are needed, such as x=edges, vx=edges"
        )
    at = reading.detector.times
    if "time" not in density.dims:
        return {f"t = {at[0]:.4g} s": density}
    if times is None:
        times = sorted(set(np.linspace(0, len(at) - 1, min(MOST, len(at))).round().astype(int).tolist()))
    return {f"t = {at[k]:.4g} s": density[k] for k in times}


def _norm(fields: list[np.ndarray], decades: float | None, name: str) -> Normalize:
    top = max(float(np.nanmax(field, initial=0.0)) for field in fields)
    if not top > 0:
        raise ValueError(
            f"phase_density: nothing was in the bins of {name!r}; look where and when particles are"
        )
    return Normalize(0.0, top) if decades is None else LogNorm(top * 10.0**-decades, top)


def _map(axes: Axes, bins: EstimateArray, field: np.ndarray, norm: Normalize, colours: str) -> object:
    axes.grid(False)
    if np.isnan(field).any():
        hatch(axes)
    drawn = axes.pcolorfast(*bins.coords.values(), np.ma.masked_invalid(field.T), norm=norm, cmap=colours)
    axes.tick_params(pad=8)
    return drawn


def _bars(
    figure: Figure, grid: np.ndarray, above: object, below: object, label: str, decades: float | None
) -> None:
    extend = "neither" if decades is None else "min"
    figure.colorbar(above, ax=list(grid[0]), pad=0.015, aspect=18, extend=extend).set_label(label)
    bar = figure.colorbar(below, ax=list(grid[1]), pad=0.015, aspect=18)
    bar.set_label(TITLE, fontsize=17)
    tick_errors(bar.ax.yaxis, below.norm)


def _named(coordinate: str) -> str:
    unit = unit_label(COORDINATES[coordinate].unit)
    return f"{WORDS[coordinate]}  [{unit}]" if unit else WORDS[coordinate]
