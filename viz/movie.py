"""Particles that fly through a 3-D scene, as a GIF: in time if the scene has a duration, else along their tracks.

With a duration, frames are the engine's snapshots, samples of the same histories. A steady scene has no time: all
particles of `tp.tracks` start together, and time is path length / c. Walls and clouds are drawn thin, so that particles
are seen through them; colours have one scale and one palette in all frames.
"""

from __future__ import annotations

import math
import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

import transport as tp
from transport.statistics.notation import with_thousands_spaces
from transport.units import speed_of_light
from transport.viz import scene_style as style
from transport.viz.facets import Bounds, segments
from transport.viz.scene import clipped, draw_scene
from transport.viz.scene_parts import frame_of

if TYPE_CHECKING:
    import pyvista as pv

    from transport.results.phase_space import SnapshotReading

FRAMES = 60
SAMPLE = 3000  # particles of a frame
TAIL = 2.5  # [frames] length of the path drawn behind a particle
MAX_DIAGONALS = (
    2.0  # diagonals of the box that particles fly at most; farther, they would jump between frames
)
FAR = 1.5  # diagonals of the box: if all particles fly farther before they enter it, that way is left out
GONE = 0.95  # share of the particles that have left at the end
FRAMES_PER_SECOND = 20
SIZE = (900, 600)  # [pixels]
PALETTE = 220  # colours of all frames together, besides those of the bar
BAR_COLOURS = 33
COLOURS = {  # colour map and title of what particles are coloured by
    "direction": ("coolwarm", r"$\mathrm{cosine\ to}\ {+}z$"),
    "weight": ("plasma", r"$\mathrm{weight}$"),
}
LONG_TITLE = 56  # characters above which a title is smaller
WALL_OPACITY = 0.2
SAMPLES_PER_PIXEL = 4  # the usual 8 take twice as long
MANY = 1000  # particles, which are drawn as finer dots
UNITS = {1.0: "s", 1e-3: "ms", 1e-6: "µs", 1e-9: "ns", 1e-12: "ps", 1e-15: "fs"}


class Flying(NamedTuple):
    """Some particles: places (n, 3) or ends of lines (n, 2, 3) [m], directions (n, 3) and weights (n,)."""

    places: np.ndarray
    directions: np.ndarray
    weights: np.ndarray

    def within(self, bounds: Bounds) -> Flying:
        """Return those in the box."""
        inside = (bounds[0] <= self.places) & (self.places <= bounds[1])
        inside = inside.all(axis=tuple(range(1, inside.ndim)))
        return Flying(*(values[inside] for values in self))

    def values(self, colour: str) -> np.ndarray:
        """The cosine to +z, or the weight."""
        return self.directions[:, 2] if colour == "direction" else self.weights

    def drawn(self) -> pv.PolyData:
        """Return them as points or lines."""
        import pyvista as pv

        if self.places.ndim == 3:
            return segments(self.places)
        return pv.PolyData(self.places) if len(self.places) else pv.PolyData()


class Instant(NamedTuple):
    """Particles, and the paths behind them from old to new, at a time since the start [s]."""

    seconds: float
    heads: Flying
    tails: Flying

    def within(self, bounds: Bounds) -> Instant:
        """Return what lies in the box."""
        return Instant(self.seconds, self.heads.within(bounds), self.tails.within(bounds))


NO_TAILS = Flying(np.empty((0, 2, 3)), np.empty((0, 3)), np.empty(0))


def filmed(scene: tp.Scene, frames: int = FRAMES, particles: int = SAMPLE) -> tp.Scene:
    """Return the scene with a snapshot of so many particles at each of `frames` equal steps of its duration.

    Raises SceneError for a scene without a duration.
    """
    if scene.duration is None:
        raise tp.SceneError("filmed: needs a scene with a duration; film a steady one along its tracks")
    times = np.linspace(0, scene.duration, frames)
    shots = [tp.Snapshot(float(time), particles, name=f"frame {k}") for k, time in enumerate(times)]
    return replace(scene, detectors=(*scene.detectors, *shots))


def clock_movie(
    scene: tp.Scene,
    path: str | os.PathLike,
    result: tp.Result,
    colour: str = "direction",
    title: str | None = None,
) -> str | os.PathLike:
    """Write the particles of a result's snapshots, in the order of their times, as a GIF.

    Parameters
    ----------
    scene : Scene
        Drawn around them; its own snapshots are no frames.
    path : path
        GIF to write.
    result : Result
        Of `filmed(scene)`.
    colour : {"direction", "weight"}
        What colours particles; the heaviest has weight 1.
    title : str, optional
        Heading.

    Returns
    -------
    path
        The path.

    Raises
    ------
    ValueError
        If the result has no snapshots.
    """
    added = [shot for shot in result.scene.snapshots if shot not in scene.snapshots]
    shots = sorted(added or result.scene.snapshots, key=lambda shot: shot.time)
    if not shots:
        raise ValueError("clock_movie: the result has no snapshots; run filmed(scene)")
    bounds = frame_of(scene).margins
    instants = [_snapped(result[shot.name]).within(bounds) for shot in shots]
    top = max(each.heads.weights.max(initial=0.0) for each in instants) or 1.0
    instants = [
        each._replace(heads=each.heads._replace(weights=each.heads.weights / top)) for each in instants
    ]
    return _film(scene, path, instants, "t", colour, title)


