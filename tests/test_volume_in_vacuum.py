"""Volume detectors in light without media: fluence rate and radiance in a box or a ball, cell by cell.

All runs have seed 1; each judgement fails right code in one of 10^5 seeds.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.volume_scenes import (
    BALL,
    BOX,
    FALSE_ALARM,
    lit,
    rejects,
    run,
    sphere,
    whole,
)


@pytest.mark.parametrize("shape", [BOX, BALL], ids=["box", "ball"])
def test_the_mean_chord_of_isotropic_rays_is_four_volumes_over_the_surface(shape):
    """Cauchy (1841): so light of the power P from all of the boundary makes the fluence rate 4 P/S."""
    source = tp.Source(shape, tp.Lambertian(power=3.0), side="back")
    found = run(tp.Scene(source, [], tp.VolumeDetector(shape, "inside")))["inside"].fluence_rate
    assert_agrees(found, 12.0 / shape.area, FALSE_ALARM)
    assert found.relative_error < 0.01
    rejects(found, 12.0 / shape.area * 4 / 3)  # the mean over points instead of rays
    rejects(found, 12.0 / shape.area * 1.05)  # a volume 5 % wrong


@pytest.mark.parametrize(
    "name", ["box", "voxels", "ball", "shells", "hollow", "ways", "cells and ways", "azimuth"]
)
def test_in_a_uniform_field_the_fluence_rate_is_4_pi_radiance_in_each_cell(name):
    reading = lit()[name]
    assert_agrees(reading.fluence_rate, 4 * math.pi, FALSE_ALARM)
    if reading.detector.directions is not None:
        assert_agrees(reading.radiance, 1.0, FALSE_ALARM)
        rejects(reading.radiance, 1.2)


def test_cells_add_up_to_the_whole():
    for part, all_of_it in (
        ("voxels", "box"),
        ("shells", "ball"),
        ("ways", "box"),
        ("cells and ways", "box"),
    ):
        reading = lit()[part]
        found = whole(reading.fluence_rate.value, reading.volumes)
        assert found == pytest.approx(lit()[all_of_it].fluence_rate.value, rel=1e-13)


def test_radiance_over_all_directions_is_the_fluence_rate():
    reading = lit()["ways"]
    angles = reading.detector.directions.solid_angles()
    assert angles.sum() == pytest.approx(4 * math.pi, rel=1e-15)
    assert (reading.radiance.value * angles).sum() == pytest.approx(reading.fluence_rate.value, rel=1e-13)
    some = lit()["cells and ways"]
    part = (some.radiance.value * some.detector.directions.solid_angles()).sum(axis=(-2, -1))
    assert (part < some.fluence_rate.value * 0.5).all()


@pytest.mark.parametrize("axis", [(0, 0, 1), (1, 0, 0), (0, 1, 0), (1, -2, 3)])
def test_radiance_is_told_by_the_direction_of_flight(axis):
    """A beam in known bins of cosine and azimuth."""
    flight = np.array((-0.48, 0.64, 0.6))
    beam = tp.Source(
        tp.Disk(radius=0.1, center=tuple(-3 * flight), normal=tuple(flight)), tp.Beam(flight, power=1.0)
    )
    reading = run(tp.Scene(beam, [], tp.VolumeDetector(BOX, "box", None, sphere(9, 12, axis))), 1000)["box"]
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
    radii = (0.0, 1e-9, 0.1, 0.1 + 1e-9, 0.7, 0.8)
    found = tp.VolumeDetector(BALL, "ball", radii).volumes(BALL)
    cubes = [Fraction(r) ** 3 for r in radii]
    exact = [4 / 3 * math.pi * float(b - a) for a, b in zip(cubes, cubes[1:], strict=False)]
    np.testing.assert_allclose(
        found, exact, rtol=1e-14
    )  # a difference of cubes has eight digits of the thin one
    assert tp.VolumeDetector(BALL, "ball", 7).volumes(BALL).sum() == pytest.approx(BALL.volume, rel=1e-15)
    assert tp.VolumeDetector(BOX, "box", (2, 3, 4)).volumes(BOX) == pytest.approx(
        np.full((2, 3, 4), 1 / 24), rel=1e-15
    )


@pytest.mark.parametrize(("shape", "way"), [(tp.Box(size=1.2), 0.5), (tp.Sphere(radius=0.6), 0.5)])
def test_what_begins_within_counts_from_where_it_begins(shape, way):
    """A beam of 1 W from 0.1 beyond the middle: its way to the side, over the volume."""
    beam = tp.Source(tp.Point(position=(0.1, 0, 0)), tp.Beam((1, 0, 0), power=1.0))
    result = tp.simulate(tp.Scene(beam, detectors=tp.VolumeDetector(shape, "volume")), 100, seed=1)
    assert result["volume"].fluence_rate.value == pytest.approx(way / shape.volume, rel=1e-12)
