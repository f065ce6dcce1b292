"""The sheet turned to 89.9°, radiance three ways, and a ball's reading; for each a mistake that is rejected.

The statistical tests fail right code in one of 10^5 seeds each; the seed is 1.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_rejected
from transport.geometry import solid_angles
from transport.sims import lambert_disk
from transport.theory import solid_angles as solid_angles_theory
from transport.verification.experiment import run_experiment

pytestmark = pytest.mark.slow  # runs of millions of particles

FALSE_ALARM = 1e-5
RADIANCE, RADIUS = 100.0, 0.5
CONE = "radiance, cone in the disk"


def run(**parameters):
    """The first case of the sim with these parameters."""
    return run_experiment(lambert_disk, parameters, particles=1_000_000, seed=1)[0]


def turned(degrees, distance):
    return run(reading="turned", tilt=math.radians(degrees), distance=distance)


@pytest.mark.parametrize("degrees", [30, 60, 85, 89, 89.9])
def test_turning_a_far_sheet_lets_the_flux_fall_with_the_cosine_and_the_radiance_stay(degrees):
    outcome = turned(degrees, 1000.0)
    facing = RADIANCE * math.pi * RADIUS**2 / (RADIUS**2 + 1000.0**2)
    irradiance, cosine = outcome["irradiance"].estimate, math.cos(math.radians(degrees))
    assert_agrees(irradiance, facing * cosine, FALSE_ALARM)
    assert_rejected(irradiance, facing * cosine**2)
    assert_agrees(outcome[CONE].estimate, RADIANCE, FALSE_ALARM)
    meter = outcome.result["turned"]  # flux over dA and dω, the projection of dA forgotten
    assert_rejected(meter.flux_density[0], RADIANCE)


@pytest.mark.parametrize("degrees", [45, 60, 89, 89.9, 120])
def test_a_near_sheet_sees_what_is_above_its_horizon(degrees):
    """The disk is a cone of 45° and is cut by the horizon of a sheet turned by more."""
    outcome, mu = turned(degrees, RADIUS), math.cos(math.radians(degrees))
    seen = solid_angles.cone_projected_solid_angle(math.pi / 4, mu)
    assert_agrees(outcome["irradiance"].estimate, RADIANCE * seen, FALSE_ALARM)
    assert_agrees(outcome[CONE].estimate, RADIANCE, FALSE_ALARM)
    if degrees > 45:
        assert_rejected(outcome["irradiance"].estimate, RADIANCE * math.pi / 2 * mu)


def test_radiance_comes_out_alike_three_ways():
    outcome = run(reading="three ways", distance=1.0)
    mean_cosine = (1 + math.cos(lambert_disk.CONE)) / 2
    for name, exact in zip(lambert_disk.THREE_WAYS, (1, mean_cosine, mean_cosine), strict=True):
        assert_agrees(outcome[name].estimate, RADIANCE * exact, FALSE_ALARM)
        assert_rejected(
            outcome[name].estimate, RADIANCE * exact * math.cos(lambert_disk.RAY)
        )  # a cosine too many
        assert_rejected(
            outcome[name].estimate, RADIANCE * exact / math.cos(lambert_disk.RAY)
        )  # and one forgotten


def test_the_cone_of_the_three_ways_meets_the_disk_from_all_of_both_meters():
    """All that comes from it has L: in no position is there less."""
    scene = run(reading="three ways", distance=1.0).result.scene
    places = [tp.Positions(u=3, v=4) for _ in range(2)]
    meters = [
        tp.Detector(d.shape, d.name, directions=d.directions, positions=p)
        for d, p in zip(scene.detectors, places, strict=False)
    ]
    result = tp.simulate(tp.Scene(scene.sources, detectors=meters), particles=4_000_000, seed=1, threads=2)
    for meter in meters:
        assert_agrees(result[meter.name].radiance, RADIANCE, FALSE_ALARM)


@pytest.mark.parametrize(
    ("distance", "ball"), [(0.5, 0.01), (0.5, 0.2), (0.5, 0.99), (0.1, 0.5), (20.0, 0.05)]
)
def test_a_ball_reads_the_fluence_rate_whatever_its_size(distance, ball):
    reading = run(reading="ball", distance=distance, ball=ball)[lambert_disk.BALL].estimate
    solid_angle = 2 * math.pi * (1 - distance / math.hypot(distance, RADIUS))
    assert_agrees(reading, RADIANCE * solid_angle, FALSE_ALARM)
    assert_rejected(reading, RADIANCE * solid_angle / 4)  # flux over the area 4 π r²
    projected = solid_angles_theory.disk_projected_solid_angle(RADIUS, distance)
    if distance < 20:
        assert_rejected(reading, RADIANCE * projected)  # the irradiance of a plate


def test_one_setting_for_all_cases_is_no_contradiction():
    """At the distance 0 the meter is the disk, whatever the reading."""
    for settings in ({"distance": 0.0}, {"distance": 0.1}, {"offset": 0.2}, {"radius": 0.01}, {"tilt": 0.3}):
        outcomes = run_experiment(lambert_disk, settings, particles=1000, seed=1)
        assert {"power"} < {row.name for row in outcomes[0].rows} or settings != {"distance": 0.0}


@pytest.mark.parametrize("parameters", [each for each in lambert_disk.cases() if "offset" in each])
def test_a_map_of_the_disk_has_no_bins_that_its_rim_barely_reaches(parameters):
    """A rim on an edge of bins leaves a few scores in the next bins, and a warning that no reader expects."""
    offset, distance, radius = parameters["offset"], parameters["distance"], RADIUS
    theta = np.linspace(0, 90, lambert_disk.MAP.theta + 1)
    for place in (offset - radius, offset + radius):
        rim = math.degrees(math.atan(abs(place) / distance))
        assert rim == 0 or np.abs(theta - rim).min() > 0.1 * theta[1]
    outcomes = [run_experiment(lambert_disk, parameters, seed=seed)[0] for seed in (0, 3, 5)]
    assert [warning for outcome in outcomes for warning in outcome.warnings] == []
