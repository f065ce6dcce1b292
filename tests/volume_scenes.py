"""What volume detectors look into in tests: uniform light, a ball of fog, a beam that fades; and the judges."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees

FALSE_ALARM = 1e-5
BOX, BALL = (
    tp.Box(size=(1.0, 2.0, 0.5), center=(0.1, 0.0, 0.3)),
    tp.Sphere(radius=0.8, center=(0.0, 0.2, 0.0)),
)
ALL_ROUND = tp.Source(
    tp.Sphere(radius=2.0), tp.Lambertian(radiance=1.0), side="back"
)  # L = 1 everywhere within
FOG = tp.Medium(absorption=0.7, scattering=2.0, phase=tp.HenyeyGreenstein(0.5))
sphere = tp.Directions.sphere


def run(scene, particles=100_000, **options):
    return tp.simulate(scene, particles=particles, seed=1, threads=1, progress=False, **options)


def body(shape, medium, name="body"):
    return tp.Surface(shape, tp.Transparent(), name, inside=medium)


def whole(cells, volumes):
    """The mean over all cells."""
    return (cells * volumes).sum() / np.sum(volumes)


def rejects(estimate, wrong):
    with pytest.raises(AssertionError):
        assert_agrees(estimate, wrong, FALSE_ALARM)


@lru_cache
def lit():
    """Everything that looks at a field of radiance 1."""
    looks = [
        tp.VolumeDetector(BOX, "box"),
        tp.VolumeDetector(BOX, "voxels", (3, 4, 2)),
        tp.VolumeDetector(BALL, "ball"),
        tp.VolumeDetector(BALL, "shells", (4,)),
        tp.VolumeDetector(BALL, "hollow", (0.3, 0.31, 0.7)),
        tp.VolumeDetector(BOX, "ways", None, sphere(4, 3)),
        tp.VolumeDetector(
            BOX, "cells and ways", (1, 2, 1), sphere(mu=(-0.5, 0.1, 0.9), phi=(-1, 2), axis=(1, 2, 0))
        ),
        tp.VolumeDetector(BALL, "azimuth", (2,), sphere(mu=None, phi=4)),
    ]
    return run(tp.Scene(ALL_ROUND, [], looks), particles=400_000)


DEEP = tp.Box(size=(1.0, 1.0, 2.0))
FACE = tp.Rectangle(width=1.0, height=1.0, center=(0.0, 0.0, -1.5))
SIGMA = 1.3


def faded(edges):
    """Mean of exp(-SIGMA z) between depths."""
    return np.diff(-np.exp(-SIGMA * np.asarray(edges))) / SIGMA / np.diff(edges)


@lru_cache
def foggy(tracking):
    looks = [
        tp.VolumeDetector("body", "ways"),
        tp.VolumeDetector("body", "hits", estimator="collision"),
        tp.VolumeDetector("body", "shells", (5,)),
        tp.VolumeDetector(tp.Box(size=2.2), "voxels about it", (3, 4, 5)),
        tp.VolumeDetector("body", "directions", (2,), sphere(2, 3)),
    ]
    return run(tp.Scene(ALL_ROUND, [body(BALL, FOG)], looks), tracking=tracking)


TRACKINGS = {
    "analog": "analog",
    "weighted": "weighted",
    "forced": tp.Tracking(forced=True),
    "split": tp.Tracking(splitting=tp.Splitting(start=(0, 0, -1), end=(0, 0, 1), gain=10.0)),
}
