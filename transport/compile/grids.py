"""Rows of grids: voxels, and majorants of macro cells (blocks of voxels crossed in one step)."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from transport.compile import layout
from transport.scene.media import Grid

if TYPE_CHECKING:
    from transport.compile.plan import Plan

# Time [ns] to cross a macro cell (twice that where the majorants exceed the second-level cache) and to try a
# tentative collision: fitted to tests/bench/grid.py. CACHE_BYTES: size of that cache.
CROSSING_COST, COLLISION_COST, CACHE_BYTES = 6.0, 14.0, 1 << 22


def fill_grids(plan: Plan, analog: bool) -> None:
    """Fill the plan's rows of bodies made of voxels.

    `grids` holds those where particles collide, `absorbing_grids` those that absorb only and so only reduce
    weights.
    """
    for number, body in enumerate(plan.bodies, start=1):
        grid = body.medium
        if isinstance(grid, Grid) and extinction_of(grid).any():
            collides = analog or bool(grid.scattering.any())
            rows = plan.grids if collides else plan.absorbing_grids
            rows.append(grid_row(plan, grid, number, collides))


def grid_row(plan: Plan, grid: Grid, medium: int, collides: bool) -> np.ndarray:
    """Return the row (layout.GRID) of a grid that fills the body with this row of media."""
    # Lay out voxels and macro cells.
    size, counts = plan.space.size, grid.shape
    voxel = np.array(grid.box.size) / counts
    low = plan.space.place(tuple(grid.box.bounds[0]))
    block, tops = macro_cells(grid) if collides else (1, np.zeros((1, 1, 1)))
    values = layout.center_columns(low) | {"length": size, "block": block, "medium": medium}
    values |= {f"per_{x}": size / side for x, side in zip("xyz", voxel, strict=True)}
    values |= {f"n{x}": count for x, count in zip("xyz", counts, strict=True)}
    values |= {f"m{x}": count for x, count in zip("xyz", tops.shape, strict=True)}
    # Store majorants [1/scene lengths] with least shares, padded by a rim of -1 that marks the outside.
    levels = quantized_shares(grid, block, tops) if collides else np.zeros(1, np.uint8)
    least = min_shares(grid, block, tops) if collides else tops
    both = [np.pad(each, 1, constant_values=-1.0) for each in (tops * size, least)]  # -1: outside the grid
    tops = np.ascontiguousarray(np.stack(both, axis=-1))
    values |= {
        "tops": plan.arena.place(tops),
        "top_count": tops.size,
        "levels": plan.arena.place(levels),
        "level_count": levels.size,
    }
    # Place the coefficients; where all voxels share one number, its stride is 0.
    values |= {"absorbs": bool(grid.absorption.any())}
    for name, array in (("absorption", grid.absorption), ("scattering", grid.scattering)):
        stored = np.ascontiguousarray(array) if any(array.strides) else array[:1, :1, :1]
        values |= {name: plan.arena.place(stored), f"{name}_count": stored.size}
        values |= {f"{name}_stride": int(stored.size > 1)}
    values["ledger"] = layout.ABSORBED  # the program fills in the rest
    return layout.row(layout.GRID, **values)


@lru_cache(maxsize=8)
def macro_cells(grid: Grid) -> tuple[int, np.ndarray]:
    """Return the voxels per side of a macro cell and each cell's largest extinction [m^-1].

    The size of the cells is the one of the least expected cost.

    A flight pays for each macro cell that it crosses, 0.5 (1/a + 1/b + 1/c) per unit of length for isotropic
    directions and cells of sides a, b, c (Cauchy's formula), and for tentative collisions, whose number is
    the mean of the majorants.
    """
    voxel = np.array(grid.box.size) / grid.shape
    tops, block, found = extinction_of(grid), 1, []
    while True:
        crossings = 0.5 * float((1 / (block * voxel))[np.array(tops.shape) > 1].sum())
        crossing = CROSSING_COST * (2 if 2 * tops.nbytes > CACHE_BYTES else 1)
        found.append(
            (crossing * crossings + COLLISION_COST * _volume_mean(tops, block, grid.shape), block, tops)
        )
        if max(tops.shape) == 1:
            break
        tops, block = _pooled_maxima(tops), 2 * block
    _, block, tops = min(found, key=lambda each: each[0])
    return block, np.ascontiguousarray(tops)


def min_shares(grid: Grid, block: int, tops: np.ndarray) -> np.ndarray:
    """Return each macro cell's least extinction over its largest.

    A random number below it accepts a collision without a voxel lookup.
    """
    least = extinction_of(grid)
    for axis, count in enumerate(grid.shape):
        least = np.minimum.reduceat(least, np.arange(0, count, block), axis=axis)
    share = np.divide(least, tops, out=np.zeros_like(tops), where=tops > 0)
    return np.where(share < 1, share * (1 - 2.0**-50), 1.0)


def quantized_shares(grid: Grid, block: int, tops: np.ndarray) -> np.ndarray:
    """Return each voxel's extinction over its majorant in units of 1/layout.LEVELS, rounded down."""
    levels = np.empty(grid.shape, np.uint8)
    for i, row in enumerate(tops):  # one layer of macro cells at a time, to save memory
        layer = slice(i * block, (i + 1) * block)
        within = row.repeat(block, axis=0).repeat(block, axis=1)[: grid.shape[1], : grid.shape[2]]
        extinction = grid.absorption[layer] + grid.scattering[layer]
        share = np.divide(extinction, within, out=np.zeros_like(extinction), where=within > 0)
        levels[layer] = layout.LEVELS * np.minimum(share, 1.0)
    return levels


def extinction_of(grid: Grid) -> np.ndarray:
    """Return absorption + scattering [m^-1] per voxel, rounded as a flight rounds their sum."""
    return grid.absorption + grid.scattering


def _pooled_maxima(tops: np.ndarray) -> np.ndarray:
    """Return the maxima over blocks of two by two by two, or fewer at the upper ends."""
    for axis, count in enumerate(tops.shape):
        tops = np.maximum.reduceat(tops, np.arange(0, count, 2), axis=axis)
    return tops


def _volume_mean(tops: np.ndarray, block: int, counts: tuple[int, int, int]) -> float:
    """Return the mean over the volume, in which macro cells at the upper ends may be smaller."""
    for count in counts:
        cells = np.diff(np.append(np.arange(0, count, block), count))
        tops = np.tensordot(cells / count, tops, axes=(0, 0))
    return float(tops)
