"""Maps: a quantity over two axes of bins, beside it its relative standard error, and a cut where it is asked for.

>>> plot_map(result["floor"], "floor.png", decades=2, cut=True, title="Light on the floor")  # doctest: +SKIP
>>> plot_map(result["sky"], "sky.png", exact=law, cut=0.0)  # doctest: +SKIP

Several maps on one scale, their errors below; or panels of a figure of one's own:

>>> plot_maps({"at first": density[0], "later": density[1]}, "times.png")  # doctest: +SKIP
>>> norm = value_norm([bins_of(each) for each in seen], decades=3)  # doctest: +SKIP
>>> for axes, each in zip(row, seen):  # doctest: +SKIP
...     plot_map(each, ax=axes, norm=norm, bar=False)
>>> page.colorbar(ScalarMappable(norm, SEQUENTIAL), ax=row)  # doctest: +SKIP
"""

from __future__ import annotations

import math
import os
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from numbers import Real
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Circle, PathPatch
from matplotlib.patches import Rectangle as RectanglePatch
from matplotlib.path import Path
from matplotlib.ticker import FuncFormatter, MaxNLocator

from transport import EstimateArray
from transport.geometry.flat import Disk
from transport.results.backward import ViewReading
from transport.results.tally import Tally
from transport.results.volumes import VolumeReading
from transport.scene.cameras import CYLINDER, FACES
from transport.statistics.axes import (
    AXES_OF_PLACES,
    POLAR_AXES,
    axis_coordinate,
    axis_symbol,
    axis_unit,
    axis_words,
)
from transport.validation import short_repr
from transport.viz.curves import TRUSTED, Series, plot_curves
from transport.viz.directions import POLAR_ANGLE, Radiance, direction_bins, polar_series
from transport.viz.style import (
    HATCHING,
    INK,
    MUTED,
    PALE,
    SEQUENTIAL,
    FewTicks,
    figure,
    look,
    outlined,
    tick_log,
    unit_label,
    with_unit,
)
from transport.viz.wording import unit_of_length

ERROR_LABEL = "relative standard error  [%]"
ERROR_DECADES = 2.0  # at most: what is nearly exact does not stretch the scale
WORST = 100.0  # %, at the top of the scale of errors at the most
WIDE = 5.0  # times the least error, from which on its scale is logarithmic
PANEL, CUT = 5.0, 6.2  # inches: the longer side of a map, the width of a cut with its labels
BESIDE = 1.9  # inches, of a map's labels and its colour bar
SWATCH = 0.4  # inches, of what explains the hatching
LOW = 4.0  # inches, of a map whose bar has a small label
STRETCHED = 4.0  # most, of the sides of a map that is drawn to scale
FINEST = 1.5  # deg, of an arc that is drawn as one cell
MOST_COLUMNS = 6  # maps side by side
MAX_DECADES = 300  # of a double
LABELLED = math.radians(56)  # azimuth at which rings carry their angle, between the spokes
COMPASS = ((0, "left", "center"), (90, "center", "bottom"), (180, "right", "center"), (270, "center", "top"))

# How a map lies.
FRAMES = FLAT, DISK, PLAN, SKY, IMAGE, ROUND, UNROLLED, UNFOLDED = (
    "flat", "disk", "plan", "sky", "image", "round image", "cylinder", "cube",
)  # fmt: skip
IMAGES = (IMAGE, ROUND, UNFOLDED)
# Row, column and half turn of each face of an unfolded cube, seen from inside: +z above and -z below +y.
CROSS = {
    "+x": (1, 2, False), "-x": (1, 0, False), "+y": (1, 1, False), "-y": (1, 3, False),
    "+z": (2, 1, True), "-z": (0, 1, False),
}  # fmt: skip
UPRIGHT = (*POLAR_AXES, "v")  # axes that stand upright if they come first
CELLS = ("z", "y", "x")  # axes of which the middle bin is taken, in this order
POLES = {"local": "in front", "world": "+z"}  # where θ = 0 is, by the frame of a detector's directions
NO_BINS: Mapping[str, int] = MappingProxyType({})

Data = Tally | EstimateArray


