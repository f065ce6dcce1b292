"""Volume detectors in boxes, balls and cylinders: fluence rate, radiance and absorbed power agree with integrals, ledger and other trackings.

What holds for every flight is asked to rounding.  All runs have seed 1; each judgement fails right code in one of 10^5 seeds.
"""

from __future__ import annotations

import math
from fractions import Fraction
from functools import lru_cache

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.slow import quick
from transport.compile.compiler import compile_scene
from transport.engine.bundle import empty_bundle
from transport.engine.driver import compile_program, run_batch
from transport.engine.passes.volumes import SCORE_BOUND
from transport.engine.program import build_program

FALSE_ALARM = 1e-5
BOX = tp.Box(size=(1.0, 2.0, 0.5), center=(0.1, 0.0, 0.3))
BALL = tp.Sphere(radius=0.8, center=(0.0, 0.2, 0.0))
ALL_ROUND = tp.Source(tp.Sphere(radius=2.0), tp.Lambertian(radiance=1.0), side="back")  # L = 1 within
M, VACUUM, CLEAR = tp.Medium, tp.Vacuum(), tp.Transparent()
FOG = M(absorption=0.7, scattering=2.0, phase=tp.HenyeyGreenstein(0.5))
sphere, Volume = tp.Directions.sphere, tp.VolumeDetector


def run(sources, detectors, surfaces=(), particles=100_000, tracking=None, **scene):
    scene = tp.Scene(sources, surfaces, detectors, **scene)
    return tp.simulate(scene, particles=particles, seed=1, threads=1, progress=False, tracking=tracking)


def body(shape, medium, name="body"):
    return tp.Surface(shape, CLEAR, name, inside=medium)


def whole(cells, volumes):
    """The mean over all cells."""
    return (cells * volumes).sum() / np.sum(volumes)


def rejects(estimate, wrong):
    with pytest.raises(AssertionError):
        assert_agrees(estimate, wrong, FALSE_ALARM)


# ---- without media ----


@lru_cache
def lit():
    """All kinds of cells in a field of radiance 1."""
    oblique = sphere(mu=(-0.5, 0.1, 0.9), phi=(-1, 2), axis=(1, 2, 0))
    looks = [
        Volume(BOX, "box"),
        Volume(BOX, "voxels", (3, 4, 2)),
        Volume(BALL, "ball"),
        Volume(BALL, "shells", (4,)),
        Volume(BALL, "hollow", (0.3, 0.31, 0.7)),
        Volume(BOX, "directions", None, sphere(4, 3)),
        Volume(BOX, "cells and directions", (1, 2, 1), oblique),
        Volume(BALL, "azimuth", (2,), sphere(mu=None, phi=4)),
    ]
    return run(ALL_ROUND, looks, particles=400_000)


def test_in_a_uniform_field_the_fluence_rate_is_4_pi_radiance_in_each_cell():
    for reading in map(lit().__getitem__, lit()):
        assert_agrees(reading.fluence_rate, 4 * math.pi, FALSE_ALARM)
        if reading.detector.directions is not None:
            assert_agrees(reading.radiance, 1.0, FALSE_ALARM)
            rejects(reading.radiance, 1.2)
    pairs = {"voxels": "box", "shells": "ball", "directions": "box", "cells and directions": "box"}
    for part, all_of_it in pairs.items():
        found = whole(lit()[part].fluence_rate.value, lit()[part].volumes)
        assert found == pytest.approx(lit()[all_of_it].fluence_rate.value, rel=1e-13)


def test_radiance_over_all_directions_is_the_fluence_rate():
    reading, some = lit()["directions"], lit()["cells and directions"]
    angles = reading.detector.directions.solid_angles()
    assert angles.sum() == pytest.approx(4 * math.pi, rel=1e-15)
    assert (reading.radiance.value * angles).sum() == pytest.approx(reading.fluence_rate.value, rel=1e-13)
    part = (some.radiance.value * some.detector.directions.solid_angles()).sum(axis=(-2, -1))
    assert (part < some.fluence_rate.value * 0.5).all()


@pytest.mark.parametrize("axis", [(0, 0, 1), (1, 0, 0), (0, 1, 0), (1, -2, 3)])
def test_radiance_is_binned_by_the_direction_of_flight(axis):
    """A beam in known bins of cosine and azimuth."""
    flight = np.array((-0.48, 0.64, 0.6))
    disk = tp.Disk(radius=0.1, center=tuple(-3 * flight), normal=tuple(flight))
    looks = Volume(BOX, "box", None, sphere(9, 12, axis))
    reading = run(tp.Source(disk, tp.Beam(flight, power=1.0)), looks, particles=1000)["box"]
    e_w = np.array(axis) / np.linalg.norm(axis)
    up = np.array((0, 0, 1.0)) if axis == (0, 1, 0) else np.array((0, 1.0, 0))
    e_v = up - (up @ e_w) * e_w
    e_u = np.cross(e_v, e_w)
    e_v, e_u = e_v / np.linalg.norm(e_v), e_u / np.linalg.norm(e_u)
    turn = math.atan2(flight @ e_v, flight @ e_u) % (2 * math.pi)
    expected = int((flight @ e_w + 1) * 4.5), int(turn / (2 * math.pi) * 12)
    assert [tuple(map(int, place)) for place in np.argwhere(reading.radiance.value > 0)] == [expected]
    value = reading.radiance.value[expected] * (2 / 9 * math.pi / 6)
    assert value == pytest.approx(reading.fluence_rate.value, rel=1e-13)


