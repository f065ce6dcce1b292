"""How every chart looks: type sizes for a lecture hall, one palette, one sequential and one diverging colour map, units in mathtext.

Figures are made without pyplot, so that no state is shared and no display is needed:

>>> with figure((8, 6), "Title", "384 particles, seed 1", path="picture.png") as page:  # doctest: +SKIP
...     page.subplots().plot([0, 1], [0, 1], color=ESTIMATOR_COLOURS["analog"])
"""

from __future__ import annotations

import os
import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogFormatterMathtext, LogLocator, MaxNLocator, NullLocator

from transport.statistics.notation import with_thousands_spaces
from transport.validation import SceneError, short_repr

Mark = tuple[str, str | tuple]  # marker, line style

# Okabe and Ito 2008, "Color universal design": colour-blind eyes tell them apart.  Their yellow is too pale.
BLUE, VERMILLION, GREEN = "#0072B2", "#D55E00", "#009E73"
PURPLE, ORANGE, SKY = "#CC79A7", "#E69F00", "#56B4E9"
PALETTE = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY)
MARKERS = ("o", "s", "^", "D", "v", "P")  # beside the colour, for prints in grey
# The same in all figures: the colour of an estimator, marker and line of a sampling or of a tracking.
ESTIMATOR_COLOURS = {"analog": BLUE, "aimed": VERMILLION, "expected": GREEN, "backward": PURPLE}
SAMPLING_MARKS: dict[str, Mark] = {"random": ("o", "-"), "stratified": ("s", "--"), "sobol": ("^", "-.")}
TRACKING_MARKS: dict[str, Mark] = {
    "analog absorption": ("D", ":"),
    "roulette": ("v", (0, (6, 2, 2, 2, 2, 2))),
    "forced collisions": ("P", (0, (9, 3))),
}
INK, MUTED, PALE = "#1a1a1a", "#6b6b6b", "#d9d9d9"
WITHIN_TWO = "#dcebf5"  # the band of two standard errors
SEQUENTIAL, DIVERGING = "inferno", "RdBu_r"  # colour maps of amounts, and of differences from the middle
HATCHING = "////"

POINTS = {"capsize": 4, "lw": 2.2, "mec": "white", "mew": 0.8}
HOLLOW = {"mfc": "white", "mew": 1.6, "ms": 6}

RESOLUTION = 150  # dots per inch
ONE_AT_A_TIME = threading.RLock()  # the settings of matplotlib are those of all threads
STYLE = {
    "font.size": 18,
    "axes.titlesize": 21,
    "axes.labelsize": 20,
    "axes.titlepad": 14,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.linewidth": 1.2,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.use_mathtext": True,
    "grid.color": "#e6e6e6",
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.edgecolor": "none",
    "legend.framealpha": 0.9,
    "legend.fontsize": 17,
    "lines.markersize": 9,
    "hatch.color": "#8a8a8a",
    "hatch.linewidth": 1.0,
    "savefig.facecolor": "white",
}


@contextmanager
def figure(
    size: tuple[float, float],
    title: str | None = None,
    note: str | None = None,
    path: str | os.PathLike | None = None,
    layout: str = "constrained",
) -> Iterator[Figure]:
    """Make a figure to draw on, and write it at the end if a path is given.

    Parameters
    ----------
    size : tuple of float
        Width and height [inches]; type is 18 points high, so that a panel needs about 6 by 5 inches.
    title, note : str, optional
        Headline, and provenance in small type, such as particles and seed.
    path : str or os.PathLike, optional
        File to write; its folder is made [default: no file, the figure is the caller's].
    layout : str, default "constrained"
        How axes are placed; "none" leaves that to the caller.

    Yields
    ------
    matplotlib.figure.Figure
    """
    with ONE_AT_A_TIME, matplotlib.rc_context(STYLE):
        made = Figure(figsize=size, dpi=RESOLUTION, layout=layout)
        FigureCanvasAgg(made)
        if layout == "constrained":
            made.get_layout_engine().set(w_pad=0.12, h_pad=0.12)
        if title:
            made.suptitle(title, fontsize=24, fontweight="bold")
        if note:
            made.supxlabel(note, fontsize=14, color=MUTED, x=0.99, ha="right")
        yield made
        if path is None:
            made.draw_without_rendering()  # labels take their sizes from these settings when they are first drawn
        else:
            save_figure(made, path)


