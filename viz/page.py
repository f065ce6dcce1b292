"""A 3-D scene as one HTML file that turns under the mouse in any browser and asks nothing of the network.

What a plotter would draw is written down as triangles, lines and points with the colours that VTK gives them; page.html
beside this file draws them with the browser's own WebGL 2.  Nothing else is in the file: a page is as large as its scene.
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
from transport.viz.page_parts import OPAQUE, pieces_of
from transport.viz.scene_frame import frame_of
from transport.viz.scene_parts import parts_of
from transport.viz.scene_view import caption_of, undrawn_plotter
from transport.viz.screen import without_screen

if TYPE_CHECKING:
    import pyvista as pv
    from vtkmodules.vtkCommonCore import vtkScalarsToColors
    from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor

TEMPLATE = Path(__file__).with_name("page.html")
RAMP = 33  # colours of a bar
STEEP = 0.99  # cosine between a look and what is up, beyond which it cannot turn about that


def scene_page(
    scene: Scene,
    path: str | os.PathLike,
    result: Result | None = None,
    tracks: Tracks | None = None,
    title: str = "A scene",
) -> str | os.PathLike:
    """Write the scene with its result and tracks, as `scene_view` draws it, as a page that turns; returns the path.

    The browser draws it: no libraries of OpenGL are needed to write it.
    """
    frame = frame_of(scene, tracks)
    note = caption_of(scene, result, tracks, parts_of(scene, frame, result), frame)
    with without_screen():
        plotter = undrawn_plotter(scene, result, tracks)
        try:
            return page(plotter, path, title, note)
        finally:
            plotter.close()


def page(plotter: pv.Plotter, path: str | os.PathLike, title: str, note: str = "") -> str | os.PathLike:
    """Write what a plotter has in its first renderer as a page of HTML; returns the path.

    Surfaces, lines, points, their colours, labels, volumes on grids and colour bars are kept; other texts are left out.
    title, note: a heading, and a smaller line below it.
    """
    actors = list(plotter.renderer.actors.values())
    parts = [part for actor in actors for part in pieces_of(actor)]
    middle, size = _extent(plotter, parts)
    held = bytearray()
    background = plotter.renderer.background_color
    told = {
        "camera": _camera(plotter, middle, size),
        "background": [*background.float_rgb],
        "bars": [_bar(title, actor) for title, actor in plotter.scalar_bars.items()],
        "labels": [_placed(label, middle, size) for actor in actors for label in _labels(actor)],
        "parts": [_stored(part, held, middle, size) for part in parts],
    }
    filled = {
        "title": html.escape(title),
        "note": html.escape(note),
        "background": background.hex_rgb,
        "scene": json.dumps(told).replace("<", "\\u003c"),  # else a name such as "<!--<script>" would end it
        "bytes": base64.b64encode(zlib.compress(held, 6)).decode(),
    }
    text = re.sub(r"\{\{(\w+)\}\}", lambda name: filled[name[1]], TEMPLATE.read_text(encoding="utf-8"))
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    Path(path).write_text(text, encoding="utf-8")
    return path


def _stored(part: dict, held: bytearray, middle: np.ndarray, size: float) -> dict:
    """The description of a part whose arrays are put behind what is held, in units of the scene's size."""
    points = (part.pop("points") - middle) / size
    arrays = {"places": points.astype("<f4")}
    arrays |= {name: part.pop(name) for name in ("tints", "cells", "table") if name in part}
    told = part | {"count": len(points), "middle": _rounded(points.mean(axis=0))}
    for name, array in arrays.items():
        told[name] = len(held)
        held += array.tobytes() + bytes(-array.nbytes % 4)
    return told


def _labels(actor) -> Iterator[dict]:
    """The words of an actor of labels, each with its place and colour."""
    from vtkmodules.vtkRenderingLabel import vtkPointSetToLabelHierarchy

    mapper = actor.GetMapper() if hasattr(actor, "GetMapper") else None
    source = mapper.GetInputAlgorithm() if hasattr(mapper, "GetInputAlgorithm") else None
    if not isinstance(source, vtkPointSetToLabelHierarchy):
        return
    data = source.GetInputDataObject(0, 0)
    words = data.GetPointData().GetAbstractArray(source.GetLabelArrayName())
    colour = "#" + "".join(f"{round(OPAQUE * share):02x}" for share in source.GetTextProperty().GetColor())
    for k in range(data.GetNumberOfPoints()):
        said = words.GetValue(k).replace(r"\$", "$")
        yield {"place": data.GetPoint(k), "words": said, "colour": colour}


