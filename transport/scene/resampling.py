"""Radiances of one instrument as another would show them: maps in other projections, views of a light field.

All are sums of the values of cells: radiance times a matrix of weights, which is applied to bare values and,
batch by batch, to estimates.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Protocol

import numpy as np

from transport.vectors import Vector

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from transport.statistics.estimates import EstimateArray


POINTS = 64  # of each cell
CUT_POINTS = 4096  # ... of one that a horizon or a rim divides
LENS_NODES = 8  # across a lens
PLASTIC = 1.324717957244746  # root of x^3 = x + 1
BALANCING_ROUNDS = 20
GROUND = 1e-12  # relative
CLOSE = 1e-9  # of a cell's side, from its corners
CORNER_SHARE = 1e-3  # of a cell, that each of its corners stands for where even points are not enough


class Cells(Protocol):
    """What has cells: an instrument."""

    axis_units: dict[str, str]

    def edges(self) -> dict[str, np.ndarray]:
        """Return the edges of the cells by axis."""


class DirectionCells(Cells, Protocol):
    """A map: its cells are directions from a point."""

    image_axis: Vector

    def solid_angles(self) -> np.ndarray:
        """Return the solid angle of each cell [sr]."""

    def rays(
        self, across: float, up: float, cells: np.ndarray | slice = ...
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return directions and weights at the same place in each cell."""

    def cells_of(self, rays: np.ndarray) -> np.ndarray:
        """Return the flat indices of the cells of directions, -1 for none."""


class RayCells(Cells, Protocol):
    """A light field: its cells are sets of rays."""

    def cells_of(self, origins: np.ndarray, rays: np.ndarray) -> np.ndarray:
        """Return the flat indices of the cells of rays, -1 for none."""


