"""`Scene.plot()`: a plane section of a scene, by which its geometry is checked: surfaces by material, media, sources, detectors.

Nothing is simulated, and no shape is approximated: the lines of a raster are crossed with each shape, and a dot is drawn at each crossing.
"""

from __future__ import annotations

import math
import os
import textwrap
from collections.abc import Iterator
from numbers import Real
from typing import NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, to_rgb
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path
from matplotlib.ticker import FuncFormatter

from transport.geometry.line_crossings import crossings
from transport.geometry.shape import Cloud, Point, Shape
from transport.io.html.scenes import constructor_text
from transport.scene.bodies import media_numbers, scene_media
from transport.scene.materials import Material
from transport.scene.media import Vacuum
from transport.scene.scene import Scene
from transport.validation import SceneError, join_names, short_repr
from transport.viz.facets import CLOUD_SIGMAS, Bounds, facets_of
from transport.viz.scene_parts import frame_of, shape_of
from transport.viz.style import INK, MUTED, PALETTE, STYLE, check_axes, saved
from transport.viz.wording import as_it_stands, unit_of_length

PLANES = {"xy": (0, 1, 2), "xz": (0, 2, 1), "yz": (1, 2, 0)}  # axis to the right, axis upwards, axis across
RASTER = 500  # lines along the longer side
SHIFT = 0.3183  # of the lines, in their distance, so that none runs within a wall at a round coordinate
FEW = 16  # lines through a shape, at least
NEAR = 0.02  # of the longer side: distance from the plane up to which a point is drawn
TOUCHING = 1e-9  # of the longer side: distance up to which a shape is in the plane
INSET = 1e-6  # of a shape that touches the plane: how far within it is crossed
SMALLEST = 0.01  # of the longer side: areas that are less are marked by a dot
PALE = 0.55  # of white in the colour of areas within the plane
SIZE, LEAST = 6.5, 2.0  # inches of the longer side, and at least of the other
MOST_NAMED = 8  # sources, and detectors, in the legend
WIDEST, MOST_LINES = 44, 4  # letters of a line of the legend, and lines of a material or medium
LETTER = 0.122  # inches of a letter of the legend
MARGIN = 0.05  # of the longer side
MANY = 10  # materials; where there are more, they are drawn by kind
SMALL = {"font.size": 13, "axes.titlesize": 14, "axes.labelsize": 14, "legend.fontsize": 12}
MATERIALS = (INK, *PALETTE, "#8c564b", "#7f7f7f", "#bcbd22")  # colours
LAMP = "#ffbf5e"
METERS = ("#8fd08f", "#7cc6c9", "#c9d96f", "#a9b8ea")  # colours of detectors, in turn
STEEP = 0.3  # sine of the angle between a normal and the line of sight, below which no arrow is drawn
ARROW = 0.07  # of the longer side, along the side that a source emits from or a detector counts at
MEDIA = ("#ffffff", "#d6e6f4", "#fbe3d0", "#dcefdc", "#efe0f0", "#f5f0c8", "#e3e3e3", "#d0ecec")


