"""Ducts through a shield: maps of the fluence rate in layers, and how points in them compare with what is
known.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.ticker import LogLocator

from transport.viz.style import INK, MARKERS, MUTED, PALETTE, WITHIN_TWO, figure_at, outlined

COLOURS, NOTHING = "inferno", "#3a3a3a"
PANEL = 6.4  # inches across
FURTHEST = 5.0  # standard errors shown


class Layer(NamedTuple):
    """A map, (nx, ny), of one octant from the origin on; outlines: low and high (x, y) [cm] of voids and
    source, which is the last;  points: name -> (x, y, ...) [cm].
    """

    label: str
    rates: np.ndarray
    outlines: Sequence[tuple[Sequence[float], Sequence[float]]]
    points: Mapping[str, Sequence[float]]


class Duct(NamedTuple):
    """One problem.  cell: width of the map's cells [cm];  ratios: name -> ratio to what is known, and its
    standard error; against: what is known.
    """

    label: str
    cell: float
    layers: Sequence[Layer]
    ratios: Mapping[str, tuple[float, float]]
    against: str


def duct_maps(
    ducts: Sequence[Duct], path: str | os.PathLike, title: str | None = None, note: str | None = None
) -> str | os.PathLike:
    """Draw the layers of each problem in one scale of decades, and ratios below; returns the path.

    Raises ValueError for no problems.
    """
    if not ducts:
        raise ValueError("duct_maps: at least one problem is needed, got none")
    widths = [max(len(duct.layers), 1.35) for duct in ducts]
    norm = _norm([layer.rates for duct in ducts for layer in duct.layers])
    with figure_at(path, (2.4 + PANEL * sum(widths), 15.5), title, note) as figure:
        columns = figure.subfigures(1, len(ducts), width_ratios=widths, squeeze=False)[0]
        for column, duct in zip(columns, ducts, strict=True):
            above, below = column.subfigures(2, 1, height_ratios=(1.9, 1))
            above.suptitle(duct.label, fontsize=21)
            panels = above.subplots(1, len(duct.layers), squeeze=False, sharey=True)[0]
            for axes, layer in zip(panels, duct.layers, strict=True):
                mesh = _draw_layer(axes, layer, duct, norm)
            panels[0].set_ylabel("y  [cm]")
            if duct is ducts[-1]:
                bar = above.colorbar(mesh, ax=panels, shrink=0.8, pad=0.02, extend="min")
                bar.set_label(r"fluence rate  [$\mathrm{cm^{-2}\,s^{-1}}$]")
                bar.ax.yaxis.set_major_locator(LogLocator(10, numticks=20))
            _draw_ratios(below.subplots(), duct)
    return path


def _norm(maps: Sequence[np.ndarray]) -> LogNorm:
    """Whole decades about all that was counted."""
    found = np.concatenate([rates[rates > 0] for rates in maps])
    return LogNorm(
        10 ** math.floor(math.log10(np.quantile(found, 0.005))), 10 ** math.ceil(math.log10(found.max()))
    )


def _draw_layer(axes: Axes, layer: Layer, duct: Duct, norm: LogNorm):
    nx, ny = layer.rates.shape
    mesh = axes.pcolormesh(
        duct.cell * np.arange(nx + 1),
        duct.cell * np.arange(ny + 1),
        np.where(layer.rates > 0, layer.rates, np.nan).T,
        cmap=COLOURS,
        norm=norm,
        rasterized=True,
    )
    axes.set_facecolor(NOTHING)
    axes.grid(False)
    for k, (low, high) in enumerate(layer.outlines):
        is_source = k == len(layer.outlines) - 1 and high[0] == -low[0]
        x, y = (np.clip([low[a], high[a]], 0, None) for a in (0, 1))
        if np.ptp(x) and np.ptp(y):
            style = {"ls": "-", "lw": 2.2} if is_source else {"ls": "--", "lw": 1.6}
            axes.plot(x[[0, 1, 1, 0, 0]], y[[0, 0, 1, 1, 0]], color="white", path_effects=outlined(), **style)
    for name, (x, y, *_) in layer.points.items():
        colour, marker = _look(duct, name)
        axes.plot(x, y, marker=marker, color=colour, mec="white", mew=1.6, ms=12, zorder=5)
    axes.set_aspect("equal")
    axes.set_xlabel("x  [cm]")
    axes.set_title(layer.label, fontsize=18)
    return mesh


def _look(duct: Duct, name: str) -> tuple[str, str]:
    """Colour and marker of a point, the same in map and chart."""
    names = list(dict.fromkeys([*duct.ratios, *(name for layer in duct.layers for name in layer.points)]))
    place = names.index(name)
    return PALETTE[place % len(PALETTE)], MARKERS[place % len(MARKERS)]


def _draw_ratios(axes: Axes, duct: Duct) -> None:
    """How many standard errors each point is off; beside it, how large one is."""
    if not duct.ratios:
        axes.text(
            0.5, 0.5, "nothing is known to compare with", ha="center", transform=axes.transAxes, color=MUTED
        )
        axes.axis("off")
        return
    axes.axvspan(-2, 2, color=WITHIN_TWO, lw=0)
    axes.axvline(0, color=INK, lw=1.6)
    for row, (name, (ratio, error)) in enumerate(duct.ratios.items()):
        colour, marker = _look(duct, name)
        off = np.clip((ratio - 1) / error, -FURTHEST, FURTHEST)
        axes.plot(off, row, marker=marker, color=colour, ms=12, mec="white", mew=0.8, zorder=3)
        axes.text(
            1.02, row, f"{100 * error:.2g} %", va="center", transform=axes.get_yaxis_transform(), fontsize=15
        )
    axes.text(1.02, -0.9, "1 std. error", transform=axes.get_yaxis_transform(), fontsize=15, color=MUTED)
    axes.set_yticks(range(len(duct.ratios)), list(duct.ratios), fontsize=15)
    axes.set_ylim(len(duct.ratios) - 0.4, -0.6)
    axes.set_xlim(-1.1 * FURTHEST, 1.1 * FURTHEST)
    axes.set_xlabel(f"off {duct.against}  [std. errors]", fontsize=18)
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0)