def plot_map(
    data: Data,
    path: str | os.PathLike | None = None,
    *,
    ax: Axes | Sequence[Axes] | None = None,
    quantity: str | None = None,
    at: Mapping[str, int] = NO_BINS,
    label: str | None = None,
    unit: str | None = None,
    exact: np.ndarray | Radiance | None = None,
    cut: bool | float = False,
    decades: float | None = None,
    norm: Normalize | None = None,
    frame: str | None = None,
    bar: bool = True,
    title: str | None = None,
    note: str | None = None,
) -> Figure | Axes:
    """Draw a quantity over two axes of bins, its relative standard error [%] beside it, and a cut.

    Parameters
    ----------
    data : Tally or EstimateArray
        `result["name"]` of a detector with bins, or one of its quantities.  Bins along one axis are drawn as a curve,
        two axes at several instants as a column of maps per instant.
    path : str or os.PathLike, optional
        File to write [default: none].
    ax : Axes, or sequence of them, optional
        Where to draw: the values alone; values and errors; or values, errors and cut [default: a new figure].
    quantity : str, optional
        Of a tally, such as "fluence_rate" [default: the one that its kind of detector is made for].
    at : mapping of str to int, optional
        Bin to take along an axis, such as {"time": 3} [default: of three axes of cells the middle of one, of a light
        field the middle of u and v].
    label : str, optional
        Name of the quantity; the unit is added [default: `quantity`, or "estimate" of an array].
    unit : str, optional
        Unit to write in place of that of the quantity; values stay as they are.
    exact : ndarray or callable, optional
        For the cut: means over the bins, shaped as the quantity; or of a plan of directions the exact radiance, a function
        of arrays theta and phi [rad], which may jump.
    cut : bool or float, default False
        Whether there is a cut, through the brightest row of bins; or where it runs: the coordinate [SI unit] of a row
        of bins, or the azimuth [rad] on a disk and of directions, where it goes on at the opposite azimuth.
    decades : float, optional
        Range of a logarithmic scale, below the greatest value [default: a linear scale].
    norm : Normalize, optional
        The scale, in place of `decades`, such as one that several panels share.
    frame : str, optional
        How the map lies: "flat", "disk", "plan" (a hemisphere of directions), "sky" (all directions, seen from
        inside), "image", "round image" (nothing outside of its rim), "cylinder" (a sky of rows of equal height in
        cos θ) or "cube" (six images, unfolded) [default: by the axes and the detector].
    bar : bool, default True
        Whether there is a colour bar.
    title, note : str, optional
        Of a new figure.

    Returns
    -------
    Figure or Axes
        The new figure, or the axes of the values if `ax` is given.

    Raises
    ------
    ValueError
        For a quantity without bins, more than two axes of bins, `exact` of another shape, a cut outside, and for what is of
        a new figure together with `ax`.

    Notes
    -----
    Bins without a known error are hatched on grey in the map of errors, those with a doubtful one above their colour
    (where there is no map of errors, in the map of values).
    In a plan of directions azimuth grows anticlockwise: it is seen from θ = 0, which is in front of the
    detector's side or, in the world's frame, at +z.  A sky is seen from inside, so that azimuth grows to the left.
    The brightest row is that of the greatest value less its standard error, so that one large score of a rare
    particle does not decide; of rows within two standard errors of it the one with the greatest mean is taken, of
    equal ones the one nearest the middle is taken, of equal azimuths the first.
    """
    if ax is not None and (path is not None or title or note):
        raise ValueError("plot_map: path, title and note are of a new figure; leave them out with ax=")
    _check_words("unit", unit)
    if not isinstance(cut, Real) or cut != cut:
        what = "True, for the brightest row of bins, or the coordinate of a row"
        raise ValueError(f"plot: cut must be {what}, got {short_repr(cut)}")
    chosen = _chosen(data, quantity, at, label, frame)
    if chosen.listed:
        if ax is not None or exact is not None or cut is not False or norm is not None:
            where = f"at={{{chosen.listed!r}: 0}}"
            raise ValueError(
                f"plot_map: several maps have no ax, exact, cut or norm; choose one with {where}"
            )
        if unit is not None:
            raise ValueError("plot_map: several maps have no unit; choose one with at=")
        panels = _by_instants(chosen.array, chosen.listed)
        return plot_maps(panels, path, label=chosen.label, decades=decades, title=title, note=note)
    if chosen.is_line:
        if cut is not False or norm is not None:
            given = "cut" if cut is not False else "norm"
            raise ValueError(f"plot: one axis of bins is drawn as a curve without {given}; leave {given} out")
        where = ax if ax is None or isinstance(ax, Axes) else ax[0]
        return _plot_line(chosen, path, where, exact, decades, title, note, unit)
    bins = _arranged(chosen)
    if unit is not None:
        bins = replace(bins, unit=unit)
    if exact is not None and not callable(exact):
        exact = bins.arranged(chosen.taken(np.asarray(exact, dtype=float)))
    if ax is not None:
        axes = [ax] if isinstance(ax, Axes) else list(np.ravel(ax))
        if not 1 <= len(axes) <= 3 or not all(isinstance(each, Axes) for each in axes):
            raise ValueError(f"plot_map: ax must be one to three Axes of matplotlib, got {short_repr(ax)}")
        _draw(axes, bins, exact, cut, decades, norm, bar)
        return axes[0]
    has_cut = cut is not False
    with figure(suited_size(bins, has_cut, bool(title)), title, note, path) as page:
        if has_cut:  # the legend of the cut takes no room from the maps
            maps, beside = page.subfigures(1, 2, width_ratios=(2 * (_panel(bins)[0] + BESIDE), CUT))
            axes = [*maps.subplots(1, 2), beside.subplots()]
        else:
            axes = page.subplots(1, 2)
        _draw(axes, bins, exact, cut, decades, norm, bar)
    return page


def plot_maps(
    panels: Mapping[str, Data],
    path: str | os.PathLike | None = None,
    *,
    quantity: str | None = None,
    at: Mapping[str, int] = NO_BINS,
    label: str | None = None,
    decades: float | None = None,
    frame: str | None = None,
    title: str | None = None,
    note: str | None = None,
) -> Figure:
    """Draw several maps side by side on one scale, and their relative standard errors [%] below.

    Parameters
    ----------
    panels : mapping of str to Tally or EstimateArray
        What is drawn, by its heading.
    path, quantity, at, label, decades, frame, title, note
        As of `plot_map`.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        For no panels, and where `plot_map` raises it.
    """
    if not panels:
        raise ValueError("plot_maps: at least one panel is needed, got none")
    shown = {name: bins_of(each, quantity, at, label, frame) for name, each in panels.items()}
    first, *others = shown.values()
    for other, name in zip(others, list(shown)[1:], strict=True):
        for what, one, its in (
            ("unit", str(first.unit), str(other.unit)),
            ("axes", (first.across.label, first.up.label), (other.across.label, other.up.label)),
        ):
            if one != its:
                raise ValueError(f"plot_maps: all panels need the same {what}, {one}, got {its} in {name!r}")
    norm, worst = value_norm(shown.values(), decades), error_norm(shown.values())
    across, up = _panel(first)
    size = 1.0 * across * len(shown) + 3.0, 2 * up + 1.2 + (0.7 if title else 0)
    with figure(size, title, note, path) as page:
        grid = page.subplots(2, len(shown), sharex=True, sharey=True, squeeze=False)
        for (upper, lower), (name, bins) in zip(grid.T, shown.items(), strict=True):
            values, errors = draw_values(upper, bins, norm), draw_errors(lower, bins, worst)
            upper.set_title(name)
            for axes in (upper, lower):
                axes.label_outer()
        _bar(values, grid[0], with_unit(first.label, first.unit), _beyond(shown.values(), norm))
        _bar(errors, grid[1], ERROR_LABEL, _beyond_errors(shown.values(), worst), hatched=shown.values())
    return page


# ---- What is drawn


class Along(NamedTuple):
    """An axis of a map: its name, edges of its bins in `unit`, of which there are `scale` in an SI unit, and its words.

    names: what stands at the bins where the axis is a list of instants or of media; they are drawn equally wide.
    is_from_pole: whether it is a polar angle, which grows downwards.
    """

    name: str
    edges: np.ndarray
    words: str
    unit: str
    scale: float = 1.0
    names: tuple[str, ...] = ()
    is_from_pole: bool = False

    @property
    def label(self) -> str:
        """The words with the unit."""
        return f"{self.words} [{self.unit}]" if self.unit else self.words

    @property
    def middles(self) -> np.ndarray:
        """The middles of the bins."""
        return 0.5 * (self.edges[1:] + self.edges[:-1])


