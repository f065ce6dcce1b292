"""Grids where numbers are extreme or things meet: any size and unit, needles of voxels, grids in grids, lenses of voxels."""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.bench.grid import memory
from tests.grid_scenes import (
    FALSE_ALARM,
    SIZE,
    columns,
    depth_along,
    grid_scene,
    lit_along_z,
    plant_block,
    strewn,
)

PHASE = tp.HenyeyGreenstein(0.6)


def motley_scene(size: float = 1.0, center=(0.0, 0.0, 0.0)) -> tp.Scene:
    """Voxels that absorb and scatter about a mirror ball, all lengths times `size`."""
    box = tp.Box(center=tuple(center), size=tuple(size * side for side in SIZE))
    fields = {
        "absorption": strewn((9, 7, 13), high=0.5) / size,
        "scattering": strewn((9, 7, 13), 2, high=1.5) / size,
    }
    grid = tp.Grid(box=box, **fields, phase=PHASE)
    place = tuple(c + size * p for c, p in zip(center, (0.8, 0.25, 0.25), strict=True))
    ball = tp.Sphere(
        center=tuple(c + size * p for c, p in zip(center, (0.25, 0.125, 0), strict=True)), radius=0.25 * size
    )
    parts = [tp.Surface(box, tp.Transparent(), inside=grid), tp.Surface(ball, tp.Mirror(0.9))]
    return tp.Scene(tp.Source(tp.Point(position=place), tp.Isotropic(power=1.0)), parts)


@pytest.mark.parametrize("tracking", ["analog", "weighted"])
def test_units_and_places_do_not_matter(tracking):
    results = [
        tp.simulate(scene, particles=20_000, seed=2, threads=1, tracking=tracking)
        for scene in (
            motley_scene(),
            motley_scene(1e-9),
            motley_scene(3e11),
            motley_scene(center=(4e6, -2e6, 1e6)),
        )
    ]
    for result in results:
        assert result.ledger["lost"].value == 0
        assert result.cost.collisions == pytest.approx(results[0].cost.collisions, rel=1e-3)
        for name in ("absorbed", "escaped"):
            assert result.ledger[name].value == pytest.approx(results[0].ledger[name].value, rel=2e-3)
    assert results[1].ledger["escaped"].value == pytest.approx(results[0].ledger["escaped"].value, rel=1e-9)


@pytest.mark.parametrize("tracking", ["analog", "weighted"])
def test_voxels_of_all_magnitudes_stay_numbers(tracking):
    """From 1e-300 to 1e15 m^-1; a beam along z sees the exact mean over the columns."""
    field = np.random.default_rng(3).choice([0.0, 1e-300, 1e-20, 1e-3, 0.3, 1.0], (6, 5, 9))
    field[2, 3, 4], field[0, 0, 0], field[5, 4, 8] = 1e15, 1e6, 1e9
    grid = tp.Grid(box=tp.Box(size=SIZE), absorption=field)
    through = lit_along_z(grid, tracking)
    assert_agrees(through, columns(grid), FALSE_ALARM)


@pytest.mark.parametrize("shape", [(1, 1, 1000), (1000, 1, 1), (3, 500, 2)])
def test_needles_and_slices(shape):
    """By chance within errors; by weights, where all rays cross the same voxels, to rounding."""
    grid = tp.Grid(box=tp.Box(size=SIZE), absorption=strewn(shape, low=-1, high=0.3))
    assert_agrees(lit_along_z(grid, "analog"), columns(grid), FALSE_ALARM)
    weighted = lit_along_z(grid, "weighted")
    if shape[:2] == (1, 1):
        assert weighted.value == pytest.approx(columns(grid), rel=1e-12)
    else:
        assert_agrees(weighted, columns(grid), FALSE_ALARM)
    start, way = (-0.9, -0.4, -0.7), (0.8, 0.33, 0.51)
    beam = tp.Source(tp.Point(position=start), tp.Beam(way, power=1.0))
    left = tp.simulate(grid_scene(grid, beam), particles=64, seed=1, threads=1).ledger["escaped"]
    assert left.value == pytest.approx(math.exp(-depth_along(grid, start, way)), rel=1e-11)