def test_shells_have_the_volumes_between_their_spheres():
    """Exact where a difference of cubes would keep eight digits of a thin shell."""
    radii = (0.0, 1e-9, 0.1, 0.1 + 1e-9, 0.7, 0.8)
    cubes = [Fraction(r) ** 3 for r in radii]
    exact = [4 / 3 * math.pi * float(b - a) for a, b in zip(cubes, cubes[1:], strict=False)]
    np.testing.assert_allclose(Volume(BALL, "ball", radii).volumes(BALL), exact, rtol=1e-14)
    assert Volume(BALL, "ball", 7).volumes(BALL).sum() == pytest.approx(BALL.volume, rel=1e-15)
    np.testing.assert_allclose(Volume(BOX, "box", (2, 3, 4)).volumes(BOX), 1 / 24, rtol=1e-15)


@pytest.mark.parametrize("shape", [tp.Box(size=1.2), tp.Sphere(radius=0.6)])
def test_a_flight_that_begins_within_counts_from_where_it_begins(shape):
    """A beam of 1 W from 0.1 m beyond the middle: 0.5 m to the side, over the volume."""
    beam = tp.Source(tp.Point(position=(0.1, 0, 0)), tp.Beam((1, 0, 0), power=1.0))
    found = run(beam, Volume(shape, "volume"), particles=100)["volume"].fluence_rate
    assert found.value == pytest.approx(0.5 / shape.volume, rel=1e-12)


# ---- in media ----

DEEP, SIGMA = tp.Box(size=(1.0, 1.0, 2.0)), 1.3
DOWN = tp.Source(tp.Rectangle(width=1.0, height=1.0, center=(0, 0, -1.5)), tp.Beam((0, 0, 1), power=2.0))


def faded(edges):
    """Mean of exp(-SIGMA z) between depths."""
    return np.diff(-np.exp(-SIGMA * np.asarray(edges))) / SIGMA / np.diff(edges)


def test_a_beam_fades_in_each_cell_by_the_exact_integral():
    """Followed by weight no draw is made: every digit is right.  The power of 2 W falls on 1 m^2."""
    looks = [
        Volume("body", "all"),
        Volume(DEEP, "cells", (1, 1, 4)),
        Volume(tp.Box(size=(0.5, 0.5, 1.0)), "inner", (2, 2, 5)),
        Volume(tp.Box(center=(0, 0, 0.4), size=(1.0, 1.0, 0.6)), "deep down"),
    ]
    result = run(DOWN, looks, body(DEEP, M(absorption=SIGMA)), 2000, tracking="weighted")
    assert result["all"].fluence_rate.value == pytest.approx(2.0 * faded([0, 2])[0], rel=1e-13)
    assert result["deep down"].fluence_rate.value == pytest.approx(2.0 * faded([1.1, 1.7])[0], rel=1e-13)
    cells, exact = result["cells"], 2.0 * faded(np.linspace(0, 2, 5))
    np.testing.assert_allclose(cells.fluence_rate.value[0, 0], exact, rtol=1e-13)
    np.testing.assert_allclose(cells.absorbed_power.value[0, 0], exact * SIGMA * 0.5, rtol=1e-13)
    np.testing.assert_allclose(cells.absorbed_density.value[0, 0], exact * SIGMA, rtol=1e-13)
    inner = result["inner"].fluence_rate.sum(("x", "y")) * 0.25
    for k, exact in enumerate(2.0 * faded(np.linspace(0.5, 1.5, 6))):  # a quarter of the beam, at random
        assert_agrees(inner[k], exact, FALSE_ALARM)


def test_a_beam_that_is_absorbed_by_chance_fades_by_the_integral():
    looks = [Volume("body", "all"), Volume("body", "cells", (1, 1, 4))]
    looks += [Volume("body", "hits", (1, 1, 4), estimator="collision")]
    result = run(DOWN, looks, body(DEEP, M(absorption=SIGMA)), tracking="analog")
    exact = 2.0 * faded(np.linspace(0, 2, 5))
    assert_agrees(result["all"].fluence_rate, 2.0 * faded([0, 2])[0], FALSE_ALARM)
    for name in ("cells", "hits"):
        assert_agrees(result[name].fluence_rate[0, 0], exact, FALSE_ALARM)
        assert_agrees(result[name].absorbed_power[0, 0], exact * SIGMA * 0.5, FALSE_ALARM)
    rejects(result["cells"].fluence_rate[0, 0], np.full(4, 2.0))  # absorption left out
    hits = result["hits"].absorbed_power.sum()  # each collision is an absorption, of the ledger as well
    assert hits.value == pytest.approx(result.ledger["absorbed"].value, rel=1e-12)


PHASES = {"isotropic": tp.Isotropic(), "forwards": tp.HenyeyGreenstein(0.9), "rayleigh": tp.Rayleigh()}


