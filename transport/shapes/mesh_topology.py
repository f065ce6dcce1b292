"""Mesh topology: open, non-manifold and inconsistently oriented edges; equal rows."""

from typing import NamedTuple

import numpy as np

MIXERS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)


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


def equal_rows(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First occurrence of each distinct row of three int64, and for each row the index of its equal.

    First occurrences are in ascending order.
    """
    keys = (rows.view(np.uint64) * MIXERS).sum(axis=1, dtype=np.uint64)
    _, first, label = np.unique(keys, return_index=True, return_inverse=True)
    if not np.array_equal(rows[first][label], rows):  # hash collision: compare the rows themselves
        _, first, label = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return first[order], rank[label.ravel()]


def repeated_triangles(faces: np.ndarray) -> tuple[int, tuple[int, int] | None]:
    """Number of triangles with the same three vertices as an earlier one, and the first such pair."""
    first, label = equal_rows(np.sort(faces, axis=1))
    if len(first) == len(faces):
        return 0, None
    earlier = first[label]
    again = int(np.flatnonzero(earlier != np.arange(len(faces)))[0])
    return len(faces) - len(first), (int(earlier[again]), again)


def without_unused(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices that triangles use, in their order, and the triangles with the new indices."""
    used = np.zeros(len(vertices), dtype=bool)
    used[faces] = True
    if used.all():
        return vertices, faces
    return np.ascontiguousarray(vertices[used]), (np.cumsum(used) - 1)[faces]