def save_figure(made: Figure, path: str | os.PathLike) -> None:
    """Write a figure to a file, whose folder is made.  Raises SceneError for an unknown ending."""
    ending, known = Path(path).suffix, made.canvas.get_supported_filetypes()
    if ending and ending[1:].lower() not in known:
        raise SceneError(f"plot: path must end in .png, .pdf or .svg, got {str(path)!r}; rename the file")
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    made.savefig(path)


def check_axes(ax: object) -> None:
    """Raise SceneError for what a picture cannot be drawn in; None is allowed."""
    if ax is None:
        return
    if not isinstance(ax, Axes):
        raise SceneError(f"plot: ax must be Axes of matplotlib, got {short_repr(ax)}; write ax=pyplot.gca()")
    if ax.name != "rectilinear":
        raise SceneError(f"plot: ax must have straight axes, got {ax.name} ones; leave the projection out")


def saved(axes: Axes, path: str | os.PathLike | None) -> Axes:
    """The axes, after their figure has been written if a path is given."""
    if path is not None:
        save_figure(axes.figure, path)
    return axes


def unit_label(unit: object) -> str:
    """The unit in mathtext, such as W m^-2; empty where it is dimensionless.

    unit: a transport.Unit or its text.
    """
    if str(unit) == "1":
        return ""
    text = re.sub(r"([%#&_{}])", r"\\\1", str(unit).replace("\\", ""))  # as they stand in mathtext
    factors = (_power(*factor.partition("^")[::2]) for factor in text.split())
    return r"$\mathrm{" + r"\,".join(factors) + "}$"


def with_unit(words: str, unit: object) -> str:
    """The words with the unit in brackets behind them, or alone for a dimensionless quantity."""
    label = unit_label(unit)
    return f"{words}  [{label}]" if label else words


def look(rank: int) -> tuple[str, str]:
    """Colour and marker of the series of this rank in a figure."""
    return PALETTE[rank % len(PALETTE)], MARKERS[rank % len(MARKERS)]


def tick_log(axis: Axis, decades: float = 2.5) -> None:
    """Label a logarithmic axis at 1, 2, 5, ... in plain numbers over few decades, and at powers of ten over more."""
    low, high = sorted(axis.get_view_interval())
    if not 0 < low < high <= low * 10**decades:
        axis.set_major_locator(LogLocator(10, numticks=12))
        axis.set_major_formatter(LogFormatterMathtext())
        return
    room = axis.get_tick_space() / np.log10(high / low)  # labels per decade
    axis.set_major_locator(
        LogLocator(10, (1, 2, 5) if room >= 3 else (1, 3) if room >= 2 else (1,), numticks=12)
    )
    axis.set_major_formatter(FuncFormatter(lambda value, _: plain(value)))
    axis.set_minor_locator(NullLocator())


def plain(number: float) -> str:
    """A number as a tick says it: 20 000, 2e6, 0.5."""
    if 1e4 <= number < 1e6:
        return with_thousands_spaces(number)
    return f"{number:g}".replace("e+0", "e").replace("e+", "e")


class FewTicks(MaxNLocator):
    """At most five intervals between round numbers, fewer where labels would touch; of an angle at most six parts of a turn."""

    def __init__(self, is_angle: bool = False) -> None:
        super().__init__(5, steps=[1, 1.5, 3, 4.5, 6, 9, 10] if is_angle else [1, 2, 5, 10])
        self.most = 6 if is_angle else 5
        self.size = matplotlib.rcParams["font.size"]

    def __call__(self) -> np.ndarray:
        box, in_points = self.axis.axes.bbox, 72 / self.axis.figure.dpi
        length = box.width / 2.6 if self.axis.axis_name == "x" else box.height / 2.0
        self.set_params(nbins=min(self.most, max(1, int(length * in_points / self.size))))
        return super().__call__()


def outlined(width: float = 3.0) -> list[patheffects.AbstractPathEffect]:
    """A dark rim round white text or lines, so that they are read on any colour of a map."""
    return [patheffects.withStroke(linewidth=width, foreground="#000000")]


def _power(symbol: str, exponent: str) -> str:
    return f"{symbol}^{{{exponent.strip('()')}}}" if exponent else symbol