@dataclass(frozen=True, eq=False)
class Bins:
    """Bins over two coordinates as a map shows them; all fields are (up, across).

    On a disk and in a plan of directions `across` is the distance from the middle, and `up` the azimuth;
    pole: where directions with θ = 0 are, in words;  is_void: where there is no bin, such as beyond the rim of an
    image; nothing is drawn there.
    """

    across: Along
    up: Along
    value: np.ndarray
    error: np.ndarray
    unscored: np.ndarray
    doubtful: np.ndarray
    unit: object
    label: str
    frame: str
    is_transposed: bool
    source: EstimateArray
    pole: str
    is_void: np.ndarray | None = None

    @property
    def is_round(self) -> bool:
        """Whether the bins are rings and sectors."""
        return self.frame in (DISK, PLAN)

    @property
    def is_to_scale(self) -> bool:
        """Whether both coordinates are drawn to one scale."""
        if self.is_round or self.frame in (*IMAGES, UNROLLED):
            return True
        alike = self.up.unit == self.across.unit and not (self.up.names or self.across.names)
        return alike and 1 / STRETCHED <= self.stretch <= STRETCHED

    @property
    def stretch(self) -> float:
        """Height over width."""
        return self.aspect * float(np.ptp(self.up.edges) / np.ptp(self.across.edges))

    @property
    def aspect(self) -> float:
        """Height of a unit of `up` over the width of one of `across`, in a map that is drawn to scale.

        A cylinder has the circumference of 2π radii, and cos θ along its height.
        """
        return 180 / math.pi if self.frame == UNROLLED else 1.0

    @property
    def percent(self) -> np.ndarray:
        """Relative standard errors [%], nan where there is none: no score, no error, or a value of 0."""
        with np.errstate(divide="ignore", invalid="ignore"):
            percent = np.where(self.error == 0, 0.0, 100 * self.error / np.abs(self.value))
        return np.where(np.isfinite(percent), percent, np.nan)

    @property
    def outlines(self) -> tuple[np.ndarray, np.ndarray]:
        """x and y of the corners of the bins, (up + 1, across + 1); azimuths are cut so fine that they look round."""
        if not self.is_round:
            return np.meshgrid(self.across.edges, self.up.edges)
        turn, times = self.up.edges, self.arcs
        fine = np.interp(np.arange((len(turn) - 1) * times + 1) / times, np.arange(len(turn)), turn)
        phi = np.radians(fine)[:, None]
        return self.across.edges * np.cos(phi), self.across.edges * np.sin(phi)

    @property
    def arcs(self) -> int:
        """Cells that a bin is drawn as, along its azimuth."""
        return max(1, math.ceil(np.diff(self.up.edges).max() / FINEST)) if self.is_round else 1

    def drawn(self, field: np.ndarray) -> np.ndarray:
        """A field (up, across) by the cells between `outlines`."""
        return np.repeat(field, self.arcs, axis=0)

    def arranged(self, field: np.ndarray) -> np.ndarray:
        """A field of the array as (up, across)."""
        return field.T if self.is_transposed else field


def bins_of(
    data: Data,
    quantity: str | None = None,
    at: Mapping[str, int] = NO_BINS,
    label: str | None = None,
    frame: str | None = None,
) -> Bins:
    """The two axes of bins that `plot_map` draws of the same arguments.  Raises ValueError if they are not two."""
    chosen = _chosen(data, quantity, at, label, frame)
    if chosen.listed or chosen.is_line:
        example = "[" + ":, " * chosen.array.dims.index(chosen.listed) + "0].plot()" if chosen.listed else ""
        cure = f"take one {chosen.listed}, as in {example}" if chosen.listed else "use plot_curves"
        raise ValueError(f"plot: a map has two axes of bins, got {chosen.array.dims}; {cure}")
    return _arranged(chosen)


def is_line(data: Data, quantity: str | None = None) -> bool:
    """Whether `plot_map` draws a curve, along one axis of bins."""
    return _chosen(data, quantity, NO_BINS, None, None).is_line


class Chosen(NamedTuple):
    """A quantity with its axes of bins: index: which bins of the data they are;  listed: its axis of instants, if it is one too many."""

    array: EstimateArray
    index: tuple[int | slice, ...]
    bins: tuple[int, ...]
    label: str
    shape: object
    frame: str | None
    pole: str
    listed: str | None = None
    is_void: np.ndarray | None = None

    @property
    def is_line(self) -> bool:
        """Whether only one axis is left."""
        return len(self.array.dims) == 1 and self.frame is None

    def taken(self, field: np.ndarray) -> np.ndarray:
        """Of numbers for all bins those that are drawn.  Raises ValueError for another shape."""
        if field.shape != self.bins:
            raise ValueError(f"plot_map: exact must have the bins {self.bins}, got {field.shape}")
        return field[self.index]


