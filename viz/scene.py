"""A scene in space: surfaces coloured by what falls on them, glowing sources, named detectors, media, and tracks.

`draw_scene` returns a plotter to look around in and writes a picture if asked; `scene_blocks` returns the same things for
ParaView. Nothing is simulated here: colours come from a result, tracks from `transport.analysis.tracks`.
"""

from __future__ import annotations

import math
import os
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from transport.analysis.tracks import Tracks
from transport.geometry.shape import Point
from transport.geometry.solid import Box
from transport.results.result import Result
from transport.scene.cameras import ORTHOGRAPHIC, THIN_LENS, Camera, LightField
from transport.scene.media import Grid
from transport.scene.projections import PINHOLE, radial_rays
from transport.scene.scene import Scene
from transport.statistics.notation import with_thousands_spaces
from transport.viz import scene_style as style
from transport.viz.facets import Bounds, level_lines, segments
from transport.viz.scene_camera import VIEW_ANGLE, View, view_of
from transport.viz.scene_parts import (
    BACK,
    FRONT,
    MIN_HITS,
    NOWHERE,
    SYMBOLS,
    Frame,
    Part,
    block_names,
    frame_of,
    is_hazed,
    large_surfaces,
    parts_of,
)
from transport.viz.screen import require_screen
from transport.viz.style import unit_label
from transport.viz.wording import as_it_stands, lengths_text

if TYPE_CHECKING:
    import pyvista

WINDOW = (1400, style.HEIGHT)
MAX_OPACITY, MIN_OPACITY = 0.75, 0.02  # of a few tracks, and of very many
OPAQUE_TRACKS = 60.0  # number of tracks up to which each has the largest opacity
MAX_SMOOTHED = 20_000  # flights
TRACK_WIDTH = 1.2  # [pixels]
# ratios of the largest to the smallest weight: above the first they are drawn, up to the second they are equal
UNLIKE, EQUAL = 1.2, 1.01
SMOOTHING = 1.9  # factor by which lines would be finer in smoothed pictures
BARS = {0: (), 1: ((0.36, 0.5),), 2: ((0.64, 0.23), (0.36, 0.18))}  # lower ends and heights, by their number
APART = 4e-4  # of the picture's size: distance from a wall of what lies on it
HALO = ((30, 0.08), (19, 0.18), (9, 1.0))  # size [pixels] and opacity of the discs of a small glow
RIM = ((11.0, 0.10), (6.0, 0.20), (2.0, 0.9))  # width [pixels] and opacity of the lines of a large one
SMALL = 0.02  # of the picture's size: smaller things are marked by a dot
CULLED = {FRONT: "back", BACK: "front", None: None}  # facets that are left out, by the side that is shown
HAZE = (0.10, 0.55)  # opacity of the thinnest and the thickest medium
MAX_DEPTH = 1.5  # mean optical depth of drawn voxels; denser ones are drawn thinner
RIM_STEPS = 8  # points along each side of what a camera sees
VOXEL_STEPS = 80  # of opacity along a way through voxels
RIGHT = 0.9  # of the window: names that would end farther right end at their place
MAX_CHI_SQUARED = 2.0  # per value, of values that agree with their mean
MAX_NAME = 40  # characters of a detector's name
FLAT_LOOK = {"lighting": False, "show_scalar_bar": False}


