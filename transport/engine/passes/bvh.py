"""Bounding volume hierarchies (BVH) of boxes over the facets of a mesh, by the surface area heuristic.

Binned: 16 split planes along each axis are tried (Wald 2007, "On fast construction of SAH-based bounding
volume hierarchies"). A node holds the boxes of both children in one cache line, in single precision relative
to the middle of the mesh, rounded outwards.
"""

import math

import numpy as np
from numba import njit

from transport.compile.layout import NODE
from transport.engine.cache import cached_kernels

BINS = 16
MAX_LEAF_FACETS = 4  # largest number of facets in a leaf
# beyond this depth nodes are halved by number, so that the tree never exceeds a lane's traversal stack
MAX_SAH_DEPTH = 40
BOX_MARGIN = 2.0**-46  # [scene lengths] margin about each box, larger than a ray's rounding


def _build(vertices, faces, center, nodes, order):
    """Fill `nodes`, and `order` with the facets' numbers in leaf order; returns the number of nodes."""
    n = faces.shape[0]
    # Bounding box and middle of each facet.
    low, high, middle = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3))
    for i in range(n):
        for a in range(3):
            p = vertices[faces[i, 0], a] - center[a]
            q = vertices[faces[i, 1], a] - center[a]
            r = vertices[faces[i, 2], a] - center[a]
            low[i, a], high[i, a] = min(p, min(q, r)), max(p, max(q, r))
            middle[i, a] = 0.5 * (low[i, a] + high[i, a])
        order[i] = i
    counts, bin_low, bin_high = np.empty(BINS, np.int64), np.empty((BINS, 3)), np.empty((BINS, 3))
    right = np.empty(BINS)
    # Stack of open nodes: parent, which child, first and last facet, depth.
    stack = np.empty((512, 5), np.int64)
    stack[0, 0], stack[0, 1], stack[0, 2], stack[0, 3], stack[0, 4] = 0, 0, 0, n, 0
    _write_child(nodes[0], 1, np.full(3, math.inf), np.full(3, -math.inf), 0, 1)  # an empty child
    top, used = 1, 1
    while top > 0:
        top -= 1
        node, child = stack[top, 0], stack[top, 1]
        first, last, depth = stack[top, 2], stack[top, 3], stack[top, 4]
        # Bounds of the facets and of their middles.
        box_low, box_high = np.full(3, math.inf), np.full(3, -math.inf)
        mid_low, mid_high = np.full(3, math.inf), np.full(3, -math.inf)
        for j in range(first, last):
            i = order[j]
            for a in range(3):
                box_low[a], box_high[a] = min(box_low[a], low[i, a]), max(box_high[a], high[i, a])
                mid_low[a], mid_high[a] = min(mid_low[a], middle[i, a]), max(mid_high[a], middle[i, a])
        if last - first <= MAX_LEAF_FACETS:
            _write_child(nodes[node], child, box_low, box_high, first, last - first)
            continue
        _write_child(nodes[node], child, box_low, box_high, used, 0)
        # Find the split of least cost (number times half area, on both sides).
        best, axis, cut = math.inf, -1, 0
        if depth < MAX_SAH_DEPTH:
            for a in range(3):
                width = mid_high[a] - mid_low[a]
                if not width > 0.0:
                    continue
                scale = BINS / width
                counts[:] = 0
                bin_low[:], bin_high[:] = math.inf, -math.inf
                for j in range(first, last):
                    i = order[j]
                    k = min(int((middle[i, a] - mid_low[a]) * scale), BINS - 1)
                    counts[k] += 1
                    for c in range(3):
                        bin_low[k, c] = min(bin_low[k, c], low[i, c])
                        bin_high[k, c] = max(bin_high[k, c], high[i, c])
                sweep_low, sweep_high, number = np.full(3, math.inf), np.full(3, -math.inf), 0
                for k in range(BINS - 1, 0, -1):
                    number += counts[k]
                    for c in range(3):
                        sweep_low[c] = min(sweep_low[c], bin_low[k, c])
                        sweep_high[c] = max(sweep_high[c], bin_high[k, c])
                    right[k] = number * _half_area(sweep_low, sweep_high) if number > 0 else 0.0
                sweep_low[:], sweep_high[:], number = math.inf, -math.inf, 0
                for k in range(BINS - 1):
                    number += counts[k]
                    for c in range(3):
                        sweep_low[c] = min(sweep_low[c], bin_low[k, c])
                        sweep_high[c] = max(sweep_high[c], bin_high[k, c])
                    if 0 < number < last - first:
                        cost = number * _half_area(sweep_low, sweep_high) + right[k + 1]
                        if cost < best:
                            best, axis, cut = cost, a, k + 1
        # Partition the facets at the split; without one, halve them by number.
        half = first + (last - first) // 2
        if axis >= 0:
            scale = BINS / (mid_high[axis] - mid_low[axis])
            i, j = first, last - 1
            while i <= j:
                k = min(int((middle[order[i], axis] - mid_low[axis]) * scale), BINS - 1)
                if k < cut:
                    i += 1
                else:
                    order[i], order[j] = order[j], order[i]
                    j -= 1
            half = i
        for part in range(2):
            begin, end = (first, half) if part == 0 else (half, last)
            stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3] = used, part, begin, end
            stack[top, 4] = depth + 1
            top += 1
        used += 1
    return used