def _chosen(
    data: Data, quantity: str | None, at: Mapping[str, int], label: str | None, frame: str | None
) -> Chosen:
    """The bins to draw: one of the axes that `at` names, of three axes of cells, and of axes with a single bin."""
    shape = void = None
    _check_words("label", label)
    if frame not in (None, *FRAMES):
        raise ValueError(f"plot: frame must be one of {', '.join(FRAMES)}, got {frame!r}")
    if isinstance(data, EstimateArray):
        array, label, whose = data, label or "estimate", "the array"
    elif not hasattr(data, "named"):
        cure = 'give it a result["name"], or one of its quantities with bins'
        raise ValueError(f"plot: a Tally or EstimateArray is drawn, got {type(data).__name__}; {cure}")
    else:
        name = quantity or main_quantity(data)
        array, whose = data.named(name), f"{name} of {data.name!r}"
        label = label or name.replace("_", " ")
        shape = None if isinstance(data, VolumeReading) else getattr(data, "shape", None)
        if isinstance(data, ViewReading):
            frame = frame or _view_frame(data.detector, array.dims)
            void = _void_of(data.detector, frame)
        if not isinstance(array, EstimateArray):
            raise ValueError(f"plot: {whose} has no bins, it is {array}")
    if strangers := set(at) - set(array.dims):
        raise ValueError(f"plot: {whose} has no axes {sorted(strangers)}; there are {array.dims}")
    bins = dict(zip(array.dims, array.shape, strict=True))
    if tuple(bins) == tuple("uvst") and not {"s", "t"} & set(at):  # the view in the middle of a light field
        at = {name: bins[name] // 2 for name in "uv"} | dict(at)
    free = [name for name in bins if name not in at]
    if tuple(bins) == ("face", "v", "u") and frame in (None, UNFOLDED):
        frame = IMAGE if at else UNFOLDED
    if frame == UNFOLDED and tuple(free) != ("face", "v", "u"):
        raise ValueError(f"plot: frame='cube' needs the axes face, v and u, got {tuple(free)}")
    if frame == UNROLLED and tuple(free) != ("theta", "phi"):
        raise ValueError(f"plot: frame='cylinder' needs the axes theta and phi, got {tuple(free)}")
    is_plan = frame in (PLAN, UNFOLDED)
    left = [name for name in free if bins[name] > 1 or is_plan] or free[:1]
    at = {name: 0 for name in bins if name not in left} | dict(at)
    listed = next((name for name in left if len(left) == 3 and _is_list(array, name)), None)
    while len(left) > 2 and listed is None and frame != UNFOLDED:
        middle = next((name for name in CELLS if name in left), None)
        if middle is None:
            cure = f"index it, or average it as in .mean({left[-1]!r}), to leave one or two"
            example = f"; or write at={{{left[0]!r}: 0}} of plot_map"
            raise ValueError(
                f"plot: {whose} has {len(left)} axes of bins ({', '.join(left)}); {cure}{example}"
            )
        at[middle] = bins[middle] // 2
        left.remove(middle)
    for name, place in at.items():
        if not -bins[name] <= place < bins[name]:
            raise ValueError(f"plot: {whose} has {bins[name]} bins of {name}, got {place} in at=")
    index = tuple(at.get(name, slice(None)) if name not in left else slice(None) for name in array.dims)
    label += "".join(_place_words(array, name, at[name]) for name in at if bins[name] > 1)
    shown = array[index]
    if not isinstance(shown, EstimateArray):
        raise ValueError(f"plot: {whose} at {dict(at)} is one bin, {shown}; leave an axis out of at=")
    directions = getattr(getattr(data, "detector", None), "directions", None)
    pole = POLES.get(getattr(directions, "frame", ""), "θ = 0")  # an array does not know its frame
    if frame == ROUND and void is None and set(shown.dims) == {"v", "u"}:
        sides = [shown.coords[name] for name in shown.dims]
        void = _outside(*sides, min(edges[-1] for edges in sides))
    return Chosen(shown, index, array.shape, label, shape, frame, pole, listed, void)


def _view_frame(sensor: object, names: tuple[str, ...]) -> str | None:
    """How the map of a camera or of an environment map lies; None where it depends on the axes that are left."""
    if getattr(sensor, "projection", None) == CYLINDER:
        return UNROLLED
    if "theta" in names:
        return SKY
    if names != ("v", "u"):
        return None
    return IMAGE if sensor.projection_of_image is None or sensor.solid_angles().all() else ROUND


def _void_of(sensor: object, frame: str | None) -> np.ndarray | None:
    """Pixels beyond the rim of an image."""
    return sensor.solid_angles() == 0 if frame == ROUND and sensor.projection_of_image else None


def _outside(first: np.ndarray, second: np.ndarray, rim: float) -> np.ndarray:
    """Pixels between edges that lie beyond a circle about the middle."""
    near = [np.maximum(0.0, np.maximum(edges[:-1], -edges[1:])) for edges in (first, second)]
    return np.hypot(*np.meshgrid(*near, indexing="ij")) >= rim


def _check_words(name: str, text: object) -> None:
    if text is not None and not (isinstance(text, str) and text):
        raise ValueError(f"plot: {name} must be words, got {short_repr(text)}; leave {name} out")


def _place_words(array: EstimateArray, name: str, place: int) -> str:
    """Where an array is cut, such as ", z = -4.5 mm"."""
    along = alongs(array)[array.dims.index(name)]
    if along.names:
        return f", {along.names[place]}"
    return f", {along.words} = {along.middles[place]:.3g} {along.unit}".rstrip().replace("-", "−")


def main_quantity(tally: Tally) -> str:
    """The first quantity in which findings about bins are searched, or else the first one with bins.

    Raises ValueError if there is none.
    """
    for name, _ in tally.binned():
        return name
    for name in tally.available:
        if isinstance(getattr(tally, name), EstimateArray):
            return name
    cure = "give the detector bins, such as positions=, directions=, cells= or times=, or print it"
    raise ValueError(f"plot: {tally.title} has no quantity with bins; {cure}")


def _is_list(array: EstimateArray, name: str) -> bool:
    """Whether an axis is a list, of instants or of media, and no bins."""
    return name in AXES_OF_PLACES and len(array.coords[name]) == array.shape[array.dims.index(name)]


def _by_instants(array: EstimateArray, listed: str) -> dict[str, EstimateArray]:
    """Heading -> the array at that instant, of up to MOST_COLUMNS of them evenly."""
    names, axis = _names(array, listed), array.dims.index(listed)
    columns = np.linspace(0, len(names) - 1, min(MOST_COLUMNS, len(names))).round().astype(int).tolist()
    return {names[k]: array[tuple(k if d == axis else slice(None) for d in range(3))] for k in columns}


def _names(array: EstimateArray, listed: str) -> tuple[str, ...]:
    """What stands at the places of a list."""
    if listed == "medium":
        return tuple(f"medium {place:.0f}" for place in array.coords[listed])
    places = array.coords[listed]
    digits = next((n for n in range(4, 17) if len({f"{place:.{n}g}" for place in places}) == len(places)), 17)
    return tuple(f"t = {place:.{digits}g} s" for place in places)


def alongs(array: EstimateArray, shape: object = None) -> list[Along]:
    """The axes of an array with angles in degrees, and all lengths in the unit of the longest."""
    names_of_shape = _coordinate_names(shape)
    given = {} if shape is None else {name: unit for name, (_, _, unit) in shape.coordinates().items()}
    units = {name: axis_unit(name, given | array.axis_units) for name in array.dims}
    lengths = [np.abs(array.coords[name]).max() for name in array.dims if units[name] == "m"]
    metre, length = unit_of_length(max(lengths, default=1.0))
    suited = {"m": (1 / metre, length), "rad": (180 / math.pi, "°")}
    found = []
    for name, unit in units.items():
        if _is_list(array, name):
            names = _names(array, name)
            found.append(Along(name, np.arange(len(names) + 1) - 0.5, "", "", names=names))
            continue
        scale, unit = suited.get(unit, (1.0, unit_label(unit or "1")))
        say, coordinate = axis_words(name, names_of_shape), axis_coordinate(name, names_of_shape)
        is_from_pole = coordinate is not None and coordinate.is_from_pole
        found.append(Along(name, array.coords[name] * scale, say, unit, scale, is_from_pole=is_from_pole))
    return found


def _coordinate_names(shape: object) -> tuple[str, ...]:
    """What a shape calls u and v."""
    return ("u", "v") if shape is None else shape.coordinate_names


def _arranged(chosen: Chosen) -> Bins:
    """The bins as they lie."""
    array, shape, names = chosen.array, chosen.shape, chosen.array.dims
    frame = chosen.frame or _frame(array, shape)
    if frame == PLAN:
        found = direction_bins(array)
        across = Along(
            "theta", np.degrees(found.theta), axis_words("theta"), "°", 180 / math.pi, is_from_pole=True
        )
        up = Along("phi", np.degrees(found.phi), axis_words("phi"), "°", 180 / math.pi)
        fields = (each.T for each in (found.value, found.error, found.unscored, found.doubtful))
        is_transposed = names[-1] == "phi"
        return Bins(across, up, *fields, array.unit, chosen.label, frame, is_transposed, array, chosen.pole)
    if frame == UNFOLDED:
        return _unfolded(chosen)
    first, second = alongs(array, shape)
    if frame == UNROLLED:
        first = Along("theta", np.cos(array.coords["theta"]), "cos θ", "")
    is_unrolled = "azimuth" in _coordinate_names(shape) and frame == FLAT
    is_transposed = not (is_unrolled and names == ("u", "v")) and names[0] not in UPRIGHT
    up, across = (second, first) if is_transposed else (first, second)
    fields = (array.value, array.error, array.reason == "no score", array.is_doubtful)
    fields = (each.T if is_transposed else each for each in fields)
    common = array.unit, chosen.label, frame, is_transposed, array, chosen.pole
    return _without(Bins(across, up, *fields, *common), chosen.is_void)


def _without(bins: Bins, is_void: np.ndarray | None) -> Bins:
    """The bins without values where there is nothing."""
    if is_void is None or not is_void.any():
        return bins
    is_void = bins.arranged(is_void)
    value, error = (np.where(is_void, np.nan, each) for each in (bins.value, bins.error))
    marks = {name: getattr(bins, name) & ~is_void for name in ("unscored", "doubtful")}
    return replace(bins, value=value, error=error, is_void=is_void, **marks)


def _unfolded(chosen: Chosen) -> Bins:
    """The six faces of a cube as a cross, seen from inside."""
    array = chosen.array
    _, rows, columns = array.shape
    step = np.diff(array.coords["u"])[0]
    up, across = (
        Along(name, np.arange(count + 1) * step, name, "")
        for name, count in (("v", 3 * rows), ("u", 4 * columns))
    )
    common = array.unit, chosen.label, UNFOLDED, False, array, chosen.pole
    fields = array.value, array.error, array.reason == "no score", array.is_doubtful
    fields = [unfold(each, fill) for each, fill in zip(fields, (np.nan, np.nan, False, False), strict=True)]
    return Bins(across, up, *fields, *common, is_void=unfold(np.zeros(array.shape, bool), True))


def unfold(faces: np.ndarray, fill: object) -> np.ndarray:
    """Six images (face, v, u) of a cube as a cross (3 v, 4 u), with v upward; `fill` where no face is.

    The face +y is in its middle, -x, +x and -y beside it, +z above and -z below, so that neighbours meet.
    """
    _, rows, columns = faces.shape
    laid = np.full((3 * rows, 4 * columns), fill, dtype=faces.dtype)
    for face, (row, column, is_turned) in zip(faces, map(CROSS.get, FACES), strict=True):
        place = slice(row * rows, (row + 1) * rows), slice(column * columns, (column + 1) * columns)
        laid[place] = face[::-1, ::-1] if is_turned else face
    return laid


def _frame(array: EstimateArray, shape: object) -> str:
    names = array.dims
    if set(names) == {"theta", "phi"} or set(names) == {"mu", "phi"}:
        polar = names[0] if names[0] in POLAR_AXES else names[1]
        edges = array.coords[polar]
        theta = np.arccos(np.clip(edges, -1, 1)) if polar == "mu" else edges
        if theta.max() <= math.pi / 2 + 1e-9:
            return PLAN
        return SKY if names == ("theta", "phi") else FLAT
    if names == ("v", "u"):
        return IMAGE
    return DISK if isinstance(shape, Disk) and names == ("u", "v") else FLAT


# ---- Scales


def _check_decades(decades: float | None) -> None:
    if decades is not None and not (isinstance(decades, int | float) and 0 < decades <= MAX_DECADES):
        must = f"decades must be above 0 and at most {MAX_DECADES}"
        raise ValueError(f"plot: {must}, got {short_repr(decades)}; leave it out for a linear scale")


def value_norm(bins: Bins | Iterable[Bins], decades: float | None = None) -> Normalize:
    """The scale of maps: from 0 (or the least, below it) to the greatest value that is well known, or so many decades down from there.

    Raises ValueError for decades of negative values, and for decades that are not above 0.
    """
    bins = [bins] if isinstance(bins, Bins) else list(bins)
    value, error = (np.concatenate([getattr(b, name).ravel() for b in bins]) for name in ("value", "error"))
    return scale_of(value, error, decades)


def scale_of(value: np.ndarray, error: np.ndarray, decades: float | None) -> Normalize:
    """The scale of values with their errors; see `value_norm`."""
    _check_decades(decades)
    trusted = value[error <= TRUSTED * np.abs(value)]
    shown = trusted if trusted.size else value[np.isfinite(value)]
    low, high = min(0.0, shown.min(initial=0.0)), shown.max(initial=0.0)
    if decades is None:
        return Normalize(low, high if high > low else low + 1)
    if low < 0:
        raise ValueError(f"decades: a logarithmic scale has no place for {low:.4g}; leave decades out")
    high = high or value[value > 0].max(initial=0.0) or 1.0
    return LogNorm(high * 10.0**-decades, high)


def error_norm(bins: Bins | Iterable[Bins]) -> Normalize:
    """From the least relative error [%] to the greatest over decades where they differ much, from 0 where they do not."""
    bins = [bins] if isinstance(bins, Bins) else list(bins)
    percent = np.concatenate([np.clip(each.percent, None, WORST).ravel() for each in bins])
    positive = percent[percent > 0]
    low, high = (positive.min(), positive.max()) if positive.size else (0.0, 1.0)
    if not high > WIDE * low > 0:
        return Normalize(0, high)
    return LogNorm(max(low, high * 10.0**-ERROR_DECADES), high)


def _on_scale(bins: Bins, norm: Normalize) -> np.ndarray:
    """The values; on a logarithmic scale what is fainter at its darkest end, and nan for what has no logarithm.

    A picture is dark where nothing came from.
    """
    if not isinstance(norm, LogNorm):
        return bins.value
    is_shown = bins.value >= 0 if bins.frame in (*IMAGES, SKY, UNROLLED) else bins.value > 0
    return np.where(is_shown, np.maximum(bins.value, norm.vmin), np.nan)


def _beyond(bins: Iterable[Bins], norm: Normalize) -> str:
    return _ends_beyond([each.value for each in bins], norm)


def _beyond_errors(bins: Iterable[Bins], norm: Normalize) -> str:
    """As `_beyond`; that an exact bin has no error is below every scale."""
    return _ends_beyond([each.percent[~(each.percent == 0)] for each in bins], norm)


def _ends_beyond(fields: Iterable[np.ndarray], norm: Normalize) -> str:
    """The ends of a scale that some values lie beyond, as `extend` of a colour bar."""
    values = np.concatenate([each.ravel() for each in fields])
    finite = values[np.isfinite(values)]
    ends = (
        finite.min(initial=norm.vmax) < norm.vmin * (1 - 1e-9),
        finite.max(initial=norm.vmin) > norm.vmax * (1 + 1e-9),
    )
    return {(True, True): "both", (True, False): "min", (False, True): "max"}.get(ends, "neither")


# ---- Drawing


def _draw(
    axes: Sequence[Axes],
    bins: Bins,
    exact: np.ndarray | Radiance | None,
    cut: bool | float,
    decades: float | None,
    norm: Normalize | None,
    bar: bool,
) -> None:
    """Values, errors where there are two axes or more, and the cut where there are three."""
    norm = norm or value_norm(bins, decades)
    is_alone, named = len(axes) == 1, with_unit(bins.label, bins.unit)
    values = draw_values(axes[0], bins, norm, is_alone)
    if bar:
        _bar(values, axes[0], named if is_alone else "", _beyond([bins], norm), bins)
    if not is_alone:
        worst = error_norm(bins)
        errors = draw_errors(axes[1], bins, worst)
        axes[0].set_title(named)
        axes[1].set_title(ERROR_LABEL)
        if bar:
            _bar(errors, axes[1], "", _beyond_errors([bins], worst), bins, hatched=[bins])
    if cut is not False:
        sides = _sides(bins, cut)
        _mark(axes[0], bins, sides)
        if len(axes) > 2:
            _draw_cut(axes[2], bins, sides, exact, norm)


def draw_values(axes: Axes, bins: Bins, norm: Normalize, is_alone: bool = False) -> ScalarMappable:
    """Colour bins by their values; those with a doubtful error are hatched where no map of errors stands beside."""
    field = _on_scale(bins, norm)
    drawn = draw_field(axes, bins, field, norm)
    if is_alone:
        _hatch(axes, bins, bins.doubtful & np.isfinite(field))
    return drawn


def draw_errors(axes: Axes, bins: Bins, norm: Normalize) -> ScalarMappable:
    """Colour bins by their relative standard error [%], hatched where it is not known or doubtful."""
    percent = bins.percent
    field = np.maximum(percent, norm.vmin) if isinstance(norm, LogNorm) else percent
    drawn = draw_field(axes, bins, field, norm)
    _hatch(axes, bins, bins.doubtful & ~np.isnan(percent))
    return drawn


def _why_hatched(bins: Collection[Bins]) -> str:
    """What hatching means in maps of errors; empty where nothing is hatched."""
    percent, unscored, doubtful = (
        np.concatenate([getattr(each, name).ravel() for each in bins])
        for name in ("percent", "unscored", "doubtful")
    )
    nowhere = [np.zeros(each.value.shape, bool) if each.is_void is None else each.is_void for each in bins]
    gaps = np.isnan(percent) & ~np.concatenate([each.ravel() for each in nowhere])
    words = [("no score" if unscored[gaps].all() else "not known")] if gaps.any() else []
    return ",\n".join(words + ["doubtful"] * bool((doubtful & ~gaps).any()))


def draw_field(
    axes: Axes, bins: Bins, field: np.ndarray, norm: Normalize, colours: str = SEQUENTIAL
) -> ScalarMappable:
    """Colour the bins by a field (up, across); where it is nan they are hatched grey, and blank where no bin is."""
    axes.grid(False)
    shown = np.ma.masked_invalid(bins.drawn(field))
    x, y = bins.outlines
    is_void = np.zeros(field.shape, bool) if bins.is_void is None else bins.is_void
    if not np.isfinite(field[~is_void]).all():
        # One hatched face below all bins: hatching each of them takes seconds.
        rim = [np.concatenate([c[0], c[:, -1], c[-1, ::-1], c[::-1, 0]]) for c in (x, y)]
        axes.fill(*rim, facecolor=PALE, hatch=HATCHING, edgecolor=MUTED, linewidth=0, zorder=-5)
        if is_void.any():
            blank = np.ma.masked_equal(is_void.astype(float), 0.0)
            axes.pcolorfast(x[0], y[:, 0], blank, cmap=ListedColormap(["white"]), zorder=-4)
    look_of = {"norm": norm, "cmap": colours}
    if bins.is_round:
        drawn = axes.pcolormesh(x, y, shown, rasterized=True, **look_of)
    else:
        drawn = axes.pcolorfast(bins.across.edges, bins.up.edges, shown, **look_of)
        rim = bins.across.edges[-1]
        if bins.frame == ROUND and np.array_equal(is_void, _outside(bins.up.edges, bins.across.edges, rim)):
            drawn.set_clip_path(Circle((0, 0), rim, transform=axes.transData))
    if bins.frame == PLAN:
        _furnish_plan(axes, bins)
    elif bins.frame == DISK:
        unit = bins.across.unit
        axes.set(xlabel=rf"along $e_u$ [{unit}]", ylabel=rf"along $e_v$ [{unit}]", aspect="equal")
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(FewTicks())
    else:
        _furnish_flat(axes, bins)
    return drawn


def _furnish_flat(axes: Axes, bins: Bins) -> None:
    """Ticks, labels and directions of both axes."""
    across, up = bins.across, bins.up
    if bins.frame in IMAGES:
        axes.set(xticks=[], yticks=[], aspect="equal")
        if bins.frame != IMAGE:
            axes.spines[:].set_visible(False)
        if bins.frame == UNFOLDED:
            _name_faces(axes, bins)
        return
    is_sky = bins.frame in (SKY, UNROLLED) and across.name == "phi" and up.name in POLAR_AXES
    axes.set(xlabel=across.label + ", seen from inside" * is_sky, ylabel=up.label)
    axes.xaxis.set_inverted(is_sky)
    axes.yaxis.set_inverted(up.is_from_pole)
    for axis, along in ((axes.xaxis, across), (axes.yaxis, up)):
        if along.names:
            axis.set_ticks(range(len(along.names)), along.names)
            lines = axes.axvline if axis is axes.xaxis else axes.axhline
            for between in along.edges[1:-1]:
                lines(between, color="white", lw=3)
        else:
            axis.set_major_locator(FewTicks(along.unit == "°"))
    axes.tick_params(pad=6)
    if bins.is_to_scale:
        axes.set_aspect(bins.aspect)


def _name_faces(axes: Axes, bins: Bins) -> None:
    """The axes of a cube's faces, in a corner of each."""
    side = bins.up.edges[-1] / 3
    style = {"color": "white", "fontsize": "small", "ha": "left", "va": "bottom", "path_effects": outlined()}
    for name, (row, column, _) in CROSS.items():
        axes.text((column + 0.05) * side, (row + 0.03) * side, name.replace("-", "−"), **style)


def _furnish_plan(axes: Axes, bins: Bins) -> None:
    """Rings of polar angle, spokes of azimuth, and their labels."""
    rim, has_spokes = bins.across.edges.max(), len(bins.up.edges) > 2
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set(xlim=(-1.15 * rim, 1.15 * rim), ylim=(-1.15 * rim, 1.15 * rim))
    if has_spokes:
        for azimuth in range(0, 360, 45):
            phi = math.radians(azimuth)
            axes.plot([0, rim * math.cos(phi)], [0, rim * math.sin(phi)], color="white", lw=0.7, alpha=0.45)
        for azimuth, across, up in COMPASS:
            x, y = 1.06 * rim * math.cos(math.radians(azimuth)), 1.06 * rim * math.sin(math.radians(azimuth))
            axes.text(x, y, f"φ = {azimuth}°" if azimuth == 90 else f"{azimuth}°", ha=across, va=up)
    for angle in _rings(rim):
        axes.add_patch(Circle((0, 0), angle, fill=False, ec="white", lw=1.0, alpha=0.7))
        x, y = angle * math.cos(LABELLED), angle * math.sin(LABELLED)
        axes.text(x, y, f"{angle:g}°", ha="center", va="center", color="white", path_effects=outlined())
    axes.add_patch(Circle((0, 0), rim, fill=False, ec=INK, lw=1.8))
    x, y = 1.03 * rim * math.cos(LABELLED), 1.03 * rim * math.sin(LABELLED)
    axes.text(x, y, f"θ = {rim:.3g}°", ha="left", va="bottom")
    if has_spokes:
        corner = {"color": MUTED, "fontsize": "small", "ha": "left", "va": "bottom"}
        axes.text(-1.15 * rim, -1.15 * rim, f"seen from\n{bins.pole}", **corner)


def _rings(rim: float) -> list[float]:
    """Polar angles of the rings inside the rim [deg]: 30 and 60, or round numbers for a narrower cone."""
    if math.isclose(rim, 90):
        return [30.0, 60.0]
    angles = MaxNLocator(3, steps=[1, 2, 3, 5, 10]).tick_values(0, rim)
    return [angle for angle in angles if 0 < angle < 0.9 * rim]


def _hatch(axes: Axes, bins: Bins, those: np.ndarray) -> None:
    """Hatch bins above their colours."""
    if not those.any():
        return
    corners, those = np.stack(bins.outlines, axis=-1), bins.drawn(those)
    ways = corners[:-1, :-1], corners[:-1, 1:], corners[1:, 1:], corners[1:, :-1], corners[:-1, :-1]
    outlines = np.stack([way[those] for way in ways], axis=1)
    codes = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY]
    # One path for all bins: hatching each of them takes seconds.
    path = Path(outlines.reshape(-1, 2), np.tile(codes, len(outlines)))
    axes.add_patch(PathPatch(path, facecolor="none", edgecolor=MUTED, linewidth=0, hatch=HATCHING, zorder=3))