@pytest.mark.parametrize("phase", quick(PHASES, "forwards"))
def test_a_ball_that_only_scatters_leaves_a_uniform_field_as_it_is(phase):
    """Radiance is conserved: 1 in all directions, inside as outside (Kirchhoff)."""
    cells = {"whole": ("body", None, None), "shells": ("body", (0.2, 0.5, 0.8), None)}
    cells["voxels"] = (tp.Box(size=0.6), (2, 2, 2), sphere(2, 2))
    looks = [
        Volume(shape, f"{estimator} {name}", part, directions, estimator)
        for name, (shape, part, directions) in cells.items()
        for estimator in ("track", "collision")
    ]
    result = run(ALL_ROUND, looks, body(BALL, M(scattering=3.0, phase=PHASES[phase])), particles=200_000)
    for reading in map(result.__getitem__, result):
        assert_agrees(reading.fluence_rate, 4 * math.pi, FALSE_ALARM)
        if reading.detector.directions is not None:
            assert_agrees(reading.radiance, 1.0, FALSE_ALARM)
    rejects(result["track whole"].fluence_rate, 4 * math.pi * 1.06)
    for name in cells:
        track, hits = (result[f"{each} {name}"].fluence_rate for each in ("track", "collision"))
        assert_agrees(track - hits, 0.0, FALSE_ALARM)


TRACKINGS = {
    "analog": "analog",
    "weighted": "weighted",
    "forced": tp.Tracking(forced=True),
    "split": tp.Tracking(splitting=tp.Splitting(start=(0, 0, -1), end=(0, 0, 1), gain=10.0)),
}


@lru_cache
def foggy(tracking):
    looks = [
        Volume("body", "track"),
        Volume("body", "hits", estimator="collision"),
        Volume("body", "shells", (5,)),
        Volume(tp.Box(size=2.2), "voxels about it", (3, 4, 5)),
        Volume("body", "directions", (2,), sphere(2, 3)),
    ]
    return run(ALL_ROUND, looks, body(BALL, FOG), tracking=TRACKINGS[tracking])


@pytest.mark.parametrize("tracking", TRACKINGS)
def test_a_volume_absorbs_as_much_as_the_ledger_however_histories_are_followed(tracking):
    result, weighted = foggy(tracking), foggy("weighted")
    absorbed, powers = result.ledger["absorbed"], {name: result[name].absorbed_power for name in result}
    totals = {name: power if name in ("track", "hits") else power.sum() for name, power in powers.items()}
    for name, power in totals.items():
        rejects(power - absorbed * 1.1, 0.0)
        if tracking == "analog" or name == "hits":
            assert_agrees(power - absorbed, 0.0, FALSE_ALARM)
        else:  # flight by flight, to rounding
            assert power.value == pytest.approx(absorbed.value, rel=1e-12)
    for name in ("shells", "voxels about it", "directions"):
        assert totals[name].value == pytest.approx(totals["track"].value, rel=1e-12)
    rate = result["track"].fluence_rate.value
    assert totals["track"].value == pytest.approx(0.7 * rate * BALL.volume, rel=1e-12)
    for name in ("track", "hits", "shells", "voxels about it"):
        one, other = (each[name].fluence_rate for each in (result, weighted))
        assert np.abs((one.value - other.value) / np.hypot(one.error, other.error)).max() < 5


@pytest.mark.parametrize("scatters", [False, True], ids=["absorbing", "scattering"])
@pytest.mark.parametrize("tracking", ["analog", "weighted"])
def test_in_a_grid_each_cell_absorbs_by_the_voxels_on_the_way(tracking, scatters):
    rng = np.random.default_rng(1)
    box, shape = tp.Box(size=(1.0, 1.2, 0.9)), (3, 4, 2)
    absorption, scattering = rng.uniform(0.1, 3, shape), rng.uniform(0.2, 4, shape) * scatters
    grid = tp.Grid(box=box, absorption=absorption, scattering=scattering)
    looks = [
        Volume("body", "all"),
        Volume("body", "same", shape),
        Volume("body", "other", (5, 3, 4)),
        Volume(tp.Box(size=1.5), "about it", (2, 2, 2)),
        Volume(tp.Sphere(radius=0.4), "ball", (3,)),
    ]
    looks += [Volume("body", "hits", (5, 3, 4), estimator="collision")] * scatters
    result = run(ALL_ROUND, looks, body(box, grid), tracking=tracking)
    same, total, rate = result["same"], result["all"].absorbed_power, result["all"].fluence_rate.value
    np.testing.assert_allclose(
        same.absorbed_power.value, absorption * same.fluence_rate.value * same.volumes, rtol=1e-12
    )
    for name in ("same", "other", "about it"):
        assert result[name].absorbed_power.sum().value == pytest.approx(total.value, rel=1e-12)
    for name in ("same", "other"):
        assert whole(result[name].fluence_rate.value, result[name].volumes) == pytest.approx(rate, rel=1e-12)
    if tracking == "weighted" and not scatters:
        assert total.value == pytest.approx(result.ledger["absorbed"].value, rel=1e-12)
    else:
        assert_agrees(total - result.ledger["absorbed"], 0.0, FALSE_ALARM)
    for quantity in ("fluence_rate", "absorbed_power") if scatters else ():
        one, other = (getattr(result[name], quantity) for name in ("other", "hits"))
        assert_agrees(one - other, 0.0, FALSE_ALARM)