class Section(NamedTuple):
    """A raster in a plane: places [m] along both axes, and the place of the plane on the third."""

    axes: tuple[int, int, int]
    right: np.ndarray
    up: np.ndarray
    at: float

    def points(self) -> np.ndarray:
        """All points of the raster, (n, 3) [m], row by row."""
        points = np.empty((len(self.up), len(self.right), 3))
        along, upwards, across = self.axes
        points[..., along], points[..., upwards], points[..., across] = self.right, self.up[:, None], self.at
        return points.reshape(-1, 3)

    @property
    def size(self) -> float:
        """Its longer side [m]."""
        return max(np.ptp(self.right), np.ptp(self.up))

    @property
    def bounds(self) -> Bounds:
        """Corners (3,) [m] of a box around what is shown, as deep as it is wide."""
        low, high = np.full(3, self.at - self.size), np.full(3, self.at + self.size)
        for axis, places in zip(self.axes[:2], (self.right, self.up), strict=True):
            low[axis], high[axis] = places[0], places[-1]
        return low, high

    def meets(self, shape: Shape) -> bool:
        """Whether the plane passes through or touches the shape's bounds; of a point, whether it is near."""
        across = self.axes[2]
        if isinstance(shape, Point):
            return abs(shape.middle[across] - self.at) < NEAR * self.size
        if isinstance(shape, Cloud):
            return abs(shape.middle[across] - self.at) < self.depth(shape)
        low, high = (corner[across] for corner in shape.bounds)
        return bool(low - TOUCHING * self.size <= self.at <= high + TOUCHING * self.size)

    def depth(self, cloud: Cloud) -> float:
        """How far from the middle of a cloud the plane still cuts most of it [m]."""
        return max(CLOUD_SIGMAS * cloud.sigma[self.axes[2]], TOUCHING * self.size)

    def holds(self, shape: Shape) -> bool:
        """Whether a flat shape lies within the plane."""
        low, high = (corner[self.axes[2]] for corner in shape.bounds)
        return shape.is_flat and high - low <= TOUCHING * self.size and self.meets(shape)

    def crossings(self, shape: Shape) -> tuple[np.ndarray, np.ndarray]:
        """Where the lines of the raster, and some more through a small shape, cross a shape, along both axes [m]."""
        low, high = (np.array(corner) for corner in shape.bounds)
        inset = INSET * (high - low)[self.axes[2]]
        at = self.at  # just within a shape whose face lies in the plane
        if self.meets(shape) and np.isfinite(inset):
            at = np.clip(at, low[self.axes[2]] + inset, high[self.axes[2]] - inset)
        found = []
        for one, other, places, begins in (
            (self.axes[0], self.axes[1], self.up, self.right[0]),
            (self.axes[1], self.axes[0], self.right, self.up[0]),
        ):
            if (width := high[other] - low[other]) < FEW * (places[1] - places[0]):
                more = low[other] + width * (SHIFT + np.arange(FEW)) / FEW
                places = np.append(places, more[(more > places[0]) & (more < places[-1])])
            origins, directions = np.zeros((len(places), 3)), np.zeros((len(places), 3))
            origins[:, one], origins[:, other], origins[:, self.axes[2]] = begins, places, at
            directions[:, one] = 1.0
            distances = crossings(shape, origins, directions).distances
            row, column = np.nonzero(np.isfinite(distances))
            along, beside = begins + distances[row, column], places[row]
            found.append((along, beside) if one == self.axes[0] else (beside, along))
        x, y = (np.concatenate(parts) for parts in zip(*found, strict=True))
        return x, y


def plot_section(
    scene: Scene,
    plane: str = "xz",
    at: float | None = None,
    ax: Axes | None = None,
    path: str | os.PathLike | None = None,
) -> Axes:
    """Draw a plane section of a scene; see `Scene.plot`."""
    if plane not in PLANES:
        raise SceneError(f'Scene: plane must be "xy", "xz" or "yz", got {short_repr(plane)}')
    check_axes(ax)
    if at is not None and not (isinstance(at, Real) and math.isfinite(at)):
        raise SceneError(f"Scene: at must be a finite number [m], got {short_repr(at)}")
    section = section_of(scene, plane, at)
    with matplotlib.rc_context(STYLE | SMALL):
        if ax is None:
            from matplotlib import pyplot  # a figure that notebooks and windows show

            lengths = np.array([np.ptp(section.right), np.ptp(section.up)])
            width, height = np.maximum(SIZE * lengths / lengths.max(), LEAST)
            figure = pyplot.figure(figsize=(width, height + 1.0), layout="constrained")
            ax = figure.add_subplot()
            texts = [each.get_text() for each in _draw(scene, plane, section, ax).get_texts()]
            letters = max((len(line) for text in texts for line in text.split("\n")), default=0)
            figure.set_figwidth(width + 1.0 + LETTER * letters)
        else:
            _draw(scene, plane, section, ax)
        return saved(ax, path)


def section_of(scene: Scene, plane: str, at: float | None) -> Section:
    """The raster of a scene's section."""
    frame, axes = frame_of(scene), PLANES[plane]
    low, high = frame.low.copy(), frame.high.copy()
    margin = MARGIN * max((high - low)[list(axes[:2])].max(), 1e-300)
    if at is None:
        middle = 0.5 * (low[axes[2]] + high[axes[2]])
        at = 0.0 if low[axes[2]] < 0 < high[axes[2]] else middle
    lengths = [high[axis] - low[axis] + 2 * margin for axis in axes[:2]]
    step = max(lengths) / RASTER
    right, up = (
        low[axis] - margin + step * (SHIFT + np.arange(max(2, round(length / step))))
        for axis, length in zip(axes[:2], lengths, strict=True)
    )
    return Section(axes, right, up, float(at))