def _bar(
    drawn: ScalarMappable,
    axes: Axes | np.ndarray,
    label: str,
    extend: str,
    bins: Bins | None = None,
    hatched: Collection[Bins] = (),
) -> None:
    """The colour bar beside a map, or beside a row of maps, and below it what hatching means."""
    why = _why_hatched(hatched) if hatched else ""
    if isinstance(axes, Axes):
        across, up = _panel(bins)
        low, high = (0.08, 0.92) if bins.frame == PLAN else (0.0, 1.0)
        low += (SWATCH + 0.3) / up if why else 0.0
        place = {"cax": axes.inset_axes((1 + 0.16 / across, low, 0.26 / across, high - low))}
        bar = axes.figure.colorbar(drawn, extend=extend, **place)
        height = up * (high - low)
    else:
        bar = axes[0].figure.colorbar(drawn, ax=list(axes), extend=extend, pad=0.015, aspect=18)
        height = PANEL
    bar.set_label(label, fontsize="small" if bins and _panel(bins)[1] < LOW else None)
    if isinstance(drawn.norm, LogNorm):
        tick_log(bar.ax.yaxis)
    else:
        bar.locator = MaxNLocator(5)
        bar.update_ticks()
    if why:
        look_of = {"facecolor": PALE, "hatch": HATCHING, "edgecolor": MUTED, "linewidth": 0}
        below = -(SWATCH + 0.3) / height
        where = {"transform": bar.ax.transAxes, "clip_on": False}
        bar.ax.add_patch(RectanglePatch((0, below), 1, SWATCH / height, **look_of, **where))
        say = {"fontsize": "small", "va": "center", "linespacing": 0.9, "transform": bar.ax.transAxes}
        bar.ax.text(1.35, below + 0.5 * SWATCH / height, why, **say)


