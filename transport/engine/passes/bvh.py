"""Bounding volume hierarchies (BVH) of boxes over the facets of a mesh, by the surface area heuristic.

Binned: 15 split planes along each axis are tried (Wald 2007, "On fast construction of SAH-based bounding
volume hierarchies"). Its nodes are then merged into nodes of up to layout.CHILDREN children, whose boxes are
in single precision relative to the middle of the mesh, rounded outwards.
"""

import math

import numpy as np
from numba import njit

from transport.compile.layout import CHILDREN, FACET_TERMS, LEAF_BITS, MAX_LEAF_FACETS, NODE, ROUNDING, VECTOR
from transport.engine.cache import cached_kernels

BINS = 16
SPLIT_FACETS = 4  # so many facets are not split; this decides the order of facets
# beyond this depth nodes are halved by number, so that the tree never exceeds a lane's traversal stack
MAX_SAH_DEPTH = 40
# [scene lengths] bound of the rounding of an edge function per size of the mesh, and of the reach within
# which facets are joined (meshes.SLACK)
EDGE_MARGIN = 512.0 * ROUNDING
BOX_MARGIN = 2.0**-46  # [scene lengths] margin about each box, larger than a ray's rounding
# A node of the binary tree: its box, facets [first, last) in leaf order, and its left child (the right one
# follows); 0: none.
BRANCH = np.dtype(
    [("low", "f8", (3,)), ("high", "f8", (3,))] + [(name, "i8") for name in ("first", "last", "left")]
)


def _build(vertices, faces, center, tree, order):
    """Fill the binary tree (BRANCH), and `order` with the facets' numbers in leaf order."""
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
    # Stack of open nodes: number, depth.
    stack = np.empty((512, 2), np.int64)
    stack[0, 0], stack[0, 1] = 0, 0
    tree[0].first, tree[0].last = 0, n
    top, used = 1, 1
    while top > 0:
        top -= 1
        node, depth = tree[stack[top, 0]], stack[top, 1]
        first, last = node.first, node.last
        # Bounds of the facets and of their middles.
        box_low, box_high = np.full(3, math.inf), np.full(3, -math.inf)
        mid_low, mid_high = np.full(3, math.inf), np.full(3, -math.inf)
        for j in range(first, last):
            i = order[j]
            for a in range(3):
                box_low[a], box_high[a] = min(box_low[a], low[i, a]), max(box_high[a], high[i, a])
                mid_low[a], mid_high[a] = min(mid_low[a], middle[i, a]), max(mid_high[a], middle[i, a])
        node.low[:], node.high[:] = box_low, box_high
        if last - first <= SPLIT_FACETS:
            continue
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
        node.left = used
        for part in range(2):
            child = tree[used]
            child.first, child.last = (first, half) if part == 0 else (half, last)
            stack[top, 0], stack[top, 1] = used, depth + 1
            top, used = top + 1, used + 1


def _merge(tree, nodes):
    """Fill `nodes` (layout.NODE) from the binary tree; returns their number."""
    stack = np.empty((512, 2), np.int64)  # nodes to fill: of the tree, of the result
    stack[0, 0], stack[0, 1] = 0, 0
    top, used = 1, 1
    opened = np.empty(CHILDREN, np.int64)
    while top > 0:
        top -= 1
        node, count = nodes[stack[top, 1]], 1
        opened[0] = stack[top, 0]
        # Replace the child of largest area by its own two children until the node is full.
        while count < CHILDREN:
            largest, widest = 0.0, -1
            for k in range(count):
                child = tree[opened[k]]
                area = _half_area(child.low, child.high)
                if (child.last - child.first > MAX_LEAF_FACETS) & (area >= largest):
                    largest, widest = area, k
            if widest < 0:
                break
            left = tree[opened[widest]].left
            opened[widest], opened[count] = left, left + 1
            count += 1
        node.boxes[:, count:] = math.nan
        for k in range(count):
            child = tree[opened[k]]
            for a in range(3):
                node.boxes[a, k] = _rounded_down(child.low[a])
                node.boxes[a + 3, k] = -_rounded_down(-child.high[a])
            number = child.last - child.first
            if number <= MAX_LEAF_FACETS:
                node.children[k] = child.first << LEAF_BITS | number
            else:
                node.children[k] = used << LEAF_BITS
                stack[top, 0], stack[top, 1] = opened[k], used
                top, used = top + 1, used + 1
    return used


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
    _merged = njit(cache=True, nogil=True)(_merge)


def build_mesh(table) -> None:
    """Sort the facets of a compile.plan.MeshTable; build its nodes, leaves and area shares."""
    if table.nodes is None:
        table.nodes, order = build_hierarchy(table.vertices, table.faces, table.center)
        _renumber(table, order)
        table.leaves = _facets_by_leaf(table)
        table.margin = EDGE_MARGIN * float(np.linalg.norm(np.ptp(table.vertices, axis=0)))
        areas = table.areas[order]
        table.shares = np.cumsum(areas) / areas.sum()


def build_hierarchy(
    vertices: np.ndarray, faces: np.ndarray, center: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the nodes (layout.NODE) over the facets, and the facets' numbers in leaf order."""
    tree, order = np.zeros(2 * len(faces), BRANCH), np.zeros(len(faces), np.int64)
    _compiled(vertices, faces, center, tree.view(np.recarray), order)
    nodes = np.zeros(len(faces) // 4 + 1, NODE)
    if len(faces) <= MAX_LEAF_FACETS:  # a single leaf
        return nodes[:1], order
    return np.ascontiguousarray(nodes[: _merged(tree.view(np.recarray), nodes.view(np.recarray))]), order


def _renumber(table, order: np.ndarray) -> None:
    """Sort facets by leaf and vertices by their first facet, so that neighbours are close in memory."""
    faces = table.faces[order]
    vertices, first, back = np.unique(faces.ravel(), return_index=True, return_inverse=True)
    rank = np.argsort(first)
    table.vertices = np.ascontiguousarray(table.vertices[vertices[rank]])
    table.faces = np.argsort(rank).astype(np.int32)[back].reshape(faces.shape)
    table.normals = np.ascontiguousarray(table.normals[order])


def _facets_by_leaf(table) -> np.ndarray:
    """Return the vertices and normals of the facets, in runs of the facets of a leaf (layout.MESH)."""
    number = len(table.faces)
    words = table.nodes["children"].ravel() if number > MAX_LEAF_FACETS else np.array([number])
    counts = words & ((1 << LEAF_BITS) - 1)
    firsts, counts = (words >> LEAF_BITS)[counts > 0], counts[counts > 0]
    order = np.argsort(firsts)
    first, count = (np.repeat(each[order], counts[order])[:, None] for each in (firsts, counts))
    places = FACET_TERMS * first + count * np.arange(FACET_TERMS) + (np.arange(number)[:, None] - first)
    leaves = np.zeros(FACET_TERMS * number + VECTOR)
    leaves[places] = np.column_stack([table.vertices[table.faces].reshape(number, 9), table.normals])
    return leaves
