"""What each kind of thing looks like in a picture of a scene: surfaces, media, sources, detectors."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import numpy as np

from transport.geometry.shape import Point
from transport.scene.cameras import Camera
from transport.scene.media import Grid
from transport.scene.scene import Scene
from transport.viz import night
from transport.viz.painted import LEAST_HITS
from transport.viz.scene_frame import Frame
from transport.viz.scene_parts import BACK, FRONT, NOWHERE, Part
from transport.viz.solids import contours, segments
from transport.viz.wording import as_it_stands, lengths_text

if TYPE_CHECKING:
    import pyvista

APART = 4e-4  # of the picture's size: how far what lies on a wall is drawn off it
HALO = ((30, 0.08), (19, 0.18), (9, 1.0))  # size [pixels] and opacity of the discs of a small glow
RIM = ((11.0, 0.10), (6.0, 0.20), (2.0, 0.9))  # width [pixels] and opacity of the lines of a large one
SMALL = 0.02  # of the picture's size: smaller things have a mark
HIDES = {FRONT: "back", BACK: "front", None: None}  # the facets left out, by the side that is shown
FOG = (0.10, 0.55)  # opacity of the thinnest and the thickest medium
DEPTH = 1.5  # mean optical depth across voxels, at most: denser ones are drawn thinner
RIGHT = 0.9  # of the window: names that would be further right end at what they name
LONGEST = 40  # characters of a detector's name
SAMPLES = 80  # of opacity, along a way across voxels


def known(part: Part) -> np.ndarray:
    """Of each bin, whether enough was counted to show it."""
    return part.paint.hits >= LEAST_HITS


def opacity_of(part: Part) -> float:
    """Of what was read: below 1 of what is looked through and has one colour only, which is told as a number."""
    if part.has_bins:
        return 1.0
    return 0.35 if part.kind == "detector" else 0.6 if part.is_clear else 1.0


def add_surface(plotter: pyvista.Plotter, part: Part, scale: night.Scale | None) -> object | None:
    """A wall, a mirror or a pane; painted where it was looked at.  Returns the painted actor."""
    if len(part.facets.faces) == 0:
        return None
    if not part.is_other_side:
        _add_lines(plotter, part.outlined(), color=night.FAINT, opacity=0.5, line_width=1.2)
    if part.seen_from == NOWHERE:
        return None
    if part.paint is None and part.is_empty:
        return None
    if part.paint is not None and scale is not None:
        if not part.has_bins:
            lift = APART * part.frame.size * (-1 if part.seen_from == BACK else 1)
            _add_lines(plotter, contours(part.drawn(), lift), color=night.GROUND, opacity=0.5, line_width=1.2)
        return _paint(plotter, part, scale, lift=0.0, opacity=opacity_of(part))
    look = {"color": night.WALL, "ambient": 0.35, "diffuse": 0.65}
    if part.is_mirror:
        look = {"color": night.STEEL, "ambient": 0.25, "diffuse": 0.5, "specular": 0.7, "specular_power": 30}
    if part.is_clear:
        look = {"color": night.GLASS, "opacity": 0.13, "ambient": 0.5}
    plotter.add_mesh(part.drawn(), culling=HIDES[part.seen_from], show_scalar_bar=False, **look)
    return None


def add_medium(plotter: pyvista.Plotter, part: Part, scale: night.Scale | None) -> None:
    """A translucent body, the denser the more light stays in it; voxels as a volume."""
    medium = part.what
    if len(part.facets.faces) == 0:
        return
    if isinstance(medium, Grid) and part.shape == medium.box:
        _add_voxels(plotter, medium)
        return
    across = 2 * part.shape.extent if np.isfinite(part.shape.extent) else part.frame.size
    depth = float(np.mean(medium.extinction)) * across
    low, high = FOG
    opacity = low + (high - low) * -np.expm1(-depth)
    colour = night.GLOWING if medium.emission > 0 else night.FOG
    look = {"color": colour, "opacity": opacity, "lighting": False, "show_scalar_bar": False}
    plotter.add_mesh(part.drawn(), culling="front", **look)  # the far side: what is inside keeps its colours


def add_source(plotter: pyvista.Plotter, part: Part, scale: night.Scale | None) -> None:
    """Bright where it emits, with a rim that glows; a small one as a glowing dot, a volume as a haze."""
    if isinstance(part.shape, Point) or part.shape.extent < SMALL * part.frame.size:
        _add_glow(plotter, np.array(part.shape.middle))
    if isinstance(part.shape, Point):
        return
    for width, opacity in RIM:
        lines = _lifted(part.outlined(), part, 2)
        _add_lines(plotter, lines, color=night.GLOW, opacity=opacity, line_width=width)
    if part.is_on_surface:  # the colours say how bright it is
        return
    look = {"color": night.GLOW, "lighting": False, "show_scalar_bar": False}
    if not part.what.emission.has_side:
        plotter.add_mesh(part.drawn(), opacity=0.12, **look)
        return
    drawn = _lifted(part.drawn(), part, 2)
    plotter.add_mesh(drawn, culling=HIDES[part.side], **look)
    if part.seen_from is None:
        plotter.add_mesh(drawn, culling=part.side, opacity=0.10, **look)


def add_distant(plotter: pyvista.Plotter, scene: Scene, frame: Frame) -> None:
    """A dashed way towards each source that lies beyond the picture, and how far it is."""
    for number, place in frame.distant.items():
        far = np.linalg.norm(place - frame.middle)
        way = (place - frame.middle) / far
        marks = frame.middle + way * frame.size * np.linspace(0.25, 0.5, 12)[:, None]
        plotter.add_mesh(segments(marks[::2], marks[1::2]), color=night.GLOW, line_width=2.5, lighting=False)
        _add_glow(plotter, marks[-1])
        add_labels(plotter, [(marks[-1], f"source {number}, {lengths_text([far])} away")], night.GLOW)


def add_detector(plotter: pyvista.Plotter, part: Part, scale: night.Scale | None) -> object | None:
    """An outline, and what was read painted on it.  Returns the painted actor."""
    if not part.shape.is_infinite:
        middle = np.array(part.shape.middle)
        if isinstance(part.shape, Point) or part.shape.extent < SMALL * part.frame.size:
            plotter.add_points(
                middle[None], color=night.METER, point_size=9, render_points_as_spheres=True, lighting=False
            )
        if isinstance(part.what, Camera):
            _add_pyramid(plotter, part.what, part.frame.size)
        if len(part.facets.faces):
            lines = _lifted(part.outlined(), part, 1)
            width, opacity = (1.4, 0.6) if part.is_on_surface else (2.2, 1.0)
            _add_lines(plotter, lines, color=night.METER, line_width=width, opacity=opacity)
    if part.paint is not None and scale is not None:
        return _paint(plotter, part, scale, lift=1.0, opacity=opacity_of(part))
    return None


def add_cells(plotter: pyvista.Plotter, part: Part, scale: night.Scale | None) -> object | None:
    """What a volume detector read, on cuts.  Returns the painted actor."""
    return None if scale is None else _paint(plotter, part, scale, lift=0.0, opacity=1.0, colours=night.CELLS)


def name_of(part: Part, up: np.ndarray) -> tuple[np.ndarray, str] | None:
    """Where to write the name of a detector [m], at the highest place of its outline, and what it read."""
    if isinstance(part.shape, Point):
        place = np.array(part.shape.position)
    else:
        points = part.outlined().points
        if len(points) == 0:  # smooth all over, as a fine mesh
            points = part.drawn().points
        if len(points) == 0:
            return None
        place = points[np.argmax(np.round(points @ up / part.frame.size, 6))]
    name = textwrap.shorten(part.name, LONGEST, placeholder=" …")
    words = name if part.told is None else f"{name}   {night.in_words(part.told)}"
    return place, words


def add_labels(plotter: pyvista.Plotter, labels: list[tuple[np.ndarray, str]], colour: str) -> None:
    """Words at places in space; those that would lie on others are left out."""
    if not labels:
        return
    places = np.array([place for place, _ in labels], dtype=float)
    words = np.array([as_it_stands(each) for _, each in labels])
    size = night.sized(plotter, 15, night.LEGIBLE)
    widths = np.array([night.width_of(plotter, each, size) for each in words])
    is_right = _across(plotter, places) + widths > RIGHT
    for chosen, side in ((~is_right, "left"), (is_right, "right")):
        if chosen.any():
            _add_words(plotter, places[chosen], list(words[chosen]), colour, side, size)


def _across(plotter: pyvista.Plotter, places: np.ndarray) -> np.ndarray:
    """Where places lie in the window, from 0 at the left to 1."""
    aspect = plotter.window_size[0] / plotter.window_size[1]
    matrix = plotter.camera.GetCompositeProjectionTransformMatrix(aspect, -1, 1)
    matrix = np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])
    shown = np.column_stack([places, np.ones(len(places))]) @ matrix.T
    return 0.5 + 0.5 * shown[:, 0] / shown[:, 3]


def _add_words(
    plotter: pyvista.Plotter, places: np.ndarray, words: list[str], colour: str, side: str, size: int
) -> None:
    """Words at places [m], which are at their "left" or "right" end."""
    plotter.add_point_labels(
        places,
        words,
        justification_horizontal=side,
        font_size=size,
        bold=False,
        text_color=colour,
        font_file=night.font(),
        shape="rounded_rect" if side == "left" else None,  # it would lie beside words that end at a place
        shape_color=night.GROUND,
        shape_opacity=0.55,
        margin=3,
        show_points=False,
        always_visible=True,
    )


def _add_lines(plotter: pyvista.Plotter, lines: pyvista.PolyData, **look: object) -> None:
    """Draw an outline; of what is smooth all over there is none."""
    if lines.n_points:
        plotter.add_mesh(lines, lighting=False, **look)


def _paint(
    plotter: pyvista.Plotter,
    part: Part,
    scale: night.Scale,
    lift: float,
    opacity: float,
    colours: str = night.VALUES,
) -> object:
    drawn = part.drawn()
    values = scale.of(np.where(known(part), part.paint.values, np.nan))
    drawn.cell_data["shown"] = np.append(values, np.nan)[part.facets.bins]
    return plotter.add_mesh(
        _lifted(drawn, part, lift) if lift else drawn,
        scalars="shown",
        cmap=colours,
        clim=(scale.low, scale.high),
        nan_color=night.UNKNOWN,
        lighting=False,
        culling=HIDES[part.seen_from],
        opacity=opacity,
        show_scalar_bar=False,
    )


def _lifted(drawn: pyvista.PolyData, part: Part, steps: float) -> pyvista.PolyData:
    """Moved off the wall that it lies on, towards the side that counts."""
    areas = part.facets.vector_areas
    if len(areas) == 0 or drawn.n_points == 0 or (part.side is None and part.kind != "detector"):
        return drawn
    shift = steps * APART * part.frame.size * (-1.0 if part.side == BACK else 1.0)
    whole = areas.sum(axis=0)
    is_flat = np.linalg.norm(whole) > 0.999 * np.linalg.norm(areas, axis=1).sum()
    if is_flat:
        drawn.points = drawn.points + shift * whole / np.linalg.norm(whole)
        return drawn
    middle = np.array(part.shape.middle)
    drawn.points = middle + (drawn.points - middle) * (1 + shift / max(part.shape.extent, abs(shift)))
    return drawn


def _add_glow(plotter: pyvista.Plotter, place: np.ndarray) -> None:
    for size, opacity in HALO:
        plotter.add_points(
            place[None],
            color=night.GLOW,
            point_size=size,
            opacity=opacity,
            render_points_as_spheres=True,
            lighting=False,
        )


def _add_pyramid(plotter: pyvista.Plotter, camera: Camera, size: float) -> None:
    """What the camera's picture holds, as four rays and a rim."""
    left, up, ahead = (np.array(axis) for axis in camera.frame)
    edges = camera.edges()
    corners = [
        ahead - edges["u"][a] * left + edges["v"][b] * up for a, b in ((0, 0), (-1, 0), (-1, -1), (0, -1))
    ]
    place = np.array(camera.position)
    rim = place + 0.12 * size * np.array(corners) / np.linalg.norm(corners[0])
    starts = np.concatenate([np.repeat(place[None], 4, axis=0), rim])
    lines = segments(starts, np.concatenate([rim, np.roll(rim, -1, axis=0)]))
    plotter.add_mesh(lines, color=night.METER, line_width=1.6, lighting=False)


def _add_voxels(plotter: pyvista.Plotter, grid: Grid) -> None:
    """The extinction of each voxel as a fog that hides as much as it does, up to a depth."""
    import pyvista

    extinction = grid.extinction
    size, highest = float(np.linalg.norm(grid.box.size)), float(extinction.max())
    if highest == 0:
        return
    step = size / SAMPLES
    thinned = min(1.0, DEPTH / (extinction.mean() * np.cbrt(grid.box.volume)))
    image = pyvista.ImageData(
        dimensions=np.add(extinction.shape, 1),
        spacing=[side / count for side, count in zip(grid.box.size, extinction.shape, strict=True)],
        origin=grid.box.bounds[0],
    )
    shares = np.linspace(0, 1, 64)
    image.cell_data["extinction"] = (extinction / highest).ravel(order="F")
    plotter.add_volume(
        image.cell_data_to_point_data(),
        scalars="extinction",
        clim=(0.0, 1.0),
        cmap=[night.FOG, "#f4f7fb"],
        opacity=-np.expm1(-shares * thinned * highest * step),
        opacity_unit_distance=step,
        show_scalar_bar=False,
    )
