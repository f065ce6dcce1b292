"""How every chart looks: type sizes for a lecture hall, the palette of Okabe and Ito, units in mathtext.

Figures are made without pyplot, so that no state is shared and no display is asked for.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import matplotlib
from matplotlib import patheffects
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

# Okabe and Ito 2008, "Color universal design": told apart by colour-blind eyes; their yellow is too pale on white.
BLUE, VERMILLION, GREEN, ORANGE, PURPLE, SKY = (
    "#0072B2",
    "#D55E00",
    "#009E73",
    "#E69F00",
    "#CC79A7",
    "#56B4E9",
)
PALETTE = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY)
MARKERS = ("o", "s", "^", "D", "v", "P")  # beside the colour, for prints in grey
INK, MUTED, PALE = "#1a1a1a", "#6b6b6b", "#d9d9d9"

RESOLUTION = 150  # dots per inch
STYLE = {
    "font.size": 17,
    "axes.titlesize": 19,
    "axes.labelsize": 18,
    "axes.titlepad": 14,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.linewidth": 1.2,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e6e6e6",
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.frameon": False,
    "legend.fontsize": 16,
    "lines.markersize": 8,
    "hatch.color": "#8a8a8a",
    "hatch.linewidth": 1.0,
    "savefig.facecolor": "white",
}


@contextmanager
def figure_at(
    path: str | os.PathLike, size: tuple[float, float], title: str | None, note: str | None
) -> Iterator[Figure]:
    """A figure of this size [inches] to draw on, written to `path` at the end; its folder is made."""
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=size, dpi=RESOLUTION, layout="constrained")
        FigureCanvasAgg(figure)
        figure.get_layout_engine().set(w_pad=0.12, h_pad=0.12)
        if title:
            figure.suptitle(title, fontsize=22, fontweight="bold")
        if note:
            figure.supxlabel(note, fontsize=13, color=MUTED, x=0.99, ha="right")
        yield figure
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path)


def unit_label(unit: object) -> str:
    """The unit in mathtext, such as W m^-2; empty where it is dimensionless.

    unit: a transport.units.Unit or its text.
    """
    factors = [factor.split("^") for factor in str(unit).split()]
    if factors == [["1"]]:
        return ""
    powers = (symbol + (f"^{{{exponent[0].strip('()')}}}" if exponent else "") for symbol, *exponent in factors)
    return rf"$\mathrm{{{chr(92) + ','}}}$".join(f"$\\mathrm{{{power}}}$" for power in powers)


def with_unit(words: str, unit: object) -> str:
    """The words with the unit in brackets behind them, or alone for a dimensionless quantity."""
    label = unit_label(unit)
    return f"{words}  [{label}]" if label else words


def outlined(width: float = 3.0) -> list[patheffects.AbstractPathEffect]:
    """A dark rim round white text or lines, so that they are read on any colour of a map."""
    return [patheffects.withStroke(linewidth=width, foreground="#000000")]