def draw_scene(
    scene: Scene,
    result: Result | None = None,
    tracks: Tracks | None = None,
    path: str | os.PathLike | None = None,
    *,
    title: str | None = None,
    off_screen: bool = True,
    window_size: tuple[int, int] = WINDOW,
    quantity: str | None = None,
    whole: bool = False,
) -> pyvista.Plotter:
    """Draw a scene in 3-D, in metres.

    Parameters
    ----------
    scene : Scene
        What to draw.
    result : Result, optional
        Colours surfaces with detectors by irradiance or exitance, and cuts through volumes by fluence rate.
    tracks : Tracks, optional
        Drawn as lines, coloured by weight if it varies by more than a fifth, or by age if all weights are equal.
    path : path, optional
        PNG to write; the plotter is closed then.
    title : str, optional
        Heading.
    off_screen : bool, default True
        Whether to open no window.
    window_size : two ints
        Width and height [pixels].
    quantity : {"irradiance", "exitance", "fluence_rate"}, optional
        Colour by this quantity only.
    whole : bool, default False
        Draw also sources so far away that all else is a dot.

    Returns
    -------
    pyvista.Plotter
        To show, export and close.

    Raises
    ------
    NoScreen
        If this machine cannot draw.
    """
    require_screen()
    plotter, _ = plot_unrendered(
        scene, result, tracks, off_screen=off_screen, window_size=window_size, quantity=quantity, whole=whole
    )
    if title:
        style.write(plotter, title, (0.022, 0.935), 16)
    if path is not None:
        _smooth(plotter)
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        plotter.screenshot(path, return_img=False)
        plotter.close()
    return plotter


def plot_unrendered(
    scene: Scene,
    result: Result | None = None,
    tracks: Tracks | None = None,
    *,
    off_screen: bool = True,
    window_size: tuple[int, int] = WINDOW,
    quantity: str | None = None,
    whole: bool = False,
) -> tuple[pyvista.Plotter, str]:
    """Return the plotter of `draw_scene`, also on machines that cannot draw it, and its caption."""
    import pyvista

    frame = frame_of(scene, tracks, whole)
    parts = parts_of(scene, frame, result, quantity)
    plotter = pyvista.Plotter(off_screen=off_screen, window_size=list(window_size))
    plotter.set_background(style.GROUND)
    has_bars = add_parts(plotter, scene, parts, frame)
    if tracks is not None:
        add_tracks(plotter, tracks, frame.margins, has_bars)
    _set_camera(plotter, parts, frame, window_size[0] / window_size[1])
    caption = caption_of(scene, result, tracks, parts, frame)
    style.write(plotter, as_it_stands(caption), (0.022, 0.018), 9, style.FAINT)
    return plotter, caption


def scene_blocks(
    scene: Scene,
    result: Result | None = None,
    tracks: Tracks | None = None,
    *,
    quantity: str | None = None,
    whole: bool = False,
) -> pyvista.MultiBlock:
    """Return named blocks [m] for ParaView, with readings as cell arrays such as "irradiance" and "irradiance error".

    Arguments are those of `draw_scene`. Needs pyvista, but no screen.
    """
    import pyvista

    frame = frame_of(scene, tracks, whole)
    parts = parts_of(scene, frame, result, quantity)
    blocks = pyvista.MultiBlock()
    for name, part in zip(block_names(parts), parts, strict=True):
        is_grid = part.kind == "cells" and isinstance(part.shape, Box)
        blocks.append(part.grid() if is_grid else part.drawn(), name)
    if tracks is not None:
        blocks.append(track_lines(tracks, frame.margins), "tracks")
    return blocks


def caption_of(
    scene: Scene, result: Result | None, tracks: Tracks | None, parts: list[Part], frame: Frame
) -> str:
    """Return one line: the size of the scene, what is drawn, and the number of histories."""
    painted = [part for part in parts if part.paint is not None]
    limited = dict.fromkeys((part.name, part.paint.only) for part in painted if part.paint.only)
    cuts = [part for part in painted if part.kind == "cells"]
    unlike = {
        "behind a haze": painted and any(is_hazed(part, parts) for part in parts),
        "of what is seen through": any(part.opacity < 1 for part in painted),
    }
    unlike_bar = " and ".join(name for name, is_so in unlike.items() if is_so)
    large, medium = large_surfaces(scene, frame), scene.medium
    pieces = [
        lengths_text(frame.high - frame.low),
        result is not None and f"{with_thousands_spaces(result.particles)} histories",
        tracks is not None and f"{with_thousands_spaces(len(np.unique(tracks.histories)))} tracks drawn",
        not all(part.paint.is_known.all() for part in painted)
        and f"cells with fewer than {MIN_HITS} hits grey",
        *(f"of {name} only what counts with {limits}" for name, limits in limited),
        *(
            f"{part.name} cut through its {'brightest cell' if isinstance(part.shape, Box) else 'middle'}"
            for part in cuts
        ),
        *(f"{symbol} differs by no more than its errors" for symbol in _uniform(painted)),
        unlike_bar and f"colours {unlike_bar} are not the bar's",
        large and f"not drawn, far larger: {', '.join(large)}",
        medium is not None
        and medium.extinction > 0
        and f"a medium of {medium.extinction:.3g} m⁻¹ everywhere",
    ]
    return style.BETWEEN.join(piece for piece in pieces if piece)