LAYER_SIGMA = np.array([0.3, 1.1, 0.2, 2.0, 0.7])  # [m^-1], of layers 1 m thick about the origin
FACES = np.arange(6) - 2.5


def along(axis, length, width):
    """A vector of the length along one axis, of the width along the others."""
    return tuple(length if k == axis else width for k in range(3))


def layered(axis, scattering=0.0):
    """Voxels in five layers across an axis: numbers of voxels that differ on all axes tell these apart."""
    sigma = LAYER_SIGMA.reshape(along(axis, 5, 1))
    return tp.Grid(box=tp.Box(size=along(axis, 5.0, 3.0)), absorption=sigma, scattering=scattering * sigma)


def faded_in(sigma, edges):
    """Of a beam of 1 W that enters at -2.5: the integrals of its power between edges, each in some layers."""
    places = np.union1d(FACES, edges)
    here = sigma[np.clip(np.floor((places[1:] + places[:-1]) / 2 + 2.5).astype(int), 0, 4)]
    left = np.exp(-np.concatenate([[0.0], np.cumsum(here * np.diff(places))]))
    integral = np.concatenate([[0.0], np.cumsum(-np.diff(left) / here)])
    return np.diff(integral[np.searchsorted(places, edges)])


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("filling", ["voxels", "medium"])
def test_a_beam_fades_on_its_way_to_a_volume_and_in_the_hollow_of_one(filling, axis):
    """With weighted tracking every digit is right: volumes begin within a layer, and behind a hollow."""
    sigma = LAYER_SIGMA if filling == "voxels" else np.full(5, SIGMA)
    grid, radii = layered(axis), (0.4, 0.9, 1.3)
    looks = [
        Volume(tp.Box(center=along(axis, 1.1, 0.0), size=along(axis, 1.4, 0.5)), "deep"),
        Volume(tp.Box(size=along(axis, 3.2, 0.5)), "cells", along(axis, 7, 1)),
        Volume(tp.Sphere(radius=radii[-1]), "shells", radii),
    ]
    beam = tp.Source(tp.Point(position=along(axis, -3.0, 0.0)), tp.Beam(along(axis, 1, 0), power=1.0))
    medium = grid if filling == "voxels" else M(absorption=SIGMA)
    result = run(beam, looks, body(grid.box, medium), 100, tracking="weighted")
    found = {name: np.ravel((result[name].fluence_rate * result[name].volumes).value) for name in result}
    np.testing.assert_allclose(found["deep"], faded_in(sigma, np.array([0.4, 1.8])), rtol=1e-12)
    np.testing.assert_allclose(found["cells"], faded_in(sigma, np.linspace(-1.6, 1.6, 8)), rtol=1e-12)
    before, after = (faded_in(sigma, np.sort(sign * np.array(radii))) for sign in (-1, 1))
    np.testing.assert_allclose(found["shells"], before[::-1] + after, rtol=1e-12)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_collisions_in_layers_of_voxels_absorb_as_much_as_tracks(axis):
    """Each collision uses the coefficients of its own voxel, along whichever axis they change."""
    looks = [Volume("body", name, along(axis, 5, 1), estimator=name) for name in ("track", "collision")]
    grid = layered(axis, scattering=1.5)
    lamp = tp.Source(grid.box, tp.Lambertian(power=1.0), side="back")
    result = run(lamp, looks, body(grid.box, grid), 50_000, tracking="weighted")
    for quantity in ("fluence_rate", "absorbed_power"):
        tracks, hits = (getattr(result[look.name], quantity) for look in looks)
        assert_agrees(hits - tracks, 0.0, FALSE_ALARM)
        rejects(hits - tracks + tracks * 0.05, 0.0)


# ---- clear media beside media that absorb ----

DARK, MILK = M(absorption=1.0, scattering=2.0), M(scattering=7.0)
ABOVE = tp.Source(tp.Disk(center=(0, 0, 1.5), normal=(0, 0, -1), radius=0.6), tp.Lambertian(power=1.0))
OUTER = body(tp.Sphere(radius=1.0), DARK, "outer")
DROP = body(tp.Sphere(center=(0.2, 0.1, 0), radius=0.35), MILK, "ball")
BRICK = body(tp.Box(center=(-0.4, -0.2, 0.1), size=(0.3, 0.4, 0.5)), MILK, "box")


def absorbed(looks, surfaces, **scene):
    return run(ABOVE, looks, surfaces, 50_000, **scene)[looks.name].absorbed_power.value


