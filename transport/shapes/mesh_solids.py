"""Triangulated solids: a sphere (subdivided icosahedron) and a box."""

import math

import numpy as np

from transport.shapes.mesh_weld import weld

GOLDEN = (1 + math.sqrt(5)) / 2
CORNERS = np.array(
    [(0, s, t * GOLDEN) for s in (-1, 1) for t in (-1, 1)]
    + [(s, t * GOLDEN, 0) for s in (-1, 1) for t in (-1, 1)]
    + [(t * GOLDEN, 0, s) for s in (-1, 1) for t in (-1, 1)]
)


def sphere_arrays(center: tuple[float, ...], radius: float, triangles: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices on a sphere [m] and at least `triangles` triangles, 20 f^2, of a subdivided icosahedron.

    Points of a shared edge are computed by identical sums on both sides, so that they merge exactly.
    """
    f = max(1, math.isqrt(max(triangles - 1, 0) // 20) + 1)
    a, b, c = (CORNERS[faces] for faces in _icosahedron().T)
    # Place points of the divided face at integer barycentric coordinates (i, j, f - i - j).
    i, j = (index.ravel() for index in np.meshgrid(range(f + 1), range(f + 1), indexing="ij"))
    i, j = i[i + j <= f], j[i + j <= f]
    points = (i[:, None] * a[:, None, :] + j[:, None] * b[:, None, :]) + (f - i - j)[:, None] * c[:, None, :]
    points = points.reshape(-1, 3)
    # Number the points of one face, and list its upright and inverted triangles.
    place = np.full((f + 2, f + 2), -1)
    place[i, j] = np.arange(len(i))
    upright = np.stack([place[i, j], place[i + 1, j], place[i, j + 1]], axis=1)[i + j < f]
    turned = np.stack([place[i, j], place[i - 1, j], place[i, j - 1]], axis=1)[(i > 0) & (j > 0)]
    one_side = np.concatenate([upright, turned])
    # Repeat for all 20 faces, merge shared points, and project them onto the sphere.
    faces = (one_side[None] + len(i) * np.arange(20)[:, None, None]).reshape(-1, 3)
    points, faces, *_ = weld(points, faces)
    return radius * (points / np.linalg.norm(points, axis=1)[:, None]) + center, faces


def box_arrays(low: tuple[float, ...], high: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Eight corners [m] of an axis-aligned box, and twelve triangles with outward normals."""
    ends = np.array([low, high])
    vertices = np.array([ends[(x, y, z), (0, 1, 2)] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return vertices, np.array([(p, q, r) for a, b, c, d in sides for p, q, r in ((a, b, c), (a, c, d))])


def _icosahedron() -> np.ndarray:
    """The 20 triples of adjacent corners, with outward normals."""
    # Adjacent corners, at edge length 2, have the scalar product phi.
    near = np.abs(CORNERS @ CORNERS.T - GOLDEN) < 0.1
    faces = [
        (a, b, c)
        for a in range(12)
        for b in range(a)
        for c in range(b)
        if near[a, b] and near[b, c] and near[a, c]
    ]
    return np.array([(a, b, c) if np.linalg.det(CORNERS[[a, b, c]]) > 0 else (a, c, b) for a, b, c in faces])
