"""Position against velocity as pictures in time: the density in phase space, and how far it is from the exact one."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize, PowerNorm
from matplotlib.figure import Figure

from transport import EstimateArray
from transport.viz.maps import bins_of, draw_field, draw_values
from transport.viz.style import DIVERGING, INK, SEQUENTIAL, figure, outlined, with_unit

FURTHEST = 4.0  # standard errors at the ends of the scale
CERTAIN = 0.1  # relative error up to which a bin's score is drawn: with fewer counts it is not a normal one
LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95)  # contours, of the largest value
FINE = 301  # points of a contour's grid along each axis
PANEL, BAR = (4.7, 4.2), 1.9  # inches


def phase_portraits(
    panels: Mapping[str, EstimateArray],
    path: str | os.PathLike | None = None,
    exact: Mapping[str, np.ndarray] | None = None,
    contours: Mapping[str, Callable[[np.ndarray, np.ndarray], np.ndarray]] | None = None,
    marks: Mapping[str, Mapping[str, tuple[float, float]]] | None = None,
    power: float = 1.0,
    xlabel: str = "position x  [m]",
    ylabel: str = "velocity  [m/s]",
    title: str | None = None,
    note: str | None = None,
) -> Figure:
    """Draw densities in phase space side by side, one per label, all on one scale.

    panels: label -> density with two axes, the first across and the second upwards, such as x and vx.
    exact: label -> means of the exact density over the same bins; below each panel its score z is drawn, grey where the
    error is unknown or above a tenth of the exact value.
    contours: label -> the exact density as a function of both coordinates, for a smooth one.
    marks: label -> {letter: place} of what is followed from panel to panel.
    power: exponent of the colour scale; below 1 it shows what is faint.
    Raises ValueError for no panels, for other numbers of axes, unlike units, and an `exact` that does not fit.
    """
    _check(panels, exact or {})
    rows = 2 if exact else 1
    size = PANEL[0] * len(panels) + BAR, PANEL[1] * rows + 0.8 + (0.7 if title else 0)
    with figure(size, title, note, path) as page:
        axes = page.subplots(rows, len(panels), sharex=True, sharey=True, squeeze=False)
        _draw_densities(page, axes[0], panels, power)
        for each, (label, density) in zip(axes[0], panels.items(), strict=True):
            _draw_over(each, density, (contours or {}).get(label), (marks or {}).get(label, {}))
        if exact:
            _draw_scores(page, axes[1], panels, exact)
        for each in axes.flat:
            each.set(xlabel=xlabel, ylabel=ylabel)
            each.label_outer()
    return page


def _draw_densities(figure: Figure, row: np.ndarray, panels: Mapping, power: float) -> None:
    top = max(np.nanmax(each.value, initial=0.0) for each in panels.values())
    norm = PowerNorm(power, vmin=0.0, vmax=top if top > 0 else 1.0)
    for axes, (label, each) in zip(row, panels.items(), strict=True):
        draw_values(axes, bins_of(each), norm)
        axes.set_title(label)
    _bar(figure, row, norm, SEQUENTIAL, with_unit("density", next(iter(panels.values())).unit))


def _draw_over(axes: Axes, bins: EstimateArray, density: Callable | None, marks: Mapping) -> None:
    """Contours of the exact density, and lettered places."""
    if density is not None:
        across, up = (np.linspace(edges[0], edges[-1], FINE) for edges in bins.coords.values())
        field = density(across, up[:, None])
        levels = [level * field.max() for level in LEVELS]
        axes.contour(across, up, field, levels=levels, colors="white", linewidths=1.2, alpha=0.7)
    for letter, (x, y) in marks.items():
        axes.plot(x, y, "o", mfc="none", mec="white", mew=2.0, ms=9, path_effects=outlined())
        axes.annotate(
            letter, (x, y), (9, -4), textcoords="offset points", color="white", path_effects=outlined()
        )


def _draw_scores(figure: Figure, row: np.ndarray, panels: Mapping, exact: Mapping) -> None:
    norm = Normalize(-FURTHEST, FURTHEST)
    for axes, (label, each) in zip(row, panels.items(), strict=True):
        if label not in exact:
            continue
        z, bins = scores(each, exact[label]), bins_of(each)
        draw_field(axes, bins, bins.arranged(z), norm, DIVERGING)
        known = np.isfinite(z)
        rms = f"rms {np.sqrt(np.mean(z[known] ** 2)):.3f} in {known.sum()} bins" if known.any() else ""
        axes.set_title(rms or "no error known", fontsize=18)
    _bar(figure, row, norm, DIVERGING, "z  [standard errors]", extend="both")


def scores(estimates: EstimateArray, exact: np.ndarray) -> np.ndarray:
    """z of each bin; nan where the error is unknown, or above a tenth of the exact value."""
    certain = estimates.error <= CERTAIN * np.abs(exact)
    return np.where(certain, estimates.z(exact), np.nan)


def _bar(figure: Figure, row: np.ndarray, norm: Normalize, colours: str, label: str, **options: str) -> None:
    bar = figure.colorbar(ScalarMappable(norm, colours), ax=list(row), pad=0.015, aspect=18, **options)
    bar.set_label(label, color=INK)


def _check(panels: Mapping[str, EstimateArray], exact: Mapping[str, np.ndarray]) -> None:
    if not panels:
        raise ValueError("phase_portraits: at least one panel is needed, got none")
    for label, each in panels.items():
        if len(each.dims) != 2:
            raise ValueError(f"phase_portraits: {label!r} must have two axes, got {each.dims}; take one time")
    if len(units := {str(each.unit) for each in panels.values()}) > 1:
        raise ValueError(f"phase_portraits: panels of one unit are needed, got {sorted(units)}")
    for label, values in exact.items():
        if label not in panels or np.shape(values) != panels[label].shape:
            must = f"must be one of {list(panels)}, with its bins"
            raise ValueError(f"phase_portraits: exact {label!r} {must}, got shape {np.shape(values)}")
