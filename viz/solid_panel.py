"""A drawing in space as a panel of a figure: solid objects are drawn by PyVista, text stands over them in the figure's type.

>>> panel = SolidPanel(viewer=(1, -2, 1))  # doctest: +SKIP
>>> panel.polygon([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], BLUE)  # doctest: +SKIP
>>> panel.arrow((0.5, 0.5, 0), (0, 0, 1), INK, text="n")  # doctest: +SKIP
>>> with figure((8, 6), "A patch", path="patch.png") as page:  # doctest: +SKIP
...     panel.show(page.subplots())
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.patheffects import withStroke
from matplotlib.text import Text
from numpy.typing import ArrayLike

from transport.vectors import unit_vector
from transport.viz.facets import as_polydata, grid_facets
from transport.viz.screen import require_screen
from transport.viz.style import INK, SEQUENTIAL

if TYPE_CHECKING:
    import pyvista

ROUND = 24  # sides of tubes and arrows
BALL_SIDES = 12  # of the many balls that stand for particles
SHAFT = 0.4  # radius of an arrow's shaft over that of its head
HEAD = 3.2  # length of an arrow's head over its radius
DASHES = 0.05  # length of a dash with its gap, of the line
SUPERSAMPLED = 2  # pixels of the drawing per pixel of the figure, along a side
LABEL = {"fontweight": "bold", "fontsize": 22}  # of letters and numbers at objects
MATT = {"ambient": 0.6, "diffuse": 0.55, "specular": 0.0}
FLAT = {"ambient": 1.0, "diffuse": 0.0}
FAR = 10.0  # of the drawing's size: distance of the camera, which sees without perspective


class SolidPanel:
    """Objects in space, seen without perspective, so that parallel lines stay parallel.

    Parameters
    ----------
    viewer : vector of 3 floats
        Direction from the objects to the viewer.
    up : vector of 3 floats, default +z
        Direction that points up in the figure.

    Raises
    ------
    NoScreen
        If this machine cannot draw in 3-D.

    Notes
    -----
    Coordinates of the axes after `show` are lengths: a place p stands at `panel.projected(p)`.
    """

    def __init__(self, viewer: ArrayLike, up: ArrayLike = (0, 0, 1)) -> None:
        require_screen()
        import pyvista

        self.plotter = pyvista.Plotter(off_screen=True)
        self.viewer = np.array(unit_vector(tuple(np.asarray(viewer, dtype=float).tolist())))
        right = np.array(unit_vector(tuple(np.cross(up, self.viewer).tolist())))
        self.screen = np.stack([right, np.cross(self.viewer, right)])
        self.words: list[tuple[np.ndarray, str, dict]] = []
        self.corners: list[np.ndarray] = []

    def projected(self, places: ArrayLike) -> np.ndarray:
        """Return the places (..., 3) in the coordinates of the axes (..., 2)."""
        return np.asarray(places, dtype=float) @ self.screen.T

    def mesh(self, mesh: pyvista.PolyData, colour: str | None = None, **look: object) -> None:
        """Add a mesh.  look: arguments of `pyvista.Plotter.add_mesh`."""
        self.corners.append(self.projected(mesh.points))
        self.plotter.add_mesh(mesh, color=colour, show_scalar_bar=False, **MATT | look)

    def polygon(self, corners: ArrayLike, colour: str, opacity: float = 1.0) -> None:
        """Add a flat polygon (N, 3)."""
        import pyvista

        corners = np.asarray(corners, dtype=float)
        face = [len(corners), *range(len(corners))]
        self.mesh(pyvista.PolyData(corners, face), colour, opacity=opacity, **FLAT)

    def bins(self, points: np.ndarray, values: np.ndarray, norm: Normalize) -> None:
        """Add a curved sheet of bins between a net of points (n + 1, m + 1, 3), coloured by values (n, m)."""
        mesh = as_polydata(grid_facets(points, values))
        mesh.cell_data["colour"] = colormaps[SEQUENTIAL](norm(values.ravel()))[:, :3]
        self.mesh(mesh, scalars="colour", rgb=True, **FLAT)

    def line(self, places: ArrayLike, colour: str, width: float, is_dashed: bool = False) -> None:
        """Add a line through places (N, 3), as a tube of this radius [m]."""
        import pyvista

        places = np.asarray(places, dtype=float)
        for part in _dashes(places) if is_dashed else [places]:
            self.mesh(pyvista.lines_from_points(part).tube(radius=width, n_sides=ROUND, capping=True), colour)

    def loop(self, corners: ArrayLike, colour: str, width: float, is_dashed: bool = False) -> None:
        """Add the closed outline of corners (N, 3), side by side."""
        corners = np.asarray(corners, dtype=float)
        for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            self.line([start, end], colour, width, is_dashed)

    def arrow(self, start: ArrayLike, way: ArrayLike, colour: str, width: float, text: str = "") -> None:
        """Add an arrow from a place along a vector, its head of radius `width` [m], with text beyond its end."""
        import pyvista

        start, way = np.asarray(start, dtype=float), np.asarray(way, dtype=float)
        length = float(np.linalg.norm(way))
        shape = {"tip_radius": width / length, "shaft_radius": SHAFT * width / length}
        made = pyvista.Arrow(
            start=start, direction=way, scale=length, tip_length=min(0.6, HEAD * width / length), tip_resolution=ROUND,
            shaft_resolution=ROUND, **shape,
        )  # fmt: skip
        self.mesh(made, colour)
        if text:
            self.text(
                start + way * (1 + 2.4 * width / length), text, color=colour, fontweight="bold", fontsize=22
            )

    def balls(self, places: ArrayLike, colour: str, radius: float) -> None:
        """Add balls of one radius [m] round places (N, 3)."""
        import pyvista

        if len(places):
            ball = pyvista.Sphere(radius=radius, theta_resolution=BALL_SIDES, phi_resolution=BALL_SIDES)
            cloud = pyvista.PolyData(np.asarray(places, dtype=float))
            self.mesh(cloud.glyph(geom=ball, scale=False, orient=False), colour, smooth_shading=True)

    def text(self, place: ArrayLike, words: str, **style: object) -> None:
        """Write words at a place.  style: of the text in matplotlib."""
        self.words.append((self.projected(place), words, style))

    def show(self, axes: Axes, limits: ArrayLike | None = None) -> list[Text]:
        """Draw all into axes without a frame, and return the texts.

        limits: lower left and upper right corner of the panel [default: `self.limits()`].
        """
        low, high = self.limits() if limits is None else np.array(limits, dtype=float)
        width, height = high - low
        of_figure = axes.figure.get_size_inches() * axes.figure.dpi * axes.get_position().size
        pixels = SUPERSAMPLED * min(of_figure[0] / width, of_figure[1] / height)
        plotter, middle = self.plotter, ((low + high) / 2) @ self.screen
        plotter.window_size = [max(1, round(pixels * width)), max(1, round(pixels * height))]
        camera, size = plotter.camera, math.hypot(width, height)
        camera.parallel_projection, camera.parallel_scale = True, height / 2
        camera.focal_point, camera.up = middle, self.screen[1]
        camera.position = middle + FAR * size * self.viewer
        plotter.enable_anti_aliasing("msaa")
        plotter.reset_camera_clipping_range()
        image = plotter.screenshot(transparent_background=True, return_img=True)
        plotter.close()
        axes.imshow(image, extent=(low[0], high[0], low[1], high[1]), interpolation="antialiased", zorder=0)
        axes.set(aspect="equal", xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        axes.axis("off")
        rim = [withStroke(linewidth=5, foreground="white")]
        look = {"ha": "center", "va": "center", "color": INK, "path_effects": rim}
        return [axes.text(*place, words, **look | style) for place, words, style in self.words]

    def limits(self, margin: float = 0.04) -> tuple[np.ndarray, np.ndarray]:
        """Return the corners of what is drawn, with a margin of its size."""
        corners = np.concatenate(self.corners)
        low, high = corners.min(axis=0), corners.max(axis=0)
        room = margin * (high - low).max()
        return low - room, high + room


def _dashes(places: np.ndarray) -> list[np.ndarray]:
    """Parts of a line, each half as long as it is to the next."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))])
    starts = np.arange(0, 1, DASHES) * along[-1]
    ends = starts + 0.55 * DASHES * along[-1]
    at = lambda s: np.array([np.interp(s, along, axis) for axis in places.T])  # noqa: E731
    return [np.stack([at(a), at(b)]) for a, b in zip(starts, ends, strict=True)]