@pytest.mark.parametrize("tracking", ["weighted", "analog"])
def test_bodies_that_only_scatter_absorb_exactly_nothing(tracking):
    """Rounding alone would leave 1e-18 W with an error of a fiftieth of that."""
    looks = [
        Volume("ball", "whole"),
        Volume("ball", "shells", cells=3),
        Volume("box", "brick"),
        Volume("box", "voxels", cells=(2, 1, 2)),
        Volume(tp.Box(center=(0.2, 0.1, 0), size=0.3), "within"),
        Volume("box", "struck", estimator="collision"),
    ]
    result = run(ABOVE, looks, [OUTER, DROP, BRICK], 50_000, tracking=tracking)
    for reading in map(result.__getitem__, result):
        for quantity in (reading.absorbed_power, reading.absorbed_density):
            assert np.all(quantity.value == 0) and np.all(quantity.error == 0)
        assert np.all(reading.fluence_rate.value > 0)


def test_cells_that_only_scatter_absorb_nothing_beside_cells_that_do():
    """Cells end where the medium does: of a box of boxes, of shells about a core, of voxels of a Grid."""
    halves = [
        body(tp.Box(center=(0, 0, z), size=(1, 1, 0.5)), medium, name)
        for z, medium, name in ((0.25, MILK, "upper"), (-0.25, DARK, "lower"))
    ]
    layers = absorbed(Volume(tp.Box(size=1.0), "box", (2, 1, 2)), halves)
    assert (layers[..., 1] == 0).all() and (layers[..., 0] > 1e-3).all()
    core = [body(tp.Sphere(radius=0.9), MILK, "shell"), body(tp.Sphere(radius=0.4), DARK, "core")]
    shells = absorbed(Volume("shell", "shells", (0, 0.4, 0.9)), core)
    assert shells[0] > 1e-3 and shells[1] == 0
    voxels = np.zeros((3, 2, 4))
    voxels[1] = 2.0
    grid = tp.Grid(box=tp.Box(size=1.0), absorption=voxels, scattering=1.0)
    found = absorbed(Volume(grid.box, "cells", (3, 2, 4)), body(grid.box, grid, "grid"))
    assert (found[[0, 2]] == 0).all() and (found[1] > 1e-5).all()
    mesh = body(tp.Mesh.sphere(radius=0.5, triangles=320), DARK, "mesh")  # wherever in its box it may lie
    assert absorbed(Volume(tp.Box(size=0.4), "in it"), [mesh]) > 1e-3


def test_a_medium_that_absorbs_a_little_is_not_taken_for_clear():
    """A billionth of what its neighbour absorbs, in the body, in a cell that holds a part of it, and all around."""
    faint = body(DROP.shape, M(absorption=1e-9, scattering=7.0), "ball")
    looks = [Volume("ball", "ball"), Volume("ball", "shells", 2)]
    result = run(ABOVE, looks, [OUTER, faint, BRICK], 50_000)
    for reading in map(result.__getitem__, result):
        expected = 1e-9 * reading.fluence_rate.value * reading.volumes
        np.testing.assert_allclose(reading.absorbed_power.value, expected, rtol=1e-6)
    speck = body(tp.Sphere(center=(0.2, 0.1, 0.3), radius=1e-3), M(absorption=5.0), "speck")
    half = Volume(tp.Box(center=(-0.4, -0.2, 0.1), size=(0.3, 0.4, 0.51)), "half")
    around = Volume("ball", "ball"), Volume("box", "box"), half
    result = run(ABOVE, around, [DROP, BRICK, speck], 50_000, medium=M(absorption=0.1))
    assert 0 < result["ball"].absorbed_power.value < 1e-4
    assert result["box"].absorbed_power.value == 0 and result["half"].absorbed_power.value > 1e-6


def test_no_finding_counts_against_an_exact_zero():
    """Geometry proves that nothing is absorbed in the clear half of a cloud."""
    absorption = np.zeros((4, 4, 4))
    absorption[:, :, 3:] = 1.0
    cloud = tp.Grid(box=tp.Box(size=2.0), absorption=absorption, scattering=np.full((4, 4, 4), 0.5))
    lamp = tp.Source(tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=0.8), tp.Lambertian(power=1.0))
    below = Volume(tp.Box(center=(0, 0, -0.4), size=0.5), "below")
    power = run(lamp, below, body(cloud.box, cloud), 2e4, tracking="weighted")["below"].absorbed_power
    assert power.exact and power.verdict == "sound" and power.interval() == (0.0, 0.0)


# ---- how flights are counted ----


@pytest.mark.parametrize("speeds", [(2.0,), (2.0, 0.5, 0.0)])
def test_a_gas_at_rest_as_a_whole_has_the_fluence_rate_n_v(speeds):
    sources = [tp.Source(tp.Box(size=4.4), tp.Gas(10.0, speed)) for speed in speeds]
    looks = [Volume(tp.Box(size=2.4), "box"), Volume(BALL, "ball", (3,))]
    result = run(sources, looks, particles=400_000, duration=0.5)
    flow = 10.0 * sum(speeds)
    assert_agrees(result["box"].fluence_rate, flow, FALSE_ALARM)
    assert_agrees(result["box"].fluence, flow * 0.5, FALSE_ALARM)
    assert_agrees(result["ball"].fluence_rate, flow, FALSE_ALARM)
    assert "s^-1" in str(result["box"].fluence_rate.unit)
    rejects(result["box"].fluence_rate, flow * 1.05)


