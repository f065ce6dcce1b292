"""Boxes of media at their edges and corners, and two side by side.

Each scene has an exact value; its ledger closes and nothing is lost.  Runs have seed 1; each judgement fails right code in
one of 10^5 seeds.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.hard.media_at_limits import DARK, FALSE_ALARM, FORCED, absorbed, beam, body, fog, run


def _chord(low, high, start, way):
    """How far a ray flies in a box; along a face it is inside."""
    with np.errstate(divide="ignore", invalid="ignore"):
        near, far = (low - start) / way, (high - start) / way
    first = np.where(way != 0, np.minimum(near, far), -np.inf).max()
    last = np.where(way != 0, np.maximum(near, far), np.inf).min()
    return max(0.0, last - max(first, 0.0))


@pytest.mark.parametrize("number", range(12))
def test_beams_through_edges_and_corners_are_absorbed_by_their_chord(number):
    """Twenty beams aimed at exact points of edges, twenty at corners, from within and from outside; no coordinate is round."""
    random = np.random.default_rng(number)
    size = random.uniform(0.3, 2, 3) if number % 3 else random.choice([0.5, 1, 2], 3)
    center = random.normal(size=3) * random.choice([0, 1, 1000])
    low, high = center - size / 2, center + size / 2
    sources, exact = [], 0.0
    for k in range(40):
        side = random.choice([-1.0, 1.0], 3)
        if k % 2:
            side[random.integers(3)] = random.choice([0, 0.5, random.uniform(-1, 1)])
        target = center + side * size / 2
        start = (
            center + random.uniform(-0.45, 0.45, 3) * size if k < 16 else target + 2 * random.normal(size=3)
        )
        if k >= 32:  # along a diagonal
            start = target + random.choice([-1, 1], 3) * size
        way = (target - start) / np.linalg.norm(target - start)
        sources.append(beam(start, way))
        exact -= math.expm1(-_chord(low, high, start, way))
    box = tp.Box(center=tuple(center), size=tuple(size))
    found = absorbed(tp.Scene(sources, body(box, DARK), ()))
    assert found == pytest.approx(exact, abs=1e-6)
    assert found != pytest.approx(exact + 0.01, abs=1e-6)


HALVES = [tp.Box(center=(x, 0, 0), size=1.0) for x in (-0.5, 0.5)]
WHOLE = tp.Box(size=(2, 1, 1))
RAYS = {  # start, direction, way within
    "across the shared face": ((3, 0.1, 0.2), (-1, 0, 0), 2.0),
    "in the shared face": ((0, 0, 2), (0, 0, -1), 1.0),
    "in it, aslant": ((0, 2, 2), (0, -1, -1), math.sqrt(2)),
    "through its edge": ((1, 0.1, 1), (-1, 0, -0.5), 0.5 * math.sqrt(5)),
    "through its corner": ((1, 1.5, 1.5), (-1, -1, -1), math.sqrt(3)),
    "along a diagonal": ((2, 2, 2), (-1, -1, -1), math.sqrt(3)),
    "into the far corner": ((3, 1.5, 1.5), (-2, -1, -1), math.sqrt(6)),
}


@pytest.mark.parametrize("ray", RAYS)
@pytest.mark.parametrize("kind", ["one box", "two boxes", "a box in another", "two in one"])
def test_two_boxes_side_by_side_are_one(ray, kind):
    """Nested boxes share faces, or two fill a third; their media differ by the last digit."""
    start, way, chord = RAYS[ray]
    other = tp.Medium(absorption=1.0 + 2.0**-52)
    surfaces = {
        "one box": [body(WHOLE, DARK)],
        "two boxes": [body(HALVES[0], DARK), body(HALVES[1], other)],
        "a box in another": [body(WHOLE, DARK), body(HALVES[1], other)],
        "two in one": [body(WHOLE, tp.Medium(absorption=7.0)), body(HALVES[0], DARK), body(HALVES[1], other)],
    }[kind]
    scene = tp.Scene(beam(start, np.array(way) / np.linalg.norm(way)), surfaces, ())
    assert absorbed(scene) == pytest.approx(-math.expm1(-chord), abs=1e-12)  # of 1 W


@pytest.mark.parametrize("tracking", [None, "analog", FORCED])
@pytest.mark.parametrize(
    "place", [(0.0, 0.0), (0.0, 0.5), (0.3, 0.2)], ids=["shared face", "its edge", "within"]
)
def test_light_that_scatters_in_a_shared_face_is_lost_to_neither_box(place, tracking):
    """A beam down the very face between two boxes, and between one and a twin within a larger one: as in one box."""
    mist, other = fog(2.0, 0.9, 0.5), fog(2.0, 0.9, 0.5 * (1 + 1e-12))
    small = 1e-9  # beside the outermost face, where only what is within counts
    lamp = beam((place[0], place[1] - (small if place[1] else 0), 2), (0, 0, -1))
    found = []
    for surfaces in (
        [body(WHOLE, mist)],
        [body(HALVES[0], mist), body(HALVES[1], other)],
        [body(WHOLE, mist), body(HALVES[1], other)],
    ):
        result = run(tp.Scene(lamp, surfaces, ()), tracking)
        found.append(result.ledger["escaped"])
    for one in found[1:]:
        assert_agrees(one - found[0], 0.0, FALSE_ALARM)
