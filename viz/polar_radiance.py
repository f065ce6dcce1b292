"""Radiance that leaves a layer, by polar angle: what returns above, what passes below; and all residuals."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MultipleLocator, NullLocator

from transport import EstimateArray
from transport.viz.profiles import FURTHEST, in_standard_errors
from transport.viz.style import INK, MARKERS, MUTED, PALETTE, WITHIN_TWO, figure_at

Curve = Callable[[np.ndarray], np.ndarray]

FINE = np.linspace(1e-3, math.pi / 2 - 1e-3, 361)  # rad, from the normal
FLOOR = "#e3eef6"  # of the half below


class Lobes(NamedTuple):
    """What leaves both faces of a layer, over what a white Lambertian one would send back (1 all round).

    mu: (n,) cosines at which bins stand, rising; back, on: (n,) estimates; their exact means (n,) and exact
    curves of mu.
    """

    mu: np.ndarray
    back: EstimateArray
    on: EstimateArray
    back_means: np.ndarray
    on_means: np.ndarray
    back_curve: Curve
    on_curve: Curve


def polar_radiance(
    members: Mapping[str, Lobes], path: str | os.PathLike, title: str | None = None, note: str | None = None
) -> str | os.PathLike:
    """Draw radiance by angle on a logarithmic radius, points on exact lines, and residuals beside; returns
    the path.

    members: label -> lobes, one colour each.  Raises ValueError for none.
    """
    if not members:
        raise ValueError("polar_radiance: members must hold one at least, got none")
    with figure_at(path, (17, 10.4), title, note) as figure:
        left, right = _axes(figure)
        _prepare(left, members)
        right.axhspan(-2, 2, color=WITHIN_TWO, lw=0)
        right.axhline(0, color=INK, lw=1.6)
        right.axvline(0, color=MUTED, lw=1.2, ls=":")
        for place, (label, lobes) in enumerate(members.items()):
            colour, marker = PALETTE[place % len(PALETTE)], MARKERS[place % len(MARKERS)]
            _draw_lobes(left, lobes, colour, marker, label)
            _draw_residuals(right, lobes, colour, marker)
        _furnish(right)
        left.plot([], [], color=MUTED, lw=2.2, label="exact")
        figure.legend(*left.get_legend_handles_labels(), loc="outside lower left", ncols=2)
    return path


def _axes(figure: Figure) -> tuple[Axes, Axes]:
    grid = figure.add_gridspec(1, 2, width_ratios=(1.3, 1))
    return figure.add_subplot(grid[0], projection="polar"), figure.add_subplot(grid[1])


def _prepare(axes: Axes, members: Mapping[str, Lobes]) -> None:
    """The normal points up; the radius is a logarithm, from a tenth of the least mean of a bin up."""
    means = [each for lobes in members.values() for each in (lobes.back_means, lobes.on_means)]
    least, most = (pick([pick(each[each > 0]) for each in means if (each > 0).any()]) for pick in (min, max))
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(-1)
    axes.set_rscale("log")
    axes.set_rlim(least / 3, 1.6 * most)
    axes.yaxis.set_major_locator(LogLocator(10))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.set_rlabel_position(-82)
    axes.tick_params(axis="y", labelsize=15, labelcolor=INK)
    angles = np.arange(0, 360, 30)
    shown = [min(angle % 180, 180 - angle % 180) for angle in angles]
    axes.set_xticks(np.radians(angles), [f"{angle}°" for angle in shown])
    below = np.linspace(math.pi / 2, 3 * math.pi / 2, 181)
    axes.fill_between(below, axes.get_rmin(), axes.get_rmax(), color=FLOOR, lw=0, zorder=0)
    axes.plot([-math.pi / 2] * 2, axes.get_ylim(), color=INK, lw=2)
    axes.plot([math.pi / 2] * 2, axes.get_ylim(), color=INK, lw=2)
    for words, height in (("comes\nback", 0.96), ("passes,\nscattered", 0.04)):
        axes.text(-0.07, height, words, transform=axes.transAxes, va="center", color=MUTED, fontsize=19)
    axes.set_title("π L / irradiance", fontsize=19)


def _draw_lobes(axes: Axes, lobes: Lobes, colour: str, marker: str, label: str) -> None:
    """Lines on both sides, points on the right one."""
    angle = np.arccos(lobes.mu)
    sides = (
        (angle, FINE, lobes.back, lobes.back_curve),
        (math.pi - angle, math.pi - FINE, lobes.on, lobes.on_curve),
    )
    for k, (places, fine, estimates, curve) in enumerate(sides):
        line = np.asarray(curve(np.cos(FINE)))
        for turned in (fine, -fine):
            axes.plot(turned, line, color=colour, lw=2.0)
        value, bar = estimates.value, 2 * np.nan_to_num(estimates.error)
        shown = value > 0
        style = {
            "fmt": marker,
            "ms": 6.5,
            "color": colour,
            "mec": "white",
            "mew": 0.7,
            "lw": 1.8,
            "zorder": 4,
        }
        name = label if k == 0 else None
        axes.errorbar(places[shown], value[shown], np.minimum(bar, 0.9 * value)[shown], label=name, **style)


def _draw_residuals(axes: Axes, lobes: Lobes, colour: str, marker: str) -> None:
    for sign, estimates, means in ((1, lobes.back, lobes.back_means), (-1, lobes.on, lobes.on_means)):
        residual = in_standard_errors(estimates.value, estimates.error, means)
        known = np.isfinite(residual)
        heights = np.clip(residual[known], -FURTHEST, FURTHEST)
        axes.plot(sign * lobes.mu[known], heights, marker, color=colour, mec="white", mew=0.8, ms=8)


def _furnish(axes: Axes) -> None:
    reach = max(3.4, *np.abs(axes.get_ylim()))
    axes.set(xlim=(-1.03, 1.03), ylim=(-reach, reach))
    axes.xaxis.set_major_locator(MultipleLocator(0.5))
    axes.set_xlabel("cosine μ:  passes < 0 < comes back")
    axes.set_ylabel("residual of each bin  [std. errors]")