def _placed(label: dict, middle: np.ndarray, size: float) -> dict:
    return label | {"place": _rounded((np.array(label["place"]) - middle) / size)}


# ---- where it is seen from, and what its colours mean ----


def _extent(plotter: pv.Plotter, parts: list[dict]) -> tuple[np.ndarray, float]:
    """The middle of all parts, and the distance of the farthest point from it: single precision is enough about it."""
    if not parts:
        return np.array(plotter.camera.focal_point), 1.0
    low, high = (np.array([getattr(part["points"], end)(axis=0) for part in parts]) for end in ("min", "max"))
    middle = (low.min(axis=0) + high.max(axis=0)) / 2
    farthest = max(float(np.linalg.norm(part["points"] - middle, axis=1).max()) for part in parts)
    return middle, farthest or 1.0


def _camera(plotter: pv.Plotter, middle: np.ndarray, size: float) -> dict[str, object]:
    if not plotter.renderer.camera_set:
        plotter.renderer.view_isometric()
    camera = plotter.camera
    eye, focus = ((np.array(place) - middle) / size for place in (camera.position, camera.focal_point))
    up, back = np.array(camera.up), (eye - focus) / np.linalg.norm(eye - focus)
    up = up - (up @ back) * back if abs(up @ back) > STEEP * np.linalg.norm(up) else up
    return {
        "eye": _rounded(eye),
        "focus": _rounded(focus),
        "up": _rounded(up / np.linalg.norm(up)),
        "angle": math.radians(camera.view_angle),
        "centre": [*camera.GetWindowCenter()],
    }


def _rounded(values: np.ndarray) -> list[float]:
    return [round(float(value), 6) for value in values]


def _bar(title: str, actor: vtkScalarBarActor) -> dict[str, object]:
    """A colour bar: its title, its colours from low to high, and its labels with their places as shares of its height."""
    table = actor.GetLookupTable()
    (low, high), is_log = table.GetRange(), bool(table.UsingLogScale())
    shares = np.linspace(0, 1, RAMP)
    values = low * (high / low) ** shares if is_log else low + (high - low) * shares
    colours, rgb = [], [0.0, 0.0, 0.0]
    for value in values:
        table.GetColor(float(value), rgb)
        colours.append("#" + "".join(f"{round(OPAQUE * share):02x}" for share in rgb))
    return {"title": as_html(title), "colours": colours, "labels": _marks(table, low, high, is_log)}


def _marks(table: vtkScalarsToColors, low: float, high: float, is_log: bool) -> list[tuple[float, str]]:
    """What stands beside a bar, and where as a share of its height: its own marks, else decades or five numbers."""
    shown = np.log10 if is_log else np.asarray
    first, last = shown([low, high])
    count = table.GetNumberOfAnnotatedValues()
    if count:
        marks = {table.GetAnnotatedValue(k).ToDouble(): table.GetAnnotation(k) for k in range(count)}
    elif is_log:
        decades = range(math.ceil(first - 1e-9), math.floor(last + 1e-9) + 1)
        marks = {10.0**k: f"$10^{{{k}}}$" for k in decades}
    else:
        marks = {float(value): f"{value:.4g}" for value in np.linspace(low, high, 5)}
    shares = {value: float((shown(value) - first) / (last - first)) for value in marks}
    return [
        (shares[value], as_html(text)) for value, text in marks.items() if -1e-6 <= shares[value] <= 1 + 1e-6
    ]


def as_html(text: str) -> str:
    r"""A text with VTK's mathtext, such as $E\;[\mathrm{W\,m^{-2}}]$, as HTML."""
    plain = html.escape(text.replace("$", ""))
    plain = re.sub(r"\\[,;: ]", "\u2009", plain)
    plain = re.sub(r"\\math\w+\{((?:[^{}]|\{[^{}]*\})*)\}", r"\1", plain)
    plain = re.sub(r"\^\{([^{}]*)\}|\^(\S)", lambda m: f"<sup>{m[1] or m[2]}</sup>", plain)
    return plain.replace("-", "−").replace("\n", "<br>")
