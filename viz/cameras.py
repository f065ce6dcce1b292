"""What a camera or an environment map saw: the radiance on a scale of decades, and beside it its relative error."""

from __future__ import annotations

import os

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.ticker import FuncFormatter

from viz.style import MUTED, figure_at, with_unit

WORST = 1.0  # relative error at the top of its scale
DIRECTIONS = (0, 90, 180, 270, 360)  # ticks of azimuth [deg]


def seen(
    reading: object,
    path: str | os.PathLike,
    decades: float = 2.0,
    title: str | None = None,
    note: str | None = None,
) -> str | os.PathLike:
    """Draw `result["view"]` of a Camera or EnvironmentMap: radiance from its greatest down by so many decades, and errors.

    Pixels that are darker have the darkest colour; where nothing came at all, so that no error is known, the error is
    grey.  Returns the path; raises ValueError for an image that is dark everywhere.
    """
    image, errors = reading.image(), reading.errors()
    top = float(np.max(image))
    if not top > 0:
        raise ValueError(f"seen: {reading.name!r} saw no light at all; run more particles")
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = errors / image
    shape = image.shape
    width = 6.2 * min(1.0, 1.4 * shape[1] / shape[0])
    with figure_at(path, (2 * width + 4.2, width * shape[0] / shape[1] + 2.6), title, note) as figure:
        left, right = figure.subplots(1, 2)
        light = LogNorm(top * 10.0**-decades, top)
        dark = np.maximum(image, light.vmin)
        _picture(
            figure, left, reading, dark, light, "inferno", with_unit("radiance", reading.radiance.unit), "min"
        )
        worst = LogNorm(max(WORST * 1e-3, float(np.nanmin(relative))), WORST)
        _picture(figure, right, reading, relative, worst, "viridis", "relative standard error", "max")
    return path


def _picture(figure, axes, reading, values, norm, colours: str, words: str, extend: str) -> None:
    """One image with its bar; ticks of angle on a map, none on a photograph."""
    is_map = "theta" in reading.radiance.dims
    extent = None
    if is_map:
        theta, phi = (np.degrees(edges) for edges in reading.radiance.coords.values())
        extent = (phi[0], phi[-1], theta[-1], theta[0])
    axes.set_facecolor(MUTED)
    shown = axes.imshow(
        values, norm=norm, cmap=colours, extent=extent, aspect="equal", interpolation="nearest"
    )
    axes.grid(False)
    if is_map:
        axes.set_xlabel(r"azimuth $\varphi$")
        axes.set_ylabel(r"polar angle $\theta$")
        axes.set_xticks([angle for angle in DIRECTIONS if extent[0] <= angle <= extent[1]])
        axes.set_yticks([angle for angle in (0, 45, 90, 135, 180) if extent[3] <= angle <= extent[2]])
        axes.xaxis.set_major_formatter(FuncFormatter(_degrees))
        axes.yaxis.set_major_formatter(FuncFormatter(_degrees))
    else:
        axes.set_xticks([])
        axes.set_yticks([])
    figure.colorbar(shown, ax=axes, orientation="horizontal", extend=extend, shrink=0.9, pad=0.03).set_label(
        words
    )


def _degrees(angle: float, _: int) -> str:
    return f"{angle:g}°"
