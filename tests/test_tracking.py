"""However histories are followed through media, exact values come out.

All runs have seed 1; each judgement fails right code in one of 10^5 seeds.  A comment such as `E.slab_HG` names the entry of
the project's reference collection that a number comes from.
"""

from __future__ import annotations

import math

import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.tracking_scenes import FALSE_ALARM, TRACKINGS, R, T, assert_rejects, run, slab, splitting
from transport.theory import ordinates


@pytest.mark.parametrize("name", TRACKINGS)
def test_van_de_hulst_s_slab(name):
    """A cosine of the wrong sign (g = -0.75) or isotropic scattering would be seen."""
    result = run(slab(2.0, 0.9, 0.75), TRACKINGS[name])
    top, bottom = result["top"].flux_out, result["bottom"].flux_out
    assert_agrees(top, R, FALSE_ALARM)
    assert_agrees(bottom, T, FALSE_ALARM)
    balance = result.ledger["absorbed"] + result.ledger["roulette"]  # what roulette kills less what it gains
    assert_agrees(balance, 1 - R - T, FALSE_ALARM)
    wrong = ordinates.slab(2.0, 0.9)
    for estimate, other, exact in ((top, wrong.reflected, R), (bottom, wrong.transmitted, T)):
        assert_rejects(estimate, other)
        assert_rejects(estimate, exact * 1.1)


def test_ways_that_do_not_lessen_weights_play_no_roulette():
    assert run(slab(2.0, 1.0, 0.75)).ledger["roulette"].value == 0
    assert run(slab(2.0, 0.9, 0.75), "analog").ledger["roulette"].value == 0


OTHERS = [  # tau, albedo, g, mu0
    (0.1, 0.5, 0.0, 0.5),
    (1.0, 0.99, -0.5, 1.0),
    (5.0, 0.8, 0.9, 0.7),
    (2.0, 1.0, 0.0, 0.1),
]


@pytest.mark.parametrize(("tau", "albedo", "g", "mu0"), OTHERS)
@pytest.mark.parametrize("name", ["analog", "weighted", "forced", "split"])
def test_slabs_of_every_kind(tau, albedo, g, mu0, name):
    exact = ordinates.slab(tau, albedo, ordinates.henyey_greenstein(g), mu0)
    result = run(slab(tau, albedo, g, mu0), TRACKINGS[name], 50_000)
    assert_agrees(result["top"].flux_out, exact.reflected, FALSE_ALARM)
    assert_agrees(result["bottom"].flux_out, exact.transmitted, FALSE_ALARM)


@pytest.mark.parametrize("name", ["analog", "weighted", "forced", "split"])
def test_a_half_space_behind_a_boundary(name):
    """E.giovanelli: index 1.5, albedo 0.9: 0.2599186 with the specular 0.04."""
    milk = tp.Medium(absorption=0.1, scattering=0.9, index=1.5)
    beam = tp.Source(tp.Point(position=(0, 0, 1)), tp.Beam((0, 0, -1), power=1.0))
    face = tp.Surface(tp.Plane(), tp.Dielectric(1.5), "face", inside=milk)
    above = tp.Detector(tp.Plane(center=(0, 0, 2)), "above", side="back")
    tracking = TRACKINGS[name]
    if name == "split":
        tracking = tp.Tracking(splitting=splitting(10, start=(0, 0, -5), end=(0, 0, 0)))
    result = run(tp.Scene(beam, face, [above]), tracking)
    assert_agrees(result["above"].flux_in, 0.2599185699177473, FALSE_ALARM)
    assert_rejects(result["above"].flux_in, 0.2599185699177473 - 0.04)


def test_weights_that_forget_what_did_not_collide_would_be_seen():
    """Planted: a forced collision that keeps the whole weight would return 1/(1 - exp(-tau)) times as much."""
    tau = 0.1
    exact = ordinates.slab(tau, 0.5)
    returned = run(slab(tau, 0.5), TRACKINGS["forced"])["top"].flux_out
    assert_agrees(returned, exact.reflected, FALSE_ALARM)
    assert_rejects(returned, exact.reflected / -math.expm1(-tau))
    assert_rejects(returned, exact.reflected * 1.05)


def test_forced_collisions_do_not_go_with_splitting():
    with pytest.raises(tp.SceneError, match="forced cannot be combined with splitting"):
        tp.Tracking(forced=True, splitting=splitting(4))
