"""Grids as rows: where their voxels lie, and the majorants of macro cells, blocks of voxels that a flight crosses at once."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from transport.compile import layout
from transport.media import Grid

if TYPE_CHECKING:
    from transport.compile.plan import Plan

# What a flight spends on crossing a macro cell, twice where their table does not stay in the second cache, and on a tentative
# collision [ns]: fitted by hand to the times of tests/bench/grid.py.
CROSSING, TRYING, LARGE = 6.0, 14.0, 1 << 22


def fill_grids(plan: Plan, analog: bool) -> None:
    """The plan's rows of the bodies that grids fill: in `grids` those where flights collide, in `thinning_grids` those that
    only absorb and so only lessen weights."""
    for number, body in enumerate(plan.bodies, start=1):
        grid = body.medium
        if isinstance(grid, Grid) and extinction_of(grid).any():
            collides = analog or bool(grid.scattering.any())
            rows = plan.grids if collides else plan.thinning_grids
            rows.append(grid_row(plan, grid, number, collides))


def grid_row(plan: Plan, grid: Grid, medium: int, collides: bool) -> np.ndarray:
    """The row (layout.GRID) of a grid that fills the body of this row of media."""
    size, counts = plan.space.size, grid.shape
    voxel = np.array(grid.box.size) / counts
    low = plan.space.place(tuple(grid.box.bounds[0]))
    block, tops = macro_cells(grid) if collides else (1, np.zeros((1, 1, 1)))
    values = layout.center_columns(low) | {"length": size, "block": block, "medium": medium}
    values |= {f"per_{x}": size / side for x, side in zip("xyz", voxel, strict=True)}
    values |= {f"n{x}": count for x, count in zip("xyz", counts, strict=True)}
    values |= {f"m{x}": count for x, count in zip("xyz", tops.shape, strict=True)}
    levels = levels_of(grid, block, tops) if collides else np.zeros(1, np.uint8)
    least = least_of(grid, block, tops) if collides else tops
    both = [np.pad(each, 1, constant_values=-1.0) for each in (tops * size, least)]  # -1: beyond the grid
    tops = np.ascontiguousarray(np.stack(both, axis=-1))
    values |= {
        "tops": tops.ctypes.data,
        "top_count": tops.size,
        "levels": levels.ctypes.data,
        "level_count": levels.size,
    }
    values |= {"absorbs": bool(grid.absorption.any())}
    for name, array in (("absorption", grid.absorption), ("scattering", grid.scattering)):
        values |= {name: array.ctypes.data, f"{name}_count": 1 + sum(_reach(array))}
        values |= {f"{name}_{x}": step // 8 for x, step in zip("xyz", array.strides, strict=True)}
    values["ledger"] = layout.ABSORBED  # of which the program knows the rest
    plan.kept += [tops, levels, grid.absorption, grid.scattering]
    return layout.row(layout.GRID, **values)


def _reach(array: np.ndarray) -> list[int]:
    """How far behind the first number each axis reaches; 0 for a number that all voxels share."""
    return [(count - 1) * step // 8 for count, step in zip(array.shape, array.strides, strict=True)]


@lru_cache(maxsize=8)
def macro_cells(grid: Grid) -> tuple[int, np.ndarray]:
    """Voxels along the side of a macro cell, and the largest extinction [m^-1] in each: what costs least to fly through.

    A flight pays for each macro cell that it crosses, half of 1/a + 1/b + 1/c in a unit of length of isotropic directions
    (Cauchy's formula), and for its tentative collisions, of which there are as many as the mean of the majorants.
    """
    voxel = np.array(grid.box.size) / grid.shape
    tops, block, found = extinction_of(grid), 1, []
    while True:
        crossings = 0.5 * float((1 / (block * voxel))[np.array(tops.shape) > 1].sum())
        crossing = CROSSING * (2 if 2 * tops.nbytes > LARGE else 1)
        found.append((crossing * crossings + TRYING * _mean(tops, block, grid.shape), block, tops))
        if max(tops.shape) == 1:
            break
        tops, block = _halved(tops), 2 * block
    _, block, tops = min(found, key=lambda each: each[0])
    return block, np.ascontiguousarray(tops)


def least_of(grid: Grid, block: int, tops: np.ndarray) -> np.ndarray:
    """Of each macro cell its least extinction over its largest: a chance below it decides without a look at the voxel."""
    least = extinction_of(grid)
    for axis, count in enumerate(grid.shape):
        least = np.minimum.reduceat(least, np.arange(0, count, block), axis=axis)
    share = np.divide(least, tops, out=np.zeros_like(tops), where=tops > 0)
    return np.where(share < 1, share * (1 - 2.0**-50), 1.0)


def levels_of(grid: Grid, block: int, tops: np.ndarray) -> np.ndarray:
    """Of each voxel its extinction over the majorant of its macro cell in layout.LEVELS steps, rounded down."""
    levels = np.empty(grid.shape, np.uint8)
    for i, row in enumerate(tops):  # a layer of macro cells at a time, to save memory
        layer = slice(i * block, (i + 1) * block)
        within = row.repeat(block, axis=0).repeat(block, axis=1)[: grid.shape[1], : grid.shape[2]]
        extinction = grid.absorption[layer] + grid.scattering[layer]
        share = np.divide(extinction, within, out=np.zeros_like(extinction), where=within > 0)
        levels[layer] = layout.LEVELS * np.minimum(share, 1.0)
    return levels


def extinction_of(grid: Grid) -> np.ndarray:
    """absorption + scattering [m^-1] of each voxel, added up as a flight adds them up."""
    return grid.absorption + grid.scattering


def _halved(tops: np.ndarray) -> np.ndarray:
    """The largest of every two by two by two, or of what is left of them at the upper ends."""
    for axis, count in enumerate(tops.shape):
        tops = np.maximum.reduceat(tops, np.arange(0, count, 2), axis=axis)
    return tops


def _mean(tops: np.ndarray, block: int, counts: tuple[int, int, int]) -> float:
    """The mean over the volume: macro cells at the upper ends may be smaller."""
    for count in counts:
        cells = np.diff(np.append(np.arange(0, count, block), count))
        tops = np.tensordot(cells / count, tops, axes=(0, 0))
    return float(tops)
