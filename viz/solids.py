"""Shapes, outlines and flights as what VTK draws: PolyData in metres, normals those of the shapes."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

import numpy as np

from transport.geometry.flat import Disk, Plane, Rectangle, Slab
from transport.geometry.mesh import Mesh
from transport.geometry.polygon import Polygon
from transport.geometry.revolved import Revolved
from transport.geometry.shape import Cloud, Point, Shape
from transport.geometry.solid import Box, Sphere
from transport.scene.bins import Positions
from transport.viz.facets import TURN, Bounds, Facets, facets_of

if TYPE_CHECKING:
    import pyvista

SHARP = 30.0  # degrees between two triangles of a mesh, beyond which their edge is drawn
MOST_EDGES = 20_000  # of a mesh
LEVELS = 11  # lines round a form of one colour


def solid(shape: Shape, positions: Positions | None = None, bounds: Bounds | None = None) -> pyvista.PolyData:
    """The shape as PolyData [m], with the cell arrays "bin" (flat, u before v; -1: none) and "Normals".

    positions: its cells are cut along these bins;  bounds: where a shape without end is cut off.
    """
    return as_polydata(facets_of(shape, positions, bounds))


def as_polydata(facets: Facets) -> pyvista.PolyData:
    """Facets as PolyData with the cell arrays "bin" and "Normals"; a point alone as a vertex."""
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


def outline(shape: Shape, bounds: Bounds | None = None) -> pyvista.PolyData:
    """The lines that show a shape: its rims and edges, a few meridians of what is round [m]."""
    match shape:
        case Mesh():
            return _edges_of(shape)
        case Plane():
            return segments(*_sides_of(facets_of(shape, None, bounds)))
    return polylines(_lines_of(shape, bounds))


def polylines(lines: list[np.ndarray]) -> pyvista.PolyData:
    """Lines through points, each (n, 3) [m]."""
    import pyvista

    points = np.concatenate(lines) if lines else np.zeros((0, 3))
    firsts = itertools.accumulate((len(line) for line in lines), initial=0)
    rows = [
        np.r_[len(line), np.arange(len(line)) + first] for line, first in zip(lines, firsts, strict=False)
    ]
    return pyvista.PolyData(points, lines=np.concatenate(rows)) if lines else pyvista.PolyData()


def segments(starts: np.ndarray, ends: np.ndarray) -> pyvista.PolyData:
    """Straight lines from starts to ends, (n, 3) each [m]: cell k is the k-th."""
    import pyvista

    points = np.stack([starts, ends], axis=1).reshape(-1, 3)
    rows = np.full((len(starts), 3), 2)
    rows[:, 1:] = np.arange(2 * len(starts)).reshape(-1, 2)
    return pyvista.PolyData(points, lines=rows.ravel())


def contours(drawn: pyvista.PolyData, lift: float) -> pyvista.PolyData:
    """Level lines of what is not flat, as on a map of mountains: they show its form where it is of one colour.

    drawn: as `as_polydata` gives it;  lift: how far along its normals they stand off it [m].
    """
    low, high = np.reshape(drawn.bounds, (3, 2)).T
    normals = drawn.cell_data["Normals"]
    if np.linalg.matrix_rank(normals[:: max(1, len(normals) // 200)], tol=1e-3) < 2:
        return polylines([])
    axis = 2 if high[2] - low[2] > 0.1 * (high - low).max() else int(np.argmax(high - low))
    starts, ends = [], []
    for level in np.linspace(low[axis], high[axis], LEVELS + 2)[1:-1]:
        cut = drawn.slice(normal="xyz"[axis], origin=np.eye(3)[axis] * level)
        if cut.n_cells:
            ways = cut.points[cut.lines.reshape(-1, 3)[:, 1:]] + lift * cut.cell_data["Normals"][:, None]
            starts.append(ways[:, 0])
            ends.append(ways[:, 1])
    return segments(np.concatenate(starts), np.concatenate(ends)) if starts else polylines([])


def _lines_of(shape: Shape, bounds: Bounds | None) -> list[np.ndarray]:
    match shape:
        case Rectangle():
            e_u, e_v, _ = (np.array(axis) for axis in shape.frame)
            rim = [a * shape.width / 2 * e_u + b * shape.height / 2 * e_v for a, b in _SQUARE]
            return [np.array(shape.center) + np.array(rim)] + (
                [] if shape.hole is None else _lines_of(shape.hole, bounds)
            )
        case Disk():
            radii = [radius for radius in (shape.radius, shape.inner_radius) if radius > 0]
            return [_circle(shape, radius, 0.0) for radius in radii]
        case Polygon():
            return [np.array([*shape.vertices, shape.vertices[0]])]
        case Box():
            return _box_lines(*(np.array(corner) for corner in shape.bounds))
        case Cloud() | Point():
            return []
        case Slab():
            return [line for plane in shape.planes() for line in _rim_of(facets_of(plane, None, bounds))]
        case Sphere():
            return _rims(shape) + [_circle(shape, shape.radius, 0.0)] * (shape.mu_min < 0 < shape.mu_max)
        case Revolved():
            return _rims(shape)
    return _rim_of(facets_of(shape, None, bounds))


_SQUARE = ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))


def _circle(shape: Shape, radius: float, height: float) -> np.ndarray:
    """Round the shape's axis at a height [m] over its center."""
    e_u, e_v, n = (np.array(axis) for axis in shape.frame)
    v = np.linspace(0, TURN, 121)[:, None]
    return np.array(shape.center) + radius * (np.cos(v) * e_u + np.sin(v) * e_v) + height * n


def _rims(shape: Revolved) -> list[np.ndarray]:
    """The circles at both ends of a surface of revolution, and four meridians."""
    profile = shape.profile
    e_u, e_v, n = (np.array(axis) for axis in shape.frame)
    heights = profile.low + (profile.high - profile.low) * (1 - np.cos(np.linspace(0, math.pi, 49))) / 2
    radii = profile.radius_at(heights)
    ends = [(radii[end], heights[end] + profile.lift) for end in (0, -1)]
    circles = [_circle(shape, radius, height) for radius, height in ends if radius > 0]
    ways = [math.cos(k * math.pi / 2) * e_u + math.sin(k * math.pi / 2) * e_v for k in range(4)]
    center = np.array(shape.center)
    return circles + [center + radii[:, None] * way + (heights + profile.lift)[:, None] * n for way in ways]


def _box_lines(low: np.ndarray, high: np.ndarray) -> list[np.ndarray]:
    x, y = (low[0], high[0]), (low[1], high[1])
    loop = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)]
    lines = [np.array([(x[a], y[b], z) for a, b in loop]) for z in (low[2], high[2])]
    return lines + [np.array([(x[a], y[b], low[2]), (x[a], y[b], high[2])]) for a, b in loop[:4]]


def _rim_of(facets: Facets) -> list[np.ndarray]:
    """Round the points of one flat piece, in their order."""
    return [] if len(facets.points) == 0 else [np.vstack([facets.points, facets.points[:1]])]


def _sides_of(facets: Facets) -> tuple[np.ndarray, np.ndarray]:
    return facets.points, np.roll(facets.points, -1, axis=0)


def _edges_of(mesh: Mesh) -> pyvista.PolyData:
    """The open edges of a mesh and its sharp ones."""
    import pyvista

    drawn = pyvista.PolyData.from_regular_faces(mesh.vertices, mesh.faces)
    found = drawn.extract_feature_edges(feature_angle=SHARP, manifold_edges=False, non_manifold_edges=True)
    return found if found.n_cells <= MOST_EDGES else polylines(_box_lines(*map(np.array, mesh.bounds)))