def _uniform(painted: list[Part]) -> Iterator[str]:
    """Yield the symbol of each bar whose values agree with one value within their errors, by chi squared."""
    for is_cells in (False, True):
        paints = [part.paint for part in painted if (part.kind == "cells") == is_cells]
        columns = [(paint.values[paint.is_known], paint.errors[paint.is_known]) for paint in paints]
        values, errors = np.concatenate(columns, axis=1) if columns else np.zeros((2, 0))
        has_error = np.isfinite(errors) & (errors > 0)
        weights = 1 / errors[has_error] ** 2
        if len(weights) > 1:
            mean = np.average(values[has_error], weights=weights)
            if np.mean((values[has_error] - mean) ** 2 * weights) < MAX_CHI_SQUARED:
                yield SYMBOLS[paints[0].quantity]


def add_parts(plotter: pyvista.Plotter, scene: Scene, parts: list[Part], frame: Frame) -> bool:
    """Draw all parts, distant sources, and colour bars; return whether there are any."""
    painted: dict[bool, tuple[object, Part, style.Scale]] = {}
    for is_cells in (False, True):
        alike = [part for part in parts if (part.kind == "cells") == is_cells]
        values = [part.paint.values[part.paint.is_known] for part in alike if part.paint is not None]
        scale = style.logarithmic(np.concatenate(values)) if values else None
        for part in alike:
            _ADDERS[part.kind](plotter, part, parts, scale is not None)
            if part.paint is not None and scale is not None and part.seen_from != NOWHERE:
                painted[is_cells] = _paint(plotter, part, scale), part, scale
    _add_distant(plotter, scene, frame)
    for (low, height), (actor, part, scale) in zip(BARS[len(painted)], painted.values(), strict=True):
        unit = unit_label(part.paint.unit).strip("$")
        title = rf"${SYMBOLS[part.paint.quantity]}\;[{unit}]$"
        style.add_bar(plotter, actor, title, scale, (0.91, low), height)
    return bool(painted)


def _smooth(plotter: pyvista.Plotter) -> None:
    """Draw at several times the resolution and shrink; lines and dots keep their widths.

    Volumes do not support it, and very many tracks do not need it.
    """
    tracks = plotter.actors.get("tracks")
    are_many = tracks is not None and tracks.mapper.dataset.n_cells > MAX_SMOOTHED
    if are_many or plotter.renderer.GetVolumes().GetNumberOfItems():
        return
    plotter.enable_anti_aliasing("ssaa")
    for actor in plotter.actors.values():
        look = getattr(actor, "prop", None)
        if hasattr(look, "line_width"):
            look.line_width, look.point_size = SMOOTHING * look.line_width, SMOOTHING * look.point_size


def _set_camera(plotter: pyvista.Plotter, parts: list[Part], frame: Frame, aspect: float) -> None:
    """Set the camera; add the names of detectors, and small axes in a corner."""
    view = view_of(parts, frame, aspect)
    plotter.camera.position, plotter.camera.focal_point, plotter.camera.up = view
    plotter.camera.view_angle = VIEW_ANGLE
    plotter.camera.SetWindowCenter(0.06, 0.03)
    plotter.reset_camera_clipping_range()
    labels = {part.name: label_of(part, view) for part in parts if part.kind == "detector"}
    _add_labels(plotter, [label for label in labels.values() if label is not None], style.DETECTOR)
    plotter.add_axes(color=style.FAINT, line_width=2, viewport=(0.0, 0.05, 0.11, 0.22))


