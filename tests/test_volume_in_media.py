"""Volume detectors in media: fluence rate and absorbed power agree with integrals, ledger and other trackings.

What holds for every flight is asked to rounding.  All runs have seed 1; each judgement fails right code in
one of 10^5 seeds.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.volume_scenes import (
    ALL_ROUND,
    BALL,
    DEEP,
    FACE,
    FALSE_ALARM,
    SIGMA,
    TRACKINGS,
    body,
    faded,
    foggy,
    rejects,
    run,
    sphere,
    whole,
)


def test_a_beam_fades_in_each_cell_by_the_exact_integral():
    """Followed by weight no draw is made: every digit is right.  The power of 2 W falls on 1 m^2."""
    looks = [tp.VolumeDetector("body", "all"), tp.VolumeDetector(DEEP, "cells", (1, 1, 4))]
    looks += [tp.VolumeDetector(tp.Box(size=(0.5, 0.5, 1.0)), "inner", (2, 2, 5))]
    looks += [tp.VolumeDetector(tp.Box(center=(0, 0, 0.4), size=(1.0, 1.0, 0.6)), "deep down")]
    scene = tp.Scene(
        tp.Source(FACE, tp.Beam((0, 0, 1), power=2.0)), [body(DEEP, tp.Medium(absorption=SIGMA))], looks
    )
    result = run(scene, 2000, tracking="weighted")
    assert result["all"].fluence_rate.value == pytest.approx(2.0 * faded([0, 2])[0], rel=1e-13)
    assert result["deep down"].fluence_rate.value == pytest.approx(2.0 * faded([1.1, 1.7])[0], rel=1e-13)
    np.testing.assert_allclose(
        result["cells"].fluence_rate.value[0, 0], 2.0 * faded(np.linspace(0, 2, 5)), rtol=1e-13
    )
    power = 2.0 * faded(np.linspace(0, 2, 5)) * SIGMA * 0.5
    np.testing.assert_allclose(result["cells"].absorbed_power.value[0, 0], power, rtol=1e-13)
    np.testing.assert_allclose(result["cells"].absorbed_density.value[0, 0], power / 0.5, rtol=1e-13)
    inner = result["inner"].fluence_rate.sum(("x", "y")) * 0.25
    for k, exact in enumerate(2.0 * faded(np.linspace(0.5, 1.5, 6))):  # a quarter of the beam, at random
        assert_agrees(inner[k], exact, FALSE_ALARM)


def test_the_same_by_chance():
    looks = [tp.VolumeDetector("body", "all"), tp.VolumeDetector("body", "cells", (1, 1, 4))]
    looks += [tp.VolumeDetector("body", "hits", (1, 1, 4), estimator="collision")]
    scene = tp.Scene(
        tp.Source(FACE, tp.Beam((0, 0, 1), power=2.0)), [body(DEEP, tp.Medium(absorption=SIGMA))], looks
    )
    result = run(scene, tracking="analog")
    exact = 2.0 * faded(np.linspace(0, 2, 5))
    assert_agrees(result["all"].fluence_rate, 2.0 * faded([0, 2])[0], FALSE_ALARM)
    for name in ("cells", "hits"):
        assert_agrees(result[name].fluence_rate[0, 0], exact, FALSE_ALARM)
        assert_agrees(result[name].absorbed_power[0, 0], exact * SIGMA * 0.5, FALSE_ALARM)
    rejects(result["cells"].fluence_rate[0, 0], np.full(4, 2.0))  # absorption left out
    hits = result["hits"]  # each collision is an absorption, of the ledger as well
    assert hits.absorbed_power.sum().value == pytest.approx(result.ledger["absorbed"].value, rel=1e-12)


@pytest.mark.parametrize("phase", [tp.Isotropic(), tp.HenyeyGreenstein(0.9), tp.Rayleigh()])
def test_a_ball_that_only_scatters_leaves_a_uniform_field_as_it_is(phase):
    """Radiance is conserved: 1 in all directions, inside as outside (Kirchhoff)."""
    medium = tp.Medium(scattering=3.0, phase=phase)
    looks = [
        tp.VolumeDetector("body", "ways"),
        tp.VolumeDetector("body", "hits", estimator="collision"),
        tp.VolumeDetector("body", "shells", (0.2, 0.5, 0.8)),
        tp.VolumeDetector("body", "hits in shells", (0.2, 0.5, 0.8), estimator="collision"),
        tp.VolumeDetector(tp.Box(size=0.6), "voxels", (2, 2, 2), sphere(2, 2)),
        tp.VolumeDetector(tp.Box(size=0.6), "hits in voxels", (2, 2, 2), sphere(2, 2), "collision"),
    ]
    result = run(tp.Scene(ALL_ROUND, [body(BALL, medium)], looks), particles=200_000)
    for reading in map(result.__getitem__, result):
        assert_agrees(reading.fluence_rate, 4 * math.pi, FALSE_ALARM)
        if reading.detector.directions is not None:
            assert_agrees(reading.radiance, 1.0, FALSE_ALARM)
    rejects(result["ways"].fluence_rate, 4 * math.pi * 1.06)
    for one, other in (("ways", "hits"), ("shells", "hits in shells"), ("voxels", "hits in voxels")):
        assert_agrees(result[one].fluence_rate - result[other].fluence_rate, 0.0, FALSE_ALARM)


@pytest.mark.parametrize("tracking", TRACKINGS)
def test_what_the_volume_absorbs_is_what_the_ledger_says(tracking):
    result = foggy(TRACKINGS[tracking])
    absorbed = result.ledger["absorbed"]
    totals = {name: result[name].absorbed_power for name in result}
    totals = {name: power if name in ("ways", "hits") else power.sum() for name, power in totals.items()}
    for name, power in totals.items():
        assert_agrees(power - absorbed, 0.0, FALSE_ALARM) if tracking == "analog" or name == "hits" else None
        rejects(power - absorbed * 1.1, 0.0)
        if tracking != "analog" and name != "hits":  # flight by flight, to rounding
            assert power.value == pytest.approx(absorbed.value, rel=1e-12)
    for name in ("shells", "voxels about it", "directions"):
        assert totals[name].value == pytest.approx(totals["ways"].value, rel=1e-12)
    ways = result["ways"]
    assert ways.absorbed_power.value == pytest.approx(0.7 * ways.fluence_rate.value * BALL.volume, rel=1e-12)


def test_however_histories_are_followed_the_same_comes_out():
    for tracking in ("analog", "forced", "split"):
        for name in ("ways", "hits", "shells", "voxels about it"):
            one, other = (foggy(TRACKINGS[each])[name].fluence_rate for each in (tracking, "weighted"))
            z = (one.value - other.value) / np.hypot(one.error, other.error)
            assert np.abs(z).max() < 5


@lru_cache
def voxelled(tracking, scatters=True):
    rng = np.random.default_rng(1)
    box, shape = tp.Box(size=(1.0, 1.2, 0.9)), (3, 4, 2)
    absorption, scattering = rng.uniform(0.1, 3, shape), rng.uniform(0.2, 4, shape) * scatters
    grid = tp.Grid(box=box, absorption=absorption, scattering=scattering)
    looks = [
        tp.VolumeDetector("body", "all"),
        tp.VolumeDetector("body", "same", shape),
        tp.VolumeDetector("body", "other", (5, 3, 4)),
        tp.VolumeDetector(tp.Box(size=1.5), "about it", (2, 2, 2)),
        tp.VolumeDetector(tp.Sphere(radius=0.4), "ball", (3,)),
    ]
    if scatters:
        looks += [tp.VolumeDetector("body", "hits", (5, 3, 4), estimator="collision")]
    return absorption, run(tp.Scene(ALL_ROUND, [body(box, grid)], looks), tracking=tracking)


@pytest.mark.parametrize("scatters", [False, True], ids=["absorbing", "scattering"])
@pytest.mark.parametrize("tracking", ["analog", "weighted"])
def test_in_a_grid_each_cell_absorbs_by_the_voxels_on_the_way(tracking, scatters):
    absorption, result = voxelled(tracking, scatters)
    same = result["same"]
    np.testing.assert_allclose(
        same.absorbed_power.value, absorption * same.fluence_rate.value * same.volumes, rtol=1e-12
    )
    total = result["all"].absorbed_power
    for name in ("same", "other", "about it"):
        assert result[name].absorbed_power.sum().value == pytest.approx(total.value, rel=1e-12)
    for name in ("same", "other"):
        found = whole(result[name].fluence_rate.value, result[name].volumes)
        assert found == pytest.approx(result["all"].fluence_rate.value, rel=1e-12)
    if tracking == "weighted" and not scatters:
        assert total.value == pytest.approx(result.ledger["absorbed"].value, rel=1e-12)
    assert_agrees(
        total - result.ledger["absorbed"], 0.0, FALSE_ALARM
    ) if tracking == "analog" or scatters else None
    if scatters:
        assert_agrees(result["other"].fluence_rate - result["hits"].fluence_rate, 0.0, FALSE_ALARM)
        assert_agrees(result["other"].absorbed_power - result["hits"].absorbed_power, 0.0, FALSE_ALARM)


LAYER_SIGMA = np.array([0.3, 1.1, 0.2, 2.0, 0.7])  # [m^-1], of layers 1 m thick about the origin
FACES = np.arange(6) - 2.5


def along(axis, length, width):
    """A vector of the length along one axis, of the width along the others."""
    return tuple(length if k == axis else width for k in range(3))


def layered(axis, scattering=0.0):
    """Voxels in five layers across an axis: numbers of voxels that differ on all axes tell these apart."""
    shape = along(axis, 5, 1)
    sigma = LAYER_SIGMA.reshape(shape)
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
    grid = layered(axis)
    medium = grid if filling == "voxels" else tp.Medium(absorption=SIGMA)
    radii = (0.4, 0.9, 1.3)
    looks = [
        tp.VolumeDetector(tp.Box(center=along(axis, 1.1, 0.0), size=along(axis, 1.4, 0.5)), "deep"),
        tp.VolumeDetector(tp.Box(size=along(axis, 3.2, 0.5)), "cells", along(axis, 7, 1)),
        tp.VolumeDetector(tp.Sphere(radius=radii[-1]), "shells", radii),
    ]
    beam = tp.Source(tp.Point(position=along(axis, -3.0, 0.0)), tp.Beam(along(axis, 1, 0), power=1.0))
    result = run(tp.Scene(beam, [body(grid.box, medium)], looks), 100, tracking="weighted")
    found = {name: np.ravel((result[name].fluence_rate * result[name].volumes).value) for name in result}
    np.testing.assert_allclose(found["deep"], faded_in(sigma, np.array([0.4, 1.8])), rtol=1e-12)
    np.testing.assert_allclose(found["cells"], faded_in(sigma, np.linspace(-1.6, 1.6, 8)), rtol=1e-12)
    before, after = (faded_in(sigma, np.sort(sign * np.array(radii))) for sign in (-1, 1))
    np.testing.assert_allclose(found["shells"], before[::-1] + after, rtol=1e-12)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_collisions_in_layers_of_voxels_absorb_what_the_ways_through_them_do(axis):
    """Each collision uses the coefficients of its own voxel, along whichever axis they change."""
    cells = along(axis, 5, 1)
    looks = [tp.VolumeDetector("body", name, cells, estimator=name) for name in ("track", "collision")]
    grid = layered(axis, scattering=1.5)
    lamp = tp.Source(grid.box, tp.Lambertian(power=1.0), side="back")
    result = run(tp.Scene(lamp, [body(grid.box, grid)], looks), 50_000, tracking="weighted")
    ways, hits = (result[look.name] for look in looks)
    for quantity in ("fluence_rate", "absorbed_power"):
        difference = getattr(hits, quantity) - getattr(ways, quantity)
        assert_agrees(difference, 0.0, FALSE_ALARM)
        rejects(difference + getattr(ways, quantity) * 0.05, 0.0)


def test_no_finding_counts_against_an_exact_zero():
    """Geometry proves that nothing is absorbed in the clear half of a cloud."""
    box = tp.Box(size=2.0)
    absorption = np.zeros((4, 4, 4))
    absorption[:, :, 3:] = 1.0
    cloud = tp.Grid(box=box, absorption=absorption, scattering=np.full((4, 4, 4), 0.5))
    lamp = tp.Source(tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=0.8), tp.Lambertian(power=1.0))
    body = tp.Surface(box, tp.Transparent(), "cloud", inside=cloud)
    below = tp.VolumeDetector(tp.Box(center=(0, 0, -0.4), size=0.5), "below")
    run = tp.simulate(tp.Scene(lamp, body, below), particles=2e4, seed=1, tracking="weighted", progress=False)
    absorbed = run["below"].absorbed_power
    assert absorbed.exact and absorbed.verdict == "sound" and absorbed.interval() == (0.0, 0.0)
