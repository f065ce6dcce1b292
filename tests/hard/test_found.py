"""What random scenes have found (`python -m tests.fuzz`), each as a case by itself."""

from __future__ import annotations

import warnings

import numpy as np

import transport as tp


def test_an_aim_behind_its_source_in_fog_is_told_without_a_number_that_is_none():
    """Nothing is born: the share of survivors that may be missing was 0/0."""
    box = tp.Box(center=(0, 0, 3), size=1.0)
    cells = np.array([[[1.0, 2.0]]])
    fog = tp.Surface(
        box, tp.Transparent(), "fog", inside=tp.Grid(box=box, absorption=cells, scattering=cells)
    )
    lamp = tp.Source(
        tp.Disk(radius=0.3), tp.Lambertian(power=1.0), aim=tp.Sphere(center=(0, 0, -2), radius=0.1)
    )
    scene = tp.Scene([lamp], [fog], [tp.Detector("fog")])
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        result = tp.simulate(scene, particles=500, seed=1, progress=False)
        report = result.report()
    assert "nothing is emitted towards the aim" in report
    assert "nan" not in report
