"""What next to nothing absorbs is in the ledger to all the digits that there are, and the ledger closes."""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees

FALSE_ALARM = 1e-6
BEAM = tp.Source(tp.Point(position=(0, 0, -3)), tp.Beam(direction=(0, 0, 1), power=1.0))


def absorbed(depth, particles=20_000, grid=False):
    """By weight, of a beam of 1 W through the middle of a weak absorber of this optical depth, 2 m long."""
    shape = tp.Box(size=2.0) if grid else tp.Sphere(radius=1.0)
    inside = (
        tp.Grid(box=shape, absorption=np.full((2, 3, 4), depth / 2))
        if grid
        else tp.Medium(absorption=depth / 2)
    )
    scene = tp.Scene(BEAM, tp.Surface(shape, tp.Transparent(), inside=inside))
    result = tp.simulate(scene, particles=particles, tracking="weighted", seed=1, progress=False)
    return result.ledger["absorbed"]


@pytest.mark.parametrize("grid", [False, True])
@pytest.mark.parametrize("depth", [1e-3, 1.5e-6, 7e-7, 1e-9, 1e-12])
def test_what_little_is_absorbed_is_known(depth, grid):
    """Of 20 000 histories the last places of a weight average out to 1e-18, 1e-6 of a depth of 1e-12."""
    assert absorbed(depth, grid=grid).value == pytest.approx(
        -math.expm1(-depth), rel=max(1e-13, 5e-18 / depth), abs=0
    )


@pytest.mark.parametrize("grid", [False, True])
@pytest.mark.parametrize("depth", [1e-16, 1e-18])
def test_absorption_below_the_last_place_of_a_weight_is_right_in_the_mean(depth, grid):
    """One history in a hundred loses 1e-16: a difference of weights would be 0, every time."""
    found = absorbed(depth, particles=400_000, grid=grid)
    assert_agrees(found, depth, FALSE_ALARM)
    assert found.value > 0


def test_weights_that_have_been_lessened_before_are_lessened_right():
    """Weights of any digits, behind an absorber: of each length in the ball the same as where plain arithmetic will do."""
    found = []
    for absorption in (1e-3, 2e-17):
        inside = tp.Medium(absorption=absorption)
        ball = tp.Surface(tp.Sphere(radius=1.0), tp.Transparent(), inside=inside, name="ball")
        room = tp.Surface(tp.Sphere(radius=1.9), tp.Transparent(), inside=tp.Medium(absorption=0.3))
        lamp = tp.Source(tp.Sphere(radius=2.0), tp.Lambertian(power=1.0), side="inside")
        scene = tp.Scene(lamp, [ball, room])
        result = tp.simulate(scene, particles=100_000, tracking="weighted", seed=2, progress=False)
        found.append(result.ledger.absorbed_by["inside ball"] * (1 / absorption))
    assert_agrees(found[1], found[0].value, FALSE_ALARM)
    assert found[1].relative_error < 0.02
