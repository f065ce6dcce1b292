"""Volume detectors in cylinders: rings of equal steps of r and layers of z.

Beams are followed by hand through all rings; a kernel of its own, one photon at a time, judges what scatters.  All runs have seed 1;
each judgement fails right code in one of 10^5 seeds.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import pytest
from numba import njit

import transport as tp
from tests.agreement import assert_agrees
from tests.volume_scenes import ALL_ROUND, FALSE_ALARM, body, rejects, run, sphere, whole

ROD = tp.Cylinder(radius=0.6, height=1.4, center=(0.1, -0.2, 0.3), axis=(1.0, 2.0, 2.0))
DIM = tp.Medium(absorption=0.9)
BLOCK = tp.Box(size=8.0)
CELLS = (5, 7)


def rods(name="rod", shape=ROD, cells=CELLS, **more):
    return tp.VolumeDetector(shape, name, cells=cells, **more)


def ray_in_rings(shape, start, direction, cells, absorption=0.0, pieces=400_000):
    """Path in each ring of a ray of weight exp(-absorption x), by many short steps, and the length of a step."""
    start, direction, axis = (np.array(each, float) for each in (start, direction, shape.axis))
    direction /= np.linalg.norm(direction)
    reach = np.linalg.norm(start - shape.center) + shape.extent
    x = (np.arange(pieces) + 0.5) * reach / pieces
    away = start + x[:, None] * direction - shape.center
    z = away @ axis
    r = np.linalg.norm(away - z[:, None] * axis, axis=1)
    edges = tp.VolumeDetector(shape, "x", cells=cells).edges(shape)
    counts, _, _ = np.histogram2d(r, z, (edges["r"], edges["z"]), weights=np.exp(-absorption * x))
    return counts * reach / pieces, reach / pieces


def pencil(start, direction, width=1e-9):
    """A beam so narrow that all of it goes the same way."""
    return tp.Source(
        tp.Disk(center=start, normal=direction, radius=width), tp.Beam(direction, power=2.0), side="front"
    )


PENCILS = {
    "along the axis": ((0.1 - 1, -0.2 - 2, 0.3 - 2), (1, 2, 2)),
    "beside the axis": ((0.1 - 1 + 0.2, -0.2 - 2 - 0.1, 0.3 - 2), (1, 2, 2)),
    "through the axis": ((0.1 + 2, -0.2 - 1, 0.3), (-2, 1, 0)),
    "across": ((0.1 + 2, -0.2 - 1 + 0.2, 0.3 + 0.1), (-2, 1, 0)),
    "tilted": ((1.3, 0.7, -0.9), (-1.0, -0.65, 1.1)),
    "in by an end, out by the side": ((0.1 - 1, -0.2 - 2, 0.3 - 2), (1.25, 2, 2.1)),
    "beyond": ((1.3, 0.7, -0.9), (1.0, -0.65, 1.1)),
    "beyond, along the axis": ((0.1 - 1 + 0.8, -0.2 - 2 - 0.4, 0.3 - 2), (1, 2, 2)),
}


@pytest.mark.parametrize("way", PENCILS)
def test_a_pencil_beam_fades_ring_by_ring(way):
    """A(r, z) by hand: followed by weight no draw is made."""
    start, direction = PENCILS[way]
    detectors = [rods(), rods("one", cells=None)]
    scene = tp.Scene(pencil(start, direction), [body(BLOCK, DIM)], detectors)
    result = run(scene, 300, tracking="weighted")
    by_hand, step = ray_in_rings(ROD, start, direction, CELLS, 0.9)
    by_hand *= 2.0
    volumes = detectors[0].volumes(ROD)
    assert volumes.sum() == pytest.approx(ROD.volume, rel=1e-14)
    paths = result["rod"].fluence_rate.value * volumes
    np.testing.assert_allclose(paths, by_hand, rtol=1e-9, atol=2.0 * 2 * step)  # at entry and exit
    np.testing.assert_allclose(result["rod"].absorbed_power.value, 0.9 * paths, rtol=1e-12)
    np.testing.assert_allclose(result["rod"].absorbed_density.value, 0.9 * paths / volumes, rtol=1e-12)
    assert paths.sum() == pytest.approx(result["one"].fluence_rate.value * ROD.volume, rel=1e-12, abs=1e-30)
    assert (by_hand.sum() > 0) == ("beyond" not in way)


def test_paths_through_rings_are_exact():
    """Square roots by hand: a ray at a distance of 0.2 from the axis of a rod of radius 0.6, aligned with the world's axes."""
    rod = tp.Cylinder(radius=0.6, height=1.4)
    scene = tp.Scene(pencil((-2, 0.2, 0.1), (1, 0, 0), 1e-14), [], [rods(shape=rod, cells=(4, 2))])
    half = [math.sqrt(max(r * r - 0.04, 0.0)) for r in (0.0, 0.15, 0.3, 0.45, 0.6)]
    paths = run(scene, 300)["rod"].fluence_rate.value * scene.volumes[0].volumes(rod) / 2.0
    assert paths[:, 0].tolist() == [0] * 4
    np.testing.assert_allclose(paths[:, 1], 2 * np.diff(half), rtol=1e-12, atol=1e-30)


