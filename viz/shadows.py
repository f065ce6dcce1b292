"""Shadows: the section through lamp, obstacle and screen; the irradiance across; the residuals; a column a shadow."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from transport import EstimateArray
from transport.viz.profiles import in_standard_errors
from transport.viz.style import BLUE, INK, MUTED, ORANGE, POINTS, WITHIN_TWO, figure_at, with_unit

MM = 1e3
SECTION = (300, 160)  # places across and down at which the section is shaded
NIGHT, DAY = 0.18, 1.0  # grey of the umbra and of full light
SHADES = {"umbra": "#c4c4c4", "antumbra": "#dedede", "penumbra": "#ececec"}


class ShadowColumn(NamedTuple):
    """One shadow.  Lengths in metres; x across the shadow, z from the lamp to the screen.

    edges (n + 1,), estimates (n,), expected (n,): bins of irradiance and their exact means.  curve(x): exact values.
    seen(x, z): share of the lamp that is seen, (z, x).  zones: name, low and high of each.
    lamp: its radius;  thickness: the cylinder's radius, 0 for an edge.
    """

    edges: np.ndarray
    estimates: EstimateArray
    expected: np.ndarray
    curve: Callable[[np.ndarray], np.ndarray]
    seen: Callable[[np.ndarray, np.ndarray], np.ndarray]
    zones: Sequence[tuple[str, float, float]]
    lamp: float
    gap: float
    distance: float
    thickness: float


def shadow_columns(
    columns: Mapping[str, ShadowColumn],
    path: str | os.PathLike,
    title: str | None = None,
    note: str | None = None,
) -> str | os.PathLike:
    """Draw for each shadow its section, its irradiance with bars of two standard errors, and residuals; returns the path.

    Raises ValueError for no columns.
    """
    if not columns:
        raise ValueError("shadow_columns: at least one column is needed, got none")
    with figure_at(path, (3 + 7.2 * len(columns), 14), title, note) as figure:
        grid = figure.subplots(
            3, len(columns), squeeze=False, sharex="col", sharey="row", height_ratios=(1.5, 1.7, 0.8)
        )
        for (label, column), axes in zip(columns.items(), grid.T, strict=True):
            _draw_section(axes[0], column)
            _draw_irradiance(axes[1], column)
            _draw_residuals(axes[2], column)
            axes[0].set_title(label)
            axes[2].set_xlabel("x  [mm]")
            axes[2].set_xlim(MM * column.edges[0], MM * column.edges[-1])
        _name_rows(figure, grid, next(iter(columns.values())))
    return path


def _name_rows(figure: Figure, grid: np.ndarray, first: ShadowColumn) -> None:
    grid[0, 0].set_ylabel("from the lamp, z  [m]")
    grid[1, 0].set_ylabel(with_unit("irradiance E", first.estimates.unit))
    grid[1, 0].set_ylim(np.array([-0.04, 1.2]) * first.expected.max())
    grid[2, 0].set_ylabel("residual\n[std. errors]")
    figure.align_ylabels(grid[:, 0])
    grid[1, 0].legend(loc="best", fontsize=15)


def _draw_section(axes: Axes, column: ShadowColumn) -> None:
    """The lamp above, the screen below; shaded by the share of the lamp that is seen."""
    left, right = column.edges[[0, -1]]
    x, z = np.linspace(left, right, SECTION[0]), np.linspace(0, column.distance, SECTION[1])
    grey = NIGHT + (DAY - NIGHT) * column.seen(x, z)
    axes.pcolormesh(MM * x, z, grey, cmap="gray", vmin=0, vmax=1, shading="nearest", rasterized=True)
    axes.grid(False)
    axes.plot(MM * column.lamp * np.array([-1, 1]), [0, 0], color=ORANGE, lw=9, solid_capstyle="butt")
    axes.text(0, 0.045 * column.distance, "lamp", color=INK, ha="center", va="top", fontsize=16)
    _draw_obstacle(axes, column, left)
    for _, _, border in column.zones[:-1]:
        _draw_border_rays(axes, column, border)
    axes.plot(MM * np.array([left, right]), [column.distance] * 2, color=INK, lw=5)
    axes.set_ylim(1.02 * column.distance, -0.04 * column.distance)


def _draw_obstacle(axes: Axes, column: ShadowColumn, left: float) -> None:
    if column.thickness == 0:
        axes.plot([MM * left, 0], [column.gap] * 2, color=INK, lw=6, solid_capstyle="butt")
        return
    angle = np.linspace(0, 2 * np.pi, 200)
    axes.fill(
        MM * column.thickness * np.cos(angle),
        column.gap + column.thickness * np.sin(angle),
        color=INK,
        zorder=3,
    )


def _draw_border_rays(axes: Axes, column: ShadowColumn, border: float) -> None:
    """From the border of a zone back to the rim of the lamp that it sees just there, past the obstacle."""
    ends = np.array([-1.0, 1.0]) * column.lamp
    across = border + (ends - border) * (1 - column.gap / column.distance)
    slant = np.hypot(1, (ends - border) / column.distance)
    end = ends[np.argmin(np.abs(np.abs(across) / slant - column.thickness))]
    axes.plot([MM * border, MM * end], [column.distance, 0], color=ORANGE, lw=1.6, zorder=2)


def _draw_irradiance(axes: Axes, column: ShadowColumn) -> None:
    for name, low, high in column.zones:
        if name in SHADES:
            axes.axvspan(MM * low, MM * high, color=SHADES[name], lw=0, zorder=0)
        word = name.replace(" ", "\n")
        axes.text(
            MM * (low + high) / 2, 0.985, word, transform=axes.get_xaxis_transform(), ha="center", va="top",
            fontsize=15, color=MUTED,
        )  # fmt: skip
    fine = np.linspace(column.edges[0], column.edges[-1], 1201)
    axes.plot(MM * fine, column.curve(fine), color=INK, lw=2.2, label="exact")
    middles, value, error = _points(column)
    known = np.isfinite(error)
    axes.errorbar(
        MM * middles[known], value[known], 2 * error[known], fmt="o", color=BLUE, zorder=4,
        label="bin means, ± 2 std. errors", **POINTS,
    )  # fmt: skip
    axes.plot(
        MM * middles[~known], value[~known], "o", mfc="white", mec=BLUE, mew=1.6, label="nothing arrived"
    )


def _draw_residuals(axes: Axes, column: ShadowColumn) -> None:
    """From the exact means over the bins."""
    middles, value, error = _points(column)
    residual = in_standard_errors(value, error, column.expected)
    axes.axhspan(-2, 2, color=WITHIN_TWO, lw=0)
    axes.axhline(0, color=INK, lw=1.6)
    axes.plot(MM * middles, np.clip(residual, -5.5, 5.5), "o", color=BLUE, mec="white", mew=0.8)
    axes.set_ylim(-6, 6)


def _points(column: ShadowColumn) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return (column.edges[1:] + column.edges[:-1]) / 2, column.estimates.value, column.estimates.error
