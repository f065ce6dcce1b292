"""Shapes as flat facets that know their bin: what is drawn of a shape, and where on it a detector's bins lie.

A facet's corners are ordered so that its right-hand normal is that of the shape. Outlines and level lines are made of
the same facets.
"""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from transport.geometry.flat import Disk, FlatPolygon, Plane, Rectangle, Slab
from transport.geometry.mesh import Mesh
from transport.geometry.revolved import Cylinder, Paraboloid, Revolved
from transport.geometry.shape import Cloud, Point, Shape
from transport.geometry.solid import Box, Sphere
from transport.scene.bins import Positions

if TYPE_CHECKING:
    import pyvista

TURN = 2 * math.pi
ROUND = TURN / 120  # [rad] largest step of an angle
PARABOLOID_RINGS = 24
CUT_STEPS = 90  # facets around a shell in a cut
CLOUD_SIGMAS = 2.0  # radius at which a Gaussian cloud is drawn; it holds 74 % of the particles
SHARP = 30.0  # [degrees] between two facets, above which their common edge belongs to the outline
MAX_EDGES = 20_000  # of an outline; a mesh with more is outlined by its bounding box
LEVELS = 11  # level lines across a shape
SQUARE = np.array(((-1, -1), (1, -1), (1, 1), (-1, 1)))
BOX_FACES = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])

Bounds = tuple[np.ndarray, np.ndarray]  # lower and upper corner [m]


class Facets(NamedTuple):
    """Flat facets.

    `points` (n, 3) [m]; `faces` (m, 3 or 4): rows of points; `bins` (m,): flat number of each facet's bin, u
    before v, or -1 outside all bins. A shape without positions is bin 0 as a whole.
    """

    points: np.ndarray
    faces: np.ndarray
    bins: np.ndarray

    @property
    def centres(self) -> np.ndarray:
        """Centres of the facets, (m, 3) [m]."""
        return self.points[self.faces].mean(axis=1)

    @property
    def vector_areas(self) -> np.ndarray:
        """Normal times area of each facet, (m, 3) [m^2]."""
        corners = self.points[self.faces]
        return 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1])

    @property
    def triangles(self) -> np.ndarray:
        """The facets as rows of three points, each quadrilateral as two."""
        if self.faces.shape[1] == 3:
            return self.faces
        return np.concatenate([self.faces[:, [0, 1, 2]], self.faces[:, [0, 2, 3]]])