# ---- Sizes


def _panel(bins: Bins) -> tuple[float, float]:
    """Width and height of a map [inches]."""
    if bins.frame == PLAN:
        return 1.25 * PANEL, 1.25 * PANEL
    if bins.is_round or not bins.is_to_scale:
        return PANEL, PANEL
    return (PANEL, PANEL * bins.stretch) if bins.stretch <= 1 else (PANEL / bins.stretch, PANEL)


def suited_size(bins: Bins, has_cut: bool = False, has_title: bool = False) -> tuple[float, float]:
    """Width and height of a figure of values, errors and cut [inches]."""
    across, up = _panel(bins)
    height = max(up + 1.6, 5.8 if has_cut else 4.2) + 0.7 * has_title
    return 2 * (across + BESIDE) + CUT * has_cut, height


# ---- Cuts


class Side(NamedTuple):
    """A row of bins (an azimuth of a round map) that a cut runs along, to the right (+1) or the left (-1)."""

    row: int
    sign: int


def _sides(bins: Bins, cut: bool | float) -> list[Side]:
    """The row of a cut; of a round map the azimuth, and the opposite one where there is one."""
    if bins.frame == UNFOLDED:
        raise ValueError("plot_map: an unfolded cube has no cut; choose a face, as in at={'face': 2}")
    up, row = bins.up, _brightest_row(bins) if cut is True else None
    if row is None:
        if bins.is_round and abs(cut) > 2 * math.pi:
            must = f"an azimuth of -2π to 2π [rad], got {cut!r}; write math.radians({cut!r}) for degrees"
            raise ValueError(f"plot: cut must be {must}")
        place = cut * up.scale
        if bins.frame == UNROLLED:
            place = math.cos(cut) if 0 <= cut <= math.pi else math.inf
        row = _row_at(bins, place)
        if row is None:
            ends = np.arccos(up.edges) if bins.frame == UNROLLED else up.edges / up.scale
            low, high = ends[[0, -1]]
            raise ValueError(f"plot_map: cut must be {low:.4g} to {high:.4g}, got {cut!r}")
    if not bins.is_round or len(up.edges) == 2:
        return [Side(row, 1)]
    opposite = _row_at(bins, up.middles[row] + 180)
    return [Side(row, 1)] if opposite is None else [Side(row, 1), Side(opposite, -1)]


