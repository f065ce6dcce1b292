"""Volume detectors and voxels at their edges: rays along and from faces, through corners, tangent; thin and thick; any size and unit.

Rays are driven through the passes of one volume detector by themselves, and compared cell by cell with lengths between exact
crossings (fractions).
"""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise, product

import numpy as np
import pytest
from numba import config

import transport as tp
from tests.agreement import assert_agrees
from tests.bench.grid import memory
from tests.driven import PASS
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
from tests.slow import quick
from transport.compile.compiler import compile_scene
from transport.engine import driver
from transport.engine.bundle import LANES, empty_bundle
from transport.engine.driver import compile_program, run_batch
from transport.engine.program import build_program

BOX, BALL = tp.Box(size=(1.0, 0.5, 0.25)), tp.Sphere(radius=0.5)
LAMP = tp.Source(tp.Sphere(radius=1.0), tp.Lambertian(power=1.0), side="back")
WAY_UNITS = np.array([2.0**-32, 2.0**-63])
PHASE = tp.HenyeyGreenstein(0.6)
both_shapes = pytest.mark.parametrize("shape", [BOX, BALL], ids=["box", "ball"])
trackings = pytest.mark.parametrize("tracking", ["analog", "weighted"])


class Rays:
    """Lanes that fly from `start` to `distance`, through the passes of a scene with one volume."""

    def __init__(self, shape, cells=None, absorption=0.0):
        medium = tp.Medium(absorption=absorption, scattering=1.0)
        about = tp.Surface(tp.Sphere(radius=3.0), tp.Transparent(), inside=medium)
        scene = tp.Scene(LAMP, about, tp.VolumeDetector(shape, "it", cells))
        self.machine = compile_program(
            build_program(compile_scene(scene, tp.Tracking(absorption="weighted")))
        )
        self.plan = self.machine.program.plan
        self.volume = self.plan.volumes[0]

    def walk(self, origins, flights, starts=0.0, ends=math.inf, weights=1.0, waits=False, sigma_a=0.0):
        """Sums by cell of all rays: weight times length [m], number of passages, absorbed weight."""
        bundle, count, size = empty_bundle(), len(origins), self.plan.space.size
        assert count <= LANES
        tallies = np.zeros((self.plan.rows, 4), np.int64)
        bundle["tallies"], bundle["arena"] = tallies.ctypes.data, self.plan.arena.memory.ctypes.data
        values = dict(zip("xyz", (np.asarray(origins, float) - self.plan.space.origin).T / size, strict=True))
        values |= dict(zip(("ux", "uy", "uz"), np.asarray(flights, float).T, strict=True))
        values |= {
            "start": starts / size,
            "distance": np.asarray(ends) / size,
            "weight": weights,
            "flies": not waits,
        }
        values |= {"sigma_a": sigma_a * size, "mfp": math.inf, "survival": 1.0}
        for name, value in values.items():
            bundle[0][name][:count] = value
        for lane_pass, offset in self.machine.program.steps:
            if not lane_pass.function.__module__.endswith(("volumes", "volume_cells")):
                continue
            if config.DISABLE_JIT:
                lane_pass.entry(bundle.view(np.recarray)[0], offset, 0, count)
            else:
                PASS(lane_pass.entry)(bundle.ctypes.data, offset, 0, count)
        row, cells = self.volume.row, self.volume.detector.volumes(self.volume.shape).size
        track = tallies[int(row["first"]) :][:cells]
        kept = tallies[int(row["kept"]) :][:cells, :2] @ WAY_UNITS if row["kept"] else np.zeros(cells)
        return track[:, :2] @ WAY_UNITS * self.volume.unit, track[:, 2], kept


def exact_lengths(origin, flight, start, end, edges):
    """Lengths [m] in the voxels between edges along x, y, z: between all crossings in fractions."""
    o, u = [list(map(Fraction, map(float, vector))) for vector in (origin, flight)]
    cuts = {Fraction(start), Fraction(end)}
    for axis in range(3):
        if u[axis] != 0:
            cuts |= {(Fraction(e) - o[axis]) / u[axis] for e in edges[axis]}
    cuts = sorted(t for t in cuts if start <= t <= end)
    lengths = np.zeros([len(e) - 1 for e in edges])
    for a, b in pairwise(cuts):
        place = [o[axis] + (a + b) / 2 * u[axis] for axis in range(3)]
        cell = [np.searchsorted(e, float(x), side="right") - 1 for e, x in zip(edges, place, strict=True)]
        cell = [len(e) - 2 if x == e[-1] else c for c, e, x in zip(cell, edges, place, strict=True)]
        if all(0 <= c < len(e) - 1 for c, e in zip(cell, edges, strict=True)):
            lengths[tuple(cell)] += float(b - a)
    return lengths


