"""Small pictures in a notebook: drawn by matplotlib, and part of the page as PNG."""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from transport.io.html.elements import escaped, muted
from transport.renderers import function_for
from transport.statistics.estimates import Batches, EstimateArray
from transport.validation import missing_package

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DOTS_PER_INCH = 100
CURVE, MAPS = (4.6, 2.2), (7.0, 2.4)  # inches: width and height of a curve, and of two maps
LEAST_HEIGHT, LARGEST_HEIGHT = 1.7, 3.0  # inches, of maps that are drawn to scale
MARGINS = {"left": 0.7, "right": 0.5, "bottom": 0.45, "top": 0.2}  # inches around the axes
STYLE = {
    "figure.facecolor": "white", "font.size": 8, "axes.titlesize": 8, "legend.fontsize": 7,
    "lines.markersize": 3, "axes.spines.top": False, "axes.spines.right": False, "hatch.linewidth": 0.5,
}  # fmt: skip
MAX_BINS = 1 << 19  # bins of an array, above which no picture is drawn
LOGARITHMIC_RATIO = 1e3  # ratio of the largest to the smallest value, above which the scale is logarithmic
MAX_DECADES = 15  # shown at most
WIDEST_RANGE = 300  # decades, from which on matplotlib's logarithmic scale overflows


def image(draw: Callable[[Figure], object], size: tuple[float, float], title: str) -> str:
    """An element with the picture that `draw(figure)` makes, or a line that says which package it needs.

    size: inches;  title: what the picture shows.
    """
    try:
        import matplotlib
        from matplotlib.figure import Figure

        # Values far apart overflow in matplotlib's scales, where it does no harm.
        with matplotlib.rc_context(STYLE), np.errstate(all="ignore"):
            figure = Figure(size, dpi=DOTS_PER_INCH)
            draw(figure)
            _set_margins(figure)  # matplotlib's own layout takes three times as long
            held = io.BytesIO()
            figure.savefig(held, format="png")
    except ImportError as error:
        if (lack := missing_package(error)) is None:
            raise
        return muted(escaped(f"no picture: {lack}"))
    data = base64.b64encode(held.getvalue()).decode("ascii")
    return f'<img alt="{escaped(title)}" title="{escaped(title)}" src="data:image/png;base64,{data}">'


def array_image(array: EstimateArray, label: str = "estimate") -> str:
    """A curve along one axis, or a map over two beside that of its error; "" if all values are 0."""
    if array.value.size > MAX_BINS:
        return muted(f"no picture of {array.value.size} bins here; .plot() draws it")
    if not np.nan_to_num(array.value, posinf=0.0, neginf=0.0).any():
        return ""
    is_curve = sum(bins > 1 for bins in array.shape) < 2

    def draw_array(figure: Figure) -> None:
        draw = function_for(EstimateArray, "plot")
        panels: list[Axes] = [figure.subplots()] if is_curve else list(figure.subplots(1, 2))
        draw(array, panels[0], _decades(array.value), label)
        if is_curve:
            return
        draw(_relative_errors(array), panels[1], None, "relative standard error [%]")
        if panels[0].get_aspect() != "auto":  # a picture as high as maps to scale are
            height = figure.get_figwidth() / 3 * np.ptp(panels[0].get_ylim()) / np.ptp(panels[0].get_xlim())
            figure.set_figheight(min(max(height + 0.6, LEAST_HEIGHT), LARGEST_HEIGHT))

    title = "bars: ± 2 standard errors" if is_curve else "the estimate, and its relative standard error"
    return image(draw_array, CURVE if is_curve else MAPS, title)


def _set_margins(figure: Figure) -> None:
    width, height = figure.get_size_inches()
    left, right, bottom, top = (MARGINS[side] for side in ("left", "right", "bottom", "top"))
    figure.subplots_adjust(left / width, bottom / height, 1 - right / width, 1 - top / height, wspace=0.35)


def _decades(values: np.ndarray) -> int | None:
    """The decades of a logarithmic scale; None where a linear one shows the values."""
    known = values[np.isfinite(values)]
    positive = known[known > 0]
    if not positive.size or (known < 0).any() or positive.max() < LOGARITHMIC_RATIO * positive.min():
        return None
    decades = math.ceil(math.log10(positive.max()) - math.log10(positive.min()))
    return min(MAX_DECADES, decades) if decades < WIDEST_RANGE else None


def _relative_errors(array: EstimateArray) -> EstimateArray:
    """The relative standard errors [%] as exact numbers over the same bins; nan where none is known."""
    percent = 100 * np.where(np.isfinite(array.relative_error), array.relative_error, np.nan)
    return EstimateArray(
        percent[None], Batches([1]), "1", array.dims, array.coords, exact=True, axis_units=array.axis_units
    )