def _row_at(bins: Bins, place: float) -> int | None:
    """Which row holds this coordinate, or None where none does; of a list the nearest."""
    edges = bins.up.edges
    if bins.up.names:
        return int(np.argmin(np.abs(bins.source.coords[bins.up.name] - place)))
    if bins.is_round:
        place = edges[0] + np.mod(place - edges[0] + 1e-9, 360)
    if edges[0] > edges[-1]:  # cos θ
        edges, place = -edges, -place
    row = int(np.searchsorted(edges, place, side="right")) - 1
    row -= place == edges[-1]
    return row if 0 <= row < len(edges) - 1 else None


def _brightest_row(bins: Bins) -> int:
    """The row of greatest mean amount, of those with a bin within two standard errors of the brightest."""
    # Take one standard error off, so that a bin with a single large score does not win.
    amount = np.abs(bins.value)
    sure = amount - bins.error
    if not np.isfinite(sure).any():
        sure = amount
    sure = np.where(np.isfinite(sure), sure, -np.inf)
    top = np.unravel_index(sure.argmax(), sure.shape)
    slack = 2 * np.nan_to_num(bins.error[top])
    rows = np.flatnonzero(sure.max(axis=1) >= sure[top] - slack)
    start = 0 if bins.is_round else len(sure) // 2
    means = np.nan_to_num(amount[rows]).mean(axis=1)
    best = rows[np.isclose(means, means.max(), rtol=1e-9, atol=0)]
    return min(best.tolist(), key=lambda row: abs(row - start))