# ---- The parts, by their kind.


def _add_surface(plotter: pyvista.Plotter, part: Part, parts: list[Part], is_scaled: bool) -> None:
    """A wall, a mirror or a pane, unless it is painted."""
    if not part.is_other_side:
        _add_lines(plotter, part.outline, style.FAINT, 1.2, 0.5)
    if part.paint is not None and is_scaled:
        if not part.has_bins:
            lift = APART * part.frame.size * (-1 if part.seen_from == BACK else 1)
            _add_lines(plotter, level_lines(part.drawn(), lift), style.GROUND, 1.2, 0.5)
        return
    if part.seen_from == NOWHERE or len(part.facets.faces) == 0 or (part.paint is None and part.is_bare):
        return
    look = {"color": style.WALL, "ambient": 0.35, "diffuse": 0.65}
    if part.is_mirror:
        look = {"color": style.STEEL, "ambient": 0.25, "diffuse": 0.5, "specular": 0.7, "specular_power": 30}
    if part.is_clear:
        look = {"color": style.GLASS, "opacity": 0.13, "ambient": 0.5}
    plotter.add_mesh(part.drawn(), culling=CULLED[part.seen_from], show_scalar_bar=False, **look)


def _add_medium(plotter: pyvista.Plotter, part: Part, parts: list[Part], is_scaled: bool) -> None:
    """A translucent body, denser with its extinction; voxels as a volume."""
    medium = part.what
    if len(part.facets.faces) == 0 or not is_hazed(part, parts):
        return
    if isinstance(medium, Grid) and part.shape == medium.box:
        _add_voxels(plotter, medium)
        return
    across = 2 * part.shape.extent if np.isfinite(part.shape.extent) else part.frame.size
    low, high = HAZE
    opacity = low + (high - low) * -np.expm1(-float(np.mean(medium.extinction)) * across)
    colour = style.GLOWING if medium.emission > 0 else style.FOG
    # Only the far side, so that the inside keeps its colours.
    plotter.add_mesh(part.drawn(), culling="front", color=colour, opacity=opacity, **FLAT_LOOK)


def _add_voxels(plotter: pyvista.Plotter, grid: Grid) -> None:
    """The extinction of each voxel as a fog that hides as much as it does, up to a depth."""
    import pyvista

    extinction = grid.extinction
    highest = float(extinction.max())
    if highest == 0:
        return
    step = float(np.linalg.norm(grid.box.size)) / VOXEL_STEPS
    thinned = min(1.0, MAX_DEPTH / (extinction.mean() * np.cbrt(grid.box.volume)))
    image = pyvista.ImageData(
        dimensions=np.add(extinction.shape, 1),
        spacing=np.divide(grid.box.size, extinction.shape),
        origin=grid.box.bounds[0],
    )
    image.cell_data["extinction"] = (extinction / highest).ravel(order="F")
    plotter.add_volume(
        image.cell_data_to_point_data(),
        scalars="extinction",
        clim=(0.0, 1.0),
        cmap=[style.FOG, "#f4f7fb"],
        opacity=-np.expm1(-np.linspace(0, 1, 64) * thinned * highest * step),
        opacity_unit_distance=step,
        show_scalar_bar=False,
    )


def _add_source(plotter: pyvista.Plotter, part: Part, parts: list[Part], is_scaled: bool) -> None:
    """Bright where it emits, with a glowing rim; a small one as a glowing dot, a volume as a haze."""
    if _is_small(part):
        _add_glow(plotter, np.array(part.shape.middle))
    if isinstance(part.shape, Point):
        return
    for width, opacity in RIM:
        _add_lines(plotter, lifted(part.outline, part, 2), style.GLOW, width, opacity)
    if part.is_on_surface:  # the paint shows how bright it is
        return
    look = {"color": style.GLOW} | FLAT_LOOK
    if not part.what.emission.has_side:
        plotter.add_mesh(part.drawn(), opacity=0.12, **look)
        return
    drawn = lifted(part.drawn(), part, 2)
    plotter.add_mesh(drawn, culling=CULLED[part.side], **look)
    plotter.add_mesh(drawn, culling=part.side, opacity=0.10, **look)


