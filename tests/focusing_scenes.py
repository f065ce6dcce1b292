"""More scenes in which light reaches a small detector, "m", by specular surfaces: periscope, lens, prism, a glass of water.

The periscope is exact: two mirrors show the lamp at the whole length of the way, so that a small detector on the axis
sees a coaxial disk.  The others have stored runs; a lens of which a detector sees all of the aperture as bright as the
lamp has E = T pi L sin^2(theta) but for aberrations, and T = (1 - R)^2 at each of its faces.
"""

from __future__ import annotations

import math

import numpy as np

import transport as tp
from transport.theory import view_factors

RADIUS = 1e-3  # of detectors [m]
LAMP, POWER = 0.05, 100.0


def _disk_lamp(center, normal, radius, power):
    return tp.Source(tp.Disk(center=center, normal=normal, radius=radius), tp.Lambertian(power=power))


def periscope() -> tp.Scene:
    """Two mirrors at 45 degrees, and a black wall with a hole between them, 4 m from lamp to detector."""
    half = math.sqrt(0.5)
    lower = tp.Rectangle(center=(1, 0, 0), normal=(-half, 0, half), up=(0, 1, 0), width=0.4, height=0.4)
    upper = tp.Rectangle(center=(1, 0, 1), normal=(half, 0, -half), up=(0, 1, 0), width=0.4, height=0.4)
    hole = tp.Rectangle(center=(1, 0, 0.5), up=(0, 1, 0), width=0.4, height=0.4)
    wall = tp.Rectangle(center=(1, 0, 0.5), up=(0, 1, 0), width=10, height=10, hole=hole)
    mirrors = [tp.Surface(lower, tp.Mirror(0.9), "lower"), tp.Surface(upper, tp.Mirror(0.8), "upper")]
    return tp.Scene(
        [_disk_lamp((0, 0, 0), (1, 0, 0), LAMP, POWER)],
        [*mirrors, tp.Surface(wall, tp.Black(), "wall")],
        [tp.Detector(tp.Disk(center=(3, 0, 1), normal=(-1, 0, 0), radius=RADIUS), "m")],
    )


def by_periscope() -> float:
    """Irradiance [W m^-2]: 0.9 x 0.8 of that of a coaxial disk at 4 m."""
    seen = view_factors.coaxial_disks(RADIUS, LAMP, 4.0)
    return 0.9 * 0.8 * POWER / (math.pi * LAMP**2) * float(seen)


def lens() -> tp.Scene:
    """A biconvex lens of f = 10 cm and 6 cm across, which images a lamp of 2 mm on a detector of 1 mm, each 20 cm away."""
    bend, aperture = 0.1, 0.03
    height = math.sqrt(bend**2 - aperture**2)
    caps = [
        tp.Sphere(center=(0, 0, -side * height), radius=bend, axis=(0, 0, side), mu_min=height / bend)
        for side in (1, -1)
    ]
    return tp.Scene(
        [_disk_lamp((0, 0, 0.2), (0, 0, -1), 2e-3, 1.0)],
        [tp.Surface(cap, tp.Dielectric(1.5), f"cap {k}") for k, cap in enumerate(caps)],
        [tp.Detector(tp.Disk(center=(0, 0, -0.2), radius=RADIUS), "m")],
    )


def prism() -> tp.Scene:
    """An equilateral prism of glass at least deviation, between a lamp of 5 mm and a detector."""
    side, depth = 0.06, 0.06
    corners = [
        (side / math.sqrt(3) * math.cos(a), side / math.sqrt(3) * math.sin(a))
        for a in np.radians([90, 210, 330])
    ]
    vertices = [(x, y, z) for z in (-depth / 2, depth / 2) for x, y in corners]
    faces = [(0, 2, 1), (3, 4, 5), (0, 1, 4), (0, 4, 3), (1, 2, 5), (1, 5, 4), (2, 0, 3), (2, 3, 5)]
    glass = tp.Surface(tp.Mesh(vertices=vertices, faces=faces), tp.Dielectric(1.5), "prism")
    # At least deviation the ray inside is parallel to the base; outside it is turned by half the deviation.
    turn = math.asin(1.5 * math.sin(math.radians(30))) - math.radians(30)
    reach, height = 0.5, 0.0
    along = (math.cos(turn), -math.sin(turn))
    face = side / 4  # where the ray meets a face, from the axis
    lamp, meter = (
        ((-face - reach * along[0]), height + reach * along[1]),
        ((face + reach * along[0]), height + reach * along[1]),
    )
    return tp.Scene(
        [_disk_lamp((*lamp, 0), (along[0], -along[1], 0), 5e-3, 1.0)],
        [glass],
        [tp.Detector(tp.Disk(center=(*meter, 0), normal=(-along[0], -along[1], 0), radius=RADIUS), "m")],
    )


def glass_of_water() -> tp.Scene:
    """A tumbler of water on a white floor, lit from the side; the detector lies in the caustic on the floor."""
    outer, inner, tall, base = 0.035, 0.032, 0.1, 0.003

    def can(radius: float, low: float, high: float, material: tp.Dielectric, name: str) -> list[tp.Surface]:
        side = tp.Cylinder(center=(0, 0, (low + high) / 2), radius=radius, height=high - low)
        top = tp.Disk(center=(0, 0, high), normal=(0, 0, 1), radius=radius)
        bottom = tp.Disk(center=(0, 0, low), normal=(0, 0, -1), radius=radius)
        parts = (side, "side"), (top, "top"), (bottom, "bottom")
        return [tp.Surface(shape, material, f"{name} {part}") for shape, part in parts]

    lift = 0.001
    glass = can(outer, lift, lift + tall, tp.Dielectric(1.5), "glass")
    water = can(inner, lift + base, lift + tall - base, tp.Dielectric(1.33, 1.5), "water")
    floor = tp.Surface(tp.Rectangle(normal=(0, 0, 1), width=1, height=1), tp.Diffuse(0.8), "floor")
    place, to = np.array((0.3, 0.0, 0.25)), np.array((-0.3, 0.0, -0.2))
    return tp.Scene(
        [_disk_lamp(tuple(place.tolist()), tuple(to.tolist()), 0.01, 10.0)],
        [floor, *glass, *water],
        [tp.Detector(tp.Disk(center=(-0.06, 0, 5e-4), radius=RADIUS), "m")],
    )


SCENES = {"periscope": periscope, "lens": lens, "prism": prism, "glass of water": glass_of_water}
# Irradiance and its error [W m^-2].  Stored are backward runs of seed 20261127: guided, 1e7 histories, for which unguided ones of 6e7 gave
# 994.26 +- 1.11, 0.961 +- 0.015 and 161.32 +- 0.26; "expected" gave 992.5 +- 1.2 for the lens.
VALUES = {
    "periscope": lambda: (by_periscope(), 0.0),
    "lens": lambda: (992.67, 0.36),
    "prism": lambda: (0.9547, 0.0011),
    "glass of water": lambda: (161.016, 0.083),
}
