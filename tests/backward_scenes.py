"""Scenes that are run both ways, and what of them is compared: the same detector, by what arrives at it."""

from __future__ import annotations

import math

import numpy as np

import transport as tp

LOOK = tp.Directions(mu=(0.0, 0.7, 1.0), phi=3)


def occluded():
    """A disk towards a tilted disk, with a grey one in between; bins of place and direction."""
    sheet = tp.Disk(center=(0.3, 0.0, 1.0), normal=(0.2, 0.1, -1.0), radius=0.5)
    blocker = tp.Surface(tp.Disk(center=(0.2, 0.1, 0.5), radius=0.2), tp.Diffuse(0.6))
    detector = tp.Detector(sheet, name="meter", directions=LOOK, positions=tp.Positions(u=2, v=2))
    return tp.Scene([tp.Source(tp.Disk(radius=0.7), tp.Lambertian(radiance=10.0))], [blocker], [detector])


def behind():
    """The back of a rectangle with bins of place, and of the world's directions."""
    shape = tp.Rectangle(center=(0.1, 0.2, 0.8), normal=(0.1, 0.0, 1.0), width=0.6, height=0.4)
    world = tp.Directions(theta=(math.pi / 2, 2.4, math.pi), phi=3, frame="world")
    places = tp.Positions(u=2, v=2)
    detectors = [
        tp.Detector(shape, name="meter", side="back", directions=world, positions=places),
        tp.Detector(shape, name="local", side="back", directions=LOOK, positions=places),
    ]
    return tp.Scene([tp.Source(tp.Disk(radius=0.7), tp.Lambertian(radiance=10.0))], (), detectors)


def diffuse_box():
    """A closed grey box lit from a patch of its ceiling, metered on its floor and on one side of a screen in it."""
    box = tp.Box(size=(1.0, 1.2, 0.8))
    lamp = tp.Rectangle(center=(0.1, 0.0, 0.4), normal=(0, 0, -1), width=0.3, height=0.3)
    screen = tp.Surface(
        tp.Rectangle(center=(0.2, 0, 0), normal=(1, 0, 0), width=0.4, height=0.4),
        tp.TwoSided(front=tp.Diffuse(0.3, transmission=0.2), back=tp.Diffuse(0.7, transmission=0.2)),
        name="screen",
    )
    patch = tp.Rectangle(center=(0.0, 0.1, -0.4), normal=(0, 0, 1), width=0.3, height=0.3)
    detectors = [tp.Detector(patch, name="floor", directions=LOOK), tp.Detector("screen", side="back")]
    walls = tp.Surface(box, tp.Diffuse(0.7), name="walls")
    return tp.Scene([tp.Source(lamp, tp.Lambertian(power=3.0))], [walls, screen], detectors)


def mirrors():
    """A lamp seen by way of a half mirror and a glossy sheet, by a small ball."""
    surfaces = [
        tp.Surface(tp.Rectangle(center=(0, 0, 0), width=2, height=2), tp.Glossy(0.3, albedo=0.9)),
        tp.Surface(
            tp.Rectangle(center=(0.8, 0, 0.6), normal=(-1, 0, 0.3), width=1, height=1), tp.Mirror(0.5, 0.3)
        ),
    ]
    lamp = tp.Source(
        tp.Disk(center=(-0.5, 0, 0.7), normal=(1, 0, -0.8), radius=0.3), tp.Lambertian(radiance=5.0)
    )
    ball = tp.Sphere(center=(0.3, 0.1, 0.5), radius=0.15)
    return tp.Scene([lamp], surfaces, [tp.Detector(ball, name="ball", directions=LOOK)])


def glass_ball():
    """From a lamp outside into a ball of glass: eta^2 between source and detector, within and on the ball."""
    ball = tp.Surface(tp.Sphere(radius=0.5), tp.Dielectric(1.6), name="glass")
    lamp = tp.Source(tp.Disk(center=(0, 0, -1), radius=0.6), tp.Lambertian(radiance=2.0))
    inner = tp.Disk(center=(0.05, 0, 0.1), normal=(0, 0, -1), radius=0.2)
    outer = tp.Disk(center=(0.0, 0, 0.9), normal=(0, 0, -1), radius=0.3)
    detectors = [tp.Detector(inner, name="within"), tp.Detector(outer, name="behind", directions=LOOK)]
    return tp.Scene([lamp], [ball], detectors)


def glowing_glass():
    """A ball of glass that glows, seen from outside: the other way through."""
    glass = tp.Medium(absorption=1.5, emission=4.0, index=1.5)
    ball = tp.Surface(tp.Sphere(radius=0.5), tp.Dielectric(1.5), name="glass", inside=glass)
    meter = tp.Disk(center=(0, 0.2, 0.8), normal=(0, 0, -1), radius=0.3)
    return tp.Scene((), [ball], [tp.Detector(meter, name="meter", directions=LOOK)])


def fog(phase=None):
    """A slab of fog between lamp and meter, and a cloud that emits beside them."""
    medium = tp.Medium(absorption=0.4, scattering=2.0, phase=tp.Isotropic() if phase is None else phase)
    body = tp.Surface(tp.Box(center=(0, 0, 0.5), size=(2, 2, 0.5)), tp.Transparent(), inside=medium)
    lamp = tp.Source(tp.Disk(radius=0.3), tp.Lambertian(radiance=10.0))
    cloud = tp.Source(tp.Sphere(center=(0.6, 0, 1.0), radius=0.15), tp.Isotropic(power=3.0))
    meter = tp.Detector(
        tp.Disk(center=(0, 0, 1.0), normal=(0, 0, -1), radius=0.25), name="meter", directions=LOOK
    )
    side = tp.Detector(tp.Disk(center=(0, 0, 1.1), normal=(1, 0, 0.2), radius=0.25), name="side")
    return tp.Scene([lamp, cloud], [body], [meter, side])


def forward_fog():
    """The same fog, scattering forwards."""
    return fog(tp.HenyeyGreenstein(0.7))


def voxels():
    """Smoke of voxels, and a lamp that fills a box in clear air."""
    scattering = 3.0 * (1 + np.arange(8).reshape(2, 2, 2)) / 8
    grid = tp.Grid(
        box=tp.Box(center=(0, 0, 0.5), size=(1, 1, 0.5)),
        scattering=scattering,
        absorption=0.3 + 0 * scattering,
    )
    body = tp.Surface(grid.box, tp.Transparent(), inside=grid)
    lamp = tp.Source(tp.Box(center=(0, 0, -0.1), size=(0.6, 0.4, 0.2)), tp.Isotropic(power=3.0))
    meter = tp.Detector(
        tp.Disk(center=(0, 0, 1.0), normal=(0, 0, -1), radius=0.25), name="meter", directions=LOOK
    )
    return tp.Scene([lamp], [body], [meter])


SCENES = {
    scene.__name__: scene
    for scene in (occluded, behind, diffuse_box, mirrors, glass_ball, glowing_glass, fog, forward_fog, voxels)
}