def facets_of(
    shape: Shape, positions: Positions | None = None, bounds: Bounds | None = None, step: float = ROUND
) -> Facets:
    """Return the facets of a shape, cut along the bins of `positions`; an infinite shape is cut to `bounds` [m].

    `step` is the largest step of an angle [rad] on a round shape.
    """
    match shape:
        case Rectangle() if shape.hole is not None:
            return _around_hole(shape)
        case Rectangle() | Disk() | Revolved():
            return _on_coordinates(shape, positions, step)
        case Box():
            return box_facets(shape.bounds)
        case FlatPolygon():
            corners = np.array([triangle.vertices for triangle in shape.primitives()])
            return _plain(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
        case Mesh():
            return _plain(shape.vertices, shape.faces)
        case Plane():
            return _cut_plane(shape, bounds)
        case Slab():
            return joined([_cut_plane(plane, bounds) for plane in shape.planes()])
        case Cloud():
            ball = facets_of(Sphere(radius=CLOUD_SIGMAS), None, None, step)
            return ball._replace(points=np.array(shape.center) + ball.points * np.array(shape.sigma))
        case Point():
            return _plain(np.array([shape.position]), np.zeros((0, 3), dtype=int))
    raise TypeError(f"facets_of: no facets of a {type(shape).__name__}")


def grid_facets(points: np.ndarray, bins: np.ndarray, is_reversed: bool = False) -> Facets:
    """Quadrilaterals between neighbours of a grid of points (n, m, 3), of bins (n - 1, m - 1)."""
    rows, columns = points.shape[:2]
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    corners = (0, 1, columns + 1, columns) if is_reversed else (0, columns, columns + 1, 1)
    return Facets(points.reshape(-1, 3), first[:, None] + np.array(corners), bins.ravel())


def joined(several: list[Facets]) -> Facets:
    """Join facets of equally many corners."""
    starts = np.cumsum([0] + [len(each.points) for each in several])
    return Facets(
        np.concatenate([each.points for each in several]),
        np.concatenate([each.faces + start for each, start in zip(several, starts, strict=False)]),
        np.concatenate([each.bins for each in several]),
    )


def box_facets(bounds: Bounds) -> Facets:
    """The six faces of a box between two corners [m]."""
    return _plain(np.array(list(itertools.product(*zip(*bounds, strict=True)))), BOX_FACES)


def half_box(plane: Plane, bounds: Bounds) -> Facets:
    """The part of a box's faces behind a plane, as triangles."""
    box = box_facets(bounds)
    rims = [_clip(box.points[face], np.array(plane.normal), plane.center) for face in box.faces]
    return joined([_polygon(rim) for rim in rims])


def cell_cuts(shape: Shape, edges: dict[str, np.ndarray], brightest: int) -> Facets:
    """Cuts through the cells of a volume detector: across each axis of a box, through one cell; else through the middle.

    `edges`: of its cells; `brightest`: flat number of the cell through which a box is cut.
    """
    center = np.array(shape.middle)
    if isinstance(shape, Sphere):
        radii, turns = edges["r"][:, None, None], np.linspace(0, TURN, CUT_STEPS + 1)[:, None]
        shells = np.repeat(np.arange(len(radii) - 1)[:, None], CUT_STEPS, axis=1)
        axes = [np.roll(np.eye(3), -k, axis=0) for k in range(3)]
        rings = [radii * (np.cos(turns) * one + np.sin(turns) * other) for _, one, other in axes]
        return joined([grid_facets(center + ring, shells) for ring in rings])
    if isinstance(shape, Cylinder):
        radii, heights = edges["r"], edges["z"][:, None]
        cells = np.arange((len(radii) - 1) * (len(heights) - 1)).reshape(len(radii) - 1, -1)
        rho = np.concatenate([-radii[:0:-1], radii])[:, None, None]
        halves = [rho * np.array(across) + heights * np.array(shape.axis) for across in shape.frame[:2]]
        return joined([grid_facets(center + half, np.concatenate([cells[::-1], cells])) for half in halves])
    numbers = np.arange(math.prod(len(each) - 1 for each in edges.values()))
    numbers = numbers.reshape([len(each) - 1 for each in edges.values()])
    found = []
    for axis, layer in enumerate(np.unravel_index(brightest, numbers.shape)):
        axes = list(edges.values())
        axes[axis] = axes[axis][layer : layer + 2].mean()
        points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).squeeze(axis)
        found.append(grid_facets(points, np.take(numbers, layer, axis=axis)))
    return joined(found)