def _add_detector(plotter: pyvista.Plotter, part: Part, parts: list[Part], is_scaled: bool) -> None:
    """An outline; a small one as a dot, a camera or a light field with what it sees."""
    if part.shape.is_infinite:
        return
    if _is_small(part):
        _add_dot(plotter, np.array(part.shape.middle), style.DETECTOR, 9)
    if isinstance(part.what, Camera | LightField):
        _add_lines(plotter, _view_lines(part.what, 0.12 * part.frame.size), style.DETECTOR, 1.6)
    if len(part.facets.faces):
        width, opacity = (1.4, 0.6) if part.is_on_surface else (2.2, 1.0)
        _add_lines(plotter, lifted(part.outline, part, 1), style.DETECTOR, width, opacity)


_ADDERS = {
    "surface": _add_surface,
    "medium": _add_medium,
    "cells": lambda plotter, part, parts, is_scaled: None,
    "detector": _add_detector,
    "source": _add_source,
}


def _is_small(part: Part) -> bool:
    return isinstance(part.shape, Point) or part.shape.extent < SMALL * part.frame.size


def _paint(plotter: pyvista.Plotter, part: Part, scale: style.Scale) -> object:
    """Colour a part by what was read; cells of few hits are grey."""
    paint, drawn = part.paint, part.drawn()
    values = np.append(np.where(paint.is_known, paint.values, np.nan), np.nan)[part.facets.bins]
    return style.add_coloured(
        plotter,
        lifted(drawn, part, 1) if part.kind == "detector" else drawn,
        values,
        scale,
        style.IN_VOLUMES if part.kind == "cells" else style.ON_SURFACES,
        culling=CULLED[part.seen_from],
        opacity=part.opacity,
    )


def lifted(drawn: pyvista.PolyData, part: Part, steps: float) -> pyvista.PolyData:
    """Return a copy off the wall on which it lies, towards the side that counts."""
    areas, drawn = part.facets.vector_areas, drawn.copy()
    if len(areas) == 0 or drawn.n_points == 0 or (part.side is None and part.kind != "detector"):
        return drawn
    shift = steps * APART * part.frame.size * (-1.0 if part.side == BACK else 1.0)
    whole = areas.sum(axis=0)
    if np.linalg.norm(whole) > 0.999 * np.linalg.norm(areas, axis=1).sum():  # flat
        drawn.points = drawn.points + shift * whole / np.linalg.norm(whole)
    else:
        middle = np.array(part.shape.middle)
        drawn.points = middle + (drawn.points - middle) * (1 + shift / max(part.shape.extent, abs(shift)))
    return drawn


def _add_distant(plotter: pyvista.Plotter, scene: Scene, frame: Frame) -> None:
    """A dashed line towards each source outside the picture, and its distance."""
    for number, place in frame.distant.items():
        distance = np.linalg.norm(place - frame.middle)
        way = (place - frame.middle) / distance
        marks = frame.middle + way * frame.size * np.linspace(0.25, 0.5, 12)[:, None]
        _add_lines(plotter, segments(marks.reshape(-1, 2, 3)), style.GLOW, 2.5)
        _add_glow(plotter, marks[-1])
        text = f"source {number}, {lengths_text([distance])} away"
        _add_labels(plotter, [(marks[-1], text)], style.GLOW)


def _add_lines(
    plotter: pyvista.Plotter, lines: pyvista.PolyData, colour: str, width: float, opacity: float = 1.0
) -> None:
    if lines.n_points:
        plotter.add_mesh(lines, color=colour, line_width=width, opacity=opacity, lighting=False)


def _add_dot(
    plotter: pyvista.Plotter, place: np.ndarray, colour: str, size: float, opacity: float = 1.0
) -> None:
    look = {"render_points_as_spheres": True, "lighting": False}
    plotter.add_points(place[None], color=colour, point_size=size, opacity=opacity, **look)


def _add_glow(plotter: pyvista.Plotter, place: np.ndarray) -> None:
    for size, opacity in HALO:
        _add_dot(plotter, place, style.GLOW, size, opacity)


