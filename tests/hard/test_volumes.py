"""Volume detectors at their edges: rays along faces, from faces, through corners, tangent ones; thin and thick cells; any size.

Single passes are run on rays made for it and compared with ways told from exact crossings (fractions), cell by cell.
"""

from __future__ import annotations

import math
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise

import numpy as np
import pytest
from numba import config

import transport as tp
from tests.sampling import PASS
from transport.compile import compile_scene
from transport.engine.bundle import LANES, empty_bundle
from transport.engine.driver import machine_of, run_batch
from transport.engine.program import program_of

BOX, BALL = tp.Box(size=(1.0, 0.5, 0.25)), tp.Sphere(radius=0.5)
LAMP = tp.Source(tp.Sphere(radius=1.0), tp.Lambertian(power=1.0), side="back")
EMPTY, FOG = tp.Medium(scattering=1.0), tp.Medium(absorption=1.0, scattering=1.0)
WAY_UNITS = np.array([2.0**-32, 2.0**-63])


class Rays:
    """Lanes that fly from `start` to `distance`, through the passes of a scene with one volume."""

    def __init__(self, detector, medium=EMPTY):
        about = tp.Surface(tp.Sphere(radius=3.0), tp.Transparent(), inside=medium)
        scene = tp.Scene(LAMP, about, detector)
        self.machine = machine_of(program_of(compile_scene(scene, tp.Tracking(absorption="weighted"))))
        self.plan = self.machine.program.plan
        self.volume = self.plan.volumes[0]

    def walk(self, origins, flights, starts=0.0, ends=math.inf, weights=1.0, waits=False, sigma_a=0.0):
        """Sums by cell of all rays: weight times way [m], number of ways, absorbed weight."""
        bundle, count, size = empty_bundle(), len(origins), self.plan.space.size
        assert count <= LANES
        tallies = np.zeros((self.plan.rows, 4), np.int64)
        bundle["tallies"] = tallies.ctypes.data
        lanes = bundle[0]
        for name, column in zip("xyz", (np.asarray(origins, float) - self.plan.space.origin).T, strict=True):
            lanes[name][:count] = column / size
        for name, column in zip(("ux", "uy", "uz"), np.asarray(flights, float).T, strict=True):
            lanes[name][:count] = column
        values = {
            "start": starts / size,
            "distance": np.asarray(ends) / size,
            "weight": weights,
            "flies": not waits,
        }
        values |= {"sigma_a": sigma_a * size, "mfp": math.inf, "survival": 1.0}
        for name, value in values.items():
            lanes[name][:count] = value
        self.bundle = bundle
        for lane_pass, table in self.machine.program.steps:
            if lane_pass.function.__module__.endswith(("volumes", "volume_cells")):
                entry, handle, table = _ready(lane_pass, bundle, table)
                entry(handle, table, 0, count)
        row, cells = self.volume.row, self.volume.detector.volumes(self.volume.shape).size
        track = tallies[int(row["first"]) :][:cells]
        kept = tallies[int(row["kept"]) :][:cells, :2] @ WAY_UNITS if row["kept"] else np.zeros(cells)
        return track[:, :2] @ WAY_UNITS * self.volume.unit, track[:, 2], kept


def _ready(lane_pass, bundle, table):
    """A pass as it is called, by addresses or without compilation."""
    if config.DISABLE_JIT:
        return lane_pass.function, bundle.view(np.recarray)[0], table.reshape(1).view(np.recarray)[0]
    return PASS(lane_pass.entry), bundle.ctypes.data, table.ctypes.data


def exact_ways(origin, flight, start, end, edges):
    """Ways [m] through the voxels between edges along x, y, z: between all crossings in fractions."""
    o, u = [list(map(Fraction, map(float, vector))) for vector in (origin, flight)]
    cuts = {Fraction(start), Fraction(end)}
    for axis in range(3):
        if u[axis] != 0:
            cuts |= {(Fraction(e) - o[axis]) / u[axis] for e in edges[axis]}
    cuts = sorted(t for t in cuts if start <= t <= end)
    ways = np.zeros([len(e) - 1 for e in edges])
    for a, b in pairwise(cuts):
        place = [o[axis] + (a + b) / 2 * u[axis] for axis in range(3)]
        cell = [np.searchsorted(e, float(x), side="right") - 1 for e, x in zip(edges, place, strict=True)]
        cell = [len(e) - 2 if x == e[-1] else c for c, e, x in zip(cell, edges, place, strict=True)]
        if all(0 <= c < len(e) - 1 for c, e in zip(cell, edges, strict=True)):
            ways[tuple(cell)] += float(b - a)
    return ways


