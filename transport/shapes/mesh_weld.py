"""Welding: vertices in one place become one, and triangles that collapse are left out."""

from typing import NamedTuple

import numpy as np

from transport.shapes.mesh_topology import equal_rows


class Welded(NamedTuple):
    """Vertices, triangles, and how many of each are gone."""

    vertices: np.ndarray
    faces: np.ndarray
    merged: int
    collapsed: int


def weld(vertices: np.ndarray, faces: np.ndarray, tolerance: float = 0.0) -> Welded:
    """Merge vertices whose coordinates are equal, or that chains of steps up to a tolerance [m] join.

    A merged vertex is the first of its group, so that no vertex gets a place that was not there.
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
    """For each point the number of its group, in the order of the groups' first points."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(points).query_pairs(tolerance, output_type="ndarray")
    links = coo_array((np.ones(len(pairs), dtype=bool), tuple(pairs.T)), shape=(len(points),) * 2)
    _, group = connected_components(links, directed=False)
    _, first, group = np.unique(group, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[group.ravel()]