def _view_lines(view: Camera | LightField, size: float) -> pyvista.PolyData:
    """What a camera sees: rays from its corners and a rim; of a light field both planes."""
    left, up, ahead = (np.array(axis) for axis in view.frame)
    place, edges = np.array(view.position), view.edges()
    axes, share = (
        (("u", "v"), np.linspace(0, 1, RIM_STEPS, endpoint=False))
        if isinstance(view, Camera)
        else (("s", "t"), np.zeros(1))
    )
    (u0, u1), (v0, v1) = (edges[name][[0, -1]] for name in axes)
    u = np.concatenate([u0 + share * (u1 - u0), u1 + 0 * share, u1 + share * (u0 - u1), u0 + 0 * share])
    v = np.concatenate([v0 + 0 * share, v0 + share * (v1 - v0), v1 + 0 * share, v1 + share * (v0 - v1)])
    across = u[:, None] * -left + v[:, None] * up
    near, rim = np.repeat(place[None], len(u), axis=0), place + across + size * ahead
    if isinstance(view, LightField):
        width, height = view.size
        near = place + np.sign(u)[:, None] * -left * width / 2 + np.sign(v)[:, None] * up * height / 2
        rim = place + across + view.distance * ahead
    elif view.lens == ORTHOGRAPHIC:
        near = place + across
    else:
        seen = radial_rays(PINHOLE if view.lens == THIN_LENS else view.lens, u, v)
        rim = place + size * seen @ np.array((-left, up, ahead))
    corners = np.stack([near, rim], axis=1)[:: len(share)]
    rims = [np.stack([each, np.roll(each, -1, axis=0)], axis=1) for each in (near, rim)]
    return segments(np.concatenate([corners, *rims]))


# ---- Names.


def label_of(part: Part, view: View) -> tuple[np.ndarray, str] | None:
    """Return where to write the name of a detector [m], at the highest place of its outline farthest right, and the text."""
    points = next((p for p in (part.outline.points, part.facets.points) if len(p)), None)
    if points is None:
        return None
    right = np.cross(view.up, view.position - view.focus)
    right, height = (
        np.round(points @ way / np.linalg.norm(way) / part.frame.size, 6) for way in (right, view.up)
    )
    place = points[np.lexsort((-right, -height))[0]]
    name = textwrap.shorten(part.name, MAX_NAME, placeholder=" …")
    return place, name if part.number is None else f"{name}   {style.short_estimate(part.number)}"


def _add_labels(plotter: pyvista.Plotter, labels: list[tuple[np.ndarray, str]], colour: str) -> None:
    """Write text at places in space, ending there at the right of the window; overlapping text is left out."""
    if not labels:
        return
    places = np.array([place for place, _ in labels], dtype=float)
    texts = np.array([as_it_stands(text) for _, text in labels])
    size = style.type_size(plotter, 15, style.LEGIBLE)
    # Project the places into the window.
    matrix = plotter.camera.GetCompositeProjectionTransformMatrix(
        plotter.window_size[0] / plotter.window_size[1], -1, 1
    )
    matrix = np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])
    projected = np.column_stack([places, np.ones(len(places))]) @ matrix.T
    ends = 0.5 + 0.5 * projected[:, 0] / projected[:, 3]
    ends += [style.text_width(plotter, text, size) for text in texts]
    for chosen, side in ((ends <= RIGHT, "left"), (ends > RIGHT, "right")):
        if chosen.any():
            plotter.add_point_labels(
                places[chosen],
                list(texts[chosen]),
                justification_horizontal=side,
                font_size=size,
                bold=False,
                text_color=colour,
                font_file=style.font(),
                shape="rounded_rect"
                if side == "left"
                else None,  # at the right it would not lie below the text
                shape_color=style.GROUND,
                shape_opacity=0.55,
                margin=3,
                show_points=False,
                always_visible=True,
            )


# ---- Tracks.


