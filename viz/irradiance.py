"""What falls on a surface by place, or is in the cells of a volume: its map, the map of its error, and a cut."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.ticker import FuncFormatter, MaxNLocator

from transport.viz.places import Coordinate, Places, places_of
from transport.viz.style import BLUE, INK, VERMILLION, axes_at, figure_at, outlined, with_unit
from transport.viz.uncertainty import (
    ERRORS,
    TITLE,
    VALUES,
    draw_points,
    error_bar,
    error_norm,
    gap_words,
    hatch,
    hatch_key,
    on_scale,
    percent_of,
    value_bar,
    value_norm,
)

FINEST = 1.5  # deg, of an arc drawn as one cell
PANEL, BELOW, CUT = 5.6, 2.3, (6.6, 5.0)  # inches: a map's longer side, what its bar needs, the cut
MOST_STRETCHED = 3.0  # sides of a map
SIDES, MARKS = (VERMILLION, BLUE), "os"  # of a cut through a disk


def irradiance_map(
    reading: object,
    path: str | os.PathLike,
    quantity: str = "irradiance",
    exact: np.ndarray | None = None,
    row: int | None = None,
    at: Mapping[str, int] | None = None,
    decades: float | None = None,
    title: str | None = None,
    note: str | None = None,
) -> str | os.PathLike:
    """Draw a quantity by place, its relative standard error [%] and a cut.

    Parameters
    ----------
    reading : Reading
        `result["meter"]` of a Detector with positions, or of a VolumeDetector with cells.  Of bins along one
        coordinate only the cut is drawn.
    path : str or os.PathLike
        File to write; its folder is made.
    quantity : str
        Such as "fluence_rate" or "absorbed_density" of a VolumeDetector.
    exact : numpy.ndarray, optional
        Means over the bins, shaped as the quantity; drawn as steps in the cut.
    row : int, optional
        Row of bins along which the cut runs across the map; on a disk a sector of azimuth, from which the cut
        goes on through the centre into the opposite one [default: the brightest].
    at : Mapping[str, int], optional
        Bin to take along other axes, such as {"time": 3}.
    decades : float, optional
        Range of a logarithmic scale, below the greatest value [default: a linear scale].
    title, note : str, optional
        Headline, and provenance in small type, such as particles and seed.

    Returns
    -------
    str or os.PathLike
        `path`.

    Raises
    ------
    ValueError
        If there are no bins of place, or `exact` has another shape.

    Notes
    -----
    The brightest row, or sector, is that of the brightest bin: the greatest value less its standard error,
    so that one large score of a rare particle does not decide.  Bins that are nan or have no known error
    are left out, unless no error is known at all.  Of equal rows the one nearest the middle is taken, of
    equal sectors the first.

    Examples
    --------
    >>> viz.irradiance_map(result["floor"], "floor.png", decades=2)  # doctest: +SKIP
    """
    places = places_of(reading, quantity, at)
    means = (
        None
        if exact is None
        else _arranged(np.asarray(exact, float), places, getattr(reading, quantity).shape)
    )
    label = quantity.replace("_", " ")
    if len(places.axes) == 1:
        with figure_at(path, (13, 8.4), title, note) as figure:
            _draw_cut(figure.subplots(), places, None, means, label, decades)
        return path
    row = _brightest_row(places) if row is None else row
    across, up = _panel(places)
    size = 2 * across + CUT[0] + 5.2, max(up + BELOW, CUT[1] + 2.5) + (1.5 if title else 0.8)
    with figure_at(path, size, title, note, "none") as figure:
        lefts, bottom = (1.2, across + 2.7), size[1] - (1.5 if title else 0.8) - up
        values, errors = (axes_at(figure, left, bottom, across, up) for left in lefts)
        bars = [axes_at(figure, left + 0.3, bottom - 1.3, across - 0.6, 0.2) for left in lefts]
        cut = axes_at(figure, size[0] - CUT[0] - 0.4, size[1] - (1.5 if title else 0.8) - CUT[1], *CUT)
        _map_values(values, bars[0], places, label, decades)
        _map_errors(errors, bars[1], places)
        _mark_row(values, places, row)
        _draw_cut(cut, places, row, means, label, decades)
    return path


def _brightest_row(places: Places) -> int:
    """The row, or sector of a disk, of the brightest bin; of equal ones that nearest the middle, or first."""
    # Take one standard error off, so that a bin with a single large score does not win.
    sure = places.value - places.error
    if not np.isfinite(sure).any():
        sure = places.value
    peaks = np.where(np.isfinite(sure), sure, -np.inf).max(axis=0)
    start = 0 if places.is_round else len(peaks) // 2
    return min(np.flatnonzero(peaks == peaks.max()).tolist(), key=lambda row: abs(row - start))


def _panel(places: Places) -> tuple[float, float]:
    """Width and height of a map [inches]: lengths on one scale, where it is not too long and thin for that."""
    if places.is_round or not places.is_metric:
        return PANEL, PANEL
    across, up = (np.ptp(edges) for edges in places.edges)
    stretch = min(max(up / across, 1 / MOST_STRETCHED), MOST_STRETCHED)
    return (PANEL, PANEL * stretch) if stretch <= 1 else (PANEL / stretch, PANEL)


def _map_values(axes: Axes, below: Axes, places: Places, label: str, decades: float | None) -> None:
    norm = value_norm(places.value, places.error, decades)
    drawn = _draw(axes, places, on_scale(places.value, norm), norm, VALUES)
    axes.set_title(with_unit(label, places.unit))
    value_bar(drawn, norm, places.value, cax=below)


def _map_errors(axes: Axes, below: Axes, places: Places) -> None:
    percent = percent_of(places.value, places.error)
    norm = error_norm(percent)
    drawn = _draw(axes, places, percent, norm, ERRORS)
    doubtful = places.doubtful & ~np.isnan(percent)
    if places.is_round:
        hatch(axes, *_on_disk(places, doubtful))
    else:
        hatch(axes, doubtful.T, *places.edges)
    axes.set_title(TITLE)
    error_bar(drawn, norm, cax=below)
    if words := gap_words(percent, places.unscored, places.doubtful):
        axes.legend(handles=[hatch_key(words)], loc="lower left", fontsize=14)


def _draw(axes: Axes, places: Places, field: np.ndarray, norm: Normalize, colours: str) -> ScalarMappable:
    """Colour the bins by a field (across, up); where it is nan they are hatched grey."""
    axes.grid(False)
    if places.is_round:
        return _draw_round(axes, places, field, norm, colours)
    across, up = places.edges
    if np.isnan(field).any():
        hatch(axes)
    drawn = axes.pcolorfast(across, up, np.ma.masked_invalid(field.T), norm=norm, cmap=colours)
    axes.set_xlabel(f"{places.axes[0].words}  [{places.axes[0].unit}]")
    axes.set_ylabel(f"{places.axes[1].words}  [{places.axes[1].unit}]")
    for axis, coordinate in zip((axes.xaxis, axes.yaxis), places.axes, strict=True):
        axis.set_major_locator(_ticks(coordinate))
    axes.yaxis.set_inverted(places.axes[1].is_downwards)
    return drawn


def _draw_round(
    axes: Axes, places: Places, field: np.ndarray, norm: Normalize, colours: str
) -> ScalarMappable:
    """Rings and sectors as they lie on the disk."""
    if np.isnan(field).any():
        hatch(axes)
    field, x, y = _on_disk(places, field)
    drawn = axes.pcolormesh(x, y, np.ma.masked_invalid(field), norm=norm, cmap=colours, rasterized=True)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(_ticks(places.axes[0]))
    unit = places.axes[0].unit
    axes.set_xlabel(rf"along $e_u$  [{unit}]")
    axes.set_ylabel(rf"along $e_v$  [{unit}]")
    return drawn


def _on_disk(places: Places, field: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A field with its sectors cut so fine that they look round, and the corners of its bins."""
    radius, turn = places.edges
    times = max(1, math.ceil(np.diff(turn).max() / FINEST))
    fine = np.radians(np.interp(np.arange((len(turn) - 1) * times + 1) / times, np.arange(len(turn)), turn))
    x, y = radius[:, None] * np.cos(fine), radius[:, None] * np.sin(fine)
    return np.repeat(field, times, axis=1), x, y


