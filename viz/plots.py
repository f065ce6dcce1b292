"""`.plot()` of a run, a tally and an EstimateArray: a curve along one axis of bins, or a map over two beside that of its error."""

from __future__ import annotations

import math
import os

import matplotlib
import numpy as np
from matplotlib.axes import Axes

from transport import EstimateArray, Result
from transport.results.phase_space import SnapshotReading
from transport.results.tally import Tally
from transport.statistics.axes import axis_unit, axis_words
from transport.statistics.notation import with_thousands_spaces
from transport.validation import join_names
from transport.viz.maps import bins_of, is_line, main_quantity, plot_map, suited_size
from transport.viz.power_flow import End, ends_of
from transport.viz.style import BLUE, MUTED, STYLE, check_axes, saved, with_unit
from transport.viz.wording import as_it_stands

LINE = 10.0, 6.4  # inches, of a figure with one axis of bins
PANEL, MOST_PANELS = (6.0, 5.0), 8  # inches, and number of panels, of the figure of a whole run
SMALL = {"font.size": 15, "axes.titlesize": 17, "axes.labelsize": 16, "legend.fontsize": 14}  # for a notebook


def plot_tally(
    tally: Tally,
    quantity: str | None = None,
    ax: Axes | None = None,
    decades: float | None = None,
    path: str | os.PathLike | None = None,
    **options: object,
) -> Axes:
    """Draw a quantity with bins, by default the one that its kind of detector is made for; see `Tally.plot`."""
    if isinstance(tally, SnapshotReading):
        unused = {"quantity": quantity, "decades": decades, **options}
        given = [name for name, value in unused.items() if value is not None and value is not False]
        if given:
            cure = "leave it out; plot() draws positions against velocities"
            raise ValueError(f"plot: {tally.title} has no bins and takes no {join_names(given)}; {cure}")
        return saved(_plot_sample(tally, ax), path)
    chosen = {"quantity": quantity or main_quantity(tally), **options}
    return saved(_plot(tally, ax, decades, tally.heading, chosen), path)


def plot_array(
    array: EstimateArray,
    ax: Axes | None = None,
    decades: float | None = None,
    label: str = "estimate",
    path: str | os.PathLike | None = None,
    **options: object,
) -> Axes:
    """Draw an array over one or two axes; see `EstimateArray.plot`."""
    return saved(_plot(array, ax, decades, "", {"label": label, **options}), path)


def _plot(
    data: Tally | EstimateArray,
    ax: Axes | None,
    decades: float | None,
    title: str,
    options: dict[str, object],
) -> Axes:
    check_axes(ax)
    if ax is not None:
        if options.get("cut", False) is not False:
            cure = "leave ax out, or give plot_map of transport.viz three Axes"
            raise ValueError(f"plot: ax has no room for a cut beside the map; {cure}")
        return plot_map(data, ax=ax, decades=decades, **options)
    from matplotlib import pyplot  # a figure that notebooks and windows show

    chosen = {name: options[name] for name in ("quantity", "label") if name in options}
    with matplotlib.rc_context(STYLE | SMALL):
        if is_line(data, options.get("quantity")):
            figure, where = pyplot.subplots(figsize=LINE, layout="constrained")
        else:
            has_cut = options.get("cut", False) is not False
            size = suited_size(bins_of(data, **chosen), has_cut)
            figure, where = pyplot.subplots(1, 2 + has_cut, figsize=size, layout="constrained")
        drawn = plot_map(data, ax=where, decades=decades, **options)
        if title:
            figure.suptitle(as_it_stands(title), fontsize=17)
    return drawn


