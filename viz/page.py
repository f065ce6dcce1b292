"""A 3-D scene as one HTML file that turns under the mouse in any browser, without a network.

What VTK would draw is stored as triangles, lines and points with the colours that VTK gives them; page.html beside this
file draws them with the browser's WebGL 2. Nothing else is in the file: a page is as large as its scene.
"""

from __future__ import annotations

import base64
import html
import json
import math
import os
import re
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from transport.analysis.tracks import Tracks
from transport.results.result import Result
from transport.scene.scene import Scene
from transport.validation import SceneError
from transport.viz.scene import draw_scene, plot_unrendered
from transport.viz.scene_style import round_marks
from transport.viz.screen import NoScreen, has_display, without_screen

if TYPE_CHECKING:
    import pyvista as pv
    from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
    from vtkmodules.vtkRenderingCore import vtkActor, vtkProp, vtkVolume

TEMPLATE = Path(__file__).with_name("page.html")
BAR_COLOURS = 33
STEEP = 0.99  # cosine between the line of sight and the upward direction above which the camera cannot turn about that
OPAQUE = 255
EDGES, POINTS = 1, 0  # VTK's numbers of an actor's representations
MAX_DEPTH = 400.0  # largest optical depth along a box's diagonal


def scene_page(
    scene: Scene,
    path: str | os.PathLike,
    result: Result | None = None,
    tracks: Tracks | None = None,
    title: str = "A scene",
) -> str | os.PathLike:
    """Write a scene with its result and tracks, as `draw_scene` draws it, as a page that turns; return the path.

    The browser draws it: OpenGL is not needed to write it.
    """
    with without_screen():
        plotter, caption = plot_unrendered(scene, result, tracks)
        try:
            return page(plotter, path, title, caption)
        finally:
            plotter.close()


def view_scene(scene: Scene, path: str | os.PathLike | None = None) -> pv.Plotter | Path:
    """Show a scene in a window, or write a picture or a page; see `Scene.view`."""
    kind = None if path is None else Path(path).suffix.lower()
    if kind not in (None, ".png", ".html"):
        raise SceneError(f"view: path must end in .png or .html, got {str(path)!r}")
    if kind is None and not has_display():
        raise SceneError('view: there is no display to open a window on; write scene.view("scene.html")')
    try:
        if kind == ".html":
            return Path(scene_page(scene, path))
        plotter = draw_scene(scene, path=path, off_screen=kind is not None)
    except NoScreen as error:
        raise SceneError(f"view: {error}") from None
    if kind is not None:
        return Path(path)
    plotter.show()
    return plotter


def page(plotter: pv.Plotter, path: str | os.PathLike, title: str, note: str = "") -> str | os.PathLike:
    """Write what a plotter has in its first renderer as an HTML page; return the path.

    Surfaces, lines, points, their colours, labels, volumes on grids and colour bars are kept; other texts are left out.

    Parameters
    ----------
    plotter : pyvista.Plotter
        It need not have drawn anything.
    path : path
        HTML file to write.
    title, note : str
        Heading, and a smaller line below it.
    """
    actors = list(plotter.renderer.actors.values())
    by_name = {name: list(_pieces(actor)) for name, actor in plotter.renderer.actors.items()}
    pieces = [piece for found in by_name.values() for piece in found]
    middle, size = _extent(plotter, pieces)
    framed = [piece["points"] for name, found in by_name.items() if name != "tracks" for piece in found]
    labels = [label for actor in actors for label in _labels(actor)]
    stored = bytearray()
    background = plotter.renderer.background_color
    description = {
        "camera": _camera(plotter, middle, size, framed),
        "background": [*background.float_rgb],
        "bars": [_bar(title, actor) for title, actor in plotter.scalar_bars.items()],
        "labels": [label | {"place": _rounded((label["place"] - middle) / size)} for label in labels],
        "parts": [_store(piece, stored, middle, size) for piece in pieces],
    }
    filled = {
        "title": html.escape(title),
        "note": html.escape(note),
        "background": background.hex_rgb,
        "scene": json.dumps(description).replace(
            "<", "\\u003c"
        ),  # else a name such as "<!--<script>" would end it
        "bytes": base64.b64encode(zlib.compress(stored, 6)).decode(),
    }
    text = re.sub(r"\{\{(\w+)\}\}", lambda name: filled[name[1]], TEMPLATE.read_text(encoding="utf-8"))
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    Path(path).write_text(text, encoding="utf-8")
    return path


