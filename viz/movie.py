"""Particles that fly through a 3-D scene, as a GIF: by the clock where the scene has one, else along their tracks.

Walls are thin, clouds too, so that particles are seen through them; colours are directions or weights, on one scale for
all frames, and in one palette with those of their bar.
"""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import transport as tp
from transport.viz import night
from transport.viz.flying import FRAMES, Instant, flights, snapped, within
from transport.viz.scene_frame import frame_of
from transport.viz.scene_view import scene_plotter

if TYPE_CHECKING:
    import pyvista as pv

PER_SECOND = 20  # frames
SIZE = (900, 600)  # pixels
PALETTE = 220  # colours of all frames together, besides those of the bar
DIRECTION, WEIGHT = "direction", "weight"
COLOURS = (DIRECTION, WEIGHT)
MEANINGS = {DIRECTION: r"$\mathrm{cosine\ to}\ {+}z$", WEIGHT: r"$\mathrm{weight}$"}
MAPS = {DIRECTION: "coolwarm", WEIGHT: "plasma"}
BAR = 33  # colours of the bar that a palette has
LONG = 56  # characters of a title, beyond which it is written smaller
THIN = 0.2  # opacity of a wall
SMOOTH = 4  # samples a pixel; the usual 8 take twice as long
FAINTEST = 1e-300
MANY = 1000  # particles, which are drawn as finer dots
PREFIXES = {1.0: "s", 1e-3: "ms", 1e-6: "µs", 1e-9: "ns", 1e-12: "ps", 1e-15: "fs"}


def clock_movie(
    scene: tp.Scene,
    path: str | os.PathLike,
    result: tp.Result,
    colour: str = DIRECTION,
    title: str | None = None,
) -> str | os.PathLike:
    """Write the particles of the result's snapshots, in the order of their times, as a GIF; returns the path.

    scene: what is drawn round them, and whose own snapshots are left out;  result: of `filmed(scene)`;
    colour: "direction" or "weight", that of the heaviest being 1.  Raises ValueError for a result without snapshots.
    """
    added = [look for look in result.scene.snapshots if look not in scene.snapshots]
    looks = sorted(added or result.scene.snapshots, key=lambda look: look.time)
    if not looks:
        raise ValueError("clock_movie: the result has no snapshots; run filmed(scene)")
    bounds = frame_of(scene).grown()
    instants = [within(snapped(result[look.name]), bounds) for look in looks]
    top = max(each.weights.max(initial=0.0) for each in instants) or 1.0
    instants = [each._replace(weights=each.weights / top) for each in instants]
    return _film(scene, path, instants, "t", colour, title)


def tracks_movie(
    scene: tp.Scene,
    path: str | os.PathLike,
    tracks: tp.Tracks,
    colour: str = DIRECTION,
    title: str | None = None,
    frames: int = FRAMES,
) -> str | os.PathLike:
    """Write particles that start together and fly along their tracks as a GIF; returns the path.

    colour: "direction" or "weight";  frames: how many.
    """
    instants, is_from_edge = flights(tracks, frame_of(scene).grown(), frames)
    backwards = "backwards, " if scene.instruments else ""  # from the camera to the light
    edge = " since the edge of the picture" if is_from_edge else ""
    return _film(scene, path, instants, f"{backwards}path length / c{edge}", colour, title)


# ---- drawing ----


def _film(
    scene: tp.Scene,
    path: str | os.PathLike,
    instants: list[Instant],
    clock: str,
    colour: str,
    title: str | None,
) -> str | os.PathLike:
    """Draw the instants into the scene and write them; clock: what the label calls their time."""
    if colour not in COLOURS:
        raise ValueError(f"movie: colour must be one of {', '.join(COLOURS)}, got {colour!r}")
    plotter = scene_plotter(scene, window_size=SIZE)
    try:
        pictures = _pictures(plotter, instants, clock, colour, title)
    finally:
        plotter.close()
    _write(pictures, Path(path), MAPS[colour])
    return path


def _pictures(plotter: pv.Plotter, instants: list[Instant], clock: str, colour: str, title: str | None):
    """What the plotter shows of each instant, (height, width, 3) of 0 to 255."""
    plotter.render_window.SetMultiSamples(SMOOTH)
    _clear_the_view(plotter)
    heads, tails = _particles(plotter, colour, instants)
    if title:
        _write_text(plotter, title, 0.93, 12 if len(title) < LONG else 9)
    label = _write_text(plotter, " ", 0.07, 11)
    plotter.screenshot(return_img=True)  # the first places the marks of the bar otherwise
    said = _clock(clock, max(instant.seconds for instant in instants))
    pictures = []
    for each in instants:
        heads.SetInputData(_points(each.places, _values(colour, each.directions, each.weights)))
        tails.SetInputData(_lines(each.tails, _values(colour, each.tail_directions, each.tail_weights)))
        label.SetInput(f"{said(each.seconds)}   ·   {len(each.places)} particles")
        plotter.render()
        pictures.append(plotter.screenshot(return_img=True))
    return pictures