def track_lines(tracks: Tracks, bounds: Bounds) -> pyvista.PolyData:
    """Return each flight's part in the box as a line [m]; cell arrays "weight", "age" [m] (half-way) and "history"."""
    first, last = clipped(tracks, bounds)
    inside = np.flatnonzero(first < last)
    starts, ways = tracks.starts[inside], tracks.directions[inside]
    ends = [starts + along[inside, None] * ways for along in (first, last)]
    lines = segments(np.stack(ends, axis=1))
    lines.cell_data["weight"] = tracks.weights[inside]
    lines.cell_data["age"] = tracks.ages[inside] + (first[inside] + last[inside]) / 2
    lines.field_data["unit of age"] = ["m"]
    lines.cell_data["history"] = tracks.histories[inside].astype(np.int64)
    return lines


def clipped(tracks: Tracks, bounds: Bounds) -> tuple[np.ndarray, np.ndarray]:
    """Return where along each flight [m] it enters and leaves the box; outside, the first is not below the last."""
    first, last = np.zeros(len(tracks)), tracks.lengths.copy()
    for axis, (low, high) in enumerate(zip(*bounds, strict=True)):
        here, way = tracks.starts[:, axis], tracks.directions[:, axis]
        with np.errstate(divide="ignore", invalid="ignore"):
            one, other = (low - here) / way, (high - here) / way
        is_parallel = way == 0
        first = np.where(is_parallel, first, np.fmax(first, np.fmin(one, other)))
        last = np.where(is_parallel, last, np.fmin(last, np.fmax(one, other)))
        last = np.where(is_parallel & ((here < low) | (here > high)), -1.0, last)
    return first, last


def track_colours(lines: pyvista.PolyData) -> tuple[str, style.Scale] | None:
    """Return "weight" with its scale if it varies by more than a fifth, "age" if it varies and no weight does, else None."""
    for name, scale_of, unlike in (("weight", style.logarithmic, UNLIKE), ("age", style.linear, EQUAL)):
        values = lines.cell_data[name]
        positive = values[values > 0]
        ratio = positive.max() / positive.min() if len(positive) else 1.0
        if ratio > unlike:
            return name, scale_of(values)
        if ratio > EQUAL:
            return None
    return None


def layers_of(lines: pyvista.PolyData, bounds: Bounds) -> float:
    """Return how many lines lie over each other on average, where they are seen from their broad side."""
    ends = lines.points.reshape(-1, 2, 3)
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    breadths = math.sqrt(12) * np.linalg.svd(lines.points - lines.points.mean(axis=0), compute_uv=False)[:2]
    area = np.prod(breadths / math.sqrt(lines.n_points))
    width = TRACK_WIDTH / style.HEIGHT * np.linalg.norm(bounds[1] - bounds[0])
    return float(lengths.sum() * width / area) if area > 0 else 1.0


def add_tracks(plotter: pyvista.Plotter, tracks: Tracks, bounds: Bounds, has_bars: bool) -> None:
    """Draw thin lines, fainter for more tracks; `has_bars`: whether there are other colour bars."""
    lines = track_lines(tracks, bounds)
    if lines.n_cells == 0:
        return
    count = len(np.unique(lines.cell_data["history"]))
    opacity = MAX_OPACITY * (OPAQUE_TRACKS / count) ** 0.6 / math.sqrt(max(1.0, layers_of(lines, bounds)))
    opacity = float(np.clip(opacity, MIN_OPACITY, MAX_OPACITY))
    look = {"opacity": opacity, "line_width": TRACK_WIDTH, "name": "tracks"}
    if (colours := track_colours(lines)) is None:
        plotter.add_mesh(lines, color=style.TRACK, lighting=False, **look)
        return
    name, scale = colours
    actor = style.add_coloured(plotter, lines, lines.cell_data[name], scale, style.ON_TRACKS, **look)
    title = r"$\mathrm{weight}$" if name == "weight" else r"$\mathrm{age}\;[\mathrm{m}]$"
    place, height = ((0.91, 0.07), 0.19) if has_bars else ((0.91, 0.30), 0.4)
    style.add_bar(plotter, actor, title, scale, place, height)
