"""Merges coincident vertices and drops triangles that collapse."""

from typing import NamedTuple

import numpy as np

from transport.shapes.mesh_topology import equal_rows


class Welded(NamedTuple):
    """Vertices, triangles, and how many vertices were merged and triangles collapsed."""

    vertices: np.ndarray
    faces: np.ndarray
    merged: int
    collapsed: int


def weld(vertices: np.ndarray, faces: np.ndarray, tolerance: float = 0.0) -> Welded:
    """Merge vertices with equal coordinates, or linked by chains of steps up to `tolerance` [m].

    A merged vertex is the first of its group: no new positions arise.
    """
    vertices = np.ascontiguousarray(vertices, dtype=np.float64) + 0.0  # -0.0 equals 0.0
    first, label = equal_rows(vertices.view(np.int64))
    welded, faces = vertices[first], label[np.asarray(faces)]
    if tolerance > 0:
        group = _groups(welded, tolerance)
        welded, faces = welded[np.unique(group, return_index=True)[1]], group[faces]
    a, b, c = faces.T
    keeps = (a != b) & (b != c) & (c != a)
    return Welded(welded, faces[keeps], len(vertices) - len(welded), int((~keeps).sum()))


def _groups(points: np.ndarray, tolerance: float) -> np.ndarray:
    """Group number of each point, in the order of the groups' first points."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(points).query_pairs(tolerance, output_type="ndarray")
    links = coo_array((np.ones(len(pairs), dtype=bool), tuple(pairs.T)), shape=(len(points),) * 2)
    _, group = connected_components(links, directed=False)
    _, first, group = np.unique(group, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[group.ravel()]
