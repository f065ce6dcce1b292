"""Fog measured: radiance along rays, what came straight, a room and the sun, and planted faults.

All runs have seed 1.  Each judgement fails right code in one of 10^5 seeds, or shares that among its rows.
"""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_rejected
from transport.sims import fog
from transport.theory import attenuation
from transport.verification.experiment import run_experiment
from transport.viz.directions import direction_bins

pytestmark = pytest.mark.slow  # runs of millions of particles

FALSE_ALARM = 1e-5


@pytest.fixture(scope="module")
def outcomes():
    return run_experiment(fog, particles=500_000, seed=1, threads=2)


@pytest.fixture(scope="module")
def cases(outcomes):
    """By reading and optical depth, the sun's also by its zenith angle."""
    return {(o.parameters["reading"], *list(o.parameters.values())[1:]): o for o in outcomes}


def clear_irradiance(reading):
    radius, distance, meter = fog.LAMP if reading == "lamp" else fog.DISK
    return attenuation.disk_irradiance(fog.RADIANCE, radius, distance, 0.0, meter)


def test_nothing_is_seen_beside_the_disk(outcomes):
    beside = [row for o in outcomes for row in o.rows if "beside" in row.name]
    assert [row.estimate.value for row in beside] == [0.0] * 4


def test_in_clear_air_radiance_is_the_same_along_every_ray(cases):
    for row in cases["disk", 0.0, "slab"].rows[: fog.BINS]:
        assert_agrees(row.estimate, fog.RADIANCE, FALSE_ALARM)
        assert_rejected(row.estimate, 0.97 * fog.RADIANCE)


@pytest.mark.parametrize(("tau", "place"), [(0.5, "slab"), (1.0, "box"), (2.0, "everywhere")])
def test_in_fog_it_is_not_and_slanted_rays_lose_more(cases, tau, place):
    rows = cases["disk", tau, place].rows[: fog.BINS]
    for row in rows:
        assert_rejected(row.estimate, fog.RADIANCE)
        assert_rejected(row.estimate, fog.RADIANCE * math.exp(-tau))
    assert np.all(np.diff([row.estimate.value for row in rows]) < 0)


@pytest.mark.parametrize(("tau", "place"), [(0.5, "slab"), (1.0, "box"), (2.0, "everywhere")])
def test_irradiance_in_clear_air_times_the_straight_transmittance_is_rejected(cases, tau, place):
    irradiance = cases["disk", tau, place][fog.IRRADIANCE]
    assert_agrees(irradiance.estimate, irradiance.exact, FALSE_ALARM)
    assert_rejected(irradiance.estimate, math.exp(-tau) * clear_irradiance("disk"))
    assert_rejected(irradiance.estimate, attenuation.lambertian_transmission(tau) * clear_irradiance("disk"))


def test_scattered_light_comes_on_top_of_the_direct_part(cases):
    lamp = cases["lamp", 1.0]
    assert_agrees(lamp[fog.DIRECT].estimate, lamp[fog.DIRECT].exact, FALSE_ALARM)
    total = lamp.result["view"].irradiance
    assert_rejected(total, lamp[fog.DIRECT].exact)
    assert_rejected(lamp[fog.DIRECT].estimate, clear_irradiance("lamp"))
    assert total.value > 2 * lamp[fog.DIRECT].estimate.value


@pytest.mark.parametrize("albedo", [0.0, 0.4, 1.0])
def test_the_direct_part_depends_on_extinction_alone(albedo):
    """Absorbed or scattered, in any proportion: exp(-τ) counts the extinction."""
    meter = tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.3)
    scene = tp.Scene(
        tp.Source(tp.Disk(radius=0.2), tp.Lambertian(radiance=1.0)),
        tp.Surface(
            tp.Slab(center=(0, 0, 0.5), thickness=0.5),
            tp.Transparent(),
            inside=tp.Medium(absorption=2 * (1 - albedo), scattering=2 * albedo),
        ),
        tp.Detector(meter, "meter", events=0),
    )
    direct = tp.simulate(scene, particles=100_000, seed=1)["meter"].irradiance
    assert_agrees(direct, attenuation.disk_irradiance(1.0, 0.2, 1.0, 1.0, 0.3), FALSE_ALARM)
    assert_rejected(direct, attenuation.disk_irradiance(1.0, 0.2, 1.0, 1 - albedo / 3, 0.3) * 1.1)