def _ticks(coordinate: Coordinate) -> MaxNLocator:
    """Round numbers; of an angle thirds and quarters of a turn."""
    return MaxNLocator(5, steps=[1, 2, 5, 10] if coordinate.is_length else [1, 1.5, 3, 4.5, 6, 9, 10])


def _mark_row(axes: Axes, places: Places, row: int) -> None:
    """Where the cut runs."""
    style = {"color": "white", "lw": 1.8, "ls": (0, (4, 3)), "path_effects": outlined(3.0)}
    middle = places.middles(1)[row]
    if not places.is_round:
        axes.axhline(middle, **style)
        return
    for (_, _, angle), colour, mark in zip(_sides(places, row), SIDES, MARKS, strict=False):
        reach, turned = places.edges[0][[0, -1]], math.radians(angle)
        x, y = reach * math.cos(turned), reach * math.sin(turned)
        axes.plot(x, y, **style)
        axes.plot(x[-1], y[-1], mark, ms=13, color=colour, mec="white", clip_on=False)


def _sides(places: Places, row: int) -> list[tuple[int, int, float]]:
    """(row, sign, azimuth [deg]) of the halves of a cut through a disk; the opposite one where there is one."""
    turn, here = places.edges[1], places.middles(1)[row]
    opposite = turn[0] + (here + 180 - turn[0]) % 360
    place = int(np.searchsorted(turn, opposite, side="right")) - 1
    found = [(row, 1, here)]
    return [*found, (place, -1, places.middles(1)[place])] if place < len(turn) - 1 else found