@pytest.mark.parametrize("offset", [0.0, 0.2, 0.9])
def test_a_ray_along_the_axis_stays_in_its_ring(offset):
    """Its sine to the axis is 0: it meets no ring, and beyond the radius nothing."""
    rod = tp.Cylinder(radius=0.6, height=1.4)
    scene = tp.Scene(pencil((offset, 0, -2), (0, 0, 1), 1e-14), [], [rods(shape=rod, cells=(4, 2))])
    paths = run(scene, 300)["rod"].fluence_rate.value * scene.volumes[0].volumes(rod) / 2.0
    exact = np.zeros((4, 2))
    exact[[0.0, 0.2].index(offset) if offset < 0.6 else [], :] = 0.7
    np.testing.assert_allclose(paths, exact, rtol=1e-12)


@pytest.mark.parametrize("offset", [0.15, 0.6])
def test_a_ray_that_touches_a_ring_goes_on_and_leaves_nothing_in_it(offset):
    """Tangent to the first ring's edge, and to the whole: no path within."""
    rod = tp.Cylinder(radius=0.6, height=1.4)
    scene = tp.Scene(pencil((-2, offset, 0.1), (1, 0, 0), 1e-14), [], [rods(shape=rod, cells=(4, 2))])
    paths = run(scene, 300)["rod"].fluence_rate.value * scene.volumes[0].volumes(rod) / 2.0
    assert paths[0].sum() < 1e-6
    assert paths.sum() == pytest.approx(2 * math.sqrt(0.36 - offset**2), rel=1e-12, abs=1e-6)


@pytest.mark.parametrize("estimator", ["track", "collision"])
def test_light_all_round_is_the_same_in_all_rings(estimator):
    """Radiance 1 from all sides: 4 pi in each ring, in vacuum and where a medium only scatters."""
    surfaces = [] if estimator == "track" else [body(tp.Sphere(radius=1.5), tp.Medium(scattering=2.0))]
    more = {"estimator": estimator, "directions": sphere(2, 3)}
    scene = tp.Scene(ALL_ROUND, surfaces, [rods(cells=(3, 2), **more), rods("one", cells=None)])
    result = run(scene, 200_000)
    assert_agrees(result["rod"].fluence_rate, 4 * math.pi, FALSE_ALARM)
    assert_agrees(result["rod"].radiance, 1.0, FALSE_ALARM)
    assert_agrees(result["one"].fluence_rate, 4 * math.pi, FALSE_ALARM)
    rejects(result["one"].fluence_rate, 4 * math.pi * 1.08)
    rejects(result["rod"].fluence_rate * np.array([[1.0], [3.0], [5.0]]) / 3, 4 * math.pi)  # areas all alike


@njit
def photons(number, random, absorption, scattering, g, radius, height, rings, layers):
    """Absorbed share by ring and layer of photons down the axis of an endless fog, one at a time."""
    found = np.zeros((rings, layers))
    for _ in range(number):
        x, y, z, ux, uy, uz = 0.0, 0.0, -height, 0.0, 0.0, 1.0
        alive = True
        while alive:
            step = -math.log(1.0 - random.random()) / (absorption + scattering)
            x, y, z = x + step * ux, y + step * uy, z + step * uz
            if random.random() * (absorption + scattering) < absorption:
                ring, layer = (
                    int(math.sqrt(x * x + y * y) / radius * rings),
                    math.floor((z / height + 0.5) * layers),
                )
                if ring < rings and 0 <= layer < layers:
                    found[ring, int(layer)] += 1.0 / number
                alive = False
            mu = (1 + g * g - ((1 - g * g) / (1 - g + 2 * g * random.random())) ** 2) / (2 * g)
            turn, sine = 2 * math.pi * random.random(), math.sqrt(1 - mu * mu)
            s = math.sqrt(max(1 - uz * uz, 1e-30))
            cosine, across = math.cos(turn), math.sin(turn)
            if s > 1e-10:
                vx = sine * (ux * uz * cosine - uy * across) / s + ux * mu
                vy = sine * (uy * uz * cosine + ux * across) / s + uy * mu
                vz = -sine * cosine * s + uz * mu
            else:
                vx, vy, vz = sine * cosine, sine * across, mu * uz
            ux, uy, uz = vx, vy, vz
    return found