def test_grids_in_grids_and_beside_grids_leave_one_radiance_alone():
    """A ball of fog in a grid in a grid, and a third that shares a face with them, in a room of radiance 1: 4 pi everywhere."""
    outer = tp.Grid(box=tp.Box(size=1.0), scattering=strewn((7, 6, 5), low=-2, high=1.5), phase=PHASE)
    inner = tp.Grid(box=tp.Box(size=0.5), scattering=strewn((3, 4, 5), 2, low=-2, high=1.5))
    beside = tp.Grid(
        box=tp.Box(center=(1, 0, 0), size=1.0), scattering=strewn((2, 3, 4), 3, low=-2, high=1.5)
    )
    ball = tp.Sphere(radius=0.2)
    parts = [tp.Surface(grid.box, tp.Transparent(), inside=grid) for grid in (outer, inner, beside)]
    parts.append(tp.Surface(ball, tp.Transparent(), inside=tp.Medium(scattering=5.0)))
    room = tp.Surface(tp.Sphere(center=(0.5, 0, 0), radius=2.0), tp.Black(), name="room")
    looks = [
        tp.VolumeDetector(shape, name=name)
        for name, shape in (
            ("outer", outer.box),
            ("inner", inner.box),
            ("beside", beside.box),
            ("ball", ball),
        )
    ]
    source = tp.Source("room", tp.Lambertian(radiance=1.0), side="inside")
    result = tp.simulate(tp.Scene(source, [*parts, room], looks), particles=200_000, seed=1, threads=1)
    assert result.ledger["lost"].value == 0
    for look in looks:
        assert_agrees(result[look.name].fluence_rate, 4 * math.pi, FALSE_ALARM)


def alike(make, **options):
    """The results of the same scene with a medium and with a grid of one coefficient."""
    box, coefficients = tp.Box(size=SIZE), {"absorption": 0.5, "scattering": 2.0}
    medium = tp.Medium(**coefficients, phase=PHASE, index=options.pop("index", 1.0))
    grid = tp.Grid(
        box=box, absorption=0.5, scattering=np.full((40, 3, 9), 2.0), phase=PHASE, index=medium.index
    )
    defaults = {"particles": 40_000, "seed": 5, "threads": 1, "tracking": "analog"}
    return [tp.simulate(make(box, filling), **(defaults | options)) for filling in (medium, grid)]


def assert_same(results, *quantities):
    """The same random numbers: the same, to what a history that rounding parts from its twin may do."""
    for quantity in quantities:
        one, other = (quantity(result).value for result in results)
        assert one > 0 and other == pytest.approx(one, rel=1e-3)


def test_meters_within_and_an_aim_through():
    pane = tp.Disk(center=(0.1, 0, 0.2), normal=(0.1, 0, 1), radius=0.3)

    def make(box, filling):
        lamp = tp.Source(tp.Point(position=(0.1, 0.1, -2.0)), tp.Isotropic(power=1.0), aim=pane)
        return tp.Scene(
            lamp, tp.Surface(box, tp.Transparent(), inside=filling), tp.Detector(pane, name="pane")
        )

    assert_same(alike(make), (lambda r: r["pane"].flux_in), (lambda r: r["pane"].flux_out))


def test_clock_and_index():
    """Light that is slower by the index, in a box that refracts and reflects, up to the end of the clock."""

    def make(box, filling):
        wall = tp.Surface(box, tp.Dielectric(1.4), inside=filling, name="glass")
        lamp = tp.Source(tp.Point(position=(0.1, 0.1, 0.2)), tp.Isotropic(energy=1.0))
        return tp.Scene(lamp, wall, duration=4e-9)

    results = alike(make, index=1.4)
    assert_same(results, *(lambda r, name=name: r.ledger[name] for name in ("in_flight", "absorbed")))


