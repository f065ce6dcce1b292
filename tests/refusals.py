"""Objects to refuse wrong ones with, and what a refusal must say."""

import pytest

from transport.geometry.flat import Disk, Rectangle
from transport.geometry.solid import Box, Sphere
from transport.scene.detectors import Detector
from transport.scene.emissions import Gas, Isotropic, Lambertian
from transport.scene.materials import Black, Surface
from transport.scene.phase_space import PhaseSpace
from transport.scene.pulses import Instant
from transport.scene.sources import Source
from transport.scene.speeds import Maxwellian, SpeedTable
from transport.validation import SceneError

DISK, BALL, CUBE = Disk(radius=1), Sphere(radius=2), Box(size=(1, 2, 3))
SHEET = Rectangle(width=2, height=4)
LAMP = Source(DISK, Lambertian(power=1))
GAS = Source(CUBE, Gas(1e20, 500))
WALL = Surface(DISK, Black(), name="floor")
EDGES, CORNERS = (0, 1, 2), [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
WARM, DRIFTING = Maxwellian(temperature=300, mass=4.65e-26), Maxwellian(sigma=1, drift=(0, 0, 31))
SIGNED = SpeedTable((-1, 1), (1, 1))
INSTANT, FLASH = Instant(0.5), Isotropic(energy=1)


def meter(**how):
    return Detector(DISK, name="lid", **how)


def cloud(**how):
    return PhaseSpace(**{"time": 1, "name": "cloud"} | how)


def assert_refused(make, words):
    """It is refused, and the message holds all these words: object, parameter, value, cure."""
    with pytest.raises(SceneError) as caught:
        make()
    message = str(caught.value)
    assert [word for word in words if word not in message] == [], message
