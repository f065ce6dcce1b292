"""`.plot()` of a tally and of an EstimateArray: bars along one axis of bins, or a map over two beside that of its error."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.ticker import MaxNLocator

from transport import EstimateArray
from transport.results.tally import Tally
from transport.statistics.axes import axis_places, axis_symbol, axis_unit
from transport.validation import short_repr
from transport.viz.places import shape_of, words_of
from transport.viz.style import BLUE, HOLLOW, STYLE, unit_label, with_unit
from transport.viz.uncertainty import (
    ERRORS,
    TITLE,
    VALUES,
    beyond,
    draw_points,
    error_norm,
    gap_words,
    hatch,
    hatch_key,
    percent_of,
    tick_errors,
    value_norm,
)
from transport.viz.wording import as_it_stands, unit_of_length

LINE = 10.0, 6.4  # inches, of a figure with one axis of bins
WIDE, LOW, HIGH = 15.0, 4.4, 6.4  # inches, of one with two maps: its width, least and greatest height
MAP = 5.2  # inches, width of a map
MAX_DECADES = 300  # of a double
SMALL = {"font.size": 15, "axes.titlesize": 17, "axes.labelsize": 16, "legend.fontsize": 14}  # for a notebook
STRETCHED = 4.0  # most, of the sides of a map that is drawn to scale
NO_WORDS: Mapping[str, str] = MappingProxyType({})


def plot_tally(
    tally: Tally, quantity: str | None = None, axes: Axes | None = None, decades: float | None = None
) -> Axes:
    """Draw a quantity with bins, by default the one that its kind of detector is made for; see `Tally.plot`."""
    name = quantity or _main_quantity(tally)
    array = tally.named(name)
    if not isinstance(array, EstimateArray):
        raise ValueError(f"plot: {name} of {tally.name!r} has no bins, it is {array}")
    title, words = tally.heading, words_of(shape_of(tally))
    return plot_array(array, axes, decades, name.replace("_", " "), title, words)


def plot_array(
    array: EstimateArray,
    axes: Axes | None = None,
    decades: float | None = None,
    label: str = "estimate",
    title: str = "",
    words: Mapping[str, str] = NO_WORDS,
) -> Axes:
    """Draw an array over one or two axes; see `EstimateArray.plot`.  words: of axes, instead of their symbols."""
    if axes is not None and not isinstance(axes, Axes):
        raise ValueError(
            f"plot: axes must be Axes of matplotlib, got {short_repr(axes)}; write axes=pyplot.gca()"
        )
    if decades is not None and not (isinstance(decades, int | float) and 0 < decades <= MAX_DECADES):
        must = f"decades must be above 0 and at most {MAX_DECADES}"
        raise ValueError(f"plot: {must}, got {short_repr(decades)}; leave it out for a linear scale")
    several = [name for name, bins in zip(array.dims, array.shape, strict=True) if bins > 1]
    if len(several) > 2:
        cure = f"index it, or average it as in .mean({several[-1]!r}), to leave one or two"
        raise ValueError(f"plot: the array has {len(several)} axes of bins ({', '.join(several)}); {cure}")
    kept = several or array.dims[:1]
    shown = array[tuple(slice(None) if name in kept else 0 for name in array.dims)]
    along = _suited(shown, words)[0] if len(kept) == 1 else None
    if axes is not None:
        if along:
            _draw_line(axes, shown, along, label, decades)
        else:
            _draw_values(axes, shown, MapLayout.of(shown, words), label, decades, is_alone=True)
        return axes
    from matplotlib import pyplot  # a figure that notebooks and windows show

    with matplotlib.rc_context(STYLE | SMALL):
        if along:
            figure, axes = pyplot.subplots(figsize=LINE, layout="constrained")
            _draw_line(axes, shown, along, label, decades)
        else:
            layout = MapLayout.of(shown, words)
            figure, (axes, beside) = pyplot.subplots(
                1, 2, figsize=(WIDE, layout.height), layout="constrained"
            )
            _draw_values(axes, shown, layout, label, decades)
            _draw_errors(beside, shown, layout)
        if title:
            figure.suptitle(as_it_stands(title), fontsize=17)
    return axes


def _main_quantity(tally: Tally) -> str:
    """The first quantity in which findings about bins are searched, or else the first one with bins."""
    for name, _ in tally.binned():
        return name
    for name in tally.available:
        if isinstance(getattr(tally, name), EstimateArray):
            return name
    cure = "give the detector bins, such as positions=, directions=, cells= or times=, or print it"
    raise ValueError(f"plot: {tally.title} has no quantity with bins; {cure}")


# ---- Axes: their bins in units that suit, and their labels.


class Along(NamedTuple):
    """An axis of a picture: name, edges of bins (or instants) in its unit, words with the unit, the unit alone."""

    name: str
    edges: np.ndarray
    label: str
    unit: str

    @property
    def ticks(self) -> MaxNLocator:
        """Round numbers; of an angle thirds and quarters of a turn."""
        return MaxNLocator(5, steps=[1, 1.5, 3, 4.5, 6, 9, 10] if self.unit == "°" else [1, 2, 5, 10])


def _suited(array: EstimateArray, words: Mapping[str, str]) -> list[Along]:
    """The axes with angles in degrees, and all lengths in the unit of the longest."""
    units = {name: axis_unit(name, array.axis_units) for name in array.dims}
    lengths = [np.abs(array.coords[name]).max() for name in array.dims if units[name] == "m"]
    metre, length = unit_of_length(max(lengths, default=1.0))
    suited = {"m": (1 / metre, length), "rad": (180 / math.pi, "°")}
    found = []
    for name, unit in units.items():
        scale, unit = suited.get(unit, (1.0, unit_label(unit or "1")))
        label = words.get(name, axis_symbol(name)) + (f" [{unit}]" if unit else "")
        found.append(Along(name, array.coords[name] * scale, label, unit))
    return found


# ---- One axis.


def _draw_line(axes: Axes, array: EstimateArray, along: Along, label: str, decades: float | None) -> None:
    """Steps over the bins, and points with bars of two standard errors; hollow where these are not sound."""
    value, error, doubtful = array.value, array.error, array.is_doubtful & np.isfinite(array.error)
    places = axis_places(along.edges, len(value))
    if len(places) > 1:
        axes.stairs(value, along.edges, baseline=None, color=BLUE, lw=1.2, alpha=0.6)
    draw_points(axes, places[""], value, error, BLUE, "o", "± 2 standard errors")
    if doubtful.any():
        axes.plot(places[""][doubtful], value[doubtful], "s", mec=BLUE, label="doubtful", zorder=5, **HOLLOW)
    axes.set(xlabel=along.label, ylabel=with_unit(label, array.unit))
    axes.margins(x=0.02)
    axes.xaxis.set_major_locator(along.ticks)
    low, high = axes.get_ylim()
    if decades is not None:
        norm = value_norm(value, error, decades)
        axes.set_yscale("log", nonpositive="clip")
        axes.set_ylim(norm.vmin, max(1.5 * norm.vmax, high))
    elif np.nanmin(value, initial=0.0) >= 0 and low < 0.7 * high:
        axes.set_ylim(bottom=0)
    axes.legend()


# ---- Two axes: those of direction and of an image stand upright, others lie.


VERTICAL_AXES = ("mu", "theta", "v")  # vertical axes if they come first; all others are horizontal
TOP_DOWN_AXES = ("theta",)  # axes with their small end on top: the zenith
POLAR_AXES = ("mu", "theta")  # of a map of directions beside an azimuth, which grows to the left


def has_azimuth_to_the_left(names: tuple[str, str]) -> bool:
    """Return whether it is a map of directions, by polar angle and azimuth."""
    return names[0] in POLAR_AXES and names[1] == "phi"


def azimuth_note(names: tuple[str, str]) -> str:
    """Return what follows the label of the azimuth of a map with the zenith on top.

    With bins of mu it is empty: they may be directions of flight, as in a volume.
    """
    return ", seen from inside" if names == ("theta", "phi") else ""


class MapLayout(NamedTuple):
    """How a map lies: its axes, whether the array is transposed, and whether both axes are drawn to one scale."""

    up: Along
    across: Along
    is_transposed: bool
    is_to_scale: bool

    @classmethod
    def of(cls, array: EstimateArray, words: Mapping[str, str]) -> MapLayout:
        """Of an array with two axes."""
        first, second = (
            each._replace(edges=_bounds(each.edges, bins))
            for each, bins in zip(_suited(array, words), array.shape, strict=True)
        )
        is_transposed = first.name not in VERTICAL_AXES
        up, across = (second, first) if is_transposed else (first, second)
        stretch = np.ptp(up.edges) / np.ptp(across.edges)
        return cls(
            up, across, is_transposed, up.unit == across.unit and 1 / STRETCHED <= stretch <= STRETCHED
        )

    @property
    def height(self) -> float:
        """Height of a figure of two such maps [inches]."""
        stretch = np.ptp(self.up.edges) / np.ptp(self.across.edges)
        return min(max(MAP * stretch + 1.7, LOW), HIGH) if self.is_to_scale else HIGH

    def arranged(self, field: np.ndarray) -> np.ndarray:
        """A field of the array as (up, across)."""
        return field.T if self.is_transposed else field

    def draw(self, axes: Axes, field: np.ndarray, norm: Normalize, colours: str) -> ScalarMappable:
        """Colour the bins by a field (up, across); hatch them in grey where it is nan."""
        up, across = self.up, self.across
        axes.grid(False)
        if np.isnan(field).any():
            hatch(axes)
        drawn = axes.pcolorfast(across.edges, up.edges, np.ma.masked_invalid(field), norm=norm, cmap=colours)
        names = up.name, across.name
        axes.set(xlabel=across.label + azimuth_note(names), ylabel=up.label)
        axes.xaxis.set_inverted(has_azimuth_to_the_left(names))
        axes.yaxis.set_inverted(up.name in TOP_DOWN_AXES)
        axes.xaxis.set_major_locator(across.ticks)
        axes.yaxis.set_major_locator(up.ticks)
        if self.is_to_scale:
            axes.set_aspect("equal")
        return drawn

    def hatch(self, axes: Axes, doubtful: np.ndarray) -> None:
        """Hatch bins (up, across) above their colours."""
        hatch(axes, doubtful, self.across.edges, self.up.edges)


def _bounds(edges: np.ndarray, bins: int) -> np.ndarray:
    """Edges of bins, or of instants the middles between them."""
    if len(edges) > bins:
        return edges
    middles = 0.5 * (edges[1:] + edges[:-1])
    return np.concatenate([[1.5 * edges[0] - 0.5 * edges[1]], middles, [1.5 * edges[-1] - 0.5 * edges[-2]]])


def _draw_values(
    axes: Axes,
    array: EstimateArray,
    layout: MapLayout,
    label: str,
    decades: float | None,
    is_alone: bool = False,
) -> None:
    """The values; what lies below a logarithmic scale has its darkest colour.  is_alone: no map of errors is beside it."""
    value = layout.arranged(array.value)
    norm = value_norm(array.value, array.error, decades)
    field = value if decades is None else np.where(value >= 0, np.maximum(value, norm.vmin), np.nan)
    drawn = layout.draw(axes, field, norm, VALUES)
    if is_alone:
        layout.hatch(axes, layout.arranged(array.is_doubtful) & np.isfinite(field))
    bar = axes.figure.colorbar(drawn, ax=axes, extend=beyond(value, norm))
    bar.set_label(with_unit(label, array.unit))


def _draw_errors(axes: Axes, array: EstimateArray, layout: MapLayout) -> None:
    percent, doubtful = percent_of(array.value, array.error), array.is_doubtful
    norm = error_norm(percent)
    bar = axes.figure.colorbar(layout.draw(axes, layout.arranged(percent), norm, ERRORS), ax=axes)
    layout.hatch(axes, layout.arranged(doubtful & ~np.isnan(percent)))
    bar.set_label(TITLE)
    tick_errors(bar.ax.yaxis, norm)
    if words := gap_words(percent, array.reason == "no score", doubtful):
        axes.legend(handles=[hatch_key(words)], loc="lower right", bbox_to_anchor=(1, 1), borderpad=0)