def _mark(axes: Axes, bins: Bins, sides: Sequence[Side]) -> None:
    """Where the cut runs."""
    style = {"color": "white", "lw": 1.8, "ls": (0, (4, 3)), "path_effects": outlined()}
    for rank, side in enumerate(sides):
        middle = bins.up.middles[side.row]
        if not bins.is_round:
            axes.axhline(middle, **style)
        elif len(bins.up.edges) > 2:
            reach, (colour, marker) = bins.across.edges[[0, -1]], look(rank)
            x, y = reach * math.cos(math.radians(middle)), reach * math.sin(math.radians(middle))
            axes.plot(x, y, **style)
            axes.plot(x[-1], y[-1], marker, ms=13, color=colour, mec="white", clip_on=False)


def _draw_cut(
    axes: Axes, bins: Bins, sides: Sequence[Side], exact: np.ndarray | Radiance | None, norm: Normalize
) -> None:
    """Points along the rows of the cut before what is exact, on the scale of the map."""
    series = {_side_label(bins, side): _cut_series(bins, side, exact) for side in sides}
    xlabel = POLAR_ANGLE if bins.frame == PLAN else bins.across.label
    is_log = isinstance(norm, LogNorm)
    plot_curves(series, ax=axes, xlabel=xlabel, ylabel=bins.label, log_y=is_log, means=True, legend="above")
    axes.set_ylabel(with_unit(bins.label, bins.unit))
    if is_log:
        axes.set_ylim(norm.vmin, max(1.5 * norm.vmax, axes.get_ylim()[1]))
        _say_hidden(axes, bins.value[[side.row for side in sides]], norm)
    axes.xaxis.set_major_locator(FewTicks(bins.across.unit == "°"))
    if bins.is_round:
        axes.set_xlim(np.array([-1, 1]) * bins.across.edges[-1])
        axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{abs(x):g}"))


def _say_hidden(axes: Axes, value: np.ndarray, norm: Normalize) -> None:
    """Write how many bins lie below a logarithmic scale."""
    if count := np.count_nonzero(value < norm.vmin):
        style = {"transform": axes.transAxes, "fontsize": "small", "color": MUTED}
        axes.text(0.01, 0.01, f"not drawn: {count} of {value.size} bins, below the scale", **style)


def _cut_series(bins: Bins, side: Side, exact: np.ndarray | Radiance | None) -> Series:
    if bins.frame == PLAN:
        if exact is not None and not callable(exact):
            raise ValueError("plot_map: exact of a plan of directions must be a function of theta and phi")
        return polar_series(bins.source, exact, side.row, side.sign)
    if callable(exact):
        raise ValueError(
            "plot_map: exact must be an array of means over the bins, but of a plan of directions"
        )
    estimates = bins.source[(slice(None), side.row) if bins.is_transposed else (side.row,)]
    expected = None if exact is None else exact[side.row]
    return Series(side.sign * bins.across.edges, estimates, expected=expected)


def _side_label(bins: Bins, side: Side) -> str:
    if len(bins.up.edges) == 2 and bins.is_round:
        return "all azimuths"
    if bins.up.names:
        return bins.up.names[side.row]
    low, high = bins.up.edges[side.row : side.row + 2]
    if bins.is_round:
        return f"{axis_symbol(bins.up.name)} = {low:.4g}° to {high:.4g}°".replace("-", "−")
    unit = "" if bins.up.unit == "°" else " "
    return f"at {bins.up.words} = {bins.up.middles[side.row]:.3g}{unit}{bins.up.unit}".replace("-", "−")


# ---- One axis


def _plot_line(
    chosen: Chosen,
    path: str | os.PathLike | None,
    ax: Axes | None,
    exact: np.ndarray | None,
    decades: float | None,
    title: str | None,
    note: str | None,
    unit: str | None,
) -> Figure | Axes:
    """Bins along one axis as steps with points; a list of instants as points, of media by their names."""
    array, (along,) = chosen.array, alongs(chosen.array, chosen.shape)
    norm = scale_of(array.value, array.error, decades)
    x, label = along.edges, along.label
    if along.names:
        x, label = along.middles, ""
        if along.name == "time":
            x, label = array.coords["time"], f"{axis_words('time')} [{axis_unit('time', {})}]"
    expected = None if exact is None else chosen.taken(np.asarray(exact, dtype=float))
    series = {chosen.label: Series(x, array, expected=expected)}
    is_log = isinstance(norm, LogNorm) and bool((array.value > 0).any())
    words = {"xlabel": label, "ylabel": chosen.label, "steps": True, "log_y": is_log}
    made = plot_curves(series, path if ax is None else None, ax=ax, title=title, note=note, **words)
    axes = made if ax is not None else made.axes[0]
    if unit is not None:
        axes.set_ylabel(with_unit(chosen.label, unit))
    if along.names and along.name != "time":
        axes.set_xticks(x, along.names)
        axes.set_xlim(along.edges[[0, -1]])
    elif not along.names:
        axes.xaxis.set_major_locator(FewTicks(along.unit == "°"))
    if is_log:
        axes.set_ylim(norm.vmin, max(1.5 * norm.vmax, axes.get_ylim()[1]))
        _say_hidden(axes, array.value, norm)
    return made