def test_a_flash_is_counted_as_far_as_it_comes_before_the_clock_stops():
    """Light of 2 J on 1 m^2, slower in the medium by its index, from its face on."""
    index, way = 1.5, 0.8
    face = tp.Rectangle(width=1.0, height=1.0, center=(0, 0, -1.0))
    flash = tp.Source(face, tp.Beam((0, 0, 1), energy=2.0), pulse=tp.Instant())
    looks = [Volume(DEEP, "all"), Volume(DEEP, "cells", (1, 1, 5))]
    duration = way * index / tp.speed_of_light
    result = run(flash, looks, medium=M(absorption=SIGMA, index=index), duration=duration)
    exact, energy = 2.0 * faded([0, 0.4, 0.8]) * 0.4, result["all"].absorbed_energy
    assert_agrees(energy, exact.sum() * SIGMA, FALSE_ALARM)
    assert_agrees(result["cells"].fluence[0, 0, :2], exact / 0.4, FALSE_ALARM)
    rejects(energy, 2.0 * faded([0, 2])[0] * 2 * SIGMA)  # the clock left out
    assert (result["cells"].fluence.value[0, 0, 2:] < 1e-12).all()
    assert result["all"].absorbed_power.value == pytest.approx(energy.value / duration, rel=1e-12)


def test_aimed_births_count_from_their_source_to_their_target_and_beyond():
    meter = tp.Disk(center=(0, 0, 3), radius=0.2, normal=(0, 0, -1))
    places = {"near": 0.25, "close by": 2.75, "beyond": 3.25}
    looks = [Volume(tp.Box(center=(0, 0, z), size=(9, 9, 0.5)), name) for name, z in places.items()]
    source = tp.Source(tp.Disk(radius=0.5), tp.Lambertian(radiance=1.0), aim=meter)
    result = run(source, [*looks, tp.Detector(meter, "meter")])
    first, *others = (result[name].fluence_rate.value for name in places)
    assert others == pytest.approx([first] * 2, rel=1e-12)  # straight on: the same way in each layer
    flux = result["meter"].flux_in.value
    assert flux < first * 81 < 1.05 * flux  # 1/cos of a few degrees
    assert any("volume detector" in warning and "aim" in warning for warning in result.warnings)


def test_light_that_leaves_into_the_open_is_counted_outside_as_well():
    """In a scene whose surroundings are empty: nothing is absorbed, 1.1 m on the straightest way out."""
    about = Volume(tp.Sphere(radius=1.9, center=BALL.center), "about", (0.8, 1.9))
    lamp = tp.Source(tp.Point(position=BALL.center), tp.Isotropic(power=1.0))
    reading = run(lamp, about, body(BALL, M(scattering=1.0)))["about"]
    assert 1.1 <= (reading.fluence_rate * reading.volumes).value[0] < 1.9


def test_scores_stay_within_the_guard_of_the_sums():
    result, bundle = foggy("weighted"), empty_bundle()
    program = compile_program(build_program(compile_scene(result.scene, result.plan.tracking)))
    raw = run_batch(program, seed=1, batch=0, histories=5000, bundle=bundle)
    high, scores = raw.detectors[1:, 0].sum(), raw.detectors[1:, 2].sum()
    assert bundle["scored"][0] >= high > 0 and bundle["scored"][0] - high >= SCORE_BOUND * scores // 2 > 0
    each = raw.detectors[1:, 0] / np.maximum(raw.detectors[1:, 2], 1)
    assert each.max() <= 2.0**32  # one at most, of weight 1


def test_volume_detectors_change_neither_with_threads_nor_the_flights_of_others():
    """The origin of all places is another one with them, so the rest is the same within rounding."""
    scene = foggy("weighted").scene
    options = {"particles": 20_000, "seed": 3, "tracking": "weighted", "progress": False}
    one, two = (tp.simulate(scene, threads=n, **options) for n in (1, 2))
    for name in one:
        for quantity in ("fluence_rate", "absorbed_power"):
            assert np.array_equal(*(getattr(each[name], quantity).value for each in (one, two)))
    bare = tp.simulate(tp.Scene(ALL_ROUND, body(BALL, FOG)), **options)
    for name in ("absorbed", "escaped"):
        assert one.ledger[name].value == pytest.approx(bare.ledger[name].value, rel=0.02)
    assert one.cost.collisions == pytest.approx(bare.cost.collisions, rel=0.02)


# ---- rings and layers of cylinders ----

ROD = tp.Cylinder(radius=0.6, height=1.4, center=(0.1, -0.2, 0.3), axis=(1.0, 2.0, 2.0))
UPRIGHT = tp.Cylinder(radius=0.6, height=1.4)
DIM, CELLS = M(absorption=0.9), (5, 7)


def ray_in_rings(shape, start, direction, cells, absorption=0.0, pieces=400_000):
    """Path in each ring of a ray of weight exp(-absorption x), by many short steps, and the length of a step."""
    start, direction, axis = (np.array(each, float) for each in (start, direction, shape.axis))
    direction /= np.linalg.norm(direction)
    reach = np.linalg.norm(start - shape.center) + shape.extent
    x = (np.arange(pieces) + 0.5) * reach / pieces
    away = start + x[:, None] * direction - shape.center
    z = away @ axis
    r = np.linalg.norm(away - z[:, None] * axis, axis=1)
    edges = Volume(shape, "x", cells=cells).edges(shape)
    counts, _, _ = np.histogram2d(r, z, (edges["r"], edges["z"]), weights=np.exp(-absorption * x))
    return counts * reach / pieces, reach / pieces


