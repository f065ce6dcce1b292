"""What a volume detector read, cell by cell: three cuts, one across each axis, through the cell that surely read most.

Cuts show each cell in the very colour of the bar; a haze of all cells would mix those that lie behind one another.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from transport.geometry.revolved import Cylinder
from transport.geometry.shape import Shape
from transport.geometry.solid import Sphere
from transport.scene.volumes import VolumeDetector
from transport.statistics.estimates import Estimate
from transport.viz.facets import TURN, Facets
from transport.viz.painted import LEAST_HITS, Paint

if TYPE_CHECKING:
    import pyvista

QUANTITY = "fluence_rate"
ROUND = 90  # facets round a shell


def paint_of_cells(reading: object) -> Paint:
    """The fluence rate of each cell, flat in the order of its axes.  Raises SceneError where it is not known."""
    estimate = reading.fluence_rate
    values, errors, hits = (
        np.ravel(each).astype(float) for each in (estimate.value, estimate.error, reading.counts.value)
    )
    words = str(estimate) if isinstance(estimate, Estimate) else None
    return Paint(QUANTITY, str(estimate.unit), words, None, values, errors, hits)


def cuts_of(detector: VolumeDetector, shape: Shape, paint: Paint) -> Facets:
    """Facets of the cells that the cuts go through; bins: the flat number of each one's cell."""
    edges = detector.edges(shape)
    if isinstance(shape, Sphere):
        found = [_rings(shape, edges["r"], axis) for axis in range(3)]
    elif isinstance(shape, Cylinder):
        found = [_halves(shape, edges["r"], edges["z"], across) for across in shape.frame[:2]]
    else:
        axes = [edges[name] for name in "xyz"]
        counts = tuple(len(each) - 1 for each in axes)
        surely = np.where(paint.hits < LEAST_HITS, 0.0, paint.values - 2 * np.nan_to_num(paint.errors))
        most = np.unravel_index(int(np.argmax(surely)), counts)
        found = [_across(axes, counts, axis, most[axis]) for axis in range(3)]
    ends = np.cumsum([0, *(len(each.points) for each in found)])
    return Facets(
        np.concatenate([each.points for each in found]),
        np.concatenate([each.faces + end for each, end in zip(found, ends, strict=False)]),
        np.concatenate([each.bins for each in found]),
    )


def grid_of_cells(detector: VolumeDetector, shape: Shape, paint: Paint) -> pyvista.RectilinearGrid:
    """All cells of a box with what they read [m]."""
    import pyvista

    grid = pyvista.RectilinearGrid(*(detector.edges(shape)[name] for name in "xyz"))
    counts = [len(each) - 1 for each in detector.edges(shape).values()]
    for name, column in paint.on(np.arange(len(paint.values))).items():
        grid.cell_data[name] = column.reshape(counts).ravel(order="F")
    grid.field_data["unit"] = [paint.unit]
    return grid


def _across(axes: list[np.ndarray], counts: tuple[int, ...], axis: int, layer: int) -> Facets:
    """The cells of a box in one layer, as rectangles in its middle."""
    others = [k for k in range(3) if k != axis]
    corners = np.meshgrid(*(axes[k] for k in others), indexing="ij")
    points = np.empty((corners[0].size, 3))
    points[:, axis] = axes[axis][layer : layer + 2].mean()
    for k, each in zip(others, corners, strict=True):
        points[:, k] = each.ravel()
    number = np.arange(len(points)).reshape(corners[0].shape)
    faces = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1)
    cells = np.take(np.arange(np.prod(counts)).reshape(counts), layer, axis=axis)
    return Facets(points, faces.reshape(-1, 4), cells.ravel())


def _rings(ball: Sphere, radii: np.ndarray, axis: int) -> Facets:
    """The shells of a ball in a plane through its center."""
    turns = np.linspace(0, TURN, ROUND + 1)
    points = np.zeros((len(radii), len(turns), 3))
    points[..., (axis + 1) % 3] = radii[:, None] * np.cos(turns)
    points[..., (axis + 2) % 3] = radii[:, None] * np.sin(turns)
    number = np.arange(points[..., 0].size).reshape(points.shape[:2])
    faces = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1)
    shells = np.repeat(np.arange(len(radii) - 1), ROUND)
    return Facets(points.reshape(-1, 3) + np.array(ball.center), faces.reshape(-1, 4), shells)


def _halves(
    rod: Cylinder, radii: np.ndarray, heights: np.ndarray, across: tuple[float, float, float]
) -> Facets:
    """The rings of a cylinder in a plane through its axis, on both sides of it."""
    rho = np.concatenate([-radii[::-1], radii])
    points = (
        np.array(rod.center) + rho[:, None, None] * np.array(across) + heights[:, None] * np.array(rod.axis)
    )
    number = np.arange(points[..., 0].size).reshape(points.shape[:2])
    faces = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1)
    rings, layers = len(radii) - 1, len(heights) - 1
    cells = np.arange(rings * layers).reshape(rings, layers)
    there = np.arange(2 * rings + 1) != rings  # the faces between both sides have no width
    return Facets(
        points.reshape(-1, 3), faces[there].reshape(-1, 4), np.concatenate([cells[::-1], cells]).ravel()
    )
