"""A room with one of each thing, by which the figures are shown: lamp, walls, a mirror ball, glass, fog, and what looks at them."""

from __future__ import annotations

import transport as tp

LAMP = tp.Disk(center=(0.2, 0.1, 2.4), normal=(0, 0, -1), radius=0.22)
FLOOR = tp.Rectangle(width=3.2, height=2.4)
BACK = tp.Rectangle(center=(0, 1.2, 1.25), normal=(0, -1, 0), width=3.2, height=2.5)
SIDE = tp.Rectangle(center=(-1.6, 0, 1.25), normal=(1, 0, 0), width=2.5, height=2.4)  # its e_u points down
MIRROR_BALL = tp.Sphere(center=(-0.85, 0.3, 0.4), radius=0.38)
GLASS_BALL = tp.Sphere(center=(0.15, -0.35, 0.62), radius=0.3)
FOG = tp.Box(center=(1.0, 0.3, 0.45), size=(0.8, 0.8, 0.85))
MIST = tp.Medium(absorption=0.15, scattering=1.8, phase=tp.HenyeyGreenstein(0.6))
GLASS = tp.Medium(absorption=0.3, index=1.5)
PATCH = tp.Rectangle(center=(0.0, 0.45, 0.02), width=0.3, height=0.3)
SLICE = tp.Box(center=(0, 0.3, 1.25), size=(3.2, 0.1, 2.3))  # through mirror ball and fog


METERS, EYES = "meters", "eyes"  # what looks at the room
PLATE = tp.Rectangle(width=1.0, height=1.0)
SLANT = (0.7071067811865476, 0.0, -0.7071067811865476)  # where the beam goes, 45 degrees to the plate


def showroom(looks: str = METERS, power: float = 100.0) -> tp.Scene:
    """The room, lit by a lamp of that power [W].

    looks: with "meters" by place, by direction and by cell; or with "eyes", a camera and a map of all directions.
    """
    return tp.Scene(
        sources=[tp.Source(LAMP, tp.Lambertian(power=power))],
        surfaces=[
            tp.Surface(FLOOR, tp.Diffuse(0.6), "floor"),
            tp.Surface(BACK, tp.Diffuse(0.8), "back wall"),
            tp.Surface(SIDE, tp.Diffuse(0.4), "side wall"),
            tp.Surface(MIRROR_BALL, tp.Mirror(0.9), "mirror ball"),
            tp.Surface(GLASS_BALL, tp.Dielectric(index_inside=1.5), "glass ball", inside=GLASS),
            tp.Surface(FOG, tp.Transparent(), "fog", inside=MIST),
        ],
        detectors={METERS: _meters, EYES: _eyes}[looks](),
    )


def _meters() -> list:
    return [
        tp.Detector("floor", positions=tp.Positions(u=64, v=48)),
        tp.Detector("back wall", positions=tp.Positions(u=32, v=25)),
        tp.Detector("side wall", positions=tp.Positions(u=25, v=24)),
        tp.Detector("mirror ball", positions=tp.Positions(u=24, v=48)),
        tp.Detector(PATCH, "sky", directions=tp.Directions(theta=18, phi=36)),
        tp.VolumeDetector(SLICE, "slice", cells=(64, 1, 46)),
    ]


def _eyes() -> list:
    eye = {"position": (0.4, -2.9, 1.35), "look_at": (-0.05, 0, 0.85), "field_of_view": 1.0}
    return [
        tp.Camera(name="view", pixels=(168, 126), **eye),
        tp.EnvironmentMap(name="around", position=(0.2, 0.3, 1.1), theta=60, phi=120),
    ]


def glossy_plate(roughness: float = 0.25) -> tp.Scene:
    """A plate of gloss of that roughness in a beam of 1 W from 45 degrees, and what leaves it by direction."""
    middle = tuple(-1.2 * way for way in SLANT)
    lamp = tp.Disk(center=middle, normal=SLANT, radius=0.12)
    return tp.Scene(
        sources=[tp.Source(lamp, tp.Beam(SLANT, power=1.0))],
        surfaces=[tp.Surface(PLATE, tp.Glossy(roughness=roughness, albedo=0.9), "plate")],
        detectors=[tp.Detector("plate", directions=tp.Directions(theta=30, phi=60))],
    )
