"""Detectors that cannot be are refused when made, with object, parameter and value named."""

import math

import numpy as np
import pytest

from tests.refusals import CUBE, DISK, LAMP, SHEET, WALL, assert_refused, meter
from transport.geometry.flat import Disk
from transport.geometry.shape import Cloud, Point
from transport.scene.bins import Directions, Positions
from transport.scene.detectors import Detector
from transport.scene.scene import Scene

REFUSALS = {
    # detectors
    "nameless": (lambda: Detector(DISK), ["Detector: name", "None", "name='detector'"]),
    "meter point": (lambda: Detector(Point(), name="lid"), ["Detector 'lid': shape", "Point("]),
    "meter inside flat": (
        lambda: Detector(DISK, name="lid", side="inside"),
        ["Detector 'lid': side", "'inside'"],
    ),
    "directions type": (
        lambda: Detector(DISK, name="lid", directions=8),
        ["Detector 'lid': directions", "got 8"],
    ),
    "positions type": (
        lambda: Detector(DISK, name="lid", positions=8),
        ["Detector 'lid': positions", "got 8"],
    ),
    "no directions": (lambda: Directions(), ["Directions", "mu, theta, phi", "none"]),
    "mu and theta": (lambda: Directions(mu=4, theta=2), ["Directions: mu and theta", "mu=4", "theta=2"]),
    "mu count": (lambda: Directions(mu=0), ["Directions: mu", "got 0"]),
    "mu many": (lambda: Directions(mu=10**12), ["Directions: mu", "1 000 000", "got 1000000000000"]),
    "mu float": (lambda: Directions(mu=8.0), ["Directions: mu", "got 8.0"]),
    "mu bool": (lambda: Directions(mu=True), ["Directions: mu", "True"]),
    "mu order": (lambda: Directions(mu=(0, 0.5, 0.5)), ["Directions: mu", "increasing", "(0, 0.5, 0.5)"]),
    "mu one edge": (lambda: Directions(mu=[0.5]), ["Directions: mu", "[0.5]"]),
    "mu nan": (lambda: Directions(mu=[0, math.nan]), ["Directions: mu", "nan"]),
    "mu range": (lambda: Directions(mu=(-0.5, 1)), ["Directions: mu", "[0.0, 1.0]", "(-0.5, 1.0)"]),
    "mu world range": (
        lambda: Directions(mu=(-2, 1), frame="world"),
        ["Directions: mu", "[-1.0, 1.0]", "-2.0"],
    ),
    "theta range": (lambda: Directions(theta=(0, 2)), ["Directions: theta", "2.0"]),
    "phi range": (lambda: Directions(phi=(-7, -1)), ["Directions: phi", "(-7.0, -1.0)"]),
    "phi over a turn": (
        lambda: Directions(phi=(-1, 0, 6)),
        ["Directions: phi", "one turn", "(-1.0, 0.0, 6.0)"],
    ),
    "bins in all": (
        lambda: Directions(mu=10_000, phi=np.linspace(0, 6, 2002)),
        [
            "Directions: mu x phi",
            "10000000",
            "got 20010000",
            "1.28 GB",
            "4.48 GB",
            "8 batches",
            "use fewer",
        ],
    ),
    "positions in all": (lambda: Positions(u=10_000, v=10_000), ["Positions: u x v", "got 100000000"]),
    "bins of a detector in all": (
        lambda: Detector(DISK, name="lid", directions=Directions(mu=4000), positions=Positions(u=10, v=1000)),
        ["Detector 'lid': u x v x mu", "got 40000000"],
    ),
    "vanishing bins": (lambda: Directions(mu=(0.5, 1, 1 + 4e-16)), ["Directions: mu", "vanish"]),
    "frame": (lambda: Directions(mu=1, frame="wold"), ["Directions: frame", "'wold'", "'world'"]),
    "half angle": (
        lambda: Directions.cone((0, 0, 1), 2),
        ["DirectionCone: half_angle", "(0, pi/2]", "got 2"],
    ),
    "half angle 0": (lambda: Directions.cone((0, 0, 1), 0), ["half_angle", "got 0"]),
    "cone without half angle": (
        lambda: Directions.cone((0, 0, 1)),
        ["half_angle missing", "write Directions.cone(half_angle=...)"],
    ),
    "cone unknown": (
        lambda: Directions.cone((0, 0, 1), halfangle=1),
        ["halfangle=1", "did you mean 'half_angle'?"],
    ),
    "cone too many": (lambda: Directions.cone((0, 0, 1), 1, 2), ["got 2", "write Directions.cone(axis=..."]),
    "cone axis": (lambda: Directions.cone((0, 0, 0), 1), ["DirectionCone: axis", "(0, 0, 0)"]),
    "no positions": (lambda: Positions(), ["Positions", "u, v", "none"]),
    "positions count": (lambda: Positions(u=-1), ["Positions: u", "got -1"]),
    "positions box": (lambda: Positions(u=2).edges(CUBE), ["Positions", "Box", "faces()"]),
    "positions point": (lambda: Positions(u=2).edges(Point()), ["Positions", "Point("]),
    "positions beyond": (
        lambda: Detector(SHEET, name="lid", positions=Positions(v=(0, 3))),
        ["Detector 'lid'", "Positions: v", "[-2.0, 2.0]", "(0.0, 3.0)"],
    ),
    "positions hole": (
        lambda: Positions(u=(0, 1)).edges(Disk(radius=1, inner_radius=0.5)),
        ["Positions: u", "[0.5, 1.0]", "(0.0, 1.0)"],
    ),
    # clocks, speeds and histories of detectors
    "meter cloud": (lambda: Detector(Cloud(sigma=1), name="lid"), ["Detector 'lid': shape", "Cloud("]),
    "times count": (lambda: meter(times=0), ["Detector 'lid': times", "a number of bins", "got 0"]),
    "times float": (lambda: meter(times=2.5), ["Detector 'lid': times", "got 2.5"]),
    "times order": (lambda: meter(times=(0, 2, 1)), ["Detector 'lid': times", "increasing", "(0, 2, 1)"]),
    "times before 0": (lambda: meter(times=(-1, 2)), ["Detector 'lid': times", "0 or above", "(-1, 2)"]),
    "times after the end": (
        lambda: Scene(LAMP, (), meter(times=(0, 3)), duration=2),
        ["Detector 'lid': times edges", "[0.0, 2.0]", "duration", "(0.0, 3.0)"],
    ),
    "times without a clock": (
        lambda: Scene(LAMP, (), meter(times=4)),
        ["Detector 'lid': times need a clock", "got 4", "Scene(..., duration=...)"],
    ),
    "speeds count": (lambda: meter(speeds=4), ["Detector 'lid': speeds", "edges", "got 4", "linspace"]),
    "speeds below 0": (lambda: meter(speeds=(-1, 1)), ["Detector 'lid': speeds", "0 or above", "(-1, 1)"]),
    "speeds infinite": (lambda: meter(speeds=(0, math.inf)), ["Detector 'lid': speeds", "finite", "inf"]),
    "via type": (lambda: meter(via=3), ["Detector 'lid': via", "name", "got 3", "via='pinhole'"]),
    "via empty": (lambda: meter(via=()), ["Detector 'lid': via", "got ()"]),
    "via blank": (lambda: meter(via=("a", " ")), ["Detector 'lid': via", "('a', ' ')"]),
    "via twice": (lambda: meter(via=("a", "a")), ["Detector 'lid': via", "once", "('a', 'a')"]),
    "via unknown": (
        lambda: Scene(LAMP, WALL, meter(via="flor")),
        ["Detector 'lid': via must name a detector or a surface", "got 'flor'", "did you mean 'floor'?"],
    ),
    "events type": (lambda: meter(events=1.0), ["Detector 'lid': events", "reflections", "got 1.0"]),
    "events bool": (lambda: meter(events=True), ["Detector 'lid': events", "True"]),
    "events below 0": (lambda: meter(events=-1), ["Detector 'lid': events", "got -1"]),
    "events order": (lambda: meter(events=(2, 1)), ["Detector 'lid': events", "(least, most)", "(2, 1)"]),
    "events three": (lambda: meter(events=(0, 1, 2)), ["Detector 'lid': events", "(0, 1, 2)", "math.inf"]),
    "events nan": (lambda: meter(events=(0, math.nan)), ["Detector 'lid': events", "nan"]),
    "moments": (lambda: meter(moments="all"), ["Detector 'lid': moments", "True or False", "'all'"]),
}


@pytest.mark.parametrize(("make", "words"), REFUSALS.values(), ids=REFUSALS)
def test_a_wrong_detector_is_refused_with_object_parameter_value_and_cure(make, words):
    assert_refused(make, words)
