"""Fluence rates whose crossings beyond the grazing cut are no constant radiance's say so, and others do not."""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from transport.results.diagnostics.nearby import _is_significant

DISK = tp.Disk(radius=0.5)
METER = tp.Detector(DISK, "meter")


def flat_beam(mu, power=1.0):
    """Through the middle of the disk, so flat."""
    direction = (math.sqrt((1 - mu) * (1 + mu)), 0, -mu)
    return tp.Source(tp.Point(position=(-1, 0, mu)), tp.Beam(direction=direction, power=power))


def warnings_of(*sources, particles=20_000, meter=METER):
    result = tp.simulate(tp.Scene(sources, (), meter), particles=particles, seed=1, progress=False)
    return [warning for warning in result.warnings if "fluence_rate" in warning], result["meter"]


@pytest.mark.parametrize("bins", [{}, {"directions": tp.Directions(mu=4, phi=4)}])
@pytest.mark.parametrize("mu", [1e-7, 5e-4, 9e-4])
def test_a_beam_beyond_the_grazing_cut_is_told(mu, bins):
    (warning,), reading = warnings_of(flat_beam(mu), meter=tp.Detector(DISK, "meter", **bins))
    assert warning.startswith(
        "fluence_rate of detector 'meter' is doubtful: 1 or more of it is crossings of |mu| < 0.001"
    )
    assert ", doubtful: 1 or more of it is crossings" in str(reading.fluence_rate)
    assert reading.fluence_rate.is_doubtful and not reading.flux_in.is_doubtful
    assert np.sum(reading.counts.value) == 20_000  # what is told apart does not spoil numbers


def test_it_is_told_beside_other_light_as_far_as_it_matters():
    """Of 4 pi W m^-2 from all around and half as much from the beam, 122 histories in 500 000."""
    lamp = tp.Source(tp.Sphere(radius=0.6), tp.Lambertian(radiance=1.0), side="inside")
    power = 4 * math.pi * DISK.area / 2000 / 2
    (warning,), _ = warnings_of(lamp, flat_beam(5e-4, power), particles=500_000)
    assert 0.25 < float(warning.split(": ")[1].split()[0]) < 0.4
    assert not warnings_of(lamp, particles=500_000)[0]


def test_one_history_that_grazes_many_times_tells_nothing():
    assert _is_significant(np.arange(32) % 3 + 1.0) and _is_significant(np.full(4, 7.0))
    assert not _is_significant(np.array([40.0] + 31 * [0.0]))


@pytest.mark.parametrize(("mu", "side"), [(7.06e-4, 1), (7.08e-4, -1)])
def test_half_of_what_grazes_from_a_constant_radiance_is_below_the_root_of_one_half(mu, side):
    """Of the cut: crossings come in proportion to |mu|."""
    scene = tp.Scene(
        flat_beam(mu), (), [tp.Detector(tp.Plane(center=(0, 0, -1)), "other"), tp.Detector(DISK, "meter")]
    )
    result = tp.simulate(scene, particles=320, seed=1, progress=False)
    assert [batch.grazing.tolist() for batch in result.batches] == [[10 * side, 10 * side]] * 32


@pytest.mark.parametrize("mu", [1.1e-3, 0.5])
def test_a_beam_short_of_the_cut_is_not(mu):
    assert not warnings_of(flat_beam(mu))[0]


def test_even_light_from_the_horizon_is_not():
    """A low wall all around: a tenth of the fluence comes beyond the cut, as the mean supposes."""
    wall = tp.Cylinder(radius=0.6, height=0.004)
    lamp = tp.Source(wall, tp.Lambertian(radiance=1.0), side="back")
    found, reading = warnings_of(lamp, particles=1_000_000)
    assert not found
    assert reading.fluence_rate.value / (reading.flux_in.value + reading.flux_out.value) * DISK.area > 200


def test_of_one_batch_nothing_is_sure():
    """An interrupted run may have one; its spread is 0/0."""
    assert not _is_significant(np.array([1000.0]))
    assert _is_significant(np.array([1000.0, 1000.0]))