def test_a_room_full_of_fog_is_as_bright_as_an_empty_one(cases):
    room = cases["room", 2.0]
    assert room[fog.IRRADIANCE].estimate.value == pytest.approx(math.pi * fog.RADIANCE, rel=1e-12)
    for i, row in enumerate(room.rows[:4]):
        assert_agrees(row.estimate, fog.RADIANCE, FALSE_ALARM)
        direct = room.rows[4 + i]
        assert "direct" in direct.name
        assert_agrees(direct.estimate, direct.exact, FALSE_ALARM)
        # nor is it what fog would leave that lies as a layer before the wall
        middle = (fog.WALL[i] + fog.WALL[i + 1]) / 2
        assert_rejected(direct.estimate, fog.RADIANCE * math.exp(-2.0 / middle))


def test_the_sun_has_2_3e7_above_the_air_and_1_4e7_below_it(cases):
    above, below = cases["sun", 0.0], cases["sun", fog.ATMOSPHERE, 0.0]
    assert_agrees(above[fog.SUN].estimate, 2.3e7, FALSE_ALARM)
    assert_agrees(below[fog.SUN].estimate, 1.4e7, FALSE_ALARM)
    assert round(fog.ATMOSPHERE, 2) == 0.50
    assert_rejected(below[fog.SUN].estimate, 2.3e7)
    low = cases["sun", fog.ATMOSPHERE, 75 * tp.deg][fog.SUN].estimate
    assert_rejected(low, 1.4e7)  # the same air at every height of the sun
    assert_rejected(low, 2.3e7 * math.exp(-fog.ATMOSPHERE * math.cos(75 * tp.deg)))


def test_radiances_read_on_the_ground_tell_that_above_the_air(cases):
    """Langley's line: log L against 1/cos z, drawn on to no air at all."""
    angles = [0, 60, 75]
    seen = [cases["sun", fog.ATMOSPHERE, angle * tp.deg][fog.SUN].estimate for angle in angles]
    air = [1 / math.cos(angle * tp.deg) for angle in angles]
    slope, top = np.polyfit(air, np.log([each.value for each in seen]), 1)
    error = max(each.relative_error for each in seen)
    assert abs(math.exp(top) / 2.3e7 - 1) < 10 * error
    assert abs(-slope / fog.ATMOSPHERE - 1) < 10 * error
    assert 10 * error < 0.05


@pytest.mark.parametrize(("tau", "place"), [(0.0, "slab"), (0.5, "slab"), (2.0, "everywhere")])
def test_the_picture_s_points_lie_on_its_bin_means_at_the_disk_s_edge_too(cases, tau, place):
    """Rejected there: the law in the middle of the bin, which the disk does not reach."""
    seen, law = cases["disk", tau, place].result["view"].radiance, disk_law(tau)
    bins, within = direction_bins(seen), math.atan2(*fog.DISK[:2])
    means = bins.expected(lambda theta, phi: law(theta), 0)
    edge = int(np.searchsorted(fog.ANGLES, within)) - 1
    assert_agrees(seen[: edge + 1], means[: edge + 1], FALSE_ALARM)
    assert law(fog.ANGLES[[edge, edge + 1]].mean()) == 0 < means[edge] < 0.2 * means[edge - 1]
    assert_rejected(seen[edge], 0.0)


def disk_law(tau):
    return lambda theta: fog._direct(theta, tau, fog.DISK)


def test_nothing_comes_through_fog_that_is_too_thick():
    [outcome] = run_experiment(
        fog, {"reading": "disk", "tau": 700.0, "place": "slab"}, particles=1000, seed=1
    )
    assert "inf times too much" in fog.verdict([outcome])


def test_the_verdict_says_how_wrong_the_guess_is(outcomes):
    assert re.search(r"1\.9[45] times too much at τ = 2", fog.verdict(outcomes))
