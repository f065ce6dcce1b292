"""Lower volume detectors: their rows of sums, their cells and directions."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from transport.compile import layout
from transport.compile.detectors import axis_columns, edge_columns, widened
from transport.compile.rows import Rows, axes_of
from transport.geometry.relations import boxes_meet
from transport.geometry.revolved import Cylinder
from transport.geometry.shape import Shape
from transport.geometry.solid import Box, Sphere
from transport.scene.bodies import TEST_DEPTH, body_bounds, media_at, points_beside
from transport.scene.materials import AnyMedium
from transport.scene.media import Grid
from transport.scene.volumes import COLLISION, VolumeDetector
from transport.validation import refuse
from transport.vectors import local_frame

if TYPE_CHECKING:
    from transport.compile.plan import Plan


# By kind of shape: the passes that clip a path to it, and that score collisions in its cells.
PASSES = {
    Box: ("clip_to_box", "score_collisions_in_box"),
    Sphere: ("clip_to_ball", "score_collisions_in_ball"),
    Cylinder: ("clip_to_cylinder", "score_collisions_in_cylinder"),
}
SAMPLES_PER_AXIS = 9  # points per axis of a volume, and of each body in it, at which its media are checked


@dataclass(frozen=True)
class Volume:
    """A volume detector ready to run: its row of layout.VOLUME, and what selects its passes."""

    detector: VolumeDetector
    shape: Shape
    row: np.ndarray
    unit: float  # value of a sum of 1 [m]
    has_cells: bool  # cells or direction bins: paths are traced from cell to cell
    absorbs: bool
    grids: tuple[np.ndarray, ...]  # of layout.VOLUME_IN_GRID: grids that absorb in it

    @property
    def passes(self) -> tuple[str, str]:
        """Names of the passes that clip a path to the shape, and that score collisions in its cells."""
        return PASSES[type(self.shape)]

    @property
    def counts_collisions(self) -> bool:
        """Whether collisions are scored rather than path lengths."""
        return self.detector.estimator == COLLISION


def lower_volumes(plan: Plan) -> None:
    """Give each VolumeDetector its rows of sums, and fill its table."""
    plan.volumes = [_volume(plan, detector) for detector in plan.scene.volumes]


def _volume(plan: Plan, detector: VolumeDetector) -> Volume:
    """Return a volume detector's Volume."""
    shape, absorbed = plan.scene.shape_of(detector), None
    rows = plan.add_rows(detector.name, volume_rows(detector, shape, plan.rows))
    if plan.absorbing_media:
        absorbed = plan.absorbed_rows_of[detector.name] = Rows(rows.past, rows.outer, (), 1)
        plan.rows = absorbed.past
    _check_media(plan, detector, shape)
    values = layout.center_columns(plan.space.place(shape.center)) | _cell_columns(plan, rows, shape)
    values |= _direction_columns(plan, detector, rows) | {"first": rows.first, "rows": rows.block}
    if absorbed is not None:
        values["kept"] = absorbed.first
    is_hollow = isinstance(shape, Sphere) and detector.cells is not None
    values["is_one"] = rows.count == rows.block and not is_hollow
    values["scale"] = _scale(plan, detector, shape)
    row = layout.row(layout.VOLUME, **values)
    unit, has_cells = plan.space.size / values["scale"], bool(rows.inner) or not values["is_one"]
    grids = tuple(_grids(plan, shape, row))
    return Volume(detector, shape, row, unit, has_cells, absorbed is not None, grids)


def volume_rows(detector: VolumeDetector, shape: Shape, first: int) -> Rows:
    """Return the rows of paths through a volume: a block per cell, of one row without directions."""
    directions = () if detector.directions is None else axes_of(detector.directions.edges())
    block = 1 + math.prod(map(len, directions)) if directions else 1
    return Rows(first, axes_of(detector.edges(shape)), directions, block)


def _scale(plan: Plan, detector: VolumeDetector, shape: Shape) -> float:
    """Return 1 over the largest score of weight 1: the longest path, or mean free path.

    In scene lengths.
    """
    if detector.estimator == COLLISION:
        paths = plan.media["mfp"]
        grids = [plan.bodies[int(row["medium"]) - 1].medium for row in plan.grids]
        thinnest = [float(grid.extinction.min()) * plan.space.size for grid in grids]
        return min([1.0 / float(path) for path in paths[paths < math.inf]] + [t for t in thinnest if t > 0])
    return plan.space.size / (2 * shape.extent)


def _cell_columns(plan: Plan, rows: Rows, shape: Shape) -> dict[str, float]:
    """Return the columns of the cells of a box, the shells of a sphere, or the rings of a cylinder."""
    size, cells, values = plan.space.size, {axis.name: axis for axis in rows.outer}, {}
    if not isinstance(shape, Box):
        edges = cells["r"].edges if cells else np.array([0.0, shape.radius])
        radii = np.ascontiguousarray(edges / size)
        values = {"hx": radii[-1], "cells_x": len(radii) - 1, "radii": plan.arena.place(radii)}
    sides = {}
    if isinstance(shape, Box):
        sides = dict(zip("xyz", shape.size, strict=True))
    elif isinstance(shape, Cylinder):
        sides = {"z": shape.height}
        values |= layout.vector_columns("a", shape.axis)
    for x, side in sides.items():
        count = len(cells[x]) if cells else 1
        width = side / size / count
        values |= {f"h{x}": side / size / 2, f"width_{x}": width, f"per_{x}": 1 / width, f"cells_{x}": count}
    return values


