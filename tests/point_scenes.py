"""What point detectors look at in tests: a lamp, fog, filled bodies; and how their readings are asked for."""

from __future__ import annotations

import math

import pytest

import transport as tp

T, M, V = tp.Transparent(), tp.Medium, tp.Vacuum()
LAMP = tp.Source(tp.Point(position=(0, 0, 0)), tp.Isotropic(power=2.0))
FOG = M(absorption=0.1, scattering=0.9)


def filled(shape, medium, material=T):
    return tp.Surface(shape, material, inside=medium)


def seen(sources, places, surfaces=(), particles=1000, seed=1, tracking=None, extra=(), **options):
    """Readings at these places, as they are named by their number; the result last."""
    points = [tp.PointDetector(place, f"p{k}") for k, place in enumerate(places)]
    scene = tp.Scene(sources, surfaces, [*points, *extra], **options)
    result = tp.simulate(scene, particles=particles, seed=seed, threads=1, progress=False, tracking=tracking)
    return *(result[point.name].fluence_rate for point in points), result


def straight(distance, depth=0.0, power=2.0):
    """From a point source: power exp(-tau) / (4 pi r^2)."""
    return power * math.exp(-depth) / (4 * math.pi * distance**2)


def assert_is(estimate, exact):
    assert estimate.exact
    assert estimate.value == pytest.approx(exact, rel=1e-12, abs=0)