def pencil(start, direction, width=1e-9):
    """A beam so narrow that all of it goes the same way."""
    disk = tp.Disk(center=start, normal=direction, radius=width)
    return tp.Source(disk, tp.Beam(direction, power=2.0), side="front")


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


@pytest.mark.quick_cases("along the axis", "beside the axis")
@pytest.mark.parametrize("way", PENCILS)
def test_a_pencil_beam_fades_ring_by_ring(way):
    """A(r, z) by hand: followed by weight no draw is made."""
    (start, direction), looks = PENCILS[way], [Volume(ROD, "rod", CELLS), Volume(ROD, "one")]
    result = run(pencil(start, direction), looks, body(tp.Box(size=8.0), DIM), 300, tracking="weighted")
    by_hand, step = ray_in_rings(ROD, start, direction, CELLS, 0.9)
    volumes = looks[0].volumes(ROD)
    assert volumes.sum() == pytest.approx(ROD.volume, rel=1e-14)
    paths = result["rod"].fluence_rate.value * volumes
    np.testing.assert_allclose(paths, 2.0 * by_hand, rtol=1e-9, atol=2.0 * 2 * step)  # at entry and exit
    np.testing.assert_allclose(result["rod"].absorbed_power.value, 0.9 * paths, rtol=1e-12)
    np.testing.assert_allclose(result["rod"].absorbed_density.value, 0.9 * paths / volumes, rtol=1e-12)
    assert paths.sum() == pytest.approx(result["one"].fluence_rate.value * ROD.volume, rel=1e-12, abs=1e-30)
    assert (by_hand.sum() > 0) == ("beyond" not in way)


def paths_in_upright(start, direction):
    look = Volume(UPRIGHT, "rod", (4, 2))
    result = run(pencil(start, direction, 1e-14), look, particles=300)
    return result["rod"].fluence_rate.value * look.volumes(UPRIGHT) / 2.0


def test_paths_through_rings_are_exact():
    """Square roots by hand: a ray at a distance of 0.2 from the axis of a rod of radius 0.6, aligned with the world's axes."""
    half = [math.sqrt(max(r * r - 0.04, 0.0)) for r in (0.0, 0.15, 0.3, 0.45, 0.6)]
    paths = paths_in_upright((-2, 0.2, 0.1), (1, 0, 0))
    assert paths[:, 0].tolist() == [0] * 4
    np.testing.assert_allclose(paths[:, 1], 2 * np.diff(half), rtol=1e-12, atol=1e-30)


@pytest.mark.parametrize(("offset", "ring"), [(0.0, 0), (0.2, 1), (0.9, [])])
def test_a_ray_along_the_axis_stays_in_its_ring(offset, ring):
    """Its sine to the axis is 0: it meets no ring, and beyond the radius nothing."""
    exact = np.zeros((4, 2))
    exact[ring, :] = 0.7
    np.testing.assert_allclose(paths_in_upright((offset, 0, -2), (0, 0, 1)), exact, rtol=1e-12)


@pytest.mark.parametrize("offset", [0.15, 0.6])
def test_a_ray_that_touches_a_ring_goes_on_and_leaves_nothing_in_it(offset):
    """Tangent to the first ring's edge, and to the whole: no path within."""
    paths = paths_in_upright((-2, offset, 0.1), (1, 0, 0))
    assert paths[0].sum() < 1e-6
    assert paths.sum() == pytest.approx(2 * math.sqrt(0.36 - offset**2), rel=1e-12, abs=1e-6)


@pytest.mark.parametrize("estimator", ["track", "collision"])
def test_light_all_round_is_the_same_in_all_rings(estimator):
    """Radiance 1 from all sides: 4 pi in each ring, in vacuum and where a medium only scatters."""
    surfaces = [] if estimator == "track" else [body(tp.Sphere(radius=1.5), M(scattering=2.0))]
    looks = [Volume(ROD, "rod", (3, 2), sphere(2, 3), estimator), Volume(ROD, "one")]
    result = run(ALL_ROUND, looks, surfaces, 200_000)
    rings, one = result["rod"].fluence_rate, result["one"].fluence_rate
    assert_agrees(rings, 4 * math.pi, FALSE_ALARM)
    assert_agrees(result["rod"].radiance, 1.0, FALSE_ALARM)
    assert_agrees(one, 4 * math.pi, FALSE_ALARM)
    rejects(one, 4 * math.pi * 1.08)
    rejects(rings * np.array([[1.0], [3.0], [5.0]]) / 3, 4 * math.pi)  # areas all alike


@lru_cache
def beam_in_fog():
    """A beam down the axis of a rod in an endless fog, from one height below its middle."""
    rod = tp.Cylinder(radius=1.2, height=2.0)
    looks = [Volume(rod, "rod", (3, 4)), Volume(rod, "hits", (3, 4), estimator="collision")]
    looks += [Volume(rod, "one"), Volume(tp.Box(size=2.4), "box", (1, 1, 1))]
    source = tp.Source(tp.Point(position=(0, 0, -2.0)), tp.Beam((0, 0, 1), power=1.0))
    return run(source, looks, (), 200_000, medium=M(0.5, 1.5, tp.HenyeyGreenstein(0.6)))