def tracks_movie(
    scene: tp.Scene,
    path: str | os.PathLike,
    tracks: tp.Tracks,
    colour: str = "direction",
    title: str | None = None,
    frames: int = FRAMES,
) -> str | os.PathLike:
    """Write particles that start together and fly along their tracks as a GIF; return the path.

    Arguments are those of `clock_movie`, and the number of frames.
    """
    instants, is_from_edge = flights(tracks, frame_of(scene).margins, frames)
    backwards = "backwards, " if scene.instruments else ""  # from the camera to the light
    edge = " since the edge of the picture" if is_from_edge else ""
    return _film(scene, path, instants, f"{backwards}path length / c{edge}", colour, title)


# ---- Where particles are.


def _snapped(shot: SnapshotReading) -> Instant:
    """The particles of a snapshot; those at rest have no direction."""
    speeds = np.linalg.norm(shot.velocities, axis=1, keepdims=True)
    directions = shot.velocities / np.where(speeds > 0, speeds, 1.0)
    return Instant(shot.time, Flying(shot.positions, directions, shot.weights), NO_TAILS)


def flights(tracks: tp.Tracks, bounds: Bounds, count: int = FRAMES) -> tuple[list[Instant], bool]:
    """Return instants until most particles are absorbed or out of the box; and whether time begins at its edge."""
    size = float(np.linalg.norm(bounds[1] - bounds[0]))
    first, last = clipped(tracks, bounds)
    entries = (tracks.ages + first)[first < last]
    is_far = bool(len(entries)) and entries.min() > FAR * size
    if is_far:
        tracks = from_entry(tracks, bounds)
        first, last = clipped(tracks, bounds)
    # How far each particle flies until it is absorbed or out of the box.
    inside = first < last
    _, numbers = np.unique(tracks.histories[inside], return_inverse=True)
    flown = np.zeros(numbers.max(initial=0) + 1)
    np.maximum.at(flown, numbers, (tracks.ages + last)[inside])
    farthest = min(float(np.quantile(flown, GONE)), MAX_DIAGONALS * size)
    ways = np.linspace(0, farthest, count)
    return [along(tracks, float(way), TAIL * farthest / count).within(bounds) for way in ways], is_far


def along(tracks: tp.Tracks, way: float, tail: float) -> Instant:
    """Return the particles after a path length [m], with the last `tail` [m] of their paths."""
    first = tracks.ages
    last = first + tracks.lengths

    def at(chosen: np.ndarray, flown: np.ndarray | float) -> np.ndarray:
        flown = np.broadcast_to(flown, first.shape)
        return tracks.starts[chosen] + (flown - first)[chosen, None] * tracks.directions[chosen]

    here, behind = (first <= way) & (way < last), (first < way) & (last > way - tail)
    ends = at(behind, np.maximum(first, way - tail)), at(behind, np.minimum(last, way))
    return Instant(
        way / speed_of_light,
        Flying(at(here, way), tracks.directions[here], tracks.weights[here]),
        Flying(np.stack(ends, axis=1), tracks.directions[behind], tracks.weights[behind]),
    )


def from_entry(tracks: tp.Tracks, bounds: Bounds) -> tp.Tracks:
    """Return the tracks from where each particle enters the box, without those that never do.

    For sources so far away that their light would never be in the picture at one time.
    """
    first, last = clipped(tracks, bounds)
    is_in = first < last
    _, numbers = np.unique(tracks.histories, return_inverse=True)
    entering = np.full(numbers.max(initial=0) + 1, len(tracks))
    np.minimum.at(entering, numbers[is_in], np.flatnonzero(is_in))
    rows = np.arange(len(tracks))
    cut = np.where(rows == entering[numbers], first, 0.0)
    kept = rows >= entering[numbers]
    columns = {name: getattr(tracks, name)[kept] for name in ("directions", "weights", "histories", "meets")}
    starts, lengths = tracks.starts + cut[:, None] * tracks.directions, tracks.lengths - cut
    return replace(tracks, starts=starts[kept], lengths=lengths[kept], **columns)


# ---- Drawing.


def _film(
    scene: tp.Scene,
    path: str | os.PathLike,
    instants: list[Instant],
    clock: str,
    colour: str,
    title: str | None,
) -> str | os.PathLike:
    """Draw the instants into the scene and write them; `clock`: name of their time."""
    if colour not in COLOURS:
        raise ValueError(f"movie: colour must be one of {', '.join(COLOURS)}, got {colour!r}")
    plotter = draw_scene(scene, window_size=SIZE)
    try:
        pictures = _pictures(plotter, instants, clock, colour, title)
    finally:
        plotter.close()
    _write_gif(pictures, Path(path), COLOURS[colour][0])
    return path


