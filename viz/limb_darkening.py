"""Limb darkening: radiance by cosine on exact curves, residuals, and a star half counted, half by the law."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from transport.viz.profiles import FURTHEST, in_standard_errors
from transport.viz.style import INK, MARKERS, MUTED, PALETTE, POINTS, WITHIN_TWO, figure_at

FINE = np.linspace(0, 1, 401)
PIXELS = 801  # across the disk


class Limb(NamedTuple):
    """Radiance over that of a Lambertian face of the same exitance, pi L/M.

    edges: (n + 1,) of bins of cosine from 0 to 1; value, error: (n,) bin means and standard errors; means:
    (n,) exact ones; law: function of mu; is_star: whether the disk shows it.
    """

    edges: np.ndarray
    value: np.ndarray
    error: np.ndarray
    means: np.ndarray
    law: Callable[[np.ndarray], np.ndarray]
    is_star: bool = False


def limb_darkening(
    members: Mapping[str, Limb], path: str | os.PathLike, title: str | None = None, note: str | None = None
) -> str | os.PathLike:
    """Draw each limb by cosine with bars of two standard errors, residuals below, the star beside; returns
    the path.

    Raises ValueError for none.
    """
    if not members:
        raise ValueError("limb_darkening: members must hold one at least, got none")
    star = next((limb for limb in members.values() if limb.is_star), None)
    with figure_at(path, (19 if star else 13, 10), title, note) as figure:
        grid = figure.add_gridspec(
            2, 2 if star else 1, height_ratios=(2.6, 1), width_ratios=(1.25, 1)[: 1 + bool(star)]
        )
        main = figure.add_subplot(grid[0, 0])
        lowest = figure.add_subplot(grid[1, 0], sharex=main)
        lowest.axhspan(-2, 2, color=WITHIN_TWO, lw=0)
        lowest.axhline(0, color=INK, lw=1.6)
        for place, (label, limb) in enumerate(members.items()):
            _draw(main, lowest, limb, label, PALETTE[place % len(PALETTE)], MARKERS[place % len(MARKERS)])
        main.plot([], [], color=MUTED, lw=2.2, label="exact")
        main.axhline(1, color=MUTED, lw=1.6, ls=":", label="Lambert's law")
        main.set_ylim(0, 1.25 * main.get_ylim()[1])
        main.legend(loc="upper right", title="points ± 2 standard errors", title_fontsize=15)
        main.set_ylabel("radiance  π L / exitance")
        reach = max(3.4, *np.abs(lowest.get_ylim()))
        lowest.set(xlim=(0, 1.01), ylim=(-reach, reach), xlabel="cosine μ of the angle to the normal")
        lowest.set_ylabel("residual\n[std. errors]")
        main.tick_params(labelbottom=False)
        figure.align_ylabels()
        if star:
            _draw_star(figure.add_subplot(grid[:, 1]), star)
    return path


def _draw(main: Axes, lowest: Axes, limb: Limb, label: str, colour: str, marker: str) -> None:
    mu = np.sqrt((limb.edges[1:] ** 2 + limb.edges[:-1] ** 2) / 2)
    value, error = limb.value, limb.error
    main.plot(FINE[1:], limb.law(FINE[1:]), color=colour, lw=2.2)
    main.errorbar(mu, value, 2 * error, fmt=marker, color=colour, label=label, zorder=4, **POINTS)
    residual = np.clip(in_standard_errors(value, error, limb.means), -FURTHEST, FURTHEST)
    lowest.plot(mu, residual, marker, color=colour, mec="white", mew=0.8)


def _draw_star(axes: Axes, limb: Limb) -> None:
    """The disk as it is seen from afar: at the distance r of its middle mu is sqrt(1 - r^2)."""
    across = np.linspace(-1, 1, PIXELS)
    x, y = np.meshgrid(across, across)
    r2 = x**2 + y**2
    mu = np.sqrt(np.clip(1 - r2, 0, 1))
    place = np.clip(np.searchsorted(limb.edges, mu, side="right") - 1, 0, len(limb.edges) - 2)
    shown = np.where(x < 0, limb.value[place], np.interp(mu, FINE[1:], limb.law(FINE[1:])))
    shown = np.ma.masked_where(r2 > 1, shown)
    style = {"cmap": "afmhot", "vmin": 0, "vmax": 1.15 * float(shown.max()), "rasterized": True}
    picture = axes.pcolormesh(across, across, shown, **style)
    axes.add_patch(Circle((0, 0), 1, fill=False, ec=INK, lw=1.2))
    axes.plot([0, 0], [-1.06, 1.06], color=INK, lw=1.2, ls=":")
    for x_words, words in ((-0.5, "counted, by bins"), (0.5, "by the law")):
        axes.text(x_words, 1.1, words, ha="center", fontsize=18)
    axes.set(aspect="equal", xlim=(-1.08, 1.08), ylim=(-1.36, 1.24))
    axes.set_axis_off()
    axes.set_title("Milne's star, seen from afar", fontsize=20)
    bar = axes.figure.colorbar(
        picture, cax=axes.inset_axes([0.15, 0.07, 0.7, 0.025]), orientation="horizontal"
    )
    bar.set_label("π L / exitance")