@njit(inline="always")
def _write_child(node, child, low, high, first, count):
    """Write a child of a node: its box, and its first facet and count, or its node and 0."""
    low_x, low_y, low_z = _rounded_down(low[0]), _rounded_down(low[1]), _rounded_down(low[2])
    high_x, high_y, high_z = -_rounded_down(-high[0]), -_rounded_down(-high[1]), -_rounded_down(-high[2])
    if child == 0:
        node.low_x0, node.low_y0, node.low_z0 = low_x, low_y, low_z
        node.high_x0, node.high_y0, node.high_z0 = high_x, high_y, high_z
        node.first0, node.count0 = first, count
    else:
        node.low_x1, node.low_y1, node.low_z1 = low_x, low_y, low_z
        node.high_x1, node.high_y1, node.high_z1 = high_x, high_y, high_z
        node.first1, node.count1 = first, count


@njit(inline="always")
def _rounded_down(x):
    """Return a bound below x by more than the rounding to single precision and that of a ray."""
    return x - BOX_MARGIN - 2.0**-23 * abs(x)


@njit(inline="always")
def _half_area(low, high):
    """Return half the surface area of a box."""
    x, y, z = high[0] - low[0], high[1] - low[1], high[2] - low[2]
    return x * y + y * z + z * x


with cached_kernels():
    _compiled = njit(cache=True, nogil=True)(_build)


def build_mesh(table) -> None:
    """Sort the facets of a compile.plan.MeshTable, and build its nodes and area shares."""
    if table.nodes is None:
        table.nodes, order = build_hierarchy(table.vertices, table.faces, table.center)
        _renumber(table, order)
        areas = table.areas[order]
        table.shares = np.cumsum(areas) / areas.sum()


def build_hierarchy(
    vertices: np.ndarray, faces: np.ndarray, center: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the nodes (layout.NODE) over the facets, and the facets' numbers in leaf order."""
    nodes, order = np.zeros(max(1, len(faces)), NODE), np.zeros(len(faces), np.int64)
    used = _compiled(vertices, faces, center, nodes.view(np.recarray), order)
    return np.ascontiguousarray(nodes[:used]), order


def _renumber(table, order: np.ndarray) -> None:
    """Sort facets by leaf and vertices by their first facet, so that neighbours are close in memory."""
    faces = table.faces[order]
    vertices, first, back = np.unique(faces.ravel(), return_index=True, return_inverse=True)
    rank = np.argsort(first)
    table.vertices = np.ascontiguousarray(table.vertices[vertices[rank]])
    table.faces = np.argsort(rank).astype(np.int32)[back].reshape(faces.shape)
    table.normals = np.ascontiguousarray(table.normals[order])
