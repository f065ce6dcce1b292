"""Faults planted in the tables of a grid, each of which the laws of test_grid.py see."""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.grid_scenes import (
    FALSE_ALARM,
    SIZE,
    columns,
    come_through,
    depth_along,
    forget_programs,
    lit_along_z,
    plant_block,
    strewn,
)
from transport.compile import grids


@pytest.fixture(autouse=True)
def nothing_planted_is_left():
    yield
    forget_programs()


def plant(monkeypatch, name: str, wrong) -> None:
    right = getattr(grids, name)
    forget_programs()
    monkeypatch.setattr(grids, name, lambda *given: wrong(right(*given)))


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("macro_cells", lambda cells: (cells[0], 0.99 * cells[1])),
        ("macro_cells", lambda cells: (cells[0], np.roll(cells[1], 1, axis=2))),
        ("macro_cells", lambda cells: (cells[0], np.ascontiguousarray(cells[1][::-1]))),
        ("quantized_shares", lambda levels: levels - levels // 8),
        ("quantized_shares", lambda levels: levels[::-1].copy()),
        ("quantized_shares", lambda levels: np.roll(levels, 1)),
    ],
    ids=[
        "majorants 1 % low",
        "cells off by one",
        "cells backwards",
        "too few real",
        "voxels backwards",
        "voxels off by one",
    ],
)
def test_planted_faults_are_seen(name, wrong, monkeypatch):
    field = strewn((9, 7, 13), low=-0.3, high=0.5)
    if name == "macro_cells":  # all voxels of a macro cell at its majorant
        field = strewn((5, 4, 7), low=-0.3, high=0.3).repeat(2, 0).repeat(2, 1).repeat(2, 2)[:9, :7, :13]
    grid = tp.Grid(box=tp.Box(size=SIZE), absorption=field)
    plant_block(monkeypatch, 2)
    assert_agrees(lit_along_z(grid, "analog", 2_000_000), columns(grid), FALSE_ALARM)
    plant(monkeypatch, name, wrong)
    with pytest.raises(AssertionError):
        assert_agrees(lit_along_z(grid, "analog", 2_000_000), columns(grid), FALSE_ALARM)


def test_swapped_axes_are_seen():
    rows = np.broadcast_to(np.array([0.5, 1.0, 2.0, 4.0])[:, None, None], (4, 4, 4))
    grid, swapped = (
        tp.Grid(box=tp.Box(size=SIZE), absorption=each) for each in (rows, rows.transpose(1, 0, 2))
    )
    start, way = (-0.9, -0.4, -0.7), (0.8, 0.33, 0.51)
    left = come_through(grid, start, way).value
    assert left == pytest.approx(math.exp(-depth_along(grid, start, way)), rel=1e-12)
    assert left != pytest.approx(math.exp(-depth_along(swapped, start, way)), rel=0.01)
