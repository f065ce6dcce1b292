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
MAX_DECADES = 300  # of a double
SMALL = {"font.size": 15, "axes.titlesize": 17, "axes.labelsize": 16, "legend.fontsize": 14}  # for a notebook


def plot_tally(
    tally: Tally, quantity: str | None = None, axes: Axes | None = None, decades: float | None = None
) -> Axes:
    """Draw a quantity with bins, by default the one that its kind of detector is made for; see `Tally.plot`."""
    return _plot(tally, axes, decades, quantity or main_quantity(tally), None, tally.heading)


def plot_array(
    array: EstimateArray, axes: Axes | None = None, decades: float | None = None, label: str = "estimate"
) -> Axes:
    """Draw an array over one or two axes; see `EstimateArray.plot`."""
    return _plot(array, axes, decades, None, label, "")


def _plot(
    data: Tally | EstimateArray,
    axes: Axes | None,
    decades: float | None,
    quantity: str | None,
    label: str | None,
    title: str,
) -> Axes:
    if axes is not None and not isinstance(axes, Axes):
        raise ValueError(
            f"plot: axes must be Axes of matplotlib, got {short_repr(axes)}; write axes=pyplot.gca()"
        )
    if decades is not None and not (isinstance(decades, int | float) and 0 < decades <= MAX_DECADES):
        must = f"decades must be above 0 and at most {MAX_DECADES}"
        raise ValueError(f"plot: {must}, got {short_repr(decades)}; leave it out for a linear scale")
    what = {"quantity": quantity, "label": label}
    if axes is not None:
        return plot_map(data, ax=axes, decades=decades, **what)
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
