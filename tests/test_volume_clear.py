"""What does not absorb shows nothing absorbed, next to what does: rounding leaves ends of flights in neighbouring cells."""

from __future__ import annotations

import numpy as np
import pytest

import transport as tp

T, M = tp.Transparent(), tp.Medium
LAMP = tp.Source(tp.Disk(center=(0, 0, 1.5), normal=(0, 0, -1), radius=0.6), tp.Lambertian(power=1.0))
DARK, CLEAR = M(absorption=1.0, scattering=2.0), M(scattering=7.0)


def filled(shape, medium, name):
    return tp.Surface(shape, T, name, inside=medium)


SCENE = [
    filled(tp.Sphere(radius=1.0), DARK, "outer"),
    filled(tp.Sphere(center=(0.2, 0.1, 0), radius=0.35), CLEAR, "ball"),
    filled(tp.Box(center=(-0.4, -0.2, 0.1), size=(0.3, 0.4, 0.5)), CLEAR, "box"),
]


def read(detectors, surfaces=SCENE, tracking=None, medium=None):
    scene = tp.Scene(LAMP, surfaces, detectors, medium=medium)
    return tp.simulate(scene, particles=50_000, seed=1, threads=1, progress=False, tracking=tracking)


@pytest.mark.parametrize("tracking", ["weighted", "analog"])
def test_bodies_that_only_scatter_absorb_exactly_nothing(tracking):
    """Rounding alone would leave 1e-18 W with an error of a fiftieth of that."""
    detectors = [
        tp.VolumeDetector("ball", "whole"),
        tp.VolumeDetector("ball", "shells", cells=3),
        tp.VolumeDetector("box", "brick"),
        tp.VolumeDetector("box", "voxels", cells=(2, 1, 2)),
        tp.VolumeDetector(tp.Box(center=(0.2, 0.1, 0), size=0.3), "within"),
        tp.VolumeDetector("box", "struck", estimator="collision"),
    ]
    result = read(detectors, tracking=tracking)
    for detector in detectors:
        reading = result[detector.name]
        for quantity in (reading.absorbed_power, reading.absorbed_density):
            assert np.all(quantity.value == 0) and np.all(quantity.error == 0)
        assert np.all(reading.fluence_rate.value > 0)


def test_cells_that_only_scatter_absorb_nothing_beside_cells_that_do():
    """Cells end where the medium does: of a box of boxes, of shells about a core, of voxels of a Grid."""
    halves = [
        filled(tp.Box(center=(0, 0, z), size=(1, 1, 0.5)), medium, name)
        for z, medium, name in ((0.25, CLEAR, "upper"), (-0.25, DARK, "lower"))
    ]
    layers = read(tp.VolumeDetector(tp.Box(size=1.0), "box", (2, 1, 2)), halves)["box"].absorbed_power.value
    assert (layers[..., 1] == 0).all() and (layers[..., 0] > 1e-3).all()

    core = [
        filled(tp.Sphere(radius=0.9), CLEAR, "shell"),
        filled(tp.Sphere(radius=0.4), DARK, "core"),
    ]
    shells = read(tp.VolumeDetector("shell", "shells", (0, 0.4, 0.9)), core)["shells"].absorbed_power.value
    assert shells[0] > 1e-3 and shells[1] == 0

    voxels = np.zeros((3, 2, 4))
    voxels[1] = 2.0
    grid = tp.Grid(box=tp.Box(size=1.0), absorption=voxels, scattering=1.0)
    cells = read(tp.VolumeDetector(grid.box, "cells", (3, 2, 4)), [filled(grid.box, grid, "grid")])
    found = cells["cells"].absorbed_power.value
    assert (found[[0, 2]] == 0).all() and (found[1] > 1e-5).all()


def test_what_absorbs_a_little_is_not_taken_for_nothing():
    """A billionth of what its neighbour absorbs, in the body, in a cell that holds a part of it, and all around."""
    faint = M(absorption=1e-9, scattering=7.0)
    surfaces = [SCENE[0], filled(SCENE[1].shape, faint, "ball"), SCENE[2]]
    result = read([tp.VolumeDetector("ball", "ball"), tp.VolumeDetector("ball", "shells", 2)], surfaces)
    for name in ("ball", "shells"):
        reading = result[name]
        expected = 1e-9 * reading.fluence_rate.value * reading.volumes
        np.testing.assert_allclose(reading.absorbed_power.value, expected, rtol=1e-6)
    speck = filled(tp.Sphere(center=(0.2, 0.1, 0.3), radius=1e-3), M(absorption=5.0), "speck")
    half = tp.VolumeDetector(tp.Box(center=(-0.4, -0.2, 0.1), size=(0.3, 0.4, 0.51)), "half")
    around = tp.VolumeDetector("ball", "ball"), tp.VolumeDetector("box", "box"), half
    result = read(around, [SCENE[1], SCENE[2], speck], medium=M(absorption=0.1))
    assert 0 < result["ball"].absorbed_power.value < 1e-4
    assert result["box"].absorbed_power.value == 0 and result["half"].absorbed_power.value > 1e-6


def test_a_body_of_open_surfaces_or_of_facets_counts_wherever_it_may_lie():
    """Of these nothing is sure but the box about them: what they absorb stays."""
    mesh = filled(tp.Mesh.sphere(radius=0.5, triangles=320), DARK, "mesh")
    result = read(tp.VolumeDetector(tp.Box(size=0.4), "in it"), [mesh])
    assert result["in it"].absorbed_power.value > 1e-3
