"""Splitting finds what gets through many mean free paths, and no gain biases anything.

All runs have seed 1; each judgement fails right code in one of 10^5 seeds.
"""

from __future__ import annotations

import math
from functools import lru_cache

import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.tracking_scenes import FALSE_ALARM, assert_rejects, run, slab, splitting
from transport.theory import ordinates

PARTICLES = 2000


@lru_cache
def transmitted(tau, albedo):
    return ordinates.slab(tau, albedo).transmitted


@pytest.mark.parametrize("absorption", ["weighted", "analog"])
@pytest.mark.parametrize("gain", [1e6, 3e8, 1e10])
def test_what_gets_through_twenty_mean_free_paths_is_found_by_splitting(absorption, gain):
    """tau 20, albedo 0.2: 2.94e-9 of the light; without splitting none of 4 10^4 particles comes through by chance."""
    tracking = tp.Tracking(absorption=absorption, splitting=splitting(gain))
    through = run(slab(20.0, 0.2), tracking, 40_000)["bottom"].flux_out
    assert_agrees(through, transmitted(20.0, 0.2), FALSE_ALARM)
    if gain == 3e8:
        assert through.relative_error < 0.1
        assert_rejects(through, 1.6 * transmitted(20.0, 0.2))
    if absorption == "analog":
        assert run(slab(20.0, 0.2), absorption, 40_000)["bottom"].flux_out.value == 0


@pytest.mark.parametrize("gain", [2.0, 10.0, 1e3, 1e6, 1e12])
@pytest.mark.parametrize("is_upwards", [False, True])
def test_no_gain_biases_a_slab_lit_from_either_end(gain, is_upwards):
    """tau 3: importance rises with depth, or the light comes from where it is largest and is thinned out."""
    depth = max(1.0, math.log(gain) / 3)  # so far that importance rises no faster than the light falls
    ends = {"start": (0, 0, -depth), "end": (0, 0, 0)} if is_upwards else {"end": (0, 0, -depth)}
    exact = ordinates.slab(3.0, 0.5)
    result = run(slab(3.0, 0.5), tp.Tracking(splitting=splitting(gain, **ends)), 20_000)
    assert_agrees(result["top"].flux_out, exact.reflected, FALSE_ALARM)
    assert_agrees(result["bottom"].flux_out, exact.transmitted, FALSE_ALARM)
    assert result.cost.collisions < 100 * 20_000  # not a copy for each unit of the gain


@pytest.mark.parametrize("is_aimed", [False, True])
def test_what_is_born_is_heavy_as_its_own_birthplace_wants_and_light_as_the_end_does(is_aimed):
    """After eight mean free paths, mostly of absorption, each weighs 1/gain of its birth weight, within 2.

    An aimed history is kept at its target, where importance is greatest, but is born where it is least.
    """
    gain, tau, radius, height = math.exp(6), 8.0, 1e-3, 3.0
    law, at = tp.Beam((0, 0, -1), power=1.0), tp.Point(position=(0, 0, height))
    if is_aimed:
        target = tp.Disk(center=(0, 0, -1), radius=radius)
        power = 2 / (1 - (height + 1) / math.hypot(height + 1, radius))  # of which 1 W goes there
        lamp = tp.Source(at, tp.Isotropic(power=power), aim=target)
    else:
        lamp = tp.Source(at, law)
    scene = slab(tau, 0.01)
    through = run(
        tp.Scene(lamp, scene.surfaces, scene.detectors), tp.Tracking(splitting=splitting(gain)), PARTICLES
    )["bottom"]
    assert through.flux_out.value == pytest.approx(math.exp(-tau), rel=0.1)
    weight = through.flux_out.value / through.number_of("weight out") * PARTICLES
    assert 0.5 / gain <= weight <= 2 / gain