def _direction_columns(plan: Plan, detector: VolumeDetector, rows: Rows) -> dict[str, float]:
    """Return the columns of the direction bins; an axis that is not binned is one bin."""
    directions, axes = detector.directions, {axis.name: axis for axis in rows.inner}
    if directions is None:
        return {}
    turns = len(axes["phi"]) if "phi" in axes else 1
    cosines = axes["mu"].edges if "mu" in axes else np.array([-1.0, 1.0])
    values = layout.frame_columns(local_frame(directions.axis, None))
    values |= edge_columns(plan, "mu", widened(cosines), turns)
    if "phi" in axes:
        values |= axis_columns(plan, axes["phi"], rows) | {"turn_low": axes["phi"].edges[0]}
    if all(bins is None or isinstance(bins, int) for bins in (directions.mu, directions.phi)):
        values |= {"turn_cells": turns, "is_even": 1}
    return values


def _grids(plan: Plan, shape: Shape, volume: np.ndarray) -> Iterator[np.ndarray]:
    """Yield rows of the grids that absorb and may overlap the volume."""
    for fades, grids in enumerate((plan.grids, plan.absorbing_grids)):
        for grid in grids:
            if grid["absorbs"] and boxes_meet(shape, plan.bodies[int(grid["medium"]) - 1].medium.box):
                row = layout.row(layout.VOLUME_IN_GRID, fades=fades)
                row["volume"], row["grid"] = volume, grid
                yield row


def _check_media(plan: Plan, detector: VolumeDetector, shape: Shape) -> None:
    """Refuse the estimator "collision" in media without collisions."""
    if detector.estimator != COLLISION:
        return
    is_weighted = plan.tracking.absorption == "weighted"
    cure = "use estimator='track'"
    points = _points_in_media(plan, shape)
    for medium in dict.fromkeys(media_at(plan.scene, points[_holds(shape, points)])):
        if not _collides_everywhere(medium, is_weighted):
            what = "scatter (tracking is weighted)" if is_weighted else "absorb or scatter"
            must = f"all media in it must {what} for estimator 'collision'"
            refuse(detector, f"{must}, got {medium!r}; {cure}")


def _collides_everywhere(medium: AnyMedium, is_weighted: bool) -> bool:
    if isinstance(medium, Grid):
        return bool((medium.extinction > 0).all()) and not (is_weighted and not medium.scattering.any())
    return (medium.scattering if is_weighted else medium.extinction) > 0


def _points_in_media(plan: Plan, shape: Shape) -> np.ndarray:
    """Return points [m], shape (n, 3), in all media of a volume, and others outside the volume.

    They lie on lattices over the box of the volume and over the part of each body's box in it, and on both
    sides of the volume's surface and of those of the bodies, as a body or a gap may be of any size.
    """
    low, high = np.array(shape.bounds)
    found = [_lattice(low, high), points_beside(shape, False)]
    for body in plan.bodies:
        lowest, highest = body_bounds(plan.scene, body)
        lowest, highest = np.maximum(low, lowest), np.minimum(high, highest)
        if (lowest < highest).all():
            found.append(_lattice(lowest, highest))
            for number, _ in body.faces:
                found += _points_on_both_sides(plan.scene.surfaces[number].shape, found[0])
    return np.concatenate(found)


def _points_on_both_sides(face: Shape, lattice: np.ndarray) -> list[np.ndarray]:
    """Return points beside a surface of a body; beside planes they lie above and below a lattice."""
    if not face.is_infinite:
        return [points_beside(face, is_front) for is_front in (False, True)]
    depth, points = TEST_DEPTH * np.ptp(lattice, axis=0).max(), []
    for plane in face.pieces():
        heights = ((lattice - plane.center) @ np.array(plane.normal))[:, None]
        points += [lattice - (heights + shift) * np.array(plane.normal) for shift in (-depth, depth)]
    return points


def _lattice(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return points [m] spread over a box and off its symmetries, shape (n, 3)."""
    steps = (np.arange(SAMPLES_PER_AXIS) + 0.4817) / SAMPLES_PER_AXIS
    return low + np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3) * (high - low)


def _holds(shape: Shape, points: np.ndarray) -> np.ndarray:
    """Return which points [m] lie in a volume."""
    if not isinstance(shape, Cylinder):
        return shape.contains(points)
    u, v, w = np.array(shape.frame) @ (points - shape.center).T
    return (np.hypot(u, v) <= shape.radius) & (np.abs(w) <= shape.height / 2)