def random_rays(count, seed):
    """Rays to places in the middle of both shapes; some in planes across x, some along z.  Origins, flights, starts, ends."""
    rng = np.random.default_rng(seed)
    origins = rng.uniform(-0.8, 0.8, (count, 3))
    flights = rng.uniform(-0.12, 0.12, (count, 3)) - origins
    origins[: count // 8, 0], flights[: count // 8, 0] = rng.uniform(-0.4, 0.4, count // 8), 0.0
    origins[: count // 16, 1], flights[: count // 16, 1] = rng.uniform(-0.2, 0.2, count // 16), 0.0
    flights /= np.linalg.norm(flights, axis=1)[:, None]
    return origins, flights, rng.uniform(0.0, 0.5, count), rng.uniform(0.5, 2.0, count)


@pytest.mark.parametrize("cells", [None, (1, 1, 1), (7, 3, 5), (1, 64, 2)])
def test_ways_through_voxels_are_those_between_exact_crossings(cells):
    rays = Rays(tp.VolumeDetector(BOX, "box", cells))
    edges = [np.linspace(a, b, n + 1) for a, b, n in zip(*BOX.bounds, cells or (1, 1, 1), strict=True)]
    origins, flights, starts, ends = random_rays(64, 1)
    for origin, flight, start, end in zip(origins, flights, starts, ends, strict=True):
        found, _, _ = rays.walk([origin], [flight], start, end)
        exact = exact_ways(origin, flight, start, end, edges).ravel()
        np.testing.assert_allclose(found, exact, rtol=0, atol=4e-15)
    together, counts, _ = rays.walk(origins, flights, starts, ends)
    assert together.sum() > 10 and counts.sum() > 40
    # A walk that took the wrong cell, or lost a part, would be off by a way of about a cell.


@pytest.mark.parametrize("cells", [None, 1, 6, (0.1, 0.2, 0.20001, 0.5), (0.0, 0.3)])
def test_ways_through_shells_are_differences_of_chords(cells):
    rays = Rays(tp.VolumeDetector(BALL, "ball", cells))
    radii = rays.volume.detector.edges(BALL).get("r", np.array([0.0, 0.5]))
    origins, flights, starts, ends = random_rays(64, 2)
    for o, u, start, end in zip(origins, flights, starts, ends, strict=True):
        h, q2 = o @ u, o @ o - (o @ u) ** 2
        half = np.sqrt(np.maximum(radii**2 - q2, 0.0))
        inside = np.maximum(np.minimum(end + h, half) - np.maximum(start + h, -half), 0.0)
        found, _, _ = rays.walk([o], [u], start, end)
        np.testing.assert_allclose(found, np.diff(inside), rtol=0, atol=2e-14)


@pytest.mark.parametrize("shape", [BOX, BALL], ids=["box", "ball"])
def test_lanes_that_wait_or_have_ended_are_not_counted_again(shape):
    rays = Rays(tp.VolumeDetector(shape, "it", (2, 2, 2) if shape is BOX else (3,)))
    origins, flights, starts, ends = random_rays(64, 3)
    assert rays.walk(origins, flights, starts, ends)[0].sum() > 10
    for values in ({"waits": True}, {"weights": 0.0}):
        found, counts, _ = rays.walk(origins, flights, starts, ends, **values)
        assert (found == 0).all() and (counts == 0).all()


# ---- along faces, from faces, through corners ----


@pytest.mark.parametrize("cells", [None, (4, 4, 4)])
@pytest.mark.parametrize("x", [-0.5, -0.25, 0.0, 0.25, 0.5])
@pytest.mark.parametrize("y", [-0.25, 0.0, 0.25])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_way_along_faces_and_edges_counts_once(cells, x, y, sign):
    """Within the planes of voxels, and those of the box, along z: 0.25 m in all, with both signs of a zero."""
    rays = Rays(tp.VolumeDetector(BOX, "box", cells))
    for zero in (0.0, -0.0):
        found, counts, _ = rays.walk([(x, y, -0.7 * sign)], [(zero, zero, sign)])
        assert found.sum() == pytest.approx(0.25, rel=1e-14)
        assert counts.sum() == (1 if cells is None else 4)


@pytest.mark.parametrize("cells", [(1, 1, 1), (4, 4, 4), (5, 5, 5)])
def test_a_way_through_corners_of_voxels_is_whole(cells):
    """Along the diagonal of a cube all three faces are met at once; both ways, from outside and from the corner."""
    cube = tp.Box(size=1.0)
    rays = Rays(tp.VolumeDetector(cube, "cube", cells))
    diagonal = np.ones(3) / math.sqrt(3)
    for origin, flight in (
        ((-1, -1, -1), diagonal),
        ((-0.5, -0.5, -0.5), diagonal),
        ((0.5, 0.5, 0.5), -diagonal),
    ):
        found, _, _ = rays.walk([origin], [flight])
        assert found.sum() == pytest.approx(math.sqrt(3), rel=1e-14)
        ways = found.reshape(cells)
        on_it = ways[np.arange(cells[0]), np.arange(cells[0]), np.arange(cells[0])]
        assert on_it.sum() == pytest.approx(math.sqrt(3), rel=1e-14)


def test_rays_that_start_on_a_face_count_on_the_side_that_they_fly_to():
    rays = Rays(tp.VolumeDetector(BOX, "box", (4, 1, 1)))
    for x, ux, exact in (
        (-0.5, 1.0, [0.25] * 4), (-0.5, -1.0, [0] * 4), (0.5, -1.0, [0.25] * 4), (0.5, 1.0, [0] * 4),
        (0.0, 1.0, [0, 0, 0.25, 0.25]), (0.0, -1.0, [0.25, 0.25, 0, 0]),
    ):  # fmt: skip
        found, counts, _ = rays.walk([(x, 0.1, 0.1)], [(ux, 0.0, 0.0)])
        assert found == pytest.approx(exact, abs=1e-15)
        assert counts.tolist() == [way > 0 for way in exact]


def test_an_aimed_ray_begins_before_its_origin():
    """Its origin is its target; it starts at a negative distance of it."""
    rays = Rays(tp.VolumeDetector(BOX, "box", (2, 1, 1)))
    found, _, _ = rays.walk([(0.7, 0.0, 0.0)], [(1.0, 0.0, 0.0)], starts=-0.95, ends=0.0)
    assert found == pytest.approx([0.25, 0.5], abs=1e-15)


@pytest.mark.parametrize("radius", [0.1, 0.2, 0.4, 0.5])
@pytest.mark.parametrize("beyond", [0.0, 1e-16, -1e-16, 1e-9, -1e-9])
def test_a_tangent_ray_ends_and_is_whole(radius, beyond):
    """It touches the sphere of a boundary of shells: inside of it, on it or just outside."""
    rays = Rays(tp.VolumeDetector(BALL, "ball", 5))
    height = radius + beyond
    found, _, _ = rays.walk([(-0.9, height, 0.0)], [(1.0, 0.0, 0.0)])
    half = math.sqrt(max((0.5 - height) * (0.5 + height), 0.0))
    assert found.sum() == pytest.approx(2 * half, abs=1e-15)
    inner = found[: round(radius * 10)].sum()
    assert inner == pytest.approx(2 * math.sqrt(max((radius - height) * (radius + height), 0)), abs=4e-8)


def test_a_ray_through_the_centre_meets_each_shell_twice():
    rays = Rays(tp.VolumeDetector(BALL, "ball", 5))
    for start, exact in ((-0.9, [0.2] * 5), (0.0, [0.1] * 5), (-0.3, [0.2, 0.2, 0.2, 0.1, 0.1])):
        found, counts, _ = rays.walk([(start, 0.0, 0.0)], [(1.0, 0.0, 0.0)])
        assert found == pytest.approx(exact, abs=1e-15)
        assert counts.sum() == round(sum(exact) * 10) - (
            start < -0.5 or start == -0.3
        )  # the innermost at one go


# ---- absorption ----


@pytest.mark.parametrize("depth", [1e-300, 1e-12, 1e-9, 1e-3, 1.0, 30.0, 1e4])
@pytest.mark.parametrize("shape", [BOX, BALL], ids=["box", "ball"])
def test_fading_on_the_way_keeps_its_digits_from_thin_to_thick(shape, depth):
    """Of a ray along x, 1 m through all, from 0.5 m before: each cell against expm1 in double precision."""
    cells = (4, 1, 1) if shape is BOX else 2
    rays = Rays(tp.VolumeDetector(shape, "it", cells), FOG)
    found, _, kept = rays.walk([(-1.0, 0.0, 0.0)], [(1.0, 0.0, 0.0)], sigma_a=depth)
    places = np.linspace(0.5, 1.5, 5)
    exact = -np.exp(-depth * places[:-1]) * np.expm1(-depth * np.diff(places)) / depth
    exact = exact if shape is BOX else np.array([exact[1] + exact[2], exact[0] + exact[3]])
    tiny = 2.0**-62  # of what the sums resolve
    np.testing.assert_allclose(found, exact, rtol=1e-13, atol=tiny)
    np.testing.assert_allclose(kept, depth * exact, rtol=1e-13, atol=tiny)
    whole, _, _ = Rays(tp.VolumeDetector(shape, "it"), FOG).walk(
        [(-1.0, 0.0, 0.0)], [(1.0, 0.0, 0.0)], sigma_a=depth
    )
    assert whole[0] == pytest.approx(exact.sum(), rel=1e-13, abs=tiny)


# ---- any size, any place ----


@lru_cache
def moved(scale, offset):
    """What two volumes read in a fog, in any unit of length and at any place; back in metres."""

    def place(*p):
        return tuple(scale * (x + o) for x, o in zip(p, offset, strict=True))

    lamp = tp.Source(tp.Sphere(radius=scale, center=place(0, 0, 0)), tp.Lambertian(power=1.0), side="back")
    looks = [
        tp.VolumeDetector(tp.Box(size=0.5 * scale, center=place(0, 0.25, 0)), "box", (3, 2, 1)),
        tp.VolumeDetector(tp.Sphere(radius=0.5 * scale, center=place(0, 0, 0.25)), "ball", 3),
    ]
    medium = tp.Medium(absorption=0.3 / scale, scattering=1.0 / scale)
    scene = tp.Scene(lamp, [], looks, medium=medium)
    result = tp.simulate(scene, particles=2000, seed=1, tracking="weighted", progress=False)
    return {
        (name, quantity): getattr(result[name], quantity).value * scale**power
        for name in result
        for quantity, power in (("fluence_rate", 2), ("absorbed_power", 0))
    }


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1.5e11])
@pytest.mark.parametrize("offset", [(0.0, 0.0, 0.0), (3.0, -7.0, 5.0)])
def test_the_unit_and_the_origin_do_not_matter(scale, offset):
    for key, exact in moved(1.0, (0.0, 0.0, 0.0)).items():
        np.testing.assert_allclose(moved(scale, offset)[key], exact, rtol=1e-9)


