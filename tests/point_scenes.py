"""Scenes of point detectors: a lamp, fog, filled bodies, and the readings of points among them."""

from __future__ import annotations

import transport as tp

T, M, V = tp.Transparent(), tp.Medium, tp.Vacuum()
LAMP = tp.Source(tp.Point(position=(0, 0, 0)), tp.Isotropic(power=2.0))
FOG = M(absorption=0.1, scattering=0.9)


def filled(shape, medium, material=T):
    return tp.Surface(shape, material, inside=medium)


def seen(sources, places, surfaces=(), particles=1000, seed=1, tracking=None, extra=(), **options):
    """Fluence rates at these places, whose detectors are p0, p1, ...; the result last."""
    points = [tp.PointDetector(place, f"p{k}") for k, place in enumerate(places)]
    scene = tp.Scene(sources, surfaces, [*points, *extra], **options)
    result = tp.simulate(scene, particles=particles, seed=seed, threads=1, progress=False, tracking=tracking)
    return *(result[point.name].fluence_rate for point in points), result