class Eye(Cells, Protocol):
    """A camera: its pixels are means over rays."""

    pixels: tuple[int, int]

    def lens_points(self, nodes: int) -> list[tuple[float, float]]:
        """Return even points of the lens."""

    def rays(
        self, across: float, up: float, lens: tuple[float, float] = ...
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return origins, directions and weights at the same place in each pixel."""


def _pairs(number: int) -> Iterator[tuple[float, float]]:
    """Yield even points of a square, in opposite pairs, so that their mean is the middle.

    They lie on no line of symmetry, where edges of cells may lie (Roberts's sequence R2).
    """
    for k in range(number // 2):
        a, b = (0.5 + (k + 0.5) / PLASTIC) % 1.0, (0.5 + (k + 0.5) / PLASTIC**2) % 1.0
        yield a, b
        yield 1.0 - a, 1.0 - b


def _points_of(view: DirectionCells) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Yield indices of cells, rays through them and weights, which are positive and add up to 1 per cell."""
    angles, total, found = view.solid_angles().ravel(), 0.0, []
    for a, b in _pairs(POINTS):
        rays, weights = view.rays(a, b)
        found.append((rays, weights))
        total = total + weights
    for rays, weights in found:
        (mine,) = np.nonzero((weights > 0) & (angles > 0))
        yield mine, rays[mine], weights[mine] / total[mine]
    (missed,) = np.nonzero((angles > 0) & (total == 0))  # slivers within the rim: their innermost corner
    if len(missed):
        corners = [view.rays(a, b, missed)[0] for a in (0.0, 1.0) for b in (0.0, 1.0)]
        along = np.array([corner @ np.array(view.image_axis) for corner in corners])
        yield missed, np.array(corners)[along.argmax(axis=0), np.arange(len(missed))], np.ones(len(missed))


def projected_solid_angles(view: DirectionCells, normal: Vector) -> np.ndarray:
    """Return the integral of max(cos, 0) over each cell of a map [sr], in the shape of its solid angles."""
    angles, across = view.solid_angles().ravel(), np.array(normal)
    low, high, means = np.ones_like(angles), -np.ones_like(angles), np.zeros_like(angles)
    points = np.zeros(len(angles), np.int64)
    for cells, rays, shares in _points_of(view):
        cosine = rays @ across
        low[cells], high[cells] = np.minimum(low[cells], cosine), np.maximum(high[cells], cosine)
        means[cells] += shares * np.maximum(cosine, 0.0)
        points[cells] += 1
    # Cells that a horizon or a rim divides need more points. Corners lie beyond the points by less than their
    # spread.
    reach = high - low
    (cut,) = np.nonzero((low < reach) & (high > -reach) & (points > 1) | (points > 0) & (points < POINTS))
    if len(cut):
        total, sums = np.zeros(len(cut)), np.zeros(len(cut))
        for a, b in _pairs(CUT_POINTS):
            rays, weights = view.rays(a, b, cut)
            total += weights
            sums += weights * np.maximum(rays @ across, 0.0)
        means[cut] = np.divide(sums, total, out=means[cut], where=total > 0)
    found = means * angles
    if math.isclose(angles.sum(), 4 * math.pi, rel_tol=1e-9):  # to 4 digits without
        found *= math.pi / found.sum()
    return found.reshape(view.solid_angles().shape)


def overlaps(view: DirectionCells, other: DirectionCells) -> csr_array:
    """Return the solid angles [sr] that cells of another map share with cells of a map, (other, view).

    Both cover all directions. Sums over rows and columns are the solid angles of the cells to rounding, so
    that the fluence rate is conserved and a uniform field stays uniform; each entry alone is as exact as
    POINTS points per cell.
    """
    from scipy.sparse import coo_array

    wholes = [each.solid_angles().ravel() for each in (other, view)]

    def matrix_of(points: Callable) -> csr_array:
        rows, columns, values = [], [], []
        for here, there, is_view in ((view, other, True), (other, view, False)):
            angles = here.solid_angles().ravel()
            for cells, rays, shares in points(here):
                met = there.cells_of(rays)
                is_met = met >= 0
                rows.append((met if is_view else cells)[is_met])
                columns.append((cells if is_view else met)[is_met])
                values.append((0.5 * angles[cells] * shares)[is_met])
        entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
        return coo_array(entries, shape=tuple(map(len, wholes))).tocsr()

    found = matrix_of(_points_of)
    if not _can_be_balanced(found, *wholes):
        # Strips between edges of both maps may be narrower than points lie apart.
        found = (found + matrix_of(_corners_of)).tocsr()
    return _balanced(found, *wholes)


def _corners_of(view: DirectionCells) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Yield indices of cells, rays close to their corners, and the shares that these stand for."""
    angles = view.solid_angles().ravel()
    for a in (CLOSE, 1 - CLOSE):
        for b in (CLOSE, 1 - CLOSE):
            rays, weights = view.rays(a, b)
            (mine,) = np.nonzero((weights > 0) & (angles > 0))
            yield mine, rays[mine], np.full(len(mine), CORNER_SHARE)


def _can_be_balanced(matrix: csr_array, rows: np.ndarray, columns: np.ndarray) -> bool:
    """Return whether rows and columns that entries connect have the same sums, which scaling keeps."""
    from scipy.sparse import block_array
    from scipy.sparse.csgraph import connected_components

    _, groups = connected_components(block_array([[None, matrix], [matrix.T, None]]), directed=False)
    excess = np.bincount(groups, np.concatenate([rows, -columns]))
    return bool(np.abs(excess).max() <= GROUND * rows.sum())


def _balanced(matrix: csr_array, rows: np.ndarray, columns: np.ndarray) -> csr_array:
    """Scale rows and columns so that they have these sums.

    Iterative proportional fitting brings the sums close, slowly; what is left is small, and solved for as
    factors 1 + x_i + y_j.
    """
    from scipy.sparse import block_array, diags_array
    from scipy.sparse.linalg import spsolve

    down = np.ones_like(columns)
    for _ in range(BALANCING_ROUNDS):
        along = _over(rows, matrix @ down)
        down = _over(columns, matrix.T @ along)
    found = (diags_array(along) @ matrix @ diags_array(down)).tocoo()
    sums = np.concatenate([found.sum(axis=1), found.sum(axis=0)])
    missing = np.concatenate([rows, columns]) - sums
    normal = block_array([[diags_array(sums[: len(rows)]), found], [found.T, diags_array(sums[len(rows) :])]])
    # x + c and y - c are as good: without a trace of the diagonal the matrix would be singular.
    factors = spsolve((normal + GROUND * diags_array(np.maximum(sums, sums.max() * GROUND))).tocsc(), missing)
    row, column = found.coords
    found.data *= 1 + factors[row] + factors[len(rows) + column]
    return found.tocsr()


def _over(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return a/b, 0 where b is 0."""
    return np.divide(a, b, out=np.zeros_like(a), where=b > 0)


def view_weights(field: RayCells, camera: Eye) -> csr_array:
    """Return the share of each cell of a light field in each pixel of a camera, (pixels, cells).

    A pixel is the mean over even rays, each with the value of the cell that it passes through. Rays that miss
    the light field leave their pixel out, without a value.
    """
    from scipy.sparse import coo_array, csr_array, diags_array

    shape = math.prod(camera.pixels), math.prod(len(edges) - 1 for edges in field.edges().values())
    lens = camera.lens_points(LENS_NODES)
    points = POINTS if len(lens) == 1 else POINTS // 4
    found, total, missed = csr_array(shape), np.zeros(shape[0]), np.zeros(shape[0], bool)
    for place in lens:
        rows, columns, values = [], [], []
        for a, b in _pairs(points):
            origins, rays, weights = camera.rays(a, b, place)
            cells = field.cells_of(origins, rays)
            inside = np.flatnonzero(cells >= 0)
            rows.append(inside), columns.append(cells[inside]), values.append(weights[inside])
            total, missed = total + weights, missed | ((cells < 0) & (weights > 0))
        entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
        found = found + coo_array(entries, shape=shape).tocsr()
    (empty,) = np.nonzero(missed | (total == 0))
    no_value = coo_array((np.full(len(empty), np.nan), (empty, 0 * empty)), shape=shape)
    return (diags_array(1 / np.where(total > 0, total, 1.0)) @ found + no_value).tocsr()


def weighted(
    matrix: csr_array, values: EstimateArray | np.ndarray, shape: tuple[int, ...], other: Cells
) -> EstimateArray | np.ndarray:
    """Return the values of another instrument: a matrix times those of one, (cells of other, cells).

    shape: of the values.
    """
    from transport.statistics.estimates import EstimateArray

    edges = other.edges()
    new = tuple(len(each) - 1 for each in edges.values())
    if np.shape(values) != shape:
        raise ValueError(f"values must have the shape {shape} of the cells, got {np.shape(values)}")
    if isinstance(values, EstimateArray):
        return values.weighted(matrix, edges, other.axis_units)
    return (matrix @ np.asarray(values, float).ravel()).reshape(new)
