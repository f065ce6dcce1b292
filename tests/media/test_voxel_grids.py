"""Grids: flights through voxels against line integrals, against the same in other words, and in what no voxel can change.

The exact values: a beam through voxels that only absorb is exp(-sum sigma ds), which a reference adds up between sorted
crossings; and in a closed room of one radiance L the fluence rate is 4 pi L in every place, whatever scatters there.
Faults planted in the tables of a grid are seen by these laws.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.grid_scenes import (
    FALSE_ALARM,
    SIZE,
    checkerboard,
    columns,
    come_through,
    depth_along,
    forget_programs,
    grid_scene,
    lit_along_z,
    plant_block,
    strewn,
)
from transport.compile import grids


@pytest.fixture(autouse=True)
def nothing_planted_is_left():
    yield
    forget_programs()


# ---- what only absorbs ----

RAYS = {
    "oblique": ((-0.9, -0.4, -0.7), (0.8, 0.33, 0.51)),
    "along an axis": ((-0.93, 0.1, 0.2), (1, 0, 0)),
    "against an axis": ((0.11, 0.1, 0.74), (0, 0, -1)),
    "from the middle of a voxel": ((0.0, 0.125, 0.125), (-0.3, 0.4, -0.2)),
    "from a face": ((-0.2, 0.1, 0.1), (-1, 0.2, 0.1)),
    "from a face upwards": ((-0.2, 0.1, 0.1), (1, 0.2, 0.1)),
    "from an edge": ((0.2, 0.25, 0.1), (-0.5, -0.7, 0.3)),
    "from a corner": ((0.2, 0.25, 0.25), (-0.5, 0.7, -0.3)),
    "through corners": ((0.0, 0.125, 0.125), (0.4, 0.25, 0.25)),
    "through edges": ((0.0, -0.125, 0.1), (-0.4, 0.25, 0.0)),
    "nearly along a face": ((-1.0 + 1e-9, 1e-9, 0.1), (1, 1e-9, 0)),
}


@pytest.mark.quick_cases("oblique", "along an axis")
@pytest.mark.parametrize("ray", RAYS)
def test_a_beam_is_lessened_by_the_line_integral_to_all_digits(ray):
    for absorption in (checkerboard(), strewn(low=-3, high=1)):
        grid = tp.Grid(box=tp.Box(size=SIZE), absorption=absorption)
        left = come_through(grid, *RAYS[ray])
        assert left.value == pytest.approx(math.exp(-depth_along(grid, *RAYS[ray])), rel=1e-11, abs=1e-18)


def test_a_beam_in_a_face_of_voxels_is_in_one_of_both():
    """In the one of the higher number, all the way: a ray that lies in a face to the last digit has no better answer."""
    grid = tp.Grid(box=tp.Box(size=SIZE), absorption=checkerboard())
    left = come_through(grid, (-1.0, 0.0, 0.1), (1, 0, 0)).value  # y = 0: between the second and the third
    either = [math.exp(-depth_along(grid, (-1.0, y, 0.1), (1, 0, 0))) for y in (-1e-6, 1e-6)]
    assert left == pytest.approx(either[1], rel=1e-12) and either[0] != pytest.approx(either[1], rel=0.01)


@pytest.mark.parametrize("tracking", ["analog", "weighted"])
@pytest.mark.parametrize(
    "field",
    [checkerboard((5, 4, 7)), strewn(high=1.0), pytest.param(strewn((9, 7, 13)), marks=pytest.mark.slow)],
    ids=["checkerboard", "strewn", "wild"],
)
def test_a_broad_beam_is_lessened_by_the_mean_of_line_integrals(field, tracking):
    grid = tp.Grid(box=tp.Box(size=SIZE), absorption=field)
    assert_agrees(lit_along_z(grid, tracking), columns(grid), FALSE_ALARM)


@pytest.mark.parametrize(
    "block", [1, 2, pytest.param(4, marks=pytest.mark.slow), pytest.param(8, marks=pytest.mark.slow)]
)
def test_macro_cells_of_any_size_give_the_same_means(block, monkeypatch):
    plant_block(monkeypatch, block)
    grid = tp.Grid(box=tp.Box(size=SIZE), absorption=strewn((9, 7, 13), high=1.0), scattering=0.0)
    assert_agrees(lit_along_z(grid, "analog"), columns(grid), FALSE_ALARM)


FAULTS = {
    "majorants 1 % low": ("macro_cells", lambda cells: (cells[0], 0.99 * cells[1])),
    "cells off by one": ("macro_cells", lambda cells: (cells[0], np.roll(cells[1], 1, axis=2))),
    "cells backwards": ("macro_cells", lambda cells: (cells[0], np.ascontiguousarray(cells[1][::-1]))),
    "too few real": ("quantized_shares", lambda levels: levels - levels // 8),
    "voxels backwards": ("quantized_shares", lambda levels: levels[::-1].copy()),
    "voxels off by one": ("quantized_shares", lambda levels: np.roll(levels, 1)),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    "fault", [pytest.param(f, marks=pytest.mark.slow if f == "majorants 1 % low" else ()) for f in FAULTS]
)
def test_planted_faults_are_seen(fault, monkeypatch):
    name, wrong = FAULTS[fault]
    particles = 2_000_000 if fault == "majorants 1 % low" else 300_000
    field = strewn((9, 7, 13), low=-0.3, high=0.5)
    if name == "macro_cells":  # all voxels of a macro cell at its majorant
        field = strewn((5, 4, 7), low=-0.3, high=0.3).repeat(2, 0).repeat(2, 1).repeat(2, 2)[:9, :7, :13]
    grid = tp.Grid(box=tp.Box(size=SIZE), absorption=field)
    plant_block(monkeypatch, 2)
    assert_agrees(lit_along_z(grid, "analog", particles), columns(grid), FALSE_ALARM)
    right = getattr(grids, name)
    forget_programs()
    monkeypatch.setattr(grids, name, lambda *given: wrong(right(*given)))
    with pytest.raises(AssertionError):
        assert_agrees(lit_along_z(grid, "analog", particles), columns(grid), FALSE_ALARM)


def test_swapped_axes_are_seen():
    rows = np.broadcast_to(np.array([0.5, 1.0, 2.0, 4.0])[:, None, None], (4, 4, 4))
    grid, swapped = (
        tp.Grid(box=tp.Box(size=SIZE), absorption=each) for each in (rows, rows.transpose(1, 0, 2))
    )
    start, way = (-0.9, -0.4, -0.7), (0.8, 0.33, 0.51)
    left = come_through(grid, start, way).value
    assert left == pytest.approx(math.exp(-depth_along(grid, start, way)), rel=1e-12)
    assert left != pytest.approx(math.exp(-depth_along(swapped, start, way)), rel=0.01)


# ---- the same in other words ----


def layers(n: int = 4):
    rng = np.random.default_rng(5)
    return rng.uniform(0, 1, n), rng.uniform(0.5, 4, n)


@pytest.mark.parametrize("tracking", ["analog", "weighted"])
def test_a_layered_grid_is_a_stack_of_media(tracking):
    absorption, scattering = layers()
    thickness = SIZE[2] / len(absorption)
    phase = tp.HenyeyGreenstein(0.5)
    stack = [
        tp.Surface(
            tp.Box(center=(0, 0, -SIZE[2] / 2 + (k + 0.5) * thickness), size=(*SIZE[:2], thickness)),
            tp.Transparent(),
            inside=tp.Medium(absorption=a, scattering=s, phase=phase),
        )
        for k, (a, s) in enumerate(zip(absorption, scattering, strict=True))
    ]
    fields = {
        name: np.tile(field, (3, 2, 1))
        for name, field in (("absorption", absorption), ("scattering", scattering))
    }
    grid = tp.Grid(box=tp.Box(size=SIZE), phase=phase, **fields)
    source = tp.Source(tp.Point(position=(0.1, 0.2, -0.7)), tp.Beam((0.1, 0.2, 1), power=1.0))
    lids = [
        tp.Detector(tp.Plane(center=(0, 0, z)), name=name) for name, z in (("bottom", -0.76), ("lid", 0.76))
    ]
    results = [
        tp.simulate(tp.Scene(source, parts, lids), particles=200_000, seed=seed, threads=1, tracking=tracking)
        for seed, parts in enumerate((stack, [tp.Surface(grid.box, tp.Transparent(), inside=grid)]))
    ]
    for quantity in (
        (lambda r: r["lid"].flux_out),
        (lambda r: r["bottom"].flux_in),
        (lambda r: r.ledger["absorbed"]),
    ):
        one, other = map(quantity, results)
        assert_agrees(one - other, 0.0, FALSE_ALARM)


def test_weights_and_chance_agree_where_voxels_absorb_and_scatter():
    grid = tp.Grid(box=tp.Box(size=SIZE), absorption=strewn(high=0.5), scattering=strewn(seed=2, high=1.0))
    source = tp.Source(tp.Point(position=(0.1, 0.2, 0.3)), tp.Isotropic(power=1.0))
    results = [
        tp.simulate(grid_scene(grid, source), particles=200_000, seed=seed, threads=1, tracking=tracking)
        for seed, tracking in enumerate(("analog", "weighted"))
    ]
    assert_agrees(results[0].ledger["escaped"] - results[1].ledger["escaped"], 0.0, FALSE_ALARM)
    for result in results:  # exactly, in each batch
        whole = result.ledger["absorbed"] + result.ledger["escaped"] + result.ledger["roulette"]
        assert whole.value == pytest.approx(1.0, rel=1e-14) and result.ledger["lost"].value == 0


# ---- what no voxel can change ----


def test_in_a_room_of_one_radiance_every_voxel_sees_it():
    field = strewn((5, 4, 6), low=-3, high=2)
    grid = tp.Grid(box=tp.Box(size=SIZE), scattering=field, phase=tp.HenyeyGreenstein(-0.4))
    room = tp.Surface(tp.Sphere(radius=2.0), tp.Black(), name="room")
    cloud = tp.Surface(grid.box, tp.Transparent(), inside=grid)
    source = tp.Source("room", tp.Lambertian(radiance=1.0), side="inside")
    look = tp.VolumeDetector(grid.box, name="voxels", cells=grid.shape)
    result = tp.simulate(tp.Scene(source, [room, cloud], [look]), particles=100_000, seed=1, threads=1)
    assert_agrees(result["voxels"].fluence_rate, 4 * math.pi, FALSE_ALARM)


def test_empty_voxels_cost_no_draw():
    field = np.zeros((32, 32, 32))
    field[20, 7, 30] = 1e3
    grid = tp.Grid(box=tp.Box(size=SIZE), scattering=field)
    source = tp.Source(tp.Point(position=(-0.9, -0.4, -0.7)), tp.Beam((1, 0, 0), power=1.0))
    for tracking in ("analog", "weighted"):
        result = tp.simulate(grid_scene(grid, source), particles=10_000, seed=1, threads=1, tracking=tracking)
        assert result.ledger["escaped"].value == 1.0 and result.cost.collisions == 0
    nothing = tp.Grid(box=tp.Box(size=SIZE), scattering=np.zeros((2, 2, 2)))
    assert come_through(nothing, (-0.9, -0.4, -0.7), (1, 0, 0)).value == 1.0