def _store(piece: dict, stored: bytearray, middle: np.ndarray, size: float) -> dict:
    """Append the arrays of a piece, in units of the scene's size, and return its description with their offsets."""
    points = (piece.pop("points") - middle) / size
    arrays = {"places": points.astype("<f4")}
    arrays |= {name: piece.pop(name) for name in ("tints", "cells", "table") if name in piece}
    description = piece | {"count": len(points), "middle": _rounded(points.mean(axis=0))}
    for name, array in arrays.items():
        description[name] = len(stored)
        stored += array.tobytes() + bytes(-array.nbytes % 4)
    return description


def _rounded(values: np.ndarray) -> list[float]:
    return [round(float(value), 6) for value in values]


def _hex(rgb: tuple[float, ...]) -> str:
    return "#" + "".join(f"{round(OPAQUE * share):02x}" for share in rgb)


# ---- What VTK draws, as arrays.


def _pieces(prop: vtkProp) -> Iterator[dict[str, object]]:
    """What is drawn of an actor or a volume: kind, points (n, 3) and their colours "tints" (n, 4), 0 to 255.

    Also the opacity, whether it is lit, a round dot or clear (transparent), the size of points [pixels], and which side
    is hidden, "front" or "back". A cloud is a box, with the dimensions of a grid, its cells as bytes, and in a table the
    colour of each byte and the root of its depth as a share of the deepest.
    """
    from vtkmodules.vtkRenderingCore import vtkActor, vtkVolume

    if prop.GetVisibility() and isinstance(prop, vtkActor | vtkVolume) and prop.GetMapper() is not None:
        prop.GetMapper().GetInputAlgorithm().Update()  # what was never drawn may not have been made yet
        yield from (_of_actor if isinstance(prop, vtkActor) else _of_volume)(prop)


def _of_actor(actor: vtkActor) -> Iterator[dict[str, object]]:
    """Triangles, lines and points of an actor."""
    import pyvista as pv

    look, data = actor.GetProperty(), pv.wrap(actor.GetMapper().GetInputDataObject(0, 0))
    if data is None or data.n_points == 0:
        return
    surface = data.copy() if isinstance(data, pv.PolyData) else data.extract_geometry()
    tints, of_cells = _tints(actor.GetMapper(), surface, look)
    surface.clear_data()
    (surface.cell_data if of_cells else surface.point_data)["tints"] = tints
    if look.GetRepresentation() == EDGES:
        surface = surface.extract_all_edges()
    elif look.GetRepresentation() == POINTS:
        surface = surface.cast_to_pointset().cast_to_polydata()
    surface = surface.triangulate(pass_verts=True, pass_lines=True)
    tints = np.asarray((surface.cell_data if of_cells else surface.point_data)["tints"])
    opacity = look.GetOpacity()
    kinds = {
        "points": surface.verts.reshape(-1, 2)[:, 1:],
        "lines": surface.lines.reshape(-1, 3)[:, 1:],
        "triangles": surface.regular_faces,
    }
    start = 0
    for kind, corners in kinds.items():
        cells = slice(start, start + len(corners))
        start += len(corners)
        if len(corners):
            own = np.repeat(tints[cells], corners.shape[1], axis=0) if of_cells else tints[corners.ravel()]
            yield {
                "kind": kind,
                "points": np.asarray(surface.points, dtype=float)[corners.ravel()],
                "tints": np.ascontiguousarray(own),
                "opacity": opacity,
                "clear": bool(opacity < 1 or (own[:, 3] < OPAQUE).any()),
                "round": bool(look.GetRenderPointsAsSpheres()),
                "lit": bool(look.GetLighting()) and kind == "triangles",
                "size": look.GetPointSize(),
                "hidden": "front"
                if look.GetFrontfaceCulling()
                else "back"
                if look.GetBackfaceCulling()
                else "",
            }


