"""Scenes of voxels in a box, and what is exact about them: optical depths along rays, added up between sorted crossings."""

from __future__ import annotations

import numpy as np

import transport as tp
from transport.compile import grids
from transport.compile.compiler import compile_scene
from transport.run.programs import program_for
from transport.statistics.estimates import Estimate

FALSE_ALARM = 1e-6
SIZE = (2.0, 1.0, 1.5)


def strewn(shape=(5, 4, 6), seed=1, low=-3.0, high=3.0) -> np.ndarray:
    """Coefficients of all magnitudes between 10^low and 10^high."""
    return 10.0 ** np.random.default_rng(seed).uniform(low, high, shape)


def checkerboard(shape=(5, 4, 6)) -> np.ndarray:
    return 0.2 + 1.5 * (np.indices(shape).sum(axis=0) % 2)


def grid_scene(medium, source, detectors=(), size=SIZE) -> tp.Scene:
    return tp.Scene(
        source, tp.Surface(tp.Box(size=size), tp.Transparent(), inside=medium, name="box"), detectors
    )


def depth_along(grid: tp.Grid, start, direction) -> float:
    """Optical depth of a ray to the end of its grid: voxels looked up in the middle between crossings of the lattice's planes."""
    low, high = np.array(grid.box.bounds)
    u = np.array(direction) / np.linalg.norm(direction)
    crossings = [0.0]
    for axis in range(3):
        if u[axis] != 0:
            planes = np.linspace(low[axis], high[axis], grid.shape[axis] + 1)
            crossings += ((planes - start[axis]) / u[axis]).tolist()
    t = np.unique([each for each in crossings if each >= 0])
    middles = np.array(start) + np.outer((t[1:] + t[:-1]) / 2, u)
    voxels = np.floor((middles - low) / (high - low) * grid.shape).astype(int)
    inside = ((voxels >= 0) & (voxels < grid.shape)).all(axis=1)
    return float((grid.extinction[tuple(voxels[inside].T)] * np.diff(t)[inside]).sum())


def come_through(grid, start, direction, tracking="weighted", particles=64) -> Estimate:
    beam = tp.Source(tp.Point(position=tuple(start)), tp.Beam(tuple(direction), power=1.0))
    result = tp.simulate(grid_scene(grid, beam), particles=particles, seed=1, threads=1, tracking=tracking)
    assert result.ledger["lost"].value == 0
    return result.ledger["escaped"]


def columns(grid: tp.Grid) -> float:
    """The mean over voxel columns of what a beam along z keeps."""
    return float(np.exp(-grid.extinction.sum(axis=2) * grid.box.size[2] / grid.shape[2]).mean())


def lit_along_z(grid, tracking, particles=200_000, seed=1) -> Estimate:
    lid = tp.Rectangle(center=(0, 0, -1), width=SIZE[0], height=SIZE[1], up=(0, 1, 0))
    source = tp.Source(lid, tp.Beam((0, 0, 1), power=1.0))
    return tp.simulate(
        grid_scene(grid, source), particles=particles, seed=seed, threads=1, tracking=tracking
    ).ledger["escaped"]


# ---- faults to plant ----


def plant_block(monkeypatch, block: int) -> None:
    def cells(grid):
        tops = grids.extinction_of(grid)
        for _ in range(block.bit_length() - 1):
            tops = grids._pooled_maxima(tops)
        return block, np.ascontiguousarray(tops)

    forget_programs()
    monkeypatch.setattr(grids, "macro_cells", cells)


def forget_programs() -> None:
    """Forget compiled scenes, so that equal ones are compiled anew, with a planted fault or without."""
    compile_scene.cache_clear()
    program_for.cache_clear()