def _draw(scene: Scene, plane: str, section: Section, ax: Axes) -> Legend:
    handles, missing = list(_draw_media(scene, section, ax)), {}
    for each in (_draw_surfaces, _draw_sources, _draw_detectors):
        drawn, left_out = each(scene, section, ax)
        handles += drawn
        missing |= left_out
    elsewhere = [name for name, shape in missing.items() if not section.meets(shape)]
    beyond = [name for name in missing if name not in elsewhere]
    ax.set_aspect("equal")
    ax.grid(visible=False)
    ax.set_xlim(section.right[0], section.right[-1])
    ax.set_ylim(section.up[0], section.up[-1])
    metre, unit = unit_of_length(section.size)
    for axis, name in ((ax.xaxis, plane[0]), (ax.yaxis, plane[1])):
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value / metre:.6g}".replace("-", "−")))
        axis.set_label_text(f"{name}  [{unit}]")
    third = ({"x", "y", "z"} - set(plane)).pop()
    ax.set_title(f"section at {third} = {section.at / metre:.6g} {unit}", loc="left")
    words = []
    for where, names in (("not in this plane", elsewhere), ("in this plane, but not drawn", beyond)):
        if names:
            words += textwrap.wrap(f"{where}: {join_names(names, 8)}", WIDEST)
    handles += [Patch(facecolor="none", edgecolor="none", label=as_it_stands(line)) for line in words]
    legend = ax.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0)
    for text in legend.get_texts()[len(handles) - len(words) :]:
        text.set_color(MUTED)
    return legend


def _draw_media(scene: Scene, section: Section, ax: Axes) -> Iterator[Patch]:
    """Fill media by colour; the vacuum stays white."""
    media = scene_media(scene)
    if media == (Vacuum(),):
        return
    numbers = media_numbers(scene, section.points()).reshape(len(section.up), len(section.right))
    colours = [
        MEDIA[0] if medium == Vacuum() else MEDIA[1 + k % (len(MEDIA) - 1)] for k, medium in enumerate(media)
    ]
    edges = [(each[0], each[-1]) for each in (section.right, section.up)]
    ax.imshow(
        numbers, ListedColormap(colours), origin="lower", extent=(*edges[0], *edges[1]), vmin=-0.5,
        vmax=len(media) - 0.5, interpolation="nearest", zorder=0,
    )  # fmt: skip
    texts: list[str] = []
    for number, medium in enumerate(media):
        if (numbers == number).any():
            text = brief(medium)
            texts.append(text)
            # Media of one text differ in what is not written.
            again = f" ({texts.count(text)})" if texts.count(text) > 1 else ""
            yield Patch(facecolor=colours[number], edgecolor=MUTED, label=text + again)


def _draw_surfaces(scene: Scene, section: Section, ax: Axes) -> tuple[list, dict[str, Shape]]:
    """Draw surfaces by their material; return entries of the legend, and what is not seen."""
    materials = list(dict.fromkeys(surface.material for surface in scene.surfaces))
    by_kind = len(materials) > MANY

    def key(material: Material) -> object:
        return type(material) if by_kind else material

    colours = {
        kind: MATERIALS[k % len(MATERIALS)] for k, kind in enumerate(dict.fromkeys(map(key, materials)))
    }
    names, missing = {}, {}
    for number, surface in enumerate(scene.surfaces):
        name, kind = surface.name or f"surfaces[{number}]", key(surface.material)
        if _draw_shape(surface.shape, section, ax, colours[kind], 2.2, 3) is None:
            missing[name] = surface.shape
        else:
            names.setdefault(kind, []).append(name)
    return [
        _handle(
            colours[kind],
            f"{kind.__name__ if isinstance(kind, type) else brief(kind)}: {join_names(several, 3)}",
        )
        for kind, several in names.items()
    ], missing


def brief(thing: object) -> str:
    """The name of a medium; else the kind of a material or medium, with the parameters that differ from the default."""
    lines = textwrap.wrap(getattr(thing, "name", None) or constructor_text(thing), WIDEST)
    return "\n".join(lines[:MOST_LINES]) + " ..." * (len(lines) > MOST_LINES)


def _draw_sources(scene: Scene, section: Section, ax: Axes) -> tuple[list, dict[str, Shape]]:
    """Draw sources over their surfaces."""
    handles, missing = [], {}
    for number, source in enumerate(scene.sources):
        name = source.shape if isinstance(source.shape, str) else f"sources[{number}]"
        shape = scene.shape_of(source)
        places = _draw_shape(shape, section, ax, LAMP, 9.0, 1, "\\\\")
        if places is None:
            missing[name] = shape
        else:
            _draw_arrow(places, LAMP, shape, source.side, section, ax)
            handles.append(_handle(LAMP, f"source {name}: {type(source.emission).__name__}"))
    return _few(handles, "sources"), missing


def _draw_detectors(scene: Scene, section: Section, ax: Axes) -> tuple[list, dict[str, Shape]]:
    """Draw detectors over their surfaces, those at a point as a disk; what covers all of space has no place."""
    handles, missing = [], {}
    for detector in scene.detectors:
        shape = shape_of(scene, detector)
        if shape is None:
            continue
        colour = METERS[len(handles) % len(METERS)]
        places = _draw_shape(shape, section, ax, colour, 6.0, 2, "//")
        if places is None:
            missing[detector.name] = shape
        else:
            _draw_arrow(places, colour, shape, getattr(detector, "side", None), section, ax)
            handles.append(_handle(colour, f"{type(detector).__name__} {detector.name}"))
    return _few(handles, "detectors"), missing