def test_the_rings_add_up_to_the_whole():
    """Of the collision estimator within its error: each ring and layer by itself."""
    rings, one, box, hits = (beam_in_fog()[name] for name in ("rod", "one", "box", "hits"))
    difference = hits.absorbed_power - rings.absorbed_power
    assert_agrees(difference, 0.0, FALSE_ALARM)
    rejects(difference + rings.absorbed_power * 0.1, 0.0)
    assert whole(rings.fluence_rate, rings.volumes).value == pytest.approx(one.fluence_rate.value, rel=1e-12)
    assert rings.absorbed_power.sum().value == pytest.approx(one.absorbed_power.value, rel=1e-12)
    assert rings.fluence_rate.dims == ("r", "z")
    assert rings.absorbed_power.sum().value < box.absorbed_power.sum().value


@pytest.mark.parametrize("radius", [1.2, 0.7])
def test_a_rod_absorbs_nothing_where_it_lies_in_a_clear_ball(radius):
    """A ball of 1.2 m holds the rod, so that nothing within absorbs; out of one of 0.7 m its ends reach into what does."""
    clear = body(tp.Sphere(center=ROD.center, radius=radius), M(scattering=1.0))
    result = run(ALL_ROUND, Volume(ROD, "one"), clear, 20_000, tracking="weighted", medium=DIM)
    power = result["one"].absorbed_power
    assert (power.value > 0) == (radius < ROD.extent)
    assert power.exact == (radius > ROD.extent)


@pytest.mark.slow
def test_files_keep_rings(tmp_path):
    xarray, result = pytest.importorskip("xarray"), beam_in_fog()
    rate = result["rod"].fluence_rate
    data = rate.to_xarray()
    assert isinstance(data, (xarray.DataArray, xarray.Dataset)) and tuple(data.sizes) == ("r", "z")
    assert tp.Scene.from_json(result.scene.to_json()) == result.scene
    result.save(tmp_path / "rod.nc")
    again = tp.load(tmp_path / "rod.nc")["rod"].fluence_rate
    assert again.value.tobytes() == rate.value.tobytes() and again.dims == ("r", "z")


# ---- what is refused ----

POINT = tp.Source(tp.Point(position=(-0.95, 0.0, 0.0)), tp.Isotropic(power=1.0))
UNIT_BALL, SPECK = tp.Sphere(radius=1.0), (0.0321, -0.0123, 0.0712)
LOW, HIGH = (tp.Plane(center=(0, 0, z), normal=(0, 0, 1)) for z in (0.0999, 0.1))
LAYER = [tp.Surface(HIGH, CLEAR, front=FOG, back=VACUUM), tp.Surface(LOW, CLEAR, front=VACUUM, back=FOG)]
VOIDS = {
    "a speck": [body(tp.Sphere(radius=1e-3, center=SPECK), VACUUM)],
    "a small mesh": [body(tp.Mesh.box(size=1e-3, center=SPECK), VACUUM)],
    "a cap": [body(tp.Sphere(radius=3.0, center=(3.999, 0, 0)), VACUUM)],
    "a shell": [body(tp.Sphere(radius=0.9), VACUUM), body(tp.Sphere(radius=0.8999), FOG, "inner")],
    "a layer": LAYER,
}


def by_collisions(shape, surfaces, medium=FOG):
    detector = Volume(shape, "volume", estimator="collision")
    return compile_scene(tp.Scene(POINT, surfaces, detector, medium=medium)).volumes


@pytest.mark.slow
@pytest.mark.parametrize("shape", [UNIT_BALL, tp.Box(size=2.0), tp.Cylinder(radius=1.0, height=2.0)])
@pytest.mark.parametrize("void", VOIDS)
def test_collisions_are_refused_with_a_vacuum_of_any_size_in_the_volume(void, shape):
    with pytest.raises(tp.SceneError, match=r"all media in it must scatter .* got Vacuum"):
        by_collisions(shape, VOIDS[void])


def test_collisions_are_allowed_beside_a_vacuum():
    assert by_collisions(UNIT_BALL, body(tp.Sphere(radius=3.0, center=(4.001, 0, 0)), VACUUM))
    assert by_collisions(UNIT_BALL, body(UNIT_BALL, FOG), None)
    assert by_collisions(tp.Sphere(radius=0.2, center=(0, 0, 0.301)), LAYER, None)


def test_quantities_that_a_volume_was_not_set_up_for_are_refused():
    words = {"absorbed_power": "medium that absorbs", "radiance": "sphere"}
    for quantity, word in (words | dict.fromkeys(("fluence", "absorbed_energy"), "duration")).items():
        with pytest.raises(tp.SceneError, match=word):
            getattr(lit()["box"], quantity)
    with pytest.raises(AttributeError, match="did you mean 'fluence_rate'"):
        _ = lit()["box"].fluence_rates
