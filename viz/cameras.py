"""What a camera or an environment map saw: the radiance on a scale of decades, and beside it its relative error."""

from __future__ import annotations

import os

import numpy as np
from matplotlib.colorbar import Colorbar
from matplotlib.colors import LogNorm, Normalize
from matplotlib.ticker import FuncFormatter

from transport.viz.style import MUTED, figure_at, with_unit
from transport.viz.uncertainty import ERRORS, TITLE, VALUES, error_norm, hatch, percent_of, tick_errors

WORST = 100.0  # %, at the top of the scale of errors at the most
WIDTH = 6.2  # inches, of an image
DIRECTIONS = (0, 90, 180, 270, 360)  # ticks of azimuth [deg]


def seen(
    reading: object,
    path: str | os.PathLike,
    decades: float = 2.0,
    title: str | None = None,
    note: str | None = None,
) -> str | os.PathLike:
    """Draw what a Camera or EnvironmentMap saw: the radiance, and beside it its relative standard error [%].

    Parameters
    ----------
    reading : ViewReading
        `result["view"]` of a Camera or of an EnvironmentMap.
    path : str or os.PathLike
        File to write; its folder is made.
    decades : float
        Range of the logarithmic scale, below the greatest radiance [decades]; darker pixels have the darkest
        colour.
    title, note : str, optional
        Headline, and provenance in small type, such as particles and seed.

    Returns
    -------
    str or os.PathLike
        `path`.

    Raises
    ------
    ValueError
        For an image that is dark everywhere.

    Notes
    -----
    Both pictures are seen from the instrument's place: what is on the right of a camera's picture is on the
    right in a map.  The azimuth of a map, which turns from +x towards +y, therefore grows to the left, as
    in a map of the sky.  Pixels without a known error (no score, or the same in every batch) are hatched on
    grey, those with a doubtful one above their colour.

    Examples
    --------
    >>> viz.seen(result["around"], "around.png", decades=3)  # doctest: +SKIP
    """
    image, errors = reading.image(), reading.errors()
    top = float(np.max(image))
    if not top > 0:
        raise ValueError(f"seen: {reading.name!r} saw no light at all; run more particles")
    percent = percent_of(image, errors)
    steepness = _steepness(reading)
    width = WIDTH * min(1.0, 1.4 / steepness)
    height = width * steepness + (3.8 if _is_map(reading) else 2.6)
    with figure_at(path, (2 * width + 4.2, height), title, note) as figure:
        left, right = figure.subplots(1, 2)
        light = LogNorm(top * 10.0**-decades, top)
        dark = np.maximum(image, light.vmin)
        _picture(
            figure, left, reading, dark, light, VALUES, with_unit("radiance", reading.radiance.unit), "min"
        )
        worst = _error_norm(percent)
        bar = _picture(figure, right, reading, percent, worst, ERRORS, TITLE, "both")
        tick_errors(bar.ax.xaxis, worst)
        doubtful = _doubtful(reading) & ~np.isnan(percent)
        if _is_map(reading):
            theta, phi = (np.degrees(edges) for edges in reading.radiance.coords.values())
        else:
            theta, phi = (np.arange(n + 1) - 0.5 for n in doubtful.shape)
        hatch(right, doubtful, phi, theta)
        kinds = {"no error known": np.isnan(percent), "doubtful error": doubtful}
        if hatched := [words for words, where in kinds.items() if where.any()]:
            right.set_title(f"hatched: {', '.join(hatched)}", fontsize=15, color=MUTED, pad=8)
    return path


def _doubtful(reading: object) -> np.ndarray:
    """Which pixels have a doubtful error, in the order of `image`."""
    doubtful = reading.radiance.is_doubtful
    return doubtful if _is_map(reading) else doubtful[::-1]


def _is_map(reading: object) -> bool:
    """Whether it is an EnvironmentMap's, by polar angle and azimuth."""
    return "theta" in reading.radiance.dims


def _steepness(reading: object) -> float:
    """Height over width of the image: of the pixels, or of the angles."""
    if not _is_map(reading):
        return reading.image().shape[0] / reading.image().shape[1]
    theta, phi = reading.radiance.coords.values()
    return float(np.ptp(theta) / np.ptp(phi))


def _error_norm(percent: np.ndarray) -> Normalize:
    """Two decades at the most: what a lamp fills is nearly exact, and would stretch the scale."""
    norm = error_norm(np.clip(percent, None, WORST))
    if isinstance(norm, LogNorm):
        norm.vmin = max(norm.vmin, norm.vmax / 100)
    return norm


def _picture(figure, axes, reading, values, norm, colours: str, words: str, extend: str) -> Colorbar:
    """One image with its bar; ticks of angle on a map, none on a photograph."""
    is_map = _is_map(reading)
    if np.isnan(values).any():
        hatch(axes)
    known, look = np.ma.masked_invalid(values), {"norm": norm, "cmap": colours}
    axes.grid(False)
    if is_map:
        theta, phi = (np.degrees(edges) for edges in reading.radiance.coords.values())
        shown = axes.pcolormesh(phi, theta, known, rasterized=True, **look)  # bins may be unlike
        # Seen from inside: the zenith is on top, and azimuth grows to the left.
        axes.set(aspect="equal", xlim=phi[[-1, 0]], ylim=theta[[-1, 0]])
        axes.set_xlabel(r"azimuth $\varphi$, seen from inside")
        axes.set_ylabel(r"polar angle $\theta$")
        axes.set_xticks([angle for angle in DIRECTIONS if phi[0] <= angle <= phi[-1]])
        axes.set_yticks([angle for angle in (0, 45, 90, 135, 180) if theta[0] <= angle <= theta[-1]])
        axes.tick_params(axis="x", pad=9)  # clear of the polar angle's lowest label
        axes.xaxis.set_major_formatter(FuncFormatter(_degrees))
        axes.yaxis.set_major_formatter(FuncFormatter(_degrees))
    else:
        shown = axes.imshow(known, interpolation="nearest", **look)
        axes.set_xticks([])
        axes.set_yticks([])
    bar = figure.colorbar(shown, ax=axes, orientation="horizontal", extend=extend, shrink=0.9, pad=0.03)
    bar.set_label(words)
    return bar


def _degrees(angle: float, _: int) -> str:
    return f"{angle:g}°"