def _pictures(
    plotter: pv.Plotter, instants: list[Instant], clock: str, colour: str, title: str | None
) -> list[np.ndarray]:
    """Pictures of each instant, (height, width, 3) of 0 to 255."""
    plotter.render_window.SetMultiSamples(SAMPLES_PER_PIXEL)
    _make_transparent(plotter)
    scale = _scale(colour, instants)
    mappers = _add_particles(plotter, colour, scale, max(len(each.heads.places) for each in instants))
    if title:
        style.write(plotter, title, (0.022, 0.93), 18 if len(title) < LONG_TITLE else 14)
    label = style.write(plotter, " ", (0.022, 0.07), 17)
    plotter.screenshot(return_img=True)  # else the first has the marks of the bar at another place
    time_text = clock_text(clock, max(instant.seconds for instant in instants))
    pictures = []
    for each in instants:
        for mapper, flying in zip(mappers, (each.heads, each.tails), strict=True):
            mesh = flying.drawn()
            mesh.cell_data["shown"] = scale.of(flying.values(colour))
            mapper.SetInputData(mesh)
        label.SetInput(
            f"{time_text(each.seconds)}   ·   {with_thousands_spaces(len(each.heads.places))} particles"
        )
        plotter.render()
        pictures.append(plotter.screenshot(return_img=True))
    return pictures


def _make_transparent(plotter: pv.Plotter) -> None:
    """Thin clouds, and walls that hide what is behind them from both sides."""
    for actor in plotter.actors.values():
        data, look = getattr(getattr(actor, "mapper", None), "dataset", None), getattr(actor, "prop", None)
        if getattr(data, "GetNumberOfPolys", int)() and look is not None and look.culling == "none":
            look.opacity = min(look.opacity, WALL_OPACITY)
        if hasattr(look, "SetScalarOpacityUnitDistance"):
            look.SetScalarOpacityUnitDistance(look.GetScalarOpacityUnitDistance() / WALL_OPACITY)


def _scale(colour: str, instants: list[Instant]) -> style.Scale:
    """One scale for all frames: of cosines, or decades of weights with the brightest at the top."""
    if colour == "direction":
        return style.Scale(-1.0, 1.0, ((-1.0, "−1"), (0.0, "0"), (1.0, "1")), False)
    weights = np.concatenate([each.heads.weights for each in instants])
    top = weights.max(initial=0.0) or 1.0
    return style.logarithmic(np.append(weights, [top, top / 10]))


def _add_particles(plotter: pv.Plotter, colour: str, scale: style.Scale, count: int) -> list[object]:
    """Return the mappers of heads and tails; frames give them their data."""
    colours, title = COLOURS[colour]
    dots = {"point_size": 3, "opacity": 0.8} if count > MANY else {"point_size": 4, "opacity": 0.9}
    heads, tails = (
        style.add_coloured(plotter, mesh, np.ones(1), scale, colours, reset_camera=False, **look)
        for mesh, look in (
            (NO_TAILS._replace(places=np.zeros((1, 3))).drawn(), {"style": "points"} | dots),
            (NO_TAILS._replace(places=np.zeros((1, 2, 3))).drawn(), {"line_width": 1.3, "opacity": 0.45}),
        )
    )
    style.add_bar(plotter, heads, title, scale, (0.82, 0.28), 0.45)
    return [heads.mapper, tails.mapper]


def clock_text(name: str, longest: float):
    """Return a function that writes a time [s] with three digits of the longest one, in its unit."""
    unit = next((unit for unit in UNITS if longest >= unit), min(UNITS))
    digits = max(0, 2 - math.floor(math.log10(longest / unit))) if longest > 0 else 0
    return lambda seconds: f"{name} = {seconds / unit:.{digits}f} {UNITS[unit]}"


def _write_gif(pictures: list[np.ndarray], path: Path, colours: str) -> None:
    """Write an endless GIF with one palette: of frames from all of it, and of the bar."""
    from matplotlib import colormaps
    from PIL import Image

    few = np.concatenate(pictures[:: max(1, len(pictures) // 8)])
    palette = Image.fromarray(few).quantize(PALETTE, method=Image.Quantize.MEDIANCUT)
    bar = colormaps[colours](np.linspace(0, 1, BAR_COLOURS), bytes=True)[:, :3]
    palette.putpalette([*palette.getpalette()[: 3 * PALETTE], *bar.ravel().tolist()])
    first, *others = (
        Image.fromarray(picture).quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    duration = 1000 // FRAMES_PER_SECOND
    first.save(path, save_all=True, append_images=others, duration=duration, loop=0, disposal=1)