def _plot_sample(sample: SnapshotReading, ax: Axes | None) -> Axes:
    """Particles of a snapshot in phase space: the coordinate that spreads most, and its velocity."""
    check_axes(ax)
    spread = np.ptp(sample.positions, axis=0) if len(sample) else np.zeros(3)
    axis = int(np.argmax(spread))
    size = float(np.clip(60 / math.sqrt(max(len(sample), 1)), 3, 12))  # few are seen, many not blurred
    with matplotlib.rc_context(STYLE | SMALL):
        if ax is None:
            from matplotlib import pyplot

            _, ax = pyplot.subplots(figsize=LINE, layout="constrained")
        ax.plot(
            sample.positions[:, axis], sample.velocities[:, axis], ".", ms=size, mew=0, color=BLUE, alpha=0.5
        )
        along, velocity = "xyz"[axis], f"v{'xyz'[axis]}"
        labels = [with_unit(axis_words(name), axis_unit(name, {})) for name in (along, velocity)]
        ax.set(xlabel=labels[0], ylabel=labels[1])
        ax.set_title(as_it_stands(sample.heading))
    return ax


# ---- A whole run


def plot_result(result: Result, path: str | os.PathLike | None = None) -> list[Axes]:
    """Draw what each detector has bins of, single numbers, and where the power went; see `Result.plot`."""
    from matplotlib import pyplot

    binned = [reading for name in result if _has_bins(reading := result[name])]
    shown = [each for each in binned if _is_drawn(each)][:MOST_PANELS]
    left = [each for each in binned if each not in shown]
    columns = min(max(len(shown), 1), 3)
    rows = -(-len(shown) // columns)
    ends = ends_of(result)[::-1]
    heights = [PANEL[1] * rows, 1.6 + 0.42 * len(ends)]
    with matplotlib.rc_context(STYLE | SMALL):
        size = (max(PANEL[0] * columns, 9.0), sum(heights))
        figure = pyplot.figure(figsize=size, layout="constrained")
        grid = figure.add_gridspec(2, 1, height_ratios=[max(each, 1e-3) for each in heights])
        places = grid[0].subgridspec(max(rows, 1), columns)
        panels = [figure.add_subplot(places[divmod(k, columns)]) for k in range(len(shown))]
        for ax, reading in zip(panels, shown, strict=False):
            if isinstance(reading, SnapshotReading):
                _plot_sample(reading, ax)
            else:
                plot_map(reading, ax=ax)
            ax.set_title(as_it_stands(reading.name))
        balance = figure.add_subplot(grid[1].subgridspec(1, 1)[0])
        _plot_balance(result, ends, balance)
        note = f"{with_thousands_spaces(result.particles)} particles, {result.plan.method.title}"
        for why, those in (
            ("more than two axes of bins", [each for each in left if not _is_drawn(each)]),
            (f"the picture has {MOST_PANELS} panels", [each for each in left if _is_drawn(each)]),
        ):
            note += f"; not drawn: {join_names([each.name for each in those], 6)} ({why})" if those else ""
        figure.supxlabel(as_it_stands(note), fontsize=13, color=MUTED, x=0.99, ha="right")
    return [*panels, saved(balance, path)]


def _has_bins(reading: Tally) -> bool:
    try:
        return isinstance(reading, SnapshotReading) or bool(main_quantity(reading))
    except ValueError:
        return False


def _is_drawn(reading: Tally) -> bool:
    """Whether what it has bins of has one or two axes of them."""
    if isinstance(reading, SnapshotReading):
        return True
    try:
        return is_line(reading, main_quantity(reading)) or bool(bins_of(reading, main_quantity(reading)))
    except ValueError:
        return False


def _plot_balance(result: Result, ends: list[End], ax: Axes) -> None:
    """Bars of where the power, or the particles, of a run went, with two standard errors."""
    values = np.array([end.amount.value for end in ends])
    errors = np.array([0.0 if np.isnan(end.amount.error) else 2 * end.amount.error for end in ends])
    ax.barh(range(len(ends)), values, xerr=errors, color=[end.colour for end in ends], alpha=0.7, capsize=4)
    ax.set_yticks(range(len(ends)), [end.words for end in ends])
    emitted = result.ledger["emitted"]
    if result.plan.adjoint is None:
        title = f"energy balance of {emitted.value:.4g} {emitted.unit}".removesuffix(" 1")
        label = with_unit("where it went", emitted.unit)
    else:
        title, label = "histories, traced backwards", "share that ended there"
    ax.set_xlabel(label)
    ax.set_title(as_it_stands(title))
    ax.grid(visible=False, axis="y")