def _tints(mapper: object, surface: pv.PolyData, look: object) -> tuple[np.ndarray, bool]:
    """The colours (n, 4) that VTK gives to points or cells, and whether to cells."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    smooth = mapper.GetInterpolateScalarsBeforeMapping()
    mapper.SetInterpolateScalarsBeforeMapping(False)  # else it gives places in a texture
    mapped = mapper.MapScalars(surface, 1.0) if mapper.GetScalarVisibility() else None
    mapper.SetInterpolateScalarsBeforeMapping(smooth)
    if mapped is None:
        rgb = [round(OPAQUE * share) for share in look.GetColor()]
        return np.tile(np.array([*rgb, OPAQUE], np.uint8), (surface.n_points, 1)), False
    found = vtk_to_numpy(mapped)
    if found.shape[1] == 3:
        found = np.column_stack([found, np.full(len(found), OPAQUE, np.uint8)])
    return found, "Cell" in mapper.GetScalarModeAsString()


def _of_volume(volume: vtkVolume) -> Iterator[dict[str, object]]:
    """A volume on a regular grid: its box as triangles, its values as bytes, and the colour and depth of each byte."""
    import pyvista as pv

    data = pv.wrap(volume.GetMapper().GetInputDataObject(0, 0))
    if not isinstance(data, pv.ImageData):
        return
    values, look = np.asarray(data.active_scalars, dtype=float), volume.GetProperty()
    low, high = float(values.min()), float(values.max())
    steps = np.linspace(low, high, OPAQUE + 1)
    opacity = np.array([look.GetScalarOpacity().GetValue(step) for step in steps])
    # Depth [1] of a path as long as the box's diagonal.
    depth = -np.log1p(-np.minimum(opacity, 0.999)) * data.length / look.GetScalarOpacityUnitDistance()
    colours = np.array([look.GetRGBTransferFunction().GetColor(step) for step in steps])
    share = np.sqrt(np.minimum(depth / MAX_DEPTH, 1.0))
    box = pv.Box(data.bounds).triangulate()
    yield {
        "kind": "cloud",
        "clear": True,
        "opacity": 1.0,
        "points": box.points[box.regular_faces.ravel()].astype(float),
        "tints": np.zeros((3 * box.n_cells, 4), np.uint8),
        "dimensions": [*data.dimensions],
        "deepest": MAX_DEPTH,
        "cells": np.round(OPAQUE * (values - low) / ((high - low) or 1.0)).astype(np.uint8),
        "table": np.round(OPAQUE * np.column_stack([colours, share])).astype(np.uint8),
    }


def _labels(actor: vtkProp) -> Iterator[dict]:
    """The text of an actor of labels, each with its place and colour."""
    from vtkmodules.vtkRenderingLabel import vtkPointSetToLabelHierarchy

    mapper = actor.GetMapper() if hasattr(actor, "GetMapper") else None
    source = mapper.GetInputAlgorithm() if hasattr(mapper, "GetInputAlgorithm") else None
    if isinstance(source, vtkPointSetToLabelHierarchy):
        data, colour = source.GetInputDataObject(0, 0), _hex(source.GetTextProperty().GetColor())
        texts = data.GetPointData().GetAbstractArray(source.GetLabelArrayName())
        for k in range(data.GetNumberOfPoints()):
            # The number begins a line of its own.
            text = texts.GetValue(k).replace(r"\$", "$").replace("   ", "\n")
            yield {"place": np.array(data.GetPoint(k)), "words": text, "colour": colour}


# ---- The camera, and what colours mean.


def _extent(plotter: pv.Plotter, pieces: list[dict]) -> tuple[np.ndarray, float]:
    """The middle of all pieces, and the largest distance from it: single precision is enough relative to it."""
    if not pieces:
        return np.array(plotter.camera.focal_point), 1.0
    points = np.concatenate([piece["points"] for piece in pieces])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    return middle, float(np.linalg.norm(points - middle, axis=1).max()) or 1.0


def _camera(
    plotter: pv.Plotter, middle: np.ndarray, size: float, framed: list[np.ndarray]
) -> dict[str, object]:
    """The camera, in units of the scene's size; "width": the half-width that a narrow page must show.

    That is of the framed points: tracks may end far outside. The centre of VTK's window is not kept: it makes
    room for bars, which stand beside the scene in a page.
    """
    if not plotter.renderer.camera_set:
        plotter.renderer.view_isometric()
    camera = plotter.camera
    eye, focus = ((np.array(place) - middle) / size for place in (camera.position, camera.focal_point))
    up, back = np.array(camera.up), (eye - focus) / np.linalg.norm(eye - focus)
    up = up - (up @ back) * back if abs(up @ back) > STEEP * np.linalg.norm(up) else up
    from_eye = (np.concatenate(framed) - camera.position) if framed else np.zeros((0, 3))
    depths = np.maximum(-from_eye @ back, 1e-9 * size)
    across = np.abs(from_eye @ np.cross(up, back)) / np.linalg.norm(np.cross(up, back)) / depths
    widest = math.tan(math.radians(camera.view_angle) / 2) * plotter.window_size[0] / plotter.window_size[1]
    return {
        "eye": _rounded(eye),
        "focus": _rounded(focus),
        "up": _rounded(up / np.linalg.norm(up)),
        "angle": math.radians(camera.view_angle),
        "width": float(min(across.max(initial=0.0), widest)),
    }


def _bar(title: str, actor: vtkScalarBarActor) -> dict[str, object]:
    """A colour bar: its title, its colours from low to high, and its labels with their places as shares of its height."""
    table = actor.GetLookupTable()
    (low, high), is_log = table.GetRange(), bool(table.UsingLogScale())
    shares = np.linspace(0, 1, BAR_COLOURS)
    colours, rgb = [], [0.0, 0.0, 0.0]
    for value in low * (high / low) ** shares if is_log else low + (high - low) * shares:
        table.GetColor(float(value), rgb)
        colours.append(_hex(rgb))
    # Its own marks, else round numbers.
    shown = np.log10 if is_log else np.asarray
    first, last = shown([low, high])
    own = range(table.GetNumberOfAnnotatedValues())
    marks = [(table.GetAnnotatedValue(k).ToDouble(), table.GetAnnotation(k)) for k in own]
    marks = marks or round_marks(low, high, is_log)
    labels = [(float((shown(value) - first) / (last - first)), as_html(text)) for value, text in marks]
    labels = [(share, text) for share, text in labels if -1e-6 <= share <= 1 + 1e-6]
    return {"title": as_html(title), "colours": colours, "labels": labels}


def as_html(text: str) -> str:
    r"""Return a text with mathtext, such as $E\;[\mathrm{W\,m^{-2}}]$, as HTML."""
    plain = html.escape(text.replace("$", ""))
    plain = re.sub(r"\\[,;: ]", "\u2009", plain)
    plain = re.sub(r"\\math\w+\{((?:[^{}]|\{[^{}]*\})*)\}", r"\1", plain)
    plain = re.sub(r"\^\{([^{}]*)\}|\^(\S)", lambda m: f"<sup>{m[1] or m[2]}</sup>", plain)
    return plain.replace("-", "−").replace("\n", "<br>")
