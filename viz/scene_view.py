"""A scene in space: surfaces coloured by what falls on them, sources glowing, detectors named, media, and some tracks.

`scene_view` writes a picture, `scene_plotter` gives what to look round in, `scene_blocks` the same things for ParaView.
Nothing is simulated here: the colours are of a result, and the tracks are those of `transport.analysis.tracks`.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from transport.analysis.tracks import Tracks
from transport.geometry.solid import Box
from transport.results.result import Result
from transport.scene.scene import Scene
from transport.viz import night
from transport.viz.painted import LEAST_HITS, OF_VOLUMES, SYMBOLS
from transport.viz.scene_camera import VIEW_ANGLE, view_of
from transport.viz.scene_frame import Frame, frame_of
from transport.viz.scene_parts import Part, block_names, is_hazed, left_out, parts_of
from transport.viz.scene_things import (
    add_cells,
    add_detector,
    add_distant,
    add_labels,
    add_medium,
    add_source,
    add_surface,
    known,
    name_of,
    opacity_of,
)
from transport.viz.screen import require_screen
from transport.viz.style import unit_label
from transport.viz.track_lines import told_by, track_lines
from transport.viz.volume_cuts import grid_of_cells
from transport.viz.wording import as_it_stands, lengths_text

if TYPE_CHECKING:
    import pyvista

WINDOW = (1400, night.HEIGHT)
AGE, WEIGHT = r"$\mathrm{age}\;[\mathrm{m}]$", r"$\mathrm{weight}$"
FULL, FEWEST = 0.75, 0.02  # opacity of a few tracks, and of very many
MOST_SMOOTHED = 20_000  # flights
SMOOTHED = 1.9  # how much finer lines would be where pictures are smoothed
CLEAR_OF = 60.0  # tracks that may all be drawn at the full opacity
BARS = {0: (), 1: ((0.36, 0.5),), 2: ((0.64, 0.23), (0.36, 0.18))}  # lower ends and heights, by their number

_ADDERS = {
    "surface": add_surface,
    "medium": add_medium,
    "cells": add_cells,
    "detector": add_detector,
    "source": add_source,
}


def scene_plotter(
    scene: Scene,
    result: Result | None = None,
    tracks: Tracks | None = None,
    *,
    off_screen: bool = True,
    window_size: tuple[int, int] = WINDOW,
    quantity: str | None = None,
    whole: bool = False,
) -> pyvista.Plotter:
    """A pyvista.Plotter that shows the scene, in metres; the caller shows, exports and closes it.

    result: whose irradiance (or exitance) colours the surfaces that detectors look at, and whose fluence rate cuts through
    volumes;  quantity: "irradiance", "exitance" or "fluence_rate" alone;  tracks: drawn as lines, coloured by weight, or by age where all weigh the same;  whole: with sources that
    lie so far away that all else would be a dot.  Raises NoScreen where nothing can be drawn.
    """
    require_screen()
    return undrawn_plotter(
        scene, result, tracks, off_screen=off_screen, window_size=window_size, quantity=quantity, whole=whole
    )


def undrawn_plotter(
    scene: Scene,
    result: Result | None = None,
    tracks: Tracks | None = None,
    *,
    off_screen: bool = True,
    window_size: tuple[int, int] = WINDOW,
    quantity: str | None = None,
    whole: bool = False,
) -> pyvista.Plotter:
    """What `scene_plotter` gives, on machines as well that cannot draw it."""
    import pyvista

    frame = frame_of(scene, tracks, whole)
    parts = parts_of(scene, frame, result, quantity)
    plotter = pyvista.Plotter(off_screen=off_screen, window_size=list(window_size))
    plotter.set_background(night.GROUND)
    scale = _add_parts(plotter, scene, parts, frame)
    if tracks is not None:
        _add_tracks(plotter, tracks, frame, beside=scale is not None)
    _look(plotter, parts, frame, window_size)
    caption = as_it_stands(caption_of(scene, result, tracks, parts, frame))
    night.write(plotter, caption, (0.022, 0.018), 9, night.FAINT)
    return plotter


def scene_view(
    scene: Scene,
    path: str | os.PathLike,
    result: Result | None = None,
    tracks: Tracks | None = None,
    title: str | None = None,
    **more: object,
) -> str | os.PathLike:
    """Write the picture of `scene_plotter` as a PNG; returns `path`.  more: as for `scene_plotter`."""
    plotter = scene_plotter(scene, result, tracks, **more)
    if title:
        night.write(plotter, title, (0.022, 0.935), 16)
    _smooth(plotter)
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    plotter.screenshot(path, return_img=False)
    plotter.close()
    return path


def _smooth(plotter: pyvista.Plotter) -> None:
    """Draw at several times the resolution and shrink; lines and dots keep their widths.

    Volumes do not go with it, and very many tracks do not need it.
    """
    tracks = plotter.actors.get("tracks")
    is_full = tracks is not None and tracks.mapper.dataset.n_cells > MOST_SMOOTHED
    if is_full or plotter.renderer.GetVolumes().GetNumberOfItems():
        return
    plotter.enable_anti_aliasing("ssaa")
    for actor in plotter.actors.values():
        look = getattr(actor, "prop", None)
        if hasattr(look, "line_width"):
            look.line_width, look.point_size = SMOOTHED * look.line_width, SMOOTHED * look.point_size


def scene_blocks(
    scene: Scene, result: Result | None = None, tracks: Tracks | None = None, **more: object
) -> pyvista.MultiBlock:
    """Named blocks [m] with what was read as cell arrays, such as "irradiance" and "irradiance error", for ParaView.

    more: `quantity` and `whole` as for `scene_plotter`.  Needs pyvista, and no screen.
    """
    import pyvista

    frame = frame_of(scene, tracks, bool(more.get("whole")))
    parts = parts_of(scene, frame, result, more.get("quantity"))
    blocks = pyvista.MultiBlock()
    for name, part in zip(block_names(parts), parts, strict=True):
        is_grid = part.kind == "cells" and isinstance(part.shape, Box)
        blocks.append(grid_of_cells(part.what, part.shape, part.paint) if is_grid else part.drawn(), name)
    if tracks is not None:
        blocks.append(track_lines(tracks, frame.grown()), "tracks")
    return blocks


def caption_of(
    scene: Scene, result: Result | None, tracks: Tracks | None, parts: list[Part], frame: Frame
) -> str:
    """One line: how large it is, what is drawn, and of how many histories."""
    said = [lengths_text(frame.high - frame.low)]
    if result is not None:
        said.append(f"{result.particles:_} histories".replace("_", " "))
    if tracks is not None:
        said.append(f"{len(np.unique(tracks.histories)):_} tracks drawn".replace("_", " "))
    painted = [part for part in parts if part.paint is not None]
    if any((known(part) == 0).any() for part in painted):
        said.append(f"cells with fewer than {LEAST_HITS} hits grey")
    limited = dict.fromkeys((part.name, part.paint.only) for part in painted if part.paint.only)
    said += [f"of {name} only what counts with {limits}" for name, limits in limited]
    for part in painted:
        if part.kind == "cells":
            said.append(
                f"{part.name} cut through its {'brightest cell' if isinstance(part.shape, Box) else 'middle'}"
            )
    mixed = {
        "behind a haze": painted and any(is_hazed(part, parts) for part in parts),
        "of what is seen through": any(opacity_of(part) < 1 for part in painted),
    }
    if any(mixed.values()):
        said.append(
            f"colours {' and '.join(name for name, is_so in mixed.items() if is_so)} are not the bar's"
        )
    if beyond := left_out(scene, frame):
        said.append(f"not drawn, far larger: {', '.join(beyond)}")
    if scene.medium is not None and scene.medium.extinction > 0:
        said.append(f"a medium of {scene.medium.extinction:.3g} m⁻¹ everywhere")
    return night.BETWEEN.join(said)


def _add_parts(plotter: pyvista.Plotter, scene: Scene, parts: list[Part], frame: Frame) -> night.Scale | None:
    """Draw all parts, and the bars of what was measured; returns a scale of them, None where nothing was."""
    kinds = [[part for part in parts if (part.kind == "cells") == is_cells] for is_cells in (False, True)]
    scales = [_scale_of(some) for some in kinds]
    actors = {}
    for part in parts:
        if part.kind == "medium" and not is_hazed(part, parts):
            continue
        scale = scales[part.kind == "cells"]
        drawn = _ADDERS[part.kind](plotter, part, scale)
        if drawn is not None:
            actors[part.kind == "cells"] = (drawn, part.paint, scale)
    add_distant(plotter, scene, frame)
    for (low, height), (actor, paint, scale) in zip(BARS[len(actors)], actors.values(), strict=True):
        unit = unit_label(paint.unit).strip("$")
        symbol = (SYMBOLS | OF_VOLUMES)[paint.quantity]
        night.add_bar(plotter, actor, rf"${symbol}\;[{unit}]$", scale, (0.91, low), height)
    return next((scale for _, _, scale in actors.values()), None)


def _scale_of(parts: list[Part]) -> night.Scale | None:
    """Whole decades for all that was read on parts, of what is shown of it."""
    values = [part.paint.values[known(part)] for part in parts if part.paint is not None]
    return night.decades(np.concatenate(values)) if values else None


def _add_tracks(plotter: pyvista.Plotter, tracks: Tracks, frame: Frame, beside: bool) -> None:
    """Thin lines, the fainter the more there are; beside: whether the usual place of a bar is taken."""
    lines = track_lines(tracks, frame.grown())
    if lines.n_cells == 0:
        return
    many = len(np.unique(lines.cell_data["history"]))
    opacity = float(np.clip(FULL * (CLEAR_OF / many) ** 0.6, FEWEST, FULL))
    told = told_by(lines)
    look = {"opacity": opacity, "line_width": 1.2, "lighting": False, "name": "tracks"}
    if told is None:
        plotter.add_mesh(lines, color="#ffe7a8", **look)
        return
    values = lines.cell_data[told]
    scale = night.decades(values) if told == "weight" else night.evenly(values)
    lines.cell_data["shown"] = scale.of(values)
    actor = plotter.add_mesh(
        lines,
        scalars="shown",
        cmap=night.WAYS,
        clim=(scale.low, scale.high),
        show_scalar_bar=False,
        **look,
    )
    place = (0.91, 0.07) if beside else (0.91, 0.30)
    night.add_bar(plotter, actor, WEIGHT if told == "weight" else AGE, scale, place, 0.19 if beside else 0.4)


def _look(plotter: pyvista.Plotter, parts: list[Part], frame: Frame, window_size: tuple[int, int]) -> None:
    """Set the camera, and small axes in a corner."""
    view = view_of(parts, frame, window_size[0] / window_size[1])
    plotter.camera.position, plotter.camera.focal_point, plotter.camera.up = view
    plotter.camera.view_angle = VIEW_ANGLE
    plotter.camera.SetWindowCenter(0.06, 0.03)
    plotter.reset_camera_clipping_range()
    labels = {part.name: name_of(part, view.up) for part in parts if part.kind == "detector"}
    add_labels(plotter, [label for label in labels.values() if label is not None], night.METER)
    plotter.add_axes(color=night.FAINT, line_width=2, viewport=(0.0, 0.05, 0.11, 0.22))