def _draw_cut(
    axes: Axes,
    places: Places,
    row: int | None,
    exact: np.ndarray | None,
    label: str,
    decades: float | None,
) -> None:
    """Points with bars of two standard errors along the first coordinate, on the steps of the exact means; the map's scale."""
    halves = [(row, 1, None)] if row is None or not places.is_round else _sides(places, row)
    for (column, sign, angle), colour, mark in zip(halves, SIDES, MARKS, strict=False):
        pick = ... if column is None else (slice(None), column)
        x, value, error = sign * places.middles(0), places.value[pick], places.error[pick]
        if exact is not None:
            steps, edges = exact[pick][::sign], (sign * places.edges[0])[::sign]
            axes.stairs(
                steps, edges, baseline=None, color=INK, lw=2.0, label="exact, bin mean" if sign > 0 else None
            )
        words = "± 2 standard errors" if angle is None else f"azimuth {angle:.4g}°, ± 2 std. errors"
        draw_points(axes, x, value, error, colour, mark, words)
    first = places.axes[0]
    axes.set_xlabel(f"{first.words}  [{first.unit}]")
    axes.set_ylabel(with_unit(label, places.unit))
    if row is not None and not places.is_round:
        up = places.axes[1]
        axes.set_title(f"cut at {up.words} = {places.middles(1)[row]:.3g} {up.unit}".replace("-", "−"))
    elif row is not None:
        axes.set_title("cut through the middle")
    axes.margins(x=0.02)
    axes.xaxis.set_major_locator(_ticks(first))
    if places.is_round and row is not None:
        axes.xaxis.set_major_formatter(FuncFormatter(lambda radius, _: f"{abs(radius):g}"))
    if decades is not None:
        axes.set_yscale("log", nonpositive="clip")
        norm = value_norm(places.value, places.error, decades)
        axes.set_ylim(norm.vmin, max(1.5 * norm.vmax, axes.get_ylim()[1]))
    elif np.nanmin(places.value) >= 0:
        axes.set_ylim(bottom=0)
    axes.legend(
        loc="upper center",
        bbox_to_anchor=(0.5, -0.17),
        ncol=1 if len(halves) > 1 else 2,
        columnspacing=1.2,
        handletextpad=0.5,
    )


def _arranged(exact: np.ndarray, places: Places, bins: tuple[int, ...]) -> np.ndarray:
    """The exact means of the bins that are drawn.  Raises ValueError for another shape than the detector's."""
    if exact.shape != bins:
        raise ValueError(f"irradiance_map: exact must have the bins {bins}, got {exact.shape}")
    return places.arranged(exact)
