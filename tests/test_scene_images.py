"""Four pictures of scenes against pictures that were looked at (tests/images), by the differences that pyvista allows.

Bins are few and particles many, so that no noise is seen.  New ones: pytest tests/test_scene_images.py --reset_image_cache
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from transport.viz.screen import has_screen

pytest.importorskip("pytest_pyvista")
WINDOW = (480, 320)


@pytest.fixture
def check(verify_image_cache):
    if not has_screen():
        pytest.skip("no libraries of OpenGL here")
    from transport.viz.scene_view import scene_plotter

    def drawn(scene, particles, tracks=0, finish=lambda plotter, result: None):
        result = tp.simulate(scene, particles=particles, seed=1, batches=4) if particles else None
        ways = tp.tracks(scene, particles=tracks) if tracks else None
        plotter = scene_plotter(scene, result, ways, window_size=WINDOW)
        finish(plotter, result)
        plotter.show()

    return drawn


def test_scene_room(check):
    """A closed room seen into: the walls before the camera are looked through; a mirror ball, a glass one, a lamp."""
    box = tp.Box(size=(4, 3, 2))
    walls = [tp.Surface(face, tp.Diffuse(0.6), name) for name, face in box.faces().items()]
    balls = [
        tp.Surface(tp.Sphere(center=(0.9, 0.4, -0.6), radius=0.4), tp.Mirror(0.9), "mirror"),
        tp.Surface(tp.Sphere(center=(-0.8, -0.4, -0.5), radius=0.35), tp.Dielectric(1.5), "glass"),
    ]
    lamp = tp.Source(
        tp.Rectangle(center=(0, 0, 0.95), normal=(0, 0, -1), width=1, height=1), tp.Lambertian(power=10.0)
    )
    looks = [
        tp.Detector(name, side="back", positions=tp.Positions(u=6, v=6))
        for name in ("-z", "+y", "-x", "+x", "-y")
    ]
    check(tp.Scene(lamp, walls + balls, looks), particles=200_000)


def test_scene_maps(check):
    """Maps by place on a cylinder, a zone of a sphere and a tilted floor, lit by a point from one side."""
    lamp = tp.Source(tp.Point(position=(-2.0, -2.5, 3.0)), tp.Isotropic(power=100.0))
    floor = tp.Rectangle(normal=(0, -0.2, 1), width=5, height=4, up=(0.3, 1, 0))
    pipe = tp.Cylinder(center=(1, 0.5, 1.4), axis=(1, 0.3, 0.2), radius=0.4, height=2)
    cap = tp.Sphere(center=(-0.8, 0.2, 1.0), radius=0.7, axis=(0, 0, 1), mu_min=-0.2)
    surfaces = [
        tp.Surface(floor, tp.Black(), "floor"),
        tp.Surface(pipe, tp.Black(), "pipe"),
        tp.Surface(cap, tp.Black(), "cap"),
    ]
    looks = [tp.Detector(name, positions=tp.Positions(u=8, v=12)) for name in ("floor", "pipe", "cap")]
    check(tp.Scene(lamp, surfaces, looks), particles=2_000_000)


def test_scene_fog(check):
    """Voxels and a body of fog as translucent volumes, a beam as a glowing dot, flights by weight."""
    x, y, z = np.indices((12, 12, 12)) - 5.5
    cloud = np.where(x**2 + y**2 + 2 * z**2 < 25, 4.0, 0.0)
    grid = tp.Grid(box=tp.Box(size=2.0), scattering=0.8 * cloud, absorption=0.2 * cloud)
    fog = tp.Medium(scattering=1.0, absorption=0.3, emission=0.1)
    ball = tp.Sphere(center=(2.2, 0, 0), radius=0.8)
    surfaces = [
        tp.Surface(grid.box, tp.Transparent(), "cloud", inside=grid),
        tp.Surface(ball, tp.Transparent(), "ball", inside=fog),
    ]
    beam = tp.Source(tp.Point(position=(-2.0, 0.2, 0.1)), tp.Beam((1, 0, 0), power=1.0))
    check(tp.Scene(beam, surfaces), particles=0, tracks=12)


def test_scene_lobe(check):
    """A lobe of radiance on a patch points at the lamp; few tracks; a detector's name and number."""
    from transport.viz.lobes_in_place import add_lobe

    lamp = tp.Disk(center=(0.8, 0, 1.5), normal=(0, 0, -1), radius=0.4)
    patch = tp.Disk(center=(-0.5, 0, 0), radius=0.3)
    look = tp.Detector(
        patch, "patch", directions=tp.Directions(theta=np.linspace(0, math.pi / 2, 10), phi=18)
    )
    scene = tp.Scene(tp.Source(lamp, tp.Lambertian(radiance=10.0), aim=patch), detectors=look)
    check(
        scene, 500_000, tracks=10, finish=lambda plotter, result: add_lobe(plotter, result["patch"], size=1.0)
    )