@lru_cache
def fog():
    """A beam down the axis of a rod in an endless fog, from one height below its middle."""
    rod = tp.Cylinder(radius=1.2, height=2.0)
    detectors = [rods(shape=rod, cells=(3, 4)), rods("hits", rod, (3, 4), estimator="collision")]
    detectors += [rods("one", rod, None), tp.VolumeDetector(tp.Box(size=2.4), "box", cells=(1, 1, 1))]
    medium = tp.Medium(absorption=0.5, scattering=1.5, phase=tp.HenyeyGreenstein(0.6))
    source = tp.Source(tp.Point(position=(0, 0, -2.0)), tp.Beam((0, 0, 1), power=1.0))
    return run(tp.Scene(source, [], detectors, medium=medium), 200_000)


@pytest.mark.parametrize("name", ["rod", "hits"])
def test_what_rings_in_fog_absorb_agrees_with_photons_followed_one_at_a_time(name):
    """Two independent runs: their difference in units of both errors, in twelve cells."""
    number, power = 400_000, fog()[name].absorbed_power
    judged = photons(number, np.random.default_rng(5), 0.5, 1.5, 0.6, 1.2, 2.0, 3, 4)
    error = np.hypot(power.error, np.sqrt(judged * (1 - judged) / number))
    assert np.abs((power.value - judged) / error).max() < 5
    assert np.abs((power.value * 1.1 - judged) / error).max() > 5


def test_the_rings_add_up_to_the_whole():
    result = fog()
    volumes = result["rod"].volumes
    one = result["one"].fluence_rate
    assert whole(result["rod"].fluence_rate, volumes).value == pytest.approx(one.value, rel=1e-12)
    assert result["rod"].absorbed_power.sum().value == pytest.approx(
        result["one"].absorbed_power.value, rel=1e-12
    )
    assert result["rod"].fluence_rate.dims == ("r", "z")
    assert result["rod"].absorbed_power.sum().value < result["box"].absorbed_power.sum().value


@pytest.mark.parametrize("unit", [1e-6, 149_597_870_700.0])
def test_digits_do_not_depend_on_the_unit_of_length(unit):
    """The scene of `fog` shrunk and grown: powers of two or not, the same digits to rounding."""

    def scene(unit):
        rod = tp.Cylinder(radius=0.6 * unit, height=1.4 * unit, axis=(1, 2, 2))
        medium = tp.Medium(absorption=0.5 / unit, scattering=1.5 / unit)
        source = tp.Source(tp.Point(position=(0.1 * unit, 0, -unit)), tp.Isotropic(power=1.0))
        return tp.Scene(source, [], [rods(shape=rod)], medium=medium)

    here, there = (
        run(scene(each), 20_000, tracking="weighted")["rod"].absorbed_power.value for each in (1.0, unit)
    )
    np.testing.assert_allclose(there, here, rtol=1e-9)


@pytest.mark.parametrize("radius", [1.2, 0.7])
def test_a_rod_absorbs_nothing_where_it_lies_in_a_clear_ball(radius):
    """A ball of 1.2 m holds the rod, so that nothing within absorbs; out of one of 0.7 m its ends reach into what does."""
    clear = body(tp.Sphere(center=ROD.center, radius=radius), tp.Medium(scattering=1.0))
    scene = tp.Scene(ALL_ROUND, [clear], [rods("one", cells=None)], medium=DIM)
    power = run(scene, 20_000, tracking="weighted")["one"].absorbed_power
    assert (power.value > 0) == (radius < ROD.extent)
    assert power.exact == (radius > ROD.extent)


def test_cells_must_fit_a_cylinder():
    for cells in (5, (3,), (3, 4, 5), (0, 3), (2.5, 3), (0.1, 0.2)):
        with pytest.raises(tp.SceneError, match=r"two whole numbers for a Cylinder.*write cells=\(nr, nz\)"):
            rods(cells=cells)
    with pytest.raises(tp.SceneError, match="shape must be a Box, a Sphere or a Cylinder, got a Cone"):
        rods(shape=tp.Cone(radius=1.0, height=1.0))


def test_rings_in_files(tmp_path):
    xarray = pytest.importorskip("xarray")
    result = fog()
    data = result["rod"].fluence_rate.to_xarray()
    assert isinstance(data, (xarray.DataArray, xarray.Dataset)) and tuple(data.sizes) == ("r", "z")
    scene = tp.Scene.from_json(result.scene.to_json())
    assert scene == result.scene
    result.save(tmp_path / "rod.nc")
    again = tp.load(tmp_path / "rod.nc")["rod"].fluence_rate
    assert again.value.tobytes() == result["rod"].fluence_rate.value.tobytes() and again.dims == ("r", "z")
