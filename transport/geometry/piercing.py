"""Whether one surface passes through another: lines drawn on the one that cross the other."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from transport.geometry.line_crossings import MAX_LINE_FACETS, crossings
from transport.geometry.mesh import Mesh
from transport.geometry.relations import boxes_meet
from transport.geometry.shape import Shape

LINES = 17  # each way over a surface, in as many pieces less one
MESH_LINES = 6  # on each facet of a mesh: its sides and medians
TOUCH = (
    1e-6  # relative to the size of the shape: what comes no nearer than that to passing through only touches
)


def passes_through(shape: Shape, wall: Shape) -> bool:
    """Return whether a surface certainly passes through another one, rather than lie on it or touch it.

    Notes
    -----
    Lines are drawn on the shape. One that crosses the wall still does so if the shape is moved a little to
    either side; one that lies on the wall, or touches it, does not. Not found: what the lines miss, such as a
    thin wall between two of them or a corner of less than a percent; infinite shapes (False), and meshes and
    walls of very many triangles.
    """
    if shape.is_infinite or not shape.has_area or not boxes_meet(shape, wall):
        return False
    lines = MESH_LINES * shape.triangles if isinstance(shape, Mesh) else 4 * LINES**2
    if max(wall.triangles, 1) * lines > MAX_LINE_FACETS:
        return False
    parts = [part for piece in shape.pieces() for part in piece.primitives()]
    faces = [face for piece in wall.pieces() for face in piece.primitives()]
    return any(_part_passes_through(part, face) for part in parts for face in faces if boxes_meet(part, face))


def _part_passes_through(part: Shape, face: Shape) -> bool:
    """Return whether a line on a part crosses a face, moved to the front of the part and to the back."""
    starts, steps, normals, first, last = map(np.concatenate, zip(*_lines_on(part), strict=True))
    lengths = np.linalg.norm(steps, axis=1)
    kept = lengths > TOUCH * part.extent
    starts, steps, normals = starts[kept], steps[kept], normals[kept]
    first, last, lengths = first[kept, None], last[kept, None], lengths[kept, None]
    crosses = np.ones(len(starts), bool)
    for side in (-1.0, 1.0):
        begins = starts + side * TOUCH * part.extent * normals
        shares = crossings(face, begins, steps / lengths).distances / lengths
        is_between = (shares > first) & (shares < last)
        for share, within in zip(shares.T, is_between.T, strict=True):
            if part.hole is not None:
                within &= part.covers(begins + np.nan_to_num(share)[:, None] * steps)
        crosses &= is_between.any(axis=1)
    return bool(crosses.any())


def _lines_on(part: Shape) -> Iterator[tuple[np.ndarray, ...]]:
    """Start, step and normal of each piece of the lines on a part, and between which shares of it to search.

    The ends of a line are left out, as they may touch.
    """
    if isinstance(part, Mesh):
        yield from _lines_on_facets(part)
        return
    ticks = np.linspace(0.0, 1.0, LINES)
    for place in ticks:
        beside = np.full(LINES, place)
        for numbers in ((ticks, beside), (beside, ticks)):
            points, normals = part.sample_area(np.stack(numbers, axis=1))
            if len(points) < 2:
                continue
            first, last = np.full(len(points) - 1, -TOUCH), np.full(len(points) - 1, 1 + TOUCH)
            first[0], last[-1] = TOUCH, 1 - TOUCH
            yield points[:-1], np.diff(points, axis=0), normals[:-1], first, last


def _lines_on_facets(mesh: Mesh) -> Iterator[tuple[np.ndarray, ...]]:
    """The same for the sides and medians of the facets of a mesh.

    At its ends a line that is moved aside may cross the facets beside its own, where these lie on the wall.
    """
    corners = mesh.vertices[mesh.faces]
    for k in range(3):
        start, following, last = (corners[:, (k + j) % 3] for j in range(3))
        for step in (following - start, 0.5 * (following + last) - start):
            with np.errstate(divide="ignore"):
                margin = 100 * TOUCH * mesh.extent / np.linalg.norm(step, axis=1)
            yield start, step, mesh.normals, margin, 1 - margin