def _clear_the_view(plotter: pv.Plotter) -> None:
    """Make clouds, and walls that hide what is behind them from any side, thin: particles are seen through them."""
    for actor in plotter.actors.values():
        data, look = getattr(getattr(actor, "mapper", None), "dataset", None), getattr(actor, "prop", None)
        if getattr(data, "GetNumberOfPolys", int)() and look is not None and look.culling == "none":
            look.opacity = min(look.opacity, THIN)
        if hasattr(look, "SetScalarOpacityUnitDistance"):
            look.SetScalarOpacityUnitDistance(look.GetScalarOpacityUnitDistance() / THIN)


def _write_text(plotter: pv.Plotter, words: str, height: float, size: int):
    """The actor of a line at the left side of the window; height: as a share of that."""
    look = {"color": night.TEXT, "font_file": night.font(), "font_size": size}
    return plotter.add_text(words, position=(0.022, height), viewport=True, **look)


def _particles(plotter: pv.Plotter, colour: str, instants: list[Instant]):
    """The mappers of heads and tails, in colours that are the same in all frames."""
    many = max(len(each.places) for each in instants) > MANY
    scale = _scale(colour, instants)
    look = {
        "scalars": "colour",
        "cmap": MAPS[colour],
        "clim": (scale.low, scale.high),
        "lighting": False,
        "reset_camera": False,
        "show_scalar_bar": False,
    }
    points, lines = (
        _points(np.zeros((1, 3)), np.array([scale.high])),
        _lines(np.zeros((1, 2, 3)), np.array([scale.high])),
    )
    dots = {"point_size": 3, "opacity": 0.8} if many else {"point_size": 4, "opacity": 0.9}
    heads = plotter.add_mesh(points, style="points", **dots, **look)
    tails = plotter.add_mesh(lines, line_width=1.3, opacity=0.45, **look)
    night.add_bar(plotter, heads, MEANINGS[colour], scale, (0.82, 0.28), 0.45)
    return heads.mapper, tails.mapper


def _values(colour: str, directions: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """What of the scale a particle has: the cosine of its direction, or the decimal logarithm of its weight."""
    return directions[:, 2] if colour == DIRECTION else np.log10(np.maximum(weights, FAINTEST))


def _scale(colour: str, instants: list[Instant]) -> night.Scale:
    """Of cosines from -1 to 1, of weights whole decades."""
    if colour == DIRECTION:
        return night.Scale(-1.0, 1.0, ((-1.0, "−1"), (0.0, "0"), (1.0, "1")), False)
    weights = np.concatenate([each.weights for each in instants])
    top = weights.max(initial=0.0) or 1.0
    return night.decades(np.append(weights, [top, top / 10]))  # so that the brightest is at the top


def _points(places: np.ndarray, values: np.ndarray) -> pv.PolyData:
    import pyvista as pv

    made = pv.PolyData(places) if len(places) else pv.PolyData()
    made.point_data["colour"] = values
    return made


def _lines(ends: np.ndarray, values: np.ndarray) -> pv.PolyData:
    import pyvista as pv

    made = pv.line_segments_from_points(ends.reshape(-1, 3)) if len(ends) else pv.PolyData()
    made.cell_data["colour"] = values
    return made


def _clock(name: str, longest: float):
    """Says a time [s] with three digits of the longest one, in its unit."""
    unit = next((unit for unit in PREFIXES if longest >= unit), min(PREFIXES))
    digits = max(0, 2 - math.floor(math.log10(longest / unit))) if longest > 0 else 0
    return lambda seconds: f"{name} = {seconds / unit:.{digits}f} {PREFIXES[unit]}"


def _write(pictures: list[np.ndarray], path: Path, cmap: str) -> None:
    """A GIF without end in one palette: that of frames from all of it, with the colours of the bar."""
    from matplotlib import colormaps
    from PIL import Image

    few = np.concatenate(pictures[:: max(1, len(pictures) // 8)])
    palette = Image.fromarray(few).quantize(PALETTE, method=Image.Quantize.MEDIANCUT)
    bar = colormaps[cmap](np.linspace(0, 1, BAR), bytes=True)[:, :3]
    palette.putpalette([*palette.getpalette()[: 3 * PALETTE], *bar.ravel().tolist()])
    images = [
        Image.fromarray(picture).quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures
    ]
    path.parent.mkdir(parents=True, exist_ok=True)
    images[0].save(
        path, save_all=True, append_images=images[1:], duration=1000 // PER_SECOND, loop=0, disposal=1
    )