def test_forced_collisions_are_refused():
    grid = tp.Grid(box=tp.Box(size=SIZE), scattering=strewn(seed=2, high=0.8))
    source = tp.Source(tp.Point(position=(0.1, 0.1, -0.7)), tp.Beam((0, 0, 1), power=1.0))
    with pytest.raises(tp.SceneError, match="Grid, got forced=True"):
        tp.simulate(grid_scene(grid, source), particles=10, tracking=tp.Tracking(forced=True))


def test_splitting_has_the_same_means():
    tracking = tp.Tracking(splitting=tp.Splitting(start=(0, 0, -0.75), end=(0, 0, 0.75), gain=30.0))
    source = tp.Source(tp.Point(position=(0.1, 0.1, -0.7)), tp.Beam((0, 0, 1), power=1.0))
    lid = tp.Detector(tp.Plane(center=(0, 0, 0.76)), name="lid")
    grid = tp.Grid(
        box=tp.Box(size=SIZE), absorption=strewn(high=0), scattering=strewn(seed=2, high=0.8), phase=PHASE
    )
    results = [
        tp.simulate(grid_scene(grid, source, lid), particles=100_000, seed=seed, threads=1, tracking=each)
        for seed, each in enumerate(("analog", tracking))
    ]
    assert_agrees(results[0]["lid"].flux_out - results[1]["lid"].flux_out, 0.0, FALSE_ALARM)
    assert_agrees(results[0].ledger["absorbed"] - results[1].ledger["absorbed"], 0.0, FALSE_ALARM)


def test_flights_that_pause_do_not_collide(monkeypatch):
    """A flight through 400 macro cells is cut into dozens; only what collides counts."""
    plant_block(monkeypatch, 1)
    grid = tp.Grid(box=tp.Box(size=SIZE), scattering=np.full((400, 300, 5), 1e-3), phase=PHASE)
    source = tp.Source(tp.Point(position=(-0.999, 0.1, 0.1)), tp.Beam((1, 0.1, 0.05), power=1.0))
    result = tp.simulate(grid_scene(grid, source), particles=100_000, seed=1, threads=1)
    way = depth_along(grid, (-0.999, 0.1, 0.1), (1, 0.1, 0.05))
    collided = result.cost.collisions / 100_000
    assert abs(collided - way) < 6 * math.sqrt(way / 100_000) and result.ledger["lost"].value == 0


def test_every_place_on_the_lattice_lets_light_go_on():
    """Births in all corners, on all edges and faces of voxels, along all axes and diagonals of the lattice."""
    grid = tp.Grid(box=tp.Box(size=SIZE), absorption=np.full((4, 4, 4), 0.5))
    steps = [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (x, y, z) != (0, 0, 0)]
    side = np.array(SIZE) / 4
    for corner in ((1, 2, 3), (2, 2, 2), (1.5, 2, 3), (1.5, 2.5, 3)):
        start = -np.array(SIZE) / 2 + np.array(corner) * side
        for way in steps:
            direction = np.array(way) * side
            beam = tp.Source(tp.Point(position=tuple(start)), tp.Beam(tuple(direction), power=1.0))
            for tracking in ("weighted",):
                result = tp.simulate(
                    grid_scene(grid, beam), particles=8, seed=1, threads=1, tracking=tracking, batches=2
                )
                left = np.where(np.array(way) > 0, 4 - np.array(corner), np.array(corner))[
                    np.array(way) != 0
                ].min()
                exact = math.exp(-0.5 * left * np.linalg.norm(direction))
                assert result.ledger["escaped"].value == pytest.approx(exact, rel=1e-12)


def test_a_grid_of_two_million_voxels_takes_less_than_100_megabytes():
    assert memory()["most"] < 100