def test_a_volume_as_small_as_a_billionth_of_the_scene_is_counted_rightly():
    """Two of them: one is where numbers are finest, the other is not."""
    tiny = 1e-9
    looks = [
        tp.VolumeDetector(tp.Box(size=tiny, center=center), name, (2, 1, 1))
        for name, center in (("at the origin", (0, 0, 0)), ("aside", (0.3, 0.4, 0.0)))
    ]
    for look in looks:
        aim = tp.Sphere(radius=tiny, center=look.shape.center)
        lamp = tp.Source(tp.Point(position=(0, 0, 0.9)), tp.Isotropic(intensity=1.0), aim=aim)
        result = tp.simulate(tp.Scene(lamp, [], looks), particles=20_000, seed=1, progress=False)
        found = result[look.name].fluence_rate.mean()
        exact = 1 / ((0.9**2) + look.shape.center[0] ** 2 + look.shape.center[1] ** 2)
        assert abs(found.value - exact) < 5 * found.error and found.relative_error < 0.02


def test_a_batch_that_scores_too_much_is_refused_before_a_sum_overflows(monkeypatch):
    """The guard is asked between bundles: as if 2^60 units had been added up."""
    from transport.engine import driver

    scene = tp.Scene(LAMP, [], tp.VolumeDetector(BOX, "box"))
    machine = machine_of(program_of(compile_scene(scene)))
    real = driver.drive

    def full(lanes, *rest):
        real(lanes, *rest)
        lanes["scored"] = driver.MOST_SCORED

    monkeypatch.setattr(driver, "drive", full)
    with pytest.raises(OverflowError, match="ask for more batches"):
        run_batch(machine, seed=1, batch=0, histories=100)