def random_rays(count, seed):
    """Rays to places in the middle of both shapes, some in planes across x, some along z."""
    rng = np.random.default_rng(seed)
    origins = rng.uniform(-0.8, 0.8, (count, 3))
    flights = rng.uniform(-0.12, 0.12, (count, 3)) - origins
    origins[: count // 8, 0], flights[: count // 8, 0] = rng.uniform(-0.4, 0.4, count // 8), 0.0
    origins[: count // 16, 1], flights[: count // 16, 1] = rng.uniform(-0.2, 0.2, count // 16), 0.0
    flights /= np.linalg.norm(flights, axis=1)[:, None]
    return origins, flights, rng.uniform(0.0, 0.5, count), rng.uniform(0.5, 2.0, count)


@pytest.mark.quick_cases("None")
@pytest.mark.parametrize("cells", [None, (1, 1, 1), (7, 3, 5), (1, 64, 2)])
def test_lengths_in_voxels_are_those_between_exact_crossings(cells):
    """A walk that took the wrong cell, or lost a part, would be off by about the size of a cell."""
    rays = Rays(BOX, cells)
    edges = [np.linspace(a, b, n + 1) for a, b, n in zip(*BOX.bounds, cells or (1, 1, 1), strict=True)]
    them = random_rays(64, 1)
    for origin, flight, start, end in zip(*them, strict=True):
        found, _, _ = rays.walk([origin], [flight], start, end)
        exact = exact_lengths(origin, flight, start, end, edges).ravel()
        np.testing.assert_allclose(found, exact, rtol=0, atol=4e-15)
    together, counts, _ = rays.walk(*them)
    assert together.sum() > 10 and counts.sum() > 40


@pytest.mark.parametrize("cells", [None, 1, 6, (0.1, 0.2, 0.20001, 0.5), (0.0, 0.3)])
def test_lengths_in_shells_are_differences_of_chords(cells):
    rays = Rays(BALL, cells)
    radii = rays.volume.detector.edges(BALL).get("r", np.array([0.0, 0.5]))
    for o, u, start, end in zip(*random_rays(64, 2), strict=True):
        h, q2 = o @ u, o @ o - (o @ u) ** 2
        half = np.sqrt(np.maximum(radii**2 - q2, 0.0))
        inside = np.maximum(np.minimum(end + h, half) - np.maximum(start + h, -half), 0.0)
        found, _, _ = rays.walk([o], [u], start, end)
        np.testing.assert_allclose(found, np.diff(inside), rtol=0, atol=2e-14)


@pytest.mark.parametrize("cells", [None, (4, 4, 4)])
def test_a_ray_along_faces_and_edges_counts_once(cells):
    """Within the planes of voxels, and those of the box, along z: 0.25 m in all, with both signs of a zero."""
    rays = Rays(BOX, cells)
    for x, y, sign, zero in product(
        (-0.5, -0.25, 0.0, 0.25, 0.5), (-0.25, 0.0, 0.25), (1.0, -1.0), (0.0, -0.0)
    ):
        found, counts, _ = rays.walk([(x, y, -0.7 * sign)], [(zero, zero, sign)])
        assert found.sum() == pytest.approx(0.25, rel=1e-14), (x, y, sign)
        assert counts.sum() == (1 if cells is None else 4), (x, y, sign)


@pytest.mark.parametrize("n", [1, 4, 5])
@pytest.mark.parametrize(("start", "way"), [(-1, 1), (-0.5, 1), (0.5, -1)])
def test_a_ray_through_corners_of_voxels_is_whole(n, start, way):
    """Along the diagonal of a cube all three faces are met at once; from outside and from the corner."""
    found, _, _ = Rays(tp.Box(size=1.0), (n, n, n)).walk(
        [np.full(3, start)], [np.full(3, way / math.sqrt(3))]
    )
    on_diagonal = np.einsum("iii->i", found.reshape(n, n, n))
    assert found.sum() == pytest.approx(math.sqrt(3), rel=1e-14)
    assert on_diagonal.sum() == pytest.approx(math.sqrt(3), rel=1e-14)


@pytest.mark.parametrize(
    ("x", "ux", "exact"),
    [
        (-0.5, 1.0, [0.25] * 4), (-0.5, -1.0, [0] * 4), (0.5, -1.0, [0.25] * 4), (0.5, 1.0, [0] * 4),
        (0.0, 1.0, [0, 0, 0.25, 0.25]), (0.0, -1.0, [0.25, 0.25, 0, 0]),
    ],
)  # fmt: skip
def test_a_ray_that_starts_on_a_face_counts_on_the_side_that_it_flies_to(x, ux, exact):
    found, counts, _ = Rays(BOX, (4, 1, 1)).walk([(x, 0.1, 0.1)], [(ux, 0.0, 0.0)])
    assert found == pytest.approx(exact, abs=1e-15)
    assert counts.tolist() == [length > 0 for length in exact]


@pytest.mark.slow
@pytest.mark.parametrize("depth", [1e-300, 1e-12, 1e-9, 1e-3, 1.0, 30.0, 1e4])
@both_shapes
def test_fading_keeps_its_digits_from_thin_to_thick(shape, depth):
    """Of a ray along x, 1 m through all, from 0.5 m before: each cell against expm1 in double precision."""
    ray = [(-1.0, 0.0, 0.0)], [(1.0, 0.0, 0.0)]
    found, _, kept = Rays(shape, (4, 1, 1) if shape is BOX else 2, 1.0).walk(*ray, sigma_a=depth)
    places = np.linspace(0.5, 1.5, 5)
    exact = -np.exp(-depth * places[:-1]) * np.expm1(-depth * np.diff(places)) / depth
    exact = exact if shape is BOX else np.array([exact[1] + exact[2], exact[0] + exact[3]])
    tiny = 2.0**-62  # of what the sums resolve
    np.testing.assert_allclose(found, exact, rtol=1e-13, atol=tiny)
    np.testing.assert_allclose(kept, depth * exact, rtol=1e-13, atol=tiny)
    whole, _, _ = Rays(shape, None, 1.0).walk(*ray, sigma_a=depth)
    assert whole[0] == pytest.approx(exact.sum(), rel=1e-13, abs=tiny)


# ---- any size and place ----


@pytest.mark.parametrize("name", ["at the origin", "aside"])
def test_a_volume_as_small_as_a_billionth_of_the_scene_is_counted_rightly(name):
    """Two of them: one is where numbers are finest, the other is not."""
    tiny, centers = 1e-9, {"at the origin": (0, 0, 0), "aside": (0.3, 0.4, 0.0)}
    looks = [tp.VolumeDetector(tp.Box(size=tiny, center=c), n, (2, 1, 1)) for n, c in centers.items()]
    aim = tp.Sphere(radius=tiny, center=centers[name])
    lamp = tp.Source(tp.Point(position=(0, 0, 0.9)), tp.Isotropic(intensity=1.0), aim=aim)
    result = tp.simulate(tp.Scene(lamp, [], looks), particles=20_000, seed=1, progress=False)
    found = result[name].fluence_rate.mean()
    exact = 1 / math.dist((0, 0, 0.9), centers[name]) ** 2
    assert abs(found.value - exact) < 5 * found.error and found.relative_error < 0.02


def test_a_batch_that_scores_too_much_is_refused_before_a_sum_overflows(monkeypatch):
    """The guard looks between bundles: as if 2^60 units had been added up."""
    machine = compile_program(build_program(compile_scene(tp.Scene(LAMP, [], tp.VolumeDetector(BOX, "box")))))
    real = driver.drive

    def full(lanes, *rest):
        real(lanes, *rest)
        lanes["scored"] = driver.MAX_SCORED

    monkeypatch.setattr(driver, "drive", full)
    with pytest.raises(OverflowError, match="pass more batches"):
        run_batch(machine, seed=1, batch=0, histories=100)


# ---- grids of voxels: extreme numbers, needles, grids in grids ----


def motley_scene(size=1.0, center=(0.0, 0.0, 0.0)):
    """Voxels that absorb and scatter about a mirror ball, all lengths times `size`."""

    def place(*p):
        return tuple(c + size * x for c, x in zip(center, p, strict=True))

    box = tp.Box(center=tuple(center), size=tuple(size * side for side in SIZE))
    absorption, scattering = strewn((9, 7, 13), high=0.5) / size, strewn((9, 7, 13), 2, high=1.5) / size
    grid = tp.Grid(box=box, absorption=absorption, scattering=scattering, phase=PHASE)
    ball = tp.Sphere(center=place(0.25, 0.125, 0), radius=0.25 * size)
    parts = [tp.Surface(box, tp.Transparent(), inside=grid), tp.Surface(ball, tp.Mirror(0.9))]
    return tp.Scene(tp.Source(tp.Point(position=place(0.8, 0.25, 0.25)), tp.Isotropic(power=1.0)), parts)


@pytest.mark.slow
@trackings
def test_grids_do_not_depend_on_units_and_places(tracking):
    scenes = motley_scene(), motley_scene(1e-9), motley_scene(3e11), motley_scene(center=(4e6, -2e6, 1e6))
    first, *others = (
        tp.simulate(scene, particles=20_000, seed=2, threads=1, tracking=tracking) for scene in scenes
    )
    for result in (first, *others):
        assert result.ledger["lost"].value == 0
        assert result.cost.collisions == pytest.approx(first.cost.collisions, rel=1e-3)
        for name in ("absorbed", "escaped"):
            assert result.ledger[name].value == pytest.approx(first.ledger[name].value, rel=2e-3)
    assert others[0].ledger["escaped"].value == pytest.approx(first.ledger["escaped"].value, rel=1e-9)


@pytest.mark.parametrize("tracking", quick(["analog", "weighted"], "analog"))
def test_voxels_of_all_magnitudes_stay_numbers(tracking):
    """From 1e-300 to 1e15 m^-1; a beam along z sees the exact mean over the columns."""
    field = np.random.default_rng(3).choice([0.0, 1e-300, 1e-20, 1e-3, 0.3, 1.0], (6, 5, 9))
    field[2, 3, 4], field[0, 0, 0], field[5, 4, 8] = 1e15, 1e6, 1e9
    grid = tp.Grid(box=tp.Box(size=SIZE), absorption=field)
    assert_agrees(lit_along_z(grid, tracking), columns(grid), FALSE_ALARM)


def left_of_beam(grid, start, way, particles=64, **options):
    """What leaves a grid of a beam of 1 W."""
    lamp = tp.Source(tp.Point(position=tuple(start)), tp.Beam(tuple(way), power=1.0))
    result = tp.simulate(grid_scene(grid, lamp), particles=particles, seed=1, threads=1, **options)
    return result.ledger["escaped"].value


@pytest.mark.parametrize("shape", quick([(1, 1, 1000), (1000, 1, 1), (3, 500, 2)], (3, 500, 2)))
def test_needles_and_slices_of_voxels(shape):
    """By chance within errors; by weights, where all rays cross the same voxels, to rounding."""
    grid = tp.Grid(box=tp.Box(size=SIZE), absorption=strewn(shape, low=-1, high=0.3))
    assert_agrees(lit_along_z(grid, "analog"), columns(grid), FALSE_ALARM)
    weighted = lit_along_z(grid, "weighted")
    if shape[:2] == (1, 1):
        assert weighted.value == pytest.approx(columns(grid), rel=1e-12)
    else:
        assert_agrees(weighted, columns(grid), FALSE_ALARM)
    ray = (-0.9, -0.4, -0.7), (0.8, 0.33, 0.51)
    assert left_of_beam(grid, *ray) == pytest.approx(math.exp(-depth_along(grid, *ray)), rel=1e-11)


def test_grids_in_grids_and_beside_grids_leave_one_radiance_alone():
    """A ball of fog in a grid in a grid, and a third that shares a face with them, in a room of radiance 1: 4 pi everywhere."""
    fogs = {
        "outer": tp.Grid(box=tp.Box(size=1.0), scattering=strewn((7, 6, 5), low=-2, high=1.5), phase=PHASE),
        "inner": tp.Grid(box=tp.Box(size=0.5), scattering=strewn((3, 4, 5), 2, low=-2, high=1.5)),
        "beside": tp.Grid(
            box=tp.Box(center=(1, 0, 0), size=1.0), scattering=strewn((2, 3, 4), 3, low=-2, high=1.5)
        ),
        "ball": tp.Medium(scattering=5.0),
    }
    shapes = {name: getattr(fog, "box", tp.Sphere(radius=0.2)) for name, fog in fogs.items()}
    parts = [tp.Surface(shapes[name], tp.Transparent(), inside=fog) for name, fog in fogs.items()]
    room = tp.Surface(tp.Sphere(center=(0.5, 0, 0), radius=2.0), tp.Black(), name="room")
    looks = [tp.VolumeDetector(shape, name=name) for name, shape in shapes.items()]
    source = tp.Source("room", tp.Lambertian(radiance=1.0), side="inside")
    result = tp.simulate(tp.Scene(source, [*parts, room], looks), particles=200_000, seed=1, threads=1)
    assert result.ledger["lost"].value == 0
    for name in fogs:
        assert_agrees(result[name].fluence_rate, 4 * math.pi, FALSE_ALARM)


def lamp_before_a_pane(box, filling):
    """Detectors within and an aim through a grid."""
    pane = tp.Disk(center=(0.1, 0, 0.2), normal=(0.1, 0, 1), radius=0.3)
    lamp = tp.Source(tp.Point(position=(0.1, 0.1, -2.0)), tp.Isotropic(power=1.0), aim=pane)
    body = tp.Surface(box, tp.Transparent(), inside=filling)
    return tp.Scene(lamp, body, tp.Detector(pane, name="pane"))


def flash_in_glass(box, filling):
    """Light that is slower by the index, in a box that refracts and reflects, up to the end of the clock."""
    wall = tp.Surface(box, tp.Dielectric(1.4), inside=filling, name="glass")
    lamp = tp.Source(tp.Point(position=(0.1, 0.1, 0.2)), tp.Isotropic(energy=1.0))
    return tp.Scene(lamp, wall, duration=4e-9)


@pytest.mark.parametrize(
    ("make", "index", "names"),
    [
        (lamp_before_a_pane, 1.0, ("pane.flux_in", "pane.flux_out")),
        (flash_in_glass, 1.4, ("ledger.in_flight", "ledger.absorbed")),
    ],
)
def test_a_grid_of_one_coefficient_is_a_medium(make, index, names):
    """The same random numbers: the same, to what a history that rounding parts from its twin may do."""
    box = tp.Box(size=SIZE)
    medium = tp.Medium(absorption=0.5, scattering=2.0, phase=PHASE, index=index)
    grid = tp.Grid(box=box, absorption=0.5, scattering=np.full((40, 3, 9), 2.0), phase=PHASE, index=index)
    options = {"particles": 40_000, "seed": 5, "threads": 1, "tracking": "analog"}
    one, other = (tp.simulate(make(box, filling), **options) for filling in (medium, grid))
    for name in names:
        exact, found = (
            run.ledger[name.partition(".")[2]] if name.startswith("ledger") else run.quantity(name)
            for run in (one, other)
        )
        assert exact.value > 0 and found.value == pytest.approx(exact.value, rel=1e-3)


def test_forced_collisions_in_a_grid_are_refused():
    grid = tp.Grid(box=tp.Box(size=SIZE), scattering=strewn(seed=2, high=0.8))
    with pytest.raises(tp.SceneError, match="Grid, got forced=True"):
        left_of_beam(grid, (0.1, 0.1, -0.7), (0, 0, 1), tracking=tp.Tracking(forced=True))


@pytest.mark.slow
def test_flights_that_pause_do_not_collide(monkeypatch):
    """A flight through 400 macro cells is cut into dozens; only what collides counts."""
    plant_block(monkeypatch, 1)
    grid = tp.Grid(box=tp.Box(size=SIZE), scattering=np.full((400, 300, 5), 1e-3), phase=PHASE)
    ray = (-0.999, 0.1, 0.1), (1, 0.1, 0.05)
    source = tp.Source(tp.Point(position=ray[0]), tp.Beam(ray[1], power=1.0))
    result = tp.simulate(grid_scene(grid, source), particles=100_000, seed=1, threads=1)
    depth = depth_along(grid, *ray)
    assert abs(result.cost.collisions / 100_000 - depth) < 6 * math.sqrt(depth / 100_000)
    assert result.ledger["lost"].value == 0


@pytest.mark.slow
@pytest.mark.parametrize("corner", [(1, 2, 3), (2, 2, 2), (1.5, 2, 3), (1.5, 2.5, 3)])
def test_every_place_on_the_lattice_lets_light_go_on(corner):
    """Births in corners, on edges and faces of voxels, along all axes and diagonals of the lattice."""
    grid = tp.Grid(box=tp.Box(size=SIZE), absorption=np.full((4, 4, 4), 0.5))
    corner, side = np.array(corner), np.array(SIZE) / 4
    for step in product((-1, 0, 1), repeat=3):
        if any(step):
            way = np.array(step)
            left = np.where(way > 0, 4 - corner, corner)[way != 0].min()
            exact = math.exp(-0.5 * left * np.linalg.norm(way * side))
            start = -np.array(SIZE) / 2 + corner * side
            found = left_of_beam(grid, start, way * side, 8, tracking="weighted", batches=2)
            assert found == pytest.approx(exact, rel=1e-12), step


@pytest.mark.slow
def test_a_grid_of_two_million_voxels_takes_less_than_100_megabytes():
    assert memory()["most"] < 100