def _few(handles: list[Line2D], what: str) -> list:
    """The first entries of the legend, and how many others there are."""
    more = len(handles) - MOST_NAMED
    others = [Patch(facecolor="none", edgecolor="none", label=f"and {more} more {what}")] if more > 0 else []
    return [*handles[:MOST_NAMED], *others]


def _draw_shape(
    shape: Shape, section: Section, ax: Axes, colour: str, size: float, order: int, hatch: str | None = None
) -> np.ndarray | None:
    """Draw a shape by dots of a size, a flat one within the plane and a cloud by their area, a point by a disk.

    Return the places (n, 2) [m]; None where nothing is seen.
    """
    if not section.meets(shape):
        return None
    axes = list(section.axes[:2])
    low, high = (corner[axes] for corner in section.bounds)
    style = {"linestyle": "", "marker": "s", "ms": size, "mew": 0, "color": colour, "zorder": order}
    if isinstance(shape, Cloud) or section.holds(shape):
        areas = _areas(shape, section)
        places = areas.reshape(-1, 2)
        if not ((places.min(axis=0) < high) & (places.max(axis=0) > low)).all():
            return None
        _fill(areas, ax, colour, hatch)
        if np.ptp(places, axis=0).max() < SMALLEST * section.size:
            ax.plot(*places.mean(axis=0), **style)
        return places
    if isinstance(shape, Point):
        places = np.array(shape.middle)[None, axes]
        style |= {"marker": "o", "ms": 9, "mew": 1, "mec": "white", "zorder": 6}
    else:
        places = np.stack(section.crossings(shape), axis=-1)
    places = places[((low <= places) & (places <= high)).all(axis=1)]
    if len(places) == 0:
        return None
    ax.plot(*places.T, **style)
    return places


def _fill(areas: np.ndarray, ax: Axes, colour: str, hatch: str | None) -> None:
    """Fill polygons (n, corners, 2) [m] by a pale colour, or hatch them above what is filled."""
    if hatch is None:
        pale = PALE + (1 - PALE) * np.array(to_rgb(colour))
        look = {"facecolor": pale, "edgecolor": pale, "lw": 0.5, "zorder": 0.1}
    else:
        look = {"facecolor": "none", "edgecolor": colour, "lw": 0, "hatch": hatch, "zorder": 0.2}
    outline = Path.make_compound_path(*(Path(corners, closed=False) for corners in areas))
    with matplotlib.rc_context({"hatch.color": colour, "hatch.linewidth": 2.0}):
        ax.add_patch(PathPatch(outline, **look))


def _areas(shape: Shape, section: Section) -> np.ndarray:
    """Polygons (n, corners, 2) [m] of a flat shape within the plane, and of most of a cloud where the plane cuts it."""
    axes = list(section.axes[:2])
    if isinstance(shape, Cloud):
        height = (section.at - shape.middle[section.axes[2]]) / section.depth(shape)
        turns = np.linspace(0, 2 * math.pi, 180)
        rim = np.stack([np.cos(turns), np.sin(turns)], axis=-1) * math.sqrt(1 - height**2)
        return (np.array(shape.middle)[axes] + CLOUD_SIGMAS * np.array(shape.sigma)[axes] * rim)[None]
    facets = facets_of(shape, None, section.bounds)
    return facets.points[facets.faces][..., axes]


def _draw_arrow(
    places: np.ndarray, colour: str, shape: Shape, side: str | None, section: Section, ax: Axes
) -> None:
    """Draw an arrow from the middle of a flat shape to the side that it emits from or counts at."""
    if not shape.is_flat or side is None:
        return
    sign = 1.0 if side in ("front", "outside") else -1.0
    along, up = (sign * shape.normal[axis] for axis in section.axes[:2])
    length = ARROW * section.size
    x, y = places.mean(axis=0)
    if np.hypot(along, up) > STEEP:
        style = {"arrowstyle": "-|>", "color": colour, "lw": 2, "mutation_scale": 16}
        ax.annotate("", (x + length * along, y + length * up), (x, y), arrowprops=style, zorder=5)


def _handle(colour: str, text: str) -> Line2D:
    """An entry of the legend."""
    style = {"linestyle": "", "marker": "s", "ms": 9, "mew": 0, "color": colour}
    return Line2D([], [], label=as_it_stands(text), **style)
