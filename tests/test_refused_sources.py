"""Sources and pulses that cannot be are refused when made, with object, parameter and value named."""

import math

import pytest

from tests.refusals import BALL, CUBE, DISK, DRIFTING, FLASH, GAS, INSTANT, assert_refused
from transport.geometry.flat import Triangle
from transport.geometry.shape import Cloud, Point
from transport.scene.emissions import Beam, Effusive, Gas, Isotropic, Lambertian
from transport.scene.pulses import BoxPulse, GaussianPulse, Instant
from transport.scene.sources import Source
from transport.scene.speeds import Maxwellian

REFUSALS = {
    # sources
    "source shape": (lambda: Source(3, Lambertian(power=1)), ["Source: shape", "got 3"]),
    "emission": (lambda: Source(DISK, Lambertian), ["Source: emission", "Lambertian(radiance=...)"]),
    "lambertian point": (
        lambda: Source(Point(), Lambertian(power=1)),
        ["Source", "Lambertian", "Point(", "Isotropic"],
    ),
    "isotropic disk": (
        lambda: Source(DISK, Isotropic(power=1)),
        ["Source", "Isotropic", "Disk(", "Lambertian"],
    ),
    "gas disk": (lambda: Source(DISK, Gas(1, 1)), ["Source", "Gas leaves from a Box", "Disk("]),
    "side": (
        lambda: Source(DISK, Lambertian(power=1), side="bak"),
        ["Source: side", "'bak'", "did you mean 'back'"],
    ),
    "side type": (lambda: Source(DISK, Lambertian(power=1), side=1), ["Source: side", "got 1"]),
    "inside flat": (
        lambda: Source(DISK, Lambertian(power=1), side="inside"),
        ["Source: side", "'inside'", "'back'"],
    ),
    "outside flat": (lambda: Source(DISK, Lambertian(power=1), side="outside"), ["Source: side", "'front'"]),
    "side of gas": (
        lambda: Source(CUBE, Gas(1, 1), side="back"),
        ["Source: side", "Gas", "'back'", "leave it out"],
    ),
    "side of point": (
        lambda: Source(Point(), Beam((0, 0, 1), power=1), side="back"),
        ["Source: side", "Point"],
    ),
    "aim type": (lambda: Source(DISK, Lambertian(power=1), aim="lid"), ["Source: aim", "a shape", "'lid'"]),
    "aim point": (lambda: Source(DISK, Lambertian(power=1), aim=Point()), ["Source: aim", "Point("]),
    "aim beam": (
        lambda: Source(DISK, Beam((0, 0, 1), power=1), aim=BALL),
        ["Source: aim", "Beam", "drop aim"],
    ),
    "aim gas": (lambda: Source(CUBE, Gas(1, 1), aim=BALL), ["Source: aim", "Gas", "drop aim"]),
    "beam irradiance": (
        lambda: Source(Point(), Beam((0, 0, 1), irradiance=7)),
        ["Source: irradiance", "7.0", "write power="],
    ),
    "beam inwards": (
        lambda: Source(DISK, Beam((0, 0, -1), power=1)),
        ["Source: direction", "-1.0", "side='back'"],
    ),
    "beam from back": (
        lambda: Source(DISK, Beam((0, 0, 1), power=1), side="back"),
        ["Source: direction", "(0.0, 0.0, 1.0)", "side='front'"],
    ),
    "beam along": (
        lambda: Source(DISK, Beam((1, 0, math.cos(math.pi / 2)), power=1)),
        ["Source: direction", "plane of the Disk", "(1.0, 0.0", "tilt"],
    ),
    "power overflows": (lambda: Source(BALL, Lambertian(radiance=1e308)), ["Source: power", "finite", "inf"]),
    # sources and pulses
    "density in a point": (lambda: Source(Point(), Gas(1, 1)), ["Source: density", "Point", "number="]),
    "density in a flat cloud": (
        lambda: Source(Cloud(sigma=(0, 1, 1)), Gas(1, 1)),
        ["Source: density", "Cloud", "number="],
    ),
    "cloud of light": (
        lambda: Source(Cloud(sigma=1), Isotropic(power=1)),
        ["Isotropic leaves from", "Cloud("],
    ),
    "effusive point": (lambda: Source(Point(), Effusive(1, 5)), ["Effusive leaves from", "Point(", "Gas"]),
    "drift on a ball": (
        lambda: Source(BALL, Effusive(1, DRIFTING)),
        ["Source: drift", "flat", "Sphere", "31.0"],
    ),
    "drift on a box": (lambda: Source(CUBE, Effusive(1, DRIFTING)), ["Source: drift", "flat", "Box"]),
    "drift too fast": (
        lambda: Source(DISK, Effusive(1, DRIFTING)),
        ["Maxwellian: drift", "30 sigma", "31 m/s"],
    ),
    "drift too fast away": (
        lambda: Source(DISK, Effusive(number=1, speed=DRIFTING), side="back"),
        ["Maxwellian: drift", "-31 m/s"],
    ),
    "triangle of gas": (
        lambda: Source(Triangle(vertices=((0, 0, 0), (1, 0, 0), (0, 1, 0))), Gas(1, 1)),
        ["Source", "Gas leaves from a Box", "Triangle(", "enclose it in a Box"],
    ),
    "aim drift": (
        lambda: Source(DISK, Effusive(1, Maxwellian(sigma=1, drift=(1, 0, 0))), aim=BALL),
        ["Source: aim", "drift", "leave one of them out"],
    ),
    "aim cloud": (lambda: Source(DISK, Lambertian(power=1), aim=Cloud(sigma=1)), ["Source: aim", "Cloud("]),
    "pulse type": (
        lambda: Source(Point(), FLASH, pulse=0.5),
        ["Source: pulse", "a pulse such as", "got 0.5"],
    ),
    "pulse of a gas": (lambda: Source(CUBE, Gas(1, 1), pulse=INSTANT), ["Source: pulse", "Gas", "drop it"]),
    "power at an instant": (
        lambda: Source(Point(), Isotropic(power=5), pulse=INSTANT),
        ["Source: pulse Instant", "energy=...", "power=5.0", "BoxPulse"],
    ),
    "density at an instant": (
        lambda: Source(DISK, Effusive(1, 5), pulse=GaussianPulse(9, 1)),
        ["Source: pulse GaussianPulse", "number=...", "density=1.0"],
    ),
    "energy without clock": (
        lambda: Source(Point(), FLASH).check_clock(None),
        ["Scene: duration", "Isotropic(energy=...)", "None", "duration=..."],
    ),
    "number without clock": (
        lambda: Source(DISK, Effusive(number=1, speed=5)).check_clock(None),
        ["Scene: duration", "Effusive(number=...)"],
    ),
    "gas without clock": (lambda: GAS.check_clock(None), ["Scene: duration", "a Gas", "None"]),
    "pulse without clock": (
        lambda: Source(Point(), Isotropic(power=1), pulse=BoxPulse(0, 1)).check_clock(None),
        ["Scene: duration", "BoxPulse(", "None"],
    ),
    "pulse after the end": (
        lambda: Source(Point(), FLASH, pulse=INSTANT).check_clock(0.5),
        ["Source: pulse", "0.5 s", "Instant", "longer"],
    ),
    "pulse over the end": (
        lambda: Source(Point(), FLASH, pulse=BoxPulse(0, 1)).check_clock(0.75),
        ["Source: pulse", "0.75 s", "from 0 to 1 s"],
    ),
    "bell over the end": (
        lambda: Source(Point(), FLASH, pulse=GaussianPulse(1, 0.1)).check_clock(1.5),
        ["Source: pulse", "1.5 s", "to 1.85 s"],
    ),
    "instant": (lambda: Instant(-1), ["Instant: time", "zero or positive", "-1"]),
    "box pulse": (lambda: BoxPulse(2, 1), ["BoxPulse: stop", "after start=2.0", "got 1.0"]),
    "box pulse start": (lambda: BoxPulse(-1, 1), ["BoxPulse: start", "-1"]),
    "bell before 0": (
        lambda: GaussianPulse(1, 1),
        ["GaussianPulse: time", "8.5 sigma", "got 1.0", "time=8.5"],
    ),
    "bell sigma": (lambda: GaussianPulse(1, 0), ["GaussianPulse: sigma", "positive", "got 0"]),
    "cloud of no size": (lambda: Cloud(sigma=(0, 0, 0)), ["Cloud: sigma", "not all 0", "Point"]),
    "cloud of two": (lambda: Cloud(sigma=(1, 2)), ["Cloud: sigma", "one or three", "(1, 2)"]),
    "cloud sign": (lambda: Cloud(sigma=(1, -2, 1)), ["Cloud: sigma", "(1, -2, 1)"]),
}


@pytest.mark.parametrize(("make", "words"), REFUSALS.values(), ids=REFUSALS)
def test_a_wrong_source_is_refused_with_object_parameter_value_and_cure(make, words):
    assert_refused(make, words)
