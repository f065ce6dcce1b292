"""`.plot()` of a tally and of an EstimateArray: a curve along one axis of bins, or a map over two beside that of its error."""

from __future__ import annotations

import matplotlib
from matplotlib.axes import Axes

from transport import EstimateArray
from transport.results.tally import Tally
from transport.validation import short_repr
from transport.viz.maps import bins_of, is_line, main_quantity, plot_map, suited_size
from transport.viz.style import STYLE
from transport.viz.wording import as_it_stands

LINE = 10.0, 6.4  # inches, of a figure with one axis of bins
SMALL = {"font.size": 15, "axes.titlesize": 17, "axes.labelsize": 16, "legend.fontsize": 14}  # for a notebook


def plot_tally(
    tally: Tally, quantity: str | None = None, ax: Axes | None = None, decades: float | None = None
) -> Axes:
    """Draw a quantity with bins, by default the one that its kind of detector is made for; see `Tally.plot`."""
    return _plot(tally, ax, decades, quantity or main_quantity(tally), None, tally.heading)


def plot_array(
    array: EstimateArray, ax: Axes | None = None, decades: float | None = None, label: str = "estimate"
) -> Axes:
    """Draw an array over one or two axes; see `EstimateArray.plot`."""
    return _plot(array, ax, decades, None, label, "")


def _plot(
    data: Tally | EstimateArray,
    ax: Axes | None,
    decades: float | None,
    quantity: str | None,
    label: str | None,
    title: str,
) -> Axes:
    if ax is not None and not isinstance(ax, Axes):
        raise ValueError(f"plot: ax must be Axes of matplotlib, got {short_repr(ax)}; write ax=pyplot.gca()")
    what = {"quantity": quantity, "label": label}
    if ax is not None:
        return plot_map(data, ax=ax, decades=decades, **what)
    from matplotlib import pyplot  # a figure that notebooks and windows show

    with matplotlib.rc_context(STYLE | SMALL):
        if is_line(data, quantity):
            figure, where = pyplot.subplots(figsize=LINE, layout="constrained")
        else:
            size = suited_size(bins_of(data, **what))
            figure, where = pyplot.subplots(1, 2, figsize=size, layout="constrained")
        drawn = plot_map(data, ax=where, decades=decades, **what)
        if title:
            figure.suptitle(as_it_stands(title), fontsize=17)
    return drawn
