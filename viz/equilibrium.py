"""Equilibrium: light from one lamp and from all, radiance by kind of thing and by direction, the scores of bins."""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from transport import Estimate, EstimateArray
from transport.viz.style import (
    BLUE,
    INK,
    MARKERS,
    MUTED,
    PALETTE,
    POINTS,
    VERMILLION,
    WITHIN_TWO,
    figure_at,
    outlined,
)

REACH, CELL = 5.0, 0.25  # of the histogram of scores, and of its cells
Places = Mapping[str, tuple[float, float]]


def equilibrium(
    maps: Mapping[str, EstimateArray],
    places: Places,
    kinds: Mapping[str, Estimate],
    angles: Mapping[str, tuple[EstimateArray, np.ndarray]],
    scores: np.ndarray,
    least: int,
    path: str | os.PathLike,
    title: str | None = None,
    note: str | None = None,
) -> str | os.PathLike:
    """Draw maps over (u, v) from 0 up, and below them three tests of equilibrium; returns the path.

    maps: relative to what is expected of all light;  places: names of what stands there, at (u, v) [m].
    kinds: estimates of 1.  angles: label -> radiance by mu, and its exact values.
    scores: normal ones, of bins of `least` counts or more.
    """
    with figure_at(path, (23, 7.2 + 7.4), title, note) as figure:
        above, below = figure.subfigures(2, 1, height_ratios=(1, 1.2))
        _draw_maps(above, maps, places)
        left, middle, right = below.subplots(1, 3, width_ratios=(1.25, 1, 1))
        _draw_kinds(left, kinds)
        _draw_angles(middle, angles)
        _draw_scores(right, scores, least)
    return path


def _draw_maps(figure: Figure, maps: Mapping[str, EstimateArray], places: Places) -> None:
    for axes, (label, shares) in zip(figure.subplots(1, len(maps), sharey=True), maps.items(), strict=True):
        top = 1.2 * np.quantile(shares.value, 0.98)
        shown = axes.pcolormesh(
            shares.coords["u"],
            shares.coords["v"],
            shares.value.T,
            vmin=0,
            vmax=top,
            cmap="inferno",
            rasterized=True,
        )
        figure.colorbar(shown, ax=axes, shrink=0.8, pad=0.015).set_label("E / π L₀")
        for name, (u, v) in places.items():
            style = {"color": "white", "fontsize": 15, "ha": "center", "va": "center"}
            axes.text(u, v, name, path_effects=outlined(2.4), **style)
        axes.set(title=label, xlabel="x  [m]", aspect="equal")
        axes.grid(False)
        if axes.get_subplotspec().is_first_col():
            axes.set_ylabel("y  [m]")


def _draw_kinds(axes: Axes, kinds: Mapping[str, Estimate]) -> None:
    for row, estimate in enumerate(kinds.values()):
        axes.errorbar(
            100 * (estimate.value - 1), row, xerr=200 * estimate.error, fmt="o", color=BLUE, **POINTS
        )
    axes.axvline(0, color=INK, lw=1.6)
    axes.set_yticks(range(len(kinds)), list(kinds))
    axes.set_ylim(len(kinds) - 0.4, -0.6)
    axes.grid(False, axis="y")
    axes.set(xlabel="L / n²L₀ − 1  [%],  ± 2 standard errors", title="Radiance by kind of thing")


def _draw_angles(axes: Axes, angles: Mapping[str, tuple[EstimateArray, np.ndarray]]) -> None:
    for (label, (radiance, expected)), colour, marker in zip(angles.items(), PALETTE, MARKERS, strict=False):
        theta = np.degrees(np.arccos(radiance.coords["mu"]))
        axes.stairs(expected[::-1], theta[::-1], color=colour, lw=6, alpha=0.3, baseline=None)
        middles, bars = (theta[1:] + theta[:-1]) / 2, 2 * np.nan_to_num(radiance.error)
        axes.errorbar(middles, radiance.value, yerr=bars, fmt=marker, color=colour, label=label, **POINTS)
    axes.set(
        xlim=(0, 90),
        xlabel="angle to the normal, in the glass  [deg]",
        ylabel="L / L₀",
        title="Glass with nothing in it",
    )
    axes.set_xticks(range(0, 91, 15))
    axes.set_ylim(0, 1.35 * max(expected.max() for _, expected in angles.values()))
    axes.legend(loc="upper right")


def _draw_scores(axes: Axes, scores: np.ndarray, least: int) -> None:
    edges = np.arange(-REACH, REACH + CELL / 2, CELL)
    beyond = np.count_nonzero(np.abs(scores) > REACH)
    axes.axvspan(-2, 2, color=WITHIN_TWO, lw=0)
    axes.stairs(
        np.histogram(scores, edges)[0], edges, fill=True, color=BLUE, alpha=0.75, label=f"{scores.size} bins"
    )
    z = np.linspace(-REACH, REACH, 401)
    chance = scores.size * CELL * np.exp(-z * z / 2) / np.sqrt(2 * np.pi)
    axes.plot(z, chance, color=VERMILLION, lw=3, label="chance alone")
    axes.text(
        0.03,
        0.97,
        f"{beyond} beyond ±{REACH:g}",
        transform=axes.transAxes,
        va="top",
        color=MUTED,
        fontsize=16,
    )
    axes.set(
        xlim=(-REACH, REACH),
        xlabel="z  [standard errors]",
        ylabel="bins",
        title=f"Bins of {least} counts and more",
    )
    axes.legend(loc="upper right", fontsize=15)
