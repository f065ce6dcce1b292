"""Mesh topology: open, non-manifold and inconsistently oriented edges; equal rows."""

import math
from typing import NamedTuple

import numpy as np

HASH_MULTIPLIERS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)


class Edges(NamedTuple):
    """Numbers of edges with one triangle (open), with more than two (crowded), and of turned edges.

    A turned edge joins two triangles of opposite orientation.

    crowded_example, turned_example: the triangles at the first such edge.
    """

    open: int
    crowded: int
    turned: int
    crowded_example: tuple[int, ...]
    turned_example: tuple[int, ...]

    @property
    def are_paired(self) -> bool:
        """Whether every edge joins exactly two triangles of equal orientation."""
        return self.open == self.crowded == self.turned == 0


def edges_of(faces: np.ndarray) -> Edges:
    """Count the edges of triangles (m, 3) of vertex indices by kind."""
    # Encode each directed edge as an integer whose last bit is its direction.
    start, stop = faces.ravel(), faces[:, (1, 2, 0)].ravel()
    number = int(faces.max()) + 1
    coded = (np.minimum(start, stop) * number + np.maximum(start, stop)) * 2 + (start < stop)
    # Group equal undirected edges and count their triangles.
    in_order = np.sort(coded)
    undirected = in_order >> 1
    first = np.flatnonzero(np.concatenate([[True], undirected[1:] != undirected[:-1]]))
    sharers = np.diff(first, append=len(in_order))
    crowded, pairs = first[sharers > 2], first[sharers == 2]
    turned = pairs[in_order[pairs] == in_order[pairs + 1]]

    def example(places: np.ndarray) -> tuple[int, ...]:
        if len(places) == 0:
            return ()
        return tuple((np.flatnonzero(coded >> 1 == undirected[places[0]]) // 3).tolist())

    counts = (int((sharers == 1).sum()), len(crowded), len(turned))
    return Edges(*counts, example(crowded), example(turned))


def unique_rows(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First occurrence of each distinct row of three int64, and for each row the index of its equal.

    First occurrences are in ascending order.
    """
    keys = (rows.view(np.uint64) * HASH_MULTIPLIERS).sum(axis=1, dtype=np.uint64)
    _, first, label = np.unique(keys, return_index=True, return_inverse=True)
    if not np.array_equal(rows[first][label], rows):  # hash collision: compare the rows themselves
        _, first, label = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return first[order], rank[label.ravel()]


def repeated_triangles(faces: np.ndarray) -> tuple[int, tuple[int, int] | None]:
    """Number of triangles with the same three vertices as an earlier one, and the first such pair."""
    first, label = unique_rows(np.sort(faces, axis=1))
    if len(first) == len(faces):
        return 0, None
    earlier = first[label]
    again = int(np.flatnonzero(earlier != np.arange(len(faces)))[0])
    return len(faces) - len(first), (int(earlier[again]), again)


def drop_unused_vertices(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices that triangles use, in their order, and the triangles with the new indices."""
    used = np.zeros(len(vertices), dtype=bool)
    used[faces] = True
    if used.all():
        return vertices, faces
    return np.ascontiguousarray(vertices[used]), (np.cumsum(used) - 1)[faces]


# ---- Normals, areas and volume of many triangles at once, accurate for thin triangles.
#
# Twice the area is the cross product of two edges. Edges are kept as exact sums of two doubles, and products
# with their rounding errors (Dekker 1971; Shewchuk 1997, Adaptive precision floating-point arithmetic), so
# that the error is 2^-104 of the squared edge lengths: as small as the height that rounded coordinates can
# still represent.

ROUNDING = 2.0**-51  # relative to coordinates: triangles of smaller height count as lines
DEKKER_SPLITTER = 2.0**27 + 1
EPSILON = 2.0**-52


class Facets(NamedTuple):
    """Per triangle: unit normals (m, 3), areas (m,) [m^2], and whether its vertices are collinear."""

    normals: np.ndarray
    areas: np.ndarray
    is_collinear: np.ndarray


def facets(vertices: np.ndarray, faces: np.ndarray) -> Facets:
    """Unit normals (right-hand rule over the vertex order) and areas [m^2], accurate to a few roundings."""
    a, b, c = (np.ascontiguousarray(vertices[faces[:, i]].T) for i in range(3))
    (u, u_low), (v, v_low) = _two_difference(b, a), _two_difference(c, a)
    # Scale each triangle by a power of two, so that squares neither overflow nor underflow.
    _, exponent = np.frexp(np.maximum(np.abs(u), np.abs(v)).max(axis=0))
    u, u_low, v, v_low = (np.ldexp(part, -exponent) for part in (u, u_low, v, v_low))
    twice = np.stack([_cross_component(u, u_low, v, v_low, i, j) for i, j in ((1, 2), (2, 0), (0, 1))])
    # Compare the height with the rounding of the coordinates.
    length = np.sqrt((twice * twice).sum(axis=0))
    longest = np.sqrt(np.maximum.reduce([(offset * offset).sum(axis=0) for offset in (u, v, v - u)]))
    magnitude = np.abs(np.concatenate([a, b, c])).max(axis=0)
    with np.errstate(over="ignore", under="ignore", invalid="ignore", divide="ignore"):
        on_a_line = ~(length > ROUNDING * np.ldexp(magnitude, -exponent) * longest)
        normals = np.ascontiguousarray((twice / length).T) + 0.0
        areas = np.ldexp(length / 2, 2 * exponent)
    return Facets(normals, areas, on_a_line)


def signed_volume(
    vertices: np.ndarray, faces: np.ndarray, normals: np.ndarray, areas: np.ndarray
) -> tuple[float, float]:
    """Volume [m^3] of a closed mesh (negative if normals point inwards), and a bound on its rounding error.

    Divergence theorem: a third of the sum of area times signed distance of the triangle's plane from the
    middle.
    """
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    offset = vertices[faces[:, 0]] - (low + (high - low) / 2)
    terms = offset * normals * areas[:, None]
    return math.fsum(terms.ravel()) / 3, 4 * EPSILON * float(np.abs(terms).sum())


def winding_number(vertices: np.ndarray, faces: np.ndarray, point: np.ndarray) -> float:
    """Winding number of the mesh around a point: solid angle over 4π (Van Oosterom and Strackee 1983, eq. 8).

    A facet that contains the point counts as 0, so that a point in a facet of a closed mesh has winding
    number 1/2.
    """
    a, b, c = ((vertices - point)[faces[:, i]] for i in range(3))
    p, q, r = (np.sqrt((offset * offset).sum(axis=1)) for offset in (a, b, c))
    above = (a * np.cross(b, c)).sum(axis=1)
    below = p * q * r + (a * b).sum(axis=1) * r + (b * c).sum(axis=1) * p + (c * a).sum(axis=1) * q
    return math.fsum(2 * np.arctan2(above, below)[above != 0]) / (4 * math.pi)


def _cross_component(u, u_low, v, v_low, i: int, j: int) -> np.ndarray:
    """u_i v_j - u_j v_i of vectors given as sums of two doubles."""
    (plus, plus_low), (minus, minus_low) = _two_product(u[i], v[j]), _two_product(u[j], v[i])
    high, low = _two_difference(plus, minus)
    mixed = (u[i] * v_low[j] - u[j] * v_low[i]) + (u_low[i] * v[j] - u_low[j] * v[i])
    return high + (low + ((plus_low - minus_low) + mixed))


def _two_difference(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """a - b as a double and its rounding error."""
    high = a - b
    b_seen = a - high
    return high, (a - (high + b_seen)) + (b_seen - b)


def _two_product(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """a b as a double and its rounding error."""
    high = a * b
    (a_high, a_low), (b_high, b_low) = _split(a), _split(b)
    return high, ((a_high * b_high - high) + a_high * b_low + a_low * b_high) + a_low * b_low


def _split(a: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Split a double into the sum of two 26-bit numbers (Dekker)."""
    spread = DEKKER_SPLITTER * a
    high = spread - (spread - a)
    return high, a - high


# ---- Merges coincident vertices and drops triangles that collapse.


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
    first, label = unique_rows(vertices.view(np.int64))
    welded, faces = vertices[first], label[np.asarray(faces)]
    if tolerance > 0:
        group = _cluster_points(welded, tolerance)
        welded, faces = welded[np.unique(group, return_index=True)[1]], group[faces]
    a, b, c = faces.T
    keeps = (a != b) & (b != c) & (c != a)
    return Welded(welded, faces[keeps], len(vertices) - len(welded), int((~keeps).sum()))


def _cluster_points(points: np.ndarray, tolerance: float) -> np.ndarray:
    """Group number of each point, in the order of the groups' first points."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(points).query_pairs(tolerance, output_type="ndarray")
    links = coo_array((np.ones(len(pairs), dtype=bool), tuple(pairs.T)), shape=(len(points),) * 2)
    _, group = connected_components(links, directed=False)
    _, first, group = np.unique(group, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[group.ravel()]
