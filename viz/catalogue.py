"""Several quantities along one coordinate, each an exact curve with points on it, and all residuals below."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from transport import Estimate, EstimateArray
from transport.viz.profiles import FURTHEST, in_standard_errors
from transport.viz.style import INK, MARKERS, PALETTE, POINTS, WITHIN_TWO, figure_at, with_unit

FINE = 300  # points of an exact curve


class Entry(NamedTuple):
    """Estimates along x: places (n,), or edges (n + 1,) of bins, and the exact value as a function of one x.

    expected: (n,) exact values for the residuals, where bins hold something else than the curve at their
    middles.
    """

    x: Sequence[float]
    estimates: EstimateArray | Sequence[Estimate]
    exact: Callable[[float], float]
    expected: Sequence[float] | None = None

    @property
    def places(self) -> np.ndarray:
        """Where the points are drawn: the places, or the middles of the bins, (n,)."""
        x = np.asarray(self.x, dtype=float)
        return x if len(x) == len(self.estimates) else (x[1:] + x[:-1]) / 2

    def of_all(self, name: str) -> np.ndarray:
        """An attribute of all estimates, (n,)."""
        return np.array([getattr(estimate, name) for estimate in self.estimates], dtype=float)


def catalogue(
    entries: Mapping[str, Entry],
    path: str | os.PathLike,
    xlabel: str,
    ylabel: str,
    title: str | None = None,
    note: str | None = None,
    log_x: bool = False,
    log_y: bool = False,
    span: tuple[float, float] | None = None,
) -> str | os.PathLike:
    """Draw each entry with bars of two standard errors on its exact curve, residuals below; returns the path.

    ylabel: without unit, it is added.  span: of the curves along x, that of all entries where it is left out.
    Raises ValueError for no entries, for lengths that do not fit and for unlike units.
    """
    unit = _checked_unit(entries)
    ends = np.concatenate([np.asarray(entry.x, dtype=float) for entry in entries.values()])
    low, high = span or (ends.min(), ends.max())
    fine = (np.geomspace if log_x else np.linspace)(low, high, FINE)
    with figure_at(path, (16, 10.5), title, note) as figure:
        main, lower = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
        main.set_xscale("log" if log_x else "linear")
        main.set_yscale("log" if log_y else "linear")
        main.plot([], [], color=INK, lw=2.2, label="lines: exact")
        for place, (label, entry) in enumerate(entries.items()):
            colour, marker = _look(place)
            main.plot(fine, [float(entry.exact(x)) for x in fine], lw=2.2, color=colour, zorder=2)
            _draw_points(main, entry, label, colour, marker)
        _show_zero(main)
        _draw_residuals(lower, entries.values())
        main.set_ylabel(with_unit(ylabel, unit))
        lower.set_xlabel(xlabel)
        main.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), handletextpad=0.5)
        figure.align_ylabels()
    return path


def _show_zero(axes: Axes) -> None:
    """A linear scale shows its zero unless the values lie far from it."""
    low, high = axes.get_ylim()
    if axes.get_yscale() == "linear" and 0 < low < 0.7 * high:
        axes.set_ylim(bottom=0)


def _look(place: int) -> tuple[str, str]:
    return PALETTE[place % len(PALETTE)], MARKERS[place % len(MARKERS)]


def _checked_unit(entries: Mapping[str, Entry]) -> str:
    if not entries:
        raise ValueError("catalogue: at least one entry is needed, got none")
    for label, entry in entries.items():
        if len(entry.x) - len(entry.estimates) not in (0, 1):
            got = f"{len(entry.x)} x and {len(entry.estimates)} estimates"
            raise ValueError(f"catalogue: {label!r} must have a place or a bin an estimate, got {got}")
    units = {str(estimate.unit) for entry in entries.values() for estimate in entry.estimates}
    if len(units) != 1:
        raise ValueError(f"catalogue: estimates of one unit are needed, got {sorted(units)}")
    return units.pop()


def _draw_points(axes: Axes, entry: Entry, label: str, colour: str, marker: str) -> None:
    value, error = entry.of_all("value"), entry.of_all("error")
    bars = 2 * np.where(np.isfinite(error), error, 0.0)
    if axes.get_yscale() == "log":
        bars = np.minimum(bars, 0.9 * value)
    look = POINTS | {"color": colour, "marker": marker, "ms": 11}
    axes.errorbar(entry.places, value, bars, ls="none", label=label, zorder=4, **look)


def _draw_residuals(axes: Axes, entries: Iterable[Entry]) -> None:
    axes.axhspan(-2, 2, color=WITHIN_TWO, lw=0)
    axes.axhline(0, color=INK, lw=1.6)
    reach = 3.4
    for place, entry in enumerate(entries):
        exact = [entry.exact(x) for x in entry.places] if entry.expected is None else entry.expected
        residual = in_standard_errors(entry.of_all("value"), entry.of_all("error"), np.asarray(exact))
        shown = np.clip(residual, -FURTHEST, FURTHEST)
        reach = max(reach, 1.15 * np.abs(shown[np.isfinite(shown)]).max(initial=0.0))
        colour, marker = _look(place)
        axes.plot(entry.places, shown, ls="none", color=colour, marker=marker, ms=9, mec="white", mew=0.8)
    axes.set_ylim(-reach, reach)
    axes.yaxis.set_major_locator(MaxNLocator(5, integer=True, steps=[1, 2, 4, 5, 10]))
    axes.set_ylabel("residual\n[std. errors]")
