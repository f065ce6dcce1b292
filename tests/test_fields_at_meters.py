"""What meters make of one crossing beyond its flux: fluence, momentum, phase density, radiance by the world's directions.

Each judgement fails right code in one of 10^6 seeds.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees

FALSE_ALARM = 1e-6
LIGHT_SPEED = 299_792_458.0


def told(sources, *detectors, particles=200_000, **scene):
    """A run without surfaces."""
    return tp.simulate(tp.Scene(sources, (), detectors, **scene), particles=particles, seed=1, progress=False)


@pytest.mark.parametrize(
    ("mu", "inverse"), [(0.02, 50.0), (1.5e-3, 1 / 1.5e-3), (5e-4, 2000.0), (1e-6, 2000.0)]
)
@pytest.mark.parametrize("side", [-1, 1])
def test_a_crossing_brings_one_over_its_cosine_and_beyond_the_grazing_cut_its_mean(mu, inverse, side):
    """The cut is at 1e-3, and the mean of 1/mu below it, weighted with mu, 2000."""
    beam = tp.Beam(direction=(math.sqrt(1 - mu * mu), 0, mu), power=3.0)
    disk = tp.Disk(center=(1, 0, mu), normal=(0, 0, side), radius=0.5)
    reading = told(tp.Source(tp.Point(), beam), tp.Detector(disk, "meter"), particles=64)["meter"]
    assert reading.fluence_rate.value == pytest.approx(3.0 * inverse / disk.area, rel=1e-6)


def test_light_from_all_sides_has_its_fluence_and_presses_with_a_third_of_its_energy_density():
    lamp = tp.Source(tp.Sphere(radius=2.0), tp.Lambertian(radiance=1.0), side="inside")
    meter = told(lamp, tp.Detector(tp.Disk(radius=1.0), "meter", moments=True))["meter"]
    assert_agrees(meter.fluence_rate, 4 * math.pi, FALSE_ALARM)
    assert_agrees(meter.pressure, 4 * math.pi / 3 / LIGHT_SPEED, FALSE_ALARM)


def test_light_of_each_speed_presses_by_its_energy_over_its_own_speed():
    """Two beams, 3 W at 0.5 m/s and 5 W at 2 m/s, press with 6 and 2.5 N; matter has v instead of 1/v."""
    at, into, meter = tp.Point(position=(0, 0, -1)), (0, 0, 1), tp.Disk(radius=0.5)
    beams = [tp.Source(at, tp.Beam(into, power=p, speed=v)) for p, v in ((3.0, 0.5), (5.0, 2.0))]
    found = told(beams, tp.Detector(meter, "meter", side="back", moments=True))["meter"]
    assert_agrees(found.pressure * (meter.area * 1.0), 3.0 / 0.5 + 5.0 / 2.0, FALSE_ALARM)
    assert found.pressure.relative_error < 1e-2


def test_light_from_below_is_in_the_worlds_lower_bins_of_a_ball():
    """By where it comes from; the ball's normals are met at a mean cosine of 1/4 of its surface."""
    lamp = tp.Source(tp.Sphere(radius=2.0, mu_max=0.0), tp.Lambertian(radiance=5.0), side="back")
    world = tp.Directions(mu=(-1, -0.3, 0.3, 1), frame="world")
    ball = tp.Detector(tp.Sphere(radius=0.5), "ball", side="outside", directions=world)
    sphere, below = tp.Sphere(radius=0.5), tp.Directions.cone((0, 0, -1), 0.5)
    result = told(lamp, ball, tp.Detector(sphere, "cone", side="outside", directions=below))
    assert_agrees(result["cone"].radiance, 5.0, FALSE_ALARM)
    radiance = result["ball"].radiance
    assert_agrees(radiance[0], 5.0, FALSE_ALARM)
    assert radiance.value[2] == 0 < radiance.value[1] < 5


def test_phase_density_is_flux_over_what_crosses_of_it():
    """Of a gas of one speed, in a bin of speeds from 1/2 to 2: n / 4 pi over the integral of v^3, times v."""
    gas = tp.Source(tp.Box(size=2.4), tp.Gas(density=7.0, speed=1.0))
    meter = tp.Detector(tp.Disk(radius=0.4), "meter", directions=tp.Directions(mu=1), speeds=(0.5, 2.0))
    density = told(gas, meter, particles=400_000, duration=0.8)["meter"].phase_density
    assert_agrees(density[0, 0], 7.0 / (4 * math.pi) / ((2.0**4 - 0.5**4) / 4), FALSE_ALARM)
    assert np.size(density.value) == 1
