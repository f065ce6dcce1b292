"""What is fainter than its digits: far below 2^-63 of a birth weight scores are right in the mean, and no digit is made up.

Sums are whole numbers of 2^-63 of the largest birth weight.  A code that cuts off what is less reports 0 beyond 44 mean free
paths, with "every batch gave the same".
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from transport.engine import tally

FALSE_ALARM = 1e-4


def through(tau, particles, directions=None):
    """A beam through a pure absorber, of power 1: what comes out, and the fluence in the last metre (tau is 1 a metre)."""
    lamp = tp.Source(tp.Point(position=(0, 0, 1)), tp.Beam((0, 0, -1), power=1.0))
    slab = tp.Slab(center=(0, 0, -tau / 2), thickness=tau)
    last = tp.VolumeDetector(tp.Box(center=(0, 0, -tau + 0.5), size=(1, 1, 1)), "last")
    cells = tp.VolumeDetector(tp.Box(center=(0, 0, -tau + 0.5), size=(1, 1, 1)), "cells", cells=(1, 1, 4))
    far = tp.Detector(tp.Plane(center=(0, 0, -tau)), "far", side="back", directions=directions)
    scene = tp.Scene(
        lamp, tp.Surface(slab, tp.Transparent(), inside=tp.Medium(absorption=1.0)), [far, last, cells]
    )
    return tp.simulate(scene, particles=particles, seed=5, threads=1)


@pytest.mark.parametrize("tau", [30.0, 40.0, 45.0, 50.0])
def test_faint_light_is_right_in_the_mean(tau):
    exact = math.exp(-tau)
    result = through(tau, 200_000)
    assert_agrees(result["far"].flux_out, exact, FALSE_ALARM)
    assert_agrees(result["last"].fluence_rate, exact * (math.e - 1), FALSE_ALARM)
    quarters = exact * 4 * (np.exp(np.arange(1, 5) / 4) - np.exp(np.arange(4) / 4))
    assert_agrees(result["cells"].fluence_rate[0, 0], quarters, FALSE_ALARM)
    assert_agrees(result["last"].absorbed_power, exact * (math.e - 1), FALSE_ALARM)


def test_what_is_not_faint_has_no_noise():
    result = through(20.0, 10_000)
    assert result["far"].flux_out.value == pytest.approx(math.exp(-20), abs=2.0**-63)  # the unit of sums
    assert math.isnan(result["far"].flux_out.error)


def test_what_is_too_faint_for_a_single_score_says_so():
    flux = through(80.0, 1000)["far"].flux_out
    assert flux.value == 0 and flux.reason == "no score"


@pytest.mark.parametrize("weight", [0.0, 2.0**-63, 2.0**-40, 1e-15, 1e-20, 1e-30, 0.3, 1.0])
def test_chance_rounds_up_only_what_is_less_than_a_unit(weight):
    """The mean over even chances is the weight; a whole number of units is left alone; nothing stays nothing."""
    chances = (np.arange(4096) + 0.5) / 4096
    units = np.array([tally.unbiased_limbs(weight, chance) for chance in chances], dtype=object)
    found = [high * 2**31 + low for high, low in units]
    exact = weight * 2.0**63
    assert abs(np.mean([float(one) for one in found]) - exact) <= max(1 / 4096, 1e-9 * exact)
    assert exact != int(exact) or set(found) == {int(exact)}


@pytest.mark.parametrize("weight", [0.0, 2.0**-63, 1e-15, 1 / 3, 0.7, 1.0])
def test_the_ledger_keeps_every_unit_of_a_weight(weight):
    """Both limbs together are its whole number of units of 2^-63: with the upper one alone 2^-32 would be the end."""
    high, low = tally.limbs(weight)
    assert high * 2**31 + low == int(weight * 2.0**63)
