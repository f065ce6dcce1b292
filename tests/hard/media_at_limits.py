"""Beams, bodies and faces that tests of media at their limits share; runs have seed 1, must close and lose nothing."""

from __future__ import annotations

import math

import pytest

import transport as tp
from tests.agreement import assert_agrees

FALSE_ALARM = 1e-5
CLEAR = tp.Transparent()
R, T = 0.0973946386719247, 0.6609577001638116  # E.vandehulst_hg: tau 2, albedo 0.9, g 0.75, normal beam
DARK = tp.Medium(absorption=1.0)
FORCED = tp.Tracking(forced=True)


def beam(position, direction):
    return tp.Source(tp.Point(position=tuple(position)), tp.Beam(tuple(direction), power=1.0))


def body(shape, medium, name=None):
    return tp.Surface(shape, CLEAR, name, inside=medium)


def fog(tau, albedo, g=0.0, thickness=1.0):
    phase = tp.HenyeyGreenstein(g) if g else tp.Isotropic()
    sigma = tau / thickness
    return tp.Medium(absorption=(1 - albedo) * sigma, scattering=albedo * sigma, phase=phase)


def faces(thickness=1.0, center=(0.0, 0.0, 0.0)):
    """Meters a little above z = 0 and below z = -thickness."""
    x, y, z = center
    above, below = (x, y, z + 0.25 * thickness), (x, y, z - 1.25 * thickness)
    return [
        tp.Detector(tp.Plane(center=above), "above", side="back"),
        tp.Detector(tp.Plane(center=below), "below"),
    ]


def run(scene, tracking=None, particles=50_000):
    result = tp.simulate(scene, particles, seed=1, threads=1, tracking=tracking, progress=False)
    ledger = result.ledger
    parts = math.fsum(ledger[name].value for name in ledger if name != "emitted")
    assert parts == pytest.approx(ledger["emitted"].value, rel=1e-14)
    assert ledger["lost"].value == 0
    return result


def returned_and_passed(result):
    return result["above"].flux_in, result["below"].flux_in


def assert_is_van_de_hulst_s_slab(result):
    for estimate, exact in zip(returned_and_passed(result), (R, T), strict=True):
        assert_agrees(estimate, exact, FALSE_ALARM)


def absorbed(scene, tracking=None):
    """Of a beam or a few, which all of their histories share."""
    return run(scene, tracking, 64 * len(scene.sources)).ledger["absorbed"].value