def places_on(shape: Rectangle | Disk | Revolved, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return the places (..., 3) [m] at coordinates u, v of a shape (transport.scene.bins.Positions)."""
    e_u, e_v, n = (np.array(axis) for axis in shape.frame)
    if isinstance(shape, Rectangle):
        a, b, height = u, v, 0.0
    else:
        if isinstance(shape, Disk):
            rho, height = u, 0.0
        elif isinstance(shape, Sphere):
            rho, height = shape.radius * np.sin(u), shape.radius * np.cos(u)
        else:
            rho, height = shape.profile.radius_at(u - shape.profile.lift), u
        a, b = rho * np.cos(v), rho * np.sin(v)
    a, b, height = (each[..., None] for each in np.broadcast_arrays(a, b, height))
    return np.array(shape.center) + a * e_u + b * e_v + height * n


def refined(edges: np.ndarray, longest: float) -> tuple[np.ndarray, np.ndarray]:
    """Divide intervals into equal steps of at most `longest`; return all edges, and the interval of each step."""
    counts = np.maximum(1, np.ceil(np.diff(edges) / longest * (1 - 1e-12))).astype(int)
    interval = np.repeat(np.arange(len(counts)), counts)
    share = (np.arange(counts.sum()) - (np.cumsum(counts) - counts)[interval]) / counts[interval]
    return np.append(edges[interval] + share * np.diff(edges)[interval], edges[-1]), interval


def _plain(points: np.ndarray, faces: np.ndarray) -> Facets:
    return Facets(np.asarray(points, dtype=float), faces, np.zeros(len(faces), dtype=int))


def _on_coordinates(shape: Rectangle | Disk | Revolved, positions: Positions | None, step: float) -> Facets:
    """A grid of facets along u and v."""
    whole = {name: np.array(limits[:2]) for name, limits in shape.coordinates().items()}
    edges = whole | ({} if positions is None else positions.edges(shape))
    longest = {"u": math.inf, "v": math.inf if isinstance(shape, Rectangle) else step}
    if isinstance(shape, Sphere):
        longest["u"] = step
    elif isinstance(shape, Paraboloid):
        longest["u"] = np.ptp(whole["u"]) * step / ROUND / PARABOLOID_RINGS
    (u, of_u), (v, of_v) = (_steps(whole[name], edges[name], longest[name]) for name in "uv")
    bins = np.where((of_u[:, None] < 0) | (of_v < 0), -1, of_u[:, None] * (len(edges["v"]) - 1) + of_v)
    # Where u goes along the axis, u, v and the normal are a left-handed frame.
    along_axis = isinstance(shape, Revolved) and not isinstance(shape, Sphere)
    return grid_facets(places_on(shape, u[:, None], v), bins, along_axis)


def _steps(whole: np.ndarray, edges: np.ndarray, longest: float) -> tuple[np.ndarray, np.ndarray]:
    """Steps over the whole range that include all edges; and the bin of each step, -1 outside."""
    marks = np.unique([*whole, *edges])
    steps, interval = refined(marks, longest)
    bins = np.searchsorted(edges, (marks[1:] + marks[:-1]) / 2) - 1
    return steps, np.where(bins < len(edges) - 1, bins, -1)[interval]


def _around_hole(shape: Rectangle) -> Facets:
    """Between the rims of the hole and of the rectangle, at angles about the hole's centre that hold every corner."""
    plane, center = np.array(shape.frame[:2]), np.array(shape.hole.center)
    rims = [(_rim(each) - center) @ plane.T for each in (shape.hole, shape)]
    angles = np.unique(np.concatenate([np.arctan2(rim[:, 1], rim[:, 0]) for rim in rims]))
    angles = np.append(angles, angles[0] + TURN)
    way = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    return grid_facets(
        np.array([center + (_distance_to_rim(rim, way)[:, None] * way) @ plane for rim in rims]),
        np.zeros(len(angles) - 1, dtype=int),
    )


def _rim(shape: Rectangle | Disk) -> np.ndarray:
    """The corners of a flat shape in cyclic order, (n, 3) [m]."""
    if isinstance(shape, Rectangle):
        return np.array(shape.center) + np.array(shape.corners) @ np.array(shape.frame[:2])
    return places_on(shape, shape.radius, np.arange(0, TURN, ROUND))


def _distance_to_rim(rim: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Distance from the origin to a convex rim around it, along each way."""
    side = np.roll(rim, -1, axis=0) - rim
    normal = np.stack([side[:, 1], -side[:, 0]], axis=-1)
    normal *= np.sign((normal * rim).sum(axis=1))[:, None]
    approach = way @ normal.T
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(approach > 0, (normal * rim).sum(axis=1) / approach, np.inf).min(axis=1)


def _clip(rim: np.ndarray, normal: np.ndarray, center: np.ndarray, tolerance: float = 0.0) -> np.ndarray:
    """The part of a convex polygon behind a plane (Sutherland and Hodgman 1974)."""
    height = (rim - np.array(center)) @ normal
    height[np.abs(height) < tolerance] = 0.0
    kept = []
    for k, here in enumerate(height):
        after = height[k - len(rim) + 1]
        if here <= 0:
            kept.append(rim[k])
        if here * after < 0:
            kept.append(rim[k] + here / (here - after) * (rim[k - len(rim) + 1] - rim[k]))
    return np.array(kept).reshape(-1, 3)


def _polygon(rim: np.ndarray) -> Facets:
    """Triangles of a convex polygon, none of fewer than three corners."""
    return _plain(rim, np.array([[0, k, k + 1] for k in range(1, len(rim) - 1)], dtype=int).reshape(-1, 3))


def _cut_plane(plane: Plane, bounds: Bounds | None) -> Facets:
    """The polygon in which a plane meets the box, as triangles; none where they do not meet."""
    if bounds is None:
        raise ValueError("facets_of: an infinite shape needs bounds")
    low, high = (np.asarray(corner, dtype=float) for corner in bounds)
    e_u, e_v, n = (np.array(axis) for axis in plane.frame)
    size, middle = np.linalg.norm(high - low), (low + high) / 2
    foot = middle - ((middle - np.array(plane.center)) @ n) * n
    rim = foot + size * SQUARE @ np.array([e_u, e_v])
    for axis in np.eye(3):
        rim = _clip(_clip(rim, axis, high, 1e-9 * size), -axis, low, 1e-9 * size)
    return _polygon(rim)


# ---- Facets and lines for VTK.


def as_polydata(facets: Facets) -> pyvista.PolyData:
    """Return facets as PolyData with the cell arrays "bin" and "Normals"; a single point as a vertex."""
    import pyvista

    if len(facets.faces) == 0:
        return pyvista.PolyData(facets.points)
    drawn = pyvista.PolyData.from_regular_faces(facets.points, facets.faces)
    areas = facets.vector_areas
    lengths = np.linalg.norm(areas, axis=1, keepdims=True)
    drawn.cell_data["Normals"] = np.divide(areas, lengths, out=np.zeros_like(areas), where=lengths > 0)
    drawn.cell_data["bin"] = facets.bins
    drawn.cell_data.active_normals_name = "Normals"
    return drawn


def segments(ends: np.ndarray) -> pyvista.PolyData:
    """Straight lines between pairs of places, (n, 2, 3) [m]."""
    import pyvista

    return pyvista.line_segments_from_points(ends.reshape(-1, 3)) if len(ends) else pyvista.PolyData()


def outline(shape: Shape, bounds: Bounds | None = None) -> pyvista.PolyData:
    """Lines that show a shape: its rims and sharp edges, four meridians of a round one, the equator of a sphere [m]."""
    import pyvista

    if isinstance(shape, Cloud | Point):
        return pyvista.PolyData()
    facets = facets_of(shape, None, bounds)
    found = _edges(facets)
    if found.n_cells > MAX_EDGES:
        found = _edges(box_facets(shape.bounds))
    if isinstance(shape, Revolved):
        # Rows of the grid of facets go along u, columns along v.
        grid = facets.points.reshape(-1, round(TURN / ROUND) + 1, 3)
        lines = [grid[:, k * (grid.shape[1] // 4)] for k in range(4)]
        if isinstance(shape, Sphere) and shape.mu_min < 0 < shape.mu_max:
            lines.append(places_on(shape, math.pi / 2, np.linspace(0, TURN, grid.shape[1])))
        found = found.append_polydata(*(polyline(line) for line in lines))
    return found


def polyline(points: np.ndarray) -> pyvista.PolyData:
    """A line through points (n, 3) [m]."""
    return segments(np.stack([points[:-1], points[1:]], axis=1))


def _edges(facets: Facets) -> pyvista.PolyData:
    """Edges of only one facet, and between facets that meet at an angle."""
    drawn = as_polydata(facets).clean(tolerance=1e-9, absolute=False)
    return drawn.extract_feature_edges(feature_angle=SHARP, manifold_edges=False, non_manifold_edges=True)


def level_lines(drawn: pyvista.PolyData, lift: float) -> pyvista.PolyData:
    """Level lines of facets that are not flat: they show the form of what has one colour.

    `drawn` is as `as_polydata` returns it; the lines stand off it by `lift` along its normals [m].
    """
    low, high = np.reshape(drawn.bounds, (3, 2)).T
    normals = drawn.cell_data["Normals"]
    is_flat = np.linalg.matrix_rank(normals[:: max(1, len(normals) // 200)], tol=1e-3) < 2
    axis = 2 if high[2] - low[2] > 0.1 * (high - low).max() else int(np.argmax(high - low))
    found = [np.zeros((0, 2, 3))]
    for level in [] if is_flat else np.linspace(low[axis], high[axis], LEVELS + 2)[1:-1]:
        cut = drawn.slice(normal="xyz"[axis], origin=np.eye(3)[axis] * level)
        if cut.n_cells:
            ends = cut.points[cut.lines.reshape(-1, 3)[:, 1:]]
            found.append(ends + lift * cut.cell_data["Normals"][:, None])
    return segments(np.concatenate(found))
